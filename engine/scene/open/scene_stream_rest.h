/* What follows the meshes in the stream of a scene: its nodes, the variants of its materials, names, and what moves.
 * Needs the scene's counts and meshes. */
#ifndef STILB_SCENE_STREAM_REST_H
#define STILB_SCENE_STREAM_REST_H

#include "scene/open/scene_stream.h"

/* Names are printed: what could move a terminal's cursor becomes a space. */
void scene_stream_clean_name(char *name, size_t size);

bool scene_stream_write_rest(int file, const stilb_scene *scene);

/* Reads it into the scene, whose other arrays are complete. What it names is not checked yet. STILB_ERROR_FILE,
 * STILB_ERROR_MEMORY; the scene is to be destroyed then. */
stilb_result scene_stream_read_rest(scene_stream *stream, stilb_scene *scene);

#endif
