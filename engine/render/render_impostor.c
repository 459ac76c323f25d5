/* Impostors: a square of two triangles whose vertices carry what shaders/impostor.vert needs to turn it to the camera,
 * a material that says so (RENDER_STATE_IMPOSTOR), and a texture with the maps. */
#include "render/render_internal.h"

#include <string.h>

/* What the vertices' members mean is in shaders/impostor.vert. */
static stilb_result impostor_mesh_create(stilb_render *render, const stilb_scene_impostor *impostor,
                                         stilb_render_mesh *out)
{
	uint32_t indices[6] = {0, 1, 3, 0, 3, 2};
	stilb_scene_vertex vertices[5] = {[4] = {.normal = {0.0f, 1.0f, 0.0f}}};
	memcpy(vertices[4].position, impostor->half, sizeof vertices[4].position);
	static_assert(STILB_SCENE_IMPOSTOR_MAX_TEXELS == 4096, "a float holds all of these bits");
	for (uint32_t corner = 0; corner < 4; corner++) {
		stilb_scene_vertex *vertex = &vertices[corner];
		uint32_t numbers = (impostor->grid * STILB_SCENE_IMPOSTOR_MAX_TEXELS + impostor->side) * 4 + corner;
		STILB_ASSERT(numbers < 1u << 24);
		*vertex = (stilb_scene_vertex){.normal = {0.0f, 1.0f, 0.0f}, .uv = {impostor->radius, (float)numbers}};
		memcpy(vertex->position, impostor->center, sizeof vertex->position);
	}
	stilb_scene_mesh mesh = {.vertices = vertices, .indices = indices, .vertex_count = 5, .index_count = 6};
	return stilb_render_mesh_create(render, &mesh, out);
}

stilb_result stilb_render_impostor_create(stilb_render *render, const stilb_scene_impostor *impostor,
                                          stilb_render_impostor *out)
{
	STILB_ASSERT(impostor && out);
	*out = (stilb_render_impostor){0};
	const char *mistake = stilb_scene_impostor_mistake(impostor);
	if (mistake)
		return stilb_fail(STILB_ERROR_ARGUMENT, "an impostor cannot be drawn: %s", mistake);
	stilb_result result = stilb_render_texture_create(render, &impostor->maps, &out->texture);
	if (result == STILB_OK)
		result = render_material_create_impostor(render, &impostor->material, out->texture, &out->material);
	if (result == STILB_OK)
		result = impostor_mesh_create(render, impostor, &out->mesh);
	if (result != STILB_OK) {
		stilb_render_impostor_destroy(render, *out);
		*out = (stilb_render_impostor){0};
	}
	return result;
}

void stilb_render_impostor_destroy(stilb_render *render, stilb_render_impostor impostor)
{
	stilb_render_mesh_destroy(render, impostor.mesh);
	stilb_render_material_destroy(render, impostor.material);
	stilb_render_texture_destroy(render, impostor.texture);
}
