/*
 * base_file: output files that are whole or not there, and input files that can be read without waiting.
 *
 * stilb_file_check refuses a path before the work starts; stilb_file_open, write and commit make the file. A regular or
 * new file is written beside its place under a temporary name, "<file>.<process>.tmp", synced and renamed, links
 * followed, and its folder synced: a reader sees the old file or the new one, and a full disk leaves the old one alone.
 * A temporary file that a killed process left is removed when the same file is written again. A device, a pipe and
 * stdout ("-", "/dev/stdout") are written directly.
 * Threads: one writer per stilb_file; otherwise [any-thread].
 */
#ifndef STILB_BASE_FILE_H
#define STILB_BASE_FILE_H

#include "base/base.h"

#include <stdio.h>

typedef struct stilb_file {
	FILE *stream;
	char *path;      /* as given; NULL: closed */
	char *target;    /* where the bytes must end (links resolved); NULL when written directly */
	char *temporary; /* the name written to until commit; NULL when written directly */
} stilb_file;

/* STILB_ERROR_ARGUMENT with a message when path cannot become a file here: empty, a directory, a missing folder, no
 * permission. Creates nothing. */
stilb_result stilb_file_check(const char *path);

/* "-" and "/dev/stdout". */
bool stilb_file_is_stdout(const char *path);

/* Would one of these two outputs replace the other? False for devices other than stdout. */
bool stilb_file_same(const char *a, const char *b);

/* Removes the temporary files that killed processes left beside path; those that are being written stay. For a file
 * that this run may not write; stilb_file_open does it as well. */
void stilb_file_clean(const char *path);

/* Opens for writing; on failure file is {0} and needs no finish. */
stilb_result stilb_file_open(stilb_file *file, const char *path);

/* fwrite with the error kept for commit. Returns 0, or a negative errno. */
int stilb_file_write(stilb_file *file, const void *data, size_t size);

/* Flushes, syncs, renames into place, syncs the folder, and finishes. Any error so far, a full disk too, comes out
 * here; then the old file is still there and nothing new is. */
stilb_result stilb_file_commit(stilb_file *file);

/* Drops what was written and closes. Safe on {0} and after commit. */
void stilb_file_finish(stilb_file *file);

/* Open, write, commit in one go. */
stilb_result stilb_file_save(const char *path, const void *data, size_t size);

/* Opens a regular file for reading from its start; fclose it. Never waits: STILB_ERROR_FILE for a pipe, a device, a
 * folder, and what cannot be opened; *stream is NULL then. */
stilb_result stilb_file_read_open(const char *path, FILE **stream);

#endif
