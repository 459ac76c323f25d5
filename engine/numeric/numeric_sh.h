/*
 * numeric_sh: projects a function of direction, or an environment map, onto nine spherical harmonics. The basis and
 * what is done with the coefficients is in shading/shade_sh.h.
 *
 *   shade_sh_rgb light;
 *   if (stilb_numeric_sh_project_map(&scene->surroundings.panorama, &light) != STILB_OK)
 *       stilb_log("%s", stilb_error_message());
 *
 * Maps.     An environment map is a picture in longitude and latitude: its top row is +Y, the bottom row -Y, the centre
 *           is -Z, the direction of a camera without rotation, and +X is a quarter of the width to the right of the
 *           centre. A value is the radiance of its whole texel, constant, so it is integrated exactly: a finer map of
 *           the same light gives the same coefficients.
 * Threads.  Pure functions: [any-thread].
 */
#ifndef STILB_NUMERIC_SH_H
#define STILB_NUMERIC_SH_H

#include "base/base.h"
#include "image/image.h"
#include "numeric/numeric_quadrature.h"
#include "shading/shade_sh.h"

/* Largest absolute radiance of a texel: products of it stay finite in shading/shade_sh.h. */
#define STILB_NUMERIC_SH_LIMIT 1e30f

/* The unit direction, in world axes, of a place in an environment map: u to the right and v down, [0, 1] each, from the
 * top left corner. */
void stilb_numeric_latlong_direction(double u, double v, double direction[3]);

/* The integral of f(w) Y_i(w) dw for the nine basis functions Y_i, with unit directions w in world axes, by
 * stilb_numeric_integrate_sphere with `panels` >= 1 panels between -Z and +Z. f is called nine times for each
 * direction. Exact to rounding if f is a polynomial of degree 29 at most in each panel. */
shade_sh stilb_numeric_sh_project(stilb_numeric_direction_function *f, const void *context, int panels);

/* The projection of an environment map of linear floats (as .exr and .hdr files load). 1 or 2 channels: grey, the same
 * for red, green and blue; 3 or 4: colour. Alpha is ignored. Errors: STILB_ERROR_ARGUMENT: 8- or 16-bit pictures, and
 * NaN or values beyond STILB_NUMERIC_SH_LIMIT, with their place; STILB_ERROR_MEMORY. Then sh is not written. */
stilb_result stilb_numeric_sh_project_map(const stilb_image *map, shade_sh_rgb *sh);

#endif
