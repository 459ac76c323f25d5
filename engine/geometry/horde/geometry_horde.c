#include "geometry/horde/geometry_horde.h"

#include "geometry/geometry_impostor_internal.h"
#include "scene/play/scene_play.h"

#include <math.h>
#include <stdlib.h>

#define HORDE_ERROR 0.5f /* pixels by which levels may be off, the default of frames */

/* A model, and what those that look like it have in common. */
typedef struct horde_model {
	uint64_t key;
	uint32_t id;
} horde_model;

/* Models first .. first + count - 1 of the sorted list. */
typedef struct horde {
	uint32_t first, count;
	uint64_t triangles; /* of all together */
} horde;

stilb_geometry_horde_desc stilb_geometry_horde_desc_default(void)
{
	return (stilb_geometry_horde_desc){.impostor = stilb_geometry_impostor_desc_default(),
	                                   .bytes = (uint64_t)128 << 20};
}

/* True if the model may have an impostor, and has none. */
static bool horde_may(const stilb_scene *scene, uint32_t model)
{
	uint32_t first = scene->first_part[model], end = scene->first_part[model + 1];
	if (first == end || !(scene->bounds.radius[model] > 0.0f) ||
	    (model < scene->impostor_model_count && scene->model_impostor[model] > 0))
		return false;
	for (uint32_t p = first; p < end; p++) {
		uint32_t mesh = scene->part_mesh[p], material = scene->part_material[p];
		if (mesh == STILB_SCENE_NONE || material == STILB_SCENE_NONE ||
		    stilb_scene_animation_deform(scene->animation, mesh) || stilb_scene_mesh_is_posed(scene, mesh))
			return false;
		const float *emission = scene->materials[material].emission;
		if (emission[0] > 0.0f || emission[1] > 0.0f || emission[2] > 0.0f)
			return false;
	}
	return true;
}

static uint64_t horde_key(const stilb_scene *scene, uint32_t model)
{
	uint32_t first = scene->first_part[model];
	size_t size = (scene->first_part[model + 1] - first) * sizeof(uint32_t);
	uint64_t key = stilb_hash_fnv1a64(STILB_FNV1A64_START, scene->part_mesh + first, size);
	return stilb_hash_fnv1a64(key, scene->part_material + first, size);
}

static int horde_by_key(const void *a, const void *b)
{
	const horde_model *x = a, *y = b;
	return x->key != y->key ? (x->key > y->key) - (x->key < y->key) : (x->id > y->id) - (x->id < y->id);
}

static int horde_by_triangles(const void *a, const void *b)
{
	const horde *x = a, *y = b;
	return x->triangles != y->triangles ? (x->triangles < y->triangles) - (x->triangles > y->triangles)
	                                    : (x->first > y->first) - (x->first < y->first);
}

/* The largest length of a column: how much a transform stretches. */
static float horde_stretch(const stilb_mat4 *m)
{
	float most = 0.0f;
	for (size_t c = 0; c < 3; c++) {
		const float *column = m->m + 4 * c;
		most = fmaxf(most, column[0] * column[0] + column[1] * column[1] + column[2] * column[2]);
	}
	return sqrtf(most);
}

/* True if the parts of `model` are those of `like`, and lie in the same places relative to the first one. */
static bool horde_alike(const stilb_scene *scene, uint32_t like, uint32_t model)
{
	uint32_t a = scene->first_part[like], b = scene->first_part[model], count = scene->first_part[like + 1] - a;
	stilb_mat4 inverse;
	if (scene->first_part[model + 1] - b != count || !geometry_impostor_invert(&scene->part_transform[a], &inverse))
		return false;
	for (uint32_t p = 0; p < count; p++) {
		if (scene->part_mesh[a + p] != scene->part_mesh[b + p] ||
		    scene->part_material[a + p] != scene->part_material[b + p])
			return false;
		if (p == 0)
			continue;
		stilb_mat4 wanted =
			stilb_mat4_multiply(stilb_mat4_multiply(scene->part_transform[b], inverse), scene->part_transform[a + p]);
		/* Rounding, and what no pixel of an impostor shows. */
		float radius = scene->bounds.radius[model], far = 0.0f;
		for (int i = 12; i < 15; i++)
			far += fabsf(scene->part_transform[b].m[i]);
		for (int i = 0; i < 16; i++) {
			float most = i < 12 ? 1e-3f * horde_stretch(&scene->part_transform[b]) : 1e-3f * radius + 1e-6f * far;
			if (!(fabsf(wanted.m[i] - scene->part_transform[b + p].m[i]) <= most))
				return false;
		}
	}
	return true;
}

/* Triangles that frames draw of a model from where its impostor may take its place. */
static uint64_t horde_triangles(const stilb_scene *scene, uint32_t model, uint32_t side)
{
	/* There so many texels of the impostor's sphere are a pixel: this is a metre in pixels. */
	float meter = (float)side / (2.0f * STILB_SCENE_IMPOSTOR_TEXELS * scene->bounds.radius[model]);
	uint64_t triangles = 0;
	for (uint32_t p = scene->first_part[model]; p < scene->first_part[model + 1]; p++) {
		const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[p]];
		uint32_t level = 0;
		float pixels = meter * horde_stretch(&scene->part_transform[p]);
		while (level < mesh->level_count && mesh->levels[level].error * pixels <= HORDE_ERROR)
			level++;
		triangles += (level == 0 ? mesh->index_count : mesh->levels[level - 1].index_count) / 3;
	}
	return triangles;
}

/* Gathers the hordes that an impostor makes cheaper. Returns their number. */
static uint32_t hordes_find(const stilb_scene *scene, const horde_model *models, uint32_t count, uint32_t side,
                            horde *hordes)
{
	uint32_t found = 0;
	for (uint32_t first = 0, next; first < count; first = next) {
		next = first + 1;
		while (next < count && models[next].key == models[first].key)
			next++;
		uint64_t triangles = horde_triangles(scene, models[first].id, side);
		if (next - first >= STILB_GEOMETRY_HORDE_MODELS && triangles >= STILB_GEOMETRY_HORDE_TRIANGLES)
			hordes[found++] = (horde){first, next - first, triangles * (next - first)};
	}
	qsort(hordes, found, sizeof *hordes, horde_by_triangles);
	return found;
}

/* Bakes the first model's impostor, and gives it to those that are like it. *made is counted up. */
static stilb_result horde_make(stilb_scene *scene, const stilb_geometry_horde_desc *desc, const horde_model *models,
                               uint32_t count, stilb_job_pool *pool, uint32_t worker, uint32_t *made)
{
	uint32_t alike = 0, id;
	for (uint32_t i = 0; i < count; i++)
		alike += horde_alike(scene, models[0].id, models[i].id);
	if (alike < STILB_GEOMETRY_HORDE_MODELS)
		return STILB_OK;
	stilb_scene_impostor impostor;
	stilb_result result =
		stilb_geometry_impostor_of_model(scene, models[0].id, &desc->impostor, pool, worker, &impostor);
	if (result == STILB_ERROR_ARGUMENT) /* it has none */
		return STILB_OK;
	if (result == STILB_OK)
		result = stilb_scene_add_impostor(scene, &impostor, &id);
	if (result != STILB_OK) {
		stilb_scene_impostor_finish(&impostor);
		return result;
	}
	*made += 1;
	for (uint32_t i = 0; i < count && result == STILB_OK; i++)
		if (horde_alike(scene, models[0].id, models[i].id))
			result = stilb_scene_set_impostor(scene, models[i].id, id + 1);
	return result;
}

stilb_result stilb_geometry_hordes(stilb_scene *scene, const stilb_geometry_horde_desc *desc, stilb_job_pool *pool,
                                   uint32_t worker, uint32_t *made)
{
	STILB_ASSERT(scene && desc && made);
	*made = 0;
	if (scene->impostor_count > 0 && !stilb_scene_impostors_are_current(scene))
		stilb_scene_remove_impostors(scene);
	if (scene->model_count < STILB_GEOMETRY_HORDE_MODELS)
		return STILB_OK;
	horde_model *models = stilb_memory_alloc(scene->model_count, sizeof *models);
	horde *hordes = stilb_memory_alloc(scene->model_count, sizeof *hordes);
	stilb_result result = models && hordes ? STILB_OK : stilb_fail(STILB_ERROR_MEMORY, "no memory to look for hordes");
	uint32_t count = 0;
	for (uint32_t m = 0; m < scene->model_count && result == STILB_OK; m++)
		if (horde_may(scene, m))
			models[count++] = (horde_model){horde_key(scene, m), m};
	if (count > 0)
		qsort(models, count, sizeof *models, horde_by_key);
	uint64_t side = (uint64_t)desc->impostor.grid * desc->impostor.side, each = side * side * 2 * 8;
	uint32_t found = count > 0 ? hordes_find(scene, models, count, desc->impostor.side, hordes) : 0;
	for (uint32_t h = 0; h < found && result == STILB_OK && (*made + 1) * each <= desc->bytes; h++) {
		if (desc->give_up && desc->give_up(desc->user))
			break;
		result = horde_make(scene, desc, models + hordes[h].first, hordes[h].count, pool, worker, made);
	}
	free(models);
	free(hordes);
	return result;
}
