/* One view's culling: chooses the method and the number of threads, and turns bits into ids in scene order. */
#include "culling/cull_internal.h"
#include "profiler/prof.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#define CULL_CELL_OBJECTS 64u    /* least average number of objects in a cell of a uniform scene */
#define CULL_OCTREE_SHARE 0.25   /* share of visible models up to which the octree is the faster method */
#define CULL_GATHER_GRAIN 16u    /* chunks that one job gathers: some microseconds of work */
#define CULL_EXPAND_GRAIN 8u     /* chunks that one job turns into ids */
#define CULL_EXTENT_LIMIT 0x1p58 /* metres; centres beyond it do not make the root cell larger */
#define CULL_REBUILD_LEAST 1024u /* models that may come, or leave the root cell, before a new octree is made */

/* ---- building ------------------------------------------------------------------------------------------------- */

typedef struct cull_extent {
	double low[3], high[3];
} cull_extent;

static stilb_sphere cull_scene_sphere(const stilb_scene *scene, uint32_t model)
{
	const stilb_scene_bounds *b = &scene->bounds;
	return (stilb_sphere){b->x[model], b->y[model], b->z[model], b->radius[model]};
}

/* The box around all centres with coordinates up to CULL_EXTENT_LIMIT; on an axis without any it is 0..0. */
static cull_extent cull_extent_of(const stilb_scene *scene)
{
	const float *const centers[3] = {scene->bounds.x, scene->bounds.y, scene->bounds.z};
	cull_extent extent = {0};
	for (int axis = 0; axis < 3; axis++) {
		double low = (double)INFINITY, high = -low;
		for (uint32_t model = 0; model < scene->model_count; model++) {
			double value = (double)centers[axis][model];
			if (!(fabs(value) <= CULL_EXTENT_LIMIT))
				continue;
			low = value < low ? value : low;
			high = value > high ? value : high;
		}
		if (low <= high) {
			extent.low[axis] = low;
			extent.high[axis] = high;
		}
	}
	return extent;
}

/* The greatest depth at which cells still hold CULL_CELL_OBJECTS objects, if these fill the box evenly. */
static uint32_t cull_depth_for(const cull_extent *extent, double size, uint32_t model_count)
{
	for (uint32_t depth = 1; depth <= CULL_MAX_DEPTH; depth++) {
		double cells = 1.0;
		for (int axis = 0; axis < 3; axis++)
			cells *= fmax(1.0, (extent->high[axis] - extent->low[axis]) / size * (double)(1u << depth));
		if ((double)model_count < cells * (double)CULL_CELL_OBJECTS)
			return depth - 1;
	}
	return CULL_MAX_DEPTH;
}

stilb_cull_octree_desc cull_desc_for_scene(const stilb_scene *scene)
{
	cull_extent extent = cull_extent_of(scene);
	double size = 1.0; /* metres, the least; and at least 2^11 times the spacing of floats in the scene */
	for (int axis = 0; axis < 3; axis++) {
		size = fmax(size, extent.high[axis] - extent.low[axis]);
		size = fmax(size, 0x1p-12 * fmax(fabs(extent.low[axis]), fabs(extent.high[axis])));
	}
	uint32_t depth = cull_depth_for(&extent, size, scene->model_count);
	/* The root's low corner lies an eighth of a cell below the scene's, so that a flat scene fills one layer of cells.
	 * If root and scene had the same centre, such a scene would lie across two layers, each half as full. */
	double slack = size / (double)(1u << depth) * 0.125;
	double half = size * 0.5 + slack;
	STILB_ASSERT(depth <= CULL_MAX_DEPTH && isfinite(half) && half >= 0.5);
	return (stilb_cull_octree_desc){
		.center = {(float)(extent.low[0] - slack + half), (float)(extent.low[1] - slack + half),
	               (float)(extent.low[2] - slack + half)},
		.half_size = (float)half,
		.max_depth = depth,
	};
}

/* Makes an octree of all models of the scene, and sets the sizes at which the next one is made. On failure nothing has
 * changed. */
static stilb_result cull_build(stilb_cull *cull, const stilb_scene *scene)
{
	stilb_cull_octree_desc desc = cull_desc_for_scene(scene);
	stilb_cull_octree *octree;
	stilb_result result = stilb_cull_octree_create(&desc, &octree);
	for (uint32_t model = 0; result == STILB_OK && model < scene->model_count; model++) {
		stilb_sphere bounds = cull_scene_sphere(scene, model);
		if (!cull_is_absent(bounds))
			result = stilb_cull_octree_insert(octree, model, bounds);
	}
	if (result != STILB_OK) {
		stilb_cull_octree_destroy(octree);
		return result;
	}
	const cull_cell *root = &octree->cells[CULL_ROOT];
	octree->kernels = cull->kernels;
	stilb_cull_octree_destroy(cull->octree);
	cull->octree = octree;
	cull->rebuild_models = 2 * (uint64_t)root->subtree_count + CULL_REBUILD_LEAST;
	cull->rebuild_outside = 2 * (uint64_t)root->count + CULL_REBUILD_LEAST;
	STILB_CHECK(!cull_octree_check(octree));
	return STILB_OK;
}

/* The octree's root and depth suit the scene that it was made for. When the models are more than twice as many, or
 * twice as many lie outside the root, a new one is made, at a cost that is small beside that of the changes. */
static void cull_rebuild(stilb_cull *cull, const stilb_scene *scene)
{
	const cull_cell *root = &cull->octree->cells[CULL_ROOT];
	if (root->subtree_count <= cull->rebuild_models && root->count <= cull->rebuild_outside)
		return;
	PROFILE("cull.rebuild");
	if (cull_build(cull, scene) == STILB_OK)
		return;
	cull->rebuild_models *= 2; /* no memory: the old octree is slower, not wrong */
	cull->rebuild_outside *= 2;
}

stilb_result stilb_cull_create(const stilb_scene *scene, stilb_cull **out)
{
	STILB_ASSERT(scene && out);
	*out = NULL;
	stilb_isa isa;
	stilb_result result = stilb_cpu_isa(&isa);
	if (result != STILB_OK)
		return result;
	stilb_cull *cull = stilb_memory_alloc(1, sizeof *cull);
	if (!cull)
		return stilb_fail(STILB_ERROR_MEMORY, "culling: no memory");
	*cull = (stilb_cull){
		.kernels = cull_kernels_for(isa), .model_count = scene->model_count, .serial_below = CULL_SERIAL_BELOW};
	result = cull_build(cull, scene);
	if (result != STILB_OK) {
		stilb_cull_destroy(cull);
		return result;
	}
	*out = cull;
	return STILB_OK;
}

/* cull_enter and cull_leave stand around a call that no other thread may make at the same time: enter asserts that no
 * other thread is inside. */
static void cull_enter(stilb_cull *cull)
{
	STILB_ASSERT_OWNER(cull->caller);
	stilb_owner_take(&cull->caller);
}

static void cull_leave(stilb_cull *cull)
{
	cull->caller = (stilb_owner){0};
}

void stilb_cull_destroy(stilb_cull *cull)
{
	if (!cull)
		return;
	STILB_ASSERT_OWNER(cull->caller);
	stilb_cull_octree_destroy(cull->octree);
	free(cull);
}

stilb_result stilb_cull_update(stilb_cull *cull, const stilb_scene *scene, const uint32_t *ids, uint32_t count)
{
	stilb_result result = STILB_OK;
	STILB_ASSERT(scene->model_count >= cull->model_count && "models are removed by their bounds, not by the count");
	STILB_ASSERT(ids || count == 0);
	cull_enter(cull);
	for (uint32_t i = 0; result == STILB_OK && i < count; i++) {
		STILB_ASSERT(ids[i] < scene->model_count);
		result = cull_octree_put(cull->octree, ids[i], cull_scene_sphere(scene, ids[i]));
	}
	if (result == STILB_OK) {
		cull->model_count = scene->model_count;
		cull_rebuild(cull, scene);
	}
	STILB_CHECK(!cull_octree_check(cull->octree));
	cull_leave(cull);
	return result;
}

/* ---- the buffers of a view ------------------------------------------------------------------------------------ */

void stilb_cull_visible_finish(stilb_cull_visible *visible)
{
	if (!visible)
		return;
	free(visible->ids);
	free(visible->bits);
	free(visible->chunk_count);
	if (visible->list)
		cull_list_finish(visible->list);
	free(visible->list);
	*visible = (stilb_cull_visible){0};
}

/* Number of chunks of a scene: CULL_CHUNK models each, the last one fewer. */
static uint32_t cull_chunk_total(uint32_t model_count)
{
	return (model_count + CULL_CHUNK - 1) / CULL_CHUNK;
}

/* Words from one thread's set of bits to the next. */
static size_t cull_set_stride(const stilb_cull_visible *visible)
{
	return visible->capacity / 64;
}

static uint32_t cull_greater(uint32_t a, uint32_t b)
{
	return a > b ? a : b;
}

/* Checks what stilb_cull_run leaves: ids ascend and are models, and no bit is set. */
static bool cull_visible_is_sound(const stilb_cull_visible *visible, uint32_t model_count)
{
	bool sound = visible->count <= model_count && visible->capacity % CULL_CHUNK == 0;
	for (uint32_t i = 0; i < visible->count && sound; i++)
		sound = visible->ids[i] < model_count && (i == 0 || visible->ids[i - 1] < visible->ids[i]);
	for (size_t word = 0; word < cull_set_stride(visible) * visible->set_count && sound; word++)
		sound = !visible->bits[word];
	return sound;
}

/* Makes visible large enough for model_count models, with a set of bits for each of so many threads. */
static stilb_result cull_visible_reserve(stilb_cull_visible *visible, uint32_t model_count, uint32_t threads)
{
	STILB_ASSERT(threads > 0 && !visible->ids == (visible->capacity == 0) && "zero-initialised, or of an earlier run");
	if (visible->capacity >= model_count && visible->set_count >= threads)
		return STILB_OK;
	threads = cull_greater(threads, visible->set_count);
	uint32_t chunks = cull_greater(model_count / CULL_CHUNK + 1, visible->capacity / CULL_CHUNK);
	stilb_cull_visible grown = {
		.capacity = chunks * CULL_CHUNK, .set_count = threads, .count = visible->count, .method = visible->method};
	size_t words = cull_set_stride(&grown) * threads;
	grown.ids = stilb_memory_alloc((size_t)grown.capacity + CULL_SLACK, sizeof *grown.ids);
	grown.bits = stilb_memory_alloc(words, sizeof *grown.bits);
	grown.chunk_count = stilb_memory_alloc(chunks, sizeof *grown.chunk_count);
	if (!grown.ids || !grown.bits || !grown.chunk_count) {
		stilb_cull_visible_finish(&grown);
		return stilb_fail(STILB_ERROR_MEMORY, "culling: no memory for the visible list of %u models", model_count);
	}
	memset(grown.bits, 0, words * sizeof *grown.bits);
	stilb_cull_visible outgrown = *visible;
	grown.list = visible->list;
	outgrown.list = NULL;
	*visible = grown;
	stilb_cull_visible_finish(&outgrown);
	return STILB_OK;
}

/* ---- the jobs of a run ---------------------------------------------------------------------------------------- */

/* Shared by the jobs of one run. */
typedef struct cull_run {
	const stilb_cull *cull;
	const stilb_frustum *frustum;
	cull_spheres spheres; /* of the scene */
	stilb_cull_visible *visible;
	stilb_job_pool *pool; /* NULL: the caller alone */
	uint32_t worker;
} cull_run;

/* Number of models in a chunk. */
static uint32_t cull_chunk_size(uint32_t chunk, uint32_t model_count)
{
	STILB_ASSERT(chunk < cull_chunk_total(model_count));
	uint32_t left = model_count - chunk * CULL_CHUNK;
	return left < CULL_CHUNK ? left : CULL_CHUNK;
}

static cull_spheres cull_spheres_from(cull_spheres spheres, uint32_t first)
{
	return (cull_spheres){spheres.x + first, spheres.y + first, spheres.z + first, spheres.radius + first};
}

/* Marks the visible objects of items begin .. end - 1 of the octree. Each thread has its own set of bits: models whose
 * bits share a word lie in many cells, so two threads could otherwise write the same word. */
static void cull_job_items(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	PROFILE("cull.cells");
	const cull_run *run = context;
	STILB_ASSERT(worker < run->visible->set_count);
	const stilb_cull_octree *octree = run->cull->octree;
	uint64_t *bits = run->visible->bits + worker * cull_set_stride(run->visible);
	cull_octree_mark(octree, run->visible->list, begin, end, run->frustum, bits);
}

/* Joins the bits of all threads' sets in the first set, and counts them for each chunk. */
static void cull_job_gather(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	PROFILE("cull.gather");
	(void)worker;
	const cull_run *run = context;
	stilb_cull_visible *visible = run->visible;
	for (uint32_t chunk = begin; chunk < end; chunk++)
		visible->chunk_count[chunk] = run->cull->kernels->gather(
			visible->bits + chunk * CULL_CHUNK_WORDS, cull_set_stride(visible), visible->set_count, CULL_CHUNK_WORDS);
}

/* Tests the models of chunks begin .. end - 1, and counts the visible ones of each chunk. */
static void cull_job_flat(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	PROFILE("cull.spheres");
	(void)worker;
	const cull_run *run = context;
	for (uint32_t chunk = begin; chunk < end; chunk++) {
		uint64_t *bits = run->visible->bits + chunk * CULL_CHUNK_WORDS;
		run->cull->kernels->test(cull_spheres_from(run->spheres, chunk * CULL_CHUNK),
		                         cull_chunk_size(chunk, run->cull->model_count), run->frustum, CULL_ALL_PLANES, bits);
		run->visible->chunk_count[chunk] = run->cull->kernels->gather(bits, 0, 1, CULL_CHUNK_WORDS);
	}
}

/* Turns bits into ids; chunk_count[c] is the position of chunk c's first id. The ids go through the stack, because the
 * kernel writes up to CULL_SLACK beyond the last one, over ids that another thread may have written. */
static void cull_job_expand(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	PROFILE("cull.expand");
	(void)worker;
	const cull_run *run = context;
	stilb_cull_visible *visible = run->visible;
	uint32_t ids[CULL_CHUNK + CULL_SLACK];
	for (uint32_t chunk = begin; chunk < end; chunk++) {
		uint32_t first = chunk * CULL_CHUNK;
		uint32_t count = run->cull->kernels->expand(visible->bits + first / 64, CULL_CHUNK_WORDS, first, ids);
		STILB_ASSERT(visible->chunk_count[chunk] + count <= visible->count);
		memcpy(visible->ids + visible->chunk_count[chunk], ids, count * sizeof *ids);
	}
}

/* ---- the methods ---------------------------------------------------------------------------------------------- */

/* True if testing so many objects is worth waking threads for. */
static bool cull_run_parallel(const cull_run *run, uint64_t objects)
{
	return run->pool && objects >= run->cull->serial_below;
}

static void cull_run_chunks(cull_run *run, uint32_t grain, stilb_job_range_fn *fn)
{
	stilb_job_parallel_for(run->pool, cull_chunk_total(run->cull->model_count), grain, fn, run, run->worker);
}

/* Replaces chunk_count by its exclusive prefix sum, the position of each chunk's first id, and writes the ids. */
static void cull_run_expand(cull_run *run)
{
	stilb_cull_visible *visible = run->visible;
	for (uint32_t chunk = 0; chunk < cull_chunk_total(run->cull->model_count); chunk++) {
		uint32_t count = visible->chunk_count[chunk];
		visible->chunk_count[chunk] = visible->count;
		visible->count += count;
	}
	STILB_ASSERT(visible->count <= run->cull->model_count);
	cull_run_chunks(run, CULL_EXPAND_GRAIN, cull_job_expand);
}

static void cull_run_flat(cull_run *run)
{
	uint32_t model_count = run->cull->model_count;
	if (!cull_run_parallel(run, model_count)) {
		PROFILE("cull.spheres");
		run->visible->count = run->cull->kernels->flat(run->spheres, model_count, run->frustum, run->visible->ids);
		return;
	}
	cull_run_chunks(run, 1, cull_job_flat);
	cull_run_expand(run);
}

/* True if every model of the scene is in the octree and the view holds all of it. */
static bool cull_sees_all(const stilb_cull *cull, const stilb_frustum *frustum)
{
	return cull->octree->cells[CULL_ROOT].subtree_count == cull->model_count &&
	       cull_octree_inside(cull->octree, frustum);
}

static void cull_run_all(cull_run *run)
{
	PROFILE("cull.all");
	run->cull->kernels->all(run->cull->model_count, run->visible->ids);
	run->visible->count = run->cull->model_count;
}

static stilb_result cull_list_make(stilb_cull_visible *visible)
{
	if (!visible->list)
		visible->list = calloc(1, sizeof *visible->list);
	return visible->list ? STILB_OK : stilb_fail(STILB_ERROR_MEMORY, "culling: no memory for a view's list of cells");
}

static stilb_result cull_run_octree(cull_run *run)
{
	stilb_cull_visible *visible = run->visible;
	cull_walk_result walk;
	stilb_result result = cull_list_make(visible);
	if (result == STILB_OK)
		result = cull_octree_walk(run->cull->octree, visible->list, run->frustum, &walk);
	if (result != STILB_OK)
		return result;
	uint32_t objects = walk.tested + walk.accepted;
	STILB_ASSERT(objects <= run->cull->model_count);
	if (!cull_run_parallel(run, 2 * (uint64_t)objects)) {
		cull_job_items(0, walk.item_count, 0, run);
		PROFILE("cull.expand");
		uint32_t lines = (run->cull->model_count + CULL_BITS_OBJECTS - 1) / CULL_BITS_OBJECTS;
		visible->count = run->cull->kernels->expand(visible->bits, lines * CULL_BITS_WORDS, 0, visible->ids);
		return STILB_OK;
	}
	/* One job marks so many items: together they hold about CULL_CHUNK objects. */
	uint32_t grain = (uint32_t)((uint64_t)walk.item_count * CULL_CHUNK / (objects + 1));
	stilb_job_parallel_for(run->pool, walk.item_count, grain, cull_job_items, run, run->worker);
	cull_run_chunks(run, CULL_GATHER_GRAIN, cull_job_gather);
	cull_run_expand(run);
	return STILB_OK;
}

/* The octree's cost grows with the number of visible models, the flat method's does not; above some share flat is
 * faster. The last run's share predicts this one's. Near the threshold both cost the same, so a wrong prediction costs
 * little. */
static stilb_cull_method cull_choose(const stilb_cull *cull, const stilb_cull_visible *visible)
{
	return (double)visible->count > CULL_OCTREE_SHARE * (double)cull->model_count ? STILB_CULL_FLAT : STILB_CULL_OCTREE;
}

static stilb_result cull_run_view(const stilb_cull *cull, stilb_cull_method method, const stilb_scene *scene,
                                  const stilb_frustum *frustum, stilb_job_pool *pool, uint32_t worker,
                                  stilb_cull_visible *visible)
{
	const stilb_scene_bounds *bounds = &scene->bounds;
	cull_run run = {
		.cull = cull,
		.frustum = frustum,
		.spheres = {bounds->x, bounds->y, bounds->z, bounds->radius},
		.visible = visible,
		.pool = pool,
		.worker = worker,
	};
	bool all = method != STILB_CULL_FLAT && cull_sees_all(cull, frustum);
	if (method == STILB_CULL_AUTO)
		method = all ? STILB_CULL_OCTREE : cull_choose(cull, visible);
	visible->count = 0;
	visible->method = method;
	uint32_t threads = pool ? stilb_job_pool_worker_count(pool) + 1 : 1;
	stilb_result result = cull_visible_reserve(visible, cull->model_count, threads);
	if (result == STILB_OK && all)
		cull_run_all(&run);
	else if (result == STILB_OK && method == STILB_CULL_FLAT)
		cull_run_flat(&run);
	else if (result == STILB_OK)
		result = cull_run_octree(&run);
	STILB_CHECK(cull_visible_is_sound(visible, cull->model_count));
	return result;
}

/* Several views of a run, of which each thread takes one after the other. */
typedef struct cull_views {
	const stilb_cull *cull;
	stilb_cull_method method;
	const stilb_scene *scene;
	const stilb_frustum *frusta;
	stilb_cull_visible *visible;
	atomic_bool failed; /* relaxed: read after the loop, which orders it */
} cull_views;

static void cull_job_views(uint32_t begin, uint32_t end, uint32_t worker, void *user)
{
	PROFILE("cull.view");
	cull_views *views = user;
	(void)worker;
	for (uint32_t v = begin; v < end; v++)
		if (cull_run_view(views->cull, views->method, views->scene, &views->frusta[v], NULL, 0, &views->visible[v]) !=
		    STILB_OK)
			atomic_store_explicit(&views->failed, true, memory_order_relaxed);
}

stilb_result stilb_cull_run_views(stilb_cull *cull, stilb_cull_method method, const stilb_scene *scene,
                                  const stilb_frustum *frusta, uint32_t count, stilb_job_pool *pool, uint32_t worker,
                                  stilb_cull_visible *visible)
{
	STILB_ASSERT(scene->model_count == cull->model_count && "new models are told to stilb_cull_update");
	STILB_ASSERT((count == 0 || (frusta && visible)) && (uint32_t)method <= STILB_CULL_FLAT);
	STILB_ASSERT(!pool || worker <= stilb_job_pool_worker_count(pool));
	stilb_result result = STILB_OK;
	uint32_t threads = pool ? stilb_job_pool_worker_count(pool) + 1 : 1;
	bool apart = threads > 1 && count >= threads && (uint64_t)count * cull->model_count >= cull->serial_below;
	cull_enter(cull);
	if (apart) {
		cull_views views = {cull, method, scene, frusta, visible, false};
		stilb_job_parallel_for(pool, count, 1, cull_job_views, &views, worker);
		if (atomic_load_explicit(&views.failed, memory_order_relaxed))
			result = stilb_fail(STILB_ERROR_MEMORY, "culling: no memory for the visible lists of %u views", count);
	} else {
		for (uint32_t v = 0; v < count && result == STILB_OK; v++)
			result = cull_run_view(cull, method, scene, &frusta[v], pool, worker, &visible[v]);
	}
	for (uint32_t v = 0; v < count && result != STILB_OK; v++)
		visible[v].count = 0;
	cull_leave(cull);
	return result;
}

stilb_result stilb_cull_run(stilb_cull *cull, stilb_cull_method method, const stilb_scene *scene,
                            const stilb_frustum *frustum, stilb_job_pool *pool, uint32_t worker,
                            stilb_cull_visible *visible)
{
	STILB_ASSERT(frustum && visible);
	return stilb_cull_run_views(cull, method, scene, frustum, 1, pool, worker, visible);
}
