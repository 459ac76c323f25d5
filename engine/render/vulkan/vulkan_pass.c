/* One pass on the GPU: the images it draws into, its view, its draws. */
#include "render/vulkan/vulkan_internal.h"

#include <math.h>
#include <string.h>

/* What scene passes draw into. */
static const gpu_vulkan_image *pass_light(const vulkan_device *device)
{
	return device->light_samples.image ? &device->light_samples : &device->light;
}

/* Makes the images ready to be drawn into. The frame's first pass waits for the last frame's passes and its copy to the
 * window, and discards the contents; later passes wait for the pass before. 2D passes use the picture alone, scene
 * passes all others. */
static void pass_take_targets(vulkan_device *device, VkCommandBuffer commands, bool first, bool scene)
{
	VkPipelineStageFlags2 color_stage = VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT;
	VkPipelineStageFlags2 depth_stage =
		VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT;
	VkAccessFlags2 color_access = VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT;
	VkAccessFlags2 depth_access =
		VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
	VkImageLayout attachment = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL;
	VkImageLayout before = first ? VK_IMAGE_LAYOUT_UNDEFINED : attachment;
	VkImageMemoryBarrier2 taken[2];
	uint32_t count = 0;
	VkPipelineStageFlags2 reader =
		scene ? VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT : VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
	taken[count++] = gpu_vulkan_image_transition(scene ? pass_light(device)->image : device->color.image,
	                                             VK_IMAGE_ASPECT_COLOR_BIT, before, attachment, color_stage | reader,
	                                             VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT, color_stage, color_access);
	if (scene)
		taken[count++] =
			gpu_vulkan_image_transition(device->depth.image, VK_IMAGE_ASPECT_DEPTH_BIT, before, attachment, depth_stage,
		                                VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT, depth_stage, depth_access);
	gpu_vulkan_image_barriers(commands, taken, count);
}

/* contents: 0 if the primary command buffer makes the draws itself, or
 * VK_RENDERING_CONTENTS_SECONDARY_COMMAND_BUFFERS_BIT if it executes others. */
static void pass_begin_rendering(vulkan_device *device, VkCommandBuffer commands, const render_stream *stream,
                                 bool first, VkRenderingFlags contents)
{
	bool scene = stream->pass->kind == STILB_RENDER_PASS_SCENE;
	VkAttachmentLoadOp load = first ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD;
	VkRenderingAttachmentInfo color = {
		.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
		.imageView = scene ? pass_light(device)->view : device->color.view,
		.imageLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
		.loadOp = load,
		.storeOp = VK_ATTACHMENT_STORE_OP_STORE,
		.clearValue = {.color = vulkan_backdrop_clear(stream->view)},
	};
	VkRenderingAttachmentInfo depth = {
		.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
		.imageView = device->depth.view,
		.imageLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
		.loadOp = load,
		.storeOp = VK_ATTACHMENT_STORE_OP_STORE,
		.clearValue = {.depthStencil = {.depth = 0.0f}}, /* reversed: 0 is far */
	};
	VkRenderingInfo rendering = {
		.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
		.flags = contents,
		.renderArea = {.extent = {device->base.width, device->base.height}},
		.layerCount = 1,
		.colorAttachmentCount = 1,
		.pColorAttachments = &color,
		.pDepthAttachment = scene ? &depth : NULL,
	};
	vkCmdBeginRendering(commands, &rendering);
}

static void copy3(float out[4], const float in[3])
{
	memcpy(out, in, 3 * sizeof *out);
	out[3] = 0.0f;
}

/* Writes the stream's view to the slot's array, at the index of the pass. */
static void pass_write_view(const vulkan_device *device, const vulkan_slot *slot, const render_stream *stream)
{
	const stilb_render_view *view = stream->view;
	STILB_ASSERT(device->pass < STILB_RENDER_MAX_PASSES);
	vulkan_view *out = (vulkan_view *)slot->views.mapped + device->pass;
	memcpy(out->view_projection, view->view_projection.m, sizeof out->view_projection);
	copy3(out->camera_position, view->camera_position);
	copy3(out->sky, view->surroundings.sky);
	copy3(out->ground, view->surroundings.ground);
	out->added[0] = view->shading.roughness;
	out->added[1] = view->shading.anisotropy;
	out->added[2] = view->shading.wrap;
	out->added[3] = view->shading.specular;
	out->lights = slot->memory[RENDER_MEMORY_LIGHTS].address + stream->first_light * sizeof(render_light);
	out->light_count = stream->light_count;
	out->panorama = stream->panorama ? device->panorama.address : 0;
	out->turn[0] = sinf(view->surroundings.rotation);
	out->turn[1] = cosf(view->surroundings.rotation);
}

/* Records the pass's draws into the frame's own command buffer, not into secondary ones. */
static void pass_draw(vulkan_device *device, VkCommandBuffer commands, const render_stream *stream)
{
	stilb_render_stats *stats = &device->base.stats;
	vulkan_screen_area(device, commands);
	if (render_stream_mode(&device->base, stream) == STILB_RENDER_REPLAY_INDIRECT) {
		vulkan_sent sent = vulkan_draws_indirect(device, commands, stream);
		stats->indirect_commands += sent.draws;
		stats->binds_sent += sent.binds;
	} else {
		vulkan_sent sent = vulkan_draws_direct(device, commands, stream, (render_part){.count = stream->draws});
		stats->draw_commands += sent.draws;
		stats->binds_sent += sent.binds;
	}
}

/* Names the pass in messages of the validation layer and in captures of debuggers. */
static void pass_label_begin(const vulkan_device *device, VkCommandBuffer commands, const char *name)
{
	if (device->gpu->label_begin)
		device->gpu->label_begin(commands, &(VkDebugUtilsLabelEXT){.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT,
		                                                           .pLabelName = name ? name : "pass"});
}

/* Draws the backdrop into the cleared picture, in a rendering of its own: that of the draws may consist of secondary
 * command buffers alone. */
static void pass_draw_backdrop(vulkan_device *device, const vulkan_slot *slot, const render_stream *stream)
{
	pass_take_targets(device, slot->gpu->draw, true, true);
	pass_begin_rendering(device, slot->gpu->draw, stream, true, 0);
	vulkan_screen_area(device, slot->gpu->draw);
	vulkan_backdrop_draw(device, slot);
	vkCmdEndRendering(slot->gpu->draw);
}

stilb_result vulkan_pass(render_device *base, const render_stream *stream)
{
	vulkan_device *device = (vulkan_device *)base;
	vulkan_slot *slot = vulkan_slot_now(device);
	VkCommandBuffer secondary[VULKAN_MAX_LISTS];
	uint32_t secondary_count = 0;
	STILB_ASSERT(device->color.image && stream->pass);
	STILB_ASSERT((stream->pass->kind == STILB_RENDER_PASS_SCENE) == (bool)stream->view);
	bool first = device->pass == 0, scene = stream->pass->kind == STILB_RENDER_PASS_SCENE;
	if (!scene && !first && stream->draws == 0)
		return STILB_OK;
	stilb_result result = STILB_OK;
	device->rows = stream->rows ? ((const vulkan_rows *)stream->rows)->buffer.address : 0;
	if (scene) {
		pass_write_view(device, slot, stream);
		result = vulkan_pipeline_choose(device, stream);
	}
	bool backdrop = first && scene && vulkan_backdrop_is_drawn(stream);
	if (first)
		device->transparent = scene && stream->view->backdrop.kind == STILB_SCENE_BACKDROP_NOTHING;
	if (first && scene && result == STILB_OK)
		result = vulkan_tone_begin(device, stream->view);
	if (result == STILB_OK && backdrop)
		result = vulkan_backdrop_prepare(device, slot, stream);
	if (result != STILB_OK)
		return result;
	if (render_stream_mode(base, stream) == STILB_RENDER_REPLAY_SECONDARY && stream->draws > 0) {
		secondary_count = stilb_job_pool_worker_count(stream->pool) + 1;
		result = vulkan_secondary_record(device, stream, secondary_count, secondary);
		if (result != STILB_OK)
			return result;
	}
	if (!scene)
		vulkan_tone_pass(device, slot->gpu->draw);
	pass_label_begin(device, slot->gpu->draw, stream->pass->name);
	gpu_vulkan_times_pass_begin(device->gpu, stream->site);
	if (backdrop)
		pass_draw_backdrop(device, slot, stream);
	pass_take_targets(device, slot->gpu->draw, first && !backdrop, scene);
	pass_begin_rendering(device, slot->gpu->draw, stream, first && !backdrop,
	                     secondary_count > 0 ? VK_RENDERING_CONTENTS_SECONDARY_COMMAND_BUFFERS_BIT : 0);
	if (secondary_count > 0)
		vkCmdExecuteCommands(slot->gpu->draw, secondary_count, secondary);
	else if (stream->draws > 0)
		pass_draw(device, slot->gpu->draw, stream);
	vkCmdEndRendering(slot->gpu->draw);
	gpu_vulkan_times_pass_end(device->gpu);
	if (device->gpu->label_end)
		device->gpu->label_end(slot->gpu->draw);
	device->pass++;
	return STILB_OK;
}
