/* ui: the profiler's window used with mouse and keys while frames go by, on snapshots made by hand and without a
 * renderer. */
#include "support/test.h"
#include "test_ui_profiler_made.h"
#include "test_ui_raster.h"
#include "ui/ui_internal.h"
#include "ui/ui_profiler_internal.h"

#include <errno.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>

#define FRAMES 300u

/* ---- allocations are counted ------------------------------------------------------------------------------------- */

static uint32_t allocations;

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *memory, size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *memory, size_t size);

void *__wrap_malloc(size_t size)
{
	allocations++;
	return __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size)
{
	allocations++;
	return __real_calloc(count, size);
}

void *__wrap_realloc(void *memory, size_t size)
{
	allocations++;
	return __real_realloc(memory, size);
}

/* ---- the profiled program ---------------------------------------------------------------------------------------- */

/* Frames of 10 ms, frame 60 of 30 ms; each has record and, in it, a wait for the worker. */
static made *recorded;
static uint64_t latest;         /* the last whole frame so far */
static uint64_t oldest;         /* the oldest frame that can still be taken */
static bool out_of_memory;      /* the next calls of `take` fail */
static stilb_prof_window asked; /* the frames that the last call of `take` asked for */
static uint32_t takes;

static void record_frames(void)
{
	double at = 0.0;
	recorded = made_new();
	for (uint32_t i = 0; i < FRAMES; i++) {
		double length = i == 60 ? 30000.0 : 10000.0;
		made_frame(recorded, i, at, at + length);
		at += length;
	}
	made_lane(recorded, "main", STILB_PROF_LANE_THREAD);
	for (uint32_t i = 0; i < FRAMES; i++) {
		double begin = (double)recorded->frames[i].begin_ns * 1e-3, end = (double)recorded->frames[i].end_ns * 1e-3;
		made_zone(recorded, 0, "frame", begin, end);
		made_zone(recorded, 1, "cull", begin, begin + 2000.0);
		made_zone(recorded, 1, "record", begin + 2000.0, end);
		made_zone(recorded, 2, "wait for workers", end - 3000.0, end);
	}
	made_lane(recorded, "worker 1", STILB_PROF_LANE_THREAD);
	for (uint32_t i = 0; i < FRAMES; i++)
		made_zone(recorded, 0, "job", (double)recorded->frames[i].end_ns * 1e-3 - 4000.0,
		          (double)recorded->frames[i].end_ns * 1e-3);
	recorded->snapshot.end_ns = made_ns(at);
}

static int take(void *user, stilb_prof_snapshot *snapshot, const stilb_prof_window *window)
{
	assert_ptr_equal(user, &recorded);
	uint64_t first = window->first_frame, end = first + window->frame_count;
	takes++;
	asked = *window;
	*snapshot = recorded->snapshot;
	if (out_of_memory) {
		*snapshot = (stilb_prof_snapshot){0};
		return -ENOMEM;
	}
	if (window->last_frames > 0) {
		end = latest + 1;
		first = end > window->last_frames ? end - window->last_frames : 0;
	}
	end = end < latest + 1 ? end : latest + 1;
	first = first > oldest ? first : oldest;
	snapshot->frames = recorded->frames + first;
	snapshot->frame_count = end > first ? (uint32_t)(end - first) : 0;
	return 0;
}

static void frames(void *user, stilb_prof_frame_stats *stats, double budget_ms)
{
	assert_ptr_equal(user, &recorded);
	*stats = (stilb_prof_frame_stats){.last = latest, .p50_ms = 10.0, .p99_ms = 10.0, .mean_ms = 10.0};
	stats->count = latest + 1 < STILB_PROF_STATS_FRAMES ? (uint32_t)latest + 1 : STILB_PROF_STATS_FRAMES;
	stats->limit_ms = budget_ms > 20.0 ? budget_ms : 20.0;
	for (uint32_t i = 0; i < stats->count; i++) {
		const stilb_prof_frame *frame = &recorded->frames[latest + 1 - stats->count + i];
		stats->ms[i] = (double)(frame->end_ns - frame->begin_ns) * 1e-6;
		stats->max_ms = stats->ms[i] > stats->max_ms ? stats->ms[i] : stats->max_ms;
	}
	stats->spike = stats->ms[stats->count - 1] > stats->limit_ms;
}

/* ---- the user ---------------------------------------------------------------------------------------------------- */

static stilb_ui *ui;
static stilb_ui_profiler *profiler;
static stilb_ui_input input;

static int set_up(void **state)
{
	(void)state;
	stilb_ui_desc desc = stilb_ui_desc_default();
	stilb_ui_profiler_desc profiler_desc = {.take = take, .frames = frames, .user = &recorded};
	record_frames();
	latest = 99;
	oldest = 0;
	out_of_memory = false;
	input = (stilb_ui_input){.width = 1280.0f, .height = 720.0f, .seconds = 1.0f};
	return stilb_ui_create(&desc, &ui) == STILB_OK && stilb_ui_profiler_create(&profiler_desc, &profiler) == STILB_OK
	           ? 0
	           : -1;
}

static int tear_down(void **state)
{
	(void)state;
	stilb_ui_profiler_destroy(profiler);
	stilb_ui_destroy(ui);
	free(recorded);
	return 0;
}

static void draw(void)
{
	stilb_ui_begin(ui, &input);
	stilb_ui_profiler_draw(profiler, ui);
	stilb_ui_end(ui);
	input.mouse_presses = 0;
	input.wheel = 0.0f;
	memset(input.keys, 0, sizeof input.keys);
}

static void point_at(float x, float y)
{
	input.mouse_present = true;
	input.mouse_x = x;
	input.mouse_y = y;
	draw(); /* a widget reacts to the mouse in the frame after the one that drew it */
	draw();
}

static void press(void)
{
	input.mouse_down = true;
	input.mouse_presses = 1;
	draw();
	input.mouse_down = false;
	draw();
}

static void key(stilb_ui_key which)
{
	input.keys[which] = 1;
	draw();
}

/* True if the tooltip's first entry is this text. Drawing it has replaced tabs and newlines by ends of strings. */
static bool tip_is(const char *text)
{
	return strcmp(ui->tooltip, text) == 0;
}

/* Moves the mouse upwards at x until a tooltip begins with the text, then from the left to the zone that shows it. */
static void find(float x, const char *any, const char *tip)
{
	float y = input.height;
	do {
		y -= 7.0f;
		assert_true(y > 0.0f);
		point_at(x, y);
	} while (strncmp(ui->tooltip, any, strlen(any)) != 0);
	for (x = 2.0f; !tip_is(tip); x += 3.0f) {
		assert_true(x < input.width);
		point_at(x, y);
	}
}

static void show_frames(uint64_t count)
{
	for (uint64_t i = 0; i < count; i++) {
		latest++;
		draw();
	}
}

/* ---- which frame ------------------------------------------------------------------------------------------------- */

static void test_slowest(void **state)
{
	(void)state;
	draw();
	assert_int_equal(profiler->number, 60);
	assert_int_equal(asked.first_frame, 59);
	assert_int_equal(asked.frame_count, 3);
	assert_string_equal(profiler->data.report.verdict, "CPU-limited: record decides, 28.00 ms of 30.00 ms.");
	assert_string_equal(profiler->data.report.wait_text,
	                    "In record, main waited 3.00 ms for worker 1, which was in job.");
	show_frames(60); /* 60 is the oldest frame of the history now */
	assert_int_equal(profiler->number, 60);
	show_frames(1);
	assert_int_equal(profiler->number, 160); /* of equally slow frames the latest */
}

/* While the same frame is shown, its snapshot is not taken again once the GPU's zones have arrived. */
static void test_takes(void **state)
{
	(void)state;
	latest = 60;
	draw();
	takes = 0;
	show_frames(30);
	assert_int_equal(profiler->number, 60);
	assert_in_range(takes, 3, 5);
	takes = 0;
	for (int i = 0; i < 10; i++)
		draw();
	assert_int_equal(takes, 0);
}

static void test_latest(void **state)
{
	(void)state;
	profiler->mode = UI_PROFILER_LATEST;
	draw();
	assert_int_equal(profiler->number, 99);
	show_frames(5);
	assert_int_equal(profiler->number, 104);
	stilb_ui_profiler_freeze(profiler, true);
	show_frames(5);
	assert_int_equal(profiler->number, 104);
	assert_int_equal(profiler->history.last, 104);
}

static void test_click_on_bar(void **state)
{
	(void)state;
	draw();
	find(500.0f, "frame ", "frame 77");
	press();
	draw();
	assert_true(stilb_ui_profiler_frozen(profiler));
	assert_int_equal(profiler->number, 77);
	show_frames(40); /* while frozen: the older frames can no longer be taken */
	assert_int_equal(profiler->history.last, 99);
	assert_int_equal(asked.first_frame, 0);
	assert_int_equal(asked.frame_count, 100);
	oldest = latest;
	for (uint64_t number = 76; number > 70; number--) {
		stilb_ui_profiler_show(profiler, number);
		draw();
		assert_int_equal(profiler->number, number);
	}
	oldest = 0;
	stilb_ui_profiler_freeze(profiler, false);
	draw();
	assert_int_equal(profiler->number, 60);
	assert_int_equal(profiler->history.last, latest);
}

/* The window as it is used over a trace file: a frame is chosen before the first draw, and it fills the picture. */
static void test_show(void **state)
{
	(void)state;
	profiler->desc.whole = true;
	stilb_ui_profiler_show(profiler, 30);
	draw();
	assert_int_equal(profiler->number, 30);
	assert_true(stilb_ui_profiler_frozen(profiler));
	point_at(640.0f, 30.0f);
	assert_true(stilb_ui_wants_mouse(ui));
	latest = 299;
	stilb_ui_profiler_freeze(profiler, false);
	draw();
	stilb_ui_profiler_show(profiler, 40); /* older than the history */
	for (int i = 0; i < 10; i++)
		draw();
	assert_non_null(profiler->snapshot);
	assert_int_equal(profiler->number, 40);
}

static void test_keys(void **state)
{
	(void)state;
	draw();
	for (int i = 0; i < 40 && profiler->number == 60;
	     i++) { /* Tab from widget to widget until the history has the keys */
		key(STILB_UI_KEY_TAB);
		key(STILB_UI_KEY_RIGHT);
		draw();
	}
	assert_int_equal(profiler->number, 61);
	key(STILB_UI_KEY_LEFT);
	key(STILB_UI_KEY_LEFT);
	draw();
	assert_int_equal(profiler->number, 59);
	assert_true(stilb_ui_profiler_frozen(profiler));
	key(STILB_UI_KEY_SPACE);
	assert_false(stilb_ui_profiler_frozen(profiler));
}

static void test_freeze_on_spike(void **state)
{
	(void)state;
	latest = 50;
	profiler->freeze_on_spike = true;
	show_frames(9);
	assert_false(stilb_ui_profiler_frozen(profiler));
	show_frames(1);
	assert_true(stilb_ui_profiler_frozen(profiler));
	stilb_ui_profiler_freeze(profiler, false); /* the same spike does not freeze twice */
	draw();
	assert_false(stilb_ui_profiler_frozen(profiler));
	latest = 59;
	draw();
	show_frames(1);
	show_frames(20);
	assert_true(stilb_ui_profiler_frozen(profiler));
	assert_int_equal(profiler->number, 60);
	assert_int_equal(profiler->history.last, 60);
}

/* ---- the lanes --------------------------------------------------------------------------------------------------- */

static double time_at(float x, float x0, float x1)
{
	return profiler->view_begin_ns + (double)(x - x0) / (double)(x1 - x0) * profiler->view_ns;
}

/* Moves the mouse to a zone of the lanes; returns their rectangle. */
static stilb_ui_rect find_lanes(void)
{
	find(700.0f, "record", "record");
	const ui_item *lanes = &ui->before.items[0];
	for (uint32_t i = 0; i < ui->before.count; i++)
		if (ui->before.items[i].id == ui->hot)
			lanes = &ui->before.items[i];
	return lanes->rect;
}

static void test_zoom_and_pan(void **state)
{
	(void)state;
	draw();
	stilb_ui_rect lanes = find_lanes();
	float x0 = lanes.x0, x1 = lanes.x1;
	double span = profiler->view_ns, at = time_at(input.mouse_x, x0, x1);
	input.wheel = 2.0f;
	draw();
	assert_true(fabs(profiler->view_ns - span / 1.5625) < 1.0);
	assert_true(fabs(time_at(input.mouse_x, x0, x1) - at) < 10.0);
	input.mouse_down = true;
	input.mouse_presses = 1;
	draw();
	input.mouse_x += 50.0f;
	draw();
	assert_true(fabs(time_at(input.mouse_x, x0, x1) - at) < 10.0);
	input.mouse_down = false;
	for (int i = 0; i < 200; i++) { /* zooming stops at a limit in both directions */
		input.wheel = 100.0f;
		draw();
	}
	assert_true(profiler->view_ns >= 100.0);
	for (int i = 0; i < 200; i++) {
		input.wheel = -100.0f;
		draw();
	}
	assert_true(profiler->view_ns <= 60e9);
}

/* The x of the next upright line of that colour from y0 to y1, one pixel wide, in the draw list from vertex *v on;
 * negative: there are no more. */
static float next_line(uint32_t *v, float y0, float y1, stilb_ui_color color)
{
	for (; *v + 4 <= ui->list.vertex_count; (*v)++) {
		const float *from = ui->list.vertices[*v].position, *to = ui->list.vertices[*v + 2].position;
		if (from[1] == y0 && to[1] == y1 && to[0] == from[0] + 1.0f &&
		    memcmp(ui->list.vertices[*v].color, &color, sizeof color) == 0)
			return ui->list.vertices[(*v)++].position[0];
	}
	return -1.0f;
}

/* The ruler has marks at every zoom, 92 pixels apart or up to 2.5 times that, as the steps go from 2 to 5. */
static void test_ruler(void **state)
{
	(void)state;
	draw();
	stilb_ui_rect lanes = find_lanes();
	stilb_ui_color color = stilb_ui_style_get(ui)->text_muted;
	for (double ns = 1e3; ns < 60e9; ns *= 1.7) {
		profiler->view_ns = ns;
		draw();
		uint32_t marks = 0;
		float last = 0.0f;
		for (uint32_t v = 0;; marks++) {
			float x = next_line(&v, lanes.y0 - 5.0f, lanes.y0, color);
			if (x < 0.0f)
				break;
			if (marks > 0)
				assert_true(x - last >= 91.0f && x - last <= 92.0f * 2.5f + 1.0f); /* they stand at whole pixels */
			last = x;
		}
		assert_true((float)marks >= floorf((lanes.x1 - lanes.x0) / (92.0f * 2.5f)));
	}
}

/* A line stands where the frame begins and where it ends. */
static void test_frame_boundaries(void **state)
{
	(void)state;
	draw();
	stilb_ui_rect lanes = find_lanes();
	stilb_ui_color color = stilb_ui_fade(stilb_ui_style_get(ui)->text_strong, 0.75f);
	double pixels_per_ns = (double)(lanes.x1 - lanes.x0) / profiler->view_ns;
	float begin = lanes.x0 - (float)(profiler->view_begin_ns * pixels_per_ns);
	float end = begin + (float)(30e6 * pixels_per_ns);
	bool begins = false, ends = false;
	for (uint32_t v = 0;;) {
		float x = next_line(&v, lanes.y0, lanes.y1, color);
		if (x < 0.0f)
			break;
		assert_true(x == floorf(begin) || x == floorf(end));
		begins |= x == floorf(begin);
		ends |= x == floorf(end);
	}
	assert_true(begins && ends);
}

/* A name that is longer than its zone ends 3 pixels before the zone does. */
static void test_names_end_in_their_zones(void **state)
{
	(void)state;
	recorded->labels[made_label(recorded, "job")].name = "iiiiiiiiiiiiiiiiiiiiiiiiiiiiiiiiiiiiiiiiiiiiiiiiiiiiiiiii";
	draw();
	stilb_ui_rect lanes = find_lanes();
	input.mouse_present = false; /* no tooltip */
	draw();
	for (double width = 60.0; width < 64.0; width += 0.5) {
		profiler->view_ns = (double)(lanes.x1 - lanes.x0) * 4e6 / width; /* the job takes 4 ms, up to the frame's end */
		profiler->view_begin_ns = 30e6 - 0.5 * profiler->view_ns;
		draw();
		float end = 0.5f * (lanes.x0 + lanes.x1), top = profiler->rows[1].top;
		float reached = 0.0f;
		for (uint32_t v = 0; v < ui->list.vertex_count; v++) {
			const stilb_render_vertex_2d *at = &ui->list.vertices[v];
			if (at->uv[0] != ui->list.vertices[0].uv[0] && at->position[0] > end - 60.0f &&
			    at->position[0] < end + 60.0f && at->position[1] > top &&
			    at->position[1] < top + profiler->rows[1].height)
				reached = fmaxf(reached, at->position[0]);
		}
		assert_true(reached > end - 10.0f && reached <= end - 2.0f); /* a letter's picture may end a pixel later */
	}
}

static void double_click(void)
{
	input.seconds = 0.05f;
	press();
	press();
}

static void test_double_click(void **state)
{
	(void)state;
	draw();
	find(700.0f, "record", "cull");
	double_click();
	assert_true(fabs(profiler->view_ns - 1.04 * 2e6) < 1.0);
	input.seconds = 1.0f;
	while (!tip_is("")) /* moves the mouse down to a place without a zone, which has no tooltip */
		point_at(input.mouse_x, input.mouse_y + 3.0f);
	double_click();
	assert_true(fabs(profiler->view_ns - 1.04 * 30e6) < 1.0);
}

/* The tooltip of merged zones gives their number. */
static void test_merged_tooltip(void **state)
{
	(void)state;
	draw();
	profiler->view_begin_ns = -1e9;
	profiler->view_ns = 6e9;
	for (float y = input.height; !strstr(ui->tooltip, " zones, too narrow"); y -= 5.0f) {
		assert_true(y > 0.0f);
		point_at(400.0f, y);
	}
}

static bool tip_says(const char *text)
{
	return memmem(ui->tooltip, sizeof ui->tooltip, text, strlen(text));
}

/* The tooltip of a job's zone gives the delay and the thread that submitted it; that of the submitting zone gives
 * neither. */
static void test_job_tooltip(void **state)
{
	(void)state;
	uint64_t end = recorded->frames[60].end_ns;
	recorded->flows[0] = (stilb_prof_flow){.id = 1, .from_ns = end - 9000000, .to_ns = end - 3999000, .to_lane = 1};
	recorded->snapshot.flow_count = 1;
	draw();
	find(input.width - 60.0f, "job", "job");
	assert_true(tip_says("submitted"));
	assert_true(tip_says("5.00 ms before, by main"));
	find(input.width - 60.0f, "record", "record");
	assert_false(tip_says("submitted"));
}

/* ---- lanes and counters ------------------------------------------------------------------------------------------ */

/* The tooltip of a lane's name gives the parts of its time, which add up to the frame. */
static void test_lane_tooltip(void **state)
{
	(void)state;
	draw();
	for (float y = input.height; !tip_says("main"); y -= 7.0f) {
		assert_true(y > 0.0f);
		point_at(30.0f, y);
	}
	assert_true(tip_says("frame 60") && tip_says("work") && tip_says("27.00 ms") && tip_says("wait") &&
	            tip_says("3.00 ms") && tip_says("together") && tip_says("30.00 ms"));
	assert_false(tip_says("outside zones"));
	recorded->zones[0][60 * 4].end_ns -= 7000000; /* shortens the frame's zone and those that would reach beyond it */
	for (uint32_t i = 60 * 4 + 1; i < 61 * 4; i++)
		recorded->zones[0][i].begin_ns = recorded->zones[0][i].end_ns = recorded->zones[0][60 * 4].begin_ns;
	profiler->held_number = UINT64_MAX;
	draw();
	draw();
	assert_true(tip_says("outside zones") && tip_says("7.00 ms") && tip_says("23.00 ms") && tip_says("30.00 ms"));
}

static void record_counters(void)
{
	uint32_t draws = made_label(recorded, "draws");
	for (uint32_t i = 0; i < FRAMES; i++)
		made_counter(recorded, 1, draws, (double)recorded->frames[i].begin_ns * 1e-3 + 5000.0, 1000.0 + i);
}

/* A counter's curve is drawn below the lanes, and the tooltip gives its value. */
static void test_counters(void **state)
{
	(void)state;
	draw();
	uint32_t without = ui->list.index_count;
	float height = ui_profiler_timeline_height(profiler, ui);
	record_counters();
	profiler->held_number = UINT64_MAX;
	draw();
	assert_int_equal(profiler->data.counter_count, 1);
	assert_true(ui->list.index_count > without);
	assert_true(ui_profiler_timeline_height(profiler, ui) > height);
	for (float y = input.height; !tip_says("draws"); y -= 5.0f) {
		assert_true(y > 0.0f);
		point_at(input.width - 60.0f, y);
	}
	assert_true(tip_says("1060") && tip_says("by worker 1"));
	float y = input.mouse_y;
	float x = 215.0f;
	for (; !tip_says("1059"); x -= 1.0f) /* before the frame's first value, the last one of the frame before holds */
		point_at(x, y);
	assert_true(x > 100.0f);
}

/* A counter's curve is drawn at heights in proportion to its values: the rectangles of the draw list show it. */
static void test_a_curve_is_as_high_as_its_values(void **state)
{
	(void)state;
	stilb_ui_rect area = {200.0f, 100.0f, 1200.0f, 300.0f};
	ui_profiler_view view = {{0.0f, 100.0f, 190.0f, 300.0f}, area, 0.0, 1e-5, 50.0f, {0}};
	uint32_t label = made_label(recorded, "steps");
	made_counter(recorded, 0, label, 10000.0, 100.0); /* x 300: from here on 100, the highest */
	made_counter(recorded, 0, label, 50000.0, 25.0);  /* x 700 */
	draw();
	stilb_ui_begin(ui, &input);
	ui->list.vertex_count = ui->list.index_count = 0;
	ui_profiler_draw_counters(profiler, ui, &view, 100.0f);
	stilb_ui_end(ui);
	bool full = false, quarter = false;
	for (uint32_t v = 0; v < ui->list.vertex_count; v++) {
		float x = ui->list.vertices[v].position[0], y = ui->list.vertices[v].position[1];
		full |= x == 300.0f && y == 100.0f;
		quarter |= x == 700.0f && y == 173.0f;  /* the row of pixels of 198.5 - 0.25 * 98.5 */
		assert_false(x > 192.0f && x < 299.0f); /* no curve before the first value */
	}
	assert_true(full);
	assert_true(quarter);
}

/* ---- opaque backgrounds ------------------------------------------------------------------------------------------ */

/* The picture of the window and a panel in front of it, on a background of that colour. */
static raster_picture on_ground(stilb_ui_color ground)
{
	raster_picture picture = raster_create(640, 360, (stilb_ui_color){0, 0, 0, 255});
	stilb_ui_rect place = {100.0f, 150.0f, 300.0f, 300.0f};
	input.width = 640.0f;
	input.height = 360.0f;
	stilb_ui_begin(ui, &input);
	stilb_ui_draw_rect(stilb_ui_list(ui), (stilb_ui_rect){0.0f, 0.0f, 640.0f, 360.0f}, ground);
	stilb_ui_profiler_draw(profiler, ui);
	stilb_ui_draw_rect(stilb_ui_list(ui), (stilb_ui_rect){90.0f, 140.0f, 310.0f, 310.0f}, ground);
	stilb_ui_panel_begin(ui, "Materials", &place, 0, NULL);
	stilb_ui_panel_end(ui);
	stilb_ui_end(ui);
	raster_draw(&picture, &ui->list, NULL);
	return picture;
}

static void assert_same_within(const raster_picture *a, const raster_picture *b, stilb_ui_rect rect)
{
	for (uint32_t y = (uint32_t)rect.y0; y < (uint32_t)rect.y1; y++)
		for (uint32_t x = (uint32_t)rect.x0; x < (uint32_t)rect.x1; x++)
			for (int c = 0; c < 3; c++)
				if (fabs(raster_at(a, x, y)[c] - raster_at(b, x, y)[c]) > 1e-12) /* more than rounding */
					fail_msg("at %u, %u: %g and %g", x, y, raster_at(a, x, y)[c], raster_at(b, x, y)[c]);
}

/* The background does not shine through the window, nor a rectangle in front of that through a panel. */
static void test_backgrounds_are_opaque(void **state)
{
	(void)state;
	raster_picture dark = on_ground((stilb_ui_color){0, 0, 0, 255});
	raster_picture bright = on_ground((stilb_ui_color){255, 255, 255, 255});
	assert_same_within(&dark, &bright,
	                   (stilb_ui_rect){105.0f, 155.0f, 295.0f, 295.0f}); /* without the rounded corners */
	assert_same_within(&dark, &bright, (stilb_ui_rect){320.0f, 20.0f, 620.0f, 340.0f});
	assert_true(fabs(raster_at(&dark, 95, 145)[0] - raster_at(&bright, 95, 145)[0]) >
	            0.1); /* beside the panel, the rectangle drawn behind it is seen */
	free(dark.rgb);
	free(bright.rgb);
}

/* Names in a trace file may be of any length. */
static void test_long_names(void **state)
{
	(void)state;
	static char name[5000], file[5000];
	memset(name, 'x', sizeof name - 1);
	memset(file, 'y', sizeof file - 1);
	stilb_prof_label *job = &recorded->labels[made_label(recorded, "job")];
	job->name = recorded->lanes[1].name = name;
	job->file = file;
	draw();
	find(input.width - 60.0f, "xxx", ui->tooltip);
	assert_in_range(strlen(ui->tooltip), 100, sizeof ui->tooltip - 1);
}

/* ---- what must not go wrong -------------------------------------------------------------------------------------- */

static void test_no_allocation(void **state)
{
	(void)state;
	for (int mode = UI_PROFILER_SLOWEST; mode <= UI_PROFILER_LATEST; mode++) {
		profiler->mode = (ui_profiler_mode)mode;
		point_at(700.0f, 600.0f);
		show_frames(10);
		allocations = 0;
		show_frames(50);
		assert_int_equal(allocations, 0);
	}
}

static void test_overwritten(void **state)
{
	(void)state;
	oldest = 80;
	draw();
	assert_null(profiler->snapshot);
	assert_true(ui->list.index_count > 0);
	profiler->mode = UI_PROFILER_LATEST;
	draw();
	assert_int_equal(profiler->number, 99);
}

static void test_out_of_memory(void **state)
{
	(void)state;
	out_of_memory = true;
	draw();
	assert_null(profiler->snapshot);
	out_of_memory = false;
	draw();
	assert_non_null(profiler->snapshot);
	assert_int_equal(profiler->number, 60);
}

/* Empty snapshots, snapshots without whole frames, and pictures of any size. */
static void test_little_room(void **state)
{
	(void)state;
	static const float SIZES[][2] = {{1, 1}, {50, 40}, {200, 1000}, {3000, 100}, {640, 360}};
	for (size_t i = 0; i < sizeof SIZES / sizeof *SIZES; i++) {
		input.width = SIZES[i][0];
		input.height = SIZES[i][1];
		point_at(input.width * 0.5f, input.height * 0.5f);
		double_click();
		profiler->desc.whole = !profiler->desc.whole;
		draw();
		for (uint32_t v = 0; v < ui->list.vertex_count; v++) {
			assert_true(isfinite(ui->list.vertices[v].position[0]));
			assert_true(isfinite(ui->list.vertices[v].position[1]));
		}
	}
	recorded->snapshot.lane_count = 0;
	input.width = 1280.0f;
	input.height = 720.0f;
	show_frames(10);
	profiler->mode = UI_PROFILER_LATEST;
	show_frames(2);
	assert_string_equal(profiler->data.report.verdict, "Nothing was recorded in this frame.");
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup_teardown(test_slowest, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_takes, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_latest, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_click_on_bar, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_show, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_keys, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_freeze_on_spike, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_zoom_and_pan, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_ruler, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_frame_boundaries, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_names_end_in_their_zones, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_double_click, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_merged_tooltip, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_job_tooltip, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_lane_tooltip, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_counters, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_a_curve_is_as_high_as_its_values, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_backgrounds_are_opaque, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_long_names, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_no_allocation, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_overwritten, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_out_of_memory, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_little_room, set_up, tear_down),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
