#include "bake/unwrap/bake_patch.h"

#include <math.h>
#include <stdlib.h>

/* A patch is level if no vertex is farther from its plane than this share of its extent. */
#define LEVEL 1e-5

/* ---- vertices of its own ----------------------------------------------------------------------------------------- */

static uint32_t corner_root(uint32_t *parent, uint32_t corner)
{
	while (parent[corner] != corner) {
		parent[corner] = parent[parent[corner]];
		corner = parent[corner];
	}
	return corner;
}

/* The lower number leads, so that the roots do not depend on the order. */
static void corners_join(uint32_t *parent, uint32_t a, uint32_t b)
{
	a = corner_root(parent, a);
	b = corner_root(parent, b);
	if (a < b)
		parent[b] = a;
	else
		parent[a] = b;
}

/* The half-edge of the patch on the other side; BAKE_NONE: it is the border. */
static uint32_t local_twin(const bake_patch *patch, const uint32_t *chart, const uint32_t *local, uint32_t half_edge)
{
	uint32_t triangle = patch->triangles[half_edge / 3];
	uint32_t twin = patch->topology->twin[3 * triangle + half_edge % 3];
	if (twin == BAKE_NONE || chart[twin / 3] != chart[triangle])
		return BAKE_NONE;
	return 3 * local[twin / 3] + twin % 3;
}

/* Joins corners to vertices, numbers these, and lists the border. */
static void patch_vertices(bake_patch *patch, const uint32_t *chart, const uint32_t *local)
{
	uint32_t corners = 3 * patch->count, *parent = patch->corner;
	for (uint32_t c = 0; c < corners; c++)
		parent[c] = c;
	for (uint32_t h = 0; h < corners; h++) {
		uint32_t twin = local_twin(patch, chart, local, h);
		if (twin == BAKE_NONE || twin < h)
			continue;
		corners_join(parent, h, bake_next(twin));
		corners_join(parent, bake_next(h), twin);
	}
	/* Roots are the lowest corners of their vertices: they come first and get numbers, which others then copy. */
	for (uint32_t c = 0; c < corners; c++)
		parent[c] = corner_root(parent, c);
	for (uint32_t c = 0; c < corners; c++) {
		if (parent[c] != c) {
			parent[c] = parent[parent[c]];
			continue;
		}
		patch->place_of[patch->vertex_count] = 3 * patch->triangles[c / 3] + c % 3;
		parent[c] = patch->vertex_count++;
	}
	for (uint32_t h = 0; h < corners; h++)
		if (local_twin(patch, chart, local, h) == BAKE_NONE) {
			patch->border[patch->border_count][0] = patch->corner[h];
			patch->border[patch->border_count++][1] = patch->corner[bake_next(h)];
		}
}

stilb_result bake_patch_begin(const bake_topology *topology, const uint32_t *triangles, uint32_t count,
                              const uint32_t *chart, uint32_t *local, bake_patch *patch)
{
	STILB_ASSERT(count > 0);
	*patch = (bake_patch){.topology = topology, .triangles = triangles, .count = count};
	patch->corner = stilb_memory_alloc(3 * (size_t)count, sizeof *patch->corner);
	patch->place_of = stilb_memory_alloc(3 * (size_t)count, sizeof *patch->place_of);
	patch->border = stilb_memory_alloc(3 * (size_t)count, sizeof *patch->border);
	patch->at = stilb_memory_alloc(3 * (size_t)count, sizeof *patch->at);
	if (!patch->corner || !patch->place_of || !patch->border || !patch->at) {
		bake_patch_finish(patch);
		return stilb_fail(STILB_ERROR_MEMORY, "out of memory for a chart of %u triangles", count);
	}
	for (uint32_t t = 0; t < count; t++) {
		local[triangles[t]] = t;
		patch->area += topology->area[triangles[t]];
		for (int k = 0; k < 3; k++)
			patch->normal[k] += topology->area[triangles[t]] * topology->normal[triangles[t]][k];
	}
	double *n = patch->normal, length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
	for (int k = 0; k < 3; k++)
		n[k] = length > 0.0 ? n[k] / length : 0.0;
	patch_vertices(patch, chart, local);
	return STILB_OK;
}

void bake_patch_finish(bake_patch *patch)
{
	free(patch->corner);
	free(patch->place_of);
	free(patch->border);
	free(patch->at);
	*patch = (bake_patch){0};
}

/* ---- maps -------------------------------------------------------------------------------------------------------- */

/* Two unit vectors along the plane of the normal, so that x, y and the normal are right-handed. The one along the axis
 * that the normal is farthest from comes out level with it: faces of boxes stay upright. */
static void plane_of(const double n[3], double x[3], double y[3])
{
	int least = 0;
	for (int k = 1; k < 3; k++)
		if (fabs(n[k]) < fabs(n[least]))
			least = k;
	double length = 0.0;
	for (int k = 0; k < 3; k++) {
		x[k] = (k == least ? 1.0 : 0.0) - n[least] * n[k];
		length += x[k] * x[k];
	}
	length = sqrt(length);
	for (int k = 0; k < 3; k++)
		x[k] = length > 0.0 ? x[k] / length : 0.0;
	for (int k = 0; k < 3; k++)
		y[k] = n[(k + 1) % 3] * x[(k + 2) % 3] - n[(k + 2) % 3] * x[(k + 1) % 3];
}

void bake_patch_project(bake_patch *patch)
{
	double x[3], y[3], low = HUGE_VAL, high = -HUGE_VAL, extent = 0.0;
	const double *origin = patch->topology->place[patch->place_of[0]];
	plane_of(patch->normal, x, y);
	for (uint32_t v = 0; v < patch->vertex_count; v++) {
		const double *place = patch->topology->place[patch->place_of[v]];
		double p[3] = {0.0, 0.0, 0.0};
		for (int k = 0; k < 3; k++) {
			double d = place[k] - origin[k];
			p[0] += d * x[k];
			p[1] += d * y[k];
			p[2] += d * patch->normal[k];
			extent = fmax(extent, fabs(d));
		}
		patch->at[v][0] = p[0];
		patch->at[v][1] = p[1];
		low = fmin(low, p[2]);
		high = fmax(high, p[2]);
	}
	patch->level = high - low <= LEVEL * extent;
}

bake_flat bake_patch_flat(const bake_patch *patch, uint32_t triangle)
{
	uint32_t t = patch->triangles[triangle];
	double(*p)[3] = &patch->topology->place[3 * (size_t)t], e1[3], e2[3], square = 0.0, along = 0.0;
	for (int k = 0; k < 3; k++) {
		e1[k] = p[1][k] - p[0][k];
		e2[k] = p[2][k] - p[0][k];
		square += e1[k] * e1[k];
		along += e1[k] * e2[k];
	}
	double length = sqrt(square);
	return (bake_flat){length, along / length, 2.0 * patch->topology->area[t] / length};
}

double bake_patch_stretch(const bake_patch *patch)
{
	double sum = 0.0, map_area = 0.0;
	for (uint32_t t = 0; t < patch->count; t++) {
		const uint32_t *v = &patch->corner[3 * (size_t)t];
		const double *a = patch->at[v[0]], *b = patch->at[v[1]], *c = patch->at[v[2]];
		double area2 = bake_patch_area2(patch, t);
		if (!(area2 > 0.0))
			return HUGE_VAL;
		/* The derivatives of the surface along the map's axes: their squares are a and c of the paper. */
		double(*p)[3] = &patch->topology->place[3 * (size_t)patch->triangles[t]], squares = 0.0;
		for (int k = 0; k < 3; k++) {
			double s = (p[0][k] * (b[1] - c[1]) + p[1][k] * (c[1] - a[1]) + p[2][k] * (a[1] - b[1])) / area2;
			double u = (p[0][k] * (c[0] - b[0]) + p[1][k] * (a[0] - c[0]) + p[2][k] * (b[0] - a[0])) / area2;
			squares += s * s + u * u;
		}
		sum += 0.5 * squares * patch->topology->area[patch->triangles[t]];
		map_area += 0.5 * area2;
	}
	return sum * map_area / patch->area;
}
