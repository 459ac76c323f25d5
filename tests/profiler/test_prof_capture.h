/* For the profiler's tests: writes a trace to memory and checks it. */
#ifndef STILB_TEST_PROF_CAPTURE_H
#define STILB_TEST_PROF_CAPTURE_H

#include "profiler/prof_internal.h"
#include "profiler/prof_trace.h"
#include "support/trace_check.h"

#include <stdlib.h>
#include <string.h>

typedef struct capture {
	char *text; /* ends in 0 */
	size_t size;
	trace_check_report report;
} capture;

static int capture_write(void *user, const void *data, size_t size)
{
	capture *c = user;
	char *text = realloc(c->text, c->size + size + 1);
	if (!text)
		return -1;
	c->text = text;
	memcpy(c->text + c->size, data, size);
	c->size += size;
	c->text[c->size] = 0;
	return 0;
}

/* 0 if the trace was written and keeps all rules; else report.error says what is wrong. */
static inline int capture_take(capture *c, uint32_t last_frames)
{
	*c = (capture){0};
	stilb_prof_window window = {.last_frames = last_frames};
	stilb_prof_snapshot snapshot = {0};
	int error = stilb_prof_snapshot_take(&snapshot, &window);
	if (error == 0)
		error = stilb_prof_trace_write_chrome(&snapshot, "test", (stilb_prof_sink){capture_write, c});
	stilb_prof_snapshot_finish(&snapshot);
	int broken = trace_check_text(c->text ? c->text : "", c->size, &c->report);
	return error != 0 ? error : broken;
}

static inline void capture_finish(capture *c)
{
	trace_check_finish(&c->report);
	free(c->text);
	*c = (capture){0};
}

#define assert_trace(c, last_frames)                                                                                   \
	do {                                                                                                               \
		if (capture_take(c, last_frames) != 0)                                                                         \
			fail_msg("trace: %s", (c)->report.error);                                                                  \
	} while (0)

#endif
