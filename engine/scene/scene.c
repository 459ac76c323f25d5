#include "scene/scene_internal.h"

#include "scene/edit/scene_check.h"
#include "scene/edit/scene_edit_internal.h"
#include "scene/open/scene_lights_file.h"
#include "scene/play/scene_play_internal.h"
#include "scene/scene_animation_internal.h"
#include "scene/scene_impostor.h"
#include "shading/shade_energy.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

/* An array of zeros. Sets *failed if there is no memory for it. */
static void *scene_array(bool *failed, size_t count, size_t size)
{
	void *array = stilb_memory_alloc(count, size);
	if (array)
		memset(array, 0, count * size);
	else
		*failed = true;
	return array;
}

stilb_result scene_create(uint32_t model_count, uint32_t part_count, uint32_t mesh_count, uint32_t material_count,
                          stilb_scene **out)
{
	STILB_ASSERT(out && model_count <= STILB_SCENE_MAX_MODELS);
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
	scene->model_node = scene_array(&failed, model_count, sizeof(uint32_t));
	scene->model_flags = scene_array(&failed, model_count, sizeof(uint8_t));
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

void scene_set_model_flags(stilb_scene *scene, uint32_t model, uint32_t flags)
{
	STILB_ASSERT(model < scene->model_count && flags <= STILB_SCENE_MODEL_FLAGS);
	scene->model_flags[model] = (uint8_t)flags;
	scene->flags_used |= flags;
}

uint32_t stilb_scene_leave_out(const stilb_scene *scene, uint32_t flags, uint32_t *ids, uint32_t count)
{
	STILB_ASSERT(scene && (ids || count == 0));
	if ((scene->flags_used & flags) == 0)
		return count;
	uint32_t kept = 0;
	for (uint32_t i = 0; i < count; i++) {
		STILB_ASSERT(ids[i] < scene->model_count);
		ids[kept] = ids[i];
		kept += (scene->model_flags[ids[i]] & flags) == 0;
	}
	return kept;
}

void stilb_scene_set_sky(stilb_scene *scene, const float radiance[3])
{
	STILB_ASSERT(scene && radiance);
	stilb_image_finish(&scene->surroundings.panorama);
	for (int i = 0; i < 3; i++)
		STILB_ASSERT(radiance[i] >= 0.0f && isfinite(radiance[i]));
	for (int i = 0; i < 3; i++)
		scene->surroundings.sky[i] = scene->surroundings.ground[i] = radiance[i];
	scene->surroundings.name[0] = '\0';
	scene->revisions.surroundings++; /* the next panorama may lie where the last one did */
}

stilb_result scene_add_surfaces(stilb_scene *scene, uint32_t count)
{
	bool failed = false;
	STILB_ASSERT(!scene->surfaces && "surfaces are added once");
	scene->surfaces = scene_array(&failed, count, sizeof *scene->surfaces);
	if (failed)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for %u surfaces", count);
	scene->surface_count = count;
	return STILB_OK;
}

stilb_result scene_add_functions(stilb_scene *scene, uint32_t count)
{
	bool failed = false;
	STILB_ASSERT(!scene->functions && "functions are added once");
	scene->functions = scene_array(&failed, count, sizeof *scene->functions);
	if (failed)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for %u surface functions", count);
	scene->function_count = count;
	return STILB_OK;
}

stilb_result scene_add_textures(stilb_scene *scene, uint32_t count)
{
	bool failed = false;
	STILB_ASSERT(!scene->textures && "textures are added once");
	scene->textures = scene_array(&failed, count, sizeof(stilb_image));
	if (failed)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for %u textures", count);
	scene->texture_count = count;
	return STILB_OK;
}

stilb_result scene_add_cameras(stilb_scene *scene, uint32_t count)
{
	bool failed = false;
	STILB_ASSERT(!scene->cameras && "cameras are added once");
	scene->cameras = scene_array(&failed, count, sizeof *scene->cameras);
	if (failed)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for %u cameras", count);
	scene->camera_count = count;
	return STILB_OK;
}

stilb_result scene_add_names(stilb_scene *scene)
{
	bool failed = false;
	stilb_scene_names *names = &scene->names;
	STILB_ASSERT(!names->models && "names are added once");
	if ((uint64_t)scene->model_count + scene->material_count > SCENE_NAMES)
		return STILB_OK;
	names->models = scene_array(&failed, scene->model_count, sizeof *names->models);
	names->materials = scene_array(&failed, scene->material_count, sizeof *names->materials);
	if (failed)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the names of %u models", scene->model_count);
	names->model_count = scene->model_count;
	names->material_count = scene->material_count;
	return STILB_OK;
}

stilb_result scene_add_lights(stilb_scene *scene, uint32_t count)
{
	bool failed = false;
	STILB_ASSERT(!scene->lights && "lights are added once");
	scene->lights = scene_array(&failed, count, sizeof(stilb_scene_light));
	if (failed)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for %u lights", count);
	scene->light_count = count;
	return STILB_OK;
}

stilb_result scene_add_nodes(stilb_scene *scene, uint32_t count)
{
	bool failed = false;
	stilb_scene_nodes *nodes = &scene->nodes;
	STILB_ASSERT(!nodes->parent && "nodes are added once");
	nodes->parent = scene_array(&failed, count, sizeof *nodes->parent);
	nodes->pose = scene_array(&failed, count, sizeof *nodes->pose);
	nodes->local = scene_array(&failed, count, sizeof *nodes->local);
	nodes->to_world = scene_array(&failed, count, sizeof *nodes->to_world);
	nodes->name = scene_array(&failed, count, sizeof *nodes->name);
	if (failed)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for %u nodes", count);
	nodes->count = count;
	return STILB_OK;
}

stilb_result scene_add_mounts(stilb_scene_mount **mounts, uint32_t count)
{
	bool failed = false;
	STILB_ASSERT(mounts);
	if (!*mounts)
		*mounts = scene_array(&failed, count, sizeof **mounts);
	return failed ? stilb_fail(STILB_ERROR_MEMORY, "no memory to hang %u lights or cameras on nodes", count) : STILB_OK;
}

void stilb_scene_destroy(stilb_scene *scene)
{
	if (!scene)
		return;
	for (uint32_t i = 0; i < scene->mesh_count; i++)
		stilb_scene_mesh_finish(&scene->meshes[i]);
	for (uint32_t i = 0; i < scene->texture_count; i++)
		stilb_image_finish(&scene->textures[i]);
	stilb_scene_remove_impostors(scene);
	stilb_image_finish(&scene->surroundings.panorama);
	free(scene->backdrop.map);
	free(scene->backdrop.floor);
	free(scene->bounds.x);
	free(scene->bounds.y);
	free(scene->bounds.z);
	free(scene->bounds.radius);
	free(scene->first_part);
	free(scene->moved);
	free(scene->model_node);
	free(scene->model_flags);
	free(scene->nodes.parent);
	free(scene->nodes.pose);
	free(scene->nodes.local);
	free(scene->nodes.to_world);
	free(scene->nodes.name);
	free(scene->part_mesh);
	free(scene->part_material);
	free(scene->part_transform);
	free(scene->meshes);
	free(scene->materials);
	free(scene->surfaces);
	for (uint32_t i = 0; i < scene->function_count; i++)
		stilb_scene_function_finish(&scene->functions[i]);
	free(scene->functions);
	free(scene->textures);
	free(scene->lights);
	free(scene->light_mounts);
	scene_lights_close(scene->lights_file);
	free(scene->cameras);
	free(scene->camera_mounts);
	free(scene->names.models);
	free(scene->names.materials);
	scene_play_finish(scene);
	scene_edit_finish(scene->edits);
	scene_variants_finish(scene->variants);
	scene_animation_finish(scene->animation);
	free(scene);
}

static bool scene_all_below(const uint32_t *values, uint32_t count, uint32_t limit)
{
	for (uint32_t i = 0; i < count; i++)
		if (values[i] >= limit)
			return false;
	return true;
}

bool scene_mesh_is_sound(const stilb_scene_mesh *mesh)
{
	bool sound = mesh->index_count % 3 == 0 && scene_all_below(mesh->indices, mesh->index_count, mesh->vertex_count);
	for (uint32_t l = 0; l < mesh->level_count; l++) {
		const stilb_scene_level *level = &mesh->levels[l];
		sound = sound && level->first_index <= mesh->level_index_count && level->index_count % 3 == 0 &&
		        level->index_count <= mesh->level_index_count - level->first_index &&
		        level->vertex_count <= mesh->vertex_count &&
		        scene_all_below(mesh->level_indices + level->first_index, level->index_count, level->vertex_count);
	}
	uint32_t clusters = 0;
	for (uint32_t g = 0; g < mesh->group_count; g++) {
		sound = sound && mesh->groups[g].first_cluster == clusters;
		clusters += mesh->groups[g].cluster_count;
	}
	return sound && clusters == mesh->cluster_count &&
	       scene_all_below(mesh->cluster_indices, mesh->cluster_index_count, mesh->vertex_count);
}

/* True if all numbers are within 1e18. */
static bool scene_mount_is_sound(const stilb_scene_mount *mount)
{
	const float *vectors[] = {mount->position, mount->direction, mount->half_x, mount->half_y, mount->up};
	bool sound = scene_is_within(&mount->radius, 1, -SCENE_FAR, SCENE_FAR);
	for (size_t v = 0; v < sizeof vectors / sizeof *vectors; v++)
		sound = sound && scene_is_within(vectors[v], 3, -SCENE_FAR, SCENE_FAR);
	return sound;
}

/* mounts: NULL, or [count]. */
static bool scene_mounts_are_sound(const stilb_scene_mount *mounts, uint32_t count, uint32_t node_count)
{
	bool sound = true;
	for (uint32_t i = 0; mounts && i < count; i++)
		sound = sound && mounts[i].node <= node_count && scene_mount_is_sound(&mounts[i]);
	return sound;
}

bool scene_nodes_are_sound(const stilb_scene *scene)
{
	const stilb_scene_nodes *nodes = &scene->nodes;
	bool sound = true;
	for (uint32_t n = 0; n < nodes->count; n++) {
		const float *pose = (const float *)&nodes->pose[n]; /* ten of them */
		sound =
			sound && (nodes->parent[n] < n || nodes->parent[n] == STILB_SCENE_NONE) && memchr(nodes->name[n], 0, 64);
		for (int i = 0; i < 16; i++)
			sound = sound && isfinite(nodes->local[n].m[i]) && isfinite(pose[i % 10]);
	}
	for (uint32_t m = 0; m < scene->model_count; m++)
		sound = sound && scene->model_node[m] <= nodes->count;
	return sound && scene_mounts_are_sound(scene->light_mounts, scene->light_count, nodes->count) &&
	       scene_mounts_are_sound(scene->camera_mounts, scene->camera_count, nodes->count);
}

bool scene_is_sound(const stilb_scene *scene)
{
	bool sound = scene->first_part[0] == 0 && scene->first_part[scene->model_count] == scene->part_count;
	for (uint32_t m = 0; m < scene->model_count; m++)
		sound = sound && scene->first_part[m] <= scene->first_part[m + 1] &&
		        (scene->model_flags[m] & ~(scene->flags_used & STILB_SCENE_MODEL_FLAGS)) == 0;
	for (uint32_t m = 0; m < scene->mesh_count; m++)
		sound = sound && scene_mesh_is_sound(&scene->meshes[m]);
	for (uint32_t m = 0; m < scene->material_count; m++)
		sound = sound && scene->materials[m].diffuse_texture <= scene->texture_count &&
		        scene->materials[m].surface <= scene->surface_count;
	for (uint32_t s = 0; s < scene->surface_count; s++)
		sound = sound &&
		        scene_check_surface(&scene->surfaces[s], scene->texture_count, scene->function_count, s) == STILB_OK;
	for (uint32_t i = 0; i < scene->light_count; i++)
		sound = sound && scene->lights[i].face <= scene->part_count && !stilb_scene_light_mistake(&scene->lights[i]);
	return sound && scene_all_below(scene->part_mesh, scene->part_count, scene->mesh_count) &&
	       scene_all_below(scene->part_material, scene->part_count, scene->material_count) &&
	       scene_variants_are_sound(scene) && scene_animation_is_sound(scene);
}

/* ---- bounds ------------------------------------------------------------------------------------------------------ */

typedef struct scene_box {
	float low[3], high[3];
} scene_box;

static const scene_box scene_box_empty = {{FLT_MAX, FLT_MAX, FLT_MAX}, {-FLT_MAX, -FLT_MAX, -FLT_MAX}};

/* Grows the box to hold a sphere. */
static void scene_box_add(scene_box *box, const float p[3], float radius)
{
	for (int i = 0; i < 3; i++) {
		box->low[i] = fminf(box->low[i], p[i] - radius);
		box->high[i] = fmaxf(box->high[i], p[i] + radius);
	}
}

/* The centre of the box; the origin if the box is empty. */
static stilb_vec3 scene_box_center(const scene_box *box)
{
	stilb_vec3 center = {0};
	for (int i = 0; i < 3; i++)
		center[i] = box->low[i] <= box->high[i] ? 0.5f * box->low[i] + 0.5f * box->high[i] : 0.0f;
	return center;
}

/* Transforms a point to the world. False: NaN, or so far out that the square of a distance overflows. */
static bool scene_world(const stilb_mat4 *transform, const float p[3], float out[3])
{
	const float *m = transform->m;
	bool finite = true;
	for (int row = 0; row < 3; row++) {
		out[row] = m[row] * p[0] + m[4 + row] * p[1] + m[8 + row] * p[2] + m[12 + row];
		finite &= fabsf(out[row]) <= 1e18f;
	}
	return finite;
}

/* Calls add with the corners of the box, transformed to the world. */
static void scene_each_corner(const scene_box *box, const stilb_mat4 *transform,
                              void (*add)(void *context, const float p[3]), void *context)
{
	float p[3];
	for (int corner = 0; corner < 8 && box->low[0] <= box->high[0]; corner++) {
		float at[3] = {corner & 1 ? box->high[0] : box->low[0], corner & 2 ? box->high[1] : box->low[1],
		               corner & 4 ? box->high[2] : box->low[2]};
		if (scene_world(transform, at, p))
			add(context, p);
	}
}

/* Calls add with every vertex of the model in world space, but for those that scene_world refuses. boxes: NULL, or for
 * each mesh a box whose corners stand for its vertices. */
static void scene_each_vertex(const stilb_scene *scene, uint32_t model, const scene_box *boxes,
                              void (*add)(void *context, const float p[3]), void *context)
{
	float p[3];
	for (uint32_t part = scene->first_part[model]; part < scene->first_part[model + 1]; part++) {
		const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[part]];
		if (boxes)
			scene_each_corner(&boxes[scene->part_mesh[part]], &scene->part_transform[part], add, context);
		for (uint32_t v = 0; v < mesh->vertex_count && !boxes; v++)
			if (scene_world(&scene->part_transform[part], mesh->vertices[v].position, p))
				add(context, p);
	}
}

static void scene_grow_box(void *box, const float p[3])
{
	scene_box_add(box, p, 0.0f);
}

static void scene_grow_sphere(void *context, const float p[3])
{
	stilb_sphere *sphere = context;
	float x = p[0] - sphere->x, y = p[1] - sphere->y, z = p[2] - sphere->z;
	sphere->radius = fmaxf(sphere->radius, sqrtf(x * x + y * y + z * z));
}

static void scene_fit_model(stilb_scene *scene, uint32_t model, const scene_box *boxes)
{
	STILB_ASSERT(model < scene->model_count);
	scene_box box = scene_box_empty;
	scene_each_vertex(scene, model, boxes, scene_grow_box, &box);
	stilb_vec3 center = scene_box_center(&box);
	stilb_sphere sphere = {center[0], center[1], center[2], 0.0f};
	scene_each_vertex(scene, model, boxes, scene_grow_sphere, &sphere);
	scene->bounds.x[model] = sphere.x;
	scene->bounds.y[model] = sphere.y;
	scene->bounds.z[model] = sphere.z;
	scene->bounds.radius[model] = sphere.radius * 1.00001f; /* a margin for rounding */
	STILB_ASSERT(isfinite(scene->bounds.radius[model]));
}

void scene_fit_bounds(stilb_scene *scene, uint32_t model)
{
	scene_fit_model(scene, model, NULL);
}

bool scene_is_placed_often(const stilb_scene *scene)
{
	uint64_t placed = 0;
	for (uint32_t part = 0; part < scene->part_count; part++) {
		if (scene->part_mesh[part] == STILB_SCENE_NONE)
			continue; /* it was removed */
		const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[part]];
		placed += mesh->vertex_count > mesh->index_count ? mesh->vertex_count : mesh->index_count;
	}
	return placed > SCENE_PLACED_OFTEN;
}

/* The box of each mesh in its own space, [mesh_count], to be freed; NULL without memory. */
static scene_box *scene_mesh_boxes(const stilb_scene *scene)
{
	scene_box *boxes = stilb_memory_alloc(scene->mesh_count, sizeof *boxes);
	stilb_mat4 itself = stilb_mat4_identity();
	float p[3];
	for (uint32_t m = 0; boxes && m < scene->mesh_count; m++) {
		boxes[m] = scene_box_empty;
		for (uint32_t v = 0; v < scene->meshes[m].vertex_count; v++)
			if (scene_world(&itself, scene->meshes[m].vertices[v].position, p))
				scene_box_add(&boxes[m], p, 0.0f);
	}
	return boxes;
}

void scene_fit_all_bounds(stilb_scene *scene)
{
	scene_box *boxes = scene_is_placed_often(scene) ? scene_mesh_boxes(scene) : NULL;
	for (uint32_t m = 0; m < scene->model_count; m++)
		scene_fit_model(scene, m, boxes);
	free(boxes);
}

stilb_sphere scene_sphere(const stilb_scene *scene)
{
	scene_box box = scene_box_empty;
	const stilb_scene_bounds *b = &scene->bounds;
	for (uint32_t m = 0; m < scene->model_count; m++)
		scene_box_add(&box, (float[3]){b->x[m], b->y[m], b->z[m]}, b->radius[m]);
	stilb_vec3 center = scene_box_center(&box);
	stilb_sphere sphere = {center[0], center[1], center[2], 0.0f};
	for (uint32_t m = 0; m < scene->model_count; m++) {
		float x = b->x[m] - sphere.x, y = b->y[m] - sphere.y, z = b->z[m] - sphere.z;
		sphere.radius = fmaxf(sphere.radius, sqrtf(x * x + y * y + z * z) + b->radius[m]);
	}
	return sphere;
}

static float scene_clamp(float value, float low, float high)
{
	return !(value > low) ? low : value < high ? value : high; /* NaN becomes low */
}

stilb_scene_material stilb_scene_material_make(const float diffuse[3], const float specular[3], float roughness)
{
	STILB_ASSERT(diffuse && specular);
	stilb_vec3 cd = {0}, cs = {0};
	for (int i = 0; i < 3; i++) {
		cd[i] = scene_clamp(diffuse[i], 0.0f, 1e6f);
		cs[i] = scene_clamp(specular[i], 0.0f, 1e6f);
	}
	shade_reflectance limited = shade_limit_to_one(cd, cs);
	stilb_scene_material material = {.roughness = scene_clamp(roughness, 0.0f, 1.0f)};
	for (int i = 0; i < 3; i++) {
		STILB_ASSERT(limited.diffuse[i] + limited.specular[i] <= 1.0001f);
		material.diffuse[i] = limited.diffuse[i];
		material.specular[i] = limited.specular[i];
	}
	return material;
}

/* ---- camera ------------------------------------------------------------------------------------------------------ */

stilb_scene_camera scene_camera_along(stilb_vec3 position, stilb_vec3 view, float fov_y)
{
	float distance = sqrtf(stilb_vec3_dot(view, view));
	STILB_ASSERT(distance > 0.0f && isfinite(distance));
	STILB_ASSERT(fov_y > 0.0f && fov_y < 3.1415927f);
	return (stilb_scene_camera){
		.position = {position[0], position[1], position[2]},
		.yaw = atan2f(-view[0], -view[2]),
		.pitch = atan2f(view[1], sqrtf(view[0] * view[0] + view[2] * view[2])),
		.fov_y = fov_y,
		.near_z = 1e-3f * distance,
		.far_z = 1e3f * distance,
	};
}

stilb_scene_camera scene_camera_look(stilb_vec3 position, stilb_vec3 target, float fov_y)
{
	return scene_camera_along(position, target - position, fov_y);
}

/* The matrix from view space to the view space of the same camera rolled by that angle, radians: a rotation about Z,
 * the axis along which it looks. */
static stilb_mat4 scene_roll(float roll)
{
	float s = sinf(roll), c = cosf(roll);
	return (stilb_mat4){.m = {[0] = c, [1] = s, [4] = -s, [5] = c, [10] = 1.0f, [15] = 1.0f}};
}

stilb_mat4 stilb_scene_camera_matrix(const stilb_scene_camera *camera, float aspect)
{
	STILB_ASSERT(camera);
	stilb_vec3 position = stilb_vec3_make(camera->position[0], camera->position[1], camera->position[2]);
	stilb_mat4 view = stilb_mat4_view(position, camera->yaw, camera->pitch);
	if (camera->roll != 0.0f) /* without roll the product might change the last bit of some elements */
		view = stilb_mat4_multiply(scene_roll(camera->roll), view);
	return stilb_mat4_multiply(stilb_mat4_perspective(camera->fov_y, aspect, camera->near_z, camera->far_z), view);
}
