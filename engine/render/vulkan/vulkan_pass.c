/* One pass on the GPU: targets, bindings, draws. */
#include "render/vulkan/vulkan_internal.h"

#include "shading/shade_tonemap.h"

#include <string.h>

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
		.rows = slot->memory[RENDER_MEMORY_ROWS].address,
		.materials = device->heaps[RENDER_HEAP_MATERIALS].address,
	};
	vkCmdBindPipeline(slot->draw, VK_PIPELINE_BIND_POINT_GRAPHICS, device->pipeline);
	vkCmdPushConstants(slot->draw, device->pipeline_layout, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT,
	                   0, sizeof push, &push);
	vkCmdBindVertexBuffers(slot->draw, 0, 1, &device->heaps[RENDER_HEAP_VERTICES].buffer, &(VkDeviceSize){0});
	vkCmdBindIndexBuffer(slot->draw, device->heaps[RENDER_HEAP_INDICES].buffer, 0, VK_INDEX_TYPE_UINT32);
}

/* ---- draws --------------------------------------------------------------------------------------------------------- */

static void pass_direct(vulkan_device *device, VkCommandBuffer commands, const render_stream *stream)
{
	for (const render_run *run = stream->runs; run < stream->runs + stream->run_count; run++) {
		const render_command *command = stream->commands + run->first;
		for (uint32_t i = 0; i < run->count; i++, command++)
			vkCmdDrawIndexed(commands, command->index_count, 1, command->first_index, command->vertex_offset,
			                 command->row);
	}
	device->base.stats.draw_commands += stream->draws;
}

static void pass_indirect(vulkan_device *device, VkCommandBuffer commands, const render_stream *stream)
{
	const uint32_t most = device->properties.limits.maxDrawIndirectCount;
	VkBuffer buffer = vulkan_slot_now(device)->memory[RENDER_MEMORY_COMMANDS].buffer;
	for (const render_run *run = stream->runs; run < stream->runs + stream->run_count; run++)
		for (uint32_t done = 0, count; done < run->count; done += count) {
			count = run->count - done < most ? run->count - done : most;
			vkCmdDrawIndexedIndirect(commands, buffer, (run->first + (VkDeviceSize)done) * sizeof(render_command),
			                         count, sizeof(render_command));
			device->base.stats.indirect_commands++;
		}
}

stilb_result vulkan_pass(render_device *base, const render_stream *stream)
{
	vulkan_device *device = (vulkan_device *)base;
	vulkan_slot *slot = vulkan_slot_now(device);
	bool first = device->pass == 0;
	pass_take_targets(device, slot->draw, first);
	pass_begin_rendering(device, slot->draw, &stream->view->sky, first);
	if (stream->draws > 0) {
		pass_bind(device, slot, stream->view);
		if (base->replay == STILB_RENDER_REPLAY_INDIRECT)
			pass_indirect(device, slot->draw, stream);
		else
			pass_direct(device, slot->draw, stream);
	}
	vkCmdEndRendering(slot->draw);
	device->pass++;
	return STILB_OK;
}
