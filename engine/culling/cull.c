/* One view's culling: mark a byte a model, then turn the bytes into ids in scene order. */
#include "culling/cull.h"
#include "culling/cull_internal.h"
#include "profiler/prof.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define CULL_CELL_OBJECTS 64u    /* fewest objects a cell of a uniform scene holds on average */
#define CULL_COMPACT_GRAIN 4u    /* chunks a job counts or compacts */
#define CULL_EXTENT_LIMIT 0x1p58 /* metres; centres farther out do not shape the root */

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "cull_compact_chunk reads flags eight at a time");

/* ---- building ------------------------------------------------------------------------------------------------- */

typedef struct cull_extent {
	double low[3], high[3];
} cull_extent;

static stilb_sphere cull_scene_sphere(const stilb_scene *scene, uint32_t model)
{
	const stilb_scene_bounds *b = &scene->bounds;
	return (stilb_sphere){b->x[model], b->y[model], b->z[model], b->radius[model]};
}

/* The box around all centres within reason; around the origin when there is none. */
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

/* The deepest level at which cells still hold CULL_CELL_OBJECTS objects, if these fill their box evenly. */
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
	double size = 1.0; /* metres, at least; and far more than the spacing of floats where the scene lies */
	for (int axis = 0; axis < 3; axis++) {
		size = fmax(size, extent.high[axis] - extent.low[axis]);
		size = fmax(size, 0x1p-12 * fmax(fabs(extent.low[axis]), fabs(extent.high[axis])));
	}
	uint32_t depth = cull_depth_for(&extent, size, scene->model_count);
	/* The low corner of the root lies an eighth of a cell below that of the scene: a flat scene then fills one layer of
	 * cells. With the scene's middle at the root's it would lie across two layers, each half as full. */
	double slack = size / (double)(1u << depth) * 0.125;
	double half = size * 0.5 + slack;
	return (stilb_cull_octree_desc){
		.center = {(float)(extent.low[0] - slack + half), (float)(extent.low[1] - slack + half),
	               (float)(extent.low[2] - slack + half)},
		.half_size = (float)half,
		.max_depth = depth,
	};
}

stilb_result stilb_cull_create(const stilb_scene *scene, stilb_cull **out)
{
	*out = NULL;
	stilb_cull *cull = stilb_memory_alloc(1, sizeof *cull);
	if (!cull)
		return stilb_fail(STILB_ERROR_MEMORY, "culling: no memory");
	*cull = (stilb_cull){.model_count = scene->model_count, .serial_below = CULL_SERIAL_BELOW};
	stilb_cull_octree_desc desc = cull_desc_for_scene(scene);
	stilb_result result = stilb_cull_octree_create(&desc, &cull->octree);
	for (uint32_t model = 0; result == STILB_OK && model < scene->model_count; model++)
		result = stilb_cull_octree_insert(cull->octree, model, cull_scene_sphere(scene, model));
	if (result != STILB_OK) {
		stilb_cull_destroy(cull);
		return result;
	}
	*out = cull;
	return STILB_OK;
}

void stilb_cull_destroy(stilb_cull *cull)
{
	if (!cull)
		return;
	stilb_cull_octree_destroy(cull->octree);
	free(cull);
}

stilb_result stilb_cull_move(stilb_cull *cull, const stilb_scene *scene, const uint32_t *ids, uint32_t count)
{
	stilb_result result = STILB_OK;
	for (uint32_t i = 0; result == STILB_OK && i < count; i++) {
		STILB_ASSERT(ids[i] < cull->model_count);
		result = stilb_cull_octree_move(cull->octree, ids[i], cull_scene_sphere(scene, ids[i]));
	}
	return result;
}

/* ---- the buffers of a view ------------------------------------------------------------------------------------ */

void stilb_cull_visible_finish(stilb_cull_visible *visible)
{
	if (!visible)
		return;
	free(visible->ids);
	free(visible->flags);
	free(visible->chunk_count);
	*visible = (stilb_cull_visible){0};
}

/* Whole chunks, so that flags can be read eight at a time up to the end. */
static stilb_result cull_visible_reserve(stilb_cull_visible *visible, uint32_t model_count)
{
	if (visible->capacity >= model_count && visible->flags)
		return STILB_OK;
	uint32_t chunks = model_count / CULL_CHUNK + 1;
	stilb_cull_visible grown = {.capacity = chunks * CULL_CHUNK};
	grown.ids = stilb_memory_alloc(grown.capacity, sizeof *grown.ids);
	grown.flags = stilb_memory_alloc(grown.capacity, sizeof *grown.flags);
	grown.chunk_count = stilb_memory_alloc(chunks, sizeof *grown.chunk_count);
	if (!grown.ids || !grown.flags || !grown.chunk_count) {
		stilb_cull_visible_finish(&grown);
		return stilb_fail(STILB_ERROR_MEMORY, "culling: no memory for the visible list of %u models", model_count);
	}
	memset(grown.flags, 0, grown.capacity);
	stilb_cull_visible_finish(visible);
	*visible = grown;
	return STILB_OK;
}

/* ---- marking and compacting ----------------------------------------------------------------------------------- */

/* What the jobs of one run share. */
typedef struct cull_run {
	const stilb_cull *cull;
	const stilb_scene *scene;
	const stilb_frustum *frustum;
	stilb_cull_visible *visible;
	stilb_job_pool *pool;
	uint32_t worker;
} cull_run;

/* Worth waking threads for? */
static bool cull_run_parallel(const cull_run *run, uint32_t objects)
{
	return run->pool && objects >= run->cull->serial_below;
}

/* fn over [0, count): on the caller alone when that means few objects, else on the pool. */
static void cull_run_for(cull_run *run, uint32_t objects, uint32_t count, uint32_t grain, stilb_job_range_fn *fn)
{
	if (cull_run_parallel(run, objects))
		stilb_job_parallel_for(run->pool, count, grain, fn, run, run->worker);
	else
		fn(0, count, run->worker, run);
}

static uint32_t cull_chunk_total(uint32_t model_count)
{
	return (model_count + CULL_CHUNK - 1) / CULL_CHUNK;
}

static uint32_t cull_chunk_size(uint32_t chunk, uint32_t model_count)
{
	uint32_t left = model_count - chunk * CULL_CHUNK;
	return left < CULL_CHUNK ? left : CULL_CHUNK;
}

/* Items begin .. end - 1 of the octree. Other threads store to other bytes of flags: every object is in one cell. */
static void cull_job_items(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	PROFILE("cull.cells");
	(void)worker;
	const cull_run *run = context;
	const stilb_cull_octree *octree = run->cull->octree;
	for (uint32_t i = begin; i < end; i++)
		cull_octree_mark(octree, &octree->items[i], run->frustum, run->visible->flags);
}

static void cull_job_flat(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	PROFILE("cull.spheres");
	(void)worker;
	const cull_run *run = context;
	const stilb_scene_bounds *bounds = &run->scene->bounds;
	for (uint32_t chunk = begin; chunk < end; chunk++) {
		uint32_t first = chunk * CULL_CHUNK;
		cull_spheres spheres = {bounds->x + first, bounds->y + first, bounds->z + first, bounds->radius + first};
		cull_test_spheres(spheres, cull_chunk_size(chunk, run->cull->model_count), run->frustum, CULL_PLANES,
		                  run->visible->flags + first);
	}
}

static void cull_job_count(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	PROFILE("cull.count");
	(void)worker;
	const cull_run *run = context;
	for (uint32_t chunk = begin; chunk < end; chunk++) {
		const uint8_t *flags = run->visible->flags + chunk * CULL_CHUNK;
		uint32_t count = 0;
		for (uint32_t i = 0; i < CULL_CHUNK; i++)
			count += flags[i];
		run->visible->chunk_count[chunk] = count;
	}
}

/* Appends the ids of a chunk's flags at ids, clears the flags and returns how many there were. Writes no id beyond, as
 * that is another thread's place. */
static uint32_t cull_compact_chunk(uint8_t *flags, uint32_t first_id, uint32_t *ids)
{
	uint32_t count = 0;
	for (uint32_t i = 0; i < CULL_CHUNK; i += 8) {
		uint64_t word;
		memcpy(&word, flags + i, sizeof word);
		if (word == 0x0101010101010101u) {
			for (uint32_t k = 0; k < 8; k++)
				ids[count + k] = first_id + i + k;
			count += 8;
			continue;
		}
		for (; word; word &= word - 1)
			ids[count++] = first_id + i + ((uint32_t)__builtin_ctzll(word) >> 3);
	}
	memset(flags, 0, CULL_CHUNK);
	return count;
}

/* chunk_count holds where each chunk's ids begin. */
static void cull_job_compact(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	PROFILE("cull.compact");
	(void)worker;
	const cull_run *run = context;
	stilb_cull_visible *visible = run->visible;
	for (uint32_t chunk = begin; chunk < end; chunk++) {
		uint32_t first = chunk * CULL_CHUNK;
		cull_compact_chunk(visible->flags + first, first, visible->ids + visible->chunk_count[chunk]);
	}
}

/* Marks what is visible; candidates gets a bound on how much that can be. */
static stilb_result cull_run_mark(cull_run *run, stilb_cull_method method, uint32_t *candidates)
{
	const stilb_cull *cull = run->cull;
	if (method == STILB_CULL_FLAT) {
		*candidates = cull->model_count;
		cull_run_for(run, *candidates, cull_chunk_total(cull->model_count), 1, cull_job_flat);
		return STILB_OK;
	}
	uint32_t items;
	stilb_result result = cull_octree_collect(cull->octree, run->frustum, &items, candidates);
	if (result != STILB_OK)
		return result;
	/* A slice of items with about a chunk of objects. */
	uint32_t grain = *candidates > CULL_CHUNK ? (uint32_t)((uint64_t)items * CULL_CHUNK / *candidates) : items;
	cull_run_for(run, *candidates, items, grain, cull_job_items);
	return STILB_OK;
}

static void cull_compact_serial(stilb_cull_visible *visible, uint32_t chunks)
{
	PROFILE("cull.compact");
	for (uint32_t chunk = 0; chunk < chunks; chunk++) {
		uint32_t first = chunk * CULL_CHUNK;
		visible->count += cull_compact_chunk(visible->flags + first, first, visible->ids + visible->count);
	}
}

/* Threads must know where their ids begin: first a count per chunk and its prefix sum, then the ids. */
static void cull_compact_parallel(cull_run *run, uint32_t chunks)
{
	stilb_cull_visible *visible = run->visible;
	stilb_job_parallel_for(run->pool, chunks, CULL_COMPACT_GRAIN, cull_job_count, run, run->worker);
	for (uint32_t chunk = 0; chunk < chunks; chunk++) {
		uint32_t count = visible->chunk_count[chunk];
		visible->chunk_count[chunk] = visible->count;
		visible->count += count;
	}
	stilb_job_parallel_for(run->pool, chunks, CULL_COMPACT_GRAIN, cull_job_compact, run, run->worker);
}

stilb_result stilb_cull_run(stilb_cull *cull, stilb_cull_method method, const stilb_scene *scene,
                            const stilb_frustum *frustum, stilb_job_pool *pool, uint32_t worker,
                            stilb_cull_visible *visible)
{
	STILB_ASSERT(scene->model_count == cull->model_count);
	cull_run run = {cull, scene, frustum, visible, pool, worker};
	uint32_t candidates = 0;
	visible->count = 0;
	stilb_result result = cull_visible_reserve(visible, cull->model_count);
	if (result == STILB_OK)
		result = cull_run_mark(&run, method, &candidates);
	if (result != STILB_OK)
		return result;
	/* Passing over a flag that is 0 costs about a sixteenth of writing an id. */
	uint32_t work = candidates > cull->model_count / 16 ? candidates : cull->model_count / 16;
	uint32_t chunks = cull_chunk_total(cull->model_count);
	if (cull_run_parallel(&run, work))
		cull_compact_parallel(&run, chunks);
	else
		cull_compact_serial(visible, chunks);
	return STILB_OK;
}
