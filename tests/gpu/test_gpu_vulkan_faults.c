/* The Vulkan device when things go wrong, under validation: each allocation of device memory fails once, and what
 * failed is done again; the device is lost with each of some frames; and the picture's size changes in every state that
 * a frame can be in. */
#include "gpu/gpu_internal.h"
#include "support/test.h"

#include <stdlib.h>
#include <string.h>
#include <vulkan/vulkan.h>

static const uint32_t mix_frag[] =
#include "mix.frag.inc"
	;

/* ---- what is alive (linked with --wrap) -------------------------------------------------------------------------- */

static int alive; /* buffers, images, views and blocks of memory */

/* Counts what a function makes. */
#define WRAP_MAKE(function, info, object)                                                                              \
	VkResult __real_##function(VkDevice, const info *, const VkAllocationCallbacks *, object *);                       \
	VkResult __wrap_##function(VkDevice, const info *, const VkAllocationCallbacks *, object *);                       \
	VkResult __wrap_##function(VkDevice device, const info *i, const VkAllocationCallbacks *a, object *o)              \
	{                                                                                                                  \
		VkResult result = __real_##function(device, i, a, o);                                                          \
		alive += result == VK_SUCCESS;                                                                                 \
		return result;                                                                                                 \
	}
#define WRAP_DROP(function, object)                                                                                    \
	void __real_##function(VkDevice, object, const VkAllocationCallbacks *);                                           \
	void __wrap_##function(VkDevice, object, const VkAllocationCallbacks *);                                           \
	void __wrap_##function(VkDevice device, object o, const VkAllocationCallbacks *a)                                  \
	{                                                                                                                  \
		alive -= o != VK_NULL_HANDLE;                                                                                  \
		__real_##function(device, o, a);                                                                               \
	}
WRAP_MAKE(vkCreateBuffer, VkBufferCreateInfo, VkBuffer)
WRAP_DROP(vkDestroyBuffer, VkBuffer)
WRAP_MAKE(vkCreateImage, VkImageCreateInfo, VkImage)
WRAP_DROP(vkDestroyImage, VkImage)
WRAP_MAKE(vkCreateImageView, VkImageViewCreateInfo, VkImageView)
WRAP_DROP(vkDestroyImageView, VkImageView)
WRAP_MAKE(vkAllocateMemory, VkMemoryAllocateInfo, VkDeviceMemory)
WRAP_DROP(vkFreeMemory, VkDeviceMemory)

/* ---- a run of frames --------------------------------------------------------------------------------------------- */

#define WORDS 16u
#define FRAMES 7u
#define MOST_TEXELS 300u

static const uint32_t sizes[][2] = {{8, 8}, {33, 9}, {1, 1}, {64, 3}, {5, 7}};

/* A run of frames, and what they must give. */
static struct {
	stilb_gpu *gpu;
	stilb_gpu_plan *plan;
	stilb_gpu_program mix;
	stilb_gpu_image own; /* 4 x 4 */
	uint32_t words[WORDS];
	uint32_t width, height;
	uint32_t history[MOST_TEXELS];
	uint16_t ids[3]; /* history, resolved, copied */
	uint32_t failed; /* calls that had no memory */
	bool lost;
} w;

/* True if a call has done what it should. A failure is one of memory, after which it is called again, or the device is
 * lost, which ends all. */
static bool done(stilb_result result)
{
	w.failed += result == STILB_ERROR_MEMORY;
	w.lost |= result == STILB_ERROR_DEVICE_LOST;
	if (result != STILB_OK && result != STILB_ERROR_MEMORY && result != STILB_ERROR_DEVICE_LOST)
		fail_msg("%s", stilb_error_message());
	assert_true(w.failed < 2);
	return result == STILB_OK;
}

static void open_all(stilb_gpu_faults faults)
{
	memset(&w, 0, sizeof w);
	stilb_gpu_desc desc = {.validate = true, .upload_bytes = 65536, .faults = faults};
	while (!done(stilb_gpu_create(&desc, &w.gpu))) {
		assert_null(w.gpu);
		assert_int_equal(alive, 0);
		desc.faults.allocation = 0; /* it counts from the device's start */
	}
	w.plan = stilb_gpu_plan_create();
	assert_non_null(w.plan);
	stilb_gpu_program_desc program = {
		.name = "mix", .fragment = {.words = mix_frag, .bytes = sizeof mix_frag}, .samplers = 2};
	assert_int_equal(stilb_gpu_program_create(w.gpu, &program, &w.mix), STILB_OK);
	stilb_gpu_image_desc image = {
		.name = "own",
		.extent = {.format = STILB_GPU_R32_UI,
	               .width = 4,
	               .height = 4,
	               .depth = 1,
	               .layers = 1,
	               .mips = 1,
	               .samples = 1,
	               .uses = 1u << STILB_GPU_USE_COPY_FROM | 1u << STILB_GPU_USE_COPY_TO | 1u << STILB_GPU_USE_SAMPLED}};
	while (!done(stilb_gpu_image_create(w.gpu, &image, &w.own)))
		assert_int_equal(w.own.id, 0);
}

static void close_all(void)
{
	if (!w.lost)
		assert_int_equal(stilb_gpu_wait(w.gpu), STILB_OK);
	assert_int_equal(w.gpu->validation_messages, 0);
	stilb_gpu_plan_destroy(w.plan);
	stilb_gpu_destroy(w.gpu);
	assert_int_equal(alive, 0);
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

static void add_rows(uint32_t number)
{
	stilb_gpu_plan_begin(w.plan, w.width, w.height);
	uint16_t samples = stilb_gpu_plan_image(
		w.plan,
		&(stilb_gpu_plan_image_row){.name = "samples", .format = STILB_GPU_RGBA8_U, .scale = 1.0f, .samples = 4});
	/* In some frames another image is made while the history stays. */
	uint16_t resolved = stilb_gpu_plan_image(
		w.plan,
		&(stilb_gpu_plan_image_row){
			.name = number % 5 == 1 ? "one" : "other", .format = STILB_GPU_RGBA8_U, .scale = 1.0f, .output = true});
	uint16_t own = stilb_gpu_plan_image(
		w.plan, &(stilb_gpu_plan_image_row){
					.name = "own", .format = STILB_GPU_R32_UI, .width = 4, .height = 4, .owned = w.own.id});
	uint16_t copied = stilb_gpu_plan_buffer(
		w.plan, &(stilb_gpu_plan_buffer_row){.name = "copied", .bytes = sizeof w.words, .output = true});
	uint16_t history = stilb_gpu_plan_image(
		w.plan, &(stilb_gpu_plan_image_row){
					.name = "history", .format = STILB_GPU_R32_UI, .scale = 1.0f, .keep = true, .output = true});
	if (!stilb_gpu_plan_kept(w.plan, history))
		memset(w.history, 0, sizeof w.history);
	stilb_gpu_pass mix = {.name = "mix",
	                      .kind = STILB_GPU_PASS_FULLSCREEN,
	                      .color = {{.image = history, .load = STILB_GPU_LOAD_DISCARD}},
	                      .color_count = 1,
	                      .uses = {{.resource = history, .how = STILB_GPU_USE_SAMPLED, .previous = true},
	                               {.resource = history, .how = STILB_GPU_USE_SAMPLED, .previous = true, .slot = 1}},
	                      .use_count = 2,
	                      .constant_bytes = 4,
	                      .program = w.mix.id};
	memcpy(mix.constants, &number, sizeof number);
	stilb_gpu_plan_pass(w.plan, &mix);
	stilb_gpu_attachment color = {.image = samples, .resolve = resolved, .load = STILB_GPU_LOAD_CLEAR};
	color.clear[0] = (float)(number % 256) / 255.0f;
	stilb_gpu_plan_pass(
		w.plan, &(stilb_gpu_pass){.name = "clear", .kind = STILB_GPU_PASS_DRAWS, .color = {color}, .color_count = 1});
	stilb_gpu_plan_pass(w.plan, &(stilb_gpu_pass){.name = "copy",
	                                              .kind = STILB_GPU_PASS_COPY,
	                                              .uses = {{.resource = own, .how = STILB_GPU_USE_COPY_FROM},
	                                                       {.resource = copied, .how = STILB_GPU_USE_COPY_TO}},
	                                              .use_count = 2});
	w.ids[0] = history;
	w.ids[1] = resolved;
	w.ids[2] = copied;
}

/* What the pass "mix" makes of the history. */
static void model_mix(uint32_t number)
{
	for (uint32_t t = 0; t < w.width * w.height; t++) {
		uint32_t hash = (number ^ w.history[t]) * 16777619u;
		hash = (hash ^ w.history[t]) * 16777619u;
		w.history[t] = (hash ^ (t % w.width + 97 * (t / w.width))) * 16777619u;
	}
}

static bool plan_make(uint32_t number)
{
	add_rows(number);
	stilb_gpu_planner planner = stilb_gpu_planner_of(w.gpu);
	return done(stilb_gpu_plan_make(w.plan, &planner));
}

/* One frame, and again until it has run; false: the device is lost. */
static bool run_frame(uint32_t number)
{
	static const stilb_gpu_draws nothing;
	while (!w.lost) {
		if (!done(stilb_gpu_frame_begin(w.gpu)) || !plan_make(number))
			continue;
		if (done(stilb_gpu_frame_run(w.gpu, w.plan, &nothing, 1, NULL))) {
			model_mix(number);
			return true;
		}
		stilb_gpu_plan_dropped(w.plan);
	}
	return false;
}

/* ---- results ----------------------------------------------------------------------------------------------------- */

static void begin_reads(uint64_t tickets[3])
{
	for (uint32_t i = 0; i < 3; i++)
		while (!done(stilb_gpu_read_begin(w.gpu, w.plan, w.ids[i], 0, 0, &tickets[i])))
			assert_int_equal(tickets[i], 0);
}

static void check_reads(const uint64_t tickets[3], uint32_t number, uint32_t texels, const uint32_t *history)
{
	const void *bytes[3];
	uint64_t frame;
	for (uint32_t i = 0; i < 3; i++) {
		assert_int_equal(stilb_gpu_read_get(w.gpu, tickets[i], true, &bytes[i], &frame), STILB_OK);
		assert_non_null(bytes[i]);
	}
	assert_memory_equal(bytes[0], history, texels * sizeof *history);
	for (uint32_t t = 0; t < texels; t++)
		assert_int_equal(((const uint32_t *)bytes[1])[t], number % 256);
	assert_memory_equal(bytes[2], w.words, sizeof w.words);
	for (uint32_t i = 0; i < 3; i++)
		stilb_gpu_read_end(w.gpu, tickets[i]);
}

static uint32_t *begin_upload(uint32_t number)
{
	void *bytes = NULL;
	stilb_gpu_upload upload = {.image = w.own, .width = 4, .height = 4, .depth = 1, .bytes = sizeof w.words};
	assert_int_equal(stilb_gpu_upload_begin(w.gpu, &upload, &bytes), STILB_OK);
	assert_non_null(bytes);
	for (uint32_t i = 0; i < WORDS; i++)
		w.words[i] = 1000 * number + i;
	return bytes;
}

static void resize(uint32_t number)
{
	w.width = sizes[number % 5][0];
	w.height = sizes[number % 5][1];
}

/* Frames of changing sizes. The size changes before a frame, while an upload is under way, after a plan was made that
 * does not run, after rows were added, and while results are read back. */
static void run_frames(void)
{
	uint32_t history[MOST_TEXELS];
	for (uint32_t number = 1; number <= FRAMES; number++) {
		uint32_t *upload = begin_upload(number);
		if (number % 5 != 1) /* the first stays one frame longer */
			resize(number / 2);
		memcpy(upload, w.words, sizeof w.words);
		stilb_gpu_upload_end(w.gpu, upload);
		memcpy(history, w.history, sizeof history);
		if (number % 5 == 2 && plan_make(number)) {
			stilb_gpu_plan_dropped(w.plan);
			resize(number / 2 + 1);
		}
		if (number % 5 == 3) {
			add_rows(number);
			resize(number / 2 + 2);
		}
		memcpy(w.history, history, sizeof history); /* no frame has run */
		if (!run_frame(number))
			return;
		uint64_t tickets[3];
		begin_reads(tickets);
		uint32_t texels = w.width * w.height;
		memcpy(history, w.history, sizeof history);
		if (number % 5 == 4) {
			uint32_t words[WORDS];
			memcpy(words, w.words, sizeof words);
			resize(number);
			if (!run_frame(number + 100))
				return;
			memcpy(w.words, words, sizeof words);
		}
		check_reads(tickets, number, texels, history);
		assert_int_equal(w.gpu->validation_messages, 0);
	}
}

static void each_allocation_fails(void **state)
{
	(void)state;
	uint32_t n = 1;
	for (;; n++) {
		open_all((stilb_gpu_faults){.allocation = n});
		resize(0);
		run_frames();
		uint32_t failed = w.failed;
		close_all();
		if (failed == 0)
			break;
	}
	assert_in_range(n, 20, 100);
}

static void each_frame_is_the_last(void **state)
{
	(void)state;
	for (uint32_t n = 1; n <= FRAMES; n += 3) {
		open_all((stilb_gpu_faults){.lost_frame = n});
		resize(0);
		run_frames();
		assert_true(w.lost);
		begin_upload(0); /* is never ended */
		close_all();
	}
}

int main(void)
{
	setenv("GALLIVM_PERF", "nopt", 0); /* Mesa's software device compiles shaders in half the time */
	const struct CMUnitTest tests[] = {cmocka_unit_test(each_allocation_fails),
	                                   cmocka_unit_test(each_frame_is_the_last)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
