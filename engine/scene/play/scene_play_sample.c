/* Poses of nodes and weights of morph targets from clips. */
#include "profiler/prof.h"
#include "scene/play/scene_play_internal.h"
#include "scene/scene_pose.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

#define SAMPLE_SLICE 1024u     /* channels that a job takes at least */
#define SAMPLE_UNTOUCHED -1.0f /* in place of the sum of weights: nothing replaces it */

/* ---- keys -------------------------------------------------------------------------------------------------------- */

/* The last key that is not after `time`. times[0] <= time < times[count - 1]. */
static uint32_t sample_search(const float *times, uint32_t count, double time)
{
	uint32_t low = 0, high = count - 1;
	while (high - low > 1) {
		uint32_t middle = low + (high - low) / 2;
		if ((double)times[middle] <= time)
			low = middle;
		else
			high = middle;
	}
	return low;
}

/* Where a time stands among the keys of a track. Before the first key and after the last one it stands on that. Keys
 * are often evenly spaced, so that it is found at once. */
static inline play_cursor sample_find(const float *times, const play_track *track, double time)
{
	uint32_t last = track->key_count - 1;
	times += track->first_time;
	if (time < (double)times[0])
		return (play_cursor){0, 0, 0.0f, 0.0f};
	if (time >= (double)times[last])
		return (play_cursor){last, last, 0.0f, 0.0f};
	double guess = (time - (double)times[0]) * (double)track->rate;
	uint32_t key = guess < (double)last ? (uint32_t)guess : last - 1;
	key -= key > 0 && time < (double)times[key];
	key += key + 1 < last && time >= (double)times[key + 1];
	if (!((double)times[key] <= time && time < (double)times[key + 1]))
		key = sample_search(times, track->key_count, time);
	double span = (double)times[key + 1] - (double)times[key];
	return (play_cursor){key, key + 1, (float)((time - (double)times[key]) / span), (float)span};
}

/* ---- values ------------------------------------------------------------------------------------------------------ */

/* Numbers of a value, at any place: a load is one instruction. Of three numbers the fourth is whatever follows, which
 * is there (scene_animation_create) and nobody reads. */
typedef float sample_four __attribute__((vector_size(16), aligned(4), may_alias));

static inline stilb_vec4 sample_load(const float *from)
{
	return *(const sample_four *)from;
}

static inline float sample_dot(stilb_vec4 a, stilb_vec4 b)
{
	stilb_vec4 product = a * b;
	return product[0] + product[1] + product[2] + product[3];
}

/* Adds a value of up to four numbers to what a target has so far, in proportion to its weight. Of q and -q, which are
 * the same rotation, it takes the one that is nearer to the sum. */
static inline void sample_add(float *to, float *sum, stilb_vec4 value, float weight, bool turn)
{
	stilb_vec4 has = sample_load(to);
	if (*sum <= 0.0f) {
		*(sample_four *)to = weight * value;
		*sum = weight;
		return;
	}
	float share = turn && sample_dot(has, value) < 0.0f ? -weight : weight;
	*(sample_four *)to = has + share * value;
	*sum += weight;
}

/* The value of a channel of up to four numbers (glTF 2.0, appendix C). */
static inline stilb_vec4 sample_value(const stilb_scene_channel *channel, const float *values, const play_cursor *at)
{
	size_t width = channel->width;
	if (channel->interpolation != STILB_SCENE_CUBIC) {
		stilb_vec4 a = sample_load(values + at->key * width);
		return channel->interpolation == STILB_SCENE_STEP
		           ? a
		           : a + at->share * (sample_load(values + at->next * width) - a);
	}
	float t = at->share, square = t * t, cube = square * t;
	const float *from = values + 3 * width * at->key, *to = values + 3 * width * at->next;
	return (2.0f * cube - 3.0f * square + 1.0f) * sample_load(from + width) +
	       (cube - 2.0f * square + t) * at->span * sample_load(from + 2 * width) +
	       (3.0f * square - 2.0f * cube) * sample_load(to + width) + (cube - square) * at->span * sample_load(to);
}

/* Adds the numbers of a channel of weights. */
static void sample_weights(const stilb_scene_channel *channel, const float *values, const play_cursor *at, float *row,
                           float *sum, float weight)
{
	bool first = *sum <= 0.0f;
	size_t width = channel->width;
	float t = at->share, square = t * t, cube = square * t;
	for (size_t k = 0; k < width; k++) {
		float number = values[at->key * width + k];
		if (channel->interpolation == STILB_SCENE_LINEAR)
			number += t * (values[at->next * width + k] - number);
		if (channel->interpolation == STILB_SCENE_CUBIC) {
			const float *from = values + 3 * width * at->key + k, *to = values + 3 * width * at->next + k;
			number = (2.0f * cube - 3.0f * square + 1.0f) * from[width] +
			         (cube - 2.0f * square + t) * at->span * from[2 * width] +
			         (3.0f * square - 2.0f * cube) * to[width] + (cube - square) * at->span * to[0];
		}
		row[k] = first ? weight * number : row[k] + weight * number;
	}
	*sum = first ? weight : *sum + weight;
}

static inline void sample_channel(const stilb_scene_channel *channel, const float *values, const play_cursor *at,
                                  float *row, float *sum, float weight)
{
	values += channel->first_value;
	if (channel->path == STILB_SCENE_PATH_WEIGHTS) {
		sample_weights(channel, values, at, row, sum, weight);
		return;
	}
	stilb_vec4 value = sample_value(channel, values, at);
	bool turn = channel->path == STILB_SCENE_PATH_ROTATION;
	if (turn) { /* cubic ones are made unit before they are mixed */
		float square = sample_dot(value, value);
		value *= square > 1e-30f && square < 1e30f ? 1.0f / sqrtf(square) : 1.0f;
	}
	sample_add(row, sum, value, weight, turn);
}

/* ---- rotations, four at a time ----------------------------------------------------------------------------------- */

typedef stilb_vec4 sample_lanes;
typedef int32_t sample_mask __attribute__((vector_size(16)));

static inline sample_lanes sample_all(float x)
{
	return (sample_lanes){x, x, x, x};
}

static inline sample_lanes sample_select(sample_mask mask, sample_lanes a, sample_lanes b)
{
	sample_mask x, y;
	memcpy(&x, &a, sizeof x);
	memcpy(&y, &b, sizeof y);
	x = (x & mask) | (y & ~mask);
	memcpy(&a, &x, sizeof a);
	return a;
}

static inline sample_lanes sample_root(sample_lanes x)
{
#if defined(__x86_64__)
	return (sample_lanes)_mm_sqrt_ps((__m128)x);
#else
	return (sample_lanes){sqrtf(x[0]), sqrtf(x[1]), sqrtf(x[2]), sqrtf(x[3])};
#endif
}

/* sin(x) for 0 <= x <= pi / 2, to 6e-9: Abramowitz and Stegun, 4.3.97 with its coefficients. */
static inline sample_lanes sample_sin(sample_lanes x)
{
	sample_lanes s = x * x, sum = sample_all(-2.39e-8f);
	sum = sum * s + 2.7526e-6f;
	sum = sum * s - 1.98409e-4f;
	sum = sum * s + 8.3333315e-3f;
	sum = sum * s - 1.666666664e-1f;
	return x * (sum * s + 1.0f);
}

/* The shares of a and b in the rotation between them, `angle` apart. acos(c) = sqrt(1 - c) p(c), to 2e-8: Abramowitz
 * and Stegun, 4.4.46. */
static inline void sample_shares(sample_lanes cosine, sample_lanes share, sample_lanes *a, sample_lanes *b)
{
	sample_lanes c = sample_select(cosine < 1.0f, cosine, sample_all(1.0f)), rest = 1.0f - c;
	sample_lanes p = sample_all(-1.2624911e-3f);
	p = p * c + 6.6700901e-3f;
	p = p * c - 1.70881256e-2f;
	p = p * c + 3.08918810e-2f;
	p = p * c - 5.01743046e-2f;
	p = p * c + 8.89789874e-2f;
	p = p * c - 2.145988016e-1f;
	p = p * c + 1.5707963050f;
	sample_lanes angle = sample_root(rest) * p, sine = sample_root(rest * (1.0f + c));
	sample_mask wide = sine > 1e-4f;
	sine = sample_select(wide, sine, sample_all(1.0f));
	*a = sample_select(wide, sample_sin((1.0f - share) * angle) / sine, 1.0f - share);
	*b = sample_select(wide, sample_sin(share * angle) / sine, share);
}

/* Rows become columns. */
static inline void sample_transpose(sample_lanes q[4])
{
	sample_lanes a = __builtin_shufflevector(q[0], q[1], 0, 4, 1, 5),
				 b = __builtin_shufflevector(q[2], q[3], 0, 4, 1, 5);
	sample_lanes c = __builtin_shufflevector(q[0], q[1], 2, 6, 3, 7),
				 d = __builtin_shufflevector(q[2], q[3], 2, 6, 3, 7);
	q[0] = __builtin_shufflevector(a, b, 0, 1, 4, 5);
	q[1] = __builtin_shufflevector(a, b, 2, 3, 6, 7);
	q[2] = __builtin_shufflevector(c, d, 0, 1, 4, 5);
	q[3] = __builtin_shufflevector(c, d, 2, 3, 6, 7);
}

/* The rotations between four pairs, on the shorter way: Shoemake, "Animating rotation with quaternion curves", 1985.
 * a becomes them. */
static inline void sample_turn(sample_lanes a[4], sample_lanes b[4], sample_lanes share)
{
	sample_lanes dot, of_a, of_b;
	sample_transpose(a);
	sample_transpose(b);
	dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
	sample_mask far = dot < 0.0f;
	sample_shares(sample_select(far, -dot, dot), share, &of_a, &of_b);
	of_b = sample_select(far, -of_b, of_b);
	/* On a key it is that key, whatever rounding makes of the share; that of the other is 0 then. */
	of_a = sample_select(share == 0.0f, sample_all(1.0f), of_a);
	for (int k = 0; k < 4; k++)
		a[k] = of_a * a[k] + of_b * b[k];
	sample_transpose(a);
}

/* ---- a figure ---------------------------------------------------------------------------------------------------- */

/* Channels of rotations, `lanes` of them. */
static void sample_rotations(const stilb_scene_animation *animation, const play_shared *shared,
                             const uint32_t channels[4], uint32_t lanes, const play_scratch *scratch, float weight)
{
	float *sums = scratch->row + shared->value_count;
	sample_lanes from[4], to[4], share;
	for (uint32_t i = 0; i < 4; i++) {
		uint32_t c = channels[i < lanes ? i : 0];
		const play_cursor *at = &scratch->cursors[shared->channels[c].track];
		const float *values = animation->values + animation->channels[c].first_value;
		from[i] = sample_load(values + 4 * (size_t)at->key);
		to[i] = sample_load(values + 4 * (size_t)at->next);
		share[i] = at->share;
	}
	sample_turn(from, to, share);
	for (uint32_t i = 0; i < lanes; i++) {
		uint32_t target = shared->channels[channels[i]].target;
		sample_add(scratch->row + shared->targets[target].first, &sums[target], from[i], weight, true);
	}
}

/* Lists the channels that are to be sampled: all, or those of nodes that reach far enough. */
static uint32_t sample_next(const stilb_scene_animation *animation, const play_shared *shared, const uint32_t *order,
                            uint32_t *at, uint32_t end, float least, uint32_t channels[4])
{
	uint32_t count = 0;
	while (*at < end && count < 4) {
		uint32_t c = order[(*at)++];
		if (least <= 0.0f || shared->reach[animation->channels[c].node] >= least)
			channels[count++] = c;
	}
	return count;
}

static void sample_play(const stilb_scene_animation *animation, const play_shared *shared, play_figure *figure,
                        const stilb_scene_play *play, const play_scratch *scratch)
{
	const play_clip *clip = &shared->clips[play->clip];
	const stilb_scene_clip *from = &animation->clips[play->clip];
	const uint32_t *order = shared->order + from->first_channel;
	float *row = scratch->row, *sums = row + shared->value_count;
	uint32_t channels[4], at = 0, count, sampled = 0;
	for (uint32_t t = 0; t < clip->track_count; t++)
		scratch->cursors[t] = sample_find(animation->times, &shared->tracks[clip->first_track + t], play->time);
	while ((count = sample_next(animation, shared, order, &at, clip->rotation_count, figure->least, channels)) > 0) {
		sample_rotations(animation, shared, channels, count, scratch, play->weight);
		sampled += count;
	}
	at = clip->rotation_count;
	while ((count = sample_next(animation, shared, order, &at, from->channel_count, figure->least, channels)) > 0) {
		sampled += count;
		for (uint32_t i = 0; i < count; i++) {
			uint32_t c = channels[i], target = shared->channels[c].target;
			sample_channel(&animation->channels[c], animation->values, &scratch->cursors[shared->channels[c].track],
			               row + shared->targets[target].first, &sums[target], play->weight);
		}
	}
	figure->sampled += sampled;
	figure->still += from->channel_count - sampled;
}

/* The mean of what the plays have added and, for weights below 1, of what the file has. */
static inline stilb_vec4 sample_mean(const float *from, float weight, stilb_vec4 rest)
{
	stilb_vec4 sum = sample_load(from);
	if (weight == 1.0f)
		return sum;
	return weight > 1.0f ? sum * (1.0f / weight) : sum + (1.0f - weight) * rest;
}

/* Makes a quaternion that is unit but for 1e-4 so: if the last digits were always off to the same side, chains of many
 * joints would grow or shrink. One step of Newton's, whose error is measured in double. */
static inline stilb_vec4 sample_settle_length(stilb_vec4 q)
{
	typedef float two __attribute__((vector_size(8)));
	typedef double wide __attribute__((vector_size(16)));
	wide low = __builtin_convertvector((two){q[0], q[1]}, wide),
		 high = __builtin_convertvector((two){q[2], q[3]}, wide);
	wide squares = low * low + high * high;
	return q + q * (float)(0.5 * (1.0 - (squares[0] + squares[1])));
}

/* The same of a rotation; what cancels leaves `before`. */
static inline stilb_vec4 sample_mean_turn(const float *from, float weight, stilb_vec4 rest, stilb_vec4 before)
{
	stilb_vec4 sum = sample_load(from);
	if (weight < 1.0f)
		sum += (sample_dot(sum, rest) < 0.0f ? weight - 1.0f : 1.0f - weight) * rest;
	float square = sample_dot(sum, sum);
	if (!(square > 1e-12f && square < 1e30f))
		return before;
	return sample_settle_length(fabsf(square - 1.0f) < 1e-4f ? sum : sum * (1.0f / sqrtf(square)));
}

static void sample_mean_weights(const float *from, float weight, const float *rest, uint32_t count, float *out)
{
	float scale = weight > 1.0f ? 1.0f / weight : 1.0f, share = weight < 1.0f ? 1.0f - weight : 0.0f;
	for (uint32_t k = 0; k < count; k++)
		out[k] = share > 0.0f ? from[k] + share * rest[k] : from[k] * scale;
}

/* Gives a node what the targets first .. end - 1 have; places that are too far away are left out. */
static inline void sample_node(const stilb_scene_animation *animation, const play_shared *shared,
                               const play_figure *figure, const play_scratch *scratch, uint32_t first, uint32_t end,
                               stilb_scene_nodes *nodes)
{
	uint32_t n = shared->targets[first].node, own = figure->nodes[n];
	const stilb_scene_rest *rest = &animation->nodes[n];
	const float *sums = scratch->row + shared->value_count;
	if (own == STILB_SCENE_NONE)
		return;
	float *pose = nodes->pose[own].translation, *scale = nodes->pose[own].scale;
	stilb_vec4 t = sample_load(pose), q = sample_load(pose + 3), s = {scale[0], scale[1], scale[2]};
	bool moved = false;
	for (uint32_t i = first; i < end; i++) {
		const play_target *target = &shared->targets[i];
		const float *from = scratch->row + target->first;
		if (sums[i] < 0.0f)
			continue;
		moved |= target->path != STILB_SCENE_PATH_WEIGHTS;
		if (target->path == STILB_SCENE_PATH_TRANSLATION)
			t = sample_mean(from, sums[i], sample_load(rest->translation));
		else if (target->path == STILB_SCENE_PATH_ROTATION)
			q = sample_mean_turn(from, sums[i], sample_load(rest->rotation), q);
		else if (target->path == STILB_SCENE_PATH_SCALE)
			s = sample_mean(from, sums[i], (stilb_vec4){rest->scale[0], rest->scale[1], rest->scale[2]});
		else
			sample_mean_weights(from, sums[i], animation->weights + rest->first_weight, target->width,
			                    figure->weights + rest->first_weight);
	}
	stilb_mat4 local;
	if (!moved || !scene_pose_columns(t, q, s, &local))
		return;
	*(sample_four *)pose = t; /* its fourth lane is overwritten by the rotation */
	*(sample_four *)(pose + 3) = q;
	for (int i = 0; i < 3; i++)
		scale[i] = s[i];
	nodes->local[own] = local;
}

/* True if the nodes that clips can move hang on one another as in the file: the places of all follow from the topmost
 * ones. */
static bool sample_is_whole(const stilb_scene *scene, const play_figure *figure)
{
	const play_shared *shared = &scene->figures->shared;
	for (uint32_t i = shared->top_count; i < shared->moved_count; i++) {
		uint32_t n = shared->moved[i], own = figure->nodes[n], above = figure->nodes[scene->animation->nodes[n].parent];
		if (own == STILB_SCENE_NONE || above == STILB_SCENE_NONE || scene->nodes.parent[own] != above)
			return false;
	}
	return true;
}

static void sample_figure(stilb_scene *scene, play_figure *figure, const play_scratch *scratch)
{
	const play_shared *shared = &scene->figures->shared;
	const stilb_scene_animation *animation = scene->animation;
	float *sums = scratch->row + shared->value_count;
	for (uint32_t t = 0; t < shared->target_count; t++)
		sums[t] = SAMPLE_UNTOUCHED;
	figure->sampled = figure->still = 0;
	for (uint32_t p = 0; p < figure->play_count; p++)
		sample_play(animation, shared, figure, &figure->plays[p], scratch);
	for (uint32_t t = 0, end; t < shared->target_count; t = end) {
		for (end = t + 1; end < shared->target_count && shared->targets[end].node == shared->targets[t].node;)
			end++;
		sample_node(animation, shared, figure, scratch, t, end, &scene->nodes);
	}
	figure->whole = sample_is_whole(scene, figure);
}

/* ---- all --------------------------------------------------------------------------------------------------------- */

static void sample_range(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	stilb_scene *scene = context;
	stilb_scene_figures *all = scene->figures;
	for (uint32_t i = begin; i < end; i++)
		sample_figure(scene, &all->figures[all->due[i]], &all->scratch[worker]);
}

bool scene_play_reserve_scratch(stilb_scene_figures *all, uint32_t threads)
{
	if (threads <= all->scratch_count)
		return true;
	play_scratch *grown = realloc(all->scratch, threads * sizeof *grown);
	if (!grown)
		return false;
	all->scratch = grown;
	while (all->scratch_count < threads) {
		size_t numbers = (size_t)all->shared.value_count + all->shared.target_count;
		play_scratch *scratch = &grown[all->scratch_count];
		scratch->row = calloc(numbers + 1, sizeof *scratch->row);
		scratch->cursors = calloc(all->shared.most_tracks + 1ull, sizeof *scratch->cursors);
		if (!scratch->row || !scratch->cursors) {
			free(scratch->row);
			free(scratch->cursors);
			return false;
		}
		all->scratch_count++;
	}
	return true;
}

/* Lists the nodes that the clips of a figure can move, or those from which their places follow, as changed. */
static void sample_list(stilb_scene *scene, play_figure *figure)
{
	const play_shared *shared = &scene->figures->shared;
	edit_nodes *nodes = &scene->edits->nodes;
	for (uint32_t i = 0; i < (figure->whole ? shared->top_count : shared->moved_count); i++) {
		uint32_t own = figure->nodes[shared->moved[i]];
		if (own != STILB_SCENE_NONE)
			scene_edit_node_changed(nodes, own);
	}
	figure->posing = true;
	figure->behind = false;
	scene->figures->counts.channels += figure->sampled;
	scene->figures->counts.still += figure->still;
}

void scene_play_sample(stilb_scene *scene, uint32_t count, stilb_job_pool *pool, uint32_t worker)
{
	PROFILE("scene clips");
	stilb_scene_figures *all = scene->figures;
	uint32_t grain = SAMPLE_SLICE / (all->shared.target_count + 1) + 1;
	/* Without memory for the other threads this one does it alone. */
	if (pool && count > grain && scene_play_reserve_scratch(all, stilb_job_pool_worker_count(pool) + 1))
		stilb_job_parallel_for(pool, count, grain, sample_range, scene, worker);
	else
		sample_range(0, count, 0, scene);
	for (uint32_t i = 0; i < count; i++)
		sample_list(scene, &all->figures[all->due[i]]);
}
