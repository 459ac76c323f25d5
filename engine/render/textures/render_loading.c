/* Textures that are made ready while frames are drawn. See render_loading.h. */
#include "render/textures/render_loading.h"

#include "render/render_internal.h"
#include "shading/shade_srgb.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LOADING_ROWS 32u                            /* of a picture, whose mean is taken for that of all */
#define LOADING_PENDING (4 * RENDER_UPLOAD_A_FRAME) /* bytes that wait for frames; beyond that no more is made */
#define LOADING_BRIGHTEST 65504.0f                  /* of halves */
#define LOADING_EACH 4096u                          /* texels that creating a texture counts as */

/* ---- stand-ins --------------------------------------------------------------------------------------------------- */

/* The mean light of some rows, evenly apart, of the smallest level that has so many, as the device sees it: red, green,
 * blue and alpha. STILB_ERROR_MEMORY. */
static stilb_result loading_mean(const stilb_image *image, float mean[4])
{
	uint32_t level = 0, count = stilb_image_level_count(image);
	while (level + 1 < count && image->height >> (level + 1) >= LOADING_ROWS)
		level++;
	stilb_image from = stilb_image_level(image, level);
	uint32_t rows = from.height < LOADING_ROWS ? from.height : LOADING_ROWS, channels = from.channels;
	float *light = stilb_memory_alloc(from.width, channels * sizeof *light);
	double sum[4] = {0};
	if (!light)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a row of a texture");
	for (uint32_t r = 0; r < rows; r++) {
		stilb_image_row_to_light(&from, (uint32_t)((2 * (uint64_t)r + 1) * from.height / (2ull * rows)), light);
		for (uint32_t x = 0; x < from.width; x++)
			for (uint32_t c = 0; c < channels; c++) /* NaN counts as 0 */
				sum[c] += (double)fminf(fmaxf(light[x * channels + c], 0.0f), LOADING_BRIGHTEST);
	}
	free(light);
	for (uint32_t c = 0; c < 4; c++) {
		uint32_t from_channel = c == 3 ? channels - 1 : channels < 3 ? 0 : c;
		bool one = c == 3 && channels % 2 == 1; /* it has no alpha */
		mean[c] = one ? 1.0f : (float)(sum[from_channel] / ((double)rows * (double)from.width));
	}
	return STILB_OK;
}

/* The nearest of the codes 0 to `most` of a value that the format has for light. */
static uint32_t loading_code(float light, bool srgb, uint32_t most)
{
	float value = srgb ? shade_srgb_from_linear(fminf(light, 1.0f)) : fminf(light, 1.0f);
	return (uint32_t)(value * (float)most + 0.5f);
}

/* A block of one color: both of its ends are that, and all texels the first one. */
static void loading_block(stilb_image_format format, const float mean[4], uint8_t *block)
{
	bool srgb = stilb_image_format_as_data(format) != format;
	bool two = format == STILB_IMAGE_BC5_LINEAR, one = format == STILB_IMAGE_BC4_LINEAR;
	uint32_t color =
		loading_code(mean[0], srgb, 31) << 11 | loading_code(mean[1], srgb, 63) << 5 | loading_code(mean[2], srgb, 31);
	uint8_t first = (uint8_t)loading_code(one || two ? mean[0] : mean[3], false, 255);
	uint8_t ends[16] = {first, first}, *at = ends + 8;
	if (format == STILB_IMAGE_BC1_SRGB || format == STILB_IMAGE_BC1_LINEAR)
		at = ends;
	if (two)
		at[0] = at[1] = (uint8_t)loading_code(mean[3], false, 255);
	else if (!one)
		at[0] = at[2] = (uint8_t)color, at[1] = at[3] = (uint8_t)(color >> 8);
	memcpy(block, ends, one || at == ends ? 8 : 16);
}

/* A texel of four channels. */
static void loading_texel(stilb_image_format format, const float mean[4], void *texel)
{
	for (uint32_t c = 0; c < 4; c++) {
		bool srgb = format == STILB_IMAGE_U8_SRGB && c < 3;
		if (format == STILB_IMAGE_F32_LINEAR)
			((float *)texel)[c] = mean[c];
		else if (format == STILB_IMAGE_F16_LINEAR)
			((uint16_t *)texel)[c] = stilb_image_half_from_float(mean[c]);
		else if (format == STILB_IMAGE_U16_LINEAR)
			((uint16_t *)texel)[c] = (uint16_t)loading_code(mean[c], false, 65535);
		else
			((uint8_t *)texel)[c] = (uint8_t)loading_code(mean[c], srgb, 255);
	}
}

/* A picture of the mean in the format that the device will have, with mips if that has some, and with sides that are
 * powers of two if its sides are: software devices compile their programs for all of that, and would do so again. BC7,
 * which they have decoded, becomes texels. */
static stilb_result loading_stand_in(const render_texture_shape *shape, const float mean[4], stilb_image *out)
{
	stilb_image_format format = shape->format;
	bool bc7 = format == STILB_IMAGE_BC7_SRGB || format == STILB_IMAGE_BC7_LINEAR;
	format = bc7 ? stilb_image_decoded_format(format) : format;
	bool blocks = stilb_image_format_is_blocks(format);
	uint32_t width = (shape->width & (shape->width - 1)) == 0 ? 2 : 3;
	uint32_t height = (shape->height & (shape->height - 1)) == 0 ? 2 : 3;
	stilb_result result = stilb_image_create_levels(out, width, height, shape->channels, format, blocks ? 2 : 1);
	if (result != STILB_OK)
		return result;
	uint64_t bytes = stilb_image_levels_size(out);
	uint64_t step = blocks ? bytes / 2 : bytes / width / height;
	for (uint64_t at = 0; at < bytes; at += step) {
		if (blocks)
			loading_block(format, mean, (uint8_t *)out->pixels + at);
		else
			loading_texel(format, mean, (uint8_t *)out->pixels + at);
	}
	return STILB_OK;
}

stilb_result render_loading_begin(stilb_render *render, render_scene *tables, const stilb_image *image, uint32_t id)
{
	render_scene_texture *now = &tables->textures[id], next = {.mapped = now->mapped,
	                                                           .mips = now->mapped,
	                                                           .kind = now->kind,
	                                                           .as_normals = now->as_normals,
	                                                           .as_other = now->as_other};
	render_texture_shape shape = render_texture_shape_of(render->device, image, now->mapped);
	stilb_image stand_in = {0};
	float mean[4];
	if (!tables->loading)
		tables->loading = calloc(1, sizeof *tables->loading);
	stilb_result result = render_device_texture_check(render->device, &shape);
	if (result == STILB_OK && !tables->loading)
		result = stilb_fail(STILB_ERROR_MEMORY, "no memory for the textures of a scene");
	if (result == STILB_OK)
		result = loading_mean(image, mean);
	if (result == STILB_OK)
		result = loading_stand_in(&shape, mean, &stand_in);
	if (result == STILB_OK)
		result = render_texture_create(render, &stand_in, (render_texture_way){.mips = now->mapped, .kind = now->kind},
		                               &next.texture);
	stilb_image_finish(&stand_in);
	if (result != STILB_OK)
		return result;
	next.width = image->width;
	next.height = image->height;
	next.levels = stilb_image_level_count(image);
	next.format = image->format;
	next.loading = RENDER_LOADING_WAITS;
	next.picture = *image;
	render_loading_cancel(render, tables, id);
	stilb_render_texture_destroy(render, now->texture);
	*now = next;
	tables->loading->left++;
	tables->loading->next = id < tables->loading->next ? id : tables->loading->next;
	return STILB_OK;
}

void render_loading_cancel(stilb_render *render, render_scene *tables, uint32_t id)
{
	render_scene_texture *texture = &tables->textures[id];
	if (texture->loading == RENDER_LOADING_DONE)
		return;
	if (texture->loading == RENDER_LOADING_MADE)
		render_pixels_finish(&tables->loading->work.to);
	if (texture->loading == RENDER_LOADING_COPIED)
		stilb_render_texture_destroy(render, texture->coming);
	texture->loading = RENDER_LOADING_DONE;
	texture->coming = (stilb_render_texture){0};
	texture->picture = (stilb_image){0};
	tables->loading->left--;
}

void render_loading_drop(render_scene *tables)
{
	render_loading *loading = tables->loading;
	if (loading && loading->made < tables->texture_count &&
	    tables->textures[loading->made].loading == RENDER_LOADING_MADE)
		render_pixels_finish(&loading->work.to);
	free(loading);
	tables->loading = NULL;
}

void render_loading_finish(stilb_render *render, render_scene *tables)
{
	for (uint32_t t = 0; tables->loading && t < tables->texture_count; t++)
		render_loading_cancel(render, tables, t);
	render_loading_drop(tables);
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

/* What a frame may still do. */
typedef struct loading_room {
	uint64_t texels;
	uint64_t end_ns; /* 0: no end */
} loading_room;

static bool room_is_left(const loading_room *room)
{
	return room->texels > 0 && (room->end_ns == 0 || stilb_time_ns() < room->end_ns);
}

/* Puts textures that the device has whole, or gets whole with this frame, into their stand-ins' place. */
static void loading_arrive(stilb_render *render, render_scene *tables, uint32_t *arrived)
{
	for (uint32_t t = 0; t < tables->texture_count; t++) {
		render_scene_texture *texture = &tables->textures[t];
		if (texture->loading != RENDER_LOADING_COPIED)
			continue;
		stilb_lock_take(&render->resources.lock);
		const render_texture_upload *upload =
			render_upload_of(&render->resources, texture->coming.id & RENDER_INDEX_MASK);
		bool waits = upload && upload->patient;
		stilb_lock_give(&render->resources.lock);
		if (waits)
			continue;
		stilb_render_texture_destroy(render, texture->texture);
		texture->texture = texture->coming;
		texture->coming = (stilb_render_texture){0};
		texture->picture = (stilb_image){0};
		texture->loading = RENDER_LOADING_DONE;
		texture->arrived = true;
		tables->loading->left--;
		*arrived += 1;
	}
}

/* The next texture that waits begins to be made. False: none waits, or there is an error. */
static bool loading_start(const stilb_render *render, render_scene *tables, stilb_result *result)
{
	render_loading *loading = tables->loading;
	while (loading->next < tables->texture_count && tables->textures[loading->next].loading != RENDER_LOADING_WAITS)
		loading->next++;
	if (loading->next == tables->texture_count)
		return false;
	loading->made = loading->next++;
	render_scene_texture *texture = &tables->textures[loading->made];
	*result =
		render_pixels_begin(render->device, &texture->picture,
	                        (render_pixels_way){texture->mapped, texture->kind, render->specular_aa}, &loading->work);
	if (*result == STILB_OK)
		texture->loading = RENDER_LOADING_MADE;
	return *result == STILB_OK;
}

/* The pixels of the texture that is being made are complete. */
static stilb_result loading_copy(stilb_render *render, render_scene *tables, bool patient)
{
	render_loading *loading = tables->loading;
	render_scene_texture *texture = &tables->textures[loading->made];
	stilb_result result =
		render_texture_create_made(render, &loading->work.shape, loading->work.to, patient, &texture->coming);
	loading->work.to = (render_pixels){0};
	texture->loading = RENDER_LOADING_COPIED;
	return result;
}

/* Makes pixels while there is room. */
static stilb_result loading_make(stilb_render *render, render_scene *tables, loading_room *room, bool patient)
{
	render_loading *loading = tables->loading;
	stilb_result result = STILB_OK;
	while (result == STILB_OK && room_is_left(room)) {
		bool making =
			loading->made < tables->texture_count && tables->textures[loading->made].loading == RENDER_LOADING_MADE;
		if (!making && patient && render_resources_pending(&render->resources) > LOADING_PENDING)
			break;
		if (!making && !loading_start(render, tables, &result))
			break;
		uint64_t before = loading->work.left, most = patient ? RENDER_LOADING_SLICE : UINT64_MAX;
		result = render_pixels_step(&loading->work, room->texels < most ? room->texels : most, render->pool);
		uint64_t done = before - loading->work.left + (loading->work.left == 0 ? LOADING_EACH : 0);
		room->texels -= done < room->texels ? done : room->texels;
		if (result == STILB_OK && loading->work.left == 0)
			result = loading_copy(render, tables, patient);
	}
	return result;
}

stilb_result render_loading_advance(stilb_render *render, render_scene *tables, uint32_t *arrived)
{
	render_loading *loading = tables->loading;
	*arrived = 0;
	if (!loading || loading->left == 0)
		return STILB_OK;
	PROFILE("load textures");
	loading_room room = {.texels = UINT64_MAX};
	stilb_render_textures mode = render_textures_mode(render);
	bool patient = mode != STILB_RENDER_TEXTURES_AT_ONCE;
	if (mode == STILB_RENDER_TEXTURES_EVEN)
		room.texels = RENDER_LOADING_TEXELS;
	if (mode == STILB_RENDER_TEXTURES_SPARE)
		room.end_ns = stilb_time_ns() + RENDER_LOADING_NS;
	if (!patient)
		render_resources_hurry(&render->resources);
	stilb_result result = loading_make(render, tables, &room, patient);
	if (result != STILB_OK && loading->made < tables->texture_count)
		render_loading_cancel(render, tables, loading->made); /* what else is on its way goes on */
	loading_arrive(render, tables, arrived);
	if (loading->left == 0)
		render_resources_expect_no_textures(render);
	return result;
}
