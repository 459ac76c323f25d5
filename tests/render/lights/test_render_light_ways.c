/* Each way of lighting at its limits: programs made ahead, targets smaller than a tile, more lights than passes,
 * pictures without a background, lights that are nowhere, all ways to bind and to replay. */
#include "tests/engine/pipeline_count.h"

#include "render/lights/lights_field.h" /* names a type as these name variables */

/* ---- programs are made ahead ------------------------------------------------------------------------------------- */

/* A frame of a view that was prepared compiles nothing. */
static void assert_prepared(field *f, const char *what)
{
	for (int way = 0; way < STILB_RENDER_LIGHTING_WAYS; way++) {
		f->view.lighting = (stilb_render_lighting)way;
		f->view.lights = f->lights;
		assert_int_equal(stilb_render_prepare_view(f->render, &f->view), STILB_OK);
		int before = pipeline_count;
		field_frame(f, (stilb_render_lighting)way, 1);
		if (pipeline_count != before)
			fail_msg("%s, %s: the frame compiled %d pipelines", what, stilb_render_lighting_names[way],
			         pipeline_count - before);
	}
}

static void a_first_frame_compiles_nothing(void **state)
{
	(void)state;
	field f = field_open(STILB_RENDER_OUTPUT_LINEAR, 0, 1);
	assert_prepared(&f, "wide");
	f.view.light_tolerance = 0.1f;
	f.view.light_peak = 1e3f;
	f.view.deferred = (stilb_render_deferred){STILB_RENDER_COVERAGE_VOLUMES, STILB_RENDER_GBUFFER_RGBA8};
	assert_prepared(&f, "narrow, with a tolerance, by volumes");
	assert_true(pipeline_count > 0);
	field_close(&f);
}

/* ---- lights are counted ------------------------------------------------------------------------------------------ */

static stilb_render_light_counts counts_of(field *f, stilb_render_lighting way)
{
	stilb_image image;
	field_frame(f, way, 1);
	assert_int_equal(stilb_render_read_radiance(f->render, &image), STILB_OK);
	assert_int_equal(image.channels, 3);
	uint64_t pixels = (uint64_t)image.width * image.height;
	uint16_t(*texels)[4] = calloc(pixels, sizeof *texels);
	assert_non_null(texels);
	for (uint64_t i = 0; i < pixels; i++)
		memcpy(texels[i], (const uint16_t *)image.pixels + 3 * i, 3 * sizeof **texels);
	stilb_render_light_counts counts = stilb_render_count_lights((const uint16_t(*)[4])texels, pixels);
	free(texels);
	stilb_image_finish(&image);
	assert_int_equal(counts.pixels, pixels);
	return counts;
}

/* Each way asks no fewer lights than reach its pixels, which bodies around lights tell nearly, and no more than all. */
static void asked_lights_are_counted(void **state)
{
	(void)state;
	field f = field_open(STILB_RENDER_OUTPUT_LINEAR, 1, 1);
	f.view.show = STILB_RENDER_SHOW_LIGHTS;
	f.view.exposure = 3.0f;         /* is not read */
	double all = f.light_count - 1; /* one is BAKED */
	stilb_render_light_counts screen, cells, some;
	f.view.deferred.coverage = STILB_RENDER_COVERAGE_SCREEN;
	screen = counts_of(&f, STILB_RENDER_LIGHTING_DEFERRED);
	assert_true(screen.shown > WIDTH * HEIGHT / 8 && screen.shown < WIDTH * HEIGHT);
	assert_true(screen.shadings == (double)screen.shown && screen.lights == all * (double)screen.shown);
	f.view.deferred.coverage = STILB_RENDER_COVERAGE_CELLS;
	cells = counts_of(&f, STILB_RENDER_LIGHTING_DEFERRED);
	assert_true(cells.shadings == (double)cells.shown && cells.shown == screen.shown);
	for (int way = 0; way < STILB_RENDER_LIGHTING_WAYS; way++) {
		const char *name = stilb_render_lighting_names[way];
		some = counts_of(&f, (stilb_render_lighting)way);
		double each = some.lights / (double)some.shown, lit = some.shadings / (double)some.shown;
		bool multipass = way == STILB_RENDER_LIGHTING_MULTIPASS;
		bool forward = way == STILB_RENDER_LIGHTING_FORWARD || way == STILB_RENDER_LIGHTING_COMBINED; /* by hand */
		if (some.shown != screen.shown)
			fail_msg("%s: %u pixels, not %u", name, (unsigned)some.shown, (unsigned)screen.shown);
		if (forward && some.lights != all * some.shadings)
			fail_msg("%s: %g lights of %g", name, some.lights / some.shadings, all);
		if (!(lit >= 1.0 && lit < 2.0) != multipass)
			fail_msg("%s: lit %g times", name, lit);
		if (!(each >= 3.0 && each <= all * 2.0) || (!forward && !multipass && each > 0.5 * all))
			fail_msg("%s: %g lights a pixel of %g", name, each, all);
	}
	double before = all * (double)screen.shown; /* bodies hold less than rectangles, and these less than all */
	for (int coverage = STILB_RENDER_COVERAGE_RECTANGLES; coverage <= STILB_RENDER_COVERAGE_VOLUMES; coverage++) {
		f.view.deferred.coverage = (stilb_render_coverage)coverage;
		some = counts_of(&f, STILB_RENDER_LIGHTING_DEFERRED);
		assert_true(some.shown == screen.shown && some.lights > 3.0 * (double)some.shown);
		assert_true(some.lights < before && some.shadings > 3.0 * (double)some.shown);
		before = some.lights;
	}
	field_close(&f);
}

/* ---- limits ------------------------------------------------------------------------------------------------------ */

/* All ways, and all coverages of DEFERRED, show what FORWARD shows. */
static void all_as_forward(field *f, const char *what)
{
	stilb_image forward = field_picture(f, STILB_RENDER_LIGHTING_FORWARD, 1);
	for (int i = 0; i < STILB_RENDER_LIGHTING_WAYS + STILB_RENDER_COVERAGE_WAYS; i++) {
		bool way = i < STILB_RENDER_LIGHTING_WAYS;
		int coverage = way ? 0 : i - STILB_RENDER_LIGHTING_WAYS;
		f->view.deferred.coverage = (stilb_render_coverage)coverage;
		stilb_image picture = field_picture(f, way ? (stilb_render_lighting)i : STILB_RENDER_LIGHTING_DEFERRED, 1);
		assert_as_forward(what, way ? (stilb_render_lighting)i : STILB_RENDER_LIGHTING_MULTIPASS, &forward, &picture);
		stilb_image_finish(&picture);
	}
	f->view.deferred.coverage = STILB_RENDER_COVERAGE_CELLS;
	stilb_image_finish(&forward);
}

/* Smaller than a tile and than a cell. */
static void a_small_picture(void **state)
{
	(void)state;
	field f = field_open(STILB_RENDER_OUTPUT_LINEAR, 0, 1);
	assert_int_equal(stilb_render_resize(f.render, 5, 3), STILB_OK);
	all_as_forward(&f, "small");
	field_close(&f);
}

/* So many small lamps over the field, each of which lights something: of a pixel a few. */
static void field_of_lamps(field *f, stilb_scene_light *lamps, uint32_t count)
{
	for (uint32_t i = 0; i < count; i++) {
		uint32_t side = (uint32_t)ceil(sqrt(count));
		lamps[i] = lamp(STILB_SCENE_LIGHT_POINT, STILB_SCENE_LIGHT_WINDOWED,
		                8.0f * ((float)(i % side) / (float)side - 0.5f), 8.0f * (float)(i / side) / (float)side);
		lamps[i].reach = 1.5f + 10.0f / (float)side;
	}
	f->own_lights = lamps;
	f->view.light_count = count;
}

/* More rectangles than a frame has rows for, and more eights than passes. */
static void more_lights_than_rows(void **state)
{
	(void)state;
	enum { RECTANGLES = 1100, PASSES = 8300 };
	field f = field_open(STILB_RENDER_OUTPUT_LINEAR, 0, 1);
	stilb_scene_light *lamps = calloc(PASSES, sizeof *lamps);
	assert_non_null(lamps);
	assert_int_equal(stilb_render_resize(f.render, 24, 16), STILB_OK);
	field_of_lamps(&f, lamps, RECTANGLES);
	stilb_image forward = field_picture(&f, STILB_RENDER_LIGHTING_FORWARD, 1);
	f.view.deferred.coverage = STILB_RENDER_COVERAGE_RECTANGLES;
	stilb_image picture = field_picture(&f, STILB_RENDER_LIGHTING_DEFERRED, 1);
	double off = deferred_off(&forward, &picture);
	if (!(off <= 20.0 * DEFERRED_ADDED)) /* some 300 lights a pixel, each rounded to half floats */
		fail_msg("%u rectangles: off by %.2f", RECTANGLES, off);
	stilb_image_finish(&picture);
	stilb_image_finish(&forward);
	field_of_lamps(&f, lamps, PASSES);
	for (uint32_t i = 0; i < PASSES; i++)
		lamps[i].reach = 0.3f;
	forward = field_picture(&f, STILB_RENDER_LIGHTING_FORWARD, 1);
	picture = field_picture(&f, STILB_RENDER_LIGHTING_MULTIPASS, 1);
	assert_as_forward("more lights than eights of passes", STILB_RENDER_LIGHTING_MULTIPASS, &forward, &picture);
	stilb_image_finish(&picture);
	stilb_image_finish(&forward);
	free(lamps);
	field_close(&f);
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

/* With nothing behind the field pictures have alpha, which all ways agree in, and no light where that is 0. */
static void nothing_behind(void **state)
{
	(void)state;
	field f = field_open(STILB_RENDER_OUTPUT_LINEAR, 0, 1);
	f.view.backdrop = (stilb_scene_backdrop){.kind = STILB_SCENE_BACKDROP_NOTHING};
	stilb_image forward = field_picture(&f, STILB_RENDER_LIGHTING_FORWARD, 1);
	assert_int_equal(forward.channels, 4);
	for (int way = 0; way < STILB_RENDER_LIGHTING_WAYS; way++) {
		stilb_image picture = field_picture(&f, (stilb_render_lighting)way, 1);
		const uint16_t(*want)[4] = forward.pixels, (*got)[4] = picture.pixels;
		uint32_t clear = 0;
		assert_int_equal(picture.channels, 4);
		for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
			if (want[i][3] != got[i][3] || (got[i][3] == 0 && (got[i][0] | got[i][1] | got[i][2])))
				fail_msg("%s: pixel %u has alpha %#x, not %#x", stilb_render_lighting_names[way], i, got[i][3],
				         want[i][3]);
			clear += got[i][3] == 0;
		}
		assert_true(clear > 100);
		if (way_nearness((stilb_render_lighting)way) == SAME_BITS)
			assert_same_bits(stilb_render_lighting_names[way], &forward, &picture);
		stilb_image_finish(&picture);
	}
	stilb_image_finish(&forward);
	field_close(&f);
}

/* Lights that hardly are any: without intensity, without a size, around the viewer, with reach next to nothing. */
static void odd_lights(void **state)
{
	(void)state;
	field f = field_open(STILB_RENDER_OUTPUT_LINEAR, 0, 1);
	for (uint32_t i = 0; i < 12; i++) {
		stilb_scene_light *light = &f.lights[i];
		*light = lamp(i % 3 ? STILB_SCENE_LIGHT_POINT : STILB_SCENE_LIGHT_SPOT, STILB_SCENE_LIGHT_WINDOWED, 0.5f, 4.0f);
		if (i < 3)
			memset(light->intensity, 0, sizeof light->intensity);
		else if (i < 6)
			memcpy(light->position, f.view.camera_position, sizeof light->position);
		else if (i < 9)
			light->reach = 1e-6f;
		else
			light->reach = 1e9f;
		assert_null(stilb_scene_light_mistake(light));
	}
	f.view.light_tolerance = 0.0f;
	all_as_forward(&f, "odd lights");
	field_close(&f);
}

/* What is no light at all is told by name before a frame sees it. */
static void bad_lights_are_refused(void **state)
{
	(void)state;
	stilb_scene *scene;
	assert_int_equal(stilb_scene_create_stress(1, 1, &scene), STILB_OK);
	stilb_scene_light good = lamp(STILB_SCENE_LIGHT_SPHERE, STILB_SCENE_LIGHT_WINDOWED, 0.0f, 0.0f), bad[5];
	for (int i = 0; i < 5; i++)
		bad[i] = good;
	bad[0].intensity[1] = -1.0f;
	bad[1].position[0] = NAN;
	bad[2].radius = 0.0f;
	bad[3].reach = 0.0f;
	bad[4].intensity[2] = INFINITY;
	assert_int_equal(stilb_scene_set_lights(scene, &good, 1), STILB_OK);
	for (int i = 0; i < 5; i++) {
		assert_int_equal(stilb_scene_set_lights(scene, &bad[i], 1), STILB_ERROR_ARGUMENT);
		assert_non_null(strstr(stilb_error_message(), stilb_scene_light_mistake(&bad[i])));
		assert_int_equal(scene->light_count, 1);
	}
	stilb_scene_destroy(scene);
}

/* ---- how draws get to the device --------------------------------------------------------------------------------- */

/* All ways to bind materials and to replay give the same bits, with ways of lighting of each kind. */
static void binding_and_replay(void **state)
{
	(void)state;
	static const stilb_render_lighting ways[] = {STILB_RENDER_LIGHTING_MULTIPASS, STILB_RENDER_LIGHTING_DEFERRED,
	                                             STILB_RENDER_LIGHTING_TILED_FORWARD, STILB_RENDER_LIGHTING_PRELIGHT};
	static const stilb_render_desc descs[] = {
		{0},
		{.materials = STILB_RENDER_MATERIALS_BIND, .replay = STILB_RENDER_REPLAY_DIRECT},
		{.materials = STILB_RENDER_MATERIALS_PIPELINE, .replay = STILB_RENDER_REPLAY_SECONDARY}};
	enum { WAYS = sizeof ways / sizeof *ways };
	stilb_image pictures[WAYS];
	for (size_t d = 0; d < sizeof descs / sizeof *descs; d++) {
		stilb_render_desc desc = descs[d];
		desc.output = STILB_RENDER_OUTPUT_LINEAR;
		desc.samples = 1;
		field f = field_open_desc(desc, 2);
		for (int w = 0; w < WAYS; w++) {
			stilb_image picture = field_picture(&f, ways[w], 1);
			if (d == 0) {
				pictures[w] = picture;
				continue;
			}
			assert_same_bits(stilb_render_lighting_names[ways[w]], &pictures[w], &picture);
			stilb_image_finish(&picture);
		}
		field_close(&f);
	}
	for (int w = 0; w < WAYS; w++)
		stilb_image_finish(&pictures[w]);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_first_frame_compiles_nothing),
		cmocka_unit_test(asked_lights_are_counted),
		cmocka_unit_test(a_small_picture),
		cmocka_unit_test(more_lights_than_rows),
		cmocka_unit_test(nothing_behind),
		cmocka_unit_test(odd_lights),
		cmocka_unit_test(bad_lights_are_refused),
		cmocka_unit_test(binding_and_replay),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
