#include "input/input_orbit.h"

#include "base/base_math.h"

#include <math.h>

static float orbit_finite(float value)
{
	return isfinite(value) ? value : 0.0f;
}

static float orbit_clamp(float value, float low, float high)
{
	return fminf(fmaxf(value, low), high);
}

void stilb_input_orbit_move(const stilb_input_orbit *orbit, stilb_input_pose *pose, float *distance)
{
	STILB_ASSERT(orbit && pose && distance);
	STILB_ASSERT(*distance > 0.0f && isfinite(*distance));
	STILB_ASSERT(isfinite(pose->yaw) && isfinite(pose->pitch) && isfinite(pose->position[0]) &&
	             isfinite(pose->position[1]) && isfinite(pose->position[2]));
	float right = orbit_finite(orbit->pan[0]) * *distance, up = orbit_finite(orbit->pan[1]) * *distance;
	float nearer = orbit_clamp(*distance * powf(STILB_INPUT_ORBIT_STEP, orbit_finite(orbit->closer)),
	                           STILB_INPUT_ORBIT_NEAREST, STILB_INPUT_ORBIT_FARTHEST);
	stilb_mat4 before = stilb_mat4_view((stilb_vec3){0}, pose->yaw, pose->pitch);
	pose->yaw = remainderf(pose->yaw + orbit_finite(orbit->turn[0]), 6.2831853f);
	if (orbit_finite(orbit->turn[1]) != 0.0f) /* a camera of a file may look straight down, until it is turned */
		pose->pitch = orbit_clamp(pose->pitch + orbit->turn[1], -STILB_INPUT_PITCH_LIMIT, STILB_INPUT_PITCH_LIMIT);
	stilb_mat4 after = stilb_mat4_view((stilb_vec3){0}, pose->yaw, pose->pitch);
	const float *was = before.m, *is = after.m; /* rows of a view matrix: the axes to the right, up and backwards */
	for (int i = 0; i < 3; i++, was += 4, is += 4)
		pose->position[i] += nearer * is[2] - *distance * was[2] + right * is[0] + up * is[1];
	*distance = nearer;
}
