/* From the light that scene passes have drawn, linear radiance in half floats, to the picture: samples become pixels,
 * then exposure and tone map. Each is one triangle over the whole picture. */
#include "render/vulkan/vulkan_internal.h"

#include <math.h>
#include <string.h>

static const uint32_t screen_vert[] =
#include "screen.vert.inc"
	;
static const uint32_t resolve_frag[] =
#include "resolve.frag.inc"
	;
static const uint32_t tone_frag[] =
#include "tone.frag.inc"
	;

/* ---- what does not change ---------------------------------------------------------------------------------------- */

static VkResult tone_make_layout(vulkan_device *device)
{
	vulkan_tone *tone = &device->tone;
	VkDescriptorSetLayoutBinding binding = {
		.descriptorType = VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE,
		.descriptorCount = 1,
		.stageFlags = VK_SHADER_STAGE_FRAGMENT_BIT,
	};
	VkDescriptorSetLayoutCreateInfo layout = {
		.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
		.bindingCount = 1,
		.pBindings = &binding,
	};
	VkResult result = vkCreateDescriptorSetLayout(device->gpu->device, &layout, device->gpu->allocator, &tone->layout);
	if (result != VK_SUCCESS)
		return result;
	VkPushConstantRange range = {.stageFlags = VK_SHADER_STAGE_FRAGMENT_BIT, .size = sizeof(vulkan_tone_push)};
	VkPipelineLayoutCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
		.setLayoutCount = 1,
		.pSetLayouts = &tone->layout,
		.pushConstantRangeCount = 1,
		.pPushConstantRanges = &range,
	};
	return vkCreatePipelineLayout(device->gpu->device, &info, device->gpu->allocator, &tone->pipeline_layout);
}

static VkResult tone_make_sets(vulkan_device *device)
{
	vulkan_tone *tone = &device->tone;
	uint32_t count = device->base.samples > 1 ? 2 : 1;
	VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE, count};
	VkDescriptorPoolCreateInfo pool = {
		.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
		.maxSets = count,
		.poolSizeCount = 1,
		.pPoolSizes = &size,
	};
	VkResult result = vkCreateDescriptorPool(device->gpu->device, &pool, device->gpu->allocator, &tone->pool);
	if (result != VK_SUCCESS)
		return result;
	VkDescriptorSetLayout layouts[2] = {tone->layout, tone->layout};
	VkDescriptorSet sets[2] = {VK_NULL_HANDLE, VK_NULL_HANDLE};
	VkDescriptorSetAllocateInfo info = {
		.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
		.descriptorPool = tone->pool,
		.descriptorSetCount = count,
		.pSetLayouts = layouts,
	};
	result = vkAllocateDescriptorSets(device->gpu->device, &info, sets);
	tone->light = sets[0];
	tone->samples = sets[1];
	return result;
}

stilb_result vulkan_tone_create(vulkan_device *device)
{
	VkResult result = tone_make_layout(device);
	if (result == VK_SUCCESS)
		result = tone_make_sets(device);
	return result == VK_SUCCESS ? STILB_OK : gpu_vulkan_fail(device->gpu, result, "make what tone maps the picture");
}

void vulkan_tone_destroy(vulkan_device *device)
{
	vulkan_tone *tone = &device->tone;
	vkDestroyPipeline(device->gpu->device, tone->resolve.handle, device->gpu->allocator);
	for (uint32_t curve = 0; curve < SHADE_TONE_COUNT; curve++)
		vkDestroyPipeline(device->gpu->device, tone->tones[curve].handle, device->gpu->allocator);
	vkDestroyDescriptorPool(device->gpu->device, tone->pool, device->gpu->allocator); /* frees the sets, too */
	vkDestroyPipelineLayout(device->gpu->device, tone->pipeline_layout, device->gpu->allocator);
	vkDestroyDescriptorSetLayout(device->gpu->device, tone->layout, device->gpu->allocator);
}

static void tone_write_set(const vulkan_device *device, VkDescriptorSet set, const gpu_vulkan_image *image)
{
	VkDescriptorImageInfo info = {.imageView = image->view, .imageLayout = VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL};
	VkWriteDescriptorSet write = {
		.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
		.dstSet = set,
		.descriptorCount = 1,
		.descriptorType = VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE,
		.pImageInfo = &info,
	};
	vkUpdateDescriptorSets(device->gpu->device, 1, &write, 0, NULL);
}

void vulkan_tone_targets(vulkan_device *device)
{
	tone_write_set(device, device->tone.light, &device->light);
	if (device->light_samples.image)
		tone_write_set(device, device->tone.samples, &device->light_samples);
}

/* ---- pipelines --------------------------------------------------------------------------------------------------- */

static VkResult tone_make_screen(void *user, const void *what, VkPipeline *pipeline)
{
	return vulkan_screen_make(user, what, pipeline);
}

stilb_result vulkan_tone_make(vulkan_device *device, uint32_t curve)
{
	STILB_ASSERT(curve < SHADE_TONE_COUNT);
	vulkan_screen tone = {.vertex = screen_vert,
	                      .vertex_bytes = sizeof screen_vert,
	                      .fragment = tone_frag,
	                      .fragment_bytes = sizeof tone_frag,
	                      .constants = {curve, device->output == STILB_RENDER_OUTPUT_DISPLAY},
	                      .format = device->color_format,
	                      .samples = 1,
	                      .layout = device->tone.pipeline_layout};
	vulkan_screen resolve = tone;
	resolve.fragment = resolve_frag;
	resolve.fragment_bytes = sizeof resolve_frag;
	resolve.constants[0] = device->base.samples;
	resolve.format = VULKAN_LIGHT_FORMAT;
	VkResult result =
		gpu_vulkan_pipeline_once(device->gpu, &device->tone.tones[curve], tone_make_screen, device, &tone);
	if (result == VK_SUCCESS && device->base.samples > 1)
		result = gpu_vulkan_pipeline_once(device->gpu, &device->tone.resolve, tone_make_screen, device, &resolve);
	return result == VK_SUCCESS ? STILB_OK : gpu_vulkan_fail(device->gpu, result, "make the pipeline of the tone map");
}

/* ---- a frame ----------------------------------------------------------------------------------------------------- */

stilb_result vulkan_tone_begin(vulkan_device *device, const stilb_render_view *view)
{
	device->tone.push = (vulkan_tone_push){exp2f(view->exposure), view->dither};
	device->tone.curve = view->tone;
	device->tone.wanted = true;
	return vulkan_tone_make(device, view->tone);
}

/* What has been drawn into `from` can be read, and `to` be written, whose content before is lost. reader: the stage
 * that has read `to` last. */
static void tone_take_images(VkCommandBuffer commands, VkImage from, VkImage to, VkPipelineStageFlags2 reader)
{
	VkPipelineStageFlags2 drawing = VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT;
	VkAccessFlags2 written = VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT;
	VkImageMemoryBarrier2 taken[2] = {
		gpu_vulkan_image_transition(from, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
	                                VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL, drawing, written,
	                                VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT),
		gpu_vulkan_image_transition(to, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
	                                VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL, drawing | reader, written, drawing, written),
	};
	gpu_vulkan_image_barriers(commands, taken, 2);
}

static void tone_run(vulkan_device *device, VkCommandBuffer commands, VkPipeline pipeline, VkDescriptorSet from,
                     VkImageView to)
{
	const vulkan_tone *tone = &device->tone;
	VkRenderingAttachmentInfo color = {
		.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
		.imageView = to,
		.imageLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
		.loadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
		.storeOp = VK_ATTACHMENT_STORE_OP_STORE,
	};
	VkRenderingInfo rendering = {
		.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
		.renderArea = {.extent = {device->base.width, device->base.height}},
		.layerCount = 1,
		.colorAttachmentCount = 1,
		.pColorAttachments = &color,
	};
	STILB_ASSERT(pipeline && from && to);
	vkCmdBeginRendering(commands, &rendering);
	vulkan_screen_area(device, commands);
	vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
	vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, tone->pipeline_layout, 0, 1, &from, 0, NULL);
	vkCmdPushConstants(commands, tone->pipeline_layout, VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof tone->push,
	                   &tone->push);
	vkCmdDraw(commands, 3, 1, 0, 0);
	vkCmdEndRendering(commands);
}

void vulkan_tone_pass(vulkan_device *device, VkCommandBuffer commands)
{
	vulkan_tone *tone = &device->tone;
	if (!tone->wanted)
		return;
	tone->wanted = false;
	tone->lit = true;
	if (device->gpu->label_begin)
		device->gpu->label_begin(commands, &(VkDebugUtilsLabelEXT){.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT,
		                                                           .pLabelName = "tone map"});
	if (device->light_samples.image) {
		tone_take_images(commands, device->light_samples.image, device->light.image,
		                 VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT);
		tone_run(device, commands, tone->resolve.handle, tone->samples, device->light.view);
	}
	tone_take_images(commands, device->light.image, device->color.image, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT);
	tone_run(device, commands, tone->tones[tone->curve].handle, tone->light, device->color.view);
	if (device->gpu->label_end)
		device->gpu->label_end(commands);
}

/* ---- reading the light ------------------------------------------------------------------------------------------- */

/* Copies the light of the slot's frame, which is done, to the buffer. */
static stilb_result light_copy(vulkan_device *device, vulkan_slot *slot, VkBuffer to)
{
	VkBufferImageCopy region = {
		.imageSubresource = {.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT, .layerCount = 1},
		.imageExtent = {device->base.width, device->base.height, 1},
	};
	VkResult error = vkResetCommandPool(device->gpu->device, slot->gpu->pool, 0);
	if (error != VK_SUCCESS)
		return gpu_vulkan_fail(device->gpu, error, "read the frame's light");
	stilb_result result = gpu_vulkan_show_begin(device->gpu, slot->gpu);
	if (result != STILB_OK)
		return result;
	gpu_vulkan_image_barrier(slot->gpu->show, device->light.image, VK_IMAGE_ASPECT_COLOR_BIT,
	                         VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
	                         VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, VK_ACCESS_2_NONE,
	                         VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_READ_BIT);
	vkCmdCopyImageToBuffer(slot->gpu->show, device->light.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to, 1, &region);
	gpu_vulkan_image_barrier(slot->gpu->show, device->light.image, VK_IMAGE_ASPECT_COLOR_BIT,
	                         VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL,
	                         VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_NONE,
	                         VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, VK_ACCESS_2_NONE);
	gpu_vulkan_host_barrier(slot->gpu->show);
	result = gpu_vulkan_show_submit(device->gpu, slot->gpu, VK_NULL_HANDLE, VK_NULL_HANDLE);
	return result == STILB_OK ? gpu_vulkan_timeline_wait(device->gpu, slot->gpu->done) : result;
}

stilb_result vulkan_read_light(render_device *base, stilb_image *image)
{
	vulkan_device *device = (vulkan_device *)base;
	vulkan_slot *slot = vulkan_slot_now(device);
	size_t pixels = (size_t)base->width * base->height, channels = device->transparent ? 4 : 3;
	if (!device->drawn || !device->tone.lit)
		return stilb_fail(STILB_ERROR_DEVICE, "no frame with a scene of this size has been drawn yet");
	gpu_vulkan_buffer buffer;
	stilb_result result = gpu_vulkan_timeline_wait(device->gpu, slot->gpu->done);
	if (result == STILB_OK)
		result = gpu_vulkan_buffer_create(device->gpu, pixels * 8, VK_BUFFER_USAGE_TRANSFER_DST_BIT,
		                                  STILB_GPU_MEMORY_READ, &buffer);
	if (result != STILB_OK)
		return result;
	result = light_copy(device, slot, buffer.buffer);
	if (result == STILB_OK)
		result = stilb_image_create(image, base->width, base->height, (uint32_t)channels, STILB_IMAGE_F16_LINEAR);
	for (size_t i = 0; i < pixels && result == STILB_OK; i++)
		memcpy((uint8_t *)image->pixels + i * 2 * channels, (const uint8_t *)buffer.mapped + i * 8, 2 * channels);
	gpu_vulkan_buffer_destroy(device->gpu, &buffer);
	return result;
}
