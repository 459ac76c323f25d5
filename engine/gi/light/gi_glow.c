#include "gi/light/gi_glow.h"

#include "gi/gi_texture.h"
#include "shading/shade_layers.h"

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

/* The largest code of a row of texels whose codes are bytes or words, without alpha. */
static uint32_t glow_largest_code(const stilb_image *image, uint32_t y)
{
	size_t channels = image->channels, colors = channels < 3 ? 1 : 3, first = (size_t)y * image->width * channels;
	bool words = image->format == STILB_IMAGE_U16_SRGB || image->format == STILB_IMAGE_U16_LINEAR;
	const uint8_t *bytes = (const uint8_t *)image->pixels + first;
	const uint16_t *wide = (const uint16_t *)image->pixels + first;
	uint32_t any = 0;
	for (size_t c = 0; c < colors && words; c++)
		for (size_t x = 0; x < image->width; x++)
			any |= wide[x * channels + c];
	for (size_t c = 0; c < colors && !words; c++)
		for (size_t x = 0; x < image->width; x++)
			any |= bytes[x * channels + c];
	return any;
}

static bool glow_row_is_dark(const stilb_image *image, uint32_t y)
{
	stilb_scene_map map = {.to_u = {1.0f, 0.0f, 0.0f}, .to_v = {0.0f, 1.0f, 0.0f}, .nearest = true};
	if (image->format != STILB_IMAGE_F16_LINEAR && image->format != STILB_IMAGE_F32_LINEAR)
		return glow_largest_code(image, y) == 0;
	for (uint32_t x = 0; x < image->width; x++) {
		stilb_vec2 place = {((float)x + 0.5f) / (float)image->width, ((float)y + 0.5f) / (float)image->height};
		stilb_vec4 texel = gi_texture_map(image, &map, place);
		if (texel[0] > 0.0f || texel[1] > 0.0f || texel[2] > 0.0f)
			return false;
	}
	return true;
}

bool gi_glow_is_dark(const stilb_image *image)
{
	bool dark = image->pixels;
	for (uint32_t y = 0; y < image->height && dark; y++)
		dark = glow_row_is_dark(image, y);
	return dark;
}
