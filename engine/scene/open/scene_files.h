/*
 * scene_files: opens files for the import process, which cannot open any itself (scene_import.h). A scene names
 * buffers, materials and textures by paths; these are the ones that are opened:
 *
 * - what lies below the scene's folder, and below its parent where the name says `../`;
 * - through no symbolic link that leads out of the folder it was looked for in;
 * - regular files only, and only for reading.
 *
 * Many scenes name files of the disk that they were made on. So a name that leads nowhere, or outside, is looked for by
 * its last part in the scene's folder. Capitals do not count where there is no file of exactly that name.
 *
 * Life cycle.  scene_files_init -> scene_files_open, any number -> scene_files_finish. One thread at a time.
 */
#ifndef STILB_SCENE_FILES_H
#define STILB_SCENE_FILES_H

#include "scene/scene.h"

#include <limits.h>

typedef struct scene_files {
	int folder, parent;    /* descriptors; parent is -1 until it is asked for */
	char prefix[PATH_MAX]; /* the folder as the scene's path says it, with a slash at its end; "" is this folder */
	bool allow_outside;    /* any file that the user may read */
} scene_files;

/* scene: the path of the scene's file, which exists. STILB_ERROR_FILE: its folder cannot be opened. */
stilb_result scene_files_init(scene_files *files, const char *scene, bool allow_outside);

/* A descriptor of the file that the scene calls name, or -1 with the reason, without a name, in why: "there is no such
 * file", ... */
int scene_files_open(scene_files *files, const char *name, char why[static 256]);

/* Was the reason that the file lies outside? */
bool scene_files_outside(const char *why);

void scene_files_finish(scene_files *files);

#endif
