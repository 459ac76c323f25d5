/*
 * gi_cache_record: irradiance at one point of a surface, how far from there it is valid, and its value at points
 * nearby. [any-thread]
 *
 * Validity.  The expected error of a record at another point is Ward's, with an ellipsoid in place of his sphere:
 *                e = |(dt / r_t, db / r_b, dn / r_n)| + sqrt(1 - n.n_i) / turn
 *            with dt, db, dn the offset of that point from the record, and r_t, r_b, r_n the ellipsoid's radii, along
 *            the record's tangent, bitangent and normal; n and n_i are the normals of the point and of the record. The
 *            record is valid where e < 1, unless the point lies below the record's plane. For radii a R and turn = a
 *            this is Ward's test for the error a and the harmonic mean distance R.
 * Value.     Irradiance is extrapolated along its gradients and, where radii come from the Hessian, along its second
 *            derivative too, one for all colours: without that term the error would have one sign wherever irradiance
 *            bends one way, a bias that no number of rays brings down.
 * Source:    Ward, Rubinstein, Clear (1988); Schwarzhaupt, Jensen, Jarosz (2012).
 */
#ifndef STILB_GI_CACHE_RECORD_H
#define STILB_GI_CACHE_RECORD_H

#include "gi/cache/gi_cache_strata.h"
#include "gi/gi_render.h"
#include "shading/shade_frame.h"

/* A record: 128 bytes, two cache lines. Each row is a vector of three numbers with an unrelated fourth in [3]. r_t, r_b
 * and r_n are the radii above. translation[3]: half the second derivative of irradiance along that axis over the
 * irradiance, m^-2. */
typedef struct gi_cache_record {
	stilb_vec4 position;       /* [3] 1 / r_t */
	stilb_vec4 normal;         /* [3] 1 / r_b */
	stilb_vec4 tangent;        /* [3] 1 / r_n */
	stilb_vec4 irradiance;     /* [3] 1 / the longest radius */
	stilb_vec4 translation[2]; /* change of irradiance per metre along the tangent [0] and the bitangent [1] */
	stilb_vec4 rotation[2];    /* and per unit that the normal's tip moves along them */
} gi_cache_record;

/* The settings that decide about radii. */
typedef struct gi_cache_limits {
	float error; /* Ward's a: the relative error that is tolerated */
	float turn;  /* as in the formula at the top */
	stilb_gi_cache_radius radius;
	bool gradients;          /* keep them in the record */
	float shortest, longest; /* metres */
	float unit;              /* metres: side of the square over which the Hessian's error is tolerated */
} gi_cache_limits;

/* A record at a position, from the sums over its hemisphere (gi_cache_strata_gather). frame.n is the surface's normal;
 * the gradients in gathered are along frame.t and frame.b. */
gi_cache_record gi_cache_record_make(const gi_cache_gathered *gathered, shade_frame frame, stilb_vec3 position,
                                     const gi_cache_limits *limits);

/* Makes each of the record's radii that is larger than radius (> 0, metres) equal to it. */
void gi_cache_record_limit(gi_cache_record *record, float radius);

/* So far below the record's plane, as a share of its radius, a point may lie and still not count as below it. */
#define GI_CACHE_BELOW 0.05f

/* The error e of the formula at the top, at a position and normal; the record is valid there if it is below 1.
 * +infinity if the position lies below the record's plane. */
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

/* Irradiance at a position and normal nearby, by extrapolation. */
static inline stilb_vec3 gi_cache_record_irradiance(const gi_cache_record *record, stilb_vec3 position,
                                                    stilb_vec3 normal)
{
	stilb_vec3 way = position - record->position;
	stilb_vec3 bitangent = stilb_vec3_cross(record->normal, record->tangent);
	float t = stilb_vec3_dot(way, record->tangent), b = stilb_vec3_dot(way, bitangent);
	float bent = 1.0f + record->translation[0][3] * t * t + record->translation[1][3] * b * b;
	return record->irradiance * bent + record->translation[0] * t + record->translation[1] * b +
	       record->rotation[0] * stilb_vec3_dot(normal, record->tangent) +
	       record->rotation[1] * stilb_vec3_dot(normal, bitangent);
}

#endif
