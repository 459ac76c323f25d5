/* Frames and traced pictures agree on what is covered: with every mesh in full, and with levels that are off by half a
 * pixel. Rays always meet the mesh in full. A pixel counts if the samples of it and of its eight neighbours all hit or
 * all miss, that is more than a pixel away from silhouettes. */
#include "engine_internal.h"
#include "geometry/geometry_levels.h"
#include "gi/gi_render.h"
#include "scene/scene_build.h"
#include "support/test.h"
#include "tests/geometry/mesh_made.h"

#include <math.h>
#include <string.h>

enum { WIDTH = 240, HEIGHT = 160, SAMPLES = 16, MODELS = 60 };

#define REFLECTANCE 0.5f /* of all models */

typedef enum coverage { EMPTY, FULL, SILHOUETTE } coverage;

/* ---- scenes ------------------------------------------------------------------------------------------------------ */

/* Some number in [low, high) for each number, model and use. */
static float random_of(uint32_t model, uint32_t use, float low, float high)
{
	return low + (high - low) * stilb_random_float(7, 16 * (uint64_t)model + use);
}

/* From 4 to 100 metres ahead of the camera, most of them where a model is a few pixels wide, turned at random. */
static stilb_mat4 place_of(uint32_t model)
{
	float distance = 4.0f * powf(25.0f, ((float)model + random_of(model, 0, 0.0f, 1.0f)) / MODELS), length = 0.0f;
	stilb_scene_pose pose = {.scale = {1, 1, 1},
	                         .translation = {distance * random_of(model, 1, -0.6f, 0.6f),
	                                         distance * random_of(model, 2, -0.4f, 0.4f), -distance}};
	for (uint32_t i = 0; i < 4; i++) {
		pose.rotation[i] = random_of(model, 3 + i, -1.0f, 1.0f);
		length += pose.rotation[i] * pose.rotation[i];
	}
	for (int i = 0; i < 4; i++)
		pose.rotation[i] /= sqrtf(length);
	return stilb_scene_pose_matrix(&pose);
}

/* Many of one mesh, which shine before black. The mesh is copied and freed. */
static stilb_scene *scene_of(stilb_scene_mesh *mesh)
{
	static const float grey[3] = {REFLECTANCE, REFLECTANCE, REFLECTANCE}, none[3] = {0};
	static const stilb_scene_camera camera = {.fov_y = 0.8f, .near_z = 0.1f, .far_z = 1000.0f};
	stilb_scene_material paint = stilb_scene_material_make(grey, none, 0.8f);
	for (int c = 0; c < 3; c++)
		paint.emission[c] = 0.5f;
	stilb_scene *scene;
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_build_part part = {.mesh = stilb_scene_build_mesh(build, mesh)};
	part.material = stilb_scene_build_material(build, &paint);
	for (uint32_t m = 0; m < MODELS; m++) {
		stilb_mat4 place = place_of(m);
		stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &place), &part, 1);
	}
	stilb_scene_build_camera(build, &camera);
	if (stilb_scene_build_end(build, &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	scene->backdrop.kind = STILB_SCENE_BACKDROP_NOTHING;
	stilb_scene_mesh_finish(mesh);
	return scene;
}

/* ---- both pictures ----------------------------------------------------------------------------------------------- */

/* What the samples of each pixel meet. */
static void traced(stilb_scene *scene, coverage *out)
{
	stilb_job_pool_desc desc = {.worker_count = 1};
	stilb_job_pool *pool;
	stilb_gi_scene *gi;
	stilb_gi_render *render;
	assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
	stilb_gi_scene_desc gi_desc = stilb_gi_scene_desc_default(pool);
	assert_int_equal(stilb_gi_scene_create(scene, &gi_desc, &gi), STILB_OK);
	stilb_gi_settings settings = stilb_gi_settings_default(scene);
	settings.integrator = STILB_GI_INTEGRATOR_DIRECT;
	settings.width = WIDTH;
	settings.height = HEIGHT;
	settings.samples = SAMPLES;
	assert_int_equal(stilb_gi_render_create(gi, &settings, pool, &render), STILB_OK);
	assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	const float *albedo = stilb_gi_render_film(render).albedo;
	for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
		float share = albedo[3 * (size_t)i] / REFLECTANCE, part = 0.5f / SAMPLES;
		out[i] = share < part ? EMPTY : share > 1.0f - part ? FULL : SILHOUETTE;
	}
	stilb_gi_render_destroy(render);
	stilb_gi_scene_destroy(gi);
	stilb_job_pool_destroy(pool);
}

/* The first frame of an engine with this detail. */
static stilb_image live(stilb_scene *scene, stilb_render_detail detail)
{
	stilb_engine_desc desc = stilb_engine_desc_default();
	stilb_engine *engine;
	stilb_engine_report report;
	stilb_image image = {0};
	desc.workers = 1;
	desc.width = WIDTH;
	desc.height = HEIGHT;
	desc.samples = 1;
	desc.profile = false;
	desc.detail = detail;
	if (stilb_engine_create(&desc, &engine) != STILB_OK || stilb_engine_set_scene(engine, scene) != STILB_OK ||
	    stilb_engine_frame(engine, &report) != STILB_OK || stilb_render_read_image(engine->render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(image.width, WIDTH);
	assert_int_equal(image.format, STILB_IMAGE_U8_SRGB);
	stilb_engine_destroy(engine);
	return image;
}

/* ---- comparing --------------------------------------------------------------------------------------------------- */

static bool is_near_silhouette(const coverage *rays, uint32_t x, uint32_t y)
{
	coverage here = rays[y * WIDTH + x];
	for (uint32_t v = y - 1; v <= y + 1; v++)
		for (uint32_t u = x - 1; u <= x + 1; u++)
			if (rays[v * WIDTH + u] != here)
				return true;
	return here == SILHOUETTE;
}

/* Number of pixels that only one of both covers. */
static uint32_t differing(stilb_scene *scene, const coverage *rays, stilb_render_detail detail)
{
	stilb_image image = live(scene, detail);
	uint32_t covered = 0, count = 0;
	for (uint32_t y = 1; y + 1 < HEIGHT; y++)
		for (uint32_t x = 1; x + 1 < WIDTH; x++) {
			size_t i = (size_t)y * WIDTH + x;
			if (is_near_silhouette(rays, x, y))
				continue;
			covered += rays[i] == FULL;
			count += (rays[i] == FULL) != (((const uint8_t *)image.pixels)[image.channels * i] > 0);
		}
	assert_true(covered > 1000);
	stilb_image_finish(&image);
	return count;
}

static void check(stilb_scene_mesh *mesh)
{
	static coverage rays[WIDTH * HEIGHT];
	assert_true(mesh->level_count >= 3);
	stilb_scene *scene = scene_of(mesh);
	traced(scene, rays);
	assert_int_equal(differing(scene, rays, (stilb_render_detail){STILB_RENDER_DETAIL_OFF, 0.5f}), 0);
	for (int mode = STILB_RENDER_DETAIL_POP; mode <= STILB_RENDER_DETAIL_MORPH; mode++)
		assert_int_equal(differing(scene, rays, (stilb_render_detail){(stilb_render_detail_mode)mode, 0.5f}), 0);
	/* Many times as much is seen, so that there are levels to be seen. */
	assert_in_range(differing(scene, rays, (stilb_render_detail){STILB_RENDER_DETAIL_MORPH, 8.0f}), 10, 10000);
	stilb_scene_destroy(scene);
}

static void spheres(void **state)
{
	(void)state;
	stilb_scene_mesh mesh;
	assert_int_equal(stilb_scene_mesh_sphere(3, &mesh), STILB_OK);
	check(&mesh);
}

static void bumpy_rings(void **state)
{
	(void)state;
	stilb_scene_mesh mesh = mesh_grid(48, 24, mesh_place_torus);
	stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
	assert_int_equal(stilb_geometry_levels(&mesh, &desc, NULL, 0), STILB_OK);
	check(&mesh);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(spheres),
		cmocka_unit_test(bumpy_rings),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
