/* The asserts of the user interface, each made to fail on purpose; and damaged draw lists and snapshots, which must
 * fail their checks (STILB_CHECK). */
#include "support/contract.h"
#include "support/test.h"
#include "ui/ui_internal.h"
#include "ui/ui_profiler.h"
#include "ui/ui_profiler_internal.h"

#include <math.h>
#include <pthread.h>

static const stilb_ui_input nothing_done = {.width = 640.0f, .height = 480.0f, .seconds = 0.01f};
static const stilb_ui_rect place = {10.0f, 10.0f, 200.0f, 40.0f};

static stilb_ui *make(void)
{
	stilb_ui_desc desc = stilb_ui_desc_default();
	stilb_ui *ui;
	assert_int_equal(stilb_ui_create(&desc, &ui), STILB_OK);
	return ui;
}

static void *begin(void *ui)
{
	stilb_ui_begin(ui, &nothing_done);
	return NULL;
}

/* Draws a label in a frame that another thread has begun. */
static void label_beside_another_thread(stilb_ui *ui)
{
	pthread_t thread;
	assert_int_equal(pthread_create(&thread, NULL, begin, ui), 0);
	pthread_join(thread, NULL);
	stilb_ui_label(ui, place, STILB_UI_ALIGN_LEFT, "mine");
}

static void begin_backwards_in_time(stilb_ui *ui)
{
	stilb_ui_begin(ui, &(stilb_ui_input){.width = 640.0f, .height = 480.0f, .seconds = -1.0f});
}

static void frames(void **state)
{
	(void)state;
	stilb_ui *ui = make();
	contract_breaks("between begin and end", stilb_ui_label(ui, place, STILB_UI_ALIGN_LEFT, "early"));
	contract_breaks("called on the owner's thread", label_beside_another_thread(ui));
	contract_breaks("input->seconds >= 0.0f", begin_backwards_in_time(ui));
	contract_breaks("STILB_UI_TEXT_KINDS", stilb_ui_font_get(ui, STILB_UI_TEXT_KINDS));
	contract_breaks("STILB_UI_AA_OFF", stilb_ui_aa_set(ui, (stilb_ui_aa)7));
	stilb_ui_begin(ui, &nothing_done);
	contract_breaks("after end", stilb_ui_begin(ui, &nothing_done));
	contract_breaks("after end", stilb_ui_destroy(ui));
	contract_breaks("an id was pushed", stilb_ui_id_pop(ui));
	contract_breaks("a panel has begun", stilb_ui_panel_end(ui));
	contract_breaks("a clip was pushed", stilb_ui_clip_pop(stilb_ui_list(ui)));
	stilb_ui_id_push(ui, "left open");
	contract_breaks("every id was popped", stilb_ui_end(ui));
	stilb_ui_id_pop(ui);
	stilb_ui_clip_push(stilb_ui_list(ui), place);
	contract_breaks("every clip was popped", stilb_ui_end(ui));
	stilb_ui_clip_pop(stilb_ui_list(ui));
	stilb_ui_end(ui);
	stilb_ui_destroy(ui);
}

static void draw_row_out_of_sight(stilb_ui *ui)
{
	stilb_ui_list_state state = {.selected = STILB_UI_NO_ROW};
	stilb_ui_rows rows = stilb_ui_rows_begin(ui, place, "rows", 100, &state);
	stilb_ui_row(ui, &rows, rows.end);
}

static void widgets(void **state)
{
	(void)state;
	stilb_ui *ui = make();
	const stilb_ui_column columns[] = {{"a", 20.0f, STILB_UI_ALIGN_LEFT}, {"b", 0.0f, STILB_UI_ALIGN_LEFT}};
	stilb_ui_sort sort = {.column = 2};
	stilb_ui_rect rect = place;
	float value = 0.0f;
	stilb_ui_begin(ui, &nothing_done);
	contract_breaks("label", stilb_ui_button(ui, place, NULL));
	contract_breaks("STILB_UI_TAKES_FOCUS", stilb_ui_area(ui, "area", place, 64));
	contract_breaks("STILB_UI_PANEL_RESIZABLE", stilb_ui_panel_begin(ui, "panel", &rect, 64, NULL));
	contract_breaks("value && range", stilb_ui_slider(ui, place, "slider", &value, NULL));
	contract_breaks("range->minimum <= range->maximum",
	                stilb_ui_slider(ui, place, "slider", &value, &(stilb_ui_slider_range){.minimum = 1.0f}));
	contract_breaks("a visible row", draw_row_out_of_sight(ui));
	contract_breaks("column < column_count", stilb_ui_table_cell(place, columns, 2, 2));
	contract_breaks("sort->column < column_count", stilb_ui_table_header(ui, place, "table", columns, 2, &sort));
	contract_breaks("values || count == 0", stilb_ui_plot(ui, place, "plot", NULL, 3, 0.0f, 1.0f));
	stilb_ui_end(ui);
	stilb_ui_destroy(ui);
}

static void damage_index(stilb_ui *ui)
{
	stilb_ui_list(ui)->indices[1] = stilb_ui_list(ui)->vertex_count;
	stilb_ui_end(ui);
}

static void damage_command(stilb_ui *ui)
{
	stilb_ui_list(ui)->commands[0].index_count -= 3;
	stilb_ui_end(ui);
}

static void draw_lists(void **state)
{
	(void)state;
	stilb_ui *ui = make();
	const stilb_ui_font *font = stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL);
	stilb_ui_draw_list unbegun = {0}, *list = stilb_ui_list(ui);
	const stilb_ui_point two[2] = {{0.0f, 0.0f}, {9.0f, 9.0f}};
	stilb_ui_color white = stilb_ui_rgb(0xffffff);
	contract_breaks("the list has begun", stilb_ui_draw_rect(&unbegun, place, white));
	contract_breaks("width >= 0.0f", stilb_ui_list_begin(&unbegun, NAN, 1.0f));
	stilb_ui_begin(ui, &nothing_done);
	contract_breaks("count >= 3", stilb_ui_draw_convex(list, two, 2, white));
	contract_breaks("points || count == 0", stilb_ui_draw_polyline(list, NULL, 2, false, 1.0f, white));
	contract_breaks("isfinite (x)", stilb_ui_draw_text_at(list, font, NAN, 20.0f, white, "text"));
	stilb_ui_draw_rect(list, place, white);
	contract_breaks("ui_list_is_sound", damage_index(ui));
	contract_breaks("ui_list_is_sound", damage_command(ui));
	stilb_ui_end(ui);
	stilb_ui_destroy(ui);
}

static void *freeze(void *profiler)
{
	stilb_ui_profiler_freeze(profiler, true);
	return NULL;
}

static void freeze_on_another_thread(stilb_ui_profiler *profiler)
{
	pthread_t thread;
	assert_int_equal(pthread_create(&thread, NULL, freeze, profiler), 0);
	pthread_join(thread, NULL);
}

static int take_nothing(void *user, stilb_prof_snapshot *snapshot, const stilb_prof_window *window)
{
	(void)user, (void)snapshot, (void)window;
	return 0;
}

static void profiler_windows(void **state)
{
	(void)state;
	stilb_ui_profiler *profiler, *other;
	contract_breaks("take and frames come together",
	                stilb_ui_profiler_create(&(stilb_ui_profiler_desc){.take = take_nothing}, &other));
	assert_int_equal(stilb_ui_profiler_create(NULL, &profiler), STILB_OK);
	contract_breaks("called on the owner's thread", freeze_on_another_thread(profiler));
	contract_breaks("a frame is shown", ui_profiler_fit_frame(profiler));
	stilb_ui_profiler_destroy(profiler);
}

/* Builds the data of a snapshot with one lane, a frame with two zones in it, of which zone number `at` is `damaged`. */
static void build_with(stilb_prof_zone damaged, uint32_t at)
{
	stilb_prof_zone zones[3] = {
		{.begin_ns = 0, .end_ns = 1000, .parent = STILB_PROF_NONE, .size = 3},
		{.begin_ns = 100, .end_ns = 200, .parent = 0, .size = 1, .level = 1},
		{.begin_ns = 300, .end_ns = 400, .parent = 0, .size = 1, .level = 1},
	};
	stilb_prof_label label = {.name = "work", .function = "", .file = ""};
	stilb_prof_frame frame = {.begin_ns = 0, .end_ns = 1000};
	stilb_prof_lane lane = {.name = "main", .zones = zones, .zone_count = 3};
	stilb_prof_snapshot snapshot = {.labels = &label,
	                                .lanes = &lane,
	                                .frames = &frame,
	                                .label_count = 1,
	                                .lane_count = 1,
	                                .frame_count = 1,
	                                .end_ns = 1000};
	if (at < 3)
		zones[at] = damaged;
	ui_profiler_data data = {0};
	assert_true(ui_profiler_data_build(&data, &snapshot, at == 4));
	ui_profiler_data_finish(&data);
}

static void snapshots(void **state)
{
	(void)state;
	stilb_prof_frame_stats history = {.count = 3};
	stilb_prof_lane lane = {.name = "main"};
	stilb_prof_zone good = {.begin_ns = 300, .end_ns = 400, .parent = 0, .size = 1, .level = 1}, bad = good;
	ui_profiler_spans spans = {0};
	build_with(good, 3);
	contract_breaks("frame < snapshot->frame_count", build_with(good, 4));
	bad.label = 1;
	contract_breaks("snapshot_is_sound", build_with(bad, 2));
	bad = good;
	bad.parent = 2;
	contract_breaks("snapshot_is_sound", build_with(bad, 2));
	bad = good;
	bad.begin_ns = 50;
	contract_breaks("snapshot_is_sound", build_with(bad, 2));
	bad = good;
	bad.size = 2;
	contract_breaks("snapshot_is_sound", build_with(bad, 2));
	contract_breaks("index < history->count", ui_profiler_frame_number(&history, 3));
	contract_breaks("history->count > 0", ui_profiler_slowest(&(stilb_prof_frame_stats){0}));
	contract_breaks("narrow_ns >= 0.0", ui_profiler_spans_build(&spans, &lane, 0, 1, -1.0));
	contract_breaks("begin_ns <= end_ns", ui_profiler_spans_build(&spans, &lane, 2, 1, 1.0));
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(frames),           cmocka_unit_test(widgets),   cmocka_unit_test(draw_lists),
		cmocka_unit_test(profiler_windows), cmocka_unit_test(snapshots),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
