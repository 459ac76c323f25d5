/* The parts of a dump that surfaces need: what materials have besides constants, and the extras of vertices. */
#include "render/render_dump_format.h"
#include "render/render_internal.h"

#include <string.h>

/* ---- saving ------------------------------------------------------------------------------------------------------ */

/* The maps of a material by its entry of render_resources.materials; NULL: it has none. */
static const render_maps_slot *dump_slot(const render_resources *resources, uint32_t material, uint32_t *index)
{
	uint32_t entry = resources->materials[material] & RENDER_INDEX_MASK;
	STILB_ASSERT_LOCKED(&resources->lock);
	if (!(entry & RENDER_STATE_MAPS))
		return NULL;
	*index = ((const render_material *)resources->heaps[RENDER_HEAP_MATERIALS].data)[material].maps;
	return &resources->maps[*index];
}

bool render_dump_surface_textures(const render_resources *resources, uint32_t material, uint32_t textures[RENDER_MAPS])
{
	uint32_t index;
	const render_maps_slot *slot = dump_slot(resources, material, &index);
	memset(textures, 0, RENDER_MAPS * sizeof *textures);
	for (uint32_t i = 0; slot && i < RENDER_MAPS; i++)
		textures[i] = slot->bits >> i & 1u ? slot->textures[i] & RENDER_INDEX_MASK : 0;
	return slot;
}

uint32_t render_dump_surface_function(const render_resources *resources, uint32_t material)
{
	uint32_t index;
	const render_maps_slot *slot = dump_slot(resources, material, &index);
	return slot ? render_maps_function(slot->bits) : 0;
}

void render_dump_surface_put(const render_resources *resources, uint32_t material, const uint32_t *places,
                             const uint16_t *functions, render_dump_surface *out)
{
	uint32_t index = 0, textures[RENDER_MAPS];
	const render_maps_slot *slot = dump_slot(resources, material, &index);
	STILB_ASSERT(slot);
	render_dump_surface_textures(resources, material, textures);
	const render_maps_stored *stored = (const render_maps_stored *)resources->heaps[RENDER_HEAP_MAPS].data + index;
	out->record = stored->record;
	out->bits = (uint32_t)slot->bits;
	out->function = functions[render_maps_function(slot->bits)];
	memcpy(out->parameters, stored->parameters, sizeof out->parameters);
	for (uint32_t i = 0; i < RENDER_MAPS; i++)
		out->textures[i] = textures[i] ? places[textures[i]] + 1 : 0;
	memcpy(out->samplers, slot->samplers, sizeof slot->samplers);
}

render_extra *render_dump_extras_put(const render_resources *resources, uint32_t mesh, render_extra *out)
{
	const render_mesh_slot *slot = &resources->meshes[mesh];
	STILB_ASSERT_LOCKED(&resources->lock);
	if (!(slot->flags & RENDER_MESH_EXTRAS))
		return out;
	const render_extra_place *places = (const render_extra_place *)resources->heaps[RENDER_HEAP_EXTRA_PLACES].data;
	uint32_t first = places[mesh].extra_pairs & ~RENDER_EXTRA_PAIRS;
	memcpy(out, (const render_extra *)resources->heaps[RENDER_HEAP_EXTRAS].data + first,
	       slot->vertex_count * sizeof *out);
	return out + slot->vertex_count;
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

static bool dump_is_finite(const float *values, size_t count)
{
	bool finite = true;
	for (size_t i = 0; i < count; i++)
		finite &= (bool)isfinite(values[i]);
	return finite;
}

static const char *dump_surface_mistake(const render_dump_surface *surface, uint32_t textures, uint32_t functions)
{
	static const uint8_t zero[sizeof surface->unused] = {0};
	const render_maps_record *record = &surface->record;
	uint32_t both = RENDER_MAPS_MASK | RENDER_MAPS_BLEND;
	uint32_t layers = RENDER_MAPS_COAT | RENDER_MAPS_SHEEN | RENDER_MAPS_BRUSHED | RENDER_MAPS_THROUGH |
	                  (((1u << RENDER_MAPS) - 1u) & ~((1u << RENDER_MAPS_PLAIN) - 1u));
	bool layered = surface->bits & RENDER_MAPS_LAYERS;
	if (surface->bits >= RENDER_MAPS_EXTRAS || (surface->bits & both) == both || (surface->bits & layers && !layered))
		return "its bits are unknown";
	if (!dump_is_finite(record->color, offsetof(render_maps_record, places) / sizeof(float)))
		return "a number is not finite";
	for (uint32_t i = 0; i < RENDER_MAPS; i++) {
		const render_maps_place *place = &record->places[i];
		if (!dump_is_finite(place->to_u, offsetof(render_maps_place, name) / sizeof(float)))
			return "a map's place is not finite";
		if (surface->textures[i] > textures || !surface->textures[i] != !(surface->bits >> i & 1u))
			return "a map's texture is not there, or too much";
		if (surface->samplers[i] >= RENDER_MAPS_SAMPLERS)
			return "a map's sampler is unknown";
	}
	if (surface->function > functions || !dump_is_finite(surface->parameters[0], (size_t)STILB_SCENE_PARAMETERS * 4))
		return "its function is not there, or a parameter is not finite";
	if (surface->also_unused != 0)
		return "its unused bytes are not zero";
	return memcmp(surface->unused, zero, sizeof zero) != 0 ? "its unused bytes are not zero" : NULL;
}

static stilb_result dump_check_extras(const stilb_render_dump *dump)
{
	uint64_t count = 0;
	for (uint32_t m = 0; m < dump->header->meshes; m++) {
		const render_dump_mesh *mesh = &dump->meshes[m];
		if (mesh->extras > 1)
			return stilb_fail(STILB_ERROR_FILE, "mesh %u: %u kinds of extras; there are 0 or 1", m, mesh->extras);
		count += mesh->extras ? mesh->vertices : 0;
	}
	if (count != dump->header->extras)
		return stilb_fail(STILB_ERROR_FILE, "header: %llu extras of vertices, but meshes have %llu",
		                  (unsigned long long)dump->header->extras, (unsigned long long)count);
	for (uint64_t e = 0; e < count; e++) {
		const render_extra *extra = &dump->extras[e];
		bool sound = dump_is_finite(extra->uv, 2) && (extra->sign == 0.0f || fabsf(extra->sign) == 1.0f);
		for (int c = 0; c < 4; c++)
			sound &= (extra->color[c] >> 10 & 31) != 31;
		if (!sound)
			return stilb_fail(STILB_ERROR_FILE, "extra %llu: a number is not finite, or its sign is none",
			                  (unsigned long long)e);
	}
	return STILB_OK;
}

stilb_result render_dump_check_surfaces(const stilb_render_dump *dump)
{
	uint64_t count = 0;
	for (uint32_t m = 0; m < dump->header->materials; m++) {
		const render_dump_material *material = &dump->materials[m];
		if (material->surface == 0)
			continue;
		if (material->surface != ++count || material->texture != 0)
			return stilb_fail(STILB_ERROR_FILE, "material %u: surface %u, not %llu, or a texture besides", m,
			                  material->surface, (unsigned long long)count);
	}
	if (count != dump->header->surfaces)
		return stilb_fail(STILB_ERROR_FILE, "header: %llu surfaces, but materials have %llu",
		                  (unsigned long long)dump->header->surfaces, (unsigned long long)count);
	for (uint64_t s = 0; s < count; s++) {
		const char *mistake = dump_surface_mistake(&dump->surfaces[s], dump->header->textures, dump->header->functions);
		if (mistake)
			return stilb_fail(STILB_ERROR_FILE, "surface %llu: %s", (unsigned long long)s, mistake);
	}
	return dump_check_extras(dump);
}

/* ---- playing ----------------------------------------------------------------------------------------------------- */

/* The kind of mips that a surface's map needs. */
static render_mips_kind dump_mips_kind(const render_dump_surface *surface, uint32_t map)
{
	bool coat = map == STILB_SCENE_MAP_CLEARCOAT_NORMAL;
	uint32_t spread = coat ? RENDER_MAPS_COAT_SPREAD : RENDER_MAPS_SPREAD;
	if ((map != STILB_SCENE_MAP_NORMAL && !coat) || !(surface->bits & spread))
		return RENDER_MIPS_MEANS;
	return surface->bits & (coat ? RENDER_MAPS_COAT_TWO : RENDER_MAPS_TWO) ? RENDER_MIPS_NORMALS_TWO
	                                                                       : RENDER_MIPS_NORMALS;
}

render_texture_way render_dump_texture_way(const stilb_render_dump *dump, uint32_t texture)
{
	render_texture_way way = {0};
	const render_dump_texture *stored = &dump->textures[texture];
	stilb_image_format format = (stilb_image_format)stored->format;
	bool spreads = format != STILB_IMAGE_U8_SRGB && !stilb_image_format_is_blocks(format) && stored->levels == 1;
	for (uint64_t s = 0; s < dump->header->surfaces; s++)
		for (uint32_t i = 0; i < RENDER_MAPS; i++) {
			if (dump->surfaces[s].textures[i] != texture + 1)
				continue;
			way.mips = true;
			way.kind = way.kind == RENDER_MIPS_MEANS && spreads ? dump_mips_kind(&dump->surfaces[s], i) : way.kind;
		}
	return way;
}

render_maps render_dump_surface_get(const stilb_render *render, const render_dump_surface *from,
                                    const stilb_render_texture *textures, const uint32_t *functions)
{
	render_maps maps = {.record = from->record, .bits = from->bits};
	for (uint32_t i = 0; i < RENDER_MAPS; i++)
		maps.textures[i] = from->textures[i] ? textures[from->textures[i] - 1].id : 0;
	memcpy(maps.samplers, from->samplers, sizeof maps.samplers);
	memcpy(maps.parameters, from->parameters, sizeof maps.parameters);
	render_function_name(render, from->function ? functions[from->function - 1] : 0, &maps);
	return maps;
}
