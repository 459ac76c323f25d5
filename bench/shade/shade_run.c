/* The program of the suite `shade`: three ways to evaluate a BRDF (shade_run.h) are compared with its formula in
 * double, then timed in turns in one process, so that disturbances of the machine cancel in their ratios. */
#include "bench/shade/shade_run.h"

#include "base/base.h"
#include "bench/harness/bench_child.h"

#include <math.h>
#include <string.h>

#define TURNS_MAX 65536u
#define TURN_PASSES 40 /* passes over all points in a turn of one way: tens of us, less than a time slice */
#define WAYS 3

static const struct shade_case {
	const char *name;
	shade_run_kernel *ways[WAYS]; /* own, hand, wide */
	void (*exact)(const shade_run_point *point, double result[3]);
	int divisions, roots, powers;
} cases[] = {
#define CASE(NAME, TITLE, SYMBOL, DIVISIONS, ROOTS, POWERS)                                                            \
	{NAME,  {shade_own_##SYMBOL, shade_hand_##SYMBOL, shade_wide_##SYMBOL}, shade_exact_##SYMBOL, DIVISIONS, ROOTS,    \
	 POWERS},
	SHADE_BENCH_CASES(CASE)
#undef CASE
};

/* The number of ways to measure: 2 on x86-64 CPUs without AVX2, which the wide way needs. */
static uint32_t way_count(void)
{
#ifdef __x86_64__
	return __builtin_cpu_supports("avx2") ? WAYS : WAYS - 1;
#else
	return WAYS;
#endif
}

static const char *const way_names[WAYS] = {"stilb", "hand", "wide"};

static shade_run_inputs inputs;
static shade_run_results results;

/* ---- input ------------------------------------------------------------------------------------------------------- */

static float random_at(uint32_t round, uint32_t i, uint32_t which)
{
	return stilb_random_float(round + 1, (uint64_t)i * 16 + which);
}

static stilb_vec4 random_direction(uint32_t round, uint32_t i, uint32_t which)
{
	float z = 2.0f * random_at(round, i, which) - 1.0f, phi = 6.2831853f * random_at(round, i, which + 1);
	float r = sqrtf(1.0f - z * z);
	return (stilb_vec4){r * cosf(phi), r * sinf(phi), z, 0.0f};
}

static stilb_vec4 unit(stilb_vec4 a)
{
	return a / sqrtf(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
}

/* A random normal, a light less than 72 degrees from it, and a viewer around the mirrored light, spread by roughness;
 * both are above the surface. */
static shade_run_point random_point(uint32_t round, uint32_t i)
{
	shade_run_point p = {.n = random_direction(round, i, 0)};
	p.l = unit(p.n + 0.95f * random_direction(round, i, 2));
	float n_l = p.n[0] * p.l[0] + p.n[1] * p.l[1] + p.n[2] * p.l[2];
	stilb_vec4 mirrored = 2.0f * n_l * p.n - p.l;
	p.roughness = 0.15f + 0.85f * random_at(round, i, 4);
	p.v = unit(mirrored + 0.9f * n_l * p.roughness * random_direction(round, i, 5));
	for (uint32_t c = 0; c < 3; c++)
		p.f0[c] = 0.02f + 0.9f * random_at(round, i, 7 + c);
	return p;
}

static void make_inputs(uint32_t round)
{
	for (uint32_t i = 0; i < SHADE_RUN_COUNT; i++) {
		shade_run_point p = random_point(round, i);
		inputs.points[i] = p;
		inputs.lanes.roughness[i] = p.roughness;
		for (int c = 0; c < 3; c++) {
			inputs.lanes.n[c][i] = p.n[c];
			inputs.lanes.l[c][i] = p.l[c];
			inputs.lanes.v[c][i] = p.v[c];
			inputs.lanes.f0[c][i] = p.f0[c];
		}
	}
}

/* ---- verification ------------------------------------------------------------------------------------------------ */

/* The largest relative error of a way over all points; NaN if a result is NaN. */
static double error_of(const struct shade_case *on, uint32_t way)
{
	bool wide = way == 2;
	double worst = 0.0;
	memset(&results, 0xff, sizeof results); /* NaN */
	on->ways[way](&inputs, &results);
	for (int i = 0; i < SHADE_RUN_COUNT; i++) {
		double exact[3];
		on->exact(&inputs.points[i], exact);
		for (int c = 0; c < 3; c++) {
			double got = (double)(wide ? results.lanes[c][i] : results.points[i][c]);
			double error = fabs(got - exact[c]) / fmax(exact[c], 1e-6);
			if (isnan(error))
				return error;
			worst = fmax(worst, error);
		}
	}
	return worst;
}

/* Ends the program if a way's error is too large. The bound is larger for formulas with powers: an exponent of up to
 * 4,000 multiplies the relative error of its base. */
static void check(const struct shade_case *on)
{
	double limit = on->powers ? 5e-3 : 2e-5;
	for (uint32_t way = 0; way < way_count(); way++) {
		double error = error_of(on, way);
		if (!(error <= limit))
			bench_child_fail("wrong result: %s of %s is %g off, relatively; at most %g", way_names[way], on->name,
			                 error, limit);
	}
}

/* ---- time -------------------------------------------------------------------------------------------------------- */

static struct {
	uint32_t count;
	double ns[WAYS][TURNS_MAX], of_hand[TURNS_MAX], of_wide[TURNS_MAX];
} turns;

static int order(const void *a, const void *b)
{
	double x = *(const double *)a, y = *(const double *)b;
	return (x > y) - (x < y);
}

static double median(double *values, uint32_t count)
{
	qsort(values, count, sizeof *values, order);
	return 0.5 * (values[count / 2] + values[(count - 1) / 2]);
}

static double time_kernel(shade_run_kernel *kernel)
{
	uint64_t begin = bench_child_now_ns();
	for (int pass = 0; pass < TURN_PASSES; pass++) {
		kernel(&inputs, &results);
		__asm__ volatile("" ::: "memory");
	}
	return (double)(bench_child_now_ns() - begin) / (TURN_PASSES * SHADE_RUN_COUNT);
}

static void run_turns(const struct shade_case *on, double seconds)
{
	uint32_t ways = way_count();
	uint64_t end = bench_child_now_ns() + (uint64_t)(seconds * 1e9);
	while (turns.count < TURNS_MAX && (turns.count < 8 || bench_child_now_ns() < end)) {
		uint32_t turn = turns.count++;
		for (uint32_t k = 0; k < ways; k++) {
			uint32_t way = (k + turn) % ways;
			turns.ns[way][turn] = time_kernel(on->ways[way]);
		}
		turns.of_hand[turn] = turns.ns[0][turn] / turns.ns[1][turn];
		turns.of_wide[turn] = turns.ns[0][turn] / turns.ns[2][turn];
	}
}

/* ---- the machine's limit ----------------------------------------------------------------------------------------- */

/* Divides for each point; the divisions are independent, so their throughput is measured, not their latency. The next
 * functions do the same for other operations. */
static void limit_division(const shade_run_inputs *in, shade_run_results *out)
{
	for (int i = 0; i < SHADE_RUN_COUNT; i++) {
		float x = 1.0f / in->lanes.roughness[i];
		__asm__ volatile("" : "+x"(x)); /* keeps the compiler from vectorizing */
		out->lanes[0][i] = x;
	}
}

static void limit_root(const shade_run_inputs *in, shade_run_results *out)
{
	for (int i = 0; i < SHADE_RUN_COUNT; i++) {
		float x = sqrtf(in->lanes.roughness[i]);
		__asm__ volatile("" : "+x"(x));
		out->lanes[0][i] = x;
	}
}

static void limit_power(const shade_run_inputs *in, shade_run_results *out)
{
	for (int i = 0; i < SHADE_RUN_COUNT; i++)
		out->lanes[0][i] = powf(in->lanes.roughness[i], in->lanes.f0[0][i]);
}

/* The time that the divisions, roots and powers of one evaluation take by themselves, ns. */
static double limit_of(const struct shade_case *on)
{
	static double ns[3][64];
	for (int turn = 0; turn < 64; turn++) {
		ns[0][turn] = time_kernel(limit_division);
		ns[1][turn] = time_kernel(limit_root);
		ns[2][turn] = time_kernel(limit_power);
	}
	return on->divisions * median(ns[0], 64) + on->roots * median(ns[1], 64) + on->powers * median(ns[2], 64);
}

int main(int argc, char **argv)
{
	bench_child child = bench_child_args(argc, argv);
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		const struct shade_case *on = &cases[i];
		if (strcmp(child.case_name, on->name) != 0)
			continue;
		make_inputs(child.round);
		check(on);
		double error = error_of(on, 0), hand_error = error_of(on, 1);
		run_turns(on, child.seconds);
		bench_child_metric("scalar", median(turns.ns[0], turns.count));
		bench_child_metric("hand", median(turns.ns[1], turns.count));
		bench_child_metric("of-hand", median(turns.of_hand, turns.count));
		if (way_count() == WAYS) {
			bench_child_metric("wide", median(turns.ns[2], turns.count));
			bench_child_metric("of-wide", median(turns.of_wide, turns.count));
		}
		bench_child_metric("limit", limit_of(on));
		bench_child_metric("error", 1e6 * error);
		bench_child_metric("hand-error", 1e6 * hand_error);
		return 0;
	}
	return BENCH_CHILD_SKIP;
}
