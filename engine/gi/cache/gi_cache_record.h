/*
 * gi_cache_record: what is known at one place of a surface, how far it holds, and what it says about a place nearby.
 * [any-thread]
 *
 * Validity.  The error that is expected of a record at a place is Ward's, with an ellipsoid in the place of his sphere:
 *                e = |(dt / r_t, db / r_b, dn / r_n)| + sqrt(1 - n.n_i) / turn
 *            where dt, db, dn is the way from the record, in its own frame. The record counts where e < 1 and where it
 *            does not see the place from below. With radii a R and turn = a this is his test for the error a and radius
 *            R.
 * Source:    Ward, Rubinstein, Clear (1988); Schwarzhaupt, Jensen, Jarosz (2012).
 */
#ifndef STILB_GI_CACHE_RECORD_H
#define STILB_GI_CACHE_RECORD_H

#include "gi/cache/gi_cache_strata.h"
#include "gi/gi_render.h"
#include "shading/shade_frame.h"

/* Two cache lines: rows of three numbers, and a fourth that has nothing to do with them. */
typedef struct gi_cache_record {
	stilb_vec4 position;       /* [3] 1 / r_t */
	stilb_vec4 normal;         /* [3] 1 / r_b */
	stilb_vec4 tangent;        /* [3] 1 / r_n */
	stilb_vec4 irradiance;     /* [3] 1 / the longest radius */
	stilb_vec4 translation[2]; /* along t and b; [3] 0 */
	stilb_vec4 rotation[2];
} gi_cache_record;

/* How long radii are. */
typedef struct gi_cache_limits {
	float error; /* Ward's a */
	float turn;  /* of gi_cache_record_error */
	stilb_gi_cache_radius radius;
	bool gradients;          /* kept in the record */
	float shortest, longest; /* metres */
	float unit;              /* metres: side of the area that the Hessian's error is summed over */
} gi_cache_limits;

/* frame.n is the surface's normal. */
gi_cache_record gi_cache_record_make(const gi_cache_gathered *gathered, shade_frame frame, stilb_vec3 position,
                                     const gi_cache_limits *limits);

/* No radius longer than this, metres. */
void gi_cache_record_limit(gi_cache_record *record, float radius);

/* How far below a record's plane, in radii, a place may lie and still be on the same surface. */
#define GI_CACHE_BELOW 0.05f

/* Below 1: the record holds there. */
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

/* Ward's weight less what it is where the record ceases to hold, so that none comes or goes with a jump; bounded at the
 * record's own place. */
static inline float gi_cache_record_weight(float error)
{
	STILB_ASSERT(error >= 0.0f);
	return 1.0f / fmaxf(error, 1.0f / 16.0f) - 1.0f;
}

/* Irradiance there, extrapolated along the gradients. */
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
