/* Meshes whose tangents are known: a thousand random ones and four classic ones. Their numbers are made from integers
 * by operations that IEEE 754 rounds in one way, so that they have the same bits on every machine.
 *
 * The last triangle of each shares no vertex with the others. The public implementation of MikkTSpace leaves the last
 * run of its list of edges unsorted, and so may overlook two triangles that share an edge of the last vertices; that
 * triangle is then the last run. */
#ifndef TANGENTS_MESHES_H
#define TANGENTS_MESHES_H

#include "scene/tangents/scene_tangents.h"

#define TANGENTS_MOST_VERTICES 192u
#define TANGENTS_MOST_INDICES 768u

typedef struct tangents_mesh {
	float positions[TANGENTS_MOST_VERTICES][3], normals[TANGENTS_MOST_VERTICES][3], uvs[TANGENTS_MOST_VERTICES][2];
	uint32_t indices[TANGENTS_MOST_INDICES];
	uint32_t vertex_count, index_count;
} tangents_mesh;

/* What scene_tangents reads of it. */
scene_tangents_mesh tangents_view(const tangents_mesh *mesh);

/* Fills *mesh with mesh `seed`: a soup of triangles over few vertices, a patch with mirrored parts, a fan, or sheets
 * that share edges. All have triangles of which two corners are one; patches and fans have triangles without area on
 * the texture; soups and sheets have, too, duplicates of positions and of vertices, -0 beside 0 and zero normals. */
void tangents_random(tangents_mesh *mesh, uint32_t seed);

#define TANGENTS_RANDOM 1000u /* seeds 0 .. 999 */

/* Fills *mesh with a classic one: two mirrored halves of a helmet that share their texture and the seam's vertices; a
 * sphere whose texture has a seam and poles; four squares, plain, mirrored along u, along v and turned, that share
 * edges; a cube. */
typedef enum tangents_classic {
	TANGENTS_HELMET,
	TANGENTS_SPHERE,
	TANGENTS_SQUARES,
	TANGENTS_CUBE,
	TANGENTS_CLASSICS,
} tangents_classic;

void tangents_make_classic(tangents_mesh *mesh, tangents_classic classic);

#endif
