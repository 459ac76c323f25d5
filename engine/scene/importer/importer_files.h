/*
 * importer_files: the files that are needed to serve a request of Stilb's to read a scene or a picture. The import
 * process can open none itself: it asks Stilb, which decides (scene_files.h).
 *
 * Life cycle.  importer_files_begin -> importer_files_ask and importer_file_io, any number -> importer_files_end.
 * Threads.     The process's main thread; importer_bytes_read and importer_bytes_free are [any-thread].
 */
#ifndef STILB_SCENE_IMPORTER_FILES_H
#define STILB_SCENE_IMPORTER_FILES_H

#include "scene/open/scene_stream.h"

#include <assimp/cfileio.h>

/* A file in memory. */
typedef struct importer_bytes {
	unsigned char *data;
	size_t size;
} importer_bytes;

/* The connection to Stilb. */
extern scene_stream importer_stream;

/* Begins a request. given: the descriptor of the file at path, or -1: none. importer_files_ask for path returns copies
 * of given. It is closed by importer_files_end. */
void importer_files_begin(const char *path, int given);

/* Ends the request, if there is one. */
void importer_files_end(void);

/* Asks Stilb for the file that the scene calls name. Returns a descriptor, or -1 with the reason in why. quiet: Stilb
 * does not log a refusal, because the caller warns of it. */
int importer_files_ask(const char *name, bool quiet, char why[static 256]);

/* Reads the whole file behind a descriptor, >= 0, and closes it. False: it cannot be read, or memory is out; bytes is
 * {0} then. */
bool importer_bytes_read(int file, importer_bytes *bytes);
void importer_bytes_free(importer_bytes *bytes);

/* The functions by which Assimp opens files. */
extern struct aiFileIO importer_file_io;

#endif
