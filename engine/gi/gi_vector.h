/* gi_vector: the few functions of vectors and colours that the files of this module share. [any-thread] */
#ifndef STILB_GI_VECTOR_H
#define STILB_GI_VECTOR_H

#include "base/base_math.h"

/* Three floats of a struct as a vector. */
static inline stilb_vec3 gi_vector(const float v[3])
{
	return stilb_vec3_make(v[0], v[1], v[2]);
}

static inline float gi_length(stilb_vec3 v)
{
	return sqrtf(stilb_vec3_dot(v, v));
}

/* Mean of the three channels. */
static inline float gi_brightness(stilb_vec3 colour)
{
	return (colour[0] + colour[1] + colour[2]) * (1.0f / 3.0f);
}

/* The sine of an angle in [0, pi] from its cosine; 0 where rounding has made that more than 1. */
static inline float gi_sine(float cosine)
{
	float square = 1.0f - cosine * cosine;
	return sqrtf(square > 0.0f ? square : 0.0f);
}

#endif
