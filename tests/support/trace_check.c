/* The judge of trace_check.h: a recursive-descent JSON parser that keeps the events, then one pass over them. */
#include "trace_check.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define DEPTH_MAX 64
#define KEYS_MAX 64

/* ---- memory: growing arrays, and strings that are kept once ------------------------------------------------------ */

typedef struct strings {
	char **slot; /* [capacity] hash table with open addressing; capacity is a power of two */
	size_t capacity, count;
} strings;

static void *grow(void *array, size_t count, size_t *capacity, size_t size)
{
	if (count < *capacity)
		return array;
	*capacity = *capacity > 0 ? 2 * *capacity : 64;
	array = realloc(array, *capacity * size);
	if (!array)
		abort();
	return array;
}

static size_t strings_slot(const strings *set, const char *text, size_t size)
{
	uint64_t hash = 0xcbf29ce484222325u; /* FNV-1a */
	for (size_t i = 0; i < size; i++)
		hash = (hash ^ (unsigned char)text[i]) * 0x100000001b3u;
	size_t at = hash & (set->capacity - 1);
	while (set->slot[at] && (strlen(set->slot[at]) != size || memcmp(set->slot[at], text, size) != 0))
		at = (at + 1) & (set->capacity - 1);
	return at;
}

static const char *strings_keep(strings *set, const char *text, size_t size)
{
	if (2 * set->count >= set->capacity) {
		strings old = *set;
		set->capacity = old.capacity > 0 ? 2 * old.capacity : 256;
		set->slot = calloc(set->capacity, sizeof *set->slot);
		if (!set->slot)
			abort();
		for (size_t i = 0; i < old.capacity; i++)
			if (old.slot[i])
				set->slot[strings_slot(set, old.slot[i], strlen(old.slot[i]))] = old.slot[i];
		free(old.slot);
	}
	size_t at = strings_slot(set, text, size);
	if (!set->slot[at]) {
		set->slot[at] = strndup(text, size);
		set->count++;
	}
	return set->slot[at];
}

/* ---- what is kept of the text ------------------------------------------------------------------------------------ */

typedef struct text_span {
	const char *begin, *end; /* begin == NULL: absent */
} text_span;

typedef struct event {
	const char *ph, *name, *scope, *cat, *bind; /* NULL: absent */
	text_span pid, tid, ts, dur, id;
	bool has_args;
	const char *arg_name;
	text_span arg_sort, arg_value;
	size_t line;
	int64_t pid_value, tid_value, id_value;
	uint64_t begin, end; /* tenths of nanoseconds; end: of events with ph "X" only */
} event;

typedef struct parser {
	const char *at, *end;
	size_t line;
	trace_check_report *report;
	strings strings;
	char *scratch; /* the string that is being read, its escape sequences replaced by what they stand for */
	size_t scratch_size, scratch_capacity;
	event *events;
	size_t event_count, event_capacity;
	event *current; /* the event being read */
	const char *unit, *clock;
	bool has_events, has_other;
	text_span hz, resolution, bias, cost, epoch, first, last, recorded, lost, held, too_deep, without_ring, written;
} parser;

static bool fail_at(parser *p, size_t line, const char *format, ...) __attribute__((format(printf, 3, 4)));

static bool fail_at(parser *p, size_t line, const char *format, ...)
{
	char *error = p->report->error;
	if (error[0] != 0)
		return false;
	int used = line > 0 ? snprintf(error, sizeof p->report->error, "line %zu: ", line) : 0;
	va_list arguments;
	va_start(arguments, format);
	vsnprintf(error + used, sizeof p->report->error - (size_t)used, format, arguments);
	va_end(arguments);
	return false;
}

#define fail(p, ...) fail_at(p, (p)->line, __VA_ARGS__)

/* ---- JSON -------------------------------------------------------------------------------------------------------- */

typedef bool member_fn(parser *p, const char *key, int depth);

static void skip_space(parser *p)
{
	for (; p->at < p->end && (*p->at == ' ' || *p->at == '\t' || *p->at == '\n' || *p->at == '\r'); p->at++)
		p->line += *p->at == '\n';
}

static bool take(parser *p, char c)
{
	skip_space(p);
	if (p->at == p->end || *p->at != c)
		return false;
	p->at++;
	return true;
}

static bool expect(parser *p, char c)
{
	return take(p, c) || fail(p, "'%c' expected", c);
}

static void scratch_byte(parser *p, unsigned char byte)
{
	p->scratch = grow(p->scratch, p->scratch_size, &p->scratch_capacity, 1);
	p->scratch[p->scratch_size++] = (char)byte;
}

static void scratch_code_point(parser *p, uint32_t c)
{
	if (c >= 0x10000) {
		scratch_byte(p, (unsigned char)(0xf0 | c >> 18));
		scratch_byte(p, (unsigned char)(0x80 | (c >> 12 & 0x3f)));
	} else if (c >= 0x800) {
		scratch_byte(p, (unsigned char)(0xe0 | c >> 12));
	}
	if (c >= 0x800)
		scratch_byte(p, (unsigned char)(0x80 | (c >> 6 & 0x3f)));
	else if (c >= 0x80)
		scratch_byte(p, (unsigned char)(0xc0 | c >> 6));
	scratch_byte(p, (unsigned char)(c >= 0x80 ? 0x80 | (c & 0x3f) : c));
}

static bool parse_hex4(parser *p, uint32_t *value)
{
	*value = 0;
	for (int i = 0; i < 4; i++) {
		char c = p->at < p->end ? *p->at++ : 0;
		int digit = c >= '0' && c <= '9' ? c - '0' : (c | 32) >= 'a' && (c | 32) <= 'f' ? (c | 32) - 'a' + 10 : -1;
		if (digit < 0)
			return fail(p, "four hex digits expected after \\u");
		*value = *value << 4 | (uint32_t)digit;
	}
	return true;
}

/* After \u: one code point, maybe from a surrogate pair. */
static bool parse_unicode_escape(parser *p)
{
	uint32_t c, low;
	if (!parse_hex4(p, &c))
		return false;
	if (c >= 0xdc00 && c <= 0xdfff)
		return fail(p, "second half of a surrogate pair without the first");
	if (c >= 0xd800 && c <= 0xdbff) {
		if (p->end - p->at < 2 || p->at[0] != '\\' || p->at[1] != 'u')
			return fail(p, "first half of a surrogate pair without the second");
		p->at += 2;
		if (!parse_hex4(p, &low))
			return false;
		if (low < 0xdc00 || low > 0xdfff)
			return fail(p, "first half of a surrogate pair without the second");
		c = 0x10000 + ((c - 0xd800) << 10) + (low - 0xdc00);
	}
	if (c == 0)
		return fail(p, "\\u0000 in a string");
	scratch_code_point(p, c);
	return true;
}

static bool parse_escape(parser *p)
{
	static const char from[] = "\"\\/bfnrt", to[] = "\"\\/\b\f\n\r\t";
	char c = p->at < p->end ? *p->at++ : 0;
	if (c == 'u')
		return parse_unicode_escape(p);
	const char *found = c != 0 ? strchr(from, c) : NULL;
	if (!found)
		return fail(p, "unknown escape in a string");
	scratch_byte(p, (unsigned char)to[found - from]);
	return true;
}

/* A multi-byte UTF-8 sequence whose first byte is at p->at: shortest form, no surrogates, up to U+10FFFF. */
static bool parse_utf8(parser *p)
{
	unsigned char first = (unsigned char)*p->at++;
	int more = first >= 0xf0 && first <= 0xf4 ? 3 : first >= 0xe0 ? 2 : 1;
	uint32_t c = first & (0x3fu >> more);
	if (first < 0xc2 || first > 0xf4)
		return fail(p, "a string is not UTF-8");
	for (int i = 0; i < more; i++) {
		if (p->at == p->end || ((unsigned char)*p->at & 0xc0) != 0x80)
			return fail(p, "a string is not UTF-8");
		c = c << 6 | ((unsigned char)*p->at++ & 0x3f);
	}
	if (c < (more == 3 ? 0x10000u : more == 2 ? 0x800u : 0x80u) || c > 0x10ffff || (c >= 0xd800 && c <= 0xdfff))
		return fail(p, "a string is not UTF-8");
	scratch_code_point(p, c);
	return true;
}

static bool parse_string(parser *p, const char **out)
{
	p->scratch_size = 0;
	if (!take(p, '"'))
		return fail(p, "a string expected");
	for (;;) {
		unsigned char c = p->at < p->end ? (unsigned char)*p->at : 0;
		if (c < 0x20)
			return fail(p, p->at < p->end ? "control byte in a string" : "a string does not end");
		if (c >= 0x80) {
			if (!parse_utf8(p))
				return false;
			continue;
		}
		p->at++;
		if (c == '"')
			break;
		if (c != '\\')
			scratch_byte(p, c);
		else if (!parse_escape(p))
			return false;
	}
	*out = strings_keep(&p->strings, p->scratch ? p->scratch : "", p->scratch_size);
	return true;
}

static bool take_digits(parser *p)
{
	const char *begin = p->at;
	while (p->at < p->end && *p->at >= '0' && *p->at <= '9')
		p->at++;
	return p->at > begin;
}

static bool parse_number(parser *p, text_span *out)
{
	skip_space(p);
	out->begin = p->at;
	if (p->at < p->end && *p->at == '-')
		p->at++;
	const char *digits = p->at;
	if (!take_digits(p) || (*digits == '0' && p->at - digits > 1))
		return fail(p, "a number expected");
	if (p->at < p->end && *p->at == '.' && (p->at++, !take_digits(p)))
		return fail(p, "digits expected after the point");
	if (p->at < p->end && (*p->at | 32) == 'e') {
		p->at++;
		if (p->at < p->end && (*p->at == '+' || *p->at == '-'))
			p->at++;
		if (!take_digits(p))
			return fail(p, "digits expected in the exponent");
	}
	out->end = p->at;
	return true;
}

static bool parse_value(parser *p, int depth);

static bool parse_object(parser *p, member_fn *member, int depth)
{
	const char *keys[KEYS_MAX];
	size_t count = 0;
	if (depth > DEPTH_MAX)
		return fail(p, "nested too deep");
	if (!expect(p, '{'))
		return false;
	if (take(p, '}'))
		return true;
	do {
		const char *key;
		if (count == KEYS_MAX)
			return fail(p, "more than %d keys in an object", KEYS_MAX);
		if (!parse_string(p, &key) || !expect(p, ':'))
			return false;
		for (size_t i = 0; i < count; i++)
			if (keys[i] == key) /* strings are kept once */
				return fail(p, "key \"%.40s\" twice in an object", key);
		keys[count++] = key;
		if (!(member ? member(p, key, depth + 1) : parse_value(p, depth + 1)))
			return false;
	} while (take(p, ','));
	return take(p, '}') || fail(p, "',' or '}' expected");
}

static bool parse_array(parser *p, bool (*element)(parser *p, int depth), int depth)
{
	if (depth > DEPTH_MAX)
		return fail(p, "nested too deep");
	if (!expect(p, '['))
		return false;
	if (take(p, ']'))
		return true;
	do
		if (!element(p, depth + 1))
			return false;
	while (take(p, ','));
	return take(p, ']') || fail(p, "',' or ']' expected");
}

static bool parse_word(parser *p)
{
	static const char *const words[] = {"true", "false", "null"};
	for (size_t i = 0; i < 3; i++) {
		size_t length = strlen(words[i]);
		if ((size_t)(p->end - p->at) >= length && memcmp(p->at, words[i], length) == 0) {
			p->at += length;
			return true;
		}
	}
	return fail(p, "a value expected");
}

static bool parse_value(parser *p, int depth)
{
	const char *string;
	text_span number;
	skip_space(p);
	char c = p->at < p->end ? *p->at : 0;
	if (c == '{')
		return parse_object(p, NULL, depth);
	if (c == '[')
		return parse_array(p, parse_value, depth);
	if (c == '"')
		return parse_string(p, &string);
	if (c == '-' || (c >= '0' && c <= '9'))
		return parse_number(p, &number);
	return parse_word(p);
}

/* ---- the trace as JSON ------------------------------------------------------------------------------------------- */

static bool member_args(parser *p, const char *key, int depth)
{
	if (strcmp(key, "name") == 0)
		return parse_string(p, &p->current->arg_name);
	if (strcmp(key, "sort_index") == 0)
		return parse_number(p, &p->current->arg_sort);
	if (strcmp(key, "value") == 0)
		return parse_number(p, &p->current->arg_value);
	return parse_value(p, depth);
}

static bool member_event(parser *p, const char *key, int depth)
{
	event *e = p->current;
	const struct {
		const char *key;
		const char **string;
		text_span *number;
	} known[] = {
		{"ph", &e->ph, NULL},   {"name", &e->name, NULL}, {"s", &e->scope, NULL}, {"cat", &e->cat, NULL},
		{"bp", &e->bind, NULL}, {"pid", NULL, &e->pid},   {"tid", NULL, &e->tid}, {"ts", NULL, &e->ts},
		{"id", NULL, &e->id},   {"dur", NULL, &e->dur},
	};
	for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
		if (strcmp(key, known[i].key) == 0)
			return known[i].string ? parse_string(p, known[i].string) : parse_number(p, known[i].number);
	if (strcmp(key, "args") == 0) {
		e->has_args = true;
		return parse_object(p, member_args, depth);
	}
	return parse_value(p, depth);
}

static bool element_event(parser *p, int depth)
{
	event e = {0};
	skip_space(p);
	e.line = p->line;
	p->current = &e;
	if (!parse_object(p, member_event, depth))
		return false;
	p->events = grow(p->events, p->event_count, &p->event_capacity, sizeof *p->events);
	p->events[p->event_count++] = e;
	return true;
}

static bool member_other(parser *p, const char *key, int depth)
{
	const struct {
		const char *key;
		text_span *number;
	} known[] = {
		{"hz", &p->hz},
		{"resolution_ns", &p->resolution},
		{"bias_ns", &p->bias},
		{"zone_cost_ns", &p->cost},
		{"epoch_ns", &p->epoch},
		{"begin_ns", &p->first},
		{"end_ns", &p->last},
		{"events_recorded", &p->recorded},
		{"events_lost", &p->lost},
		{"events_held", &p->held},
		{"too_deep", &p->too_deep},
		{"without_ring", &p->without_ring},
		{"zones_written", &p->written},
	};
	for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
		if (strcmp(key, known[i].key) == 0)
			return parse_number(p, known[i].number);
	return strcmp(key, "clock") == 0 ? parse_string(p, &p->clock) : parse_value(p, depth);
}

static bool member_top(parser *p, const char *key, int depth)
{
	if (strcmp(key, "displayTimeUnit") == 0)
		return parse_string(p, &p->unit);
	if (strcmp(key, "traceEvents") == 0) {
		p->has_events = true;
		return parse_array(p, element_event, depth);
	}
	if (strcmp(key, "otherData") == 0) {
		p->has_other = true;
		return parse_object(p, member_other, depth);
	}
	return parse_value(p, depth);
}

/* ---- the rules --------------------------------------------------------------------------------------------------- */

typedef struct open_zone {
	const char *name;
	uint64_t begin, end;
	bool unended; /* begun by an event with ph "B" whose "E" has not come */
} open_zone;

typedef struct track {
	int64_t tid;
	const char *name;
	bool has_sort;
	bool is_frames, is_off_cpu;
	uint64_t last; /* ts of the event before */
	size_t last_line;
	open_zone *open;
	size_t depth, capacity;
} track;

/* The arrow that viewers draw for a flow: its two ends, the events with ph "s" and "f"; NULL: that one has not come. */
typedef struct arrow {
	const event *from, *to;
} arrow;

typedef struct judge {
	parser *p;
	track *lanes;
	size_t lane_count, lane_capacity;
	int64_t pid;
	bool has_pid, has_process_name;
	uint64_t complete; /* zones whose begin and end are one event, with ph "X" */
	arrow *arrows;     /* [arrow_count] the arrow with the flow id i is arrows[i - 1] */
	size_t arrow_count, arrow_capacity;
} judge;

/* Reads the text as a whole number of up to 18 digits; false: it is none. */
static bool span_integer(text_span span, int64_t *value)
{
	bool negative = *span.begin == '-';
	*value = 0;
	if (span.end - span.begin - negative > 18)
		return false;
	for (const char *c = span.begin + negative; c < span.end; c++) {
		if (*c < '0' || *c > '9')
			return false;
		*value = 10 * *value + (*c - '0');
	}
	*value = negative ? -*value : *value;
	return true;
}

/* Reads microseconds, not negative, with three decimals or a fourth that is not 0, as tenths of nanoseconds; false: the
 * text is none. */
static bool span_tenths(text_span span, uint64_t *tenths)
{
	const char *point = memchr(span.begin, '.', (size_t)(span.end - span.begin));
	ptrdiff_t decimals = point ? span.end - point - 1 : 0;
	*tenths = 0;
	if (span.end - span.begin > 19 || decimals < 3 || decimals > 4 || (decimals == 4 && span.end[-1] == '0'))
		return false;
	for (const char *c = span.begin; c < span.end; c++)
		if (c != point) {
			if (*c < '0' || *c > '9')
				return false;
			*tenths = 10 * *tenths + (uint64_t)(*c - '0');
		}
	*tenths *= decimals == 3 ? 10 : 1;
	return true;
}

static track *judge_lane(judge *j, int64_t tid)
{
	for (size_t i = 0; i < j->lane_count; i++)
		if (j->lanes[i].tid == tid)
			return &j->lanes[i];
	j->lanes = grow(j->lanes, j->lane_count, &j->lane_capacity, sizeof *j->lanes);
	j->lanes[j->lane_count] = (track){.tid = tid};
	return &j->lanes[j->lane_count++];
}

static bool judge_keys(judge *j, event *e)
{
	parser *p = j->p;
	if (!e->ph)
		return fail_at(p, e->line, "event without ph");
	if (strlen(e->ph) != 1 || !strchr("MXBEiCsf", e->ph[0]))
		return fail_at(p, e->line, "unknown ph \"%.20s\"", e->ph);
	char ph = e->ph[0];
	if (!e->name && ph != 'E')
		return fail_at(p, e->line, "event without name");
	if (!e->pid.begin || !span_integer(e->pid, &e->pid_value))
		return fail_at(p, e->line, "event without an integer pid");
	if (!e->tid.begin || !span_integer(e->tid, &e->tid_value))
		return fail_at(p, e->line, "event without an integer tid");
	if (ph == 'M')
		return e->has_args || fail_at(p, e->line, "M event without args");
	if (!e->ts.begin || !span_tenths(e->ts, &e->begin))
		return fail_at(p, e->line, "%c event without a ts of three decimals", ph);
	if (ph == 'X' && (!e->dur.begin || !span_tenths(e->dur, &e->end)))
		return fail_at(p, e->line, "X event without a dur of three decimals");
	if (ph == 'i' && (!e->scope || (strcmp(e->scope, "g") != 0 && strcmp(e->scope, "t") != 0)))
		return fail_at(p, e->line, "i event without s \"g\" or \"t\"");
	if (ph == 'C' && !e->arg_value.begin)
		return fail_at(p, e->line, "C event without a number args.value");
	if ((ph == 's' || ph == 'f') && (!e->cat || !e->id.begin || !span_integer(e->id, &e->id_value)))
		return fail_at(p, e->line, "%c event without cat and an integer id", ph);
	if (ph == 'f' && (!e->bind || strcmp(e->bind, "e") != 0))
		return fail_at(p, e->line, "f event without bp \"e\"");
	e->end += e->begin;
	return true;
}

#define OFF_CPU ": off the CPU"

static bool ends_in(const char *text, const char *ending)
{
	size_t length = strlen(text), size = strlen(ending);
	return length >= size && strcmp(text + length - size, ending) == 0;
}

/* A track "NAME: off the CPU" must follow the track of the thread NAME, to which it belongs. */
static bool judge_off_cpu_thread(judge *j, const track *lane)
{
	const track *owner = lane > j->lanes ? lane - 1 : NULL;
	size_t length = strlen(lane->name) - strlen(OFF_CPU);
	return (owner && strlen(owner->name) == length && strncmp(owner->name, lane->name, length) == 0) ||
	       fail_at(j->p, 0, "\"%.60s\" does not follow its thread", lane->name);
}

static bool judge_metadata(judge *j, const event *e)
{
	parser *p = j->p;
	track *lane = judge_lane(j, e->tid_value);
	if (strcmp(e->name, "process_name") == 0) {
		if (!e->arg_name || j->has_process_name)
			return fail_at(p, e->line, "process_name without args.name, or a second one");
		j->has_process_name = true;
	} else if (strcmp(e->name, "thread_name") == 0) {
		if (!e->arg_name || lane->name)
			return fail_at(p, e->line, "thread_name without args.name, or a second one of tid %" PRId64, e->tid_value);
		lane->name = e->arg_name;
		lane->is_frames = strcmp(e->arg_name, "frames") == 0;
		lane->is_off_cpu = ends_in(e->arg_name, OFF_CPU);
	} else if (strcmp(e->name, "thread_sort_index") == 0) {
		int64_t index;
		if (!e->arg_sort.begin || !span_integer(e->arg_sort, &index) || lane->has_sort)
			return fail_at(p, e->line, "thread_sort_index without an integer, or a second one of tid %" PRId64,
			               e->tid_value);
		lane->has_sort = true;
	}
	return true;
}

/* Judges what does not depend on the order of events: their keys, the process, names. */
static bool judge_events(judge *j)
{
	parser *p = j->p;
	for (size_t i = 0; i < p->event_count; i++) {
		event *e = &p->events[i];
		if (!judge_keys(j, e))
			return false;
		if (j->has_pid && e->pid_value != j->pid)
			return fail_at(p, e->line, "a second process, pid %" PRId64, e->pid_value);
		j->pid = e->pid_value;
		j->has_pid = true;
		if (e->ph[0] == 'M' && !judge_metadata(j, e))
			return false;
	}
	return true;
}

static bool judge_names(judge *j)
{
	parser *p = j->p;
	uint32_t frames = 0;
	for (size_t i = 0; i < p->event_count; i++)
		judge_lane(j, p->events[i].tid_value);
	for (size_t i = 0; i < j->lane_count; i++) {
		if (!j->lanes[i].name)
			return fail_at(p, 0, "tid %" PRId64 " without a thread_name", j->lanes[i].tid);
		if (!j->lanes[i].has_sort)
			return fail_at(p, 0, "tid %" PRId64 " without a thread_sort_index", j->lanes[i].tid);
		frames += j->lanes[i].is_frames;
		p->report->threads += !j->lanes[i].is_frames && !j->lanes[i].is_off_cpu;
		if (j->lanes[i].is_off_cpu && !judge_off_cpu_thread(j, &j->lanes[i]))
			return false;
	}
	if (!j->has_process_name)
		return fail_at(p, 0, "no process_name");
	if (frames != 1)
		return fail_at(p, 0, "not one thread \"frames\" but %u", frames);
	return true;
}

/* Takes the zones that ended by the time of the event e off the lane's stack of open zones. */
static bool judge_pop(judge *j, track *lane, const event *e)
{
	for (; lane->depth > 0; lane->depth--) {
		const open_zone *top = &lane->open[lane->depth - 1];
		if (top->unended || top->end > e->begin)
			return true;
		if (top->end == e->begin && top->end > top->begin)
			return fail_at(j->p, e->line, "the end of \"%.60s\" touches \"%.60s\"", top->name, e->name ? e->name : "E");
	}
	return true;
}

static bool judge_inside(judge *j, const track *lane, const event *e)
{
	const open_zone *top = &lane->open[lane->depth - 1];
	if (lane->is_frames || lane->is_off_cpu)
		return fail_at(j->p, e->line, "%s overlap", lane->is_frames ? "frames" : "times off the CPU");
	if (top->unended)
		return true;
	if (e->ph[0] == 'B' || e->end > top->end)
		return fail_at(j->p, e->line,
		               top->begin == e->begin ? "parent \"%.60s\" after its child \"%.60s\" of equal ts"
		                                      : "\"%.60s\" sticks out of \"%.60s\"",
		               e->name, top->name);
	return e->end < top->end || e->end == e->begin ||
	       fail_at(j->p, e->line, "\"%.60s\" touches the end of its parent \"%.60s\"", e->name, top->name);
}

static bool judge_push(judge *j, track *lane, const event *e)
{
	parser *p = j->p;
	bool begin = e->ph[0] == 'B';
	if (!judge_pop(j, lane, e) || (lane->depth > 0 && !judge_inside(j, lane, e)))
		return false;
	if (lane->is_frames && (begin || strcmp(e->name, "frame") != 0))
		return fail_at(p, e->line, "\"%.60s\" on the thread \"frames\"", e->name);
	if (lane->is_off_cpu && (begin || (strcmp(e->name, "sleeping") != 0 && strcmp(e->name, "preempted") != 0)))
		return fail_at(p, e->line, "\"%.60s\" on an off-CPU thread", e->name);
	lane->open = grow(lane->open, lane->depth, &lane->capacity, sizeof *lane->open);
	lane->open[lane->depth++] = (open_zone){e->name, e->begin, e->end, begin};
	bool zone = !lane->is_frames && !lane->is_off_cpu;
	j->complete += zone && !begin;
	p->report->frames += lane->is_frames;
	p->report->switches += lane->is_off_cpu;
	p->report->zones += zone;
	p->report->open_zones += begin;
	return true;
}

static bool judge_end(judge *j, track *lane, const event *e)
{
	parser *p = j->p;
	if (!judge_pop(j, lane, e))
		return false;
	if (lane->depth == 0)
		return fail_at(p, e->line, "E without a B");
	const open_zone *top = &lane->open[lane->depth - 1];
	if (!top->unended)
		return fail_at(p, e->line, "E while \"%.60s\" is open", top->name);
	if (e->name && e->name != top->name)
		return fail_at(p, e->line, "E of \"%.60s\" while \"%.60s\" is open", e->name, top->name);
	lane->depth--;
	p->report->open_zones--;
	return true;
}

static bool judge_point(judge *j, const track *lane, const event *e)
{
	parser *p = j->p;
	bool global = e->ph[0] == 'i' && strcmp(e->scope, "g") == 0;
	if (global != lane->is_frames || lane->is_off_cpu)
		return fail_at(p, e->line, global ? "mark on a thread other than \"frames\"" : "%c on the thread \"%.60s\"",
		               e->ph[0], lane->name);
	p->report->marks += global;
	p->report->instants += e->ph[0] == 'i' && !global;
	p->report->counters += e->ph[0] == 'C';
	return true;
}

/* Viewers bind an arrow's ends to the zones around them. */
static bool judge_arrow_end(judge *j, const track *lane, const event *e)
{
	parser *p = j->p;
	bool from = e->ph[0] == 's';
	size_t around = lane->depth;
	while (around > 0 && !lane->open[around - 1].unended && lane->open[around - 1].end / 10 * 10 <= e->begin)
		around--;
	p->report->flow_ends_outside += around == 0;
	if (e->id_value < 1 || (size_t)e->id_value > p->event_count)
		return fail_at(p, e->line, "a flow's id is not a number from 1 on");
	while (j->arrow_count < (size_t)e->id_value) {
		j->arrows = grow(j->arrows, j->arrow_count, &j->arrow_capacity, sizeof *j->arrows);
		j->arrows[j->arrow_count++] = (arrow){0};
	}
	const event **end = from ? &j->arrows[e->id_value - 1].from : &j->arrows[e->id_value - 1].to;
	if (*end)
		return fail_at(p, e->line, "a second %c of flow %" PRId64, e->ph[0], e->id_value);
	*end = e;
	return true;
}

static bool judge_arrows(judge *j)
{
	parser *p = j->p;
	for (size_t i = 0; i < j->arrow_count; i++) {
		const event *from = j->arrows[i].from, *to = j->arrows[i].to;
		if (!from && !to)
			continue;
		if (!from)
			return fail_at(p, to->line, "f without an s");
		if (!to)
			return fail_at(p, from->line, "s without an f");
		if (from->name != to->name || from->cat != to->cat) /* strings are kept once */
			return fail_at(p, to->line, "the f of flow %" PRId64 " has another name or cat than its s", to->id_value);
		if (from->begin > to->begin)
			return fail_at(p, to->line, "flow %" PRId64 " goes back in time", to->id_value);
		p->report->flows++;
	}
	return true;
}

static bool judge_order(judge *j)
{
	parser *p = j->p;
	for (size_t i = 0; i < p->event_count; i++) {
		const event *e = &p->events[i];
		char ph = e->ph[0];
		if (ph == 'M')
			continue;
		track *lane = judge_lane(j, e->tid_value);
		if (e->begin < lane->last)
			return fail_at(p, e->line, "ts goes back on tid %" PRId64 " (after line %zu)", e->tid_value,
			               lane->last_line);
		lane->last = e->begin;
		lane->last_line = e->line;
		if ((ph == 'i' || ph == 'C') && !judge_point(j, lane, e))
			return false;
		if ((ph == 's' || ph == 'f') && !judge_arrow_end(j, lane, e))
			return false;
		if ((ph == 'X' || ph == 'B') && !judge_push(j, lane, e))
			return false;
		if (ph == 'E' && !judge_end(j, lane, e))
			return false;
	}
	return true;
}

static bool judge_accounts(judge *j)
{
	parser *p = j->p;
	int64_t recorded, lost, held, written, first, last;
	const text_span needed[] = {p->hz, p->resolution, p->bias, p->cost, p->epoch, p->too_deep, p->without_ring};
	static const char *const names[] = {"hz",       "resolution_ns", "bias_ns",     "zone_cost_ns",
	                                    "epoch_ns", "too_deep",      "without_ring"};
	if (!p->clock)
		return fail_at(p, 0, "otherData without clock");
	for (size_t i = 0; i < sizeof needed / sizeof needed[0]; i++)
		if (!needed[i].begin || *needed[i].begin == '-')
			return fail_at(p, 0, "otherData without %s, or it is negative", names[i]);
	if (p->hz.end - p->hz.begin == 1 && *p->hz.begin == '0')
		return fail_at(p, 0, "hz is 0");
	if (!p->first.begin || !p->last.begin || !span_integer(p->first, &first) || !span_integer(p->last, &last) ||
	    first > last)
		return fail_at(p, 0, "otherData without a window from begin_ns to end_ns");
	if (!p->recorded.begin || !p->lost.begin || !p->held.begin || !p->written.begin ||
	    !span_integer(p->recorded, &recorded) || !span_integer(p->lost, &lost) || !span_integer(p->held, &held) ||
	    !span_integer(p->written, &written))
		return fail_at(p, 0, "otherData without the accounts of events");
	if (recorded < 0 || lost < 0 || written < 0 || recorded != lost + held || (int64_t)j->complete > held)
		return fail_at(p, 0, "the accounts of events do not add up");
	if ((uint64_t)written != p->report->zones)
		return fail_at(p, 0, "%" PRIu64 " zones, but zones_written is %" PRId64, p->report->zones, written);
	p->report->events_recorded = (uint64_t)recorded;
	p->report->events_lost = (uint64_t)lost;
	return true;
}

/* ---- counts ------------------------------------------------------------------------------------------------------ */

static int compare_counts(const void *a, const void *b)
{
	const trace_check_count *x = a, *y = b;
	int thread = strcmp(x->thread, y->thread);
	return thread != 0 ? thread : strcmp(x->name, y->name);
}

static void judge_count(judge *j)
{
	trace_check_report *report = j->p->report;
	size_t capacity = 0, count = 0, kept = 0;
	trace_check_count *counts = NULL;
	for (size_t i = 0; i < j->p->event_count; i++) {
		const event *e = &j->p->events[i];
		const track *lane = judge_lane(j, e->tid_value);
		if ((e->ph[0] == 'X' || e->ph[0] == 'B') && !lane->is_frames && !lane->is_off_cpu) {
			counts = grow(counts, count, &capacity, sizeof *counts);
			counts[count++] = (trace_check_count){lane->name, e->name, 1};
		}
	}
	if (count > 0)
		qsort(counts, count, sizeof *counts, compare_counts);
	for (size_t i = 0; i < count; i++) {
		if (kept > 0 && compare_counts(&counts[kept - 1], &counts[i]) == 0)
			counts[kept - 1].zones++;
		else
			counts[kept++] = counts[i];
	}
	report->counts = counts;
	report->count_count = kept;
}

uint64_t trace_check_zones(const trace_check_report *report, const char *thread, const char *name)
{
	uint64_t zones = 0;
	for (size_t i = 0; i < report->count_count; i++)
		if ((!thread || strcmp(report->counts[i].thread, thread) == 0) &&
		    (!name || strcmp(report->counts[i].name, name) == 0))
			zones += report->counts[i].zones;
	return zones;
}

/* ---- the calls --------------------------------------------------------------------------------------------------- */

static bool check_document(parser *p)
{
	if (!parse_object(p, member_top, 0))
		return false;
	skip_space(p);
	if (p->at != p->end)
		return fail(p, "something after the end of the object");
	if (!p->unit || strcmp(p->unit, "ns") != 0)
		return fail_at(p, 0, "displayTimeUnit is not \"ns\"");
	if (!p->has_events)
		return fail_at(p, 0, "no traceEvents");
	return p->has_other || fail_at(p, 0, "no otherData");
}

int trace_check_text(const char *text, size_t size, trace_check_report *report)
{
	*report = (trace_check_report){0};
	parser p = {.at = text, .end = text + size, .line = 1, .report = report};
	judge j = {.p = &p};
	if (check_document(&p) && judge_events(&j) && judge_names(&j) && judge_order(&j) && judge_arrows(&j) &&
	    judge_accounts(&j))
		judge_count(&j);
	for (size_t i = 0; i < j.lane_count; i++)
		free(j.lanes[i].open);
	free(j.lanes);
	free(j.arrows);
	free(p.events);
	free(p.scratch);
	strings *kept = malloc(sizeof *kept);
	if (!kept)
		abort();
	*kept = p.strings;
	report->memory = kept;
	return report->error[0] == 0 ? 0 : -1;
}

int trace_check_file(const char *path, trace_check_report *report)
{
	char *text = NULL;
	size_t size = 0, capacity = 0, got = 0;
	*report = (trace_check_report){0};
	FILE *file = fopen(path, "rb");
	if (!file) {
		snprintf(report->error, sizeof report->error, "cannot open %.200s", path);
		return -1;
	}
	do {
		size += got;
		if (size + 65536 > capacity) {
			capacity = 2 * capacity + 65536;
			text = realloc(text, capacity);
			if (!text)
				abort();
		}
		got = fread(text + size, 1, capacity - size, file);
	} while (got > 0);
	fclose(file);
	int result = trace_check_text(text, size, report);
	free(text);
	return result;
}

void trace_check_finish(trace_check_report *report)
{
	strings *kept = report->memory;
	for (size_t i = 0; kept && i < kept->capacity; i++)
		free(kept->slot[i]);
	if (kept)
		free(kept->slot);
	free(kept);
	free(report->counts);
	*report = (trace_check_report){0};
}
