/* The materials' window used with mouse and keys, without a renderer. */
#include "engine_internal.h"
#include "shading/shade_brdf.h"
#include "support/test.h"

#include <stddef.h>
#include <string.h>

/* ---- a user ------------------------------------------------------------------------------------------------------ */

static stilb_ui *ui;
static stilb_ui_input input;
static engine_inspector inspector;
static stilb_render_shading shading;
static const char *const words[] = {"sun", "hemisphere", "sphere", "disk", "windowed", "subtracted", NULL};
enum { CHOICES = sizeof words / sizeof *words - 1 };
static stilb_engine_choice choice = {"Light", words, CHOICES, 0, 0};
static bool open;

static int set_up(void **state)
{
	(void)state;
	stilb_ui_desc desc = stilb_ui_desc_default();
	input = (stilb_ui_input){.width = 1280.0f, .height = 720.0f, .seconds = 1.0f};
	inspector = (engine_inspector){0};
	shading = stilb_render_shading_default();
	open = true;
	return stilb_ui_create(&desc, &ui) == STILB_OK ? 0 : -1;
}

static int tear_down(void **state)
{
	(void)state;
	stilb_ui_destroy(ui);
	return 0;
}

static void draw(void)
{
	stilb_ui_begin(ui, &input);
	engine_inspector_draw(&inspector, ui, &shading, &choice, &open);
	stilb_ui_end(ui);
	input.mouse_presses = 0;
	memset(input.keys, 0, sizeof input.keys);
}

static void point_at(float x, float y)
{
	input.mouse_present = true;
	input.mouse_x = x;
	input.mouse_y = y;
	draw(); /* a widget reacts to the mouse in the frame after the one that drew it */
	draw();
}

static void click(float x, float y)
{
	point_at(x, y);
	input.mouse_down = true;
	input.mouse_presses = 1;
	draw();
	input.mouse_down = false;
	draw();
}

static void key(stilb_ui_key which)
{
	input.keys[which] = 1;
	draw();
}

/* The x at this share of the panel's width: 0 is its left edge, 1 its right one. */
static float across(float share)
{
	return inspector.place.x0 + share * (inspector.place.x1 - inspector.place.x0);
}

/* Clicks at every pixel of a vertical line from below the title down to `end` of the panel's height; before each click
 * the shading is reset to the default, or to Lambert. */
static void click_down(float share, float end, bool lambert, void (*look)(void))
{
	float height = inspector.place.y1 - inspector.place.y0;
	for (float y = inspector.place.y0 + 30.0f; y < inspector.place.y0 + end * height; y += 5.0f) {
		shading = stilb_render_shading_default();
		choice.chosen = 0;
		if (lambert)
			shading.brdf = SHADE_BRDF_LAMBERT;
		click(across(share), y);
		look();
	}
}

/* ---- choosing ---------------------------------------------------------------------------------------------------- */

static uint32_t seen[5][SHADE_BRDF_COUNT + SHADE_G_COUNT];

static void look_at_choice(void)
{
	seen[0][shading.brdf]++;
	seen[1][shading.ndf]++;
	seen[2][shading.g]++;
	seen[3][shading.f]++;
	seen[4][choice.chosen]++;
}

static uint32_t count_seen(int list)
{
	uint32_t count = 0;
	for (int i = 0; i < SHADE_BRDF_COUNT + SHADE_G_COUNT; i++)
		count += seen[list][i] > 0;
	return count;
}

/* Clicking a row of any list chooses the model that it names. */
static void test_each_word(void **state)
{
	(void)state;
	memset(seen, 0, sizeof seen);
	draw();
	click_down(0.2f, 0.72f, false, look_at_choice);
	assert_int_equal(count_seen(0), SHADE_BRDF_COUNT);
	assert_int_equal(count_seen(4), CHOICES);
	assert_int_equal(count_seen(1) + count_seen(2) + count_seen(3), 3); /* clicks there have not changed D, G and F */
	memset(seen, 0, sizeof seen);
	click_down(0.7f, 0.72f, false, look_at_choice);
	assert_int_equal(count_seen(1), SHADE_NDF_COUNT);
	assert_int_equal(count_seen(2), SHADE_G_COUNT);
	assert_int_equal(count_seen(3), SHADE_F_COUNT);
	assert_int_equal(count_seen(4), 1);
	assert_true(open);
}

static void look_at_model(void)
{
	stilb_render_shading at_first = stilb_render_shading_default();
	bool same = shading.ndf == at_first.ndf && shading.g == at_first.g && shading.f == at_first.f;
	seen[0][shading.brdf]++;
	assert_true(same || shading.brdf == SHADE_BRDF_MICROFACET);
	assert_true(shading.brdf == SHADE_BRDF_LAMBERT || shading.brdf == SHADE_BRDF_MICROFACET);
}

/* Choosing D, G or F chooses the microfacet model, also if that row was selected already. */
static void test_a_part_chooses_its_model(void **state)
{
	(void)state;
	memset(seen, 0, sizeof seen);
	draw();
	click_down(0.7f, 0.72f, true, look_at_model);
	uint32_t rows = SHADE_NDF_COUNT + SHADE_G_COUNT + SHADE_F_COUNT;
	assert_in_range(seen[0][SHADE_BRDF_MICROFACET], 3 * rows, 4 * rows); /* a row is 18 pixels high */
	assert_true(seen[0][SHADE_BRDF_LAMBERT] > 0);                        /* clicks on headings choose nothing */
}

static float wrap_then_anisotropy(uint32_t brdf, uint32_t ndf)
{
	stilb_render_shading before = shading;
	shading.brdf = brdf;
	shading.ndf = ndf;
	stilb_engine_shading_chosen(&before, &shading);
	return shading.wrap + 10.0f * shading.anisotropy;
}

/* Choosing wrapped light or anisotropic GGX adds wrap or anisotropy; choosing another model removes it unless the user
 * has changed it. */
static void test_a_choice_can_be_seen(void **state)
{
	(void)state;
	enum { BENT = SHADE_NDF_GGX_ANISOTROPIC };
	shading = stilb_render_shading_default();
	assert_true(wrap_then_anisotropy(SHADE_BRDF_WRAPPED, SHADE_NDF_GGX) == 0.5f);
	assert_true(wrap_then_anisotropy(SHADE_BRDF_WRAPPED, BENT) == 0.5f);
	assert_true(wrap_then_anisotropy(SHADE_BRDF_MICROFACET, BENT) == 6.0f);
	assert_true(wrap_then_anisotropy(SHADE_BRDF_PHONG, BENT) == 0.0f);
	shading.wrap = 0.5f; /* set by the user with Phong: choosing Lambert keeps it */
	assert_true(wrap_then_anisotropy(SHADE_BRDF_LAMBERT, BENT) == 0.5f);
	shading.wrap = 0.25f;
	shading.anisotropy = -0.5f;
	assert_true(wrap_then_anisotropy(SHADE_BRDF_WRAPPED, BENT) == -4.75f);
	assert_true(wrap_then_anisotropy(SHADE_BRDF_MICROFACET, BENT) == -4.75f);
	assert_true(wrap_then_anisotropy(SHADE_BRDF_MICROFACET, SHADE_NDF_BLINN) == -4.75f);
}

/* Chosen with the mouse: the second row below the first heading is wrapped light. */
static void test_wrapped_clicked(void **state)
{
	(void)state;
	draw();
	float first = inspector.place.y0 + 34.0f + 18.0f + 9.0f;
	click(across(0.2f), first + 18.0f);
	assert_int_equal(shading.brdf, SHADE_BRDF_WRAPPED);
	assert_true(shading.wrap == 0.5f);
	click(across(0.2f), first);
	assert_int_equal(shading.brdf, SHADE_BRDF_LAMBERT);
	assert_true(shading.wrap == 0.0f);
}

static void test_words(void **state)
{
	(void)state;
	assert_string_equal(stilb_engine_brdf_names[SHADE_BRDF_BLINN_PHONG_MODIFIED], "blinn_phong_modified");
	assert_string_equal(stilb_engine_ndf_names[SHADE_NDF_GGX_ANISOTROPIC], "ggx_anisotropic");
	assert_string_equal(stilb_engine_g_names[SHADE_G_SMITH_GGX], "smith_ggx");
	assert_string_equal(stilb_engine_f_names[SHADE_F_NONE], "none");
	assert_null(stilb_engine_brdf_names[SHADE_BRDF_COUNT]);
}

static void test_keys(void **state)
{
	(void)state;
	draw();
	shading.brdf = SHADE_BRDF_WRAPPED;
	for (int i = 0; i < 10 && shading.brdf == SHADE_BRDF_WRAPPED; i++) {
		key(STILB_UI_KEY_TAB); /* from list to list until that of the models has the keys */
		key(STILB_UI_KEY_DOWN);
	}
	assert_int_equal(shading.brdf, SHADE_BRDF_PHONG);
	key(STILB_UI_KEY_UP);
	key(STILB_UI_KEY_UP);
	assert_int_equal(shading.brdf, SHADE_BRDF_LAMBERT);
	key(STILB_UI_KEY_UP); /* already the first row */
	assert_int_equal(shading.brdf, SHADE_BRDF_LAMBERT);
}

/* ---- sliders ----------------------------------------------------------------------------------------------------- */

static uint32_t moved[4];

static void look_at_sliders(void)
{
	if (shading.brdf != stilb_render_shading_default().brdf)
		return; /* clicked into a list */
	const float values[4] = {shading.roughness, shading.anisotropy, shading.wrap, shading.specular};
	for (int i = 0; i < 4; i++) {
		assert_true(values[i] >= -1.0f && values[i] <= 1.0f);
		moved[i] += values[i] > 0.2f;
		moved[i] += values[i] < -0.2f ? 100 : 0;
	}
}

/* A click right of a slider's middle raises the value, one left of it lowers it; the button resets all. */
static void test_sliders(void **state)
{
	(void)state;
	draw();
	memset(moved, 0, sizeof moved);
	click_down(0.9f, 1.0f, false, look_at_sliders);
	for (int i = 0; i < 4; i++)
		assert_in_range(moved[i], 3, 5); /* as many of the clicks fall on a slider, which is 22 pixels high */
	memset(moved, 0, sizeof moved);
	click_down(0.53f, 1.0f, false, look_at_sliders);
	for (int i = 0; i < 4; i++)
		assert_in_range(moved[i], 300, 500);
	stilb_render_shading at_first = stilb_render_shading_default();
	shading = (stilb_render_shading){.brdf = SHADE_BRDF_PHONG, .wrap = 0.5f, .specular = 1.0f};
	choice.chosen = 2;
	click(across(0.75f), inspector.place.y1 - 18.0f);
	assert_memory_equal(&shading, &at_first, sizeof shading);
	assert_int_equal(choice.chosen, choice.initial);
}

/* ---- the window -------------------------------------------------------------------------------------------------- */

static void test_window(void **state)
{
	(void)state;
	draw();
	point_at(across(0.5f), inspector.place.y0 + 100.0f);
	assert_true(stilb_ui_wants_mouse(ui));
	point_at(20.0f, 700.0f);
	assert_false(stilb_ui_wants_mouse(ui));
	stilb_ui_rect before = inspector.place;
	point_at(across(0.4f), before.y0 + 10.0f);
	input.mouse_down = true;
	input.mouse_presses = 1;
	draw();
	input.mouse_x -= 300.0f;
	input.mouse_y += 50.0f;
	draw();
	input.mouse_down = false;
	draw();
	assert_true(inspector.place.x0 == before.x0 - 300.0f && inspector.place.y0 == before.y0 + 50.0f);
	stilb_render_shading at_first = stilb_render_shading_default();
	assert_memory_equal(&shading, &at_first, sizeof shading);
	click(inspector.place.x1 - 14.0f, inspector.place.y0 + 13.0f);
	assert_false(open);
}

/* In a low picture the plot and the sliders are beside the lists; the right edge stays when that changes. */
static void test_low_picture(void **state)
{
	(void)state;
	draw();
	stilb_ui_rect tall = inspector.place;
	input.height = 480.0f;
	draw();
	stilb_ui_rect low = inspector.place;
	assert_true(low.y0 >= 0.0f && low.y1 <= 480.0f && low.x1 == tall.x1 && low.x0 < tall.x0);
	memset(moved, 0, sizeof moved);
	click_down(0.95f, 1.0f, false, look_at_sliders);
	for (int i = 0; i < 4; i++)
		assert_in_range(moved[i], 3, 5);
	memset(seen, 0, sizeof seen);
	click_down(0.45f, 1.0f, false, look_at_choice);
	assert_int_equal(count_seen(1) + count_seen(2) + count_seen(3), SHADE_NDF_COUNT + SHADE_G_COUNT + SHADE_F_COUNT);
	input.height = 720.0f;
	draw();
	draw();
	assert_memory_equal(&inspector.place, &tall, sizeof tall);
}

/* Scrolls to the top with the wheel, and from there down. */
static void scroll_down(float x, float y, float notches)
{
	point_at(x, y);
	input.wheel = 100.0f;
	draw();
	input.wheel = -notches;
	draw();
	input.wheel = 0.0f;
}

static void each_word_of_column(float share)
{
	for (float notches = 0.0f; notches < (input.height < 250.0f ? 6.0f : 3.0f); notches += 0.5f)
		for (float y = inspector.place.y0 + 30.0f; y < inspector.place.y1; y += 6.0f) {
			shading = stilb_render_shading_default();
			choice.chosen = 0;
			scroll_down(across(share), y, notches);
			click(across(share), y);
			look_at_choice();
		}
}

/* In a small picture the lists scroll: every row, every slider, the button and the close box can still be clicked. */
static void test_small_picture(void **state)
{
	(void)state;
	static const float sizes[][2] = {{640.0f, 360.0f}, {400.0f, 300.0f}, {320.0f, 200.0f}};
	for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
		input.width = sizes[s][0];
		input.height = sizes[s][1];
		inspector = (engine_inspector){0};
		draw();
		stilb_ui_rect place = inspector.place;
		assert_true(place.x0 >= 0.0f && place.y0 >= 0.0f && place.x1 <= input.width && place.y1 <= input.height);
		memset(seen, 0, sizeof seen);
		each_word_of_column(0.15f);
		each_word_of_column(0.45f);
		assert_int_equal(count_seen(0), SHADE_BRDF_COUNT);
		assert_int_equal(count_seen(1), SHADE_NDF_COUNT);
		assert_int_equal(count_seen(2), SHADE_G_COUNT);
		assert_int_equal(count_seen(3), SHADE_F_COUNT);
		assert_int_equal(count_seen(4), CHOICES);
		memset(moved, 0, sizeof moved);
		click_down(0.93f, 1.0f, false, look_at_sliders);
		for (int i = 0; i < 4; i++)
			assert_in_range(moved[i], 3, 5);
		stilb_render_shading at_first = stilb_render_shading_default();
		shading.wrap = 1.0f;
		click(across(0.85f), place.y1 - 18.0f);
		assert_memory_equal(&shading, &at_first, sizeof shading);
		click(place.x1 - 14.0f, place.y0 + 13.0f);
		assert_false(open);
		open = true;
	}
}

static bool list_shows(size_t list, uint32_t row, float rows)
{
	float scroll = inspector.lists[list].scroll, top = 18.0f * (float)row;
	return scroll <= top && top + 18.0f <= scroll + 18.0f * rows;
}

/* A chosen row is scrolled into view, be it chosen by the user or the program; then the user may scroll away. */
static void test_chosen_is_in_view(void **state)
{
	(void)state;
	input.width = 400.0f;
	input.height = 300.0f;
	shading.brdf = SHADE_BRDF_MICROFACET;
	shading.g = SHADE_G_SCHLICK_GGX;
	draw();
	assert_true(list_shows(0, SHADE_BRDF_MICROFACET, 5.0f));
	assert_true(list_shows(2 + 1, SHADE_G_SCHLICK_GGX, 3.0f));
	shading.g = SHADE_G_IMPLICIT;
	draw();
	assert_true(list_shows(2 + 1, SHADE_G_IMPLICIT, 3.0f));
	scroll_down(across(0.45f), inspector.place.y0 + 145.0f, 1.0f);
	assert_false(list_shows(2 + 1, SHADE_G_IMPLICIT, 3.0f));
	draw();
	assert_false(list_shows(2 + 1, SHADE_G_IMPLICIT, 3.0f));
}

/* Pictures smaller than the window, and added values at both ends of the sliders: all vertices stay finite, and nothing
 * crashes. */
static void test_small_and_odd(void **state)
{
	(void)state;
	static const float sizes[][2] = {{1.0f, 1.0f}, {64.0f, 48.0f}, {320.0f, 180.0f}, {5000.0f, 100.0f}};
	for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
		input.width = sizes[s][0];
		input.height = sizes[s][1];
		inspector = (engine_inspector){0};
		for (uint32_t brdf = 0; brdf < SHADE_BRDF_COUNT; brdf++)
			for (float added = -1.0f; added <= 1.0f; added += 1.0f) {
				shading = (stilb_render_shading){
					.brdf = brdf, .roughness = added, .anisotropy = added, .wrap = added, .specular = added};
				point_at(0.5f * input.width, 0.5f * input.height);
				const stilb_ui_draw_list *list = stilb_ui_list(ui);
				assert_false(list->out_of_memory);
				for (uint32_t v = 0; v < list->vertex_count; v++)
					assert_true(isfinite(list->vertices[v].position[0]) && isfinite(list->vertices[v].position[1]));
			}
	}
}

/* Frame rate and caption never lie on one another: in a narrow picture the rate stands below. */
static void test_rate_beside_a_caption(void **state)
{
	(void)state;
	engine_rate rate = {.open = true, .rate = 59.9f, .ms = 16.7f, .longest = 18.2f};
	const struct {
		stilb_ui_rect caption;
		float top; /* of the rate's box */
	} rows[] = {
		{{0}, 8.0f},
		{{1000.0f, 8.0f, 1272.0f, 32.0f}, 8.0f},
		{{60.0f, 8.0f, 312.0f, 32.0f}, 40.0f},
		{{310.0f, 8.0f, 560.0f, 32.0f}, 40.0f}, /* it would touch if the numbers were longer */
	};
	for (size_t r = 0; r < sizeof rows / sizeof *rows; r++) {
		stilb_ui_begin(ui, &input);
		stilb_ui_draw_list *list = stilb_ui_list(ui);
		float low = 1e9f;
		uint32_t first = list->vertex_count;
		engine_rate_draw(&rate, ui, rows[r].caption, NULL, 0);
		assert_true(list->vertex_count > first);
		for (uint32_t v = first; v < list->vertex_count; v++)
			low = fminf(low, list->vertices[v].position[1]);
		assert_true(fabsf(low - rows[r].top) < 1.5f); /* edges are feathered */
		stilb_ui_end(ui);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup_teardown(test_each_word, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_a_part_chooses_its_model, set_up, tear_down),
		cmocka_unit_test(test_a_choice_can_be_seen),
		cmocka_unit_test_setup_teardown(test_wrapped_clicked, set_up, tear_down),
		cmocka_unit_test(test_words),
		cmocka_unit_test_setup_teardown(test_keys, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_sliders, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_window, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_low_picture, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_small_picture, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_chosen_is_in_view, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_small_and_odd, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_rate_beside_a_caption, set_up, tear_down),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
