/* Shared by the tests of post: a box. */
#ifndef POST_BOX_H
#define POST_BOX_H

#include "scene/scene_build.h"

/* A cube from -1 to 1 whose faces have vertices of their own. */
static inline stilb_scene_mesh post_box(void)
{
	static stilb_scene_vertex vertices[24];
	static uint32_t indices[36];
	for (uint32_t f = 0; f < 6; f++) {
		uint32_t axis = f / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
		float side = f % 2 ? 1.0f : -1.0f;
		for (uint32_t c = 0; c < 4; c++) {
			stilb_scene_vertex *vertex = &vertices[4 * f + c];
			vertex->position[axis] = vertex->normal[axis] = side;
			vertex->position[u] = c % 2 ? side : -side;
			vertex->position[v] = c / 2 ? 1.0f : -1.0f;
			vertex->normal[u] = vertex->normal[v] = 0.0f;
		}
		static const uint32_t corners[6] = {0, 1, 2, 2, 1, 3};
		for (uint32_t i = 0; i < 6; i++)
			indices[6 * f + i] = 4 * f + corners[i];
	}
	return (stilb_scene_mesh){.vertices = vertices, .indices = indices, .vertex_count = 24, .index_count = 36};
}

#endif
