/* shade_light_area.h against integrals over the lights' surfaces, in double, and against closed forms of others. */
#include "numeric/numeric_quadrature.h"
#include "shading/shade_frame.h"
#include "shading/shade_surface.h"
#include "support/shade_proof.h"

#include <math.h>
#include <stdio.h>

#define TRIALS 60
#define GRID 160 /* cells along a side of a flat light: the horizon's edge in them costs 4e-5 */

typedef struct flat {
	stilb_vec3 center, direction, half_x, half_y;
	stilb_vec3 n;
	double radius; /* of a disk; 0: a rectangle */
} flat;

/* What a point of the light, in units of its halves, gives to the integral over its area. */
static double flat_at(const flat *f, double x, double y)
{
	double p[3], square = 0.0, here = 0.0, there = 0.0;
	for (int i = 0; i < 3; i++) {
		p[i] = (double)f->center[i] + x * (double)f->half_x[i] + y * (double)f->half_y[i];
		square += p[i] * p[i];
		here += p[i] * (double)f->n[i];
		there -= p[i] * (double)f->direction[i];
	}
	return fmax(here, 0.0) * fmax(there, 0.0) / (square * square);
}

/* E / L by the midpoints of a grid; of a disk in polar coordinates. */
static double flat_integral(const flat *f)
{
	double sum = 0.0, x2 = (double)stilb_vec3_dot(f->half_x, f->half_x),
		   y2 = (double)stilb_vec3_dot(f->half_y, f->half_y);
	for (int i = 0; i < GRID; i++)
		for (int k = 0; k < GRID; k++) {
			double a = (i + 0.5) / GRID, b = (k + 0.5) / GRID;
			sum += f->radius > 0.0 ? a * flat_at(f, a * cos(2.0 * M_PI * b), a * sin(2.0 * M_PI * b))
			                       : flat_at(f, 2.0 * a - 1.0, 2.0 * b - 1.0);
		}
	double area = f->radius > 0.0 ? 2.0 * M_PI * f->radius * f->radius : 4.0 * sqrt(x2 * y2);
	return sum * area / GRID / GRID;
}

/* A light about the size of its distance, so that its plane and the horizon lie anywhere. */
static flat random_flat(shade_proof_random *random, bool disk)
{
	flat f;
	f.direction = shade_proof_random_direction(random);
	shade_frame frame = shade_frame_from_normal(f.direction);
	float turn = shade_proof_range(random, 0.0f, 6.28f), x = shade_proof_range(random, 0.2f, 1.5f);
	float y = disk ? x : shade_proof_range(random, 0.2f, 1.5f);
	f.half_x = (frame.t * cosf(turn) + frame.b * sinf(turn)) * x;
	f.half_y = (frame.b * cosf(turn) - frame.t * sinf(turn)) * y;
	if (shade_proof_uniform(random) < 0.5f)
		f.half_y = -f.half_y;
	stilb_vec3 beside =
		f.half_x * shade_proof_range(random, -2.0f, 2.0f) + f.half_y * shade_proof_range(random, -2.0f, 2.0f);
	f.center = beside - f.direction * shade_proof_range(random, 0.4f, 2.0f);
	f.n = shade_proof_random_direction(random);
	f.radius = disk ? (double)x : 0.0;
	return f;
}

static double flat_formula(const flat *f)
{
	return (double)(f->radius > 0.0 ? shade_disk_irradiance(f->center, f->direction, (float)f->radius, f->n)
	                                : shade_rectangle_irradiance(f->center, f->direction, f->half_x, f->half_y, f->n));
}

static void flat_lights_are_exact(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 12};
	for (int disk = 0; disk < 2; disk++) {
		int cut = 0;
		for (int i = 0; i < TRIALS; i++) {
			flat f = random_flat(&random, disk);
			double truth = flat_integral(&f), middle = (double)stilb_vec3_dot(f.center, f.n);
			SHADE_PROOF_NEAR(flat_formula(&f), truth, 6e-5, 6e-5);
			cut += truth > 0.0 && fabs(middle) < 0.5 * fabs(f.radius);
			f.center -= f.direction * (2.0f * stilb_vec3_dot(f.center, f.direction)); /* the point is behind it */
			assert_true(flat_formula(&f) == 0.0);
		}
		assert_true(!disk || cut > 5); /* disks that the horizon cuts in two */
	}
}

/* Small lights that the horizon cuts: against the same integral, as a share of what they send where they face. */
static void small_lights_on_the_horizon(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 21};
	double cut = 0.0;
	for (int i = 0; i < 3 * TRIALS; i++) {
		flat f = random_flat(&random, i & 1);
		float size = shade_proof_log_range(&random, 1e-5f, 0.1f);
		f.half_x *= size;
		f.half_y *= size;
		f.radius *= (double)size;
		float reach = sqrtf(stilb_vec3_dot(f.half_x, f.half_x) + stilb_vec3_dot(f.half_y, f.half_y));
		stilb_vec3 to_light = stilb_vec3_normalize(f.center);
		f.n = stilb_vec3_normalize(stilb_vec3_cross(to_light, f.n)); /* upright to the light, then turned a little */
		f.n = stilb_vec3_normalize(f.n + to_light * (shade_proof_range(&random, -1.2f, 1.2f) * reach));
		flat facing = f;
		facing.n = to_light;
		double most = flat_integral(&facing), truth = flat_integral(&f);
		SHADE_PROOF_NEAR(flat_formula(&f) / most, truth / most, 0.0, 4e-4);
		cut += truth > 0.0;
	}
	assert_true(cut > TRIALS);
}

/* From afar the falloffs of shade_light.h; on the axis, where the arc's denominators vanish, Foote's value; a disk that
 * the horizon halves gives half of what it and its other half do together. */
static void disks_in_special_places(void **state)
{
	(void)state;
	stilb_vec3 down = stilb_vec3_make(0.0f, -1.0f, 0.0f), up = -down;
	for (double h = 0.01; h < 1e4; h *= 1.9) {
		stilb_vec3 center = stilb_vec3_make(0.0f, (float)h, 0.0f);
		double whole = M_PI / (1.0 + h * h);
		SHADE_PROOF_NEAR(shade_disk_irradiance(center, down, 1.0f, up), whole, 2e-5, 0.0);
		/* A surface that stands upright sees one half, and one that faces the other way the other. */
		for (float turn = 0.0f; turn < 6.0f; turn += 1.1f) {
			stilb_vec3 n = stilb_vec3_make(cosf(turn), 0.0f, sinf(turn));
			/* E / L of half a disk on an upright surface: atan(1 / h) - h / (1 + h^2). */
			SHADE_PROOF_NEAR(shade_disk_irradiance(center, down, 1.0f, n), atan(1.0 / h) - h / (1.0 + h * h), 1e-3,
			                 3e-7);
		}
		if (h > 50.0) {
			stilb_vec3 aside = stilb_vec3_make((float)h, (float)h, 0.0f), n = stilb_vec3_normalize(aside);
			double far = M_PI * (double)shade_falloff_disk((float)(2.0 * h * h), 1.0f) * sqrt(0.5);
			SHADE_PROOF_NEAR(shade_disk_irradiance(aside, down, 1.0f, n), far, 1e-3, 0.0);
		}
	}
}

static void rectangles_in_special_places(void **state)
{
	(void)state;
	stilb_vec3 down = stilb_vec3_make(0.0f, -1.0f, 0.0f), up = -down;
	stilb_vec3 x = stilb_vec3_make(1e6f, 0.0f, 0.0f), z = stilb_vec3_make(0.0f, 0.0f, 1e6f);
	SHADE_PROOF_NEAR(shade_rectangle_irradiance(up, down, x, z, up), M_PI, 1e-5, 0.0); /* a ceiling without an end */
	stilb_vec3 slant = stilb_vec3_make(0.6f, 0.8f, 0.0f);
	SHADE_PROOF_NEAR(shade_rectangle_irradiance(up, down, x, z, slant), M_PI * 0.9, 1e-5, 0.0); /* (1 + cos) / 2 */
	x *= 1e-6f;
	z *= 1e-6f;
	for (float h = 10.0f; h < 3000.0f; h *= 2.0f) {
		stilb_vec3 center = up * h;
		SHADE_PROOF_NEAR(shade_rectangle_irradiance(center, down, x, z, up) * h * h / 4.0f, 1.0,
		                 1.5 / ((double)h * (double)h) + 1e-3, 0.0);
	}
}

typedef struct receiver {
	double normal[3];
} receiver;

static double cosine_of_receiver(const double direction[3], const void *context)
{
	const double *n = ((const receiver *)context)->normal;
	return fmax(n[0] * direction[0] + n[2] * direction[2], 0.0);
}

static void spheres_are_exact_below_the_horizon_too(void **state)
{
	(void)state;
	for (double sine = 0.02; sine < 1.0; sine += 0.12)
		for (double tilt = 0.0; tilt <= M_PI; tilt += 0.17) {
			receiver r = {{sin(tilt), 0.0, cos(tilt)}};
			double truth = stilb_numeric_integrate_sphere(cosine_of_receiver, &r, sqrt(1.0 - sine * sine), 1.0, 16);
			SHADE_PROOF_NEAR(shade_sphere_irradiance((float)cos(tilt), (float)(sine * sine)), truth, 0.0, 3e-4);
		}
	/* From its surface or inside, half of it: a hemisphere. */
	SHADE_PROOF_NEAR(shade_sphere_irradiance(1.0f, 1.0f), M_PI, 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_sphere_irradiance(0.0f, 1.0f), 0.5 * M_PI, 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_sphere_irradiance(-1.0f, 1.0f), 0.0, 0.0, 1e-6);
}

/* All kinds together with their falloff, and what is left of them at the end of their reach. */
static void lights_send_their_intensity(void **state)
{
	(void)state;
	shade_light light = {.kind = SHADE_LIGHT_SPHERE,
	                     .position = {0.0f, 50.0f, 0.0f},
	                     .direction = {0.0f, -1.0f, 0.0f},
	                     .intensity = {10.0f, 20.0f, 0.0f},
	                     .radius = 0.5f,
	                     .half_x = {1.0f, 0.0f, 0.0f},
	                     .half_y = {0.0f, 0.0f, 0.25f},
	                     .reach = 100.0f};
	stilb_vec3 up = stilb_vec3_make(0.0f, 1.0f, 0.0f), here = stilb_vec3_make(0.0f, 0.0f, 0.0f);
	for (light.kind = SHADE_LIGHT_SPHERE; light.kind <= SHADE_LIGHT_RECTANGLE; light.kind++) {
		light.falloff = SHADE_FALLOFF_PHYSICAL;
		SHADE_PROOF_NEAR3(shade_area_irradiance(light, here, up), 10.0 / 2500.0, 20.0 / 2500.0, 0.0, 1e-3, 0.0);
		light.falloff = SHADE_FALLOFF_WINDOWED;
		SHADE_PROOF_NEAR(shade_area_irradiance(light, here, up)[0], 0.5625 * 10.0 / 2500.0, 1e-3, 0.0);
		assert_true(shade_area_irradiance(light, here - up * 51.0f, up)[0] == 0.0f);
	}
}

/* Finite, and in [0, pi], wherever the light and the surface are. */
static void bounds(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 5};
	for (int i = 0; i < SHADE_PROOF_COUNT / 4; i++) {
		flat f = random_flat(&random, i & 1);
		float size = shade_proof_log_range(&random, 1e-4f, 1e4f), away = shade_proof_log_range(&random, 1e-6f, 1e6f);
		f.half_x *= size;
		f.half_y *= size;
		f.radius *= (double)size;
		f.center *= away;
		double form = flat_formula(&f);
		assert_true(form >= 0.0 && form <= M_PI * 1.001);
		float cosine = shade_proof_range(&random, -1.0f, 1.0f);
		double ball = (double)shade_sphere_irradiance(cosine, shade_proof_log_range(&random, 1e-12f, 1.0f));
		assert_true(ball >= 0.0 && ball <= M_PI * 1.00001);
	}
}

/* ---- exactness: each constant of the header shows ---------------------------------------------------------------- */

#define STEPS 4000 /* of the midpoint rule in one dimension */

/* E / L of a sphere, by circles about the direction to its centre: on each the cosine has a closed form. */
static double sphere_integral(double cosine, double sin2)
{
	double sum = 0.0, sine = sqrt(1.0 - cosine * cosine), end = asin(sqrt(sin2));
	for (int i = 0; i < STEPS; i++) {
		double angle = end * (i + 0.5) / STEPS, z = cos(angle) * cosine, s = sin(angle) * sine;
		double half = z >= s ? M_PI : z <= -s ? 0.0 : acos(-z / s);
		sum += 2.0 * sin(angle) * (z * half + s * sin(half));
	}
	return sum * end / STEPS;
}

static void spheres_to_six_digits(void **state)
{
	(void)state;
	for (double sin2 = 0.1; sin2 < 1.0; sin2 += 0.2)
		for (double cosine = -0.95; cosine < 1.0; cosine += 0.1)
			SHADE_PROOF_NEAR(shade_sphere_irradiance((float)cosine, (float)sin2), sphere_integral(cosine, sin2), 1e-5,
			                 4e-6);
	/* Almost upright, from just outside. */
	static const float steep[] = {-0.9999f, -0.999f, 0.999f, 0.9999f};
	for (int i = 0; i < 4; i++)
		SHADE_PROOF_NEAR(shade_sphere_irradiance(steep[i], 0.9999f), sphere_integral((double)steep[i], (double)0.9999f),
		                 2e-5, 1e-5);
	for (double x = -1.0; x <= 1.0; x += 0.125)
		SHADE_PROOF_NEAR(shade_area_acos((float)x), acos(x), 1e-6, 1e-6);
}

static void ramps_to_six_digits(void **state)
{
	(void)state;
	for (double z = -0.9; z < 1.0; z += 0.3) {
		double disk = 0.0, rectangle = 0.0, a = 0.9, b = 0.4;
		for (int i = 0; i < STEPS; i++) {
			double x = -cos(M_PI * (i + 0.5) / STEPS), u = (2.0 * i + 1.0) / STEPS - 1.0;
			double low = fmax(z + a * u - b, 0.0), high = fmax(z + a * u + b, 0.0);
			disk += fmax(z + x, 0.0) * 2.0 * (1.0 - x * x) * M_PI / STEPS;
			rectangle += (high * high - low * low) / (4.0 * b) / STEPS;
		}
		SHADE_PROOF_NEAR(shade_disk_ramp((float)z), disk, 1e-5, 1e-6);
		SHADE_PROOF_NEAR(shade_rectangle_ramp((float)z, (float)a, (float)b), rectangle, 1e-5, 1e-6);
	}
}

/* A distant rectangle, 0.12 by 0.04 in the tangents of its angles, that rises over the horizon: the mean over its
 * points of max(n . l, 0), which small angles give to the cube of them. */
static void a_distant_rectangle_rises(void **state)
{
	(void)state;
	stilb_vec3 direction = {0.0f, 0.6f, -0.8f}, x = {0.06f, 0.0f, 0.0f}, y = {0.0f, 0.016f, 0.012f};
	for (double above = -0.1; above < 0.1; above += 0.009)
		for (double side = 0.0; side < 1.0; side += 0.2) {
			double up[3] = {side, 0.8 * sqrt(1.0 - side * side), 0.6 * sqrt(1.0 - side * side)}, mean = 0.0;
			double across = sqrt(1.0 - above * above);
			stilb_vec3 n = {0.0f, 0.0f, 0.0f};
			for (int c = 0; c < 3; c++)
				n[c] = (float)(up[c] * across + (double)direction[c] * above);
			for (int i = 0; i < 400 * 400; i++) {
				double u = (i % 400 * 2.0 + 1.0) / 400.0 - 1.0, v = (i / 400 * 2.0 + 1.0) / 400.0 - 1.0, height = 0.0;
				for (int c = 0; c < 3; c++)
					height += (double)n[c] * ((double)direction[c] + u * (double)x[c] + v * (double)y[c]);
				mean += fmax(height, 0.0) / (400.0 * 400.0);
			}
			SHADE_PROOF_NEAR(shade_distant_share(direction, x, y, n), mean, 1e-4, 2e-6);
		}
	stilb_vec3 none = {0.0f, 0.0f, 0.0f};
	assert_true(shade_distant_share(direction, none, none, direction) > 0.999999f);
	assert_true(shade_distant_share(direction, none, none, -direction) == 0.0f);
}

/* n . (r x dr) / r^2 along an arc, in the axes of shade_disk_seen. */
static double arc_integral(shade_disk_seen d, double from, double to)
{
	double sum = 0.0, h = (double)d.height, x = (double)d.across, r0 = (double)d.radius;
	for (int i = 0; i < STEPS; i++) {
		double t = from + (to - from) * (i + 0.5) / STEPS, c = cos(t), s = sin(t);
		double square = h * h + x * x + r0 * r0 + 2.0 * r0 * x * c;
		sum += ((double)d.axis_n * (r0 + x * c) - h * ((double)d.across_n * c + (double)d.side_n * s)) / square;
	}
	return sum * r0 * (to - from) / STEPS;
}

/* The whole border is the whole disk, also of one that is larger than its distance. */
static void borders_of_disks_to_five_digits(void **state)
{
	(void)state;
	for (float radius = 0.3f; radius < 4.0f; radius *= 1.6f)
		for (float across = 0.2f; across < 2.0f; across += 0.5f) {
			shade_disk_seen d = {0.8f, 0.36f, -0.48f, 0.7f, across, radius};
			float left = d.height * d.height + across * across - radius * radius;
			float root = sqrtf(left * left + 4.0f * radius * radius * d.height * d.height);
			SHADE_PROOF_NEAR(shade_disk_arc(d, root, -1.0f, 0.4f), arc_integral(d, -1.0, 0.4), 2e-5, 1e-5);
			SHADE_PROOF_NEAR(shade_disk_irradiance_whole(d, root), 0.5 * arc_integral(d, -M_PI, M_PI), 2e-5, 1e-6);
		}
}

static void flat_lights_to_four_digits(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 33};
	for (int i = 0; i < 24; i++) {
		flat f = random_flat(&random, i & 1);
		SHADE_PROOF_NEAR(flat_formula(&f), flat_integral(&f), 1e-4, 6e-5);
	}
}

/* What lights with a size do to highlights. */
static void highlights_widen(void **state)
{
	(void)state;
	shade_light light = {.kind = SHADE_LIGHT_SPHERE,
	                     .position = {0.0f, 2.0f, 0.0f},
	                     .direction = {0.0f, -1.0f, 0.0f},
	                     .radius = 0.5f,
	                     .half_x = {1.0f, 0.0f, 0.0f},
	                     .half_y = {0.0f, 0.0f, 0.25f}};
	stilb_vec3 below = stilb_vec3_make(0.0f, 0.0f, 0.0f), beside = stilb_vec3_make(2.0f, 0.0f, 0.0f);
	SHADE_PROOF_NEAR(shade_light_share(light, below), 0.0625, 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_light_share(light, beside), 0.25 / 8.0, 1e-6, 0.0);
	assert_true(shade_light_share(light, light.position) == 1.0f);
	light.kind = SHADE_LIGHT_DISK;
	SHADE_PROOF_NEAR(shade_light_share(light, below), 0.0625, 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_light_share(light, beside), 0.25 / 8.0 * sqrt(0.5), 1e-6, 0.0);
	assert_true(shade_light_share(light, stilb_vec3_make(0.0f, 3.0f, 0.0f)) == 0.0f);
	light.kind = SHADE_LIGHT_RECTANGLE;
	SHADE_PROOF_NEAR(shade_light_share(light, below), 1.0 / (4.0 * M_PI), 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_light_share(light, beside), 1.0 / (8.0 * M_PI) * sqrt(0.5), 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_roughness_under(0.3f, 0.04f), pow(0.0081 + 0.0075, 0.25), 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_roughness_under(0.3f, 1.0f), pow(0.0081 + 0.1875, 0.25), 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_roughness_under(0.6f, 0.0f), 0.6, 1e-6, 0.0);
	assert_true(shade_roughness_under(1.0f, 1.0f) == 1.0f);
}

/* A lamp over a ball and a floor, and what its surface's points send to a viewer, summed up. */
typedef struct gloss {
	shade_brdf_model model;
	shade_material material;
	shade_light light;
	stilb_vec3 eye;
} gloss;

static double gloss_integral(const gloss *g, stilb_vec3 place, stilb_vec3 n, stilb_vec3 v)
{
	enum { SIDE = 16 };
	stilb_vec3 toward = stilb_vec3_normalize(g->light.position - place);
	bool ball = g->light.kind == SHADE_LIGHT_SPHERE, disk = g->light.kind == SHADE_LIGHT_DISK;
	shade_frame frame = shade_frame_from_normal(n);
	shade_frame around = shade_frame_from_normal(ball ? -toward : g->light.direction);
	double sum = 0.0;
	for (int i = 0; i < SIDE * SIDE; i++) {
		double x = (i % SIDE + 0.5) / SIDE, y = (i / SIDE + 0.5) / SIDE;
		double across = sqrt(x) * cos(2.0 * M_PI * y), along = sqrt(x) * sin(2.0 * M_PI * y);
		stilb_vec3 at = g->light.position;
		if (ball || disk) /* of a ball its half that is seen, as a disk that covers as much */
			at += (around.t * (float)across + around.b * (float)along) * g->light.radius;
		else
			at += g->light.half_x * (float)(2.0 * x - 1.0) + g->light.half_y * (float)(2.0 * y - 1.0);
		if (ball)
			at -= toward * (g->light.radius * (float)sqrt(fmax(1.0 - x, 0.0)));
		stilb_vec3 offset = at - place;
		double square = (double)stilb_vec3_dot(offset, offset);
		stilb_vec3 l = stilb_vec3_normalize(offset);
		/* dA cos / d^2 of I / A; of a ball dA is that of the disk, over the cosine by which it is turned to it. */
		double turned =
			ball ? (double)stilb_vec3_dot(stilb_vec3_normalize(g->light.position - at), l) /
					   fmax((double)stilb_vec3_dot(stilb_vec3_normalize(g->light.position - at), toward), 1e-3)
				 : -(double)stilb_vec3_dot(l, g->light.direction);
		sum += fmax(turned, 0.0) / square * (double)shade_surface_highlight_cos(g->model, g->material, frame, l, v)[0];
	}
	return sum / (SIDE * SIDE);
}

/* RMS of all points, as a share of the largest value: what highlights of lights with a size are off by. */
static double gloss_error(const gloss *g)
{
	enum { SIDE = 16 };
	double square = 0.0, most = 0.0;
	int count = 0;
	for (int i = 0; i < 2 * SIDE * SIDE; i++) {
		float x = (float)(i % SIDE) / SIDE * 2.0f - 0.95f, y = (float)(i / 2 / SIDE) / SIDE * 2.0f - 0.95f;
		bool ball = (i / SIDE) % 2 == 1;
		if (ball && x * x + y * y > 0.9f)
			continue;
		stilb_vec3 n = ball ? stilb_vec3_make(x, y, sqrtf(1.0f - x * x - y * y)) : stilb_vec3_make(0.0f, 1.0f, 0.0f);
		stilb_vec3 place =
			ball ? stilb_vec3_make(-1.1f, 1.0f, 0.0f) + n : stilb_vec3_make(2.5f * x + 0.3f, 0.0f, 2.5f * y + 1.0f);
		stilb_vec3 v = stilb_vec3_normalize(g->eye - place);
		if (stilb_vec3_dot(n, v) < 0.05f)
			continue;
		double want = gloss_integral(g, place, n, v);
		double got =
			(double)shade_surface_light(g->model, g->material, shade_frame_from_normal(n), g->light, place, v)[0];
		square += (got - want) * (got - want);
		most = fmax(most, want);
		count++;
	}
	assert_true(count > SIDE * SIDE && most > 0.0);
	return sqrt(square / count) / most;
}

/* Of a roughness of .2 and more highlights of lights with a size are off by 5 % of the largest value at most (RMS). */
static void highlights_beside_integrals(void **state)
{
	(void)state;
	static const shade_brdf_model models[] = {
		{SHADE_BRDF_MICROFACET, SHADE_NDF_GGX, SHADE_G_SMITH_GGX, SHADE_F_SCHLICK},
		{.kind = SHADE_BRDF_BLINN_PHONG_MODIFIED},
		{.kind = SHADE_BRDF_PHONG_MODIFIED}};
	static const float roughness[] = {0.2f, 0.3f, 0.45f, 0.6f, 1.0f};
	static const shade_light lights[] = {{.position = {0.5f, 3.0f, 1.0f},
	                                      .direction = {0.0f, -0.8f, -0.6f},
	                                      .intensity = {1.0f, 1.0f, 1.0f},
	                                      .radius = 0.6f,
	                                      .half_x = {1.0f, 0.0f, 0.0f},
	                                      .half_y = {0.0f, 0.18f, -0.24f}},
	                                     /* not used while the form was chosen */
	                                     {.position = {-2.0f, 2.4f, 2.0f},
	                                      .direction = {0.48f, -0.8f, -0.36f},
	                                      .intensity = {1.0f, 1.0f, 1.0f},
	                                      .radius = 0.4f,
	                                      .half_x = {0.3f, 0.0f, 0.4f},
	                                      .half_y = {0.192f, 0.18f, -0.144f}}};
	double worst = 0.0;
	for (int i = 0; i < 2 * 3 * 3 * 5; i++) {
		gloss g = {.model = models[i / 5 % 3],
		           .eye = {0.3f, 2.2f, 6.0f},
		           .material = {.specular = {0.5f, 0.5f, 0.5f}, .roughness = roughness[i % 5]},
		           .light = lights[i / 45]};
		g.light.kind = SHADE_LIGHT_SPHERE + i / 15 % 3;
		double error = gloss_error(&g);
		if (error >= 0.05)
			fail_msg("light %d of kind %d, model %d, roughness %.2f: off by %.2f %%", i / 45, g.light.kind,
			         g.model.kind, (double)g.material.roughness, 100.0 * error);
		worst = fmax(worst, error);
	}
	printf("highlights of lights with a size: off by %.2f %% at most\n", 100.0 * worst);
}

int main(void)
{
	const struct CMUnitTest exactness[] = {
		cmocka_unit_test(spheres_to_six_digits),       cmocka_unit_test(ramps_to_six_digits),
		cmocka_unit_test(a_distant_rectangle_rises),   cmocka_unit_test(borders_of_disks_to_five_digits),
		cmocka_unit_test(flat_lights_to_four_digits),  cmocka_unit_test(highlights_widen),
		cmocka_unit_test(highlights_beside_integrals),
	};
	const struct CMUnitTest properties[] = {
		cmocka_unit_test(flat_lights_are_exact),
		cmocka_unit_test(small_lights_on_the_horizon),
		cmocka_unit_test(disks_in_special_places),
		cmocka_unit_test(rectangles_in_special_places),
		cmocka_unit_test(spheres_are_exact_below_the_horizon_too),
		cmocka_unit_test(lights_send_their_intensity),
		cmocka_unit_test(bounds),
	};
	return SHADE_PROOF_RUN(exactness, properties);
}
