/* The functions of sim_libc.h. */
#include "bench/sim/sim_libc.h"

#include "bench/sim/sim.h"

#include <errno.h>
#include <linux/futex.h>
#include <stdarg.h>
#include <string.h>

#undef malloc
#undef calloc
#undef aligned_alloc
#undef free
#undef syscall
#undef fopen

#define CLOCK_NS 20 /* what reading the clock and the ticks costs; both count nanoseconds */
#define TICKS_NS 8

/* ---- memory ------------------------------------------------------------------------------------------------------ */

void *sim_libc_malloc(size_t size)
{
	return sim_allocate(16, size);
}

void *sim_libc_calloc(size_t count, size_t size)
{
	return sim_allocate(16, count * size); /* zero, since nothing is used again */
}

void *sim_libc_aligned_alloc(size_t alignment, size_t size)
{
	return sim_allocate(alignment, size);
}

void sim_libc_free(void *block)
{
	(void)block;
}

/* ---- time -------------------------------------------------------------------------------------------------------- */

unsigned long long sim_libc_ticks(void)
{
	if (!sim_running())
		return 0;
	sim_work(TICKS_NS);
	return (unsigned long long)sim_now();
}

int sim_libc_clock(clockid_t clock, struct timespec *now)
{
	(void)clock;
	sim_work(CLOCK_NS);
	uint64_t ns = (uint64_t)sim_now();
	*now = (struct timespec){.tv_sec = (time_t)(ns / 1000000000u), .tv_nsec = (long)(ns % 1000000000u)};
	return 0;
}

void sim_libc_pause(void)
{
	sim_pause();
}

int sim_libc_nanosleep(const struct timespec *time, struct timespec *left)
{
	(void)left;
	sim_sleep((double)time->tv_sec * 1e9 + (double)time->tv_nsec);
	return 0;
}

/* ---- system calls ------------------------------------------------------------------------------------------------ */

static long futex(va_list arguments)
{
	uint32_t *word = va_arg(arguments, uint32_t *);
	int operation = va_arg(arguments, int);
	uint32_t value = va_arg(arguments, uint32_t);
	const struct timespec *time = va_arg(arguments, const struct timespec *);
	switch (operation & FUTEX_CMD_MASK) {
	case FUTEX_WAIT:
		sim_read(word, NULL);
		sim_futex_wait(word, value, time ? (uint64_t)time->tv_sec * 1000000000u + (uint64_t)time->tv_nsec : UINT64_MAX);
		return 0;
	case FUTEX_WAKE:
		return sim_futex_wake(word, value);
	}
	errno = ENOSYS;
	return -1;
}

long sim_libc_syscall(long number, ...)
{
	va_list arguments;
	va_start(arguments, number);
	long result = 0;
	if (sim_running() && number == SYS_futex)
		result = futex(arguments);
	else if (sim_running() && number == SYS_membarrier)
		sim_membarrier();
	else if (sim_running() && number == SYS_gettid)
		result = sim_thread() + 1; /* 0 means the caller */
	va_end(arguments);
	return result;
}

int sim_libc_yield(void)
{
	sim_yield();
	return 0;
}

/* ---- threads ----------------------------------------------------------------------------------------------------- */

int sim_libc_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*fn)(void *), void *data)
{
	(void)attributes;
	*thread = sim_thread_create(fn, data);
	return 0;
}

int sim_libc_join(pthread_t thread, void **result)
{
	(void)result;
	sim_thread_join((uint32_t)thread);
	return 0;
}

pthread_t sim_libc_self(void)
{
	return sim_thread() + 1;
}

int sim_libc_getcpu(void)
{
	return (int)sim_cpu();
}

int sim_libc_getaffinity(pid_t thread, size_t size, cpu_set_t *set)
{
	(void)thread;
	CPU_ZERO_S(size, set);
	for (uint32_t i = 0; i < sim_cpus(); i++)
		CPU_SET_S(i, size, set);
	return 0;
}

int sim_libc_setaffinity(pid_t thread, size_t size, const cpu_set_t *set)
{
	for (uint32_t i = 0; i < sim_cpus(); i++)
		if (CPU_ISSET_S(i, size, set)) {
			sim_thread_bind(thread > 0 ? (uint32_t)thread - 1 : sim_thread(), i);
			return 0;
		}
	errno = EINVAL;
	return -1;
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

/* The number after /sys/devices/system/cpu/cpu in a path, and what follows it. False: another path. */
static bool cpu_path(const char *path, uint32_t *cpu, const char **rest)
{
	int length = 0;
	if (sscanf(path, "/sys/devices/system/cpu/cpu%u%n", cpu, &length) != 1 || *cpu >= sim_cpus())
		return false;
	*rest = path + length;
	return true;
}

FILE *sim_libc_fopen(const char *path, const char *mode)
{
	(void)mode;
	static char line[32];
	uint32_t cpu, first;
	const char *rest;
	errno = ENOENT;
	if (!cpu_path(path, &cpu, &rest))
		return NULL;
	sim_place place = sim_place_of(cpu);
	if (strcmp(rest, "/topology/thread_siblings_list") == 0)
		first = place.core;
	else if (strcmp(rest, "/cache/index3/shared_cpu_list") == 0)
		first = place.cluster;
	else if (strcmp(rest, "/topology/physical_package_id") == 0)
		first = place.socket;
	else
		return NULL;
	int length = snprintf(line, sizeof line, "%u\n", first);
	return fmemopen(line, (size_t)length, "r");
}

static struct {
	uint32_t socket;
	bool read;
	struct dirent entry;
} folder;

DIR *sim_libc_opendir(const char *path)
{
	uint32_t cpu;
	const char *rest;
	if (!cpu_path(path, &cpu, &rest) || *rest)
		return NULL;
	folder.socket = sim_place_of(cpu).socket;
	folder.read = false;
	return (DIR *)&folder;
}

struct dirent *sim_libc_readdir(DIR *stream)
{
	(void)stream;
	if (folder.read)
		return NULL;
	folder.read = true;
	snprintf(folder.entry.d_name, sizeof folder.entry.d_name, "node%u", folder.socket);
	return &folder.entry;
}

int sim_libc_closedir(DIR *stream)
{
	(void)stream;
	return 0;
}
