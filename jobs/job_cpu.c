#include "jobs/job_internal.h"

#include <dirent.h>
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

/* The CPUs of the list as a set, to be freed with CPU_FREE; NULL as affinity. */
static cpu_set_t *set_of(job_cpu_list list, size_t *size)
{
	if (list.count == 0)
		return affinity(size);
	uint32_t last = 0;
	for (uint32_t i = 0; i < list.count; i++)
		last = list.cpu[i] > last ? list.cpu[i] : last;
	assert(last < STILB_JOB_MAX_CPUS);
	cpu_set_t *set = CPU_ALLOC(last + 1);
	if (!set)
		return NULL;
	*size = CPU_ALLOC_SIZE(last + 1);
	CPU_ZERO_S(*size, set);
	for (uint32_t i = 0; i < list.count; i++)
		CPU_SET_S(list.cpu[i], *size, set);
	return set;
}

uint32_t job_cpu_different(job_cpu_list list)
{
	size_t size;
	cpu_set_t *set = set_of(list, &size);
	int count = set ? CPU_COUNT_S(size, set) : 0;
	CPU_FREE(set);
	return count > 0 ? (uint32_t)count : 1;
}

bool job_cpu_allows(job_cpu_list list, uint32_t cpu)
{
	uint32_t i = 0;
	while (i < list.count && list.cpu[i] != cpu)
		i++;
	return i < list.count || list.count == 0;
}

int job_cpu_bind(job_cpu_list list)
{
	size_t size;
	cpu_set_t *set = set_of(list, &size);
	int error = !set ? -ENOMEM : sched_setaffinity(0, size, set) == 0 ? 0 : -errno;
	CPU_FREE(set);
	return error;
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
	uint32_t cpus = job_cpu_different((job_cpu_list){0});
	uint32_t quota = job_cpu_quota("/proc/self/cgroup", "/sys/fs/cgroup");
	return quota > 0 && quota < cpus ? quota : cpus;
}

/* ---- which CPUs for the workers -------------------------------------------------------------------------------- */

/* A CPU and what it shares with others. A core, a cache or a node is named by the lowest CPU that belongs to it; where
 * the kernel does not say, a core is the CPU alone, and cache and node are 0. */
typedef struct cpu_place {
	uint32_t cpu;
	uint32_t core;    /* its hardware threads share execution units */
	uint32_t cache;   /* the last level of cache */
	uint32_t node;    /* memory; the node's number and not a CPU */
	uint32_t threads; /* of the pool, the owner included, that have been placed on its core */
	bool taken;
} cpu_place;

/* The first number in a file below the CPU's folder, which is the lowest CPU if the file is a list of CPUs; `otherwise`
 * if there is no such file. */
static uint32_t cpu_number(const char *dir, const char *file, uint32_t otherwise)
{
	char line[128];
	uint32_t number;
	return read_line("", dir, file, line, sizeof line) && sscanf(line, "%u", &number) == 1 ? number : otherwise;
}

/* The number of the memory node whose link lies in the CPU's folder, 0 if there is none. */
static uint32_t cpu_node(const char *dir)
{
	uint32_t node = 0;
	DIR *stream = opendir(dir);
	if (!stream)
		return 0;
	for (const struct dirent *entry; (entry = readdir(stream));)
		if (sscanf(entry->d_name, "node%u", &node) == 1)
			break;
	closedir(stream);
	return node;
}

/* The folder of a CPU. Source: Linux, Documentation/ABI/stable/sysfs-devices-system-cpu. False if it has too long a
 * name. */
static bool cpu_dir(const char *cpu_dirs, uint32_t cpu, char dir[CPU_PATH_MAX])
{
	int length = snprintf(dir, CPU_PATH_MAX, "%s/cpu%u", cpu_dirs, cpu);
	return length >= 0 && length < CPU_PATH_MAX;
}

/* The last level of cache of the CPU with this folder. Caches are numbered from the nearest on. */
static uint32_t cpu_cache(const char *dir)
{
	char file[64];
	uint32_t cache = UINT32_MAX;
	for (int level = 3; level >= 0 && cache == UINT32_MAX; level--) {
		snprintf(file, sizeof file, "cache/index%d/shared_cpu_list", level);
		cache = cpu_number(dir, file, UINT32_MAX);
	}
	return cache == UINT32_MAX ? 0 : cache;
}

static void cpu_find_place(const char *cpu_dirs, cpu_place *place)
{
	char dir[CPU_PATH_MAX];
	if (!cpu_dir(cpu_dirs, place->cpu, dir))
		return;
	place->core = cpu_number(dir, "topology/thread_siblings_list", place->cpu);
	place->node = cpu_node(dir);
	place->cache = cpu_cache(dir);
}

/* How bad a choice the CPU is: foremost the number of threads that share its core already, then the distance from the
 * owner. */
static uint32_t place_cost(const cpu_place *owner, const cpu_place *place)
{
	return 3 * place->threads + (place->node != owner->node ? 2 : place->cache != owner->cache ? 1 : 0);
}

/* Counts one more thread on the core. */
static void place_thread(cpu_place *places, uint32_t count, uint32_t core)
{
	for (uint32_t i = 0; i < count; i++)
		places[i].threads += places[i].core == core;
}

/* Stores the best `max` CPUs of the places in cpus; the first of several equal ones. */
static void choose_places(const char *cpu_dirs, cpu_place *places, uint32_t count, uint32_t here, uint32_t *cpus,
                          uint32_t max)
{
	cpu_place owner = {.cpu = here, .core = here};
	cpu_find_place(cpu_dirs, &owner);
	for (uint32_t i = 0; i < count; i++)
		cpu_find_place(cpu_dirs, &places[i]);
	place_thread(places, count, owner.core);
	for (uint32_t chosen = 0; chosen < max; chosen++) {
		cpu_place *best = NULL;
		uint32_t best_cost = UINT32_MAX;
		for (uint32_t i = 0; i < count; i++) {
			uint32_t cost = places[i].taken ? UINT32_MAX : place_cost(&owner, &places[i]);
			if (cost < best_cost) {
				best = &places[i];
				best_cost = cost;
			}
		}
		assert(best && "max is less than count");
		best->taken = true;
		place_thread(places, count, best->core);
		cpus[chosen] = best->cpu;
	}
}

uint32_t job_cpu_choose(const uint32_t *allowed, uint32_t count, uint32_t here, const char *cpu_dirs, uint32_t *cpus,
                        uint32_t max)
{
	assert(allowed && cpu_dirs && cpus && max > 0);
	cpu_place *places = count > max ? calloc(count, sizeof *places) : NULL;
	uint32_t chosen = count < max ? count : max;
	for (uint32_t i = 0; i < chosen; i++)
		cpus[i] = allowed[i];
	if (!places)
		return chosen; /* all of them; or there is no memory, and the first ones will do */
	for (uint32_t i = 0; i < count; i++)
		places[i] = (cpu_place){.cpu = allowed[i], .core = allowed[i]};
	choose_places(cpu_dirs, places, count, here, cpus, max);
	free(places);
	return chosen;
}

/* Moves element `from` of the array to the lower place `to` and those between up by one. */
static void move_down(uint32_t *array, uint32_t from, uint32_t to)
{
	uint32_t moved = array[from];
	memmove(array + to + 1, array + to, (from - to) * sizeof *array);
	array[to] = moved;
}

void job_cpu_sort(uint32_t *cpus, uint32_t count, const char *cpu_dirs, uint32_t *cache)
{
	assert(cpus && count > 0 && cpu_dirs && cache);
	char dir[CPU_PATH_MAX];
	for (uint32_t i = 0; i < count; i++)
		cache[i] = cpu_dir(cpu_dirs, cpus[i], dir) ? cpu_cache(dir) : 0;
	for (uint32_t sorted = 1; sorted < count; sorted++) {
		uint32_t next = sorted; /* the next CPU with the same cache as the one before, if there is one */
		while (next < count && cache[next] != cache[sorted - 1])
			next++;
		if (next < count) {
			move_down(cpus, next, sorted);
			move_down(cache, next, sorted);
		}
	}
}

uint32_t job_cpu_others(job_cpu_list list, uint32_t here, uint32_t *cpus, uint32_t max)
{
	assert(cpus && max > 0);
	size_t size;
	cpu_set_t *set = set_of(list, &size);
	uint32_t count = 0, chosen = 0;
	uint32_t *allowed = set ? calloc(size * 8, sizeof *allowed) : NULL;
	if (allowed) {
		for (size_t i = 0; i < size * 8; i++) {
			size_t cpu = (here + i) % (size * 8);
			if (cpu != here && CPU_ISSET_S(cpu, size, set))
				allowed[count++] = (uint32_t)cpu;
		}
		chosen = job_cpu_choose(allowed, count, here, "/sys/devices/system/cpu", cpus, max);
	}
	free(allowed);
	CPU_FREE(set);
	return chosen;
}
