/*
 * Crashes: the program executes itself and crashes in one of many ways. The parent checks how the child ended, how long
 * that took and which files it left.
 */
#include "profiler/prof_capture.h"
#include "profiler/prof_internal.h"
#include "support/test.h"
#include "support/trace_check.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <setjmp.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static void sleep_us(long us)
{
	nanosleep(&(struct timespec){.tv_sec = us / 1000000, .tv_nsec = us % 1000000 * 1000}, NULL);
}

/* ---- ways to crash ----------------------------------------------------------------------------------------------- */

/* For functions that crash: hides them from sanitizers, which would report the error before the signal comes. */
#define UNSEEN __attribute__((noinline, no_sanitize("address", "thread", "undefined")))

static volatile uintptr_t low_address = 64;

UNSEEN static void write_low(void)
{
	*(volatile int *)low_address = 1; /* NOLINT */
}

static void crash_segv(void)
{
	PROFILE("crashes");
	write_low();
}

static void crash_abort(void)
{
	PROFILE("crashes");
	abort();
}

UNSEEN static void crash_ill(void)
{
	PROFILE("crashes");
	__builtin_trap();
}

static void crash_fpe(void)
{
	PROFILE("crashes");
	raise(SIGFPE); /* a signal that is sent, not caused by an instruction */
}

/* Reads a mapped page beyond the end of a file that was truncated. */
UNSEEN static void crash_bus(void)
{
	PROFILE("crashes");
	FILE *file = tmpfile();
	char *page = mmap(NULL, 4096, PROT_READ, MAP_SHARED, fileno(file), 0);
	*(volatile char *)page;
}

static volatile uint32_t deep;

UNSEEN static uint32_t overflow(uint32_t depth)
{
	volatile char frame[4096];
	frame[depth % 4096] = 1;
	return depth == deep ? 0 : overflow(depth + 1) + (uint32_t)frame[1];
}

static void crash_stack(void)
{
	PROFILE("crashes");
	static char stack[65536];
	sigaltstack(&(stack_t){.ss_sp = stack, .ss_size = sizeof stack}, NULL);
	deep = UINT32_MAX;
	overflow(0);
}

static void *worker_crashes(void *user)
{
	pthread_barrier_t *barrier = user;
	stilb_prof_thread_begin("worker");
	PROFILE("crashes");
	pthread_barrier_wait(barrier);
	write_low();
	return NULL;
}

/* count threads crash at once, while this one waits. */
static void crash_workers(uint32_t count)
{
	pthread_t threads[8];
	pthread_barrier_t barrier;
	PROFILE("waits");
	pthread_barrier_init(&barrier, NULL, count);
	for (uint32_t i = 0; i < count; i++)
		pthread_create(&threads[i], NULL, worker_crashes, &barrier);
	for (uint32_t i = 0; i < count; i++)
		pthread_join(threads[i], NULL);
}

static void crash_worker(void)
{
	crash_workers(1);
}

static void crash_crowd(void)
{
	crash_workers(8);
}

/* Crashes while a capture waits for frames. */
static void crash_while_one_waits(void)
{
	stilb_prof_capture_now();
	sleep_us(10000);
	crash_segv();
}

/* Crashes on the capturing thread, in done. */
static void crash_in_done(void)
{
	stilb_prof_capture_now();
	sleep_us(20000000);
}

/* Crashes in a child of fork, which has no thread that could write. */
static void crash_in_a_fork(void)
{
	pid_t child = fork();
	int status = 0;
	if (child == 0) {
		write_low();
		_exit(0);
	}
	waitpid(child, &status, 0);
	_exit(WIFSIGNALED(status) && WTERMSIG(status) == SIGSEGV ? 43 : 1);
}

/* ---- the program that crashes ------------------------------------------------------------------------------------ */

static void on_done(void *user, const stilb_prof_captured *captured)
{
	const bool *crash = user;
	if (captured->cause != STILB_PROF_CAUSE_CRASH && *crash)
		write_low();
	if (captured->error != 0 || captured->cause != STILB_PROF_CAUSE_CRASH || captured->frame != 9)
		fprintf(stderr, "done: error %d, cause %d, frame %lu\n", captured->error, (int)captured->cause,
		        captured->frame);
}

static void old_handler(int number, siginfo_t *info, void *context)
{
	(void)context;
	_exit(number == SIGSEGV && (uintptr_t)info->si_addr == low_address ? 42 : 1);
}

static sigjmp_buf recovery;

static void recovering_handler(int number)
{
	siglongjmp(recovery, number);
}

/* The program's own handler catches the signal and the program goes on: captures do, too. */
static int recovers(stilb_prof_capture_desc *desc)
{
	signal(SIGSEGV, recovering_handler);
	if (stilb_prof_capture_start(desc) != 0)
		return 1;
	if (sigsetjmp(recovery, 1) == 0)
		crash_segv();
	return stilb_prof_capture_now() != 0 || stilb_prof_capture_stop() != 0;
}

typedef struct scenario {
	const char *name;
	void (*crash)(void);
} scenario;

static const scenario scenarios[] = {
	{"segv", crash_segv},        {"abort", crash_abort},    {"ill", crash_ill},
	{"fpe", crash_fpe},          {"bus", crash_bus},        {"stack", crash_stack},
	{"worker", crash_worker},    {"crowd", crash_crowd},    {"waiting", crash_while_one_waits},
	{"in_done", crash_in_done},  {"fork", crash_in_a_fork}, {"not_asked_for", crash_segv},
	{"old_handler", crash_segv}, {"recovers", NULL},        {"blocked", crash_segv},
};

static int program(const char *name, const char *path)
{
	struct rlimit none = {0, 0};
	bool in_done = strcmp(name, "in_done") == 0;
	stilb_prof_capture_desc desc = stilb_prof_capture_desc_default();
	setrlimit(RLIMIT_CORE, &none);
	alarm(60);
	desc.path = path;
	desc.crash = strcmp(name, "not_asked_for") != 0;
	desc.done = on_done;
	desc.user = &in_done;
	if (strcmp(name, "old_handler") == 0)
		sigaction(SIGSEGV, &(struct sigaction){.sa_sigaction = old_handler, .sa_flags = SA_SIGINFO}, NULL);
	stilb_prof_thread_begin("main");
	for (int i = 0; i < 10; i++) {
		stilb_prof_frame_mark();
		PROFILE("work");
	}
	if (strcmp(name, "recovers") == 0)
		return recovers(&desc);
	if (stilb_prof_capture_start(&desc) != 0)
		return 2;
	for (size_t i = 0; i < sizeof scenarios / sizeof scenarios[0]; i++)
		if (strcmp(scenarios[i].name, name) == 0)
			scenarios[i].crash();
	return 3;
}

/* ---- the parent -------------------------------------------------------------------------------------------------- */

static char folder[64], path[96];

typedef struct end {
	int signal, status;
	double seconds;
	trace_check_report report;
	bool has_file;
} end;

static double now_s(void)
{
	return 1e-9 * (double)stilb_prof_clock_monotonic();
}

static end run(const char *name)
{
	end e = {0};
	int status = 0;
	struct stat file;
	double begin = now_s();
	pid_t child = fork();
	if (child == 0) {
		/* Sanitizers leave the signals to the program. */
		const char *options =
			"handle_segv=0:handle_abort=0:handle_sigbus=0:handle_sigill=0:handle_sigfpe=0:detect_leaks=0";
		setenv("ASAN_OPTIONS", options, 1);
		setenv("TSAN_OPTIONS", options, 1);
		setenv("UBSAN_OPTIONS", options, 1);
		execl("/proc/self/exe", "test_prof_crash", name, path, NULL);
		_exit(99);
	}
	assert_int_equal(waitpid(child, &status, 0), child);
	e.seconds = now_s() - begin;
	e.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
	e.status = WIFEXITED(status) ? WEXITSTATUS(status) : 0;
	e.has_file = stat(path, &file) == 0 && S_ISREG(file.st_mode);
	if (e.has_file && trace_check_file(path, &e.report) != 0)
		fail_msg("%s: %s", name, e.report.error);
	return e;
}

static void crashes_with(const char *name, int signal, const char *thread, uint64_t zones)
{
	end e = run(name);
	if (e.signal != signal || !e.has_file)
		fail_msg("%s: signal %d, status %d after %.1f s, %s", name, e.signal, e.status, e.seconds,
		         e.has_file ? "with a file" : "without a file");
	assert_int_equal(trace_check_zones(&e.report, thread, "crashes"), zones);
	assert_int_equal(trace_check_zones(&e.report, "main", "work"), 10);
	assert_int_equal(e.report.frames, 9);
	assert_true(e.report.open_zones >= zones);
	trace_check_finish(&e.report);
	unlink(path);
}

static int set_up(void **state)
{
	(void)state;
	strcpy(folder, "/tmp/stilb-prof-crash-XXXXXX");
	if (!mkdtemp(folder))
		return -1;
	snprintf(path, sizeof path, "%s/crash.json", folder);
	return 0;
}

static int tear_down(void **state)
{
	(void)state;
	unlink(path);
	return rmdir(folder); /* fails if anything else is in it */
}

static void open_zones_are_written(void **state)
{
	(void)state;
	crashes_with("segv", SIGSEGV, "main", 1);
	crashes_with("abort", SIGABRT, "main", 1);
	crashes_with("ill", SIGILL, "main", 1);
	crashes_with("fpe", SIGFPE, "main", 1);
	crashes_with("bus", SIGBUS, "main", 1);
	crashes_with("stack", SIGSEGV, "main", 1);
}

static void on_any_thread(void **state)
{
	(void)state;
	crashes_with("worker", SIGSEGV, "worker", 1);
	crashes_with("crowd", SIGSEGV, "worker", 8);
	crashes_with("waiting", SIGSEGV, "main", 1);
}

/* However it crashes, the program ends as it would without the profiler's handlers of crashes. */
static void the_old_way_follows(void **state)
{
	(void)state;
	end e = run("old_handler");
	assert_int_equal(e.status, 42);
	assert_true(e.has_file);
	trace_check_finish(&e.report);
	unlink(path);

	e = run("recovers");
	assert_int_equal(e.signal, 0);
	assert_int_equal(e.status, 0);
	assert_true(e.has_file);
	trace_check_finish(&e.report);
	unlink(path);
	snprintf(path, sizeof path, "%s/crash-2.json", folder);
	assert_int_equal(unlink(path), 0); /* the capture that the program asked for after the signal */
}

static void without_a_file(void **state)
{
	(void)state;
	end e = run("not_asked_for");
	assert_int_equal(e.signal, SIGSEGV);
	assert_false(e.has_file);

	/* No thread can write a file, so the crash does not wait for one. */
	e = run("fork");
	assert_int_equal(e.status, 43);
	assert_false(e.has_file);
	assert_true(e.seconds < 2);
	e = run("in_done");
	assert_int_equal(e.signal, SIGSEGV);
	assert_true(e.has_file); /* the file that done was told of; tear_down asserts that there is no other */
	trace_check_finish(&e.report);
	unlink(path);
}

/* The capture goes into a pipe that nobody reads, so it is never finished: the crash waits two seconds at most. */
static void two_seconds_at_most(void **state)
{
	(void)state;
	assert_int_equal(mkfifo(path, 0600), 0);
	end e = run("blocked");
	assert_int_equal(e.signal, SIGSEGV);
	assert_true(e.seconds >= 2 && e.seconds < 20);
}

int main(int argc, char **argv)
{
	if (argc == 3)
		return program(argv[1], argv[2]);
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup_teardown(open_zones_are_written, set_up, tear_down),
		cmocka_unit_test_setup_teardown(on_any_thread, set_up, tear_down),
		cmocka_unit_test_setup_teardown(the_old_way_follows, set_up, tear_down),
		cmocka_unit_test_setup_teardown(without_a_file, set_up, tear_down),
		cmocka_unit_test_setup_teardown(two_seconds_at_most, set_up, tear_down),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
