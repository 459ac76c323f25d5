/*
 * The effects' window: what happens to the light of frames (post.h), each effect on or off and with its numbers, and
 * all of them at once, to compare.
 */
#include "engine_internal.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#define EFFECTS_WIDTH 300.0f /* pixels, at most */
#define EFFECTS_BORDER 2.0f  /* pixels: the panel's border is no thicker */
#define EFFECTS_INDENT 16.0f /* pixels, of what belongs to the effect above */
#define EFFECTS_FOCUS 5.0f   /* metres */
#define EFFECTS_APERTURE 0.02f
#define EFFECTS_LABEL 64 /* bytes */

/* A line of the window. */
typedef struct effects_row {
	const char *label;
	enum {
		EFFECTS_EFFECT, /* an amount, 0: the effect is off */
		EFFECTS_NUMBER, /* of the effect above; 0: its default */
		EFFECTS_WORD,   /* likewise, an enumeration whose words are `words` */
		EFFECTS_SWITCH, /* a bool: on or off */
	} kind;
	size_t offset; /* in stilb_post_settings, of a float or an int */
	float usual;   /* of an effect that is switched on for the first time; it goes from 0 to 1 */
	stilb_ui_slider_range range;
	const char *const *words; /* NULL-terminated */
} effects_row;

#define EFFECTS_AT(member) offsetof(stilb_post_settings, member)
#define EFFECT(text, member, first)                                                                                    \
	{                                                                                                                  \
		.label = text, .kind = EFFECTS_EFFECT, .offset = EFFECTS_AT(member), .usual = first                            \
	}
#define NUMBER(text, member, ...)                                                                                      \
	{                                                                                                                  \
		.label = text, .kind = EFFECTS_NUMBER, .offset = EFFECTS_AT(member), .range = { __VA_ARGS__ }                  \
	}
#define SWITCH(text, member)                                                                                           \
	{                                                                                                                  \
		.label = text, .kind = EFFECTS_SWITCH, .offset = EFFECTS_AT(member)                                            \
	}
#define WORD(text, member, names)                                                                                      \
	{                                                                                                                  \
		.label = text, .kind = EFFECTS_WORD, .offset = EFFECTS_AT(member), .words = names                              \
	}

static const effects_row effects_rows[] = {
	SWITCH("Exposure adapts", exposure_adapts),
	EFFECT("Occlusion", occlusion, 1.0f),
	NUMBER("Radius", occlusion_radius, 0.05f, 20.0f, 0.05f, "%.2f m"),
	EFFECT("Motion blur", motion_blur, 0.5f),
	NUMBER("Longest", motion_blur_most, 0.01f, 0.5f, 0.01f, "%.2f"),
	WORD("Of", motion, stilb_post_motion_names),
	NUMBER("From", motion_blur_far, 1.0f, 200.0f, 1.0f, "%.0f m"),
	EFFECT("Bloom", bloom, 0.05f),
	NUMBER("Width", bloom_width, 0.01f, 1.0f, 0.01f, "%.2f"),
	WORD("Images", bloom_format, stilb_post_bloom_format_names),
	WORD("Computed by", place, stilb_post_place_names),
	WORD("Dither", dither, stilb_post_dither_names),
	WORD("Antialiasing", aa, stilb_post_aa_names),
	WORD("Reflections", reflections, stilb_post_reflections_names),
	WORD("Depth of field", dof, stilb_post_dof_names),
	NUMBER("Aperture", aperture, 0.0f, 0.5f, 0.005f, "%.3f m"),
	NUMBER("Focus", focus, 0.1f, 100.0f, 0.1f, "%.1f m"),
};
#define EFFECTS_ROWS ((uint32_t)(sizeof effects_rows / sizeof *effects_rows))

static float *effects_number(stilb_post_settings *settings, const effects_row *row)
{
	return (float *)((char *)settings + row->offset);
}

/* ---- lines ------------------------------------------------------------------------------------------------------- */

static stilb_ui_rect effects_line(const stilb_ui_style *style, stilb_ui_rect *area)
{
	stilb_ui_rect line = stilb_ui_cut_top(area, style->control_height);
	stilb_ui_cut_top(area, style->gap);
	return line;
}

/* A check box, and a slider for the amount while it is on. last: what it was when it was on. */
static bool effects_draw_effect(stilb_ui *ui, stilb_ui_rect line, const effects_row *row, float *amount, float *last)
{
	static const stilb_ui_slider_range amounts = {0.0f, 1.0f, 0.01f, "%.2f"};
	bool on = *amount > 0.0f, changed = false;
	float third = floorf(0.4f * (line.x1 - line.x0));
	if (on)
		*last = *amount;
	if (stilb_ui_checkbox(ui, stilb_ui_cut_left(&line, third), row->label, &on)) {
		*amount = on ? *last > 0.0f ? *last : row->usual : 0.0f;
		changed = true;
	}
	if (on)
		changed |= stilb_ui_slider(ui, line, "Amount", amount, &amounts);
	return changed;
}

/* A button with the word, which goes on to the next. */
static bool effects_draw_word(stilb_ui *ui, stilb_ui_rect line, const effects_row *row, int *word)
{
	char label[EFFECTS_LABEL];
	snprintf(label, sizeof label, "%s: %s", row->label, row->words[*word]);
	stilb_ui_id_push(ui, row->label);
	bool pressed = stilb_ui_button(ui, line, label);
	stilb_ui_id_pop(ui);
	if (pressed)
		*word = row->words[*word + 1] ? *word + 1 : 0;
	return pressed;
}

/* All lines. True if something changed. */
static bool effects_draw_rows(engine_effects *effects, stilb_post_settings *settings, stilb_ui *ui, stilb_ui_rect area)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	stilb_post_settings filled = stilb_post_settings_filled(settings);
	bool changed = false, on = false;
	for (uint32_t r = 0; r < EFFECTS_ROWS; r++) {
		const effects_row *row = &effects_rows[r];
		if (area.y1 - area.y0 < style->control_height)
			break; /* the picture is too low for them */
		stilb_ui_rect line = effects_line(style, &area);
		stilb_ui_id_push_number(ui, r);
		if (row->kind == EFFECTS_EFFECT) {
			float *amount = effects_number(settings, row);
			changed |= effects_draw_effect(ui, line, row, amount, effects_number(&effects->last, row));
			on = *amount > 0.0f;
		} else if (row->kind == EFFECTS_SWITCH) {
			changed |= stilb_ui_checkbox(ui, line, row->label, (bool *)((char *)settings + row->offset));
		} else {
			line.x0 += EFFECTS_INDENT;
		}
		if (row->kind == EFFECTS_NUMBER) {
			float shown = *(const float *)((const char *)&filled + row->offset);
			if ((on ? stilb_ui_slider : stilb_ui_slider_muted)(ui, line, row->label, &shown, &row->range)) {
				*effects_number(settings, row) = shown;
				changed = true;
			}
		} else if (row->kind == EFFECTS_WORD) {
			int *word = (int *)((char *)settings + row->offset);
			changed |= effects_draw_word(ui, line, row, word);
			on = *word != 0;
		}
		stilb_ui_id_pop(ui);
	}
	return changed;
}

/* ---- the window -------------------------------------------------------------------------------------------------- */

/* At first in the upper right corner, from then on wherever the user moved it. */
static void effects_place(engine_effects *effects, const stilb_ui_style *style, const stilb_ui_input *input)
{
	float around = 2.0f * style->margin, line = style->control_height + style->gap;
	float width = fminf(EFFECTS_WIDTH, input->width - around);
	float height = style->title_height + around + EFFECTS_BORDER + line * (float)(EFFECTS_ROWS + 1 + effects->saves);
	height = fminf(height, input->height - around);
	stilb_ui_rect *place = &effects->place;
	if (stilb_ui_is_empty(*place))
		*place = (stilb_ui_rect){.x0 = input->width - width - style->margin, .y0 = style->margin};
	*place = (stilb_ui_rect){place->x0, place->y0, place->x0 + width, place->y0 + height};
}

void engine_effects_draw(engine_effects *effects, stilb_ui *ui, const stilb_post_settings *settings)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	stilb_post_settings none = {0};
	if (effects->without && memcmp(settings, &none, sizeof none) != 0) /* the program has set some */
		effects->without = false;
	if (!effects->without)
		effects->kept = *settings;
	effects_place(effects, style, stilb_ui_input_get(ui));
	stilb_ui_id_push(ui, "effects");
	stilb_ui_rect area = stilb_ui_panel_begin(ui, "Effects", &effects->place, STILB_UI_PANEL_MOVABLE, &effects->open);
	bool changed = stilb_ui_checkbox(ui, effects_line(style, &area), "Frames without them", &effects->without);
	if (effects->saves)
		effects->save |= stilb_ui_button(ui, effects_line(style, &area), "Save them as a preset");
	changed |= effects_draw_rows(effects, &effects->kept, ui, area);
	if (effects->kept.dof != STILB_POST_DOF_OFF && effects->kept.focus == 0.0f) { /* a lens that shows what it does */
		effects->kept.focus = EFFECTS_FOCUS;
		effects->kept.aperture = effects->kept.aperture > 0.0f ? effects->kept.aperture : EFFECTS_APERTURE;
	}
	stilb_ui_panel_end(ui);
	stilb_ui_id_pop(ui);
	effects->chosen = effects->without ? none : effects->kept;
	effects->changed |= changed;
}
