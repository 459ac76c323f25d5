/* The profiler microprofile as a subject of the suite `profiler`, all groups of zones enabled. MicroProfileFlip empties
 * the buffers of all threads; it is called after each turn (PROFILER_TURN zones), untimed. */
#define MICROPROFILE_WEBSERVER 0
#include <microprofile.h>

#define PROFILER_SCOPE MICROPROFILE_SCOPEI("bench", "empty", 0xff8800)
#include "bench/profiler/profiler_run.h"

static void thread_start(const char *name)
{
	MicroProfileOnThreadCreate(name);
	MicroProfileSetEnableAllGroups(true);
	MicroProfileFlip(nullptr);
	MicroProfileFlip(nullptr);
}

static void thread_stop()
{
}

static void record(int on)
{
	MicroProfileSetEnableAllGroups(on != 0);
	MicroProfileFlip(nullptr);
	MicroProfileFlip(nullptr);
}

static void frame()
{
	MicroProfileFlip(nullptr);
}

static const profiler_subject subject = {"microprofile", profiler_loop_zones, nullptr, nullptr, profiler_loop_work,
                                         thread_start,   thread_stop,         record,  frame,   nullptr,
                                         nullptr};

extern "C" const profiler_subject *const profiler_subjects[] = {&subject, nullptr};
