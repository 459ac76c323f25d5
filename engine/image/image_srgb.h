/*
 * image_srgb: what the codes of sRGB in 8 bits stand for, which powers take too long for. [any-thread]
 */
#ifndef STILB_IMAGE_SRGB_H
#define STILB_IMAGE_SRGB_H

/* The linear light of each code: shade_srgb_to_linear(code / 255). */
extern const float stilb_image_srgb_to_light[256];

#endif
