/*
 * input_orbit: a camera that turns about a point which it looks at. The point is `distance` ahead of the camera and
 * not stored otherwise, so that a camera may orbit, be flown and orbit again.
 *
 *   stilb_input_orbit orbit = {.turn = {-dx * STILB_INPUT_ORBIT_TURN, -dy * STILB_INPUT_ORBIT_TURN}};
 *   stilb_input_orbit_move(&orbit, &pose, &distance);
 *
 * Threads.  [any-thread]
 */
#ifndef STILB_INPUT_ORBIT_H
#define STILB_INPUT_ORBIT_H

#include "input/input_camera.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct stilb_input_orbit {
	float turn[2]; /* yaw to the left and pitch upwards, radians, with the point staying where it is */
	float pan[2];  /* to the right and up, in distances: camera and point move together */
	float closer;  /* steps towards the point, each by the factor STILB_INPUT_ORBIT_STEP; negative: away */
} stilb_input_orbit;

#define STILB_INPUT_ORBIT_STEP 0.9f
#define STILB_INPUT_ORBIT_TURN 3.1415927f /* radians for a drag over the window's height */

/* The distance stays within these, metres. */
#define STILB_INPUT_ORBIT_NEAREST 1e-12f
#define STILB_INPUT_ORBIT_FARTHEST 1e12f

/* Turns, then moves along, then comes closer. The pitch stays within STILB_INPUT_PITCH_LIMIT; values that are not
 * finite count as 0. Asserts that the pose is finite and *distance > 0. */
void stilb_input_orbit_move(const stilb_input_orbit *orbit, stilb_input_pose *pose, float *distance);

#ifdef __cplusplus
}
#endif

#endif
