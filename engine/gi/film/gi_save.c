/* gi_save: the picture as a file: .exr has all planes unchanged, .hdr the radiance, .png the picture as displayed. */
#include "gi/film/gi_picture.h"
#include "gi/gi_render_internal.h"
#include "gi/gi_settings.h"
#include "gi/integrate/gi_backdrop.h"
#include "image/image_layers.h"
#include "profiler/prof.h"
#include "shading/shade_srgb.h"
#include "shading/shade_tonemap.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* ---- texts ------------------------------------------------------------------------------------------------------ */

#define SAVE_MAX_ATTRIBUTES 64u
#define SAVE_PREFIX "stilb:"

typedef struct save_attributes {
	uint32_t count;
	stilb_image_attribute list[SAVE_MAX_ATTRIBUTES];
	struct {
		char name[GI_SETTING_TEXT], text[GI_SURROUNDINGS_TEXT];
	} texts[SAVE_MAX_ATTRIBUTES];
} save_attributes;

static void save_attribute(save_attributes *attributes, const char *name, const char *text)
{
	uint32_t i = attributes->count++;
	STILB_ASSERT(i < SAVE_MAX_ATTRIBUTES);
	snprintf(attributes->texts[i].name, GI_SETTING_TEXT, SAVE_PREFIX "%s", name);
	snprintf(attributes->texts[i].text, GI_SURROUNDINGS_TEXT, "%s", text);
	attributes->list[i] = (stilb_image_attribute){attributes->texts[i].name, attributes->texts[i].text};
}

/* Writes all settings, those of the display (GI_SETTING_VIEW; a grade has no name here) only if the file is for
 * display, and nothing about the run itself, so that a picture is the same file whether its render ran through or was
 * stopped and continued. */
static void save_settings(const gi_picture *picture, bool display, save_attributes *attributes)
{
	attributes->count = 0;
	for (uint32_t i = 0; i < gi_settings_count(); i++) {
		gi_setting setting = gi_settings_get(picture->settings, i);
		if (display || setting.role != GI_SETTING_VIEW)
			save_attribute(attributes, setting.name, setting.value);
	}
	save_attribute(attributes, "environment", picture->surroundings);
	save_attribute(attributes, "isa", picture->isa);
}

/* ---- .png -------------------------------------------------------------------------------------------------------- */

#define DISPLAY_BRIGHTEST 1e30f /* largest radiance that the tone map accepts */

/* NaN becomes black. */
static float display_light(float radiance, float scale)
{
	return fminf(fmaxf(radiance * scale, 0.0f), DISPLAY_BRIGHTEST);
}

static uint8_t display_code(float light)
{
	return (uint8_t)(shade_srgb_from_linear(light) * 255.0f + 0.5f);
}

void stilb_gi_display(const float *rgb, size_t pixels, float exposure, uint32_t tone, uint8_t *srgb)
{
	STILB_ASSERT(((rgb && srgb) || pixels == 0) && tone < SHADE_TONE_COUNT);
	float scale = exp2f(exposure);
	for (size_t i = 0; i < pixels; i++, rgb += 3, srgb += 3) {
		stilb_vec3 light = {display_light(rgb[0], scale), display_light(rgb[1], scale), display_light(rgb[2], scale)};
		stilb_vec3 shown = shade_tone((int)tone, light);
		for (int c = 0; c < 3; c++)
			srgb[c] = display_code(shown[c]);
	}
}

/* Adds triangular noise of at most one code to a code in [0, 255]; near the ends as much as there is room for, so that
 * the mean stays. As dithered_by_triangle of tone.frag; noise of Jimenez, "Next Generation Post Processing in Call of
 * Duty: Advanced Warfare" (2014). pixel: its number in a picture of this width. */
static float display_dithered(float code, size_t pixel, size_t width)
{
	size_t row = pixel / width;
	float x = (float)(pixel - row * width), y = (float)row;
	float inner = 0.06711056f * x + 0.00583715f * y, noise = 52.9829189f * (inner - floorf(inner));
	float away = 2.0f * (noise - floorf(noise)) - 1.0f, share = copysignf(1.0f - sqrtf(1.0f - fabsf(away)), away);
	float room = fminf(fminf(code, 255.0f - code) + 0.5f, 1.0f);
	return fminf(fmaxf(code + room * share, 0.0f), 255.0f);
}

/* As stilb_gi_display, graded. */
static void display_graded(const gi_picture *picture, const float *rgb, size_t pixels, uint8_t *srgb)
{
	const stilb_gi_grade *grade = picture->grade;
	float scale = exp2f(picture->settings->exposure);
	for (size_t i = 0; i < pixels; i++, rgb += 3, srgb += 3) {
		stilb_vec3 light = {display_light(rgb[0], scale), display_light(rgb[1], scale), display_light(rgb[2], scale)};
		stilb_vec3 shown = shade_tone((int)picture->settings->tone, light);
		float codes[3], out[3];
		for (int c = 0; c < 3; c++)
			codes[c] = out[c] = shade_srgb_from_linear(shown[c]);
		if (grade->at)
			grade->at(grade->user, codes, out);
		for (int c = 0; c < 3; c++) {
			float code = 255.0f * fminf(fmaxf(out[c], 0.0f), 1.0f);
			srgb[c] = (uint8_t)((grade->dither ? display_dithered(code, i, picture->film->width) : code) + 0.5f);
		}
	}
}

/* What the settings make of the picture for display. rgb: is changed. */
static void save_codes(const gi_picture *picture, float *rgb, size_t pixels, uint8_t *srgb)
{
	const stilb_gi_settings *settings = picture->settings;
	bool channel = settings->integrator == STILB_GI_INTEGRATOR_CHANNEL;
	if (gi_shows_data(settings))
		gi_data_to_light(rgb, pixels);
	if (picture->grade && !channel) {
		display_graded(picture, rgb, pixels, srgb);
		return;
	}
	stilb_gi_display(rgb, pixels, channel ? 0.0f : settings->exposure, channel ? SHADE_TONE_NONE : settings->tone,
	                 srgb);
}

/* The picture for display with alpha, of what is shown before nothing: rgb, whose radiance is a mean over all samples,
 * is made the mean over those that hit something. srgb: [pixels][4]. */
static bool save_with_alpha(const gi_picture *picture, float *rgb, uint8_t *srgb)
{
	size_t pixels = (size_t)picture->film->width * picture->film->height;
	float *share = stilb_memory_alloc(pixels, sizeof *share);
	uint8_t *opaque = stilb_memory_alloc(pixels, 3);
	bool good = share && opaque;
	if (good)
		gi_film_coverage(picture->film, share);
	for (size_t i = 0; good && i < pixels; i++)
		for (size_t c = 0; c < 3 && share[i] > 0.0f; c++)
			rgb[3 * i + c] /= share[i];
	if (good)
		save_codes(picture, rgb, pixels, opaque);
	for (size_t i = 0; good && i < pixels; i++) {
		memcpy(srgb + 4 * i, opaque + 3 * i, 3);
		srgb[4 * i + 3] = (uint8_t)(share[i] * 255.0f + 0.5f);
	}
	free(share);
	free(opaque);
	return good;
}

/* A pixel without samples shows a pixel near it, as in stilb_gi_render_preview, so that a progressive picture that was
 * stopped has no holes. */
static stilb_result save_display(const gi_picture *picture, const char *path)
{
	const gi_film *film = picture->film;
	size_t pixels = (size_t)film->width * film->height;
	bool alpha = picture->transparent;
	stilb_image image;
	stilb_result result = stilb_image_create(&image, film->width, film->height, alpha ? 4 : 3, STILB_IMAGE_U8_SRGB);
	if (result != STILB_OK)
		return result;
	float *rgb = stilb_memory_alloc(pixels, sizeof(float[3]));
	bool good = rgb;
	if (good)
		gi_film_picture(film, rgb);
	if (good && alpha)
		good = save_with_alpha(picture, rgb, image.pixels);
	else if (good)
		save_codes(picture, rgb, pixels, image.pixels);
	save_attributes attributes;
	save_settings(picture, true, &attributes);
	result = good ? stilb_image_save_with(&image, path, attributes.list, attributes.count)
	              : stilb_fail(STILB_ERROR_MEMORY, "cannot write '%s': out of memory", path);
	free(rgb);
	stilb_image_finish(&image);
	return result;
}

/* ---- .exr -------------------------------------------------------------------------------------------------------- */

#define SAVE_CHANNELS 15 /* the last is there with a backdrop of nothing alone */
_Static_assert(SAVE_CHANNELS * sizeof(float) * (uint64_t)STILB_GI_MAX_PIXELS <= STILB_IMAGE_MAX_BYTES,
               "what can be rendered can be saved");

/* The three channels of one plane. */
static void save_triple(stilb_image_channel *channels, const char *const names[3], const float *plane)
{
	for (int c = 0; c < 3; c++)
		channels[c] = (stilb_image_channel){.name = names[c], .values = plane + c, .stride = 3};
}

/* [3] The radiance that the file shows. */
static const float *save_radiance(const stilb_gi_film *film)
{
	return film->denoised ? film->denoised : film->radiance;
}

/* counts: [width x height] memory for the sample counts as floats, which hold them exactly. share: likewise, alpha. */
static void save_channels(const stilb_gi_film *film, float *counts, const float *share,
                          stilb_image_channel channels[SAVE_CHANNELS])
{
	for (size_t i = 0; i < (size_t)film->width * film->height; i++)
		counts[i] = (float)film->samples[i];
	save_triple(channels, (const char *[]){"R", "G", "B"}, save_radiance(film));
	save_triple(channels + 3, (const char *[]){"albedo.R", "albedo.G", "albedo.B"}, film->albedo);
	save_triple(channels + 6, (const char *[]){"normal.X", "normal.Y", "normal.Z"}, film->normal);
	save_triple(channels + 9, (const char *[]){"variance.R", "variance.G", "variance.B"}, film->variance);
	channels[12] = (stilb_image_channel){.name = "depth.Z", .values = film->depth, .stride = 1};
	channels[13] = (stilb_image_channel){.name = "samples", .values = counts, .stride = 1};
	channels[14] = (stilb_image_channel){.name = "A", .values = share, .stride = 1};
}

static stilb_result save_layers(const gi_picture *picture, const char *path)
{
	stilb_gi_film film = gi_film_planes(picture->film);
	bool alpha = picture->transparent;
	size_t pixels = (size_t)film.width * film.height;
	float *counts = stilb_memory_alloc(alpha ? 2 * pixels : pixels, sizeof *counts);
	if (!counts)
		return stilb_fail(STILB_ERROR_MEMORY, "cannot write '%s': out of memory", path);
	float *share = alpha ? counts + pixels : NULL;
	if (alpha)
		gi_film_coverage(picture->film, share);
	stilb_image_channel channels[SAVE_CHANNELS];
	save_attributes attributes;
	save_channels(&film, counts, share, channels);
	save_settings(picture, false, &attributes);
	stilb_image_layers layers = {.width = film.width,
	                             .height = film.height,
	                             .channel_count = SAVE_CHANNELS - !alpha,
	                             .attribute_count = attributes.count,
	                             .channels = channels,
	                             .attributes = attributes.list};
	stilb_result result = stilb_image_layers_save(&layers, path);
	free(counts);
	return result;
}

/* ---- .hdr -------------------------------------------------------------------------------------------------------- */

static stilb_result save_light(const gi_picture *picture, const char *path)
{
	stilb_gi_film film = gi_film_planes(picture->film);
	stilb_image image = {.width = film.width,
	                     .height = film.height,
	                     .channels = 3,
	                     .format = STILB_IMAGE_F32_LINEAR,
	                     .pixels = (float *)save_radiance(&film)}; /* is only read */
	save_attributes attributes;
	save_settings(picture, false, &attributes);
	return stilb_image_save_with(&image, path, attributes.list, attributes.count);
}

stilb_result gi_picture_save(const gi_picture *picture, const char *path)
{
	STILB_ASSERT(picture && path);
	PROFILE("gi.save");
	stilb_result result = stilb_image_path_check(path);
	if (result != STILB_OK)
		return result;
	if (!stilb_image_path_is_light(path))
		return save_display(picture, path);
	const char *dot = strrchr(path, '.');
	return strcasecmp(dot, ".exr") == 0 ? save_layers(picture, path) : save_light(picture, path);
}

stilb_result stilb_gi_render_save(stilb_gi_render *render, const char *path)
{
	return stilb_gi_render_save_graded(render, path, NULL);
}

stilb_result stilb_gi_render_save_graded(stilb_gi_render *render, const char *path, const stilb_gi_grade *grade)
{
	STILB_ASSERT(render && path);
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(render->begun_ns == 0 && "run does not run");
	if (render->view.settings.denoise && !render->film.denoised) {
		stilb_result result = stilb_gi_render_denoise(render);
		if (result != STILB_OK)
			return result;
	}
	const stilb_gi_scene *scene = render->view.scene;
	gi_picture picture = {.settings = &render->view.settings,
	                      .film = &render->film,
	                      .grade = grade,
	                      .surroundings = scene->surroundings,
	                      .isa = scene->info.isa,
	                      .transparent = gi_backdrop_is_nothing(scene->backdrop)};
	return gi_picture_save(&picture, path);
}
