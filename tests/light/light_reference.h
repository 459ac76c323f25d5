/* Shared by the tests of light lists: what a light sends to a point, in double precision, as shade_light.h and
 * shade_light_area.h have it; the cell of a point as a shader finds it; random lights and views. */
#ifndef LIGHT_REFERENCE_H
#define LIGHT_REFERENCE_H

#include "light/light_lists.h"
#include "scene/scene_light_shade.h"
#include "shading/shade_light_area.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- numbers ----------------------------------------------------------------------------------------------------- */

typedef struct light_random {
	uint64_t seed, index;
} light_random;

static inline double draw(light_random *random, double low, double high)
{
	return low + (high - low) * (double)stilb_random_float(random->seed, random->index++);
}

static inline uint32_t draw_below(light_random *random, uint32_t bound)
{
	return (uint32_t)(stilb_random_u64(random->seed, random->index++) % bound);
}

static inline void draw_direction(light_random *random, float out[3])
{
	double z = draw(random, -1.0, 1.0), angle = draw(random, 0.0, 6.283185307179586), flat = sqrt(1.0 - z * z);
	out[0] = (float)(flat * cos(angle));
	out[1] = (float)(flat * sin(angle));
	out[2] = (float)z;
}

static inline double dot_double(const double a[3], const double b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* ---- lights ------------------------------------------------------------------------------------------------------ */

/* The largest E / I that the light gives to a surface at the point, m^-2: what shade_light_at says, and a bound of what
 * shade_area_irradiance does, which no normal exceeds. */
static inline double reference_sends(const stilb_scene_light *light, const double point[3])
{
	if (light->kind == STILB_SCENE_LIGHT_DIRECTIONAL)
		return 1.0;
	double from[3], square = 0.0, cosine = 0.0;
	for (int i = 0; i < 3; i++) {
		from[i] = point[i] - (double)light->position[i];
		square += from[i] * from[i];
	}
	for (int i = 0; i < 3; i++)
		cosine += from[i] * (double)light->direction[i];
	cosine = square > 1e-8 ? cosine / sqrt(square) : 1.0;
	double share = 1.0, end = fmax((double)light->reach * (double)light->reach, 1e-8);
	bool round = light->kind == STILB_SCENE_LIGHT_SPHERE || light->kind == STILB_SCENE_LIGHT_DISK;
	double radius = round ? (double)light->radius : 0.0;
	if (light->falloff == STILB_SCENE_LIGHT_WINDOWED)
		share = pow(fmax(1.0 - square / end, 0.0), 2.0);
	if (light->falloff == STILB_SCENE_LIGHT_RANGED)
		share = fmax(1.0 - square * square / (end * end), 0.0);
	if (light->falloff == STILB_SCENE_LIGHT_SUBTRACTED)
		share = fmax(1.0 - fmax(square, radius * radius) / end, 0.0);
	if (light->kind == STILB_SCENE_LIGHT_SPOT) {
		double width = fmax((double)light->cos_inner - (double)light->cos_outer, 1e-6);
		double t = fmin(fmax((cosine - (double)light->cos_outer) / width, 0.0), 1.0);
		share *= t * t * (3.0 - 2.0 * t);
	}
	if (light->kind == STILB_SCENE_LIGHT_DISK || light->kind == STILB_SCENE_LIGHT_RECTANGLE)
		share *= cosine > 0.0 ? 1.0 : 0.0;
	return share / fmax(fmax(square, radius * radius), 1e-8);
}

/* A random light near the origin, whose reach is about `reach`. */
static inline stilb_scene_light draw_light(light_random *random, double extent, double reach)
{
	stilb_scene_light light = {.kind = (stilb_scene_light_kind)draw_below(random, STILB_SCENE_LIGHT_KINDS)};
	if (light.kind == STILB_SCENE_LIGHT_DIRECTIONAL && draw_below(random, 8) > 0)
		light.kind = STILB_SCENE_LIGHT_POINT;
	light.falloff = (stilb_scene_light_falloff)draw_below(random, STILB_SCENE_LIGHT_FALLOFFS);
	if (light.falloff == STILB_SCENE_LIGHT_PHYSICAL && draw_below(random, 8) > 0)
		light.falloff = STILB_SCENE_LIGHT_WINDOWED;
	light.use = (stilb_scene_light_use)draw_below(random, STILB_SCENE_LIGHT_USES);
	for (int i = 0; i < 3; i++) {
		light.position[i] = (float)draw(random, -extent, extent);
		light.intensity[i] = (float)draw(random, 0.0, 10.0);
	}
	draw_direction(random, light.direction);
	light.reach = (float)(reach * exp2(draw(random, -3.0, 1.0)));
	light.radius = light.reach * (float)draw(random, 0.01, 0.9);
	light.cos_outer = (float)cos(draw(random, 0.0, 1.0) * draw(random, 0.01, 3.14159));
	light.cos_inner = light.cos_outer + (1.0f - light.cos_outer) * (float)draw(random, 0.0, 1.0);
	/* Two sides of a rectangle, perpendicular to the direction. */
	float other[3], *n = light.direction;
	draw_direction(random, other);
	float x[3] = {n[1] * other[2] - n[2] * other[1], n[2] * other[0] - n[0] * other[2],
	              n[0] * other[1] - n[1] * other[0]};
	float length = sqrtf(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
	float y[3] = {n[1] * x[2] - n[2] * x[1], n[2] * x[0] - n[0] * x[2], n[0] * x[1] - n[1] * x[0]};
	float a = light.reach * (float)draw(random, 0.01, 0.3) / length;
	float b = light.reach * (float)draw(random, 0.01, 0.3) / length;
	for (int i = 0; i < 3; i++) {
		light.half_x[i] = x[i] * a;
		light.half_y[i] = y[i] * b;
	}
	return light;
}

/* ---- views ------------------------------------------------------------------------------------------------------- */

/* View to clip space without perspective: half_width and half_height are half the sides of what it shows, metres. */
static inline stilb_mat4 orthographic(float half_width, float half_height, float near_z, float far_z)
{
	float depth = far_z - near_z;
	return (stilb_mat4){
		{1.0f / half_width, 0, 0, 0, 0, -1.0f / half_height, 0, 0, 0, 0, 1.0f / depth, 0, 0, 0, far_z / depth, 1}};
}

/* A view into lights that lie within extent of the origin. */
static inline stilb_light_grid draw_grid(light_random *random, double extent)
{
	stilb_light_grid grid = {.tile = 8u << draw_below(random, 5),
	                         .width = 1 + draw_below(random, 1400),
	                         .height = 1 + draw_below(random, 800),
	                         .slices = 1 + draw_below(random, draw_below(random, 4) == 0 ? 128 : 24),
	                         .peak = 0.5f};
	double fov = draw_below(random, 4) == 0 ? draw(random, 0.01, 3.0) : draw(random, 0.4, 1.4);
	float aspect = (float)grid.width / (float)grid.height, near_z = (float)(extent * exp2(draw(random, -10.0, -2.0)));
	stilb_vec3 eye = stilb_vec3_make((float)draw(random, -1.2 * extent, 1.2 * extent),
	                                 (float)draw(random, -1.2 * extent, 1.2 * extent),
	                                 (float)draw(random, -1.2 * extent, 1.2 * extent));
	stilb_mat4 view = stilb_mat4_view(eye, (float)draw(random, -3.2, 3.2), (float)draw(random, -1.6, 1.6));
	float half = (float)draw(random, 0.2 * extent, extent);
	stilb_mat4 projection = draw_below(random, 4) == 0
	                            ? orthographic(half * aspect, half, near_z, near_z + 3.0f * (float)extent)
	                            : stilb_mat4_perspective((float)fov, aspect, near_z, near_z + 4.0f * (float)extent);
	if (draw_below(random, 8) == 0) { /* a part of a larger picture: the planes are not symmetric */
		projection.m[8] = (float)draw(random, -2.0, 2.0);
		projection.m[9] = (float)draw(random, -2.0, 2.0);
	}
	grid.view_projection = stilb_mat4_multiply(projection, view);
	grid.first = (float)(extent * exp2(draw(random, -8.0, -1.0)));
	grid.last = grid.first * (float)exp2(draw(random, 0.1, 6.0));
	return grid;
}

/* The pixel that shows a point, and whether one does. */
static inline bool reference_pixel(const stilb_light_grid *grid, const double point[3], uint32_t pixel[2])
{
	double clip[4];
	for (int row = 0; row < 4; row++) {
		clip[row] = (double)grid->view_projection.m[12 + row];
		for (int i = 0; i < 3; i++)
			clip[row] += (double)grid->view_projection.m[4 * i + row] * point[i];
	}
	if (!(clip[3] > 0.0) || clip[2] > clip[3])
		return false;
	double x = (clip[0] / clip[3] * 0.5 + 0.5) * (double)grid->width;
	double y = (clip[1] / clip[3] * 0.5 + 0.5) * (double)grid->height;
	if (!(x >= 0.0 && y >= 0.0 && x < (double)grid->width && y < (double)grid->height))
		return false;
	pixel[0] = (uint32_t)x;
	pixel[1] = (uint32_t)y;
	return true;
}

/* The cell of a point that a pixel shows, as a shader finds it. */
static inline uint32_t reference_cell(const stilb_light_lists *lists, const stilb_light_grid *grid,
                                      const uint32_t pixel[2], const float point[3])
{
	const float *plane = lists->depth_plane;
	float depth = plane[0] * point[0] + plane[1] * point[1] + plane[2] * point[2] + plane[3];
	float slice = floorf(log2f(depth) * lists->slice_scale + lists->slice_bias);
	float last = (float)(lists->slices - 1);
	uint32_t z = (uint32_t)(slice > 0.0f ? (slice < last ? slice : last) : 0.0f);
	return pixel[0] / grid->tile + lists->columns * (pixel[1] / grid->tile + lists->rows * z);
}

/* The point at the depth z that a place of the picture shows, [-1, 1]. */
static inline void reference_place(const stilb_light_lists *lists, const stilb_light_grid *grid, double nx, double ny,
                                   double z, double out[3])
{
	const float *m = grid->view_projection.m;
	double rows[3][4], minors[3][3];
	for (int k = 0; k < 4; k++) {
		rows[0][k] = (double)m[4 * k] - nx * (double)m[4 * k + 3];
		rows[1][k] = (double)m[4 * k + 1] - ny * (double)m[4 * k + 3];
		rows[2][k] = (double)lists->depth_plane[k];
	}
	rows[2][3] -= z;
	for (int i = 0; i < 3; i++)
		for (int k = 0; k < 3; k++) {
			const double *a = rows[(i + 1) % 3], *b = rows[(i + 2) % 3];
			minors[i][k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
		}
	double volume = dot_double(rows[0], minors[0]);
	for (int k = 0; k < 3; k++)
		out[k] = -(rows[0][3] * minors[0][k] + rows[1][3] * minors[1][k] + rows[2][3] * minors[2][k]) / volume;
}

/* Where slice k begins; of the first one 0. */
static inline double reference_depth(const stilb_light_lists *lists, uint32_t k)
{
	return k > 0 ? exp2(((double)k - (double)lists->slice_bias) / (double)lists->slice_scale) : 0.0;
}

/* True if the lists say that the cell has the light. */
static inline bool lists_have(const stilb_light_lists *lists, uint32_t cell, uint32_t light)
{
	for (uint32_t i = 0; i < lists->everywhere_count; i++)
		if (lists->lights[i] == light)
			return true;
	for (uint32_t i = lists->starts[cell]; i < lists->starts[cell + 1]; i++)
		if (lists->lights[lists->everywhere_count + lists->ids[i]] == light)
			return true;
	return false;
}

/* What the header promises of any lists: everything in its range, and ascending. */
static inline void assert_sound(const stilb_light_lists *lists, uint32_t light_count)
{
	uint32_t cells = lists->columns * lists->rows * lists->slices, own = lists->light_count - lists->everywhere_count;
	assert_true(lists->everywhere_count <= lists->light_count && lists->light_count <= light_count);
	assert_int_equal(lists->starts[0], 0);
	assert_int_equal(lists->starts[cells], lists->id_count);
	for (uint32_t i = 0; i < lists->light_count; i++)
		if (lists->lights[i] >= light_count ||
		    (i > 0 && i != lists->everywhere_count && lists->lights[i - 1] >= lists->lights[i]))
			fail_msg("light %u of %u is %u", i, lists->light_count, lists->lights[i]);
	for (uint32_t cell = 0; cell < cells; cell++) {
		if (lists->starts[cell] > lists->starts[cell + 1])
			fail_msg("the list of cell %u ends before it begins", cell);
		for (uint32_t i = lists->starts[cell]; i < lists->starts[cell + 1]; i++)
			if (lists->ids[i] >= own || (i > lists->starts[cell] && lists->ids[i - 1] >= lists->ids[i]))
				fail_msg("id %u of cell %u is %u", i - lists->starts[cell], cell, lists->ids[i]);
	}
}

#endif
