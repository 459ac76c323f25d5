/*
 * numeric_albedo: how much of the light a reflection model gives back, by quadrature in double around the float function.
 *
 * Two questions, which have one answer for a reciprocal model. `of_view`: what does a view direction see where light of
 * radiance 1 comes from everywhere (the white furnace)? `of_light`: which share of a beam from a direction leaves again?
 * A model conserves energy where both are at most 1 for every direction and roughness.
 *
 * Method.   In polar coordinates about the half vectors' pole, the normal, or about the mirrored direction for the two
 *           lobes of Phong: there every lobe of shade_brdf.h has the shape of alpha. The polar angle is
 *           tan(theta) = alpha sinh(t), so that equal steps of t meet the lobe's core and its tail alike, and the horizon
 *           is a limit of the azimuth, not an edge inside the range. The two diffuse kinds go over directions.
 *           The error is below 5e-4 of the answer for alpha from 1e-3 to 1 and angles up to 89 degrees: the larger ones
 *           are Cook-Torrance's, whose G has a kink.
 * Threads.  Pure functions: [any-thread].
 */
#ifndef STILB_NUMERIC_ALBEDO_H
#define STILB_NUMERIC_ALBEDO_H

#include "shading/shade_brdf.h"

/* The fixed direction: radians from the normal, [0, pi/2), and around it from the frame's t. */
typedef struct stilb_numeric_angles {
	double polar, azimuth;
} stilb_numeric_angles;

/* Integral of f(l, v) n.l over the light's directions, of the first channel. */
double stilb_numeric_albedo_of_view(const shade_brdf_model *model, const shade_brdf_parameters *parameters,
                                    stilb_numeric_angles view);

/* Integral of f(l, v) n.v over the view directions, of the first channel. */
double stilb_numeric_albedo_of_light(const shade_brdf_model *model, const shade_brdf_parameters *parameters,
                                     stilb_numeric_angles light);

#endif
