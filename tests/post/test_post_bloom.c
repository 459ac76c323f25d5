/* Bloom by the device's programs and by the CPU's threads, beside its definition in double: sizes of all kinds, light
 * that is kept, that does not flicker, and that is no number. */
#include "post_stage.h"

/* ---- the definition ---------------------------------------------------------------------------------------------- */

/* A picture of one channel. */
typedef struct plane {
	double *at;
	uint32_t width, height;
} plane;

static plane plane_make(uint32_t width, uint32_t height)
{
	plane p = {calloc((size_t)width * height, sizeof *p.at), width, height};
	assert_non_null(p.at);
	return p;
}

static double plane_get(const plane *p, int64_t x, int64_t y)
{
	x = x < 0 ? 0 : x >= p->width ? p->width - 1 : x;
	y = y < 0 ? 0 : y >= p->height ? p->height - 1 : y;
	return p->at[(size_t)y * p->width + (size_t)x];
}

/* Each texel of half the size: weights 1, 3, 3, 1 of four columns and rows. */
static plane plane_halved(const plane *from)
{
	static const double weights[4] = {0.125, 0.375, 0.375, 0.125};
	plane to = plane_make((from->width + 1) / 2, (from->height + 1) / 2);
	for (uint32_t y = 0; y < to.height; y++)
		for (uint32_t x = 0; x < to.width; x++)
			for (int j = 0; j < 4; j++)
				for (int i = 0; i < 4; i++)
					to.at[(size_t)y * to.width + x] +=
						weights[i] * weights[j] * plane_get(from, 2 * (int64_t)x - 1 + i, 2 * (int64_t)y - 1 + j);
	return to;
}

/* A texel of twice the size: three quarters of the nearest one and a quarter of the one beside it, each way. */
static double plane_doubled(const plane *from, uint32_t x, uint32_t y)
{
	int64_t near_x = x / 2, near_y = y / 2, far_x = near_x + (x % 2 ? 1 : -1), far_y = near_y + (y % 2 ? 1 : -1);
	return 0.5625 * plane_get(from, near_x, near_y) + 0.1875 * plane_get(from, far_x, near_y) +
	       0.1875 * plane_get(from, near_x, far_y) + 0.0625 * plane_get(from, far_x, far_y);
}

/* What is scattered of a plane that has been halved `level` times; first: the level that scatters light. */
static plane plane_scattered(const plane *from, uint32_t level, int first, double width)
{
	plane here = plane_halved(from);
	if (here.width < 8 || here.height < 8)
		return here;
	plane wider = plane_scattered(&here, level + 1, first, width);
	for (uint32_t y = 0; y < here.height; y++)
		for (uint32_t x = 0; x < here.width; x++) {
			double share = (int)level < first ? 1.0 : width, *own = &here.at[(size_t)y * here.width + x];
			*own = (1.0 - share) * *own + share * plane_doubled(&wider, x, y);
		}
	free(wider.at);
	return here;
}

/* A channel of what the chain makes of a light. */
static plane plane_bloomed(const plane *light, const stilb_post_settings *settings)
{
	double width = settings->bloom_width > 0.0f ? (double)settings->bloom_width : 0.6;
	plane out = plane_make(light->width, light->height);
	plane scattered = plane_scattered(light, 0, (int)lround(log2(light->height / 360.0)), width);
	for (uint32_t y = 0; y < out.height; y++)
		for (uint32_t x = 0; x < out.width; x++)
			out.at[(size_t)y * out.width + x] = (1.0 - (double)settings->bloom) * plane_get(light, x, y) +
			                                    (double)settings->bloom * plane_doubled(&scattered, x, y);
	free(scattered.at);
	return out;
}

/* ---- who computes it --------------------------------------------------------------------------------------------- */

/* Of the tests that run now. */
static stilb_post_place place;

static void bloom_set(post_stage *s, stilb_post_settings settings)
{
	settings.place = place;
	stilb_post_set(s->post, &settings);
}

/* ---- lights ------------------------------------------------------------------------------------------------------ */

static float *light_make(const post_stage *s)
{
	float *rgb = calloc((size_t)s->width * s->height, 3 * sizeof *rgb);
	assert_non_null(rgb);
	return rgb;
}

/* Dim everywhere, and a few bright pixels. */
static void light_fill(const post_stage *s, uint64_t seed, float bright, float *rgb)
{
	for (uint32_t i = 0; i < 3 * s->width * s->height; i++) {
		float value = stilb_random_float(seed, i), rare = stilb_random_float(seed + 1, i);
		value = rare > 0.99f ? bright * value : 0.2f * value;
		rgb[i] = stilb_image_half_to_float(stilb_image_half_from_float(value));
	}
}

static double sum_of(const post_stage *s, const float *rgb)
{
	double sum = 0.0;
	for (uint32_t i = 0; i < 3 * s->width * s->height; i++)
		sum += (double)rgb[i];
	return sum;
}

/* ---- tests ------------------------------------------------------------------------------------------------------- */

/* Each of 12 levels, and of as many on the way back, rounds to half floats; the light itself once more. */
#define ROUNDED (26.0 / 2048.0)

static void pictures_are_as_defined(void **state)
{
	(void)state;
	static const struct {
		uint32_t width, height;
		stilb_post_settings settings;
	} cases[] = {
		{1, 1, {.bloom = 0.5f}},
		{3, 5, {.bloom = 0.5f}},
		{67, 41, {.bloom = 0.25f}},
		{64, 48, {.bloom = 1.0f, .bloom_width = 0.3f}},
		{160, 640, {.bloom = 0.5f, .bloom_width = 1.0f}},
		{120, 900, {.bloom = 0.5f}},
		{16384, 1, {.bloom = 0.5f}},
		{1, 300, {.bloom = 0.5f, .bloom_width = 0.9f}},
	};
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		post_stage s;
		stage_open(&s, STILB_RENDER_DEVICE_VULKAN, cases[i].width, cases[i].height);
		float *light = light_make(&s);
		light_fill(&s, 10 + i, 50.0f, light);
		stage_light(&s, light);
		bloom_set(&s, cases[i].settings);
		float *shown = stage_shown(&s);
		for (uint32_t c = 0; c < 3; c++) {
			plane from = plane_make(s.width, s.height);
			for (uint32_t p = 0; p < s.width * s.height; p++)
				from.at[p] = (double)light[3 * p + c];
			plane want = plane_bloomed(&from, &cases[i].settings);
			for (uint32_t p = 0; p < s.width * s.height; p++)
				if (fabs((double)shown[3 * p + c] - want.at[p]) > ROUNDED * want.at[p] + 1e-6)
					fail_msg("%u x %u, pixel %u: %.6g, not %.6g", s.width, s.height, p, (double)shown[3 * p + c],
					         want.at[p]);
			free(from.at);
			free(want.at);
		}
		free(shown);
		free(light);
		stage_close(&s);
	}
}

/* No light is made or lost where sides can be halved without a rest, but for the rounding of 10 passes, which some
 * devices do towards zero; and what is the same everywhere stays so. */
static void light_is_kept(void **state)
{
	(void)state;
	post_stage s;
	stage_open(&s, STILB_RENDER_DEVICE_VULKAN, 128, 64);
	bloom_set(&s, (stilb_post_settings){.bloom = 0.7f});
	float *light = light_make(&s);
	for (uint64_t seed = 0; seed < 4; seed++) {
		light_fill(&s, seed, 1000.0f, light);
		stage_light(&s, light);
		float *shown = stage_shown(&s);
		double ratio = sum_of(&s, shown) / sum_of(&s, light);
		if (fabs(ratio - 1.0) > 3e-3)
			fail_msg("%.5f of the light is left", ratio);
		free(shown);
	}
	for (uint32_t i = 0; i < 3 * s.width * s.height; i++)
		light[i] = 0.75f;
	stage_light(&s, light);
	float *shown = stage_shown(&s);
	for (uint32_t i = 0; i < 3 * s.width * s.height; i++)
		assert_true(fabsf(shown[i] - 0.75f) <= 1e-3f);
	free(shown);
	free(light);
	stage_close(&s);
}

/* A bright pixel that moves by thirds of a pixel, from one to the next, scatters the same light. */
static void movement_does_not_flicker(void **state)
{
	(void)state;
	post_stage s;
	stage_open(&s, STILB_RENDER_DEVICE_VULKAN, 160, 90);
	bloom_set(&s, (stilb_post_settings){.bloom = 0.5f});
	float *light = light_make(&s);
	double least = HUGE_VAL, most = 0.0;
	for (uint32_t third = 0; third < 24; third++) {
		uint32_t x = 70 + third / 3, pixel = 45 * s.width + x;
		float beside = (float)(third % 3) / 3.0f;
		memset(light, 0, (size_t)s.width * s.height * 3 * sizeof *light);
		for (uint32_t c = 0; c < 3; c++) {
			light[3 * pixel + c] = 900.0f * (1.0f - beside);
			light[3 * (pixel + 1) + c] = 900.0f * beside;
		}
		stage_light(&s, light);
		float *shown = stage_shown(&s);
		double sum = sum_of(&s, shown) - 0.5 * sum_of(&s, light); /* what the pixels keep */
		least = fmin(least, sum);
		most = fmax(most, sum);
		free(shown);
	}
	if (most > 1.01 * least)
		fail_msg("from %.3f to %.3f", least, most);
	free(light);
	stage_close(&s);
}

/* What is no number stays where it is, and what is negative scatters nothing. */
static void what_is_no_number_stays(void **state)
{
	(void)state;
	static const float values[] = {NAN, INFINITY, -INFINITY, -1000.0f};
	for (uint32_t format = 0; format < STILB_POST_BLOOM_FORMATS_COUNT; format++) {
		post_stage s;
		stage_open(&s, STILB_RENDER_DEVICE_VULKAN, 96, 64);
		bloom_set(&s, (stilb_post_settings){.bloom = 0.5f, .bloom_format = (stilb_post_bloom_format)format});
		float *light = light_make(&s);
		for (size_t v = 0; v < sizeof values / sizeof *values; v++) {
			uint32_t broken = 33 * s.width + 47;
			light_fill(&s, v, 3.0f, light);
			light[3 * broken + v % 3] = values[v];
			stage_light(&s, light);
			float *shown = stage_shown(&s);
			for (uint32_t i = 0; i < 3 * s.width * s.height; i++)
				if (i / 3 != broken && !(shown[i] >= 0.0f && shown[i] <= 4.0f))
					fail_msg("with %g pixel %u is %g", (double)values[v], i / 3, (double)shown[i]);
			free(shown);
		}
		free(light);
		stage_close(&s);
	}
}

/* In 8 bits pictures are within two codes of display white of those in half floats, whatever the exposure. */
static void fixed_point_is_near(void **state)
{
	(void)state;
	for (int stops = -4; stops <= 4; stops += 4) {
		post_stage s;
		stage_open(&s, STILB_RENDER_DEVICE_VULKAN, 160, 90);
		stilb_post_see(s.post, &(stilb_render_view){.exposure = (float)stops});
		float *light = light_make(&s), *shown[2];
		light_fill(&s, 5, 20.0f, light);
		for (uint32_t i = 0; i < 3 * s.width * s.height; i++)
			light[i] *= exp2f((float)-stops);
		stage_light(&s, light);
		for (uint32_t f = 0; f < 2; f++) {
			stilb_post_set(s.post, &(stilb_post_settings){.bloom = 0.1f, .bloom_format = (stilb_post_bloom_format)f});
			shown[f] = stage_shown(&s);
		}
		double worst = 0.0, differs = 0.0;
		for (uint32_t i = 0; i < 3 * s.width * s.height; i++) {
			double error = fabs((double)shown[1][i] - (double)shown[0][i]) * exp2(stops);
			worst = fmax(worst, error / fmax(1.0, (double)shown[0][i] * exp2(stops)));
			differs += error > 0.0;
		}
		if (worst > 2.0 / 255.0 || differs == 0.0)
			fail_msg("exposed by %d stops: off by %.5f, %.0f values differ", stops, worst, differs);
		for (uint32_t f = 0; f < 2; f++)
			free(shown[f]);
		free(light);
		stage_close(&s);
	}
}

/* The passes of the last frame that are bloom's. */
static uint32_t bloom_passes(const post_stage *s)
{
	const stilb_gpu_plan *plan = stilb_render_plan(s->render);
	uint32_t count = 0;
	for (uint32_t p = 0; p < stilb_gpu_plan_passes(plan); p++)
		count += strncmp(stilb_gpu_plan_row(plan, p)->name, "bloom", 5) == 0;
	return count;
}

/* Without bloom there is no row; with it the same picture each time, and the same alpha. */
static void no_effect_no_row(void **state)
{
	(void)state;
	post_stage s;
	stage_open(&s, STILB_RENDER_DEVICE_VULKAN, 64, 64);
	float *light = light_make(&s);
	light_fill(&s, 1, 9.0f, light);
	s.alpha = 0.5f;
	stage_light(&s, light);
	float *plain = stage_shown(&s);
	assert_int_equal(bloom_passes(&s), 0);
	assert_memory_equal(plain, light, (size_t)s.width * s.height * 3 * sizeof *light);
	bloom_set(&s, (stilb_post_settings){.bloom = 0.1f});
	float *bloomed = stage_shown(&s), *again = stage_shown(&s);
	assert_int_equal(bloom_passes(&s), place == STILB_POST_PLACE_CPU ? 1 : 4 + 3 + 1); /* 32, 16, 8, 4 texels */
	assert_memory_equal(bloomed, again, (size_t)s.width * s.height * 3 * sizeof *light);
	assert_memory_not_equal(bloomed, light, (size_t)s.width * s.height * 3 * sizeof *light);
	stilb_post_set(s.post, &(stilb_post_settings){0});
	free(again);
	again = stage_shown(&s);
	assert_int_equal(bloom_passes(&s), 0);
	assert_memory_equal(plain, again, (size_t)s.width * s.height * 3 * sizeof *light);
	free(plain);
	free(bloomed);
	free(again);
	free(light);
	stage_close(&s);
}

/* The software device leaves it to the CPU, unless it is to be in 8 bits. */
static void software_devices_leave_it_to_the_cpu(void **state)
{
	(void)state;
	post_stage s;
	stage_open(&s, STILB_RENDER_DEVICE_VULKAN, 64, 64);
	bool software = stilb_render_device_is_software(s.render);
	for (uint32_t format = 0; format < STILB_POST_BLOOM_FORMATS_COUNT; format++) {
		stilb_post_settings settings = {.bloom = 0.1f, .bloom_format = (stilb_post_bloom_format)format};
		stilb_post_set(s.post, &settings);
		stage_draw(&s);
		assert_int_equal(bloom_passes(&s) == 1, software && format == STILB_POST_BLOOM_HALF);
	}
	stage_close(&s);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(pictures_are_as_defined),   cmocka_unit_test(light_is_kept),
		cmocka_unit_test(movement_does_not_flicker), cmocka_unit_test(what_is_no_number_stays),
		cmocka_unit_test(no_effect_no_row),
	};
	struct CMUnitTest others[] = {
		cmocka_unit_test(fixed_point_is_near),
		cmocka_unit_test(software_devices_leave_it_to_the_cpu),
	};
	int failed = 0;
	for (int who = STILB_POST_PLACE_GPU; who <= STILB_POST_PLACE_CPU; who++) {
		place = (stilb_post_place)who;
		failed += cmocka_run_group_tests_name(stilb_post_place_names[who], tests, NULL, NULL);
	}
	return failed + cmocka_run_group_tests(others, NULL, NULL);
}
