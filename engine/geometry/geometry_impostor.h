/*
 * geometry_impostor: bakes impostors (scene/scene_impostor.h), pictures of a model from many directions, on the job
 * system and without a device.
 *
 * How it works. Each picture is drawn by a small rasteriser: parallel projection, samples x samples points a texel,
 *               the nearest triangle at each; then the points of a texel are averaged. Coordinates are rounded to 1/256
 *               of a point's distance and edges are decided in integers, so that triangles that share an edge leave no
 *               gap. Textures are read from a chain of smaller copies, at the one whose texels are as large as the
 *               points' distance on that triangle.
 * Determinism.  A picture is drawn by one job from first to last triangle: the same bits for any number of workers.
 * Cost.         Time: grid^2 times (vertices + triangles + covered points). Memory: 16 bytes a texel for the result
 *               (grid * side <= STILB_SCENE_IMPOSTOR_MAX_TEXELS: at most 256 MiB); while it works 36 bytes a vertex
 *               and 16 a triangle of all parts, 16 bytes a texel of their textures, and for each thread of the pool
 *               8 bytes a point of a picture and 12 a vertex.
 * Threads.      [any-thread] that the pool knows: `worker` is the caller's index in it.
 * Example.      An impostor of model 7 of a scene, with the sizes that the renderer likes best:
 *
 *   stilb_scene_impostor impostor;
 *   stilb_geometry_impostor_desc desc = stilb_geometry_impostor_desc_default();
 *   stilb_result result = stilb_geometry_impostor_of_model(scene, 7, &desc, pool, 0, &impostor);
 *   if (result == STILB_OK) {
 *       ...
 *       stilb_scene_impostor_finish(&impostor);
 *   }
 */
#ifndef STILB_GEOMETRY_IMPOSTOR_H
#define STILB_GEOMETRY_IMPOSTOR_H

#include "jobs/job.h"
#include "scene/scene_impostor.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

#define STILB_GEOMETRY_IMPOSTOR_MAX_SAMPLES 16u
#define STILB_GEOMETRY_IMPOSTOR_MAX_POINTS 4096u /* side * samples */

typedef struct stilb_geometry_impostor_desc {
	uint32_t grid;    /* directions a side: odd, 3 at least */
	uint32_t side;    /* texels of a picture's side, 4 at least; grid * side <= STILB_SCENE_IMPOSTOR_MAX_TEXELS */
	uint32_t samples; /* points a texel in each direction, 1..STILB_GEOMETRY_IMPOSTOR_MAX_SAMPLES; side * samples <=
	                     STILB_GEOMETRY_IMPOSTOR_MAX_POINTS */
	bool both_sides;  /* triangles are seen from behind, too, with the normal on the viewer's side: stilb_scene's */
} stilb_geometry_impostor_desc;

/* 13 x 13 pictures of 64 texels a side, 11 MiB of maps; 4 x 4 points a texel; front sides alone. [any-thread] */
stilb_geometry_impostor_desc stilb_geometry_impostor_desc_default(void);

/* A piece of what is baked. */
typedef struct stilb_geometry_impostor_part {
	const stilb_scene_mesh *mesh;
	const stilb_scene_material *material;
	const stilb_image *texture;  /* multiplies material->diffuse; NULL: none. diffuse_texture is not read */
	const stilb_mat4 *transform; /* from the mesh to the impostor's space, affine; NULL: they are the same */
} stilb_geometry_impostor_part;

/* Bakes part_count >= 1 parts, each with its full mesh. Materials may differ in diffuse reflectance and roughness; of
 * specular, anisotropy and wrap the impostor has the means over the surface, and diffuse is lowered where the sum of
 * both would exceed 1. STILB_ERROR_ARGUMENT names the fault: numbers out of range, a position or normal that is not
 * finite, an index beyond the vertices, nothing with an extent, a material that emits (impostors do not). Triangles
 * without area are left out, as every rasteriser does. STILB_ERROR_MEMORY. *impostor is {0} after an error. */
stilb_result stilb_geometry_impostor_bake(const stilb_geometry_impostor_part *parts, uint32_t part_count,
                                          const stilb_geometry_impostor_desc *desc, stilb_job_pool *pool,
                                          uint32_t worker, stilb_scene_impostor *impostor);

/* Bakes a model of a scene in the space of its first part's mesh: who draws it gives it that part's transform. The
 * scene's both_sides counts, desc's is not read. STILB_ERROR_ARGUMENT also for a model that was removed, and for a
 * first part whose transform has no inverse. The rest as above. */
stilb_result stilb_geometry_impostor_of_model(const stilb_scene *scene, uint32_t model,
                                              const stilb_geometry_impostor_desc *desc, stilb_job_pool *pool,
                                              uint32_t worker, stilb_scene_impostor *impostor);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
