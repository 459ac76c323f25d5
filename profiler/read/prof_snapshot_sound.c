/* For asserts: checks each promise of prof_snapshot.h, at the end of every function that makes a snapshot. */
#include "profiler/prof_internal.h"

static bool zone_is_inside(const stilb_prof_lane *lane, uint32_t i)
{
	const stilb_prof_zone *zone = &lane->zones[i];
	if (zone->parent == STILB_PROF_NONE)
		return zone->level == 0;
	if (zone->parent >= i)
		return false;
	const stilb_prof_zone *parent = &lane->zones[zone->parent];
	return i - zone->parent < parent->size && zone->begin_ns >= parent->begin_ns && zone->end_ns <= parent->end_ns &&
	       (zone->level == parent->level + 1 || parent->level == UINT16_MAX);
}

static bool zones_are_sound(const stilb_prof_snapshot *s, const stilb_prof_lane *lane)
{
	bool sound = true;
	for (uint32_t i = 0; sound && i < lane->zone_count; i++) {
		const stilb_prof_zone *zone = &lane->zones[i];
		uint64_t duration_ns = zone->end_ns - zone->begin_ns;
		sound = zone->begin_ns <= zone->end_ns && zone->self_ns <= duration_ns && zone->off_cpu_ns <= duration_ns &&
		        zone->size > 0 && zone->size <= lane->zone_count - i && zone->label < s->label_count &&
		        (zone->frame < s->frame_count || zone->frame == STILB_PROF_NONE) &&
		        (i == 0 || zone->begin_ns >= zone[-1].begin_ns) && zone_is_inside(lane, i) &&
		        (i + zone->size == lane->zone_count || zone[zone->size].begin_ns >= zone->end_ns);
	}
	return sound;
}

static bool lane_is_sound(const stilb_prof_snapshot *s, const stilb_prof_lane *lane)
{
	bool sound = lane->name && zones_are_sound(s, lane);
	for (uint32_t i = 0; sound && i < lane->switch_count; i++)
		sound = lane->switches[i].out_ns <= lane->switches[i].in_ns &&
		        (i == 0 || lane->switches[i].out_ns >= lane->switches[i - 1].in_ns);
	return sound;
}

static bool lane_exists(const stilb_prof_snapshot *s, uint32_t lane)
{
	return lane < s->lane_count || lane == STILB_PROF_NONE;
}

bool prof_snapshot_is_sound(const stilb_prof_snapshot *s)
{
	bool sound = true;
	for (uint32_t i = 0; sound && i < s->label_count; i++)
		sound = s->labels[i].name && s->labels[i].function && s->labels[i].file;
	for (uint32_t i = 0; sound && i < s->lane_count; i++)
		sound = lane_is_sound(s, &s->lanes[i]);
	for (uint32_t i = 0; sound && i < s->point_count; i++)
		sound = s->points[i].label < s->label_count && lane_exists(s, s->points[i].lane) &&
		        (i == 0 || s->points[i].ns >= s->points[i - 1].ns);
	for (uint32_t i = 0; sound && i < s->flow_count; i++)
		sound = s->flows[i].label < s->label_count && lane_exists(s, s->flows[i].from_lane) &&
		        lane_exists(s, s->flows[i].to_lane) && s->flows[i].from_ns <= s->flows[i].to_ns &&
		        (s->flows[i].frame < s->frame_count || s->flows[i].frame == STILB_PROF_NONE) &&
		        (i == 0 || s->flows[i].to_ns >= s->flows[i - 1].to_ns);
	for (uint32_t i = 0; sound && i < s->frame_count; i++)
		sound = s->frames[i].begin_ns <= s->frames[i].end_ns &&
		        (i == 0 ||
		         (s->frames[i].begin_ns >= s->frames[i - 1].end_ns && s->frames[i].number > s->frames[i - 1].number));
	return sound;
}
