/* shade_srgb: the transfer between linear light and sRGB codes, per channel. Alpha is linear already. [any-thread] */
#ifndef SHADE_SRGB_H
#define SHADE_SRGB_H

#include "glsl_begin.h"

/* Linear light in [0, 1] to the sRGB code in [0, 1]. Source: IEC 61966-2-1:1999, 5.3. */
SHADE_FN float shade_srgb_from_linear(float light)
{
	return select(light <= 0.0031308f, 12.92f * light, 1.055f * pow(light, 1.0f / 2.4f) - 0.055f);
}

/* The sRGB code in [0, 1] to linear light in [0, 1]. Source: IEC 61966-2-1:1999, 5.2. */
SHADE_FN float shade_srgb_to_linear(float code)
{
	return select(code <= 0.04045f, code / 12.92f, pow((code + 0.055f) / 1.055f, 2.4f));
}

#include "glsl_end.h"
#endif
