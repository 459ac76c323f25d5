/* A scene whose models come and go: 100,000 random edits, told to the octree in lists of 1 to 160. After each list
 * every method, with every instruction set, on one thread and on several, sees what a plain loop sees. */
#include "support/cull_reference.h"

#define EDITS (TEST_ASAN ? 40000u : 100000u)
#define MOST_MODELS 6000u
#define MOST_EDITS 160u /* in a frame */

typedef struct world {
	reference_random random;
	stilb_scene scene;
	stilb_cull *cull;
	stilb_cull_visible visible;
	stilb_job_pool *pool;
	float extent;                   /* metres; grows, so that models leave the root cell of the first octree */
	float radius[MOST_MODELS];      /* of models that are shown or hidden; NaN: removed */
	uint32_t changed[MOST_EDITS];   /* [count] */
	uint32_t expected[MOST_MODELS]; /* [expected_count] */
	uint32_t count, expected_count, rebuilt;
	uint32_t added, removed, hidden, shown, moved;
} world;

static void place(world *w, uint32_t model)
{
	reference_random *random = &w->random;
	bool strange = random_below(random, 200) == 0;
	stilb_sphere sphere = {random_between(random, -w->extent, w->extent), random_between(random, -3.0f, 3.0f),
	                       random_between(random, -w->extent, w->extent), exp2f(random_between(random, -4.0f, 4.0f))};
	scene_set(&w->scene, model, strange ? random_strange_sphere(random, w->extent) : sphere);
	w->radius[model] = w->scene.bounds.radius[model];
}

/* A model that is not removed is moved, hidden, shown or removed; a removed one is added again, and sometimes a model
 * with a new id is. */
static void edit(world *w)
{
	uint32_t count = w->scene.model_count, kind = random_below(&w->random, 16);
	uint32_t model = count > 0 ? random_below(&w->random, count) : 0;
	float *radius = &w->scene.bounds.radius[model];
	if (count == 0 || (kind < 3 && count < MOST_MODELS)) {
		model = w->scene.model_count++;
		place(w, model);
		w->added++;
	} else if (isnan(w->radius[model])) {
		place(w, model);
		w->added++;
	} else if (kind < 5) {
		w->radius[model] = *radius = (float)NAN;
		w->removed++;
	} else if (kind < 9) {
		bool hide = !isnan(*radius);
		*radius = hide ? (float)NAN : w->radius[model];
		w->hidden += hide;
		w->shown += !hide;
	} else {
		place(w, model);
		w->moved++;
	}
	w->changed[w->count++] = model;
}

static void expect(world *w, const stilb_frustum *view)
{
	w->expected_count = 0;
	for (uint32_t model = 0; model < w->scene.model_count; model++)
		if (reference_visible(scene_get(&w->scene, model), view))
			w->expected[w->expected_count++] = model;
}

static void assert_view(world *w, const stilb_frustum *view, bool parallel)
{
	expect(w, view);
	w->cull->serial_below = parallel ? 0 : CULL_SERIAL_BELOW;
	for (stilb_isa isa = STILB_ISA_SCALAR; isa <= stilb_cpu_widest_isa(); isa++) {
		w->cull->kernels = w->cull->octree->kernels = cull_kernels_for(isa);
		for (stilb_cull_method method = STILB_CULL_AUTO; method <= STILB_CULL_FLAT; method++) {
			stilb_job_pool *pool = parallel ? w->pool : NULL;
			assert_int_equal(stilb_cull_run(w->cull, method, &w->scene, view, pool, 0, &w->visible), STILB_OK);
			assert_int_equal(w->visible.count, w->expected_count);
			assert_memory_equal(w->visible.ids, w->expected, w->expected_count * sizeof *w->expected);
		}
	}
}

/* Tells the edits of a frame to the octree and looks from a random camera and from one that sees everything. */
static void frame(world *w, uint32_t number)
{
	const stilb_cull_octree *before = w->cull->octree;
	float far = 1e9f;
	stilb_frustum near = random_view(&w->random, w->extent),
				  all = box_view((float[]){-far, -far, -far}, (float[]){far, far, far});
	assert_int_equal(stilb_cull_update(w->cull, &w->scene, w->changed, w->count), STILB_OK);
	w->rebuilt += w->cull->octree != before;
	w->count = 0;
	assert_view(w, &near, number % 16 == 0);
	if (number % 4 == 0)
		assert_view(w, &all, false);
	if (number % 64 == 0)
		assert_null(cull_octree_check(w->cull->octree));
}

static void world_make(world *w)
{
	stilb_job_pool_desc desc = {.worker_count = 2};
	*w = (world){.random = {.seed = 18}, .scene = scene_make(MOST_MODELS), .extent = 5.0f};
	w->scene.model_count = 0;
	assert_int_equal(stilb_job_pool_create(&desc, &w->pool), 0);
	assert_int_equal(stilb_cull_create(&w->scene, &w->cull), STILB_OK);
}

static void world_finish(world *w)
{
	stilb_job_pool_destroy(w->pool);
	stilb_cull_visible_finish(&w->visible);
	stilb_cull_destroy(w->cull);
	scene_free(&w->scene);
}

static void test_random_edits(void **state)
{
	(void)state;
	static world w;
	world_make(&w);
	uint32_t edits = 0, number = 0;
	for (; edits < EDITS; number++) {
		for (uint32_t left = 1 + random_below(&w.random, MOST_EDITS - 1); left > 0; left--, edits++)
			edit(&w);
		frame(&w, number);
		w.extent *= 1.003f;
	}
	assert_true(w.rebuilt >= 2 && w.rebuilt < 16); /* the scene outgrows its octree, and rarely */
	assert_true(w.added > EDITS / 8 && w.removed > EDITS / 20 && w.hidden > EDITS / 20 && w.shown > EDITS / 40 &&
	            w.moved > EDITS / 5);
	world_finish(&w);
}

/* Models that are all seen by a view that holds the octree: hidden ones are left out, and come back. */
#define LINE 1000u

static void test_hidden_among_all(void **state)
{
	(void)state;
	static world w;
	world_make(&w);
	stilb_frustum all = box_view((float[]){-100.0f, -100.0f, -100.0f}, (float[]){100.0f, 100.0f, 100.0f});
	for (uint32_t model = 0; model < LINE; model++)
		scene_set(&w.scene, model, (stilb_sphere){(float)model * 0.05f - 25.0f, 0.0f, 0.0f, 0.25f});
	w.scene.model_count = LINE;
	stilb_cull_destroy(w.cull);
	assert_int_equal(stilb_cull_create(&w.scene, &w.cull), STILB_OK);
	assert_true(cull_octree_inside(w.cull->octree, &all));
	assert_view(&w, &all, false);
	assert_int_equal(w.visible.count, LINE);
	w.scene.bounds.radius[7] = (float)NAN;
	assert_int_equal(stilb_cull_update(w.cull, &w.scene, (uint32_t[]){7, 7}, 2), STILB_OK);
	assert_view(&w, &all, false);
	assert_int_equal(w.visible.count, LINE - 1);
	stilb_cull_destroy(w.cull); /* one that never had the model */
	assert_int_equal(stilb_cull_create(&w.scene, &w.cull), STILB_OK);
	assert_int_equal(w.cull->octree->cells[CULL_ROOT].subtree_count, LINE - 1);
	assert_view(&w, &all, false);
	w.scene.bounds.radius[7] = 0.25f;
	assert_int_equal(stilb_cull_update(w.cull, &w.scene, (uint32_t[]){7}, 1), STILB_OK);
	assert_view(&w, &all, false);
	assert_int_equal(w.visible.count, LINE);
	world_finish(&w);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(test_random_edits),
		cmocka_unit_test(test_hidden_among_all),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
