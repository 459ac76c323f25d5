/* Rounds of simplification: the mesh is cut into regions by space, each of which is simplified alone, with what it
 * shares with others kept; in the next round the cuts lie elsewhere. */
#include "geometry/geometry_internal.h"

#include <float.h>
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#define REGION 8192u     /* triangles of a region, at most */
#define VALUE_LIMIT 0.01 /* edges^2: the most that a vertex's values may cost */
#define KEY_SHIFT 8      /* bits of a Z-order key that are left out: two passes of sorting instead of three */
#define PILOTS 8u        /* one region of this many tells what the others should pay at most */

/* ---- checking and measuring -------------------------------------------------------------------------------------- */

stilb_result geometry_mesh_check(const stilb_geometry_mesh *mesh)
{
	if (mesh->index_count % 3 != 0)
		return stilb_fail(STILB_ERROR_ARGUMENT, "a mesh has %u indices, which is no multiple of 3", mesh->index_count);
	if (mesh->stream_count > STILB_GEOMETRY_STREAMS)
		return stilb_fail(STILB_ERROR_ARGUMENT, "a mesh has %u streams, more than %d", mesh->stream_count,
		                  STILB_GEOMETRY_STREAMS);
	for (uint32_t s = 0; s < mesh->stream_count; s++) {
		const stilb_geometry_stream *stream = &mesh->streams[s];
		if (stream->components < 1 || stream->components > 4 || !(stream->weight >= 0.0f && stream->weight < 1e6f) ||
		    stream->kind >= STILB_GEOMETRY_KINDS)
			return stilb_fail(STILB_ERROR_ARGUMENT, "stream '%s' has %u components, weight %g and kind %d",
			                  stream->name, stream->components, (double)stream->weight, (int)stream->kind);
	}
	for (uint32_t i = 0; i < mesh->index_count; i++)
		if (mesh->indices[i] >= mesh->vertex_count)
			return stilb_fail(STILB_ERROR_ARGUMENT, "index %u of a mesh is %u, and it has %u vertices", i,
			                  mesh->indices[i], mesh->vertex_count);
	return STILB_OK;
}

/* The part of a mesh between two of its triangles, as numbers that are added up in order. */
typedef struct work_sums {
	float lower[3], upper[3];
	double area, texture[STILB_GEOMETRY_STREAMS];
	uint32_t count; /* triangles that are to be simplified */
} work_sums;

#define SUM_GRAIN 32768u

typedef struct work_sum_context {
	geometry_work *work;
	work_sums *sums; /* one for each SUM_GRAIN triangles */
} work_sum_context;

bool geometry_work_is_sound(const geometry_work *work, const uint32_t vertex[3])
{
	uint32_t a = work->canonical[vertex[0]], b = work->canonical[vertex[1]], c = work->canonical[vertex[2]];
	if (a == b || b == c || a == c)
		return false;
	for (int k = 0; k < 3; k++) {
		const float *p = geometry_position(work->mesh, vertex[k]);
		if (!(fabsf(p[0]) < 1e18f && fabsf(p[1]) < 1e18f && fabsf(p[2]) < 1e18f))
			return false;
	}
	return true;
}

static double texture_area(const stilb_geometry_stream *stream, const uint32_t vertex[3])
{
	const float *uv[3];
	for (int k = 0; k < 3; k++)
		uv[k] = (const float *)((const char *)stream->values + vertex[k] * stream->stride);
	double area = 0.5 * fabs((double)(uv[1][0] - uv[0][0]) * (double)(uv[2][1] - uv[0][1]) -
	                         (double)(uv[1][1] - uv[0][1]) * (double)(uv[2][0] - uv[0][0]));
	return isfinite(area) ? area : 0.0;
}

static void sum_triangle(const geometry_work *work, const uint32_t vertex[3], work_sums *sums)
{
	double e[2][3];
	for (int k = 0; k < 3; k++) {
		const float *p = geometry_position(work->mesh, vertex[k]);
		for (int axis = 0; axis < 3; axis++) {
			sums->lower[axis] = p[axis] < sums->lower[axis] ? p[axis] : sums->lower[axis];
			sums->upper[axis] = p[axis] > sums->upper[axis] ? p[axis] : sums->upper[axis];
			if (k > 0)
				e[k - 1][axis] = (double)p[axis] - (double)geometry_position(work->mesh, vertex[0])[axis];
		}
	}
	double x = e[0][1] * e[1][2] - e[0][2] * e[1][1], y = e[0][2] * e[1][0] - e[0][0] * e[1][2],
		   z = e[0][0] * e[1][1] - e[0][1] * e[1][0];
	sums->area += 0.5 * sqrt(x * x + y * y + z * z);
	for (uint32_t s = 0; s < work->mesh->stream_count; s++)
		if (work->mesh->streams[s].kind == STILB_GEOMETRY_TEXTURE && work->mesh->streams[s].components >= 2)
			sums->texture[s] += texture_area(&work->mesh->streams[s], vertex);
}

static void sum_chunks(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	const work_sum_context *c = context;
	uint32_t total = c->work->mesh->index_count / 3;
	for (uint32_t chunk = begin; chunk < end; chunk++) {
		work_sums sums = {.lower = {FLT_MAX, FLT_MAX, FLT_MAX}, .upper = {-FLT_MAX, -FLT_MAX, -FLT_MAX}};
		uint32_t last = total - chunk * SUM_GRAIN < SUM_GRAIN ? total : (chunk + 1) * SUM_GRAIN;
		for (uint32_t t = chunk * SUM_GRAIN; t < last; t++) {
			const uint32_t *vertex = &c->work->mesh->indices[3 * (size_t)t];
			if (!geometry_work_is_sound(c->work, vertex))
				continue;
			sums.count++;
			sum_triangle(c->work, vertex, &sums);
		}
		c->sums[chunk] = sums;
	}
}

/* Copies the sound triangles of chunks, each to its place. */
static void copy_chunks(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	const work_sum_context *c = context;
	uint32_t total = c->work->mesh->index_count / 3;
	for (uint32_t chunk = begin; chunk < end; chunk++) {
		uint32_t last = total - chunk * SUM_GRAIN < SUM_GRAIN ? total : (chunk + 1) * SUM_GRAIN,
				 to = c->sums[chunk].count;
		for (uint32_t t = chunk * SUM_GRAIN; t < last; t++) {
			const uint32_t *vertex = &c->work->mesh->indices[3 * (size_t)t];
			if (geometry_work_is_sound(c->work, vertex))
				memcpy(c->work->triangles[to++], vertex, sizeof *c->work->triangles);
		}
	}
}

static bool work_measure(geometry_work *work)
{
	uint32_t total = work->mesh->index_count / 3, chunks = total / SUM_GRAIN + (total % SUM_GRAIN != 0);
	work_sum_context c = {.work = work, .sums = stilb_memory_alloc(chunks, sizeof *c.sums)};
	if (!c.sums)
		return false;
	geometry_for(work->pool, work->worker, chunks, 1, sum_chunks, &c);
	float upper[3] = {-FLT_MAX, -FLT_MAX, -FLT_MAX};
	double texture[STILB_GEOMETRY_STREAMS] = {0};
	for (int axis = 0; axis < 3; axis++)
		work->lower[axis] = FLT_MAX;
	for (uint32_t i = 0; i < chunks; i++) {
		for (int axis = 0; axis < 3; axis++) {
			work->lower[axis] = fminf(work->lower[axis], c.sums[i].lower[axis]);
			upper[axis] = fmaxf(upper[axis], c.sums[i].upper[axis]);
		}
		work->area += c.sums[i].area;
		for (uint32_t s = 0; s < work->mesh->stream_count; s++)
			texture[s] += c.sums[i].texture[s];
		uint32_t count = c.sums[i].count;
		c.sums[i].count = work->count;
		work->count += count;
	}
	for (int axis = 0; axis < 3 && work->count > 0; axis++)
		work->extent = fmaxf(work->extent, upper[axis] - work->lower[axis]);
	for (uint32_t s = 0; s < work->mesh->stream_count; s++)
		work->texture_density[s] = work->area > 0.0 ? sqrt(texture[s] / work->area) : 0.0;
	geometry_for(work->pool, work->worker, chunks, 1, copy_chunks, &c);
	free(c.sums);
	return true;
}

static void copy_locks(geometry_work *work)
{
	for (uint32_t v = 0; v < work->mesh->vertex_count; v++)
		if (work->mesh->locked[v])
			work->locked[work->canonical[v]] = 1;
}

stilb_result geometry_work_create(const stilb_geometry_mesh *mesh, stilb_job_pool *pool, uint32_t worker,
                                  geometry_work *work)
{
	*work = (geometry_work){.mesh = mesh, .pool = pool, .worker = worker};
	work->canonical = stilb_memory_alloc(mesh->vertex_count, sizeof *work->canonical);
	work->target = stilb_memory_alloc(mesh->vertex_count, sizeof *work->target);
	work->triangles = stilb_memory_alloc(mesh->index_count / 3, sizeof *work->triangles);
	if (mesh->locked)
		work->locked = calloc(mesh->vertex_count + 1u, 1);
	if (!work->canonical || !work->target || !work->triangles || (mesh->locked && !work->locked) ||
	    !geometry_weld(mesh, pool, worker, work->canonical) || !work_measure(work)) {
		geometry_work_finish(work);
		return stilb_fail(STILB_ERROR_MEMORY, "no memory to simplify a mesh of %u triangles", mesh->index_count / 3);
	}
	if (mesh->locked)
		copy_locks(work);
	for (uint32_t v = 0; v < mesh->vertex_count; v++)
		work->target[v] = v;
	return STILB_OK;
}

void geometry_work_finish(geometry_work *work)
{
	free(work->canonical);
	free(work->locked);
	free(work->target);
	free(work->triangles);
	*work = (geometry_work){0};
}

/* ---- cutting into regions ---------------------------------------------------------------------------------------- */

typedef struct reduce {
	geometry_work *work;
	geometry_round round;
	_Atomic uint32_t *owner;     /* [vertex_count] of canonical vertices */
	const geometry_keyed *order; /* [count] triangles in the order of space */
	const uint32_t (*unsorted)[3];
	uint32_t (*triangles)[3]; /* [count] in this order */
	uint32_t count, regions;
	float shift[3]; /* where the cuts lie */
	geometry_stop stop;
	geometry_record *records; /* [regions] */
	uint32_t *left;           /* [regions] collapses to apply; triangles after them; then where these go */
	uint32_t step;            /* every `step`-th region is a pilot */
	bool pilots;              /* this loop is over the pilots, else over the others */
	atomic_bool failed;
	geometry_keyed *keyed;
} reduce;

static uint32_t region_begin(const reduce *r, uint32_t region)
{
	return (uint32_t)((uint64_t)r->count * region / r->regions);
}

static void key_triangles(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	const reduce *r = context;
	const geometry_work *work = r->work;
	float scale = work->extent > 0.0f ? 1023.0f / (1.6f * work->extent) : 0.0f;
	for (uint32_t t = begin; t < end; t++) {
		uint32_t cell[3];
		const float *p = geometry_position(work->mesh, r->unsorted[t][0]),
					*q = geometry_position(work->mesh, r->unsorted[t][1]),
					*s = geometry_position(work->mesh, r->unsorted[t][2]);
		for (int axis = 0; axis < 3; axis++) {
			float middle = (p[axis] + q[axis] + s[axis]) * (1.0f / 3.0f);
			float at = (middle - work->lower[axis] + r->shift[axis] * work->extent) * scale;
			cell[axis] = at > 0.0f ? at < 1023.0f ? (uint32_t)at : 1023u : 0u;
		}
		r->keyed[t] = (geometry_keyed){geometry_morton(cell[0], cell[1], cell[2]) >> KEY_SHIFT, t};
	}
}

static void gather_triangles(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	const reduce *r = context;
	for (uint32_t t = begin; t < end; t++)
		memcpy(r->triangles[t], r->unsorted[r->order[t].value], sizeof *r->triangles);
}

static void clear_owners(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	const reduce *r = context;
	for (uint32_t v = begin; v < end; v++) /* relaxed: the loop's end publishes it */
		atomic_store_explicit(&r->owner[v], GEOMETRY_SHARED - 1, memory_order_relaxed);
}

/* Notes for each position the region that it is in, or that it is in several. */
static void find_owners(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	const reduce *r = context;
	for (uint32_t region = begin; region < end; region++)
		for (uint32_t t = region_begin(r, region); t < region_begin(r, region + 1); t++)
			for (int k = 0; k < 3; k++) {
				_Atomic uint32_t *owner = &r->owner[r->work->canonical[r->triangles[t][k]]];
				/* relaxed: only the value counts, which is the same in the end in whatever order regions come, and
				 * the loop's end publishes it */
				uint32_t now = atomic_load_explicit(owner, memory_order_relaxed);
				while (now != region && now != GEOMETRY_SHARED)
					if (atomic_compare_exchange_weak_explicit(owner, &now,
					                                          now == GEOMETRY_SHARED - 1 ? region : GEOMETRY_SHARED,
					                                          memory_order_relaxed, memory_order_relaxed))
						break;
			}
}

/* ---- one round --------------------------------------------------------------------------------------------------- */

static void collapse_regions(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	reduce *r = context;
	for (uint32_t i = begin; i < end; i++) {
		uint32_t region = r->pilots ? i * r->step : i + i / (r->step - 1) + 1;
		uint32_t from = region_begin(r, region);
		uint32_t count = region_begin(r, region + 1) - from;
		geometry_stop stop = r->stop;
		stop.triangles = (uint32_t)((uint64_t)stop.triangles * count / r->count);
		if (!geometry_region_collapse(&r->round, region, (const uint32_t(*)[3])(r->triangles + from), count, stop,
		                              &r->records[region]))
			atomic_store_explicit(&r->failed, true, memory_order_relaxed); /* relaxed: the loop's end publishes it */
	}
}

/* Triangles that pilots lose if collapses of this cost at most are made. */
static uint64_t removed_at(const reduce *r, float cost)
{
	uint64_t removed = 0;
	for (uint32_t region = 0; region < r->regions; region += r->step) {
		uint32_t prefix = geometry_record_prefix(&r->records[region], cost);
		removed += prefix > 0 ? r->records[region].triangles[prefix - 1] : 0;
	}
	return removed;
}

/* The least cost at which at least `wanted` triangles go; FLT_MAX if there are not so many. */
static float cost_of(const reduce *r, uint64_t wanted)
{
	uint32_t low = 0, high = 0x7f7fffff; /* the bits of floats from 0 to FLT_MAX ascend with them */
	while (low < high) {
		uint32_t middle = low + (high - low) / 2;
		float cost;
		memcpy(&cost, &middle, sizeof cost);
		if (removed_at(r, cost) >= wanted)
			high = middle;
		else
			low = middle + 1;
	}
	float cost;
	memcpy(&cost, &low, sizeof cost);
	return cost;
}

/* Triangles that the first collapses of a record remove. */
static uint32_t removed_by(const geometry_record *record, uint32_t collapses)
{
	return collapses > 0 ? record->triangles[collapses - 1] : 0;
}

/* How many collapses of each region are applied, r->left: those that cost less than the last one that is needed, and of
 * those that cost as much, in every region the same part. Costs of a region ascend, so many may be the same. */
static void choose_prefixes(reduce *r, uint64_t wanted)
{
	float cost = cost_of(r, wanted), less = nextafterf(cost, 0.0f);
	uint64_t before = 0, equal = 0;
	for (uint32_t region = 0; region < r->regions; region++) {
		const geometry_record *record = &r->records[region];
		uint32_t first = cost > 0.0f ? geometry_record_prefix(record, less) : 0;
		uint32_t all = geometry_record_prefix(record, cost), removed = removed_by(record, first);
		r->left[region] = first;
		before += removed;
		equal += removed_by(record, all) - removed;
	}
	uint64_t needed = wanted > before ? wanted - before : 0;
	for (uint32_t region = 0; region < r->regions && equal > 0 && needed > 0; region++) {
		const geometry_record *record = &r->records[region];
		uint32_t all = geometry_record_prefix(record, cost), i = r->left[region], removed = removed_by(record, i);
		uint64_t part = removed_by(record, all) - removed, take = needed * part / equal + (needed * part % equal != 0);
		while (i < all && removed_by(record, i) - removed < take)
			i++;
		r->left[region] = i;
		equal -= part; /* what is left of both is for the regions that follow */
		uint64_t taken = removed_by(record, i) - removed;
		needed = needed > taken ? needed - taken : 0;
	}
	for (uint32_t region = 0; region < r->regions; region++) {
		const geometry_record *record = &r->records[region];
		uint32_t last = r->left[region];
		if (last > 0 && record->cost[last - 1] > r->work->cost)
			r->work->cost = record->cost[last - 1];
	}
}

/* Applies the collapses of regions to their triangles, in place. */
static void apply_regions(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	const reduce *r = context;
	geometry_work *work = r->work;
	for (uint32_t region = begin; region < end; region++) {
		const geometry_record *record = &r->records[region];
		uint32_t prefix = r->left[region], maps = prefix > 0 ? record->maps_end[prefix - 1] : 0;
		for (uint32_t i = maps; i-- > 0;) /* backwards: where a vertex goes to is known before it */
			work->target[record->from[i]] = work->target[record->to[i]];
		uint32_t from = region_begin(r, region), to = from;
		for (uint32_t t = from; t < region_begin(r, region + 1); t++) {
			uint32_t v[3], p[3];
			for (int k = 0; k < 3; k++) {
				v[k] = work->target[r->triangles[t][k]];
				p[k] = work->canonical[v[k]];
			}
			if (p[0] != p[1] && p[1] != p[2] && p[0] != p[2])
				memcpy(r->triangles[to++], v, sizeof v);
		}
		r->left[region] = to - from;
	}
}

static void compact_regions(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	const reduce *r = context;
	for (uint32_t region = begin; region < end; region++)
		memcpy(r->work->triangles[r->left[region]], r->triangles[region_begin(r, region)],
		       (r->left[region + 1] - r->left[region]) * sizeof *r->triangles);
}

static void reduce_finish(reduce *r)
{
	for (uint32_t i = 0; r->records && i < r->regions; i++)
		geometry_record_finish(&r->records[i]);
	free(r->records);
	free(r->left);
	free(r->owner);
	free(r->keyed);
	free(r->triangles);
}

static bool reduce_allocate(reduce *r)
{
	r->triangles = stilb_memory_alloc(r->count, sizeof *r->triangles);
	r->records = calloc(r->regions, sizeof *r->records);
	r->left = stilb_memory_alloc(r->regions + 1u, sizeof *r->left);
	if (r->regions > 1) {
		r->owner = stilb_memory_alloc(r->work->mesh->vertex_count, sizeof *r->owner);
		r->keyed = stilb_memory_alloc(r->count, 2 * sizeof *r->keyed);
	}
	return r->triangles && r->records && r->left && (r->regions == 1 || (r->owner && r->keyed));
}

/* Sorts triangles by space and finds what regions share. False: no memory. */
static bool reduce_cut(reduce *r)
{
	geometry_work *work = r->work;
	if (r->regions == 1) {
		memcpy(r->triangles, work->triangles, r->count * sizeof *r->triangles);
		return true;
	}
	/* A Z-order curve over shifted cells: each round cuts elsewhere. */
	for (uint32_t axis = 0; axis < 3; axis++)
		r->shift[axis] = 0.6f * stilb_random_float(work->rounds, axis);
	r->unsorted = (const uint32_t(*)[3])work->triangles;
	geometry_for(work->pool, work->worker, r->count, 8192, key_triangles, r);
	geometry_keyed *sorted;
	if (!geometry_sort(work->pool, work->worker, r->keyed, r->keyed + r->count, r->count, 30 - KEY_SHIFT, &sorted))
		return false;
	r->order = sorted;
	geometry_for(work->pool, work->worker, r->count, 8192, gather_triangles, r);
	geometry_for(work->pool, work->worker, work->mesh->vertex_count, 65536, clear_owners, r);
	geometry_for(work->pool, work->worker, r->regions, 1, find_owners, r);
	r->round.owner = (const uint32_t *)r->owner;
	return true;
}

void geometry_round_scale(geometry_round *round, const geometry_work *work, uint32_t target)
{
	double edge = sqrt(work->area / (target > 0 ? target : 1));
	uint32_t numbers = 0;
	for (uint32_t s = 0; s < work->mesh->stream_count; s++) {
		const stilb_geometry_stream *stream = &work->mesh->streams[s];
		double scale = (double)stream->weight * edge;
		if (stream->kind == STILB_GEOMETRY_TEXTURE)
			scale = work->texture_density[s] > 1e-30 ? (double)stream->weight / work->texture_density[s] : 0.0;
		round->scale[s] = scale < 1e18 ? (float)scale : 0.0f;
		numbers += stream->components;
	}
	round->groups = (numbers + 3) / 4;
	double area = 6.0 * work->area / (work->count > 0 ? work->count : 1); /* six triangles at a position */
	round->area = area < 1e30 ? (float)area : 1e30f;
	double limit = VALUE_LIMIT * edge * edge;
	round->value_limit = limit < 1e30 ? (float)limit : 1e30f;
}

/* Simplifies all regions: first the pilots, which tell what triangles cost, then the others up to that. Afterwards all
 * count as pilots. */
static void collapse_all(reduce *r, uint32_t target, float max_cost)
{
	geometry_work *work = r->work;
	r->stop = (geometry_stop){.triangles = target, .cost = max_cost};
	r->step = r->regions >= 2 * PILOTS ? PILOTS : 1;
	if (r->regions > 1) /* costs differ from region to region: some go farther than to their share */
		r->stop.triangles = r->step > 1 ? target / 2 : target - target / 8;
	uint32_t pilots = (r->regions + r->step - 1) / r->step;
	r->pilots = true;
	geometry_for(work->pool, work->worker, pilots, 1, collapse_regions, r);
	if (r->step > 1) {
		uint64_t all = 0;
		for (uint32_t region = 0; region < r->regions; region += r->step)
			all += region_begin(r, region + 1) - region_begin(r, region);
		float cost = cost_of(r, (uint64_t)((double)(r->count - target) / r->count * (double)all * 1.03));
		r->stop.cost = cost < max_cost ? cost : max_cost;
		r->pilots = false;
		geometry_for(work->pool, work->worker, r->regions - pilots, 1, collapse_regions, r);
	}
	r->step = 1;
}

/* How many regions triangles are cut into: so many that two or four threads have as many each. */
static uint32_t region_count(uint32_t triangles)
{
	uint32_t least = (triangles + REGION - 1) / REGION, alike = least > 16 ? 16 : least > 2 ? 4 : 1;
	if (least == 1 && triangles > REGION / 2)
		return 2;
	return (least + alike - 1) / alike * alike;
}

static stilb_result reduce_round(geometry_work *work, uint32_t target, float max_cost)
{
	reduce r = {.work = work, .count = work->count, .regions = region_count(work->count)};
	r.round = (geometry_round){.mesh = work->mesh, .canonical = work->canonical, .locked = work->locked};
	geometry_round_scale(&r.round, work, target);
	bool made = reduce_allocate(&r) && reduce_cut(&r);
	if (made)
		collapse_all(&r, target, max_cost);
	if (!made || atomic_load_explicit(&r.failed, memory_order_relaxed)) {
		reduce_finish(&r);
		return stilb_fail(STILB_ERROR_MEMORY, "no memory to simplify a mesh of %u triangles", work->count);
	}
	choose_prefixes(&r, r.count - target);
	geometry_for(work->pool, work->worker, r.regions, 1, apply_regions, &r);
	uint32_t sum = 0;
	for (uint32_t region = 0; region <= r.regions; region++) {
		uint32_t left = region < r.regions ? r.left[region] : 0;
		r.left[region] = sum;
		sum += left;
	}
	geometry_for(work->pool, work->worker, r.regions, 1, compact_regions, &r);
	work->count = sum;
	work->rounds++;
	reduce_finish(&r);
	return STILB_OK;
}

stilb_result geometry_work_reduce(geometry_work *work, uint32_t target, float max_cost)
{
	uint32_t stalled = 0;
	while (work->count > target && stalled < 2) {
		uint32_t before = work->count, next = target;
		/* Far rounds are few, and what their borders have cost the last one makes good. */
		if (target < before / 3)
			next = target + target / 2 > before / 5 ? target + target / 2 : before / 5;
		stilb_result result = reduce_round(work, next, max_cost);
		if (result != STILB_OK)
			return result;
		stalled = before - work->count < before / 50 + 1 ? stalled + 1 : 0;
	}
	return STILB_OK;
}

/* ---- the whole --------------------------------------------------------------------------------------------------- */

void stilb_geometry_simplified_finish(stilb_geometry_simplified *simplified)
{
	STILB_ASSERT(simplified);
	free(simplified->indices);
	free(simplified->target);
	*simplified = (stilb_geometry_simplified){0};
}

stilb_result stilb_geometry_simplify(const stilb_geometry_mesh *mesh, const stilb_geometry_simplify_desc *desc,
                                     stilb_job_pool *pool, uint32_t worker, stilb_geometry_simplified *simplified)
{
	STILB_ASSERT(mesh && desc && simplified);
	*simplified = (stilb_geometry_simplified){0};
	stilb_result result = geometry_mesh_check(mesh);
	if (result != STILB_OK)
		return result;
	geometry_work work;
	result = geometry_work_create(mesh, pool, worker, &work);
	if (result != STILB_OK)
		return result;
	float limit = desc->max_error * desc->max_error;
	result = geometry_work_reduce(&work, desc->target_triangles, desc->max_error > 0.0f ? limit : FLT_MAX);
	if (result == STILB_OK) {
		for (uint32_t v = 0; v < mesh->vertex_count; v++) {
			uint32_t to = v; /* rounds make chains of a few links */
			while (work.target[to] != to)
				to = work.target[to];
			work.target[v] = to;
		}
		simplified->indices = (uint32_t *)work.triangles;
		simplified->index_count = 3 * work.count;
		simplified->target = work.target;
		simplified->error = sqrtf(work.cost);
		work.triangles = NULL;
		work.target = NULL;
	}
	geometry_work_finish(&work);
	return result;
}
