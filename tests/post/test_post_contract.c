/* The asserts of post, each made to fail on purpose; and frames of the null device, which counts the chain's rows. */
#include "post_stage.h"
#include "support/contract.h"

static void broken_contracts(void **state)
{
	(void)state;
	post_stage s;
	stilb_post *post;
	stage_open(&s, STILB_RENDER_DEVICE_NULL, 64, 64);
	static const stilb_post_settings wrong[] = {
		{.occlusion = 1.5f},
		{.occlusion_radius = -1.0f},
		{.occlusion_radius = INFINITY},
		{.bloom = -0.1f},
		{.bloom = 1.1f},
		{.bloom = NAN},
		{.bloom_width = 2.0f},
		{.bloom_width = NAN},
		{.exposure_low = -0.1f, .exposure_high = 0.5f},
		{.exposure_low = 0.5f, .exposure_high = 0.5f},
		{.exposure_high = 1.1f},
		{.exposure_speed = -1.0f},
		{.exposure_rate = INFINITY},
		{.exposure_darkest = 3.0f, .exposure_brightest = 2.0f},
		{.exposure_darkest = NAN},
		{.bloom_format = STILB_POST_BLOOM_FORMATS_COUNT},
		{.dither = STILB_POST_DITHERS_COUNT},
		{.reflections = STILB_POST_REFLECTIONS_COUNT},
		{.dof = STILB_POST_DOF_COUNT},
		{.dof = STILB_POST_DOF_BOKEH, .aperture = 0.1f},
		{.aperture = -0.1f},
		{.aperture = INFINITY},
		{.focus = NAN},
		{.blades = 2},
		{.blades = 17},
	};
	for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
		assert_false(stilb_post_settings_are_valid(&wrong[i]));
		contract_breaks("stilb_post_settings_are_valid", stilb_post_set(s.post, &wrong[i]));
	}
	contract_breaks("isfinite", stilb_post_see(s.post, &(stilb_render_view){.exposure = INFINITY}));
	contract_breaks("seconds >= 0.0f", stilb_post_adapt(s.post, -1.0f));
	contract_breaks("finite", stilb_post_adapt(s.post, INFINITY));
	static const stilb_post_area flat = {.high = {1.0f, 1.0f, 0.0f}};
	static const stilb_post_area endless = {.high = {1.0f, 1.0f, 1.0f}, .blend = INFINITY};
	stilb_post_table *table;
	contract_breaks("grade_area_is_valid", stilb_post_set_grade(s.post, NULL, &flat, 1));
	contract_breaks("grade_area_is_valid", stilb_post_set_grade(s.post, NULL, &endless, 1));
	contract_breaks("count <= 64", stilb_post_set_grade(s.post, NULL, &flat, STILB_POST_MAX_AREAS + 1));
	contract_breaks("areas || count == 0", stilb_post_set_grade(s.post, NULL, NULL, 1));
	contract_breaks("size >= 2", stilb_post_table_identity(1, &table));
	contract_breaks("render && post", stilb_post_create(NULL, &post));
	assert_true(stilb_post_settings_are_valid(&(stilb_post_settings){.bloom = 1.0f, .bloom_width = 1.0f}));
	stilb_post_set(s.post, &(stilb_post_settings){.bloom = 1.0f});
	stage_draw(&s);
	stage_close(&s);
	stilb_post_destroy(NULL);
}

int main(void)
{
	struct CMUnitTest tests[] = {cmocka_unit_test(broken_contracts)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
