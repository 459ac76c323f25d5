/*
 * Comparisons: compares two runs zone by zone, with a statistical test that tells a slower zone from noise.
 *
 * Prints: sort got slower, load did not
 */
#include <stilb/prof.h>
#include <stilb/prof_diff.h>
#include <stilb/prof_snapshot.h>

#include <stdio.h>
#include <string.h>
#include <time.h>

/* Sleeps for about that time, in place of real work: the length of an empty zone would depend on what ran before it. */
static void work_for(long us)
{
	nanosleep(&(struct timespec){.tv_nsec = us * 1000}, NULL);
}

static void run(long sort_us)
{
	for (int i = 0; i < 12; i++) {
		PROFILE("load");
		work_for(5000);
		PROFILE_NEXT("sort");
		work_for(sort_us);
	}
}

int main(void)
{
	stilb_prof_snapshot a = {0}, b = {0};
	stilb_prof_diff diff = {0};
	stilb_prof_diff_desc desc = stilb_prof_diff_desc_default();
	desc.threshold = 3; /* four times as long: the machine may be busy */
	if (stilb_prof_thread_begin("main") != 0)
		return 1;
	run(100);
	if (stilb_prof_snapshot_take(&a, NULL) != 0)
		return 1;
	stilb_prof_shutdown(); /* forgets the first run */
	if (stilb_prof_thread_begin("main") != 0)
		return 1;
	run(25000);
	if (stilb_prof_snapshot_take(&b, NULL) != 0 || stilb_prof_diff_make(&diff, &a, &b, &desc) != 0)
		return 1;
	const char *sort = "?", *load = "?";
	for (uint32_t i = 0; i < diff.row_count; i++) {
		const char *verdict = diff.rows[i].verdict == STILB_PROF_SLOWER ? "got slower" : "did not";
		if (strcmp(diff.rows[i].name, "sort") == 0)
			sort = verdict;
		else
			load = verdict;
	}
	printf("sort %s, load %s\n", sort, load);
	stilb_prof_diff_finish(&diff);
	stilb_prof_snapshot_finish(&b);
	stilb_prof_snapshot_finish(&a);
	stilb_prof_shutdown();
	return 0;
}
