/*
 * view_watch: tells when a scene's file, or one that it names, has changed on disk, and names its neighbours in the
 * folder. [main-thread]
 *
 *   view_watch watch = VIEW_WATCH_NONE;
 *   view_watch_set(&watch, "model.gltf");
 *   switch (view_watch_look(&watch)) ...       once a frame
 *   view_watch_finish(&watch);
 */
#ifndef STILB_VIEW_WATCH_H
#define STILB_VIEW_WATCH_H

#include "base/base.h"

typedef struct view_watch_file {
	int folder; /* inotify's number of its folder */
	char *name; /* in the folder */
} view_watch_file;

typedef struct view_watch {
	int notify; /* an inotify descriptor for the files' folders; -1: nothing is watched */
	view_watch_file
		*files; /* [file_count] the first is the scene's, the others are those that it names or that stand beside it */
	uint32_t file_count;
	uint32_t which;  /* the file that has changed, if it is a single one, else 0; while due_ns is not 0 */
	uint64_t due_ns; /* time at which a change is reported, unless another one comes before; 0: there was none */
} view_watch;

#define VIEW_WATCH_NONE ((view_watch){.notify = -1})

typedef enum view_watch_news {
	VIEW_WATCH_NOTHING,
	VIEW_WATCH_CHANGED, /* the file is new, and nobody wrote to it for 0.3 s */
	VIEW_WATCH_GONE,    /* the file was deleted or renamed */
} view_watch_news;

/* Watches the folder of this file in place of the one before. A built-in scene's name, or a folder that cannot be
 * watched: nothing is. */
void view_watch_set(view_watch *watch, const char *path);

/* Watches a file that the scene's file names, too: when it is written, that has changed. */
void view_watch_add(view_watch *watch, const char *path);

/* What has happened since the last look. Does not wait. */
view_watch_news view_watch_look(view_watch *watch);

/* True if what the last look has told to be changed is a single file beside the scene's own, whose name ends so. */
bool view_watch_is(const view_watch *watch, const char *ending);

void view_watch_finish(view_watch *watch);

/* The scene file `step` places after the one at path in its folder, by name, around its end; files that no importer
 * reads, by their extension, are left out. The caller frees it. NULL: there is no other. */
char *view_watch_neighbour(const char *path, int step);

#endif
