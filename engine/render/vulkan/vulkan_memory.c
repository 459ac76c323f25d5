/* Buffers and images, each with an allocation of its own. */
#include "render/vulkan/vulkan_internal.h"

#include <stdio.h>
#include <string.h>

/* The memory type among `allowed` (a bit each) that has all flags of `required` and most of `preferred`; UINT32_MAX:
 * there is none. */
static uint32_t memory_type(const vulkan_device *device, uint32_t allowed, VkMemoryPropertyFlags required,
                            VkMemoryPropertyFlags preferred)
{
	uint32_t best = UINT32_MAX;
	int best_score = -1;
	for (uint32_t i = 0; i < device->memory.memoryTypeCount; i++) {
		VkMemoryPropertyFlags flags = device->memory.memoryTypes[i].propertyFlags;
		if (!(allowed & (1u << i)) || (flags & required) != required)
			continue;
		int score = __builtin_popcount(flags & preferred);
		if (score > best_score) {
			best = i;
			best_score = score;
		}
	}
	return best;
}

/* Allocates from the best memory type, and if that fails from the next best: a GPU's host-visible heap may be full. */
static VkResult memory_allocate(vulkan_device *device, VkMemoryRequirements needs, vulkan_memory_kind kind,
                                bool address, VkDeviceMemory *memory)
{
	static const VkMemoryPropertyFlags required[] = {
		[VULKAN_MEMORY_DEVICE] = 0,
		[VULKAN_MEMORY_WRITE] = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT,
		[VULKAN_MEMORY_SHARED] = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT,
		[VULKAN_MEMORY_READBACK] = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT,
	};
	static const VkMemoryPropertyFlags preferred[] = {
		[VULKAN_MEMORY_DEVICE] = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT,
		[VULKAN_MEMORY_WRITE] = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT,
		[VULKAN_MEMORY_SHARED] = VK_MEMORY_PROPERTY_HOST_CACHED_BIT,
		[VULKAN_MEMORY_READBACK] = VK_MEMORY_PROPERTY_HOST_CACHED_BIT,
	};
	VkMemoryAllocateFlagsInfo flags = {
		.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
		.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT,
	};
	VkMemoryAllocateInfo info = {
		.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
		.pNext = address ? &flags : NULL,
		.allocationSize = needs.size,
	};
	VkResult result = VK_ERROR_OUT_OF_DEVICE_MEMORY;
	STILB_ASSERT(needs.size > 0 && needs.memoryTypeBits && (uint32_t)kind <= VULKAN_MEMORY_READBACK);
	if (render_fault_allocation(&device->base))
		return result;
	uint32_t allowed = needs.memoryTypeBits, type;
	while ((type = memory_type(device, allowed, required[kind], preferred[kind])) != UINT32_MAX) {
		info.memoryTypeIndex = type;
		result = vkAllocateMemory(device->device, &info, device->allocator, memory);
		if (result == VK_SUCCESS)
			break;
		allowed &= ~(1u << type);
	}
	return result;
}

static VkResult memory_buffer_make(vulkan_device *device, VkBufferUsageFlags usage, vulkan_memory_kind kind,
                                   vulkan_buffer *buffer)
{
	bool address = usage & VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
	VkBufferCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
		.size = buffer->size,
		.usage = usage,
	};
	VkResult result = vkCreateBuffer(device->device, &info, device->allocator, &buffer->buffer);
	if (result != VK_SUCCESS)
		return result;
	VkMemoryRequirements needs;
	vkGetBufferMemoryRequirements(device->device, buffer->buffer, &needs);
	result = memory_allocate(device, needs, kind, address, &buffer->memory);
	if (result == VK_SUCCESS)
		result = vkBindBufferMemory(device->device, buffer->buffer, buffer->memory, 0);
	if (result == VK_SUCCESS && kind != VULKAN_MEMORY_DEVICE)
		result = vkMapMemory(device->device, buffer->memory, 0, VK_WHOLE_SIZE, 0, &buffer->mapped);
	if (result == VK_SUCCESS && address)
		buffer->address = vkGetBufferDeviceAddress(
			device->device, &(VkBufferDeviceAddressInfo){.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO,
		                                                 .buffer = buffer->buffer});
	return result;
}

stilb_result vulkan_buffer_create(vulkan_device *device, VkDeviceSize size, VkBufferUsageFlags usage,
                                  vulkan_memory_kind kind, vulkan_buffer *buffer)
{
	STILB_ASSERT(size > 0 && usage && "an empty buffer is not valid Vulkan");
	*buffer = (vulkan_buffer){.size = size};
	VkResult result = memory_buffer_make(device, usage, kind, buffer);
	if (result == VK_SUCCESS)
		return STILB_OK;
	vulkan_buffer_destroy(device, buffer);
	char what[96];
	if (size < 1 << 20)
		snprintf(what, sizeof what, "get %u KiB of GPU memory", (unsigned)((size + 1023) / 1024));
	else
		snprintf(what, sizeof what, "get %.1f MiB of GPU memory", (double)size / (1024.0 * 1024.0));
	return vulkan_fail(device, result, what);
}

void vulkan_buffer_destroy(vulkan_device *device, vulkan_buffer *buffer)
{
	vkDestroyBuffer(device->device, buffer->buffer, device->allocator);
	vkFreeMemory(device->device, buffer->memory, device->allocator); /* unmaps */
	*buffer = (vulkan_buffer){0};
}

static VkResult memory_image_make(vulkan_device *device, const VkImageCreateInfo *info, VkImageAspectFlags aspect,
                                  vulkan_image *image)
{
	VkResult result = vkCreateImage(device->device, info, device->allocator, &image->image);
	if (result != VK_SUCCESS)
		return result;
	VkMemoryRequirements needs;
	vkGetImageMemoryRequirements(device->device, image->image, &needs);
	result = memory_allocate(device, needs, VULKAN_MEMORY_DEVICE, false, &image->memory);
	if (result == VK_SUCCESS)
		result = vkBindImageMemory(device->device, image->image, image->memory, 0);
	VkImageViewCreateInfo view = {
		.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
		.image = image->image,
		.viewType = VK_IMAGE_VIEW_TYPE_2D,
		.format = info->format,
		.subresourceRange = {.aspectMask = aspect, .levelCount = 1, .layerCount = 1},
	};
	return result == VK_SUCCESS ? vkCreateImageView(device->device, &view, device->allocator, &image->view) : result;
}

VkResult vulkan_image_create(vulkan_device *device, const VkImageCreateInfo *info, VkImageAspectFlags aspect,
                             vulkan_image *image)
{
	STILB_ASSERT(info->extent.width > 0 && info->extent.height > 0 && aspect);
	*image = (vulkan_image){0};
	VkResult result = memory_image_make(device, info, aspect, image);
	if (result != VK_SUCCESS)
		vulkan_image_destroy(device, image);
	return result;
}

void vulkan_image_destroy(vulkan_device *device, vulkan_image *image)
{
	vkDestroyImageView(device->device, image->view, device->allocator);
	vkDestroyImage(device->device, image->image, device->allocator);
	vkFreeMemory(device->device, image->memory, device->allocator);
	*image = (vulkan_image){0};
}
