/* The lights as a scene's file has them. For this folder and scene.c. */
#ifndef SCENE_LIGHTS_FILE_H
#define SCENE_LIGHTS_FILE_H

#include "scene/scene.h"

#include <stdlib.h>
#include <sys/stat.h>

struct stilb_scene_lights_file {
	char *path;                /* of SCENE.lights.json */
	stilb_scene_light *lights; /* [count] before that was read */
	stilb_scene_mount *mounts; /* [count]; NULL: no light hangs on a node */
	uint32_t count;
	struct stat known; /* of the file that was read or written last; 0: none was */
};

/* Keeps the lights that the scene has now, and reads the file beside `path`, if there is one. quiet: without a line
 * that says so; opened: told of that file (stilb_scene_open_options), or NULL. STILB_ERROR_FILE: it is damaged, or of
 * another scene; STILB_ERROR_MEMORY. */
stilb_result scene_lights_open(stilb_scene *scene, const char *path, bool quiet,
                               void (*opened)(void *user, const char *path), void *user);

/* Accepts NULL. */
static inline void scene_lights_close(struct stilb_scene_lights_file *file)
{
	if (!file)
		return;
	free(file->path);
	free(file->lights);
	free(file->mounts);
	free(file);
}

#endif
