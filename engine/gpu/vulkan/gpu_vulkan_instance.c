/* Error messages, the instance, validation, and the choice of a GPU. */
#include "gpu/vulkan/gpu_vulkan_internal.h"

#include <ctype.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define VULKAN_MAX_GPUS 32
#define VULKAN_MAX_EXTENSIONS 16
#define VULKAN_DRIVER_BYTES ((size_t)1 << 29) /* address space that loading a driver may need: Mesa's loads LLVM */

/* ---- errors ------------------------------------------------------------------------------------------------------ */

static const char *error_name(VkResult error)
{
	switch (error) {
	case VK_ERROR_OUT_OF_HOST_MEMORY:
		return "VK_ERROR_OUT_OF_HOST_MEMORY";
	case VK_ERROR_OUT_OF_DEVICE_MEMORY:
		return "VK_ERROR_OUT_OF_DEVICE_MEMORY";
	case VK_ERROR_INITIALIZATION_FAILED:
		return "VK_ERROR_INITIALIZATION_FAILED";
	case VK_ERROR_LAYER_NOT_PRESENT:
		return "VK_ERROR_LAYER_NOT_PRESENT";
	case VK_ERROR_EXTENSION_NOT_PRESENT:
		return "VK_ERROR_EXTENSION_NOT_PRESENT";
	case VK_ERROR_FEATURE_NOT_PRESENT:
		return "VK_ERROR_FEATURE_NOT_PRESENT";
	case VK_ERROR_INCOMPATIBLE_DRIVER:
		return "VK_ERROR_INCOMPATIBLE_DRIVER";
	case VK_ERROR_TOO_MANY_OBJECTS:
		return "VK_ERROR_TOO_MANY_OBJECTS";
	case VK_ERROR_FORMAT_NOT_SUPPORTED:
		return "VK_ERROR_FORMAT_NOT_SUPPORTED";
	case VK_ERROR_SURFACE_LOST_KHR:
		return "VK_ERROR_SURFACE_LOST_KHR";
	default:
		return "VkResult";
	}
}

stilb_result gpu_vulkan_fail(const gpu_vulkan *gpu, VkResult error, const char *what)
{
	STILB_ASSERT(error != VK_SUCCESS && what);
	stilb_result result = STILB_ERROR_DEVICE;
	if (error == VK_ERROR_DEVICE_LOST)
		return stilb_fail(STILB_ERROR_DEVICE_LOST,
		                  "cannot %s: device lost (VK_ERROR_DEVICE_LOST %d): GPU '%s' was reset or its driver failed, "
		                  "'dmesg' may say why; start again, or take another with --gpu",
		                  what, (int)error, gpu->base.name);
	if (error == VK_ERROR_SURFACE_LOST_KHR)
		return stilb_fail(STILB_ERROR_WINDOW, "cannot %s: the window or its display has gone (%s %d)", what,
		                  error_name(error), (int)error);
	if (error == VK_ERROR_OUT_OF_HOST_MEMORY || error == VK_ERROR_OUT_OF_DEVICE_MEMORY)
		result = STILB_ERROR_MEMORY;
	const char *advice = result == STILB_ERROR_MEMORY ? "; try fewer models or a smaller --size" : "";
	return stilb_fail(result, "cannot %s: %s (%s %d)%s", what, stilb_result_text(result), error_name(error), (int)error,
	                  advice);
}

/* The loader drops drivers that it cannot load, also those for which there is no memory. */
static stilb_result fail_no_driver(const char *call, VkResult error)
{
	if (error == VK_ERROR_OUT_OF_HOST_MEMORY || stilb_memory_is_scarce(VULKAN_DRIVER_BYTES))
		return stilb_fail(STILB_ERROR_MEMORY,
		                  "no memory to load a Vulkan driver (%s gives %d); raise the limit that 'ulimit -v' shows",
		                  call, (int)error);
	return stilb_fail(STILB_ERROR_DEVICE,
	                  "no Vulkan driver found (%s gives %d); install one, for example the software driver "
	                  "with 'apt install mesa-vulkan-drivers'",
	                  call, (int)error);
}

/* ---- instance ---------------------------------------------------------------------------------------------------- */

/* The layer (1.3.239) takes it for a mistake that a shader writes where a pass has no image, whose format is undefined.
 * Such writes are dropped: Vulkan 1.3, "Fragment Output Interface", of attachments whose view is VK_NULL_HANDLE. */
static bool message_is_of_none(const VkDebugUtilsMessengerCallbackDataEXT *data)
{
	return data->pMessageIdName && strstr(data->pMessageIdName, "Shader-InterfaceTypeMismatch") &&
	       strstr(data->pMessage, "VK_FORMAT_UNDEFINED");
}

/* The layer calls this on the thread that made the faulty call, any thread: so the counter is atomic. */
static VKAPI_ATTR VkBool32 VKAPI_CALL message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                              VkDebugUtilsMessageTypeFlagsEXT type,
                                              const VkDebugUtilsMessengerCallbackDataEXT *data, void *user)
{
	(void)severity, (void)type;
	STILB_ASSERT(user && data);
	gpu_vulkan *gpu = user;
	if (message_is_of_none(data))
		return VK_FALSE;
	__atomic_fetch_add(&gpu->base.validation_messages, 1, __ATOMIC_RELAXED); /* relaxed: only the number matters */
	stilb_log("validation: %s", data->pMessage);
	return VK_FALSE;
}

static VkDebugUtilsMessengerCreateInfoEXT messenger_info(gpu_vulkan *gpu)
{
	return (VkDebugUtilsMessengerCreateInfoEXT){
		.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
		.messageSeverity =
			VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
		.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
	                   VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT,
		.pfnUserCallback = message,
		.pUserData = gpu,
	};
}

static bool has_layer(const char *name)
{
	VkLayerProperties layers[64];
	uint32_t count = 64;
	vkEnumerateInstanceLayerProperties(&count, layers);
	for (uint32_t i = 0; i < count; i++)
		if (strcmp(layers[i].layerName, name) == 0)
			return true;
	return false;
}

/* True if RenderDoc captures frames of this process: it sets this variable, by which the loader finds its layer. */
static bool is_captured(void)
{
	const char *set = getenv("ENABLE_VULKAN_RENDERDOC_CAPTURE");
	return set && strcmp(set, "1") == 0;
}

/* Finds the functions that give names to objects and passes. */
static void names_create(gpu_vulkan *gpu)
{
	gpu->object_name =
		(PFN_vkSetDebugUtilsObjectNameEXT)vkGetInstanceProcAddr(gpu->instance, "vkSetDebugUtilsObjectNameEXT");
	gpu->label_begin =
		(PFN_vkCmdBeginDebugUtilsLabelEXT)vkGetInstanceProcAddr(gpu->instance, "vkCmdBeginDebugUtilsLabelEXT");
	gpu->label_end = (PFN_vkCmdEndDebugUtilsLabelEXT)vkGetInstanceProcAddr(gpu->instance, "vkCmdEndDebugUtilsLabelEXT");
	if (is_captured())
		gpu->label_insert =
			(PFN_vkCmdInsertDebugUtilsLabelEXT)vkGetInstanceProcAddr(gpu->instance, "vkCmdInsertDebugUtilsLabelEXT");
}

static VkResult messenger_create(gpu_vulkan *gpu)
{
	PFN_vkCreateDebugUtilsMessengerEXT create =
		(PFN_vkCreateDebugUtilsMessengerEXT)vkGetInstanceProcAddr(gpu->instance, "vkCreateDebugUtilsMessengerEXT");
	VkDebugUtilsMessengerCreateInfoEXT info = messenger_info(gpu);
	return create ? create(gpu->instance, &info, NULL, &gpu->messenger) : VK_ERROR_EXTENSION_NOT_PRESENT;
}

stilb_result gpu_vulkan_surface_create(gpu_vulkan *gpu, const stilb_gpu_surface *surface)
{
	STILB_ASSERT(!gpu->surface);
	uint64_t handle = 0;
	VkResult result = surface->create(surface->user, gpu->instance, &handle);
	if (result != VK_SUCCESS) {
		gpu_vulkan_fail(gpu, result, "make a Vulkan surface for the window");
		return STILB_ERROR_WINDOW;
	}
	memcpy(&gpu->surface, &handle, sizeof handle); /* a pointer, or a number on machines of 32 bits */
	return STILB_OK;
}

void gpu_vulkan_surface_destroy(gpu_vulkan *gpu)
{
	STILB_ASSERT(!gpu->swapchain.handle && "it is of this surface");
	if (gpu->surface)
		vkDestroySurfaceKHR(gpu->instance, gpu->surface, NULL);
	gpu->surface = VK_NULL_HANDLE;
	gpu->surface_lost = false;
}

stilb_result gpu_vulkan_instance_create(gpu_vulkan *gpu, const stilb_gpu_desc *desc)
{
	static const char *const layer = "VK_LAYER_KHRONOS_validation";
	VkApplicationInfo application = {
		.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
		.pApplicationName = "stilb",
		.pEngineName = "stilb",
		.apiVersion = VK_API_VERSION_1_3,
	};
	const char *extensions[VULKAN_MAX_EXTENSIONS];
	uint32_t extension_count = 0, wanted_count = 0;
	const char *const *wanted = NULL;
	if (desc->surface)
		wanted = desc->surface->extensions(desc->surface->user, &wanted_count);
	if (wanted_count >= VULKAN_MAX_EXTENSIONS)
		return stilb_fail(STILB_ERROR_WINDOW, "the window needs %u Vulkan extensions, Stilb passes on at most %u",
		                  wanted_count, VULKAN_MAX_EXTENSIONS - 1u);
	for (uint32_t i = 0; i < wanted_count; i++)
		extensions[extension_count++] = wanted[i];
	bool named = desc->validate || is_captured();
	if (named)
		extensions[extension_count++] = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
	if (desc->validate && !has_layer(layer))
		return stilb_fail(STILB_ERROR_DEVICE,
		                  "--validate needs the Vulkan validation layer; install it with 'apt install "
		                  "vulkan-validationlayers'");
	VkValidationFeatureEnableEXT enabled[] = {VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
	VkDebugUtilsMessengerCreateInfoEXT messenger = messenger_info(gpu);
	VkValidationFeaturesEXT features = {
		.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
		.pNext = &messenger,
		.enabledValidationFeatureCount = 1,
		.pEnabledValidationFeatures = enabled,
	};
	VkInstanceCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
		.pNext = desc->validate ? &features : NULL,
		.pApplicationInfo = &application,
		.enabledLayerCount = desc->validate,
		.ppEnabledLayerNames = &layer,
		.enabledExtensionCount = extension_count,
		.ppEnabledExtensionNames = extensions,
	};
	VkResult result = vkCreateInstance(&info, NULL, &gpu->instance);
	if (result == VK_ERROR_INCOMPATIBLE_DRIVER)
		return fail_no_driver("vkCreateInstance", result);
	if (result == VK_SUCCESS && named)
		names_create(gpu);
	if (result == VK_SUCCESS && desc->validate)
		result = messenger_create(gpu);
	if (result != VK_SUCCESS)
		return gpu_vulkan_fail(gpu, result, "start Vulkan");
	return desc->surface ? gpu_vulkan_surface_create(gpu, desc->surface) : STILB_OK;
}

/* Keeps the first instance that would be destroyed until the program ends, and returns true then. The loader unloads a
 * driver with its last instance, and not every driver can be loaded again: after a few rounds NVIDIA's (580.159) finds
 * no room for its thread-local variables, and the program has no driver any more. An instance with the validation layer
 * is not kept, since the layer would stay with it. */
static bool instance_keep(VkInstance instance)
{
	static _Atomic(VkInstance) kept;
	VkInstance none = VK_NULL_HANDLE;
	/* Relaxed: nobody reads what the instance points to by way of this word. */
	return atomic_compare_exchange_strong_explicit(&kept, &none, instance, memory_order_relaxed, memory_order_relaxed);
}

void gpu_vulkan_instance_destroy(gpu_vulkan *gpu)
{
	if (!gpu->instance)
		return;
	gpu_vulkan_surface_destroy(gpu);
	PFN_vkDestroyDebugUtilsMessengerEXT destroy =
		(PFN_vkDestroyDebugUtilsMessengerEXT)vkGetInstanceProcAddr(gpu->instance, "vkDestroyDebugUtilsMessengerEXT");
	if (gpu->messenger && destroy)
		destroy(gpu->instance, gpu->messenger, NULL);
	if (gpu->messenger || !instance_keep(gpu->instance))
		vkDestroyInstance(gpu->instance, NULL);
	gpu->instance = VK_NULL_HANDLE;
}

/* ---- GPUs -------------------------------------------------------------------------------------------------------- */

/* The first feature that Stilb needs and a GPU lacks; NULL: it has all. Shaders of surfaces name eight outputs, also
 * where a pass has fewer images. */
static const char *gpu_missing(VkPhysicalDevice gpu)
{
	VkPhysicalDeviceProperties properties;
	vkGetPhysicalDeviceProperties(gpu, &properties);
	if (properties.apiVersion < VK_API_VERSION_1_3)
		return "Vulkan 1.3";
	VkPhysicalDeviceVulkan13Features v13 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
	VkPhysicalDeviceVulkan12Features v12 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
	                                        .pNext = &v13};
	VkPhysicalDeviceFeatures2 features = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &v12};
	vkGetPhysicalDeviceFeatures2(gpu, &features);
	struct {
		VkBool32 there;
		const char *name;
	} needs[] = {
		{v13.dynamicRendering, "dynamicRendering"},
		{v13.synchronization2, "synchronization2"},
		{v12.bufferDeviceAddress, "bufferDeviceAddress"},
		{v12.timelineSemaphore, "timelineSemaphore"},
		{features.features.multiDrawIndirect, "multiDrawIndirect"},
		{features.features.drawIndirectFirstInstance, "drawIndirectFirstInstance"},
		{features.features.shaderInt64, "shaderInt64"},
		{properties.limits.maxColorAttachments >= STILB_GPU_MAX_COLORS &&
	         properties.limits.maxFragmentOutputAttachments >= STILB_GPU_MAX_COLORS,
	     "eight colour attachments"},
	};
	for (size_t i = 0; i < sizeof needs / sizeof *needs; i++)
		if (!needs[i].there)
			return needs[i].name;
	return NULL;
}

const char *gpu_vulkan_gpu_type_text(VkPhysicalDeviceType type)
{
	switch (type) {
	case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
		return "discrete GPU";
	case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
		return "integrated GPU";
	case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
		return "virtual GPU";
	case VK_PHYSICAL_DEVICE_TYPE_CPU:
		return "software";
	default:
		return "other";
	}
}

/* The GPU with the highest score is chosen; 0: it cannot run Stilb. */
static int gpu_score(VkPhysicalDevice gpu)
{
	static const int scores[] = {
		[VK_PHYSICAL_DEVICE_TYPE_OTHER] = 1,        [VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU] = 4,
		[VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU] = 5, [VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU] = 3,
		[VK_PHYSICAL_DEVICE_TYPE_CPU] = 2,
	};
	VkPhysicalDeviceProperties properties;
	vkGetPhysicalDeviceProperties(gpu, &properties);
	if (gpu_missing(gpu))
		return 0;
	/* A newer driver may report types that this header does not list. */
	return (size_t)properties.deviceType < sizeof scores / sizeof *scores ? scores[properties.deviceType] : 1;
}

/* The index of the GPU that `wanted` names: its number in the list, or a part of its name. A number that no list
 * reaches, as "4090", is a part of a name. If several match, or wanted is NULL, the best score decides. Returns count
 * if none matches. */
static uint32_t gpu_find(const VkPhysicalDevice *gpus, uint32_t count, const char *wanted)
{
	uint32_t best = count;
	char *end = NULL;
	if (wanted && isdigit((unsigned char)wanted[0])) {
		unsigned long number = strtoul(wanted, &end, 10);
		if (*end == '\0' && number < VULKAN_MAX_GPUS)
			return number < count ? (uint32_t)number : count;
	}
	for (uint32_t i = 0; i < count; i++) {
		VkPhysicalDeviceProperties properties;
		vkGetPhysicalDeviceProperties(gpus[i], &properties);
		if (wanted && !strcasestr(properties.deviceName, wanted))
			continue;
		if (best == count || gpu_score(gpus[i]) > gpu_score(gpus[best]))
			best = i;
	}
	return best;
}

stilb_result gpu_vulkan_gpu_select(gpu_vulkan *gpu, const char *wanted)
{
	VkPhysicalDevice gpus[VULKAN_MAX_GPUS];
	uint32_t count = VULKAN_MAX_GPUS;
	VkResult result = vkEnumeratePhysicalDevices(gpu->instance, &count, gpus);
	if ((result != VK_SUCCESS && result != VK_INCOMPLETE) || count == 0)
		return fail_no_driver("vkEnumeratePhysicalDevices", result);
	STILB_ASSERT(count <= VULKAN_MAX_GPUS);
	uint32_t found = gpu_find(gpus, count, wanted);
	if (found == count)
		return stilb_fail(STILB_ERROR_ARGUMENT, "there is no GPU '%s'; 'stilb info' lists the GPUs", wanted);
	gpu->physical = gpus[found];
	vkGetPhysicalDeviceProperties(gpu->physical, &gpu->properties);
	vkGetPhysicalDeviceMemoryProperties(gpu->physical, &gpu->memory);
	const char *missing = gpu_missing(gpu->physical);
	if (missing && is_captured())
		return stilb_fail(STILB_ERROR_DEVICE,
		                  "GPU '%s' under RenderDoc lacks %s: RenderDoc hides buffer addresses if the driver cannot "
		                  "give a buffer the same one again; capture on another GPU",
		                  gpu->properties.deviceName, missing);
	if (missing)
		return stilb_fail(STILB_ERROR_DEVICE, "GPU '%s' cannot run Stilb: it lacks %s; 'stilb info' lists the others",
		                  gpu->properties.deviceName, missing);
	snprintf(gpu->base.name, sizeof gpu->base.name, "%s", gpu->properties.deviceName);
	gpu->base.software = gpu->properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
	return STILB_OK;
}

static void gpu_describe(VkPhysicalDevice gpu, stilb_gpu_listed *out)
{
	VkPhysicalDeviceDriverProperties driver = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
	VkPhysicalDeviceProperties2 properties = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
	vkGetPhysicalDeviceProperties2(gpu, &properties);
	uint32_t version = properties.properties.apiVersion;
	if (version >= VK_API_VERSION_1_2) {
		properties.pNext = &driver;
		vkGetPhysicalDeviceProperties2(gpu, &properties);
	}
	VkPhysicalDeviceFeatures features;
	vkGetPhysicalDeviceFeatures(gpu, &features);
	*out = (stilb_gpu_listed){
		.bc = features.textureCompressionBC,
		.type = gpu_vulkan_gpu_type_text(properties.properties.deviceType),
		.missing = gpu_missing(gpu),
	};
	snprintf(out->name, sizeof out->name, "%s", properties.properties.deviceName);
	snprintf(out->driver, sizeof out->driver, "%.120s %.120s", driver.driverName, driver.driverInfo);
	snprintf(out->api_version, sizeof out->api_version, "%u.%u.%u", VK_API_VERSION_MAJOR(version),
	         VK_API_VERSION_MINOR(version), VK_API_VERSION_PATCH(version));
}

stilb_result stilb_gpu_list(stilb_gpu_listed *gpus, uint32_t capacity, uint32_t *count)
{
	VkPhysicalDevice devices[VULKAN_MAX_GPUS];
	uint32_t found = VULKAN_MAX_GPUS;
	gpu_vulkan gpu = {0};
	STILB_ASSERT(count && (gpus || capacity == 0));
	*count = 0;
	stilb_result result = gpu_vulkan_instance_create(&gpu, &(stilb_gpu_desc){0});
	if (result != STILB_OK)
		return result;
	VkResult listed = vkEnumeratePhysicalDevices(gpu.instance, &found, devices);
	if (listed != VK_SUCCESS && listed != VK_INCOMPLETE) {
		found = 0; /* on an error the array is not filled in */
		result = fail_no_driver("vkEnumeratePhysicalDevices", listed);
	}
	for (uint32_t i = 0; i < found && i < capacity; i++)
		gpu_describe(devices[i], &gpus[(*count)++]);
	gpu_vulkan_instance_destroy(&gpu);
	return result;
}

const char *stilb_gpu_vulkan_version(void)
{
	static char text[32];
	uint32_t version = VK_API_VERSION_1_0;
	vkEnumerateInstanceVersion(&version);
	snprintf(text, sizeof text, "%u.%u.%u", VK_API_VERSION_MAJOR(version), VK_API_VERSION_MINOR(version),
	         VK_API_VERSION_PATCH(version));
	return text;
}
