/*
 * image_compare: how far two pictures are apart, in numbers that tests bound.
 *
 * Values.      Linear light, as stilb_image_row_to_light has it. Codes are compared as they are where both pictures are
 *              named data first (stilb_image_format_as_data in a copy of the stilb_image; a step of 8 bits is 1 / 255).
 * Masks.       A picture of one channel in U8_LINEAR, as large as those it masks: pixels whose code is 0 are left out.
 *              NULL: none is. stilb_image_mask_edges makes one that leaves silhouettes out, where a pixel's samples
 *              decide and not its light.
 * NaN.         A value differs by infinity from NaN, and NaN from NaN, so that no bound passes a picture with NaN;
 *              equal infinities differ by 0.
 * Threads.     [any-thread] The pictures are only read.
 * Errors.      STILB_ERROR_ARGUMENT for pictures that cannot be compared, with their sizes in the message;
 *              STILB_ERROR_MEMORY.
 * Example.     Pixels farther than two pixels from where another part begins, against a bound of 1 % of the range:
 *
 *   stilb_image mask = {0};
 *   stilb_image_comparison apart;
 *   stilb_result result = stilb_image_mask_edges(&parts, 0.0f, 0.0f, 2, &mask);
 *   if (result == STILB_OK)
 *       result = stilb_image_compare(&frame, &traced, &mask, 0.05, &apart);
 *   bool good = result == STILB_OK && apart.rms_all <= 0.01 * apart.largest && apart.above == 0;
 *   stilb_image_finish(&mask);
 */
#ifndef STILB_IMAGE_COMPARE_H
#define STILB_IMAGE_COMPARE_H

#include "image/image.h"

typedef struct stilb_image_comparison {
	uint64_t pixels;   /* that were compared; 0: all other members are 0, but channels */
	uint32_t channels; /* 1 or 3 of colour, then alpha if both pictures have it */
	double rms[4];     /* root of the mean square of a - b, for each of these channels */
	double rms_all;    /* the same over the values of all of them */
	double worst;      /* the largest |a - b| of one channel, and the first place, row by row, that has it */
	uint32_t worst_x, worst_y, worst_channel;
	uint64_t above; /* pixels of which a channel differs by more than the bound */
	double largest; /* the largest value of b, for bounds that are shares of the range; infinite values do not count */
} stilb_image_comparison;

/* Compares a with b, the reference: pictures of the same size, both grey or both with three colours; formats may
 * differ. bound >= 0, for the count of the pixels that differ by more. On failure *out is {0}. */
stilb_result stilb_image_compare(const stilb_image *a, const stilb_image *b, const stilb_image *mask, double bound,
                                 stilb_image_comparison *out);

/* The number by which Khronos' glTF-Render-Fidelity set ranks viewers, in decibels: 10 log10(RMS / 35215), where RMS is
 * the root mean square over pixels of pixelmatch's distance d = 0.5053 Y^2 + 0.299 I^2 + 0.1957 Q^2, of the difference
 * of two pixels in YIQ, from 8-bit sRGB codes over white; 35215 is its largest value. Pixels where the candidate has an
 * alpha of 0 do not count. -40 is hardly seen, and -22 was that tool's bound for a regression. -INFINITY: equal; NAN:
 * no pixel counts, so that no bound passes.
 * Pictures of floats and 16 bits become the codes that stilb_image_save writes into a .png; grey counts as three equal
 * colours. Sources: render-fidelity-tools of github.com/google/model-viewer, src/common.ts (ImageComparator.analyze and
 * toDecibel) and src/third_party/pixelmatch/color-delta.ts; Kotsarenko, Ramos, "Measuring perceived color difference
 * using YIQ NTSC transmission color space in mobile applications", 2010. On failure *db is NAN. */
stilb_result stilb_image_fidelity(const stilb_image *candidate, const stilb_image *golden, const stilb_image *mask,
                                  double *db);

/* Leaves out of the mask what lies at edges of a picture of ids, depths or alpha: pixels at most `distance` pixels
 * away, across, down or diagonally, from one of a pair of neighbours (side by side, or one above the other) that differ
 * in some channel by more than step + share * the larger one's size; infinite differences are edges always. With step
 * and share 0 any difference is one; the picture's border is none. Ids up to 2^24 are exact as floats. mask is {0}, and
 * becomes a new one (stilb_image_finish), or the mask of another picture of the same size, which then keeps what both
 * keep. On failure a mask that was {0} still is, and another one is as it was. */
stilb_result stilb_image_mask_edges(const stilb_image *picture, float step, float share, uint32_t distance,
                                    stilb_image *mask);

#endif
