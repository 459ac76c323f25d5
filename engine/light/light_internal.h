/* What one view's lists are made of. For this folder and its tests. */
#ifndef LIGHT_INTERNAL_H
#define LIGHT_INTERNAL_H

#include "light/light_kernels.h"

#include <math.h>

/* Of numbers that are not NaN; fmax and fmin would be calls. */
static inline double light_larger(double a, double b)
{
	return a > b ? a : b;
}

static inline double light_smaller(double a, double b)
{
	return a < b ? a : b;
}

/* The sum of the sizes of a point's coordinates: no less than its distance from the origin. */
static inline double light_size(const float p[3])
{
	return fabs((double)p[0]) + fabs((double)p[1]) + fabs((double)p[2]);
}

#define LIGHT_RELATIVE 0x1p-20 /* bound of the relative errors of float sums of some terms: 16 roundings */

/* Two vectors, as wide as the baseline has them. */
typedef double light_two __attribute__((vector_size(16)));
typedef struct light_four {
	light_two low, high;
} light_four;

/* The cells of a view. */
typedef struct light_view {
	uint32_t columns, rows, slices;
	bool perspective;
	double clip[3][4];       /* clip x, y and w of a point (p, 1) */
	double depth[4];         /* its depth */
	light_four functions[4]; /* clip and depth, by their factors of p[0], p[1], p[2] and 1 */
	light_four sides[4];     /* distances from the four sides, metres, positive inside, likewise */
	double base[3];          /* of rays */
	double growth;  /* sum of the sizes of a plane's two terms, for a point one metre away: rounding grows with it */
	double reach;   /* metres: how far the planes are from the origin */
	float along[3]; /* change of clip x, y and w for one metre along the view */
	light_columns column_planes;
	light_planes row_planes;
	light_rays rays;
	light_depths depths;
	float *memory;
	size_t capacity; /* floats */
} light_view;

/* Fills the view and lists' columns, rows, slices, depth_plane, slice_scale and slice_bias. STILB_ERROR_ARGUMENT,
 * STILB_ERROR_MEMORY. */
stilb_result light_view_make(light_view *view, const stilb_light_grid *grid, stilb_light_lists *lists);

void light_view_finish(light_view *view);

/* The most that the light sends to a surface at this distance from its centre or farther, W m^-2; INFINITY at 0. Of a
 * light with a place. */
double light_irradiance(const stilb_scene_light *light, double distance);

/* The distance beyond which the light sends no more than `irradiance`, W m^-2, to any point, metres; 0: it does so
 * nowhere. Of a light with a place. */
double light_reach(const stilb_scene_light *light, double irradiance);

/* stilb_light_bounds_of, of a light that reaches no farther than `reach` metres, which may be INFINITY. Without a cone,
 * axis and apex stay as they are. */
void light_bounds_within(const stilb_scene_light *light, double reach, stilb_light_bounds *bounds);

#endif
