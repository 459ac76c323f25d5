/* Resources on the device: the heaps of vertices, indices and materials, buffers with the same contents at the same
 * offsets; textures, an image and a set each; the sets of maps; tables of rows. What has changed goes through the
 * device's ring of uploads, at the start of a frame. Textures that no surface names have one mip level, so distant ones
 * may flicker. */
#include "render/render_internal.h"

#include <stdlib.h>
#include <string.h>

static const struct {
	const char *name;
	uint32_t uses;
} heap_buffers[RENDER_HEAPS] = {
	[RENDER_HEAP_VERTICES] = {"vertices", STILB_GPU_BUFFER_VERTICES | STILB_GPU_BUFFER_ADDRESS | STILB_GPU_BUFFER_COPY},
	[RENDER_HEAP_INDICES] = {"indices", STILB_GPU_BUFFER_INDICES | STILB_GPU_BUFFER_COPY},
	[RENDER_HEAP_INDICES_16] = {"16-bit indices", STILB_GPU_BUFFER_INDICES | STILB_GPU_BUFFER_COPY},
	[RENDER_HEAP_MATERIALS] = {"materials", STILB_GPU_BUFFER_ADDRESS | STILB_GPU_BUFFER_COPY},
	[RENDER_HEAP_MAPS] = {"surfaces", STILB_GPU_BUFFER_ADDRESS | STILB_GPU_BUFFER_COPY},
	[RENDER_HEAP_EXTRAS] = {"extras of vertices", STILB_GPU_BUFFER_ADDRESS | STILB_GPU_BUFFER_COPY},
	[RENDER_HEAP_LAST] = {"last vertices", STILB_GPU_BUFFER_ADDRESS | STILB_GPU_BUFFER_COPY},
	[RENDER_HEAP_EXTRA_PLACES] = {"places of extras", STILB_GPU_BUFFER_ADDRESS | STILB_GPU_BUFFER_COPY},
};

/* ---- uploads ----------------------------------------------------------------------------------------------------- */

stilb_result render_device_send(render_device *device, const stilb_gpu_upload *upload, const void *from)
{
	void *bytes;
	stilb_result result = stilb_gpu_upload_begin(device->gpu, upload, &bytes);
	/* Other threads write into the ring, too: what is full once may be full again. */
	while (result == STILB_OK && !bytes) {
		result = stilb_gpu_upload_flush(device->gpu);
		if (result == STILB_OK)
			result = stilb_gpu_upload_begin(device->gpu, upload, &bytes);
	}
	if (result != STILB_OK)
		return result;
	memcpy(bytes, from, upload->bytes);
	stilb_gpu_upload_end(device->gpu, bytes);
	return STILB_OK;
}

/* Bytes that one upload has at most: so that parts of large ones are copied while the next ones are written. */
static uint64_t heaps_part(const render_device *device)
{
	return stilb_gpu_upload_most(device->gpu) / 4;
}

/* ---- heaps ------------------------------------------------------------------------------------------------------- */

/* Replaces the buffer of a heap that has outgrown it, or will; then *all is true: the whole heap must be copied. */
static stilb_result heap_fit(render_device *device, const render_resources *resources, int kind, bool *all)
{
	const render_heap *heap = &resources->heaps[kind];
	uint64_t size = (uint64_t)heap->size * heap->element;
	uint64_t expected = (uint64_t)resources->expected[kind] * heap->element;
	uint64_t wanted = size > expected ? size + size / 2 : expected;
	render_buffer *buffer = &device->heaps[kind], larger;
	*all = size > buffer->bytes || (heap->size > 0 && expected > buffer->bytes);
	if (!*all)
		return STILB_OK;
	stilb_result result = render_buffer_make(device, heap_buffers[kind].name, wanted, STILB_GPU_MEMORY_DEVICE,
	                                         heap_buffers[kind].uses, &larger);
	if (result != STILB_OK)
		return result;
	render_buffer_drop(device, buffer);
	*buffer = larger;
	return STILB_OK;
}

static stilb_result heap_send(render_device *device, const render_heap *heap, int kind, render_range range)
{
	uint64_t part = heaps_part(device) / heap->element, end = (uint64_t)range.first + range.count;
	stilb_result result = STILB_OK;
	for (uint64_t first = range.first; first < end && result == STILB_OK; first += part) {
		uint64_t count = end - first < part ? end - first : part;
		stilb_gpu_upload upload = {
			.buffer = device->heaps[kind].buffer, .offset = first * heap->element, .bytes = count * heap->element};
		STILB_ASSERT(upload.offset + upload.bytes <= device->heaps[kind].bytes);
		result = render_device_send(device, &upload, heap->data + first * heap->element);
	}
	return result;
}

/* Sends what has changed of a heap. */
static stilb_result heap_update(render_device *device, const render_resources *resources, int kind)
{
	const render_heap *heap = &resources->heaps[kind];
	bool all;
	stilb_result result = heap_fit(device, resources, kind, &all);
	if (result != STILB_OK || heap->size == 0)
		return result;
	if (all)
		return heap_send(device, heap, kind, (render_range){0, heap->size});
	for (uint32_t r = 0; r < heap->dirty.count && result == STILB_OK; r++)
		result = heap_send(device, heap, kind, heap->dirty.items[r]);
	return result;
}

/* ---- textures ---------------------------------------------------------------------------------------------------- */

/* Sends rows first .. end - 1 of a mip. */
static stilb_result texture_send(render_device *device, uint32_t texture, const render_upload_mip *mip, uint32_t first,
                                 uint32_t end)
{
	uint32_t part = (uint32_t)(heaps_part(device) / mip->row), height = mip->image.height;
	stilb_result result = STILB_OK;
	STILB_ASSERT(part > 0 && end <= mip->rows);
	for (; first < end && result == STILB_OK; first += part) {
		uint32_t count = end - first < part ? end - first : part, y = first * mip->side;
		stilb_gpu_upload to = {.image = device->textures[texture].image,
		                       .mip = (uint16_t)mip->mip,
		                       .layer = device->textures[texture].layer,
		                       .y = y,
		                       .width = mip->image.width,
		                       .height = count * mip->side < height - y ? count * mip->side : height - y,
		                       .depth = 1,
		                       .bytes = count * mip->row};
		result = render_device_send(device, &to, (const uint8_t *)mip->image.pixels + first * mip->row);
	}
	return result;
}

/* Sends rows upload->rows .. upload->sent - 1. */
static stilb_result texture_update(render_device *device, const render_texture_upload *upload)
{
	render_upload_mip mip = render_upload_first(upload);
	stilb_result result = STILB_OK;
	do {
		uint32_t begin = mip.first_row, end = begin + mip.rows;
		uint32_t first = upload->rows > begin ? upload->rows : begin, last = upload->sent < end ? upload->sent : end;
		if (first < last)
			result = texture_send(device, upload->texture, &mip, first - begin, last - begin);
	} while (result == STILB_OK && render_upload_next(upload, &mip));
	return result;
}

static stilb_result texture_image(render_device *device, const render_array_kind *kind, stilb_gpu_image *out)
{
	stilb_gpu_image_desc desc = {.name = "texture",
	                             .channels = render_texture_channels(kind->format),
	                             .extent = {.format = kind->format,
	                                        .width = kind->width,
	                                        .height = kind->height,
	                                        .depth = 1,
	                                        .layers = 1,
	                                        .mips = 1,
	                                        .samples = 1,
	                                        .uses = 1u << STILB_GPU_USE_SAMPLED | 1u << STILB_GPU_USE_COPY_TO}};
	return stilb_gpu_image_create(device->gpu, &desc, out);
}

stilb_result render_device_texture_check(const render_device *device, const render_texture_shape *shape)
{
	const char *name = stilb_gpu_name(device->gpu);
	uint32_t most = stilb_gpu_limits_get(device->gpu)->image_side, fault = device->gpu->faults.image_side;
	most = fault > 0 && fault < most ? fault : most;
	if (!(device->gpu->formats[render_texture_format(shape->format)] & GPU_FORMAT_LINEAR))
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "GPU '%s' cannot filter textures of %s; use an image of 8-bit codes or 16-bit floats", name,
		                  shape->format == STILB_IMAGE_F32_LINEAR ? "32-bit floats" : "this format");
	if (shape->width > most || shape->height > most)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "GPU '%s' has textures of up to %ux%u pixels, not %ux%u; use a smaller image", name, most,
		                  most, shape->width, shape->height);
	return STILB_OK;
}

stilb_result render_device_texture_create(render_device *device, uint32_t index, const render_texture_shape *shape)
{
	STILB_ASSERT(index > 0 && index < STILB_RENDER_MAX_TEXTURES);
	render_device_texture *texture = &device->textures[index];
	STILB_ASSERT(texture->image.id == 0 && texture->set.id == 0 && "a released index");
	stilb_result result;
	render_array_kind kind = {shape->width, shape->height, render_texture_format(shape->format), shape->levels};
	if (shape->mapped) {
		uint32_t array;
		uint16_t layer;
		result = render_array_take(device, &kind, &array, &layer);
		if (result == STILB_OK)
			*texture =
				(render_device_texture){.image = device->arrays.items[array].image, .array = array + 1, .layer = layer};
	} else {
		result = texture_image(device, &kind, &texture->image);
	}
	if (result == STILB_ERROR_MEMORY)
		return stilb_fail(result, "no memory for a texture of %ux%u pixels on '%s'", shape->width, shape->height,
		                  stilb_gpu_name(device->gpu));
	uint32_t set;
	if (result == STILB_OK && !shape->mapped) {
		result = render_device_texture_set(device, index, &set);
		if (result != STILB_OK) {
			stilb_gpu_image_destroy(device->gpu, texture->image);
			texture->image = (stilb_gpu_image){0};
		}
	}
	return result;
}

stilb_result render_device_texture_set(render_device *device, uint32_t index, uint32_t *set)
{
	render_device_texture *texture = &device->textures[index];
	stilb_gpu_set_item item = {
		.image = texture->image, .sampler = device->sampler, .seen = STILB_GPU_SEEN_LAYER, .layer = texture->layer};
	stilb_result result = STILB_OK;
	STILB_ASSERT(texture->image.id != 0);
	if (texture->set.id == 0)
		result = stilb_gpu_set_create(device->gpu, &item, 1, &texture->set);
	*set = texture->set.id;
	return result;
}

void render_device_texture_destroy(render_device *device, uint32_t index)
{
	render_device_texture *texture = &device->textures[index];
	STILB_ASSERT(texture->image.id != 0);
	if (texture->set.id != 0)
		stilb_gpu_set_destroy(device->gpu, texture->set);
	if (texture->array > 0)
		render_array_give(device, texture->array - 1, texture->layer);
	else
		stilb_gpu_image_destroy(device->gpu, texture->image);
	*texture = (render_device_texture){0};
}

/* ---- maps -------------------------------------------------------------------------------------------------------- */

/* The sampler of that number (render_maps.samplers). */
static stilb_result maps_sampler(render_device *device, uint32_t number, stilb_gpu_sampler *sampler)
{
	static const uint8_t wraps[STILB_SCENE_WRAPS] = {[STILB_SCENE_REPEAT] = STILB_GPU_WRAP_REPEAT,
	                                                 [STILB_SCENE_MIRROR] = STILB_GPU_WRAP_MIRROR,
	                                                 [STILB_SCENE_CLAMP] = STILB_GPU_WRAP_CLAMP};
	STILB_ASSERT(number < RENDER_MAPS_SAMPLERS);
	stilb_gpu_sampler_desc desc = {.anisotropy = number < 9 ? device->anisotropy : 1.0f,
	                               .linear = number < 9,
	                               .mips = true,
	                               .mip_linear = true,
	                               .wrap = {wraps[number % 3], wraps[number / 3 % 3]}};
	return stilb_gpu_sampler_get(device->gpu, &desc, sampler);
}

stilb_result render_device_maps_set(render_device *device, uint32_t group, const render_maps *maps)
{
	STILB_ASSERT(group < RENDER_MAX_MAPS && device->maps[group].set.id == 0);
	stilb_gpu_set_item items[RENDER_MAPS] = {0};
	stilb_result result = STILB_OK;
	uint32_t count = maps->bits & RENDER_MAPS_LAYERS ? RENDER_MAPS : RENDER_MAPS_PLAIN;
	for (uint32_t i = 0; i < count && result == STILB_OK; i++) {
		uint32_t texture = maps->textures[i] & RENDER_INDEX_MASK;
		items[i].seen = STILB_GPU_SEEN_ARRAY;
		if (!(maps->bits >> i & 1u))
			continue;
		STILB_ASSERT(texture > 0 && texture < STILB_RENDER_MAX_TEXTURES && device->textures[texture].array != 0);
		items[i].image = device->textures[texture].image;
		result = maps_sampler(device, maps->samplers[i], &items[i].sampler);
	}
	if (result == STILB_OK)
		result = stilb_gpu_set_create(device->gpu, items, count, &device->maps[group].set);
	if (result != STILB_OK)
		return result;
	device->maps[group].bits = maps->bits;
	device->through += maps->bits & RENDER_MAPS_THROUGH ? 1 : 0;
	return STILB_OK;
}

void render_device_maps_drop(render_device *device, uint32_t group)
{
	STILB_ASSERT(device->maps[group].set.id != 0);
	stilb_gpu_set_destroy(device->gpu, device->maps[group].set);
	device->through -= device->maps[group].bits & RENDER_MAPS_THROUGH ? 1 : 0;
	device->maps[group] = (render_device_maps){0};
}

/* ---- all of them ------------------------------------------------------------------------------------------------- */

stilb_result render_device_textures_update(render_device *device, const render_resources *resources)
{
	STILB_ASSERT_LOCKED(&resources->lock);
	stilb_result result = STILB_OK;
	for (uint32_t u = 0; u < resources->upload_count && result == STILB_OK; u++)
		result = texture_update(device, &resources->uploads[u]);
	return result;
}

stilb_result render_device_update(render_device *device, const render_resources *resources)
{
	STILB_ASSERT_LOCKED(&resources->lock);
	stilb_result result = STILB_OK;
	for (int kind = 0; kind < RENDER_HEAPS && result == STILB_OK; kind++)
		result = heap_update(device, resources, kind);
	return result == STILB_OK ? render_device_textures_update(device, resources) : result;
}

/* ---- rows -------------------------------------------------------------------------------------------------------- */

/* Like a frame's rows the CPU writes them once, mostly, and the GPU reads them where they are. */
stilb_result render_device_rows_make(render_device *device, uint32_t capacity, render_rows **out)
{
	STILB_ASSERT(capacity > 0);
	*out = NULL;
	render_buffer buffer;
	render_rows *rows = calloc(1, sizeof *rows);
	if (!rows)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a table of rows");
	stilb_result result = render_buffer_make(device, "scene rows", (uint64_t)capacity * sizeof(render_row),
	                                         STILB_GPU_MEMORY_WRITE, STILB_GPU_BUFFER_ADDRESS, &buffer);
	if (result != STILB_OK) {
		free(rows);
		return result == STILB_ERROR_MEMORY ? stilb_fail(result, "no memory for the rows of %u parts", capacity)
		                                    : result;
	}
	*rows = (render_rows){
		.data = buffer.mapped, .address = buffer.address, .buffer = buffer.buffer.id, .capacity = capacity};
	*out = rows;
	return STILB_OK;
}

void render_device_rows_free(render_device *device, render_rows *rows)
{
	stilb_gpu_buffer_destroy(device->gpu, (stilb_gpu_buffer){rows->buffer});
	free(rows);
}
