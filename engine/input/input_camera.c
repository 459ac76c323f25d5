#include "input/input_camera.h"

#include <math.h>

#define CAMERA_FULL_TURN 6.28318530717958647692
#define CAMERA_MOVE_MAX 1e6f  /* far beyond any: so that its square is a number */
#define CAMERA_TURN_MAX 10.0f /* of the full rate */
#define CAMERA_BOOST_MAX 8.0f
#define CAMERA_SETTLED 1e-9 /* m/s or radians/s from the target: it is there */

/* ---- following ------------------------------------------------------------------------------------------------- */

double stilb_input_follow(double value, double target, double a, double dt, double *area)
{
	double none = 0.0, *sum = area ? area : &none;
	if (!(dt > 0.0))
		return value;
	if (!(a > 0.0)) {
		*sum += value * dt;
		return value;
	}
	double gone = -expm1(-a * dt); /* 1 - e */
	*sum += target * dt + (value - target) * gone / a;
	return target + (value - target) * (1.0 - gone);
}

float stilb_input_step_towards(float value, float target, float step)
{
	float way = target - value;
	return fabsf(way) <= step ? target : value + copysignf(step, way);
}

void stilb_input_stick(const float in[2], float inner, float outer, float curve, float out[2])
{
	float length = hypotf(in[0], in[1]);
	float scale = 0.0f;
	if (isfinite(length) && length > inner) {
		float t = length < outer ? (length - inner) / (outer - inner) : 1.0f;
		scale = powf(t, curve) / length;
	}
	for (int i = 0; i < 2; i++)
		out[i] = scale > 0.0f ? in[i] * scale : 0.0f;
}

/* ---- one step -------------------------------------------------------------------------------------------------- */

stilb_input_camera_settings stilb_input_camera_settings_default(void)
{
	return (stilb_input_camera_settings){
		.speed = 12.0f, .turn_rate = 2.2f, .accelerate = 12.0f, .brake = 16.0f, .turn_follow = 24.0f};
}

static double camera_rate(float a)
{
	return a > 0.0f ? (double)a : (double)INFINITY;
}

static double camera_clamp_pitch(double pitch)
{
	double limit = (double)STILB_INPUT_PITCH_LIMIT;
	return fmax(-limit, fmin(limit, pitch));
}

/* The rate of turning to the left or upwards, after dt seconds; *angle grows by what was turned. */
static double camera_turned(const stilb_input_camera *camera, int axis, double dt, double *angle)
{
	double a = camera_rate(camera->settings.turn_follow);
	return stilb_input_follow(camera->turning[axis], camera->wanted_turning[axis], a, dt, angle);
}

static double camera_moved(const stilb_input_camera *camera, int axis, double dt, double *way)
{
	return stilb_input_follow(camera->motion[axis], camera->wanted_motion[axis], camera->follow, dt, way);
}

/* Adds `motion`, along the axes that the camera has dt seconds on, to the world's `place`. */
static void camera_add(const stilb_input_camera *camera, double dt, const double motion[3], double place[3])
{
	double yaw = camera->yaw, pitch = camera->pitch;
	camera_turned(camera, 0, dt, &yaw);
	camera_turned(camera, 1, dt, &pitch);
	pitch = camera_clamp_pitch(pitch);
	double ahead = cos(pitch) * motion[2];
	place[0] += cos(yaw) * motion[0] - sin(yaw) * ahead;
	place[1] += motion[1] + sin(pitch) * motion[2];
	place[2] += -sin(yaw) * motion[0] - cos(yaw) * ahead;
}

/*
 * Adds the way of dt seconds to `place`: the integral of axes(t) motion(t). With axes(t) = middle + (axes(t) - middle) its
 * first part is the analytic integral of the motion, along the axes of the step's middle; while the view does not turn that
 * is all. The rest is small and smooth: Gauss and Legendre's rule of three points, whose middle one adds nothing.
 * Source of nodes and weights: Abramowitz and Stegun, Handbook of Mathematical Functions, table 25.4, n = 3.
 */
static void camera_way(const stilb_input_camera *camera, double dt, double place[3])
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
		camera_add(camera, nodes[n] * dt, there, place);
	}
	camera_add(camera, 0.5 * dt, middle, place);
}

/* The last of an exponential's way takes for ever and moves nothing. */
static double camera_settle(double value, double target)
{
	return fabs(value - target) < CAMERA_SETTLED ? target : value;
}

static void camera_step(stilb_input_camera *camera, uint64_t dt_us)
{
	double dt = (double)dt_us * 1e-6;
	camera_way(camera, dt, camera->position);
	for (int i = 0; i < 3; i++)
		camera->motion[i] = camera_settle(camera_moved(camera, i, dt, NULL), camera->wanted_motion[i]);
	double *const angles[2] = {&camera->yaw, &camera->pitch};
	for (int i = 0; i < 2; i++)
		camera->turning[i] = camera_settle(camera_turned(camera, i, dt, angles[i]), camera->wanted_turning[i]);
	camera->yaw = remainder(camera->yaw, CAMERA_FULL_TURN);
	if (camera->pitch != camera_clamp_pitch(camera->pitch)) { /* turning beyond the stop is not stored */
		camera->pitch = camera_clamp_pitch(camera->pitch);
		camera->turning[1] = 0.0;
	}
	camera->time_us += (int64_t)dt_us;
}

/* ---- the camera ------------------------------------------------------------------------------------------------ */

static bool camera_stands(const stilb_input_camera *camera)
{
	bool stands = true;
	for (int i = 0; i < 3; i++)
		stands = stands && camera->motion[i] == 0.0 && camera->wanted_motion[i] == 0.0;
	for (int i = 0; i < 2; i++)
		stands = stands && camera->turning[i] == 0.0 && camera->wanted_turning[i] == 0.0;
	return stands;
}

/* Times are whatever a recording says: their difference is taken where it cannot overflow. */
static uint64_t camera_until(const stilb_input_camera *camera, int64_t time_us)
{
	return time_us > camera->time_us ? (uint64_t)time_us - (uint64_t)camera->time_us : 0;
}

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
	uint64_t left = camera_until(camera, time_us);
	if (left > STILB_INPUT_GAP_US)
		camera_stand(camera);
	if (camera_stands(camera))
		camera->time_us = (int64_t)((uint64_t)camera->time_us + (left - left % STILB_INPUT_TICK_US));
	else
		for (; left >= STILB_INPUT_TICK_US; left -= STILB_INPUT_TICK_US)
			camera_step(camera, STILB_INPUT_TICK_US);
}

/* To exactly this time, which is where ticks are counted from now on. */
static void camera_reach(stilb_input_camera *camera, int64_t time_us)
{
	stilb_input_camera_advance(camera, time_us);
	uint64_t left = camera_until(camera, time_us);
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

stilb_input_camera stilb_input_camera_make(const stilb_input_camera_settings *settings, const stilb_input_pose *pose,
                                           int64_t time_us)
{
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
	stilb_input_wish clean = camera_clean_wish(wish);
	if (camera_same_wish(&clean, &camera->wish))
		return;
	camera_reach(camera, time_us);
	camera->wish = clean;
	double move[3] = {(double)clean.move[0], (double)clean.move[1], (double)clean.move[2]};
	/* A keyboard's diagonal is no faster; a stick that is pushed half way stays slow. */
	double speed = (double)camera->settings.speed * exp2((double)clean.boost) / fmax(1.0, camera_length(move));
	for (int i = 0; i < 3; i++)
		camera->wanted_motion[i] = speed * move[i];
	for (int i = 0; i < 2; i++)
		camera->wanted_turning[i] = (double)camera->settings.turn_rate * (double)clean.turn[i];
	bool slower = camera_length(camera->wanted_motion) < camera_length(camera->motion);
	camera->follow = camera_rate(slower ? camera->settings.brake : camera->settings.accelerate);
}

void stilb_input_camera_turn(stilb_input_camera *camera, int64_t time_us, float left, float up)
{
	if (!isfinite(left) || !isfinite(up))
		return;
	camera_reach(camera, time_us);
	camera->yaw = remainder(camera->yaw + (double)left, CAMERA_FULL_TURN);
	camera->pitch = camera_clamp_pitch(camera->pitch + (double)up);
}

void stilb_input_camera_stop(stilb_input_camera *camera, int64_t time_us)
{
	camera_reach(camera, time_us);
	camera_stand(camera);
}

stilb_input_pose stilb_input_camera_at(const stilb_input_camera *camera, int64_t time_us)
{
	stilb_input_camera then = *camera;
	camera_reach(&then, time_us);
	return (stilb_input_pose){
		.position = {(float)then.position[0], (float)then.position[1], (float)then.position[2]},
		.yaw = (float)then.yaw,
		.pitch = (float)then.pitch,
	};
}
