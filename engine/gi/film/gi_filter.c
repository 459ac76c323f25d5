#include "gi/film/gi_camera.h"

#include <math.h>

/* Both filters are products of a function of x and one of y, cut off at the edge of a square of this half width,
 * pixels. */
#define RADIUS 1.5f
#define SIGMA 0.5f                  /* standard deviation of the Gaussian, pixels */
#define INSIDE 0.99730020393673979f /* erf(RADIUS / (SIGMA sqrt(2))): the share of the Gaussian inside the cut */
#define ROOT_2 1.41421356237309505f

/* erf(result) = x, |x| < 1. Source: Giles, "Approximating the erfinv function" (2010), single precision. */
static float inverse_erf(float x)
{
	STILB_ASSERT(x > -1.0f && x < 1.0f);
	float w = -logf((1.0f - x) * (1.0f + x));
	if (w < 5.0f) {
		w -= 2.5f;
		float p = 3.43273939e-07f + 2.81022636e-08f * w;
		p = -3.5233877e-06f + p * w;
		p = -4.39150654e-06f + p * w;
		p = 0.00021858087f + p * w;
		p = -0.00125372503f + p * w;
		p = -0.00417768164f + p * w;
		p = 0.246640727f + p * w;
		return (1.50140941f + p * w) * x;
	}
	w = sqrtf(w) - 3.0f;
	float p = 0.000100950558f - 0.000200214257f * w;
	p = 0.00134934322f + p * w;
	p = -0.00367342844f + p * w;
	p = 0.00573950773f + p * w;
	p = -0.0076224613f + p * w;
	p = 0.00943887047f + p * w;
	p = 1.00167406f + p * w;
	return (2.83297682f + p * w) * x;
}

static float clamped(float x, float limit)
{
	return x < -limit ? -limit : x > limit ? limit : x;
}

static float gaussian(float u)
{
	return clamped(SIGMA * ROOT_2 * inverse_erf((2.0f * u - 1.0f) * INSIDE), RADIUS);
}

/* Terms of the window a0 + a1 cos t + a2 cos 2t + a3 cos 3t, t = pi x / radius. Source: Harris, "On the use of windows
 * for harmonic analysis with the discrete Fourier transform" (1978), minimum 4-term. */
static const float a0 = 0.35875f, a1 = 0.48829f, a2 = 0.14128f, a3 = 0.01168f;

#define NEAR_SIGMA 0.768f /* standard deviation, in t, of the Gaussian nearest to the window: gives the first guess */
/* Largest |t| of Newton's first guess: there the window is still well above 0, so that Newton goes outwards from it and
 * does not overshoot. */
#define GUESS_MAX 2.0f
#define NEWTON_STEPS 16  /* at most; usually three */
#define NEWTON_END 1e-6f /* it ends after a step of at most this, in t */

/* The inverse of the window's cumulative distribution: the offset with share u to its left. */
static float blackman_harris(float u)
{
	float pi = (float)M_PI, target = (u - 0.5f) * 2.0f * pi * a0;
	float t = clamped(NEAR_SIGMA * ROOT_2 * inverse_erf((2.0f * u - 1.0f) * INSIDE), GUESS_MAX), step = 1.0f;
	for (int i = 0; i < NEWTON_STEPS && fabsf(step) > NEWTON_END; i++) {
		float s = sinf(t), c = cosf(t);
		float sum = a0 * t + s * (a1 + a2 * c + a3 * (1.0f - s * s * (4.0f / 3.0f)));
		float slope = a0 + a1 * c + a2 * (2.0f * c * c - 1.0f) + a3 * c * (4.0f * c * c - 3.0f);
		step = (sum - target) / slope;
		t = clamped(t - step, pi);
	}
	return t * (RADIUS / pi);
}

stilb_vec2 gi_filter_offset(stilb_gi_filter_kind filter, stilb_vec2 u)
{
	STILB_ASSERT(filter < STILB_GI_FILTER_COUNT);
	STILB_ASSERT(u[0] >= 0.0f && u[0] < 1.0f && u[1] >= 0.0f && u[1] < 1.0f);
	switch (filter) {
	case STILB_GI_FILTER_GAUSSIAN:
		return (stilb_vec2){gaussian(u[0]), gaussian(u[1])};
	case STILB_GI_FILTER_BLACKMAN_HARRIS:
		return (stilb_vec2){blackman_harris(u[0]), blackman_harris(u[1])};
	case STILB_GI_FILTER_BOX:
	case STILB_GI_FILTER_COUNT:
		break;
	}
	return u - 0.5f;
}
