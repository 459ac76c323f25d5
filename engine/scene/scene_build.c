#include "scene/scene_build.h"

#include "scene/edit/scene_check.h"
#include "scene/scene_internal.h"

#include <float.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* An array that grows by doubling. */
typedef struct build_list {
	void *items;
	uint32_t count, capacity;
} build_list;

typedef struct build_mesh {
	stilb_scene_mesh mesh;
	float reach; /* the largest coordinate of a vertex, without its sign */
} build_mesh;

typedef struct build_model {
	uint32_t node, first_part;
	uint32_t flags; /* STILB_SCENE_MODEL_... */
} build_model;

typedef struct build_node {
	uint32_t parent;
	stilb_scene_pose pose;
	stilb_mat4 local, to_world;
	char name[64];
} build_node;

typedef struct build_camera {
	stilb_scene_named_camera named; /* in the world */
	stilb_scene_mount mount;
} build_camera;

struct stilb_scene_build {
	build_list meshes;    /* of build_mesh */
	build_list textures;  /* of stilb_image */
	build_list surfaces;  /* of stilb_scene_surface */
	build_list functions; /* of stilb_scene_function */
	build_list materials; /* of stilb_scene_material */
	build_list nodes;     /* of build_node */
	build_list models;    /* of build_model */
	build_list parts;     /* of stilb_scene_build_part */
	build_list lights;    /* of stilb_scene_light, in the world */
	build_list mounts;    /* of stilb_scene_mount, one for each light */
	build_list cameras;   /* of build_camera */
	stilb_scene_surroundings surroundings;
	stilb_scene_camera camera;
	bool has_camera;
	stilb_result error; /* STILB_OK: no mistake so far */
	char words[256];    /* of the error */
};

/* ---- mistakes and memory ----------------------------------------------------------------------------------------- */

__attribute__((format(printf, 2, 3))) static bool build_refuse(stilb_scene_build *build, const char *format, ...)
{
	va_list arguments;
	STILB_ASSERT(build->error == STILB_OK);
	va_start(arguments, format);
	vsnprintf(build->words, sizeof build->words, format, arguments);
	va_end(arguments);
	build->error = STILB_ERROR_ARGUMENT;
	return false;
}

/* Keeps the mistake that a check has found. True if it found none. */
static bool build_accept(stilb_scene_build *build, stilb_result checked)
{
	return checked == STILB_OK || build_refuse(build, "%s", stilb_error_message());
}

static bool build_goes_on(const stilb_scene_build *build)
{
	return build && build->error == STILB_OK;
}

static void build_no_memory(stilb_scene_build *build, const char *what)
{
	snprintf(build->words, sizeof build->words, "no memory for another %s", what);
	build->error = STILB_ERROR_MEMORY;
}

/* Room for count more items of this size at the end of the list, which are not counted yet. NULL: no memory. */
static void *build_room(stilb_scene_build *build, build_list *list, uint32_t count, size_t size, const char *what)
{
	uint64_t needed = (uint64_t)list->count + count, capacity = list->capacity ? list->capacity : 16;
	while (capacity < needed)
		capacity *= 2;
	if (capacity > list->capacity) {
		void *items = capacity <= UINT32_MAX ? realloc(list->items, capacity * size) : NULL;
		if (!items) {
			build_no_memory(build, what);
			return NULL;
		}
		list->items = items;
		list->capacity = (uint32_t)capacity;
	}
	return (char *)list->items + list->count * size;
}

/* Adds a copy of an item. Returns its id, or 0 after an error. */
static uint32_t build_add(stilb_scene_build *build, build_list *list, const void *item, size_t size, const char *what)
{
	void *room = build_room(build, list, 1, size, what);
	if (!room)
		return 0;
	memcpy(room, item, size);
	return list->count++;
}

stilb_scene_build *stilb_scene_build_begin(void)
{
	return calloc(1, sizeof(stilb_scene_build));
}

static void build_free(stilb_scene_build *build)
{
	build_mesh *meshes = build->meshes.items;
	stilb_image *textures = build->textures.items;
	for (uint32_t i = 0; i < build->meshes.count; i++)
		stilb_scene_mesh_finish(&meshes[i].mesh);
	for (uint32_t i = 0; i < build->textures.count; i++)
		stilb_image_finish(&textures[i]);
	stilb_image_finish(&build->surroundings.panorama);
	free(build->meshes.items);
	free(build->textures.items);
	free(build->surfaces.items);
	stilb_scene_function *functions = build->functions.items;
	for (uint32_t i = 0; i < build->functions.count; i++)
		stilb_scene_function_finish(&functions[i]);
	free(build->functions.items);
	free(build->materials.items);
	free(build->nodes.items);
	free(build->models.items);
	free(build->parts.items);
	free(build->lights.items);
	free(build->mounts.items);
	free(build->cameras.items);
	free(build);
}

/* ---- meshes and textures ----------------------------------------------------------------------------------------- */

static float build_reach(const stilb_scene_mesh *mesh)
{
	float reach = 0.0f;
	for (uint32_t i = 0; i < mesh->vertex_count; i++)
		for (int k = 0; k < 3; k++)
			reach = fmaxf(reach, fabsf(mesh->vertices[i].position[k]));
	return reach;
}

uint32_t stilb_scene_build_mesh(stilb_scene_build *build, const stilb_scene_mesh *mesh)
{
	stilb_scene_mesh copy;
	STILB_ASSERT(mesh);
	if (!build_goes_on(build) || !build_accept(build, scene_check_mesh(mesh, build->meshes.count)))
		return 0;
	build_mesh *room = build_room(build, &build->meshes, 1, sizeof *room, "mesh");
	if (!room)
		return 0;
	if (scene_copy_mesh(mesh, &copy) != STILB_OK) {
		build_no_memory(build, "mesh");
		return 0;
	}
	*room = (build_mesh){copy, build_reach(mesh)};
	return build->meshes.count++;
}

uint32_t stilb_scene_build_texture(stilb_scene_build *build, const stilb_image *image)
{
	stilb_image copy;
	STILB_ASSERT(image);
	if (!build_goes_on(build) || !build_accept(build, scene_check_texture(image, build->textures.count)))
		return 0;
	stilb_image *room = build_room(build, &build->textures, 1, sizeof *room, "texture");
	if (!room)
		return 0;
	if (stilb_image_copy(image, false, &copy) != STILB_OK) {
		build_no_memory(build, "texture");
		return 0;
	}
	*room = copy;
	return build->textures.count++;
}

/* ---- materials --------------------------------------------------------------------------------------------------- */

uint32_t stilb_scene_build_function(stilb_scene_build *build, const stilb_scene_function *function)
{
	stilb_scene_function copy;
	STILB_ASSERT(function);
	if (!build_goes_on(build) || !build_accept(build, scene_check_function(function, build->functions.count)))
		return 0;
	stilb_scene_function *room = build_room(build, &build->functions, 1, sizeof *room, "surface function");
	if (!room)
		return 0;
	if (stilb_scene_function_copy(function, &copy) != STILB_OK) {
		build_no_memory(build, "surface function");
		return 0;
	}
	*room = copy;
	return build->functions.count++;
}

uint32_t stilb_scene_build_surface(stilb_scene_build *build, const stilb_scene_surface *surface)
{
	STILB_ASSERT(surface);
	if (!build_goes_on(build) ||
	    !build_accept(
			build, scene_check_surface(surface, build->textures.count, build->functions.count, build->surfaces.count)))
		return 0;
	return build_add(build, &build->surfaces, surface, sizeof *surface, "surface");
}

static bool build_material_check(stilb_scene_build *build, const stilb_scene_material *m)
{
	uint32_t id = build->materials.count;
	if (!build_accept(build, scene_check_material(m, id)))
		return false;
	if (m->diffuse_texture > build->textures.count)
		return build_refuse(build, "material %u: there is no texture %u", id, m->diffuse_texture - 1);
	if (m->surface > build->surfaces.count)
		return build_refuse(build, "material %u: there is no surface %u", id, m->surface - 1);
	return true;
}

uint32_t stilb_scene_build_material(stilb_scene_build *build, const stilb_scene_material *material)
{
	STILB_ASSERT(material);
	if (!build_goes_on(build) || !build_material_check(build, material))
		return 0;
	return build_add(build, &build->materials, material, sizeof *material, "material");
}

/* ---- nodes and models -------------------------------------------------------------------------------------------- */

/* Adds a node whose parent and local are set. */
static uint32_t build_add_node(stilb_scene_build *build, build_node *node)
{
	uint32_t id = build->nodes.count, parent = node->parent;
	const build_node *nodes = build->nodes.items;
	if (parent != STILB_SCENE_NO_PARENT && parent >= id) {
		build_refuse(build, "node %u: there is no node %u before it", id, parent);
		return 0;
	}
	node->to_world = node->local;
	if (parent != STILB_SCENE_NO_PARENT)
		node->to_world = stilb_mat4_multiply(nodes[parent].to_world, node->local);
	if (!scene_is_affine(&node->local) || !scene_is_affine(&node->to_world)) {
		build_refuse(build, "node %u: its transform is not affine, or not within 1e18", id);
		return 0;
	}
	return build_add(build, &build->nodes, node, sizeof *node, "node");
}

uint32_t stilb_scene_build_node(stilb_scene_build *build, uint32_t parent, const stilb_mat4 *local)
{
	STILB_ASSERT(local);
	if (!build_goes_on(build))
		return 0;
	build_node node = {.parent = parent, .pose = stilb_scene_pose_of(local), .local = *local};
	return build_add_node(build, &node);
}

uint32_t stilb_scene_build_pose(stilb_scene_build *build, uint32_t parent, const stilb_scene_pose *pose)
{
	STILB_ASSERT(pose);
	if (!build_goes_on(build) || !build_accept(build, scene_check_pose(pose, build->nodes.count)))
		return 0;
	build_node node = {.parent = parent, .pose = *pose, .local = stilb_scene_pose_matrix(pose)};
	return build_add_node(build, &node);
}

void stilb_scene_build_name(stilb_scene_build *build, uint32_t node, const char *name)
{
	STILB_ASSERT(name);
	if (!build_goes_on(build))
		return;
	build_node *nodes = build->nodes.items;
	if (node >= build->nodes.count)
		build_refuse(build, "the name '%.63s': there is no node %u", name, node);
	else
		snprintf(nodes[node].name, sizeof nodes->name, "%s", name);
}

/* True if every vertex of a mesh of this reach is within SCENE_FAR in the world. */
static bool build_is_near(const stilb_mat4 *world, float reach)
{
	const float *m = world->m;
	for (int row = 0; row < 3; row++) {
		float most = (fabsf(m[row]) + fabsf(m[4 + row]) + fabsf(m[8 + row])) * reach + fabsf(m[12 + row]);
		if (!(most <= SCENE_FAR))
			return false;
	}
	return true;
}

static bool build_model_check(stilb_scene_build *build, uint32_t node, const stilb_scene_build_part *parts,
                              uint32_t part_count)
{
	uint32_t id = build->models.count;
	const build_mesh *meshes = build->meshes.items;
	const build_node *nodes = build->nodes.items;
	if (id == STILB_SCENE_MAX_MODELS)
		return build_refuse(build, "more than %u models", STILB_SCENE_MAX_MODELS);
	if (node >= build->nodes.count)
		return build_refuse(build, "model %u: there is no node %u", id, node);
	if (part_count == 0)
		return build_refuse(build, "model %u: it has no parts", id);
	for (uint32_t i = 0; i < part_count; i++) {
		if (parts[i].mesh >= build->meshes.count)
			return build_refuse(build, "model %u: there is no mesh %u", id, parts[i].mesh);
		if (parts[i].material >= build->materials.count)
			return build_refuse(build, "model %u: there is no material %u", id, parts[i].material);
		if (!build_is_near(&nodes[node].to_world, meshes[parts[i].mesh].reach))
			return build_refuse(build, "model %u: mesh %u reaches farther than 1e18 m there", id, parts[i].mesh);
	}
	return true;
}

uint32_t stilb_scene_build_model(stilb_scene_build *build, uint32_t node, const stilb_scene_build_part *parts,
                                 uint32_t part_count)
{
	STILB_ASSERT(parts || part_count == 0);
	if (!build_goes_on(build) || !build_model_check(build, node, parts, part_count))
		return 0;
	void *room = build_room(build, &build->parts, part_count, sizeof *parts, "part");
	if (!room)
		return 0;
	build_model model = {.node = node, .first_part = build->parts.count};
	uint32_t id = build_add(build, &build->models, &model, sizeof model, "model");
	if (!build_goes_on(build))
		return 0;
	memcpy(room, parts, part_count * sizeof *parts);
	build->parts.count += part_count;
	return id;
}

void stilb_scene_build_model_flags(stilb_scene_build *build, uint32_t model, uint32_t flags)
{
	if (!build_goes_on(build))
		return;
	build_model *models = build->models.items;
	if (model >= build->models.count)
		build_refuse(build, "flags: there is no model %u", model);
	else if (flags > STILB_SCENE_MODEL_FLAGS)
		build_refuse(build, "model %u: its flags are %u; STILB_SCENE_MODEL_FLAGS, %u, are all there are", model, flags,
		             STILB_SCENE_MODEL_FLAGS);
	else
		models[model].flags = flags;
}

/* ---- light and camera -------------------------------------------------------------------------------------------- */

/* The place of a node of this build, for thing `id`; NULL after the mistake that there is none. */
static const stilb_mat4 *build_place(stilb_scene_build *build, uint32_t node, const char *what, uint32_t id)
{
	const build_node *nodes = build->nodes.items;
	if (node < build->nodes.count)
		return &nodes[node].to_world;
	build_refuse(build, "%s %u: there is no node %u", what, id, node);
	return NULL;
}

/* Adds a light in the world, and how it hangs on a node, or {0}. */
static uint32_t build_add_light(stilb_scene_build *build, const stilb_scene_light *light, stilb_scene_mount mount)
{
	uint32_t id = build->lights.count;
	const char *mistake = stilb_scene_light_mistake(light);
	if (mistake)
		build_refuse(build, "light %u: %s", id, mistake);
	else if (light->face > build->parts.count)
		build_refuse(build, "light %u: there is no part %u", id, light->face - 1);
	if (!build_goes_on(build))
		return 0;
	build_add(build, &build->mounts, &mount, sizeof mount, "light");
	return build_goes_on(build) ? build_add(build, &build->lights, light, sizeof *light, "light") : 0;
}

uint32_t stilb_scene_build_light(stilb_scene_build *build, const stilb_scene_light *light)
{
	STILB_ASSERT(light);
	return build_goes_on(build) ? build_add_light(build, light, (stilb_scene_mount){0}) : 0;
}

uint32_t stilb_scene_build_light_on(stilb_scene_build *build, uint32_t node, const stilb_scene_light *light)
{
	STILB_ASSERT(light);
	if (!build_goes_on(build))
		return 0;
	uint32_t id = build->lights.count;
	const stilb_mat4 *place = build_place(build, node, "light", id);
	const char *mistake = stilb_scene_light_mistake(light);
	if (!place || mistake)
		return place ? (build_refuse(build, "light %u: %s", id, mistake), 0) : 0;
	stilb_scene_mount mount = scene_mount_of_light(light, node + 1);
	stilb_scene_light placed = *light;
	if (!scene_mount_light(&mount, place, &placed)) {
		build_refuse(build, "light %u: node %u makes it too small or puts it too far away", id, node);
		return 0;
	}
	return build_add_light(build, &placed, mount);
}

void stilb_scene_build_surroundings(stilb_scene_build *build, const stilb_scene_surroundings *surroundings)
{
	STILB_ASSERT(surroundings);
	const stilb_image *map = &surroundings->panorama;
	if (!build_goes_on(build))
		return;
	if (!scene_is_within(surroundings->sky, 3, 0.0f, FLT_MAX) ||
	    !scene_is_within(surroundings->ground, 3, 0.0f, FLT_MAX))
		build_refuse(build, "surroundings: a radiance is negative or not finite");
	else if (!scene_is_within(&surroundings->rotation, 1, -FLT_MAX, FLT_MAX))
		build_refuse(build, "surroundings: the rotation is not finite");
	else if (map->pixels && (map->channels != 3 || map->format != STILB_IMAGE_F32_LINEAR))
		build_refuse(build, "surroundings: the panorama has not three channels of linear floats");
	stilb_image copy = {0};
	if (!build_goes_on(build))
		return;
	if (map->pixels && stilb_image_create(&copy, map->width, map->height, 3, map->format) != STILB_OK) {
		build_no_memory(build, "panorama");
		return;
	}
	if (map->pixels)
		memcpy(copy.pixels, map->pixels, stilb_image_size(map));
	stilb_image_finish(&build->surroundings.panorama);
	build->surroundings = *surroundings;
	build->surroundings.panorama = copy;
}

/* True if there is nothing wrong with a camera. name: "camera", or its number, too. */
static bool build_camera_check(stilb_scene_build *build, const char *name, const stilb_scene_camera *camera)
{
	const float angles[3] = {camera->yaw, camera->pitch, camera->roll};
	if (!scene_is_within(camera->position, 3, -SCENE_FAR, SCENE_FAR) || !scene_is_within(angles, 3, -FLT_MAX, FLT_MAX))
		build_refuse(build, "%s: its position is not within 1e18 m, or an angle is not finite", name);
	else if (!(camera->fov_y > 0.0f && camera->fov_y < 3.1415925f))
		build_refuse(build, "%s: the field of view %g is not between 0 and pi", name, (double)camera->fov_y);
	else if (!(camera->near_z > 0.0f && camera->near_z < camera->far_z && camera->far_z <= SCENE_FAR))
		build_refuse(build, "%s: near %g and far %g are not 0 < near < far", name, (double)camera->near_z,
		             (double)camera->far_z);
	return build_goes_on(build);
}

void stilb_scene_build_camera(stilb_scene_build *build, const stilb_scene_camera *camera)
{
	STILB_ASSERT(camera);
	if (!build_goes_on(build) || !build_camera_check(build, "camera", camera))
		return;
	build->camera = *camera;
	build->has_camera = true;
}

uint32_t stilb_scene_build_named_camera(stilb_scene_build *build, const char *name, uint32_t node,
                                        const stilb_scene_camera *camera)
{
	STILB_ASSERT(name && camera);
	if (!build_goes_on(build))
		return 0;
	char what[32];
	uint32_t id = build->cameras.count;
	build_camera made = {.named.camera = *camera};
	snprintf(what, sizeof what, "camera %u", id);
	snprintf(made.named.name, sizeof made.named.name, "%s", name);
	if (!build_camera_check(build, what, camera))
		return 0;
	if (node != STILB_SCENE_NO_PARENT) {
		const stilb_mat4 *place = build_place(build, node, "camera", id);
		if (!place)
			return 0;
		made.mount = scene_mount_of_camera(camera, node + 1);
		if (!scene_mount_camera(&made.mount, place, &made.named.camera)) {
			build_refuse(build, "camera %u: node %u puts it too far away", id, node);
			return 0;
		}
	}
	return build_add(build, &build->cameras, &made, sizeof made, "camera");
}

/* ---- the scene --------------------------------------------------------------------------------------------------- */

static void build_fill_nodes(const stilb_scene_build *build, stilb_scene_nodes *to)
{
	const build_node *nodes = build->nodes.items;
	for (uint32_t n = 0; n < to->count; n++) {
		to->parent[n] = nodes[n].parent;
		to->pose[n] = nodes[n].pose;
		to->local[n] = nodes[n].local;
		to->to_world[n] = nodes[n].to_world;
		memcpy(to->name[n], nodes[n].name, sizeof *to->name);
	}
}

/* Copies cameras, and how lights and cameras hang on nodes where the scene has room for that. */
static void build_fill_mounts(const stilb_scene_build *build, stilb_scene *scene)
{
	const build_camera *cameras = build->cameras.items;
	if (scene->light_mounts)
		memcpy(scene->light_mounts, build->mounts.items, scene->light_count * sizeof *scene->light_mounts);
	for (uint32_t c = 0; c < scene->camera_count; c++) {
		scene->cameras[c] = cameras[c].named;
		if (scene->camera_mounts)
			scene->camera_mounts[c] = cameras[c].mount;
	}
}

/* Moves meshes, textures and functions, copies the rest. */
static void build_fill(stilb_scene_build *build, stilb_scene *scene)
{
	const build_model *models = build->models.items;
	const build_mesh *meshes = build->meshes.items;
	const stilb_scene_build_part *parts = build->parts.items;
	const struct {
		void *to;
		const build_list *from;
		size_t size;
	} arrays[] = {{scene->textures, &build->textures, sizeof *scene->textures},
	              {scene->surfaces, &build->surfaces, sizeof *scene->surfaces},
	              {scene->functions, &build->functions, sizeof *scene->functions},
	              {scene->materials, &build->materials, sizeof *scene->materials},
	              {scene->lights, &build->lights, sizeof *scene->lights}};
	for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
		if (arrays[i].from->count > 0)
			memcpy(arrays[i].to, arrays[i].from->items, arrays[i].from->count * arrays[i].size);
	for (uint32_t i = 0; i < scene->mesh_count; i++)
		scene->meshes[i] = meshes[i].mesh;
	build->meshes.count = build->textures.count = build->functions.count = 0;
	scene->surroundings = build->surroundings;
	build->surroundings.panorama = (stilb_image){0};
	build_fill_nodes(build, &scene->nodes);
	build_fill_mounts(build, scene);
	for (uint32_t m = 0; m < scene->model_count; m++) {
		uint32_t end = m + 1 < scene->model_count ? models[m + 1].first_part : scene->part_count;
		scene->first_part[m] = models[m].first_part;
		scene->model_node[m] = models[m].node + 1;
		scene_set_model_flags(scene, m, models[m].flags);
		for (uint32_t p = models[m].first_part; p < end; p++) {
			scene->part_mesh[p] = parts[p].mesh;
			scene->part_material[p] = parts[p].material;
			scene->part_transform[p] = scene->nodes.to_world[models[m].node];
		}
	}
	scene->first_part[scene->model_count] = scene->part_count;
	scene_fit_all_bounds(scene);
	scene->framed = !build->has_camera;
	scene->camera = build->has_camera ? build->camera
	                                  : stilb_scene_frame(scene, STILB_SCENE_FRAME_YAW, STILB_SCENE_FRAME_PITCH, 1.0f);
	STILB_CHECK(scene_is_sound(scene) && scene_nodes_are_sound(scene));
}

/* Room for nodes, and for the lights and cameras that may hang on them. */
static stilb_result build_add_nodes(const stilb_scene_build *build, stilb_scene *scene)
{
	stilb_result result = scene_add_nodes(scene, build->nodes.count);
	if (result == STILB_OK && scene->light_count > 0)
		result = scene_add_mounts(&scene->light_mounts, scene->light_count);
	if (result == STILB_OK && scene->camera_count > 0)
		result = scene_add_mounts(&scene->camera_mounts, scene->camera_count);
	return result;
}

static stilb_result build_scene(stilb_scene_build *build, stilb_scene **out)
{
	if (build->error != STILB_OK)
		return stilb_fail(build->error, "%s", build->words);
	stilb_scene *scene;
	stilb_result result =
		scene_create(build->models.count, build->parts.count, build->meshes.count, build->materials.count, &scene);
	if (result == STILB_OK && build->textures.count > 0)
		result = scene_add_textures(scene, build->textures.count);
	if (result == STILB_OK && build->surfaces.count > 0)
		result = scene_add_surfaces(scene, build->surfaces.count);
	if (result == STILB_OK && build->functions.count > 0)
		result = scene_add_functions(scene, build->functions.count);
	if (result == STILB_OK && build->lights.count > 0)
		result = scene_add_lights(scene, build->lights.count);
	if (result == STILB_OK && build->cameras.count > 0)
		result = scene_add_cameras(scene, build->cameras.count);
	if (result == STILB_OK && build->nodes.count > 0)
		result = build_add_nodes(build, scene);
	if (result != STILB_OK) {
		stilb_scene_destroy(scene);
		return result;
	}
	build_fill(build, scene);
	*out = scene;
	return STILB_OK;
}

stilb_result stilb_scene_build_end(stilb_scene_build *build, stilb_scene **scene)
{
	STILB_ASSERT(scene);
	*scene = NULL;
	if (!build)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory to build a scene");
	stilb_result result = build_scene(build, scene);
	build_free(build);
	return result;
}
