/* The contracts of culling (what its asserts demand of a caller), each broken on purpose; and an octree that is damaged
 * fails its check. */
#include "culling/cull_internal.h"
#include "support/contract.h"
#include "support/test.h"

#include <math.h>
#include <pthread.h>
#include <string.h>

#define MODELS 40u

/* Models on a line, one metre apart. */
typedef struct line {
	float x[MODELS + 1], y[MODELS + 1], z[MODELS + 1], radius[MODELS + 1];
	stilb_scene scene;
	stilb_cull *cull;
	stilb_frustum everything;
} line;

static void line_make(line *l)
{
	*l = (line){.scene = {.model_count = MODELS}};
	l->scene.bounds = (stilb_scene_bounds){.x = l->x, .y = l->y, .z = l->z, .radius = l->radius};
	for (uint32_t m = 0; m < MODELS; m++) {
		l->x[m] = (float)m;
		l->radius[m] = 0.25f;
	}
	for (int p = 0; p < CULL_PLANES; p++)
		l->everything.planes[p] = (stilb_plane){.distance = 1.0f};
	assert_int_equal(stilb_cull_create(&l->scene, &l->cull), STILB_OK);
}

static stilb_result run(line *l, stilb_cull_method method, stilb_cull_visible *visible)
{
	return stilb_cull_run(l->cull, method, &l->scene, &l->everything, NULL, 0, visible);
}

static void *take(void *owner)
{
	stilb_owner_take(owner);
	return NULL;
}

/* Calls stilb_cull_run while the cull is marked as if another thread were inside a call. */
static void run_beside_another_thread(line *l, stilb_cull_visible *visible)
{
	pthread_t thread;
	assert_int_equal(pthread_create(&thread, NULL, take, &l->cull->caller), 0);
	pthread_join(thread, NULL);
	run(l, STILB_CULL_FLAT, visible);
}

static void run_with_another_scene(line *l, stilb_cull_visible *visible)
{
	l->scene.model_count++;
	run(l, STILB_CULL_FLAT, visible);
}

static void runs(void **state)
{
	(void)state;
	line l;
	line_make(&l);
	stilb_cull_visible visible = {0}, garbage = {.capacity = 4096};
	assert_int_equal(run(&l, STILB_CULL_AUTO, &visible), STILB_OK);
	assert_int_equal(visible.count, MODELS);
	contract_breaks("called on the owner's thread", run_beside_another_thread(&l, &visible));
	contract_breaks("new models are told to stilb_cull_update", run_with_another_scene(&l, &visible));
	contract_breaks("method <= STILB_CULL_FLAT", run(&l, (stilb_cull_method)9, &visible));
	contract_breaks("frustum && visible", run(&l, STILB_CULL_FLAT, NULL));
	contract_breaks("zero-initialised", run(&l, STILB_CULL_FLAT, &garbage));
	contract_breaks("ids[i] < scene->model_count", stilb_cull_update(l.cull, &l.scene, (uint32_t[]){MODELS}, 1));
	contract_breaks("ids || count == 0", stilb_cull_update(l.cull, &l.scene, NULL, 1));
	visible.bits[0] = 2; /* a bit that is set between runs, which none may be */
	contract_breaks("cull_visible_is_sound", run(&l, STILB_CULL_FLAT, &visible));
	stilb_cull_visible_finish(&visible);
	stilb_cull_destroy(l.cull);
}

/* Moves model 0 to where it is: a call that ends with a check of the octree. */
static void move_nothing(line *l)
{
	stilb_cull_update(l->cull, &l->scene, (uint32_t[]){0}, 1);
}

static void damage_count(line *l)
{
	l->cull->octree->cells[CULL_ROOT].subtree_count++;
	move_nothing(l);
}

static void damage_reach(line *l)
{
	l->cull->octree->reach[CULL_ROOT] = -1.0f;
	move_nothing(l);
}

static void damage_place(line *l)
{
	l->cull->octree->places[1] = l->cull->octree->places[2];
	move_nothing(l);
}

static void damage_free_list(line *l)
{
	l->cull->octree->family_count++;
	move_nothing(l);
}

static void octrees(void **state)
{
	(void)state;
	line l;
	line_make(&l);
	move_nothing(&l);
	contract_breaks("cull_octree_check(cull->octree)", damage_count(&l));
	contract_breaks("cull_octree_check(cull->octree)", damage_reach(&l));
	contract_breaks("cull_octree_check(cull->octree)", damage_place(&l));
	contract_breaks("cull_octree_check(cull->octree)", damage_free_list(&l));
	stilb_cull_octree *octree = l.cull->octree;
	octree->max_depth = 3;
	contract_breaks("depth <= octree->max_depth", cull_octree_cell_size(octree, 4));
	double center[3];
	cull_cell_name outside = {.depth = 1, .position = {2, 0, 0}};
	contract_breaks(">> name.depth == 0", cull_octree_cell_center(octree, outside, center));
	contract_breaks("begin <= end", cull_octree_mark(octree, &octree->list, 2, 1, &l.everything, NULL));
	contract_breaks("count <= capacity", cull_grow(NULL, 2, 1, 4));
	stilb_cull_octree *out;
	contract_breaks("desc && out", stilb_cull_octree_create(NULL, &out));
	stilb_cull_destroy(l.cull);
}

static void kernels(void **state)
{
	(void)state;
	line l;
	line_make(&l);
	cull_spheres spheres = {l.x, l.y, l.z, l.radius};
	uint64_t bits[CULL_BITS_WORDS] = {0};
	uint32_t ids[CULL_BITS_OBJECTS + CULL_SLACK];
	for (uint32_t isa = 0; isa <= (uint32_t)stilb_cpu_widest_isa(); isa++) {
		const cull_kernels *table = cull_kernels_for((stilb_isa)isa);
		contract_breaks("count > 0", table->test(spheres, 0, &l.everything, CULL_ALL_PLANES, bits));
		contract_breaks("planes", table->test(spheres, MODELS, &l.everything, 0, bits));
		contract_breaks("words %", table->gather(bits, 0, 1, 3));
		contract_breaks("words %", table->expand(bits, 3, 0, ids));
	}
	contract_breaks("this CPU has it", cull_kernels_for(STILB_ISA_COUNT));
	stilb_cull_destroy(l.cull);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(runs),
		cmocka_unit_test(octrees),
		cmocka_unit_test(kernels),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
