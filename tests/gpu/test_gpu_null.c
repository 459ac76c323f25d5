/* The null device: rules, lifetimes, uploads from several threads, and 100,000 images. */
#include "gpu/gpu_internal.h"
#include "support/test.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#define SAMPLED (1u << STILB_GPU_USE_SAMPLED)
#define COPY_TO (1u << STILB_GPU_USE_COPY_TO)
#define STORAGE (1u << STILB_GPU_USE_STORAGE)

static const uint32_t sum_comp[] =
#include "sum.comp.inc"
	;
static const uint32_t uniforms_comp[] =
#include "uniforms.comp.inc"
	;
static const uint32_t depth_frag[] =
#include "depth_to_color.frag.inc"
	;
static const uint32_t textured_frag[] =
#include "textured.frag.inc"
	;
static const uint32_t scene_vert[] =
#include "scene.vert.inc"
	;
static const uint32_t mix_comp[] =
#include "mix.comp.inc"
	;

#define SHADER(code)                                                                                                   \
	{                                                                                                                  \
		.words = code, .bytes = sizeof code                                                                            \
	}

static stilb_gpu *gpu;

static int open_null(void **state)
{
	(void)state;
	stilb_gpu_desc desc = {.kind = STILB_GPU_KIND_NULL, .upload_bytes = 4096};
	assert_int_equal(stilb_gpu_create(&desc, &gpu), STILB_OK);
	return 0;
}

static int close_null(void **state)
{
	(void)state;
	stilb_gpu_destroy(gpu);
	gpu = NULL;
	return 0;
}

static stilb_gpu_extent extent(stilb_gpu_format format, uint32_t side, uint32_t uses)
{
	return (stilb_gpu_extent){.format = format,
	                          .width = side,
	                          .height = side,
	                          .depth = 1,
	                          .layers = 1,
	                          .mips = 1,
	                          .samples = 1,
	                          .uses = (uint16_t)uses};
}

static void assert_says(stilb_result result, const char *word)
{
	assert_int_equal(result, STILB_ERROR_ARGUMENT);
	if (!strstr(stilb_error_message(), word))
		fail_msg("'%s' does not say '%s'", stilb_error_message(), word);
}

/* ---- rules ------------------------------------------------------------------------------------------------------- */

static void images_that_cannot_be(void **state)
{
	(void)state;
	struct {
		stilb_gpu_extent extent;
		const char *says;
	} rows[24];
	uint32_t count = 0;
	stilb_gpu_extent e = extent(STILB_GPU_RGBA8_U, 4, SAMPLED);
#define ROW(change, words)                                                                                             \
	do {                                                                                                               \
		rows[count].extent = e;                                                                                        \
		stilb_gpu_extent *x = &rows[count].extent;                                                                     \
		change;                                                                                                        \
		rows[count++].says = words;                                                                                    \
	} while (0)
	ROW(x->format = STILB_GPU_NONE, "format 0");
	ROW(x->format = STILB_GPU_FORMAT_COUNT, "no such format");
	ROW(x->width = 0, "may be 0");
	ROW(x->layers = 0, "may be 0");
	ROW(x->width = 16385, "16384 a side; make it smaller");
	ROW(x->layers = 2049, "up to 2048; use several images");
	ROW(x->depth = 2, "only images of shape 3D");
	ROW(x->mips = 4, "at most 3");
	ROW(x->uses = 0, "uses 0");
	ROW(x->samples = 3, "3 samples");
	ROW(x->samples = 8, "8 samples");
	ROW((x->samples = 4, x->mips = 2), "have 1 mip");
	ROW((x->samples = 4, x->uses = STORAGE), "cannot be a storage image");
	ROW((x->format = STILB_GPU_D32_F, x->uses = STORAGE), "d32_f cannot be a storage image");
	ROW((x->format = STILB_GPU_D32_F_S8, x->uses = SAMPLED), "d32_f_s8 cannot be sampled");
	ROW((x->format = STILB_GPU_BC1_U, x->uses = STILB_GPU_EXTENT_ATTACHMENT), "bc1_u cannot be drawn into");
	ROW((x->shape = STILB_GPU_SHAPE_CUBE), "cubes are square");
	ROW((x->shape = STILB_GPU_SHAPE_1D), "height 1");
	ROW((x->shape = STILB_GPU_SHAPE_3D, x->uses = STILB_GPU_EXTENT_ATTACHMENT), "3D cannot be drawn into");
	ROW((x->shape = STILB_GPU_SHAPE_3D, x->format = STILB_GPU_D32_F), "depth images are 2D");
#undef ROW
	for (uint32_t i = 0; i < count; i++) {
		stilb_gpu_image image = {1};
		stilb_gpu_image_desc desc = {.name = "shadow", .extent = rows[i].extent};
		assert_says(stilb_gpu_image_create(gpu, &desc, &image), rows[i].says);
		assert_non_null(strstr(stilb_error_message(), "image 'shadow'"));
		assert_int_equal(image.id, 0);
	}
	stilb_gpu_memory_report report = stilb_gpu_memory_measure(gpu);
	assert_int_equal(report.allocations, 1); /* the ring */
}

static stilb_result program_of(stilb_gpu_program_desc desc)
{
	stilb_gpu_program program;
	desc.name = "test";
	stilb_result result = stilb_gpu_program_create(gpu, &desc, &program);
	stilb_gpu_program_destroy(gpu, program);
	return result;
}

static void programs_that_cannot_be(void **state)
{
	(void)state;
	static const uint32_t nonsense[] = {1, 2, 3, 4, 5, 6};
	uint32_t cut[64];
	memcpy(cut, sum_comp, sizeof cut);
	assert_int_equal(program_of((stilb_gpu_program_desc){.compute = SHADER(sum_comp), .samplers = 1}), STILB_OK);
	assert_says(program_of((stilb_gpu_program_desc){.compute = SHADER(sum_comp)}), "binding 0 of set 0");
	assert_says(program_of((stilb_gpu_program_desc){.compute = SHADER(sum_comp), .storage_images = 1}),
	            "binding 0 of set 0");
	assert_int_equal(
		program_of((stilb_gpu_program_desc){.compute = SHADER(mix_comp), .samplers = 2, .storage_images = 1}),
		STILB_OK);
	assert_says(program_of((stilb_gpu_program_desc){.compute = SHADER(mix_comp), .samplers = 3}), "binding 2 of set 0");
	assert_int_equal(program_of((stilb_gpu_program_desc){.compute = SHADER(uniforms_comp), .uniforms = 2}), STILB_OK);
	assert_says(program_of((stilb_gpu_program_desc){.compute = SHADER(uniforms_comp), .uniforms = 1}),
	            "binding 1 of set 0");
	assert_says(program_of((stilb_gpu_program_desc){.compute = SHADER(uniforms_comp), .samplers = 2}),
	            "binding 0 of set 0");
	assert_says(program_of((stilb_gpu_program_desc){.compute = SHADER(uniforms_comp), .uniforms = 13}),
	            "13 uniform buffers: 'null' has up to 12");
	assert_says(program_of((stilb_gpu_program_desc){.compute = SHADER(nonsense)}), "no SPIR-V");
	stilb_gpu_shader broken = {.words = cut, .bytes = sizeof cut};
	cut[5] = 0; /* an instruction of no words */
	assert_says(program_of((stilb_gpu_program_desc){.compute = broken, .samplers = 1}), "no SPIR-V");
	assert_says(program_of((stilb_gpu_program_desc){0}), "no shader");
	assert_says(program_of((stilb_gpu_program_desc){.compute = SHADER(sum_comp), .fragment = SHADER(depth_frag)}),
	            "beside others");
	assert_says(program_of((stilb_gpu_program_desc){.fragment = SHADER(textured_frag), .vertex = SHADER(scene_vert)}),
	            "binding 0 of set 1");
	/* More samplers than a stage has: Mesa's software driver would crash. */
	assert_says(program_of((stilb_gpu_program_desc){.fragment = SHADER(depth_frag), .samplers = 33}),
	            "33 sampled images: 'null' has up to 32; use layers");
	stilb_gpu_program_desc input = {.vertex = SHADER(scene_vert),
	                                .vertex_bytes = 12,
	                                .input_count = 1,
	                                .inputs = {{.location = 1, .format = STILB_GPU_R32_F, .offset = 12}}};
	assert_says(program_of(input), "outside of the 12 bytes");
	stilb_gpu_program_desc count = {.vertex = SHADER(scene_vert),
	                                .vertex_bytes = 12,
	                                .input_count = 2,
	                                .inputs = {{.location = 0, .format = STILB_GPU_RG32_F},
	                                           {.location = 1, .format = STILB_GPU_R32_F, .offset = 8}},
	                                .depth = STILB_GPU_COMPARE_GREATER,
	                                .stencil = STILB_GPU_STENCIL_COUNT};
	assert_int_equal(program_of(count), STILB_OK);
	gpu->limits.counts = false;
	assert_says(program_of(count), "depthClamp");
	gpu->limits.counts = true;
	count.depth_write = true;
	assert_says(program_of(count), "stencil 1: there are 0..2");
	count.stencil = 3;
	assert_says(program_of(count), "stencil 3: there are 0..2");
	gpu->limits.group_invocations = 32;
	assert_says(program_of((stilb_gpu_program_desc){.compute = SHADER(sum_comp), .samplers = 1}), "64 invocations");
}

/* A damaged shader is refused or taken, and never read past its end. */
static void damaged_shaders(void **state)
{
	(void)state;
	uint64_t seed = 1;
	uint32_t refused = 0, rounds = TEST_TSAN ? 200 : 20000;
	for (uint32_t round = 0; round < rounds; round++) {
		size_t words = 5 + stilb_random_u64(seed, 3 * round) % (sizeof mix_comp / 4 - 5);
		uint32_t *copy = malloc(words * sizeof *copy);
		assert_non_null(copy);
		memcpy(copy, mix_comp, words * sizeof *copy);
		copy[stilb_random_u64(seed, 3 * round + 1) % words] =
			(uint32_t)stilb_random_u64(seed, 3 * round + 2) & 0x1fffff;
		stilb_gpu_shader shader = {.words = copy, .bytes = words * sizeof *copy};
		gpu_spirv found;
		refused += !gpu_spirv_read(&shader, &found);
		free(copy);
	}
	assert_true(refused > rounds / 10);
}

static void samplers_are_kept(void **state)
{
	(void)state;
	stilb_gpu_sampler first, again, other;
	stilb_gpu_sampler_desc desc = {.linear = true, .wrap = {1, 1, 1}};
	assert_int_equal(stilb_gpu_sampler_get(gpu, &(stilb_gpu_sampler_desc){0}, &first), STILB_OK);
	assert_int_equal(first.id, 0);
	assert_int_equal(stilb_gpu_sampler_get(gpu, &desc, &first), STILB_OK);
	assert_int_equal(stilb_gpu_sampler_get(gpu, &desc, &again), STILB_OK);
	assert_int_equal(first.id, 1);
	assert_int_equal(again.id, 1);
	desc.anisotropy = 17.0f;
	assert_says(stilb_gpu_sampler_get(gpu, &desc, &other), "anisotropy 17");
	for (uint32_t i = 2; i < 256; i++) {
		desc.anisotropy = 1.0f + (float)i / 64.0f;
		assert_int_equal(stilb_gpu_sampler_get(gpu, &desc, &other), STILB_OK);
	}
	desc.anisotropy = 15.0f;
	assert_says(stilb_gpu_sampler_get(gpu, &desc, &other), "255 samplers");
}

/* ---- lifetimes --------------------------------------------------------------------------------------------------- */

static void a_frame(stilb_gpu_plan *plan)
{
	assert_int_equal(stilb_gpu_frame_begin(gpu), STILB_OK);
	stilb_gpu_plan_begin(plan, 64, 64);
	stilb_gpu_planner planner = stilb_gpu_planner_of(gpu);
	assert_int_equal(stilb_gpu_plan_make(plan, &planner), STILB_OK);
	assert_int_equal(stilb_gpu_frame_run(gpu, plan, NULL, 0, NULL), STILB_OK);
}

static void destroyed_when_no_frame_uses_it(void **state)
{
	(void)state;
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	stilb_gpu_buffer buffer, next;
	stilb_gpu_buffer_desc desc = {.name = "b", .bytes = 1000, .uses = STILB_GPU_BUFFER_COPY};
	a_frame(plan);
	assert_int_equal(stilb_gpu_buffer_create(gpu, &desc, &buffer), STILB_OK);
	assert_null(stilb_gpu_buffer_mapped(gpu, buffer));
	stilb_gpu_buffer_destroy(gpu, buffer);
	assert_null(gpu_buffer_of(gpu, buffer.id)); /* its id is no longer valid, and its memory still is */
	assert_int_equal(stilb_gpu_memory_measure(gpu).allocations, 2);
	a_frame(plan);
	assert_int_equal(stilb_gpu_memory_measure(gpu).allocations, 2);
	a_frame(plan);
	assert_int_equal(stilb_gpu_memory_measure(gpu).allocations, 1);
	assert_int_equal(stilb_gpu_buffer_create(gpu, &desc, &next), STILB_OK);
	assert_true(next.id != buffer.id);
	assert_null(gpu_buffer_of(gpu, buffer.id));
	stilb_gpu_buffer_destroy(gpu, (stilb_gpu_buffer){0});
	stilb_gpu_plan_destroy(plan);
}

static void a_hundred_thousand_images(void **state)
{
	(void)state;
	enum { COUNT = TEST_TSAN || TEST_ASAN ? 5000 : 100000 };
	static stilb_gpu_image images[COUNT];
	for (uint32_t i = 0; i < COUNT; i++) {
		stilb_gpu_image_desc desc = {.name = "many", .extent = extent(STILB_GPU_BC7_U, 4u << i % 7, SAMPLED | COPY_TO)};
		assert_int_equal(stilb_gpu_image_create(gpu, &desc, &images[i]), STILB_OK);
	}
	stilb_gpu_memory_report report = stilb_gpu_memory_measure(gpu);
	assert_int_equal(report.allocations, COUNT + 1);
	assert_true(report.blocks < 32 && report.used_bytes <= report.block_bytes);
	for (uint32_t i = 0; i < COUNT; i++)
		stilb_gpu_image_destroy(gpu, images[(i * 7919u) % COUNT]);
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	for (int i = 0; i < 3; i++)
		a_frame(plan);
	assert_int_equal(stilb_gpu_memory_measure(gpu).allocations, 1);
	stilb_gpu_plan_destroy(plan);
}

static void each_allocation_fails(void **state)
{
	(void)state;
	for (uint32_t n = 1; n < 5; n++) {
		stilb_gpu *failing;
		stilb_gpu_desc desc = {.kind = STILB_GPU_KIND_NULL, .faults.allocation = n};
		stilb_result result = stilb_gpu_create(&desc, &failing);
		if (n == 1) {
			assert_int_equal(result, STILB_ERROR_MEMORY);
			assert_null(failing);
			continue;
		}
		assert_int_equal(result, STILB_OK);
		stilb_gpu_buffer buffers[4];
		for (uint32_t b = 2; b < 5; b++) {
			stilb_gpu_buffer_desc wanted = {.name = "b", .bytes = 16, .uses = STILB_GPU_BUFFER_COPY};
			result = stilb_gpu_buffer_create(failing, &wanted, &buffers[b - 2]);
			assert_int_equal(result, b == n ? STILB_ERROR_MEMORY : STILB_OK);
			assert_int_equal(buffers[b - 2].id == 0, b == n);
		}
		stilb_gpu_destroy(failing);
	}
}

/* ---- uploads ----------------------------------------------------------------------------------------------------- */

static void uploads_that_cannot_be(void **state)
{
	(void)state;
	void *bytes;
	stilb_gpu_buffer buffer;
	stilb_gpu_image image;
	stilb_gpu_buffer_desc desc = {.name = "b", .bytes = 100, .uses = STILB_GPU_BUFFER_COPY};
	stilb_gpu_image_desc image_desc = {.name = "i", .extent = extent(STILB_GPU_BC1_U, 16, SAMPLED | COPY_TO)};
	assert_int_equal(stilb_gpu_buffer_create(gpu, &desc, &buffer), STILB_OK);
	assert_int_equal(stilb_gpu_image_create(gpu, &image_desc, &image), STILB_OK);
	assert_int_equal(stilb_gpu_upload_most(gpu), 4096);
	assert_says(stilb_gpu_upload_begin(gpu, &(stilb_gpu_upload){.bytes = 4}, &bytes),
	            "goes to a buffer or to an image");
	assert_says(stilb_gpu_upload_begin(gpu, &(stilb_gpu_upload){.buffer = buffer, .offset = 96, .bytes = 8}, &bytes),
	            "bytes 96 + 8");
	stilb_gpu_upload to = {.image = image, .width = 16, .height = 16, .depth = 1, .bytes = 128};
	assert_int_equal(stilb_gpu_upload_begin(gpu, &to, &bytes), STILB_OK);
	stilb_gpu_upload_end(gpu, bytes);
	to.bytes = 100;
	assert_says(stilb_gpu_upload_begin(gpu, &to, &bytes), "are 128 bytes, not 100");
	to.x = 2;
	to.width = 4;
	assert_says(stilb_gpu_upload_begin(gpu, &to, &bytes), "whole blocks");
	to = (stilb_gpu_upload){.image = image, .mip = 1, .width = 16, .height = 16, .depth = 1, .bytes = 128};
	assert_says(stilb_gpu_upload_begin(gpu, &to, &bytes), "no mip 1");
}

#define THREADS 4u
#define EACH 200u

typedef struct uploader {
	stilb_gpu_buffer buffer;
	uint32_t number, waits;
	_Atomic bool *done;
} uploader;

/* Writes its part of the buffer word by word, in pieces of many sizes. */
static void *upload_words(void *context)
{
	uploader *up = context;
	for (uint32_t i = 0; i < EACH;) {
		uint32_t words = 1 + (i * 7 + up->number) % 60;
		words = words < EACH - i ? words : EACH - i;
		stilb_gpu_upload to = {.buffer = up->buffer,
		                       .offset = ((uint64_t)up->number * EACH + i) * sizeof(uint32_t),
		                       .bytes = words * sizeof(uint32_t)};
		void *bytes;
		if (stilb_gpu_upload_begin(gpu, &to, &bytes) != STILB_OK)
			abort();
		if (!bytes) {
			up->waits++;
			sched_yield();
			continue;
		}
		for (uint32_t w = 0; w < words; w++)
			((uint32_t *)bytes)[w] = 1 + up->number * EACH + i + w;
		stilb_gpu_upload_end(gpu, bytes);
		i += words;
	}
	atomic_store_explicit(up->done, true, memory_order_release); /* the main thread's loop ends by it */
	return NULL;
}

static void uploads_of_several_threads(void **state)
{
	(void)state;
	static uploader uploaders[THREADS];
	static _Atomic bool done[THREADS];
	pthread_t threads[THREADS];
	stilb_gpu_buffer buffer;
	stilb_gpu_buffer_desc desc = {.name = "words",
	                              .bytes = THREADS * EACH * sizeof(uint32_t),
	                              .memory = STILB_GPU_MEMORY_READ,
	                              .uses = STILB_GPU_BUFFER_COPY};
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	assert_int_equal(stilb_gpu_buffer_create(gpu, &desc, &buffer), STILB_OK);
	for (uint32_t t = 0; t < THREADS; t++) {
		uploaders[t] = (uploader){.buffer = buffer, .number = t, .done = &done[t]};
		assert_int_equal(pthread_create(&threads[t], NULL, upload_words, &uploaders[t]), 0);
	}
	/* Frames run meanwhile, and make and destroy other things. */
	uint64_t uploaded = 0;
	for (bool all = false; !all;) {
		all = true;
		for (uint32_t t = 0; t < THREADS; t++)
			all &= atomic_load_explicit(&done[t], memory_order_acquire); /* upload_words */
		stilb_gpu_buffer other;
		assert_int_equal(stilb_gpu_buffer_create(gpu, &desc, &other), STILB_OK);
		stilb_gpu_buffer_destroy(gpu, other);
		a_frame(plan);
		uploaded += stilb_gpu_stats_get(gpu).uploaded_bytes;
	}
	for (uint32_t t = 0; t < THREADS; t++)
		pthread_join(threads[t], NULL);
	a_frame(plan);
	uploaded += stilb_gpu_stats_get(gpu).uploaded_bytes;
	assert_int_equal(uploaded, desc.bytes);
	const uint32_t *words = stilb_gpu_buffer_mapped(gpu, buffer);
	for (uint32_t w = 0; w < THREADS * EACH; w++)
		assert_int_equal(words[w], w + 1);
	stilb_gpu_plan_destroy(plan);
}

static void *end_upload(void *bytes)
{
	memset(bytes, 7, 64);
	stilb_gpu_upload_end(gpu, bytes);
	return NULL;
}

/* The end of an upload alone tells the frame that its bytes are written. */
static void uploads_end_in_threads(void **state)
{
	(void)state;
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	stilb_gpu_buffer buffer;
	stilb_gpu_buffer_desc desc = {
		.name = "b", .bytes = 64, .memory = STILB_GPU_MEMORY_READ, .uses = STILB_GPU_BUFFER_COPY};
	assert_int_equal(stilb_gpu_buffer_create(gpu, &desc, &buffer), STILB_OK);
	for (uint32_t round = 0; round < 10; round++) {
		pthread_t thread;
		void *bytes = NULL;
		while (!bytes) {
			a_frame(plan);
			stilb_gpu_upload upload = {.buffer = buffer, .bytes = 64};
			assert_int_equal(stilb_gpu_upload_begin(gpu, &upload, &bytes), STILB_OK);
		}
		memset(stilb_gpu_buffer_mapped(gpu, buffer), 0, 64);
		assert_int_equal(pthread_create(&thread, NULL, end_upload, bytes), 0);
		do {
			a_frame(plan);
			sched_yield();
		} while (stilb_gpu_stats_get(gpu).uploaded_bytes == 0);
		for (uint32_t i = 0; i < 64; i++)
			assert_int_equal(((uint8_t *)stilb_gpu_buffer_mapped(gpu, buffer))[i], 7);
		pthread_join(thread, NULL);
	}
	stilb_gpu_plan_destroy(plan);
}

/* The ring gives no more than it has, begins again at its start, and an upload that has not ended keeps its place. */
static void the_ring_is_full(void **state)
{
	(void)state;
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	stilb_gpu_buffer buffer;
	stilb_gpu_buffer_desc desc = {
		.name = "b", .bytes = 5000, .memory = STILB_GPU_MEMORY_READ, .uses = STILB_GPU_BUFFER_COPY};
	assert_int_equal(stilb_gpu_buffer_create(gpu, &desc, &buffer), STILB_OK);
	void *first, *second, *third;
	stilb_gpu_upload large = {.buffer = buffer, .bytes = 3000}, small = {.buffer = buffer, .bytes = 1200};
	assert_int_equal(stilb_gpu_upload_begin(gpu, &large, &first), STILB_OK);
	assert_non_null(first);
	assert_int_equal(stilb_gpu_upload_begin(gpu, &small, &second), STILB_OK);
	assert_null(second); /* 4096 - 3008 = 1088 are left */
	small.bytes = 1000;
	assert_int_equal(stilb_gpu_upload_begin(gpu, &small, &second), STILB_OK);
	assert_non_null(second);
	stilb_gpu_upload_end(gpu, second); /* and the first has not ended */
	for (int i = 0; i < 4; i++)
		a_frame(plan);
	assert_int_equal(stilb_gpu_upload_begin(gpu, &small, &third), STILB_OK);
	assert_null(third);
	stilb_gpu_upload_end(gpu, first);
	a_frame(plan);
	assert_int_equal(stilb_gpu_stats_get(gpu).uploaded_bytes, 3000);
	assert_int_equal(stilb_gpu_upload_begin(gpu, &small, &third), STILB_OK);
	assert_null(third); /* that frame may still read it */
	a_frame(plan);
	a_frame(plan);
	assert_int_equal(stilb_gpu_upload_begin(gpu, &large, &third), STILB_OK);
	assert_ptr_equal(third, first);
	stilb_gpu_upload_end(gpu, third);
	assert_says(stilb_gpu_upload_begin(gpu, &(stilb_gpu_upload){.buffer = buffer, .bytes = 4097 + 3}, &third),
	            "the ring holds 4096");
	stilb_gpu_plan_destroy(plan);
}

/* A frame copies no more than it may, but always one upload; in order. */
static void uploads_of_a_frame(void **state)
{
	(void)state;
	static const uint32_t sizes[] = {600, 400, 4, 600, 2000, 4, 996, 4}, wanted[] = {1000, 604, 2000, 1000, 4, 0};
	stilb_gpu *bounded;
	stilb_gpu_desc desc = {.kind = STILB_GPU_KIND_NULL, .upload_bytes = 8192, .upload_frame = 1000};
	assert_int_equal(stilb_gpu_create(&desc, &bounded), STILB_OK);
	stilb_gpu *own = gpu;
	gpu = bounded;
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	stilb_gpu_buffer buffer;
	stilb_gpu_buffer_desc target = {
		.name = "b", .bytes = 5000, .memory = STILB_GPU_MEMORY_READ, .uses = STILB_GPU_BUFFER_COPY};
	assert_int_equal(stilb_gpu_buffer_create(gpu, &target, &buffer), STILB_OK);
	for (uint32_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
		void *bytes;
		stilb_gpu_upload to = {.buffer = buffer, .bytes = sizes[i]};
		assert_int_equal(stilb_gpu_upload_begin(gpu, &to, &bytes), STILB_OK);
		assert_non_null(bytes);
		memset(bytes, (int)i + 1, sizes[i]);
		stilb_gpu_upload_end(gpu, bytes);
	}
	for (uint32_t i = 0; i < sizeof wanted / sizeof *wanted; i++) {
		a_frame(plan);
		assert_int_equal(stilb_gpu_stats_get(gpu).uploaded_bytes, wanted[i]);
	}
	assert_int_equal(*(uint8_t *)stilb_gpu_buffer_mapped(gpu, buffer), 8);
	stilb_gpu_plan_destroy(plan);
	stilb_gpu_destroy(gpu);
	gpu = own;
}

/* More uploads than can be there at once wait until the frames that copied others are done. */
static void many_uploads(void **state)
{
	(void)state;
	stilb_gpu *own = gpu;
	stilb_gpu_desc desc = {.kind = STILB_GPU_KIND_NULL};
	assert_int_equal(stilb_gpu_create(&desc, &gpu), STILB_OK);
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	stilb_gpu_buffer buffer;
	stilb_gpu_buffer_desc target = {.name = "b", .bytes = 64, .uses = STILB_GPU_BUFFER_COPY};
	assert_int_equal(stilb_gpu_buffer_create(gpu, &target, &buffer), STILB_OK);
	stilb_gpu_upload to = {.buffer = buffer, .bytes = 16};
	uint32_t begun = 0;
	uint64_t copied = 0;
	for (uint32_t frame = 0; frame < 12; frame++) {
		for (void *bytes = gpu; bytes;) {
			assert_int_equal(stilb_gpu_upload_begin(gpu, &to, &bytes), STILB_OK);
			begun += bytes ? 1 : 0;
			if (bytes)
				stilb_gpu_upload_end(gpu, bytes);
		}
		assert_int_equal(begun,
		                 GPU_UPLOADS * (1 + frame / 3)); /* all go with a frame, and come back two frames later */
		a_frame(plan);
		copied += stilb_gpu_stats_get(gpu).uploaded_bytes;
		assert_int_equal(copied, begun * (uint64_t)16);
	}
	stilb_gpu_plan_destroy(plan);
	stilb_gpu_destroy(gpu);
	gpu = own;
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

static void passes_that_do_not_fit(void **state)
{
	(void)state;
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	stilb_gpu_planner planner = stilb_gpu_planner_of(gpu);
	stilb_gpu_program program;
	stilb_gpu_program_desc desc = {.name = "depth", .fragment = SHADER(depth_frag), .samplers = 1};
	assert_int_equal(stilb_gpu_program_create(gpu, &desc, &program), STILB_OK);
	for (int bound = 0; bound < 2; bound++) {
		stilb_gpu_plan_begin(plan, 8, 8);
		uint16_t depth = stilb_gpu_plan_image(
			plan, &(stilb_gpu_plan_image_row){.name = "depth", .format = STILB_GPU_D32_F, .scale = 1.0f});
		uint16_t out = stilb_gpu_plan_image(
			plan,
			&(stilb_gpu_plan_image_row){.name = "out", .format = STILB_GPU_R32_UI, .scale = 1.0f, .output = true});
		stilb_gpu_plan_pass(plan, &(stilb_gpu_pass){.name = "fill",
		                                            .kind = STILB_GPU_PASS_DRAWS,
		                                            .depth = {.image = depth, .load = STILB_GPU_LOAD_CLEAR}});
		stilb_gpu_plan_pass(plan, &(stilb_gpu_pass){.name = "show",
		                                            .kind = STILB_GPU_PASS_FULLSCREEN,
		                                            .color = {{.image = out, .load = STILB_GPU_LOAD_CLEAR}},
		                                            .color_count = 1,
		                                            .uses = {{.resource = depth, .how = STILB_GPU_USE_SAMPLED}},
		                                            .use_count = (uint8_t)bound,
		                                            .program = program.id});
		stilb_result result = stilb_gpu_plan_make(plan, &planner);
		if (bound == 0)
			assert_says(result, "are not those of its program (samplers)");
		else
			assert_int_equal(result, STILB_OK);
	}
	assert_int_equal(stilb_gpu_frame_begin(gpu), STILB_OK);
	assert_says(stilb_gpu_frame_run(gpu, plan, NULL, 0, NULL), "draws list 0 of 0");
	stilb_gpu_draws list = {0};
	assert_int_equal(stilb_gpu_frame_run(gpu, plan, &list, 1, NULL), STILB_OK);
	stilb_gpu_stats stats = stilb_gpu_stats_get(gpu);
	assert_int_equal(stats.passes, 2);
	assert_int_equal(stats.frame, 1);
	uint64_t ticket, frame;
	const void *bytes;
	assert_int_equal(stilb_gpu_read_begin(gpu, plan, 2, 0, 0, &ticket), STILB_OK);
	assert_int_equal(stilb_gpu_read_get(gpu, ticket, false, &bytes, &frame), STILB_OK);
	assert_non_null(bytes);
	assert_int_equal(frame, 1);
	stilb_gpu_read_end(gpu, ticket);
	assert_says(stilb_gpu_read_get(gpu, ticket, false, &bytes, &frame), "nothing is read back");
	assert_says(stilb_gpu_read_begin(gpu, plan, 1, 0, 0, &ticket), "no output");
	stilb_gpu_plan_destroy(plan);
}

/* A set with an image with which the plan does more than to sample it, in some way or in none. */
static void sets_of_what_plans_write(void **state)
{
	(void)state;
	static const struct {
		stilb_gpu_use_kind how;
		bool output, refused;
	} rows[] = {{STILB_GPU_USE_SAMPLED, false, false},
	            {STILB_GPU_USE_SAMPLED, true, true},
	            {STILB_GPU_USE_COPY_FROM, false, true},
	            {STILB_GPU_USE_COPY_TO, false, true}};
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	stilb_gpu_planner planner = stilb_gpu_planner_of(gpu);
	stilb_gpu_image image, other;
	stilb_gpu_extent e = extent(STILB_GPU_RGBA8_U, 8, SAMPLED | COPY_TO | 1u << STILB_GPU_USE_COPY_FROM);
	assert_int_equal(stilb_gpu_image_create(gpu, &(stilb_gpu_image_desc){.name = "i", .extent = e}, &image), STILB_OK);
	assert_int_equal(stilb_gpu_image_create(gpu, &(stilb_gpu_image_desc){.name = "o", .extent = e}, &other), STILB_OK);
	stilb_gpu_set set;
	assert_int_equal(stilb_gpu_set_create(gpu, &(stilb_gpu_set_item){.image = image}, 1, &set), STILB_OK);
	stilb_gpu_program program, shows;
	stilb_gpu_program_desc desc = {.name = "textured",
	                               .vertex = SHADER(scene_vert),
	                               .fragment = SHADER(textured_frag),
	                               .set_items = 1,
	                               .vertex_bytes = 12,
	                               .input_count = 2,
	                               .inputs = {{.location = 0, .format = STILB_GPU_RG32_F},
	                                          {.location = 1, .format = STILB_GPU_R32_F, .offset = 8}}};
	assert_int_equal(stilb_gpu_program_create(gpu, &desc, &program), STILB_OK);
	desc = (stilb_gpu_program_desc){.name = "shows", .fragment = SHADER(depth_frag), .samplers = 1};
	assert_int_equal(stilb_gpu_program_create(gpu, &desc, &shows), STILB_OK);
	stilb_gpu_buffer buffer;
	stilb_gpu_buffer_desc bytes = {.name = "b",
	                               .bytes = 64,
	                               .memory = STILB_GPU_MEMORY_SHARED,
	                               .uses = STILB_GPU_BUFFER_INDICES | STILB_GPU_BUFFER_VERTICES |
	                                       STILB_GPU_BUFFER_INDIRECT};
	assert_int_equal(stilb_gpu_buffer_create(gpu, &bytes, &buffer), STILB_OK);
	stilb_gpu_binding binding = {.program = program.id, .indices = buffer.id, .vertices = buffer.id, .index_bytes = 2};
	stilb_gpu_run run = {.count = 1, .set = set.id};
	stilb_gpu_draws list = {.commands = buffer, .bindings = &binding, .runs = &run, .binding_count = 1, .run_count = 1};
	for (uint32_t r = 0; r < sizeof rows / sizeof *rows; r++) {
		assert_int_equal(stilb_gpu_frame_begin(gpu), STILB_OK);
		stilb_gpu_plan_begin(plan, 8, 8);
		stilb_gpu_plan_image_row row = {.format = STILB_GPU_RGBA8_U, .width = 8, .height = 8};
		row.name = "texture", row.owned = image.id, row.output = rows[r].output;
		uint16_t texture = stilb_gpu_plan_image(plan, &row);
		row.name = "other", row.owned = other.id, row.output = false;
		uint16_t second = stilb_gpu_plan_image(plan, &row);
		row.name = "out", row.owned = 0, row.output = true;
		uint16_t out = stilb_gpu_plan_image(plan, &row);
		stilb_gpu_pass first = {.name = "first", .kind = STILB_GPU_PASS_COPY, .use_count = 2};
		bool to = rows[r].how == STILB_GPU_USE_COPY_TO;
		first.uses[0] = (stilb_gpu_use){.resource = to ? second : texture, .how = STILB_GPU_USE_COPY_FROM};
		first.uses[1] = (stilb_gpu_use){.resource = to ? texture : second, .how = STILB_GPU_USE_COPY_TO};
		stilb_gpu_load load = rows[r].how == STILB_GPU_USE_SAMPLED ? STILB_GPU_LOAD_KEEP : STILB_GPU_LOAD_CLEAR;
		if (rows[r].how == STILB_GPU_USE_SAMPLED)
			first = (stilb_gpu_pass){.name = "first",
			                         .kind = STILB_GPU_PASS_FULLSCREEN,
			                         .color = {{.image = out, .load = STILB_GPU_LOAD_CLEAR}},
			                         .color_count = 1,
			                         .uses = {{.resource = texture, .how = STILB_GPU_USE_SAMPLED}},
			                         .use_count = 1,
			                         .program = shows.id};
		stilb_gpu_plan_pass(plan, &first);
		stilb_gpu_plan_pass(plan, &(stilb_gpu_pass){.name = "draw",
		                                            .kind = STILB_GPU_PASS_DRAWS,
		                                            .color = {{.image = out, .load = (uint8_t)load}},
		                                            .color_count = 1});
		if (stilb_gpu_plan_make(plan, &planner) != STILB_OK)
			fail_msg("%s", stilb_error_message());
		stilb_result result = stilb_gpu_frame_run(gpu, plan, &list, 1, NULL);
		if (rows[r].refused)
			assert_says(result, "pass 'draw': item 0 of a run's set is image 'texture', which the plan writes");
		else
			assert_int_equal(result, STILB_OK);
	}
	stilb_gpu_plan_destroy(plan);
}

static void a_device_is_lost(void **state)
{
	(void)state;
	stilb_gpu *own = gpu;
	stilb_gpu_desc desc = {.kind = STILB_GPU_KIND_NULL, .faults.lost_frame = 2};
	assert_int_equal(stilb_gpu_create(&desc, &gpu), STILB_OK);
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	a_frame(plan);
	assert_int_equal(stilb_gpu_frame_begin(gpu), STILB_OK);
	assert_int_equal(stilb_gpu_frame_run(gpu, plan, NULL, 0, NULL), STILB_ERROR_DEVICE_LOST);
	stilb_gpu_plan_destroy(plan);
	stilb_gpu_destroy(gpu);
	gpu = own;
}

#define NULL_TEST(f) cmocka_unit_test_setup_teardown(f, open_null, close_null)

int main(void)
{
	struct CMUnitTest tests[] = {
		NULL_TEST(images_that_cannot_be),
		NULL_TEST(programs_that_cannot_be),
		NULL_TEST(damaged_shaders),
		NULL_TEST(samplers_are_kept),
		NULL_TEST(destroyed_when_no_frame_uses_it),
		NULL_TEST(a_hundred_thousand_images),
		NULL_TEST(each_allocation_fails),
		NULL_TEST(uploads_that_cannot_be),
		NULL_TEST(uploads_of_several_threads),
		NULL_TEST(uploads_end_in_threads),
		NULL_TEST(the_ring_is_full),
		NULL_TEST(uploads_of_a_frame),
		NULL_TEST(many_uploads),
		NULL_TEST(passes_that_do_not_fit),
		NULL_TEST(sets_of_what_plans_write),
		NULL_TEST(a_device_is_lost),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
