/* culling, inside: for this folder and its tests. */
#ifndef STILB_CULL_INTERNAL_H
#define STILB_CULL_INTERNAL_H

#include "culling/cull.h"
#include "culling/cull_kernels.h"

#define CULL_MAX_DEPTH 20u
#define CULL_CHUNK 4096u /* most objects that one piece of work tests or writes: 64 words of bits */
/* Models to test flat: with fewer, waking a sleeping worker (some 20 us) costs more than it saves. Measured on two CPUs, the
 * worker asleep before each run: 65,536 models take 32 us on one thread and 41 on two, 131,072 take 70 and 71, 262,144
 * take 131 and 107. Objects of the octree, which are also marked one by one, count twice. */
#define CULL_SERIAL_BELOW 131072u
#define CULL_ROOT 0u
#define CULL_NONE 0u /* no cell: the root is nobody's child and is never free */

/* Where an object belongs: the cell at this depth and place (in cells of that depth from the root's low corner). */
typedef struct cull_cell_name {
	uint32_t depth;
	uint32_t position[3];
} cull_cell_name;

/* A cell of the tree. Cells come in families of eight siblings at indices 8 n .. 8 n + 7, bit 0 of the index: upper half
 * in x, bit 1 in y, bit 2 in z. A sibling with nothing at or below it is vacant. The root is alone in family 0.
 * The five arrays are one block of memory that starts at x; its capacity is a multiple of CULL_WIDTH. */
typedef struct cull_cell {
	float *x, *y, *z, *radius; /* [count] bounds of the objects of this very cell */
	uint32_t *id;              /* [count] */
	uint32_t count, capacity;
	uint32_t subtree_count; /* objects here and in all cells below */
	uint32_t parent;        /* of the first of a free family: the next free one's first cell */
	uint32_t children;      /* the first of eight, or CULL_NONE */
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

/* Children that a view's way through the tree has come to, and what it knows of their parent. */
typedef struct cull_family {
	uint32_t children, depth;   /* the first child's index; the depth of the children */
	uint32_t planes;            /* that the parent is not wholly inside of */
	double center[CULL_PLANES]; /* each plane's signed distance of the parent's centre */
} cull_family;

/* What the walk through the tree came to. */
typedef struct cull_walk_result {
	uint32_t item_count;
	uint32_t tested, accepted; /* objects in the items with and without planes to test */
} cull_walk_result;

struct stilb_cull_octree {
	const cull_kernels *kernels;
	double low[3]; /* the root's low corner */
	double size;   /* the root's side */
	uint32_t max_depth;

	cull_cell *cells; /* [cell_count], of which 8 * family_count are in the tree */
	float *reach;     /* [cell_count] no object at or below has a greater radius; the root leaves its own objects out.
	                     -infinity for vacant cells, so that every plane rejects them */
	uint32_t cell_count, cell_capacity, family_count;
	uint32_t free_family; /* its first cell, or CULL_NONE */

	cull_place *places; /* [place_capacity] by object id */
	uint32_t place_capacity;

	/* Of the last cull_octree_walk. */
	cull_item *items; /* [item_capacity] */
	uint32_t item_capacity;
	cull_family *families; /* [families_capacity] */
	uint32_t families_capacity;
	uint32_t cell_tests; /* of a cell against a plane */
};

struct stilb_cull {
	const cull_kernels *kernels;
	stilb_cull_octree *octree;
	uint32_t model_count;
	uint32_t serial_below; /* CULL_SERIAL_BELOW, but for tests */
};

/* A copy of array (count elements) with room for capacity; frees array. NULL: no memory, array is untouched. */
void *cull_grow(void *array, size_t count, size_t capacity, size_t element);

/* Where these bounds belong. Depth 0 is also the place of all that no cell can promise to hold: centres outside the
 * root, radii that are negative, larger than half the root or infinite, and NaN. */
cull_cell_name cull_octree_name(const stilb_cull_octree *octree, stilb_sphere bounds);

/* Side of the cells at this depth, and the centre of one. */
double cull_octree_cell_size(const stilb_cull_octree *octree, uint32_t depth);
void cull_octree_cell_center(const stilb_cull_octree *octree, cull_cell_name name, double center[3]);

/* Whether every object is visible for certain; looks at the root alone. */
bool cull_octree_inside(const stilb_cull_octree *octree, const stilb_frustum *frustum);

/* Fills octree->items with what frustum may see. */
stilb_result cull_octree_walk(stilb_cull_octree *octree, const stilb_frustum *frustum, cull_walk_result *result);

/* Does items begin .. end - 1: sets the bits of their visible objects. */
void cull_octree_mark(const stilb_cull_octree *octree, uint32_t begin, uint32_t end, const stilb_frustum *frustum,
                      uint64_t *bits);

/* NULL when all is as it should be, else what is wrong: every object is in the cell that its bounds name and inside that
 * cell's loose bounds, counts, reaches, places and the free list are right. */
const char *cull_octree_check(const stilb_cull_octree *octree);

/* The root cube and depth for a scene: what stilb_cull_create builds. */
stilb_cull_octree_desc cull_desc_for_scene(const stilb_scene *scene);

#endif
