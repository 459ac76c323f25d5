/* What all figures of a scene share: clips in the order of their work, and meshes at rest. */
#include "scene/play/scene_play_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static stilb_result share_memory(void)
{
	return stilb_fail(STILB_ERROR_MEMORY, "no memory for what moves");
}

/* ---- clips ------------------------------------------------------------------------------------------------------- */

/* True if channels move the node. seen: of share_targets. */
static bool share_moves(const uint32_t *seen, uint32_t node)
{
	const uint32_t *at = seen + node * (size_t)STILB_SCENE_PATHS;
	return at[STILB_SCENE_PATH_TRANSLATION] > 0 || at[STILB_SCENE_PATH_ROTATION] > 0 || at[STILB_SCENE_PATH_SCALE] > 0;
}

/* Puts the moved nodes that hang on no other of them first. */
static void share_tops(const stilb_scene_animation *animation, play_shared *shared, const uint32_t *seen)
{
	for (uint32_t i = 0; i < shared->moved_count; i++) {
		uint32_t node = shared->moved[i], parent = animation->nodes[node].parent;
		if (parent != STILB_SCENE_NONE && share_moves(seen, parent))
			continue;
		shared->moved[i] = shared->moved[shared->top_count];
		shared->moved[shared->top_count++] = node;
	}
}

/* Lists what channels replace. seen: [node_count * STILB_SCENE_PATHS], all 0; then 1 + the target. */
static void share_targets(const stilb_scene_animation *animation, play_shared *shared, uint32_t *seen)
{
	for (uint32_t c = 0; c < animation->channel_count; c++)
		seen[animation->channels[c].node * (size_t)STILB_SCENE_PATHS + animation->channels[c].path] = 1;
	for (uint32_t n = 0; n < animation->node_count; n++) {
		bool moved = false;
		for (int path = 0; path < STILB_SCENE_PATHS; path++) {
			static const uint32_t widths[STILB_SCENE_PATHS] = {3, 4, 3, 0};
			uint32_t *at = &seen[n * (size_t)STILB_SCENE_PATHS + (size_t)path];
			if (*at == 0)
				continue;
			play_target *target = &shared->targets[shared->target_count++];
			*target = (play_target){n, (stilb_scene_path)path, widths[path], shared->value_count};
			if (path == STILB_SCENE_PATH_WEIGHTS)
				target->width = animation->nodes[n].weight_count;
			shared->value_count += (target->width + 3) / 4 * 4;
			moved |= path != STILB_SCENE_PATH_WEIGHTS;
			*at = shared->target_count;
		}
		if (moved)
			shared->moved[shared->moved_count++] = n;
	}
	share_tops(animation, shared, seen);
	for (uint32_t c = 0; c < animation->channel_count; c++) {
		const stilb_scene_channel *channel = &animation->channels[c];
		shared->channels[c].target = seen[channel->node * (size_t)STILB_SCENE_PATHS + channel->path] - 1;
	}
}

/* The track of a channel among those of its clip, which begin at `first`. Files list channels of the same times one
 * after the other, so the newest is looked at first. */
static uint32_t share_track(const stilb_scene_animation *animation, play_shared *shared, uint32_t first,
                            const stilb_scene_channel *channel, uint32_t *known)
{
	uint32_t have = known[channel->first_time];
	if (have > first && shared->tracks[have - 1].key_count == channel->key_count)
		return have - 1 - first;
	const float *times = animation->times + channel->first_time;
	float span = times[channel->key_count - 1] - times[0];
	shared->tracks[shared->track_count] =
		(play_track){.first_time = channel->first_time,
	                 .key_count = channel->key_count,
	                 .rate = span > 0.0f && isfinite(span) ? (float)(channel->key_count - 1) / span : 0.0f};
	known[channel->first_time] = ++shared->track_count;
	return shared->track_count - 1 - first;
}

static bool share_is_turn(const stilb_scene_channel *channel)
{
	return channel->path == STILB_SCENE_PATH_ROTATION && channel->interpolation == STILB_SCENE_LINEAR;
}

/* Orders the channels of clips: those that turn come first, since they are sampled four at a time. known: [time_count
 * + 1], all 0. */
static void share_clips(const stilb_scene_animation *animation, play_shared *shared, uint32_t *known)
{
	for (uint32_t c = 0; c < animation->clip_count; c++) {
		const stilb_scene_clip *from = &animation->clips[c];
		play_clip *clip = &shared->clips[c];
		uint32_t at = from->first_channel;
		clip->first_track = shared->track_count;
		for (int pass = 0; pass < 2; pass++) {
			for (uint32_t i = 0; i < from->channel_count; i++)
				if (share_is_turn(&animation->channels[from->first_channel + i]) == (pass == 0))
					shared->order[at++] = from->first_channel + i;
			if (pass == 0)
				clip->rotation_count = at - from->first_channel;
		}
		for (uint32_t i = 0; i < from->channel_count; i++)
			shared->channels[from->first_channel + i].track =
				share_track(animation, shared, clip->first_track, &animation->channels[from->first_channel + i], known);
		clip->track_count = shared->track_count - clip->first_track;
		shared->most_tracks = clip->track_count > shared->most_tracks ? clip->track_count : shared->most_tracks;
	}
}

/* ---- meshes ------------------------------------------------------------------------------------------------------ */

/* Numbers at a cache line's begin: no eight of them lie in two lines. NULL: no memory. */
static float *share_zeros(size_t count)
{
	float *zeros = stilb_memory_alloc(count, sizeof *zeros);
	if (zeros)
		memset(zeros, 0, count * sizeof *zeros);
	return zeros;
}

/* What the influences of a vertex are divided by; 0: it has none, and follows joint 0. */
static double share_sum(const stilb_scene_deform *deform, uint32_t vertex)
{
	double sum = 0.0;
	for (uint32_t i = 0; i < deform->influences; i++)
		sum += (double)deform->weights[(size_t)vertex * deform->influences + i];
	return sum;
}

/* The place of a joint in the list of an eight, to the end of which it is added if it is not there. */
static uint32_t share_joint(uint16_t *joints, uint32_t *count, uint16_t joint)
{
	uint32_t at = 0;
	while (at < *count && joints[at] != joint)
		at++;
	joints[at] = joint;
	*count += at == *count;
	return at;
}

/* Lists the joints that carry eight vertices from `first` on, and what each weighs for them, if it is to be kept.
 * joints: of room for all influences of eight vertices. Returns their number. */
static uint32_t share_eight(const stilb_scene_deform *deform, uint32_t vertex_count, uint32_t first, uint16_t *joints,
                            float *weights)
{
	uint32_t count = 0;
	for (uint32_t v = first; v < vertex_count && v < first + PLAY_LANES; v++) {
		double sum = share_sum(deform, v);
		for (uint32_t i = 0; i < deform->influences; i++) {
			size_t from = (size_t)v * deform->influences + i;
			double weight = sum > 0.0 ? (double)deform->weights[from] / sum : i == 0 ? 1.0 : 0.0;
			if (weight == 0.0)
				continue;
			uint32_t at = share_joint(joints, &count, sum > 0.0 ? deform->joints[from] : 0);
			if (weights)
				weights[at * PLAY_LANES + (v - first)] += (float)weight;
		}
	}
	return count;
}

/* The joints of each eight vertices. */
static bool share_skin(const stilb_scene_deform *deform, play_rest *rest)
{
	uint32_t eights = rest->stride / PLAY_LANES;
	uint16_t *joints = malloc((size_t)deform->influences * PLAY_LANES * sizeof *joints);
	rest->starts = malloc((eights + 1ull) * sizeof *rest->starts);
	size_t count = 0;
	for (uint32_t e = 0; joints && rest->starts && e < eights; e++) {
		rest->starts[e] = (uint32_t)count;
		count += share_eight(deform, rest->vertex_count, e * PLAY_LANES, joints, NULL);
	}
	free(joints);
	if (!joints || !rest->starts || count > UINT32_MAX)
		return false;
	rest->starts[eights] = (uint32_t)count;
	rest->joints = malloc((count + 1) * sizeof *rest->joints); /* also where there is no vertex */
	rest->weights = share_zeros(count * PLAY_LANES);
	for (uint32_t e = 0; rest->joints && rest->weights && e < eights; e++)
		share_eight(deform, rest->vertex_count, e * PLAY_LANES, rest->joints + rest->starts[e],
		            rest->weights + (size_t)rest->starts[e] * PLAY_LANES);
	return rest->joints && rest->weights;
}

/* Numbers of vertices become streams. */
static void share_streams(const stilb_scene_mesh *mesh, play_rest *rest)
{
	for (uint32_t v = 0; v < rest->vertex_count; v++) {
		const stilb_scene_vertex *vertex = &mesh->vertices[v];
		float *to = rest->streams + v;
		for (int i = 0; i < 3; i++) {
			to[(size_t)(PLAY_POSITION + i) * rest->stride] = vertex->position[i];
			to[(size_t)(PLAY_NORMAL + i) * rest->stride] = vertex->normal[i];
		}
		for (int i = 0; i < 2; i++)
			to[(size_t)(PLAY_UV + i) * rest->stride] = vertex->uv[i];
		for (int i = 0; rest->tangents && mesh->extras && i < 4; i++)
			to[(size_t)(PLAY_TANGENT + i) * rest->stride] = mesh->extras[v].tangent[i];
	}
}

static stilb_result share_rest(const stilb_scene *scene, const stilb_scene_deform *deform, play_rest *rest)
{
	const stilb_scene_mesh *mesh = &scene->meshes[deform->mesh];
	*rest = (play_rest){.vertex_count = mesh->vertex_count,
	                    .stride = (mesh->vertex_count + PLAY_LANES - 1) / PLAY_LANES * PLAY_LANES,
	                    .tangents = mesh->extras};
	rest->streams = share_zeros((size_t)(rest->tangents ? PLAY_STREAMS : PLAY_STREAMS_PLAIN) * rest->stride);
	if (!rest->streams)
		return share_memory();
	share_streams(mesh, rest);
	return deform->influences == 0 || share_skin(deform, rest) ? STILB_OK : share_memory();
}

/* Lists the meshes that poses change, and keeps them as they are at rest. shared->posed has room for the parts of the
 * first model of each node. */
static stilb_result share_posed(const stilb_scene *scene, play_shared *shared)
{
	const stilb_scene_animation *animation = scene->animation;
	stilb_result result = STILB_OK;
	for (uint32_t n = 0; result == STILB_OK && n < animation->node_count; n++) {
		const stilb_scene_rest *node = &animation->nodes[n];
		if (node->model_count == 0)
			continue;
		if (shared->model_count == 0)
			shared->first_model = node->first_model;
		shared->model_count = node->first_model + node->model_count - shared->first_model;
		uint32_t first = scene->first_part[node->first_model], end = scene->first_part[node->first_model + 1];
		for (uint32_t p = first; result == STILB_OK && p < end; p++) {
			const stilb_scene_deform *deform = stilb_scene_animation_deform(animation, scene->part_mesh[p]);
			bool skinned = deform && node->skin != STILB_SCENE_NONE && deform->influences > 0 &&
			               animation->skins[node->skin].joint_count > 0;
			if (!skinned && !(deform && deform->targets > 0))
				continue;
			uint32_t d = (uint32_t)(deform - animation->deforms);
			shared->posed[shared->posed_count++] =
				(play_posed){n, p - first, d, skinned ? node->skin : STILB_SCENE_NONE};
			if (!shared->rests[d].streams)
				result = share_rest(scene, deform, &shared->rests[d]);
		}
	}
	return result;
}

/* Lists the nodes that are joints of skins, or above these. */
static stilb_result share_carriers(const stilb_scene_animation *animation, play_shared *shared)
{
	bool *carries = calloc(animation->node_count + 1ull, sizeof *carries);
	uint32_t count = 0;
	for (uint32_t p = 0; carries && p < shared->posed_count; p++) {
		if (shared->posed[p].skin == STILB_SCENE_NONE)
			continue;
		const stilb_scene_skin *skin = &animation->skins[shared->posed[p].skin];
		for (uint32_t j = 0; j < skin->joint_count; j++)
			carries[animation->joints[skin->first_joint + j]] = true;
	}
	for (uint32_t n = animation->node_count; carries && n-- > 0;) {
		count += carries[n];
		if (carries[n] && animation->nodes[n].parent != STILB_SCENE_NONE)
			carries[animation->nodes[n].parent] = true;
	}
	shared->carriers = carries ? malloc((count + 1ull) * sizeof *shared->carriers) : NULL;
	for (uint32_t n = 0; shared->carriers && n < animation->node_count; n++)
		if (carries[n])
			shared->carriers[shared->carrier_count++] = n;
	free(carries);
	return shared->carriers ? STILB_OK : share_memory();
}

/* ---- all --------------------------------------------------------------------------------------------------------- */

/* How many parts the first models of all nodes have. */
static size_t share_count_parts(const stilb_scene *scene)
{
	size_t count = 0;
	for (uint32_t n = 0; n < scene->animation->node_count; n++) {
		const stilb_scene_rest *node = &scene->animation->nodes[n];
		if (node->model_count > 0)
			count += scene->first_part[node->first_model + 1] - scene->first_part[node->first_model];
	}
	return count;
}

stilb_result scene_play_share(const stilb_scene *scene, play_shared *shared)
{
	const stilb_scene_animation *a = scene->animation;
	STILB_ASSERT(a);
	*shared = (play_shared){
		.targets = calloc(a->channel_count + 1ull, sizeof *shared->targets),
		.channels = calloc(a->channel_count + 1ull, sizeof *shared->channels),
		.order = calloc(a->channel_count + 1ull, sizeof *shared->order),
		.clips = calloc(a->clip_count + 1ull, sizeof *shared->clips),
		.moved = calloc(a->node_count + 1ull, sizeof *shared->moved),
		.tracks = calloc(a->channel_count + 1ull, sizeof *shared->tracks),
		.rests = calloc(a->deform_count + 1ull, sizeof *shared->rests),
		.posed = calloc(share_count_parts(scene) + 1, sizeof *shared->posed),
	};
	uint32_t *seen = calloc(a->node_count * (size_t)STILB_SCENE_PATHS + 1, sizeof *seen);
	uint32_t *known = calloc(a->time_count + 1ull, sizeof *known);
	bool good = shared->targets && shared->channels && shared->order && shared->clips && shared->tracks &&
	            shared->moved && shared->rests && shared->posed && seen && known;
	if (good) {
		share_targets(a, shared, seen);
		share_clips(a, shared, known);
	}
	free(seen);
	free(known);
	stilb_result result = good ? share_posed(scene, shared) : share_memory();
	return result == STILB_OK ? share_carriers(a, shared) : result;
}
