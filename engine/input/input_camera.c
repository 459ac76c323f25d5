#include "input/input_camera.h"

#include <math.h>

#define CAMERA_FULL_TURN 6.28318530717958647692
#define CAMERA_MOVE_MAX 1e6f  /* larger than any wish, and its square is still finite */
#define CAMERA_TURN_MAX 10.0f /* of a wish, in multiples of settings.turn_rate */
#define CAMERA_BOOST_MAX 8.0f
#define CAMERA_SETTLED 1e-9 /* m/s or radians/s: velocity and wish that differ by less count as equal */

/* ---- following --------------------------------------------------------------------------------------------------- */

double stilb_input_follow(double value, double target, double a, double dt, double *area)
{
	double unused = 0.0, *sum = area ? area : &unused;
	STILB_ASSERT(!isnan(value) && !isnan(target) && !isnan(a) && !isnan(dt) && "v' = a (target - v) has numbers");
	if (!(dt > 0.0))
		return value;
	if (!(a > 0.0)) {
		*sum += value * dt;
		return value;
	}
	double gone = -expm1(-a * dt); /* 1 - exp(-a dt): the part of the difference that has gone */
	*sum += target * dt + (value - target) * gone / a;
	return target + (value - target) * (1.0 - gone);
}

float stilb_input_step_towards(float value, float target, float step)
{
	STILB_ASSERT(step >= 0.0f && "a step goes towards the target");
	float way = target - value;
	return fabsf(way) <= step ? target : value + copysignf(step, way);
}

void stilb_input_stick(const float in[2], float inner, float outer, float curve, float out[2])
{
	STILB_ASSERT(inner >= 0.0f && outer > 0.0f && "a dead zone and a range");
	STILB_ASSERT(curve > 0.0f && "the response rises");
	float length = hypotf(in[0], in[1]);
	float scale = 0.0f;
	if (isfinite(length) && length > inner) {
		float t = length < outer ? (length - inner) / (outer - inner) : 1.0f;
		scale = powf(t, curve) / length;
	}
	for (int i = 0; i < 2; i++)
		out[i] = scale > 0.0f ? in[i] * scale : 0.0f;
}

/* ---- one step ---------------------------------------------------------------------------------------------------- */

stilb_input_camera_settings stilb_input_camera_settings_default(void)
{
	return (stilb_input_camera_settings){
		.speed = 12.0f, .turn_rate = 2.2f, .accelerate = 12.0f, .brake = 16.0f, .turn_follow = 24.0f};
}

/* The rate in 1/s of a setting. The setting 0 means no smoothing, which is an infinite rate. */
static double camera_rate(float a)
{
	return a > 0.0f ? (double)a : (double)INFINITY;
}

static double camera_clamp_pitch(double pitch)
{
	double limit = (double)STILB_INPUT_PITCH_LIMIT;
	return fmax(-limit, fmin(limit, pitch));
}

/* Turning rate about axis 0 (to the left) or 1 (upwards) after dt seconds; the angle turned is added to *angle. */
static double camera_turned(const stilb_input_camera *camera, int axis, double dt, double *angle)
{
	double a = camera_rate(camera->settings.turn_follow);
	return stilb_input_follow(camera->turning[axis], camera->wanted_turning[axis], a, dt, angle);
}

/* Velocity along one of the camera's axes after dt seconds; the distance flown is added to *way, which may be NULL. */
static double camera_moved(const stilb_input_camera *camera, int axis, double dt, double *way)
{
	return stilb_input_follow(camera->motion[axis], camera->wanted_motion[axis], camera->follow, dt, way);
}

/* Adds a displacement, given along the axes that the camera will have after dt seconds, to the world position. */
static void camera_add(const stilb_input_camera *camera, double dt, const double along[3], double position[3])
{
	double yaw = camera->yaw, pitch = camera->pitch;
	camera_turned(camera, 0, dt, &yaw);
	camera_turned(camera, 1, dt, &pitch);
	pitch = camera_clamp_pitch(pitch);
	double ahead = cos(pitch) * along[2];
	position[0] += cos(yaw) * along[0] - sin(yaw) * ahead;
	position[1] += along[1] + sin(pitch) * along[2];
	position[2] += -sin(yaw) * along[0] - cos(yaw) * ahead;
}

/*
 * Adds the displacement of dt seconds to the position: the integral of A(t) v(t), where A(t) are the camera's axes and
 * v(t) its velocity along them. With Am the axes at the middle of the step, A v = Am v + (A - Am) v. The first part is
 * Am times the closed-form integral of v, and exact; while the view does not turn it is all. The second part is small
 * and smooth and is integrated by Gauss-Legendre quadrature with three points; at the middle point A - Am is 0.
 * Source of nodes and weights: Abramowitz and Stegun, Handbook of Mathematical Functions, table 25.4, n = 3.
 */
static void camera_displace(const stilb_input_camera *camera, double dt, double position[3])
{
	static const double nodes[2] = {0.11270166537925831, 0.88729833462074169};
	double weight = 5.0 / 18.0;
	double middle[3] = {0};
	for (int i = 0; i < 3; i++)
		camera_moved(camera, i, dt, &middle[i]);
	for (int n = 0; n < 2; n++) {
		double there[3];
		for (int i = 0; i < 3; i++) {
			there[i] = camera_moved(camera, i, nodes[n] * dt, NULL) * weight * dt;
			middle[i] -= there[i];
		}
		camera_add(camera, nodes[n] * dt, there, position);
	}
	camera_add(camera, 0.5 * dt, middle, position);
}

/* An exponential never arrives: differences that move nothing visible are dropped, so that a camera comes to rest. */
static double camera_settle(double value, double target)
{
	return fabs(value - target) < CAMERA_SETTLED ? target : value;
}

static void camera_step(stilb_input_camera *camera, uint64_t dt_us)
{
	double dt = (double)dt_us * 1e-6;
	camera_displace(camera, dt, camera->position);
	for (int i = 0; i < 3; i++)
		camera->motion[i] = camera_settle(camera_moved(camera, i, dt, NULL), camera->wanted_motion[i]);
	double *const angles[2] = {&camera->yaw, &camera->pitch};
	for (int i = 0; i < 2; i++)
		camera->turning[i] = camera_settle(camera_turned(camera, i, dt, angles[i]), camera->wanted_turning[i]);
	camera->yaw = remainder(camera->yaw, CAMERA_FULL_TURN);
	if (camera->pitch != camera_clamp_pitch(camera->pitch)) { /* at the limit the turning upwards or downwards ends */
		camera->pitch = camera_clamp_pitch(camera->pitch);
		camera->turning[1] = 0.0;
	}
	camera->time_us += (int64_t)dt_us;
}

/* ---- the camera -------------------------------------------------------------------------------------------------- */

/* For STILB_CHECK: all numbers are finite, and the angles are within their limits. */
static bool camera_is_sound(const stilb_input_camera *camera)
{
	bool sound = camera->follow > 0.0 && isfinite(camera->yaw) && fabs(camera->yaw) <= CAMERA_FULL_TURN / 2 &&
	             fabs(camera->pitch) <= (double)STILB_INPUT_PITCH_LIMIT;
	for (int i = 0; i < 3; i++)
		sound = sound && isfinite(camera->position[i]) && isfinite(camera->motion[i]);
	for (int i = 0; i < 2; i++)
		sound = sound && isfinite(camera->turning[i]);
	return sound;
}

static bool camera_stands(const stilb_input_camera *camera)
{
	bool stands = true;
	for (int i = 0; i < 3; i++)
		stands = stands && camera->motion[i] == 0.0 && camera->wanted_motion[i] == 0.0;
	for (int i = 0; i < 2; i++)
		stands = stands && camera->turning[i] == 0.0 && camera->wanted_turning[i] == 0.0;
	return stands;
}

/* Microseconds from camera->time_us to time_us, 0 if time_us is the earlier one. Unsigned, because times come from
 * recordings and the difference of any two int64_t must not overflow. */
static uint64_t camera_until(const stilb_input_camera *camera, int64_t time_us)
{
	return time_us > camera->time_us ? (uint64_t)time_us - (uint64_t)camera->time_us : 0;
}

/* Stands still from here on, wanting nothing. */
static void camera_stand(stilb_input_camera *camera)
{
	camera->wish = (stilb_input_wish){0};
	for (int i = 0; i < 3; i++)
		camera->motion[i] = camera->wanted_motion[i] = 0.0;
	for (int i = 0; i < 2; i++)
		camera->turning[i] = camera->wanted_turning[i] = 0.0;
}

void stilb_input_camera_advance(stilb_input_camera *camera, int64_t time_us)
{
	STILB_ASSERT(camera && camera->follow > 0.0 && "made by stilb_input_camera_make");
	uint64_t left = camera_until(camera, time_us);
	if (left > STILB_INPUT_GAP_US)
		camera_stand(camera);
	if (camera_stands(camera))
		camera->time_us = (int64_t)((uint64_t)camera->time_us + (left - left % STILB_INPUT_TICK_US));
	else
		for (; left >= STILB_INPUT_TICK_US; left -= STILB_INPUT_TICK_US)
			camera_step(camera, STILB_INPUT_TICK_US);
	STILB_CHECK(camera_is_sound(camera));
}

/* Advances to exactly time_us; from now on ticks are counted from there. */
static void camera_reach(stilb_input_camera *camera, int64_t time_us)
{
	stilb_input_camera_advance(camera, time_us);
	uint64_t left = camera_until(camera, time_us);
	STILB_ASSERT(left < STILB_INPUT_TICK_US);
	if (left > 0)
		camera_step(camera, left);
}

static float camera_clean(float value, float most)
{
	return isfinite(value) ? fmaxf(-most, fminf(most, value)) : 0.0f;
}

static stilb_input_wish camera_clean_wish(const stilb_input_wish *wish)
{
	stilb_input_wish clean = {.boost = camera_clean(wish->boost, CAMERA_BOOST_MAX)};
	for (int i = 0; i < 3; i++)
		clean.move[i] = camera_clean(wish->move[i], CAMERA_MOVE_MAX);
	for (int i = 0; i < 2; i++)
		clean.turn[i] = camera_clean(wish->turn[i], CAMERA_TURN_MAX);
	return clean;
}

static bool camera_same_wish(const stilb_input_wish *a, const stilb_input_wish *b)
{
	bool same = a->boost == b->boost;
	for (int i = 0; i < 3; i++)
		same = same && a->move[i] == b->move[i];
	for (int i = 0; i < 2; i++)
		same = same && a->turn[i] == b->turn[i];
	return same;
}

static double camera_length(const double v[3])
{
	return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/* True if all settings are numbers of at least 0, and speed and turning rate are finite. */
static bool settings_are_sound(const stilb_input_camera_settings *settings)
{
	return settings->speed >= 0.0f && isfinite(settings->speed) && settings->turn_rate >= 0.0f &&
	       isfinite(settings->turn_rate) && settings->accelerate >= 0.0f && settings->brake >= 0.0f &&
	       settings->turn_follow >= 0.0f;
}

static bool pose_is_finite(const stilb_input_pose *pose)
{
	return isfinite(pose->position[0]) && isfinite(pose->position[1]) && isfinite(pose->position[2]) &&
	       isfinite(pose->yaw) && isfinite(pose->pitch);
}

stilb_input_camera stilb_input_camera_make(const stilb_input_camera_settings *settings, const stilb_input_pose *pose,
                                           int64_t time_us)
{
	STILB_ASSERT(settings && settings_are_sound(settings) && "speeds and rates are at least 0");
	STILB_ASSERT(pose && pose_is_finite(pose) && "the camera is somewhere");
	return (stilb_input_camera){
		.settings = *settings,
		.follow = camera_rate(settings->brake),
		.time_us = time_us,
		.position = {(double)pose->position[0], (double)pose->position[1], (double)pose->position[2]},
		.yaw = remainder((double)pose->yaw, CAMERA_FULL_TURN),
		.pitch = camera_clamp_pitch((double)pose->pitch),
	};
}

void stilb_input_camera_steer(stilb_input_camera *camera, int64_t time_us, const stilb_input_wish *wish)
{
	STILB_ASSERT(camera && wish);
	stilb_input_wish clean = camera_clean_wish(wish);
	if (camera_same_wish(&clean, &camera->wish))
		return;
	camera_reach(camera, time_us);
	camera->wish = clean;
	double move[3] = {(double)clean.move[0], (double)clean.move[1], (double)clean.move[2]};
	/* Two keys together are no faster than one; a stick pushed half way flies at half the speed. */
	double speed = (double)camera->settings.speed * exp2((double)clean.boost) / fmax(1.0, camera_length(move));
	for (int i = 0; i < 3; i++)
		camera->wanted_motion[i] = speed * move[i];
	for (int i = 0; i < 2; i++)
		camera->wanted_turning[i] = (double)camera->settings.turn_rate * (double)clean.turn[i];
	bool slower = camera_length(camera->wanted_motion) < camera_length(camera->motion);
	camera->follow = camera_rate(slower ? camera->settings.brake : camera->settings.accelerate);
	STILB_CHECK(camera_is_sound(camera));
}

void stilb_input_camera_turn(stilb_input_camera *camera, int64_t time_us, float left, float up)
{
	if (!isfinite(left) || !isfinite(up))
		return;
	camera_reach(camera, time_us);
	camera->yaw = remainder(camera->yaw + (double)left, CAMERA_FULL_TURN);
	camera->pitch = camera_clamp_pitch(camera->pitch + (double)up);
	STILB_CHECK(camera_is_sound(camera));
}

void stilb_input_camera_stop(stilb_input_camera *camera, int64_t time_us)
{
	camera_reach(camera, time_us);
	camera_stand(camera);
}

stilb_input_pose stilb_input_camera_at(const stilb_input_camera *camera, int64_t time_us)
{
	STILB_ASSERT(camera);
	stilb_input_camera then = *camera;
	camera_reach(&then, time_us);
	return (stilb_input_pose){
		.position = {(float)then.position[0], (float)then.position[1], (float)then.position[2]},
		.yaw = (float)then.yaw,
		.pitch = (float)then.pitch,
	};
}
