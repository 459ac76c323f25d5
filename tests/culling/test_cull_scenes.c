/* 100,000 small random scenes in motion: every method, with every instruction set, on one thread and on several, gives
 * the result of a plain loop. Bounds and planes can have any values, also NaN and infinities. */
#include "support/cull_reference.h"

#define SCENES (TEST_ASAN ? 12000u : 100000u)
#define MOST_MODELS 160u
#define FAR 1e6f /* metres from the origin */

/* Kinds of scenes, each for another kind of fault. */
typedef enum world {
	WORLD_CLOUD,   /* all sizes */
	WORLD_LATTICE, /* on the faces of cells, touching planes exactly */
	WORLD_FAR,     /* where floats are coarse */
	WORLD_HUGE,    /* coordinates and radii near overflow */
	WORLD_STRANGE, /* every other model has a NaN, infinite or negative value */
	WORLD_SPOT,    /* all in one place */
	WORLDS
} world;

static float world_extent(world kind)
{
	return kind == WORLD_HUGE ? 1e37f : kind == WORLD_LATTICE ? 8.0f : 50.0f;
}

static stilb_sphere world_sphere(world kind, reference_random *random)
{
	float extent = world_extent(kind);
	stilb_sphere sphere = {random_between(random, -extent, extent), random_between(random, -extent, extent),
	                       random_between(random, -extent, extent), exp2f(random_between(random, -8.0f, 5.0f))};
	switch (kind) {
	case WORLD_LATTICE:
		return (stilb_sphere){rintf(sphere.x), rintf(sphere.y), rintf(sphere.z), (float)random_below(random, 3)};
	case WORLD_FAR:
		sphere.x += FAR;
		return sphere;
	case WORLD_HUGE:
		sphere.radius *= 1e36f;
		return sphere;
	case WORLD_STRANGE:
		return random_below(random, 2) ? random_strange_sphere(random, extent) : sphere;
	case WORLD_SPOT:
		return (stilb_sphere){1.0f, 2.0f, 3.0f, random_below(random, 2) ? 0.0f : sphere.radius};
	default:
		return sphere;
	}
}

/* A camera, a box with integer coordinates, or planes that no camera has. */
static stilb_frustum world_view(world kind, reference_random *random)
{
	float extent = world_extent(kind);
	if (kind == WORLD_LATTICE) {
		float low[3], high[3];
		for (int axis = 0; axis < 3; axis++) {
			low[axis] = (float)random_below(random, 20) - 10.0f;
			high[axis] = low[axis] + (float)random_below(random, 12);
		}
		return box_view(low, high);
	}
	stilb_frustum view = random_view(random, extent);
	for (int p = 0; kind == WORLD_FAR && p < 6; p++)
		view.planes[p].distance -= FAR * view.planes[p].x;
	uint32_t plane = random_below(random, 6);
	float *values = (float *)&view.planes[plane];
	switch (random_below(random, 8)) {
	case 0: /* a plane without a normal: it sees everything or nothing */
		view.planes[plane] = (stilb_plane){0.0f, 0.0f, 0.0f, random_between(random, -1.0f, 1.0f)};
		break;
	case 1: /* the same plane twice */
		view.planes[plane] = view.planes[(plane + 1) % 6];
		break;
	case 2: /* a normal that is not of unit length */
		for (int i = 0; i < 4; i++)
			values[i] *= exp2f(random_between(random, -140.0f, 120.0f));
		break;
	case 3:
		values[random_below(random, 4)] = random_strange_value(random);
		break;
	default:
		break;
	}
	return view;
}

#define VIEWS 5u /* that are culled together, more than threads */

typedef struct fixture {
	stilb_scene scene;
	stilb_cull *cull;
	stilb_cull_visible visible;
	stilb_cull_visible together[VIEWS];
	stilb_job_pool *pool;
	uint32_t expected[MOST_MODELS], expected_count;
	uint64_t seen, all; /* models that are seen, and that there are, added up over all views */
} fixture;

static void expect(fixture *f, const stilb_frustum *view)
{
	f->expected_count = 0;
	for (uint32_t model = 0; model < f->scene.model_count; model++)
		if (reference_visible(scene_get(&f->scene, model), view))
			f->expected[f->expected_count++] = model;
	f->seen += f->expected_count;
	f->all += f->scene.model_count;
}

static void assert_run(fixture *f, stilb_cull_method method, const stilb_frustum *view, stilb_job_pool *pool)
{
	assert_int_equal(stilb_cull_run(f->cull, method, &f->scene, view, pool, 0, &f->visible), STILB_OK);
	if (f->visible.count != f->expected_count ||
	    memcmp(f->visible.ids, f->expected, f->expected_count * sizeof *f->expected) != 0)
		fail_msg("method %d sees %u of %u models, where a plain loop sees %u, or others", method, f->visible.count,
		         f->scene.model_count, f->expected_count);
}

/* Five views together, one like the other but the second, which sees nothing. */
static void assert_views(fixture *f, stilb_cull_method method, const stilb_frustum *view)
{
	stilb_frustum frusta[VIEWS] = {*view, *view, *view, *view, *view};
	frusta[1].planes[0] = (stilb_plane){0.0f, 0.0f, 0.0f, -INFINITY};
	assert_int_equal(stilb_cull_run_views(f->cull, method, &f->scene, frusta, VIEWS, f->pool, 0, f->together),
	                 STILB_OK);
	for (uint32_t v = 0; v < VIEWS; v++) {
		const stilb_cull_visible *seen = &f->together[v];
		uint32_t count = v == 1 ? seen->count : f->expected_count;
		assert_int_equal(seen->count, count);
		assert_memory_equal(seen->ids, f->expected, v == 1 ? 0 : count * sizeof *seen->ids);
		for (uint32_t i = 0; v == 1 && i < seen->count; i++)
			assert_true(isinf(f->scene.bounds.radius[seen->ids[i]]));
	}
}

static void assert_view(fixture *f, const stilb_frustum *view, bool parallel)
{
	expect(f, view);
	f->cull->serial_below = parallel ? 0 : CULL_SERIAL_BELOW;
	for (stilb_isa isa = STILB_ISA_SCALAR; isa <= stilb_cpu_widest_isa(); isa++) {
		f->cull->kernels = f->cull->octree->kernels = cull_kernels_for(isa);
		for (stilb_cull_method method = STILB_CULL_AUTO; method <= STILB_CULL_FLAT; method++)
			assert_run(f, method, view, parallel ? f->pool : NULL);
		if (parallel)
			assert_views(f, (stilb_cull_method)(isa % 3), view);
	}
}

static void move_some(fixture *f, world kind, reference_random *random)
{
	uint32_t moved[MOST_MODELS], count = 0;
	for (uint32_t model = random_below(random, 5); model < f->scene.model_count; model += 1 + random_below(random, 9)) {
		scene_set(&f->scene, model, world_sphere(kind, random));
		moved[count++] = model;
	}
	assert_int_equal(stilb_cull_update(f->cull, &f->scene, moved, count), STILB_OK);
}

/* Replaces the octree by one of another depth: with so few models it would be shallow. */
static void deepen(fixture *f, reference_random *random)
{
	stilb_cull_octree_desc desc = cull_desc_for_scene(&f->scene);
	desc.max_depth = random_below(random, 7);
	stilb_cull_octree_destroy(f->cull->octree);
	assert_int_equal(stilb_cull_octree_create(&desc, &f->cull->octree), STILB_OK);
	for (uint32_t model = 0; model < f->scene.model_count; model++)
		assert_int_equal(stilb_cull_octree_insert(f->cull->octree, model, scene_get(&f->scene, model)), STILB_OK);
}

static void run_scene(fixture *f, uint64_t seed)
{
	reference_random random = {.seed = seed};
	world kind = (world)(seed % WORLDS);
	f->scene.model_count = random_below(&random, random_below(&random, 2) ? MOST_MODELS : 20);
	for (uint32_t model = 0; model < f->scene.model_count; model++)
		scene_set(&f->scene, model, world_sphere(kind, &random));
	assert_int_equal(stilb_cull_create(&f->scene, &f->cull), STILB_OK);
	if (random_below(&random, 2))
		deepen(f, &random);
	bool parallel = seed % 16 == 0;
	for (int frame = 0; frame < 2; frame++) {
		stilb_frustum view = world_view(kind, &random);
		assert_view(f, &view, parallel);
		move_some(f, kind, &random);
	}
	stilb_cull_destroy(f->cull);
}

static void test_random_scenes(void **state)
{
	(void)state;
	fixture f = {.scene = scene_make(MOST_MODELS)};
	stilb_job_pool_desc desc = {.worker_count = 2};
	assert_int_equal(stilb_job_pool_create(&desc, &f.pool), 0);
	for (uint64_t seed = 0; seed < SCENES; seed++)
		run_scene(&f, seed);
	assert_true(f.seen > f.all / 20 && f.seen < f.all / 2); /* the views see some models and not all */
	stilb_job_pool_destroy(f.pool);
	for (uint32_t v = 0; v < VIEWS; v++)
		stilb_cull_visible_finish(&f.together[v]);
	stilb_cull_visible_finish(&f.visible);
	scene_free(&f.scene);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(test_random_scenes),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
