/* The calls of prof_read.h: files, errors, memory. */
#include "profiler/prof_read.h"

#include "profiler/prof_array.h"
#include "profiler/read/prof_read_internal.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define PROF_READ_CHUNK ((size_t)1 << 20)

/* Frees what is only needed while reading. */
static void prof_read_free_rest(prof_read *read)
{
	free(read->label_slots);
	free(read->lane_slots);
	free(read->ends);
	free(read->marks);
	if (read->scan.c_locale != (locale_t)0)
		freelocale(read->scan.c_locale);
	read->label_slots = NULL;
	read->lane_slots = NULL;
	read->ends = NULL;
	read->marks = NULL;
	read->scan = (prof_scan){0};
}

static void prof_read_destroy(void *memory)
{
	prof_read *read = memory;
	prof_read_free_rest(read);
	for (size_t i = 0; i < read->lane_count; i++) {
		free(read->lanes[i].zones);
		free(read->lanes[i].switches);
	}
	prof_strings_free(&read->strings);
	free(read->labels);
	free(read->lanes);
	free(read->points);
	free(read->out_lanes);
	free(read->out_frames);
	free(read->out_flows);
	free(read);
}

/* ---- errors ------------------------------------------------------------------------------------------------------ */

static int prof_read_say(int result, char *error, size_t error_size, const char *format, ...)
	__attribute__((format(printf, 4, 5)));

static int prof_read_say(int result, char *error, size_t error_size, const char *format, ...)
{
	va_list arguments;
	va_start(arguments, format);
	if (error && error_size > 0)
		vsnprintf(error, error_size, format, arguments);
	va_end(arguments);
	return result;
}

#define PROF_READ_FOUND 48

/* Describes, for the error message, the text at the error: a whole number if there is one, else one byte. */
static void prof_read_found(const prof_scan *scan, char found[PROF_READ_FOUND])
{
	assert(scan->failed >= scan->begin && scan->failed <= scan->end);
	const char *end = scan->failed;
	while (end < scan->end && end - scan->failed < 24 && *end != '\0' && strchr("+-.0123456789eE", *end))
		end++;
	unsigned char c = scan->failed < scan->end ? (unsigned char)*scan->failed : 0;
	if (scan->failed == scan->end)
		snprintf(found, PROF_READ_FOUND, "the file ends");
	else if (c == '-' || (c >= '0' && c <= '9'))
		snprintf(found, PROF_READ_FOUND, "there is '%.*s'", (int)(end - scan->failed), scan->failed);
	else if (c > 0x20 && c < 0x7f)
		snprintf(found, PROF_READ_FOUND, "there is '%c'", c);
	else
		snprintf(found, PROF_READ_FOUND, "there is byte 0x%02x", c);
}

static int prof_read_bad(const prof_scan *scan, const char *name, char *error, size_t error_size)
{
	char found[PROF_READ_FOUND];
	size_t line = 1;
	for (const char *at = scan->begin; at < scan->failed; at++)
		line += *at == '\n';
	prof_read_found(scan, found);
	return prof_read_say(-EBADMSG, error, error_size, "'%s', line %zu, byte %zu of %zu: expected %s, but %s", name,
	                     line, (size_t)(scan->failed - scan->begin) + 1, (size_t)(scan->end - scan->begin),
	                     scan->expected, found);
}

/* ---- the calls --------------------------------------------------------------------------------------------------- */

int stilb_prof_trace_parse(const char *text, size_t size, const char *name, stilb_prof_snapshot *snapshot, char *error,
                           size_t error_size)
{
	assert((text || size == 0) && name && snapshot && (error || error_size == 0));
	stilb_prof_snapshot_finish(snapshot);
	prof_read *read = calloc(1, sizeof *read);
	if (!read)
		return prof_read_say(-ENOMEM, error, error_size, "'%s': no memory to read it", name);
	read->memory.destroy = prof_read_destroy;
	read->scan = (prof_scan){.begin = text, .at = text, .end = text + size};
	int result = 0;
	if (!prof_read_events(read) && !read->no_memory)
		result = prof_read_bad(&read->scan, name, error, error_size);
	else if (read->no_memory || !prof_read_link(read, snapshot))
		result = prof_read_say(-ENOMEM, error, error_size, "'%s': no memory for what %zu bytes tell", name, size);
	if (result == 0)
		prof_read_free_rest(read);
	else
		prof_read_destroy(read);
	return result;
}

/* False if the text so far cannot begin a trace: then the rest, which may be endless, is not read. */
static bool prof_may_be_trace(const char *text, size_t size)
{
	size_t space = strspn(text, " \t\r\n"); /* a 0 byte follows the text */
	return space == size || text[space] == '{' || text[space] == '[';
}

/* Reads all of a file or of standard input, or the beginning of it if that cannot be a trace. Returns 0 or a negative
 * errno; the caller frees *text in both cases. */
static int prof_read_bytes(int file, char **text, size_t *size)
{
	assert(!*text && *size == 0);
	size_t capacity = 0;
	struct stat info;
	size_t expected = fstat(file, &info) == 0 && info.st_size > 0 ? (size_t)info.st_size : 0;
	for (;;) {
		size_t wanted = *size < expected ? expected + 2 : *size + PROF_READ_CHUNK;
		if (!prof_array_room(text, 1, wanted, &capacity))
			return -ENOMEM;
		ssize_t got = read(file, *text + *size, capacity - *size - 1);
		if (got == 0)
			return 0;
		if (got < 0 && errno != EINTR)
			return -errno;
		*size += got > 0 ? (size_t)got : 0;
		(*text)[*size] = '\0';
		if (!prof_may_be_trace(*text, *size))
			return 0;
	}
}

/* Opens a regular file. Returns a descriptor or a negative errno; -ESPIPE: a pipe or a device. O_NONBLOCK keeps open
 * from waiting for the writer of a pipe; it has no effect on regular files. */
static int prof_read_open(const char *path)
{
	struct stat info;
	int file = open(path, O_RDONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK);
	if (file < 0)
		return -errno;
	int error = fstat(file, &info) != 0 ? -errno
	            : S_ISREG(info.st_mode) ? 0
	            : S_ISDIR(info.st_mode) ? -EISDIR
	                                    : -ESPIPE;
	if (error == 0)
		return file;
	close(file);
	return error;
}

int stilb_prof_trace_read(const char *path, stilb_prof_snapshot *snapshot, char *error, size_t error_size)
{
	assert(path && snapshot && (error || error_size == 0));
	bool is_stdin = strcmp(path, "-") == 0;
	char *text = NULL;
	size_t size = 0;
	stilb_prof_snapshot_finish(snapshot);
	int file = is_stdin ? STDIN_FILENO : prof_read_open(path);
	int result = file < 0 ? file : prof_read_bytes(file, &text, &size);
	if (file >= 0 && !is_stdin)
		close(file);
	if (file == -ESPIPE)
		prof_read_say(result, error, error_size,
		              "cannot read '%s': it is a device or a pipe; give a regular file, or '-' for standard input",
		              path);
	else if (result != 0)
		prof_read_say(result, error, error_size, "cannot read '%s': %s", path, strerror(-result));
	else
		result = stilb_prof_trace_parse(text, size, path, snapshot, error, error_size);
	free(text);
	return result;
}
