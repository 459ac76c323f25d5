/* The writer of input_recording.h. All lines of an event are composed in one buffer and written by one call. */
#include "input/input_recording_internal.h"

#include "base/base_contract.h"
#include "base/base_file.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#define RECORDER_TEXT_MAX 1024u /* characters of an event's lines without the hexadecimal bytes */

struct stilb_input_recorder {
	stilb_owner owner;
	stilb_file file;
	bool failed; /* nothing more is written; `why` is the reason */
	char why[256];
	int64_t start_us, last_us;
	uint32_t described;                      /* pads that were added so far, removed ones included */
	uint32_t count;                          /* pads that were added and not removed, */
	uint32_t pads[INPUT_RECORDING_PADS_MAX]; /* and their numbers (stilb_input_event.pad) */
	uint32_t current;                        /* number of the pad of the last D line; 0: there is none yet */
	uint64_t reports;
	size_t length;
	char text[RECORDER_TEXT_MAX + 3 * (STILB_INPUT_DESCRIPTOR_MAX + STILB_INPUT_REPORT_MAX)];
};

/* For STILB_CHECK: no more pads are present than were added, and the last time is not before the first. */
static bool recorder_is_sound(const stilb_input_recorder *recorder)
{
	return recorder->count <= recorder->described && recorder->described <= INPUT_RECORDING_PADS_MAX &&
	       recorder->last_us >= recorder->start_us && recorder->length <= sizeof recorder->text;
}

static stilb_result recorder_say(const stilb_input_recorder *recorder)
{
	return stilb_fail(STILB_ERROR_FILE, "cannot record to '%s': %s", recorder->file.path, recorder->why);
}

static stilb_result recorder_fail(stilb_input_recorder *recorder, const char *why)
{
	recorder->failed = true;
	snprintf(recorder->why, sizeof recorder->why, "%s", why);
	return recorder_say(recorder);
}

/* ---- text -------------------------------------------------------------------------------------------------------- */

static void recorder_print(stilb_input_recorder *recorder, const char *format, ...)
	__attribute__((format(printf, 2, 3)));

static void recorder_print(stilb_input_recorder *recorder, const char *format, ...)
{
	va_list arguments;
	va_start(arguments, format);
	size_t room = sizeof recorder->text - recorder->length;
	int length = vsnprintf(recorder->text + recorder->length, room, format, arguments);
	va_end(arguments);
	STILB_ASSERT(length >= 0 && (size_t)length < room);
	recorder->length += (size_t)length;
}

static void recorder_print_bytes(stilb_input_recorder *recorder, const uint8_t *bytes, uint32_t size)
{
	static const char digits[] = "0123456789abcdef";
	STILB_ASSERT(recorder->length + 3 * (size_t)size < sizeof recorder->text);
	char *to = recorder->text + recorder->length;
	for (uint32_t i = 0; i < size; i++) {
		*to++ = ' ';
		*to++ = digits[bytes[i] >> 4];
		*to++ = digits[bytes[i] & 15];
	}
	*to++ = '\n';
	recorder->length += 3 * (size_t)size + 1;
}

static void recorder_print_time(stilb_input_recorder *recorder, const char *before)
{
	int64_t us = recorder->last_us - recorder->start_us;
	recorder_print(recorder, "%s %06" PRId64 ".%06" PRId64, before, us / 1000000, us % 1000000);
}

/* ---- events ------------------------------------------------------------------------------------------------------ */

/* Index in recorder->pads of the pad with this number; recorder->count if it is not among them. */
static uint32_t recorder_find(const stilb_input_recorder *recorder, uint32_t pad)
{
	uint32_t i = 0;
	while (i < recorder->count && recorder->pads[i] != pad)
		i++;
	return i;
}

static bool recorder_keeps(const stilb_input_recorder *recorder, const stilb_input_event *event)
{
	switch (event->kind) {
	case STILB_INPUT_PAD_ADDED:
		return event->info->descriptor_size > 0;
	case STILB_INPUT_PAD_REMOVED:
	case STILB_INPUT_PAD_REPORT:
		return recorder_find(recorder, event->pad) < recorder->count;
	case STILB_INPUT_PAD_DENIED:
	case STILB_INPUT_PAD_STATE:
		break;
	}
	return false;
}

/* Time 0 of the file is that of the first event written. An event earlier than the one written before it gets that
 * one's time. */
static void recorder_note_time(stilb_input_recorder *recorder, int64_t time_us)
{
	if (recorder->described == 0)
		recorder->start_us = recorder->last_us = time_us;
	if (time_us > recorder->last_us)
		recorder->last_us = time_us;
}

static void recorder_added(stilb_input_recorder *recorder, uint32_t pad, const stilb_input_pad_info *info)
{
	STILB_ASSERT(recorder_find(recorder, pad) == recorder->count && "a pad is added once");
	STILB_ASSERT(info->descriptor_size <= STILB_INPUT_DESCRIPTOR_MAX);
	recorder->described++;
	recorder->pads[recorder->count++] = pad;
	recorder_print_time(recorder, "# added");
	recorder_print(recorder, "\nR: %u", info->descriptor_size);
	recorder_print_bytes(recorder, info->descriptor, info->descriptor_size);
	recorder_print(recorder, "N: %s\nP: %s\nI: %x %04x %04x\n", info->name, info->path, info->bus, info->vendor,
	               info->product);
}

static void recorder_removed(stilb_input_recorder *recorder, uint32_t pad)
{
	recorder->count--;
	recorder->pads[recorder_find(recorder, pad)] = recorder->pads[recorder->count];
	recorder_print_time(recorder, "# removed");
	recorder_print(recorder, "\n");
}

static void recorder_report(stilb_input_recorder *recorder, const uint8_t *bytes, uint32_t size)
{
	STILB_ASSERT(bytes && size >= 1 && size <= STILB_INPUT_REPORT_MAX);
	recorder->reports++;
	recorder_print_time(recorder, "E:");
	recorder_print(recorder, " %" PRIu32, size);
	recorder_print_bytes(recorder, bytes, size);
}

static void recorder_print_event(stilb_input_recorder *recorder, const stilb_input_event *event)
{
	static const char title[] = "# recorded by Stilb " STILB_VERSION ", in the format of hid-recorder\n";
	recorder->length = 0;
	recorder_note_time(recorder, event->time_us);
	if (recorder->described == 0)
		recorder_print(recorder, "%s", title);
	if (recorder->current != event->pad)
		recorder_print(recorder, "D: %" PRIu32 "\n", event->pad - 1);
	recorder->current = event->pad;
	if (event->kind == STILB_INPUT_PAD_ADDED)
		recorder_added(recorder, event->pad, event->info);
	else if (event->kind == STILB_INPUT_PAD_REMOVED)
		recorder_removed(recorder, event->pad);
	else
		recorder_report(recorder, event->bytes, event->size);
}

stilb_result stilb_input_recorder_add(stilb_input_recorder *recorder, const stilb_input_event *event)
{
	STILB_ASSERT(recorder && event && event->pad != 0);
	STILB_ASSERT(event->kind != STILB_INPUT_PAD_ADDED || event->info);
	STILB_ASSERT_OWNER(recorder->owner);
	if (recorder->failed)
		return recorder_say(recorder);
	if (!recorder_keeps(recorder, event))
		return STILB_OK;
	if (event->kind == STILB_INPUT_PAD_ADDED && recorder->described == INPUT_RECORDING_PADS_MAX)
		return recorder_fail(recorder, "more pads came than a recording may have, 4096");
	if (event->kind == STILB_INPUT_PAD_REPORT && recorder->reports == INPUT_RECORDING_REPORTS_MAX)
		return recorder_fail(recorder, "more reports came than a recording may have, 16777216");
	recorder_print_event(recorder, event);
	STILB_CHECK(recorder_is_sound(recorder));
	int error = stilb_file_write(&recorder->file, recorder->text, recorder->length);
	return error ? recorder_fail(recorder, strerror(-error)) : STILB_OK;
}

/* ---- life -------------------------------------------------------------------------------------------------------- */

stilb_result stilb_input_recorder_create(const char *path, stilb_input_recorder **recorder)
{
	STILB_ASSERT(path && recorder);
	stilb_input_recorder *made = calloc(1, sizeof *made);
	*recorder = NULL;
	if (!made)
		return stilb_fail(STILB_ERROR_MEMORY, "cannot record to '%s': out of memory", path);
	stilb_owner_take(&made->owner);
	stilb_result result = stilb_file_open(&made->file, path);
	if (result != STILB_OK) {
		free(made);
		return result;
	}
	*recorder = made;
	return STILB_OK;
}

/* A recording without a report could not be loaded, so it is not allowed to replace an older file at its path. */
static stilb_result recorder_commit(stilb_input_recorder *recorder)
{
	if (recorder->failed)
		return recorder_say(recorder);
	if (recorder->reports == 0)
		return stilb_fail(STILB_ERROR_FILE, "no gamepad sent a report: '%s' is not written", recorder->file.path);
	return stilb_file_commit(&recorder->file);
}

stilb_result stilb_input_recorder_close(stilb_input_recorder *recorder)
{
	if (!recorder)
		return STILB_OK;
	STILB_ASSERT_OWNER(recorder->owner);
	stilb_result result = recorder_commit(recorder);
	stilb_file_finish(&recorder->file);
	free(recorder);
	return result;
}
