/* The octree's invariants, for asserts and tests. */
#include "culling/cull_internal.h"

#include <math.h>

typedef struct cull_check {
	const stilb_cull_octree *octree;
	const char *wrong; /* the first fault, or NULL */
	uint32_t families; /* families of eight siblings found in the tree, the root's included */
} cull_check;

static void cull_check_that(cull_check *check, bool right, const char *wrong)
{
	if (!right && !check->wrong)
		check->wrong = wrong;
}

static void cull_check_object(cull_check *check, uint32_t index, uint32_t slot)
{
	const stilb_cull_octree *octree = check->octree;
	const cull_cell *cell = &octree->cells[index];
	stilb_sphere bounds = {cell->x[slot], cell->y[slot], cell->z[slot], cell->radius[slot]};
	cull_cell_name name = cull_octree_name(octree, bounds);
	uint32_t id = cell->id[slot];
	bool placed =
		id < octree->place_capacity && octree->places[id].cell_plus_one == index + 1 && octree->places[id].slot == slot;
	cull_check_that(check, placed, "an object's place names another slot");
	cull_check_that(check, name.depth == cell->name.depth, "an object is at the wrong depth");
	if (index == CULL_ROOT)
		return; /* may hold any bounds */
	double center[3], at[3] = {(double)bounds.x, (double)bounds.y, (double)bounds.z};
	double half = cull_octree_cell_size(octree, name.depth) * 0.5, rounding = 1.0 + 0x1p-20;
	cull_octree_cell_center(octree, cell->name, center);
	for (int axis = 0; axis < 3; axis++) {
		double offset = fabs(at[axis] - center[axis]), radius = (double)bounds.radius;
		cull_check_that(check, name.position[axis] == cell->name.position[axis], "an object is in the wrong cell");
		cull_check_that(check, offset <= half * rounding, "an object's centre is outside its cell");
		cull_check_that(check, offset + radius <= 2.0 * half * rounding, "an object leaves its cell's loose bounds");
	}
}

static float cull_check_cell(cull_check *check, uint32_t index);

/* Checks the children of a cell. Adds their objects to *count and returns the greatest radius among them. */
static float cull_check_family(cull_check *check, uint32_t parent, uint32_t *count)
{
	const stilb_cull_octree *octree = check->octree;
	uint32_t first = octree->cells[parent].children, before = *count;
	float reach = 0.0f;
	check->families++;
	cull_check_that(check, first % CULL_CHILDREN == 0 && first < octree->cell_count, "a family is not aligned");
	for (uint32_t octant = 0; octant < CULL_CHILDREN; octant++) {
		const cull_cell *child = &octree->cells[first + octant];
		const cull_cell_name *name = &child->name;
		uint32_t bits = (name->position[0] & 1u) | (name->position[1] & 1u) << 1 | (name->position[2] & 1u) << 2;
		cull_check_that(check, child->parent == parent, "a cell names another parent");
		cull_check_that(check, name->depth == octree->cells[parent].name.depth + 1 && bits == octant,
		                "a cell has the wrong name");
		reach = fmaxf(reach, cull_check_cell(check, first + octant));
		*count += child->subtree_count;
	}
	cull_check_that(check, *count > before, "an empty family is in the tree");
	return reach;
}

/* Checks a cell and all cells below it; returns the greatest radius among their objects. */
static float cull_check_cell(cull_check *check, uint32_t index)
{
	const cull_cell *cell = &check->octree->cells[index];
	uint32_t count = cell->count;
	float reach = 0.0f, known = check->octree->reach[index];
	for (uint32_t slot = 0; slot < cell->count; slot++) {
		cull_check_object(check, index, slot);
		if (index != CULL_ROOT)
			reach = fmaxf(reach, cell->radius[slot]);
	}
	if (cell->children != CULL_NONE)
		reach = fmaxf(reach, cull_check_family(check, index, &count));
	cull_check_that(check, count == cell->subtree_count, "a subtree's count is wrong");
	cull_check_that(check, cell->name.depth <= check->octree->max_depth, "a cell is too deep");
	if (count > 0 || index == CULL_ROOT)
		cull_check_that(check, known >= reach, "a radius is greater than its cell's reach");
	else
		cull_check_that(check, known == -INFINITY && cell->children == CULL_NONE, "an empty cell is not vacant");
	return reach;
}

const char *cull_octree_check(const stilb_cull_octree *octree)
{
	cull_check check = {.octree = octree, .families = 1}; /* the root's */
	uint32_t placed = 0, free_families = 0;
	cull_check_cell(&check, CULL_ROOT);
	for (uint32_t id = 0; id < octree->place_capacity; id++)
		placed += octree->places[id].cell_plus_one != 0;
	for (uint32_t first = octree->free_family; first != CULL_NONE && free_families <= octree->cell_count;
	     first = octree->cells[first].parent)
		free_families++;
	cull_check_that(&check, placed == octree->cells[CULL_ROOT].subtree_count, "places and objects differ in number");
	cull_check_that(&check, check.families == octree->family_count, "the count of families is wrong");
	cull_check_that(&check, (check.families + free_families) * CULL_CHILDREN == octree->cell_count, "a family is lost");
	return check.wrong;
}
