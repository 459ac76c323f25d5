#include "bake/bake_texels.h"

#include "profiler/prof.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Cells whose share of a triangle is smaller are not touched: rounding. */
#define LEAST_SHARE 1e-6

/* ---- polygons ---------------------------------------------------------------------------------------------------- */

#define POLYGON 12 /* corners at most: three, one more for each of four cuts, and again where a cut meets a corner */

typedef struct polygon {
	uint32_t count;
	double at[POLYGON][2];
} polygon;

static void polygon_add(polygon *p, double x, double y)
{
	p->at[p->count][0] = x;
	p->at[p->count++][1] = y;
}

/* Cuts the polygon at at[axis] = value: `below` gets what is less, `above` the rest. Sutherland and Hodgman, "Reentrant
 * Polygon Clipping" (1974). */
static void polygon_cut(const polygon *from, int axis, double value, polygon *below, polygon *above)
{
	below->count = above->count = 0;
	const double *a = from->at[from->count - 1];
	double da = a[axis] - value;
	for (uint32_t i = 0; i < from->count; i++) {
		const double *b = from->at[i];
		double db = b[axis] - value;
		if ((da > 0.0 && db < 0.0) || (da < 0.0 && db > 0.0)) {
			double t = da / (da - db), x = axis == 0 ? value : a[0] + (b[0] - a[0]) * t,
				   y = axis == 1 ? value : a[1] + (b[1] - a[1]) * t;
			polygon_add(below, x, y);
			polygon_add(above, x, y);
		}
		if (db <= 0.0)
			polygon_add(below, b[0], b[1]);
		if (db >= 0.0)
			polygon_add(above, b[0], b[1]);
		a = b;
		da = db;
	}
}

/* The polygon's area; its centroid, if that is > 0. */
static double polygon_area(const polygon *p, double centroid[2])
{
	double area2 = 0.0, x = 0.0, y = 0.0;
	for (uint32_t i = 2; i < p->count; i++) {
		double ax = p->at[i - 1][0] - p->at[0][0], ay = p->at[i - 1][1] - p->at[0][1];
		double bx = p->at[i][0] - p->at[0][0], by = p->at[i][1] - p->at[0][1];
		double part = ax * by - ay * bx;
		area2 += part;
		x += part * (ax + bx);
		y += part * (ay + by);
	}
	if (!(area2 > 0.0))
		return 0.0;
	centroid[0] = p->at[0][0] + x / (3.0 * area2);
	centroid[1] = p->at[0][1] + y / (3.0 * area2);
	return 0.5 * area2;
}

/* Not fmin and fmax, which take care of NaN in calls. */
static double lesser(double a, double b)
{
	return a < b ? a : b;
}

static double greater(double a, double b)
{
	return a > b ? a : b;
}

static void polygon_span(const polygon *p, int axis, double *low, double *high)
{
	*low = HUGE_VAL;
	*high = -HUGE_VAL;
	for (uint32_t i = 0; i < p->count; i++) {
		*low = lesser(*low, p->at[i][axis]);
		*high = greater(*high, p->at[i][axis]);
	}
}

/* ---- one triangle ------------------------------------------------------------------------------------------------ */

/* A triangle in cells, and the barycentric coordinates as functions of the place. */
typedef struct cell_triangle {
	polygon shape;
	double u[3], v[3]; /* constant, along x, along y */
	uint32_t triangle;
} cell_triangle;

typedef struct page_cells {
	stilb_bake_texels *texels;
	uint32_t place;
	uint32_t low[2], high[2]; /* the chart's cells: low <= cell < high */
} page_cells;

static float clamped(double x)
{
	return x > 0.0 ? x < 1.0 ? (float)x : 1.0f : 0.0f;
}

static void cell_offer(const page_cells *cells, const cell_triangle *t, uint32_t x, uint32_t y, double share,
                       const double at[2])
{
	stilb_bake_texels *texels = cells->texels;
	size_t texel = (size_t)(y / 2) * texels->side + x / 2;
	stilb_bake_spot *spot = &texels->spots[texel][2 * (y & 1) + (x & 1)];
	if (!((float)share > spot->share))
		return;
	*spot = (stilb_bake_spot){.triangle = t->triangle,
	                          .u = clamped(t->u[0] + t->u[1] * at[0] + t->u[2] * at[1]),
	                          .v = clamped(t->v[0] + t->v[1] * at[0] + t->v[2] * at[1]),
	                          .share = (float)lesser(share, 1.0)};
	texels->place[texel] = cells->place;
}

/* Cells first .. end - 1 of a row, which the triangle has whole; so no other has anything of them. */
static void row_whole(const page_cells *cells, const cell_triangle *t, uint32_t y, uint32_t first, uint32_t end)
{
	stilb_bake_texels *texels = cells->texels;
	size_t row = (size_t)(y / 2) * texels->side;
	double v0 = t->v[0] + t->v[2] * ((double)y + 0.5), u0 = t->u[0] + t->u[2] * ((double)y + 0.5);
	for (uint32_t x = first; x < end; x++) {
		double at = (double)x + 0.5;
		texels->spots[row + x / 2][2 * (y & 1) + (x & 1)] =
			(stilb_bake_spot){t->triangle, clamped(u0 + t->u[1] * at), clamped(v0 + t->v[1] * at), 1.0f};
	}
	for (uint32_t x = first / 2; x < (end + 1) / 2; x++)
		texels->place[row + x] = cells->place;
}

/* Cells first .. end - 1, of which the triangle has what `rest` has; *rest becomes what is beyond. */
static void row_cut(const page_cells *cells, const cell_triangle *t, polygon *rest, uint32_t y, uint32_t first,
                    uint32_t end)
{
	polygon cell, beyond;
	for (uint32_t x = first; x < end && rest->count > 2; x++) {
		double at[2];
		polygon_cut(rest, 0, (double)x + 1.0, &cell, &beyond);
		double share = cell.count > 2 ? polygon_area(&cell, at) : 0.0;
		if (share > LEAST_SHARE)
			cell_offer(cells, t, x, y, share, at);
		*rest = beyond;
	}
}

/* Where the triangle's sides are at this height: from left to right; false: it does not reach it. */
static bool width_at(const polygon *shape, double y, double *left, double *right)
{
	*left = HUGE_VAL;
	*right = -HUGE_VAL;
	for (uint32_t i = 0; i < 3; i++) {
		const double *a = shape->at[i], *b = shape->at[(i + 1) % 3];
		if ((a[1] > y && b[1] > y) || (a[1] < y && b[1] < y))
			continue;
		double x0 = a[0], x1 = b[0];
		if (a[1] < b[1] || a[1] > b[1])
			x0 = x1 = a[0] + (b[0] - a[0]) * ((y - a[1]) / (b[1] - a[1]));
		*left = lesser(*left, lesser(x0, x1));
		*right = greater(*right, greater(x0, x1));
	}
	return *left <= *right;
}

static uint32_t cell_of(double x, uint32_t low, uint32_t high)
{
	return x > (double)low ? x < (double)high ? (uint32_t)x : high : low;
}

/* Fills the row with what of the triangle is in it. */
static void row_fill(const page_cells *cells, const cell_triangle *t, polygon *band, uint32_t y)
{
	double low, high, left[2], right[2];
	if (band->count < 3)
		return;
	polygon_span(band, 0, &low, &high);
	uint32_t first = cell_of(floor(low), cells->low[0], cells->high[0]);
	uint32_t end = cell_of(ceil(high), cells->low[0], cells->high[0]), whole = first, whole_end = first;
	if (end - first > 2 && width_at(&t->shape, (double)y, &left[0], &right[0]) &&
	    width_at(&t->shape, (double)y + 1.0, &left[1], &right[1])) {
		whole = cell_of(ceil(greater(left[0], left[1])), first, end);
		whole_end = cell_of(floor(lesser(right[0], right[1])), whole, end);
	}
	row_cut(cells, t, band, y, first, whole);
	if (whole_end > whole) {
		polygon before, beyond;
		row_whole(cells, t, y, whole, whole_end);
		polygon_cut(band, 0, (double)whole_end, &before, &beyond);
		*band = beyond;
	}
	row_cut(cells, t, band, y, whole_end, end);
}

/* Fills u and v. False: the triangle has no area on the page. */
static bool triangle_set(cell_triangle *t)
{
	const double *a = t->shape.at[0], *b = t->shape.at[1], *c = t->shape.at[2];
	double area2 = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
	if (!(area2 > 0.0))
		return false;
	t->u[1] = (c[1] - a[1]) / area2;
	t->u[2] = (a[0] - c[0]) / area2;
	t->v[1] = (a[1] - b[1]) / area2;
	t->v[2] = (b[0] - a[0]) / area2;
	t->u[0] = -(t->u[1] * a[0] + t->u[2] * a[1]);
	t->v[0] = -(t->v[1] * a[0] + t->v[2] * a[1]);
	return true;
}

static void triangle_fill(const page_cells *cells, cell_triangle *t)
{
	double low, high;
	if (!triangle_set(t))
		return;
	polygon_span(&t->shape, 1, &low, &high);
	uint32_t first = cell_of(floor(low), cells->low[1], cells->high[1]);
	uint32_t end = cell_of(ceil(high), cells->low[1], cells->high[1]);
	polygon rest = t->shape, band, beyond;
	for (uint32_t y = first; y < end && rest.count > 2; y++) {
		polygon_cut(&rest, 1, (double)y + 1.0, &band, &beyond);
		row_fill(cells, t, &band, y);
		rest = beyond;
	}
}

/* ---- charts ------------------------------------------------------------------------------------------------------ */

/* The charts of a page, for the loop over them. */
typedef struct page_fill {
	const stilb_bake_atlas *atlas;
	stilb_bake_texels *texels;
	uint32_t *list; /* [count] indices of places */
	uint32_t count;
} page_fill;

static void chart_fill(const page_fill *page, uint32_t index)
{
	const stilb_bake_place *place = &page->atlas->places[index];
	const stilb_bake_part *part = &page->atlas->parts[page->texels->part[index]];
	const stilb_bake_uv *uv = &page->atlas->uvs[part->uv];
	const stilb_bake_chart *chart = &uv->charts[index - part->first_place];
	double scale = 2.0 * (double)place->scale, origin[2] = {2.0 * place->x, 2.0 * place->y};
	page_cells cells = {.texels = page->texels, .place = index};
	for (int k = 0; k < 2; k++) {
		double size = (double)(k == 0 ? chart->width : chart->height) * scale;
		cells.low[k] = k == 0 ? 2 * place->x : 2 * place->y;
		cells.high[k] = cells.low[k] + (uint32_t)greater(ceil(size), 1.0);
	}
	for (uint32_t i = 0; i < chart->count; i++) {
		cell_triangle t = {.shape.count = 3, .triangle = uv->triangles[chart->first + i]};
		for (int corner = 0; corner < 3; corner++)
			for (int k = 0; k < 2; k++)
				t.shape.at[corner][k] =
					origin[k] + (double)uv->corners[3 * (size_t)t.triangle + (size_t)corner][k] * scale;
		triangle_fill(&cells, &t);
	}
}

/* stilb_job_range_fn */
static void charts_fill(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	PROFILE("bake.texels");
	for (uint32_t i = begin; i < end; i++)
		chart_fill(context, ((const page_fill *)context)->list[i]);
}

/* stilb_job_range_fn */
static void rows_clear(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	stilb_bake_texels *texels = context;
	size_t first = (size_t)begin * texels->side, count = (size_t)(end - begin) * texels->side;
	(void)worker;
	memset(&texels->spots[first], 0, count * sizeof *texels->spots);
	memset(&texels->place[first], 0xff, count * sizeof *texels->place);
}

static void list_charts(page_fill *page)
{
	const stilb_bake_atlas *atlas = page->atlas;
	for (uint32_t part = 0; part < atlas->part_count; part++) {
		if (atlas->parts[part].uv == STILB_BAKE_NO_CHART)
			continue;
		uint32_t first = atlas->parts[part].first_place, count = atlas->uvs[atlas->parts[part].uv].chart_count;
		for (uint32_t i = first; i < first + count; i++) {
			page->texels->part[i] = part;
			if (atlas->places[i].page == page->texels->page)
				page->list[page->count++] = i;
		}
	}
}

stilb_result stilb_bake_texels_create(const stilb_bake_atlas *atlas, uint32_t page, stilb_job_pool *pool,
                                      stilb_bake_texels **out)
{
	STILB_ASSERT(page < atlas->page_count);
	size_t count = (size_t)atlas->side * atlas->side;
	stilb_bake_texels *texels = calloc(1, sizeof *texels);
	page_fill fill = {.atlas = atlas, .texels = texels};
	*out = NULL;
	fill.list = stilb_memory_alloc(atlas->place_count, sizeof *fill.list);
	if (texels) {
		texels->side = atlas->side;
		texels->page = page;
		texels->spots = stilb_memory_alloc(count, sizeof *texels->spots);
		texels->place = stilb_memory_alloc(count, sizeof *texels->place);
		texels->part = stilb_memory_alloc(atlas->place_count, sizeof *texels->part);
	}
	if (!texels || !fill.list || !texels->spots || !texels->place || !texels->part) {
		free(fill.list);
		stilb_bake_texels_destroy(texels);
		return stilb_fail(STILB_ERROR_MEMORY, "out of memory for a page of %u x %u texels", atlas->side, atlas->side);
	}
	list_charts(&fill);
	stilb_job_parallel_for(pool, atlas->side, 16, rows_clear, texels, 0);
	stilb_job_parallel_for(pool, fill.count, 8, charts_fill, &fill, 0);
	free(fill.list);
	for (size_t i = 0; i < count; i++)
		texels->covered += texels->place[i] != STILB_BAKE_NO_CHART;
	*out = texels;
	return STILB_OK;
}

void stilb_bake_texels_destroy(stilb_bake_texels *texels)
{
	if (!texels)
		return;
	free(texels->spots);
	free(texels->place);
	free(texels->part);
	free(texels);
}
