/* References of the suite `profiler`, lower bounds for its zones: two reads of a clock, nothing recorded. */
#include "bench/profiler/profiler_run.h"

static void thread_nothing(const char *name)
{
	(void)name;
}

static void nothing(void)
{
}

#define BARRIER __asm__ volatile("" ::: "memory")

static void loop_rdtsc(uint32_t count)
{
	for (uint32_t i = 0; i < count; i++) {
		bench_child_ticks();
		BARRIER;
		bench_child_ticks();
		BARRIER;
	}
}

static void loop_rdtsc_once(uint32_t count)
{
	for (uint32_t i = 0; i < count; i++) {
		bench_child_ticks();
		BARRIER;
	}
}

static void loop_rdtsc_work(uint32_t count)
{
	for (uint32_t i = 0; i < count; i++) {
		bench_child_ticks();
		BARRIER;
		profiler_work();
		BARRIER;
		bench_child_ticks();
		BARRIER;
	}
}

/* The second read waits for the instructions before it, if the CPU has rdtscp. */
static void loop_rdtscp(uint32_t count)
{
	for (uint32_t i = 0; i < count; i++) {
		bench_child_ticks();
		BARRIER;
#if defined(__x86_64__)
		unsigned processor;
		__builtin_ia32_rdtscp(&processor);
#else
		bench_child_ticks();
#endif
		BARRIER;
	}
}

static void loop_clock_gettime(uint32_t count)
{
	for (uint32_t i = 0; i < count; i++) {
		bench_child_now_ns();
		bench_child_now_ns();
	}
}

static void loop_clock_gettime_work(uint32_t count)
{
	for (uint32_t i = 0; i < count; i++) {
		bench_child_now_ns();
		profiler_work();
		bench_child_now_ns();
	}
}

static const profiler_subject tsc = {
	.name = "rdtsc",
	.zones = loop_rdtsc,
	.next = loop_rdtsc_once,
	.precise = loop_rdtscp,
	.work = loop_rdtsc_work,
	.thread_start = thread_nothing,
	.thread_stop = nothing,
};

static const profiler_subject monotonic = {
	.name = "clock_gettime",
	.zones = loop_clock_gettime,
	.work = loop_clock_gettime_work,
	.thread_start = thread_nothing,
	.thread_stop = nothing,
};

const profiler_subject *const profiler_subjects[] = {&tsc, &monotonic, NULL};
