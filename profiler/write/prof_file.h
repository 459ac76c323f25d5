/* Output files that are whole or not there: written beside their place, synced and renamed. */
#ifndef STILB_PROF_FILE_H
#define STILB_PROF_FILE_H

#include <stdbool.h>
#include <stddef.h>

typedef struct prof_file {
	int descriptor;  /* -1: closed */
	int folder;      /* the target's; -1: written directly, or the folder cannot be read */
	bool fresh;      /* no file is replaced */
	int error;       /* the first that happened, a negative errno */
	char *target;    /* where the bytes must end, links followed; NULL when written directly */
	char *temporary; /* the name written to until commit; NULL when written directly */
} prof_file;

/* 0 when path can become a file now, or a negative errno. */
int prof_file_check(const char *path);

/* 0 or a negative errno; then there is nothing to finish. "-" is stdout. Temporary files of that path which a process
 * that was killed has left behind are removed. */
int prof_file_open(prof_file *file, const char *path, bool fresh);

/* All of it; returns 0 or a negative errno, which commit returns too. */
int prof_file_write(void *file, const void *data, size_t size);

/* Syncs, renames, closes. After an error, error or an earlier one, the old file is still there and nothing new is.
 * -EEXIST: it was to be fresh, and there is a file. */
int prof_file_commit(prof_file *file, int error);

#endif
