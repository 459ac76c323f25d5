#include "scene/edit/scene_check.h"

#include "scene/scene_internal.h"

#include <float.h>
#include <math.h>
#include <string.h>

bool scene_is_within(const float *values, int count, float low, float high)
{
	for (int i = 0; i < count; i++)
		if (!(values[i] >= low && values[i] <= high))
			return false;
	return true;
}

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
	return scene_check_vertices(mesh->vertices, 0, mesh->vertex_count, id);
}

stilb_result scene_check_texture(const stilb_image *image, uint32_t id)
{
	if (image->width < 1 || image->width > 16384 || image->height < 1 || image->height > 16384 || !image->pixels)
		return stilb_fail(STILB_ERROR_ARGUMENT, "texture %u: %ux%u pixels; a side has 1..16384", id, image->width,
		                  image->height);
	if (image->channels < 1 || image->channels > 4 || (uint32_t)image->format > STILB_IMAGE_F32_LINEAR)
		return stilb_fail(STILB_ERROR_ARGUMENT, "texture %u: %u channels in format %u; there are 1..4 and 0..2", id,
		                  image->channels, (unsigned)image->format);
	return STILB_OK;
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
	return STILB_OK;
}

stilb_result scene_copy_mesh(const stilb_scene_mesh *from, stilb_scene_mesh *to)
{
	stilb_result result = scene_mesh_create(to, from->vertex_count, from->index_count);
	if (result != STILB_OK)
		return result;
	memcpy(to->vertices, from->vertices, from->vertex_count * sizeof *to->vertices);
	memcpy(to->indices, from->indices, from->index_count * sizeof *to->indices);
	return STILB_OK;
}

stilb_result scene_copy_image(const stilb_image *from, stilb_image *to)
{
	stilb_result result = stilb_image_create(to, from->width, from->height, from->channels, from->format);
	if (result == STILB_OK)
		memcpy(to->pixels, from->pixels, stilb_image_size(from));
	else
		*to = (stilb_image){0};
	return result;
}
