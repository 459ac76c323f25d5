#include "live_picture.h"

#include "base/base_file.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

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

char *live_picture_name(const char *path, const char *last)
{
	STILB_ASSERT(path && path[0]);
	struct stat info;
	for (uint32_t n = 1;; n++) {
		char *name = picture_numbered(path, n);
		if (!name || (lstat(name, &info) != 0 && !(last && stilb_file_same(name, last))))
			return name;
		free(name);
	}
}
