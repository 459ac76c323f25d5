/* One picture of an impostor: the rasteriser, the means of the texels, and the values of texels that nothing covers. */
#include "geometry/geometry_impostor_internal.h"

#include "shading/shade_impostor.h"

#include <string.h>

#define DRAW_UNIT 256 /* steps of a coordinate from one point to the next */

typedef struct draw_picture {
	const impostor_model *model;
	const impostor_canvas *canvas;
	uint32_t points, samples, side; /* points of the picture's side, points of a texel's, texels of the picture's */
	bool both_sides;
	shade_frame frame;
} draw_picture;

/* ---- points ------------------------------------------------------------------------------------------------------ */

static void draw_place_vertices(const draw_picture *picture)
{
	float side = (float)picture->side, scale = (float)(picture->samples * DRAW_UNIT);
	for (uint32_t v = 0; v < picture->model->vertex_count; v++) {
		const float *p = picture->model->vertices[v].position;
		stilb_vec3 local = shade_frame_to_local(picture->frame, stilb_vec3_make(p[0], p[1], p[2]));
		stilb_vec2 texel = shade_impostor_texel((stilb_vec2){local[0], local[1]}, side);
		picture->canvas->places[v] =
			(impostor_place){(int32_t)lrintf(texel[0] * scale), (int32_t)lrintf(texel[1] * scale), local[2]};
	}
}

/* A triangle ready to be drawn: its corners clockwise as the picture's rows go down. */
typedef struct draw_triangle {
	const impostor_place *corner[3];
	uint32_t vertex[3];
	int64_t area; /* twice, in steps squared, > 0 */
	bool front;   /* it faces the viewer */
} draw_triangle;

/* False: no area, or seen from behind where that does not count. */
static bool draw_set_up(const draw_picture *picture, const impostor_triangle *from, draw_triangle *out)
{
	const impostor_place *places = picture->canvas->places;
	const impostor_place *a = &places[from->vertices[0]], *b = &places[from->vertices[1]];
	const impostor_place *c = &places[from->vertices[2]];
	int64_t area = (int64_t)(b->x - a->x) * (c->y - a->y) - (int64_t)(c->x - a->x) * (b->y - a->y);
	bool front = area < 0; /* counter-clockwise where y goes up */
	if (area == 0 || (!front && !picture->both_sides))
		return false;
	uint32_t second = front ? 2 : 1, third = front ? 1 : 2;
	*out = (draw_triangle){
		.corner = {a, front ? c : b, front ? b : c},
		.vertex = {from->vertices[0], from->vertices[second], from->vertices[third]},
		.area = front ? -area : area,
		.front = front,
	};
	return true;
}

/* Twice the area of the triangle of an edge and a point; > 0 inside. */
static int64_t draw_edge(const impostor_place *a, const impostor_place *b, int64_t x, int64_t y)
{
	return (int64_t)(b->x - a->x) * (y - a->y) - (int64_t)(b->y - a->y) * (x - a->x);
}

/* 0 for a left or an upper edge, whose points belong to the triangle, -1 for the others: of two triangles with a common
 * edge one has its points. */
static int64_t draw_edge_bias(const impostor_place *a, const impostor_place *b)
{
	return b->y < a->y || (b->y == a->y && b->x > a->x) ? 0 : -1;
}

/* Weight of each corner at a point, in steps squared; together the area. */
static void draw_weights(const draw_triangle *triangle, uint32_t x, uint32_t y, int64_t weights[3])
{
	int64_t at_x = (int64_t)x * DRAW_UNIT + DRAW_UNIT / 2, at_y = (int64_t)y * DRAW_UNIT + DRAW_UNIT / 2;
	for (int c = 0; c < 3; c++)
		weights[c] = draw_edge(triangle->corner[(c + 1) % 3], triangle->corner[(c + 2) % 3], at_x, at_y);
}

static int32_t draw_least(const impostor_place *const corner[3], bool y)
{
	int32_t a = y ? corner[0]->y : corner[0]->x, b = y ? corner[1]->y : corner[1]->x;
	int32_t c = y ? corner[2]->y : corner[2]->x;
	a = a < b ? a : b;
	return a < c ? a : c;
}

static int32_t draw_most(const impostor_place *const corner[3], bool y)
{
	int32_t a = y ? corner[0]->y : corner[0]->x, b = y ? corner[1]->y : corner[1]->x;
	int32_t c = y ? corner[2]->y : corner[2]->x;
	a = a > b ? a : b;
	return a > c ? a : c;
}

/* The first and one past the last point whose coordinate may lie in the triangle. */
static void draw_range(const draw_triangle *triangle, bool y, uint32_t points, uint32_t *first, uint32_t *end)
{
	int32_t low = draw_least(triangle->corner, y) - DRAW_UNIT / 2,
			high = draw_most(triangle->corner, y) - DRAW_UNIT / 2;
	*first = low <= 0 ? 0 : (uint32_t)(low + DRAW_UNIT - 1) / DRAW_UNIT;
	*end = high < 0 ? 0 : (uint32_t)high / DRAW_UNIT + 1;
	*end = *end < points ? *end : points;
}

/* Keeps triangle number `index` at its points where it is the nearest so far. */
static void draw_points(const draw_picture *picture, const draw_triangle *triangle, uint32_t index)
{
	const impostor_place *const *corner = triangle->corner;
	uint32_t left, right, upper, lower;
	draw_range(triangle, false, picture->points, &left, &right);
	draw_range(triangle, true, picture->points, &upper, &lower);
	if (left >= right || upper >= lower)
		return;
	int64_t bias[3], row[3], across[3], down[3];
	draw_weights(triangle, left, upper, row);
	for (int c = 0; c < 3; c++) {
		const impostor_place *a = corner[(c + 1) % 3], *b = corner[(c + 2) % 3];
		bias[c] = draw_edge_bias(a, b);
		across[c] = -(int64_t)(b->y - a->y) * DRAW_UNIT;
		down[c] = (int64_t)(b->x - a->x) * DRAW_UNIT;
	}
	float share = 1.0f / (float)triangle->area;
	for (uint32_t y = upper; y < lower; y++) {
		int64_t w0 = row[0], w1 = row[1], w2 = row[2];
		size_t at = (size_t)y * picture->points + left;
		for (uint32_t x = left; x < right; x++, at++, w0 += across[0], w1 += across[1], w2 += across[2]) {
			if (((w0 + bias[0]) | (w1 + bias[1]) | (w2 + bias[2])) < 0)
				continue;
			float height =
				((float)w0 * corner[0]->height + (float)w1 * corner[1]->height + (float)w2 * corner[2]->height) * share;
			if (picture->canvas->triangles[at] != 0 && !(height > picture->canvas->heights[at]))
				continue;
			picture->canvas->heights[at] = height;
			picture->canvas->triangles[at] = index + 1;
		}
		for (int c = 0; c < 3; c++)
			row[c] += down[c];
	}
}

/* ---- texels ------------------------------------------------------------------------------------------------------ */

/* Sums over the points of a texel. */
typedef struct draw_sum {
	stilb_vec3 color, normal;
	float height, roughness;
	uint32_t points;
} draw_sum;

/* The corners' normals at a point, on the side of the triangle that is seen. */
static stilb_vec3 draw_normal(const draw_picture *picture, const draw_triangle *triangle, const float share[3])
{
	const impostor_vertex *vertices = picture->model->vertices;
	stilb_vec3 normal = {0}, p[3];
	for (int c = 0; c < 3; c++) {
		const impostor_vertex *v = &vertices[triangle->vertex[c]];
		p[c] = stilb_vec3_make(v->position[0], v->position[1], v->position[2]);
		normal += stilb_vec3_make(v->normal[0], v->normal[1], v->normal[2]) * share[c];
	}
	stilb_vec3 flat = stilb_vec3_cross(p[1] - p[0], p[2] - p[0]); /* the corners are clockwise for the viewer */
	flat = stilb_vec3_dot(flat, picture->frame.n) < 0.0f ? -flat : flat;
	float length2 = stilb_vec3_dot(normal, normal), flat2 = stilb_vec3_dot(flat, flat);
	if (!(length2 > 1e-12f))
		return flat2 > 0.0f ? flat * (1.0f / sqrtf(flat2)) : picture->frame.n;
	normal *= 1.0f / sqrtf(length2);
	return picture->both_sides && stilb_vec3_dot(normal, flat) < 0.0f ? -normal : normal;
}

/* log2 of the texels of a texture between two neighbouring points. */
static float draw_texture_level(const draw_picture *picture, const draw_triangle *triangle,
                                const impostor_texture *texture)
{
	const impostor_vertex *vertices = picture->model->vertices;
	const float *a = vertices[triangle->vertex[0]].uv, *b = vertices[triangle->vertex[1]].uv;
	const float *c = vertices[triangle->vertex[2]].uv;
	float texels = fabsf((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])) * (float)texture->width[0] *
	               (float)texture->height[0];
	float points = (float)triangle->area * (1.0f / (DRAW_UNIT * DRAW_UNIT));
	return texels > points ? 0.5f * log2f(texels / points) : 0.0f;
}

static stilb_vec3 draw_color(const draw_picture *picture, const draw_triangle *triangle, uint32_t part,
                             const float share[3])
{
	const stilb_scene_material *material = picture->model->parts[part].material;
	const impostor_texture *texture = picture->model->textures[part];
	stilb_vec3 color = stilb_vec3_make(material->diffuse[0], material->diffuse[1], material->diffuse[2]);
	if (!texture)
		return color;
	float uv[2] = {0};
	for (int c = 0; c < 3; c++)
		for (int i = 0; i < 2; i++)
			uv[i] += picture->model->vertices[triangle->vertex[c]].uv[i] * share[c];
	return color * geometry_impostor_texture_at(texture, uv, draw_texture_level(picture, triangle, texture));
}

static void draw_add_point(const draw_picture *picture, uint32_t x, uint32_t y, draw_sum *sum)
{
	uint32_t index = picture->canvas->triangles[(size_t)y * picture->points + x];
	if (index == 0)
		return;
	const impostor_triangle *from = &picture->model->triangles[index - 1];
	draw_triangle triangle;
	int64_t weights[3];
	float share[3];
	bool drawn = draw_set_up(picture, from, &triangle);
	STILB_ASSERT(drawn);
	(void)drawn;
	draw_weights(&triangle, x, y, weights);
	for (int c = 0; c < 3; c++)
		share[c] = (float)weights[c] / (float)triangle.area;
	sum->color += draw_color(picture, &triangle, from->part, share);
	sum->normal += draw_normal(picture, &triangle, share);
	sum->height += picture->canvas->heights[(size_t)y * picture->points + x];
	sum->roughness += picture->model->parts[from->part].material->roughness;
	sum->points++;
}

static float draw_clamp(float x, float low, float high)
{
	return x < low ? low : x > high ? high : x;
}

static impostor_texel draw_mean(const draw_picture *picture, const draw_sum *sum)
{
	if (sum->points == 0)
		return (impostor_texel){0};
	float share = 1.0f / (float)sum->points, length2 = stilb_vec3_dot(sum->normal, sum->normal);
	stilb_vec3 normal = length2 > 1e-12f ? sum->normal * (1.0f / sqrtf(length2)) : picture->frame.n;
	stilb_vec2 code = shade_octahedral_from_direction(shade_frame_to_local(picture->frame, normal));
	impostor_texel texel = {
		.coverage = (float)sum->points / (float)(picture->samples * picture->samples),
		.normal = {code[0], code[1]},
		.height = draw_clamp(sum->height * share, -1.0f, 1.0f),
		.roughness = draw_clamp(sum->roughness * share, 0.0f, 1.0f),
		.known = true,
	};
	for (int c = 0; c < 3; c++)
		texel.color[c] = draw_clamp(sum->color[c] * share, 0.0f, picture->model->most[c]);
	return texel;
}

static void draw_texels(const draw_picture *picture)
{
	uint32_t samples = picture->samples;
	for (uint32_t y = 0; y < picture->side; y++)
		for (uint32_t x = 0; x < picture->side; x++) {
			draw_sum sum = {0};
			for (uint32_t i = 0; i < samples * samples; i++)
				draw_add_point(picture, x * samples + i % samples, y * samples + i / samples, &sum);
			picture->canvas->texels[(size_t)y * picture->side + x] = draw_mean(picture, &sum);
		}
}

/* ---- texels that nothing covers ---------------------------------------------------------------------------------- */

/* The mean of the known texels among the eight neighbours, as a known one without coverage; unknown if there are
 * none. */
static impostor_texel draw_neighbours(const impostor_texel *texels, size_t side, size_t x, size_t y)
{
	impostor_texel mean = {0};
	float found = 0.0f;
	for (size_t v = y > 0 ? y - 1 : 0; v <= y + 1 && v < side; v++)
		for (size_t u = x > 0 ? x - 1 : 0; u <= x + 1 && u < side; u++) {
			const impostor_texel *texel = &texels[v * side + u];
			if (!texel->known)
				continue;
			found += 1.0f;
			for (int c = 0; c < 3; c++)
				mean.color[c] += texel->color[c];
			mean.normal[0] += texel->normal[0];
			mean.normal[1] += texel->normal[1];
			mean.height += texel->height;
			mean.roughness += texel->roughness;
		}
	if (found == 0.0f)
		return mean;
	float share = 1.0f / found;
	for (int c = 0; c < 3; c++)
		mean.color[c] *= share;
	mean.normal[0] *= share;
	mean.normal[1] *= share;
	mean.height *= share;
	mean.roughness *= share;
	mean.known = true;
	return mean;
}

/* Gives the texels beside known ones values, again and again until all have some; at most `side` times. An empty
 * picture stays all 0. */
static void draw_spread(const draw_picture *picture)
{
	impostor_texel *texels = picture->canvas->texels, *spread = picture->canvas->spread;
	size_t side = picture->side, count = side * side, missing = count;
	for (size_t pass = 0; pass < side && missing > 0; pass++) {
		missing = 0;
		for (size_t y = 0, i = 0; y < side; y++)
			for (size_t x = 0; x < side; x++, i++) {
				spread[i] = texels[i].known ? texels[i] : draw_neighbours(texels, side, x, y);
				missing += !spread[i].known;
			}
		memcpy(texels, spread, count * sizeof *texels);
		if (missing == count)
			return;
	}
}

/* ---- the maps ---------------------------------------------------------------------------------------------------- */

static void draw_store(const draw_picture *picture, uint32_t grid_x, uint32_t grid_y, const stilb_image *maps)
{
	uint32_t side = picture->side;
	for (uint32_t y = 0; y < side; y++)
		for (uint32_t x = 0; x < side; x++) {
			const impostor_texel *texel = &picture->canvas->texels[(size_t)y * side + x];
			size_t at = 4 * (((size_t)grid_y * side + y) * maps->width + (size_t)grid_x * side + x);
			uint16_t *upper = (uint16_t *)maps->pixels + at;
			uint16_t *lower = upper + 4 * (size_t)maps->width * (maps->height / 2);
			for (int c = 0; c < 3; c++)
				upper[c] = stilb_image_half_from_float(texel->color[c]);
			upper[3] = stilb_image_half_from_float(texel->coverage);
			lower[0] = stilb_image_half_from_float(texel->normal[0]);
			lower[1] = stilb_image_half_from_float(texel->normal[1]);
			lower[2] = stilb_image_half_from_float(texel->height);
			lower[3] = stilb_image_half_from_float(texel->roughness);
		}
}

void geometry_impostor_draw(const impostor_model *model, const stilb_geometry_impostor_desc *desc, uint32_t grid_x,
                            uint32_t grid_y, const impostor_canvas *canvas, const stilb_image *maps)
{
	stilb_vec3 direction = shade_impostor_direction((stilb_vec2){(float)grid_x, (float)grid_y}, (float)desc->grid);
	draw_picture picture = {
		.model = model,
		.canvas = canvas,
		.points = desc->side * desc->samples,
		.samples = desc->samples,
		.side = desc->side,
		.both_sides = desc->both_sides,
		.frame = shade_frame_from_normal(direction),
	};
	draw_triangle triangle;
	memset(canvas->triangles, 0, (size_t)picture.points * picture.points * sizeof *canvas->triangles);
	draw_place_vertices(&picture);
	for (uint32_t t = 0; t < model->triangle_count; t++)
		if (draw_set_up(&picture, &model->triangles[t], &triangle))
			draw_points(&picture, &triangle, t);
	draw_texels(&picture);
	draw_spread(&picture);
	draw_store(&picture, grid_x, grid_y, maps);
}
