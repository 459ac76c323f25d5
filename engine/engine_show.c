/* What the program says of a picture of its own, shown in place of the scene or to the right of a divider that the user
 * drags, and of the caption, a line in the picture's corner. engine_picture.c draws them. */
#include "engine_internal.h"

#include <stdio.h>

/* Copies the pixels; their alpha is 1. */
static stilb_result show_copy(engine_shown *picture, const stilb_engine_shown *from)
{
	stilb_image *image = &picture->radiance;
	if (image->width != from->width || image->height != from->height) {
		stilb_image_finish(image);
		stilb_result result = stilb_image_create(image, from->width, from->height, 4, STILB_IMAGE_F32_LINEAR);
		if (result != STILB_OK)
			return result;
	}
	const float *in = from->radiance;
	float *out = image->pixels;
	for (size_t i = 0, count = (size_t)from->width * from->height; i < count; i++, in += 3, out += 4) {
		out[0] = in[0];
		out[1] = in[1];
		out[2] = in[2];
		out[3] = 1.0f;
	}
	picture->stale = true;
	return STILB_OK;
}

stilb_result stilb_engine_show(stilb_engine *engine, const stilb_engine_shown *picture)
{
	STILB_ASSERT_OWNER(engine->owner);
	if (!picture) {
		engine_picture_finish(engine);
		return STILB_OK;
	}
	STILB_ASSERT(picture->from && (picture->radiance || engine->picture.shown));
	STILB_ASSERT(!picture->radiance || (picture->width >= 1 && picture->height >= 1));
	STILB_ASSERT(!picture->radiance || (picture->width <= 16384 && picture->height <= 16384));
	stilb_result result = picture->radiance ? show_copy(&engine->picture, picture) : STILB_OK;
	bool divider = picture->divider && engine->window;
	if (result == STILB_OK && divider)
		result = engine_overlay_create(engine);
	if (result != STILB_OK) {
		engine_picture_finish(engine);
		return result;
	}
	if (!picture->still)
		engine_picture_forget_scene(engine);
	engine->picture.shown = true;
	engine->picture.still = picture->still;
	engine->overlay.divider_open = divider;
	engine->picture.from = picture->from;
	return STILB_OK;
}

void stilb_engine_caption(stilb_engine *engine, const char *text)
{
	STILB_ASSERT_OWNER(engine->owner);
	engine->overlay.caption_open = false;
	if (!text || !engine->window)
		return;
	if (engine_overlay_create(engine) == STILB_OK)
		engine->overlay.caption_open = snprintf(engine->caption, sizeof engine->caption, "%s", text) > 0;
	else
		stilb_log("%s: %s", text, stilb_error_message());
}
