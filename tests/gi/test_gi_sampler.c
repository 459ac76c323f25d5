/* gi_sampler: what makes numbers good (nets, strata, independence), the same bits in every version, and the errors that
 * pictures get from them against closed forms. */
#include "support/shade_proof.h"

#include "gi/sample/gi_sampler.h"
#include "gi/sample/gi_sampler_kernels.h"
#include "shading/shade_sampling.h"

#include <string.h>

static const stilb_gi_sampler_kind kinds[] = {STILB_GI_SAMPLER_RANDOM, STILB_GI_SAMPLER_STRATIFIED,
                                              STILB_GI_SAMPLER_SOBOL, STILB_GI_SAMPLER_BLUE_NOISE};
#define KINDS 4

/* ---- bits -------------------------------------------------------------------------------------------------------- */

/* Not by its own bit tricks: the matrix row by row, with binomials modulo 2 by their recursion. */
static void second_coordinate_is_pascals_triangle(void **state)
{
	(void)state;
	uint32_t row[32] = {1}, matrix[32];
	for (int i = 0; i < 32; i++) {
		matrix[i] = 0;
		for (int j = 0; j <= i; j++)
			matrix[i] |= row[j] << j;
		for (int j = i + 1; j > 0 && j < 32; j--)
			row[j] ^= row[j - 1];
	}
	for (uint32_t i = 0; i < 10000; i++) {
		uint32_t index = (uint32_t)stilb_random_u64(1, i), want = 0;
		for (int bit = 0; bit < 32; bit++)
			want ^= index >> bit & 1 ? matrix[bit] : 0;
		assert_int_equal(gi_sobol_second(index), want);
	}
}

/* Scrambling in the sense of Owen: what a bit becomes depends on it and on the higher bits alone (lower ones here, for
 * bits are reversed), and each flips as often as not. */
static void scrambling_is_owens(void **state)
{
	(void)state;
	uint32_t flips[32] = {0};
	for (uint32_t i = 0; i < 20000; i++) {
		uint32_t x = (uint32_t)stilb_random_u64(2, i), seed = (uint32_t)stilb_random_u64(3, i);
		uint32_t bit = i % 32, below = (1u << bit) - 1;
		uint32_t scrambled = gi_owen_hash(x, seed);
		assert_int_equal((gi_owen_hash(x ^ ~(below | 1u << bit), seed) ^ scrambled) & (below | 1u << bit), 0);
		assert_int_equal((gi_owen_hash(x ^ 1u << bit, seed) ^ scrambled) & (below | 1u << bit), 1u << bit);
		for (int k = 0; k < 32; k++)
			flips[k] += (x ^ scrambled) >> k & 1;
	}
	for (int k = 0; k < 32; k++)
		SHADE_PROOF_NEAR(flips[k], 10000.0, 0.0, 4.0 * sqrt(5000.0)); /* four standard deviations */
}

static void versions_agree_in_every_bit(void **state)
{
	(void)state;
	for (stilb_isa isa = STILB_ISA_SCALAR; isa <= stilb_cpu_widest_isa(); isa++) {
		const gi_sampler_kernels *kernels = gi_sampler_kernels_for(isa);
		for (uint32_t i = 0; i < 20000; i++) {
			uint64_t hash = stilb_random_u64(4, i);
			uint32_t index = (uint32_t)stilb_random_u64(5, i) >> i % 32, first = 8 * (i % 2048);
			float want[8], have[8];
			gi_sampler_kernels_scalar.sobol_8(hash, index, first, want);
			kernels->sobol_8(hash, index, first, have);
			assert_memory_equal(have, want, sizeof want);
			gi_sampler_kernels_scalar.random_8(hash, first, want);
			kernels->random_8(hash, first, have);
			assert_memory_equal(have, want, sizeof want);
		}
	}
}

static void numbers_are_the_same_by_ones_pairs_and_eights(void **state)
{
	(void)state;
	for (int k = 0; k < KINDS; k++) {
		gi_sampler sampler = gi_sampler_make(kinds[k], 7, 60);
		for (uint32_t i = 0; i < 2000; i++) {
			gi_point point = gi_sampler_point(&sampler, i * 7, i * 3, i % 60);
			if (i & 1)
				point = gi_sampler_branch(&sampler, point, i, i % 9, 9);
			float numbers[8];
			uint32_t first = 8 * (i % 100);
			gi_sample_8(&sampler, point, first, numbers);
			for (uint32_t d = 0; d < 8; d++) {
				assert_true(numbers[d] >= 0.0f && numbers[d] < 1.0f);
				assert_true(gi_sample_2d(&sampler, point, first + (d & ~1u))[d & 1] == numbers[d]);
			}
		}
	}
}

/* Pictures are to be the same in years to come: these bits were written down once. */
static void numbers_stay_what_they_are(void **state)
{
	(void)state;
	static const uint64_t want[KINDS] = {0x1a8dd647b51c5bf0u, 0x63ac84babda0044cu, 0x8fd02a1c2f0440afu,
	                                     0x22d3bd634781de35u};
	bool same = true;
	for (int k = 0; k < KINDS; k++) {
		gi_sampler sampler = gi_sampler_make(kinds[k], 42, 64);
		uint64_t hash = STILB_FNV1A64_START;
		for (uint32_t i = 0; i < 64; i++) {
			gi_point point = gi_sampler_point(&sampler, 3 + i, 5, i);
			float numbers[8];
			gi_sample_8(&sampler, gi_sampler_branch(&sampler, point, 8, 1, 4), 8, numbers);
			hash = stilb_hash_fnv1a64(hash, numbers, sizeof numbers);
			gi_sample_8(&sampler, point, 0, numbers);
			hash = stilb_hash_fnv1a64(hash, numbers, sizeof numbers);
		}
		if (hash != want[k])
			print_message("sampler %d: 0x%016llxu\n", k, (unsigned long long)hash);
		same &= hash == want[k];
	}
	assert_true(same);
}

/* ---- nets and strata --------------------------------------------------------------------------------------------- */

/* Every box of 2^-a x 2^-(k - a) holds one of the 2^k points. Source: Niederreiter, "Point sets and sequences with
 * small discrepancy" (1987): a (0, k, 2)-net. */
static void assert_net(const stilb_vec2 *points, uint32_t k)
{
	uint8_t seen[1024];
	for (uint32_t a = 0; a <= k; a++) {
		memset(seen, 0, sizeof seen);
		for (uint32_t i = 0; i < 1u << k; i++) {
			uint32_t x = (uint32_t)(points[i][0] * (float)(1u << a));
			uint32_t y = (uint32_t)(points[i][1] * (float)(1u << (k - a)));
			seen[x << (k - a) | y]++;
		}
		for (uint32_t box = 0; box < 1u << k; box++)
			assert_int_equal(seen[box], 1);
	}
}

static void every_aligned_run_of_sobol_points_is_a_net(void **state)
{
	(void)state;
	gi_sampler sampler = gi_sampler_make(STILB_GI_SAMPLER_SOBOL, 1, 1024);
	stilb_vec2 points[1024];
	for (uint32_t pixel = 0; pixel < 12; pixel++) {
		uint32_t dimension = 2 * pixel + 8 * (pixel % 3);
		for (uint32_t i = 0; i < 1024; i++)
			points[i] = gi_sample_2d(&sampler, gi_sampler_point(&sampler, pixel, 9, i), dimension);
		for (uint32_t k = 0; k <= 10; k++)
			for (uint32_t first = 0; first < 1024; first += 1u << k)
				assert_net(points + first, k);
	}
}

/* Sixteen branches of sixteen samples: each sixteen are a net, and the 256 too. */
static void branches_of_sobol_points_are_nets_alone_and_together(void **state)
{
	(void)state;
	gi_sampler sampler = gi_sampler_make(STILB_GI_SAMPLER_SOBOL, 1, 16);
	stilb_vec2 points[256];
	for (uint32_t i = 0; i < 256; i++) {
		gi_point parent = gi_sampler_point(&sampler, 100, 200, i / 16);
		points[i] = gi_sample_2d(&sampler, gi_sampler_branch(&sampler, parent, 8, i % 16, 16), 2);
	}
	for (uint32_t k = 0; k <= 8; k++)
		for (uint32_t first = 0; first < 256; first += 1u << k)
			assert_net(points + first, k);
}

/* All pixels of an aligned square of the picture together. */
static void blue_noise_points_of_a_square_are_a_net(void **state)
{
	(void)state;
	gi_sampler sampler = gi_sampler_make(STILB_GI_SAMPLER_BLUE_NOISE, 1, 4);
	stilb_vec2 points[256];
	for (uint32_t side = 1; side <= 8; side *= 2)
		for (uint32_t square = 0; square < 10; square++) {
			uint32_t count = 0;
			for (uint32_t y = 0; y < side; y++)
				for (uint32_t x = 0; x < side; x++)
					for (uint32_t i = 0; i < 4; i++)
						points[count++] =
							gi_sample_2d(&sampler, gi_sampler_point(&sampler, square * side + x, y, i), 2 * square);
			assert_net(points, (uint32_t)__builtin_ctz(count));
		}
}

/* At most one point in each cell, and one in each of as many columns, and rows, as there are cells. */
static void stratified_points_have_cells_of_their_own(void **state)
{
	(void)state;
	static const struct {
		uint32_t count, columns, rows;
	} grids[] = {{1, 1, 1}, {2, 1, 2}, {5, 2, 3}, {16, 4, 4}, {30, 5, 6}, {64, 8, 8}, {200, 14, 15}, {256, 16, 16}};
	for (size_t g = 0; g < sizeof grids / sizeof *grids; g++) {
		uint32_t count = grids[g].count, cells = grids[g].columns * grids[g].rows;
		gi_sampler sampler = gi_sampler_make(STILB_GI_SAMPLER_STRATIFIED, 3, count);
		uint8_t cell[256] = {0}, x_seen[256] = {0}, y_seen[256] = {0};
		for (uint32_t i = 0; i < count; i++) {
			stilb_vec2 u = gi_sample_2d(&sampler, gi_sampler_point(&sampler, 1, 2, i), 4);
			uint32_t x = (uint32_t)(u[0] * (float)grids[g].columns), y = (uint32_t)(u[1] * (float)grids[g].rows);
			assert_int_equal(cell[y * grids[g].columns + x]++, 0);
			assert_int_equal(x_seen[(uint32_t)(u[0] * (float)cells)]++, 0);
			assert_int_equal(y_seen[(uint32_t)(u[1] * (float)cells)]++, 0);
		}
	}
}

/* Of 16 samples with 9 branches each, every nine have cells of their own; with one branch each, all sixteen do. */
static void branches_of_stratified_points_have_cells_of_their_own(void **state)
{
	(void)state;
	gi_sampler sampler = gi_sampler_make(STILB_GI_SAMPLER_STRATIFIED, 3, 16);
	uint8_t alone[16] = {0};
	for (uint32_t sample = 0; sample < 16; sample++) {
		gi_point parent = gi_sampler_point(&sampler, 5, 6, sample);
		uint8_t nine[9] = {0};
		for (uint32_t i = 0; i < 9; i++) {
			stilb_vec2 u = gi_sample_2d(&sampler, gi_sampler_branch(&sampler, parent, 8, i, 9), 2);
			assert_int_equal(nine[(int)(u[1] * 3.0f) * 3 + (int)(u[0] * 3.0f)]++, 0);
		}
		stilb_vec2 u = gi_sample_2d(&sampler, gi_sampler_branch(&sampler, parent, 8, 0, 1), 2);
		assert_int_equal(alone[(int)(u[1] * 4.0f) * 4 + (int)(u[0] * 4.0f)]++, 0);
	}
}

/* ---- evenness and independence ----------------------------------------------------------------------------------- */

#define BINS 8

/* Pearson's chi-square of pairs in BINS x BINS equal bins: that many degrees of freedom less one; four standard
 * deviations above the mean. */
static void assert_even(const uint32_t bins[BINS * BINS], uint32_t count, const char *what, int kind)
{
	double expected = (double)count / (BINS * BINS), freedom = BINS * BINS - 1;
	double sum = 0.0;
	for (int i = 0; i < BINS * BINS; i++)
		sum += (bins[i] - expected) * (bins[i] - expected) / expected;
	if (sum > freedom + 4.0 * sqrt(2.0 * freedom))
		fail_msg("%s, sampler %d: chi-square %g for %g degrees of freedom", what, kind, sum, freedom);
}

static uint32_t bin_of(float x, float y)
{
	return (uint32_t)(x * BINS) * BINS + (uint32_t)(y * BINS);
}

/* One sample of each of many pixels: the sampler has nothing to even out there but at random (blue noise evens out over
 * pixels and is too good for chance, never too bad). Pairs of numbers: of one pair of dimensions, of two, of two
 * vertices, of neighbours in the picture, and of a sample and its branch. */
static void numbers_are_even_and_independent(void **state)
{
	(void)state;
	for (int k = 0; k < KINDS; k++) {
		enum { SIDE = 128 };
		gi_sampler sampler = gi_sampler_make(kinds[k], 11, 5);
		uint32_t pair[BINS * BINS] = {0}, two[BINS * BINS] = {0}, vertices[BINS * BINS] = {0};
		uint32_t neighbours[BINS * BINS] = {0}, branch[BINS * BINS] = {0};
		for (uint32_t y = 0; y < SIDE; y++)
			for (uint32_t x = 0; x < SIDE; x++) {
				gi_point point = gi_sampler_point(&sampler, x, y, x % 5);
				gi_point next = gi_sampler_point(&sampler, x + 1, y, x % 5);
				float a[8], b[8];
				gi_sample_8(&sampler, point, 8, a);
				gi_sample_8(&sampler, point, 16, b);
				pair[bin_of(a[0], a[1])]++;
				two[bin_of(a[0], a[2])]++;
				vertices[bin_of(a[1], b[1])]++;
				gi_sample_8(&sampler, next, 8, b);
				neighbours[bin_of(a[0], b[0])]++;
				gi_sample_8(&sampler, gi_sampler_branch(&sampler, point, 8, 2, 3), 8, b);
				branch[bin_of(a[0], b[0])]++;
			}
		assert_even(pair, SIDE * SIDE, "a pair", k);
		assert_even(two, SIDE * SIDE, "two pairs", k);
		assert_even(vertices, SIDE * SIDE, "two vertices", k);
		assert_even(branch, SIDE * SIDE, "a branch", k);
		if (kinds[k] != STILB_GI_SAMPLER_BLUE_NOISE)
			assert_even(neighbours, SIDE * SIDE, "neighbours", k);
	}
}

/* A grid with more cells than points leaves every cell out as often. */
static void odd_counts_are_not_biased(void **state)
{
	(void)state;
	uint32_t bins[BINS * BINS] = {0};
	gi_sampler sampler = gi_sampler_make(STILB_GI_SAMPLER_STRATIFIED, 1, 7);
	for (uint32_t i = 0; i < 7 * 4000; i++) {
		stilb_vec2 u = gi_sample_2d(&sampler, gi_sampler_point(&sampler, i / 7, 0, i % 7), 0);
		bins[bin_of(u[0], u[1])]++;
	}
	assert_even(bins, 7 * 4000, "7 samples", STILB_GI_SAMPLER_STRATIFIED);
}

static void branches_differ_by_dimension_parent_and_number(void **state)
{
	(void)state;
	for (int k = 0; k < KINDS; k++) {
		gi_sampler sampler = gi_sampler_make(kinds[k], 1, 4);
		float seen[64];
		int count = 0;
		for (uint32_t sample = 0; sample < 4; sample++)
			for (uint32_t dimension = 8; dimension < 40; dimension += 8)
				for (uint32_t i = 0; i < 4; i++) {
					gi_point parent = gi_sampler_point(&sampler, 3, 4, sample);
					gi_point point = gi_sampler_branch(&sampler, parent, dimension, i, 4);
					seen[count] = gi_sample_2d(&sampler, point, 2)[1];
					for (int other = 0; other < count; other++)
						assert_true(seen[other] != seen[count]);
					count++;
				}
	}
}

/* ---- what pictures get ------------------------------------------------------------------------------------------- */

/* Ambient occlusion of a plane at the foot of an infinite wall that fills elevations below 45 degrees on its side: a
 * cosine sample sees the sky unless it goes to the wall's side and below. AO = (1 + cos 45) / 2 (docs/gi.md). */
static double wall_occlusion(stilb_vec2 u)
{
	shade_sample s = shade_sample_cosine(u);
	return s.direction[0] > 0.0f && s.direction[2] < s.direction[0] ? 0.0 : 1.0;
}
#define WALL_TRUTH (0.5 * (1.0 + 0.70710678118654752))

/* Irradiance over pi below a sky that is brighter upwards, L = 1 + cos: 1 + 2/3. */
static double sky_cosine(stilb_vec2 u)
{
	return 1.0 + (double)shade_sample_cosine(u).direction[2];
}

static double sky_uniform(stilb_vec2 u)
{
	double z = (double)shade_sample_hemisphere(u).direction[2];
	return 2.0 * z * (1.0 + z);
}
#define SKY_TRUTH (5.0 / 3.0)

/* Mean square error of 256 rays over 200 pixels. */
static double square_error(stilb_gi_sampler_kind kind, double (*f)(stilb_vec2 u), double truth)
{
	gi_sampler sampler = gi_sampler_make(kind, 5, 1);
	double error = 0.0;
	for (uint32_t pixel = 0; pixel < 200; pixel++) {
		double sum = 0.0;
		gi_point parent = gi_sampler_point(&sampler, pixel, 0, 0);
		for (uint32_t i = 0; i < 256; i++)
			sum += f(gi_sample_2d(&sampler, gi_sampler_branch(&sampler, parent, 8, i, 256), 0));
		error += (sum / 256.0 - truth) * (sum / 256.0 - truth);
	}
	return error / 200.0;
}

/* Random numbers have the variance of theory; strata and nets beat them by these factors at least. */
static void samplers_differ_in_variance(void **state)
{
	(void)state;
	double theory = WALL_TRUTH * (1.0 - WALL_TRUTH) / 256.0;
	double random = square_error(STILB_GI_SAMPLER_RANDOM, wall_occlusion, WALL_TRUTH);
	double stratified = square_error(STILB_GI_SAMPLER_STRATIFIED, wall_occlusion, WALL_TRUTH);
	double sobol = square_error(STILB_GI_SAMPLER_SOBOL, wall_occlusion, WALL_TRUTH);
	print_message("ao, 256 rays: variance of random / stratified %.1f, random / sobol %.1f\n", random / stratified,
	              random / sobol);
	SHADE_PROOF_NEAR(random, theory, 0.4, 0.0); /* four standard deviations of 200 squares */
	assert_true(stratified < random / 10.0 && sobol < random / 10.0);
	double smooth_random = square_error(STILB_GI_SAMPLER_RANDOM, sky_cosine, SKY_TRUTH);
	double smooth_stratified = square_error(STILB_GI_SAMPLER_STRATIFIED, sky_cosine, SKY_TRUTH);
	double smooth_sobol = square_error(STILB_GI_SAMPLER_SOBOL, sky_cosine, SKY_TRUTH);
	print_message("sky, 256 rays: variance of random / stratified %.0f, random / sobol %.0f\n",
	              smooth_random / smooth_stratified, smooth_random / smooth_sobol);
	assert_true(smooth_stratified < smooth_random / 300.0 && smooth_sobol < smooth_random / 150.0);
}

/* A final gather: the cosine chosen by the directions instead of weighing them. Variances by theory: 17/6 - 25/9 for
 * cosine, 62/15 - 25/9 for uniform directions, 24.4 times as much. */
static void cosine_directions_beat_uniform_ones(void **state)
{
	(void)state;
	double cosine = square_error(STILB_GI_SAMPLER_RANDOM, sky_cosine, SKY_TRUTH);
	double uniform = square_error(STILB_GI_SAMPLER_RANDOM, sky_uniform, SKY_TRUTH);
	print_message("sky, 256 random rays: variance of uniform / cosine %.1f\n", uniform / cosine);
	SHADE_PROOF_NEAR(cosine, (17.0 / 6.0 - 25.0 / 9.0) / 256.0, 0.4, 0.0);
	SHADE_PROOF_NEAR(uniform, (62.0 / 15.0 - 25.0 / 9.0) / 256.0, 0.4, 0.0);
}

#define PICTURE 64

/* Power of the error of a picture of the wall at frequencies of less than 4 in its width, over the mean power at
 * all. */
static double low_frequencies(stilb_gi_sampler_kind kind, uint32_t samples)
{
	static double error[PICTURE][PICTURE];
	double low = 0.0, all = 0.0;
	int count = 0;
	gi_sampler sampler = gi_sampler_make(kind, 9, samples);
	for (uint32_t y = 0; y < PICTURE; y++)
		for (uint32_t x = 0; x < PICTURE; x++) {
			error[y][x] = -WALL_TRUTH;
			for (uint32_t i = 0; i < samples; i++)
				error[y][x] += wall_occlusion(gi_sample_2d(&sampler, gi_sampler_point(&sampler, x, y, i), 8)) / samples;
			all += error[y][x] * error[y][x];
		}
	for (int v = 0; v < 4; v++)
		for (int u = v ? -3 : 0; u < 4; u++) { /* the other half is conjugate */
			double real = 0.0, imaginary = 0.0;
			if (u * u + v * v >= 16)
				continue;
			for (int y = 0; y < PICTURE; y++)
				for (int x = 0; x < PICTURE; x++) {
					double phase = 2.0 * M_PI * (u * x + v * y) / PICTURE;
					real += error[y][x] * cos(phase);
					imaginary += error[y][x] * sin(phase);
				}
			low += real * real + imaginary * imaginary;
			count++;
		}
	return low / count / all;
}

/* White noise has the same power everywhere; blue noise little where the eye sees most. The error in all is the
 * same. */
static void blue_noise_lacks_low_frequencies(void **state)
{
	(void)state;
	for (uint32_t samples = 1; samples <= 16; samples *= 4) {
		double white = low_frequencies(STILB_GI_SAMPLER_SOBOL, samples);
		double blue = low_frequencies(STILB_GI_SAMPLER_BLUE_NOISE, samples);
		print_message(
			"%u samples a pixel: low frequencies have %.2f of the mean power with sobol, %.2f with blue_noise\n",
			samples, white, blue);
		assert_true(white > 0.5 && white < 2.0 && blue < 0.4);
	}
}

/* The orders of the four pixels of a square: each of the 24 as often. */
static void every_order_of_four_pixels_occurs(void **state)
{
	(void)state;
	uint32_t seen[256] = {0}, orders = 0;
	gi_sampler sampler = gi_sampler_make(STILB_GI_SAMPLER_BLUE_NOISE, 3, 1);
	for (uint32_t square = 0; square < 2400; square++) {
		uint32_t order = 0;
		for (uint32_t i = 0; i < 4; i++) {
			gi_point point = gi_sampler_point(&sampler, square % 64 * 2 + (i & 1), square / 64 * 2 + (i >> 1), 0);
			uint32_t reversed = gi_reverse(gi_owen_hash(gi_reverse(point.index), (uint32_t)point.hash));
			order = order << 2 | (reversed & 3);
		}
		seen[order]++;
	}
	for (uint32_t order = 0; order < 256; order++) {
		orders += seen[order] > 0;
		assert_true(seen[order] == 0 || (seen[order] > 60 && seen[order] < 140)); /* 100 +- 4 standard deviations */
	}
	assert_int_equal(orders, 24);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(second_coordinate_is_pascals_triangle),
		cmocka_unit_test(scrambling_is_owens),
		cmocka_unit_test(versions_agree_in_every_bit),
		cmocka_unit_test(numbers_are_the_same_by_ones_pairs_and_eights),
		cmocka_unit_test(numbers_stay_what_they_are),
		cmocka_unit_test(every_aligned_run_of_sobol_points_is_a_net),
		cmocka_unit_test(branches_of_sobol_points_are_nets_alone_and_together),
		cmocka_unit_test(blue_noise_points_of_a_square_are_a_net),
		cmocka_unit_test(stratified_points_have_cells_of_their_own),
		cmocka_unit_test(branches_of_stratified_points_have_cells_of_their_own),
		cmocka_unit_test(numbers_are_even_and_independent),
		cmocka_unit_test(odd_counts_are_not_biased),
		cmocka_unit_test(branches_differ_by_dimension_parent_and_number),
		cmocka_unit_test(samplers_differ_in_variance),
		cmocka_unit_test(cosine_directions_beat_uniform_ones),
		cmocka_unit_test(blue_noise_lacks_low_frequencies),
		cmocka_unit_test(every_order_of_four_pixels_occurs),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
