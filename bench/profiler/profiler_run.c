/* main of the programs of the suite `profiler`: runs one case (profiler_cases.h) with one subject (a profiler), checks
 * that every zone was recorded, prints the metrics. */
#include "bench/profiler/profiler_run.h"

#include <pthread.h>
#include <stdatomic.h>
#include <string.h>

#define TURNS_MAX 65536u
#define WORST_ZONES 10000000u

uint64_t profiler_work_value = 1;

/* ---- loops without a zone ---------------------------------------------------------------------------------------- */

static void loop_nothing(uint32_t count)
{
	for (uint32_t i = 0; i < count; i++)
		__asm__ volatile("" ::: "memory");
}

/* Two reads of the clock: the lower bound for a zone that records two times. */
static void loop_clock_pair(uint32_t count)
{
	for (uint32_t i = 0; i < count; i++) {
		bench_child_ticks();
		__asm__ volatile("" ::: "memory");
		bench_child_ticks();
		__asm__ volatile("" ::: "memory");
	}
}

static void loop_work(uint32_t count)
{
	for (uint32_t i = 0; i < count; i++)
		profiler_work();
}

/* ---- turns ------------------------------------------------------------------------------------------------------- */

/* Times of two loops that take turns, ns for each pass through the body: those of the loops, second / first, and
 * second - first. */
typedef struct turns {
	uint32_t count;
	double first[TURNS_MAX], second[TURNS_MAX], ratio[TURNS_MAX], difference[TURNS_MAX];
} turns;

static turns samples;

static int order(const void *a, const void *b)
{
	double x = *(const double *)a, y = *(const double *)b;
	return (x > y) - (x < y);
}

static double median(double *values)
{
	qsort(values, samples.count, sizeof *values, order);
	return 0.5 * (values[samples.count / 2] + values[(samples.count - 1) / 2]);
}

static double time_loop(profiler_loop *loop)
{
	uint64_t begin = bench_child_now_ns();
	loop(PROFILER_TURN);
	return (double)(bench_child_now_ns() - begin) / PROFILER_TURN;
}

static void turns_add(double first, double second)
{
	uint32_t i = samples.count++;
	samples.first[i] = first;
	samples.second[i] = second;
	samples.ratio[i] = second / first;
	samples.difference[i] = second - first;
}

/* Runs the two loops in turns for so many seconds and adds their times to samples. Returns the number of zones that the
 * second loop has recorded. */
static uint64_t turns_run(const profiler_subject *subject, profiler_loop *first, profiler_loop *second, double seconds)
{
	uint64_t end = bench_child_now_ns() + (uint64_t)(seconds * 1e9);
	second(PROFILER_TURN); /* not measured, since it takes the page faults */
	uint64_t zones = PROFILER_TURN;
	while (samples.count < TURNS_MAX && (samples.count < 8 || bench_child_now_ns() < end)) {
		if (subject->frame)
			subject->frame();
		double a = time_loop(first);
		turns_add(a, time_loop(second));
		zones += PROFILER_TURN;
	}
	return zones;
}

static void check_recorded(const profiler_subject *subject, uint64_t before, uint64_t zones)
{
	if (!subject->recorded)
		return;
	uint64_t seen = subject->recorded() - before;
	if (seen != zones)
		bench_child_fail("wrong result: %llu zones recorded, not %llu", (unsigned long long)seen,
		                 (unsigned long long)zones);
}

static void run_ratio(const profiler_subject *subject, profiler_loop *loop, double seconds)
{
	uint64_t before = subject->recorded ? subject->recorded() : 0;
	check_recorded(subject, before, turns_run(subject, loop_clock_pair, loop, seconds));
	bench_child_metric("pair", median(samples.first));
	bench_child_metric("zone", median(samples.second));
	bench_child_metric("of-pair", median(samples.ratio));
}

static void run_work(const profiler_subject *subject, double seconds)
{
	turns_run(subject, loop_work, subject->work, seconds);
	bench_child_metric("without", median(samples.first));
	bench_child_metric("with", median(samples.second));
	bench_child_metric("added", median(samples.difference));
}

static void run_off(const profiler_subject *subject, double seconds)
{
	subject->record(0);
	uint64_t before = subject->recorded ? subject->recorded() : 0;
	turns_run(subject, loop_nothing, subject->zones, seconds);
	check_recorded(subject, before, 0);
	bench_child_metric("without", median(samples.first));
	bench_child_metric("with", median(samples.second));
	bench_child_metric("added", median(samples.difference));
}

/* ---- two threads ------------------------------------------------------------------------------------------------- */

static struct {
	const profiler_subject *subject;
	pthread_barrier_t barrier;
	_Atomic int stop; /* relaxed: the barrier publishes it */
	double ns;        /* time of a zone in the second thread's turn; the barrier publishes it */
} two;

static void *two_second(void *unused)
{
	(void)unused;
	bench_child_pin(1);
	two.subject->thread_start("second");
	for (;;) {
		pthread_barrier_wait(&two.barrier);
		if (atomic_load_explicit(&two.stop, memory_order_relaxed))
			break;
		two.ns = time_loop(two.subject->zones);
		pthread_barrier_wait(&two.barrier);
	}
	two.subject->thread_stop();
	return NULL;
}

static void *two_first(void *argument)
{
	double seconds = *(const double *)argument;
	bench_child_pin(0);
	two.subject->thread_start("first");
	uint64_t end = bench_child_now_ns() + (uint64_t)(seconds * 1e9);
	two.subject->zones(PROFILER_TURN);
	while (samples.count < TURNS_MAX && (samples.count < 8 || bench_child_now_ns() < end)) {
		if (two.subject->frame)
			two.subject->frame();
		double alone = time_loop(two.subject->zones);
		if (two.subject->frame)
			two.subject->frame();
		pthread_barrier_wait(&two.barrier);
		double here = time_loop(two.subject->zones);
		pthread_barrier_wait(&two.barrier);
		turns_add(alone, 0.5 * (here + two.ns));
	}
	atomic_store_explicit(&two.stop, 1, memory_order_relaxed);
	pthread_barrier_wait(&two.barrier);
	two.subject->thread_stop();
	return NULL;
}

static int run_two(const profiler_subject *subject, double seconds)
{
	pthread_t threads[2];
	if (bench_child_cpu_count() < 2) {
		fprintf(stderr, "two threads at once need two CPUs\n");
		return BENCH_CHILD_SKIP;
	}
	two.subject = subject;
	pthread_barrier_init(&two.barrier, NULL, 2);
	if (pthread_create(&threads[0], NULL, two_first, &seconds) != 0 ||
	    pthread_create(&threads[1], NULL, two_second, NULL) != 0)
		bench_child_fail("cannot start two threads");
	pthread_join(threads[0], NULL);
	pthread_join(threads[1], NULL);
	bench_child_metric("one", median(samples.first));
	bench_child_metric("two", median(samples.second));
	bench_child_metric("of-one", median(samples.ratio));
	return 0;
}

/* ---- the slowest zone -------------------------------------------------------------------------------------------- */

/* Measures each zone in ticks, with one read of the clock between two zones. */
static void worst_fill(const profiler_subject *subject, uint32_t *ticks)
{
	uint64_t last = bench_child_ticks();
	for (uint32_t i = 0; i < WORST_ZONES; i++) {
		subject->zones(1);
		uint64_t now = bench_child_ticks(), passed = now - last;
		ticks[i] = passed < UINT32_MAX ? (uint32_t)passed : UINT32_MAX;
		last = now;
		if (subject->frame && i % PROFILER_TURN == PROFILER_TURN - 1) {
			subject->frame();
			last = bench_child_ticks();
		}
	}
}

static int order_ticks(const void *a, const void *b)
{
	uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
	return (x > y) - (x < y);
}

static double ns_per_tick(void)
{
	uint64_t ns = bench_child_now_ns(), ticks = bench_child_ticks();
	while (bench_child_now_ns() - ns < 20000000)
		;
	return (double)(bench_child_now_ns() - ns) / (double)(bench_child_ticks() - ticks);
}

static void run_worst(const profiler_subject *subject)
{
	uint32_t *ticks = malloc(WORST_ZONES * sizeof *ticks);
	if (!ticks)
		bench_child_fail("out of memory");
	memset(ticks, 1, WORST_ZONES * sizeof *ticks); /* page faults happen now, not while zones are timed */
	double scale = ns_per_tick();
	worst_fill(subject, ticks);
	qsort(ticks, WORST_ZONES, sizeof *ticks, order_ticks);
	bench_child_metric("p50", ticks[WORST_ZONES / 2] * scale);
	bench_child_metric("p99.99", ticks[WORST_ZONES - WORST_ZONES / 10000] * scale);
	bench_child_metric("p99.999", ticks[WORST_ZONES - WORST_ZONES / 100000] * scale);
	bench_child_metric("worst", ticks[WORST_ZONES - 1] * scale);
	free(ticks);
}

/* ---- the program ------------------------------------------------------------------------------------------------- */

static profiler_kind find_case(const char *name)
{
	static const char *const names[] = {
#define CASE(NAME, TITLE, KIND) [PROFILER_##KIND] = NAME,
		PROFILER_CASES(CASE)
#undef CASE
	};
	for (size_t i = 0; i < sizeof names / sizeof *names; i++)
		if (strcmp(names[i], name) == 0)
			return (profiler_kind)i;
	bench_child_fail("no case %s", name);
}

static int run_loop(const profiler_subject *subject, profiler_loop *loop, double seconds)
{
	if (!loop)
		return BENCH_CHILD_SKIP;
	subject->thread_start("main");
	run_ratio(subject, loop, seconds);
	subject->thread_stop();
	return 0;
}

static int run_on_main(const profiler_subject *subject, void (*run)(const profiler_subject *, double), double seconds)
{
	subject->thread_start("main");
	run(subject, seconds);
	subject->thread_stop();
	return 0;
}

int main(int argc, char **argv)
{
	bench_child child = bench_child_args(argc, argv);
	profiler_kind kind = find_case(child.case_name);
	const profiler_subject *const *at = profiler_subjects;
	while (*at && strcmp((*at)->name, child.subject) != 0)
		at++;
	const profiler_subject *subject = *at;
	if (!subject)
		bench_child_fail("no subject %s", child.subject);
	switch (kind) {
	case PROFILER_ZONE:
		return run_loop(subject, subject->zones, child.seconds);
	case PROFILER_NEXT:
		return run_loop(subject, subject->next, child.seconds);
	case PROFILER_PRECISE:
		return run_loop(subject, subject->precise, child.seconds);
	case PROFILER_WORK:
		return subject->work ? run_on_main(subject, run_work, child.seconds) : BENCH_CHILD_SKIP;
	case PROFILER_OFF:
		return subject->record ? run_on_main(subject, run_off, child.seconds) : BENCH_CHILD_SKIP;
	case PROFILER_TWO:
		return run_two(subject, child.seconds);
	case PROFILER_WORST:
		subject->thread_start("main");
		run_worst(subject);
		subject->thread_stop();
		return 0;
	default:
		return subject->special ? subject->special(kind, &child) : BENCH_CHILD_SKIP;
	}
}
