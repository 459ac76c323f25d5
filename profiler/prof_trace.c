/*
 * Chrome trace JSON from a copy of the rings.
 * Source of the format: Google, "Trace Event Format"; what Perfetto and chrome://tracing really need beyond it:
 * displayTimeUnit "ns" (else nesting is rounded to microseconds), parents before children at equal times, three decimals.
 *
 * The order of a ring is the order in which zones end: children before parents. Times alone cannot tell a child from an
 * earlier sibling when both begin in the same tick, so the tree is rebuilt from that order and the depths, and then
 * walked parents first. Times become whole nanoseconds by one monotone map and are clamped to the parent, so no zone
 * sticks out of its parent whatever the rounding. Viewers written in JavaScript add ts and dur as doubles, so that ends
 * which are equal in the decimals may come out in either order, and speedscope then drops zones; it also takes a zone
 * that begins where one of the same name ends for a child of it. So a zone that touches the next one or the end of its
 * parent is written 1 ns shorter.
 */
#include "profiler/prof_internal.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#define PROF_TID_FRAMES 1 /* the frames' pseudo-thread; threads follow */

typedef struct prof_trace {
	prof_json json;
	prof_copy copy;
	prof_timeline timeline;
	uint64_t pid;
	uint32_t first_frame; /* index into copy.frame_begin of the first frame to write */
	uint64_t window;      /* ticks; zones that ended before are left out */
	uint64_t written;     /* zones that had ended */
} prof_trace;

/* {"ph":"X","pid":1,"tid":2 and no closing brace. */
static void prof_trace_open(prof_trace *trace, const char *phase, uint64_t tid)
{
	prof_json *json = &trace->json;
	prof_json_text(json, ",\n{\"ph\":\"");
	prof_json_text(json, phase);
	prof_json_text(json, "\",\"pid\":");
	prof_json_u64(json, trace->pid);
	prof_json_text(json, ",\"tid\":");
	prof_json_u64(json, tid);
}

/* ---- who is who --------------------------------------------------------------------------------------------------- */

static void prof_trace_thread(prof_trace *trace, uint64_t tid, const char *name)
{
	prof_json *json = &trace->json;
	prof_trace_open(trace, "M", tid);
	prof_json_text(json, ",\"name\":\"thread_name\",\"args\":{\"name\":");
	prof_json_string(json, name);
	prof_json_text(json, "}}");
	prof_trace_open(trace, "M", tid);
	prof_json_text(json, ",\"name\":\"thread_sort_index\",\"args\":{\"sort_index\":");
	prof_json_u64(json, tid);
	prof_json_text(json, "}}");
}

static void prof_trace_head(prof_trace *trace, const char *process_name)
{
	prof_json *json = &trace->json;
	prof_json_text(json, "{\"displayTimeUnit\":\"ns\",\"traceEvents\":[\n{\"ph\":\"M\",\"pid\":");
	prof_json_u64(json, trace->pid);
	prof_json_text(json, ",\"tid\":1,\"name\":\"process_name\",\"args\":{\"name\":");
	prof_json_string(json, process_name);
	prof_json_text(json, "}}");
	prof_trace_thread(trace, PROF_TID_FRAMES, "frames");
	for (uint32_t i = 0; i < trace->copy.thread_count; i++)
		prof_trace_thread(trace, PROF_TID_FRAMES + 1 + i, trace->copy.threads[i].name);
}

/* ---- frames ------------------------------------------------------------------------------------------------------- */

static void prof_trace_slice(prof_trace *trace, uint64_t tid, const char *name, uint64_t begin_ns, uint64_t end_ns)
{
	prof_json *json = &trace->json;
	prof_trace_open(trace, "X", tid);
	prof_json_text(json, ",\"ts\":");
	prof_json_us(json, begin_ns);
	prof_json_text(json, ",\"dur\":");
	prof_json_us(json, end_ns - begin_ns);
	prof_json_text(json, ",\"name\":");
	prof_json_string(json, name);
	prof_json_text(json, "}");
}

/* A frame is whole when the next one has begun; the last one held has only its mark. */
static void prof_trace_frames(prof_trace *trace)
{
	const prof_copy *copy = &trace->copy;
	prof_json *json = &trace->json;
	for (uint32_t i = trace->first_frame; i < copy->frame_count; i++) {
		const uint64_t begin_ns = prof_timeline_ns(&trace->timeline, copy->frame_begin[i]);
		if (i + 1 < copy->frame_count) {
			const uint64_t next_ns = prof_timeline_ns(&trace->timeline, copy->frame_begin[i + 1]);
			prof_trace_slice(trace, PROF_TID_FRAMES, "frame", begin_ns, next_ns - (next_ns > begin_ns));
		}
		prof_trace_open(trace, "i", PROF_TID_FRAMES);
		prof_json_text(json, ",\"ts\":");
		prof_json_us(json, begin_ns);
		prof_json_text(json, ",\"s\":\"g\",\"name\":\"frame\",\"args\":{\"number\":");
		prof_json_u64(json, copy->first_frame + i);
		prof_json_text(json, "}}");
	}
}

/* ---- zones -------------------------------------------------------------------------------------------------------- */

/* Depths saturate at the last level: there the times decide alone. */
static bool prof_zone_is_inside(const prof_zone *inner, const prof_zone *outer)
{
	const bool deeper = inner->depth > outer->depth || inner->depth >= STILB_PROF_DEPTH_MAX - 1;
	return deeper && inner->begin >= outer->begin;
}

/* Finds each zone's children: they stand right before it, subtree by subtree. */
static void prof_zones_link(prof_zone *zones, uint32_t count)
{
	for (uint32_t i = 0; i < count; i++) {
		zones[i].parent = PROF_NONE;
		zones[i].size = 1;
		while (zones[i].size <= i && prof_zone_is_inside(&zones[i - zones[i].size], &zones[i])) {
			prof_zone *child = &zones[i - zones[i].size];
			child->parent = i;
			zones[i].size += child->size;
		}
	}
	for (uint32_t i = count; i-- > 0;)
		zones[i].level = zones[i].parent == PROF_NONE ? 0 : zones[zones[i].parent].level + 1;
}

/* A subtree fills the same places in both orders, its root last in one and first in the other; and in the latter each
 * ancestor stands before it instead of behind. So a zone's place is (its place) - (size - 1) + level. */
static void prof_zones_order(const prof_zone *zones, uint32_t count, uint32_t *order)
{
	for (uint32_t i = 0; i < count; i++)
		order[i - (zones[i].size - 1) + zones[i].level] = i;
}

static uint64_t prof_clamp(uint64_t value, uint64_t low, uint64_t high)
{
	return value < low ? low : value > high ? high : value;
}

/* Times in nanoseconds: after the sibling before, within the parent. cursor is that of the roots. */
static void prof_zone_place(prof_zone *zones, prof_zone *zone, const prof_timeline *timeline, uint64_t *cursor)
{
	prof_zone *parent = zone->parent == PROF_NONE ? NULL : &zones[zone->parent];
	uint64_t *from = parent != NULL ? &parent->cursor_ns : cursor;
	const uint64_t high = parent != NULL ? parent->end_ns : UINT64_MAX;
	zone->begin_ns = prof_clamp(prof_timeline_ns(timeline, zone->begin), *from, high);
	zone->end_ns = prof_clamp(prof_timeline_ns(timeline, zone->end), zone->begin_ns, high);
	zone->cursor_ns = zone->begin_ns;
	*from = zone->end_ns;
}

/* Makes a zone end before next, the zone after its subtree, begins, and before its parent ends. Parents come first. */
static void prof_zone_cut(const prof_zone *zones, prof_zone *zone, const prof_zone *next)
{
	uint64_t high = UINT64_MAX;
	if (zone->parent != PROF_NONE) {
		const prof_zone *parent = &zones[zone->parent];
		if (!parent->open)
			high = parent->end_ns - (parent->end_ns > parent->begin_ns);
	}
	zone->begin_ns = prof_clamp(zone->begin_ns, 0, high);
	zone->end_ns = prof_clamp(zone->end_ns, 0, high);
	if (next == NULL || next->parent != zone->parent)
		return;
	const uint64_t next_ns = prof_clamp(next->begin_ns, 0, high); /* where it will be cut to */
	if (zone->end_ns == next_ns && zone->end_ns > zone->begin_ns)
		zone->end_ns--;
}

static void prof_trace_zone(prof_trace *trace, uint64_t tid, const prof_zone *zone)
{
	prof_json *json = &trace->json;
	if (!zone->open) {
		prof_trace_slice(trace, tid, zone->site->name, zone->begin_ns, zone->end_ns);
		trace->written++;
		return;
	}
	prof_trace_open(trace, "B", tid);
	prof_json_text(json, ",\"ts\":");
	prof_json_us(json, zone->begin_ns);
	prof_json_text(json, ",\"name\":");
	prof_json_string(json, zone->site->name);
	prof_json_text(json, "}");
}

static int prof_trace_zones(prof_trace *trace, uint64_t tid, prof_thread_copy *thread)
{
	uint32_t skip = 0; /* zones stand in the order of their ends */
	while (skip < thread->count && thread->zones[skip].end < trace->window)
		skip++;
	prof_zone *zones = thread->zones + skip;
	const uint32_t count = thread->count - skip;
	uint32_t *order = malloc(((size_t)count + 1) * sizeof *order);
	uint64_t cursor = 0;
	if (order == NULL)
		return -ENOMEM;
	prof_zones_link(zones, count);
	prof_zones_order(zones, count, order);
	for (uint32_t i = 0; i < count; i++)
		prof_zone_place(zones, &zones[order[i]], &trace->timeline, &cursor);
	for (uint32_t i = 0; i < count && trace->json.error == 0; i++) {
		prof_zone *zone = &zones[order[i]];
		prof_zone_cut(zones, zone, i + zone->size < count ? &zones[order[i + zone->size]] : NULL);
		prof_trace_zone(trace, tid, zone);
	}
	free(order);
	return trace->json.error;
}

/* ---- the whole ---------------------------------------------------------------------------------------------------- */

static void prof_trace_account(prof_json *json, const char *name, uint64_t value)
{
	prof_json_text(json, ",\"");
	prof_json_text(json, name);
	prof_json_text(json, "\":");
	prof_json_u64(json, value);
}

static void prof_trace_tail(prof_trace *trace)
{
	prof_json *json = &trace->json;
	const prof_copy *copy = &trace->copy;
	prof_json_text(json, "\n],\"otherData\":{\"clock\":");
	prof_json_string(json, trace->timeline.tsc ? "rdtsc" : "CLOCK_MONOTONIC");
	prof_trace_account(json, "hz", (uint64_t)(trace->timeline.hz + 0.5));
	prof_json_text(json, ",\"resolution_ns\":");
	prof_json_us(json, (uint64_t)(trace->timeline.resolution_ns * 1000.0 + 0.5)); /* thousandths either way */
	prof_trace_account(json, "events_recorded", copy->events_recorded);
	prof_trace_account(json, "events_lost", copy->events_recorded - copy->events_held);
	prof_trace_account(json, "events_held", copy->events_held);
	prof_trace_account(json, "events_written", trace->written);
	prof_json_text(json, "}}\n");
}

/* N whole frames back from the last mark, if that many are remembered. */
static void prof_trace_choose(prof_trace *trace, uint32_t last_frames)
{
	if (last_frames == 0 || last_frames >= trace->copy.frame_count)
		return;
	trace->first_frame = trace->copy.frame_count - 1 - last_frames;
	trace->window = trace->copy.frame_begin[trace->first_frame];
}

int stilb_prof_trace_write(const stilb_prof_trace_desc *desc, int (*write)(void *user, const void *data, size_t size),
                           void *user)
{
	prof_trace *trace = calloc(1, sizeof *trace);
	if (trace == NULL)
		return -ENOMEM;
	trace->json.write = write;
	trace->json.user = user;
	trace->pid = (uint64_t)getpid();
	int error = prof_copy_take(&trace->copy);
	trace->timeline = prof_clock_timeline();
	if (error == 0) {
		prof_trace_choose(trace, desc != NULL ? desc->last_frames : 0);
		prof_trace_head(trace, desc != NULL && desc->process_name != NULL ? desc->process_name
		                                                                  : program_invocation_short_name);
		prof_trace_frames(trace);
	}
	for (uint32_t i = 0; i < trace->copy.thread_count && error == 0; i++)
		error = prof_trace_zones(trace, PROF_TID_FRAMES + 1 + i, &trace->copy.threads[i]);
	if (error == 0) {
		prof_trace_tail(trace);
		error = prof_json_flush(&trace->json);
	}
	prof_copy_free(&trace->copy);
	free(trace);
	return error;
}
