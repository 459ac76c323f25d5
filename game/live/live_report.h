/* live_report: the results of a live run, as text and as JSON. [main-thread] */
#ifndef STILB_LIVE_REPORT_H
#define STILB_LIVE_REPORT_H

#include "game/cli/stage_times.h"
#include "live_options.h"

typedef struct live_report {
	const live_options *options;
	const stilb_engine *engine;
	stilb_engine_report last;         /* of the last frame that was drawn */
	uint64_t frames;                  /* number of frames drawn */
	const stilb_engine_choice *light; /* the choice among kinds of light, NULL: there is none */
	stage_summary summary[STAGE_COUNT];
	uint64_t warmup; /* frames at the start that the summary leaves out */
} live_report;

/* Prints the report on live_message_stream. */
void live_report_print(const live_report *report);

/* Writes the report as JSON to the file options->stats, which must not be NULL. STILB_ERROR_FILE,
 * STILB_ERROR_MEMORY. */
stilb_result live_report_save(const live_report *report);

#endif
