/*
 * scene_pick: the triangle that a ray meets first: what lies under the mouse.
 *
 * On the CPU: bounds first, then every triangle of each model whose bounding sphere the ray meets. So there is nothing
 * to keep up to date while the scene changes. An index may be given, in which meshes of 4,096 triangles and more have
 * boxes around groups of their triangles; the engine has one for stilb_engine_pick. For rays by the thousand there is
 * gi. Hidden models are not met. After stilb_scene_set_vertices bounds are right from the next frame on.
 * Cost.     4 ns a model, and 12 ns a triangle of the models whose spheres the ray meets (AMD EPYC, one thread). With
 *           an index, of a mesh of 10 million triangles: 140 ms once, when its boxes are made, and then 13 us. A
 *           mesh whose triangles stand in random order gains nothing.
 * Exact.    In double, from the corners in world space as floats. Triangles show their counter-clockwise side alone, as
 *           frames draw them. Of two at the same distance the one with the lower ids is met.
 * Threads.  [any-thread]; nobody may write to the scene meanwhile.
 * Example.
 *
 *   stilb_scene_ray ray = stilb_scene_camera_ray(&scene->camera, 1280, 720, mouse_x, mouse_y);
 *   stilb_scene_hit hit;
 *   if (stilb_scene_pick(scene, &ray, &hit))
 *       printf("model %u, %.2f m away\n", hit.model, hit.distance);
 */
#ifndef STILB_SCENE_PICK_H
#define STILB_SCENE_PICK_H

#include "scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* The segment origin + t direction, near_t < t <= far_t, in world space. direction need not be unit. */
typedef struct stilb_scene_ray {
	double origin[3], direction[3];
	double near_t, far_t;
} stilb_scene_ray;

/* What a ray meets first. */
typedef struct stilb_scene_hit {
	uint32_t model, part; /* ids; part is an index into the scene's parts, scene->part_mesh[part] its mesh */
	uint32_t triangle;    /* its number in that mesh: indices 3 * triangle .. 3 * triangle + 2 */
	float position[3];    /* world space, metres */
	float u, v;           /* barycentric: the position is (1 - u - v) a + u b + v c of the corners a, b, c */
	double distance;      /* from the ray's origin, metres */
} stilb_scene_hit;

/* The ray through a point of the picture, pixels from its top left corner; the first pixel's centre is (0.5, 0.5). It
 * begins at the near plane and ends at the far plane: near_t and far_t are their distances. width and height are
 * positive. */
stilb_scene_ray stilb_scene_camera_ray(const stilb_scene_camera *camera, uint32_t width, uint32_t height, double x,
                                       double y);

/* Fills *hit with the first triangle on the ray. False: there is none, and *hit is as before; a ray that is not finite
 * meets none. */
bool stilb_scene_pick(const stilb_scene *scene, const stilb_scene_ray *ray, stilb_scene_hit *hit);

/* ---- with an index ----------------------------------------------------------------------------------------------- */

/* Boxes of a scene's large meshes, each made when a ray first meets its model. [one-writer], picking too. */
typedef struct stilb_scene_pick_index stilb_scene_pick_index;

/* An empty index; NULL: no memory. It takes 0.8 bytes a triangle. */
stilb_scene_pick_index *stilb_scene_pick_index_create(void);

/* Accepts NULL. */
void stilb_scene_pick_index_destroy(stilb_scene_pick_index *index);

/* To be called after the mesh was replaced or removed, or its vertices were changed; _clear for all meshes, or before
 * another scene. NULL is accepted. */
void stilb_scene_pick_index_forget(stilb_scene_pick_index *index, uint32_t mesh);
void stilb_scene_pick_index_clear(stilb_scene_pick_index *index);

/* As stilb_scene_pick, with the same result; index NULL, or without memory for it: at the same cost, too. */
bool stilb_scene_pick_indexed(const stilb_scene *scene, const stilb_scene_ray *ray, stilb_scene_pick_index *index,
                              stilb_scene_hit *hit);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
