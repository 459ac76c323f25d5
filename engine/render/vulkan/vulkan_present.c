/* Copies the picture to the window, or to memory. */
#include "render/vulkan/vulkan_internal.h"

#include "shading/shade_srgb.h"

#include <math.h>
#include <string.h>

/* Limit of the wait for the window's next image, which a hidden window may never give: then the frame is not shown. */
#define PRESENT_TIMEOUT_NS 500000000u

/* ---- swapchain --------------------------------------------------------------------------------------------------- */

static bool swapchain_choose_format(vulkan_device *device, VkSurfaceFormatKHR *chosen)
{
	VkSurfaceFormatKHR formats[64];
	uint32_t count = 64;
	vkGetPhysicalDeviceSurfaceFormatsKHR(device->gpu, device->surface, &count, formats);
	for (uint32_t i = 0; i < count; i++) {
		bool srgb = formats[i].format == VK_FORMAT_B8G8R8A8_SRGB || formats[i].format == VK_FORMAT_R8G8B8A8_SRGB;
		VkFormatProperties properties;
		vkGetPhysicalDeviceFormatProperties(device->gpu, formats[i].format, &properties);
		if (srgb && formats[i].colorSpace == VK_COLOR_SPACE_SRGB_NONLINEAR_KHR &&
		    (properties.optimalTilingFeatures & VK_FORMAT_FEATURE_BLIT_DST_BIT)) {
			*chosen = formats[i];
			return true;
		}
	}
	return false;
}

static bool swapchain_offers(const vulkan_device *device, VkPresentModeKHR mode)
{
	VkPresentModeKHR modes[16];
	uint32_t count = 16;
	VkResult result = vkGetPhysicalDeviceSurfacePresentModesKHR(device->gpu, device->surface, &count, modes);
	for (uint32_t i = 0; i < count && (result == VK_SUCCESS || result == VK_INCOMPLETE); i++)
		if (modes[i] == mode)
			return true;
	return false;
}

/* The mode that was asked for, else FIFO, which is said once: from then on FIFO is what is asked for. */
static VkPresentModeKHR swapchain_choose_mode(vulkan_device *device)
{
	static const struct {
		VkPresentModeKHR mode;
		const char *name;
	} modes[] = {
		[STILB_RENDER_PRESENT_FIFO] = {VK_PRESENT_MODE_FIFO_KHR, "fifo"},
		[STILB_RENDER_PRESENT_MAILBOX] = {VK_PRESENT_MODE_MAILBOX_KHR, "mailbox"},
		[STILB_RENDER_PRESENT_IMMEDIATE] = {VK_PRESENT_MODE_IMMEDIATE_KHR, "immediate"},
	};
	STILB_ASSERT((size_t)device->presentation < sizeof modes / sizeof *modes);
	VkPresentModeKHR mode = modes[device->presentation].mode;
	if (mode != VK_PRESENT_MODE_FIFO_KHR && !swapchain_offers(device, mode)) {
		stilb_log("the window does not offer the presentation '%s'; going on with 'fifo'",
		          modes[device->presentation].name);
		device->presentation = STILB_RENDER_PRESENT_FIFO;
	}
	device->base.presentation = device->presentation;
	return modes[device->presentation].mode;
}

static uint32_t swapchain_clamp(uint32_t value, uint32_t low, uint32_t high)
{
	return value < low ? low : value > high ? high : value;
}

static VkExtent2D swapchain_extent(const vulkan_device *device, const VkSurfaceCapabilitiesKHR *can)
{
	if (can->currentExtent.width != UINT32_MAX)
		return can->currentExtent;
	return (VkExtent2D){
		swapchain_clamp(device->base.width, can->minImageExtent.width, can->maxImageExtent.width),
		swapchain_clamp(device->base.height, can->minImageExtent.height, can->maxImageExtent.height),
	};
}

static VkResult swapchain_make_semaphores(vulkan_device *device)
{
	VkSemaphoreCreateInfo semaphore = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
	VkResult result = VK_SUCCESS;
	for (uint32_t i = 0; i < device->swapchain.image_count && result == VK_SUCCESS; i++)
		result = vkCreateSemaphore(device->device, &semaphore, device->allocator, &device->swapchain.shown[i]);
	return result;
}

static VkResult swapchain_make(vulkan_device *device, const VkSurfaceCapabilitiesKHR *can, VkSurfaceFormatKHR format)
{
	vulkan_swapchain *swapchain = &device->swapchain;
	uint32_t wanted = can->minImageCount + 1;
	VkSwapchainCreateInfoKHR info = {
		.sType = VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR,
		.surface = device->surface,
		.minImageCount = can->maxImageCount && wanted > can->maxImageCount ? can->maxImageCount : wanted,
		.imageFormat = format.format,
		.imageColorSpace = format.colorSpace,
		.imageExtent = swapchain->extent,
		.imageArrayLayers = 1,
		.imageUsage = VK_IMAGE_USAGE_TRANSFER_DST_BIT,
		.preTransform = can->currentTransform,
		.compositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR,
		.presentMode = swapchain_choose_mode(device),
		.clipped = VK_TRUE,
	};
	VkResult result = vkCreateSwapchainKHR(device->device, &info, device->allocator, &swapchain->handle);
	if (result != VK_SUCCESS)
		return result;
	swapchain->image_count = VULKAN_MAX_SWAPCHAIN_IMAGES;
	result = vkGetSwapchainImagesKHR(device->device, swapchain->handle, &swapchain->image_count, swapchain->images);
	return result == VK_SUCCESS ? swapchain_make_semaphores(device) : result;
}

/* A window without area (minimised) gets no swapchain, which is not an error. */
stilb_result vulkan_swapchain_create(vulkan_device *device)
{
	STILB_ASSERT(device->surface && !device->swapchain.handle);
	VkSurfaceCapabilitiesKHR can;
	VkSurfaceFormatKHR format;
	VkResult result = vkGetPhysicalDeviceSurfaceCapabilitiesKHR(device->gpu, device->surface, &can);
	if (result != VK_SUCCESS)
		return vulkan_fail(device, result, "ask the window for its size");
	device->swapchain.extent = swapchain_extent(device, &can);
	device->swapchain.stale = false;
	if (device->swapchain.extent.width == 0 || device->swapchain.extent.height == 0)
		return STILB_OK;
	if (!(can.supportedUsageFlags & VK_IMAGE_USAGE_TRANSFER_DST_BIT) || !swapchain_choose_format(device, &format))
		return stilb_fail(STILB_ERROR_WINDOW, "GPU '%s' offers no 8-bit sRGB window; use --headless",
		                  device->base.name);
	result = swapchain_make(device, &can, format);
	return result == VK_SUCCESS ? STILB_OK : vulkan_fail(device, result, "make a swapchain");
}

void vulkan_swapchain_destroy(vulkan_device *device)
{
	vulkan_swapchain *swapchain = &device->swapchain;
	for (uint32_t i = 0; i < VULKAN_MAX_SWAPCHAIN_IMAGES; i++)
		vkDestroySemaphore(device->device, swapchain->shown[i], device->allocator);
	if (swapchain->handle)
		vkDestroySwapchainKHR(device->device, swapchain->handle, device->allocator);
	*swapchain = (vulkan_swapchain){0};
}

static stilb_result swapchain_renew(vulkan_device *device)
{
	VkResult result = vkDeviceWaitIdle(device->device);
	if (result != VK_SUCCESS)
		return vulkan_fail(device, result, "wait for the GPU");
	vulkan_swapchain_destroy(device);
	return vulkan_swapchain_create(device);
}

/* The surface is new: asks whether this GPU can present to it, and makes its swapchain. */
static stilb_result surface_use(vulkan_device *device)
{
	VkBool32 shows = VK_FALSE;
	VkResult result = vkGetPhysicalDeviceSurfaceSupportKHR(device->gpu, device->queue_family, device->surface, &shows);
	if (result != VK_SUCCESS)
		return vulkan_fail(device, result, "ask the window whether it can be drawn to");
	if (!shows)
		return stilb_fail(STILB_ERROR_WINDOW, "GPU '%s' cannot draw to this window", device->base.name);
	return vulkan_swapchain_create(device);
}

stilb_result vulkan_set_surface(render_device *base, const stilb_render_surface *surface)
{
	vulkan_device *device = (vulkan_device *)base;
	if (surface && !device->presents)
		return stilb_fail(STILB_ERROR_WINDOW,
		                  "the renderer was created without a window and cannot draw to one; create it with a surface");
	VkResult idle = vkDeviceWaitIdle(device->device);
	if (idle != VK_SUCCESS)
		return vulkan_fail(device, idle, "wait for the GPU");
	vulkan_swapchain_destroy(device);
	vulkan_surface_destroy(device);
	device->presentation = device->asked;
	stilb_result result = surface ? vulkan_surface_create(device, surface) : STILB_OK;
	if (result == STILB_OK && surface)
		result = surface_use(device);
	if (result != STILB_OK) {
		vulkan_swapchain_destroy(device);
		vulkan_surface_destroy(device);
	}
	base->in_window = device->surface;
	return result;
}

/* ---- to the window ----------------------------------------------------------------------------------------------- */

static stilb_result show_begin(vulkan_device *device, vulkan_slot *slot)
{
	VkCommandBufferBeginInfo begin = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
		.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT,
	};
	VkResult result = vkBeginCommandBuffer(slot->show, &begin);
	return result == VK_SUCCESS ? STILB_OK : vulkan_fail(device, result, "show a frame");
}

static stilb_result show_submit(vulkan_device *device, vulkan_slot *slot, VkSemaphore wait, VkSemaphore signal)
{
	VkResult result = vkEndCommandBuffer(slot->show);
	if (result != VK_SUCCESS)
		return vulkan_fail(device, result, "show a frame");
	stilb_result submitted = vulkan_queue_submit(device, slot->show, wait, signal);
	slot->done = device->timeline_value;
	return submitted;
}

/* Copies the picture to a window's image. While a window is being resized its size may differ for a frame or two, so
 * the blit scales. */
static void show_blit(vulkan_device *device, VkCommandBuffer commands, VkImage image)
{
	VkImageSubresourceLayers layers = {.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT, .layerCount = 1};
	VkExtent2D to = device->swapchain.extent;
	VkImageBlit2 region = {
		.sType = VK_STRUCTURE_TYPE_IMAGE_BLIT_2,
		.srcSubresource = layers,
		.srcOffsets = {{0, 0, 0}, {(int32_t)device->base.width, (int32_t)device->base.height, 1}},
		.dstSubresource = layers,
		.dstOffsets = {{0, 0, 0}, {(int32_t)to.width, (int32_t)to.height, 1}},
	};
	VkBlitImageInfo2 blit = {
		.sType = VK_STRUCTURE_TYPE_BLIT_IMAGE_INFO_2,
		.srcImage = device->color.image,
		.srcImageLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
		.dstImage = image,
		.dstImageLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
		.regionCount = 1,
		.pRegions = &region,
		.filter = VK_FILTER_NEAREST,
	};
	/* The submission waits for the acquired image at the transfer stage, so the layout must not change before it. */
	vulkan_image_barrier(commands, image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
	                     VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_NONE,
	                     VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT);
	vkCmdBlitImage2(commands, &blit);
	vulkan_image_barrier(commands, image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
	                     VK_IMAGE_LAYOUT_PRESENT_SRC_KHR, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
	                     VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_2_NONE, VK_ACCESS_2_NONE);
}

/* Acquires the window's next image: *image is its index. *skip: there is none now, do not present. */
static stilb_result present_acquire(vulkan_device *device, vulkan_slot *slot, uint32_t *image, bool *skip)
{
	PROFILE("acquire"); /* waits if all images of the window are in use */
	*skip = true;
	if (device->swapchain.stale || !device->swapchain.handle) {
		stilb_result result = swapchain_renew(device);
		if (result != STILB_OK || !device->swapchain.handle)
			return result;
	}
	VkResult result = render_fault_surface(&device->base)
	                      ? VK_ERROR_SURFACE_LOST_KHR
	                      : vkAcquireNextImageKHR(device->device, device->swapchain.handle, PRESENT_TIMEOUT_NS,
	                                              slot->acquired, VK_NULL_HANDLE, image);
	if (result == VK_ERROR_OUT_OF_DATE_KHR)
		device->swapchain.stale = true;
	if (result == VK_ERROR_OUT_OF_DATE_KHR || result == VK_TIMEOUT || result == VK_NOT_READY)
		return STILB_OK;
	if (result == VK_SUBOPTIMAL_KHR)
		device->swapchain.stale = true;
	else if (result != VK_SUCCESS)
		return vulkan_fail(device, result, "get the window's next image");
	*skip = false;
	return STILB_OK;
}

static stilb_result present_to_window(vulkan_device *device, vulkan_slot *slot)
{
	uint32_t image;
	bool skip;
	stilb_result result = present_acquire(device, slot, &image, &skip);
	if (result != STILB_OK || skip)
		return result;
	PROFILE("show");
	STILB_ASSERT(image < device->swapchain.image_count && device->drawn);
	VkSemaphore shown = device->swapchain.shown[image];
	result = show_begin(device, slot);
	if (result != STILB_OK)
		return result;
	show_blit(device, slot->show, device->swapchain.images[image]);
	result = show_submit(device, slot, slot->acquired, shown);
	if (result != STILB_OK)
		return result;
	VkPresentInfoKHR info = {
		.sType = VK_STRUCTURE_TYPE_PRESENT_INFO_KHR,
		.waitSemaphoreCount = 1,
		.pWaitSemaphores = &shown,
		.swapchainCount = 1,
		.pSwapchains = &device->swapchain.handle,
		.pImageIndices = &image,
	};
	PROFILE("queue present"); /* some drivers wait here until the GPU has drawn the picture */
	VkResult presented = vkQueuePresentKHR(device->queue, &info);
	if (presented == VK_ERROR_OUT_OF_DATE_KHR || presented == VK_SUBOPTIMAL_KHR)
		device->swapchain.stale = true;
	else if (presented != VK_SUCCESS)
		return vulkan_fail(device, presented, "show a frame in the window");
	return STILB_OK;
}

/* ---- to memory --------------------------------------------------------------------------------------------------- */

/* Bytes of a pixel of the picture: four channels. */
static uint32_t picture_pixel_size(const vulkan_device *device)
{
	return device->output == STILB_RENDER_OUTPUT_LINEAR ? 8 : 4;
}

static void picture_copy(vulkan_device *device, vulkan_slot *slot)
{
	VkBufferImageCopy region = {
		.imageSubresource = {.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT, .layerCount = 1},
		.imageExtent = {device->base.width, device->base.height, 1},
	};
	STILB_ASSERT(slot->picture.size ==
	             (VkDeviceSize)device->base.width * device->base.height * picture_pixel_size(device));
	vkCmdCopyImageToBuffer(slot->show, device->color.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, slot->picture.buffer,
	                       1, &region);
	vulkan_host_barrier(slot->show);
}

static stilb_result present_to_memory(vulkan_device *device, vulkan_slot *slot)
{
	PROFILE("show");
	stilb_result result = STILB_OK;
	if (!slot->picture.buffer)
		result = vulkan_buffer_create(
			device, (VkDeviceSize)device->base.width * device->base.height * picture_pixel_size(device),
			VK_BUFFER_USAGE_TRANSFER_DST_BIT, VULKAN_MEMORY_READBACK, &slot->picture);
	if (result == STILB_OK)
		result = show_begin(device, slot);
	if (result != STILB_OK)
		return result;
	picture_copy(device, slot);
	result = show_submit(device, slot, VK_NULL_HANDLE, VK_NULL_HANDLE);
	slot->picture_valid = result == STILB_OK;
	return result;
}

stilb_result vulkan_present(render_device *base)
{
	vulkan_device *device = (vulkan_device *)base;
	vulkan_slot *slot = vulkan_slot_now(device);
	if (!device->surface || device->surface_lost)
		return present_to_memory(device, slot);
	stilb_result result = present_to_window(device, slot);
	device->surface_lost = result == STILB_ERROR_WINDOW;
	return result;
}

/* Copies three of the four channels: the picture is opaque. */
static void picture_take(const vulkan_device *device, const vulkan_slot *slot, stilb_image *image)
{
	size_t from = picture_pixel_size(device), to = from / 4 * 3;
	size_t pixels = (size_t)image->width * image->height;
	const unsigned char *source = slot->picture.mapped;
	unsigned char *target = image->pixels;
	STILB_ASSERT(slot->picture_valid && pixels * from <= slot->picture.size && stilb_image_size(image) == pixels * to);
	for (size_t i = 0; i < pixels; i++)
		memcpy(target + i * to, source + i * from, to);
}

/* Copies all four channels. Where a pixel is partly covered its colour is premultiplied: codes are divided by alpha, as
 * linear light; radiance stays, as EXR files have it. */
static void picture_take_alpha(const vulkan_device *device, const vulkan_slot *slot, stilb_image *image)
{
	size_t size = stilb_image_size(image);
	STILB_ASSERT(slot->picture_valid && size <= slot->picture.size);
	memcpy(image->pixels, slot->picture.mapped, size);
	uint8_t *codes = image->pixels;
	for (size_t i = 0; i < size && device->output == STILB_RENDER_OUTPUT_DISPLAY; i += 4)
		for (size_t c = 0; c < 3 && codes[i + 3] > 0 && codes[i + 3] < 255; c++) {
			float light = shade_srgb_to_linear((float)codes[i + c] / 255.0f) * 255.0f / (float)codes[i + 3];
			codes[i + c] = (uint8_t)(shade_srgb_from_linear(fminf(light, 1.0f)) * 255.0f + 0.5f);
		}
}

stilb_result vulkan_read_image(render_device *base, stilb_image *image)
{
	vulkan_device *device = (vulkan_device *)base;
	vulkan_slot *slot = vulkan_slot_now(device);
	if (!device->drawn)
		return stilb_fail(STILB_ERROR_DEVICE, "no frame of this size has been drawn yet");
	stilb_result result = vulkan_timeline_wait(device, slot->done);
	if (result == STILB_OK && !slot->picture_valid) {
		/* The window's blit is done, so its command buffer is reused for the copy; a pool can only be reset as a
		 * whole. */
		VkResult reset = vkResetCommandPool(device->device, slot->pool, 0);
		result = reset == VK_SUCCESS ? present_to_memory(device, slot) : vulkan_fail(device, reset, "read the picture");
	}
	if (result == STILB_OK)
		result = vulkan_timeline_wait(device, slot->done);
	if (result == STILB_OK)
		result = stilb_image_create(image, base->width, base->height, device->transparent ? 4 : 3,
		                            device->output == STILB_RENDER_OUTPUT_LINEAR ? STILB_IMAGE_F16_LINEAR
		                                                                         : STILB_IMAGE_U8_SRGB);
	if (result == STILB_OK && device->transparent)
		picture_take_alpha(device, slot, image);
	else if (result == STILB_OK)
		picture_take(device, slot, image);
	return result;
}
