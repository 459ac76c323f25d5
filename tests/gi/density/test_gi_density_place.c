/* Points of the aperture, places in a pixel, and the directions of a record's rays are spread as they should be:
 * support/chi_square.h. */
#include "support/chi_square.h"

#include "gi/cache/gi_cache_strata.h"
#include "gi/film/gi_camera.h"

static uint32_t draws;

static void passes(chi_square_family *family, const chi_square_subject *subject, const char *what, uint32_t kind)
{
	chi_square_result got = chi_square_compare(subject, 40 + family->done, draws);
	if (!chi_square_passes(family, got.p))
		fail_msg("%s %u: p %.2g, integral %.5f", what, kind, got.p, got.mass);
}

/* ---- the aperture ------------------------------------------------------------------------------------------------ */

static bool aperture_draw(const void *context, shade_proof_random *random, double at[2])
{
	const gi_camera *camera = context;
	stilb_vec2 u = {shade_proof_uniform(random), shade_proof_uniform(random)};
	stilb_vec2 place = gi_camera_aperture(camera, u) / camera->lens.radius;
	at[0] = fmin(0.5 + 0.5 * (double)place[0], 0.9999999);
	at[1] = fmin(0.5 + 0.5 * (double)place[1], 0.9999999);
	return true;
}

/* The same all over a disk, or a polygon whose corners lie on it. */
static double aperture_density(const void *context, const double at[2])
{
	const gi_camera *camera = context;
	double x = 2.0 * at[0] - 1.0, y = 2.0 * at[1] - 1.0, blades = camera->lens.blades;
	if (camera->lens.blades == 0)
		return x * x + y * y < 1.0 ? 4.0 / M_PI : 0.0;
	double step = 2.0 * M_PI / blades, turn = atan2(y, x) - (double)camera->lens.rotation;
	turn -= step * floor(turn / step) + 0.5 * step;
	bool inside = hypot(x, y) * cos(turn) < cos(0.5 * step);
	return inside ? 4.0 / (0.5 * blades * sin(step)) : 0.0;
}

static void apertures_are_even(void **state)
{
	(void)state;
	static const uint32_t blades[] = {0, 3, 4, 5, 6, 16};
	chi_square_family family = chi_square_family_of(6);
	for (uint32_t i = 0; i < 6; i++) {
		gi_camera camera = {.lens = {.radius = 0.3f, .focus = 1.0f, .blades = blades[i], .rotation = 0.4f * (float)i}};
		passes(&family, &(chi_square_subject){aperture_draw, aperture_density, &camera}, "blades:", blades[i]);
	}
	chi_square_end(&family);
}

/* ---- the pixel --------------------------------------------------------------------------------------------------- */

static bool filter_draw(const void *context, shade_proof_random *random, double at[2])
{
	stilb_vec2 u = {shade_proof_uniform(random), shade_proof_uniform(random)};
	stilb_vec2 place = gi_filter_offset(*(const stilb_gi_filter_kind *)context, u);
	at[0] = fmin(0.5 + 0.25 * (double)place[0], 0.9999999); /* two pixels to each side */
	at[1] = fmin(0.5 + 0.25 * (double)place[1], 0.9999999);
	return true;
}

/* Weight at x over the integral of all. */
static double filter_share(stilb_gi_filter_kind kind, double x)
{
	double t = M_PI * x / 1.5;
	if (kind == STILB_GI_FILTER_BOX)
		return fabs(x) < 0.5 ? 1.0 : 0.0;
	if (fabs(x) > 1.5)
		return 0.0;
	if (kind == STILB_GI_FILTER_GAUSSIAN)
		return exp(-2.0 * x * x) / (sqrt(0.5 * M_PI) * erf(1.5 * sqrt(2.0)));
	return (0.35875 + 0.48829 * cos(t) + 0.14128 * cos(2.0 * t) + 0.01168 * cos(3.0 * t)) / (3.0 * 0.35875);
}

static double filter_density(const void *context, const double at[2])
{
	stilb_gi_filter_kind kind = *(const stilb_gi_filter_kind *)context;
	return 16.0 * filter_share(kind, 4.0 * at[0] - 2.0) * filter_share(kind, 4.0 * at[1] - 2.0);
}

static void filters_are_their_weights(void **state)
{
	(void)state;
	chi_square_family family = chi_square_family_of(STILB_GI_FILTER_COUNT);
	for (stilb_gi_filter_kind kind = 0; kind < STILB_GI_FILTER_COUNT; kind++)
		passes(&family, &(chi_square_subject){filter_draw, filter_density, &kind}, "filter", kind);
	chi_square_end(&family);
}

/* ---- a record's rays --------------------------------------------------------------------------------------------- */

static const shade_frame frame = {.t = {1.0f, 0.0f, 0.0f}, .b = {0.0f, 1.0f, 0.0f}, .n = {0.0f, 0.0f, 1.0f}};

static bool strata_draw(const void *context, shade_proof_random *random, double at[2])
{
	const gi_cache_strata *strata = context;
	uint32_t cells = gi_cache_strata_cells(strata), cell = (uint32_t)((double)shade_proof_uniform(random) * cells);
	stilb_vec2 u = {shade_proof_uniform(random), shade_proof_uniform(random)};
	chi_square_place(frame, gi_cache_strata_direction(strata, cell, u), at);
	return true;
}

static double strata_density(const void *context, const double at[2])
{
	(void)context;
	return 4.0 * fmax((double)chi_square_direction(frame, at)[2], 0.0);
}

static void rays_of_records_are_cosine_distributed(void **state)
{
	(void)state;
	static const uint32_t rays[] = {16, 100, 1024, 5000};
	chi_square_family family = chi_square_family_of(4);
	for (uint32_t i = 0; i < 4; i++) {
		gi_cache_strata strata;
		assert_int_equal(gi_cache_strata_create(rays[i], &strata), STILB_OK);
		passes(&family, &(chi_square_subject){strata_draw, strata_density, &strata}, "rays:", rays[i]);
		gi_cache_strata_destroy(&strata);
	}
	chi_square_end(&family);
}

int main(void)
{
	draws = TEST_ASAN || TEST_EMULATED ? 10000 : 60000;
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(apertures_are_even),
		cmocka_unit_test(filters_are_their_weights),
		cmocka_unit_test(rays_of_records_are_cosine_distributed),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
