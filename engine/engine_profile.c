/* The engine's use of the profiler: starts it and shuts it down, captures and traces. Jobs are recorded through the
 * hooks of job_prof.h. */
#include "engine_internal.h"

#include "profiler/prof.h"
#include "profiler/prof_snapshot.h"
#include "profiler/prof_trace.h"

#include <string.h>

#define EVENTS_PER_MIB 65536u

/* ---- life -------------------------------------------------------------------------------------------------------- */

stilb_result engine_profile_start(const stilb_engine_desc *desc)
{
	if (desc->profile_ring_mib > STILB_ENGINE_PROFILE_RING_MAX ||
	    stilb_prof_ring_events_set(desc->profile_ring_mib * EVENTS_PER_MIB) != 0)
		return stilb_fail(STILB_ERROR_ARGUMENT, "a profiler ring of %u MiB: give a power of two in 1..%u",
		                  desc->profile_ring_mib, STILB_ENGINE_PROFILE_RING_MAX);
	stilb_prof_record_set(desc->profile);
	stilb_prof_switches_set(desc->profile);
	stilb_prof_thread_begin("main"); /* without memory for a ring, the main thread is not profiled */
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
