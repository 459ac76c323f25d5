/* What one view's lists are made of. For this folder and its tests. */
#ifndef LIGHT_INTERNAL_H
#define LIGHT_INTERNAL_H

#include "light/light_kernels.h"

#define LIGHT_RELATIVE 0x1p-20 /* bound of the relative errors of float sums of some terms: 16 roundings */

/* The cells of a view. A point that pixel (nx, ny), [-1, 1], shows at the depth z is
 * base + nx base_x + ny base_y + z (ray + nx ray_x + ny ray_y): of a perspective view base_x and base_y are 0, of an
 * orthographic one ray_x and ray_y are. */
typedef struct light_view {
	uint32_t columns, rows, slices;
	double clip[3][4]; /* clip x, y and w of a point (p, 1) */
	double depth[4];   /* its depth */
	double base[3], base_x[3], base_y[3], ray[3], ray_x[3], ray_y[3];
	double growth;  /* of a light's radius by what is added to it for rounding, a share of `reach` + its place */
	double reach;   /* metres: how far the planes are from the origin */
	float along[3]; /* change of clip x, y and w for one metre along the view */
	light_planes column_planes, row_planes;
	float *edge_x, *edge_y; /* [columns + 1], [rows + 1], padded as the planes: nx and ny between them */
	float near_z[STILB_LIGHT_SLICES_MAX], far_z[STILB_LIGHT_SLICES_MAX]; /* of each slice; the last ends at infinity */
	float *memory;
	size_t capacity; /* floats */
} light_view;

/* Fills the view and lists' columns, rows, slices, depth_plane, slice_scale and slice_bias. STILB_ERROR_ARGUMENT,
 * STILB_ERROR_MEMORY. */
stilb_result light_view_make(light_view *view, const stilb_light_grid *grid, stilb_light_lists *lists);

void light_view_finish(light_view *view);

/* A cone of at most half space. */
typedef struct light_cone {
	float apex[3], axis[3]; /* axis: unit */
	float cosine, sine;     /* of the half angle, [0, 1] */
	float slack;            /* metres: what lies so far outside counts as inside */
	bool some;              /* false: there is none */
} light_cone;

/* True if the light may send something to a cell. */
bool light_cone_meets(const light_view *view, const light_cone *cone, uint32_t column, uint32_t row, uint32_t slice);

/* The distance beyond which the light sends no more than `irradiance`, W m^-2, to any point, metres; 0: it does so
 * nowhere. Of a light with a place. */
double light_reach(const stilb_scene_light *light, double irradiance);

/* stilb_light_bounds_of, of a light that reaches no farther than `reach` metres, which may be INFINITY. */
stilb_light_bounds light_bounds_within(const stilb_scene_light *light, double reach);

#endif
