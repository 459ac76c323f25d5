/* Frames beside rays on larger models (gltf_models.h), in the metric of Khronos' glTF-Render-Fidelity set: lit by a
 * panorama alone, without shadows. With STILB_TRUTH_PICTURES=FOLDER in the environment models, panorama and pictures
 * stay in that folder; STILB_MODEL_SIDE=N makes the helmet's pictures of N x N texels. */
#include "engine.h"
#include "engine_internal.h"
#include "framed.h"
#include "gi/gi_render.h"
#include "gltf_models.h"
#include "image/image_compare.h"
#include "support/folder.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SIDE 160u /* of pictures; frames are FINE times as large along each side, and their means compared */
#define FINE 8u
#define SAMPLES 256u

static stilb_engine *engine;
static stilb_job_pool *pool;

static int set_up(void **state)
{
	stilb_job_pool_desc pool_desc = {.worker_count = 2, .affinity = STILB_JOB_AFFINITY_NONE};
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.width = desc.height = SIDE * FINE;
	desc.output = STILB_RENDER_OUTPUT_LINEAR;
	desc.validate = true;
	desc.workers = 1;
	desc.shading.brdf = SHADE_BRDF_MICROFACET; /* as stilb view has it */
	const char *folder = getenv("STILB_TRUTH_PICTURES");
	if ((folder ? chdir(folder) : folder_make(state)) != 0 || stilb_job_pool_create(&pool_desc, &pool) != 0)
		return -1;
	return stilb_engine_create(&desc, &engine) == STILB_OK ? 0 : -1;
}

static int tear_down(void **state)
{
	(void)state;
	int messages = engine ? (int)stilb_engine_validation_messages(engine) : 1;
	stilb_engine_destroy(engine);
	stilb_job_pool_destroy(pool);
	if (getenv("STILB_TRUTH_PICTURES"))
		return messages > 0 ? -1 : 0;
	folder_clear();
	return folder_remove() != 0 || messages > 0 ? -1 : 0;
}

static stilb_image framed(stilb_scene *scene)
{
	return framed_by(engine, scene, FINE);
}

static stilb_image traced(const stilb_scene *scene)
{
	stilb_gi_scene_desc desc = stilb_gi_scene_desc_default(pool);
	stilb_render_shading shading = stilb_engine_shading(engine);
	stilb_gi_scene *gi;
	stilb_gi_render *render;
	stilb_image image;
	if (stilb_gi_scene_create(scene, &desc, &gi) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_gi_settings settings = stilb_gi_settings_default(scene);
	settings.integrator = STILB_GI_INTEGRATOR_DIRECT;
	settings.no_shadows = true;
	settings.width = settings.height = SIDE;
	settings.samples = SAMPLES;
	settings.model = (shade_brdf_model){(int)shading.brdf, (int)shading.ndf, (int)shading.g, (int)shading.f};
	if (stilb_gi_render_create(gi, &settings, pool, &render) != STILB_OK || stilb_gi_render_run(render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_gi_film film = stilb_gi_render_film(render);
	assert_int_equal(stilb_image_create(&image, SIDE, SIDE, 3, STILB_IMAGE_F32_LINEAR), STILB_OK);
	memcpy(image.pixels, film.radiance, stilb_image_size(&image));
	stilb_gi_render_destroy(render);
	stilb_gi_scene_destroy(gi);
	return image;
}

/* Opens NAME.gltf under room.exr, compares both renderers, and says how far they are apart. */
static double fidelity(const char *name)
{
	char path[64];
	stilb_scene *scene;
	double db;
	snprintf(path, sizeof path, "%s.gltf", name);
	if (stilb_scene_open(path, &scene) != STILB_OK || stilb_scene_set_environment(scene, "room.exr") != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_image live = framed(scene), rays = traced(scene);
	assert_int_equal(stilb_image_fidelity(&live, &rays, NULL, &db), STILB_OK);
	print_message("%s: %.1f dB\n", name, db);
	snprintf(path, sizeof path, "%s-live.png", name);
	assert_int_equal(stilb_image_save(&live, path), STILB_OK);
	snprintf(path, sizeof path, "%s-rays.png", name);
	assert_int_equal(stilb_image_save(&rays, path), STILB_OK);
	stilb_image_finish(&live);
	stilb_image_finish(&rays);
	stilb_scene_destroy(scene);
	return db;
}

static void a_helmet_is_near_rays(void **state)
{
	(void)state;
	const char *side = getenv("STILB_MODEL_SIDE");
	if (!gltf_model_helmet(side ? (uint32_t)atoi(side) : 512) || !gltf_model_room("room.exr", 512))
		fail_msg("%s", stilb_error_message());
	assert_true(fidelity("helmet") <= -30.0);
}

static void spheres_are_near_rays(void **state)
{
	(void)state;
	if (!gltf_model_spheres() || !gltf_model_room("room.exr", 512))
		fail_msg("%s", stilb_error_message());
	assert_true(fidelity("spheres") <= -33.5);
}

/* Of several samples a pixel none is lit from behind where two triangles of a ball meet: frames of one and of four
 * samples differ by what edges are smoothed, and the balls' insides hardly. */
static void samples_change_edges_alone(void **state)
{
	(void)state;
	stilb_scene *scene;
	stilb_engine_desc desc = stilb_engine_desc_default();
	stilb_image frames[2] = {{0}}, mask = {0};
	stilb_image_comparison apart;
	desc.width = desc.height = 400;
	desc.workers = 1;
	desc.shading.brdf = SHADE_BRDF_MICROFACET;
	desc.output = STILB_RENDER_OUTPUT_LINEAR;
	if (!gltf_model_spheres() || stilb_scene_open("spheres.gltf", &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	for (uint32_t i = 0; i < 2; i++) {
		stilb_engine *other;
		stilb_engine_report report;
		desc.samples = i == 0 ? 1 : 4;
		if (stilb_engine_create(&desc, &other) != STILB_OK || stilb_engine_set_scene(other, scene) != STILB_OK ||
		    stilb_engine_frame(other, &report) != STILB_OK ||
		    stilb_render_read_image(other->render, &frames[i]) != STILB_OK)
			fail_msg("%s", stilb_error_message());
		stilb_engine_destroy(other);
	}
	assert_int_equal(stilb_image_mask_edges(&frames[0], 0.0f, 0.3f, 2, &mask), STILB_OK);
	assert_int_equal(stilb_image_compare(&frames[1], &frames[0], &mask, 0.0, &apart), STILB_OK);
	print_message("one and four samples: rms %.5f, worst %.4f of %.3f; %llu pixels\n", apart.rms_all, apart.worst,
	              apart.largest, (unsigned long long)apart.pixels);
	assert_true(apart.pixels > 10000 && apart.worst < 0.1 * apart.largest);
	stilb_image_finish(&frames[0]);
	stilb_image_finish(&frames[1]);
	stilb_image_finish(&mask);
	stilb_scene_destroy(scene);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_helmet_is_near_rays),
		cmocka_unit_test(spheres_are_near_rays),
		cmocka_unit_test(samples_change_edges_alone),
	};
	return cmocka_run_group_tests(tests, set_up, tear_down);
}
