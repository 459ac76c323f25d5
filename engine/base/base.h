/*
 * base: the foundation of every engine module: results and their messages, asserts, log lines, memory, hashing, random
 * numbers, time and CPU features. Nothing here is created or destroyed.
 *
 * Errors.   Two kinds. Trouble with the world (a file, a driver, a flag) is a stilb_result plus one line that names the
 *           thing, the value and the way out; trouble made by a programmer is an assert. Nothing a user can feed in
 *           reaches an assert.
 * Threads.  Every function here is [any-thread]. A message belongs to the thread that failed.
 * Example.  A function that can fail, and its caller:
 *
 *   stilb_result load(const char *path)
 *   {
 *       if (!exists(path))
 *           return stilb_fail(STILB_ERROR_FILE, "cannot read '%s': no such file", path);
 *       return STILB_OK;
 *   }
 *
 *   if (load("scene.gltf") != STILB_OK)
 *       stilb_log("%s", stilb_error_message());   // stilb: cannot read 'scene.gltf': no such file
 */
#ifndef STILB_BASE_H
#define STILB_BASE_H

#include <assert.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* The version of this header. While the major number is 0, every minor version may change an interface. */
#define STILB_VERSION_MAJOR 0
#define STILB_VERSION_MINOR 2
#define STILB_VERSION_PATCH 0
#define STILB_VERSION_JOIN_(a, b, c) #a "." #b "." #c
#define STILB_VERSION_TEXT_(a, b, c) STILB_VERSION_JOIN_(a, b, c)
#define STILB_VERSION STILB_VERSION_TEXT_(STILB_VERSION_MAJOR, STILB_VERSION_MINOR, STILB_VERSION_PATCH)

/* The version of the library that is linked: STILB_VERSION, if both come from one installation. Static. */
const char *stilb_version(void);

#if 0 /* 1 in the copy of this header that is installed */
/* Where this header lies tells a program in which installation it finds the files that the engine starts and loads
 * (stilb-scene-import and the like): in ../../lib/stilb from here, wherever the installed tree was moved to. */
extern const char stilb_header_path[] __attribute__((weak));
const char stilb_header_path[] = __FILE__;
#endif

/* ---- results ----------------------------------------------------------------------------------------------------- */

/* X(NAME, what stilb_result_text says of it). STILB_OK is 0. */
#define STILB_RESULTS(X)                                                                                               \
	X(OK, "ok")                                                                                                        \
	X(ERROR_ARGUMENT, "refused argument")                                                                              \
	X(ERROR_MEMORY, "out of memory")                                                                                   \
	X(ERROR_FILE, "file error")                                                                                        \
	X(ERROR_DEVICE, "device error")                                                                                    \
	X(ERROR_DEVICE_LOST, "device lost")                                                                                \
	X(ERROR_WINDOW, "window error")                                                                                    \
	X(ERROR_THREAD, "thread error")                                                                                    \
	X(ERROR_GIVEN_UP, "given up")

typedef enum stilb_result {
#define STILB_RESULT_ENUM(name, text) STILB_##name,
	STILB_RESULTS(STILB_RESULT_ENUM)
#undef STILB_RESULT_ENUM
} stilb_result;

/* stilb_fail(result, format, ...) stores the line for this thread's stilb_error_message and returns result, which is
 * not STILB_OK, for `return stilb_fail(...)`. The line has no "stilb: " in front and no newline, and names the thing,
 * the value and what to do about it. It may quote stilb_error_message(). Lines longer than 1023 bytes are cut.
 * A macro, so that static analysis sees in every caller that the result is no success. */
#define stilb_fail(result, ...) (stilb_fail_line(__VA_ARGS__), stilb_fail_result(result))

/* The parts of stilb_fail. */
void stilb_fail_line(const char *format, ...) __attribute__((format(printf, 1, 2)));
static inline stilb_result stilb_fail_result(stilb_result result);

/* The line of this thread's last stilb_fail; "" before the first. Valid until the thread's next stilb_fail, which may
 * happen in any function that returns a stilb_result: copy it to keep it. */
const char *stilb_error_message(void);

/* The result in words, for example "device lost"; "unknown result" for a number that is no result. Static. */
const char *stilb_result_text(stilb_result result);

/* ---- asserts and log --------------------------------------------------------------------------------------------- */

/* Contracts of functions. A broken one is the programmer's mistake: it prints file, line, function and condition and
 * ends the program with SIGABRT. With NDEBUG they are compiled as dead code, so release builds pay nothing and
 * functions that only asserts call are not unused.
 *
 *   STILB_ASSERT(index < count);              cheap: an argument, a state, a range
 *   STILB_CHECK(octree_is_sound(octree));     walks a whole structure; for the end of a change to it
 *
 * The condition must have no side effects. The calling thread and the locks it holds are asserted with
 * base_contract.h. */
#ifdef NDEBUG
#define STILB_ASSERT(condition) ((void)(0 && (condition)))
#else
#define STILB_ASSERT(condition) assert(condition)
#endif
#define STILB_CHECK(condition) STILB_ASSERT(condition)

static inline stilb_result stilb_fail_result(stilb_result result)
{
	STILB_ASSERT(result != STILB_OK && "a failure has a result of its own");
	return result;
}

/* Passes one line on to the function of stilb_log_set, or writes it to stderr, "stilb: " in front. Lines of two threads
 * do not mix. Control characters become '?', so a quoted file name cannot break the line. Lines longer than 2047 bytes
 * are cut. */
void stilb_log(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* Takes a line, without "stilb: " and newline; valid during the call. Called on the thread that logs, one line at a
 * time; it must not log itself and not call stilb_log_set. */
typedef void stilb_log_fn(void *user, const char *line);

/* All lines of this process go to fn from now on, with user; NULL: to stderr, as at the start. When it returns, the
 * function before is not running and will not be called again.
 *
 *   static void to_my_console(void *user, const char *line)
 *   {
 *       console_print(user, line);
 *   }
 *
 *   stilb_log_set(to_my_console, console); */
void stilb_log_set(stilb_log_fn *fn, void *user);

/* ---- memory ------------------------------------------------------------------------------------------------------ */

#define STILB_CACHE_LINE 128 /* two 64-byte lines: the adjacent-line prefetcher pairs them */

/* count * size bytes, aligned to STILB_CACHE_LINE and not initialised; blocks of 4 MiB and more in huge pages where the
 * system offers them. Never NULL for 0 bytes; NULL if the product overflows or there is no memory, and then no message
 * is stored. free() it. */
void *stilb_memory_alloc(size_t count, size_t size);

/* True if the process cannot reserve `bytes` (> 0) more of address space now: its own limit (ulimit -v) or the
 * machine's is near. Touches none of that memory. Tells out of memory from other causes after a library has failed
 * without a reason. */
bool stilb_memory_is_scarce(size_t bytes);

/* Stores the message for `count` (>= 1) threads that could not be started, and returns STILB_ERROR_MEMORY or
 * STILB_ERROR_THREAD. error: the errno, > 0, of pthread_create. It is EAGAIN both for too many threads and for no
 * memory for their stacks; which of the two is decided here by stilb_memory_is_scarce. */
stilb_result stilb_fail_threads(uint32_t count, int error);

/* ---- hashing ----------------------------------------------------------------------------------------------------- */

/* The hash of no bytes: begin with it. */
#define STILB_FNV1A64_START 0xcbf29ce484222325u

/* FNV-1a, 64 bits, of size bytes, continued from hash: hashing in pieces gives the same as in one. data may be NULL if
 * size is 0. Not for untrusted keys. Source: Fowler, Noll, Vo; draft-eastlake-fnv. */
uint64_t stilb_hash_fnv1a64(uint64_t hash, const void *data, size_t size);

/* ---- numbers as text --------------------------------------------------------------------------------------------- */

#define STILB_FLOAT_TEXT 24

/* The shortest text, of 6 digits at least, that reads back as this float: "0.1", "1e-10", "nan". */
void stilb_float_text(float value, char text[STILB_FLOAT_TEXT]);

/* ---- random numbers ---------------------------------------------------------------------------------------------- */

/* A value for every (seed, index): the finaliser of splitmix64 over seed + (index + 1) * golden gamma. Counter-based:
 * the same pair gives the same value in any order of calls and on any thread. Source: Steele, Lea, Flood, "Fast
 * splittable pseudorandom number generators", OOPSLA 2014. */
uint64_t stilb_random_u64(uint64_t seed, uint64_t index);

/* The upper 24 bits of stilb_random_u64 as a float in [0, 1), a multiple of 2^-24. */
float stilb_random_float(uint64_t seed, uint64_t index);

/* ---- time and CPU ------------------------------------------------------------------------------------------------ */

/* CLOCK_MONOTONIC in nanoseconds: never goes back; its zero is arbitrary. */
uint64_t stilb_time_ns(void);

typedef struct stilb_cpu_features {
	char name[64];                       /* brand string without outer blanks, or "unknown CPU" */
	bool sse42, avx2, fma, f16c, avx512; /* avx512: F, VL, BW and DQ. Only if the OS saves their registers, too */
	bool invariant_tsc;                  /* the time stamp counter ticks at one rate in every power state */
} stilb_cpu_features;

/* Asks the CPU with CPUID instructions, which take microseconds each on a virtual machine, so call it once. All false
 * on architectures other than x86-64. */
stilb_cpu_features stilb_cpu_query(void);

/* The instruction sets for which modules have code; each includes the ones before it. */
typedef enum stilb_isa {
	STILB_ISA_SCALAR, /* plain C; the reference that the others are tested against */
	STILB_ISA_AVX2,   /* AVX2 and BMI, which came with it */
	STILB_ISA_AVX512, /* AVX-512 F, VL, BW and DQ */
	STILB_ISA_COUNT
} stilb_isa;

/* "scalar", "avx2", "avx512". isa < STILB_ISA_COUNT. Static. */
const char *stilb_isa_text(stilb_isa isa);

/* The widest set that this CPU and OS have. */
stilb_isa stilb_cpu_widest_isa(void);

/* The instruction set to use: the one that the environment variable STILB_ISA names, else the widest.
 * STILB_ERROR_ARGUMENT: STILB_ISA names none, or one that this CPU lacks; then *isa must not be used. */
stilb_result stilb_cpu_isa(stilb_isa *isa);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
