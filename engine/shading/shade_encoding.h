/*
 * shade_encoding: radiance in four 8-bit numbers: RGBM and LogLuv. [any-thread]
 *
 *            range                    error in 8 bits, at most                        filtering, blending
 *   RGBM     [0, factor^gamma]        any channel 0.44 % of the largest one, 0.85 %   nearly right; can be multiplied
 *                                     in the dark (gamma 2.2, m >= 0.2, >= 2/255)
 *   LogLuv   2^-63 to 2^64, and 0     luminance 0.07 %, any channel 2.1 % of the      neither
 *                                     largest one
 * m is RGBM's fourth number, the multiplier: 0.44 % holds for m >= 0.2, 0.85 % for dark colours, m >= 2/255.
 * Encoders return numbers in [0, 1], which the target rounds to 8 bits; decoders take what was stored. Colours are
 * linear Rec.709, channels >= 0.
 */
#ifndef SHADE_ENCODING_H
#define SHADE_ENCODING_H

#include "shade_luminance.h"

#include "glsl_begin.h"

/* What an 8-bit UNORM target stores for v: the nearest of 0/255 ... 255/255. */
SHADE_FN vec4 shade_unorm8(vec4 v)
{
	return floor(clamp(v, 0.0f, 1.0f) * 255.0f + 0.5f) / 255.0f;
}

/* ---- RGBM: colour and multiplier --------------------------------------------------------------------------------- */

/* The usual factor and gamma: Karis's constant 6, and the gamma that gives the range 6^2.2 = 51.5 that he names for it.
 * With a square root, gamma 2, the range is 36. */
#define SHADE_RGBM_FACTOR 6.0f
#define SHADE_RGBM_GAMMA 2.2f

/* The largest value that a channel can hold. */
SHADE_FN float shade_rgbm_range(float factor, float gamma)
{
	return pow(factor, gamma);
}

/* color^(1 / gamma) / factor = rgb m, with m the largest channel rounded up to 8 bits: then rgb is in [0, 1], and its
 * largest channel near 1, where 8 bits are fine. m is at least 1/255, also for black. Past the range channels are
 * clipped: bring colours in with shade_tonemap first. factor >= 1, gamma in [1, 3].
 * Error of a channel in color^(1 / gamma): at most factor m / 510, so that the largest channel x is off by at most
 * gamma k / (k - 1) / 510 of itself, k = 255 m; and below range / 255^gamma (k = 1) by factor / 255 / 510 before the
 * power.
 * Source: Karis, "RGBM color encoding" (2009). */
SHADE_FN vec4 shade_rgbm_encode(vec3 color, float factor, float gamma)
{
	vec3 scaled = pow(max(color, 0.0f), vec3(1.0f / gamma)) / factor;
	float largest = min(max(scaled[0], max(scaled[1], scaled[2])), 1.0f);
	float m = max(ceil(largest * 255.0f), 1.0f) / 255.0f;
	return vec4(min(scaled / m, 1.0f), m);
}

/* (factor rgb m)^gamma */
SHADE_FN vec3 shade_rgbm_decode(vec4 stored, float factor, float gamma)
{
	vec3 rgb = vec3(stored[0], stored[1], stored[2]);
	return pow(rgb * (stored[3] * factor), vec3(gamma));
}

/* What a multiply blend into the stored rgb must use to multiply the decoded colour by tint, per channel in [0, 1]:
 * tint^(1 / gamma). Exact (up to the 8 bits) because the power of a product is the product of powers; a transfer that
 * is not a pure power, sRGB's, has no such tint. */
SHADE_FN vec3 shade_rgbm_tint(vec3 tint, float gamma)
{
	return pow(tint, vec3(1.0f / gamma));
}

/* ---- CIE XYZ ----------------------------------------------------------------------------------------------------- */

/* Rows of the matrix to XYZ (Y is the luminance) and of its inverse. Source: IEC 61966-2-1:1999, 5.2; the inverse to
 * seven digits here, since the standard's four lose colours that go there and back. */
SHADE_CONST vec3 SHADE_XYZ_X = {0.4124f, 0.3576f, 0.1805f};
SHADE_CONST vec3 SHADE_XYZ_Z = {0.0193f, 0.1192f, 0.9505f};
SHADE_CONST vec3 SHADE_XYZ_R = {3.2406255f, -1.5372080f, -0.4986286f};
SHADE_CONST vec3 SHADE_XYZ_G = {-0.9689307f, 1.8757561f, 0.0415175f};
SHADE_CONST vec3 SHADE_XYZ_B = {0.0557101f, -0.2040211f, 1.0569959f};

SHADE_FN vec3 shade_xyz_from_linear(vec3 color)
{
	return vec3(dot(color, SHADE_XYZ_X), shade_luminance(color), dot(color, SHADE_XYZ_Z));
}

/* Channels are negative outside the Rec.709 gamut. */
SHADE_FN vec3 shade_linear_from_xyz(vec3 xyz)
{
	return vec3(dot(xyz, SHADE_XYZ_R), dot(xyz, SHADE_XYZ_G), dot(xyz, SHADE_XYZ_B));
}

/* ---- LogLuv: hue and the logarithm of the luminance -------------------------------------------------------------- */

#define SHADE_LOGLUV_LUMINANCE_MIN 1e-30f /* keeps the logarithm of black finite; encoded as black */
#define SHADE_LOGLUV_LEVEL_MAX 255.999f   /* the level of a luminance of 2^64.5 */
#define SHADE_LOGLUV_V_MIN 1e-3f /* less than any colour has: keeps the decoded result of arbitrary bytes finite */

/* (u, v, level's whole part, level's fraction). u and v are CIE 1976 u' and v' times 410 / 255, which fits all colours;
 * level = 2 log2(Y) + 127 in [0, 256), in 16 bits: its error of 1/510 is 0.07 % of Y. Level 0 is black, and takes all
 * that is darker than 2^-63.5; brighter than 2^64.5 keeps its hue.
 * Source: Ward Larson, "LogLuv Encoding for Full-Gamut, High-Dynamic Range Images" (1998), the 32-bit form, for u', v'
 * and 410; the level's two bytes as in Karis, "RGBM color encoding" (2009), whose matrix stands for primaries of its
 * own and is not used. */
SHADE_FN vec4 shade_logluv_encode(vec3 color)
{
	vec3 xyz = shade_xyz_from_linear(max(color, 0.0f));
	float level = 2.0f * log2(max(xyz[1], SHADE_LOGLUV_LUMINANCE_MIN)) + 127.0f;
	if (level <= 0.0f)
		return vec4(0.0f);
	level = min(level, SHADE_LOGLUV_LEVEL_MAX);
	float scale = 410.0f / 255.0f / (xyz[0] + 15.0f * xyz[1] + 3.0f * xyz[2]);
	return vec4(4.0f * xyz[0] * scale, 9.0f * xyz[1] * scale, floor(level) / 255.0f, fract(level));
}

/* Channels that the rounded hue puts below 0 are 0; the others are scaled so that the luminance stays. */
SHADE_FN vec3 shade_logluv_decode(vec4 stored)
{
	float level = 255.0f * stored[2] + stored[3];
	if (level <= 0.0f)
		return vec3(0.0f);
	float y = exp2(0.5f * (level - 127.0f));
	float u = stored[0] * (255.0f / 410.0f);
	float v = max(stored[1] * (255.0f / 410.0f), SHADE_LOGLUV_V_MIN);
	float scale = 0.25f * y / v;
	vec3 xyz = vec3(9.0f * u * scale, y, (12.0f - 3.0f * u - 20.0f * v) * scale);
	vec3 color = max(shade_linear_from_xyz(xyz), 0.0f);
	return color * (y / max(shade_luminance(color), y));
}

#include "glsl_end.h"
#endif
