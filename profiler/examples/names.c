/*
 * Names known at run time only: passes read from a file, scripts, queries. stilb_prof_site_make returns one site for
 * each name; call it once for each name and keep the result.
 *
 * Prints: shadows, opaque, sky; the same site for the same name: yes
 */
#include <stilb/prof.h>
#include <stilb/prof_snapshot.h>

#include <stdio.h>

int main(void)
{
	const char *passes[] = {"shadows", "opaque", "sky"};
	const stilb_prof_site *sites[3];
	stilb_prof_snapshot snapshot = {0};
	if (stilb_prof_thread_begin("main") != 0)
		return 1;
	for (int i = 0; i < 3; i++)
		sites[i] = stilb_prof_site_make(passes[i], 0);
	for (int i = 0; i < 3; i++) {
		stilb_prof_zone_begin(sites[i]);
		stilb_prof_zone_end();
	}
	if (stilb_prof_snapshot_take(&snapshot, NULL) != 0)
		return 1;
	for (uint32_t i = 0; i < snapshot.lanes[0].zone_count; i++)
		printf("%s%s", i > 0 ? ", " : "", snapshot.labels[snapshot.lanes[0].zones[i].label].name);
	printf("; the same site for the same name: %s\n", stilb_prof_site_make("sky", 0) == sites[2] ? "yes" : "no");
	stilb_prof_snapshot_finish(&snapshot);
	stilb_prof_shutdown();
	return 0;
}
