/* gpu_plan: rows of images and buffers: what is wrong with them, and the sizes that they mean. */
#include "gpu/gpu_plan_internal.h"

#include <math.h>
#include <string.h>

/* A side of the picture times scale, rounded up; 0: more than STILB_GPU_MAX_SIDE. */
static uint32_t scaled(uint32_t side, float scale)
{
	double texels = ceil((double)side * (double)scale);
	if (texels > STILB_GPU_MAX_SIDE)
		return 0;
	return texels < 1 ? 1 : (uint32_t)texels;
}

static stilb_result check_size(gpu_resource *resource, const uint32_t picture[2])
{
	const stilb_gpu_plan_image_row *row = &resource->image;
	stilb_gpu_extent *extent = &resource->extent;
	const char *name = resource->name;
	if (!isfinite(row->scale) || row->scale < 0)
		return stilb_fail(STILB_ERROR_ARGUMENT, "image '%s' has the scale %g: give a share of the picture's size, or 0",
		                  name, (double)row->scale);
	if (row->scale > 0 && (row->width > 0 || row->height > 0))
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "image '%s' has a scale, %g, and a size, %u x %u: only one of both counts", name,
		                  (double)row->scale, row->width, row->height);
	if (!(row->scale > 0) && row->width == 0)
		return stilb_fail(STILB_ERROR_ARGUMENT, "image '%s' has no size: give a scale, or a width in texels", name);
	if (row->scale > 0) {
		extent->width = scaled(picture[0], row->scale);
		extent->height = row->shape == STILB_GPU_SHAPE_1D ? 1 : scaled(picture[1], row->scale);
	} else {
		extent->width = row->width;
		extent->height = row->height > 0 ? row->height : 1;
	}
	extent->depth = row->depth > 0 ? row->depth : 1;
	if (extent->width == 0 || extent->height == 0)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "image '%s' is %g times a picture of %u x %u: a side has at most %u texels", name,
		                  (double)row->scale, picture[0], picture[1], STILB_GPU_MAX_SIDE);
	if (extent->width > STILB_GPU_MAX_SIDE || extent->height > STILB_GPU_MAX_SIDE || extent->depth > STILB_GPU_MAX_SIDE)
		return stilb_fail(STILB_ERROR_ARGUMENT, "image '%s' is %u x %u x %u: a side has at most %u texels", name,
		                  extent->width, extent->height, extent->depth, STILB_GPU_MAX_SIDE);
	return STILB_OK;
}

static stilb_result check_shape(gpu_resource *resource)
{
	stilb_gpu_extent *extent = &resource->extent;
	const char *name = resource->name;
	extent->layers = resource->image.layers;
	if (extent->layers == 0)
		extent->layers = extent->shape == STILB_GPU_SHAPE_CUBE ? 6 : 1;
	if (extent->layers > STILB_GPU_MAX_LAYERS)
		return stilb_fail(STILB_ERROR_ARGUMENT, "image '%s' has %u layers: %u are the most", name, extent->layers,
		                  STILB_GPU_MAX_LAYERS);
	switch (extent->shape) {
	case STILB_GPU_SHAPE_1D:
		if (extent->height > 1)
			return stilb_fail(STILB_ERROR_ARGUMENT, "image '%s' is 1-D and %u texels high: its height is 1", name,
			                  extent->height);
		break;
	case STILB_GPU_SHAPE_CUBE:
		if (extent->width != extent->height)
			return stilb_fail(STILB_ERROR_ARGUMENT, "image '%s' is a cube of %u x %u texels: a cube's sides are equal",
			                  name, extent->width, extent->height);
		if (extent->layers % 6 != 0)
			return stilb_fail(STILB_ERROR_ARGUMENT, "image '%s' is a cube of %u layers: give a multiple of six", name,
			                  extent->layers);
		break;
	case STILB_GPU_SHAPE_3D:
		if (extent->layers > 1)
			return stilb_fail(STILB_ERROR_ARGUMENT, "image '%s' is 3-D with %u layers: its slices are its depth", name,
			                  extent->layers);
		break;
	case STILB_GPU_SHAPE_2D:
		break;
	}
	if (extent->depth > 1 && extent->shape != STILB_GPU_SHAPE_3D)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "image '%s' has the depth %u and is not 3-D: give layers, or the shape 3-D", name,
		                  extent->depth);
	return STILB_OK;
}

static stilb_result check_mips(gpu_resource *resource)
{
	stilb_gpu_extent *extent = &resource->extent;
	uint32_t side = extent->width > extent->height ? extent->width : extent->height;
	side = side > extent->depth ? side : extent->depth;
	uint32_t most = 32u - (uint32_t)__builtin_clz(side);
	uint16_t mips = resource->image.mips;
	if (mips != STILB_GPU_ALL && mips > most)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "image '%s' has %u mips: one of %u x %u x %u has at most %u (STILB_GPU_ALL)", resource->name,
		                  mips, extent->width, extent->height, extent->depth, most);
	extent->mips = (uint16_t)(mips == STILB_GPU_ALL ? most : mips == 0 ? 1 : mips);
	return STILB_OK;
}

static stilb_result check_samples(gpu_resource *resource)
{
	stilb_gpu_extent *extent = &resource->extent;
	uint8_t samples = resource->image.samples;
	extent->samples = samples == 0 ? 1 : samples;
	if (extent->samples != 1 && extent->samples != 2 && extent->samples != 4 && extent->samples != 8)
		return stilb_fail(STILB_ERROR_ARGUMENT, "image '%s' has %u samples a texel: give 1, 2, 4 or 8", resource->name,
		                  samples);
	if (extent->samples > 1 && (extent->shape != STILB_GPU_SHAPE_2D || extent->mips > 1))
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "image '%s' has %u samples a texel: such images are 2-D and have one mip", resource->name,
		                  extent->samples);
	return STILB_OK;
}

static stilb_result check_format(gpu_resource *resource)
{
	const stilb_gpu_extent *extent = &resource->extent;
	if (extent->format == STILB_GPU_NONE || extent->format >= STILB_GPU_FORMAT_COUNT)
		return stilb_fail(STILB_ERROR_ARGUMENT, "image '%s' has no format: %u is none of stilb_gpu_format",
		                  resource->name, (unsigned)extent->format);
	if (extent->shape > STILB_GPU_SHAPE_1D)
		return stilb_fail(STILB_ERROR_ARGUMENT, "image '%s' has the shape %u: it is none of stilb_gpu_shape",
		                  resource->name, (unsigned)extent->shape);
	const stilb_gpu_format_info *info = stilb_gpu_format_describe(extent->format);
	bool flat = extent->shape == STILB_GPU_SHAPE_2D || extent->shape == STILB_GPU_SHAPE_CUBE;
	if (!flat && (info->block_side > 1 || info->kind == STILB_GPU_FORMAT_DEPTH))
		return stilb_fail(STILB_ERROR_ARGUMENT, "image '%s' has the format %s, which only 2-D images and cubes have",
		                  resource->name, info->name);
	if (info->block_side > 1 && resource->image.samples > 1)
		return stilb_fail(STILB_ERROR_ARGUMENT, "image '%s' has the format %s, which has one sample a texel, not %u",
		                  resource->name, info->name, resource->image.samples);
	return STILB_OK;
}

static stilb_result check_stay(const gpu_resource *resource)
{
	if (resource->image.owned != 0 && resource->image.keep)
		return stilb_fail(STILB_ERROR_ARGUMENT, "%s '%s' is owned and kept: what is owned stays anyway, leave keep out",
		                  gpu_resource_word(resource), resource->name);
	return STILB_OK;
}

stilb_result gpu_resource_check_image(gpu_resource *resource, const uint32_t picture[2])
{
	stilb_gpu_extent *extent = &resource->extent;
	*extent = (stilb_gpu_extent){.format = resource->image.format, .shape = resource->image.shape};
	stilb_result result = check_format(resource);
	result = result == STILB_OK ? check_size(resource, picture) : result;
	result = result == STILB_OK ? check_shape(resource) : result;
	result = result == STILB_OK ? check_mips(resource) : result;
	result = result == STILB_OK ? check_samples(resource) : result;
	result = result == STILB_OK ? check_stay(resource) : result;
	if (result != STILB_OK)
		return result;
	resource->bytes = 0;
	for (uint32_t mip = 0; mip < extent->mips; mip++)
		resource->bytes += stilb_gpu_format_bytes(extent->format, gpu_mip_side(extent->width, mip),
		                                          gpu_mip_side(extent->height, mip), gpu_mip_side(extent->depth, mip));
	resource->bytes *= (uint64_t)extent->layers * extent->samples;
	return STILB_OK;
}

stilb_result gpu_resource_check_buffer(gpu_resource *resource)
{
	resource->extent = (stilb_gpu_extent){.format = STILB_GPU_NONE, .mips = 1, .layers = 1};
	if (resource->bytes == 0)
		return stilb_fail(STILB_ERROR_ARGUMENT, "buffer '%s' has no size: give its bytes", resource->name);
	if (resource->bytes > STILB_GPU_MAX_BUFFER)
		return stilb_fail(STILB_ERROR_ARGUMENT, "buffer '%s' has %llu bytes: %llu are the most", resource->name,
		                  (unsigned long long)resource->bytes, (unsigned long long)STILB_GPU_MAX_BUFFER);
	return check_stay(resource);
}
