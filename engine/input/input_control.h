/*
 * input_control: keyboard, mouse and gamepads together: events and keys in, actions and the camera's pose out.
 *
 *   events of pads (live or recorded) -> stilb_input_control_event, as they come
 *   keys and mouse of the frame       -> stilb_input_control_frame -> actions and pose
 *
 * The pad touched last leads. Touched means: a button was pressed, or a stick or trigger moved by more than the dead
 * zone from its position at the last touch; that position follows slow drift, so a worn stick does not take over.
 * Events of the other pads are only looked at for a touch. The wishes of the leading pad and of the keys are added.
 * When the leading pad is unplugged or the window loses the keyboard, the camera stands still at once.
 *
 *   left stick            fly right, forward
 *   right stick           look
 *   left, right trigger   slower, faster by powers of two
 *   buttons               as the table of actions says; the shoulders fly down and up
 *
 * Life cycle.  create -> a frame: event for each event up to now, then frame -> destroy:
 *
 *     stilb_input_control_create(&settings, &start, now_us, &control);
 *     while (stilb_input_pads_next(pads, now_us, &event))
 *         stilb_input_control_event(control, &event);
 *     stilb_input_control_frame(control, now_us, &keys, focused, &actions, &pose);
 *
 * Threads.  [owner-thread]: all calls from the thread that created the control; asserted. There is no I/O and no clock:
 *           all times are arguments, microseconds.
 */
#ifndef STILB_INPUT_CONTROL_H
#define STILB_INPUT_CONTROL_H

#include "input/input.h"
#include "input/input_camera.h"
#include "input/input_pad.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* Pads at a time; events of more are ignored. */
#define STILB_INPUT_PADS_MAX 16u

typedef struct stilb_input_control_settings {
	stilb_input_camera_settings camera;
	/* Response of both sticks; see stilb_input_stick. */
	float inner, outer, curve;
	/* Factors for the values of the left stick's x and y and the right stick's x and y; 0..10. */
	float sensitivity[4];
	/* True: pushing the right stick up looks down. */
	bool invert_y;
	/* The right trigger pulled to its end doubles the speed so many times, the left one halves it as often; 0..8. */
	float boost;
	/* What keys and buttons do; lives as long as the control. NULL: they move the camera alone. An engine has its own
	 * table. */
	const stilb_input_table *table;
} stilb_input_control_settings;

/* The camera's defaults; inner 0.12, outer 0.95, curve 2; sensitivity 1; not inverted; boost 3; no table.
 * [any-thread] */
stilb_input_control_settings stilb_input_control_settings_default(void);

typedef struct stilb_input_control stilb_input_control;

/* A control without pads, its camera standing still at the pose. STILB_ERROR_MEMORY: *control is then NULL. Asserts the
 * ranges of the settings. The calling thread becomes the owner. */
stilb_result stilb_input_control_create(const stilb_input_control_settings *settings, const stilb_input_pose *pose,
                                        int64_t time_us, stilb_input_control **control);

/* NULL is allowed. [owner-thread] */
void stilb_input_control_destroy(stilb_input_control *control);

/* Takes one event. Events of one pad come in time order, its ADDED or DENIED first; what comes of a pad that was not
 * added, or was removed, is ignored, and so is a pad beyond STILB_INPUT_PADS_MAX. What the event points to is copied.
 * [owner-thread] */
void stilb_input_control_event(stilb_input_control *control, const stilb_input_event *event);

/* Microseconds after a frame for which the keys held in it still count as held. If no frame follows by then, the
 * program is stalled and cannot learn of their release: they count as released until the next frame. */
#define STILB_INPUT_KEYS_US 100000

/* Ends the frame at time_us. keys is what stilb_input_from_window said; *out gets the actions of keys and pads
 * together, and the movement that the camera was told; *pose is the camera at time_us. focused false: the window has
 * lost the keyboard; the camera stands still and presses on pads meanwhile are dropped. keys may be out.
 * [owner-thread] */
void stilb_input_control_frame(stilb_input_control *control, int64_t time_us, const stilb_input_state *keys,
                               bool focused, stilb_input_state *out, stilb_input_pose *pose);

/* Puts the camera elsewhere at time_us, standing still; keys and sticks that are held then accelerate it again. Asserts
 * that the pose is finite. [owner-thread] */
void stilb_input_control_place(stilb_input_control *control, int64_t time_us, const stilb_input_pose *pose);

/* Sets the camera's speed, m/s, finite and >= 0; it takes effect when the camera is placed. [owner-thread] */
void stilb_input_control_set_speed(stilb_input_control *control, float speed);

/* One pad as it is now. */
typedef struct stilb_input_control_pad {
	/* Its number; see stilb_input_event. */
	uint32_t pad;
	/* Valid until the pad is removed. */
	const stilb_input_pad_info *info;
	/* Name of the layout and how it was found; for a pad without a layout its own name and the reason. */
	const char *name, *recognised;
	/* denied: it may not be opened (no permission). leads: it is the leading pad. */
	bool denied, leads;
	stilb_input_pad_state state;
	/* Reports that were decoded, and reports that were refused: a wrong CRC, or too short. */
	uint64_t reports, corrupt;
	/* Time of the last decoded report. */
	int64_t last_us;
} stilb_input_control_pad;

/* Fills pads with those there are and returns their number. [owner-thread] */
uint32_t stilb_input_control_pads(const stilb_input_control *control,
                                  stilb_input_control_pad pads[STILB_INPUT_PADS_MAX]);

/* Number of the leading pad, 0 if none leads. *last_us, which may be NULL, gets the time of its last decoded report and
 * is unchanged if none leads. [owner-thread] */
uint32_t stilb_input_control_leader(const stilb_input_control *control, int64_t *last_us);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
