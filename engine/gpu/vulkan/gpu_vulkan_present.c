/* Copies a picture to the window. */
#include "gpu/vulkan/gpu_vulkan_internal.h"

/* Limit of the wait for the window's next image, which a hidden window may never give: then the frame is not shown. */
#define PRESENT_TIMEOUT_NS 500000000u

/* ---- swapchain --------------------------------------------------------------------------------------------------- */

static bool swapchain_choose_format(gpu_vulkan *gpu, VkSurfaceFormatKHR *chosen)
{
	VkSurfaceFormatKHR formats[64];
	uint32_t count = 64;
	vkGetPhysicalDeviceSurfaceFormatsKHR(gpu->physical, gpu->surface, &count, formats);
	for (uint32_t i = 0; i < count; i++) {
		bool srgb = formats[i].format == VK_FORMAT_B8G8R8A8_SRGB || formats[i].format == VK_FORMAT_R8G8B8A8_SRGB;
		VkFormatProperties properties;
		vkGetPhysicalDeviceFormatProperties(gpu->physical, formats[i].format, &properties);
		if (srgb && formats[i].colorSpace == VK_COLOR_SPACE_SRGB_NONLINEAR_KHR &&
		    (properties.optimalTilingFeatures & VK_FORMAT_FEATURE_BLIT_DST_BIT)) {
			*chosen = formats[i];
			return true;
		}
	}
	return false;
}

static bool swapchain_offers(const gpu_vulkan *gpu, VkPresentModeKHR mode)
{
	VkPresentModeKHR modes[16];
	uint32_t count = 16;
	VkResult result = vkGetPhysicalDeviceSurfacePresentModesKHR(gpu->physical, gpu->surface, &count, modes);
	for (uint32_t i = 0; i < count && (result == VK_SUCCESS || result == VK_INCOMPLETE); i++)
		if (modes[i] == mode)
			return true;
	return false;
}

/* The mode that was asked for, else FIFO, which is said once: from then on FIFO is what is asked for. */
static VkPresentModeKHR swapchain_choose_mode(gpu_vulkan *gpu)
{
	static const struct {
		VkPresentModeKHR mode;
		const char *name;
	} modes[] = {
		[STILB_GPU_PRESENT_FIFO] = {VK_PRESENT_MODE_FIFO_KHR, "fifo"},
		[STILB_GPU_PRESENT_MAILBOX] = {VK_PRESENT_MODE_MAILBOX_KHR, "mailbox"},
		[STILB_GPU_PRESENT_IMMEDIATE] = {VK_PRESENT_MODE_IMMEDIATE_KHR, "immediate"},
	};
	STILB_ASSERT((size_t)gpu->presentation < sizeof modes / sizeof *modes);
	VkPresentModeKHR mode = modes[gpu->presentation].mode;
	if (mode != VK_PRESENT_MODE_FIFO_KHR && !swapchain_offers(gpu, mode)) {
		stilb_log("the window does not offer the presentation '%s'; going on with 'fifo'",
		          modes[gpu->presentation].name);
		gpu->presentation = STILB_GPU_PRESENT_FIFO;
	}
	gpu->base.presentation = gpu->presentation;
	return modes[gpu->presentation].mode;
}

static uint32_t swapchain_clamp(uint32_t value, uint32_t low, uint32_t high)
{
	return value < low ? low : value > high ? high : value;
}

static VkExtent2D swapchain_extent(const gpu_vulkan *gpu, const VkSurfaceCapabilitiesKHR *can)
{
	if (can->currentExtent.width != UINT32_MAX)
		return can->currentExtent;
	return (VkExtent2D){
		swapchain_clamp(gpu->picture.width, can->minImageExtent.width, can->maxImageExtent.width),
		swapchain_clamp(gpu->picture.height, can->minImageExtent.height, can->maxImageExtent.height),
	};
}

static VkResult swapchain_make_semaphores(gpu_vulkan *gpu)
{
	VkSemaphoreCreateInfo semaphore = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
	VkResult result = VK_SUCCESS;
	for (uint32_t i = 0; i < gpu->swapchain.image_count && result == VK_SUCCESS; i++)
		result = vkCreateSemaphore(gpu->device, &semaphore, gpu->allocator, &gpu->swapchain.shown[i]);
	return result;
}

static VkResult swapchain_make(gpu_vulkan *gpu, const VkSurfaceCapabilitiesKHR *can, VkSurfaceFormatKHR format)
{
	gpu_vulkan_swapchain *swapchain = &gpu->swapchain;
	uint32_t wanted = can->minImageCount + 1;
	VkSwapchainCreateInfoKHR info = {
		.sType = VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR,
		.surface = gpu->surface,
		.minImageCount = can->maxImageCount && wanted > can->maxImageCount ? can->maxImageCount : wanted,
		.imageFormat = format.format,
		.imageColorSpace = format.colorSpace,
		.imageExtent = swapchain->extent,
		.imageArrayLayers = 1,
		.imageUsage = VK_IMAGE_USAGE_TRANSFER_DST_BIT,
		.preTransform = can->currentTransform,
		.compositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR,
		.presentMode = swapchain_choose_mode(gpu),
		.clipped = VK_TRUE,
	};
	VkResult result = vkCreateSwapchainKHR(gpu->device, &info, gpu->allocator, &swapchain->handle);
	if (result != VK_SUCCESS)
		return result;
	swapchain->image_count = GPU_VULKAN_MAX_SWAPCHAIN_IMAGES;
	result = vkGetSwapchainImagesKHR(gpu->device, swapchain->handle, &swapchain->image_count, swapchain->images);
	return result == VK_SUCCESS ? swapchain_make_semaphores(gpu) : result;
}

/* A window without area (minimised) gets no swapchain, which is not an error. */
stilb_result gpu_vulkan_swapchain_create(gpu_vulkan *gpu)
{
	STILB_ASSERT(gpu->surface && !gpu->swapchain.handle);
	VkSurfaceCapabilitiesKHR can;
	VkSurfaceFormatKHR format;
	VkResult result = vkGetPhysicalDeviceSurfaceCapabilitiesKHR(gpu->physical, gpu->surface, &can);
	if (result != VK_SUCCESS)
		return gpu_vulkan_fail(gpu, result, "ask the window for its size");
	gpu->swapchain.extent = swapchain_extent(gpu, &can);
	gpu->swapchain.stale = false;
	if (gpu->swapchain.extent.width == 0 || gpu->swapchain.extent.height == 0)
		return STILB_OK;
	if (!(can.supportedUsageFlags & VK_IMAGE_USAGE_TRANSFER_DST_BIT) || !swapchain_choose_format(gpu, &format))
		return stilb_fail(STILB_ERROR_WINDOW, "GPU '%s' offers no 8-bit sRGB window; use --headless", gpu->base.name);
	result = swapchain_make(gpu, &can, format);
	return result == VK_SUCCESS ? STILB_OK : gpu_vulkan_fail(gpu, result, "make a swapchain");
}

void gpu_vulkan_swapchain_destroy(gpu_vulkan *gpu)
{
	gpu_vulkan_swapchain *swapchain = &gpu->swapchain;
	for (uint32_t i = 0; i < GPU_VULKAN_MAX_SWAPCHAIN_IMAGES; i++)
		vkDestroySemaphore(gpu->device, swapchain->shown[i], gpu->allocator);
	if (swapchain->handle)
		vkDestroySwapchainKHR(gpu->device, swapchain->handle, gpu->allocator);
	*swapchain = (gpu_vulkan_swapchain){0};
}

static stilb_result swapchain_renew(gpu_vulkan *gpu)
{
	VkResult result = vkDeviceWaitIdle(gpu->device);
	if (result != VK_SUCCESS)
		return gpu_vulkan_fail(gpu, result, "wait for the GPU");
	gpu_vulkan_swapchain_destroy(gpu);
	return gpu_vulkan_swapchain_create(gpu);
}

/* The surface is new: asks whether this GPU can present to it, and makes its swapchain. */
static stilb_result surface_use(gpu_vulkan *gpu)
{
	VkBool32 shows = VK_FALSE;
	VkResult result = vkGetPhysicalDeviceSurfaceSupportKHR(gpu->physical, gpu->queue_family, gpu->surface, &shows);
	if (result != VK_SUCCESS)
		return gpu_vulkan_fail(gpu, result, "ask the window whether it can be drawn to");
	if (!shows)
		return stilb_fail(STILB_ERROR_WINDOW, "GPU '%s' cannot draw to this window", gpu->base.name);
	return gpu_vulkan_swapchain_create(gpu);
}

stilb_result gpu_vulkan_set_surface(gpu_vulkan *gpu, const stilb_gpu_surface *surface)
{
	if (surface && !gpu->presents)
		return stilb_fail(STILB_ERROR_WINDOW,
		                  "the renderer was created without a window and cannot draw to one; create it with a surface");
	VkResult idle = vkDeviceWaitIdle(gpu->device);
	if (idle != VK_SUCCESS)
		return gpu_vulkan_fail(gpu, idle, "wait for the GPU");
	gpu_vulkan_swapchain_destroy(gpu);
	gpu_vulkan_surface_destroy(gpu);
	gpu->presentation = gpu->asked;
	stilb_result result = surface ? gpu_vulkan_surface_create(gpu, surface) : STILB_OK;
	if (result == STILB_OK && surface)
		result = surface_use(gpu);
	if (result != STILB_OK) {
		gpu_vulkan_swapchain_destroy(gpu);
		gpu_vulkan_surface_destroy(gpu);
	}
	gpu->base.in_window = gpu->surface;
	return result;
}

/* ---- to the window ----------------------------------------------------------------------------------------------- */

/* Copies the picture to a window's image. While a window is being resized its size may differ for a frame or two, so
 * the blit scales. */
static void show_blit(gpu_vulkan *gpu, VkCommandBuffer commands, VkImage picture, VkExtent2D size, VkImage image)
{
	VkImageSubresourceLayers layers = {.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT, .layerCount = 1};
	VkExtent2D to = gpu->swapchain.extent;
	VkImageBlit2 region = {
		.sType = VK_STRUCTURE_TYPE_IMAGE_BLIT_2,
		.srcSubresource = layers,
		.srcOffsets = {{0, 0, 0}, {(int32_t)size.width, (int32_t)size.height, 1}},
		.dstSubresource = layers,
		.dstOffsets = {{0, 0, 0}, {(int32_t)to.width, (int32_t)to.height, 1}},
	};
	VkBlitImageInfo2 blit = {
		.sType = VK_STRUCTURE_TYPE_BLIT_IMAGE_INFO_2,
		.srcImage = picture,
		.srcImageLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
		.dstImage = image,
		.dstImageLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
		.regionCount = 1,
		.pRegions = &region,
		.filter = VK_FILTER_NEAREST,
	};
	/* The submission waits for the acquired image at the transfer stage, so the layout must not change before it. */
	gpu_vulkan_image_barrier(commands, image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
	                         VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
	                         VK_ACCESS_2_NONE, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT);
	vkCmdBlitImage2(commands, &blit);
	gpu_vulkan_image_barrier(commands, image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
	                         VK_IMAGE_LAYOUT_PRESENT_SRC_KHR, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
	                         VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_2_NONE, VK_ACCESS_2_NONE);
}

/* Acquires the window's next image: *image is its index. *skip: there is none now, do not present. */
static stilb_result present_acquire(gpu_vulkan *gpu, gpu_vulkan_slot *slot, uint32_t *image, bool *skip)
{
	PROFILE("acquire"); /* waits if all images of the window are in use */
	*skip = true;
	if (gpu->swapchain.stale || !gpu->swapchain.handle) {
		stilb_result result = swapchain_renew(gpu);
		if (result != STILB_OK || !gpu->swapchain.handle)
			return result;
	}
	VkResult result = gpu_fault_surface(&gpu->base)
	                      ? VK_ERROR_SURFACE_LOST_KHR
	                      : vkAcquireNextImageKHR(gpu->device, gpu->swapchain.handle, PRESENT_TIMEOUT_NS,
	                                              slot->acquired, VK_NULL_HANDLE, image);
	if (result == VK_ERROR_OUT_OF_DATE_KHR)
		gpu->swapchain.stale = true;
	if (result == VK_ERROR_OUT_OF_DATE_KHR || result == VK_TIMEOUT || result == VK_NOT_READY)
		return STILB_OK;
	if (result == VK_SUBOPTIMAL_KHR)
		gpu->swapchain.stale = true;
	else if (result != VK_SUCCESS)
		return gpu_vulkan_fail(gpu, result, "get the window's next image");
	*skip = false;
	return STILB_OK;
}

static stilb_result present_to_window(gpu_vulkan *gpu, VkImage picture, VkExtent2D size)
{
	gpu_vulkan_slot *slot = gpu_vulkan_slot_now(gpu);
	uint32_t image;
	bool skip;
	stilb_result result = present_acquire(gpu, slot, &image, &skip);
	if (result != STILB_OK || skip)
		return result;
	PROFILE("show");
	STILB_ASSERT(image < gpu->swapchain.image_count);
	VkSemaphore shown = gpu->swapchain.shown[image];
	result = gpu_vulkan_show_begin(gpu, slot);
	if (result != STILB_OK)
		return result;
	show_blit(gpu, slot->show, picture, size, gpu->swapchain.images[image]);
	result = gpu_vulkan_show_submit(gpu, slot, slot->acquired, shown);
	if (result != STILB_OK)
		return result;
	VkPresentInfoKHR info = {
		.sType = VK_STRUCTURE_TYPE_PRESENT_INFO_KHR,
		.waitSemaphoreCount = 1,
		.pWaitSemaphores = &shown,
		.swapchainCount = 1,
		.pSwapchains = &gpu->swapchain.handle,
		.pImageIndices = &image,
	};
	PROFILE("queue present"); /* some drivers wait here until the GPU has drawn the picture */
	VkResult presented = vkQueuePresentKHR(gpu->queue, &info);
	if (presented == VK_ERROR_OUT_OF_DATE_KHR || presented == VK_SUBOPTIMAL_KHR)
		gpu->swapchain.stale = true;
	else if (presented != VK_SUCCESS)
		return gpu_vulkan_fail(gpu, presented, "show a frame in the window");
	return STILB_OK;
}

stilb_result gpu_vulkan_present_image(gpu_vulkan *gpu, VkImage image, VkExtent2D size)
{
	STILB_ASSERT(gpu->surface && !gpu->surface_lost && image);
	if (size.width != gpu->picture.width || size.height != gpu->picture.height)
		gpu->swapchain.stale = true;
	gpu->picture = size;
	stilb_result result = present_to_window(gpu, image, size);
	gpu->surface_lost = result == STILB_ERROR_WINDOW;
	return result;
}
