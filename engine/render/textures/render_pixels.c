/* The pixels of textures as the device takes them, made a few rows at a time. See render_textures.h. */
#include "render/render_internal.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#define PIXELS_SLICE 16384u /* texels of a job, or a few more */

/* ---- shapes ------------------------------------------------------------------------------------------------------ */

/* True if a device filters blocks of this format at a cost like that of texels: software devices decode BC7 for each
 * read, which takes them 40 times as long. */
static bool shape_takes(const render_device *device, stilb_image_format format)
{
	bool slow = format == STILB_IMAGE_BC7_SRGB || format == STILB_IMAGE_BC7_LINEAR;
	return device->gpu->formats[render_texture_format(format)] & GPU_FORMAT_LINEAR &&
	       !(slow && stilb_gpu_is_software(device->gpu));
}

/* True if the picture's levels end with one that is a single block, behind which mips may be missing. */
static bool shape_ends(const stilb_image *image)
{
	stilb_image last = stilb_image_level(image, stilb_image_level_count(image) - 1);
	return last.width <= 4 && last.height <= 4;
}

render_texture_shape render_texture_shape_of(const render_device *device, const stilb_image *image, bool mapped)
{
	bool blocks = stilb_image_format_is_blocks(image->format) && shape_takes(device, image->format) &&
	              (!mapped || shape_ends(image));
	render_texture_shape shape = {.width = image->width, .height = image->height, .channels = 4, .mapped = mapped};
	shape.given = mapped ? stilb_image_level_count(image) : 1;
	shape.levels = !mapped ? 1 : blocks ? shape.given : render_mip_count(image->width, image->height);
	shape.format = stilb_image_decoded_format(image->format);
	if (blocks) {
		shape.format = image->format;
		shape.channels = image->channels;
	} else if (shape.format == STILB_IMAGE_U16_SRGB) {
		shape.format = STILB_IMAGE_F16_LINEAR;
	}
	return shape;
}

uint64_t render_texture_shape_bytes(const render_texture_shape *shape)
{
	render_array_kind kind = {shape->width, shape->height, render_texture_format(shape->format), shape->levels};
	return render_array_layer(&kind);
}

/* ---- conversion -------------------------------------------------------------------------------------------------- */

/* Writes pixels of four channels; one: the value of alpha where there is none. Compiled for each `channels`, 1 to 3,
 * and `size`, the bytes of a channel. */
__attribute__((always_inline)) static inline void widen_to(const uint8_t *in, size_t pixels, uint32_t channels,
                                                           size_t size, const void *one, uint8_t *out)
{
	for (size_t p = 0; p < pixels; p++, in += channels * size, out += 4 * size) {
		for (uint32_t c = 0; c < 3; c++)
			memcpy(out + c * size, in + (channels == 3 ? c * size : 0), size);
		memcpy(out + 3 * size, channels == 2 ? in + size : one, size);
	}
}

__attribute__((always_inline)) static inline void widen_size(const void *in, size_t pixels, uint32_t channels,
                                                             size_t size, const void *one, uint8_t *out)
{
	if (channels == 1)
		widen_to(in, pixels, 1, size, one, out);
	else if (channels == 2)
		widen_to(in, pixels, 2, size, one, out);
	else
		widen_to(in, pixels, 3, size, one, out);
}

/* Writes pixels of this format with four channels: grey becomes three equal channels, a missing alpha 1. */
static void widen(const void *in, size_t pixels, uint32_t channels, stilb_image_format format, uint8_t *out)
{
	static const uint8_t one_u8 = 255;
	static const uint16_t one_f16 = 0x3c00, one_u16 = 65535;
	static const float one_f32 = 1.0f;
	switch (format) {
	case STILB_IMAGE_F32_LINEAR:
		if (channels == 4)
			memcpy(out, in, pixels * 16);
		else
			widen_size(in, pixels, channels, 4, &one_f32, out);
		break;
	case STILB_IMAGE_F16_LINEAR:
	case STILB_IMAGE_U16_LINEAR:
		if (channels == 4)
			memcpy(out, in, pixels * 8);
		else
			widen_size(in, pixels, channels, 2, format == STILB_IMAGE_F16_LINEAR ? &one_f16 : &one_u16, out);
		break;
	default:
		STILB_ASSERT(format == STILB_IMAGE_U8_SRGB || format == STILB_IMAGE_U8_LINEAR);
		if (channels == 4)
			memcpy(out, in, pixels * 4);
		else
			widen_size(in, pixels, channels, 1, &one_u8, out);
	}
}

/* Rows of a level that are being converted. */
typedef struct conversion {
	stilb_image from, to; /* the level, before and after */
	uint32_t first, end;  /* rows; first is a multiple of 4 */
	uint32_t slice;       /* rows of a job, a multiple of 4 */
	atomic_bool failed;   /* no memory; relaxed: read when all jobs are done */
} conversion;

/* 16-bit codes of sRGB as halves of light: no GPU has such codes. A half's step is finer than a quarter of an 8-bit
 * code's. */
static bool convert_codes(const stilb_image *from, stilb_image *to, uint32_t first, uint32_t end)
{
	size_t row = (size_t)from->width * from->channels;
	float *light = stilb_memory_alloc(row, sizeof *light);
	uint16_t *halves = stilb_memory_alloc(row, sizeof *halves);
	for (uint32_t y = first; y < end && light && halves; y++) {
		stilb_image_row_to_light(from, y, light);
		for (size_t i = 0; i < row; i++)
			halves[i] = stilb_image_half_from_float(light[i]);
		widen(halves, from->width, from->channels, to->format, (uint8_t *)to->pixels + (size_t)y * to->width * 8);
	}
	bool good = light && halves;
	free(light);
	free(halves);
	return good;
}

/* Blocks of one or two channels, which have 16 bits each. */
static bool convert_narrow_blocks(const stilb_image *from, stilb_image *to, uint32_t first, uint32_t end)
{
	stilb_image part = *from, texels = *from;
	uint64_t blocks = stilb_image_size(from) / ((from->height + 3) / 4); /* bytes of a row of them */
	STILB_ASSERT(to->format == STILB_IMAGE_U16_LINEAR && stilb_image_decoded_format(from->format) == to->format);
	texels.format = to->format;
	texels.storage = 0;
	texels.pixels = stilb_memory_alloc((size_t)4 * from->width * from->channels, sizeof(uint16_t));
	for (uint32_t y = first; y < end && texels.pixels; y += 4) {
		part.height = texels.height = end - y < 4 ? end - y : 4;
		part.pixels = (uint8_t *)from->pixels + y / 4 * blocks;
		stilb_image_decode_rows(&part, 0, part.height, &texels);
		widen(texels.pixels, (size_t)part.height * part.width, part.channels, to->format,
		      (uint8_t *)to->pixels + (size_t)y * to->width * 8);
	}
	bool good = texels.pixels;
	free(texels.pixels);
	return good;
}

/* Converts rows first .. end - 1. False: no memory. */
static bool convert_rows(const stilb_image *from, stilb_image *to, uint32_t first, uint32_t end)
{
	bool blocks = stilb_image_format_is_blocks(from->format);
	if (blocks && to->format == from->format) { /* as they are */
		uint64_t row = stilb_image_size(from) / ((from->height + 3) / 4);
		memcpy((uint8_t *)to->pixels + first / 4 * row, (const uint8_t *)from->pixels + first / 4 * row,
		       (end - first + 3) / 4 * row);
		return true;
	}
	if (blocks && from->channels < 4)
		return convert_narrow_blocks(from, to, first, end);
	if (from->format == STILB_IMAGE_U16_SRGB)
		return convert_codes(from, to, first, end);
	if (blocks) {
		stilb_image_decode_rows(from, first, end, to);
		return true;
	}
	size_t in = stilb_image_size(from) / from->height, out = stilb_image_size(to) / to->height;
	widen((const uint8_t *)from->pixels + first * in, (size_t)(end - first) * from->width, from->channels, from->format,
	      (uint8_t *)to->pixels + first * out);
	return true;
}

static void convert_slices(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	conversion *c = context;
	uint32_t first = c->first + begin * c->slice, last = c->first + end * c->slice;
	(void)worker;
	if (!convert_rows(&c->from, &c->to, first, last < c->end ? last : c->end))
		atomic_store_explicit(&c->failed, true, memory_order_relaxed); /* partner: convert */
}

/* Converts rows first .. end - 1 of a level, with the help of a pool. False: no memory. */
static bool convert(const stilb_image *from, const stilb_image *to, uint32_t first, uint32_t end, stilb_job_pool *pool)
{
	conversion c = {.from = *from, .to = *to, .first = first, .end = end};
	c.slice = (PIXELS_SLICE / from->width + 4) / 4 * 4;
	uint32_t slices = (end - first + c.slice - 1) / c.slice;
	atomic_init(&c.failed, false);
	if (pool && slices > 1)
		stilb_job_parallel_for(pool, slices, 1, convert_slices, &c, 0);
	else
		convert_slices(0, slices, 0, &c);
	return !atomic_load_explicit(&c.failed, memory_order_relaxed); /* partner: convert_slices */
}

/* ---- work -------------------------------------------------------------------------------------------------------- */

void render_pixels_finish(render_pixels *pixels)
{
	stilb_image_finish(&pixels->image);
	free(pixels->mips);
	pixels->mips = NULL;
}

stilb_result render_pixels_begin(const render_device *device, const stilb_image *image, render_pixels_way way,
                                 render_pixels_work *work)
{
	render_texture_shape shape = render_texture_shape_of(device, image, way.mapped);
	*work = (render_pixels_work){
		.from = *image, .shape = shape, .kind = way.kind, .to = {.levels = shape.levels, .given = shape.given}};
	stilb_image *made = &work->to.image; /* not stilb_image_create, which clears pages that are written step by step */
	*made = (stilb_image){shape.width, shape.height, shape.channels, shape.format, NULL, 0};
	uint64_t size = stilb_image_size(made), mips = render_texture_shape_bytes(&shape) - size;
	made->pixels = stilb_memory_alloc(size, 1);
	work->to.mips = mips > 0 ? stilb_memory_alloc(mips, 1) : NULL;
	if (!made->pixels || (mips > 0 && !work->to.mips)) {
		render_pixels_finish(&work->to);
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the pixels of a texture of %ux%u pixels", image->width,
		                  image->height);
	}
	work->level = *made;
	work->left = render_mip_texels(shape.width, shape.height, shape.levels);
	if (shape.levels > shape.given)
		render_mips_codes_make(shape.format, way.kind, way.spread, &work->codes);
	return STILB_OK;
}

/* Goes on to the next level. */
static void pixels_next(render_pixels_work *work)
{
	stilb_image *level = &work->level;
	work->before = *level;
	level->pixels = work->number == 0 ? work->to.mips : (uint8_t *)level->pixels + stilb_image_size(level);
	level->width = level->width > 1 ? level->width / 2 : 1;
	level->height = level->height > 1 ? level->height / 2 : 1;
	work->number++;
	work->row = 0;
}

/* Texels of a map of normals that the picture gives do not spread. */
static void pixels_prepare(const render_pixels_work *work, uint32_t rows)
{
	if (work->kind == RENDER_MIPS_MEANS)
		return;
	stilb_image part = work->level;
	STILB_ASSERT(!stilb_image_format_is_blocks(part.format));
	part.pixels = (uint8_t *)part.pixels + stilb_image_size(&part) / part.height * work->row;
	part.height = rows;
	render_mips_prepare(&part, work->kind);
}

stilb_result render_pixels_step(render_pixels_work *work, uint64_t texels, stilb_job_pool *pool)
{
	texels = texels < work->left ? texels : work->left;
	while (texels > 0) {
		uint32_t rows = work->level.height - work->row;
		uint64_t most = (texels / work->level.width / 4 + 1) * 4; /* whole blocks */
		rows = most < rows ? (uint32_t)most : rows;
		uint64_t done = (uint64_t)rows * work->level.width;
		if (work->number < work->shape.given) {
			stilb_image from = stilb_image_level(&work->from, work->number);
			if (!convert(&from, &work->level, work->row, work->row + rows, pool))
				return stilb_fail(STILB_ERROR_MEMORY, "no memory for the pixels of a texture");
			pixels_prepare(work, rows);
		} else {
			render_mips_rows(&work->codes, &work->before, work->row, work->row + rows, pool, &work->level);
		}
		work->row += rows;
		work->left -= done;
		texels -= done < texels ? done : texels;
		if (work->row == work->level.height && work->left > 0)
			pixels_next(work);
	}
	return STILB_OK;
}

stilb_result render_pixels_make(const render_device *device, const stilb_image *image, render_pixels_way way,
                                stilb_job_pool *pool, render_pixels *pixels)
{
	render_pixels_work work;
	stilb_result result = render_pixels_begin(device, image, way, &work);
	*pixels = (render_pixels){0};
	if (result != STILB_OK)
		return result;
	result = render_pixels_step(&work, UINT64_MAX, pool);
	if (result == STILB_OK)
		*pixels = work.to;
	else
		render_pixels_finish(&work.to);
	return result;
}
