/* Quadrics of a vertex: sums of squared differences, weighted by area, as functions of how far the vertex moves. All
 * are relative to the vertex's own position and values, so that nothing cancels. Inside the module alone.
 * Sources: Garland and Heckbert 1997, Hoppe 1999 (geometry.h). */
#ifndef GEOMETRY_QUADRIC_H
#define GEOMETRY_QUADRIC_H

#include "base/base_math.h"

/* d' A d + 2 b d + c: squared distance from planes, times their areas. */
typedef struct geometry_plane_quadric {
	float a00, a11, a22, a01, a02, a12, b0, b1, b2, c;
	float area; /* the sum of the weights */
	float pad;
} geometry_plane_quadric;

/* The same for values: each triangle predicts values g d + e at the place d away, and s is the difference of the values
 * that are there. The sum of area |g d + e - s|^2 is d' A d + 2 b d + c - 2 s (G d + h) + area s^2. It is followed by
 * four vectors for each group of four values: G's x, y and z, and h. */
typedef struct geometry_value_quadric {
	float a00, a11, a22, a01, a02, a12, b0, b1, b2, c;
	float area;
	float pad;
} geometry_value_quadric;

static inline stilb_vec4 *geometry_value_rows(geometry_value_quadric *q)
{
	return (stilb_vec4 *)(q + 1);
}

static inline float geometry_sum(stilb_vec4 v)
{
	return (v[0] + v[1]) + (v[2] + v[3]);
}

/* The plane through the vertex with this unit normal. */
static inline void geometry_plane_add(geometry_plane_quadric *q, stilb_vec3 n, float weight)
{
	q->a00 += weight * n[0] * n[0];
	q->a11 += weight * n[1] * n[1];
	q->a22 += weight * n[2] * n[2];
	q->a01 += weight * n[0] * n[1];
	q->a02 += weight * n[0] * n[2];
	q->a12 += weight * n[1] * n[2];
}

static inline float geometry_plane_cost(const geometry_plane_quadric *q, stilb_vec3 d)
{
	float x = d[0], y = d[1], z = d[2];
	float square = q->a00 * x * x + q->a11 * y * y + q->a22 * z * z;
	float mixed = q->a01 * x * y + q->a02 * x * z + q->a12 * y * z + q->b0 * x + q->b1 * y + q->b2 * z;
	float cost = square + 2.0f * mixed + q->c;
	return cost > 0.0f ? cost : 0.0f;
}

/* Adds to `to` the quadric of a vertex that moves by d to the place of to's. */
static inline void geometry_plane_move(geometry_plane_quadric *to, const geometry_plane_quadric *q, stilb_vec3 d)
{
	float x = d[0], y = d[1], z = d[2];
	to->c += geometry_plane_cost(q, d);
	to->b0 += q->b0 + q->a00 * x + q->a01 * y + q->a02 * z;
	to->b1 += q->b1 + q->a01 * x + q->a11 * y + q->a12 * z;
	to->b2 += q->b2 + q->a02 * x + q->a12 * y + q->a22 * z;
	to->a00 += q->a00;
	to->a11 += q->a11;
	to->a22 += q->a22;
	to->a01 += q->a01;
	to->a02 += q->a02;
	to->a12 += q->a12;
	to->area += q->area;
}

/* The quadric of a triangle of this area at one of its corners. gradient: the values' change per metre along x, y and
 * z, for each group. */
static inline void geometry_value_make(geometry_value_quadric *q, uint32_t groups, const stilb_vec4 *gradient,
                                       float area)
{
	stilb_vec4 *rows = geometry_value_rows(q), xx = {0}, yy = {0}, zz = {0}, xy = {0}, xz = {0}, yz = {0};
	for (uint32_t g = 0; g < groups; g++) {
		stilb_vec4 x = gradient[3 * g], y = gradient[3 * g + 1], z = gradient[3 * g + 2];
		xx += x * x;
		yy += y * y;
		zz += z * z;
		xy += x * y;
		xz += x * z;
		yz += y * z;
		rows[4 * g] = area * x;
		rows[4 * g + 1] = area * y;
		rows[4 * g + 2] = area * z;
		rows[4 * g + 3] = (stilb_vec4){0};
	}
	*q = (geometry_value_quadric){.a00 = area * geometry_sum(xx),
	                              .a11 = area * geometry_sum(yy),
	                              .a22 = area * geometry_sum(zz),
	                              .a01 = area * geometry_sum(xy),
	                              .a02 = area * geometry_sum(xz),
	                              .a12 = area * geometry_sum(yz),
	                              .area = area};
}

/* Adds a quadric of the same vertex. */
static inline void geometry_value_add(geometry_value_quadric *to, const geometry_value_quadric *q, uint32_t groups)
{
	stilb_vec4 *sum = (stilb_vec4 *)to;
	const stilb_vec4 *other = (const stilb_vec4 *)q;
	for (uint32_t i = 0; i < sizeof *q / sizeof *sum + 4 * groups; i++)
		sum[i] += other[i];
}

/* Moves by d to a vertex with values `there`; `here` are the vertex's own. */
static inline float geometry_value_cost(const geometry_value_quadric *q, uint32_t groups, stilb_vec3 d,
                                        const stilb_vec4 *here, const stilb_vec4 *there)
{
	const stilb_vec4 *rows = (const stilb_vec4 *)(q + 1);
	float x = d[0], y = d[1], z = d[2];
	stilb_vec4 sum = {0};
	for (uint32_t g = 0; g < groups; g++) {
		stilb_vec4 s = there[g] - here[g];
		stilb_vec4 t = rows[4 * g] * x + rows[4 * g + 1] * y + rows[4 * g + 2] * z + rows[4 * g + 3];
		sum += s * (q->area * s - 2.0f * t);
	}
	float square = q->a00 * x * x + q->a11 * y * y + q->a22 * z * z;
	float mixed = q->a01 * x * y + q->a02 * x * z + q->a12 * y * z + q->b0 * x + q->b1 * y + q->b2 * z;
	float cost = square + 2.0f * mixed + q->c + geometry_sum(sum);
	return cost > 0.0f ? cost : 0.0f;
}

static inline void geometry_value_move(geometry_value_quadric *to, const geometry_value_quadric *q, uint32_t groups,
                                       stilb_vec3 d, const stilb_vec4 *here, const stilb_vec4 *there)
{
	const stilb_vec4 *rows = (const stilb_vec4 *)(q + 1);
	stilb_vec4 *out = geometry_value_rows(to);
	float x = d[0], y = d[1], z = d[2];
	to->c += geometry_value_cost(q, groups, d, here, there);
	to->b0 += q->b0 + q->a00 * x + q->a01 * y + q->a02 * z;
	to->b1 += q->b1 + q->a01 * x + q->a11 * y + q->a12 * z;
	to->b2 += q->b2 + q->a02 * x + q->a12 * y + q->a22 * z;
	for (uint32_t g = 0; g < groups; g++) {
		stilb_vec4 s = there[g] - here[g];
		stilb_vec4 gx = rows[4 * g], gy = rows[4 * g + 1], gz = rows[4 * g + 2];
		to->b0 -= geometry_sum(s * gx);
		to->b1 -= geometry_sum(s * gy);
		to->b2 -= geometry_sum(s * gz);
		out[4 * g] += gx;
		out[4 * g + 1] += gy;
		out[4 * g + 2] += gz;
		out[4 * g + 3] += rows[4 * g + 3] + gx * x + gy * y + gz * z - q->area * s;
	}
	to->a00 += q->a00;
	to->a11 += q->a11;
	to->a22 += q->a22;
	to->a01 += q->a01;
	to->a02 += q->a02;
	to->a12 += q->a12;
	to->area += q->area;
}

#endif
