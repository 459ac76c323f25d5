/* cmocka with the headers it wants before itself; and the sanitizers that a test is built with, so that it repeats less
 * of what gains nothing there. */
#ifndef SUPPORT_TEST_H
#define SUPPORT_TEST_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

/* 1 in builds with the address sanitizer, 1 in those with the thread sanitizer: a test takes two to twenty times as
 * long there. */
#if defined(__has_feature) /* clang */
#define TEST_ASAN __has_feature(address_sanitizer)
#define TEST_TSAN __has_feature(thread_sanitizer)
#else
#if defined(__SANITIZE_ADDRESS__)
#define TEST_ASAN 1
#else
#define TEST_ASAN 0
#endif
#if defined(__SANITIZE_THREAD__)
#define TEST_TSAN 1
#else
#define TEST_TSAN 0
#endif
#endif

/* 1 in builds for another processor, whose tests run in an emulator at a tenth of the speed. */
#ifndef TEST_EMULATED
#define TEST_EMULATED 0
#endif

/* Stands in the list of a group for cmocka_unit_test(f), if f takes long and neither starts nor wakes another thread:
 * the thread sanitizer, which sees only races, skips it by name. */
#define test_one_thread(f)                                                                                             \
	{                                                                                                                  \
		.name = #f, .test_func = TEST_TSAN ? test_skip : (f)                                                           \
	}

/* The same for the address sanitizer, if f takes long and runs no code of ours that no other test runs with it: what a
 * driver draws is not instrumented. */
#define test_no_asan(f)                                                                                                \
	{                                                                                                                  \
		.name = #f, .test_func = TEST_ASAN ? test_skip : (f)                                                           \
	}

static inline void test_skip(void **state)
{
	(void)state;
	skip();
}

#endif
