/* The loose octree (cull.h): a tree of cubic cells, the objects stored in each cell, and the table that gives for an
 * object's id its cell and its index there (cull_place). */
#include "culling/cull_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define CULL_ROOT_LIMIT 0x1p60 /* metres from the origin; keeps the sums of the float tests from overflow */
#define CULL_FIRST_OBJECTS CULL_WIDTH
#define CULL_FIRST_CELLS 64u

_Static_assert(CULL_FIRST_OBJECTS % CULL_WIDTH == 0 && CULL_FIRST_CELLS % CULL_CHILDREN == 0,
               "capacities are whole vectors and whole families");

void *cull_grow(void *array, size_t count, size_t capacity, size_t element)
{
	STILB_ASSERT(count <= capacity && element > 0 && (array || count == 0));
	void *grown = stilb_memory_alloc(capacity, element);
	if (!grown)
		return NULL;
	if (count)
		memcpy(grown, array, count * element);
	free(array);
	return grown;
}

/* ---- names and places of cells -------------------------------------------------------------------------------- */

double cull_octree_cell_size(const stilb_cull_octree *octree, uint32_t depth)
{
	STILB_ASSERT(depth <= octree->max_depth);
	return octree->size / (double)(1u << depth); /* exact: a division by a power of two */
}

void cull_octree_cell_center(const stilb_cull_octree *octree, cull_cell_name name, double center[3])
{
	double size = cull_octree_cell_size(octree, name.depth);
	STILB_ASSERT((name.position[0] | name.position[1] | name.position[2]) >> name.depth == 0);
	for (int axis = 0; axis < 3; axis++)
		center[axis] = octree->low[axis] + ((double)name.position[axis] + 0.5) * size;
}

cull_cell_name cull_octree_name(const stilb_cull_octree *octree, stilb_sphere bounds)
{
	float center[3] = {bounds.x, bounds.y, bounds.z};
	double radius = (double)bounds.radius, half = octree->size * 0.5;
	double place[3]; /* of the centre, as a fraction of the root's side: [0, 1) inside */
	cull_cell_name name = {0};
	if (!(radius >= 0.0 && radius <= half)) /* also true for NaN */
		return name;
	for (int axis = 0; axis < 3; axis++) {
		place[axis] = ((double)center[axis] - octree->low[axis]) / octree->size;
		if (!(place[axis] >= 0.0 && place[axis] < 1.0))
			return name;
	}
	while (name.depth < octree->max_depth && radius <= half * 0.5) {
		half *= 0.5;
		name.depth++;
	}
	for (int axis = 0; axis < 3; axis++)
		name.position[axis] = (uint32_t)(place[axis] * (double)(1u << name.depth));
	return name;
}

static bool cull_name_equal(cull_cell_name a, cull_cell_name b)
{
	return a.depth == b.depth && a.position[0] == b.position[0] && a.position[1] == b.position[1] &&
	       a.position[2] == b.position[2];
}

/* On the path from the root to the cell `name`: which of its parent's eight children, 0..7, the cell at `depth` is. */
static uint32_t cull_octant(cull_cell_name name, uint32_t depth)
{
	STILB_ASSERT(depth >= 1 && depth <= name.depth);
	uint32_t shift = name.depth - depth;
	return (name.position[0] >> shift & 1u) | (name.position[1] >> shift & 1u) << 1 |
	       (name.position[2] >> shift & 1u) << 2;
}

/* ---- cells ---------------------------------------------------------------------------------------------------- */

/* Makes space for another family, which is eight sibling cells. False: no memory. */
static bool cull_cells_reserve(stilb_cull_octree *octree)
{
	if (octree->cell_count < octree->cell_capacity)
		return true;
	uint32_t capacity = octree->cell_capacity ? octree->cell_capacity * 2 : CULL_FIRST_CELLS;
	cull_cell *cells = stilb_memory_alloc(capacity, sizeof *cells);
	float *reach = stilb_memory_alloc(capacity, sizeof *reach);
	if (!cells || !reach) {
		free(cells);
		free(reach);
		return false;
	}
	if (octree->cell_count) {
		memcpy(cells, octree->cells, octree->cell_count * sizeof *cells);
		memcpy(reach, octree->reach, octree->cell_count * sizeof *reach);
	}
	free(octree->cells);
	free(octree->reach);
	octree->cells = cells;
	octree->reach = reach;
	octree->cell_capacity = capacity;
	return true;
}

/* Takes a family from the free list or the end of the array: the index of the first of eight vacant cells; CULL_NONE:
 * no memory. Cells of the free list keep their blocks of memory. May move octree->cells. */
static uint32_t cull_family_take(stilb_cull_octree *octree)
{
	uint32_t first = octree->free_family;
	STILB_ASSERT(first % CULL_CHILDREN == 0 && (first == CULL_NONE || first < octree->cell_count));
	if (first != CULL_NONE) {
		octree->free_family = octree->cells[first].parent;
		return first;
	}
	if (!cull_cells_reserve(octree))
		return CULL_NONE;
	first = octree->cell_count;
	octree->cell_count += CULL_CHILDREN;
	for (uint32_t i = 0; i < CULL_CHILDREN; i++) {
		octree->cells[first + i] = (cull_cell){0};
		octree->reach[first + i] = -INFINITY;
	}
	return first;
}

/* Gives a cell its eight children. False: no memory. */
static bool cull_family_make(stilb_cull_octree *octree, uint32_t parent)
{
	STILB_ASSERT(octree->cells[parent].children == CULL_NONE && octree->cells[parent].name.depth < octree->max_depth);
	uint32_t first = cull_family_take(octree);
	if (first == CULL_NONE)
		return false;
	for (uint32_t octant = 0; octant < CULL_CHILDREN; octant++) {
		cull_cell *cell = &octree->cells[first + octant];
		cell->parent = parent;
		cell->name = octree->cells[parent].name;
		cell->name.depth++;
		for (int axis = 0; axis < 3; axis++)
			cell->name.position[axis] = cell->name.position[axis] * 2 + (octant >> axis & 1u);
	}
	octree->cells[parent].children = first;
	octree->family_count++;
	return true;
}

static bool cull_family_vacant(const stilb_cull_octree *octree, uint32_t first)
{
	for (uint32_t i = 0; i < CULL_CHILDREN; i++)
		if (octree->cells[first + i].subtree_count)
			return false;
	return true;
}

/* Walks from a cell towards the root as long as cells are empty: makes them vacant, and moves families that are wholly
 * vacant from the tree to the free list. */
static void cull_cell_prune(stilb_cull_octree *octree, uint32_t index)
{
	while (index != CULL_ROOT && octree->cells[index].subtree_count == 0) {
		uint32_t first = index - index % CULL_CHILDREN, parent = octree->cells[index].parent;
		STILB_ASSERT(octree->cells[index].count == 0 && octree->cells[parent].children == first);
		octree->reach[index] = -INFINITY;
		if (!cull_family_vacant(octree, first))
			return;
		octree->cells[parent].children = CULL_NONE;
		octree->cells[first].parent = octree->free_family;
		octree->free_family = first;
		octree->family_count--;
		index = parent;
	}
}

/* Makes space for one more object. False: no memory. */
static bool cull_cell_reserve(cull_cell *cell)
{
	STILB_ASSERT(cell->count <= cell->capacity && cell->capacity % CULL_WIDTH == 0);
	if (cell->count < cell->capacity)
		return true;
	uint32_t capacity = cell->capacity ? cell->capacity * 2 : CULL_FIRST_OBJECTS;
	float *block = stilb_memory_alloc(capacity, 4 * sizeof(float) + sizeof(uint32_t));
	if (!block)
		return false;
	cull_cell old = *cell;
	cell->capacity = capacity;
	cell->x = block;
	cell->y = cell->x + capacity;
	cell->z = cell->y + capacity;
	cell->radius = cell->z + capacity;
	cell->id = (uint32_t *)(cell->radius + capacity);
	if (old.count) {
		memcpy(cell->x, old.x, old.count * sizeof(float));
		memcpy(cell->y, old.y, old.count * sizeof(float));
		memcpy(cell->z, old.z, old.count * sizeof(float));
		memcpy(cell->radius, old.radius, old.count * sizeof(float));
		memcpy(cell->id, old.id, old.count * sizeof(uint32_t));
	}
	free(old.x);
	return true;
}

/* Finds the cell called name, or makes it, and makes space in it for one more object. False: no memory; the tree is as
 * before. */
static bool cull_cell_find(stilb_cull_octree *octree, cull_cell_name name, uint32_t *found)
{
	uint32_t index = CULL_ROOT;
	for (uint32_t depth = 1; depth <= name.depth; depth++) {
		if (octree->cells[index].children == CULL_NONE && !cull_family_make(octree, index)) {
			cull_cell_prune(octree, index);
			return false;
		}
		index = octree->cells[index].children + cull_octant(name, depth);
	}
	if (!cull_cell_reserve(&octree->cells[index])) {
		cull_cell_prune(octree, index);
		return false;
	}
	STILB_ASSERT(cull_name_equal(octree->cells[index].name, name));
	*found = index;
	return true;
}

/* ---- objects -------------------------------------------------------------------------------------------------- */

static void cull_cell_store(cull_cell *cell, uint32_t slot, stilb_sphere bounds)
{
	STILB_ASSERT(slot < cell->count);
	cell->x[slot] = bounds.x;
	cell->y[slot] = bounds.y;
	cell->z[slot] = bounds.z;
	cell->radius[slot] = bounds.radius;
}

/* Raises the reach of a cell and of all cells above it to at least radius. The root's own objects are left out of its
 * reach: they are always tested one by one, and may have any radius. */
static void cull_octree_widen(stilb_cull_octree *octree, uint32_t index, float radius)
{
	if (index == CULL_ROOT)
		return;
	STILB_ASSERT(radius >= 0.0f && (double)radius <= octree->size * 0.5);
	while (octree->reach[index] < radius) {
		octree->reach[index] = radius;
		if (index == CULL_ROOT)
			break;
		index = octree->cells[index].parent;
	}
}

/* Adds delta, 1 or -1, to the subtree counts of a cell and of all cells above it. */
static void cull_octree_count(stilb_cull_octree *octree, uint32_t index, int32_t delta)
{
	for (;;) {
		STILB_ASSERT(delta > 0 || octree->cells[index].subtree_count > 0);
		octree->cells[index].subtree_count += (uint32_t)delta;
		if (index == CULL_ROOT)
			return;
		index = octree->cells[index].parent;
	}
}

static void cull_octree_add(stilb_cull_octree *octree, uint32_t index, uint32_t id, stilb_sphere bounds)
{
	cull_cell *cell = &octree->cells[index];
	STILB_ASSERT(cell->count < cell->capacity && id < octree->place_capacity);
	uint32_t slot = cell->count++;
	cull_cell_store(cell, slot, bounds);
	cell->id[slot] = id;
	octree->places[id] = (cull_place){index + 1, slot};
	cull_octree_widen(octree, index, bounds.radius);
	cull_octree_count(octree, index, 1);
}

/* Takes an object out of its cell: the cell's last object moves into its slot. */
static void cull_octree_take_out(stilb_cull_octree *octree, cull_place place)
{
	uint32_t index = place.cell_plus_one - 1;
	cull_cell *cell = &octree->cells[index];
	STILB_ASSERT(index < octree->cell_count && place.slot < cell->count);
	uint32_t last = --cell->count;
	if (place.slot != last) {
		stilb_sphere bounds = {cell->x[last], cell->y[last], cell->z[last], cell->radius[last]};
		cull_cell_store(cell, place.slot, bounds);
		cell->id[place.slot] = cell->id[last];
		octree->places[cell->id[last]].slot = place.slot;
	}
	cull_octree_count(octree, index, -1);
	cull_cell_prune(octree, index);
}

/* The place of an object; {0}: it is not in the tree. */
static cull_place cull_octree_place(const stilb_cull_octree *octree, uint32_t id)
{
	return id < octree->place_capacity ? octree->places[id] : (cull_place){0};
}

/* Makes the table of places long enough for id. False: no memory. */
static bool cull_places_reserve(stilb_cull_octree *octree, uint32_t id)
{
	if (id < octree->place_capacity)
		return true;
	uint32_t capacity = octree->place_capacity ? octree->place_capacity : 1024u;
	while (capacity <= id)
		capacity *= 2; /* at most 2^31, as id is below that */
	cull_place *places = cull_grow(octree->places, octree->place_capacity, capacity, sizeof *places);
	if (!places)
		return false;
	memset(places + octree->place_capacity, 0, (capacity - octree->place_capacity) * sizeof *places);
	octree->places = places;
	octree->place_capacity = capacity;
	return true;
}

/* ---- public --------------------------------------------------------------------------------------------------- */

/* True if all members are in their ranges; false for NaN. */
static bool cull_desc_valid(const stilb_cull_octree_desc *desc)
{
	bool valid = desc->half_size > 0.0f && desc->max_depth <= CULL_MAX_DEPTH;
	for (int axis = 0; axis < 3; axis++)
		valid = valid && fabs((double)desc->center[axis]) + (double)desc->half_size <= CULL_ROOT_LIMIT;
	return valid;
}

stilb_result stilb_cull_octree_create(const stilb_cull_octree_desc *desc, stilb_cull_octree **out)
{
	STILB_ASSERT(desc && out);
	*out = NULL;
	if (!cull_desc_valid(desc))
		return stilb_fail(
			STILB_ERROR_ARGUMENT,
			"octree: half size %g and depth %u refused; the root must lie within 2^60 m, with a half size "
			"above 0 and at most %u levels",
			(double)desc->half_size, desc->max_depth, CULL_MAX_DEPTH);
	stilb_isa isa;
	stilb_result result = stilb_cpu_isa(&isa);
	if (result != STILB_OK)
		return result;
	stilb_cull_octree *octree = stilb_memory_alloc(1, sizeof *octree);
	if (!octree)
		return stilb_fail(STILB_ERROR_MEMORY, "octree: no memory");
	*octree = (stilb_cull_octree){
		.kernels = cull_kernels_for(isa), .size = 2.0 * (double)desc->half_size, .max_depth = desc->max_depth};
	for (int axis = 0; axis < 3; axis++)
		octree->low[axis] = (double)desc->center[axis] - (double)desc->half_size;
	if (!cull_cells_reserve(octree)) {
		stilb_cull_octree_destroy(octree);
		return stilb_fail(STILB_ERROR_MEMORY, "octree: no memory for its cells");
	}
	cull_family_take(octree); /* the root's, at index 0 */
	octree->reach[CULL_ROOT] = 0.0f;
	octree->family_count = 1;
	*out = octree;
	return STILB_OK;
}

void stilb_cull_octree_destroy(stilb_cull_octree *octree)
{
	if (!octree)
		return;
	for (uint32_t index = 0; index < octree->cell_count; index++)
		free(octree->cells[index].x);
	free(octree->cells);
	free(octree->reach);
	free(octree->places);
	cull_list_finish(&octree->list);
	free(octree);
}

stilb_result stilb_cull_octree_insert(stilb_cull_octree *octree, uint32_t id, stilb_sphere bounds)
{
	uint32_t index;
	if (id >= 1u << 31 || cull_octree_place(octree, id).cell_plus_one)
		return stilb_fail(STILB_ERROR_ARGUMENT, "octree: object %u is in the tree already, or not below 2^31", id);
	if (!cull_places_reserve(octree, id) || !cull_cell_find(octree, cull_octree_name(octree, bounds), &index))
		return stilb_fail(STILB_ERROR_MEMORY, "octree: no memory for object %u", id);
	cull_octree_add(octree, index, id, bounds);
	return STILB_OK;
}

/* Moves an object of the tree to the cell called name. */
static stilb_result cull_octree_move_to(stilb_cull_octree *octree, uint32_t id, cull_cell_name name,
                                        stilb_sphere bounds)
{
	uint32_t index;
	cull_place place = cull_octree_place(octree, id);
	if (!cull_cell_find(octree, name, &index))
		return stilb_fail(STILB_ERROR_MEMORY, "octree: no memory to move object %u", id);
	cull_octree_add(octree, index, id, bounds); /* before take_out, so that pruning cannot take the new cell */
	cull_octree_take_out(octree, place);
	return STILB_OK;
}

/* True if the object is in the cell called name, and has been given these bounds in its place there. */
static inline bool cull_octree_move_within(stilb_cull_octree *octree, uint32_t id, cull_cell_name name,
                                           stilb_sphere bounds)
{
	cull_place place = cull_octree_place(octree, id);
	if (!place.cell_plus_one || !cull_name_equal(octree->cells[place.cell_plus_one - 1].name, name))
		return false;
	cull_cell_store(&octree->cells[place.cell_plus_one - 1], place.slot, bounds);
	cull_octree_widen(octree, place.cell_plus_one - 1, bounds.radius);
	return true;
}

stilb_result stilb_cull_octree_move(stilb_cull_octree *octree, uint32_t id, stilb_sphere bounds)
{
	if (!cull_octree_place(octree, id).cell_plus_one)
		return stilb_fail(STILB_ERROR_ARGUMENT, "octree: object %u is not in the tree; insert it first", id);
	cull_cell_name name = cull_octree_name(octree, bounds);
	return cull_octree_move_within(octree, id, name, bounds) ? STILB_OK : cull_octree_move_to(octree, id, name, bounds);
}

bool cull_is_absent(stilb_sphere bounds)
{
	return isnan(bounds.x) || isnan(bounds.y) || isnan(bounds.z) || isnan(bounds.radius);
}

/* The cases of cull_octree_put that are not a move within a cell. */
__attribute__((noinline)) static stilb_result cull_octree_put_anew(stilb_cull_octree *octree, uint32_t id,
                                                                   stilb_sphere bounds)
{
	if (cull_is_absent(bounds))
		stilb_cull_octree_remove(octree, id);
	else if (cull_octree_place(octree, id).cell_plus_one)
		return stilb_cull_octree_move(octree, id, bounds);
	else
		return stilb_cull_octree_insert(octree, id, bounds);
	return STILB_OK;
}

stilb_result cull_octree_put(stilb_cull_octree *octree, uint32_t id, stilb_sphere bounds)
{
	cull_cell_name name = cull_octree_name(octree, bounds); /* the root if bounds are absent */
	if (name.depth > 0 && cull_octree_move_within(octree, id, name, bounds))
		return STILB_OK;
	return cull_octree_put_anew(octree, id, bounds);
}

void stilb_cull_octree_remove(stilb_cull_octree *octree, uint32_t id)
{
	cull_place place = cull_octree_place(octree, id);
	if (!place.cell_plus_one)
		return;
	STILB_ASSERT(octree->cells[place.cell_plus_one - 1].id[place.slot] == id);
	octree->places[id] = (cull_place){0};
	cull_octree_take_out(octree, place);
}
