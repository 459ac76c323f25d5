/* The texels of a prefiltered cube. */
#include "numeric/numeric_prefilter_internal.h"

#include "shading/shade_environment.h"

#include <string.h>

/* ---- storage ----------------------------------------------------------------------------------------------------- */

#define HALF_MAX 65504.0f

/* The mean that weighted sums stand for. What is below 0, which a convolution rounds to, is 0. */
static stilb_vec4 write_mean(stilb_vec4 sums)
{
	float scale = 1.0f / fmaxf(sums[3], 1e-30f);
	stilb_vec4 mean = {0.0f, 0.0f, 0.0f, 1.0f};
	for (int c = 0; c < 3; c++)
		mean[c] = fmaxf(sums[c] * scale, 0.0f);
	return mean;
}

/* index: of the texel, from the mip's first one on. */
static void write_texel(const stilb_numeric_prefilter *work, uint32_t mip, size_t index, stilb_vec4 sums)
{
	char *texels = work->mips[mip];
	stilb_vec4 mean = write_mean(sums);
	if (!work->settings.halves) {
		memcpy(texels + index * sizeof mean, &mean, sizeof mean);
		return;
	}
	uint16_t halves[4];
	for (int c = 0; c < 4; c++)
		halves[c] = stilb_image_half_from_float(fminf(mean[c], HALF_MAX));
	memcpy(texels + index * sizeof halves, halves, sizeof halves);
}

/* ---- directions -------------------------------------------------------------------------------------------------- */

/* Of the panorama, radians: from +Y, and from its left side. */
typedef struct write_angles {
	float theta, phi;
} write_angles;

static write_angles write_angles_of(stilb_vec3 d)
{
	float phi = atan2f(d[0], -d[2]) + (float)M_PI;
	return (write_angles){atan2f(sqrtf(d[0] * d[0] + d[2] * d[2]), d[1]), phi};
}

/* ---- mip 0 ------------------------------------------------------------------------------------------------------- */

/* The sums of a band, from a cube: it is interpolated at points that are as dense as its own texels, or denser. */
static void write_look_band(const stilb_numeric_prefilter *work, int number, uint32_t first, stilb_vec4 *sums)
{
	uint32_t side = work->settings.face, samples = (work->source[0].width + side - 1) / side;
	float step = 2.0f / (float)(side * samples);
	stilb_vec4 zero = {0.0f, 0.0f, 0.0f, 0.0f};
	for (uint32_t k = 0; k < numeric_prefilter_band_rows(side) * side; k++) {
		uint32_t x = k % side, y = first + k / side;
		sums[k] = zero;
		for (uint32_t i = 0; i < samples * samples; i++) {
			uint32_t down = y * samples + i / samples;
			float s = ((float)(x * samples + i % samples) + 0.5f) * step - 1.0f;
			float t = ((float)down + 0.5f) * step - 1.0f;
			float square = 1.0f + s * s + t * t;
			sums[k] += numeric_prefilter_look(work, shade_cube_direction(number, s, t)) / (square * sqrtf(square));
		}
	}
}

void numeric_prefilter_write_band(stilb_numeric_prefilter *work, uint32_t band)
{
	uint32_t side = work->settings.face, rows = numeric_prefilter_band_rows(side);
	uint32_t number = band * rows / side, first = band * rows % side;
	stilb_vec4 sums[PREFILTER_BAND_TEXELS];
	if (work->is_cube)
		write_look_band(work, (int)number, first, sums);
	else
		numeric_prefilter_resample(work, number, first, sums);
	for (uint32_t k = 0; k < rows * side; k++)
		write_texel(work, 0, ((size_t)number * side + first) * side + k, sums[k]);
}

/* ---- the other mips ---------------------------------------------------------------------------------------------- */

/* A point of the grid; rings beyond a pole are those on its other side, half a turn away. */
static stilb_vec4 write_point(const prefilter_grid *grid, int32_t ring, uint32_t column)
{
	int32_t rings = (int32_t)(2 * grid->pairs);
	if (ring < 0 || ring >= rings) {
		ring = ring < 0 ? -1 - ring : 2 * rings - 1 - ring;
		column += grid->columns / 2;
	}
	bool north = ring < (int32_t)grid->pairs;
	uint32_t row = (uint32_t)(north ? ring : rings - 1 - ring);
	const prefilter_wave *wave = grid->waves + (size_t)row * grid->columns + (column & (grid->columns - 1));
	return north ? wave->re : wave->im;
}

static stilb_vec4 write_look_grid(const prefilter_grid *grid, stilb_vec3 direction)
{
	write_angles angles = write_angles_of(direction);
	float down = angles.theta * (float)M_1_PI * (float)(2 * grid->pairs) - 0.5f;
	float across = angles.phi * (float)(0.5 * M_1_PI) * (float)grid->columns;
	float top = floorf(down), left = floorf(across);
	stilb_vec4 sum = {0.0f, 0.0f, 0.0f, 0.0f};
	for (int32_t i = -1; i < 3; i++) {
		stilb_vec4 row = {0.0f, 0.0f, 0.0f, 0.0f};
		for (int32_t k = -1; k < 3; k++)
			row += write_point(grid, (int32_t)top + i, (uint32_t)((int32_t)left + k)) *
			       prefilter_cubic(across - left - (float)k);
		sum += row * prefilter_cubic(down - top - (float)i);
	}
	return sum;
}

void numeric_prefilter_write_row(stilb_numeric_prefilter *work, uint32_t mip, uint32_t row)
{
	uint32_t side = work->settings.face >> mip, number = row / side, y = row % side;
	float step = 2.0f / (float)side;
	for (uint32_t x = 0; x < side; x++) {
		stilb_vec3 direction =
			shade_cube_direction((int)number, ((float)x + 0.5f) * step - 1.0f, ((float)y + 0.5f) * step - 1.0f);
		write_texel(work, mip, (size_t)row * side + x, write_look_grid(&work->out[mip], direction));
	}
}
