/*
 * Snapshots: a raw copy of the rings (prof_ring.c) becomes zones, lane by lane (prof_snapshot_zones.c); then the ends
 * of flows are joined. The memory belongs to the snapshot and is reused by the next take, so that one snapshot a frame
 * soon allocates nothing. Per event: 16 bytes for the copy, 56 for the zone, and 40 of scratch for the longest lane.
 */
#include "profiler/prof_array.h"
#include "profiler/prof_snapshot_internal.h"

#include <assert.h>
#include <errno.h>
#include <string.h>

#define PROF_SWITCHES_MORE 2    /* besides those of the kernel: before the thread began, and after it ended */
#define PROF_SWITCHES_UNUSED 64 /* a kernel's ring that lacks so many entries counts as full, see below */

/* Makes room for count items, and one more so that the array is never NULL, in the array m->items. False: no memory. */
#define ROOM(m, items, count, capacity) prof_array_room(&(m)->items, sizeof *(m)->items, (count) + 1, &(m)->capacity)

/* ---- labels ------------------------------------------------------------------------------------------------------ */

static struct prof_site_slot *snapshot_site_find(const prof_snapshot_memory *m, const stilb_prof_site *site)
{
	assert(m->site_capacity > m->label_count && "a slot is free, or the search would not end");
	size_t mask = m->site_capacity - 1;
	size_t at =
		(size_t)((uintptr_t)site / sizeof *site * UINT64_C(0x9e3779b97f4a7c15) >> 32) & mask; /* Fibonacci hashing */
	while (m->sites[at].site && m->sites[at].site != site)
		at = (at + 1) & mask;
	return &m->sites[at];
}

static bool prof_sites_grow(prof_snapshot_memory *m)
{
	size_t capacity = m->site_capacity > 0 ? 2 * m->site_capacity : 256;
	struct prof_site_slot *old = m->sites, *sites = calloc(capacity, sizeof *sites);
	size_t old_capacity = m->site_capacity;
	if (!sites)
		return false;
	m->sites = sites;
	m->site_capacity = capacity;
	for (size_t i = 0; i < old_capacity; i++)
		if (old[i].site)
			*snapshot_site_find(m, old[i].site) = old[i];
	free(old);
	return true;
}

static uint32_t prof_snapshot_label_add(prof_snapshot_memory *m, const stilb_prof_site *site)
{
	assert(m->label_count < PROF_NONE);
	if (2 * (m->label_count + 1) > m->site_capacity && !prof_sites_grow(m))
		return PROF_NONE;
	if (!ROOM(m, labels, m->label_count + 1, label_capacity))
		return PROF_NONE;
	uint32_t label = (uint32_t)m->label_count++;
	*snapshot_site_find(m, site) = (struct prof_site_slot){site, label};
	m->labels[label] = (stilb_prof_label){
		.name = site->name,
		.function = site->function,
		.file = site->file,
		.line = site->line,
		.color = site->color,
	};
	return label;
}

uint32_t prof_snapshot_label(prof_snapshot_memory *m, const stilb_prof_site *site)
{
	assert(site);
	if (m->site_capacity > 0) {
		const struct prof_site_slot *slot = snapshot_site_find(m, site);
		if (slot->site)
			return slot->label;
	}
	return prof_snapshot_label_add(m, site);
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

static bool prof_snapshot_frames(prof_snapshot_memory *m)
{
	const prof_copy *copy = &m->copy;
	assert(copy->window_first + copy->window_count <= copy->frame_count && "a frame ends where the next begins");
	m->frame_count = copy->window_count;
	if (!ROOM(m, frames, m->frame_count, frame_capacity))
		return false;
	for (uint32_t i = 0; i < m->frame_count; i++) {
		uint32_t at = copy->window_first + i;
		m->frames[i].number = copy->first_frame + at;
		m->frames[i].begin_ns = prof_timeline_ns(&m->timeline, copy->frames[at].ticks);
		m->frames[i].end_ns = prof_timeline_ns(&m->timeline, copy->frames[at + 1].ticks);
	}
	return true;
}

uint32_t prof_snapshot_flow_frame(const prof_snapshot_memory *m, uint64_t id)
{
	if (m->frame_count == 0)
		return STILB_PROF_NONE;
	uint64_t newest = m->copy.first_frame + m->copy.frame_count - 1;
	uint64_t at = prof_flow_frame(id, newest) - m->frames[0].number;
	return at < m->frame_count ? (uint32_t)at : STILB_PROF_NONE;
}

/* ---- switches ---------------------------------------------------------------------------------------------------- */

static uint64_t prof_switch_ns(const prof_snapshot_memory *m, uint64_t monotonic_ns)
{
	return monotonic_ns > m->timeline.epoch_ns ? monotonic_ns - m->timeline.epoch_ns : 0;
}

static uint64_t prof_later(uint64_t a, uint64_t b)
{
	return a > b ? a : b;
}

static void prof_switch_add(prof_snapshot_memory *m, uint64_t out_ns, uint64_t in_ns, bool preempted)
{
	assert(m->switch_count < m->switch_capacity || out_ns >= in_ns);
	if (out_ns < in_ns)
		m->switches[m->switch_count++] = (stilb_prof_switch){out_ns, in_ns, preempted};
}

/* Makes a switch of each event at which the thread left a CPU and the next one at which it came back, if that is later
 * than begin_ns; both times are cut to begun_ns .. end_ns. A thread that has not come back is off the CPU until end_ns.
 * A coming back without a known leaving is dropped. */
static void prof_switches_pair(prof_snapshot_memory *m, const prof_lane_copy *copy, uint64_t begun_ns,
                               uint64_t begin_ns, uint64_t end_ns)
{
	const prof_switch_event *out = NULL;
	for (uint32_t i = 0; i <= copy->switch_count; i++) {
		const prof_switch_event *event = i < copy->switch_count ? &copy->switches[i] : NULL;
		uint64_t in_ns = event ? prof_switch_ns(m, event->ns) : end_ns;
		in_ns = in_ns < end_ns ? in_ns : end_ns;
		if (out && (!event || event->in) && in_ns > begin_ns)
			prof_switch_add(m, prof_later(prof_switch_ns(m, out->ns), begun_ns), in_ns, out->preempted);
		out = event && !event->in ? event : NULL;
	}
}

/* The end of the last outermost zone of the lane that began before ns, where ns is the time at which the thread took
 * its ring; 0: none. Such zones are those of an earlier owner of the ring, whose switches are not known. */
static uint64_t prof_lane_end_before(const stilb_prof_lane *lane, uint64_t ns)
{
	uint64_t end_ns = 0;
	for (uint32_t i = 0; i < lane->zone_count && lane->zones[i].begin_ns < ns; i += lane->zones[i].size)
		end_ns = lane->zones[i].end_ns;
	return end_ns;
}

/* True if switches after begin_ns may be missing: the kernel's ring was full, so older ones may have been overwritten.
 * It counts as full a few entries early, since a reader drops those that may be being written. */
static bool prof_switches_are_cut(const prof_lane_copy *copy, uint64_t begin_ns)
{
	return copy->switch_count >= PROF_SWITCHES_MAX - PROF_SWITCHES_UNUSED && copy->switches[0].ns > begin_ns;
}

/* Fills the lane's switches. A thread does not run before it begins nor after it has ended. */
static void prof_switches_find(prof_snapshot_memory *m, stilb_prof_lane *lane, const prof_lane_copy *copy,
                               uint64_t begin_ns, uint64_t end_ns)
{
	uint64_t begun_ns = prof_switch_ns(m, copy->begun_ns);
	uint64_t ended_ns = copy->ended_ns != 0 ? prof_switch_ns(m, copy->ended_ns) : end_ns;
	uint64_t last_ns = ended_ns < end_ns ? ended_ns : end_ns;
	lane->switches_ns = begin_ns;
	if (prof_switches_are_cut(copy, begin_ns + m->timeline.epoch_ns)) {
		lane->switches_ns = prof_switch_ns(m, copy->switches[0].ns);
	} else if (begun_ns > begin_ns) {
		lane->switches_ns = prof_later(prof_lane_end_before(lane, begun_ns), begin_ns);
		prof_switch_add(m, lane->switches_ns, begun_ns < end_ns ? begun_ns : end_ns, false);
	}
	prof_switches_pair(m, copy, begun_ns, begin_ns, last_ns);
	prof_switch_add(m, prof_later(last_ns, begin_ns), end_ns, false);
}

/* Makes the switches of all lanes and the zones' off_cpu_ns. Called after the zones are made, since begin_ns of a
 * window without a begin is that of its first zone. */
static bool prof_snapshot_switches(prof_snapshot_memory *m, uint64_t begin_ns, uint64_t end_ns)
{
	for (uint32_t l = 0; l < m->copy.lane_count; l++) {
		const prof_lane_copy *copy = &m->copy.lanes[l];
		stilb_prof_lane *lane = &m->lanes[l];
		size_t first = m->switch_count;
		lane->switches = m->switches + first;
		if (copy->device || copy->no_switches)
			continue;
		if (!ROOM(m, off_before, copy->switch_count + PROF_SWITCHES_MORE, off_capacity))
			return false;
		prof_switches_find(m, lane, copy, begin_ns, end_ns);
		lane->switch_count = (uint32_t)(m->switch_count - first);
		uint64_t off_ns = 0;
		for (uint32_t i = 0; i < lane->switch_count; i++) {
			m->off_before[i] = off_ns;
			off_ns += lane->switches[i].in_ns - lane->switches[i].out_ns;
		}
		if (lane->switch_count > 0)
			prof_snapshot_off_cpu(m, l);
	}
	return true;
}

/* ---- runs: merges lists that ascend lane by lane into one that does ---------------------------------------------- */

typedef struct prof_runs {
	char *items;
	size_t size, key; /* bytes of an item; offset of its key, a uint64_t */
} prof_runs;

static uint64_t prof_runs_key(const prof_runs *runs, const char *item)
{
	uint64_t key;
	memcpy(&key, item + runs->key, sizeof key);
	return key;
}

/* Merges the neighbouring runs [a, b) and [b, end) into one; to is scratch. Items with equal keys keep their order. */
static void prof_runs_merge(const prof_runs *runs, size_t a, size_t b, size_t end, char *to)
{
	assert(a <= b && b <= end);
	size_t size = runs->size;
	const char *left = runs->items + a * size, *right = runs->items + b * size;
	const char *left_end = right, *right_end = runs->items + end * size;
	for (char *out = to; out < to + (end - a) * size; out += size) {
		bool take_left =
			left < left_end && (right == right_end || prof_runs_key(runs, left) <= prof_runs_key(runs, right));
		memcpy(out, take_left ? left : right, size);
		left += take_left ? size : 0;
		right += take_left ? 0 : size;
	}
	memcpy(runs->items + a * size, to, (end - a) * size);
}

/* Merges `count` runs into one. starts holds the first index of each run and then the end of the last one; scratch has
 * room for all items. */
static void prof_runs_sort(const prof_runs *runs, size_t *starts, size_t count, char *scratch)
{
	assert(runs->key + sizeof(uint64_t) <= runs->size);
	for (; count > 1; count = (count + 1) / 2) {
		for (size_t i = 0; i + 1 < count; i += 2)
			prof_runs_merge(runs, starts[i], starts[i + 1], starts[i + 2], scratch);
		for (size_t i = 0; i <= count; i += 2)
			starts[i / 2] = starts[i];
		starts[(count + 1) / 2] = starts[count];
	}
}

/* ---- flows ------------------------------------------------------------------------------------------------------- */

static uint32_t *prof_flow_slot(const prof_snapshot_memory *m, size_t slots, uint64_t id)
{
	assert((slots & (slots - 1)) == 0 && slots > m->mark_count);
	size_t at = (size_t)(id * UINT64_C(0x9e3779b97f4a7c15) >> 32) & (slots - 1);
	while (m->flow_slots[at] != PROF_NONE && m->marks[m->flow_slots[at]].id != id)
		at = (at + 1) & (slots - 1);
	return &m->flow_slots[at];
}

static bool prof_flows_make_room(prof_snapshot_memory *m, size_t slots)
{
	return ROOM(m, flow_slots, slots, slot_capacity) && ROOM(m, flows, m->mark_count, flow_capacity) &&
	       ROOM(m, runs, 2 * (size_t)m->copy.lane_count + 2, run_capacity) &&
	       ROOM(m, merged, m->mark_count * sizeof *m->flows, merged_capacity);
}

static void prof_flow_add(prof_snapshot_memory *m, const prof_flow_mark *from, const prof_flow_mark *to)
{
	assert((from || to) && m->flow_count < m->flow_capacity);
	const prof_flow_mark *known = from ? from : to;
	m->flows[m->flow_count++] = (stilb_prof_flow){
		.id = known->id,
		.from_ns = from ? from->ns : to->ns,
		.to_ns = to ? to->ns : from->ns,
		.from_lane = from ? from->lane : STILB_PROF_NONE,
		.to_lane = to ? to->lane : STILB_PROF_NONE,
		.label = known->label,
		.frame = prof_snapshot_flow_frame(m, known->id),
	};
}

/* Makes one flow for each end mark, with its begin if that is in the snapshot, then one for each begin mark without an
 * end, both in the order of the marks, which is lane by lane. So the flows ascend within runs, two for each lane with
 * marks; stores where each run begins in m->runs and returns how many there are. If the clocks of two CPUs differ, a
 * begin may come after its end: then it is moved to the end, since arrows never go back in time. */
static size_t prof_flows_join(prof_snapshot_memory *m, size_t slots)
{
	size_t runs = 0;
	for (int ends = 1; ends >= 0; ends--) {
		for (size_t i = 0; i < m->mark_count; i++) {
			prof_flow_mark *mark = &m->marks[i];
			prof_give_way(i);
			if (i == 0 || mark->lane != mark[-1].lane)
				m->runs[runs++] = m->flow_count;
			if (mark->begin || !ends) {
				if (mark->begin && !ends && !mark->joined)
					prof_flow_add(m, mark, NULL);
				continue;
			}
			uint32_t begin = *prof_flow_slot(m, slots, mark->id);
			prof_flow_mark *from = begin != PROF_NONE ? &m->marks[begin] : NULL;
			prof_flow_add(m, from, mark);
			if (from) {
				from->joined = true;
				stilb_prof_flow *flow = &m->flows[m->flow_count - 1];
				flow->from_ns = flow->from_ns < flow->to_ns ? flow->from_ns : flow->to_ns;
			}
		}
	}
	assert(runs < m->run_capacity);
	m->runs[runs] = m->flow_count;
	return runs;
}

static bool prof_snapshot_flows(prof_snapshot_memory *m)
{
	size_t slots = 64;
	while (slots < 2 * m->mark_count)
		slots *= 2;
	if (m->mark_count == 0)
		return true;
	if (!prof_flows_make_room(m, slots))
		return false;
	memset(m->flow_slots, 0xff, slots * sizeof *m->flow_slots);
	for (uint32_t i = 0; i < m->mark_count; i++)
		if (m->marks[i].begin)
			*prof_flow_slot(m, slots, m->marks[i].id) = i;
	size_t runs = prof_flows_join(m, slots);
	prof_runs by_end = {(char *)m->flows, sizeof *m->flows, offsetof(stilb_prof_flow, to_ns)};
	prof_runs_sort(&by_end, m->runs, runs, m->merged);
	return true;
}

static bool prof_snapshot_points(prof_snapshot_memory *m)
{
	size_t runs = 0;
	if (m->point_count == 0)
		return true;
	if (!ROOM(m, runs, (size_t)m->copy.lane_count + 1, run_capacity) ||
	    !ROOM(m, merged, m->point_count * sizeof *m->points, merged_capacity))
		return false;
	for (size_t i = 0; i < m->point_count; i++)
		if (i == 0 || m->points[i].lane != m->points[i - 1].lane)
			m->runs[runs++] = i;
	assert(runs < m->run_capacity);
	m->runs[runs] = m->point_count;
	prof_runs by_time = {(char *)m->points, sizeof *m->points, offsetof(stilb_prof_point, ns)};
	prof_runs_sort(&by_time, m->runs, runs, m->merged);
	return true;
}

/* ---- the whole --------------------------------------------------------------------------------------------------- */

static void prof_snapshot_destroy(void *memory)
{
	prof_snapshot_memory *m = memory;
	assert(m->memory.destroy == prof_snapshot_destroy && "memory of a snapshot that was taken");
	prof_copy_free(&m->copy);
	free(m->labels);
	free(m->sites);
	free(m->frames);
	free(m->lanes);
	free(m->zones);
	free(m->switches);
	free(m->off_before);
	free(m->points);
	free(m->marks);
	free(m->flows);
	free(m->nodes);
	free(m->flow_slots);
	free(m->merged);
	free(m->runs);
	free(m);
}

/* The memory that an earlier take left in the snapshot, or new memory. NULL: no memory. */
static prof_snapshot_memory *prof_snapshot_memory_of(stilb_prof_snapshot *snapshot)
{
	prof_snapshot_memory *m = snapshot->memory;
	if (!m || m->memory.destroy != prof_snapshot_destroy) {
		stilb_prof_snapshot_finish(snapshot); /* one that was read from a file */
		m = calloc(1, sizeof *m);
		if (!m)
			return NULL;
		m->memory.destroy = prof_snapshot_destroy;
	}
	*snapshot = (stilb_prof_snapshot){.memory = m};
	m->zone_count = m->switch_count = m->point_count = m->mark_count = m->flow_count = 0;
	return m;
}

static bool prof_snapshot_make_room(prof_snapshot_memory *m)
{
	size_t zones = 0, longest = 0, switches = 0;
	for (uint32_t i = 0; i < m->copy.lane_count; i++) {
		size_t count = m->copy.lanes[i].event_count + m->copy.lanes[i].open_count;
		zones += count;
		longest = count > longest ? count : longest;
		switches += m->copy.lanes[i].switch_count + PROF_SWITCHES_MORE;
	}
	return longest < PROF_NONE && ROOM(m, lanes, m->copy.lane_count, lane_capacity) &&
	       ROOM(m, zones, zones, zone_capacity) && ROOM(m, nodes, longest, node_capacity) &&
	       ROOM(m, switches, switches, switch_capacity);
}

static bool prof_snapshot_lanes(prof_snapshot_memory *m)
{
	for (uint32_t i = 0; i < m->copy.lane_count; i++) {
		const prof_lane_copy *copy = &m->copy.lanes[i];
		m->lanes[i] = (stilb_prof_lane){
			.name = copy->name,
			.kind = copy->device ? STILB_PROF_LANE_DEVICE : STILB_PROF_LANE_THREAD,
			.tid = copy->tid,
			.zones = m->zones + m->zone_count,
			.no_switches = copy->no_switches,
		};
		if (!prof_snapshot_zones(m, i))
			return false;
	}
	return true;
}

/* begin_ns of a window that has no begin: the first time in the snapshot; if it holds nothing, the time at which the
 * first thread took its ring. At most end_ns. */
static uint64_t prof_snapshot_first_ns(const prof_snapshot_memory *m, uint64_t end_ns)
{
	uint64_t first_ns = end_ns;
	if (m->frame_count > 0 && m->frames[0].begin_ns < first_ns)
		first_ns = m->frames[0].begin_ns;
	if (m->point_count > 0 && m->points[0].ns < first_ns)
		first_ns = m->points[0].ns;
	for (uint32_t i = 0; i < m->copy.lane_count; i++)
		if (m->lanes[i].zone_count > 0 && m->lanes[i].zones[0].begin_ns < first_ns)
			first_ns = m->lanes[i].zones[0].begin_ns;
	for (uint32_t i = 0; first_ns == end_ns && i < m->copy.lane_count; i++)
		first_ns = prof_switch_ns(m, m->copy.lanes[i].begun_ns);
	return first_ns < end_ns ? first_ns : end_ns;
}

static void prof_snapshot_fill(stilb_prof_snapshot *s, const prof_snapshot_memory *m, uint64_t begin_ns,
                               uint64_t end_ns)
{
	*s = (stilb_prof_snapshot){
		.labels = m->labels,
		.lanes = m->lanes,
		.points = m->points,
		.flows = m->flows,
		.frames = m->frames,
		.label_count = (uint32_t)m->label_count,
		.lane_count = m->copy.lane_count,
		.point_count = (uint32_t)m->point_count,
		.flow_count = (uint32_t)m->flow_count,
		.frame_count = m->frame_count,
		.begin_ns = begin_ns,
		.end_ns = end_ns,
		.epoch_ns = m->timeline.epoch_ns,
		.clock = m->timeline.clock,
		.hz = m->timeline.hz,
		.resolution_ns = m->timeline.resolution_ns,
		.bias_ns = prof_clock_bias_ns(),
		.zone_cost_ns = prof_clock_zone_cost_ns(),
		.events_recorded = m->copy.events_recorded,
		.events_lost = m->copy.events_recorded - m->copy.events_held,
		.events_held = m->copy.events_held,
		.too_deep = m->copy.too_deep,
		.without_ring = m->copy.without_ring,
		.memory = s->memory,
	};
}

/* The end of the window. A window of frames that are not remembered any more is empty and lies at the present time. */
static uint64_t prof_snapshot_end_ns(prof_snapshot_memory *m)
{
	bool empty = m->copy.begin.ticks == UINT64_MAX, closed = m->copy.end.ticks != UINT64_MAX;
	m->now_ns = prof_timeline_ns(&m->timeline, prof_clock_now());
	m->end_ticks = empty ? 0 : m->copy.end.ticks;
	return closed ? prof_timeline_ns(&m->timeline, m->copy.end.ticks) : m->now_ns;
}

/* The begin of the window; call it after the lanes and points are made. */
static uint64_t prof_snapshot_begin_ns(prof_snapshot_memory *m, uint64_t end_ns)
{
	uint64_t begin = m->copy.begin.ticks;
	if (begin == 0)
		return prof_snapshot_first_ns(m, end_ns);
	return begin == UINT64_MAX ? end_ns : prof_timeline_ns(&m->timeline, begin);
}

/* Makes the snapshot from the copy. False: no memory. */
static bool prof_snapshot_make(stilb_prof_snapshot *snapshot, prof_snapshot_memory *m)
{
	prof_clock_timeline(&m->timeline, m->copy.frames, m->copy.frame_count);
	uint64_t end_ns = prof_snapshot_end_ns(m);
	if (!prof_snapshot_frames(m) || !prof_snapshot_make_room(m) || !prof_snapshot_lanes(m) || !prof_snapshot_points(m))
		return false;
	uint64_t begin_ns = prof_snapshot_begin_ns(m, end_ns);
	if (!prof_snapshot_switches(m, begin_ns, end_ns) || !prof_snapshot_flows(m))
		return false;
	prof_snapshot_fill(snapshot, m, begin_ns, end_ns);
	return true;
}

int stilb_prof_snapshot_take(stilb_prof_snapshot *snapshot, const stilb_prof_window *window)
{
	assert(snapshot);
	static const stilb_prof_window all = {0};
	prof_snapshot_memory *m = prof_snapshot_memory_of(snapshot);
	if (!m)
		return -ENOMEM;
	int error = prof_copy_take(&m->copy, window ? window : &all);
	if (error == 0 && !prof_snapshot_make(snapshot, m))
		error = -ENOMEM;
	if (error != 0)
		stilb_prof_snapshot_finish(snapshot);
	PROF_CHECK(prof_snapshot_is_sound(snapshot));
	return error;
}

void stilb_prof_snapshot_finish(stilb_prof_snapshot *snapshot)
{
	assert(snapshot);
	prof_memory *memory = snapshot->memory;
	if (memory)
		memory->destroy(memory);
	*snapshot = (stilb_prof_snapshot){0};
}
