#include "scene/edit/scene_check.h"

#include "scene/scene_internal.h"

#include <float.h>
#include <math.h>
#include <string.h>

bool scene_is_unit(const float v[3])
{
	float square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
	return square >= 0.98f && square <= 1.02f;
}

bool scene_is_affine(const stilb_mat4 *m)
{
	return m->m[3] == 0.0f && m->m[7] == 0.0f && m->m[11] == 0.0f && m->m[15] == 1.0f &&
	       scene_is_within(m->m, 16, -SCENE_FAR, SCENE_FAR);
}

stilb_result scene_check_pose(const stilb_scene_pose *pose, uint32_t id)
{
	const float *q = pose->rotation;
	float square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
	if (!scene_is_within(pose->translation, 3, -SCENE_FAR, SCENE_FAR) ||
	    !scene_is_within(pose->scale, 3, -SCENE_FAR, SCENE_FAR))
		return stilb_fail(STILB_ERROR_ARGUMENT, "node %u: its translation or scale is not within 1e18", id);
	if (!(square >= 0.98f && square <= 1.02f))
		return stilb_fail(STILB_ERROR_ARGUMENT, "node %u: its rotation %g, %g, %g, %g is not a unit quaternion", id,
		                  (double)q[0], (double)q[1], (double)q[2], (double)q[3]);
	return STILB_OK;
}

stilb_result scene_check_vertices(const stilb_scene_vertex *vertices, uint32_t first, uint32_t count, uint32_t id)
{
	for (uint32_t i = 0; i < count; i++) {
		const stilb_scene_vertex *v = &vertices[i];
		if (!scene_is_within(v->position, 3, -SCENE_FAR, SCENE_FAR))
			return stilb_fail(STILB_ERROR_ARGUMENT,
			                  "mesh %u: the position %g, %g, %g of vertex %u is not within 1e18 m", id,
			                  (double)v->position[0], (double)v->position[1], (double)v->position[2], first + i);
		if (!scene_is_unit(v->normal))
			return stilb_fail(STILB_ERROR_ARGUMENT, "mesh %u: the normal %g, %g, %g of vertex %u is not unit", id,
			                  (double)v->normal[0], (double)v->normal[1], (double)v->normal[2], first + i);
		if (!scene_is_within(v->uv, 2, -FLT_MAX, FLT_MAX))
			return stilb_fail(STILB_ERROR_ARGUMENT, "mesh %u: the uv %g, %g of vertex %u are not finite", id,
			                  (double)v->uv[0], (double)v->uv[1], first + i);
	}
	return STILB_OK;
}

/* Level number `l` against the finer one, which may stand for the mesh itself. */
static stilb_result check_level(const stilb_scene_mesh *mesh, const stilb_scene_level *finer, uint32_t l, uint32_t id)
{
	const stilb_scene_level *level = &mesh->levels[l];
	uint32_t first = level->first_index, count = level->index_count;
	if (count == 0 || count % 3 != 0 || count >= finer->index_count)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "mesh %u: its level %u has %u indices; that takes a multiple of 3 below the finer level's %u",
		                  id, l, count, finer->index_count);
	if (first > mesh->level_index_count || count > mesh->level_index_count - first)
		return stilb_fail(STILB_ERROR_ARGUMENT, "mesh %u: indices %u to %llu of its level %u; its levels have %u", id,
		                  first, (unsigned long long)first + count - 1, l, mesh->level_index_count);
	if (level->vertex_count == 0 || level->vertex_count > finer->vertex_count)
		return stilb_fail(STILB_ERROR_ARGUMENT, "mesh %u: its level %u has %u vertices, the finer one %u", id, l,
		                  level->vertex_count, finer->vertex_count);
	if (!(level->error >= finer->error && level->error <= SCENE_FAR))
		return stilb_fail(STILB_ERROR_ARGUMENT, "mesh %u: the error of its level %u is %g m, the finer one's %g", id, l,
		                  (double)level->error, (double)finer->error);
	for (uint32_t i = 0; i < count; i++)
		if (mesh->level_indices[first + i] >= level->vertex_count)
			return stilb_fail(STILB_ERROR_ARGUMENT, "mesh %u: index %u of its level %u is vertex %u, but it has %u", id,
			                  i, l, mesh->level_indices[first + i], level->vertex_count);
	return STILB_OK;
}

/* Where vertices morph to, of those that not every level uses. */
static stilb_result check_morph(const stilb_scene_mesh *mesh, uint32_t id)
{
	for (uint32_t v = mesh->levels[mesh->level_count - 1].vertex_count; v < mesh->vertex_count; v++) {
		const stilb_scene_vertex *to = &mesh->morph[v];
		const float *n = to->normal;
		float square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
		if (!scene_is_within(to->position, 3, -SCENE_FAR, SCENE_FAR) || !(square <= 1.02f) ||
		    !scene_is_within(to->uv, 2, -FLT_MAX, FLT_MAX))
			return stilb_fail(STILB_ERROR_ARGUMENT,
			                  "mesh %u: vertex %u morphs to what is no vertex: position %g, %g, %g, normal %g, %g, %g, "
			                  "uv %g, %g",
			                  id, v, (double)to->position[0], (double)to->position[1], (double)to->position[2],
			                  (double)n[0], (double)n[1], (double)n[2], (double)to->uv[0], (double)to->uv[1]);
	}
	return STILB_OK;
}

static stilb_result check_levels(const stilb_scene_mesh *mesh, uint32_t id)
{
	if (mesh->level_count == 0 && mesh->level_index_count == 0 && !mesh->morph)
		return STILB_OK;
	if (mesh->level_count == 0 || mesh->level_count > STILB_SCENE_MAX_LEVELS || !mesh->levels || !mesh->level_indices)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "mesh %u: %u levels of %u indices; there are 1..%u, or none without "
		                  "indices and morph",
		                  id, mesh->level_count, mesh->level_index_count, STILB_SCENE_MAX_LEVELS);
	stilb_scene_level finer = {.index_count = mesh->index_count, .vertex_count = mesh->vertex_count};
	for (uint32_t l = 0; l < mesh->level_count; l++) {
		stilb_result result = check_level(mesh, &finer, l, id);
		if (result != STILB_OK)
			return result;
		finer = mesh->levels[l];
	}
	return mesh->morph ? check_morph(mesh, id) : STILB_OK;
}

static bool extra_is_good(const stilb_scene_vertex_extra *extra)
{
	const float *t = extra->tangent;
	bool none = t[0] == 0.0f && t[1] == 0.0f && t[2] == 0.0f && t[3] == 0.0f;
	return (none || (scene_is_unit(t) && fabsf(t[3]) == 1.0f)) && scene_is_within(extra->uv, 2, -FLT_MAX, FLT_MAX) &&
	       scene_is_within(extra->color, 4, 0.0f, SCENE_BRIGHTEST_COLOR);
}

stilb_result scene_check_extras(const stilb_scene_mesh *mesh, uint32_t id)
{
	for (uint32_t v = 0; v < mesh->vertex_count; v++)
		if (!extra_is_good(&mesh->extras[v]))
			return stilb_fail(STILB_ERROR_ARGUMENT,
			                  "mesh %u: vertex %u has a tangent that is not unit with w 1 or -1, a uv that is not "
			                  "finite, or a colour that is not within 0..%g",
			                  id, v, (double)SCENE_BRIGHTEST_COLOR);
	return STILB_OK;
}

stilb_result scene_check_mesh(const stilb_scene_mesh *mesh, uint32_t id)
{
	if (mesh->vertex_count == 0 || mesh->index_count == 0 || !mesh->vertices || !mesh->indices)
		return stilb_fail(STILB_ERROR_ARGUMENT, "mesh %u: it has no triangles", id);
	if (mesh->index_count % 3 != 0)
		return stilb_fail(STILB_ERROR_ARGUMENT, "mesh %u: %u indices are no whole triangles", id, mesh->index_count);
	for (uint32_t i = 0; i < mesh->index_count; i++)
		if (mesh->indices[i] >= mesh->vertex_count)
			return stilb_fail(STILB_ERROR_ARGUMENT, "mesh %u: index %u is vertex %u, but it has %u vertices", id, i,
			                  mesh->indices[i], mesh->vertex_count);
	stilb_result result = scene_check_vertices(mesh->vertices, 0, mesh->vertex_count, id);
	if (result == STILB_OK && mesh->extras)
		result = scene_check_extras(mesh, id);
	if (result == STILB_OK)
		result = check_levels(mesh, id);
	return result == STILB_OK ? scene_check_clusters(mesh, id) : result;
}

stilb_result scene_check_texture(const stilb_image *image, uint32_t id)
{
	if (image->width < 1 || image->width > 16384 || image->height < 1 || image->height > 16384 || !image->pixels)
		return stilb_fail(STILB_ERROR_ARGUMENT, "texture %u: %ux%u pixels; a side has 1..16384", id, image->width,
		                  image->height);
	if (image->channels < 1 || image->channels > 4 || (uint32_t)image->format >= STILB_IMAGE_FORMAT_COUNT)
		return stilb_fail(STILB_ERROR_ARGUMENT, "texture %u: %u channels in format %u; there are 1..4 and 0..%d", id,
		                  image->channels, (unsigned)image->format, STILB_IMAGE_FORMAT_COUNT - 1);
	uint32_t channels = stilb_image_format_channels(image->format);
	if (channels > 0 && image->channels != channels)
		return stilb_fail(STILB_ERROR_ARGUMENT, "texture %u: %u channels in blocks that have %u", id, image->channels,
		                  channels);
	return STILB_OK;
}

stilb_result scene_check_surface(const stilb_scene_surface *surface, uint32_t texture_count, uint32_t function_count,
                                 uint32_t id)
{
	const char *mistake = stilb_scene_surface_mistake(surface);
	if (mistake)
		return stilb_fail(STILB_ERROR_ARGUMENT, "surface %u: %s", id, mistake);
	for (int i = 0; i < STILB_SCENE_MAPS; i++)
		if (surface->maps[i].texture > texture_count)
			return stilb_fail(STILB_ERROR_ARGUMENT, "surface %u: there is no texture %u for its map %s", id,
			                  surface->maps[i].texture - 1, stilb_scene_map_names[i]);
	if (surface->function > function_count)
		return stilb_fail(STILB_ERROR_ARGUMENT, "surface %u: there is no function %u", id, surface->function - 1);
	return STILB_OK;
}

stilb_result scene_check_function(const stilb_scene_function *function, uint32_t id)
{
	const char *mistake = stilb_scene_function_mistake(function);
	if (id >= STILB_SCENE_MAX_FUNCTIONS)
		return stilb_fail(STILB_ERROR_ARGUMENT, "surface function %u: a scene has at most %u", id,
		                  STILB_SCENE_MAX_FUNCTIONS);
	return mistake ? stilb_fail(STILB_ERROR_ARGUMENT, "surface function %u, '%.63s': %s", id,
	                            function->name ? function->name : "", mistake)
	               : STILB_OK;
}

stilb_result scene_check_material(const stilb_scene_material *m, uint32_t id)
{
	if (!scene_is_within(m->diffuse, 3, 0.0f, 1.0f) || !scene_is_within(m->specular, 3, 0.0f, 1.0f))
		return stilb_fail(STILB_ERROR_ARGUMENT, "material %u: diffuse and specular are not within 0..1", id);
	for (int i = 0; i < 3; i++)
		if (m->diffuse[i] + m->specular[i] > 1.0001f)
			return stilb_fail(STILB_ERROR_ARGUMENT,
			                  "material %u: diffuse + specular is %g, more than 1 (stilb_scene_material_make)", id,
			                  (double)(m->diffuse[i] + m->specular[i]));
	if (!scene_is_within(&m->roughness, 1, 0.0f, 1.0f) || !scene_is_within(&m->wrap, 1, 0.0f, 1.0f))
		return stilb_fail(STILB_ERROR_ARGUMENT, "material %u: roughness %g or wrap %g is not within 0..1", id,
		                  (double)m->roughness, (double)m->wrap);
	if (!(m->anisotropy > -1.0f && m->anisotropy < 1.0f))
		return stilb_fail(STILB_ERROR_ARGUMENT, "material %u: anisotropy %g is not between -1 and 1", id,
		                  (double)m->anisotropy);
	if (!scene_is_within(m->emission, 3, 0.0f, FLT_MAX))
		return stilb_fail(STILB_ERROR_ARGUMENT, "material %u: emission is negative or not finite", id);
	if (m->surface && m->diffuse_texture)
		return stilb_fail(STILB_ERROR_ARGUMENT, "material %u: it has both a surface and a diffuse_texture", id);
	return STILB_OK;
}

/* memcpy, which takes no NULL. */
static void copy_values(void *to, const void *from, size_t bytes)
{
	if (bytes > 0)
		memcpy(to, from, bytes);
}

stilb_result scene_copy_mesh(const stilb_scene_mesh *from, stilb_scene_mesh *to)
{
	stilb_result result = scene_mesh_create(to, from->vertex_count, from->index_count);
	if (result == STILB_OK && from->extras)
		result = scene_mesh_add_extras(to);
	if (result == STILB_OK && from->level_count > 0)
		result = scene_mesh_add_levels(to, from->level_count, from->level_index_count, from->morph);
	if (result == STILB_OK && from->cluster_count > 0)
		result = scene_mesh_add_clusters(to, from->cluster_count, from->group_count, from->cluster_index_count);
	if (result != STILB_OK) {
		stilb_scene_mesh_finish(to);
		return result;
	}
	memcpy(to->vertices, from->vertices, from->vertex_count * sizeof *to->vertices);
	copy_values(to->extras, from->extras, from->extras ? from->vertex_count * sizeof *to->extras : 0);
	memcpy(to->indices, from->indices, from->index_count * sizeof *to->indices);
	copy_values(to->levels, from->levels, from->level_count * sizeof *to->levels);
	copy_values(to->level_indices, from->level_indices, from->level_index_count * sizeof *to->level_indices);
	copy_values(to->morph, from->morph, to->morph ? from->vertex_count * sizeof *to->morph : 0);
	copy_values(to->clusters, from->clusters, from->cluster_count * sizeof *to->clusters);
	copy_values(to->groups, from->groups, from->group_count * sizeof *to->groups);
	copy_values(to->cluster_indices, from->cluster_indices, from->cluster_index_count * sizeof *to->cluster_indices);
	return STILB_OK;
}
