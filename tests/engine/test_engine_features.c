/* Rows that a program adds to the plan of each frame: effects on light and picture, a dispatch, what is wrong with
 * them, and the plan as a file. With the shaders of the examples. */
#include "engine_internal.h"
#include "support/folder.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const uint32_t photograph_shader[] =
#include "own_pass.frag.inc"
	;
static const uint32_t meter_shader[] =
#include "own_compute.comp.inc"
	;

#define WIDTH 67u /* odd: neither side is a multiple of a work group's */
#define HEIGHT 41u

typedef struct photograph_push {
	float hue[4], dark;
} photograph_push;

static const photograph_push look = {{1.5f, 1.0f, 0.5f, 1.0f}, 0.5f};

static stilb_scene *scene;

static bool apart; /* stilb_engine_desc.ambient_apart of engines that open */

static stilb_engine *open_engine(uint32_t samples, stilb_render_output output)
{
	stilb_engine *engine;
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.width = WIDTH;
	desc.height = HEIGHT;
	desc.samples = samples;
	desc.output = output;
	desc.ambient_apart = apart;
	desc.validate = true;
	desc.workers = 1;
	if (stilb_engine_create(&desc, &engine) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(stilb_engine_set_scene(engine, scene), STILB_OK);
	return engine;
}

static void close_engine(stilb_engine *engine)
{
	assert_int_equal(stilb_engine_validation_messages(engine), 0);
	stilb_engine_destroy(engine);
}

static stilb_result draw(stilb_engine *engine)
{
	stilb_engine_report report;
	return stilb_engine_frame(engine, &report);
}

/* What a test's features do, and what they saw. */
typedef struct stages {
	stilb_gpu_program photograph, meter;
	uint32_t order[16], count; /* stages in the order of their calls */
	uint16_t images[STILB_RENDER_STAGES];
	bool small;              /* the effect's image is too small */
	stilb_gpu_format format; /* of the effect's image */
	stilb_result result;     /* of the effect */
	uint32_t groups[2];
	uint16_t sums;
} stages;

static void note(stages *s, stilb_render_stage stage, uint16_t image)
{
	assert_true(s->count < sizeof s->order / sizeof *s->order);
	s->order[s->count++] = stage;
	s->images[stage] = image;
}

static stilb_result add_first(void *user, stilb_gpu_plan *plan, uint16_t *image)
{
	(void)plan;
	note(user, STILB_RENDER_STAGE_FIRST, *image);
	return STILB_OK;
}

static stilb_result add_last(void *user, stilb_gpu_plan *plan, uint16_t *image)
{
	(void)plan;
	note(user, STILB_RENDER_STAGE_LAST, *image);
	return STILB_OK;
}

static void add_photograph(stages *s, stilb_gpu_plan *plan, const char *name, uint16_t *image)
{
	const stilb_gpu_extent *from = stilb_gpu_plan_extent(plan, *image);
	uint32_t less = s->small ? 2 : 1;
	stilb_gpu_plan_image_row row = {.name = name,
	                                .format = s->format,
	                                .width = (from->width + less - 1) / less,
	                                .height = (from->height + less - 1) / less};
	uint16_t out = stilb_gpu_plan_image(plan, &row);
	stilb_gpu_pass pass = {.name = name,
	                       .kind = STILB_GPU_PASS_FULLSCREEN,
	                       .program = s->photograph.id,
	                       .color = {{.image = out, .load = STILB_GPU_LOAD_DISCARD}},
	                       .color_count = 1,
	                       .uses = {{.resource = *image, .how = STILB_GPU_USE_SAMPLED}},
	                       .use_count = 1,
	                       .constant_bytes = sizeof look};
	memcpy(pass.constants, &look, sizeof look);
	stilb_gpu_plan_pass(plan, &pass);
	*image = out;
}

static stilb_result add_light(void *user, stilb_gpu_plan *plan, uint16_t *image)
{
	stages *s = user;
	note(s, STILB_RENDER_STAGE_LIGHT, *image);
	if (s->result == STILB_OK)
		add_photograph(s, plan, "photograph", image);
	return s->result == STILB_OK ? STILB_OK : stilb_fail(s->result, "no film in the camera");
}

static stilb_result add_ambient(void *user, stilb_gpu_plan *plan, uint16_t *image)
{
	(void)plan;
	note(user, STILB_RENDER_STAGE_AMBIENT, *image);
	return STILB_OK;
}

static stilb_result add_reflection(void *user, stilb_gpu_plan *plan, uint16_t *image)
{
	(void)plan;
	note(user, STILB_RENDER_STAGE_REFLECTION, *image);
	return STILB_OK;
}

static stilb_result add_picture(void *user, stilb_gpu_plan *plan, uint16_t *image)
{
	stages *s = user;
	note(s, STILB_RENDER_STAGE_PICTURE, *image);
	add_photograph(s, plan, "photograph of the picture", image);
	return STILB_OK;
}

static stilb_result add_meter(void *user, stilb_gpu_plan *plan, uint16_t *image)
{
	stages *s = user;
	const stilb_gpu_extent *light = stilb_gpu_plan_extent(plan, *image);
	s->groups[0] = (light->width + 7) / 8;
	s->groups[1] = (light->height + 7) / 8;
	stilb_gpu_plan_buffer_row row = {
		.name = "sums", .bytes = (uint64_t)s->groups[0] * s->groups[1] * sizeof(float), .output = true};
	s->sums = stilb_gpu_plan_buffer(plan, &row);
	stilb_gpu_pass pass = {.name = "light meter",
	                       .kind = STILB_GPU_PASS_DISPATCH,
	                       .program = s->meter.id,
	                       .groups = {s->groups[0], s->groups[1], 1},
	                       .uses = {{.resource = *image, .how = STILB_GPU_USE_SAMPLED},
	                                {.resource = s->sums, .how = STILB_GPU_USE_STORAGE_WRITE}},
	                       .use_count = 2,
	                       .constant_bytes = sizeof(uint64_t)};
	stilb_gpu_plan_pass(plan, &pass);
	return STILB_OK;
}

static stilb_result add_drawn(void *user, stilb_gpu_plan *plan, uint16_t *image)
{
	(void)plan;
	note(user, STILB_RENDER_STAGE_DRAWN, *image);
	return STILB_OK;
}

static void make_programs(stilb_engine *engine, stages *s)
{
	stilb_gpu *gpu = stilb_engine_gpu(engine);
	stilb_gpu_program_desc photograph = {.name = "photograph",
	                                     .fragment = {.words = photograph_shader, .bytes = sizeof photograph_shader},
	                                     .samplers = 1};
	stilb_gpu_program_desc meter = {
		.name = "light meter", .compute = {.words = meter_shader, .bytes = sizeof meter_shader}, .samplers = 1};
	*s = (stages){.format = STILB_GPU_RGBA16_F};
	if (stilb_gpu_program_create(gpu, &photograph, &s->photograph) != STILB_OK ||
	    stilb_gpu_program_create(gpu, &meter, &s->meter) != STILB_OK)
		fail_msg("%s", stilb_error_message());
}

static void add(stilb_engine *engine, stages *s, stilb_render_stage stage,
                stilb_result (*function)(void *user, stilb_gpu_plan *plan, uint16_t *image))
{
	stilb_render_feature feature = {stage, function, s};
	assert_int_equal(stilb_engine_add_feature(engine, &feature), STILB_OK);
}

/* Pixels of the last frame as floats, three a pixel; to be freed. */
static float *pixels(stilb_engine *engine, const char *name)
{
	stilb_image image;
	if (stilb_engine_screenshot(engine, name) != STILB_OK || stilb_image_load(name, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_true(image.format == STILB_IMAGE_F32_LINEAR && image.width == WIDTH && image.height == HEIGHT &&
	            image.channels == 3);
	return image.pixels;
}

static float bright_of(const float *p)
{
	return 0.2126f * p[0] + 0.7152f * p[1] + 0.0722f * p[2];
}

/* What the shader makes of a pixel. */
static float photographed(const float *light, uint32_t x, uint32_t y, int channel)
{
	float u = ((float)x + 0.5f) / WIDTH - 0.5f, v = ((float)y + 0.5f) / HEIGHT - 0.5f;
	return bright_of(light) * look.hue[channel] * (1.0f - look.dark * 2.0f * (u * u + v * v));
}

/* The effect takes the light's place before the tone map; with output linear the picture is the light as it then is. */
static void an_effect_on_the_light(void **state)
{
	(void)state;
	for (uint32_t samples = 1; samples <= 4; samples += 3) {
		stages s;
		stilb_engine *engine = open_engine(samples, STILB_RENDER_OUTPUT_LINEAR);
		make_programs(engine, &s);
		assert_int_equal(draw(engine), STILB_OK);
		float *plain = pixels(engine, "plain.exr");
		add(engine, &s, STILB_RENDER_STAGE_LIGHT, add_light);
		for (int frame = 0; frame < 3; frame++)
			assert_int_equal(draw(engine), STILB_OK);
		assert_int_equal(stilb_gpu_stats_get(stilb_engine_gpu(engine)).passes, samples > 1 ? 4 : 3);
		float *got = pixels(engine, "effect.exr");
		for (uint32_t y = 0; y < HEIGHT; y++)
			for (uint32_t x = 0; x < WIDTH; x++)
				for (int c = 0; c < 3; c++) {
					const float *light = plain + 3 * (y * WIDTH + x);
					float want = photographed(light, x, y, c), have = got[3 * (y * WIDTH + x) + (uint32_t)c];
					if (fabsf(have - want) > 2e-3f * want + 1e-4f)
						fail_msg("%ux%u %d: %g, not %g", x, y, c, (double)have, (double)want);
				}
		free(plain);
		free(got);
		stilb_engine_remove_feature(engine, &s);
		assert_int_equal(draw(engine), STILB_OK);
		assert_int_equal(stilb_gpu_stats_get(stilb_engine_gpu(engine)).passes, samples > 1 ? 3 : 2);
		close_engine(engine);
	}
}

/* An effect that goes by the light's own size works whatever that is. */
static void an_effect_on_light_of_another_size(void **state)
{
	(void)state;
	stages s;
	stilb_engine *engine = open_engine(1, STILB_RENDER_OUTPUT_DISPLAY);
	stilb_engine_set_scale(engine, 0.5f);
	make_programs(engine, &s);
	add(engine, &s, STILB_RENDER_STAGE_LIGHT, add_light);
	assert_int_equal(draw(engine), STILB_OK);
	const stilb_gpu_plan *plan = stilb_engine_plan(engine);
	const stilb_gpu_extent *extent = stilb_gpu_plan_extent(plan, stilb_gpu_plan_find(plan, "photograph"));
	assert_int_equal(extent->width, (WIDTH + 1) / 2);
	assert_int_equal(extent->height, (HEIGHT + 1) / 2);
	close_engine(engine);
}

static void stages_come_in_their_order(void **state)
{
	(void)state;
	stages s;
	apart = true;
	stilb_engine *engine = open_engine(1, STILB_RENDER_OUTPUT_LINEAR);
	apart = false;
	make_programs(engine, &s);
	add(engine, &s, STILB_RENDER_STAGE_LAST, add_last);
	add(engine, &s, STILB_RENDER_STAGE_PICTURE, add_picture);
	add(engine, &s, STILB_RENDER_STAGE_LIGHT, add_light);
	add(engine, &s, STILB_RENDER_STAGE_REFLECTION, add_reflection);
	add(engine, &s, STILB_RENDER_STAGE_AMBIENT, add_ambient);
	add(engine, &s, STILB_RENDER_STAGE_FIRST, add_first);
	add(engine, &s, STILB_RENDER_STAGE_DRAWN, add_drawn);
	add(engine, &s, STILB_RENDER_STAGE_LIGHT, add_meter);
	assert_int_equal(draw(engine), STILB_OK);
	assert_int_equal(s.count, STILB_RENDER_STAGES);
	for (uint32_t i = 0; i < s.count; i++)
		assert_int_equal(s.order[i], i);
	const stilb_gpu_plan *plan = stilb_engine_plan(engine);
	assert_int_equal(s.images[STILB_RENDER_STAGE_FIRST], 0);
	assert_int_equal(s.images[STILB_RENDER_STAGE_AMBIENT], stilb_gpu_plan_find(plan, "ambient"));
	assert_int_equal(s.images[STILB_RENDER_STAGE_REFLECTION], stilb_gpu_plan_find(plan, "reflection"));
	assert_int_equal(s.images[STILB_RENDER_STAGE_DRAWN], stilb_gpu_plan_find(plan, "color"));
	assert_int_equal(s.images[STILB_RENDER_STAGE_LIGHT], stilb_gpu_plan_find(plan, "color"));
	assert_int_equal(s.images[STILB_RENDER_STAGE_PICTURE], stilb_gpu_plan_find(plan, "picture"));
	assert_int_equal(s.images[STILB_RENDER_STAGE_LAST], stilb_gpu_plan_find(plan, "photograph of the picture"));
	/* The effect twice: a screenshot has what takes the picture's place. */
	float *got = pixels(engine, "twice.exr");
	float once[3], twice;
	stilb_engine_remove_feature(engine, &s);
	assert_int_equal(draw(engine), STILB_OK);
	float *plain = pixels(engine, "plain.exr");
	uint32_t x = WIDTH / 2, y = HEIGHT / 2;
	for (int c = 0; c < 3; c++)
		once[c] = photographed(plain + 3 * (y * WIDTH + x), x, y, c);
	for (int c = 0; c < 3; c++) {
		twice = photographed(once, x, y, c);
		assert_true(fabsf(got[3 * (y * WIDTH + x) + (uint32_t)c] - twice) <= 3e-3f * twice + 1e-4f);
	}
	free(plain);
	free(got);
	close_engine(engine);
}

/* A dispatch reads the light and its sums are read back, each with the frame that it belongs to. */
static void a_dispatch_and_its_result(void **state)
{
	(void)state;
	stages s;
	stilb_engine *engine = open_engine(1, STILB_RENDER_OUTPUT_LINEAR);
	make_programs(engine, &s);
	add(engine, &s, STILB_RENDER_STAGE_LIGHT, add_meter);
	for (uint64_t f = 1; f <= 3; f++) {
		uint64_t ticket = 0, frame = 0;
		const void *bytes = NULL;
		assert_int_equal(draw(engine), STILB_OK);
		stilb_gpu *gpu = stilb_engine_gpu(engine);
		assert_int_equal(stilb_gpu_read_begin(gpu, stilb_engine_plan(engine), s.sums, 0, 0, &ticket), STILB_OK);
		assert_int_equal(stilb_gpu_read_get(gpu, ticket, true, &bytes, &frame), STILB_OK);
		assert_int_equal(frame, f);
		double sum = 0.0, want = 0.0;
		for (uint32_t g = 0; g < s.groups[0] * s.groups[1]; g++)
			sum += (double)((const float *)bytes)[g];
		stilb_gpu_read_end(gpu, ticket);
		float *light = pixels(engine, "light.exr");
		for (uint32_t p = 0; p < WIDTH * HEIGHT; p++)
			want += (double)bright_of(light + (size_t)3 * p);
		free(light);
		assert_true(want > 1.0 && fabs(sum - want) < 1e-4 * want);
	}
	close_engine(engine);
}

static void what_is_wrong_is_said(void **state)
{
	(void)state;
	stages s;
	stilb_engine *engine = open_engine(1, STILB_RENDER_OUTPUT_DISPLAY);
	make_programs(engine, &s);
	add(engine, &s, STILB_RENDER_STAGE_LIGHT, add_light);
	static const struct {
		bool small;
		stilb_gpu_format format;
		stilb_result fails, result;
		const char *says;
	} rows[] = {
		{true, STILB_GPU_RGBA16_F, STILB_OK, STILB_ERROR_ARGUMENT, "in the place of 'color', which is 67x41 of format"},
		{false, STILB_GPU_RGBA8_U, STILB_OK, STILB_ERROR_ARGUMENT, "rgba16_f; give one like it"},
		{false, STILB_GPU_RGBA16_F, STILB_ERROR_FILE, STILB_ERROR_FILE, "no film in the camera"},
	};
	for (size_t r = 0; r < sizeof rows / sizeof *rows; r++) {
		s.count = 0;
		s.small = rows[r].small;
		s.format = rows[r].format;
		s.result = rows[r].fails;
		assert_int_equal(draw(engine), rows[r].result);
		if (!strstr(stilb_error_message(), rows[r].says))
			fail_msg("%s", stilb_error_message());
		assert_int_equal(stilb_engine_screenshot(engine, "none.png"), STILB_ERROR_DEVICE);
		s = (stages){.photograph = s.photograph, .meter = s.meter, .format = STILB_GPU_RGBA16_F};
		assert_int_equal(draw(engine), STILB_OK);
	}
	stilb_engine_remove_feature(engine, &s);
	stilb_render_feature feature = {STILB_RENDER_STAGE_FIRST, add_first, &s};
	for (uint32_t f = 0; f < STILB_ENGINE_MAX_FEATURES; f++)
		assert_int_equal(stilb_engine_add_feature(engine, &feature), STILB_OK);
	stilb_result result = STILB_OK;
	for (uint32_t f = STILB_ENGINE_MAX_FEATURES; f < STILB_RENDER_MAX_FEATURES && result == STILB_OK; f++)
		result = stilb_engine_add_feature(engine, &feature); /* what the engine does not need, a program may have */
	assert_int_equal(result, STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "features already"));
	stilb_engine_remove_feature(engine, &s);
	assert_int_equal(draw(engine), STILB_OK);
	close_engine(engine);
}

/* What a frame shows of an image; to be freed. */
static float *shown_pixels(stilb_engine *engine, const char *name, float low, float high)
{
	stilb_engine_show_image(engine, &(stilb_render_shown){.name = name, .low = low, .high = high});
	if (draw(engine) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return pixels(engine, "shown.exr");
}

/* Any image of the plan in the place of the picture, its values from low to high. */
static void images_are_shown(void **state)
{
	(void)state;
	for (uint32_t samples = 1; samples <= 4; samples += 3) {
		stilb_engine *engine = open_engine(samples, STILB_RENDER_OUTPUT_LINEAR);
		assert_int_equal(draw(engine), STILB_OK);
		float *plain = pixels(engine, "plain.exr");
		float *color = shown_pixels(engine, "color", 0.1f, 0.6f);
		for (uint32_t i = 0; i < 3 * WIDTH * HEIGHT; i++)
			assert_true(fabsf(color[i] - fminf(fmaxf((plain[i] - 0.1f) / 0.5f, 0.0f), 1.0f)) < 2e-3f);
		float *depth = shown_pixels(engine, "depth", 0.0f, 0.0f);
		uint32_t far = 0, near = 0;
		for (uint32_t p = 0; p < WIDTH * HEIGHT; p++) {
			const float *d = depth + (size_t)3 * p;
			assert_true(d[0] == d[1] && d[1] == d[2] && d[0] < 1.0f);
			far += d[0] == 0.0f;
			near += d[0] > 0.0f;
		}
		assert_true(far > 100 && near > 100);
		float *same = shown_pixels(engine, "picture", 0.0f, 0.5f); /* is shown anyway */
		assert_memory_equal(same, plain, sizeof *plain * 3 * WIDTH * HEIGHT);
		if (samples > 1)
			free(shown_pixels(engine, "color samples", 0.0f, 1.0f));
		stilb_engine_show_image(engine, &(stilb_render_shown){.name = "bump"});
		assert_int_equal(draw(engine), STILB_ERROR_ARGUMENT);
		assert_non_null(strstr(stilb_error_message(), "no image 'bump' to show; this frame has picture, color, depth"));
		assert_non_null(strstr(stilb_error_message(), ", shaded, lod"));
		stilb_engine_show_image(engine, &(stilb_render_shown){.name = "color", .mip = 3});
		assert_int_equal(draw(engine), STILB_ERROR_ARGUMENT);
		assert_non_null(strstr(stilb_error_message(), "has 1 mips and 1 layers; there is no mip 3, layer 0"));
		stilb_engine_show_image(engine, NULL);
		assert_int_equal(draw(engine), STILB_OK);
		free(plain);
		free(color);
		free(depth);
		free(same);
		close_engine(engine);
	}
}

/* Draws a frame in which this was typed. */
static void type(stilb_engine *engine, uint32_t character)
{
	stilb_window_state state = {.width = WIDTH, .height = HEIGHT, .typed = {character}, .typed_count = 1};
	assert_int_equal(stilb_engine_input(engine, &state), STILB_OK);
	assert_int_equal(draw(engine), STILB_OK);
}

/* i and I go through the images of the plan, around its end; a line tells which is shown. */
static void keys_show_images(void **state)
{
	(void)state;
	static const char *const names[] = {"color", "depth", "", "color", "", "depth", "color", ""};
	static const char typed[] = "iiiiIIII"; /* after "color" back to the picture, and around */
	stilb_engine *engine = open_engine(1, STILB_RENDER_OUTPUT_DISPLAY);
	assert_int_equal(draw(engine), STILB_OK);
	stilb_image plain = {0}, shown = {0};
	assert_int_equal(stilb_render_read_image(engine->render, &plain), STILB_OK);
	for (size_t k = 0; typed[k]; k++) {
		type(engine, (uint32_t)typed[k]);
		assert_string_equal(engine->image, names[k]);
		assert_int_equal(engine->overlay.caption_open, names[k][0] != '\0');
		assert_int_equal(stilb_render_read_image(engine->render, &shown), STILB_OK);
		bool same = memcmp(plain.pixels, shown.pixels, stilb_image_size(&plain)) == 0;
		assert_int_equal(same, names[k][0] == '\0');
		stilb_image_finish(&shown);
	}
	char line[128];
	type(engine, 'I');
	snprintf(line, sizeof line, "depth, %u x %u d32_f, mip 0 of 1, layer 0 of 1, 0..1", (uint32_t)WIDTH,
	         (uint32_t)HEIGHT);
	assert_string_equal(engine->caption, line);
	stilb_image_finish(&plain);
	close_engine(engine);
}

/* Two mips and two layers, each of one red: .2, .4, .6, .8 by mip, then by layer. */
static stilb_result add_quarters(void *user, stilb_gpu_plan *plan, uint16_t *image)
{
	(void)image;
	uint32_t draws;
	stilb_engine *engine = user;
	stilb_result result = stilb_render_add_draws(engine->render, &(stilb_gpu_draws){0}, &draws);
	stilb_gpu_plan_image_row row = {.name = "a quarter",
	                                .format = STILB_GPU_R32_F,
	                                .width = 8,
	                                .height = 8,
	                                .mips = 2,
	                                .layers = 2,
	                                .output = true};
	uint16_t made = stilb_gpu_plan_image(plan, &row);
	for (uint32_t part = 0; part < 4; part++)
		stilb_gpu_plan_pass(plan, &(stilb_gpu_pass){.name = "paint",
		                                            .kind = STILB_GPU_PASS_DRAWS,
		                                            .draws = draws,
		                                            .color = {{.image = made,
		                                                       .mip = (uint8_t)(part % 2),
		                                                       .layer = (uint16_t)(part / 2),
		                                                       .load = STILB_GPU_LOAD_CLEAR,
		                                                       .clear = {0.2f * (float)(part + 1)}}},
		                                            .color_count = 1});
	return result;
}

/* u and U go through the mips and layers of the image that is shown, and nothing else. */
static void keys_show_mips(void **state)
{
	(void)state;
	static const char typed[] = "uUIuuuuUU"; /* of the picture there is no part; "a quarter" is the last image */
	static const int parts[] = {-1, -1, 0, 1, 2, 3, 0, 3, 2};
	stilb_engine *engine = open_engine(1, STILB_RENDER_OUTPUT_LINEAR);
	stilb_render_feature feature = {STILB_RENDER_STAGE_FIRST, add_quarters, engine};
	assert_int_equal(stilb_engine_add_feature(engine, &feature), STILB_OK);
	assert_int_equal(draw(engine), STILB_OK);
	for (size_t k = 0; typed[k]; k++) {
		type(engine, (uint32_t)typed[k]);
		assert_string_equal(engine->image, parts[k] < 0 ? "" : "a quarter");
		if (parts[k] < 0)
			continue;
		char line[128];
		snprintf(line, sizeof line, "a quarter, 8 x 8 r32_f, mip %d of 2, layer %d of 2, 0..1", parts[k] % 2,
		         parts[k] / 2);
		assert_string_equal(engine->caption, line);
		float *shown = pixels(engine, "shown.exr"); /* the line stands in the middle of so small a picture */
		assert_true(fabsf(shown[3 * (HEIGHT - 1) * WIDTH] - 0.2f * (float)(parts[k] + 1)) < 1e-3f);
		free(shown);
	}
	close_engine(engine);
}

/* What keys have chosen may be missing in a later frame: that shows the picture. */
static void an_optional_image(void **state)
{
	(void)state;
	stilb_engine *engine = open_engine(1, STILB_RENDER_OUTPUT_DISPLAY);
	stilb_engine_show_image(engine, &(stilb_render_shown){.name = "bump", .optional = true});
	assert_int_equal(draw(engine), STILB_OK);
	close_engine(engine);
}

static void the_plan_as_a_file(void **state)
{
	(void)state;
	stages s;
	char text[4096];
	stilb_engine *engine = open_engine(1, STILB_RENDER_OUTPUT_DISPLAY);
	make_programs(engine, &s);
	assert_int_equal(stilb_engine_save_plan(engine, "none.svg"), STILB_ERROR_ARGUMENT);
	add(engine, &s, STILB_RENDER_STAGE_LIGHT, add_light);
	assert_int_equal(draw(engine), STILB_OK);
	static const char *const names[2] = {"plan.svg", "plan.txt"};
	static const char *const begins[2] = {"<svg ", "picture 67 x 41, 3 passes"};
	for (int f = 0; f < 2; f++) {
		assert_int_equal(stilb_engine_save_plan(engine, names[f]), STILB_OK);
		FILE *file = fopen(names[f], "r");
		assert_non_null(file);
		text[fread(text, 1, sizeof text - 1, file)] = '\0';
		fclose(file);
		assert_int_equal(strncmp(text, begins[f], strlen(begins[f])), 0);
		assert_non_null(strstr(text, "photograph"));
	}
	assert_int_equal(stilb_engine_save_plan(engine, "/nowhere/plan.svg"), STILB_ERROR_FILE);
	close_engine(engine);
}

static int make_scene(void **state)
{
	return folder_make(state) != 0 || stilb_scene_create_stress(200, 3, &scene) != STILB_OK;
}

static int drop_scene(void **state)
{
	(void)state;
	stilb_scene_destroy(scene);
	folder_clear();
	return folder_remove();
}

int main(void)
{
	stilb_gpu_listed one;
	uint32_t count;
	if (stilb_gpu_list(&one, 1, &count) != STILB_OK || count == 0) {
		printf("skipped: no Vulkan driver (apt install mesa-vulkan-drivers)\n");
		return 77;
	}
	struct CMUnitTest tests[] = {
		cmocka_unit_test(an_effect_on_the_light),
		cmocka_unit_test(stages_come_in_their_order),
		cmocka_unit_test(an_effect_on_light_of_another_size),
		cmocka_unit_test(a_dispatch_and_its_result),
		cmocka_unit_test(what_is_wrong_is_said),
		cmocka_unit_test(images_are_shown),
		cmocka_unit_test(keys_show_images),
		cmocka_unit_test(keys_show_mips),
		cmocka_unit_test(an_optional_image),
		cmocka_unit_test(the_plan_as_a_file),
	};
	return cmocka_run_group_tests(tests, make_scene, drop_scene);
}
