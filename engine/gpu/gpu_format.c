/* gpu: the table of formats. */
#include "gpu/gpu_format.h"

static const stilb_gpu_format_info formats[STILB_GPU_FORMAT_COUNT] = {
#define GPU_FORMAT_INFO(id, text, bytes, side, what)                                                                   \
	[STILB_GPU_##id] = {.name = (text), .block_bytes = (bytes), .block_side = (side), .kind = STILB_GPU_FORMAT_##what},
	STILB_GPU_FORMATS(GPU_FORMAT_INFO)
#undef GPU_FORMAT_INFO
};

const stilb_gpu_format_info *stilb_gpu_format_describe(stilb_gpu_format format)
{
	STILB_ASSERT(format < STILB_GPU_FORMAT_COUNT);
	return &formats[format];
}

uint64_t stilb_gpu_format_bytes(stilb_gpu_format format, uint32_t width, uint32_t height, uint32_t depth)
{
	const stilb_gpu_format_info *info = stilb_gpu_format_describe(format);
	uint64_t side = info->block_side;
	return (width + side - 1) / side * ((height + side - 1) / side) * depth * info->block_bytes;
}
