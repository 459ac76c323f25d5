/* numeric_prefilter.h: the mips of a cube against closed forms and brute-force quadrature of the same source, where its
 * faces lie, what it keeps of the light, and that neither rows' order nor threads change a bit. */
#include "numeric/numeric_prefilter.h"

#include "jobs/job.h"
#include "numeric/numeric_quadrature.h"
#include "numeric/numeric_sh.h"
#include "support/shade_proof.h"

#include <string.h>

#define SLOW (TEST_EMULATED || TEST_ASAN || TEST_TSAN) /* the formulas are proved by the other builds */

/* ---- sources and cubes ------------------------------------------------------------------------------------------- */

static stilb_image made_map(uint32_t width, uint32_t height, uint32_t channels)
{
	stilb_image map;
	assert_int_equal(stilb_image_create(&map, width, height, channels, STILB_IMAGE_F32_LINEAR), STILB_OK);
	return map;
}

static float *texel_of(const stilb_image *map, uint32_t x, uint32_t y)
{
	return (float *)map->pixels + ((size_t)y * map->width + x) * map->channels;
}

/* Light that has a different linear part in each channel: 1 + d / 2. */
static stilb_image linear_map(uint32_t width)
{
	stilb_image map = made_map(width, width / 2, 3);
	for (uint32_t y = 0; y < map.height; y++)
		for (uint32_t x = 0; x < width; x++) {
			double d[3];
			stilb_numeric_latlong_direction((x + 0.5) / width, (y + 0.5) / map.height, d);
			for (int c = 0; c < 3; c++)
				texel_of(&map, x, y)[c] = (float)(1.0 + 0.5 * d[c]);
		}
	return map;
}

/* Noise, and a lamp of one texel that gives as much light as all the rest. */
static stilb_image random_map(uint32_t width, uint32_t seed)
{
	stilb_image map = made_map(width, width / 2, 3);
	for (uint32_t i = 0; i < width * map.height * 3; i++)
		((float *)map.pixels)[i] = 2.0f * stilb_random_float(seed, i);
	float *lamp = texel_of(&map, width * 5 / 7, map.height / 3);
	for (int c = 0; c < 3; c++)
		lamp[c] = 0.5f * (float)(width * map.height);
	return map;
}

static void *made_cube(stilb_numeric_prefilter_source source, stilb_numeric_prefilter_settings settings)
{
	void *cube = stilb_memory_alloc(1, stilb_numeric_prefilter_offset(&settings, settings.mips, 0));
	stilb_numeric_prefilter *work;
	assert_non_null(cube);
	assert_int_equal(stilb_numeric_prefilter_create(&source, &settings, cube, &work), STILB_OK);
	for (uint32_t stage = 0; stage < STILB_NUMERIC_PREFILTER_STAGES; stage++)
		stilb_numeric_prefilter_run(work, stage, 0, stilb_numeric_prefilter_rows(work, stage));
	stilb_numeric_prefilter_destroy(work);
	return cube;
}

static const float *cube_texel(const void *cube, const stilb_numeric_prefilter_settings *settings, uint32_t mip,
                               uint32_t face, uint32_t x, uint32_t y)
{
	const char *from = (const char *)cube + stilb_numeric_prefilter_offset(settings, mip, face);
	return (const float *)(const void *)from + 4 * (y * (settings->face >> mip) + x);
}

/* Axis and sign of s, t and the face's own axis: "Cube map face and coordinate selection" of Vulkan 1.3, 16.5.4, read
 * backwards. */
static const struct {
	int axis, side, s_axis, s_side, t_axis, t_side;
} faces[6] = {
	{0, 1, 2, -1, 1, -1}, {0, -1, 2, 1, 1, -1}, {1, 1, 0, 1, 2, 1},
	{1, -1, 0, 1, 2, -1}, {2, 1, 0, 1, 1, -1},  {2, -1, 0, -1, 1, -1},
};

/* The unit direction of a place on a face: u, v in [0, 1] from its top left corner. */
static void face_direction(uint32_t face, double u, double v, double d[3])
{
	double s = 2.0 * u - 1.0, t = 2.0 * v - 1.0, length = sqrt(1.0 + s * s + t * t);
	d[faces[face].axis] = faces[face].side / length;
	d[faces[face].s_axis] = faces[face].s_side * s / length;
	d[faces[face].t_axis] = faces[face].t_side * t / length;
}

/* ---- quadrature -------------------------------------------------------------------------------------------------- */

#define PARTS 12 /* along a side of a texel of the source */

/* D(h) G1(l) of the angle whose cosine this is, over some constant. */
static double lobe_at(double cosine, double alpha)
{
	double alpha2 = alpha * alpha, sine2 = 0.5 * (1.0 - cosine), bracket = alpha2 + sine2 * (1.0 - alpha2);
	double masking = cosine / (cosine + sqrt(cosine * cosine + alpha2 * (1.0 - cosine * cosine)));
	return cosine > 0.0 ? masking / (bracket * bracket) : 0.0;
}

/* The weighted mean of a map about n. range > 0: with firefly weights. */
static void quadrature(const stilb_image *map, double roughness, const double n[3], double range, double mean[3])
{
	double sums[4] = {0.0};
	uint32_t width = map->width * PARTS, height = map->height * PARTS;
	for (uint32_t y = 0; y < height; y++) {
		double solid = cos(M_PI * y / height) - cos(M_PI * (y + 1.0) / height), theta = M_PI * (y + 0.5) / height;
		double sine = sin(theta), up = cos(theta) * n[1];
		for (uint32_t x = 0; x < width; x++) {
			double phi = 2.0 * M_PI * ((x + 0.5) / width - 0.5);
			double cosine = sine * (sin(phi) * n[0] - cos(phi) * n[2]) + up;
			if (cosine <= 0.0)
				continue;
			const float *texel = texel_of(map, x / PARTS, y / PARTS);
			double luminance = 0.2126 * (double)texel[0] + 0.7152 * (double)texel[1] + 0.0722 * (double)texel[2];
			double weight = lobe_at(cosine, roughness * roughness) * solid;
			weight *= range > 0.0 ? range / (range + luminance) : 1.0;
			for (int c = 0; c < 3; c++)
				sums[c] += weight * (double)texel[c];
			sums[3] += weight;
		}
	}
	for (int c = 0; c < 3; c++)
		mean[c] = sums[c] / sums[3];
}

/* Compares texels of a mip with quadrature: the root of the mean square error is at most `bound` of their mean. */
static void assert_mip(const stilb_image *map, const void *cube, const stilb_numeric_prefilter_settings *settings,
                       uint32_t mip, double bound)
{
	uint32_t side = settings->face >> mip, count = SLOW ? 6 : 24;
	double error = 0.0, sum = 0.0;
	for (uint32_t i = 0; i < count; i++) {
		uint32_t face = i % 6, x = (uint32_t)(stilb_random_u64(3, 2 * i) % side);
		uint32_t y = (uint32_t)(stilb_random_u64(3, 2 * i + 1) % side);
		double n[3], want[3];
		face_direction(face, (x + 0.5) / side, (y + 0.5) / side, n);
		quadrature(map, (double)mip / (settings->mips - 1), n, (double)settings->firefly_range, want);
		const float *got = cube_texel(cube, settings, mip, face, x, y);
		for (int c = 0; c < 3; c++) {
			error += ((double)got[c] - want[c]) * ((double)got[c] - want[c]);
			sum += want[c];
		}
	}
	error = sqrt(error / (3 * count)) / (sum / (3 * count));
	if (!(error <= bound))
		fail_msg("mip %u is off by %g of its mean, not %g", mip, error, bound);
}

static void mips_are_quadrature(void **state)
{
	(void)state;
	stilb_image map = random_map(64, 1);
	stilb_numeric_prefilter_settings settings = {.face = 32, .mips = 6};
	void *cube = made_cube((stilb_numeric_prefilter_source){.panorama = &map}, settings);
	for (uint32_t mip = 1; mip < settings.mips; mip += SLOW ? 2 : 1)
		assert_mip(&map, cube, &settings, mip, 1e-3);
	free(cube);
	stilb_image_finish(&map);
}

/* Alpha of mip 1 is 1/49, and a texel of the source is ten times as wide. Here quadrature itself is off by 4e-3. */
static void narrow_lobes_are_quadrature(void **state)
{
	(void)state;
	if (TEST_EMULATED)
		return; /* it takes a third of all the time, for the same code with more harmonics */
	stilb_image map = random_map(32, 2);
	stilb_numeric_prefilter_settings settings = {.face = 128, .mips = 8};
	void *cube = made_cube((stilb_numeric_prefilter_source){.panorama = &map}, settings);
	assert_mip(&map, cube, &settings, 1, 5e-3);
	assert_mip(&map, cube, &settings, 2, 1e-3);
	free(cube);
	stilb_image_finish(&map);
}

/* Lamps beside the poles, on black, seen from texels around them: their light is spread across the pole. */
static void poles_are_no_place_of_their_own(void **state)
{
	(void)state;
	stilb_image map = made_map(32, 16, 3);
	for (int c = 0; c < 3; c++)
		texel_of(&map, 9, 0)[c] = texel_of(&map, 20, 15)[c] = 1000.0f;
	stilb_numeric_prefilter_settings settings = {.face = 64, .mips = 7};
	void *cube = made_cube((stilb_numeric_prefilter_source){.panorama = &map}, settings);
	double error = 0.0, sum = 0.0;
	for (uint32_t i = 0; i < 32; i += SLOW ? 5 : 1) {
		uint32_t face = 2 + i / 16, x = 14 + i % 4, y = 14 + i / 4 % 4;
		double n[3], want[3];
		face_direction(face, (x + 0.5) / 32, (y + 0.5) / 32, n);
		quadrature(&map, 1.0 / 6.0, n, 0.0, want);
		error += pow((double)cube_texel(cube, &settings, 1, face, x, y)[0] - want[0], 2.0);
		sum += want[0];
	}
	error = sqrt(error / (SLOW ? 7 : 32)) / (sum / (SLOW ? 7 : 32));
	if (!(error < 2e-3))
		fail_msg("around the poles mip 1 is off by %g of its mean", error);
	size_t count = stilb_numeric_prefilter_offset(&settings, settings.mips, 0) / sizeof(float);
	for (size_t i = 0; i < count; i++)
		assert_true(((const float *)cube)[i] >= 0.0f);
	free(cube);
	stilb_image_finish(&map);
}

static void fireflies_are_weighted(void **state)
{
	(void)state;
	stilb_image map = random_map(64, 4);
	stilb_numeric_prefilter_settings settings = {.face = 16, .mips = 4, .firefly_range = 2.0f};
	void *cube = made_cube((stilb_numeric_prefilter_source){.panorama = &map}, settings);
	for (uint32_t mip = 1; mip < settings.mips; mip++)
		assert_mip(&map, cube, &settings, mip, 1e-3);
	free(cube);
	stilb_image_finish(&map);
}

/* ---- mip 0 ------------------------------------------------------------------------------------------------------- */

#define SHARED_SIDE 16u
#define SHARED_POINTS 1500 /* around the equator, at least */

/* Shares a point's light out to the four texels of a face around it. sums: [side][side][2], light and its weights. */
static void share_out(double (*sums)[2], uint32_t face, const double d[3], double weight, double light)
{
	double size = d[faces[face].axis] * faces[face].side;
	if (size <= 0.3)
		return;
	double x = (d[faces[face].s_axis] * faces[face].s_side / size + 1.0) * SHARED_SIDE / 2 - 0.5;
	double y = (d[faces[face].t_axis] * faces[face].t_side / size + 1.0) * SHARED_SIDE / 2 - 0.5;
	for (int i = 0; i < 4; i++) {
		int column = (int)floor(x) + i % 2, row = (int)floor(y) + i / 2;
		if (column < 0 || row < 0 || column >= (int)SHARED_SIDE || row >= (int)SHARED_SIDE)
			continue;
		double part = weight * (1.0 - fabs(x - column)) * (1.0 - fabs(y - row));
		sums[row * (int)SHARED_SIDE + column][0] += part * light;
		sums[row * (int)SHARED_SIDE + column][1] += part;
	}
}

/* Mip 0 against the same sharing of many points; from sources that are coarser and finer than it. */
static void assert_shared_out(uint32_t width, double bound)
{
	stilb_image map = random_map(width, width);
	texel_of(&map, width * 5 / 7, map.height / 3)[1] = 20.0f; /* its lamp */
	stilb_numeric_prefilter_settings settings = {.face = SHARED_SIDE, .mips = 2};
	void *cube = made_cube((stilb_numeric_prefilter_source){.panorama = &map}, settings);
	static double sums[6][SHARED_SIDE * SHARED_SIDE][2];
	memset(sums, 0, sizeof sums);
	uint32_t each = SHARED_POINTS / width, across = width * each, down = map.height * each;
	for (uint32_t i = 0; i < across * down; i++) {
		uint32_t x = i % across, y = i / across;
		double d[3], solid = sin(M_PI * (y + 0.5) / down);
		stilb_numeric_latlong_direction((x + 0.5) / across, (y + 0.5) / down, d);
		double light = (double)texel_of(&map, x / each, y / each)[1];
		for (uint32_t face = 0; face < 6; face++)
			share_out(sums[face], face, d, solid, light);
	}
	double error = 0.0, sum = 0.0;
	for (uint32_t i = 0; i < 6 * SHARED_SIDE * SHARED_SIDE; i++) {
		const double *want = sums[i / (SHARED_SIDE * SHARED_SIDE)][i % (SHARED_SIDE * SHARED_SIDE)];
		error += pow((double)((const float *)cube)[4 * i + 1] - want[0] / want[1], 2.0);
		sum += want[0] / want[1];
	}
	uint32_t count = 6 * SHARED_SIDE * SHARED_SIDE;
	error = sqrt(error / count) / (sum / count);
	if (!(error <= bound))
		fail_msg("mip 0 of a panorama of %u columns is off by %g of its mean, not %g", width, error, bound);
	free(cube);
	stilb_image_finish(&map);
}

static void light_is_shared_out(void **state)
{
	(void)state;
	if (!SLOW) {
		assert_shared_out(10, 0.02);
		assert_shared_out(64, 0.02);
		assert_shared_out(256, 0.02); /* parts are as small as points */
	}
	assert_shared_out(512, 0.03); /* parts are of two texels each way */
}

/* ---- closed forms ------------------------------------------------------------------------------------------------ */

typedef struct moment {
	double alpha;
	int power; /* of the cosine */
} moment;

static double moment_at(double cosine, const void *context)
{
	const moment *m = context;
	return lobe_at(cosine, m->alpha) * pow(cosine, m->power);
}

/* The lobe of this alpha about n, over a texel of a map of 512 x 256: its share of a light of 1. */
static double lobe_over_texel(const double n[3], uint32_t column, uint32_t row, double alpha)
{
	moment none = {alpha, 0};
	double sum = 0.0, below = cos(M_PI * row / 256);
	for (int i = 0; i < 8; i++) {
		double above = below, d[3];
		below = cos(M_PI * (row + (i + 1) / 8.0) / 256);
		stilb_numeric_latlong_direction((column + 0.5) / 512, (row + (i + 0.5) / 8) / 256, d);
		sum += (above - below) * lobe_at(n[0] * d[0] + n[1] * d[1] + n[2] * d[2], alpha);
	}
	return sum / (512 * stilb_numeric_integrate(moment_at, &none, 0.0, 1.0, 400));
}

/* One lit texel close to a pole: a mip is the lobe itself, about where the texel is. */
static void lamps_beside_poles_show_the_lobe(void **state)
{
	(void)state;
	for (uint32_t k = 0; k < 4; k += SLOW ? 3 : 1) {
		stilb_image map = made_map(512, 256, 1);
		uint32_t column = 100 + 60 * k, row = k < 2 ? k : 251 + k; /* 0, 1, 253, 254 */
		*texel_of(&map, column, row) = 1.0f;
		stilb_numeric_prefilter_settings settings = {.face = 16, .mips = 3};
		void *cube = made_cube((stilb_numeric_prefilter_source){.panorama = &map}, settings);
		const double pole[3] = {0.0, k < 2 ? 1.0 : -1.0, 0.0};
		double most = lobe_over_texel(pole, column, row, 0.25);
		for (uint32_t i = 0; i < 64; i++) {
			uint32_t face = k < 2 ? 2 : 3;
			double n[3];
			face_direction(face, (i % 8 + 0.5) / 8, (i / 8 + 0.5) / 8, n);
			double got = (double)cube_texel(cube, &settings, 1, face, i % 8, i / 8)[0];
			SHADE_PROOF_NEAR(got, lobe_over_texel(n, column, row, 0.25), 0.0, 6e-4 * most);
		}
		free(cube);
		stilb_image_finish(&map);
	}
}

/* The mean of 1 + d / 2 over a lobe about n is 1 + k n / 2, k being the lobe's mean cosine. */
static void linear_light_has_its_closed_form(void **state)
{
	(void)state;
	stilb_image map = linear_map(256);
	stilb_numeric_prefilter_settings settings = {.face = 32, .mips = 6};
	void *cube = made_cube((stilb_numeric_prefilter_source){.panorama = &map}, settings);
	for (uint32_t mip = 0; mip < settings.mips; mip++) {
		double roughness = (double)mip / (settings.mips - 1);
		moment none = {roughness * roughness, 0}, one = {roughness * roughness, 1};
		double k = mip == 0 ? 1.0
		                    : stilb_numeric_integrate(moment_at, &one, 0.0, 1.0, 400) /
		                          stilb_numeric_integrate(moment_at, &none, 0.0, 1.0, 400);
		uint32_t side = settings.face >> mip;
		for (uint32_t i = 0; i < 6 * side * side; i++) {
			uint32_t x = i % side, y = i / side % side, face = i / side / side;
			double n[3];
			face_direction(face, (x + 0.5) / side, (y + 0.5) / side, n);
			const float *got = cube_texel(cube, &settings, mip, face, x, y);
			for (int c = 0; c < 3; c++)
				SHADE_PROOF_NEAR(got[c], 1.0 + 0.5 * k * n[c], 0.0, mip == 0 ? 2e-3 : 2e-4);
			assert_true(got[3] == 1.0f);
		}
	}
	free(cube);
	stilb_image_finish(&map);
}

static void white_stays_white(void **state)
{
	(void)state;
	static const uint32_t widths[] = {1, 5, 40, 300};
	for (size_t k = 0; k < sizeof widths / sizeof widths[0]; k++) {
		stilb_image map = made_map(widths[k], widths[k] / 2 + 1, 1);
		for (uint32_t i = 0; i < map.width * map.height; i++)
			((float *)map.pixels)[i] = 1.0f;
		stilb_numeric_prefilter_settings settings = {.face = 16, .mips = 5, .halves = true};
		uint16_t *cube = made_cube((stilb_numeric_prefilter_source){.panorama = &map}, settings);
		for (size_t i = 0; i < stilb_numeric_prefilter_offset(&settings, 5, 0) / sizeof *cube; i++)
			assert_int_equal(cube[i], 0x3c00);
		free(cube);
		stilb_image_finish(&map);
	}
}

/* A lamp of one texel: mip 0 has all of its light, also at the poles, at sides and at corners of faces. */
static void lamps_keep_their_light(void **state)
{
	(void)state;
	static const uint32_t places[][2] = {{10, 0}, {77, 63}, {16, 32}, {0, 31}, {127, 40}, {80, 20}, {48, 12}, {64, 32}};
	for (size_t k = 0; k < sizeof places / sizeof places[0]; k += SLOW ? 3 : 1) {
		stilb_image map = made_map(128, 64, 3);
		texel_of(&map, places[k][0], places[k][1])[1] = 1000.0f;
		stilb_numeric_prefilter_settings settings = {.face = 64, .mips = 2};
		void *cube = made_cube((stilb_numeric_prefilter_source){.panorama = &map}, settings);
		double sum = 0.0, top = M_PI * places[k][1] / 64;
		for (uint32_t i = 0; i < 6 * 64 * 64; i++) {
			double s = (2.0 * (i % 64) + 1.0) / 64 - 1.0, t = (2.0 * (i / 64 % 64) + 1.0) / 64 - 1.0;
			double solid = pow(1.0 + s * s + t * t, -1.5) * (2.0 / 64) * (2.0 / 64);
			sum += solid * (double)cube_texel(cube, &settings, 0, i / 4096, i % 64, i / 64 % 64)[1];
		}
		SHADE_PROOF_NEAR(sum, 1000.0 * (cos(top) - cos(top + M_PI / 64)) * 2.0 * M_PI / 128, 0.03, 0.0);
		free(cube);
		stilb_image_finish(&map);
	}
}

/* ---- cubes ------------------------------------------------------------------------------------------------------- */

/* Six faces of the same light as linear_map. */
static void linear_faces(uint32_t side, stilb_image images[6])
{
	for (uint32_t face = 0; face < 6; face++) {
		images[face] = made_map(side, side, 4);
		for (uint32_t i = 0; i < side * side; i++) {
			double d[3];
			face_direction(face, (i % side + 0.5) / side, (i / side + 0.5) / side, d);
			for (int c = 0; c < 4; c++)
				texel_of(&images[face], i % side, i / side)[c] = c < 3 ? (float)(1.0 + 0.5 * d[c]) : NAN;
		}
	}
}

static void cubes_are_filtered_like_panoramas(void **state)
{
	(void)state;
	stilb_image map = linear_map(512), images[6];
	linear_faces(32, images);
	stilb_numeric_prefilter_settings settings = {.face = 32, .mips = 6};
	float *of_map = made_cube((stilb_numeric_prefilter_source){.panorama = &map}, settings);
	float *of_faces = made_cube((stilb_numeric_prefilter_source){.faces = images}, settings);
	for (size_t i = 0; i < stilb_numeric_prefilter_offset(&settings, 6, 0) / sizeof(float); i++)
		SHADE_PROOF_NEAR(of_faces[i], (double)of_map[i], 0.0, 2e-3);
	/* A cube of the same side is its own mip 0. */
	for (uint32_t i = 0; i < 6 * 32 * 32; i++)
		for (int c = 0; c < 3; c++) {
			double own = (double)texel_of(&images[i / 1024], i % 32, i / 32 % 32)[c];
			SHADE_PROOF_NEAR(of_faces[4 * i + c], own, 1e-6, 0.0);
		}
	free(of_map);
	free(of_faces);
	stilb_image_finish(&map);
	for (int face = 0; face < 6; face++)
		stilb_image_finish(&images[face]);
}

/* From a finer cube, a texel of mip 0 is the mean of its own, weighted with their solid angles. */
static void finer_cubes_are_averaged(void **state)
{
	(void)state;
	stilb_image images[6];
	linear_faces(64, images);
	for (uint32_t i = 0; i < 64 * 64; i++)
		((float *)images[4].pixels)[4 * i] = stilb_random_float(9, i);
	stilb_numeric_prefilter_settings settings = {.face = 8, .mips = 2};
	void *cube = made_cube((stilb_numeric_prefilter_source){.faces = images}, settings);
	for (uint32_t k = 0; k < 64; k++) {
		double sums[2] = {0.0, 0.0};
		for (uint32_t i = 0; i < 64; i++) {
			uint32_t x = k % 8 * 8 + i % 8, y = k / 8 * 8 + i / 8;
			double s = (2.0 * x + 1.0) / 64 - 1.0, t = (2.0 * y + 1.0) / 64 - 1.0;
			double solid = pow(1.0 + s * s + t * t, -1.5);
			sums[0] += solid * (double)texel_of(&images[4], x, y)[0];
			sums[1] += solid;
		}
		SHADE_PROOF_NEAR(cube_texel(cube, &settings, 0, 4, k % 8, k / 8)[0], sums[0] / sums[1], 1e-5, 0.0);
	}
	free(cube);
	for (int face = 0; face < 6; face++)
		stilb_image_finish(&images[face]);
}

/* ---- values ------------------------------------------------------------------------------------------------------ */

static void mistakes_in_maps_are_black(void **state)
{
	(void)state;
	stilb_image good = random_map(32, 5), bad = random_map(32, 5);
	const float wrong[] = {NAN, -1.0f, -INFINITY};
	for (uint32_t k = 0; k < 3; k++) {
		memset(texel_of(&good, 7 * k, 4 * k), 0, 3 * sizeof(float));
		for (int c = 0; c < 3; c++)
			texel_of(&bad, 7 * k, 4 * k)[c] = wrong[k];
	}
	texel_of(&good, 30, 9)[0] = 1e15f;
	texel_of(&bad, 30, 9)[0] = INFINITY;
	stilb_numeric_prefilter_settings settings = {.face = 8, .mips = 3};
	size_t size = stilb_numeric_prefilter_offset(&settings, 3, 0);
	void *a = made_cube((stilb_numeric_prefilter_source){.panorama = &good}, settings);
	void *b = made_cube((stilb_numeric_prefilter_source){.panorama = &bad}, settings);
	assert_memory_equal(a, b, size);
	free(a);
	free(b);
	/* Halves are limited. */
	settings.halves = true;
	uint16_t *halves = made_cube((stilb_numeric_prefilter_source){.panorama = &bad}, settings);
	uint16_t most = 0;
	for (size_t i = 0; i < size / sizeof(float); i++)
		most = halves[i] > most ? halves[i] : most;
	assert_int_equal(most, 0x7bff); /* 65504 */
	free(halves);
	stilb_image_finish(&good);
	stilb_image_finish(&bad);
}

/* Halves in the source are the floats that they stand for, and halves of the cube are the nearest to its floats. */
static void halves_are_floats(void **state)
{
	(void)state;
	stilb_image floats = made_map(16, 8, 1), halves;
	assert_int_equal(stilb_image_create(&halves, 16, 8, 1, STILB_IMAGE_F16_LINEAR), STILB_OK);
	for (uint32_t i = 0; i < 128; i++) {
		uint16_t half = (uint16_t)(stilb_random_u64(6, i) % 0x4000); /* below 2, also denormal ones */
		((uint16_t *)halves.pixels)[i] = i % 5 == 0 ? half % 0x400 : half;
		((float *)floats.pixels)[i] = stilb_image_half_to_float(((uint16_t *)halves.pixels)[i]);
	}
	stilb_numeric_prefilter_settings settings = {.face = 16, .mips = 5}, small = settings;
	small.halves = true;
	float *a = made_cube((stilb_numeric_prefilter_source){.panorama = &floats}, settings);
	float *b = made_cube((stilb_numeric_prefilter_source){.panorama = &halves}, settings);
	uint16_t *c = made_cube((stilb_numeric_prefilter_source){.panorama = &halves}, small);
	size_t count = stilb_numeric_prefilter_offset(&settings, 5, 0) / sizeof(float);
	assert_memory_equal(a, b, count * sizeof(float));
	for (size_t i = 0; i < count; i++) {
		float step = stilb_image_half_to_float((uint16_t)(c[i] + 1)) - stilb_image_half_to_float(c[i]);
		assert_true(fabsf(stilb_image_half_to_float(c[i]) - a[i]) <= 0.5f * step);
	}
	free(a);
	free(b);
	free(c);
	stilb_image_finish(&floats);
	stilb_image_finish(&halves);
}

static void bad_sources_are_refused(void **state)
{
	(void)state;
	stilb_image codes, images[6];
	assert_int_equal(stilb_image_create(&codes, 4, 2, 3, STILB_IMAGE_U8_SRGB), STILB_OK);
	linear_faces(4, images);
	stilb_image kept = images[3];
	images[3].height = 3;
	stilb_numeric_prefilter_settings settings = {.face = 8, .mips = 2};
	stilb_vec4 cube[6 * (64 + 16)];
	stilb_numeric_prefilter *work;
	stilb_numeric_prefilter_source of_codes = {.panorama = &codes}, of_faces = {.faces = images};
	assert_int_equal(stilb_numeric_prefilter_create(&of_codes, &settings, cube, &work), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), ".exr"));
	assert_null(work);
	assert_int_equal(stilb_numeric_prefilter_create(&of_faces, &settings, cube, &work), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "face 3"));
	images[3] = kept;
	images[3].width = images[3].height = 2;
	assert_int_equal(stilb_numeric_prefilter_create(&of_faces, &settings, cube, &work), STILB_ERROR_ARGUMENT);
	stilb_numeric_prefilter_destroy(NULL);
	images[3] = kept;
	stilb_image_finish(&codes);
	for (int face = 0; face < 6; face++)
		stilb_image_finish(&images[face]);
}

/* ---- rows -------------------------------------------------------------------------------------------------------- */

typedef struct stage_loop {
	stilb_numeric_prefilter *work;
	uint32_t stage, rows;
} stage_loop;

/* Rows from both ends in turn: no order that a loop would take. */
static void run_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	const stage_loop *loop = context;
	for (uint32_t i = begin; i < end; i++) {
		uint32_t row = i % 2 == 0 ? i / 2 : loop->rows - 1 - i / 2;
		stilb_numeric_prefilter_run(loop->work, loop->stage, row, row + 1);
	}
}

static void assert_rows_in_any_order(stilb_numeric_prefilter_source source)
{
	/* The same code with fewer harmonics where it is slow. */
	stilb_numeric_prefilter_settings settings = {.face = SLOW ? 8 : 16, .mips = SLOW ? 2 : 4};
	size_t size = stilb_numeric_prefilter_offset(&settings, settings.mips, 0);
	void *want = made_cube(source, settings), *got = stilb_memory_alloc(1, size);
	assert_non_null(got);
	stilb_job_pool *pool;
	assert_int_equal(stilb_job_pool_create(&(stilb_job_pool_desc){.worker_count = 3}, &pool), 0);
	stage_loop loop;
	assert_int_equal(stilb_numeric_prefilter_create(&source, &settings, got, &loop.work), STILB_OK);
	for (loop.stage = 0; loop.stage < STILB_NUMERIC_PREFILTER_STAGES; loop.stage++) {
		loop.rows = stilb_numeric_prefilter_rows(loop.work, loop.stage);
		stilb_job_parallel_for(pool, loop.rows, 1, run_slice, &loop, 0);
	}
	stilb_numeric_prefilter_destroy(loop.work);
	stilb_job_pool_destroy(pool);
	assert_memory_equal(got, want, size);
	free(want);
	free(got);
}

static void threads_change_no_bit(void **state)
{
	(void)state;
	stilb_image map = random_map(SLOW ? 16 : 48, 7), images[6];
	linear_faces(SLOW ? 4 : 8, images);
	assert_rows_in_any_order((stilb_numeric_prefilter_source){.panorama = &map});
	assert_rows_in_any_order((stilb_numeric_prefilter_source){.faces = images});
	stilb_image_finish(&map);
	for (int face = 0; face < 6; face++)
		stilb_image_finish(&images[face]);
}

/* ---- offsets ----------------------------------------------------------------------------------------------------- */

static void mips_follow_one_another(void **state)
{
	(void)state;
	stilb_numeric_prefilter_settings settings = {.face = 256, .mips = 7, .halves = true};
	assert_int_equal(stilb_numeric_prefilter_offset(&settings, 0, 0), 0);
	assert_int_equal(stilb_numeric_prefilter_offset(&settings, 0, 5), 5 * 256 * 256 * 8);
	assert_int_equal(stilb_numeric_prefilter_offset(&settings, 1, 2), (6 * 256 * 256 + 2 * 128 * 128) * 8);
	settings.halves = false;
	assert_int_equal(stilb_numeric_prefilter_offset(&settings, 7, 0),
	                 6 * (65536 + 16384 + 4096 + 1024 + 256 + 64 + 16) * 16);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		test_one_thread(mips_are_quadrature),
		test_one_thread(narrow_lobes_are_quadrature),
		test_one_thread(poles_are_no_place_of_their_own),
		test_one_thread(fireflies_are_weighted),
		test_one_thread(light_is_shared_out),
		test_one_thread(lamps_beside_poles_show_the_lobe),
		test_one_thread(linear_light_has_its_closed_form),
		test_one_thread(white_stays_white),
		test_one_thread(lamps_keep_their_light),
		test_one_thread(cubes_are_filtered_like_panoramas),
		test_one_thread(finer_cubes_are_averaged),
		test_one_thread(mistakes_in_maps_are_black),
		test_one_thread(halves_are_floats),
		test_one_thread(bad_sources_are_refused),
		cmocka_unit_test(threads_change_no_bit),
		test_one_thread(mips_follow_one_another),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
