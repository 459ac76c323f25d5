/* The lower part of the profiler's window: a lane for each thread and device, and the counters; time from left to
 * right. */
#include "ui/ui_internal.h"
#include "ui/ui_profiler_internal.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TIMELINE_MAX_DEPTH 10u    /* levels of nested zones that are drawn in a lane */
#define TIMELINE_GROUND 0x1d232cu /* background of the lanes, 0xRRGGBB */
#define TIMELINE_NARROW 2.0f      /* pixels: narrower zones are merged with their neighbours */
#define TIMELINE_TEXT 30.0f       /* pixels: a narrower zone gets no name */
#define TIMELINE_FLOWS 24u        /* if more arrows of jobs are visible, only those of the hovered zone are drawn */
#define TIMELINE_LOST 220.0f      /* pixels: a wider time without the CPU gets the words "lost the CPU" */
#define TIMELINE_FRAME 8.0f       /* pixels: frames narrower than that get no boundaries */
#define TIMELINE_PART 200u        /* parts of a lane's time under a 200th of the frame are not named */
#define TIMELINE_GAP 8.0f         /* pixels between the names and the lanes */
#define TIMELINE_STRIP 4.0f       /* pixels: height of the bar below a lane's zones that shows when its thread ran */
#define TIMELINE_MIN_NS 100.0     /* shortest time that the lanes can be zoomed to show, nanoseconds */
#define TIMELINE_MAX_NS 60.0e9    /* longest one */

/* The state of drawing the lanes once. */
typedef struct timeline {
	stilb_ui_profiler *profiler;
	stilb_ui *ui;
	stilb_ui_draw_list *list;
	const stilb_ui_style *style;
	const stilb_prof_snapshot *snapshot;
	const stilb_ui_font *font, *small, *strong;
	stilb_ui_rect ruler, names, area; /* the times at the top, the lanes' names at the left, the lanes */
	double begin_ns, pixels_per_ns;   /* begin_ns: the time at the area's left edge; pixels_per_ns > 0 */
	float level;                      /* height of a level of zones, pixels */
	stilb_ui_action action;           /* what the user does with the area */
	uint32_t hot_lane;                /* lane of the span under the mouse, or STILB_PROF_NONE */
	ui_profiler_span hot;             /* that span, if there is one */
} timeline;

/* ---- layout ------------------------------------------------------------------------------------------------------ */

/* Levels of the lane's zones, TIMELINE_MAX_DEPTH at most; 0: it has none. */
static uint32_t timeline_depth(const stilb_prof_lane *lane)
{
	uint32_t depth = 0;
	for (uint32_t i = 0; i < lane->zone_count; i++)
		if (lane->zones[i].level >= depth)
			depth = lane->zones[i].level + 1u;
	return depth < TIMELINE_MAX_DEPTH ? depth : TIMELINE_MAX_DEPTH;
}

/* Threads first, then devices. A lane whose zones were nested more deeply in the frame shown before keeps that depth,
 * so that the picture does not jump from frame to frame. */
bool ui_profiler_layout_lanes(stilb_ui_profiler *profiler)
{
	const stilb_prof_snapshot *snapshot = profiler->snapshot;
	STILB_ASSERT(snapshot && "a snapshot is shown");
	if (profiler->row_capacity < snapshot->lane_count) {
		ui_profiler_row *grown = realloc(profiler->rows, (snapshot->lane_count + 8) * sizeof *grown);
		if (!grown)
			return false;
		profiler->rows = grown;
		profiler->row_capacity = snapshot->lane_count + 8;
	}
	bool same = profiler->lane_count == snapshot->lane_count;
	uint32_t before = profiler->row_count;
	uint32_t count = 0;
	for (int kind = STILB_PROF_LANE_THREAD; kind <= STILB_PROF_LANE_DEVICE; kind++)
		for (uint32_t i = 0; i < snapshot->lane_count; i++) {
			uint32_t depth = (int)snapshot->lanes[i].kind == kind ? timeline_depth(&snapshot->lanes[i]) : 0;
			if (depth == 0)
				continue;
			ui_profiler_row *row = &profiler->rows[count];
			bool stays = same && count < before && row->lane == i;
			if (stays && row->depth > depth)
				depth = row->depth;
			profiler->rows[count++] = (ui_profiler_row){.lane = i, .depth = depth, .lines = stays ? row->lines : 0};
		}
	STILB_ASSERT(count <= profiler->row_capacity);
	profiler->row_count = count;
	profiler->lane_count = snapshot->lane_count;
	return true;
}

static float timeline_level(const stilb_ui *ui)
{
	return stilb_ui_font_line(stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL)) + 1.0f;
}

/* Width of the column of lanes' names, pixels: wide enough for two parts of a lane's time side by side, as in the text
 * below. */
static float timeline_names_width(const stilb_ui *ui)
{
	const stilb_ui_font *small = stilb_ui_font_get(ui, STILB_UI_TEXT_SMALL);
	return floorf(stilb_ui_text_width(small, "work 000.00 ms, wait 000.00 ms,") + 12.0f);
}

/* The parts of the lane's time in the frame that are long enough to be named; returns how many. */
static uint32_t timeline_parts(const stilb_ui_profiler *profiler, const ui_profiler_row *row,
                               ui_profiler_part parts[UI_PROFILER_PARTS])
{
	STILB_ASSERT(row->lane < profiler->snapshot->lane_count);
	const stilb_prof_frame *frame = ui_profiler_frame(profiler);
	return ui_profiler_parts(profiler->snapshot->lanes[row->lane].kind, &profiler->data.lanes[row->lane],
	                         (frame->end_ns - frame->begin_ns) / TIMELINE_PART, parts);
}

/* Writes the text of each part of a lane's time and breaks the texts into lines of `width` pixels: lines[i] is the line
 * of texts[i], counted from 0. Returns the number of lines. */
static uint32_t timeline_lay_parts(const stilb_ui_font *font, float width, const ui_profiler_part *parts,
                                   uint32_t count, char texts[][48], uint32_t *lines)
{
	STILB_ASSERT(count <= UI_PROFILER_PARTS);
	float x = 0.0f;
	uint32_t line = 0;
	for (uint32_t i = 0; i < count; i++) {
		char time[32];
		snprintf(texts[i], sizeof texts[i], "%s %s%s", parts[i].name,
		         ui_profiler_time_text(time, sizeof time, parts[i].ns), i + 1 < count ? ", " : "");
		float w = stilb_ui_text_width(font, texts[i]);
		if (i > 0 && x + w > width) {
			x = 0.0f;
			line++;
		}
		lines[i] = line;
		x += w;
	}
	return line + 1;
}

/* Pixels that a lane needs with the gap below it: the height of its zones or of its lines of text, whichever is more. A
 * lane that had more lines in an earlier frame keeps their height, so that the picture does not jump. */
static float timeline_row_height(const stilb_ui_profiler *profiler, const stilb_ui *ui, ui_profiler_row *row)
{
	ui_profiler_part parts[UI_PROFILER_PARTS];
	char texts[UI_PROFILER_PARTS][48];
	uint32_t places[UI_PROFILER_PARTS];
	float level = timeline_level(ui), levels = (float)row->depth * level;
	uint32_t count = timeline_parts(profiler, row, parts);
	uint32_t lines = timeline_lay_parts(stilb_ui_font_get(ui, STILB_UI_TEXT_SMALL), timeline_names_width(ui), parts,
	                                    count, texts, places);
	row->lines = lines > row->lines ? lines : row->lines;
	float words = level + (float)row->lines * (level - 3.0f) + 3.0f;
	return (levels > words ? levels : words) + TIMELINE_STRIP + 10.0f;
}

float ui_profiler_timeline_height(stilb_ui_profiler *profiler, const stilb_ui *ui)
{
	float height = timeline_level(ui);
	for (uint32_t i = 0; profiler->snapshot && i < profiler->row_count; i++) {
		profiler->rows[i].height = timeline_row_height(profiler, ui, &profiler->rows[i]);
		height += profiler->rows[i].height;
	}
	return profiler->snapshot ? height + ui_profiler_counters_height(profiler, timeline_level(ui)) : height;
}

/* ---- time -------------------------------------------------------------------------------------------------------- */

/* The x at which a time is drawn, and below the reverse, the time that is drawn at an x. */
static float timeline_x(const timeline *t, double ns)
{
	return t->area.x0 + (float)((ns - t->begin_ns) * t->pixels_per_ns);
}

static double timeline_ns(const timeline *t, float x)
{
	STILB_ASSERT(t->pixels_per_ns > 0.0);
	return t->begin_ns + (double)(x - t->area.x0) / t->pixels_per_ns;
}

/* The x range of begin_ns..end_ns, clipped to the area and 4 pixels beyond it, so that borders at the clipped ends are
 * not visible. False: no part of it is visible. */
static bool timeline_clip_x(const timeline *t, uint64_t begin_ns, uint64_t end_ns, float *x0, float *x1)
{
	*x0 = timeline_x(t, (double)begin_ns);
	*x1 = timeline_x(t, (double)end_ns);
	if (*x1 < t->area.x0 || *x0 > t->area.x1)
		return false;
	*x0 = *x0 > t->area.x0 - 4.0f ? *x0 : t->area.x0 - 4.0f;
	*x1 = *x1 < t->area.x1 + 4.0f ? *x1 : t->area.x1 + 4.0f;
	return true;
}

/* The time between the ruler's marks: the first of 1, 2, 5, 10, 20, ... ns that is at least that many pixels wide. */
static double timeline_step(const timeline *t, double pixels)
{
	static const double FACTORS[] = {1.0, 2.0, 5.0};
	double decade = 1.0;
	while (decade < 1e12 && decade * FACTORS[2] * t->pixels_per_ns < pixels)
		decade *= 10.0;
	for (int i = 0; i < 2; i++)
		if (decade * FACTORS[i] * t->pixels_per_ns >= pixels)
			return decade * FACTORS[i];
	return decade * FACTORS[2];
}

/* The width of the stripes in the background, a power of ten of nanoseconds: 1 ms, but longer if that were under 8
 * pixels and shorter if a tenth of it has 64 pixels or more. */
static double timeline_bar(const timeline *t)
{
	double bar = 1e6;
	while (bar * t->pixels_per_ns < 8.0)
		bar *= 10.0;
	while (bar > 1.0 && bar * 0.1 * t->pixels_per_ns >= 64.0)
		bar *= 0.1;
	return bar;
}

/* The background: every other stripe is lighter, counted from the frame's begin. */
static void timeline_draw_bars(const timeline *t)
{
	double zero = (double)ui_profiler_frame(t->profiler)->begin_ns, bar = timeline_bar(t);
	double end = timeline_ns(t, t->area.x1);
	stilb_ui_draw_rect(t->list, t->area, stilb_ui_rgb(TIMELINE_GROUND));
	for (double n = floor((t->begin_ns - zero) / bar); zero + n * bar < end; n++) {
		if (fmod(n, 2.0) == 0.0)
			continue;
		stilb_ui_rect rect = {timeline_x(t, zero + n * bar), t->area.y0, timeline_x(t, zero + (n + 1.0) * bar),
		                      t->area.y1};
		rect = stilb_ui_intersection(rect, t->area);
		stilb_ui_draw_rect(t->list, rect, stilb_ui_rgb(0x252c37));
	}
}

/* The times at the top, in milliseconds from the frame's begin, with as few decimals as tell the marks apart. */
static void timeline_draw_ruler(const timeline *t)
{
	double zero = (double)ui_profiler_frame(t->profiler)->begin_ns, step = timeline_step(t, 92.0);
	double end = timeline_ns(t, t->area.x1);
	int decimals = 0;
	for (double size = step * 1e-6; size < 0.999 && decimals < 6; size *= 10.0)
		decimals++;
	stilb_ui_clip_push(t->list, t->ruler);
	for (double n = floor((t->begin_ns - zero) / step); zero + n * step < end; n++) {
		char text[48];
		float x = floorf(timeline_x(t, zero + n * step));
		snprintf(text, sizeof text, "%.*f ms", decimals, n * step * 1e-6);
		stilb_ui_draw_rect(t->list, (stilb_ui_rect){x, t->ruler.y1 - 5.0f, x + 1.0f, t->ruler.y1},
		                   t->style->text_muted);
		if (x + 4.0f + stilb_ui_text_width(t->small, text) > t->ruler.x1)
			continue;
		stilb_ui_draw_text(t->list, t->small, (stilb_ui_rect){x + 4.0f, t->ruler.y0, x + 92.0f, t->ruler.y1},
		                   STILB_UI_ALIGN_LEFT, t->style->text_muted, text);
	}
	stilb_ui_clip_pop(t->list);
}

static void timeline_draw_boundary(const timeline *t, float x)
{
	x = floorf(x);
	if (x >= t->area.x0 && x < t->area.x1)
		stilb_ui_draw_rect(t->list, (stilb_ui_rect){x, t->area.y0, x + 1.0f, t->area.y1},
		                   stilb_ui_fade(t->style->text_strong, 0.75f));
}

/* Darkens the time before and after the frame that is shown, and draws a line at each boundary of a frame. */
static void timeline_draw_frames(const timeline *t)
{
	const stilb_prof_frame *shown = ui_profiler_frame(t->profiler);
	stilb_ui_color shadow = {8, 10, 14, 150};
	float x0 = timeline_x(t, (double)shown->begin_ns), x1 = timeline_x(t, (double)shown->end_ns);
	stilb_ui_rect before = t->area, after = t->area;
	before.x1 = x0;
	after.x0 = x1;
	stilb_ui_draw_rect(t->list, stilb_ui_intersection(before, t->area), shadow);
	stilb_ui_draw_rect(t->list, stilb_ui_intersection(after, t->area), shadow);
	for (uint32_t i = 0; i < t->snapshot->frame_count; i++) {
		const stilb_prof_frame *frame = &t->snapshot->frames[i];
		float begin = timeline_x(t, (double)frame->begin_ns), end = timeline_x(t, (double)frame->end_ns);
		if (frame == shown || end - begin > TIMELINE_FRAME) {
			timeline_draw_boundary(t, begin);
			timeline_draw_boundary(t, end);
		}
	}
}

/* ---- lanes ------------------------------------------------------------------------------------------------------- */

/* The y at which a level of nested zones begins; levels that are too deep to be drawn share that of the last one. */
static float timeline_y(const timeline *t, const ui_profiler_row *row, uint32_t level)
{
	STILB_ASSERT(row->depth > 0);
	level = level < row->depth ? level : row->depth - 1;
	return row->top + (float)level * t->level;
}

/* The row of a lane of the snapshot; NULL: it has no zones and is not drawn. */
static const ui_profiler_row *timeline_row_of(const timeline *t, uint32_t lane)
{
	for (uint32_t i = 0; i < t->profiler->row_count; i++)
		if (t->profiler->rows[i].lane == lane)
			return &t->profiler->rows[i];
	return NULL;
}

/* Appends to the text of size bytes and cuts it short at its end: names in a trace file may be of any length. */
__attribute__((format(printf, 3, 4))) static void timeline_say(char *text, size_t size, const char *format, ...)
{
	size_t length = strlen(text);
	STILB_ASSERT(length < size);
	va_list arguments;
	va_start(arguments, format);
	vsnprintf(text + length, size - length, format, arguments);
	va_end(arguments);
}

/* The lane's name, and below it the parts of its time, side by side as far as they fit. */
static void timeline_draw_name(const timeline *t, const ui_profiler_row *row)
{
	const stilb_prof_lane *lane = &t->snapshot->lanes[row->lane];
	ui_profiler_part parts[UI_PROFILER_PARTS];
	char texts[UI_PROFILER_PARTS][48];
	uint32_t lines[UI_PROFILER_PARTS];
	uint32_t count = timeline_parts(t->profiler, row, parts);
	timeline_lay_parts(t->small, t->names.x1 - t->names.x0, parts, count, texts, lines);
	stilb_ui_rect place = {t->names.x0, row->top, t->names.x1, row->top + t->level};
	stilb_ui_draw_text(t->list, t->strong, place, STILB_UI_ALIGN_LEFT, t->style->text_strong, lane->name);
	for (uint32_t i = 0; i < count; i++) {
		place.x0 = i > 0 && lines[i] == lines[i - 1] ? place.x0 : t->names.x0;
		place.y0 = row->top + t->level + (float)lines[i] * (t->level - 3.0f);
		place.y1 = place.y0 + t->level;
		stilb_ui_color color = parts[i].lost ? stilb_ui_rgb(UI_PROFILER_BAD) : t->style->text_muted;
		stilb_ui_draw_text(t->list, t->small, place, STILB_UI_ALIGN_LEFT, color, texts[i]);
		place.x0 += stilb_ui_text_width(t->small, texts[i]);
	}
}

/* A tooltip for the lane whose name is under the mouse: all parts of its time and their sum. */
static void timeline_tip_name(const timeline *t)
{
	stilb_ui_action action = stilb_ui_area(t->ui, "lane names", t->names, STILB_UI_TAKES_WHEEL);
	const stilb_prof_frame *frame = ui_profiler_frame(t->profiler);
	for (uint32_t i = 0; action.hovered && i < t->profiler->row_count; i++) {
		const ui_profiler_row *row = &t->profiler->rows[i];
		if (action.mouse_y < row->top || action.mouse_y >= row->top + row->height)
			continue;
		ui_profiler_part parts[UI_PROFILER_PARTS];
		char text[512], time[32];
		uint32_t count =
			ui_profiler_parts(t->snapshot->lanes[row->lane].kind, &t->profiler->data.lanes[row->lane], 0, parts);
		text[0] = '\0';
		timeline_say(text, sizeof text, "%s\tframe %llu", t->snapshot->lanes[row->lane].name,
		             (unsigned long long)frame->number);
		for (uint32_t p = 0; p < count; p++)
			timeline_say(text, sizeof text, "\n%s\t%s", parts[p].name,
			             ui_profiler_time_text(time, sizeof time, parts[p].ns));
		timeline_say(text, sizeof text, "\ntogether\t%s",
		             ui_profiler_time_text(time, sizeof time, frame->end_ns - frame->begin_ns));
		stilb_ui_tooltip(t->ui, text);
	}
}

/* Writes the words for a span (a zone, or several narrow ones merged) that is `width` pixels wide. */
static void timeline_span_text(const timeline *t, const ui_profiler_span *span, float width, char *text, size_t size)
{
	const char *name = t->snapshot->labels[span->label == STILB_PROF_NONE ? 0 : span->label].name;
	char time[32];
	if (span->label == STILB_PROF_NONE)
		snprintf(text, size, "%u zones", span->count);
	else if (span->count > 1)
		snprintf(text, size, "%s: %u zones", name, span->count);
	else if (width < 110.0f)
		snprintf(text, size, "%s", name);
	else
		snprintf(text, size, "%s  %s", name, ui_profiler_time_text(time, sizeof time, span->end_ns - span->begin_ns));
}

/* The translucent colour drawn over zones while their thread does not run. */
static stilb_ui_color timeline_shadow(bool preempted)
{
	return preempted ? (stilb_ui_color){100, 5, 10, 165} : (stilb_ui_color){8, 10, 14, 120};
}

/* The span's visible rectangle; empty if it is outside the area or too deep to be drawn. */
static stilb_ui_rect timeline_span_rect(const timeline *t, const ui_profiler_row *row, const ui_profiler_span *span)
{
	stilb_ui_rect rect = {0.0f, timeline_y(t, row, span->level), 0.0f,
	                      timeline_y(t, row, span->level) + t->level - 1.0f};
	if (span->level >= row->depth || !timeline_clip_x(t, span->begin_ns, span->end_ns, &rect.x0, &rect.x1))
		return (stilb_ui_rect){0};
	return rect;
}

static stilb_ui_color timeline_span_color(const timeline *t, const ui_profiler_row *row, const ui_profiler_span *span)
{
	STILB_ASSERT(span->zone < t->snapshot->lanes[row->lane].zone_count);
	uint32_t label = t->snapshot->lanes[row->lane].zones[span->zone].label;
	stilb_ui_color color = stilb_ui_rgb(t->profiler->colors.rgb[label]);
	if (span->count > 1)
		color = stilb_ui_mix(color, stilb_ui_rgb(TIMELINE_GROUND), 0.3f);
	if (t->profiler->hot_label != STILB_PROF_NONE && t->profiler->hot_label != label)
		color = stilb_ui_mix(color, stilb_ui_rgb(TIMELINE_GROUND), 0.7f);
	return color;
}

static void timeline_draw_span(timeline *t, const ui_profiler_row *row, const ui_profiler_span *span)
{
	stilb_ui_rect rect = timeline_span_rect(t, row, span);
	stilb_ui_color color = timeline_span_color(t, row, span);
	if (rect.x1 <= rect.x0)
		return;
	stilb_ui_rect reach = {rect.x0, rect.y0, rect.x1 + 1.0f, rect.y1};
	if (t->action.hovered && stilb_ui_contains(reach, t->action.mouse_x, t->action.mouse_y)) {
		t->hot_lane = row->lane;
		t->hot = *span;
		color = stilb_ui_mix(color, t->style->text_strong, 0.25f);
	}
	if (rect.x1 - rect.x0 > 4.0f)
		rect.x1 -= 1.0f; /* a gap between neighbours of one colour */
	stilb_ui_draw_rect(t->list, rect, color);
}

/* Draws the span's name, after the shadows of times off the CPU, in black or white, whichever is readable on the colour
 * below its first letters. */
static void timeline_draw_span_name(const timeline *t, const ui_profiler_row *row, const ui_profiler_span *span)
{
	const stilb_prof_lane *lane = &t->snapshot->lanes[row->lane];
	ui_profiler_kind kind = (ui_profiler_kind)t->profiler->data.kinds[lane->zones[span->zone].label];
	stilb_ui_rect place = timeline_span_rect(t, row, span);
	place.x0 = (place.x0 > t->area.x0 ? place.x0 : t->area.x0) + 4.0f;
	place.x1 = (place.x1 < t->area.x1 ? place.x1 : t->area.x1) - 3.0f;
	if (place.x1 - place.x0 < TIMELINE_TEXT)
		return;
	stilb_ui_color ground = timeline_span_color(t, row, span);
	uint64_t from = ui_profiler_whole_ns(timeline_ns(t, place.x0)),
			 to = ui_profiler_whole_ns(timeline_ns(t, place.x0 + TIMELINE_TEXT));
	uint64_t preempted;
	if (ui_profiler_off_cpu(lane, from, to, &preempted) > 0) {
		stilb_ui_color shadow = timeline_shadow(preempted > 0);
		ground = stilb_ui_mix(ground, (stilb_ui_color){shadow.r, shadow.g, shadow.b, 255}, (float)shadow.a / 255.0f);
	}
	stilb_ui_color color = kind == UI_PROFILER_IDLE ? t->style->text_muted : stilb_ui_text_color_on(ground);
	char text[128];
	timeline_span_text(t, span, place.x1 - place.x0, text, sizeof text);
	stilb_ui_draw_text(t->list, t->font, place, STILB_UI_ALIGN_LEFT, color, text);
}

/* A time without the CPU, from x0 to x1: darkens the zones, and the strip below them shows by its colour whether the
 * thread slept or lost the CPU to another thread. */
static void timeline_draw_off(const timeline *t, const ui_profiler_row *row, float x0, float x1, bool preempted)
{
	float strip = row->top + (float)row->depth * t->level;
	stilb_ui_rect zones = {x0, row->top, x1, strip - 1.0f}, below = {x0, strip, x1, strip + TIMELINE_STRIP};
	stilb_ui_draw_rect(t->list, zones, timeline_shadow(preempted));
	stilb_ui_draw_rect(t->list, below, stilb_ui_rgb(preempted ? UI_PROFILER_BAD : UI_PROFILER_PARKED));
	if (preempted && x1 - x0 > TIMELINE_LOST) {
		stilb_ui_rect place = {x0, zones.y1 - t->level, x1 - 6.0f, zones.y1};
		stilb_ui_draw_text(t->list, t->font, place, STILB_UI_ALIGN_RIGHT, t->style->text_strong, "lost the CPU");
	}
}

/* The strip below a lane's zones that shows when its thread ran, slept or lost the CPU, as far as that is known.
 * Neighbouring times of one kind less than a pixel apart are drawn as one: there may be thousands. */
static void timeline_draw_switches(const timeline *t, const ui_profiler_row *row)
{
	const stilb_prof_lane *lane = &t->snapshot->lanes[row->lane];
	float strip = row->top + (float)row->depth * t->level;
	float x0, x1, from = 0.0f, to = -1.0f; /* from..to: x range of the neighbours merged so far; to < from: none */
	bool preempted = false;
	if (lane->kind != STILB_PROF_LANE_THREAD || lane->no_switches ||
	    !timeline_clip_x(t, lane->switches_ns > t->snapshot->begin_ns ? lane->switches_ns : t->snapshot->begin_ns,
	                     t->snapshot->end_ns, &x0, &x1))
		return;
	stilb_ui_draw_rect(t->list, (stilb_ui_rect){x0, strip, x1, strip + TIMELINE_STRIP},
	                   stilb_ui_rgb(UI_PROFILER_RUNNING));
	for (uint32_t i = ui_profiler_switch_after(lane, ui_profiler_whole_ns(t->begin_ns)); i < lane->switch_count; i++) {
		const stilb_prof_switch *s = &lane->switches[i];
		if (!timeline_clip_x(t, s->out_ns, s->in_ns, &x0, &x1))
			break;
		if (to >= from && s->preempted == preempted && x0 - to < 1.0f) {
			to = x1;
			continue;
		}
		if (to >= from)
			timeline_draw_off(t, row, from, to, preempted);
		from = x0;
		to = x1;
		preempted = s->preempted;
	}
	if (to >= from)
		timeline_draw_off(t, row, from, to, preempted);
}

static void timeline_draw_lane(timeline *t, const ui_profiler_row *row)
{
	ui_profiler_spans *spans = &t->profiler->spans;
	uint64_t begin = ui_profiler_whole_ns(t->begin_ns), end = ui_profiler_whole_ns(timeline_ns(t, t->area.x1));
	if (end <= begin || !ui_profiler_spans_build(spans, &t->snapshot->lanes[row->lane], begin, end,
	                                             (double)TIMELINE_NARROW / t->pixels_per_ns))
		return;
	for (uint32_t i = 0; i < spans->count; i++)
		timeline_draw_span(t, row, &spans->spans[i]);
	timeline_draw_switches(t, row);
	for (uint32_t i = 0; i < spans->count; i++)
		timeline_draw_span_name(t, row, &spans->spans[i]);
}

/* ---- arrows and the longest wait --------------------------------------------------------------------------------- */

/* The x of a time, and the y of the middle of the innermost zone at that time: an end of an arrow. */
static stilb_ui_point timeline_point(const timeline *t, const ui_profiler_row *row, uint64_t ns)
{
	const stilb_prof_lane *lane = &t->snapshot->lanes[row->lane];
	uint32_t zone = ui_profiler_zone_at(lane, ns);
	uint32_t level = zone == STILB_PROF_NONE ? 0 : lane->zones[zone].level;
	return (stilb_ui_point){timeline_x(t, (double)ns), timeline_y(t, row, level) + 0.5f * t->level};
}

/* True if that lane and time are inside the span under the mouse. */
static bool timeline_hot_at(const timeline *t, uint32_t lane, uint64_t ns)
{
	return t->hot_lane == lane && ns >= t->hot.begin_ns && ns < t->hot.end_ns;
}

static bool timeline_flow_seen(const timeline *t, const stilb_prof_flow *flow)
{
	double begin = t->begin_ns, end = timeline_ns(t, t->area.x1);
	return flow->from_lane != STILB_PROF_NONE && flow->to_lane != STILB_PROF_NONE && flow->from_lane != flow->to_lane &&
	       (double)flow->to_ns >= begin && (double)flow->from_ns < end;
}

static void timeline_draw_flow(const timeline *t, const stilb_prof_flow *flow, bool hot)
{
	const ui_profiler_row *from = timeline_row_of(t, flow->from_lane), *to = timeline_row_of(t, flow->to_lane);
	if (from && to)
		stilb_ui_draw_arrow(t->list, timeline_point(t, from, flow->from_ns), timeline_point(t, to, flow->to_ns),
		                    hot ? 1.75f : 1.0f, 7.0f,
		                    stilb_ui_fade(stilb_ui_rgb(UI_PROFILER_FLOW), hot ? 1.0f : 0.55f));
}

/* Arrows from where a job was submitted to where it ran: all visible ones if they are few, else those of the span under
 * the mouse. */
static void timeline_draw_flows(const timeline *t)
{
	uint32_t seen = 0;
	for (uint32_t i = 0; i < t->snapshot->flow_count && seen <= TIMELINE_FLOWS; i++)
		seen += timeline_flow_seen(t, &t->snapshot->flows[i]);
	for (uint32_t i = 0; i < t->snapshot->flow_count; i++) {
		const stilb_prof_flow *flow = &t->snapshot->flows[i];
		bool hot = timeline_hot_at(t, flow->from_lane, flow->from_ns) || timeline_hot_at(t, flow->to_lane, flow->to_ns);
		if (timeline_flow_seen(t, flow) && (hot || seen <= TIMELINE_FLOWS))
			timeline_draw_flow(t, flow, hot);
	}
}

/* Marks the longest wait: an outline around it, one around the same time in the lane that was waited for, and an arrow
 * between the two at the wait's end. */
static void timeline_draw_wait(const timeline *t)
{
	const ui_profiler_wait *wait = &t->profiler->data.report.wait;
	const ui_profiler_row *row = wait->lane == STILB_PROF_NONE ? NULL : timeline_row_of(t, wait->lane);
	stilb_ui_color color = stilb_ui_rgb(UI_PROFILER_ATTENTION);
	float x0, x1;
	if (!row || !timeline_clip_x(t, wait->begin_ns, wait->end_ns, &x0, &x1))
		return;
	uint32_t zone = ui_profiler_zone_at(&t->snapshot->lanes[wait->lane], wait->begin_ns);
	uint32_t level = zone == STILB_PROF_NONE ? 0 : t->snapshot->lanes[wait->lane].zones[zone].level;
	float y = timeline_y(t, row, level);
	stilb_ui_draw_rounded_outline(t->list, (stilb_ui_rect){x0 - 1.0f, y - 1.0f, x1 + 1.0f, y + t->level}, 2.0f, 2.0f,
	                              color);
	const ui_profiler_row *other = wait->for_lane == STILB_PROF_NONE ? NULL : timeline_row_of(t, wait->for_lane);
	if (!other)
		return;
	stilb_ui_rect lane = {x0 - 1.0f, other->top - 1.0f, x1 + 1.0f, other->top + (float)other->depth * t->level};
	stilb_ui_draw_rounded_outline(t->list, lane, 2.0f, 1.0f, stilb_ui_fade(color, 0.8f));
	float from = other->top > y ? lane.y0 : lane.y1, to = other->top > y ? y + t->level + 1.0f : y - 2.0f;
	if (x1 < t->area.x1)
		stilb_ui_draw_arrow(t->list, (stilb_ui_point){x1 - 4.0f, from}, (stilb_ui_point){x1 - 4.0f, to}, 1.5f, 8.0f,
		                    color);
}

/* ---- the mouse --------------------------------------------------------------------------------------------------- */

/* Zooms in by that many notches of 1.25 (out if negative). The time at `share` of the width, 0..1, stays where it is.
 */
static void timeline_zoom(stilb_ui_profiler *profiler, double notches, double share)
{
	double span = profiler->view_ns * pow(1.25, -notches);
	span = span < TIMELINE_MIN_NS ? TIMELINE_MIN_NS : span > TIMELINE_MAX_NS ? TIMELINE_MAX_NS : span;
	profiler->view_begin_ns += share * (profiler->view_ns - span);
	profiler->view_ns = span;
}

/* The wheel zooms about the mouse and dragging pans; with the focus, the arrow keys do both. */
static void timeline_navigate(timeline *t)
{
	stilb_ui_profiler *profiler = t->profiler;
	const uint8_t *keys = stilb_ui_input_get(t->ui)->keys;
	double width = (double)(t->area.x1 - t->area.x0);
	if (t->action.wheel != 0.0f)
		timeline_zoom(profiler, (double)t->action.wheel, (double)(t->action.mouse_x - t->area.x0) / width);
	if (t->action.held)
		profiler->view_begin_ns -= (double)t->action.drag_x * profiler->view_ns / width;
	ui_profiler_freeze_key(profiler, t->ui, &t->action);
	if (!t->action.focused)
		return;
	timeline_zoom(profiler, (double)keys[STILB_UI_KEY_UP] - (double)keys[STILB_UI_KEY_DOWN], 0.5);
	profiler->view_begin_ns +=
		((double)keys[STILB_UI_KEY_RIGHT] - (double)keys[STILB_UI_KEY_LEFT]) * 0.1 * profiler->view_ns;
}

/* If the lanes do not all fit into the area, dragging scrolls them up and down. */
static void timeline_scroll(timeline *t)
{
	stilb_ui_profiler *profiler = t->profiler;
	float most = t->area.y0 - t->area.y1 + ui_profiler_counters_height(profiler, t->level);
	for (uint32_t i = 0; i < profiler->row_count; i++)
		most += profiler->rows[i].height;
	profiler->scroll -= t->action.held ? t->action.drag_y : 0.0f;
	profiler->scroll = profiler->scroll > most ? most : profiler->scroll;
	profiler->scroll = profiler->scroll < 0.0f ? 0.0f : floorf(profiler->scroll);
}

/* The row of the zone table with this label and kind of lane: how often such zones were recorded in the frame and for
 * how long. NULL: the table has none. */
static const stilb_prof_row *timeline_label_row(const timeline *t, uint32_t label, stilb_prof_lane_kind kind)
{
	const stilb_prof_stats *stats = &t->profiler->stats;
	for (uint32_t i = 0; i < stats->row_count; i++)
		if (stats->rows[i].label == label && stats->rows[i].kind == kind)
			return &stats->rows[i];
	return NULL;
}

/* The arrow of the job that ran in the zone under the mouse: the one that ends in that zone itself, not in a zone
 * nested in it. NULL: there is none. */
static const stilb_prof_flow *timeline_job_of(const timeline *t)
{
	STILB_ASSERT(t->hot_lane < t->snapshot->lane_count);
	const stilb_prof_lane *lane = &t->snapshot->lanes[t->hot_lane];
	for (uint32_t i = 0; i < t->snapshot->flow_count; i++) {
		const stilb_prof_flow *flow = &t->snapshot->flows[i];
		if (timeline_hot_at(t, flow->to_lane, flow->to_ns) && flow->from_lane != STILB_PROF_NONE &&
		    ui_profiler_zone_at(lane, flow->to_ns) == t->hot.zone)
			return flow;
	}
	return NULL;
}

/* The tooltip's text for a single zone. */
static void timeline_tip_zone(const timeline *t, char *text, size_t size)
{
	const stilb_prof_lane *lane = &t->snapshot->lanes[t->hot_lane];
	const stilb_prof_zone *zone = &lane->zones[t->hot.zone];
	const stilb_prof_label *label = &t->snapshot->labels[zone->label];
	const stilb_prof_row *row = timeline_label_row(t, zone->label, lane->kind);
	const stilb_prof_flow *job = timeline_job_of(t);
	char time[32], off[32] = "not known";
	text[0] = '\0';
	timeline_say(text, size, "%s\t%s", label->name, lane->name);
	ui_profiler_time_text(time, sizeof time, zone->end_ns - zone->begin_ns);
	timeline_say(text, size, "\ntime\t%s%s", time, zone->open ? " so far" : "");
	timeline_say(text, size, "\nself\t%s", ui_profiler_time_text(time, sizeof time, zone->self_ns));
	if (!lane->no_switches && zone->begin_ns >= lane->switches_ns)
		ui_profiler_time_text(off, sizeof off, zone->off_cpu_ns);
	if (lane->kind == STILB_PROF_LANE_THREAD)
		timeline_say(text, size, "\noff the CPU\t%s", off);
	if (row)
		timeline_say(text, size, "\nin this frame\t%u, %s together", row->calls,
		             ui_profiler_time_text(time, sizeof time, row->inclusive_ns));
	if (job)
		timeline_say(text, size, "\nsubmitted\t%s before, by %s",
		             ui_profiler_time_text(time, sizeof time, job->to_ns - job->from_ns),
		             t->snapshot->lanes[job->from_lane].name);
	if (label->file[0]) {
		const char *slash = strrchr(label->file, '/');
		timeline_say(text, size, "\n%s:%u", slash ? slash + 1 : label->file, label->line);
	}
}

static void timeline_tip(const timeline *t)
{
	char text[512], time[32];
	if (t->hot_lane == STILB_PROF_NONE)
		return;
	if (t->hot.count > 1)
		snprintf(text, sizeof text, "%u zones, too narrow to be drawn\t%s\nlongest\t%s\nzoom in with the wheel",
		         t->hot.count, ui_profiler_time_text(time, sizeof time, t->hot.end_ns - t->hot.begin_ns),
		         t->snapshot->labels[t->snapshot->lanes[t->hot_lane].zones[t->hot.zone].label].name);
	else
		timeline_tip_zone(t, text, sizeof text);
	stilb_ui_tooltip(t->ui, text);
}

static void timeline_double_click(const timeline *t)
{
	if (t->hot_lane != STILB_PROF_NONE)
		ui_profiler_fit(t->profiler, t->hot.begin_ns, t->hot.end_ns);
	else
		ui_profiler_fit_frame(t->profiler);
}

/* ---- the timeline ------------------------------------------------------------------------------------------------ */

static timeline timeline_begin(stilb_ui_profiler *profiler, stilb_ui *ui, stilb_ui_rect area)
{
	timeline t = {.profiler = profiler,
	              .ui = ui,
	              .list = stilb_ui_list(ui),
	              .style = stilb_ui_style_get(ui),
	              .snapshot = profiler->snapshot,
	              .font = stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL),
	              .small = stilb_ui_font_get(ui, STILB_UI_TEXT_SMALL),
	              .strong = stilb_ui_font_get(ui, STILB_UI_TEXT_STRONG),
	              .level = timeline_level(ui),
	              .hot_lane = STILB_PROF_NONE};
	t.ruler = stilb_ui_cut_top(&area, t.level);
	t.names = stilb_ui_cut_left(&area, timeline_names_width(ui));
	stilb_ui_cut_right(&t.names, TIMELINE_GAP);
	t.ruler.x0 = area.x0;
	t.area = area;
	return t;
}

/* Sets the y of each row; returns the y at which the counters begin. */
static float timeline_place_rows(timeline *t)
{
	float y = t->area.y0 + 4.0f - t->profiler->scroll;
	for (uint32_t i = 0; i < t->profiler->row_count; i++) {
		t->profiler->rows[i].top = y;
		y += t->profiler->rows[i].height;
	}
	return y;
}

static void timeline_draw_cursor(const timeline *t)
{
	float x = floorf(t->action.mouse_x);
	if (t->action.hovered)
		stilb_ui_draw_rect(t->list, (stilb_ui_rect){x, t->area.y0, x + 1.0f, t->area.y1},
		                   stilb_ui_fade(t->style->text_strong, 0.35f));
}

void ui_profiler_draw_timeline(stilb_ui_profiler *profiler, stilb_ui *ui, stilb_ui_rect area)
{
	timeline t = timeline_begin(profiler, ui, area);
	if (stilb_ui_is_empty(t.area))
		return;
	t.action = stilb_ui_area(ui, "lanes", t.area, STILB_UI_TAKES_WHEEL | STILB_UI_TAKES_KEYS);
	timeline_navigate(&t);
	timeline_scroll(&t);
	t.begin_ns = (double)ui_profiler_frame(profiler)->begin_ns + profiler->view_begin_ns;
	t.pixels_per_ns = (double)(t.area.x1 - t.area.x0) / profiler->view_ns;
	float counters = timeline_place_rows(&t);
	ui_profiler_view view = {t.names, t.area, t.begin_ns, t.pixels_per_ns, t.level, t.action};
	timeline_draw_bars(&t);
	timeline_draw_ruler(&t);
	stilb_ui_clip_push(t.list, (stilb_ui_rect){t.names.x0, t.area.y0, t.area.x1, t.area.y1});
	for (uint32_t i = 0; i < profiler->row_count; i++)
		timeline_draw_name(&t, &profiler->rows[i]);
	ui_profiler_draw_counters(profiler, ui, &view, counters);
	stilb_ui_clip_push(t.list, t.area);
	for (uint32_t i = 0; i < profiler->row_count; i++)
		timeline_draw_lane(&t, &profiler->rows[i]);
	timeline_draw_frames(&t);
	timeline_draw_flows(&t);
	timeline_draw_wait(&t);
	timeline_draw_cursor(&t);
	ui_draw_focus(ui, t.area, 0.0f, &t.action);
	stilb_ui_clip_pop(t.list);
	stilb_ui_clip_pop(t.list);
	timeline_tip_name(&t);
	timeline_tip(&t);
	if (t.action.double_clicked)
		timeline_double_click(&t);
}
