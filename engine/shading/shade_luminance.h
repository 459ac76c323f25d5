/* shade_luminance: how bright a colour looks. [any-thread] */
#ifndef SHADE_LUMINANCE_H
#define SHADE_LUMINANCE_H

#include "glsl_begin.h"

/* Weights of the linear Rec.709 channels; they add up to 1, so white keeps its value. Source: ITU-R BT.709-6 (2015),
 * 3.2. */
#define SHADE_LUMINANCE_R 0.2126f
#define SHADE_LUMINANCE_G 0.7152f
#define SHADE_LUMINANCE_B 0.0722f

/* The luminance of a linear Rec.709 colour, in the colour's own unit. */
SHADE_FN float shade_luminance(vec3 color)
{
	return SHADE_LUMINANCE_R * color[0] + SHADE_LUMINANCE_G * color[1] + SHADE_LUMINANCE_B * color[2];
}

#include "glsl_end.h"
#endif
