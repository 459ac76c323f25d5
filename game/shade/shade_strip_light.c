/* Strips of spheres under lamps, under spherical harmonics and through tone curves. */
#include "shade_strip.h"

#include "shading/shade_diffuse.h"
#include "shading/shade_light.h"
#include "shading/shade_sh.h"
#include "shading/shade_tonemap.h"

#include <math.h>
#include <stdio.h>

static stilb_vec3 even(float value)
{
	return stilb_vec3_make(value, value, value);
}

/* ---- lamps ------------------------------------------------------------------------------------------------------- */

#define BALL_RADIUS 0.5f
#define LAMP_RADIUS 0.25f
#define LAMP_REACH 4.0f

/* The distance between the centres of lamp and ball in a column, metres; in each column 1.19 times that before. */
static float lamp_distance(int column)
{
	return 0.8f * powf(1.19f, (float)column);
}

static stilb_vec3 lamp_radiance(const strip_sphere *sphere, stilb_vec3 n)
{
	stilb_vec3 to_lamp = stilb_vec3_normalize(stilb_vec3_make(-0.75f, 0.45f, 0.55f));
	shade_light lamp = {
		.kind = sphere->light & 7,
		.falloff = sphere->light >> 3,
		.position = to_lamp * sphere->number,
		.direction = -to_lamp,
		.intensity = stilb_vec3_make(5.0f, 4.6f, 4.0f),
		.radius = LAMP_RADIUS,
		.reach = LAMP_REACH,
	};
	shade_sun seen = shade_light_at(lamp, n * BALL_RADIUS);
	stilb_vec3 sky = shade_hemisphere_irradiance(n[1], even(0.03f), even(0.01f));
	return shade_lambert(sphere->diffuse) * (seen.irradiance * fmaxf(stilb_vec3_dot(n, seen.direction), 0.0f) + sky);
}

static void make_lit(const strip_row *row, int column, strip_sphere *sphere, strip_words words)
{
	float distance = lamp_distance(column);
	*sphere = (strip_sphere){.diffuse = even(0.6f), .radiance = lamp_radiance, .number = distance, .light = row->kind};
	snprintf(words, sizeof(strip_words), "%.2f m", (double)distance);
}

/* kind: a SHADE_LIGHT_ + 8 * a SHADE_FALLOFF_ */
const strip_row strip_light_rows[STRIP_LIGHT_ROWS] = {
	{.caption = "Sphere: 1 / d²", .make = make_lit, .kind = SHADE_LIGHT_SPHERE},
	{.caption = "Disk that faces\nthe ball", .make = make_lit, .kind = SHADE_LIGHT_DISK},
	{.caption = "Windowed, ends\nat 4 m", .make = make_lit, .kind = SHADE_LIGHT_SPHERE + 8 * SHADE_FALLOFF_WINDOWED},
	{.caption = "Subtracted, ends\nat 4 m",
     .make = make_lit,
     .kind = SHADE_LIGHT_SPHERE + 8 * SHADE_FALLOFF_SUBTRACTED},
};

/* ---- spherical harmonics ----------------------------------------------------------------------------------------- */

static const stilb_vec3 sky_above = {0.16f, 0.22f, 0.34f, 0.0f}, ground_below = {0.09f, 0.06f, 0.035f, 0.0f};

static shade_sun harmonic_sun(void)
{
	return (shade_sun){stilb_vec3_normalize(stilb_vec3_make(-0.62f, 0.45f, 0.55f)), stilb_vec3_make(2.8f, 2.5f, 1.9f)};
}

/* One channel of the light of sky and ground, times share, as spherical harmonics. Band 0 is the mean of both; of band
 * 1 only the vertical coefficient c_1 is not 0: the irradiance is E(n) = pi (mean + (sky - ground) n_y / 2), and its
 * second term must equal A_1 c_1 Y_1(n). */
static shade_sh sky_channel(int channel, float share)
{
	shade_sh f = shade_sh_ambient(0.5f * (sky_above[channel] + ground_below[channel]));
	f.c[1] = -0.5f * SHADE_PI * (sky_above[channel] - ground_below[channel]) / (SHADE_SH_A1 * SHADE_SH_Y1);
	return shade_sh_scale(f, share);
}

static shade_sh_rgb surroundings_of(const strip_sphere *sphere)
{
	shade_sun sun = harmonic_sun();
	float share = sphere->number;
	shade_sh_rgb sky = {sky_channel(0, share), sky_channel(1, share), sky_channel(2, share)};
	return shade_sh_rgb_add(shade_sh_rgb_directional(sun.direction, sun.irradiance), sky);
}

/* The radiance that a diffuse surface reflects; magenta marks a negative irradiance. */
static stilb_vec3 reflected(const strip_sphere *sphere, stilb_vec3 irradiance)
{
	if (fminf(irradiance[0], fminf(irradiance[1], irradiance[2])) < 0.0f)
		return stilb_vec3_make(0.6f, 0.0f, 0.6f);
	return shade_lambert(sphere->diffuse) * irradiance;
}

static stilb_vec3 radiance_true(const strip_sphere *sphere, stilb_vec3 n)
{
	shade_sun sun = harmonic_sun();
	return reflected(sphere, sun.irradiance * fmaxf(stilb_vec3_dot(n, sun.direction), 0.0f) +
	                             shade_hemisphere_irradiance(n[1], sky_above, ground_below) * sphere->number);
}

static stilb_vec3 radiance_bands(const strip_sphere *sphere, stilb_vec3 n)
{
	return reflected(sphere, shade_sh_rgb_irradiance(surroundings_of(sphere), n));
}

static stilb_vec3 radiance_window(const strip_sphere *sphere, stilb_vec3 n)
{
	shade_sh_rgb soft = shade_sh_rgb_window(surroundings_of(sphere), SHADE_SH_WINDOW_IRRADIANCE);
	return reflected(sphere, shade_sh_rgb_irradiance(soft, n));
}

static stilb_vec3 radiance_dominant(const strip_sphere *sphere, stilb_vec3 n)
{
	shade_sh_light light = shade_sh_dominant_light(surroundings_of(sphere));
	return reflected(sphere,
	                 light.irradiance * fmaxf(stilb_vec3_dot(n, light.direction), 0.0f) + light.ambient * SHADE_PI);
}

static void make_harmonic(const strip_row *row, int column, strip_sphere *sphere, strip_words words)
{
	*sphere = (strip_sphere){.diffuse = even(0.7f), .radiance = row->radiance, .number = 0.1f * (float)(10 - column)};
	snprintf(words, sizeof(strip_words), "sky %d %%", 100 - 10 * column);
}

const strip_row strip_sh_rows[STRIP_SH_ROWS] = {
	{.caption = "Truth", .make = make_harmonic, .radiance = radiance_true},
	{.caption = "Three bands", .make = make_harmonic, .radiance = radiance_bands},
	{.caption = "Three bands,\nwindowed", .make = make_harmonic, .radiance = radiance_window},
	{.caption = "Dominant light taken\nfrom the bands,\nand ambient",
     .make = make_harmonic,
     .radiance = radiance_dominant},
};

/* ---- tone curves ------------------------------------------------------------------------------------------------- */

/* A red ball under a light of the strength sphere->number, with a little light from everywhere. */
static stilb_vec3 exposed(const strip_sphere *sphere, stilb_vec3 n)
{
	stilb_vec3 l = stilb_vec3_normalize(stilb_vec3_make(-0.5f, 0.6f, 0.6f));
	float lit = fmaxf(stilb_vec3_dot(n, l), 0.0f) + 0.12f * (0.6f + 0.4f * n[1]);
	return sphere->diffuse * (lit * sphere->number);
}

/* Clips to 1 as the picture's format would, but before the samples of a pixel are averaged. */
static stilb_vec3 clipped(stilb_vec3 color)
{
	for (int k = 0; k < 3; k++)
		color[k] = fminf(color[k], 1.0f);
	return color;
}

static stilb_vec3 mapped_clipped(const strip_sphere *sphere, stilb_vec3 n)
{
	return clipped(exposed(sphere, n));
}

static stilb_vec3 mapped_channels(const strip_sphere *sphere, stilb_vec3 n)
{
	stilb_vec3 color = exposed(sphere, n);
	for (int k = 0; k < 3; k++)
		color[k] = shade_tonemap_curve(color[k], SHADE_TONEMAP_A, SHADE_TONEMAP_B);
	return color;
}

static stilb_vec3 mapped_largest(const strip_sphere *sphere, stilb_vec3 n)
{
	return shade_tonemap(exposed(sphere, n), SHADE_TONEMAP_A, SHADE_TONEMAP_B);
}

static stilb_vec3 mapped_luminance(const strip_sphere *sphere, stilb_vec3 n)
{
	return clipped(shade_tonemap_luminance(exposed(sphere, n), SHADE_TONEMAP_A, SHADE_TONEMAP_B));
}

static void make_exposed(const strip_row *row, int column, strip_sphere *sphere, strip_words words)
{
	float stops = (float)(column - 2);
	*sphere = (strip_sphere){
		.diffuse = stilb_vec3_make(0.80f, 0.24f, 0.07f), .radiance = row->radiance, .number = exp2f(stops)};
	snprintf(words, sizeof(strip_words), "light x %g", (double)sphere->number);
}

const strip_row strip_tonemap_rows[STRIP_TONEMAP_ROWS] = {
	{.caption = "Clipped", .make = make_exposed, .radiance = mapped_clipped},
	{.caption = "A curve for each\nchannel: colours wash\nout", .make = make_exposed, .radiance = mapped_channels},
	{.caption = "The largest channel's\ncurve: the hue stays", .make = make_exposed, .radiance = mapped_largest},
	{.caption = "The luminance's curve:\nbright colours leave\nthe range",
     .make = make_exposed,
     .radiance = mapped_luminance},
};
