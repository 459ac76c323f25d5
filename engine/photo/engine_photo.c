/*
 * Pictures of any size, by tiles. Each tile is a frame of its own whose camera looks through a part of the picture's
 * frame; around it lies a band, as wide as effects reach, which is drawn and thrown away. Tiles begin at multiples of
 * 64 pixels, so that patterns (dither, tiles of depth of field, halved images) lie where they lie in one piece. What is
 * measured by the picture's height, depth of field's largest circle and the size of lamps' shadow maps, takes that of
 * the whole picture. Occlusion, bloom and reflections reach over all of it, and their pictures are drawn in one piece.
 *
 * Rounding parts the two: a vertex is projected by another matrix, so that an edge may lie some thousandths of a pixel
 * beside; and a tile's noise of `--dither triangular` begins anew, up to a code.
 */
#include "engine_internal.h"

#include "profiler/prof.h"

#include <stdio.h>
#include <string.h>

#define PHOTO_TILE 1024u
#define PHOTO_PIECE 16384u   /* a side of a picture in one piece, pixels */
#define PHOTO_FRAMES 64u     /* of temporal antialiasing: the places of its jitter */
#define PHOTO_BAND 64u       /* pixels around a tile: more than antialiasing looks along an edge */
#define PHOTO_BAND_LENS 320u /* likewise: the largest circle, and halved images around it */

typedef struct photo_rect {
	uint32_t left, top, right, bottom;
} photo_rect;

const char *stilb_engine_photo_whole(const stilb_engine *engine)
{
	STILB_ASSERT_OWNER(engine->owner);
	const stilb_post_settings *post = &engine->desc.post;
	return post->bloom > 0.0f                                        ? "bloom scatters light over half of it"
	       : post->occlusion > 0.0f                                  ? "occlusion looks as far as its height says"
	       : post->reflections != STILB_POST_REFLECTIONS_OFF         ? "surfaces mirror all of it"
	       : engine->desc.scale != 1.0f && engine->desc.scale > 0.0f ? "it is drawn in another size, and filtered"
	                                                                 : NULL;
}

static uint32_t photo_band(const stilb_engine *engine)
{
	return engine->desc.post.dof != STILB_POST_DOF_OFF ? PHOTO_BAND_LENS : PHOTO_BAND;
}

/* ---- a frame of it ----------------------------------------------------------------------------------------------- */

/* Draws what engine->part says; with temporal antialiasing so many frames that each pixel has seen its places. */
static stilb_result photo_draw(stilb_engine *engine, uint32_t width, uint32_t height)
{
	uint64_t frame = engine->frame;
	uint32_t frames = engine->desc.post.aa == STILB_POST_AA_TEMPORAL ? PHOTO_FRAMES : 1;
	stilb_result result = stilb_render_resize(engine->render, width, height);
	stilb_post_set_whole(engine->post, engine->part.height);
	stilb_render_forget_levels(engine->render); /* those of another picture, or tile */
	for (uint32_t f = 0; f < frames && result == STILB_OK; f++) {
		engine->frame = f;
		result = engine_frame_again(engine, false);
		if (result == STILB_OK)
			engine_shadows_drawn(engine);
	}
	engine->frame = frame;
	return result;
}

/* Copies a rectangle of the picture from the tile that begins at left, top; the first one says what pixels are. */
static stilb_result photo_copy(const engine_part *part, const stilb_image *tile, photo_rect rect, stilb_image *picture)
{
	stilb_result result = STILB_OK;
	if (!picture->pixels)
		result = stilb_image_create(picture, part->width, part->height, tile->channels, tile->format);
	if (result != STILB_OK)
		return result;
	size_t pixel = stilb_image_size(tile) / ((size_t)tile->width * tile->height);
	for (uint32_t y = rect.top; y < rect.bottom; y++)
		memcpy((char *)picture->pixels + ((size_t)y * part->width + rect.left) * pixel,
		       (const char *)tile->pixels + ((size_t)(y - part->top) * tile->width + rect.left - part->left) * pixel,
		       (rect.right - rect.left) * pixel);
	return STILB_OK;
}

static uint32_t photo_less(uint32_t from, uint32_t by)
{
	return from > by ? from - by : 0;
}

static uint32_t photo_most(uint32_t a, uint32_t most)
{
	return a < most ? a : most;
}

/* Draws a tile with the band around it as far as the picture goes, and takes it over. */
static stilb_result photo_tile(stilb_engine *engine, const char *path, photo_rect rect, uint32_t band,
                               stilb_image *picture)
{
	engine_part *part = &engine->part;
	stilb_image tile = {0};
	part->left = photo_less(rect.left, band);
	part->top = photo_less(rect.top, band);
	uint32_t right = photo_most(rect.right + band, part->width), bottom = photo_most(rect.bottom + band, part->height);
	stilb_result result = photo_draw(engine, right - part->left, bottom - part->top);
	if (result == STILB_OK)
		result = stilb_render_read_for_file(engine->render, path, &tile);
	if (result == STILB_OK)
		result = photo_copy(part, &tile, rect, picture);
	stilb_image_finish(&tile);
	return result;
}

static stilb_result photo_tiles(stilb_engine *engine, const stilb_engine_photo *photo, stilb_image *picture)
{
	bool whole = stilb_engine_photo_whole(engine);
	uint32_t side = whole ? PHOTO_PIECE : photo->tile > 0 ? photo->tile : PHOTO_TILE, band = photo_band(engine);
	engine->part = (engine_part){.width = photo->width, .height = photo->height};
	stilb_result result = STILB_OK;
	for (uint32_t y = 0; y < photo->height && result == STILB_OK; y += side)
		for (uint32_t x = 0; x < photo->width && result == STILB_OK; x += side) {
			photo_rect rect = {x, y, photo_most(x + side, photo->width), photo_most(y + side, photo->height)};
			result = photo_tile(engine, photo->path, rect, band, picture);
		}
	return result;
}

/* ---- the picture ------------------------------------------------------------------------------------------------- */

static stilb_result photo_check(const stilb_engine *engine, const stilb_engine_photo *photo)
{
	const char *whole = stilb_engine_photo_whole(engine);
	if (!engine->scene || !engine->lasts[0].known)
		return stilb_fail(STILB_ERROR_ARGUMENT, "a photo is of the last frame, and none of a scene has been drawn");
	if (engine->picture.shown)
		return stilb_fail(STILB_ERROR_ARGUMENT, "a photo is of frames; leave the picture that is shown over them");
	if (whole && (photo->width > PHOTO_PIECE || photo->height > PHOTO_PIECE))
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "%ux%u is more than one piece of %u, and %s; switch that off, or take a smaller picture",
		                  photo->width, photo->height, PHOTO_PIECE, whole);
	uint64_t bytes = (uint64_t)photo->width * photo->height * (stilb_image_path_is_light(photo->path) ? 12 : 4);
	if (bytes > STILB_IMAGE_MAX_BYTES)
		return stilb_fail(STILB_ERROR_ARGUMENT, "a photo of %ux%u takes %.3g GiB; give one of up to 4", photo->width,
		                  photo->height, (double)bytes * 0x1p-30);
	return stilb_image_path_check(photo->path);
}

stilb_result stilb_engine_photo_take(stilb_engine *engine, const stilb_engine_photo *photo)
{
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT(photo && photo->path);
	STILB_ASSERT(photo->width >= 1 && photo->width <= STILB_ENGINE_PHOTO_SIDE);
	STILB_ASSERT(photo->height >= 1 && photo->height <= STILB_ENGINE_PHOTO_SIDE);
	STILB_ASSERT(photo->tile % STILB_ENGINE_PHOTO_STEP == 0 && photo->tile <= 8192);
	PROFILE("photo");
	stilb_result result = photo_check(engine, photo);
	if (result != STILB_OK)
		return result;
	stilb_image picture = {0};
	uint32_t size[2], cameras = engine->camera_count;
	engine_last last = engine->lasts[0];
	bool holds = engine->holds;
	stilb_render_size(engine->render, &size[0], &size[1]);
	engine->camera_count = 0;
	result = photo_tiles(engine, photo, &picture);
	stilb_scene_look look = engine_look(&engine->views[0]);
	engine->part = (engine_part){0};
	engine->camera_count = cameras;
	engine->lasts[0] = last;
	engine->holds = holds;
	stilb_post_set_whole(engine->post, 0);
	stilb_render_forget_levels(engine->render);
	stilb_result back = stilb_render_resize(engine->render, size[0], size[1]);
	engine->culled_size[0] = 0;
	engine->dumpable = false;
	if (result == STILB_OK)
		result = stilb_scene_look_save(&look, &picture, photo->path);
	stilb_image_finish(&picture);
	return result == STILB_OK ? back : result;
}
