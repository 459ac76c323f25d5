/* Functions that the parts of stilb trace share; see trace.h. */
#include "trace.h"

#include "game/cli/flags.h"

#include "base/base_file.h"
#include "profiler/prof_read.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

trace_files trace_take_files(int wanted, int *argc, char ***argv)
{
	STILB_ASSERT(wanted == 1 || wanted == 2);
	trace_files files = {.wanted = wanted};
	while (*argc > 0 && files.count < wanted && ((*argv)[0][0] != '-' || (*argv)[0][1] == '\0')) {
		files.path[files.count++] = (*argv)[0];
		(*argc)--;
		(*argv)++;
	}
	return files;
}

bool trace_check(const char *command, const trace_files *files, const char *output)
{
	STILB_ASSERT(command && (files->wanted == 1 || files->wanted == 2));
	for (int i = 0; i < files->wanted; i++)
		if (i >= files->count || !files->path[i][0]) {
			stilb_log(
				"no file to read; give it before the flags: stilb trace %s %s; 'stilb demo --trace FILE' writes one",
				command, files->wanted == 1 ? "FILE" : "A B");
			return false;
		} else if (output && stilb_file_same(files->path[i], output)) {
			stilb_log("the output would replace '%s'; give it another name", files->path[i]);
			return false;
		}
	if (!output || stilb_file_check(output) == STILB_OK)
		return true;
	stilb_log("%s", stilb_error_message());
	return false;
}

bool trace_load(const char *path, stilb_prof_snapshot *trace)
{
	char error[512];
	if (stilb_prof_trace_read(path, trace, error, sizeof error) != 0)
		stilb_log("%s", error);
	else if (trace_zone_count(trace) == 0)
		stilb_log("'%s' is a trace without zones; was the profiler off when it was recorded?", path);
	else
		return true;
	return false;
}

void trace_print_name(FILE *out, const char *name, stilb_prof_lane_kind kind)
{
	for (const unsigned char *c = (const unsigned char *)name; *c; c++) {
		if (c[0] == 0xc2 && c[1] >= 0x80 && c[1] < 0xa0) { /* U+0080..U+009F: control characters in UTF-8 */
			fputc('?', out);
			c++;
		} else {
			fputc(*c < 0x20 || *c == 0x7f ? '?' : *c, out);
		}
	}
	fprintf(out, "%s\n", kind == STILB_PROF_LANE_DEVICE ? " (device)" : "");
}

uint64_t trace_zone_count(const stilb_prof_snapshot *trace)
{
	uint64_t zones = 0;
	for (uint32_t i = 0; i < trace->lane_count; i++)
		zones += trace->lanes[i].zone_count;
	return zones;
}

static uint32_t trace_slowest(const stilb_prof_snapshot *trace)
{
	STILB_ASSERT(trace->frame_count > 0);
	uint32_t slowest = 0;
	for (uint32_t i = 1; i < trace->frame_count; i++)
		if (trace_frame_ns(&trace->frames[i]) > trace_frame_ns(&trace->frames[slowest]))
			slowest = i;
	return slowest;
}

bool trace_choose_frame(const stilb_prof_snapshot *trace, const char *file, const char *text, uint32_t *frame)
{
	STILB_ASSERT(text && frame);
	if (trace->frame_count == 0) {
		stilb_log("--frame: there are no whole frames in '%s'", file);
		return false;
	}
	*frame = trace_slowest(trace);
	if (strcmp(text, "slowest") == 0)
		return true;
	bool digits = strspn(text, "0123456789") == strlen(text);
	uint64_t number = strtoull(text, NULL, 10);
	for (uint32_t i = 0; digits && i < trace->frame_count; i++)
		if (trace->frames[i].number == number) {
			*frame = i;
			return true;
		}
	stilb_log("--frame: '%s' is neither 'slowest' nor a frame of '%s', which has %" PRIu64 "..%" PRIu64, text, file,
	          trace->frames[0].number, trace->frames[trace->frame_count - 1].number);
	return false;
}

void trace_print_summary(FILE *out, const char *path, const stilb_prof_snapshot *trace)
{
	fprintf(out, "%s: %.3f ms, %" PRIu32 " lanes, %" PRIu64 " zones", path, trace_ms(trace->end_ns - trace->begin_ns),
	        trace->lane_count, trace_zone_count(trace));
	if (trace->frame_count > 0) {
		const stilb_prof_frame *slowest = &trace->frames[trace_slowest(trace)];
		fprintf(out, ", %" PRIu32 " frames (%.3f ms on average, the slowest is %" PRIu64 " with %.3f ms)",
		        trace->frame_count,
		        trace_ms(trace->frames[trace->frame_count - 1].end_ns - trace->frames[0].begin_ns) / trace->frame_count,
		        slowest->number, trace_ms(trace_frame_ns(slowest)));
	}
	fprintf(out, "\n");
	if (trace->events_lost > 0 || trace->too_deep > 0)
		fprintf(out, "%" PRIu64 " older events were overwritten, %" PRIu64 " zones nested too deep to be recorded\n",
		        trace->events_lost, trace->too_deep);
	if (trace->without_ring > 0)
		fprintf(out, "%" PRIu64 " zones and other events are missing: there was no memory to record their threads\n",
		        trace->without_ring);
}

void trace_json_ns(stilb_json *json, const char *key, uint64_t ns)
{
	stilb_json_int(json, key, (int64_t)(ns < INT64_MAX ? ns : INT64_MAX));
}
