/* CPU counting: this process' affinity mask, and cgroup files that the test writes. And the choice of CPUs for workers,
 * from a description of the machine that the test writes. */
#include <sched.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "jobs/job_internal.h"
#include "support/test.h"

static char root[] = "/tmp/stilb-cgroup-XXXXXX";

static void write_file(const char *name, const char *text)
{
	char path[512];
	snprintf(path, sizeof path, "%s/%s", root, name);
	FILE *stream = fopen(path, "w");
	assert_non_null(stream);
	assert_true(fputs(text, stream) >= 0);
	assert_int_equal(fclose(stream), 0);
}

static void make_dir(const char *name)
{
	char path[512];
	snprintf(path, sizeof path, "%s/%s", root, name);
	assert_int_equal(mkdir(path, 0700), 0);
}

static uint32_t quota(const char *proc_cgroup)
{
	char path[512];
	write_file("self", proc_cgroup);
	snprintf(path, sizeof path, "%s/self", root);
	return job_cpu_quota(path, root);
}

static int setup(void **state)
{
	(void)state;
	if (!mkdtemp(root))
		return -1;
	make_dir("outer");
	make_dir("outer/inner");
	make_dir("cpu");
	make_dir("cpu/box");
	return 0;
}

static int teardown(void **state)
{
	(void)state;
	char command[512];
	snprintf(command, sizeof command, "rm -rf '%s'", root);
	return system(command);
}

static void test_version_2(void **state)
{
	(void)state;
	assert_int_equal(quota("0::/outer/inner\n"), 0); /* without files there is no limit */
	write_file("outer/inner/cpu.max", "max 100000\n");
	assert_int_equal(quota("0::/outer/inner\n"), 0);
	write_file("outer/inner/cpu.max", "400000 100000\n");
	assert_int_equal(quota("0::/outer/inner\n"), 4);
	write_file("outer/cpu.max", "150000 100000\n"); /* an outer group limits as well; 1.5 is rounded up */
	assert_int_equal(quota("0::/outer/inner\n"), 2);
	write_file("cpu.max", "10000 100000\n"); /* the root, as a container sees it */
	assert_int_equal(quota("0::/outer/inner\n"), 1);
	assert_int_equal(quota("0::/\n"), 1);
	assert_int_equal(quota("0::/not/here\n"), 1);
	write_file("cpu.max", "max 100000\n");
}

static void test_version_1(void **state)
{
	(void)state;
	write_file("cpu/box/cpu.cfs_quota_us", "-1\n");
	write_file("cpu/box/cpu.cfs_period_us", "100000\n");
	assert_int_equal(quota("4:memory:/x\n3:cpu,cpuacct:/box\n"), 0);
	write_file("cpu/box/cpu.cfs_quota_us", "250000\n");
	assert_int_equal(quota("4:memory:/x\n3:cpu,cpuacct:/box\n"), 3);
	assert_int_equal(quota("4:memory:/x\n3:cpuacct,cpu:/box\n"), 3);
	assert_int_equal(quota("3:cpuset:/box\n2:cpuacct:/box\n"), 0); /* no cpu controller */
}

static void test_nonsense(void **state)
{
	(void)state;
	static const char *const lines[] = {"", "\n", "0", "0:", "0::", "::::", "garbage\n", "0::relative\n"};
	for (size_t i = 0; i < sizeof lines / sizeof *lines; i++)
		assert_int_equal(quota(lines[i]), 0);
	static const char *const limits[] = {"",           "0 100000\n", "-5 100000\n",
	                                     "100000 0\n", "100000\n",   "9999999999999999999 1\n"};
	for (size_t i = 0; i < sizeof limits / sizeof *limits; i++) {
		write_file("cpu.max", limits[i]);
		assert_int_equal(quota("0::/\n"), 0);
	}
	assert_int_equal(job_cpu_quota("/nonexistent/self", root), 0);
}

static void test_affinity(void **state)
{
	(void)state;
	cpu_set_t before, one;
	assert_int_equal(sched_getaffinity(0, sizeof before, &before), 0);
	uint32_t all = stilb_job_cpu_count();
	assert_true(all >= 1 && all <= (uint32_t)CPU_COUNT(&before));
	int first = 0;
	while (!CPU_ISSET(first, &before))
		first++;
	CPU_ZERO(&one);
	CPU_SET(first, &one);
	assert_int_equal(sched_setaffinity(0, sizeof one, &one), 0);
	uint32_t count = stilb_job_cpu_count();
	assert_int_equal(sched_setaffinity(0, sizeof before, &before), 0);
	assert_int_equal(count, 1);
}

/* ---- the choice of CPUs ---------------------------------------------------------------------------------------- */

/* Describes a CPU of a machine with 16: two nodes of two caches each, two cores share a cache, and each core has two
 * hardware threads, whose numbers differ by eight. */
static void describe_cpu(uint32_t cpu)
{
	char name[64], text[64];
	uint32_t core = cpu % 8, cache = core / 2 * 2;
	snprintf(name, sizeof name, "cpu%u", cpu);
	make_dir(name);
	snprintf(name, sizeof name, "cpu%u/topology", cpu);
	make_dir(name);
	snprintf(name, sizeof name, "cpu%u/node%u", cpu, core / 4);
	make_dir(name);
	snprintf(name, sizeof name, "cpu%u/topology/thread_siblings_list", cpu);
	snprintf(text, sizeof text, "%u,%u\n", core, core + 8);
	write_file(name, text);
	snprintf(name, sizeof name, "cpu%u/cache", cpu);
	make_dir(name);
	snprintf(name, sizeof name, "cpu%u/cache/index0", cpu);
	make_dir(name);
	snprintf(name, sizeof name, "cpu%u/cache/index0/shared_cpu_list", cpu);
	write_file(name, text);
	snprintf(name, sizeof name, "cpu%u/cache/index3", cpu);
	make_dir(name);
	snprintf(name, sizeof name, "cpu%u/cache/index3/shared_cpu_list", cpu);
	snprintf(text, sizeof text, "%u-%u,%u-%u\n", cache, cache + 1, cache + 8, cache + 9);
	write_file(name, text);
}

static void check_choice(uint32_t here, uint32_t max, const uint32_t *wanted)
{
	uint32_t allowed[15], cpus[15];
	for (uint32_t i = 0; i < 15; i++)
		allowed[i] = (here + 1 + i) % 16;
	assert_int_equal(job_cpu_choose(allowed, 15, here, root, cpus, max), max);
	for (uint32_t i = 0; i < max; i++)
		assert_int_equal(cpus[i], wanted[i]);
}

static void test_choice(void **state)
{
	(void)state;
	for (uint32_t cpu = 0; cpu < 16; cpu++)
		describe_cpu(cpu);
	/* The other core of the cache, the other cache, the other node; then second threads, also of the owner's core. */
	check_choice(0, 14, (const uint32_t[]){1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14});
	check_choice(5, 14, (const uint32_t[]){12, 6, 7, 8, 9, 10, 11, 13, 4, 14, 15, 0, 1, 2});
	check_choice(13, 3, (const uint32_t[]){4, 14, 15});
	/* Fewer CPUs than asked for: all of them. Without a description: in the order given. */
	uint32_t cpus[3];
	assert_int_equal(job_cpu_choose((const uint32_t[]){9, 1}, 2, 0, root, cpus, 3), 2);
	assert_int_equal(cpus[0], 9);
	assert_int_equal(cpus[1], 1);
	assert_int_equal(job_cpu_choose((const uint32_t[]){9, 1, 4}, 3, 0, "/nowhere", cpus, 2), 2);
	assert_int_equal(cpus[0], 9);
	assert_int_equal(cpus[1], 1);
}

/* The machine of test_choice again. */
static void test_sort(void **state)
{
	(void)state;
	uint32_t cpus[] = {5, 8, 12, 1, 6, 4, 0, 13}, caches[8];
	static const uint32_t sorted[] = {5, 12, 4, 13, 8, 1, 0, 6}, cache[] = {4, 4, 4, 4, 0, 0, 0, 6};
	job_cpu_sort(cpus, 8, root, caches);
	assert_memory_equal(cpus, sorted, sizeof cpus);
	assert_memory_equal(caches, cache, sizeof caches);
	job_cpu_sort(cpus, 1, root, caches);
	assert_int_equal(caches[0], 4);
	job_cpu_sort(cpus, 8, "/nowhere", caches); /* as if all shared one cache */
	assert_memory_equal(cpus, sorted, sizeof cpus);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_version_2), cmocka_unit_test(test_version_1), cmocka_unit_test(test_nonsense),
		cmocka_unit_test(test_affinity),  cmocka_unit_test(test_choice),    cmocka_unit_test(test_sort),
	};
	return cmocka_run_group_tests(tests, setup, teardown);
}
