/* Walks over the zones of a lane (a thread's or the GPU's row of the timeline), merging of narrow zones, counters and
 * history. The report of a frame is in ui_profiler_report.c. */
#include "ui/ui_profiler_data.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- walking a lane ---------------------------------------------------------------------------------------------- */

static bool name_begins(const char *name, const char *word)
{
	return strncmp(name, word, strlen(word)) == 0;
}

bool ui_profiler_presents(const char *name)
{
	return strcmp(name, "acquire") == 0 || strcmp(name, "queue present") == 0;
}

ui_profiler_kind ui_profiler_kind_of(const char *name)
{
	if (name_begins(name, "wait") || ui_profiler_presents(name))
		return UI_PROFILER_WAIT;
	return strcmp(name, "parked") == 0 || strcmp(name, "idle") == 0 ? UI_PROFILER_IDLE : UI_PROFILER_WORK;
}

/* The number of the lane's zones that begin at ns or before. */
static uint32_t lane_begun(const stilb_prof_lane *lane, uint64_t ns)
{
	uint32_t low = 0, high = lane->zone_count;
	while (low < high) {
		uint32_t middle = low + (high - low) / 2;
		if (lane->zones[middle].begin_ns <= ns)
			low = middle + 1;
		else
			high = middle;
	}
	return low;
}

/* Index of the outermost zone that holds the time ns, or else of the last outermost zone before ns; 0 if there is none.
 * All outermost zones before that one have ended at ns, because siblings do not overlap. */
static uint32_t lane_first(const stilb_prof_lane *lane, uint64_t ns)
{
	uint32_t zone = lane_begun(lane, ns);
	if (zone == 0)
		return 0;
	zone--;
	while (lane->zones[zone].parent != STILB_PROF_NONE) {
		STILB_ASSERT(lane->zones[zone].parent < zone && "parents stand before their children");
		zone = lane->zones[zone].parent;
	}
	return zone;
}

ui_profiler_walk ui_profiler_walk_begin(const stilb_prof_lane *lane, uint64_t begin_ns, uint64_t end_ns)
{
	return (ui_profiler_walk){lane, begin_ns, end_ns, lane_first(lane, begin_ns), STILB_PROF_NONE};
}

bool ui_profiler_walk_next(ui_profiler_walk *walk, ui_profiler_stretch *stretch)
{
	const stilb_prof_lane *lane = walk->lane;
	const stilb_prof_zone *zones = lane->zones;
	if (walk->at_ns >= walk->end_ns)
		return false;
	while (walk->innermost != STILB_PROF_NONE && zones[walk->innermost].end_ns <= walk->at_ns)
		walk->innermost = zones[walk->innermost].parent;
	while (walk->next < lane->zone_count && zones[walk->next].begin_ns <= walk->at_ns) {
		const stilb_prof_zone *zone = &zones[walk->next];
		STILB_ASSERT(zone->size > 0 && "a zone's subtree holds the zone");
		if (zone->end_ns > walk->at_ns)
			walk->innermost = walk->next++;
		else
			walk->next += zone->size;
	}
	*stretch = (ui_profiler_stretch){walk->at_ns, walk->end_ns, walk->innermost};
	if (walk->innermost != STILB_PROF_NONE && zones[walk->innermost].end_ns < stretch->end_ns)
		stretch->end_ns = zones[walk->innermost].end_ns;
	if (walk->next < lane->zone_count && zones[walk->next].begin_ns < stretch->end_ns)
		stretch->end_ns = zones[walk->next].begin_ns;
	walk->at_ns = stretch->end_ns;
	return true;
}

uint32_t ui_profiler_zone_at(const stilb_prof_lane *lane, uint64_t ns)
{
	ui_profiler_walk walk = ui_profiler_walk_begin(lane, ns, ns + 1);
	ui_profiler_stretch stretch;
	return ui_profiler_walk_next(&walk, &stretch) ? stretch.zone : STILB_PROF_NONE;
}

uint32_t ui_profiler_switch_after(const stilb_prof_lane *lane, uint64_t ns)
{
	uint32_t low = 0, high = lane->switch_count;
	while (low < high) {
		uint32_t middle = low + (high - low) / 2;
		if (lane->switches[middle].in_ns <= ns)
			low = middle + 1;
		else
			high = middle;
	}
	return low;
}

uint64_t ui_profiler_off_cpu(const stilb_prof_lane *lane, uint64_t begin_ns, uint64_t end_ns, uint64_t *preempted)
{
	uint64_t off = 0;
	*preempted = 0;
	for (uint32_t i = ui_profiler_switch_after(lane, begin_ns); i < lane->switch_count; i++) {
		const stilb_prof_switch *s = &lane->switches[i];
		if (s->out_ns >= end_ns)
			break;
		uint64_t from = s->out_ns > begin_ns ? s->out_ns : begin_ns, to = s->in_ns < end_ns ? s->in_ns : end_ns;
		STILB_ASSERT(from <= to && "a switch ends after it begins");
		off += to - from;
		*preempted += s->preempted ? to - from : 0;
	}
	return off;
}

/* ---- merging ----------------------------------------------------------------------------------------------------- */

/* Levels of nesting that are drawn. Zones nested deeper, which only traces of other programs have, are left out. */
#define SPANS_LEVELS (STILB_PROF_DEPTH_MAX + 1u)

typedef struct spans_builder {
	ui_profiler_spans *out;
	/* For each level a run: neighbouring narrow zones merged so far into one span, not yet in `out`; count 0: none. */
	ui_profiler_span runs[SPANS_LEVELS];
	double narrow_ns; /* a zone shorter than this is narrow */
} spans_builder;

static bool spans_push(ui_profiler_spans *spans, const ui_profiler_span *span)
{
	if (spans->count == spans->capacity) {
		uint32_t capacity = spans->capacity ? spans->capacity * 2 : 512;
		ui_profiler_span *grown = realloc(spans->spans, capacity * sizeof *grown);
		if (!grown)
			return false;
		spans->spans = grown;
		spans->capacity = capacity;
	}
	spans->spans[spans->count++] = *span;
	return true;
}

/* Puts the runs of this level and all deeper ones into the spans: the next zone, at this level, is not narrow, and a
 * run must not reach across it. */
static bool spans_flush(spans_builder *builder, uint32_t level)
{
	for (; level < SPANS_LEVELS; level++) {
		ui_profiler_span *run = &builder->runs[level];
		if (run->count > 0 && !spans_push(builder->out, run))
			return false;
		run->count = 0;
	}
	return true;
}

/* Adds a narrow zone, with all zones nested in it, to its level's run, or begins a new run with it. */
static bool spans_narrow(spans_builder *builder, const stilb_prof_lane *lane, uint32_t index)
{
	const stilb_prof_zone *zone = &lane->zones[index];
	ui_profiler_span *run = &builder->runs[zone->level];
	if (run->count > 0 && (double)zone->begin_ns - (double)run->end_ns < builder->narrow_ns) {
		const stilb_prof_zone *longest = &lane->zones[run->zone];
		run->end_ns = zone->end_ns > run->end_ns ? zone->end_ns : run->end_ns;
		run->count += zone->size;
		run->label = run->label == zone->label ? run->label : STILB_PROF_NONE;
		if (zone->end_ns - zone->begin_ns > longest->end_ns - longest->begin_ns)
			run->zone = index;
		return true;
	}
	if (run->count > 0 && !spans_push(builder->out, run))
		return false;
	*run = (ui_profiler_span){zone->begin_ns, zone->end_ns, index, zone->size, zone->label, zone->level};
	return true;
}

/* For STILB_CHECK: each span encloses its longest zone, and the spans of one level ascend and do not overlap. */
static bool spans_are_sound(const ui_profiler_spans *spans, const stilb_prof_lane *lane)
{
	uint64_t reached[SPANS_LEVELS] = {0};
	for (uint32_t i = 0; i < spans->count; i++) {
		const ui_profiler_span *span = &spans->spans[i];
		if (span->count == 0 || span->level >= SPANS_LEVELS || span->begin_ns < reached[span->level] ||
		    span->end_ns < span->begin_ns || span->zone >= lane->zone_count ||
		    lane->zones[span->zone].begin_ns < span->begin_ns || lane->zones[span->zone].end_ns > span->end_ns)
			return false;
		reached[span->level] = span->end_ns;
	}
	return true;
}

bool ui_profiler_spans_build(ui_profiler_spans *spans, const stilb_prof_lane *lane, uint64_t begin_ns, uint64_t end_ns,
                             double narrow_ns)
{
	STILB_ASSERT(begin_ns <= end_ns);
	STILB_ASSERT(narrow_ns >= 0.0);
	spans_builder builder = {.out = spans, .narrow_ns = narrow_ns};
	spans->count = 0;
	for (uint32_t i = lane_first(lane, begin_ns); i < lane->zone_count && lane->zones[i].begin_ns < end_ns;) {
		const stilb_prof_zone *zone = &lane->zones[i];
		if (zone->end_ns <= begin_ns || zone->level >= SPANS_LEVELS) {
			i += zone->size;
		} else if ((double)(zone->end_ns - zone->begin_ns) < narrow_ns) {
			if (!spans_narrow(&builder, lane, i))
				return false;
			i += zone->size;
		} else {
			ui_profiler_span span = {zone->begin_ns, zone->end_ns, i, 1, zone->label, zone->level};
			if (!spans_flush(&builder, zone->level) || !spans_push(spans, &span))
				return false;
			i++;
		}
	}
	if (!spans_flush(&builder, 0))
		return false;
	STILB_CHECK(spans_are_sound(spans, lane));
	return true;
}

void ui_profiler_spans_finish(ui_profiler_spans *spans)
{
	free(spans->spans);
	*spans = (ui_profiler_spans){0};
}

/* ---- counters ---------------------------------------------------------------------------------------------------- */

uint32_t ui_profiler_counter_at(const ui_profiler_data *data, const stilb_prof_snapshot *snapshot,
                                const ui_profiler_counter *counter, uint64_t ns)
{
	STILB_ASSERT(counter >= data->counters && counter < data->counters + data->counter_count);
	/* Binary search for the first point after ns. */
	uint32_t low = counter->first, high = counter->first + counter->count;
	while (low < high) {
		uint32_t middle = low + (high - low) / 2;
		if (snapshot->points[data->points[middle]].ns <= ns)
			low = middle + 1;
		else
			high = middle;
	}
	return low > counter->first ? low - 1 : STILB_PROF_NONE;
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

uint32_t ui_profiler_frame_find(const stilb_prof_snapshot *snapshot, uint64_t number)
{
	if (snapshot->frame_count == 0 || number < snapshot->frames[0].number)
		return STILB_PROF_NONE;
	/* Frame numbers are consecutive, except in trace files of other programs, which have gaps: then the frame is before
	 * the place computed from its number. */
	uint64_t guess = number - snapshot->frames[0].number;
	for (uint64_t i = guess < snapshot->frame_count ? guess + 1 : snapshot->frame_count; i-- > 0;)
		if (snapshot->frames[i].number == number)
			return (uint32_t)i;
	return STILB_PROF_NONE;
}

const char *ui_profiler_time_text(char *text, size_t size, uint64_t ns)
{
	double value = (double)ns;
	if (ns < 1000)
		snprintf(text, size, "%u ns", (unsigned)ns);
	else if (value < 99.95e3)
		snprintf(text, size, "%.1f µs", value * 1e-3);
	else if (value < 999.5e3)
		snprintf(text, size, "%.0f µs", value * 1e-3);
	else if (value < 999.5e6)
		snprintf(text, size, "%.2f ms", value * 1e-6);
	else
		snprintf(text, size, "%.2f s", value * 1e-9);
	return text;
}

uint32_t ui_profiler_parts(stilb_prof_lane_kind kind, const ui_profiler_lane_sum *sum, uint64_t least_ns,
                           ui_profiler_part parts[UI_PROFILER_PARTS])
{
	bool device = kind == STILB_PROF_LANE_DEVICE;
	ui_profiler_part all[UI_PROFILER_PARTS] = {
		{device ? "busy" : "work", sum->work_ns, false},
		{"wait", sum->wait_ns, false},
		{"idle", sum->idle_ns + (device ? sum->outside_ns : 0), false},
		{"asleep", sum->asleep_ns, false},
		{"lost the CPU", sum->lost_ns, true},
		{"outside zones", device ? 0 : sum->outside_ns, false},
	};
	uint32_t count = 0;
	for (uint32_t i = 0; i < UI_PROFILER_PARTS; i++)
		if (all[i].ns > (i == 0 ? 0 : least_ns))
			parts[count++] = all[i];
	if (count == 0)
		parts[count++] = all[0];
	return count;
}

void ui_profiler_average(const stilb_prof_frame_stats *history, float average_ms[STILB_PROF_STATS_FRAMES])
{
	STILB_ASSERT(history->count <= STILB_PROF_STATS_FRAMES);
	double sum = 0.0;
	for (uint32_t i = 0; i < history->count; i++) {
		uint32_t frames = i + 1 < UI_PROFILER_AVERAGE ? i + 1 : UI_PROFILER_AVERAGE;
		sum += history->ms[i];
		if (i >= UI_PROFILER_AVERAGE)
			sum -= history->ms[i - UI_PROFILER_AVERAGE];
		average_ms[i] = (float)(sum / frames);
	}
}

uint32_t ui_profiler_slowest(const stilb_prof_frame_stats *history)
{
	STILB_ASSERT(history->count > 0 && history->count <= STILB_PROF_STATS_FRAMES);
	uint32_t slowest = 0;
	for (uint32_t i = 0; i < history->count; i++)
		if (history->ms[i] >= history->ms[slowest])
			slowest = i;
	return slowest;
}
