#include "render/maps/render_maps.h"

#include "base/base_contract.h"
#include "image/image.h"
#include "render/render_vertex.h"
#include "shading/shade_gltf.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

/* ---- surfaces ---------------------------------------------------------------------------------------------------- */

#define MAPS_PLAIN ((1u << RENDER_MAPS_PLAIN) - 1u)
#define MAPS_OF_COAT                                                                                                   \
	(1u << STILB_SCENE_MAP_CLEARCOAT | 1u << STILB_SCENE_MAP_CLEARCOAT_ROUGHNESS |                                     \
	 1u << STILB_SCENE_MAP_CLEARCOAT_NORMAL)
#define MAPS_OF_SHEEN (1u << STILB_SCENE_MAP_SHEEN_COLOR | 1u << STILB_SCENE_MAP_SHEEN_ROUGHNESS)
#define MAPS_OF_SPECULAR (1u << STILB_SCENE_MAP_SPECULAR | 1u << STILB_SCENE_MAP_SPECULAR_COLOR)

/* The layers that show something, and the maps that they and highlights can have. */
static uint32_t maps_layers(const stilb_scene_surface *surface, uint32_t coat_channels, uint32_t *maps)
{
	const float *sheen = surface->sheen_color;
	uint32_t bits = 0;
	*maps = MAPS_PLAIN | (surface->workflow == STILB_SCENE_METALLIC ? MAPS_OF_SPECULAR : 0);
	if (surface->clearcoat > 0.0f) {
		bits |= RENDER_MAPS_COAT;
		*maps |= MAPS_OF_COAT;
		if (surface->maps[STILB_SCENE_MAP_CLEARCOAT_NORMAL].texture && coat_channels == 2)
			bits |= RENDER_MAPS_COAT_TWO;
	}
	if (sheen[0] > 0.0f || sheen[1] > 0.0f || sheen[2] > 0.0f) {
		bits |= RENDER_MAPS_SHEEN;
		*maps |= MAPS_OF_SHEEN;
	}
	if (surface->anisotropy > 0.0f) {
		bits |= RENDER_MAPS_BRUSHED;
		*maps |= 1u << STILB_SCENE_MAP_ANISOTROPY;
	}
	if (surface->transmission > 0.0f) {
		bits |= RENDER_MAPS_THROUGH | (surface->thickness > 0.0f ? RENDER_MAPS_SOLID : 0);
		*maps |= 1u << STILB_SCENE_MAP_TRANSMISSION;
		*maps |= surface->thickness > 0.0f ? 1u << STILB_SCENE_MAP_THICKNESS : 0;
	}
	return bits;
}

static uint32_t maps_bits(const stilb_scene_surface *surface, uint32_t channels, uint32_t coat_channels)
{
	uint32_t bits = 0, shown, layers = maps_layers(surface, coat_channels, &shown);
	for (uint32_t i = 0; i < RENDER_MAPS; i++)
		bits |= surface->maps[i].texture ? 1u << i & shown : 0;
	bits |= layers | (layers || bits & ~MAPS_PLAIN ? RENDER_MAPS_LAYERS : 0);
	if (surface->unlit)
		bits = (bits & 1u << STILB_SCENE_MAP_COLOR) | RENDER_MAPS_UNLIT;
	if (bits >> STILB_SCENE_MAP_NORMAL & 1u && channels == 2)
		bits |= RENDER_MAPS_TWO;
	return bits | (surface->alpha == STILB_SCENE_MASK ? RENDER_MAPS_MASK : 0) |
	       (surface->alpha == STILB_SCENE_BLEND ? RENDER_MAPS_BLEND : 0) |
	       (surface->one_sided ? RENDER_MAPS_ONE_SIDED : 0) |
	       (surface->workflow == STILB_SCENE_SPECULAR && !surface->unlit ? RENDER_MAPS_SPECULAR : 0);
}

/* True if all maps that there are lie in one way. */
static bool maps_lie_together(const render_maps *maps)
{
	const render_maps_place *first = NULL;
	for (uint32_t i = 0; i < RENDER_MAPS; i++) {
		const render_maps_place *place = &maps->record.places[i];
		if (!(maps->bits >> i & 1u))
			continue;
		first = first ? first : place;
		if (memcmp(place, first, offsetof(render_maps_place, name)) != 0)
			return false;
	}
	return true;
}

/* The reflectance at normal incidence. */
static void maps_specular(const stilb_scene_surface *surface, uint32_t bits, render_maps_record *record)
{
	const float *s = surface->specular;
	stilb_vec3 dielectric =
		shade_gltf_dielectric(surface->ior, stilb_vec3_make(s[0], s[1], s[2]), surface->specular_weight);
	bool metallic = surface->workflow == STILB_SCENE_METALLIC;
	record->specular_weight = bits & MAPS_OF_SPECULAR ? surface->specular_weight : 1.0f;
	for (int c = 0; c < 3; c++)
		record->specular[c] = !metallic                 ? s[c]
		                      : bits & MAPS_OF_SPECULAR ? s[c] * shade_gltf_reflectance(surface->ior)
		                                                : dielectric[c];
}

static void maps_of_layers(const stilb_scene_surface *surface, render_maps_record *record)
{
	record->coat = surface->clearcoat;
	record->coat_roughness = surface->clearcoat_roughness;
	record->coat_normal_scale = surface->clearcoat_normal_scale;
	memcpy(record->sheen, surface->sheen_color, sizeof record->sheen);
	record->sheen_roughness = surface->sheen_roughness;
	record->brushed = surface->anisotropy;
	record->brushed_turn[0] = cosf(surface->anisotropy_rotation);
	record->brushed_turn[1] = sinf(surface->anisotropy_rotation);
	record->transmission = surface->transmission;
	record->thickness = surface->thickness;
	record->ior = surface->ior;
	for (int c = 0; c < 3; c++)
		record->absorption[c] = fminf(-logf(surface->attenuation[c]) / surface->attenuation_distance, 1e30f);
}

render_maps render_maps_make(const stilb_scene_surface *surface, uint32_t channels, uint32_t coat_channels)
{
	STILB_ASSERT(surface && !stilb_scene_surface_mistake(surface));
	render_maps maps = {.bits = maps_bits(surface, channels, coat_channels),
	                    .record = {.roughness = surface->roughness,
	                               .metalness = surface->metalness,
	                               .normal_scale = surface->normal_scale,
	                               .occlusion = surface->occlusion,
	                               .cutoff = surface->cutoff}};
	render_maps_record *record = &maps.record;
	memcpy(record->color, surface->color, sizeof record->color);
	memcpy(record->emission, surface->emission, sizeof record->emission);
	maps_specular(surface, maps.bits, record);
	if (maps.bits & RENDER_MAPS_LAYERS)
		maps_of_layers(surface, record);
	memcpy(maps.parameters, surface->parameters, sizeof maps.parameters);
	for (uint32_t i = 0; i < RENDER_MAPS; i++) {
		const stilb_scene_map *map = &surface->maps[i];
		render_maps_place *place = &record->places[i];
		if (!(maps.bits >> i & 1u))
			continue;
		memcpy(place->to_u, map->to_u, sizeof place->to_u);
		memcpy(place->to_v, map->to_v, sizeof place->to_v);
		place->set = (float)map->set;
		place->name = map->texture;
		maps.samplers[i] = (uint8_t)(map->wrap_u + 3 * map->wrap_v + 9 * map->nearest);
	}
	maps.bits |= maps_lie_together(&maps) ? RENDER_MAPS_TOGETHER : 0;
	return maps;
}

#define MAPS_OF_TANGENTS                                                                                               \
	(RENDER_MAPS_TWO | RENDER_MAPS_COAT_TWO | RENDER_MAPS_SPREAD | RENDER_MAPS_COAT_SPREAD |                           \
	 1u << STILB_SCENE_MAP_NORMAL | 1u << STILB_SCENE_MAP_CLEARCOAT_NORMAL)

uint64_t render_maps_program_bits(uint64_t bits, bool extras, bool sides, bool depth)
{
	if (extras)
		bits |= RENDER_MAPS_EXTRAS;
	else
		bits &= ~(uint64_t)MAPS_OF_TANGENTS; /* there are none */
	if (!sides)
		bits &= ~(uint64_t)RENDER_MAPS_ONE_SIDED; /* everything is */
	if (!depth || (bits & RENDER_MAPS_MASK && render_maps_function(bits) > 0))
		return bits; /* a function may make alpha of anything */
	uint64_t kept = RENDER_MAPS_BLEND | RENDER_MAPS_ONE_SIDED;
	if (bits & RENDER_MAPS_MASK)
		kept |= RENDER_MAPS_MASK | RENDER_MAPS_EXTRAS | RENDER_MAPS_LAYERS | 1u << STILB_SCENE_MAP_COLOR;
	return bits & kept;
}

uint64_t render_maps_hash(const render_maps *maps)
{
	uint64_t hash = stilb_hash_fnv1a64(STILB_FNV1A64_START, &maps->record, sizeof maps->record);
	uint32_t bits = (uint32_t)maps->bits; /* without the function's index, which depends on what there was before */
	hash = stilb_hash_fnv1a64(hash, &bits, sizeof bits);
	hash = stilb_hash_fnv1a64(hash, maps->samplers, sizeof maps->samplers);
	if (maps->function_hash == 0)
		return hash;
	hash = stilb_hash_fnv1a64(hash, &maps->function_hash, sizeof maps->function_hash);
	return stilb_hash_fnv1a64(hash, maps->parameters, sizeof maps->parameters);
}

/* ---- extras ------------------------------------------------------------------------------------------------------ */

void render_extras_pack(const stilb_scene_vertex_extra *extras, size_t count, render_extra *out)
{
	for (size_t v = 0; v < count; v++, extras++, out++) {
		const float *t = extras->tangent;
		bool there = t[0] != 0.0f || t[1] != 0.0f || t[2] != 0.0f;
		*out = (render_extra){.tangent = there ? render_direction_pack(t) : 0,
		                      .sign = !there        ? 0.0f
		                              : t[3] < 0.0f ? -1.0f
		                                            : 1.0f,
		                      .uv = {extras->uv[0], extras->uv[1]}};
		for (int c = 0; c < 4; c++)
			out->color[c] = stilb_image_half_from_float(fminf(extras->color[c], 65504.0f));
	}
}

void render_extras_unpack(const render_extra *packed, size_t count, stilb_scene_vertex_extra *out)
{
	for (size_t v = 0; v < count; v++, packed++, out++) {
		*out = (stilb_scene_vertex_extra){.tangent = {[3] = packed->sign}, .uv = {packed->uv[0], packed->uv[1]}};
		if (packed->sign != 0.0f)
			render_direction_unpack(packed->tangent, out->tangent);
		for (int c = 0; c < 4; c++)
			out->color[c] = stilb_image_half_to_float(packed->color[c]);
	}
}
