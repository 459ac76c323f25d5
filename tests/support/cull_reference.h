/* Shared by the culling tests: the plainest test of a sphere, random numbers, scenes and views. */
#ifndef CULL_REFERENCE_H
#define CULL_REFERENCE_H

#include "culling/cull_internal.h"
#include "support/test.h"

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static inline bool reference_visible(stilb_sphere sphere, const stilb_frustum *frustum)
{
	for (int p = 0; p < 6; p++) {
		const stilb_plane *plane = &frustum->planes[p];
		float sum = ((sphere.x * plane->x + sphere.y * plane->y) + sphere.z * plane->z) + plane->distance;
		if (!(sum >= -sphere.radius))
			return false;
	}
	return true;
}

static inline bool reference_bit(const uint64_t *bits, uint32_t i)
{
	return bits[i / 64] >> (i % 64) & 1;
}

/* A generator with its own state: the same numbers in every run. */
typedef struct reference_random {
	uint64_t seed, index;
} reference_random;

static inline uint32_t random_below(reference_random *random, uint32_t bound)
{
	return (uint32_t)(stilb_random_u64(random->seed, random->index++) % bound);
}

static inline float random_between(reference_random *random, float low, float high)
{
	return low + (high - low) * stilb_random_float(random->seed, random->index++);
}

/* A camera anywhere in and around a world that reaches extent metres from the origin. */
static inline stilb_frustum random_view(reference_random *random, float extent)
{
	float near_z = exp2f(random_between(random, -6.0f, 3.0f));
	float far_z = near_z + exp2f(random_between(random, -1.0f, 2.0f)) * extent;
	stilb_mat4 projection =
		stilb_mat4_perspective(random_between(random, 0.05f, 2.8f), random_between(random, 0.3f, 3.0f), near_z, far_z);
	float reach = 1.5f * extent;
	stilb_vec3 eye = stilb_vec3_make(random_between(random, -reach, reach), random_between(random, -reach, reach),
	                                 random_between(random, -reach, reach));
	stilb_mat4 view = stilb_mat4_view(eye, random_between(random, -3.2f, 3.2f), random_between(random, -1.6f, 1.6f));
	stilb_mat4 matrix = stilb_mat4_multiply(projection, view);
	return stilb_frustum_from_matrix(&matrix);
}

/* The box low <= x, y, z <= high. */
static inline stilb_frustum box_view(const float low[3], const float high[3])
{
	return (stilb_frustum){{
		{1.0f, 0.0f, 0.0f, -low[0]},
		{-1.0f, 0.0f, 0.0f, high[0]},
		{0.0f, 1.0f, 0.0f, -low[1]},
		{0.0f, -1.0f, 0.0f, high[1]},
		{0.0f, 0.0f, 1.0f, -low[2]},
		{0.0f, 0.0f, -1.0f, high[2]},
	}};
}

/* A value that a careless caller might hand in. */
static inline float random_strange_value(reference_random *random)
{
	float strange[] = {(float)NAN, INFINITY, -INFINITY, 3e38f, -3e38f, 1e-44f, -1e-44f, -0.0f, -1.0f, -50.0f, 1e9f};
	return strange[random_below(random, sizeof strange / sizeof *strange)];
}

/* A sphere of which one random number, of its centre or radius, is such a value; the others are harmless. */
static inline stilb_sphere random_strange_sphere(reference_random *random, float extent)
{
	float v[4] = {random_between(random, -extent, extent), random_between(random, -extent, extent),
	              random_between(random, -extent, extent), random_between(random, 0.0f, 2.0f)};
	v[random_below(random, 4)] = random_strange_value(random);
	return (stilb_sphere){v[0], v[1], v[2], v[3]};
}

/* ---- scenes of bounds alone ------------------------------------------------------------------------------------ */

static inline void scene_set(stilb_scene *scene, uint32_t model, stilb_sphere sphere)
{
	scene->bounds.x[model] = sphere.x;
	scene->bounds.y[model] = sphere.y;
	scene->bounds.z[model] = sphere.z;
	scene->bounds.radius[model] = sphere.radius;
}

static inline stilb_sphere scene_get(const stilb_scene *scene, uint32_t model)
{
	const stilb_scene_bounds *b = &scene->bounds;
	return (stilb_sphere){b->x[model], b->y[model], b->z[model], b->radius[model]};
}

static inline stilb_scene scene_make(uint32_t model_count)
{
	stilb_scene scene = {.model_count = model_count};
	float **arrays[] = {&scene.bounds.x, &scene.bounds.y, &scene.bounds.z, &scene.bounds.radius};
	for (int i = 0; i < 4; i++) {
		*arrays[i] = calloc(model_count + 1, sizeof(float));
		assert_non_null(*arrays[i]);
	}
	return scene;
}

static inline void scene_free(stilb_scene *scene)
{
	free(scene->bounds.x);
	free(scene->bounds.y);
	free(scene->bounds.z);
	free(scene->bounds.radius);
}

/* The stress test's layout: a square grid of 2 m, nearly flat. */
static inline stilb_sphere grid_sphere(reference_random *random, uint32_t model, uint32_t model_count)
{
	uint32_t side = (uint32_t)ceil(sqrt((double)model_count));
	float x = (float)(2 * (int)(model % side) - (int)side + 1), z = (float)(2 * (int)(model / side) - (int)side + 1);
	return (stilb_sphere){x, random_between(random, 0.0f, 0.8f), z, random_between(random, 1.42f, 1.7f)};
}

#endif
