/*
 * numeric_sh: the light of a function or of an environment map as spherical harmonics (shading/shade_sh.h). These are the
 * loops; the formulas are there.
 *
 * Maps.     An environment map is a picture of longitude and latitude: its top row is +Y, the bottom row -Y, the middle
 *           -Z (where a camera looks that was not turned), and +X is a quarter of the width to the right of that. Each
 *           value is the radiance of its whole texel, not interpolated, and integrated exactly: more texels add nothing
 *           but time.
 * Threads.  Pure functions: [any-thread].
 */
#ifndef STILB_NUMERIC_SH_H
#define STILB_NUMERIC_SH_H

#include "base/base.h"
#include "image/image.h"
#include "numeric/numeric_quadrature.h"
#include "shading/shade_sh.h"

#define STILB_NUMERIC_SH_LIMIT 1e30f /* highest radiance of a texel, in size: what shading/shade_sh.h is made for */

/* Unit direction, in world axes, of the place u, v of an environment map: u and v in [0, 1], from its top left
 * corner. */
void stilb_numeric_latlong_direction(double u, double v, double direction[3]);

/* The projection of f(direction), unit directions in world axes: the integral of f Y[i] by stilb_numeric_integrate_sphere
 * with `panels` panels between -Z and +Z; f is called nine times for each direction. Exact to rounding where f is a
 * polynomial of degree 29 or less in each panel. */
shade_sh stilb_numeric_sh_project(stilb_numeric_direction_function *f, const void *context, int panels);

/* The projection of an environment map of floats (as .exr files load), with 1 or 2 channels (grey: the same in all
 * three) or 3 or 4; alpha is not looked at. STILB_ERROR_ARGUMENT for 8- and 16-bit pictures and for values that are no
 * numbers or beyond STILB_NUMERIC_SH_LIMIT, STILB_ERROR_MEMORY; then sh stays as it was. */
stilb_result stilb_numeric_sh_project_map(const stilb_image *map, shade_sh_rgb *sh);

#endif
