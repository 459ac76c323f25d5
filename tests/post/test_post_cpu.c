/* Effects on the CPU's threads: the same bits for any number of workers and any instruction set, whatever the pictures
 * before. That they are what they should be test_post_bloom tells. */
#include "image/image.h"
#include "post/cpu/post_cpu_internal.h"
#include "post/cpu/post_cpu_lanes.h"
#include "support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static uint16_t *light_make(uint32_t width, uint32_t height)
{
	size_t count = (size_t)width * height * 4;
	uint16_t *texels = malloc(count * sizeof *texels);
	assert_non_null(texels);
	for (size_t i = 0; i < count; i++) {
		float value = stilb_random_float(width, i), rare = stilb_random_float(height, i);
		texels[i] = rare > 0.995f ? 0x7c00u + (i & 0x81ffu)
		                          : stilb_image_half_from_float(rare > 0.98f ? 900.0f * value : value);
	}
	return texels;
}

/* One picture behind another, of all sizes, by pools of all sizes. */
static void same_bits_by_any_threads(void **state)
{
	(void)state;
	static const uint32_t sizes[][2] = {{640, 360}, {1, 1}, {3, 5}, {16384, 1}, {1, 999}, {67, 41}, {640, 360}};
	static const uint32_t workers[] = {0, 1, 2, 3, 8};
	stilb_post_settings settings = {.bloom = 0.3f, .bloom_width = 0.6f};
	uint16_t *alone[sizeof sizes / sizeof *sizes];
	for (size_t w = 0; w <= sizeof workers / sizeof *workers; w++) { /* the first time without a pool */
		post_cpu *cpu;
		stilb_job_pool *pool = NULL;
		stilb_job_pool_desc desc = {.worker_count = w > 0 ? workers[w - 1] : 0};
		assert_int_equal(post_cpu_create(&cpu), STILB_OK);
		assert_int_equal(w > 0 ? stilb_job_pool_create(&desc, &pool) : 0, 0);
		for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
			uint32_t width = sizes[i][0], height = sizes[i][1];
			uint16_t *texels = light_make(width, height);
			assert_int_equal(post_cpu_fit(cpu, width, height, pool), STILB_OK);
			post_cpu_bloom(cpu, &settings, texels);
			if (w == 0)
				alone[i] = texels;
			else
				assert_memory_equal(texels, alone[i], (size_t)width * height * 8);
			if (w > 0)
				free(texels);
		}
		stilb_job_pool_destroy(pool);
		post_cpu_destroy(cpu);
	}
	for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++)
		free(alone[i]);
}

/* A floor that rises, with steps and holes without depth. */
static float *depth_make(uint32_t width, uint32_t height)
{
	float *depth = malloc((size_t)width * height * sizeof *depth);
	assert_non_null(depth);
	for (size_t i = 0; i < (size_t)width * height; i++) {
		float up = (float)(i / width) / (float)height, step = stilb_random_float(width, i / 37);
		depth[i] = step < 0.1f ? 0.0f : 0.02f * (0.2f + up) + (step > 0.8f ? 0.004f : 0.0f);
	}
	return depth;
}

/* Likewise occlusion, in every instruction set that this CPU has. */
static void same_bits_of_occlusion(void **state)
{
	(void)state;
	static const uint32_t sizes[][2] = {{320, 180}, {1, 1}, {3, 5}, {4099, 1}, {1, 99}, {67, 41}};
	const occlusion_rows *sets[2] = {&post_cpu_occlusion_plain,
	                                 stilb_cpu_query().avx2 ? post_cpu_occlusion_avx2 : NULL};
	stilb_post_settings settings = {.occlusion = 0.8f, .occlusion_radius = 0.5f};
	stilb_mat4 from_clip = stilb_mat4_perspective(1.0f, 1.5f, 0.1f, 100.0f);
	from_clip = stilb_mat4_inverse(&from_clip);
	for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
		uint32_t width = sizes[i][0], height = sizes[i][1];
		size_t bytes = (size_t)width * height * 8;
		float *depth = depth_make(width, height);
		uint16_t *first = NULL;
		for (uint32_t run = 0; run < 6; run++) {
			post_cpu *cpu;
			stilb_job_pool *pool = NULL;
			stilb_job_pool_desc desc = {.worker_count = run / 2};
			if (!sets[run % 2])
				continue;
			assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
			assert_int_equal(post_cpu_create(&cpu), STILB_OK);
			cpu->occlusion = sets[run % 2];
			assert_int_equal(post_cpu_fit(cpu, width, height, pool), STILB_OK);
			uint16_t *ambient = malloc(bytes);
			assert_non_null(ambient);
			for (size_t t = 0; t < bytes / 2; t++)
				ambient[t] = stilb_image_half_from_float(stilb_random_float(9, t));
			post_cpu_occlusion(cpu, &settings, &from_clip, depth, ambient);
			if (first)
				assert_memory_equal(first, ambient, bytes);
			for (size_t t = 0; t < bytes / 2; t++) /* only darker, and no less than the strength leaves */
				assert_in_range(1000 * stilb_image_half_to_float(ambient[t]), 199 * stilb_random_float(9, t),
				                1001 * stilb_random_float(9, t) + 1);
			if (first)
				free(ambient);
			else
				first = ambient;
			post_cpu_destroy(cpu);
			stilb_job_pool_destroy(pool);
		}
		free(first);
		free(depth);
	}
}

/* The angle of a cosine is what the C library says. */
static void angles_are_exact_enough(void **state)
{
	(void)state;
	for (int i = -1000000; i <= 1000000; i += 8) {
		float cosine[8], angle[8];
		for (int k = 0; k < 8; k++)
			cosine[k] = fminf((float)(i + k) * 1e-6f, 1.0f);
		lanes_store(lanes_acos(lanes_load(cosine)), angle);
		for (int k = 0; k < 8; k++)
			assert_true(fabsf(angle[k] - acosf(cosine[k])) < 1e-6f);
	}
}

#if defined(__x86_64__)
/* All half floats, and floats around the middle between two of them, but for what NaN carries. */
static void instruction_sets_agree(void **state)
{
	(void)state;
	if (!stilb_cpu_query().f16c)
		skip();
	enum { HALVES = 65536, TEXELS = HALVES / 4 };
	static uint16_t halves[HALVES], narrowed[2][HALVES];
	static post_texel wide[2][TEXELS];
	for (uint32_t i = 0; i < HALVES; i++)
		halves[i] = (uint16_t)i;
	post_cpu_rows_scalar.widen(halves, TEXELS, wide[0]);
	post_cpu_rows_f16c.widen(halves, TEXELS, wide[1]);
	for (uint32_t i = 0; i < HALVES; i++) {
		float a = wide[0][i / 4][i % 4], b = wide[1][i / 4][i % 4];
		assert_true(isnan(a) ? isnan(b) : memcmp(&a, &b, sizeof a) == 0);
	}
	for (int step = -1; step <= 1; step++) {
		for (uint32_t i = 0; i < HALVES; i++) {
			float half = stilb_image_half_to_float((uint16_t)i), next = stilb_image_half_to_float((uint16_t)(i + 1));
			float middle = 0.5f * half + 0.5f * next;
			wide[0][i / 4][i % 4] = step < 0   ? nextafterf(middle, -INFINITY)
			                        : step > 0 ? nextafterf(middle, INFINITY)
			                                   : middle;
		}
		post_cpu_rows_scalar.narrow(wide[0], TEXELS, narrowed[0]);
		post_cpu_rows_f16c.narrow(wide[0], TEXELS, narrowed[1]);
		for (uint32_t i = 0; i < HALVES; i++)
			if (!isnan(wide[0][i / 4][i % 4]) && narrowed[0][i] != narrowed[1][i])
				fail_msg("%.9g: %#x and %#x", (double)wide[0][i / 4][i % 4], narrowed[0][i], narrowed[1][i]);
	}
}
#endif

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(same_bits_by_any_threads),
		cmocka_unit_test(same_bits_of_occlusion),
		cmocka_unit_test(angles_are_exact_enough),
#if defined(__x86_64__)
		cmocka_unit_test(instruction_sets_agree),
#endif
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
