/* How a view is cut into cells. */
#include "light/light_internal.h"

#include <math.h>
#include <stdlib.h>

#define SIZE_MAX_PIXELS 16384u
#define TILE_MIN 8u
#define TILE_MAX 1024u
#define PERSPECTIVE_MIN 1e-30 /* a gradient of w below it counts as 0: an orthographic view */

static const char *grid_mistake(const stilb_light_grid *grid)
{
	for (int i = 0; i < 16; i++)
		if (!isfinite(grid->view_projection.m[i]))
			return "view_projection has a number that is not finite";
	if (grid->width < 1 || grid->height < 1 || grid->width > SIZE_MAX_PIXELS || grid->height > SIZE_MAX_PIXELS)
		return "the picture's sides are not 1..16384 pixels";
	if (grid->tile < TILE_MIN || grid->tile > TILE_MAX || (grid->tile & (grid->tile - 1)))
		return "the tile is not a power of 2 from 8 to 1024 pixels";
	if (grid->slices < 1 || grid->slices > STILB_LIGHT_SLICES_MAX)
		return "there are not 1..128 slices";
	if (grid->slices > 1 && !(grid->first > 0.0f && isfinite(grid->first)))
		return "the first slice's end is not above 0";
	if (grid->slices > 2 && !(grid->first < grid->last && isfinite(grid->last)))
		return "the last slice does not begin beyond the first slice's end";
	if (!(grid->tolerance >= 0.0f && isfinite(grid->tolerance)))
		return "the tolerance is negative or not finite";
	if (grid->tolerance > 0.0f && !(grid->peak >= 0.318f && isfinite(grid->peak)))
		return "the peak is below 1 / pi or not finite";
	return NULL;
}

static double dot(const double a[3], const double b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3])
{
	out[0] = a[1] * b[2] - a[2] * b[1];
	out[1] = a[2] * b[0] - a[0] * b[2];
	out[2] = a[0] * b[1] - a[1] * b[0];
}

/* Row `row` of the matrix. */
static void matrix_row(const stilb_mat4 *matrix, int row, double out[4])
{
	for (int column = 0; column < 4; column++)
		out[column] = (double)matrix->m[column * 4 + row];
}

/* Clip coordinates and depth, and back to the world. False: the matrix has no inverse. */
static bool view_space(light_view *view, const stilb_mat4 *matrix)
{
	double z[4], yz[3], zx[3], xy[3];
	matrix_row(matrix, 0, view->clip[0]);
	matrix_row(matrix, 1, view->clip[1]);
	matrix_row(matrix, 2, z);
	double *x = view->clip[0], *y = view->clip[1], *w = view->clip[2];
	matrix_row(matrix, 3, w);
	double scale = sqrt(dot(w, w)), far_w = w[3];
	bool perspective = view->perspective = scale > PERSPECTIVE_MIN;
	if (!perspective) { /* depth 1 of clip space is near */
		scale = -sqrt(dot(z, z));
		if (!(far_w > 0.0) || scale >= 0.0)
			return false;
		for (int i = 0; i < 3; i++)
			w[i] = 0.0;
	}
	double unit = perspective ? scale : far_w; /* clip coordinates are the same for any multiple of x, y and w */
	for (int i = 0; i < 4; i++) {
		x[i] /= unit;
		y[i] /= unit;
		w[i] /= unit;
		z[i] /= unit;
	}
	scale /= unit;
	for (int i = 0; i < 4; i++)
		view->depth[i] = perspective ? w[i] : (z[i] - w[i]) / scale;
	cross(y, view->depth, yz);
	cross(view->depth, x, zx);
	cross(x, y, xy);
	double volume = dot(x, yz);
	if (!(fabs(volume) > 0.0) || !isfinite(1.0 / volume))
		return false;
	double by_ray = perspective ? 1.0 : 0.0, by_base = 1.0 - by_ray;
	for (int i = 0; i < 3; i++) {
		view->base[i] = -(yz[i] * x[3] + zx[i] * y[3] + xy[i] * view->depth[3]) / volume;
		view->rays.ray[i] = (float)(xy[i] / volume);
		view->rays.ray_x[i] = (float)(by_ray * yz[i] / volume);
		view->rays.ray_y[i] = (float)(by_ray * zx[i] / volume);
		view->rays.base_x[i] = (float)(by_base * yz[i] / volume);
		view->rays.base_y[i] = (float)(by_base * zx[i] / volume);
	}
	for (int i = 0; i < 3; i++)
		view->along[i] = (float)dot(view->clip[i], view->depth);
	return true;
}

/* The ndc coordinate at the beginning of a tile; the last one ends with the picture. */
static double edge_of(uint32_t tile_index, uint32_t tile, uint32_t size)
{
	double pixel = fmin((double)tile_index * (double)tile, (double)size);
	return 2.0 * pixel / (double)size - 1.0;
}

/* The planes across one axis of clip space, and what is needed to bound their rounding. False: a plane has no normal.
 * */
static bool view_planes(light_view *view, int axis, uint32_t count, uint32_t tile, uint32_t size)
{
	light_planes *planes = axis == 0 ? &view->column_planes.planes : &view->row_planes;
	float *edges = axis == 0 ? view->rays.edge_x : view->rays.edge_y;
	const double *clip = view->clip[axis], *w = view->clip[2];
	for (uint32_t i = 0; i < count + 1 + LIGHT_LANES; i++) {
		double edge = edge_of(i < count ? i : count, tile, size), normal[3];
		for (int k = 0; k < 3; k++)
			normal[k] = clip[k] - edge * w[k];
		double length = sqrt(dot(normal, normal)), inverse = 1.0 / length;
		if (!(length > 0.0) || !isfinite(inverse))
			return false;
		planes->inverse[i] = (float)inverse;
		planes->offset[i] = (float)(edge * inverse);
		edges[i] = (float)edge;
		if (axis == 1) {
			planes->x[i] = (float)(dot(view->clip[0], normal) * inverse);
			planes->w[i] = (float)(dot(w, normal) * inverse);
		}
		double parts = (sqrt(dot(clip, clip)) + fabs(edge) * sqrt(dot(w, w))) * inverse;
		view->growth = fmax(view->growth, parts);
		view->reach = fmax(view->reach, (fabs(clip[3]) + fabs(edge * w[3])) * inverse);
	}
	return true;
}

/* The functions of lights' places that are found first. */
static void view_functions(light_view *view)
{
	const light_planes *planes[2] = {&view->column_planes.planes, &view->row_planes};
	const uint32_t counts[2] = {view->columns, view->rows};
	for (int k = 0; k < 4; k++) {
		view->functions[k].low = (light_two){view->clip[0][k], view->clip[1][k]};
		view->functions[k].high = (light_two){view->clip[2][k], view->depth[k]};
		for (int axis = 0; axis < 2; axis++) {
			double low = view->clip[axis][k] * (double)planes[axis]->inverse[0];
			double high = view->clip[axis][k] * (double)planes[axis]->inverse[counts[axis]];
			low -= view->clip[2][k] * (double)planes[axis]->offset[0];
			high -= view->clip[2][k] * (double)planes[axis]->offset[counts[axis]];
			*(axis == 0 ? &view->sides[k].low : &view->sides[k].high) = (light_two){low, -high};
		}
	}
}

/* What tangents are found by. */
static void view_tangents(light_view *view, const stilb_light_grid *grid)
{
	const double *x = view->clip[0], *w = view->clip[2];
	double xx = dot(x, x), xw = dot(x, w), ww = dot(w, w), tiles = (double)grid->width / (double)grid->tile;
	light_columns *columns = &view->column_planes;
	columns->count = view->columns;
	columns->xx = (float)xx;
	columns->length = (float)(sqrt(xx) * (1.0 + LIGHT_RELATIVE));
	columns->xw = (float)xw;
	columns->ww = (float)ww;
	columns->area = (float)(xx * ww - xw * xw);
	columns->scale = columns->shift = (float)(0.5 * tiles);
}

/* The depths between which slices lie: a little farther apart than a shader finds, whose log2 has 3 units in the last
 * place. */
static void view_slices(light_view *view, const stilb_light_grid *grid, stilb_light_lists *lists)
{
	double scale = 0.0, bias = 0.0;
	if (view->slices > 1) {
		scale = view->slices == 2 ? 1.0 : (view->slices - 2) / log2((double)grid->last / (double)grid->first);
		bias = 1.0 - log2((double)grid->first) * scale;
	}
	lists->slice_scale = (float)scale;
	lists->slice_bias = (float)bias;
	view->depths.count = view->slices;
	view->depths.near_z[0] = 0.0f;
	for (uint32_t k = 1; k < view->slices; k++) {
		double power = ((double)k - (double)lists->slice_bias) / (double)lists->slice_scale;
		double slip = LIGHT_RELATIVE * (1.0 + fabs(power)) +
		              LIGHT_RELATIVE * ((double)k + fabs((double)lists->slice_bias)) / (double)lists->slice_scale;
		view->depths.near_z[k] = (float)(exp2(power - slip) * (1.0 - LIGHT_RELATIVE));
		view->depths.far_z[k - 1] = (float)(exp2(power + slip) * (1.0 + LIGHT_RELATIVE));
	}
	view->depths.far_z[view->slices - 1] = INFINITY;
}

/* The arrays of the planes. */
static bool view_reserve(light_view *view)
{
	size_t across = view->columns + 1 + LIGHT_LANES, down = view->rows + 1 + LIGHT_LANES;
	size_t floats = 3 * across + 5 * down;
	if (floats > view->capacity) {
		light_view_finish(view);
		view->memory = stilb_memory_alloc(floats, sizeof *view->memory);
		if (!view->memory)
			return false;
		view->capacity = floats;
	}
	float *at = view->memory;
	view->column_planes.planes = (light_planes){.inverse = at, .offset = at + across};
	view->rays.edge_x = at + 2 * across;
	at += 3 * across;
	view->row_planes = (light_planes){.inverse = at, .offset = at + down, .x = at + 2 * down, .w = at + 3 * down};
	view->rays.edge_y = at + 4 * down;
	return true;
}

void light_view_finish(light_view *view)
{
	free(view->memory);
	view->memory = NULL;
	view->capacity = 0;
}

stilb_result light_view_make(light_view *view, const stilb_light_grid *grid, stilb_light_lists *lists)
{
	const char *mistake = grid_mistake(grid);
	if (mistake)
		return stilb_fail(STILB_ERROR_ARGUMENT, "light lists: %s", mistake);
	view->columns = (grid->width + grid->tile - 1) / grid->tile;
	view->rows = (grid->height + grid->tile - 1) / grid->tile;
	view->slices = grid->slices;
	view->growth = 1.0;
	view->reach = 0.0;
	if (!view_reserve(view))
		return stilb_fail(STILB_ERROR_MEMORY, "light lists: no memory for the planes of %u x %u tiles", view->columns,
		                  view->rows);
	if (!view_space(view, &grid->view_projection) || !view_planes(view, 0, view->columns, grid->tile, grid->width) ||
	    !view_planes(view, 1, view->rows, grid->tile, grid->height))
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "light lists: view_projection is no perspective and no orthographic view");
	view_functions(view);
	view_tangents(view, grid);
	view_slices(view, grid, lists);
	view->reach = fmax(view->reach, fabs(view->depth[3]));
	lists->columns = view->columns;
	lists->rows = view->rows;
	lists->slices = view->slices;
	for (int i = 0; i < 4; i++)
		lists->depth_plane[i] = (float)view->depth[i];
	return STILB_OK;
}
