/* Draws a draw list (ui_draw.h) as a picture without a GPU, to compare with: each triangle of each command, sampled at
 * the centres of pixels, blended in linear light, in double precision; written to be plain, not fast. */
#ifndef TEST_UI_RASTER_H
#define TEST_UI_RASTER_H

#include "support/test.h"
#include "ui/ui_internal.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

typedef struct raster_picture {
	uint32_t width, height;
	double *rgb; /* [height][width][3], linear */
} raster_picture;

static inline double raster_linear(uint8_t code)
{
	double c = code / 255.0;
	return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
}

static inline uint8_t raster_code(double linear)
{
	double c = linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1.0 / 2.4) - 0.055;
	return (uint8_t)(fmin(fmax(c, 0.0), 1.0) * 255.0 + 0.5);
}

static inline raster_picture raster_create(uint32_t width, uint32_t height, stilb_ui_color color)
{
	raster_picture picture = {width, height, calloc((size_t)width * height, 3 * sizeof(double))};
	assert_non_null(picture.rgb);
	for (size_t i = 0; i < (size_t)width * height; i++) {
		picture.rgb[3 * i] = raster_linear(color.r);
		picture.rgb[3 * i + 1] = raster_linear(color.g);
		picture.rgb[3 * i + 2] = raster_linear(color.b);
	}
	return picture;
}

static inline const double *raster_at(const raster_picture *picture, uint32_t x, uint32_t y)
{
	assert_true(x < picture->width && y < picture->height);
	return picture->rgb + 3 * ((size_t)y * picture->width + x);
}

/* Twice the signed area of the triangle of a, b and the point (x, y): positive on one side of the edge from a to b,
 * negative on the other. */
static inline double raster_side(const float a[2], const float b[2], double x, double y)
{
	return ((double)b[0] - (double)a[0]) * (y - (double)a[1]) - ((double)b[1] - (double)a[1]) * (x - (double)a[0]);
}

/* True if the point with this raster_side is on the triangle's side of the edge; a point on the edge belongs to the
 * triangle to the edge's right or below it. */
static inline bool raster_inside(const float a[2], const float b[2], double side)
{
	bool top = a[1] == b[1] && b[0] > a[0], left = b[1] < a[1];
	return side > 0.0 || (side == 0.0 && (top || left));
}

static inline double raster_coverage(const ui_fonts *fonts, double u, double v)
{
	if (!fonts)
		return 1.0;
	uint32_t x = (uint32_t)fmin(fmax(u * fonts->width, 0.0), fonts->width - 1.0);
	uint32_t y = (uint32_t)fmin(fmax(v * fonts->height, 0.0), fonts->height - 1.0);
	return fonts->coverage[(size_t)y * fonts->width + x] / 255.0;
}

static inline void raster_triangle(const raster_picture *picture, const ui_fonts *fonts, const float clip[4],
                                   const stilb_render_vertex_2d *a, const stilb_render_vertex_2d *b,
                                   const stilb_render_vertex_2d *c)
{
	double area = raster_side(a->position, b->position, (double)c->position[0], (double)c->position[1]);
	if (area < 0.0) {
		const stilb_render_vertex_2d *swapped = b;
		b = c;
		c = swapped;
		area = -area;
	}
	if (!(area > 0.0))
		return;
	double x0 = fmin(fmin((double)a->position[0], (double)b->position[0]), (double)c->position[0]);
	double x1 = fmax(fmax((double)a->position[0], (double)b->position[0]), (double)c->position[0]);
	double y0 = fmin(fmin((double)a->position[1], (double)b->position[1]), (double)c->position[1]);
	double y1 = fmax(fmax((double)a->position[1], (double)b->position[1]), (double)c->position[1]);
	x0 = fmax(fmax(x0, (double)clip[0]), 0.0);
	y0 = fmax(fmax(y0, (double)clip[1]), 0.0);
	x1 = fmin(fmin(x1, (double)clip[2]), picture->width);
	y1 = fmin(fmin(y1, (double)clip[3]), picture->height);
	const stilb_render_vertex_2d *corners[3] = {a, b, c};
	for (double y = floor(y0) + 0.5; y <= y1; y++)
		for (double x = floor(x0) + 0.5; x <= x1; x++) {
			double sides[3] = {raster_side(b->position, c->position, x, y), raster_side(c->position, a->position, x, y),
			                   raster_side(a->position, b->position, x, y)};
			if (!raster_inside(b->position, c->position, sides[0]) ||
			    !raster_inside(c->position, a->position, sides[1]) ||
			    !raster_inside(a->position, b->position, sides[2]) || x < (double)clip[0] || x >= (double)clip[2] ||
			    y < (double)clip[1] || y >= (double)clip[3] || x < 0 || y < 0 || x > picture->width ||
			    y > picture->height)
				continue;
			double color[4] = {0}, u = 0.0, v = 0.0;
			for (int i = 0; i < 3; i++) {
				double share = sides[i] / area, alpha = corners[i]->color[3] / 255.0;
				for (int k = 0; k < 3; k++)
					color[k] += share * alpha * raster_linear(corners[i]->color[k]);
				color[3] += share * alpha;
				u += share * (double)corners[i]->uv[0];
				v += share * (double)corners[i]->uv[1];
			}
			double coverage = raster_coverage(fonts, u, v);
			double *pixel = picture->rgb + 3 * ((size_t)y * picture->width + (size_t)x);
			for (int k = 0; k < 3; k++)
				pixel[k] = color[k] * coverage + pixel[k] * (1.0 - color[3] * coverage);
		}
}

/* Draws the list over the picture. fonts: those of the list's text; NULL if it has none. */
static inline void raster_draw(const raster_picture *picture, const stilb_ui_draw_list *list, const ui_fonts *fonts)
{
	assert_false(list->out_of_memory);
	for (uint32_t d = 0; d < list->command_count; d++) {
		const stilb_ui_draw_command *command = &list->commands[d];
		const uint32_t *index = list->indices + command->first_index;
		for (uint32_t i = 0; i < command->index_count; i += 3)
			raster_triangle(picture, fonts, command->clip, &list->vertices[index[i]], &list->vertices[index[i + 1]],
			                &list->vertices[index[i + 2]]);
	}
}

#endif
