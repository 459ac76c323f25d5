/*
 * scene_impostor: what a model looks like from afar, as plain data: small pictures of it from many directions. Whoever
 * draws it needs two triangles. geometry_impostor.h makes impostors of meshes; shading/shade_impostor.h says which
 * pictures a viewer needs and where they are looked up.
 *
 * Life cycle.  Filled in by stilb_geometry_impostor_bake, or by hand around pixels of somebody else -> read ->
 *              stilb_scene_impostor_finish.
 * Threads.     [one-writer].
 * Units.       As scene.h: metres, linear Rec.709.
 */
#ifndef STILB_SCENE_IMPOSTOR_H
#define STILB_SCENE_IMPOSTOR_H

#include "scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

#define STILB_SCENE_IMPOSTOR_MIN_GRID 3u
#define STILB_SCENE_IMPOSTOR_MIN_SIDE 4u
#define STILB_SCENE_IMPOSTOR_MAX_TEXELS 4096u /* grid * side: 256 MiB of maps */

/* grid * grid pictures of side * side texels, of the directions that shade_impostor_direction gives; grid is odd.
 * Picture (x, y) covers columns x * side .. and rows y * side .. of both halves of maps.
 *
 * maps: F16_LINEAR, 4 channels, grid * side wide and twice as high.
 * Upper half: diffuse reflectance (red, green, blue), then the share of the texel that the model covers, [0, 1].
 * Lower half: the unit normal in the picture's frame as shade_octahedral_from_direction has it (two channels), the
 * height above the plate in radii, [-1, 1], towards the viewer, and roughness, [0, 1].
 * Texels that the model does not cover have the values of their neighbours, so that filtering mixes in no others. */
typedef struct stilb_scene_impostor {
	float center[3], radius; /* of the sphere about the model, metres in the model's space, radius > 0 */
	uint32_t grid, side;
	stilb_image maps;
	/* What the maps do not have: specular, anisotropy, wrap. diffuse is the mean over the surface, emission is 0. */
	stilb_scene_material material;
} stilb_scene_impostor;

/* What is wrong with an impostor, as words that go on after its name ("its grid is not odd"); NULL: nothing. Looks at
 * the numbers and the shape of the maps, not at their texels. [any-thread] */
const char *stilb_scene_impostor_mistake(const stilb_scene_impostor *impostor);

/* Frees the maps and leaves {0}. Accepts {0}. [one-writer] */
void stilb_scene_impostor_finish(stilb_scene_impostor *impostor);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
