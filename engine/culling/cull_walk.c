/* A view's way through the octree: cells are rejected or accepted whole where that is certain, and what is left becomes
 * a list of items that any number of threads can work on. */
#include "culling/cull_internal.h"
#include "profiler/prof.h"

#include <math.h>
#include <stdlib.h>

typedef struct cull_walk {
	const stilb_cull_octree *octree;
	const stilb_frustum *frustum;
	cull_item *items;
	uint32_t item_count, object_count, plane_tests;
} cull_walk;

/*
 * Tests a cell against the planes of the mask. False: no object at or below it can pass. True: planes keeps the bits that
 * some object may still fail.
 *
 * What must hold: the float test of each object comes out as promised here, rounding included. Centres lie in the cell,
 * a cube with half side h around c, radii in [0, reach]. So n.center + distance lies in s - spread .. s + spread with
 * s = n.c + distance and spread = (|nx| + |ny| + |nz|) h.
 *
 * With u = 2^-24 and size = sum of |n_i| (|c_i| + h) + |distance|, the float test is off by at most 4u / (1 - 4u) times
 * size (three products, three additions; Higham, "Accuracy and Stability of Numerical Algorithms", 2002, section 3.1).
 * The margin is 8u size; its other half, 2^-22 size, is room for the rest. This function, in double, is off by less than
 * 2^-48 size. A centre may lie outside the cell it was placed in by 2^-51 (L + S), S the root's side and L the magnitude
 * of its low corner: where L <= 2 S that is less than 2^-28 h even at depth 20 (h = 2^-21 S), else |c_i| >= L / 2 and it
 * is less than 2^-49 (|c_i| + h).
 * 2^-120 stands for products that underflow, flush-to-zero too.
 *
 * Adding reach comes last, as the sign of a rounded sum is the sign of the exact one. From 2^126 on a float sum could
 * overflow, and planes may hold NaN: then nothing is certain and the objects decide.
 */
static bool cull_walk_test(cull_walk *walk, const cull_cell *cell, double half, uint32_t *planes)
{
	double c[3];
	cull_octree_cell_center(walk->octree, cell->name, c);
	double most[3] = {fabs(c[0]) + half, fabs(c[1]) + half, fabs(c[2]) + half};
	for (uint32_t left = *planes; left; left &= left - 1) {
		uint32_t bit = left & -left;
		walk->plane_tests++;
		stilb_plane plane = walk->frustum->planes[__builtin_ctz(left)];
		double n[3] = {(double)plane.x, (double)plane.y, (double)plane.z}, distance = (double)plane.distance;
		double s = n[0] * c[0] + n[1] * c[1] + n[2] * c[2] + distance;
		double spread = (fabs(n[0]) + fabs(n[1]) + fabs(n[2])) * half;
		double size = fabs(n[0]) * most[0] + fabs(n[1]) * most[1] + fabs(n[2]) * most[2] + fabs(distance);
		double margin = size * 0x1p-21 + 0x1p-120;
		if (!(size < 0x1p126))
			continue;
		if ((s + spread + margin) + (double)cell->reach < 0.0)
			return false;
		if (s - spread - margin >= 0.0)
			*planes &= ~bit;
	}
	return true;
}

static void cull_walk_push(cull_walk *walk, uint32_t index, uint32_t planes)
{
	uint32_t count = walk->octree->cells[index].count;
	for (uint32_t first = 0; first < count; first += CULL_CHUNK) {
		uint32_t piece = count - first < CULL_CHUNK ? count - first : CULL_CHUNK;
		walk->items[walk->item_count++] = (cull_item){index, first, piece, planes};
	}
	walk->object_count += count;
}

/* At most max_depth calls deep. */
static void cull_walk_cell(cull_walk *walk, uint32_t index, double half, uint32_t planes)
{
	const cull_cell *cell = &walk->octree->cells[index];
	if (planes && !cull_walk_test(walk, cell, half, &planes))
		return;
	if (index != CULL_ROOT)
		cull_walk_push(walk, index, planes);
	if (cell->subtree_count == cell->count)
		return;
	for (uint32_t octant = 0; octant < 8; octant++)
		if (cell->children[octant] != CULL_NONE)
			cull_walk_cell(walk, cell->children[octant], half * 0.5, planes);
}

/* Room for every item there can be, so that the walk itself cannot fail. */
static bool cull_items_reserve(stilb_cull_octree *octree)
{
	uint32_t needed = octree->live_count + octree->cells[CULL_ROOT].subtree_count / CULL_CHUNK;
	if (needed <= octree->item_capacity)
		return true;
	cull_item *items = cull_grow(octree->items, 0, (size_t)needed * 2, sizeof *items);
	if (!items)
		return false;
	octree->items = items;
	octree->item_capacity = needed * 2;
	return true;
}

stilb_result cull_octree_collect(stilb_cull_octree *octree, const stilb_frustum *frustum, uint32_t *item_count,
                                 uint32_t *object_count)
{
	PROFILE("cull.walk");
	*item_count = *object_count = 0;
	if (!cull_items_reserve(octree))
		return stilb_fail(STILB_ERROR_MEMORY, "octree: no memory for the list of %u cells", octree->live_count);
	cull_walk walk = {.octree = octree, .frustum = frustum, .items = octree->items};
	cull_walk_push(&walk, CULL_ROOT, CULL_PLANES); /* its objects may lie anywhere: always tested */
	cull_walk_cell(&walk, CULL_ROOT, octree->size * 0.5, CULL_PLANES);
	*item_count = walk.item_count;
	*object_count = walk.object_count;
	octree->plane_tests = walk.plane_tests;
	return STILB_OK;
}

void cull_octree_mark(const stilb_cull_octree *octree, const cull_item *item, const stilb_frustum *frustum,
                      uint8_t *flags)
{
	const cull_cell *cell = &octree->cells[item->cell];
	const uint32_t *id = cell->id + item->first;
	if (!item->planes) {
		for (uint32_t i = 0; i < item->count; i++)
			flags[id[i]] = 1;
		return;
	}
	cull_spheres spheres = {cell->x + item->first, cell->y + item->first, cell->z + item->first,
	                        cell->radius + item->first};
	uint8_t visible[CULL_CHUNK];
	cull_test_spheres(spheres, item->count, frustum, item->planes, visible);
	for (uint32_t i = 0; i < item->count; i++)
		flags[id[i]] = visible[i];
}

stilb_result stilb_cull_octree_mark(stilb_cull_octree *octree, const stilb_frustum *frustum, uint8_t *flags)
{
	uint32_t item_count, object_count;
	stilb_result result = cull_octree_collect(octree, frustum, &item_count, &object_count);
	for (uint32_t i = 0; i < item_count; i++)
		cull_octree_mark(octree, &octree->items[i], frustum, flags);
	return result;
}
