/* What a frame of plain Vulkan programs has before and after its draws: barriers, the tone map, the copy to memory. */
#include "bench/subjects/vulkan_bare.h"

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
		.renderArea.extent = {b->width, b->height},
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
		.imageExtent = {b->width, b->height, 1},
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

void bare_frame_wait(const bare *b, const bare_frame *frame)
{
	bare_check(vkWaitForFences(b->device, 1, &frame->done, VK_TRUE, UINT64_MAX), "vkWaitForFences");
}

void bare_frame_begin(const bare *b, const bare_frame *frame, const float sky[3])
{
	VkCommandBufferBeginInfo begin = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
		.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT,
	};
	bare_check(vkResetFences(b->device, 1, &frame->done), "vkResetFences");
	bare_check(vkResetCommandPool(b->device, frame->pool, 0), "vkResetCommandPool");
	bare_check(vkBeginCommandBuffer(frame->commands, &begin), "vkBeginCommandBuffer");
	take_targets(b, frame->commands);
	begin_rendering(b, frame->commands, &b->light, sky);
}

void bare_frame_end(const bare *b, const bare_frame *frame)
{
	vkCmdEndRendering(frame->commands);
	tone_map(b, frame->commands);
	copy_picture(b, frame);
	bare_check(vkEndCommandBuffer(frame->commands), "vkEndCommandBuffer");
	submit(b, frame);
}
