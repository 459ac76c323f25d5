/*
 * Off and on: recording can be switched while the program runs. While it is off, a macro is one load and one branch; if
 * STILB_PROFILE_OFF is defined, macros expand to nothing.
 *
 * Prints: before, after
 */
#include <stilb/prof.h>
#include <stilb/prof_snapshot.h>

#include <stdio.h>

int main(void)
{
	stilb_prof_snapshot snapshot = {0};
	if (stilb_prof_thread_begin("main") != 0)
		return 1;
	{
		PROFILE("before");
	}
	stilb_prof_record_set(false);
	{
		PROFILE("meanwhile");
	}
	stilb_prof_record_set(true);
	{
		PROFILE("after");
	}
	if (stilb_prof_snapshot_take(&snapshot, NULL) != 0)
		return 1;
	for (uint32_t i = 0; i < snapshot.lanes[0].zone_count; i++)
		printf("%s%s", i > 0 ? ", " : "", snapshot.labels[snapshot.lanes[0].zones[i].label].name);
	printf("\n");
	stilb_prof_snapshot_finish(&snapshot);
	stilb_prof_shutdown();
	return 0;
}
