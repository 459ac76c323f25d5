/* The heaps of vertices, indices and materials on the GPU: buffers with the same contents at the same offsets. Dirty
 * ranges and new textures are copied through the slot's staging buffer, at the start of the frame's commands. */
#include "render/vulkan/vulkan_internal.h"

#include <stdlib.h>
#include <string.h>

#define HEAPS_TEXTURE_ALIGN 16u /* bytes: where a texture's pixels may start in the staging buffer; size of 4 floats */
/* Bytes; a larger staging buffer, as for a scene, is freed when a frame has used less than a quarter of it. */
#define HEAPS_STAGING_KEPT (16ull << 20)

static const VkBufferUsageFlags heap_usage[RENDER_HEAPS] = {
	[RENDER_HEAP_VERTICES] = VK_BUFFER_USAGE_VERTEX_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                             VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
	[RENDER_HEAP_INDICES] = VK_BUFFER_USAGE_INDEX_BUFFER_BIT,
	[RENDER_HEAP_INDICES_16] = VK_BUFFER_USAGE_INDEX_BUFFER_BIT,
	[RENDER_HEAP_MATERIALS] = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
};

/* ---- replaced buffers -------------------------------------------------------------------------------------------- */

stilb_result vulkan_buffer_retire(vulkan_device *device, gpu_vulkan_buffer *buffer)
{
	vulkan_slot *slot = vulkan_slot_now(device);
	if (!render_reserve((void **)&slot->outgrown, &slot->outgrown_capacity, slot->outgrown_count + 1,
	                    sizeof *slot->outgrown))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the list of outgrown buffers");
	slot->outgrown[slot->outgrown_count++] = *buffer;
	*buffer = (gpu_vulkan_buffer){0};
	return STILB_OK;
}

stilb_result vulkan_buffer_replace(vulkan_device *device, gpu_vulkan_buffer *buffer, gpu_vulkan_buffer with)
{
	STILB_ASSERT(with.buffer && with.buffer != buffer->buffer && with.size > buffer->size);
	stilb_result result = vulkan_buffer_retire(device, buffer);
	if (result == STILB_OK)
		*buffer = with;
	else
		gpu_vulkan_buffer_destroy(device->gpu, &with);
	return result;
}

void vulkan_heaps_frame(vulkan_device *device, vulkan_slot *slot)
{
	for (uint32_t b = 0; b < slot->outgrown_count; b++)
		gpu_vulkan_buffer_destroy(device->gpu, &slot->outgrown[b]);
	slot->outgrown_count = 0;
	if (slot->staging.size > HEAPS_STAGING_KEPT && slot->staging_used < slot->staging.size / 4)
		gpu_vulkan_buffer_destroy(device->gpu, &slot->staging);
	slot->staging_used = 0;
}

void vulkan_heaps_destroy_slot(vulkan_device *device, vulkan_slot *slot)
{
	vulkan_heaps_frame(device, slot);
	gpu_vulkan_buffer_destroy(device->gpu, &slot->staging);
	free(slot->outgrown);
	slot->outgrown = NULL;
	slot->outgrown_capacity = 0;
}

/* ---- materials that are bound one by one ------------------------------------------------------------------------- */

/* Materials are packed, except with --materials bind: then each offset must be a multiple of the GPU's alignment. */
VkDeviceSize vulkan_material_stride(const vulkan_device *device)
{
	VkDeviceSize size = sizeof(render_material), align = device->gpu->properties.limits.minStorageBufferOffsetAlignment;
	STILB_ASSERT(align > 0);
	return device->base.materials == STILB_RENDER_MATERIALS_BIND ? (size + align - 1) / align * align : size;
}

VkResult vulkan_material_sets_create(vulkan_device *device)
{
	if (device->base.materials != STILB_RENDER_MATERIALS_BIND)
		return VK_SUCCESS;
	VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER_DYNAMIC, STILB_GPU_FRAMES};
	VkDescriptorPoolCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
		.maxSets = STILB_GPU_FRAMES,
		.poolSizeCount = 1,
		.pPoolSizes = &size,
	};
	VkResult result =
		vkCreateDescriptorPool(device->gpu->device, &info, device->gpu->allocator, &device->material_pool);
	for (uint32_t i = 0; i < STILB_GPU_FRAMES && result == VK_SUCCESS; i++) {
		VkDescriptorSetAllocateInfo set = {
			.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
			.descriptorPool = device->material_pool,
			.descriptorSetCount = 1,
			.pSetLayouts = &device->material_layout,
		};
		result = vkAllocateDescriptorSets(device->gpu->device, &set, &device->slots[i].material_set);
	}
	return result;
}

/* Makes the slot's descriptor set refer to the current buffer of materials. The GPU does not read the set now: it has
 * finished the slot's last frame. */
static void material_set_update(vulkan_device *device, vulkan_slot *slot)
{
	VkBuffer materials = device->heaps[RENDER_HEAP_MATERIALS].buffer;
	if (!slot->material_set || slot->material_buffer == materials)
		return;
	VkDescriptorBufferInfo buffer = {.buffer = materials, .range = sizeof(render_material)};
	VkWriteDescriptorSet write = {
		.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
		.dstSet = slot->material_set,
		.descriptorCount = 1,
		.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER_DYNAMIC,
		.pBufferInfo = &buffer,
	};
	vkUpdateDescriptorSets(device->gpu->device, 1, &write, 0, NULL);
	slot->material_buffer = materials;
}

/* ---- heaps ------------------------------------------------------------------------------------------------------- */

/* Bytes from one element to the next on the GPU. */
static VkDeviceSize heap_stride(const vulkan_device *device, const render_heap *heap, int kind)
{
	return kind == RENDER_HEAP_MATERIALS ? vulkan_material_stride(device) : heap->element;
}

/* Replaces the buffer of a heap that has outgrown it, or will; then *all is true: the whole heap must be copied. */
static stilb_result heap_fit(vulkan_device *device, const render_resources *resources, int kind, bool *all)
{
	const render_heap *heap = &resources->heaps[kind];
	VkDeviceSize stride = heap_stride(device, heap, kind), size = heap->size * stride;
	VkDeviceSize expected = resources->expected[kind] * stride, wanted = size > expected ? size + size / 2 : expected;
	gpu_vulkan_buffer larger;
	*all = size > device->heaps[kind].size || (heap->size > 0 && expected > device->heaps[kind].size);
	if (!*all)
		return STILB_OK;
	stilb_result result = gpu_vulkan_buffer_create(
		device->gpu, wanted, heap_usage[kind] | VK_BUFFER_USAGE_TRANSFER_DST_BIT, STILB_GPU_MEMORY_DEVICE, &larger);
	return result == STILB_OK ? vulkan_buffer_replace(device, &device->heaps[kind], larger) : result;
}

static VkDeviceSize ranges_bytes(const render_ranges *ranges, VkDeviceSize stride)
{
	VkDeviceSize bytes = 0;
	for (uint32_t r = 0; r < ranges->count; r++)
		bytes += ranges->items[r].count * stride;
	return bytes;
}

/* Copies elements to staging memory, `stride` bytes apart. */
static void elements_write(uint8_t *to, VkDeviceSize stride, const uint8_t *from, uint32_t element, uint32_t count)
{
	STILB_ASSERT(stride >= element);
	if (stride == element) {
		memcpy(to, from, (size_t)count * element);
		return;
	}
	for (uint32_t i = 0; i < count; i++)
		memcpy(to + i * stride, from + (size_t)i * element, element);
}

/* Copies ranges of a heap to the GPU, through the staging buffer from byte `at` on; returns the end of the bytes
 * used. */
static VkDeviceSize heap_copy(vulkan_device *device, const render_heap *heap, int kind, const render_ranges *ranges,
                              VkDeviceSize at)
{
	vulkan_slot *slot = vulkan_slot_now(device);
	VkDeviceSize stride = heap_stride(device, heap, kind);
	for (uint32_t r = 0; r < ranges->count; r++) {
		render_range range = ranges->items[r];
		VkBufferCopy copy = {.srcOffset = at, .dstOffset = range.first * stride, .size = range.count * stride};
		STILB_ASSERT(at + copy.size <= slot->staging.size && copy.dstOffset + copy.size <= device->heaps[kind].size);
		elements_write((uint8_t *)slot->staging.mapped + at, stride, heap->data + (size_t)range.first * heap->element,
		               heap->element, range.count);
		vkCmdCopyBuffer(slot->gpu->draw, slot->staging.buffer, device->heaps[kind].buffer, 1, &copy);
		at += copy.size;
	}
	return at;
}

/* Orders this frame's copies to the heaps. before: they begin after the draws and copies of earlier frames have ended;
 * else they end before the draws of this frame begin. */
static void heaps_barrier(VkCommandBuffer commands, bool before)
{
	VkPipelineStageFlags2 readers = VK_PIPELINE_STAGE_2_VERTEX_INPUT_BIT | VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT |
	                                VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT;
	VkMemoryBarrier2 barrier = {
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

/* ---- the frame's copies ------------------------------------------------------------------------------------------ */

static stilb_result staging_fit(vulkan_device *device, vulkan_slot *slot, VkDeviceSize size)
{
	if (size <= slot->staging.size)
		return STILB_OK;
	gpu_vulkan_buffer_destroy(device->gpu, &slot->staging); /* unused: the GPU has finished the slot's last frame */
	return gpu_vulkan_buffer_create(device->gpu, size + size / 2, VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
	                                STILB_GPU_MEMORY_WRITE, &slot->staging);
}

static VkDeviceSize texture_row(const render_texture_upload *upload)
{
	return stilb_image_size(&upload->image) / upload->image.height;
}

/* Bytes of the frame's rows of a texture in the staging buffer, with padding. */
static VkDeviceSize texture_bytes(const render_texture_upload *upload)
{
	STILB_ASSERT(upload->sent >= upload->rows && upload->sent <= upload->image.height);
	VkDeviceSize size = texture_row(upload) * (upload->sent - upload->rows);
	return (size + HEAPS_TEXTURE_ALIGN - 1) / HEAPS_TEXTURE_ALIGN * HEAPS_TEXTURE_ALIGN;
}

/* Records all copies. Textures come first in the staging buffer: offset 0 has their alignment. */
static void update_copy(vulkan_device *device, const render_resources *resources, const render_ranges *dirty)
{
	vulkan_slot *slot = vulkan_slot_now(device);
	VkDeviceSize at = 0;
	heaps_barrier(slot->gpu->draw, true);
	for (uint32_t u = 0; u < resources->upload_count; u++) {
		const render_texture_upload *upload = &resources->uploads[u];
		STILB_ASSERT(at + texture_bytes(upload) <= slot->staging.size);
		if (upload->sent == upload->rows)
			continue;
		memcpy((uint8_t *)slot->staging.mapped + at,
		       (const uint8_t *)upload->image.pixels + upload->rows * texture_row(upload),
		       (upload->sent - upload->rows) * texture_row(upload));
		vulkan_texture_copy(device, upload, at);
		at += texture_bytes(upload);
	}
	for (int kind = 0; kind < RENDER_HEAPS; kind++)
		at = heap_copy(device, &resources->heaps[kind], kind, &dirty[kind], at);
	heaps_barrier(slot->gpu->draw, false);
}

stilb_result vulkan_update(render_device *base, const render_resources *resources)
{
	vulkan_device *device = (vulkan_device *)base;
	STILB_ASSERT_LOCKED(&resources->lock);
	vulkan_slot *slot = vulkan_slot_now(device);
	render_range whole[RENDER_HEAPS];
	render_ranges dirty[RENDER_HEAPS];
	VkDeviceSize bytes = 0;
	stilb_result result = STILB_OK;
	for (int kind = 0; kind < RENDER_HEAPS && result == STILB_OK; kind++) {
		const render_heap *heap = &resources->heaps[kind];
		bool all;
		result = heap_fit(device, resources, kind, &all);
		whole[kind] = (render_range){0, heap->size};
		dirty[kind] = all ? (render_ranges){&whole[kind], 1, 1} : heap->dirty;
		bytes += ranges_bytes(&dirty[kind], heap_stride(device, heap, kind));
	}
	if (result != STILB_OK)
		return result;
	material_set_update(device, slot);
	for (uint32_t u = 0; u < resources->upload_count; u++)
		bytes += texture_bytes(&resources->uploads[u]);
	slot->staging_used = bytes;
	if (bytes == 0)
		return STILB_OK;
	result = staging_fit(device, slot, bytes);
	if (result == STILB_OK)
		update_copy(device, resources, dirty);
	return result;
}
