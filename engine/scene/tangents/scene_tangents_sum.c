/* The tangent of a group: the directions of its triangles, weighted by their angles. Sums are formed in the order of
 * the indices and in float, so that results have the bits of the public implementation. */
#include "scene/tangents/scene_tangents_internal.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A triangle of a group, seen from the group's vertex. */
typedef struct sum_member {
	stilb_vec3 u, v; /* projected; unit, or zero */
	float angle;     /* radians */
	bool any;        /* without a direction: the others are zero */
} sum_member;

/* The corners of all groups, and room for the largest. */
typedef struct sum_lists {
	uint32_t *first;   /* [group_count + 1] the corners of group g: corners[first[g]] .., ascending */
	uint32_t *corners; /* [corner_count] */
	sum_member *members;
} sum_lists;

/* v / |v|; zero if v is, or is too large. */
static stilb_vec3 sum_unit(stilb_vec3 v)
{
	float largest = fmaxf(fmaxf(fabsf(v[0]), fabsf(v[1])), fabsf(v[2]));
	if (!(largest > FLT_MIN && largest <= FLT_MAX))
		return stilb_vec3_make(0, 0, 0);
	return stilb_vec3_normalize(v);
}

static stilb_vec3 sum_project(stilb_vec3 v, stilb_vec3 normal)
{
	return sum_unit(v - normal * stilb_vec3_dot(normal, v));
}

static bool sum_is_tangent(stilb_vec3 normal, stilb_vec3 u)
{
	return fabsf(stilb_vec3_dot(u, u) - 1.0f) <= 1e-3f && fabsf(stilb_vec3_dot(normal, u)) <= 1e-3f;
}

void scene_tangents_write(stilb_vec3 normal, stilb_vec3 u, bool mapped, float tangent[4])
{
	if (!sum_is_tangent(normal, u))
		u = sum_project(u, normal);
	if (!sum_is_tangent(normal, u))
		u = sum_project(stilb_vec3_make(1, 0, 0), normal);
	if (!sum_is_tangent(normal, u))
		u = sum_project(stilb_vec3_make(0, 1, 0), normal);
	for (int i = 0; i < 3; i++)
		tangent[i] = u[i]; /* never -0: a sum that is zero is 0 */
	tangent[3] = mapped ? -1.0f : 1.0f;
}

static sum_member sum_read(const scene_tangents_work *work, uint32_t corner)
{
	if ((work->flags[corner / 3] & SCENE_TANGENTS_ANY) != 0)
		return (sum_member){.any = true};
	const scene_tangents_vertex *vertex = &work->vertices[work->corners[corner]];
	const scene_tangents_face *face = &work->faces[corner / 3];
	const float *before = work->vertices[work->corners[scene_tangents_before(corner)]].position;
	const float *next = work->vertices[work->corners[scene_tangents_next(corner)]].position;
	stilb_vec3 normal = scene_tangents_vec3(vertex->normal), here = scene_tangents_vec3(vertex->position);
	stilb_vec3 a = sum_project(scene_tangents_vec3(before) - here, normal);
	stilb_vec3 b = sum_project(scene_tangents_vec3(next) - here, normal);
	float cosine = fminf(fmaxf(stilb_vec3_dot(a, b), -1.0f), 1.0f);
	return (sum_member){
		.u = sum_project(scene_tangents_vec3(face->u), normal),
		.v = sum_project(scene_tangents_vec3(face->v), normal),
		.angle = (float)acos((double)cosine),
	};
}

/* True if no two of the members can be opposite: all are within 75 degrees of the first. */
static bool sum_agrees(const sum_member *members, uint32_t count)
{
	const sum_member *first = members;
	while (first->any)
		first++;
	for (const sum_member *m = first; m < members + count; m++)
		if (!m->any && !(stilb_vec3_dot(first->u, m->u) > 0.26f && stilb_vec3_dot(first->v, m->v) > 0.26f))
			return false;
	return true;
}

static bool sum_is_opposite(const sum_member *a, const sum_member *b)
{
	return stilb_vec3_dot(a->u, b->u) <= -1.0f || stilb_vec3_dot(a->v, b->v) <= -1.0f;
}

/* The sum of all members that are not opposite to `one`; of all if that is NULL. */
static stilb_vec3 sum_of(const sum_member *members, uint32_t count, const sum_member *one)
{
	stilb_vec3 sum = stilb_vec3_make(0, 0, 0);
	for (const sum_member *m = members; m < members + count; m++)
		if (!one || !sum_is_opposite(one, m))
			sum = sum + m->u * m->angle;
	return sum_unit(sum);
}

static void sum_group(const scene_tangents_work *work, const uint32_t *corners, uint32_t count, sum_member *members,
                      float (*tangents)[4])
{
	stilb_vec3 normal = scene_tangents_vec3(work->vertices[work->corners[corners[0]]].normal);
	bool mapped = (work->flags[corners[0] / 3] & SCENE_TANGENTS_MAPPED) != 0;
	for (uint32_t i = 0; i < count; i++)
		members[i] = sum_read(work, corners[i]);
	bool one = count > SCENE_TANGENTS_MOST_PAIRED || sum_agrees(members, count);
	if (one)
		scene_tangents_write(normal, sum_of(members, count, NULL), mapped, tangents[corners[0]]);
	for (uint32_t i = 0; i < count; i++)
		if (!one)
			scene_tangents_write(normal, sum_of(members, count, &members[i]), mapped, tangents[corners[i]]);
		else if (i > 0)
			memcpy(tangents[corners[i]], tangents[corners[0]], sizeof *tangents);
}

/* Sorts the corners by their groups. Returns the size of the largest. */
static uint32_t sum_sort(const scene_tangents_work *work, sum_lists *lists)
{
	memset(lists->first, 0, ((size_t)work->group_count + 1) * sizeof *lists->first);
	for (uint32_t c = 0; c < work->corner_count; c++)
		if (work->groups[c] != SCENE_TANGENTS_NONE)
			lists->first[work->groups[c]]++;
	uint32_t sum = 0, largest = 0;
	for (uint32_t g = 0; g <= work->group_count; g++) {
		uint32_t count = lists->first[g];
		largest = count > largest ? count : largest;
		lists->first[g] = sum;
		sum += count;
	}
	for (uint32_t c = 0; c < work->corner_count; c++)
		if (work->groups[c] != SCENE_TANGENTS_NONE)
			lists->corners[lists->first[work->groups[c]]++] = c;
	/* Each entry is now where the next one began. */
	memmove(lists->first + 1, lists->first, (size_t)work->group_count * sizeof *lists->first);
	lists->first[0] = 0;
	return largest;
}

bool scene_tangents_sum(const scene_tangents_work *work, float (*tangents)[4])
{
	sum_lists lists = {
		.first = stilb_memory_alloc((size_t)work->group_count + 1, sizeof *lists.first),
		.corners = stilb_memory_alloc(work->corner_count, sizeof *lists.corners),
	};
	bool good = lists.first && lists.corners;
	if (good)
		lists.members = stilb_memory_alloc(sum_sort(work, &lists), sizeof *lists.members);
	good = good && lists.members;
	for (uint32_t g = 0; good && g < work->group_count; g++)
		sum_group(work, lists.corners + lists.first[g], lists.first[g + 1] - lists.first[g], lists.members, tangents);
	free(lists.first);
	free(lists.corners);
	free(lists.members);
	return good;
}
