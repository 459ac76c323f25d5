/*
 * base_file: output files that are whole or not there, and input files that can be read without waiting.
 *
 * A regular or new file is written beside its place under a temporary name, "<file>.<process>.tmp", synced and renamed,
 * links followed, and its folder is synced: a reader sees the old file or the new one, and a full disk leaves the old
 * one alone. A temporary file that a killed process left is removed when the same file is written again. A device, a
 * pipe and stdout ("-", "/dev/stdout") are written directly.
 *
 * Life cycle.  stilb_file_check refuses a path before the work starts. stilb_file_open -> stilb_file_write, any number
 *              -> stilb_file_commit, or stilb_file_finish to drop what was written. stilb_file_save does it all.
 * Errors.      STILB_ERROR_ARGUMENT for a path that is refused before the work, STILB_ERROR_FILE afterwards; every
 *              message names the path as given.
 * Threads.     [one-writer] per stilb_file; otherwise [any-thread]. Two threads or processes may write one path at the
 *              same time: the last commit wins, and the file is one of the two.
 * Example.
 *
 *   stilb_file file;
 *   stilb_result result = stilb_file_open(&file, path);
 *   if (result == STILB_OK) {
 *       stilb_file_write(&file, rows, size);   // commit reports its error
 *       result = stilb_file_commit(&file);
 *   }
 */
#ifndef STILB_BASE_FILE_H
#define STILB_BASE_FILE_H

#include "base/base.h"

#include <stdio.h>

typedef struct stilb_file {
	FILE *stream;    /* NULL: closed */
	char *path;      /* as given */
	char *target;    /* path with links resolved, the place of the bytes; NULL when written directly */
	char *temporary; /* the name written to until commit; NULL when written directly */
	bool unsynced;   /* set by who opened it: commit does not wait for the disk, and a power cut may leave anything */
} stilb_file;

/* STILB_ERROR_ARGUMENT when path cannot become a file here: empty, a directory, a missing folder, no permission.
 * Creates nothing. [any-thread] */
stilb_result stilb_file_check(const char *path);

/* True for "-" and "/dev/stdout". [any-thread] */
bool stilb_file_is_stdout(const char *path);

/* True if one of these two outputs would replace the other: both are stdout, or the same file by any of its names, also
 * if it does not exist yet. False for other devices and pipes, which take any number of writers. [any-thread] */
bool stilb_file_same(const char *a, const char *b);

/* Removes the temporary files for path that killed processes left beside it; those that a process is writing stay.
 * stilb_file_open does it as well, so this is for a program that may end without writing path. [any-thread] */
void stilb_file_clean(const char *path);

/* Opens path for writing. STILB_ERROR_FILE; then file is {0} and needs no finish. [one-writer] */
stilb_result stilb_file_open(stilb_file *file, const char *path);

/* Appends size bytes, buffered as by fwrite; data may be NULL if size is 0. Returns 0 or a negative errno, and commit
 * fails then, too. [one-writer] */
int stilb_file_write(stilb_file *file, const void *data, size_t size);

/* Flushes, syncs, renames into place, syncs the folder, and finishes. STILB_ERROR_FILE for any error so far, a full
 * disk included; then the old file is still there and nothing new is. [one-writer] */
stilb_result stilb_file_commit(stilb_file *file);

/* Drops the bytes written, closes, and leaves {0}. Accepts {0}, and does nothing after commit. [one-writer] */
void stilb_file_finish(stilb_file *file);

/* stilb_file_open, write and commit. data may be NULL if size is 0. STILB_ERROR_FILE. [any-thread] */
stilb_result stilb_file_save(const char *path, const void *data, size_t size);

/* Opens a regular file for reading from its start; the caller closes it with fclose. Never waits: STILB_ERROR_FILE for
 * a pipe, a device, a folder, and for a file that cannot be opened; *stream is NULL then. [any-thread] */
stilb_result stilb_file_read_open(const char *path, FILE **stream);

/* Finds one of the files that Stilb starts or loads by itself, such as stilb-scene-import, and writes its path. Looks
 * beside the running program, in the folder above it (tests in a build), in ../lib/stilb from it (the program stilb,
 * installed), in stilb/ and ../stilb/ beside the shared library that holds this function, and in the installation whose
 * headers the program was compiled with (base.h). False: it is in none of them. [any-thread] */
#define STILB_FILE_PART_MAX 4352 /* bytes of a path: PATH_MAX, and room for a folder and a name */
bool stilb_file_find_part(const char *name, char path[STILB_FILE_PART_MAX]);

/* Where stilb_file_find_part has looked, for messages. */
#define STILB_FILE_PART_PLACES "neither beside the program, nor in ../lib/stilb, nor in Stilb's installation"

#endif
