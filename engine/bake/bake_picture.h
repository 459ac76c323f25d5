/* bake_picture: what an atlas looks like, for people. [any-thread] */
#ifndef STILB_BAKE_PICTURE_H
#define STILB_BAKE_PICTURE_H

#include "bake/bake_texels.h"

/* srgb: [side * side][3]. Charts in colours of their own, each triangle a little lighter or darker than the one before;
 * what no chart covers dark. */
void stilb_bake_picture_charts(const stilb_bake_texels *texels, uint8_t (*srgb)[3]);

/* Texels as chequers; those of which triangles have a part only are yellow, the less they have the stronger. */
void stilb_bake_picture_texels(const stilb_bake_texels *texels, uint8_t (*srgb)[3]);

#endif
