/*
 * image_blocks: block-compressed pictures, texel by texel. Inside image/ and for its tests.
 *
 * A block is 4 x 4 texels. Blocks stand in rows, the top one first, without gaps; of those at the right and the lower
 * edge the texels outside of the picture mean nothing.
 */
#ifndef STILB_IMAGE_BLOCKS_H
#define STILB_IMAGE_BLOCKS_H

#include "image/image_internal.h"

typedef struct image_block_format {
	uint8_t bytes;             /* of a block; 0: the format has no blocks */
	uint8_t channels;          /* of a texel, and so of the picture */
	stilb_image_format texels; /* the format that its texels have */
} image_block_format;

extern const image_block_format image_block_formats[STILB_IMAGE_FORMAT_COUNT]; /* image.c */

/* Decodes a block into texels, [4][4][channels] of uint8_t or, for BC4 and BC5, uint16_t: the values of the
 * specification, rounded to the nearest code, halves up. BC7 is defined in 8 bits and exact. [any-thread] */
void image_block_decode(stilb_image_format format, const uint8_t *block, void *texels);

/* Decodes the row of blocks that texel row y, a multiple of 4, is the first of: `rows` of its rows, at most 4, into
 * [rows][width][channels]. */
void image_block_rows(const stilb_image *shape, const void *blocks, uint32_t y, uint32_t rows, void *texels);

/* Decodes row y, texels first .. first + count - 1, where first is a multiple of 4, into [count][channels]. blocks: of
 * a picture of this shape, whose own pixels are not read. */
void image_block_row(const stilb_image *shape, const void *blocks, uint32_t y, uint32_t first, uint32_t count,
                     void *texels);

/* image_bc7.c: red, green, blue and alpha of a block of BC7. */
void image_block_bc7(const uint8_t block[16], uint8_t texels[16][4]);

#endif
