/* A view's walk through the octree: sixteen cells at a time are rejected or accepted as a whole where that is certain.
 * All other objects go to a list of items that any number of threads can test. */
#include "culling/cull_internal.h"
#include "profiler/prof.h"

#include <math.h>
#include <stdlib.h>

/* Constants of a view's planes, for any cell. */
typedef struct cull_view {
	uint32_t certain;           /* mask of planes without NaN and overflow, which can decide a cell */
	double center[CULL_PLANES]; /* signed distance of the root's centre */
	/* For a cell of half side 1, measured along the plane's normal n: from its centre to the farthest corner, which is
	 * |n.x| + |n.y| + |n.z|. */
	double spread[CULL_PLANES];
	double margin[CULL_PLANES]; /* bound of all rounding errors of a signed distance */
	/* The same from the parent's centre to that of each child, signed; the child's half side is 1. */
	double toward[CULL_PLANES][CULL_CHILDREN];
} cull_view;

typedef struct cull_walk {
	const stilb_cull_octree *octree;
	cull_list *list;
	cull_view view;
	double half;           /* half the side of the cells that `level` is for */
	uint32_t depth;        /* that `level` is for; 0: none yet */
	uint32_t family_count; /* families (eight siblings) reached so far */
	cull_walk_result result;
	cull_level level;
} cull_walk;

/*
 * To prove: if a cell is rejected or accepted here, the float test of each of its objects gives the same result,
 * rounding included. A plane has the normal n and the constant `distance`. The objects' centres lie in the cell, a cube
 * with half side h around c, and their radii in [0, reach]. So dot(n, centre) + distance lies in s - spread .. s +
 * spread with s = dot(n, c) + distance and spread = (|n_x| + |n_y| + |n_z|) h.
 *
 * With u = 2^-24 and size = sum of |n_i| (|c_i| + h) + |distance|, the float test is off by at most 4u / (1 - 4u) times
 * size (three products, three additions; Higham, "Accuracy and Stability of Numerical Algorithms", 2002, section 3.1).
 * The root's size bounds that of all cells, as they lie in it. The margin is 8u size, twice as much; the other half,
 * 2^-22 size, covers the remaining errors. The sums here, in double and over at most 20 levels, are off by less than
 * 2^-45 size. A centre may lie outside the cell it was placed in by 2^-51 (|low| + side) of the root, and for each axis
 * |c_i| + h is at least |low_i| and at least half a side: that is less than 2^-48 size.
 * The margin's term 2^-120 covers products that underflow, also if the CPU flushes them to zero.
 *
 * reach is added last: a sum of two numbers keeps its sign when it is rounded, so this addition cannot falsify the
 * comparison with 0. From 2^126 on a float sum could overflow, and planes may hold NaN: such a plane decides no cell,
 * and each object is tested against it.
 */
static void cull_view_init(cull_view *view, const stilb_cull_octree *octree, const stilb_frustum *frustum)
{
	double c[3], half = octree->size * 0.5;
	cull_octree_cell_center(octree, (cull_cell_name){0}, c);
	view->certain = 0;
	for (uint32_t p = 0; p < CULL_PLANES; p++) {
		stilb_plane plane = frustum->planes[p];
		double n[3] = {(double)plane.x, (double)plane.y, (double)plane.z}, distance = (double)plane.distance;
		double a[3] = {fabs(n[0]), fabs(n[1]), fabs(n[2])};
		double size =
			a[0] * (fabs(c[0]) + half) + a[1] * (fabs(c[1]) + half) + a[2] * (fabs(c[2]) + half) + fabs(distance);
		view->certain |= (uint32_t)(size < 0x1p126) << p;
		view->center[p] = n[0] * c[0] + n[1] * c[1] + n[2] * c[2] + distance;
		view->spread[p] = a[0] + a[1] + a[2];
		view->margin[p] = size * 0x1p-21 + 0x1p-120;
		for (uint32_t child = 0; child < CULL_CHILDREN; child++)
			view->toward[p][child] =
				(child & 1 ? n[0] : -n[0]) + (child & 2 ? n[1] : -n[1]) + (child & 4 ? n[2] : -n[2]);
	}
}

/* *planes: mask of the planes that the root is not wholly inside of. False: everything below the root is outside a
 * plane. */
static bool cull_view_root(const cull_view *view, const stilb_cull_octree *octree, uint32_t *planes)
{
	double half = octree->size * 0.5;
	*planes = CULL_ALL_PLANES;
	for (uint32_t left = view->certain; left; left &= left - 1) {
		uint32_t p = (uint32_t)__builtin_ctz(left);
		double spread = view->spread[p] * half + view->margin[p];
		if ((view->center[p] + spread) + (double)octree->reach[CULL_ROOT] < 0.0)
			return false;
		if (view->center[p] - spread >= 0.0)
			*planes &= ~(1u << p);
	}
	return true;
}

bool cull_octree_inside(const stilb_cull_octree *octree, const stilb_frustum *frustum)
{
	cull_view view;
	uint32_t planes;
	if (octree->cells[CULL_ROOT].count) /* the root's own objects may lie anywhere */
		return false;
	cull_view_init(&view, octree, frustum);
	return cull_view_root(&view, octree, &planes) && !planes;
}

/* Computes walk->level for another depth. Families are reached level by level, so one table at a time is enough. */
static void cull_walk_descend(cull_walk *walk, uint32_t depth)
{
	STILB_ASSERT(depth >= walk->depth && "families are in order of depth");
	if (walk->depth == depth)
		return;
	const cull_view *view = &walk->view;
	double half = cull_octree_cell_size(walk->octree, depth) * 0.5;
	for (uint32_t p = 0; p < CULL_PLANES; p++) {
		double spread = view->spread[p] * half + view->margin[p];
		for (uint32_t child = 0; child < CULL_CHILDREN; child++) {
			double toward = view->toward[p][child] * half;
			walk->level.high[p][child] = toward + spread;
			walk->level.low[p][child] = toward - spread;
		}
	}
	walk->depth = depth;
	walk->half = half;
}

/* Adds the objects of one cell to the items, to be tested against planes. */
static void cull_walk_push(cull_walk *walk, uint32_t index, uint32_t planes)
{
	uint32_t count = walk->octree->cells[index].count;
	for (uint32_t first = 0; first < count; first += CULL_CHUNK) {
		uint32_t piece = count - first < CULL_CHUNK ? count - first : CULL_CHUNK;
		STILB_ASSERT(walk->result.item_count < walk->list->item_capacity);
		walk->list->items[walk->result.item_count++] = (cull_item){index, first, piece, planes};
	}
	*(planes ? &walk->result.tested : &walk->result.accepted) += count;
}

/* Adds the children of a cell to the families to be tested. */
static cull_family *cull_walk_add(cull_walk *walk, uint32_t index, uint32_t planes)
{
	const cull_cell *cell = &walk->octree->cells[index];
	STILB_ASSERT(cell->children != CULL_NONE && walk->family_count < walk->list->families_capacity);
	cull_family *family = &walk->list->families[walk->family_count++];
	family->children = cell->children;
	family->depth = cell->name.depth + 1;
	family->planes = planes;
	return family;
}

/* Takes the results of one family from a test of sixteen cells, in which its first cell is bit `shift`: skips rejected
 * cells, adds the objects of the others to the items, and their children to the families to be tested. */
static void cull_walk_family(cull_walk *walk, const cull_family *family, const cull_sixteen *cells, uint32_t shift)
{
	const cull_view *view = &walk->view;
	STILB_ASSERT(shift == 0 || shift == CULL_CHILDREN);
	for (uint32_t left = ~((uint32_t)cells->rejected >> shift) & 0xffu; left; left &= left - 1) {
		uint32_t child = (uint32_t)__builtin_ctz(left), index = family->children + child;
		uint32_t planes = family->planes;
		if (!walk->octree->cells[index].subtree_count)
			continue;
		for (uint32_t p = 0; p < CULL_PLANES; p++)
			planes &= ~(((uint32_t)cells->inside[p] >> (shift + child) & 1u) << p);
		cull_walk_push(walk, index, planes);
		if (walk->octree->cells[index].children == CULL_NONE)
			continue;
		cull_family *next = cull_walk_add(walk, index, planes);
		for (uint32_t p = 0; p < CULL_PLANES; p++)
			next->center[p] = family->center[p] + view->toward[p][child] * walk->half;
	}
}

/* Tests family `at`, and with it family at + 1 if that has the same depth; returns how many were tested. */
static uint32_t cull_walk_step(cull_walk *walk, uint32_t at)
{
	const stilb_cull_octree *octree = walk->octree;
	const cull_family *first = &walk->list->families[at];
	bool pair = at + 1 < walk->family_count && first[1].depth == first->depth;
	const cull_family *second = pair ? first + 1 : first;
	uint32_t planes = (first->planes | second->planes) & walk->view.certain;
	STILB_ASSERT(first->depth <= octree->max_depth && first->children < octree->cell_count);
	cull_sixteen cells = {.center = {first->center, second->center},
	                      .reach = {octree->reach + first->children, octree->reach + second->children}};
	cull_walk_descend(walk, first->depth);
	if (planes)
		octree->kernels->sixteen(&cells, &walk->level, planes);
	walk->list->cell_tests += (uint32_t)__builtin_popcount(planes) * (pair ? 16 : 8);
	cull_walk_family(walk, first, &cells, 0);
	if (pair)
		cull_walk_family(walk, second, &cells, CULL_CHILDREN);
	return pair ? 2 : 1;
}

/* Makes space for the greatest possible number of items and families, so that the walk itself cannot fail. False: no
 * memory. */
static bool cull_walk_reserve(const stilb_cull_octree *octree, cull_list *list)
{
	uint32_t needed = octree->family_count * CULL_CHILDREN + octree->cells[CULL_ROOT].subtree_count / CULL_CHUNK;
	if (needed > list->item_capacity) {
		cull_item *items = cull_grow(list->items, 0, (size_t)needed * 2, sizeof *items);
		if (!items)
			return false;
		list->items = items;
		list->item_capacity = needed * 2;
	}
	if (octree->family_count > list->families_capacity) {
		uint32_t capacity = octree->family_count * 2;
		cull_family *families = cull_grow(list->families, 0, capacity, sizeof *families);
		if (!families)
			return false;
		list->families = families;
		list->families_capacity = capacity;
	}
	return true;
}

stilb_result cull_octree_walk(const stilb_cull_octree *octree, cull_list *list, const stilb_frustum *frustum,
                              cull_walk_result *result)
{
	PROFILE("cull.walk");
	STILB_ASSERT(frustum && result);
	*result = (cull_walk_result){0};
	if (!cull_walk_reserve(octree, list))
		return stilb_fail(STILB_ERROR_MEMORY, "octree: no memory for the list of its cells");
	cull_walk walk;
	uint32_t planes;
	walk.octree = octree;
	walk.list = list;
	walk.depth = 0;
	walk.family_count = 0;
	walk.result = (cull_walk_result){0};
	list->cell_tests = 0;
	cull_walk_push(&walk, CULL_ROOT, CULL_ALL_PLANES); /* the root's own objects may lie anywhere */
	cull_view_init(&walk.view, octree, frustum);
	if (cull_view_root(&walk.view, octree, &planes) && octree->cells[CULL_ROOT].children != CULL_NONE) {
		cull_family *family = cull_walk_add(&walk, CULL_ROOT, planes);
		for (uint32_t p = 0; p < CULL_PLANES; p++)
			family->center[p] = walk.view.center[p];
	}
	for (uint32_t at = 0; at < walk.family_count;)
		at += cull_walk_step(&walk, at);
	*result = walk.result;
	STILB_ASSERT(result->tested + result->accepted <= octree->cells[CULL_ROOT].subtree_count);
	return STILB_OK;
}

static void cull_set_bit(uint64_t *bits, uint32_t id)
{
	bits[id >> 6] |= 1ull << (id & 63);
}

/* Sets the bits of an item's visible objects. */
static void cull_mark_item(const stilb_cull_octree *octree, const cull_item *item, const stilb_frustum *frustum,
                           uint64_t *bits)
{
	const cull_cell *cell = &octree->cells[item->cell];
	const uint32_t *id = cell->id + item->first;
	STILB_ASSERT(item->count > 0 && item->count <= CULL_CHUNK && item->first + item->count <= cell->count);
	if (!item->planes) {
		for (uint32_t i = 0; i < item->count; i++)
			cull_set_bit(bits, id[i]);
		return;
	}
	cull_spheres spheres = {cell->x + item->first, cell->y + item->first, cell->z + item->first,
	                        cell->radius + item->first};
	uint64_t visible[CULL_CHUNK_WORDS];
	octree->kernels->test(spheres, item->count, frustum, item->planes, visible);
	for (uint32_t first = 0; first < item->count; first += 64)
		for (uint64_t left = visible[first / 64]; left; left &= left - 1)
			cull_set_bit(bits, id[first + (uint32_t)__builtin_ctzll(left)]);
}

void cull_octree_mark(const stilb_cull_octree *octree, const cull_list *list, uint32_t begin, uint32_t end,
                      const stilb_frustum *frustum, uint64_t *bits)
{
	STILB_ASSERT(begin <= end && end <= list->item_capacity);
	for (uint32_t i = begin; i < end; i++)
		cull_mark_item(octree, &list->items[i], frustum, bits);
}

stilb_result stilb_cull_octree_mark(stilb_cull_octree *octree, const stilb_frustum *frustum, uint64_t *bits)
{
	STILB_ASSERT(bits || octree->cells[CULL_ROOT].subtree_count == 0);
	cull_walk_result walk;
	stilb_result result = cull_octree_walk(octree, &octree->list, frustum, &walk);
	cull_octree_mark(octree, &octree->list, 0, walk.item_count, frustum, bits);
	return result;
}
