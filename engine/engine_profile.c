/* The engine's use of the profiler: starts it and shuts it down, captures and traces. Jobs are recorded through the
 * hooks of job_prof.h. */
#include "engine_internal.h"

#include "profiler/prof.h"
#include "profiler/prof_snapshot.h"
#include "profiler/prof_trace.h"

#include <pthread.h>
#include <stdatomic.h>
#include <string.h>

#define EVENTS_PER_MIB 65536u

/* ---- life -------------------------------------------------------------------------------------------------------- */

/* What the engines of the process share. Guarded by the lock, but for `marks`. */
static struct {
	pthread_mutex_t lock;
	uint32_t engines, recording; /* engines that have started the profiler, and how many of them record */
	/* The engine whose frames are the profiler's; NULL: the next that draws one. Release and acquire: marking frames is
	 * [one-writer], and the next engine marks its first frame after the last one of the engine before. */
	_Atomic(const stilb_engine *) marks;
} profile = {.lock = PTHREAD_MUTEX_INITIALIZER};

/* Counts the engine, or takes it out again. */
static void profile_count(const stilb_engine *engine, int change)
{
	pthread_mutex_lock(&profile.lock);
	profile.engines += (uint32_t)change;
	profile.recording += (uint32_t)(engine->desc.profile ? change : 0);
	if (profile.engines > 0) {
		stilb_prof_record_set(profile.recording > 0);
		stilb_prof_switches_set(profile.recording > 0);
	} else {
		stilb_prof_thread_end();
		stilb_prof_shutdown();
	}
	pthread_mutex_unlock(&profile.lock);
}

stilb_result engine_profile_start(stilb_engine *engine)
{
	const stilb_engine_desc *desc = &engine->desc;
	if (desc->profile_ring_mib > STILB_ENGINE_PROFILE_RING_MAX ||
	    stilb_prof_ring_events_set(desc->profile_ring_mib * EVENTS_PER_MIB) != 0)
		return stilb_fail(STILB_ERROR_ARGUMENT, "a profiler ring of %u MiB: give a power of two in 1..%u",
		                  desc->profile_ring_mib, STILB_ENGINE_PROFILE_RING_MAX);
	profile_count(engine, 1);
	engine->profiled = true;
	stilb_prof_thread_begin("main"); /* without memory for a ring, the main thread is not profiled */
	if (!desc->profile || !desc->capture.path)
		return STILB_OK;
	int error = stilb_prof_capture_start(&desc->capture);
	engine->captures = error == 0;
	if (error == 0)
		return STILB_OK;
	return stilb_fail(STILB_ERROR_FILE, "cannot capture to '%s': %s", desc->capture.path, strerror(-error));
}

void engine_profile_frame(const stilb_engine *engine)
{
	const stilb_engine *marks = NULL;
	/* Acquire: pairs with the release in engine_profile_stop. */
	if (atomic_compare_exchange_strong_explicit(&profile.marks, &marks, engine, memory_order_acquire,
	                                            memory_order_relaxed) ||
	    marks == engine)
		stilb_prof_frame_mark();
}

void engine_profile_stop_capture(stilb_engine *engine)
{
	if (engine->captures)
		stilb_prof_capture_stop();
	engine->captures = false;
}

void engine_profile_stop(stilb_engine *engine)
{
	if (!engine->profiled)
		return;
	if (atomic_load_explicit(&profile.marks, memory_order_relaxed) ==
	    engine)                                                            /* only this engine stores or removes it */
		atomic_store_explicit(&profile.marks, NULL, memory_order_release); /* pairs with engine_profile_frame */
	profile_count(engine, -1);
	engine->profiled = false;
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

stilb_result stilb_engine_capture(stilb_engine *engine)
{
	STILB_ASSERT_OWNER(engine->owner);
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
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT(path);
	(void)engine; /* the profiler is the process's; release builds assert nothing */
	stilb_prof_snapshot snapshot = {0};
	int error = stilb_prof_snapshot_take(&snapshot, &(stilb_prof_window){.last_frames = last_frames});
	if (error == 0)
		error = stilb_prof_trace_save(&snapshot, "stilb", path);
	stilb_prof_snapshot_finish(&snapshot);
	return error == 0 ? STILB_OK : stilb_fail(STILB_ERROR_FILE, "cannot write '%s': %s", path, strerror(-error));
}
