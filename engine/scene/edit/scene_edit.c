/* Models that come, go, move and hide, and their bounds. */
#include "scene/edit/scene_check.h"
#include "scene/edit/scene_edit_internal.h"
#include "scene/edit/scene_node.h"
#include "scene/play/scene_play_internal.h"
#include "scene/scene_internal.h"

#include <math.h>

#define EDIT_MARGIN 1.00001f /* of radii, for rounding */

/* ---- spheres ----------------------------------------------------------------------------------------------------- */

/* A sphere around the vertices of a mesh, which is then known. */
static stilb_sphere edit_measure_mesh(stilb_scene *scene, uint32_t mesh)
{
	stilb_sphere *known = &scene->edits->mesh_sphere[mesh];
	const stilb_scene_mesh *from = &scene->meshes[mesh];
	STILB_ASSERT(mesh < scene->mesh_count);
	float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY}, most = 0.0f;
	for (uint32_t v = 0; v < from->vertex_count; v++)
		for (int i = 0; i < 3; i++) {
			float at = from->vertices[v].position[i];
			bool usable = fabsf(at) <= SCENE_FAR; /* files may have others, which no picture shows */
			low[i] = usable && at < low[i] ? at : low[i];
			high[i] = usable && at > high[i] ? at : high[i];
		}
	float center[3];
	for (int i = 0; i < 3; i++)
		center[i] = low[i] <= high[i] ? 0.5f * low[i] + 0.5f * high[i] : 0.0f;
	for (uint32_t v = 0; v < from->vertex_count; v++) {
		const float *p = from->vertices[v].position;
		float x = p[0] - center[0], y = p[1] - center[1], z = p[2] - center[2], square = x * x + y * y + z * z;
		most = square > most && square < INFINITY ? square : most;
	}
	*known = (stilb_sphere){center[0], center[1], center[2], sqrtf(most) * EDIT_MARGIN};
	return *known;
}

void scene_edit_measure(stilb_scene *scene)
{
	stilb_scene_edits *edits = scene->edits;
	for (uint32_t m = 0; m < scene->mesh_count && edits->unmeasured; m++)
		if (edits->meshes.users[m] > 0 && isnan(edits->mesh_sphere[m].radius))
			edit_measure_mesh(scene, m);
	edits->unmeasured = false;
}

static inline stilb_sphere edit_mesh_sphere(stilb_scene *scene, uint32_t mesh)
{
	stilb_sphere known = scene->edits->mesh_sphere[mesh];
	return isnan(known.radius) ? edit_measure_mesh(scene, mesh) : known;
}

/* A sphere that holds the transformed one. The greatest factor by which a matrix A stretches is at most the root of the
 * largest row sum of |A^T A|; that is exact where A keeps right angles. */
static inline stilb_sphere edit_sphere_place(const stilb_mat4 *transform, stilb_sphere sphere)
{
	const float *m = transform->m;
	float at[3];
	for (int row = 0; row < 3; row++)
		at[row] = m[row] * sphere.x + m[4 + row] * sphere.y + m[8 + row] * sphere.z + m[12 + row];
	float xx = m[0] * m[0] + m[1] * m[1] + m[2] * m[2], xy = fabsf(m[0] * m[4] + m[1] * m[5] + m[2] * m[6]);
	float yy = m[4] * m[4] + m[5] * m[5] + m[6] * m[6], xz = fabsf(m[0] * m[8] + m[1] * m[9] + m[2] * m[10]);
	float zz = m[8] * m[8] + m[9] * m[9] + m[10] * m[10], yz = fabsf(m[4] * m[8] + m[5] * m[9] + m[6] * m[10]);
	float square = xx + xy + xz, second = yy + xy + yz, third = zz + xz + yz;
	square = square > second ? square : second; /* not fmaxf, which is a call */
	square = square > third ? square : third;
	return (stilb_sphere){at[0], at[1], at[2], sphere.radius * sqrtf(square) * EDIT_MARGIN};
}

/* The smallest sphere around both. */
static inline stilb_sphere edit_sphere_join(stilb_sphere a, stilb_sphere b)
{
	float x = b.x - a.x, y = b.y - a.y, z = b.z - a.z, distance = sqrtf(x * x + y * y + z * z);
	if (distance + b.radius <= a.radius)
		return a;
	if (distance + a.radius <= b.radius)
		return b;
	float radius = 0.5f * (distance + a.radius + b.radius), share = (radius - a.radius) / distance;
	return (stilb_sphere){a.x + share * x, a.y + share * y, a.z + share * z, radius * EDIT_MARGIN};
}

__attribute__((noinline)) static void edit_measure_model(stilb_scene *scene, uint32_t model)
{
	edit_model *own = &scene->edits->models[model];
	uint32_t first = scene->first_part[model];
	own->sphere = edit_mesh_sphere(scene, scene->part_mesh[first]);
	for (uint32_t p = first + 1; p < scene->first_part[model + 1]; p++)
		own->sphere = edit_sphere_join(own->sphere, edit_mesh_sphere(scene, scene->part_mesh[p]));
	own->measured = scene->edits->measures;
}

/* A sphere around the meshes of a model in the space of parts that have one transform. It stays known, so that a model
 * of several parts is moved at the cost of one. */
static inline stilb_sphere edit_model_sphere(stilb_scene *scene, uint32_t model)
{
	const edit_model *own = &scene->edits->models[model];
	if (own->measured != scene->edits->measures)
		edit_measure_model(scene, model);
	return own->sphere;
}

static bool edit_sphere_is_near(stilb_sphere s)
{
	return fabsf(s.x) + fabsf(s.y) + fabsf(s.z) + s.radius <= SCENE_FAR;
}

/* ---- bounds ------------------------------------------------------------------------------------------------------ */

/* Without listing it. True if the model is shown. */
static inline bool edit_put_bounds(stilb_scene *scene, uint32_t model, stilb_sphere sphere)
{
	edit_model *own = &scene->edits->models[model];
	scene->bounds.x[model] = sphere.x;
	scene->bounds.y[model] = sphere.y;
	scene->bounds.z[model] = sphere.z;
	own->radius = sphere.radius;
	if (!own->hidden)
		scene->bounds.radius[model] = sphere.radius;
	return !own->hidden;
}

static inline void edit_set_bounds(stilb_scene *scene, uint32_t model, stilb_sphere sphere)
{
	if (edit_put_bounds(scene, model, sphere))
		scene_edit_moved(scene, model);
}

/* A sphere around the parts of a model. */
static stilb_sphere edit_fit(stilb_scene *scene, uint32_t model)
{
	stilb_sphere sum = {0};
	uint32_t first = scene->first_part[model];
	for (uint32_t p = first; p < scene->first_part[model + 1]; p++) {
		stilb_sphere mesh = edit_mesh_sphere(scene, scene->part_mesh[p]);
		stilb_sphere part = edit_sphere_place(&scene->part_transform[p], mesh);
		sum = p == first ? part : edit_sphere_join(sum, part);
	}
	return sum;
}

/* True if a part of the model shows a mesh that has changed since its bounds were made. */
static bool edit_is_stale(const stilb_scene *scene, uint32_t model)
{
	for (uint32_t p = scene->first_part[model]; p < scene->first_part[model + 1]; p++)
		if (scene->edits->mesh_stale[scene->part_mesh[p]])
			return true;
	return false;
}

static void edit_refit(stilb_scene *scene, uint32_t model)
{
	stilb_sphere sphere = edit_fit(scene, model);
	if (!edit_sphere_is_near(sphere))
		sphere = (stilb_sphere){0.0f, 0.0f, 0.0f, INFINITY}; /* seen from everywhere */
	edit_set_bounds(scene, model, sphere);
}

void scene_edit_refit(stilb_scene *scene, uint32_t model)
{
	edit_model *own = &scene->edits->models[model];
	STILB_ASSERT(own->next == EDIT_IN_USE);
	own->measured = 0;
	if (!isnan(own->radius))
		edit_refit(scene, model);
}

void scene_edit_settle(stilb_scene *scene)
{
	stilb_scene_edits *edits = scene->edits;
	if (edits->stale_count == 0)
		return;
	for (uint32_t m = 0; m < scene->model_count; m++)
		if (edits->models[m].next == EDIT_IN_USE && !isnan(edits->models[m].radius) && edit_is_stale(scene, m))
			edit_refit(scene, m);
	for (uint32_t m = 0; m < scene->mesh_count; m++)
		edits->mesh_stale[m] = false;
	edits->stale_count = 0;
}

/* ---- models ------------------------------------------------------------------------------------------------------ */

/* STILB_OK if there is such a model and edits can begin. */
static stilb_result edit_find_model(stilb_scene *scene, uint32_t id)
{
	stilb_result result = scene->edits ? STILB_OK : scene_edit_begin(scene);
	if (result != STILB_OK)
		return result;
	if (id >= scene->model_count || scene->edits->models[id].next != EDIT_IN_USE)
		return stilb_fail(STILB_ERROR_ARGUMENT, "there is no model %u", id);
	return STILB_OK;
}

static stilb_result edit_part_check(const stilb_scene *scene, uint32_t model, stilb_scene_build_part part)
{
	const stilb_scene_edits *edits = scene->edits;
	if (!scene_edit_has(&edits->meshes, scene->mesh_count, part.mesh))
		return stilb_fail(STILB_ERROR_ARGUMENT, "model %u: there is no mesh %u", model, part.mesh);
	if (!scene_edit_has(&edits->materials, scene->material_count, part.material))
		return stilb_fail(STILB_ERROR_ARGUMENT, "model %u: there is no material %u", model, part.material);
	return STILB_OK;
}

/* Why a sphere that is not near, or a transform that is not affine, is refused. */
__attribute__((noinline)) static stilb_result edit_refuse_place(uint32_t model, uint32_t mesh,
                                                                const stilb_mat4 *transform)
{
	if (!scene_is_affine(transform))
		return stilb_fail(STILB_ERROR_ARGUMENT, "model %u: its transform is not affine, or not within 1e18", model);
	return stilb_fail(STILB_ERROR_ARGUMENT, "model %u: mesh %u reaches farther than 1e18 m there", model, mesh);
}

/* Adds to *sum the sphere of a mesh at a transform; first: instead of adding. A NaN or an infinity among the elements
 * of the transform is one in the sphere, so that they need not be looked at one by one. */
static inline stilb_result edit_place_check(stilb_scene *scene, uint32_t model, uint32_t mesh,
                                            const stilb_mat4 *transform, bool first, stilb_sphere *sum)
{
	const float *m = transform->m;
	stilb_sphere part = edit_sphere_place(transform, edit_mesh_sphere(scene, mesh));
	part = first ? part : edit_sphere_join(*sum, part);
	*sum = part;
	bool affine = m[3] == 0.0f && m[7] == 0.0f && m[11] == 0.0f && m[15] == 1.0f;
	return affine && edit_sphere_is_near(part) ? STILB_OK : edit_refuse_place(model, mesh, transform);
}

/* Takes a removed model with so many parts out of its list. False: there is none. */
static bool edit_take_model(stilb_scene *scene, uint32_t part_count, uint32_t *id)
{
	stilb_scene_edits *edits = scene->edits;
	uint32_t *link = &edits->free_models[part_count % EDIT_BUCKETS];
	while (*link) {
		uint32_t model = *link - 1;
		if (scene->first_part[model + 1] - scene->first_part[model] == part_count) {
			*link = edits->models[model].next;
			*id = model;
			return true;
		}
		link = &edits->models[model].next;
	}
	return false;
}

/* Makes room for one more model and its parts. False: no memory. */
static bool edit_reserve_model(stilb_scene *scene, uint32_t part_count)
{
	stilb_scene_edits *edits = scene->edits;
	stilb_scene_bounds *bounds = &scene->bounds;
	edit_array models[] = {
		{(void **)&bounds->x, sizeof(float), 0},
		{(void **)&bounds->y, sizeof(float), 0},
		{(void **)&bounds->z, sizeof(float), 0},
		{(void **)&bounds->radius, sizeof(float), 0},
		{(void **)&scene->first_part, sizeof(uint32_t), 1},
		{(void **)&scene->moved, sizeof(uint32_t), 0},
		{(void **)&edits->models, sizeof *edits->models, 0},
		{(void **)&scene->model_node, sizeof(uint32_t), 0},
		{(void **)&scene->model_flags, sizeof(uint8_t), 0},
	};
	edit_array parts[] = {
		{(void **)&scene->part_mesh, sizeof(uint32_t), 0},
		{(void **)&scene->part_material, sizeof(uint32_t), 0},
		{(void **)&scene->part_transform, sizeof(stilb_mat4), 0},
	};
	uint32_t count = scene->model_count, part_end = scene->part_count + part_count;
	if (part_end < part_count)
		return false;
	return (count < edits->model_capacity ||
	        scene_edit_grow(models, sizeof models / sizeof *models, count, count + 1, &edits->model_capacity)) &&
	       (part_end <= edits->part_capacity ||
	        scene_edit_grow(parts, sizeof parts / sizeof *parts, scene->part_count, part_end, &edits->part_capacity));
}

/* The id for a new model of so many parts. */
static stilb_result edit_new_model(stilb_scene *scene, uint32_t part_count, uint32_t *id)
{
	if (edit_take_model(scene, part_count, id))
		return STILB_OK;
	if (scene->model_count == STILB_SCENE_MAX_MODELS)
		return stilb_fail(STILB_ERROR_ARGUMENT, "more than %u models", STILB_SCENE_MAX_MODELS);
	if (!edit_reserve_model(scene, part_count))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for another model");
	*id = scene->model_count++;
	scene->part_count += part_count;
	scene->first_part[scene->model_count] = scene->part_count;
	return STILB_OK;
}

stilb_result stilb_scene_add_model(stilb_scene *scene, const stilb_mat4 *transform, const stilb_scene_build_part *parts,
                                   uint32_t part_count, uint32_t *id)
{
	STILB_ASSERT(transform && (parts || part_count == 0) && id);
	stilb_sphere sphere = {0};
	stilb_result result = scene_edit_begin(scene);
	if (result == STILB_OK && part_count == 0)
		return stilb_fail(STILB_ERROR_ARGUMENT, "model %u: it has no parts", scene->model_count);
	for (uint32_t i = 0; i < part_count && result == STILB_OK; i++) {
		result = edit_part_check(scene, scene->model_count, parts[i]);
		if (result == STILB_OK)
			result = edit_place_check(scene, scene->model_count, parts[i].mesh, transform, i == 0, &sphere);
	}
	uint32_t model;
	if (result == STILB_OK)
		result = edit_new_model(scene, part_count, &model);
	if (result != STILB_OK)
		return result;
	stilb_scene_edits *edits = scene->edits;
	for (uint32_t i = 0; i < part_count; i++) {
		uint32_t part = scene->first_part[model] + i;
		scene->part_mesh[part] = parts[i].mesh;
		scene->part_material[part] = parts[i].material;
		scene->part_transform[part] = *transform;
		edits->meshes.users[parts[i].mesh]++;
		edits->materials.users[parts[i].material]++;
	}
	scene_impostor_forget(scene, model);
	edits->models[model].next = EDIT_IN_USE;
	edits->models[model].hidden = false;
	edits->models[model].measured = 0;
	edits->models[model].figure = 0;
	scene->model_flags[model] = 0;
	scene->revisions.models++;
	edit_set_bounds(scene, model, sphere);
	*id = model;
	return STILB_OK;
}

stilb_result stilb_scene_remove_model(stilb_scene *scene, uint32_t id)
{
	stilb_result result = edit_find_model(scene, id);
	if (result != STILB_OK)
		return result;
	stilb_scene_edits *edits = scene->edits;
	uint32_t first = scene->first_part[id], end = scene->first_part[id + 1];
	for (uint32_t l = 0; l < scene->light_count; l++)
		if (scene->lights[l].face > first && scene->lights[l].face <= end)
			scene->lights[l].face = 0;
	for (uint32_t p = first; p < end; p++) {
		edits->meshes.users[scene->part_mesh[p]]--;
		edits->materials.users[scene->part_material[p]]--;
		scene->part_mesh[p] = scene->part_material[p] = STILB_SCENE_NONE;
	}
	scene_edit_detach(scene, id);
	if (edits->models[id].figure)
		scene_play_forget_model(scene, edits->models[id].figure, id);
	scene->bounds.radius[id] = edits->models[id].radius = (float)NAN;
	scene_edit_moved(scene, id);
	uint32_t *bucket = &edits->free_models[(end - first) % EDIT_BUCKETS];
	edits->models[id].next = *bucket;
	*bucket = id + 1;
	scene->revisions.models++;
	return STILB_OK;
}

/* Moves the parts of a model; `step` is the number of matrices from one part's to the next one's. */
static stilb_result edit_move(stilb_scene *scene, uint32_t id, const stilb_mat4 *transforms, size_t step)
{
	STILB_ASSERT(transforms);
	stilb_result result = edit_find_model(scene, id);
	if (result != STILB_OK)
		return result;
	stilb_sphere sphere = {0};
	uint32_t first = scene->first_part[id], count = scene->first_part[id + 1] - first;
	for (uint32_t i = 0; i < count && result == STILB_OK; i++)
		result = edit_place_check(scene, id, scene->part_mesh[first + i], &transforms[i * step], i == 0, &sphere);
	if (result != STILB_OK)
		return result;
	if (scene->model_node[id])
		scene_edit_detach(scene, id);
	for (uint32_t i = 0; i < count; i++)
		scene->part_transform[first + i] = transforms[i * step];
	edit_set_bounds(scene, id, sphere);
	scene->revisions.places++;
	return STILB_OK;
}

stilb_result stilb_scene_set_transform(stilb_scene *scene, uint32_t id, const stilb_mat4 *transform)
{
	STILB_ASSERT(transform);
	stilb_result result = edit_find_model(scene, id);
	if (result != STILB_OK)
		return result;
	const float *m = transform->m;
	stilb_sphere sphere = edit_sphere_place(transform, edit_model_sphere(scene, id));
	if (m[3] != 0.0f || m[7] != 0.0f || m[11] != 0.0f || m[15] != 1.0f || !edit_sphere_is_near(sphere))
		return edit_move(scene, id, transform, 0); /* part by part, for what is wrong */
	if (scene->model_node[id])
		scene_edit_detach(scene, id);
	for (uint32_t p = scene->first_part[id]; p < scene->first_part[id + 1]; p++)
		scene->part_transform[p] = *transform;
	edit_set_bounds(scene, id, sphere);
	scene->revisions.places++;
	return STILB_OK;
}

stilb_result stilb_scene_set_part_transforms(stilb_scene *scene, uint32_t id, const stilb_mat4 *transforms)
{
	stilb_result result = edit_move(scene, id, transforms, 1);
	if (result == STILB_OK)
		scene_impostor_forget(scene, id);
	return result;
}

stilb_result stilb_scene_set_part(stilb_scene *scene, uint32_t id, uint32_t part, stilb_scene_build_part with)
{
	stilb_result result = edit_find_model(scene, id);
	if (result == STILB_OK && part >= scene->first_part[id + 1] - scene->first_part[id])
		return stilb_fail(STILB_ERROR_ARGUMENT, "model %u: there is no part %u", id, part);
	if (result == STILB_OK)
		result = edit_part_check(scene, id, with);
	if (result != STILB_OK)
		return result;
	uint32_t p = scene->first_part[id] + part;
	stilb_scene_build_part was = {scene->part_mesh[p], scene->part_material[p]};
	scene->part_mesh[p] = with.mesh;
	stilb_sphere sphere = edit_fit(scene, id);
	if (!edit_sphere_is_near(sphere)) {
		scene->part_mesh[p] = was.mesh;
		return stilb_fail(STILB_ERROR_ARGUMENT, "model %u: mesh %u reaches farther than 1e18 m there", id, with.mesh);
	}
	scene->part_material[p] = with.material;
	scene_impostor_forget(scene, id);
	scene->edits->models[id].measured = 0;
	scene->edits->meshes.users[was.mesh]--;
	scene->edits->meshes.users[with.mesh]++;
	scene->edits->materials.users[was.material]--;
	scene->edits->materials.users[with.material]++;
	if (isnan(scene->edits->models[id].radius))
		sphere.radius = (float)NAN; /* its node is still too far away */
	edit_set_bounds(scene, id, sphere);
	scene->revisions.models++;
	return STILB_OK;
}

stilb_result stilb_scene_show_model(stilb_scene *scene, uint32_t id, bool shown)
{
	stilb_result result = edit_find_model(scene, id);
	if (result != STILB_OK || scene->edits->models[id].hidden == !shown)
		return result;
	scene->edits->models[id].hidden = !shown;
	scene->bounds.radius[id] = shown ? scene->edits->models[id].radius : (float)NAN;
	scene_edit_moved(scene, id);
	scene->revisions.places++;
	return STILB_OK;
}

stilb_result stilb_scene_set_model_flags(stilb_scene *scene, uint32_t id, uint32_t flags)
{
	stilb_result result = edit_find_model(scene, id);
	if (result == STILB_OK && flags > STILB_SCENE_MODEL_FLAGS)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "model %u: its flags are %u; STILB_SCENE_MODEL_FLAGS, %u, are all "
		                  "there are",
		                  id, flags, STILB_SCENE_MODEL_FLAGS);
	if (result != STILB_OK || scene->model_flags[id] == flags)
		return result;
	scene_set_model_flags(scene, id, flags);
	scene_edit_moved(scene, id);
	scene->revisions.models++;
	return STILB_OK;
}

void scene_edit_place_model(stilb_scene *scene, uint32_t model, const stilb_mat4 *transform)
{
	stilb_sphere sphere = edit_sphere_place(transform, edit_model_sphere(scene, model));
	bool near = edit_sphere_is_near(sphere);
	for (uint32_t p = scene->first_part[model]; p < scene->first_part[model + 1] && near; p++)
		scene->part_transform[p] = *transform;
	edit_put_bounds(scene, model, near ? sphere : (stilb_sphere){.radius = (float)NAN});
}

/* ---- nodes of models --------------------------------------------------------------------------------------------- */

void scene_edit_detach(stilb_scene *scene, uint32_t model)
{
	edit_model *models = scene->edits->models, *own = &models[model];
	uint32_t node = scene->model_node[model];
	if (!node)
		return;
	if (own->next_on_node)
		models[own->next_on_node - 1].previous_on_node = own->previous_on_node;
	if (own->previous_on_node)
		models[own->previous_on_node - 1].next_on_node = own->next_on_node;
	else
		scene->edits->nodes.first_model[node - 1] = own->next_on_node;
	own->next_on_node = own->previous_on_node = scene->model_node[model] = 0;
}

stilb_result stilb_scene_attach_model(stilb_scene *scene, uint32_t model, uint32_t node)
{
	stilb_result result = edit_find_model(scene, model);
	if (result != STILB_OK)
		return result;
	edit_nodes *nodes = &scene->edits->nodes;
	edit_model *models = scene->edits->models;
	if (node != STILB_SCENE_NONE && (node >= scene->nodes.count || nodes->next[node] != EDIT_IN_USE))
		return stilb_fail(STILB_ERROR_ARGUMENT, "model %u: there is no node %u", model, node);
	scene_edit_detach(scene, model);
	if (node == STILB_SCENE_NONE) {
		if (isnan(models[model].radius)) /* its node was too far away */
			edit_set_bounds(scene, model, edit_fit(scene, model));
		return STILB_OK;
	}
	uint32_t first = nodes->first_model[node];
	models[model].next_on_node = first;
	if (first)
		models[first - 1].previous_on_node = model + 1;
	nodes->first_model[node] = model + 1;
	scene->model_node[model] = node + 1;
	scene_edit_node_changed(nodes, node);
	return STILB_OK;
}
