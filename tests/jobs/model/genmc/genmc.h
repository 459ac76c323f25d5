/*
 * The real sources of jobs/ under GenMC (Kokologiannakis and Vafeiadis, "GenMC: A Model Checker for Weak Memory
 * Models", CAV 2021), which explores all executions of a small program that the C11 memory model (RC11) allows, and
 * finds races of plain accesses: so it sees the missing acquires and releases that the checker of job_model.h does not
 * see. It is not part of the build. With GenMC 0.10.3 and clang 14, from the top of the repository:
 *
 *   genmc --rc11 --disable-estimation -- -O0 -w -std=gnu17 -D_GNU_SOURCE -I. tests/jobs/model/genmc/genmc_spsc.c
 *
 * It must end with "No errors were detected". Each of the programs takes at most some ten seconds.
 *
 * Tried: it reports an error if a release or acquire of the SPSC queue is relaxed (all but those of close); if the
 * deque's push is a release store or relaxed, or its pop a release store; if cells or links of the lock-free queue are
 * changed relaxed. It does not if the hazard pointer is set by a release store, or the thread's announcement is
 * relaxed: the program is too short.
 *
 * Include this first. GenMC has no memset, and takes no accesses of several sizes to one place, so the programs
 * initialise what they check themselves.
 */
#ifndef GENMC_H
#define GENMC_H

#define NDEBUG /* for the sources: their asserts and checks are run by the model tests */
#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#undef static_assert
#define static_assert _Static_assert

/* size is a multiple of 8. */
static inline void genmc_zero(void *at, size_t size)
{
	for (size_t i = 0; i < size / sizeof(uint64_t); i++)
		((uint64_t *)at)[i] = 0;
}
#undef memset
#define memset(at, byte, size) genmc_zero(at, size)

/* Instead of jobs/queue/job_event.h, which sleeps in the kernel. */
#define STILB_JOB_EVENT_H
#define JOB_EVENT_ALL 1
#define job_event_signal(event, count) ((void)(event))
#define job_event_wait(...) (-ETIMEDOUT)
typedef struct job_event {
	uint32_t waiters;
} job_event;

#endif
