/* What a render came to: words on stdout, and --stats. */
#ifndef STILB_RENDER_REPORT_H
#define STILB_RENDER_REPORT_H

#include "render_work.h"

stilb_result offline_report_save(const offline_options *options, const offline_result *result);

void offline_report_print(const offline_options *options, const offline_result *result);

#endif
