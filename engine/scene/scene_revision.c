/* What has changed of a scene. */
#include "scene/edit/scene_node.h"

#include <string.h>

/* Mixes the bytes of values into a hash, eight at a time. The multiplier is the one of splitmix64 (Steele et al., "Fast
 * splittable pseudorandom number generators", 2014). */
static uint64_t revision_hash(uint64_t hash, const void *values, size_t size)
{
	const unsigned char *bytes = values;
	for (size_t at = 0; at < size; at += sizeof hash) {
		uint64_t word = 0;
		memcpy(&word, bytes + at, size - at < sizeof word ? size - at : sizeof word);
		hash = (hash ^ word) * 0xbf58476d1ce4e5b9ull;
		hash ^= hash >> 31;
	}
	return hash;
}

/* Its map and its floor are made anew when they change. */
static uint64_t revision_backdrop(uint64_t hash, const stilb_scene_backdrop *backdrop)
{
	const uint64_t parts[3] = {backdrop->kind, (uintptr_t)backdrop->map, (uintptr_t)backdrop->floor};
	hash = revision_hash(hash, backdrop->color, sizeof backdrop->color);
	return revision_hash(hash, parts, sizeof parts);
}

static uint64_t revision_surroundings(const stilb_scene_surroundings *around)
{
	const stilb_image *map = &around->panorama;
	const uint64_t picture[4] = {(uintptr_t)map->pixels, map->width, map->height, around->glossy};
	uint64_t hash = revision_hash(0, around->sky, sizeof around->sky);
	hash = revision_hash(hash, around->ground, sizeof around->ground);
	hash = revision_hash(hash, &around->rotation, sizeof around->rotation);
	return revision_hash(hash, picture, sizeof picture);
}

stilb_scene_revisions stilb_scene_revisions_read(stilb_scene *scene)
{
	STILB_ASSERT(scene);
	stilb_scene_update_nodes(scene, NULL, 0);
	uint64_t *counts[3] = {&scene->revisions.lights, &scene->revisions.surroundings, &scene->revisions.camera};
	const uint64_t now[3] = {
		revision_hash(scene->light_count, scene->lights, scene->light_count * sizeof *scene->lights),
		revision_backdrop(revision_surroundings(&scene->surroundings), &scene->backdrop),
		revision_hash(0, &scene->camera, sizeof scene->camera),
	};
	for (int i = 0; i < 3; i++) {
		if (scene->values[i] == now[i])
			continue; /* written only where something has changed: other threads may read the counts meanwhile */
		(*counts[i])++;
		scene->values[i] = now[i];
	}
	return scene->revisions;
}
