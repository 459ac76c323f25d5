/* The triangles around one position, measured four at a time, and what it costs to move the position along an edge.
 * All is relative to the position, so that floats suffice in meshes of any size. Inside the module alone.
 * Sources: Garland and Heckbert 1997; Hoppe 1999; of the surface as it is, Lindstrom and Turk 1998 (geometry.h). */
#ifndef GEOMETRY_FAN_H
#define GEOMETRY_FAN_H

#include "base/base_math.h"

#include <math.h>
#include <string.h>

#define GEOMETRY_FAN 96u               /* triangles and edges of a fan, at most; a multiple of four */
#define GEOMETRY_TURN_COSINE_2 0.0625f /* the squared cosine of the angle by which a triangle may turn */

/* Four truths that belong to four triangles: 0 or -1. */
typedef int32_t geometry_mask __attribute__((vector_size(16)));

typedef struct geometry_vec3x4 {
	stilb_vec4 x, y, z;
} geometry_vec3x4;

typedef struct geometry_fan {
	stilb_vec3 edge[GEOMETRY_FAN]; /* from the position to its neighbours, metres */
	/* of each four triangles: to their next and their previous corners; a x b, as long as twice the area */
	geometry_vec3x4 a[GEOMETRY_FAN / 4], b[GEOMETRY_FAN / 4], normal[GEOMETRY_FAN / 4];
	_Alignas(16) float area[GEOMETRY_FAN];              /* m^2 */
	float along_a[GEOMETRY_FAN], along_b[GEOMETRY_FAN]; /* what geometry_fan_place finds */
	float cost[GEOMETRY_FAN];                           /* of edges */
	uint32_t triangles;                                 /* rounded up to fours, the rest are of no area */
	float whole;                                        /* m^2, the sum of the areas */
	float xx, yy, zz, xy, xz, yz; /* the sum of squared distances from planes, times their areas, as a matrix */
} geometry_fan;

static inline stilb_vec4 geometry_dot4(geometry_vec3x4 a, geometry_vec3x4 b)
{
	return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline geometry_vec3x4 geometry_cross4(geometry_vec3x4 a, geometry_vec3x4 b)
{
	return (geometry_vec3x4){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline geometry_vec3x4 geometry_same4(stilb_vec3 v)
{
	return (geometry_vec3x4){{v[0], v[0], v[0], v[0]}, {v[1], v[1], v[1], v[1]}, {v[2], v[2], v[2], v[2]}};
}

static inline float geometry_sum4(stilb_vec4 v)
{
	return (v[0] + v[1]) + (v[2] + v[3]);
}

static inline void geometry_store4(float *to, stilb_vec4 v)
{
	memcpy(to, &v, sizeof v);
}

/* The x, y and z of four vectors. */
static inline geometry_vec3x4 geometry_turn4(stilb_vec3 p, stilb_vec3 q, stilb_vec3 r, stilb_vec3 s)
{
	stilb_vec4 xy_pq = __builtin_shufflevector(p, q, 0, 4, 1, 5), xy_rs = __builtin_shufflevector(r, s, 0, 4, 1, 5);
	stilb_vec4 z_pq = __builtin_shufflevector(p, q, 2, 6, 2, 6), z_rs = __builtin_shufflevector(r, s, 2, 6, 2, 6);
	return (geometry_vec3x4){__builtin_shufflevector(xy_pq, xy_rs, 0, 1, 4, 5),
	                         __builtin_shufflevector(xy_pq, xy_rs, 2, 3, 6, 7),
	                         __builtin_shufflevector(z_pq, z_rs, 0, 1, 4, 5)};
}

static inline stilb_vec3 geometry_fan_normal(const geometry_fan *fan, uint32_t i)
{
	const geometry_vec3x4 *n = &fan->normal[i / 4];
	return stilb_vec3_make(n->x[i % 4], n->y[i % 4], n->z[i % 4]);
}

/* Computes normals, areas and planes of so many triangles. sides: of each the edges along its other two corners; of
 * those that fill up the last four twice the same. */
static inline void geometry_fan_measure(geometry_fan *fan, uint32_t count, const uint16_t (*sides)[2])
{
	const stilb_vec3 *edge = fan->edge;
	fan->triangles = (count + 3) & ~3u;
	stilb_vec4 xx = {0}, yy = {0}, zz = {0}, xy = {0}, xz = {0}, yz = {0}, whole = {0};
	for (uint32_t i = 0; i < fan->triangles; i += 4) {
		const uint16_t(*of)[2] = sides + i;
		geometry_vec3x4 a = geometry_turn4(edge[of[0][0]], edge[of[1][0]], edge[of[2][0]], edge[of[3][0]]);
		geometry_vec3x4 b = geometry_turn4(edge[of[0][1]], edge[of[1][1]], edge[of[2][1]], edge[of[3][1]]);
		geometry_vec3x4 n = geometry_cross4(a, b);
		fan->a[i / 4] = a;
		fan->b[i / 4] = b;
		fan->normal[i / 4] = n;
		stilb_vec4 length = geometry_dot4(n, n);
		for (int k = 0; k < 4; k++)
			length[k] = sqrtf(length[k]);
		geometry_store4(&fan->area[i], 0.5f * length);
		whole += 0.5f * length;
		stilb_vec4 weight = 0.5f / (length + 1e-30f); /* a unit normal would weigh as much as the area */
		stilb_vec4 x = weight * n.x, y = weight * n.y;
		xx += x * n.x;
		xy += x * n.y;
		xz += x * n.z;
		yy += y * n.y;
		yz += y * n.z;
		zz += weight * n.z * n.z;
	}
	fan->whole = geometry_sum4(whole);
	fan->xx = geometry_sum4(xx);
	fan->yy = geometry_sum4(yy);
	fan->zz = geometry_sum4(zz);
	fan->xy = geometry_sum4(xy);
	fan->xz = geometry_sum4(xz);
	fan->yz = geometry_sum4(yz);
}

/* Adds a plane through the position with any normal: the squared distance from it costs weight * |normal|^2. */
static inline void geometry_fan_add_plane(geometry_fan *fan, stilb_vec3 normal, float weight)
{
	stilb_vec3 n = normal * weight;
	fan->xx += n[0] * normal[0];
	fan->yy += n[1] * normal[1];
	fan->zz += n[2] * normal[2];
	fan->xy += n[0] * normal[1];
	fan->xz += n[0] * normal[2];
	fan->yz += n[1] * normal[2];
}

/* What the planes cost, times `scale`, when the position moves along each of `count` edges: fan->cost. */
static inline void geometry_fan_costs(geometry_fan *fan, uint32_t count, float scale)
{
	for (uint32_t i = 0; i < count; i += 4) {
		const stilb_vec3 *edge = &fan->edge[i];
		geometry_vec3x4 d = geometry_turn4(edge[0], edge[1], edge[2], edge[3]);
		stilb_vec4 square = fan->xx * d.x * d.x + fan->yy * d.y * d.y + fan->zz * d.z * d.z;
		stilb_vec4 cost = scale * (square + 2.0f * (fan->xy * d.x * d.y + fan->xz * d.x * d.z + fan->yz * d.y * d.z));
		geometry_store4(&fan->cost[i], (stilb_vec4)((cost > 0.0f) & (geometry_mask)cost));
	}
}

/* Finds where the place d away lies in the plane of each triangle: along_a a + along_b b. */
static inline void geometry_fan_place(geometry_fan *fan, stilb_vec3 d)
{
	geometry_vec3x4 way = geometry_same4(d);
	for (uint32_t i = 0; i < fan->triangles; i += 4) {
		geometry_vec3x4 a = fan->a[i / 4], b = fan->b[i / 4], n = fan->normal[i / 4];
		/* Of needles, in which values change fast and mean nothing, both are smaller. */
		stilb_vec4 square = geometry_dot4(n, n) + 1e-4f * geometry_dot4(a, a) * geometry_dot4(b, b) + 1e-38f;
		geometry_store4(&fan->along_a[i], geometry_dot4(geometry_cross4(way, b), n) / square);
		geometry_store4(&fan->along_b[i], geometry_dot4(geometry_cross4(a, way), n) / square);
	}
}

/* Which of the four triangles from i on turn over, or nearly so, when the position moves by d. */
static inline geometry_mask geometry_fan_turns(const geometry_fan *fan, uint32_t i, stilb_vec3 d)
{
	geometry_vec3x4 a = fan->a[i / 4], b = fan->b[i / 4], n = fan->normal[i / 4];
	geometry_vec3x4 across = geometry_cross4((geometry_vec3x4){b.x - a.x, b.y - a.y, b.z - a.z}, geometry_same4(d));
	geometry_vec3x4 m = {n.x + across.x, n.y + across.y, n.z + across.z};
	stilb_vec4 nn = geometry_dot4(n, n), mm = geometry_dot4(m, m), nm = geometry_dot4(n, m);
	return (nn > 0.0f) & ~((nm > 0.0f) & (nm * nm > GEOMETRY_TURN_COSINE_2 * nn * mm));
}

#endif
