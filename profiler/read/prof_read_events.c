/*
 * Reads the events of a trace one after the other into arrays. Members that a snapshot does not need are skipped, but
 * must be JSON. Names and threads are found by hashing, so the cost is linear in the size of the text.
 */
#include "profiler/prof_array.h"
#include "profiler/read/prof_read_internal.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#define PROF_BLOCK_SIZE 16384

/* The members of one JSON event, before it is known what they mean together. */
typedef struct prof_raw_event {
	char phase; /* 0: missing, or longer than one character */
	bool has_ts, has_dur, has_tid;
	prof_time ts, dur;
	uint64_t pid, tid, id;
	prof_span name, args;
} prof_raw_event;

static bool prof_read_no_memory(prof_read *read)
{
	read->no_memory = true;
	return false;
}

/* ---- strings ----------------------------------------------------------------------------------------------------- */

typedef struct prof_strings_block {
	struct prof_strings_block *next;
	char bytes[];
} prof_strings_block;

static char *prof_strings_room(prof_strings *strings, size_t size)
{
	assert(size > 0);
	if (strings->room < size) {
		size_t bytes = size > PROF_BLOCK_SIZE ? size : PROF_BLOCK_SIZE;
		prof_strings_block *block = malloc(sizeof *block + bytes);
		if (!block)
			return NULL;
		block->next = strings->blocks;
		strings->blocks = block;
		strings->at = block->bytes;
		strings->room = bytes;
	}
	char *at = strings->at;
	strings->at += size;
	strings->room -= size;
	return at;
}

char *prof_strings_add(prof_strings *strings, const char *text, size_t size)
{
	assert(text || size == 0);
	char *copy = prof_strings_room(strings, size + 1);
	if (!copy)
		return NULL;
	if (size > 0)
		memcpy(copy, text, size);
	copy[size] = '\0';
	return copy;
}

void prof_strings_free(prof_strings *strings)
{
	for (prof_strings_block *block = strings->blocks, *next; block; block = next) {
		next = block->next;
		free(block);
	}
	*strings = (prof_strings){0};
}

/* A copy of the string with its escapes decoded. NULL: no memory. */
static const char *prof_read_string(prof_read *read, prof_span string)
{
	char *copy = prof_strings_add(&read->strings, string.text, string.size);
	if (copy && string.escaped)
		copy[prof_scan_decode(string, copy)] = '\0';
	return copy;
}

/* Hashes eight bytes at a time. Source of the constant: Steele, Lea, Flood, "Fast splittable pseudorandom number
 * generators", 2014. The seed, an address, differs from run to run, so that no file can make all names collide. */
static uint64_t prof_hash(uint64_t seed, const char *text, size_t size)
{
	uint64_t hash = seed ^ size, word;
	for (; size >= 8; text += 8, size -= 8) {
		memcpy(&word, text, 8);
		hash = (hash ^ word) * UINT64_C(0xbf58476d1ce4e5b9);
		hash ^= hash >> 29;
	}
	for (word = 0; size > 0; size--)
		word = word << 8 | (unsigned char)text[size - 1];
	hash = (hash ^ word) * UINT64_C(0xbf58476d1ce4e5b9);
	return hash ^ hash >> 32;
}

/* Replaces the slots of a hash table by twice as many, all free. Returns how many; 0: no memory. */
static size_t prof_slots_grow(uint32_t **slots, size_t count)
{
	size_t grown = count > 0 ? 2 * count : 256;
	uint32_t *more = calloc(grown, sizeof *more);
	if (!more)
		return 0;
	free(*slots);
	*slots = more;
	return grown;
}

/* ---- labels ------------------------------------------------------------------------------------------------------ */

static size_t prof_label_slot(const prof_read *read, const char *name, size_t size)
{
	assert(read->label_slot_count > read->label_count && "a slot is free, or the search would not end");
	size_t slot = prof_hash((uintptr_t)read, name, size) & (read->label_slot_count - 1);
	for (;; slot = (slot + 1) & (read->label_slot_count - 1)) {
		uint32_t label = read->label_slots[slot];
		if (label == 0)
			return slot;
		const char *other = read->labels[label - 1].name;
		if (strncmp(other, name, size) == 0 && other[size] == '\0')
			return slot;
	}
}

static bool prof_labels_grow(prof_read *read)
{
	size_t count = prof_slots_grow(&read->label_slots, read->label_slot_count);
	if (count == 0)
		return prof_read_no_memory(read);
	read->label_slot_count = count;
	for (size_t i = 0; i < read->label_count; i++) {
		const char *name = read->labels[i].name;
		read->label_slots[prof_label_slot(read, name, strlen(name))] = (uint32_t)i + 1;
	}
	return true;
}

/* *label is the label at this slot of the hash table, or a new one with that name if the slot is free. keep: the name
 * is a copy already, which lives as long as the snapshot. False: no memory. */
static bool prof_label_at(prof_read *read, size_t slot, const char *name, size_t size, bool keep, uint32_t *label)
{
	if (read->label_slots[slot] == 0) {
		if (!prof_array_room(&read->labels, sizeof *read->labels, read->label_count + 1, &read->label_capacity))
			return prof_read_no_memory(read);
		if (!keep && !(name = prof_strings_add(&read->strings, name, size)))
			return prof_read_no_memory(read);
		read->labels[read->label_count++] = (stilb_prof_label){.name = name, .function = "", .file = ""};
		read->label_slots[slot] = (uint32_t)read->label_count;
	}
	*label = read->label_slots[slot] - 1;
	assert(*label < read->label_count);
	return true;
}

static bool prof_read_label(prof_read *read, prof_span name, uint32_t *label)
{
	if (2 * read->label_count >= read->label_slot_count && !prof_labels_grow(read))
		return false;
	if (!name.text)
		name = (prof_span){.text = "", .size = 0};
	if (!name.escaped)
		return prof_label_at(read, prof_label_slot(read, name.text, name.size), name.text, name.size, false, label);
	const char *decoded = prof_read_string(read, name);
	if (!decoded)
		return prof_read_no_memory(read);
	size_t size = strlen(decoded);
	return prof_label_at(read, prof_label_slot(read, decoded, size), decoded, size, true, label);
}

/* ---- lanes ------------------------------------------------------------------------------------------------------- */

static size_t prof_lane_slot(const prof_read *read, uint64_t pid, uint64_t tid)
{
	assert(read->lane_slot_count > read->lane_count && "a slot is free, or the search would not end");
	uint64_t key[2] = {pid, tid};
	size_t slot = prof_hash((uintptr_t)read, (const char *)key, sizeof key) & (read->lane_slot_count - 1);
	while (read->lane_slots[slot] != 0 &&
	       (read->lanes[read->lane_slots[slot] - 1].pid != pid || read->lanes[read->lane_slots[slot] - 1].tid != tid))
		slot = (slot + 1) & (read->lane_slot_count - 1);
	return slot;
}

prof_read_lane *prof_read_lane_find(prof_read *read, uint64_t pid, uint64_t tid)
{
	if (read->lane_count == 0)
		return NULL;
	uint32_t lane = read->lane_slots[prof_lane_slot(read, pid, tid)];
	return lane > 0 ? &read->lanes[lane - 1] : NULL;
}

static bool prof_lanes_grow(prof_read *read)
{
	size_t count = prof_slots_grow(&read->lane_slots, read->lane_slot_count);
	if (count == 0)
		return prof_read_no_memory(read);
	read->lane_slot_count = count;
	for (size_t i = 0; i < read->lane_count; i++)
		read->lane_slots[prof_lane_slot(read, read->lanes[i].pid, read->lanes[i].tid)] = (uint32_t)i + 1;
	return true;
}

/* The lane of pid and tid, made if there is none. NULL: no memory. */
static prof_read_lane *prof_read_lane_of(prof_read *read, uint64_t pid, uint64_t tid)
{
	if (read->lane_count > 0) {
		prof_read_lane *last = &read->lanes[read->last_lane];
		/* NOLINTNEXTLINE(clang-analyzer-core.NullDereference): lane_count counts the lanes that are there */
		if (last->tid == tid && last->pid == pid)
			return last;
	}
	if (2 * read->lane_count >= read->lane_slot_count && !prof_lanes_grow(read))
		return NULL;
	size_t slot = prof_lane_slot(read, pid, tid);
	if (read->lane_slots[slot] == 0) {
		if (!prof_array_room(&read->lanes, sizeof *read->lanes, read->lane_count + 1, &read->lane_capacity)) {
			read->no_memory = true;
			return NULL;
		}
		/* NOLINTNEXTLINE(clang-analyzer-core.NullDereference): prof_array_room has made room */
		read->lanes[read->lane_count++] =
			(prof_read_lane){.pid = pid, .tid = tid, .sort = INT64_MAX, .open = STILB_PROF_NONE};
		read->lane_slots[slot] = (uint32_t)read->lane_count;
	}
	read->last_lane = read->lane_slots[slot] - 1;
	assert(read->last_lane < read->lane_count);
	return &read->lanes[read->last_lane];
}

/* ---- zones, points and ends of arrows ---------------------------------------------------------------------------- */

static uint64_t prof_read_time(prof_read *read, prof_time time)
{
	assert(time.tenths >= -5 && time.tenths <= 5);
	uint64_t ns = PROF_READ_ZERO + (uint64_t)time.ns;
	read->first_ns = ns < read->first_ns ? ns : read->first_ns;
	read->last_ns = ns > read->last_ns ? ns : read->last_ns;
	return ns;
}

static uint64_t prof_tenths(prof_time time)
{
	return 10 * (uint64_t)time.ns + (uint64_t)time.tenths;
}

/* Adds a zone that begins with the event. NULL: no memory. */
static stilb_prof_zone *prof_lane_zone_add(prof_read *read, prof_read_lane *lane, const prof_raw_event *event)
{
	uint32_t label;
	if (!prof_read_label(read, event->name, &label))
		return NULL;
	if (!prof_array_room(&lane->zones, sizeof *lane->zones, lane->zone_count + 1, &lane->zone_capacity) ||
	    lane->zone_count >= STILB_PROF_NONE - 1) {
		read->no_memory = true;
		return NULL;
	}
	lane->used = true;
	stilb_prof_zone *zone = &lane->zones[lane->zone_count++];
	*zone = (stilb_prof_zone){
		.begin_ns = prof_read_time(read, event->ts),
		.self_ns = prof_tenths(event->ts),
		.label = label,
		.parent = STILB_PROF_NONE,
	};
	return zone;
}

static bool prof_event_complete(prof_read *read, const prof_raw_event *event)
{
	prof_read_lane *lane = prof_read_lane_of(read, event->pid, event->tid);
	stilb_prof_zone *zone = lane ? prof_lane_zone_add(read, lane, event) : NULL;
	if (!zone)
		return false;
	zone->end_ns = prof_read_time(read, (prof_time){event->ts.ns + event->dur.ns, 0});
	zone->off_cpu_ns = prof_tenths(event->ts) + prof_tenths(event->dur);
	return true;
}

static bool prof_event_begin(prof_read *read, const prof_raw_event *event)
{
	prof_read_lane *lane = prof_read_lane_of(read, event->pid, event->tid);
	stilb_prof_zone *zone = lane ? prof_lane_zone_add(read, lane, event) : NULL;
	if (!zone)
		return false;
	zone->open = true;
	zone->parent = lane->open;
	lane->open = (uint32_t)lane->zone_count - 1;
	return true;
}

/* An E event: ends the zone that was begun last on its thread, whatever its name. If none is open, the zone began
 * before the file does, and the event is ignored. */
static bool prof_event_end(prof_read *read, const prof_raw_event *event)
{
	prof_read_lane *lane = prof_read_lane_of(read, event->pid, event->tid);
	if (!lane)
		return false;
	if (lane->open == STILB_PROF_NONE)
		return true;
	assert(lane->open < lane->zone_count && lane->zones[lane->open].open && "a chain of zones that have not ended");
	stilb_prof_zone *zone = &lane->zones[lane->open];
	uint64_t ns = prof_read_time(read, event->ts);
	zone->end_ns = ns > zone->begin_ns ? ns : zone->begin_ns;
	zone->off_cpu_ns = ns > zone->begin_ns ? prof_tenths(event->ts) : zone->self_ns;
	zone->open = false;
	lane->open = zone->parent;
	zone->parent = STILB_PROF_NONE;
	return true;
}

static bool prof_point_add(prof_read *read, const prof_raw_event *event, prof_span name, bool counter, double value)
{
	stilb_prof_point point = {.value = value, .lane = STILB_PROF_NONE, .counter = counter};
	prof_read_lane *lane = event->has_tid ? prof_read_lane_of(read, event->pid, event->tid) : NULL;
	if (read->no_memory || !prof_read_label(read, name, &point.label))
		return false;
	if (lane) {
		lane->used = true;
		point.lane = (uint32_t)(lane - read->lanes);
	}
	point.ns = prof_read_time(read, event->ts);
	if (!prof_array_room(&read->points, sizeof *read->points, read->point_count + 1, &read->point_capacity))
		return prof_read_no_memory(read);
	read->points[read->point_count++] = point;
	return true;
}

static bool prof_event_flow(prof_read *read, const prof_raw_event *event, uint64_t frame)
{
	prof_read_lane *lane = prof_read_lane_of(read, event->pid, event->tid);
	prof_read_end end = {.id = event->id, .frame = frame, .phase = event->phase};
	if (!lane || !prof_read_label(read, event->name, &end.label))
		return false;
	lane->used = true;
	end.lane = (uint32_t)(lane - read->lanes);
	end.ns = prof_read_time(read, event->ts);
	if (!prof_array_room(&read->ends, sizeof *read->ends, read->end_count + 1, &read->end_capacity))
		return prof_read_no_memory(read);
	read->ends[read->end_count++] = end;
	return true;
}

/* ---- args -------------------------------------------------------------------------------------------------------- */

/* The members of an event's "args" that are read, of all phases (kinds of events). */
typedef struct prof_args {
	prof_span name, no_switches;
	int64_t sort_index;
	uint64_t tid, number, frame, switches_from;
	bool device, has_sort, has_number, has_frame;
} prof_args;

/* Reads a value; *value and *has are set if it is a whole number. */
static bool prof_args_integer(prof_scan *scan, uint64_t *value, bool *has)
{
	prof_span number;
	if (!prof_scan_value(scan, &number))
		return false;
	if (prof_span_integer(number, value))
		*has = true;
	return true;
}

static bool prof_args_member(prof_scan *scan, prof_span key, prof_args *args)
{
	prof_span value;
	bool ignored;
	uint64_t sort;
	if (PROF_SPAN_IS(key, "name") && prof_scan_next(scan) == '"')
		return prof_scan_string(scan, &args->name);
	if (PROF_SPAN_IS(key, "no_switches") && prof_scan_next(scan) == '"')
		return prof_scan_string(scan, &args->no_switches);
	if (PROF_SPAN_IS(key, "number"))
		return prof_args_integer(scan, &args->number, &args->has_number);
	if (PROF_SPAN_IS(key, "frame"))
		return prof_args_integer(scan, &args->frame, &args->has_frame);
	if (PROF_SPAN_IS(key, "tid"))
		return prof_args_integer(scan, &args->tid, &ignored);
	if (PROF_SPAN_IS(key, "switches_from"))
		return prof_args_integer(scan, &args->switches_from, &ignored);
	if (PROF_SPAN_IS(key, "sort_index")) {
		bool negative = prof_scan_take(scan, '-');
		if (!prof_args_integer(scan, &sort, &args->has_sort))
			return false;
		args->sort_index = !args->has_sort ? 0 : negative ? -(int64_t)sort : (int64_t)sort;
		return true;
	}
	if (!prof_scan_value(scan, &value))
		return false;
	if (PROF_SPAN_IS(key, "device"))
		args->device = PROF_SPAN_IS(value, "true");
	return true;
}

/* Reads the members of args, if span is an object. Its syntax is right, since prof_scan_value has passed over it
 * before; false: an error in a member, for example a sort_index of "-". */
static bool prof_args_parse(prof_read *read, prof_span span, prof_args *args)
{
	prof_scan scan = read->scan;
	prof_span key;
	bool first = true;
	*args = (prof_args){0};
	if (!span.text || *span.text != '{')
		return true;
	assert(span.text >= scan.begin && span.text < scan.end);
	scan.at = span.text + 1;
	while (prof_scan_key(&scan, &first, &key))
		if (!prof_args_member(&scan, key, args))
			break;
	if (!scan.failed)
		return true;
	return prof_scan_fail(&read->scan, scan.failed, scan.expected);
}

/* The name of a counter: "memory" {"value":1} is the counter "memory". With other keys each value is a counter, named
 * as in Perfetto: "memory used". */
static bool prof_counter_name(prof_read *read, const prof_raw_event *event, prof_span key, prof_span *name)
{
	*name = event->name;
	if (PROF_SPAN_IS(key, "value") || !name->text || name->escaped || key.escaped || name->size == 0)
		return true;
	size_t size = name->size + 1 + key.size;
	char *joined = prof_strings_add(&read->strings, name->text, size);
	if (!joined)
		return prof_read_no_memory(read);
	joined[name->size] = ' ';
	memcpy(joined + name->size + 1, key.text, key.size);
	*name = (prof_span){.text = joined, .size = size};
	return true;
}

static bool prof_event_counter(prof_read *read, const prof_raw_event *event)
{
	prof_scan scan = read->scan;
	prof_span key, value, name;
	bool first = true;
	double number;
	if (!event->args.text || *event->args.text != '{')
		return true;
	scan.at = event->args.text + 1;
	while (prof_scan_key(&scan, &first, &key)) {
		char next = prof_scan_next(&scan);
		if (next != '-' && (next < '0' || next > '9')) {
			if (!prof_scan_value(&scan, &value))
				break;
			continue;
		}
		if (!prof_scan_double(&scan, &number))
			break;
		if (!prof_counter_name(read, event, key, &name) || !prof_point_add(read, event, name, true, number))
			return false;
	}
	read->scan.c_locale = scan.c_locale;
	return !scan.failed || prof_scan_fail(&read->scan, scan.failed, scan.expected);
}

/* ---- metadata and frames ----------------------------------------------------------------------------------------- */

static bool prof_event_metadata(prof_read *read, const prof_raw_event *event)
{
	prof_args args;
	bool is_name = PROF_SPAN_IS(event->name, "thread_name");
	if (!is_name && !PROF_SPAN_IS(event->name, "thread_sort_index"))
		return true;
	if (!prof_args_parse(read, event->args, &args))
		return false;
	prof_read_lane *lane = prof_read_lane_of(read, event->pid, event->tid);
	if (!lane)
		return false;
	if (!is_name) {
		lane->sort = args.has_sort ? args.sort_index : lane->sort;
		return true;
	}
	if (!args.name.text)
		return true;
	lane->device = args.device;
	lane->kernel_tid = args.tid;
	lane->switches_from = args.switches_from;
	lane->frames = PROF_SPAN_IS(args.name, "frames");
	lane->name = prof_read_string(read, args.name);
	if (lane->name && args.no_switches.text)
		lane->no_switches = prof_read_string(read, args.no_switches);
	bool good = lane->name && (!args.no_switches.text || lane->no_switches);
	return good || prof_read_no_memory(read);
}

/* Adds an instant, or, on the thread "frames", the number of a frame. */
static bool prof_event_instant(prof_read *read, const prof_raw_event *event)
{
	prof_args args;
	prof_read_lane *lane = event->has_tid ? prof_read_lane_of(read, event->pid, event->tid) : NULL;
	if (read->no_memory)
		return false;
	if (!lane || !lane->frames)
		return prof_point_add(read, event, event->name, false, 0.0);
	if (!prof_args_parse(read, event->args, &args))
		return false;
	if (!args.has_number)
		return true;
	if (!prof_array_room(&read->marks, sizeof *read->marks, read->mark_count + 1, &read->mark_capacity))
		return prof_read_no_memory(read);
	read->marks[read->mark_count++] = (prof_read_mark){prof_read_time(read, event->ts), args.number};
	return true;
}

/* ---- an event ---------------------------------------------------------------------------------------------------- */

/* Reads an id: a whole number as it is; anything else as its hash with bit 63 set, which no number has. */
static bool prof_scan_id(prof_scan *scan, uint64_t *id)
{
	prof_span value;
	if (!prof_scan_value(scan, &value))
		return false;
	if (!prof_span_integer(value, id))
		*id = prof_hash(0, value.text, value.size) | UINT64_C(1) << 63;
	return true;
}

static bool prof_scan_phase(prof_scan *scan, char *phase)
{
	prof_span value;
	if (!prof_scan_string(scan, &value))
		return false;
	*phase = '\0';
	if (value.size == 1)
		*phase = value.text[0];
	return true;
}

static bool prof_event_member(prof_scan *scan, prof_span key, prof_raw_event *event)
{
	prof_span value;
	if (PROF_SPAN_IS(key, "ph"))
		return prof_scan_phase(scan, &event->phase);
	if (PROF_SPAN_IS(key, "ts"))
		return event->has_ts = prof_scan_us(scan, true, &event->ts);
	if (PROF_SPAN_IS(key, "dur"))
		return event->has_dur = prof_scan_us(scan, false, &event->dur);
	if (PROF_SPAN_IS(key, "pid"))
		return prof_scan_id(scan, &event->pid);
	if (PROF_SPAN_IS(key, "tid"))
		return event->has_tid = prof_scan_id(scan, &event->tid);
	if (PROF_SPAN_IS(key, "id"))
		return prof_scan_id(scan, &event->id);
	if (PROF_SPAN_IS(key, "args"))
		return prof_scan_value(scan, &event->args);
	if (PROF_SPAN_IS(key, "name") && prof_scan_next(scan) == '"')
		return prof_scan_string(scan, &event->name);
	return prof_scan_value(scan, &value);
}

static bool prof_event_take(prof_read *read, const char *begin, const prof_raw_event *event)
{
	assert(begin >= read->scan.begin && begin < read->scan.at);
	prof_args args;
	if (event->phase == 'M')
		return !event->name.text || prof_event_metadata(read, event);
	if (event->phase == '\0' || !strchr("XBEiICstf", event->phase))
		return true;
	if (!event->has_ts)
		return prof_scan_fail(&read->scan, begin, "an event with \"ts\"");
	switch (event->phase) {
	case 'X':
		if (!event->has_dur)
			return prof_scan_fail(&read->scan, begin, "an X event with \"dur\"");
		return prof_event_complete(read, event);
	case 'B':
		return prof_event_begin(read, event);
	case 'E':
		return prof_event_end(read, event);
	case 'C':
		return prof_event_counter(read, event);
	case 'i':
	case 'I':
		return prof_event_instant(read, event);
	default:
		if (!prof_args_parse(read, event->args, &args))
			return false;
		return prof_event_flow(read, event, args.has_frame ? args.frame : UINT64_MAX);
	}
}

static bool prof_read_event(prof_read *read)
{
	prof_scan *scan = &read->scan;
	prof_raw_event event = {0};
	prof_span key;
	bool first = true;
	prof_scan_space(scan);
	const char *begin = scan->at;
	if (!prof_scan_take(scan, '{'))
		return prof_scan_fail(scan, begin, "an event: '{'");
	while (prof_scan_key(scan, &first, &key))
		if (!prof_event_member(scan, key, &event))
			return false;
	return !scan->failed && prof_event_take(read, begin, &event);
}

/* Reads events after '['. If may_end, the closing ']' may be missing: programs that crashed could not write it. */
static bool prof_read_array(prof_read *read, bool may_end)
{
	prof_scan *scan = &read->scan;
	if (prof_scan_take(scan, ']'))
		return true;
	for (;;) {
		if (may_end && prof_scan_next(scan) == '\0' && scan->at == scan->end)
			return true;
		if (!prof_read_event(read))
			return false;
		if (prof_scan_take(scan, ']'))
			return true;
		if (may_end && prof_scan_next(scan) == '\0' && scan->at == scan->end)
			return true;
		if (!prof_scan_take(scan, ','))
			return prof_scan_fail(scan, scan->at, "',' or ']' after an event");
	}
}

/* ---- the whole --------------------------------------------------------------------------------------------------- */

static bool prof_header_string(prof_read *read, const char **out)
{
	prof_span string;
	if (!prof_scan_string(&read->scan, &string))
		return false;
	*out = prof_read_string(read, string);
	return *out || prof_read_no_memory(read);
}

static bool prof_header_member(prof_read *read, prof_span key)
{
	stilb_prof_snapshot *h = &read->header;
	const struct {
		const char *key;
		double *real;
		uint64_t *integer;
	} known[] = {
		{"hz", &h->hz, NULL},
		{"resolution_ns", &h->resolution_ns, NULL},
		{"bias_ns", &h->bias_ns, NULL},
		{"zone_cost_ns", &h->zone_cost_ns, NULL},
		{"epoch_ns", NULL, &h->epoch_ns},
		{"begin_ns", NULL, &read->header_begin_ns},
		{"end_ns", NULL, &read->header_end_ns},
		{"events_recorded", NULL, &h->events_recorded},
		{"events_lost", NULL, &h->events_lost},
		{"events_held", NULL, &h->events_held},
		{"too_deep", NULL, &h->too_deep},
		{"without_ring", NULL, &h->without_ring},
	};
	prof_span value;
	char next = prof_scan_next(&read->scan);
	if (PROF_SPAN_IS(key, "clock") && next == '"')
		return prof_header_string(read, &h->clock);
	for (size_t i = 0; i < sizeof known / sizeof *known; i++)
		if (prof_span_is(key, known[i].key, strlen(known[i].key))) {
			bool has;
			if (known[i].integer)
				return prof_args_integer(&read->scan, known[i].integer, &has);
			if (next == '-' || (next >= '0' && next <= '9'))
				return prof_scan_double(&read->scan, known[i].real);
		}
	return prof_scan_value(&read->scan, &value);
}

static bool prof_read_header(prof_read *read)
{
	prof_span key;
	bool first = true;
	while (prof_scan_key(&read->scan, &first, &key))
		if (!prof_header_member(read, key))
			return false;
	return !read->scan.failed;
}

static bool prof_read_object(prof_read *read)
{
	prof_scan *scan = &read->scan;
	prof_span key, value;
	bool first = true, events = false;
	while (prof_scan_key(scan, &first, &key)) {
		if (PROF_SPAN_IS(key, "traceEvents")) {
			if (!prof_scan_take(scan, '['))
				return prof_scan_fail(scan, scan->at, "an array of events");
			events = true;
			if (!prof_read_array(read, false))
				return false;
		} else if (PROF_SPAN_IS(key, "otherData") && prof_scan_take(scan, '{')) {
			if (!prof_read_header(read))
				return false;
		} else if (!prof_scan_value(scan, &value)) {
			return false;
		}
	}
	if (!scan->failed && !events)
		prof_scan_fail(scan, scan->at, "\"traceEvents\" before the end of the object");
	return !scan->failed;
}

bool prof_read_events(prof_read *read)
{
	prof_scan *scan = &read->scan;
	assert(scan->at == scan->begin && !scan->failed && "read once");
	read->first_ns = UINT64_MAX;
	if (prof_scan_next(scan) == '\0' && scan->at == scan->end)
		return prof_scan_fail(scan, scan->at, "a trace");
	bool array = prof_scan_take(scan, '[');
	if (!array && !prof_scan_take(scan, '{'))
		return prof_scan_fail(scan, scan->at, "a Chrome trace: '{' or '['");
	if (!(array ? prof_read_array(read, true) : prof_read_object(read)))
		return false;
	prof_scan_space(scan);
	return scan->at == scan->end || prof_scan_fail(scan, scan->at, "nothing after the trace");
}
