/*
 * gi_cache_record: irradiance at one point of a surface, how far from there it is valid, and its value at points
 * nearby. [any-thread]
 *
 * Validity.  The expected error of a record at another point is Ward's, with an ellipsoid in place of his sphere:
 *                e = |(dt / r_t, db / r_b, dn / r_n)| + sqrt(1 - n.n_i) / turn
 *            with dt, db, dn the offset from the record in its own frame and n, n_i the normals. The record is valid
 *            where e < 1 and where it does not see the point from below. For radii a R and turn = a this is Ward's
 *            test for the error a and the harmonic mean distance R.
 * Source:    Ward, Rubinstein, Clear (1988); Schwarzhaupt, Jensen, Jarosz (2012).
 */
#ifndef STILB_GI_CACHE_RECORD_H
#define STILB_GI_CACHE_RECORD_H

#include "gi/cache/gi_cache_strata.h"
#include "gi/gi_render.h"
#include "shading/shade_frame.h"

/* Two cache lines: rows of three numbers and, in [3], an unrelated fourth. */
typedef struct gi_cache_record {
	stilb_vec4 position;       /* [3] 1 / r_t */
	stilb_vec4 normal;         /* [3] 1 / r_b */
	stilb_vec4 tangent;        /* [3] 1 / r_n */
	stilb_vec4 irradiance;     /* [3] 1 / the longest radius */
	stilb_vec4 translation[2]; /* [0] gradient along t, [1] along b, per metre */
	stilb_vec4 rotation[2];
} gi_cache_record;

/* The settings that decide about radii. */
typedef struct gi_cache_limits {
	float error; /* Ward's a */
	float turn;  /* see above */
	stilb_gi_cache_radius radius;
	bool gradients;          /* keep them in the record */
	float shortest, longest; /* metres */
	float unit;              /* metres: side of the square over which the Hessian's error is tolerated */
} gi_cache_limits;

/* A record at a position, from what its hemisphere's cells gathered. frame.n is the surface's normal; gathered is
 * along frame.t and frame.b. */
gi_cache_record gi_cache_record_make(const gi_cache_gathered *gathered, shade_frame frame, stilb_vec3 position,
                                     const gi_cache_limits *limits);

/* Limits all radii to this, metres, > 0. */
void gi_cache_record_limit(gi_cache_record *record, float radius);

/* A point may lie so far below a record's plane, in radii, and still count as the same surface. */
#define GI_CACHE_BELOW 0.05f

/* The error e above; the record is valid there if it is below 1. +infinity if it sees the point from below. */
static inline float gi_cache_record_error(const gi_cache_record *record, stilb_vec3 position, stilb_vec3 normal,
                                          float turn)
{
	STILB_ASSERT(turn > 0.0f);
	stilb_vec3 way = position - record->position;
	stilb_vec3 bitangent = stilb_vec3_cross(record->normal, record->tangent);
	float t = stilb_vec3_dot(way, record->tangent) * record->position[3];
	float b = stilb_vec3_dot(way, bitangent) * record->normal[3];
	float height = stilb_vec3_dot(way, record->normal);
	float n = height * record->tangent[3];
	if (0.5f * (height + stilb_vec3_dot(way, normal)) * record->tangent[3] < -GI_CACHE_BELOW)
		return INFINITY;
	float turned = fmaxf(1.0f - stilb_vec3_dot(normal, record->normal), 0.0f);
	return sqrtf(t * t + b * b + n * n) + sqrtf(turned) / turn;
}

/* Ward's weight 1 / e minus its value where the record ceases to be valid, so that records fade in and out; bounded
 * at the record's own position. */
static inline float gi_cache_record_weight(float error)
{
	STILB_ASSERT(error >= 0.0f);
	return 1.0f / fmaxf(error, 1.0f / 16.0f) - 1.0f;
}

/* Irradiance at a position and normal nearby, by linear extrapolation along the gradients. */
static inline stilb_vec3 gi_cache_record_irradiance(const gi_cache_record *record, stilb_vec3 position,
                                                    stilb_vec3 normal)
{
	stilb_vec3 way = position - record->position;
	stilb_vec3 bitangent = stilb_vec3_cross(record->normal, record->tangent);
	return record->irradiance + record->translation[0] * stilb_vec3_dot(way, record->tangent) +
	       record->translation[1] * stilb_vec3_dot(way, bitangent) +
	       record->rotation[0] * stilb_vec3_dot(normal, record->tangent) +
	       record->rotation[1] * stilb_vec3_dot(normal, bitangent);
}

#endif
