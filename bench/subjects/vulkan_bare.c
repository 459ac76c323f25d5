/* vulkan-bare, a plain Vulkan program with which the suite `record` compares the engine: draws and times frames, and
 * checks the last picture. vulkan_bare.h describes it. */
#include "bench/subjects/vulkan_bare.h"

#include "bench/record/record_child.h"

/* ---- data of a frame --------------------------------------------------------------------------------------------- */

static void write_draws(const bare *b, const bare_frame *frame, const stilb_scene *scene)
{
	bare_row *rows = frame->rows.mapped;
	VkDrawIndexedIndirectCommand *indirect = frame->indirect.mapped;
	for (uint32_t i = 0; i < scene->part_count; i++) {
		const float *m = scene->part_transform[i].m;
		const bare_mesh *mesh = &b->meshes[scene->part_mesh[i]];
		rows[i] = (bare_row){
			.transform = {m[0], m[4], m[8], m[12], m[1], m[5], m[9], m[13], m[2], m[6], m[10], m[14]},
			.material = scene->part_material[i],
		};
		indirect[i] = (VkDrawIndexedIndirectCommand){
			.indexCount = mesh->index_count,
			.instanceCount = 1,
			.firstIndex = mesh->first_index,
			.vertexOffset = mesh->vertex_offset,
			.firstInstance = i,
		};
	}
}

static void write_view(const bare_frame *frame, const stilb_scene *scene)
{
	stilb_mat4 matrix = stilb_scene_camera_matrix(&scene->camera, (float)RECORD_WIDTH / (float)RECORD_HEIGHT);
	bare_view view = {0};
	memcpy(view.view_projection, matrix.m, sizeof view.view_projection);
	memcpy(view.sky, scene->surroundings.sky, 3 * sizeof(float));
	memcpy(view.ground, scene->surroundings.ground, 3 * sizeof(float));
	view.sun[3] = STILB_SCENE_LIGHT_DIRECTIONAL;
	memcpy(&view.sun[4], scene->lights[0].direction, 3 * sizeof(float));
	memcpy(&view.sun[8], scene->lights[0].intensity, 3 * sizeof(float));
	memcpy(frame->view.mapped, &view, sizeof view);
}

/* ---- commands ---------------------------------------------------------------------------------------------------- */

#define COLOR_STAGE VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT
#define DEPTH_STAGES (VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT)
#define COPY_STAGE VK_PIPELINE_STAGE_2_COPY_BIT

static void image_barrier(VkCommandBuffer commands, const VkImageMemoryBarrier2 *barrier)
{
	VkImageMemoryBarrier2 whole = *barrier;
	whole.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2;
	whole.subresourceRange.levelCount = whole.subresourceRange.layerCount = 1;
	vkCmdPipelineBarrier2(commands, &(VkDependencyInfo){.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
	                                                    .imageMemoryBarrierCount = 1,
	                                                    .pImageMemoryBarriers = &whole});
}

/* An image of colours is drawn into next, by a pass that discards its contents, once `reader` no longer reads it. */
static void take_color(VkCommandBuffer commands, VkImage image, VkPipelineStageFlags2 reader)
{
	image_barrier(commands, &(VkImageMemoryBarrier2){.srcStageMask = COLOR_STAGE | reader,
	                                                 .srcAccessMask = VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT,
	                                                 .dstStageMask = COLOR_STAGE,
	                                                 .dstAccessMask = VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT,
	                                                 .newLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
	                                                 .image = image,
	                                                 .subresourceRange.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT});
}

/* Barriers: this frame's drawing waits until the previous frame no longer uses the render targets, and discards their
 * contents. */
static void take_targets(const bare *b, VkCommandBuffer commands)
{
	take_color(commands, b->light.image, VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT);
	image_barrier(commands, &(VkImageMemoryBarrier2){
								.srcStageMask = DEPTH_STAGES,
								.srcAccessMask = VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT,
								.dstStageMask = DEPTH_STAGES,
								.dstAccessMask = VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT |
	                                             VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT,
								.newLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
								.image = b->depth.image,
								.subresourceRange.aspectMask = VK_IMAGE_ASPECT_DEPTH_BIT,
							});
}

/* sky: the radiance that `image` is cleared to, with the depth; NULL: it is not, and there is no depth. */
static void begin_rendering(const bare *b, VkCommandBuffer commands, const bare_image *image, const float *sky)
{
	VkRenderingAttachmentInfo color = {
		.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
		.imageView = image->view,
		.imageLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
		.loadOp = sky ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_DONT_CARE,
		.storeOp = VK_ATTACHMENT_STORE_OP_STORE,
	};
	if (sky)
		color.clearValue = (VkClearValue){.color.float32 = {sky[0], sky[1], sky[2], 1.0f}};
	VkRenderingAttachmentInfo depth = {
		.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
		.imageView = b->depth.view,
		.imageLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
		.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
		.storeOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
	};
	VkRenderingInfo rendering = {
		.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
		.renderArea.extent = {RECORD_WIDTH, RECORD_HEIGHT},
		.layerCount = 1,
		.colorAttachmentCount = 1,
		.pColorAttachments = &color,
		.pDepthAttachment = sky ? &depth : NULL,
	};
	vkCmdBeginRendering(commands, &rendering);
}

/* Makes the picture of the light. */
static void tone_map(const bare *b, VkCommandBuffer commands)
{
	image_barrier(commands, &(VkImageMemoryBarrier2){.srcStageMask = COLOR_STAGE,
	                                                 .srcAccessMask = VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT,
	                                                 .dstStageMask = VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT,
	                                                 .dstAccessMask = VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
	                                                 .oldLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
	                                                 .newLayout = VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL,
	                                                 .image = b->light.image,
	                                                 .subresourceRange.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT});
	take_color(commands, b->color.image, COPY_STAGE);
	begin_rendering(b, commands, &b->color, NULL);
	bare_tone_draw(b, commands);
	vkCmdEndRendering(commands);
}

static void draw_all(const bare *b, const bare_frame *frame, const stilb_scene *scene, uint32_t draws)
{
	bare_push push = {
		.light_count = scene->light_count, /* 1: the stress test's sun */
		.lights = frame->view.address + offsetof(bare_view, sun),
		.view = frame->view.address,
		.rows = frame->rows.address,
		.materials = b->materials.address,
	};
	memcpy(push.camera_position, scene->camera.position, 3 * sizeof(float));
	vkCmdBindPipeline(frame->commands, VK_PIPELINE_BIND_POINT_GRAPHICS, b->pipeline);
	vkCmdPushConstants(frame->commands, b->layout, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0,
	                   sizeof push, &push);
	vkCmdBindVertexBuffers(frame->commands, 0, 1, &b->vertices.buffer, &(VkDeviceSize){0});
	vkCmdBindIndexBuffer(frame->commands, b->indices.buffer, 0, VK_INDEX_TYPE_UINT32);
	vkCmdDrawIndexedIndirect(frame->commands, frame->indirect.buffer, 0, draws, sizeof(VkDrawIndexedIndirectCommand));
}

static void copy_picture(const bare *b, const bare_frame *frame)
{
	image_barrier(frame->commands, &(VkImageMemoryBarrier2){
									   .srcStageMask = COLOR_STAGE,
									   .srcAccessMask = VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT,
									   .dstStageMask = COPY_STAGE,
									   .dstAccessMask = VK_ACCESS_2_TRANSFER_READ_BIT,
									   .oldLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
									   .newLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
									   .image = b->color.image,
									   .subresourceRange.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT,
								   });
	VkBufferImageCopy region = {
		.imageSubresource = {.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT, .layerCount = 1},
		.imageExtent = {RECORD_WIDTH, RECORD_HEIGHT, 1},
	};
	vkCmdCopyImageToBuffer(frame->commands, b->color.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, frame->picture.buffer,
	                       1, &region);
	VkMemoryBarrier2 to_host = {
		.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
		.srcStageMask = COPY_STAGE,
		.srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT,
		.dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT,
		.dstAccessMask = VK_ACCESS_2_HOST_READ_BIT,
	};
	vkCmdPipelineBarrier2(frame->commands, &(VkDependencyInfo){.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
	                                                           .memoryBarrierCount = 1,
	                                                           .pMemoryBarriers = &to_host});
}

static void submit(const bare *b, const bare_frame *frame)
{
	VkCommandBufferSubmitInfo commands = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
		.commandBuffer = frame->commands,
	};
	VkSubmitInfo2 info = {
		.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
		.commandBufferInfoCount = 1,
		.pCommandBufferInfos = &commands,
	};
	bare_check(vkQueueSubmit2(b->queue, 1, &info, frame->done), "vkQueueSubmit2");
}

static void draw_frame(const bare *b, const bare_frame *frame, const stilb_scene *scene)
{
	VkCommandBufferBeginInfo begin = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
		.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT,
	};
	bare_check(vkWaitForFences(b->device, 1, &frame->done, VK_TRUE, UINT64_MAX), "vkWaitForFences");
	bare_check(vkResetFences(b->device, 1, &frame->done), "vkResetFences");
	bare_check(vkResetCommandPool(b->device, frame->pool, 0), "vkResetCommandPool");
	write_draws(b, frame, scene);
	write_view(frame, scene);
	bare_check(vkBeginCommandBuffer(frame->commands, &begin), "vkBeginCommandBuffer");
	take_targets(b, frame->commands);
	begin_rendering(b, frame->commands, &b->light, scene->surroundings.sky);
	draw_all(b, frame, scene, scene->part_count);
	vkCmdEndRendering(frame->commands);
	tone_map(b, frame->commands);
	copy_picture(b, frame);
	bare_check(vkEndCommandBuffer(frame->commands), "vkEndCommandBuffer");
	submit(b, frame);
}

/* ---- the program ------------------------------------------------------------------------------------------------- */

/* The checksum of a finished frame's picture, without alpha. */
static uint64_t picture_sum(const bare *b, const bare_frame *frame)
{
	size_t pixels = (size_t)RECORD_WIDTH * RECORD_HEIGHT;
	bare_check(vkWaitForFences(b->device, 1, &frame->done, VK_TRUE, UINT64_MAX), "vkWaitForFences");
	unsigned char *rgb = record_alloc(pixels, 3);
	for (size_t i = 0; i < pixels; i++)
		memcpy(rgb + 3 * i, (const unsigned char *)frame->picture.mapped + 4 * i, 3);
	uint64_t sum = record_picture_sum(rgb, pixels);
	free(rgb);
	return sum;
}

static void measure(const bare *b, const stilb_scene *scene, const bench_child *child)
{
	static record_samples samples;
	record_picture_times times = {0};
	const bare_frame *frame;
	uint64_t until = record_deadline(child->seconds);
	do {
		frame = &b->frames[times.frames % BARE_FRAMES];
		draw_frame(b, frame, scene);
	} while (record_picture_frame(&times, &samples, until));
	record_picture_check(picture_sum(b, frame), child->argument);
	record_picture_print(&times, &samples);
}

/* Draws one frame and prints the upper and lower 24 bits of its checksum, from which the suite's `prepare` makes the
 * reference for all subjects. */
static void show_sum(const bare *b, const stilb_scene *scene)
{
	draw_frame(b, &b->frames[0], scene);
	uint64_t sum = picture_sum(b, &b->frames[0]);
	bench_child_metric("high", (double)(sum >> 24));
	bench_child_metric("low", (double)(sum & 0xffffff));
}

int main(int argc, char **argv)
{
	bench_child child = bench_child_args(argc, argv);
	const record_case *on = record_case_find(child.case_name);
	stilb_scene *scene;
	bare b;
	if (on->materials != RECORD_INDEX || !bare_open(&b))
		return BENCH_CHILD_SKIP;
	if (stilb_scene_create_stress(on->models, 1, &scene) != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
	bare_prepare(&b, scene, RECORD_WIDTH, RECORD_HEIGHT);
	if (child.argument)
		measure(&b, scene, &child);
	else
		show_sum(&b, scene);
	bare_close(&b);
	stilb_scene_destroy(scene);
	return 0;
}
