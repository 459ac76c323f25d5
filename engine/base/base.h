/*
 * base: what every engine module stands on: results and their messages, asserts, log lines, hashing, CPU features.
 *
 * Errors.   Two kinds. Trouble with the world (a file, a driver, a flag) is a stilb_result plus one line that names the
 *           thing and the way out; trouble made by a programmer is an assert. Nothing a user can feed in reaches an
 *           assert.
 * Threads.  Every function here is [any-thread].
 */
#ifndef STILB_BASE_H
#define STILB_BASE_H

#include <assert.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define STILB_VERSION "0.2.0"

/* ---- results ------------------------------------------------------------------------------------------------- */

#define STILB_RESULTS(X)                                                                                               \
	X(OK, "ok")                                                                                                        \
	X(ERROR_ARGUMENT, "refused argument")                                                                              \
	X(ERROR_MEMORY, "out of memory")                                                                                   \
	X(ERROR_FILE, "file error")                                                                                        \
	X(ERROR_DEVICE, "device error")                                                                                    \
	X(ERROR_DEVICE_LOST, "device lost")                                                                                \
	X(ERROR_WINDOW, "window error")                                                                                    \
	X(ERROR_THREAD, "thread error")

typedef enum stilb_result {
#define STILB_RESULT_ENUM(name, text) STILB_##name,
	STILB_RESULTS(STILB_RESULT_ENUM)
#undef STILB_RESULT_ENUM
} stilb_result;

/* Stores the line for this thread's stilb_error_message and returns result, for `return stilb_fail(...)`. The line has
 * no "stilb: " in front, no newline, and names the thing, the value and what to do about it. */
stilb_result stilb_fail(stilb_result result, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* The line of this thread's last stilb_fail; "" before the first. Valid until the thread's next stilb_fail. */
const char *stilb_error_message(void);

/* The result in words, for example "device lost". */
const char *stilb_result_text(stilb_result result);

/* ---- asserts and log ------------------------------------------------------------------------------------------ */

/* Contracts of functions. A broken one is the programmer's mistake: it prints file, line, function and condition and
 * ends the program with SIGABRT. With NDEBUG they are compiled as dead code, so release builds pay nothing and
 * functions that only asserts call are not unused.
 *
 *   STILB_ASSERT(index < count);              cheap: an argument, a state, a range
 *   STILB_CHECK(octree_is_sound(octree));     walks a whole structure; for the end of a change to it
 *
 * Which thread calls, and which lock it holds, is asserted with base_contract.h. */
#ifdef NDEBUG
#define STILB_ASSERT(condition) ((void)(0 && (condition)))
#else
#define STILB_ASSERT(condition) assert(condition)
#endif
#define STILB_CHECK(condition) STILB_ASSERT(condition)

/* One line on stderr, "stilb: " in front; control characters become '?'. */
void stilb_log(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* ---- memory ---------------------------------------------------------------------------------------------------- */

#define STILB_CACHE_LINE 128 /* two 64-byte lines: the adjacent-line prefetcher pairs them */

/* count * size bytes, aligned to STILB_CACHE_LINE and not initialised, large blocks in huge pages where the system
 * offers them; NULL on overflow or when there is no memory. free() it. */
void *stilb_memory_alloc(size_t count, size_t size);

/* True if the process cannot have `bytes` more addresses now: its own limit (ulimit -v) or the machine's is near.
 * Touches none of them. For libraries that fail without a reason. */
bool stilb_memory_is_scarce(size_t bytes);

/* The failure of threads that could not be started, and the way out. error: what the system said, for which EAGAIN may
 * mean too many threads or no room for their stacks. Returns STILB_ERROR_MEMORY or STILB_ERROR_THREAD. */
stilb_result stilb_fail_threads(uint32_t count, int error);

/* ---- hashing --------------------------------------------------------------------------------------------------- */

#define STILB_FNV1A64_START 0xcbf29ce484222325u

/* FNV-1a, 64 bits, continued from hash. Source: Fowler, Noll, Vo; draft-eastlake-fnv. */
uint64_t stilb_hash_fnv1a64(uint64_t hash, const void *data, size_t size);

/* ---- random numbers -------------------------------------------------------------------------------------------- */

/* A value for every (seed, index): splitmix64's finaliser over their sum. Counter-based, so the order of calls does
 * not matter. Source: Steele, Lea, Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014. */
uint64_t stilb_random_u64(uint64_t seed, uint64_t index);

/* The same in [0, 1), 24 bits. */
float stilb_random_float(uint64_t seed, uint64_t index);

/* ---- time and CPU ---------------------------------------------------------------------------------------------- */

/* CLOCK_MONOTONIC in nanoseconds. */
uint64_t stilb_time_ns(void);

typedef struct stilb_cpu_features {
	char name[64];                       /* brand string, or "unknown CPU" */
	bool sse42, avx2, fma, f16c, avx512; /* avx512: F, VL, BW and DQ; all as the OS allows them */
	bool invariant_tsc;
} stilb_cpu_features;

stilb_cpu_features stilb_cpu_query(void);

/* The instruction sets that modules have code for; each includes the ones before it. */
typedef enum stilb_isa {
	STILB_ISA_SCALAR, /* plain C; the truth that the others are tested against */
	STILB_ISA_AVX2,   /* and BMI, which came with it */
	STILB_ISA_AVX512, /* as stilb_cpu_features.avx512 */
	STILB_ISA_COUNT
} stilb_isa;

/* "scalar", "avx2", "avx512". */
const char *stilb_isa_text(stilb_isa isa);

/* The widest that this CPU has. */
stilb_isa stilb_cpu_widest_isa(void);

/* The one to use: the environment's STILB_ISA, else the widest. STILB_ERROR_ARGUMENT: STILB_ISA names none, or one that
 * this CPU lacks. */
stilb_result stilb_cpu_isa(stilb_isa *isa);

#endif
