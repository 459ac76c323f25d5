/* culling, inside: for this folder and its tests. */
#ifndef STILB_CULL_INTERNAL_H
#define STILB_CULL_INTERNAL_H

#include "culling/cull.h"

#define CULL_MAX_DEPTH 20u
#define CULL_PLANES 0x3fu        /* one bit a plane of the frustum */
#define CULL_CHUNK 4096u         /* most objects that one piece of work tests, marks or compacts */
#define CULL_SERIAL_BELOW 32768u /* objects: with fewer, waking a thread costs more than it saves */
#define CULL_ROOT 0u
#define CULL_NONE 0u /* no cell: the root is nobody's child and is never free */

/* Spheres, one array a component. */
typedef struct cull_spheres {
	const float *x, *y, *z, *radius;
} cull_spheres;

/* Where an object belongs: the cell at this depth and place (in cells of that depth from the root's low corner). */
typedef struct cull_cell_name {
	uint32_t depth;
	uint32_t position[3];
} cull_cell_name;

/* A cell of the tree. The five arrays are one block of memory that starts at x. */
typedef struct cull_cell {
	float *x, *y, *z, *radius; /* [count] bounds of the objects of this very cell */
	uint32_t *id;              /* [count] */
	uint32_t count, capacity;
	uint32_t subtree_count; /* objects here and in all cells below; only the root can be empty */
	float reach;            /* no object here or below has a greater radius; the root leaves its own objects out */
	uint32_t parent;        /* of a free cell: the next free one */
	uint32_t children[8];   /* bit 0 of the index: upper half in x, bit 1 in y, bit 2 in z */
	cull_cell_name name;
} cull_cell;

/* Where an object is. */
typedef struct cull_place {
	uint32_t cell_plus_one; /* 0: not in the tree */
	uint32_t slot;
} cull_place;

/* Work of one view: objects first .. first + count - 1 of a cell, to be tested against planes (none: all visible). */
typedef struct cull_item {
	uint32_t cell, first, count;
	uint32_t planes;
} cull_item;

struct stilb_cull_octree {
	double low[3]; /* the root's low corner */
	double size;   /* the root's side */
	uint32_t max_depth;

	cull_cell *cells; /* [cell_count], of which live_count are in the tree */
	uint32_t cell_count, cell_capacity, live_count;
	uint32_t free_cell;

	cull_place *places; /* [place_capacity] by object id */
	uint32_t place_capacity;

	cull_item *items; /* [item_capacity] of the last cull_octree_collect */
	uint32_t item_capacity;
	uint32_t plane_tests; /* of cells, in the last cull_octree_collect */
};

struct stilb_cull {
	stilb_cull_octree *octree;
	uint32_t model_count;
	uint32_t serial_below; /* CULL_SERIAL_BELOW, but for tests */
};

/* A copy of array (count elements) with room for capacity; frees array. NULL: no memory, array is untouched. */
void *cull_grow(void *array, size_t count, size_t capacity, size_t element);

/* visible[i] = whether sphere i is visible for all planes of the mask; 0 or 1. THE test of this module, always evaluated
 * in this order: ((x * px + y * py) + z * pz) + distance >= -radius. */
void cull_test_spheres(cull_spheres spheres, uint32_t count, const stilb_frustum *frustum, uint32_t planes,
                       uint8_t *visible);

/* Where these bounds belong. Depth 0 is also the place of all that no cell can promise to hold: centres outside the
 * root, radii that are negative, larger than half the root or infinite, and NaN. */
cull_cell_name cull_octree_name(const stilb_cull_octree *octree, stilb_sphere bounds);

/* Side of the cells at this depth, and the centre of one. */
double cull_octree_cell_size(const stilb_cull_octree *octree, uint32_t depth);
void cull_octree_cell_center(const stilb_cull_octree *octree, cull_cell_name name, double center[3]);

/* Fills octree->items with what frustum may see; object_count gets the number of objects in them. */
stilb_result cull_octree_collect(stilb_cull_octree *octree, const stilb_frustum *frustum, uint32_t *item_count,
                                 uint32_t *object_count);

/* Does one item: flags[id] = 1 for its visible objects. */
void cull_octree_mark(const stilb_cull_octree *octree, const cull_item *item, const stilb_frustum *frustum,
                      uint8_t *flags);

/* NULL when all is as it should be, else what is wrong: every object is in the cell that its bounds name and inside that
 * cell's loose bounds, counts, reaches, places and the free list are right. */
const char *cull_octree_check(const stilb_cull_octree *octree);

/* The root cube and depth for a scene: what stilb_cull_create builds. */
stilb_cull_octree_desc cull_desc_for_scene(const stilb_scene *scene);

#endif
