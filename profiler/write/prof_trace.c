/* Writing a snapshot to a file, in the format that its name asks for. */
#include "profiler/prof_trace.h"
#include "profiler/prof_internal.h"
#include "profiler/write/prof_file.h"

#include <assert.h>
#include <errno.h>
#include <stdbool.h>
#include <string.h>
#include <strings.h>

static bool prof_path_ends_in(const char *path, const char *ending)
{
	assert(path);
	size_t length = strlen(path), size = strlen(ending);
	return length >= size && strcasecmp(path + length - size, ending) == 0;
}

stilb_prof_form stilb_prof_trace_form(const char *path)
{
	if (prof_path_ends_in(path, ".folded"))
		return STILB_PROF_FORM_FOLDED;
	return prof_path_ends_in(path, ".csv") ? STILB_PROF_FORM_FRAMES_CSV : STILB_PROF_FORM_CHROME;
}

bool stilb_prof_trace_is_named(const char *path)
{
	return prof_path_ends_in(path, ".json") || stilb_prof_trace_form(path) != STILB_PROF_FORM_CHROME;
}

int stilb_prof_trace_check(const char *path)
{
	return prof_file_check(path);
}

static int prof_trace_save(const stilb_prof_snapshot *snapshot, const char *process_name, const char *path, bool fresh)
{
	assert(snapshot && path);
	prof_file file;
	int error = prof_file_open(&file, path, fresh);
	if (error != 0)
		return error;
	stilb_prof_sink sink = {prof_file_write, &file};
	switch (stilb_prof_trace_form(path)) {
	case STILB_PROF_FORM_FOLDED:
		error = stilb_prof_trace_write_folded(snapshot, sink);
		break;
	case STILB_PROF_FORM_FRAMES_CSV:
		error = stilb_prof_trace_write_frames_csv(snapshot, sink);
		break;
	case STILB_PROF_FORM_CHROME:
		error = stilb_prof_trace_write_chrome(snapshot, process_name, sink);
		break;
	}
	return prof_file_commit(&file, error);
}

int stilb_prof_trace_save(const stilb_prof_snapshot *snapshot, const char *process_name, const char *path)
{
	return prof_trace_save(snapshot, process_name, path, false);
}

int prof_trace_save_fresh(const stilb_prof_snapshot *snapshot, const char *process_name, const char *path)
{
	return prof_trace_save(snapshot, process_name, path, true);
}
