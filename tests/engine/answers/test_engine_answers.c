/* Materials as files mean them, the same in both renderers: on each of the known answers (gltf_answers.c) a frame
 * without shadows equals rays with `--integrator direct --shadows off`, and what --show shows of it is the same.
 * A frame is drawn FINE times as large along each side, and the mean of its pixels compared. With
 * STILB_TRUTH_PICTURES=FOLDER in the environment the pictures and their difference, times 20, are written there; with
 * STILB_TRUTH_ANSWER=TEXT only answers with TEXT in their name are compared. */
#include "engine.h"
#include "engine_internal.h"
#include "framed.h"
#include "gi/gi_render.h"
#include "gltf_answers.h"
#include "image/image_compare.h"
#include "support/folder.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WIDTH 64u
#define HEIGHT 64u
#define FINE (TEST_ASAN ? 1u : 6u) /* the address sanitizer looks at how files are read and shown, not at the numbers */
#define SAMPLES (TEST_ASAN ? 2u : 256u)
#define SAMPLES_CHANCE (TEST_ASAN ? 2u : 4096u)
#define SAMPLES_CHANNEL (TEST_ASAN ? 2u : 64u)

/* The bounds, shares of the largest value: of the root of the mean square, and of the worst pixel. */
#define BOUND_RMS 1e-3
#define BOUND_WORST 1e-2
#define BOUND_CHANCE 8.0 /* times these: a half by chance has a noise of 0.5 / sqrt(SAMPLES_CHANCE) */

static stilb_engine *engine;
static stilb_job_pool *pool;
static char told[8192];

static void take_log(void *user, const char *line)
{
	(void)user;
	size_t used = strlen(told);
	snprintf(told + used, sizeof told - used, "%s\n", line);
}

static int set_up(void **state)
{
	stilb_job_pool_desc pool_desc = {.worker_count = 2, .affinity = STILB_JOB_AFFINITY_NONE};
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.width = WIDTH * FINE;
	desc.height = HEIGHT * FINE;
	desc.output = STILB_RENDER_OUTPUT_LINEAR;
	desc.validate = true;
	desc.workers = 1;
	stilb_log_set(take_log, NULL);
	if (folder_make(state) != 0 || stilb_job_pool_create(&pool_desc, &pool) != 0)
		return -1;
	return stilb_engine_create(&desc, &engine) == STILB_OK ? 0 : -1;
}

static int tear_down(void **state)
{
	(void)state;
	int messages = (int)stilb_engine_validation_messages(engine);
	stilb_engine_destroy(engine);
	stilb_job_pool_destroy(pool);
	stilb_log_set(NULL, NULL);
	folder_clear();
	return folder_remove() != 0 || messages > 0 ? -1 : 0;
}

static stilb_image framed(stilb_scene *scene)
{
	return framed_by(engine, scene, FINE);
}

/* The settings of the picture by rays. */
static stilb_gi_settings lit(const stilb_scene *scene, uint32_t samples)
{
	stilb_render_shading shading = stilb_engine_shading(engine);
	stilb_gi_settings settings = stilb_gi_settings_default(scene);
	settings.integrator = STILB_GI_INTEGRATOR_DIRECT;
	settings.no_shadows = true;
	settings.width = WIDTH;
	settings.height = HEIGHT;
	settings.samples = samples;
	settings.model = (shade_brdf_model){(int)shading.brdf, (int)shading.ndf, (int)shading.g, (int)shading.f};
	return settings;
}

static stilb_gi_settings shown(const stilb_scene *scene, stilb_scene_surface_channel channel)
{
	stilb_gi_settings settings = lit(scene, SAMPLES_CHANNEL);
	settings.integrator = STILB_GI_INTEGRATOR_CHANNEL;
	settings.no_shadows = false;
	settings.channel = channel;
	return settings;
}

/* The picture by rays, and a mask of the pixels that no silhouette touches. */
static stilb_image traced(const stilb_scene *scene, stilb_gi_settings settings, stilb_image *mask)
{
	stilb_gi_scene_desc desc = stilb_gi_scene_desc_default(pool);
	stilb_gi_scene *gi;
	stilb_gi_render *render;
	stilb_image image;
	if (stilb_gi_scene_create(scene, &desc, &gi) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	if (stilb_gi_render_create(gi, &settings, pool, &render) != STILB_OK || stilb_gi_render_run(render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_gi_film film = stilb_gi_render_film(render);
	assert_int_equal(stilb_image_create(&image, WIDTH, HEIGHT, 3, STILB_IMAGE_F32_LINEAR), STILB_OK);
	memcpy(image.pixels, film.radiance, stilb_image_size(&image));
	stilb_image depth = {WIDTH, HEIGHT, 1, STILB_IMAGE_F32_LINEAR, (void *)(uintptr_t)film.depth, 0};
	assert_int_equal(stilb_image_mask_edges(&depth, 0.05f, 0.0f, 1, mask), STILB_OK);
	stilb_gi_render_destroy(render);
	stilb_gi_scene_destroy(gi);
	return image;
}

static void write_pictures(const char *name, const stilb_image *live, const stilb_image *rays)
{
	const char *folder = getenv("STILB_TRUTH_PICTURES");
	stilb_image three;
	char path[512];
	if (!folder || stilb_image_create(&three, 3 * WIDTH, HEIGHT, 3, STILB_IMAGE_F32_LINEAR) != STILB_OK)
		return;
	for (uint32_t y = 0; y < HEIGHT; y++)
		for (uint32_t x = 0; x < WIDTH; x++)
			for (uint32_t c = 0; c < 3; c++) {
				float *to = (float *)three.pixels + 3 * (y * 3 * WIDTH + x) + c;
				float a = ((float *)live->pixels)[3 * (y * WIDTH + x) + c];
				float b = ((float *)rays->pixels)[3 * (y * WIDTH + x) + c];
				to[0] = a;
				to[(size_t)3 * WIDTH] = b;
				to[(size_t)6 * WIDTH] = 20.0f * fabsf(a - b);
			}
	snprintf(path, sizeof path, "%s/%s.png", folder, name);
	assert_int_equal(stilb_image_save(&three, path), STILB_OK);
	stilb_image_finish(&three);
}

/* The root of the mean square of what pixels near the middle differ from their mean, a share of that: what a texture
 * does is more than the light's slope over the card, about 0.01. */
static double variation(const stilb_image *image)
{
	double sum = 0.0, squares = 0.0, count = 0.0;
	for (uint32_t y = HEIGHT / 4; y < 3 * HEIGHT / 4; y++)
		for (uint32_t x = WIDTH / 4; x < 5 * WIDTH / 8; x++)
			for (uint32_t c = 0; c < 3; c++) {
				double value = (double)((float *)image->pixels)[3 * (y * WIDTH + x) + c];
				sum += value;
				squares += value * value;
				count++;
			}
	return sqrt(fmax(squares / count - sum * sum / count / count, 0.0)) / (sum / count);
}

/* One answer. Returns false if a bound is passed. */
static bool agrees(const gltf_answer *answer)
{
	stilb_scene *scene = NULL;
	stilb_image mask = {0};
	stilb_image_comparison apart;
	told[0] = '\0';
	if (!gltf_answer_write(answer, "answer.glb") || stilb_scene_open("answer.glb", &scene) != STILB_OK)
		fail_msg("%s: %s", answer->name, stilb_error_message());
	if (answer->says ? !strstr(told, answer->says) : told[0] != '\0')
		fail_msg("%s: told '%s'", answer->name, told);
	stilb_render_shading before = stilb_engine_shading(engine), shading = before;
	if (answer->ggx)
		shading = (stilb_render_shading){
			.brdf = SHADE_BRDF_MICROFACET, .ndf = SHADE_NDF_GGX, .g = SHADE_G_SMITH_GGX, .f = SHADE_F_SCHLICK};
	stilb_engine_set_shading(engine, &shading);
	stilb_image rays = traced(scene, lit(scene, answer->chance ? SAMPLES_CHANCE : SAMPLES), &mask);
	stilb_image live = framed(scene);
	stilb_engine_set_shading(engine, &before);
	if (answer->edges)
		assert_int_equal(stilb_image_mask_edges(&rays, 0.0f, 0.08f, 1, &mask), STILB_OK);
	assert_int_equal(stilb_image_compare(&live, &rays, &mask, 0.0, &apart), STILB_OK);
	write_pictures(answer->name, &live, &rays);
	double range = apart.largest * (answer->chance ? BOUND_CHANCE : 1.0);
	if (!TEST_ASAN && answer->pictures && !answer->flat && !(variation(&rays) > 0.05))
		fail_msg("%s: a variation of %g", answer->name, variation(&rays));
	bool good = apart.pixels > WIDTH * HEIGHT / 8 && apart.largest > 0.01 &&
	            (TEST_ASAN || (apart.rms_all <= BOUND_RMS * range && apart.worst <= BOUND_WORST * range));
	print_message("%-40s rms %.5f worst %.4f at %u, %u; %llu pixels%s\n", answer->name, apart.rms_all / apart.largest,
	              apart.worst / apart.largest, apart.worst_x, apart.worst_y, (unsigned long long)apart.pixels,
	              good ? "" : "  <-- apart");
	stilb_image_finish(&rays);
	stilb_image_finish(&live);
	stilb_image_finish(&mask);
	stilb_scene_destroy(scene);
	return good;
}

static void frames_equal_rays(void **state)
{
	(void)state;
	uint32_t apart = 0;
	const char *only = getenv("STILB_TRUTH_ANSWER");
	for (uint32_t i = 0; i < gltf_answer_count; i++)
		apart += (!only || strstr(gltf_answers[i].name, only)) && !agrees(&gltf_answers[i]);
	assert_int_equal(apart, 0);
}

/* ---- channels ---------------------------------------------------------------------------------------------------- */

/* The answers whose channels are compared. */
static const char *const of_channels[] = {
	"base texture and factor",
	"vertex colours of bytes and a texture",
	"half a metal",
	"metal and roughness by texture",
	"smooth dielectric",
	"normal map and tangents",
	"normal map and a negative scale",
	"normal map on the second uv",
	"occlusion",
	"emission by texture",
	"second uv",
	"mask with a cutoff",
	"blend by texture",
	"double sided from behind",
	"unlit",
	"specular and gloss by texture",
	"all maps",
};

static const gltf_answer *answer_of(const char *name)
{
	for (uint32_t i = 0; i < gltf_answer_count; i++)
		if (strcmp(gltf_answers[i].name, name) == 0)
			return &gltf_answers[i];
	fail_msg("there is no answer '%s'", name);
	return NULL;
}

static stilb_scene *opened(const gltf_answer *answer)
{
	stilb_scene *scene = NULL;
	if (!gltf_answer_write(answer, "answer.glb") || stilb_scene_open("answer.glb", &scene) != STILB_OK)
		fail_msg("%s: %s", answer->name, stilb_error_message());
	return scene;
}

/* One channel of an answer; returns false if the bound is passed. *largest: of the values, at least what it was. */
static bool channel_agrees(const gltf_answer *answer, stilb_scene *scene, stilb_scene_surface_channel channel,
                           double *largest)
{
	char name[128];
	stilb_image mask = {0};
	stilb_image_comparison apart;
	stilb_engine_set_shows(engine, (stilb_render_show)((int)STILB_RENDER_SHOW_BASE + (int)channel));
	stilb_image rays = traced(scene, shown(scene, channel), &mask), live = framed(scene);
	stilb_engine_set_shows(engine, STILB_RENDER_SHOW_SHADED);
	assert_int_equal(stilb_image_mask_edges(&rays, 0.0f, 0.08f, 1, &mask),
	                 STILB_OK); /* texels, and where uv begin anew */
	assert_int_equal(stilb_image_compare(&live, &rays, &mask, 0.0, &apart), STILB_OK);
	snprintf(name, sizeof name, "channel: %s, %s", answer->name, stilb_scene_channel_names[channel]);
	write_pictures(name, &live, &rays);
	*largest = fmax(*largest, apart.largest);
	bool good = apart.pixels > WIDTH * HEIGHT / 8 && (TEST_ASAN || apart.rms_all <= BOUND_RMS);
	print_message("%-58s rms %.5f worst %.4f of %.3f; %llu pixels%s\n", name, apart.rms_all, apart.worst, apart.largest,
	              (unsigned long long)apart.pixels, good ? "" : "  <-- apart");
	stilb_image_finish(&rays);
	stilb_image_finish(&live);
	stilb_image_finish(&mask);
	return good;
}

/* Each channel of each answer, and each channel is more than black in one of them. */
static void channels_equal_rays(void **state)
{
	(void)state;
	uint32_t apart = 0;
	double largest[STILB_SCENE_CHANNELS_OF_RAYS] = {0};
	for (size_t i = 0; i < sizeof of_channels / sizeof *of_channels; i++) {
		const gltf_answer *answer = answer_of(of_channels[i]);
		stilb_scene *scene = opened(answer);
		for (int c = 0; c < STILB_SCENE_CHANNELS_OF_RAYS; c++)
			apart += !channel_agrees(answer, scene, (stilb_scene_surface_channel)c, &largest[c]);
		stilb_scene_destroy(scene);
	}
	for (int c = 0; c < STILB_SCENE_CHANNELS_OF_RAYS; c++)
		assert_true(largest[c] > 0.4);
	assert_int_equal(apart, 0);
}

/* In the middle of the card, by frames and by rays. */
static void channel_is(const char *answer, stilb_scene_surface_channel channel, float x, float y, float z)
{
	const float wanted[3] = {x, y, z};
	stilb_image mask = {0};
	stilb_scene *scene = opened(answer_of(answer));
	stilb_engine_set_shows(engine, (stilb_render_show)((int)STILB_RENDER_SHOW_BASE + (int)channel));
	stilb_image images[2] = {traced(scene, shown(scene, channel), &mask), framed(scene)};
	stilb_engine_set_shows(engine, STILB_RENDER_SHOW_SHADED);
	for (int i = 0; i < 2; i++) {
		const float *pixel = (const float *)images[i].pixels + 3 * (HEIGHT / 2 * WIDTH + WIDTH / 2);
		for (int c = 0; c < 3; c++)
			if (!(fabsf(pixel[c] - wanted[c]) < 2e-3f))
				fail_msg("%s, %s by %s: %g %g %g", answer, stilb_scene_channel_names[channel], i ? "frames" : "rays",
				         (double)pixel[0], (double)pixel[1], (double)pixel[2]);
		stilb_image_finish(&images[i]);
	}
	stilb_image_finish(&mask);
	stilb_scene_destroy(scene);
}

/* What the files say, also where the material has no surface. */
static void channels_have_the_files_values(void **state)
{
	(void)state;
	channel_is("half a metal", STILB_SCENE_CHANNEL_BASE, 1.0f, 0.8f, 0.3f);
	channel_is("half a metal", STILB_SCENE_CHANNEL_METALNESS, 0.5f, 0.5f, 0.5f);
	channel_is("half a metal", STILB_SCENE_CHANNEL_ROUGHNESS, 0.4f, 0.4f, 0.4f);
	channel_is("half a metal", STILB_SCENE_CHANNEL_NORMAL, 0.5f, 0.5f, 1.0f);
	channel_is("half a metal", STILB_SCENE_CHANNEL_OCCLUSION, 1.0f, 1.0f, 1.0f);
	channel_is("half a metal", STILB_SCENE_CHANNEL_ALPHA, 1.0f, 1.0f, 1.0f);
	channel_is("emission", STILB_SCENE_CHANNEL_EMISSION, 0.2f, 0.1f, 0.5f);
	channel_is("base factor", STILB_SCENE_CHANNEL_BASE, 0.8f, 0.4f, 0.1f);
}

/* The middle of what frames show of an answer; *share: the mean of the picture. */
static float framed_middle(const char *answer, stilb_render_show show, double *share)
{
	stilb_scene *scene = opened(answer_of(answer));
	stilb_engine_set_shows(engine, show);
	stilb_image image = framed(scene);
	stilb_engine_set_shows(engine, STILB_RENDER_SHOW_SHADED);
	const float *pixels = image.pixels;
	float middle = pixels[3 * (HEIGHT / 2 * WIDTH + WIDTH / 2)];
	*share = 0.0;
	for (size_t i = 0; i < WIDTH * HEIGHT; i++)
		*share += (double)pixels[3 * i] / (WIDTH * HEIGHT);
	stilb_image_finish(&image);
	stilb_scene_destroy(scene);
	return middle;
}

/* A card is drawn once, one before another one twice; its edges are there and are few. */
static void frames_count_and_draw_lines(void **state)
{
	(void)state;
	double share;
	assert_true(fabsf(framed_middle("base factor", STILB_RENDER_SHOW_OVERDRAW, &share) - 1.0f) < 1e-4f);
	assert_true(share < 0.9);
	assert_true(fabsf(framed_middle("blend", STILB_RENDER_SHOW_OVERDRAW, &share) - 2.0f) < 1e-4f);
	framed_middle("base factor", STILB_RENDER_SHOW_WIREFRAME, &share);
	print_message("edges: %.4f of the picture\n", share);
	assert_true(share > 0.002 && share < (TEST_ASAN ? 0.5 : 0.1)); /* lines are a pixel wide, whatever the size */
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(frames_equal_rays), cmocka_unit_test(channels_equal_rays),
	                                   cmocka_unit_test(channels_have_the_files_values),
	                                   cmocka_unit_test(frames_count_and_draw_lines)};
	return cmocka_run_group_tests(tests, set_up, tear_down);
}
