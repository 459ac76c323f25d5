/* Shaders that take the place of others, on the null device: which programs get them, which are refused, when the old
 * ones go, and all of it beside frames, from several threads. */
#include "gpu/gpu_internal.h"
#include "replace_shaders.h"
#include "support/test.h"

#include <pthread.h>
#include <string.h>

static stilb_gpu *gpu;
static stilb_gpu_plan *plan;

static int open_null(void **state)
{
	(void)state;
	stilb_gpu_desc desc = {.kind = STILB_GPU_KIND_NULL, .upload_bytes = 4096};
	assert_int_equal(stilb_gpu_create(&desc, &gpu), STILB_OK);
	plan = stilb_gpu_plan_create();
	assert_non_null(plan);
	return 0;
}

static int close_null(void **state)
{
	(void)state;
	stilb_gpu_plan_destroy(plan);
	stilb_gpu_destroy(gpu);
	return 0;
}

static void a_frame(void)
{
	stilb_gpu_planner planner = stilb_gpu_planner_of(gpu);
	assert_int_equal(stilb_gpu_frame_begin(gpu), STILB_OK);
	stilb_gpu_plan_begin(plan, 64, 64);
	assert_int_equal(stilb_gpu_plan_make(plan, &planner), STILB_OK);
	assert_int_equal(stilb_gpu_frame_run(gpu, plan, NULL, 0, NULL), STILB_OK);
}

static stilb_gpu_program_desc fullscreen(void)
{
	return (stilb_gpu_program_desc){.name = "value",
	                                .fragment = SHADER_OF(quarter_frag, FRAG),
	                                .constant_count = 2,
	                                .constants = {{3, 0x3f800000}, {4, 7}}};
}

static stilb_gpu_program made(stilb_gpu_program_desc desc)
{
	stilb_gpu_program program;
	assert_int_equal(stilb_gpu_program_create(gpu, &desc, &program), STILB_OK);
	return program;
}

/* The words that a program has of a stage. */
static bool has(stilb_gpu_program program, int stage, const uint32_t *words, size_t bytes)
{
	const gpu_program *entry = gpu_program_of(gpu, program.id);
	return entry->code[stage].bytes == bytes && memcmp(entry->code[stage].words, words, bytes) == 0;
}
#define HAS(program, stage, code) assert_true(has(program, stage, code, sizeof code))

static uint32_t replace(const stilb_gpu_shader *shaders, uint32_t count)
{
	uint32_t programs = 99;
	if (stilb_gpu_shaders_replace(gpu, shaders, count, &programs) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return programs;
}

static void from_the_next_frame_on(void **state)
{
	(void)state;
	stilb_gpu_shader half = SHADER_OF(half_frag, FRAG), quarter = SHADER_OF(quarter_frag, FRAG);
	stilb_gpu_program_desc desc = fullscreen(), other = fullscreen();
	other.fragment.source = "other.frag";
	stilb_gpu_program a = made(desc), b = made(desc), c = made(other);
	a_frame();
	assert_int_equal(replace(&half, 1), 2);
	HAS(a, GPU_STAGE_FRAGMENT, quarter_frag);
	assert_int_equal(stilb_gpu_frame_begin(gpu), STILB_OK);
	HAS(a, GPU_STAGE_FRAGMENT, half_frag);
	HAS(b, GPU_STAGE_FRAGMENT, half_frag);
	HAS(c, GPU_STAGE_FRAGMENT, quarter_frag);
	stilb_gpu_program later = made(desc); /* what the build gave it is out of date */
	HAS(later, GPU_STAGE_FRAGMENT, half_frag);
	assert_int_equal(replace(&quarter, 1), 3);
	assert_int_equal(replace(&half, 1), 3); /* before a frame saw the one before */
	assert_int_equal(replace(&quarter, 1), 3);
	a_frame();
	HAS(later, GPU_STAGE_FRAGMENT, quarter_frag);
	assert_string_equal(stilb_gpu_shader_source(gpu, 0), "gpu/shaders/fullscreen.vert");
	assert_string_equal(stilb_gpu_shader_source(gpu, 1), FRAG);
	assert_string_equal(stilb_gpu_shader_source(gpu, 2), "other.frag");
	assert_null(stilb_gpu_shader_source(gpu, 3));
	stilb_gpu_program_destroy(gpu, a);
	assert_int_equal(replace(&half, 1), 2);
}

/* What programs were before is there until no frame can use it, and no longer. */
static void old_ones_go(void **state)
{
	(void)state;
	stilb_gpu_shader half = SHADER_OF(half_frag, FRAG), quarter = SHADER_OF(quarter_frag, FRAG);
	stilb_gpu_program a = made(fullscreen());
	const gpu_table *table = &gpu->tables[GPU_PROGRAM];
	for (int round = 0; round < 10; round++) {
		a_frame();
		replace(round % 2 == 0 ? &half : &quarter, 1);
		assert_int_equal(table->used, 2);
		a_frame(); /* while the device may still draw the frame before */
		assert_int_equal(table->used, 2);
		a_frame();
		assert_int_equal(table->used, 1);
	}
	assert_true(table->count <= 3);
	replace(&half, 1);
	stilb_gpu_program_destroy(gpu, a); /* while another waits for its place */
	for (int frame = 0; frame < 4; frame++)
		a_frame();
	assert_int_equal(table->used, 0);
}

/* All shaders of a call or none: a fragment shader that reads what only the new vertex shader writes. */
static void together(void **state)
{
	(void)state;
	stilb_gpu_program_desc desc = {
		.name = "both", .vertex = SHADER_OF(plain_vert, VERT), .fragment = SHADER_OF(quarter_frag, FRAG)};
	stilb_gpu_shader both[2] = {SHADER_OF(place_frag, FRAG), SHADER_OF(place_vert, VERT)};
	stilb_gpu_program program = made(desc), screen = made(fullscreen());
	uint32_t programs = 99;
	assert_int_equal(stilb_gpu_shaders_replace(gpu, both, 1, &programs), STILB_ERROR_ARGUMENT);
	assert_int_equal(programs, 0);
	assert_int_equal(stilb_gpu_shaders_replace(gpu, both, 2, NULL), STILB_ERROR_ARGUMENT); /* `screen` has no place */
	stilb_gpu_program_destroy(gpu, screen);
	assert_int_equal(replace(both, 2), 1);
	a_frame();
	HAS(program, GPU_STAGE_VERTEX, place_vert);
	HAS(program, GPU_STAGE_FRAGMENT, place_frag);
	assert_int_equal(stilb_gpu_shaders_replace(gpu, &desc.vertex, 1, NULL), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "location 2, which its vertex shader does not write"));
	/* A program that what has taken its shader's place does not fit gets its own. */
	stilb_gpu_program lone = made(fullscreen());
	HAS(lone, GPU_STAGE_FRAGMENT, quarter_frag);
}

static void that_do_not_fit(void **state)
{
	(void)state;
	stilb_gpu_program_desc desc = {.name = "area",
	                               .vertex = SHADER_OF(plain_vert, VERT),
	                               .fragment = SHADER_OF(quarter_frag, "area.frag"),
	                               .vertex_bytes = 8,
	                               .input_count = 1,
	                               .inputs = {{.location = 0, .format = STILB_GPU_RG32_F}}};
	stilb_gpu_program a = made(fullscreen());
	made(desc);
	for (size_t i = 0; i < REPLACE_WRONG; i++) {
		assert_int_equal(stilb_gpu_shaders_replace(gpu, &replace_wrong[i].shader, 1, NULL), STILB_ERROR_ARGUMENT);
		if (!strstr(stilb_error_message(), replace_wrong[i].says))
			fail_msg("'%s' does not say '%s'", stilb_error_message(), replace_wrong[i].says);
		assert_non_null(strstr(stilb_error_message(), "program 'value'"));
	}
	static const struct {
		stilb_gpu_shader shader;
		const char *says;
	} vertex[2] = {{SHADER_OF(input_vert, VERT), "reads location 5, which its vertices do not have"},
	               {SHADER_OF(integer_vert, VERT), "location 0 is an integer in its vertex shader"}};
	for (int i = 0; i < 2; i++) {
		assert_int_equal(stilb_gpu_shaders_replace(gpu, &vertex[i].shader, 1, NULL), STILB_ERROR_ARGUMENT);
		if (!strstr(stilb_error_message(), vertex[i].says))
			fail_msg("'%s' does not say '%s'", stilb_error_message(), vertex[i].says);
	}
	a_frame();
	HAS(a, GPU_STAGE_FRAGMENT, quarter_frag);
	assert_int_equal(gpu->tables[GPU_PROGRAM].used, 2);
	HAS(made(fullscreen()), GPU_STAGE_FRAGMENT, quarter_frag);
}

/* A thread compiles one of the programs: it and all that change with it stay until it is done; so does what is
 * destroyed meanwhile. */
static void pinned(void **state)
{
	(void)state;
	stilb_gpu_shader half = SHADER_OF(half_frag, FRAG);
	stilb_gpu_program a = made(fullscreen()), b = made(fullscreen());
	gpu_program *entry = gpu_program_of(gpu, b.id);
	entry->pins++;
	replace(&half, 1);
	a_frame();
	HAS(a, GPU_STAGE_FRAGMENT, quarter_frag);
	HAS(b, GPU_STAGE_FRAGMENT, quarter_frag);
	entry->pins--;
	a_frame();
	HAS(a, GPU_STAGE_FRAGMENT, half_frag);
	HAS(b, GPU_STAGE_FRAGMENT, half_frag);
	for (int frame = 0; frame < 3; frame++)
		a_frame();
	entry->pins++;
	stilb_gpu_program_destroy(gpu, b);
	for (int frame = 0; frame < 4; frame++)
		a_frame();
	assert_int_equal(gpu->tables[GPU_PROGRAM].used, 2);
	entry->pins--;
	a_frame();
	assert_int_equal(gpu->tables[GPU_PROGRAM].used, 1);
}

/* Two replacements between two frames: a program gets both. */
static void stage_by_stage(void **state)
{
	(void)state;
	stilb_gpu_program_desc desc = {
		.name = "both", .vertex = SHADER_OF(plain_vert, VERT), .fragment = SHADER_OF(quarter_frag, FRAG)};
	stilb_gpu_shader vertex = SHADER_OF(place_vert, VERT), fragment = SHADER_OF(place_frag, FRAG);
	stilb_gpu_program program = made(desc);
	assert_int_equal(replace(&vertex, 1), 1);
	assert_int_equal(replace(&fragment, 1), 1);
	a_frame();
	HAS(program, GPU_STAGE_VERTEX, place_vert);
	HAS(program, GPU_STAGE_FRAGMENT, place_frag);
}

/* A shader is replaced while a program is made of it: that is made again, of the new one. */
static stilb_result (*null_make)(stilb_gpu *device, gpu_program *program);
static uint32_t makes;

static stilb_result make_late(stilb_gpu *device, gpu_program *program)
{
	stilb_gpu_shader half = SHADER_OF(half_frag, FRAG);
	if (makes++ == 0)
		assert_int_equal(replace(&half, 1), 0);
	return null_make(device, program);
}

static void while_it_is_made(void **state)
{
	(void)state;
	const gpu_functions *before = gpu->functions;
	gpu_functions functions = *before;
	null_make = before->program_make;
	functions.program_make = make_late;
	gpu->functions = &functions;
	makes = 0;
	HAS(made(fullscreen()), GPU_STAGE_FRAGMENT, half_frag);
	assert_int_equal(makes, 2);
	gpu->functions = before;
}

/* ---- several threads --------------------------------------------------------------------------------------------- */

typedef struct work {
	uint32_t rounds;
	stilb_gpu_program shared;
	stilb_result worst;
	atomic_bool ended; /* release when the thread is done, acquire by the main thread */
} work;

static void *replacing(void *user)
{
	work *w = user;
	stilb_gpu_shader shaders[3] = {SHADER_OF(half_frag, FRAG), SHADER_OF(quarter_frag, FRAG),
	                               SHADER_OF(binding_frag, FRAG)};
	for (uint32_t r = 0; r < w->rounds; r++) {
		stilb_result result = stilb_gpu_shaders_replace(gpu, &shaders[r % 3], 1, NULL);
		if ((result == STILB_OK) != (r % 3 < 2))
			w->worst = STILB_ERROR_ARGUMENT;
	}
	atomic_store_explicit(&w->ended, true, memory_order_release); /* see ended */
	return NULL;
}

static void *making(void *user)
{
	work *w = user;
	stilb_gpu_format color = STILB_GPU_RGBA8_U;
	stilb_gpu_program_desc desc = fullscreen();
	for (uint32_t r = 0; r < w->rounds; r++) {
		stilb_gpu_program program;
		stilb_result result = stilb_gpu_program_create(gpu, &desc, &program);
		if (result == STILB_OK)
			result = stilb_gpu_program_prepare(gpu, program, &color, 1, STILB_GPU_NONE, 1);
		if (result == STILB_OK)
			result = stilb_gpu_program_prepare(gpu, w->shared, &color, 1, STILB_GPU_NONE, 1);
		w->worst = result != STILB_OK ? result : w->worst;
		stilb_gpu_program_destroy(gpu, program);
	}
	atomic_store_explicit(&w->ended, true, memory_order_release); /* see ended */
	return NULL;
}

static void beside_frames(void **state)
{
	(void)state;
	enum { THREADS = 4 };
	pthread_t threads[THREADS];
	work works[THREADS];
	stilb_gpu_program shared = made(fullscreen());
	for (int t = 0; t < THREADS; t++) {
		works[t] = (work){.rounds = TEST_TSAN ? 200 : 2000, .shared = shared};
		assert_int_equal(pthread_create(&threads[t], NULL, t < 2 ? replacing : making, &works[t]), 0);
	}
	for (int t = 0; t < THREADS; t++)
		while (!atomic_load_explicit(&works[t].ended, memory_order_acquire)) /* see ended */
			a_frame();
	for (int t = 0; t < THREADS; t++) {
		pthread_join(threads[t], NULL);
		assert_int_equal(works[t].worst, STILB_OK);
	}
	stilb_gpu_shader half = SHADER_OF(half_frag, FRAG);
	assert_int_equal(replace(&half, 1), 1);
	for (int frame = 0; frame < 4; frame++)
		a_frame();
	HAS(shared, GPU_STAGE_FRAGMENT, half_frag);
	assert_int_equal(gpu->tables[GPU_PROGRAM].used, 1);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup_teardown(from_the_next_frame_on, open_null, close_null),
		cmocka_unit_test_setup_teardown(old_ones_go, open_null, close_null),
		cmocka_unit_test_setup_teardown(together, open_null, close_null),
		cmocka_unit_test_setup_teardown(that_do_not_fit, open_null, close_null),
		cmocka_unit_test_setup_teardown(pinned, open_null, close_null),
		cmocka_unit_test_setup_teardown(stage_by_stage, open_null, close_null),
		cmocka_unit_test_setup_teardown(while_it_is_made, open_null, close_null),
		cmocka_unit_test_setup_teardown(beside_frames, open_null, close_null),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
