/*
 * shade_tonemap: brings radiance of any height into a range and keeps its hue. [any-thread]
 *
 * A curve is applied to one number of the colour, its luma, and the colour is scaled by the same number: a curve for
 * each channel would wash bright colours out. Karis offers two lumas.
 *   Largest channel   every channel ends in the range: what a display or an 8-bit encoding needs. With luminance a
 *                     saturated blue (weight 0.07) would leave the range and be clipped.
 *   Luminance         equally bright colours are dimmed alike, and it is linear: what averages need (shade_firefly.h).
 *                     A channel may end above the range, blue at up to 14 times its end.
 * Two curves: the simple one bends everywhere; the other is linear up to a, so that measured values can be read off the
 * picture, and bends above a towards the range's end b, which it never passes; with a = 0 and b = range it is the
 * simple one. All have inverses.
 *
 * Colours are linear, each channel in [0, 1e30].
 * Source: Karis, "Tone mapping" (2013).
 */
#ifndef SHADE_TONEMAP_H
#define SHADE_TONEMAP_H

#include "shade_luminance.h"

#include "glsl_begin.h"

/* What the renderer uses: linear to 0.6 (sRGB code 203 of 255), everything below 1. */
#define SHADE_TONEMAP_A 0.6f
#define SHADE_TONEMAP_B 1.0f

/* For an inverse, a mapped value counts as lying below the range's end by at least this share of it (a float step): so
 * the result is finite for a colour that was rounded, or filtered, onto the end. */
#define SHADE_TONEMAP_EPSILON 6e-8f

#define SHADE_TONEMAP_ABOVE_MAX 1e30f /* infinite light ends at b too, not at inf / inf */

SHADE_FN float shade_largest(vec3 color)
{
	return max(color[0], max(color[1], color[2]));
}

/* ---- the simple curve -------------------------------------------------------------------------------------------- */

/* color / (1 + luma / range): luma becomes luma range / (range + luma), in [0, range). luma is shade_luminance or
 * shade_largest of the colour; range > 0. */
SHADE_FN vec3 shade_tonemap_simple(vec3 color, float luma, float range)
{
	return color * (range / (range + luma));
}

/* The inverse, color / (1 - luma / range), luma of the mapped colour in [0, range). A float step of it there stands for
 * (range / (range - luma))^2 steps of the result. */
SHADE_FN vec3 shade_tonemap_simple_inverse(vec3 color, float luma, float range)
{
	return color * (range / max(range - luma, SHADE_TONEMAP_EPSILON * range));
}

/* ---- linear to a, then bent -------------------------------------------------------------------------------------- */

/* T(x) = x up to a, then (a^2 - b x) / (2 a - b - x); value and slope continue at a, and b is the limit. x >= 0,
 * 0 <= a < b. Computed as a + the simple curve of the part above a, with the range b - a: the same number, without
 * differences of large numbers. */
SHADE_FN float shade_tonemap_curve(float x, float a, float b)
{
	float above = clamp(x - a, 0.0f, SHADE_TONEMAP_ABOVE_MAX);
	return select(x <= a, x, min(a + (b - a) * (above / (above + (b - a))), b));
}

/* The inverse, y = T(x) in [0, b): a + (b - a) (y - a) / (b - y) above a. Steep near b: a float step of y there stands
 * for ((b - a) / (b - y))^2 steps of x. */
SHADE_FN float shade_tonemap_curve_inverse(float y, float a, float b)
{
	float unbent = a + (b - a) * (y - a) / max(b - y, SHADE_TONEMAP_EPSILON * b);
	return select(y <= a, y, unbent);
}

/* color scaled by T(luma) / luma. */
SHADE_FN vec3 shade_tonemap_scaled(vec3 color, float luma, float a, float b)
{
	return color * select(luma <= a, 1.0f, shade_tonemap_curve(luma, a, b) / max(luma, a));
}

/* color scaled by x / luma, where T(x) = luma. */
SHADE_FN vec3 shade_tonemap_unscaled(vec3 color, float luma, float a, float b)
{
	return color * select(luma <= a, 1.0f, shade_tonemap_curve_inverse(luma, a, b) / max(luma, a));
}

/* Tone maps a color by its largest channel, scaling all channels alike: each channel of the result is in [0, b]. */
SHADE_FN vec3 shade_tonemap(vec3 color, float a, float b)
{
	return min(shade_tonemap_scaled(color, shade_largest(color), a, b), b);
}

/* The inverse of shade_tonemap. color: a result of it with its largest channel below b. */
SHADE_FN vec3 shade_tonemap_inverse(vec3 color, float a, float b)
{
	return shade_tonemap_unscaled(color, shade_largest(color), a, b);
}

/* Tone maps a color by its luminance, scaling all channels alike: the luminance of the result is in [0, b], up to
 * rounding; a channel may be above b. */
SHADE_FN vec3 shade_tonemap_luminance(vec3 color, float a, float b)
{
	return shade_tonemap_scaled(color, shade_luminance(color), a, b);
}

/* The inverse of shade_tonemap_luminance. color: a result of it with its luminance below b. */
SHADE_FN vec3 shade_tonemap_luminance_inverse(vec3 color, float a, float b)
{
	return shade_tonemap_unscaled(color, shade_luminance(color), a, b);
}

/* ---- tone maps of pictures -------------------------------------------------------------------------------------
 * By number, as a picture can be shown: linear radiance times the exposure in, linear light of the display out, each
 * channel in [0, 1]. Each has an inverse. KNEE, NEUTRAL, LUMINANCE and PIECEWISE cut nothing off: of two lights the
 * brighter one is shown brighter, as far as floats tell.
 *
 *   KNEE      linear to 0.6, bent above by the largest channel (shade_tonemap): values can be read off the picture.
 *   NONE      what is above 1 is cut off.
 *   NEUTRAL   Khronos' PBR neutral: base colours in plain white light look as their sRGB codes say; linear below
 *             0.76, highlights lose their colour slowly.
 *   FILMIC    Narkowicz's fit of ACES: an S in each channel, which adds contrast and takes colour from bright light. It
 *             is 1 from 7.24 on.
 *   LUMINANCE the knee's curve of the luminance: what is shown is as bright as that says, whatever the hue. A colour
 *             that would leave the display is mixed with the grey that is as bright.
 *   PIECEWISE an S in each channel: a power at the toe, a line of slope 1.25 through 0.18, a power at the shoulder that
 *             never ends.
 *   HABLE     Hable's curve of "Uncharted 2" in each channel, at twice the exposure as there: dark to the toe, 1 from
 *             5.6 on.
 *
 * Sources: Khronos, "PBR neutral tone mapper specification" (2024); Narkowicz, "ACES filmic tone mapping curve" (2015);
 * Hable, "Filmic tonemapping operators" (2010), and "Filmic tonemapping with piecewise power curves" (2017), for toe,
 * line and shoulder: there the shoulder ends at a white point.
 */

#define SHADE_TONE_KNEE 0
#define SHADE_TONE_NONE 1
#define SHADE_TONE_NEUTRAL 2
#define SHADE_TONE_FILMIC 3
#define SHADE_TONE_LUMINANCE 4
#define SHADE_TONE_PIECEWISE 5
#define SHADE_TONE_HABLE 6
#define SHADE_TONE_COUNT 7

#define SHADE_NEUTRAL_FRESNEL 0.04f /* what a dielectric mirrors straight ahead: taken from colours again */
#define SHADE_NEUTRAL_START 0.76f   /* the largest channel from which on it is compressed: 0.8 - 0.04 */
#define SHADE_NEUTRAL_DESATURATION 0.15f

/* ---- neutral ---------------------------------------------------------------------------------------------------- */

SHADE_FN vec3 shade_neutral(vec3 color)
{
	float least = min(color[0], min(color[1], color[2]));
	float offset = select(least < SHADE_NEUTRAL_FRESNEL + SHADE_NEUTRAL_FRESNEL, least - 6.25f * least * least,
	                      SHADE_NEUTRAL_FRESNEL);
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

/* ---- filmic ----------------------------------------------------------------------------------------------------- */

#define SHADE_FILMIC_MAX 1e3f      /* above it the curve has long been 1; its square is finite */
#define SHADE_FILMIC_EPSILON 1e-9f /* 0 / 0 at 0 is 0 */

/* x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14), at most 1, which it reaches at 7.24. x: a channel. */
SHADE_FN float shade_filmic_curve(float x)
{
	x = min(x, SHADE_FILMIC_MAX);
	return min(x * (2.51f * x + 0.03f) / (x * (2.43f * x + 0.59f) + 0.14f), 1.0f);
}

/* The inverse; 1 gives 7.24. y: [0, 1]. */
SHADE_FN float shade_filmic_curve_inverse(float y)
{
	float p = 0.03f - 0.59f * y;
	return 0.28f * y / max(p + sqrt(p * p + 0.56f * y * (2.51f - 2.43f * y)), SHADE_FILMIC_EPSILON);
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

/* ---- luminance -------------------------------------------------------------------------------------------------- */

SHADE_FN vec3 shade_shown_by_luminance(vec3 color)
{
	float bright = shade_tonemap_curve(shade_luminance(color), SHADE_TONEMAP_A, SHADE_TONEMAP_B);
	vec3 scaled = shade_tonemap_luminance(color, SHADE_TONEMAP_A, SHADE_TONEMAP_B);
	float largest = shade_largest(scaled);
	float kept = select(largest > 1.0f, (1.0f - bright) / max(largest - bright, SHADE_TONEMAP_EPSILON), 1.0f);
	return min(scaled * kept + bright * (1.0f - kept), 1.0f);
}

/* color: a result of it with its luminance below 1. Of the colours that are mixed to the same one, the least
 * saturated. */
SHADE_FN vec3 shade_shown_by_luminance_inverse(vec3 color)
{
	return shade_tonemap_luminance_inverse(color, SHADE_TONEMAP_A, SHADE_TONEMAP_B);
}

/* ---- piecewise -------------------------------------------------------------------------------------------------- */

#define SHADE_PIECEWISE_SLOPE 1.25f
#define SHADE_PIECEWISE_TOE 0.09f /* where the toe ends, and what is shown there: on the line through 0.18 */
#define SHADE_PIECEWISE_TOE_SHOWN 0.0675f
#define SHADE_PIECEWISE_TOE_POWER (5.0f / 3.0f) /* so that its slope there is the line's */
#define SHADE_PIECEWISE_SHOULDER 0.45f          /* where the shoulder begins, likewise */
#define SHADE_PIECEWISE_SHOULDER_SHOWN 0.5175f
#define SHADE_PIECEWISE_SHOULDER_POWER 1.5f
#define SHADE_PIECEWISE_SHOULDER_SCALE 1.7271157f /* slope / (power (1 - shown)) */

/* x: a channel. */
SHADE_FN float shade_piecewise_curve(float x)
{
	float toe =
		SHADE_PIECEWISE_TOE_SHOWN * pow(min(x, SHADE_PIECEWISE_TOE) / SHADE_PIECEWISE_TOE, SHADE_PIECEWISE_TOE_POWER);
	float line = SHADE_PIECEWISE_TOE_SHOWN + SHADE_PIECEWISE_SLOPE * (x - SHADE_PIECEWISE_TOE);
	float above = 1.0f + SHADE_PIECEWISE_SHOULDER_SCALE * max(x - SHADE_PIECEWISE_SHOULDER, 0.0f);
	float shoulder = 1.0f - (1.0f - SHADE_PIECEWISE_SHOULDER_SHOWN) * pow(above, -SHADE_PIECEWISE_SHOULDER_POWER);
	return select(x < SHADE_PIECEWISE_TOE, toe, select(x < SHADE_PIECEWISE_SHOULDER, line, shoulder));
}

/* The inverse, y in [0, 1). Near 1 a float step stands for (0.4825 / (1 - y))^(5/3) / 1.25 steps of x. */
SHADE_FN float shade_piecewise_curve_inverse(float y)
{
	float toe = SHADE_PIECEWISE_TOE *
	            pow(min(y, SHADE_PIECEWISE_TOE_SHOWN) / SHADE_PIECEWISE_TOE_SHOWN, 1.0f / SHADE_PIECEWISE_TOE_POWER);
	float line = SHADE_PIECEWISE_TOE + (y - SHADE_PIECEWISE_TOE_SHOWN) / SHADE_PIECEWISE_SLOPE;
	float left = max(1.0f - y, SHADE_TONEMAP_EPSILON) / (1.0f - SHADE_PIECEWISE_SHOULDER_SHOWN);
	float above = pow(min(left, 1.0f), -1.0f / SHADE_PIECEWISE_SHOULDER_POWER) - 1.0f;
	float shoulder = SHADE_PIECEWISE_SHOULDER + above / SHADE_PIECEWISE_SHOULDER_SCALE;
	return select(y < SHADE_PIECEWISE_TOE_SHOWN, toe, select(y < SHADE_PIECEWISE_SHOULDER_SHOWN, line, shoulder));
}

SHADE_FN vec3 shade_piecewise(vec3 color)
{
	return vec3(shade_piecewise_curve(color[0]), shade_piecewise_curve(color[1]), shade_piecewise_curve(color[2]));
}

SHADE_FN vec3 shade_piecewise_inverse(vec3 color)
{
	return vec3(shade_piecewise_curve_inverse(color[0]), shade_piecewise_curve_inverse(color[1]),
	            shade_piecewise_curve_inverse(color[2]));
}

/* ---- Hable's ----------------------------------------------------------------------------------------------------- */

#define SHADE_HABLE_BRIGHTER 2.0f
#define SHADE_HABLE_WHITE 0.7251294f /* what the curve without it gives at its white point, 11.2 */

/* ((x (0.15 x + 0.05) + 0.004) / (x (0.15 x + 0.5) + 0.06) - 0.02 / 0.3) / white of twice the channel, at most 1; the
 * difference as one fraction, which is 0 at 0. x: a channel. */
SHADE_FN float shade_hable_curve(float x)
{
	x = SHADE_HABLE_BRIGHTER * min(x, SHADE_FILMIC_MAX);
	float curve = x * (0.14f * x + 0.05f / 3.0f) / (x * (0.15f * x + 0.5f) + 0.06f);
	return min(curve / SHADE_HABLE_WHITE, 1.0f);
}

/* The inverse; 1 gives 5.6. y: [0, 1]. */
SHADE_FN float shade_hable_curve_inverse(float y)
{
	float curve = SHADE_HABLE_WHITE * y, p = 0.05f / 3.0f - 0.5f * curve, a = 0.14f - 0.15f * curve;
	return 0.12f * curve / max(p + sqrt(p * p + 0.24f * curve * a), SHADE_FILMIC_EPSILON) / SHADE_HABLE_BRIGHTER;
}

SHADE_FN vec3 shade_hable(vec3 color)
{
	return vec3(shade_hable_curve(color[0]), shade_hable_curve(color[1]), shade_hable_curve(color[2]));
}

SHADE_FN vec3 shade_hable_inverse(vec3 color)
{
	return vec3(shade_hable_curve_inverse(color[0]), shade_hable_curve_inverse(color[1]),
	            shade_hable_curve_inverse(color[2]));
}

/* ---- by number -------------------------------------------------------------------------------------------------- */

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
	if (tone == SHADE_TONE_LUMINANCE)
		return shade_shown_by_luminance(color);
	if (tone == SHADE_TONE_PIECEWISE)
		return shade_piecewise(color);
	if (tone == SHADE_TONE_HABLE)
		return shade_hable(color);
	return shade_tonemap(color, SHADE_TONEMAP_A, SHADE_TONEMAP_B);
}

/* color: a result of shade_tone with its largest channel below 1; LUMINANCE: its luminance. */
SHADE_FN vec3 shade_tone_inverse(int tone, vec3 color)
{
	if (tone == SHADE_TONE_NONE)
		return color;
	if (tone == SHADE_TONE_NEUTRAL)
		return shade_neutral_inverse(color);
	if (tone == SHADE_TONE_FILMIC)
		return shade_filmic_inverse(color);
	if (tone == SHADE_TONE_LUMINANCE)
		return shade_shown_by_luminance_inverse(color);
	if (tone == SHADE_TONE_PIECEWISE)
		return shade_piecewise_inverse(color);
	if (tone == SHADE_TONE_HABLE)
		return shade_hable_inverse(color);
	return shade_tonemap_inverse(color, SHADE_TONEMAP_A, SHADE_TONEMAP_B);
}

#include "glsl_end.h"
#endif
