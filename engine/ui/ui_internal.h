/* Inside ui: what the files of the draw list, the fonts and the widgets share. */
#ifndef UI_INTERNAL_H
#define UI_INTERNAL_H

#include "base/base_contract.h"
#include "ui/ui.h"

/* One instruction each, unlike fminf and fmaxf, which are calls because they treat NaN specially. If either argument is
 * NaN, the result is b. */
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

/* The vertices and indices of one shape, inside the list's arrays; valid until the next ui_list_add. */
typedef struct ui_mesh {
	stilb_render_vertex_2d *vertices;
	uint32_t *indices;
	uint32_t first; /* index of vertices[0] in the list's vertices, which the mesh's indices count from */
} ui_mesh;

/* Adds a shape with the list's current clip. The caller fills all vertices and indices of *mesh. False: no memory, and
 * the list's out_of_memory is set. */
bool ui_list_add(stilb_ui_draw_list *list, uint32_t vertex_count, uint32_t index_count, ui_mesh *mesh);

/* True if the rectangle overlaps the clip; false if a coordinate is NaN. */
bool ui_list_sees(const stilb_ui_draw_list *list, float x0, float y0, float x1, float y1);

/* For STILB_CHECK: the commands together hold all indices in order, consecutive commands have different clips, and all
 * indices are of vertices that exist. */
bool ui_list_is_sound(const stilb_ui_draw_list *list);

/* A vertex of a shape without texture: uv (0, 0) is a white texel at a corner of the texture, so that filtering and
 * wrapping change nothing. */
static inline stilb_render_vertex_2d ui_vertex(float x, float y, stilb_ui_color color)
{
	return (stilb_render_vertex_2d){{x, y}, {0.0f, 0.0f}, {color.r, color.g, color.b, color.a}};
}

/* The two triangles of the quadrilateral a b c d, corners in order around it. */
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

/* The TrueType files as they are on disk. */
extern const uint8_t ui_text_sans[] __attribute__((visibility("hidden")));
extern const uint8_t ui_text_bold[] __attribute__((visibility("hidden")));

/* Glyphs are placed at whole pixels vertically and at quarters of a pixel horizontally: each has one picture for each
 * of the four offsets within a pixel, its phases. */
#define UI_GLYPH_PHASES 4

/* Most glyphs of a font. Glyph 0 is the box for characters that the font lacks. */
#define UI_GLYPHS_MAX 256

/* A glyph's picture in the atlas; a texel is a pixel. */
typedef struct ui_glyph {
	uint16_t x, y, width, height; /* rectangle in the atlas; width 0: nothing to draw */
	int16_t left, top;            /* of the rectangle, from the pen on the baseline, y down */
} ui_glyph;

struct stilb_ui_font {
	float line, ascent;           /* see stilb_ui_font_line, stilb_ui_font_ascent */
	float texel_x, texel_y;       /* size of a texel in uv */
	float advance[UI_GLYPHS_MAX]; /* how far each glyph moves the pen, pixels */
	ui_glyph glyphs[UI_GLYPHS_MAX][UI_GLYPH_PHASES];
};

/* All fonts in one picture of coverage (the share of each pixel that a letter covers). Its four corners are 255, for
 * shapes without texture. The lower half repeats the glyphs with the coverage for dark letters. */
typedef struct ui_fonts {
	stilb_ui_font fonts[STILB_UI_TEXT_KINDS];
	uint32_t width, height;
	uint8_t *coverage; /* [height][width] */
} ui_fonts;

/* Draws the glyphs of all kinds of text at this scale, 0.5..4. STILB_ERROR_MEMORY: *fonts needs no ui_fonts_finish. */
stilb_result ui_fonts_init(ui_fonts *fonts, float scale);

/* Frees the picture of the fonts. Accepts {0}. */
void ui_fonts_finish(ui_fonts *fonts);

/* The index of a character in the tables of glyphs; 0 if the fonts lack it. */
uint32_t ui_glyph_index(uint32_t character);

/* The character of a glyph, 0xffff for the box; 0 beyond the last glyph. */
uint32_t ui_glyph_character(uint32_t index);

/* Decodes the next character of UTF-8 text and moves *text behind it. 0: the end. UINT32_MAX: a byte that does not
 * begin a character. */
uint32_t ui_text_next(const char **text);

/* ---- frames and widgets ------------------------------------------------------------------------------------------ */

/* An area that reacts to the user (stilb_ui_area). */
typedef struct ui_item {
	uint64_t id;
	stilb_ui_rect rect; /* its visible part */
	uint32_t takes;     /* STILB_UI_TAKES_... */
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
	stilb_owner writer; /* the thread between begin and end; nobody otherwise */
	bool in_frame;      /* between begin and end */
	stilb_ui_draw_list list;
	stilb_ui_style style;
	ui_fonts fonts;
	float scale;                  /* see stilb_ui_desc */
	stilb_render *render;         /* NULL: nothing can be recorded */
	stilb_render_texture texture; /* of the fonts */

	stilb_ui_input input;
	ui_items now, before; /* the areas of this frame so far, and those of the frame before */

	/* Ids of areas, 0: none. */
	uint64_t hot;                              /* under the mouse */
	uint64_t wheel;                            /* gets the wheel */
	uint64_t active;                           /* the button went down on it and is still held */
	uint64_t pressed, double_clicked, clicked; /* in this frame */
	uint64_t focus;                            /* has the keys */
	uint64_t press_id;                         /* of the area last pressed; 0 if that was a double click */
	float press_x, press_y;                    /* where the button went down last, pixels */
	float press_age;                           /* how long ago that was, seconds */
	float move_x, move_y;                      /* of the mouse in this frame, pixels */

	uint64_t ids[STILB_UI_ID_DEPTH]; /* [id_count] hashes of the pushed names; area ids continue the last one */
	uint32_t id_count;
	ui_panel panels[UI_PANEL_DEPTH]; /* [panel_count] begun and not ended */
	uint32_t panel_count;
	char tooltip[STILB_UI_TOOLTIP_SIZE]; /* "": none */
};

/* Asserts that a function is called between stilb_ui_begin and stilb_ui_end, by the thread that called the first. */
#define UI_ASSERT_IN_FRAME(ui)                                                                                         \
	do {                                                                                                               \
		STILB_ASSERT((ui)->in_frame && "between begin and end");                                                       \
		STILB_ASSERT_OWNER((ui)->writer);                                                                              \
	} while (0)

/* Uploads the glyphs as a texture; on success ui->render is set. */
stilb_result ui_texture_create(stilb_ui *ui, stilb_render *render);

/* The visible part of a label: up to "##", 255 bytes at most. */
typedef struct ui_label {
	char text[256];
} ui_label;
ui_label ui_label_shown(const char *label);

/* Grows an array of `count` elements of `size` bytes so that `more` further ones fit; updates *memory and *capacity.
 * False: no memory, and the array is as before. */
bool ui_reserve(void **memory, uint32_t *capacity, uint32_t count, uint32_t more, size_t size);

/* The outline around an area that has the keys; nothing if it has not. */
void ui_draw_focus(stilb_ui *ui, stilb_ui_rect rect, float radius, const stilb_ui_action *action);

/* Draws the tooltip of this frame, if there is one. */
void ui_tooltip_draw(stilb_ui *ui);

#endif
