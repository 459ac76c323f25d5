/* gi_texture: textures sampled at a point. [any-thread] */
#ifndef STILB_GI_TEXTURE_H
#define STILB_GI_TEXTURE_H

#include "base/base_math.h"
#include "image/image.h"

/* Linear red, green and blue, interpolated bilinearly between the four texels around uv; the texture repeats outside
 * [0, 1]. A grey picture gives its grey in all three. NaN in uv counts as 0; a picture without pixels is white. */
stilb_vec3 gi_texture_at(const stilb_image *image, stilb_vec2 uv);

#endif
