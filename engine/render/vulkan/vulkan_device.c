/* Opening, resizing and closing the device. */
#include "render/vulkan/vulkan_internal.h"

#include <stdlib.h>

static stilb_result device_choose_samples(vulkan_device *device, uint32_t wanted)
{
	const VkPhysicalDeviceLimits *limits = &device->gpu->properties.limits;
	VkSampleCountFlags possible = limits->framebufferColorSampleCounts & limits->framebufferDepthSampleCounts;
	STILB_ASSERT(wanted == 0 || wanted == VK_SAMPLE_COUNT_1_BIT || wanted == VK_SAMPLE_COUNT_4_BIT);
	device->base.samples = wanted ? wanted : device->gpu->base.software || !(possible & VK_SAMPLE_COUNT_4_BIT) ? 1 : 4;
	if (!(possible & device->base.samples))
		return stilb_fail(STILB_ERROR_DEVICE, "GPU '%s' has no %u samples per pixel; use --msaa 1",
		                  device->gpu->base.name, device->base.samples);
	return STILB_OK;
}

static void vulkan_destroy(render_device *base)
{
	vulkan_device *device = (vulkan_device *)base;
	if (device->gpu) {
		gpu_vulkan_idle(device->gpu);
		vulkan_frames_destroy(device);
		vulkan_targets_destroy(device);
		for (int heap = 0; heap < RENDER_HEAPS; heap++)
			gpu_vulkan_buffer_destroy(device->gpu, &device->heaps[heap]);
		vulkan_pipeline_destroy(device);
		vulkan_tone_destroy(device);
		vulkan_textures_destroy(device);
		gpu_vulkan_destroy(device->gpu);
	}
	free(device);
}

static stilb_result vulkan_resize(render_device *base, uint32_t width, uint32_t height)
{
	vulkan_device *device = (vulkan_device *)base;
	VkResult result = vkDeviceWaitIdle(device->gpu->device);
	if (result != VK_SUCCESS)
		return gpu_vulkan_fail(device->gpu, result, "wait for the GPU");
	vulkan_targets_destroy(device);
	for (uint32_t i = 0; i < STILB_GPU_FRAMES; i++) {
		gpu_vulkan_buffer_destroy(device->gpu, &device->slots[i].picture);
		device->slots[i].picture_valid = false;
	}
	base->width = width;
	base->height = height;
	device->gpu->swapchain.stale = true;
	device->gpu->picture = (VkExtent2D){width, height};
	device->drawn = false;
	stilb_result created = vulkan_targets_create(device);
	if (created != STILB_OK)
		vulkan_targets_destroy(device); /* frame_begin fails until a resize succeeds */
	return created;
}

/* Address space that making the pipelines may need in a driver that draws on the CPU. */
#define DEVICE_SHADER_BYTES ((size_t)1 << 24)

static stilb_result device_start(vulkan_device *device, const stilb_render_desc *desc)
{
	stilb_gpu_desc gpu = {
		.name = desc->gpu,
		.surface = desc->surface,
		.presentation = desc->presentation,
		.validate = desc->validate,
		.faults = {desc->faults.allocation, desc->faults.lost_frame, desc->faults.surface_lost,
	               desc->faults.texture_side},
	};
	stilb_result result = gpu_vulkan_create(&gpu, (VkExtent2D){desc->width, desc->height}, &device->gpu);
	if (result != STILB_OK)
		return result;
	device->base.gpu = &device->gpu->base;
	for (uint32_t i = 0; i < STILB_GPU_FRAMES; i++)
		device->slots[i].gpu = &device->gpu->slots[i];
	result = device_choose_samples(device, desc->samples);
	if (result == STILB_OK)
		result = vulkan_tone_create(device);
	if (result == STILB_OK)
		result = vulkan_targets_create(device);
	if (result == STILB_OK)
		result = vulkan_textures_create(device);
	if (result == STILB_OK)
		result = gpu_vulkan_check_memory(device->gpu, DEVICE_SHADER_BYTES);
	if (result == STILB_OK)
		result = vulkan_pipeline_create(device);
	return result == STILB_OK ? vulkan_frames_create(device) : result;
}

stilb_result render_vulkan_create(const stilb_render_desc *desc, render_device **out)
{
	static const render_device_functions functions = {
		.destroy = vulkan_destroy,
		.resize = vulkan_resize,
		.frame_begin = vulkan_frame_begin,
		.grow = vulkan_grow,
		.rows_make = vulkan_rows_make,
		.rows_free = vulkan_rows_free,
		.texture_create = vulkan_texture_create,
		.texture_destroy = vulkan_texture_destroy,
		.update = vulkan_update,
		.panorama_make = vulkan_panorama_make,
		.panorama_show = vulkan_panorama_show,
		.prepare = vulkan_prepare,
		.pass = vulkan_pass,
		.submit = vulkan_submit,
		.present = vulkan_present,
		.set_surface = vulkan_set_surface,
		.wait = vulkan_wait,
		.read_image = vulkan_read_image,
		.read_light = vulkan_read_light,
	};
	vulkan_device *device = calloc(1, sizeof *device);
	if (!device)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the Vulkan device");
	device->base.functions = &functions;
	device->base.width = desc->width;
	device->base.height = desc->height;
	device->base.replay = desc->replay;
	device->base.materials = desc->materials;
	device->output = desc->output;
	device->packed = !desc->float_vertices;
	device->layout = render_layout_make(&stilb_scene_vertex_streams, device->packed);
	device->color_format =
		desc->output == STILB_RENDER_OUTPUT_LINEAR ? VK_FORMAT_R16G16B16A16_SFLOAT : VK_FORMAT_R8G8B8A8_SRGB;
	stilb_result result = device_start(device, desc);
	if (result != STILB_OK) {
		vulkan_destroy(&device->base);
		return result;
	}
	*out = &device->base;
	return STILB_OK;
}
