/*
 * numeric_prefilter: a panorama or a cube as GGX of rising roughness reflects it, in the mips of another cube, for
 * pictures that look reflections up there (shading/shade_environment.h).
 *
 * Mips.     Mip 0 is the source, shared out to the cube's texels as bilinear interpolation weighs them. Mip m of `mips`
 *           belongs to the perceptual roughness m / (mips - 1), alpha = roughness^2 (shade_alpha_from_roughness). Its
 *           texel in the direction n is the mean of the source weighted with D(h) G1(l), h halfway between n and l:
 *           what GGX seen along its normal reflects, the first factor of the split sum. Source: Karis, "Real Shading in
 *           Unreal Engine 4" (2013); his weight n.l in place of G1, Smith's term, takes up to a fifth of the light from
 *           metal of roughness 0.5 that faces the viewer.
 * Method.   That weight depends on the angle between n and l alone: each mip is a convolution on the sphere, which
 *           multiplies the source's spherical harmonics of degree l by one number. The source is projected up to degree
 *           6 / alpha of mip 1, beyond which GGX leaves less than a thousandth, and each mip is evaluated on a grid and
 *           interpolated by cubics. Nothing is sampled at random, so there are no fireflies, and a sun of one texel has
 *           the lobe's shape. Source: Driscoll and Healy, "Computing Fourier transforms and convolutions on the
 *           2-sphere" (1994); Ramamoorthi and Hanrahan, "Frequency space environment map rendering" (2002).
 * Source.   A panorama as in numeric_sh.h, its texels of constant radiance; or six square faces, interpolated between
 *           their texels' centres, each for itself. Of linear halves or floats, with 1 (grey) to 4 channels (alpha is
 *           ignored). NaN and what is below 0 count as 0, what is above 1e15 as 1e15.
 * Fireflies. With a firefly range each value is weighted by shade_firefly_weight first (shading/shade_firefly.h): for
 *           cubes that are stored in few bits. It is biased: bright spots lose light.
 * Layout.   Of the cube in memory: [mip][face][row][column][4], the fourth 1, without gaps; mip m has sides of
 *           face >> m texels. Faces are +X -X +Y -Y +Z -Z of the world, each from its top left corner, as Vulkan
 *           samples cubes (shade_cube_direction). Halves are rounded to the nearest; values beyond 65504 are 65504.
 * Slices.   The work is STILB_NUMERIC_PREFILTER_STAGES stages of rows. The rows of a stage may be run in any order, by
 *           any threads, each once; a stage begins after the one before has ended. That changes no bit of the result.
 *
 *   stilb_numeric_prefilter *work;
 *   if (stilb_numeric_prefilter_create(&source, &settings, cube, &work) == STILB_OK)
 *       for (uint32_t stage = 0; stage < STILB_NUMERIC_PREFILTER_STAGES; stage++)
 *           stilb_numeric_prefilter_run(work, stage, 0, stilb_numeric_prefilter_rows(work, stage)); // or on jobs
 *   stilb_numeric_prefilter_destroy(work);
 *
 * Cost.     And how far the mips are from quadrature: docs/shading.md.
 * Threads.  [any-thread]; run: different rows of a stage at the same time.
 */
#ifndef STILB_NUMERIC_PREFILTER_H
#define STILB_NUMERIC_PREFILTER_H

#include "base/base.h"
#include "image/image.h"

#define STILB_NUMERIC_PREFILTER_STAGES 6
#define STILB_NUMERIC_PREFILTER_FACE_MIN 8u
#define STILB_NUMERIC_PREFILTER_FACE_MAX 2048u

/* One of the two; the other is NULL. Its pixels are read until the work is destroyed. */
typedef struct stilb_numeric_prefilter_source {
	const stilb_image *panorama;
	const stilb_image *faces; /* [6], of one side, number of channels and format */
} stilb_numeric_prefilter_source;

typedef struct stilb_numeric_prefilter_settings {
	uint32_t face;       /* texels of a side of mip 0: a power of two, FACE_MIN to FACE_MAX */
	uint32_t mips;       /* 2 to log2(face) + 1 */
	bool halves;         /* else floats */
	float firefly_range; /* radiance at which a value weighs half; 0: all weigh the same */
} stilb_numeric_prefilter_settings;

typedef struct stilb_numeric_prefilter stilb_numeric_prefilter;

/* Where face 0..5 of a mip begins in the cube, bytes. mip == mips and face 0: the size of the whole cube. */
size_t stilb_numeric_prefilter_offset(const stilb_numeric_prefilter_settings *settings, uint32_t mip, uint32_t face);

/* Prepares the work that fills the cube, stilb_numeric_prefilter_offset(settings, mips, 0) bytes, aligned to 16.
 * STILB_ERROR_ARGUMENT: pictures of codes, or faces that are no cube; STILB_ERROR_MEMORY: then *work is NULL. */
stilb_result stilb_numeric_prefilter_create(const stilb_numeric_prefilter_source *source,
                                            const stilb_numeric_prefilter_settings *settings, void *cube,
                                            stilb_numeric_prefilter **work);

/* The rows of a stage. */
uint32_t stilb_numeric_prefilter_rows(const stilb_numeric_prefilter *work, uint32_t stage);

/* Runs rows [begin, end) of a stage. */
void stilb_numeric_prefilter_run(stilb_numeric_prefilter *work, uint32_t stage, uint32_t begin, uint32_t end);

/* Accepts NULL. */
void stilb_numeric_prefilter_destroy(stilb_numeric_prefilter *work);

#endif
