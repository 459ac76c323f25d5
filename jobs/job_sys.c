#include "jobs/job_sys.h"

#include "jobs/job_contract.h"

#include <linux/membarrier.h>

#define CALIBRATION_NS 50000u    /* how long measure() counts ticks, at least */
#define CALIBRATION_READINGS 4   /* readings at its start, of which it keeps the best */
#define CALIBRATION_ACCURACY 64u /* the rate is wrong by at most one part in this many */

/* The clock and the ticks at one moment. The ticks were read before and after the clock, and lie that far apart. */
typedef struct reading {
	uint64_t clock_ns;
	uint64_t ticks; /* in the middle between the two */
	uint64_t apart; /* large if the thread was interrupted in between */
} reading;

static reading read_both(void)
{
	struct timespec now;
	uint64_t before = job_sys_ticks();
	clock_gettime(CLOCK_MONOTONIC, &now);
	uint64_t apart = job_sys_ticks() - before;
	return (reading){.clock_ns = (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec,
	                 .ticks = before + apart / 2,
	                 .apart = apart};
}

/* Measures the rate of job_sys_ticks: ticks in 2^20 nanoseconds. A reading's ticks are wrong by at most half of
 * `apart`. So an interruption inside a reading makes this take longer, and does not make the rate wrong. */
static uint64_t measure(void)
{
	reading start = read_both(), now;
	for (uint32_t i = 1; i < CALIBRATION_READINGS; i++) {
		now = read_both();
		if (now.apart < start.apart)
			start = now;
	}
	do
		now = read_both();
	while (now.clock_ns - start.clock_ns < CALIBRATION_NS ||
	       (start.apart + now.apart) / 2 * CALIBRATION_ACCURACY > now.ticks - start.ticks);
	return ((now.ticks - start.ticks) << 20) / (now.clock_ns - start.clock_ns);
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

/* The kernel wants a process to register before its first membarrier. At the start of the program, while it has one
 * thread, that takes 1 us; later the kernel lets 5 to 40 ms pass, to be sure that every CPU knows. */
__attribute__((constructor)) static void register_membarrier(void)
{
	syscall(SYS_membarrier, MEMBARRIER_CMD_REGISTER_PRIVATE_EXPEDITED, 0, 0); /* job_sys_membarrier tells if it fails */
}

bool job_sys_membarrier(void)
{
	return syscall(SYS_membarrier, MEMBARRIER_CMD_PRIVATE_EXPEDITED, 0, 0) == 0;
}
