/*
 * gi_scene_hash: a number that identifies a scene's contents. A file made from a scene (a checkpoint, an irradiance
 * cache) holds it, which tells if the file belongs to the scene at hand.
 */
#ifndef GI_SCENE_HASH_H
#define GI_SCENE_HASH_H

#include "gi/gi_scene_internal.h"

/* FNV-1a of every number that the radiance of a ray depends on: triangles, materials, textures, lights,
 * surroundings. Reads the whole scene, some milliseconds for a million triangles. [any-thread] */
uint64_t gi_scene_hash(const stilb_gi_scene *scene);

#endif
