/* The steps in their order, and the corners that are in no group. */
#include "scene/tangents/scene_tangents_internal.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Large enough to matter and finite. Smaller numbers are lost to rounding: the bound is that of MikkTSpace. */
static bool tangents_matters(float x)
{
	return fabsf(x) > FLT_MIN && fabsf(x) <= FLT_MAX;
}

static bool tangents_share_position(const scene_tangents_vertex *a, const scene_tangents_vertex *b)
{
	return memcmp(a->position, b->position, sizeof a->position) == 0;
}

/* The derivatives of the position by u and v, equations 18 and 19 of the thesis, times the area on the texture. The
 * order of the operations is that of the public implementation, so that results have the same bits. */
static uint8_t tangents_derive_face(const scene_tangents_vertex *const corner[3], scene_tangents_face *face)
{
	const float *a = corner[0]->uv, *b = corner[1]->uv, *c = corner[2]->uv;
	float bu = b[0] - a[0], bv = b[1] - a[1], cu = c[0] - a[0], cv = c[1] - a[1];
	stilb_vec3 start = scene_tangents_vec3(corner[0]->position);
	stilb_vec3 ab = scene_tangents_vec3(corner[1]->position) - start;
	stilb_vec3 ac = scene_tangents_vec3(corner[2]->position) - start;
	float area = bu * cv - bv * cu;
	stilb_vec3 u = ab * cv - ac * bv, v = ab * -cu + ac * bu;
	float u_length = sqrtf(stilb_vec3_dot(u, u)), v_length = sqrtf(stilb_vec3_dot(v, v));
	uint8_t mapped = area > 0.0f ? SCENE_TANGENTS_MAPPED : 0;
	if (!tangents_matters(area) || !tangents_matters(u_length) || !tangents_matters(v_length))
		return mapped | SCENE_TANGENTS_ANY;
	float sign = mapped != 0 ? 1.0f : -1.0f;
	for (int i = 0; i < 3; i++) {
		face->u[i] = sign / u_length * u[i];
		face->v[i] = sign / v_length * v[i];
	}
	return mapped;
}

bool scene_tangents_derive(scene_tangents_work *work)
{
	uint32_t count = work->corner_count / 3;
	work->flags = stilb_memory_alloc(count, sizeof *work->flags);
	work->faces = stilb_memory_alloc(count, sizeof *work->faces);
	if (!work->flags || !work->faces)
		return false;
	for (uint32_t f = 0; f < count; f++) {
		const uint32_t *ids = work->corners + 3 * (size_t)f;
		const scene_tangents_vertex *corner[3];
		for (int i = 0; i < 3; i++)
			corner[i] = &work->vertices[ids[i]];
		work->faces[f] = (scene_tangents_face){0};
		if (tangents_share_position(corner[0], corner[1]) || tangents_share_position(corner[1], corner[2]) ||
		    tangents_share_position(corner[2], corner[0]))
			work->flags[f] = SCENE_TANGENTS_DEGENERATE;
		else
			work->flags[f] = tangents_derive_face(corner, &work->faces[f]);
	}
	return true;
}

/* Step 5. */
static bool tangents_inherit(const scene_tangents_work *work, float (*tangents)[4])
{
	uint32_t *first = stilb_memory_alloc(work->vertex_count, sizeof *first);
	if (!first)
		return false;
	memset(first, 0xff, work->vertex_count * sizeof *first);
	for (uint32_t c = 0; c < work->corner_count; c++)
		if ((work->flags[c / 3] & SCENE_TANGENTS_DEGENERATE) == 0) {
			uint32_t v = work->corners[c];
			if (work->groups[c] == SCENE_TANGENTS_NONE)
				scene_tangents_write(scene_tangents_vec3(work->vertices[v].normal), stilb_vec3_make(0, 0, 0), false,
				                     tangents[c]);
			if (first[v] == SCENE_TANGENTS_NONE)
				first[v] = c;
		}
	for (uint32_t c = 0; c < work->corner_count; c++)
		if ((work->flags[c / 3] & SCENE_TANGENTS_DEGENERATE) != 0) {
			uint32_t v = work->corners[c];
			if (first[v] != SCENE_TANGENTS_NONE)
				memcpy(tangents[c], tangents[first[v]], sizeof tangents[c]);
			else
				scene_tangents_write(scene_tangents_vec3(work->vertices[v].normal), stilb_vec3_make(0, 0, 0), false,
				                     tangents[c]);
		}
	free(first);
	return true;
}

static void tangents_finish(scene_tangents_work *work)
{
	free(work->corners);
	free(work->vertices);
	free(work->flags);
	free(work->faces);
	free(work->mates);
	free(work->groups);
}

stilb_result scene_tangents_make(const scene_tangents_mesh *mesh, float (*tangents)[4])
{
	STILB_ASSERT(mesh && (tangents || mesh->index_count == 0));
	STILB_ASSERT(mesh->index_count % 3 == 0 && "a list of triangles");
	STILB_ASSERT(mesh->index_count == 0 || (mesh->positions && mesh->normals && mesh->uvs && mesh->indices));
	STILB_ASSERT(mesh->position_stride % 4 == 0 && mesh->normal_stride % 4 == 0 && mesh->uv_stride % 4 == 0);
	if (mesh->index_count == 0)
		return STILB_OK;
	scene_tangents_work work = {.corner_count = mesh->index_count};
	bool good = scene_tangents_weld(mesh, &work) && scene_tangents_derive(&work) && scene_tangents_match(&work) &&
	            scene_tangents_group(&work) && scene_tangents_sum(&work, tangents) && tangents_inherit(&work, tangents);
	tangents_finish(&work);
	return good ? STILB_OK
	            : stilb_fail(STILB_ERROR_MEMORY, "no memory for the tangents of %u triangles", mesh->index_count / 3);
}
