/* What moves in Assimp's scenes: nodes at rest, skins of the bones that were planned, and clips. */
#include "scene/importer/importer_motion.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Ticks a second where a file does not say it: the same as in Assimp's own viewer. */
#define CLIP_TICKS 25.0

/* How far a matrix may be from the product of a translation, a rotation and a scale, as a share of its longest axis,
 * to be one. */
#define CLIP_EXACT 1e-6f

typedef struct clip_reader {
	importer *import;
	stilb_scene_animation made;
	uint64_t channel_room, joint_room, bind_room, time_room, value_room, weight_room, skin_room;
	uint32_t *skin;  /* [skins of importer_motion] 1 + its place in made; 0: it is not there, or there for each node */
	uint32_t *taken; /* [nodes * paths] 1 + the animation that has a channel of it already */
	float turn[4];   /* of the root: what takes the file's axes to ours is this rotation, */
	float mirror;    /* times this, 1 or -1 */
} clip_reader;

/* An animation that is read. */
typedef struct clip_source {
	const struct aiAnimation *from;
	uint32_t number;
	double ticks; /* a second */
	stilb_scene_clip clip;
	bool strays, repeats; /* a channel names no node; one goes on beyond its keys */
} clip_source;

/* Makes room for `needed` elements in an array that grows. */
static stilb_result clip_reserve(void **at, uint64_t *room, uint64_t needed, size_t size)
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

/* Counts numbers, and makes room for them behind the `used` ones of an array. */
static stilb_result clip_extend(clip_reader *reader, float **numbers, uint64_t *room, uint32_t used, uint64_t more)
{
	stilb_result result = importer_count_moving(reader->import, more);
	return result == STILB_OK ? clip_reserve((void **)numbers, room, used + more + 1, sizeof **numbers) : result;
}

/* Counts as lost what could not be read, with the reason. STILB_ERROR_MEMORY is returned. */
static stilb_result clip_leave_out(clip_reader *reader, stilb_result result, importer_loss loss, const char *name)
{
	char words[256];
	if (result == STILB_ERROR_MEMORY)
		return result;
	snprintf(words, sizeof words, "%s: %s", name, stilb_error_message());
	importer_lose(reader->import, loss, words);
	return STILB_OK;
}

/* ---- nodes ------------------------------------------------------------------------------------------------------- */

/* True if the matrix is the product of the pose. */
static bool clip_pose_is_exact(const stilb_scene_pose *pose, const stilb_mat4 *local)
{
	stilb_mat4 product = stilb_scene_pose_matrix(pose);
	float longest = 0.0f, worst = 0.0f;
	for (int i = 0; i < 12; i++) {
		longest = fmaxf(longest, fabsf(local->m[i]));
		worst = fmaxf(worst, fabsf(local->m[i] - product.m[i]));
	}
	return worst <= CLIP_EXACT * longest && local->m[3] == 0.0f && local->m[7] == 0.0f && local->m[11] == 0.0f &&
	       local->m[15] == 1.0f;
}

static void clip_set_pose(stilb_scene_rest *node, const stilb_scene_pose *pose)
{
	memcpy(node->translation, pose->translation, sizeof node->translation);
	memcpy(node->rotation, pose->rotation, sizeof node->rotation);
	memcpy(node->scale, pose->scale, sizeof node->scale);
}

static void clip_add_nodes(clip_reader *reader)
{
	const importer *import = reader->import;
	const stilb_scene *scene = import->scene;
	for (uint32_t n = 0; n < import->node_count; n++) {
		stilb_scene_rest *node = &reader->made.nodes[n];
		stilb_scene_pose pose = scene->nodes.pose[n];
		*node = (stilb_scene_rest){
			.parent = import->nodes[n].parent, .local = import->nodes[n].local, .skin = STILB_SCENE_NONE};
		node->moves = clip_pose_is_exact(&pose, &node->local);
		if (!node->moves)
			pose = stilb_scene_pose_identity();
		clip_set_pose(node, &pose);
		memcpy(node->name, scene->nodes.name[n], sizeof node->name);
	}
	for (uint32_t m = 0; m < scene->model_count; m++) {
		reader->made.nodes[scene->model_node[m] - 1].first_model = m;
		reader->made.nodes[scene->model_node[m] - 1].model_count = 1;
	}
}

/* A clip is to move the node: it needs a pose, also where its matrix at rest is no product of one. */
static void clip_make_movable(clip_reader *reader, uint32_t n)
{
	stilb_scene_rest *node = &reader->made.nodes[n];
	if (!node->moves)
		clip_set_pose(node, &reader->import->scene->nodes.pose[n]);
	node->moves = true;
}

/* The weight of a morph target at rest. Assimp 5.2 gives 1 to all of FBX that have no shapes between: it says
 * nothing. */
static float clip_rest_weight(const importer *import, const struct aiAnimMesh *target)
{
	bool unknown =
		!isfinite(target->mWeight) || (target->mWeight == 1.0f && importer_is_format(import->from, "Autodesk FBX"));
	return unknown ? 0.0f : target->mWeight;
}

/* Gives a node the weights of its meshes' morph targets. */
static stilb_result clip_add_weights(clip_reader *reader, stilb_scene_rest *node)
{
	const importer *import = reader->import;
	const stilb_scene *scene = import->scene;
	stilb_scene_animation *made = &reader->made;
	node->first_weight = made->weight_count;
	for (uint32_t p = scene->first_part[node->first_model]; p < scene->first_part[node->first_model + 1]; p++) {
		const stilb_scene_deform *deform = &import->motion->deforms[scene->part_mesh[p]];
		const struct aiMesh *from = import->motion->deform_from[scene->part_mesh[p]];
		if (deform->targets <= node->weight_count)
			continue;
		stilb_result result = clip_extend(reader, &made->weights, &reader->weight_room, made->weight_count,
		                                  deform->targets - node->weight_count);
		if (result != STILB_OK)
			return result;
		for (; node->weight_count < deform->targets; node->weight_count++)
			made->weights[made->weight_count++] = clip_rest_weight(import, from->mAnimMeshes[node->weight_count]);
	}
	return STILB_OK;
}

/* ---- skins ------------------------------------------------------------------------------------------------------- */

/* The skin of the meshes of a node, NULL: they have none. */
static const importer_skin *clip_skin_of(const clip_reader *reader, uint32_t n)
{
	const importer *import = reader->import;
	const struct aiNode *node = import->nodes[n].node;
	for (uint32_t i = 0; i < node->mNumMeshes; i++) {
		uint32_t number = node->mMeshes[i] < import->from->mNumMeshes ? import->motion->skin_of[node->mMeshes[i]] : 0;
		if (number > 0)
			return &import->motion->skins[number - 1];
	}
	return NULL;
}

static stilb_result clip_add_joints(clip_reader *reader, const importer_skin *skin, uint32_t n)
{
	stilb_scene_animation *made = &reader->made;
	uint32_t count = skin->joint_count + skin->with_node;
	if (made->joint_count + (uint64_t)count > STILB_SCENE_MAX_MODELS)
		return stilb_fail(STILB_ERROR_FILE, "its skins have more than %u joints", STILB_SCENE_MAX_MODELS);
	stilb_result result = clip_reserve((void **)&made->joints, &reader->joint_room, made->joint_count + count + 1ull,
	                                   sizeof *made->joints);
	if (result == STILB_OK)
		result = clip_reserve((void **)&made->inverse_binds, &reader->bind_room, made->joint_count + count + 1ull,
		                      sizeof *made->inverse_binds);
	if (result == STILB_OK)
		result = clip_reserve((void **)&made->skins, &reader->skin_room, made->skin_count + 1ull, sizeof *made->skins);
	if (result != STILB_OK)
		return result;
	stilb_scene_skin *own = &made->skins[made->skin_count++];
	*own = (stilb_scene_skin){.first_joint = made->joint_count, .joint_count = count};
	memcpy(own->name, skin->name, sizeof own->name);
	if (skin->with_node) {
		made->joints[made->joint_count] = n;
		made->inverse_binds[made->joint_count++] = stilb_mat4_identity();
	}
	for (uint32_t j = 0; j < skin->joint_count; j++) {
		const importer_joint *joint = &reader->import->motion->joints[skin->first_joint + j];
		made->joints[made->joint_count] = joint->node;
		made->inverse_binds[made->joint_count++] = joint->inverse_bind;
	}
	return STILB_OK;
}

/* Gives a node its skin, if all of its meshes have the vertices for it. */
static stilb_result clip_dress_node(clip_reader *reader, uint32_t n)
{
	const stilb_scene *scene = reader->import->scene;
	const importer_motion *motion = reader->import->motion;
	stilb_scene_rest *node = &reader->made.nodes[n];
	const importer_skin *skin = clip_skin_of(reader, n);
	if (!skin)
		return STILB_OK;
	for (uint32_t p = scene->first_part[node->first_model]; p < scene->first_part[node->first_model + 1]; p++)
		if (motion->deforms[scene->part_mesh[p]].influences == 0)
			return STILB_OK;
	uint32_t *known = &reader->skin[skin - motion->skins];
	if (*known == 0) {
		stilb_result result = clip_add_joints(reader, skin, n);
		if (result != STILB_OK)
			return clip_leave_out(reader, result, IMPORTER_LOSS_BAD_SKINS, skin->name);
		*known = reader->made.skin_count;
	}
	node->skin = *known - 1;
	if (skin->with_node)
		*known = 0;
	return STILB_OK;
}

/* ---- keys -------------------------------------------------------------------------------------------------------- */

/* The time of a key; all of Assimp's begin with it. */
static double clip_time(const void *keys, size_t stride, uint32_t k)
{
	double time;
	memcpy(&time, (const char *)keys + k * stride, sizeof time);
	return time;
}

/* Appends the times of keys, or finds that the channel before has the same. */
static stilb_result clip_add_times(clip_reader *reader, const clip_source *source, const void *keys, size_t stride,
                                   stilb_scene_channel *channel)
{
	stilb_scene_animation *made = &reader->made;
	uint32_t count = channel->key_count;
	if (!keys)
		return stilb_fail(STILB_ERROR_FILE, "%u keys are not there", count);
	stilb_result result = clip_extend(reader, &made->times, &reader->time_room, made->time_count, count);
	if (result != STILB_OK)
		return result;
	float *times = made->times + made->time_count, last = 0.0f;
	for (uint32_t k = 0; k < count; k++) {
		times[k] = (float)(clip_time(keys, stride, k) / source->ticks);
		if (!(times[k] >= last && times[k] <= 1e30f))
			return stilb_fail(STILB_ERROR_FILE, "the times of '%.63s' are negative, NaN or descend",
			                  made->nodes[channel->node].name);
		last = times[k];
	}
	uint32_t before = source->clip.first_channel + source->clip.channel_count;
	const stilb_scene_channel *other = source->clip.channel_count > 0 ? &made->channels[before - 1] : NULL;
	channel->first_time = made->time_count;
	if (other && other->key_count == count &&
	    memcmp(made->times + other->first_time, times, count * sizeof *times) == 0)
		channel->first_time = other->first_time;
	else
		made->time_count += count;
	return STILB_OK;
}

/* Appends a channel, if nothing else of the clip has its node and path. */
static stilb_result clip_add_channel(clip_reader *reader, clip_source *source, const stilb_scene_channel *channel)
{
	stilb_scene_animation *made = &reader->made;
	uint32_t place = source->clip.first_channel + source->clip.channel_count;
	float last = made->times[channel->first_time + channel->key_count - 1];
	if (place >= STILB_SCENE_MAX_MODELS)
		return stilb_fail(STILB_ERROR_FILE, "its animations have more than %u channels", STILB_SCENE_MAX_MODELS);
	stilb_result result = clip_reserve((void **)&made->channels, &reader->channel_room, place + 1ull, sizeof *channel);
	if (result != STILB_OK)
		return result;
	made->channels[place] = *channel;
	source->clip.channel_count++;
	source->clip.duration = fmaxf(source->clip.duration, last);
	return STILB_OK;
}

/* True the first time that an animation has a channel for a path of a node. */
static bool clip_takes(clip_reader *reader, const clip_source *source, uint32_t node, stilb_scene_path path)
{
	uint32_t *taken = &reader->taken[(size_t)node * STILB_SCENE_PATHS + path];
	bool first = *taken != source->number + 1;
	*taken = source->number + 1;
	return first;
}

/* ---- channels of nodes ------------------------------------------------------------------------------------------- */

static void clip_rotate(const float q[4], const float v[3], float out[3])
{
	stilb_scene_pose pose = {.rotation = {q[0], q[1], q[2], q[3]}, .scale = {1, 1, 1}};
	stilb_mat4 m = stilb_scene_pose_matrix(&pose);
	for (int row = 0; row < 3; row++)
		out[row] = m.m[row] * v[0] + m.m[4 + row] * v[1] + m.m[8 + row] * v[2];
}

/* Hamilton's product, a after b. */
static void clip_multiply(const float a[4], const float b[4], float out[4])
{
	out[0] = a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1];
	out[1] = a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0];
	out[2] = a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3];
	out[3] = a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2];
}

/* Takes a value of the root from the file's axes to ours: mirror * turn * (T R S) is again such a product. */
static void clip_turn(const clip_reader *reader, stilb_scene_path path, float *value)
{
	float from[4];
	memcpy(from, value, sizeof from);
	if (path == STILB_SCENE_PATH_ROTATION)
		clip_multiply(reader->turn, from, value);
	else if (path == STILB_SCENE_PATH_TRANSLATION)
		clip_rotate(reader->turn, from, value);
	for (int k = 0; path != STILB_SCENE_PATH_ROTATION && k < 3; k++)
		value[k] *= reader->mirror;
}

/* The value of a key. False: it is NaN or infinite, or a rotation without a direction. */
static bool clip_value(const void *keys, stilb_scene_path path, uint32_t k, float out[4])
{
	if (path != STILB_SCENE_PATH_ROTATION) {
		const struct aiVector3D *v = &((const struct aiVectorKey *)keys)[k].mValue;
		out[0] = v->x, out[1] = v->y, out[2] = v->z, out[3] = 0.0f;
		return isfinite(out[0]) && isfinite(out[1]) && isfinite(out[2]);
	}
	const struct aiQuaternion *q = &((const struct aiQuatKey *)keys)[k].mValue;
	out[0] = q->x, out[1] = q->y, out[2] = q->z, out[3] = q->w;
	float length = sqrtf(out[0] * out[0] + out[1] * out[1] + out[2] * out[2] + out[3] * out[3]);
	for (int i = 0; i < 4; i++)
		out[i] /= length;
	return length > 1e-18f && length < 1e18f;
}

/* Adds a channel of one path of a node; without keys none. */
static stilb_result clip_read_path(clip_reader *reader, clip_source *source, uint32_t node, stilb_scene_path path,
                                   const void *keys, uint32_t count)
{
	stilb_scene_animation *made = &reader->made;
	bool turns = path == STILB_SCENE_PATH_ROTATION;
	if (count == 0 || !clip_takes(reader, source, node, path))
		return STILB_OK;
	stilb_scene_channel channel = {.node = node,
	                               .path = path,
	                               .interpolation = STILB_SCENE_LINEAR,
	                               .key_count = count,
	                               .width = turns ? 4 : 3,
	                               .first_value = made->value_count};
	stilb_result result =
		clip_add_times(reader, source, keys, turns ? sizeof(struct aiQuatKey) : sizeof(struct aiVectorKey), &channel);
	if (result == STILB_OK)
		result =
			clip_extend(reader, &made->values, &reader->value_room, made->value_count, (uint64_t)count * channel.width);
	for (uint32_t k = 0; result == STILB_OK && k < count; k++) {
		float value[4];
		if (!clip_value(keys, path, k, value))
			return stilb_fail(STILB_ERROR_FILE, "key %u of '%.63s' is NaN or infinite, or turns by nothing", k,
			                  made->nodes[node].name);
		if (node == 0)
			clip_turn(reader, path, value);
		memcpy(made->values + made->value_count, value, channel.width * sizeof *value);
		made->value_count += channel.width;
	}
	if (result == STILB_OK)
		clip_make_movable(reader, node);
	return result == STILB_OK ? clip_add_channel(reader, source, &channel) : result;
}

static stilb_result clip_read_node(clip_reader *reader, clip_source *source, const struct aiNodeAnim *from)
{
	uint32_t node = importer_find_moving(reader->import, from->mNodeName.data);
	source->strays |= node == STILB_SCENE_NONE;
	if (node == STILB_SCENE_NONE)
		return STILB_OK;
	source->repeats |= from->mPreState >= aiAnimBehaviour_LINEAR || from->mPostState >= aiAnimBehaviour_LINEAR;
	stilb_result result =
		clip_read_path(reader, source, node, STILB_SCENE_PATH_TRANSLATION, from->mPositionKeys, from->mNumPositionKeys);
	if (result == STILB_OK)
		result = clip_read_path(reader, source, node, STILB_SCENE_PATH_ROTATION, from->mRotationKeys,
		                        from->mNumRotationKeys);
	return result == STILB_OK
	           ? clip_read_path(reader, source, node, STILB_SCENE_PATH_SCALE, from->mScalingKeys, from->mNumScalingKeys)
	           : result;
}

/* ---- weights of morph targets ------------------------------------------------------------------------------------ */

/* Fills in the weight of one target where keys do not name it: on a straight line between those that do. values:
 * [key_count * width], with NaN where a key does not name the target. */
static void clip_fill_weight(const float *times, uint32_t count, float *values, uint32_t width, float rest)
{
	uint32_t before = UINT32_MAX;
	for (uint32_t k = 0; k < count; k++) {
		if (isnan(values[(size_t)k * width]))
			continue;
		float to = values[(size_t)k * width], from = before == UINT32_MAX ? to : values[(size_t)before * width];
		for (uint32_t i = before + 1; i < k; i++) { /* from 0 on, if there is none before */
			float span = before == UINT32_MAX ? 0.0f : times[k] - times[before];
			float share = span > 0.0f ? (times[i] - times[before]) / span : 0.0f;
			values[(size_t)i * width] = from + (to - from) * share;
		}
		before = k;
	}
	float last = before == UINT32_MAX ? rest : values[(size_t)before * width];
	for (uint32_t i = before + 1; i < count; i++)
		values[(size_t)i * width] = last;
}

static stilb_result clip_read_weight_keys(const struct aiMeshMorphAnim *from, float *values, uint32_t width)
{
	for (uint32_t k = 0; k < from->mNumKeys; k++) {
		const struct aiMeshMorphKey *key = &from->mKeys[k];
		if (key->mNumValuesAndWeights > 0 && (!key->mValues || !key->mWeights))
			return stilb_fail(STILB_ERROR_FILE, "key %u of '%.63s' has no weights", k, from->mName.data);
		for (uint32_t w = 0; w < width; w++)
			values[(size_t)k * width + w] = NAN;
		for (uint32_t i = 0; i < key->mNumValuesAndWeights; i++) {
			if (key->mValues[i] >= width || !(fabs(key->mWeights[i]) <= 1e30))
				return stilb_fail(STILB_ERROR_FILE, "key %u of '%.63s' has target %u of %u with weight %g", k,
				                  from->mName.data, key->mValues[i], width, key->mWeights[i]);
			values[(size_t)k * width + key->mValues[i]] = (float)key->mWeights[i];
		}
	}
	return STILB_OK;
}

static stilb_result clip_read_weights(clip_reader *reader, clip_source *source, const struct aiMeshMorphAnim *from,
                                      uint32_t node)
{
	stilb_scene_animation *made = &reader->made;
	const stilb_scene_rest *rest = &made->nodes[node];
	stilb_scene_channel channel = {.node = node,
	                               .path = STILB_SCENE_PATH_WEIGHTS,
	                               .interpolation = STILB_SCENE_LINEAR,
	                               .key_count = from->mNumKeys,
	                               .width = rest->weight_count,
	                               .first_value = made->value_count};
	if (from->mNumKeys == 0 || rest->weight_count == 0 || !clip_takes(reader, source, node, STILB_SCENE_PATH_WEIGHTS))
		return STILB_OK;
	uint64_t numbers = (uint64_t)channel.key_count * channel.width;
	stilb_result result = clip_add_times(reader, source, from->mKeys, sizeof *from->mKeys, &channel);
	if (result == STILB_OK)
		result = clip_extend(reader, &made->values, &reader->value_room, made->value_count, numbers);
	if (result == STILB_OK)
		result = clip_read_weight_keys(from, made->values + made->value_count, channel.width);
	for (uint32_t w = 0; result == STILB_OK && w < channel.width; w++)
		clip_fill_weight(made->times + channel.first_time, channel.key_count, made->values + made->value_count + w,
		                 channel.width, made->weights[rest->first_weight + w]);
	if (result != STILB_OK)
		return result;
	made->value_count += (uint32_t)numbers;
	return clip_add_channel(reader, source, &channel);
}

/* Finds what an animation of morph targets is for: a node of its name, which may end with a number behind a *, or all
 * that show a mesh of its name. */
static stilb_result clip_read_morph(clip_reader *reader, clip_source *source, const struct aiMeshMorphAnim *from)
{
	const importer *import = reader->import;
	char name[MAXLEN];
	snprintf(name, sizeof name, "%s", from->mName.data);
	uint32_t node = importer_find_moving(reader->import, name);
	char *star = strrchr(name, '*');
	if (node == STILB_SCENE_NONE && star) {
		*star = '\0';
		node = importer_find_moving(reader->import, name);
	}
	if (node != STILB_SCENE_NONE && reader->made.nodes[node].weight_count > 0)
		return clip_read_weights(reader, source, from, node);
	stilb_result result = STILB_OK;
	bool found = node != STILB_SCENE_NONE;
	for (uint32_t n = 0; result == STILB_OK && n < import->node_count; n++) {
		const stilb_scene_rest *rest = &reader->made.nodes[n];
		bool shows = false;
		for (uint32_t p = rest->weight_count > 0 ? import->scene->first_part[rest->first_model] : UINT32_MAX;
		     p < UINT32_MAX && p < import->scene->first_part[rest->first_model + 1]; p++) {
			const struct aiMesh *mesh = import->motion->deform_from[import->scene->part_mesh[p]];
			shows |= mesh && strcmp(mesh->mName.data, from->mName.data) == 0;
		}
		found |= shows;
		if (shows)
			result = clip_read_weights(reader, source, from, n);
	}
	source->strays |= !found;
	return result;
}

/* ---- clips ------------------------------------------------------------------------------------------------------- */

static stilb_result clip_read(clip_reader *reader, clip_source *source)
{
	const struct aiAnimation *from = source->from;
	if (!(from->mTicksPerSecond >= 0.0 && from->mTicksPerSecond < 1e30))
		return stilb_fail(STILB_ERROR_FILE, "it has %g ticks a second", from->mTicksPerSecond);
	if ((from->mNumChannels > 0 && !from->mChannels) || (from->mNumMorphMeshChannels > 0 && !from->mMorphMeshChannels))
		return stilb_fail(STILB_ERROR_FILE, "its channels are not there");
	source->ticks = from->mTicksPerSecond > 0.0 ? from->mTicksPerSecond : CLIP_TICKS;
	stilb_result result = STILB_OK;
	for (uint32_t c = 0; result == STILB_OK && c < from->mNumChannels; c++)
		if (from->mChannels[c])
			result = clip_read_node(reader, source, from->mChannels[c]);
	for (uint32_t c = 0; result == STILB_OK && c < from->mNumMorphMeshChannels; c++)
		if (from->mMorphMeshChannels[c])
			result = clip_read_morph(reader, source, from->mMorphMeshChannels[c]);
	return result;
}

/* Counts what of an animation is not as the file has it. */
static void clip_lose(clip_reader *reader, const clip_source *source)
{
	importer *import = reader->import;
	if (source->from->mNumMeshChannels > 0)
		importer_lose(import, IMPORTER_LOSS_MESH_FRAMES, source->clip.name);
	else if (source->clip.channel_count == 0)
		importer_lose(import, IMPORTER_LOSS_ANIMATIONS, source->clip.name);
	else if (source->strays)
		importer_lose(import, IMPORTER_LOSS_STRAYS, source->clip.name);
	if (source->repeats)
		importer_lose(import, IMPORTER_LOSS_REPEATS, source->clip.name);
}

static stilb_result clip_add_all(clip_reader *reader)
{
	const struct aiScene *from = reader->import->from;
	stilb_scene_animation *made = &reader->made;
	for (uint32_t a = 0; a < from->mNumAnimations; a++) {
		if (!from->mAnimations || !from->mAnimations[a])
			continue;
		clip_source source = {
			.from = from->mAnimations[a], .number = a, .clip = {.first_channel = made->channel_count}};
		stilb_scene_clip *clip = &source.clip;
		uint32_t times = made->time_count, values = made->value_count;
		snprintf(clip->name, sizeof clip->name, "%.63s", from->mAnimations[a]->mName.data);
		if (!clip->name[0])
			snprintf(clip->name, sizeof clip->name, "number %u", a);
		stilb_result result = clip_read(reader, &source);
		if (result == STILB_OK && clip->channel_count > 0) {
			made->channel_count += clip->channel_count;
			made->clips[made->clip_count++] = *clip;
		} else {
			made->time_count = times;
			made->value_count = values;
		}
		if (result == STILB_OK)
			clip_lose(reader, &source);
		else
			result = clip_leave_out(reader, result, IMPORTER_LOSS_BAD_ANIMATIONS, clip->name);
		if (result != STILB_OK)
			return result;
	}
	return STILB_OK;
}

/* ---- all --------------------------------------------------------------------------------------------------------- */

/* The file's axes are a rotation, or a mirroring that is one times -1. */
static void clip_find_turn(clip_reader *reader)
{
	stilb_mat4 axes = reader->import->world.to_world;
	stilb_vec3 x = stilb_vec3_make(axes.m[0], axes.m[1], axes.m[2]);
	stilb_vec3 y = stilb_vec3_make(axes.m[4], axes.m[5], axes.m[6]);
	stilb_vec3 z = stilb_vec3_make(axes.m[8], axes.m[9], axes.m[10]);
	reader->mirror = stilb_vec3_dot(stilb_vec3_cross(x, y), z) < 0.0f ? -1.0f : 1.0f;
	for (int i = 0; i < 12; i++)
		axes.m[i] *= reader->mirror;
	stilb_scene_pose pose = stilb_scene_pose_of(&axes);
	memcpy(reader->turn, pose.rotation, sizeof reader->turn);
}

static stilb_result clip_begin(clip_reader *reader)
{
	const importer *import = reader->import;
	stilb_scene_animation *made = &reader->made;
	size_t nodes = import->node_count;
	made->node_count = import->node_count;
	made->nodes = calloc(nodes + 1, sizeof *made->nodes);
	made->clips = calloc(import->from->mNumAnimations + 1ull, sizeof *made->clips);
	made->deforms = calloc(import->scene->mesh_count + 1ull, sizeof *made->deforms);
	reader->skin = calloc(import->motion->skin_count + 1ull, sizeof *reader->skin);
	reader->taken = calloc((nodes + 1) * STILB_SCENE_PATHS, sizeof *reader->taken);
	if (!made->nodes || !made->clips || !made->deforms || !reader->skin || !reader->taken)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for what moves");
	clip_find_turn(reader);
	return STILB_OK;
}

static stilb_result clip_read_all(clip_reader *reader)
{
	importer_motion *motion = reader->import->motion;
	stilb_scene_animation *made = &reader->made;
	stilb_result result = STILB_OK;
	clip_add_nodes(reader);
	for (uint32_t n = 0; result == STILB_OK && n < made->node_count; n++) {
		if (made->nodes[n].model_count == 0)
			continue;
		result = clip_add_weights(reader, &made->nodes[n]);
		if (result == STILB_OK)
			result = clip_dress_node(reader, n);
	}
	if (result == STILB_OK)
		result = clip_add_all(reader);
	for (uint32_t m = 0; result == STILB_OK && m < reader->import->scene->mesh_count; m++) {
		stilb_scene_deform *deform = &motion->deforms[m];
		if (deform->influences == 0 && deform->targets == 0)
			continue;
		deform->mesh = m;
		made->deforms[made->deform_count++] = *deform;
		*deform = (stilb_scene_deform){0};
	}
	return result;
}

stilb_result importer_add_animation(importer *import)
{
	stilb_scene *scene = import->scene;
	STILB_ASSERT(scene && !scene->animation && import->motion);
	bool any = import->from->mNumAnimations > 0;
	for (uint32_t m = 0; !any && m < scene->mesh_count; m++)
		any = import->motion->deform_from[m];
	if (!any)
		return STILB_OK;
	clip_reader reader = {.import = import};
	stilb_scene_animation *made = calloc(1, sizeof *made);
	stilb_result result = made ? clip_begin(&reader) : stilb_fail(STILB_ERROR_MEMORY, "no memory for what moves");
	if (result == STILB_OK)
		result = clip_read_all(&reader);
	free(reader.skin);
	free(reader.taken);
	if (!made)
		return result;
	*made = reader.made;
	if (result == STILB_OK && made->clip_count + made->skin_count + made->deform_count > 0)
		scene->animation = made;
	else
		scene_animation_finish(made);
	return result;
}
