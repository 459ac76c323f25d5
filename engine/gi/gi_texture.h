/* gi_texture: what a texture shows at a point. [any-thread] */
#ifndef STILB_GI_TEXTURE_H
#define STILB_GI_TEXTURE_H

#include "base/base_math.h"
#include "image/image.h"

/* Linear red, green, blue between the four texels around uv, repeated outside [0, 1]; grey counts as all three. uv that is
 * no number counts as 0; a picture without pixels is white. */
stilb_vec3 gi_texture_at(const stilb_image *image, stilb_vec2 uv);

#endif
