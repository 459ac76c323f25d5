/* ui: shapes as triangles: the positions of their vertices, and their coverage of pixels compared with the exact shapes
 * sampled 64 x 64 times a pixel. */
#include "test_ui_raster.h"

static const stilb_ui_color white = {255, 255, 255, 255};

static stilb_ui_draw_list list_of(stilb_ui_aa aa, float width, float height)
{
	stilb_ui_draw_list list = {.aa = aa};
	stilb_ui_list_begin(&list, width, height);
	return list;
}

/* ---- coverage ---------------------------------------------------------------------------------------------------- */

#define SIDE 48
#define SAMPLES 64

/* A shape: the call that draws it, and the test whether a point is inside. */
typedef struct test_shape {
	const char *name;
	void (*draw)(stilb_ui_draw_list *list);
	bool (*inside)(double x, double y);
	double worst, edge_mean; /* largest errors allowed, see shape_error below */
} test_shape;

/* The errors of a drawn shape: drawn alpha against the share of the pixel that the shape covers, the largest over all
 * pixels and the mean over pixels on its edge. */
typedef struct shape_error {
	double worst, edge_mean, area; /* area: sum of the drawn alpha over the exact area */
} shape_error;

static double reference_coverage(const test_shape *shape, uint32_t x, uint32_t y)
{
	uint32_t inside = 0;
	for (uint32_t j = 0; j < SAMPLES; j++)
		for (uint32_t i = 0; i < SAMPLES; i++)
			inside += shape->inside(x + (i + 0.5) / SAMPLES, y + (j + 0.5) / SAMPLES);
	return (double)inside / (SAMPLES * SAMPLES);
}

static shape_error shape_measure(const test_shape *shape, stilb_ui_aa aa)
{
	stilb_ui_draw_list list = list_of(aa, SIDE, SIDE);
	raster_picture picture = raster_create(SIDE, SIDE, stilb_ui_rgb(0));
	shape_error error = {0};
	double drawn_area = 0.0, true_area = 0.0;
	uint32_t edges = 0;
	shape->draw(&list);
	raster_draw(&picture, &list, NULL);
	for (uint32_t y = 0; y < SIDE; y++)
		for (uint32_t x = 0; x < SIDE; x++) {
			double drawn = raster_at(&picture, x, y)[0], covered = reference_coverage(shape, x, y);
			double off = fabs(drawn - covered);
			bool edge = (covered > 0.0 && covered < 1.0) || (drawn > 0.0 && drawn < 1.0);
			error.worst = fmax(error.worst, off);
			error.edge_mean += edge ? off : 0.0;
			edges += edge;
			drawn_area += drawn;
			true_area += covered;
		}
	error.edge_mean /= edges > 0 ? edges : 1;
	error.area = drawn_area / true_area;
	free(picture.rgb);
	stilb_ui_list_finish(&list);
	return error;
}

static bool in_rounded(double x, double y, double x0, double y0, double x1, double y1, double r)
{
	double dx = fmax(fmax(x0 + r - x, x - (x1 - r)), 0.0), dy = fmax(fmax(y0 + r - y, y - (y1 - r)), 0.0);
	return x >= x0 && x < x1 && y >= y0 && y < y1 && dx * dx + dy * dy <= r * r;
}

/* True if (x, y) is on the line of this width from a to b, which ends squarely. */
static bool in_line(double x, double y, double ax, double ay, double bx, double by, double width)
{
	double length = hypot(bx - ax, by - ay), ux = (bx - ax) / length, uy = (by - ay) / length;
	double along = (x - ax) * ux + (y - ay) * uy, across = (x - ax) * uy - (y - ay) * ux;
	return along >= 0.0 && along <= length && fabs(across) <= 0.5 * width;
}

static bool in_corners(double x, double y, const stilb_ui_point *p, uint32_t count)
{
	for (uint32_t i = 0; i < count; i++) {
		const stilb_ui_point *a = &p[i], *b = &p[(i + 1) % count];
		if (raster_side((const float[2]){a->x, a->y}, (const float[2]){b->x, b->y}, x, y) < 0.0)
			return false;
	}
	return true;
}

static void draw_box(stilb_ui_draw_list *list)
{
	stilb_ui_draw_rounded(list, (stilb_ui_rect){16, 16, 32, 32}, 4.0f, white);
}
static bool in_box(double x, double y)
{
	return in_rounded(x, y, 16, 16, 32, 32, 4);
}

static void draw_button(stilb_ui_draw_list *list)
{
	stilb_ui_draw_rounded(list, (stilb_ui_rect){4, 13, 44, 35}, 11.0f, white);
}
static bool in_button(double x, double y)
{
	return in_rounded(x, y, 4, 13, 44, 35, 11);
}

static void draw_frame(stilb_ui_draw_list *list)
{
	stilb_ui_draw_rounded_outline(list, (stilb_ui_rect){8, 10, 40, 38}, 8.0f, 2.0f, white);
}
static bool in_frame(double x, double y)
{
	return in_rounded(x, y, 8, 10, 40, 38, 8) && !in_rounded(x, y, 10, 12, 38, 36, 6);
}

static void draw_sharp_frame(stilb_ui_draw_list *list)
{
	stilb_ui_draw_rect_outline(list, (stilb_ui_rect){8.3f, 10.4f, 40.2f, 37.6f}, 2.5f, white);
}
static bool in_sharp_frame(double x, double y)
{
	return in_rounded(x, y, 8.3, 10.4, 40.2, 37.6, 0) && !in_rounded(x, y, 10.8, 12.9, 37.7, 35.1, 0);
}

static void draw_disc(stilb_ui_draw_list *list)
{
	stilb_ui_draw_circle(list, (stilb_ui_point){23.7f, 24.2f}, 13.3f, white);
}
static bool in_disc(double x, double y)
{
	return hypot(x - 23.7, y - 24.2) <= 13.3;
}

static void draw_dot(stilb_ui_draw_list *list)
{
	stilb_ui_draw_circle(list, (stilb_ui_point){23.7f, 24.2f}, 0.4f, white);
}
static bool in_dot(double x, double y)
{
	return hypot(x - 23.7, y - 24.2) <= 0.4;
}

static const stilb_ui_point diamond[4] = {{24.0f, 7.0f}, {40.0f, 21.5f}, {25.5f, 37.5f}, {9.5f, 23.0f}};
static void draw_diamond(stilb_ui_draw_list *list)
{
	stilb_ui_draw_convex(list, diamond, 4, white);
}
static bool in_diamond(double x, double y)
{
	return in_corners(x, y, diamond, 4);
}

static const stilb_ui_point triangle[3] = {{12.0f, 10.0f}, {38.0f, 24.0f}, {12.0f, 38.0f}};
static void draw_triangle(stilb_ui_draw_list *list)
{
	stilb_ui_draw_triangle(list, triangle[2], triangle[1], triangle[0], white); /* corners counterclockwise */
}
static bool in_triangle(double x, double y)
{
	return in_corners(x, y, triangle, 3);
}

static const stilb_ui_point needle[3] = {{6.0f, 24.0f}, {42.0f, 26.2f}, {42.0f, 27.0f}};
static void draw_needle(stilb_ui_draw_list *list)
{
	stilb_ui_draw_triangle(list, needle[0], needle[1], needle[2], white);
}
static bool in_needle(double x, double y)
{
	return in_corners(x, y, needle, 3);
}

static void draw_line(stilb_ui_draw_list *list)
{
	stilb_ui_draw_line(list, (stilb_ui_point){8.0f, 12.0f}, (stilb_ui_point){41.0f, 33.5f}, 1.5f, white);
}
static bool in_thick_line(double x, double y)
{
	return in_line(x, y, 8, 12, 41, 33.5, 1.5);
}

static void draw_hair(stilb_ui_draw_list *list)
{
	stilb_ui_draw_line(list, (stilb_ui_point){8.0f, 12.0f}, (stilb_ui_point){41.0f, 33.5f}, 0.3f, white);
}
static bool in_hair(double x, double y)
{
	return in_line(x, y, 8, 12, 41, 33.5, 0.3);
}

static void draw_between(stilb_ui_draw_list *list)
{
	stilb_ui_draw_rect(list, (stilb_ui_rect){10.375f, 12.75f, 33.625f, 30.125f}, white);
}
static bool in_between(double x, double y)
{
	return x >= 10.375 && x < 33.625 && y >= 12.75 && y < 30.125;
}

static void draw_sliver(stilb_ui_draw_list *list)
{
	stilb_ui_draw_rect(list, (stilb_ui_rect){10.875f, 12.5f, 11.125f, 40.0f}, white);
}
static bool in_sliver(double x, double y)
{
	return x >= 10.875 && x < 11.125 && y >= 12.5 && y < 40.0;
}

static const test_shape shapes[] = {
	{"check box", draw_box, in_box, 0.035, 0.015},
	{"rounded button", draw_button, in_button, 0.05, 0.015},
	{"rounded frame", draw_frame, in_frame, 0.065, 0.025},
	{"frame", draw_sharp_frame, in_sharp_frame, 0.1, 0.01},
	{"circle", draw_disc, in_disc, 0.065, 0.015},
	{"dot", draw_dot, in_dot, 0.03, 0.015},
	{"diamond", draw_diamond, in_diamond, 0.26, 0.025}, /* its corners: the lesser of two shares for their product */
	{"triangle", draw_triangle, in_triangle, 0.04, 0.02},
	{"needle", draw_needle, in_needle, 0.27, 0.1},
	{"line 1.5 wide", draw_line, in_thick_line, 0.19, 0.03},
	{"line 0.3 wide", draw_hair, in_hair, 0.085, 0.035},
	{"rectangle", draw_between, in_between, 0.003, 0.002}, /* exact but for the rounding of alpha to 8 bits */
	{"sliver", draw_sliver, in_sliver, 0.003, 0.002},
};
#define SHAPES (sizeof shapes / sizeof *shapes)

static void test_shapes_cover_what_they_should(void **state)
{
	(void)state;
	for (size_t i = 0; i < SHAPES; i++) {
		const test_shape *shape = &shapes[i];
		shape_error error = shape_measure(shape, STILB_UI_AA_FEATHER);
		print_message("%-16s worst %.3f, edge mean %.4f, area %.4f\n", shape->name, error.worst, error.edge_mean,
		              error.area);
		assert_true(error.worst <= shape->worst);
		assert_true(error.edge_mean <= shape->edge_mean);
	}
}

/* The other two kinds of antialiasing have larger errors, and AA_ARTICLE enlarges shapes: the limits above tell the
 * three apart. */
static void test_other_modes_are_worse(void **state)
{
	(void)state;
	for (size_t i = 0; i < SHAPES; i++) {
		shape_error ours = shape_measure(&shapes[i], STILB_UI_AA_FEATHER);
		shape_error article = shape_measure(&shapes[i], STILB_UI_AA_ARTICLE);
		shape_error off = shape_measure(&shapes[i], STILB_UI_AA_OFF);
		assert_true(article.area > 1.015); /* AA_ARTICLE enlarges the shape */
		assert_true(article.edge_mean > 2.5 * ours.edge_mean);
		assert_true(off.edge_mean > 2.5 * ours.edge_mean);
	}
}

/* ---- positions of vertices --------------------------------------------------------------------------------------- */

/* The signed distance of a vertex to the edge from a to b of a clockwise polygon; positive outside. */
static float outside_edge(const stilb_render_vertex_2d *vertex, stilb_ui_point a, stilb_ui_point b)
{
	float length = hypotf(b.x - a.x, b.y - a.y);
	return ((vertex->position[0] - a.x) * (b.y - a.y) - (vertex->position[1] - a.y) * (b.x - a.x)) / length;
}

static void test_ring_is_half_a_pixel_from_every_edge(void **state)
{
	(void)state;
	stilb_ui_draw_list list = list_of(STILB_UI_AA_FEATHER, SIDE, SIDE);
	draw_diamond(&list);
	assert_int_equal(list.vertex_count, 8);
	assert_int_equal(list.index_count, 3 * (2 + 8));
	for (uint32_t i = 0; i < 4; i++) {
		stilb_ui_point before = diamond[(i + 3) % 4], here = diamond[i], after = diamond[(i + 1) % 4];
		assert_float_equal(outside_edge(&list.vertices[i], before, here), -0.5f, 1e-4f);
		assert_float_equal(outside_edge(&list.vertices[i], here, after), -0.5f, 1e-4f);
		assert_float_equal(outside_edge(&list.vertices[4 + i], before, here), 0.5f, 1e-4f);
		assert_float_equal(outside_edge(&list.vertices[4 + i], here, after), 0.5f, 1e-4f);
		assert_int_equal(list.vertices[i].color[3], 255);
		assert_int_equal(list.vertices[4 + i].color[3], 0);
	}
	stilb_ui_list_finish(&list);
}

static void test_article_ring_has_half_the_sum_of_the_normals(void **state)
{
	(void)state;
	stilb_ui_draw_list list = list_of(STILB_UI_AA_ARTICLE, SIDE, SIDE);
	stilb_ui_draw_rect(&list, (stilb_ui_rect){10, 10, 20, 20}, white);
	assert_int_equal(list.vertex_count, 8);
	const float corners[4][2] = {{9.5f, 9.5f}, {20.5f, 9.5f}, {20.5f, 20.5f}, {9.5f, 20.5f}};
	for (uint32_t i = 0; i < 4; i++) {
		assert_float_equal(list.vertices[4 + i].position[0], corners[i][0], 1e-4f);
		assert_float_equal(list.vertices[4 + i].position[1], corners[i][1], 1e-4f);
		assert_true(list.vertices[i].position[0] == 10.0f || list.vertices[i].position[0] == 20.0f);
	}
	stilb_ui_list_finish(&list);
}

static void test_sharp_corners_are_limited(void **state)
{
	(void)state;
	stilb_ui_draw_list list = list_of(STILB_UI_AA_FEATHER, 400, SIDE);
	const stilb_ui_point corners[3] = {{20, 20}, {390, 24}, {390, 28}};
	stilb_ui_draw_convex(&list, corners, 3, white);
	float reach = hypotf(list.vertices[3].position[0] - 20.0f, list.vertices[3].position[1] - 20.0f);
	assert_float_equal(reach, 4.0f * 0.5f, 1e-3f); /* unlimited it would be 0.5 / sin(half the angle), some 90 */
	assert_true(list.vertices[0].color[3] < 20);   /* the tip is much thinner than a pixel */
	stilb_ui_list_finish(&list);
}

static void test_rectangles_on_pixels_are_one_quad(void **state)
{
	(void)state;
	for (int aa = 0; aa < 3; aa += 2) {
		stilb_ui_draw_list list = list_of((stilb_ui_aa)aa, SIDE, SIDE);
		stilb_ui_draw_rect(&list, (stilb_ui_rect){3, 4, 10, 12}, stilb_ui_rgb(0x123456));
		assert_int_equal(list.vertex_count, 4);
		assert_int_equal(list.index_count, 6);
		assert_true(list.vertices[0].position[0] == 3.0f && list.vertices[2].position[1] == 12.0f);
		assert_memory_equal(list.vertices[2].color, ((uint8_t[]){0x12, 0x34, 0x56, 0xff}), 4);
		stilb_ui_list_finish(&list);
	}
}

/* Across a straight line of any width, alpha is the share of each pixel that the line covers, also when the width is
 * below a pixel. */
static void test_lines_keep_their_width(void **state)
{
	(void)state;
	for (float width = 0.25f; width < 4.0f; width += 0.25f) {
		stilb_ui_draw_list list = list_of(STILB_UI_AA_FEATHER, 200, 200);
		const stilb_ui_point ring[5] = {{50, 50}, {150, 50}, {150, 50}, {150, 150}, {50, 150}}; /* one of them twice */
		raster_picture picture = raster_create(200, 200, stilb_ui_rgb(0));
		stilb_ui_draw_polyline(&list, ring, 5, true, width, white);
		raster_draw(&picture, &list, NULL);
		double area = 0.0;
		for (uint32_t i = 0; i < 200 * 200; i++)
			area += picture.rgb[3 * i];
		assert_float_equal((float)(area / (4.0 * 100.0 * (double)width)), 1.0f, 0.01f);
		free(picture.rgb);
		stilb_ui_list_finish(&list);
	}
}

/* ---- clips ------------------------------------------------------------------------------------------------------- */

static void test_clips_nest_and_merge(void **state)
{
	(void)state;
	stilb_ui_draw_list list = list_of(STILB_UI_AA_FEATHER, 100, 80);
	stilb_ui_draw_rect(&list, (stilb_ui_rect){0, 0, 10, 10}, white);
	stilb_ui_clip_push(
		&list, (stilb_ui_rect){10.5f, 20.5f, 90.2f, 200}); /* rounded outwards to pixels, and clipped to the picture */
	stilb_ui_clip_push(&list, (stilb_ui_rect){0, 0, 50, 50});
	stilb_ui_rect clip = stilb_ui_clip(&list);
	assert_true(clip.x0 == 10 && clip.y0 == 20 && clip.x1 == 50 && clip.y1 == 50);
	stilb_ui_draw_rect(&list, (stilb_ui_rect){-1e9f, -1e9f, 1e9f, 1e9f}, white);
	assert_true(list.vertices[4].position[0] == 10 && list.vertices[6].position[1] == 50); /* rectangles are cut here */
	stilb_ui_draw_circle(&list, (stilb_ui_point){60, 30}, 8, white);                       /* outside the clip */
	stilb_ui_draw_rect(&list, (stilb_ui_rect){50, 20, 60, 30}, white);
	stilb_ui_draw_line(&list, (stilb_ui_point){0, 0}, (stilb_ui_point){1, 70}, 1, white);
	assert_int_equal(list.vertex_count, 8);
	stilb_ui_draw_rect(&list, (stilb_ui_rect){20, 20, 21, 21}, white);
	stilb_ui_clip_pop(&list);
	stilb_ui_clip_pop(&list);
	stilb_ui_clip_push(&list, (stilb_ui_rect){0, 0, 100, 80}); /* the whole picture: the clip does not change */
	stilb_ui_draw_rect(&list, (stilb_ui_rect){0, 0, 10, 10}, white);
	stilb_ui_clip_pop(&list);
	stilb_ui_draw_rect(&list, (stilb_ui_rect){0, 0, 10, 10}, white);
	assert_int_equal(list.command_count, 3);
	const uint32_t counts[3] = {6, 12, 12};
	for (uint32_t i = 0, first = 0; i < 3; first += counts[i++]) {
		assert_int_equal(list.commands[i].first_index, first);
		assert_int_equal(list.commands[i].index_count, counts[i]);
	}
	stilb_ui_clip_push(&list, (stilb_ui_rect){30, 30, 20, 20}); /* an empty clip: nothing is drawn */
	stilb_ui_draw_rect(&list, (stilb_ui_rect){0, 0, 100, 100}, white);
	draw_box(&list);
	assert_int_equal(list.command_count, 3);
	stilb_ui_list_finish(&list);
}

static void test_what_is_no_shape_draws_nothing(void **state)
{
	(void)state;
	stilb_ui_draw_list list = list_of(STILB_UI_AA_FEATHER, SIDE, SIDE);
	const stilb_ui_point same[3] = {{5, 5}, {5, 5}, {5, 5}}, flat[3] = {{5, 5}, {10, 10}, {20, 20}};
	const stilb_ui_point lost[3] = {{NAN, 5}, {9, 9}, {20, NAN}};
	stilb_ui_draw_rect(&list, (stilb_ui_rect){10, 10, 10, 20}, white);
	stilb_ui_draw_rect(&list, (stilb_ui_rect){20, 10, 10, 20}, white);
	stilb_ui_draw_rect(&list, (stilb_ui_rect){NAN, 10, 30, 20}, white);
	stilb_ui_draw_rounded(&list, (stilb_ui_rect){20, 10, 10, 20}, 3, white);
	stilb_ui_draw_rounded(&list, (stilb_ui_rect){2, NAN, 10, 20}, 3, white);
	stilb_ui_draw_circle(&list, (stilb_ui_point){20, 20}, 0, white);
	stilb_ui_draw_circle(&list, (stilb_ui_point){20, 20}, NAN, white);
	stilb_ui_draw_convex(&list, flat, 3, white);
	stilb_ui_draw_convex(&list, lost, 3, white);
	stilb_ui_draw_polyline(&list, same, 3, true, 2, white);
	stilb_ui_draw_polyline(&list, flat, 3, false, 0, white);
	stilb_ui_draw_polyline(&list, flat, 1, false, 2, white);
	stilb_ui_draw_polyline(&list, lost, 3, false, 2, white);
	stilb_ui_draw_arrow(&list, same[0], same[1], 1, 8, white);
	assert_int_equal(list.index_count, 0);
	stilb_ui_list_finish(&list);
}

/* ---- memory ------------------------------------------------------------------------------------------------------ */

static uint64_t reallocs;
static bool no_memory;
void *__real_realloc(void *memory, size_t size);
void *__wrap_realloc(void *memory, size_t size);
void *__wrap_realloc(void *memory, size_t size)
{
	reallocs++;
	return no_memory ? NULL : __real_realloc(memory, size);
}

static void draw_everything(stilb_ui_draw_list *list)
{
	for (size_t i = 0; i < SHAPES; i++) {
		stilb_ui_clip_push(list, (stilb_ui_rect){0, 0, SIDE - (float)i, SIDE});
		for (int k = 0; k < 20; k++)
			shapes[i].draw(list);
		stilb_ui_clip_pop(list);
	}
	stilb_ui_draw_shadow(list, (stilb_ui_rect){10, 10, 20, 20}, 3, 5, white);
}

static void test_steady_frames_allocate_nothing(void **state)
{
	(void)state;
	stilb_ui_draw_list list = list_of(STILB_UI_AA_FEATHER, SIDE, SIDE);
	draw_everything(&list);
	uint64_t before = reallocs;
	uint32_t vertices = list.vertex_count;
	for (int frame = 0; frame < 3; frame++) {
		stilb_ui_list_begin(&list, SIDE, SIDE);
		draw_everything(&list);
	}
	assert_int_equal(list.vertex_count, vertices);
	assert_int_equal(reallocs, before);
	stilb_ui_list_finish(&list);
}

static void test_without_memory_shapes_are_left_out(void **state)
{
	(void)state;
	stilb_ui_draw_list list = list_of(STILB_UI_AA_FEATHER, SIDE, SIDE);
	no_memory = true;
	draw_everything(&list);
	no_memory = false;
	assert_true(list.out_of_memory);
	assert_int_equal(list.index_count, 0);
	stilb_ui_list_begin(&list, SIDE, SIDE);
	draw_everything(&list);
	assert_false(list.out_of_memory);
	assert_true(list.index_count > 0);
	stilb_ui_list_finish(&list);
	stilb_ui_list_finish(NULL);
}

/* ---- colours ----------------------------------------------------------------------------------------------------- */

static double contrast(stilb_ui_color a, stilb_ui_color b)
{
	double l[2];
	const stilb_ui_color colors[2] = {a, b};
	for (int i = 0; i < 2; i++)
		l[i] = 0.2126 * raster_linear(colors[i].r) + 0.7152 * raster_linear(colors[i].g) +
		       0.0722 * raster_linear(colors[i].b) + 0.05;
	return fmax(l[0], l[1]) / fmin(l[0], l[1]);
}

static void test_colors(void **state)
{
	(void)state;
	assert_int_equal(stilb_ui_fade(white, 0.5f).a, 128);
	assert_int_equal(stilb_ui_fade(white, 7.0f).a, 255);
	assert_int_equal(stilb_ui_fade(white, -1.0f).a, 0);
	stilb_ui_color mixed = stilb_ui_mix(stilb_ui_rgb(0x204060), stilb_ui_rgb(0x406080), 0.5f);
	assert_memory_equal(&mixed, ((uint8_t[]){0x30, 0x50, 0x70, 0xff}), 4);
	for (uint32_t rgb = 0; rgb < 1u << 24; rgb += 0x0305) { /* the chosen one has the higher contrast, up to rounding */
		stilb_ui_color back = stilb_ui_rgb(rgb), text = stilb_ui_text_color_on(back);
		double other = contrast(back, stilb_ui_rgb(text.r ? 0x000000 : 0xffffff));
		assert_true(contrast(back, text) >= 0.96 * other);
		assert_true(contrast(back, text) >= 4.4); /* nearly the 4.5 that WCAG's level AA demands */
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_shapes_cover_what_they_should),
		cmocka_unit_test(test_other_modes_are_worse),
		cmocka_unit_test(test_ring_is_half_a_pixel_from_every_edge),
		cmocka_unit_test(test_article_ring_has_half_the_sum_of_the_normals),
		cmocka_unit_test(test_sharp_corners_are_limited),
		cmocka_unit_test(test_rectangles_on_pixels_are_one_quad),
		cmocka_unit_test(test_lines_keep_their_width),
		cmocka_unit_test(test_clips_nest_and_merge),
		cmocka_unit_test(test_what_is_no_shape_draws_nothing),
		cmocka_unit_test(test_steady_frames_allocate_nothing),
		cmocka_unit_test(test_without_memory_shapes_are_left_out),
		cmocka_unit_test(test_colors),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
