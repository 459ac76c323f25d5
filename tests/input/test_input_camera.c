/* input_camera: the formulas against closed forms, the path against a fine numeric solution, and the same path to the
 * bit at every frame rate. */
#include "base/base_math.h"
#include "input/input_camera.h"
#include "support/test.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

#define PI 3.14159265358979323846f
#define SECOND 1000000

/* cmocka's comparison rounds to float first. */
#define assert_close(value, wanted, most)                                                                              \
	do {                                                                                                               \
		double close_value = (value), close_wanted = (wanted);                                                         \
		if (!(fabs(close_value - close_wanted) <= (most)))                                                             \
			fail_msg("%s is %.17g, not %.17g", #value, close_value, close_wanted);                                     \
	} while (0)

/* ---- the helpers ------------------------------------------------------------------------------------------------- */

/* stilb_input_follow from 0 towards 1 at the rate a for a second, in `steps` equal steps. */
static double followed(double a, int steps, double *area)
{
	double value = 0.0;
	*area = 0.0;
	for (int i = 0; i < steps; i++)
		value = stilb_input_follow(value, 1.0, a, 1.0 / steps, area);
	return value;
}

/* The same by the common Euler step value += (target - value) a dt. */
static double lerped(double a, int steps)
{
	double value = 0.0;
	for (int i = 0; i < steps; i++)
		value += (1.0 - value) * a / steps;
	return value;
}

/* Source of the two lerped values: maxest, "A Better Way To Use Lerp To Smooth Things Out", 2015. */
static void test_follow_is_the_same_at_every_rate(void **state)
{
	(void)state;
	assert_close(lerped(1.0, 60), 0.6352, 5e-5);
	assert_close(lerped(1.0, 10), 0.6513, 5e-5);
	static const int rates[] = {1, 3, 10, 20, 30, 60, 144, 1000, 100000};
	for (size_t i = 0; i < sizeof rates / sizeof *rates; i++) {
		double area;
		assert_close(followed(1.0, rates[i], &area), 1.0 - exp(-1.0), 1e-12);
		assert_close(area, exp(-1.0), 1e-12);
		/* The area must be exact; summing the stepped values instead would be wrong by 0.4 to 5.6 %. */
		followed(10.0, rates[i], &area);
		assert_close(area, 1.0 - (1.0 - exp(-10.0)) / 10.0, 1e-12);
	}
}

static void test_follow_never_overshoots(void **state)
{
	(void)state;
	for (uint64_t i = 0; i < 20000; i++) {
		double from = 200.0 * (double)stilb_random_float(1, i) - 100.0;
		double to = 200.0 * (double)stilb_random_float(2, i) - 100.0;
		double a = exp2(40.0 * (double)stilb_random_float(3, i) - 20.0);
		double dt = i % 2 ? 2.0 : exp2(30.0 * (double)stilb_random_float(4, i) - 20.0);
		double area = 0.0, value = stilb_input_follow(from, to, a, dt, &area);
		double low = fmin(from, to), high = fmax(from, to), slack = 1e-13 * 100.0;
		assert_true(from < to ? value <= to : value >= to);
		assert_true(value >= low - slack && value <= high + slack);
		assert_true(area >= low * dt - slack * dt && area <= high * dt + slack * dt);
	}
}

static void test_follow_at_the_ends(void **state)
{
	(void)state;
	double area = 0.0;
	assert_true(stilb_input_follow(3.0, 5.0, 0.0, 2.0, &area) == 3.0 && area == 6.0); /* a 0: stays */
	area = 0.0;
	assert_true(stilb_input_follow(3.0, 5.0, (double)INFINITY, 2.0, &area) == 5.0 && area == 10.0);
	assert_true(stilb_input_follow(3.0, 5.0, 7.0, 0.0, &area) == 3.0 && area == 10.0); /* no time */
	assert_true(stilb_input_follow(3.0, 5.0, (double)INFINITY, 0.0, &area) == 3.0 && area == 10.0);
	assert_true(stilb_input_follow(5.0, 5.0, 7.0, 1.0, NULL) == 5.0);
}

static void test_step_towards(void **state)
{
	(void)state;
	assert_float_equal(stilb_input_step_towards(0.0f, 1.0f, 0.1f), 0.1f, 0.0f);
	assert_float_equal(stilb_input_step_towards(2.0f, 1.0f, 0.25f), 1.75f, 0.0f);
	assert_true(stilb_input_step_towards(0.95f, 1.0f, 0.1f) == 1.0f &&
	            stilb_input_step_towards(1.05f, 1.0f, 0.1f) == 1.0f);
	assert_true(stilb_input_step_towards(1.0f, 1.0f, 0.1f) == 1.0f &&
	            stilb_input_step_towards(0.5f, 1.0f, 0.0f) == 0.5f);
	assert_true(stilb_input_step_towards(-3.0f, 3.0f, INFINITY) == 3.0f);
	for (uint64_t i = 0; i < 1000; i++) { /* from a random value to a random target, never beyond it, where it stays */
		float value = 2.0f * stilb_random_float(1, i) - 1.0f, target = 2.0f * stilb_random_float(2, i) - 1.0f;
		float step = 0.01f + stilb_random_float(3, i), first = value;
		for (int n = 0; n < 300; n++) {
			value = stilb_input_step_towards(value, target, step);
			assert_true(first < target ? value <= target : value >= target);
		}
		assert_true(value == target);
	}
	/* A target that moves away by half a step each time is caught; then, at 3, a target on the other side turns the
	 * value round at once, by one step to 2.5. */
	float value = 0.0f;
	for (int n = 1; n <= 40; n++)
		value = stilb_input_step_towards(value, 1.0f + 0.05f * (float)n, 0.1f);
	assert_true(value == 1.0f + 0.05f * 40.0f);
	value = stilb_input_step_towards(value, -1.0f, 0.5f);
	assert_float_equal(value, 2.5f, 0.0f);
}

static float magnitude(const float v[2])
{
	return hypotf(v[0], v[1]);
}

static void test_stick(void **state)
{
	(void)state;
	float inner = 0.12f, outer = 0.95f;
	for (int angle = 0; angle < 360; angle += 7) {
		float x = cosf((float)angle * PI / 180.0f), y = sinf((float)angle * PI / 180.0f);
		float before = 0.0f;
		for (int i = 0; i <= 140; i++) { /* up to length 1.4: a stick that can be pushed into the corners of a square */
			float m = (float)i * 0.01f, in[2] = {x * m, y * m};
			float out[2];
			stilb_input_stick(in, inner, outer, 2.0f, out);
			float t = fminf(fmaxf((m - inner) / (outer - inner), 0.0f), 1.0f);
			assert_float_equal(magnitude(out), t * t, 1e-5f);
			assert_float_equal(out[0], x * t * t, 1e-5f); /* radial: the direction stays */
			assert_float_equal(out[1], y * t * t, 1e-5f);
			assert_true(magnitude(out) >= before - 1e-6f && magnitude(out) <= 1.0f + 1e-6f);
			if (i <= 12 - 1)
				assert_true(out[0] == 0.0f && out[1] == 0.0f);
			before = magnitude(out);
		}
	}
	float out[2] = {0.5f, 0.0f};
	stilb_input_stick(out, 0.0f, 1.0f, 1.0f, out); /* out is in; without a dead zone and a curve it is unchanged */
	assert_true(out[0] == 0.5f && out[1] == 0.0f);
	stilb_input_stick((const float[2]){0.5f, 0.0f}, 0.4f, 0.4f, 2.0f, out); /* outer <= inner: 0 or 1 */
	assert_true(out[0] == 1.0f && out[1] == 0.0f);
	stilb_input_stick((const float[2]){0.3f, 0.0f}, 0.4f, 0.2f, 2.0f, out);
	assert_true(out[0] == 0.0f && out[1] == 0.0f);
	stilb_input_stick((const float[2]){NAN, 0.5f}, inner, outer, 2.0f, out);
	assert_true(out[0] == 0.0f && out[1] == 0.0f);
	stilb_input_stick((const float[2]){INFINITY, 0.5f}, inner, outer, 2.0f, out);
	assert_true(out[0] == 0.0f && out[1] == 0.0f);
}

/* ---- flying ------------------------------------------------------------------------------------------------------ */

/* All rates are 0: velocity and turning follow at once, so that the expected positions need no exponentials. */
static const stilb_input_camera_settings stiff = {.speed = 12.0f, .turn_rate = 2.0f};

static stilb_input_camera camera_at_origin(const stilb_input_camera_settings *settings, float yaw, float pitch)
{
	return stilb_input_camera_make(settings, &(stilb_input_pose){.yaw = yaw, .pitch = pitch}, 0);
}

/* The pose after flying by this wish for a second from the origin. */
static stilb_input_pose flown(float yaw, float pitch, const stilb_input_wish *wish)
{
	stilb_input_camera camera = camera_at_origin(&stiff, yaw, pitch);
	stilb_input_camera_steer(&camera, 0, wish);
	return stilb_input_camera_at(&camera, SECOND);
}

static stilb_input_pose moved(float yaw, float pitch, float right, float up, float forward)
{
	return flown(yaw, pitch, &(stilb_input_wish){.move = {right, up, forward}});
}

static void assert_position(const stilb_input_pose *pose, float x, float y, float z)
{
	assert_float_equal(pose->position[0], x, 1e-4f);
	assert_float_equal(pose->position[1], y, 1e-4f);
	assert_float_equal(pose->position[2], z, 1e-4f);
}

static void assert_same_pose(const stilb_input_pose *a, const stilb_input_pose *b)
{
	assert_memory_equal(a, b, sizeof *a);
}

static void test_axes(void **state)
{
	(void)state;
	float s = stiff.speed, r = s * sqrtf(0.5f);
	stilb_input_pose pose = moved(0, 0, 0, 0, 1);
	assert_position(&pose, 0, 0, -s);
	pose = moved(0, 0, 1, 0, 0);
	assert_position(&pose, s, 0, 0);
	pose = moved(0, 0, 0, 1, 0);
	assert_position(&pose, 0, s, 0);
	pose = moved(PI / 2, 0, 0, 0, 1); /* turned to the left: along -X */
	assert_position(&pose, -s, 0, 0);
	pose = moved(PI / 2, 0, 1, 0, 0);
	assert_position(&pose, 0, 0, -s);
	pose = moved(0, 0, 1, 0, 1); /* a diagonal is no faster */
	assert_position(&pose, r, 0, -r);
	pose = moved(0, 0, 0.5f, 0, 0); /* half a push is half as fast */
	assert_position(&pose, s / 2, 0, 0);
	pose = moved(0, PI / 4, 0, 0, 1); /* looking up: forward climbs */
	assert_position(&pose, 0, r, -r);
	pose = moved(0, PI / 4, 1, 0, 0); /* no roll: right stays level */
	assert_position(&pose, s, 0, 0);
	pose = moved(1.0f, 1.0f, 0, 1, 0); /* up is the world's */
	assert_position(&pose, 0, s, 0);
	pose = moved(0.3f, -0.4f, -1, -1, -1);
	stilb_input_pose back = moved(0.3f, -0.4f, 1, 1, 1);
	assert_position(&pose, -back.position[0], -back.position[1], -back.position[2]);
}

/* The camera flies along the axes (forward and right) that its pose's yaw and pitch give. */
static void test_axes_are_the_views(void **state)
{
	(void)state;
	for (uint64_t i = 0; i < 50; i++) {
		float yaw = 6.0f * stilb_random_float(1, i) - 3.0f, pitch = 3.0f * stilb_random_float(2, i) - 1.5f;
		stilb_mat4 view = stilb_mat4_view(stilb_vec3_make(0, 0, 0), yaw, pitch);
		stilb_input_pose pose = moved(yaw, pitch, 0, 0, 1.0f / stiff.speed);
		assert_position(&pose, -view.m[2], -view.m[6], -view.m[10]);
		pose = moved(yaw, pitch, 1.0f / stiff.speed, 0, 0);
		assert_position(&pose, view.m[0], view.m[4], view.m[8]);
	}
}

static void test_boost(void **state)
{
	(void)state;
	static const float boosts[] = {0.0f, 1.0f, 3.0f, -2.0f, 2.5849625f, 8.0f};
	for (size_t i = 0; i < sizeof boosts / sizeof *boosts; i++) {
		stilb_input_pose pose = flown(0, 0, &(stilb_input_wish){.move = {0.5f, 0, 0}, .boost = boosts[i]});
		float way = 6.0f * exp2f(boosts[i]);
		assert_float_equal(pose.position[0], way, way * 1e-6f);
	}
}

static void test_turning(void **state)
{
	(void)state;
	stilb_input_pose pose = flown(0, 0, &(stilb_input_wish){.turn = {0.25f, -0.5f}});
	assert_float_equal(pose.yaw, 0.5f, 1e-6f);
	assert_float_equal(pose.pitch, -1.0f, 1e-6f);
	assert_position(&pose, 0, 0, 0);
	pose = flown(3.0f, 0, &(stilb_input_wish){.turn = {1.0f, 0}}); /* through the back: yaw wraps */
	assert_float_equal(pose.yaw, 5.0f - 2.0f * PI, 1e-6f);
	/* A circle: a second at 12 m/s and 2 rad/s lies on a radius of 6 m around (-6, 0, 0). */
	pose = flown(0, 0, &(stilb_input_wish){.move = {0, 0, 1}, .turn = {1.0f, 0}});
	assert_position(&pose, -6.0f + 6.0f * cosf(2.0f), 0, -6.0f * sinf(2.0f));
	pose = flown(0, 0, &(stilb_input_wish){.turn = {10.0f, 0}});
	assert_float_equal(pose.yaw, 20.0f - 6.0f * PI, 1e-5f);
}

static void test_pitch_stops(void **state)
{
	(void)state;
	stilb_input_camera camera = camera_at_origin(&stiff, 0, 0);
	stilb_input_camera_steer(&camera, 0, &(stilb_input_wish){.turn = {0, 1.0f}});
	for (int i = 0; i <= 200; i++)
		assert_true(stilb_input_camera_at(&camera, i * SECOND / 100).pitch <= STILB_INPUT_PITCH_LIMIT);
	stilb_input_pose pose = stilb_input_camera_at(&camera, 2 * SECOND);
	assert_true(pose.pitch == STILB_INPUT_PITCH_LIMIT && STILB_INPUT_PITCH_LIMIT < PI / 2);
	/* Forward is along the view, also while the stick pushes against the pitch limit. */
	camera = stilb_input_camera_make(&stiff, &pose, 2 * SECOND);
	stilb_input_camera_steer(&camera, 2 * SECOND, &(stilb_input_wish){.move = {0, 0, 1}, .turn = {0, 1.0f}});
	pose = stilb_input_camera_at(&camera, 3 * SECOND);
	assert_position(&pose, 0, 12.0f * sinf(STILB_INPUT_PITCH_LIMIT), -12.0f * cosf(STILB_INPUT_PITCH_LIMIT));
	camera = stilb_input_camera_make(&stiff, &(stilb_input_pose){.pitch = STILB_INPUT_PITCH_LIMIT}, 2 * SECOND);
	stilb_input_camera_steer(&camera, 2 * SECOND, &(stilb_input_wish){.turn = {0, 1.0f}});
	/* Turns back at once: turning beyond the limit is not accumulated, neither from the stick nor from the mouse. */
	stilb_input_camera_turn(&camera, 2 * SECOND, 0, 5.0f);
	stilb_input_camera_steer(&camera, 2 * SECOND, &(stilb_input_wish){.turn = {0, -1.0f}});
	pose = stilb_input_camera_at(&camera, 2 * SECOND + SECOND / 10);
	assert_float_equal(pose.pitch, STILB_INPUT_PITCH_LIMIT - 0.2f, 1e-6f);
	stilb_input_camera_turn(&camera, 3 * SECOND, 0, -100.0f);
	assert_true(stilb_input_camera_at(&camera, 4 * SECOND).pitch == -STILB_INPUT_PITCH_LIMIT);

	stilb_input_camera_settings soft = stilb_input_camera_settings_default();
	camera = camera_at_origin(&soft, 0, 1.5f); /* with smoothing too: at the limit the turning rate is 0 */
	stilb_input_camera_steer(&camera, 0, &(stilb_input_wish){.turn = {0, 1.0f}});
	stilb_input_camera_steer(&camera, SECOND, &(stilb_input_wish){.turn = {0, -0.001f}});
	assert_true(camera.turning[1] <= 0.01 * 24.0);
	assert_true(stilb_input_camera_at(&camera, 2 * SECOND).pitch < STILB_INPUT_PITCH_LIMIT);
	stilb_input_pose high = {.pitch = 3.0f};
	camera = stilb_input_camera_make(&soft, &high, 0);
	assert_true(stilb_input_camera_at(&camera, 0).pitch == STILB_INPUT_PITCH_LIMIT);
}

static void test_mouse_turns_at_once(void **state)
{
	(void)state;
	stilb_input_camera camera = camera_at_origin(&stiff, 0.5f, 0.5f);
	stilb_input_camera_turn(&camera, SECOND, 0.25f, -0.25f);
	stilb_input_pose pose = stilb_input_camera_at(&camera, SECOND);
	assert_true(pose.yaw == 0.75f && pose.pitch == 0.25f);
	for (int i = 0; i < 1000; i++) {
		stilb_input_camera_turn(&camera, SECOND, 0.1f, 0);
		assert_true(fabsf(stilb_input_camera_at(&camera, SECOND).yaw) <= PI + 1e-6f);
	}
	assert_float_equal(cosf(stilb_input_camera_at(&camera, SECOND).yaw), cosf(100.75f), 1e-4f);
	/* The part before the turn was flown in the old direction. */
	camera = camera_at_origin(&stiff, 0, 0);
	stilb_input_camera_steer(&camera, 0, &(stilb_input_wish){.move = {0, 0, 1}});
	stilb_input_camera_turn(&camera, SECOND, PI / 2, 0);
	pose = stilb_input_camera_at(&camera, 2 * SECOND);
	assert_position(&pose, -12.0f, 0, -12.0f);
}

/* With e = exp(-a t): from rest towards the speed u, x(t) = u (t - (1 - e) / a); braking from v, x grows by
 * v (1 - e) / a. Accelerating, braking and turning have a rate a each. */
static void test_speed_follows(void **state)
{
	(void)state;
	stilb_input_camera_settings settings = stilb_input_camera_settings_default();
	stilb_input_camera camera = camera_at_origin(&settings, 0, 0);
	stilb_input_camera_steer(&camera, 0, &(stilb_input_wish){.move = {1, 0, 0}});
	for (int64_t t = 0; t <= SECOND; t += 12345) {
		double s = (double)t * 1e-6;
		assert_close((double)stilb_input_camera_at(&camera, t).position[0], 12.0 * (s + expm1(-12.0 * s) / 12.0), 1e-6);
	}
	stilb_input_camera_steer(&camera, SECOND, &(stilb_input_wish){0});
	double start = 12.0 * (1.0 + expm1(-12.0) / 12.0), v = -12.0 * expm1(-12.0);
	assert_close(camera.motion[0], v, 1e-9);
	for (int64_t t = 0; t <= SECOND; t += 12345) {
		double s = (double)t * 1e-6;
		assert_close((double)stilb_input_camera_at(&camera, SECOND + t).position[0],
		             start - v * expm1(-16.0 * s) / 16.0, 2e-6);
	}
	stilb_input_camera_advance(&camera, 5 * SECOND);
	assert_true(camera.motion[0] == 0.0); /* it comes to rest */
	stilb_input_camera_steer(&camera, 6 * SECOND, &(stilb_input_wish){.turn = {1, 0}});
	assert_close((double)stilb_input_camera_at(&camera, 7 * SECOND).yaw, 2.2 * (1.0 + expm1(-24.0) / 24.0), 1e-6);
	stilb_input_camera_steer(&camera, 7 * SECOND,
	                         &(stilb_input_wish){0}); /* the turning ends while the camera stands still */
	assert_close((double)stilb_input_camera_at(&camera, 9 * SECOND).yaw, 2.2, 1e-6);
}

static void test_stop(void **state)
{
	(void)state;
	stilb_input_camera_settings settings = stilb_input_camera_settings_default();
	stilb_input_camera camera = camera_at_origin(&settings, 0, 0);
	stilb_input_wish wish = {.move = {1, 1, 1}, .turn = {1, 1}, .boost = 1};
	stilb_input_camera_steer(&camera, 0, &wish);
	stilb_input_pose before = stilb_input_camera_at(&camera, SECOND / 2);
	stilb_input_camera_stop(&camera, SECOND / 2);
	stilb_input_pose pose = stilb_input_camera_at(&camera, SECOND);
	assert_same_pose(&pose, &before);
	stilb_input_camera_steer(&camera, SECOND, &wish); /* after a stop the same wish counts again */
	pose = stilb_input_camera_at(&camera, 2 * SECOND);
	assert_true(memcmp(&pose, &before, sizeof pose) != 0);
}

/* ---- the path ---------------------------------------------------------------------------------------------------- */

#define WISHES 400u
#define WISHES_SECONDS 5

typedef struct timed_wish {
	int64_t time_us;
	stilb_input_wish wish;
} timed_wish;

static float random_side(uint64_t seed, uint64_t i)
{
	return 2.0f * stilb_random_float(seed, i) - 1.0f;
}

/* Aggressive flying: a new wish every 12.5 ms, some at the same time, all axes at once, at 6 to 96 m/s, with rests. The
 * pitch stays within its limits, where the motion has no kinks. */
static void make_wishes(timed_wish wishes[WISHES], int64_t start_us)
{
	for (uint32_t i = 0; i < WISHES; i++) {
		uint64_t n = i - (i % 8 == 7); /* some wishes are repeated */
		int64_t jitter = (int64_t)(stilb_random_u64(7, n) % 12500);
		wishes[i].time_us = start_us + (int64_t)(i - (i % 8 == 7)) * 12500 + (i % 16 == 7 ? 0 : jitter);
		wishes[i].wish = (stilb_input_wish){
			.move = {random_side(1, n), random_side(2, n), random_side(3, n)},
			.turn = {random_side(4, n), i % 40 < 20 ? 0.4f : -0.4f},
			.boost = 1.0f + 2.0f * random_side(5, n),
		};
		if (i % 50 >= 40)
			wishes[i].wish = (stilb_input_wish){0};
	}
	for (uint32_t i = 1; i < WISHES; i++)
		if (wishes[i].time_us < wishes[i - 1].time_us)
			wishes[i].time_us = wishes[i - 1].time_us;
}

typedef struct flight {
	const timed_wish *wishes;
	uint32_t next;
	stilb_input_camera camera;
} flight;

static flight flight_begin(const timed_wish *wishes, int64_t start_us)
{
	stilb_input_camera_settings settings = stilb_input_camera_settings_default();
	stilb_input_pose pose = {.position = {3, 2, 1}, .yaw = 1.0f, .pitch = -0.2f};
	return (flight){.wishes = wishes, .camera = stilb_input_camera_make(&settings, &pose, start_us)};
}

/* Steers by all wishes up to the frame, then evaluates the pose. */
static stilb_input_pose flight_frame(flight *f, int64_t time_us)
{
	for (; f->next < WISHES && f->wishes[f->next].time_us <= time_us; f->next++)
		stilb_input_camera_steer(&f->camera, f->wishes[f->next].time_us, &f->wishes[f->next].wish);
	stilb_input_camera_advance(&f->camera, time_us);
	return stilb_input_camera_at(&f->camera, time_us);
}

/* Flies through the wishes with `rate` frames a second; poses[i] is the pose after i + 1 seconds. */
static void fly_at_rate(int rate, const timed_wish *wishes, int64_t start_us, stilb_input_pose poses[WISHES_SECONDS])
{
	flight f = flight_begin(wishes, start_us);
	for (int frame = 1; frame <= rate * WISHES_SECONDS; frame++) {
		stilb_input_pose pose = flight_frame(&f, start_us + (int64_t)frame * SECOND / rate);
		if (frame % rate == 0)
			poses[frame / rate - 1] = pose;
	}
}

static void fly_at_odd_times(const timed_wish *wishes, stilb_input_pose poses[WISHES_SECONDS])
{
	flight f = flight_begin(wishes, 0);
	for (uint64_t time = 0, n = 0; time < WISHES_SECONDS * SECOND; n++) {
		uint64_t second = time / SECOND + 1, step = n % 30 == 29 ? 700000 : stilb_random_u64(11, n) % 40000;
		time = time + step < second * SECOND ? time + step : second * SECOND;
		stilb_input_pose pose = flight_frame(&f, (int64_t)time);
		if (time == second * SECOND)
			poses[second - 1] = pose;
	}
}

static void test_path_is_the_same_at_every_rate(void **state)
{
	(void)state;
	timed_wish wishes[WISHES];
	stilb_input_pose wanted[WISHES_SECONDS], poses[WISHES_SECONDS];
	make_wishes(wishes, 0);
	fly_at_rate(60, wishes, 0, wanted);
	assert_true(wanted[0].position[0] != 3.0f && wanted[4].position[0] != wanted[3].position[0]);
	static const int rates[] = {1, 20, 30, 59, 144, 1000};
	for (size_t i = 0; i < sizeof rates / sizeof *rates; i++) {
		fly_at_rate(rates[i], wishes, 0, poses);
		assert_memory_equal(poses, wanted, sizeof poses);
	}
	fly_at_odd_times(wishes, poses);
	assert_memory_equal(poses, wanted, sizeof poses);
	/* A recording is played at another time of day. */
	int64_t later = 86400LL * SECOND + 1234567;
	make_wishes(wishes, later);
	fly_at_rate(60, wishes, later, poses);
	assert_memory_equal(poses, wanted, sizeof poses);
}

/* The camera's state for a reference solution of its differential equations: ten numbers, or their derivatives. */
typedef struct motion_state {
	double v[10]; /* position, motion, yaw, pitch, turning */
} motion_state;

static motion_state motion_slope(const motion_state *at, const stilb_input_camera *wanted)
{
	const double *motion = &at->v[3], yaw = at->v[6], pitch = at->v[7], *turning = &at->v[8];
	double follow = (double)wanted->settings.turn_follow;
	motion_state slope = {{cos(yaw) * motion[0] - sin(yaw) * cos(pitch) * motion[2], motion[1] + sin(pitch) * motion[2],
	                       -sin(yaw) * motion[0] - cos(yaw) * cos(pitch) * motion[2]}};
	for (int i = 0; i < 3; i++)
		slope.v[3 + i] = wanted->follow * (wanted->wanted_motion[i] - motion[i]);
	for (int i = 0; i < 2; i++) {
		slope.v[6 + i] = turning[i];
		slope.v[8 + i] = follow * (wanted->wanted_turning[i] - turning[i]);
	}
	return slope;
}

static motion_state motion_add(const motion_state *a, const motion_state *b, double scale)
{
	motion_state sum;
	for (int i = 0; i < 10; i++)
		sum.v[i] = a->v[i] + b->v[i] * scale;
	return sum;
}

/* The classical method of Runge and Kutta, of fourth order. */
static motion_state motion_step(const motion_state *at, const stilb_input_camera *wanted, double dt)
{
	motion_state a = motion_slope(at, wanted), at_b = motion_add(at, &a, dt / 2);
	motion_state b = motion_slope(&at_b, wanted), at_c = motion_add(at, &b, dt / 2);
	motion_state c = motion_slope(&at_c, wanted), at_d = motion_add(at, &c, dt);
	motion_state d = motion_slope(&at_d, wanted);
	motion_state end = motion_add(at, &a, dt / 6);
	end = motion_add(&end, &b, dt / 3);
	end = motion_add(&end, &c, dt / 3);
	return motion_add(&end, &d, dt / 6);
}

/* Source of the solution: the differential equations alone, in steps of at most 0.25 ms. */
static void test_path_is_the_solution(void **state)
{
	(void)state;
	timed_wish wishes[WISHES];
	make_wishes(wishes, 0);
	flight f = flight_begin(wishes, 0);
	motion_state exact = {{3, 2, 1, 0, 0, 0, 1.0, (double)-0.2f, 0, 0}};
	double worst = 0.0, length = 0.0;
	for (uint32_t i = 0; i + 1 < WISHES; i++) {
		stilb_input_camera *camera = &f.camera;
		stilb_input_camera_steer(camera, wishes[i].time_us, &wishes[i].wish);
		for (int k = 0; k < 3; k++)
			worst = fmax(worst, fabs(camera->position[k] - exact.v[k]) * (camera->time_us == wishes[i].time_us));
		int64_t span = wishes[i + 1].time_us - wishes[i].time_us;
		int steps = (int)(span / 250) + 1;
		for (int s = 0; s < steps; s++) {
			motion_state before = exact;
			exact = motion_step(&exact, camera, (double)span * 1e-6 / steps);
			length += hypot(exact.v[0] - before.v[0], exact.v[2] - before.v[2]);
		}
	}
	print_message("path of %.1f m: at most %.2e m from the solution\n", length, worst);
	assert_true(length > 20.0);
	assert_true(worst < 1e-9);
}

static void test_nothing_new_changes_nothing(void **state)
{
	(void)state;
	stilb_input_camera_settings settings = stilb_input_camera_settings_default();
	stilb_input_wish wish = {.move = {0.3f, 0.1f, 0.9f}, .turn = {0.5f, 0.1f}};
	stilb_input_camera once = camera_at_origin(&settings, 0, 0), often = once;
	stilb_input_camera_steer(&once, 0, &wish);
	for (int i = 0; i < 1000; i++) /* a pad repeats its report */
		stilb_input_camera_steer(&often, i * 997, &wish);
	stilb_input_camera_advance(&once, SECOND);
	stilb_input_camera_advance(&often, SECOND);
	assert_int_equal(once.time_us, often.time_us);
	assert_memory_equal(once.position, often.position, sizeof once.position);
	stilb_input_pose a = stilb_input_camera_at(&once, SECOND), b = stilb_input_camera_at(&often, SECOND);
	assert_same_pose(&a, &b);
	b = stilb_input_camera_at(&once, SECOND); /* evaluating does not change the camera */
	assert_same_pose(&a, &b);
	/* A pose that nothing moves keeps its bits. */
	stilb_input_pose pose = {.position = {0.1f, -7.3f, 1e6f}, .yaw = 3.1f, .pitch = -1.3f};
	stilb_input_camera still = stilb_input_camera_make(&settings, &pose, 5);
	for (int64_t time = 5; time < 3 * SECOND; time += 16667) {
		stilb_input_camera_advance(&still, time);
		b = stilb_input_camera_at(&still, time);
		assert_same_pose(&b, &pose);
	}
}

static void test_nonsense(void **state)
{
	(void)state;
	stilb_input_camera_settings settings = stilb_input_camera_settings_default();
	stilb_input_camera camera = camera_at_origin(&settings, 0, 0);
	stilb_input_pose start = stilb_input_camera_at(&camera, 0);
	stilb_input_camera_steer(
		&camera, 0, &(stilb_input_wish){.move = {NAN, INFINITY, -INFINITY}, .turn = {NAN, INFINITY}, .boost = NAN});
	stilb_input_camera_turn(&camera, 10, NAN, 0);
	stilb_input_camera_turn(&camera, 10, 0, INFINITY);
	stilb_input_pose pose = stilb_input_camera_at(&camera, SECOND);
	assert_same_pose(&pose, &start);
	pose = flown(0, 0, &(stilb_input_wish){.move = {1e30f, 0, 0}, .turn = {0, 0}, .boost = -1e30f});
	assert_position(&pose, 12.0f / 256.0f, 0, 0);
	pose = flown(0, 0, &(stilb_input_wish){.turn = {-1e30f, 0}});
	assert_float_equal(pose.yaw, -20.0f + 6.0f * PI, 1e-5f);

	/* A time before the camera's time_us counts as time_us. */
	camera = camera_at_origin(&settings, 0, 0);
	stilb_input_camera_steer(&camera, SECOND, &(stilb_input_wish){.move = {1, 0, 0}});
	stilb_input_camera_steer(&camera, 0, &(stilb_input_wish){.move = {0, 1, 0}});
	pose = stilb_input_camera_at(&camera, INT64_MIN);
	assert_same_pose(&pose, &start);
	assert_true(camera.time_us == SECOND && camera.wish.move[1] == 1.0f);
	/* After more than STILB_INPUT_GAP_US without a call the camera is where it was at the last call; so it is after the
	 * largest gap between two int64_t times. */
	pose = stilb_input_camera_at(&camera, SECOND + STILB_INPUT_GAP_US);
	assert_true(pose.position[1] > 700.0f);
	pose = stilb_input_camera_at(&camera, SECOND + STILB_INPUT_GAP_US + 1);
	assert_same_pose(&pose, &start);
	camera = stilb_input_camera_make(&settings, &start, INT64_MIN);
	stilb_input_camera_steer(&camera, INT64_MIN + 1, &(stilb_input_wish){.move = {1, 0, 0}});
	stilb_input_camera_advance(&camera, INT64_MAX);
	pose = stilb_input_camera_at(&camera, INT64_MAX);
	assert_same_pose(&pose, &start);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(test_follow_is_the_same_at_every_rate),
		cmocka_unit_test(test_follow_never_overshoots),
		cmocka_unit_test(test_follow_at_the_ends),
		cmocka_unit_test(test_step_towards),
		cmocka_unit_test(test_stick),
		cmocka_unit_test(test_axes),
		cmocka_unit_test(test_axes_are_the_views),
		cmocka_unit_test(test_boost),
		cmocka_unit_test(test_turning),
		cmocka_unit_test(test_pitch_stops),
		cmocka_unit_test(test_mouse_turns_at_once),
		cmocka_unit_test(test_speed_follows),
		cmocka_unit_test(test_stop),
		cmocka_unit_test(test_path_is_the_same_at_every_rate),
		cmocka_unit_test(test_path_is_the_solution),
		cmocka_unit_test(test_nothing_new_changes_nothing),
		cmocka_unit_test(test_nonsense),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
