/*
 * gi_scene_hash: whether a file that was made of a scene (a checkpoint, an irradiance cache) belongs to this one.
 */
#ifndef GI_SCENE_HASH_H
#define GI_SCENE_HASH_H

#include "gi/gi_scene_internal.h"

/* FNV-1a of every number that a ray's radiance depends on: triangles, materials, textures, lights, surroundings. Reads all of
 * the scene, some milliseconds for a million triangles: not for every frame. [any-thread] */
uint64_t gi_scene_hash(const stilb_gi_scene *scene);

#endif
