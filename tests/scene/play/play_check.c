#include "play_check.h"

#include "play_reference.h"
#include "scene/play/scene_play_internal.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What is compared in one call. */
typedef struct compare {
	const stilb_scene *rest, *scene;
	const play_pose *pose;
	const play_place *from_place; /* what the figure's place is to */
	double low[3], high[3];       /* of the reference */
	double position, normal, tangent, bound;
	uint32_t worst_node, worst_vertex;
	uint64_t vertices, directions;
} compare;

static double distance(const double *a, const double *b, int count)
{
	double sum = 0.0;
	for (int i = 0; i < count; i++)
		sum += (a[i] - b[i]) * (a[i] - b[i]);
	return sqrt(sum);
}

static double unit(double v[3])
{
	double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
	for (int i = 0; length > 0.0 && i < 3; i++)
		v[i] /= length;
	return length;
}

/* How far a direction of a mesh is from being unit. */
static double not_unit(const float v[3])
{
	double copy[3] = {(double)v[0], (double)v[1], (double)v[2]};
	return fabs(unit(copy) - 1.0);
}

/* A vertex that the scene shows, in the world. */
static play_vertex shown_vertex(const stilb_scene *scene, uint32_t part, uint32_t v)
{
	const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[part]];
	play_place place = play_place_of(&scene->part_transform[part]);
	double position[3], normal[3];
	play_vertex out = {.tangent = {0}};
	for (int k = 0; k < 3; k++) {
		position[k] = (double)mesh->vertices[v].position[k];
		normal[k] = (double)mesh->vertices[v].normal[k];
	}
	play_place_point(&place, position, out.position);
	play_place_normal(&place, normal, out.normal);
	unit(out.normal);
	for (int r = 0; mesh->extras && r < 3; r++)
		for (int c = 0; c < 3; c++)
			out.tangent[r] += place.m[c][r] * (double)mesh->extras[v].tangent[c];
	unit(out.tangent);
	if (mesh->extras)
		out.tangent[3] = (double)mesh->extras[v].tangent[3] * (play_place_determinant(&place) < 0.0 ? -1.0 : 1.0);
	return out;
}

static void compare_part(compare *c, uint32_t node, const play_place *own, uint32_t rest_part, uint32_t model,
                         uint32_t part)
{
	const stilb_scene *scene = c->scene;
	uint32_t mesh = c->rest->part_mesh[rest_part];
	const stilb_scene_mesh *shown = &scene->meshes[scene->part_mesh[part]];
	const double center[3] = {(double)scene->bounds.x[model], (double)scene->bounds.y[model],
	                          (double)scene->bounds.z[model]};
	assert_int_equal(c->rest->meshes[mesh].vertex_count, shown->vertex_count);
	for (uint32_t v = 0; v < c->rest->meshes[mesh].vertex_count; v++) {
		play_vertex wanted = play_pose_vertex(c->pose, c->rest, node, own, mesh, v), got = shown_vertex(scene, part, v);
		double error = distance(wanted.position, got.position, 3);
		if (!(error <= c->position)) {
			c->position = isnan(error) ? (double)INFINITY : error;
			c->worst_node = node;
			c->worst_vertex = v;
		}
		const double behind[3] = {-got.normal[0], -got.normal[1], -got.normal[2]};
		double turned = distance(wanted.normal, got.normal, 3);
		if (!wanted.side_is_clear)
			turned = fmin(turned, distance(wanted.normal, behind, 3));
		if (wanted.normal_is_clear)
			c->normal = fmax(fmax(c->normal, turned), not_unit(shown->vertices[v].normal));
		if (wanted.tangent_is_clear)
			c->tangent = fmax(fmax(c->tangent, not_unit(shown->extras[v].tangent)),
			                  distance(wanted.tangent, got.tangent, wanted.side_is_clear ? 4 : 3));
		c->bound = fmax(c->bound, distance(center, wanted.position, 3) - (double)scene->bounds.radius[model]);
		for (int k = 0; k < 3; k++) {
			c->low[k] = fmin(c->low[k], wanted.position[k]);
			c->high[k] = fmax(c->high[k], wanted.position[k]);
		}
		c->directions += wanted.normal_is_clear + wanted.tangent_is_clear;
	}
	c->vertices += c->rest->meshes[mesh].vertex_count;
}

/* The place of a model on the node of the animation: of an instance its own. */
static play_place own_place(const stilb_scene *rest, uint32_t model, uint32_t node)
{
	stilb_mat4 own = stilb_mat4_identity();
	if (rest->model_node[model] > 0 && rest->model_node[model] - 1 != node)
		own = rest->nodes.local[rest->model_node[model] - 1];
	return play_place_of(&own);
}

void play_compare(const stilb_scene *rest, const stilb_scene *scene, uint32_t figure, const stilb_mat4 *place,
                  const stilb_scene_play *plays, uint32_t count, const char *name, play_errors *errors)
{
	const stilb_scene_animation *a = rest->animation;
	play_place root = play_place_of(place);
	play_pose pose = play_pose_make(a, plays, count, &root);
	compare c = {.rest = rest, .scene = scene, .pose = &pose};
	for (int k = 0; k < 3; k++) {
		c.low[k] = (double)INFINITY;
		c.high[k] = -(double)INFINITY;
	}
	const play_figure *shown = &scene->figures->figures[figure];
	for (uint32_t n = 0; n < a->node_count; n++)
		for (uint32_t m = a->nodes[n].first_model; m < a->nodes[n].first_model + a->nodes[n].model_count; m++) {
			uint32_t model = shown->models[m - scene->figures->shared.first_model];
			play_place own = own_place(rest, m, n);
			assert_true(model != STILB_SCENE_NONE);
			assert_int_equal(scene->first_part[model + 1] - scene->first_part[model],
			                 rest->first_part[m + 1] - rest->first_part[m]);
			for (uint32_t p = rest->first_part[m]; p < rest->first_part[m + 1]; p++)
				compare_part(&c, n, &own, p, model, scene->first_part[model] + p - rest->first_part[m]);
		}
	play_pose_free(&pose);
	double size = distance(c.low, c.high, 3);
	if (c.position / size > errors->position)
		snprintf(errors->where, sizeof errors->where, "%.60s: node %u, vertex %u", name, c.worst_node, c.worst_vertex);
	errors->position = fmax(errors->position, c.position / size);
	errors->bound = fmax(errors->bound, c.bound / size);
	errors->normal = fmax(errors->normal, c.normal);
	errors->tangent = fmax(errors->tangent, c.tangent);
	errors->vertices += c.vertices;
	errors->directions += c.directions;
}

void play_assert(const play_errors *errors, const char *name)
{
	if (!(errors->position <= 1e-5 && errors->normal <= 1e-4 && errors->tangent <= 1e-4 && errors->bound <= 1e-5) ||
	    errors->vertices == 0 || errors->directions == 0)
		fail_msg(
			"%s: positions %.2e of the size (%s), normals %.2e, tangents %.2e, outside of bounds %.2e; %llu vertices",
			name, errors->position, errors->where, errors->normal, errors->tangent, errors->bound,
			(unsigned long long)errors->vertices);
}
