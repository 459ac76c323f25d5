/*
 * Recording makes no system call and no allocation, and takes no lock that could need either. Ten million zones, and as
 * many events of every other kind, are recorded in a child process whose first system call ends it (seccomp);
 * allocations are counted (--wrap).
 */
#include "support/test.h"
#include "test_prof_records.h"

#include <linux/filter.h>
#include <linux/seccomp.h>
#include <signal.h>
#include <stddef.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#define ZONES 10000000

static uint64_t allocations;

void *__real_malloc(size_t size);
void *__wrap_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__real_realloc(void *memory, size_t size);
void *__wrap_realloc(void *memory, size_t size);
void *__real_mmap(void *address, size_t size, int protection, int flags, int file, off_t offset);
void *__wrap_mmap(void *address, size_t size, int protection, int flags, int file, off_t offset);

void *__wrap_malloc(size_t size)
{
	allocations++;
	return __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size)
{
	allocations++;
	return __real_calloc(count, size);
}

void *__wrap_realloc(void *memory, size_t size)
{
	allocations++;
	return __real_realloc(memory, size);
}

void *__wrap_mmap(void *address, size_t size, int protection, int flags, int file, off_t offset)
{
	allocations++;
	return __real_mmap(address, size, protection, flags, file, offset);
}

/* From here on every system call but exit_group kills the process. */
static int forbid_system_calls(void)
{
	struct sock_filter filter[] = {
		BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, nr)),
		BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_exit_group, 0, 1),
		BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
		BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS),
	};
	struct sock_fprog program = {.len = sizeof filter / sizeof filter[0], .filter = filter};
	return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 ? -1 : prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program);
}

/* Runs a child; returns its exit status, or minus the signal that ended it. */
static int in_a_child(int (*run)(void))
{
	pid_t child = fork();
	if (child == 0) {
		int status = run();
		syscall(SYS_exit_group, status);
	}
	int status = 0;
	assert_true(child > 0);
	assert_int_equal(waitpid(child, &status, 0), child);
	return WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
}

STILB_PROF_SITE(hook_site, "hook", 0);
STILB_PROF_FLOW(job_flow, "job", 0);

static __attribute__((noinline)) void record_everything(int i, stilb_prof_lane_handle *lane)
{
	PROFILE_FUNCTION();
	PROFILE_PRECISE("precise");
	PROFILE_BEGIN("first");
	PROFILE_NEXT("second");
	PROFILE_END();
	PROFILE_COUNTER("counter", i);
	PROFILE_INSTANT("instant");
	stilb_prof_zone_begin(&hook_site);
	stilb_prof_flow_end(job_flow, stilb_prof_flow_begin(job_flow));
	stilb_prof_zone_end();
	stilb_prof_lane_zone(lane, &hook_site, 0, (uint64_t)i, (uint64_t)i + 1);
}

static int record_all(void)
{
	stilb_prof_lane_handle *lane;
	if (stilb_prof_ring_events_set(1u << 20) != 0 || stilb_prof_thread_begin("main") != 0 ||
	    stilb_prof_lane_create("GPU", &lane) != 0 || forbid_system_calls() != 0)
		return 2;
	allocations = 0;
	for (int i = 0; i < ZONES; i++) {
		if (i % 10000 == 0)
			stilb_prof_frame_mark();
		PROFILE("zone");
	}
	for (int i = 0; i < ZONES / 100; i++)
		record_everything(i, lane);
	for (int i = 0; i < 100; i++) /* and too deep */
		stilb_prof_zone_begin(&hook_site);
	while (stilb_prof_thread_ring->depth > 0)
		stilb_prof_zone_end();
	return allocations == 0 && stilb_prof_thread_ring->head > ZONES ? 0 : 3;
}

static void recording_stays_in_the_program(void **state)
{
	(void)state;
	assert_int_equal(in_a_child(record_all), 0);
}

/* The same checks must fail for a child that makes a system call. */
static int make_a_system_call(void)
{
	return forbid_system_calls() != 0 ? 2 : (int)syscall(SYS_getppid) * 0;
}

static int allocate(void)
{
	allocations = 0;
	return stilb_prof_thread_begin("main") == 0 && allocations == 2 ? 0 : 3; /* the list of threads, the ring */
}

static void others_would_be_seen(void **state)
{
	(void)state;
	assert_int_equal(in_a_child(make_a_system_call), -SIGSYS);
	assert_int_equal(in_a_child(allocate), 0);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(others_would_be_seen),
		cmocka_unit_test(recording_stays_in_the_program),
	};
	if (!prof_clock_is_tsc()) {
		printf("skipped: without an invariant TSC the kernel may be asked for the time\n");
		return 77;
	}
	return cmocka_run_group_tests(tests, NULL, NULL);
}
