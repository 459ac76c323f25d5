/* shade_planted: literals that planted.c proves, and some that it does not (marked, for planted.sh): are they told
 * apart? */
#ifndef SHADE_PLANTED_H
#define SHADE_PLANTED_H

#include "shading/glsl_begin.h"

#define SHADE_PLANTED_PROVED 3.0f
#define SHADE_PLANTED_LOOSE 5.0f // unproved 5.0f
#define SHADE_PLANTED_EPSILON 1e-6f

/* A table's last one is looked at by nobody. */
SHADE_CONST vec3 SHADE_PLANTED_TABLE = {0.25f, 0.5f, // the line is broken here
                                        0.75f};      // unproved 0.75f

/* 0.0f and 1.0f inside clamp and min are left alone; the 1.0f that is a summand is proved. */
SHADE_FN float shade_planted_proved(float x)
{
	float high = max(x, SHADE_PLANTED_EPSILON) + 2.5e1f; // unproved 2.5e1f
	return SHADE_PLANTED_PROVED * clamp(x, -1.0f, 1.0f) + min(1.0f + x, high);
}

/* Its test allows 10 %. */
SHADE_FN float shade_planted_loose(float x)
{
	return SHADE_PLANTED_LOOSE * x;
}

/* No test calls it. */
SHADE_FN float shade_planted_forgotten(float x)
{
	return x + .125f; // unproved .125f
}

#include "shading/glsl_end.h"
#endif
