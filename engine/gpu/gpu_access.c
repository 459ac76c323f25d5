/* gpu: what is known of each way in which the device touches memory. */
#include "gpu/gpu_plan.h"

typedef struct access_info {
	const char *name;
	stilb_gpu_layout layout;
	bool writes;
} access_info;

static const access_info accesses[STILB_GPU_ACCESSES] = {
	[STILB_GPU_ACCESS_NONE] = {"none", STILB_GPU_LAYOUT_NONE, false},
	[STILB_GPU_ACCESS_COLOR] = {"color", STILB_GPU_LAYOUT_COLOR, true},
	[STILB_GPU_ACCESS_DEPTH] = {"depth", STILB_GPU_LAYOUT_DEPTH, true},
	[STILB_GPU_ACCESS_DEPTH_READ] = {"depth_read", STILB_GPU_LAYOUT_DEPTH_READ, false},
	[STILB_GPU_ACCESS_RESOLVE] = {"resolve", STILB_GPU_LAYOUT_COLOR, true},
	[STILB_GPU_ACCESS_SAMPLED_FRAGMENT] = {"sampled_fragment", STILB_GPU_LAYOUT_SAMPLED, false},
	[STILB_GPU_ACCESS_SAMPLED_COMPUTE] = {"sampled_compute", STILB_GPU_LAYOUT_SAMPLED, false},
	[STILB_GPU_ACCESS_STORAGE_READ_GRAPHICS] = {"storage_read_graphics", STILB_GPU_LAYOUT_STORAGE, false},
	[STILB_GPU_ACCESS_STORAGE_READ_COMPUTE] = {"storage_read_compute", STILB_GPU_LAYOUT_STORAGE, false},
	[STILB_GPU_ACCESS_STORAGE_GRAPHICS] = {"storage_graphics", STILB_GPU_LAYOUT_STORAGE, true},
	[STILB_GPU_ACCESS_STORAGE_COMPUTE] = {"storage_compute", STILB_GPU_LAYOUT_STORAGE, true},
	[STILB_GPU_ACCESS_VERTICES] = {"vertices", STILB_GPU_LAYOUT_NONE, false},
	[STILB_GPU_ACCESS_INDIRECT] = {"indirect", STILB_GPU_LAYOUT_NONE, false},
	[STILB_GPU_ACCESS_COPY_FROM] = {"copy_from", STILB_GPU_LAYOUT_COPY_FROM, false},
	[STILB_GPU_ACCESS_COPY_TO] = {"copy_to", STILB_GPU_LAYOUT_COPY_TO, true},
	[STILB_GPU_ACCESS_HOST] = {"host", STILB_GPU_LAYOUT_NONE, true},
	[STILB_GPU_ACCESS_OUTPUT] = {"output", STILB_GPU_LAYOUT_COPY_FROM, false},
};

stilb_gpu_layout stilb_gpu_access_layout(stilb_gpu_access access, stilb_gpu_format_kind kind)
{
	STILB_ASSERT(access < STILB_GPU_ACCESSES);
	stilb_gpu_layout layout = accesses[access].layout;
	return layout == STILB_GPU_LAYOUT_SAMPLED && kind == STILB_GPU_FORMAT_DEPTH ? STILB_GPU_LAYOUT_DEPTH_READ : layout;
}

bool stilb_gpu_access_writes(stilb_gpu_access access)
{
	STILB_ASSERT(access < STILB_GPU_ACCESSES);
	return accesses[access].writes;
}

const char *stilb_gpu_access_name(stilb_gpu_access access)
{
	STILB_ASSERT(access < STILB_GPU_ACCESSES);
	return accesses[access].name;
}
