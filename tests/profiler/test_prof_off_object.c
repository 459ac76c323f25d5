/* Compiled three times by test_prof_off.c: zones on, zones off, and no zones in the source (TEST_PROF_NONE). */
#ifndef TEST_PROF_NONE
#include "profiler/prof.h"
STILB_PROF_SITE(hook_site, "hook", 0xff0000);
STILB_PROF_FLOW(job_flow, "job", 0x0000ff);
#define RECORD(what) what
#else
#define RECORD(what)
#endif

int test_prof_off_sum(const int *values, int count);

int test_prof_off_sum(const int *values, int count)
{
	int sum = 0;
	RECORD(PROFILE_FUNCTION();)
	RECORD(PROFILE("sum");)
	RECORD(stilb_prof_zone_begin(&hook_site);)
	RECORD(stilb_prof_flow_end(job_flow, stilb_prof_flow_begin(job_flow));)
	RECORD(PROFILE_BEGIN("begin");)
	for (int i = 0; i < count; i++) {
		RECORD(PROFILE_COLOR("step", 0x00ff00);)
		RECORD(PROFILE_PRECISE("exactly");)
		RECORD(PROFILE_COUNTER("value", values[i]);)
		sum += values[i];
	}
	RECORD(PROFILE_NEXT("next");)
	RECORD(PROFILE_INSTANT("instant");)
	RECORD(PROFILE_END();)
	RECORD(stilb_prof_lane_zone(0, &hook_site, 0, 0, 0);)
	RECORD(stilb_prof_zone_end();)
	return sum;
}
