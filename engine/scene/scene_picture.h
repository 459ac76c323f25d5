/* Pictures as a scene holds them: three channels, 8 bits of sRGB or floats. */
#ifndef STILB_SCENE_PICTURE_H
#define STILB_SCENE_PICTURE_H

#include "image/image.h"

/* Replaces image: grey becomes three times the same, alpha goes. STILB_ERROR_MEMORY: image is {0}. */
stilb_result scene_picture_to_rgb(stilb_image *image);

/* And linear floats in every case, nothing below 0. */
stilb_result scene_picture_to_light(stilb_image *image);

#endif
