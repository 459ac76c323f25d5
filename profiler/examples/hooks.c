/*
 * Hooks: a zone whose begin and end lie in different functions, for example in two callbacks of a library. Its site is
 * defined by STILB_PROF_SITE. A zone that has not ended is in the snapshot as open.
 *
 * Prints: request, open: no; parse, open: no; request, open: yes
 */
#include <stilb/prof.h>
#include <stilb/prof_snapshot.h>

#include <stdio.h>

STILB_PROF_SITE(site_request, "request", 0xd08030);
STILB_PROF_SITE(site_parse, "parse", 0);

static void on_request_begin(void)
{
	stilb_prof_zone_begin(&site_request);
}

static void on_request_end(void)
{
	stilb_prof_zone_end();
}

int main(void)
{
	stilb_prof_snapshot snapshot = {0};
	if (stilb_prof_thread_begin("main") != 0)
		return 1;
	on_request_begin();
	stilb_prof_zone_begin(&site_parse);
	stilb_prof_zone_end();
	on_request_end();
	on_request_begin();
	if (stilb_prof_snapshot_take(&snapshot, NULL) != 0)
		return 1;
	for (uint32_t i = 0; i < snapshot.lanes[0].zone_count; i++) {
		const stilb_prof_zone *zone = &snapshot.lanes[0].zones[i];
		printf("%s%s, open: %s", i > 0 ? "; " : "", snapshot.labels[zone->label].name, zone->open ? "yes" : "no");
	}
	printf("\n");
	on_request_end();
	stilb_prof_snapshot_finish(&snapshot);
	stilb_prof_shutdown();
	return 0;
}
