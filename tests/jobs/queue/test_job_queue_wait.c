/*
 * Calls that wait: stilb_job_queue_pop_wait and push_wait for both kinds of the library, and stilb_job_spsc_pop_wait,
 * with real threads. test_job_model_wait checks all interleavings.
 */
#include <errno.h>
#include <linux/futex.h>
#include <linux/membarrier.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "jobs/job_queue_kinds.h"
#include "jobs/job_spsc.h"
#include "support/test.h"

enum { PUSHERS = 3, POPPERS = 3, THREADS = PUSHERS + POPPERS, EACH = TEST_TSAN || TEST_EMULATED ? 2000 : 20000 };
#define MS UINT64_C(1000000) /* nanoseconds */
#define LONG (60000 * MS)    /* ends a test that hangs */

static uint64_t clock_ns(clockid_t clock)
{
	struct timespec now;
	clock_gettime(clock, &now);
	return (uint64_t)now.tv_sec * 1000 * MS + (uint64_t)now.tv_nsec;
}

/* ---- the kernel ------------------------------------------------------------------------------------------------ */

/* Linked with -Wl,--wrap=syscall. What the kernel refuses or forgets, and the number of sleeps it was asked for.
 * Relaxed, all: set and read while no other thread of the test runs, or waited for. */
static _Atomic bool membarrier_refused, wakes_forgotten;
static _Atomic uint32_t sleeps, limited_sleeps;

long __real_syscall(long number, ...);
long __wrap_syscall(long number, ...);

long __wrap_syscall(long number, ...)
{
	long argument[6];
	va_list list;
	va_start(list, number);
	for (size_t i = 0; i < 6; i++)
		argument[i] = va_arg(list, long); /* the system call ignores those that it does not have */
	va_end(list);
	if (number == SYS_membarrier && atomic_load_explicit(&membarrier_refused, memory_order_relaxed)) {
		errno = EPERM;
		return -1;
	}
	if (number == SYS_futex && argument[1] == FUTEX_WAIT_PRIVATE)
		atomic_fetch_add_explicit(argument[3] ? &limited_sleeps : &sleeps, 1, memory_order_relaxed);
	if (number == SYS_futex && argument[1] == FUTEX_WAKE_PRIVATE &&
	    atomic_load_explicit(&wakes_forgotten, memory_order_relaxed))
		return 0;
	return __real_syscall(number, argument[0], argument[1], argument[2], argument[3], argument[4], argument[5]);
}

static void set_kernel(bool refuse_membarrier, bool forget_wakes)
{
	atomic_store_explicit(&membarrier_refused, refuse_membarrier, memory_order_relaxed);
	atomic_store_explicit(&wakes_forgotten, forget_wakes, memory_order_relaxed);
	atomic_store_explicit(&sleeps, 0, memory_order_relaxed);
	atomic_store_explicit(&limited_sleeps, 0, memory_order_relaxed);
}

static void await_sleeps(uint32_t count)
{
	while (atomic_load_explicit(&sleeps, memory_order_relaxed) +
	           atomic_load_explicit(&limited_sleeps, memory_order_relaxed) <
	       count)
		nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
}

/* ---- one thread ------------------------------------------------------------------------------------------------ */

static int item;

static void test_time_is_over(void **state)
{
	(void)state;
	for (size_t kind = 0; kind < QUEUE_KINDS_OURS; kind++) {
		stilb_job_queue *queue = queue_kind_create(&queue_kinds[kind], queue_kinds[kind].bounded ? 1 : SIZE_MAX, 2);
		void *popped = NULL;
		uint64_t begin = clock_ns(CLOCK_MONOTONIC);
		assert_int_equal(stilb_job_queue_pop_wait(queue, &popped, 0, 0), -ETIMEDOUT);
		assert_int_equal(stilb_job_queue_pop_wait(queue, &popped, 0, 1), -ETIMEDOUT);
		assert_int_equal(stilb_job_queue_pop_wait(queue, &popped, 0, 3 * MS), -ETIMEDOUT);
		assert_true(clock_ns(CLOCK_MONOTONIC) - begin >= 3 * MS);
		assert_null(popped);
		assert_int_equal(stilb_job_queue_push_wait(queue, NULL, 0, UINT64_MAX), -EINVAL);
		assert_int_equal(stilb_job_queue_push_wait(queue, &item, 0, UINT64_MAX), 0);
		if (queue_kinds[kind].bounded) {
			begin = clock_ns(CLOCK_MONOTONIC);
			assert_int_equal(stilb_job_queue_push_wait(queue, &item, 1, 0), -ETIMEDOUT);
			assert_int_equal(stilb_job_queue_push_wait(queue, &item, 1, 3 * MS), -ETIMEDOUT);
			assert_true(clock_ns(CLOCK_MONOTONIC) - begin >= 3 * MS);
		}
		stilb_job_queue_close(queue);
		assert_int_equal(stilb_job_queue_push_wait(queue, &item, 1, UINT64_MAX), -EPIPE);
		assert_int_equal(stilb_job_queue_pop_wait(queue, &popped, 0, UINT64_MAX), 0); /* what is left comes first */
		assert_ptr_equal(popped, &item);
		assert_int_equal(stilb_job_queue_pop_wait(queue, &popped, 0, UINT64_MAX), -EPIPE);
		stilb_job_queue_destroy(queue);
	}
}

/* ---- several threads -------------------------------------------------------------------------------------------- */

typedef struct member {
	pthread_t thread;
	stilb_job_queue *queue;
	uint32_t number;
	uint64_t timeout_ns;
	uint32_t *items; /* plain: the thread sanitizer checks that an item's content is seen by the one who pops it */
	uint64_t count, sum, cpu_ns;
	int error; /* of the last call */
} member;

static void *push_each(void *data)
{
	member *self = data;
	for (uint32_t i = 0; i < EACH && self->error == 0; i++) {
		self->items[i] = i + 1;
		self->error = stilb_job_queue_push_wait(self->queue, &self->items[i], self->number, self->timeout_ns);
		self->count += self->error == 0;
		if (i % 1000 == 999)
			nanosleep(&(struct timespec){.tv_nsec = 100000}, NULL); /* the poppers fall asleep */
	}
	return NULL;
}

static void *pop_each(void *data)
{
	member *self = data;
	void *popped;
	while ((self->error = stilb_job_queue_pop_wait(self->queue, &popped, self->number, self->timeout_ns)) == 0) {
		self->count++;
		self->sum += *(uint32_t *)popped;
		if (self->count % 1000 == 999)
			nanosleep(&(struct timespec){.tv_nsec = 100000}, NULL); /* the pushers fall asleep */
	}
	self->cpu_ns = clock_ns(CLOCK_THREAD_CPUTIME_ID);
	return NULL;
}

static void start(member *members, uint32_t first, uint32_t end, stilb_job_queue *queue, void *(*run)(void *))
{
	for (uint32_t i = first; i < end; i++) {
		members[i] = (member){.queue = queue, .number = i, .timeout_ns = LONG, .items = members[i].items};
		assert_int_equal(pthread_create(&members[i].thread, NULL, run, &members[i]), 0);
	}
}

/* Every item arrives, although threads of both ends sleep again and again; then close ends the poppers. */
static void pass_all(const queue_kind *kind, size_t capacity)
{
	static uint32_t items[PUSHERS][EACH];
	stilb_job_queue *queue = queue_kind_create(kind, kind->bounded ? capacity : SIZE_MAX, THREADS);
	member members[THREADS] = {0};
	for (uint32_t i = 0; i < PUSHERS; i++)
		members[i].items = items[i];
	start(members, 0, PUSHERS, queue, push_each);
	start(members, PUSHERS, THREADS, queue, pop_each);
	for (uint32_t i = 0; i < PUSHERS; i++) {
		pthread_join(members[i].thread, NULL);
		assert_int_equal(members[i].error, 0);
	}
	stilb_job_queue_close(queue);
	uint64_t count = 0, sum = 0;
	for (uint32_t i = PUSHERS; i < THREADS; i++) {
		pthread_join(members[i].thread, NULL);
		assert_int_equal(members[i].error, -EPIPE);
		count += members[i].count;
		sum += members[i].sum;
	}
	assert_int_equal(count, (uint64_t)PUSHERS * EACH);
	assert_int_equal(sum, (uint64_t)PUSHERS * EACH * (EACH + 1) / 2);
	stilb_job_queue_destroy(queue);
}

static void test_every_item_arrives(void **state)
{
	(void)state;
	set_kernel(false, false);
	for (size_t kind = 0; kind < QUEUE_KINDS_OURS; kind++) {
		pass_all(&queue_kinds[kind], SIZE_MAX);
		if (queue_kinds[kind].bounded)
			pass_all(&queue_kinds[kind], 4);
	}
}

/* Threads that wait for an item sleep and use no CPU; close ends them all. */
static void test_close_ends_pops(void **state)
{
	(void)state;
	for (size_t kind = 0; kind < QUEUE_KINDS_OURS; kind++) {
		set_kernel(false, false);
		stilb_job_queue *queue = queue_kind_create(&queue_kinds[kind], SIZE_MAX, THREADS);
		member members[THREADS] = {0};
		start(members, 0, POPPERS, queue, pop_each);
		await_sleeps(POPPERS);
		nanosleep(&(struct timespec){.tv_nsec = 100 * (long)MS}, NULL);
		stilb_job_queue_close(queue);
		for (uint32_t i = 0; i < POPPERS; i++) {
			pthread_join(members[i].thread, NULL);
			assert_int_equal(members[i].error, -EPIPE);
			assert_true(members[i].cpu_ns < 20 * MS); /* some 0.1 ms; a thread that spins uses 50 ms and more */
		}
		stilb_job_queue_destroy(queue);
	}
}

static void test_close_ends_pushes(void **state)
{
	(void)state;
	static uint32_t items[PUSHERS][EACH];
	for (size_t kind = 0; kind < QUEUE_KINDS_OURS; kind++) {
		set_kernel(false, false);
		stilb_job_queue *queue = queue_kind_create(&queue_kinds[kind], 2, THREADS);
		member members[THREADS] = {0};
		for (uint32_t i = 0; i < PUSHERS; i++)
			members[i].items = items[i];
		start(members, 0, PUSHERS, queue, push_each);
		await_sleeps(PUSHERS);
		stilb_job_queue_close(queue);
		uint64_t count = 0;
		for (uint32_t i = 0; i < PUSHERS; i++) {
			pthread_join(members[i].thread, NULL);
			assert_int_equal(members[i].error, -EPIPE);
			count += members[i].count;
		}
		assert_int_equal(count, 2);
		stilb_job_queue_destroy(queue);
	}
}

/* With membarrier a sleep without timeout has no limit; without it, a push may fail to wake. Here all of them do, and
 * the sleeps end nevertheless. */
static void test_without_membarrier(void **state)
{
	(void)state;
	static uint32_t number = 7;
	for (int refused = 0; refused <= 1; refused++) {
		set_kernel(refused, refused);
		stilb_job_queue *queue = queue_kind_create(&queue_kinds[0], SIZE_MAX, THREADS);
		member members[THREADS] = {0};
		members[0] = (member){.queue = queue, .timeout_ns = UINT64_MAX};
		assert_int_equal(pthread_create(&members[0].thread, NULL, pop_each, &members[0]), 0);
		await_sleeps(1);
		bool limited = atomic_load_explicit(&limited_sleeps, memory_order_relaxed) > 0;
		assert_int_equal(stilb_job_queue_push(queue, &number, 1), 0);
		stilb_job_queue_close(queue);
		pthread_join(members[0].thread, NULL);
		assert_int_equal(members[0].sum, 7);
		bool has_membarrier = __real_syscall(SYS_membarrier, MEMBARRIER_CMD_PRIVATE_EXPEDITED, 0, 0) == 0;
		assert_int_equal(limited, refused || !has_membarrier);
		stilb_job_queue_destroy(queue);
	}
	set_kernel(false, false);
}

/* ---- one producer, one consumer --------------------------------------------------------------------------------- */

static void *spsc_push_each(void *data)
{
	static uint32_t items[EACH];
	await_sleeps(1); /* the consumer finds nothing until then */
	for (uint32_t i = 0; i < EACH; i++) {
		items[i] = i;
		if (stilb_job_spsc_push(data, &items[i]) != 0)
			break;
		if (i % 1000 == 999)
			nanosleep(&(struct timespec){.tv_nsec = 100000}, NULL); /* the consumer falls asleep */
	}
	stilb_job_spsc_close(data);
	return NULL;
}

static void test_spsc(void **state)
{
	(void)state;
	set_kernel(false, false);
	stilb_job_spsc *queue;
	assert_int_equal(stilb_job_spsc_create(&queue), 0);
	void *popped = NULL;
	assert_int_equal(stilb_job_spsc_pop_wait(queue, &popped, 0), -ETIMEDOUT);
	assert_int_equal(stilb_job_spsc_pop_wait(queue, &popped, MS), -ETIMEDOUT);
	assert_null(popped);
	set_kernel(false, false); /* counts sleeps anew */
	pthread_t thread;
	assert_int_equal(pthread_create(&thread, NULL, spsc_push_each, queue), 0);
	uint32_t count = 0, wrong = 0;
	int error;
	while ((error = stilb_job_spsc_pop_wait(queue, &popped, LONG)) == 0)
		wrong += *(uint32_t *)popped != count++;
	assert_int_equal(error, -EPIPE);
	pthread_join(thread, NULL);
	assert_int_equal(count, EACH);
	assert_int_equal(wrong, 0);
	assert_true(atomic_load_explicit(&limited_sleeps, memory_order_relaxed) > 0); /* it has slept, with a timeout */
	stilb_job_spsc_destroy(queue);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_time_is_over),       cmocka_unit_test(test_every_item_arrives),
		cmocka_unit_test(test_close_ends_pops),    cmocka_unit_test(test_close_ends_pushes),
		cmocka_unit_test(test_without_membarrier), cmocka_unit_test(test_spsc),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
