/*
 * bake_glb: the scene with its second uv, as a binary glTF 2.0 file that other programs open.
 *
 * Each part that has texels is a mesh of its own: positions, normals, the first uv as TEXCOORD_0, the place on the
 * page over its side as TEXCOORD_1, in model space, and a node with the part's transform. Materials have the diffuse
 * colour, roughness and emission; maps are left out. One with openness has the page's picture as its occlusion
 * texture, one with a lightmap names the file in extras.lightmap. [any-thread]
 */
#ifndef STILB_BAKE_GLB_H
#define STILB_BAKE_GLB_H

#include "bake/bake_atlas.h"

/* Names of a page's files, as they stand in the .glb; NULL: there is none. They hold one %u for the number of the
 * page. */
typedef struct stilb_bake_glb_files {
	const char *lightmap, *occlusion;
} stilb_bake_glb_files;

/* Writes path, whole or not at all. STILB_ERROR_FILE, also if it would be larger than the format allows, 4 GiB;
 * STILB_ERROR_MEMORY. */
stilb_result stilb_bake_glb_save(const stilb_scene *scene, const stilb_bake_atlas *atlas,
                                 const stilb_bake_glb_files *files, const char *path);

#endif
