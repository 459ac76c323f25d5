/*
 * Tables: calls, inclusive and self time and percentiles of each name, for any lanes, frames or range of time. The time
 * of a zone inside another of its name is not counted twice.
 *
 * Prints: walk: 10 calls, main: 1 call; the most time of its own was spent in walk
 */
#include <stilb/prof.h>
#include <stilb/prof_snapshot.h>
#include <stilb/prof_stats.h>

#include <stdio.h>
#include <string.h>
#include <time.h>

static void walk(int depth)
{
	PROFILE_FUNCTION();
	nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
	if (depth > 1)
		walk(depth - 1);
}

static const stilb_prof_row *find(const stilb_prof_stats *stats, const stilb_prof_snapshot *snapshot, const char *name)
{
	for (uint32_t i = 0; i < stats->row_count; i++)
		if (strcmp(snapshot->labels[stats->rows[i].label].name, name) == 0)
			return &stats->rows[i];
	return NULL;
}

int main(void)
{
	stilb_prof_snapshot snapshot = {0};
	stilb_prof_stats stats = {0};
	if (stilb_prof_thread_begin("main") != 0)
		return 1;
	{
		PROFILE_FUNCTION();
		walk(10);
	}
	if (stilb_prof_snapshot_take(&snapshot, NULL) != 0 || stilb_prof_stats_take(&stats, &snapshot, NULL) != 0)
		return 1;
	stilb_prof_stats_sort(&stats, &snapshot, STILB_PROF_BY_SELF);
	const stilb_prof_row *walks = find(&stats, &snapshot, "walk"), *mains = find(&stats, &snapshot, "main");
	if (!walks || !mains || walks->inclusive_ns > mains->inclusive_ns)
		return 1;
	printf("walk: %u calls, main: %u call; the most time of its own was spent in %s\n", walks->calls, mains->calls,
	       snapshot.labels[stats.rows[0].label].name);
	stilb_prof_stats_finish(&stats);
	stilb_prof_snapshot_finish(&snapshot);
	stilb_prof_shutdown();
	return 0;
}
