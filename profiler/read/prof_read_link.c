/*
 * Makes the snapshot from the events: sorts and nests the zones of each lane, joins the ends of flows, finds the frames
 * of zones and the context switches of threads. All passes are linear except for sorting what is not in order.
 *
 * Nesting is decided in tenths of nanoseconds, because zones that touch in whole nanoseconds differ there. Other
 * programs round begins and durations separately: if a zone begins at most a nanosecond before the end of the zone
 * before it and ends after it, it follows that zone.
 */
#include "profiler/read/prof_read_internal.h"

#include <assert.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PROF_OFF_CPU ": off the CPU"
#define PROF_ROUNDING 10                     /* tenths of a nanosecond */
#define PROF_UNCHARGED (STILB_PROF_NONE - 1) /* in charges: no flow ends in the zone, so its own time decides */

/* ---- order ------------------------------------------------------------------------------------------------------- */

/* Removes PROF_READ_ZERO from all times; if the earliest would be negative, moves all so that it is 0. */
static void prof_link_shift(prof_read *read)
{
	uint64_t zero = read->first_ns < PROF_READ_ZERO ? read->first_ns : PROF_READ_ZERO;
	for (size_t l = 0; l < read->lane_count; l++)
		for (size_t i = 0; i < read->lanes[l].zone_count; i++) {
			read->lanes[l].zones[i].begin_ns -= zero;
			read->lanes[l].zones[i].end_ns -= zero;
		}
	for (size_t i = 0; i < read->point_count; i++)
		read->points[i].ns -= zero;
	for (size_t i = 0; i < read->end_count; i++)
		read->ends[i].ns -= zero;
	for (size_t i = 0; i < read->mark_count; i++)
		read->marks[i].ns -= zero;
	read->first_ns = read->first_ns == UINT64_MAX ? 0 : read->first_ns - zero;
	read->last_ns = read->last_ns == 0 ? 0 : read->last_ns - zero;
}

/* Ends zones without an E event at ns, the last time in the file, plus a tenth, so that zones that begin at that time
 * are inside. */
static void prof_lane_end_open(prof_read_lane *lane, uint64_t ns)
{
	while (lane->open != STILB_PROF_NONE) {
		assert(lane->open < lane->zone_count && ns >= lane->zones[lane->open].begin_ns);
		stilb_prof_zone *zone = &lane->zones[lane->open];
		lane->open = zone->parent;
		zone->parent = STILB_PROF_NONE;
		zone->end_ns = ns;
		zone->off_cpu_ns = zone->self_ns + 10 * (ns - zone->begin_ns) + 1;
	}
}

/* Negative if a comes first: the one that begins earlier or, if both begin together, the longer one, which is the
 * parent. self_ns is the begin here and off_cpu_ns the end (prof_read_lane), modulo 2^64; they differ by < 2^63. */
static int prof_zone_compare(const stilb_prof_zone *a, const stilb_prof_zone *b)
{
	if (a->self_ns != b->self_ns)
		return (int64_t)(a->self_ns - b->self_ns) < 0 ? -1 : 1;
	if (a->off_cpu_ns != b->off_cpu_ns)
		return (int64_t)(a->off_cpu_ns - b->off_cpu_ns) > 0 ? -1 : 1;
	return 0;
}

static int prof_zone_compare_stable(const void *left, const void *right)
{
	const stilb_prof_zone *a = left, *b = right;
	int order = prof_zone_compare(a, b);
	return order != 0 ? order : (a->size > b->size) - (a->size < b->size);
}

/* Sorts the zones unless they are in order already. A zone without length that comes before one with the same begin
 * counts as in order. */
static void prof_lane_sort(prof_read_lane *lane)
{
	size_t ordered = 1;
	for (; ordered < lane->zone_count; ordered++) {
		const stilb_prof_zone *zone = &lane->zones[ordered];
		if (prof_zone_compare(zone - 1, zone) > 0 &&
		    (zone[-1].self_ns != zone->self_ns || zone[-1].self_ns != zone[-1].off_cpu_ns))
			break;
	}
	if (ordered >= lane->zone_count)
		return;
	for (size_t i = 0; i < lane->zone_count; i++)
		lane->zones[i].size = (uint32_t)i;
	qsort(lane->zones, lane->zone_count, sizeof *lane->zones, prof_zone_compare_stable);
}

/* ---- nesting ----------------------------------------------------------------------------------------------------- */

typedef struct prof_nest {
	stilb_prof_zone *zones;
	uint32_t top;       /* the innermost zone that has not ended, or STILB_PROF_NONE */
	uint64_t cursor_ns; /* the end of the zone that ended last */
} prof_nest;

/* Ends the innermost zone; next is the index of the zone after its subtree. Until now its self_ns holds the sum of its
 * children's durations. */
static void prof_nest_end(prof_nest *nest, uint32_t next)
{
	assert(nest->top < next && "not ended twice");
	stilb_prof_zone *zone = &nest->zones[nest->top];
	assert(zone->self_ns <= zone->end_ns - zone->begin_ns && "children lie inside");
	zone->size = next - nest->top;
	zone->self_ns = zone->end_ns - zone->begin_ns - zone->self_ns;
	nest->cursor_ns = zone->end_ns > nest->cursor_ns ? zone->end_ns : nest->cursor_ns;
	nest->top = zone->parent;
}

/* True if the zone begins after `top` has ended, or so shortly before that end that it is taken for a rounding error:
 * see the head of this file. */
static bool prof_nest_is_over(const stilb_prof_zone *top, const stilb_prof_zone *zone)
{
	int64_t inside = (int64_t)(top->off_cpu_ns - zone->self_ns); /* tenths from the begin of zone to the end of top */
	return inside <= 0 || (inside <= PROF_ROUNDING && (int64_t)(zone->off_cpu_ns - top->off_cpu_ns) > 0);
}

/* Begins the zone, cut to its parent and to the end of its previous sibling. */
static void prof_nest_begin(prof_nest *nest, uint32_t index)
{
	assert(nest->top == STILB_PROF_NONE || nest->top < index);
	stilb_prof_zone *zone = &nest->zones[index];
	zone->parent = nest->top;
	if (zone->begin_ns < nest->cursor_ns)
		zone->begin_ns = nest->cursor_ns;
	if (nest->top != STILB_PROF_NONE) {
		stilb_prof_zone *parent = &nest->zones[nest->top];
		if ((int64_t)(zone->off_cpu_ns - parent->off_cpu_ns) > 0)
			zone->off_cpu_ns = parent->off_cpu_ns;
		if (zone->begin_ns > parent->end_ns)
			zone->begin_ns = parent->end_ns;
		if (zone->end_ns > parent->end_ns)
			zone->end_ns = parent->end_ns;
		zone->level = parent->level < UINT16_MAX ? parent->level + 1 : UINT16_MAX;
	}
	if (zone->end_ns < zone->begin_ns)
		zone->end_ns = zone->begin_ns;
	if (nest->top != STILB_PROF_NONE)
		nest->zones[nest->top].self_ns += zone->end_ns - zone->begin_ns;
	zone->self_ns = 0;
	nest->top = index;
}

/* True if the zone ends before a flow that ends at ns; a zone without length at ns does not. */
static bool prof_zone_is_before(const stilb_prof_zone *zone, uint64_t ns)
{
	return zone->end_ns <= ns && zone->begin_ns < ns;
}

/* Finds the parents of the zones of a lane. ends are the flows that end on the lane, ascending by time; for each, the
 * index of its frame is stored in charges[zone], where zone is the one in which the flow ends. */
static void prof_lane_nest(prof_read_lane *lane, const stilb_prof_flow *const *ends, size_t end_count,
                           uint32_t *charges)
{
	prof_nest nest = {.zones = lane->zones, .top = STILB_PROF_NONE};
	uint32_t count = (uint32_t)lane->zone_count;
	size_t end = 0;
	for (uint32_t i = 0; i <= count; i++) {
		for (; end < end_count && (i == count || ends[end]->to_ns < lane->zones[i].begin_ns); end++) {
			while (nest.top != STILB_PROF_NONE && prof_zone_is_before(&lane->zones[nest.top], ends[end]->to_ns))
				prof_nest_end(&nest, i);
			if (nest.top != STILB_PROF_NONE)
				charges[nest.top] = ends[end]->frame;
		}
		while (nest.top != STILB_PROF_NONE &&
		       (i == count || prof_nest_is_over(&lane->zones[nest.top], &lane->zones[i])))
			prof_nest_end(&nest, i);
		if (i < count)
			prof_nest_begin(&nest, i);
	}
	assert(nest.top == STILB_PROF_NONE && end == end_count);
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

static int prof_mark_compare(const void *left, const void *right)
{
	const prof_read_mark *a = left, *b = right;
	return a->ns != b->ns ? (a->ns > b->ns) - (a->ns < b->ns) : (a->number > b->number) - (a->number < b->number);
}

/* Makes the frames from the outermost zones of the thread "frames", numbered by the marks at their begins. */
static bool prof_link_frames(prof_read *read, const prof_read_lane *lane)
{
	assert(!read->out_frames && read->out_frame_count == 0 && "one thread has the frames");
	size_t mark = 0;
	uint64_t number = 0;
	if (read->mark_count > 0)
		qsort(read->marks, read->mark_count, sizeof *read->marks, prof_mark_compare);
	read->out_frames = malloc((lane->zone_count + 1) * sizeof *read->out_frames);
	if (!read->out_frames)
		return false;
	for (uint32_t i = 0; i < lane->zone_count; i += lane->zones[i].size) {
		const stilb_prof_zone *zone = &lane->zones[i];
		while (mark < read->mark_count && read->marks[mark].ns < zone->begin_ns)
			mark++;
		if (mark < read->mark_count && read->marks[mark].ns == zone->begin_ns && read->marks[mark].number >= number)
			number = read->marks[mark].number;
		read->out_frames[read->out_frame_count++] = (stilb_prof_frame){number++, zone->begin_ns, zone->end_ns};
	}
	return true;
}

/* The index of the frame that contains the time ns, or STILB_PROF_NONE. */
static uint32_t prof_frame_at(const prof_read *read, uint64_t ns)
{
	size_t low = 0, high = read->out_frame_count;
	while (low < high) { /* finds the first that ends after ns */
		size_t middle = low + (high - low) / 2;
		if (read->out_frames[middle].end_ns > ns)
			high = middle;
		else
			low = middle + 1;
	}
	return low < read->out_frame_count && read->out_frames[low].begin_ns <= ns ? (uint32_t)low : STILB_PROF_NONE;
}

static uint32_t prof_frame_of_number(const prof_read *read, uint64_t number)
{
	size_t low = 0, high = read->out_frame_count;
	while (low < high) {
		size_t middle = low + (high - low) / 2;
		if (read->out_frames[middle].number >= number)
			high = middle;
		else
			low = middle + 1;
	}
	return low < read->out_frame_count && read->out_frames[low].number == number ? (uint32_t)low : STILB_PROF_NONE;
}

/* Charges zones in a job to the frame of the job, others to the frame in which they began. charges may be NULL: no
 * jobs. */
static void prof_lane_charge(const prof_read *read, prof_read_lane *lane, uint32_t *charges)
{
	size_t at = 0;
	for (uint32_t i = 0; i < lane->zone_count; i++) {
		stilb_prof_zone *zone = &lane->zones[i];
		while (at < read->out_frame_count && read->out_frames[at].end_ns <= zone->begin_ns)
			at++;
		bool whole = at < read->out_frame_count && read->out_frames[at].begin_ns <= zone->begin_ns;
		zone->frame = whole ? (uint32_t)at : STILB_PROF_NONE;
		if (!charges)
			continue;
		if (charges[i] == PROF_UNCHARGED && zone->parent != STILB_PROF_NONE)
			charges[i] = charges[zone->parent];
		if (charges[i] != PROF_UNCHARGED)
			zone->frame = charges[i];
	}
}

/* ---- flows ------------------------------------------------------------------------------------------------------- */

static int prof_end_rank(const prof_read_end *end)
{
	return end->phase == 's' ? 0 : end->phase == 't' ? 1 : 2;
}

/* Orders the ends of flows by flow (id and name), then by time. */
static int prof_end_compare(const void *left, const void *right)
{
	const prof_read_end *a = left, *b = right;
	if (a->id != b->id)
		return a->id < b->id ? -1 : 1;
	if (a->label != b->label)
		return a->label < b->label ? -1 : 1;
	if (a->ns != b->ns)
		return a->ns < b->ns ? -1 : 1;
	return prof_end_rank(a) - prof_end_rank(b);
}

/* Adds a flow; from or to is NULL if it is not in the file. */
static void prof_link_flow(prof_read *read, const prof_read_end *from, const prof_read_end *to)
{
	assert((from || to) && read->out_flow_count < 2 * read->end_count);
	const prof_read_end *some = from ? from : to;
	stilb_prof_flow flow = {
		.id = some->id,
		.from_ns = some->ns,
		.to_ns = to ? to->ns : some->ns,
		.from_lane = from ? from->lane : STILB_PROF_NONE,
		.to_lane = to ? to->lane : STILB_PROF_NONE,
		.label = some->label,
		.frame = from ? prof_frame_at(read, from->ns) : STILB_PROF_NONE,
	};
	if (to && to->frame != UINT64_MAX)
		flow.frame = prof_frame_of_number(read, to->frame);
	read->out_flows[read->out_flow_count++] = flow;
}

static int prof_flow_compare(const void *left, const void *right)
{
	const stilb_prof_flow *a = left, *b = right;
	if (a->to_ns != b->to_ns)
		return a->to_ns < b->to_ns ? -1 : 1;
	return (a->id > b->id) - (a->id < b->id);
}

/* Joins the ends of flows: an s begins a flow, each f after it ends one that begins there, and a t does both. */
static bool prof_link_flows(prof_read *read)
{
	const prof_read_end *from = NULL; /* the last s or t of this flow */
	bool used = false;                /* an f or a t has followed it */
	read->out_flows = malloc((2 * read->end_count + 1) * sizeof *read->out_flows);
	if (!read->out_flows)
		return false;
	if (read->end_count > 0)
		qsort(read->ends, read->end_count, sizeof *read->ends, prof_end_compare);
	for (size_t i = 0; i < read->end_count; i++) {
		const prof_read_end *end = &read->ends[i];
		if (from && (from->id != end->id || from->label != end->label || end->phase == 's')) {
			if (!used)
				prof_link_flow(read, from, NULL);
			from = NULL;
		}
		if (end->phase != 's')
			prof_link_flow(read, from, end);
		used = end->phase == 'f';
		if (end->phase != 'f')
			from = end;
	}
	if (from && !used)
		prof_link_flow(read, from, NULL);
	if (read->out_flow_count > 0)
		qsort(read->out_flows, read->out_flow_count, sizeof *read->out_flows, prof_flow_compare);
	return true;
}

/* Flows by the lane in which they end, ascending by time: those of lane l are ends[start[l]] up to, but without,
 * ends[start[l + 1]]. */
typedef struct prof_arrivals {
	const stilb_prof_flow **ends;
	size_t *start;
} prof_arrivals;

/* True if the flow ends on a lane and its begin or frame is known: then its job is charged to that frame. */
static bool prof_flow_charges(const stilb_prof_flow *flow)
{
	return flow->to_lane != STILB_PROF_NONE && (flow->from_lane != STILB_PROF_NONE || flow->frame != STILB_PROF_NONE);
}

static bool prof_arrivals_make(const prof_read *read, prof_arrivals *arrivals)
{
	arrivals->ends = malloc((read->out_flow_count + 1) * sizeof *arrivals->ends);
	arrivals->start = calloc(read->lane_count + 2, sizeof *arrivals->start);
	if (!arrivals->ends || !arrivals->start)
		return false;
	/* A counting sort in one array. The first loop makes start[l + 2] the number of lane l's flows; the second makes
	 * start[l + 1] the index of its first one; the third, which fills in the flows, advances that to the index after
	 * its last one, which is where lane l + 1 begins. */
	for (size_t i = 0; i < read->out_flow_count; i++)
		if (prof_flow_charges(&read->out_flows[i]))
			arrivals->start[read->out_flows[i].to_lane + 2]++;
	for (size_t l = 0; l < read->lane_count; l++)
		arrivals->start[l + 2] += arrivals->start[l + 1];
	for (size_t i = 0; i < read->out_flow_count; i++)
		if (prof_flow_charges(&read->out_flows[i]))
			arrivals->ends[arrivals->start[read->out_flows[i].to_lane + 1]++] = &read->out_flows[i];
	assert(arrivals->start[0] == 0 && arrivals->start[read->lane_count] <= read->out_flow_count);
	return true;
}

static void prof_arrivals_free(prof_arrivals *arrivals)
{
	free(arrivals->ends);
	free(arrivals->start);
}

/* ---- context switches -------------------------------------------------------------------------------------------- */

/* prof_trace_chrome.c writes the switches of a lane as zones of an extra thread, "<lane>: off the CPU", whose tid is
 * the lane's plus one. If `off` is such a thread: the lane that its zones are the switches of; else NULL. */
static prof_read_lane *prof_lane_switched(prof_read *read, const prof_read_lane *off)
{
	size_t suffix = sizeof PROF_OFF_CPU - 1, size = off->name ? strlen(off->name) : 0;
	if (size < suffix || strcmp(off->name + size - suffix, PROF_OFF_CPU) != 0 || off->tid == 0)
		return NULL;
	prof_read_lane *lane = prof_read_lane_find(read, off->pid, off->tid - 1);
	bool same =
		lane && lane->name && strlen(lane->name) == size - suffix && strncmp(lane->name, off->name, size - suffix) == 0;
	return same ? lane : NULL;
}

static bool prof_lane_switches(const prof_read *read, prof_read_lane *lane, const prof_read_lane *off)
{
	free(lane->switches);
	lane->switch_count = 0;
	lane->switches_ns = off->switches_from;
	lane->switches = malloc((off->zone_count + 1) * sizeof *lane->switches);
	if (!lane->switches)
		return false;
	for (uint32_t i = 0; i < off->zone_count; i += off->zones[i].size) {
		const stilb_prof_zone *zone = &off->zones[i];
		bool preempted = strcmp(read->labels[zone->label].name, "preempted") == 0;
		lane->switches[lane->switch_count++] = (stilb_prof_switch){zone->begin_ns, zone->end_ns, preempted};
	}
	return true;
}

/* How long the thread was off the CPU before ns. sums[i] is the length of all switches before i. */
static uint64_t prof_off_before(const prof_read_lane *lane, const uint64_t *sums, uint64_t ns)
{
	size_t low = 0, high = lane->switch_count;
	while (low < high) { /* finds the first that begins at ns or later */
		size_t middle = low + (high - low) / 2;
		if (lane->switches[middle].out_ns >= ns)
			high = middle;
		else
			low = middle + 1;
	}
	if (low == 0)
		return 0;
	const stilb_prof_switch *last = &lane->switches[low - 1];
	assert(last->out_ns < ns && (low == lane->switch_count || lane->switches[low].out_ns >= ns));
	return sums[low - 1] + (last->in_ns < ns ? last->in_ns : ns) - last->out_ns;
}

static bool prof_lane_off_cpu(prof_read_lane *lane)
{
	uint64_t *sums = NULL, sum = 0;
	if (lane->switch_count > 0 && !(sums = malloc(lane->switch_count * sizeof *sums)))
		return false;
	for (size_t i = 0; i < lane->switch_count; i++) {
		sums[i] = sum;
		sum += lane->switches[i].in_ns - lane->switches[i].out_ns;
	}
	for (size_t i = 0; i < lane->zone_count; i++) {
		stilb_prof_zone *zone = &lane->zones[i];
		zone->off_cpu_ns =
			!sums ? 0 : prof_off_before(lane, sums, zone->end_ns) - prof_off_before(lane, sums, zone->begin_ns);
	}
	free(sums);
	return true;
}

/* ---- lanes ------------------------------------------------------------------------------------------------------- */

static bool prof_lane_is_frames(const prof_read *read, const prof_read_lane *lane)
{
	return lane->frames && read->header.clock; /* another program may call a thread "frames" */
}

static bool prof_link_lane(prof_read *read, size_t index, const prof_arrivals *arrivals)
{
	prof_read_lane *lane = &read->lanes[index];
	assert(arrivals->start[index] <= arrivals->start[index + 1]);
	size_t first = arrivals->start[index], count = arrivals->start[index + 1] - first;
	uint32_t *charges = NULL;
	if (count > 0) {
		charges = malloc((lane->zone_count + 1) * sizeof *charges);
		if (!charges)
			return false;
		for (size_t i = 0; i < lane->zone_count; i++)
			charges[i] = PROF_UNCHARGED;
	}
	prof_lane_nest(lane, arrivals->ends + first, count, charges);
	prof_lane_charge(read, lane, charges);
	free(charges);
	return true;
}

static int prof_lane_compare(const void *left, const void *right)
{
	const prof_read_lane *const *a = left, *const *b = right;
	if ((*a)->pid != (*b)->pid)
		return (*a)->pid < (*b)->pid ? -1 : 1;
	if ((*a)->sort != (*b)->sort)
		return (*a)->sort < (*b)->sort ? -1 : 1;
	return (*a > *b) - (*a < *b);
}

static const char *prof_lane_name(prof_read *read, const prof_read_lane *lane)
{
	char name[32];
	if (lane->name)
		return lane->name;
	if (lane->tid >> 63 == 0)
		snprintf(name, sizeof name, "thread %" PRIu64, lane->tid);
	else
		snprintf(name, sizeof name, "thread #%zu", (size_t)(lane - read->lanes) + 1);
	return prof_strings_add(&read->strings, name, strlen(name));
}

static bool prof_link_out_lane(prof_read *read, prof_read_lane *lane)
{
	assert(read->out_lane_count < read->lane_count && lane->index == STILB_PROF_NONE);
	stilb_prof_lane *out = &read->out_lanes[read->out_lane_count];
	lane->index = (uint32_t)read->out_lane_count++;
	*out = (stilb_prof_lane){
		.name = prof_lane_name(read, lane),
		.kind = lane->device ? STILB_PROF_LANE_DEVICE : STILB_PROF_LANE_THREAD,
		.tid = lane->kernel_tid <= UINT32_MAX ? (uint32_t)lane->kernel_tid : 0,
		.zones = lane->zones,
		.zone_count = (uint32_t)lane->zone_count,
		.switches = lane->switches,
		.switch_count = (uint32_t)lane->switch_count,
		.switches_ns = lane->switches_ns,
		.no_switches = lane->no_switches || lane->switch_count > 0 || lane->device || read->header.clock
	                       ? lane->no_switches
	                       : "the file does not tell",
	};
	return out->name;
}

/* Makes the lanes of the snapshot, in the order of their sort indices. */
static bool prof_link_out_lanes(prof_read *read)
{
	prof_read_lane **order = malloc((read->lane_count + 1) * sizeof(prof_read_lane *));
	size_t count = 0;
	bool good = order;
	read->out_lanes = malloc((read->lane_count + 1) * sizeof *read->out_lanes);
	for (size_t i = 0; good && i < read->lane_count; i++) {
		prof_read_lane *lane = &read->lanes[i];
		lane->index = STILB_PROF_NONE;
		if ((lane->used || lane->name) && !prof_lane_is_frames(read, lane) && !prof_lane_switched(read, lane))
			order[count++] = lane;
	}
	if (count > 0)
		qsort(order, count, sizeof *order, prof_lane_compare);
	good = good && read->out_lanes;
	for (size_t i = 0; good && i < count; i++)
		good = prof_link_out_lane(read, order[i]);
	free(order);
	return good;
}

/* ---- the whole --------------------------------------------------------------------------------------------------- */

static int prof_point_compare(const void *left, const void *right)
{
	const stilb_prof_point *a = left, *b = right;
	return (a->ns > b->ns) - (a->ns < b->ns);
}

static uint32_t prof_out_lane(const prof_read *read, uint32_t lane)
{
	assert(lane < read->lane_count || lane == STILB_PROF_NONE);
	return lane != STILB_PROF_NONE ? read->lanes[lane].index : STILB_PROF_NONE;
}

/* Sorts the points by time, and replaces the lanes of points and flows by their indices in the snapshot. glibc's qsort
 * is a merge sort and keeps the order of points at equal times; with another qsort only that order may change. */
static void prof_link_points(prof_read *read)
{
	if (read->point_count > 0)
		qsort(read->points, read->point_count, sizeof *read->points, prof_point_compare);
	for (size_t i = 0; i < read->point_count; i++)
		read->points[i].lane = prof_out_lane(read, read->points[i].lane);
	for (size_t i = 0; i < read->out_flow_count; i++) {
		read->out_flows[i].from_lane = prof_out_lane(read, read->out_flows[i].from_lane);
		read->out_flows[i].to_lane = prof_out_lane(read, read->out_flows[i].to_lane);
	}
}

static bool prof_link_zones(prof_read *read)
{
	uint64_t end_ns = read->header_end_ns > read->last_ns ? read->header_end_ns : read->last_ns;
	prof_arrivals arrivals = {0};
	for (size_t i = 0; i < read->lane_count; i++) {
		prof_lane_end_open(&read->lanes[i], end_ns);
		prof_lane_sort(&read->lanes[i]);
	}
	bool good = true;
	for (size_t i = 0; i < read->lane_count && !read->out_frames && good; i++)
		if (prof_lane_is_frames(read, &read->lanes[i])) {
			prof_lane_nest(&read->lanes[i], NULL, 0, NULL);
			good = prof_link_frames(read, &read->lanes[i]);
		}
	good = good && prof_link_flows(read) && prof_arrivals_make(read, &arrivals);
	for (size_t i = 0; i < read->lane_count && good; i++)
		if (!prof_lane_is_frames(read, &read->lanes[i]))
			good = prof_link_lane(read, i, &arrivals);
	for (size_t i = 0; i < read->lane_count && good; i++) {
		prof_read_lane *lane = prof_lane_switched(read, &read->lanes[i]);
		good = !lane || prof_lane_switches(read, lane, &read->lanes[i]);
	}
	for (size_t i = 0; i < read->lane_count && good; i++)
		good = prof_lane_off_cpu(&read->lanes[i]);
	prof_arrivals_free(&arrivals);
	return good;
}

bool prof_read_link(prof_read *read, stilb_prof_snapshot *snapshot)
{
	bool own = read->header.clock;
	prof_link_shift(read);
	if (!prof_link_zones(read) || !prof_link_out_lanes(read))
		return false;
	prof_link_points(read);
	*snapshot = read->header;
	snapshot->clock = own ? read->header.clock : "";
	snapshot->labels = read->labels;
	snapshot->label_count = (uint32_t)read->label_count;
	snapshot->lanes = read->out_lanes;
	snapshot->lane_count = (uint32_t)read->out_lane_count;
	snapshot->points = read->points;
	snapshot->point_count = (uint32_t)read->point_count;
	snapshot->flows = read->out_flows;
	snapshot->flow_count = (uint32_t)read->out_flow_count;
	snapshot->frames = read->out_frames;
	snapshot->frame_count = (uint32_t)read->out_frame_count;
	snapshot->begin_ns = own ? read->header_begin_ns : read->first_ns;
	snapshot->end_ns = own ? read->header_end_ns : read->last_ns;
	snapshot->memory = read;
	PROF_CHECK(prof_snapshot_is_sound(snapshot));
	return true;
}
