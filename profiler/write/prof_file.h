/* Output files that are either complete or not there: each is written under a temporary name, synced and renamed. */
#ifndef STILB_PROF_FILE_H
#define STILB_PROF_FILE_H

#include <stdbool.h>
#include <stddef.h>

typedef struct prof_file {
	int descriptor;  /* -1: closed */
	int folder;      /* descriptor of the target's folder; -1: written directly, or the folder cannot be read */
	bool fresh;      /* never replace an existing file */
	int error;       /* the first error of a write, a negative errno */
	char *target;    /* path of the file, links followed; NULL: written directly */
	char *temporary; /* path until commit; NULL: written directly */
} prof_file;

/* Returns 0 if a file can be written at path now, or a negative errno. Creates nothing. */
int prof_file_check(const char *path);

/* Begins a file; "-" is stdout. Temporary files of path that killed processes have left are removed. Returns 0, and
 * then prof_file_commit must follow, or a negative errno. */
int prof_file_open(prof_file *file, const char *path, bool fresh);

/* Writes all size bytes; file is a prof_file. Returns 0 or a negative errno, which prof_file_commit then returns
 * too. */
int prof_file_write(void *file, const void *data, size_t size);

/* Syncs, renames and closes. error is 0 or an error of the caller (negative); after that or any earlier error the old
 * file is unchanged and there is no new one. Returns 0 or the error; -EEXIST: fresh, and there is a file. Once per file
 * (asserted). */
int prof_file_commit(prof_file *file, int error);

#endif
