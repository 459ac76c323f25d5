/*
 * input_actions: what the user can ask for, as a table. A row is one action: its keys, its part of mouse and gamepad,
 * and its help. Input counts by the table (input.h), and every list of keys that a user reads is written from it.
 *
 * Rows.       The first STILB_INPUT_ACTIONS rows, which move the camera, are always there. The engine's follow
 *             (engine.h), then the program's. A row's number is its index in stilb_input_state.actions.
 * Life cycle. None: a stilb_input_table is a value. The strings of its rows live as long as it is used.
 * Threads.    Functions of their arguments. [any-thread]
 * Example.    Two keys of a program's own, the camera's beside them:
 *
 *     enum { JUMP = STILB_INPUT_ACTIONS, DUCK };
 *     static const stilb_input_action own[] = {
 *         {.name = "jump", .keys = {STILB_WINDOW_KEY_SPACE}, .pad = STILB_INPUT_PAD(SOUTH), .help = "jump"},
 *         {.name = "duck", .kind = STILB_INPUT_HELD, .keys = {STILB_WINDOW_KEY_C}, .help = "duck"},
 *     };
 *     stilb_input_table table = stilb_input_table_camera();
 *     if (stilb_input_table_add(&table, own, 2) == STILB_OK)
 *         duck(stilb_input_from_window(&table, &window).actions[DUCK]);
 */
#ifndef STILB_INPUT_ACTIONS_H
#define STILB_INPUT_ACTIONS_H

#include "base/base.h"
#include "input/input_pad.h"
#include "window/window.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* Rows of a table at most. */
#define STILB_INPUT_ACTIONS_MAX 64u

/* What the number of a row in stilb_input_state.actions says. */
typedef enum stilb_input_kind {
	STILB_INPUT_PRESS,  /* how often it was asked for since the last frame, 255 at most */
	STILB_INPUT_REPEAT, /* as PRESS, and repeats of a key that is held count, too */
	STILB_INPUT_SWITCH, /* 1 if this frame flips it: asked for twice between two frames, nothing changes */
	STILB_INPUT_HELD,   /* 1 while one of its keys or buttons is down; it cannot be typed */
	STILB_INPUT_MOTION, /* 0: how far the mouse, wheel or stick moved is in other members of stilb_input_state */
} stilb_input_kind;

/* A part of the mouse; bits of stilb_input_action.mouse. Only rows of kind MOTION have any. */
enum {
	STILB_INPUT_MOUSE_LEFT = 1, /* movement with this button held */
	STILB_INPUT_MOUSE_MIDDLE = 2,
	STILB_INPUT_MOUSE_RIGHT = 4,
	STILB_INPUT_MOUSE_WHEEL = 8,
	STILB_INPUT_MOUSE_DROP = 16, /* a file that is dropped onto the window */
	STILB_INPUT_MOUSE_CLICK = 32,
	STILB_INPUT_MOUSE_DOUBLE = 64, /* double click */
};

/* Bits of stilb_input_action.pad: of a button, by its name in stilb_input_button, as in STILB_INPUT_PAD(SOUTH); of a
 * stick's or a trigger's axis, as in STILB_INPUT_PAD_AXIS(LEFT_X). An axis is only told in help. */
#define STILB_INPUT_PAD(button) (1u << STILB_INPUT_##button)
#define STILB_INPUT_PAD_AXIS(axis) (1u << (16 + STILB_INPUT_##axis))

/* One action. Everything but name and help may be left out. */
typedef struct stilb_input_action {
	const char *name; /* a word or two for messages and the line of main keys; no two rows have the same */
	stilb_input_kind kind;
	stilb_window_key keys[3]; /* any of them asks for it */
	const char *typed; /* printable ASCII characters, each of which does so, too; help names the first; or NULL */
	uint32_t mouse;    /* STILB_INPUT_MOUSE_... */
	uint32_t pad;      /* STILB_INPUT_PAD_... */
	bool main;         /* one of the few keys that a user has to know first */
	const char *help;  /* rows that follow one another with equal help are one line; NULL: the row is not used */
} stilb_input_action;

typedef struct stilb_input_table {
	stilb_input_action rows[STILB_INPUT_ACTIONS_MAX]; /* [count] */
	uint32_t count;
	uint32_t newest; /* the first of the rows that were added last */
} stilb_input_table;

/* The rows that move the camera, the first of every table. Sticks, triggers and mouse move it, too: input_control.h. */
enum {
	STILB_INPUT_FORWARD,
	STILB_INPUT_LEFTWARD,
	STILB_INPUT_BACKWARD,
	STILB_INPUT_RIGHTWARD,
	STILB_INPUT_DOWNWARD,
	STILB_INPUT_UPWARD,
	STILB_INPUT_FASTER,
	STILB_INPUT_SPEED,
	STILB_INPUT_LOOK,
	STILB_INPUT_ACTIONS
};

/* A table of these rows alone. */
stilb_input_table stilb_input_table_camera(void);

/* A table for a window without a camera: these rows are there, but nothing asks for them and help leaves them out. */
stilb_input_table stilb_input_table_plain(void);

/* The keys that a panel takes while it has the keyboard: they are looked up here by all who must know them. */
enum {
	STILB_INPUT_PANEL_NEXT = STILB_INPUT_ACTIONS,
	STILB_INPUT_PANEL_ENTER,
	STILB_INPUT_PANEL_SPACE,
	STILB_INPUT_PANEL_LEAVE,
	STILB_INPUT_PANEL_LEFT,
	STILB_INPUT_PANEL_RIGHT,
	STILB_INPUT_PANEL_UP,
	STILB_INPUT_PANEL_DOWN,
	STILB_INPUT_PANEL_BACK, /* held: NEXT goes back */
	STILB_INPUT_PANEL_ACTIONS
};

/* A plain table of these rows. */
stilb_input_table stilb_input_table_panels(void);

/* Adds rows[0 .. count - 1] to the table. STILB_ERROR_ARGUMENT: a row has no name or that of another; a key, a
 * character, a button or a part of the mouse belongs to two rows, also if one has a letter's key and the other types
 * the letter; a part does not go with the row's kind; there are too many rows. The table is then as before. */
stilb_result stilb_input_table_add(stilb_input_table *table, const stilb_input_action *rows, uint32_t count);

/* One line of help: "W, A, S, D" and so on, "" where there is nothing. Names are UTF-8. */
typedef struct stilb_input_help {
	char keys[64], mouse[64], pad[96];
	const char *name, *help; /* of the first of its rows, */
	uint32_t row;            /* which has this number */
	bool main;               /* one of its rows is */
} stilb_input_help;

/* Fills *line with the next line of help and moves *next on, which is 0 at first. The rows that were added last
 * come first. False: there are no more lines. */
bool stilb_input_help_next(const stilb_input_table *table, uint32_t *next, stilb_input_help *line);

/* The key's name as help shows it, "Page Down"; "" for NONE. */
const char *stilb_input_key_name(stilb_window_key key);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
