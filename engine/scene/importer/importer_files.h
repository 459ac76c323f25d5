/* importer_files: the files of a request. The process opens none itself: it asks Stilb, which decides
 * (scene_files.h). */
#ifndef STILB_SCENE_IMPORTER_FILES_H
#define STILB_SCENE_IMPORTER_FILES_H

#include "scene/open/scene_stream.h"

#include <assimp/cfileio.h>

/* A file in memory, read only. */
typedef struct importer_bytes {
	unsigned char *data;
	size_t size;
} importer_bytes;

/* The connection to Stilb. */
extern scene_stream importer_stream;

/* Begins a request: path is given's name, which may be opened any number of times. Closes given. */
void importer_files_begin(const char *path, int given);

/* Ends it. */
void importer_files_end(void);

/* Asks for the file that the scene calls name. A descriptor, or -1 with the reason in why. quiet: the caller tells the
 * reason itself. */
int importer_files_ask(const char *name, bool quiet, char why[static 256]);

/* The whole file behind a descriptor, which is closed; false: it cannot be read. */
bool importer_bytes_read(int file, importer_bytes *bytes);
void importer_bytes_free(importer_bytes *bytes);

/* For Assimp: what opens its files. */
extern struct aiFileIO importer_file_io;

#endif
