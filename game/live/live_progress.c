#include "live_progress.h"

#include "base/base.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define PROGRESS_QUIET_NS 2000000000u  /* a shorter run shows nothing */
#define PROGRESS_BETWEEN_NS 200000000u /* between two updates of the line */

void live_progress_begin(live_progress *progress)
{
	const char *kind = getenv("TERM");
	bool dumb = kind && strcmp(kind, "dumb") == 0;
	*progress = (live_progress){.start_ns = stilb_time_ns(), .terminal = isatty(STDERR_FILENO) && !dumb};
}

void live_progress_show(live_progress *progress, uint64_t frames, uint64_t wanted)
{
	STILB_ASSERT(progress->start_ns > 0 && (wanted == 0 || frames <= wanted));
	uint64_t now = stilb_time_ns(), passed = now - progress->start_ns;
	if (!progress->terminal || passed < PROGRESS_QUIET_NS || now - progress->last_ns < PROGRESS_BETWEEN_NS)
		return;
	progress->last_ns = now;
	progress->shown = true;
	fprintf(stderr, "\r%" PRIu64, frames);
	if (wanted > 0)
		fprintf(stderr, " of %" PRIu64, wanted);
	fputs(" frames", stderr);
	if (wanted > frames && frames > 0)
		fprintf(stderr, ", %.0f s left", (double)passed * 1e-9 * (double)(wanted - frames) / (double)frames);
	fputs("\033[K", stderr);
}

void live_progress_end(live_progress *progress)
{
	if (progress->shown)
		fputs("\r\033[K", stderr);
}
