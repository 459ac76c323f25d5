/*
 * The steps from a trace to a snapshot: prof_read_json.c reads JSON, prof_read_events.c appends the events to arrays as
 * they come, and prof_read_link.c orders them: nesting, flows, frames, switches.
 */
#ifndef STILB_PROF_READ_INTERNAL_H
#define STILB_PROF_READ_INTERNAL_H

#include "profiler/prof_internal.h"
#include "profiler/prof_snapshot.h"
#include "profiler/read/prof_read_json.h"

/* Times in files of other programs may be negative. While reading, this is added to all times, which keeps their
 * order. */
#define PROF_READ_ZERO (UINT64_C(1) << 62)

/* Strings in blocks; their addresses never change. */
typedef struct prof_strings {
	struct prof_strings_block *blocks;
	char *at;
	size_t room;
} prof_strings;

/* A lane while the file is read: the events of one pid and tid. Until prof_read_link, the zones are in the order of the
 * file, their `parent` chains the B events that have no E yet, and self_ns and off_cpu_ns hold begin and end in tenths
 * of nanoseconds, modulo 2^64. Tenths matter, since prof_trace_chrome.c lets zones end by tenths before they touch. */
typedef struct prof_read_lane {
	uint64_t pid, tid;
	const char *name;        /* NULL: the file names none */
	const char *no_switches; /* as in stilb_prof_lane */
	int64_t sort;            /* the file's thread_sort_index; INT64_MAX: it has none */
	uint64_t kernel_tid;     /* the kernel's thread id, if the file names it; else 0 */
	uint64_t switches_from;  /* of a thread "...: off the CPU": switches_ns of the lane whose switches it has */
	uint64_t switches_ns;    /* as in stilb_prof_lane */
	bool device, used, frames;
	uint32_t open;  /* the innermost open B, or STILB_PROF_NONE */
	uint32_t index; /* in the finished snapshot; STILB_PROF_NONE: left out, as the lane of frames is */
	stilb_prof_zone *zones;
	size_t zone_count, zone_capacity;
	stilb_prof_switch *switches;
	size_t switch_count;
} prof_read_lane;

/* One end of a flow: an s, t or f event. */
typedef struct prof_read_end {
	uint64_t id, ns;
	uint32_t lane, label;
	uint64_t frame; /* number that the f event gives, or UINT64_MAX */
	char phase;
} prof_read_end;

/* The begin of a frame and its number, from an i event of the thread "frames". */
typedef struct prof_read_mark {
	uint64_t ns, number;
} prof_read_mark;

/* The memory of a snapshot that was read, and what is needed while reading it. */
typedef struct prof_read {
	prof_memory memory;
	prof_scan scan;
	prof_strings strings;
	stilb_prof_label *labels;
	uint32_t *label_slots; /* hash table by name, its size a power of two: 1 + index of the label, 0: free */
	prof_read_lane *lanes;
	uint32_t *lane_slots; /* the same by pid and tid: 1 + index of the lane, 0: free */
	uint32_t last_lane;   /* index of the lane found last */
	stilb_prof_point *points;
	prof_read_end *ends;
	prof_read_mark *marks;
	size_t label_count, label_capacity, label_slot_count, lane_count, lane_capacity, lane_slot_count;
	size_t point_count, point_capacity, end_count, end_capacity, mark_count, mark_capacity;
	stilb_prof_lane *out_lanes;
	stilb_prof_frame *out_frames;
	stilb_prof_flow *out_flows;
	size_t out_lane_count, out_frame_count, out_flow_count;
	uint64_t first_ns, last_ns; /* smallest and largest time read so far; UINT64_MAX and 0: none yet */
	stilb_prof_snapshot header; /* values from otherData; clock is NULL if there are none */
	uint64_t header_begin_ns, header_end_ns;
	bool no_memory;
} prof_read;

/* Copies size bytes and adds a 0. NULL: no memory. */
char *prof_strings_add(prof_strings *strings, const char *text, size_t size);
void prof_strings_free(prof_strings *strings);

/* The lane of pid and tid; NULL: there is none. */
prof_read_lane *prof_read_lane_find(prof_read *read, uint64_t pid, uint64_t tid);

/* Reads the whole text into the arrays. False: read->scan holds the error, or read->no_memory is set. */
bool prof_read_events(prof_read *read);

/* Makes the snapshot from the arrays. False: no memory. */
bool prof_read_link(prof_read *read, stilb_prof_snapshot *snapshot);

#endif
