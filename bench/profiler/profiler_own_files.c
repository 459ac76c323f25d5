/* Stilb's profiler in the suite `profiler`: captures, trace files, snapshots and context switches. */
#include "bench/harness/bench_child.h"
#include "bench/profiler/profiler_own.h"
#include "profiler/prof.h"
#include "profiler/prof_capture.h"
#include "profiler/prof_read.h"
#include "profiler/prof_snapshot.h"
#include "profiler/prof_trace.h"

#include <errno.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdatomic.h>
#include <string.h>
#include <sys/stat.h>

#define FRAMES 300u
#define ZONES 5000u        /* zones (named spans of code) of each thread in each frame */
#define RING (1u << 21)    /* events that a thread's ring holds: 300 frames, and those recorded during the copy */
#define PERIOD_NS 5000000u /* length of a frame */
#define SAMPLES_MAX 65536u

static void check(int error, const char *what)
{
	if (error != 0)
		bench_child_fail("%s: %s", what, strerror(-error));
}

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

/* Records ZONES zones: groups of ten, of which one encloses the other nine. */
static void record_frame(void)
{
	for (uint32_t i = 0; i < ZONES / 10; i++) {
		PROFILE("ten");
		for (int k = 0; k < 9; k++) {
			PROFILE("one");
			__asm__ volatile("" ::: "memory");
		}
	}
}

/* The path of a file of this process in the folder for temporary files. */
static void temporary_path(char *path, size_t size)
{
	const char *folder = getenv("TMPDIR");
	snprintf(path, size, "%s/stilb-bench-%d.json", folder ? folder : "/tmp", (int)getpid());
}

/* ---- the second thread ------------------------------------------------------------------------------------------- */

static struct {
	pthread_t thread;
	sem_t begin, end;
	_Atomic int stop; /* relaxed: the semaphores publish it */
} second;

static void *second_main(void *unused)
{
	(void)unused;
	check(stilb_prof_thread_begin("second"), "a ring");
	for (;;) {
		sem_wait(&second.begin);
		if (atomic_load_explicit(&second.stop, memory_order_relaxed))
			break;
		record_frame();
		sem_post(&second.end);
	}
	stilb_prof_thread_end();
	return NULL;
}

static void threads_begin(void)
{
	check(stilb_prof_ring_events_set(RING), "a ring");
	check(stilb_prof_thread_begin("main"), "a ring");
	sem_init(&second.begin, 0, 0);
	sem_init(&second.end, 0, 0);
	check(-pthread_create(&second.thread, NULL, second_main, NULL), "a thread");
}

static void threads_end(void)
{
	atomic_store_explicit(&second.stop, 1, memory_order_relaxed);
	sem_post(&second.begin);
	pthread_join(second.thread, NULL);
	stilb_prof_thread_end();
}

/* ---- capture ----------------------------------------------------------------------------------------------------- */

typedef struct frame_times {
	double busy_us; /* recording and the frame mark, without the wait for the second thread */
	double mark_us;
} frame_times;

static frame_times frame_run(uint64_t *due)
{
	struct timespec until = {.tv_sec = (time_t)(*due / 1000000000u), .tv_nsec = (long)(*due % 1000000000u)};
	clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, NULL);
	*due += PERIOD_NS;
	sem_post(&second.begin);
	uint64_t begin = bench_child_now_ns();
	record_frame();
	uint64_t before_mark = bench_child_now_ns();
	stilb_prof_frame_mark();
	uint64_t end = bench_child_now_ns();
	sem_wait(&second.end);
	return (frame_times){(double)(end - begin) * 1e-3, (double)(end - before_mark) * 1e-3};
}

static struct {
	atomic_int done; /* release in on_captured, by the capturing thread; pairs with the acquire in the frame loop */
	int error;
	uint32_t frames;
} captured;

static void on_captured(void *user, const stilb_prof_captured *capture)
{
	(void)user;
	captured.error = capture->error;
	captured.frames = capture->frame_count;
	atomic_store_explicit(&captured.done, 1, memory_order_release);
}

int profiler_own_capture(void)
{
	static double before[FRAMES];
	char path[256];
	temporary_path(path, sizeof path);
	stilb_prof_capture_desc desc = stilb_prof_capture_desc_default();
	desc.path = path;
	desc.frames_before = FRAMES;
	desc.frames_after = 0;
	desc.done = on_captured;
	threads_begin();
	check(stilb_prof_capture_start(&desc), "the capture's thread");
	uint64_t due = bench_child_now_ns();
	double worst_before = 0.0, worst_during = 0.0, mark = 0.0;
	for (uint32_t f = 0; f < FRAMES + 10; f++) {
		frame_times times = frame_run(&due);
		if (f >= 10) /* the first frames warm up */
			before[f - 10] = times.busy_us;
	}
	for (uint32_t f = 0; f < FRAMES; f++)
		worst_before = before[f] > worst_before ? before[f] : worst_before;
	uint64_t begin = bench_child_now_ns();
	check(stilb_prof_capture_now(), "a capture");
	while (!atomic_load_explicit(&captured.done, memory_order_acquire)) {
		frame_times times = frame_run(&due);
		worst_during = times.busy_us > worst_during ? times.busy_us : worst_during;
		mark = times.mark_us > mark ? times.mark_us : mark;
	}
	double seconds = (double)(bench_child_now_ns() - begin) * 1e-9;
	stilb_prof_capture_stop();
	threads_end();
	unlink(path);
	check(captured.error, "the capture");
	if (captured.frames < FRAMES)
		bench_child_fail("wrong result: %u frames captured, not %u", captured.frames, FRAMES);
	double usual = median(before, FRAMES);
	bench_child_metric("frame", usual);
	bench_child_metric("worst-before", worst_before);
	bench_child_metric("worst-during", worst_during);
	bench_child_metric("stall", worst_during - usual);
	bench_child_metric("mark", mark);
	bench_child_metric("captured", seconds * 1e3);
	return 0;
}

/* ---- file -------------------------------------------------------------------------------------------------------- */

static int count_bytes(void *user, const void *data, size_t size)
{
	(void)data;
	*(uint64_t *)user += size;
	return 0;
}

static uint64_t count_zones(const stilb_prof_snapshot *snapshot)
{
	uint64_t zones = 0;
	for (uint32_t lane = 0; lane < snapshot->lane_count; lane++)
		zones += snapshot->lanes[lane].zone_count;
	return zones;
}

static double megabytes_a_second(uint64_t bytes, uint64_t begin)
{
	return (double)bytes * 1e3 / (double)(bench_child_now_ns() - begin);
}

int profiler_own_file(void)
{
	char path[256], error[256];
	temporary_path(path, sizeof path);
	threads_begin();
	for (uint32_t f = 0; f <= FRAMES; f++) {
		stilb_prof_frame_mark();
		sem_post(&second.begin);
		record_frame();
		sem_wait(&second.end);
	}
	threads_end();
	stilb_prof_snapshot taken = {0}, back = {0};
	uint64_t bytes = 0, begin = bench_child_now_ns();
	check(stilb_prof_snapshot_take(&taken, &(stilb_prof_window){.last_frames = FRAMES}), "a snapshot");
	bench_child_metric("snapshot", (double)(bench_child_now_ns() - begin) * 1e-6);
	begin = bench_child_now_ns();
	check(stilb_prof_trace_write_chrome(&taken, "bench", (stilb_prof_sink){count_bytes, &bytes}), "the JSON");
	bench_child_metric("json", megabytes_a_second(bytes, begin));
	begin = bench_child_now_ns();
	check(stilb_prof_trace_save(&taken, "bench", path), path);
	bench_child_metric("file", megabytes_a_second(bytes, begin));
	begin = bench_child_now_ns();
	if (stilb_prof_trace_read(path, &back, error, sizeof error) != 0)
		bench_child_fail("%s", error);
	bench_child_metric("read", megabytes_a_second(bytes, begin));
	unlink(path);
	uint64_t zones = count_zones(&taken), again = count_zones(&back);
	/* At least as many: in the file each frame is a zone, too, in a lane (row of the timeline) for frames. */
	if (zones < UINT64_C(2) * FRAMES * ZONES || again < zones)
		bench_child_fail("wrong result: %llu zones written, %llu read back", (unsigned long long)zones,
		                 (unsigned long long)again);
	bench_child_metric("size", (double)bytes * 1e-6);
	stilb_prof_snapshot_finish(&taken);
	stilb_prof_snapshot_finish(&back);
	return 0;
}

/* ---- live -------------------------------------------------------------------------------------------------------- */

int profiler_own_live(double seconds)
{
	static double us[SAMPLES_MAX];
	uint32_t count = 0;
	stilb_prof_snapshot snapshot = {0};
	check(stilb_prof_ring_events_set(RING), "a ring");
	check(stilb_prof_thread_begin("main"), "a ring");
	for (uint64_t end = bench_child_now_ns() + (uint64_t)(seconds * 1e9), now = 0; now < end && count < SAMPLES_MAX;) {
		stilb_prof_frame_mark();
		for (int i = 0; i < 50; i++) {
			PROFILE("ten");
			for (int k = 0; k < 9; k++) {
				PROFILE("one");
			}
		}
		uint64_t begin = bench_child_now_ns();
		check(stilb_prof_snapshot_take(&snapshot, &(stilb_prof_window){.last_frames = 2}), "a snapshot");
		now = bench_child_now_ns();
		us[count++] = (double)(now - begin) * 1e-3;
	}
	if (count_zones(&snapshot) < 1000)
		bench_child_fail("wrong result: %llu zones in two frames", (unsigned long long)count_zones(&snapshot));
	bench_child_metric("snapshot", median(us, count));
	stilb_prof_snapshot_finish(&snapshot);
	stilb_prof_thread_end();
	return 0;
}

/* ---- switches ---------------------------------------------------------------------------------------------------- */

/* The number of context switches of the calling thread, voluntary and not, that the kernel has counted. */
static uint64_t kernel_switches(void)
{
	FILE *file = fopen("/proc/thread-self/status", "r");
	char line[128];
	unsigned long long slept = 0, preempted = 0;
	if (!file)
		bench_child_fail("no /proc/thread-self/status");
	while (fgets(line, sizeof line, file)) {
		sscanf(line, "voluntary_ctxt_switches: %llu", &slept);
		sscanf(line, "nonvoluntary_ctxt_switches: %llu", &preempted);
	}
	fclose(file);
	return slept + preempted;
}

/* Reads the kernel's count of switches and the number that the profiler has recorded, again until the kernel's count is
 * the same before and after the profiler's snapshot, so that no switch lies between the two. */
static void count_switches(uint64_t *kernel, uint64_t *seen)
{
	stilb_prof_snapshot snapshot = {0};
	do {
		*kernel = kernel_switches();
		check(stilb_prof_snapshot_take(&snapshot, NULL), "a snapshot");
		if (snapshot.lanes[0].no_switches) {
			fprintf(stderr, "%s\n", snapshot.lanes[0].no_switches);
			exit(BENCH_CHILD_SKIP);
		}
		*seen = snapshot.lanes[0].switch_count;
	} while (kernel_switches() != *kernel);
	stilb_prof_snapshot_finish(&snapshot);
}

int profiler_own_switches(double seconds)
{
	uint64_t most = 1000; /* so few switches always fit into the ring buffer from which the profiler reads them */
	uint64_t kernel_before, kernel_after, seen_before, seen_after;
	stilb_prof_switches_set(true);
	check(stilb_prof_thread_begin("main"), "a ring");
	PROFILE("switches"); /* the profiler keeps a thread's switches from its first zone on */
	count_switches(&kernel_before, &seen_before);
	for (uint64_t end = bench_child_now_ns() + (uint64_t)(seconds * 1e9), i = 0; i < most && bench_child_now_ns() < end;
	     i++)
		nanosleep(&(struct timespec){.tv_nsec = 50000}, NULL);
	count_switches(&kernel_after, &seen_after);
	double kernel = (double)(kernel_after - kernel_before), seen = (double)(seen_after - seen_before);
	bench_child_metric("kernel", kernel);
	bench_child_metric("seen", seen);
	bench_child_metric("of-kernel", seen / kernel);
	stilb_prof_thread_end();
	return 0;
}
