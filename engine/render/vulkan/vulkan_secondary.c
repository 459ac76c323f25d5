/* Secondary command buffers: a pass is cut into as many parts as there are threads. A job records each part into a
 * command buffer of its own (a vulkan_list), and the main thread executes these in the order of the parts. */
#include "render/vulkan/vulkan_internal.h"

#include <stdlib.h>
#include <string.h>

static VkResult list_create(vulkan_device *device, vulkan_list *list)
{
	VkCommandPoolCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
		.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT,
		.queueFamilyIndex = device->gpu->queue_family,
	};
	return vkCreateCommandPool(device->gpu->device, &info, device->gpu->allocator, &list->pool);
}

/* Gives the slot at least count lists. No job may be recording: the array of lists moves. */
static stilb_result lists_fit(vulkan_device *device, vulkan_slot *slot, uint32_t count)
{
	if (count <= slot->list_count)
		return STILB_OK;
	STILB_ASSERT(count <= VULKAN_MAX_LISTS);
	vulkan_list *lists = stilb_memory_alloc(count, sizeof *lists);
	if (!lists)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for %u secondary command buffers; try fewer --workers", count);
	memset(lists, 0, count * sizeof *lists);
	if (slot->list_count > 0)
		memcpy(lists, slot->lists, slot->list_count * sizeof *lists);
	free(slot->lists);
	slot->lists = lists;
	while (slot->list_count < count) {
		VkResult result = list_create(device, &slot->lists[slot->list_count]);
		if (result != VK_SUCCESS)
			return gpu_vulkan_fail(device->gpu, result, "make secondary command buffers");
		slot->list_count++;
	}
	return STILB_OK;
}

void vulkan_secondary_destroy(vulkan_device *device, vulkan_slot *slot)
{
	for (uint32_t l = 0; l < slot->list_count; l++)
		vkDestroyCommandPool(device->gpu->device, slot->lists[l].pool, device->gpu->allocator);
	free(slot->lists);
	slot->lists = NULL;
	slot->list_count = 0;
}

/* The list's next command buffer, empty. The first call of a frame empties all of the list's buffers, which takes about
 * as long as recording them: so the jobs do it. */
static VkResult list_next(vulkan_device *device, vulkan_list *list, VkCommandBuffer *commands)
{
	STILB_ASSERT(list->used <= list->made && list->used < STILB_RENDER_MAX_PASSES);
	VkResult result = list->used == 0 ? vkResetCommandPool(device->gpu->device, list->pool, 0) : VK_SUCCESS;
	if (result == VK_SUCCESS && list->used == list->made) {
		VkCommandBufferAllocateInfo info = {
			.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
			.commandPool = list->pool,
			.level = VK_COMMAND_BUFFER_LEVEL_SECONDARY,
			.commandBufferCount = 1,
		};
		result = vkAllocateCommandBuffers(device->gpu->device, &info, &list->commands[list->made]);
		list->made += result == VK_SUCCESS;
	}
	if (result == VK_SUCCESS)
		*commands = list->commands[list->used++];
	return result;
}

static VkResult list_begin(vulkan_device *device, VkCommandBuffer commands)
{
	VkFormat light = VULKAN_LIGHT_FORMAT;
	VkCommandBufferInheritanceRenderingInfo rendering = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_INHERITANCE_RENDERING_INFO,
		.colorAttachmentCount = 1,
		.pColorAttachmentFormats = &light,
		.depthAttachmentFormat = VK_FORMAT_D32_SFLOAT,
		.rasterizationSamples = (VkSampleCountFlagBits)device->base.samples,
	};
	VkCommandBufferInheritanceInfo inheritance = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_INHERITANCE_INFO,
		.pNext = &rendering,
	};
	VkCommandBufferBeginInfo begin = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
		.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT | VK_COMMAND_BUFFER_USAGE_RENDER_PASS_CONTINUE_BIT,
		.pInheritanceInfo = &inheritance,
	};
	return vkBeginCommandBuffer(commands, &begin);
}

static VkResult list_record(vulkan_device *device, vulkan_list *list, const render_stream *stream, render_part part,
                            VkCommandBuffer *commands)
{
	VkResult result = list_next(device, list, commands);
	if (result == VK_SUCCESS)
		result = list_begin(device, *commands);
	if (result != VK_SUCCESS)
		return result;
	vulkan_screen_area(device, *commands);
	list->sent = vulkan_draws_direct(device, *commands, stream, part);
	return vkEndCommandBuffer(*commands);
}

/* Shared by the slices of the loop; slice p writes list p and commands[p] alone. */
typedef struct secondary_job {
	vulkan_device *device;
	const render_stream *stream;
	const render_part *parts;
	VkCommandBuffer *commands;
} secondary_job;

static void secondary_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	const secondary_job *job = context;
	for (uint32_t p = begin; p < end; p++) {
		PROFILE("record secondary");
		vulkan_list *list = &vulkan_slot_now(job->device)->lists[p];
		list->result = list_record(job->device, list, job->stream, job->parts[p], &job->commands[p]);
	}
}

stilb_result vulkan_secondary_record(vulkan_device *device, const render_stream *stream, uint32_t count,
                                     VkCommandBuffer *commands)
{
	STILB_ASSERT(stream->draws > 0 && stream->pass->kind == STILB_RENDER_PASS_SCENE);
	vulkan_slot *slot = vulkan_slot_now(device);
	render_part parts[VULKAN_MAX_LISTS];
	stilb_result result = lists_fit(device, slot, count);
	if (result != STILB_OK)
		return result;
	render_split(stream, count, parts);
	secondary_job job = {device, stream, parts, commands};
	stilb_job_parallel_for(stream->pool, count, 1, secondary_slice, &job, stream->worker);
	for (uint32_t l = 0; l < count; l++) {
		const vulkan_list *list = &slot->lists[l];
		if (list->result != VK_SUCCESS)
			return gpu_vulkan_fail(device->gpu, list->result, "record secondary command buffers");
		device->base.stats.draw_commands += list->sent.draws;
		device->base.stats.binds_sent += list->sent.binds;
	}
	device->base.stats.execute_commands += count;
	return STILB_OK;
}
