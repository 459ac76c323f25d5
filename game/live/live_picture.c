#include "live_picture.h"

#include "base/base_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Where the extension of a file's name begins, or its end. */
static const char *picture_extension(const char *path)
{
	const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path, *dot = strrchr(name, '.');
	return dot && dot != name ? dot : name + strlen(name);
}

char *live_picture_numbered(const char *path, uint32_t number)
{
	STILB_ASSERT(path && path[0]);
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

stilb_result live_picture_reserve(const char *path, const char *last, char **name)
{
	STILB_ASSERT(path && path[0] && name);
	for (uint32_t n = 1;; n++) {
		*name = picture_numbered(path, n);
		if (!*name)
			return stilb_fail(STILB_ERROR_MEMORY, "no memory for a picture's name");
		bool kept = last && stilb_file_same(*name, last);
		int file = kept ? -1 : open(*name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
		int error = kept ? EEXIST : errno;
		if (file >= 0) {
			close(file);
			return STILB_OK;
		}
		if (error != EEXIST)
			stilb_fail(STILB_ERROR_FILE, "cannot create '%s': %s", *name, strerror(error));
		free(*name);
		*name = NULL;
		if (error != EEXIST)
			return STILB_ERROR_FILE;
	}
}
