/* Shared by prof_snapshot.c and prof_snapshot_zones.c: a snapshot while it is being made. */
#ifndef STILB_PROF_SNAPSHOT_INTERNAL_H
#define STILB_PROF_SNAPSHOT_INTERNAL_H

#include "profiler/prof_internal.h"

/* A zone while it is still in the order in which zones end, as events are; then it is moved to its place in the order
 * in which zones begin, as in the snapshot. */
typedef struct prof_zone_node {
	uint64_t begin, end; /* ns */
	uint32_t label;
	uint32_t parent; /* index of a node, or PROF_NONE */
	uint32_t size;   /* zones in its subtree, itself included */
	uint16_t level;
	bool open;
} prof_zone_node;

/* One end of a flow. */
typedef struct prof_flow_mark {
	uint64_t id;
	uint64_t ns;
	uint32_t label;
	uint32_t lane;
	uint32_t zone; /* the zone around it: index of a node, later into the lane's zones; or PROF_NONE */
	bool begin;
	bool joined; /* this begin has an end */
} prof_flow_mark;

typedef struct prof_snapshot_memory {
	prof_memory memory; /* first */
	prof_copy copy;
	prof_timeline timeline;
	uint64_t now_ns;    /* the time of the snapshot: open zones end there */
	uint64_t end_ticks; /* end of the window: open zones that began at it or later are left out */

	stilb_prof_label *labels; /* kept from one take to the next */
	size_t label_count, label_capacity;
	struct prof_site_slot {
		const stilb_prof_site *site; /* NULL: empty */
		uint32_t label;
	} * sites; /* an open hash table of twice as many slots as labels have room, a power of two */
	size_t site_capacity;

	stilb_prof_frame *frames;
	stilb_prof_lane *lanes;
	stilb_prof_zone *zones; /* of all lanes */
	stilb_prof_switch *switches;
	uint64_t *off_before; /* for each switch of one lane: ns off the CPU in all of its switches before that one */
	stilb_prof_point *points;
	prof_flow_mark *marks;
	stilb_prof_flow *flows;
	size_t frame_capacity, lane_capacity, zone_capacity, switch_capacity, off_capacity, point_capacity, mark_capacity,
		flow_capacity;
	size_t zone_count, switch_count, point_count, mark_count, flow_count;

	/* Scratch: used during one take alone. */
	prof_zone_node *nodes; /* the zones of one lane */
	uint32_t *flow_slots;  /* an open hash table of the marks that begin flows */
	char *merged;          /* where prof_runs_merge writes */
	size_t *runs;          /* indices at which runs begin: parts of points or flows that ascend by time */
	size_t node_capacity, slot_capacity, merged_capacity, run_capacity;
	uint32_t frame_count;
} prof_snapshot_memory;

/* The label of a site, or PROF_NONE: no memory. */
uint32_t prof_snapshot_label(prof_snapshot_memory *m, const stilb_prof_site *site);

/* The index into frames of the frame in which the flow with this id was begun, or STILB_PROF_NONE: it is not in the
 * window. */
uint32_t prof_snapshot_flow_frame(const prof_snapshot_memory *m, uint64_t id);

/* Converts a time of the lane's clock to nanoseconds since the profiler's first call. */
static inline uint64_t prof_snapshot_ns(prof_snapshot_memory *m, const prof_lane_copy *lane, uint64_t time)
{
	if (!lane->device)
		return prof_timeline_ns(&m->timeline, time);
	return time > m->timeline.epoch_ns ? time - m->timeline.epoch_ns : 0;
}

/* Appends the zones of a lane to m->zones, which has room for them, and its points and marks, ascending. False: no
 * memory. */
bool prof_snapshot_zones(prof_snapshot_memory *m, uint32_t index);

/* Computes off_cpu_ns of the lane's zones from its switches and m->off_before. */
void prof_snapshot_off_cpu(prof_snapshot_memory *m, uint32_t index);

#endif
