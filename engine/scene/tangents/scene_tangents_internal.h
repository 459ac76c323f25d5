/* What the steps of scene_tangents pass on to each other. */
#ifndef SCENE_TANGENTS_INTERNAL_H
#define SCENE_TANGENTS_INTERNAL_H

#include "base/base_math.h"
#include "scene/tangents/scene_tangents.h"

#define SCENE_TANGENTS_NONE UINT32_MAX

/* Triangles at a vertex up to which directions are compared with each other (step 4). */
#define SCENE_TANGENTS_MOST_PAIRED 4096u

/* A vertex, and one key: equal floats have equal bits, since -0 was made 0. NaN is like any other number. */
typedef struct scene_tangents_vertex {
	float position[3], normal[3], uv[2];
} scene_tangents_vertex;

enum {
	SCENE_TANGENTS_DEGENERATE = 1, /* two corners share a position */
	SCENE_TANGENTS_ANY = 2,        /* no direction of its own: it goes with any group */
	SCENE_TANGENTS_MAPPED = 4,     /* its area on the texture is positive: not mirrored, as MikkTSpace counts it */
};

/* The unit directions in which u and v grow on a triangle; zero in ANY ones. */
typedef struct scene_tangents_face {
	float u[3], v[3];
} scene_tangents_face;

/* Corner c belongs to triangle c / 3; edge c begins at it and ends at the triangle's next corner. */
typedef struct scene_tangents_work {
	uint32_t corner_count;
	uint32_t vertex_count;           /* after welding */
	uint32_t *corners;               /* [corner_count] vertices */
	scene_tangents_vertex *vertices; /* [vertex_count] in the order in which the corners come to them */
	uint8_t *flags;                  /* [corner_count / 3] */
	scene_tangents_face *faces;      /* [corner_count / 3] */
	uint32_t *mates;                 /* [corner_count] the edge that runs along this one backwards, or NONE */
	uint32_t *groups;                /* [corner_count] numbers < group_count, or NONE */
	uint32_t group_count;
} scene_tangents_work;

static inline uint32_t scene_tangents_next(uint32_t corner)
{
	return corner % 3 == 2 ? corner - 2 : corner + 1;
}

static inline uint32_t scene_tangents_before(uint32_t corner)
{
	return corner % 3 == 0 ? corner + 2 : corner - 1;
}

static inline stilb_vec3 scene_tangents_vec3(const float v[3])
{
	return stilb_vec3_make(v[0], v[1], v[2]);
}

/* Step 1: fills corners and vertices; normals are then unit or zero. False: no memory, as in those below. */
bool scene_tangents_weld(const scene_tangents_mesh *mesh, scene_tangents_work *work);

/* Step 2: fills flags and faces. */
bool scene_tangents_derive(scene_tangents_work *work);

/* Step 3: fills mates, then groups. */
bool scene_tangents_match(scene_tangents_work *work);
bool scene_tangents_group(scene_tangents_work *work);

/* Step 4: the tangents of corners that are in a group. */
bool scene_tangents_sum(const scene_tangents_work *work, float (*tangents)[4]);

/* Writes direction `u` and `mapped` as a tangent at a vertex with this normal, unit or zero. */
void scene_tangents_write(stilb_vec3 normal, stilb_vec3 u, bool mapped, float tangent[4]);

#endif
