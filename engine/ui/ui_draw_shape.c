/* Shapes with edges that do not run along pixels: polygons, rounded rectangles, circles, lines.
 *
 * A convex shape is a path: corners, and for each the mitre, the way that the corner goes when all edges move outwards
 * by one. For edges with the unit normals n0 and n1 that is (n0 + n1) / (1 + n0.n1): its part along either normal is 1.
 * On an arc it is the radius' direction. Feathered, the path moved inwards by half a pixel is filled, and a ring leads
 * from there, fading, to the path moved outwards by half a pixel. Across an edge the alpha is then what a pixel square
 * over the edge is covered by, exactly where the edge runs along pixels, and as a straight ramp elsewhere. */
#include "ui/ui_internal.h"

#include <math.h>
#include <string.h>

#define MITRE_LIMIT 4.0f    /* how far, in widths, a corner goes at most */
#define ARC_STEPS_MAX 32    /* of a quarter */
#define ARC_TOLERANCE 0.02f /* pixels between an arc and its chords */
#define PATH_MAX (4 * (ARC_STEPS_MAX + 1))

typedef struct draw_path {
	uint32_t count;
	stilb_ui_point corners[PATH_MAX], mitres[PATH_MAX];
	float shares[PATH_MAX]; /* of the alpha that a corner gets: less where the mitre was limited */
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

/* From a to b, one long, and how long it was. */
static stilb_ui_point point_direction(stilb_ui_point a, stilb_ui_point b, float *length)
{
	stilb_ui_point d = {b.x - a.x, b.y - a.y};
	*length = sqrtf(point_dot(d, d));
	float scale = *length > 0.0f ? 1.0f / *length : 0.0f;
	return (stilb_ui_point){d.x * scale, d.y * scale};
}

/* To the left of the direction as seen on the screen (y down): outwards of a path that runs clockwise there. */
static stilb_ui_point point_normal(stilb_ui_point direction)
{
	return (stilb_ui_point){direction.y, -direction.x};
}

/* Where the corner between two edges goes when both move along their unit normals by one. How much of that it may go is
 * *share: inside a sharp corner the shape is that much thinner than a pixel. */
static stilb_ui_point corner_mitre(stilb_ui_point n0, stilb_ui_point n1, float *share)
{
	stilb_ui_point sum = {n0.x + n1.x, n0.y + n1.y};
	float shrink = 0.5f * point_dot(sum, sum); /* 1 + n0.n1, without its rounding; the mitre is sqrt(2 / shrink) long */
	*share = ui_min(MITRE_LIMIT * sqrtf(0.5f * shrink), 1.0f);
	float scale = *share > 0.0f ? *share / shrink : 0.0f;
	return (stilb_ui_point){sum.x * scale, sum.y * scale};
}

/* The article's: half the sum. */
static stilb_ui_point corner_half_sum(stilb_ui_point n0, stilb_ui_point n1, float *share)
{
	*share = 1.0f;
	return (stilb_ui_point){0.5f * (n0.x + n1.x), 0.5f * (n0.y + n1.y)};
}

/* ---- paths ------------------------------------------------------------------------------------------------------- */

/* Positive when the path runs clockwise on the screen. */
static float path_area(const draw_path *path)
{
	float area = 0.0f;
	for (uint32_t i = 2; i < path->count; i++) /* from the first corner, so that places far away lose no digits */
		area += triangle_area(path->corners[0], path->corners[i - 1], path->corners[i]);
	return area;
}

/* The unit normal of the edge that ends (last) or begins at corner i. */
static stilb_ui_point path_normal(const draw_path *path, uint32_t i, bool last)
{
	uint32_t from = last ? (i + path->count - 1) % path->count : i;
	float length;
	return point_normal(point_direction(path->corners[from], path->corners[(from + 1) % path->count], &length));
}

static void path_find_mitres(draw_path *path,
                             stilb_ui_point (*corner)(stilb_ui_point n0, stilb_ui_point n1, float *share))
{
	for (uint32_t i = 0; i < path->count; i++)
		path->mitres[i] = corner(path_normal(path, i, true), path_normal(path, i, false), &path->shares[i]);
}

/* How far inwards the path can move before an edge has no length left, at most half a pixel. */
static float path_room(const draw_path *path)
{
	float room = 0.5f;
	for (uint32_t i = 0; i < path->count; i++) {
		uint32_t next = (i + 1) % path->count;
		float length;
		stilb_ui_point along = point_direction(path->corners[i], path->corners[next], &length);
		float shrinks = point_dot(along, path->mitres[next]) - point_dot(along, path->mitres[i]);
		if (length < room * shrinks)
			room = length / shrinks;
	}
	return room;
}

/* The corners of a rounded rectangle, clockwise from the left end of the top right one; radius 0 < r. */
static void path_rounded(draw_path *path, stilb_ui_rect rect, float radius)
{
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

/* The triangles of a convex polygon whose corners are the list's vertices first on; returns behind the last index. */
static uint32_t *fan_indices(uint32_t *indices, uint32_t first, uint32_t count)
{
	for (uint32_t i = 2; i < count; i++) {
		*indices++ = first;
		*indices++ = first + i - 1;
		*indices++ = first + i;
	}
	return indices;
}

static void draw_hard(stilb_ui_draw_list *list, const draw_path *path, stilb_ui_color color)
{
	ui_mesh mesh;
	if (!ui_list_add(list, path->count, 3 * (path->count - 2), &mesh))
		return;
	for (uint32_t i = 0; i < path->count; i++)
		mesh.vertices[i] = ui_vertex(path->corners[i].x, path->corners[i].y, color);
	fan_indices(mesh.indices, mesh.first, path->count);
}

/* From the path moved outwards by `inner` it fades to nothing where it is moved by `outer`; filled: and the inside is
 * full. */
static bool draw_ring(stilb_ui_draw_list *list, const draw_path *path, float inner, float outer, bool filled,
                      stilb_ui_color color, ui_mesh *mesh)
{
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

/* The alpha over all triangles of a mesh, 0..1 times pixels. */
static float mesh_volume(const ui_mesh *mesh, uint32_t index_count)
{
	float volume = 0.0f;
	for (uint32_t i = 0; i < index_count; i += 3) {
		stilb_ui_point points[3];
		float alpha = 0.0f;
		for (uint32_t k = 0; k < 3; k++) {
			const stilb_render_vertex_2d *vertex = &mesh->vertices[mesh->indices[i + k] - mesh->first];
			points[k] = (stilb_ui_point){vertex->position[0], vertex->position[1]};
			alpha += vertex->color[3];
		}
		volume += fabsf(triangle_area(points[0], points[1], points[2])) * alpha / (3.0f * 255.0f);
	}
	return volume;
}

/* A path that is too small to move inwards by half a pixel moves as far as it can, and gets the alpha with which all
 * adds up to its area. */
static void draw_small(stilb_ui_draw_list *list, const draw_path *path, float room, stilb_ui_color color)
{
	uint32_t n = path->count, index_count = 6 * n + 3 * (n - 2);
	ui_mesh mesh;
	if (!draw_ring(list, path, -room, 0.5f, true, color, &mesh))
		return;
	float volume = mesh_volume(&mesh, index_count) * 255.0f / (float)(color.a > 0 ? color.a : 1);
	float opacity = volume > 0.0f ? ui_min(path_area(path) / volume, 1.0f) : 0.0f;
	for (uint32_t i = 0; i < n; i++)
		mesh.vertices[i].color[3] = (uint8_t)((float)mesh.vertices[i].color[3] * opacity + 0.5f);
}

/* Fills a clockwise path whose mitres are known. */
static void draw_path_filled(stilb_ui_draw_list *list, draw_path *path, stilb_ui_color color)
{
	ui_mesh mesh;
	if (list->aa == STILB_UI_AA_OFF) {
		draw_hard(list, path, color);
	} else if (list->aa == STILB_UI_AA_ARTICLE) {
		path_find_mitres(path, corner_half_sum);
		draw_ring(list, path, 0.0f, 1.0f, true, color, &mesh);
	} else {
		float room = path_room(path);
		if (room < 0.5f)
			draw_small(list, path, room, color);
		else
			draw_ring(list, path, -0.5f, 0.5f, true, color, &mesh);
	}
}

void stilb_ui_draw_convex(stilb_ui_draw_list *list, const stilb_ui_point *corners, uint32_t count, stilb_ui_color color)
{
	STILB_ASSERT(count >= 3 && count <= STILB_UI_MAX_POLYGON);
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

/* What is far outside the clip need not be drawn far outside. */
static stilb_ui_rect rect_near_clip(const stilb_ui_draw_list *list, stilb_ui_rect rect, float reach)
{
	return stilb_ui_intersection(rect, stilb_ui_inset(stilb_ui_clip(list), -reach));
}

static float rounded_radius(stilb_ui_rect rect, float radius)
{
	return ui_min(radius, 0.5f * ui_min(rect.x1 - rect.x0, rect.y1 - rect.y0));
}

void stilb_ui_draw_rounded(stilb_ui_draw_list *list, stilb_ui_rect rect, float radius, stilb_ui_color color)
{
	radius = rounded_radius(rect, radius);
	if (!(radius > 0.5f)) { /* its rounding would be less than what feathering rounds */
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
	enum { RINGS = 4 }; /* their sum falls off as a parabola, nearly */
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

/* Across a line there are four vertices: nothing, full, full, nothing. `ring` leads from the full ones outwards. */
typedef struct line_profile {
	float full, ring; /* half the width that is full, and the way from there to nothing; pixels */
	stilb_ui_color color;
} line_profile;

/* A line of width w blurred over a pixel is a trapezoid: min(w, 1) high, |w - 1| wide on top and w + 1 at its foot. */
static line_profile profile_of(const stilb_ui_draw_list *list, float width, stilb_ui_color color)
{
	if (list->aa == STILB_UI_AA_OFF)
		return (line_profile){0.5f * width, 0.0f, color};
	if (list->aa == STILB_UI_AA_ARTICLE)
		return (line_profile){0.5f * width, 1.0f, color};
	float full = 0.5f * fabsf(width - 1.0f);
	return (line_profile){full, 0.5f * (width + 1.0f) - full, stilb_ui_fade(color, width)};
}

/* The four vertices across at one place; `mitre` as for paths, to one side. */
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

/* The three quadrilaterals between two rows of four vertices. */
static void stretch_indices(uint32_t indices[18], uint32_t from, uint32_t to)
{
	for (uint32_t i = 0; i < 3; i++)
		ui_quad_indices(indices + 6 * i, from + i, to + i, to + i + 1, from + i + 1);
}

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

/* From nothing to a full line, or back: the end at `place`, where the line goes on along `inwards`. Returns the full
 * row. */
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

/* Whether a line through the points can be seen. */
static bool line_is_seen(const stilb_ui_draw_list *list, const stilb_ui_point *points, uint32_t count, float width)
{
	stilb_ui_rect bounds = {points[0].x, points[0].y, points[0].x, points[0].y};
	for (uint32_t i = 1; i < count; i++)
		bounds = (stilb_ui_rect){ui_min(points[i].x, bounds.x0), ui_min(points[i].y, bounds.y0),
		                         ui_max(points[i].x, bounds.x1), ui_max(points[i].y, bounds.y1)};
	float reach = MITRE_LIMIT * (0.5f * width + 1.0f);
	return ui_list_sees(list, bounds.x0 - reach, bounds.y0 - reach, bounds.x1 + reach, bounds.y1 + reach);
}

/* The normal of the edge that closes a line: from its last other point to its first. */
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
	for (uint32_t i = 0; i < path.count; i++) {
		uint32_t here = mesh.first + 4 * i, next = mesh.first + 4 * (i + 1 < path.count ? i + 1 : 0);
		line_vertices(mesh.vertices + 4 * i, path.corners[i], path.mitres[i], &profile, 1.0f);
		stretch_indices(mesh.indices + 18 * i, here, next);
	}
}
