/* The loose octree (cull.h): which cell an object is stored in, removal, and the walk of a view through the cells. */
#include "support/cull_reference.h"

#define OBJECTS 600u
#define EXTENT 100.0f

/* An octree, and a plain array of the objects that it should hold. */
typedef struct twin_octree {
	stilb_cull_octree *octree;
	stilb_sphere spheres[OBJECTS];
	bool present[OBJECTS];
} twin_octree;

static stilb_cull_octree *octree_make(float center, float half_size, uint32_t max_depth)
{
	stilb_cull_octree_desc desc = {{center, center, center}, half_size, max_depth};
	stilb_cull_octree *octree;
	assert_int_equal(stilb_cull_octree_create(&desc, &octree), STILB_OK);
	return octree;
}

static void assert_octree(const stilb_cull_octree *octree)
{
	const char *wrong = cull_octree_check(octree);
	if (wrong)
		fail_msg("%s", wrong);
}

/* Checks that the tree marks exactly the objects that are visible by a test of each in the plain array, with every
 * instruction set. Returns their number. */
static uint32_t assert_same(twin_octree *twin, const stilb_frustum *frustum)
{
	uint32_t visible = 0;
	for (stilb_isa isa = STILB_ISA_SCALAR; isa <= stilb_cpu_widest_isa(); isa++) {
		uint64_t bits[OBJECTS / 64 + 1] = {0};
		visible = 0;
		twin->octree->kernels = cull_kernels_for(isa);
		assert_int_equal(stilb_cull_octree_mark(twin->octree, frustum, bits), STILB_OK);
		for (uint32_t id = 0; id < OBJECTS; id++) {
			bool expected = twin->present[id] && reference_visible(twin->spheres[id], frustum);
			if (reference_bit(bits, id) != expected)
				fail_msg("object %u with %s: expected %d", id, stilb_isa_text(isa), expected);
			visible += expected;
		}
	}
	return visible;
}

static void twin_insert(twin_octree *twin, uint32_t id, stilb_sphere sphere)
{
	assert_int_equal(stilb_cull_octree_insert(twin->octree, id, sphere), STILB_OK);
	twin->spheres[id] = sphere;
	twin->present[id] = true;
}

static void twin_move(twin_octree *twin, uint32_t id, stilb_sphere sphere)
{
	assert_int_equal(stilb_cull_octree_move(twin->octree, id, sphere), STILB_OK);
	twin->spheres[id] = sphere;
}

static void twin_remove(twin_octree *twin, uint32_t id)
{
	stilb_cull_octree_remove(twin->octree, id);
	twin->present[id] = false;
}

/* A sphere of any size, from a point to larger than the root cell; some lie on corners of cells, and one in sixteen has
 * a NaN or an infinity. */
static stilb_sphere random_sphere(reference_random *random)
{
	uint32_t kind = random_below(random, 16);
	if (kind == 0)
		return random_strange_sphere(random, EXTENT);
	float reach = kind == 1 ? 3.0f * EXTENT : EXTENT;
	stilb_sphere sphere = {random_between(random, -reach, reach), random_between(random, -reach, reach),
	                       random_between(random, -reach, reach), exp2f(random_between(random, -12.0f, 8.0f))};
	if (kind <= 4)
		sphere = (stilb_sphere){rintf(sphere.x / 12.5f) * 12.5f, rintf(sphere.y / 12.5f) * 12.5f,
		                        rintf(sphere.z / 12.5f) * 12.5f, kind == 2 ? 0.0f : 6.25f};
	return sphere;
}

static void test_create_refuses_bad_roots(void **state)
{
	(void)state;
	stilb_cull_octree_desc bad[] = {
		{{0.0f, 0.0f, 0.0f}, 0.0f, 3},     {{0.0f, 0.0f, 0.0f}, -1.0f, 3},      {{0.0f, 0.0f, 0.0f}, (float)NAN, 3},
		{{0.0f, 0.0f, 0.0f}, INFINITY, 3}, {{0.0f, 0.0f, (float)NAN}, 1.0f, 3}, {{0.0f, -INFINITY, 0.0f}, 1.0f, 3},
		{{0.0f, 0x1p61f, 0.0f}, 1.0f, 3},  {{0.0f, 0.0f, 0.0f}, 1.0f, 21},
	};
	for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
		stilb_cull_octree *octree = (stilb_cull_octree *)1;
		assert_int_equal(stilb_cull_octree_create(&bad[i], &octree), STILB_ERROR_ARGUMENT);
		assert_null(octree);
	}
	stilb_cull_octree_destroy(NULL);
}

static void assert_name(const stilb_cull_octree *octree, stilb_sphere bounds, cull_cell_name expected)
{
	cull_cell_name name = cull_octree_name(octree, bounds);
	assert_int_equal(name.depth, expected.depth);
	for (int axis = 0; axis < 3; axis++)
		assert_int_equal(name.position[axis], expected.position[axis]);
}

/* The root reaches from -64 to 64; cells have sides of 128, 64, 32, 16, 8. An object belongs to the smallest cell whose
 * half side is at least its radius. */
static void test_size_and_centre_name_the_cell(void **state)
{
	(void)state;
	stilb_cull_octree *octree = octree_make(0.0f, 64.0f, 4);
	assert_name(octree, (stilb_sphere){1.0f, 9.0f, -1.0f, 0.0f}, (cull_cell_name){4, {8, 9, 7}});
	assert_name(octree, (stilb_sphere){1.0f, 9.0f, -1.0f, 4.0f}, (cull_cell_name){4, {8, 9, 7}});
	assert_name(octree, (stilb_sphere){1.0f, 9.0f, -1.0f, 4.001f}, (cull_cell_name){3, {4, 4, 3}});
	assert_name(octree, (stilb_sphere){1.0f, 17.0f, -1.0f, 8.0f}, (cull_cell_name){3, {4, 5, 3}});
	assert_name(octree, (stilb_sphere){1.0f, -9.0f, 40.0f, 32.0f}, (cull_cell_name){1, {1, 0, 1}});
	assert_name(octree, (stilb_sphere){1.0f, -9.0f, 40.0f, 32.001f}, (cull_cell_name){0});
	/* Low faces belong to a cell, high faces to the next one; the root's high face is outside. */
	assert_name(octree, (stilb_sphere){-64.0f, 0.0f, 8.0f, 1.0f}, (cull_cell_name){4, {0, 8, 9}});
	assert_name(octree, (stilb_sphere){63.999f, 0.0f, 0.0f, 1.0f}, (cull_cell_name){4, {15, 8, 8}});
	stilb_sphere homeless[] = {
		{64.0f, 0.0f, 0.0f, 1.0f},    {0.0f, -64.01f, 0.0f, 1.0f},    {0.0f, 0.0f, 0.0f, 65.0f},
		{0.0f, 0.0f, 0.0f, INFINITY}, {0.0f, 0.0f, 0.0f, (float)NAN}, {0.0f, 0.0f, 0.0f, -1.0f},
		{0.0f, INFINITY, 0.0f, 1.0f}, {0.0f, 0.0f, -INFINITY, 1.0f},  {(float)NAN, 0.0f, 0.0f, 1.0f},
	};
	for (size_t i = 0; i < sizeof homeless / sizeof *homeless; i++)
		assert_name(octree, homeless[i], (cull_cell_name){0});
	stilb_cull_octree_destroy(octree);
}

static void random_operation(twin_octree *twin, reference_random *random)
{
	uint32_t id = random_below(random, OBJECTS);
	stilb_sphere sphere = random_sphere(random);
	if (!twin->present[id])
		twin_insert(twin, id, sphere);
	else if (random_below(random, 4) == 0)
		twin_remove(twin, id);
	else
		twin_move(twin, id, sphere);
}

static void test_random_operations(void **state)
{
	(void)state;
	uint32_t depths[] = {0, 1, 3, 6, 20};
	for (size_t d = 0; d < sizeof depths / sizeof *depths; d++) {
		twin_octree twin = {.octree = octree_make(0.0f, EXTENT, depths[d])};
		reference_random random = {.seed = d};
		uint32_t visible = 0, everything = 0;
		for (int round = 0; round < 100; round++) {
			for (int i = 0; i < 60; i++)
				random_operation(&twin, &random);
			assert_octree(twin.octree);
			stilb_frustum frustum = random_view(&random, EXTENT);
			visible += assert_same(&twin, &frustum);
			everything += twin.octree->cells[CULL_ROOT].subtree_count;
		}
		assert_true(visible > everything / 50 && visible < everything); /* the views saw some objects and not all */
		for (uint32_t id = 0; id < OBJECTS; id++)
			twin_remove(&twin, id);
		assert_octree(twin.octree);
		assert_int_equal(twin.octree->family_count, 1);
		stilb_cull_octree_destroy(twin.octree);
	}
}

static void test_move_within_a_cell_stays_there(void **state)
{
	(void)state;
	twin_octree twin = {.octree = octree_make(0.0f, 64.0f, 4)};
	twin_insert(&twin, 0, (stilb_sphere){1.0f, 1.0f, 1.0f, 1.0f});
	twin_insert(&twin, 1, (stilb_sphere){2.0f, 1.0f, 1.0f, 1.0f});
	cull_place before = twin.octree->places[0];
	uint32_t cells = twin.octree->cell_count;
	/* Moved and grown: its radius is still at most half the cell's side. */
	twin_move(&twin, 0, (stilb_sphere){7.5f, 2.0f, 3.0f, 4.0f});
	assert_memory_equal(&before, &twin.octree->places[0], sizeof before);
	assert_int_equal(twin.octree->cell_count, cells);
	assert_octree(twin.octree);
	/* Only with its new radius the object touches this box: the cell's reach must have grown. */
	float low[3] = {11.0f, -9.0f, -9.0f}, high[3] = {30.0f, 9.0f, 9.0f};
	stilb_frustum frustum = box_view(low, high);
	assert_int_equal(assert_same(&twin, &frustum), 1);
	twin_move(&twin, 0, (stilb_sphere){8.5f, 2.0f, 3.0f, 4.0f});
	assert_int_not_equal(before.cell_plus_one, twin.octree->places[0].cell_plus_one);
	assert_octree(twin.octree);
	stilb_cull_octree_destroy(twin.octree);
}

static void test_removed_objects_are_not_seen(void **state)
{
	(void)state;
	twin_octree twin = {.octree = octree_make(0.0f, 64.0f, 2)};
	float low[3] = {-1e6f, -1e6f, -1e6f}, high[3] = {1e6f, 1e6f, 1e6f};
	stilb_frustum all = box_view(low, high);
	for (uint32_t id = 0; id < 40; id++) /* all in one cell, the last ones in the root */
		twin_insert(&twin, id, (stilb_sphere){1.0f, 1.0f, 1.0f, id < 30 ? 1.0f : 500.0f});
	uint32_t order[] = {0, 29, 28, 5, 39, 30, 31}; /* first, last, new last, from the middle */
	for (uint32_t i = 0; i < 7; i++) {
		assert_int_equal(assert_same(&twin, &all), 40 - i);
		twin_remove(&twin, order[i]);
		assert_octree(twin.octree);
	}
	assert_int_equal(assert_same(&twin, &all), 33);
	twin_insert(&twin, 28, (stilb_sphere){-5.0f, 1.0f, 1.0f, 1.0f}); /* back again, elsewhere */
	assert_int_equal(assert_same(&twin, &all), 34);
	stilb_cull_octree_destroy(twin.octree);
}

static void test_ids_are_checked(void **state)
{
	(void)state;
	stilb_cull_octree *octree = octree_make(0.0f, 64.0f, 4);
	stilb_sphere sphere = {1.0f, 2.0f, 3.0f, 1.0f};
	stilb_cull_octree_remove(octree, 0);
	stilb_cull_octree_remove(octree, UINT32_MAX);
	assert_int_equal(stilb_cull_octree_move(octree, 5, sphere), STILB_ERROR_ARGUMENT);
	assert_int_equal(stilb_cull_octree_move(octree, UINT32_MAX, sphere), STILB_ERROR_ARGUMENT);
	assert_int_equal(stilb_cull_octree_insert(octree, 1u << 31, sphere), STILB_ERROR_ARGUMENT);
	assert_int_equal(stilb_cull_octree_insert(octree, 1000000, sphere), STILB_OK);
	assert_int_equal(stilb_cull_octree_insert(octree, 1000000, sphere), STILB_ERROR_ARGUMENT);
	assert_int_equal(octree->cells[CULL_ROOT].subtree_count, 1);
	stilb_cull_octree_remove(octree, 1000000);
	stilb_cull_octree_remove(octree, 1000000);
	assert_int_equal(stilb_cull_octree_move(octree, 1000000, sphere), STILB_ERROR_ARGUMENT);
	assert_int_equal(octree->cells[CULL_ROOT].subtree_count, 0);
	assert_octree(octree);
	stilb_cull_octree_destroy(octree);
}

/* A small object that moves through a deep tree needs a new path of cells each time: memory must not grow. */
static void test_cells_are_reused(void **state)
{
	(void)state;
	stilb_cull_octree *octree = octree_make(0.0f, EXTENT, 20);
	reference_random random = {.seed = 5};
	assert_int_equal(stilb_cull_octree_insert(octree, 0, (stilb_sphere){0}), STILB_OK);
	for (int i = 0; i < 2000; i++) {
		stilb_sphere sphere = {random_between(&random, -EXTENT, EXTENT), random_between(&random, -EXTENT, EXTENT), 0.0f,
		                       0.0f};
		assert_int_equal(stilb_cull_octree_move(octree, 0, sphere), STILB_OK);
		assert_int_equal(octree->family_count, 21);
	}
	assert_true(octree->cell_count <= 41 * CULL_CHILDREN); /* the old path and the new one */
	assert_octree(octree);
	stilb_cull_octree_destroy(octree);
}

/* ---- what a view makes of the cells ------------------------------------------------------------------------------ */

/* Walks the octree, and checks that the numbers that the walk returns are the sums over the list of work it made. */
static cull_walk_result walk_octree(stilb_cull_octree *octree, const stilb_frustum *frustum)
{
	cull_walk_result walk;
	uint32_t tested = 0, accepted = 0;
	assert_int_equal(cull_octree_walk(octree, &octree->list, frustum, &walk), STILB_OK);
	for (uint32_t i = 0; i < walk.item_count; i++)
		*(octree->list.items[i].planes ? &tested : &accepted) += octree->list.items[i].count;
	assert_int_equal(tested, walk.tested);
	assert_int_equal(accepted, walk.accepted);
	return walk;
}

static void test_cells_are_taken_whole(void **state)
{
	(void)state;
	twin_octree twin = {.octree = octree_make(0.0f, EXTENT, 3)};
	reference_random random = {.seed = 6};
	for (uint32_t id = 0; id < OBJECTS; id++)
		twin_insert(&twin, id,
		            (stilb_sphere){random_between(&random, -EXTENT, EXTENT), random_between(&random, -EXTENT, EXTENT),
		                           random_between(&random, -EXTENT, EXTENT), 1.0f});
	const struct {
		float low, high;
		uint32_t tested_most, accepted_least, seen_most;
	} views[] = {
		{-300.0f, 300.0f, 0, OBJECTS, OBJECTS},    /* a view that sees everything: no object is tested */
		{200.0f, 300.0f, 0, 0, 0},                 /* a view that sees nothing: no object is tested */
		{-300.0f, 1.5f, OBJECTS / 4, 10, OBJECTS}, /* the lower eighth and a layer of cells around it */
	};
	for (size_t v = 0; v < sizeof views / sizeof *views; v++) {
		float low[3] = {views[v].low, views[v].low, views[v].low},
			  high[3] = {views[v].high, views[v].high, views[v].high};
		stilb_frustum frustum = box_view(low, high);
		cull_walk_result walk = walk_octree(twin.octree, &frustum);
		assert_true(walk.tested <= views[v].tested_most);
		assert_true(walk.accepted >= views[v].accepted_least);
		assert_int_equal(cull_octree_inside(twin.octree, &frustum), v == 0);
		assert_true(assert_same(&twin, &frustum) <= views[v].seen_most);
	}
	stilb_cull_octree_destroy(twin.octree);
}

/* A plane that a cell lies wholly inside of is not tested below that cell: items hold only the planes that cut. */
static void test_planes_are_masked(void **state)
{
	(void)state;
	twin_octree twin = {.octree = octree_make(0.0f, 64.0f, 3)};
	reference_random random = {.seed = 7};
	for (uint32_t id = 0; id < OBJECTS; id++)
		twin_insert(&twin, id,
		            (stilb_sphere){random_between(&random, -64.0f, 64.0f), random_between(&random, -64.0f, 64.0f),
		                           random_between(&random, -64.0f, 64.0f), 0.5f});
	float low[3] = {-200.0f, -200.0f, -200.0f}, high[3] = {3.0f, 200.0f, 200.0f}; /* only plane 1 cuts */
	stilb_frustum frustum = box_view(low, high);
	uint32_t cut = 0;
	cull_walk_result walk = walk_octree(twin.octree, &frustum);
	for (uint32_t i = 0; i < walk.item_count; i++) {
		assert_int_equal(twin.octree->list.items[i].planes & ~2u, 0);
		cut += twin.octree->list.items[i].planes;
	}
	assert_true(cut > 0);
	/* Below the root each cell is tested once, against plane 1 alone. */
	assert_true(twin.octree->list.cell_tests > 0);
	assert_true(twin.octree->list.cell_tests <= CULL_CHILDREN * (twin.octree->family_count - 1));
	assert_true(assert_same(&twin, &frustum) > 0);
	stilb_cull_octree_destroy(twin.octree);
}

/* One cell with far more objects than an item holds. */
static void test_crowded_cells_are_split(void **state)
{
	(void)state;
	enum { CROWD = 2 * CULL_CHUNK + 5 };
	stilb_cull_octree *octree = octree_make(0.0f, 64.0f, 2);
	for (uint32_t id = 0; id < CROWD; id++)
		assert_int_equal(stilb_cull_octree_insert(octree, id, (stilb_sphere){(float)id * 0.001f, 1.0f, 1.0f, 0.0f}),
		                 STILB_OK);
	float low[3] = {0.5f, 0.0f, 0.0f}, high[3] = {7.0f, 2.0f, 2.0f};
	stilb_frustum frustum = box_view(low, high);
	cull_walk_result walk = walk_octree(octree, &frustum);
	assert_int_equal(walk.item_count, 3);
	assert_int_equal(walk.tested, CROWD);
	uint64_t *bits = calloc(CROWD / 64 + 1, sizeof *bits);
	assert_non_null(bits);
	assert_int_equal(stilb_cull_octree_mark(octree, &frustum, bits), STILB_OK);
	for (uint32_t id = 0; id < CROWD; id++) {
		stilb_sphere sphere = {(float)id * 0.001f, 1.0f, 1.0f, 0.0f};
		assert_int_equal(reference_bit(bits, id), reference_visible(sphere, &frustum));
	}
	free(bits);
	stilb_cull_octree_destroy(octree);
}

/* ---- rounding ---------------------------------------------------------------------------------------------------- */

/* Planes whose exact distance to a corner of a cell is about 0, with objects of radius 0 or of the cell's reach there:
 * a decision about the cell must agree with the rounded float test of each of its objects. */
static void test_cells_agree_with_rounded_objects(void **state)
{
	(void)state;
	float centers[] = {0.0f, 1000.0f, -123456.0f};
	uint32_t touched = 0;
	for (size_t c = 0; c < sizeof centers / sizeof *centers; c++) {
		twin_octree twin = {.octree = octree_make(centers[c], 64.0f, 3)};
		reference_random random = {.seed = 8 + c};
		for (uint32_t id = 0; id < 512; id++) { /* one object in the low corner of each of the 8 x 8 x 8 cells */
			float corner[3] = {(float)(id & 7), (float)(id >> 3 & 7), (float)(id >> 6)};
			float base = centers[c] - 64.0f;
			twin_insert(&twin, id,
			            (stilb_sphere){base + corner[0] * 16.0f, base + corner[1] * 16.0f, base + corner[2] * 16.0f,
			                           random_below(&random, 2) ? 1.0f : 0.0f});
		}
		for (int round = 0; round < 4000; round++) {
			stilb_vec3 n = stilb_vec3_normalize(stilb_vec3_make(random_between(&random, -1.0f, 1.0f),
			                                                    random_between(&random, -1.0f, 1.0f),
			                                                    random_between(&random, -1.0f, 1.0f)));
			stilb_sphere at = twin.spheres[random_below(&random, 512)];
			float away = at.radius * (float)((int)random_below(&random, 3) - 1);
			float distance = -(((at.x * n[0] + at.y * n[1]) + at.z * n[2]) + away);
			stilb_frustum frustum;
			for (int p = 0; p < 6; p++) /* planes that see everything, but for one below */
				frustum.planes[p] = (stilb_plane){0.0f, 0.0f, 0.0f, 1.0f};
			frustum.planes[random_below(&random, 6)] = (stilb_plane){n[0], n[1], n[2], distance};
			touched += assert_same(&twin, &frustum);
		}
		stilb_cull_octree_destroy(twin.octree);
	}
	assert_true(touched > 0);
}

/* Frustums that no camera makes. */
static void test_strange_planes(void **state)
{
	(void)state;
	float strange[] = {(float)NAN, INFINITY, -INFINITY, 3e38f, -3e38f, 1e30f, 1e-40f, -1e-40f, 0.0f};
	uint32_t kinds = sizeof strange / sizeof *strange;
	twin_octree twin = {.octree = octree_make(0.0f, EXTENT, 3)};
	reference_random random = {.seed = 9};
	for (uint32_t id = 0; id < OBJECTS; id++)
		twin_insert(&twin, id, random_sphere(&random));
	for (int round = 0; round < 2000; round++) {
		stilb_frustum frustum = random_view(&random, EXTENT);
		for (uint32_t changes = 1 + random_below(&random, 4); changes; changes--) {
			float *values = (float *)&frustum.planes[random_below(&random, 6)];
			values[random_below(&random, 4)] = strange[random_below(&random, kinds)];
		}
		assert_same(&twin, &frustum);
	}
	stilb_cull_octree_destroy(twin.octree);
}

/* ---- the octree of a scene ------------------------------------------------------------------------------------- */

static void test_uniform_scenes_fill_their_cells(void **state)
{
	(void)state;
	uint32_t counts[] = {300, 1000, 10000, 50000};
	for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
		reference_random random = {.seed = 10};
		stilb_scene scene = scene_make(counts[i]);
		for (uint32_t model = 0; model < counts[i]; model++)
			scene_set(&scene, model, grid_sphere(&random, model, counts[i]));
		stilb_cull *cull;
		assert_int_equal(stilb_cull_create(&scene, &cull), STILB_OK);
		const stilb_cull_octree *octree = cull->octree;
		assert_octree(octree);
		assert_int_equal(octree->cells[CULL_ROOT].subtree_count, counts[i]);
		assert_int_equal(octree->cells[CULL_ROOT].count, 0);
		uint32_t leaves = 0;
		for (uint32_t cell = 0; cell < octree->cell_count; cell++)
			leaves += octree->cells[cell].count > 0;
		uint32_t mean = counts[i] / leaves;
		assert_true(mean >= 60 && mean <= 256);
		stilb_cull_destroy(cull);
		scene_free(&scene);
	}
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(test_create_refuses_bad_roots),
		cmocka_unit_test(test_size_and_centre_name_the_cell),
		cmocka_unit_test(test_random_operations),
		cmocka_unit_test(test_move_within_a_cell_stays_there),
		cmocka_unit_test(test_removed_objects_are_not_seen),
		cmocka_unit_test(test_ids_are_checked),
		cmocka_unit_test(test_cells_are_reused),
		cmocka_unit_test(test_cells_are_taken_whole),
		cmocka_unit_test(test_planes_are_masked),
		cmocka_unit_test(test_crowded_cells_are_split),
		cmocka_unit_test(test_cells_agree_with_rounded_objects),
		cmocka_unit_test(test_strange_planes),
		cmocka_unit_test(test_uniform_scenes_fill_their_cells),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
