/*
 * numeric_albedo: how much of the light a reflection model reflects, by quadrature in double around the float function.
 *
 * Use.      Two integrals, which are equal for a reciprocal model. `of_view`: radiance towards a view direction under
 *           uniform light of radiance 1 (the white furnace). `of_light`: the share of a beam from one direction that is
 *           reflected into all directions. A model conserves energy where both are at most 1 for every direction and
 *           roughness.
 *
 *   shade_brdf_parameters white = stilb_numeric_white(0.5f, 0.0f);
 *   double seen = stilb_numeric_albedo_of_view(&model, &white, (stilb_numeric_angles){.polar = 1.0});
 *
 * Method.   Integrated over half vectors (halfway between the two directions), in polar coordinates about the normal;
 *           Phong's two lobes over directions, about the mirrored one. There every lobe of shade_brdf.h is as wide as
 *           its alpha, roughness squared. The polar angle is theta with tan(theta) = alpha sinh(t), so that equal steps
 *           of t resolve the core and the tail of the lobe alike, and the horizon is a limit of the azimuth instead of
 *           a kink inside the range. Lambert's and the wrapped model are integrated over directions.
 * Error.    Below 5e-4 of the result for alpha from 1e-3 to 1 and angles up to 89 degrees; largest for Cook-Torrance,
 *           whose G has a kink.
 * Threads.  Pure functions: [any-thread].
 */
#ifndef STILB_NUMERIC_ALBEDO_H
#define STILB_NUMERIC_ALBEDO_H

#include "shading/shade_brdf.h"

/* The fixed direction: polar from the normal, [0, pi/2), and azimuth from the frame's t; radians. */
typedef struct stilb_numeric_angles {
	double polar, azimuth;
} stilb_numeric_angles;

/* Integral of f(l, v) n.l over the light directions l, first channel. roughness in [0, 1]. */
double stilb_numeric_albedo_of_view(const shade_brdf_model *model, const shade_brdf_parameters *parameters,
                                    stilb_numeric_angles view);

/* Integral of f(l, v) n.v over the view directions v, first channel. roughness in [0, 1]. */
double stilb_numeric_albedo_of_light(const shade_brdf_model *model, const shade_brdf_parameters *parameters,
                                     stilb_numeric_angles light);

#endif
