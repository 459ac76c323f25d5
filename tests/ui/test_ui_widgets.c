/* ui: what widgets return while a user moves the mouse, presses and types. */
#include "support/test.h"
#include "ui/ui_internal.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- memory ------------------------------------------------------------------------------------------------------ */

static uint64_t allocations;
static uint64_t failing; /* number, counted down from now, of the allocation that fails; 0: none fails */

static bool allocation_fails(void)
{
	allocations++;
	return failing > 0 && --failing == 0;
}

void *__real_malloc(size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_malloc(size_t size)
{
	return allocation_fails() ? NULL : __real_malloc(size);
}

void *__real_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size)
{
	return allocation_fails() ? NULL : __real_calloc(count, size);
}

void *__real_realloc(void *memory, size_t size);
void *__wrap_realloc(void *memory, size_t size);
void *__wrap_realloc(void *memory, size_t size)
{
	return allocation_fails() ? NULL : __real_realloc(memory, size);
}

/* ---- a user ------------------------------------------------------------------------------------------------------ */

typedef struct user {
	stilb_ui *ui;
	stilb_ui_input input;
	void (*screen)(stilb_ui *ui); /* draws the widgets under test */
} user;

static user user_create(void (*screen)(stilb_ui *ui))
{
	user u = {.screen = screen,
	          .input = {.width = 640, .height = 480, .mouse_present = true, .mouse_x = -1, .seconds = 1.0f / 60.0f}};
	stilb_ui_desc desc = stilb_ui_desc_default();
	assert_int_equal(stilb_ui_create(&desc, &u.ui), STILB_OK);
	return u;
}

static void user_frame(user *u)
{
	stilb_ui_begin(u->ui, &u->input);
	u->screen(u->ui);
	stilb_ui_end(u->ui);
	assert_false(stilb_ui_list(u->ui)->out_of_memory);
	u->input.mouse_presses = 0;
	u->input.wheel = 0.0f;
	memset(u->input.keys, 0, sizeof u->input.keys);
}

static void user_move(user *u, float x, float y)
{
	u->input.mouse_x = x;
	u->input.mouse_y = y;
	user_frame(u);
}

static void user_press(user *u)
{
	u->input.mouse_down = true;
	u->input.mouse_presses = 1;
	user_frame(u);
}

static void user_release(user *u)
{
	u->input.mouse_down = false;
	user_frame(u);
}

static void user_click(user *u, float x, float y)
{
	user_move(u, x, y);
	user_press(u);
	user_release(u);
}

static void user_key(user *u, stilb_ui_key key)
{
	u->input.keys[key] = 1;
	user_frame(u);
}

static void user_destroy(user *u)
{
	stilb_ui_destroy(u->ui);
}

/* ---- areas ------------------------------------------------------------------------------------------------------- */

static stilb_ui_action back, front; /* the actions on two overlapping areas that the last frame returned */
static const stilb_ui_rect back_rect = {100, 100, 300, 200}, front_rect = {200, 150, 400, 250};

static void two_areas(stilb_ui *ui)
{
	back = stilb_ui_area(ui, "back", back_rect, STILB_UI_TAKES_WHEEL);
	stilb_ui_clip_push(stilb_ui_list(ui), (stilb_ui_rect){200, 150, 350, 250});
	front = stilb_ui_area(ui, "front", front_rect, 0);
	stilb_ui_clip_pop(stilb_ui_list(ui));
}

static void test_what_is_drawn_later_is_in_front(void **state)
{
	(void)state;
	user u = user_create(two_areas);
	user_move(&u, 150, 120);
	assert_false(back.hovered); /* the last frame had no areas */
	user_frame(&u);
	assert_true(back.hovered && !front.hovered && stilb_ui_wants_mouse(u.ui));
	user_move(&u, 250, 175); /* over both areas */
	assert_true(!back.hovered && front.hovered);
	user_move(&u, 375, 200); /* over a part of `front` that is clipped */
	assert_true(!back.hovered && !front.hovered && !stilb_ui_wants_mouse(u.ui));
	u.input.mouse_present = false;
	user_move(&u, 150, 120);
	assert_true(!back.hovered && !stilb_ui_wants_mouse(u.ui));
	user_destroy(&u);
}

static void test_press_drag_and_click(void **state)
{
	(void)state;
	user u = user_create(two_areas);
	user_frame(&u);
	user_move(&u, 150, 120);
	user_press(&u);
	assert_true(back.pressed && back.held && !back.clicked);
	assert_true(back.drag_x == 0.0f && back.total_x == 0.0f);
	user_move(&u, 160, 115);
	assert_true(!back.pressed && back.held && back.drag_x == 10.0f && back.drag_y == -5.0f);
	user_move(&u, 250, 175); /* over the other area, while the first is held */
	assert_true(back.held && back.drag_x == 90.0f && back.total_x == 100.0f && back.total_y == 55.0f);
	assert_true(!front.hovered && !front.held && stilb_ui_wants_mouse(u.ui));
	user_release(&u);
	assert_true(!back.held && !back.clicked && !front.clicked);
	user_click(&u, 150, 120);
	assert_true(back.clicked && back.hovered);
	user_frame(&u);
	assert_false(back.clicked);
	/* Pressed elsewhere and released here: no click. */
	user_move(&u, 10, 10);
	user_press(&u);
	user_move(&u, 150, 120);
	assert_true(!back.held && !back.pressed);
	user_release(&u);
	assert_false(back.clicked);
	user_destroy(&u);
}

static void test_clicks_within_a_frame_count(void **state)
{
	(void)state;
	user u = user_create(two_areas);
	user_frame(&u);
	u.input.mouse_presses = 1; /* moved here, pressed and released since the last frame */
	user_move(&u, 150, 120);
	assert_true(back.pressed && back.clicked && !back.held);
	u.input.seconds = 1.0f;
	user_frame(&u);
	user_press(&u);
	u.input.mouse_presses = 1; /* released and pressed again since the last frame */
	user_frame(&u);
	assert_true(back.clicked && back.pressed && back.held);
	user_release(&u);
	assert_true(back.clicked);
	user_destroy(&u);
}

static void test_double_click(void **state)
{
	(void)state;
	user u = user_create(two_areas);
	user_frame(&u);
	user_click(&u, 150, 120);
	assert_false(back.double_clicked);
	user_press(&u);
	assert_true(back.double_clicked);
	user_release(&u);
	user_press(&u); /* the third press begins another double click */
	assert_false(back.double_clicked);
	user_release(&u);
	u.input.seconds = 2.0f; /* too long after the first press for a double click */
	user_press(&u);
	assert_false(back.double_clicked);
	user_release(&u);
	u.input.seconds = 0.01f;
	user_click(&u, 170, 120); /* too far from the next press for a double click */
	user_click(&u, 150, 120);
	assert_false(back.double_clicked);
	u.input.mouse_presses = 2; /* both presses in one frame */
	user_frame(&u);
	assert_true(back.double_clicked);
	user_destroy(&u);
}

static void test_wheel_goes_through_what_does_not_take_it(void **state)
{
	(void)state;
	user u = user_create(two_areas);
	user_frame(&u);
	u.input.wheel = 2.0f;
	user_move(&u, 250, 175);
	assert_true(front.hovered && front.wheel == 0.0f && back.wheel == 2.0f);
	u.input.wheel = 2.0f;
	user_move(&u, 10, 10);
	assert_true(back.wheel == 0.0f);
	user_destroy(&u);
}

/* ---- controls ---------------------------------------------------------------------------------------------------- */

static uint32_t presses[3];
static bool box, toggled;
static float value;
static uint32_t slid;
static stilb_ui_slider_range range;
static const stilb_ui_rect places[5] = {
	{10, 10, 100, 32}, {110, 10, 200, 32}, {210, 10, 300, 32}, {10, 50, 200, 72}, {10, 90, 218, 112}};

static void controls(stilb_ui *ui)
{
	presses[0] += stilb_ui_button(ui, places[0], "go##1");
	presses[1] += stilb_ui_button_rounded(ui, places[1], "go##2");
	presses[2] += stilb_ui_toggle(ui, places[2], "hold", &toggled);
	stilb_ui_checkbox(ui, places[3], "freeze", &box);
	slid += stilb_ui_slider(ui, places[4], "spike", &value, &range);
}

static user control_user(void)
{
	memset(presses, 0, sizeof presses);
	box = toggled = false;
	value = 0.0f;
	slid = 0;
	range = (stilb_ui_slider_range){.minimum = 0.0f, .maximum = 10.0f};
	user u = user_create(controls);
	user_frame(&u);
	return u;
}

static void test_buttons(void **state)
{
	(void)state;
	user u = control_user();
	user_click(&u, 20, 20);
	user_click(&u, 120, 20);
	user_click(&u, 120, 20);
	user_click(&u, 220, 20);
	assert_true(presses[0] == 1 && presses[1] == 2 && presses[2] == 1 && toggled);
	user_move(&u, 20, 20);
	user_press(&u);
	user_move(&u, 20, 300); /* released outside the button: not pressed */
	user_release(&u);
	assert_int_equal(presses[0], 1);
	user_click(&u, 15, 60);
	assert_true(box);
	user_click(&u, 15, 60);
	assert_false(box);
	user_destroy(&u);
}

static void test_slider(void **state)
{
	(void)state;
	user u = control_user();
	user_move(&u, 114, 100); /* the middle of the slider */
	user_press(&u);
	assert_float_equal(value, 5.0f, 0.05f);
	assert_int_equal(slid, 1);
	user_frame(&u); /* held without a movement: no change */
	assert_int_equal(slid, 1);
	user_move(&u, 600, 400); /* beyond the slider's right end */
	assert_true(value == 10.0f);
	user_release(&u);
	user_move(&u, 20, 100); /* released: the slider does not follow the mouse */
	assert_true(value == 10.0f);
	user_key(&u, STILB_UI_KEY_LEFT); /* the click has given it the focus; the key moves it by 1 % */
	assert_float_equal(value, 9.9f, 1e-4f);
	range.step = 2.5f;
	user_key(&u, STILB_UI_KEY_LEFT);
	assert_true(value == 7.5f);
	user_click(&u, 114, 100);
	assert_true(value == 5.0f);
	user_click(&u, 400, 400); /* a click elsewhere takes the focus away */
	user_key(&u, STILB_UI_KEY_LEFT);
	assert_true(value == 5.0f && !stilb_ui_wants_keys(u.ui));
	user_destroy(&u);
}

/* Knob and track are below the text, so that no value hides its own digits. */
static void test_slider_words_are_free(void **state)
{
	(void)state;
	user u = control_user();
	stilb_ui_color accent = stilb_ui_style_get(u.ui)->accent;
	for (value = range.minimum; value <= range.maximum; value += 0.5f) {
		user_frame(&u);
		const stilb_ui_draw_list *list = stilb_ui_list(u.ui);
		uint32_t knob = 0;
		for (uint32_t v = 0; v < list->vertex_count; v++) {
			const stilb_render_vertex_2d *at = &list->vertices[v];
			if (at->position[1] < places[4].y0 || memcmp(at->color, &accent, 3) != 0)
				continue;
			knob++;
			assert_true(at->position[1] > places[4].y1 - 8.0f);
		}
		assert_true(knob > 0);
	}
	user_destroy(&u);
}

static void muted_slider(stilb_ui *ui)
{
	slid += stilb_ui_slider_muted(ui, places[4], "spike", &value, &range);
}

/* A muted slider is moved like any other. */
static void test_slider_muted(void **state)
{
	(void)state;
	user u = control_user();
	u.screen = muted_slider;
	user_frame(&u);
	user_click(&u, 114, 100);
	assert_float_equal(value, 5.0f, 0.05f);
	assert_int_equal(slid, 1);
	user_destroy(&u);
}

static void test_keyboard(void **state)
{
	(void)state;
	user u = control_user();
	user_key(&u, STILB_UI_KEY_SPACE);
	assert_true(presses[0] == 0 && !stilb_ui_wants_keys(u.ui));
	user_key(&u, STILB_UI_KEY_TAB);
	assert_true(stilb_ui_wants_keys(u.ui));
	user_key(&u, STILB_UI_KEY_SPACE);
	user_key(&u, STILB_UI_KEY_ENTER);
	assert_int_equal(presses[0], 2);
	u.input.keys[STILB_UI_KEY_TAB] = 3; /* three times in one frame */
	user_frame(&u);
	user_key(&u, STILB_UI_KEY_SPACE);
	assert_true(box);
	user_key(&u, STILB_UI_KEY_TAB);
	user_key(&u, STILB_UI_KEY_RIGHT);
	assert_float_equal(value, 0.1f, 1e-6f);
	user_key(&u, STILB_UI_KEY_TAB); /* from the last widget to the first */
	user_key(&u, STILB_UI_KEY_SPACE);
	assert_int_equal(presses[0], 3);
	u.input.shift = true;
	user_key(&u, STILB_UI_KEY_TAB); /* from the first to the last */
	user_key(&u, STILB_UI_KEY_RIGHT);
	assert_float_equal(value, 0.2f, 1e-6f);
	user_key(&u, STILB_UI_KEY_ESCAPE);
	assert_false(stilb_ui_wants_keys(u.ui));
	user_key(&u, STILB_UI_KEY_TAB); /* backwards without a focus: the last widget */
	user_key(&u, STILB_UI_KEY_RIGHT);
	assert_float_equal(value, 0.3f, 1e-6f);
	user_destroy(&u);
}

static uint32_t nothing_drawn;
static void nothing(stilb_ui *ui)
{
	(void)ui;
	nothing_drawn++;
}

static void test_what_is_gone_has_no_keys(void **state)
{
	(void)state;
	user u = control_user();
	user_key(&u, STILB_UI_KEY_TAB);
	assert_true(stilb_ui_wants_keys(u.ui));
	u.screen = nothing;
	user_frame(&u);
	user_frame(&u);
	assert_false(stilb_ui_wants_keys(u.ui));
	user_key(&u, STILB_UI_KEY_TAB); /* no area takes keys */
	assert_true(!stilb_ui_wants_keys(u.ui) && stilb_ui_list(u.ui)->index_count == 0);
	user_destroy(&u);
}

/* ---- ids --------------------------------------------------------------------------------------------------------- */

static bool row_clicked[3];
static void rows_of_buttons(stilb_ui *ui)
{
	for (uint32_t i = 0; i < 3; i++) {
		stilb_ui_id_push_number(ui, i);
		stilb_ui_id_push(ui, "row");
		row_clicked[i] =
			stilb_ui_button(ui, (stilb_ui_rect){10, 10 + 30.0f * (float)i, 90, 30 + 30.0f * (float)i}, "x");
		stilb_ui_id_pop(ui);
		stilb_ui_id_pop(ui);
	}
}

static void test_equal_labels_with_pushed_ids(void **state)
{
	(void)state;
	user u = user_create(rows_of_buttons);
	user_frame(&u);
	user_click(&u, 20, 50);
	assert_true(!row_clicked[0] && row_clicked[1] && !row_clicked[2]);
	user_destroy(&u);
}

static void test_labels_hide_what_follows_two_signs(void **state)
{
	(void)state;
	assert_string_equal(ui_label_shown("go##1").text, "go");
	assert_string_equal(ui_label_shown("a#b").text, "a#b");
	assert_string_equal(ui_label_shown("##all").text, "");
	char longest[600];
	memset(longest, 'x', sizeof longest);
	longest[sizeof longest - 1] = 0;
	assert_int_equal(strlen(ui_label_shown(longest).text), 255);
}

/* ---- panels ------------------------------------------------------------------------------------------------------ */

static stilb_ui_rect panel_rect;
static bool panel_open;
static stilb_ui_rect content;
static stilb_ui_action behind;

static void panels(stilb_ui *ui)
{
	behind = stilb_ui_area(ui, "behind", (stilb_ui_rect){0, 0, 640, 480}, STILB_UI_TAKES_WHEEL);
	if (!panel_open)
		return;
	content =
		stilb_ui_panel_begin(ui, "panel", &panel_rect, STILB_UI_PANEL_MOVABLE | STILB_UI_PANEL_RESIZABLE, &panel_open);
	presses[0] += stilb_ui_button(ui, stilb_ui_cut_top(&content, 22), "go");
	stilb_ui_panel_end(ui);
}

static user panel_user(void)
{
	panel_rect = (stilb_ui_rect){100, 100, 400, 300};
	panel_open = true;
	presses[0] = 0;
	user u = user_create(panels);
	user_frame(&u);
	return u;
}

static void test_panels_stop_the_mouse(void **state)
{
	(void)state;
	user u = panel_user();
	u.input.wheel = 1.0f;
	user_move(&u, 200, 280);
	assert_true(!behind.hovered && behind.wheel == 0.0f && stilb_ui_wants_mouse(u.ui));
	u.input.wheel = 1.0f;
	user_move(&u, 50, 50);
	assert_true(behind.hovered && behind.wheel == 1.0f);
	user_click(&u, 150, 145);
	assert_int_equal(presses[0], 1);
	assert_true(content.x0 > 100 && content.x1 < 400 && content.y1 < 300);
	user_destroy(&u);
}

static void test_panels_move_and_grow(void **state)
{
	(void)state;
	user u = panel_user();
	user_move(&u, 200, 110);
	user_press(&u);
	user_move(&u, 230, 120);
	assert_true(panel_rect.x0 == 130 && panel_rect.y0 == 110 && panel_rect.x1 == 430 && panel_rect.y1 == 310);
	user_move(&u, 5000, -5000); /* the panel stays within the picture */
	assert_true(panel_rect.x1 == 640 && panel_rect.y0 == 0 && panel_rect.x0 == 340 && panel_rect.y1 == 200);
	user_release(&u);
	user_move(&u, 635, 195);
	user_press(&u);
	user_move(&u, 600, 250);
	assert_true(panel_rect.x0 == 340 && panel_rect.x1 == 605 && panel_rect.y1 == 255);
	user_move(&u, 0, 0); /* the panel keeps its smallest size */
	assert_true(panel_rect.x1 - panel_rect.x0 > 100 && panel_rect.y1 - panel_rect.y0 > 50);
	user_release(&u);
	user_destroy(&u);
}

static void test_panels_close(void **state)
{
	(void)state;
	user u = panel_user();
	user_click(&u, 387, 113);
	assert_false(panel_open);
	user_frame(&u);
	user_move(&u, 200, 200);
	assert_true(behind.hovered);
	user_destroy(&u);
}

/* ---- lists ------------------------------------------------------------------------------------------------------- */

static stilb_ui_list_state list_state;
static stilb_ui_rows rows;
static uint32_t row_count;
static float row_top; /* y of the first row drawn */

static void a_list(stilb_ui *ui)
{
	rows = stilb_ui_rows_begin(ui, (stilb_ui_rect){10, 10, 210, 100}, "list", row_count, &list_state);
	for (uint32_t row = rows.first; row < rows.end; row++) {
		stilb_ui_rect place = stilb_ui_row(ui, &rows, row);
		row_top = row == rows.first ? place.y0 : row_top;
		stilb_ui_label(ui, place, STILB_UI_ALIGN_LEFT, "row");
	}
	stilb_ui_rows_end(ui);
}

static user list_user(uint32_t count)
{
	list_state = (stilb_ui_list_state){.selected = STILB_UI_NO_ROW};
	row_count = count;
	user u = user_create(a_list);
	user_frame(&u);
	return u;
}

static void test_lists_show_and_scroll(void **state)
{
	(void)state;
	user u = list_user(100); /* rows of 18 pixels, of which five are visible */
	assert_true(rows.first == 0 && rows.end == 5 && row_top == 10);
	user_move(&u, 50, 50);
	assert_true(rows.hovered == 2 && rows.clicked == STILB_UI_NO_ROW);
	u.input.wheel = -2.0f;
	user_frame(&u);
	assert_true(rows.first == 6 && rows.end == 11 && list_state.scroll == 108.0f);
	u.input.wheel = -1000.0f;
	user_frame(&u);
	assert_true(rows.first == 95 && rows.end == 100);
	row_count = 3; /* shorter than the list's rectangle */
	user_frame(&u);
	assert_true(rows.first == 0 && rows.end == 3 && list_state.scroll == 0.0f);
	row_count = 0;
	user_frame(&u);
	assert_true(rows.first == 0 && rows.end == 0 && rows.hovered == STILB_UI_NO_ROW);
	user_destroy(&u);
}

static void test_lists_select(void **state)
{
	(void)state;
	user u = list_user(100);
	user_move(&u, 50, 50);
	user_press(&u);
	assert_true(rows.clicked == 2 && rows.changed && list_state.selected == 2 && rows.selected == 2);
	user_release(&u);
	user_press(&u);
	assert_true(rows.clicked == 2 && !rows.changed);
	user_release(&u);
	u.input.keys[STILB_UI_KEY_DOWN] = 5;
	user_frame(&u);
	assert_true(list_state.selected == 7 && rows.changed && rows.first <= 7 && rows.end > 7);
	assert_true(list_state.scroll == 8 * 18.0f - 90.0f); /* scrolled as little as shows row 7 */
	u.input.keys[STILB_UI_KEY_UP] = 200;
	user_frame(&u);
	assert_true(list_state.selected == 0 && list_state.scroll == 0.0f);
	row_count = 0;
	user_key(&u, STILB_UI_KEY_DOWN);
	assert_int_equal(list_state.selected, STILB_UI_NO_ROW);
	user_destroy(&u);
}

static void test_lists_have_a_bar(void **state)
{
	(void)state;
	user u = list_user(100);
	user_move(&u, 206, 15); /* on the thumb, which is at the top */
	user_press(&u);
	assert_true(list_state.scroll == 0.0f && list_state.selected == STILB_UI_NO_ROW);
	user_move(&u, 206, 52);
	assert_true(list_state.scroll > 700.0f && list_state.scroll < 1000.0f);
	user_move(&u, 206, 500);
	assert_true(list_state.scroll == 1800.0f - 90.0f);
	user_release(&u);
	user_move(&u, 206, 55); /* beside the thumb, which jumps to the mouse */
	user_press(&u);
	assert_float_equal(list_state.scroll, 855.0f, 20.0f);
	user_release(&u);
	user_destroy(&u);
}

static stilb_ui_sort sort;
static uint32_t sorted;
static const stilb_ui_column columns[3] = {
	{"zone", 0, STILB_UI_ALIGN_LEFT}, {"calls", 50, STILB_UI_ALIGN_RIGHT}, {"self", 60, STILB_UI_ALIGN_RIGHT}};

static void a_table(stilb_ui *ui)
{
	sorted += stilb_ui_table_header(ui, (stilb_ui_rect){0, 0, 308, 20}, "table", columns, 3, &sort);
	stilb_ui_table_header(ui, (stilb_ui_rect){0, 100, 308, 120}, "fixed", columns, 3, NULL);
}

static void test_tables_sort(void **state)
{
	(void)state;
	sort = (stilb_ui_sort){0, false};
	sorted = 0;
	user u = user_create(a_table);
	user_frame(&u);
	user_click(&u, 210, 10);
	assert_true(sorted == 1 && sort.column == 1 && sort.descending); /* a column of numbers: largest first */
	user_click(&u, 210, 10);
	assert_true(sorted == 2 && sort.column == 1 && !sort.descending);
	user_click(&u, 30, 10);
	assert_true(sorted == 3 && sort.column == 0 && !sort.descending); /* a column of names: A first */
	user_click(&u, 210, 110);
	assert_int_equal(sorted, 3);
	user_destroy(&u);
}

static void test_table_cells(void **state)
{
	(void)state;
	stilb_ui_rect row = {10, 20, 310, 40};
	stilb_ui_rect first = stilb_ui_table_cell(row, columns, 3, 0), last = stilb_ui_table_cell(row, columns, 3, 2);
	assert_true(first.x0 == 15 && first.x1 == 195 && first.y0 == 20 && first.y1 == 40);
	assert_true(last.x0 == 255 && last.x1 == 305);
	row.x1 = 50; /* narrower than the columns: cells stay within the row */
	for (uint32_t c = 0; c < 3; c++)
		assert_true(stilb_ui_table_cell(row, columns, 3, c).x1 <= 50);
}

/* ---- plot and tooltip -------------------------------------------------------------------------------------------- */

static float plotted[300];
static uint32_t plot_count;
static float plot_maximum;
static void a_plot(stilb_ui *ui)
{
	stilb_ui_plot(ui, (stilb_ui_rect){10, 10, 310, 110}, "ms", plotted, plot_count, 0.0f, plot_maximum);
}

static void test_plots(void **state)
{
	(void)state;
	user u = user_create(a_plot);
	for (uint32_t i = 0; i < 300; i++)
		plotted[i] = sinf((float)i);
	plot_count = 300;
	plot_maximum = 1.0f;
	user_frame(&u);
	user_move(&u, 160, 50);
	assert_non_null(strstr(u.ui->tooltip, "ms 150: ") ? u.ui->tooltip : strstr(u.ui->tooltip, "ms 149: "));
	plotted[20] = NAN;
	plotted[299] = INFINITY;
	plot_maximum = 0.0f; /* no range is given: that of the values is taken */
	user_frame(&u);
	for (uint32_t i = 0; i < stilb_ui_list(u.ui)->vertex_count; i++)
		assert_true(isfinite(stilb_ui_list(u.ui)->vertices[i].position[1]));
	const uint32_t counts[] = {0, 1, 2, 64, 65, 128};
	for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
		plot_count = counts[i];
		user_frame(&u);
	}
	for (uint32_t i = 0; i < 300; i++)
		plotted[i] = NAN;
	plot_count = 300;
	user_frame(&u);
	user_destroy(&u);
}

static const char *tip;
static void a_tip(stilb_ui *ui)
{
	stilb_ui_tooltip(ui, tip);
}

static stilb_ui_rect tip_bounds(user *u, const char *text)
{
	tip = text;
	user_frame(u);
	const stilb_ui_draw_list *list = stilb_ui_list(u->ui);
	stilb_ui_rect bounds = {1e9f, 1e9f, -1e9f, -1e9f};
	for (uint32_t i = 0; i < list->vertex_count; i++) {
		const float *p = list->vertices[i].position;
		if (list->vertices[i].color[3] == 255)
			bounds = (stilb_ui_rect){fminf(bounds.x0, p[0]), fminf(bounds.y0, p[1]), fmaxf(bounds.x1, p[0]),
			                         fmaxf(bounds.y1, p[1])};
	}
	return bounds;
}

static void test_tooltips_stay_in_the_picture(void **state)
{
	(void)state;
	user u = user_create(a_tip);
	const char *text = "wait for workers\ntime\t3.1 ms\nself\t1 ms";
	const float places_of_mouse[4][2] = {{5, 5}, {635, 5}, {5, 475}, {635, 475}};
	for (int i = 0; i < 4; i++) {
		u.input.mouse_x = places_of_mouse[i][0];
		u.input.mouse_y = places_of_mouse[i][1];
		stilb_ui_rect bounds = tip_bounds(&u, text);
		assert_true(bounds.x1 > bounds.x0 + 100 && bounds.y1 > bounds.y0 + 40); /* the tooltip is drawn */
		assert_true(bounds.x0 >= 0 && bounds.y0 >= 0 && bounds.x1 <= 640 && bounds.y1 <= 480);
		assert_false(
			stilb_ui_contains(bounds, u.input.mouse_x, u.input.mouse_y)); /* the tooltip does not cover the mouse */
	}
	assert_true(tip_bounds(&u, "").x1 < 0);
	char longest[3000];
	for (size_t i = 0; i < sizeof longest; i++)
		longest[i] = i % 7 == 0 ? '\n' : i % 11 == 0 ? '\t' : 'x';
	longest[sizeof longest - 1] = 0;
	tip_bounds(&u, longest);
	tip_bounds(&u, "\n\n\t\t\n");
	user_destroy(&u);
}

/* ---- life -------------------------------------------------------------------------------------------------------- */

static void test_descriptions_are_checked(void **state)
{
	(void)state;
	const float scales[] = {0.0f, -1.0f, 4.5f, NAN, INFINITY};
	for (size_t i = 0; i < sizeof scales / sizeof *scales; i++) {
		stilb_ui *ui = (stilb_ui *)1;
		stilb_ui_desc desc = stilb_ui_desc_default();
		desc.scale = scales[i];
		assert_int_equal(stilb_ui_create(&desc, &ui), STILB_ERROR_ARGUMENT);
		assert_null(ui);
		assert_non_null(strstr(stilb_error_message(), "scale"));
	}
	stilb_ui_destroy(NULL);
	user u = control_user();
	assert_int_equal(stilb_ui_record(u.ui, 0, 0), STILB_ERROR_ARGUMENT); /* no renderer */
	user_destroy(&u);
}

static void all_there_is(stilb_ui *ui)
{
	static bool open = true;
	static stilb_ui_rect frame = {300, 100, 600, 400};
	controls(ui);
	a_list(ui);
	a_table(ui);
	stilb_ui_panel_begin(ui, "panel", &frame, STILB_UI_PANEL_MOVABLE, &open);
	a_plot(ui);
	stilb_ui_panel_end(ui);
	stilb_ui_tooltip(ui, "heading\nleft\tright");
}

static void test_steady_frames_allocate_nothing(void **state)
{
	(void)state;
	user u = list_user(100);
	plot_count = 300;
	u.screen = all_there_is;
	for (int frame = 0; frame < 3; frame++)
		user_frame(&u);
	uint64_t before = allocations;
	for (int frame = 0; frame < 20; frame++) {
		u.input.keys[STILB_UI_KEY_TAB] = 1;
		user_move(&u, 10.0f * (float)frame, 20.0f * (float)frame);
	}
	assert_int_equal(allocations, before);
	user_destroy(&u);
}

static void test_without_memory(void **state)
{
	(void)state;
	stilb_ui *ui = NULL;
	stilb_ui_desc small = stilb_ui_desc_default();
	uint64_t before = allocations;
	assert_int_equal(stilb_ui_create(&small, &ui), STILB_OK);
	uint64_t needed = allocations - before;
	stilb_ui_destroy(ui);
	for (uint64_t call = 1; call <= needed;
	     call += 1 + call / 20) { /* not every one: there are thousands, for the outlines of glyphs */
		failing = call;
		assert_int_equal(stilb_ui_create(&small, &ui), STILB_ERROR_MEMORY);
		assert_null(ui);
		assert_int_equal(failing, 0);
	}
	user u = list_user(100);
	u.screen = all_there_is;
	for (uint64_t call = 1; call < 12; call++) { /* allocations of the first frames, in which the lists grow */
		stilb_ui_destroy(u.ui);
		stilb_ui_desc desc = stilb_ui_desc_default();
		assert_int_equal(stilb_ui_create(&desc, &u.ui), STILB_OK);
		failing = call;
		stilb_ui_begin(u.ui, &u.input);
		u.screen(u.ui);
		stilb_ui_end(u.ui);
		assert_true(failing > 0 || stilb_ui_list(u.ui)->out_of_memory);
		failing = 0;
	}
	user_destroy(&u);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_what_is_drawn_later_is_in_front),
		cmocka_unit_test(test_press_drag_and_click),
		cmocka_unit_test(test_clicks_within_a_frame_count),
		cmocka_unit_test(test_double_click),
		cmocka_unit_test(test_wheel_goes_through_what_does_not_take_it),
		cmocka_unit_test(test_buttons),
		cmocka_unit_test(test_slider),
		cmocka_unit_test(test_slider_words_are_free),
		cmocka_unit_test(test_slider_muted),
		cmocka_unit_test(test_keyboard),
		cmocka_unit_test(test_what_is_gone_has_no_keys),
		cmocka_unit_test(test_equal_labels_with_pushed_ids),
		cmocka_unit_test(test_labels_hide_what_follows_two_signs),
		cmocka_unit_test(test_panels_stop_the_mouse),
		cmocka_unit_test(test_panels_move_and_grow),
		cmocka_unit_test(test_panels_close),
		cmocka_unit_test(test_lists_show_and_scroll),
		cmocka_unit_test(test_lists_select),
		cmocka_unit_test(test_lists_have_a_bar),
		cmocka_unit_test(test_tables_sort),
		cmocka_unit_test(test_table_cells),
		cmocka_unit_test(test_plots),
		cmocka_unit_test(test_tooltips_stay_in_the_picture),
		cmocka_unit_test(test_descriptions_are_checked),
		cmocka_unit_test(test_steady_frames_allocate_nothing),
		cmocka_unit_test(test_without_memory),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
