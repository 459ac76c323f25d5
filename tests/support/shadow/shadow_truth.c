#include "support/shadow/shadow_truth.h"

#include "gi/film/gi_camera.h"
#include "gi/gi_surface.h"
#include "gi/gi_vector.h"
#include "gi/light/gi_light_listed.h"
#include "gi/trace/gi_cover.h"
#include "gi/trace/gi_ray.h"
#include "support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define ROWS 4u          /* of pixels in a step of the parallel loop */
#define SEED 0x73686164u /* of all random numbers */
#define SETS 8u          /* of points on the light; the standard error is that of the mean of their results */
#define SIDE 8u          /* a set has SIDE^2 points at first, one in each square of a grid, then four times as many */
#define SIDE_MOST 64u    /* and no more than the square of this */
#define ERROR (1.0f / 255.0f) /* of a soft shadow */
#define SHORTER 0x1p-13f      /* rays end before the light by this share, where its face may be */
#define GAP 2.0f        /* of two pixels, in steps from one to the other on one surface, that are of two surfaces */
#define HIDDEN_RAYS 64u /* that look for an edge which the picture does not show */

/* ---- one pixel --------------------------------------------------------------------------------------------------- */

typedef struct shadow_task {
	const stilb_gi_scene *gi;
	const shadow_asked *asked;
	gi_camera camera;
	gi_light_listed light;
	shadow_truth *truth;
	float *errors; /* [height] the largest of each row */
} shadow_task;

static void *room(size_t count, size_t size)
{
	void *array = calloc(count, size);
	assert_non_null(array);
	return array;
}

static bool has_size(const stilb_scene_light *light)
{
	return light->kind >= STILB_SCENE_LIGHT_SPHERE;
}

/* The ray from a point to the light's centre, or to what is sent from there. False: nothing is. */
static bool towards_centre(const gi_light_listed *listed, stilb_vec3 position, gi_light_sample *sample)
{
	const stilb_scene_light *light = &listed->light;
	bool sent = gi_light_listed_sample(listed, position, (stilb_vec2){0.5f, 0.5f}, sample);
	if (!sent || !has_size(light))
		return sent;
	stilb_vec3 to_light = gi_vector(light->position) - position;
	float distance = gi_length(to_light);
	sample->direction = to_light * (1.0f / distance);
	sample->distance = light->kind == STILB_SCENE_LIGHT_SPHERE ? distance - light->radius : distance;
	return true;
}

/* True if the ray from the surface meets something. */
static bool is_blocked(const stilb_gi_scene *gi, const gi_surface *surface, const gi_light_sample *sample)
{
	gi_ray ray = gi_ray_make_of(gi->parts[surface->part].lit_by, gi_surface_ray_origin(surface, sample->direction),
	                            sample->direction, sample->distance * (1.0f - SHORTER), GI_CHANCE_ALL);
	if (!(ray.t_max > 0.0f))
		return false;
	gi->tracer.occluded(&gi->tracer, &ray, 1);
	return ray.t_max < 0.0f;
}

/* The cosine at the surface; 0: it faces away, its triangle or its normal. */
static float cosine_of(const gi_surface *surface, stilb_vec3 direction)
{
	float cosine = stilb_vec3_dot(surface->normal, direction);
	return cosine > 0.0f && stilb_vec3_dot(surface->geometric, direction) > 0.0f ? cosine : 0.0f;
}

static float hard_at(const shadow_task *task, const gi_surface *surface)
{
	gi_light_sample sample;
	if (!towards_centre(&task->light, surface->position, &sample) || !(cosine_of(surface, sample.direction) > 0.0f))
		return NAN;
	return is_blocked(task->gi, surface, &sample) ? 0.0f : 1.0f;
}

/* One set of side^2 points, jittered: the irradiance that arrives, and that of a light which nothing hides. */
static void soft_set(const shadow_task *task, const gi_surface *surface, uint32_t pixel, uint32_t set, uint32_t side,
                     double sums[2])
{
	uint64_t seed = SEED + ((uint64_t)pixel * SETS + set) * (2 * SIDE_MOST) + side;
	uint32_t index = 0;
	for (uint32_t i = 0; i < side * side; i++) {
		float u = ((float)(i % side) + stilb_random_float(seed, index)) / (float)side;
		float v = ((float)(i / side) + stilb_random_float(seed, index + 1)) / (float)side;
		index += 2;
		gi_light_sample sample;
		if (!gi_light_listed_sample(&task->light, surface->position,
		                            (stilb_vec2){fminf(u, 0.999999f), fminf(v, 0.999999f)}, &sample))
			continue;
		stilb_vec3 sent = sample.radiance * (cosine_of(surface, sample.direction) / sample.pdf);
		double light = (double)sent[0] + (double)sent[1] + (double)sent[2];
		if (!(light > 0.0))
			continue;
		sums[1] += light;
		sums[0] += is_blocked(task->gi, surface, &sample) ? 0.0 : light;
	}
}

/* The share of the light that arrives. *error: its standard error, by how much the sets differ. */
static float soft_at(const shadow_task *task, const gi_surface *surface, uint32_t pixel, float *error)
{
	for (uint32_t side = SIDE; side <= SIDE_MOST; side *= 2) {
		double all[2] = {0}, mean = 0.0, square = 0.0;
		uint32_t lit = 0;
		for (uint32_t set = 0; set < SETS; set++) {
			double sums[2] = {0};
			soft_set(task, surface, pixel, set, side, sums);
			all[0] += sums[0];
			all[1] += sums[1];
			if (!(sums[1] > 0.0))
				continue;
			lit++;
			mean += sums[0] / sums[1];
			square += sums[0] / sums[1] * (sums[0] / sums[1]);
		}
		if (lit < SETS) /* of the lamp hardly anything is above the horizon, or nothing */
			continue;
		mean /= lit;
		double variance = (square / lit - mean * mean) / (lit - 1);
		*error = variance > 0.0 ? sqrtf((float)variance) : 0.0f;
		if (*error <= ERROR)
			return (float)(all[0] / all[1]);
	}
	*error = 0.0f;
	return NAN; /* it is not known well enough */
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

static void trace_pixel(const shadow_task *task, uint32_t x, uint32_t y)
{
	shadow_truth *truth = task->truth;
	uint32_t pixel = y * truth->width + x;
	gi_ray_hit ray;
	gi_surface surface;
	truth->visible[pixel] = NAN;
	gi_camera_ray(&task->camera, (float)x + 0.5f, (float)y + 0.5f, (stilb_vec2){0.5f, 0.5f}, &ray);
	ray.ray.time = task->gi->blends ? GI_CHANCE_ALL : 0.0f;
	task->gi->tracer.intersect(&task->gi->tracer, &ray);
	if (!gi_is_hit(&ray))
		return;
	gi_surface_at(task->gi, &ray, &surface);
	for (int i = 0; i < 3; i++) {
		truth->position[pixel][i] = surface.position[i];
		truth->normal[pixel][i] = surface.geometric[i];
	}
	float error = 0.0f;
	truth->visible[pixel] = task->asked->soft && has_size(task->asked->light) ? soft_at(task, &surface, pixel, &error)
	                                                                          : hard_at(task, &surface);
	task->errors[y] = fmaxf(task->errors[y], error);
}

static void trace_rows(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const shadow_task *task = context;
	(void)worker;
	for (uint32_t y = begin; y < end; y++)
		for (uint32_t x = 0; x < task->truth->width; x++)
			trace_pixel(task, x, y);
}

static shadow_task task_of(const stilb_gi_scene *gi, const shadow_asked *asked)
{
	return (shadow_task){.gi = gi,
	                     .asked = asked,
	                     .camera = gi_camera_make(asked->camera, &(stilb_gi_lens){0}, asked->width, asked->height),
	                     .light = gi_light_listed_make(asked->light)};
}

shadow_truth shadow_truth_trace(const stilb_gi_scene *gi, const shadow_asked *asked, stilb_job_pool *pool)
{
	assert_in_range(asked->width, 1, 4096);
	assert_in_range(asked->height, 1, 4096);
	assert_null(stilb_scene_light_mistake(asked->light));
	size_t pixels = (size_t)asked->width * asked->height;
	shadow_truth truth = {.width = asked->width,
	                      .height = asked->height,
	                      .visible = room(pixels, sizeof *truth.visible),
	                      .position = room(pixels, sizeof *truth.position),
	                      .normal = room(pixels, sizeof *truth.normal)};
	shadow_task task = task_of(gi, asked);
	memcpy(truth.eye, asked->camera->position, sizeof truth.eye);
	task.truth = &truth;
	task.errors = room(asked->height, sizeof *task.errors);
	stilb_job_group group = {0};
	assert_int_equal(stilb_job_submit_array(pool, asked->height, ROWS, trace_rows, &task, &group, 0), 0);
	stilb_job_wait(pool, &group, 0);
	for (uint32_t y = 0; y < asked->height; y++)
		truth.error = fmaxf(truth.error, task.errors[y]);
	free(task.errors);
	return truth;
}

void shadow_truth_finish(shadow_truth *truth)
{
	free(truth->visible);
	free(truth->position);
	free(truth->normal);
	*truth = (shadow_truth){0};
}

/* ---- edges ------------------------------------------------------------------------------------------------------- */

/* True if the other pixel's surface continues the plane of this one's, to GAP steps between them. */
static bool continues(const shadow_truth *truth, uint32_t one, uint32_t other)
{
	stilb_vec3 at = gi_vector(truth->position[one]), there = gi_vector(truth->position[other]);
	stilb_vec3 eye = gi_vector(truth->eye), normal = gi_vector(truth->normal[one]);
	float along = stilb_vec3_dot(normal, at - eye) / stilb_vec3_dot(normal, there - eye);
	stilb_vec3 expected = eye + (there - eye) * along; /* where the other pixel's ray meets the plane */
	return along > 0.0f && gi_length(there - expected) <= GAP * gi_length(expected - at);
}

/* Adds the edge between two pixels, if there is one. */
static void edge_between(const shadow_truth *truth, uint32_t x, uint32_t y, bool down, float step, shadow_edges *edges)
{
	uint32_t one = y * truth->width + x, other = one + (down ? truth->width : 1);
	if (!(fabsf(truth->visible[one] - truth->visible[other]) > step)) /* or NaN */
		return;
	if (!continues(truth, one, other) && !continues(truth, other, one))
		return;
	shadow_edge *edge = &edges->edges[edges->count++];
	edge->x = 2 * x + !down;
	edge->y = 2 * y + down;
	memcpy(edge->one, truth->position[one], sizeof edge->one);
	memcpy(edge->other, truth->position[other], sizeof edge->other);
}

shadow_edges shadow_edges_find(const shadow_truth *truth, float step)
{
	shadow_edges edges = {.edges = room((size_t)2 * truth->width * truth->height, sizeof *edges.edges)};
	for (uint32_t y = 0; y < truth->height; y++)
		for (uint32_t x = 0; x < truth->width; x++) {
			if (x + 1 < truth->width)
				edge_between(truth, x, y, false, step, &edges);
			if (y + 1 < truth->height)
				edge_between(truth, x, y, true, step, &edges);
		}
	return edges;
}

void shadow_edges_finish(shadow_edges *edges)
{
	free(edges->edges);
	*edges = (shadow_edges){0};
}

/* In half pixels: first the distance to the nearest edge in each column, then for each pixel the least over the
 * columns. Source: Meijster, Roerdink, Hesselink, "A General Algorithm for Computing Distance Transforms in Linear
 * Time" (2000), whose second step is a search here. */
void shadow_edges_pixels(const shadow_edges *edges, uint32_t width, uint32_t height, float *distance)
{
	uint32_t columns = 2 * width, rows = 2 * height, far = columns + rows;
	uint32_t *in_column = room((size_t)columns * rows, sizeof *in_column);
	for (size_t i = 0; i < (size_t)columns * rows; i++)
		in_column[i] = far;
	for (uint32_t e = 0; e < edges->count; e++)
		in_column[(size_t)edges->edges[e].y * columns + edges->edges[e].x] = 0;
	for (uint32_t x = 0; x < columns; x++) {
		uint32_t *column = in_column + x;
		for (size_t y = 1; y < rows; y++)
			if (column[(y - 1) * columns] + 1 < column[y * columns])
				column[y * columns] = column[(y - 1) * columns] + 1;
		for (size_t y = rows - 1; y-- > 0;)
			if (column[(y + 1) * columns] + 1 < column[y * columns])
				column[y * columns] = column[(y + 1) * columns] + 1;
	}
	for (uint32_t y = 0; y < height; y++)
		for (uint32_t x = 0; x < width; x++) {
			uint64_t least = UINT64_MAX;
			for (uint32_t k = 0; k < columns; k++) {
				uint64_t down = in_column[(size_t)2 * y * columns + k];
				uint64_t across = k > 2 * x ? k - 2 * x : 2 * x - k;
				if (down < far && across * across + down * down < least)
					least = across * across + down * down;
			}
			distance[y * width + x] = least < UINT64_MAX ? 0.5f * sqrtf((float)least) : INFINITY;
		}
	free(in_column);
}

/* The square of the distance from a point to a straight line between two. */
static double square_to_line(const float at[3], const float one[3], const float other[3])
{
	double along = 0.0, length = 0.0, square = 0.0;
	for (int i = 0; i < 3; i++) {
		double line = (double)other[i] - (double)one[i];
		along += line * ((double)at[i] - (double)one[i]);
		length += line * line;
	}
	double share = length > 0.0 ? fmin(fmax(along / length, 0.0), 1.0) : 0.0;
	for (int i = 0; i < 3; i++) {
		double away = (double)at[i] - (double)one[i] - share * ((double)other[i] - (double)one[i]);
		square += away * away;
	}
	return square;
}

float shadow_edges_distance(const shadow_edges *edges, const float at[3])
{
	double least = (double)INFINITY;
	for (uint32_t e = 0; e < edges->count; e++)
		least = fmin(least, square_to_line(at, edges->edges[e].one, edges->edges[e].other));
	return (float)sqrt(least);
}

/* ---- comparing --------------------------------------------------------------------------------------------------- */

/* True if the light's centre is seen from some points of a disk in the surface's plane, and from others not: points on
 * circles, the outermost of this radius. */
static bool has_edge_around(const shadow_task *task, const float at[3], const float normal[3], float radius)
{
	shade_frame frame = shade_frame_from_normal(gi_vector(normal));
	uint32_t lit = 0, blocked = 0;
	for (uint32_t i = 0; i < HIDDEN_RAYS && (lit == 0 || blocked == 0); i++) {
		float angle = 2.39996f * (float)i, far = radius * sqrtf((float)(i + 1) / HIDDEN_RAYS); /* the golden angle */
		stilb_vec3 from = gi_vector(at) + frame.t * (far * cosf(angle)) + frame.b * (far * sinf(angle));
		gi_light_sample sample;
		from += frame.n * (1e-4f * radius);
		if (!towards_centre(&task->light, from, &sample))
			continue;
		gi_ray ray = gi_ray_make(from, sample.direction, sample.distance * (1.0f - SHORTER), GI_CHANCE_ALL);
		task->gi->tracer.occluded(&task->gi->tracer, &ray, 1);
		lit += ray.t_max >= 0.0f;
		blocked += ray.t_max < 0.0f;
	}
	return lit > 0 && blocked > 0;
}

/* True if something hides the light's centre that is not farther from the point than this. */
static bool is_touched(const shadow_task *task, const float at[3], const float normal[3], float distance)
{
	gi_light_sample sample;
	stilb_vec3 from = gi_vector(at) + gi_vector(normal) * (1e-3f * distance);
	if (!towards_centre(&task->light, from, &sample))
		return false;
	gi_ray ray =
		gi_ray_make(from, sample.direction, fminf(sample.distance * (1.0f - SHORTER), distance), GI_CHANCE_ALL);
	task->gi->tracer.occluded(&task->gi->tracer, &ray, 1);
	return ray.t_max < 0.0f;
}

shadow_compared shadow_compare(const stilb_gi_scene *gi, const shadow_asked *asked, const shadow_truth *truth,
                               const shadow_edges *edges, const float *live, float tolerance, const float *allowed)
{
	shadow_compared result = {0};
	shadow_task task = task_of(gi, asked);
	for (uint32_t pixel = 0; pixel < truth->width * truth->height; pixel++) {
		if (isnan(truth->visible[pixel]))
			continue;
		result.compared++;
		if (fabsf(live[pixel] - truth->visible[pixel]) <= tolerance) /* false if live is NaN */
			continue;
		result.wrong++;
		float distance = shadow_edges_distance(edges, truth->position[pixel]);
		if (distance <= allowed[pixel])
			continue;
		if (gi && has_edge_around(&task, truth->position[pixel], truth->normal[pixel], allowed[pixel])) {
			result.hidden++;
			continue;
		}
		if (gi && live[pixel] > truth->visible[pixel] &&
		    is_touched(&task, truth->position[pixel], truth->normal[pixel], allowed[pixel])) {
			result.touching++;
			continue;
		}
		result.outside++;
		result.acne += live[pixel] < truth->visible[pixel];
		if (!(distance / allowed[pixel] > result.worst))
			continue;
		result.worst = distance / allowed[pixel];
		result.worst_x = pixel % truth->width;
		result.worst_y = pixel / truth->width;
	}
	return result;
}
