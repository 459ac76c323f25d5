/* Shaders that take the place of others, on the Vulkan device under validation: what frames show, while earlier ones
 * are in flight and from another thread, where pipelines are compiled, and that old ones are destroyed. */
#include "gpu/gpu_internal.h"
#include "replace_shaders.h"
#include "support/test.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <vulkan/vulkan.h>

#define SIDE 16u

static stilb_gpu *gpu;
static stilb_gpu_plan *plan;
static _Atomic uint32_t pipelines_made, pipelines_there; /* relaxed: counters; read when no other thread counts */

VkResult __real_vkCreateGraphicsPipelines(VkDevice device, VkPipelineCache cache, uint32_t count,
                                          const VkGraphicsPipelineCreateInfo *infos,
                                          const VkAllocationCallbacks *allocator, VkPipeline *pipelines);
VkResult __wrap_vkCreateGraphicsPipelines(VkDevice device, VkPipelineCache cache, uint32_t count,
                                          const VkGraphicsPipelineCreateInfo *infos,
                                          const VkAllocationCallbacks *allocator, VkPipeline *pipelines);
void __real_vkDestroyPipeline(VkDevice device, VkPipeline pipeline, const VkAllocationCallbacks *allocator);
void __wrap_vkDestroyPipeline(VkDevice device, VkPipeline pipeline, const VkAllocationCallbacks *allocator);

VkResult __wrap_vkCreateGraphicsPipelines(VkDevice device, VkPipelineCache cache, uint32_t count,
                                          const VkGraphicsPipelineCreateInfo *infos,
                                          const VkAllocationCallbacks *allocator, VkPipeline *pipelines)
{
	VkResult result = __real_vkCreateGraphicsPipelines(device, cache, count, infos, allocator, pipelines);
	atomic_fetch_add_explicit(&pipelines_made, result == VK_SUCCESS, memory_order_relaxed);  /* see pipelines_made */
	atomic_fetch_add_explicit(&pipelines_there, result == VK_SUCCESS, memory_order_relaxed); /* see pipelines_made */
	return result;
}

void __wrap_vkDestroyPipeline(VkDevice device, VkPipeline pipeline, const VkAllocationCallbacks *allocator)
{
	atomic_fetch_sub_explicit(&pipelines_there, pipeline != VK_NULL_HANDLE, memory_order_relaxed); /* likewise */
	__real_vkDestroyPipeline(device, pipeline, allocator);
}

static uint32_t counted(_Atomic uint32_t *counter)
{
	return atomic_load_explicit(counter, memory_order_relaxed); /* see pipelines_made */
}

static int open_device(void **state)
{
	(void)state;
	stilb_gpu_desc desc = {.validate = true, .upload_bytes = 1 << 20};
	if (stilb_gpu_create(&desc, &gpu) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	plan = stilb_gpu_plan_create();
	assert_non_null(plan);
	atomic_store_explicit(&pipelines_made, 0, memory_order_relaxed); /* see pipelines_made */
	return 0;
}

static int close_device(void **state)
{
	(void)state;
	assert_int_equal(stilb_gpu_validation_messages(gpu), 0);
	stilb_gpu_plan_destroy(plan);
	stilb_gpu_destroy(gpu);
	assert_int_equal(counted(&pipelines_there), 0);
	return 0;
}

static stilb_gpu_program_desc fullscreen(float scale)
{
	stilb_gpu_program_desc desc = {
		.name = "value", .fragment = SHADER_OF(quarter_frag, FRAG), .constant_count = 2, .constants = {{3, 0}, {4, 0}}};
	memcpy(&desc.constants[0].value, &scale, sizeof scale);
	return desc;
}

static stilb_gpu_program made(stilb_gpu_program_desc desc)
{
	stilb_gpu_program program;
	if (stilb_gpu_program_create(gpu, &desc, &program) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return program;
}

/* Draws a frame: one image of each format, by two programs. *tickets: of what is drawn; nothing waits. */
static void a_frame(stilb_gpu_program a, stilb_gpu_program b, uint64_t tickets[2])
{
	stilb_gpu_planner planner = stilb_gpu_planner_of(gpu);
	const stilb_gpu_program programs[2] = {a, b};
	uint16_t images[2];
	assert_int_equal(stilb_gpu_frame_begin(gpu), STILB_OK);
	stilb_gpu_plan_begin(plan, SIDE, SIDE);
	for (int i = 0; i < 2; i++) {
		images[i] =
			stilb_gpu_plan_image(plan, &(stilb_gpu_plan_image_row){.name = i == 0 ? "a" : "b",
		                                                           .format = i == 0 ? STILB_GPU_R32_F : STILB_GPU_R16_F,
		                                                           .scale = 1.0f,
		                                                           .output = true});
		stilb_gpu_plan_pass(
			plan, &(stilb_gpu_pass){.name = "value",
		                            .kind = STILB_GPU_PASS_FULLSCREEN,
		                            .color = {{.image = images[i], .load = STILB_GPU_LOAD_CLEAR, .clear = {9.0f}}},
		                            .color_count = 1,
		                            .program = programs[i].id});
	}
	if (stilb_gpu_plan_make(plan, &planner) != STILB_OK || stilb_gpu_frame_run(gpu, plan, NULL, 0, NULL) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	for (int i = 0; i < 2; i++)
		assert_int_equal(stilb_gpu_read_begin(gpu, plan, images[i], 0, 0, &tickets[i]), STILB_OK);
}

static float half_value(uint16_t bits)
{
	return ldexpf((float)(1024 + (bits & 1023)), (int)(bits >> 10) - 25); /* positive, normal */
}

/* The value that all texels of a read-back have. */
static float value_of(uint64_t ticket, bool half)
{
	const void *bytes;
	uint64_t frame;
	assert_int_equal(stilb_gpu_read_get(gpu, ticket, true, &bytes, &frame), STILB_OK);
	float first = 0.0f;
	for (uint32_t i = 0; i < SIDE * SIDE; i++) {
		float value = half ? half_value(((const uint16_t *)bytes)[i]) : ((const float *)bytes)[i];
		first = i == 0 ? value : first;
		assert_true(value == first);
	}
	stilb_gpu_read_end(gpu, ticket);
	return first;
}

static void replace(stilb_gpu_shader shader, uint32_t expected)
{
	uint32_t programs = 99;
	if (stilb_gpu_shaders_replace(gpu, &shader, 1, &programs) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(programs, expected);
}

/* Frames that were handed over before show the old shader, those after it the new one, at the scale that each program
 * was specialised with; and no frame compiles. */
static void frames_in_flight(void **state)
{
	(void)state;
	stilb_gpu_shader shaders[2] = {SHADER_OF(quarter_frag, FRAG), SHADER_OF(half_frag, FRAG)};
	stilb_gpu_program one = made(fullscreen(1.0f)), two = made(fullscreen(2.0f));
	uint64_t tickets[8][2];
	a_frame(one, two, tickets[0]);
	assert_int_equal(counted(&pipelines_made), 2);
	for (int round = 1; round < 8; round++) {
		replace(shaders[round % 2], 2);
		uint32_t compiled = counted(&pipelines_made);
		assert_int_equal(compiled, 2 + 2 * round);
		a_frame(one, two, tickets[round]);
		assert_int_equal(counted(&pipelines_made), compiled);
		assert_in_range(counted(&pipelines_there), 2, 6);
	}
	for (int round = 0; round < 8; round++) {
		float expected = round % 2 == 0 ? 0.25f : 0.5f;
		assert_true(value_of(tickets[round][0], false) == expected);
		assert_true(value_of(tickets[round][1], true) == 2.0f * expected);
	}
	for (int frame = 0; frame < 3; frame++) {
		a_frame(one, two, tickets[0]);
		value_of(tickets[0][0], false);
		value_of(tickets[0][1], true);
	}
	assert_int_equal(counted(&pipelines_there), 2);
	/* A program that is made later is made of the new shader: what it was built with is out of date. */
	stilb_gpu_program later = made(fullscreen(0.5f));
	a_frame(later, two, tickets[0]);
	assert_true(value_of(tickets[0][0], false) == 0.25f);
}

static void that_do_not_fit(void **state)
{
	(void)state;
	stilb_gpu_program one = made(fullscreen(1.0f)), two = made(fullscreen(2.0f));
	uint64_t tickets[2];
	a_frame(one, two, tickets);
	for (size_t i = 0; i < REPLACE_WRONG; i++) {
		assert_int_equal(stilb_gpu_shaders_replace(gpu, &replace_wrong[i].shader, 1, NULL), STILB_ERROR_ARGUMENT);
		assert_non_null(strstr(stilb_error_message(), replace_wrong[i].says));
		a_frame(one, two, tickets);
		assert_true(value_of(tickets[0], false) == 0.25f);
		assert_true(value_of(tickets[1], true) == 0.5f);
	}
	assert_int_equal(counted(&pipelines_made), 2);
}

/* The device's own vertex shader of fullscreen passes, too. */
static void fullscreen_vertices(void **state)
{
	(void)state;
	stilb_gpu_program one = made(fullscreen(1.0f));
	stilb_gpu_shader vertices = SHADER_OF(plain_vert, "gpu/shaders/fullscreen.vert");
	uint64_t tickets[2];
	a_frame(one, one, tickets);
	replace(vertices, 1);
	a_frame(one, one, tickets);
	assert_true(value_of(tickets[0], false) == 0.25f);
	assert_int_equal(counted(&pipelines_made), 4);
}

static atomic_bool stop; /* relaxed: orders nothing else */

static void *replacing(void *user)
{
	(void)user;
	stilb_gpu_shader shaders[2] = {SHADER_OF(quarter_frag, FRAG), SHADER_OF(half_frag, FRAG)};
	uint32_t rounds = 0;
	for (; !atomic_load_explicit(&stop, memory_order_relaxed); rounds++) /* see stop */
		if (stilb_gpu_shaders_replace(gpu, &shaders[rounds % 2], 1, NULL) != STILB_OK)
			return NULL;
	return rounds > 1 ? user : NULL;
}

static void beside_frames(void **state)
{
	(void)state;
	pthread_t thread;
	void *good;
	stilb_gpu_program one = made(fullscreen(1.0f)), two = made(fullscreen(1.0f));
	uint32_t seen[2] = {0}, frames = TEST_ASAN ? 40 : 200;
	assert_int_equal(pthread_create(&thread, NULL, replacing, &seen), 0);
	for (uint32_t frame = 0; frame < frames; frame++) {
		uint64_t tickets[2];
		a_frame(one, two, tickets);
		float a = value_of(tickets[0], false), b = value_of(tickets[1], true);
		assert_true((a == 0.25f || a == 0.5f) && b == a); /* all programs in the same frame */
		seen[a == 0.5f]++;
	}
	atomic_store_explicit(&stop, true, memory_order_relaxed); /* see stop */
	pthread_join(thread, &good);
	assert_non_null(good);
	assert_true(seen[0] > 0 && seen[1] > 0);
	for (int frame = 0; frame < 4; frame++) {
		uint64_t tickets[2];
		a_frame(one, two, tickets);
		value_of(tickets[0], false);
		value_of(tickets[1], true);
	}
	assert_int_equal(counted(&pipelines_there), 2);
}

int main(void)
{
	setenv("GALLIVM_PERF", "nopt", 0); /* Mesa's software device compiles shaders in half the time */
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup_teardown(frames_in_flight, open_device, close_device),
		cmocka_unit_test_setup_teardown(that_do_not_fit, open_device, close_device),
		cmocka_unit_test_setup_teardown(fullscreen_vertices, open_device, close_device),
		cmocka_unit_test_setup_teardown(beside_frames, open_device, close_device),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
