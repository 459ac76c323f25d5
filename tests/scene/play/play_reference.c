#include "play_reference.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- matrices ---------------------------------------------------------------------------------------------------- */

play_place play_place_of(const stilb_mat4 *matrix)
{
	play_place place;
	for (int c = 0; c < 4; c++)
		for (int r = 0; r < 3; r++)
			place.m[c][r] = (double)matrix->m[4 * c + r];
	return place;
}

play_place play_place_product(const play_place *a, const play_place *b)
{
	play_place p;
	for (int c = 0; c < 4; c++)
		for (int r = 0; r < 3; r++) {
			p.m[c][r] = c == 3 ? a->m[3][r] : 0.0;
			for (int k = 0; k < 3; k++)
				p.m[c][r] += a->m[k][r] * b->m[c][k];
		}
	return p;
}

static void cross(const double a[3], const double b[3], double out[3])
{
	for (int i = 0; i < 3; i++)
		out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static double dot(const double *a, const double *b, int count)
{
	double sum = 0.0;
	for (int i = 0; i < count; i++)
		sum += a[i] * b[i];
	return sum;
}

double play_place_determinant(const play_place *place)
{
	double x[3];
	cross(place->m[0], place->m[1], x);
	return dot(x, place->m[2], 3);
}

void play_place_point(const play_place *place, const double from[3], double to[3])
{
	for (int r = 0; r < 3; r++)
		to[r] = place->m[0][r] * from[0] + place->m[1][r] * from[1] + place->m[2][r] * from[2] + place->m[3][r];
}

/* The inverse transpose is the matrix of cofactors over the determinant, of which the sign counts. */
void play_place_normal(const play_place *place, const double from[3], double to[3])
{
	double sign = play_place_determinant(place) < 0.0 ? -1.0 : 1.0;
	for (int r = 0; r < 3; r++)
		to[r] = 0.0;
	for (int c = 0; c < 3; c++) {
		double x[3];
		cross(place->m[(c + 1) % 3], place->m[(c + 2) % 3], x);
		for (int r = 0; r < 3; r++)
			to[r] += sign * x[r] * from[c];
	}
}

static play_place place_of_pose(const double t[3], const double q[4], const double s[3])
{
	double x = q[0], y = q[1], z = q[2], w = q[3];
	const double axes[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)},
	                           {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)},
	                           {2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)}};
	play_place place;
	for (int c = 0; c < 3; c++)
		for (int r = 0; r < 3; r++)
			place.m[c][r] = axes[c][r] * s[c];
	for (int r = 0; r < 3; r++)
		place.m[3][r] = t[r];
	return place;
}

/* ---- keys -------------------------------------------------------------------------------------------------------- */

static void make_unit(double *v, int count)
{
	double length = sqrt(dot(v, v, count));
	for (int i = 0; length > 0.0 && i < count; i++)
		v[i] /= length;
}

/* glTF 2.0, C.4: between a and b, at `share` of the way. */
static void slerp(const double a[4], const double b[4], double share, double out[4])
{
	double cosine = dot(a, b, 4), sign = cosine < 0.0 ? -1.0 : 1.0;
	double angle = acos(fmin(fabs(cosine), 1.0)), sine = sin(angle);
	double of_a = sine > 1e-9 ? sin((1.0 - share) * angle) / sine : 1.0 - share;
	double of_b = sine > 1e-9 ? sin(share * angle) / sine : share;
	for (int i = 0; i < 4; i++)
		out[i] = of_a * a[i] + sign * of_b * b[i];
}

/* The numbers of a channel at a time, [width]. Rotations are unit, also where the file has few digits of them. */
static void sample(const stilb_scene_animation *a, const stilb_scene_channel *c, double time, double *out)
{
	const float *times = a->times + c->first_time, *values = a->values + c->first_value;
	uint32_t width = c->width, last = c->key_count - 1, k = 0;
	bool cubic = c->interpolation == STILB_SCENE_CUBIC, turns = c->path == STILB_SCENE_PATH_ROTATION;
	uint32_t stride = cubic ? 3 * width : width, middle = cubic ? width : 0;
	while (k < last && (double)times[k + 1] <= time)
		k++;
	bool on_key = time < (double)times[0] || k == last || c->interpolation == STILB_SCENE_STEP;
	double span = on_key ? 1.0 : (double)times[k + 1] - (double)times[k];
	double t = on_key ? 0.0 : (time - (double)times[k]) / span;
	const float *at = values + (size_t)k * stride, *to = on_key ? at : at + stride;
	if (turns && c->interpolation == STILB_SCENE_LINEAR) {
		double p[4], q[4];
		for (int i = 0; i < 4; i++) {
			p[i] = (double)at[i];
			q[i] = (double)to[i];
		}
		slerp(p, q, t, out);
		make_unit(out, 4);
		return;
	}
	for (uint32_t i = 0; i < width; i++) {
		double p = (double)at[middle + i], q = (double)to[middle + i];
		double leave = cubic ? span * (double)at[2 * width + i] : 0.0, arrive = cubic ? span * (double)to[i] : 0.0;
		out[i] = cubic ? (2 * t * t * t - 3 * t * t + 1) * p + (t * t * t - 2 * t * t + t) * leave +
		                     (3 * t * t - 2 * t * t * t) * q + (t * t * t - t * t) * arrive
		               : p + (q - p) * t;
	}
	if (turns)
		make_unit(out, 4);
}

/* ---- plays ------------------------------------------------------------------------------------------------------- */

/* Adds a value of a play to the sum of those before; of q and -q the nearer one. */
static void add(double *to, double *sum, const double *value, uint32_t width, double weight, bool turns)
{
	double sign = turns && *sum > 0.0 && dot(to, value, 4) < 0.0 ? -1.0 : 1.0;
	for (uint32_t i = 0; i < width; i++)
		to[i] = (*sum >= 0.0 ? to[i] : 0.0) + sign * weight * value[i];
	*sum = fmax(*sum, 0.0) + weight;
}

/* The rest counts for what is missing to a weight of 1; of more it is the mean. */
static void mix(double *to, double sum, const double *rest, uint32_t width, bool turns)
{
	double share = fmax(1.0 - sum, 0.0), sign = turns && dot(to, rest, 4) < 0.0 ? -1.0 : 1.0;
	for (uint32_t i = 0; i < width; i++)
		to[i] = (to[i] + sign * share * rest[i]) / fmax(sum, 1.0);
	if (turns)
		make_unit(to, 4);
}

static void play_all(const stilb_scene_animation *a, const stilb_scene_play *plays, uint32_t count, play_pose *pose)
{
	for (uint32_t i = 0; i < a->node_count * STILB_SCENE_PATHS; i++)
		pose->sums[i] = -1.0;
	for (uint32_t p = 0; p < count; p++) {
		const stilb_scene_clip *clip = &a->clips[plays[p].clip];
		for (uint32_t i = 0; i < clip->channel_count; i++) {
			const stilb_scene_channel *c = &a->channels[clip->first_channel + i];
			bool weights = c->path == STILB_SCENE_PATH_WEIGHTS;
			double *value = malloc(c->width * sizeof *value);
			double *to =
				weights ? pose->weights + a->nodes[c->node].first_weight : pose->targets[3 * c->node + c->path];
			sample(a, c, plays[p].time, value);
			add(to, &pose->sums[c->node * STILB_SCENE_PATHS + c->path], value, c->width, (double)plays[p].weight,
			    c->path == STILB_SCENE_PATH_ROTATION);
			free(value);
		}
	}
}

/* The matrix of a node in its parent, from what was added to its values. */
static play_place settle(const stilb_scene_animation *a, uint32_t n, play_pose *pose)
{
	const stilb_scene_rest *rest = &a->nodes[n];
	const double *sums = pose->sums + n * STILB_SCENE_PATHS;
	bool moved = false;
	for (int path = 0; path < 3; path++) {
		static const uint32_t widths[3] = {3, 4, 3};
		const float *from = path == 0 ? rest->translation : path == 1 ? rest->rotation : rest->scale;
		double *to = pose->targets[3 * n + (uint32_t)path], own[4] = {0};
		for (uint32_t i = 0; i < widths[path]; i++)
			own[i] = (double)from[i];
		if (sums[path] < 0.0)
			memcpy(to, own, sizeof own);
		else
			mix(to, sums[path], own, widths[path], path == STILB_SCENE_PATH_ROTATION);
		moved |= sums[path] >= 0.0;
	}
	for (uint32_t w = rest->first_weight; w < rest->first_weight + rest->weight_count; w++) {
		double own = (double)a->weights[w];
		if (sums[STILB_SCENE_PATH_WEIGHTS] < 0.0)
			pose->weights[w] = own;
		else
			mix(&pose->weights[w], sums[STILB_SCENE_PATH_WEIGHTS], &own, 1, false);
	}
	return moved ? place_of_pose(pose->targets[3 * n], pose->targets[3 * n + 1], pose->targets[3 * n + 2])
	             : play_place_of(&rest->local);
}

play_pose play_pose_make(const stilb_scene_animation *a, const stilb_scene_play *plays, uint32_t count,
                         const play_place *root)
{
	play_pose pose = {.to_world = calloc(a->node_count + 1ull, sizeof *pose.to_world),
	                  .weights = calloc(a->weight_count + 1ull, sizeof *pose.weights),
	                  .targets = calloc(3ull * a->node_count + 1, sizeof *pose.targets),
	                  .sums = calloc(STILB_SCENE_PATHS * (size_t)a->node_count + 1, sizeof *pose.sums)};
	play_all(a, plays, count, &pose);
	for (uint32_t n = 0; n < a->node_count; n++) {
		play_place local = settle(a, n, &pose);
		const play_place *parent = a->nodes[n].parent == STILB_SCENE_NONE ? root : &pose.to_world[a->nodes[n].parent];
		pose.to_world[n] = play_place_product(parent, &local);
	}
	return pose;
}

void play_pose_free(play_pose *pose)
{
	free(pose->to_world);
	free(pose->weights);
	free(pose->targets);
	free(pose->sums);
}

/* ---- vertices ---------------------------------------------------------------------------------------------------- */

/* The matrix that the skin has for a vertex. */
static play_place skin_place(const play_pose *pose, const stilb_scene_animation *a, const stilb_scene_skin *skin,
                             const stilb_scene_deform *d, uint32_t v)
{
	const uint16_t *joints = d->joints + (size_t)v * d->influences;
	const float *weights = d->weights + (size_t)v * d->influences;
	play_place place = {{{0}}};
	double sum = 0.0;
	for (uint32_t i = 0; i < d->influences; i++)
		sum += (double)weights[i];
	for (uint32_t i = 0; i < d->influences; i++) {
		double share = sum > 0.0 ? (double)weights[i] / sum : i == 0 ? 1.0 : 0.0;
		if (share == 0.0)
			continue;
		uint32_t joint = skin->first_joint + (sum > 0.0 ? joints[i] : 0u);
		play_place bind = play_place_of(&a->inverse_binds[joint]);
		play_place own = play_place_product(&pose->to_world[a->joints[joint]], &bind);
		for (int c = 0; c < 4; c++)
			for (int r = 0; r < 3; r++)
				place.m[c][r] += share * own.m[c][r];
	}
	return place;
}

/* Adds what targets change, and makes a direction unit; without a length it is what it was. False: it has nearly none.
 */
static bool morph(const stilb_scene_deform *d, const float *deltas, const double *weights, uint32_t vertices,
                  uint32_t v, double *to, bool direction)
{
	double from[3] = {to[0], to[1], to[2]};
	for (uint32_t t = 0; deltas && t < d->targets; t++)
		for (int k = 0; k < 3; k++)
			to[k] += weights[t] * (double)deltas[3 * ((size_t)t * vertices + v) + (size_t)k];
	if (!direction || !deltas)
		return true;
	bool clear = dot(to, to, 3) > 1e-6;
	if (dot(to, to, 3) < 1e-30)
		memcpy(to, from, sizeof from);
	make_unit(to, 3);
	return clear;
}

/* The length of the longest side of a matrix. */
static double longest(const play_place *place)
{
	double most = 0.0;
	for (int c = 0; c < 3; c++)
		most = fmax(most, sqrt(dot(place->m[c], place->m[c], 3)));
	return most;
}

play_vertex play_pose_vertex(const play_pose *pose, const stilb_scene *rest, uint32_t node, const play_place *own,
                             uint32_t mesh, uint32_t v)
{
	const stilb_scene_animation *a = rest->animation;
	const stilb_scene_rest *from = &a->nodes[node];
	const stilb_scene_mesh *at_rest = &rest->meshes[mesh];
	const stilb_scene_deform *d = stilb_scene_animation_deform(a, mesh);
	double position[3], normal[3], tangent[3] = {0}, sign = 0.0;
	play_vertex out = {.normal_is_clear = true, .tangent_is_clear = at_rest->extras};
	for (int k = 0; k < 3; k++) {
		position[k] = (double)at_rest->vertices[v].position[k];
		normal[k] = (double)at_rest->vertices[v].normal[k];
		tangent[k] = at_rest->extras ? (double)at_rest->extras[v].tangent[k] : 0.0;
	}
	sign = at_rest->extras ? (double)at_rest->extras[v].tangent[3] : 0.0;
	if (d && d->targets > 0) {
		const double *weights = pose->weights + from->first_weight;
		morph(d, d->positions, weights, at_rest->vertex_count, v, position, false);
		out.normal_is_clear &= morph(d, d->normals, weights, at_rest->vertex_count, v, normal, true);
		out.tangent_is_clear &= morph(d, d->tangents, weights, at_rest->vertex_count, v, tangent, true);
	}
	play_place place;
	if (d && d->influences > 0 && from->skin != STILB_SCENE_NONE && a->skins[from->skin].joint_count > 0)
		place = skin_place(pose, a, &a->skins[from->skin], d, v);
	else
		place = play_place_product(&pose->to_world[node], own);
	play_place_point(&place, position, out.position);
	play_place_normal(&place, normal, out.normal);
	for (int r = 0; r < 3; r++)
		out.tangent[r] = place.m[0][r] * tangent[0] + place.m[1][r] * tangent[1] + place.m[2][r] * tangent[2];
	out.tangent[3] = play_place_determinant(&place) < 0.0 ? -sign : sign;
	/* Enough is left of a direction, which grows with the matrix, the normal with its square. */
	double side = longest(&place);
	out.side_is_clear = fabs(play_place_determinant(&place)) > 1e-4 * side * side * side;
	out.normal_is_clear &= sqrt(dot(out.normal, out.normal, 3)) > 1e-2 * side * side;
	out.tangent_is_clear &= sqrt(dot(out.tangent, out.tangent, 3)) > 1e-2 * side;
	make_unit(out.normal, 3);
	make_unit(out.tangent, 3);
	return out;
}
