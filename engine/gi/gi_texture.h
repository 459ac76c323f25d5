/*
 * gi_texture: textures sampled at a point. [any-thread]
 *
 * Texels are linear: codes of formats that are sRGB are decoded, but for alpha; all others are the numbers that they
 * are. A picture of one or two channels is grey: red, green and blue are its first one, and alpha its second. A picture
 * without alpha has alpha 1, and one without pixels is 1 in all four. No picture is made of blocks.
 */
#ifndef STILB_GI_TEXTURE_H
#define STILB_GI_TEXTURE_H

#include "base/base_math.h"
#include "image/image.h"
#include "scene/scene_surface.h"

/* Linear red, green and blue, interpolated bilinearly between the four texels around uv; the texture repeats outside
 * [0, 1]. What is not finite in uv counts as 0. */
stilb_vec3 gi_texture_at(const stilb_image *image, stilb_vec2 uv);

/* Red, green, blue and alpha at a place on a surface: by the map's transform, its wrap and its filter. What is NaN on
 * the texture counts as 0, what is too far away for floats as some place of it; CLAMP takes infinity for its end. */
stilb_vec4 gi_texture_map(const stilb_image *image, const stilb_scene_map *map, stilb_vec2 place);

/* The alpha of gi_texture_map, in less time. */
float gi_texture_alpha(const stilb_image *image, const stilb_scene_map *map, stilb_vec2 place);

#endif
