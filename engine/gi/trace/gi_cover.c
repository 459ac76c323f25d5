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

static float cover_between(float a, float b, float c, const gi_crossing *crossing)
{
	return a + ((b - a) * crossing->u + (c - a) * crossing->v);
}

/* The alpha at the crossing, by as little of gi_place_at as that takes: many rays cross many leaves. */
static float cover_alpha(const gi_maps *maps, const gi_part *part, const gi_crossing *crossing)
{
	const uint32_t *index = part->triangles[crossing->triangle].vertex;
	const float *uv[3];
	float alpha = 1.0f;
	bool second = part->extras && maps->surface->maps[STILB_SCENE_MAP_COLOR].set == 1;
	for (int i = 0; i < 3; i++)
		uv[i] = second ? part->extras[index[i]].uv : part->vertices[index[i]].uv;
	if (part->extras)
		alpha = cover_between(part->extras[index[0]].color[3], part->extras[index[1]].color[3],
		                      part->extras[index[2]].color[3], crossing);
	stilb_vec2 at = {cover_between(uv[0][0], uv[1][0], uv[2][0], crossing),
	                 cover_between(uv[0][1], uv[1][1], uv[2][1], crossing)};
	return gi_maps_alpha_at(maps, at, alpha);
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
	float alpha = cover_alpha(&maps, part, crossing);
	return maps.surface->alpha == STILB_SCENE_MASK ? alpha > 0.0f : gi_cover_number(crossing) < alpha;
}
