/*
 * scene_import: files of unknown origin, read by a process of their own, the program stilb-scene-import
 * (engine/scene/importer): scenes through Assimp, pictures through libpng, OpenEXR and OpenImageIO. These libraries
 * crash on files that somebody made for it, and keep growing or never return on others. There a crash is an error here,
 * memory and time are bounded, and the process can open no file and start no program (docs/import.md says what that
 * protects): Stilb opens what the scene names (scene_files.h) and hands the descriptors over. Stilb's own programs
 * start without loading these libraries.
 *
 * Life cycle.  scene_importer_start -> scene_importer_scene, scene_importer_picture, any number, in any order ->
 *              scene_importer_stop. A process that crashed on a file is started again for the next.
 * Threads.     One importer is used by one thread at a time.
 */
#ifndef STILB_SCENE_IMPORT_H
#define STILB_SCENE_IMPORT_H

#include "scene/scene.h"

#define SCENE_IMPORTER "stilb-scene-import"

typedef struct scene_import_limits {
	uint64_t bytes;     /* of memory, and of what it may send for one request */
	double seconds;     /* for one request */
	bool allow_outside; /* scenes may name files outside of their folder and its parent */
} scene_import_limits;

/* As stilb_scene_open says. */
scene_import_limits scene_import_limits_default(void);

typedef struct scene_importer scene_importer;

/* STILB_ERROR_FILE with a message without a name: the program cannot be started, or is not of this build.
 * STILB_ERROR_MEMORY. */
stilb_result scene_importer_start(const scene_import_limits *limits, scene_importer **importer);

/* Ends the process. Accepts NULL. */
void scene_importer_stop(scene_importer *importer);

/* The scene in the file at path, which is no built-in's name. Errors of stilb_scene_open. */
stilb_result scene_importer_scene(scene_importer *importer, const char *path, stilb_scene **scene);

/* The picture in the file at path: with the precision and the channels of the file, or as light: three channels of
 * linear floats, nothing below 0. Errors of stilb_scene_set_environment; image is {0} then. */
stilb_result scene_importer_picture(scene_importer *importer, const char *path, bool light, stilb_image *image);

/* What guards the process: flags of scene_protection (scene_stream.h). */
uint32_t scene_importer_protection(const scene_importer *importer);

/* One scene, by a process of its own. */
stilb_result scene_import_within(const char *path, const scene_import_limits *limits, stilb_scene **scene);

#endif
