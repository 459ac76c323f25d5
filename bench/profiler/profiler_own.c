/* Stilb's profiler in the suite `profiler`: loops of zones, and frame marks. */
#include "bench/profiler/profiler_own.h"
#include "profiler/prof.h"
#include "profiler/prof_snapshot.h"

#define PROFILER_SCOPE PROFILE("empty")
#include "bench/profiler/profiler_run.h"

static void thread_start(const char *name)
{
	if (stilb_prof_thread_begin(name) != 0)
		bench_child_fail("no memory for a ring");
}

static void record(int on)
{
	stilb_prof_record_set(on != 0);
}

static uint64_t recorded(void)
{
	stilb_prof_snapshot snapshot = {0};
	if (stilb_prof_snapshot_take(&snapshot, NULL) != 0)
		bench_child_fail("no memory for a snapshot");
	uint64_t events = snapshot.events_recorded;
	stilb_prof_snapshot_finish(&snapshot);
	return events;
}

static void loop_next(uint32_t count)
{
	PROFILE_BEGIN("first");
	for (uint32_t i = 1; i < count; i++) {
		PROFILE_NEXT("next");
		__asm__ volatile("" ::: "memory");
	}
	PROFILE_END();
}

static void loop_precise(uint32_t count)
{
	for (uint32_t i = 0; i < count; i++) {
		PROFILE_PRECISE("precise");
		__asm__ volatile("" ::: "memory");
	}
}

static int run_frame(const bench_child *child)
{
	uint64_t begin = bench_child_now_ns(), end = begin + (uint64_t)(child->seconds * 1e9), now = begin, marks = 0;
	for (; now < end; now = bench_child_now_ns())
		for (int i = 0; i < 1000; i++, marks++)
			stilb_prof_frame_mark();
	bench_child_metric("mark", (double)(now - begin) / (double)marks);
	return 0;
}

static int special(profiler_kind kind, const bench_child *child)
{
	return kind == PROFILER_FRAME      ? run_frame(child)
	       : kind == PROFILER_CAPTURE  ? profiler_own_capture()
	       : kind == PROFILER_FILE     ? profiler_own_file()
	       : kind == PROFILER_LIVE     ? profiler_own_live(child->seconds)
	       : kind == PROFILER_SWITCHES ? profiler_own_switches(child->seconds)
	                                   : BENCH_CHILD_SKIP;
}

static const profiler_subject subject = {
	.name = "stilb",
	.zones = profiler_loop_zones,
	.next = loop_next,
	.precise = loop_precise,
	.work = profiler_loop_work,
	.thread_start = thread_start,
	.thread_stop = stilb_prof_thread_end,
	.record = record,
	.recorded = recorded,
	.special = special,
};

const profiler_subject *const profiler_subjects[] = {&subject, NULL};
