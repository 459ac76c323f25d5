/* A view's cells and the lights that reach it, for a compute program. */
#include "light/light_reached.h"

#include "light/light_lists.h"

#include <string.h>

static_assert(sizeof(stilb_light_reached) == 64 && sizeof(stilb_light_cells) == 176, "std430");

uint64_t stilb_light_reached_most(const stilb_light_lists *lists)
{
	const light_reaching *r = &lists->scratch->reaching;
	uint64_t slices = 0;
	for (uint32_t chunk = 0; chunk < r->chunk_count; chunk++)
		for (uint32_t i = chunk * LIGHT_CHUNK; i < chunk * LIGHT_CHUNK + r->chunks[chunk].count; i++)
			slices += r->first_slice[i] <= r->last_slice[i] ? r->last_slice[i] - r->first_slice[i] + 1u : 0;
	return slices * lists->columns * lists->rows;
}

size_t stilb_light_cells_bytes(const stilb_light_lists *lists)
{
	size_t planes = (size_t)(lists->columns + 1) + 3 * (size_t)(lists->rows + 1) + lists->slices;
	return sizeof(stilb_light_cells) + planes * sizeof(float[4]);
}

static void copy3(const float in[3], float out[4])
{
	memcpy(out, in, 3 * sizeof *out);
	out[3] = 0.0f;
}

static void write4(float out[4], float a, float b, float c, float d)
{
	out[0] = a;
	out[1] = b;
	out[2] = c;
	out[3] = d;
}

/* The rows of the unit and the band that a row is in. */
static void write_strips(const light_view *view, uint32_t row, float out[4])
{
	uint32_t bands = light_bands(view), units = light_units(view), band = row / LIGHT_BAND_ROWS, unit = 0;
	while ((unit + 1) * bands / units <= band && unit + 1 < units)
		unit++;
	write4(out, (float)light_band_row(view, unit * bands / units),
	       (float)light_band_row(view, (unit + 1) * bands / units), (float)light_band_row(view, band),
	       (float)light_band_row(view, band + 1));
}

static void write_planes(const light_view *view, float (*out)[4])
{
	const light_planes *columns = &view->column_planes.planes, *rows = &view->row_planes;
	for (uint32_t c = 0; c <= view->columns; c++)
		write4(*out++, columns->inverse[c], columns->offset[c], view->rays.edge_x[c], 0.0f);
	for (uint32_t r = 0; r <= view->rows; r++) {
		write4(*out++, rows->inverse[r], rows->offset[r], view->rays.edge_y[r], 0.0f);
		write4(*out++, rows->x[r], rows->w[r], 0.0f, 0.0f);
		write_strips(view, r, *out++);
	}
	for (uint32_t s = 0; s < view->slices; s++) {
		float near, far;
		light_slab_inverses(view, s, &near, &far);
		write4(*out++, view->depths.near_z[s], view->depths.far_z[s], near, far);
	}
}

void stilb_light_cells_write(const stilb_light_lists *lists, stilb_light_cells *out)
{
	const light_view *view = &lists->scratch->view;
	const light_columns *columns = &view->column_planes;
	*out = (stilb_light_cells){.slice_scale = lists->slice_scale,
	                           .slice_bias = lists->slice_bias,
	                           .columns = lists->columns,
	                           .rows = lists->rows,
	                           .slices = lists->slices,
	                           .light_count = lists->light_count - lists->everywhere_count,
	                           .squares = {columns->xx, columns->xw, columns->ww, columns->area},
	                           .column_scale = {columns->scale, columns->shift, columns->length}};
	memcpy(out->depth_plane, lists->depth_plane, sizeof out->depth_plane);
	copy3(view->along, out->along);
	copy3(view->rays.base_x, out->base_x);
	copy3(view->rays.base_y, out->base_y);
	copy3(view->rays.ray, out->ray);
	copy3(view->rays.ray_x, out->ray_x);
	copy3(view->rays.ray_y, out->ray_y);
	write_planes(view, out->planes);
}

void stilb_light_reached_write(const stilb_light_lists *lists, stilb_light_reached *out)
{
	const light_reaching *r = &lists->scratch->reaching;
	for (uint32_t chunk = 0; chunk < r->chunk_count; chunk++)
		for (uint32_t i = chunk * LIGHT_CHUNK; i < chunk * LIGHT_CHUNK + r->chunks[chunk].count; i++) {
			const light_cone *cone = &r->cones[i];
			uint32_t slices = r->first_slice[i] | (uint32_t)r->last_slice[i] << 8;
			*out = (stilb_light_reached){.radius = r->radius[i], .slices = slices | (uint32_t)cone->some << 16};
			write4(out->place, r->x[i], r->y[i], r->w[i], r->depth[i]);
			if (cone->some) {
				out->cosine = cone->cosine;
				out->sine = cone->sine;
				out->slack = cone->slack;
				memcpy(out->base, cone->base, sizeof out->base);
				memcpy(out->axis, cone->axis, sizeof out->axis);
			}
			out++;
		}
}
