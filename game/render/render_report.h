/* offline_report: the results of a render, as text and as JSON. [main-thread] */
#ifndef STILB_RENDER_REPORT_H
#define STILB_RENDER_REPORT_H

#include "render_work.h"

/* Writes the report as JSON to the file options->stats, which must not be NULL; also for a render that failed.
 * STILB_ERROR_FILE, STILB_ERROR_MEMORY. */
stilb_result offline_report_save(const offline_options *options, const offline_result *result);

/* Prints the report of a render with a picture on offline_message_stream. */
void offline_report_print(const offline_options *options, const offline_result *result);

#endif
