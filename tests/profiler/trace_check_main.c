/* trace_check FILE: if the trace keeps every rule of trace_check.h, prints its counts and exits with 0; else prints the
 * first rule that is broken and exits with 1. */
#include "support/trace_check.h"

#include <inttypes.h>
#include <stdio.h>

int main(int argc, char **argv)
{
	trace_check_report report;
	if (argc != 2) {
		fprintf(stderr, "usage: trace_check FILE.json\n");
		return 1;
	}
	int result = trace_check_file(argv[1], &report);
	if (result != 0) {
		fprintf(stderr, "trace_check: %s: %s\n", argv[1], report.error);
	} else {
		printf("%" PRIu32 " threads, %" PRIu64 " zones (%" PRIu64 " open), %" PRIu64 " frames, %" PRIu64
		       " events lost\n",
		       report.threads, report.zones, report.open_zones, report.frames, report.events_lost);
		for (size_t i = 0; i < report.count_count; i++)
			printf("%10" PRIu64 "  %s / %s\n", report.counts[i].zones, report.counts[i].thread, report.counts[i].name);
	}
	trace_check_finish(&report);
	return result != 0;
}
