/* Opening, resizing and closing the device. */
#include "render/vulkan/vulkan_internal.h"

#include <stdlib.h>
#include <string.h>

const VkAllocationCallbacks *vulkan_host_allocator;

/* The first queue family that can draw, and present if there is a window; UINT32_MAX: there is none. */
static uint32_t device_queue_family(const vulkan_device *device, uint32_t *timestamp_bits)
{
	VkQueueFamilyProperties families[32];
	uint32_t count = 32;
	vkGetPhysicalDeviceQueueFamilyProperties(device->gpu, &count, families);
	for (uint32_t i = 0; i < count; i++) {
		VkBool32 shows = VK_TRUE;
		if (device->surface)
			vkGetPhysicalDeviceSurfaceSupportKHR(device->gpu, i, device->surface, &shows);
		if ((families[i].queueFlags & VK_QUEUE_GRAPHICS_BIT) && shows) {
			*timestamp_bits = families[i].timestampValidBits;
			return i;
		}
	}
	return UINT32_MAX;
}

static bool device_has_extension(const vulkan_device *device, const char *name)
{
	uint32_t count = 0;
	vkEnumerateDeviceExtensionProperties(device->gpu, NULL, &count, NULL);
	VkExtensionProperties *extensions = calloc(count, sizeof *extensions);
	bool found = false; /* stays false without memory: Stilb can do without every extension that is asked for here */
	if (extensions && vkEnumerateDeviceExtensionProperties(device->gpu, NULL, &count, extensions) >= 0)
		for (uint32_t i = 0; i < count; i++)
			found |= strcmp(extensions[i].extensionName, name) == 0;
	free(extensions);
	return found;
}

static VkResult device_make(vulkan_device *device)
{
	static const float priority = 1.0f;
	const char *extensions[2];
	uint32_t extension_count = 0;
	if (device->surface)
		extensions[extension_count++] = VK_KHR_SWAPCHAIN_EXTENSION_NAME;
	device->calibrates = device_has_extension(device, VK_EXT_CALIBRATED_TIMESTAMPS_EXTENSION_NAME);
	if (device->calibrates)
		extensions[extension_count++] = VK_EXT_CALIBRATED_TIMESTAMPS_EXTENSION_NAME;
	VkPhysicalDeviceVulkan13Features v13 = {
		.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES,
		.dynamicRendering = VK_TRUE,
		.synchronization2 = VK_TRUE,
	};
	VkPhysicalDeviceVulkan12Features v12 = {
		.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
		.pNext = &v13,
		.bufferDeviceAddress = VK_TRUE,
		.timelineSemaphore = VK_TRUE,
	};
	VkPhysicalDeviceFeatures features = {
		.multiDrawIndirect = VK_TRUE,
		.drawIndirectFirstInstance = VK_TRUE,
	};
	VkDeviceQueueCreateInfo queue = {
		.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
		.queueFamilyIndex = device->queue_family,
		.queueCount = 1,
		.pQueuePriorities = &priority,
	};
	VkDeviceCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
		.pNext = &v12,
		.queueCreateInfoCount = 1,
		.pQueueCreateInfos = &queue,
		.enabledExtensionCount = extension_count,
		.ppEnabledExtensionNames = extensions,
		.pEnabledFeatures = &features,
	};
	return vkCreateDevice(device->gpu, &info, device->allocator, &device->device);
}

static stilb_result device_create(vulkan_device *device)
{
	uint32_t timestamp_bits = 0;
	device->queue_family = device_queue_family(device, &timestamp_bits);
	if (device->queue_family == UINT32_MAX)
		return stilb_fail(STILB_ERROR_WINDOW, "GPU '%s' cannot draw to this window; choose another with --gpu",
		                  device->base.name);
	VkResult result = device_make(device);
	if (result != VK_SUCCESS)
		return vulkan_fail(device, result, "open the GPU");
	vkGetDeviceQueue(device->device, device->queue_family, 0, &device->queue);
	if (timestamp_bits > 0 && device->properties.limits.timestampPeriod > 0.0f)
		device->timestamp_mask = UINT64_MAX >> (64 - timestamp_bits);
	return STILB_OK;
}

static stilb_result device_choose_samples(vulkan_device *device, uint32_t wanted)
{
	const VkPhysicalDeviceLimits *limits = &device->properties.limits;
	VkSampleCountFlags possible = limits->framebufferColorSampleCounts & limits->framebufferDepthSampleCounts;
	STILB_ASSERT(wanted == 0 || wanted == VK_SAMPLE_COUNT_1_BIT || wanted == VK_SAMPLE_COUNT_4_BIT);
	device->base.samples = wanted ? wanted : device->base.software || !(possible & VK_SAMPLE_COUNT_4_BIT) ? 1 : 4;
	if (!(possible & device->base.samples))
		return stilb_fail(STILB_ERROR_DEVICE, "GPU '%s' has no %u samples per pixel; use --msaa 1", device->base.name,
		                  device->base.samples);
	return STILB_OK;
}

static void vulkan_destroy(render_device *base)
{
	vulkan_device *device = (vulkan_device *)base;
	if (device->device) {
		/* vkDeviceWaitIdle may fail for want of memory: then the timeline is waited for. */
		if (vkDeviceWaitIdle(device->device) != VK_SUCCESS && device->timeline)
			vulkan_timeline_wait(device, device->timeline_value);
		vulkan_swapchain_destroy(device);
		vulkan_frames_destroy(device);
		vulkan_targets_destroy(device);
		for (int heap = 0; heap < RENDER_HEAPS; heap++)
			vulkan_buffer_destroy(device, &device->heaps[heap]);
		vulkan_pipeline_destroy(device);
		vulkan_textures_destroy(device);
		vkDestroyDevice(device->device, device->allocator);
	}
	vulkan_instance_destroy(device);
	free(device);
}

static stilb_result vulkan_resize(render_device *base, uint32_t width, uint32_t height)
{
	vulkan_device *device = (vulkan_device *)base;
	VkResult result = vkDeviceWaitIdle(device->device);
	if (result != VK_SUCCESS)
		return vulkan_fail(device, result, "wait for the GPU");
	vulkan_targets_destroy(device);
	for (int i = 0; i < VULKAN_SLOTS; i++) {
		vulkan_buffer_destroy(device, &device->slots[i].picture);
		device->slots[i].picture_valid = false;
	}
	base->width = width;
	base->height = height;
	device->swapchain.stale = true;
	device->drawn = false;
	stilb_result created = vulkan_targets_create(device);
	if (created != STILB_OK)
		vulkan_targets_destroy(device); /* frame_begin fails until a resize succeeds */
	return created;
}

/* A driver that draws on the CPU starts threads and compiles shaders with LLVM, which do not survive a lack of memory
 * (Mesa 22.3: a segmentation fault). Address space that starting the device, and making its pipelines, may need. */
#define DEVICE_START_BYTES ((size_t)1 << 26)
#define DEVICE_SHADER_BYTES ((size_t)1 << 24)

static stilb_result device_check_memory(const vulkan_device *device, size_t bytes)
{
	if (!device->base.software || !stilb_memory_is_scarce(bytes))
		return STILB_OK;
	return stilb_fail(STILB_ERROR_MEMORY,
	                  "no memory for the software driver: less than %zu MiB of address space are left; raise the limit "
	                  "that 'ulimit -v' shows",
	                  bytes >> 20);
}

static stilb_result device_start(vulkan_device *device, const stilb_render_desc *desc)
{
	stilb_result result = vulkan_instance_create(device, desc);
	if (result == STILB_OK)
		result = vulkan_gpu_select(device, desc->gpu);
	if (result == STILB_OK)
		result = device_check_memory(device, DEVICE_START_BYTES);
	if (result == STILB_OK)
		result = device_create(device);
	if (result == STILB_OK)
		result = device_choose_samples(device, desc->samples);
	if (result == STILB_OK)
		result = vulkan_targets_create(device);
	if (result == STILB_OK)
		result = vulkan_textures_create(device);
	if (result == STILB_OK)
		result = device_check_memory(device, DEVICE_SHADER_BYTES);
	if (result == STILB_OK)
		result = vulkan_pipeline_create(device);
	if (result == STILB_OK)
		result = vulkan_frames_create(device);
	if (result == STILB_OK && device->surface)
		result = vulkan_swapchain_create(device);
	return result;
}

stilb_result render_vulkan_create(const stilb_render_desc *desc, render_device **out)
{
	static const render_device_functions functions = {
		.destroy = vulkan_destroy,
		.resize = vulkan_resize,
		.frame_begin = vulkan_frame_begin,
		.grow = vulkan_grow,
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
	};
	vulkan_device *device = calloc(1, sizeof *device);
	if (!device)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the Vulkan device");
	device->base.functions = &functions;
	device->base.width = desc->width;
	device->base.height = desc->height;
	device->base.replay = desc->replay;
	device->base.materials = desc->materials;
	device->base.faults = desc->faults;
	device->base.in_window = desc->surface;
	device->allocator = vulkan_host_allocator;
	device->output = desc->output;
	device->packed = !desc->float_vertices;
	device->layout = render_layout_make(&stilb_scene_vertex_streams, device->packed);
	device->presentation = device->asked = desc->presentation;
	device->presents = desc->surface;
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
