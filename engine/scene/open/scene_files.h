/*
 * scene_files: opens files for the import process, which cannot open any itself (scene_import.h). A scene names
 * buffers, materials and textures by paths. A file is opened only if
 *
 * - it lies below the scene's folder, or below that folder's parent if the name says `../`;
 * - no symbolic link on the way leads out of that folder;
 * - it is a regular file. It is opened for reading.
 *
 * Many scenes name files by their paths on the author's disk. So if a path names no file, or one outside, the last name
 * of the path is looked for in the scene's folder. If no file has exactly the name, upper and lower case are the same.
 *
 * Life cycle.  scene_files_init -> scene_files_open, any number -> scene_files_finish.
 * Threads.     [one-writer] per scene_files.
 */
#ifndef STILB_SCENE_FILES_H
#define STILB_SCENE_FILES_H

#include "scene/scene.h"

#include <limits.h>

typedef struct scene_files {
	int folder, parent;    /* descriptors; parent is -1 until a name needs it */
	char prefix[PATH_MAX]; /* the folder's part of the scene's path, with a slash at its end; "": the working folder */
	bool allow_outside;    /* open any file that the user may read */
} scene_files;

/* scene: the path of the scene's file, which exists. STILB_ERROR_FILE: its folder cannot be opened; then there is
 * nothing to finish. */
stilb_result scene_files_init(scene_files *files, const char *scene, bool allow_outside);

/* Opens the file that the scene calls name, any string. Returns a descriptor, or -1 with the reason in why: "there is
 * no such file", ... */
int scene_files_open(scene_files *files, const char *name, char why[static 256]);

/* True if why, of scene_files_open, says that the file lies outside. */
bool scene_files_outside(const char *why);

void scene_files_finish(scene_files *files);

#endif
