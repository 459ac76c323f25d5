/* One frame on the GPU: its slot, the images that are drawn into, its memory, its submission. */
#include "render/vulkan/vulkan_internal.h"

#include <stdio.h>
#include <string.h>

/* ---- slots ------------------------------------------------------------------------------------------------------- */

static VkResult slot_create(vulkan_device *device, vulkan_slot *slot)
{
	VkCommandPoolCreateInfo pool = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
		.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT,
		.queueFamilyIndex = device->queue_family,
	};
	VkResult result = vkCreateCommandPool(device->device, &pool, device->allocator, &slot->pool);
	if (result != VK_SUCCESS)
		return result;
	VkCommandBufferAllocateInfo buffers = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
		.commandPool = slot->pool,
		.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
		.commandBufferCount = 1,
	};
	result = vkAllocateCommandBuffers(device->device, &buffers, &slot->draw);
	if (result == VK_SUCCESS)
		result = vkAllocateCommandBuffers(device->device, &buffers, &slot->show);
	VkSemaphoreCreateInfo semaphore = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
	return result == VK_SUCCESS ? vkCreateSemaphore(device->device, &semaphore, device->allocator, &slot->acquired)
	                            : result;
}

static VkResult frames_make(vulkan_device *device)
{
	VkSemaphoreTypeCreateInfo type = {
		.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO,
		.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE,
	};
	VkSemaphoreCreateInfo timeline = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, .pNext = &type};
	VkResult result = vkCreateSemaphore(device->device, &timeline, device->allocator, &device->timeline);
	for (int i = 0; i < VULKAN_SLOTS && result == VK_SUCCESS; i++)
		result = slot_create(device, &device->slots[i]);
	return result == VK_SUCCESS ? vulkan_material_sets_create(device) : result;
}

stilb_result vulkan_frames_create(vulkan_device *device)
{
	VkResult error = frames_make(device);
	if (error != VK_SUCCESS)
		return vulkan_fail(device, error, "make command buffers");
	stilb_result result = STILB_OK;
	for (int i = 0; i < VULKAN_SLOTS && result == STILB_OK; i++)
		result = vulkan_buffer_create(device, STILB_RENDER_MAX_PASSES * sizeof(vulkan_view),
		                              VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
		                              VULKAN_MEMORY_WRITE, &device->slots[i].views);
	return result == STILB_OK ? vulkan_times_create(device) : result;
}

void vulkan_frames_destroy(vulkan_device *device)
{
	for (int i = 0; i < VULKAN_SLOTS; i++) {
		vulkan_slot *slot = &device->slots[i];
		vkDestroyCommandPool(device->device, slot->pool, device->allocator);
		vkDestroySemaphore(device->device, slot->acquired, device->allocator);
		for (int kind = 0; kind < RENDER_MEMORY_KINDS; kind++)
			vulkan_buffer_destroy(device, &slot->memory[kind]);
		vulkan_secondary_destroy(device, slot);
		vulkan_heaps_destroy_slot(device, slot);
		vulkan_buffer_destroy(device, &slot->backdrop);
		vulkan_buffer_destroy(device, &slot->views);
		vulkan_buffer_destroy(device, &slot->picture);
	}
	vulkan_buffer_destroy(device, &device->panorama);
	vulkan_buffer_destroy(device, &device->next_panorama);
	vkDestroyDescriptorPool(device->device, device->material_pool, device->allocator); /* frees the slots' sets too */
	vulkan_times_destroy(device);
	vkDestroySemaphore(device->device, device->timeline, device->allocator);
}

/* ---- targets ----------------------------------------------------------------------------------------------------- */

/* Checks the GPU's limits: creating an image beyond them is undefined behaviour, not an error. */
static stilb_result target_check(const vulkan_device *device, const VkImageCreateInfo *info)
{
	VkImageFormatProperties can;
	uint32_t width = info->extent.width, height = info->extent.height;
	VkResult result = vkGetPhysicalDeviceImageFormatProperties(device->gpu, info->format, info->imageType, info->tiling,
	                                                           info->usage, info->flags, &can);
	if (result != VK_SUCCESS)
		return vulkan_fail(device, result, "draw in the picture's format on this GPU");
	if (!(can.sampleCounts & info->samples))
		return stilb_fail(STILB_ERROR_DEVICE, "GPU '%s' has no %u samples per pixel; use --msaa 1", device->base.name,
		                  (unsigned)info->samples);
	const VkPhysicalDeviceLimits *limits = &device->properties.limits;
	uint32_t most_width = can.maxExtent.width, most_height = can.maxExtent.height;
	most_width = most_width < limits->maxFramebufferWidth ? most_width : limits->maxFramebufferWidth;
	most_height = most_height < limits->maxFramebufferHeight ? most_height : limits->maxFramebufferHeight;
	if (width > most_width || height > most_height)
		return stilb_fail(STILB_ERROR_DEVICE, "GPU '%s' draws pictures of up to %ux%u, not %ux%u; use a smaller --size",
		                  device->base.name, most_width, most_height, width, height);
	return STILB_OK;
}

static stilb_result target_create(vulkan_device *device, VkFormat format, VkSampleCountFlagBits samples,
                                  VkImageUsageFlags usage, VkImageAspectFlags aspect, vulkan_image *image)
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
	VkResult result = vulkan_image_create(device, &info, aspect, image);
	if (result == VK_SUCCESS)
		return STILB_OK;
	char what[96];
	snprintf(what, sizeof what, "make a picture of %ux%u with %u samples", device->base.width, device->base.height,
	         (unsigned)samples);
	return vulkan_fail(device, result, what);
}

stilb_result vulkan_targets_create(vulkan_device *device)
{
	VkSampleCountFlagBits samples = (VkSampleCountFlagBits)device->base.samples;
	stilb_result result = target_create(device, device->color_format, VK_SAMPLE_COUNT_1_BIT,
	                                    VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
	                                    VK_IMAGE_ASPECT_COLOR_BIT, &device->color);
	if (result == STILB_OK && samples > 1)
		result = target_create(device, device->color_format, samples, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT,
		                       VK_IMAGE_ASPECT_COLOR_BIT, &device->color_samples);
	if (result == STILB_OK)
		result = target_create(device, VK_FORMAT_D32_SFLOAT, samples, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT,
		                       VK_IMAGE_ASPECT_DEPTH_BIT, &device->depth);
	return result;
}

void vulkan_targets_destroy(vulkan_device *device)
{
	vulkan_image_destroy(device, &device->color);
	vulkan_image_destroy(device, &device->color_samples);
	vulkan_image_destroy(device, &device->depth);
}

/* ---- begin ------------------------------------------------------------------------------------------------------- */

stilb_result vulkan_timeline_wait(vulkan_device *device, uint64_t value)
{
	VkSemaphoreWaitInfo info = {
		.sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO,
		.semaphoreCount = 1,
		.pSemaphores = &device->timeline,
		.pValues = &value,
	};
	STILB_ASSERT(value <= device->timeline_value && "a submission will signal it");
	PROFILE("wait for the GPU");
	VkResult result = vkWaitSemaphores(device->device, &info, UINT64_MAX);
	return result == VK_SUCCESS ? STILB_OK : vulkan_fail(device, result, "wait for the GPU");
}

static stilb_result slot_begin_commands(vulkan_device *device, vulkan_slot *slot)
{
	PROFILE("reset commands"); /* frees the commands of the slot's last frame */
	VkCommandBufferBeginInfo begin = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
		.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT,
	};
	VkResult result = vkResetCommandPool(device->device, slot->pool, 0);
	if (result == VK_SUCCESS)
		result = vkBeginCommandBuffer(slot->draw, &begin);
	if (result != VK_SUCCESS)
		return vulkan_fail(device, result, "begin a frame");
	vulkan_times_begin(device);
	return STILB_OK;
}

stilb_result vulkan_frame_begin(render_device *base, render_memory *memory)
{
	vulkan_device *device = (vulkan_device *)base;
	if (!device->color.image)
		return stilb_fail(STILB_ERROR_MEMORY, "there is no picture to draw into; choose a smaller size");
	device->slot = (device->slot + 1) % VULKAN_SLOTS;
	device->pass = 0;
	vulkan_slot *slot = vulkan_slot_now(device);
	STILB_ASSERT(memory);
	stilb_result result = vulkan_timeline_wait(device, slot->done);
	if (result != STILB_OK)
		return result;
	vulkan_times_read(device, slot);
	slot->picture_valid = false;
	for (uint32_t l = 0; l < slot->list_count; l++)
		slot->lists[l].used = 0;
	vulkan_heaps_frame(device, slot);
	result = slot_begin_commands(device, slot);
	for (int kind = 0; kind < RENDER_MEMORY_KINDS && result == STILB_OK; kind++) {
		vulkan_buffer *buffer = &slot->memory[kind];
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
	vulkan_memory_kind memory;
} frame_memory[RENDER_MEMORY_KINDS] = {
	[RENDER_MEMORY_COMMANDS] = {VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT, VULKAN_MEMORY_SHARED},
	[RENDER_MEMORY_ROWS] = {VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
                            VULKAN_MEMORY_WRITE},
	[RENDER_MEMORY_VERTICES_2D] = {VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, VULKAN_MEMORY_WRITE},
	[RENDER_MEMORY_INDICES_2D] = {VK_BUFFER_USAGE_INDEX_BUFFER_BIT, VULKAN_MEMORY_WRITE},
	[RENDER_MEMORY_LIGHTS] = {VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
                              VULKAN_MEMORY_WRITE},
};

stilb_result vulkan_grow(render_device *base, render_memory *memory, render_memory_kind kind, uint32_t capacity,
                         uint32_t keep)
{
	vulkan_device *device = (vulkan_device *)base;
	vulkan_buffer *buffer = &vulkan_slot_now(device)->memory[kind], grown;
	STILB_ASSERT(capacity > 0 && keep <= capacity && (VkDeviceSize)keep * memory->element <= buffer->size);
	stilb_result result = vulkan_buffer_create(device, (VkDeviceSize)capacity * memory->element,
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

/* ---- barriers ---------------------------------------------------------------------------------------------------- */

/* ---- submission -------------------------------------------------------------------------------------------------- */

stilb_result vulkan_queue_submit(vulkan_device *device, VkCommandBuffer commands, VkSemaphore wait, VkSemaphore signal)
{
	VkCommandBufferSubmitInfo buffer = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
		.commandBuffer = commands,
	};
	VkSemaphoreSubmitInfo waits = {
		.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
		.semaphore = wait,
		.stageMask = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
	};
	VkSemaphoreSubmitInfo signals[2] = {
		{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
	     .semaphore = device->timeline,
	     .value = device->timeline_value + 1,
	     .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT},
		{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
	     .semaphore = signal,
	     .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT},
	};
	VkSubmitInfo2 submit = {
		.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
		.waitSemaphoreInfoCount = wait != VK_NULL_HANDLE,
		.pWaitSemaphoreInfos = &waits,
		.commandBufferInfoCount = 1,
		.pCommandBufferInfos = &buffer,
		.signalSemaphoreInfoCount = signal != VK_NULL_HANDLE ? 2 : 1,
		.pSignalSemaphoreInfos = signals,
	};
	STILB_ASSERT(commands && device->timeline_value < UINT64_MAX);
	VkResult result = vkQueueSubmit2(device->queue, 1, &submit, VK_NULL_HANDLE);
	if (result != VK_SUCCESS)
		return vulkan_fail(device, result, "give the GPU a frame");
	device->timeline_value++;
	return STILB_OK;
}

stilb_result vulkan_submit(render_device *base)
{
	PROFILE("submit");
	vulkan_device *device = (vulkan_device *)base;
	vulkan_slot *slot = vulkan_slot_now(device);
	if (render_fault_lost(base))
		return vulkan_fail(device, VK_ERROR_DEVICE_LOST, "give the GPU a frame");
	vulkan_image_barrier(slot->draw, device->color.image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
	                     VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
	                     VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
	                     VK_ACCESS_2_TRANSFER_READ_BIT);
	vulkan_times_end(device);
	VkResult result = vkEndCommandBuffer(slot->draw);
	if (result != VK_SUCCESS)
		return vulkan_fail(device, result, "record a frame");
	stilb_result submitted = vulkan_queue_submit(device, slot->draw, VK_NULL_HANDLE, VK_NULL_HANDLE);
	slot->done = device->timeline_value;
	vulkan_times_submitted(device, submitted == STILB_OK);
	device->drawn |= submitted == STILB_OK;
	return submitted;
}

stilb_result vulkan_wait(render_device *base)
{
	vulkan_device *device = (vulkan_device *)base;
	stilb_result result = vulkan_timeline_wait(device, device->timeline_value);
	for (uint32_t i = 1; i <= VULKAN_SLOTS && result == STILB_OK; i++) /* the oldest first */
		vulkan_times_read(device, &device->slots[(device->slot + i) % VULKAN_SLOTS]);
	return result;
}

/* ---- panoramas --------------------------------------------------------------------------------------------------- */

void *vulkan_panorama_make(render_device *base, size_t bytes)
{
	vulkan_device *device = (vulkan_device *)base;
	if (device->next_panorama.size != bytes) {
		vulkan_buffer_destroy(device, &device->next_panorama); /* no frame has read it */
		vulkan_buffer_create(device, bytes,
		                     VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
		                     VULKAN_MEMORY_WRITE, &device->next_panorama);
	}
	return device->next_panorama.mapped;
}

void vulkan_panorama_show(render_device *base)
{
	vulkan_device *device = (vulkan_device *)base;
	STILB_ASSERT(device->next_panorama.buffer);
	if (device->panorama.buffer && vulkan_buffer_retire(device, &device->panorama) != STILB_OK) {
		vulkan_timeline_wait(device, device->timeline_value);
		vulkan_buffer_destroy(device, &device->panorama);
	}
	device->panorama = device->next_panorama;
	device->next_panorama = (vulkan_buffer){0};
}
