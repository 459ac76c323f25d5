/* Comparisons: the Mann-Whitney test against published values and all permutations, verdicts, matching, errors. */
#include "profiler/prof_diff.h"

#include "support/failing_memory.h"
#include "support/prof_made.h"
#include "support/test.h"

#include <errno.h>
#include <math.h>
#include <stddef.h>

/* ---- Mann-Whitney ------------------------------------------------------------------------------------------------ */

#define P(a, b) stilb_prof_mann_whitney(a, sizeof a / sizeof *a, b, sizeof b / sizeof *b)

static void assert_near(double value, double expected, double tolerance)
{
	if (!(fabs(value - expected) <= tolerance))
		fail_msg("%.12g is not %.12g", value, expected);
}

/* Ages at a diagnosis of diabetes, an example in the documentation of SciPy's mannwhitneyu: U = 17, p = 1/9. */
static void published_example(void **state)
{
	(void)state;
	static const uint64_t males[] = {16, 19, 22, 24, 29}, females[] = {11, 12, 17, 20};
	assert_near(P(males, females), 1.0 / 9.0, 1e-12);
	assert_near(P(females, males), 1.0 / 9.0, 1e-12);
}

static void trivial_samples(void **state)
{
	(void)state;
	static const uint64_t one[] = {5}, two[] = {9}, same[] = {5, 5, 5, 5}, low[] = {1, 2, 3}, high[] = {4, 5, 6};
	assert_near(P(one, one), 1.0, 1e-12);
	assert_near(P(one, two), 1.0, 1e-12);
	assert_near(P(same, same), 1.0, 1e-12);
	assert_near(P(low, high), 0.1, 1e-12); /* 2 of 20 ways */
	assert_near(stilb_prof_mann_whitney(one, 1, NULL, 0), 1.0, 0.0);
	assert_near(stilb_prof_mann_whitney(NULL, 0, NULL, 0), 1.0, 0.0);
}

/* Twice U, counted pair by pair. */
static int twice_u(const uint64_t *values, uint64_t chosen, int count)
{
	int u = 0;
	for (int i = 0; i < count; i++)
		for (int j = 0; j < count; j++)
			if ((chosen >> i & 1) != 0 && (chosen >> j & 1) == 0)
				u += values[i] > values[j] ? 2 : values[i] == values[j] ? 1 : 0;
	return u;
}

/* The exact p, by trying all ways to choose the first sample from the values of both. */
static double permutation_p(const uint64_t *values, int a_count, int count)
{
	int observed = abs(twice_u(values, (1u << a_count) - 1, count) - a_count * (count - a_count));
	double far = 0.0, all = 0.0;
	for (uint32_t chosen = 0; chosen < 1u << count; chosen++)
		if (__builtin_popcount(chosen) == a_count) {
			all += 1.0;
			far += abs(twice_u(values, chosen, count) - a_count * (count - a_count)) >= observed ? 1.0 : 0.0;
		}
	return far / all;
}

static int compare_u64(const void *a, const void *b)
{
	uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
	return (x > y) - (x < y);
}

static void small_samples_are_exact(void **state)
{
	(void)state;
	made_random random = {.state = 1};
	for (int round = 0; round < 300; round++) {
		uint64_t values[10];
		int count = 2 + (int)made_below(&random, 9), a_count = 1 + (int)made_below(&random, (uint64_t)count - 1);
		uint64_t range = round % 3 == 0 ? 3 : round % 3 == 1 ? 8 : 1u << 30; /* many ties, some, none */
		for (int i = 0; i < count; i++)
			values[i] = made_below(&random, range);
		qsort(values, (size_t)a_count, sizeof *values, compare_u64);
		qsort(values + a_count, (size_t)(count - a_count), sizeof *values, compare_u64);
		assert_near(stilb_prof_mann_whitney(values, (size_t)a_count, values + a_count, (size_t)(count - a_count)),
		            permutation_p(values, a_count, count), 1e-12);
	}
}

/* For sizes above the exact ones: close to the p of 20,000 random ways to deal out the values. */
static void large_samples_agree(void **state)
{
	(void)state;
	enum { A = 25, COUNT = 55 };
	made_random random = {.state = 2};
	for (int round = 0; round < 6; round++) {
		uint64_t values[COUNT];
		uint64_t range = round % 2 ? 1000 : 12, shift = made_below(&random, range / 3 + 1);
		for (int i = 0; i < COUNT; i++)
			values[i] = (i < A ? shift : 0) + made_below(&random, range);
		qsort(values, A, sizeof *values, compare_u64);
		qsort(values + A, COUNT - A, sizeof *values, compare_u64);
		double p = stilb_prof_mann_whitney(values, A, values + A, COUNT - A);
		int observed = abs(twice_u(values, (UINT64_C(1) << A) - 1, COUNT) - A * (COUNT - A));
		int far = 0;
		for (int way = 0; way < 20000; way++) {
			uint64_t chosen = 0;
			for (int left = A; left > 0;) {
				uint64_t bit = UINT64_C(1) << made_below(&random, COUNT);
				left -= (chosen & bit) == 0;
				chosen |= bit;
			}
			far += abs(twice_u(values, chosen, COUNT) - A * (COUNT - A)) >= observed;
		}
		assert_near(p, far / 20000.0, 0.02);
	}
}

/* The formula as books print it, U counted pair by pair and ties value by value. */
static double book_p(const uint64_t *a, int a_count, const uint64_t *b, int b_count)
{
	double u = 0.0, ties = 0.0;
	for (int i = 0; i < a_count; i++)
		for (int j = 0; j < b_count; j++)
			u += a[i] > b[j] ? 1.0 : a[i] == b[j] ? 0.5 : 0.0;
	for (uint64_t value = 0; value < 100; value++) {
		double t = 0.0;
		for (int i = 0; i < a_count; i++)
			t += a[i] == value;
		for (int j = 0; j < b_count; j++)
			t += b[j] == value;
		ties += t * t * t - t;
	}
	double n = a_count + b_count, mean = 0.5 * a_count * b_count;
	double sigma = sqrt(a_count * b_count / 12.0 * ((n + 1.0) - ties / (n * (n - 1.0))));
	double z = (fabs(u - mean) - 0.5) / sigma;
	return z > 0.0 ? 2.0 * 0.5 * erfc(z / sqrt(2.0)) : 1.0;
}

static void large_samples_follow_the_formula(void **state)
{
	(void)state;
	made_random random = {.state = 5};
	for (int round = 0; round < 100; round++) {
		uint64_t a[40], b[30];
		uint64_t range = round % 2 ? 80 : 5, shift = made_below(&random, range / 4 + 1);
		for (int i = 0; i < 40; i++)
			a[i] = made_below(&random, range);
		for (int i = 0; i < 30; i++)
			b[i] = shift + made_below(&random, range);
		qsort(a, 40, sizeof *a, compare_u64);
		qsort(b, 30, sizeof *b, compare_u64);
		assert_near(P(a, b), book_p(a, 40, b, 30), 1e-12);
	}
}

/* Equal programs are called different with the probability alpha. */
static void false_alarms_are_rare(void **state)
{
	(void)state;
	made_random random = {.state = 3};
	int alarms = 0;
	for (int round = 0; round < 4000; round++) {
		uint64_t a[60], b[50];
		for (int i = 0; i < 60; i++)
			a[i] = 1000 + made_below(&random, 50) * made_below(&random, 50);
		for (int i = 0; i < 50; i++)
			b[i] = 1000 + made_below(&random, 50) * made_below(&random, 50);
		qsort(a, 60, sizeof *a, compare_u64);
		qsort(b, 50, sizeof *b, compare_u64);
		alarms += P(a, b) < 0.05;
	}
	assert_in_range(alarms, 120, 280); /* 200 expected; six standard deviations are 83 */
}

/* ---- verdicts ---------------------------------------------------------------------------------------------------- */

/* Makes a trace of `frames` frames, each with `calls` zones of label 1 that take about ns nanoseconds each, and one
 * zone of each label in `others`. */
static void make_trace(made *m, uint64_t seed, uint64_t frames, int calls, uint64_t ns, const char *others)
{
	made_random random = {.state = seed};
	made_init(m, 2);
	m->lanes[1].kind = STILB_PROF_LANE_DEVICE;
	m->snapshot.resolution_ns = 10;
	uint64_t at = 1000;
	for (uint64_t f = 0; f < frames; f++) {
		uint64_t begin = at;
		made_push(m, 0, 0, at);
		for (int i = 0; i < calls; i++) {
			uint64_t took = ns - ns / 10 + made_below(&random, ns / 5 + 1);
			made_push(m, 0, 1, at);
			made_pop(m, 0, at += took);
		}
		for (const char *other = others; *other; other++) {
			made_push(m, 0, (uint32_t)(*other - '0'), at);
			made_pop(m, 0, at += 500 + made_below(&random, 20));
		}
		made_push(m, 1, 1, begin); /* the device has a zone of that name too, which never changes */
		made_pop(m, 1, begin + 700 + made_below(&random, 9));
		made_pop(m, 0, at += 100);
		made_frame(m, f, begin, at);
	}
	m->snapshot.end_ns = at;
	made_derive(m);
}

static const stilb_prof_diff_row *find(const stilb_prof_diff *diff, const char *name, stilb_prof_lane_kind kind)
{
	for (uint32_t i = 0; i < diff->row_count; i++)
		if (strcmp(diff->rows[i].name, name) == 0 && diff->rows[i].kind == kind)
			return &diff->rows[i];
	return NULL;
}

static stilb_prof_verdict verdict_of(uint64_t a_ns, uint64_t b_ns, const stilb_prof_diff_desc *desc, int b_calls)
{
	made a, b;
	stilb_prof_diff diff = {0};
	make_trace(&a, 1, 60, 5, a_ns, "23");
	make_trace(&b, 2, 40, b_calls, b_ns, "23");
	assert_int_equal(stilb_prof_diff_make(&diff, &a.snapshot, &b.snapshot, desc), 0);
	assert_true(diff.frames);
	stilb_prof_verdict verdict = find(&diff, "cull", STILB_PROF_LANE_THREAD)->verdict;
	assert_int_equal(find(&diff, "cull", STILB_PROF_LANE_DEVICE)->verdict, STILB_PROF_SAME);
	assert_int_equal(find(&diff, "record", STILB_PROF_LANE_THREAD)->verdict, STILB_PROF_SAME);
	uint32_t slower = 0;
	for (uint32_t i = 0; i < diff.row_count; i++) {
		slower += diff.rows[i].verdict == STILB_PROF_SLOWER;
		assert_true(i == 0 || diff.rows[i - 1].verdict <= diff.rows[i].verdict);
	}
	assert_int_equal(diff.slower, slower);
	stilb_prof_diff_finish(&diff);
	made_finish(&a);
	made_finish(&b);
	return verdict;
}

static void slower_faster_same(void **state)
{
	(void)state;
	stilb_prof_diff_desc desc = stilb_prof_diff_desc_default();
	assert_int_equal(verdict_of(10000, 10000, &desc, 5), STILB_PROF_SAME);
	assert_int_equal(verdict_of(10000, 11000, &desc, 5), STILB_PROF_SLOWER);
	assert_int_equal(verdict_of(11000, 10000, &desc, 5), STILB_PROF_FASTER);
	assert_int_equal(verdict_of(10000, 10300, &desc, 5), STILB_PROF_SAME); /* 3 %, less than the threshold of 5 % */
	desc.threshold = 0.01;
	assert_int_equal(verdict_of(10000, 10300, &desc, 5), STILB_PROF_SLOWER);
	desc.alpha = 0.0;
	assert_int_equal(verdict_of(10000, 20000, &desc, 5), STILB_PROF_SAME); /* no p is below 0 */
	desc = stilb_prof_diff_desc_default();
	assert_int_equal(verdict_of(50, 58, &desc, 5), STILB_PROF_SAME); /* the clock does not resolve it */
	assert_int_equal(verdict_of(50, 70, &desc, 5), STILB_PROF_SLOWER);
}

/* More zones of the same length: only the time per frame shows the difference. */
static void more_calls(void **state)
{
	(void)state;
	stilb_prof_diff_desc desc = stilb_prof_diff_desc_default();
	assert_int_equal(verdict_of(10000, 10000, &desc, 7), STILB_PROF_SAME);
	desc.sample = STILB_PROF_DIFF_PER_FRAME;
	assert_int_equal(verdict_of(10000, 10000, &desc, 7), STILB_PROF_SLOWER);
	assert_int_equal(verdict_of(10000, 10000, &desc, 5), STILB_PROF_SAME);
	assert_int_equal(verdict_of(10000, 10000, &desc, 3), STILB_PROF_FASTER);
}

static void sides_are_told(void **state)
{
	(void)state;
	stilb_prof_diff_desc desc = stilb_prof_diff_desc_default();
	made a, b;
	stilb_prof_diff diff = {0};
	make_trace(&a, 1, 30, 2, 1000, "24");
	make_trace(&b, 2, 20, 3, 2000, "3");
	assert_int_equal(stilb_prof_diff_make(&diff, &a.snapshot, &b.snapshot, &desc), 0);
	const stilb_prof_diff_row *cull = find(&diff, "cull", STILB_PROF_LANE_THREAD);
	assert_int_equal(cull->a.calls, 60);
	assert_int_equal(cull->b.calls, 60);
	assert_in_range(cull->a.p50_ns, 950, 1050);
	assert_in_range(cull->b.p50_ns, 1900, 2100);
	assert_in_range(cull->b.p99_ns, 2150, 2200);
	assert_in_range(cull->a.self_ns, 60 * 900, 60 * 1100);
	assert_int_equal(cull->a.self_ns, cull->a.inclusive_ns);
	assert_near(cull->ratio, (double)cull->b.p50_ns / (double)cull->a.p50_ns, 1e-12);
	assert_true(cull->p < 1e-9);
	const stilb_prof_diff_row *record = find(&diff, "record", STILB_PROF_LANE_THREAD);
	assert_int_equal(record->verdict, STILB_PROF_ONLY_A);
	assert_true(record->ratio == 0.0 && record->p == 1.0 && record->b.calls == 0 && record->a.calls == 30);
	assert_int_equal(find(&diff, "replay", STILB_PROF_LANE_THREAD)->verdict, STILB_PROF_ONLY_B);
	assert_int_equal(find(&diff, "frame", STILB_PROF_LANE_THREAD)->verdict, STILB_PROF_SLOWER);
	assert_int_equal(diff.row_count, 6);
	stilb_prof_diff_finish(&diff);
	made_finish(&a);
	made_finish(&b);
}

/* Each of the zones in both traces is a test, and alpha is for all of them together. */
static void alpha_is_shared(void **state)
{
	(void)state;
	stilb_prof_diff_desc desc = stilb_prof_diff_desc_default();
	made a, b;
	stilb_prof_diff diff = {0};
	make_trace(&a, 1, 30, 2, 1000, "23");
	make_trace(&b, 2, 20, 2, 1200, "23");
	assert_int_equal(stilb_prof_diff_make(&diff, &a.snapshot, &b.snapshot, &desc), 0);
	double p = find(&diff, "cull", STILB_PROF_LANE_THREAD)->p;
	assert_int_equal(diff.row_count, 5);
	desc.alpha = 4.9 * p;
	assert_int_equal(stilb_prof_diff_make(&diff, &a.snapshot, &b.snapshot, &desc), 0);
	assert_int_equal(find(&diff, "cull", STILB_PROF_LANE_THREAD)->verdict, STILB_PROF_SAME);
	desc.alpha = 5.1 * p;
	assert_int_equal(stilb_prof_diff_make(&diff, &a.snapshot, &b.snapshot, &desc), 0);
	assert_int_equal(find(&diff, "cull", STILB_PROF_LANE_THREAD)->verdict, STILB_PROF_SLOWER);
	stilb_prof_diff_finish(&diff);
	made_finish(&a);
	made_finish(&b);
}

/* A zone inside another of its name counts when it is charged to another frame: a job that helped out later. */
static void jobs_of_other_frames(void **state)
{
	(void)state;
	stilb_prof_diff_desc desc = stilb_prof_diff_desc_default();
	desc.sample = STILB_PROF_DIFF_PER_FRAME;
	made a;
	stilb_prof_diff diff = {0};
	made_init(&a, 1);
	made_frame(&a, 0, 0, 1000);
	made_frame(&a, 1, 1000, 2000);
	made_push(&a, 0, 6, 1100); /* job 1100..1900, of frame 1, around one of frame 0 and one of its own */
	made_push(&a, 0, 6, 1200);
	made_pop(&a, 0, 1500);
	made_push(&a, 0, 6, 1600);
	made_pop(&a, 0, 1700);
	made_pop(&a, 0, 1900);
	made_flow(&a, (stilb_prof_flow){.id = 1, .from_ns = 500, .to_ns = 1200, .label = 14, .frame = 0});
	made_derive(&a);
	assert_int_equal(stilb_prof_diff_make(&diff, &a.snapshot, &a.snapshot, &desc), 0);
	const stilb_prof_diff_row *job = find(&diff, "job", STILB_PROF_LANE_THREAD);
	assert_int_equal(job->a.calls, 3);
	assert_int_equal(job->a.p99_ns, 800); /* the time in frame 1 */
	assert_int_equal(job->a.inclusive_ns, 800);
	a.frames[1].end_ns = 3000; /* a third frame, empty: the median is frame 0 */
	made_frame(&a, 2, 3000, 4000);
	assert_int_equal(stilb_prof_diff_make(&diff, &a.snapshot, &a.snapshot, &desc), 0);
	assert_int_equal(find(&diff, "job", STILB_PROF_LANE_THREAD)->a.p50_ns, 300);
	stilb_prof_diff_finish(&diff);
	made_finish(&a);
}

/* Zones before the first whole frame and after the last do not count where both sides have frames. */
static void without_frames_all_count(void **state)
{
	(void)state;
	stilb_prof_diff_desc desc = stilb_prof_diff_desc_default();
	made a, b;
	stilb_prof_diff diff = {0};
	make_trace(&a, 1, 30, 2, 1000, "");
	make_trace(&b, 2, 20, 2, 1000, "");
	a.snapshot.frame_count = 10;
	made_derive(&a);
	assert_int_equal(stilb_prof_diff_make(&diff, &a.snapshot, &b.snapshot, &desc), 0);
	assert_int_equal(find(&diff, "cull", STILB_PROF_LANE_THREAD)->a.calls, 20);
	b.snapshot.frame_count = 0;
	made_derive(&b);
	assert_int_equal(stilb_prof_diff_make(&diff, &a.snapshot, &b.snapshot, &desc), 0);
	assert_false(diff.frames);
	assert_int_equal(find(&diff, "cull", STILB_PROF_LANE_THREAD)->a.calls, 60);
	desc.sample = STILB_PROF_DIFF_PER_FRAME;
	assert_int_equal(stilb_prof_diff_make(&diff, &a.snapshot, &b.snapshot, &desc), -EINVAL);
	assert_int_equal(diff.row_count, 0);
	stilb_prof_diff_finish(&diff);
	made_finish(&a);
	made_finish(&b);
}

static void errors(void **state)
{
	(void)state;
	static const stilb_prof_diff_desc wrong[] = {{0, -0.1, 0.01}, {0, 0.1, -0.1}, {0, 0.1, 1.1}};
	stilb_prof_diff_desc desc = stilb_prof_diff_desc_default();
	stilb_prof_snapshot empty = {0};
	stilb_prof_diff diff = {0};
	made a;
	make_trace(&a, 1, 20, 2, 1000, "23");
	for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
		assert_int_equal(stilb_prof_diff_make(&diff, &a.snapshot, &a.snapshot, &wrong[i]), -EINVAL);
	assert_int_equal(stilb_prof_diff_make(&diff, &empty, &empty, &desc), 0);
	assert_int_equal(diff.row_count, 0);
	desc.sample = STILB_PROF_DIFF_PER_FRAME;
	int failures = 0;
	for (;; failures++) {
		fail_allocation = failures;
		int error = stilb_prof_diff_make(&diff, &a.snapshot, &a.snapshot, &desc);
		bool failed = fail_allocation < 0;
		fail_allocation = -1;
		if (!failed)
			break;
		assert_true(error == -ENOMEM || error == 0); /* the exact test falls back to the approximation */
		assert_int_equal(diff.row_count == 0, error != 0);
	}
	assert_true(failures > 8);
	assert_int_equal(diff.slower, 0);
	stilb_prof_diff_finish(&diff);
	made_finish(&a);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(published_example),
		cmocka_unit_test(trivial_samples),
		cmocka_unit_test(small_samples_are_exact),
		cmocka_unit_test(large_samples_agree),
		cmocka_unit_test(large_samples_follow_the_formula),
		cmocka_unit_test(false_alarms_are_rare),
		cmocka_unit_test(slower_faster_same),
		cmocka_unit_test(more_calls),
		cmocka_unit_test(sides_are_told),
		cmocka_unit_test(alpha_is_shared),
		cmocka_unit_test(jobs_of_other_frames),
		cmocka_unit_test(without_frames_all_count),
		cmocka_unit_test(errors),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
