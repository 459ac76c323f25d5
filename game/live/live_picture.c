#include "live_picture.h"

#include "base/base_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Where the extension of a file's name begins, or its end. */
static const char *picture_extension(const char *path)
{
	const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path, *dot = strrchr(name, '.');
	return dot && dot != name ? dot : name + strlen(name);
}

/* Returns the name of a series' picture; NULL: out of memory. */
static char *picture_of_series(const char *path, uint32_t number)
{
	const char *dot = picture_extension(path);
	char *numbered;
	return asprintf(&numbered, "%.*s-%03u%s", (int)(dot - path), path, number, dot) < 0 ? NULL : numbered;
}

/* Returns the name of picture number n, counted from 1; NULL: out of memory. */
static char *picture_numbered(const char *path, uint32_t n)
{
	const char *dot = picture_extension(path);
	char *numbered = NULL;
	int written =
		n == 1 ? asprintf(&numbered, "%s", path) : asprintf(&numbered, "%.*s-%u%s", (int)(dot - path), path, n, dot);
	return written < 0 ? NULL : numbered;
}

/* Creates an empty file. Returns 0 or errno: EEXIST if there is a file of this name. */
static int picture_create(const char *name)
{
	int file = open(name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
	if (file < 0)
		return errno;
	close(file);
	return 0;
}

stilb_result live_picture_reserve(const char *path, const char *last, char **name)
{
	STILB_ASSERT(path && path[0] && name);
	for (uint32_t n = 1;; n++) {
		*name = picture_numbered(path, n);
		if (!*name)
			return stilb_fail(STILB_ERROR_MEMORY, "no memory for a picture's name");
		bool kept = last && stilb_file_same(*name, last);
		int error = kept ? EEXIST : picture_create(*name);
		if (error == 0)
			return STILB_OK;
		if (error != EEXIST)
			stilb_fail(STILB_ERROR_FILE, "cannot create '%s': %s", *name, strerror(error));
		free(*name);
		*name = NULL;
		if (error != EEXIST)
			return STILB_ERROR_FILE;
	}
}

/* ---- series ------------------------------------------------------------------------------------------------------ */

/* Sets *taken if there is a file of any of the series' names. Returns false if there is no memory. */
static bool picture_series_taken(const char *series, uint32_t count, bool *taken)
{
	struct stat info;
	*taken = false;
	for (uint32_t n = 1; n <= count && !*taken; n++) {
		char *name = picture_of_series(series, n);
		if (!name)
			return false;
		*taken = lstat(name, &info) == 0; /* a link too, whatever it leads to */
		free(name);
	}
	return true;
}

stilb_result live_picture_series(const char *path, uint32_t count, char **series)
{
	STILB_ASSERT(path && path[0] && count > 0 && series);
	for (uint32_t n = 1;; n++) {
		bool taken;
		*series = picture_numbered(path, n);
		if (!*series || !picture_series_taken(*series, count, &taken)) {
			free(*series);
			*series = NULL;
			return stilb_fail(STILB_ERROR_MEMORY, "no memory for a picture's name");
		}
		if (!taken)
			return STILB_OK;
		free(*series);
	}
}

stilb_result live_picture_reserve_numbered(const char *series, uint32_t number, char **name)
{
	STILB_ASSERT(series && series[0] && number > 0 && name);
	*name = picture_of_series(series, number);
	if (!*name)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a picture's name");
	int error = picture_create(*name);
	if (error == 0)
		return STILB_OK;
	stilb_fail(STILB_ERROR_FILE, "cannot create '%s': %s", *name, strerror(error));
	free(*name);
	*name = NULL;
	return STILB_ERROR_FILE;
}
