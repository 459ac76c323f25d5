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

/* The colour of a black body that glows at this temperature, 1000 .. 15,000 K, beyond which the nearer end counts:
 * linear Rec.709, its largest channel 1; what is redder than Rec.709 can show has no blue. Chromaticity in the diagram
 * of CIE 1960 within 9e-5. Source: Krystek, "An algorithm to calculate correlated colour temperature" (1985); the
 * matrix: ITU-R BT.709-6, 1.3 and 1.4. */
SHADE_FN vec3 shade_color_of_temperature(float kelvin)
{
	float t = clamp(kelvin, 1000.0f, 15000.0f);
	float u =
		(0.860117757f + (1.54118254e-4f + 1.28641212e-7f * t) * t) / (1.0f + (8.42420235e-4f + 7.08145163e-7f * t) * t);
	float v = (0.317398726f + (4.22806245e-5f + 4.20481691e-8f * t) * t) /
	          (1.0f + (-2.89741816e-5f + 1.61456053e-7f * t) * t);
	float x = 1.5f * u / v; /* XYZ of Y = 1: x = 3 u / (2 u - 8 v + 4), y = 2 v / (2 u - 8 v + 4) */
	float z = (2.0f - 0.5f * u - 5.0f * v) / v;
	vec3 color = vec3(3.2404542f * x - 1.5371385f - 0.4985314f * z, -0.9692660f * x + 1.8760108f + 0.0415560f * z,
	                  max(0.0556434f * x - 0.2040259f + 1.0572252f * z, 0.0f));
	return color / max(color[0], max(color[1], color[2]));
}

#include "glsl_end.h"
#endif
