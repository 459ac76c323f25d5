/* gpu: the choice of a device. */
#include "gpu/gpu_internal.h"

stilb_result stilb_gpu_create(const stilb_gpu_desc *desc, stilb_gpu **gpu)
{
	STILB_ASSERT(desc && gpu && (uint32_t)desc->kind <= STILB_GPU_KIND_NULL);
	*gpu = NULL;
	return desc->kind == STILB_GPU_KIND_NULL ? gpu_null_create(desc, gpu) : gpu_vulkan_open(desc, gpu);
}
