/* What a mesh, texture or material of a program must be, shared by scene_build and scene_edit. Each check returns
 * STILB_OK or STILB_ERROR_ARGUMENT with a line that names the thing by its id, the value and what is wrong. */
#ifndef STILB_SCENE_CHECK_H
#define STILB_SCENE_CHECK_H

#include "scene/scene.h"

#define SCENE_FAR 1e18f                /* metres: the square of a larger coordinate overflows */
#define SCENE_BRIGHTEST_COLOR 65504.0f /* the largest half: devices have colours of vertices as such */

/* True if low <= v <= high for all values; false for NaN. */
static inline bool scene_is_within(const float *values, int count, float low, float high)
{
	for (int i = 0; i < count; i++)
		if (!(values[i] >= low && values[i] <= high))
			return false;
	return true;
}

/* True if the length is 1, to 1 %. */
bool scene_is_unit(const float v[3]);

/* True if the last row is 0 0 0 1 and all elements are within SCENE_FAR. */
bool scene_is_affine(const stilb_mat4 *m);

/* Of node `id`. */
stilb_result scene_check_pose(const stilb_scene_pose *pose, uint32_t id);

/* Vertices `first` .. first + count - 1 of mesh `id`. */
stilb_result scene_check_vertices(const stilb_scene_vertex *vertices, uint32_t first, uint32_t count, uint32_t id);

/* The extras of mesh `id`, which has some. */
stilb_result scene_check_extras(const stilb_scene_mesh *mesh, uint32_t id);
stilb_result scene_check_mesh(const stilb_scene_mesh *mesh, uint32_t id);
/* Its clusters, if it has some. */
stilb_result scene_check_clusters(const stilb_scene_mesh *mesh, uint32_t id);
stilb_result scene_check_texture(const stilb_image *image, uint32_t id);
/* Does not look whether its texture and its surface exist. */
stilb_result scene_check_material(const stilb_scene_material *material, uint32_t id);

/* Its textures are below texture_count, its function is below function_count. */
stilb_result scene_check_surface(const stilb_scene_surface *surface, uint32_t texture_count, uint32_t function_count,
                                 uint32_t id);
stilb_result scene_check_function(const stilb_scene_function *function, uint32_t id);

/* A copy. STILB_ERROR_MEMORY; *to is {0} then. */
stilb_result scene_copy_mesh(const stilb_scene_mesh *from, stilb_scene_mesh *to);

#endif
