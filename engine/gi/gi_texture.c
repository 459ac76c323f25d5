#include "gi/gi_texture.h"

#include "image/image_srgb.h"
#include "shading/shade_srgb.h"

/* ---- texels ------------------------------------------------------------------------------------------------------ */

static float code_of_u8_srgb(const void *pixels, size_t at)
{
	return stilb_image_srgb_to_light[((const uint8_t *)pixels)[at]];
}

static float code_of_u16_srgb(const void *pixels, size_t at)
{
	return shade_srgb_to_linear((float)((const uint16_t *)pixels)[at] * (1.0f / 65535.0f));
}

static float code_of_u8(const void *pixels, size_t at)
{
	return (float)((const uint8_t *)pixels)[at] * (1.0f / 255.0f);
}

static float code_of_u16(const void *pixels, size_t at)
{
	return (float)((const uint16_t *)pixels)[at] * (1.0f / 65535.0f);
}

static float code_of_f16(const void *pixels, size_t at)
{
	return stilb_image_half_to_float(((const uint16_t *)pixels)[at]);
}

static float code_of_f32(const void *pixels, size_t at)
{
	return ((const float *)pixels)[at];
}

typedef float texture_code(const void *pixels, size_t at);

/* color and alpha: the two transfers of a format; inlined, so that each format has a loop of its own. */
static inline __attribute__((always_inline)) stilb_vec4 texture_texel(const stilb_image *image, uint32_t x, uint32_t y,
                                                                      texture_code *color, texture_code *alpha)
{
	STILB_ASSERT(x < image->width && y < image->height);
	size_t at = ((size_t)y * image->width + x) * image->channels;
	float red = color(image->pixels, at);
	if (image->channels < 3)
		return (stilb_vec4){red, red, red, image->channels == 2 ? alpha(image->pixels, at + 1) : 1.0f};
	return (stilb_vec4){red, color(image->pixels, at + 1), color(image->pixels, at + 2),
	                    image->channels == 4 ? alpha(image->pixels, at + 3) : 1.0f};
}

/* ---- places ------------------------------------------------------------------------------------------------------ */

/* Two neighbouring texels of one side of a texture, and how far from the first one's middle to the second's, [0, 1). */
typedef struct texture_place {
	uint32_t first, second;
	float fraction;
} texture_place;

/* From 0 to 1 along one side: repeated, or turned over every second time, or cut off. */
static float texture_wrap(float coordinate, uint32_t wrap)
{
	if (wrap == STILB_SCENE_CLAMP)
		return coordinate >= 1.0f ? 1.0f : coordinate > 0.0f ? coordinate : 0.0f;
	if (wrap == STILB_SCENE_MIRROR) {
		coordinate -= 2.0f * floorf(0.5f * coordinate);
		coordinate = coordinate > 1.0f ? 2.0f - coordinate : coordinate;
		return coordinate >= 0.0f ? coordinate : 0.0f;
	}
	coordinate -= floorf(coordinate);
	return coordinate >= 0.0f && coordinate < 1.0f ? coordinate : 0.0f;
}

static texture_place texture_nearest(float coordinate, uint32_t size, uint32_t wrap)
{
	uint32_t texel = (uint32_t)(texture_wrap(coordinate, wrap) * (float)size);
	texel = texel < size ? texel : size - 1;
	return (texture_place){texel, texel, 0.0f};
}

/* Beyond the outermost middles a texture that repeats goes on with its other end, any other with the same texel. */
static texture_place texture_between(float coordinate, uint32_t size, uint32_t wrap)
{
	STILB_ASSERT(size > 0);
	float place = texture_wrap(coordinate, wrap) * (float)size - 0.5f, whole = floorf(place);
	bool repeats = wrap == STILB_SCENE_REPEAT;
	uint32_t last = size - 1, first = whole < 0.0f ? (repeats ? last : 0) : (uint32_t)whole;
	first = first < last ? first : last;
	uint32_t second = whole < 0.0f ? 0 : first < last ? first + 1 : repeats ? 0 : last;
	return (texture_place){first, second, place - whole};
}

static inline __attribute__((always_inline)) stilb_vec4
texture_mix(const stilb_image *image, texture_place x, texture_place y, texture_code *color, texture_code *alpha)
{
	if (x.first == x.second && y.first == y.second)
		return texture_texel(image, x.first, y.first, color, alpha); /* an infinite one, too: not times 0 */
	stilb_vec4 above = texture_texel(image, x.first, y.first, color, alpha) * (1.0f - x.fraction) +
	                   texture_texel(image, x.second, y.first, color, alpha) * x.fraction;
	stilb_vec4 below = texture_texel(image, x.first, y.second, color, alpha) * (1.0f - x.fraction) +
	                   texture_texel(image, x.second, y.second, color, alpha) * x.fraction;
	return above * (1.0f - y.fraction) + below * y.fraction;
}

static stilb_vec4 texture_at(const stilb_image *image, texture_place x, texture_place y)
{
	STILB_ASSERT(image->channels >= 1 && image->channels <= 4);
	switch (image->format) {
	case STILB_IMAGE_U8_SRGB:
		return texture_mix(image, x, y, code_of_u8_srgb, code_of_u8);
	case STILB_IMAGE_F16_LINEAR:
		return texture_mix(image, x, y, code_of_f16, code_of_f16);
	case STILB_IMAGE_U16_SRGB:
		return texture_mix(image, x, y, code_of_u16_srgb, code_of_u16);
	case STILB_IMAGE_U8_LINEAR:
		return texture_mix(image, x, y, code_of_u8, code_of_u8);
	case STILB_IMAGE_U16_LINEAR:
		return texture_mix(image, x, y, code_of_u16, code_of_u16);
	default:
		STILB_ASSERT(image->format == STILB_IMAGE_F32_LINEAR && "blocks were decoded");
		return texture_mix(image, x, y, code_of_f32, code_of_f32);
	}
}

/* Alpha alone, four numbers in place of sixteen. */
static inline __attribute__((always_inline)) float texture_mix_alpha(const stilb_image *image, texture_place x,
                                                                     texture_place y, texture_code *alpha)
{
	size_t channels = image->channels, row = (size_t)image->width * channels, last = channels - 1;
	size_t above = y.first * row + last, below = y.second * row + last;
	const void *pixels = image->pixels;
	if (x.first == x.second && y.first == y.second)
		return alpha(pixels, above + x.first * channels);
	float a = alpha(pixels, above + x.first * channels) * (1.0f - x.fraction) +
	          alpha(pixels, above + x.second * channels) * x.fraction;
	float b = alpha(pixels, below + x.first * channels) * (1.0f - x.fraction) +
	          alpha(pixels, below + x.second * channels) * x.fraction;
	return a * (1.0f - y.fraction) + b * y.fraction;
}

static float texture_alpha_at(const stilb_image *image, texture_place x, texture_place y)
{
	switch (image->format) {
	case STILB_IMAGE_U8_SRGB:
	case STILB_IMAGE_U8_LINEAR:
		return texture_mix_alpha(image, x, y, code_of_u8);
	case STILB_IMAGE_U16_SRGB:
	case STILB_IMAGE_U16_LINEAR:
		return texture_mix_alpha(image, x, y, code_of_u16);
	case STILB_IMAGE_F16_LINEAR:
		return texture_mix_alpha(image, x, y, code_of_f16);
	default:
		STILB_ASSERT(image->format == STILB_IMAGE_F32_LINEAR && "blocks were decoded");
		return texture_mix_alpha(image, x, y, code_of_f32);
	}
}

/* Where a place is on a map's texture. */
typedef struct texture_spot {
	texture_place x, y;
} texture_spot;

static texture_spot texture_spot_of(const stilb_image *image, const stilb_scene_map *map, stilb_vec2 place)
{
	float u = map->to_u[0] * place[0] + map->to_u[1] * place[1] + map->to_u[2];
	float v = map->to_v[0] * place[0] + map->to_v[1] * place[1] + map->to_v[2];
	if (map->nearest)
		return (texture_spot){texture_nearest(u, image->width, map->wrap_u),
		                      texture_nearest(v, image->height, map->wrap_v)};
	return (texture_spot){texture_between(u, image->width, map->wrap_u),
	                      texture_between(v, image->height, map->wrap_v)};
}

/* ---- the interface ----------------------------------------------------------------------------------------------- */

stilb_vec3 gi_texture_at(const stilb_image *image, stilb_vec2 uv)
{
	if (!image->pixels)
		return stilb_vec3_make(1.0f, 1.0f, 1.0f);
	stilb_vec4 texel = texture_at(image, texture_between(uv[0], image->width, STILB_SCENE_REPEAT),
	                              texture_between(uv[1], image->height, STILB_SCENE_REPEAT));
	return stilb_vec3_make(texel[0], texel[1], texel[2]);
}

stilb_vec4 gi_texture_map(const stilb_image *image, const stilb_scene_map *map, stilb_vec2 place)
{
	if (!image->pixels)
		return (stilb_vec4){1.0f, 1.0f, 1.0f, 1.0f};
	texture_spot spot = texture_spot_of(image, map, place);
	return texture_at(image, spot.x, spot.y);
}

float gi_texture_alpha(const stilb_image *image, const stilb_scene_map *map, stilb_vec2 place)
{
	if (!image->pixels || image->channels % 2 == 1)
		return 1.0f;
	texture_spot spot = texture_spot_of(image, map, place);
	return texture_alpha_at(image, spot.x, spot.y);
}
