/*
 * job_prof: records in the profiler (prof.h) what the job system (job.h) does. A header alone, for programs that use
 * both libraries; neither library knows the other. It also compiles as C++17.
 *
 * Life cycle.  stilb_job_prof_hooks -> stilb_job_pool_desc.hooks -> stilb_job_pool_create. There is nothing to end.
 * Example.
 *                  stilb_job_pool_desc desc = stilb_job_pool_desc_default();
 *                  desc.hooks = stilb_job_prof_hooks("worker");
 *                  stilb_job_pool_create(&desc, &pool);
 *
 * What is recorded. Each worker is a lane "worker 1", "worker 2", ...; the pool's owner names its own lane. On each:
 *   zone "job"               a job, or help with a parallel loop; the zones of the job's function lie in it
 *   zone of a node's name   in the zone "job", a node of a graph (job_graph.h) that has a name
 *   arrow "job"              from where the job was submitted, or the loop opened, to the beginning of that zone: its
 *                            length is the time in the queue, and the zone is charged to the frame of the submit
 *   zone "wait for workers"  the thread waits for a group, or for slices of its loop, and finds nothing to help with
 *   zone "parked"            the thread has nothing to do and sleeps; sleep inside a wait is part of the wait
 * Cost.        About 50 ns a job, of which four reads of the clock take 40; 10 ns while recording is off.
 * Threads.     The pool calls each hook on the thread that it is about. A job's function must end the zones that it
 *              begins (asserted).
 * Memory.      Without memory for a worker's ring the worker works on; the profiler counts what it could not record
 *              (stilb_prof_snapshot.without_ring).
 */
#ifndef STILB_JOB_PROF_H
#define STILB_JOB_PROF_H

#include <stilb/job.h>
#include <stilb/prof.h>

#include <assert.h>
#include <stdio.h>
#include <string.h>

#ifdef __cplusplus
extern "C" {
#endif

/* How many waits (hook wait_begin to hook wait_end) the calling thread is inside: a job that it runs may wait, too. */
static __thread uint32_t stilb_job_prof_waits;

/* For asserts: true if the calling thread's innermost open zone has that name. Also true if none is open, since zones
 * that were open when recording went off or on are lost, and if zones are nested too deep to be recorded. */
static inline bool stilb_job_prof_innermost_is(const char *name)
{
	const stilb_prof_ring *ring = stilb_prof_thread_ring;
	return ring->depth == 0 || ring->depth > STILB_PROF_DEPTH_MAX ||
	       strcmp(ring->open[ring->depth - 1].site->name, name) == 0;
}

/* ---- the hooks: see stilb_job_hooks in job.h for when each is called; not for use by name ------------------------ */

static inline void stilb_job_prof_thread_start(void *user, uint32_t worker)
{
	assert(user && "hooks made by stilb_job_prof_hooks");
	char name[64];
	snprintf(name, sizeof name, "%s %u", (const char *)user, worker);
	stilb_prof_thread_begin(name); /* an error means no memory: see the head of this file */
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
	assert(stilb_job_prof_waits > 0 || stilb_job_prof_innermost_is("parked"));
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
	assert(stilb_job_prof_innermost_is("job") && "a job ends the zones that it begins");
	stilb_prof_zone_end();
}

static inline void stilb_job_prof_node_begin(void *user, uint32_t worker, const char *name, void **memo)
{
	(void)user, (void)worker;
	if (!*memo)
		*memo = (void *)stilb_prof_site_make(name, 0xa9a36b);
	stilb_prof_zone_begin((const stilb_prof_site *)*memo);
}

static inline void stilb_job_prof_node_end(void *user, uint32_t worker)
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
	assert(stilb_job_prof_waits > 0 && "a wait ends after it has begun");
	assert(stilb_job_prof_innermost_is("wait for workers"));
	stilb_prof_zone_end();
	stilb_job_prof_waits--;
}

/* ---- the public function ----------------------------------------------------------------------------------------- */

/* The hooks for stilb_job_pool_desc.hooks. Workers' lanes are named workers, a space and the worker's number from 1 on.
 * workers has at most 52 bytes, so that the name fits into a lane's 63, and must stay valid as long as the pool; NULL
 * stands for "worker". Give pools that live at the same time different names. [any-thread] */
static inline stilb_job_hooks stilb_job_prof_hooks(const char *workers)
{
	assert(!workers || strlen(workers) <= 52);
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
	hooks.node_begin = stilb_job_prof_node_begin;
	hooks.node_end = stilb_job_prof_node_end;
	hooks.wait_begin = stilb_job_prof_wait_begin;
	hooks.wait_end = stilb_job_prof_wait_end;
	return hooks;
}

#ifdef __cplusplus
}
#endif
#endif
