/* Maps of emission as lights: means of triangles, which of them are lights, and that asking lights and meeting them by
 * chance give the same picture, also where the light is half there. */

#include "gi/gi_path_fixture.h"
#include "gi_maps_fixture.h"

#include "gi/light/gi_light_shape.h"
#include "scene/edit/scene_edit.h"

static const stilb_mat4 here = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};

#define SIDE 16

static float texels[SIDE][SIDE][4];

/* Bright in a disk around (x, y) in texels, dark elsewhere; alpha is 1 in the right half, 0.25 in the left one. */
static stilb_image spot(float x, float y, float radius)
{
	for (int row = 0; row < SIDE; row++)
		for (int i = 0; i < SIDE; i++) {
			float dx = (float)i + 0.5f - x, dy = (float)row + 0.5f - y;
			bool bright = dx * dx + dy * dy < radius * radius;
			float color[4] = {bright ? 2.0f : 0.0f, bright ? 1.0f : 0.0f, 0.0f, i < SIDE / 2 ? 0.25f : 1.0f};
			memcpy(texels[row][i], color, sizeof color);
		}
	return (stilb_image){SIDE, SIDE, 4, STILB_IMAGE_F32_LINEAR, texels, 0};
}

static stilb_scene_surface shining(float strength)
{
	stilb_scene_surface surface = stilb_scene_surface_make();
	surface.color[0] = surface.color[1] = surface.color[2] = 0.0f;
	surface.ior = 1.0f;
	surface.emission[0] = surface.emission[1] = surface.emission[2] = strength;
	surface.maps[STILB_SCENE_MAP_EMISSION].texture = 1;
	surface.maps[STILB_SCENE_MAP_EMISSION].nearest = true;
	return surface;
}

/* ---- means ------------------------------------------------------------------------------------------------------- */

static gi_glow glow_of_triangle(const stilb_scene_surface *surface, const stilb_image *image, const float uv[3][2])
{
	gi_glow glow = {.maps = {surface, image, 1}};
	for (int i = 0; i < 3; i++)
		glow.corners[i] = (gi_place){.uv = {{uv[i][0], uv[i][1]}}, .color = {1.0f, 1.0f, 1.0f, 1.0f}};
	return glow;
}

/* Against the mean over a million points; a triangle of less than a texel has that texel's. */
static void means_of_triangles(void **state)
{
	(void)state;
	static const float uvs[4][3][2] = {{{0.0f, 0.0f}, {1.0f, 0.0f}, {0.0f, 1.0f}},
	                                   {{0.1f, 0.9f}, {0.8f, 0.2f}, {0.9f, 0.95f}},
	                                   {{-1.2f, 0.3f}, {2.5f, 0.7f}, {0.4f, 3.1f}},
	                                   {{0.26f, 0.51f}, {0.28f, 0.52f}, {0.27f, 0.54f}}};
	stilb_image image = spot(5.0f, 8.0f, 4.6f);
	for (int i = 0; i < 4; i++)
		for (int holes = 0; holes < 2; holes++) {
			stilb_scene_surface surface = shining(3.0f);
			surface.alpha = holes ? STILB_SCENE_BLEND : STILB_SCENE_OPAQUE;
			surface.maps[STILB_SCENE_MAP_COLOR].texture = 1;
			gi_glow glow = glow_of_triangle(&surface, &image, uvs[i]);
			shade_proof_random random = {.seed = 5};
			double sum = 0.0;
			for (int k = 0; k < SHADE_PROOF_COUNT; k++) {
				float root = sqrtf(shade_proof_uniform(&random)), v = shade_proof_uniform(&random);
				sum += (double)gi_glow_at(&glow, root * (1.0f - v), root * v)[0] / SHADE_PROOF_COUNT;
			}
			stilb_vec3 mean = gi_glow_mean(&glow);
			SHADE_PROOF_NEAR(mean[0], sum, i == 3 ? 1e-4 : 0.06, 0.0);
			SHADE_PROOF_NEAR3(mean, (double)mean[0], 0.5 * (double)mean[0], 0.0, 0.0, 1e-5);
		}
}

static void dark_pictures(void **state)
{
	(void)state;
	uint8_t bytes[6][4] = {{0}};
	float floats[2][3] = {{0.0f, -1.0f, NAN}, {0.0f, 0.0f, 0.0f}};
	stilb_image image = {3, 2, 4, STILB_IMAGE_U8_SRGB, bytes, 0}, light = {2, 1, 3, STILB_IMAGE_F32_LINEAR, floats, 0};
	for (int i = 0; i < 6; i++)
		bytes[i][3] = 255;
	assert_true(gi_glow_is_dark(&image) && gi_glow_is_dark(&light));
	for (int i = 0; i < 6; i++) {
		bytes[i][i % 3] = 1;
		assert_false(gi_glow_is_dark(&image));
		bytes[i][i % 3] = 0;
	}
	floats[1][2] = 0x1p-149f;
	assert_false(gi_glow_is_dark(&light));
	uint16_t halves[3][2] = {{0, 0x3c00}, {0x8001, 0x3c00}, {0x7e00, 0x3c00}}; /* 0, less, NaN; alpha 1 */
	stilb_image half = {3, 1, 2, STILB_IMAGE_F16_LINEAR, halves, 0};
	assert_true(gi_glow_is_dark(&half));
	halves[2][0] = 0x7c00; /* infinity */
	assert_false(gi_glow_is_dark(&half));
	uint8_t codes[13 * 3] = {0};
	stilb_image odd = {13, 1, 3, STILB_IMAGE_U8_LINEAR, codes, 0};
	assert_true(gi_glow_is_dark(&odd));
	for (int i = 0; i < 13 * 3; i++) {
		codes[i] = 1;
		assert_false(gi_glow_is_dark(&odd));
		codes[i] = 0;
	}
	uint16_t words[2] = {0, 65535};
	stilb_image wide = {1, 1, 2, STILB_IMAGE_U16_LINEAR, words, 0};
	assert_true(gi_glow_is_dark(&wide));
	words[0] = 256;
	assert_false(gi_glow_is_dark(&wide));
	assert_false(gi_glow_is_dark(&(stilb_image){0})); /* one without pixels is white */
}

/* ---- which triangles are lights ---------------------------------------------------------------------------------- */

static void only_what_glows_is_a_light(void **state)
{
	(void)state;
	maps_square square;
	maps_square_make(&square, 1.0f);
	/* the square's first triangle is below the line from top left to bottom right, the second above it */
	static const struct {
		float x, y, radius;
		uint32_t lights;
	} rows[] = {{3, 12, 2, 1}, {12, 3, 2, 1}, {8, 8, 4, 2}, {8, 8, 30, 2}, {8, 8, 0, 0}};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		stilb_image image = spot(rows[i].x, rows[i].y, rows[i].radius);
		stilb_scene_surface surface = shining(1.0f);
		world_fixture world = maps_trace(maps_scene(&square, &surface, &image, 1, &here), true);
		assert_int_equal(stilb_gi_scene_info_of(world.gi)->lights, rows[i].lights);
		assert_int_equal(world.gi->lights.placed_count, rows[i].lights);
		assert_int_equal(world.gi->parts[0].instance, rows[i].lights == 0); /* what is dark may be one */
		stilb_vec3 from = stilb_vec3_make(0.1f, 0.2f, 2.0f), normal = stilb_vec3_make(0.0f, 0.0f, -1.0f);
		for (uint32_t k = 0; k < world.gi->lights.emitter_count && rows[i].lights == 1; k++)
			assert_int_equal(gi_light_pdf(&world.gi->lights, from, normal, k, 2.0f) > 0.0f, k == (i == 1));
		world_finish(&world);
	}
	stilb_image image = spot(8, 8, 30);
	stilb_scene_surface surface = shining(1.0f);
	surface.unlit = true;
	world_fixture world = maps_trace(maps_scene(&square, &surface, &image, 1, &here), false);
	assert_int_equal(stilb_gi_scene_info_of(world.gi)->lights, 0);
	world_finish(&world);
}

/* ---- asking and meeting ------------------------------------------------------------------------------------------ */

/* The irradiance that a lookup of sampled lights estimates, against a sum over the square's points; and each sample's
 * density is that of a ray that meets the light there by chance, with the same radiance. */
static void sampled_light_is_the_maps(void **state)
{
	(void)state;
	enum { GRID = 400, SAMPLES = 200000 };
	stilb_image image = spot(5.0f, 9.0f, 3.7f);
	maps_square square;
	maps_square_make(&square, 1.0f);
	for (int i = 0; i < 6; i++) {
		stilb_scene_surface surface = shining(3.0f);
		stilb_scene_alpha alpha = (stilb_scene_alpha)(i / 2);
		float height = i % 2 ? 0.3f : 3.0f;
		surface.alpha = alpha;
		if (alpha != STILB_SCENE_OPAQUE)
			surface.maps[STILB_SCENE_MAP_COLOR].texture = 1;
		surface.maps[STILB_SCENE_MAP_COLOR].nearest = true;
		world_fixture world = maps_trace(maps_scene(&square, &surface, &image, 1, &here), false);
		stilb_vec3 from = stilb_vec3_make(0.2f, -0.4f, height), down = stilb_vec3_make(0.0f, 0.0f, -1.0f);
		double want = 0.0;
		for (int y = 0; y < GRID; y++)
			for (int x = 0; x < GRID; x++) {
				double px = (x + 0.5) / GRID * 2.0 - 1.0, py = (y + 0.5) / GRID * 2.0 - 1.0;
				int column = (int)((0.5 + 0.5 * px) * SIDE), row = (int)((0.5 - 0.5 * py) * SIDE);
				const float *texel = texels[row][column];
				double share = alpha == STILB_SCENE_BLEND  ? (double)texel[3]
				               : alpha == STILB_SCENE_MASK ? texel[3] >= 0.5f
				                                           : 1.0;
				double dx = px - (double)from[0], dy = py - (double)from[1],
					   d2 = dx * dx + dy * dy + (double)(height * height);
				want += 3.0 * (double)texel[0] * share * (double)(height * height) / (d2 * d2) * 4.0 / (GRID * GRID);
			}
		shade_proof_random random = {.seed = 7};
		double sum = 0.0, squares = 0.0;
		for (int k = 0; k < SAMPLES; k++) {
			gi_light_sample sample;
			stilb_vec2 u = {shade_proof_uniform(&random), shade_proof_uniform(&random)};
			if (!gi_light_sample_at(&world.gi->lights, GI_LIGHT_PLACED, true, from, down, shade_proof_uniform(&random),
			                        u, &sample))
				continue;
			double value = (double)(sample.radiance[0] * -sample.direction[2] / sample.pdf);
			sum += value / SAMPLES;
			squares += value * value / SAMPLES;
			if (k % 100)
				continue;
			gi_ray_hit ray = gi_ray_hit_make_by(from, sample.direction, shade_proof_uniform(&random));
			world.gi->tracer.intersect(&world.gi->tracer, &ray);
			if (!gi_is_hit(&ray)) {
				assert_true(alpha != STILB_SCENE_OPAQUE);
				continue;
			}
			gi_surface at;
			gi_surface_at(world.gi, &ray, &at);
			float pdf = gi_light_pdf(&world.gi->lights, from, down, world.gi->parts[0].first_light + at.triangle,
			                         ray.ray.t_max);
			SHADE_PROOF_NEAR(pdf, (double)sample.pdf, 2e-3, 0.0);
			if (alpha == STILB_SCENE_OPAQUE && sample.radiance[0] > 0.0f)
				SHADE_PROOF_NEAR(at.emission[0], (double)sample.radiance[0], 1e-5, 0.0);
		}
		double sigma = sqrt((squares - sum * sum) / SAMPLES);
		SHADE_PROOF_NEAR((float)sum, want, 2e-3, 5.0 * sigma);
		world_finish(&world);
	}
}

/* A floor below the light, seen by a camera between them: asking lights and the rays' own luck, weighed together, alone
 * (montecarlo has luck alone), are the same light. */
static void asked_and_met_are_the_same_picture(void **state)
{
	(void)state;
	static const stilb_mat4 floor = {{3, 0, 0, 0, 0, 3, 0, 0, 0, 0, -1, 0, 0, 0, 1.5f, 1}};
	stilb_image image = spot(5.0f, 9.0f, 4.5f);
	maps_square square;
	maps_square_make(&square, 1.0f);
	for (int alpha = 0; alpha < STILB_SCENE_ALPHAS; alpha++) {
		stilb_scene_surface surface = shining(3.0f), white = stilb_scene_surface_make();
		surface.alpha = (stilb_scene_alpha)alpha;
		surface.maps[STILB_SCENE_MAP_COLOR].texture = alpha != STILB_SCENE_OPAQUE;
		white.roughness = 0.4f;
		white.metalness = 0.5f;
		white.color[1] = 0.5f;
		stilb_scene_build *build = stilb_scene_build_begin();
		stilb_scene_build_texture(build, &image);
		maps_add(build, &square.mesh, &surface, &here);
		maps_add(build, &square.mesh, &white, &floor);
		stilb_scene_camera camera = {
			.position = {0, 0, 0.3f}, .yaw = 3.14159265f, .fov_y = 1.0f, .near_z = 0.01f, .far_z = 10};
		stilb_scene_build_camera(build, &camera);
		path_fixture fixture = path_fixture_make(maps_end(build));
		assert_true(fixture.gi->lights.placed_count > 0);
		path_mean means[3];
		static const stilb_gi_integrator integrators[3] = {STILB_GI_INTEGRATOR_PATH, STILB_GI_INTEGRATOR_DIRECT,
		                                                   STILB_GI_INTEGRATOR_MONTECARLO};
		for (int i = 0; i < 3; i++) {
			gi_view view = path_view(&fixture, integrators[i], 16, TEST_ASAN ? 32 : 256);
			view.settings.depth = 1;
			view.settings.rays = 32;
			means[i] = path_picture_mean(&view);
		}
		for (int i = 0; i < 2; i++) {
			double sigma = hypot(path_mean_error(&means[i], 0), path_mean_error(&means[2], 0));
			SHADE_PROOF_NEAR((float)path_mean_of(&means[i], 0), path_mean_of(&means[2], 0), 0.0, 4.5 * sigma);
			assert_true(TEST_ASAN || sigma < 0.03 * path_mean_of(&means[2], 0));
		}
		path_fixture_finish(&fixture);
	}
}

/* ---- updates ----------------------------------------------------------------------------------------------------- */

/* Another surface or texture makes other lights, as in a scene that is made anew; a part that moves keeps its own. */
static void updates_change_lights(void **state)
{
	(void)state;
	maps_square square;
	maps_square_make(&square, 1.0f);
	stilb_image image = spot(3, 12, 2);
	stilb_scene_surface surface = shining(1.0f);
	world_fixture world = maps_trace(maps_scene(&square, &surface, &image, 1, &here), true);
	stilb_gi_scene_desc desc = {.pool = world.pool, .intersector = &stilb_gi_embree, .movable = true};
	stilb_vec3 from = stilb_vec3_make(0.1f, 0.2f, 2.0f), normal = stilb_vec3_make(0.0f, 0.0f, -1.0f);
	for (int step = 0; step < 4; step++) {
		if (step == 1) { /* turned upside down: the other triangle glows */
			surface.maps[STILB_SCENE_MAP_EMISSION].to_u[0] = -1.0f;
			surface.maps[STILB_SCENE_MAP_EMISSION].to_u[2] = 1.0f;
			surface.maps[STILB_SCENE_MAP_EMISSION].to_v[1] = -1.0f;
			surface.maps[STILB_SCENE_MAP_EMISSION].to_v[2] = 1.0f;
			assert_int_equal(stilb_scene_set_surface(world.scene, 0, &surface), STILB_OK);
		} else if (step == 2) {
			image = spot(8, 8, 0);
			assert_int_equal(stilb_scene_set_texture(world.scene, 0, &image), STILB_OK);
		} else if (step == 3) {
			image = spot(8, 8, 5);
			assert_int_equal(stilb_scene_set_texture(world.scene, 0, &image), STILB_OK);
		}
		assert_int_equal(stilb_gi_scene_update(world.gi, world.scene, &desc), STILB_OK);
		assert_int_equal(stilb_gi_scene_info_of(world.gi)->lights, step < 2 ? 1 : step == 2 ? 0 : 2);
		assert_int_equal(world.gi->parts[0].instance, step == 2);
		for (uint32_t k = 0; k < 2 && step < 2; k++)
			assert_int_equal(gi_light_pdf(&world.gi->lights, from, normal, k, 2.0f) > 0.0f, k == (step == 1));
	}
	world_finish(&world);
}

/* What was found of textures and triangles is kept where nothing that it depends on has changed, also when the scene is
 * made anew: values put in its place are used. */
static void what_was_found_is_kept(void **state)
{
	(void)state;
	maps_square square;
	maps_square_make(&square, 1.0f);
	stilb_image image = spot(8, 8, 30);
	stilb_scene_surface surface = shining(1.0f);
	world_fixture world = maps_trace(maps_scene(&square, &surface, &image, 1, &here), false);
	stilb_gi_scene_desc desc = {.pool = world.pool, .intersector = &stilb_gi_embree};
	uint32_t id;
	stilb_scene_material paint = {.roughness = 0.5f};
	world.gi->found.means[0][0] = world.gi->found.means[1][0] = 42.0f;
	assert_int_equal(stilb_scene_add_material(world.scene, &paint, &id), STILB_OK);
	assert_int_equal(stilb_gi_scene_update(world.gi, world.scene, &desc), STILB_OK);
	assert_true(world.gi->found.means[0][0] == 42.0f && world.gi->found.means[1][0] == 42.0f);
	stilb_scene_build_part part = {0, id};
	assert_int_equal(stilb_scene_add_model(world.scene, &here, &part, 1, &id), STILB_OK);
	assert_int_equal(stilb_gi_scene_update(world.gi, world.scene, &desc), STILB_OK);
	assert_int_equal(world.gi->part_count, 2);
	assert_true(world.gi->found.means[0][0] == 42.0f);
	world.gi->found.dark[0] = GI_DARKNESS_DARK;
	assert_int_equal(stilb_scene_add_model(world.scene, &here, &part, 1, &id), STILB_OK);
	assert_int_equal(stilb_gi_scene_update(world.gi, world.scene, &desc), STILB_OK);
	assert_int_equal(stilb_gi_scene_info_of(world.gi)->lights, 0);
	image = spot(8, 8, 30);
	assert_int_equal(stilb_scene_set_texture(world.scene, 0, &image), STILB_OK);
	assert_int_equal(stilb_gi_scene_update(world.gi, world.scene, &desc), STILB_OK);
	assert_int_equal(stilb_gi_scene_info_of(world.gi)->lights, 2);
	assert_true(world.gi->found.means[0][0] != 42.0f);
	world_finish(&world);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(means_of_triangles),
		cmocka_unit_test(dark_pictures),
		cmocka_unit_test(only_what_glows_is_a_light),
		cmocka_unit_test(sampled_light_is_the_maps),
		cmocka_unit_test(asked_and_met_are_the_same_picture),
		cmocka_unit_test(updates_change_lights),
		cmocka_unit_test(what_was_found_is_kept),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
