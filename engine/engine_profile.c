/*
 * What the engine tells the profiler: who its threads are, what became of each job, and when to write a file.
 *
 * A job is a zone "job" on the thread that runs it, with an arrow from where it was submitted; so is a thread's help with a
 * loop. A thread that waits for others' part of its own work is in "wait for workers"; one that has nothing to do at all is
 * "parked".
 */
#include "engine_internal.h"

#include "profiler/prof.h"
#include "profiler/prof_snapshot.h"
#include "profiler/prof_trace.h"

#include <stdio.h>
#include <string.h>

#define EVENTS_PER_MIB 65536u

STILB_PROF_SITE(engine_site_job, "job", 0x93a1b5);
STILB_PROF_SITE(engine_site_wait, "wait for workers", 0x707070);
STILB_PROF_SITE(engine_site_parked, "parked", 0x505050);
STILB_PROF_FLOW(engine_flow_job, "job", 0);

/* Waits that this thread is in the middle of. */
static __thread uint32_t engine_waits;

/* ---- jobs ---------------------------------------------------------------------------------------------------------- */

static void engine_on_thread_start(void *user, uint32_t worker)
{
	(void)user;
	char name[32];
	snprintf(name, sizeof name, "worker %u", worker);
	stilb_prof_thread_begin(name); /* without memory for a ring the worker works on, unseen */
}

static void engine_on_thread_stop(void *user, uint32_t worker)
{
	(void)user, (void)worker;
	stilb_prof_thread_end();
}

/* Asleep in a wait it is still waiting. */
static void engine_on_park(void *user, uint32_t worker)
{
	(void)user, (void)worker;
	if (engine_waits == 0)
		stilb_prof_zone_begin(&engine_site_parked);
}

static void engine_on_wake(void *user, uint32_t worker)
{
	(void)user, (void)worker;
	if (engine_waits == 0)
		stilb_prof_zone_end();
}

static uint64_t engine_on_submit(void *user, uint32_t worker)
{
	(void)user, (void)worker;
	return stilb_prof_flow_begin(engine_flow_job);
}

static void engine_on_job_begin(void *user, uint32_t worker, uint64_t tag)
{
	(void)user, (void)worker;
	stilb_prof_zone_begin(&engine_site_job);
	stilb_prof_flow_end(engine_flow_job, tag);
}

static void engine_on_job_end(void *user, uint32_t worker)
{
	(void)user, (void)worker;
	stilb_prof_zone_end();
}

static void engine_on_wait_begin(void *user, uint32_t worker)
{
	(void)user, (void)worker;
	engine_waits++;
	stilb_prof_zone_begin(&engine_site_wait);
}

static void engine_on_wait_end(void *user, uint32_t worker)
{
	(void)user, (void)worker;
	stilb_prof_zone_end();
	engine_waits--;
}

stilb_job_hooks stilb_engine_job_hooks(void)
{
	return (stilb_job_hooks){
		.thread_start = engine_on_thread_start,
		.thread_stop = engine_on_thread_stop,
		.park = engine_on_park,
		.wake = engine_on_wake,
		.submit = engine_on_submit,
		.job_begin = engine_on_job_begin,
		.job_end = engine_on_job_end,
		.wait_begin = engine_on_wait_begin,
		.wait_end = engine_on_wait_end,
	};
}

/* ---- life ---------------------------------------------------------------------------------------------------------- */

stilb_result engine_profile_start(const stilb_engine_desc *desc)
{
	if (desc->profile_ring_mib > STILB_ENGINE_PROFILE_RING_MAX ||
	    stilb_prof_ring_events_set(desc->profile_ring_mib * EVENTS_PER_MIB) != 0)
		return stilb_fail(STILB_ERROR_ARGUMENT, "a profiler ring of %u MiB: give a power of two in 1..%u",
		                  desc->profile_ring_mib, STILB_ENGINE_PROFILE_RING_MAX);
	stilb_prof_record_set(desc->profile);
	stilb_prof_switches_set(desc->profile);
	stilb_prof_thread_begin("main"); /* without memory for a ring all goes on, unseen */
	if (!desc->profile || !desc->capture.path)
		return STILB_OK;
	int error = stilb_prof_capture_start(&desc->capture);
	if (error == 0)
		return STILB_OK;
	return stilb_fail(STILB_ERROR_FILE, "cannot capture to '%s': %s", desc->capture.path, strerror(-error));
}

void engine_profile_stop_capture(void)
{
	stilb_prof_capture_stop();
}

void engine_profile_stop(void)
{
	stilb_prof_thread_end();
	stilb_prof_shutdown();
}

/* ---- files --------------------------------------------------------------------------------------------------------- */

stilb_result stilb_engine_capture(stilb_engine *engine)
{
	if (!engine->desc.profile)
		return stilb_fail(STILB_ERROR_ARGUMENT, "nothing to capture: the profiler is off");
	int error = stilb_prof_capture_now();
	if (error != 0)
		return stilb_fail(STILB_ERROR_ARGUMENT, "cannot capture: %s", strerror(-error));
	engine_input_captured(engine);
	return STILB_OK;
}

stilb_result stilb_engine_trace(stilb_engine *engine, const char *path, uint32_t last_frames)
{
	(void)engine;
	stilb_prof_snapshot snapshot = {0};
	int error = stilb_prof_snapshot_take(&snapshot, &(stilb_prof_window){.last_frames = last_frames});
	if (error == 0)
		error = stilb_prof_trace_save(&snapshot, "stilb", path);
	stilb_prof_snapshot_finish(&snapshot);
	return error == 0 ? STILB_OK : stilb_fail(STILB_ERROR_FILE, "cannot write '%s': %s", path, strerror(-error));
}
