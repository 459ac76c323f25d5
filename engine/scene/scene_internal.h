/* What the files of scene/ share. */
#ifndef STILB_SCENE_INTERNAL_H
#define STILB_SCENE_INTERNAL_H

#include "scene/scene.h"

/* A scene with room for these counts, everything zero. */
stilb_result scene_create(uint32_t model_count, uint32_t part_count, uint32_t mesh_count, uint32_t material_count,
                          stilb_scene **scene);

#endif
