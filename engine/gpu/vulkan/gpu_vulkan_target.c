/* What stands for a plan's resources: images and buffers that stay from frame to frame, those that share memory, and
 * the program's own. */
#include "gpu/vulkan/gpu_vulkan_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- what is not needed any more --------------------------------------------------------------------------------- */

static void trash_destroy(gpu_vulkan *gpu, gpu_vulkan_trash *item)
{
	gpu_vulkan_texels_destroy(gpu, &item->texels);
	gpu_vulkan_buffer_destroy(gpu, &item->buffer);
	gpu_memory_give(&gpu->blocks, &item->place);
}

void gpu_vulkan_trash_add(gpu_vulkan *gpu, gpu_vulkan_trash item)
{
	gpu_vulkan_slot *slot = gpu_vulkan_slot_now(gpu);
	if (slot->trash_count == slot->trash_capacity) {
		uint32_t capacity = slot->trash_capacity ? 2 * slot->trash_capacity : 16;
		gpu_vulkan_trash *grown = realloc(slot->trash, capacity * sizeof *grown);
		if (!grown) {
			gpu_vulkan_timeline_wait(gpu, gpu->timeline_value);
			trash_destroy(gpu, &item);
			return;
		}
		slot->trash = grown;
		slot->trash_capacity = capacity;
	}
	slot->trash[slot->trash_count++] = item;
}

void gpu_vulkan_trash_empty(gpu_vulkan *gpu, gpu_vulkan_slot *slot)
{
	for (uint32_t i = 0; i < slot->trash_count; i++)
		trash_destroy(gpu, &slot->trash[i]);
	slot->trash_count = 0;
}

static bool extent_is(const stilb_gpu_extent *a, const stilb_gpu_extent *b)
{
	return a->format == b->format && a->shape == b->shape && a->width == b->width && a->height == b->height &&
	       a->depth == b->depth && a->layers == b->layers && a->mips == b->mips && a->samples == b->samples &&
	       a->uses == b->uses;
}

/* Makes *array have `count` elements, the new ones 0. */
static bool target_reserve(void **array, uint32_t *capacity, uint32_t count, size_t size)
{
	if (count <= *capacity)
		return true;
	uint32_t larger = count + count / 2 + 8;
	void *grown = realloc(*array, larger * size);
	if (!grown)
		return false;
	memset((char *)grown + *capacity * size, 0, (larger - *capacity) * size);
	*array = grown;
	*capacity = larger;
	return true;
}

#define BUFFER_USES                                                                                                    \
	(VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |                                  \
	 VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_VERTEX_BUFFER_BIT | VK_BUFFER_USAGE_INDEX_BUFFER_BIT |       \
	 VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT)

static stilb_result target_fail(const gpu_vulkan *gpu, VkResult error, const char *name)
{
	char what[GPU_NAME + 64];
	if (error == VK_ERROR_FORMAT_NOT_SUPPORTED)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "image '%s' of the plan: '%s' has no such image with these sizes, samples and uses", name,
		                  gpu->base.name);
	snprintf(what, sizeof what, "make '%.*s' of the plan", (int)GPU_NAME, name);
	return gpu_vulkan_fail(gpu, error, what);
}

/* ---- resources that stay ----------------------------------------------------------------------------------------- */

/* All that an image that stays may be used for: the next frame's plan may differ. */
static stilb_gpu_extent stay_extent(const gpu_vulkan *gpu, const stilb_gpu_extent *extent)
{
	stilb_gpu_extent all = *extent;
	uint32_t uses = gpu->base.formats[extent->format] & (2 * STILB_GPU_EXTENT_ATTACHMENT - 1);
	uint32_t storage =
		1u << STILB_GPU_USE_STORAGE_READ | 1u << STILB_GPU_USE_STORAGE_WRITE | 1u << STILB_GPU_USE_STORAGE;
	if (extent->samples > 1)
		uses &= ~storage;
	if (extent->shape == STILB_GPU_SHAPE_3D || extent->shape == STILB_GPU_SHAPE_1D)
		uses &= ~STILB_GPU_EXTENT_ATTACHMENT | extent->uses;
	all.uses = (uint16_t)uses;
	return all;
}

static void stay_drop(gpu_vulkan *gpu, gpu_vulkan_stay *stay)
{
	for (int i = 0; i < 2; i++)
		if (stay->texels[i].image || stay->buffers[i].buffer)
			gpu_vulkan_trash_add(gpu, (gpu_vulkan_trash){.texels = stay->texels[i], .buffer = stay->buffers[i]});
	*stay = (gpu_vulkan_stay){0};
}

static stilb_result stay_make(gpu_vulkan *gpu, gpu_vulkan_stay *stay, uint32_t which, const char *name)
{
	if (stay->texels[which].image || stay->buffers[which].buffer)
		return STILB_OK;
	if (stay->extent.format == STILB_GPU_NONE)
		return gpu_vulkan_buffer_create(gpu, stay->bytes, BUFFER_USES, STILB_GPU_MEMORY_DEVICE, &stay->buffers[which]);
	VkResult result = gpu_vulkan_texels_create(gpu, name, &stay->extent, NULL, 0, &stay->texels[which]);
	return result == VK_SUCCESS ? STILB_OK : target_fail(gpu, result, name);
}

static stilb_result stay_take(gpu_vulkan *gpu, const stilb_gpu_placed *placed, const char *name)
{
	if (placed->stay > UINT32_MAX / 2 ||
	    !target_reserve((void **)&gpu->stays, &gpu->stay_capacity, (uint32_t)placed->stay + 1, sizeof *gpu->stays))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for '%s' of the plan", name);
	gpu_vulkan_stay *stay = &gpu->stays[placed->stay];
	bool image = placed->extent.format != STILB_GPU_NONE;
	stilb_gpu_extent extent = image ? stay_extent(gpu, &placed->extent) : placed->extent;
	bool same = image ? extent_is(&stay->extent, &extent)
	                  : stay->extent.format == STILB_GPU_NONE && stay->bytes == placed->bytes;
	if (!same)
		stay_drop(gpu, stay);
	stay->extent = extent;
	stay->bytes = placed->bytes;
	stay->frame = gpu->base.frame;
	stilb_result result = stay_make(gpu, stay, stay->now, name);
	if (result == STILB_OK && placed->two)
		result = stay_make(gpu, stay, 1 - stay->now, name);
	return result;
}

/* ---- shared memory ----------------------------------------------------------------------------------------------- */

/* Makes the plan's heaps large enough. */
static stilb_result heaps_fit(gpu_vulkan *gpu, const stilb_gpu_plan *plan)
{
	uint32_t count = stilb_gpu_plan_heaps(plan);
	for (uint32_t h = 0; h < count; h++) {
		gpu_vulkan_heap *heap = &gpu->heaps[h];
		uint64_t bytes = stilb_gpu_plan_heap_bytes(plan, h);
		if (bytes <= heap->place.bytes)
			continue;
		gpu_memory_place place;
		uint64_t align = gpu->properties.limits.bufferImageGranularity;
		align = align > 65536 ? align : 65536;
		VkResult result = gpu_vulkan_memory_take(gpu, h, bytes, align, &place);
		if (result != VK_SUCCESS)
			return gpu_vulkan_fail(gpu, result, "get the memory of a plan's images");
		gpu_vulkan_trash_add(gpu, (gpu_vulkan_trash){.place = heap->place});
		*heap = (gpu_vulkan_heap){place, ++gpu->heap_ages};
	}
	return STILB_OK;
}

VkResult gpu_vulkan_shared_buffer_needs(gpu_vulkan *gpu, uint64_t bytes, VkMemoryRequirements *needs)
{
	VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = bytes, .usage = BUFFER_USES};
	VkBuffer buffer;
	VkResult result = vkCreateBuffer(gpu->device, &info, gpu->allocator, &buffer);
	if (result != VK_SUCCESS)
		return result;
	vkGetBufferMemoryRequirements(gpu->device, buffer, needs);
	vkDestroyBuffer(gpu->device, buffer, gpu->allocator);
	return VK_SUCCESS;
}

static VkResult shared_buffer(gpu_vulkan *gpu, const gpu_vulkan_heap *heap, uint64_t bytes, uint64_t offset,
                              gpu_vulkan_buffer *buffer)
{
	VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = bytes, .usage = BUFFER_USES};
	*buffer = (gpu_vulkan_buffer){.size = bytes};
	VkResult result = vkCreateBuffer(gpu->device, &info, gpu->allocator, &buffer->buffer);
	if (result == VK_SUCCESS)
		result = vkBindBufferMemory(gpu->device, buffer->buffer, gpu_vulkan_memory_of(heap->place.handle),
		                            heap->place.offset + offset);
	if (result != VK_SUCCESS) {
		vkDestroyBuffer(gpu->device, buffer->buffer, gpu->allocator);
		*buffer = (gpu_vulkan_buffer){0};
		return result;
	}
	buffer->address = vkGetBufferDeviceAddress(
		gpu->device,
		&(VkBufferDeviceAddressInfo){.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO, .buffer = buffer->buffer});
	return VK_SUCCESS;
}

static stilb_result shared_take(gpu_vulkan *gpu, uint32_t resource, const stilb_gpu_placed *placed, const char *name)
{
	gpu_vulkan_shared *shared = &gpu->shared[resource];
	const gpu_vulkan_heap *heap = &gpu->heaps[placed->heap];
	if (extent_is(&shared->extent, &placed->extent) && shared->bytes == placed->bytes &&
	    shared->offset == placed->offset && shared->heap == placed->heap && shared->heap_age == heap->age)
		return STILB_OK;
	if (shared->texels.image || shared->buffer.buffer)
		gpu_vulkan_trash_add(gpu, (gpu_vulkan_trash){.texels = shared->texels, .buffer = shared->buffer});
	*shared = (gpu_vulkan_shared){0};
	bool image = placed->extent.format != STILB_GPU_NONE;
	VkResult result =
		image ? gpu_vulkan_texels_create(gpu, name, &placed->extent, &heap->place, placed->offset, &shared->texels)
			  : shared_buffer(gpu, heap, placed->bytes, placed->offset, &shared->buffer);
	if (result != VK_SUCCESS)
		return target_fail(gpu, result, name);
	shared->extent = placed->extent;
	shared->bytes = placed->bytes;
	shared->offset = placed->offset;
	shared->heap = placed->heap;
	shared->heap_age = heap->age;
	return STILB_OK;
}

/* ---- all of a plan ----------------------------------------------------------------------------------------------- */

/* Sets what stands for a resource, once everything is there and no array moves any more. */
static void target_set(gpu_vulkan *gpu, uint32_t resource, const stilb_gpu_placed *placed)
{
	gpu_vulkan_target *target = &gpu->targets[resource];
	bool image = placed->extent.format != STILB_GPU_NONE;
	*target = (gpu_vulkan_target){0};
	if (placed->owned && image) {
		gpu_image *own = gpu_image_of(&gpu->base, placed->owned);
		target->texels = target->before = own->own;
		target->layouts = own->layouts;
	} else if (placed->owned)
		target->buffer = target->buffer_before = gpu_buffer_of(&gpu->base, placed->owned)->own;
	else if (placed->stay) {
		gpu_vulkan_stay *stay = &gpu->stays[placed->stay];
		uint32_t written = placed->two ? 1 - stay->now : stay->now;
		target->texels = image ? &stay->texels[written] : NULL;
		target->before = image ? &stay->texels[stay->now] : NULL;
		target->buffer = image ? NULL : &stay->buffers[written];
		target->buffer_before = image ? NULL : &stay->buffers[stay->now];
	} else if (placed->shared) {
		gpu_vulkan_shared *shared = &gpu->shared[resource];
		target->texels = target->before = image ? &shared->texels : NULL;
		target->buffer = target->buffer_before = image ? NULL : &shared->buffer;
	}
}

stilb_result gpu_vulkan_targets_take(gpu_vulkan *gpu, const stilb_gpu_plan *plan)
{
	uint32_t count = stilb_gpu_plan_resources(plan), capacity = gpu->shared_capacity;
	if (count + 1 > capacity) {
		uint32_t targets = capacity;
		if (!target_reserve((void **)&gpu->targets, &targets, count + 1, sizeof *gpu->targets) ||
		    !target_reserve((void **)&gpu->shared, &capacity, count + 1, sizeof *gpu->shared))
			return stilb_fail(STILB_ERROR_MEMORY, "no memory for the %u resources of a plan", count);
		gpu->shared_capacity = capacity;
	}
	stilb_result result = heaps_fit(gpu, plan);
	for (uint32_t r = 1; r <= count && result == STILB_OK; r++) {
		const stilb_gpu_placed *placed = stilb_gpu_plan_place(plan, (uint16_t)r);
		const char *name = stilb_gpu_plan_name(plan, (uint16_t)r);
		if (placed->stay)
			result = stay_take(gpu, placed, name);
		else if (placed->shared)
			result = shared_take(gpu, r, placed, name);
	}
	for (uint32_t r = 1; r <= count && result == STILB_OK; r++)
		target_set(gpu, r, stilb_gpu_plan_place(plan, (uint16_t)r));
	/* What no plan has any more, and shared images that the last plan had behind this one's. */
	for (uint32_t s = 0; s < gpu->stay_capacity && result == STILB_OK; s++)
		if (gpu->stays[s].frame > 0 && gpu->stays[s].frame < gpu->base.frame)
			stay_drop(gpu, &gpu->stays[s]);
	return result;
}

void gpu_vulkan_targets_done(gpu_vulkan *gpu, const stilb_gpu_plan *plan)
{
	uint32_t count = stilb_gpu_plan_resources(plan);
	for (uint32_t r = 1; r <= count; r++) {
		const stilb_gpu_placed *placed = stilb_gpu_plan_place(plan, (uint16_t)r);
		if (placed->stay && placed->two)
			gpu->stays[placed->stay].now = 1 - gpu->stays[placed->stay].now;
	}
	const stilb_gpu_barrier *barriers;
	uint32_t barrier_count = stilb_gpu_plan_barriers(plan, &barriers);
	for (uint32_t i = 0; i < barrier_count; i++) {
		const stilb_gpu_barrier *b = &barriers[i];
		const gpu_vulkan_target *target = &gpu->targets[b->resource];
		if (!target->layouts)
			continue;
		stilb_gpu_format_kind kind = stilb_gpu_format_describe(target->texels->extent.format)->kind;
		uint8_t layout = (uint8_t)stilb_gpu_access_layout((stilb_gpu_access)b->to, kind);
		for (uint32_t layer = b->layer; layer < (uint32_t)b->layer + b->layers; layer++)
			memset(&target->layouts[layer * target->texels->extent.mips + b->mip], layout, b->mips);
	}
}

void gpu_vulkan_targets_free(gpu_vulkan *gpu)
{
	for (uint32_t s = 0; s < gpu->stay_capacity; s++)
		for (int i = 0; i < 2; i++) {
			gpu_vulkan_texels_destroy(gpu, &gpu->stays[s].texels[i]);
			gpu_vulkan_buffer_destroy(gpu, &gpu->stays[s].buffers[i]);
		}
	for (uint32_t r = 0; r < gpu->shared_capacity; r++) {
		gpu_vulkan_texels_destroy(gpu, &gpu->shared[r].texels);
		gpu_vulkan_buffer_destroy(gpu, &gpu->shared[r].buffer);
	}
	for (uint32_t h = 0; h < GPU_MEMORY_POOLS; h++)
		gpu_memory_give(&gpu->blocks, &gpu->heaps[h].place);
	free(gpu->stays);
	free(gpu->shared);
	free(gpu->targets);
	gpu->stays = NULL;
	gpu->shared = NULL;
	gpu->targets = NULL;
	gpu->stay_capacity = gpu->shared_capacity = 0;
}
