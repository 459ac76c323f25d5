/* Finds the files that Stilb starts or loads by itself. */
#include "base/base_file.h"

#include <dlfcn.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* The path of the installed base.h that the program was compiled with; NULL: it was compiled without one. */
extern const char stilb_header_path[] __attribute__((weak));

/* Cuts a path after the folder that contains it, without the slash. False: it has no folder that would be the same from
 * every working directory. */
static bool part_folder(char *path)
{
	char *slash = path[0] == '/' ? strrchr(path, '/') : NULL;
	if (slash)
		*slash = '\0';
	return slash;
}

/* True if folder/below/name exists; path is then that. folder and path may not overlap. */
static bool part_is_in(const char *folder, const char *below, const char *name, char path[STILB_FILE_PART_MAX])
{
	int length = snprintf(path, STILB_FILE_PART_MAX, "%s%s/%s", folder, below, name);
	return length < STILB_FILE_PART_MAX && access(path, F_OK) == 0;
}

static bool part_program_folder(char folder[STILB_FILE_PART_MAX])
{
	ssize_t length = readlink("/proc/self/exe", folder, STILB_FILE_PART_MAX - 1);
	folder[length > 0 ? length : 0] = '\0';
	return part_folder(folder);
}

/* The folder of the shared library, or of the program, that this code was linked into. */
static bool part_library_folder(char folder[STILB_FILE_PART_MAX])
{
	Dl_info info;
	if (dladdr((void *)part_library_folder, &info) == 0 || !info.dli_fname)
		return false;
	snprintf(folder, STILB_FILE_PART_MAX, "%s", info.dli_fname);
	return part_folder(folder);
}

static bool part_header_folder(char folder[STILB_FILE_PART_MAX])
{
	if (!stilb_header_path)
		return false;
	snprintf(folder, STILB_FILE_PART_MAX, "%s", stilb_header_path);
	return part_folder(folder);
}

bool stilb_file_find_part(const char *name, char path[STILB_FILE_PART_MAX])
{
	STILB_ASSERT(name && name[0] && !strchr(name, '/') && path);
	char folder[STILB_FILE_PART_MAX];
	if (part_program_folder(folder) && (part_is_in(folder, "", name, path) || part_is_in(folder, "/..", name, path) ||
	                                    part_is_in(folder, "/../lib/stilb", name, path)))
		return true;
	if (part_library_folder(folder) &&
	    (part_is_in(folder, "/stilb", name, path) || part_is_in(folder, "/../stilb", name, path)))
		return true;
	return part_header_folder(folder) && part_is_in(folder, "/../../lib/stilb", name, path);
}
