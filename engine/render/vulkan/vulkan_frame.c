/* One frame on the GPU: its slot, the images that are drawn into, its memory, its submission. */
#include "render/vulkan/vulkan_internal.h"

#include <stdio.h>
#include <string.h>

/* ---- slots ------------------------------------------------------------------------------------------------------- */

stilb_result vulkan_frames_create(vulkan_device *device)
{
	VkResult error = vulkan_material_sets_create(device);
	if (error != VK_SUCCESS)
		return gpu_vulkan_fail(device->gpu, error, "make the sets of materials");
	stilb_result result = STILB_OK;
	for (uint32_t i = 0; i < STILB_GPU_FRAMES && result == STILB_OK; i++)
		result =
			gpu_vulkan_buffer_create(device->gpu, STILB_RENDER_MAX_PASSES * sizeof(vulkan_view),
		                             VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
		                             STILB_GPU_MEMORY_WRITE, &device->slots[i].views);
	return result;
}

void vulkan_frames_destroy(vulkan_device *device)
{
	for (uint32_t i = 0; i < STILB_GPU_FRAMES; i++) {
		vulkan_slot *slot = &device->slots[i];
		for (int kind = 0; kind < RENDER_MEMORY_KINDS; kind++)
			gpu_vulkan_buffer_destroy(device->gpu, &slot->memory[kind]);
		vulkan_secondary_destroy(device, slot);
		vulkan_heaps_destroy_slot(device, slot);
		gpu_vulkan_buffer_destroy(device->gpu, &slot->backdrop);
		gpu_vulkan_buffer_destroy(device->gpu, &slot->views);
		gpu_vulkan_buffer_destroy(device->gpu, &slot->picture);
	}
	gpu_vulkan_buffer_destroy(device->gpu, &device->panorama);
	gpu_vulkan_buffer_destroy(device->gpu, &device->next_panorama);
	vkDestroyDescriptorPool(device->gpu->device, device->material_pool,
	                        device->gpu->allocator); /* frees the slots' sets too */
}

/* ---- targets ----------------------------------------------------------------------------------------------------- */

/* Checks the GPU's limits: creating an image beyond them is undefined behaviour, not an error. */
static stilb_result target_check(const vulkan_device *device, const VkImageCreateInfo *info)
{
	VkImageFormatProperties can;
	uint32_t width = info->extent.width, height = info->extent.height;
	VkResult result = vkGetPhysicalDeviceImageFormatProperties(device->gpu->physical, info->format, info->imageType,
	                                                           info->tiling, info->usage, info->flags, &can);
	if (result != VK_SUCCESS)
		return gpu_vulkan_fail(device->gpu, result, "draw in the picture's format on this GPU");
	if (!(can.sampleCounts & info->samples))
		return stilb_fail(STILB_ERROR_DEVICE, "GPU '%s' has no %u samples per pixel; use --msaa 1",
		                  device->gpu->base.name, (unsigned)info->samples);
	const VkPhysicalDeviceLimits *limits = &device->gpu->properties.limits;
	uint32_t most_width = can.maxExtent.width, most_height = can.maxExtent.height;
	most_width = most_width < limits->maxFramebufferWidth ? most_width : limits->maxFramebufferWidth;
	most_height = most_height < limits->maxFramebufferHeight ? most_height : limits->maxFramebufferHeight;
	if (width > most_width || height > most_height)
		return stilb_fail(STILB_ERROR_DEVICE, "GPU '%s' draws pictures of up to %ux%u, not %ux%u; use a smaller --size",
		                  device->gpu->base.name, most_width, most_height, width, height);
	return STILB_OK;
}

static stilb_result target_create(vulkan_device *device, VkFormat format, VkSampleCountFlagBits samples,
                                  VkImageUsageFlags usage, VkImageAspectFlags aspect, gpu_vulkan_image *image)
{
	VkImageCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
		.imageType = VK_IMAGE_TYPE_2D,
		.format = format,
		.extent = {device->base.width, device->base.height, 1},
		.mipLevels = 1,
		.arrayLayers = 1,
		.samples = samples,
		.tiling = VK_IMAGE_TILING_OPTIMAL,
		.usage = usage,
		.initialLayout = VK_IMAGE_LAYOUT_UNDEFINED,
	};
	stilb_result possible = target_check(device, &info);
	if (possible != STILB_OK)
		return possible;
	VkResult result = gpu_vulkan_image_create(device->gpu, &info, aspect, image);
	if (result == VK_SUCCESS)
		return STILB_OK;
	char what[96];
	snprintf(what, sizeof what, "make a picture of %ux%u with %u samples", device->base.width, device->base.height,
	         (unsigned)samples);
	return gpu_vulkan_fail(device->gpu, result, what);
}

stilb_result vulkan_targets_create(vulkan_device *device)
{
	VkSampleCountFlagBits samples = (VkSampleCountFlagBits)device->base.samples;
	stilb_result result = target_create(device, device->color_format, VK_SAMPLE_COUNT_1_BIT,
	                                    VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
	                                    VK_IMAGE_ASPECT_COLOR_BIT, &device->color);
	VkImageUsageFlags light = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
	if (result == STILB_OK)
		result = target_create(device, VULKAN_LIGHT_FORMAT, VK_SAMPLE_COUNT_1_BIT,
		                       light | VK_IMAGE_USAGE_TRANSFER_SRC_BIT, VK_IMAGE_ASPECT_COLOR_BIT, &device->light);
	if (result == STILB_OK && samples > 1)
		result = target_create(device, VULKAN_LIGHT_FORMAT, samples, light, VK_IMAGE_ASPECT_COLOR_BIT,
		                       &device->light_samples);
	if (result == STILB_OK)
		result = target_create(device, VK_FORMAT_D32_SFLOAT, samples, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT,
		                       VK_IMAGE_ASPECT_DEPTH_BIT, &device->depth);
	if (result == STILB_OK)
		vulkan_tone_targets(device);
	return result;
}

void vulkan_targets_destroy(vulkan_device *device)
{
	gpu_vulkan_image_destroy(device->gpu, &device->color);
	gpu_vulkan_image_destroy(device->gpu, &device->light);
	gpu_vulkan_image_destroy(device->gpu, &device->light_samples);
	gpu_vulkan_image_destroy(device->gpu, &device->depth);
}

/* ---- begin ------------------------------------------------------------------------------------------------------- */

stilb_result vulkan_frame_begin(render_device *base, render_memory *memory)
{
	vulkan_device *device = (vulkan_device *)base;
	if (!device->color.image)
		return stilb_fail(STILB_ERROR_MEMORY, "there is no picture to draw into; choose a smaller size");
	device->tone.wanted = device->tone.lit = false;
	STILB_ASSERT(memory);
	device->pass = 0;
	stilb_result result = gpu_vulkan_slot_take(device->gpu);
	if (result != STILB_OK)
		return result;
	base->stats.gpu_ms = device->gpu->base.gpu_ms;
	vulkan_slot *slot = vulkan_slot_now(device);
	slot->picture_valid = false;
	for (uint32_t l = 0; l < slot->list_count; l++)
		slot->lists[l].used = 0;
	vulkan_heaps_frame(device, slot);
	result = gpu_vulkan_slot_begin(device->gpu, STILB_RENDER_MAX_PASSES);
	for (int kind = 0; kind < RENDER_MEMORY_KINDS && result == STILB_OK; kind++) {
		gpu_vulkan_buffer *buffer = &slot->memory[kind];
		memory[kind].data = buffer->mapped;
		memory[kind].capacity = (uint32_t)(buffer->size / memory[kind].element);
		if (!buffer->buffer && memory[kind].first_capacity > 0)
			result = vulkan_grow(base, &memory[kind], (render_memory_kind)kind, memory[kind].first_capacity, 0);
	}
	return result;
}

/* Rows and geometry are written once and read by the GPU. The CPU reads commands again when it sorts them or replays
 * them one by one, so they lie in memory that it caches; the GPU reads only 20 bytes of each. */
static const struct {
	VkBufferUsageFlags usage;
	stilb_gpu_memory memory;
} frame_memory[RENDER_MEMORY_KINDS] = {
	[RENDER_MEMORY_COMMANDS] = {VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT, STILB_GPU_MEMORY_SHARED},
	[RENDER_MEMORY_ROWS] = {VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
                            STILB_GPU_MEMORY_WRITE},
	[RENDER_MEMORY_VERTICES_2D] = {VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, STILB_GPU_MEMORY_WRITE},
	[RENDER_MEMORY_INDICES_2D] = {VK_BUFFER_USAGE_INDEX_BUFFER_BIT, STILB_GPU_MEMORY_WRITE},
	[RENDER_MEMORY_LIGHTS] = {VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
                              STILB_GPU_MEMORY_WRITE},
};

stilb_result vulkan_grow(render_device *base, render_memory *memory, render_memory_kind kind, uint32_t capacity,
                         uint32_t keep)
{
	vulkan_device *device = (vulkan_device *)base;
	gpu_vulkan_buffer *buffer = &vulkan_slot_now(device)->memory[kind], grown;
	STILB_ASSERT(capacity > 0 && keep <= capacity && (VkDeviceSize)keep * memory->element <= buffer->size);
	stilb_result result = gpu_vulkan_buffer_create(device->gpu, (VkDeviceSize)capacity * memory->element,
	                                               frame_memory[kind].usage, frame_memory[kind].memory, &grown);
	if (result != STILB_OK)
		return result;
	if (keep > 0)
		memcpy(grown.mapped, buffer->mapped, (size_t)keep * memory->element);
	result = vulkan_buffer_replace(device, buffer, grown); /* replayed passes may read the old one */
	if (result != STILB_OK)
		return result;
	memory->data = grown.mapped;
	memory->capacity = capacity;
	return STILB_OK;
}

/* Like a frame's rows the CPU writes them once, mostly, and the GPU reads them where they are. */
stilb_result vulkan_rows_make(render_device *base, uint32_t capacity, render_rows **out)
{
	vulkan_device *device = (vulkan_device *)base;
	vulkan_rows *rows = calloc(1, sizeof *rows);
	if (!rows)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a table of rows");
	stilb_result result = gpu_vulkan_buffer_create(device->gpu, (VkDeviceSize)capacity * sizeof(render_row),
	                                               frame_memory[RENDER_MEMORY_ROWS].usage,
	                                               frame_memory[RENDER_MEMORY_ROWS].memory, &rows->buffer);
	if (result != STILB_OK) {
		free(rows);
		return result;
	}
	rows->base = (render_rows){.data = rows->buffer.mapped, .capacity = capacity};
	*out = &rows->base;
	return STILB_OK;
}

void vulkan_rows_free(render_device *base, render_rows *rows)
{
	vulkan_rows *own = (vulkan_rows *)rows;
	gpu_vulkan_buffer_destroy(((vulkan_device *)base)->gpu, &own->buffer);
	free(own);
}

/* ---- submission -------------------------------------------------------------------------------------------------- */

stilb_result vulkan_submit(render_device *base)
{
	PROFILE("submit");
	vulkan_device *device = (vulkan_device *)base;
	vulkan_slot *slot = vulkan_slot_now(device);
	if (gpu_fault_lost(base->gpu))
		return gpu_vulkan_fail(device->gpu, VK_ERROR_DEVICE_LOST, "give the GPU a frame");
	vulkan_tone_pass(device, slot->gpu->draw);
	gpu_vulkan_image_barrier(slot->gpu->draw, device->color.image, VK_IMAGE_ASPECT_COLOR_BIT,
	                         VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
	                         VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT, VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT,
	                         VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_READ_BIT);
	stilb_result submitted = gpu_vulkan_slot_submit(device->gpu);
	device->drawn |= submitted == STILB_OK;
	return submitted;
}

stilb_result vulkan_wait(render_device *base)
{
	vulkan_device *device = (vulkan_device *)base;
	stilb_result result = gpu_vulkan_wait(device->gpu);
	base->stats.gpu_ms = device->gpu->base.gpu_ms;
	return result;
}

/* ---- panoramas --------------------------------------------------------------------------------------------------- */

void *vulkan_panorama_make(render_device *base, size_t bytes)
{
	vulkan_device *device = (vulkan_device *)base;
	if (device->next_panorama.size != bytes) {
		gpu_vulkan_buffer_destroy(device->gpu, &device->next_panorama); /* no frame has read it */
		gpu_vulkan_buffer_create(device->gpu, bytes,
		                         VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
		                         STILB_GPU_MEMORY_WRITE, &device->next_panorama);
	}
	return device->next_panorama.mapped;
}

void vulkan_panorama_show(render_device *base)
{
	vulkan_device *device = (vulkan_device *)base;
	STILB_ASSERT(device->next_panorama.buffer);
	if (device->panorama.buffer && vulkan_buffer_retire(device, &device->panorama) != STILB_OK) {
		gpu_vulkan_timeline_wait(device->gpu, device->gpu->timeline_value);
		gpu_vulkan_buffer_destroy(device->gpu, &device->panorama);
	}
	device->panorama = device->next_panorama;
	device->next_panorama = (gpu_vulkan_buffer){0};
}
