/* Textures: their pixels as the device takes them, their handles. See render_textures.h. */
#include "render/render_internal.h"

#include <stdlib.h>
#include <string.h>

bool render_texture_is_valid(const render_resources *resources, uint32_t handle)
{
	uint32_t index = handle & RENDER_INDEX_MASK;
	STILB_ASSERT_LOCKED(&resources->lock);
	return index > 0 && index < STILB_RENDER_MAX_TEXTURES && handle >> RENDER_GENERATION_SHIFT &&
	       resources->textures[index] == handle >> RENDER_GENERATION_SHIFT;
}

/* ---- pixels ------------------------------------------------------------------------------------------------------ */

/* 16-bit codes of sRGB as halves of light, `to` of the same size and channels: no GPU has such codes. A half's step is
 * finer than a quarter of an 8-bit code's. */
static stilb_result texture_codes_to_halves(const stilb_image *from, stilb_image *to)
{
	size_t row = (size_t)from->width * from->channels;
	float *light = stilb_memory_alloc(row, sizeof *light);
	stilb_result result = stilb_image_create(to, from->width, from->height, from->channels, STILB_IMAGE_F16_LINEAR);
	if (result == STILB_OK && !light) {
		stilb_image_finish(to);
		result = stilb_fail(STILB_ERROR_MEMORY, "no memory for the pixels of a texture");
	}
	uint16_t *halves = to->pixels;
	for (uint32_t y = 0; y < from->height && result == STILB_OK; y++) {
		stilb_image_row_to_light(from, y, light);
		for (size_t i = 0; i < row; i++)
			*halves++ = stilb_image_half_from_float(light[i]);
	}
	free(light);
	return result;
}

/* Writes pixels of four channels; one: the value of alpha where there is none. Compiled for each `channels`, 1 to 3,
 * and `size`, the bytes of a channel. */
__attribute__((always_inline)) static inline void texture_widen_to(const uint8_t *in, size_t pixels, uint32_t channels,
                                                                   size_t size, const void *one, uint8_t *out)
{
	for (size_t p = 0; p < pixels; p++, in += channels * size, out += 4 * size) {
		for (uint32_t c = 0; c < 3; c++)
			memcpy(out + c * size, in + (channels == 3 ? c * size : 0), size);
		memcpy(out + 3 * size, channels == 2 ? in + size : one, size);
	}
}

__attribute__((always_inline)) static inline void texture_widen_size(const stilb_image *from, size_t size,
                                                                     const void *one, uint8_t *out)
{
	size_t pixels = (size_t)from->width * from->height;
	if (from->channels == 1)
		texture_widen_to(from->pixels, pixels, 1, size, one, out);
	else if (from->channels == 2)
		texture_widen_to(from->pixels, pixels, 2, size, one, out);
	else
		texture_widen_to(from->pixels, pixels, 3, size, one, out);
}

/* A copy of the picture with four channels: grey becomes three equal channels, and a missing alpha becomes 1. */
static stilb_result texture_widen(const stilb_image *from, stilb_image *to)
{
	static const uint8_t one_u8 = 255;
	static const uint16_t one_f16 = 0x3c00, one_u16 = 65535;
	static const float one_f32 = 1.0f;
	static const void *const ones[] = {&one_u8, &one_f16, &one_f32, &one_u16, &one_u8, &one_u16};
	STILB_ASSERT((size_t)from->format < sizeof ones / sizeof *ones && "no blocks");
	stilb_result result = stilb_image_create(to, from->width, from->height, 4, from->format);
	if (result != STILB_OK)
		return result;
	if (from->channels == 4) {
		memcpy(to->pixels, from->pixels, stilb_image_size(from));
		return STILB_OK;
	}
	size_t size = stilb_image_size(to) / to->width / to->height / 4;
	if (size == 1)
		texture_widen_size(from, 1, ones[from->format], to->pixels);
	else if (size == 2)
		texture_widen_size(from, 2, ones[from->format], to->pixels);
	else
		texture_widen_size(from, 4, ones[from->format], to->pixels);
	return STILB_OK;
}

/* A copy of the picture as the device takes it: texture_widen, no U16_SRGB, and no blocks. */
static stilb_result texture_convert(const stilb_image *from, stilb_image *to)
{
	bool blocks = stilb_image_format_is_blocks(from->format);
	if (from->format != STILB_IMAGE_U16_SRGB && !blocks)
		return texture_widen(from, to);
	stilb_image texels;
	stilb_result result = blocks ? stilb_image_decode(from, &texels) : texture_codes_to_halves(from, &texels);
	if (result != STILB_OK)
		return result;
	if (texels.channels == 4) {
		*to = texels;
		return STILB_OK;
	}
	result = texture_widen(&texels, to);
	stilb_image_finish(&texels);
	return result;
}

/* A texture's pixels as the device takes them. */
typedef struct texture_pixels {
	stilb_image image;
	void *mips; /* NULL: none */
} texture_pixels;

static void texture_pixels_finish(texture_pixels *pixels)
{
	stilb_image_finish(&pixels->image);
	free(pixels->mips);
}

/* mips: it shall have some, if it has more than one texel; pool: as of render_mips_make. */
static stilb_result texture_pixels_make(const stilb_image *image, bool mips, stilb_job_pool *pool,
                                        texture_pixels *pixels)
{
	size_t bytes = 0;
	*pixels = (texture_pixels){0};
	stilb_result result = texture_convert(image, &pixels->image);
	if (result != STILB_OK || !mips)
		return result;
	pixels->mips = render_mips_make(&pixels->image, pool, &bytes);
	if (pixels->mips || bytes == 0)
		return STILB_OK;
	texture_pixels_finish(pixels);
	return stilb_fail(STILB_ERROR_MEMORY, "no memory for the mips of a texture of %ux%u pixels", image->width,
	                  image->height);
}

/* Takes an index and queues the pixels. False: no memory or no id; then nothing has changed. */
static bool texture_add(render_resources *resources, texture_pixels pixels, bool patient, uint32_t *index)
{
	if (!render_resource_reserve(resources, 1) ||
	    !render_reserve((void **)&resources->uploads, &resources->upload_capacity, resources->upload_count + 1,
	                    sizeof *resources->uploads) ||
	    !render_index_take(&resources->indices[RENDER_RESOURCE_TEXTURE], index))
		return false;
	resources->live++;
	uint32_t *generation = &resources->textures[*index];
	*generation = *generation ? *generation : 1;
	resources->uploads[resources->upload_count++] = render_upload_make(*index, pixels.image, pixels.mips, patient);
	return true;
}

/* Undoes the last texture_add; the lock was held since. */
static void texture_drop(render_resources *resources, uint32_t index)
{
	STILB_ASSERT(resources->upload_count > 0 && resources->uploads[resources->upload_count - 1].texture == index);
	render_index_give_back(&resources->indices[RENDER_RESOURCE_TEXTURE], index);
	resources->upload_count--;
	resources->live--;
}

stilb_result render_texture_write(stilb_render *render, stilb_render_texture texture, const stilb_image *image)
{
	render_resources *resources = &render->resources;
	uint32_t index = texture.id & RENDER_INDEX_MASK;
	texture_pixels pixels;
	stilb_result result = texture_pixels_make(image, render->device->textures[index].mips > 1, render->pool, &pixels);
	if (result != STILB_OK)
		return result;
	stilb_lock_take(&resources->lock);
	STILB_ASSERT(render_texture_is_valid(resources, texture.id));
	render_texture_upload *queued = render_upload_of(resources, index);
	if (queued) {
		render_upload_finish(queued);
		*queued = render_upload_make(index, pixels.image, pixels.mips, queued->patient);
	} else if (render_reserve((void **)&resources->uploads, &resources->upload_capacity, resources->upload_count + 1,
	                          sizeof *resources->uploads)) {
		resources->uploads[resources->upload_count++] = render_upload_make(index, pixels.image, pixels.mips, false);
	} else {
		texture_pixels_finish(&pixels);
		result = stilb_fail(STILB_ERROR_MEMORY, "no memory for the pixels of a texture");
	}
	stilb_lock_give(&resources->lock);
	return result;
}

stilb_result render_texture_create(stilb_render *render, const stilb_image *image, render_texture_way way,
                                   stilb_render_texture *out)
{
	STILB_ASSERT(image && out);
	render_resources *resources = &render->resources;
	texture_pixels pixels;
	uint32_t index;
	*out = (stilb_render_texture){0};
	if (image->channels < 1 || image->channels > 4 || (uint32_t)image->format >= STILB_IMAGE_FORMAT_COUNT)
		return stilb_fail(STILB_ERROR_ARGUMENT, "a texture of %u channels in format %u: there are 1..4 and 0..%d",
		                  image->channels, (unsigned)image->format, STILB_IMAGE_FORMAT_COUNT - 1);
	if (image->width < 1 || image->width > 16384 || image->height < 1 || image->height > 16384)
		return stilb_fail(STILB_ERROR_ARGUMENT, "a texture of %ux%u pixels: a side has 1..16384", image->width,
		                  image->height);
	STILB_ASSERT(image->pixels);
	uint32_t side = render->device->gpu->faults.image_side;
	if (side > 0 && (image->width > side || image->height > side))
		return render_texture_too_large(render->device, side, side, image);
	stilb_result result = texture_pixels_make(image, way.mips, way.pool, &pixels);
	if (result != STILB_OK)
		return result;
	stilb_lock_take(&resources->lock);
	if (!texture_add(resources, pixels, way.patient, &index))
		result = render_resource_no_memory(resources, RENDER_RESOURCE_TEXTURE);
	else {
		result = render_device_texture_create(render->device, index, &pixels.image, way.mips);
		if (result == STILB_OK)
			out->id = render_handle_make(resources->textures[index], index);
		else
			texture_drop(resources, index);
	}
	stilb_lock_give(&resources->lock);
	if (result != STILB_OK)
		texture_pixels_finish(&pixels);
	return result;
}

void render_resources_expect_texture(stilb_render *render, const stilb_image *image)
{
	render_array_kind kind = {image->width, image->height, render_texture_format(image->format)};
	stilb_lock_take(&render->resources.lock);
	render_array_expect(&render->device->arrays, &kind); /* without memory for it there are more images */
	stilb_lock_give(&render->resources.lock);
}

void render_resources_expect_no_textures(stilb_render *render)
{
	stilb_lock_take(&render->resources.lock);
	render_array_expect_none(&render->device->arrays);
	stilb_lock_give(&render->resources.lock);
}

stilb_result render_resources_send(stilb_render *render)
{
	STILB_ASSERT_OWNER(render->owner);
	render_resources *resources = &render->resources;
	stilb_lock_take(&resources->lock);
	STILB_ASSERT(!resources->sending && "between frames");
	for (uint32_t u = 0; u < resources->upload_count; u++) {
		render_texture_upload *upload = &resources->uploads[u];
		bool lives = upload->end_frame == 0 && !upload->patient;
		upload->sent = lives ? upload->count : upload->rows;
	}
	stilb_result result = render_device_textures_update(render->device, resources);
	if (result == STILB_OK)
		render_uploads_sent(resources);
	for (uint32_t u = 0; u < resources->upload_count; u++)
		resources->uploads[u].sent = 0;
	stilb_lock_give(&resources->lock);
	return result;
}

stilb_result stilb_render_texture_create(stilb_render *render, const stilb_image *image, stilb_render_texture *out)
{
	return render_texture_create(render, image, (render_texture_way){0}, out);
}

void stilb_render_texture_destroy(stilb_render *render, stilb_render_texture texture)
{
	render_resources *resources = &render->resources;
	uint32_t index = texture.id & RENDER_INDEX_MASK;
	if (texture.id == 0)
		return;
	stilb_lock_take(&resources->lock);
	STILB_ASSERT(render_texture_is_valid(resources, texture.id));
	render_texture_upload *queued = render_upload_of(resources, index);
	if (queued)
		queued->end_frame = resources->frame + 1; /* the release waits for this one, in which it may be drawn */
	resources->textures[index] = render_generation_after(resources->textures[index]);
	render_resource_retire(resources, RENDER_RESOURCE_TEXTURE, index);
	stilb_lock_give(&resources->lock);
}
