/*
 * image_normals: mip chains of normal and roughness maps; bumps that become smaller than a pixel turn into roughness.
 *
 * The formulas, and advice on the choice of the filter, are in shading/shade_normal_filter.h; here is the loop over
 * pixels. A pixel of a level is the average, weighted by exact area, of the quantity that its filter averages. So it is
 * for sides of any length, and the last level, one pixel, stands for the whole map.
 *
 * Input.       Normals with 2 channels (x, y; tangent space, z = sqrt(1 - x^2 - y^2)), 3, or 4 (the last is ignored),
 *              of any length but 0; roughness with any number of channels (the first counts). Codes are numbers, not
 *              light, also those that a file's reader took for colour: normal = 2 code / 255 - 1, roughness = code /
 *              255, of 16 bits / 65535; floats are taken as they are. Maps with +Y down keep +Y down.
 * Output.      Levels of four floats: a unit normal x, y, z, and a roughness in [sqrt(SHADE_ALPHA_MIN), 1]. Level 0 is
 *              the input; each further level has half the sides of the one before, rounded down, at least 1; the last
 *              is one pixel.
 * Life cycle.  stilb_image_normals_create -> read the levels -> stilb_image_normals_finish.
 * Threads.     [any-thread]; [one-writer] per chain.
 * Example.
 *
 *   stilb_image_normals chain;
 *   stilb_image_normals_desc desc = stilb_image_normals_desc_default(&normals);
 *   if (stilb_image_normals_create(&desc, &chain) == STILB_OK) {
 *       upload(chain.levels, chain.level_count);
 *       stilb_image_normals_finish(&chain);
 *   }
 */
#ifndef STILB_IMAGE_NORMALS_H
#define STILB_IMAGE_NORMALS_H

#include "image/image.h"

#define STILB_IMAGE_NORMALS_LEVELS 17 /* of a picture of STILB_IMAGE_MAX_SIDE */

typedef enum stilb_normal_filter {
	STILB_NORMAL_FILTER_VMF,
	STILB_NORMAL_FILTER_TOKSVIG,
	STILB_NORMAL_FILTER_VARIANCE,
	STILB_NORMAL_FILTER_CONVOLUTION,
	STILB_NORMAL_FILTER_LEAN, /* the roughness is the mean over both axes; tangent space only */
	STILB_NORMAL_FILTER_COUNT
} stilb_normal_filter;

typedef enum stilb_normal_space {
	STILB_NORMAL_SPACE_TANGENT, /* +Z is the normal of the surface */
	STILB_NORMAL_SPACE_OBJECT,  /* normals may point in any direction */
} stilb_normal_space;

typedef struct stilb_image_normals_desc {
	const stilb_image *normals;   /* any format but F16_LINEAR and blocks */
	const stilb_image *roughness; /* of such a format, as large as normals; NULL: constant_roughness everywhere */
	float constant_roughness;     /* [0, 1] */
	stilb_normal_filter filter;
	stilb_normal_space space;
} stilb_image_normals_desc;

typedef struct stilb_image_normals {
	uint32_t level_count;                           /* 1 + floor(log2(longer side)) */
	stilb_image levels[STILB_IMAGE_NORMALS_LEVELS]; /* F32_LINEAR, 4 channels */
} stilb_image_normals;

/* The filter by von Mises-Fisher distributions, tangent space, roughness 0.5. [any-thread] */
stilb_image_normals_desc stilb_image_normals_desc_default(const stilb_image *normals);

/* Filters all levels. Needs memory for the levels (21 bytes per pixel of the map) and at most as much again while it
 * works. [any-thread] STILB_ERROR_ARGUMENT for empty pictures, formats or sizes that do not fit, LEAN in object space,
 * and for a pixel whose normal has no direction or whose roughness is outside [0, 1], which the message names;
 * STILB_ERROR_MEMORY. Then chain is {0}. */
stilb_result stilb_image_normals_create(const stilb_image_normals_desc *desc, stilb_image_normals *chain);

/* Frees the levels and leaves {0}. Accepts NULL and {0}. [one-writer] */
void stilb_image_normals_finish(stilb_image_normals *chain);

#endif
