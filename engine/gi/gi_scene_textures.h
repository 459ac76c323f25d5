/*
 * gi_scene_textures: the scene's textures as rays read them, texel by texel: pictures of compressed blocks are decoded
 * (stilb_image_decode), all others are read where the scene has them. For gi_scene.c.
 */
#ifndef STILB_GI_SCENE_TEXTURES_H
#define STILB_GI_SCENE_TEXTURES_H

#include "gi/gi_scene_internal.h"

/* A hash of where the scene's textures are, and of the count of their changes. */
uint64_t gi_scene_textures_hash(const stilb_scene *scene);

/* Makes gi->found.textures, unless they are there and the scene's are as they were. pool: the caller is its owner.
 * STILB_ERROR_MEMORY; then there are none. */
stilb_result gi_scene_textures_make(stilb_gi_scene *gi, const stilb_scene *scene, stilb_job_pool *pool);

/* Frees them. Accepts {0}. */
void gi_scene_textures_finish(gi_found *found);

#endif
