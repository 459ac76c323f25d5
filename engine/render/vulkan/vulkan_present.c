/* The picture to the window, or to memory. */
#include "render/vulkan/vulkan_internal.h"

#include "shading/shade_srgb.h"

#include <math.h>
#include <string.h>

stilb_result vulkan_set_surface(render_device *base, const stilb_gpu_surface *surface)
{
	return gpu_vulkan_set_surface(((vulkan_device *)base)->gpu, surface);
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
	vkCmdCopyImageToBuffer(slot->gpu->show, device->color.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
	                       slot->picture.buffer, 1, &region);
	gpu_vulkan_host_barrier(slot->gpu->show);
}

static stilb_result present_to_memory(vulkan_device *device, vulkan_slot *slot)
{
	PROFILE("show");
	stilb_result result = STILB_OK;
	if (!slot->picture.buffer)
		result = gpu_vulkan_buffer_create(
			device->gpu, (VkDeviceSize)device->base.width * device->base.height * picture_pixel_size(device),
			VK_BUFFER_USAGE_TRANSFER_DST_BIT, STILB_GPU_MEMORY_READ, &slot->picture);
	if (result == STILB_OK)
		result = gpu_vulkan_show_begin(device->gpu, slot->gpu);
	if (result != STILB_OK)
		return result;
	picture_copy(device, slot);
	result = gpu_vulkan_show_submit(device->gpu, slot->gpu, VK_NULL_HANDLE, VK_NULL_HANDLE);
	slot->picture_valid = result == STILB_OK;
	return result;
}

stilb_result vulkan_present(render_device *base)
{
	vulkan_device *device = (vulkan_device *)base;
	vulkan_slot *slot = vulkan_slot_now(device);
	if (!device->gpu->surface || device->gpu->surface_lost)
		return present_to_memory(device, slot);
	STILB_ASSERT(device->drawn);
	return gpu_vulkan_present_image(device->gpu, device->color.image, (VkExtent2D){base->width, base->height});
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
	stilb_result result = gpu_vulkan_timeline_wait(device->gpu, slot->gpu->done);
	if (result == STILB_OK && !slot->picture_valid) {
		/* The window's blit is done, so its command buffer is reused for the copy; a pool can only be reset as a
		 * whole. */
		VkResult reset = vkResetCommandPool(device->gpu->device, slot->gpu->pool, 0);
		result = reset == VK_SUCCESS ? present_to_memory(device, slot)
		                             : gpu_vulkan_fail(device->gpu, reset, "read the picture");
	}
	if (result == STILB_OK)
		result = gpu_vulkan_timeline_wait(device->gpu, slot->gpu->done);
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
