/* Inside ui: what the parts of the draw list, the fonts and the widgets share. */
#ifndef UI_INTERNAL_H
#define UI_INTERNAL_H

#include "ui/ui.h"

/* One instruction each; fminf and fmaxf are calls, for the sake of NaN. */
static inline float ui_min(float a, float b)
{
	return a < b ? a : b;
}

static inline float ui_max(float a, float b)
{
	return a > b ? a : b;
}

static inline float ui_clamp(float value, float low, float high)
{
	return ui_min(ui_max(value, low), high);
}

/* ---- draw list --------------------------------------------------------------------------------------------------- */

/* Where the vertices of one shape go. */
typedef struct ui_mesh {
	stilb_render_vertex_2d *vertices;
	uint32_t *indices;
	uint32_t first; /* index of vertices[0] */
} ui_mesh;

/* Adds so many vertices and indices, to be filled by the caller, to the list under its clip. False without memory. */
bool ui_list_add(stilb_ui_draw_list *list, uint32_t vertex_count, uint32_t index_count, ui_mesh *mesh);

/* Whether anything of it can be seen; false when it is not a number. */
bool ui_list_sees(const stilb_ui_draw_list *list, float x0, float y0, float x1, float y1);

/* The texture's corners are white, whichever way it is sampled there. */
static inline stilb_render_vertex_2d ui_vertex(float x, float y, stilb_ui_color color)
{
	return (stilb_render_vertex_2d){{x, y}, {0.0f, 0.0f}, {color.r, color.g, color.b, color.a}};
}

/* The two triangles of four corners in order around. */
static inline void ui_quad_indices(uint32_t *indices, uint32_t a, uint32_t b, uint32_t c, uint32_t d)
{
	indices[0] = a;
	indices[1] = b;
	indices[2] = c;
	indices[3] = a;
	indices[4] = c;
	indices[5] = d;
}

/* ---- text -------------------------------------------------------------------------------------------------------- */

/* The TrueType files; each ends where its _end is. */
extern const uint8_t ui_text_sans[] __attribute__((visibility("hidden")));
extern const uint8_t ui_text_bold[] __attribute__((visibility("hidden")));

/* Glyphs stand on whole pixels down and on quarters of a pixel across, and there is a picture for each quarter. */
#define UI_GLYPH_PHASES 4

/* Places in the table of characters: 0 is the box for what is not there. */
#define UI_GLYPHS_MAX 256

/* One picture of a glyph, in pixels that are texels. */
typedef struct ui_glyph {
	uint16_t x, y, width, height; /* in the atlas; nothing to draw where the width is 0 */
	int16_t left, top;            /* of the pen on the baseline, y down */
} ui_glyph;

struct stilb_ui_font {
	float line, ascent;
	float texel_x, texel_y; /* uv of a texel */
	float advance[UI_GLYPHS_MAX];
	ui_glyph glyphs[UI_GLYPHS_MAX][UI_GLYPH_PHASES];
};

/* All fonts in one picture of coverage, whose corners are full. The lower half is the same for dark letters. */
typedef struct ui_fonts {
	stilb_ui_font fonts[STILB_UI_TEXT_KINDS];
	uint32_t width, height;
	uint8_t *coverage; /* [height][width] */
} ui_fonts;

/* Draws the glyphs of all kinds at this scale. STILB_ERROR_MEMORY. */
stilb_result ui_fonts_init(ui_fonts *fonts, float scale);
/* Accepts {0}. */
void ui_fonts_finish(ui_fonts *fonts);

/* The place of a character in the tables of glyphs, 0 when there is none. */
uint32_t ui_glyph_index(uint32_t character);
/* The character of a place; 0 behind the last. */
uint32_t ui_glyph_character(uint32_t index);

/* The next character of UTF-8 text, which moves on; 0 at its end, UINT32_MAX for a byte that is none. */
uint32_t ui_text_next(const char **text);

/* ---- frames and widgets ------------------------------------------------------------------------------------------ */

/* A place that reacted in a frame. */
typedef struct ui_item {
	uint64_t id;
	stilb_ui_rect rect;
	uint32_t takes;
} ui_item;

typedef struct ui_items {
	ui_item *items; /* back to front */
	uint32_t count, capacity;
} ui_items;

/* A panel between its begin and its end. */
typedef struct ui_panel {
	stilb_ui_rect *rect;
	uint32_t flags;
} ui_panel;

#define UI_PANEL_DEPTH 4

struct stilb_ui {
	stilb_ui_draw_list list;
	stilb_ui_style style;
	ui_fonts fonts;
	float scale;
	stilb_render *render;         /* NULL: nothing can be recorded */
	stilb_render_texture texture; /* of the fonts */

	stilb_ui_input input;
	ui_items now, before;                      /* what reacts in this frame, and what did in the one before */
	uint64_t hot;                              /* under the mouse */
	uint64_t wheel;                            /* gets the wheel */
	uint64_t active;                           /* the button is held on it */
	uint64_t pressed, double_clicked, clicked; /* in this frame */
	uint64_t focus;                            /* has the keys */
	float press_x, press_y;                    /* where the button went down last, */
	float press_age;                           /* how long ago, seconds, */
	uint64_t press_id;                         /* and on what */
	float move_x, move_y;                      /* of the mouse in this frame */

	uint64_t ids[STILB_UI_ID_DEPTH]; /* what ids are hashed with; [id_count] */
	uint32_t id_count;
	ui_panel panels[UI_PANEL_DEPTH];
	uint32_t panel_count;
	char tooltip[STILB_UI_TOOLTIP_SIZE];
};

/* Gives the renderer the glyphs; then ui->render is set. */
stilb_result ui_texture_create(stilb_ui *ui, stilb_render *render);

/* The part of a label that is shown: up to "##". */
typedef struct ui_label {
	char text[256];
} ui_label;
ui_label ui_label_shown(const char *label);

/* Room for `more` elements behind count; false without memory. */
bool ui_reserve(void **memory, uint32_t *capacity, uint32_t count, uint32_t more, size_t size);

/* The frame around what has the keys. */
void ui_draw_focus(stilb_ui *ui, stilb_ui_rect rect, float radius, const stilb_ui_action *action);

void ui_tooltip_draw(stilb_ui *ui);

#endif
