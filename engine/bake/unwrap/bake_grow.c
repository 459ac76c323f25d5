/*
 * bake_grow: charts grow from the first triangle that has none, the neighbour that leans least off the chart's mean
 * normal first. Then charts take in neighbours, from the smallest on, where one cone still holds both. All in the order
 * of numbers: the result depends on the mesh alone.
 */
#include "bake/unwrap/bake_grow.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MERGE_ROUNDS 8
/* A chart whose area is less than this share of a neighbour's may lean more: */
#define SCRAP 0.02
#define SCRAP_CONE 1.4 /* radians */

static double dot3(const double a[3], const double b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* ---- a heap of triangles, the least cost on top, of equal ones the lower number ---------------------------------- */

typedef struct grow_candidate {
	float cost;
	uint32_t triangle;
} grow_candidate;

typedef struct grow_heap {
	grow_candidate *entries;
	size_t count;
} grow_heap;

static bool candidate_before(grow_candidate a, grow_candidate b)
{
	return a.cost < b.cost || (a.cost == b.cost && a.triangle < b.triangle);
}

static void heap_push(grow_heap *heap, grow_candidate candidate)
{
	size_t at = heap->count++;
	while (at > 0 && candidate_before(candidate, heap->entries[(at - 1) / 2])) {
		heap->entries[at] = heap->entries[(at - 1) / 2];
		at = (at - 1) / 2;
	}
	heap->entries[at] = candidate;
}

static uint32_t heap_pop(grow_heap *heap)
{
	uint32_t top = heap->entries[0].triangle;
	grow_candidate last = heap->entries[--heap->count];
	size_t at = 0;
	for (size_t child; (child = 2 * at + 1) < heap->count; at = child) {
		if (child + 1 < heap->count && candidate_before(heap->entries[child + 1], heap->entries[child]))
			child++;
		if (!candidate_before(heap->entries[child], last))
			break;
		heap->entries[at] = heap->entries[child];
	}
	heap->entries[at] = last;
	return top;
}

/* ---- growth ------------------------------------------------------------------------------------------------------ */

typedef struct grow {
	const bake_topology *topology;
	double cone, crease; /* cosines */
	uint32_t *chart;     /* [triangle_count] */
	grow_heap heap;      /* room for a candidate for each half-edge */
} grow;

/* The neighbour across a half-edge that is no crease; BAKE_NONE: there is none. */
static uint32_t smooth_neighbour(const grow *g, uint32_t half_edge)
{
	uint32_t twin = g->topology->twin[half_edge];
	if (twin == BAKE_NONE || dot3(g->topology->normal[half_edge / 3], g->topology->normal[twin / 3]) < g->crease)
		return BAKE_NONE;
	return twin / 3;
}

/* How far a triangle leans off the direction of `sum`, 0 to 2; less where more of its sides are in the chart already,
 * so that outlines are short. */
static float lean_cost(const grow *g, uint32_t triangle, uint32_t chart, const double sum[3], double length)
{
	int sides = 0;
	for (uint32_t i = 0; i < 3; i++) {
		uint32_t neighbour = smooth_neighbour(g, 3 * triangle + i);
		sides += neighbour != BAKE_NONE && g->chart[neighbour] == chart;
	}
	double lean = 1.0 - dot3(g->topology->normal[triangle], sum) / length;
	return (float)(sides > 1 ? lean * 0.5 : lean);
}

static void grow_one(grow *g, uint32_t seed, uint32_t chart)
{
	double sum[3] = {0.0, 0.0, 0.0};
	g->heap.count = 0;
	heap_push(&g->heap, (grow_candidate){0.0f, seed});
	while (g->heap.count > 0) {
		uint32_t t = heap_pop(&g->heap);
		const double *normal = g->topology->normal[t];
		double length = sqrt(dot3(sum, sum));
		if (g->chart[t] != BAKE_NONE || dot3(normal, sum) < g->cone * length)
			continue;
		g->chart[t] = chart;
		for (int k = 0; k < 3; k++)
			sum[k] += g->topology->area[t] * normal[k];
		length = sqrt(dot3(sum, sum));
		for (uint32_t i = 0; i < 3; i++) {
			uint32_t neighbour = smooth_neighbour(g, 3 * t + i);
			if (neighbour != BAKE_NONE && g->chart[neighbour] == BAKE_NONE)
				heap_push(&g->heap, (grow_candidate){lean_cost(g, neighbour, chart, sum, length), neighbour});
		}
	}
}

/* ---- merging ----------------------------------------------------------------------------------------------------- */

/* A chart, or several that became one: `into` leads to the one that they became. */
typedef struct grow_group {
	double sum[3];     /* of area times normal */
	double axis[3];    /* unit */
	double half_angle; /* radians: of a cone about the axis that holds all normals */
	double area;
	uint32_t into; /* itself, or another one */
} grow_group;

static uint32_t group_root(grow_group *groups, uint32_t group)
{
	while (groups[group].into != group) {
		groups[group].into = groups[groups[group].into].into;
		group = groups[group].into;
	}
	return group;
}

static double angle_between(const double a[3], const double b[3])
{
	return acos(fmin(fmax(dot3(a, b), -1.0), 1.0));
}

static void group_aim(grow_group *group)
{
	double length = sqrt(dot3(group->sum, group->sum));
	for (int k = 0; k < 3; k++)
		group->axis[k] = length > 0.0 ? group->sum[k] / length : 0.0;
}

static void groups_measure(const grow *g, grow_group *groups, uint32_t count)
{
	for (uint32_t c = 0; c < count; c++)
		groups[c] = (grow_group){.into = c};
	for (uint32_t t = 0; t < g->topology->triangle_count; t++)
		if (g->chart[t] != BAKE_NONE) {
			grow_group *group = &groups[g->chart[t]];
			group->area += g->topology->area[t];
			for (int k = 0; k < 3; k++)
				group->sum[k] += g->topology->area[t] * g->topology->normal[t][k];
		}
	for (uint32_t c = 0; c < count; c++)
		group_aim(&groups[c]);
	for (uint32_t t = 0; t < g->topology->triangle_count; t++)
		if (g->chart[t] != BAKE_NONE) {
			grow_group *group = &groups[g->chart[t]];
			group->half_angle = fmax(group->half_angle, angle_between(group->axis, g->topology->normal[t]));
		}
}

/* The two as one, with a cone that holds both cones. */
static grow_group group_union(const grow_group *a, const grow_group *b)
{
	grow_group both = *a;
	both.area += b->area;
	for (int k = 0; k < 3; k++)
		both.sum[k] += b->sum[k];
	group_aim(&both);
	both.half_angle =
		fmax(angle_between(both.axis, a->axis) + a->half_angle, angle_between(both.axis, b->axis) + b->half_angle);
	return both;
}

typedef struct group_order {
	double area;
	uint32_t group;
} group_order;

static int smaller_first(const void *a, const void *b)
{
	const group_order *l = a, *r = b;
	if (l->area != r->area)
		return l->area < r->area ? -1 : 1;
	return l->group < r->group ? -1 : l->group > r->group;
}

/* Triangles chart by chart: those of chart c are list[first[c]] .. list[first[c + 1] - 1]. */
typedef struct group_lists {
	uint32_t *first, *list;
} group_lists;

static void lists_fill(const grow *g, uint32_t count, group_lists *lists)
{
	memset(lists->first, 0, (count + 2) * sizeof *lists->first);
	for (uint32_t t = 0; t < g->topology->triangle_count; t++)
		if (g->chart[t] != BAKE_NONE)
			lists->first[g->chart[t] + 2]++;
	for (uint32_t c = 0; c < count; c++)
		lists->first[c + 2] += lists->first[c + 1];
	for (uint32_t t = 0; t < g->topology->triangle_count; t++)
		if (g->chart[t] != BAKE_NONE)
			lists->list[lists->first[g->chart[t] + 1]++] = t;
}

/* Tries to make one of both; a scrap of the surface is taken in as it is, so that there are no charts of a few texels
 * wherever it is rough. False: they are too different. */
static bool group_join(const grow *g, const grow_group *a, const grow_group *b, grow_group *both)
{
	*both = group_union(a, b);
	if (both->half_angle < acos(g->cone))
		return true;
	const grow_group *small = a->area < b->area ? a : b, *large = a->area < b->area ? b : a;
	double lean = angle_between(large->axis, small->axis) + small->half_angle;
	if (small->area > SCRAP * large->area || lean > SCRAP_CONE)
		return false;
	both->half_angle = fmax(large->half_angle, lean);
	return true;
}

/* The neighbour of chart c that one cone holds best together with it; BAKE_NONE: there is none. Of equal ones the
 * first. */
static uint32_t best_neighbour(const grow *g, grow_group *groups, const group_lists *lists, uint32_t c,
                               grow_group *merged)
{
	uint32_t best = BAKE_NONE, last = BAKE_NONE, self = group_root(groups, c);
	double least = HUGE_VAL;
	for (uint32_t i = lists->first[c]; i < lists->first[c + 1]; i++)
		for (uint32_t side = 0; side < 3; side++) {
			uint32_t neighbour = smooth_neighbour(g, 3 * lists->list[i] + side);
			uint32_t other = neighbour == BAKE_NONE ? self : group_root(groups, g->chart[neighbour]);
			if (other == self || other == last)
				continue;
			last = other;
			grow_group both;
			if (group_join(g, &groups[self], &groups[other], &both) && both.half_angle < least) {
				least = both.half_angle;
				best = other;
				*merged = both;
			}
		}
	return best;
}

/* One round: each chart, from the smallest on, joins its best neighbour. Returns how many did. */
static uint32_t merge_round(const grow *g, grow_group *groups, group_order *order, const group_lists *lists,
                            uint32_t count)
{
	uint32_t merges = 0;
	for (uint32_t c = 0; c < count; c++)
		order[c] = (group_order){groups[c].area, c};
	qsort(order, count, sizeof *order, smaller_first);
	for (uint32_t i = 0; i < count; i++) {
		grow_group both;
		uint32_t c = order[i].group, other = best_neighbour(g, groups, lists, c, &both);
		if (other == BAKE_NONE)
			continue;
		uint32_t self = group_root(groups, c);
		both.into = other;
		groups[self].into = other;
		groups[other] = both;
		merges++;
	}
	return merges;
}

/* Gives charts the numbers of what they became, in the order of their first triangles. Returns how many there are. */
static uint32_t groups_apply(const grow *g, grow_group *groups, uint32_t *number, uint32_t count)
{
	uint32_t used = 0;
	memset(number, 0xff, (count + 1) * sizeof *number);
	for (uint32_t t = 0; t < g->topology->triangle_count; t++) {
		if (g->chart[t] == BAKE_NONE)
			continue;
		uint32_t root = group_root(groups, g->chart[t]);
		if (number[root] == BAKE_NONE)
			number[root] = used++;
		g->chart[t] = number[root];
	}
	return used;
}

static bool merge_charts(const grow *g, uint32_t *chart_count)
{
	uint32_t count = *chart_count;
	grow_group *groups = stilb_memory_alloc(count, sizeof *groups);
	group_order *order = stilb_memory_alloc(count, sizeof *order);
	group_lists lists = {stilb_memory_alloc((size_t)count + 2, sizeof *lists.first),
	                     stilb_memory_alloc(g->topology->triangle_count, sizeof *lists.list)};
	bool good = groups && order && lists.first && lists.list;
	for (int round = 0; round < MERGE_ROUNDS && good; round++) {
		groups_measure(g, groups, count);
		lists_fill(g, count, &lists);
		if (merge_round(g, groups, order, &lists, count) == 0)
			break;
		count = groups_apply(g, groups, lists.first, count);
	}
	free(groups);
	free(order);
	free(lists.first);
	free(lists.list);
	*chart_count = count;
	return good;
}

stilb_result bake_grow(const bake_topology *topology, const stilb_bake_unwrap_options *options, uint32_t *chart,
                       uint32_t *chart_count)
{
	uint32_t count = topology->triangle_count;
	grow g = {.topology = topology, .cone = cos((double)options->cone), .crease = cos((double)options->crease)};
	g.chart = chart;
	g.heap.entries = stilb_memory_alloc(3 * (size_t)count + 1, sizeof *g.heap.entries);
	*chart_count = 0;
	memset(chart, 0xff, count * sizeof *chart);
	for (uint32_t t = 0; t < count && g.heap.entries; t++)
		if (chart[t] == BAKE_NONE && topology->area[t] > 0.0)
			grow_one(&g, t, (*chart_count)++);
	bool good = g.heap.entries && merge_charts(&g, chart_count);
	free(g.heap.entries);
	return good ? STILB_OK : stilb_fail(STILB_ERROR_MEMORY, "out of memory to unwrap %u triangles", count);
}
