/* The arrays of what moves: made, freed, checked. */
#include "scene/scene_animation_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void scene_animation_arrays(stilb_scene_animation *a, scene_animation_array arrays[SCENE_ANIMATION_ARRAYS])
{
	const scene_animation_array all[SCENE_ANIMATION_ARRAYS] = {
		{(void **)&a->nodes, a->node_count, sizeof *a->nodes},
		{(void **)&a->clips, a->clip_count, sizeof *a->clips},
		{(void **)&a->channels, a->channel_count, sizeof *a->channels},
		{(void **)&a->skins, a->skin_count, sizeof *a->skins},
		{(void **)&a->joints, a->joint_count, sizeof *a->joints},
		{(void **)&a->inverse_binds, a->joint_count, sizeof *a->inverse_binds},
		{(void **)&a->times, a->time_count, sizeof *a->times},
		{(void **)&a->values, a->value_count, sizeof *a->values},
		{(void **)&a->weights, a->weight_count, sizeof *a->weights},
	};
	memcpy(arrays, all, sizeof all);
}

void scene_deform_arrays(stilb_scene_deform *d, uint32_t vertex_count,
                         scene_animation_array arrays[SCENE_DEFORM_ARRAYS])
{
	uint64_t influences = (uint64_t)vertex_count * d->influences, numbers = 3ull * vertex_count * d->targets;
	const scene_animation_array all[SCENE_DEFORM_ARRAYS] = {
		{(void **)&d->joints, influences, sizeof *d->joints},    {(void **)&d->weights, influences, sizeof *d->weights},
		{(void **)&d->positions, numbers, sizeof *d->positions}, {(void **)&d->normals, numbers, sizeof *d->normals},
		{(void **)&d->tangents, numbers, sizeof *d->tangents},
	};
	memcpy(arrays, all, sizeof all);
}

stilb_result scene_deform_create(stilb_scene_deform *deform, uint32_t vertex_count, bool normals, bool tangents)
{
	scene_animation_array arrays[SCENE_DEFORM_ARRAYS];
	scene_deform_arrays(deform, vertex_count, arrays);
	bool good = true;
	for (int i = 0; i < SCENE_DEFORM_ARRAYS; i++) {
		bool wanted = arrays[i].count > 0 && (normals || arrays[i].at != (void **)&deform->normals) &&
		              (tangents || arrays[i].at != (void **)&deform->tangents);
		*arrays[i].at = wanted ? calloc(arrays[i].count, arrays[i].size) : NULL;
		good &= !wanted || *arrays[i].at;
	}
	if (good)
		return STILB_OK;
	scene_deform_finish(deform);
	return stilb_fail(STILB_ERROR_MEMORY, "no memory for the skin and %u morph targets of a mesh", deform->targets);
}

void scene_deform_finish(stilb_scene_deform *deform)
{
	free(deform->joints);
	free(deform->weights);
	free(deform->positions);
	free(deform->normals);
	free(deform->tangents);
	deform->joints = NULL;
	deform->weights = deform->positions = deform->normals = deform->tangents = NULL;
}

stilb_result scene_animation_create(const stilb_scene_animation *counts, stilb_scene_animation **out)
{
	scene_animation_array arrays[SCENE_ANIMATION_ARRAYS];
	stilb_scene_animation *made = calloc(1, sizeof *made);
	*out = NULL;
	if (!made)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for what moves");
	*made = (stilb_scene_animation){
		.node_count = counts->node_count,
		.clip_count = counts->clip_count,
		.channel_count = counts->channel_count,
		.skin_count = counts->skin_count,
		.joint_count = counts->joint_count,
		.deform_count = counts->deform_count,
		.time_count = counts->time_count,
		.value_count = counts->value_count,
		.weight_count = counts->weight_count,
	};
	scene_animation_arrays(made, arrays);
	made->deforms = calloc(made->deform_count + 1ull, sizeof *made->deforms);
	bool good = made->deforms;
	for (int i = 0; i < SCENE_ANIMATION_ARRAYS; i++) {
		*arrays[i].at = calloc(arrays[i].count + 1, arrays[i].size);
		good &= *arrays[i].at ? true : false;
	}
	if (good) {
		*out = made;
		return STILB_OK;
	}
	scene_animation_finish(made);
	return stilb_fail(STILB_ERROR_MEMORY, "no memory for what moves");
}

void scene_animation_finish(stilb_scene_animation *a)
{
	scene_animation_array arrays[SCENE_ANIMATION_ARRAYS];
	if (!a)
		return;
	for (uint32_t d = 0; a->deforms && d < a->deform_count; d++)
		scene_deform_finish(&a->deforms[d]);
	free(a->deforms);
	scene_animation_arrays(a, arrays);
	for (int i = 0; i < SCENE_ANIMATION_ARRAYS; i++)
		free(*arrays[i].at);
	free(a);
}

/* ---- checks ------------------------------------------------------------------------------------------------------ */

/* True if first .. first + count - 1 are below end. */
static bool animation_within(uint64_t first, uint64_t count, uint64_t end)
{
	return first <= end && count <= end - first;
}

static bool animation_is_finite(const float *numbers, uint64_t count)
{
	float sum = 0.0f;
	for (uint64_t i = 0; i < count; i++)
		sum += numbers[i] * 0.0f; /* NaN for NaN and infinity */
	return sum == 0.0f;
}

static bool animation_name_ends(const char *name, size_t size)
{
	return memchr(name, 0, size);
}

static bool animation_channel_is_sound(const stilb_scene_animation *a, const stilb_scene_channel *channel)
{
	static const uint32_t widths[STILB_SCENE_PATHS] = {3, 4, 3, 0};
	if ((uint32_t)channel->path >= STILB_SCENE_PATHS ||
	    (uint32_t)channel->interpolation >= STILB_SCENE_INTERPOLATIONS || channel->node >= a->node_count ||
	    channel->key_count == 0 || !animation_within(channel->first_time, channel->key_count, a->time_count))
		return false;
	const stilb_scene_rest *node = &a->nodes[channel->node];
	bool weights = channel->path == STILB_SCENE_PATH_WEIGHTS;
	uint32_t width = weights ? node->weight_count : widths[channel->path];
	uint64_t numbers = (uint64_t)channel->key_count * width * (channel->interpolation == STILB_SCENE_CUBIC ? 3 : 1);
	if (width == 0 || channel->width != width || !(node->moves || weights) ||
	    !animation_within(channel->first_value, numbers, a->value_count))
		return false;
	const float *times = a->times + channel->first_time;
	bool ascends = times[0] >= 0.0f;
	for (uint32_t k = 1; k < channel->key_count; k++)
		ascends &= times[k] >= times[k - 1];
	return ascends;
}

static bool animation_clips_are_sound(const stilb_scene_animation *a)
{
	bool sound = animation_is_finite(a->times, a->time_count) && animation_is_finite(a->values, a->value_count);
	for (uint32_t c = 0; sound && c < a->channel_count; c++)
		sound = animation_channel_is_sound(a, &a->channels[c]);
	for (uint32_t c = 0; sound && c < a->clip_count; c++) {
		const stilb_scene_clip *clip = &a->clips[c];
		sound = animation_name_ends(clip->name, sizeof clip->name) && clip->duration >= 0.0f &&
		        isfinite(clip->duration) &&
		        animation_within(clip->first_channel, clip->channel_count, a->channel_count);
	}
	return sound;
}

static bool animation_skins_are_sound(const stilb_scene_animation *a)
{
	bool sound = true;
	for (uint32_t j = 0; sound && j < a->joint_count; j++)
		sound = a->joints[j] < a->node_count && animation_is_finite(a->inverse_binds[j].m, 16);
	for (uint32_t s = 0; sound && s < a->skin_count; s++)
		sound = animation_name_ends(a->skins[s].name, sizeof a->skins[s].name) &&
		        animation_within(a->skins[s].first_joint, a->skins[s].joint_count, a->joint_count);
	return sound;
}

static bool animation_deforms_are_sound(const stilb_scene *scene)
{
	const stilb_scene_animation *a = scene->animation;
	bool sound = true;
	for (uint32_t i = 0; sound && i < a->deform_count; i++) {
		const stilb_scene_deform *d = &a->deforms[i];
		sound = d->mesh < scene->mesh_count && (i == 0 || a->deforms[i - 1].mesh < d->mesh) && d->influences % 4 == 0;
		if (!sound)
			break;
		const stilb_scene_mesh *mesh = &scene->meshes[d->mesh];
		uint64_t vertices = mesh->vertex_count, numbers = 3 * vertices * d->targets;
		sound = animation_is_finite(d->weights, vertices * d->influences) &&
		        animation_is_finite(d->positions, numbers) &&
		        (!d->normals || animation_is_finite(d->normals, numbers)) &&
		        (!d->tangents || (mesh->extras && animation_is_finite(d->tangents, numbers)));
		for (uint64_t w = 0; sound && w < vertices * d->influences; w++)
			sound = d->weights[w] >= 0.0f;
	}
	return sound;
}

const stilb_scene_deform *stilb_scene_animation_deform(const stilb_scene_animation *a, uint32_t mesh)
{
	uint32_t low = 0, high = a ? a->deform_count : 0;
	while (low < high) {
		uint32_t middle = low + (high - low) / 2;
		if (a->deforms[middle].mesh < mesh)
			low = middle + 1;
		else
			high = middle;
	}
	return a && low < a->deform_count && a->deforms[low].mesh == mesh ? &a->deforms[low] : NULL;
}

uint32_t scene_deform_joints(const stilb_scene_deform *deform, uint32_t vertex_count)
{
	uint32_t joints = 0;
	for (uint64_t i = 0; i < (uint64_t)vertex_count * deform->influences; i++)
		joints = deform->joints[i] >= joints ? deform->joints[i] + 1u : joints;
	return joints;
}

/* True if the node's skin has the joints, and the node the weights, of the meshes that the node shows. joints: those
 * that each deform needs. */
static bool animation_node_fits(const stilb_scene *scene, const stilb_scene_rest *node, const uint32_t *joints)
{
	const stilb_scene_animation *a = scene->animation;
	uint32_t end = scene->first_part[node->first_model + node->model_count];
	for (uint32_t p = scene->first_part[node->first_model]; p < end; p++) {
		const stilb_scene_deform *d = stilb_scene_animation_deform(a, scene->part_mesh[p]);
		if (d && (d->targets > node->weight_count ||
		          (node->skin != STILB_SCENE_NONE && joints[d - a->deforms] > a->skins[node->skin].joint_count)))
			return false;
	}
	return true;
}

static bool animation_nodes_are_sound(const stilb_scene *scene, const uint32_t *joints)
{
	const stilb_scene_animation *a = scene->animation;
	bool sound = animation_is_finite(a->weights, a->weight_count);
	uint32_t models = 0; /* of the nodes before */
	for (uint32_t n = 0; sound && n < a->node_count; n++) {
		const stilb_scene_rest *node = &a->nodes[n];
		if (node->model_count > 0 && node->first_model < models)
			return false;
		sound = animation_name_ends(node->name, sizeof node->name) &&
		        (node->parent < n || node->parent == STILB_SCENE_NONE) && animation_is_finite(node->local.m, 16) &&
		        animation_is_finite(node->translation, 3) && animation_is_finite(node->rotation, 4) &&
		        animation_is_finite(node->scale, 3) && (node->skin < a->skin_count || node->skin == STILB_SCENE_NONE) &&
		        animation_within(node->first_weight, node->weight_count, a->weight_count) &&
		        animation_within(node->first_model, node->model_count, scene->model_count) &&
		        animation_node_fits(scene, node, joints);
		models = sound && node->model_count > 0 ? node->first_model + node->model_count : models;
	}
	return sound;
}

bool scene_animation_is_sound(const stilb_scene *scene)
{
	const stilb_scene_animation *a = scene->animation;
	if (!a)
		return true;
	if (!animation_clips_are_sound(a) || !animation_skins_are_sound(a) || !animation_deforms_are_sound(scene))
		return false;
	uint32_t *joints = calloc(a->deform_count + 1ull, sizeof *joints);
	for (uint32_t d = 0; joints && d < a->deform_count; d++)
		joints[d] = scene_deform_joints(&a->deforms[d], scene->meshes[a->deforms[d].mesh].vertex_count);
	bool sound = joints && animation_nodes_are_sound(scene, joints);
	free(joints);
	return sound;
}
