/*
 * The materials' window: lists of the models that shade the scene and of the program's own choice, sliders for values
 * that are added to every material's own, and a polar plot of the light that a sample material reflects with them.
 */
#include "engine_internal.h"

#include "shading/shade_energy.h"
#include "shading/shade_surface.h"

#include <stdio.h>

#define INSPECTOR_COLUMN 168.0f   /* width of a column of lists, pixels */
#define INSPECTOR_LOBE 156.0f     /* height of the plot at most, pixels */
#define INSPECTOR_LOBE_POINTS 181 /* directions that are plotted */
#define INSPECTOR_SLIDERS 124.0f  /* width in which sliders have room for name and value, pixels */
#define INSPECTOR_ARROW 7.0f      /* length of the arrowhead of the light, pixels */
#define INSPECTOR_BORDER 2.0f     /* pixels: the panel's border is no thicker */
#define INSPECTOR_WRAP 0.5f       /* wrap and anisotropy that a choice of model adds: stilb_engine_shading_chosen */
#define INSPECTOR_ANISOTROPY 0.6f

/* ---- names ------------------------------------------------------------------------------------------------------- */

/* An entry of an array of names; the shading headers number each kind of model from 0 on. */
#define INSPECTOR_WORD(number, name) [number] = #name,

const char *const stilb_engine_brdf_names[] = {SHADE_BRDFS(INSPECTOR_WORD) NULL};
const char *const stilb_engine_ndf_names[] = {SHADE_NDFS(INSPECTOR_WORD) NULL};
const char *const stilb_engine_g_names[] = {SHADE_GS(INSPECTOR_WORD) NULL};
const char *const stilb_engine_f_names[] = {SHADE_FS(INSPECTOR_WORD) NULL};

static_assert(sizeof stilb_engine_brdf_names / sizeof(char *) == SHADE_BRDF_COUNT + 1 &&
                  sizeof stilb_engine_ndf_names / sizeof(char *) == SHADE_NDF_COUNT + 1 &&
                  sizeof stilb_engine_g_names / sizeof(char *) == SHADE_G_COUNT + 1 &&
                  sizeof stilb_engine_f_names / sizeof(char *) == SHADE_F_COUNT + 1,
              "every number has a name");

/* ---- values that a choice adds ----------------------------------------------------------------------------------- */

/* True if the chosen models read the anisotropy. */
static bool inspector_is_anisotropic(const stilb_render_shading *shading)
{
	return shading->brdf == SHADE_BRDF_MICROFACET && shading->ndf == SHADE_NDF_GGX_ANISOTROPIC;
}

/* The value that is added to all materials after another model was chosen. before, now: the model before and the model
 * chosen now read the value. It becomes `shown` if only the new one does and nothing was added, and 0 again if only the
 * old one did and the user has not changed it from `shown`. */
static float inspector_added(float added, bool before, bool now, float shown)
{
	if (before == now || added != (now ? 0.0f : shown))
		return added;
	return now ? shown : 0.0f;
}

void stilb_engine_shading_chosen(const stilb_render_shading *before, stilb_render_shading *shading)
{
	STILB_ASSERT(before && shading);
	STILB_ASSERT(shading->brdf < SHADE_BRDF_COUNT && shading->ndf < SHADE_NDF_COUNT);
	shading->wrap = inspector_added(shading->wrap, before->brdf == SHADE_BRDF_WRAPPED,
	                                shading->brdf == SHADE_BRDF_WRAPPED, INSPECTOR_WRAP);
	shading->anisotropy = inspector_added(shading->anisotropy, inspector_is_anisotropic(before),
	                                      inspector_is_anisotropic(shading), INSPECTOR_ANISOTROPY);
}

/* ---- lists ------------------------------------------------------------------------------------------------------- */

/* A list of names with its heading. */
typedef struct inspector_list {
	const char *heading;
	const char *const *words; /* [count] */
	uint32_t *chosen;         /* index of the chosen word */
	uint32_t count;
	uint32_t rows; /* number of visible rows: all, unless the column of lists is too high for the window */
} inspector_list;

/* Pixels that a column of this many lists needs if `rows` rows of all of them together are visible. */
static float inspector_column_height(const stilb_ui_style *style, uint32_t lists, uint32_t rows)
{
	return (float)(lists + rows) * style->row_height + (float)lists * style->gap;
}

/* If the column is too high for the area, takes visible rows from its longest lists until it fits. */
static void inspector_fit(const stilb_ui_style *style, stilb_ui_rect area, inspector_list *lists, uint32_t count)
{
	STILB_ASSERT(count > 0);
	for (;;) {
		uint32_t rows = 0;
		inspector_list *longest = lists;
		for (uint32_t i = 0; i < count; i++) {
			rows += lists[i].rows;
			longest = lists[i].rows > longest->rows ? &lists[i] : longest;
		}
		if (inspector_column_height(style, count, rows) <= area.y1 - area.y0 || longest->rows == 1)
			return;
		longest->rows--;
	}
}

/* If another row is chosen than in the last frame, scrolls the list by as little as brings the row into view. */
static void inspector_follow(const stilb_ui_style *style, const inspector_list *list, stilb_ui_list_state *state)
{
	STILB_ASSERT(*list->chosen < list->count);
	float row = style->row_height, top = (float)*list->chosen * row;
	if (state->selected != *list->chosen)
		state->scroll = fminf(fmaxf(state->scroll, top + row - (float)list->rows * row), top);
	state->selected = *list->chosen;
}

/* Draws a list with its heading; true if the user chose a row, be it the same. muted: the choice has no effect at
 * present. */
static bool inspector_draw_list(stilb_ui *ui, stilb_ui_rect *area, const inspector_list *list,
                                stilb_ui_list_state *state, bool muted)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	stilb_ui_rect head = stilb_ui_cut_top(area, style->row_height);
	stilb_ui_draw_text(stilb_ui_list(ui), stilb_ui_font_get(ui, STILB_UI_TEXT_STRONG), head, STILB_UI_ALIGN_LEFT,
	                   muted ? style->text_muted : style->text_strong, list->heading);
	inspector_follow(style, list, state);
	stilb_ui_rows rows = stilb_ui_rows_begin(ui, stilb_ui_cut_top(area, (float)list->rows * style->row_height),
	                                         list->heading, list->count, state);
	for (uint32_t r = rows.first; r < rows.end; r++) {
		char word[48];
		snprintf(word, sizeof word, "%s", list->words[r]);
		for (char *c = word; *c; c++)
			if (*c == '_')
				*c = ' ';
		stilb_ui_rect row = stilb_ui_row(ui, &rows, r);
		row.x0 += style->gap;
		(muted ? stilb_ui_label_muted : stilb_ui_label)(ui, row, STILB_UI_ALIGN_LEFT, word);
	}
	stilb_ui_rows_end(ui);
	stilb_ui_cut_top(area, style->gap);
	bool taken = rows.changed || rows.clicked != STILB_UI_NO_ROW;
	*list->chosen = taken ? state->selected : *list->chosen;
	return taken;
}

static bool inspector_column(stilb_ui *ui, stilb_ui_rect area, inspector_list *lists, uint32_t count,
                             stilb_ui_list_state *states, bool muted)
{
	bool taken = false;
	inspector_fit(stilb_ui_style_get(ui), area, lists, count);
	for (uint32_t i = 0; i < count; i++)
		taken |= inspector_draw_list(ui, &area, &lists[i], &states[i], muted);
	return taken;
}

static void inspector_lists(engine_inspector *inspector, stilb_ui *ui, stilb_ui_rect left, stilb_ui_rect right,
                            stilb_render_shading *shading, stilb_engine_choice *choice)
{
	inspector_list whole[2] = {
		{"Model", stilb_engine_brdf_names, &shading->brdf, SHADE_BRDF_COUNT, SHADE_BRDF_COUNT},
	};
	if (choice)
		whole[1] = (inspector_list){choice->heading, choice->names, &choice->chosen, choice->count, choice->count};
	inspector_list parts[] = {
		{"D: facets", stilb_engine_ndf_names, &shading->ndf, SHADE_NDF_COUNT, SHADE_NDF_COUNT},
		{"G: shadowing", stilb_engine_g_names, &shading->g, SHADE_G_COUNT, SHADE_G_COUNT},
		{"F: Fresnel", stilb_engine_f_names, &shading->f, SHADE_F_COUNT, SHADE_F_COUNT},
	};
	stilb_render_shading before = *shading;
	inspector_column(ui, left, whole, choice ? 2 : 1, inspector->lists, false);
	/* Choosing D, G or F also chooses the microfacet model, the only one that reads them. */
	if (inspector_column(ui, right, parts, 3, inspector->lists + 2, shading->brdf != SHADE_BRDF_MICROFACET))
		shading->brdf = SHADE_BRDF_MICROFACET;
	stilb_engine_shading_chosen(&before, shading);
}

/* ---- sliders ----------------------------------------------------------------------------------------------------- */

/* Pixels that the sliders need with their heading. */
static float inspector_sliders_height(const stilb_ui_style *style)
{
	return style->row_height + 5.0f * style->control_height + 4.0f * style->gap;
}

/* Draws the sliders for the values added to all materials; one whose value the chosen models do not read is muted. */
static void inspector_sliders(stilb_ui *ui, stilb_ui_rect area, stilb_render_shading *shading,
                              stilb_engine_choice *choice)
{
	static const stilb_ui_slider_range range = {-1.0f, 1.0f, 0.01f, "%+.2f"};
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	bool lambert = shading->brdf == SHADE_BRDF_LAMBERT, highlight = !lambert && shading->brdf != SHADE_BRDF_WRAPPED;
	struct {
		const char *label;
		float *value;
		bool read;
	} rows[] = {
		{"Roughness", &shading->roughness, highlight},
		{"Anisotropy", &shading->anisotropy, inspector_is_anisotropic(shading)},
		{"Wrap", &shading->wrap, !lambert},
		{"Specular", &shading->specular, highlight},
	};
	float room = area.y1 - area.y0, needed = inspector_sliders_height(style), gap = style->gap;
	float control = style->control_height;
	if (room >= needed) {
		stilb_ui_draw_text(stilb_ui_list(ui), stilb_ui_font_get(ui, STILB_UI_TEXT_SMALL),
		                   stilb_ui_cut_top(&area, style->row_height), STILB_UI_ALIGN_LEFT, style->text,
		                   "Added to each material's own");
	} else { /* in a low window without the heading, and closer together */
		gap = floorf(fminf(gap, fmaxf(room - 5.0f * control, 0.0f) / 4.0f));
		control = floorf(fminf(control, (room - 4.0f * gap) / 5.0f));
	}
	for (size_t r = 0; r < sizeof rows / sizeof *rows; r++) {
		(rows[r].read ? stilb_ui_slider : stilb_ui_slider_muted)(ui, stilb_ui_cut_top(&area, control), rows[r].label,
		                                                         rows[r].value, &range);
		stilb_ui_cut_top(&area, gap);
	}
	if (stilb_ui_button(ui, stilb_ui_cut_top(&area, control), "Default")) {
		*shading = stilb_render_shading_default();
		if (choice)
			choice->chosen = choice->initial;
	}
}

/* ---- the lobe ---------------------------------------------------------------------------------------------------- */

/* The material that the plot shows: a grey one plus the values that are added to all materials. */
static shade_material inspector_sample(const stilb_render_shading *shading)
{
	float specular = 0.2f + shading->specular;
	shade_reflectance reflectance =
		shade_limit_to_one(stilb_vec3_make(0.4f, 0.4f, 0.4f), stilb_vec3_make(specular, specular, specular));
	return (shade_material){
		.diffuse = reflectance.diffuse,
		.specular = reflectance.specular,
		.roughness = fminf(fmaxf(0.5f + shading->roughness, 0.0f), 1.0f),
		.anisotropy = fminf(fmaxf(shading->anisotropy, -1.0f), 1.0f),
		.wrap = fminf(fmaxf(shading->wrap, 0.0f), 1.0f),
	};
}

/* The sample's BRDF times the cosine of the light's angle to the normal, 1 / sr, for light from the left, 45 degrees
 * above the horizon, in INSPECTOR_LOBE_POINTS viewing directions from the left horizon to the right one. Returns the
 * largest. */
static float inspector_lobe(const stilb_render_shading *shading, float values[INSPECTOR_LOBE_POINTS])
{
	shade_brdf_model model = {(int)shading->brdf, (int)shading->ndf, (int)shading->g, (int)shading->f};
	shade_material material = inspector_sample(shading);
	shade_frame frame = {stilb_vec3_make(1, 0, 0), stilb_vec3_make(0, 0, -1), stilb_vec3_make(0, 1, 0)};
	stilb_vec3 l = stilb_vec3_normalize(stilb_vec3_make(-1, 1, 0));
	float most = 0.0f;
	for (int i = 0; i < INSPECTOR_LOBE_POINTS; i++) {
		float angle = SHADE_PI * ((float)i + 0.5f) / INSPECTOR_LOBE_POINTS;
		stilb_vec3 v = stilb_vec3_make(-cosf(angle), sinf(angle), 0);
		shade_material seen = shade_surface_seen(model, material, v[1]);
		values[i] = shade_surface_brdf_cos(model, seen, frame, l, v)[0];
		most = fmaxf(most, values[i]);
	}
	return most;
}

/* Plots the lobe over the angle of view. Lengths are square roots of the values, because a highlight is some hundred
 * times as bright as its surroundings. Draws nothing in an area too low for the words. */
static void inspector_draw_lobe(stilb_ui *ui, stilb_ui_rect area, const stilb_render_shading *shading)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	const stilb_ui_font *font = stilb_ui_font_get(ui, STILB_UI_TEXT_SMALL);
	float line = stilb_ui_font_line(font);
	if (area.y1 - area.y0 < 4.0f * line)
		return;
	stilb_ui_draw_list *list = stilb_ui_list(ui);
	float values[INSPECTOR_LOBE_POINTS];
	stilb_ui_point points[INSPECTOR_LOBE_POINTS];
	float most = inspector_lobe(shading, values);
	stilb_ui_draw_rounded(list, area, style->radius, style->plot_background);
	stilb_ui_rect inside = stilb_ui_inset(area, style->gap);
	float reach = fminf(0.5f * (inside.x1 - inside.x0), inside.y1 - inside.y0 - 2.0f * line);
	stilb_ui_point foot = {0.5f * (inside.x0 + inside.x1), inside.y1 - line};
	float slant = reach * 0.70710678f;
	stilb_ui_draw_line(list, (stilb_ui_point){inside.x0, foot.y}, (stilb_ui_point){inside.x1, foot.y}, 1.0f,
	                   style->control_border);
	stilb_ui_draw_line(list, foot, (stilb_ui_point){foot.x, foot.y - reach}, 1.0f, style->plot_grid);
	stilb_ui_draw_line(list, foot, (stilb_ui_point){foot.x + slant, foot.y - slant}, 1.0f, style->plot_grid);
	stilb_ui_draw_arrow(list, (stilb_ui_point){foot.x - slant, foot.y - slant}, foot, 1.5f, INSPECTOR_ARROW,
	                    style->warning);
	for (int i = 0; i < INSPECTOR_LOBE_POINTS; i++) {
		float angle = SHADE_PI * ((float)i + 0.5f) / INSPECTOR_LOBE_POINTS;
		float length = most > 0.0f ? reach * sqrtf(values[i] / most) : 0.0f;
		points[i] = (stilb_ui_point){foot.x - length * cosf(angle), foot.y - length * sinf(angle)};
	}
	stilb_ui_draw_polyline(list, points, INSPECTOR_LOBE_POINTS, false, 2.0f, style->accent);
	char text[64];
	snprintf(text, sizeof text, "up to %.3g / sr", (double)most);
	stilb_ui_rect words = inside;
	stilb_ui_draw_text(list, font, stilb_ui_cut_top(&words, line), STILB_UI_ALIGN_RIGHT, style->text, text);
	stilb_ui_draw_text(list, font, stilb_ui_cut_bottom(&words, line), STILB_UI_ALIGN_CENTER, style->text_muted,
	                   "length: root of f n·l");
}

/* ---- the window -------------------------------------------------------------------------------------------------- */

/* Places the window: at first at the right of the picture, from then on wherever the user moved it. In a low picture
 * the plot and the sliders are beside the lists instead of below them; in a small one everything shrinks, and the lists
 * scroll. lists: height of the higher column of lists, pixels. */
static void inspector_place(engine_inspector *inspector, const stilb_ui_style *style, const stilb_ui_input *input,
                            float lists)
{
	float gap = 2.0f * style->gap, around = 2.0f * style->margin;
	float head = style->title_height + around + INSPECTOR_BORDER, below = style->gap + inspector_sliders_height(style);
	bool beside = input->height - around < head + lists + below;
	float columns = beside ? 3.0f : 2.0f;
	float wanted_x = columns * (INSPECTOR_COLUMN + gap) - gap + around;
	float wanted_y = head + lists + (beside ? 0.0f : below);
	float width = fmaxf(fminf(wanted_x, input->width - around), INSPECTOR_COLUMN);
	float height = fmaxf(fminf(wanted_y, input->height - around), head);
	float free_x = input->width - width, free_y = input->height - height;
	stilb_ui_rect *place = &inspector->place;
	if (stilb_ui_is_empty(*place))
		*place = (stilb_ui_rect){.x0 = free_x - fminf(around, 0.5f * free_x), .y0 = fminf(around, 0.5f * free_y)};
	else
		place->x0 = place->x1 - width; /* if the width changes, the right edge stays */
	*place = (stilb_ui_rect){place->x0, place->y0, place->x0 + width, place->y0 + height};
	inspector->beside = beside;
}

void engine_inspector_draw(engine_inspector *inspector, stilb_ui *ui, stilb_render_shading *shading,
                           stilb_engine_choice *choice, bool *open)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	float gap = 2.0f * style->gap;
	float lists = inspector_column_height(style, 3, SHADE_NDF_COUNT + SHADE_G_COUNT + SHADE_F_COUNT);
	inspector_place(inspector, style, stilb_ui_input_get(ui), lists);
	stilb_ui_id_push(ui, "inspector");
	stilb_ui_rect area = stilb_ui_panel_begin(ui, "Materials", &inspector->place, STILB_UI_PANEL_MOVABLE, open);
	float columns = inspector->beside ? 3.0f : 2.0f;
	float column = floorf((area.x1 - area.x0 + gap) / columns - gap);
	if (inspector->beside && column < INSPECTOR_SLIDERS) /* lists bear being narrow better than sliders */
		column = fmaxf(floorf(0.5f * (area.x1 - area.x0 - INSPECTOR_SLIDERS) - gap), floorf(0.5f * column));
	stilb_ui_rect rest = area, upper = inspector->beside ? area : stilb_ui_cut_top(&rest, lists), lobe;
	stilb_ui_rect left = stilb_ui_cut_left(&upper, column);
	stilb_ui_cut_left(&upper, gap);
	stilb_ui_rect right = stilb_ui_cut_left(&upper, column);
	if (inspector->beside) {
		stilb_ui_cut_left(&rest, 2.0f * (column + gap));
		float room = rest.y1 - rest.y0 - style->gap - inspector_sliders_height(style);
		lobe = stilb_ui_cut_top(&rest, fmaxf(fminf(room, INSPECTOR_LOBE), 0.0f));
		stilb_ui_cut_top(&rest, style->gap);
	} else {
		stilb_ui_cut_top(&rest, style->gap);
		lobe = stilb_ui_cut_left(&rest, column);
		stilb_ui_cut_left(&rest, gap);
	}
	inspector_lists(inspector, ui, left, right, shading, choice);
	inspector_draw_lobe(ui, lobe, shading);
	inspector_sliders(ui, rest, shading, choice);
	stilb_ui_panel_end(ui);
	stilb_ui_id_pop(ui);
}
