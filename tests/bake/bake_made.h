/* What the tests of baking share: meshes that are made, and atlases of scenes. */
#ifndef BAKE_MADE_H
#define BAKE_MADE_H

#include "support/test.h"

#include "bake/bake_texels.h"
#include "scene/scene_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MADE_PI 3.14159265f

static inline stilb_job_pool *made_pool(uint32_t workers)
{
	stilb_job_pool *pool;
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	desc.worker_count = workers;
	assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
	return pool;
}

typedef struct made_mesh {
	float (*positions)[3];
	uint32_t *indices;
	stilb_bake_mesh mesh; /* of these arrays */
} made_mesh;

static inline made_mesh made_empty(uint32_t vertices, uint32_t triangles)
{
	made_mesh made = {
		calloc(vertices + 1, sizeof *made.positions), calloc(3 * (size_t)triangles + 1, sizeof *made.indices), {0}};
	assert_non_null(made.positions);
	assert_non_null(made.indices);
	made.mesh = (stilb_bake_mesh){made.positions, sizeof *made.positions, made.indices, vertices, triangles};
	return made;
}

static inline void made_finish(made_mesh *made)
{
	free(made->positions);
	free(made->indices);
}

/* w x h squares of two triangles over (s, t) in [0, 1]^2, placed by a function. */
static inline made_mesh made_grid(uint32_t w, uint32_t h, void (*place)(float s, float t, float position[3]))
{
	made_mesh made = made_empty((w + 1) * (h + 1), 2 * w * h);
	uint32_t *out = made.indices;
	for (uint32_t j = 0; j <= h; j++)
		for (uint32_t i = 0; i <= w; i++)
			place((float)i / (float)w, (float)j / (float)h, made.positions[j * (w + 1) + i]);
	for (uint32_t j = 0; j < h; j++)
		for (uint32_t i = 0; i < w; i++) {
			uint32_t a = j * (w + 1) + i, b = a + 1, c = a + w + 1, d = c + 1;
			const uint32_t square[6] = {a, b, c, b, d, c};
			memcpy(out, square, sizeof square);
			out += 6;
		}
	return made;
}

static inline void made_set(float position[3], float x, float y, float z)
{
	position[0] = x;
	position[1] = y;
	position[2] = z;
}

static inline void made_place_sphere(float s, float t, float p[3])
{
	float a = 2.0f * MADE_PI * (s < 1.0f ? s : 0.0f), b = MADE_PI * t;
	float r = t > 0.0f && t < 1.0f ? sinf(b) : 0.0f;
	made_set(p, r * cosf(a), cosf(b), -r * sinf(a));
}

static inline void made_place_cylinder(float s, float t, float p[3])
{
	float a = 2.0f * MADE_PI * (s < 1.0f ? s : 0.0f);
	made_set(p, cosf(a), 3.0f * t, -sinf(a));
}

static inline void made_place_torus(float s, float t, float p[3])
{
	float a = 2.0f * MADE_PI * (s < 1.0f ? s : 0.0f), b = 2.0f * MADE_PI * (t < 1.0f ? t : 0.0f);
	float r = 2.0f + 0.7f * cosf(b);
	made_set(p, r * cosf(a), 0.7f * sinf(b), r * sinf(a));
}

/* Hills and cliffs. */
static inline void made_place_land(float s, float t, float p[3])
{
	float y = 0.15f * sinf(9.0f * s + 2.0f * t) + 0.1f * cosf(14.0f * t - 3.0f * s * s) + 0.04f * sinf(50.0f * s * t);
	made_set(p, 2.0f * s, y, -2.0f * t);
}

/* A cube of side 1; every corner is three vertices. */
static inline made_mesh made_cube(void)
{
	made_mesh made = made_empty(24, 12);
	for (uint32_t f = 0; f < 6; f++) {
		uint32_t axis = f / 2, x = (axis + 1) % 3, y = (axis + 2) % 3;
		for (uint32_t c = 0; c < 4; c++) {
			float *p = made.positions[4 * f + c];
			p[axis] = (float)(f & 1);
			p[x] = (float)(c & 1);
			p[y] = (float)(c >> 1);
		}
		const uint32_t front[6] = {0, 1, 3, 0, 3, 2}, back[6] = {0, 3, 1, 0, 2, 3};
		for (uint32_t i = 0; i < 6; i++)
			made.indices[6 * f + i] = 4 * f + (f & 1 ? front[i] : back[i]);
	}
	return made;
}

/* A number in [0, 1). */
static inline float made_random(uint64_t *state)
{
	return stilb_random_float(12345, (*state)++);
}

#endif
