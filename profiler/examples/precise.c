/*
 * Precise zones: rdtsc does not wait for earlier instructions, so a zone reads some nanoseconds too short.
 * PROFILE_PRECISE waits for them, which takes time itself. A snapshot says by how much other zones are too short.
 *
 * Prints: zones: 2, the error of the first is known: yes
 */
#include <stilb/prof.h>
#include <stilb/prof_snapshot.h>

#include <stdio.h>

static uint64_t chain(uint64_t value)
{
	for (int i = 0; i < 40; i++)
		value = value * 6364136223846793005u + 1442695040888963407u;
	return value;
}

int main(void)
{
	static volatile uint64_t result;
	stilb_prof_snapshot snapshot = {0};
	if (stilb_prof_thread_begin("main") != 0)
		return 1;
	{
		PROFILE("as it is");
		result = chain(1);
	}
	{
		PROFILE_PRECISE("to the end");
		result = chain(result);
	}
	if (stilb_prof_snapshot_take(&snapshot, NULL) != 0)
		return 1;
	printf("zones: %u, the error of the first is known: %s\n", snapshot.lanes[0].zone_count,
	       snapshot.bias_ns >= 0 && snapshot.resolution_ns > 0 ? "yes" : "no");
	stilb_prof_snapshot_finish(&snapshot);
	stilb_prof_shutdown();
	return 0;
}
