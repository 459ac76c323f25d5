/* Compiled three times by test_prof_off.c: zones on, zones off, and no zones in the source (TEST_PROF_NONE). */
#ifndef TEST_PROF_NONE
#include "profiler/prof.h"
STILB_PROF_SITE(hook_site, "hook", 0xff0000);
#endif

int test_prof_off_sum(const int *values, int count);

int test_prof_off_sum(const int *values, int count)
{
	int sum = 0;
#ifndef TEST_PROF_NONE
	PROFILE_FUNCTION();
	PROFILE("sum");
	stilb_prof_zone_begin(&hook_site);
#endif
	for (int i = 0; i < count; i++) {
#ifndef TEST_PROF_NONE
		PROFILE_COLOR("step", 0x00ff00);
#endif
		sum += values[i];
	}
#ifndef TEST_PROF_NONE
	stilb_prof_zone_end();
#endif
	return sum;
}
