/* The report of a frame: where each thread's time went, what limits the frame, and which thread waited longest for
 * which. A lane is one thread or the GPU with its zones. */
#include "ui/ui_profiler_data.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define REPORT_GROUPS 32 /* groups of waits (those of one reason, see ui_profiler_wait) that are kept for each lane */

/* The input of the functions below, and the data that they fill. */
typedef struct report_input {
	ui_profiler_data *data;
	const stilb_prof_snapshot *snapshot;
	uint64_t begin_ns, end_ns; /* the frame */
	uint32_t wrapper;          /* zone of the frame's thread that spans the frame ("frame"), or STILB_PROF_NONE */
} report_input;

/* The part of the zone's time that lies in the frame, nanoseconds. */
static uint64_t report_overlap(const report_input *in, const stilb_prof_zone *zone)
{
	uint64_t from = zone->begin_ns > in->begin_ns ? zone->begin_ns : in->begin_ns;
	uint64_t to = zone->end_ns < in->end_ns ? zone->end_ns : in->end_ns;
	return to > from ? to - from : 0;
}

static ui_profiler_kind report_kind(const report_input *in, const stilb_prof_lane *lane, uint32_t zone)
{
	return (ui_profiler_kind)in->data->kinds[lane->zones[zone].label];
}

/* The kind of time in a stretch. Time outside all zones counts as work: the thread does something unmarked there. */
static ui_profiler_kind report_stretch_kind(const report_input *in, const stilb_prof_lane *lane,
                                            const ui_profiler_stretch *stretch)
{
	return stretch->zone == STILB_PROF_NONE ? UI_PROFILER_WORK : report_kind(in, lane, stretch->zone);
}

static const char *report_label(const report_input *in, uint32_t label)
{
	STILB_ASSERT(label < in->snapshot->label_count);
	return in->snapshot->labels[label].name;
}

/* Appends to the text of size bytes, cut short at its end. */
static void report_append(char *text, size_t size, const char *format, ...) __attribute__((format(printf, 3, 4)));

static void report_append(char *text, size_t size, const char *format, ...)
{
	size_t length = strlen(text);
	STILB_ASSERT(length < size);
	va_list arguments;
	va_start(arguments, format);
	vsnprintf(text + length, size - length, format, arguments);
	va_end(arguments);
}

/* ---- sums -------------------------------------------------------------------------------------------------------- */

/* Adds every stretch of the lane in the frame to the part that it belongs to. */
static void report_sum_lane(const report_input *in, const stilb_prof_lane *lane, ui_profiler_lane_sum *sum)
{
	ui_profiler_walk walk = ui_profiler_walk_begin(lane, in->begin_ns, in->end_ns);
	ui_profiler_stretch stretch;
	*sum = (ui_profiler_lane_sum){0};
	while (ui_profiler_walk_next(&walk, &stretch)) {
		uint64_t length = stretch.end_ns - stretch.begin_ns;
		ui_profiler_kind kind = report_stretch_kind(in, lane, &stretch);
		uint64_t lost = 0, off = 0;
		if (kind == UI_PROFILER_WAIT) {
			sum->wait_ns += length;
		} else if (kind == UI_PROFILER_IDLE) {
			sum->idle_ns += length;
		} else {
			off = ui_profiler_off_cpu(lane, stretch.begin_ns, stretch.end_ns, &lost);
			STILB_ASSERT(lost <= off && off <= length);
			sum->lost_ns += lost;
			sum->asleep_ns += off - lost;
			*(stretch.zone == STILB_PROF_NONE ? &sum->outside_ns : &sum->work_ns) += length - off;
		}
	}
	STILB_ASSERT(sum->work_ns + sum->wait_ns + sum->idle_ns + sum->asleep_ns + sum->lost_ns + sum->outside_ns ==
	             in->end_ns - in->begin_ns);
}

/* Nanoseconds of the frame that are covered by the lane's outermost zones other than idle ones; *longest is the zone
 * that covers most of it, or STILB_PROF_NONE. */
static uint64_t report_cover(const report_input *in, const stilb_prof_lane *lane, uint32_t *longest)
{
	uint64_t cover = 0, most = 0;
	*longest = STILB_PROF_NONE;
	for (uint32_t i = 0; i < lane->zone_count && lane->zones[i].begin_ns < in->end_ns; i += lane->zones[i].size) {
		uint64_t overlap = report_overlap(in, &lane->zones[i]);
		if (report_kind(in, lane, i) == UI_PROFILER_IDLE || overlap == 0)
			continue;
		cover += overlap;
		if (overlap > most) {
			most = overlap;
			*longest = i;
		}
	}
	return cover;
}

/* Finds the thread that runs frames: the first whose zones cover half of the frame, else the one whose zones cover most
 * of it. Its wrapper is a zone with others in it that covers half of the frame by itself. */
static void report_find_lane(report_input *in)
{
	ui_profiler_report *report = &in->data->report;
	uint64_t most = 0, half = (in->end_ns - in->begin_ns) / 2;
	report->lane = in->wrapper = STILB_PROF_NONE;
	for (uint32_t i = 0; i < in->snapshot->lane_count && most < half; i++) {
		const stilb_prof_lane *lane = &in->snapshot->lanes[i];
		uint32_t longest;
		uint64_t cover = lane->kind == STILB_PROF_LANE_THREAD ? report_cover(in, lane, &longest) : 0;
		if (cover <= most)
			continue;
		most = cover;
		report->lane = i;
		STILB_ASSERT(longest < lane->zone_count && "a covered frame has a longest zone");
		bool whole = report_overlap(in, &lane->zones[longest]) >= half && lane->zones[longest].size > 1;
		in->wrapper = whole ? longest : STILB_PROF_NONE;
	}
}

/* Finds the label whose zones take most of the frame: among the wrapper's children if there is a wrapper, else among
 * the outermost zones. The time that they leave over counts for the wrapper's label. */
static void report_find_stage(const report_input *in)
{
	ui_profiler_report *report = &in->data->report;
	STILB_ASSERT(report->lane < in->snapshot->lane_count);
	const stilb_prof_lane *lane = &in->snapshot->lanes[report->lane];
	uint64_t *sums = in->data->label_ns, left = in->end_ns - in->begin_ns;
	uint32_t from = in->wrapper == STILB_PROF_NONE ? 0 : in->wrapper + 1;
	uint32_t to = in->wrapper == STILB_PROF_NONE ? lane->zone_count : in->wrapper + lane->zones[in->wrapper].size;
	memset(sums, 0, in->snapshot->label_count * sizeof *sums);
	report->stage_label = STILB_PROF_NONE;
	report->stage_ns = 0;
	for (uint32_t i = from; i < to; i += lane->zones[i].size) {
		uint32_t label = lane->zones[i].label;
		uint64_t overlap = report_overlap(in, &lane->zones[i]);
		left -= overlap < left ? overlap : left;
		sums[label] += overlap;
		if (sums[label] > report->stage_ns) {
			report->stage_ns = sums[label];
			report->stage_label = label;
		}
	}
	if (left > report->stage_ns) {
		report->stage_ns = left;
		report->stage_label = in->wrapper == STILB_PROF_NONE ? STILB_PROF_NONE : lane->zones[in->wrapper].label;
	}
}

/* Adds the lane's time in zones of work during begin_ns..end_ns to data->label_ns, each stretch to the label of its
 * innermost zone. */
static void report_count_labels(const report_input *in, const stilb_prof_lane *lane, uint64_t begin_ns, uint64_t end_ns)
{
	ui_profiler_walk walk = ui_profiler_walk_begin(lane, begin_ns, end_ns);
	ui_profiler_stretch stretch;
	while (ui_profiler_walk_next(&walk, &stretch))
		if (stretch.zone != STILB_PROF_NONE && report_kind(in, lane, stretch.zone) == UI_PROFILER_WORK)
			in->data->label_ns[lane->zones[stretch.zone].label] += stretch.end_ns - stretch.begin_ns;
}

/* The label with the most time in data->label_ns, or STILB_PROF_NONE if all are 0. */
static uint32_t report_most_label(const report_input *in)
{
	uint32_t most = STILB_PROF_NONE;
	for (uint32_t i = 0; i < in->snapshot->label_count; i++)
		if (in->data->label_ns[i] > 0 && (most == STILB_PROF_NONE || in->data->label_ns[i] > in->data->label_ns[most]))
			most = i;
	return most;
}

/* The device with the most busy time in the frame, or STILB_PROF_NONE without devices; *busy_ns is that time. */
static uint32_t report_find_device(const report_input *in, uint64_t *busy_ns)
{
	uint32_t device = STILB_PROF_NONE;
	*busy_ns = 0;
	for (uint32_t i = 0; i < in->snapshot->lane_count; i++) {
		uint32_t longest;
		if (in->snapshot->lanes[i].kind != STILB_PROF_LANE_DEVICE)
			continue;
		uint64_t cover = report_cover(in, &in->snapshot->lanes[i], &longest);
		if (device == STILB_PROF_NONE || cover > *busy_ns) {
			device = i;
			*busy_ns = cover;
		}
	}
	return device;
}

static void report_count_events(const report_input *in)
{
	const stilb_prof_snapshot *snapshot = in->snapshot;
	uint32_t zones = 0, others = 0;
	for (uint32_t l = 0; l < snapshot->lane_count; l++) {
		const stilb_prof_lane *lane = &snapshot->lanes[l];
		for (uint32_t i = 0; lane->kind == STILB_PROF_LANE_THREAD && i < lane->zone_count; i++)
			zones += lane->zones[i].begin_ns >= in->begin_ns && lane->zones[i].begin_ns < in->end_ns;
	}
	for (uint32_t i = 0; i < snapshot->point_count; i++)
		others += snapshot->points[i].ns >= in->begin_ns && snapshot->points[i].ns < in->end_ns;
	for (uint32_t i = 0; i < snapshot->flow_count; i++) {
		const stilb_prof_flow *flow = &snapshot->flows[i];
		others += flow->from_lane != STILB_PROF_NONE && flow->from_ns >= in->begin_ns && flow->from_ns < in->end_ns;
		others += flow->to_lane != STILB_PROF_NONE && flow->to_ns >= in->begin_ns && flow->to_ns < in->end_ns;
	}
	in->data->report.events = zones + others;
	/* Nearly all of the cost is reading the clock: a zone does it twice, any other event once. */
	in->data->report.cost_ns = (uint64_t)((zones + 0.5 * others) * snapshot->zone_cost_ns);
}

/* ---- waits ------------------------------------------------------------------------------------------------------- */

/* The waits of one lane, grouped by reason. */
typedef struct report_waits {
	const report_input *in;
	uint32_t lane;
	ui_profiler_wait groups[REPORT_GROUPS + 1]; /* the last one is only for times in which the CPU was lost */
	uint32_t count;
} report_waits;

/* The label of the innermost zone of work around a zone, or STILB_PROF_NONE. The wrapper is passed over: it spans the
 * frame, so that a wait was in it tells nothing. */
static uint32_t report_wait_place(const report_input *in, uint32_t lane, uint32_t zone)
{
	const stilb_prof_lane *l = &in->snapshot->lanes[lane];
	while (zone != STILB_PROF_NONE && report_kind(in, l, zone) != UI_PROFILER_WORK)
		zone = l->zones[zone].parent;
	if (zone == STILB_PROF_NONE || (zone == in->wrapper && lane == in->data->report.lane))
		return STILB_PROF_NONE;
	return l->zones[zone].label;
}

/* True if a wait of this label, in the zone of work `place`, belongs to the group. Losing the CPU to another thread is
 * one reason, whichever zone it interrupts. */
static bool report_wait_is(const ui_profiler_wait *group, uint32_t label, uint32_t place, bool preempted)
{
	return group->label == label && group->preempted == preempted && (preempted || group->in_label == place);
}

/* Adds a wait to its group. place: the label of the work around it. Waits beyond REPORT_GROUPS reasons are left out. */
static void report_wait_add(report_waits *waits, uint32_t label, uint32_t place, bool preempted, uint64_t begin,
                            uint64_t end)
{
	STILB_ASSERT(begin <= end);
	STILB_ASSERT(waits->count <= REPORT_GROUPS + 1);
	ui_profiler_wait *group = waits->groups;
	while (group < waits->groups + waits->count && !report_wait_is(group, label, place, preempted))
		group++;
	if (group >= waits->groups + REPORT_GROUPS + preempted)
		return;
	if (group == waits->groups + waits->count) {
		waits->count++;
		*group = (ui_profiler_wait){.lane = waits->lane,
		                            .label = label,
		                            .preempted = preempted,
		                            .for_lane = STILB_PROF_NONE,
		                            .for_label = STILB_PROF_NONE};
	}
	group->count++;
	group->total_ns += end - begin;
	if (group->count == 1 || end - begin > group->end_ns - group->begin_ns) {
		group->begin_ns = begin;
		group->end_ns = end;
		group->in_label = place;
	}
}

/* Adds the times off the CPU during a stretch of work or outside all zones. */
static void report_wait_off(report_waits *waits, const stilb_prof_lane *lane, const ui_profiler_stretch *stretch)
{
	uint32_t place = report_wait_place(waits->in, waits->lane, stretch->zone);
	for (uint32_t i = ui_profiler_switch_after(lane, stretch->begin_ns); i < lane->switch_count; i++) {
		const stilb_prof_switch *s = &lane->switches[i];
		if (s->out_ns >= stretch->end_ns)
			break;
		uint64_t from = s->out_ns > stretch->begin_ns ? s->out_ns : stretch->begin_ns;
		uint64_t to = s->in_ns < stretch->end_ns ? s->in_ns : stretch->end_ns;
		report_wait_add(waits, STILB_PROF_NONE, place, s->preempted, from, to);
	}
}

/* Fills `waits` with the waits of its lane in the frame. idle_too: zones with nothing to do are waits as well; so it is
 * for the thread that runs frames, which cannot go on until others are done. */
static void report_collect_waits(report_waits *waits, bool idle_too)
{
	const report_input *in = waits->in;
	const stilb_prof_lane *lane = &in->snapshot->lanes[waits->lane];
	ui_profiler_walk walk = ui_profiler_walk_begin(lane, in->begin_ns, in->end_ns);
	ui_profiler_stretch stretch;
	while (ui_profiler_walk_next(&walk, &stretch)) {
		ui_profiler_kind kind = report_stretch_kind(in, lane, &stretch);
		if (kind == UI_PROFILER_WORK)
			report_wait_off(waits, lane, &stretch);
		else if (kind == UI_PROFILER_WAIT || idle_too)
			report_wait_add(waits, lane->zones[stretch.zone].label, report_wait_place(in, waits->lane, stretch.zone),
			                false, stretch.begin_ns, stretch.end_ns);
	}
}

/* The next stretch of the walk that belongs to the group; false: there is none. */
static bool report_wait_next(const report_input *in, const ui_profiler_wait *group, ui_profiler_walk *walk,
                             ui_profiler_stretch *stretch)
{
	while (ui_profiler_walk_next(walk, stretch))
		if (stretch->zone != STILB_PROF_NONE && walk->lane->zones[stretch->zone].label == group->label &&
		    report_wait_place(in, group->lane, stretch->zone) == group->in_label)
			return true;
	return false;
}

/* The end of the lane's last stretch of work in begin_ns..end_ns; begin_ns if there is none. */
static uint64_t report_last_work(const report_input *in, const stilb_prof_lane *lane, uint64_t begin_ns,
                                 uint64_t end_ns)
{
	ui_profiler_walk walk = ui_profiler_walk_begin(lane, begin_ns, end_ns);
	ui_profiler_stretch stretch;
	uint64_t last = begin_ns;
	while (ui_profiler_walk_next(&walk, &stretch))
		if (stretch.zone != STILB_PROF_NONE && report_kind(in, lane, stretch.zone) == UI_PROFILER_WORK)
			last = stretch.end_ns;
	return last;
}

/* The lane of the thread that the group's waits were for. Each wait is taken to be for the thread that worked last in
 * it; of these threads, the one with the longest waits together. STILB_PROF_NONE: no thread worked during the waits. */
static uint32_t report_wait_for_thread(const report_input *in, const ui_profiler_wait *group)
{
	ui_profiler_walk walk = ui_profiler_walk_begin(&in->snapshot->lanes[group->lane], in->begin_ns, in->end_ns);
	ui_profiler_stretch stretch;
	uint64_t most = 0;
	uint32_t whom = STILB_PROF_NONE;
	for (uint32_t i = 0; i < in->snapshot->lane_count; i++)
		in->data->lane_ns[i] = 0;
	while (report_wait_next(in, group, &walk, &stretch)) {
		uint64_t last = stretch.begin_ns;
		uint32_t latest = STILB_PROF_NONE;
		for (uint32_t i = 0; i < in->snapshot->lane_count; i++) {
			const stilb_prof_lane *lane = &in->snapshot->lanes[i];
			if (i == group->lane || lane->kind != STILB_PROF_LANE_THREAD)
				continue;
			uint64_t ended = report_last_work(in, lane, stretch.begin_ns, stretch.end_ns);
			if (ended > last) {
				last = ended;
				latest = i;
			}
		}
		if (latest != STILB_PROF_NONE && (in->data->lane_ns[latest] += stretch.end_ns - stretch.begin_ns) > most) {
			most = in->data->lane_ns[latest];
			whom = latest;
		}
	}
	return whom;
}

/* Fills the members for_... and after_... of a group whose for_lane is known: what that lane did during the waits. */
static void report_wait_explain(const report_input *in, ui_profiler_wait *group)
{
	STILB_ASSERT(group->for_lane < in->snapshot->lane_count);
	const stilb_prof_lane *whom = &in->snapshot->lanes[group->for_lane];
	ui_profiler_walk walk = ui_profiler_walk_begin(&in->snapshot->lanes[group->lane], in->begin_ns, in->end_ns);
	ui_profiler_stretch waited, stretch;
	memset(in->data->label_ns, 0, in->snapshot->label_count * sizeof *in->data->label_ns);
	while (report_wait_next(in, group, &walk, &waited)) {
		ui_profiler_walk work = ui_profiler_walk_begin(whom, waited.begin_ns, waited.end_ns);
		uint64_t preempted, last = waited.begin_ns;
		bool begun = false;
		while (ui_profiler_walk_next(&work, &stretch)) {
			if (stretch.zone != STILB_PROF_NONE && report_kind(in, whom, stretch.zone) == UI_PROFILER_WORK) {
				begun = true;
				last = stretch.end_ns;
				group->for_off_ns += ui_profiler_off_cpu(whom, stretch.begin_ns, stretch.end_ns, &preempted);
				group->for_preempted_ns += preempted;
			} else if (!begun) {
				group->for_late_ns += stretch.end_ns - stretch.begin_ns;
			}
		}
		if (begun) {
			group->after_ns += waited.end_ns - last;
			ui_profiler_off_cpu(&in->snapshot->lanes[group->lane], last, waited.end_ns, &preempted);
			group->after_lost_ns += preempted;
		}
		report_count_labels(in, whom, waited.begin_ns, waited.end_ns);
	}
	group->for_label = report_most_label(in);
}

/* Sets *best to the group of waits with the longest total time, if that is longer than *best. */
static void report_consider(report_waits *waits, ui_profiler_wait *best)
{
	for (uint32_t i = 0; i < waits->count; i++)
		if (best->lane == STILB_PROF_NONE || waits->groups[i].total_ns > best->total_ns)
			*best = waits->groups[i];
}

/* The shortest wait that is mentioned, nanoseconds: 2 % of the frame, but at least 20 µs. */
static uint64_t report_threshold(const report_input *in)
{
	uint64_t share = (in->end_ns - in->begin_ns) / 50;
	return share > 20000 ? share : 20000;
}

/* Finds the longest group of waits. Waits of the thread that runs frames are preferred, because only they surely make
 * the frame longer; waits of other threads are considered only if that thread hardly waited. */
static void report_find_wait(const report_input *in, uint32_t device)
{
	ui_profiler_wait *wait = &in->data->report.wait;
	report_waits waits = {.in = in, .lane = in->data->report.lane};
	*wait = (ui_profiler_wait){.lane = STILB_PROF_NONE};
	report_collect_waits(&waits, true);
	report_consider(&waits, wait);
	for (uint32_t i = 0; wait->total_ns < report_threshold(in) && i < in->snapshot->lane_count; i++) {
		if (in->snapshot->lanes[i].kind != STILB_PROF_LANE_THREAD || i == in->data->report.lane)
			continue;
		waits = (report_waits){.in = in, .lane = i};
		report_collect_waits(&waits, false);
		report_consider(&waits, wait);
	}
	if (wait->total_ns < report_threshold(in))
		*wait = (ui_profiler_wait){.lane = STILB_PROF_NONE};
	if (wait->lane == STILB_PROF_NONE || wait->label == STILB_PROF_NONE)
		return;
	const char *name = report_label(in, wait->label);
	if (strstr(name, "GPU") || (ui_profiler_presents(name) && in->data->report.limit == UI_PROFILER_LIMIT_GPU))
		wait->for_lane = device;
	else if (ui_profiler_kind_of(name) == UI_PROFILER_IDLE || strstr(name, "worker") || strstr(name, "job"))
		wait->for_lane = report_wait_for_thread(in, wait);
	if (wait->for_lane != STILB_PROF_NONE)
		report_wait_explain(in, wait);
}

/* ---- the verdict ------------------------------------------------------------------------------------------------- */

/* Nanoseconds that the thread that runs frames waited for the GPU; if presenting, only those in zones for which
 * ui_profiler_presents is true. */
static uint64_t report_waited(const report_input *in, bool presenting)
{
	const stilb_prof_lane *lane = &in->snapshot->lanes[in->data->report.lane];
	ui_profiler_walk walk = ui_profiler_walk_begin(lane, in->begin_ns, in->end_ns);
	ui_profiler_stretch stretch;
	uint64_t sum = 0;
	while (ui_profiler_walk_next(&walk, &stretch)) {
		if (stretch.zone == STILB_PROF_NONE || report_kind(in, lane, stretch.zone) != UI_PROFILER_WAIT)
			continue;
		const char *name = report_label(in, lane->zones[stretch.zone].label);
		bool for_gpu = strstr(name, "GPU");
		if (presenting ? ui_profiler_presents(name) : for_gpu)
			sum += stretch.end_ns - stretch.begin_ns;
	}
	return sum;
}

/* True if presenting is the longest part of the frame and the thread sleeps in more than half of it. */
static bool report_display_limits(const report_input *in)
{
	const ui_profiler_report *report = &in->data->report;
	const stilb_prof_lane *lane = &in->snapshot->lanes[report->lane];
	uint64_t off = 0, preempted;
	if (report->stage_label == STILB_PROF_NONE || strcmp(report_label(in, report->stage_label), "present") != 0)
		return false;
	for (uint32_t i = 0; i < lane->zone_count; i++)
		if (lane->zones[i].label == report->stage_label && report_overlap(in, &lane->zones[i]) > 0)
			off += ui_profiler_off_cpu(lane, lane->zones[i].begin_ns, lane->zones[i].end_ns, &preempted) - preempted;
	return off > report->stage_ns / 2;
}

/* Decides what limits the frame. It is the GPU if that is busy for three quarters of the frame and the thread that runs
 * frames waits for it, also while presenting. A wait alone does not suffice: a frame that the CPU made slow may begin
 * with a wait for the GPU's work of the frame before, and then the GPU is idle later. Without a lane of the GPU, the
 * waits alone decide. */
static void report_find_limit(const report_input *in, uint32_t device)
{
	ui_profiler_report *report = &in->data->report;
	uint64_t frame = in->end_ns - in->begin_ns;
	bool busy = report->gpu_ns >= frame / 4 * 3, waits = report_waited(in, false) >= frame / 20;
	bool display = report_waited(in, true) >= frame / 2 || report_display_limits(in);
	if (device == STILB_PROF_NONE ? waits : busy && (waits || display)) {
		report->limit = UI_PROFILER_LIMIT_GPU;
		if (device == STILB_PROF_NONE)
			return;
		memset(in->data->label_ns, 0, in->snapshot->label_count * sizeof *in->data->label_ns);
		report_count_labels(in, &in->snapshot->lanes[device], in->begin_ns, in->end_ns);
		uint32_t pass = report_most_label(in);
		if (pass != STILB_PROF_NONE) {
			report->stage_label = pass;
			report->stage_ns = in->data->label_ns[pass];
		}
	} else {
		report->limit = display ? UI_PROFILER_LIMIT_DISPLAY : UI_PROFILER_LIMIT_CPU;
	}
}

/* If the longest part of the frame is the time outside all zones: how much of it was on a CPU, as words for the
 * verdict. Else "", because for zones the table has that number. */
static const char *report_outside_text(const report_input *in, char *text, size_t size)
{
	const ui_profiler_report *report = &in->data->report;
	char part[32];
	text[0] = 0;
	if (report->stage_label != STILB_PROF_NONE || report->lane == STILB_PROF_NONE)
		return text;
	uint64_t on_ns = in->data->lanes[report->lane].outside_ns;
	if (on_ns < report->stage_ns - report->stage_ns / 20)
		snprintf(text, size, ", %s of it on a CPU", ui_profiler_time_text(part, sizeof part, on_ns));
	return text;
}

static void report_say_verdict(const report_input *in)
{
	ui_profiler_report *report = &in->data->report;
	const char *stage =
		report->stage_label == STILB_PROF_NONE ? "what lies outside all zones" : report_label(in, report->stage_label);
	char whole[32], part[32], gpu[32], outside[64];
	ui_profiler_time_text(whole, sizeof whole, in->end_ns - in->begin_ns);
	ui_profiler_time_text(part, sizeof part, report->stage_ns);
	ui_profiler_time_text(gpu, sizeof gpu, report->gpu_ns);
	switch (report->limit) {
	case UI_PROFILER_LIMIT_UNKNOWN:
		snprintf(report->verdict, sizeof report->verdict, "Nothing was recorded in this frame.");
		break;
	case UI_PROFILER_LIMIT_CPU:
		snprintf(report->verdict, sizeof report->verdict, "CPU-limited: %s decides, %s of %s%s.", stage, part, whole,
		         report_outside_text(in, outside, sizeof outside));
		break;
	case UI_PROFILER_LIMIT_GPU:
		snprintf(report->verdict, sizeof report->verdict, "GPU-limited: the GPU was busy for %s of %s; %s decides, %s.",
		         gpu, whole, stage, part);
		break;
	case UI_PROFILER_LIMIT_DISPLAY:
		snprintf(report->verdict, sizeof report->verdict, "Held back by the display: %s waits %s of %s.", stage, part,
		         whole);
		break;
	}
}

/* Appends what the lane that was waited for did; parts under a fifth of the wait are left out. */
static void report_say_other(const report_input *in, char *text, size_t size)
{
	const ui_profiler_wait *wait = &in->data->report.wait;
	char part[32];
	report_append(text, size, ", which");
	if (wait->for_late_ns >= wait->total_ns / 5)
		report_append(text, size, " began %s late and", ui_profiler_time_text(part, sizeof part, wait->for_late_ns));
	report_append(text, size,
	              in->snapshot->lanes[wait->for_lane].kind == STILB_PROF_LANE_DEVICE ? " was busy with %s"
	                                                                                 : " was in %s",
	              report_label(in, wait->for_label));
	if (wait->for_off_ns >= wait->total_ns / 5)
		report_append(text, size,
		              wait->for_preempted_ns > wait->for_off_ns / 2 ? " but had lost the CPU for %s"
		                                                            : " but slept for %s",
		              ui_profiler_time_text(part, sizeof part, wait->for_off_ns));
	if (wait->after_ns >= wait->total_ns / 5)
		report_append(text, size, "; %s %swent on %s after that", in->snapshot->lanes[wait->lane].name,
		              wait->after_lost_ns > wait->after_ns / 2 ? "had lost the CPU itself and " : "",
		              ui_profiler_time_text(part, sizeof part, wait->after_ns));
}

/* Writes the sentence about the longest wait, for example
 * "In record, main waited 3.10 ms for worker 1, which was in record segment but had lost the CPU for 2.80 ms." */
static void report_say_wait(const report_input *in)
{
	ui_profiler_report *report = &in->data->report;
	const ui_profiler_wait *wait = &report->wait;
	char *text = report->wait_text;
	size_t size = sizeof report->wait_text;
	char total[32], part[32];
	text[0] = 0;
	if (wait->lane == STILB_PROF_NONE) {
		report_append(text, size, "No thread was held up for longer than %s.",
		              ui_profiler_time_text(part, sizeof part, report_threshold(in)));
		return;
	}
	const char *who = in->snapshot->lanes[wait->lane].name;
	ui_profiler_time_text(total, sizeof total, wait->total_ns);
	if (wait->in_label != STILB_PROF_NONE && (!wait->preempted || wait->count == 1))
		report_append(text, size, "In %s, ", report_label(in, wait->in_label));
	if (wait->preempted)
		report_append(text, size, "%s lost the CPU to other threads for %s", who, total);
	else if (wait->label == STILB_PROF_NONE)
		report_append(text, size, "%s slept %s%s", who, total,
		              report->limit == UI_PROFILER_LIMIT_GPU ? " while the GPU was busy" : "");
	else if (wait->for_lane != STILB_PROF_NONE)
		report_append(text, size, "%s waited %s for %s%s", who, total,
		              in->snapshot->lanes[wait->for_lane].kind == STILB_PROF_LANE_DEVICE ? "the " : "",
		              in->snapshot->lanes[wait->for_lane].name);
	else if (ui_profiler_presents(report_label(in, wait->label)))
		report_append(text, size, "%s waited %s for the display", who, total);
	else if (strncmp(report_label(in, wait->label), "wait for ", 9) == 0)
		report_append(text, size, "%s waited %s for %s", who, total, report_label(in, wait->label) + 9);
	else
		report_append(text, size, "%s waited %s (%s)", who, total, report_label(in, wait->label));
	if (wait->count > 1)
		report_append(text, size, " in %u pieces", wait->count);
	if (wait->preempted && wait->count > 1)
		report_append(text, size, ", %s of it at once%s%s",
		              ui_profiler_time_text(part, sizeof part, wait->end_ns - wait->begin_ns),
		              wait->in_label == STILB_PROF_NONE ? "" : " in ",
		              wait->in_label == STILB_PROF_NONE ? "" : report_label(in, wait->in_label));
	if (wait->for_label != STILB_PROF_NONE)
		report_say_other(in, text, size);
	report_append(text, size, ".");
}

/* ---- counters ---------------------------------------------------------------------------------------------------- */

/* The counter of a label: that of an earlier label with the same name, or a new one. */
static uint32_t counter_find(ui_profiler_data *data, const stilb_prof_snapshot *snapshot, uint32_t label)
{
	const char *name = snapshot->labels[label].name;
	uint32_t i = 0;
	while (i < data->counter_count && strcmp(snapshot->labels[data->counters[i].label].name, name) != 0)
		i++;
	if (i == data->counter_count)
		data->counters[data->counter_count++] =
			(ui_profiler_counter){.label = label, .minimum = (double)INFINITY, .maximum = -(double)INFINITY};
	STILB_ASSERT(data->counter_count <= snapshot->label_count);
	return i;
}

/* True for points that are drawn: values of counters other than NaN and infinity. */
static bool counter_has(const stilb_prof_point *point)
{
	return point->counter && isfinite(point->value);
}

/* Groups the points by counter: counts them, then gives each counter its part of data->points. The points of a counter
 * ascend by time because the snapshot's do. */
static void report_collect_counters(ui_profiler_data *data, const stilb_prof_snapshot *snapshot)
{
	data->counter_count = 0;
	for (uint32_t i = 0; i < snapshot->label_count; i++)
		data->counter_of[i] = STILB_PROF_NONE;
	for (uint32_t i = 0; i < snapshot->point_count; i++) {
		const stilb_prof_point *point = &snapshot->points[i];
		if (!counter_has(point))
			continue;
		uint32_t *of = &data->counter_of[point->label];
		if (*of == STILB_PROF_NONE)
			*of = counter_find(data, snapshot, point->label);
		ui_profiler_counter *counter = &data->counters[*of];
		counter->count++;
		counter->minimum = fmin(counter->minimum, point->value);
		counter->maximum = fmax(counter->maximum, point->value);
	}
	for (uint32_t i = 0, first = 0; i < data->counter_count; i++) {
		data->counters[i].first = first;
		first += data->counters[i].count;
		data->counters[i].count = 0;
	}
	for (uint32_t i = 0; i < snapshot->point_count; i++)
		if (counter_has(&snapshot->points[i])) {
			ui_profiler_counter *counter = &data->counters[data->counter_of[snapshot->points[i].label]];
			data->points[counter->first + counter->count++] = i;
		}
}

/* ---- the report as a whole --------------------------------------------------------------------------------------- */

/* Makes *array, a pointer to elements of size bytes, hold count elements; their contents are lost. False: no memory. */
static bool report_reserve(void *array, uint32_t *capacity, uint32_t count, size_t size)
{
	void **pointer = array;
	if (*capacity >= count && *pointer)
		return true;
	free(*pointer);
	*capacity = count + 16;
	*pointer = malloc(*capacity * size);
	return *pointer;
}

static bool report_memory(ui_profiler_data *data, const stilb_prof_snapshot *snapshot)
{
	return report_reserve(&data->lanes, &data->capacity[0], snapshot->lane_count, sizeof *data->lanes) &&
	       report_reserve(&data->lane_ns, &data->capacity[1], snapshot->lane_count, sizeof *data->lane_ns) &&
	       report_reserve(&data->kinds, &data->capacity[2], snapshot->label_count, sizeof *data->kinds) &&
	       report_reserve(&data->label_ns, &data->capacity[3], snapshot->label_count, sizeof *data->label_ns) &&
	       report_reserve(&data->counters, &data->capacity[4], snapshot->label_count, sizeof *data->counters) &&
	       report_reserve(&data->counter_of, &data->capacity[5], snapshot->label_count, sizeof *data->counter_of) &&
	       report_reserve(&data->points, &data->capacity[6], snapshot->point_count, sizeof *data->points);
}

/* For STILB_CHECK: the lane's zones are as prof_snapshot.h promises: ascending, parents before children, subtrees
 * within their parents', labels in range; and its switches (times off the CPU) ascend. */
static bool lane_is_sound(const stilb_prof_snapshot *snapshot, const stilb_prof_lane *lane)
{
	for (uint32_t i = 0; i < lane->zone_count; i++) {
		const stilb_prof_zone *zone = &lane->zones[i];
		if (zone->label >= snapshot->label_count || zone->size == 0 || zone->size > lane->zone_count - i ||
		    zone->end_ns < zone->begin_ns || (i > 0 && zone->begin_ns < zone[-1].begin_ns))
			return false;
		if (zone->parent != STILB_PROF_NONE &&
		    (zone->parent >= i || i + zone->size > zone->parent + lane->zones[zone->parent].size))
			return false;
	}
	for (uint32_t i = 1; i < lane->switch_count; i++)
		if (lane->switches[i].out_ns < lane->switches[i - 1].in_ns)
			return false;
	return true;
}

static bool snapshot_is_sound(const stilb_prof_snapshot *snapshot)
{
	for (uint32_t i = 0; i < snapshot->lane_count; i++)
		if (!lane_is_sound(snapshot, &snapshot->lanes[i]))
			return false;
	for (uint32_t i = 0; i < snapshot->point_count; i++)
		if (snapshot->points[i].label >= snapshot->label_count ||
		    (i > 0 && snapshot->points[i].ns < snapshot->points[i - 1].ns))
			return false;
	return true;
}

bool ui_profiler_data_build(ui_profiler_data *data, const stilb_prof_snapshot *snapshot, uint32_t frame)
{
	STILB_ASSERT(frame < snapshot->frame_count);
	STILB_CHECK(snapshot_is_sound(snapshot));
	report_input in = {data, snapshot, snapshot->frames[frame].begin_ns, snapshot->frames[frame].end_ns,
	                   STILB_PROF_NONE};
	STILB_ASSERT(in.begin_ns <= in.end_ns);
	ui_profiler_report *report = &data->report;
	if (!report_memory(data, snapshot))
		return false;
	for (uint32_t i = 0; i < snapshot->label_count; i++)
		data->kinds[i] = (uint8_t)ui_profiler_kind_of(snapshot->labels[i].name);
	for (uint32_t i = 0; i < snapshot->lane_count; i++)
		report_sum_lane(&in, &snapshot->lanes[i], &data->lanes[i]);
	*report = (ui_profiler_report){
		.frame = frame, .stage_label = STILB_PROF_NONE, .wait = {.lane = STILB_PROF_NONE}, .lane = STILB_PROF_NONE};
	report_collect_counters(data, snapshot);
	report_count_events(&in);
	report_find_lane(&in);
	uint32_t device = report_find_device(&in, &report->gpu_ns);
	if (report->lane != STILB_PROF_NONE) {
		report_find_stage(&in);
		report_find_limit(&in, device);
		report_find_wait(&in, device);
	}
	report_say_verdict(&in);
	report_say_wait(&in);
	return true;
}

void ui_profiler_data_finish(ui_profiler_data *data)
{
	free(data->lanes);
	free(data->lane_ns);
	free(data->kinds);
	free(data->label_ns);
	free(data->counters);
	free(data->counter_of);
	free(data->points);
	*data = (ui_profiler_data){0};
}
