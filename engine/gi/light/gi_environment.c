#include "gi/light/gi_environment.h"

#include "gi/gi_vector.h"
#include "numeric/numeric_sh.h"
#include "shading/shade_sampling.h"

#include <math.h>
#include <stdlib.h>

/* ---- radiance ---------------------------------------------------------------------------------------------------- */

/* A value of an environment map as it is used: NaN and negative values become 0, large ones the limit. */
static float valid(float value)
{
	return value > 0.0f ? value < STILB_NUMERIC_SH_LIMIT ? value : STILB_NUMERIC_SH_LIMIT : 0.0f;
}

static stilb_vec3 texel_radiance(const gi_environment *environment, uint32_t x, uint32_t y)
{
	STILB_ASSERT(x < environment->width && y < environment->height);
	const float *texel = environment->map + ((size_t)y * environment->width + x) * environment->channels;
	if (environment->channels < 3)
		return stilb_vec3_make(valid(texel[0]), valid(texel[0]), valid(texel[0]));
	return stilb_vec3_make(valid(texel[0]), valid(texel[1]), valid(texel[2]));
}

/* Turns a direction of the map into the world. */
static stilb_vec3 from_map(const gi_environment *environment, stilb_vec3 d)
{
	float s = environment->sine, c = environment->cosine;
	return stilb_vec3_make(c * d[0] + s * d[2], d[1], c * d[2] - s * d[0]);
}

/* The texel of a direction: the inverse of stilb_numeric_latlong_direction, turned back. */
static void texel_of(const gi_environment *environment, stilb_vec3 direction, uint32_t *x, uint32_t *y)
{
	float s = environment->sine, c = environment->cosine;
	float right = c * direction[0] - s * direction[2], back = s * direction[0] + c * direction[2];
	float u = atan2f(right, -back) * (0.5f * SHADE_INV_PI) + 0.5f;
	float v = acosf(fminf(fmaxf(direction[1], -1.0f), 1.0f)) * SHADE_INV_PI;
	uint32_t column = (uint32_t)(u * (float)environment->width), row = (uint32_t)(v * (float)environment->height);
	*x = column < environment->width ? column : environment->width - 1;
	*y = row < environment->height ? row : environment->height - 1;
}

stilb_vec3 gi_environment_at(const gi_environment *environment, stilb_vec3 direction)
{
	if (!environment->map)
		return direction[1] < 0.0f ? environment->ground : environment->sky;
	uint32_t x, y;
	texel_of(environment, direction, &x, &y);
	return texel_radiance(environment, x, y);
}

/* ---- making ------------------------------------------------------------------------------------------------------ */

static float weight_of(const gi_environment_choice *choice, stilb_vec3 radiance)
{
	return fmaxf(gi_brightness(radiance) - choice->floor, 0.0f);
}

/* Makes the tables for sampling: cumulative sums of weights along each row (columns), and over the rows, weighted by
 * their solid angles (rows), each divided by its total, so that they end with 1. Returns the integral of weights. */
static double sum_up(const gi_environment *environment, gi_environment_choice *choice)
{
	uint32_t width = environment->width, height = environment->height;
	double total = 0.0;
	for (uint32_t y = 0; y < height; y++) {
		float *columns = choice->columns + (size_t)y * width;
		double row = 0.0;
		for (uint32_t x = 0; x < width; x++) {
			row += (double)weight_of(choice, texel_radiance(environment, x, y));
			columns[x] = (float)row;
		}
		for (uint32_t x = 0; x < width && row > 0.0; x++)
			columns[x] = (float)((double)columns[x] / row);
		total += row * (2.0 * M_PI / width) * (cos(M_PI * y / height) - cos(M_PI * (y + 1.0) / height));
		choice->rows[y] = (float)total;
	}
	for (uint32_t y = 0; y < height && total > 0.0; y++)
		choice->rows[y] = (float)((double)choice->rows[y] / total);
	choice->density = total > 0.0 ? (float)(1.0 / total) : 0.0f;
	return total;
}

static stilb_result use_map(const stilb_image *map, float rotation, gi_environment *environment)
{
	STILB_ASSERT(map->width > 0 && map->height > 0);
	STILB_ASSERT(map->channels >= 1 && map->channels <= 4);
	if (map->format != STILB_IMAGE_F32_LINEAR)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "an environment map needs linear floats, which this picture lacks; give it as .exr or .hdr");
	environment->map = map->pixels;
	environment->width = map->width;
	environment->height = map->height;
	environment->channels = map->channels;
	environment->sine = sinf(rotation);
	environment->cosine = cosf(rotation);
	for (int i = 0; i < 2; i++) {
		gi_environment_choice *choice = &environment->choices[i];
		choice->rows = stilb_memory_alloc(map->height, sizeof(float));
		choice->columns = stilb_memory_alloc((size_t)map->height * map->width, sizeof(float));
		if (!choice->rows || !choice->columns)
			return stilb_fail(STILB_ERROR_MEMORY, "no memory for an environment map of %u x %u texels", map->width,
			                  map->height);
		double total = sum_up(environment, choice);
		if (i > 0)
			break;
		environment->mean = (float)(total / (4.0 * M_PI));
		environment->choices[1].floor = environment->mean;
	}
	return STILB_OK;
}

stilb_result gi_environment_create(const stilb_scene *scene, gi_environment **out)
{
	STILB_ASSERT(scene && out);
	*out = NULL;
	gi_environment *environment = stilb_memory_alloc(1, sizeof *environment);
	if (!environment)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for an environment");
	const float *sky = scene->surroundings.sky, *ground = scene->surroundings.ground;
	*environment = (gi_environment){.sky = {sky[0], sky[1], sky[2]}, .ground = {ground[0], ground[1], ground[2]}};
	environment->mean = 0.5f * (gi_brightness(environment->sky) + gi_brightness(environment->ground));
	stilb_result result = STILB_OK;
	if (scene->surroundings.panorama.pixels)
		result = use_map(&scene->surroundings.panorama, scene->surroundings.rotation, environment);
	if (result == STILB_OK)
		*out = environment;
	else
		gi_environment_destroy(environment);
	return result;
}

void gi_environment_destroy(gi_environment *environment)
{
	if (!environment)
		return;
	for (int i = 0; i < 2; i++) {
		free(environment->choices[i].rows);
		free(environment->choices[i].columns);
	}
	free(environment);
}

/* ---- sampling ---------------------------------------------------------------------------------------------------- */

/* Index of the cell of a cumulative distribution (shares, [count]) in which *u falls; *u becomes the position within
 * that cell, [0, 1). */
static uint32_t find(const float *shares, uint32_t count, float *u)
{
	STILB_ASSERT(count > 0 && *u >= 0.0f && *u < 1.0f);
	uint32_t low = 0, high = count - 1; /* invariant: shares[high] > *u, or high is the last */
	while (low < high) {
		uint32_t middle = (low + high) / 2;
		if (shares[middle] > *u)
			high = middle;
		else
			low = middle + 1;
	}
	float before = low > 0 ? shares[low - 1] : 0.0f, width = shares[low] - before;
	*u = width > 0.0f ? fminf(fmaxf((*u - before) / width, 0.0f), SHADE_UNIFORM_MAX) : 0.0f;
	return low;
}

static bool sample_map(const gi_environment *environment, const gi_environment_choice *choice, stilb_vec2 u,
                       gi_light_sample *sample)
{
	float across = u[0], down = u[1];
	uint32_t y = find(choice->rows, environment->height, &down);
	uint32_t x = find(choice->columns + (size_t)y * environment->width, environment->width, &across);
	double top = cos(M_PI * y / environment->height), bottom = cos(M_PI * (y + 1.0) / environment->height);
	float height = (float)(top + (bottom - top) * (double)down);
	float sine = sqrtf(fmaxf(1.0f - height * height, 0.0f));
	float phi = 2.0f * SHADE_PI * (((float)x + across) / (float)environment->width - 0.5f);
	sample->direction = from_map(environment, stilb_vec3_make(sine * sinf(phi), height, -sine * cosf(phi)));
	sample->radiance = texel_radiance(environment, x, y);
	sample->pdf = weight_of(choice, sample->radiance) * choice->density;
	return sample->pdf > 0.0f;
}

static bool sample_two_colours(const gi_environment *environment, stilb_vec3 normal, stilb_vec2 u,
                               gi_light_sample *sample)
{
	shade_sample chosen = shade_sample_cosine(u);
	sample->direction = shade_frame_to_world(shade_frame_from_normal(normal), chosen.direction);
	sample->radiance = gi_environment_at(environment, sample->direction);
	sample->pdf = chosen.pdf;
	return gi_brightness(sample->radiance) > 0.0f;
}

bool gi_environment_is_sampled(const gi_environment *environment, bool all)
{
	return environment->map ? environment->choices[!all].density > 0.0f : all && environment->mean > 0.0f;
}

bool gi_environment_sample(const gi_environment *environment, bool all, stilb_vec3 normal, stilb_vec2 u,
                           gi_light_sample *sample)
{
	STILB_ASSERT(gi_environment_is_sampled(environment, all));
	sample->distance = INFINITY;
	sample->delta = false;
	return environment->map ? sample_map(environment, &environment->choices[!all], u, sample)
	                        : sample_two_colours(environment, normal, u, sample);
}

float gi_environment_density(const gi_environment *environment, bool all, stilb_vec3 normal, stilb_vec3 direction)
{
	if (!gi_environment_is_sampled(environment, all))
		return 0.0f;
	if (environment->map) {
		const gi_environment_choice *choice = &environment->choices[!all];
		return weight_of(choice, gi_environment_at(environment, direction)) * choice->density;
	}
	float cosine = stilb_vec3_dot(normal, direction);
	return cosine > 0.0f ? cosine * SHADE_INV_PI : 0.0f;
}
