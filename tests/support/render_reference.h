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

static inline uint64_t reference_hash_floats(uint64_t hash, const float *numbers, int count)
{
	for (int i = 0; i < count; i++)
		hash = reference_hash_float(hash, numbers[i]);
	return hash;
}

static inline uint64_t reference_hash_light(uint64_t hash, const stilb_scene_light *light)
{
	bool round = light->kind == STILB_SCENE_LIGHT_SPHERE || light->kind == STILB_SCENE_LIGHT_DISK;
	hash = reference_hash_floats(hash, light->position, 3);
	hash = reference_hash_float(hash, (float)(light->kind + 8 * light->falloff));
	hash = reference_hash_floats(hash, light->direction, 3);
	hash = reference_hash_float(hash, light->reach);
	hash = reference_hash_floats(hash, light->intensity, 3);
	hash = reference_hash_float(hash, light->cos_inner);
	hash = reference_hash_floats(hash, light->half_x, 3);
	hash = reference_hash_float(hash, light->cos_outer);
	hash = reference_hash_floats(hash, light->half_y, 3);
	return reference_hash_float(hash, round ? light->radius : 0.0f);
}

/* Continues the hash over the begin of a pass in this view, of few lights; those that are only baked are left out, and
 * those that end nowhere come first. */
static inline uint64_t reference_hash_pass(uint64_t hash, const stilb_render_view *view)
{
	const stilb_render_shading *shading = &view->shading;
	uint32_t formulas[] = {shading->brdf, shading->ndf, shading->g, shading->f};
	float added[] = {shading->roughness, shading->anisotropy, shading->wrap, shading->specular};
	for (size_t i = 0; i < sizeof formulas / sizeof *formulas; i++)
		hash = reference_hash_u32(hash, formulas[i]);
	hash = reference_hash_floats(hash, added, 4);
	hash = reference_hash_floats(hash, view->surroundings.sky, 3);
	hash = reference_hash_floats(hash, view->surroundings.ground, 3);
	hash = reference_hash_u32(hash, (uint32_t)view->surroundings.glossy + 2 * (uint32_t)view->ambient);
	hash = reference_hash_u32(hash, view->both_sides);
	uint32_t lit = 0;
	for (uint32_t i = 0; i < view->light_count; i++)
		lit += view->lights[i].use != STILB_SCENE_LIGHT_BAKED;
	hash = reference_hash_u32(hash, lit);
	for (int ends = 0; ends < 2; ends++)
		for (uint32_t i = 0; i < view->light_count; i++) {
			const stilb_scene_light *light = &view->lights[i];
			bool far = light->kind == STILB_SCENE_LIGHT_DIRECTIONAL || light->falloff == STILB_SCENE_LIGHT_PHYSICAL;
			if (light->use != STILB_SCENE_LIGHT_BAKED && far != (bool)ends)
				hash = reference_hash_light(hash, light);
		}
	return hash;
}

/* The hash at the begin of a frame's only pass, in a view that is all zeros. */
#define REFERENCE_HASH_PASS reference_hash_pass(REFERENCE_HASH_START, &(stilb_render_view){0})

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
