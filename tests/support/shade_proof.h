/*
 * shade_proof: what the proofs of the shading headers share: random arguments, comparisons that name what differs, and
 * the rule of two groups. Truth comes from closed forms written anew in double, or from numeric/numeric_quadrature.h.
 *
 * Two groups. A test program has the group `exactness`, which is fast (well below 0.3 s) and fails if any constant of
 *             the header changes by 0.1 %, and the group `properties`, which runs many random arguments; main ends with
 *             return SHADE_PROOF_RUN(exactness, properties). With STILB_SHADE_QUICK=1 in the environment only the first
 *             one runs: mutation/mutate.sh of tests/shading starts the program for each literal that it comes across,
 *             0.1 % larger and 0.1 % smaller, and it must fail.
 */
#ifndef SHADE_PROOF_H
#define SHADE_PROOF_H

#include "base/base.h"
#include "base/base_math.h"
#include "support/test.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>

/* Random arguments for each function. Where each takes ten times as long, their first ones. */
#define SHADE_PROOF_COUNT (TEST_EMULATED ? 100000 : TEST_ASAN ? 80000 : 1000000)

static inline bool shade_proof_quick(void)
{
	const char *quick = getenv("STILB_SHADE_QUICK");
	return quick && quick[0] == '1';
}

#define SHADE_PROOF_RUN(exactness, properties)                                                                         \
	(cmocka_run_group_tests(exactness, NULL, NULL) +                                                                   \
	 (shade_proof_quick() ? 0 : cmocka_run_group_tests(properties, NULL, NULL)))

/* ---- random arguments ------------------------------------------------------------------------------------------- */

/* A stream of numbers: start it with {.seed = number}. */
typedef struct shade_proof_random {
	uint64_t seed, index;
} shade_proof_random;

/* [0, 1) */
static inline float shade_proof_uniform(shade_proof_random *random)
{
	return stilb_random_float(random->seed, random->index++);
}

/* [low, high) */
static inline float shade_proof_range(shade_proof_random *random, float low, float high)
{
	return low + (high - low) * shade_proof_uniform(random);
}

/* [low, high), every order of magnitude as often as any other; 0 < low < high. */
static inline float shade_proof_log_range(shade_proof_random *random, float low, float high)
{
	return expf(shade_proof_range(random, logf(low), logf(high)));
}

/* A unit vector, every direction as likely as any other. */
static inline stilb_vec3 shade_proof_random_direction(shade_proof_random *random)
{
	float z = shade_proof_range(random, -1.0f, 1.0f), phi = shade_proof_range(random, 0.0f, 6.2831853f);
	float r = sqrtf(1.0f - z * z);
	return stilb_vec3_normalize(stilb_vec3_make(r * cosf(phi), r * sinf(phi), z));
}

/* The same on n's side of its plane. */
static inline stilb_vec3 shade_proof_random_above(shade_proof_random *random, stilb_vec3 n)
{
	stilb_vec3 direction = shade_proof_random_direction(random);
	return stilb_vec3_dot(n, direction) < 0.0f ? -direction : direction;
}

/* Three channels in [0, highest): one in eight colours black, one in eight with equal channels. */
static inline stilb_vec3 shade_proof_random_color(shade_proof_random *random, float highest)
{
	float kind = shade_proof_uniform(random), r = shade_proof_range(random, 0.0f, highest);
	float g = shade_proof_range(random, 0.0f, highest), b = shade_proof_range(random, 0.0f, highest);
	if (kind < 0.125f)
		return stilb_vec3_make(0.0f, 0.0f, 0.0f);
	return kind < 0.25f ? stilb_vec3_make(r, r, r) : stilb_vec3_make(r, g, b);
}

/* Number k of eight for the rows of shade/cases_*.h: every combination of the lowest, the middle and the highest. */
#define SHADE_PROOF_CORNERS 6561 /* 3^8 */

static inline float shade_proof_corner(int corner, int k)
{
	static const float ends[3] = {0.0f, 0.5f, 0.99999994f};
	for (; k > 0; k--)
		corner /= 3;
	return ends[corner % 3];
}

/* ---- comparisons ------------------------------------------------------------------------------------------------ */

/* |got - want| <= max(relative * |want|, absolute); NaN never is. */
static inline void shade_proof_near(const char *file, int line, const char *what, double got, double want,
                                    double relative, double absolute)
{
	if (!(fabs(got - want) <= fmax(relative * fabs(want), absolute)))
		fail_msg("%s:%d: %s is %.9g, not %.9g within %g of it or %g", file, line, what, got, want, relative, absolute);
}

#define SHADE_PROOF_NEAR(got, want, relative, absolute)                                                                \
	shade_proof_near(__FILE__, __LINE__, #got, (double)(got), (double)(want), relative, absolute)

/* The three lanes of a vec3 against three doubles. */
#define SHADE_PROOF_NEAR3(got, x, y, z, relative, absolute)                                                            \
	do {                                                                                                               \
		stilb_vec3 shade_proof_got = (got);                                                                            \
		const double shade_proof_want[3] = {(double)(x), (double)(y), (double)(z)};                                    \
		for (int shade_proof_lane = 0; shade_proof_lane < 3; shade_proof_lane++)                                       \
			shade_proof_near(__FILE__, __LINE__, #got, (double)shade_proof_got[shade_proof_lane],                      \
			                 shade_proof_want[shade_proof_lane], relative, absolute);                                  \
	} while (0)

/* Light: finite and not negative. */
static inline void shade_proof_light(const char *file, int line, const char *what, float light)
{
	if (!(light >= 0.0f && light < INFINITY))
		fail_msg("%s:%d: %s is %g: no light", file, line, what, (double)light);
}

#define SHADE_PROOF_LIGHT(light) shade_proof_light(__FILE__, __LINE__, #light, light)

#define SHADE_PROOF_LIGHT3(color)                                                                                      \
	do {                                                                                                               \
		stilb_vec3 shade_proof_color = (color);                                                                        \
		for (int shade_proof_lane = 0; shade_proof_lane < 3; shade_proof_lane++)                                       \
			shade_proof_light(__FILE__, __LINE__, #color, shade_proof_color[shade_proof_lane]);                        \
	} while (0)

#endif
