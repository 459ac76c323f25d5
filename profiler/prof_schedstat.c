/*
 * The fallback where the kernel does not show single context switches (prof_switch.c): for each frame and thread, how
 * long the thread ran and how long it waited for a CPU, from /proc/thread-self/schedstat. The file holds three numbers:
 * nanoseconds on a CPU, nanoseconds in a run queue, and time slices (Linux, Documentation/scheduler/sched-stats.rst).
 *
 * The thread that marks frames keeps the files of all threads open, reads them once a frame and records counters. That
 * takes about a microsecond per thread and frame.
 */
#include "profiler/prof_internal.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define PROF_SCHEDSTAT_MAX 64

/* One thread: its file, the values at the last frame, and its two counters. */
typedef struct prof_schedstat {
	int file;                   /* -1: not in use */
	uint64_t ran_ns, waited_ns; /* totals since the thread began, as read at the last frame */
	uint32_t names;             /* index into prof_stats.names and sites */
} prof_schedstat;

uint32_t prof_schedstat_count;

/* The lock guards all of it. Sites are never freed, since events refer to them; they are static, since events can only
 * refer to sites near the program's section of sites (prof_site.c). */
static struct {
	prof_mutex lock;
	prof_schedstat threads[PROF_SCHEDSTAT_MAX];
	uint32_t used; /* entries of threads that were ever in use */
	uint32_t name_count;
	char names[PROF_SCHEDSTAT_MAX][2][PROF_NAME_MAX + 16];
	stilb_prof_site sites[PROF_SCHEDSTAT_MAX][2];
} prof_stats = {.lock = PROF_MUTEX_INIT};

/* The index of the counters of threads of that name, made if there are none. PROF_NONE: the table is full. */
static uint32_t prof_schedstat_names(const char *name)
{
	assert(prof_mutex_is_mine(&prof_stats.lock));
	char made[2][PROF_NAME_MAX + 16];
	uint32_t at = 0;
	snprintf(made[0], sizeof made[0], "%.*s: ran ms", PROF_NAME_MAX - 1, name);
	snprintf(made[1], sizeof made[1], "%.*s: waited ms", PROF_NAME_MAX - 1, name);
	while (at < prof_stats.name_count && strcmp(prof_stats.names[at][0], made[0]) != 0)
		at++;
	if (at == PROF_SCHEDSTAT_MAX)
		return PROF_NONE;
	if (at == prof_stats.name_count) {
		for (int i = 0; i < 2; i++) {
			memcpy(prof_stats.names[at][i], made[i], sizeof made[i]);
			prof_stats.sites[at][i] = (stilb_prof_site){
				.name = prof_stats.names[at][i], .function = "", .file = "", .kind = STILB_PROF_KIND_COUNTER};
		}
		stilb_prof_site_list(prof_stats.sites[at], 2);
		prof_stats.name_count++;
	}
	return at;
}

static bool prof_schedstat_read(int file, uint64_t *ran_ns, uint64_t *waited_ns)
{
	char text[96], *end;
	ssize_t size = pread(file, text, sizeof text - 1, 0);
	if (size <= 0)
		return false; /* the thread has ended */
	text[size] = 0;
	*ran_ns = strtoull(text, &end, 10);
	*waited_ns = strtoull(end, NULL, 10);
	return true;
}

uint32_t prof_schedstat_open(const char *name)
{
	assert(name);
	int file = open("/proc/thread-self/schedstat", O_RDONLY | O_CLOEXEC);
	prof_schedstat thread = {.file = file};
	uint32_t slot = 0;
	if (file < 0)
		return 0;
	prof_mutex_lock(&prof_stats.lock);
	while (slot < prof_stats.used && prof_stats.threads[slot].file >= 0)
		slot++;
	thread.names = slot < PROF_SCHEDSTAT_MAX ? prof_schedstat_names(name) : PROF_NONE;
	bool works = thread.names != PROF_NONE && prof_schedstat_read(file, &thread.ran_ns, &thread.waited_ns);
	if (works) {
		prof_stats.threads[slot] = thread;
		prof_stats.used += slot == prof_stats.used;
		__atomic_add_fetch(&prof_schedstat_count, 1, __ATOMIC_RELAXED); /* no data depends on it */
	} else {
		close(file);
	}
	prof_mutex_unlock(&prof_stats.lock);
	return works ? slot + 1 : 0;
}

void prof_schedstat_close(uint32_t handle)
{
	if (handle == 0)
		return;
	prof_mutex_lock(&prof_stats.lock);
	prof_schedstat *thread = &prof_stats.threads[handle - 1];
	assert(handle <= prof_stats.used && thread->file >= 0 && "a handle is closed once");
	close(thread->file);
	thread->file = -1;
	__atomic_sub_fetch(&prof_schedstat_count, 1, __ATOMIC_RELAXED); /* no data depends on it */
	prof_mutex_unlock(&prof_stats.lock);
}

/* Records the two counters of each thread. If the lock is taken, since some thread begins or ends, this frame gets no
 * counters, and its time is added to the next frame's. */
void prof_schedstat_sample(void)
{
	/* Make this thread's ring before taking the lock: a thread that gets a ring calls prof_schedstat_open. */
	if (!stilb_prof_recorder() || !prof_mutex_try(&prof_stats.lock))
		return;
	for (uint32_t i = 0; i < prof_stats.used; i++) {
		prof_schedstat *thread = &prof_stats.threads[i];
		uint64_t ran_ns, waited_ns;
		assert(thread->names < prof_stats.name_count);
		if (thread->file < 0 || !prof_schedstat_read(thread->file, &ran_ns, &waited_ns))
			continue;
		stilb_prof_counter(&prof_stats.sites[thread->names][0], 1e-6 * (double)(ran_ns - thread->ran_ns));
		stilb_prof_counter(&prof_stats.sites[thread->names][1], 1e-6 * (double)(waited_ns - thread->waited_ns));
		thread->ran_ns = ran_ns;
		thread->waited_ns = waited_ns;
	}
	prof_mutex_unlock(&prof_stats.lock);
}
