/* Shared by the tests of render and engine: the hash of the stream of draws that a frame must report, as render.h
 * defines it, computed from the scene alone; and a test that the process has loaded no third-party library. */
#ifndef RENDER_REFERENCE_H
#define RENDER_REFERENCE_H

#include "render/render.h"
#include "scene/scene.h"
#include "support/test.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

#define REFERENCE_HASH_START 14695981039346656037ull

/* FNV-1a over the four bytes of a number, lowest first. */
static inline uint64_t reference_hash_u32(uint64_t hash, uint32_t number)
{
	for (int byte = 0; byte < 4; byte++)
		hash = (hash ^ ((number >> (8 * byte)) & 0xffu)) * 1099511628211ull;
	return hash;
}

static inline uint64_t reference_hash_float(uint64_t hash, float number)
{
	uint32_t bits;
	memcpy(&bits, &number, sizeof bits);
	return reference_hash_u32(hash, bits);
}

/* Continues the hash over the begin of a pass, in a view with this shading. */
static inline uint64_t reference_hash_pass(uint64_t hash, const stilb_render_shading *shading)
{
	uint32_t formulas[] = {shading->brdf, shading->ndf, shading->g, shading->f, shading->light};
	float added[] = {shading->roughness, shading->anisotropy, shading->wrap, shading->specular};
	for (size_t i = 0; i < sizeof formulas / sizeof *formulas; i++)
		hash = reference_hash_u32(hash, formulas[i]);
	for (size_t i = 0; i < sizeof added / sizeof *added; i++)
		hash = reference_hash_float(hash, added[i]);
	return hash;
}

/* The hash at the begin of a frame's only pass, in a view whose shading is all zeros. */
#define REFERENCE_HASH_PASS reference_hash_pass(REFERENCE_HASH_START, &(stilb_render_shading){0})

static inline uint64_t reference_hash_draw(uint64_t hash, const stilb_scene *scene, uint32_t mesh, uint32_t material,
                                           const stilb_mat4 *transform)
{
	hash = reference_hash_u32(hash, mesh);
	hash = reference_hash_u32(hash, material);
	for (int i = 0; i < 16; i++)
		hash = reference_hash_float(hash, transform->m[i]);
	return reference_hash_u32(hash, scene->meshes[mesh].index_count);
}

/* Continues the hash over the draws of every part of the models in ids. */
static inline uint64_t reference_hash_models(uint64_t hash, const stilb_scene *scene, const uint32_t *ids,
                                             uint32_t count)
{
	for (uint32_t i = 0; i < count; i++)
		for (uint32_t p = scene->first_part[ids[i]]; p < scene->first_part[ids[i] + 1]; p++)
			hash = reference_hash_draw(hash, scene, scene->part_mesh[p], scene->part_material[p],
			                           &scene->part_transform[p]);
	return hash;
}

/* Is a library whose path holds this text mapped into the process? */
static inline bool reference_library_loaded(const char *text)
{
	char line[4096];
	bool found = false;
	FILE *maps = fopen("/proc/self/maps", "r");
	while (maps && fgets(line, sizeof line, maps))
		found = found || strstr(line, text);
	if (maps)
		fclose(maps);
	return found;
}

/* A test: the null device loads no third-party library, so the thread sanitizer sees all code that runs. */
static inline void reference_no_third_party(void **state)
{
	(void)state;
	assert_true(reference_library_loaded("libcmocka")); /* the query itself works */
	static const char *const libraries[] = {"libvulkan",  "libglfw", "libOpenImageIO",
	                                        "libOpenEXR", "libpng",  "libembree"};
	for (size_t i = 0; i < sizeof libraries / sizeof *libraries; i++)
		assert_false(reference_library_loaded(libraries[i]));
}

#endif
