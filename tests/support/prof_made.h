/* prof_made: snapshots that tests make by hand or by chance, every derived field worked out in the simplest way. */
#ifndef STILB_PROF_MADE_H
#define STILB_PROF_MADE_H

#include "profiler/prof_snapshot.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MADE_LANES 4
#define MADE_LABELS 16

typedef struct made {
	stilb_prof_snapshot snapshot;
	stilb_prof_label labels[MADE_LABELS];
	stilb_prof_lane lanes[MADE_LANES];
	stilb_prof_zone *zones[MADE_LANES];
	stilb_prof_switch *switches[MADE_LANES];
	stilb_prof_frame *frames;
	stilb_prof_point *points;
	stilb_prof_flow *flows;
	uint32_t top[MADE_LANES]; /* the zone that is open while it is made */
	char lane_names[MADE_LANES][16];
} made;

/* Returns the array, reallocated if it has no room for one more element after its first count. */
static inline void *made_more(void *array, size_t count, size_t size)
{
	if ((count & (count - 1)) != 0) /* it grows at powers of two */
		return array;
	void *more = realloc(array, (count > 0 ? 2 * count : 1) * size);
	if (!more)
		abort();
	return more;
}

static inline void made_init(made *m, uint32_t lanes)
{
	static const char *const names[MADE_LABELS] = {"frame",
	                                               "cull",
	                                               "record",
	                                               "replay",
	                                               "a \"quoted\" \\ name",
	                                               "\xc3\xa9t\xc3\xa9",
	                                               "job",
	                                               "x",
	                                               "wait",
	                                               "tab\tinside",
	                                               "replay all",
	                                               "record segment",
	                                               "memory",
	                                               "mark",
	                                               "flow",
	                                               "y"};
	*m = (made){0};
	for (int i = 0; i < MADE_LABELS; i++)
		m->labels[i] = (stilb_prof_label){.name = names[i], .function = "", .file = ""};
	for (uint32_t i = 0; i < lanes; i++) {
		snprintf(m->lane_names[i], sizeof m->lane_names[i], i > 0 ? "worker %u" : "main", i);
		m->lanes[i] = (stilb_prof_lane){.name = m->lane_names[i], .tid = 100 + i};
		m->top[i] = STILB_PROF_NONE;
	}
	m->snapshot = (stilb_prof_snapshot){.labels = m->labels,
	                                    .lanes = m->lanes,
	                                    .label_count = MADE_LABELS,
	                                    .lane_count = lanes,
	                                    .clock = "rdtsc",
	                                    .hz = 2.5e9,
	                                    .resolution_ns = 10.25,
	                                    .bias_ns = 18.5,
	                                    .zone_cost_ns = 19.125,
	                                    .epoch_ns = 1234567890123456,
	                                    .events_recorded = 1000,
	                                    .events_lost = 400,
	                                    .events_held = 600,
	                                    .too_deep = 3,
	                                    .without_ring = 2};
}

static inline void made_finish(made *m)
{
	for (int i = 0; i < MADE_LANES; i++) {
		free(m->zones[i]);
		free(m->switches[i]);
	}
	free(m->frames);
	free(m->points);
	free(m->flows);
	*m = (made){0};
}

static inline void made_push(made *m, uint32_t lane, uint32_t label, uint64_t begin_ns)
{
	stilb_prof_lane *l = &m->lanes[lane];
	m->zones[lane] = made_more(m->zones[lane], l->zone_count, sizeof *m->zones[lane]);
	l->zones = m->zones[lane];
	stilb_prof_zone *zone = &m->zones[lane][l->zone_count];
	*zone = (stilb_prof_zone){
		.begin_ns = begin_ns, .label = label, .parent = m->top[lane], .size = 1, .frame = STILB_PROF_NONE};
	if (zone->parent != STILB_PROF_NONE)
		zone->level = m->zones[lane][zone->parent].level + 1;
	m->top[lane] = l->zone_count++;
}

static inline void made_pop(made *m, uint32_t lane, uint64_t end_ns)
{
	stilb_prof_zone *zone = &m->zones[lane][m->top[lane]];
	zone->end_ns = end_ns;
	zone->size = m->lanes[lane].zone_count - m->top[lane];
	m->top[lane] = zone->parent;
}

static inline void made_frame(made *m, uint64_t number, uint64_t begin_ns, uint64_t end_ns)
{
	m->frames = made_more(m->frames, m->snapshot.frame_count, sizeof *m->frames);
	m->frames[m->snapshot.frame_count++] = (stilb_prof_frame){number, begin_ns, end_ns};
	m->snapshot.frames = m->frames;
}

static inline void made_switch(made *m, uint32_t lane, uint64_t out_ns, uint64_t in_ns, bool preempted)
{
	stilb_prof_lane *l = &m->lanes[lane];
	m->switches[lane] = made_more(m->switches[lane], l->switch_count, sizeof *m->switches[lane]);
	m->switches[lane][l->switch_count++] = (stilb_prof_switch){out_ns, in_ns, preempted};
	l->switches = m->switches[lane];
	l->switches_ns = m->switches[lane][0].out_ns;
}

static inline void made_point(made *m, stilb_prof_point point)
{
	m->points = made_more(m->points, m->snapshot.point_count, sizeof *m->points);
	m->points[m->snapshot.point_count++] = point;
	m->snapshot.points = m->points;
}

static inline void made_flow(made *m, stilb_prof_flow flow)
{
	m->flows = made_more(m->flows, m->snapshot.flow_count, sizeof *m->flows);
	m->flows[m->snapshot.flow_count++] = flow;
	m->snapshot.flows = m->flows;
}

static inline uint32_t made_frame_at(const made *m, uint64_t ns)
{
	for (uint32_t i = 0; i < m->snapshot.frame_count; i++)
		if (m->frames[i].begin_ns <= ns && ns < m->frames[i].end_ns)
			return i;
	return STILB_PROF_NONE;
}

static inline uint64_t made_overlap(uint64_t begin, uint64_t end, uint64_t other_begin, uint64_t other_end)
{
	uint64_t from = begin > other_begin ? begin : other_begin, to = end < other_end ? end : other_end;
	return to > from ? to - from : 0;
}

/* The frame of the last flow that ends in the zone itself; false: none does. */
static inline bool made_charge(const made *m, uint32_t lane, uint32_t zone, uint32_t *frame)
{
	bool found = false;
	const stilb_prof_zone *zones = m->zones[lane];
	for (uint32_t f = 0; f < m->snapshot.flow_count; f++) {
		uint64_t ns = m->flows[f].to_ns;
		uint32_t inside = STILB_PROF_NONE; /* the innermost */
		for (uint32_t i = 0; m->flows[f].to_lane == lane && i < m->lanes[lane].zone_count; i++)
			if (zones[i].begin_ns <= ns && (ns < zones[i].end_ns || zones[i].begin_ns == ns))
				inside = i;
		if (inside == zone) {
			*frame = m->flows[f].frame;
			found = true;
		}
	}
	return found;
}

/* Works out self times, off-CPU times, and frames: of the nearest zone where a flow ends, or where the zone began. */
static inline void made_derive(made *m)
{
	for (uint32_t l = 0; l < m->snapshot.lane_count; l++) {
		uint32_t count = m->lanes[l].zone_count;
		stilb_prof_zone *zones = m->zones[l];
		for (uint32_t i = 0; i < count; i++) {
			zones[i].self_ns = zones[i].end_ns - zones[i].begin_ns;
			zones[i].off_cpu_ns = 0;
			for (uint32_t s = 0; s < m->lanes[l].switch_count; s++)
				zones[i].off_cpu_ns +=
					made_overlap(zones[i].begin_ns, zones[i].end_ns, m->switches[l][s].out_ns, m->switches[l][s].in_ns);
			zones[i].frame = made_frame_at(m, zones[i].begin_ns);
			bool charged = false;
			for (uint32_t z = i; !charged && z != STILB_PROF_NONE; z = zones[z].parent)
				charged = made_charge(m, l, z, &zones[i].frame);
		}
		for (uint32_t i = 0; i < count; i++)
			if (zones[i].parent != STILB_PROF_NONE)
				zones[zones[i].parent].self_ns -= zones[i].end_ns - zones[i].begin_ns;
	}
}

/* ---- by chance --------------------------------------------------------------------------------------------------- */

typedef struct made_random {
	uint64_t state;
	bool no_empty; /* make no zones of no length */
} made_random;

/* Steele, Lea, Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014. */
static inline uint64_t made_u64(made_random *random)
{
	uint64_t z = random->state += UINT64_C(0x9e3779b97f4a7c15);
	z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
	z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
	return z ^ z >> 31;
}

static inline uint64_t made_below(made_random *random, uint64_t limit)
{
	return made_u64(random) % limit;
}

/* Zones in [begin, end), that often touch one another and their parent's ends; some of no length. */
static inline void made_tree(made *m, made_random *random, uint32_t lane, uint64_t begin, uint64_t end, uint32_t level)
{
	static const uint64_t lengths[] = {600, 250, 80, 30};
	for (uint64_t at = begin; at < end;) {
		uint64_t kind = made_below(random, 8), room = end - at, gap = kind < 4 ? 0 : made_below(random, 30);
		uint64_t from = at + (gap < room ? gap : 0), length = made_below(random, lengths[level]) + random->no_empty;
		bool to_end = from + length > end || (level > 0 && kind == 1);
		uint64_t to = kind == 2 && !random->no_empty ? from : to_end ? end : from + length;
		made_push(m, lane, (uint32_t)made_below(random, 12), from);
		if (level < 3 && to > from && made_below(random, 3) > 0)
			made_tree(m, random, lane, from, to, level + 1);
		made_pop(m, lane, to);
		at = to + (to == from);
	}
}

/* Frames of some 1,000 ns from begin on, zones, switches, points and flows on all lanes. */
static inline void made_by_chance_from(made *m, made_random random)
{
	made_init(m, 1 + (uint32_t)made_below(&random, MADE_LANES));
	uint64_t begin = made_below(&random, 3) * 1000000007, frames = made_below(&random, 6);
	uint64_t at = begin;
	for (uint64_t i = 0; i < frames; i++) {
		uint64_t end = at + 500 + made_below(&random, 1000);
		made_frame(m, 70000 + i, at, end);
		at = end;
	}
	uint64_t end = at + 300;
	m->snapshot.begin_ns = begin;
	m->snapshot.end_ns = end;
	for (uint32_t l = 0; l < m->snapshot.lane_count; l++) {
		if (l == 3) {
			m->lanes[l].kind = STILB_PROF_LANE_DEVICE;
			m->lanes[l].tid = 0;
		} else if (made_below(&random, 2) == 0) {
			m->lanes[l].no_switches = "perf_event_paranoid is 3";
		} else {
			for (uint64_t out = begin + made_below(&random, 300), in; out < end; out = in + made_below(&random, 300)) {
				in = out + 1 + made_below(&random, end - out);
				made_switch(m, l, out, in, made_below(&random, 2) == 0);
			}
		}
		if (made_below(&random, 8) > 0)
			made_tree(m, &random, l, begin + made_below(&random, 100), end, 0);
	}
	for (uint64_t ns = begin; (ns += 1 + made_below(&random, 300)) < end;)
		made_point(m, (stilb_prof_point){.ns = ns,
		                                 .value = (double)(int64_t)made_u64(&random) / 1024.0,
		                                 .label = 12,
		                                 .lane = (uint32_t)made_below(&random, m->snapshot.lane_count),
		                                 .counter = true});
	uint64_t id = 1;
	for (uint64_t to = begin; (to += 1 + made_below(&random, 200)) < end;) {
		uint64_t from = begin + made_below(&random, to - begin + 1);
		made_flow(m, (stilb_prof_flow){.id = id++,
		                               .from_ns = from,
		                               .to_ns = to,
		                               .from_lane = (uint32_t)made_below(&random, m->snapshot.lane_count),
		                               .to_lane = (uint32_t)made_below(&random, m->snapshot.lane_count),
		                               .label = 14,
		                               .frame = made_frame_at(m, from)});
	}
	made_derive(m);
}

static inline void made_by_chance(made *m, uint64_t seed)
{
	made_by_chance_from(m, (made_random){.state = seed});
}

/* ---- what must hold of every snapshot ---------------------------------------------------------------------------- */

static inline bool made_lane_holds(const stilb_prof_snapshot *s, const stilb_prof_lane *lane)
{
	uint64_t cursor = 0;
	for (uint32_t i = 0; i < lane->zone_count; i++) {
		const stilb_prof_zone *zone = &lane->zones[i];
		if (zone->begin_ns > zone->end_ns || zone->self_ns > zone->end_ns - zone->begin_ns || zone->size == 0 ||
		    zone->size > lane->zone_count - i || zone->label >= s->label_count || zone->begin_ns < cursor ||
		    zone->off_cpu_ns > zone->end_ns - zone->begin_ns ||
		    (zone->frame >= s->frame_count && zone->frame != STILB_PROF_NONE))
			return false;
		cursor = zone->begin_ns;
		if (zone->parent == STILB_PROF_NONE) {
			if (zone->level != 0)
				return false;
			continue;
		}
		const stilb_prof_zone *parent = zone->parent < i ? &lane->zones[zone->parent] : NULL;
		if (!parent || i >= zone->parent + parent->size || zone->begin_ns < parent->begin_ns ||
		    zone->end_ns > parent->end_ns || (zone->level != parent->level + 1 && parent->level != UINT16_MAX))
			return false;
	}
	for (uint32_t i = 0; i < lane->zone_count; i++) { /* siblings do not overlap */
		uint32_t next = i + lane->zones[i].size;
		if (next < lane->zone_count && lane->zones[next].begin_ns < lane->zones[i].end_ns)
			return false;
	}
	for (uint32_t i = 0; i < lane->switch_count; i++)
		if (lane->switches[i].in_ns < lane->switches[i].out_ns ||
		    (i > 0 && lane->switches[i].out_ns < lane->switches[i - 1].in_ns))
			return false;
	return lane->name;
}

static inline bool made_lane_is(const stilb_prof_snapshot *s, uint32_t lane)
{
	return lane < s->lane_count || lane == STILB_PROF_NONE;
}

static inline bool made_holds(const stilb_prof_snapshot *s)
{
	for (uint32_t i = 0; i < s->label_count; i++)
		if (!s->labels[i].name || !s->labels[i].function || !s->labels[i].file)
			return false;
	for (uint32_t i = 0; i < s->lane_count; i++)
		if (!made_lane_holds(s, &s->lanes[i]))
			return false;
	for (uint32_t i = 0; i < s->point_count; i++)
		if (s->points[i].label >= s->label_count || !made_lane_is(s, s->points[i].lane) ||
		    (i > 0 && s->points[i].ns < s->points[i - 1].ns))
			return false;
	for (uint32_t i = 0; i < s->flow_count; i++)
		if (s->flows[i].label >= s->label_count || !made_lane_is(s, s->flows[i].from_lane) ||
		    !made_lane_is(s, s->flows[i].to_lane) || s->flows[i].to_ns < s->flows[i].from_ns ||
		    (i > 0 && s->flows[i].to_ns < s->flows[i - 1].to_ns))
			return false;
	for (uint32_t i = 0; i < s->frame_count; i++)
		if (s->frames[i].end_ns < s->frames[i].begin_ns || (i > 0 && (s->frames[i].begin_ns < s->frames[i - 1].end_ns ||
		                                                              s->frames[i].number <= s->frames[i - 1].number)))
			return false;
	return true;
}

#endif
