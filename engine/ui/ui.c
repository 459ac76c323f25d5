/* The life of a user interface and its frames: which area gets the mouse and the keys. */
#include "ui/ui_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define DOUBLE_CLICK_REACH 4.0f /* pixels between the two presses of a double click at most */

/* ---- life -------------------------------------------------------------------------------------------------------- */

stilb_ui_desc stilb_ui_desc_default(void)
{
	return (stilb_ui_desc){.aa = STILB_UI_AA_FEATHER, .scale = 1.0f};
}

/* The default style; lengths are whole pixels. */
static stilb_ui_style style_of(float scale)
{
	return (stilb_ui_style){
		.panel = {0x14, 0x17, 0x1c, 0xff}, /* opaque: text below a panel must not shine through */
		.panel_title = {0x20, 0x25, 0x2d, 0xff},
		.panel_border = {0x3d, 0x46, 0x52, 0xff},
		.shadow = {0x00, 0x00, 0x00, 0xa0},
		.text = stilb_ui_rgb(0xd5dae1),
		.text_muted = stilb_ui_rgb(0x8f9aa8),
		.text_strong = stilb_ui_rgb(0xffffff),
		.control = stilb_ui_rgb(0x2d343e),
		.control_hot = stilb_ui_rgb(0x3a4451),
		.control_active = stilb_ui_rgb(0x232930),
		.control_border = stilb_ui_rgb(0x4d5866),
		.accent = stilb_ui_rgb(0x5aa2e6),
		.accent_face = stilb_ui_rgb(0x2c6db3),
		.accent_text = stilb_ui_rgb(0xffffff),
		.row_odd = {0xff, 0xff, 0xff, 0x02},
		.row_hot = stilb_ui_rgb(0x2a313b),
		.row_selected = stilb_ui_rgb(0x2c4a6b),
		.plot_background = stilb_ui_rgb(0x0e1014),
		.plot_grid = stilb_ui_rgb(0x262c34),
		.good = stilb_ui_rgb(0x67b96a),
		.warning = stilb_ui_rgb(0xe3b341),
		.bad = stilb_ui_rgb(0xe5594f),
		.margin = roundf(8.0f * scale),
		.gap = roundf(6.0f * scale),
		.control_height = roundf(22.0f * scale),
		.row_height = roundf(18.0f * scale),
		.title_height = roundf(26.0f * scale),
		.radius = roundf(4.0f * scale),
		.scroll_bar = roundf(8.0f * scale),
	};
}

stilb_result stilb_ui_create(const stilb_ui_desc *desc, stilb_ui **out)
{
	STILB_ASSERT(desc && out);
	STILB_ASSERT((unsigned)desc->aa <= STILB_UI_AA_OFF);
	*out = NULL;
	if (!(desc->scale >= 0.5f && desc->scale <= 4.0f))
		return stilb_fail(STILB_ERROR_ARGUMENT, "the user interface's scale is %g; it goes from 0.5 to 4",
		                  (double)desc->scale);
	stilb_ui *ui = calloc(1, sizeof *ui);
	if (!ui)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the user interface");
	ui->list.aa = desc->aa;
	ui->scale = desc->scale;
	ui->style = style_of(desc->scale);
	stilb_result result = ui_fonts_init(&ui->fonts, desc->scale);
	if (result == STILB_OK && desc->render)
		result = ui_texture_create(ui, desc->render);
	if (result == STILB_OK)
		*out = ui;
	else
		stilb_ui_destroy(ui);
	return result;
}

void stilb_ui_destroy(stilb_ui *ui)
{
	if (!ui)
		return;
	STILB_ASSERT(!ui->in_frame && "after end");
	if (ui->render)
		stilb_render_texture_destroy(ui->render, ui->texture);
	ui_fonts_finish(&ui->fonts);
	stilb_ui_list_finish(&ui->list);
	free(ui->now.items);
	free(ui->before.items);
	free(ui);
}

stilb_ui_style *stilb_ui_style_get(stilb_ui *ui)
{
	STILB_ASSERT_OWNER(ui->writer);
	return &ui->style;
}

void stilb_ui_aa_set(stilb_ui *ui, stilb_ui_aa aa)
{
	STILB_ASSERT_OWNER(ui->writer);
	STILB_ASSERT((unsigned)aa <= STILB_UI_AA_OFF);
	ui->list.aa = aa;
}

const stilb_ui_font *stilb_ui_font_get(const stilb_ui *ui, stilb_ui_text_kind kind)
{
	STILB_ASSERT((unsigned)kind < STILB_UI_TEXT_KINDS);
	return &ui->fonts.fonts[kind];
}

const uint8_t *stilb_ui_glyphs(const stilb_ui *ui, uint32_t *width, uint32_t *height)
{
	STILB_ASSERT(width && height);
	*width = ui->fonts.width;
	*height = ui->fonts.height;
	return ui->fonts.coverage;
}

stilb_ui_draw_list *stilb_ui_list(stilb_ui *ui)
{
	STILB_ASSERT_OWNER(ui->writer);
	return &ui->list;
}

const stilb_ui_input *stilb_ui_input_get(const stilb_ui *ui)
{
	return &ui->input;
}

bool stilb_ui_wants_mouse(const stilb_ui *ui)
{
	STILB_ASSERT_OWNER(ui->writer);
	return ui->hot != 0 || ui->active != 0;
}

bool stilb_ui_wants_keys(const stilb_ui *ui)
{
	STILB_ASSERT_OWNER(ui->writer);
	return ui->focus != 0;
}

/* ---- ids --------------------------------------------------------------------------------------------------------- */

static void id_push(stilb_ui *ui, const void *data, size_t size)
{
	UI_ASSERT_IN_FRAME(ui);
	STILB_ASSERT(ui->id_count < STILB_UI_ID_DEPTH);
	uint64_t above = ui->ids[ui->id_count - 1];
	ui->ids[ui->id_count++] = stilb_hash_fnv1a64(above, data, size);
}

void stilb_ui_id_push(stilb_ui *ui, const char *name)
{
	STILB_ASSERT(name);
	id_push(ui, name, strlen(name) + 1); /* with the 0 at its end: "a", "bc" differs from "ab", "c" */
}

void stilb_ui_id_push_number(stilb_ui *ui, uint64_t number)
{
	id_push(ui, &number, sizeof number);
}

void stilb_ui_id_pop(stilb_ui *ui)
{
	UI_ASSERT_IN_FRAME(ui);
	STILB_ASSERT(ui->id_count > 1 && "an id was pushed");
	ui->id_count--;
}

/* ---- which area gets the mouse ----------------------------------------------------------------------------------- */

/* The id of the frontmost area of the last frame that is under the mouse and has all of these STILB_UI_TAKES bits; 0:
 * none. */
static uint64_t item_under_mouse(const stilb_ui *ui, uint32_t takes)
{
	for (uint32_t i = ui->before.count; i-- > 0 && ui->input.mouse_present;) {
		const ui_item *item = &ui->before.items[i];
		if ((item->takes & takes) == takes && stilb_ui_contains(item->rect, ui->input.mouse_x, ui->input.mouse_y))
			return item->id;
	}
	return 0;
}

/* Handles that the left button went down, on the area ui->hot if that is not 0. */
static void mouse_press(stilb_ui *ui)
{
	const stilb_ui_input *input = &ui->input;
	bool again = ui->press_id == ui->hot && ui->press_age <= STILB_UI_DOUBLE_CLICK &&
	             fabsf(input->mouse_x - ui->press_x) <= DOUBLE_CLICK_REACH &&
	             fabsf(input->mouse_y - ui->press_y) <= DOUBLE_CLICK_REACH;
	ui->pressed = ui->hot;
	ui->double_clicked = again || input->mouse_presses > 1 ? ui->hot : 0;
	ui->press_id = ui->double_clicked ? 0 : ui->hot; /* 0: a third press begins a new double click */
	ui->press_x = input->mouse_x;
	ui->press_y = input->mouse_y;
	ui->press_age = 0.0f;
	ui->focus = 0; /* stilb_ui_area gives it to the pressed area if that takes the focus */
}

/* Decides which area of the last frame the mouse is over, presses, holds or clicks in this frame. */
static void mouse_update(stilb_ui *ui)
{
	const stilb_ui_input *input = &ui->input;
	ui->hot = item_under_mouse(ui, 0);
	ui->wheel = item_under_mouse(ui, STILB_UI_TAKES_WHEEL);
	ui->pressed = ui->clicked = ui->double_clicked = 0;
	ui->press_age += input->seconds;
	bool came_up = !input->mouse_down || input->mouse_presses > 0;
	if (came_up && ui->active != 0) {
		ui->clicked = ui->active == ui->hot ? ui->active : 0;
		ui->active = 0;
	}
	if (input->mouse_presses == 0)
		return;
	mouse_press(ui);
	if (input->mouse_down)
		ui->active = ui->hot;
	else
		ui->clicked = ui->hot;
}

/* ---- which area gets the keys ------------------------------------------------------------------------------------ */

/* Moves the focus to the next area that takes keys, or back to the one before; without a focus to the first, or the
 * last. */
static void focus_step(stilb_ui *ui, bool back)
{
	uint32_t count = ui->before.count, at = back ? 0 : count - 1;
	for (uint32_t i = 0; i < count; i++)
		if (ui->before.items[i].id == ui->focus)
			at = i;
	for (uint32_t step = 1; step <= count; step++) {
		const ui_item *item = &ui->before.items[(at + (back ? count - step : step)) % count];
		if (item->takes & STILB_UI_TAKES_KEYS) {
			ui->focus = item->id;
			return;
		}
	}
}

/* Applies the keys of this frame: moves the focus or takes it away. An area that is no longer drawn loses the focus. */
static void keys_update(stilb_ui *ui)
{
	bool drawn = false;
	for (uint32_t i = 0; i < ui->before.count; i++)
		drawn |= ui->before.items[i].id == ui->focus;
	if (!drawn || ui->input.keys[STILB_UI_KEY_ESCAPE] > 0)
		ui->focus = 0;
	for (uint32_t i = 0; i < ui->input.keys[STILB_UI_KEY_TAB]; i++)
		focus_step(ui, ui->input.shift);
	bool press = ui->input.keys[STILB_UI_KEY_SPACE] > 0 || ui->input.keys[STILB_UI_KEY_ENTER] > 0;
	if (press && ui->focus != 0)
		ui->clicked = ui->focus;
}

/* ---- frame ------------------------------------------------------------------------------------------------------- */

void stilb_ui_begin(stilb_ui *ui, const stilb_ui_input *input)
{
	STILB_ASSERT(input);
	STILB_ASSERT(!ui->in_frame && "after end");
	STILB_ASSERT(input->seconds >= 0.0f);
	stilb_owner_take(&ui->writer);
	ui->in_frame = true;
	ui->move_x = input->mouse_x - ui->input.mouse_x;
	ui->move_y = input->mouse_y - ui->input.mouse_y;
	ui->input = *input;
	ui_items items = ui->before;
	ui->before = ui->now;
	ui->now = items;
	ui->now.count = 0;
	ui->ids[0] = STILB_FNV1A64_START;
	ui->id_count = 1;
	ui->tooltip[0] = 0;
	mouse_update(ui);
	keys_update(ui);
	stilb_ui_list_begin(&ui->list, input->width, input->height);
}

void stilb_ui_end(stilb_ui *ui)
{
	UI_ASSERT_IN_FRAME(ui);
	STILB_ASSERT(ui->panel_count == 0 && "every panel has ended");
	STILB_ASSERT(ui->id_count == 1 && "every id was popped");
	STILB_ASSERT(ui->list.clip_count == 1 && "every clip was popped");
	ui_tooltip_draw(ui);
	STILB_CHECK(ui_list_is_sound(&ui->list));
	ui->in_frame = false;
	ui->writer = (stilb_owner){0};
}

stilb_ui_action stilb_ui_area(stilb_ui *ui, const char *label, stilb_ui_rect rect, uint32_t takes)
{
	UI_ASSERT_IN_FRAME(ui);
	STILB_ASSERT(label);
	STILB_ASSERT((takes & ~(uint32_t)(STILB_UI_TAKES_WHEEL | STILB_UI_TAKES_KEYS | STILB_UI_TAKES_FOCUS)) == 0);
	uint64_t id = stilb_hash_fnv1a64(ui->ids[ui->id_count - 1], label, strlen(label) + 1);
	const stilb_ui_input *input = &ui->input;
	stilb_ui_rect seen = stilb_ui_intersection(rect, stilb_ui_clip(&ui->list));
	if (!stilb_ui_is_empty(seen)) {
		if (ui_reserve((void **)&ui->now.items, &ui->now.capacity, ui->now.count, 1, sizeof *ui->now.items))
			ui->now.items[ui->now.count++] = (ui_item){id, seen, takes};
		else
			ui->list.out_of_memory = true;
	}
	if (ui->pressed == id && takes & STILB_UI_TAKES_FOCUS)
		ui->focus = id;
	stilb_ui_action action = {
		.hovered = ui->hot == id && (ui->active == 0 || ui->active == id),
		.pressed = ui->pressed == id,
		.held = ui->active == id,
		.clicked = ui->clicked == id,
		.double_clicked = ui->double_clicked == id,
		.focused = ui->focus == id,
		.mouse_x = input->mouse_x,
		.mouse_y = input->mouse_y,
		.wheel = ui->wheel == id ? input->wheel : 0.0f,
	};
	if (action.held) {
		action.drag_x = action.pressed ? 0.0f : ui->move_x;
		action.drag_y = action.pressed ? 0.0f : ui->move_y;
		action.total_x = input->mouse_x - ui->press_x;
		action.total_y = input->mouse_y - ui->press_y;
	}
	return action;
}
