/*
 * A long run of the profiler in a typical program: three threads record at sixty frames a second, and one of them ends
 * and begins again all the time; each frame a snapshot of the last two is taken, as an overlay does; now and then a
 * capture is written. Memory must not grow: `cmake --build --preset release --target soak-profiler` runs an hour.
 */
#include "profiler/prof.h"
#include "profiler/prof_capture.h"
#include "profiler/prof_snapshot.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#define PERIOD_NS 16666667u
#define ZONES 200          /* per thread and frame */
#define CAPTURE_FRAMES 600 /* between two captures */
#define ALL_FRAME 6000
#define WARM_SECONDS 120 /* until the rings are full and a few captures are written */
#define SLOPE_MAX 16.0   /* the most growth of memory, in KiB an hour; a page is 4 KiB */

static const char usage[] = "usage: soak_prof [SECONDS]\n\n"
							"  Records for SECONDS (3600, at least 300) and prints the resident memory every minute. "
							"Exit status 0: it did not\n  grow after the first two minutes; 1: it did.\n";

static struct {
	atomic_uint frame;              /* release by main, pairs with the acquire of the others */
	atomic_bool stop;               /* relaxed: it only ends the threads, no data depends on it */
	atomic_uint captures, failures; /* relaxed: counted by one thread, read after it ended */
} soak;

static void record(void)
{
	for (int i = 0; i < ZONES / 10; i++) {
		PROFILE("outer");
		for (int k = 0; k < 9; k++) {
			PROFILE("inner");
		}
		PROFILE_COUNTER("i", i);
	}
}

static void wait_for_frame(unsigned frame)
{
	while (atomic_load_explicit(&soak.frame, memory_order_acquire) < frame &&
	       !atomic_load_explicit(&soak.stop, memory_order_relaxed))
		nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
}

static void *steady(void *unused)
{
	(void)unused;
	stilb_prof_thread_begin("steady");
	for (unsigned frame = 1; !atomic_load_explicit(&soak.stop, memory_order_relaxed); frame++) {
		wait_for_frame(frame);
		record();
	}
	stilb_prof_thread_end();
	return NULL;
}

/* A thread that in each frame begins to record under another name, and ends again. */
static void *restless(void *unused)
{
	(void)unused;
	for (unsigned frame = 1; !atomic_load_explicit(&soak.stop, memory_order_relaxed); frame++) {
		char name[32];
		snprintf(name, sizeof name, "restless %u", frame % 1000);
		wait_for_frame(frame);
		stilb_prof_thread_begin(name);
		record();
		stilb_prof_thread_end();
	}
	return NULL;
}

static void on_captured(void *user, const stilb_prof_captured *captured)
{
	(void)user;
	atomic_fetch_add_explicit(captured->error ? &soak.failures : &soak.captures, 1, memory_order_relaxed);
	if (captured->error == 0)
		unlink(captured->path);
}

static double resident_kib(void)
{
	long pages = 0;
	FILE *file = fopen("/proc/self/statm", "r");
	if (!file || fscanf(file, "%*d %ld", &pages) != 1)
		pages = 0;
	if (file)
		fclose(file);
	return (double)pages * (double)sysconf(_SC_PAGESIZE) / 1024.0;
}

/* The slope of the values measured once a second, by least squares. */
typedef struct slope {
	double n, t, m, tt, tm;
} slope;

static void slope_add(slope *s, double hours, double kib)
{
	s->n += 1.0;
	s->t += hours;
	s->m += kib;
	s->tt += hours * hours;
	s->tm += hours * kib;
}

static double slope_value(const slope *s)
{
	return (s->n * s->tm - s->t * s->m) / (s->n * s->tt - s->t * s->t);
}

static void frame_run(unsigned frame, struct timespec *due, stilb_prof_snapshot *snapshot)
{
	stilb_prof_frame_mark();
	atomic_store_explicit(&soak.frame, frame, memory_order_release); /* pairs with wait_for_frame */
	record();
	/* In one frame (ALL_FRAME) a snapshot of all that the rings hold: memory that is reused has the size of the largest
	 * snapshot, which would otherwise come late, whenever the machine stalls. */
	stilb_prof_window window = {.last_frames = frame == ALL_FRAME ? 0 : 2};
	if (stilb_prof_snapshot_take(snapshot, &window) != 0)
		atomic_fetch_add_explicit(&soak.failures, 1, memory_order_relaxed);
	if (frame % CAPTURE_FRAMES == 0)
		stilb_prof_capture_now();
	due->tv_nsec += PERIOD_NS;
	due->tv_sec += due->tv_nsec / 1000000000;
	due->tv_nsec %= 1000000000;
	clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, due, NULL);
}

int main(int argc, char **argv)
{
	unsigned seconds = argc > 1 ? (unsigned)strtoul(argv[1], NULL, 10) : 3600;
	if (argc > 2 || seconds < 300) {
		fputs(usage, stderr);
		return 2;
	}
	char path[64];
	snprintf(path, sizeof path, "/tmp/soak_prof-%d.json", (int)getpid());
	stilb_prof_capture_desc desc = stilb_prof_capture_desc_default();
	desc.path = path;
	desc.done = on_captured;
	pthread_t threads[2];
	stilb_prof_switches_set(true);
	if (stilb_prof_ring_events_set(1u << 16) != 0 || stilb_prof_thread_begin("main") != 0 ||
	    stilb_prof_capture_start(&desc) != 0 || pthread_create(&threads[0], NULL, steady, NULL) != 0 ||
	    pthread_create(&threads[1], NULL, restless, NULL) != 0) {
		fputs("soak_prof: cannot start\n", stderr);
		return 1;
	}
	stilb_prof_snapshot snapshot = {0};
	slope memory = {0};
	struct timespec due;
	clock_gettime(CLOCK_MONOTONIC, &due);
	for (unsigned frame = 1; frame <= seconds * 60; frame++) {
		frame_run(frame, &due, &snapshot);
		double kib = frame % 60 == 0 ? resident_kib() : 0.0;
		if (frame % 60 == 0 && frame / 60 > WARM_SECONDS)
			slope_add(&memory, frame / 60.0 / 3600.0, kib);
		if (frame % 3600 == 0) {
			printf("%4u min: %.0f KiB resident\n", frame / 3600, kib);
			fflush(stdout);
		}
	}
	atomic_store_explicit(&soak.stop, true, memory_order_relaxed);
	pthread_join(threads[0], NULL);
	pthread_join(threads[1], NULL);
	stilb_prof_capture_stop();
	stilb_prof_snapshot_finish(&snapshot);
	stilb_prof_thread_end();
	stilb_prof_shutdown();
	unsigned captures = atomic_load_explicit(&soak.captures, memory_order_relaxed);
	unsigned failures = atomic_load_explicit(&soak.failures, memory_order_relaxed);
	printf("%u s, %u captures, %u failures: %.1f KiB an hour\n", seconds, captures, failures, slope_value(&memory));
	return failures == 0 && slope_value(&memory) <= SLOPE_MAX ? 0 : 1;
}
