/* ui on the GPU: the recorded draws are those of the draw list; edges of a check box and of a rounded button are near
 * to the share of each pixel that they cover.
 *
 * With STILB_UI_EDGES=FILE.png it also writes the picture of docs/ui.md: controls and shapes without antialiasing, with
 * the article's ring and with the default, each with its check box enlarged eight times. */
#include "support/picture_reference.h"
#include "test_ui_raster.h"

#include <stdio.h>

#define SAMPLES 64

/* ---- a screen on the GPU ----------------------------------------------------------------------------------------- */

typedef struct screen {
	stilb_render *render;
	stilb_ui *ui;
	uint32_t width, height;
} screen;

static screen screen_open(uint32_t width, uint32_t height, stilb_render_output output)
{
	screen s = {.width = width, .height = height};
	stilb_render_desc desc = {
		.output = output, .width = width, .height = height, .samples = 1, .context_count = 1, .validate = true};
	if (stilb_render_create(&desc, &s.render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_ui_desc ui_desc = stilb_ui_desc_default();
	ui_desc.render = s.render;
	if (stilb_ui_create(&ui_desc, &s.ui) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return s;
}

static void screen_begin(screen *s)
{
	stilb_ui_input input = {.width = (float)s->width, .height = (float)s->height};
	assert_int_equal(stilb_render_frame_begin(s->render), STILB_OK);
	stilb_ui_begin(s->ui, &input);
}

static stilb_image screen_end(screen *s)
{
	stilb_render_pass pass = {.name = "ui", .kind = STILB_RENDER_PASS_2D};
	stilb_image image = {0};
	stilb_ui_end(s->ui);
	assert_int_equal(stilb_ui_record(s->ui, 0, 0), STILB_OK);
	assert_int_equal(stilb_render_replay(s->render, &pass, 1, NULL, 0, NULL, 0), STILB_OK);
	if (stilb_render_read_image(s->render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(image.channels, 3);
	return image;
}

static void screen_close(screen *s)
{
	stilb_ui_destroy(s->ui);
	assert_int_equal(stilb_render_wait(s->render), STILB_OK);
	assert_int_equal(stilb_render_validation_messages(s->render), 0);
	stilb_render_destroy(s->render);
}

/* ---- what is recorded is what is drawn --------------------------------------------------------------------------- */

static void draw_some_of_everything(stilb_ui *ui)
{
	static stilb_ui_list_state rows_state = {.selected = 1};
	stilb_ui_draw_list *list = stilb_ui_list(ui);
	const float values[5] = {1, 3, 2, 5, 4};
	bool on = true;
	float value = 3.0f;
	stilb_ui_draw_rect(list, (stilb_ui_rect){0, 0, 400, 240}, stilb_ui_rgb(0x405060));
	stilb_ui_rect panel = {6, 6, 390, 230};
	stilb_ui_rect area = stilb_ui_panel_begin(ui, "Panel", &panel, STILB_UI_PANEL_RESIZABLE, &on);
	stilb_ui_rect bar = stilb_ui_cut_top(&area, 24);
	stilb_ui_button_rounded(ui, stilb_ui_cut_left(&bar, 90), "Capture");
	stilb_ui_toggle(ui, stilb_ui_cut_left(&bar, 90), "Freeze", &on);
	stilb_ui_checkbox(ui, stilb_ui_cut_left(&bar, 120), "on spike \xe2\x86\x92 \xc2\xb5s", &on);
	stilb_ui_slider(ui, stilb_ui_cut_top(&area, 24), "budget", &value, &(stilb_ui_slider_range){.maximum = 9.0f});
	stilb_ui_plot(ui, stilb_ui_cut_top(&area, 50), "ms", values, 5, 0, 6);
	stilb_ui_rows rows = stilb_ui_rows_begin(ui, area, "rows", 30, &rows_state);
	for (uint32_t row = rows.first; row < rows.end; row++)
		stilb_ui_label(ui, stilb_ui_row(ui, &rows, row), STILB_UI_ALIGN_RIGHT, "wait for workers");
	stilb_ui_rows_end(ui);
	stilb_ui_panel_end(ui);
	stilb_ui_draw_arrow(list, (stilb_ui_point){300, 215}, (stilb_ui_point){350, 160}, 1.5f, 9, stilb_ui_rgb(0xff9040));
}

static void test_the_gpu_draws_the_list(void **state)
{
	(void)state;
	screen s = screen_open(400, 240, STILB_RENDER_OUTPUT_DISPLAY);
	for (int aa = STILB_UI_AA_FEATHER; aa <= STILB_UI_AA_OFF; aa++) {
		stilb_ui_aa_set(s.ui, (stilb_ui_aa)aa);
		screen_begin(&s);
		draw_some_of_everything(s.ui);
		stilb_image image = screen_end(&s);
		raster_picture picture = raster_create(400, 240, stilb_ui_rgb(0));
		raster_draw(&picture, stilb_ui_list(s.ui), &s.ui->fonts);
		uint32_t off = 0;
		for (uint32_t i = 0; i < 400 * 240 * 3; i++)
			/* Up to 4 codes of difference: blending in an 8-bit target rounds after each layer. */
			off += abs(((const uint8_t *)image.pixels)[i] - raster_code(picture.rgb[i])) > 4;
		assert_true(off < 60); /* pixels whose centre is on an edge belong to either side */
		free(picture.rgb);
		stilb_image_finish(&image);
	}
	screen_close(&s);
}

static void test_an_empty_list_is_an_empty_pass(void **state)
{
	(void)state;
	screen s = screen_open(16, 16, STILB_RENDER_OUTPUT_DISPLAY);
	screen_begin(&s);
	stilb_image image = screen_end(&s);
	assert_int_equal(stilb_render_stats_get(s.render).draws, 0);
	for (uint32_t i = 0; i < 16 * 16 * 3; i++)
		assert_int_equal(((const uint8_t *)image.pixels)[i], 0);
	stilb_image_finish(&image);
	screen_close(&s);
}

/* ---- edges ------------------------------------------------------------------------------------------------------- */

static bool in_rounded(double x, double y, double x0, double y0, double x1, double y1, double r)
{
	double dx = fmax(fmax(x0 + r - x, x - (x1 - r)), 0.0), dy = fmax(fmax(y0 + r - y, y - (y1 - r)), 0.0);
	return x >= x0 && x < x1 && y >= y0 && y < y1 && dx * dx + dy * dy <= r * r;
}

/* A white widget on black, and the rounded rectangle that it is. */
typedef struct edge_case {
	const char *name;
	void (*draw)(stilb_ui *ui);
	double x0, y0, x1, y1, radius;
	/* Mean error on the edge: at most [0] with feathering, at least [1] with AA_ARTICLE, [2] without smoothing. */
	double limits[3];
} edge_case;

static void white_box(stilb_ui *ui)
{
	bool on = false;
	stilb_ui_checkbox(ui, (stilb_ui_rect){8, 5, 24, 27}, "##box", &on);
}

static void white_button(stilb_ui *ui)
{
	stilb_ui_button_rounded(ui, (stilb_ui_rect){4, 4, 60, 26}, "##button");
}

static double coverage_of(const edge_case *edge, uint32_t x, uint32_t y)
{
	uint32_t inside = 0;
	for (uint32_t j = 0; j < SAMPLES; j++)
		for (uint32_t i = 0; i < SAMPLES; i++)
			inside += in_rounded(x + (i + 0.5) / SAMPLES, y + (j + 0.5) / SAMPLES, edge->x0, edge->y0, edge->x1,
			                     edge->y1, edge->radius);
	return (double)inside / (SAMPLES * SAMPLES);
}

/* The mean error over the pixels that the shape covers in part, or that are drawn so. */
static double edge_error(screen *s, const edge_case *edge, stilb_ui_aa aa, double *worst)
{
	stilb_ui_style *style = stilb_ui_style_get(s->ui);
	style->control = style->control_border = stilb_ui_rgb(0xffffff);
	stilb_ui_aa_set(s->ui, aa);
	screen_begin(s);
	edge->draw(s->ui);
	stilb_image image = screen_end(s);
	double sum = 0.0;
	uint32_t edges = 0;
	*worst = 0.0;
	for (uint32_t y = 0; y < s->height; y++)
		for (uint32_t x = 0; x < s->width; x++) {
			uint16_t half = ((const uint16_t *)image.pixels)[3 * (y * s->width + x)];
			double drawn = reference_half(half), covered = coverage_of(edge, x, y), off = fabs(drawn - covered);
			bool partly = (covered > 0.0 && covered < 1.0) || (drawn > 0.0 && drawn < 1.0);
			sum += partly ? off : 0.0;
			edges += partly;
			*worst = fmax(*worst, off);
		}
	stilb_image_finish(&image);
	return sum / edges;
}

static void test_edges_against_coverage(void **state)
{
	(void)state;
	const edge_case cases[2] = {
		{"check box", white_box, 8, 8, 24, 24, 4, {0.02, 0.3, 0.14}},
		{"rounded button", white_button, 4, 4, 60, 26, 11, {0.02, 0.3, 0.14}},
	};
	screen s = screen_open(64, 32, STILB_RENDER_OUTPUT_LINEAR);
	for (int i = 0; i < 2; i++) {
		double worst[3], mean[3];
		for (int aa = 0; aa < 3; aa++)
			mean[aa] = edge_error(&s, &cases[i], (stilb_ui_aa)aa, &worst[aa]);
		print_message("%-14s feathered %.4f (worst %.3f), article %.4f (%.3f), off %.4f (%.3f)\n", cases[i].name,
		              mean[0], worst[0], mean[1], worst[1], mean[2], worst[2]);
		assert_true(mean[0] <= cases[i].limits[0] && worst[0] <= 0.05);
		assert_true(mean[1] >= cases[i].limits[1] && mean[2] >= cases[i].limits[2]);
	}
	screen_close(&s);
}

/* ---- the picture for the documentation --------------------------------------------------------------------------- */

#define COLUMN 256u /* width of a column, pixels; one for each way of antialiasing */
#define ZOOM 8u
#define CROP 28u /* side of the enlarged square with the check box, pixels */

static void draw_column(stilb_ui *ui, float x, stilb_ui_aa aa, const char *title)
{
	stilb_ui_draw_list *list = stilb_ui_list(ui);
	bool on = true;
	stilb_ui_draw_text(list, stilb_ui_font_get(ui, STILB_UI_TEXT_STRONG), (stilb_ui_rect){x + 16, 8, x + 256, 28},
	                   STILB_UI_ALIGN_LEFT, stilb_ui_rgb(0xd5dae1), title);
	stilb_ui_id_push_number(ui, aa);
	stilb_ui_aa_set(ui, aa);
	stilb_ui_checkbox(ui, (stilb_ui_rect){x + 22, 277, x + 44, 299}, "##box", &on);
	stilb_ui_button_rounded(ui, (stilb_ui_rect){x + 56, 277, x + 146, 299}, "Capture");
	stilb_ui_button(ui, (stilb_ui_rect){x + 154, 277, x + 240, 299}, "Slowest");
	stilb_ui_draw_rounded(list, (stilb_ui_rect){x + 22, 312, x + 82, 342}, 10, stilb_ui_rgb(0xe3b341));
	stilb_ui_draw_circle(list, (stilb_ui_point){x + 106, 327}, 15, stilb_ui_rgb(0x67b96a));
	stilb_ui_draw_triangle(list, (stilb_ui_point){x + 132, 312}, (stilb_ui_point){x + 166, 327},
	                       (stilb_ui_point){x + 132, 342}, stilb_ui_rgb(0xe5594f));
	stilb_ui_draw_line(list, (stilb_ui_point){x + 178, 340}, (stilb_ui_point){x + 238, 314}, 1.0f,
	                   stilb_ui_rgb(0xd5dae1));
	stilb_ui_aa_set(ui, STILB_UI_AA_FEATHER);
	stilb_ui_id_pop(ui);
}

/* Copies a square of CROP x CROP pixels, each enlarged to ZOOM x ZOOM. */
static void enlarge(const stilb_image *image, uint32_t from_x, uint32_t from_y, uint32_t to_x, uint32_t to_y)
{
	uint8_t *pixels = image->pixels;
	for (uint32_t y = 0; y < CROP * ZOOM; y++)
		for (uint32_t x = 0; x < CROP * ZOOM; x++)
			memcpy(pixels + 3 * ((to_y + y) * image->width + to_x + x),
			       pixels + 3 * ((from_y + y / ZOOM) * image->width + from_x + x / ZOOM), 3);
}

static stilb_image edges_picture(void)
{
	static const char *const titles[3] = {"off", "article", "feathered (the default)"};
	static const stilb_ui_aa ways[3] = {STILB_UI_AA_OFF, STILB_UI_AA_ARTICLE, STILB_UI_AA_FEATHER};
	screen s = screen_open(3 * COLUMN, 356, STILB_RENDER_OUTPUT_DISPLAY);
	screen_begin(&s);
	stilb_ui_draw_rect(stilb_ui_list(s.ui), (stilb_ui_rect){0, 0, 3 * COLUMN, 356}, stilb_ui_rgb(0x14171c));
	for (uint32_t i = 0; i < 3; i++)
		draw_column(s.ui, (float)(i * COLUMN), ways[i], titles[i]);
	stilb_image image = screen_end(&s);
	for (uint32_t i = 0; i < 3; i++)
		enlarge(&image, i * COLUMN + 16, 274, i * COLUMN + 16, 36);
	screen_close(&s);
	return image;
}

/* The number of different colors among a column's shapes, at most 32. */
static uint32_t shape_colors(const stilb_image *image, uint32_t column)
{
	const uint8_t *pixels = image->pixels;
	const uint8_t *found[32];
	uint32_t count = 0;
	for (uint32_t y = 310; y < 345; y++)
		for (uint32_t x = column * COLUMN + 16; x < column * COLUMN + 240 && count < 32; x++) {
			const uint8_t *pixel = pixels + 3 * (y * image->width + x);
			uint32_t c = 0;
			while (c < count && memcmp(found[c], pixel, 3) != 0)
				c++;
			found[c] = pixel;
			count += c == count;
		}
	return count;
}

/* Without antialiasing the shapes have no colors but their own and the background's, else also mixtures of the two. */
static void test_picture_for_the_documentation(void **state)
{
	(void)state;
	stilb_image image = edges_picture();
	assert_int_equal(shape_colors(&image, 0), 5);
	assert_true(shape_colors(&image, 1) > 5 && shape_colors(&image, 2) > 5);
	const char *path = getenv("STILB_UI_EDGES");
	if (path && stilb_image_save(&image, path) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_image_finish(&image);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_the_gpu_draws_the_list),
		cmocka_unit_test(test_an_empty_list_is_an_empty_pass),
		cmocka_unit_test(test_edges_against_coverage),
		cmocka_unit_test(test_picture_for_the_documentation),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
