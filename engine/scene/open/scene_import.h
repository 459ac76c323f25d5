/*
 * scene_import: files of unknown origin, read by a process of their own, the program stilb-scene-import
 * (engine/scene/importer): scenes through Assimp, pictures through libpng, OpenEXR and OpenImageIO. These libraries may
 * crash on files that were crafted for it, and grow without bound or never return on others. In that process a crash is
 * an error for its caller, memory and time are bounded, and it can open no file and start no program (docs/import.md
 * describes the protection): Stilb opens the files that a scene names (scene_files.h) and passes their descriptors.
 * Stilb's own programs start without loading these libraries.
 *
 * Life cycle.  scene_importer_start -> scene_importer_scene, scene_importer_picture, any number, in any order ->
 *              scene_importer_stop. A process that crashed on a file is started again for the next request.
 * Threads.     [one-writer] per importer. The process dies with the thread that started it.
 */
#ifndef STILB_SCENE_IMPORT_H
#define STILB_SCENE_IMPORT_H

#include "scene/scene.h"

#define SCENE_IMPORTER "stilb-scene-import"

typedef struct scene_import_limits {
	uint64_t bytes;     /* > 0: of memory, and of the answer to one request */
	double seconds;     /* > 0: for one request */
	bool allow_outside; /* scenes may name files outside of their folder and its parent */
	bool quiet;         /* what the process warns of is not logged */
	/* Asked while waiting, every 50 ms at least; true: the request fails at once. NULL: never. */
	bool (*give_up)(void *user);
	void (*opened)(void *user, const char *path); /* as stilb_scene_open_options.opened */
	void (*progress)(void *user, float done);     /* as stilb_scene_open_options.progress */
	void *user;
	uint64_t *most_bytes; /* out, of scenes: as stilb_scene_open_options.import_bytes; NULL: nobody asks */
} scene_import_limits;

/* The limits that stilb_scene_open describes. */
scene_import_limits scene_import_limits_default(void);

typedef struct scene_importer scene_importer;

/* STILB_ERROR_FILE: the program cannot be started, or is of another build; STILB_ERROR_MEMORY. The message names no
 * scene. *importer is NULL then. */
stilb_result scene_importer_start(const scene_import_limits *limits, scene_importer **importer);

/* Ends the process. Accepts NULL. */
void scene_importer_stop(scene_importer *importer);

/* Reads the scene in the file at path, which is not taken for a built-in's name. Errors of stilb_scene_open. */
stilb_result scene_importer_scene(scene_importer *importer, const char *path, stilb_scene **scene);

/* Reads the picture in the file at path: with the precision and the channels of the file or, if light is set, as three
 * channels of linear floats, finite and >= 0. Errors of stilb_scene_set_environment; image is {0} then. */
stilb_result scene_importer_picture(scene_importer *importer, const char *path, bool light, stilb_image *image);

/* The protections of the process: flags of scene_protection (scene_stream.h). */
uint32_t scene_importer_protection(const scene_importer *importer);

/* Reads one scene by a process that is started for it. Errors of stilb_scene_open. */
stilb_result scene_import_within(const char *path, const scene_import_limits *limits, stilb_scene **scene);

#endif
