/* Context switches: every one that /proc counts is recorded, whole and in order, also while the records are read. */
#include "profiler/prof_internal.h"
#include "profiler/prof_snapshot.h"
#include "support/test.h"

#include <errno.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <pthread.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static prof_switch_event events[PROF_SWITCHES_MAX];

static void sleep_ns(long ns)
{
	nanosleep(&(struct timespec){.tv_nsec = ns}, NULL);
}

/* A thread's context switches, those away from its CPU: because it slept, and because it was preempted. */
typedef struct proc_counts {
	uint64_t slept, preempted;
} proc_counts;

/* The switches of the calling thread until now, as the kernel counts them; UINT64_MAX: /proc does not tell. */
static proc_counts proc_count(void)
{
	proc_counts counts = {UINT64_MAX, UINT64_MAX};
	FILE *file = fopen("/proc/thread-self/status", "r");
	char line[256];
	while (file && fgets(line, sizeof line, file)) {
		sscanf(line, "voluntary_ctxt_switches: %lu", &counts.slept);
		sscanf(line, "nonvoluntary_ctxt_switches: %lu", &counts.preempted);
	}
	if (file)
		fclose(file);
	return counts;
}

/* True if the times in the list ascend, and its events alternate: the thread leaves a CPU, comes back (in), leaves. */
static bool events_are_whole(const prof_switch_event *list, uint32_t count)
{
	for (uint32_t i = 0; i < count; i++)
		if (list[i].ns == 0 || (list[i].in && list[i].preempted) ||
		    (i > 0 && (list[i].ns < list[i - 1].ns || list[i].in == list[i - 1].in)))
			return false;
	return true;
}

/* The same counts from events[0 .. count - 1], the switches that the profiler recorded. */
static proc_counts events_count(uint32_t count)
{
	proc_counts counts = {0, 0};
	for (uint32_t i = 0; i < count; i++) {
		counts.slept += !events[i].in && !events[i].preempted;
		counts.preempted += !events[i].in && events[i].preempted;
	}
	return counts;
}

/* Runs function on a thread of its own. */
static void run(void *(*function)(void *), void *user)
{
	pthread_t thread;
	assert_int_equal(pthread_create(&thread, NULL, function, user), 0);
	assert_int_equal(pthread_join(thread, NULL), 0);
}

/* ---- switches that are recorded ---------------------------------------------------------------------------------- */

typedef struct sleeper {
	prof_switches switches;
	proc_counts proc, noted;
	uint32_t count;
	bool whole;
} sleeper;

/* The number of recorded switches and the count of /proc at one moment: between two equal counts nothing was
 * recorded. */
static void sleeper_look(sleeper *s, proc_counts *noted, proc_counts *proc)
{
	proc_counts again;
	do {
		*proc = proc_count();
		s->count = prof_switches_copy(&s->switches, 0, events);
		again = proc_count();
	} while (proc->slept != again.slept || proc->preempted != again.preempted);
	*noted = events_count(s->count);
}

static void *sleeper_run(void *user)
{
	sleeper *s = user;
	proc_counts noted_before, proc_before;
	s->switches = prof_switches_open("test");
	sleeper_look(s, &noted_before, &proc_before);
	for (int i = 0; i < 500; i++) {
		sleep_ns(100000);
		sched_yield();
	}
	sleeper_look(s, &s->noted, &s->proc);
	s->noted = (proc_counts){s->noted.slept - noted_before.slept, s->noted.preempted - noted_before.preempted};
	s->proc = (proc_counts){s->proc.slept - proc_before.slept, s->proc.preempted - proc_before.preempted};
	s->whole = events_are_whole(events, s->count);
	return NULL;
}

static uint32_t rival_stop;

static void *rival_run(void *user)
{
	(void)user;
	while (!__atomic_load_n(&rival_stop, __ATOMIC_RELAXED)) /* set by rivals_join; no data depends on it */
		sched_yield();
	return NULL;
}

/* Threads created from now on run on one CPU; returns the CPUs before. */
static cpu_set_t one_cpu(void)
{
	cpu_set_t all, one;
	CPU_ZERO(&one);
	CPU_SET(sched_getcpu(), &one);
	pthread_getaffinity_np(pthread_self(), sizeof all, &all);
	pthread_setaffinity_np(pthread_self(), sizeof one, &one);
	return all;
}

static pthread_t rival_start(void)
{
	pthread_t thread;
	__atomic_store_n(&rival_stop, 0, __ATOMIC_RELAXED);
	assert_int_equal(pthread_create(&thread, NULL, rival_run, NULL), 0);
	return thread;
}

static void rival_join(pthread_t thread)
{
	__atomic_store_n(&rival_stop, 1, __ATOMIC_RELAXED);
	pthread_join(thread, NULL);
}

/* A thread that only sleeps, and then one that is also preempted, because a second thread runs on its only CPU. */
static void every_switch_is_noted(void **state)
{
	(void)state;
	for (int rivals = 0; rivals < 2; rivals++) {
		sleeper s = {0};
		cpu_set_t all = one_cpu();
		pthread_t rival = rivals > 0 ? rival_start() : pthread_self();
		run(sleeper_run, &s);
		if (rivals > 0)
			rival_join(rival);
		pthread_setaffinity_np(pthread_self(), sizeof all, &all);
		assert_true(s.whole);
		assert_int_equal(s.noted.slept, s.proc.slept);
		assert_int_equal(s.noted.preempted, s.proc.preempted);
		assert_true(s.proc.slept >= 400);
		assert_true(rivals == 0 || s.proc.preempted > 10);

		/* The thread has ended; its switches can be read until prof_switches_close. */
		assert_in_range(prof_switches_copy(&s.switches, 0, events), s.count, s.count + 16); /* it ends: may wait */
		prof_switches_close(&s.switches);
		assert_int_equal(prof_switches_copy(&s.switches, 0, events), 0);
	}
}

static void the_newest_are_kept(void **state)
{
	(void)state;
	prof_switches switches = prof_switches_open("test");
	for (int i = 0; i < PROF_SWITCHES_MAX / 2 + 500; i++)
		sleep_ns(1);
	uint64_t before = stilb_prof_clock_monotonic();
	sleep_ns(1000000);
	uint64_t after = stilb_prof_clock_monotonic();
	uint32_t count = prof_switches_copy(&switches, 0, events);
	assert_in_range(count, PROF_SWITCHES_MAX - 1 - 8, PROF_SWITCHES_MAX - 1); /* it may be preempted in the copy */
	assert_true(events_are_whole(events, count));

	/* A copy begins with the last switch before the given time: so the thread's state at that time is known. */
	uint32_t since = prof_switches_copy(&switches, before, events);
	assert_in_range(since, 3, 64);
	assert_true(events[0].ns <= before && events[0].in);
	assert_true(events[1].ns > before);
	assert_true(events_are_whole(events, since));
	uint64_t away = 0;
	for (uint32_t i = 2; i < since; i += 2)
		if (events[i].ns <= after)
			away += events[i].ns - events[i - 1].ns;
	assert_in_range(away, 900000, after - before);
	prof_switches_close(&switches);
}

/* ---- read while it is written ------------------------------------------------------------------------------------ */

typedef struct switcher {
	prof_switches switches;
	uint32_t ready, stop;
} switcher;

static void *switcher_run(void *user)
{
	switcher *s = user;
	s->switches = prof_switches_open("test");
	__atomic_store_n(&s->ready, 1, __ATOMIC_RELEASE); /* pairs with copies_are_whole */
	while (!__atomic_load_n(&s->stop, __ATOMIC_RELAXED))
		sched_yield();
	return NULL;
}

static void copies_are_whole(void **state)
{
	(void)state;
	if (sysconf(_SC_NPROCESSORS_ONLN) < 2)
		skip();
	switcher s = {0};
	pthread_t thread;
	cpu_set_t all = one_cpu();
	pthread_t rival = rival_start();
	assert_int_equal(pthread_create(&thread, NULL, switcher_run, &s), 0);
	pthread_setaffinity_np(pthread_self(), sizeof all, &all);
	while (!__atomic_load_n(&s.ready, __ATOMIC_ACQUIRE))
		sched_yield();
	uint64_t newest = 0;
	uint32_t full = 0, broken = 0;
	for (time_t end = time(NULL) + 20; time(NULL) < end && full < 200;) {
		uint32_t count = prof_switches_copy(&s.switches, 0, events);
		broken += !events_are_whole(events, count) || (count > 0 && events[count - 1].ns < newest);
		full += count > PROF_SWITCHES_MAX / 2 && events[count - 1].ns > newest;
		newest = count > 0 ? events[count - 1].ns : newest;
	}
	__atomic_store_n(&s.stop, 1, __ATOMIC_RELAXED);
	pthread_join(thread, NULL);
	rival_join(rival);
	prof_switches_close(&s.switches);
	assert_int_equal(broken, 0);
	assert_int_equal(full, 200); /* the thread went on switching while its switches were read */
}

/* ---- if the kernel refuses --------------------------------------------------------------------------------------- */

/* Runs check in a child process, whose rights it may give up. check returns 0: passed; 77: not possible here. */
static void in_child(int (*check)(void))
{
	pid_t child = fork();
	assert_true(child >= 0);
	if (child == 0)
		_exit(check());
	int status = 0;
	assert_int_equal(waitpid(child, &status, 0), child);
	assert_true(WIFEXITED(status));
	if (WEXITSTATUS(status) == 77)
		skip();
	assert_int_equal(WEXITSTATUS(status), 0);
}

static int refused_is(const char *part)
{
	prof_switches switches = prof_switches_open("test");
	bool good = !switches.page && switches.refused && strstr(switches.refused, part) &&
	            prof_switches_copy(&switches, 0, events) == 0;
	if (!good)
		fprintf(stderr, "refused: %s\n", switches.refused ? switches.refused : "(not at all)");
	prof_switches_close(&switches);
	return !good;
}

static int forbid_perf(uint32_t error)
{
	struct sock_filter filter[] = {
		BPF_STMT(BPF_LD | BPF_W | BPF_ABS, 0), /* the system call's number */
		BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_perf_event_open, 0, 1),
		BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | error),
		BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
	};
	struct sock_fprog program = {.len = sizeof filter / sizeof filter[0], .filter = filter};
	return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) || prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program);
}

static int without_permission(void)
{
	return forbid_perf(EPERM) ? 77 : refused_is("perf_event");
}

static int without_the_call(void)
{
	return forbid_perf(ENOSYS) ? 77 : refused_is("no perf_event_open");
}

static int without_switches(void)
{
	return forbid_perf(EINVAL) ? 77 : refused_is("knows no context switches");
}

static int without_descriptors(void)
{
	struct rlimit none = {0, 0};
	return setrlimit(RLIMIT_NOFILE, &none) ? 77 : refused_is("no file descriptor");
}

/* A short sleep may be over before it begins, and then nothing is switched: sleeps until a switch is noted. */
static bool switch_is_noted(prof_switches *switches)
{
	for (int i = 0; i < 1000; i++) {
		sleep_ns(1000);
		if (prof_switches_copy(switches, 0, events) >= 2)
			return true;
	}
	return false;
}

/* For an ordinary user the kernel limits locked memory: rings have full size until that is used up, then they are
 * smaller, then there are none. */
static int as_nobody(void)
{
	static prof_switches all[4096];
	struct rlimit little = {0, 0};
	uint32_t count = 0, small = 0;
	if (setrlimit(RLIMIT_MEMLOCK, &little) || setgid(65534) || setuid(65534))
		return 77;
	while (count < 4096 && (all[count] = prof_switches_open("test")).page) {
		if (!switch_is_noted(&all[count]))
			return 1;
		small += all[count].size < all[0].size;
		count++;
	}
	if (count == 0 || count == 4096 || small == 0)
		return 2;
	bool told = strstr(all[count].refused, "RLIMIT_MEMLOCK");
	while (count > 0)
		prof_switches_close(&all[--count]);
	return told ? 0 : 3;
}

static prof_switches parents;

static int in_a_fork(void)
{
	if (prof_switches_copy(&parents, 0, events) != 0)
		return 1;
	prof_switches_close(&parents); /* must unmap nothing: in the child, other memory may be at that address */
	return 0;
}

static void reasons_are_told(void **state)
{
	(void)state;
	in_child(without_permission);
	in_child(without_the_call);
	in_child(without_switches);
	in_child(without_descriptors);
}

/* If the kernel refuses, there are counters instead: how long each thread ran in a frame, and waited for a CPU. */
static int counted_instead(void)
{
	stilb_prof_snapshot snapshot = {0};
	double ran = 0;
	uint32_t count = 0, waited = 0;
	if (forbid_perf(EPERM))
		return 77;
	stilb_prof_thread_begin("main");
	for (int i = 0; i < 10; i++) {
		stilb_prof_frame_mark();
		sleep_ns(5000000);
		struct timespec cpu;
		do
			clock_gettime(CLOCK_THREAD_CPUTIME_ID, &cpu);
		while (cpu.tv_sec * 1000 + cpu.tv_nsec / 1000000 < 20 + 5 * (i + 1));
	}
	stilb_prof_frame_mark();
	if (stilb_prof_snapshot_take(&snapshot, NULL) != 0 || !snapshot.lanes[0].no_switches)
		return 1;
	for (uint32_t i = 0; i < snapshot.point_count; i++) {
		const stilb_prof_point *point = &snapshot.points[i];
		const char *name = snapshot.labels[point->label].name;
		if (!point->counter)
			return 2;
		if (strcmp(name, "main: ran ms") == 0) {
			ran += count > 0 ? point->value : 0; /* the first value is for the time before the first frame */
			count++;
		}
		waited += strcmp(name, "main: waited ms") == 0 && point->value >= 0;
	}
	stilb_prof_snapshot_finish(&snapshot);
	stilb_prof_shutdown();
	fprintf(stderr, "ran %.3f ms in 10 frames\n", ran);
	if (count != 11 || waited != 11 || prof_schedstat_count != 0)
		return 3;
	return ran < 45 || ran > 85 ? 4 : 0;
}

static void counters_stand_in(void **state)
{
	(void)state;
	in_child(counted_instead);
}

static void ordinary_users_have_them(void **state)
{
	(void)state;
	in_child(as_nobody);
}

static void a_fork_has_none(void **state)
{
	(void)state;
	parents = prof_switches_open("test");
	assert_true(switch_is_noted(&parents));
	in_child(in_a_fork);
	assert_true(prof_switches_copy(&parents, 0, events) >= 2);
	prof_switches_close(&parents);
}

/* The same through the public functions: a zone in a snapshot says how long its thread was not running. */
static void zones_know(void **state)
{
	(void)state;
	stilb_prof_snapshot snapshot = {0};
	assert_int_equal(stilb_prof_thread_begin("sleeper"), 0);
	{
		PROFILE("sleeps");
		sleep_ns(5000000);
	}
	assert_int_equal(stilb_prof_snapshot_take(&snapshot, NULL), 0);
	const stilb_prof_lane *lane = &snapshot.lanes[0];
	assert_null(lane->no_switches);
	assert_true(lane->switch_count > 0);
	assert_int_equal(lane->zone_count, 1);
	const stilb_prof_zone *zone = &lane->zones[0];
	assert_true(zone->off_cpu_ns > 4900000);
	assert_true(zone->off_cpu_ns <= zone->end_ns - zone->begin_ns);
	stilb_prof_snapshot_finish(&snapshot);
	stilb_prof_shutdown();

	stilb_prof_switches_set(false);
	assert_int_equal(stilb_prof_thread_begin("sleeper"), 0);
	assert_int_equal(stilb_prof_snapshot_take(&snapshot, NULL), 0);
	assert_string_equal(snapshot.lanes[0].no_switches, "not asked for");
	stilb_prof_snapshot_finish(&snapshot);
	stilb_prof_shutdown();
	stilb_prof_switches_set(true);
}

static void only_when_asked_for(void **state)
{
	(void)state;
	stilb_prof_switches_set(false);
	assert_int_equal(refused_is("not asked for"), 0);
	stilb_prof_switches_set(true);
}

int main(void)
{
	stilb_prof_switches_set(true);
	prof_switches probe = prof_switches_open("test");
	if (!probe.page) {
		printf("skipped: %s\n", probe.refused);
		return 77;
	}
	prof_switches_close(&probe);
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_switch_is_noted),
		cmocka_unit_test(the_newest_are_kept),
		cmocka_unit_test(copies_are_whole),
		cmocka_unit_test(reasons_are_told),
		cmocka_unit_test(counters_stand_in),
		cmocka_unit_test(ordinary_users_have_them),
		cmocka_unit_test(a_fork_has_none),
		cmocka_unit_test(only_when_asked_for),
		cmocka_unit_test(zones_know),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
