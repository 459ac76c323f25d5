/*
 * ui: an immediate-mode user interface. In every frame the program calls a function for each thing that is to be there;
 * the call draws it and returns at once what the user did with it.
 *
 * How it works.  Everything is added to one draw list (ui_draw.h), later calls in front of earlier ones, and recorded
 *                as a 2D pass of the renderer. An area is a rectangle that reacts to mouse or keys; every widget has
 *                one. When a frame begins, the mouse is given to the frontmost of the last frame's areas that it is
 *                over: a new widget reacts from its second frame on. An area is identified by a hash of its label
 *                and of the ids pushed around it (stilb_ui_id_push). The part of a label after "##" is hashed, but not
 *                shown: "Open##2".
 * Layout         is the caller's: every widget is given its rectangle, usually cut off an area (stilb_ui_cut_top, ...).
 * Keys.          Tab and shift Tab move the focus from widget to widget, Escape takes it away; Space or Enter press the
 *                focused widget, arrows move sliders and lists. A click on a slider or a list gives it the focus, a
 *                click elsewhere takes it away.
 * Units.         Pixels of the picture, y down from its top left corner; seconds.
 * Life cycle.    stilb_ui_create -> frames -> stilb_ui_destroy.
 * Per frame.     stilb_ui_begin, widgets and shapes, stilb_ui_end, stilb_ui_record.
 * Threads.       [one-writer]: any thread, but one at a time for each stilb_ui, and the thread that begins a frame
 *                makes all calls until its end. Calls that involve a renderer (create and destroy with one, record) are
 *                [main-thread]. Functions without another word are [one-writer].
 * Memory.        No allocation once the lists have grown to what is drawn.
 * Example.       A panel with a slider and a button:
 *
 *   stilb_ui_begin(ui, &input);
 *   stilb_ui_rect area = stilb_ui_panel_begin(ui, "Light", &place, STILB_UI_PANEL_MOVABLE, &open);
 *   stilb_ui_rect row = stilb_ui_cut_top(&area, stilb_ui_style_get(ui)->control_height);
 *   stilb_ui_slider(ui, row, "Exposure", &exposure, &(stilb_ui_slider_range){-4.0f, 4.0f, 0.1f, "%+.1f"});
 *   stilb_ui_cut_top(&area, stilb_ui_style_get(ui)->gap);
 *   if (stilb_ui_button(ui, stilb_ui_cut_top(&area, stilb_ui_style_get(ui)->control_height), "Reset"))
 *       exposure = 0.0f;
 *   stilb_ui_panel_end(ui);
 *   stilb_ui_end(ui);
 *   result = stilb_ui_record(ui, pass, worker);
 */
#ifndef STILB_UI_H
#define STILB_UI_H

#include "base/base.h"
#include "render/render.h"
#include "ui/ui_draw.h"

typedef struct stilb_ui stilb_ui;

/* ---- life -------------------------------------------------------------------------------------------------------- */

typedef struct stilb_ui_desc {
	stilb_render *render; /* gets the glyphs as a texture and records frames; NULL: nothing can be recorded */
	stilb_ui_aa aa;       /* how edges are smoothed */
	float scale;          /* of text and of the style's lengths, 0.5..4; 1 suits some 96 pixels an inch */
} stilb_ui_desc;

/* No renderer, feathered, scale 1. [any-thread] */
stilb_ui_desc stilb_ui_desc_default(void);

/* Rasterises the glyphs and, with a renderer, uploads them. On failure *ui is NULL. STILB_ERROR_ARGUMENT: scale is out
 * of range. STILB_ERROR_MEMORY, STILB_ERROR_DEVICE: no memory for the glyphs. [any-thread] without a renderer, else
 * [main-thread]. */
stilb_result stilb_ui_create(const stilb_ui_desc *desc, stilb_ui **ui);

/* Frees it, between frames and before its renderer is destroyed. NULL is accepted. [one-writer] without a renderer,
 * else [main-thread]. */
void stilb_ui_destroy(stilb_ui *ui);

/* Colours and lengths; lengths are pixels, already multiplied by the scale. */
typedef struct stilb_ui_style {
	stilb_ui_color panel, panel_title, panel_border, shadow;
	stilb_ui_color text, text_muted, text_strong;
	stilb_ui_color control, control_hot, control_active, control_border; /* buttons, boxes, tracks */
	stilb_ui_color accent;                         /* lines and marks of what is on, chosen or focused */
	stilb_ui_color accent_face, accent_text;       /* face and text of a control that is on */
	stilb_ui_color row_odd, row_hot, row_selected; /* of a list: odd rows, under the mouse, selected; over `panel` */
	stilb_ui_color plot_background, plot_grid;
	stilb_ui_color good, warning, bad;
	float margin;         /* around a panel's content */
	float gap;            /* between controls */
	float control_height; /* of a button, a check box, a slider */
	float row_height;     /* of each row of a list, > 0 */
	float title_height;   /* of a panel's title bar */
	float radius;         /* of rounded corners */
	float scroll_bar;     /* width of the bar of a list */
} stilb_ui_style;

/* The style that widgets are drawn with; may be changed between widgets. Valid until the ui is destroyed. */
stilb_ui_style *stilb_ui_style_get(stilb_ui *ui);

/* Sets how the edges of the shapes drawn from here on are smoothed. */
void stilb_ui_aa_set(stilb_ui *ui, stilb_ui_aa aa);

typedef enum stilb_ui_text_kind {
	STILB_UI_TEXT_SMALL,  /* font size (em) of 11 pixels at scale 1 */
	STILB_UI_TEXT_NORMAL, /* 13 pixels */
	STILB_UI_TEXT_STRONG, /* 13 pixels, bold */
	STILB_UI_TEXT_KINDS
} stilb_ui_text_kind;

/* The font of this kind of text. Valid until the ui is destroyed. [any-thread] */
const stilb_ui_font *stilb_ui_font_get(const stilb_ui *ui, stilb_ui_text_kind kind);

/* The texture of the draw list, for programs that draw the list themselves: *width x *height texels, one byte of
 * coverage each, top row first. Valid until the ui is destroyed. [any-thread] */
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

/* The user's input since the last frame. */
typedef struct stilb_ui_input {
	float width, height;              /* of the picture, pixels, >= 0 */
	bool mouse_present;               /* the pointer is over the picture and not captured by the program */
	float mouse_x, mouse_y;           /* pixels from the top left corner */
	bool mouse_down;                  /* the left button is held now */
	uint8_t mouse_presses;            /* times that the left button went down: also one that is up again is a click */
	float wheel;                      /* notches that the wheel was turned; away from the user is positive */
	uint8_t keys[STILB_UI_KEY_COUNT]; /* times that each key went down, repeats of a held key included */
	bool shift;                       /* the key is held now */
	float seconds;                    /* since the last frame, >= 0 */
} stilb_ui_input;

/* Begins a frame with an empty draw list and decides what mouse and keys do to the areas of the last frame. Copies
 * *input. */
void stilb_ui_begin(stilb_ui *ui, const stilb_ui_input *input);

/* Draws the tooltip and ends the frame. Every panel, list, id and clip that was begun in it has been ended. */
void stilb_ui_end(stilb_ui *ui);

/* Records the draw list of the frame that has ended as pass number `pass` of the renderer's frame, which is of kind 2D
 * and has no other segment (part recorded by one worker), on the context of this worker. An empty list draws nothing.
 * STILB_ERROR_ARGUMENT: created without a renderer. STILB_ERROR_MEMORY: shapes are missing. [main-thread] */
stilb_result stilb_ui_record(stilb_ui *ui, uint32_t pass, uint32_t worker);

/* True if the mouse is over an area or drags one, so that the program should ignore it; as of the last begin. */
bool stilb_ui_wants_mouse(const stilb_ui *ui);

/* True if an area has the focus, so that the program should ignore the keys. */
bool stilb_ui_wants_keys(const stilb_ui *ui);

/* The draw list, for the program's own shapes between begin and end. */
stilb_ui_draw_list *stilb_ui_list(stilb_ui *ui);

/* The input of the last begin. [any-thread] */
const stilb_ui_input *stilb_ui_input_get(const stilb_ui *ui);

/* From push to pop, this name or number is hashed into the ids of areas, so that equal labels differ. At most
 * STILB_UI_ID_DEPTH - 1 deep, of which panels, lists and tables use one or two each. A button in each row of a list:
 *
 *     stilb_ui_id_push_number(ui, row);
 *     if (stilb_ui_button(ui, place, "Delete"))
 *         delete(row);
 *     stilb_ui_id_pop(ui); */
#define STILB_UI_ID_DEPTH 32
void stilb_ui_id_push(stilb_ui *ui, const char *name);
void stilb_ui_id_push_number(stilb_ui *ui, uint64_t number);
void stilb_ui_id_pop(stilb_ui *ui);

/* ---- areas: the base of all widgets, and of the program's own ---------------------------------------------------- */

/* The user's actions on an area in this frame. */
typedef struct stilb_ui_action {
	bool hovered;           /* the mouse is over the area and over no area in front of it */
	bool pressed;           /* the left mouse button went down on it in this frame */
	bool held;              /* the button went down on it and is still down, wherever the mouse is */
	bool clicked;           /* the mouse button was released on it, or it was pressed with a key */
	bool double_clicked;    /* pressed again within STILB_UI_DOUBLE_CLICK seconds and four pixels */
	bool focused;           /* it has the focus: keys act on it */
	float mouse_x, mouse_y; /* pixels from the picture's top left corner */
	float drag_x, drag_y;   /* movement of the mouse in this frame while held, pixels */
	float total_x, total_y; /* movement since the button went down, pixels: tells a drag from a click */
	float wheel;            /* notches while the mouse is over it; 0 if an area in front takes the wheel */
} stilb_ui_action;

#define STILB_UI_DOUBLE_CLICK 0.4f /* seconds */

/* Input that an area reacts to besides the mouse's button. */
enum {
	STILB_UI_TAKES_WHEEL = 1,
	STILB_UI_TAKES_KEYS = 2,  /* Tab stops at it */
	STILB_UI_TAKES_FOCUS = 4, /* a click on it gives it the focus */
};

/* Makes the part of rect within the clip an area that reacts to the user; takes: STILB_UI_TAKES_... Draws nothing.
 * Returns the user's actions on the area of the same id that the last frame had. A handle that can be dragged:
 *
 *     stilb_ui_action action = stilb_ui_area(ui, "handle", rect, 0);
 *     if (action.held)
 *         x += action.drag_x;
 *     stilb_ui_draw_rect(stilb_ui_list(ui), rect, action.hovered || action.held ? bright : dim); */
stilb_ui_action stilb_ui_area(stilb_ui *ui, const char *label, stilb_ui_rect rect, uint32_t takes);

/* ---- panels ------------------------------------------------------------------------------------------------------ */

enum {
	STILB_UI_PANEL_MOVABLE = 1,   /* its title bar can be dragged */
	STILB_UI_PANEL_RESIZABLE = 2, /* its lower right corner can be dragged */
};

/* A panel with a title, in front of everything drawn so far; the mouse does not reach through it. flags:
 * STILB_UI_PANEL_... *rect follows the user's dragging and must live until the end; a movable panel is kept within the
 * picture. With `open` not NULL the panel has a box with a cross, and a click on it sets *open to false. Returns the
 * area for the content, to which drawing is clipped until the end. At most four panels may be open in one another. */
stilb_ui_rect stilb_ui_panel_begin(stilb_ui *ui, const char *title, stilb_ui_rect *rect, uint32_t flags, bool *open);

/* Ends the panel begun last. */
void stilb_ui_panel_end(stilb_ui *ui);

/* ---- widgets ----------------------------------------------------------------------------------------------------- */

/* The width that a control with this label needs, pixels. Of a label at most 255 bytes are shown. [any-thread] */
float stilb_ui_label_width(const stilb_ui *ui, const char *label);
float stilb_ui_button_width(const stilb_ui *ui, const char *label);
float stilb_ui_checkbox_width(const stilb_ui *ui, const char *label);

/* UTF-8 text in rect (stilb_ui_draw_text), in the style's normal or muted text colour. The text is shown as a whole,
 * with any "##". */
void stilb_ui_label(stilb_ui *ui, stilb_ui_rect rect, stilb_ui_align align, const char *text);
void stilb_ui_label_muted(stilb_ui *ui, stilb_ui_rect rect, stilb_ui_align align, const char *text);

/* A button; true if it was pressed, by mouse or keys. */
bool stilb_ui_button(stilb_ui *ui, stilb_ui_rect rect, const char *label);

/* A button with semicircular ends, for one that stands alone. */
bool stilb_ui_button_rounded(stilb_ui *ui, stilb_ui_rect rect, const char *label);

/* A button that stays down while *on; pressing it inverts *on. True if it was pressed. */
bool stilb_ui_toggle(stilb_ui *ui, stilb_ui_rect rect, const char *label, bool *on);

/* A check box at the left end of rect, with its label beside it; pressing it inverts *on. True if it was pressed. */
bool stilb_ui_checkbox(stilb_ui *ui, stilb_ui_rect rect, const char *label, bool *on);

typedef struct stilb_ui_slider_range {
	float minimum, maximum; /* minimum <= maximum */
	float step;             /* > 0: the user chooses among minimum + n * step; 0: any value, arrows move by 1 % */
	const char *format;     /* printf format of the value, for one double; NULL: "%.2f" */
} stilb_ui_slider_range;

/* A slider with its label and value; dragging and the arrow keys change *value. True if it changed. A value outside the
 * range stays as it is until the user moves the slider. */
bool stilb_ui_slider(stilb_ui *ui, stilb_ui_rect rect, const char *label, float *value,
                     const stilb_ui_slider_range *range);

/* A slider in muted colours, for a value that has no effect at present; it can still be moved. */
bool stilb_ui_slider_muted(stilb_ui *ui, stilb_ui_rect rect, const char *label, float *value,
                           const stilb_ui_slider_range *range);

/* values[0 .. count - 1] from left to right as a line over a grid, from minimum at the bottom to maximum at the top; if
 * maximum <= minimum, over the range of the finite values. The value under the mouse is shown in the tooltip. NaN and
 * infinity leave gaps. */
void stilb_ui_plot(stilb_ui *ui, stilb_ui_rect rect, const char *label, const float *values, uint32_t count,
                   float minimum, float maximum);

/* Text near the mouse, copied now and drawn at the end of the frame, in front of everything. Lines are separated by
 * '\n'; text after a '\t' is aligned to the right in a second column. If there are several lines, the first is a
 * heading. A second tooltip in a frame replaces the first. At most STILB_UI_TOOLTIP_SIZE - 1 bytes and 32 lines are
 * shown. */
#define STILB_UI_TOOLTIP_SIZE 1024
void stilb_ui_tooltip(stilb_ui *ui, const char *text);

/* ---- lists and tables -------------------------------------------------------------------------------------------- */

#define STILB_UI_NO_ROW UINT32_MAX

/* State of a list that the caller keeps from frame to frame; {.selected = STILB_UI_NO_ROW} at first. */
typedef struct stilb_ui_list_state {
	float scroll;      /* pixels that are hidden above the visible part */
	uint32_t selected; /* row, or STILB_UI_NO_ROW */
} stilb_ui_list_state;

/* A list in this frame. */
typedef struct stilb_ui_rows {
	uint32_t first, end;   /* the visible rows first .. end - 1: draw these */
	uint32_t hovered;      /* row under the mouse, or STILB_UI_NO_ROW */
	uint32_t clicked;      /* row that was clicked in this frame, or STILB_UI_NO_ROW */
	bool changed;          /* the user selected another row in this frame */
	stilb_ui_rect area;    /* of the rows, without the scroll bar */
	float row_height, top; /* pixels; top: y of row 0's upper edge, which may be above the area */
	uint32_t selected;     /* row, or STILB_UI_NO_ROW */
} stilb_ui_rows;

/* A list of row_count rows, scrolled by wheel, bar and arrow keys. Drawing is clipped to it until stilb_ui_rows_end:
 *
 *     stilb_ui_rows rows = stilb_ui_rows_begin(ui, rect, "zones", count, &state);
 *     for (uint32_t row = rows.first; row < rows.end; row++)
 *         stilb_ui_label(ui, stilb_ui_row(ui, &rows, row), STILB_UI_ALIGN_LEFT, names[row]);
 *     stilb_ui_rows_end(ui); */
stilb_ui_rows stilb_ui_rows_begin(stilb_ui *ui, stilb_ui_rect rect, const char *label, uint32_t row_count,
                                  stilb_ui_list_state *state);

/* Draws the background of a visible row, rows->first .. rows->end - 1, and returns its rectangle. */
stilb_ui_rect stilb_ui_row(stilb_ui *ui, const stilb_ui_rows *rows, uint32_t row);

/* Ends the list begun last. */
void stilb_ui_rows_end(stilb_ui *ui);

typedef struct stilb_ui_column {
	const char *name;
	float width;          /* pixels; 0, for one column at most: the width that the others leave over */
	stilb_ui_align align; /* of its name and cells */
} stilb_ui_column;

/* How a table is sorted. The caller keeps this from frame to frame and sorts its rows by it. */
typedef struct stilb_ui_sort {
	uint32_t column; /* index of the column that is sorted by, < column_count */
	bool descending;
} stilb_ui_sort;

/* The row of column names above a table: columns[0 .. column_count - 1]. A click on a name sorts by it, another click
 * inverts the order. True if *sort changed. sort may be NULL: the table cannot be sorted. A table is this header above
 * a list, whose rows are cut into cells:
 *
 *     if (stilb_ui_table_header(ui, stilb_ui_cut_top(&area, height), "files", columns, 2, &sort))
 *         sort_files(&sort);
 *     stilb_ui_rows rows = stilb_ui_rows_begin(ui, area, "file list", count, &state);
 *     for (uint32_t row = rows.first; row < rows.end; row++) {
 *         stilb_ui_rect place = stilb_ui_row(ui, &rows, row);
 *         stilb_ui_label(ui, stilb_ui_table_cell(place, columns, 2, 0), columns[0].align, files[row].name);
 *         stilb_ui_label(ui, stilb_ui_table_cell(place, columns, 2, 1), columns[1].align, files[row].size);
 *     }
 *     stilb_ui_rows_end(ui); */
bool stilb_ui_table_header(stilb_ui *ui, stilb_ui_rect rect, const char *label, const stilb_ui_column *columns,
                           uint32_t column_count, stilb_ui_sort *sort);

/* The rectangle of a column within a row, less five pixels of padding at its sides. [any-thread] */
stilb_ui_rect stilb_ui_table_cell(stilb_ui_rect row, const stilb_ui_column *columns, uint32_t column_count,
                                  uint32_t column);

#endif
