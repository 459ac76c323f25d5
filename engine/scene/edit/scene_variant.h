/*
 * scene_variant: other materials for the parts of a scene, in sets with a name: a car in red and in blue. Files of glTF
 * 2.0 have them by KHR_materials_variants. One set is shown at a time, at first the file's own materials.
 *
 * Life cycle.  stilb_scene.variants is made with the scene and freed with it; NULL: the file has none.
 * Threads.     [one-writer] for each scene, and nobody reads it meanwhile, as for edits (scene_edit.h).
 * Example.     The next variant, and after the last one the file's own materials:
 *
 *   const stilb_scene_variants *variants = scene->variants;
 *   if (variants)
 *       result = stilb_scene_show_variant(scene, variants->shown < variants->count ? variants->shown + 1 : 0);
 */
#ifndef STILB_SCENE_VARIANT_H
#define STILB_SCENE_VARIANT_H

#include "scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

#define STILB_SCENE_MAX_VARIANTS 1024u

typedef struct stilb_scene_variants {
	uint32_t count;      /* 1..STILB_SCENE_MAX_VARIANTS */
	uint32_t part_count; /* that the file had: parts which edits have added have no variants */
	uint32_t shown;      /* 0: the file's own materials; v + 1: variant v */
	char (*names)[64];   /* [count] UTF-8, cut to fit; "number 3": it has none */
	uint32_t *materials; /* [(count + 1) * part_count]: first the file's own, then those of each variant */
} stilb_scene_variants;

/* Shows the file's own materials, variant 0, or variant - 1 of the list. Only parts change that have the material of
 * what was shown before: what edits have given another one keeps that. STILB_ERROR_ARGUMENT: the scene has no such
 * variant, or one of its materials was removed; STILB_ERROR_MEMORY. Then the scene is as it was. */
stilb_result stilb_scene_show_variant(stilb_scene *scene, uint32_t variant);

/* Shows the variant of this name, the first of several. STILB_ERROR_ARGUMENT also if there is none, in a line that
 * lists those that there are. */
stilb_result stilb_scene_show_variant_named(stilb_scene *scene, const char *name);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
