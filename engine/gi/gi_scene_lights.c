#include "gi/gi_scene_lights.h"

#include "gi/gi_scene_textures.h"
#include "gi/gi_surface.h"
#include "profiler/prof.h"
#include "scene/scene_look.h"

#include <stdlib.h>
#include <string.h>

static uint64_t hash_numbers(uint64_t hash, const uint64_t *numbers, size_t size)
{
	return stilb_hash_fnv1a64(hash, numbers, size);
}

static bool is_bright(const float emission[3])
{
	return emission[0] > 0.0f || emission[1] > 0.0f || emission[2] > 0.0f;
}

/* ---- textures ---------------------------------------------------------------------------------------------------- */

stilb_result gi_scene_ask_darkness(stilb_gi_scene *gi, const stilb_scene *scene)
{
	uint64_t hash = gi_scene_textures_hash(scene);
	if (gi->found.dark && gi->found.dark_count == scene->texture_count && gi->found.dark_hash == hash)
		return STILB_OK;
	free(gi->found.dark);
	gi->found.dark = calloc((size_t)scene->texture_count + 1, sizeof *gi->found.dark);
	gi->found.dark_count = gi->found.dark ? scene->texture_count : 0;
	gi->found.dark_hash = hash;
	return gi->found.dark
	           ? STILB_OK
	           : stilb_fail(STILB_ERROR_MEMORY, "no memory for a scene of %u textures", scene->texture_count);
}

bool gi_scene_emits(stilb_gi_scene *gi, const stilb_scene *scene, uint32_t id)
{
	STILB_ASSERT(id < scene->material_count);
	const stilb_scene_material *material = &scene->materials[id];
	if (!material->surface)
		return is_bright(material->emission);
	STILB_ASSERT(material->surface <= scene->surface_count);
	const stilb_scene_surface *surface = &scene->surfaces[material->surface - 1];
	uint32_t texture = surface->maps[STILB_SCENE_MAP_EMISSION].texture;
	if (surface->unlit || !is_bright(surface->emission))
		return false;
	if (texture == 0 || texture > gi->found.dark_count)
		return true;
	uint8_t *dark = &gi->found.dark[texture - 1];
	if (*dark == GI_DARKNESS_UNKNOWN)
		*dark = gi_glow_is_dark(&gi->found.textures[texture - 1]) ? GI_DARKNESS_DARK : GI_DARKNESS_NONE;
	return *dark == GI_DARKNESS_NONE;
}

/* ---- emitters ---------------------------------------------------------------------------------------------------- */

/* The surface by which triangles of the part do not emit the same all over and around; NULL: they do. */
static const stilb_scene_surface *glow_surface(const stilb_gi_scene *gi, const gi_part *part)
{
	if (part->first_light == GI_NO_LIGHT || (!part->surface && !part->sieve))
		return NULL;
	const stilb_scene_surface *surface = &gi->surfaces[(part->surface ? part->surface : part->sieve) - 1];
	bool holes = part->sieve > 0 && surface->alpha != STILB_SCENE_OPAQUE;
	bool maps = surface->maps[STILB_SCENE_MAP_EMISSION].texture > 0 || surface->clearcoat > 0.0f;
	return holes || maps ? surface : NULL;
}

/* Of all that the means of glows depend on; 0: nothing glows. */
static uint64_t glows_hash(const stilb_gi_scene *gi, const stilb_scene *scene)
{
	uint64_t hash = gi_scene_textures_hash(scene), numbers[] = {scene->revisions.geometry, gi->emitter_count};
	bool any = false;
	hash = hash_numbers(hash, numbers, sizeof numbers);
	for (uint32_t i = 0; i < gi->part_count; i++) {
		const stilb_scene_surface *surface = glow_surface(gi, &gi->parts[i]);
		uint64_t place[] = {i, gi->parts[i].first_light};
		if (!surface)
			continue;
		any = true;
		hash = hash_numbers(hash, place, sizeof place);
		hash = stilb_hash_fnv1a64(hash, surface, sizeof *surface);
	}
	return any ? hash : 0;
}

static gi_glow glow_of(const stilb_gi_scene *gi, const gi_part *part, const stilb_scene_surface *surface,
                       uint32_t triangle)
{
	gi_glow glow = {.maps = {surface, gi->textures, gi->texture_count}};
	const uint32_t *index = part->triangles[triangle].vertex;
	for (int i = 0; i < 3; i++)
		glow.corners[i] = gi_place_of(&part->vertices[index[i]], part->extras ? &part->extras[index[i]] : NULL);
	return glow;
}

/* Fills in the emitters of a part. known: gi->found.means has their means. */
static void emitters_of_part(const stilb_gi_scene *gi, const gi_part *part, bool known, gi_emitter *emitters)
{
	const gi_mesh *mesh = &gi->meshes[part->mesh];
	const stilb_scene_surface *surface = glow_surface(gi, part);
	for (uint32_t k = 0; k < mesh->triangle_count; k++) {
		uint32_t light = part->first_light + k;
		STILB_ASSERT(light < gi->emitter_count && !part->instance);
		gi_emitter *emitter = &emitters[light];
		for (int corner = 0; corner < 3; corner++)
			memcpy(emitter->position[corner], mesh->vertices[mesh->triangles[k].vertex[corner]].position,
			       sizeof emitter->position[corner]);
		memcpy(emitter->emission, gi->materials[part->material].emission, sizeof emitter->emission);
		emitter->unmet = !(part->mask & GI_MASK_LIGHT);
		if (!surface)
			continue;
		STILB_ASSERT(gi->found.means);
		emitter->glow = glow_of(gi, part, surface, k);
		if (!known) {
			stilb_vec3 mean = gi_glow_mean(&emitter->glow);
			memcpy(gi->found.means[light], &mean, sizeof gi->found.means[light]);
		}
		memcpy(emitter->emission, gi->found.means[light], sizeof emitter->emission);
	}
}

/* Room for the means of glows with this hash. *known: they are there. */
static stilb_result means_ask(stilb_gi_scene *gi, uint64_t hash, bool *known)
{
	*known = gi->found.means && hash == gi->found.means_hash;
	if (hash == 0 || *known)
		return STILB_OK;
	free(gi->found.means);
	gi->found.means = malloc(gi->emitter_count * sizeof *gi->found.means);
	gi->found.means_hash = 0; /* until they are filled in */
	return gi->found.means ? STILB_OK : stilb_fail(STILB_ERROR_MEMORY, "no memory for %u lights", gi->emitter_count);
}

/* The list of emitting triangles, to be freed. */
static stilb_result emitters_make(stilb_gi_scene *gi, const stilb_scene *scene, gi_emitter **out)
{
	bool known;
	*out = NULL;
	uint64_t hash = glows_hash(gi, scene);
	stilb_result result = means_ask(gi, hash, &known);
	if (result != STILB_OK)
		return result;
	size_t size = ((size_t)gi->emitter_count + 1) * sizeof **out;
	gi_emitter *emitters = stilb_memory_alloc(1, size);
	if (!emitters)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for %u lights", gi->emitter_count);
	memset(emitters, 0, size);
	for (uint32_t i = 0; i < gi->part_count; i++)
		if (gi->parts[i].first_light != GI_NO_LIGHT)
			emitters_of_part(gi, &gi->parts[i], known, emitters);
	gi->found.means_hash = hash != 0 ? hash : gi->found.means_hash;
	*out = emitters;
	return STILB_OK;
}

/* ---- tables ------------------------------------------------------------------------------------------------------ */

static uint64_t emitter_hash(uint64_t hash, const gi_emitter *emitter)
{
	hash = stilb_hash_fnv1a64(hash, emitter->position, sizeof emitter->position);
	hash = stilb_hash_fnv1a64(hash, emitter->emission, sizeof emitter->emission);
	hash = stilb_hash_fnv1a64(hash, &emitter->unmet, sizeof emitter->unmet);
	const gi_glow *glow = &emitter->glow;
	uint64_t where[] = {(uintptr_t)glow->maps.surface, (uintptr_t)glow->maps.textures, glow->maps.texture_count};
	if (!glow->maps.surface)
		return hash;
	hash = hash_numbers(hash, where, sizeof where);
	return stilb_hash_fnv1a64(hash, glow->corners, sizeof glow->corners);
}

/* A hash of all that lights are made of. Lights and surroundings are hashed as scene_revision.c hashes them: by their
 * bytes, and a panorama by where its pixels are and by the count of its changes. */
static uint64_t lights_hash(const stilb_scene *scene, const gi_emitter *emitters, uint32_t count)
{
	const stilb_scene_surroundings *around = &scene->surroundings;
	const uint64_t numbers[] = {(uintptr_t)around->panorama.pixels, around->panorama.width, around->panorama.height,
	                            scene->revisions.surroundings, scene->light_count};
	uint64_t hash = STILB_FNV1A64_START;
	for (uint32_t i = 0; i < count; i++)
		hash = emitter_hash(hash, &emitters[i]);
	hash = stilb_hash_fnv1a64(hash, scene->lights, scene->light_count * sizeof *scene->lights);
	hash = stilb_hash_fnv1a64(hash, around->sky, sizeof around->sky);
	hash = stilb_hash_fnv1a64(hash, around->ground, sizeof around->ground);
	hash = stilb_hash_fnv1a64(hash, &around->rotation, sizeof around->rotation);
	return stilb_hash_fnv1a64(hash, numbers, sizeof numbers);
}

void gi_scene_lights_clear(stilb_gi_scene *gi)
{
	gi_lights_destroy(&gi->open_lights);
	gi_lights_destroy(&gi->lights);
	gi->lights_hash = 0;
}

static stilb_result tables_make(stilb_gi_scene *gi, const stilb_scene *scene, const gi_emitter *emitters)
{
	uint64_t hash = lights_hash(scene, emitters, gi->emitter_count);
	stilb_scene_environment_words(&scene->surroundings, gi->surroundings, sizeof gi->surroundings);
	if (gi->lights.environment && gi->lights_hash == hash)
		return STILB_OK;
	gi_scene_lights_clear(gi);
	stilb_result result = gi_lights_create(scene, emitters, gi->emitter_count, &gi->lights);
	if (result == STILB_OK)
		result = gi_lights_create_open(scene, &gi->lights, &gi->open_lights);
	gi->lights_hash = hash;
	return result;
}

stilb_result gi_scene_lights_make(stilb_gi_scene *gi, const stilb_scene *scene)
{
	PROFILE("gi.lights");
	gi_emitter *emitters;
	stilb_result result = emitters_make(gi, scene, &emitters);
	if (result == STILB_OK)
		result = tables_make(gi, scene, emitters);
	gi->info.lights = gi->lights.listed_count;
	for (uint32_t i = 0; i < gi->emitter_count && emitters; i++)
		gi->info.lights += is_bright(emitters[i].emission);
	free(emitters);
	return result;
}

void gi_scene_found_finish(gi_found *found)
{
	gi_scene_textures_finish(found);
	free(found->dark);
	free(found->means);
	*found = (gi_found){0};
}
