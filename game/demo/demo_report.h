/* What is told of a run of `stilb demo` when it is over: in words, and as JSON. */
#ifndef STILB_DEMO_REPORT_H
#define STILB_DEMO_REPORT_H

#include "demo_options.h"
#include "game/cli/stage_times.h"

typedef struct demo_report {
	const demo_options *options;
	const stilb_engine *engine;
	stilb_engine_report last; /* the last frame drawn */
	uint64_t frames;          /* drawn */
	stage_summary summary[STAGE_COUNT];
	uint64_t warmup; /* frames that the summary leaves out */
} demo_report;

/* To where words go. */
void demo_report_print(const demo_report *report);

/* To the options' file. */
stilb_result demo_report_save(const demo_report *report);

#endif
