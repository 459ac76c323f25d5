/*
 * input_control: keyboard, mouse and pads together: from what happened to what is wanted, once a frame, and to where the
 * camera is.
 *
 *   events of pads (live or recorded) -> stilb_input_control_event, in time order
 *   keys and mouse of the frame       -> stilb_input_control_frame -> actions and pose
 *
 * The pad last touched leads: a button pressed, a stick or trigger moved by more than the dead zone from where it was at the
 * last touch (what drifts slowly is not touched). The others are heard for nothing but that. The leading pad and the keys
 * add up. When the leading pad is pulled or the window loses the keyboard, the camera stands still at once.
 *
 *   left stick            fly to the right, ahead           A, cross (south)      let it stand still, or go on
 *   right stick           look                              B, circle (east)      next view
 *   left, right trigger   slower, faster, by powers of two  X, square (west)      write a trace
 *   left, right shoulder  fly down, up                      Y, triangle (north)   open or close the profiler
 *   d-pad up, down        one worker more, less             menu, options (start) open or close the materials' window
 *   d-pad right           next view                         view, share (back)    write a picture
 *
 * Threads.  One thread's; no I/O, no clock: all times come in.
 */
#ifndef STILB_INPUT_CONTROL_H
#define STILB_INPUT_CONTROL_H

#include "input/input.h"
#include "input/input_camera.h"
#include "input/input_pad.h"

#define STILB_INPUT_PADS_MAX 16u /* pads beyond are not heard */

typedef struct stilb_input_control_settings {
	stilb_input_camera_settings camera;
	float inner, outer, curve; /* of both sticks; see stilb_input_stick */
	float sensitivity[4];      /* of left x, left y, right x, right y; 0..10 */
	bool invert_y;             /* of the right stick */
	float boost;               /* doublings of the speed at the right trigger's end, halvings at the left one's */
} stilb_input_control_settings;

/* 0.12, 0.95, 2; 1 each; not inverted; 3. */
stilb_input_control_settings stilb_input_control_settings_default(void);

typedef struct stilb_input_control stilb_input_control;

/* STILB_ERROR_MEMORY. */
stilb_result stilb_input_control_create(const stilb_input_control_settings *settings, const stilb_input_pose *pose,
                                        int64_t time_us, stilb_input_control **control);

/* NULL is fine. */
void stilb_input_control_destroy(stilb_input_control *control);

void stilb_input_control_event(stilb_input_control *control, const stilb_input_event *event);

/* Without a frame for longer, nobody knows whether the keys are held: they are not. */
#define STILB_INPUT_KEYS_US 100000

/* Ends the frame: keys is what the window said (its actions and the pads' come out together in *out, with what the camera
 * was told), *pose is where the camera is at time_us. focused false: the window has lost the keyboard, and all stands still;
 * presses of pads meanwhile are not kept. */
void stilb_input_control_frame(stilb_input_control *control, int64_t time_us, const stilb_input_state *keys,
                               bool focused, stilb_input_state *out, stilb_input_pose *pose);

/* Puts the camera elsewhere, standing still. What is wanted goes on. */
void stilb_input_control_place(stilb_input_control *control, int64_t time_us, const stilb_input_pose *pose);

/* One pad as it is now. */
typedef struct stilb_input_control_pad {
	uint32_t pad;                     /* its number */
	const stilb_input_pad_info *info; /* until it is removed */
	const char *name, *recognised;    /* of its layout, or why it has none */
	bool denied, leads;
	stilb_input_pad_state state;
	uint64_t reports, corrupt; /* sound ones with state, and those that were not believed */
	int64_t last_us;           /* of the last sound report */
} stilb_input_control_pad;

/* How many there are, at most STILB_INPUT_PADS_MAX; *pads is filled. */
uint32_t stilb_input_control_pads(const stilb_input_control *control,
                                  stilb_input_control_pad pads[STILB_INPUT_PADS_MAX]);

/* The number of the leading pad, 0: none; and the time of its last sound report (NULL is fine; unchanged without a leader). */
uint32_t stilb_input_control_leader(const stilb_input_control *control, int64_t *last_us);

#endif
