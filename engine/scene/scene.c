#include "scene/scene_internal.h"

#include "shading/shade_energy.h"

#include <stdlib.h>
#include <string.h>

static void *scene_array(bool *failed, size_t count, size_t size)
{
	void *array = stilb_memory_alloc(count, size);
	if (array)
		memset(array, 0, count * size);
	*failed |= array == NULL;
	return array;
}

stilb_result scene_create(uint32_t model_count, uint32_t part_count, uint32_t mesh_count, uint32_t material_count,
                          stilb_scene **out)
{
	bool failed = false;
	*out = NULL;
	stilb_scene *scene = calloc(1, sizeof *scene);
	if (!scene)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a scene");
	scene->model_count = model_count;
	scene->bounds.x = scene_array(&failed, model_count, sizeof(float));
	scene->bounds.y = scene_array(&failed, model_count, sizeof(float));
	scene->bounds.z = scene_array(&failed, model_count, sizeof(float));
	scene->bounds.radius = scene_array(&failed, model_count, sizeof(float));
	scene->first_part = scene_array(&failed, (size_t)model_count + 1, sizeof(uint32_t));
	scene->moved = scene_array(&failed, model_count, sizeof(uint32_t));
	scene->part_count = part_count;
	scene->part_mesh = scene_array(&failed, part_count, sizeof(uint32_t));
	scene->part_material = scene_array(&failed, part_count, sizeof(uint32_t));
	scene->part_transform = scene_array(&failed, part_count, sizeof(stilb_mat4));
	scene->mesh_count = mesh_count;
	scene->meshes = scene_array(&failed, mesh_count, sizeof(stilb_scene_mesh));
	scene->material_count = material_count;
	scene->materials = scene_array(&failed, material_count, sizeof(stilb_scene_material));
	if (failed) {
		scene->mesh_count = scene->meshes ? mesh_count : 0;
		stilb_scene_destroy(scene);
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a scene of %u models; try fewer", model_count);
	}
	*out = scene;
	return STILB_OK;
}

void stilb_scene_destroy(stilb_scene *scene)
{
	if (!scene)
		return;
	for (uint32_t i = 0; i < scene->mesh_count; i++)
		stilb_scene_mesh_finish(&scene->meshes[i]);
	free(scene->bounds.x);
	free(scene->bounds.y);
	free(scene->bounds.z);
	free(scene->bounds.radius);
	free(scene->first_part);
	free(scene->moved);
	free(scene->part_mesh);
	free(scene->part_material);
	free(scene->part_transform);
	free(scene->meshes);
	free(scene->materials);
	free(scene);
}

static float scene_clamp(float value, float low, float high)
{
	return !(value > low) ? low : value < high ? value : high; /* NaN becomes low */
}

stilb_scene_material stilb_scene_material_make(const float diffuse[3], const float specular[3], float roughness)
{
	stilb_vec3 cd = {0}, cs = {0};
	for (int i = 0; i < 3; i++) {
		cd[i] = scene_clamp(diffuse[i], 0.0f, 1e6f);
		cs[i] = scene_clamp(specular[i], 0.0f, 1e6f);
	}
	shade_reflectance limited = shade_limit_to_one(cd, cs);
	stilb_scene_material material = {.roughness = scene_clamp(roughness, 0.0f, 1.0f)};
	for (int i = 0; i < 3; i++) {
		material.diffuse[i] = limited.diffuse[i];
		material.specular[i] = limited.specular[i];
	}
	return material;
}

stilb_mat4 stilb_scene_camera_matrix(const stilb_scene_camera *camera, float aspect)
{
	stilb_vec3 position = stilb_vec3_make(camera->position[0], camera->position[1], camera->position[2]);
	return stilb_mat4_multiply(stilb_mat4_perspective(camera->fov_y, aspect, camera->near_z, camera->far_z),
	                           stilb_mat4_view(position, camera->yaw, camera->pitch));
}
