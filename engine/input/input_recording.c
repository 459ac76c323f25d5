/* input_recording's reader: nothing is believed before it is checked. */
#include "input/input_recording_internal.h"
#include "input/input_text_internal.h"

#include <errno.h>
#include <inttypes.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#define RECORDING_LINE_MAX 16384u /* the longest line, and room for more than any that is right */
#define RECORDING_BACK_US 1000000 /* more than a pad's time goes back by because lines were written out of order */

typedef struct recording_pad {
	stilb_input_pad_info info;
	uint32_t number; /* from 1 */
	bool identified; /* there was an I line */
	bool removed;
	bool timed; /* a line of it had a time: */
	int64_t last_us;
} recording_pad;

typedef struct recording_event {
	int64_t time_us;
	size_t offset; /* of a report's bytes */
	uint16_t pad;  /* index */
	uint16_t size;
	stilb_input_event_kind kind;
} recording_event;

struct stilb_input_recording {
	uint32_t pad_count;
	recording_pad *pads[INPUT_RECORDING_PADS_MAX];
	recording_event *events;
	size_t event_count, event_capacity, next;
	uint8_t *bytes; /* of all reports */
	size_t byte_count, byte_capacity;
	uint64_t reports;
};

/* ---- reading lines ------------------------------------------------------------------------------------------------- */

typedef struct recording_reader {
	stilb_input_recording *recording;
	FILE *stream;
	const char *name;
	uint64_t line;   /* from 1 */
	uint32_t number; /* of the last D line, from 1 */
	bool timed;      /* a time was read: */
	int64_t first_us, last_us;
	char text[RECORDING_LINE_MAX];
} recording_reader;

static stilb_result reader_refuse(const recording_reader *reader, const char *format, ...)
	__attribute__((format(printf, 2, 3)));

static stilb_result reader_refuse(const recording_reader *reader, const char *format, ...)
{
	char reason[256];
	va_list arguments;
	va_start(arguments, format);
	vsnprintf(reason, sizeof reason, format, arguments);
	va_end(arguments);
	return stilb_fail(STILB_ERROR_FILE, "cannot read '%s': line %" PRIu64 ": %s", reader->name, reader->line, reason);
}

static stilb_result reader_no_memory(const recording_reader *reader)
{
	return stilb_fail(STILB_ERROR_MEMORY, "cannot read '%s': out of memory", reader->name);
}

/* The next line without its end; false: there is none, or *result says why not. */
static bool reader_next_line(recording_reader *reader, stilb_result *result)
{
	errno = 0;
	if (!fgets(reader->text, sizeof reader->text, reader->stream)) {
		if (ferror(reader->stream))
			*result = stilb_fail(STILB_ERROR_FILE, "cannot read '%s': %s", reader->name, strerror(errno));
		return false;
	}
	reader->line++;
	size_t length = strlen(reader->text);
	bool whole = length > 0 && reader->text[length - 1] == '\n';
	if (!whole && !feof(reader->stream)) {
		*result = reader_refuse(reader, "is longer than %u bytes or has a zero byte: it is no recording",
		                        RECORDING_LINE_MAX - 2);
		return false;
	}
	length -= whole;
	length -= length > 0 && reader->text[length - 1] == '\r';
	reader->text[length] = '\0';
	return true;
}

static const char *skip_blanks(const char *at)
{
	return at + strspn(at, " \t");
}

/* Digits of the base, a number of at most `most`; NULL: there is none. */
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

/* "000001.250000": the part behind the point counts microseconds, as hid-recorder writes it. */
static const char *take_time(const char *at, int64_t *time_us)
{
	uint64_t seconds, us;
	at = take_number(at, 10, UINT32_MAX, &seconds);
	if (!at || at[0] != '.' || strspn(at + 1, "0123456789") != 6)
		return NULL;
	at = take_number(at + 1, 10, 999999, &us);
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

/* Two digits each with blanks between, at most `most`; the count in any case, -1: there is something else. */
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

/* "64 01 80 ..." into bytes. */
static stilb_result reader_take_bytes(const recording_reader *reader, const char *at, const char *what, uint8_t *bytes,
                                      uint32_t most, uint32_t *size)
{
	uint64_t said;
	at = take_number(at, 10, UINT32_MAX, &said);
	if (!at || said == 0 || said > most)
		return reader_refuse(reader, "the %s's size is none of 1..%" PRIu32, what, most);
	int there = take_bytes(at, bytes, most);
	if (there < 0)
		return reader_refuse(reader, "the %s has something else than bytes of two hexadecimal digits", what);
	if ((uint64_t)there != said)
		return reader_refuse(reader, "the %s has %d bytes, not the %" PRIu64 " it says", what, there, said);
	*size = (uint32_t)said;
	return STILB_OK;
}

/* ---- events -------------------------------------------------------------------------------------------------------- */

/* Makes room for one more of `size` bytes each; false: no memory. */
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

static stilb_result reader_push(recording_reader *reader, stilb_input_event_kind kind, uint32_t pad,
                                const uint8_t *bytes, uint32_t size)
{
	stilb_input_recording *r = reader->recording;
	if (!grow((void **)&r->events, &r->event_capacity, r->event_count + 1, sizeof *r->events) ||
	    !grow((void **)&r->bytes, &r->byte_capacity, r->byte_count + size, 1))
		return reader_no_memory(reader);
	if (size > 0)
		memcpy(r->bytes + r->byte_count, bytes, size);
	r->events[r->event_count++] = (recording_event){.time_us = reader->last_us,
	                                                .offset = r->byte_count,
	                                                .pad = (uint16_t)pad,
	                                                .size = (uint16_t)size,
	                                                .kind = kind};
	r->byte_count += size;
	return STILB_OK;
}

/* The first time of the file is 0; none is before the one above it. */
static void reader_advance(recording_reader *reader, int64_t time_us)
{
	if (!reader->timed)
		reader->first_us = time_us;
	reader->timed = true;
	if (time_us - reader->first_us > reader->last_us)
		reader->last_us = time_us - reader->first_us;
}

/* The time of a line about one pad. */
static stilb_result reader_take_pad_time(recording_reader *reader, recording_pad *pad, int64_t time_us)
{
	if (pad->timed && pad->last_us - time_us > RECORDING_BACK_US)
		return reader_refuse(reader, "the time goes back by %.6f s; are these several recordings?",
		                     (double)(pad->last_us - time_us) * 1e-6);
	if (!pad->timed || time_us > pad->last_us)
		pad->last_us = time_us;
	pad->timed = true;
	reader_advance(reader, time_us);
	return STILB_OK;
}

/* The index of the pad that lines are about; pad_count: it was not described yet. */
static uint32_t reader_find_pad(const recording_reader *reader)
{
	const stilb_input_recording *r = reader->recording;
	uint32_t i = 0;
	while (i < r->pad_count && r->pads[i]->number != reader->number)
		i++;
	return i;
}

/* The pad that a line of its description is about. */
static stilb_result reader_describe_pad(recording_reader *reader, recording_pad **pad)
{
	stilb_input_recording *r = reader->recording;
	uint32_t i = reader_find_pad(reader);
	if (i == r->pad_count) {
		if (i == INPUT_RECORDING_PADS_MAX)
			return reader_refuse(reader, "there are more than %u pads", INPUT_RECORDING_PADS_MAX);
		r->pads[i] = calloc(1, sizeof *r->pads[i]);
		if (!r->pads[i])
			return reader_no_memory(reader);
		r->pads[i]->number = reader->number;
		r->pad_count++;
		stilb_result result = reader_push(reader, STILB_INPUT_PAD_ADDED, i, NULL, 0);
		if (result != STILB_OK)
			return result;
	}
	*pad = r->pads[i];
	return (*pad)->removed ? reader_refuse(reader, "pad %" PRIu32 " was removed before", reader->number - 1) : STILB_OK;
}

static bool pad_is_described(const recording_pad *pad)
{
	return pad->info.descriptor_size > 0 && pad->identified;
}

/* The index of the pad that a report is from or that goes. */
static stilb_result reader_known_pad(const recording_reader *reader, uint32_t *pad)
{
	const stilb_input_recording *r = reader->recording;
	*pad = reader_find_pad(reader);
	if (*pad == r->pad_count || !pad_is_described(r->pads[*pad]))
		return reader_refuse(reader, "pad %" PRIu32 " has no R and I lines before this", reader->number - 1);
	if (r->pads[*pad]->removed)
		return reader_refuse(reader, "pad %" PRIu32 " was removed before", reader->number - 1);
	return STILB_OK;
}

/* ---- kinds of lines ------------------------------------------------------------------------------------------------ */

static stilb_result reader_device(recording_reader *reader, const char *at)
{
	uint64_t number;
	at = take_number(at, 10, UINT32_MAX - 1, &number);
	if (!at || *skip_blanks(at))
		return reader_refuse(reader, "D: wants the pad's number, from 0");
	reader->number = (uint32_t)number + 1;
	return STILB_OK;
}

static stilb_result reader_descriptor(recording_reader *reader, const char *at)
{
	recording_pad *pad;
	uint32_t size;
	stilb_result result = reader_describe_pad(reader, &pad);
	if (result == STILB_OK && pad->info.descriptor_size > 0)
		return reader_refuse(reader, "pad %" PRIu32 " has an R line already", reader->number - 1);
	if (result == STILB_OK)
		result = reader_take_bytes(reader, at, "descriptor", pad->info.descriptor, STILB_INPUT_DESCRIPTOR_MAX, &size);
	if (result == STILB_OK)
		pad->info.descriptor_size = (uint16_t)size;
	return result;
}

/* N: and P:, the pad's name and path. */
static stilb_result reader_name_or_path(recording_reader *reader, const char *at)
{
	recording_pad *pad;
	bool is_name = reader->text[0] == 'N';
	stilb_result result = reader_describe_pad(reader, &pad);
	if (result == STILB_OK)
		input_text_copy(is_name ? pad->info.name : pad->info.path,
		                is_name ? sizeof pad->info.name : sizeof pad->info.path, at, strlen(at));
	return result;
}

static stilb_result reader_identity(recording_reader *reader, const char *at)
{
	recording_pad *pad;
	uint64_t bus = 0, vendor = 0, product = 0;
	stilb_result result = reader_describe_pad(reader, &pad);
	if (result != STILB_OK)
		return result;
	at = take_number(at, 16, UINT16_MAX, &bus);
	at = at ? take_number(at, 16, UINT16_MAX, &vendor) : NULL;
	at = at ? take_number(at, 16, UINT16_MAX, &product) : NULL;
	if (!at || *skip_blanks(at))
		return reader_refuse(reader, "I: wants bus, vendor and product, like '3 054c 05c4'");
	pad->info.bus = (uint16_t)bus;
	pad->info.vendor = (uint16_t)vendor;
	pad->info.product = (uint16_t)product;
	pad->identified = true;
	return STILB_OK;
}

static stilb_result reader_report(recording_reader *reader, const char *at)
{
	static const char wanted[] = "E: wants time, size and bytes, like '000001.250000 2 01 80'";
	uint8_t bytes[STILB_INPUT_REPORT_MAX];
	uint32_t pad, size = 0;
	int64_t time_us;
	at = take_time(at, &time_us);
	if (!at)
		return reader_refuse(reader, "%s", wanted);
	stilb_result result = reader_known_pad(reader, &pad);
	if (result == STILB_OK)
		result = reader_take_bytes(reader, at, "report", bytes, STILB_INPUT_REPORT_MAX, &size);
	if (result != STILB_OK)
		return result;
	if (reader->recording->reports++ == INPUT_RECORDING_REPORTS_MAX)
		return reader_refuse(reader, "there are more than %u reports", INPUT_RECORDING_REPORTS_MAX);
	result = reader_take_pad_time(reader, reader->recording->pads[pad], time_us);
	return result == STILB_OK ? reader_push(reader, STILB_INPUT_PAD_REPORT, pad, bytes, size) : result;
}

/* "# added TIME" and "# removed TIME" are meant for this reader; any other remark is not. */
static stilb_result reader_remark(recording_reader *reader, const char *at)
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
		reader_advance(reader, time_us);
	if (!removed)
		return STILB_OK;
	stilb_result result = reader_known_pad(reader, &pad);
	if (result == STILB_OK && timed)
		result = reader_take_pad_time(reader, reader->recording->pads[pad], time_us);
	if (result != STILB_OK)
		return result;
	reader->recording->pads[pad]->removed = true;
	return reader_push(reader, STILB_INPUT_PAD_REMOVED, pad, NULL, 0);
}

static stilb_result reader_take_line(recording_reader *reader)
{
	static const struct {
		const char *begin;
		stilb_result (*take)(recording_reader *reader, const char *at);
	} kinds[] = {
		{"E:", reader_report},       {"D:", reader_device},   {"R:", reader_descriptor}, {"N:", reader_name_or_path},
		{"P:", reader_name_or_path}, {"I:", reader_identity}, {"#", reader_remark},
	};
	const char *text = reader->text;
	for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
		size_t length = strlen(kinds[i].begin);
		if (strncmp(text, kinds[i].begin, length) == 0)
			return kinds[i].take(reader, text + length + (text[length] == ' '));
	}
	if (*skip_blanks(text) == '\0')
		return STILB_OK;
	return reader_refuse(reader, "begins with none of D: R: N: P: I: E: and #; is it a recording of hid-recorder?");
}

/* ---- life ---------------------------------------------------------------------------------------------------------- */

/* Pads that are described, and a report at least: a flight by a recording without one would just stand still. */
static stilb_result reader_check_end(const recording_reader *reader)
{
	const stilb_input_recording *r = reader->recording;
	for (uint32_t i = 0; i < r->pad_count; i++)
		if (!pad_is_described(r->pads[i]))
			return stilb_fail(STILB_ERROR_FILE, "cannot read '%s': pad %" PRIu32 " has no %s line", reader->name,
			                  r->pads[i]->number - 1, r->pads[i]->identified ? "R" : "I");
	if (r->reports == 0)
		return stilb_fail(STILB_ERROR_FILE, "cannot read '%s': it holds no report", reader->name);
	return STILB_OK;
}

stilb_result input_recording_read(FILE *stream, const char *name, stilb_input_recording **recording)
{
	recording_reader *reader = calloc(1, sizeof *reader);
	stilb_input_recording *made = calloc(1, sizeof *made);
	stilb_result result = STILB_OK;
	*recording = NULL;
	if (!reader || !made) {
		result = stilb_fail(STILB_ERROR_MEMORY, "cannot read '%s': out of memory", name);
	} else {
		reader->recording = made;
		reader->stream = stream;
		reader->name = name;
		reader->number = 1;
		while (result == STILB_OK && reader_next_line(reader, &result))
			result = reader_take_line(reader);
		if (result == STILB_OK)
			result = reader_check_end(reader);
	}
	free(reader);
	if (result == STILB_OK)
		*recording = made;
	else
		stilb_input_recording_free(made);
	return result;
}

stilb_result stilb_input_recording_load(const char *path, stilb_input_recording **recording)
{
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
	for (uint32_t i = 0; i < recording->pad_count; i++)
		free(recording->pads[i]);
	free(recording->events);
	free(recording->bytes);
	free(recording);
}

/* ---- playing ------------------------------------------------------------------------------------------------------- */

bool stilb_input_recording_next(stilb_input_recording *recording, int64_t until_us, stilb_input_event *event)
{
	if (recording->next == recording->event_count || recording->events[recording->next].time_us > until_us)
		return false;
	const recording_event *from = &recording->events[recording->next++];
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
	return recording->event_count ? recording->events[recording->event_count - 1].time_us : 0;
}
