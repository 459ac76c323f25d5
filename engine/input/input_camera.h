/*
 * input_camera: a flying camera. A wish is the movement that the user asks for from some time on; from the wishes
 * follow position, yaw and pitch at any time. The path is the same at every frame rate.
 *
 * Model.  Velocity and turning rate v follow the wished value u at the rate a (1/s) by v' = a (u - v). It is solved in
 *         closed form, not stepped; v0 and x0 are velocity and position at first, v1 and x1 those dt seconds later:
 *
 *             v1 = u + (v0 - u) e,  x1 = x0 + u dt + (v0 - u) (1 - e) / a,  e = exp(-a dt)
 *
 *         With a = 1/s and u = 1 from rest v is 1 - 1/2.718 = 0.6321 after a second at every frame rate; stepping
 *         v += (u - v) a dt gives 0.6352 instead at 60 Hz. The velocity is along the camera's own axes. As these turn,
 *         the state advances in ticks of STILB_INPUT_TICK_US counted from the last wish, never from a frame; a frame
 *         evaluates the state between two ticks and does not change it. So the same wishes at the same times give the
 *         same bits whatever frames were drawn between them, and only differences of times count: a recording played
 *         later flies the same path.
 *
 * Life cycle.  A plain value: make -> steer, turn, stop in time order; advance and at once a frame.
 *
 *     stilb_input_camera_settings settings = stilb_input_camera_settings_default();
 *     stilb_input_camera camera = stilb_input_camera_make(&settings, &start, 0);
 *     stilb_input_camera_steer(&camera, 0, &(stilb_input_wish){.move = {0, 0, 1}});
 *     stilb_input_pose pose = stilb_input_camera_at(&camera, 1000000); // after a second of flying ahead
 *
 * Threads.  Functions of their arguments without globals: [any-thread], one thread at a time for one camera.
 * Times.    Microseconds of any clock. A time before the camera's time_us counts as time_us.
 */
#ifndef STILB_INPUT_CAMERA_H
#define STILB_INPUT_CAMERA_H

#include "base/base.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* Position in metres and direction in radians. Yaw 0 looks along -Z and grows to the left, pitch grows
 * upwards. There is no roll. */
typedef struct stilb_input_pose {
	float position[3];
	float yaw, pitch;
} stilb_input_pose;

/* The wanted movement from a time on. A component that is not finite counts as 0, one out of range as the range's
 * end. */
typedef struct stilb_input_wish {
	/* Right, up (along +Y), forward (along the view), relative to the speed; a vector longer than 1 is normalised. */
	float move[3];
	/* To the left, upwards, relative to the turning rate; [-10, 10]. */
	float turn[2];
	/* The speed is multiplied by 2^boost; [-8, 8]. */
	float boost;
} stilb_input_wish;

/* All at least 0 and not NaN. A rate a is in 1/s: after 0.69 / a seconds half of the difference between the present and
 * the wished velocity is left; a = 0 means that there is no smoothing. */
typedef struct stilb_input_camera_settings {
	/* m/s; finite. */
	float speed;
	/* radians/s; finite. */
	float turn_rate;
	/* Rates at which the velocity follows: after a wish for at least the present speed, and after a wish for less. */
	float accelerate, brake;
	/* Rate at which the turning rate follows. */
	float turn_follow;
} stilb_input_camera_settings;

/* Largest pitch upwards and downwards, radians: just short of straight up and down. */
#define STILB_INPUT_PITCH_LIMIT 1.55f

/* Length of a tick, microseconds. */
#define STILB_INPUT_TICK_US 4000

/* Microseconds. If the functions below were not called for longer than this, the program was stopped meanwhile (in a
 * debugger, say), and the camera counts as having stood still since the last call. */
#define STILB_INPUT_GAP_US 60000000

/* 12 m/s, 2.2 radians/s; accelerate 12/s, brake 16/s, turn_follow 24/s. [any-thread] */
stilb_input_camera_settings stilb_input_camera_settings_default(void);

/* The camera's state: may be read and copied, is changed by the functions below alone. */
typedef struct stilb_input_camera {
	stilb_input_camera_settings settings;
	stilb_input_wish wish;
	/* The velocity (m/s) and turning rates (radians/s) that the wish asks for. */
	double wanted_motion[3], wanted_turning[2];
	/* Rate at which the velocity follows, 1/s. */
	double follow;
	/* The time at which the members below hold: that of the last wish, or some ticks after it. */
	int64_t time_us;
	/* position: metres, in the world; motion: m/s to the right, up and forward. */
	double position[3], motion[3];
	/* yaw, pitch: radians; turning: radians/s to the left and upwards. */
	double yaw, pitch, turning[2];
} stilb_input_camera;

/* A camera that stands still at the pose from time_us on; the yaw is brought into [-pi, pi], the pitch to its limit.
 * Asserts that the settings are in their ranges and the pose is finite. [any-thread] */
stilb_input_camera stilb_input_camera_make(const stilb_input_camera_settings *settings, const stilb_input_pose *pose,
                                           int64_t time_us);

/* From time_us on the camera follows this wish. A wish equal to the present one changes nothing, not even the time from
 * which ticks are counted. [any-thread] */
void stilb_input_camera_steer(stilb_input_camera *camera, int64_t time_us, const stilb_input_wish *wish);

/* Turns at once by radians to the left and upwards: the mouse. Does nothing if one of them is not finite.
 * [any-thread] */
void stilb_input_camera_turn(stilb_input_camera *camera, int64_t time_us, float left, float up);

/* Stands still at once and ends the wish; for when the pad was unplugged or the window lost the keyboard.
 * [any-thread] */
void stilb_input_camera_stop(stilb_input_camera *camera, int64_t time_us);

/* Advances the state by whole ticks up to time_us, once a frame, so that stilb_input_camera_at has few ticks to
 * compute. Does not change the path. [any-thread] */
void stilb_input_camera_advance(stilb_input_camera *camera, int64_t time_us);

/* The pose at a time at or after the last wish; the camera is not changed. [any-thread] */
stilb_input_pose stilb_input_camera_at(const stilb_input_camera *camera, int64_t time_us);

/* Solves v' = a (target - v) over dt seconds from v = value: returns v at their end, and adds v's integral over them
 * to *area, which may be NULL. Never overshoots the target. a <= 0: v stays; a = INFINITY: v is at the target at once.
 * dt <= 0: nothing happens. Asserts that no argument is NaN. [any-thread] */
double stilb_input_follow(double value, double target, double a, double dt, double *area);

/* Returns value moved towards target by at most step >= 0; if target is within a step the result is exactly target.
 * Asserts that step >= 0. [any-thread] */
float stilb_input_step_towards(float value, float target, float step);

/* Response of a stick: scaled radial dead zone. If in, as a vector, is no longer than `inner`, the result is 0; from
 * `outer` on the result's length is 1; in between it is t^curve with t = (length - inner) / (outer - inner), so there
 * is no jump at the edge. The direction is kept. With outer <= inner the result is 0 up to the length inner and of
 * length 1 beyond it. A stick that is not finite gives 0. out may be in. Asserts inner >= 0, outer > 0 and curve > 0.
 * [any-thread] */
void stilb_input_stick(const float in[2], float inner, float outer, float curve, float out[2]);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
