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
#define STILB_SCENE_IMPOSTOR_TEXELS 4.0f /* frames show it from where so many of its texels are at most a pixel wide */
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
	float center[3]; /* of the model's box, metres in the model's space */
	float half[3];   /* half the box's sides, >= 0: what lies beyond them is not drawn */
	float radius;    /* of the sphere about center that holds the model, > 0 */
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

/* ---- impostors of a scene ----------------------------------------------------------------------------------------
 * Any number of models may share one, like those of a horde. Frames show it in place of a model that is so far away
 * that its pictures have texels to spare (stilb_render_detail). Editing a mesh or a material makes all impostors of the
 * scene stale: no frame shows them until the program has baked them anew. Editing the parts of a model takes its
 * impostor away.
 *
 *   result = stilb_geometry_impostor_of_model(scene, 0, &desc, pool, 0, &impostor);
 *   if (result == STILB_OK)
 *       result = stilb_scene_add_impostor(scene, &impostor, &id);
 *   for (uint32_t m = 0; m < scene->model_count && result == STILB_OK; m++)
 *       result = stilb_scene_set_impostor(scene, m, id + 1);
 */

/* Takes over an impostor, which becomes {0}, under the id 0, 1, 2, ... It shows the scene as it is now; if others are
 * stale they are removed first. STILB_ERROR_ARGUMENT: it has a mistake. STILB_ERROR_MEMORY. *impostor is as before
 * after an error. [one-writer] */
stilb_result stilb_scene_add_impostor(stilb_scene *scene, stilb_scene_impostor *impostor, uint32_t *id);

/* Gives a model the impostor `impostor` - 1, which shows it in the space of its first part; 0: none.
 * STILB_ERROR_ARGUMENT: there is no such model or impostor. STILB_ERROR_MEMORY. [one-writer] */
stilb_result stilb_scene_set_impostor(stilb_scene *scene, uint32_t model, uint32_t impostor);

/* Removes all. [one-writer] */
void stilb_scene_remove_impostors(stilb_scene *scene);

/* Of the meshes that impostors show: stilb_scene.impostors_geometry while they are current. Poses do not count, since
 * what is posed is its own mesh and rarely has an impostor, which would show one pose alone. [any-thread] */
static inline uint64_t stilb_scene_impostors_revision(const stilb_scene *scene)
{
	return scene->revisions.geometry - scene->revisions.poses;
}

/* True if meshes, but for poses, and materials are still those that the scene's impostors show. [any-thread] */
bool stilb_scene_impostors_are_current(const stilb_scene *scene);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
