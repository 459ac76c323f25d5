#include "gi/trace/gi_cover.h"

#include "gi/gi_surface.h"

#include <string.h>

/* Mixes all bits of a number. Source: Appleby, MurmurHash3 (2011), fmix32. */
static uint32_t cover_mix(uint32_t x)
{
	x = (x ^ x >> 16) * 0x85ebca6bu;
	x = (x ^ x >> 13) * 0xc2b2ae35u;
	return x ^ x >> 16;
}

/* Independent, so that two half transparent layers let a quarter through. */
float gi_cover_number(const gi_crossing *crossing)
{
	uint32_t bits;
	memcpy(&bits, &crossing->chance, sizeof bits);
	bits = cover_mix(cover_mix(bits + 0x9e3779b9u * (crossing->part + 1)) + 0x9e3779b9u * (crossing->triangle + 1));
	return (float)(bits >> 8) * 0x1p-24f;
}

bool gi_cover_meets(const stilb_gi_scene *scene, const gi_crossing *crossing)
{
	STILB_ASSERT(crossing->part < scene->part_count);
	const gi_part *part = &scene->parts[crossing->part];
	if (!part->sieve)
		return true;
	STILB_ASSERT(part->sieve <= scene->surface_count);
	gi_maps maps = {&scene->surfaces[part->sieve - 1], scene->textures, scene->texture_count};
	if (gi_maps_are_one_sided(maps.surface) && !crossing->front)
		return false;
	if (maps.surface->alpha == STILB_SCENE_OPAQUE)
		return true;
	if (maps.surface->alpha == STILB_SCENE_BLEND && crossing->chance >= GI_CHANCE_ALL)
		return true;
	gi_place place = gi_place_at(part, crossing->triangle, crossing->u, crossing->v);
	return gi_cover_number(crossing) < gi_maps_alpha(&maps, &place);
}
