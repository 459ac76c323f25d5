/*
 * scene_tangents: tangents for normal maps, as glTF 2.0 defines them for meshes that bring none: MikkTSpace. Baking
 * tools use the same algorithm, so a normal map that was baked with it looks as its author saw it.
 *
 * A tangent is (x, y, z, w): (x, y, z) is unit, perpendicular to the vertex's normal, and points to where u grows; w is
 * 1 or -1. The bitangent is cross(normal, tangent) * w. It points to where v falls, since v = 0 is the top of a picture
 * and the green channel of glTF's normal maps points up. uv are passed as the file has them: the bitangent of
 * MikkTSpace points to where v grows, so w is the negative of its sign. glTF-Sample-Viewer 1.1 does the same. To pass 1
 * - v and keep the sign would be equal, but for the rounding of 1 - v.
 *
 * The algorithm.
 *   1. Vertices with equal position, normal and uv are one, whatever their indices; -0 equals 0.
 *   2. A triangle of which two corners share a position is left out. One without area on the texture, on which u or v
 *      does not move, or with numbers that are not finite has no direction of its own, and goes with any other.
 *   3. Around a vertex, triangles that are connected by edges form a group while they are all mapped or all mirrored
 *      (by the sign of their area on the texture). An edge joins two triangles that pass through it in opposite
 *      directions; of more than two the first in the order of the indices.
 *   4. A group's tangent is the sum of its triangles' directions of u, each projected onto the plane of the normal and
 *      made unit, times the triangle's angle at the vertex. A triangle whose projected direction of u or v is exactly
 *      opposite to another's, at 180 degrees, is not summed with that one.
 *   5. Corners of triangles that were left out take the tangent of the first other corner of the same vertex.
 * Source: Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", master's thesis, University of Copenhagen, 2008, and
 * what his public implementation does. Splits and signs are the same as its own, and so are all bits of the directions,
 * unless the C libraries' acos differ.
 *
 * Where it differs.
 *   - Every result is a tangent. Where a sum is zero or lies along the normal, or no triangle has a direction, it is
 *     the X axis projected onto the plane of the normal, or the Y axis where the normal is along X. w is 1 without such
 *     a triangle.
 *   - Normals that are not unit (|n|^2 more than 1e-5 from 1) are made so; where they are zero or not finite, nothing
 *     is projected. NaN equals NaN of the same bits.
 *   - Edges of the last vertices are joined by rule 3, too: the public implementation leaves the last run of its list
 *     unsorted, and may overlook neighbours there.
 *   - The exception of step 4 is left out in groups of more than 4,096 triangles, where it would take time in
 *     proportion to the square of their number.
 *
 * Cost.     About 100 ns a corner on one core, four times that if the triangles are in random order; in proportion to
 *           the number of corners. In a group whose directions differ by more than 75 degrees 2 to 4 ns more for each
 *           pair of its triangles: 60 ms for 4,096 (AMD EPYC). 30 to 70 bytes of memory a corner meanwhile.
 * Threads.  [any-thread]; nothing is shared.
 * Example.
 *
 *   scene_tangents_make(&mesh, corner_tangents);
 *   scene_tangents_split_make(&mesh, corner_tangents, &split);
 *   for (uint32_t v = 0; v < split.vertex_count; v++)
 *       write_vertex(vertices[split.sources[v]], split.tangents[v]);
 *   write_indices(split.indices, mesh.index_count);
 *   scene_tangents_split_finish(&split);
 */
#ifndef SCENE_TANGENTS_H
#define SCENE_TANGENTS_H

#include "base/base.h"

/* What tangents are made from. Strides are bytes from one vertex to the next, a multiple of 4. */
typedef struct scene_tangents_mesh {
	const float *positions, *normals, *uvs; /* of the first vertex: 3, 3 and 2 floats, of any value */
	size_t position_stride, normal_stride, uv_stride;
	const uint32_t *indices; /* [index_count] three for each triangle, each < vertex_count */
	uint32_t vertex_count, index_count;
} scene_tangents_mesh;

/* Fills tangents[index_count], one for each corner, in the order of the indices. Corners of one vertex may have
 * different ones. |tangent|^2 differs from 1 by at most 1e-3, and so does the cosine with a normal from 0; nearly
 * always it is 1e-6. No number is -0. Error: no memory. */
stilb_result scene_tangents_make(const scene_tangents_mesh *mesh, float (*tangents)[4]);

/* A mesh in which each vertex has one tangent. */
typedef struct scene_tangents_split {
	/* The mesh's vertices in their order, and then copies: further tangents of a vertex, in the order in which the
	 * indices come to them. A vertex itself has the tangent that the indices come to first, (1, 0, 0, 1) if none does.
	 */
	uint32_t vertex_count;
	uint32_t *sources;    /* [vertex_count] the vertex of the mesh that it is a copy of; itself for the first ones */
	float (*tangents)[4]; /* [vertex_count] */
	uint32_t *indices;    /* [mesh->index_count] */
} scene_tangents_split;

/* Makes one vertex for each pair of a vertex and a tangent that some corner has; tangents[index_count] are compared by
 * their bits. Only the mesh's counts and indices are read. Time in proportion to corners and vertices. Error: no
 * memory, or more vertices than 32 bits can count; *split is then empty. */
stilb_result scene_tangents_split_make(const scene_tangents_mesh *mesh, const float (*tangents)[4],
                                       scene_tangents_split *split);

/* Frees what scene_tangents_split_make made; {0} is accepted. */
void scene_tangents_split_finish(scene_tangents_split *split);

#endif
