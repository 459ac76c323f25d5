/*
 * Makes the zones of a lane, a tree, from its events, a flat list.
 *
 * Events are in the order in which zones end: children before parents. Times alone cannot tell a child from an earlier
 * sibling if both begin in the same tick, so the tree is rebuilt from that order and the depths: walking backwards, the
 * parent of a zone is the last zone met that is less deep and began no later. The snapshot wants the zones in the order
 * of their begins. A subtree is contiguous in both orders; its root is last in the order of ends and first in the order
 * of begins, and its ancestors stand behind it in the first order and before it in the second. So the place of a zone
 * in the order of begins is its place in the order of ends, minus (size - 1), plus level.
 *
 * Times are converted to whole nanoseconds by one monotone map. Then each zone is cut to lie between the end of its
 * previous sibling and the end of its parent, so zones nest properly whatever the clock did.
 */
#include "profiler/prof_array.h"
#include "profiler/prof_snapshot_internal.h"

#include <assert.h>
#include <string.h>

static uint64_t prof_clamp(uint64_t value, uint64_t low, uint64_t high)
{
	return value < low ? low : value > high ? high : value;
}

/* ---- ends to begins ---------------------------------------------------------------------------------------------- */

/* A zone that ended later than the event that the backward walk has reached: a possible parent of it. */
typedef struct zones_outer {
	uint64_t begin; /* ticks */
	uint32_t depth;
	uint32_t node;
} zones_outer;

typedef struct zones_walk {
	prof_snapshot_memory *m;
	const prof_lane_copy *lane;
	uint32_t index; /* of the lane */
	uint32_t first; /* nodes are filled from the end to the front: index of the one filled last */
	uint32_t outer_count;
	zones_outer outer[STILB_PROF_DEPTH_MAX]; /* possible parents, outermost first */
	bool failed;                             /* no memory */
} zones_walk;

/* Drops the possible parents that do not enclose an event of that depth and time. Returns the node of the innermost one
 * left, or PROF_NONE. */
static uint32_t zones_walk_into(zones_walk *walk, uint32_t depth, uint64_t time)
{
	const zones_outer *outer = walk->outer;
	while (walk->outer_count > 0 &&
	       (outer[walk->outer_count - 1].depth >= depth || outer[walk->outer_count - 1].begin > time))
		walk->outer_count--;
	return walk->outer_count > 0 ? outer[walk->outer_count - 1].node : PROF_NONE;
}

static void zones_walk_zone(zones_walk *walk, const prof_record *record, bool open)
{
	assert(record->depth < STILB_PROF_DEPTH_MAX && record->begin <= record->end);
	uint32_t parent = zones_walk_into(walk, record->depth, record->begin);
	uint32_t label = prof_snapshot_label(walk->m, record->site);
	assert(walk->first > 0 && walk->outer_count < STILB_PROF_DEPTH_MAX);
	prof_zone_node *node = &walk->m->nodes[--walk->first];
	walk->failed |= label == PROF_NONE;
	*node = (prof_zone_node){
		.end = open ? walk->m->now_ns : prof_snapshot_ns(walk->m, walk->lane, record->end),
		.begin = prof_snapshot_ns(walk->m, walk->lane, record->begin),
		.label = label,
		.parent = parent,
		.size = 1,
		.level = (uint16_t)walk->outer_count,
		.open = open,
	};
	walk->outer[walk->outer_count++] = (zones_outer){record->begin, record->depth, walk->first};
}

static void zones_walk_point(zones_walk *walk, const prof_record *record)
{
	prof_snapshot_memory *m = walk->m;
	uint32_t label = prof_snapshot_label(m, record->site);
	if (label == PROF_NONE || !prof_array_room(&m->points, sizeof *m->points, m->point_count + 1, &m->point_capacity)) {
		walk->failed = true;
		return;
	}
	m->points[m->point_count++] = (stilb_prof_point){
		.ns = prof_snapshot_ns(m, walk->lane, record->begin),
		.value = record->value,
		.label = label,
		.lane = walk->index,
		.counter = record->site->kind == STILB_PROF_KIND_COUNTER,
	};
}

static void zones_walk_flow(zones_walk *walk, const prof_record *record)
{
	prof_snapshot_memory *m = walk->m;
	uint32_t label = prof_snapshot_label(m, record->site);
	if (label == PROF_NONE || !prof_array_room(&m->marks, sizeof *m->marks, m->mark_count + 1, &m->mark_capacity)) {
		walk->failed = true;
		return;
	}
	m->marks[m->mark_count++] = (prof_flow_mark){
		.id = record->flow,
		.ns = prof_snapshot_ns(m, walk->lane, record->begin),
		.label = label,
		.lane = walk->index,
		.zone = zones_walk_into(walk, record->depth, record->begin),
		.begin = record->site->kind == STILB_PROF_KIND_FLOW_BEGIN,
	};
}

/* Walks from the zone that ends last, the outermost open one, back to the first event. */
static void zones_walk_back(zones_walk *walk)
{
	const prof_lane_copy *lane = walk->lane;
	for (uint32_t i = 0; i < lane->open_count && lane->open[i].begin < walk->m->end_ticks; i++) {
		prof_record record = {.site = lane->open[i].site, .begin = lane->open[i].begin, .end = lane->now, .depth = i};
		zones_walk_zone(walk, &record, true);
	}
	for (size_t i = lane->event_count; i-- > 0 && !walk->failed;) {
		prof_give_way(i);
		prof_record record = prof_event_unpack(&lane->events[i], lane->limit);
		if (prof_kind_is_zone(record.site->kind))
			zones_walk_zone(walk, &record, false);
		else if (record.site->kind == STILB_PROF_KIND_COUNTER || record.site->kind == STILB_PROF_KIND_INSTANT)
			zones_walk_point(walk, &record);
		else
			zones_walk_flow(walk, &record);
	}
}

/* The place of a node in the order of begins: see the head of this file. */
static uint32_t zones_place(const prof_zone_node *nodes, uint32_t first, uint32_t node)
{
	return node - first - (nodes[node].size - 1) + nodes[node].level;
}

static void zones_order(const zones_walk *walk, uint32_t end, stilb_prof_zone *zones)
{
	prof_zone_node *nodes = walk->m->nodes;
	for (uint32_t i = walk->first; i < end; i++) {
		prof_give_way(i);
		if (nodes[i].parent != PROF_NONE)
			nodes[nodes[i].parent].size += nodes[i].size;
	}
	for (uint32_t i = walk->first; i < end; i++) {
		prof_give_way(i);
		const prof_zone_node *node = &nodes[i];
		assert(zones_place(nodes, walk->first, i) < end - walk->first && "a place for each zone");
		zones[zones_place(nodes, walk->first, i)] = (stilb_prof_zone){
			.begin_ns = node->begin,
			.end_ns = node->end,
			.label = node->label,
			.parent = node->parent == PROF_NONE ? STILB_PROF_NONE : zones_place(nodes, walk->first, node->parent),
			.size = node->size,
			.level = node->level,
			.open = node->open,
		};
	}
}

/* ---- times, frames ----------------------------------------------------------------------------------------------- */

/* Cuts each zone to lie between its previous sibling's end and its parent's end, and computes self times and the frames
 * in which zones began. */
static void zones_settle(const prof_snapshot_memory *m, stilb_prof_zone *zones, uint32_t count)
{
	uint64_t cursor[STILB_PROF_DEPTH_MAX + 1] = {0}; /* by level: where the next zone may begin */
	uint32_t frame = 0;
	for (uint32_t i = 0; i < count; i++) {
		prof_give_way(i);
		stilb_prof_zone *zone = &zones[i], *parent = zone->level > 0 ? &zones[zone->parent] : NULL;
		assert(!parent || (parent < zone && zone->level == parent->level + 1));
		uint64_t high = parent ? parent->end_ns : UINT64_MAX;
		zone->begin_ns = prof_clamp(zone->begin_ns, cursor[zone->level], high);
		zone->end_ns = prof_clamp(zone->end_ns, zone->begin_ns, high);
		cursor[zone->level] = zone->end_ns;
		cursor[zone->level + 1] = zone->begin_ns;
		zone->self_ns = zone->end_ns - zone->begin_ns;
		assert(!parent || parent->self_ns >= zone->self_ns);
		if (parent)
			parent->self_ns -= zone->self_ns;
		while (frame < m->frame_count && m->frames[frame].end_ns <= zone->begin_ns)
			frame++;
		bool inside = frame < m->frame_count && zone->begin_ns >= m->frames[frame].begin_ns;
		zone->frame = inside ? frame : STILB_PROF_NONE;
	}
}

/* ---- flows ------------------------------------------------------------------------------------------------------- */

/* The zone in which a flow ends is a job: it and its subtree are charged to the frame that submitted the job. Marks
 * ascend, so a job inside another is charged later and keeps its own frame. The time of the mark is moved before the
 * end of its zone, since viewers take a mark at the end as outside. */
static void zones_charge(const prof_snapshot_memory *m, stilb_prof_zone *zones, prof_flow_mark *mark)
{
	if (mark->zone == PROF_NONE)
		return;
	stilb_prof_zone *zone = &zones[mark->zone];
	mark->ns = prof_clamp(mark->ns, zone->begin_ns, zone->end_ns - (zone->end_ns > zone->begin_ns));
	if (mark->begin)
		return;
	uint32_t frame = prof_snapshot_flow_frame(m, mark->id);
	assert(zone->size > 0);
	for (uint32_t i = 0; i < zone->size; i++)
		zone[i].frame = frame;
}

static void zones_charge_all(const prof_snapshot_memory *m, const prof_zone_node *nodes, uint32_t first,
                             stilb_prof_zone *zones, size_t first_mark)
{
	for (size_t i = first_mark; i < m->mark_count; i++) {
		prof_flow_mark *mark = &m->marks[i];
		if (mark->zone != PROF_NONE)
			mark->zone = zones_place(nodes, first, mark->zone);
		zones_charge(m, zones, mark);
		if (i > first_mark && mark->ns < mark[-1].ns)
			mark->ns = mark[-1].ns; /* a mark that was moved may have passed the next one */
	}
}

#define ZONES_SWAP_MAX 64
static_assert(sizeof(stilb_prof_point) <= ZONES_SWAP_MAX && sizeof(prof_flow_mark) <= ZONES_SWAP_MAX,
              "zones_reverse swaps them");

/* Reverses an array: points and marks were met backwards. */
static void zones_reverse(void *items, size_t size, size_t count)
{
	char swap[ZONES_SWAP_MAX];
	for (char *low = items, *high = low + size * count; count > 1 && low < (high -= size); low += size) {
		memcpy(swap, low, size);
		memcpy(low, high, size);
		memcpy(high, swap, size);
	}
}

bool prof_snapshot_zones(prof_snapshot_memory *m, uint32_t index)
{
	assert(index < m->copy.lane_count);
	const prof_lane_copy *copy = &m->copy.lanes[index];
	stilb_prof_lane *lane = &m->lanes[index];
	size_t first_point = m->point_count, first_mark = m->mark_count;
	uint32_t end = (uint32_t)(copy->event_count + copy->open_count);
	zones_walk walk = {.m = m, .lane = copy, .index = index, .first = end};
	zones_walk_back(&walk);
	if (walk.failed)
		return false;
	stilb_prof_zone *zones = m->zones + m->zone_count;
	lane->zone_count = end - walk.first;
	m->zone_count += lane->zone_count;
	assert(m->zone_count <= m->zone_capacity && "there was room for all of them");
	if (m->point_count > first_point)
		zones_reverse(m->points + first_point, sizeof *m->points, m->point_count - first_point);
	if (m->mark_count > first_mark)
		zones_reverse(m->marks + first_mark, sizeof *m->marks, m->mark_count - first_mark);
	zones_order(&walk, end, zones);
	zones_settle(m, zones, lane->zone_count);
	zones_charge_all(m, m->nodes, walk.first, zones, first_mark);
	return true;
}

/* ---- time off the CPU -------------------------------------------------------------------------------------------- */

/* How long, in ns, the thread was off the CPU before the time ns. The search begins with switches[at]; those before it
 * end at or before ns. */
static uint64_t zones_off_before(const stilb_prof_switch *switches, const uint64_t *off_before, uint32_t count,
                                 uint32_t at, uint64_t ns)
{
	assert(at <= count && (at == 0 || switches[at - 1].in_ns <= ns) && "not behind ns");
	uint32_t low = at, high = count; /* finds the first switch that ends after ns */
	while (low < high) {
		uint32_t middle = low + (high - low) / 2;
		if (switches[middle].in_ns > ns)
			high = middle;
		else
			low = middle + 1;
	}
	if (low == count)
		return count > 0 ? off_before[count - 1] + (switches[count - 1].in_ns - switches[count - 1].out_ns) : 0;
	return off_before[low] + (ns > switches[low].out_ns ? ns - switches[low].out_ns : 0);
}

void prof_snapshot_off_cpu(prof_snapshot_memory *m, uint32_t index)
{
	assert(index < m->copy.lane_count && m->lanes[index].switch_count <= m->off_capacity);
	const stilb_prof_lane *lane = &m->lanes[index];
	const stilb_prof_switch *switches = lane->switches;
	const uint64_t *off_before = m->off_before;
	stilb_prof_zone *zones = m->zones + (lane->zones - m->zones); /* lane->zones, writable */
	uint32_t next = 0; /* the first switch that ends after the begin of the zone; begins ascend */
	for (uint32_t i = 0; i < lane->zone_count; i++) {
		stilb_prof_zone *zone = &zones[i];
		prof_give_way(i);
		while (next < lane->switch_count && switches[next].in_ns <= zone->begin_ns)
			next++;
		if (next == lane->switch_count || switches[next].out_ns >= zone->end_ns)
			continue; /* it ran all the time */
		zone->off_cpu_ns = zones_off_before(switches, off_before, lane->switch_count, next, zone->end_ns) -
		                   zones_off_before(switches, off_before, lane->switch_count, next, zone->begin_ns);
	}
}
