/*
 * shade_run: input and output of the three implementations that the suite `shade` compares: the shading headers
 * (shade_own.c), the same formulas fused by hand in plain floats (shade_hand.c), and the headers' functions on eight
 * points at a time (shade_wide.c). All are verified against the formulas in double (shade_exact.c).
 *
 * An evaluation is BRDF x n.l in three channels. Every point has its own normal n, directions l to the light and v to
 * the viewer, roughness and F0 (reflectance at normal incidence). [any-thread]
 */
#ifndef SHADE_RUN_H
#define SHADE_RUN_H

#include "base/base_math.h"
#include "bench/shade/shade_cases.h"

#include <stdint.h>

/* Number of points; they and their results fit into the first-level cache. */
#define SHADE_RUN_COUNT 192

#define SHADE_RUN_WRAP 0.5f
#define SHADE_RUN_ALPHA_MIN 1e-3f

/* A point as a renderer stores it. */
typedef struct shade_run_point {
	stilb_vec4 n, l, v; /* unit; n.l and n.v > 0 */
	stilb_vec4 f0;
	float roughness, unused[3];
} shade_run_point;

/* The same points as an array for each component, from which eight points can be loaded at a time. */
typedef struct shade_run_lanes {
	float n[3][SHADE_RUN_COUNT], l[3][SHADE_RUN_COUNT], v[3][SHADE_RUN_COUNT];
	float f0[3][SHADE_RUN_COUNT];
	float roughness[SHADE_RUN_COUNT];
} shade_run_lanes;

typedef struct shade_run_inputs {
	_Alignas(64) shade_run_point points[SHADE_RUN_COUNT];
	_Alignas(64) shade_run_lanes lanes;
} shade_run_inputs;

typedef struct shade_run_results {
	_Alignas(64) stilb_vec4 points[SHADE_RUN_COUNT];
	_Alignas(64) float lanes[3][SHADE_RUN_COUNT];
} shade_run_results;

/* Evaluates all points once. The wide kernels read and write `lanes`, the others `points`. */
typedef void shade_run_kernel(const shade_run_inputs *inputs, shade_run_results *results);

#define SHADE_RUN_DECLARE(name, title, symbol, divisions, roots, powers)                                               \
	shade_run_kernel shade_own_##symbol, shade_hand_##symbol, shade_wide_##symbol;                                     \
	void shade_exact_##symbol(const shade_run_point *point, double result[3]);
SHADE_BENCH_CASES(SHADE_RUN_DECLARE)

#endif
