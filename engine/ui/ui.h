/*
 * ui: an immediate-mode user interface. A program says every frame what there is, and each call draws it and answers at
 * once what the user did with it.
 *
 * How it works.  Everything goes into one draw list (ui_draw.h), back to front, and from there as a 2D pass through
 *                command lists like everything else. Who is under the mouse is decided when a frame begins: of all that
 *                reacted last frame, the last one drawn at that place. A widget is known by its id: a hash of its label
 *                and of the ids pushed around it; what follows "##" in a label counts, but is not shown.
 * Layout         is the caller's: every widget gets its rectangle, usually cut off an area (stilb_ui_cut_top, ...).
 * Keys.          Tab and shift Tab go from widget to widget, Escape leaves; Space or Enter press, arrows move sliders
 *                and lists. A click on a slider or a list gives it the keys, a click elsewhere takes them away.
 * Life cycle.    stilb_ui_create -> frames -> stilb_ui_destroy.
 * Per frame.     stilb_ui_begin, widgets and shapes, stilb_ui_end, stilb_ui_record.
 * Threads.       [one-writer] per stilb_ui, [main-thread] where a renderer is involved.
 * Memory.        No allocation once the lists have grown to what is drawn.
 */
#ifndef STILB_UI_H
#define STILB_UI_H

#include "base/base.h"
#include "render/render.h"
#include "ui/ui_draw.h"

typedef struct stilb_ui stilb_ui;

/* ---- life -------------------------------------------------------------------------------------------------------- */

typedef struct stilb_ui_desc {
	stilb_render *render; /* draws what is recorded and holds the glyphs; NULL: nothing can be recorded */
	stilb_ui_aa aa;
	float scale; /* of text and of the style's lengths: 1 for some 96 pixels an inch; 0.5..4 */
} stilb_ui_desc;

/* No renderer, feathered, scale 1. */
stilb_ui_desc stilb_ui_desc_default(void);

/* STILB_ERROR_ARGUMENT: scale. STILB_ERROR_MEMORY, STILB_ERROR_DEVICE: no room for the glyphs. */
stilb_result stilb_ui_create(const stilb_ui_desc *desc, stilb_ui **ui);

/* Before its renderer. NULL is fine. */
void stilb_ui_destroy(stilb_ui *ui);

/* Colours and lengths. */
typedef struct stilb_ui_style {
	stilb_ui_color panel, panel_title, panel_border, shadow;
	stilb_ui_color text, text_muted, text_strong;
	stilb_ui_color control, control_hot, control_active, control_border; /* buttons, boxes, tracks */
	stilb_ui_color accent;                         /* lines and marks of what is on, chosen or has the keys */
	stilb_ui_color accent_face, accent_text;       /* a control that is on */
	stilb_ui_color row_odd, row_hot, row_selected; /* over the panel */
	stilb_ui_color plot_background, plot_grid;
	stilb_ui_color good, warning, bad;
	float margin;         /* around a panel's content */
	float gap;            /* between controls */
	float control_height; /* of a button, a check box, a slider */
	float row_height;     /* of lists */
	float title_height;
	float radius; /* of rounded corners */
	float scroll_bar;
} stilb_ui_style;

/* The style that widgets are drawn with; may be changed between frames. */
stilb_ui_style *stilb_ui_style_get(stilb_ui *ui);

void stilb_ui_aa_set(stilb_ui *ui, stilb_ui_aa aa);

typedef enum stilb_ui_text_kind {
	STILB_UI_TEXT_SMALL,  /* 11 pixels an em at scale 1 */
	STILB_UI_TEXT_NORMAL, /* 13 */
	STILB_UI_TEXT_STRONG, /* 13, bold */
	STILB_UI_TEXT_KINDS
} stilb_ui_text_kind;

const stilb_ui_font *stilb_ui_font_get(const stilb_ui *ui, stilb_ui_text_kind kind);

/* The texture of all draw lists, for who draws a list himself: one byte of coverage a texel, top row first. */
const uint8_t *stilb_ui_glyphs(const stilb_ui *ui, uint32_t *width, uint32_t *height);

/* ---- frame ------------------------------------------------------------------------------------------------------- */

typedef enum stilb_ui_key {
	STILB_UI_KEY_TAB,
	STILB_UI_KEY_ENTER,
	STILB_UI_KEY_SPACE,
	STILB_UI_KEY_ESCAPE,
	STILB_UI_KEY_LEFT,
	STILB_UI_KEY_RIGHT,
	STILB_UI_KEY_UP,
	STILB_UI_KEY_DOWN,
	STILB_UI_KEY_COUNT
} stilb_ui_key;

/* What the user did since the frame before. */
typedef struct stilb_ui_input {
	float width, height;              /* of the picture, pixels */
	bool mouse_present;               /* the pointer is over the picture, and not captured by something else */
	float mouse_x, mouse_y;           /* pixels from the top left */
	bool mouse_down;                  /* the left button is held now */
	uint8_t mouse_presses;            /* how often it went down, so that a click within a frame counts */
	float wheel;                      /* notches, away from the user is positive */
	uint8_t keys[STILB_UI_KEY_COUNT]; /* how often each went down, repeats included */
	bool shift, control;              /* are held now */
	float seconds;                    /* since the frame before */
} stilb_ui_input;

/* Begins a frame with an empty list. */
void stilb_ui_begin(stilb_ui *ui, const stilb_ui_input *input);

/* Ends it: the tooltip is drawn. */
void stilb_ui_end(stilb_ui *ui);

/* Records the list of the ended frame as `pass`, one of kind 2D and with no other segments, on the context of worker;
 * an empty list draws nothing. STILB_ERROR_MEMORY. [main-thread] */
stilb_result stilb_ui_record(stilb_ui *ui, uint32_t pass, uint32_t worker);

/* Whether the mouse or the keys belong to the user interface and to nobody else. Of the frame begun last. */
bool stilb_ui_wants_mouse(const stilb_ui *ui);
bool stilb_ui_wants_keys(const stilb_ui *ui);

/* The list, for shapes of one's own between begin and end. */
stilb_ui_draw_list *stilb_ui_list(stilb_ui *ui);

/* What was given to begin. */
const stilb_ui_input *stilb_ui_input_get(const stilb_ui *ui);

/* Between push and pop ids are hashed with this name or number: for widgets with equal labels. At most
 * STILB_UI_ID_DEPTH deep. */
#define STILB_UI_ID_DEPTH 32
void stilb_ui_id_push(stilb_ui *ui, const char *name);
void stilb_ui_id_push_number(stilb_ui *ui, uint64_t number);
void stilb_ui_id_pop(stilb_ui *ui);

/* ---- something of one's own to point at -------------------------------------------------------------------------- */

/* What the user does with a place of the picture. */
typedef struct stilb_ui_action {
	bool hovered;           /* the mouse is over it and over nothing drawn later */
	bool pressed;           /* the button went down on it in this frame */
	bool held;              /* the button went down on it and is still down, wherever the mouse is */
	bool clicked;           /* the button came up on it, or it was pressed with a key */
	bool double_clicked;    /* pressed for the second time within STILB_UI_DOUBLE_CLICK seconds, hardly moved */
	bool focused;           /* it has the keys */
	float mouse_x, mouse_y; /* pixels from the picture's top left */
	float drag_x, drag_y;   /* how far the mouse went in this frame while held, pixels */
	float total_x, total_y; /* the same since the button went down: tells a drag from a click */
	float wheel;            /* notches while the mouse is over it; 0 when something drawn later took them */
} stilb_ui_action;

#define STILB_UI_DOUBLE_CLICK 0.4f

/* What an area reacts to, beside the mouse's button. */
enum {
	STILB_UI_TAKES_WHEEL = 1,
	STILB_UI_TAKES_KEYS = 2,  /* a stop for Tab */
	STILB_UI_TAKES_FOCUS = 4, /* and a click gives it the keys */
};

/* The part of rect within the clip reacts to the user. */
stilb_ui_action stilb_ui_area(stilb_ui *ui, const char *label, stilb_ui_rect rect, uint32_t takes);

/* ---- panels ------------------------------------------------------------------------------------------------------ */

enum {
	STILB_UI_PANEL_MOVABLE = 1,   /* by its title, *rect follows */
	STILB_UI_PANEL_RESIZABLE = 2, /* by its lower right corner */
};

/* A panel with a title, over what was drawn before; the mouse does not reach through it. With open it has a box that
 * closes it. Returns the area for its content, within which drawing is clipped until the end. A movable panel is kept
 * within the picture. */
stilb_ui_rect stilb_ui_panel_begin(stilb_ui *ui, const char *title, stilb_ui_rect *rect, uint32_t flags, bool *open);
void stilb_ui_panel_end(stilb_ui *ui);

/* ---- widgets ----------------------------------------------------------------------------------------------------- */

/* How wide a control with this label has to be, pixels. Labels are 255 bytes long at most. */
float stilb_ui_label_width(const stilb_ui *ui, const char *label);
float stilb_ui_button_width(const stilb_ui *ui, const char *label);
float stilb_ui_checkbox_width(const stilb_ui *ui, const char *label);

void stilb_ui_label(stilb_ui *ui, stilb_ui_rect rect, stilb_ui_align align, const char *text);
void stilb_ui_label_muted(stilb_ui *ui, stilb_ui_rect rect, stilb_ui_align align, const char *text);

/* True when pressed. */
bool stilb_ui_button(stilb_ui *ui, stilb_ui_rect rect, const char *label);

/* The same with ends round as half its height, for what stands by itself. */
bool stilb_ui_button_rounded(stilb_ui *ui, stilb_ui_rect rect, const char *label);

/* A button that stays down while on; true when pressed, which turns *on over. */
bool stilb_ui_toggle(stilb_ui *ui, stilb_ui_rect rect, const char *label, bool *on);

/* True when *on was turned over. */
bool stilb_ui_checkbox(stilb_ui *ui, stilb_ui_rect rect, const char *label, bool *on);

typedef struct stilb_ui_slider_range {
	float minimum, maximum;
	float step;         /* values are minimum + n * step; 0: all */
	const char *format; /* of the value, a printf format for one double; NULL: "%.2f" */
} stilb_ui_slider_range;

/* True when *value changed. */
bool stilb_ui_slider(stilb_ui *ui, stilb_ui_rect rect, const char *label, float *value,
                     const stilb_ui_slider_range *range);

/* The same, dim: the value has no say at present. */
bool stilb_ui_slider_muted(stilb_ui *ui, stilb_ui_rect rect, const char *label, float *value,
                           const stilb_ui_slider_range *range);

/* Values from left to right as a line over a grid; the value under the mouse is shown. Where maximum <= minimum the
 * values' own range is taken. NaN leaves a gap. */
void stilb_ui_plot(stilb_ui *ui, stilb_ui_rect rect, const char *label, const float *values, uint32_t count,
                   float minimum, float maximum);

/* Text near the mouse, drawn when the frame ends: lines end with '\n'; what stands after a '\t' is aligned to the right
 * in a second column. Of several lines the first is the heading. The last one of a frame counts, its first
 * STILB_UI_TOOLTIP_SIZE - 1 bytes. */
#define STILB_UI_TOOLTIP_SIZE 1024
void stilb_ui_tooltip(stilb_ui *ui, const char *text);

/* ---- lists and tables -------------------------------------------------------------------------------------------- */

#define STILB_UI_NO_ROW UINT32_MAX

/* The caller keeps it from frame to frame; {.selected = STILB_UI_NO_ROW} at first. */
typedef struct stilb_ui_list_state {
	float scroll;      /* pixels from the top */
	uint32_t selected; /* row */
} stilb_ui_list_state;

/* Of one frame. */
typedef struct stilb_ui_rows {
	uint32_t first, end; /* the rows that can be seen: draw these */
	uint32_t hovered;    /* row, or STILB_UI_NO_ROW */
	uint32_t clicked;
	bool changed; /* another row was selected */
	stilb_ui_rect area;
	float row_height, top; /* of row 0 */
	uint32_t selected;
} stilb_ui_rows;

/* A list of row_count rows that scrolls by wheel, bar and arrows; drawing is clipped to it until its end:
 *     stilb_ui_rows rows = stilb_ui_rows_begin(ui, rect, "zones", count, &state);
 *     for (uint32_t row = rows.first; row < rows.end; row++)
 *         stilb_ui_label(ui, stilb_ui_row(ui, &rows, row), STILB_UI_ALIGN_LEFT, names[row]);
 *     stilb_ui_rows_end(ui); */
stilb_ui_rows stilb_ui_rows_begin(stilb_ui *ui, stilb_ui_rect rect, const char *label, uint32_t row_count,
                                  stilb_ui_list_state *state);

/* Draws the row's background and returns its place. */
stilb_ui_rect stilb_ui_row(stilb_ui *ui, const stilb_ui_rows *rows, uint32_t row);
void stilb_ui_rows_end(stilb_ui *ui);

typedef struct stilb_ui_column {
	const char *name;
	float width; /* pixels; 0: what the others leave, for one of them */
	stilb_ui_align align;
} stilb_ui_column;

typedef struct stilb_ui_sort {
	uint32_t column;
	bool descending;
} stilb_ui_sort;

/* The row of column names over a table; a click on one sorts by it, another turns the order over. True when *sort
 * changed. NULL: not to be sorted. */
bool stilb_ui_table_header(stilb_ui *ui, stilb_ui_rect rect, const char *label, const stilb_ui_column *columns,
                           uint32_t column_count, stilb_ui_sort *sort);

/* The place of a column within a row, with room at its sides. [any-thread] */
stilb_ui_rect stilb_ui_table_cell(stilb_ui_rect row, const stilb_ui_column *columns, uint32_t column_count,
                                  uint32_t column);

#endif
