/* Slots of frames, and what is given to the queue. */
#include "gpu/vulkan/gpu_vulkan_internal.h"

#include <stdlib.h>

/* ---- slots ------------------------------------------------------------------------------------------------------- */

static VkResult slot_create(gpu_vulkan *gpu, gpu_vulkan_slot *slot)
{
	VkCommandPoolCreateInfo pool = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
		.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT,
		.queueFamilyIndex = gpu->queue_family,
	};
	VkResult result = vkCreateCommandPool(gpu->device, &pool, gpu->allocator, &slot->pool);
	if (result != VK_SUCCESS)
		return result;
	VkCommandBufferAllocateInfo buffers = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
		.commandPool = slot->pool,
		.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
		.commandBufferCount = 1,
	};
	result = vkAllocateCommandBuffers(gpu->device, &buffers, &slot->draw);
	if (result == VK_SUCCESS)
		result = vkAllocateCommandBuffers(gpu->device, &buffers, &slot->show);
	VkSemaphoreCreateInfo semaphore = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
	return result == VK_SUCCESS ? vkCreateSemaphore(gpu->device, &semaphore, gpu->allocator, &slot->acquired) : result;
}

static VkResult frames_make(gpu_vulkan *gpu)
{
	VkSemaphoreTypeCreateInfo type = {
		.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO,
		.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE,
	};
	VkSemaphoreCreateInfo timeline = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, .pNext = &type};
	VkResult result = vkCreateSemaphore(gpu->device, &timeline, gpu->allocator, &gpu->timeline);
	for (uint32_t i = 0; i < STILB_GPU_FRAMES && result == VK_SUCCESS; i++)
		result = slot_create(gpu, &gpu->slots[i]);
	return result;
}

stilb_result gpu_vulkan_frames_create(gpu_vulkan *gpu)
{
	VkResult error = frames_make(gpu);
	return error == VK_SUCCESS ? gpu_vulkan_times_create(gpu) : gpu_vulkan_fail(gpu, error, "make command buffers");
}

void gpu_vulkan_frames_destroy(gpu_vulkan *gpu)
{
	for (uint32_t i = 0; i < STILB_GPU_FRAMES; i++) {
		vkDestroyCommandPool(gpu->device, gpu->slots[i].pool, gpu->allocator);
		vkDestroySemaphore(gpu->device, gpu->slots[i].acquired, gpu->allocator);
	}
	gpu_vulkan_times_destroy(gpu);
	vkDestroySemaphore(gpu->device, gpu->timeline, gpu->allocator);
}

stilb_result gpu_vulkan_slot_take(gpu_vulkan *gpu)
{
	gpu->slot = (gpu->slot + 1) % STILB_GPU_FRAMES;
	gpu_vulkan_slot *slot = gpu_vulkan_slot_now(gpu);
	stilb_result result = gpu_vulkan_timeline_wait(gpu, slot->done);
	if (result != STILB_OK)
		return result;
	gpu_vulkan_times_read(gpu, slot);
	PROFILE("reset commands"); /* frees the commands of the slot's last frame */
	VkResult reset = vkResetCommandPool(gpu->device, slot->pool, 0);
	return reset == VK_SUCCESS ? STILB_OK : gpu_vulkan_fail(gpu, reset, "begin a frame");
}

stilb_result gpu_vulkan_slot_begin(gpu_vulkan *gpu, uint32_t passes)
{
	gpu_vulkan_slot *slot = gpu_vulkan_slot_now(gpu);
	VkCommandBufferBeginInfo begin = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
		.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT,
	};
	slot->part_count = 0;
	VkResult result = vkBeginCommandBuffer(slot->draw, &begin);
	return result == VK_SUCCESS ? gpu_vulkan_times_begin(gpu, passes) : gpu_vulkan_fail(gpu, result, "begin a frame");
}

VkResult gpu_vulkan_extra_begin(gpu_vulkan *gpu, gpu_vulkan_slot *slot, VkCommandBuffer *commands)
{
	if (slot->extra_used == slot->extra_count) {
		VkCommandBuffer *grown = realloc(slot->extra, (slot->extra_count + 1) * sizeof *grown);
		if (!grown)
			return VK_ERROR_OUT_OF_HOST_MEMORY;
		slot->extra = grown;
		VkCommandBufferAllocateInfo info = {
			.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
			.commandPool = slot->pool,
			.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
			.commandBufferCount = 1,
		};
		VkResult result = vkAllocateCommandBuffers(gpu->device, &info, &slot->extra[slot->extra_count]);
		if (result != VK_SUCCESS)
			return result;
		slot->extra_count++;
	}
	*commands = slot->extra[slot->extra_used++];
	VkCommandBufferBeginInfo begin = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
		.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT,
	};
	return vkBeginCommandBuffer(*commands, &begin);
}

stilb_result gpu_vulkan_slot_split(gpu_vulkan *gpu, const stilb_gpu_pass *pass, const stilb_prof_site *site)
{
	gpu_vulkan_slot *slot = gpu_vulkan_slot_now(gpu);
	if (slot->part_count == slot->part_capacity) {
		uint32_t capacity = 2 * slot->part_capacity + 4;
		gpu_vulkan_part *grown = realloc(slot->parts, capacity * sizeof *grown);
		if (!grown)
			return stilb_fail(STILB_ERROR_MEMORY, "no memory for the parts of a frame");
		slot->parts = grown;
		slot->part_capacity = capacity;
	}
	VkCommandBuffer next;
	VkResult result = vkEndCommandBuffer(slot->draw);
	result = result == VK_SUCCESS ? gpu_vulkan_extra_begin(gpu, slot, &next) : result;
	if (result != VK_SUCCESS)
		return gpu_vulkan_fail(gpu, result, "record a frame");
	slot->parts[slot->part_count++] = (gpu_vulkan_part){slot->draw, pass, site};
	slot->extra[slot->extra_used - 1] = slot->draw; /* all of them are of one pool */
	slot->draw = next;
	return STILB_OK;
}

/* ---- submission -------------------------------------------------------------------------------------------------- */

stilb_result gpu_vulkan_timeline_wait(gpu_vulkan *gpu, uint64_t value)
{
	VkSemaphoreWaitInfo info = {
		.sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO,
		.semaphoreCount = 1,
		.pSemaphores = &gpu->timeline,
		.pValues = &value,
	};
	STILB_ASSERT(value <= gpu->timeline_value && "a submission will signal it");
	PROFILE("wait for the GPU");
	VkResult result = vkWaitSemaphores(gpu->device, &info, UINT64_MAX);
	return result == VK_SUCCESS ? STILB_OK : gpu_vulkan_fail(gpu, result, "wait for the GPU");
}

stilb_result gpu_vulkan_queue_submit(gpu_vulkan *gpu, VkCommandBuffer commands, VkSemaphore wait, VkSemaphore signal)
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
	     .semaphore = gpu->timeline,
	     .value = gpu->timeline_value + 1,
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
	STILB_ASSERT(commands && gpu->timeline_value < UINT64_MAX);
	VkResult result = vkQueueSubmit2(gpu->queue, 1, &submit, VK_NULL_HANDLE);
	if (result != VK_SUCCESS)
		return gpu_vulkan_fail(gpu, result, "give the GPU a frame");
	gpu->timeline_value++;
	return STILB_OK;
}

static stilb_result slot_part(gpu_vulkan *gpu, const gpu_vulkan_part *part)
{
	stilb_result result = gpu_vulkan_queue_submit(gpu, part->commands, VK_NULL_HANDLE, VK_NULL_HANDLE);
	if (result == STILB_OK)
		result = gpu_vulkan_timeline_wait(gpu, gpu->timeline_value);
	if (result != STILB_OK)
		return result;
	stilb_prof_zone_begin(part->site);
	part->pass->host(part->pass->host_user);
	stilb_prof_zone_end();
	return STILB_OK;
}

stilb_result gpu_vulkan_slot_submit(gpu_vulkan *gpu)
{
	gpu_vulkan_slot *slot = gpu_vulkan_slot_now(gpu);
	gpu_vulkan_times_end(gpu);
	VkResult result = vkEndCommandBuffer(slot->draw);
	if (result != VK_SUCCESS)
		return gpu_vulkan_fail(gpu, result, "record a frame");
	stilb_result submitted = STILB_OK;
	for (uint32_t p = 0; p < slot->part_count && submitted == STILB_OK; p++)
		submitted = slot_part(gpu, &slot->parts[p]);
	if (submitted == STILB_OK)
		submitted = gpu_vulkan_queue_submit(gpu, slot->draw, VK_NULL_HANDLE, VK_NULL_HANDLE);
	slot->done = gpu->timeline_value;
	gpu_vulkan_times_submitted(gpu, submitted == STILB_OK);
	return submitted;
}

stilb_result gpu_vulkan_show_begin(gpu_vulkan *gpu, gpu_vulkan_slot *slot)
{
	VkCommandBufferBeginInfo begin = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
		.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT,
	};
	VkResult result = vkBeginCommandBuffer(slot->show, &begin);
	return result == VK_SUCCESS ? STILB_OK : gpu_vulkan_fail(gpu, result, "show a frame");
}

stilb_result gpu_vulkan_show_submit(gpu_vulkan *gpu, gpu_vulkan_slot *slot, VkSemaphore wait, VkSemaphore signal)
{
	VkResult result = vkEndCommandBuffer(slot->show);
	if (result != VK_SUCCESS)
		return gpu_vulkan_fail(gpu, result, "show a frame");
	stilb_result submitted = gpu_vulkan_queue_submit(gpu, slot->show, wait, signal);
	slot->done = gpu->timeline_value;
	return submitted;
}

stilb_result gpu_vulkan_wait(gpu_vulkan *gpu)
{
	stilb_result result = gpu_vulkan_timeline_wait(gpu, gpu->timeline_value);
	for (uint32_t i = 1; i <= STILB_GPU_FRAMES && result == STILB_OK; i++) /* the oldest first */
		gpu_vulkan_times_read(gpu, &gpu->slots[(gpu->slot + i) % STILB_GPU_FRAMES]);
	return result;
}
