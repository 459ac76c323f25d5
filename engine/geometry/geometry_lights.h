/*
 * geometry_lights: cuts a large mesh that does not move, such as a floor, at the bounds of lights that do not move
 * either, into pieces that few lights reach.
 *
 * Why.       Models have four lights of their own with STILB_RENDER_LIGHTING_COMBINED; a floor has more above it.
 * Cuts.      A light's bounds are the box around its sphere. A piece that more than `enough` lights reach is cut in
 *            two by the plane of one side of one of these boxes: the one that leaves the fewest lights, each half's
 *            counted by its share of the length. A piece stays as it is where no plane leaves fewer, as below a place
 *            that more lights reach, or where all are nearer to an end of the piece than `least`.
 * Surface.   The same: triangles are cut where the plane is, and vertices there have what lies between the ends of the
 *            edge: position, normal (unit again), uv and extras. An edge has the same vertex on both of its sides. A
 *            piece that is cut further than its neighbour has vertices on their border that this one has not, so where
 *            that border is not straight along an axis the two may be a rounding apart.
 * Lost.      Levels, clusters and morphs, which name vertices of the whole.
 * Cost.      For each cut the square of the lights that reach the piece, and its triangles.
 * Threads.   [any-thread]. The pieces have the same bits everywhere.
 * Sources.   Karis, "Deferred rendering 2" (2009): geometry split at the bounds of static lights; the choice of planes
 *            by MacDonald and Booth, "Heuristics for ray tracing using space subdivision" (1990).
 * Example.   A floor under lamps, as so many models as it has pieces:
 *
 *   for (uint32_t l = 0; l < lamp_count; l++)
 *       spheres[l] = stilb_light_bounds_of(&lamps[l]).sphere;
 *   stilb_geometry_lights_desc desc = {.lights = spheres, .light_count = lamp_count, .enough = 4, .least = 0.25f};
 *   stilb_geometry_pieces pieces;
 *   stilb_result result = stilb_geometry_cut_at_lights(&floor, &desc, &pieces);
 *   if (result == STILB_OK) {
 *       stilb_geometry_build_pieces(build, node, material, &pieces);
 *       printf("%u triangles and %u draws more\n", pieces.triangles - floor.index_count / 3, pieces.count - 1);
 *       stilb_geometry_pieces_finish(&pieces);
 *   }
 */
#ifndef STILB_GEOMETRY_LIGHTS_H
#define STILB_GEOMETRY_LIGHTS_H

#include "base/base.h"
#include "base/base_math.h"
#include "scene/scene.h"
#include "scene/scene_build.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

typedef struct stilb_geometry_lights_desc {
	const stilb_sphere *lights; /* [light_count] in the mesh's space; radius INFINITY: everywhere, < 0: nowhere */
	uint32_t light_count;
	uint32_t enough; /* a piece that so many lights reach, or fewer, is cut no more */
	float least;     /* metres, > 0: no cut is nearer to an end of a piece along the plane's axis */
} stilb_geometry_lights_desc;

typedef struct stilb_geometry_pieces {
	stilb_scene_mesh *meshes; /* [count] with extras if the mesh has some */
	uint32_t count;
	uint32_t triangles; /* of all together */
	uint32_t most;      /* so many lights reach a piece at most */
} stilb_geometry_pieces;

/* Cuts the mesh; one that needs no cut is one piece. A mesh without triangles has none. STILB_ERROR_ARGUMENT: an index
 * is out of its range, a position is not finite, or `least` is not above 0. STILB_ERROR_MEMORY. *pieces is {0} then.
 * [any-thread] */
stilb_result stilb_geometry_cut_at_lights(const stilb_scene_mesh *mesh, const stilb_geometry_lights_desc *desc,
                                          stilb_geometry_pieces *pieces);

/* Adds each piece to a scene that is built, as a mesh and a model of its own on the node: each is one draw. Mistakes
 * are the build's. [one-writer] */
void stilb_geometry_build_pieces(stilb_scene_build *build, uint32_t node, uint32_t material,
                                 const stilb_geometry_pieces *pieces);

/* Frees them and leaves {0}. Accepts {0}. [one-writer] */
void stilb_geometry_pieces_finish(stilb_geometry_pieces *pieces);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
