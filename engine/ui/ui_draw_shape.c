/* Shapes whose edges do not run along pixel boundaries: polygons, rounded rectangles, circles, lines.
 *
 * A convex shape is a path: its corners, and for each corner the mitre, the vector by which the corner moves when all
 * edges move outwards by one pixel. Between edges with unit normals n0 and n1 the mitre is (n0 + n1) / (1 + n0.n1): its
 * component along either normal is 1. On an arc it is the direction of the radius. With feathering (ui_draw.h) the path
 * moved inwards by half a pixel is filled, and a ring fades from there to the path moved outwards by half a pixel.
 * Across an edge, alpha is then the share of a pixel square that the shape covers: exactly for edges along pixel
 * boundaries, approximated by a linear ramp for others. */
#include "ui/ui_internal.h"

#include <math.h>
#include <string.h>

#define MITRE_LIMIT 4.0f    /* longest mitre, pixels; sharper corners are cut off */
#define ARC_STEPS_MAX 32    /* chords of a quarter circle */
#define ARC_TOLERANCE 0.02f /* pixels between an arc and its chords at most, if ARC_STEPS_MAX chords suffice for it */
#define PATH_MAX (4 * (ARC_STEPS_MAX + 1))

typedef struct draw_path {
	uint32_t count;
	stilb_ui_point corners[PATH_MAX], mitres[PATH_MAX];
	float shares[PATH_MAX]; /* factor of the alpha at a corner, 0..1: below 1 if its mitre was limited */
} draw_path;

_Static_assert(STILB_UI_MAX_POLYGON <= PATH_MAX, "a polygon is a path");

/* ---- points ------------------------------------------------------------------------------------------------------ */

static stilb_ui_point point_mad(stilb_ui_point a, float scale, stilb_ui_point b)
{
	return (stilb_ui_point){a.x + scale * b.x, a.y + scale * b.y};
}

static float point_dot(stilb_ui_point a, stilb_ui_point b)
{
	return a.x * b.x + a.y * b.y;
}

static float point_cross(stilb_ui_point a, stilb_ui_point b)
{
	return a.x * b.y - a.y * b.x;
}

static float triangle_area(stilb_ui_point a, stilb_ui_point b, stilb_ui_point c)
{
	return 0.5f * point_cross((stilb_ui_point){b.x - a.x, b.y - a.y}, (stilb_ui_point){c.x - a.x, c.y - a.y});
}

/* The unit vector from a to b, (0, 0) if they are equal; *length is their distance. */
static stilb_ui_point point_direction(stilb_ui_point a, stilb_ui_point b, float *length)
{
	stilb_ui_point d = {b.x - a.x, b.y - a.y};
	*length = sqrtf(point_dot(d, d));
	float scale = *length > 0.0f ? 1.0f / *length : 0.0f;
	return (stilb_ui_point){d.x * scale, d.y * scale};
}

/* The normal on the left of the direction as seen on the screen (y down), which points out of a clockwise path. */
static stilb_ui_point point_normal(stilb_ui_point direction)
{
	return (stilb_ui_point){direction.y, -direction.x};
}

/* The mitre of a corner between edges with unit normals n0 and n1, limited in length to MITRE_LIMIT. *share is the
 * factor by which the limit shortened it, and by which alpha is reduced: that near to a sharp corner the shape is
 * thinner than a pixel. */
static stilb_ui_point corner_mitre(stilb_ui_point n0, stilb_ui_point n1, float *share)
{
	stilb_ui_point sum = {n0.x + n1.x, n0.y + n1.y};
	float shrink = 0.5f * point_dot(sum, sum); /* 1 + n0.n1, but exact near 0; the mitre's length is sqrt(2 / shrink) */
	*share = ui_min(MITRE_LIMIT * sqrtf(0.5f * shrink), 1.0f);
	float scale = *share > 0.0f ? *share / shrink : 0.0f;
	return (stilb_ui_point){sum.x * scale, sum.y * scale};
}

/* The simpler vector of STILB_UI_AA_ARTICLE: half the sum of the normals, too short in sharp corners. */
static stilb_ui_point corner_half_sum(stilb_ui_point n0, stilb_ui_point n1, float *share)
{
	*share = 1.0f;
	return (stilb_ui_point){0.5f * (n0.x + n1.x), 0.5f * (n0.y + n1.y)};
}

/* ---- paths ------------------------------------------------------------------------------------------------------- */

/* The area that the path encloses, positive when it runs clockwise on the screen. */
static float path_area(const draw_path *path)
{
	float area = 0.0f;
	/* Triangles from the first corner, not from the origin: shapes far from it would lose digits. */
	for (uint32_t i = 2; i < path->count; i++)
		area += triangle_area(path->corners[0], path->corners[i - 1], path->corners[i]);
	return area;
}

/* The unit normal of the edge that ends at corner i (last) or begins there (not last). */
static stilb_ui_point path_normal(const draw_path *path, uint32_t i, bool last)
{
	STILB_ASSERT(i < path->count);
	uint32_t from = last ? (i + path->count - 1) % path->count : i;
	float length;
	return point_normal(point_direction(path->corners[from], path->corners[(from + 1) % path->count], &length));
}

/* Fills mitres and shares from the corners, by corner_mitre or corner_half_sum. */
static void path_find_mitres(draw_path *path,
                             stilb_ui_point (*corner)(stilb_ui_point n0, stilb_ui_point n1, float *share))
{
	for (uint32_t i = 0; i < path->count; i++)
		path->mitres[i] = corner(path_normal(path, i, true), path_normal(path, i, false), &path->shares[i]);
}

/* How far the path can move inwards until one of its edges has length 0; at most half a pixel. */
static float path_inset_max(const draw_path *path)
{
	float inset = 0.5f;
	for (uint32_t i = 0; i < path->count; i++) {
		uint32_t next = (i + 1) % path->count;
		float length;
		stilb_ui_point along = point_direction(path->corners[i], path->corners[next], &length);
		float shrinks = point_dot(along, path->mitres[next]) - point_dot(along, path->mitres[i]);
		if (length < inset * shrinks)
			inset = length / shrinks;
	}
	return inset;
}

/* The path of a rounded rectangle, clockwise, beginning at the upper end of its top right arc; radius > 0. */
static void path_rounded(draw_path *path, stilb_ui_rect rect, float radius)
{
	STILB_ASSERT(radius > 0.0f);
	stilb_ui_point centers[4] = {{rect.x1 - radius, rect.y0 + radius},
	                             {rect.x1 - radius, rect.y1 - radius},
	                             {rect.x0 + radius, rect.y1 - radius},
	                             {rect.x0 + radius, rect.y0 + radius}};
	/* A chord over the angle t is r (1 - cos(t / 2)), about r t^2 / 8, away from its arc. */
	float angle = sqrtf(8.0f * ARC_TOLERANCE / radius), quarter = 1.57079633f;
	uint32_t steps = (uint32_t)ui_clamp(ceilf(quarter / angle), 2.0f, (float)ARC_STEPS_MAX);
	float c = cosf(quarter / (float)steps), s = sinf(quarter / (float)steps);
	stilb_ui_point normal = {0.0f, -1.0f};
	path->count = 4 * (steps + 1);
	STILB_ASSERT(path->count <= PATH_MAX);
	for (uint32_t i = 0; i <= steps; i++) {
		stilb_ui_point turned = i == steps ? (stilb_ui_point){1.0f, 0.0f} : normal;
		for (uint32_t k = 0; k < 4; k++) {
			path->mitres[k * (steps + 1) + i] = turned;
			path->shares[k * (steps + 1) + i] = 1.0f;
			path->corners[k * (steps + 1) + i] = point_mad(centers[k], radius, turned);
			turned = (stilb_ui_point){-turned.y, turned.x};
		}
		normal = (stilb_ui_point){c * normal.x - s * normal.y, s * normal.x + c * normal.y};
	}
}

/* ---- filling ----------------------------------------------------------------------------------------------------- */

/* Writes the triangles of a convex polygon whose corners are the list's vertices first .. first + count - 1. Returns
 * the end of the indices written. */
static uint32_t *fan_indices(uint32_t *indices, uint32_t first, uint32_t count)
{
	STILB_ASSERT(count >= 3);
	for (uint32_t i = 2; i < count; i++) {
		*indices++ = first;
		*indices++ = first + i - 1;
		*indices++ = first + i;
	}
	return indices;
}

/* Fills the path without antialiasing. */
static void draw_hard(stilb_ui_draw_list *list, const draw_path *path, stilb_ui_color color)
{
	ui_mesh mesh;
	if (!ui_list_add(list, path->count, 3 * (path->count - 2), &mesh))
		return;
	for (uint32_t i = 0; i < path->count; i++)
		mesh.vertices[i] = ui_vertex(path->corners[i].x, path->corners[i].y, color);
	fan_indices(mesh.indices, mesh.first, path->count);
}

/* A ring that fades from the path moved outwards by `inner` to nothing at the path moved by `outer`; if filled, also
 * the inside of the former in full color. False: no memory. */
static bool draw_ring(stilb_ui_draw_list *list, const draw_path *path, float inner, float outer, bool filled,
                      stilb_ui_color color, ui_mesh *mesh)
{
	STILB_ASSERT(inner < outer);
	uint32_t n = path->count;
	if (!ui_list_add(list, 2 * n, 6 * n + (filled ? 3 * (n - 2) : 0), mesh))
		return false;
	stilb_ui_color clear = {color.r, color.g, color.b, 0};
	for (uint32_t i = 0; i < n; i++) {
		stilb_ui_point in = point_mad(path->corners[i], inner, path->mitres[i]);
		stilb_ui_point out = point_mad(path->corners[i], outer, path->mitres[i]);
		mesh->vertices[i] = ui_vertex(in.x, in.y, stilb_ui_fade(color, path->shares[i]));
		mesh->vertices[n + i] = ui_vertex(out.x, out.y, clear);
	}
	uint32_t *indices = filled ? fan_indices(mesh->indices, mesh->first, n) : mesh->indices;
	for (uint32_t i = 0; i < n; i++, indices += 6) {
		uint32_t a = mesh->first + i, b = mesh->first + (i + 1 < n ? i + 1 : 0);
		ui_quad_indices(indices, a, a + n, b + n, b);
	}
	return true;
}

/* The integral of alpha, 0..1, over all triangles of a mesh, in pixels. */
static float mesh_volume(const ui_mesh *mesh, uint32_t index_count)
{
	float volume = 0.0f;
	for (uint32_t i = 0; i < index_count; i += 3) {
		stilb_ui_point points[3];
		float alpha = 0.0f;
		for (uint32_t k = 0; k < 3; k++) {
			const stilb_render_vertex_2d *vertex = &mesh->vertices[mesh->indices[i + k] - mesh->first];
			points[k] = (stilb_ui_point){vertex->position[0], vertex->position[1]};
			alpha += (float)vertex->color[3];
		}
		volume += fabsf(triangle_area(points[0], points[1], points[2])) * alpha / (3.0f * 255.0f);
	}
	return volume;
}

/* Fills a path that is too small to be moved inwards by half a pixel: it is moved by `inset`, and its alpha is reduced
 * until the sum over all pixels is the path's area. */
static void draw_small(stilb_ui_draw_list *list, const draw_path *path, float inset, stilb_ui_color color)
{
	uint32_t n = path->count, index_count = 6 * n + 3 * (n - 2);
	ui_mesh mesh;
	if (!draw_ring(list, path, -inset, 0.5f, true, color, &mesh))
		return;
	float volume = mesh_volume(&mesh, index_count) * 255.0f / (float)(color.a > 0 ? color.a : 1);
	float opacity = volume > 0.0f ? ui_min(path_area(path) / volume, 1.0f) : 0.0f;
	for (uint32_t i = 0; i < n; i++)
		mesh.vertices[i].color[3] = (uint8_t)((float)mesh.vertices[i].color[3] * opacity + 0.5f);
}

/* Fills a clockwise path that has its mitres, as the list's aa says. */
static void draw_path_filled(stilb_ui_draw_list *list, draw_path *path, stilb_ui_color color)
{
	ui_mesh mesh;
	if (list->aa == STILB_UI_AA_OFF) {
		draw_hard(list, path, color);
	} else if (list->aa == STILB_UI_AA_ARTICLE) {
		path_find_mitres(path, corner_half_sum);
		draw_ring(list, path, 0.0f, 1.0f, true, color, &mesh);
	} else {
		float inset = path_inset_max(path);
		if (inset < 0.5f)
			draw_small(list, path, inset, color);
		else
			draw_ring(list, path, -0.5f, 0.5f, true, color, &mesh);
	}
}

void stilb_ui_draw_convex(stilb_ui_draw_list *list, const stilb_ui_point *corners, uint32_t count, stilb_ui_color color)
{
	STILB_ASSERT(corners && count >= 3 && count <= STILB_UI_MAX_POLYGON);
	draw_path path = {.count = count};
	stilb_ui_rect bounds = {corners[0].x, corners[0].y, corners[0].x, corners[0].y};
	for (uint32_t i = 0; i < count; i++) {
		path.corners[i] = corners[i];
		bounds = (stilb_ui_rect){ui_min(bounds.x0, corners[i].x), ui_min(bounds.y0, corners[i].y),
		                         ui_max(bounds.x1, corners[i].x), ui_max(bounds.y1, corners[i].y)};
	}
	float area = path_area(&path);
	if (!(fabsf(area) > 0.0f) ||
	    !ui_list_sees(list, bounds.x0 - 2.0f, bounds.y0 - 2.0f, bounds.x1 + 2.0f, bounds.y1 + 2.0f))
		return;
	for (uint32_t i = 0; area < 0.0f && i < count; i++)
		path.corners[i] = corners[count - 1 - i];
	path_find_mitres(&path, corner_mitre);
	draw_path_filled(list, &path, color);
}

void stilb_ui_draw_triangle(stilb_ui_draw_list *list, stilb_ui_point a, stilb_ui_point b, stilb_ui_point c,
                            stilb_ui_color color)
{
	stilb_ui_point corners[3] = {a, b, c};
	stilb_ui_draw_convex(list, corners, 3, color);
}

/* Clips a rectangle to the clip and `reach` pixels around it: its edges beyond that are invisible, and moving them
 * keeps coordinates small. */
static stilb_ui_rect rect_near_clip(const stilb_ui_draw_list *list, stilb_ui_rect rect, float reach)
{
	return stilb_ui_intersection(rect, stilb_ui_inset(stilb_ui_clip(list), -reach));
}

/* The radius, or half of the rectangle's shorter side if that is less. */
static float rounded_radius(stilb_ui_rect rect, float radius)
{
	return ui_min(radius, 0.5f * ui_min(rect.x1 - rect.x0, rect.y1 - rect.y0));
}

void stilb_ui_draw_rounded(stilb_ui_draw_list *list, stilb_ui_rect rect, float radius, stilb_ui_color color)
{
	radius = rounded_radius(rect, radius);
	if (!(radius > 0.5f)) { /* such a radius is invisible: feathering alone rounds a corner as much */
		stilb_ui_draw_rect(list, rect, color);
		return;
	}
	if (!ui_list_sees(list, rect.x0 - 1.0f, rect.y0 - 1.0f, rect.x1 + 1.0f, rect.y1 + 1.0f))
		return;
	draw_path path;
	path_rounded(&path, rect_near_clip(list, rect, radius + 2.0f), radius);
	draw_path_filled(list, &path, color);
}

void stilb_ui_draw_circle(stilb_ui_draw_list *list, stilb_ui_point center, float radius, stilb_ui_color color)
{
	if (!(radius > 0.0f) || !ui_list_sees(list, center.x - radius - 1.0f, center.y - radius - 1.0f,
	                                      center.x + radius + 1.0f, center.y + radius + 1.0f))
		return;
	draw_path path;
	path_rounded(&path, (stilb_ui_rect){center.x - radius, center.y - radius, center.x + radius, center.y + radius},
	             radius);
	draw_path_filled(list, &path, color);
}

void stilb_ui_draw_shadow(stilb_ui_draw_list *list, stilb_ui_rect rect, float radius, float reach, stilb_ui_color color)
{
	enum { RINGS = 4 }; /* fading rings of growing width, one over the other: their sum falls nearly as a parabola */
	radius = ui_max(rounded_radius(rect, radius), 0.5f);
	if (stilb_ui_is_empty(rect) ||
	    !ui_list_sees(list, rect.x0 - reach, rect.y0 - reach, rect.x1 + reach, rect.y1 + reach))
		return;
	draw_path path;
	ui_mesh mesh;
	path_rounded(&path, rect, radius);
	for (uint32_t ring = 1; ring <= RINGS; ring++)
		draw_ring(list, &path, 0.0f, reach * (float)ring / RINGS, false, stilb_ui_fade(color, 1.0f / RINGS), &mesh);
}

/* ---- lines ------------------------------------------------------------------------------------------------------- */

/* The cross-section of a line: four vertices with the alphas 0, full, full, 0. */
typedef struct line_profile {
	float full; /* half the width of the middle with full alpha, pixels */
	float ring; /* width of the fade from there to alpha 0, pixels */
	stilb_ui_color color;
} line_profile;

/* The share of a pixel that a line of width w covers, over the pixel's distance from the line's middle, is a trapezoid
 * of height min(w, 1), |w - 1| pixels wide at the top and w + 1 at the bottom. */
static line_profile profile_of(const stilb_ui_draw_list *list, float width, stilb_ui_color color)
{
	if (list->aa == STILB_UI_AA_OFF)
		return (line_profile){0.5f * width, 0.0f, color};
	if (list->aa == STILB_UI_AA_ARTICLE)
		return (line_profile){0.5f * width, 1.0f, color};
	float full = 0.5f * fabsf(width - 1.0f);
	return (line_profile){full, 0.5f * (width + 1.0f) - full, stilb_ui_fade(color, width)};
}

/* The four vertices of the line's cross-section at a place. mitre: as of a path (see the top of this file), to one side
 * of the line. */
static void line_vertices(stilb_render_vertex_2d vertices[4], stilb_ui_point place, stilb_ui_point mitre,
                          const line_profile *profile, float opacity)
{
	stilb_ui_color full = stilb_ui_fade(profile->color, opacity), clear = full;
	clear.a = 0;
	float outer = profile->full + profile->ring;
	float offsets[4] = {-outer, -profile->full, profile->full, outer};
	for (uint32_t i = 0; i < 4; i++) {
		stilb_ui_point p = point_mad(place, offsets[i], mitre);
		vertices[i] = ui_vertex(p.x, p.y, i == 0 || i == 3 ? clear : full);
	}
}

/* The three quadrilaterals between two cross-sections, whose first vertices are `from` and `to`. */
static void stretch_indices(uint32_t indices[18], uint32_t from, uint32_t to)
{
	for (uint32_t i = 0; i < 3; i++, indices += 6)
		ui_quad_indices(indices, from + i, to + i, to + i + 1, from + i + 1);
}

/* The part of a line between two cross-sections. */
static void line_stretch(stilb_ui_draw_list *list, const stilb_render_vertex_2d from[4],
                         const stilb_render_vertex_2d to[4])
{
	ui_mesh mesh;
	if (!ui_list_add(list, 8, 18, &mesh))
		return;
	for (uint32_t i = 0; i < 4; i++) {
		mesh.vertices[i] = from[i];
		mesh.vertices[4 + i] = to[i];
	}
	stretch_indices(mesh.indices, mesh.first, mesh.first + 4);
}

/* An end of a line at `place`, from which the line runs along `inwards` for `length` pixels: fades alpha from 0 outside
 * to the cross-section `full` inside, which is returned. */
static void line_cap(stilb_ui_draw_list *list, stilb_ui_point place, stilb_ui_point inwards, stilb_ui_point normal,
                     float length, const line_profile *profile, stilb_render_vertex_2d full[4])
{
	float in = list->aa == STILB_UI_AA_FEATHER ? 0.5f * ui_min(length, 1.0f) : 0.0f;
	float out = list->aa == STILB_UI_AA_FEATHER ? 0.5f : 1.0f;
	line_vertices(full, point_mad(place, in, inwards), normal, profile, 1.0f);
	if (list->aa == STILB_UI_AA_OFF)
		return;
	stilb_render_vertex_2d clear[4];
	line_vertices(clear, point_mad(place, -out, inwards), normal, profile, 0.0f);
	line_stretch(list, clear, full);
}

/* True if a part of the line may be visible: its bounds, with the longest mitres, overlap the clip. */
static bool line_is_seen(const stilb_ui_draw_list *list, const stilb_ui_point *points, uint32_t count, float width)
{
	stilb_ui_rect bounds = {points[0].x, points[0].y, points[0].x, points[0].y};
	for (uint32_t i = 1; i < count; i++)
		bounds = (stilb_ui_rect){ui_min(points[i].x, bounds.x0), ui_min(points[i].y, bounds.y0),
		                         ui_max(points[i].x, bounds.x1), ui_max(points[i].y, bounds.y1)};
	float reach = MITRE_LIMIT * (0.5f * width + 1.0f);
	return ui_list_sees(list, bounds.x0 - reach, bounds.y0 - reach, bounds.x1 + reach, bounds.y1 + reach);
}

/* The normal of the edge that closes a line, from the last point that differs from the first one to the first one. */
static stilb_ui_point closing_normal(const stilb_ui_point *points, uint32_t count)
{
	stilb_ui_point along = {0.0f, 0.0f};
	float length = 0.0f;
	for (uint32_t i = count - 1; i > 0 && !(length > 0.0f); i--)
		along = point_direction(points[i], points[0], &length);
	return point_normal(along);
}

void stilb_ui_draw_polyline(stilb_ui_draw_list *list, const stilb_ui_point *points, uint32_t count, bool closed,
                            float width, stilb_ui_color color)
{
	STILB_ASSERT(points || count == 0);
	if (count < 2 || !(width > 0.0f) || !line_is_seen(list, points, count, width))
		return;
	line_profile profile = profile_of(list, width, color);
	stilb_render_vertex_2d first[4], row[4], next[4];
	stilb_ui_point place = points[0], along = {0.0f, 0.0f}, before = closed ? closing_normal(points, count) : along;
	float length = 0.0f, last_length = 0.0f;
	bool begun = false;
	for (uint32_t i = 1; i < count + closed; i++) {
		stilb_ui_point to = points[i % count], direction = point_direction(place, to, &length);
		if (!(length > 0.0f))
			continue;
		stilb_ui_point normal = point_normal(direction);
		float share;
		if (!begun && !closed)
			line_cap(list, place, direction, normal, length, &profile, next);
		else
			line_vertices(next, place, corner_mitre(before, normal, &share), &profile, 1.0f);
		if (begun)
			line_stretch(list, row, next);
		else
			memcpy(first, next, sizeof first);
		memcpy(row, next, sizeof row);
		begun = true;
		place = to;
		along = direction;
		before = normal;
		last_length = length;
	}
	if (!begun)
		return;
	if (closed)
		memcpy(next, first, sizeof next);
	else
		line_cap(list, place, (stilb_ui_point){-along.x, -along.y}, before, last_length, &profile, next);
	line_stretch(list, row, next);
}

void stilb_ui_draw_line(stilb_ui_draw_list *list, stilb_ui_point a, stilb_ui_point b, float width, stilb_ui_color color)
{
	float half = 0.5f * width;
	stilb_ui_point points[2] = {a, b};
	if (a.x == b.x)
		stilb_ui_draw_rect(list, (stilb_ui_rect){a.x - half, ui_min(a.y, b.y), a.x + half, ui_max(a.y, b.y)}, color);
	else if (a.y == b.y)
		stilb_ui_draw_rect(list, (stilb_ui_rect){ui_min(a.x, b.x), a.y - half, ui_max(a.x, b.x), a.y + half}, color);
	else
		stilb_ui_draw_polyline(list, points, 2, false, width, color);
}

void stilb_ui_draw_arrow(stilb_ui_draw_list *list, stilb_ui_point a, stilb_ui_point b, float width, float head,
                         stilb_ui_color color)
{
	float length;
	stilb_ui_point along = point_direction(a, b, &length), normal = point_normal(along);
	head = ui_min(head, length);
	if (!(head > 0.0f))
		return;
	stilb_ui_point neck = point_mad(b, -head, along);
	stilb_ui_draw_line(list, a, neck, width, color);
	stilb_ui_draw_triangle(list, b, point_mad(neck, 0.5f * head, normal), point_mad(neck, -0.5f * head, normal), color);
}

void stilb_ui_draw_rounded_outline(stilb_ui_draw_list *list, stilb_ui_rect rect, float radius, float width,
                                   stilb_ui_color color)
{
	radius = rounded_radius(rect, radius);
	if (!(radius > 0.5f)) {
		stilb_ui_draw_rect_outline(list, rect, width, color);
		return;
	}
	if (!ui_list_sees(list, rect.x0 - 1.0f, rect.y0 - 1.0f, rect.x1 + 1.0f, rect.y1 + 1.0f))
		return;
	draw_path path;
	float half = 0.5f * width;
	rect = rect_near_clip(list, rect, radius + width + 2.0f);
	path_rounded(&path, stilb_ui_inset(rect, half), ui_max(radius - half, 0.01f));
	line_profile profile = profile_of(list, width, color);
	ui_mesh mesh;
	if (!ui_list_add(list, 4 * path.count, 18 * path.count, &mesh))
		return;
	stilb_render_vertex_2d *vertices = mesh.vertices;
	uint32_t *indices = mesh.indices;
	for (uint32_t i = 0; i < path.count; i++, vertices += 4, indices += 18) {
		uint32_t here = mesh.first + 4 * i, next = mesh.first + 4 * (i + 1 < path.count ? i + 1 : 0);
		line_vertices(vertices, path.corners[i], path.mitres[i], &profile, 1.0f);
		stretch_indices(indices, here, next);
	}
}
