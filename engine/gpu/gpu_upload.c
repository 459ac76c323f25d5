/* gpu: the ring through which uploads go. Any thread takes a range, writes it and says so; the main thread copies what
 * has ended, and gives back ranges whose frame is done. The end of an upload takes no lock: after the caller's writes a
 * locked instruction would wait until all of them have left the processor. */
#include "gpu/gpu_internal.h"

#include <stdlib.h>

static gpu_upload_item *ring_item(const gpu_ring *ring, uint32_t number)
{
	return &ring->items[number % GPU_UPLOADS];
}

stilb_result gpu_ring_create(stilb_gpu *gpu, uint64_t bytes, uint64_t frame_bytes)
{
	gpu_ring *ring = &gpu->ring;
	bytes = (bytes + GPU_UPLOAD_ALIGN - 1) / GPU_UPLOAD_ALIGN * GPU_UPLOAD_ALIGN;
	ring->frame_bytes = frame_bytes > 0 ? frame_bytes : UINT64_MAX;
	ring->items = calloc(GPU_UPLOADS, sizeof *ring->items);
	ring->ready = calloc(GPU_UPLOADS, sizeof *ring->ready);
	ring->lock_made = stilb_lock_init(&ring->lock);
	if (!ring->items || !ring->ready || !ring->lock_made)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the list of uploads");
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
	if (gpu->ring.lock_made)
		stilb_lock_finish(&gpu->ring.lock);
	free(gpu->ring.items);
	free(gpu->ring.ready);
	gpu->ring = (gpu_ring){0};
}

uint64_t stilb_gpu_upload_most(const stilb_gpu *gpu)
{
	return gpu->ring.buffer.bytes;
}

/* The number of the next upload. Relaxed: it changes under the lock, which orders it; without the lock it is a hint. */
static uint32_t ring_begun(const gpu_ring *ring)
{
	return atomic_load_explicit(&ring->begun, memory_order_relaxed);
}

/* Takes a range of the ring, and returns its bytes; NULL: there is no room. */
static void *ring_take(gpu_ring *ring, const stilb_gpu_upload *upload)
{
	uint64_t size = ring->buffer.bytes, begin = ring->head;
	uint32_t first = ring->first, next = ring_begun(ring), count = next - first;
	/* What does not fit before the ring's end begins at its start; the item also takes what is left over. */
	uint64_t place = begin % size + upload->bytes > size ? begin + size - begin % size : begin;
	uint64_t end = (place + upload->bytes + GPU_UPLOAD_ALIGN - 1) / GPU_UPLOAD_ALIGN * GPU_UPLOAD_ALIGN;
	uint64_t tail = count > 0 ? ring_item(ring, first)->offset : place;
	if (end - tail > size || count == GPU_UPLOADS)
		return NULL;
	gpu_upload_item *item = ring_item(ring, next);
	item->upload = *upload;
	item->offset = count == 0 ? place : begin;
	item->end = end;
	item->frame = item->batch = 0;
	/* Relaxed: the lock's end makes it known to the main thread, and this thread or one that it tells ends it. */
	atomic_store_explicit(&item->writing, place % size + 1, memory_order_relaxed);
	atomic_store_explicit(&ring->begun, next + 1, memory_order_relaxed); /* ring_begun */
	ring->head = end;
	return (uint8_t *)ring->buffer.mapped + place % size;
}

stilb_result stilb_gpu_upload_begin(stilb_gpu *gpu, const stilb_gpu_upload *upload, void **bytes)
{
	STILB_ASSERT(gpu && upload && bytes);
	*bytes = NULL;
	gpu_ring *ring = &gpu->ring;
	stilb_result result = gpu_check_upload(gpu, upload);
	if (result != STILB_OK)
		return result;
	if (upload->bytes > ring->buffer.bytes)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "an upload of %llu bytes: the ring holds %llu; upload it in parts, or ask for a larger ring "
		                  "(stilb_gpu_desc.upload_bytes)",
		                  (unsigned long long)upload->bytes, (unsigned long long)ring->buffer.bytes);
	stilb_lock_take(&ring->lock);
	*bytes = ring_take(ring, upload);
	stilb_lock_give(&ring->lock);
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
	uint64_t writing = (uint64_t)((uint8_t *)bytes - (uint8_t *)ring->buffer.mapped) + 1;
	/* At least as new as when this upload was begun. While it is being written no other item has its place, and whoever
	 * had it before has ended, which was known when this one began. */
	uint32_t next = ring_begun(ring);
	for (uint32_t i = 1; i <= GPU_UPLOADS; i++) {
		gpu_upload_item *item = ring_item(ring, next - i);
		if (atomic_load_explicit(&item->writing, memory_order_relaxed) != writing) /* this thread knows its own */
			continue;
		atomic_store_explicit(&item->writing, 0, memory_order_release); /* gpu_ring_ready, after the bytes */
		return;
	}
	STILB_ASSERT(false && "bytes are of an upload that has begun and not ended");
}

void gpu_ring_frame(stilb_gpu *gpu, uint64_t done)
{
	gpu_ring *ring = &gpu->ring;
	stilb_lock_take(&ring->lock);
	while (ring->first != ring_begun(ring) && ring_item(ring, ring->first)->batch > 0 &&
	       ring_item(ring, ring->first)->frame <= done)
		ring->first++;
	stilb_lock_give(&ring->lock);
}

uint32_t gpu_ring_ready(stilb_gpu *gpu, uint64_t most)
{
	gpu_ring *ring = &gpu->ring;
	uint32_t count = 0;
	uint64_t bytes = 0;
	stilb_lock_take(&ring->lock);
	ring->batch++;
	for (uint32_t i = ring->first, end = ring_begun(ring); i != end; i++) {
		gpu_upload_item *item = ring_item(ring, i);
		/* Acquire: stilb_gpu_upload_end; the bytes are written. */
		if (item->batch > 0 || atomic_load_explicit(&item->writing, memory_order_acquire) != 0)
			continue;
		bytes += item->upload.bytes;
		if (count > 0 && bytes > most)
			break;
		item->frame = gpu->frame;
		item->batch = ring->batch;
		/* A target that was destroyed meanwhile needs nothing. */
		if (item->upload.image.id ? !gpu_image_of(gpu, item->upload.image.id)
		                          : !gpu_buffer_of(gpu, item->upload.buffer.id))
			continue;
		ring->ready[count++] = (gpu_upload_ready){item->upload, item_place(ring, item)};
	}
	stilb_lock_give(&ring->lock);
	return count;
}

void gpu_ring_untake(stilb_gpu *gpu)
{
	gpu_ring *ring = &gpu->ring;
	stilb_lock_take(&ring->lock);
	for (uint32_t i = ring->first, end = ring_begun(ring); i != end; i++)
		if (ring_item(ring, i)->batch == ring->batch)
			ring_item(ring, i)->batch = 0;
	stilb_lock_give(&ring->lock);
}
