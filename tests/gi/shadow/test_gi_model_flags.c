/* Models that are unseen, cast no shadow or receive none: what each kind of ray meets, and what every integrator makes
 * of it. A square hangs over a glossy floor, under each kind of light; the camera looks from between them. */
#include "gi/gi_world_fixture.h"

#include "gi/gi_render.h"
#include "gi/gi_scene_hash.h"
#include "scene/edit/scene_edit.h"
#include "scene/scene_build.h"
#include "support/test.h"

#include <math.h>

#define SIDE 12u
#define HEIGHT 1.0f /* of the square over the floor, metres */

typedef enum lit_by { BY_SUN, BY_POINT, BY_LAMP, BY_SKY, BY_SQUARE, LIGHTS } lit_by;

static const char *const light_names[LIGHTS] = {"sun", "point", "lamp", "sky", "square"};

typedef struct world_made {
	lit_by light;
	bool square;                        /* it is there */
	uint32_t square_flags, floor_flags; /* STILB_SCENE_MODEL_... */
	float above;                        /* height of the camera over the floor */
	bool aside;                         /* a model that nobody sees or is shaded by casts no shadow */
	bool exact;                         /* few samples will do */
	bool pane;                          /* there is glass between the camera and the square */
} world_made;

static stilb_job_pool *pool;

static int begin(void **state)
{
	(void)state;
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	desc.worker_count = 0;
	return stilb_job_pool_create(&desc, &pool);
}

static int end(void **state)
{
	(void)state;
	stilb_job_pool_destroy(pool);
	return 0;
}

/* Adds a horizontal square of this half side, which faces down if `down`. */
static uint32_t add_square(stilb_scene_build *build, float half, float y, bool down,
                           const stilb_scene_material *material, uint32_t flags)
{
	stilb_scene_mesh plane;
	assert_int_equal(stilb_scene_mesh_plane(&plane), STILB_OK);
	stilb_mat4 place = stilb_mat4_scale_translate(half, 0.0f, y, 0.0f);
	if (down) { /* turned about x */
		place.m[5] = -place.m[5];
		place.m[10] = -place.m[10];
	}
	stilb_scene_build_part part = {stilb_scene_build_mesh(build, &plane), stilb_scene_build_material(build, material)};
	uint32_t node = stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &place);
	uint32_t model = stilb_scene_build_model(build, node, &part, 1);
	stilb_scene_build_model_flags(build, model, flags);
	stilb_scene_mesh_finish(&plane);
	return model;
}

static stilb_scene *made(const world_made *what)
{
	static const float grey[3] = {0.4f, 0.4f, 0.4f}, some[3] = {0.3f, 0.3f, 0.3f}, none[3] = {0};
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_material glossy = stilb_scene_material_make(grey, some, 0.4f);
	stilb_scene_material matt = stilb_scene_material_make(grey, none, 1.0f);
	stilb_scene_material shines = stilb_scene_material_make(none, none, 1.0f); /* and reflects nothing */
	for (int i = 0; i < 3; i++)
		shines.emission[i] = 3.0f;
	if (what->square)
		add_square(build, 1.5f, HEIGHT, what->light == BY_SQUARE, what->light == BY_SQUARE ? &shines : &matt,
		           what->square_flags);
	add_square(build, 20.0f, 0.0f, false, &glossy, what->floor_flags);
	add_square(build, 0.1f, -50.0f, false, &matt, what->aside ? STILB_SCENE_MODEL_CASTS_NO_SHADOW : 0);
	stilb_scene_surface pane = stilb_scene_surface_make();
	pane.transmission = 1.0f;
	pane.roughness = 0.0f;
	pane.ior = 1.2f;
	if (what->pane) {
		stilb_scene_material glass = {.surface = 1 + stilb_scene_build_surface(build, &pane)};
		add_square(build, 20.0f, 0.95f * HEIGHT, false, &glass, 0);
	}
	if (what->light == BY_LAMP)
		add_square(build, 1.0f, 3.0f, true, &shines, 0);
	stilb_scene_light light = {.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {0, -1, 0}, .intensity = {2, 2, 2}};
	if (what->light == BY_POINT)
		light = (stilb_scene_light){
			.kind = STILB_SCENE_LIGHT_POINT, .position = {0.1f, 3.0f, 0.0f}, .intensity = {9, 9, 9}};
	if (what->light == BY_SUN || what->light == BY_POINT)
		stilb_scene_build_light(build, &light);
	stilb_scene_surroundings sky = {.sky = {0.7f, 0.7f, 0.7f}, .ground = {0.7f, 0.7f, 0.7f}};
	if (what->light == BY_SKY)
		stilb_scene_build_surroundings(build, &sky);
	stilb_scene_camera camera = {
		.position = {0.0f, what->above, 0.0f}, .pitch = -1.5f, .fov_y = 0.6f, .near_z = 0.01f, .far_z = 100.0f};
	stilb_scene_build_camera(build, &camera);
	stilb_scene *scene;
	if (stilb_scene_build_end(build, &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return scene;
}

static stilb_gi_scene *traced(const stilb_scene *scene)
{
	stilb_gi_scene *gi;
	stilb_gi_scene_desc desc = stilb_gi_scene_desc_default(pool);
	if (stilb_gi_scene_create(scene, &desc, &gi) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return gi;
}

/* The mean radiance of the picture, and its standard error, as if samples were independent. */
typedef struct mean {
	double value, error;
} mean;

static mean mean_of_light(const world_made *what, stilb_gi_integrator integrator, uint32_t depth, stilb_gi_only only)
{
	stilb_scene *scene = made(what);
	stilb_gi_scene *gi = traced(scene);
	stilb_gi_settings settings = stilb_gi_settings_default(scene);
	settings.integrator = integrator;
	settings.width = settings.height = SIDE;
	settings.samples = TEST_ASAN || what->exact ? 4 : 32;
	settings.depth = depth;
	settings.only = only;
	settings.rays = 4;
	settings.cache.rays = 64;
	settings.cache.error = 0.5f;
	stilb_gi_render *render;
	if (stilb_gi_render_create(gi, &settings, pool, &render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	stilb_gi_film film = stilb_gi_render_film(render);
	mean result = {0};
	for (uint32_t i = 0; i < SIDE * SIDE; i++) {
		result.value += (double)film.radiance[3 * i] / (SIDE * SIDE);
		result.error += (double)film.variance[3 * i] / (SIDE * SIDE * SIDE * SIDE);
	}
	result.error = sqrt(result.error);
	stilb_gi_render_destroy(render);
	stilb_gi_scene_destroy(gi);
	stilb_scene_destroy(scene);
	return result;
}

static mean mean_of(const world_made *what, stilb_gi_integrator integrator, uint32_t depth)
{
	return mean_of_light(what, integrator, depth, STILB_GI_ALL_LIGHT);
}

static bool is_same(mean a, mean b)
{
	return fabs(a.value - b.value) <= 4.5 * hypot(a.error, b.error) + 1e-5 * fabs(b.value);
}

static void expect_same(const char *what, lit_by light, stilb_gi_integrator integrator, mean a, mean b)
{
	if (!is_same(a, b))
		fail_msg("%s, by %s, integrator %d: %.5f +- %.5f, not %.5f +- %.5f", what, light_names[light], (int)integrator,
		         a.value, a.error, b.value, b.error);
}

static const stilb_gi_integrator integrators[] = {STILB_GI_INTEGRATOR_DIRECT, STILB_GI_INTEGRATOR_PATH,
                                                  STILB_GI_INTEGRATOR_SPLIT, STILB_GI_INTEGRATOR_MONTECARLO,
                                                  STILB_GI_INTEGRATOR_IRRADIANCE_CACHE};

/* ---- direct light ------------------------------------------------------------------------------------------------ */

/* Under the square: what casts no shadow, or on what none falls, is lit as without the square, and what is unseen casts
 * its shadow all the same; whichever technique samples the light, which is the same for all integrators. */
static void direct_light(void **state)
{
	(void)state;
	for (lit_by light = 0; light < BY_SQUARE; light++) {
		world_made empty = {.light = light, .above = 0.9f * HEIGHT}, under = empty;
		under.square = true;
		for (size_t i = 0; i < sizeof integrators / sizeof *integrators; i++) {
			mean lit = mean_of(&empty, integrators[i], 1), shadow = mean_of(&under, integrators[i], 1);
			assert_true(lit.value > 0.05 && !is_same(lit, shadow) && shadow.value < 0.8 * lit.value);
			world_made unseen = under, thin = under, bare = under;
			unseen.square_flags = STILB_SCENE_MODEL_UNSEEN;
			thin.square_flags = STILB_SCENE_MODEL_CASTS_NO_SHADOW;
			bare.floor_flags = STILB_SCENE_MODEL_RECEIVES_NO_SHADOW;
			expect_same("unseen", light, integrators[i], mean_of(&unseen, integrators[i], 1), shadow);
			expect_same("casts none", light, integrators[i], mean_of(&thin, integrators[i], 1), lit);
			expect_same("receives none", light, integrators[i], mean_of(&bare, integrators[i], 1), lit);
		}
	}
}

/* The same through a pane, by which rays towards lights are tinted and not blocked. */
static void light_through_glass(void **state)
{
	(void)state;
	for (lit_by light = 0; light < BY_SQUARE; light++)
		for (size_t i = 0; i < 2; i++) {
			world_made empty = {.light = light, .above = 0.9f * HEIGHT, .pane = true}, under = empty;
			under.square = true;
			mean lit = mean_of(&empty, integrators[i], 1), shadow = mean_of(&under, integrators[i], 1);
			assert_true(lit.value > 0.05 && !is_same(lit, shadow) && shadow.value < 0.8 * lit.value);
			world_made unseen = under, thin = under, bare = under;
			unseen.square_flags = STILB_SCENE_MODEL_UNSEEN;
			thin.square_flags = STILB_SCENE_MODEL_CASTS_NO_SHADOW;
			bare.floor_flags = STILB_SCENE_MODEL_RECEIVES_NO_SHADOW;
			expect_same("unseen", light, integrators[i], mean_of(&unseen, integrators[i], 1), shadow);
			expect_same("casts none", light, integrators[i], mean_of(&thin, integrators[i], 1), lit);
			assert_true(mean_of(&bare, integrators[i], 1).value > lit.value); /* nor does glass take anything */
		}
}

/* A square that is itself the lamp lights the floor whether rays towards lights meet it or not, and whether it is seen
 * or not. */
static void lamps_with_flags(void **state)
{
	(void)state;
	world_made lamp = {.light = BY_SQUARE, .square = true, .above = 0.9f * HEIGHT};
	for (size_t i = 0; i < sizeof integrators / sizeof *integrators; i++) {
		mean lit = mean_of(&lamp, integrators[i], 1);
		assert_true(lit.value > 0.5);
		for (uint32_t flags = 1; flags <= STILB_SCENE_MODEL_FLAGS; flags++) {
			world_made other = lamp;
			other.square_flags = flags;
			expect_same("lamp", BY_SQUARE, integrators[i], mean_of(&other, integrators[i], 1), lit);
		}
		world_made bare = lamp;
		bare.floor_flags = STILB_SCENE_MODEL_RECEIVES_NO_SHADOW;
		expect_same("floor", BY_SQUARE, integrators[i], mean_of(&bare, integrators[i], 1), lit);
	}
}

/* A flag that changes nothing in the picture changes no more than the order of its sums: where lights are found by rays
 * of their own, the same rays meet the same. */
static void flags_aside_change_nothing(void **state)
{
	(void)state;
	for (lit_by light = 0; light < LIGHTS; light++)
		for (size_t i = 0; i < sizeof integrators / sizeof *integrators; i++)
			for (int only = STILB_GI_ALL_LIGHT; only <= STILB_GI_ONLY_INDIRECT; only++) {
				world_made plain = {.light = light, .square = true, .above = 0.9f * HEIGHT, .exact = true},
						   flagged = plain;
				flagged.aside = true;
				uint32_t depth = integrators[i] == STILB_GI_INTEGRATOR_MONTECARLO ? 2 : 4;
				mean a = mean_of_light(&plain, integrators[i], depth, (stilb_gi_only)only);
				mean b = mean_of_light(&flagged, integrators[i], depth, (stilb_gi_only)only);
				if (!(fabs(a.value - b.value) <= 1e-6 * a.value))
					fail_msg("by %s, integrator %d, only %d: %.9f, not %.9f", light_names[light], (int)integrators[i],
					         only, b.value, a.value);
			}
}

/* ---- what is looked at ------------------------------------------------------------------------------------------- */

/* From above: an unseen square is not there, one that casts no shadow is. */
static void cameras(void **state)
{
	(void)state;
	static const uint32_t flags[] = {0, STILB_SCENE_MODEL_UNSEEN, STILB_SCENE_MODEL_CASTS_NO_SHADOW,
	                                 STILB_SCENE_MODEL_RECEIVES_NO_SHADOW};
	for (size_t i = 0; i < sizeof flags / sizeof *flags; i++) {
		world_made above = {.light = BY_SUN, .square = true, .square_flags = flags[i], .above = 3.0f};
		mean color = mean_of(&above, STILB_GI_INTEGRATOR_COLOR, 0);
		bool floor = flags[i] == STILB_SCENE_MODEL_UNSEEN;
		SHADE_PROOF_NEAR((float)color.value, floor ? 0.7 : 0.4, 0.0, 1e-5);
	}
}

/* From floor to square to floor: an unseen square sends no light back, one that casts no shadow does. Without the
 * square there is nothing that could. */
static void indirect_light(void **state)
{
	(void)state;
	static const stilb_gi_integrator paths[] = {STILB_GI_INTEGRATOR_PATH, STILB_GI_INTEGRATOR_MONTECARLO,
	                                            STILB_GI_INTEGRATOR_IRRADIANCE_CACHE};
	for (size_t i = 0; i < sizeof paths / sizeof *paths; i++) {
		world_made under = {.light = BY_LAMP, .square = true, .above = 0.9f * HEIGHT}, thin = under, unseen = under;
		world_made empty = {.light = BY_LAMP, .above = under.above};
		thin.square_flags = STILB_SCENE_MODEL_CASTS_NO_SHADOW;
		unseen.square_flags = STILB_SCENE_MODEL_UNSEEN;
		mean lit = mean_of(&empty, paths[i], 3), shadow = mean_of(&under, paths[i], 1);
		mean more = mean_of(&thin, paths[i], 3);
		if (!(more.value - lit.value > 3.0 * hypot(more.error, lit.error)) && !TEST_ASAN) /* of few samples */
			fail_msg("integrator %d: %.5f +- %.5f and %.5f +- %.5f", (int)paths[i], more.value, more.error, lit.value,
			         lit.error);
		expect_same("unseen", BY_LAMP, paths[i], mean_of(&unseen, paths[i], 3), shadow);
		/* Direct light and the rest are all of it; the sky is found by rays alone. */
		for (int sky = 0; sky < 2; sky++) {
			thin.light = sky ? BY_SKY : BY_LAMP;
			mean rest = mean_of_light(&thin, paths[i], 3, STILB_GI_ONLY_INDIRECT), direct = mean_of(&thin, paths[i], 1);
			mean sum = {rest.value + direct.value, hypot(rest.error, direct.error)};
			expect_same("the sum", thin.light, paths[i], sum, mean_of(&thin, paths[i], 3));
			assert_true(rest.value < 0.5 * direct.value);
		}
	}
}

/* Ambient occlusion is light from all around: it asks for what casts and receives. */
static void occlusion(void **state)
{
	(void)state;
	world_made under = {.light = BY_SUN, .square = true, .above = 0.9f * HEIGHT}, other = under;
	mean dark = mean_of(&under, STILB_GI_INTEGRATOR_AO, 1);
	assert_true(dark.value < 0.5);
	other.square_flags = STILB_SCENE_MODEL_UNSEEN;
	expect_same("unseen", BY_SUN, STILB_GI_INTEGRATOR_AO, mean_of(&other, STILB_GI_INTEGRATOR_AO, 1), dark);
	other.square_flags = STILB_SCENE_MODEL_CASTS_NO_SHADOW;
	SHADE_PROOF_NEAR((float)mean_of(&other, STILB_GI_INTEGRATOR_AO, 1).value, 1.0, 0.0, 1e-6);
	other = under;
	other.floor_flags = STILB_SCENE_MODEL_RECEIVES_NO_SHADOW;
	SHADE_PROOF_NEAR((float)mean_of(&other, STILB_GI_INTEGRATOR_AO, 1).value, 1.0, 0.0, 1e-6);
}

/* ---- rays -------------------------------------------------------------------------------------------------------- */

#define STACK 8u /* triangles one behind the other; bits of the index are the flags, but for the third */

static stilb_scene *stack(bool shared)
{
	stilb_scene *scene;
	assert_int_equal(scene_create(STACK, STACK, shared ? 1 : STACK, 1, &scene), STILB_OK);
	scene->materials[0] = (stilb_scene_material){.diffuse = {0.5f, 0.5f, 0.5f}, .roughness = 1.0f};
	for (uint32_t i = 0; i < STACK; i++) {
		const float corners[3][3] = {{-1.0f, -1.0f, 0.0f}, {1.0f, -1.0f, 0.0f}, {0.0f, 1.0f, 0.0f}};
		if (i == 0 || !shared)
			world_triangle(&scene->meshes[i], corners);
		scene->part_mesh[i] = shared ? 0 : i;
		scene->part_transform[i] = stilb_mat4_scale_translate(1.0f, 0.0f, 0.0f, -(float)i);
		scene->first_part[i + 1] = i + 1;
		scene_fit_bounds(scene, i);
		scene_set_model_flags(scene, i, i & 3);
	}
	return scene;
}

/* The first triangle from number `from` on that a ray of this kind meets. */
static uint32_t first_met(uint32_t from, uint32_t mask)
{
	uint32_t missing = mask == GI_MASK_LOOK ? STILB_SCENE_MODEL_UNSEEN : STILB_SCENE_MODEL_CASTS_NO_SHADOW;
	for (; from < STACK; from++)
		if (mask && !(from & missing))
			return from;
	return GI_NO_PART;
}

/* Rays of every kind, alone and in packets, of both intersectors, of copies and of instances. */
static void rays_meet_their_kind(void **state)
{
	(void)state;
	for (int round = 0; round < 8; round++) {
		const stilb_gi_intersector *intersector = round & 1 ? &stilb_gi_brute : &stilb_gi_embree;
		stilb_scene *scene = stack(round & 2);
		stilb_gi_scene_desc desc = {.pool = pool, .intersector = intersector, .movable = round & 4};
		stilb_gi_scene *gi;
		assert_int_equal(stilb_gi_scene_create(scene, &desc, &gi), STILB_OK);
		assert_true(gi->flagged);
		static const uint32_t masks[] = {GI_MASK_LOOK, GI_MASK_LIGHT, 0};
		for (uint32_t m = 0; m < 3 * STACK; m++) {
			uint32_t from = m / 3, met = first_met(from, masks[m % 3]);
			stilb_vec3 origin = stilb_vec3_make(0.0f, -0.1f, 0.5f - (float)from);
			gi_ray_hit ray = gi_ray_hit_make(origin, stilb_vec3_make(0.0f, 0.0f, -1.0f));
			ray.ray.mask = masks[m % 3];
			gi_ray_hit16 packet;
			int valid[16] __attribute__((aligned(64)));
			memset(&packet, 0, sizeof packet);
			for (uint32_t i = 0; i < 16; i++) {
				valid[i] = -1;
				for (int k = 0; k < 3; k++)
					packet.ray.origin[k][i] = ray.ray.origin[k];
				packet.ray.direction[2][i] = -1.0f;
				packet.ray.t_max[i] = INFINITY;
				packet.ray.mask[i] = masks[m % 3];
				packet.hit.part[i] = GI_NO_PART;
			}
			gi_ray shadows[3] = {ray.ray, ray.ray, ray.ray};
			gi->tracer.intersect16(&gi->tracer, valid, &packet);
			gi->tracer.intersect(&gi->tracer, &ray);
			gi->tracer.occluded(&gi->tracer, shadows, 3);
			assert_int_equal(ray.hit.part, met);
			for (uint32_t i = 0; i < 16; i++)
				assert_int_equal(packet.hit.part[i], met);
			for (int i = 0; i < 3; i++)
				assert_int_equal(shadows[i].t_max < 0.0f, met != GI_NO_PART);
		}
		stilb_gi_scene_destroy(gi);
		stilb_scene_destroy(scene);
	}
}

/* Flags that are edited reach a scene that is updated, and its hash, which checkpoints and caches are held against. */
static void updates_follow(void **state)
{
	(void)state;
	for (int movable = 0; movable < 2; movable++) {
		world_made what = {.light = BY_SUN, .square = true, .above = 3.0f};
		stilb_scene *scene = made(&what);
		stilb_gi_scene_desc desc = stilb_gi_scene_desc_default(pool);
		desc.movable = movable;
		stilb_gi_scene *gi;
		assert_int_equal(stilb_gi_scene_create(scene, &desc, &gi), STILB_OK);
		uint64_t hashes[STILB_SCENE_MODEL_FLAGS + 1];
		for (uint32_t step = 0; step <= STILB_SCENE_MODEL_FLAGS + 1; step++) {
			uint32_t flags = step & STILB_SCENE_MODEL_FLAGS;
			assert_int_equal(stilb_scene_set_model_flags(scene, 0, flags), STILB_OK);
			assert_int_equal(stilb_gi_scene_update(gi, scene, &desc), STILB_OK);
			gi_ray_hit ray = gi_ray_hit_make(stilb_vec3_make(0.1f, 2.0f, 0.2f), stilb_vec3_make(0.0f, -1.0f, 0.0f));
			gi_ray shadow =
				gi_ray_make(stilb_vec3_make(0.1f, 2.0f, 0.2f), stilb_vec3_make(0.0f, -1.0f, 0.0f), 1.5f, 0.0f);
			gi->tracer.intersect(&gi->tracer, &ray);
			gi->tracer.occluded(&gi->tracer, &shadow, 1);
			assert_int_equal(ray.hit.part, flags & STILB_SCENE_MODEL_UNSEEN ? 1 : 0);
			assert_int_equal(shadow.t_max > 0.0f, (flags & STILB_SCENE_MODEL_CASTS_NO_SHADOW) != 0);
			assert_int_equal(gi->parts[0].lit_by, flags & STILB_SCENE_MODEL_RECEIVES_NO_SHADOW ? 0 : GI_MASK_LIGHT);
			assert_int_equal(gi->flagged, flags != 0);
			uint64_t hash = gi_scene_hash(gi);
			if (step > STILB_SCENE_MODEL_FLAGS)
				assert_true(hash == hashes[0]);
			for (uint32_t before = 0; before < step && step <= STILB_SCENE_MODEL_FLAGS; before++)
				assert_true(hash != hashes[before]);
			if (step <= STILB_SCENE_MODEL_FLAGS)
				hashes[step] = hash;
		}
		stilb_gi_scene_destroy(gi);
		stilb_scene_destroy(scene);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(rays_meet_their_kind),
		cmocka_unit_test(cameras),
		cmocka_unit_test(direct_light),
		cmocka_unit_test(light_through_glass),
		cmocka_unit_test(flags_aside_change_nothing),
		cmocka_unit_test(lamps_with_flags),
		cmocka_unit_test(indirect_light),
		cmocka_unit_test(occlusion),
		cmocka_unit_test(updates_follow),
	};
	return cmocka_run_group_tests(tests, begin, end);
}
