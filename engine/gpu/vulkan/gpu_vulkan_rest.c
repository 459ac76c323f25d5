/* First layouts of images: which have none yet, and what happens if the commands that gave them one do not run. */
#include "gpu/vulkan/gpu_vulkan_internal.h"

#include <stdlib.h>

void gpu_vulkan_rest_begin(gpu_vulkan *gpu)
{
	gpu->resting++;
}

/* Makes room for one image more. The caller holds the device's lock. */
static bool fresh_reserve(gpu_vulkan *gpu)
{
	if (gpu->fresh_count < gpu->fresh_capacity)
		return true;
	uint32_t larger = gpu->fresh_capacity ? 2 * gpu->fresh_capacity : 16;
	gpu_image **grown = realloc(gpu->fresh, larger * sizeof(*grown));
	if (!grown)
		return false;
	gpu->fresh = grown;
	gpu->fresh_capacity = larger;
	return true;
}

stilb_result gpu_vulkan_rest_add(gpu_vulkan *gpu, gpu_image *image)
{
	stilb_lock_take(&gpu->base.lock);
	bool reserved = fresh_reserve(gpu);
	if (reserved)
		gpu->fresh[gpu->fresh_count++] = image;
	stilb_lock_give(&gpu->base.lock);
	return reserved ? STILB_OK : stilb_fail(STILB_ERROR_MEMORY, "no memory for the state of image '%s'", image->name);
}

void gpu_vulkan_rest_undo(gpu_vulkan *gpu)
{
	const gpu_table *images = &gpu->base.tables[GPU_IMAGE];
	stilb_lock_take(&gpu->base.lock);
	for (uint32_t i = 0; i < images->count; i++) {
		gpu_image *image = gpu_table_at(images, i);
		gpu_vulkan_texels *texels = image ? image->own : NULL;
		if (!texels || texels->rested != gpu->resting)
			continue;
		memset(image->layouts, STILB_GPU_LAYOUT_NONE, (size_t)image->extent.layers * image->extent.mips);
		texels->rested = 0;
		if (fresh_reserve(gpu)) /* else the next upload gives it one */
			gpu->fresh[gpu->fresh_count++] = image;
	}
	stilb_lock_give(&gpu->base.lock);
	if (gpu->white_rested == gpu->resting)
		gpu->white_rested = 0;
}
