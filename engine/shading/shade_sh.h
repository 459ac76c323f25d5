/*
 * shade_sh: spherical harmonics of three bands: light from all around as nine numbers. [any-thread]
 *
 * Meaning.    A function of the unit direction w, f(w) = sum of c[i] Y[i](w): radiance (W sr^-1 m^-2) or, convolved
 *             with the cosine, irradiance (W m^-2). The coefficients carry the same unit. Band l, 0 to 2, is the
 *             2 l + 1 functions Y that are polynomials of degree l. Irradiance hardly needs more: these three bands
 *             hold 99.2 % of the integral of max(cosine, 0)^2, the lobe that irradiance is made with.
 * Basis.      Real, orthonormal, with the Condon-Shortley phase: index l (l + 1) + m is 0; -1, 0, 1; -2, -1, 0, 1, 2.
 *             The letters x, y, z of the formulas are the world's axes (+Y up): the pole of the basis is +Z, which
 *             matters for the order of the coefficients alone.
 * Layout.     Nine floats for one channel, 27 for three: no padding, and the same in a std430 buffer.
 * Range.      Unit directions; coefficients up to 1e30 in size. All is linear in the light but the dominant light.
 * Ringing.    Three bands of a narrow light swing below zero: a directional light of irradiance 1 gives the irradiance
 *             1.0625 on a surface that faces it, 0.0625 on its back and -0.0396 where the cosine is -8 / 15.
 *             shade_sh_window takes that away.
 * Sources.    maxest, "Spherical Harmonic Lighting - Analytical Lights" (2015); Ramamoorthi and Hanrahan, "An Efficient
 *             Representation for Irradiance Environment Maps" (SIGGRAPH 2001); Sloan, "Stupid Spherical Harmonics (SH)
 *             Tricks" (GDC 2008).
 */
#ifndef SHADE_SH_H
#define SHADE_SH_H

#include "shade_constants.h"
#include "shade_frame.h"
#include "shade_luminance.h"

#include "glsl_begin.h"

/* ---- the basis --------------------------------------------------------------------------------------------------- */

#define SHADE_SH_Y0 0.28209479177387814347f   /* sqrt(1 / (4 pi)) */
#define SHADE_SH_Y1 0.48860251190291992159f   /* sqrt(3 / (4 pi)) */
#define SHADE_SH_Y2 1.09254843059207907054f   /* sqrt(15 / (4 pi)) */
#define SHADE_SH_Y2_0 0.31539156525252000603f /* sqrt(5 / (16 pi)) */
#define SHADE_SH_Y2_2 0.54627421529603953527f /* sqrt(15 / (16 pi)) */

SHADE_STRUCT(shade_sh)
{
	float c[9];
};

/* Red, green and blue light, nine coefficients each. */
SHADE_STRUCT(shade_sh_rgb)
{
	shade_sh r;
	shade_sh g;
	shade_sh b;
};

/* The nine functions Y at the unit direction d. Source: maxest, "SH Formulas", but 3 z^2 - 1 is written as
 * 2 z^2 - x^2 - y^2: a d that is a float step too long or short then scales it, and adds nothing to it. */
SHADE_FN shade_sh shade_sh_basis(vec3 d)
{
	shade_sh basis;
	basis.c[0] = SHADE_SH_Y0;
	basis.c[1] = -SHADE_SH_Y1 * d[1];
	basis.c[2] = SHADE_SH_Y1 * d[2];
	basis.c[3] = -SHADE_SH_Y1 * d[0];
	basis.c[4] = SHADE_SH_Y2 * d[0] * d[1];
	basis.c[5] = -SHADE_SH_Y2 * d[1] * d[2];
	basis.c[6] = SHADE_SH_Y2_0 * (2.0f * d[2] * d[2] - d[0] * d[0] - d[1] * d[1]);
	basis.c[7] = -SHADE_SH_Y2 * d[2] * d[0];
	basis.c[8] = SHADE_SH_Y2_2 * (d[0] * d[0] - d[1] * d[1]);
	return basis;
}

SHADE_FN shade_sh shade_sh_add(shade_sh a, shade_sh b)
{
	shade_sh sum;
	for (int i = 0; i < 9; i++)
		sum.c[i] = a.c[i] + b.c[i];
	return sum;
}

SHADE_FN shade_sh shade_sh_scale(shade_sh a, float factor)
{
	shade_sh scaled;
	for (int i = 0; i < 9; i++)
		scaled.c[i] = a.c[i] * factor;
	return scaled;
}

/* Integral of the product of two functions over all directions: the basis is orthonormal. */
SHADE_FN float shade_sh_dot(shade_sh a, shade_sh b)
{
	float sum = 0.0f;
	for (int i = 0; i < 9; i++)
		sum += a.c[i] * b.c[i];
	return sum;
}

/* The function's value in the direction d. */
SHADE_FN float shade_sh_evaluate(shade_sh f, vec3 d)
{
	return shade_sh_dot(f, shade_sh_basis(d));
}

/* ---- light ------------------------------------------------------------------------------------------------------- */

/* The light that comes from the direction l alone, with the given irradiance across its beam (a sun's). It is also the
 * step of every projection: a piece of surroundings of radiance L and solid angle dw is such a light of irradiance L
 * dw, and their sum the projection (numeric/numeric_sh.h has the loops).
 * Source: maxest, "Projecting Light and Transfer Functions into SH". */
SHADE_FN shade_sh shade_sh_directional(vec3 l, float irradiance)
{
	return shade_sh_scale(shade_sh_basis(l), irradiance);
}

/* Surroundings of the same radiance everywhere: sqrt(4 pi) radiance in the first band. */
SHADE_FN shade_sh shade_sh_ambient(float radiance)
{
	shade_sh f = {{radiance / SHADE_SH_Y0, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f}};
	return f;
}

/* f averaged with a weight that depends only on the angle from each direction: band l is scaled by bands[l], which is
 * the weight's own coefficient of that band times sqrt(4 pi / (2 l + 1)) (Funk and Hecke's theorem). */
SHADE_FN shade_sh shade_sh_convolve(shade_sh f, vec3 bands)
{
	f.c[0] = f.c[0] * bands[0];
	for (int i = 1; i < 4; i++)
		f.c[i] = f.c[i] * bands[1];
	for (int i = 4; i < 9; i++)
		f.c[i] = f.c[i] * bands[2];
	return f;
}

/* The clamped cosine's bands: radiance convolved with it is the irradiance on a surface as a function of the normal.
 * Source: Ramamoorthi and Hanrahan 2001; maxest, A_l (whose general A_1 is printed with sqrt(pi) / 3, read
 * sqrt(pi / 3)). */
#define SHADE_SH_A0 SHADE_PI
#define SHADE_SH_A1 (2.0f / 3.0f * SHADE_PI)
#define SHADE_SH_A2 (0.25f * SHADE_PI)

SHADE_FN shade_sh shade_sh_convolve_cosine(shade_sh radiance)
{
	return shade_sh_convolve(radiance, vec3(SHADE_SH_A0, SHADE_SH_A1, SHADE_SH_A2));
}

/* Irradiance on a surface with the normal n, W m^-2: the product of the surroundings' radiance with the cosine lobe
 * about n. It can be negative (see "Ringing"). Source: maxest, "Final Vertex Color". */
SHADE_FN float shade_sh_irradiance(shade_sh radiance, vec3 n)
{
	return shade_sh_dot(radiance, shade_sh_convolve_cosine(shade_sh_basis(n)));
}

/* Bands of a highlight's lobe cos(angle)^exponent about the mirrored direction, cut off at right angles: radiance
 * convolved with it is what the highlight has on average. The means of Legendre's polynomials over the lobe, whose
 * density (n + 1) / (2 pi) cos^n integrates to 1: of cos it is (n + 1) / (n + 2), of (3 cos^2 - 1) / 2 it is
 * n / (n + 3). exponent >= 0. Source: derived here; Ramamoorthi and Hanrahan, "A Signal-Processing Framework for
 * Inverse Rendering" (SIGGRAPH 2001), for Phong lobes as bands. */
SHADE_FN vec3 shade_sh_lobe(float exponent)
{
	return vec3(1.0f, (exponent + 1.0f) / (exponent + 2.0f), exponent / (exponent + 3.0f));
}

/* ---- windowing --------------------------------------------------------------------------------------------------- */

/* The least blur after which no surroundings have negative irradiance, and after which none have negative radiance. */
#define SHADE_SH_WINDOW_IRRADIANCE 0.0931f
#define SHADE_SH_WINDOW_RADIANCE 0.2751f

/* f blurred by the sphere's heat kernel, band l scaled by exp(-l (l + 1) blur): a narrow light becomes one whose mean
 * cosine is exp(-2 blur). blur >= 0; above 40 only the mean is left.
 * Heat flows from more to less: the mean stays, the least value only rises and the largest only falls, so more blur
 * never brings negative light back. With SHADE_SH_WINDOW_IRRADIANCE a directional light of irradiance 1 gives 0.844
 * facing it, 0.0137 on the back, and where it is least, 40 degrees from there, just more than 0.
 * Source: Bulow, "Spherical Diffusion for 3D Surface Smoothing", IEEE PAMI 26 (2004), for the kernel; Sloan 2008 for
 * windows against ringing. His squared-Laplacian window, 1 / (1 + s l^2 (l + 1)^2), takes so much of band 2 before
 * band 1 that facing the light only 0.584 is left when the back is no longer negative. */
SHADE_FN shade_sh shade_sh_window(shade_sh f, float blur)
{
	return shade_sh_convolve(f, vec3(1.0f, exp(-2.0f * blur), exp(-6.0f * blur)));
}

/* ---- rotation ---------------------------------------------------------------------------------------------------- */

#define SHADE_SH_SQRT3 1.73205080756887729353f

/* f given in the frame's own coordinates, in the world's: what f holds along X, Y, Z is then along frame.t, frame.b,
 * frame.n, which are orthonormal (a left-handed frame mirrors). Exact: band 1 is the product v.d with a vector, band 2
 * is d.(q d) with a symmetric matrix without trace; they turn to R v and R q R^T, R having the columns t, b, n.
 * Source: Ramamoorthi and Hanrahan 2001 for bands 1 and 2 as a matrix. */
SHADE_FN shade_sh shade_sh_rotate(shade_sh f, shade_frame frame)
{
	vec3 x = frame.t;
	vec3 y = frame.b;
	vec3 z = frame.n;
	// v in units of Y1, q in units of Y2_2; Y2_2 = sqrt(3) Y2_0, so Y2_0 (2 zz - xx - yy) has the diagonal -u, -u, 2 u.
	vec3 v = z * f.c[2] - y * f.c[1] - x * f.c[3];
	float u = f.c[6] / SHADE_SH_SQRT3;
	// The columns of R q, then what is needed of those of R q R^T.
	vec3 rq_x = x * (f.c[8] - u) + y * f.c[4] - z * f.c[7];
	vec3 rq_y = x * f.c[4] - y * (f.c[8] + u) - z * f.c[5];
	vec3 rq_z = z * (2.0f * u) - x * f.c[7] - y * f.c[5];
	vec3 q_x = rq_x * x[0] + rq_y * y[0] + rq_z * z[0];
	vec3 q_y = rq_x * x[1] + rq_y * y[1] + rq_z * z[1];
	vec3 q_z = rq_x * x[2] + rq_y * y[2] + rq_z * z[2];
	shade_sh turned = {{f.c[0], -v[1], v[2], -v[0], q_x[1], -q_y[2], 0.5f * SHADE_SH_SQRT3 * q_z[2], -q_x[2],
	                    0.5f * (q_x[0] - q_y[1])}};
	return turned;
}

/* ---- the dominant light ------------------------------------------------------------------------------------------ */

#define SHADE_SH_DIRECTION_MIN 1e-6f /* share of f.c[0]: with less, there is no dominant direction */
#define SHADE_SH_LIGHT_MIN 1e-30f    /* a band 1 below this counts as 0 */

/* Where most of the light comes from: the direction of band 1. +Y where there is none.
 * Source: Sloan 2008, the "optimal linear direction". */
SHADE_FN vec3 shade_sh_dominant_direction(shade_sh f)
{
	vec3 v = vec3(-f.c[3], -f.c[1], f.c[2]);
	float largest = max(max(abs(v[0]), abs(v[1])), abs(v[2]));
	float least = max(SHADE_SH_DIRECTION_MIN * abs(f.c[0]), SHADE_SH_LIGHT_MIN);
	return select(largest > least, normalize(v / largest), vec3(0.0f, 1.0f, 0.0f)); // squares of 1e30 would overflow
}

/* The irradiance of the directional light from d that, with any ambient beside it, comes nearest to f: least squares of
 * the irradiance over all normals, so band l weighs A_l^2; at least 0, and no more than leaves the ambient
 * non-negative. Source: Sloan 2008, on replacing SH light by a directional and an ambient one. */
SHADE_FN float shade_sh_dominant_irradiance(shade_sh f, vec3 d)
{
	shade_sh basis = shade_sh_basis(d);
	float band1 = 0.0f;
	float band2 = 0.0f;
	for (int i = 1; i < 4; i++)
		band1 += f.c[i] * basis.c[i];
	for (int i = 4; i < 9; i++)
		band2 += f.c[i] * basis.c[i];
	float weight1 = SHADE_SH_A1 * SHADE_SH_A1;
	float weight2 = SHADE_SH_A2 * SHADE_SH_A2;
	// For f = basis the sums are 3 / (4 pi) and 5 / (4 pi).
	float irradiance = 4.0f * SHADE_PI * (weight1 * band1 + weight2 * band2) / (3.0f * weight1 + 5.0f * weight2);
	return clamp(irradiance, 0.0f, max(f.c[0], 0.0f) / SHADE_SH_Y0);
}

/* direction points to the light; irradiance across its beam, W m^-2; ambient is a radiance from everywhere. */
SHADE_STRUCT(shade_sh_light)
{
	vec3 direction;
	vec3 irradiance;
	vec3 ambient;
};

/* ---- three channels ---------------------------------------------------------------------------------------------- */

SHADE_FN shade_sh_rgb shade_sh_rgb_add(shade_sh_rgb a, shade_sh_rgb b)
{
	shade_sh_rgb sum = {shade_sh_add(a.r, b.r), shade_sh_add(a.g, b.g), shade_sh_add(a.b, b.b)};
	return sum;
}

/* Three channels at once of shade_sh_directional, and so on for the rest. */
SHADE_FN shade_sh_rgb shade_sh_rgb_directional(vec3 l, vec3 irradiance)
{
	shade_sh basis = shade_sh_basis(l);
	shade_sh_rgb light = {shade_sh_scale(basis, irradiance[0]), shade_sh_scale(basis, irradiance[1]),
	                      shade_sh_scale(basis, irradiance[2])};
	return light;
}

SHADE_FN shade_sh_rgb shade_sh_rgb_ambient(vec3 radiance)
{
	shade_sh_rgb light = {shade_sh_ambient(radiance[0]), shade_sh_ambient(radiance[1]), shade_sh_ambient(radiance[2])};
	return light;
}

SHADE_FN vec3 shade_sh_rgb_evaluate(shade_sh_rgb f, vec3 d)
{
	shade_sh basis = shade_sh_basis(d);
	return vec3(shade_sh_dot(f.r, basis), shade_sh_dot(f.g, basis), shade_sh_dot(f.b, basis));
}

SHADE_FN vec3 shade_sh_rgb_irradiance(shade_sh_rgb radiance, vec3 n)
{
	shade_sh lobe = shade_sh_convolve_cosine(shade_sh_basis(n));
	return vec3(shade_sh_dot(radiance.r, lobe), shade_sh_dot(radiance.g, lobe), shade_sh_dot(radiance.b, lobe));
}

SHADE_FN shade_sh_rgb shade_sh_rgb_window(shade_sh_rgb f, float blur)
{
	shade_sh_rgb windowed = {shade_sh_window(f.r, blur), shade_sh_window(f.g, blur), shade_sh_window(f.b, blur)};
	return windowed;
}

SHADE_FN shade_sh_rgb shade_sh_rgb_rotate(shade_sh_rgb f, shade_frame frame)
{
	shade_sh_rgb turned = {shade_sh_rotate(f.r, frame), shade_sh_rotate(f.g, frame), shade_sh_rotate(f.b, frame)};
	return turned;
}

/* One directional light and an even ambient one for f: the direction is the luminance's, each channel has its own
 * irradiance and ambient. If f is the sum of a directional light and an ambient one, these two come back. */
SHADE_FN shade_sh_light shade_sh_dominant_light(shade_sh_rgb f)
{
	shade_sh luminance;
	for (int i = 0; i < 9; i++)
		luminance.c[i] = shade_luminance(vec3(f.r.c[i], f.g.c[i], f.b.c[i]));
	vec3 d = shade_sh_dominant_direction(luminance);
	vec3 irradiance = vec3(shade_sh_dominant_irradiance(f.r, d), shade_sh_dominant_irradiance(f.g, d),
	                       shade_sh_dominant_irradiance(f.b, d));
	vec3 mean = vec3(f.r.c[0], f.g.c[0], f.b.c[0]) * SHADE_SH_Y0; // radiance averaged over all directions
	shade_sh_light light = {d, irradiance, max(mean - irradiance / (4.0f * SHADE_PI), 0.0f)};
	return light;
}

#include "glsl_end.h"
#endif
