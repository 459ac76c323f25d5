/* The reader of input_recording.h. The file may come from anywhere: everything is checked before it is used. */
#include "input/input_recording_internal.h"

#include "base/base_contract.h"
#include "input/input_text_internal.h"

#include <errno.h>
#include <inttypes.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#define RECORDING_LINE_MAX 16384u /* characters; the longest valid line has about 12,300: a report of 4096 bytes */
#define RECORDING_BACK_US 1000000 /* a file in which a pad's time goes back by more than this is refused */

typedef struct recording_pad {
	stilb_input_pad_info info;
	uint32_t number; /* event.pad: from 1 */
	bool identified; /* its I line (bus, vendor, product) was read */
	bool removed;
	bool timed;      /* a line with a time was read */
	int64_t last_us; /* the latest of those times, in the file's time */
} recording_pad;

typedef struct recording_event {
	int64_t time_us;
	size_t offset; /* REPORT: index of its first byte in recording->bytes */
	uint16_t pad;  /* index into recording->pads */
	uint16_t size;
	stilb_input_event_kind kind;
} recording_event;

struct stilb_input_recording {
	stilb_owner owner;
	uint32_t pad_count;
	recording_pad *pads[INPUT_RECORDING_PADS_MAX];
	recording_event *events;
	size_t event_count, event_capacity, next;
	uint8_t *bytes; /* the bytes of all reports, one after the other */
	size_t byte_count, byte_capacity;
	uint64_t reports;
};

/* ---- reading lines ----------------------------------------------------------------------------------------------- */

typedef struct recording_parser {
	stilb_input_recording *recording;
	FILE *stream;
	const char *name;
	uint64_t line;    /* number of the line in `text`, from 1 */
	uint32_t number;  /* number of the pad of the last D line, from 1 */
	bool timed;       /* a line with a time was read */
	int64_t first_us; /* the file's first time, which becomes 0 */
	int64_t last_us;  /* the latest time, counted from first_us */
	char text[RECORDING_LINE_MAX];
} recording_parser;

static stilb_result parser_refuse(const recording_parser *parser, const char *format, ...)
	__attribute__((format(printf, 2, 3)));

static stilb_result parser_refuse(const recording_parser *parser, const char *format, ...)
{
	char reason[256];
	va_list arguments;
	va_start(arguments, format);
	vsnprintf(reason, sizeof reason, format, arguments);
	va_end(arguments);
	return stilb_fail(STILB_ERROR_FILE, "cannot read '%s': line %" PRIu64 ": %s", parser->name, parser->line, reason);
}

static stilb_result parser_no_memory(const recording_parser *parser)
{
	return stilb_fail(STILB_ERROR_MEMORY, "cannot read '%s': out of memory", parser->name);
}

/* Reads the next line without its line end. False: there is none; *result is an error if it could not be read. */
static bool parser_next_line(recording_parser *parser, stilb_result *result)
{
	errno = 0;
	if (!fgets(parser->text, sizeof parser->text, parser->stream)) {
		if (ferror(parser->stream))
			*result = stilb_fail(STILB_ERROR_FILE, "cannot read '%s': %s", parser->name, strerror(errno));
		return false;
	}
	parser->line++;
	size_t length = strlen(parser->text);
	bool whole = length > 0 && parser->text[length - 1] == '\n';
	if (!whole && !feof(parser->stream)) {
		*result = parser_refuse(parser, "is longer than %u bytes or has a zero byte; is it a recording?",
		                        RECORDING_LINE_MAX - 2);
		return false;
	}
	length -= whole;
	length -= length > 0 && parser->text[length - 1] == '\r';
	parser->text[length] = '\0';
	return true;
}

static const char *skip_blanks(const char *at)
{
	return at + strspn(at, " \t");
}

/* Reads a number in base 10 or 16 after blanks. Returns what follows it; NULL: there is none, or it is above `most`. */
static const char *take_number(const char *at, int base, uint64_t most, uint64_t *number)
{
	const char *digits = base == 16 ? "0123456789abcdefABCDEF" : "0123456789";
	at = skip_blanks(at);
	size_t length = strspn(at, digits);
	if (length == 0 || length > 16)
		return NULL;
	*number = strtoull(at, NULL, base);
	return *number <= most ? at + length : NULL;
}

/* Reads "000001.250000", a time as hid-recorder writes it: the part after the point counts microseconds. Returns what
 * follows it, or NULL. */
static const char *take_time(const char *at, int64_t *time_us)
{
	uint64_t seconds, us;
	at = take_number(at, 10, UINT32_MAX, &seconds);
	if (!at || at[0] != '.' || strspn(at + 1, "0123456789") != 6)
		return NULL;
	at = take_number(at + 1, 10, 999999, &us);
	if (!at)
		return NULL;
	*time_us = (int64_t)(seconds * 1000000 + us);
	return at;
}

static int hex_digit(char c)
{
	return c >= '0' && c <= '9'   ? c - '0'
	       : c >= 'a' && c <= 'f' ? c - 'a' + 10
	       : c >= 'A' && c <= 'F' ? c - 'A' + 10
	                              : -1;
}

/* Reads bytes of two hexadecimal digits with blanks between them and stores at most `most` of them. Returns how many
 * there are; -1: there is something else. */
static int take_bytes(const char *at, uint8_t *bytes, uint32_t most)
{
	uint32_t count = 0;
	for (const char *next = skip_blanks(at); *next; next = skip_blanks(next + 2), count++) {
		int high = hex_digit(next[0]), low = high < 0 ? -1 : hex_digit(next[1]);
		if (low < 0 || next == at || (next[2] != '\0' && next[2] != ' ' && next[2] != '\t'))
			return -1;
		if (count < most)
			bytes[count] = (uint8_t)(high << 4 | low);
	}
	return (int)count;
}

/* Reads "64 01 80 ...": a size and so many bytes. `what` is the word for them in messages. */
static stilb_result parser_take_bytes(const recording_parser *parser, const char *at, const char *what, uint8_t *bytes,
                                      uint32_t most, uint32_t *size)
{
	uint64_t said;
	at = take_number(at, 10, UINT32_MAX, &said);
	if (!at || said == 0 || said > most)
		return parser_refuse(parser, "the %s's size is not 1..%" PRIu32, what, most);
	int there = take_bytes(at, bytes, most);
	if (there < 0)
		return parser_refuse(parser, "the %s has something other than bytes of two hexadecimal digits", what);
	if ((uint64_t)there != said)
		return parser_refuse(parser, "the %s has %d bytes, not the %" PRIu64 " it says", what, there, said);
	*size = (uint32_t)said;
	return STILB_OK;
}

/* ---- events ------------------------------------------------------------------------------------------------------ */

/* Makes *array large enough for `needed` elements of `size` bytes, doubling it as it grows. False: out of memory. */
static bool grow(void **array, size_t *capacity, size_t needed, size_t size)
{
	if (needed <= *capacity)
		return true;
	size_t more = needed * 2;
	void *grown = realloc(*array, more * size);
	if (!grown)
		return false;
	*array = grown;
	*capacity = more;
	return true;
}

static stilb_result parser_push(recording_parser *parser, stilb_input_event_kind kind, uint32_t pad,
                                const uint8_t *bytes, uint32_t size)
{
	stilb_input_recording *r = parser->recording;
	STILB_ASSERT(pad < r->pad_count && size <= STILB_INPUT_REPORT_MAX);
	if (!grow((void **)&r->events, &r->event_capacity, r->event_count + 1, sizeof *r->events) ||
	    !grow((void **)&r->bytes, &r->byte_capacity, r->byte_count + size, 1))
		return parser_no_memory(parser);
	if (size > 0)
		memcpy(r->bytes + r->byte_count, bytes, size);
	r->events[r->event_count++] = (recording_event){.time_us = parser->last_us,
	                                                .offset = r->byte_count,
	                                                .pad = (uint16_t)pad,
	                                                .size = (uint16_t)size,
	                                                .kind = kind};
	r->byte_count += size;
	return STILB_OK;
}

/* Sets parser->last_us for a line with this time: the file's first time becomes 0, and a time before the latest one
 * counts as the latest. */
static void parser_advance(recording_parser *parser, int64_t time_us)
{
	if (!parser->timed)
		parser->first_us = time_us;
	parser->timed = true;
	if (time_us - parser->first_us > parser->last_us)
		parser->last_us = time_us - parser->first_us;
}

/* Takes the time of a line about one pad; refuses one that goes back by more than RECORDING_BACK_US. */
static stilb_result parser_take_pad_time(recording_parser *parser, recording_pad *pad, int64_t time_us)
{
	if (pad->timed && pad->last_us - time_us > RECORDING_BACK_US)
		return parser_refuse(parser, "the time goes back by %.6f s; are these several recordings?",
		                     (double)(pad->last_us - time_us) * 1e-6);
	if (!pad->timed || time_us > pad->last_us)
		pad->last_us = time_us;
	pad->timed = true;
	parser_advance(parser, time_us);
	return STILB_OK;
}

/* Index of the pad of the last D line; pad_count if no line has described it yet. */
static uint32_t parser_find_pad(const recording_parser *parser)
{
	const stilb_input_recording *r = parser->recording;
	uint32_t i = 0;
	while (i < r->pad_count && r->pads[i]->number != parser->number)
		i++;
	return i;
}

/* The pad that an R, N, P or I line describes; its first such line adds it to the recording. */
static stilb_result parser_describe_pad(recording_parser *parser, recording_pad **pad)
{
	stilb_input_recording *r = parser->recording;
	uint32_t i = parser_find_pad(parser);
	if (i == r->pad_count) {
		if (i == INPUT_RECORDING_PADS_MAX)
			return parser_refuse(parser, "there are more than %u pads", INPUT_RECORDING_PADS_MAX);
		r->pads[i] = calloc(1, sizeof *r->pads[i]);
		if (!r->pads[i])
			return parser_no_memory(parser);
		r->pads[i]->number = parser->number;
		r->pad_count++;
		stilb_result result = parser_push(parser, STILB_INPUT_PAD_ADDED, i, NULL, 0);
		if (result != STILB_OK)
			return result;
	}
	*pad = r->pads[i];
	return (*pad)->removed ? parser_refuse(parser, "pad %" PRIu32 " was removed before", parser->number - 1) : STILB_OK;
}

static bool pad_is_described(const recording_pad *pad)
{
	return pad->info.descriptor_size > 0 && pad->identified;
}

/* Index of the pad that a report or a removal is about; refuses one that was not described or was removed. */
static stilb_result parser_known_pad(const recording_parser *parser, uint32_t *pad)
{
	const stilb_input_recording *r = parser->recording;
	*pad = parser_find_pad(parser);
	if (*pad == r->pad_count || !pad_is_described(r->pads[*pad]))
		return parser_refuse(parser, "pad %" PRIu32 " has no R and I lines before this", parser->number - 1);
	if (r->pads[*pad]->removed)
		return parser_refuse(parser, "pad %" PRIu32 " was removed before", parser->number - 1);
	return STILB_OK;
}

/* ---- kinds of lines ---------------------------------------------------------------------------------------------- */

static stilb_result parser_device(recording_parser *parser, const char *at)
{
	uint64_t number;
	at = take_number(at, 10, UINT32_MAX - 1, &number);
	if (!at || *skip_blanks(at))
		return parser_refuse(parser, "D: needs the pad's number, from 0");
	parser->number = (uint32_t)number + 1;
	return STILB_OK;
}

static stilb_result parser_descriptor(recording_parser *parser, const char *at)
{
	recording_pad *pad;
	uint32_t size;
	stilb_result result = parser_describe_pad(parser, &pad);
	if (result == STILB_OK && pad->info.descriptor_size > 0)
		return parser_refuse(parser, "pad %" PRIu32 " has an R line already", parser->number - 1);
	if (result == STILB_OK)
		result = parser_take_bytes(parser, at, "descriptor", pad->info.descriptor, STILB_INPUT_DESCRIPTOR_MAX, &size);
	if (result == STILB_OK)
		pad->info.descriptor_size = (uint16_t)size;
	return result;
}

/* Reads an N: or P: line, which gives the name or the path of the pad of the last D: line; `at` is the text behind the
 * colon. */
static stilb_result parser_name_or_path(recording_parser *parser, const char *at)
{
	recording_pad *pad;
	bool is_name = parser->text[0] == 'N';
	stilb_result result = parser_describe_pad(parser, &pad);
	if (result == STILB_OK) /* NOLINTNEXTLINE(clang-analyzer-core.CallAndMessage): parser_refuse is never STILB_OK */
		input_text_copy(is_name ? pad->info.name : pad->info.path,
		                is_name ? sizeof pad->info.name : sizeof pad->info.path, at, strlen(at));
	return result;
}

static stilb_result parser_identity(recording_parser *parser, const char *at)
{
	recording_pad *pad;
	uint64_t bus = 0, vendor = 0, product = 0;
	stilb_result result = parser_describe_pad(parser, &pad);
	if (result != STILB_OK)
		return result;
	at = take_number(at, 16, UINT16_MAX, &bus);
	at = at ? take_number(at, 16, UINT16_MAX, &vendor) : NULL;
	at = at ? take_number(at, 16, UINT16_MAX, &product) : NULL;
	if (!at || *skip_blanks(at))
		return parser_refuse(parser, "I: needs bus, vendor and product, like '3 054c 05c4'");
	pad->info.bus = (uint16_t)bus;
	pad->info.vendor = (uint16_t)vendor;
	pad->info.product = (uint16_t)product;
	pad->identified = true;
	return STILB_OK;
}

static stilb_result parser_report(recording_parser *parser, const char *at)
{
	static const char wanted[] = "E: needs time, size and bytes, like '000001.250000 2 01 80'";
	uint8_t bytes[STILB_INPUT_REPORT_MAX];
	uint32_t pad, size = 0;
	int64_t time_us;
	at = take_time(at, &time_us);
	if (!at)
		return parser_refuse(parser, "%s", wanted);
	stilb_result result = parser_known_pad(parser, &pad);
	if (result == STILB_OK)
		result = parser_take_bytes(parser, at, "report", bytes, STILB_INPUT_REPORT_MAX, &size);
	if (result != STILB_OK)
		return result;
	if (parser->recording->reports++ == INPUT_RECORDING_REPORTS_MAX)
		return parser_refuse(parser, "there are more than %u reports", INPUT_RECORDING_REPORTS_MAX);
	result = parser_take_pad_time(parser, parser->recording->pads[pad], time_us);
	return result == STILB_OK ? parser_push(parser, STILB_INPUT_PAD_REPORT, pad, bytes, size) : result;
}

/* Reads "# added TIME" and "# removed TIME", the time being optional, as events; any other remark is skipped. */
static stilb_result parser_remark(recording_parser *parser, const char *at)
{
	uint32_t pad;
	int64_t time_us = 0;
	bool removed = strncmp(at, "removed", 7) == 0;
	if (!removed && strncmp(at, "added", 5) != 0)
		return STILB_OK;
	at = skip_blanks(at + (removed ? 7 : 5));
	const char *end = *at ? take_time(at, &time_us) : at;
	if (!end || *skip_blanks(end))
		return STILB_OK;
	bool timed = *at != '\0';
	if (timed && !removed)
		parser_advance(parser, time_us);
	if (!removed)
		return STILB_OK;
	stilb_result result = parser_known_pad(parser, &pad);
	if (result == STILB_OK && timed)
		result = parser_take_pad_time(parser, parser->recording->pads[pad], time_us);
	if (result != STILB_OK)
		return result;
	parser->recording->pads[pad]->removed = true;
	return parser_push(parser, STILB_INPUT_PAD_REMOVED, pad, NULL, 0);
}

static stilb_result parser_take_line(recording_parser *parser)
{
	static const struct {
		const char *begin;
		stilb_result (*take)(recording_parser *parser, const char *at);
	} kinds[] = {
		{"E:", parser_report},       {"D:", parser_device},   {"R:", parser_descriptor}, {"N:", parser_name_or_path},
		{"P:", parser_name_or_path}, {"I:", parser_identity}, {"#", parser_remark},
	};
	const char *text = parser->text;
	for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
		size_t length = strlen(kinds[i].begin);
		if (strncmp(text, kinds[i].begin, length) == 0)
			return kinds[i].take(parser, text + length + (text[length] == ' '));
	}
	if (*skip_blanks(text) == '\0')
		return STILB_OK;
	return parser_refuse(parser, "does not begin with D: R: N: P: I: E: or #; is it a recording of hid-recorder?");
}

/* For STILB_CHECK: times do not go back, every event has a pad, and its bytes are within r->bytes. */
static bool recording_is_sound(const stilb_input_recording *r)
{
	int64_t last_us = 0;
	for (size_t i = 0; i < r->event_count; i++) {
		const recording_event *event = &r->events[i];
		if (event->time_us < last_us || event->pad >= r->pad_count || event->offset + event->size > r->byte_count)
			return false;
		last_us = event->time_us;
	}
	return r->next <= r->event_count;
}

/* ---- life -------------------------------------------------------------------------------------------------------- */

/* Checks that every pad is described, and that there is a report: without one the replay could not move the camera. */
static stilb_result parser_check_end(const recording_parser *parser)
{
	const stilb_input_recording *r = parser->recording;
	for (uint32_t i = 0; i < r->pad_count; i++)
		if (!pad_is_described(r->pads[i]))
			return stilb_fail(STILB_ERROR_FILE, "cannot read '%s': pad %" PRIu32 " has no %s line", parser->name,
			                  r->pads[i]->number - 1, r->pads[i]->identified ? "R" : "I");
	if (r->reports == 0)
		return stilb_fail(STILB_ERROR_FILE, "cannot read '%s': it holds no report", parser->name);
	return STILB_OK;
}

stilb_result input_recording_read(FILE *stream, const char *name, stilb_input_recording **recording)
{
	STILB_ASSERT(stream && name && recording);
	recording_parser *parser = calloc(1, sizeof *parser);
	stilb_input_recording *made = calloc(1, sizeof *made);
	stilb_result result = STILB_OK;
	*recording = NULL;
	if (!parser || !made) {
		result = stilb_fail(STILB_ERROR_MEMORY, "cannot read '%s': out of memory", name);
	} else {
		parser->recording = made;
		parser->stream = stream;
		parser->name = name;
		parser->number = 1;
		while (result == STILB_OK && parser_next_line(parser, &result))
			result = parser_take_line(parser);
		if (result == STILB_OK)
			result = parser_check_end(parser);
	}
	free(parser);
	if (result == STILB_OK) {
		STILB_CHECK(made && recording_is_sound(made));
		stilb_owner_take(&made->owner);
		*recording = made;
	} else {
		stilb_input_recording_free(made);
	}
	return result;
}

stilb_result stilb_input_recording_load(const char *path, stilb_input_recording **recording)
{
	STILB_ASSERT(path && recording);
	*recording = NULL;
	if (strcmp(path, "-") == 0)
		return input_recording_read(stdin, "standard input", recording);
	FILE *stream = fopen(path, "re");
	if (!stream)
		return stilb_fail(STILB_ERROR_FILE, "cannot read '%s': %s", path, strerror(errno));
	stilb_result result = input_recording_read(stream, path, recording);
	fclose(stream);
	return result;
}

void stilb_input_recording_free(stilb_input_recording *recording)
{
	if (!recording)
		return;
	STILB_ASSERT_OWNER(recording->owner);
	for (uint32_t i = 0; i < recording->pad_count; i++)
		free(recording->pads[i]);
	free(recording->events);
	free(recording->bytes);
	free(recording);
}

/* ---- playing ----------------------------------------------------------------------------------------------------- */

bool stilb_input_recording_next(stilb_input_recording *recording, int64_t until_us, stilb_input_event *event)
{
	STILB_ASSERT(recording && event);
	STILB_ASSERT_OWNER(recording->owner);
	if (recording->next == recording->event_count || recording->events[recording->next].time_us > until_us)
		return false;
	const recording_event *from = &recording->events[recording->next++];
	STILB_ASSERT(from->pad < recording->pad_count);
	const recording_pad *pad = recording->pads[from->pad];
	*event = (stilb_input_event){.kind = from->kind, .pad = pad->number, .time_us = from->time_us};
	if (from->kind == STILB_INPUT_PAD_ADDED)
		event->info = &pad->info;
	if (from->kind == STILB_INPUT_PAD_REPORT) {
		event->bytes = recording->bytes + from->offset;
		event->size = from->size;
	}
	return true;
}

int64_t stilb_input_recording_end_us(const stilb_input_recording *recording)
{
	STILB_ASSERT(recording);
	STILB_ASSERT_OWNER(recording->owner);
	return recording->event_count ? recording->events[recording->event_count - 1].time_us : 0;
}
