/* Lights: units, falloffs and lamps against closed forms in double, and against the integral over the lamp's body. */
#include "numeric/numeric_quadrature.h"
#include "shading/shade_diffuse.h"
#include "shading/shade_light.h"
#include "support/shade_proof.h"

/* ---- exactness --------------------------------------------------------------------------------------------------- */

static const stilb_vec3 COLOR = {3.0f, 0.5f, 7e5f};

static void units_are_the_ones_of_their_formulas(void **state)
{
	(void)state;
	double r0 = 0.25, disc = M_PI * r0 * r0;
	SHADE_PROOF_NEAR3(shade_intensity_from_radiance(COLOR, 0.25f), 3.0 * disc, 0.5 * disc, 7e5 * disc, 3e-7, 0.0);
	SHADE_PROOF_NEAR3(shade_radiance_from_intensity(COLOR, 0.25f), 3.0 / disc, 0.5 / disc, 7e5 / disc, 3e-7, 0.0);
	double sphere = 4.0 * M_PI, face = M_PI;
	SHADE_PROOF_NEAR3(shade_flux_from_intensity_sphere(COLOR), 3.0 * sphere, 0.5 * sphere, 7e5 * sphere, 3e-7, 0.0);
	SHADE_PROOF_NEAR3(shade_intensity_from_flux_sphere(COLOR), 3.0 / sphere, 0.5 / sphere, 7e5 / sphere, 3e-7, 0.0);
	SHADE_PROOF_NEAR3(shade_flux_from_intensity_disk(COLOR), 3.0 * face, 0.5 * face, 7e5 * face, 3e-7, 0.0);
	SHADE_PROOF_NEAR3(shade_intensity_from_flux_disk(COLOR), 3.0 / face, 0.5 / face, 7e5 / face, 3e-7, 0.0);
	/* 1 lm of white is 1 / 179 W; of a colour, as much as its luminance says; black has none. */
	SHADE_PROOF_NEAR3(shade_watts_from_lumens(179.0f, (stilb_vec3){0}), 0.0, 0.0, 0.0, 0.0, 0.0);
	SHADE_PROOF_NEAR3(shade_watts_from_lumens(179.0f, stilb_vec3_make(1.0f, 1.0f, 1.0f)), 1.0, 1.0, 1.0, 3e-7, 0.0);
	SHADE_PROOF_NEAR3(shade_watts_from_lumens(179.0f, stilb_vec3_make(0.0f, 8.0f, 0.0f)), 0.0, 1.0 / 0.7152, 0.0, 3e-7,
	                  0.0);
}

/* The chromaticity of a linear Rec.709 colour. */
static void chromaticity_of(stilb_vec3 c, double xy[2])
{
	double r = (double)c[0], g = (double)c[1], b = (double)c[2];
	double x = 0.4124564 * r + 0.3575761 * g + 0.1804375 * b, y = 0.2126729 * r + 0.7151522 * g + 0.0721750 * b;
	double z = 0.0193339 * r + 0.1191920 * g + 0.9503041 * b;
	xy[0] = x / (x + y + z);
	xy[1] = y / (x + y + z);
}

/* Of CIE's illuminant A, which is a black body of 2856 K, and of its tables of Planck's law. */
static void glowing_bodies_have_their_colors(void **state)
{
	(void)state;
	static const double known[][3] = {{2856, 0.44757, 0.40745},
	                                  {2000, 0.52669, 0.41331},
	                                  {4000, 0.38045, 0.37676},
	                                  {6500, 0.31352, 0.32363},
	                                  {10000, 0.28063, 0.28828}};
	for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
		double xy[2];
		stilb_vec3 color = shade_color_of_temperature((float)known[i][0]);
		chromaticity_of(color, xy);
		SHADE_PROOF_NEAR(fmax((double)color[0], (double)color[2]), 1.0, 1e-6, 0.0);
		SHADE_PROOF_NEAR(xy[0], known[i][1], 0.0, 4e-4);
		SHADE_PROOF_NEAR(xy[1], known[i][2], 0.0, 4e-4);
	}
	/* The formulas in double, with their limits. */
	for (int i = 0; i <= 40; i++) {
		double kelvin = 500.0 * i + 1.0, t = fmin(fmax(kelvin, 1000.0), 15000.0);
		double u = (0.860117757 + 1.54118254e-4 * t + 1.28641212e-7 * t * t) /
		           (1.0 + 8.42420235e-4 * t + 7.08145163e-7 * t * t);
		double v = (0.317398726 + 4.22806245e-5 * t + 4.20481691e-8 * t * t) /
		           (1.0 - 2.89741816e-5 * t + 1.61456053e-7 * t * t);
		double x = 3.0 * u / (2.0 * u - 8.0 * v + 4.0), y = 2.0 * v / (2.0 * u - 8.0 * v + 4.0);
		double xyz[3] = {x / y, 1.0, (1.0 - x - y) / y};
		double red = 3.2404542 * xyz[0] - 1.5371385 - 0.4985314 * xyz[2];
		double green = -0.9692660 * xyz[0] + 1.8760108 + 0.0415560 * xyz[2];
		double blue = fmax(0.0556434 * xyz[0] - 0.2040259 + 1.0572252 * xyz[2], 0.0),
			   most = fmax(red, fmax(green, blue));
		stilb_vec3 color = shade_color_of_temperature((float)kelvin);
		SHADE_PROOF_NEAR(color[0], red / most, 1e-5, 1e-6);
		SHADE_PROOF_NEAR(color[1], green / most, 1e-5, 1e-6);
		SHADE_PROOF_NEAR(color[2], blue / most, 1e-5, 1e-6);
	}
	stilb_vec3 ember = shade_color_of_temperature(1000.0f), colder = shade_color_of_temperature(10.0f);
	SHADE_PROOF_NEAR(ember[0], 1.0, 0.0, 0.0);
	SHADE_PROOF_NEAR(ember[2], 0.0, 0.0, 0.0);
	SHADE_PROOF_NEAR3(colder, ember[0], ember[1], ember[2], 0.0, 0.0);
	SHADE_PROOF_NEAR3(shade_color_of_temperature(1e9f), shade_color_of_temperature(15000.0f)[0],
	                  shade_color_of_temperature(15000.0f)[1], 1.0, 0.0, 0.0);
}

/* A lamp's flux is what its surface emits: pi L per area for the radiance L. */
static void flux_is_what_leaves_the_surface(void **state)
{
	(void)state;
	stilb_vec3 intensity = shade_intensity_from_radiance(COLOR, 0.5f);
	SHADE_PROOF_NEAR(shade_flux_from_intensity_sphere(intensity)[0], M_PI * 3.0 * (4.0 * M_PI * 0.25), 3e-7, 0.0);
	SHADE_PROOF_NEAR(shade_flux_from_intensity_disk(intensity)[0], M_PI * 3.0 * (M_PI * 0.25), 3e-7, 0.0);
}

/* The games' convention: a light of 1 that a white surface faces shows it as 1, without a pi in sight. */
static void folded_light_shows_white_as_one(void **state)
{
	(void)state;
	stilb_vec3 one = stilb_vec3_make(1.0f, 1.0f, 1.0f);
	SHADE_PROOF_NEAR3(shade_lambert(one) * shade_from_pi_folded(one), 1.0, 1.0, 1.0, 3e-7, 0.0);
	SHADE_PROOF_NEAR3(shade_to_pi_folded(one), 1.0 / M_PI, 1.0 / M_PI, 1.0 / M_PI, 1e-7, 0.0);
	/* Schueler's two intensities: I = pi L r0^2 is the folded I' = L r0^2. */
	stilb_vec3 folded = shade_to_pi_folded(shade_intensity_from_radiance(COLOR, 0.25f));
	SHADE_PROOF_NEAR(folded[0], 3.0 / 16.0, 3e-7, 0.0);
}

static void the_sky_lights_evenly(void **state)
{
	(void)state;
	stilb_vec3 sky = {2.0f, 0.3f, 0.0f}, ground = {0.5f, 0.9f, 1.0f};
	for (int i = -4; i <= 4; i++) {
		double y = i / 4.0, up = 0.5 * (1.0 + y), down = 0.5 * (1.0 - y);
		SHADE_PROOF_NEAR3(shade_hemisphere_irradiance((float)y, sky, ground), M_PI * (2.0 * up + 0.5 * down),
		                  M_PI * (0.3 * up + 0.9 * down), M_PI * down, 3e-7, 1e-7);
	}
}

static double share_in_double(double y, double n)
{
	double k = 2.0 / M_PI * (n + 0.5 + 1.0 / (8.0 * n + 49.0 / 8.0));
	return 0.5 * (1.0 + copysign(sqrt(-expm1(k * log1p(-y * y))), y));
}

static void shares_are_those_of_the_formula(void **state)
{
	(void)state;
	static const double exponents[] = {0.0, 0.25, 1.0, 3.0, 20.0, 1e3, 1e6};
	for (size_t i = 0; i < sizeof exponents / sizeof exponents[0]; i++)
		for (int step = -20; step <= 20; step++) {
			double y = (double)(float)(step / 20.0 * fmin(0.999, 5.0 / sqrt(exponents[i] + 1.0)));
			float share = shade_hemisphere_share((float)y, (float)exponents[i]);
			SHADE_PROOF_NEAR(share, share_in_double(y, exponents[i]), 0.0, 4e-7);
		}
	stilb_vec3 sky = {2.0f, 0.3f, 0.0f}, ground = {0.5f, 0.9f, 1.0f};
	/* With an exponent of 1 it is the irradiance of the sky, divided by pi. */
	SHADE_PROOF_NEAR3(shade_hemisphere_radiance(0.5f, 1.0f, sky, ground), 1.625, 0.45, 0.25, 0.0, 1e-6);
}

static void falloffs_are_those_of_their_formulas(void **state)
{
	(void)state;
	static const double squares[] = {0.0, 1e-3, 0.24, 0.26, 1.0, 30.0, 1e18};
	for (size_t i = 0; i < sizeof squares / sizeof squares[0]; i++) {
		double square = (double)(float)squares[i];
		SHADE_PROOF_NEAR(shade_falloff_sphere((float)square, 0.5f), 1.0 / fmax(square, 0.25), 3e-7, 0.0);
		SHADE_PROOF_NEAR(shade_falloff_disk((float)square, 0.5f), 1.0 / (square + 0.25), 3e-7, 0.0);
		double left = fmax(1.0 - square / 36.0, 0.0);
		SHADE_PROOF_NEAR(shade_falloff_window((float)square, 6.0f), left * left, 1e-6, 0.0);
		double quartic = fmax(1.0 - square * square / 1296.0, 0.0);
		SHADE_PROOF_NEAR(shade_falloff_range((float)square, 6.0f), quartic, 1e-6, 0.0);
		SHADE_PROOF_NEAR(shade_falloff_share(SHADE_FALLOFF_RANGED, (float)square, 0.5f, 6.0f), quartic, 1e-6, 0.0);
	}
	SHADE_PROOF_NEAR(shade_falloff_subtracted(0.5f, 0.3f), 0.2, 2e-7, 0.0);
	assert_true(shade_falloff_subtracted(0.3f, 0.5f) == 0.0f);
	SHADE_PROOF_NEAR(shade_tolerance_from_reach(8.0f), 1.0 / 64.0, 1e-7, 0.0);
	SHADE_PROOF_NEAR(shade_reach_from_error(50.0f, 0.02f), 50.0, 1e-7, 0.0);
}

/* A light at (1, 2, 3) that shines along +Y, with a radius of 0.5 m and a reach of 4 m. */
static shade_light lamp_of(int kind, int falloff)
{
	return (shade_light){.kind = kind,
	                     .falloff = falloff,
	                     .position = {1.0f, 2.0f, 3.0f},
	                     .direction = {0.0f, 1.0f, 0.0f},
	                     .intensity = {10.0f, 20.0f, 0.0f},
	                     .radius = 0.5f,
	                     .reach = 4.0f};
}

/* From a point 2 m above and 1 m beside it. */
static void lamps_are_seen_as_suns(void **state)
{
	(void)state;
	stilb_vec3 position = stilb_vec3_make(2.0f, 4.0f, 3.0f);
	shade_sun sphere = shade_light_at(lamp_of(SHADE_LIGHT_SPHERE, SHADE_FALLOFF_PHYSICAL), position);
	double length = sqrt(5.0);
	SHADE_PROOF_NEAR3(sphere.direction, -1.0 / length, -2.0 / length, 0.0, 0.0, 1e-7);
	SHADE_PROOF_NEAR3(sphere.irradiance, 2.0, 4.0, 0.0, 3e-7, 0.0);
	shade_light flat = lamp_of(SHADE_LIGHT_DISK, SHADE_FALLOFF_PHYSICAL);
	shade_sun disk = shade_light_at(flat, position);
	SHADE_PROOF_NEAR3(disk.direction, -1.0 / length, -2.0 / length, 0.0, 0.0, 1e-7);
	SHADE_PROOF_NEAR(disk.irradiance[0], 10.0 * (2.0 / length) / 5.25, 4e-7, 0.0);
	double left = 1.0 - 5.0 / 16.0;
	shade_sun windowed = shade_light_at(lamp_of(SHADE_LIGHT_SPHERE, SHADE_FALLOFF_WINDOWED), position);
	SHADE_PROOF_NEAR(windowed.irradiance[0], 2.0 * left * left, 4e-7, 0.0);
	shade_sun subtracted = shade_light_at(lamp_of(SHADE_LIGHT_SPHERE, SHADE_FALLOFF_SUBTRACTED), position);
	SHADE_PROOF_NEAR(subtracted.irradiance[0], 10.0 * (1.0 / 5.0 - 1.0 / 16.0), 4e-7, 0.0);
	shade_sun point = shade_light_at(lamp_of(SHADE_LIGHT_POINT, SHADE_FALLOFF_WINDOWED), position);
	SHADE_PROOF_NEAR(point.irradiance[0], 2.0 * left * left, 4e-7, 0.0);
	/* Behind the disk there is no light; a point in a light's centre sees it in the direction against its own, as
	 * bright as its surface. */
	shade_sun behind = shade_light_at(flat, stilb_vec3_make(1.0f, 1.0f, 3.0f));
	assert_true(behind.irradiance[0] == 0.0f && behind.direction[1] == 1.0f);
	for (int kind = SHADE_LIGHT_SPHERE; kind <= SHADE_LIGHT_DISK; kind++) {
		shade_light light = lamp_of(kind, SHADE_FALLOFF_PHYSICAL);
		shade_sun centre = shade_light_at(light, light.position);
		SHADE_PROOF_NEAR3(centre.direction, 0.0, -1.0, 0.0, 0.0, 0.0);
		SHADE_PROOF_NEAR(centre.irradiance[0], 10.0 / 0.25, 1e-7, 0.0);
	}
	/* A rectangle counts as the disk of the same area. */
	flat.kind = SHADE_LIGHT_RECTANGLE;
	flat.half_x = stilb_vec3_make(0.0f, 0.0f, 0.125f);
	flat.half_y = stilb_vec3_make((float)M_PI * 0.5f, 0.0f, 0.0f);
	SHADE_PROOF_NEAR(shade_rectangle_area(flat.half_x, flat.half_y), M_PI * 0.25, 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_light_at(flat, position).irradiance[0], disk.irradiance[0], 1e-6, 0.0);
}

static void spots_fade_between_their_angles(void **state)
{
	(void)state;
	SHADE_PROOF_NEAR(shade_spot_share(0.9f, 0.9f, 0.5f), 1.0, 0.0, 0.0);
	SHADE_PROOF_NEAR(shade_spot_share(0.5f, 0.9f, 0.5f), 0.0, 0.0, 0.0);
	SHADE_PROOF_NEAR(shade_spot_share(-1.0f, 0.9f, 0.5f), 0.0, 0.0, 0.0);
	SHADE_PROOF_NEAR(shade_spot_share(0.7f, 0.9f, 0.5f), 0.5, 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_spot_share(0.6f, 0.9f, 0.5f), 0.0625 * 2.5, 1e-6, 0.0); /* t = 1/4 */
	SHADE_PROOF_NEAR(shade_spot_share(0.81f, 0.8f, 0.8f), 1.0, 0.0, 0.0);
	SHADE_PROOF_NEAR(shade_spot_share(0.79f, 0.8f, 0.8f), 0.0, 0.0, 0.0);
}

static void point_lights_are_seen_as_suns(void **state)
{
	(void)state;
	stilb_vec3 place = stilb_vec3_make(1.0f, 2.0f, 3.0f), down = stilb_vec3_make(0.0f, -1.0f, 0.0f);
	shade_light light = {.kind = SHADE_LIGHT_POINT,
	                     .position = place,
	                     .direction = down,
	                     .intensity = COLOR,
	                     .cos_inner = 0.9f,
	                     .cos_outer = 0.5f};
	shade_sun seen = shade_light_at(light, stilb_vec3_make(1.0f, 2.0f, 7.0f)); /* 4 m behind it */
	SHADE_PROOF_NEAR3(seen.direction, 0.0, 0.0, -1.0, 1e-6, 0.0);
	SHADE_PROOF_NEAR3(seen.irradiance, 3.0 / 16.0, 0.5 / 16.0, 7e5 / 16.0, 1e-6, 0.0);
	light.kind = SHADE_LIGHT_SPOT; /* which does not reach that point, but one below it, and half of one beside */
	seen = shade_light_at(light, stilb_vec3_make(1.0f, 2.0f, 7.0f));
	SHADE_PROOF_NEAR3(seen.irradiance, 0.0, 0.0, 0.0, 0.0, 0.0);
	seen = shade_light_at(light, stilb_vec3_make(1.0f, -3.0f, 3.0f));
	SHADE_PROOF_NEAR3(seen.irradiance, 3.0 / 25.0, 0.5 / 25.0, 7e5 / 25.0, 1e-6, 0.0);
	SHADE_PROOF_NEAR3(seen.direction, 0.0, 1.0, 0.0, 1e-6, 0.0);
	float beside = sqrtf(1.0f / 0.49f - 1.0f); /* where the cosine is 0.7, 1 m below */
	seen = shade_light_at(light, stilb_vec3_make(1.0f + beside, 1.0f, 3.0f));
	SHADE_PROOF_NEAR(seen.irradiance[0], 0.5 * 3.0 * 0.49, 1e-5, 0.0);
	light.kind = SHADE_LIGHT_DIRECTIONAL;
	seen = shade_light_at(light, stilb_vec3_make(70.0f, 80.0f, 90.0f));
	SHADE_PROOF_NEAR3(seen.direction, 0.0, 1.0, 0.0, 0.0, 0.0);
	SHADE_PROOF_NEAR3(seen.irradiance, 3.0, 0.5, 7e5, 0.0, 0.0);
}

/* ---- falloffs against the integral over the lamp's body ---------------------------------------------------------- */

/* A receiver in the origin of a frame whose z points to the lamp's centre; its normal is tilted in the x-z plane. */
typedef struct receiver {
	double normal[3];
} receiver;

static double cosine_of_receiver(const double direction[3], const void *context)
{
	const double *n = ((const receiver *)context)->normal;
	return fmax(n[0] * direction[0] + n[2] * direction[2], 0.0);
}

/* E of a sphere of radiance 1: the integral of n.l over the cap that it covers. */
static void spheres_are_exact_above_the_horizon(void **state)
{
	(void)state;
	for (double distance = 1.001; distance < 40.0; distance *= 1.7) {
		double sine = 1.0 / distance, cosine = sqrt(1.0 - sine * sine);
		for (int step = 0; step <= 10; step++) {
			double tilt = step / 10.0 * acos(sine); /* at the end the sphere touches the horizon */
			receiver r = {{sin(tilt), 0.0, cos(tilt)}};
			double truth = stilb_numeric_integrate_sphere(cosine_of_receiver, &r, cosine, 1.0, 4);
			stilb_vec3 intensity = shade_intensity_from_radiance(stilb_vec3_make(1.0f, 1.0f, 1.0f), 1.0f);
			double irradiance = (double)(intensity[0] * shade_falloff_sphere((float)(distance * distance), 1.0f));
			SHADE_PROOF_NEAR(irradiance * cos(tilt), truth, 1e-6, 1e-6);
		}
	}
}

/* E on a surface parallel to a disk of radius 1 and radiance 1, at the height h and the distance x from its axis.
 * Source: Foote, "Illumination from Circular Disk Source" (1915). */
static double foote(double h, double x)
{
	double a = h * h + x * x + 1.0;
	return 0.5 * M_PI * (1.0 - (a - 2.0) / sqrt(a * a - 4.0 * x * x));
}

static double ring_of_disk(double radius, const void *context)
{
	const double *at = context;
	double square = at[0] * at[0] + radius * radius;
	return 2.0 * M_PI * radius * at[0] * at[0] / (square * square);
}

static void disks_are_exact_on_the_axis_and_far_away(void **state)
{
	(void)state;
	shade_light lamp = {.kind = SHADE_LIGHT_DISK,
	                    .direction = {0.0f, 1.0f, 0.0f},
	                    .intensity = {(float)M_PI, 0.0f, 0.0f},
	                    .radius = 1.0f};
	for (double h = 0.01; h < 100.0; h *= 1.5) {
		shade_sun seen = shade_light_at(lamp, stilb_vec3_make(0.0f, (float)h, 0.0f));
		double truth = stilb_numeric_integrate(ring_of_disk, &h, 0.0, 1.0, 200);
		SHADE_PROOF_NEAR(seen.irradiance[0], truth, 1e-6, 0.0);
		SHADE_PROOF_NEAR(foote(h, 0.0), truth, 1e-9, 0.0);
	}
	/* Off the axis, on a surface parallel to the disk: less than Foote's exact value by 3 (sin(b) r0 / d)^2 of it, b
	 * being the angle to the axis, and by a term of higher order. */
	for (double distance = 5.0; distance < 100.0; distance *= 1.4)
		for (int step = 0; step < 9; step++) {
			double angle = step * M_PI / 18.0, h = distance * cos(angle), x = distance * sin(angle);
			shade_sun seen = shade_light_at(lamp, stilb_vec3_make((float)x, (float)h, 0.0f));
			double n_dot_l = -(double)seen.direction[1];
			double order = 1.0 / (distance * distance), share = 1.0 - 3.0 * sin(angle) * sin(angle) * order;
			SHADE_PROOF_NEAR((double)seen.irradiance[0] * n_dot_l, share * foote(h, x), 8.0 * order * order + 1e-6,
			                 0.0);
		}
}

/* Through a sphere about a lamp flows the lamp's flux, at any distance. */
static double through_height(double y, const void *context)
{
	int light = *(const int *)context;
	shade_light lamp = {
		.kind = light, .direction = {0.0f, 1.0f, 0.0f}, .intensity = {2.0f, 2.0f, 2.0f}, .radius = 0.1f};
	float x = (float)sqrt(1.0 - y * y);
	shade_sun seen = shade_light_at(lamp, stilb_vec3_make(5.0f * x, 5.0f * (float)y, 0.0f));
	return 2.0 * M_PI * 25.0 * (double)seen.irradiance[0];
}

static void flux_is_kept(void **state)
{
	(void)state;
	stilb_vec3 intensity = stilb_vec3_make(2.0f, 2.0f, 2.0f);
	int sphere = SHADE_LIGHT_SPHERE, disk = SHADE_LIGHT_DISK;
	SHADE_PROOF_NEAR(stilb_numeric_integrate(through_height, &sphere, -1.0, 1.0, 4),
	                 shade_flux_from_intensity_sphere(intensity)[0], 1e-6, 0.0);
	/* The disk's falloff divides by r0^2 + d^2 and not by d^2: at 50 radii that is 0.04 % too little. */
	SHADE_PROOF_NEAR(stilb_numeric_integrate(through_height, &disk, 0.0, 1.0, 4),
	                 (double)shade_flux_from_intensity_disk(intensity)[0] / (1.0 + 1.0 / 2500.0), 1e-6, 0.0);
}

/* ---- the sky against the integral over all directions ------------------------------------------------------------ */

typedef struct lobe {
	double axis[3]; /* z is up */
	double exponent;
} lobe;

static double lobe_at(const double direction[3], const void *context)
{
	const lobe *l = context;
	double cosine = l->axis[0] * direction[0] + l->axis[2] * direction[2];
	return cosine > 0.0 ? pow(cosine, l->exponent) : 0.0;
}

static double power_of_cosine(double angle, const void *context)
{
	return pow(fmax(cos(angle), 0.0), *(const double *)context);
}

/* The share as an integral over one angle, which the header says is the same. */
static double exact_share(double y, double exponent)
{
	double width = fmin(M_PI / 2.0, 12.0 / sqrt(exponent + 1.0)), end = fmin(fmax(asin(y), -width), width);
	double above = stilb_numeric_integrate(power_of_cosine, &exponent, -width, end, 20);
	return above / (2.0 * stilb_numeric_integrate(power_of_cosine, &exponent, 0.0, width, 20));
}

static void a_lobe_is_cut_by_the_horizon_as_one_angle_says(void **state)
{
	(void)state;
	static const double exponents[] = {1.0, 2.0, 7.0, 30.0};
	for (size_t i = 0; i < sizeof exponents / sizeof exponents[0]; i++)
		for (int step = -3; step <= 3; step++) {
			double y = step / 4.0;
			lobe l = {{sqrt(1.0 - y * y), 0.0, y}, exponents[i]};
			double above = stilb_numeric_integrate_sphere(lobe_at, &l, 0.0, 1.0, 24);
			double below = stilb_numeric_integrate_sphere(lobe_at, &l, -1.0, 0.0, 24);
			SHADE_PROOF_NEAR(above / (above + below), exact_share(y, exponents[i]), 0.0, 1e-4);
			if (i == 0) /* an exponent of 1 is the cosine lobe of irradiance (Liu and Jordan) */
				SHADE_PROOF_NEAR(
					shade_hemisphere_irradiance((float)y, stilb_vec3_make(1.0f, 1.0f, 1.0f), (stilb_vec3){0})[0], above,
					0.0, 1e-4);
		}
}

static void shares_are_near_the_exact_ones(void **state)
{
	(void)state;
	double worst = 0.0, worst_below_half = 0.0;
	for (double exponent = 0.0; exponent < 1e6; exponent = exponent * 1.5 + 0.05)
		for (int step = -50; step <= 50; step++) {
			double y = step / 50.0 * fmin(1.0, 6.0 / sqrt(exponent + 1.0));
			double share = (double)shade_hemisphere_share((float)y, (float)exponent);
			double error = fabs(share - exact_share((double)(float)y, exponent));
			if (exponent >= 0.5)
				worst = fmax(worst, error);
			else
				worst_below_half = fmax(worst_below_half, error);
		}
	if (!(worst < 0.0032 && worst > 0.0025 && worst_below_half < 0.0065 && worst_below_half > 0.004))
		fail_msg("the shares are off by %g, and by %g below an exponent of 0.5", worst, worst_below_half);
	/* The exact share is a line for the exponent 1 and a smoothstep for 3. */
	for (int step = -10; step <= 10; step++) {
		double y = step / 10.0;
		SHADE_PROOF_NEAR(shade_hemisphere_share((float)y, 1.0f), 0.5 + 0.5 * y, 0.0, 1e-6);
		SHADE_PROOF_NEAR(exact_share(y, 3.0), 0.25 * (2.0 + 3.0 * y - y * y * y), 0.0, 1e-9);
	}
}

/* ---- random lights ----------------------------------------------------------------------------------------------- */

static void units_go_there_and_back(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 1};
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		float light = shade_proof_log_range(&random, 1e-15f, 1e15f),
			  radius = shade_proof_log_range(&random, 2e-4f, 1e4f);
		stilb_vec3 color = stilb_vec3_make(light, 0.0f, 2.0f * light);
		stilb_vec3 radius_and_back =
			shade_radiance_from_intensity(shade_intensity_from_radiance(color, radius), radius);
		stilb_vec3 sphere = shade_intensity_from_flux_sphere(shade_flux_from_intensity_sphere(color));
		stilb_vec3 disk = shade_intensity_from_flux_disk(shade_flux_from_intensity_disk(color));
		stilb_vec3 folded = shade_from_pi_folded(shade_to_pi_folded(color));
		const stilb_vec3 results[] = {radius_and_back, sphere, disk, folded};
		for (size_t k = 0; k < sizeof results / sizeof results[0]; k++)
			SHADE_PROOF_NEAR3(results[k], light, 0.0, 2.0f * light, 4e-7, 0.0);
		float lumens = shade_proof_range(&random, 0.0f, 1e5f);
		stilb_vec3 watts = shade_watts_from_lumens(lumens, color);
		SHADE_PROOF_NEAR(179.0 * (double)shade_luminance(watts), lumens, 1e-6, 0.0);
	}
}

/* A sphere. */
static shade_light random_lamp(shade_proof_random *random)
{
	shade_light lamp = {.kind = SHADE_LIGHT_SPHERE, .direction = shade_proof_random_direction(random)};
	lamp.intensity = shade_proof_random_color(random, shade_proof_log_range(random, 1e-6f, 1e15f));
	lamp.position = shade_proof_random_direction(random) * shade_proof_log_range(random, 1e-6f, 1e8f);
	lamp.radius = shade_proof_uniform(random) < 0.1f ? 0.0f : shade_proof_log_range(random, 1e-6f, 1e3f);
	lamp.reach = lamp.radius + shade_proof_log_range(random, 1e-2f, 1e6f);
	return lamp;
}

/* A point at any distance from the lamp's centre: from almost none, inside its body, to far beyond its reach. */
static stilb_vec3 random_position(shade_proof_random *random, const shade_light *lamp)
{
	float far = shade_proof_uniform(random) < 0.5f ? 2.0f * lamp->reach : 1e8f;
	float distance = shade_proof_uniform(random) < 0.05f ? 0.0f : shade_proof_log_range(random, 1e-7f, far);
	return lamp->position + shade_proof_random_direction(random) * distance;
}

/* No lamp is brighter than its own surface, whose irradiance is pi L at most. The windowed and the subtracted one end
 * at their reach and are never brighter than the sphere, which does not end; the subtracted one is darker by its
 * tolerance at most, and not darker than the windowed one outside of the lamp's body. */
static void lamps_keep_their_bounds(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 2};
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		shade_light lamp = random_lamp(&random), flat = lamp;
		stilb_vec3 position = random_position(&random, &lamp);
		shade_sun seen[4];
		for (lamp.falloff = 0; lamp.falloff < 4; lamp.falloff++) {
			seen[lamp.falloff] = shade_light_at(lamp, position);
			SHADE_PROOF_LIGHT3(seen[lamp.falloff].irradiance);
			stilb_vec3 direction = seen[lamp.falloff].direction;
			SHADE_PROOF_NEAR(stilb_vec3_dot(direction, direction), 1.0, 0.0, 2e-6);
		}
		flat.kind = SHADE_LIGHT_DISK;
		float sphere = seen[SHADE_FALLOFF_PHYSICAL].irradiance[0], intensity = lamp.intensity[0];
		float surface = (float)M_PI * shade_radiance_from_intensity(lamp.intensity, lamp.radius)[0];
		assert_true(sphere <= 1.000001f * surface);
		assert_true(shade_light_at(flat, position).irradiance[0] <= 1.000001f * surface);
		assert_true(seen[SHADE_FALLOFF_WINDOWED].irradiance[0] <= sphere);
		float subtracted = seen[SHADE_FALLOFF_SUBTRACTED].irradiance[0];
		assert_true(subtracted <= sphere);
		assert_true(sphere - subtracted <=
		            1.000001f * intensity * shade_tolerance_from_reach(lamp.reach) + 1e-6f * sphere);
		stilb_vec3 offset = position - lamp.position;
		float ranged = seen[SHADE_FALLOFF_RANGED].irradiance[0];
		/* Outside of the body all have I / d^2 times a factor: (1 - x^2)^2, 1 - x^2 and 1 - x^4, with x = d / reach. */
		if (sqrtf(stilb_vec3_dot(offset, offset)) > fmaxf(lamp.radius, 1e-4f)) {
			assert_true(seen[SHADE_FALLOFF_WINDOWED].irradiance[0] <= subtracted + 1e-6f * sphere);
			assert_true(subtracted <= ranged + 1e-6f * sphere);
		}
		if (sqrtf(stilb_vec3_dot(offset, offset)) > 1.00001f * lamp.reach)
			assert_true(seen[SHADE_FALLOFF_WINDOWED].irradiance[0] == 0.0f && subtracted == 0.0f && ranged == 0.0f);
	}
}

/* Further away is never brighter. */
static void falloffs_fall(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 3};
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		shade_light lamp = random_lamp(&random);
		float near = shade_proof_log_range(&random, 1e-14f, 1e16f);
		float far = near * shade_proof_range(&random, 1.0f, 3.0f), cosine = shade_proof_range(&random, -1.0f, 1.0f);
		for (lamp.kind = 0; lamp.kind < SHADE_LIGHT_COUNT; lamp.kind++)
			for (lamp.falloff = 0; lamp.falloff < 3; lamp.falloff++)
				assert_true(shade_light_falloff(lamp, near, cosine) >= shade_light_falloff(lamp, far, cosine));
		/* At the distance shade_reach_from_error the sphere's irradiance is just that error. */
		float intensity = shade_proof_log_range(&random, 1e-6f, 1e6f),
			  error = shade_proof_log_range(&random, 1e-6f, 1.0f);
		float reach = shade_reach_from_error(intensity, error);
		SHADE_PROOF_NEAR(intensity * shade_tolerance_from_reach(reach), error, 1e-6, intensity > 1e-4f ? 0.0 : 1e30);
	}
}

static void skies_stay_between_their_colours(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 4};
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		float y = shade_proof_range(&random, -1.0f, 1.0f), highest = shade_proof_log_range(&random, 1e-6f, 1e15f);
		float exponent = shade_proof_uniform(&random) < 0.1f ? 0.0f : shade_proof_log_range(&random, 1e-3f, 1e6f);
		y = i < 2 ? (i == 0 ? -1.0f : 1.0f) : i % 2 ? y : y * fminf(1.0f, 4.0f / sqrtf(exponent));
		stilb_vec3 sky = shade_proof_random_color(&random, highest),
				   ground = shade_proof_random_color(&random, highest);
		stilb_vec3 irradiance = shade_hemisphere_irradiance(y, sky, ground);
		stilb_vec3 radiance = shade_hemisphere_radiance(y, exponent, sky, ground);
		SHADE_PROOF_LIGHT3(irradiance);
		SHADE_PROOF_LIGHT3(radiance);
		assert_true(radiance[0] <= 1.000001f * fmaxf(sky[0], ground[0]));
		float share = shade_hemisphere_share(y, exponent);
		assert_true(share >= 0.0f && share <= 1.0f);
		SHADE_PROOF_NEAR(shade_hemisphere_share(-y, exponent), 1.0 - (double)share, 0.0, 1e-7);
	}
}

int main(void)
{
	const struct CMUnitTest exactness[] = {
		cmocka_unit_test(units_are_the_ones_of_their_formulas),
		cmocka_unit_test(glowing_bodies_have_their_colors),
		cmocka_unit_test(flux_is_what_leaves_the_surface),
		cmocka_unit_test(folded_light_shows_white_as_one),
		cmocka_unit_test(the_sky_lights_evenly),
		cmocka_unit_test(shares_are_those_of_the_formula),
		cmocka_unit_test(falloffs_are_those_of_their_formulas),
		cmocka_unit_test(lamps_are_seen_as_suns),
		cmocka_unit_test(spots_fade_between_their_angles),
		cmocka_unit_test(point_lights_are_seen_as_suns),
	};
	const struct CMUnitTest properties[] = {
		cmocka_unit_test(spheres_are_exact_above_the_horizon),
		cmocka_unit_test(disks_are_exact_on_the_axis_and_far_away),
		cmocka_unit_test(flux_is_kept),
		cmocka_unit_test(a_lobe_is_cut_by_the_horizon_as_one_angle_says),
		cmocka_unit_test(shares_are_near_the_exact_ones),
		cmocka_unit_test(units_go_there_and_back),
		cmocka_unit_test(lamps_keep_their_bounds),
		cmocka_unit_test(falloffs_fall),
		cmocka_unit_test(skies_stay_between_their_colours),
	};
	return SHADE_PROOF_RUN(exactness, properties);
}
