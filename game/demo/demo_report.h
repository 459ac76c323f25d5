/* demo_report: the results of a run of `stilb demo`, as text and as JSON. [main-thread] */
#ifndef STILB_DEMO_REPORT_H
#define STILB_DEMO_REPORT_H

#include "demo_options.h"
#include "game/cli/stage_times.h"

typedef struct demo_report {
	const demo_options *options;
	const stilb_engine *engine;
	stilb_engine_report last; /* of the last frame that was drawn */
	uint64_t frames;          /* number of frames drawn */
	uint32_t light;           /* a stilb_scene_stress_light */
	stage_summary summary[STAGE_COUNT];
	uint64_t warmup; /* frames at the start that the summary leaves out */
} demo_report;

/* Prints the report on demo_message_stream. */
void demo_report_print(const demo_report *report);

/* Writes the report as JSON to the file options->stats, which must not be NULL. STILB_ERROR_FILE,
 * STILB_ERROR_MEMORY. */
stilb_result demo_report_save(const demo_report *report);

#endif
