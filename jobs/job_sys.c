#include "jobs/job_sys.h"

#include "jobs/job_contract.h"

#define CALIBRATION_NS 50000u /* how long measure() counts ticks */

static uint64_t clock_ns(void)
{
	struct timespec now;
	clock_gettime(CLOCK_MONOTONIC, &now);
	return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

/* Measures the rate of job_sys_ticks: ticks in 2^20 nanoseconds. */
static uint64_t measure(void)
{
	uint64_t start = clock_ns(), first = job_sys_ticks(), now;
	do
		now = clock_ns();
	while (now - start < CALIBRATION_NS);
	return ((job_sys_ticks() - first) << 20) / (now - start);
}

uint64_t job_sys_ticks_in(uint64_t nanoseconds)
{
	assert(nanoseconds <= UINT32_MAX && "the product below fits 64 bits");
	/* Relaxed: threads that come here at the same time each measure, and either result serves. */
	static _Atomic uint64_t rate;
	uint64_t ticks = atomic_load_explicit(&rate, memory_order_relaxed);
	if (ticks == 0) {
		ticks = measure();
		assert(ticks > 0 && "the clock runs");
		atomic_store_explicit(&rate, ticks, memory_order_relaxed);
	}
	return nanoseconds * ticks >> 20;
}

bool job_sys_bind(int32_t thread, uint32_t cpu)
{
	assert(thread >= 0);
	assert(cpu < UINT32_MAX && "job_sys_cpu may not know the CPU");
	cpu_set_t *set = CPU_ALLOC(cpu + 1);
	if (!set)
		return false;
	size_t size = CPU_ALLOC_SIZE(cpu + 1);
	CPU_ZERO_S(size, set);
	CPU_SET_S(cpu, size, set);
	bool bound = sched_setaffinity(thread, size, set) == 0;
	CPU_FREE(set);
	return bound;
}
