/* The heaps of vertices, indices and materials on the GPU: each a buffer with the same contents in the same places. What is
 * dirty is copied through the slot's staging buffer, at the start of the frame's commands. */
#include "render/vulkan/vulkan_internal.h"

#include <string.h>

static const VkBufferUsageFlags heap_usage[RENDER_HEAPS] = {
	[RENDER_HEAP_VERTICES] = VK_BUFFER_USAGE_VERTEX_BUFFER_BIT,
	[RENDER_HEAP_INDICES] = VK_BUFFER_USAGE_INDEX_BUFFER_BIT,
	[RENDER_HEAP_MATERIALS] = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
};

void vulkan_heaps_frame(vulkan_device *device, vulkan_slot *slot)
{
	for (int heap = 0; heap < RENDER_HEAPS; heap++)
		vulkan_buffer_destroy(device, &slot->replaced[heap]);
}

void vulkan_heaps_destroy_slot(vulkan_device *device, vulkan_slot *slot)
{
	vulkan_heaps_frame(device, slot);
	vulkan_buffer_destroy(device, &slot->staging);
}

/* Replaces the buffer of a heap that has outgrown it; frames in flight may still read the old one. *all says that all of the
 * heap must be copied. */
static stilb_result heap_fit(vulkan_device *device, vulkan_slot *slot, int kind, const render_heap *heap, bool *all)
{
	VkDeviceSize size = (VkDeviceSize)heap->size * heap->element;
	vulkan_buffer *buffer = &device->heaps[kind], larger;
	*all = size > buffer->size;
	if (!*all)
		return STILB_OK;
	stilb_result result = vulkan_buffer_create(
		device, size + size / 2, heap_usage[kind] | VK_BUFFER_USAGE_TRANSFER_DST_BIT, VULKAN_MEMORY_DEVICE, &larger);
	if (result != STILB_OK)
		return result;
	vulkan_buffer_destroy(device, &slot->replaced[kind]); /* empty, but for a frame that failed here before */
	slot->replaced[kind] = *buffer;
	*buffer = larger;
	return STILB_OK;
}

static VkDeviceSize ranges_bytes(const render_ranges *ranges, uint32_t element)
{
	VkDeviceSize bytes = 0;
	for (uint32_t r = 0; r < ranges->count; r++)
		bytes += (VkDeviceSize)ranges->items[r].count * element;
	return bytes;
}

/* Copies ranges of a heap through the staging buffer from `at` on, and moves `at` behind them. */
static void heap_copy(vulkan_slot *slot, const render_heap *heap, const render_ranges *ranges, VkBuffer to,
                      VkDeviceSize *at)
{
	for (uint32_t r = 0; r < ranges->count; r++) {
		VkDeviceSize first = (VkDeviceSize)ranges->items[r].first * heap->element;
		VkDeviceSize size = (VkDeviceSize)ranges->items[r].count * heap->element;
		memcpy((uint8_t *)slot->staging.mapped + *at, heap->data + first, size);
		vkCmdCopyBuffer(slot->draw, slot->staging.buffer, to, 1,
		                &(VkBufferCopy){.srcOffset = *at, .dstOffset = first, .size = size});
		*at += size;
	}
}

/* Nothing on the GPU reads what the copies write meanwhile: the draws of frames before, and then those of this one. */
static void heaps_barrier(VkCommandBuffer commands, bool before)
{
	const VkPipelineStageFlags2 readers = VK_PIPELINE_STAGE_2_VERTEX_INPUT_BIT | VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT |
	                                      VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT;
	const VkMemoryBarrier2 barrier = {
		.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
		.srcStageMask = before ? readers | VK_PIPELINE_STAGE_2_COPY_BIT : VK_PIPELINE_STAGE_2_COPY_BIT,
		.srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT,
		.dstStageMask = before ? VK_PIPELINE_STAGE_2_COPY_BIT : readers,
		.dstAccessMask = before ? VK_ACCESS_2_TRANSFER_WRITE_BIT : VK_ACCESS_2_MEMORY_READ_BIT,
	};
	vkCmdPipelineBarrier2(commands, &(VkDependencyInfo){.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
	                                                    .memoryBarrierCount = 1,
	                                                    .pMemoryBarriers = &barrier});
}

static stilb_result staging_fit(vulkan_device *device, vulkan_slot *slot, VkDeviceSize size)
{
	if (size <= slot->staging.size)
		return STILB_OK;
	vulkan_buffer_destroy(device, &slot->staging); /* the slot's last frame is done */
	return vulkan_buffer_create(device, size, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, VULKAN_MEMORY_WRITE, &slot->staging);
}

stilb_result vulkan_update(render_device *base, const render_resources *resources)
{
	vulkan_device *device = (vulkan_device *)base;
	vulkan_slot *slot = vulkan_slot_now(device);
	render_range whole[RENDER_HEAPS];
	render_ranges dirty[RENDER_HEAPS];
	VkDeviceSize bytes = 0, at = 0;
	stilb_result result = STILB_OK;
	for (int kind = 0; kind < RENDER_HEAPS && result == STILB_OK; kind++) {
		const render_heap *heap = &resources->heaps[kind];
		bool all;
		result = heap_fit(device, slot, kind, heap, &all);
		whole[kind] = (render_range){0, heap->size};
		dirty[kind] = all ? (render_ranges){&whole[kind], 1, 1} : heap->dirty;
		bytes += ranges_bytes(&dirty[kind], heap->element);
	}
	if (result != STILB_OK || bytes == 0)
		return result;
	result = staging_fit(device, slot, bytes);
	if (result != STILB_OK)
		return result;
	heaps_barrier(slot->draw, true);
	for (int kind = 0; kind < RENDER_HEAPS; kind++)
		heap_copy(slot, &resources->heaps[kind], &dirty[kind], device->heaps[kind].buffer, &at);
	heaps_barrier(slot->draw, false);
	return STILB_OK;
}

stilb_result vulkan_texture_create(render_device *base, uint32_t texture, const stilb_image *image)
{
	(void)base, (void)texture, (void)image;
	return stilb_fail(STILB_ERROR_DEVICE, "the Vulkan device has no textures yet");
}

void vulkan_texture_destroy(render_device *base, uint32_t texture)
{
	(void)base, (void)texture;
}
