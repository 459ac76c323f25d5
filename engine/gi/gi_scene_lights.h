/*
 * gi_scene_lights: which triangles of a scene are lights, and the tables of lights that are made of them. For
 * gi_scene.c.
 *
 * A triangle that emits by a map is a light if the map has light where the triangle lies. What was found of textures
 * and triangles is kept for the next update.
 */
#ifndef STILB_GI_SCENE_LIGHTS_H
#define STILB_GI_SCENE_LIGHTS_H

#include "gi/gi_scene_internal.h"

/* Before gi_scene_emits: forgets what was found of textures that are others now. STILB_ERROR_MEMORY. */
stilb_result gi_scene_ask_darkness(stilb_gi_scene *gi, const stilb_scene *scene);

/* True if parts of this material are lights: it emits, and its map of emission is not all dark. */
bool gi_scene_emits(stilb_gi_scene *gi, const stilb_scene *scene, uint32_t material);

/* Makes the tables of lights, unless they are there and as they would become, and counts them. All parts are there, and
 * emitter_count is. Errors: as of stilb_gi_scene_create. */
stilb_result gi_scene_lights_make(stilb_gi_scene *gi, const stilb_scene *scene);

/* Leaves none, but keeps what was found. Accepts a scene that has none. */
void gi_scene_lights_clear(stilb_gi_scene *gi);

/* Frees what was found. Accepts {0}. */
void gi_scene_found_finish(gi_found *found);

#endif
