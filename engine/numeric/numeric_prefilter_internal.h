/* numeric_prefilter_internal: a cube that is being made, for the files of numeric_prefilter and their tests. */
#ifndef STILB_NUMERIC_PREFILTER_INTERNAL_H
#define STILB_NUMERIC_PREFILTER_INTERNAL_H

#include "numeric/numeric_prefilter.h"

#include "base/base_math.h"

#define PREFILTER_MIPS_MAX 12
#define PREFILTER_VALUE_MAX 1e15f   /* brighter values count as this, as for rays */
#define PREFILTER_DEGREE_MAX 1024u  /* of the harmonics: 6 / alpha of 12 mips is 726 */
#define PREFILTER_BAND_TEXELS 4096u /* of a face of mip 0 that are made together, in whole rows */
#define PREFILTER_BLOCK 4           /* pairs of rings that are worked on together */

/* A complex number for each lane: red, green, blue times the weight, and the weight (1 without firefly range). */
typedef struct prefilter_wave {
	stilb_vec4 re, im;
} prefilter_wave;

/* Rings of equal angles from the pole at +Y, (ring + 0.5) pi / rings, each with points of equal longitude from the
 * panorama's left side on. A ring and its mirror image in the equator are one row of complex numbers, the northern ring
 * its real part: a Fourier transform does both. */
typedef struct prefilter_grid {
	uint32_t degree;         /* of the harmonics that it holds, at most */
	uint32_t pairs, columns; /* a multiple of PREFILTER_BLOCK, and a power of two */
	prefilter_wave *waves;   /* [pairs][columns] */
} prefilter_grid;

/* A complex number of the unit circle. */
typedef struct prefilter_turn {
	float re, im;
} prefilter_turn;

struct stilb_numeric_prefilter {
	stilb_numeric_prefilter_settings settings;
	stilb_image source[6]; /* a panorama is the first alone */
	bool is_cube;
	stilb_image unwrapped;                  /* a cube as a panorama of four floats, weighted; else {0} */
	char *mips[PREFILTER_MIPS_MAX];         /* where they begin in the cube */
	prefilter_grid in;                      /* the source's light: sums over what is around each point, W m^-2 */
	prefilter_grid out[PREFILTER_MIPS_MAX]; /* of mip 1 on */
	float *share[PREFILTER_MIPS_MAX];       /* [degree + 1]: what a mip's lobe leaves of each degree */
	prefilter_wave *harmonics;              /* of the source: by order m, and for each by degree from m on */
	prefilter_turn *turns;                  /* [columns / 2] exp(-2 pi i k / columns) of the finest grid */
	uint32_t turn_columns;
	prefilter_turn *columns; /* [parts_across] exp(i phi) of the parts of a panorama's columns, from its left side */
	uint32_t parts_across;   /* 0 for cubes */
};

/* Where the harmonics of order m begin. */
static inline size_t prefilter_order_begin(uint32_t degree, uint32_t m)
{
	return (size_t)m * (degree + 1) - (size_t)m * (m - (m > 0)) / 2;
}

static inline double prefilter_angle(const prefilter_grid *grid, uint32_t ring)
{
	return M_PI * (ring + 0.5) / (2.0 * grid->pairs);
}

/* Lagrange's cubic through four neighbours: the weight of one that is `distance` steps away; 0 from 2 on. */
static inline float prefilter_cubic(float distance)
{
	float d = fabsf(distance);
	if (d < 1.0f)
		return 0.5f * (1.0f - d * d) * (2.0f - d);
	return d < 2.0f ? (1.0f - d) * (2.0f - d) * (3.0f - d) / 6.0f : 0.0f;
}

/* numeric_prefilter_source.c */

/* Texels begin to end of row y of the panorama or of the cube unwrapped, weighted. */
void numeric_prefilter_read(const stilb_numeric_prefilter *work, uint32_t y, uint32_t begin, uint32_t end,
                            stilb_vec4 *values);

/* One texel of a picture, weighted. */
stilb_vec4 numeric_prefilter_texel(const stilb_numeric_prefilter *work, const stilb_image *image, uint32_t x,
                                   uint32_t y);

/* The radiance of a cube in this direction, weighted. */
stilb_vec4 numeric_prefilter_look(const stilb_numeric_prefilter *work, stilb_vec3 direction);

void numeric_prefilter_unwrap_row(stilb_numeric_prefilter *work, uint32_t y);
void numeric_prefilter_gather(stilb_numeric_prefilter *work,
                              uint32_t pair); /* and PREFILTER_BLOCK - 1 more; transformed */

/* numeric_prefilter_harmonics.c */
void numeric_prefilter_make_turns(stilb_numeric_prefilter *work);
void numeric_prefilter_transform(const stilb_numeric_prefilter *work, uint32_t columns, prefilter_wave *waves,
                                 bool inverse);
void numeric_prefilter_make_share(float roughness, uint32_t degree, float *share);
void numeric_prefilter_analyse(stilb_numeric_prefilter *work, uint32_t m);
void numeric_prefilter_synthesise(stilb_numeric_prefilter *work, uint32_t mip, uint32_t m);
void numeric_prefilter_finish_pair(stilb_numeric_prefilter *work, uint32_t mip, uint32_t pair);

/* numeric_prefilter_resample.c */

/* Of mip 0, written together. */
uint32_t numeric_prefilter_band_rows(uint32_t face);

/* Of a panorama's columns (across) or rows: even; a multiple of their number, or that is a multiple of it. */
uint32_t numeric_prefilter_parts(uint32_t texels, uint32_t face, bool across);
void numeric_prefilter_make_columns(stilb_numeric_prefilter *work);

/* Sums over what a panorama gives to the texels of a face's band of rows, [prefilter_band_rows][face]. */
void numeric_prefilter_resample(const stilb_numeric_prefilter *work, uint32_t number, uint32_t first, stilb_vec4 *sums);

/* numeric_prefilter_write.c */
void numeric_prefilter_write_band(stilb_numeric_prefilter *work, uint32_t band); /* of all six faces of mip 0 */
void numeric_prefilter_write_row(stilb_numeric_prefilter *work, uint32_t mip,
                                 uint32_t row); /* of all six of another mip */

#endif
