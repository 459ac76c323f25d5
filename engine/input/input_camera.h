/*
 * input_camera: the camera that flies: from wishes, each with its own time, to a place, yaw and pitch at any time, the same
 * at every frame rate.
 *
 * How.  Speed and turning follow the wish with v' = a (u - v), which is solved, not stepped: after dt
 *
 *         v1 = u + (v0 - u) e,  x1 = x0 + u dt + (v0 - u) (1 - e) / a,  e = exp(-a dt)
 *
 *       (so for a = 1 and u = 1 from rest, v = 1 - 1/e after a second at every rate, where v += (u - v) a dt gives 0.6352 at
 *       60 Hz). The speed follows along the camera's own axes, and as these turn, the state goes on in ticks of 4 ms counted
 *       from the last wish, never from a frame: a frame looks at where it is in between and changes nothing. Two runs with
 *       the same wishes at the same times are therefore equal to the bit, whatever the frames between; and as only
 *       differences of times count, so is a recording that is played later.
 *
 * Pure functions of their arguments. [any-thread]
 */
#ifndef STILB_INPUT_CAMERA_H
#define STILB_INPUT_CAMERA_H

#include "base/base.h"

/* Position and direction of what flies; yaw 0 looks along -Z and grows to the left. */
typedef struct stilb_input_pose {
	float position[3];
	float yaw, pitch;
} stilb_input_pose;

/* What is wanted from a moment on. What is not finite counts as 0, what is out of range as its end. */
typedef struct stilb_input_wish {
	float move[3]; /* right, up (along +Y), forward (where it looks); longer than 1 flies like 1 */
	float turn[2]; /* to the left, upwards; of the full rate, [-10, 10] */
	float boost;   /* the speed is 2^boost times what it is; [-8, 8] */
} stilb_input_wish;

/* Rates a are 1/s: after 0.69 / a seconds half of the way is left; 0 follows at once. */
typedef struct stilb_input_camera_settings {
	float speed;       /* m/s */
	float turn_rate;   /* radians/s at the full */
	float accelerate;  /* a of speed after a wish that is no slower than the flight */
	float brake;       /* and after one that is slower */
	float turn_follow; /* a of turning */
} stilb_input_camera_settings;

#define STILB_INPUT_PITCH_LIMIT 1.55f /* radians: short of straight up and down */
#define STILB_INPUT_TICK_US 4000

/* Not asked for longer than this, nobody was there to fly: it has stood still since the gap began. */
#define STILB_INPUT_GAP_US 60000000

/* 12 m/s, 2.2 rad/s, 12, 16, 24. */
stilb_input_camera_settings stilb_input_camera_settings_default(void);

/* To be seen, not changed, from outside. */
typedef struct stilb_input_camera {
	stilb_input_camera_settings settings;
	stilb_input_wish wish;
	double wanted_motion[3], wanted_turning[2]; /* what the wish comes to, and how the motion follows: a, 1/s */
	double follow;
	int64_t time_us;               /* of what stands below: the last wish, or some ticks after it */
	double position[3], motion[3]; /* m; m/s to the right, up, forward */
	double yaw, pitch, turning[2]; /* radians; radians/s to the left, upwards */
} stilb_input_camera;

/* Stands still at the pose. */
stilb_input_camera stilb_input_camera_make(const stilb_input_camera_settings *settings, const stilb_input_pose *pose,
                                           int64_t time_us);

/* From time_us on this is wanted; what is wanted already changes nothing. Times before the last one count as that. */
void stilb_input_camera_steer(stilb_input_camera *camera, int64_t time_us, const stilb_input_wish *wish);

/* Turns at once: the mouse. */
void stilb_input_camera_turn(stilb_input_camera *camera, int64_t time_us, float left, float up);

/* Stands still at once, wants nothing: the pad was pulled, the window lost the keyboard. */
void stilb_input_camera_stop(stilb_input_camera *camera, int64_t time_us);

/* Goes on to the last tick until time_us: once a frame, so that stilb_input_camera_at has a short way. Changes no path. */
void stilb_input_camera_advance(stilb_input_camera *camera, int64_t time_us);

/* Where it is at a time at or after its last wish. */
stilb_input_pose stilb_input_camera_at(const stilb_input_camera *camera, int64_t time_us);

/* Follows a target: value after dt seconds; *area, which may be NULL, grows by the exact integral over them. Never
 * overshoots. a 0: stays; INFINITY: is there at once. */
double stilb_input_follow(double value, double target, double a, double dt, double *area);

/* At most `step` towards the target, from above or from below; lands exactly on it. */
float stilb_input_step_towards(float value, float target, float step);

/* A stick as it is wanted: scaled, radial: nothing within `inner`, all beyond `outer`, in between the magnitude rises as
 * t^curve, the direction stays. The result is at most 1 long. out may be in. */
void stilb_input_stick(const float in[2], float inner, float outer, float curve, float out[2]);

#endif
