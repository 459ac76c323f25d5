/* What a render came to: words on stdout, and --stats. */
#ifndef STILB_RENDER_REPORT_H
#define STILB_RENDER_REPORT_H

#include "render_work.h"

stilb_result render_report_save(const render_options *options, const render_result *result);

void render_report_print(const render_options *options, const render_result *result);

#endif
