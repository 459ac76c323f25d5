/* Traces: frames, the choice of frames, times, errors. */
#include "test_prof_capture.h"

#include <errno.h>
#include <inttypes.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <sys/mman.h>
#include <time.h>

#include <cmocka.h>

/* ---- allocations that fail (the linker's --wrap) ------------------------------------------------------------------- */

static int fail_allocation = -1; /* so many succeed, then one fails; -1: never */

static bool allocation_fails(void)
{
	return fail_allocation >= 0 && fail_allocation-- == 0;
}

void *__real_malloc(size_t size);
void *__wrap_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__real_mmap(void *address, size_t size, int protection, int flags, int file, off_t offset);
void *__wrap_mmap(void *address, size_t size, int protection, int flags, int file, off_t offset);

void *__wrap_malloc(size_t size)
{
	return allocation_fails() ? NULL : __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size)
{
	return allocation_fails() ? NULL : __real_calloc(count, size);
}

void *__wrap_mmap(void *address, size_t size, int protection, int flags, int file, off_t offset)
{
	return allocation_fails() ? MAP_FAILED : __real_mmap(address, size, protection, flags, file, offset);
}

/* --------------------------------------------------------------------------------------------------------------------- */

static int begin_thread(void **state)
{
	(void)state;
	return stilb_prof_thread_begin("main");
}

static int shut_down(void **state)
{
	(void)state;
	fail_allocation = -1;
	stilb_prof_shutdown();
	return 0;
}

static void nothing_recorded_is_a_trace(void **state)
{
	(void)state;
	capture c;
	stilb_prof_shutdown();
	assert_trace(&c, 0);
	assert_int_equal(c.report.threads, 0);
	assert_int_equal(c.report.zones + c.report.frames + c.report.marks, 0);
	capture_finish(&c);
}

static void frames_and_marks(void **state)
{
	(void)state;
	capture c;
	for (int i = 0; i < 5; i++)
		stilb_prof_frame_mark();
	assert_trace(&c, 0);
	assert_int_equal(c.report.frames, 4);
	assert_int_equal(c.report.marks, 5);
	assert_non_null(strstr(c.text, "\"args\":{\"number\":4}"));
	capture_finish(&c);
}

static void the_last_frames_are_remembered(void **state)
{
	(void)state;
	capture c;
	for (int i = 0; i < 3000; i++)
		stilb_prof_frame_mark();
	assert_trace(&c, 0);
	assert_int_equal(c.report.marks, PROF_FRAMES_MAX - 1); /* the oldest may be about to be overwritten */
	assert_int_equal(c.report.frames, PROF_FRAMES_MAX - 2);
	assert_non_null(strstr(c.text, "\"args\":{\"number\":2999}"));
	assert_null(strstr(c.text, "\"args\":{\"number\":1976}"));
	capture_finish(&c);
}

static void last_frames_leaves_the_rest_out(void **state)
{
	(void)state;
	static const uint32_t asked[] = {1, 3, 9, 10, 1000, 0};
	static const uint32_t frames[] = {1, 3, 9, 9, 9, 9}; /* ten marks make nine whole frames */
	static const uint32_t zones[] = {4, 8, 20, 21, 21, 21};
	{
		PROFILE("before the first");
	}
	for (int i = 0; i < 10; i++) {
		stilb_prof_frame_mark();
		PROFILE("outer");
		PROFILE("inner");
	}
	for (size_t i = 0; i < sizeof asked / sizeof asked[0]; i++) {
		capture c;
		assert_trace(&c, asked[i]);
		assert_int_equal(c.report.frames, frames[i]);
		assert_int_equal(c.report.marks, frames[i] + 1);
		assert_int_equal(c.report.zones, zones[i]);
		capture_finish(&c);
	}
}

/* ts and dur of the first zone of that name, in ns. */
static bool find_zone(const char *text, const char *name, uint64_t *ts, uint64_t *dur)
{
	char key[64];
	unsigned long long part[4];
	snprintf(key, sizeof key, ",\"name\":\"%s\"}", name);
	const char *at = strstr(text, key);
	while (at != NULL && at > text && *at != '\n')
		at--;
	if (at == NULL ||
	    sscanf(strstr(at, "\"ts\""), "\"ts\":%llu.%llu,\"dur\":%llu.%llu", &part[0], &part[1], &part[2], &part[3]) != 4)
		return false;
	*ts = part[0] * 1000 + part[1];
	*dur = part[2] * 1000 + part[3];
	return true;
}

/* A zone's length lies between those of two intervals, one inside and one around it. */
static void times_are_true(void **state)
{
	(void)state;
	uint64_t t[4], ts, dur;
	capture c;
	t[0] = stilb_prof_clock_monotonic();
	{
		PROFILE("sleep");
		t[1] = stilb_prof_clock_monotonic();
		nanosleep(&(struct timespec){.tv_nsec = 20000000}, NULL);
		t[2] = stilb_prof_clock_monotonic();
	}
	t[3] = stilb_prof_clock_monotonic();
	assert_trace(&c, 0);
	assert_true(find_zone(c.text, "sleep", &ts, &dur));
	capture_finish(&c);
	assert_true(t[2] - t[1] >= 20000000);
	assert_in_range(dur, t[2] - t[1] - 2000, t[3] - t[0] + 2000);
}

static void threads_stand_in_order(void **state)
{
	(void)state;
	capture c;
	stilb_prof_thread_end();
	assert_int_equal(stilb_prof_thread_begin("second"), 0);
	assert_trace(&c, 0);
	const char *frames = strstr(c.text, "\"tid\":1,\"name\":\"thread_sort_index\",\"args\":{\"sort_index\":1}");
	const char *main_thread = strstr(c.text, "\"tid\":2,\"name\":\"thread_name\",\"args\":{\"name\":\"main\"}");
	const char *second = strstr(c.text, "\"tid\":3,\"name\":\"thread_name\",\"args\":{\"name\":\"second\"}");
	assert_non_null(frames);
	assert_true(frames < main_thread);
	assert_true(main_thread < second);
	capture_finish(&c);
}

static void the_process_has_a_name(void **state)
{
	(void)state;
	capture c = {0};
	assert_int_equal(stilb_prof_trace_write(NULL, capture_write, &c), 0);
	assert_non_null(strstr(c.text, "\"process_name\",\"args\":{\"name\":\"test_prof_trace\"}"));
	assert_int_equal(trace_check_text(c.text, c.size, &c.report), 0);
	capture_finish(&c);
	const stilb_prof_trace_desc desc = {.process_name = "\"quoted\""};
	assert_int_equal(stilb_prof_trace_write(&desc, capture_write, &c), 0);
	assert_non_null(strstr(c.text, "\"process_name\",\"args\":{\"name\":\"\\\"quoted\\\"\"}"));
	capture_finish(&c);
}

/* ---- errors ----------------------------------------------------------------------------------------------------------- */

typedef struct full_disk {
	int room; /* calls that succeed */
	int after_error;
} full_disk;

static int full_disk_write(void *user, const void *data, size_t size)
{
	full_disk *disk = user;
	(void)data;
	(void)size;
	if (disk->room < 0)
		disk->after_error++;
	return disk->room-- > 0 ? 0 : -ENOSPC;
}

static void a_failed_write_is_returned(void **state)
{
	(void)state;
	int blocks = 0;
	for (int i = 0; i < 1000; i++) {
		stilb_prof_frame_mark();
		PROFILE("zone");
	}
	for (;; blocks++) {
		full_disk disk = {.room = blocks};
		const int error = stilb_prof_trace_write(NULL, full_disk_write, &disk);
		if (error == 0) {
			assert_int_equal(disk.room, 0); /* all calls succeeded */
			break;
		}
		assert_int_equal(error, -ENOSPC);
		assert_int_equal(disk.after_error, 0);
	}
	assert_true(blocks > 3);
}

static void no_memory_for_a_trace(void **state)
{
	(void)state;
	int failures = 0;
	for (int i = 0; i < 100; i++) {
		PROFILE("zone");
	}
	for (;; failures++) {
		full_disk disk = {.room = 1000};
		fail_allocation = failures;
		const int error = stilb_prof_trace_write(NULL, full_disk_write, &disk);
		const bool failed = fail_allocation < 0;
		fail_allocation = -1;
		if (!failed)
			break;
		assert_int_equal(error, -ENOMEM);
	}
	assert_int_equal(failures, 5); /* the trace, the list, events, zones, order */
}

static void no_memory_for_a_ring(void **state)
{
	(void)state;
	stilb_prof_shutdown();
	fail_allocation = 0;
	assert_int_equal(stilb_prof_thread_begin("main"), -ENOMEM);
	assert_null(stilb_prof_thread_ring);
	{
		PROFILE("unseen");
	}
	assert_int_equal(stilb_prof_thread_begin("main"), 0);
}

#define TRACE_TEST(f) cmocka_unit_test_setup_teardown(f, begin_thread, shut_down)

int main(void)
{
	const struct CMUnitTest tests[] = {
		TRACE_TEST(nothing_recorded_is_a_trace),
		TRACE_TEST(frames_and_marks),
		TRACE_TEST(the_last_frames_are_remembered),
		TRACE_TEST(last_frames_leaves_the_rest_out),
		TRACE_TEST(times_are_true),
		TRACE_TEST(threads_stand_in_order),
		TRACE_TEST(the_process_has_a_name),
		TRACE_TEST(a_failed_write_is_returned),
		TRACE_TEST(no_memory_for_a_trace),
		TRACE_TEST(no_memory_for_a_ring),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
