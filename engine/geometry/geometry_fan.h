/* The triangles around one position, measured four at a time, and what it costs to move the position along an edge.
 * All is relative to the position, so that floats suffice in meshes of any size. Inside the module alone.
 * Sources: Garland and Heckbert 1997; Hoppe 1999; of the surface as it is, Lindstrom and Turk 1998 (geometry.h). */
#ifndef GEOMETRY_FAN_H
#define GEOMETRY_FAN_H

#include "base/base_math.h"

#include <math.h>

#define GEOMETRY_FAN 96u               /* triangles and edges of a fan, at most; a multiple of four */
#define GEOMETRY_TURN_COSINE_2 0.0625f /* the squared cosine of the angle by which a triangle may turn */

/* Four numbers, or truths, that belong to four triangles or edges. */
typedef int32_t geometry_mask __attribute__((vector_size(16)));

typedef struct geometry_vec3x4 {
	stilb_vec4 x, y, z;
} geometry_vec3x4;

typedef struct geometry_fan {
	geometry_vec3x4 edge[GEOMETRY_FAN / 4];                          /* from the position to its neighbours, metres */
	geometry_vec3x4 a[GEOMETRY_FAN / 4], b[GEOMETRY_FAN / 4];        /* of each triangle, to its other corners */
	geometry_vec3x4 normal[GEOMETRY_FAN / 4];                        /* a x b: as long as twice the area */
	stilb_vec4 area[GEOMETRY_FAN / 4];                               /* m^2 */
	stilb_vec4 along_a[GEOMETRY_FAN / 4], along_b[GEOMETRY_FAN / 4]; /* what geometry_fan_place finds */
	stilb_vec4 cost[GEOMETRY_FAN / 4];                               /* of edges */
	uint32_t edge_blocks, triangle_blocks;
	float whole;                  /* m^2, the sum of the areas */
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

static inline void geometry_set4(geometry_vec3x4 *v, uint32_t i, stilb_vec3 to)
{
	v[i / 4].x[i % 4] = to[0];
	v[i / 4].y[i % 4] = to[1];
	v[i / 4].z[i % 4] = to[2];
}

static inline stilb_vec3 geometry_get4(const geometry_vec3x4 *v, uint32_t i)
{
	return stilb_vec3_make(v[i / 4].x[i % 4], v[i / 4].y[i % 4], v[i / 4].z[i % 4]);
}

/* Begins a fan of so many edges and triangles; edge, a and b are set then. */
static inline void geometry_fan_begin(geometry_fan *fan, uint32_t edges, uint32_t triangles)
{
	fan->edge_blocks = (edges + 3) / 4;
	fan->triangle_blocks = (triangles + 3) / 4;
	fan->edge[fan->edge_blocks - 1] = (geometry_vec3x4){0};
	fan->a[fan->triangle_blocks - 1] = fan->b[fan->triangle_blocks - 1] = (geometry_vec3x4){0};
}

/* Computes normals, areas and planes. */
static inline void geometry_fan_measure(geometry_fan *fan)
{
	stilb_vec4 xx = {0}, yy = {0}, zz = {0}, xy = {0}, xz = {0}, yz = {0}, whole = {0};
	for (uint32_t i = 0; i < fan->triangle_blocks; i++) {
		geometry_vec3x4 n = fan->normal[i] = geometry_cross4(fan->a[i], fan->b[i]);
		stilb_vec4 length = geometry_dot4(n, n);
		for (int k = 0; k < 4; k++)
			length[k] = sqrtf(length[k]);
		whole += fan->area[i] = 0.5f * length;
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

/* What the planes cost, times `scale`, when the position moves along each of the edges: fan->cost. */
static inline void geometry_fan_costs(geometry_fan *fan, float scale)
{
	for (uint32_t i = 0; i < fan->edge_blocks; i++) {
		stilb_vec4 x = fan->edge[i].x, y = fan->edge[i].y, z = fan->edge[i].z;
		stilb_vec4 square = fan->xx * x * x + fan->yy * y * y + fan->zz * z * z;
		stilb_vec4 cost = scale * (square + 2.0f * (fan->xy * x * y + fan->xz * x * z + fan->yz * y * z));
		fan->cost[i] = (stilb_vec4)((cost > 0.0f) & (geometry_mask)cost);
	}
}

/* Finds where the place d away lies in the plane of each triangle: along_a a + along_b b. */
static inline void geometry_fan_place(geometry_fan *fan, stilb_vec3 d)
{
	geometry_vec3x4 way = geometry_same4(d);
	for (uint32_t i = 0; i < fan->triangle_blocks; i++) {
		geometry_vec3x4 a = fan->a[i], b = fan->b[i], n = fan->normal[i];
		/* Of needles, in which values change fast and mean nothing, both are smaller. */
		stilb_vec4 square = geometry_dot4(n, n) + 1e-4f * geometry_dot4(a, a) * geometry_dot4(b, b) + 1e-38f;
		fan->along_a[i] = geometry_dot4(geometry_cross4(way, b), n) / square;
		fan->along_b[i] = geometry_dot4(geometry_cross4(a, way), n) / square;
	}
}

/* Which of four triangles turn over, or nearly so, when the position moves by d. */
static inline geometry_mask geometry_fan_turns(const geometry_fan *fan, uint32_t block, stilb_vec3 d)
{
	geometry_vec3x4 a = fan->a[block], b = fan->b[block], n = fan->normal[block];
	geometry_vec3x4 across = geometry_cross4((geometry_vec3x4){b.x - a.x, b.y - a.y, b.z - a.z}, geometry_same4(d));
	geometry_vec3x4 m = {n.x + across.x, n.y + across.y, n.z + across.z};
	stilb_vec4 nn = geometry_dot4(n, n), mm = geometry_dot4(m, m), nm = geometry_dot4(n, m);
	return (nn > 0.0f) & ~((nm > 0.0f) & (nm * nm > GEOMETRY_TURN_COSINE_2 * nn * mm));
}

#endif
