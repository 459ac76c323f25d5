/* The rows of stilb_gpu_plan_mips: their barriers on the null device, and on the Vulkan device, under validation, each
 * mip of random images against the filter that gpu_plan.h tells of, worked out from the mip before it. */
#include "gpu/gpu_internal.h"
#include "gpu_script.h"
#include "shading/shade_srgb.h"
#include "support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static stilb_gpu *gpu;
static stilb_gpu_plan *plan;

static void open_device(stilb_gpu_kind kind)
{
	stilb_gpu_desc desc = {.kind = kind, .validate = kind == STILB_GPU_KIND_VULKAN, .upload_bytes = 1 << 20};
	if (stilb_gpu_create(&desc, &gpu) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	plan = stilb_gpu_plan_create();
	assert_non_null(plan);
}

static void close_device(void)
{
	assert_int_equal(stilb_gpu_validation_messages(gpu), 0);
	stilb_gpu_plan_destroy(plan);
	stilb_gpu_destroy(gpu);
}

static void rows(void **state)
{
	(void)state;
	open_device(STILB_GPU_KIND_NULL);
	stilb_gpu_planner planner = stilb_gpu_planner_of(gpu);
	assert_int_equal(stilb_gpu_frame_begin(gpu), STILB_OK);
	stilb_gpu_plan_begin(plan, 64, 64);
	uint16_t image = stilb_gpu_plan_image(plan, &(stilb_gpu_plan_image_row){.name = "bloom",
	                                                                        .format = STILB_GPU_RGBA16_F,
	                                                                        .width = 5,
	                                                                        .height = 9,
	                                                                        .mips = STILB_GPU_ALL,
	                                                                        .output = true});
	stilb_gpu_plan_pass(plan, &(stilb_gpu_pass){.name = "draw",
	                                            .kind = STILB_GPU_PASS_DRAWS,
	                                            .color = {{.image = image, .load = STILB_GPU_LOAD_CLEAR}},
	                                            .color_count = 1});
	assert_int_equal(stilb_gpu_plan_mips(plan, image, 0, 0), 3);
	assert_int_equal(stilb_gpu_plan_mips(plan, 0, 0, 0), 0);
	if (stilb_gpu_plan_make(plan, &planner) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	char *barriers = script_barriers(plan);
	assert_string_equal(barriers, "draw: bloom[0] none > color discard\n"
	                              "mips: bloom[0] color > copy_from+output\n"
	                              "mips: bloom[1] none > copy_to discard\n"
	                              "mips: bloom[1] copy_to > copy_from+output\n"
	                              "mips: bloom[2] none > copy_to discard\n"
	                              "mips: bloom[2] copy_to > copy_from+output\n"
	                              "mips: bloom[3] none > copy_to discard\n"
	                              "end: bloom[3] copy_to > output\n");
	free(barriers);
	stilb_gpu_binding binding = {0};
	stilb_gpu_draws none = {.bindings = &binding};
	if (stilb_gpu_frame_run(gpu, plan, &none, 1, NULL) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(stilb_gpu_stats_get(gpu).passes, 4);
	close_device();
}

/* What is wrong is told by the plan, with the image's name. */
static void images_without_a_filter(void **state)
{
	(void)state;
	open_device(STILB_GPU_KIND_NULL);
	static const stilb_gpu_format formats[] = {STILB_GPU_D32_F, STILB_GPU_R32_UI, STILB_GPU_BC7_U};
	for (size_t f = 0; f < 3; f++) {
		stilb_gpu_plan_begin(plan, 64, 64);
		uint16_t image = stilb_gpu_plan_image(
			plan, &(stilb_gpu_plan_image_row){
					  .name = "image", .format = formats[f], .width = 8, .height = 8, .mips = 2, .output = true});
		stilb_gpu_plan_mips(plan, image, 0, 0);
		assert_int_equal(stilb_gpu_plan_make(plan, NULL), STILB_ERROR_ARGUMENT);
		assert_non_null(strstr(stilb_error_message(), "copies 'image'"));
	}
	close_device();
}

/* ---- the device -------------------------------------------------------------------------------------------------- */

static float from_half(uint16_t bits)
{
	float value = (bits >> 10 & 31) == 0 ? ldexpf((float)(bits & 1023), -24)
	                                     : ldexpf((float)(1024 + (bits & 1023)), (bits >> 10 & 31) - 25);
	return bits >> 15 ? -value : value;
}

/* A channel as what is filtered: light, for sRGB. */
static float channel(stilb_gpu_format format, const void *texels, size_t at)
{
	if (format == STILB_GPU_RGBA16_F)
		return from_half(((const uint16_t *)texels)[at]);
	float code = (float)((const uint8_t *)texels)[at] / 255.0f;
	return format == STILB_GPU_RGBA8_SRGB && at % 4 < 3 ? shade_srgb_to_linear(code) : code;
}

/* The larger of the differences to what the format could hold below and above. */
static float tolerance(stilb_gpu_format format, size_t at, float expected, bool even)
{
	float weight = even ? 0.0f : 1.0f / 256.0f; /* bits of a place between texels: 8 */
	if (format == STILB_GPU_RGBA16_F)
		return fabsf(expected) / 1024.0f + 1e-4f + weight * 8.0f;
	if (format != STILB_GPU_RGBA8_SRGB || at % 4 == 3)
		return 1.01f / 255.0f + weight;
	float code = shade_srgb_from_linear(expected) + 1.01f / 255.0f;
	return shade_srgb_to_linear(code) - expected + weight;
}

/* The value in the middle of a smaller mip's texel, between the two of the larger one that it lies between. */
typedef struct taps {
	uint32_t first, second;
	float share; /* of the second */
} taps;

static taps taps_of(uint32_t at, uint32_t large, uint32_t small)
{
	float middle = ((float)at + 0.5f) * (float)large / (float)small - 0.5f;
	uint32_t first = (uint32_t)floorf(middle);
	return (taps){first, first + 1 < large ? first + 1 : first, middle - floorf(middle)};
}

static void assert_mip(stilb_gpu_format format, const void *large, const void *small, uint32_t width, uint32_t height)
{
	uint32_t w = width > 1 ? width / 2 : 1, h = height > 1 ? height / 2 : 1;
	bool even = (width % 2 == 0 || width == 1) && (height % 2 == 0 || height == 1);
	for (uint32_t y = 0; y < h; y++)
		for (uint32_t x = 0; x < w; x++)
			for (uint32_t c = 0; c < 4; c++) {
				taps i = taps_of(x, width, w), j = taps_of(y, height, h);
				const uint32_t columns[2] = {i.first, i.second}, lines[2] = {j.first, j.second};
				float expected = 0.0f;
				for (int k = 0; k < 4; k++) {
					float weight = (k % 2 ? i.share : 1.0f - i.share) * (k / 2 ? j.share : 1.0f - j.share);
					expected += weight * channel(format, large, 4 * (lines[k / 2] * width + columns[k % 2]) + c);
				}
				size_t at = 4 * ((size_t)y * w + x) + c;
				float got = channel(format, small, at);
				if (fabsf(got - expected) > tolerance(format, at, expected, even))
					fail_msg("%u x %u of format %s, texel %u, %u, channel %u: %g, not %g", w, h,
					         stilb_gpu_format_describe(format)->name, x, y, c, (double)got, (double)expected);
			}
}

typedef struct shape {
	stilb_gpu_shape shape;
	uint32_t width, height;
	uint16_t layers, first, count; /* count: of stilb_gpu_plan_mips */
} shape;

static void upload(stilb_gpu_image image, const stilb_gpu_extent *e, uint64_t seed)
{
	for (uint16_t layer = 0; layer < e->layers; layer++) {
		void *bytes;
		stilb_gpu_upload to = {.image = image,
		                       .layer = layer,
		                       .width = e->width,
		                       .height = e->height,
		                       .depth = 1,
		                       .bytes = gpu_mip_bytes(e, 0)};
		assert_int_equal(stilb_gpu_upload_begin(gpu, &to, &bytes), STILB_OK);
		assert_non_null(bytes);
		for (uint64_t i = 0; i < to.bytes / 2; i++) { /* halves: -8..8 */
			uint64_t random = stilb_random_u64(seed + layer, i);
			((uint16_t *)bytes)[i] =
				(uint16_t)(e->format == STILB_GPU_RGBA16_F ? random % 0x4800 | (random >> 32 & 0x8000) : random);
		}
		stilb_gpu_upload_end(gpu, bytes);
	}
}

static void *read_mip(uint16_t resource, const stilb_gpu_extent *e, uint32_t mip, uint16_t layer)
{
	uint64_t ticket, frame, size = gpu_mip_bytes(e, mip);
	const void *bytes;
	void *copy = malloc(size);
	if (stilb_gpu_read_begin(gpu, plan, resource, (uint8_t)mip, layer, &ticket) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(stilb_gpu_read_get(gpu, ticket, true, &bytes, &frame), STILB_OK);
	memcpy(copy, bytes, size);
	stilb_gpu_read_end(gpu, ticket);
	return copy;
}

static void image_has_its_mips(stilb_gpu_format format, const shape *s, uint64_t seed)
{
	uint16_t mips = 1;
	while ((s->width | s->height) >> mips > 0)
		mips++;
	stilb_gpu_image image;
	stilb_gpu_image_desc desc = {
		.name = "mipped",
		.extent = {.format = format,
	               .shape = s->shape,
	               .width = s->width,
	               .height = s->height,
	               .depth = 1,
	               .layers = s->layers,
	               .mips = mips,
	               .samples = 1,
	               .uses = 1u << STILB_GPU_USE_SAMPLED | 1u << STILB_GPU_USE_COPY_FROM | 1u << STILB_GPU_USE_COPY_TO}};
	stilb_gpu_planner planner = stilb_gpu_planner_of(gpu);
	assert_int_equal(stilb_gpu_image_create(gpu, &desc, &image), STILB_OK);
	upload(image, &desc.extent, seed);
	assert_int_equal(stilb_gpu_frame_begin(gpu), STILB_OK);
	stilb_gpu_plan_begin(plan, 64, 64);
	uint16_t row = stilb_gpu_plan_image(plan, &(stilb_gpu_plan_image_row){.name = "mipped",
	                                                                      .format = format,
	                                                                      .shape = s->shape,
	                                                                      .width = s->width,
	                                                                      .height = s->height,
	                                                                      .layers = s->layers,
	                                                                      .mips = STILB_GPU_ALL,
	                                                                      .owned = image.id,
	                                                                      .output = true});
	assert_int_equal(stilb_gpu_plan_mips(plan, row, s->first, s->count), mips - 1);
	if (stilb_gpu_plan_make(plan, &planner) != STILB_OK || stilb_gpu_frame_run(gpu, plan, NULL, 0, NULL) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	uint16_t end = s->count > 0 ? s->first + s->count : s->layers;
	for (uint16_t layer = s->first; layer < end; layer++) {
		void *large = read_mip(row, &desc.extent, 0, layer);
		for (uint32_t m = 1; m < mips; m++) {
			void *small = read_mip(row, &desc.extent, m, layer);
			assert_mip(format, large, small, gpu_mip_side(s->width, m - 1), gpu_mip_side(s->height, m - 1));
			free(large);
			large = small;
		}
		free(large);
	}
	stilb_gpu_image_destroy(gpu, image);
}

static void images_have_their_mips(void **state)
{
	(void)state;
	static const stilb_gpu_format formats[] = {STILB_GPU_RGBA8_U, STILB_GPU_RGBA8_SRGB, STILB_GPU_RGBA16_F};
	static const shape shapes[] = {
		{STILB_GPU_SHAPE_2D, 64, 32, 1, 0, 0},  {STILB_GPU_SHAPE_2D, 37, 21, 1, 0, 0},
		{STILB_GPU_SHAPE_2D, 1, 13, 1, 0, 0},   {STILB_GPU_SHAPE_2D, 16, 24, 3, 0, 0},
		{STILB_GPU_SHAPE_2D, 11, 16, 4, 1, 2},  {STILB_GPU_SHAPE_CUBE, 16, 16, 6, 0, 0},
		{STILB_GPU_SHAPE_CUBE, 9, 9, 12, 6, 6},
	};
	open_device(STILB_GPU_KIND_VULKAN);
	for (size_t f = 0; f < sizeof formats / sizeof *formats; f++)
		for (size_t s = 0; s < sizeof shapes / sizeof *shapes; s++)
			image_has_its_mips(formats[f], &shapes[s], 100 * f + s);
	close_device();
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(rows),
		cmocka_unit_test(images_without_a_filter),
		cmocka_unit_test(images_have_their_mips),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
