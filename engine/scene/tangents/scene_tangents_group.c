/* Which triangles lie along which edges, and which of those around a vertex share a tangent. */
#include "scene/tangents/scene_tangents_internal.h"

#include <stdlib.h>
#include <string.h>

/* Edges that wait for one in the opposite direction, as a queue for each vertex at their higher end: all edges of one
 * lower end are matched before those of the next. The edges of a queue have one direction. */
typedef struct group_edges {
	uint32_t *first;   /* [vertex_count + 1] edges with lower end v: sorted[first[v]] .. */
	uint32_t *sorted;  /* [corner_count] ascending for each lower end: in the order of the indices */
	uint32_t *waiting; /* [vertex_count] the head of the queue, or NONE */
	uint32_t *last;    /* [vertex_count] its tail */
	uint32_t *behind;  /* [corner_count] the next edge of the same queue, or NONE */
} group_edges;

static bool group_is_edge(const scene_tangents_work *work, uint32_t corner)
{
	return (work->flags[corner / 3] & SCENE_TANGENTS_DEGENERATE) == 0;
}

/* The ends of an edge, the lower one first. True: it begins there. */
static bool group_ends(const scene_tangents_work *work, uint32_t edge, uint32_t *lower, uint32_t *higher)
{
	uint32_t from = work->corners[edge], to = work->corners[scene_tangents_next(edge)];
	*lower = from < to ? from : to;
	*higher = from < to ? to : from;
	return from < to;
}

static void group_sort_edges(const scene_tangents_work *work, group_edges *edges)
{
	uint32_t lower, higher;
	memset(edges->first, 0, ((size_t)work->vertex_count + 1) * sizeof *edges->first);
	for (uint32_t c = 0; c < work->corner_count; c++)
		if (group_is_edge(work, c)) {
			group_ends(work, c, &lower, &higher);
			edges->first[lower]++;
		}
	uint32_t sum = 0;
	for (uint32_t v = 0; v <= work->vertex_count; v++) {
		uint32_t count = edges->first[v];
		edges->first[v] = sum;
		sum += count;
	}
	for (uint32_t c = 0; c < work->corner_count; c++)
		if (group_is_edge(work, c)) {
			group_ends(work, c, &lower, &higher);
			edges->sorted[edges->first[lower]++] = c;
		}
	/* Each entry is now where the next one began. */
	memmove(edges->first + 1, edges->first, (size_t)work->vertex_count * sizeof *edges->first);
	edges->first[0] = 0;
}

/* Joins an edge with the first that waits for it, or lets it wait. */
static void group_meet(scene_tangents_work *work, group_edges *edges, uint32_t edge)
{
	uint32_t lower, higher, other_lower, other_higher;
	bool upwards = group_ends(work, edge, &lower, &higher);
	uint32_t head = edges->waiting[higher];
	if (head != SCENE_TANGENTS_NONE && group_ends(work, head, &other_lower, &other_higher) != upwards) {
		edges->waiting[higher] = edges->behind[head];
		work->mates[head] = edge;
		work->mates[edge] = head;
		return;
	}
	edges->behind[edge] = SCENE_TANGENTS_NONE;
	if (head == SCENE_TANGENTS_NONE)
		edges->waiting[higher] = edge;
	else
		edges->behind[edges->last[higher]] = edge;
	edges->last[higher] = edge;
}

static void group_match_all(scene_tangents_work *work, group_edges *edges)
{
	memset(edges->waiting, 0xff, work->vertex_count * sizeof *edges->waiting);
	for (uint32_t v = 0; v < work->vertex_count; v++) {
		uint32_t begin = edges->first[v], end = edges->first[v + 1];
		for (uint32_t i = begin; i < end; i++)
			group_meet(work, edges, edges->sorted[i]);
		for (uint32_t i = begin; i < end; i++) {
			uint32_t lower, higher;
			group_ends(work, edges->sorted[i], &lower, &higher);
			edges->waiting[higher] = SCENE_TANGENTS_NONE;
		}
	}
}

bool scene_tangents_match(scene_tangents_work *work)
{
	size_t vertices = work->vertex_count, corners = work->corner_count;
	group_edges edges = {
		.first = stilb_memory_alloc(vertices + 1, sizeof *edges.first),
		.sorted = stilb_memory_alloc(corners, sizeof *edges.sorted),
		.waiting = stilb_memory_alloc(vertices, sizeof *edges.waiting),
		.last = stilb_memory_alloc(vertices, sizeof *edges.last),
		.behind = stilb_memory_alloc(corners, sizeof *edges.behind),
	};
	work->mates = stilb_memory_alloc(corners, sizeof *work->mates);
	bool good = edges.first && edges.sorted && edges.waiting && edges.last && edges.behind && work->mates;
	if (good) {
		memset(work->mates, 0xff, corners * sizeof *work->mates);
		group_sort_edges(work, &edges);
		group_match_all(work, &edges);
	}
	free(edges.first);
	free(edges.sorted);
	free(edges.waiting);
	free(edges.last);
	free(edges.behind);
	return good;
}

/* Adds a corner to a group that is mapped or mirrored. False: it is in one already, or of the other kind. A triangle
 * that goes with any takes the kind of the first group that comes to one of its corners. */
static bool group_join(scene_tangents_work *work, uint32_t corner, bool mapped)
{
	const uint32_t *groups = work->groups + corner / 3 * (size_t)3;
	uint8_t *flags = &work->flags[corner / 3];
	if (work->groups[corner] != SCENE_TANGENTS_NONE)
		return false;
	if ((*flags & SCENE_TANGENTS_ANY) != 0 && groups[0] == SCENE_TANGENTS_NONE && groups[1] == SCENE_TANGENTS_NONE &&
	    groups[2] == SCENE_TANGENTS_NONE)
		*flags = SCENE_TANGENTS_ANY | (mapped ? SCENE_TANGENTS_MAPPED : 0);
	if (((*flags & SCENE_TANGENTS_MAPPED) != 0) != mapped)
		return false;
	work->groups[corner] = work->group_count;
	return true;
}

/* From triangle to triangle around a corner's vertex, over the edges that begin there or over those that end there,
 * until the group ends or the fan is closed. */
static void group_walk(scene_tangents_work *work, uint32_t corner, bool mapped, bool beginning)
{
	for (;;) {
		uint32_t mate = work->mates[beginning ? corner : scene_tangents_before(corner)];
		if (mate == SCENE_TANGENTS_NONE)
			return;
		corner = beginning ? scene_tangents_next(mate) : mate;
		if (!group_join(work, corner, mapped))
			return;
	}
}

bool scene_tangents_group(scene_tangents_work *work)
{
	work->groups = stilb_memory_alloc(work->corner_count, sizeof *work->groups);
	if (!work->groups)
		return false;
	memset(work->groups, 0xff, (size_t)work->corner_count * sizeof *work->groups);
	for (uint32_t c = 0; c < work->corner_count; c++) {
		uint8_t flags = work->flags[c / 3];
		if (work->groups[c] != SCENE_TANGENTS_NONE || (flags & (SCENE_TANGENTS_DEGENERATE | SCENE_TANGENTS_ANY)) != 0)
			continue;
		bool mapped = (flags & SCENE_TANGENTS_MAPPED) != 0;
		work->groups[c] = work->group_count;
		group_walk(work, c, mapped, true);
		group_walk(work, c, mapped, false);
		work->group_count++;
	}
	return true;
}
