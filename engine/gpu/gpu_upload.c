/* gpu: the ring through which uploads go. Any thread takes a range, writes it and says so; the main thread copies what
 * has ended, and gives back ranges whose frame is done. */
#include "gpu/gpu_internal.h"

#include <stdlib.h>

stilb_result gpu_ring_create(stilb_gpu *gpu, uint64_t bytes)
{
	gpu_ring *ring = &gpu->ring;
	bytes = (bytes + GPU_UPLOAD_ALIGN - 1) / GPU_UPLOAD_ALIGN * GPU_UPLOAD_ALIGN;
	ring->buffer = (gpu_buffer){
		.name = "uploads", .bytes = bytes, .memory = STILB_GPU_MEMORY_WRITE, .uses = STILB_GPU_BUFFER_COPY};
	stilb_result result = gpu->functions->buffer_make(gpu, &ring->buffer);
	if (result != STILB_OK)
		ring->buffer = (gpu_buffer){0};
	return result;
}

void gpu_ring_destroy(stilb_gpu *gpu)
{
	if (gpu->ring.buffer.own)
		gpu->functions->buffer_free(gpu, &gpu->ring.buffer);
	free(gpu->ring.items);
	gpu->ring = (gpu_ring){0};
}

static gpu_upload_item *ring_item(const gpu_ring *ring, uint32_t number)
{
	STILB_ASSERT(number < ring->count);
	return &ring->items[(ring->first + number) % ring->capacity];
}

/* Makes room for one item more. */
static bool ring_reserve(gpu_ring *ring)
{
	if (ring->count < ring->capacity)
		return true;
	uint32_t larger = ring->capacity ? 2 * ring->capacity : 64;
	gpu_upload_item *items = malloc(larger * sizeof *items);
	if (!items)
		return false;
	for (uint32_t i = 0; i < ring->count; i++)
		items[i] = *ring_item(ring, i);
	free(ring->items);
	ring->items = items;
	ring->first = 0;
	ring->capacity = larger;
	return true;
}

uint64_t stilb_gpu_upload_most(const stilb_gpu *gpu)
{
	return gpu->ring.buffer.bytes;
}

stilb_result stilb_gpu_upload_begin(stilb_gpu *gpu, const stilb_gpu_upload *upload, void **bytes)
{
	STILB_ASSERT(gpu && upload && bytes);
	*bytes = NULL;
	gpu_ring *ring = &gpu->ring;
	uint64_t size = ring->buffer.bytes;
	stilb_result result = gpu_check_upload(gpu, upload);
	if (result != STILB_OK)
		return result;
	if (upload->bytes > size)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "an upload of %llu bytes: the ring holds %llu; upload it in parts, or ask for a larger ring "
		                  "(stilb_gpu_desc.upload_bytes)",
		                  (unsigned long long)upload->bytes, (unsigned long long)size);
	stilb_lock_take(&gpu->lock);
	uint64_t begin = ring->head, tail = ring->count > 0 ? ring_item(ring, 0)->offset : ring->head;
	/* What does not fit before the ring's end begins at its start; the item also takes what is left over. */
	uint64_t place = begin % size + upload->bytes > size ? begin + size - begin % size : begin;
	uint64_t end = (place + upload->bytes + GPU_UPLOAD_ALIGN - 1) / GPU_UPLOAD_ALIGN * GPU_UPLOAD_ALIGN;
	if (ring->count == 0)
		tail = place;
	bool fits = end - tail <= size;
	if (fits && !ring_reserve(ring)) {
		stilb_lock_give(&gpu->lock);
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the list of uploads");
	}
	if (fits) {
		ring->count++;
		*ring_item(ring, ring->count - 1) =
			(gpu_upload_item){.upload = *upload, .offset = ring->count == 1 ? place : begin, .end = end};
		ring->head = end;
		*bytes = (uint8_t *)ring->buffer.mapped + place % size;
	}
	stilb_lock_give(&gpu->lock);
	return STILB_OK;
}

/* Where the item's bytes lie in the ring's buffer. */
static uint64_t item_place(const gpu_ring *ring, const gpu_upload_item *item)
{
	uint64_t size = ring->buffer.bytes, begin = item->offset % size;
	return begin + item->upload.bytes > size ? 0 : begin;
}

void stilb_gpu_upload_end(stilb_gpu *gpu, void *bytes)
{
	STILB_ASSERT(gpu && bytes);
	gpu_ring *ring = &gpu->ring;
	stilb_lock_take(&gpu->lock);
	bool found = false;
	for (uint32_t i = ring->count; i-- > 0 && !found;) {
		gpu_upload_item *item = ring_item(ring, i);
		found = !item->ended && (uint8_t *)ring->buffer.mapped + item_place(ring, item) == bytes;
		item->ended |= found;
	}
	stilb_lock_give(&gpu->lock);
	STILB_ASSERT(found && "bytes are of an upload that has begun and not ended");
}

void gpu_ring_frame(stilb_gpu *gpu, uint64_t done)
{
	gpu_ring *ring = &gpu->ring;
	stilb_lock_take(&gpu->lock);
	while (ring->count > 0 && ring_item(ring, 0)->frame > 0 && ring_item(ring, 0)->frame <= done) {
		ring->first = (ring->first + 1) % ring->capacity;
		ring->count--;
	}
	stilb_lock_give(&gpu->lock);
}

uint32_t gpu_ring_ready(stilb_gpu *gpu, gpu_upload_ready *items, uint32_t capacity)
{
	gpu_ring *ring = &gpu->ring;
	uint32_t count = 0;
	stilb_lock_take(&gpu->lock);
	for (uint32_t i = 0; i < ring->count && count < capacity; i++) {
		gpu_upload_item *item = ring_item(ring, i);
		if (!item->ended || item->frame > 0)
			continue;
		item->frame = gpu->frame;
		/* A target that was destroyed meanwhile needs nothing. */
		if (item->upload.image.id ? !gpu_image_of(gpu, item->upload.image.id)
		                          : !gpu_buffer_of(gpu, item->upload.buffer.id))
			continue;
		items[count++] = (gpu_upload_ready){item->upload, item_place(ring, item)};
	}
	stilb_lock_give(&gpu->lock);
	return count;
}
