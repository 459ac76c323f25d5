#include "base/base.h"

#include <ctype.h>
#include <errno.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <time.h>
#if defined(__x86_64__)
#include <cpuid.h>
#endif

static _Thread_local char error_message[1024];

void stilb_fail_line(const char *format, ...)
{
	STILB_ASSERT(format);
	char line[sizeof error_message]; /* not error_message itself, which may be among the arguments */
	va_list arguments;
	va_start(arguments, format);
	vsnprintf(line, sizeof line, format, arguments);
	va_end(arguments);
	memcpy(error_message, line, sizeof error_message);
}

const char *stilb_error_message(void)
{
	return error_message;
}

const char *stilb_result_text(stilb_result result)
{
	static const char *const texts[] = {
#define STILB_RESULT_STRING(name, text) text,
		STILB_RESULTS(STILB_RESULT_STRING)
#undef STILB_RESULT_STRING
	};
	return (size_t)result < sizeof texts / sizeof *texts ? texts[result] : "unknown result";
}

/* Where lines go; fn NULL: to stderr. The lock is held while a line is written: so lines do not mix, and a replaced
 * function is no longer running. */
static struct {
	pthread_mutex_t lock;
	stilb_log_fn *fn;
	void *user;
} log_sink = {.lock = PTHREAD_MUTEX_INITIALIZER};

void stilb_log_set(stilb_log_fn *fn, void *user)
{
	pthread_mutex_lock(&log_sink.lock);
	log_sink.fn = fn;
	log_sink.user = user;
	pthread_mutex_unlock(&log_sink.lock);
}

void stilb_log(const char *format, ...)
{
	char line[2048];
	va_list arguments;
	STILB_ASSERT(format);
	va_start(arguments, format);
	vsnprintf(line, sizeof line, format, arguments);
	va_end(arguments);
	for (char *c = line; *c; c++) /* a quoted file name may hold a newline */
		if (iscntrl((unsigned char)*c))
			*c = '?';
	pthread_mutex_lock(&log_sink.lock);
	if (log_sink.fn)
		log_sink.fn(log_sink.user, line);
	else
		fprintf(stderr, "stilb: %s\n", line);
	pthread_mutex_unlock(&log_sink.lock);
}

const char *stilb_version(void)
{
	return STILB_VERSION;
}

/* Size of a huge page, and the size of a block from which on they are used. With 4 KiB pages, walking over 100 MB costs
 * more in address translation than in memory: recording a million draws on one thread took 7.4 ms, with huge pages
 * 5.5. Touching new memory for the first time is about four times as fast, too. What a block has beyond its last whole
 * huge page stays in small ones, so no memory is wasted. */
#define MEMORY_HUGE_PAGE ((size_t)2 << 20)
#define MEMORY_HUGE_FROM ((size_t)2 << 20)

void *stilb_memory_alloc(size_t count, size_t size)
{
	size_t bytes;
	if (__builtin_mul_overflow(count, size, &bytes) || bytes > SIZE_MAX - STILB_CACHE_LINE)
		return NULL;
	bytes = (bytes + STILB_CACHE_LINE - 1) & ~(size_t)(STILB_CACHE_LINE - 1);
	if (bytes < MEMORY_HUGE_FROM)
		return aligned_alloc(STILB_CACHE_LINE, bytes ? bytes : STILB_CACHE_LINE);
	if (bytes > SIZE_MAX - MEMORY_HUGE_PAGE)
		return NULL;
	void *memory = aligned_alloc(MEMORY_HUGE_PAGE, (bytes + MEMORY_HUGE_PAGE - 1) & ~(MEMORY_HUGE_PAGE - 1));
	if (memory)
		madvise(memory, bytes, MADV_HUGEPAGE); /* a hint only: its failure does not matter */
	return memory;
}

bool stilb_memory_is_scarce(size_t bytes)
{
	STILB_ASSERT(bytes > 0);
	void *probe = mmap(NULL, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
	return probe == MAP_FAILED || munmap(probe, bytes) != 0;
}

#define MEMORY_STACK ((size_t)8 << 20) /* bytes of a thread's stack if the system sets no limit */

stilb_result stilb_fail_threads(uint32_t count, int error)
{
	STILB_ASSERT(count > 0);
	STILB_ASSERT(error > 0);
	struct rlimit stack;
	bool known = getrlimit(RLIMIT_STACK, &stack) == 0 && stack.rlim_cur > 0 && stack.rlim_cur != RLIM_INFINITY;
	size_t each = known ? (size_t)stack.rlim_cur : MEMORY_STACK;
	const char *many = count == 1 ? "" : "s";
	bool no_stacks = error == EAGAIN && each <= SIZE_MAX / count && stilb_memory_is_scarce(count * each);
	if (error == ENOMEM || no_stacks)
		return stilb_fail(
			STILB_ERROR_MEMORY,
			"no memory for %u thread%s; try fewer with --workers, or raise the limit that 'ulimit -v' shows", count,
			many);
	return stilb_fail(STILB_ERROR_THREAD, "cannot start %u thread%s: %s; try fewer with --workers", count, many,
	                  strerror(error));
}

uint64_t stilb_hash_fnv1a64(uint64_t hash, const void *data, size_t size)
{
	const unsigned char *bytes = data;
	STILB_ASSERT(data || size == 0);
	for (size_t i = 0; i < size; i++)
		hash = (hash ^ bytes[i]) * 0x100000001b3u;
	return hash;
}

void stilb_float_text(float value, char text[STILB_FLOAT_TEXT])
{
	for (int digits = 6; digits <= 9; digits++) {
		snprintf(text, STILB_FLOAT_TEXT, "%.*g", digits, (double)value);
		if (strtof(text, NULL) == value)
			break;
	}
}

uint64_t stilb_random_u64(uint64_t seed, uint64_t index)
{
	uint64_t z = seed + (index + 1) * 0x9e3779b97f4a7c15u;
	z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
	z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
	return z ^ (z >> 31);
}

float stilb_random_float(uint64_t seed, uint64_t index)
{
	return (float)(stilb_random_u64(seed, index) >> 40) * 0x1p-24f;
}

uint64_t stilb_time_ns(void)
{
	struct timespec now;
	clock_gettime(CLOCK_MONOTONIC, &now);
	return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

#if defined(__x86_64__)
static bool cpu_has_avx512(void)
{
	return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
	       __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq");
}

static bool cpu_has_invariant_tsc(void)
{
	unsigned a, b, c, d;
	return __get_cpuid(0x80000007u, &a, &b, &c, &d) && (d & (1u << 8));
}

static void cpu_brand(char name[64])
{
	unsigned registers[12];
	for (size_t i = 0; i < 3; i++)
		if (!__get_cpuid(0x80000002u + (unsigned)i, &registers[4 * i], &registers[4 * i + 1], &registers[4 * i + 2],
		                 &registers[4 * i + 3]))
			return;
	char brand[sizeof registers + 1] = {0};
	memcpy(brand, registers, sizeof registers);
	const char *start = brand + strspn(brand, " ");
	size_t length = strlen(start);
	while (length > 0 && start[length - 1] == ' ')
		length--;
	if (length > 0)
		snprintf(name, 64, "%.*s", (int)length, start);
}
#endif

stilb_cpu_features stilb_cpu_query(void)
{
	stilb_cpu_features cpu = {.name = "unknown CPU"};
#if defined(__x86_64__)
	__builtin_cpu_init(); /* sets a flag only if the OS saves its registers on a context switch */
	cpu.sse42 = __builtin_cpu_supports("sse4.2");
	cpu.avx2 = __builtin_cpu_supports("avx2");
	cpu.fma = __builtin_cpu_supports("fma");
	cpu.avx512 = cpu_has_avx512();
	unsigned a, b, c = 0, d;
	cpu.f16c = cpu.avx2 && __get_cpuid(1, &a, &b, &c, &d) && (c & (1u << 29));
	cpu.invariant_tsc = cpu_has_invariant_tsc();
	cpu_brand(cpu.name);
#endif
	return cpu;
}

static const char *const isa_texts[STILB_ISA_COUNT] = {"scalar", "avx2", "avx512"};

const char *stilb_isa_text(stilb_isa isa)
{
	STILB_ASSERT((unsigned)isa < STILB_ISA_COUNT);
	return isa_texts[isa];
}

/* Does not call stilb_cpu_query, whose CPUID instructions take microseconds each on a virtual machine. */
stilb_isa stilb_cpu_widest_isa(void)
{
#if defined(__x86_64__)
	__builtin_cpu_init();
	if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("bmi"))
		return STILB_ISA_SCALAR;
	return cpu_has_avx512() ? STILB_ISA_AVX512 : STILB_ISA_AVX2;
#else
	return STILB_ISA_SCALAR;
#endif
}

stilb_result stilb_cpu_isa(stilb_isa *isa)
{
	STILB_ASSERT(isa);
	stilb_isa widest = stilb_cpu_widest_isa();
	const char *wanted = getenv("STILB_ISA");
	*isa = widest;
	if (!wanted)
		return STILB_OK;
	for (*isa = STILB_ISA_SCALAR; *isa < STILB_ISA_COUNT; (*isa)++)
		if (strcmp(wanted, isa_texts[*isa]) == 0)
			break;
	if (*isa == STILB_ISA_COUNT)
		return stilb_fail(STILB_ERROR_ARGUMENT, "STILB_ISA=%s is unknown; give scalar, avx2 or avx512, or unset it",
		                  wanted);
	if (*isa > widest)
		return stilb_fail(STILB_ERROR_ARGUMENT, "STILB_ISA=%s: this CPU has %s at most; unset it", wanted,
		                  isa_texts[widest]);
	return STILB_OK;
}
