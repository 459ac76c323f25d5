/* Writes one capture to a file. Two threads may do so at once: a crash does not wait for another capture. */
#include "profiler/prof_capture_internal.h"
#include "profiler/prof_trace.h"

#include <assert.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* The settings of the captures. Unchanged while a capturing thread runs, except `files`. */
static struct {
	stilb_prof_capture_desc desc; /* its strings belong to the caller: use the copies path and process_name */
	char *path, *process_name;
	uint32_t files; /* file numbers below this are in use: by earlier runs, written files, or files being written */
} prof_output;

void prof_capture_file_forget(void)
{
	free(prof_output.path);
	free(prof_output.process_name);
	prof_output.path = prof_output.process_name = NULL;
}

int prof_capture_file_set_up(const stilb_prof_capture_desc *desc)
{
	assert(desc && desc->path && !prof_output.path && "the last output is forgotten");
	prof_output.desc = *desc;
	prof_output.path = strdup(desc->path);
	prof_output.process_name = desc->process_name ? strdup(desc->process_name) : NULL;
	prof_output.files = 0;
	if (prof_output.path && (!desc->process_name || prof_output.process_name))
		return 0;
	prof_capture_file_forget();
	return -ENOMEM;
}

uint64_t prof_capture_frame(void)
{
	uint64_t begun = prof_frames_begun();
	return begun > 0 ? begun - 1 : 0;
}

/* True if the output is stdout, a device or a pipe: then all captures go to it instead of to numbered files. */
static bool prof_capture_is_stream(void)
{
	assert(prof_output.path && "set up");
	struct stat status;
	return strcmp(prof_output.path, "-") == 0 || (stat(prof_output.path, &status) == 0 && !S_ISREG(status.st_mode));
}

/* The path of file number n, counted from 0, in a new string; the first has no number in its name. NULL: no memory. */
static char *prof_capture_path(uint32_t n)
{
	const char *path = prof_output.path, *slash = strrchr(path, '/');
	const char *name = slash ? slash + 1 : path, *dot = strrchr(name, '.');
	char *numbered = NULL;
	if (n == 0 || prof_capture_is_stream())
		return strdup(path);
	if (!dot || dot == name)
		dot = name + strlen(name);
	return asprintf(&numbered, "%.*s-%u%s", (int)(dot - path), path, n + 1, dot) >= 0 ? numbered : NULL;
}

/* The frames before and after frame if all of them have ended; else all frames from the first on. */
static stilb_prof_window prof_capture_window(uint64_t frame, uint32_t after)
{
	assert(frame <= prof_capture_frame() && "not a frame to come");
	uint32_t before = prof_output.desc.frames_before;
	uint64_t first = frame > before ? frame - before : 0;
	uint64_t whole = prof_capture_frame();
	if (whole > frame + after)
		return (stilb_prof_window){.first_frame = first, .frame_count = (uint32_t)(frame + after - first) + 1};
	return (stilb_prof_window){.last_frames = whole > first ? (uint32_t)(whole - first) : 1};
}

/* Takes a snapshot of the window and saves it at path; *frame_count is its number of frames. -ENODATA: the requested
 * frame has been overwritten. If only some of the frames before it have been, that is no error. */
static int prof_capture_save(const char *path, const stilb_prof_window *window, uint64_t frame, uint32_t *frame_count)
{
	assert(window->last_frames > 0 || window->frame_count > 0);
	stilb_prof_snapshot snapshot = {0};
	int error = path ? stilb_prof_snapshot_take(&snapshot, window) : -ENOMEM;
	*frame_count = snapshot.frame_count;
	if (error == 0 && window->frame_count > 0 && (*frame_count == 0 || snapshot.frames[0].number > frame))
		error = -ENODATA;
	if (error == 0)
		error = prof_trace_save_fresh(&snapshot, prof_output.process_name, path);
	stilb_prof_snapshot_finish(&snapshot);
	return error;
}

/* Reserves a number for this thread and returns its path. Numbers of existing files are skipped; if a file appears
 * after that check, saving fails with -EEXIST. NULL: no memory. */
static char *prof_capture_reserve(uint32_t *n)
{
	for (;;) {
		/* Relaxed, as in prof_capture_give_back: the number is all that the threads share. */
		*n = __atomic_fetch_add(&prof_output.files, 1, __ATOMIC_RELAXED);
		char *path = prof_capture_path(*n);
		if (!path || prof_capture_is_stream() || access(path, F_OK) != 0)
			return path;
		free(path);
	}
}

/* Releases number n, unless the other thread has reserved the next one. */
static void prof_capture_give_back(uint32_t n)
{
	assert(n < __atomic_load_n(&prof_output.files, __ATOMIC_RELAXED) && "the number was reserved");
	uint32_t last = n + 1;
	__atomic_compare_exchange_n(&prof_output.files, &last, n, false, __ATOMIC_RELAXED, __ATOMIC_RELAXED);
}

int prof_capture_write(stilb_prof_cause cause, uint64_t frame, uint64_t frame_ns, uint32_t after)
{
	assert(prof_capture_is_thread && cause <= STILB_PROF_CAUSE_CRASH);
	stilb_prof_window window = prof_capture_window(frame, after);
	stilb_prof_captured captured = {.cause = cause, .frame = frame, .frame_ms = 1e-6 * (double)frame_ns};
	char *path = NULL;
	uint32_t n;
	do {
		free(path);
		path = prof_capture_reserve(&n);
		captured.error = prof_capture_save(path, &window, frame, &captured.frame_count);
	} while (captured.error == -EEXIST);
	captured.path = path ? path : prof_output.path;
	if (captured.error != 0)
		prof_capture_give_back(n);
	if (prof_output.desc.done)
		prof_output.desc.done(prof_output.desc.user, &captured);
	free(path);
	return captured.error;
}
