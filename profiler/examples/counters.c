/*
 * Counters and instants: a quantity over time, and a moment. Counters hold integers up to 2^41 exactly.
 *
 * Prints: bytes 1099511627776, bytes 1099511628800, out of memory, bytes 0
 */
#include <stilb/prof.h>
#include <stilb/prof_snapshot.h>

#include <stdio.h>

int main(void)
{
	stilb_prof_snapshot snapshot = {0};
	uint64_t bytes = UINT64_C(1) << 40;
	if (stilb_prof_thread_begin("main") != 0)
		return 1;
	PROFILE_COUNTER("bytes", (double)bytes);
	PROFILE_COUNTER("bytes", (double)(bytes + 1024));
	PROFILE_INSTANT("out of memory");
	PROFILE_COUNTER("bytes", 0);
	if (stilb_prof_snapshot_take(&snapshot, NULL) != 0)
		return 1;
	for (uint32_t i = 0; i < snapshot.point_count; i++) {
		const stilb_prof_point *point = &snapshot.points[i];
		printf("%s%s", i > 0 ? ", " : "", snapshot.labels[point->label].name);
		if (point->counter)
			printf(" %.0f", point->value);
	}
	printf("\n");
	stilb_prof_snapshot_finish(&snapshot);
	stilb_prof_shutdown();
	return 0;
}
