#include "scene/scene_build.h"

#include "scene/scene_internal.h"

#include <float.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define BUILD_FAR 1e18f /* metres: the square of a larger coordinate overflows */

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
} build_model;

struct stilb_scene_build {
	build_list meshes;    /* of build_mesh */
	build_list textures;  /* of stilb_image */
	build_list materials; /* of stilb_scene_material */
	build_list nodes;     /* of stilb_mat4, node to world */
	build_list models;    /* of build_model */
	build_list parts;     /* of stilb_scene_build_part */
	build_list lights;    /* of stilb_scene_light */
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
	free(build->meshes.items);
	free(build->textures.items);
	free(build->materials.items);
	free(build->nodes.items);
	free(build->models.items);
	free(build->parts.items);
	free(build->lights.items);
	free(build);
}

/* ---- numbers ----------------------------------------------------------------------------------------------------- */

/* False for NaN, too. */
static bool build_within(const float *values, int count, float low, float high)
{
	for (int i = 0; i < count; i++)
		if (!(values[i] >= low && values[i] <= high))
			return false;
	return true;
}

static bool build_is_unit(const float v[3])
{
	float square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
	return square >= 0.98f && square <= 1.02f;
}

static bool build_is_affine(const stilb_mat4 *m)
{
	return m->m[3] == 0.0f && m->m[7] == 0.0f && m->m[11] == 0.0f && m->m[15] == 1.0f &&
	       build_within(m->m, 16, -BUILD_FAR, BUILD_FAR);
}

/* ---- meshes and textures ----------------------------------------------------------------------------------------- */

static bool build_mesh_check(stilb_scene_build *build, const stilb_scene_mesh *mesh)
{
	uint32_t id = build->meshes.count;
	if (mesh->vertex_count == 0 || mesh->index_count == 0 || !mesh->vertices || !mesh->indices)
		return build_refuse(build, "mesh %u: it has no triangles", id);
	if (mesh->index_count % 3 != 0)
		return build_refuse(build, "mesh %u: %u indices are no whole triangles", id, mesh->index_count);
	for (uint32_t i = 0; i < mesh->index_count; i++)
		if (mesh->indices[i] >= mesh->vertex_count)
			return build_refuse(build, "mesh %u: index %u is vertex %u, but it has %u vertices", id, i,
			                    mesh->indices[i], mesh->vertex_count);
	for (uint32_t i = 0; i < mesh->vertex_count; i++) {
		const stilb_scene_vertex *v = &mesh->vertices[i];
		if (!build_within(v->position, 3, -BUILD_FAR, BUILD_FAR))
			return build_refuse(build, "mesh %u: the position %g, %g, %g of vertex %u is not within 1e18 m", id,
			                    (double)v->position[0], (double)v->position[1], (double)v->position[2], i);
		if (!build_is_unit(v->normal))
			return build_refuse(build, "mesh %u: the normal %g, %g, %g of vertex %u is not unit", id,
			                    (double)v->normal[0], (double)v->normal[1], (double)v->normal[2], i);
		if (!build_within(v->uv, 2, -FLT_MAX, FLT_MAX))
			return build_refuse(build, "mesh %u: the uv %g, %g of vertex %u are not finite", id, (double)v->uv[0],
			                    (double)v->uv[1], i);
	}
	return true;
}

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
	if (!build_goes_on(build) || !build_mesh_check(build, mesh))
		return 0;
	build_mesh *room = build_room(build, &build->meshes, 1, sizeof *room, "mesh");
	if (!room)
		return 0;
	if (scene_mesh_create(&copy, mesh->vertex_count, mesh->index_count) != STILB_OK) {
		build_no_memory(build, "mesh");
		return 0;
	}
	memcpy(copy.vertices, mesh->vertices, mesh->vertex_count * sizeof *copy.vertices);
	memcpy(copy.indices, mesh->indices, mesh->index_count * sizeof *copy.indices);
	*room = (build_mesh){copy, build_reach(mesh)};
	return build->meshes.count++;
}

uint32_t stilb_scene_build_texture(stilb_scene_build *build, const stilb_image *image)
{
	stilb_image copy;
	STILB_ASSERT(image);
	if (!build_goes_on(build))
		return 0;
	uint32_t id = build->textures.count;
	if (image->width < 1 || image->width > 16384 || image->height < 1 || image->height > 16384 || !image->pixels) {
		build_refuse(build, "texture %u: %ux%u pixels; a side has 1..16384", id, image->width, image->height);
		return 0;
	}
	if (image->channels < 1 || image->channels > 4 || (uint32_t)image->format > STILB_IMAGE_F32_LINEAR) {
		build_refuse(build, "texture %u: %u channels in format %u; there are 1..4 and 0..2", id, image->channels,
		             (unsigned)image->format);
		return 0;
	}
	stilb_image *room = build_room(build, &build->textures, 1, sizeof *room, "texture");
	if (!room)
		return 0;
	if (stilb_image_create(&copy, image->width, image->height, image->channels, image->format) != STILB_OK) {
		build_no_memory(build, "texture");
		return 0;
	}
	memcpy(copy.pixels, image->pixels, stilb_image_size(image));
	*room = copy;
	return build->textures.count++;
}

/* ---- materials --------------------------------------------------------------------------------------------------- */

static bool build_material_check(stilb_scene_build *build, const stilb_scene_material *m)
{
	uint32_t id = build->materials.count;
	if (!build_within(m->diffuse, 3, 0.0f, 1.0f) || !build_within(m->specular, 3, 0.0f, 1.0f))
		return build_refuse(build, "material %u: diffuse and specular are not within 0..1", id);
	for (int i = 0; i < 3; i++)
		if (m->diffuse[i] + m->specular[i] > 1.0001f)
			return build_refuse(build, "material %u: diffuse + specular is %g, more than 1 (stilb_scene_material_make)",
			                    id, (double)(m->diffuse[i] + m->specular[i]));
	if (!build_within(&m->roughness, 1, 0.0f, 1.0f) || !build_within(&m->wrap, 1, 0.0f, 1.0f))
		return build_refuse(build, "material %u: roughness %g or wrap %g is not within 0..1", id, (double)m->roughness,
		                    (double)m->wrap);
	if (!(m->anisotropy > -1.0f && m->anisotropy < 1.0f))
		return build_refuse(build, "material %u: anisotropy %g is not between -1 and 1", id, (double)m->anisotropy);
	if (!build_within(m->emission, 3, 0.0f, FLT_MAX))
		return build_refuse(build, "material %u: emission is negative or not finite", id);
	if (m->diffuse_texture > build->textures.count)
		return build_refuse(build, "material %u: there is no texture %u", id, m->diffuse_texture - 1);
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

uint32_t stilb_scene_build_node(stilb_scene_build *build, uint32_t parent, const stilb_mat4 *local)
{
	STILB_ASSERT(local);
	if (!build_goes_on(build))
		return 0;
	uint32_t id = build->nodes.count;
	const stilb_mat4 *nodes = build->nodes.items;
	stilb_mat4 world = *local;
	if (parent != STILB_SCENE_NO_PARENT && parent >= id) {
		build_refuse(build, "node %u: there is no node %u before it", id, parent);
		return 0;
	}
	if (parent != STILB_SCENE_NO_PARENT)
		world = stilb_mat4_multiply(nodes[parent], *local);
	if (!build_is_affine(local) || !build_is_affine(&world)) {
		build_refuse(build, "node %u: its transform is not affine, or not within 1e18", id);
		return 0;
	}
	return build_add(build, &build->nodes, &world, sizeof world, "node");
}

/* True if every vertex of a mesh of this reach is within BUILD_FAR in the world. */
static bool build_is_near(const stilb_mat4 *world, float reach)
{
	const float *m = world->m;
	for (int row = 0; row < 3; row++) {
		float most = (fabsf(m[row]) + fabsf(m[4 + row]) + fabsf(m[8 + row])) * reach + fabsf(m[12 + row]);
		if (!(most <= BUILD_FAR))
			return false;
	}
	return true;
}

static bool build_model_check(stilb_scene_build *build, uint32_t node, const stilb_scene_build_part *parts,
                              uint32_t part_count)
{
	uint32_t id = build->models.count;
	const build_mesh *meshes = build->meshes.items;
	const stilb_mat4 *nodes = build->nodes.items;
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
		if (!build_is_near(&nodes[node], meshes[parts[i].mesh].reach))
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
	build_model model = {node, build->parts.count};
	uint32_t id = build_add(build, &build->models, &model, sizeof model, "model");
	if (!build_goes_on(build))
		return 0;
	memcpy(room, parts, part_count * sizeof *parts);
	build->parts.count += part_count;
	return id;
}

/* ---- lights and camera ------------------------------------------------------------------------------------------- */

uint32_t stilb_scene_build_light(stilb_scene_build *build, const stilb_scene_light *light)
{
	STILB_ASSERT(light);
	if (!build_goes_on(build))
		return 0;
	uint32_t id = build->lights.count;
	bool spot = light->kind == STILB_SCENE_LIGHT_SPOT;
	if ((uint32_t)light->kind > STILB_SCENE_LIGHT_DIRECTIONAL)
		build_refuse(build, "light %u: there is no kind %u", id, (unsigned)light->kind);
	else if (!build_within(light->intensity, 3, 0.0f, FLT_MAX))
		build_refuse(build, "light %u: its intensity is negative or not finite", id);
	else if (light->kind != STILB_SCENE_LIGHT_DIRECTIONAL && !build_within(light->position, 3, -BUILD_FAR, BUILD_FAR))
		build_refuse(build, "light %u: its position is not within 1e18 m", id);
	else if (light->kind != STILB_SCENE_LIGHT_POINT && !build_is_unit(light->direction))
		build_refuse(build, "light %u: its direction is not unit", id);
	else if (spot && !(light->cos_inner <= 1.0f && light->cos_inner >= light->cos_outer && light->cos_outer >= -1.0f))
		build_refuse(build, "light %u: the cosines %g and %g of its cone are not 1 >= inner >= outer >= -1", id,
		             (double)light->cos_inner, (double)light->cos_outer);
	if (!build_goes_on(build))
		return 0;
	return build_add(build, &build->lights, light, sizeof *light, "light");
}

void stilb_scene_build_camera(stilb_scene_build *build, const stilb_scene_camera *camera)
{
	STILB_ASSERT(camera);
	if (!build_goes_on(build))
		return;
	const float angles[3] = {camera->yaw, camera->pitch, camera->roll};
	if (!build_within(camera->position, 3, -BUILD_FAR, BUILD_FAR) || !build_within(angles, 3, -FLT_MAX, FLT_MAX))
		build_refuse(build, "camera: its position is not within 1e18 m, or an angle is not finite");
	else if (!(camera->fov_y > 0.0f && camera->fov_y < 3.1415925f))
		build_refuse(build, "camera: the field of view %g is not between 0 and pi", (double)camera->fov_y);
	else if (!(camera->near_z > 0.0f && camera->near_z < camera->far_z && camera->far_z <= BUILD_FAR))
		build_refuse(build, "camera: near %g and far %g are not 0 < near < far", (double)camera->near_z,
		             (double)camera->far_z);
	build->camera = *camera;
	build->has_camera = true;
}

/* ---- the scene --------------------------------------------------------------------------------------------------- */

/* Moves meshes and textures, copies the rest. */
static void build_fill(stilb_scene_build *build, stilb_scene *scene)
{
	const build_model *models = build->models.items;
	const build_mesh *meshes = build->meshes.items;
	const stilb_mat4 *nodes = build->nodes.items;
	const stilb_scene_build_part *parts = build->parts.items;
	const struct {
		void *to;
		const build_list *from;
		size_t size;
	} arrays[] = {{scene->textures, &build->textures, sizeof *scene->textures},
	              {scene->materials, &build->materials, sizeof *scene->materials},
	              {scene->lights, &build->lights, sizeof *scene->lights}};
	for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
		if (arrays[i].from->count > 0)
			memcpy(arrays[i].to, arrays[i].from->items, arrays[i].from->count * arrays[i].size);
	for (uint32_t i = 0; i < scene->mesh_count; i++)
		scene->meshes[i] = meshes[i].mesh;
	build->meshes.count = build->textures.count = 0;
	for (uint32_t m = 0; m < scene->model_count; m++) {
		uint32_t end = m + 1 < scene->model_count ? models[m + 1].first_part : scene->part_count;
		scene->first_part[m] = models[m].first_part;
		for (uint32_t p = models[m].first_part; p < end; p++) {
			scene->part_mesh[p] = parts[p].mesh;
			scene->part_material[p] = parts[p].material;
			scene->part_transform[p] = nodes[models[m].node];
		}
	}
	scene->first_part[scene->model_count] = scene->part_count;
	for (uint32_t m = 0; m < scene->model_count; m++)
		scene_fit_bounds(scene, m);
	scene->camera = build->has_camera ? build->camera : scene_camera_around(scene);
	STILB_CHECK(scene_is_sound(scene));
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
	if (result == STILB_OK && build->lights.count > 0)
		result = scene_add_lights(scene, build->lights.count);
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
