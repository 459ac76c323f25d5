/* Snapshots of the profiler made by hand for tests: frames, lanes (threads and devices), their zones and switches
 * (times off the CPU), with times in microseconds. */
#ifndef TEST_UI_PROFILER_MADE_H
#define TEST_UI_PROFILER_MADE_H

#include "profiler/prof_snapshot.h"

#include <assert.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define MADE_LANES 8
#define MADE_LABELS 64
#define MADE_ZONES 20000
#define MADE_OTHERS 4096

typedef struct made {
	stilb_prof_snapshot snapshot;
	stilb_prof_label labels[MADE_LABELS];
	stilb_prof_lane lanes[MADE_LANES];
	stilb_prof_zone zones[MADE_LANES][MADE_ZONES];
	stilb_prof_switch switches[MADE_LANES][MADE_OTHERS];
	stilb_prof_flow flows[MADE_OTHERS];
	stilb_prof_point points[MADE_OTHERS];
	stilb_prof_frame frames[MADE_OTHERS];
} made;

static inline made *made_new(void)
{
	made *m = calloc(1, sizeof *m);
	assert(m);
	m->snapshot = (stilb_prof_snapshot){.labels = m->labels,
	                                    .lanes = m->lanes,
	                                    .flows = m->flows,
	                                    .points = m->points,
	                                    .frames = m->frames,
	                                    .clock = "rdtsc",
	                                    .zone_cost_ns = 20.0};
	return m;
}

static inline uint64_t made_ns(double us)
{
	return (uint64_t)(us * 1000.0 + 0.5);
}

static inline uint32_t made_label(made *m, const char *name)
{
	uint32_t i = 0;
	while (i < m->snapshot.label_count && strcmp(m->labels[i].name, name) != 0)
		i++;
	if (i == m->snapshot.label_count) {
		assert(i < MADE_LABELS);
		m->labels[i] = (stilb_prof_label){.name = name, .function = "", .file = "made.c", .line = i + 1};
		m->snapshot.label_count++;
	}
	return i;
}

/* Adds a lane; the zones and switches that follow belong to it. */
static inline uint32_t made_lane(made *m, const char *name, stilb_prof_lane_kind kind)
{
	uint32_t i = m->snapshot.lane_count++;
	assert(i < MADE_LANES);
	m->lanes[i] = (stilb_prof_lane){.name = name, .kind = kind, .zones = m->zones[i], .switches = m->switches[i]};
	return i;
}

static inline void made_frame(made *m, uint64_t number, double begin_us, double end_us)
{
	assert(m->snapshot.frame_count < MADE_OTHERS);
	m->frames[m->snapshot.frame_count++] = (stilb_prof_frame){number, made_ns(begin_us), made_ns(end_us)};
}

/* Adds a zone, nested in the last one that was made one level above. Returns its index. */
static inline uint32_t made_zone(made *m, uint16_t level, const char *name, double begin_us, double end_us)
{
	uint32_t lane = m->snapshot.lane_count - 1, index = m->lanes[lane].zone_count++;
	stilb_prof_zone *zones = m->zones[lane];
	assert(index < MADE_ZONES);
	zones[index] = (stilb_prof_zone){.begin_ns = made_ns(begin_us),
	                                 .end_ns = made_ns(end_us),
	                                 .label = made_label(m, name),
	                                 .parent = STILB_PROF_NONE,
	                                 .frame = STILB_PROF_NONE,
	                                 .size = 1,
	                                 .level = level};
	stilb_prof_zone *zone = &zones[index];
	zone->self_ns = zone->end_ns - zone->begin_ns;
	for (uint32_t f = 0; f < m->snapshot.frame_count; f++)
		if (zone->begin_ns >= m->frames[f].begin_ns && zone->begin_ns < m->frames[f].end_ns)
			zone->frame = f;
	for (uint32_t i = index; level > 0 && i-- > 0;)
		if (zones[i].level == level - 1) {
			zone->parent = i;
			break;
		}
	if (zone->parent != STILB_PROF_NONE)
		zones[zone->parent].self_ns -= zone->end_ns - zone->begin_ns;
	for (uint32_t i = zone->parent; i != STILB_PROF_NONE; i = zones[i].parent)
		zones[i].size++;
	return index;
}

/* Points are made in the order of their times. */
static inline void made_counter(made *m, uint32_t lane, uint32_t label, double us, double value)
{
	assert(m->snapshot.point_count < MADE_OTHERS);
	m->points[m->snapshot.point_count++] =
		(stilb_prof_point){.ns = made_ns(us), .value = value, .label = label, .lane = lane, .counter = true};
}

static inline void made_switch(made *m, double out_us, double in_us, bool preempted)
{
	uint32_t lane = m->snapshot.lane_count - 1, index = m->lanes[lane].switch_count++;
	assert(index < MADE_OTHERS);
	m->switches[lane][index] = (stilb_prof_switch){made_ns(out_us), made_ns(in_us), preempted};
}

#endif
