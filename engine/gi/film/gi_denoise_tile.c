/* gi_denoise_tile: the filter of gi_denoise.h for a tile of the picture, in loops over rows of pixels that the compiler
 * vectorises. All operations are of one pixel at a time and in one order, so that neither tiles nor vectors change a
 * bit. */
#include "gi/film/gi_denoise_internal.h"

#include <math.h>
#include <string.h>

#define SIDE 42                         /* of a tile */
#define REACH 3                         /* a fit takes pixels up to so far away, in both directions */
#define PATCH 1                         /* pixels are compared with so many around them */
#define SPAN (2 * REACH + 1)            /* offsets in one direction */
#define OFFSETS (SPAN * SPAN)           /* from the center of a fit to its pixels, row by row */
#define CENTERS (SIDE + 2 * REACH)      /* side of the square of fits of which a tile's pixels are made */
#define BORDER (2 * REACH + PATCH)      /* of pixels around a tile that are read */
#define READ (SIDE + 2 * BORDER)        /* side of the square that is read */
#define TERMS (3 + GI_DENOISE_FEATURES) /* of a fit: 1, x, y, features */
#define PAIRS (TERMS * (TERMS + 1) / 2) /* of terms, (i, j) with j <= i */
#define RIDGE 1e-3f                     /* added to the squares of all terms but 1, as a share of the weights' sum */
#define LIKENESS 0.81f                  /* k^2 of gi_denoise.h */
#define FARTHEST 8.0f                   /* distance at which pixels have nothing in common */
#define NO_VARIANCE 1e-30f              /* keeps 0 / 0 away */

typedef float tile_plane[READ][READ];
typedef float tile_row[CENTERS];

struct gi_denoise_tile {
	tile_plane color[3];                     /* of the half that is filtered */
	tile_plane shade[3], variance[3];        /* of the other half over its albedo, and its variance */
	tile_plane feature[GI_DENOISE_FEATURES]; /* as in the picture */
	tile_plane there;                        /* 1, or 0 where there is no pixel to be used */
	tile_plane distance, count;              /* for an offset: of single pixels, and 1 where there are two */
	tile_plane distances, counts;            /* their sums over rows of a patch */
	float weight[OFFSETS][CENTERS][CENTERS];
	float fit[3][TERMS][CENTERS][CENTERS];   /* coefficients of the channels */
	tile_row matrix[PAIRS], right[3][TERMS]; /* the normal equations of a row of fits; right: of each channel */
	tile_row term[TERMS], weighted;
};

size_t gi_denoise_tile_size(void)
{
	return sizeof(gi_denoise_tile);
}

uint32_t gi_denoise_tile_side(void)
{
	return SIDE;
}

/* The part of a tile that lies in the picture, in pixels of the tile's own planes. */
typedef struct tile_extent {
	uint32_t width, height; /* of the tile */
	uint32_t centers_x, centers_y;
	uint32_t read_x, read_y;
} tile_extent;

static tile_extent extent_of(const gi_denoise_picture *picture, uint32_t x, uint32_t y)
{
	uint32_t right = picture->width - x, below = picture->height - y;
	uint32_t width = right < SIDE ? right : SIDE, height = below < SIDE ? below : SIDE;
	return (tile_extent){width, height, width + 2 * REACH, height + 2 * REACH, width + 2 * BORDER, height + 2 * BORDER};
}

/* ---- the pixels -------------------------------------------------------------------------------------------------- */

static void load_pixel(const gi_denoise_picture *picture, size_t pixel, int half, gi_denoise_tile *tile, uint32_t v,
                       uint32_t u)
{
	float share = picture->share[pixel], part = half == 0 ? 1.0f - share : share; /* of the other half */
	tile->there[v][u] = share > 0.0f ? 1.0f : 0.0f;
	for (int c = 0; c < 3; c++) {
		float unit = 1.0f / picture->albedo[c][pixel];
		tile->color[c][v][u] = picture->half[half][c][pixel];
		tile->shade[c][v][u] = picture->half[!half][c][pixel] * unit;
		tile->variance[c][v][u] = picture->variance[c][pixel] * unit * unit / part;
	}
	for (int i = 0; i < GI_DENOISE_FEATURES; i++)
		tile->feature[i][v][u] = picture->feature[i][pixel];
}

static void load_nothing(gi_denoise_tile *tile, uint32_t v, uint32_t u)
{
	tile->there[v][u] = 0.0f;
	for (int c = 0; c < 3; c++)
		tile->color[c][v][u] = tile->shade[c][v][u] = tile->variance[c][v][u] = 0.0f;
	for (int i = 0; i < GI_DENOISE_FEATURES; i++)
		tile->feature[i][v][u] = 0.0f;
}

static void tile_load(const gi_denoise_picture *picture, uint32_t x, uint32_t y, const tile_extent *extent, int half,
                      gi_denoise_tile *tile)
{
	for (uint32_t v = 0; v < extent->read_y; v++)
		for (uint32_t u = 0; u < extent->read_x; u++) {
			uint32_t column = x + u - BORDER, row = y + v - BORDER; /* wraps where it is left of or above the picture */
			size_t pixel = (size_t)row * picture->width + column;
			if (column < picture->width && row < picture->height && picture->share[pixel] > 0.0f)
				load_pixel(picture, pixel, half, tile, v, u);
			else
				load_nothing(tile, v, u);
		}
}

/* ---- weights ----------------------------------------------------------------------------------------------------- */

/* Distances of so many pixels of a row, the first one at REACH, from those at an offset; 0 where one of the two is not
 * there. */
static void distance_row(gi_denoise_tile *tile, uint32_t v, int dx, int dy, uint32_t width)
{
	uint32_t other_v = (uint32_t)((int)v + dy), other_u = (uint32_t)(REACH + dx);
	const float *a[3], *b[3], *p[3], *q[3];
	for (int c = 0; c < 3; c++) {
		a[c] = tile->shade[c][v] + REACH;
		b[c] = tile->shade[c][other_v] + other_u;
		p[c] = tile->variance[c][v] + REACH;
		q[c] = tile->variance[c][other_v] + other_u;
	}
	const float *here = tile->there[v] + REACH, *other = tile->there[other_v] + other_u;
	float *restrict distance = tile->distance[v] + REACH, *restrict count = tile->count[v] + REACH;
	for (uint32_t i = 0; i < width; i++) {
		float sum = 0.0f;
		for (int c = 0; c < 3; c++) {
			float difference = a[c][i] - b[c][i], variance = p[c][i] + q[c][i];
			sum += (difference * difference - variance) / (LIKENESS * variance + NO_VARIANCE);
		}
		float both = here[i] * other[i];
		sum = sum < 1e6f ? sum : 1e6f; /* finite */
		count[i] = both;
		distance[i] = both * sum * (1.0f / 3.0f);
	}
}

/* Sums over the pixels of a patch beside each other. */
static void patch_row(gi_denoise_tile *tile, uint32_t v, uint32_t first, uint32_t end)
{
	const float *distance = tile->distance[v], *count = tile->count[v];
	float *restrict distances = tile->distances[v], *restrict counts = tile->counts[v];
	for (uint32_t u = first; u < end; u++) {
		distances[u] = distance[u - 1] + distance[u] + distance[u + 1];
		counts[u] = count[u - 1] + count[u] + count[u + 1];
	}
}
_Static_assert(PATCH == 1, "patch_row and weight_row add three");

static void weight_row(gi_denoise_tile *tile, uint32_t row, int dx, int dy, uint32_t width, float *restrict weight)
{
	uint32_t v = row + REACH + PATCH, u = REACH + PATCH; /* of the row's first pixel in the planes */
	const float *above = tile->distances[v - 1] + u, *mid = tile->distances[v] + u, *below = tile->distances[v + 1] + u;
	const float *count_above = tile->counts[v - 1] + u, *count_mid = tile->counts[v] + u,
				*count_below = tile->counts[v + 1] + u;
	const float *here = tile->there[v] + u, *other = tile->there[(int)v + dy] + u + dx;
	for (uint32_t i = 0; i < width; i++) {
		float pixels = count_above[i] + count_mid[i] + count_below[i];
		float distance = (above[i] + mid[i] + below[i]) / (pixels > 1.0f ? pixels : 1.0f);
		distance = distance > 0.0f ? distance : 0.0f;
		float root = distance < FARTHEST ? 1.0f - distance * (1.0f / FARTHEST) : 0.0f;
		root *= root;
		root *= root;
		weight[i] = root * root * here[i] * other[i];
	}
}

/* The weights of all pixels at an offset from the centers of fits. */
static void offset_weights(gi_denoise_tile *tile, const tile_extent *extent, uint32_t offset)
{
	int dx = (int)(offset % SPAN) - REACH, dy = (int)(offset / SPAN) - REACH;
	for (uint32_t v = REACH; v < extent->read_y - REACH; v++) {
		distance_row(tile, v, dx, dy, extent->read_x - 2 * REACH);
		patch_row(tile, v, REACH + PATCH, extent->read_x - REACH - PATCH);
	}
	for (uint32_t row = 0; row < extent->centers_y; row++)
		weight_row(tile, row, dx, dy, extent->centers_x, tile->weight[offset][row]);
}

/* ---- fits -------------------------------------------------------------------------------------------------------- */

static float offset_x(uint32_t offset)
{
	return (float)((int)(offset % SPAN) - REACH) * (1.0f / REACH);
}

static float offset_y(uint32_t offset)
{
	return (float)((int)(offset / SPAN) - REACH) * (1.0f / REACH);
}

static float *matrix_at(gi_denoise_tile *tile, uint32_t a, uint32_t b)
{
	STILB_ASSERT(b <= a && a < TERMS);
	return tile->matrix[a * (a + 1) / 2 + b];
}

/* sum += a b */
static void row_add(float *restrict sum, const float *a, const float *b, uint32_t width)
{
	for (uint32_t i = 0; i < width; i++)
		sum[i] += a[i] * b[i];
}

/* sum -= a b */
static void row_subtract(float *restrict sum, const float *a, const float *b, uint32_t width)
{
	for (uint32_t i = 0; i < width; i++)
		sum[i] -= a[i] * b[i];
}

/* row *= a */
static void row_multiply(float *restrict row, const float *a, uint32_t width)
{
	for (uint32_t i = 0; i < width; i++)
		row[i] *= a[i];
}

/* to = a - b */
static void row_difference(float *restrict to, const float *a, const float *b, uint32_t width)
{
	for (uint32_t i = 0; i < width; i++)
		to[i] = a[i] - b[i];
}

/* Adds the pixels at an offset from the centers of a row to their normal equations. */
static void fit_add(gi_denoise_tile *tile, uint32_t row, uint32_t width, uint32_t offset)
{
	const float *weight = tile->weight[offset][row];
	uint32_t v = row + REACH + PATCH, u = REACH + PATCH;
	uint32_t other_v = row + PATCH + offset / SPAN, other_u = PATCH + offset % SPAN;
	for (uint32_t i = 0; i < width; i++) {
		tile->term[0][i] = 1.0f;
		tile->term[1][i] = offset_x(offset);
		tile->term[2][i] = offset_y(offset);
	}
	for (uint32_t k = 0; k < GI_DENOISE_FEATURES; k++)
		row_difference(tile->term[3 + k], tile->feature[k][other_v] + other_u, tile->feature[k][v] + u, width);
	for (uint32_t a = 0; a < TERMS; a++) {
		memcpy(tile->weighted, weight, width * sizeof *weight);
		row_multiply(tile->weighted, tile->term[a], width);
		for (uint32_t b = 0; b <= a; b++)
			row_add(matrix_at(tile, a, b), tile->weighted, tile->term[b], width);
		for (int c = 0; c < 3; c++)
			row_add(tile->right[c][a], tile->weighted, tile->color[c][other_v] + other_u, width);
	}
}

/* The matrices of a row as L L^T (Cholesky), with the inverses of the diagonal in place of it. Weights of a fit whose
 * center is not there are all 0, and its coefficients become 0. */
static void fit_decompose(gi_denoise_tile *tile, uint32_t width)
{
	float *restrict ridge = tile->weighted;
	const float *weights = matrix_at(tile, 0, 0);
	for (uint32_t i = 0; i < width; i++)
		ridge[i] = RIDGE * weights[i];
	for (uint32_t a = 0; a < TERMS; a++)
		for (uint32_t b = 0; b <= a; b++) {
			float *at = matrix_at(tile, a, b);
			for (uint32_t i = 0; a == b && a > 0 && i < width; i++)
				at[i] += ridge[i];
			for (uint32_t k = 0; k < b; k++)
				row_subtract(at, matrix_at(tile, a, k), matrix_at(tile, b, k), width);
			if (b < a)
				row_multiply(at, matrix_at(tile, b, b), width);
			for (uint32_t i = 0; a == b && i < width; i++)
				at[i] = 1.0f / sqrtf(at[i] > 1e-12f ? at[i] : 1e-12f);
		}
}

static void fit_solve(gi_denoise_tile *tile, uint32_t width, int channel)
{
	tile_row *right = tile->right[channel];
	for (uint32_t a = 0; a < TERMS; a++) {
		for (uint32_t k = 0; k < a; k++)
			row_subtract(right[a], matrix_at(tile, a, k), right[k], width);
		row_multiply(right[a], matrix_at(tile, a, a), width);
	}
	for (uint32_t a = TERMS; a-- > 0;) {
		for (uint32_t k = a + 1; k < TERMS; k++)
			row_subtract(right[a], matrix_at(tile, k, a), right[k], width);
		row_multiply(right[a], matrix_at(tile, a, a), width);
	}
}

static void fit_row(gi_denoise_tile *tile, uint32_t row, uint32_t width)
{
	memset(tile->matrix, 0, sizeof tile->matrix);
	memset(tile->right, 0, sizeof tile->right);
	for (uint32_t offset = 0; offset < OFFSETS; offset++)
		fit_add(tile, row, width, offset);
	fit_decompose(tile, width);
	for (int c = 0; c < 3; c++) {
		fit_solve(tile, width, c);
		for (uint32_t a = 0; a < TERMS; a++)
			memcpy(tile->fit[c][a][row], tile->right[c][a], width * sizeof(float));
	}
}

/* ---- what the fits say ------------------------------------------------------------------------------------------- */

/* Adds to a row of pixels what the fits say of it whose centers lie at minus the offset. sums: [3] and the weights. */
static void tell_add(gi_denoise_tile *tile, uint32_t row, uint32_t width, uint32_t offset, tile_row sums[4])
{
	uint32_t v = row + BORDER, u = BORDER;
	uint32_t center_row = row + 2 * REACH - offset / SPAN, center = 2 * REACH - offset % SPAN; /* among the fits */
	const float *weight = tile->weight[offset][center_row] + center;
	float x = offset_x(offset), y = offset_y(offset);
	for (uint32_t k = 0; k < GI_DENOISE_FEATURES; k++)
		row_difference(tile->term[3 + k], tile->feature[k][v] + u,
		               tile->feature[k][center_row + REACH + PATCH] + center + REACH + PATCH, width);
	for (int c = 0; c < 3; c++) {
		const float *base = tile->fit[c][0][center_row] + center, *along = tile->fit[c][1][center_row] + center,
					*down = tile->fit[c][2][center_row] + center;
		float *restrict told = tile->weighted;
		for (uint32_t i = 0; i < width; i++)
			told[i] = base[i] + along[i] * x + down[i] * y;
		for (uint32_t k = 3; k < TERMS; k++)
			row_add(told, tile->fit[c][k][center_row] + center, tile->term[k], width);
		row_add(sums[c], weight, told, width);
	}
	for (uint32_t i = 0; i < width; i++)
		sums[3][i] += weight[i];
}

static void tell_row(gi_denoise_tile *tile, uint32_t row, uint32_t width, float *const out[3])
{
	tile_row sums[4];
	memset(sums, 0, sizeof sums);
	for (uint32_t offset = 0; offset < OFFSETS; offset++)
		tell_add(tile, row, width, offset, sums);
	for (int c = 0; c < 3; c++) {
		const float *color = tile->color[c][row + BORDER] + BORDER;
		for (uint32_t i = 0; i < width; i++)
			out[c][i] = sums[3][i] > 0.0f ? sums[c][i] / sums[3][i] : color[i];
	}
}

void gi_denoise_tile_filter(const gi_denoise_picture *picture, uint32_t x, uint32_t y, gi_denoise_tile *tile)
{
	STILB_ASSERT(x < picture->width && y < picture->height);
	tile_extent extent = extent_of(picture, x, y);
	for (int half = 0; half < 2; half++) {
		tile_load(picture, x, y, &extent, half, tile);
		for (uint32_t offset = 0; offset < OFFSETS; offset++)
			offset_weights(tile, &extent, offset);
		for (uint32_t row = 0; row < extent.centers_y; row++)
			fit_row(tile, row, extent.centers_x);
		for (uint32_t row = 0; row < extent.height; row++) {
			size_t at = (size_t)(y + row) * picture->width + x;
			float *const out[3] = {picture->filtered[half][0] + at, picture->filtered[half][1] + at,
			                       picture->filtered[half][2] + at};
			tell_row(tile, row, extent.width, out);
		}
	}
}
