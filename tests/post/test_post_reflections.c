/* What surfaces mirror of the picture beside the same by rays: how far it is off, and how far 64 linear steps without
 * the surroundings are. Things shine by themselves and are seen alike from everywhere, so both pictures show the same
 * light but for what is mirrored. */
#include "post_world.h"

/* ---- scenes ------------------------------------------------------------------------------------------------------ */

static const stilb_scene_camera camera = {
	.position = {0, 1.6f, 5}, .pitch = -0.3f, .fov_y = 0.8f, .near_z = 0.1f, .far_z = 100.0f};

/* Mirrors so much, and scatters nothing. */
static stilb_scene_material mirror(float reflectance, float roughness)
{
	float none[3] = {0}, shine[3] = {reflectance, reflectance, reflectance};
	return stilb_scene_material_make(none, shine, roughness);
}

/* Shines in a colour. */
static stilb_scene_material shining(uint32_t seed, uint32_t use)
{
	stilb_scene_material paint = mirror(0.0f, 1.0f);
	for (uint32_t c = 0; c < 3; c++)
		paint.emission[c] = world_random(seed, use + c, 0.05f, 1.0f);
	return paint;
}

/* Surroundings that are brighter above. */
static stilb_scene_surroundings dusk(void)
{
	enum { ACROSS = 32, DOWN = 16 };
	stilb_scene_surroundings around = {.name = "dusk"};
	assert_int_equal(stilb_image_create(&around.panorama, ACROSS, DOWN, 3, STILB_IMAGE_F32_LINEAR), STILB_OK);
	float *texels = around.panorama.pixels;
	for (uint32_t y = 0; y < DOWN; y++)
		for (uint32_t x = 0; x < ACROSS; x++)
			for (uint32_t c = 0; c < 3; c++)
				texels[3 * (y * ACROSS + x) + c] = (0.25f + 0.1f * (float)c) * (1.0f - (float)y / DOWN);
	return around;
}

/* Things on a floor that mirrors, so rough. */
static stilb_scene *yard_of(uint32_t seed, float roughness)
{
	static world_thing things[MOST];
	uint32_t count = 0;
	stilb_scene_surroundings around = dusk();
	things[count++] = world_put(WORLD_BOX, 0, -1, 0, 12, 1, 12, mirror(0.6f, roughness));
	for (uint32_t i = 0; i < 16; i++) {
		float x = world_random(seed, 8 * i, -3.0f, 3.0f), z = world_random(seed, 8 * i + 1, -5.0f, 1.5f);
		float size = world_random(seed, 8 * i + 2, 0.15f, 0.45f), tall = world_random(seed, 8 * i + 6, 1.0f, 2.0f);
		things[count++] = world_put(i % 2, x, size * tall, z, size, size * tall, size, shining(seed, 8 * i + 3));
	}
	stilb_scene *scene = world_make(things, count, &camera, &around);
	stilb_image_finish(&around.panorama);
	return scene;
}

/* ---- the comparison ---------------------------------------------------------------------------------------------- */

static world_picture off, on, crude, linear, truth;

static void shown_with(stilb_engine *engine, stilb_post_reflections way, world_picture picture)
{
	stilb_engine_set_post(engine, &(stilb_post_settings){.reflections = way});
	world_draw(engine, picture);
}

static void compare(stilb_scene *scene, const char *name, double most)
{
	char path[64];
	stilb_engine *engine = world_open(scene, (stilb_post_settings){0});
	stilb_render_shading shading = stilb_engine_shading(engine);
	shading.brdf = SHADE_BRDF_MICROFACET;
	stilb_engine_set_shading(engine, &shading);
	shown_with(engine, STILB_POST_REFLECTIONS_OFF, off);
	shown_with(engine, STILB_POST_REFLECTIONS_CONES, on);
	shown_with(engine, STILB_POST_REFLECTIONS_CRUDE, crude);
	shown_with(engine, STILB_POST_REFLECTIONS_LINEAR, linear);
	world_close(engine);
	stilb_gi_settings settings = stilb_gi_settings_default(scene);
	settings.integrator = STILB_GI_INTEGRATOR_PATH;
	settings.depth = 4;
	settings.samples = 32;
	world_trace(scene, settings, truth);
	const struct {
		const char *what;
		float (*picture)[3];
	} kept[] = {{"off", off}, {"on", on}, {"crude", crude}, {"linear", linear}, {"truth", truth}};
	double by[5];
	for (size_t k = 0; k < 5; k++) {
		snprintf(path, sizeof path, "reflections_%s_%s", name, kept[k].what);
		world_keep((const float(*)[3])kept[k].picture, path);
		by[k] = world_rms((const float(*)[3])kept[k].picture, (const float(*)[3])truth);
	}
	print_message("%s: off by %.4f, 64 steps by %.4f, crude by %.4f, without by %.4f\n", name, by[1], by[3], by[2],
	              by[0]);
	if (by[1] > 0.5 * by[3] || by[1] > most)
		fail_msg("%s: off by %.4f, 64 steps by %.4f, crude by %.4f, without by %.4f", name, by[1], by[3], by[2], by[0]);
}

/* Made after the program was done: a stair and a ball that mirror, more or less rough, before a wall of tiles. */
static stilb_scene *stair(void)
{
	static world_thing things[MOST];
	uint32_t count = 0;
	stilb_scene_surroundings around = dusk();
	things[count++] = world_put(WORLD_BOX, 0, -1, 0, 12, 1, 12, mirror(0.5f, 0.25f));
	for (uint32_t i = 0; i < 24; i++)
		things[count++] = world_put(WORLD_BOX, -3.5f + (float)(i % 8), 0.4f + 0.8f * (float)(i / 8), -4, 0.48f, 0.38f,
		                            0.1f, shining(5, 3 * i));
	for (uint32_t i = 0; i < 3; i++)
		things[count++] = world_put(WORLD_BOX, 1.5f, 0.2f * (float)(i + 1), -0.8f * (float)i - 0.5f, 0.8f,
		                            0.2f * (float)(i + 1), 0.4f, mirror(0.4f, 0.1f * (float)i));
	things[count++] = world_put(WORLD_BALL, -1.2f, 0.7f, -1.0f, 0.7f, 0.7f, 0.7f, mirror(0.7f, 0.05f));
	for (uint32_t i = 0; i < 5; i++)
		things[count++] =
			world_put(WORLD_BALL, -2.4f + 0.9f * (float)i, 0.2f, 1.0f, 0.2f, 0.2f, 0.2f, shining(6, 3 * i));
	stilb_scene *scene = world_make(things, count, &camera, &around);
	stilb_image_finish(&around.panorama);
	return scene;
}

static void pictures_are_near_those_of_rays(void **state)
{
	(void)state;
	stilb_scene *scene = yard_of(1, 0.0f);
	compare(scene, "mirror", 0.021);
	stilb_scene_destroy(scene);
	scene = yard_of(1, 0.4f);
	compare(scene, "rough", 0.019);
	stilb_scene_destroy(scene);
	scene = stair();
	compare(scene, "stair", 0.027);
	stilb_scene_destroy(scene);
}

/* What mirrors nothing stays as it is, bit by bit, and a floor that has nothing over it mirrors the surroundings as
 * before; frames of the same scene are always the same; what is very rough mirrors the surroundings alone. */
static void surroundings_stay_where_nothing_is_met(void **state)
{
	(void)state;
	stilb_scene *scene = yard_of(2, 0.3f);
	stilb_engine *engine = world_open(scene, (stilb_post_settings){0});
	shown_with(engine, STILB_POST_REFLECTIONS_CONES, on);
	shown_with(engine, STILB_POST_REFLECTIONS_CONES, truth);
	assert_memory_equal(on, truth, sizeof on);
	shown_with(engine, STILB_POST_REFLECTIONS_OFF, off);
	uint32_t things = 0;
	for (uint32_t i = 0; i < PIXELS; i++) {
		stilb_engine_hit hit;
		if (!stilb_engine_pick(engine, (double)(i % WIDTH) + 0.5, (double)(i / WIDTH) + 0.5, &hit) || hit.model == 0)
			continue;
		things++;
		for (uint32_t c = 0; c < 3; c++)
			assert_true(fabsf(on[i][c] - off[i][c]) < 2e-3f); /* added in another order of half floats */
	}
	assert_true(things > 5000);
	world_close(engine);
	stilb_scene_destroy(scene);
	for (uint32_t k = 0; k < 2; k++) {
		stilb_scene_surroundings around = dusk();
		world_thing floor[2] = {world_put(WORLD_BOX, 0, -1, 0, 12, 1, 12, mirror(0.6f, k == 0 ? 0.1f : 0.9f)),
		                        world_put(WORLD_BOX, 0, 0.5f, 0, 0.5f, 0.5f, 0.5f, shining(1, 0))};
		scene = world_make(floor, 1 + k, &camera, &around);
		stilb_image_finish(&around.panorama);
		engine = world_open(scene, (stilb_post_settings){0});
		shown_with(engine, STILB_POST_REFLECTIONS_CONES, on);
		stilb_engine_set_post(engine, &(stilb_post_settings){.occlusion = 1e-6f, .occlusion_radius = 0.01f});
		world_draw(engine, off); /* the surroundings' light apart, too */
		for (uint32_t i = 0; i < PIXELS; i++)
			for (uint32_t c = 0; c < 3; c++)
				if (fabsf(on[i][c] - off[i][c]) > 1e-3f)
					fail_msg("floor %u, pixel %u, %u: %g, without %g", k, i % WIDTH, i / WIDTH, (double)on[i][c],
					         (double)off[i][c]);
		world_close(engine);
		stilb_scene_destroy(scene);
	}
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(pictures_are_near_those_of_rays),
		cmocka_unit_test(surroundings_stay_where_nothing_is_met),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
