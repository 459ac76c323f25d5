/* Layers of materials, the same in both renderers: grids of balls, five roughnesses by five strengths of a layer, under
 * lights and under a panorama. Frames without shadows are held against rays with `--integrator direct --shadows off` by
 * Khronos' decibels (image_compare.h). With STILB_TRUTH_PICTURES=FOLDER in the environment both pictures and their
 * difference, times 5, are written there. */
#include "engine.h"
#include "engine_internal.h"
#include "framed.h"
#include "gi/gi_render.h"
#include "image/image_compare.h"
#include "scene/scene_build.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SIDE 200u /* pixels of the pictures that are compared */
#define FINE 2u   /* pixels of frames for one of these, along each side */
#define SAMPLES 64u
#define GRID 5u
#define BALL 32u /* squares of a ball along each side */

static const float roughnesses[GRID] = {0.1f, 0.3f, 0.5f, 0.75f, 1.0f};
static const float strengths[GRID] = {0.2f, 0.4f, 0.6f, 0.8f, 1.0f};

static stilb_engine *engine;
static stilb_job_pool *pool;

static int set_up(void **state)
{
	(void)state;
	stilb_job_pool_desc pool_desc = {.worker_count = 2, .affinity = STILB_JOB_AFFINITY_NONE};
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.width = desc.height = SIDE * FINE;
	desc.output = STILB_RENDER_OUTPUT_LINEAR;
	desc.validate = true;
	desc.workers = 1;
	desc.shading = (stilb_render_shading){
		.brdf = SHADE_BRDF_MICROFACET, .ndf = SHADE_NDF_GGX, .g = SHADE_G_SMITH_GGX, .f = SHADE_F_SCHLICK};
	if (stilb_job_pool_create(&pool_desc, &pool) != 0)
		return -1;
	return stilb_engine_create(&desc, &engine) == STILB_OK ? 0 : -1;
}

static int tear_down(void **state)
{
	(void)state;
	int messages = (int)stilb_engine_validation_messages(engine);
	stilb_engine_destroy(engine);
	stilb_job_pool_destroy(pool);
	return messages > 0 ? -1 : 0;
}

/* ---- scenes ------------------------------------------------------------------------------------------------------ */

static void coat(stilb_scene_surface *surface, float roughness, float strength)
{
	surface->clearcoat = strength;
	surface->clearcoat_roughness = roughness;
}

static void sheen(stilb_scene_surface *surface, float roughness, float strength)
{
	surface->sheen_roughness = roughness;
	for (int c = 0; c < 3; c++)
		surface->sheen_color[c] = strength * (1.0f - 0.2f * (float)c);
}

static void brushed(stilb_scene_surface *surface, float roughness, float strength)
{
	for (int c = 0; c < 3; c++)
		surface->color[c] = 0.9f - 0.2f * (float)c;
	surface->metalness = 1.0f;
	surface->roughness = roughness;
	surface->anisotropy = strength;
}

/* Thin walls, all of them rough enough to have a lobe: what is smoother rays pass straight through both sides of. */
static void through(stilb_scene_surface *surface, float roughness, float strength)
{
	for (int c = 0; c < 3; c++)
		surface->color[c] = 0.9f - 0.2f * (float)c;
	surface->roughness = roughness;
	surface->transmission = strength;
}

/* A ball of radius 1 with tangents along its parallels. */
static uint32_t ball_build(stilb_scene_build *build)
{
	static stilb_scene_vertex vertices[(BALL + 1) * (BALL + 1)];
	static stilb_scene_vertex_extra extras[(BALL + 1) * (BALL + 1)];
	static uint32_t indices[6 * BALL * BALL];
	uint32_t count = 0;
	for (uint32_t v = 0; v < (BALL + 1) * (BALL + 1); v++) {
		float longitude = 6.2831853f * (float)(v % (BALL + 1)) / (float)BALL;
		float latitude = 3.1415927f * (float)(v / (BALL + 1)) / (float)BALL;
		float n[3] = {sinf(latitude) * sinf(longitude), cosf(latitude), sinf(latitude) * cosf(longitude)};
		memcpy(vertices[v].position, n, sizeof n);
		memcpy(vertices[v].normal, n, sizeof n);
		extras[v] =
			(stilb_scene_vertex_extra){.tangent = {cosf(longitude), 0, -sinf(longitude), 1}, .color = {1, 1, 1, 1}};
	}
	for (uint32_t j = 0; j < BALL; j++)
		for (uint32_t i = 0; i < BALL; i++) {
			uint32_t a = j * (BALL + 1) + i, c = a + BALL + 1;
			const uint32_t corners[6] = {a, c, a + 1, a + 1, c, c + 1};
			memcpy(indices + count, corners, sizeof corners);
			count += 6;
		}
	stilb_scene_mesh mesh = {.vertices = vertices,
	                         .extras = extras,
	                         .indices = indices,
	                         .vertex_count = (BALL + 1) * (BALL + 1),
	                         .index_count = count};
	return stilb_scene_build_mesh(build, &mesh);
}

/* A sky over darker ground, with a large soft light at the side and one behind the balls. */
static void panorama_build(stilb_scene_build *build)
{
	static const float lobes[3][5] = {/* direction, sharpness, radiance */
	                                  {0.57f, 0.69f, 0.45f, 12, 5},
	                                  {-0.85f, 0.32f, -0.42f, 6, 2},
	                                  {0.2f, 0.19f, -0.96f, 20, 3}};
	uint32_t width = 128, height = 64;
	stilb_scene_surroundings around = {0};
	assert_int_equal(stilb_image_create(&around.panorama, width, height, 3, STILB_IMAGE_F32_LINEAR), STILB_OK);
	for (uint32_t i = 0; i < width * height; i++) {
		float longitude = 6.2831853f * ((float)(i % width) + 0.5f) / (float)width - 3.1415927f;
		float latitude = 3.1415927f * ((float)(i / width) + 0.5f) / (float)height;
		float d[3] = {sinf(latitude) * sinf(longitude), cosf(latitude), -sinf(latitude) * cosf(longitude)};
		for (int c = 0; c < 3; c++) {
			float *out = (float *)around.panorama.pixels + 3 * i + c;
			*out = d[1] > 0.0f ? 0.15f + 0.1f * (float)c + 0.2f * d[1] : 0.15f - 0.04f * (float)c;
			for (int l = 0; l < 3; l++) {
				float along = d[0] * lobes[l][0] + d[1] * lobes[l][1] + d[2] * lobes[l][2];
				*out += lobes[l][4] * (1.0f - 0.15f * (float)c) * expf(lobes[l][3] * (along - 1.0f));
			}
		}
	}
	stilb_scene_build_surroundings(build, &around);
	stilb_image_finish(&around.panorama);
}

static void lights_build(stilb_scene_build *build)
{
	static const float directions[2][3] = {{-0.48f, -0.6f, -0.64f}, {0.6f, 0.0f, 0.8f}};
	for (int l = 0; l < 2; l++) {
		stilb_scene_light light = {.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .intensity = {2.0f, 2.0f, 2.0f}};
		memcpy(light.direction, directions[l], sizeof light.direction);
		stilb_scene_build_light(build, &light);
	}
}

typedef void layer_of(stilb_scene_surface *surface, float roughness, float strength);

static stilb_scene *grid_scene(layer_of *layer, bool lights)
{
	stilb_scene_build *build = stilb_scene_build_begin();
	uint32_t mesh = ball_build(build);
	for (uint32_t cell = 0; cell < GRID * GRID; cell++) {
		static const float grey[3] = {0.25f, 0.25f, 0.25f}, none[3] = {0};
		stilb_scene_surface surface = stilb_scene_surface_make();
		stilb_scene_material material = stilb_scene_material_make(grey, none, 0.5f);
		surface.color[0] = 0.5f;
		surface.color[1] = 0.25f;
		surface.color[2] = 0.15f;
		surface.roughness = 0.6f;
		layer(&surface, roughnesses[cell % GRID], strengths[cell / GRID]);
		material.surface = 1 + stilb_scene_build_surface(build, &surface);
		stilb_scene_build_part part = {mesh, stilb_scene_build_material(build, &material)};
		stilb_mat4 place = stilb_mat4_scale_translate(1.0f, 2.3f * ((float)(cell % GRID) - 2.0f),
		                                              2.3f * (2.0f - (float)(cell / GRID)), 0.0f);
		stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &place), &part, 1);
	}
	stilb_scene_build_camera(
		build, &(stilb_scene_camera){.position = {0.0f, 0.0f, 16.0f}, .fov_y = 0.75f, .near_z = 0.1f, .far_z = 100.0f});
	if (lights)
		lights_build(build);
	else
		panorama_build(build);
	stilb_scene *scene;
	if (stilb_scene_build_end(build, &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return scene;
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

static stilb_image framed(stilb_scene *scene)
{
	return framed_by(engine, scene, FINE);
}

/* The picture by rays, and a mask of the pixels that no silhouette touches. */
static stilb_image traced(const stilb_scene *scene, stilb_image *mask)
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
	stilb_image depth = {SIDE, SIDE, 1, STILB_IMAGE_F32_LINEAR, (void *)(uintptr_t)film.depth, 0};
	assert_int_equal(stilb_image_mask_edges(&depth, 0.05f, 0.0f, 1, mask), STILB_OK);
	for (uint32_t i = 0; i < SIDE * SIDE; i++) /* what is not a ball is not compared */
		((uint8_t *)mask->pixels)[i] &= (uint8_t)(film.depth[i] < 100.0f ? 255 : 0);
	stilb_gi_render_destroy(render);
	stilb_gi_scene_destroy(gi);
	return image;
}

static void write_pictures(const char *name, const stilb_image *live, const stilb_image *rays)
{
	const char *folder = getenv("STILB_TRUTH_PICTURES");
	stilb_image three;
	char path[512];
	if (!folder || stilb_image_create(&three, 3 * SIDE, SIDE, 3, STILB_IMAGE_F32_LINEAR) != STILB_OK)
		return;
	for (uint32_t i = 0; i < 3 * SIDE * SIDE; i++) {
		float a = ((float *)live->pixels)[i], b = ((float *)rays->pixels)[i];
		float *to = (float *)three.pixels + 9 * SIDE * (i / (3 * SIDE)) + i % (3 * SIDE);
		to[0] = a;
		to[3 * SIDE] = b;
		to[6 * SIDE] = 5.0f * fabsf(a - b);
	}
	snprintf(path, sizeof path, "%s/%s.png", folder, name);
	assert_int_equal(stilb_image_save(&three, path), STILB_OK);
	stilb_image_finish(&three);
}

/* ---- tests ------------------------------------------------------------------------------------------------------- */

/* bound: decibels, at most. */
static const struct {
	const char *name;
	layer_of *layer;
	double lights, panorama;
} grids[] = {
	{"coat", coat, -32.0, -34.0},
	{"sheen", sheen, -46.0, -33.0},
	{"brushed", brushed, -22.0, -24.0},
	{"through", through, -31.0, -26.0},
};

static void frames_are_near_rays(void **state)
{
	(void)state;
	bool good = true;
	for (size_t g = 0; g < 2 * sizeof grids / sizeof *grids; g++) {
		char name[64];
		double db, bound = g % 2 ? grids[g / 2].panorama : grids[g / 2].lights;
		stilb_image mask = {0};
		stilb_image_comparison apart;
		stilb_scene *scene = grid_scene(grids[g / 2].layer, g % 2 == 0);
		stilb_image rays = traced(scene, &mask), live = framed(scene);
		assert_int_equal(stilb_image_fidelity(&live, &rays, &mask, &db), STILB_OK);
		assert_int_equal(stilb_image_compare(&live, &rays, &mask, 0.0, &apart), STILB_OK);
		snprintf(name, sizeof name, "%s-%s", grids[g / 2].name, g % 2 ? "panorama" : "lights");
		write_pictures(name, &live, &rays);
		print_message("%-20s %7.2f dB, rms %.5f of %.3f%s\n", name, db, apart.rms_all, apart.largest,
		              db <= bound ? "" : "  <-- apart");
		good &= db <= bound && apart.pixels > SIDE * SIDE / 8;
		stilb_image_finish(&rays);
		stilb_image_finish(&live);
		stilb_image_finish(&mask);
		stilb_scene_destroy(scene);
	}
	assert_true(good);
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(frames_are_near_rays)};
	return cmocka_run_group_tests(tests, set_up, tear_down);
}
