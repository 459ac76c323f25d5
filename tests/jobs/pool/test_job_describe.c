/* What the settings of a pool say about its threads, as the threads themselves and the kernel see it: name, stack, nice
 * value, CPUs. Settings that are out of range, and what the system refuses. */
#include "jobs/job_internal.h"
#include "tests/jobs/job_pool_fixture.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <sys/resource.h>
#include <unistd.h>

/* ---- a system that refuses; linked with -Wl,--wrap=setpriority --------------------------------------------------- */

static _Atomic bool refuse_nice;

int __real_setpriority(__priority_which_t which, id_t who, int value);
int __wrap_setpriority(__priority_which_t which, id_t who, int value);
int __wrap_setpriority(__priority_which_t which, id_t who, int value)
{
	if (!atomic_load_explicit(&refuse_nice, memory_order_relaxed))
		return __real_setpriority(which, who, value);
	errno = EACCES;
	return -1;
}

/* ---- what a thread sees of itself -------------------------------------------------------------------------------- */

enum { WORKERS = 12 };

typedef struct seen {
	char name[16];
	size_t stack_size;
	int nice;
	cpu_set_t cpus;
	counter there;
} seen;

static void look(void *data, uint32_t worker)
{
	seen *s = data;
	pthread_attr_t attributes;
	(void)worker;
	pthread_getname_np(pthread_self(), s->name, sizeof s->name);
	s->nice = getpriority(PRIO_PROCESS, 0);
	sched_getaffinity(0, sizeof s->cpus, &s->cpus);
	if (pthread_getattr_np(pthread_self(), &attributes) == 0) {
		pthread_attr_getstacksize(&attributes, &s->stack_size);
		pthread_attr_destroy(&attributes);
	}
	count_up(&s->there);
}

static stilb_job_pool *pool_of(const stilb_job_pool_desc *desc)
{
	stilb_job_pool *pool = NULL;
	assert_null(stilb_job_pool_desc_error(desc));
	assert_int_equal(stilb_job_pool_create(desc, &pool), 0);
	return pool;
}

/* What worker number `worker` of a pool sees, in s, and what it has been granted. */
static stilb_job_worker_info see(stilb_job_pool *pool, uint32_t worker, seen *s)
{
	stilb_job_worker_info info = {0};
	*s = (seen){0};
	stilb_job_pool_worker_info(pool, worker, &info);
	submit_pinned(pool, look, s, NULL, worker, 0);
	assert_true(await(&s->there, 1));
	return info;
}

/* ---- settings that are refused ----------------------------------------------------------------------------------- */

static void check_refused(const stilb_job_pool_desc *desc, const char *why)
{
	stilb_job_pool *pool = (stilb_job_pool *)&pool;
	assert_non_null(stilb_job_pool_desc_error(desc));
	assert_string_equal(stilb_job_pool_desc_error(desc), why);
	assert_int_equal(stilb_job_pool_create(desc, &pool), -EINVAL);
	assert_null(pool);
}

static void test_errors_name_what_is_wrong(void **state)
{
	(void)state;
	stilb_job_pool_desc zero = {0}, usual = stilb_job_pool_desc_default();
	assert_null(stilb_job_pool_desc_error(&zero));
	assert_null(stilb_job_pool_desc_error(&usual));
	static const uint32_t too_high[] = {0, STILB_JOB_MAX_CPUS};
	const struct {
		stilb_job_pool_desc desc;
		const char *why;
	} bad[] = {
		{{.worker_count = STILB_JOB_MAX_WORKERS + 1}, "worker_count is more than STILB_JOB_MAX_WORKERS"},
		{{.queue = (stilb_job_queue_kind)2}, "queue is not a stilb_job_queue_kind"},
		{{.affinity = (stilb_job_affinity)3}, "affinity is not a stilb_job_affinity"},
		{{.stack_size = 1}, "stack_size is less than PTHREAD_STACK_MIN"},
		{{.stack_size = (size_t)PTHREAD_STACK_MIN - 1}, "stack_size is less than PTHREAD_STACK_MIN"},
		{{.stack_size = SIZE_MAX}, "stack_size is more than PTRDIFF_MAX"},
		{{.nice = 40}, "nice is not in -39..39"},
		{{.nice = -40}, "nice is not in -39..39"},
		{{.cpu_count = 1}, "cpu_count is not 0, and cpus is NULL"},
		{{.cpu_count = STILB_JOB_MAX_CPUS + 1, .cpus = too_high}, "cpu_count is more than STILB_JOB_MAX_CPUS"},
		{{.cpu_count = 2, .cpus = too_high}, "cpus has a number that is not below STILB_JOB_MAX_CPUS"},
		{{.worker_count = 2, .affinity = STILB_JOB_AFFINITY_EACH, .cpu_count = 1, .cpus = too_high},
	     "affinity is EACH, and cpu_count is not worker_count"},
	};
	for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
		check_refused(&bad[i].desc, bad[i].why);
}

static void test_a_stack_that_the_system_refuses(void **state)
{
	(void)state;
	stilb_job_pool *pool = (stilb_job_pool *)&pool;
	stilb_job_pool_desc desc = {.worker_count = 2, .stack_size = PTRDIFF_MAX}; /* more than there are addresses */
	assert_int_equal(stilb_job_pool_create(&desc, &pool), -EAGAIN);
	assert_null(pool);
}

/* ---- name, stack, nice ------------------------------------------------------------------------------------------- */

static void check_names(const char *given, uint32_t worker, const char *expected)
{
	char name[64];
	seen s;
	snprintf(name, sizeof name, "%s", given);
	stilb_job_pool_desc desc = {.worker_count = WORKERS, .name = name};
	stilb_job_pool *pool = pool_of(&desc);
	memset(name, '!', sizeof name); /* it has been copied */
	see(pool, worker, &s);
	assert_string_equal(s.name, expected);
	stilb_job_pool_destroy(pool);
}

static void test_names(void **state)
{
	(void)state;
	check_names("", 1, "stilb-worker-1");
	check_names("loader", 1, "loader-1");
	check_names("loader", 12, "loader-12");
	check_names("abcdefghijklmnopqrstuvwxyz", 9, "abcdefghijklm-9");
	check_names("abcdefghijklmnopqrstuvwxyz", 12, "abcdefghijkl-12");
}

/* The first test, and in rising order: glibc may give a thread the larger stack of one that has ended. */
static void test_stack_sizes(void **state)
{
	(void)state;
	size_t page = (size_t)sysconf(_SC_PAGESIZE);
	for (size_t size = (size_t)1 << 19; size <= (size_t)1 << 25; size <<= 3) {
		seen s;
		stilb_job_pool_desc desc = {.worker_count = 2, .stack_size = size + 1};
		stilb_job_pool *pool = pool_of(&desc);
		for (uint32_t i = 1; i <= 2; i++) {
			see(pool, i, &s);
			assert_in_range(s.stack_size, size + page, TEST_TSAN ? 2 * size : size + page); /* it takes a part itself */
		}
		stilb_job_pool_destroy(pool);
	}
}

/* More of the nice value is always allowed. */
static void check_nice(int32_t more, int32_t expected, int error)
{
	seen s;
	stilb_job_pool_desc desc = {.worker_count = 2, .nice = more};
	stilb_job_pool *pool = pool_of(&desc);
	for (uint32_t i = 1; i <= 2; i++) {
		stilb_job_worker_info info = see(pool, i, &s);
		assert_int_equal(s.nice, expected);
		assert_int_equal(info.nice, expected);
		assert_int_equal(info.nice_error, error);
		assert_int_equal(info.affinity_error, 0);
	}
	stilb_job_pool_destroy(pool);
}

static void test_nice_values(void **state)
{
	(void)state;
	int32_t own = getpriority(PRIO_PROCESS, 0);
	check_nice(0, own, 0);
	check_nice(1, own < 19 ? own + 1 : 19, 0);
	check_nice(39, 19, 0);
	atomic_store_explicit(&refuse_nice, true, memory_order_relaxed);
	check_nice(-1, own, -EACCES);
	check_nice(0, own, 0); /* nothing was asked for */
	atomic_store_explicit(&refuse_nice, false, memory_order_relaxed);
	assert_int_equal(getpriority(PRIO_PROCESS, 0), own);
}

/* ---- CPUs -------------------------------------------------------------------------------------------------------- */

/* The first CPU of the process and the last, which may be the same one. */
static void find_cpus(cpu_set_t *all, uint32_t *first, uint32_t *last)
{
	assert_int_equal(sched_getaffinity(0, sizeof *all, all), 0);
	*first = CPU_SETSIZE;
	for (uint32_t i = 0; i < CPU_SETSIZE; i++)
		if (CPU_ISSET(i, all)) {
			*first = i < *first ? i : *first;
			*last = i;
		}
}

static bool is_only(const cpu_set_t *set, uint32_t cpu)
{
	return CPU_COUNT(set) == 1 && CPU_ISSET(cpu, set);
}

static void test_workers_stay_on_the_cpus_of_the_list(void **state)
{
	(void)state;
	cpu_set_t all;
	seen s;
	sched_getaffinity(0, sizeof all, &all);
	uint32_t here = (uint32_t)sched_getcpu(); /* AUTO would choose any other */
	for (int i = STILB_JOB_AFFINITY_AUTO; i <= STILB_JOB_AFFINITY_NONE; i++) {
		stilb_job_pool_desc desc = {
			.worker_count = 3, .affinity = (stilb_job_affinity)i, .cpus = (uint32_t[]){here, here}, .cpu_count = 2};
		stilb_job_pool *pool = pool_of(&desc);
		for (uint32_t worker = 1; worker <= 3; worker++) {
			assert_int_equal(see(pool, worker, &s).affinity_error, 0);
			assert_true(is_only(&s.cpus, here));
		}
		assert_true(pool->oversubscribed);
		stilb_job_pool_destroy(pool);
	}
	cpu_set_t after;
	sched_getaffinity(0, sizeof after, &after);
	assert_true(CPU_EQUAL(&all, &after)); /* the owner's mask is its own */
}

static void test_workers_share_a_list(void **state)
{
	(void)state;
	cpu_set_t all, both;
	uint32_t first = 0, last = 0;
	seen s;
	find_cpus(&all, &first, &last);
	CPU_ZERO(&both);
	CPU_SET(first, &both);
	CPU_SET(last, &both);
	stilb_job_pool_desc desc = {.worker_count = 4, .cpus = (uint32_t[]){first, last}, .cpu_count = 2};
	stilb_job_pool *pool = pool_of(&desc); /* AUTO binds two workers at most, and the others share both CPUs */
	for (uint32_t worker = 3; worker <= 4; worker++) {
		see(pool, worker, &s);
		assert_true(CPU_EQUAL(&s.cpus, &both));
	}
	stilb_job_pool_destroy(pool);
	desc.affinity = STILB_JOB_AFFINITY_NONE;
	pool = pool_of(&desc);
	for (uint32_t worker = 1; worker <= 4; worker++) {
		see(pool, worker, &s);
		assert_true(CPU_EQUAL(&s.cpus, &both));
	}
	stilb_job_pool_destroy(pool);
}

static void test_a_cpu_for_each_worker(void **state)
{
	(void)state;
	cpu_set_t all;
	uint32_t first = 0, last = 0;
	seen s;
	find_cpus(&all, &first, &last);
	uint32_t cpus[] = {last, first, last, STILB_JOB_MAX_CPUS - 1};
	stilb_job_pool_desc desc = {.worker_count = 4, .affinity = STILB_JOB_AFFINITY_EACH, .cpus = cpus, .cpu_count = 4};
	stilb_job_pool *pool = pool_of(&desc);
	cpus[0] = cpus[1] = cpus[2] = STILB_JOB_MAX_CPUS - 1; /* they have been copied */
	assert_int_equal(see(pool, 1, &s).affinity_error, 0);
	assert_true(is_only(&s.cpus, last));
	assert_int_equal(see(pool, 2, &s).affinity_error, 0);
	assert_true(is_only(&s.cpus, first));
	assert_int_equal(see(pool, 3, &s).affinity_error, 0);
	assert_true(is_only(&s.cpus, last));
	assert_int_equal(see(pool, 4, &s).affinity_error, -EINVAL); /* no machine has this CPU */
	assert_true(CPU_EQUAL(&s.cpus, &all));
	stilb_job_pool_destroy(pool);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_stack_sizes),
		cmocka_unit_test(test_errors_name_what_is_wrong),
		cmocka_unit_test(test_a_stack_that_the_system_refuses),
		cmocka_unit_test(test_names),
		cmocka_unit_test(test_nice_values),
		cmocka_unit_test(test_workers_stay_on_the_cpus_of_the_list),
		cmocka_unit_test(test_workers_share_a_list),
		cmocka_unit_test(test_a_cpu_for_each_worker),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
