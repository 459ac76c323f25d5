/* The lowest priority, for the thread that writes captures (prof_capture.h). */
#include "profiler/prof_internal.h"

#include <sched.h>
#include <sys/resource.h>

#define PROF_BACKGROUND_NS 50000

__thread bool prof_background;

static __thread uint64_t prof_background_since;

/* Nice 19 and not SCHED_IDLE: while other threads keep all CPUs busy, a SCHED_IDLE thread gets almost no time, and the
 * rings are overwritten before it has copied them. */
void prof_background_begin(void)
{
	setpriority(PRIO_PROCESS, 0, 19); /* on Linux: of this thread alone */
	prof_background = true;
	prof_background_since = stilb_prof_clock_monotonic();
}

void prof_background_yield(void)
{
	assert(prof_background && "only the capture's thread gives way");
	if (stilb_prof_clock_monotonic() - prof_background_since < PROF_BACKGROUND_NS)
		return;
	sched_yield();
	prof_background_since = stilb_prof_clock_monotonic();
}
