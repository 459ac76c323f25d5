/* Buffers and images, in blocks of memory that they share (gpu_memory_internal.h). */
#include "gpu/vulkan/gpu_vulkan_internal.h"

#include <stdio.h>
#include <string.h>

/* The memory type among `allowed` (a bit each) that has all flags of `required` and most of `preferred`; UINT32_MAX:
 * there is none. */
static uint32_t memory_type(const gpu_vulkan *gpu, uint32_t allowed, VkMemoryPropertyFlags required,
                            VkMemoryPropertyFlags preferred)
{
	uint32_t best = UINT32_MAX;
	int best_score = -1;
	for (uint32_t i = 0; i < gpu->memory.memoryTypeCount; i++) {
		VkMemoryPropertyFlags flags = gpu->memory.memoryTypes[i].propertyFlags;
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

/* ---- blocks ------------------------------------------------------------------------------------------------------ */

/* Pools: two for each type of memory. */
#define MEMORY_POOL(type, image) (2 * (type) + ((image) ? 1u : 0u))

/* Memory of a buffer pool can be read by address, and is mapped as long as it lives where the CPU can. */
static int32_t memory_block_make(void *user, uint32_t pool, uint64_t bytes, gpu_memory_handle *handle)
{
	gpu_vulkan *gpu = user;
	bool image = pool % 2 == 1;
	VkMemoryAllocateFlagsInfo flags = {
		.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
		.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT,
	};
	VkMemoryAllocateInfo info = {
		.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
		.pNext = image ? NULL : &flags,
		.allocationSize = bytes,
		.memoryTypeIndex = pool / 2,
	};
	VkDeviceMemory memory = VK_NULL_HANDLE;
	VkResult result = vkAllocateMemory(gpu->device, &info, gpu->allocator, &memory);
	if (result != VK_SUCCESS)
		return result;
	void *mapped = NULL;
	if (!image && gpu->memory.memoryTypes[pool / 2].propertyFlags & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT)
		result = vkMapMemory(gpu->device, memory, 0, VK_WHOLE_SIZE, 0, &mapped);
	if (result != VK_SUCCESS) {
		vkFreeMemory(gpu->device, memory, gpu->allocator);
		return result;
	}
	*handle = (gpu_memory_handle){(uint64_t)memory, mapped};
	return VK_SUCCESS;
}

static void memory_block_drop(void *user, gpu_memory_handle handle)
{
	const gpu_vulkan *gpu = user;
	vkFreeMemory(gpu->device, gpu_vulkan_memory_of(handle), gpu->allocator); /* unmaps */
}

VkResult gpu_vulkan_memory_create(gpu_vulkan *gpu)
{
	gpu_memory_source source = {gpu, memory_block_make, memory_block_drop, VK_ERROR_OUT_OF_HOST_MEMORY};
	if (!gpu_memory_init(&gpu->blocks, source))
		return VK_ERROR_OUT_OF_HOST_MEMORY;
	for (uint32_t type = 0; type < gpu->memory.memoryTypeCount; type++) {
		uint64_t heap = gpu->memory.memoryHeaps[gpu->memory.memoryTypes[type].heapIndex].size;
		gpu_memory_pool_set(&gpu->blocks, MEMORY_POOL(type, false), heap);
		gpu_memory_pool_set(&gpu->blocks, MEMORY_POOL(type, true), heap);
	}
	return VK_SUCCESS;
}

void gpu_vulkan_memory_destroy(gpu_vulkan *gpu)
{
	gpu_memory_finish(&gpu->blocks);
}

/* Takes memory of the best type, and if that fails of the next best: a GPU's host-visible heap may be full. */
static VkResult memory_allocate(gpu_vulkan *gpu, VkMemoryRequirements needs, stilb_gpu_memory kind, bool image,
                                gpu_memory_place *place)
{
	static const VkMemoryPropertyFlags required[] = {
		[STILB_GPU_MEMORY_DEVICE] = 0,
		[STILB_GPU_MEMORY_WRITE] = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT,
		[STILB_GPU_MEMORY_SHARED] = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT,
		[STILB_GPU_MEMORY_READ] = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT,
	};
	static const VkMemoryPropertyFlags preferred[] = {
		[STILB_GPU_MEMORY_DEVICE] = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT,
		[STILB_GPU_MEMORY_WRITE] = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT,
		[STILB_GPU_MEMORY_SHARED] = VK_MEMORY_PROPERTY_HOST_CACHED_BIT,
		[STILB_GPU_MEMORY_READ] = VK_MEMORY_PROPERTY_HOST_CACHED_BIT,
	};
	VkResult result = VK_ERROR_OUT_OF_DEVICE_MEMORY;
	STILB_ASSERT(needs.size > 0 && needs.memoryTypeBits && (uint32_t)kind <= STILB_GPU_MEMORY_READ);
	if (gpu_fault_allocation(&gpu->base))
		return result;
	uint32_t allowed = needs.memoryTypeBits, type;
	while ((type = memory_type(gpu, allowed, required[kind], preferred[kind])) != UINT32_MAX) {
		result = (VkResult)gpu_memory_take(&gpu->blocks, MEMORY_POOL(type, image), needs.size, needs.alignment, place);
		if (result == VK_SUCCESS)
			break;
		allowed &= ~(1u << type);
	}
	return result;
}

/* ---- buffers and images ------------------------------------------------------------------------------------------ */

static VkResult memory_buffer_make(gpu_vulkan *gpu, VkBufferUsageFlags usage, stilb_gpu_memory kind,
                                   gpu_vulkan_buffer *buffer)
{
	bool address = usage & VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
	VkBufferCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
		.size = buffer->size,
		.usage = usage,
	};
	VkResult result = vkCreateBuffer(gpu->device, &info, gpu->allocator, &buffer->buffer);
	if (result != VK_SUCCESS)
		return result;
	VkMemoryRequirements needs;
	vkGetBufferMemoryRequirements(gpu->device, buffer->buffer, &needs);
	result = memory_allocate(gpu, needs, kind, false, &buffer->place);
	if (result == VK_SUCCESS)
		result = vkBindBufferMemory(gpu->device, buffer->buffer, gpu_vulkan_memory_of(buffer->place.handle),
		                            buffer->place.offset);
	if (result == VK_SUCCESS && kind != STILB_GPU_MEMORY_DEVICE)
		buffer->mapped = buffer->place.mapped;
	if (result == VK_SUCCESS && address)
		buffer->address = vkGetBufferDeviceAddress(
			gpu->device, &(VkBufferDeviceAddressInfo){.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO,
		                                              .buffer = buffer->buffer});
	return result;
}

stilb_result gpu_vulkan_buffer_create(gpu_vulkan *gpu, VkDeviceSize size, VkBufferUsageFlags usage,
                                      stilb_gpu_memory kind, gpu_vulkan_buffer *buffer)
{
	STILB_ASSERT(size > 0 && usage && "an empty buffer is not valid Vulkan");
	*buffer = (gpu_vulkan_buffer){.size = size};
	VkResult result = memory_buffer_make(gpu, usage, kind, buffer);
	if (result == VK_SUCCESS)
		return STILB_OK;
	gpu_vulkan_buffer_destroy(gpu, buffer);
	char what[96];
	if (size < 1 << 20)
		snprintf(what, sizeof what, "get %u KiB of GPU memory", (unsigned)((size + 1023) / 1024));
	else
		snprintf(what, sizeof what, "get %.1f MiB of GPU memory", (double)size / (1024.0 * 1024.0));
	return gpu_vulkan_fail(gpu, result, what);
}

void gpu_vulkan_buffer_destroy(gpu_vulkan *gpu, gpu_vulkan_buffer *buffer)
{
	vkDestroyBuffer(gpu->device, buffer->buffer, gpu->allocator);
	gpu_memory_give(&gpu->blocks, &buffer->place);
	*buffer = (gpu_vulkan_buffer){0};
}

static VkResult memory_image_make(gpu_vulkan *gpu, const VkImageCreateInfo *info, VkImageAspectFlags aspect,
                                  gpu_vulkan_image *image)
{
	VkResult result = vkCreateImage(gpu->device, info, gpu->allocator, &image->image);
	if (result != VK_SUCCESS)
		return result;
	VkMemoryRequirements needs;
	vkGetImageMemoryRequirements(gpu->device, image->image, &needs);
	result = memory_allocate(gpu, needs, STILB_GPU_MEMORY_DEVICE, true, &image->place);
	if (result == VK_SUCCESS)
		result = vkBindImageMemory(gpu->device, image->image, gpu_vulkan_memory_of(image->place.handle),
		                           image->place.offset);
	VkImageViewCreateInfo view = {
		.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
		.image = image->image,
		.viewType = VK_IMAGE_VIEW_TYPE_2D,
		.format = info->format,
		.subresourceRange = {.aspectMask = aspect, .levelCount = 1, .layerCount = 1},
	};
	return result == VK_SUCCESS ? vkCreateImageView(gpu->device, &view, gpu->allocator, &image->view) : result;
}

VkResult gpu_vulkan_image_create(gpu_vulkan *gpu, const VkImageCreateInfo *info, VkImageAspectFlags aspect,
                                 gpu_vulkan_image *image)
{
	STILB_ASSERT(info->extent.width > 0 && info->extent.height > 0 && aspect);
	*image = (gpu_vulkan_image){0};
	VkResult result = memory_image_make(gpu, info, aspect, image);
	if (result != VK_SUCCESS)
		gpu_vulkan_image_destroy(gpu, image);
	return result;
}

void gpu_vulkan_image_destroy(gpu_vulkan *gpu, gpu_vulkan_image *image)
{
	vkDestroyImageView(gpu->device, image->view, gpu->allocator);
	vkDestroyImage(gpu->device, image->image, gpu->allocator);
	gpu_memory_give(&gpu->blocks, &image->place);
	*image = (gpu_vulkan_image){0};
}

/* ---- heaps of plans ---------------------------------------------------------------------------------------------- */

uint32_t gpu_vulkan_memory_heap(const gpu_vulkan *gpu, VkMemoryRequirements needs, bool image)
{
	uint32_t type = memory_type(gpu, needs.memoryTypeBits, 0, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
	STILB_ASSERT(type < VK_MAX_MEMORY_TYPES && "the GPU says in which types it can lie");
	return MEMORY_POOL(type, image);
}

VkResult gpu_vulkan_memory_take(gpu_vulkan *gpu, uint32_t heap, uint64_t bytes, uint64_t align, gpu_memory_place *place)
{
	if (gpu_fault_allocation(&gpu->base))
		return VK_ERROR_OUT_OF_DEVICE_MEMORY;
	return (VkResult)gpu_memory_take(&gpu->blocks, heap, bytes, align, place);
}
