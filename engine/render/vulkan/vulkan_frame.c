/* One frame on the GPU: slots, targets, passes, draws, submission. */
#include "render/vulkan/vulkan_internal.h"

#include "profiler/prof.h"
#include "shading/shade_tonemap.h"

#include <string.h>

/* ---- slots --------------------------------------------------------------------------------------------------------- */

static VkResult slot_create(vulkan_device *device, vulkan_slot *slot)
{
	const VkCommandPoolCreateInfo pool = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
		.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT,
		.queueFamilyIndex = device->queue_family,
	};
	VkResult result = vkCreateCommandPool(device->device, &pool, NULL, &slot->pool);
	if (result != VK_SUCCESS)
		return result;
	const VkCommandBufferAllocateInfo buffers = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
		.commandPool = slot->pool,
		.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
		.commandBufferCount = 1,
	};
	result = vkAllocateCommandBuffers(device->device, &buffers, &slot->draw);
	if (result == VK_SUCCESS)
		result = vkAllocateCommandBuffers(device->device, &buffers, &slot->show);
	const VkSemaphoreCreateInfo semaphore = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
	return result == VK_SUCCESS ? vkCreateSemaphore(device->device, &semaphore, NULL, &slot->acquired) : result;
}

static VkResult frames_make(vulkan_device *device)
{
	const VkSemaphoreTypeCreateInfo type = {
		.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO,
		.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE,
	};
	const VkSemaphoreCreateInfo timeline = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, .pNext = &type};
	VkResult result = vkCreateSemaphore(device->device, &timeline, NULL, &device->timeline);
	const VkQueryPoolCreateInfo queries = {
		.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
		.queryType = VK_QUERY_TYPE_TIMESTAMP,
		.queryCount = 2 * VULKAN_SLOTS,
	};
	if (result == VK_SUCCESS && device->timestamp_mask)
		result = vkCreateQueryPool(device->device, &queries, NULL, &device->queries);
	for (int i = 0; i < VULKAN_SLOTS && result == VK_SUCCESS; i++)
		result = slot_create(device, &device->slots[i]);
	return result;
}

stilb_result vulkan_frames_create(vulkan_device *device)
{
	VkResult error = frames_make(device);
	if (error != VK_SUCCESS)
		return vulkan_fail(error, "make command buffers");
	stilb_result result = STILB_OK;
	for (int i = 0; i < VULKAN_SLOTS && result == STILB_OK; i++)
		result = vulkan_buffer_create(device, STILB_RENDER_MAX_PASSES * sizeof(vulkan_view),
		                              VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
		                              VULKAN_MEMORY_WRITE, &device->slots[i].views);
	for (int i = 0; i < VULKAN_SLOTS && result == STILB_OK && device->queries; i++)
		result = vulkan_buffer_create(device, 2 * sizeof(uint64_t), VK_BUFFER_USAGE_TRANSFER_DST_BIT,
		                              VULKAN_MEMORY_READBACK, &device->slots[i].times);
	return result;
}

void vulkan_frames_destroy(vulkan_device *device)
{
	for (int i = 0; i < VULKAN_SLOTS; i++) {
		vulkan_slot *slot = &device->slots[i];
		vkDestroyCommandPool(device->device, slot->pool, NULL);
		vkDestroySemaphore(device->device, slot->acquired, NULL);
		vulkan_buffer_destroy(device, &slot->rows);
		vulkan_buffer_destroy(device, &slot->views);
		vulkan_buffer_destroy(device, &slot->times);
		vulkan_buffer_destroy(device, &slot->picture);
		for (int p = 0; p < STILB_RENDER_MAX_PASSES; p++)
			vulkan_buffer_destroy(device, &slot->indirect[p]);
	}
	vkDestroyQueryPool(device->device, device->queries, NULL);
	vkDestroySemaphore(device->device, device->timeline, NULL);
}

/* ---- targets ------------------------------------------------------------------------------------------------------- */

stilb_result vulkan_targets_create(vulkan_device *device)
{
	VkSampleCountFlagBits samples = (VkSampleCountFlagBits)device->base.samples;
	stilb_result result = vulkan_image_create(device, device->color_format, VK_SAMPLE_COUNT_1_BIT,
	                                          VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
	                                          VK_IMAGE_ASPECT_COLOR_BIT, &device->color);
	if (result == STILB_OK && samples > 1)
		result = vulkan_image_create(device, device->color_format, samples, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT,
		                             VK_IMAGE_ASPECT_COLOR_BIT, &device->color_samples);
	if (result == STILB_OK)
		result = vulkan_image_create(device, VK_FORMAT_D32_SFLOAT, samples, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT,
		                             VK_IMAGE_ASPECT_DEPTH_BIT, &device->depth);
	return result;
}

void vulkan_targets_destroy(vulkan_device *device)
{
	vulkan_image_destroy(device, &device->color);
	vulkan_image_destroy(device, &device->color_samples);
	vulkan_image_destroy(device, &device->depth);
}

/* ---- begin --------------------------------------------------------------------------------------------------------- */

stilb_result vulkan_timeline_wait(vulkan_device *device, uint64_t value)
{
	const VkSemaphoreWaitInfo info = {
		.sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO,
		.semaphoreCount = 1,
		.pSemaphores = &device->timeline,
		.pValues = &value,
	};
	PROFILE("wait for the GPU");
	VkResult result = vkWaitSemaphores(device->device, &info, UINT64_MAX);
	return result == VK_SUCCESS ? STILB_OK : vulkan_fail(result, "wait for the GPU");
}

/* How long the GPU drew the frame that used this slot; it is done. */
static void slot_read_time(vulkan_device *device, uint32_t slot)
{
	if (!device->slots[slot].timed)
		return;
	const uint64_t *ticks = device->slots[slot].times.mapped;
	uint64_t passed = (ticks[1] - ticks[0]) & device->timestamp_mask; /* a clock of few bits wraps within minutes */
	device->base.stats.gpu_ms = (double)passed * (double)device->properties.limits.timestampPeriod * 1e-6;
}

static stilb_result slot_begin_commands(vulkan_device *device, vulkan_slot *slot)
{
	const VkCommandBufferBeginInfo begin = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
		.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT,
	};
	VkResult result = vkResetCommandPool(device->device, slot->pool, 0);
	if (result == VK_SUCCESS)
		result = vkBeginCommandBuffer(slot->draw, &begin);
	if (result != VK_SUCCESS)
		return vulkan_fail(result, "begin a frame");
	if (device->queries) {
		vkCmdResetQueryPool(slot->draw, device->queries, 2 * device->slot, 2);
		vkCmdWriteTimestamp2(slot->draw, VK_PIPELINE_STAGE_2_TOP_OF_PIPE_BIT, device->queries, 2 * device->slot);
	}
	return STILB_OK;
}

stilb_result vulkan_frame_begin(render_device *base, render_rows *rows)
{
	vulkan_device *device = (vulkan_device *)base;
	if (!device->color.image)
		return stilb_fail(STILB_ERROR_MEMORY, "there is no picture to draw into; choose a smaller size");
	device->slot = (device->slot + 1) % VULKAN_SLOTS;
	device->pass = 0;
	vulkan_slot *slot = vulkan_slot_now(device);
	stilb_result result = vulkan_timeline_wait(device, slot->done);
	if (result != STILB_OK)
		return result;
	slot_read_time(device, device->slot);
	slot->timed = slot->picture_valid = false;
	result = slot_begin_commands(device, slot);
	if (result != STILB_OK)
		return result;
	if (!slot->rows.buffer)
		return vulkan_rows_grow(base, rows, VULKAN_FIRST_ROWS);
	rows->memory = slot->rows.mapped;
	rows->capacity = (uint32_t)(slot->rows.size / sizeof(render_row));
	return STILB_OK;
}

stilb_result vulkan_rows_grow(render_device *base, render_rows *rows, uint32_t capacity)
{
	vulkan_device *device = (vulkan_device *)base;
	vulkan_slot *slot = vulkan_slot_now(device);
	vulkan_buffer grown;
	stilb_result result = vulkan_buffer_create(
		device, (VkDeviceSize)capacity * sizeof(render_row),
		VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT, VULKAN_MEMORY_WRITE, &grown);
	if (result != STILB_OK)
		return result;
	if (slot->rows.buffer)
		memcpy(grown.mapped, slot->rows.mapped, slot->rows.size);
	vulkan_buffer_destroy(device, &slot->rows); /* no frame in flight uses this slot */
	slot->rows = grown;
	rows->memory = grown.mapped;
	rows->capacity = capacity;
	return STILB_OK;
}

/* ---- passes -------------------------------------------------------------------------------------------------------- */

void vulkan_image_barrier(VkCommandBuffer commands, VkImage image, VkImageAspectFlags aspect, VkImageLayout from,
                          VkImageLayout to, VkPipelineStageFlags2 from_stage, VkAccessFlags2 from_access,
                          VkPipelineStageFlags2 to_stage, VkAccessFlags2 to_access)
{
	const VkImageMemoryBarrier2 barrier = {
		.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
		.srcStageMask = from_stage,
		.srcAccessMask = from_access,
		.dstStageMask = to_stage,
		.dstAccessMask = to_access,
		.oldLayout = from,
		.newLayout = to,
		.srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
		.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
		.image = image,
		.subresourceRange = {.aspectMask = aspect, .levelCount = 1, .layerCount = 1},
	};
	const VkDependencyInfo dependency = {
		.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
		.imageMemoryBarrierCount = 1,
		.pImageMemoryBarriers = &barrier,
	};
	vkCmdPipelineBarrier2(commands, &dependency);
}

/* The frame's first pass takes the targets from the frame before (its passes, and the copy that showed it); a later one
 * continues where the pass before stopped. */
static void pass_take_targets(vulkan_device *device, VkCommandBuffer commands, bool first)
{
	const VkPipelineStageFlags2 color_stage = VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT;
	const VkPipelineStageFlags2 depth_stage =
		VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT;
	const VkAccessFlags2 color_access = VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT;
	const VkAccessFlags2 depth_access =
		VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
	const VkImageLayout attachment = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL;
	const VkImageLayout before = first ? VK_IMAGE_LAYOUT_UNDEFINED : attachment;
	vulkan_image_barrier(commands, device->color.image, VK_IMAGE_ASPECT_COLOR_BIT, before, attachment,
	                     color_stage | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT,
	                     color_stage, color_access);
	if (device->color_samples.image)
		vulkan_image_barrier(commands, device->color_samples.image, VK_IMAGE_ASPECT_COLOR_BIT, before, attachment,
		                     color_stage, VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT, color_stage, color_access);
	vulkan_image_barrier(commands, device->depth.image, VK_IMAGE_ASPECT_DEPTH_BIT, before, attachment, depth_stage,
	                     VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT, depth_stage, depth_access);
}

/* The sky behind everything, as the fragment shader would have written it. */
static VkClearColorValue pass_clear_color(const vulkan_device *device, const stilb_scene_sky *sky)
{
	stilb_vec3 color = stilb_vec3_make(sky->sky[0], sky->sky[1], sky->sky[2]);
	if (device->output == STILB_RENDER_OUTPUT_DISPLAY)
		color = shade_tonemap(color, SHADE_TONEMAP_A, SHADE_TONEMAP_B);
	return (VkClearColorValue){.float32 = {color[0], color[1], color[2], 1.0f}};
}

static void pass_begin_rendering(vulkan_device *device, VkCommandBuffer commands, const stilb_scene_sky *sky,
                                 bool first)
{
	bool resolve = device->color_samples.image != VK_NULL_HANDLE;
	const VkAttachmentLoadOp load = first ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD;
	const VkRenderingAttachmentInfo color = {
		.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
		.imageView = resolve ? device->color_samples.view : device->color.view,
		.imageLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
		.resolveMode = resolve ? VK_RESOLVE_MODE_AVERAGE_BIT : VK_RESOLVE_MODE_NONE,
		.resolveImageView = resolve ? device->color.view : VK_NULL_HANDLE,
		.resolveImageLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
		.loadOp = load,
		.storeOp = VK_ATTACHMENT_STORE_OP_STORE,
		.clearValue = {.color = pass_clear_color(device, sky)},
	};
	const VkRenderingAttachmentInfo depth = {
		.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
		.imageView = device->depth.view,
		.imageLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
		.loadOp = load,
		.storeOp = VK_ATTACHMENT_STORE_OP_STORE,
		.clearValue = {.depthStencil = {.depth = 0.0f}}, /* reversed: 0 is far */
	};
	const VkRect2D area = {.extent = {device->base.width, device->base.height}};
	const VkRenderingInfo rendering = {
		.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
		.renderArea = area,
		.layerCount = 1,
		.colorAttachmentCount = 1,
		.pColorAttachments = &color,
		.pDepthAttachment = &depth,
	};
	const VkViewport viewport = {
		.width = (float)device->base.width, .height = (float)device->base.height, .minDepth = 0.0f, .maxDepth = 1.0f};
	vkCmdBeginRendering(commands, &rendering);
	vkCmdSetViewport(commands, 0, 1, &viewport);
	vkCmdSetScissor(commands, 0, 1, &area);
}

static void copy3(float out[4], const float in[3])
{
	memcpy(out, in, 3 * sizeof *out);
	out[3] = 0.0f;
}

/* Binds what all draws of the pass share. */
static void pass_bind(vulkan_device *device, vulkan_slot *slot, const stilb_render_view *view)
{
	vulkan_view *out = (vulkan_view *)slot->views.mapped + device->pass;
	memcpy(out->view_projection, view->view_projection.m, sizeof out->view_projection);
	copy3(out->camera_position, view->camera_position);
	copy3(out->sun_direction, view->sun.direction);
	copy3(out->sun_irradiance, view->sun.irradiance);
	copy3(out->sky, view->sky.sky);
	copy3(out->ground, view->sky.ground);
	const vulkan_push push = {
		.view = slot->views.address + device->pass * sizeof(vulkan_view),
		.rows = slot->rows.address,
		.materials = device->materials.address,
	};
	vkCmdBindPipeline(slot->draw, VK_PIPELINE_BIND_POINT_GRAPHICS, device->pipeline);
	vkCmdPushConstants(slot->draw, device->pipeline_layout, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT,
	                   0, sizeof push, &push);
	vkCmdBindVertexBuffers(slot->draw, 0, 1, &device->vertices.buffer, &(VkDeviceSize){0});
	vkCmdBindIndexBuffer(slot->draw, device->indices.buffer, 0, VK_INDEX_TYPE_UINT32);
}

stilb_result vulkan_pass_begin(render_device *base, const stilb_render_pass *pass, const stilb_render_view *view,
                               uint64_t draw_count)
{
	(void)pass; /* one target today */
	vulkan_device *device = (vulkan_device *)base;
	vulkan_slot *slot = vulkan_slot_now(device);
	VkDeviceSize wanted = draw_count * sizeof(render_indirect);
	vulkan_buffer *indirect = &slot->indirect[device->pass];
	device->indirect_count = 0;
	if (base->replay == STILB_RENDER_REPLAY_INDIRECT && wanted > indirect->size) {
		vulkan_buffer_destroy(device, indirect);
		stilb_result result = vulkan_buffer_create(device, wanted + wanted / 4, VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT,
		                                           VULKAN_MEMORY_WRITE, indirect);
		if (result != STILB_OK)
			return result;
	}
	bool first = device->pass == 0;
	pass_take_targets(device, slot->draw, first);
	pass_begin_rendering(device, slot->draw, &view->sky, first);
	pass_bind(device, slot, view);
	return STILB_OK;
}

void vulkan_draws(render_device *base, const render_command *commands, uint32_t count)
{
	vulkan_device *device = (vulkan_device *)base;
	vulkan_slot *slot = vulkan_slot_now(device);
	if (base->replay == STILB_RENDER_REPLAY_INDIRECT) {
		render_write_indirect((render_indirect *)slot->indirect[device->pass].mapped + device->indirect_count, commands,
		                      count);
		device->indirect_count += count;
		return;
	}
	for (uint32_t i = 0; i < count; i++)
		vkCmdDrawIndexed(slot->draw, commands[i].index_count, 1, commands[i].first_index, commands[i].vertex_offset,
		                 commands[i].row);
	base->stats.draw_commands += count;
}

void vulkan_pass_end(render_device *base)
{
	vulkan_device *device = (vulkan_device *)base;
	vulkan_slot *slot = vulkan_slot_now(device);
	const uint32_t most = device->properties.limits.maxDrawIndirectCount;
	for (uint64_t done = 0; done < device->indirect_count;) {
		uint64_t left = device->indirect_count - done;
		uint32_t count = left < most ? (uint32_t)left : most;
		vkCmdDrawIndexedIndirect(slot->draw, slot->indirect[device->pass].buffer, done * sizeof(render_indirect), count,
		                         sizeof(render_indirect));
		base->stats.indirect_commands++;
		done += count;
	}
	vkCmdEndRendering(slot->draw);
	device->pass++;
}

/* ---- submission ---------------------------------------------------------------------------------------------------- */

stilb_result vulkan_queue_submit(vulkan_device *device, VkCommandBuffer commands, VkSemaphore wait, VkSemaphore signal)
{
	const VkCommandBufferSubmitInfo buffer = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
		.commandBuffer = commands,
	};
	const VkSemaphoreSubmitInfo waits = {
		.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
		.semaphore = wait,
		.stageMask = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
	};
	const VkSemaphoreSubmitInfo signals[2] = {
		{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
	     .semaphore = device->timeline,
	     .value = device->timeline_value + 1,
	     .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT},
		{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
	     .semaphore = signal,
	     .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT},
	};
	const VkSubmitInfo2 submit = {
		.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
		.waitSemaphoreInfoCount = wait != VK_NULL_HANDLE,
		.pWaitSemaphoreInfos = &waits,
		.commandBufferInfoCount = 1,
		.pCommandBufferInfos = &buffer,
		.signalSemaphoreInfoCount = signal != VK_NULL_HANDLE ? 2 : 1,
		.pSignalSemaphoreInfos = signals,
	};
	VkResult result = vkQueueSubmit2(device->queue, 1, &submit, VK_NULL_HANDLE);
	if (result != VK_SUCCESS)
		return vulkan_fail(result, "give the GPU a frame");
	device->timeline_value++;
	return STILB_OK;
}

void vulkan_host_barrier(VkCommandBuffer commands)
{
	const VkMemoryBarrier2 barrier = {
		.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
		.srcStageMask = VK_PIPELINE_STAGE_2_COPY_BIT,
		.srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT,
		.dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT,
		.dstAccessMask = VK_ACCESS_2_HOST_READ_BIT,
	};
	const VkDependencyInfo dependency = {
		.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
		.memoryBarrierCount = 1,
		.pMemoryBarriers = &barrier,
	};
	vkCmdPipelineBarrier2(commands, &dependency);
}

/* Takes the second timestamp and has the GPU write both to memory: asking for them with vkGetQueryPoolResults waits for all
 * of the device in some drivers. */
static void submit_time(vulkan_device *device, vulkan_slot *slot)
{
	const uint32_t first = 2 * device->slot;
	vkCmdWriteTimestamp2(slot->draw, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, device->queries, first + 1);
	vkCmdCopyQueryPoolResults(slot->draw, device->queries, first, 2, slot->times.buffer, 0, sizeof(uint64_t),
	                          VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT);
	vulkan_host_barrier(slot->draw);
	slot->timed = true;
}

stilb_result vulkan_submit(render_device *base)
{
	vulkan_device *device = (vulkan_device *)base;
	vulkan_slot *slot = vulkan_slot_now(device);
	vulkan_image_barrier(slot->draw, device->color.image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
	                     VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
	                     VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
	                     VK_ACCESS_2_TRANSFER_READ_BIT);
	if (device->queries)
		submit_time(device, slot);
	VkResult result = vkEndCommandBuffer(slot->draw);
	if (result != VK_SUCCESS)
		return vulkan_fail(result, "record a frame");
	stilb_result submitted = vulkan_queue_submit(device, slot->draw, VK_NULL_HANDLE, VK_NULL_HANDLE);
	slot->done = device->timeline_value;
	device->drawn |= submitted == STILB_OK;
	return submitted;
}

stilb_result vulkan_wait(render_device *base)
{
	vulkan_device *device = (vulkan_device *)base;
	stilb_result result = vulkan_timeline_wait(device, device->timeline_value);
	if (result == STILB_OK)
		slot_read_time(device, device->slot);
	return result;
}
