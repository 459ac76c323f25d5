/* What moves: the hierarchy at rest, clips and skins. Morph targets and weights come with their primitives. */
#include "scene/importer/gltf/gltf.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct animation_reader {
	gltf *from;
	stilb_scene_animation made;
	uint64_t channel_room, joint_room, bind_room, time_room, value_room, weight_room; /* elements of made's arrays */
	uint32_t *place;   /* [nodes of the file] among the listed ones; GLTF_NONE: it is not in the scene */
	uint32_t *skin;    /* [skins of the file] in made; GLTF_NONE: it is left out */
	uint32_t *needed;  /* [parts] joints that the part's vertices name */
	uint32_t *time_of; /* [accessors] 1 + where its numbers are in made.times; 0: not yet */
	uint32_t *value_of;
} animation_reader;

/* Makes room for `needed` elements in an array that grows. */
static stilb_result animation_reserve(void **at, uint64_t *room, uint64_t needed, size_t size)
{
	if (needed <= *room)
		return STILB_OK;
	uint64_t more = needed < 64 ? 64 : needed + needed / 2;
	void *grown = realloc(*at, more * size);
	if (!grown)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for its animations");
	*at = grown;
	*room = more;
	return STILB_OK;
}

/* Counts numbers that are about to be read. */
static stilb_result animation_count(animation_reader *reader, uint64_t numbers)
{
	if (numbers > IMPORTER_MOVING_MOST - reader->from->moving)
		return stilb_fail(STILB_ERROR_FILE, "it has more than %llu numbers that move", IMPORTER_MOVING_MOST);
	reader->from->moving += numbers;
	return STILB_OK;
}

/* ---- nodes ------------------------------------------------------------------------------------------------------- */

/* Moves the deforms of the parts, and notes the joints that they need. */
static void animation_take_deforms(animation_reader *reader)
{
	gltf_parts *parts = &reader->from->parts;
	const stilb_scene *scene = reader->from->import->scene;
	for (uint32_t p = 0; p < parts->count; p++) {
		stilb_scene_deform *deform = &parts->parts[p].deform;
		if (deform->influences == 0 && deform->targets == 0)
			continue;
		deform->mesh = p;
		reader->needed[p] = scene_deform_joints(deform, scene->meshes[p].vertex_count);
		reader->made.deforms[reader->made.deform_count++] = *deform;
		/* What stays is its shape: the arrays have another owner. */
		*deform = (stilb_scene_deform){.influences = deform->influences, .targets = deform->targets};
	}
}

/* Adds the weights of a node's morph targets at rest: its own, or the mesh's, or 0. */
static stilb_result animation_add_weights(animation_reader *reader, uint32_t item, uint32_t mesh,
                                          stilb_scene_rest *node)
{
	gltf *from = reader->from;
	scene_json *json = &from->json;
	stilb_scene_animation *made = &reader->made;
	uint32_t count = 0;
	for (uint32_t p = from->parts.first[mesh]; p < from->parts.first[mesh + 1]; p++)
		count = from->parts.parts[p].deform.targets > count ? from->parts.parts[p].deform.targets : count;
	stilb_result result = animation_count(reader, count);
	if (result == STILB_OK)
		result = animation_reserve((void **)&made->weights, &reader->weight_room, made->weight_count + (uint64_t)count,
		                           sizeof *made->weights);
	if (result != STILB_OK)
		return result;
	uint32_t array = scene_json_array(json, item, "weights");
	if (array == GLTF_NONE)
		array = scene_json_array(json, from->lists[GLTF_MESHES].items[mesh], "weights");
	node->first_weight = made->weight_count;
	node->weight_count = count;
	uint32_t at = scene_json_first(json, array);
	for (uint32_t w = 0; w < count; w++) {
		float weight = at == GLTF_NONE ? 0.0f : (float)scene_json_value(json, at);
		made->weights[made->weight_count++] = isfinite(weight) ? weight : 0.0f;
		at = at == GLTF_NONE ? GLTF_NONE : scene_json_after(json, array, at);
	}
	return scene_json_check(json);
}

static bool animation_place_is_finite(const gltf_place *place)
{
	float sum = 0.0f;
	for (int i = 0; i < 4; i++)
		sum +=
			(i < 3 ? place->pose.translation[i] + place->pose.scale[i] : 0.0f) * 0.0f + place->pose.rotation[i] * 0.0f;
	return sum == 0.0f;
}

static stilb_result animation_add_node(animation_reader *reader, uint32_t n)
{
	gltf *from = reader->from;
	const gltf_node *listed = &from->nodes[n];
	gltf_place place = gltf_node_place(from, listed->item);
	stilb_scene_rest *node = &reader->made.nodes[n];
	if (!animation_place_is_finite(&place))
		place = (gltf_place){.pose = {.rotation = {0, 0, 0, 1}, .scale = {1, 1, 1}}, .local = place.local};
	*node = (stilb_scene_rest){.parent = listed->parent,
	                           .local = place.local,
	                           .moves = place.moves,
	                           .first_model = listed->first_model,
	                           .model_count = listed->model_count,
	                           .skin = STILB_SCENE_NONE};
	memcpy(node->translation, place.pose.translation, sizeof node->translation);
	memcpy(node->rotation, place.pose.rotation, sizeof node->rotation);
	memcpy(node->scale, place.pose.scale, sizeof node->scale);
	scene_json_string(&from->json, listed->item, "name", node->name, sizeof node->name);
	uint32_t mesh = gltf_reference(from, listed->item, "mesh", GLTF_MESHES);
	if (mesh == GLTF_NONE)
		return scene_json_check(&from->json);
	return animation_add_weights(reader, listed->item, mesh, node);
}

/* ---- skins ------------------------------------------------------------------------------------------------------- */

/* Reads a skin behind those that are there. On failure the counts are as before. */
static stilb_result animation_read_skin(animation_reader *reader, uint32_t item, stilb_scene_skin *skin)
{
	gltf *from = reader->from;
	scene_json *json = &from->json;
	stilb_scene_animation *made = &reader->made;
	uint32_t array = scene_json_array(json, item, "joints"), count = 0;
	gltf_accessor binds = {0};
	for (uint32_t at = scene_json_first(json, array); at != GLTF_NONE; at = scene_json_after(json, array, at)) {
		uint64_t joint = scene_json_whole(json, at);
		uint32_t place = joint < from->lists[GLTF_NODES].count ? reader->place[joint] : GLTF_NONE;
		if (json->fault[0] || place == GLTF_NONE)
			return json->fault[0]
			           ? scene_json_check(json)
			           : stilb_fail(STILB_ERROR_FILE, "joint %llu is not in the scene", (unsigned long long)joint);
		stilb_result result = animation_reserve((void **)&made->joints, &reader->joint_room,
		                                        made->joint_count + count + 1ull, sizeof *made->joints);
		if (result != STILB_OK)
			return result;
		STILB_ASSERT(made->joints);
		made->joints[made->joint_count + count++] = place;
	}
	uint32_t index = gltf_reference(from, item, "inverseBindMatrices", GLTF_ACCESSORS);
	stilb_result result = scene_json_check(json);
	if (result == STILB_OK && made->joint_count + (uint64_t)count > STILB_SCENE_MAX_MODELS)
		result = stilb_fail(STILB_ERROR_FILE, "its skins have more than %u joints", STILB_SCENE_MAX_MODELS);
	if (result == STILB_OK && index != GLTF_NONE)
		result = gltf_accessor_open(from, index, 1u << 15, &binds);
	if (result == STILB_OK && index != GLTF_NONE && binds.count < count)
		result = stilb_fail(STILB_ERROR_FILE, "accessor %u has %llu matrices for %u joints", index,
		                    (unsigned long long)binds.count, count);
	if (result == STILB_OK)
		result = animation_reserve((void **)&made->inverse_binds, &reader->bind_room,
		                           made->joint_count + (uint64_t)count, sizeof *made->inverse_binds);
	for (uint32_t j = 0; result == STILB_OK && j < count; j++) {
		STILB_ASSERT(made->inverse_binds);
		stilb_mat4 *bind = &made->inverse_binds[made->joint_count + j];
		*bind = stilb_mat4_identity();
		if (index != GLTF_NONE)
			gltf_accessor_read(&binds, j, bind->m);
		if (!gltf_is_finite(bind))
			result = stilb_fail(STILB_ERROR_FILE, "matrix %u of accessor %u is NaN or infinite", j, index);
	}
	gltf_accessor_finish(&binds);
	*skin = (stilb_scene_skin){.first_joint = made->joint_count, .joint_count = count};
	made->joint_count += result == STILB_OK ? count : 0;
	return result;
}

static stilb_result animation_add_skins(animation_reader *reader)
{
	gltf *from = reader->from;
	stilb_scene_animation *made = &reader->made;
	for (uint32_t s = 0; s < from->lists[GLTF_SKINS].count; s++) {
		char name[96];
		stilb_scene_skin skin;
		gltf_name(from, GLTF_SKINS, s, name);
		stilb_result result = animation_read_skin(reader, from->lists[GLTF_SKINS].items[s], &skin);
		reader->skin[s] = result == STILB_OK ? made->skin_count : GLTF_NONE;
		if (result == STILB_OK) {
			snprintf(skin.name, sizeof skin.name, "%.63s", name);
			made->skins[made->skin_count++] = skin;
		} else if ((result = gltf_leave_out(from, result, IMPORTER_LOSS_BAD_SKINS, name)) != STILB_OK) {
			return result;
		}
	}
	return STILB_OK;
}

/* Gives a node its skin if that has the joints that the node's meshes name. */
static stilb_result animation_dress_node(animation_reader *reader, uint32_t n)
{
	gltf *from = reader->from;
	uint32_t item = from->nodes[n].item, mesh = gltf_reference(from, item, "mesh", GLTF_MESHES);
	uint32_t index = gltf_reference(from, item, "skin", GLTF_SKINS);
	if (from->json.fault[0] || index == GLTF_NONE || reader->skin[index] == GLTF_NONE || mesh == GLTF_NONE)
		return scene_json_check(&from->json);
	const stilb_scene_skin *skin = &reader->made.skins[reader->skin[index]];
	for (uint32_t p = from->parts.first[mesh]; p < from->parts.first[mesh + 1]; p++)
		if (reader->needed[p] > skin->joint_count) {
			stilb_fail(STILB_ERROR_FILE, "a vertex names joint %u of %u", reader->needed[p] - 1, skin->joint_count);
			return gltf_leave_out(from, STILB_ERROR_FILE, IMPORTER_LOSS_BAD_SKINS, skin->name);
		}
	reader->made.nodes[n].skin = reader->skin[index];
	return STILB_OK;
}

/* ---- clips ------------------------------------------------------------------------------------------------------- */

/* Makes a rotation unit that comes as integers, whose length may be off by 1 / 32767: rotations are mixed by their
 * weights. */
static void animation_settle_rotation(float q[4])
{
	float square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
	for (int i = 0; square > 0.0f && i < 4; i++)
		q[i] /= sqrtf(square);
}

/* Appends all numbers of an accessor to an array, once: *first is where they are. components: as gltf_accessor_open
 * has it; turns: they are rotations; *count: numbers. */
static stilb_result animation_append(animation_reader *reader, uint32_t index, uint32_t components, bool times,
                                     bool turns, uint32_t *first, uint64_t *count)
{
	stilb_scene_animation *made = &reader->made;
	uint32_t *known = times ? &reader->time_of[index] : &reader->value_of[index];
	uint32_t *used = times ? &made->time_count : &made->value_count;
	float **numbers = times ? &made->times : &made->values;
	gltf_accessor accessor;
	stilb_result result = gltf_accessor_open(reader->from, index, components, &accessor);
	if (result != STILB_OK)
		return result;
	*count = accessor.count * accessor.components;
	*first = *known ? *known - 1 : *used;
	if (!*known) {
		result = animation_count(reader, *count);
		if (result == STILB_OK)
			result = animation_reserve((void **)numbers, times ? &reader->time_room : &reader->value_room,
			                           *used + *count + 1, sizeof **numbers);
		float sum = 0.0f, last = 0.0f;
		bool ascends = true;
		for (uint64_t i = 0; result == STILB_OK && i < accessor.count; i++) {
			float *out = *numbers + *used + i * accessor.components;
			gltf_accessor_read(&accessor, i, out);
			if (turns && accessor.type != 5126)
				animation_settle_rotation(out);
			for (uint32_t k = 0; k < accessor.components; k++)
				sum += out[k] * 0.0f; /* NaN for NaN and infinity */
			ascends &= out[0] >= last;
			last = out[0];
		}
		if (result == STILB_OK && (sum != 0.0f || (times && !ascends)))
			result = stilb_fail(STILB_ERROR_FILE,
			                    sum != 0.0f ? "accessor %u is NaN or infinite somewhere"
			                                : "the times of accessor %u are negative or descend",
			                    index);
		if (result == STILB_OK) {
			*known = *used + 1;
			*used += (uint32_t)*count;
		}
	}
	gltf_accessor_finish(&accessor);
	return result;
}

static stilb_result animation_read_sampler(animation_reader *reader, uint32_t sampler, stilb_scene_channel *channel)
{
	gltf *from = reader->from;
	scene_json *json = &from->json;
	static const char *const interpolations[] = {"STEP", "LINEAR", "CUBICSPLINE"};
	/* The components that an output may have, as masks: weights are single numbers, rotations four. */
	static const uint32_t components[STILB_SCENE_PATHS] = {1u << 2, 1u << 3, 1u << 2, 1u << 0};
	uint32_t kind = scene_json_member(json, sampler, "interpolation");
	uint32_t input = gltf_reference(from, sampler, "input", GLTF_ACCESSORS);
	uint32_t output = gltf_reference(from, sampler, "output", GLTF_ACCESSORS);
	uint64_t keys = 0, numbers = 0;
	channel->interpolation = STILB_SCENE_INTERPOLATIONS;
	for (int i = 0; i < STILB_SCENE_INTERPOLATIONS; i++)
		if (kind == GLTF_NONE ? i == STILB_SCENE_LINEAR : scene_json_is(json, kind, interpolations[i]))
			channel->interpolation = (stilb_scene_interpolation)i;
	if (json->fault[0])
		return scene_json_check(json);
	if (input == GLTF_NONE || output == GLTF_NONE || channel->interpolation == STILB_SCENE_INTERPOLATIONS)
		return stilb_fail(STILB_ERROR_FILE, "a sampler has no input or output, or an unknown interpolation");
	stilb_result result = animation_append(reader, input, 1u << 0, true, false, &channel->first_time, &keys);
	bool turns = channel->path == STILB_SCENE_PATH_ROTATION && channel->interpolation != STILB_SCENE_CUBIC;
	if (result == STILB_OK)
		result =
			animation_append(reader, output, components[channel->path], false, turns, &channel->first_value, &numbers);
	uint64_t each = (uint64_t)channel->width * (channel->interpolation == STILB_SCENE_CUBIC ? 3 : 1);
	if (result == STILB_OK && (keys == 0 || numbers != keys * each))
		result = stilb_fail(STILB_ERROR_FILE, "accessor %u has %llu numbers for %llu keys of %llu", output,
		                    (unsigned long long)numbers, (unsigned long long)keys, (unsigned long long)each);
	channel->key_count = (uint32_t)keys;
	return result;
}

/* Reads a channel; its width is 0 if nothing of the scene follows it. */
static stilb_result animation_read_channel(animation_reader *reader, uint32_t item, const gltf_list *samplers,
                                           stilb_scene_channel *channel)
{
	gltf *from = reader->from;
	scene_json *json = &from->json;
	static const char *const paths[] = {"translation", "rotation", "scale", "weights"};
	static const uint32_t widths[] = {3, 4, 3, 0};
	uint32_t target = scene_json_member(json, item, "target"), path = scene_json_member(json, target, "path");
	uint32_t node = gltf_reference(from, target, "node", GLTF_NODES);
	uint64_t sampler = scene_json_size(json, item, "sampler", UINT64_MAX);
	*channel = (stilb_scene_channel){.path = STILB_SCENE_PATHS};
	for (int p = 0; p < STILB_SCENE_PATHS; p++)
		if (path != GLTF_NONE && scene_json_is(json, path, paths[p]))
			channel->path = (stilb_scene_path)p;
	if (json->fault[0])
		return scene_json_check(json);
	channel->node = node == GLTF_NONE ? GLTF_NONE : reader->place[node];
	if (channel->node == GLTF_NONE || channel->path == STILB_SCENE_PATHS)
		return STILB_OK; /* it is of another scene, or of an extension */
	const stilb_scene_rest *rest = &reader->made.nodes[channel->node];
	if (channel->path != STILB_SCENE_PATH_WEIGHTS && !rest->moves)
		return stilb_fail(STILB_ERROR_FILE, "it moves node %u, which has a matrix", node);
	channel->width = channel->path == STILB_SCENE_PATH_WEIGHTS ? rest->weight_count : widths[channel->path];
	if (sampler >= samplers->count)
		return stilb_fail(STILB_ERROR_FILE, "it has no sampler %llu", (unsigned long long)sampler);
	return channel->width > 0 ? animation_read_sampler(reader, samplers->items[sampler], channel) : STILB_OK;
}

/* Reads the channels of a clip behind those that are there. */
static stilb_result animation_read_clip(animation_reader *reader, uint32_t item, stilb_scene_clip *clip)
{
	gltf *from = reader->from;
	scene_json *json = &from->json;
	stilb_scene_animation *made = &reader->made;
	gltf_list samplers = {0};
	uint32_t channels = scene_json_array(json, item, "channels");
	stilb_result result = gltf_list_items(from, item, "samplers", &samplers);
	for (uint32_t at = scene_json_first(json, channels); result == STILB_OK && at != GLTF_NONE;
	     at = scene_json_after(json, channels, at)) {
		stilb_scene_channel channel;
		result = animation_read_channel(reader, at, &samplers, &channel);
		if (result != STILB_OK || channel.width == 0)
			continue;
		uint32_t place = clip->first_channel + clip->channel_count;
		result = animation_reserve((void **)&made->channels, &reader->channel_room, place + 1ull, sizeof channel);
		if (result == STILB_OK && place == STILB_SCENE_MAX_MODELS)
			result = stilb_fail(STILB_ERROR_FILE, "its animations have more than %u channels", STILB_SCENE_MAX_MODELS);
		if (result != STILB_OK)
			break;
		made->channels[place] = channel;
		clip->channel_count++;
		clip->duration = fmaxf(clip->duration, made->times[channel.first_time + channel.key_count - 1]);
	}
	free(samplers.items);
	return result;
}

static stilb_result animation_add_clips(animation_reader *reader)
{
	gltf *from = reader->from;
	stilb_scene_animation *made = &reader->made;
	for (uint32_t c = 0; c < from->lists[GLTF_ANIMATIONS].count; c++) {
		char name[96];
		stilb_scene_clip clip = {.first_channel = made->channel_count};
		gltf_name(from, GLTF_ANIMATIONS, c, name);
		stilb_result result = animation_read_clip(reader, from->lists[GLTF_ANIMATIONS].items[c], &clip);
		if (result != STILB_OK) {
			result = gltf_leave_out(from, result, IMPORTER_LOSS_BAD_ANIMATIONS, name);
			if (result != STILB_OK)
				return result;
			continue;
		}
		if (clip.channel_count == 0) {
			importer_lose(from->import, IMPORTER_LOSS_ANIMATIONS, name);
			continue;
		}
		snprintf(clip.name, sizeof clip.name, "%.63s", name);
		made->channel_count += clip.channel_count;
		made->clips[made->clip_count++] = clip;
	}
	return STILB_OK;
}

/* ---- all --------------------------------------------------------------------------------------------------------- */

static stilb_result animation_begin(animation_reader *reader)
{
	gltf *from = reader->from;
	uint32_t nodes = from->lists[GLTF_NODES].count, skins = from->lists[GLTF_SKINS].count;
	stilb_scene_animation *made = &reader->made;
	made->node_count = from->node_count;
	made->nodes = calloc(from->node_count + 1ull, sizeof *made->nodes);
	made->clips = calloc(from->lists[GLTF_ANIMATIONS].count + 1ull, sizeof *made->clips);
	made->skins = calloc(skins + 1ull, sizeof *made->skins);
	made->deforms = calloc(from->parts.count + 1ull, sizeof *made->deforms);
	reader->place = malloc((nodes + 1ull) * sizeof *reader->place);
	reader->skin = malloc((skins + 1ull) * sizeof *reader->skin);
	reader->needed = calloc(from->parts.count + 1ull, sizeof *reader->needed);
	reader->time_of = calloc(from->lists[GLTF_ACCESSORS].count + 1ull, sizeof *reader->time_of);
	reader->value_of = calloc(from->lists[GLTF_ACCESSORS].count + 1ull, sizeof *reader->value_of);
	if (!made->nodes || !made->clips || !made->skins || !made->deforms || !reader->place || !reader->skin ||
	    !reader->needed || !reader->time_of || !reader->value_of)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for what moves");
	for (uint32_t n = 0; n < nodes; n++)
		reader->place[n] = GLTF_NONE;
	for (uint32_t n = 0; n < from->node_count; n++)
		reader->place[from->nodes[n].index] = n;
	return STILB_OK;
}

static stilb_result animation_read(animation_reader *reader)
{
	animation_take_deforms(reader);
	stilb_result result = STILB_OK;
	for (uint32_t n = 0; result == STILB_OK && n < reader->from->node_count; n++)
		result = animation_add_node(reader, n);
	if (result == STILB_OK)
		result = animation_add_skins(reader);
	for (uint32_t n = 0; result == STILB_OK && n < reader->from->node_count; n++)
		result = animation_dress_node(reader, n);
	return result == STILB_OK ? animation_add_clips(reader) : result;
}

stilb_result gltf_add_animation(gltf *from)
{
	animation_reader reader = {.from = from};
	stilb_scene *scene = from->import->scene;
	bool any = from->lists[GLTF_ANIMATIONS].count > 0 || from->lists[GLTF_SKINS].count > 0;
	for (uint32_t p = 0; !any && p < from->parts.count; p++)
		any = from->parts.parts[p].deform.targets > 0;
	if (!any)
		return STILB_OK;
	STILB_ASSERT(scene && !scene->animation);
	stilb_scene_animation *made = calloc(1, sizeof *made);
	stilb_result result = made ? animation_begin(&reader) : stilb_fail(STILB_ERROR_MEMORY, "no memory for what moves");
	if (result == STILB_OK)
		result = animation_read(&reader);
	free(reader.place);
	free(reader.skin);
	free(reader.needed);
	free(reader.time_of);
	free(reader.value_of);
	if (!made)
		return result;
	*made = reader.made;
	if (result == STILB_OK && made->clip_count + made->skin_count + made->deform_count > 0)
		scene->animation = made;
	else
		scene_animation_finish(made);
	return result;
}
