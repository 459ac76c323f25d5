/* shade_bump.h: against height fields whose normals are known, and against rays of the pixels next door, in double. */

#include "shading/shade_bump.h"

#include "shading/shade_frame.h"
#include "support/shade_proof.h"

static stilb_vec3 scaled_step(shade_proof_random *random, shade_frame frame, float angle)
{
	float length = shade_proof_log_range(random, 1e-6f, 1e3f);
	return (frame.t * cosf(angle) + frame.b * sinf(angle)) * length;
}

static shade_frame random_frame(shade_proof_random *random)
{
	return shade_frame_from_normal(shade_proof_random_direction(random));
}

static double dot3(const double a[3], const double b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void unit3(double v[3])
{
	double length = sqrt(dot3(v, v));
	for (int axis = 0; axis < 3; axis++)
		v[axis] /= length;
}

static stilb_vec3 from_doubles(const double v[3])
{
	return stilb_vec3_make((float)v[0], (float)v[1], (float)v[2]);
}

/* ---- the gradient ------------------------------------------------------------------------------------------------ */

/* Where the height is g . p, it grows fastest along g without g's part across the surface: whatever the two steps
 * are. */
static void gradient_is_the_fields(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 1};
	for (int k = 0; k < 1000; k++) {
		shade_frame frame = random_frame(&random);
		stilb_vec3 g = shade_proof_random_direction(&random);
		float first = shade_proof_range(&random, 0.0f, 6.28f);
		float turn = shade_proof_range(&random, 0.3f, 2.8f) * (k % 2 ? 1.0f : -1.0f); /* right- and left-handed */
		stilb_vec3 ds = scaled_step(&random, frame, first), dt = scaled_step(&random, frame, first + turn);
		stilb_vec3 want = g - frame.n * stilb_vec3_dot(g, frame.n);
		stilb_vec3 got = shade_bump_gradient(frame.n, ds, dt, stilb_vec3_dot(g, ds), stilb_vec3_dot(g, dt));
		SHADE_PROOF_NEAR3(got, want[0], want[1], want[2], 0.0, 5e-6);
	}
}

/* A slope of 1 along +X, then along +Z: with one component at a time a wrong sign is recognised as such. */
static void gradient_points_uphill(void **state)
{
	(void)state;
	stilb_vec3 up = stilb_vec3_make(0.0f, 1.0f, 0.0f);
	stilb_vec3 x = stilb_vec3_make(2.0f, 0.0f, 0.0f), z = stilb_vec3_make(0.0f, 0.0f, 0.5f);
	SHADE_PROOF_NEAR3(shade_bump_gradient(up, x, z, 2.0f, 0.0f), 1.0, 0.0, 0.0, 0.0, 1e-7);
	SHADE_PROOF_NEAR3(shade_bump_gradient(up, x, z, 0.0f, 0.5f), 0.0, 0.0, 1.0, 0.0, 1e-7);
	SHADE_PROOF_NEAR3(shade_bump_gradient(up, z, x, 0.5f, 0.0f), 0.0, 0.0, 1.0, 0.0, 1e-7);
	SHADE_PROOF_NEAR3(shade_bump_gradient(up, x, -z, 0.0f, 0.5f), 0.0, 0.0, -1.0, 0.0, 1e-7);
	/* The normal leans away from where it goes up; half the height, half the lean. */
	SHADE_PROOF_NEAR3(shade_bump_normal(up, stilb_vec3_make(1.0f, 0.0f, 0.0f), 1.0f), -sqrt(0.5), sqrt(0.5), 0.0, 0.0,
	                  1e-7);
	SHADE_PROOF_NEAR3(shade_bump_normal(up, stilb_vec3_make(3.0f, 0.0f, 0.0f), -0.25f), 0.6, 0.8, 0.0, 0.0, 1e-7);
}

/* ---- on a plane: exact ------------------------------------------------------------------------------------------- */

/* Hills over the plane y = 0, their slopes, and the normal of the surface y = height. */
static double hills(double x, double z)
{
	return 0.3 * sin(2.0 * x) * cos(3.0 * z) + 0.1 * x * z;
}

static double hills_dx(double x, double z)
{
	return 0.6 * cos(2.0 * x) * cos(3.0 * z) + 0.1 * z;
}

static double hills_dz(double x, double z)
{
	return -0.9 * sin(2.0 * x) * sin(3.0 * z) + 0.1 * x;
}

static void hills_normal(double x, double z, double scale, double n[3])
{
	n[0] = -scale * hills_dx(x, z);
	n[1] = 1.0;
	n[2] = -scale * hills_dz(x, z);
	unit3(n);
}

/* uv on the plane: turned, stretched and mirrored, so that u and v mix. p = (x, 0, z). */
static const double du_dx = 0.5, du_dz = 0.2, dv_dx = 0.3, dv_dz = -0.8;

static stilb_vec2 duv_of(stilb_vec3 dp)
{
	double dx = (double)dp[0], dz = (double)dp[2];
	return (stilb_vec2){(float)(du_dx * dx + du_dz * dz), (float)(dv_dx * dx + dv_dz * dz)};
}

/* dh/du and dh/dv from dh/dx and dh/dz: the transposed map's inverse. */
static stilb_vec2 derivatives_in_uv(double x, double z)
{
	double determinant = du_dx * dv_dz - du_dz * dv_dx;
	double hx = hills_dx(x, z), hz = hills_dz(x, z);
	return (stilb_vec2){(float)((dv_dz * hx - dv_dx * hz) / determinant),
	                    (float)((du_dx * hz - du_dz * hx) / determinant)};
}

static void bumped_plane_has_the_hills_normal(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 2};
	stilb_vec3 up = stilb_vec3_make(0.0f, 1.0f, 0.0f);
	for (int k = 0; k < 300; k++) {
		double x = (double)shade_proof_range(&random, -2.0f, 2.0f), z = (double)shade_proof_range(&random, -2.0f, 2.0f);
		float scale = shade_proof_range(&random, -2.0f, 2.0f);
		stilb_vec3 dp_dx = stilb_vec3_make(0.01f, 0.0f, 0.004f), dp_dy = stilb_vec3_make(-0.002f, 0.0f, 0.03f);
		float dh_dx = (float)(hills_dx(x, z) * (double)dp_dx[0] + hills_dz(x, z) * (double)dp_dx[2]);
		float dh_dy = (float)(hills_dx(x, z) * (double)dp_dy[0] + hills_dz(x, z) * (double)dp_dy[2]);
		double n[3];
		hills_normal(x, z, (double)scale, n);
		SHADE_PROOF_NEAR3(shade_bump_from_height(up, dp_dx, dp_dy, dh_dx, dh_dy, scale), n[0], n[1], n[2], 0.0, 2e-6);
		stilb_vec2 duv_dx = duv_of(dp_dx), duv_dy = duv_of(dp_dy), slope = derivatives_in_uv(x, z);
		SHADE_PROOF_NEAR(shade_bump_chain_rule(slope, duv_dx), (double)dh_dx, 0.0, 1e-7);
		SHADE_PROOF_NEAR3(shade_bump_from_derivatives(up, dp_dx, dp_dy, slope, duv_dx, duv_dy, scale), n[0], n[1], n[2],
		                  0.0, 2e-6);
	}
}

static void texels_become_uv(void **state)
{
	(void)state;
	stilb_vec2 per_uv = shade_bump_derivatives_per_uv((stilb_vec2){0.25f, -0.5f}, (stilb_vec2){512.0f, 64.0f});
	assert_true(per_uv[0] == 128.0f && per_uv[1] == -32.0f);
}

/* A camera 3 m above the plane; where its ray through the pixel (x, y) meets y = 0. */
static void plane_hit(double x, double y, double p[3])
{
	const double direction[3] = {x, -1.0, 0.2 + y};
	for (int axis = 0; axis < 3; axis++)
		p[axis] = 3.0 * direction[axis];
	p[1] = 0.0;
}

/* Largest component of the error when the differences are those between real pixels of this size. */
static double pixel_error(double pixel)
{
	double p[3], right[3], down[3], n[3], error = 0.0;
	plane_hit(0.31, 0.17, p);
	plane_hit(0.31 + pixel, 0.17, right);
	plane_hit(0.31, 0.17 + pixel, down);
	float dh_dx = (float)(hills(right[0], right[2]) - hills(p[0], p[2]));
	float dh_dy = (float)(hills(down[0], down[2]) - hills(p[0], p[2]));
	double dx[3] = {right[0] - p[0], 0.0, right[2] - p[2]}, dy[3] = {down[0] - p[0], 0.0, down[2] - p[2]};
	stilb_vec3 up = stilb_vec3_make(0.0f, 1.0f, 0.0f);
	stilb_vec3 got = shade_bump_from_height(up, from_doubles(dx), from_doubles(dy), dh_dx, dh_dy, 1.0f);
	hills_normal(p[0], p[2], 1.0, n);
	for (int axis = 0; axis < 3; axis++)
		error = fmax(error, fabs((double)got[axis] - n[axis]));
	return error;
}

/* dFdx and dFdy are one-sided differences: half the pixel, half the error. */
static void pixel_differences_converge(void **state)
{
	(void)state;
	double coarse = pixel_error(4e-3), fine = pixel_error(2e-3);
	assert_true(coarse < 0.03);
	SHADE_PROOF_NEAR(coarse / fine, 2.0, 0.05, 0.0);
}

/* ---- on a sphere: off by height / radius ------------------------------------------------------------------------- */

/* Angle between the bumped normal and that of the surface p (1 + h / radius), the height being amplitude * w . p /
 * radius on a sphere: the gradient is amplitude / radius * (w - n (w . n)), and the surface's normal n - gradient / (1
 * + h / r). */
static double sphere_error(double amplitude, double *bound)
{
	double w[3] = {0.6, 0.5, -0.7}, n[3] = {0.3, 0.8, 0.5}, radius = 2.0, gradient[3], want[3];
	unit3(n);
	double height = amplitude * dot3(w, n);
	for (int axis = 0; axis < 3; axis++)
		gradient[axis] = amplitude / radius * (w[axis] - n[axis] * dot3(w, n));
	for (int axis = 0; axis < 3; axis++)
		want[axis] = n[axis] - gradient[axis] / (1.0 + height / radius);
	unit3(want);
	shade_frame frame = shade_frame_from_normal(from_doubles(n));
	stilb_vec3 g = from_doubles(gradient);
	stilb_vec3 got =
		shade_bump_from_height(frame.n, frame.t, frame.b, stilb_vec3_dot(g, frame.t), stilb_vec3_dot(g, frame.b), 1.0f);
	double across = 0.0;
	for (int axis = 0; axis < 3; axis++)
		across += ((double)got[axis] - want[axis]) * ((double)got[axis] - want[axis]);
	*bound = fabs(height) / radius * sqrt(dot3(gradient, gradient));
	return sqrt(across);
}

static void bumped_sphere_is_off_by_height_over_radius(void **state)
{
	(void)state;
	double bound;
	assert_true(sphere_error(0.4, &bound) < bound);
	assert_true(sphere_error(0.4, &bound) > 0.5 * bound);
	double coarse = sphere_error(0.1, &bound), fine = sphere_error(0.05, &bound);
	SHADE_PROOF_NEAR(coarse / fine, 4.0, 0.05, 0.0); /* half the height and half the gradient: a quarter of the error */
}

/* ---- rays -------------------------------------------------------------------------------------------------------- */

static void pinhole_rays_differ_as_their_neighbours(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 3};
	for (int k = 0; k < 300; k++) {
		stilb_vec3 forward = shade_proof_random_direction(&random) * shade_proof_log_range(&random, 0.1f, 10.0f);
		stilb_vec3 step = shade_proof_random_direction(&random);
		shade_ray_differential ray = shade_ray_differential_pinhole(forward, step);
		double before[3], after[3], e = 1e-5;
		for (int axis = 0; axis < 3; axis++) {
			before[axis] = (double)forward[axis] - e * (double)step[axis];
			after[axis] = (double)forward[axis] + e * (double)step[axis];
		}
		unit3(before);
		unit3(after);
		for (int axis = 0; axis < 3; axis++) {
			SHADE_PROOF_NEAR(ray.direction[axis], (after[axis] - before[axis]) / (2.0 * e), 1e-5, 1e-5);
			assert_true(ray.origin[axis] == 0.0f);
		}
	}
}

/* Where the ray from o along d meets the plane n . p = height. */
static void plane_meet(const double o[3], const double d[3], const double n[3], double height, double p[3])
{
	double path = (height - dot3(n, o)) / dot3(n, d);
	for (int axis = 0; axis < 3; axis++)
		p[axis] = o[axis] + path * d[axis];
}

static void hits_differ_as_their_neighbours(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 4};
	double e = 1e-5;
	for (int k = 0; k < 300; k++) {
		stilb_vec3 n = shade_proof_random_direction(&random), side = shade_proof_random_direction(&random);
		stilb_vec3 d = stilb_vec3_normalize(side * 0.9f - n * (k % 2 ? 1.0f : -1.0f));
		stilb_vec3 by = shade_proof_random_direction(&random), turn = shade_proof_random_direction(&random);
		shade_ray_differential ray = {by, turn - d * stilb_vec3_dot(d, turn)};
		float path = shade_proof_range(&random, 0.0f, 5.0f);
		double o[2][3], direction[2][3], p[2][3], normal[3], height = 0.0;
		for (int axis = 0; axis < 3; axis++) {
			normal[axis] = (double)n[axis];
			height += normal[axis] * (double)path * (double)d[axis]; /* of the hit: the ray starts at 0 */
		}
		for (int side_of = 0; side_of < 2; side_of++) {
			double step = side_of ? e : -e;
			for (int axis = 0; axis < 3; axis++) {
				o[side_of][axis] = step * (double)ray.origin[axis];
				direction[side_of][axis] = (double)d[axis] + step * (double)ray.direction[axis];
			}
			plane_meet(o[side_of], direction[side_of], normal, height, p[side_of]);
		}
		stilb_vec3 dp = shade_ray_differential_hit(ray, d, path, n);
		for (int axis = 0; axis < 3; axis++)
			SHADE_PROOF_NEAR(dp[axis], (p[1][axis] - p[0][axis]) / (2.0 * e), 3e-5, 3e-5);
	}
}

static void uv_steps_are_solved(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 5};
	for (int k = 0; k < 1000; k++) {
		shade_frame frame = random_frame(&random);
		float first = shade_proof_range(&random, 0.0f, 6.28f);
		float turn = shade_proof_range(&random, 0.3f, 2.8f) * (k % 2 ? 1.0f : -1.0f);
		stilb_vec3 u = scaled_step(&random, frame, first), v = scaled_step(&random, frame, first + turn);
		float du = shade_proof_range(&random, -1.0f, 1.0f) / sqrtf(stilb_vec3_dot(u, u));
		float dv = shade_proof_range(&random, -1.0f, 1.0f) / sqrtf(stilb_vec3_dot(v, v));
		stilb_vec2 got = shade_ray_differential_uv(frame.n, u * du + v * dv, u, v);
		SHADE_PROOF_NEAR(got[0] / du, 1.0, 0.0, 5e-6 / fabs((double)(du * sqrtf(stilb_vec3_dot(u, u)))));
		SHADE_PROOF_NEAR(got[1] / dv, 1.0, 0.0, 5e-6 / fabs((double)(dv * sqrtf(stilb_vec3_dot(v, v)))));
	}
}

/* u and v a millionth of a radian apart span nothing that could be told from rounding: a step across them is 10^6 steps
 * of v, and fades. */
static void uv_steps_fade_where_u_and_v_are_parallel(void **state)
{
	(void)state;
	stilb_vec3 up = stilb_vec3_make(0.0f, 1.0f, 0.0f), across = stilb_vec3_make(0.0f, 0.0f, 1.0f);
	stilb_vec3 u = stilb_vec3_make(1.0f, 0.0f, 0.0f), v = stilb_vec3_make(1.0f, 0.0f, 1e-6f);
	stilb_vec2 faded = shade_ray_differential_uv(up, across, u, v);
	SHADE_PROOF_NEAR(faded[1], 1e5, 1e-3, 0.0);
	stilb_vec2 none = shade_ray_differential_uv(up, across, u, u);
	assert_true(none[0] == 0.0f && none[1] == 0.0f);
}

/* All that a ray tracer does: camera ray, hit, uv, derivative map, normal. The lengths of the steps cancel out: the
 * result is the normal of the hills. */
static void traced_bumps_are_the_hills(void **state)
{
	(void)state;
	stilb_vec3 up = stilb_vec3_make(0.0f, 1.0f, 0.0f), right = stilb_vec3_make(1e-3f, 0.0f, 0.0f);
	stilb_vec3 down = stilb_vec3_make(0.0f, -8e-4f, 6e-4f);
	/* u and v grow by the rows above; turned over, a step of 1 in u is dp_du. */
	double determinant = du_dx * dv_dz - du_dz * dv_dx;
	stilb_vec3 dp_du = stilb_vec3_make((float)(dv_dz / determinant), 0.0f, (float)(-dv_dx / determinant));
	stilb_vec3 dp_dv = stilb_vec3_make((float)(-du_dz / determinant), 0.0f, (float)(du_dx / determinant));
	for (int k = 0; k < 100; k++) {
		stilb_vec3 forward = stilb_vec3_make(0.02f * (float)k - 1.0f, -1.0f, 0.3f), d = stilb_vec3_normalize(forward);
		float path = 3.0f * sqrtf(stilb_vec3_dot(forward, forward));
		shade_ray_differential ray_x = shade_ray_differential_pinhole(forward, right);
		shade_ray_differential ray_y = shade_ray_differential_pinhole(forward, down);
		stilb_vec3 dp_dx = shade_ray_differential_hit(ray_x, d, path, up);
		stilb_vec3 dp_dy = shade_ray_differential_hit(ray_y, d, path, up);
		stilb_vec2 duv_dx = shade_ray_differential_uv(up, dp_dx, dp_du, dp_dv);
		stilb_vec2 duv_dy = shade_ray_differential_uv(up, dp_dy, dp_du, dp_dv);
		double x = (double)(3.0f * forward[0]), z = (double)(3.0f * forward[2]), n[3];
		hills_normal(x, z, 1.0, n);
		stilb_vec2 slope = derivatives_in_uv(x, z);
		SHADE_PROOF_NEAR3(shade_bump_from_derivatives(up, dp_dx, dp_dy, slope, duv_dx, duv_dy, 1.0f), n[0], n[1], n[2],
		                  0.0, 5e-6);
		/* Without rays: u and v are steps as good as any. */
		stilb_vec3 gradient = shade_bump_gradient(up, dp_du, dp_dv, slope[0], slope[1]);
		SHADE_PROOF_NEAR3(shade_bump_normal(up, gradient, 1.0f), n[0], n[1], n[2], 0.0, 2e-6);
	}
}

/* ---- properties -------------------------------------------------------------------------------------------------- */

static bool finite3(stilb_vec3 v)
{
	return isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2]);
}

/* Steps of all lengths and angles, missing ones, parallel ones; heights that fit the steps or do not. */
static void bumped_normals_are_unit_and_above(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 20};
	for (int k = 0; k < SHADE_PROOF_COUNT; k++) {
		shade_frame frame = random_frame(&random);
		float angle = k % 4 == 0 ? 0.0f : k % 4 == 1 ? 1e-6f : shade_proof_range(&random, 0.0f, 6.3f);
		float length = shade_proof_log_range(&random, 1e-12f, 1e12f),
			  slope = shade_proof_log_range(&random, 1e-6f, 1e3f);
		stilb_vec3 ds = frame.t * length, dt = (frame.t * cosf(angle) + frame.b * sinf(angle)) * length;
		if (k % 16 == 15) /* one of the two steps is missing */
			ds = ds * 0.0f;
		if (k % 16 == 7)
			dt = dt * 0.0f;
		float dh_ds = slope * length, dh_dt = -0.5f * dh_ds, scale = shade_proof_range(&random, -2.0f, 2.0f);
		stilb_vec3 gradient = shade_bump_gradient(frame.n, ds, dt, dh_ds, dh_dt);
		stilb_vec3 normal = shade_bump_from_height(frame.n, ds, dt, dh_ds, dh_dt, scale);
		stilb_vec3 same = shade_bump_from_derivatives(frame.n, ds, dt, (stilb_vec2){dh_ds, dh_dt},
		                                              (stilb_vec2){1.0f, 0.0f}, (stilb_vec2){0.0f, 1.0f}, scale);
		assert_true(finite3(gradient) && finite3(normal));
		assert_true(stilb_vec3_dot(normal - same, normal - same) == 0.0f);
		SHADE_PROOF_NEAR(stilb_vec3_dot(normal, normal), 1.0, 1e-6, 0.0);
		assert_true(stilb_vec3_dot(normal, frame.n) > -1e-5f);
	}
}

/* Steps so nearly parallel that the angle between them is mere rounding: the gradient does not become huge. */
static void silhouettes_keep_their_normal(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 21};
	for (int k = 0; k < SHADE_PROOF_COUNT; k++) {
		shade_frame frame = random_frame(&random);
		stilb_vec3 g = shade_proof_random_direction(&random), ds = scaled_step(&random, frame, 0.4f);
		stilb_vec3 dt = ds * shade_proof_range(&random, -3.0f, 3.0f);
		stilb_vec3 gradient = shade_bump_gradient(frame.n, ds, dt, stilb_vec3_dot(g, ds), stilb_vec3_dot(g, dt));
		assert_true(stilb_vec3_dot(gradient, gradient) < 0.1f * 0.1f);
	}
}

static void layers_add_up(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 22};
	for (int k = 0; k < SHADE_PROOF_COUNT; k++) {
		shade_frame frame = random_frame(&random);
		stilb_vec3 ds = frame.t * 0.01f, dt = frame.b * 0.02f + frame.t * 0.01f;
		float h[4];
		for (int i = 0; i < 4; i++)
			h[i] = shade_proof_range(&random, -0.02f, 0.02f);
		stilb_vec3 both = shade_bump_gradient(frame.n, ds, dt, h[0] + h[2], h[1] + h[3]);
		stilb_vec3 sum =
			shade_bump_gradient(frame.n, ds, dt, h[0], h[1]) + shade_bump_gradient(frame.n, ds, dt, h[2], h[3]);
		SHADE_PROOF_NEAR3(sum, both[0], both[1], both[2], 1e-5, 5e-6);
		assert_true(fabsf(stilb_vec3_dot(sum, frame.n)) < 1e-5f);
	}
}

static void rays_stay_finite(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 23};
	for (int k = 0; k < SHADE_PROOF_COUNT; k++) {
		shade_frame frame = random_frame(&random);
		/* Every fourth ray runs along the surface. */
		stilb_vec3 d = k % 4 == 0 ? frame.t : shade_proof_random_direction(&random);
		float length = shade_proof_log_range(&random, 1e-6f, 1e6f);
		stilb_vec3 step = shade_proof_random_direction(&random);
		shade_ray_differential ray = shade_ray_differential_pinhole(d * length, step);
		stilb_vec3 dp = shade_ray_differential_hit(ray, d, shade_proof_log_range(&random, 1e-6f, 1e6f), frame.n);
		stilb_vec3 u = frame.t * shade_proof_log_range(&random, 1e-6f, 1e6f), v = k % 2 ? u : frame.b;
		stilb_vec2 duv = shade_ray_differential_uv(frame.n, dp, u, v);
		assert_true(finite3(ray.direction) && finite3(dp) && isfinite(duv[0]) && isfinite(duv[1]));
		/* A unit vector's change is at right angles to it. */
		assert_true(fabsf(stilb_vec3_dot(ray.direction, d)) <= 1e-6f / length);
	}
}

int main(void)
{
	const struct CMUnitTest exactness[] = {
		cmocka_unit_test(gradient_is_the_fields),
		cmocka_unit_test(gradient_points_uphill),
		cmocka_unit_test(bumped_plane_has_the_hills_normal),
		cmocka_unit_test(texels_become_uv),
		cmocka_unit_test(pixel_differences_converge),
		cmocka_unit_test(bumped_sphere_is_off_by_height_over_radius),
		cmocka_unit_test(pinhole_rays_differ_as_their_neighbours),
		cmocka_unit_test(hits_differ_as_their_neighbours),
		cmocka_unit_test(uv_steps_are_solved),
		cmocka_unit_test(uv_steps_fade_where_u_and_v_are_parallel),
		cmocka_unit_test(traced_bumps_are_the_hills),
	};
	const struct CMUnitTest properties[] = {
		cmocka_unit_test(bumped_normals_are_unit_and_above),
		cmocka_unit_test(silhouettes_keep_their_normal),
		cmocka_unit_test(layers_add_up),
		cmocka_unit_test(rays_stay_finite),
	};
	return SHADE_PROOF_RUN(exactness, properties);
}
