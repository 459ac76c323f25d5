/*
 * engine_watch: shaders whose files change while frames are drawn are compiled by glslc and take the place of those
 * that the build made.
 *
 * How it works.  A thread knows the sources of all shaders that programs were made of (stilb_gpu_shader_source), and,
 *                by their #include lines, which files each of them is made of. inotify tells it of files that are
 *                written in their folders; once none was written for a moment, it starts glslc for each shader that is
 *                made of one, and hands all of them to the device at once (stilb_gpu_shaders_replace), or none if one
 *                is wrong. What could not be compiled is compiled again with the next change.
 * Sources.       A file below `folder`, or with its whole path, and behind it definitions as glslc takes them:
 *                "render/shaders/mesh.frag -DMESH_TEXTURE".
 * Threads.       [main-thread]; the thread is its own.
 */
#ifndef ENGINE_WATCH_H
#define ENGINE_WATCH_H

#include "engine.h"

typedef struct engine_watch engine_watch;

/* What has happened to shaders. */
typedef struct engine_watch_news {
	bool good;  /* they were replaced; false: they stay as they are */
	char *text; /* of lines: which, or what is wrong with them; the receiver frees it */
} engine_watch_news;

/* Starts to watch the shaders of a device, whose sources lie in `folder`, NULL: where the build found them. NULL: there
 * are none, or another error, which the message says. */
engine_watch *engine_watch_create(stilb_gpu *gpu, const char *folder);
/* Ends what is being compiled. NULL is accepted. Before the device is destroyed. */
void engine_watch_destroy(engine_watch *watch);
/* To be called in each frame: true if there are news. */
bool engine_watch_look(engine_watch *watch, engine_watch_news *news);

/* ---- engine_glslc.c ---------------------------------------------------------------------------------------------- */

#define ENGINE_GLSLC_MISSING "glslc, which compiles shaders, is not in PATH; install it (Debian's package glslc)"
/* True if PATH has a folder with it. */
bool engine_glslc_is_there(void);

/* A shader to be compiled. */
typedef struct engine_glslc {
	const char *file;        /* as glslc and its messages name it, below the folder, or its whole path */
	const char *definitions; /* "-DA -DB", or "" */
	uint32_t *words;         /* SPIR-V, which the caller frees; NULL: it failed */
	size_t bytes;
	char *message; /* what glslc said, or why it did not run, which the caller frees; NULL: no memory */
} engine_glslc;

/* Compiles shaders with the build's flags, several at once. folder: in which glslc runs. end: a descriptor that becomes
 * readable when all is to end at once. False: it did; then nothing is compiled. [any-thread] */
bool engine_glslc_run(engine_glslc *shaders, uint32_t count, const char *folder, int end);

/* ---- engine_includes.c ------------------------------------------------------------------------------------------- */

/* Absolute paths, without links, each once. */
typedef struct engine_files {
	char **paths; /* [count] */
	uint32_t count;
} engine_files;

/* Adds a file, unless it is there or does not exist, and what its #include lines name, whatever stands around them.
 * [any-thread] */
void engine_files_add(engine_files *files, const char *path);
bool engine_files_have(const engine_files *files, const char *path);
void engine_files_finish(engine_files *files);

#endif
