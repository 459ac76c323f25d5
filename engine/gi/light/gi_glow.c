#include "gi/light/gi_glow.h"

#include "gi/gi_texture.h"
#include "shading/shade_layers.h"

#include <string.h>

#define GLOW_STEPS 64u  /* along a side of a triangle, at most */
#define GLOW_APART 2.0f /* texels between two points, as wide as what bilinear filters make of one texel */

stilb_vec3 gi_glow_at(const gi_glow *glow, float u, float v)
{
	STILB_ASSERT(glow->maps.surface);
	gi_place place = gi_place_between(glow->corners, u, v);
	return gi_maps_emission(&glow->maps, &place) * gi_maps_alpha(&glow->maps, &place);
}

stilb_vec3 gi_glow_towards(const gi_glow *glow, float u, float v, float cosine)
{
	stilb_vec3 emission = gi_glow_at(glow, u, v);
	if (!(glow->maps.surface->clearcoat > 0.0f))
		return emission;
	gi_place place = gi_place_between(glow->corners, u, v);
	float coat = glow->maps.surface->clearcoat * gi_maps_texel(&glow->maps, STILB_SCENE_MAP_CLEARCOAT, &place)[0];
	return emission * (1.0f - shade_coat_share(coat, cosine));
}

/* The longest side of the triangle on a map's texture, in texels; 0 without such a map. */
static float glow_texels(const gi_glow *glow, stilb_scene_map_kind kind)
{
	if (!gi_maps_have(&glow->maps, kind))
		return 0.0f;
	const stilb_scene_map *map = &glow->maps.surface->maps[kind];
	const stilb_image *image = &glow->maps.textures[map->texture - 1];
	float longest = 0.0f;
	for (int i = 0; i < 3; i++) {
		stilb_vec2 side = glow->corners[(i + 1) % 3].uv[map->set] - glow->corners[i].uv[map->set];
		float x = (map->to_u[0] * side[0] + map->to_u[1] * side[1]) * (float)image->width;
		float y = (map->to_v[0] * side[0] + map->to_v[1] * side[1]) * (float)image->height;
		longest = fmaxf(longest, sqrtf(x * x + y * y));
	}
	return longest;
}

static uint32_t glow_steps(const gi_glow *glow)
{
	float texels = fmaxf(glow_texels(glow, STILB_SCENE_MAP_EMISSION), glow_texels(glow, STILB_SCENE_MAP_COLOR));
	float steps = ceilf(texels * (1.0f / GLOW_APART));
	return steps < (float)GLOW_STEPS ? steps > 1.0f ? (uint32_t)steps : 1 : GLOW_STEPS;
}

/* Each side is cut into as many steps; the middles of the small triangles, upright and turned over, are the points. */
stilb_vec3 gi_glow_mean(const gi_glow *glow)
{
	uint32_t steps = glow_steps(glow);
	float step = 1.0f / (float)steps;
	stilb_vec3 sum = {0};
	for (uint32_t row = 0; row < steps; row++)
		for (uint32_t i = 0; i < steps - row; i++) {
			float u = (float)i * step, v = (float)row * step;
			sum += gi_glow_at(glow, u + step * (1.0f / 3.0f), v + step * (1.0f / 3.0f));
			if (i + 1 < steps - row)
				sum += gi_glow_at(glow, u + step * (2.0f / 3.0f), v + step * (2.0f / 3.0f));
		}
	return sum * (step * step);
}

/* The bits of the colours of 8 bytes of texels whose codes are bytes or words, alpha being the last of 2 or 4. */
static uint64_t glow_color_bits(const stilb_image *image, size_t code)
{
	uint64_t bits = 0;
	for (size_t byte = 0; byte < 8; byte++) {
		bool alpha = image->channels % 2 == 0 && byte / code % image->channels == image->channels - 1;
		((uint8_t *)&bits)[byte] = alpha ? 0 : 0xff;
	}
	return bits;
}

/* All texels begin a group of 8 bytes or lie in the same place of each, unless they have no alpha. */
static bool glow_codes_are_dark(const stilb_image *image)
{
	bool words = image->format == STILB_IMAGE_U16_SRGB || image->format == STILB_IMAGE_U16_LINEAR;
	uint64_t colors = glow_color_bits(image, words ? sizeof(uint16_t) : 1), group = 0;
	const uint8_t *bytes = image->pixels;
	size_t size = stilb_image_size(image), i = 0;
	for (; i + sizeof group <= size && (group & colors) == 0; i += sizeof group)
		memcpy(&group, bytes + i, sizeof group);
	if ((group & colors) != 0)
		return false;
	group = 0;
	memcpy(&group, bytes + i, size - i);
	return (group & colors) == 0;
}

/* True if no colour of the row is above 0; NaN is not. */
static bool glow_row_is_dark(const stilb_image *image, uint32_t y)
{
	uint32_t channels = image->channels, colors = channels < 3 ? 1 : 3;
	size_t first = (size_t)y * image->width * channels;
	bool halves = image->format == STILB_IMAGE_F16_LINEAR, lit = false;
	const uint16_t *half = (const uint16_t *)image->pixels + (halves ? first : 0);
	const float *wide = (const float *)image->pixels + (halves ? 0 : first);
	for (uint32_t x = 0; x < image->width; x++)
		for (uint32_t c = 0; c < colors; c++) {
			size_t at = (size_t)x * channels + c;
			lit |= halves ? half[at] > 0 && half[at] <= 0x7c00 : wide[at] > 0.0f; /* 0x7c00: infinity */
		}
	return !lit;
}

bool gi_glow_is_dark(const stilb_image *image)
{
	bool dark = image->pixels;
	if (dark && image->format != STILB_IMAGE_F16_LINEAR && image->format != STILB_IMAGE_F32_LINEAR)
		return glow_codes_are_dark(image);
	for (uint32_t y = 0; y < image->height && dark; y++)
		dark = glow_row_is_dark(image, y);
	return dark;
}
