/*
 * gi_denoise_internal: the picture as the denoiser sees it, and its filter, which works tile by tile.
 */
#ifndef GI_DENOISE_INTERNAL_H
#define GI_DENOISE_INTERNAL_H

#include "base/base.h"

#include <stddef.h>
#include <stdint.h>

enum {
	GI_DENOISE_ALBEDO,
	GI_DENOISE_NORMAL = 3,
	GI_DENOISE_NEARNESS = 6, /* 1 / depth over the largest of the picture, 0 for a miss */
	GI_DENOISE_FEATURES,
};

/* Planes of width x height floats, row by row. */
typedef struct gi_denoise_picture {
	uint32_t width, height;
	float *half[2][3]; /* mean radiance of each half of the samples */
	float *filtered[2][3];
	float *variance[3]; /* of the mean of both halves */
	float *share;       /* of the samples' weight that is in half 0; 0: the pixel is kept as it is */
	float *albedo[3];   /* what radiance is divided by before pixels are compared, > 0 */
	float *feature[GI_DENOISE_FEATURES];
} gi_denoise_picture;

/* What a thread needs for a tile. */
typedef struct gi_denoise_tile gi_denoise_tile;

size_t gi_denoise_tile_size(void);

/* Side of the tiles in pixels. */
uint32_t gi_denoise_tile_side(void);

/* Filters both halves in the square of pixels from (x, y) on; writes `filtered` there alone. The same bits whatever
 * tiles the picture is divided into. */
void gi_denoise_tile_filter(const gi_denoise_picture *picture, uint32_t x, uint32_t y, gi_denoise_tile *tile);

#endif
