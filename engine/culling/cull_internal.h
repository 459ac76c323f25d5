/* The loose octree (a tree of cubes; every object is stored in the one whose size fits it, see cull.h), the list of
 * cells that a view must look into, and what stilb_cull holds. For this folder and its tests. */
#ifndef STILB_CULL_INTERNAL_H
#define STILB_CULL_INTERNAL_H

#include "base/base_contract.h"
#include "culling/cull.h"
#include "culling/cull_kernels.h"

#include <stdlib.h>

#define CULL_MAX_DEPTH 20u
#define CULL_CHUNK 4096u                           /* most objects that one piece of work tests or writes */
#define CULL_CHUNK_WORDS ((size_t)CULL_CHUNK / 64) /* words of a chunk's bits */
/* Least number of models for which the flat method uses several threads: with fewer, waking a sleeping worker (some 20
 * us) costs more than it saves. Measured on two CPUs, the worker asleep before each run: 65,536 models take 32 us on
 * one thread and 41 us on two, 131,072 take 70 and 71, 262,144 take 131 and 107. Objects of the octree count twice,
 * because they are also marked one by one. */
#define CULL_SERIAL_BELOW 131072u
#define CULL_ROOT 0u
#define CULL_NONE 0u /* no cell: index 0 is the root's, which is no child and never in the free list */

/* Names a cell: its depth, and its position counted in cells of that depth from the root's low corner. */
typedef struct cull_cell_name {
	uint32_t depth;
	uint32_t position[3];
} cull_cell_name;

/* A cell of the tree. Cells come in families of eight siblings at indices 8 n .. 8 n + 7; bits 0, 1, 2 of the index
 * tell whether it is the upper half of its parent in x, y, z. A cell is vacant if it and all cells below it have no
 * object. The root is alone in family 0. The five arrays are one block of memory that starts at x; capacity is a
 * multiple of CULL_WIDTH. */
typedef struct cull_cell {
	float *x, *y, *z, *radius; /* [count] bounds of the objects of this cell, without those of cells below */
	uint32_t *id;              /* [count] */
	uint32_t count, capacity;
	uint32_t subtree_count; /* objects here and in all cells below */
	uint32_t parent;        /* in the first cell of a free family: the first cell of the next free family */
	uint32_t children;      /* the first of eight, or CULL_NONE */
	cull_cell_name name;
} cull_cell;

/* Where an object is stored: the index of its cell plus one, and its index in that cell's arrays. */
typedef struct cull_place {
	uint32_t cell_plus_one; /* 0: not in the tree */
	uint32_t slot;
} cull_place;

/* Work of one view: objects first .. first + count - 1 of a cell, to be tested against the planes of the mask (0: all
 * are visible). */
typedef struct cull_item {
	uint32_t cell, first, count;
	uint32_t planes;
} cull_item;

/* A family that the walk through the tree has reached but not tested, with what is known about its parent. */
typedef struct cull_family {
	uint32_t children, depth;   /* the first child's index; the depth of the children */
	uint32_t planes;            /* mask of the planes that the parent is not wholly inside of */
	double center[CULL_PLANES]; /* signed distance of the parent's centre from each plane */
} cull_family;

/* The size of the work list that a walk made. */
typedef struct cull_walk_result {
	uint32_t item_count;
	uint32_t tested, accepted; /* objects in the items with and without planes to test */
} cull_walk_result;

/* What a view must look into, made by a walk. Each view that is culled has its own. {0} is empty. */
typedef struct stilb_cull_list {
	cull_item *items; /* [item_capacity] */
	uint32_t item_capacity;
	cull_family *families; /* [families_capacity] */
	uint32_t families_capacity;
	uint32_t cell_tests; /* number of tests of a cell against a plane; for benches and tests */
} cull_list;

static inline void cull_list_finish(cull_list *list)
{
	free(list->items);
	free(list->families);
	*list = (cull_list){0};
}

struct stilb_cull_octree {
	const cull_kernels *kernels;
	double low[3]; /* the root's low corner */
	double size;   /* the root's side */
	uint32_t max_depth;

	cull_cell *cells; /* [cell_count], of which 8 * family_count are in the tree */
	float *reach;     /* [cell_count] upper bound of the radii in the cell and below it, without the root's own objects;
	                     -infinity for vacant cells, so that every plane rejects them */
	uint32_t cell_count, cell_capacity, family_count;
	uint32_t free_family; /* first cell of the first free family, or CULL_NONE */

	cull_place *places; /* [place_capacity] by object id */
	uint32_t place_capacity;

	cull_list list; /* of stilb_cull_octree_mark */
};

struct stilb_cull {
	const cull_kernels *kernels;
	stilb_cull_octree *octree;
	uint32_t model_count;
	uint32_t serial_below;    /* CULL_SERIAL_BELOW; tests change it */
	uint64_t rebuild_models;  /* a new octree is made when this one holds more models, */
	uint64_t rebuild_outside; /* or more of them lie outside its root cell */
	stilb_owner caller;       /* the thread inside a [one-writer] call; nobody between calls */
};

/* Moves an array of count elements, `element` bytes each, to new memory for `capacity` elements, and frees the old one.
 * NULL: no memory, the array is as before. */
void *cull_grow(void *array, size_t count, size_t capacity, size_t element);

/* The cell for these bounds: the smallest whose loose bounds hold every sphere of that radius with its centre in the
 * cell. Bounds that fit into no cell belong to the root: centres outside it, radii that are negative, larger than half
 * its side or infinite, and NaN. */
cull_cell_name cull_octree_name(const stilb_cull_octree *octree, stilb_sphere bounds);

/* True for bounds that no view sees because of a NaN: those of a model that is hidden or removed. */
bool cull_is_absent(stilb_sphere bounds);

/* Inserts an object, or moves it if it is in the tree; removes it if its bounds are absent. STILB_ERROR_MEMORY: it
 * keeps its old bounds. */
stilb_result cull_octree_put(stilb_cull_octree *octree, uint32_t id, stilb_sphere bounds);

/* The side of cells at this depth, and the centre of one; metres. */
double cull_octree_cell_size(const stilb_cull_octree *octree, uint32_t depth);
void cull_octree_cell_center(const stilb_cull_octree *octree, cull_cell_name name, double center[3]);

/* True if the root lies wholly inside all planes and has no objects of its own: then every object is visible. */
bool cull_octree_inside(const stilb_cull_octree *octree, const stilb_frustum *frustum);

/* Fills list->items with all objects that the frustum may see. */
stilb_result cull_octree_walk(const stilb_cull_octree *octree, cull_list *list, const stilb_frustum *frustum,
                              cull_walk_result *result);

/* Sets the bits of the visible objects of items begin .. end - 1, which the walk has made for the same frustum. */
void cull_octree_mark(const stilb_cull_octree *octree, const cull_list *list, uint32_t begin, uint32_t end,
                      const stilb_frustum *frustum, uint64_t *bits);

/* Checks the whole octree: every object is in the cell that its bounds name and inside that cell's loose bounds;
 * counts, reaches, places and the free list are right. NULL: it is sound; else the first fault found. */
const char *cull_octree_check(const stilb_cull_octree *octree);

/* The root cube and the depth that stilb_cull_create uses for a scene. */
stilb_cull_octree_desc cull_desc_for_scene(const stilb_scene *scene);

#endif
