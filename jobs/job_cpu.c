#include "jobs/job_internal.h"

#include <errno.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CPU_PATH_MAX 4096

/* The affinity mask of the calling thread, to be freed with CPU_FREE; NULL if there is no memory or the kernel refuses.
 * The kernel returns EINVAL until the mask is at least as large as its own. */
static cpu_set_t *affinity(size_t *size)
{
	for (int cpus = 1024; cpus <= 1 << 20; cpus *= 2) {
		cpu_set_t *set = CPU_ALLOC(cpus);
		if (!set)
			break;
		*size = CPU_ALLOC_SIZE(cpus);
		if (sched_getaffinity(0, *size, set) == 0)
			return set;
		int error = errno;
		CPU_FREE(set);
		if (error != EINVAL)
			break;
	}
	return NULL;
}

static uint32_t affinity_count(void)
{
	size_t size;
	cpu_set_t *set = affinity(&size);
	int count = set ? CPU_COUNT_S(size, set) : 0;
	CPU_FREE(set);
	return count > 0 ? (uint32_t)count : 1;
}

uint32_t job_cpu_others(uint32_t *cpus, uint32_t max)
{
	assert(cpus && max > 0);
	size_t size;
	cpu_set_t *set = affinity(&size);
	int here = sched_getcpu();
	uint32_t count = 0;
	if (set && here >= 0)
		for (size_t i = 1; i < size * 8 && count < max; i++) {
			size_t cpu = ((size_t)here + i) % (size * 8);
			if (CPU_ISSET_S(cpu, size, set))
				cpus[count++] = (uint32_t)cpu;
		}
	CPU_FREE(set);
	assert(count <= max);
	return count;
}

/* Reads the first line of the file mount + dir + "/" + file; false if there is no such file. */
static bool read_line(const char *mount, const char *dir, const char *file, char *line, int size)
{
	assert(size > 0);
	char path[CPU_PATH_MAX];
	int length = snprintf(path, sizeof path, "%s%s/%s", mount, dir, file);
	if (length < 0 || (size_t)length >= sizeof path)
		return false;
	FILE *stream = fopen(path, "re");
	if (!stream)
		return false;
	bool got = fgets(line, size, stream);
	fclose(stream);
	return got;
}

/* The number of CPUs that a quota of CPU time in each period amounts to, rounded up. Both arguments are in
 * microseconds; 0 if one of them is not positive, which means no limit. */
static uint32_t limit_cpus(long long quota, long long period)
{
	if (quota <= 0 || period <= 0)
		return 0;
	long long cpus = (quota - 1) / period + 1;
	return cpus < UINT32_MAX ? (uint32_t)cpus : 0;
}

/* cgroup v2 (Linux, Documentation/admin-guide/cgroup-v2.rst): cpu.max holds "max PERIOD" or "QUOTA PERIOD". */
static uint32_t limit_v2(const char *mount, const char *dir)
{
	char line[128];
	long long quota = 0, period = 0;
	if (!read_line(mount, dir, "cpu.max", line, sizeof line) || sscanf(line, "%lld %lld", &quota, &period) != 2)
		return 0;
	return limit_cpus(quota, period);
}

/* cgroup v1 (Linux, Documentation/scheduler/sched-bwc.rst): a quota of -1 means no limit. */
static uint32_t limit_v1(const char *mount, const char *dir)
{
	char line[128], cpu_mount[CPU_PATH_MAX];
	int length = snprintf(cpu_mount, sizeof cpu_mount, "%s/cpu", mount);
	if (length < 0 || (size_t)length >= sizeof cpu_mount ||
	    !read_line(cpu_mount, dir, "cpu.cfs_quota_us", line, sizeof line))
		return 0;
	long long quota = strtoll(line, NULL, 10);
	if (!read_line(cpu_mount, dir, "cpu.cfs_period_us", line, sizeof line))
		return 0;
	return limit_cpus(quota, strtoll(line, NULL, 10));
}

/* The smallest limit (limit_v1 or limit_v2, in CPUs) of the group `dir` and all groups above it, 0 if there is none;
 * shortens the string dir. Inside a container, dir may be a path of the host that does not exist here; then only the
 * root of the mount is found, which is the container's own group. */
static uint32_t smallest_limit(uint32_t (*limit)(const char *, const char *), const char *mount, char *dir)
{
	uint32_t smallest = 0;
	for (;;) {
		if (strcmp(dir, "/") == 0)
			*dir = '\0';
		uint32_t cpus = limit(mount, dir);
		if (cpus > 0 && (smallest == 0 || cpus < smallest))
			smallest = cpus;
		char *slash = strrchr(dir, '/');
		if (!slash)
			return smallest;
		*slash = '\0';
	}
}

/* True if name is one of the comma-separated words of list. */
static bool list_has(const char *list, const char *name)
{
	size_t length = strlen(name);
	for (const char *at = list; at; at = strchr(at, ','), at = at ? at + 1 : NULL)
		if (strncmp(at, name, length) == 0 && (at[length] == ',' || at[length] == '\0'))
			return true;
	return false;
}

/* The CPU limit of the group in one line of /proc/self/cgroup, "ID:CONTROLLERS:PATH"; 0 if it has none. cgroup v2
 * leaves CONTROLLERS empty. */
static uint32_t line_limit(char *line, const char *mount)
{
	line[strcspn(line, "\n")] = '\0';
	char *controllers = strchr(line, ':');
	char *dir = controllers ? strchr(controllers + 1, ':') : NULL;
	if (!dir)
		return 0;
	*dir++ = '\0';
	controllers++;
	if (*controllers == '\0')
		return smallest_limit(limit_v2, mount, dir);
	return list_has(controllers, "cpu") ? smallest_limit(limit_v1, mount, dir) : 0;
}

uint32_t job_cpu_quota(const char *proc_cgroup, const char *mount)
{
	assert(proc_cgroup && mount);
	char line[CPU_PATH_MAX];
	uint32_t smallest = 0;
	FILE *stream = fopen(proc_cgroup, "re");
	if (!stream)
		return 0;
	while (fgets(line, sizeof line, stream)) {
		uint32_t cpus = line_limit(line, mount);
		if (cpus > 0 && (smallest == 0 || cpus < smallest))
			smallest = cpus;
	}
	fclose(stream);
	return smallest;
}

uint32_t stilb_job_cpu_count(void)
{
	uint32_t cpus = affinity_count();
	uint32_t quota = job_cpu_quota("/proc/self/cgroup", "/sys/fs/cgroup");
	return quota > 0 && quota < cpus ? quota : cpus;
}
