/*
 * job_prof: the job system (job.h) seen by the profiler (prof.h). A header alone, for programs that use both libraries,
 * neither of which knows the other. It also compiles as C++17.
 *
 *   stilb_job_pool_desc desc = stilb_job_pool_desc_default();
 *   desc.hooks = stilb_job_prof_hooks("worker");
 *   stilb_job_pool_create(&desc, &pool);
 *
 * What is recorded. Each worker is a lane "worker 1", "worker 2", ...; the pool's owner names its own lane. On each:
 *   zone "job"               a job, or help with a parallel loop; the zones of the job's function lie in it
 *   arrow "job"              from where the job was submitted, or the loop opened, to the beginning of that zone: its
 *                            length is the time in the queue, and the zone is charged to the frame of the submit
 *   zone "wait for workers"  the thread waits for a group, or for slices of its loop, and finds nothing to help with
 *   zone "parked"            the thread has nothing to do and sleeps
 * Cost.        Some 50 ns a job, of which 40 are four reads of the clock; 10 ns while recording is off.
 * Threads.     The pool calls the hooks on the threads concerned. A job's function must close the zones it opens.
 */
#ifndef STILB_JOB_PROF_H
#define STILB_JOB_PROF_H

#include <stilb/job.h>
#include <stilb/prof.h>

#include <stdio.h>
#include <string.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Waits that the calling thread is in the middle of: asleep in one it still waits. */
static __thread uint32_t stilb_job_prof_waits;

static inline void stilb_job_prof_thread_start(void *user, uint32_t worker)
{
	char name[64];
	snprintf(name, sizeof name, "%s %u", (const char *)user, worker);
	stilb_prof_thread_begin(name); /* without memory the worker works on, and the profiler counts what is missing */
}

static inline void stilb_job_prof_thread_stop(void *user, uint32_t worker)
{
	(void)user, (void)worker;
	stilb_prof_thread_end();
}

static inline void stilb_job_prof_park(void *user, uint32_t worker)
{
	STILB_PROF_SITE(stilb_job_prof_parked, "parked", 0x505050);
	(void)user, (void)worker;
	if (stilb_job_prof_waits == 0)
		stilb_prof_zone_begin(&stilb_job_prof_parked);
}

static inline void stilb_job_prof_wake(void *user, uint32_t worker)
{
	(void)user, (void)worker;
	if (stilb_job_prof_waits == 0)
		stilb_prof_zone_end();
}

STILB_PROF_FLOW(stilb_job_prof_flow, "job", 0);

static inline uint64_t stilb_job_prof_submit(void *user, uint32_t worker)
{
	(void)user, (void)worker;
	return stilb_prof_flow_begin(stilb_job_prof_flow);
}

static inline void stilb_job_prof_job_begin(void *user, uint32_t worker, uint64_t tag)
{
	STILB_PROF_SITE(stilb_job_prof_job, "job", 0x93a1b5);
	(void)user, (void)worker;
	stilb_prof_zone_begin(&stilb_job_prof_job);
	stilb_prof_flow_end(stilb_job_prof_flow, tag);
}

static inline void stilb_job_prof_job_end(void *user, uint32_t worker)
{
	(void)user, (void)worker;
	stilb_prof_zone_end();
}

static inline void stilb_job_prof_wait_begin(void *user, uint32_t worker)
{
	STILB_PROF_SITE(stilb_job_prof_wait, "wait for workers", 0x707070);
	(void)user, (void)worker;
	stilb_job_prof_waits++;
	stilb_prof_zone_begin(&stilb_job_prof_wait);
}

static inline void stilb_job_prof_wait_end(void *user, uint32_t worker)
{
	(void)user, (void)worker;
	stilb_prof_zone_end();
	stilb_job_prof_waits--;
}

/* For stilb_job_pool_desc.hooks. workers: what the pool's workers are called before their number, kept by pointer while
 * the pool lives; NULL stands for "worker". Pools that live at the same time are told apart by different names.
 * [any-thread] */
static inline stilb_job_hooks stilb_job_prof_hooks(const char *workers)
{
	stilb_job_hooks hooks;
	memset(&hooks, 0, sizeof hooks);
	hooks.user = (void *)(workers ? workers : "worker");
	hooks.thread_start = stilb_job_prof_thread_start;
	hooks.thread_stop = stilb_job_prof_thread_stop;
	hooks.park = stilb_job_prof_park;
	hooks.wake = stilb_job_prof_wake;
	hooks.submit = stilb_job_prof_submit;
	hooks.job_begin = stilb_job_prof_job_begin;
	hooks.job_end = stilb_job_prof_job_end;
	hooks.wait_begin = stilb_job_prof_wait_begin;
	hooks.wait_end = stilb_job_prof_wait_end;
	return hooks;
}

#ifdef __cplusplus
}
#endif
#endif
