/* Materials as files mean them, the same in both renderers: on each of the known answers (gltf_answers.c) a frame
 * without shadows equals rays with `--integrator direct --no-shadows`. A frame is drawn FINE times as large along each
 * side, and the mean of its pixels compared. With STILB_TRUTH_PICTURES=FOLDER in the environment the pictures and
 * their difference, times 20, are written there; with STILB_TRUTH_ANSWER=TEXT only answers with TEXT in their name are
 * compared. */
#include "engine.h"
#include "engine_internal.h"
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
#define FINE 6u
#define SAMPLES 256u
#define SAMPLES_CHANCE 4096u

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

/* The mean of FINE x FINE pixels for each pixel. */
static stilb_image framed(stilb_scene *scene)
{
	stilb_engine_report report;
	stilb_image fine = {0}, image;
	assert_int_equal(stilb_engine_set_scene(engine, scene), STILB_OK);
	if (stilb_engine_frame(engine, &report) != STILB_OK || stilb_render_read_image(engine->render, &fine) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	float *row = malloc(sizeof *row * fine.width * fine.channels);
	assert_int_equal(stilb_image_create(&image, WIDTH, HEIGHT, 3, STILB_IMAGE_F32_LINEAR), STILB_OK);
	for (uint32_t y = 0; y < fine.height; y++) {
		stilb_image_row_to_light(&fine, y, row);
		for (uint32_t x = 0; x < fine.width; x++)
			for (uint32_t c = 0; c < 3; c++)
				((float *)image.pixels)[3 * (y / FINE * WIDTH + x / FINE) + c] +=
					row[x * fine.channels + c] / (float)(FINE * FINE);
	}
	free(row);
	stilb_image_finish(&fine);
	assert_int_equal(stilb_engine_set_scene(engine, NULL), STILB_OK);
	return image;
}

/* The picture by rays, and a mask of the pixels that no silhouette touches. */
static stilb_image traced(const stilb_scene *scene, const stilb_render_shading *shading, uint32_t samples,
                          stilb_image *mask)
{
	stilb_gi_scene_desc desc = stilb_gi_scene_desc_default(pool);
	stilb_gi_scene *gi;
	stilb_gi_render *render;
	stilb_image image;
	if (stilb_gi_scene_create(scene, &desc, &gi) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_gi_settings settings = stilb_gi_settings_default(scene);
	settings.integrator = STILB_GI_INTEGRATOR_DIRECT;
	settings.no_shadows = true;
	settings.width = WIDTH;
	settings.height = HEIGHT;
	settings.samples = samples;
	settings.model = (shade_brdf_model){(int)shading->brdf, (int)shading->ndf, (int)shading->g, (int)shading->f};
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
	stilb_image rays = traced(scene, &shading, answer->chance ? SAMPLES_CHANCE : SAMPLES, &mask), live = framed(scene);
	stilb_engine_set_shading(engine, &before);
	if (answer->edges)
		assert_int_equal(stilb_image_mask_edges(&rays, 0.0f, 0.08f, 1, &mask), STILB_OK);
	assert_int_equal(stilb_image_compare(&live, &rays, &mask, 0.0, &apart), STILB_OK);
	write_pictures(answer->name, &live, &rays);
	double range = apart.largest * (answer->chance ? BOUND_CHANCE : 1.0);
	if (answer->pictures && !answer->flat && !(variation(&rays) > 0.05))
		fail_msg("%s: a variation of %g", answer->name, variation(&rays));
	bool good = apart.pixels > WIDTH * HEIGHT / 8 && apart.largest > 0.01 && apart.rms_all <= BOUND_RMS * range &&
	            apart.worst <= BOUND_WORST * range;
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

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(frames_equal_rays)};
	return cmocka_run_group_tests(tests, set_up, tear_down);
}
