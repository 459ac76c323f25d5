#include "gi/cache/gi_cache_octree.h"

#include "gi/cache/gi_cache_slab.h"

#include <stdlib.h>

#define DEPTH 16u /* levels: a position is a 16-bit integer on each axis, whose bits from the highest name the cells */

/* A mention: an entry in a cell's list of records. It has the record's bounding sphere, so that most records that do
 * not reach a position are skipped without being read. */
typedef struct octree_mention {
	stilb_vec4 sphere; /* centre; [3] squared radius */
	const gi_cache_record *record;
	const struct octree_mention *next;
} octree_mention;

typedef struct octree_cell {
	_Atomic(struct octree_cell *) children[8];
	_Atomic(const octree_mention *) mentions;
	char unused[56];
} octree_cell;

struct gi_cache_octree {
	stilb_vec3 low;
	float size;     /* side of the root, metres */
	float to_cells; /* from metres to the 16-bit integers */
	octree_cell *root;
	gi_cache_slab cells, mentions, records;
};

/* ---- life -------------------------------------------------------------------------------------------------------- */

stilb_result gi_cache_octree_create(const float low[3], const float high[3], gi_cache_octree **out)
{
	STILB_ASSERT(low && high && out);
	*out = stilb_memory_alloc(1, sizeof(gi_cache_octree));
	if (!*out)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the irradiance cache");
	gi_cache_octree *octree = *out;
	float size = fmaxf(fmaxf(high[0] - low[0], high[1] - low[1]), high[2] - low[2]);
	if (!(size > 0.0f))
		size = 1.0f; /* no triangles, or a single point: any size will do */
	*octree = (gi_cache_octree){
		.low = stilb_vec3_make(low[0], low[1], low[2]), .size = size, .to_cells = (float)(1u << DEPTH) / size};
	gi_cache_slab_init(&octree->cells, sizeof(octree_cell));
	gi_cache_slab_init(&octree->mentions, sizeof(octree_mention));
	gi_cache_slab_init(&octree->records, sizeof(gi_cache_record));
	octree->root = gi_cache_slab_take(&octree->cells);
	if (octree->root)
		return STILB_OK;
	gi_cache_octree_destroy(octree);
	*out = NULL;
	return stilb_fail(STILB_ERROR_MEMORY, "no memory for the irradiance cache");
}

/* True if no cell from this one down is deeper than DEPTH, and every mention (entry in a cell's list) has a record and
 * a sphere. For STILB_CHECK, while nobody inserts; so there is no store that the loads must be ordered after, and they
 * are relaxed. */
static bool cell_is_sound(const octree_cell *cell, uint32_t depth)
{
	if (depth > DEPTH)
		return false;
	const octree_mention *mention = atomic_load_explicit(&cell->mentions, memory_order_relaxed);
	for (; mention; mention = mention->next)
		if (!mention->record || !(mention->sphere[3] > 0.0f))
			return false;
	for (int i = 0; i < 8; i++) {
		const octree_cell *child = atomic_load_explicit(&cell->children[i], memory_order_relaxed);
		if (child && !cell_is_sound(child, depth + 1))
			return false;
	}
	return true;
}

void gi_cache_octree_destroy(gi_cache_octree *octree)
{
	if (!octree)
		return;
	STILB_CHECK(!octree->root || cell_is_sound(octree->root, 0));
	gi_cache_slab_finish(&octree->cells);
	gi_cache_slab_finish(&octree->mentions);
	gi_cache_slab_finish(&octree->records);
	free(octree);
}

uint32_t gi_cache_octree_count(const gi_cache_octree *octree)
{
	return gi_cache_slab_count(&octree->records);
}

const gi_cache_record *gi_cache_octree_record(const gi_cache_octree *octree, uint32_t i)
{
	STILB_ASSERT(i < gi_cache_octree_count(octree));
	return gi_cache_slab_item(&octree->records, i);
}

/* ---- places ------------------------------------------------------------------------------------------------------ */

/* The 16-bit integer, of the position x on one axis, whose bits name the cells from the root (highest bit) down to
 * DEPTH. Positions outside the root cell count as at its border. */
static uint32_t axis_place(const gi_cache_octree *octree, float x, int axis)
{
	STILB_ASSERT(axis >= 0 && axis < 3);
	float at = (x - octree->low[axis]) * octree->to_cells;
	float last = (float)((1u << DEPTH) - 1u);
	return (uint32_t)(at > 0.0f ? fminf(at, last) : 0.0f);
}

/* Index of the child cell, at `depth`, that holds the place (16-bit integers by axis): one bit from each axis. */
static uint32_t child_of(const uint32_t place[3], uint32_t depth)
{
	STILB_ASSERT(depth < DEPTH);
	uint32_t shift = DEPTH - 1u - depth;
	return (place[0] >> shift & 1u) | (place[1] >> shift & 1u) << 1 | (place[2] >> shift & 1u) << 2;
}

/* Half the extent, along a world axis, of the box around the ellipsoid in which the record is valid, metres. */
static float half_extent(const gi_cache_record *record, stilb_vec3 bitangent, int axis)
{
	float t = record->tangent[axis] / record->position[3];
	float b = bitangent[axis] / record->normal[3];
	float n = record->normal[axis] / record->tangent[3];
	return sqrtf(t * t + b * b + n * n);
}

/* ---- insertion --------------------------------------------------------------------------------------------------- */

/* The cell at that depth, created with all above it if needed; NULL: no memory. */
static octree_cell *cell_want(gi_cache_octree *octree, const uint32_t place[3], uint32_t depth)
{
	STILB_ASSERT(depth <= DEPTH);
	octree_cell *at = octree->root;
	for (uint32_t i = 0; i < depth; i++) {
		_Atomic(octree_cell *) *link = &at->children[child_of(place, i)];
		/* acquire: pairs with the release below, so that the new child is seen zeroed, not with older contents */
		octree_cell *child = atomic_load_explicit(link, memory_order_acquire);
		if (!child) {
			octree_cell *made = gi_cache_slab_take(&octree->cells);
			if (!made)
				return NULL;
			/* release: who sees the new cell sees it zeroed. On failure another thread has added a cell at the same
			 * time: acquire as above, and this thread's cell stays unused. */
			if (atomic_compare_exchange_strong_explicit(link, &child, made, memory_order_release, memory_order_acquire))
				child = made;
		}
		at = child;
	}
	return at;
}

/* Puts a mention of the record, and of its bounding sphere, at the head of the cell's list. False: no memory. */
static bool mention_add(gi_cache_octree *octree, octree_cell *cell, const gi_cache_record *record, float radius)
{
	STILB_ASSERT(radius > 0.0f);
	octree_mention *made = gi_cache_slab_take(&octree->mentions);
	if (!made)
		return false;
	made->sphere = record->position;
	made->sphere[3] = radius * radius;
	made->record = record;
	/* relaxed: this thread does not read the older mention. Threads that reach the older one through the new one see
	 * its contents, because it was stored with release and the exchange below continues that release sequence. */
	made->next = atomic_load_explicit(&cell->mentions, memory_order_relaxed);
	/* release: pairs with the acquire in first_mention: who finds the mention sees it and its record complete */
	while (!atomic_compare_exchange_weak_explicit(&cell->mentions, &made->next, made, memory_order_release,
	                                              memory_order_relaxed))
		;
	return true;
}

bool gi_cache_octree_insert(gi_cache_octree *octree, const gi_cache_record *source)
{
	STILB_ASSERT(source->position[3] > 0.0f && source->normal[3] > 0.0f);
	STILB_ASSERT(source->tangent[3] > 0.0f && source->irradiance[3] > 0.0f);
	gi_cache_record *record = gi_cache_slab_take(&octree->records);
	if (!record)
		return false;
	*record = *source;

	stilb_vec3 bitangent = stilb_vec3_cross(record->normal, record->tangent);
	float radius = 1.0f / record->irradiance[3];
	uint32_t low[3], high[3], depth = 0;
	float widest = 0.0f;
	for (int i = 0; i < 3; i++) {
		float half = half_extent(record, bitangent, i) * 1.0001f; /* a margin for rounding */
		widest = fmaxf(widest, 2.0f * half);
		low[i] = axis_place(octree, record->position[i] - half, i);
		high[i] = axis_place(octree, record->position[i] + half, i);
	}
	for (float side = octree->size * 0.5f; side >= widest && depth < DEPTH; side *= 0.5f)
		depth++;

	uint32_t shift = DEPTH - depth;
	for (uint32_t z = low[2] >> shift; z <= high[2] >> shift; z++) {
		for (uint32_t y = low[1] >> shift; y <= high[1] >> shift; y++) {
			for (uint32_t x = low[0] >> shift; x <= high[0] >> shift; x++) {
				uint32_t place[3] = {x << shift, y << shift, z << shift};
				octree_cell *cell = cell_want(octree, place, depth);
				if (!cell || !mention_add(octree, cell, record, radius))
					return false;
			}
		}
	}
	return true;
}

/* ---- lookup ------------------------------------------------------------------------------------------------------ */

static const octree_mention *first_mention(const octree_cell *cell)
{
	/* acquire: pairs with the release in mention_add of the newest mention, and of all older ones in the list, since
	 * each exchange continues their release sequence */
	return atomic_load_explicit(&cell->mentions, memory_order_acquire);
}

/* A walk from the root to the cell of a position. */
typedef struct octree_walk {
	const octree_cell *cell;
	uint32_t depth;
	uint32_t place[3];
} octree_walk;

static octree_walk walk_begin(const gi_cache_octree *octree, stilb_vec3 position)
{
	octree_walk walk = {.cell = octree->root};
	for (int i = 0; i < 3; i++)
		walk.place[i] = axis_place(octree, position[i], i);
	return walk;
}

static void walk_down(octree_walk *walk)
{
	if (walk->depth == DEPTH) {
		walk->cell = NULL;
		return;
	}
	/* acquire: pairs with the release in cell_want, so that the child is seen zeroed or as changed later */
	walk->cell = atomic_load_explicit(&walk->cell->children[child_of(walk->place, walk->depth)], memory_order_acquire);
	walk->depth++;
}

static bool inside_sphere(const octree_mention *mention, stilb_vec3 position)
{
	stilb_vec3 way = position - mention->sphere;
	return stilb_vec3_dot(way, way) < mention->sphere[3];
}

bool gi_cache_octree_lookup(const gi_cache_octree *octree, stilb_vec3 position, stilb_vec3 normal, float turn,
                            stilb_vec3 *irradiance)
{
	stilb_vec3 sum = {0};
	float weights = 0.0f;
	for (octree_walk walk = walk_begin(octree, position); walk.cell; walk_down(&walk)) {
		for (const octree_mention *m = first_mention(walk.cell); m; m = m->next) {
			if (!inside_sphere(m, position))
				continue;
			float error = gi_cache_record_error(m->record, position, normal, turn);
			if (!(error < 1.0f))
				continue;
			float weight = gi_cache_record_weight(error);
			sum += gi_cache_record_irradiance(m->record, position, normal) * weight;
			weights += weight;
		}
	}
	if (weights == 0.0f)
		return false;
	sum /= weights;
	for (int i = 0; i < 3; i++)
		sum[i] = fmaxf(sum[i], 0.0f);
	*irradiance = sum;
	return true;
}

bool gi_cache_octree_covers(const gi_cache_octree *octree, stilb_vec3 position, stilb_vec3 normal, float turn,
                            float reach)
{
	for (octree_walk walk = walk_begin(octree, position); walk.cell; walk_down(&walk))
		for (const octree_mention *m = first_mention(walk.cell); m; m = m->next)
			if (inside_sphere(m, position) && gi_cache_record_error(m->record, position, normal, turn) < reach)
				return true;
	return false;
}

bool gi_cache_octree_record_near(const gi_cache_octree *octree, stilb_vec3 position, float distance)
{
	STILB_ASSERT(distance >= 0.0f);
	for (octree_walk walk = walk_begin(octree, position); walk.cell; walk_down(&walk)) {
		for (const octree_mention *m = first_mention(walk.cell); m; m = m->next) {
			stilb_vec3 way = position - m->sphere;
			if (stilb_vec3_dot(way, way) < distance * distance)
				return true;
		}
	}
	return false;
}

/* ---- neighbour clamping ------------------------------------------------------------------------------------------ */

void gi_cache_octree_clamp(const gi_cache_octree *octree, gi_cache_record *record)
{
	stilb_vec3 position = record->position;
	for (octree_walk walk = walk_begin(octree, position); walk.cell; walk_down(&walk)) {
		for (const octree_mention *m = first_mention(walk.cell); m; m = m->next) {
			if (!inside_sphere(m, position))
				continue;
			stilb_vec3 way = position - m->sphere;
			float distance = sqrtf(stilb_vec3_dot(way, way));
			gi_cache_record_limit(record, 1.0f / m->record->irradiance[3] + distance);
		}
	}
}
