#include "gi/gi_scene_hash.h"

#include "gi/integrate/gi_backdrop.h"
#include "gi/light/gi_environment.h"
#include "gi/light/gi_light_listed.h"

#include <assert.h>
#include <stddef.h>

static_assert(sizeof(stilb_scene_map) == 32 &&
                  offsetof(stilb_scene_surface, workflow) == sizeof(stilb_scene_map) * STILB_SCENE_MAPS,
              "maps have no bytes between their members");

static uint64_t hash_u32(uint64_t hash, uint32_t value)
{
	return stilb_hash_fnv1a64(hash, &value, sizeof value);
}

/* A surface but for the bytes between its members, which are anything. */
static uint64_t hash_surface(uint64_t hash, const stilb_scene_surface *surface)
{
	size_t flags = offsetof(stilb_scene_surface, one_sided), rest = offsetof(stilb_scene_surface, anisotropy);
	const char *bytes = (const char *)surface;
	hash = stilb_hash_fnv1a64(hash, bytes, flags);
	hash = hash_u32(hash, surface->one_sided | (uint32_t)surface->unlit << 1);
	return stilb_hash_fnv1a64(hash, bytes + rest, sizeof *surface - rest);
}

/* Triangles, and how they look. */
static uint64_t hash_surfaces(uint64_t hash, const stilb_gi_scene *scene)
{
	for (uint32_t i = 0; i < scene->mesh_count; i++) {
		const gi_mesh *mesh = &scene->meshes[i];
		hash = stilb_hash_fnv1a64(hash, mesh->vertices, mesh->vertex_count * sizeof *mesh->vertices);
		hash = stilb_hash_fnv1a64(hash, mesh->triangles, mesh->triangle_count * sizeof *mesh->triangles);
		if (mesh->extras)
			hash = stilb_hash_fnv1a64(hash, mesh->extras, mesh->vertex_count * sizeof *mesh->extras);
	}
	for (uint32_t i = 0; i < scene->part_count; i++) {
		const gi_part *part = &scene->parts[i];
		hash = hash_u32(hash_u32(hash, part->mesh), part->material);
		hash = stilb_hash_fnv1a64(hash, &part->to_world, sizeof part->to_world);
		if (scene->flagged)
			hash = hash_u32(hash_u32(hash, part->mask), part->lit_by);
	}
	hash = stilb_hash_fnv1a64(hash, scene->materials, scene->material_count * sizeof *scene->materials);
	for (uint32_t i = 0; i < scene->surface_count; i++)
		hash = hash_surface(hash, &scene->surfaces[i]);
	for (uint32_t i = 0; i < scene->texture_count; i++) {
		const stilb_image *texture = &scene->textures[i];
		hash = hash_u32(hash_u32(hash, texture->width), texture->height);
		hash = hash_u32(hash_u32(hash, texture->channels), texture->format);
		hash = stilb_hash_fnv1a64(hash, texture->pixels, stilb_image_size(texture));
	}
	return hash;
}

static uint64_t hash_lights(uint64_t hash, const gi_lights *lights)
{
	for (uint32_t i = 0; i < lights->listed_count; i++)
		hash = stilb_hash_fnv1a64(hash, &lights->listed[i].light, sizeof lights->listed[i].light);
	const gi_environment *environment = lights->environment;
	if (!environment->map) {
		hash = stilb_hash_fnv1a64(hash, &environment->sky, sizeof(float[3]));
		return stilb_hash_fnv1a64(hash, &environment->ground, sizeof(float[3]));
	}
	size_t numbers = (size_t)environment->width * environment->height * environment->channels;
	hash = hash_u32(hash_u32(hash, environment->width), environment->height);
	const float turn[2] = {environment->sine, environment->cosine};
	hash = stilb_hash_fnv1a64(hash, turn, sizeof turn);
	return stilb_hash_fnv1a64(hash, environment->map, numbers * sizeof *environment->map);
}

uint64_t gi_scene_hash(const stilb_gi_scene *scene)
{
	return gi_backdrop_hash(hash_lights(hash_surfaces(STILB_FNV1A64_START, scene), &scene->lights), scene->backdrop);
}
