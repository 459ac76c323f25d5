/* Opening and closing a GPU. */
#include "gpu/vulkan/gpu_vulkan_internal.h"

#include <stdlib.h>
#include <string.h>

const VkAllocationCallbacks *gpu_vulkan_host_allocator;

/* The first queue family that can draw, and present if there is a window; UINT32_MAX: there is none. */
static uint32_t device_queue_family(const gpu_vulkan *gpu, uint32_t *timestamp_bits)
{
	VkQueueFamilyProperties families[32];
	uint32_t count = 32;
	vkGetPhysicalDeviceQueueFamilyProperties(gpu->physical, &count, families);
	for (uint32_t i = 0; i < count; i++) {
		VkBool32 shows = VK_TRUE;
		if (gpu->surface)
			vkGetPhysicalDeviceSurfaceSupportKHR(gpu->physical, i, gpu->surface, &shows);
		if ((families[i].queueFlags & VK_QUEUE_GRAPHICS_BIT) && shows) {
			*timestamp_bits = families[i].timestampValidBits;
			return i;
		}
	}
	return UINT32_MAX;
}

static bool device_has_extension(const gpu_vulkan *gpu, const char *name)
{
	uint32_t count = 0;
	vkEnumerateDeviceExtensionProperties(gpu->physical, NULL, &count, NULL);
	VkExtensionProperties *extensions = calloc(count, sizeof *extensions);
	bool found = false; /* stays false without memory: Stilb can do without every extension that is asked for here */
	if (extensions && vkEnumerateDeviceExtensionProperties(gpu->physical, NULL, &count, extensions) >= 0)
		for (uint32_t i = 0; i < count; i++)
			found |= strcmp(extensions[i].extensionName, name) == 0;
	free(extensions);
	return found;
}

static VkResult device_make(gpu_vulkan *gpu)
{
	static const float priority = 1.0f;
	const char *extensions[2];
	uint32_t extension_count = 0;
	if (gpu->surface)
		extensions[extension_count++] = VK_KHR_SWAPCHAIN_EXTENSION_NAME;
	gpu->calibrates = device_has_extension(gpu, VK_EXT_CALIBRATED_TIMESTAMPS_EXTENSION_NAME);
	if (gpu->calibrates)
		extensions[extension_count++] = VK_EXT_CALIBRATED_TIMESTAMPS_EXTENSION_NAME;
	/* What gpu.h has and the renderer does not need is taken where it is there. */
	VkPhysicalDeviceVulkan13Features can13 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
	VkPhysicalDeviceVulkan12Features can12 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
	                                          .pNext = &can13};
	VkPhysicalDeviceFeatures2 can = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &can12};
	vkGetPhysicalDeviceFeatures2(gpu->physical, &can);
	gpu->anisotropic = can.features.samplerAnisotropy;
	gpu->lines = can.features.fillModeNonSolid;
	gpu->counts = can.features.depthClamp;
	gpu->some_colors = can.features.independentBlend;
	VkPhysicalDeviceVulkan13Features v13 = {
		.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES,
		.dynamicRendering = VK_TRUE,
		.synchronization2 = VK_TRUE,
		.maintenance4 = can13.maintenance4, /* work group sizes as glslc writes them */
	};
	VkPhysicalDeviceVulkan12Features v12 = {
		.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
		.pNext = &v13,
		.bufferDeviceAddress = VK_TRUE,
		.timelineSemaphore = VK_TRUE,
		.shaderOutputLayer = can12.shaderOutputLayer,
	};
	VkPhysicalDeviceFeatures features = {
		.multiDrawIndirect = VK_TRUE,
		.drawIndirectFirstInstance = VK_TRUE,
		.fillModeNonSolid = can.features.fillModeNonSolid,
		.depthClamp = can.features.depthClamp,
		.samplerAnisotropy = can.features.samplerAnisotropy,
		.imageCubeArray = can.features.imageCubeArray,
		.textureCompressionBC = can.features.textureCompressionBC,
		.shaderInt64 = VK_TRUE,
		.independentBlend = can.features.independentBlend,
		.fragmentStoresAndAtomics = can.features.fragmentStoresAndAtomics,
		.vertexPipelineStoresAndAtomics = can.features.vertexPipelineStoresAndAtomics,
		.shaderStorageImageExtendedFormats = can.features.shaderStorageImageExtendedFormats,
	};
	VkDeviceQueueCreateInfo queue = {
		.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
		.queueFamilyIndex = gpu->queue_family,
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
	return vkCreateDevice(gpu->physical, &info, gpu->allocator, &gpu->device);
}

static stilb_result device_open(gpu_vulkan *gpu)
{
	uint32_t timestamp_bits = 0;
	gpu->queue_family = device_queue_family(gpu, &timestamp_bits);
	if (gpu->queue_family == UINT32_MAX)
		return stilb_fail(STILB_ERROR_WINDOW, "GPU '%s' cannot draw to this window; choose another with --gpu",
		                  gpu->base.name);
	VkResult result = device_make(gpu);
	if (result != VK_SUCCESS)
		return gpu_vulkan_fail(gpu, result, "open the GPU");
	vkGetDeviceQueue(gpu->device, gpu->queue_family, 0, &gpu->queue);
	if (timestamp_bits > 0 && gpu->properties.limits.timestampPeriod > 0.0f)
		gpu->timestamp_mask = UINT64_MAX >> (64 - timestamp_bits);
	return STILB_OK;
}

/* A driver that draws on the CPU starts threads and compiles shaders with LLVM, which do not survive a lack of memory
 * (Mesa 22.3: a segmentation fault). Address space that starting the device may need. */
#define DEVICE_START_BYTES ((size_t)1 << 26)

stilb_result gpu_vulkan_check_memory(const gpu_vulkan *gpu, size_t bytes)
{
	if (!gpu->base.software || !stilb_memory_is_scarce(bytes))
		return STILB_OK;
	return stilb_fail(STILB_ERROR_MEMORY,
	                  "no memory for the software driver: less than %zu MiB of address space are left; raise the limit "
	                  "that 'ulimit -v' shows",
	                  bytes >> 20);
}

static stilb_result device_start(gpu_vulkan *gpu, const stilb_gpu_desc *desc)
{
	stilb_result result = gpu_vulkan_instance_create(gpu, desc);
	if (result == STILB_OK)
		result = gpu_vulkan_gpu_select(gpu, desc->name);
	if (result == STILB_OK)
		result = gpu_vulkan_check_memory(gpu, DEVICE_START_BYTES);
	if (result == STILB_OK)
		result = device_open(gpu);
	if (result == STILB_OK) {
		VkResult locked = gpu_vulkan_once_create(gpu);
		if (locked == VK_SUCCESS)
			locked = gpu_vulkan_memory_create(gpu);
		result = locked == VK_SUCCESS ? STILB_OK : gpu_vulkan_fail(gpu, locked, "make the locks of the device");
	}
	if (result == STILB_OK)
		result = gpu_vulkan_frames_create(gpu);
	if (result == STILB_OK && gpu->surface)
		result = gpu_vulkan_swapchain_create(gpu);
	return result;
}

stilb_result gpu_vulkan_create(const stilb_gpu_desc *desc, VkExtent2D picture, gpu_vulkan **out)
{
	*out = NULL;
	gpu_vulkan *gpu = calloc(1, sizeof *gpu);
	if (!gpu)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the Vulkan device");
	gpu->base.faults = desc->faults;
	gpu->base.in_window = desc->surface;
	gpu->allocator = gpu_vulkan_host_allocator;
	gpu->presentation = gpu->asked = desc->presentation;
	gpu->presents = desc->surface;
	gpu->picture = picture;
	stilb_result result = device_start(gpu, desc);
	if (result == STILB_OK)
		*out = gpu;
	else
		gpu_vulkan_destroy(gpu);
	return result;
}

void gpu_vulkan_idle(gpu_vulkan *gpu)
{
	/* vkDeviceWaitIdle may fail for want of memory: then the timeline is waited for. */
	if (gpu->device && vkDeviceWaitIdle(gpu->device) != VK_SUCCESS && gpu->timeline)
		gpu_vulkan_timeline_wait(gpu, gpu->timeline_value);
}

void gpu_vulkan_destroy(gpu_vulkan *gpu)
{
	if (!gpu)
		return;
	if (gpu->device) {
		gpu_vulkan_idle(gpu);
		gpu_vulkan_swapchain_destroy(gpu);
		gpu_vulkan_frames_destroy(gpu);
		gpu_vulkan_memory_destroy(gpu);
		gpu_vulkan_once_destroy(gpu);
		vkDestroyDevice(gpu->device, gpu->allocator);
	}
	gpu_vulkan_instance_destroy(gpu);
	free(gpu);
}
