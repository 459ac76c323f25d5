/* base: results and their messages, log lines, memory, hash and random numbers, time and CPU. */
#include "base/base.h"
#include "support/test.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <threads.h>
#include <unistd.h>

/* ---- results ----------------------------------------------------------------------------------------------------- */

static void test_fail_keeps_result_and_line(void **state)
{
	(void)state;
	assert_int_equal(stilb_fail(STILB_ERROR_FILE, "cannot read '%s': %d", "a.png", 5), STILB_ERROR_FILE);
	assert_string_equal(stilb_error_message(), "cannot read 'a.png': 5");
	assert_int_equal(stilb_fail(STILB_ERROR_DEVICE, "%s; try again", stilb_error_message()), STILB_ERROR_DEVICE);
	assert_string_equal(stilb_error_message(), "cannot read 'a.png': 5; try again");
}

static void test_fail_cuts_long_lines(void **state)
{
	(void)state;
	char *text = malloc(100001);
	assert_non_null(text);
	memset(text, 'x', 100000);
	text[100000] = '\0';
	stilb_fail(STILB_ERROR_FILE, "begin %s", text);
	size_t length = strlen(stilb_error_message());
	assert_true(length > 500 && length < 100000);
	assert_memory_equal(stilb_error_message(), "begin xxx", 9);
	free(text);
}

static int other_thread(void *out)
{
	char **messages = out;
	static _Thread_local char first[16];
	snprintf(first, sizeof first, "[%s]", stilb_error_message());
	messages[0] = strdup(first);
	stilb_fail(STILB_ERROR_MEMORY, "theirs");
	messages[1] = strdup(stilb_error_message());
	return 0;
}

static void test_message_is_the_threads_own(void **state)
{
	(void)state;
	char *messages[2] = {NULL, NULL};
	thrd_t thread;
	stilb_fail(STILB_ERROR_FILE, "mine");
	assert_int_equal(thrd_create(&thread, other_thread, messages), thrd_success);
	thrd_join(thread, NULL);
	assert_string_equal(messages[0], "[]");
	assert_string_equal(messages[1], "theirs");
	assert_string_equal(stilb_error_message(), "mine");
	free(messages[0]);
	free(messages[1]);
}

static void test_result_text(void **state)
{
	(void)state;
	assert_string_equal(stilb_result_text(STILB_OK), "ok");
	assert_string_equal(stilb_result_text(STILB_ERROR_DEVICE_LOST), "device lost");
	for (int a = STILB_OK; a <= STILB_ERROR_GIVEN_UP; a++)
		for (int b = STILB_OK; b < a; b++)
			assert_string_not_equal(stilb_result_text((stilb_result)a), stilb_result_text((stilb_result)b));
	assert_string_equal(stilb_result_text((stilb_result)999), "unknown result");
	assert_string_equal(stilb_result_text((stilb_result)-1), "unknown result");
}

/* ---- log --------------------------------------------------------------------------------------------------------- */

static void test_version(void **state)
{
	(void)state;
	char text[32];
	snprintf(text, sizeof text, "%d.%d.%d", STILB_VERSION_MAJOR, STILB_VERSION_MINOR, STILB_VERSION_PATCH);
	assert_string_equal(STILB_VERSION, text);
	assert_string_equal(stilb_version(), text);
}

/* Returns the text that stilb_log(text) writes to stderr. */
static size_t logged(const char *text, char *out, size_t size)
{
	FILE *file = tmpfile();
	assert_non_null(file);
	fflush(stderr);
	int kept = dup(STDERR_FILENO);
	dup2(fileno(file), STDERR_FILENO);
	stilb_log("%s", text);
	fflush(stderr);
	dup2(kept, STDERR_FILENO);
	close(kept);
	rewind(file);
	size_t length = fread(out, 1, size - 1, file);
	out[length] = '\0';
	fclose(file);
	return length;
}

typedef struct lines {
	uint32_t count;
	bool open; /* the sink may be called */
	char last[64];
} lines;

static void take_line(void *user, const char *line)
{
	lines *l = user;
	l->count++;
	assert_true(l->open);
	snprintf(l->last, sizeof l->last, "%s", line);
}

static void test_log_goes_to_the_program(void **state)
{
	(void)state;
	char out[256];
	lines l = {.open = true};
	stilb_log_set(take_line, &l);
	assert_int_equal(logged("no\nGPU", out, sizeof out), 0);
	assert_int_equal(l.count, 1);
	assert_string_equal(l.last, "no?GPU");
	stilb_log_set(NULL, NULL);
	assert_int_equal(logged("no GPU", out, sizeof out), strlen("stilb: no GPU\n"));
	assert_int_equal(l.count, 1);
}

#define LOGGED_LINES 2000u

static int log_many(void *data)
{
	(void)data;
	for (uint32_t i = 0; i < LOGGED_LINES; i++)
		stilb_log("line %u", i);
	return 0;
}

/* While another thread logs, each line goes to one of two sinks, and none to a sink that has been replaced. */
static void test_a_replaced_sink_is_quiet(void **state)
{
	(void)state;
	lines sinks[2] = {{.open = true}, {.open = true}};
	thrd_t thread;
	stilb_log_set(take_line, &sinks[0]);
	assert_int_equal(thrd_create(&thread, log_many, NULL), thrd_success);
	for (uint32_t i = 1; i <= 200; i++) {
		sinks[i % 2].open = true;
		stilb_log_set(take_line, &sinks[i % 2]);
		sinks[(i + 1) % 2].open = false;
	}
	assert_int_equal(thrd_join(thread, NULL), thrd_success);
	stilb_log_set(NULL, NULL);
	assert_int_equal(sinks[0].count + sinks[1].count, LOGGED_LINES);
}

static void test_log_is_one_line(void **state)
{
	(void)state;
	char out[8192], text[5001];
	logged("no GPU", out, sizeof out);
	assert_string_equal(out, "stilb: no GPU\n");
	logged("a\nb\tc\033[31m\x7f d\xc3\xa9", out, sizeof out);
	assert_string_equal(out, "stilb: a?b?c?[31m? d\xc3\xa9\n");
	memset(text, 'y', 5000);
	text[5000] = '\0';
	size_t length = logged(text, out, sizeof out);
	assert_true(length > 1000);
	assert_ptr_equal(strchr(out, '\n'), out + length - 1); /* cut, with a newline at its end */
}

/* ---- memory ------------------------------------------------------------------------------------------------------ */

static void test_memory_alloc(void **state)
{
	(void)state;
	const size_t counts[][2] = {{1, 1}, {3, 7}, {128, 1}, {129, 1}, {1000, 24}, {0, 8}, {8, 0}};
	for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
		unsigned char *memory = stilb_memory_alloc(counts[i][0], counts[i][1]);
		assert_non_null(memory);
		assert_int_equal((uintptr_t)memory % STILB_CACHE_LINE, 0);
		memset(memory, 0xa5, counts[i][0] * counts[i][1]); /* the address sanitizer watches the end */
		free(memory);
	}
}

/* Threads that cannot be started are a lack of memory or of threads. */
static void test_threads_that_do_not_start(void **state)
{
	(void)state;
	assert_false(stilb_memory_is_scarce(1 << 20));
	assert_true(stilb_memory_is_scarce(SIZE_MAX / 2)); /* more than the address space */
	assert_int_equal(stilb_fail_threads(3, EPERM), STILB_ERROR_THREAD);
	assert_non_null(strstr(stilb_error_message(), "cannot start 3 threads: "));
	assert_int_equal(stilb_fail_threads(1, EAGAIN), STILB_ERROR_THREAD); /* there is memory for a stack */
	assert_non_null(strstr(stilb_error_message(), "cannot start 1 thread: "));
	assert_int_equal(stilb_fail_threads(UINT32_MAX, EAGAIN), STILB_ERROR_MEMORY);
	assert_int_equal(stilb_fail_threads(1, ENOMEM), STILB_ERROR_MEMORY);
	assert_non_null(strstr(stilb_error_message(), "no memory for 1 thread; try fewer with --workers"));
}

static void test_memory_alloc_refuses_overflow(void **state)
{
	(void)state;
	const size_t counts[][2] = {
		{SIZE_MAX, 2},
		{SIZE_MAX / 2 + 1, 2},
		{(size_t)1 << 32, (size_t)1 << 32},
		{SIZE_MAX, 1},
		{SIZE_MAX - STILB_CACHE_LINE + 1, 1},
		{1, SIZE_MAX},
		{SIZE_MAX / 64 + 2, 64}, /* wraps round to a small number */
	};
	for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
		assert_null(stilb_memory_alloc(counts[i][0], counts[i][1]));
}

/* ---- hash and random numbers ------------------------------------------------------------------------------------- */

static void floats_as_text(void **state)
{
	(void)state;
	static const struct {
		float value;
		const char *text;
	} rows[] = {{0.1f, "0.1"},
	            {-13.22f, "-13.22"},
	            {0.0f, "0"},
	            {1.0f / 3.0f, "0.33333334"},
	            {16777217.0f, "16777216"},
	            {1e-45f, "1.4013e-45"},
	            {INFINITY, "inf"},
	            {-1e30f, "-1e+30"},
	            {0.100000024f, "0.100000024"}};
	char text[STILB_FLOAT_TEXT];
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		stilb_float_text(rows[i].value, text);
		assert_string_equal(text, rows[i].text);
		assert_true(strtof(text, NULL) == rows[i].value);
	}
	stilb_float_text(NAN, text);
	assert_non_null(strstr(text, "nan"));
}

/* The vectors are those of the FNV reference: draft-eastlake-fnv, appendix C. */
static void test_hash_known_values(void **state)
{
	(void)state;
	assert_int_equal(STILB_FNV1A64_START, 0xcbf29ce484222325u);
	assert_int_equal(stilb_hash_fnv1a64(STILB_FNV1A64_START, "", 0), 0xcbf29ce484222325u);
	assert_int_equal(stilb_hash_fnv1a64(STILB_FNV1A64_START, "a", 1), 0xaf63dc4c8601ec8cu);
	assert_int_equal(stilb_hash_fnv1a64(STILB_FNV1A64_START, "b", 1), 0xaf63df4c8601f1a5u);
	assert_int_equal(stilb_hash_fnv1a64(STILB_FNV1A64_START, "foobar", 6), 0x85944171f73967e8u);
	uint64_t half = stilb_hash_fnv1a64(STILB_FNV1A64_START, "foo", 3);
	assert_int_equal(stilb_hash_fnv1a64(half, "bar", 3), 0x85944171f73967e8u);
}

/* splitmix64 started with a seed s gives random_u64(s, 0), (s, 1), ...; the first outputs for the seeds 0 and 1234567
 * are widely published. */
static void test_random_known_values(void **state)
{
	(void)state;
	static const uint64_t zero[] = {0xe220a8397b1dcdafu, 0x6e789e6aa1b965f4u, 0x06c45d188009454fu};
	static const uint64_t other[] = {6457827717110365317u, 3203168211198807973u, 9817491932198370423u,
	                                 4593380528125082431u, 16408922859458223821u};
	for (uint64_t i = 0; i < 3; i++)
		assert_int_equal(stilb_random_u64(0, i), zero[i]);
	for (uint64_t i = 0; i < 5; i++)
		assert_int_equal(stilb_random_u64(1234567, i), other[i]);
}

static void test_random_float_is_uniform(void **state)
{
	(void)state;
	enum { N = 200000, BINS = 20 };
	int bins[BINS] = {0};
	double sum = 0.0;
	for (uint64_t i = 0; i < N; i++) {
		float x = stilb_random_float(7, i);
		assert_true(x >= 0.0f && x < 1.0f);
		bins[(int)(x * BINS)]++;
		sum += (double)x;
	}
	assert_true(sum / N > 0.497 && sum / N < 0.503); /* 4.6 standard deviations */
	double chi2 = 0.0;
	for (int i = 0; i < BINS; i++)
		chi2 += (bins[i] - N / BINS) * (double)(bins[i] - N / BINS) / (N / BINS);
	assert_true(chi2 > 4.0 && chi2 < 50.0); /* 19 degrees of freedom: both tails below 1e-4 */
}

/* ---- time and CPU ------------------------------------------------------------------------------------------------ */

static void test_time_runs(void **state)
{
	(void)state;
	uint64_t start = stilb_time_ns(), last = start;
	for (int i = 0; i < 1000; i++) {
		uint64_t now = stilb_time_ns();
		assert_true(now >= last);
		last = now;
	}
	usleep(2000);
	uint64_t passed = stilb_time_ns() - start;
	assert_true(passed >= 2000000u && passed < 60000000000u);
}

static void test_cpu_query(void **state)
{
	(void)state;
	stilb_cpu_features cpu = stilb_cpu_query();
	size_t length = strnlen(cpu.name, sizeof cpu.name);
	assert_true(length > 0 && length < sizeof cpu.name);
	assert_true(cpu.name[0] != ' ' && cpu.name[length - 1] != ' ');
	assert_true(cpu.sse42 || !cpu.avx2); /* no CPU has the later set alone */
	assert_true(cpu.avx2 || !cpu.avx512);
}

static void test_cpu_isa(void **state)
{
	(void)state;
	stilb_isa widest = stilb_cpu_widest_isa(), isa;
	stilb_cpu_features cpu = stilb_cpu_query();
	assert_true(widest == STILB_ISA_SCALAR || cpu.avx2);
	assert_true(widest != STILB_ISA_AVX512 || cpu.avx512);
	unsetenv("STILB_ISA");
	assert_int_equal(stilb_cpu_isa(&isa), STILB_OK);
	assert_int_equal(isa, widest);
	for (stilb_isa wanted = STILB_ISA_SCALAR; wanted < STILB_ISA_COUNT; wanted++) {
		setenv("STILB_ISA", stilb_isa_text(wanted), 1);
		assert_int_equal(stilb_cpu_isa(&isa), wanted <= widest ? STILB_OK : STILB_ERROR_ARGUMENT);
		assert_true(isa == wanted);
		if (wanted > widest)
			assert_non_null(strstr(stilb_error_message(), stilb_isa_text(widest)));
	}
	const char *const wrong[] = {"", "AVX2", "avx", "avx5120", "sse"};
	for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
		setenv("STILB_ISA", wrong[i], 1);
		assert_int_equal(stilb_cpu_isa(&isa), STILB_ERROR_ARGUMENT);
		assert_non_null(strstr(stilb_error_message(), wrong[i]));
		assert_non_null(strstr(stilb_error_message(), "scalar, avx2 or avx512"));
	}
	unsetenv("STILB_ISA");
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(floats_as_text),
		cmocka_unit_test(test_fail_keeps_result_and_line),
		cmocka_unit_test(test_fail_cuts_long_lines),
		cmocka_unit_test(test_message_is_the_threads_own),
		cmocka_unit_test(test_result_text),
		cmocka_unit_test(test_threads_that_do_not_start),
		cmocka_unit_test(test_version),
		cmocka_unit_test(test_log_is_one_line),
		cmocka_unit_test(test_log_goes_to_the_program),
		cmocka_unit_test(test_a_replaced_sink_is_quiet),
		cmocka_unit_test(test_memory_alloc),
		cmocka_unit_test(test_memory_alloc_refuses_overflow),
		cmocka_unit_test(test_hash_known_values),
		cmocka_unit_test(test_random_known_values),
		cmocka_unit_test(test_random_float_is_uniform),
		cmocka_unit_test(test_time_runs),
		cmocka_unit_test(test_cpu_query),
		cmocka_unit_test(test_cpu_isa),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
