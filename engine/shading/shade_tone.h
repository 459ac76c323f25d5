/*
 * shade_tone: the tone maps that a picture can be shown with, by number: linear radiance times the exposure in, linear
 * light of the display out, each channel in [0, 1]. Each has an inverse. [any-thread]
 *
 *   KNEE      linear to 0.6, bent above by the largest channel (shade_tonemap.h): values can be read off the picture.
 *   NONE      what is above 1 is cut off.
 *   NEUTRAL   Khronos' PBR neutral: base colours in plain white light look as their sRGB codes say; linear below
 *             0.76, highlights lose their colour slowly.
 *   FILMIC    Narkowicz's fit of ACES: an S in each channel, which adds contrast and takes colour from bright light.
 *
 * Colours are linear, each channel in [0, 1e30]; shade_tone takes what is above for 1e30.
 * Sources: Karis, "Tone mapping" (2013); Khronos, "PBR neutral tone mapper specification" (2024); Narkowicz, "ACES filmic
 * tone mapping curve" (2015).
 */
#ifndef SHADE_TONE_H
#define SHADE_TONE_H

#include "shade_tonemap.h"

#include "glsl_begin.h"

#define SHADE_TONE_KNEE 0
#define SHADE_TONE_NONE 1
#define SHADE_TONE_NEUTRAL 2
#define SHADE_TONE_FILMIC 3
#define SHADE_TONE_COUNT 4

#define SHADE_NEUTRAL_FRESNEL 0.04f /* what a dielectric mirrors straight ahead: taken from colours again */
#define SHADE_NEUTRAL_START 0.76f   /* the largest channel from which on it is compressed: 0.8 - 0.04 */
#define SHADE_NEUTRAL_DESATURATION 0.15f

/* ---- neutral ------------------------------------------------------------------------------------------------------ */

SHADE_FN vec3 shade_neutral(vec3 color)
{
	float least = min(color[0], min(color[1], color[2]));
	float offset = select(least < 2.0f * SHADE_NEUTRAL_FRESNEL, least - 6.25f * least * least, SHADE_NEUTRAL_FRESNEL);
	vec3 base = color - offset;
	float peak = shade_largest(base), room = 1.0f - SHADE_NEUTRAL_START;
	float bent = 1.0f - room * room / (max(peak, SHADE_NEUTRAL_START) + (room - SHADE_NEUTRAL_START));
	float white = 1.0f - 1.0f / (SHADE_NEUTRAL_DESATURATION * max(peak - bent, 0.0f) + 1.0f);
	vec3 scaled = mix(base * (bent / max(peak, SHADE_NEUTRAL_START)), vec3(bent), white);
	return select(peak < SHADE_NEUTRAL_START, base, scaled);
}

/* color: a result of shade_neutral with its largest channel below 1; near it a float step stands for
 * (0.24 / (1 - largest))^2 steps of the result. */
SHADE_FN vec3 shade_neutral_inverse(vec3 color)
{
	float bent = shade_largest(color), room = 1.0f - SHADE_NEUTRAL_START;
	float peak = room * room / max(1.0f - bent, SHADE_TONEMAP_EPSILON) - (room - SHADE_NEUTRAL_START);
	float unwhite = SHADE_NEUTRAL_DESATURATION * (peak - bent) + 1.0f;
	vec3 unscaled = ((color - bent) * unwhite + bent) * (peak / max(bent, SHADE_NEUTRAL_START));
	vec3 base = select(bent < SHADE_NEUTRAL_START, color, max(unscaled, 0.0f));
	float least = min(base[0], min(base[1], base[2]));
	float offset = select(least < SHADE_NEUTRAL_FRESNEL, sqrt(least * (1.0f / 6.25f)) - least, SHADE_NEUTRAL_FRESNEL);
	return base + offset;
}

/* ---- filmic ------------------------------------------------------------------------------------------------------- */

/* x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14), at most 1, which it reaches at 7.24. x: a channel. */
SHADE_FN float shade_filmic_curve(float x)
{
	x = min(x, 1e3f); /* the limit, 2.51 / 2.43, is above 1 */
	return min(x * (2.51f * x + 0.03f) / (x * (2.43f * x + 0.59f) + 0.14f), 1.0f);
}

/* The inverse; 1 gives 7.24. y: [0, 1]. */
SHADE_FN float shade_filmic_curve_inverse(float y)
{
	float p = 0.03f - 0.59f * y;
	return 0.28f * y / max(p + sqrt(p * p + 0.56f * y * (2.51f - 2.43f * y)), 1e-9f);
}

SHADE_FN vec3 shade_filmic(vec3 color)
{
	return vec3(shade_filmic_curve(color[0]), shade_filmic_curve(color[1]), shade_filmic_curve(color[2]));
}

SHADE_FN vec3 shade_filmic_inverse(vec3 color)
{
	return vec3(shade_filmic_curve_inverse(color[0]), shade_filmic_curve_inverse(color[1]),
	            shade_filmic_curve_inverse(color[2]));
}

/* ---- by number ---------------------------------------------------------------------------------------------------- */

/* tone: SHADE_TONE_... */
SHADE_FN vec3 shade_tone(int tone, vec3 color)
{
	color = min(color, SHADE_TONEMAP_ABOVE_MAX);
	if (tone == SHADE_TONE_NONE)
		return min(color, 1.0f);
	if (tone == SHADE_TONE_NEUTRAL)
		return shade_neutral(color);
	if (tone == SHADE_TONE_FILMIC)
		return shade_filmic(color);
	return shade_tonemap(color, SHADE_TONEMAP_A, SHADE_TONEMAP_B);
}

/* color: a result of shade_tone with its largest channel below 1. */
SHADE_FN vec3 shade_tone_inverse(int tone, vec3 color)
{
	if (tone == SHADE_TONE_NONE)
		return color;
	if (tone == SHADE_TONE_NEUTRAL)
		return shade_neutral_inverse(color);
	if (tone == SHADE_TONE_FILMIC)
		return shade_filmic_inverse(color);
	return shade_tonemap_inverse(color, SHADE_TONEMAP_A, SHADE_TONEMAP_B);
}

#include "glsl_end.h"
#endif
