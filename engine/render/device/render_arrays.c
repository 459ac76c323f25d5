/* Formats of textures, and array images of those that surfaces name. */
#include "render/device/render_arrays.h"

#include "gpu/gpu_format.h"
#include "render/render_internal.h"

#include <stdlib.h>
#include <string.h>

/* Pictures of formats that no GPU has, and of those that it has not, are converted before (render_pixels.c). */
stilb_gpu_format render_texture_format(stilb_image_format format)
{
	static const uint8_t formats[STILB_IMAGE_FORMAT_COUNT] = {
		[STILB_IMAGE_U8_SRGB] = STILB_GPU_RGBA8_SRGB,  [STILB_IMAGE_F16_LINEAR] = STILB_GPU_RGBA16_F,
		[STILB_IMAGE_F32_LINEAR] = STILB_GPU_RGBA32_F, [STILB_IMAGE_U16_SRGB] = STILB_GPU_RGBA16_F,
		[STILB_IMAGE_U8_LINEAR] = STILB_GPU_RGBA8_U,   [STILB_IMAGE_U16_LINEAR] = STILB_GPU_RGBA16_U,
		[STILB_IMAGE_BC1_SRGB] = STILB_GPU_BC1_SRGB,   [STILB_IMAGE_BC1_LINEAR] = STILB_GPU_BC1_U,
		[STILB_IMAGE_BC3_SRGB] = STILB_GPU_BC3_SRGB,   [STILB_IMAGE_BC3_LINEAR] = STILB_GPU_BC3_U,
		[STILB_IMAGE_BC4_LINEAR] = STILB_GPU_BC4_U,    [STILB_IMAGE_BC5_LINEAR] = STILB_GPU_BC5_U,
		[STILB_IMAGE_BC7_SRGB] = STILB_GPU_BC7_SRGB,   [STILB_IMAGE_BC7_LINEAR] = STILB_GPU_BC7_U};
	return (stilb_gpu_format)formats[format];
}

stilb_gpu_channels render_texture_channels(stilb_gpu_format format)
{
	return format == STILB_GPU_BC4_U   ? STILB_GPU_CHANNELS_GREY
	       : format == STILB_GPU_BC5_U ? STILB_GPU_CHANNELS_GREY_ALPHA
	                                   : STILB_GPU_CHANNELS_OWN;
}

uint64_t render_array_layer(const render_array_kind *kind)
{
	uint64_t bytes = 0;
	for (uint32_t m = 0; m < kind->mips; m++) {
		uint64_t width = kind->width >> m ? kind->width >> m : 1, height = kind->height >> m ? kind->height >> m : 1;
		bytes += stilb_gpu_format_bytes(kind->format, (uint32_t)width, (uint32_t)height, 1);
	}
	return bytes;
}

bool render_array_is_large(const render_array_kind *kind)
{
	return render_array_layer(kind) >= RENDER_ARRAY_LARGE;
}

static bool array_kind_is(const render_array_kind *a, const render_array_kind *b)
{
	return a->width == b->width && a->height == b->height && a->format == b->format && a->mips == b->mips;
}

static uint32_t *array_chain(render_arrays *arrays, const render_array_kind *kind)
{
	uint32_t hash = (kind->width * 2654435761u) ^ (kind->height * 2246822519u) ^ ((uint32_t)kind->format * 3266489917u);
	return &arrays->chains[(hash >> 20) % RENDER_ARRAY_CHAINS];
}

/* An array of this kind with a free layer; NULL: there is none. *layers: of all of the kind. */
static render_array *array_find(render_arrays *arrays, const render_array_kind *kind, uint32_t *layers)
{
	*layers = 0;
	for (uint32_t at = *array_chain(arrays, kind); at > 0; at = arrays->items[at - 1].next) {
		render_array *array = &arrays->items[at - 1];
		if (!array_kind_is(&array->kind, kind))
			continue;
		if (array->used < array->layers)
			return array;
		*layers += array->layers;
	}
	return NULL;
}

/* How many more textures of the kind are expected, one less from now on: its array is being taken. */
static uint32_t array_expected(render_arrays *arrays, const render_array_kind *kind)
{
	for (uint32_t h = 0; h < arrays->hope_count; h++)
		if (array_kind_is(&arrays->hopes[h].kind, kind))
			return arrays->hopes[h].count > 0 ? arrays->hopes[h].count-- : 0;
	return 0;
}

static stilb_result array_image(render_device *device, render_array *array)
{
	stilb_gpu_image_desc desc = {
		.name = "textures",
		.channels = render_texture_channels(array->kind.format),
		.extent = {.format = array->kind.format,
	               .width = array->kind.width,
	               .height = array->kind.height,
	               .depth = 1,
	               .layers = (uint16_t)array->layers,
	               .mips = (uint16_t)array->kind.mips,
	               .samples = 1,
	               .uses = 1u << STILB_GPU_USE_SAMPLED | 1u << STILB_GPU_USE_COPY_TO},
	};
	return stilb_gpu_image_create(device->gpu, &desc, &array->image);
}

/* Makes an array of about so many layers, or of fewer where there is no memory for these. *index: of it. */
static stilb_result array_make(render_device *device, const render_array_kind *kind, uint64_t layers, uint32_t *index)
{
	render_arrays *arrays = &device->arrays;
	uint64_t bytes = render_array_layer(kind);
	uint64_t most = bytes > 0 && !render_array_is_large(kind) ? RENDER_ARRAY_BYTES / bytes : 1;
	uint32_t limit = stilb_gpu_limits_get(device->gpu)->image_layers, bits = 8 * sizeof arrays->items->taken;
	bool reuses = arrays->free > 0;
	limit = limit < bits ? limit : bits;
	most = most < limit ? most : limit;
	layers = layers < most ? layers : most;
	layers = layers > 0 ? layers : 1;
	if (!reuses && !render_reserve((void **)&arrays->items, &arrays->capacity, arrays->count + 1, sizeof(render_array)))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the list of textures");
	*index = reuses ? arrays->free - 1 : arrays->count;
	render_array *array = &arrays->items[*index];
	uint32_t next = reuses ? array->next : 0;
	stilb_result result = STILB_ERROR_MEMORY;
	for (; layers > 0 && result == STILB_ERROR_MEMORY; layers /= 2) {
		*array = (render_array){.kind = *kind, .layers = (uint32_t)layers, .next = next};
		result = array_image(device, array);
	}
	if (result != STILB_OK)
		return result;
	uint32_t *chain = array_chain(arrays, kind);
	arrays->free = reuses ? next : arrays->free;
	arrays->count += !reuses;
	array->serial = ++arrays->serial;
	array->next = *chain;
	*chain = *index + 1;
	return STILB_OK;
}

stilb_result render_array_take(render_device *device, const render_array_kind *kind, uint32_t *index, uint16_t *layer)
{
	render_arrays *arrays = &device->arrays;
	uint32_t layers, expected = array_expected(arrays, kind);
	const render_array *found = array_find(arrays, kind, &layers);
	if (found) {
		*index = (uint32_t)(found - arrays->items);
	} else {
		stilb_result result = array_make(device, kind, expected > layers ? expected : layers, index);
		if (result != STILB_OK)
			return result;
	}
	render_array *array = &arrays->items[*index];
	uint32_t word = 0;
	while (array->taken[word] == UINT64_MAX)
		word++;
	uint32_t bit = (uint32_t)__builtin_ctzll(~array->taken[word]);
	array->taken[word] |= (uint64_t)1 << bit;
	array->used++;
	*layer = (uint16_t)(64 * word + bit);
	STILB_ASSERT(*layer < array->layers);
	return STILB_OK;
}

void render_array_give(render_device *device, uint32_t index, uint16_t layer)
{
	render_arrays *arrays = &device->arrays;
	render_array *array = &arrays->items[index];
	uint64_t bit = (uint64_t)1 << layer % 64;
	STILB_ASSERT(index < arrays->count && array->used > 0 && (array->taken[layer / 64] & bit) != 0);
	array->taken[layer / 64] &= ~bit;
	if (--array->used > 0)
		return;
	uint32_t *link = array_chain(arrays, &array->kind);
	while (*link != index + 1)
		link = &arrays->items[*link - 1].next;
	*link = array->next;
	stilb_gpu_image_destroy(device->gpu, array->image);
	*array = (render_array){.next = arrays->free};
	arrays->free = index + 1;
}

bool render_array_expect(render_arrays *arrays, const render_array_kind *kind)
{
	uint32_t h = 0;
	while (h < arrays->hope_count && !array_kind_is(&arrays->hopes[h].kind, kind))
		h++;
	if (h == arrays->hope_count) {
		if (!render_reserve((void **)&arrays->hopes, &arrays->hope_capacity, h + 1, sizeof *arrays->hopes))
			return false;
		arrays->hopes[arrays->hope_count++] = (render_array_hope){.kind = *kind};
	}
	arrays->hopes[h].count++;
	return true;
}

void render_array_expect_none(render_arrays *arrays)
{
	arrays->hope_count = 0;
}

void render_arrays_finish(render_arrays *arrays)
{
	free(arrays->items);
	free(arrays->hopes);
	*arrays = (render_arrays){0};
}
