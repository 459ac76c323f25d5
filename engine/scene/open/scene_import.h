/*
 * scene_import: scene files through Assimp. Assimp reads some fifty formats, crashes on files that somebody made for
 * it, and keeps growing or never returns on others. So it runs in a process of its own, the program stilb-scene-import
 * (engine/scene/importer), whose memory and time are bounded, and which sends a finished scene, or says why not,
 * through a pipe (scene_stream.h). A crash there is an error here; and Stilb's own programs start without loading
 * Assimp.
 */
#ifndef STILB_SCENE_IMPORT_H
#define STILB_SCENE_IMPORT_H

#include "scene/scene.h"

#define SCENE_IMPORTER "stilb-scene-import"

typedef struct scene_import_limits {
	uint64_t bytes; /* of memory */
	double seconds;
} scene_import_limits;

/* As stilb_scene_open says. */
scene_import_limits scene_import_limits_default(void);

/* A file within limits; path is no built-in's name. Errors of stilb_scene_open. [main-thread] */
stilb_result scene_import_within(const char *path, const scene_import_limits *limits, stilb_scene **scene);

stilb_result scene_import(const char *path, stilb_scene **scene);

#endif
