/* Measures what the simulator wants to know of a machine: the one that runs this. */
#include "bench/harness/bench_child.h"
#include "bench/sim/sim_costs.h"
#include "jobs/job_sys.h"

#include <pthread.h>
#include <stdatomic.h>
#include <string.h>

enum {
	CPUS_MAX = 64,     /* CPUs that are looked at; their pairs' time grows with the square */
	PASSES = 2000,     /* of a line to and fro, in one measurement */
	REPEATS = 7,       /* measurements of a pair; the fastest counts, since others only make it slower */
	WAKES = 300,       /* of a thread that sleeps */
	CALLS = 100000,    /* of what takes some nanoseconds */
	CREATIONS = 50,    /* of a thread */
	PARKED_NS = 120000 /* the sleeper sleeps at least so long before it is woken */
};

static int order(const void *a, const void *b)
{
	double x = *(const double *)a, y = *(const double *)b;
	return (x > y) - (x < y);
}

static double median(double *values, size_t count)
{
	qsort(values, count, sizeof *values, order);
	return values[count / 2];
}

/* ---- what CPUs share --------------------------------------------------------------------------------------------- */

/* A CPU that this program may use, with the kernel's lists of those that share its core and its last level of cache. */
typedef struct place {
	uint32_t cpu;
	int package;
	char core[256], cache[256];
} place;

static struct {
	uint32_t count;
	place place[CPUS_MAX];
} here;

/* The first line of a file in the CPU's folder; empty if there is none. */
static void read_file(uint32_t cpu, const char *name, char *line, int size)
{
	char path[128];
	snprintf(path, sizeof path, "/sys/devices/system/cpu/cpu%u/%s", cpu, name);
	FILE *in = fopen(path, "re");
	if (!in || !fgets(line, size, in))
		*line = '\0';
	line[strcspn(line, "\n")] = '\0';
	if (in)
		fclose(in);
}

/* The list of CPUs that share the highest level of cache; the package's number where there is none. */
static void read_cache(place *p)
{
	snprintf(p->cache, sizeof p->cache, "package %d", p->package);
	for (int i = 0; i < 5; i++) {
		char name[64], line[256];
		snprintf(name, sizeof name, "cache/index%d/shared_cpu_list", i);
		read_file(p->cpu, name, line, sizeof line);
		if (*line)
			memcpy(p->cache, line, sizeof line);
	}
}

static void read_places(void)
{
	cpu_set_t allowed;
	here.count = 0;
	if (sched_getaffinity(getpid(), sizeof allowed, &allowed) != 0)
		return;
	for (uint32_t cpu = 0; cpu < CPU_SETSIZE && here.count < CPUS_MAX; cpu++) {
		if (!CPU_ISSET(cpu, &allowed))
			continue;
		place *p = &here.place[here.count++];
		char package[32];
		p->cpu = cpu;
		read_file(cpu, "topology/physical_package_id", package, sizeof package);
		p->package = atoi(package);
		read_file(cpu, "topology/thread_siblings_list", p->core, sizeof p->core);
		if (!*p->core)
			snprintf(p->core, sizeof p->core, "%u", cpu);
		read_cache(p);
	}
}

typedef enum distance { SAME_CORE, SAME_CACHE, SAME_PACKAGE, FAR, DISTANCES } distance;

static distance between(const place *a, const place *b)
{
	if (a->package != b->package)
		return FAR;
	if (strcmp(a->core, b->core) == 0)
		return SAME_CORE;
	return strcmp(a->cache, b->cache) == 0 ? SAME_CACHE : SAME_PACKAGE;
}

/* The number of cores that are at most so far from the first CPU, its own included. */
static uint32_t count_cores(distance most)
{
	uint32_t cores = 0;
	for (uint32_t i = 0; i < here.count; i++) {
		bool first = true; /* of its core */
		for (uint32_t j = 0; j < i; j++)
			first &= between(&here.place[i], &here.place[j]) != SAME_CORE;
		cores += first && between(&here.place[0], &here.place[i]) <= most;
	}
	return cores;
}

static void measure_places(sim_machine *m)
{
	uint32_t all = count_cores(FAR);
	m->cores = count_cores(SAME_PACKAGE);
	m->cluster = count_cores(SAME_CACHE);
	m->sockets = (all + m->cores - 1) / m->cores;
	m->threads = (here.count + all - 1) / all;
	while (m->cores % m->cluster != 0)
		m->cluster--; /* caches of different size, or CPUs that this program may not use */
}

/* ---- transfers --------------------------------------------------------------------------------------------------- */

/* Even: the first thread's turn. Relaxed everywhere: it carries nothing but itself. */
static _Alignas(128) _Atomic uint32_t turn;
static pthread_barrier_t both;

typedef struct player {
	pthread_t thread;
	uint32_t cpu, side;
	double best; /* ns for one pass */
} player;

static void pin(uint32_t cpu)
{
	cpu_set_t one;
	CPU_ZERO(&one);
	CPU_SET(cpu, &one);
	sched_setaffinity(0, sizeof one, &one);
}

static void *play(void *data)
{
	player *p = data;
	pin(p->cpu);
	p->best = 1e9;
	for (int r = 0; r < REPEATS; r++) {
		pthread_barrier_wait(&both);
		uint64_t begin = bench_child_now_ns();
		for (uint32_t i = 0; i < PASSES; i++) {
			uint32_t expected = 2 * i + p->side;
			while (!atomic_compare_exchange_weak_explicit(&turn, &expected, 2 * i + p->side + 1, memory_order_relaxed,
			                                              memory_order_relaxed))
				expected = 2 * i + p->side;
		}
		double pass = (double)(bench_child_now_ns() - begin) / (2.0 * PASSES);
		p->best = pass < p->best ? pass : p->best;
		if (pthread_barrier_wait(&both) == PTHREAD_BARRIER_SERIAL_THREAD)
			atomic_store_explicit(&turn, 0, memory_order_relaxed);
	}
	return NULL;
}

/* The time of one pass of a line from one CPU to the other, ns; negative if threads cannot be created. */
static double pass_time(uint32_t a, uint32_t b)
{
	player one = {.cpu = a}, two = {.cpu = b, .side = 1};
	pthread_barrier_init(&both, NULL, 2);
	atomic_store_explicit(&turn, 0, memory_order_relaxed);
	if (pthread_create(&two.thread, NULL, play, &two) != 0)
		return -1.0;
	if (pthread_create(&one.thread, NULL, play, &one) != 0) {
		play(&one); /* the second waits for it, so this thread plays */
		pthread_join(two.thread, NULL);
		return -1.0;
	}
	pthread_join(one.thread, NULL);
	pthread_join(two.thread, NULL);
	pthread_barrier_destroy(&both);
	return one.best;
}

static bool measure_lines(sim_machine *m)
{
	static double times[DISTANCES][CPUS_MAX * CPUS_MAX / 2];
	size_t counts[DISTANCES] = {0};
	for (uint32_t i = 0; i < here.count; i++)
		for (uint32_t j = i + 1; j < here.count; j++) {
			distance d = between(&here.place[i], &here.place[j]);
			double time = pass_time(here.place[i].cpu, here.place[j].cpu);
			if (time < 0.0)
				return false;
			times[d][counts[d]++] = time;
		}
	double known[DISTANCES];
	for (int d = 0; d < DISTANCES; d++) /* where no pair has this distance, the nearer one's */
		known[d] = counts[d] > 0 ? median(times[d], counts[d]) : d > 0 ? known[d - 1] : 0.0;
	m->near = known[SAME_CACHE];
	m->smt = counts[SAME_CORE] > 0 ? known[SAME_CORE] : m->near;
	m->socket = known[SAME_PACKAGE] > m->near ? known[SAME_PACKAGE] : m->near;
	m->far = known[FAR] > m->socket ? known[FAR] : m->socket;
	return true;
}

/* ---- one thread -------------------------------------------------------------------------------------------------- */

static void do_rmw(void)
{
	static _Alignas(128) _Atomic uint32_t own;
	atomic_fetch_add_explicit(&own, 1, memory_order_relaxed); /* orders nothing */
}

static void do_yield(void)
{
	sched_yield();
}

/* The time of a call of fn, ns: the fastest of several measurements. */
static double time_of(void (*fn)(void), int calls)
{
	double best = 1e9;
	for (int r = 0; r < REPEATS; r++) {
		uint64_t begin = bench_child_now_ns();
		for (int i = 0; i < calls; i++)
			fn();
		double time = (double)(bench_child_now_ns() - begin) / calls;
		best = time < best ? time : best;
	}
	return best;
}

/* ---- sleep and wake ---------------------------------------------------------------------------------------------- */

static struct {
	_Alignas(128) _Atomic uint32_t word; /* 0: sleep, 1: wake up. Release by the waker, pairs with sleeper_main */
	_Alignas(
		128) _Atomic uint32_t slept; /* times that the sleeper has begun to. Release by it, pairs with wait_slept */
	uint64_t awake;                  /* when it last woke up, ns; its next store to `slept` publishes it */
	uint32_t cpu;
} bed;

static void *sleeper_main(void *unused)
{
	(void)unused;
	pin(bed.cpu);
	for (uint32_t i = 1; i <= WAKES + 1; i++) {
		atomic_store_explicit(&bed.slept, i, memory_order_release);
		while (i <= WAKES && atomic_load_explicit(&bed.word, memory_order_acquire) == 0)
			job_sys_futex_wait(&bed.word, 0);
		bed.awake = bench_child_now_ns();
		atomic_store_explicit(&bed.word, 0, memory_order_relaxed); /* the next store to `slept` publishes it */
	}
	return NULL;
}

static void wait_slept(uint32_t times)
{
	while (atomic_load_explicit(&bed.slept, memory_order_acquire) < times)
		job_sys_pause();
}

typedef struct wakes {
	double call[WAKES], latency[WAKES];
} wakes;

static void *waker_main(void *data)
{
	wakes *w = data;
	pin(here.place[0].cpu);
	for (uint32_t i = 0; i < WAKES; i++) {
		wait_slept(i + 1);
		for (uint64_t end = bench_child_now_ns() + PARKED_NS; bench_child_now_ns() < end;)
			job_sys_pause();
		uint64_t begin = bench_child_now_ns();
		atomic_store_explicit(&bed.word, 1, memory_order_release);
		job_sys_futex_wake_one(&bed.word);
		w->call[i] = (double)(bench_child_now_ns() - begin);
		wait_slept(i + 2);
		w->latency[i] = (double)(bed.awake - begin);
	}
	return NULL;
}

/* The sleeper's CPU shares no core with the waker's, if there is one. */
static bool measure_wakes(sim_machine *m)
{
	static wakes w;
	pthread_t sleeper, waker;
	for (uint32_t i = 0; i < here.count; i++)
		if (i == 0 || (bed.cpu == here.place[0].cpu && between(&here.place[0], &here.place[i]) != SAME_CORE))
			bed.cpu = here.place[i].cpu;
	if (pthread_create(&sleeper, NULL, sleeper_main, NULL) != 0)
		return false;
	if (pthread_create(&waker, NULL, waker_main, &w) != 0) {
		waker_main(&w); /* the sleeper waits for it */
		pthread_join(sleeper, NULL);
		return false;
	}
	pthread_join(waker, NULL);
	pthread_join(sleeper, NULL);
	m->wake = median(w.call, WAKES);
	m->latency = median(w.latency, WAKES);
	return true;
}

static void *return_at_once(void *data)
{
	return data;
}

static bool measure_creation(sim_machine *m)
{
	double times[CREATIONS];
	for (int i = 0; i < CREATIONS; i++) {
		pthread_t thread;
		uint64_t begin = bench_child_now_ns();
		if (pthread_create(&thread, NULL, return_at_once, NULL) != 0)
			return false;
		times[i] = (double)(bench_child_now_ns() - begin);
		pthread_join(thread, NULL);
	}
	m->create = median(times, CREATIONS);
	return true;
}

bool sim_costs_measure(sim_machine *m)
{
	read_places();
	if (here.count < 2) {
		fprintf(stderr, "stilb-bench-sim-here: --costs needs two CPUs, and this program may use %u\n", here.count);
		return false;
	}
	measure_places(m);
	m->rmw = time_of(do_rmw, CALLS);
	m->pause = time_of(job_sys_pause, CALLS);
	m->call = time_of(do_yield, CALLS / 10);
	if (measure_lines(m) && measure_wakes(m) && measure_creation(m))
		return true;
	fprintf(stderr, "stilb-bench-sim-here: a thread cannot be created\n");
	return false;
}
