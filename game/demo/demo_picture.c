#include "demo_picture.h"

#include "base/base_file.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* Returns the name of picture number n, counted from 1; NULL: out of memory. */
static char *picture_numbered(const char *path, uint32_t n)
{
	const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path, *dot = strrchr(name, '.');
	char *numbered = NULL;
	if (!dot || dot == name)
		dot = name + strlen(name);
	int written =
		n == 1 ? asprintf(&numbered, "%s", path) : asprintf(&numbered, "%.*s-%u%s", (int)(dot - path), path, n, dot);
	return written < 0 ? NULL : numbered;
}

char *demo_picture_name(const char *path, const char *last)
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
