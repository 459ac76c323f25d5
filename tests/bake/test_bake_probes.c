/* Probes against closed forms: an even sky, half a sky; a wall between a bright room and a dark one, with a door and
 * without; probes inside of something; the same bits for any number of workers. */
#include "bake_made.h"

#include "bake/bake_probes.h"

typedef struct probed {
	stilb_scene *scene;
	stilb_job_pool *pool;
	stilb_gi_scene *gi;
	stilb_gi_gather *gather;
	stilb_bake_probes probes;
} probed;

static probed probe(stilb_scene *scene, float spacing, uint32_t samples, uint32_t workers)
{
	probed p = {.scene = scene, .pool = made_pool(workers)};
	stilb_gi_scene_desc desc = {.pool = p.pool, .intersector = &stilb_gi_embree};
	stilb_gi_settings settings = stilb_gi_settings_default(scene);
	stilb_bake_probes_options options = {.spacing = spacing, .samples = samples};
	settings.samples = samples;
	settings.depth = 8;
	assert_int_equal(stilb_gi_scene_create(scene, &desc, &p.gi), STILB_OK);
	assert_int_equal(stilb_gi_gather_create(p.gi, &settings, workers + 1, &p.gather), STILB_OK);
	if (stilb_bake_probes_bake(scene, p.gi, p.gather, p.pool, &options, &p.probes) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return p;
}

static void probed_finish(probed *p)
{
	stilb_bake_probes_finish(&p->probes);
	stilb_gi_gather_destroy(p->gather);
	stilb_gi_scene_destroy(p->gi);
	stilb_scene_destroy(p->scene);
	stilb_job_pool_destroy(p->pool);
}

/* A scene of boxes, one a mesh; the first `rooms` are seen from inside. All are half grey under a black sky. */
static stilb_scene *boxes(float (*sides)[6], uint32_t count, uint32_t rooms)
{
	stilb_scene *scene;
	assert_int_equal(scene_create(1, count, count, count, &scene), STILB_OK);
	scene->first_part[1] = count;
	made_mesh cube = made_cube();
	for (uint32_t i = 0; i < count; i++) {
		stilb_scene_mesh *mesh = &scene->meshes[i];
		assert_int_equal(scene_mesh_create(mesh, 24, 36), STILB_OK);
		for (uint32_t v = 0; v < 24; v++) {
			mesh->vertices[v] = (stilb_scene_vertex){0}; /* no normals: the triangles' own count */
			for (int k = 0; k < 3; k++)
				mesh->vertices[v].position[k] = sides[i][k] + cube.positions[v][k] * (sides[i][3 + k] - sides[i][k]);
		}
		for (uint32_t t = 0; t < 12; t++) {
			mesh->indices[3 * t] = cube.indices[3 * t];
			mesh->indices[3 * t + 1] = cube.indices[3 * t + (i < rooms ? 2 : 1)];
			mesh->indices[3 * t + 2] = cube.indices[3 * t + (i < rooms ? 1 : 2)];
		}
		scene->part_mesh[i] = scene->part_material[i] = i;
		scene->part_transform[i] = stilb_mat4_identity();
		scene->materials[i] = (stilb_scene_material){.diffuse = {0.5f, 0.5f, 0.5f}, .roughness = 1.0f};
	}
	made_finish(&cube);
	const float black[3] = {0.0f, 0.0f, 0.0f};
	stilb_scene_set_sky(scene, black);
	return scene;
}

static float irradiance(const probed *p, float x, float y, float z, const float normal[3], bool plain)
{
	const float at[3] = {x, y, z};
	shade_sh_rgb light =
		plain ? stilb_bake_probes_at_plain(&p->probes, at) : stilb_bake_probes_at(&p->probes, at, normal);
	return shade_sh_irradiance(light.g, stilb_vec3_make(normal[0], normal[1], normal[2]));
}

/* ---- skies ------------------------------------------------------------------------------------------------------- */

static void test_an_even_sky(void **state)
{
	(void)state;
	float speck[1][6] = {{0.0f, 0.0f, 0.0f, 1e-3f, 1e-3f, 1e-3f}};
	stilb_scene *scene = boxes(speck, 1, 0);
	const float sky[3] = {1.0f, 2.0f, 0.5f};
	stilb_scene_set_sky(scene, sky);
	probed p = probe(scene, 1.0f, 1024, 0);
	assert_int_equal(p.probes.count[0] * p.probes.count[1] * p.probes.count[2], 8);
	assert_int_equal(p.probes.dead + p.probes.moved, 0);
	for (int i = 0; i < 8; i++) {
		const shade_sh *green = &p.probes.probes[i].light.g;
		assert_float_equal(green->c[0], 2.0f * 2.0f * sqrtf(MADE_PI), 0.02f);
		for (int k = 1; k < 9; k++)
			assert_float_equal(green->c[k], 0.0f, 0.1f);
	}
	const float up[3] = {0.0f, 1.0f, 0.0f};
	assert_float_equal(irradiance(&p, 0.1f, 0.2f, -0.1f, up, false), 2.0f * MADE_PI, 0.02f * MADE_PI);
	assert_float_equal(irradiance(&p, 100.0f, -50.0f, 0.0f, up, false), 2.0f * MADE_PI, 0.05f * MADE_PI);
	probed_finish(&p);
}

/* Under half a sky a surface that leans by t has (pi / 2) (1 + cos t): nine coefficients hold that exactly. */
static void test_half_a_sky(void **state)
{
	(void)state;
	float speck[1][6] = {{0.0f, 0.0f, 0.0f, 1e-3f, 1e-3f, 1e-3f}};
	stilb_scene *scene = boxes(speck, 1, 0);
	made_set(scene->surroundings.sky, 1.0f, 1.0f, 1.0f);
	probed p = probe(scene, 1.0f, 4096, 0);
	for (int i = 0; i <= 8; i++) {
		float t = MADE_PI * (float)i / 8.0f;
		const float normal[3] = {sinf(t) * 0.6f, cosf(t), sinf(t) * 0.8f};
		assert_float_equal(irradiance(&p, 0.0f, 0.0f, 0.0f, normal, false), 0.5f * MADE_PI * (1.0f + cosf(t)), 0.02f);
	}
	probed_finish(&p);
}

/* A sun of irradiance E from l: E Y_i(l), exactly, as each sample finds it or not. */
static void test_a_sun(void **state)
{
	(void)state;
	float speck[1][6] = {{0.0f, 0.0f, 0.0f, 1e-3f, 1e-3f, 1e-3f}};
	stilb_scene *scene = boxes(speck, 1, 0);
	scene->lights = calloc(1, sizeof *scene->lights);
	scene->light_count = 1;
	scene->lights[0] = (stilb_scene_light){
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {-0.48f, -0.8f, -0.36f}, .intensity = {3.0f, 2.0f, 1.0f}};
	probed p = probe(scene, 1.0f, 96, 0);
	shade_sh truth = shade_sh_directional(stilb_vec3_make(0.48f, 0.8f, 0.36f), 2.0f);
	for (int k = 0; k < 9; k++)
		assert_float_equal(p.probes.probes[7].light.g.c[k], truth.c[k], 1e-3f);
	probed_finish(&p);
}

/* ---- rooms ------------------------------------------------------------------------------------------------------- */

/* A hall of 6 x 2.5 x 3 m whose left third has a lamp at its ceiling, and a wall of 5 cm at x = 0, with a door of 1 m
 * or without. */
static stilb_scene *hall(bool door)
{
	float sides[4][6] = {{-3.0f, 0.0f, -1.5f, 3.0f, 2.5f, 1.5f},
	                     {-2.5f, 2.45f, -1.0f, -1.0f, 2.49f, 1.0f},
	                     {-0.025f, -0.1f, -1.6f, 0.025f, 2.6f, door ? -0.5f : 1.6f},
	                     {-0.025f, -0.1f, 0.5f, 0.025f, 2.6f, 1.6f}};
	stilb_scene *scene = boxes(sides, door ? 4 : 3, 1);
	scene->materials[1].emission[0] = scene->materials[1].emission[1] = scene->materials[1].emission[2] = 5.0f;
	return scene;
}

static const float axes[6][3] = {{1.0f, 0.0f, 0.0f},  {-1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f},
                                 {0.0f, -1.0f, 0.0f}, {0.0f, 0.0f, 1.0f},  {0.0f, 0.0f, -1.0f}};

/* The mean irradiance over six directions at a place. */
static float mean_at(const probed *p, float x, float y, float z, bool plain)
{
	float sum = 0.0f;
	for (int i = 0; i < 6; i++)
		sum += irradiance(p, x, y, z, axes[i], plain) / 6.0f;
	return sum;
}

/* Behind the wall it is dark, to 1 % of the bright side; without weights it is not. */
static void test_a_wall_keeps_light_out(void **state)
{
	(void)state;
	probed p = probe(hall(false), 1.0f, 512, 1);
	float leak = 0.0f, plain = 0.0f, bright = 0.0f;
	for (int i = 0; i < 10; i++)
		for (int j = 0; j < 5; j++) {
			float z = -1.2f + 0.25f * (float)i, y = 0.2f + 0.5f * (float)j;
			for (int k = 0; k < 6; k++) {
				/* What faces the wall is at least 10 cm behind it. */
				float x = 0.03f + 0.1f * (float)(i % 5 + (k == 1));
				leak = fmaxf(leak, irradiance(&p, x, y, z, axes[k], false));
				plain = fmaxf(plain, irradiance(&p, 0.03f, y, z, axes[k], true));
			}
			bright += mean_at(&p, -0.5f, y, z, false) / 50.0f;
		}
	assert_true(bright > 0.2f);
	print_message("leak %.5f, without weights %.3f of the bright side\n", (double)(leak / bright),
	              (double)(plain / bright));
	assert_true(leak <= 0.01f * bright);
	assert_true(plain > 0.2f * bright);
	probed_finish(&p);
}

/* Through the door light falls the farther one goes, step by step, and never to nothing. */
static void test_a_walk_through_a_door(void **state)
{
	(void)state;
	probed p = probe(hall(true), 0.5f, 1024, 1);
	float before = mean_at(&p, -0.75f, 1.25f, 0.0f, false), first = before;
	for (int i = 1; i <= 30; i++) {
		float now = mean_at(&p, -0.75f + 0.1f * (float)i, 1.25f, 0.0f, false);
		if (!(now <= before * 1.01f) || !(now > 0.0f))
			fail_msg("step %d: %g after %g", i, (double)now, (double)before);
		before = now;
	}
	assert_true(before < 0.25f * first);
	probed_finish(&p);
}

/* A thick pillar in a room: probes in it are dead or have moved out, and do not darken what is beside it. */
static void test_probes_in_a_pillar(void **state)
{
	(void)state;
	float sides[2][6] = {{-3.0f, 0.0f, -3.0f, 3.0f, 3.0f, 3.0f}, {-0.9f, -0.1f, -0.9f, 0.9f, 3.1f, 0.9f}};
	stilb_scene *scene = boxes(sides, 2, 1);
	scene->materials[0].emission[0] = scene->materials[0].emission[1] = scene->materials[0].emission[2] = 1.0f;
	probed p = probe(scene, 0.5f, 64, 1);
	assert_true(p.probes.dead > 0 && p.probes.moved > 0);
	uint32_t inside = 0, out_again = 0;
	for (uint32_t i = 0; i < p.probes.count[0] * p.probes.count[1] * p.probes.count[2]; i++) {
		const stilb_bake_probe *one = &p.probes.probes[i];
		bool within = fabsf(one->position[0]) < 0.9f && fabsf(one->position[2]) < 0.9f;
		assert_int_equal(one->dead, within);
		inside += within;
		uint32_t x = i % p.probes.count[0], z = i / p.probes.count[0] / p.probes.count[1];
		bool away = fabsf(one->position[0] - p.probes.low[0] - (float)x * p.probes.spacing) > 1e-3f ||
		            fabsf(one->position[2] - p.probes.low[2] - (float)z * p.probes.spacing) > 1e-3f;
		out_again += away && !within;
		/* Whatever a dead one has does not count. */
		if (one->dead)
			for (int k = 0; k < 9; k++)
				p.probes.probes[i].light.g.c[k] = 1e6f;
	}
	assert_true(out_again > 0);
	assert_int_equal(inside, p.probes.dead);
	const float out[3] = {1.0f, 0.0f, 0.0f};
	float beside = irradiance(&p, 0.92f, 1.5f, 0.1f, out, false);
	assert_true(beside > 0.8f * MADE_PI && beside < 2.2f * MADE_PI);
	float within = irradiance(&p, 0.5f, 1.5f, 0.1f, out, false);
	assert_true(within > 0.0f && within < 2.2f * MADE_PI);
	probed_finish(&p);
}

/* ---- bits and limits --------------------------------------------------------------------------------------------- */

static uint64_t bits_of(uint32_t workers)
{
	probed p = probe(hall(true), 1.0f, 64, workers);
	size_t count = p.probes.count[0] * p.probes.count[1] * p.probes.count[2];
	uint64_t hash = STILB_FNV1A64_START;
	for (size_t i = 0; i < count; i++) {
		hash = stilb_hash_fnv1a64(hash, &p.probes.probes[i].light, sizeof p.probes.probes[i].light);
		hash = stilb_hash_fnv1a64(hash, p.probes.probes[i].seen, sizeof p.probes.probes[i].seen);
	}
	probed_finish(&p);
	return hash;
}

static void test_the_same_bits_for_any_workers(void **state)
{
	(void)state;
	uint64_t alone = bits_of(0);
	assert_true(alone == bits_of(1));
	assert_true(alone == bits_of(3));
}

static void test_too_many(void **state)
{
	(void)state;
	probed p = probe(hall(false), 1.0f, 16, 0);
	stilb_bake_probes_options options = {.spacing = 0.001f, .samples = 16};
	stilb_bake_probes more;
	assert_int_equal(stilb_bake_probes_bake(p.scene, p.gi, p.gather, p.pool, &options, &more), STILB_ERROR_ARGUMENT);
	assert_null(more.probes);
	assert_non_null(strstr(stilb_error_message(), "0.001 m apart"));
	probed_finish(&p);
}

int main(void)
{
	static const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_an_even_sky),
		cmocka_unit_test(test_half_a_sky),
		cmocka_unit_test(test_a_sun),
		cmocka_unit_test(test_a_wall_keeps_light_out),
		cmocka_unit_test(test_a_walk_through_a_door),
		cmocka_unit_test(test_probes_in_a_pillar),
		cmocka_unit_test(test_the_same_bits_for_any_workers),
		cmocka_unit_test(test_too_many),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
