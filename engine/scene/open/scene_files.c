#include "scene/open/scene_files.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/openat2.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#define FILES_READ (O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY)
#define FILES_FOLDER (O_RDONLY | O_CLOEXEC | O_DIRECTORY)

static const char files_missing[] = "there is no such file";
static const char files_lies_outside[] =
	"it lies outside of the scene's folder and its parent; --allow-outside reads it";
static const char files_link_outside[] = "a link leads out of the scene's folder; --allow-outside reads it";

/* ---- opening below a folder -------------------------------------------------------------------------------------- */

/* For kernels before 5.6, which have no openat2: opens the file and compares its path with the folder's. */
static int files_open_and_compare(int root, const char *name, int flags)
{
	char link[64], folder[PATH_MAX], reached[PATH_MAX];
	int file = openat(root, name, flags);
	if (file < 0)
		return -1;
	snprintf(link, sizeof link, "/proc/self/fd/%d", root);
	ssize_t length = readlink(link, folder, sizeof folder);
	snprintf(link, sizeof link, "/proc/self/fd/%d", file);
	ssize_t whole = readlink(link, reached, sizeof reached);
	bool top = length == 1 && folder[0] == '/';
	if (length > 0 && whole >= length && whole < PATH_MAX && memcmp(folder, reached, (size_t)length) == 0 &&
	    (top || whole == length || reached[length] == '/'))
		return file;
	close(file);
	errno = EXDEV;
	return -1;
}

/* Opens name, a relative path, below the folder root. -1 with errno, EXDEV if the path leads out of root. */
static int files_open_below(int root, const char *name, int flags)
{
	STILB_ASSERT(root >= 0 && name[0] != '/');
	struct open_how how = {.flags = (unsigned)flags, .resolve = RESOLVE_BENEATH | RESOLVE_NO_MAGICLINKS};
	long file = syscall(SYS_openat2, root, name, &how, sizeof how);
	if (file < 0 && (errno == ENOSYS || errno == EPERM))
		return files_open_and_compare(root, name, flags);
	return (int)file;
}

/* Returns file, a descriptor or -1 with errno, if it is a regular file; else closes it, sets *why and returns -1. */
static int files_keep_regular(int file, const char **why)
{
	struct stat info;
	if (file < 0) {
		*why = errno == EXDEV                        ? files_link_outside
		       : errno == ENOENT || errno == ENOTDIR ? files_missing
		       : errno == ELOOP                      ? "its links lead in a circle"
		                                             : strerror(errno);
		return -1;
	}
	if (fstat(file, &info) == 0 && S_ISREG(info.st_mode))
		return file;
	*why = S_ISDIR(info.st_mode) ? "it is a folder, not a file" : "it is not a regular file";
	close(file);
	return -1;
}

/* ---- upper and lower case ---------------------------------------------------------------------------------------- */

/* Replaces name by the name in root's folder `below` that differs in upper and lower case only. False: there is
 * none. */
static bool files_match_name(int root, const char *below, char *name)
{
	int folder = files_open_below(root, below[0] ? below : ".", FILES_FOLDER);
	DIR *list = folder >= 0 ? fdopendir(folder) : NULL;
	bool found = false;
	for (struct dirent *entry; list && !found && (entry = readdir(list));)
		if (strcasecmp(entry->d_name, name) == 0) {
			STILB_ASSERT(strlen(entry->d_name) == strlen(name));
			memcpy(name, entry->d_name, strlen(name));
			found = true;
		}
	if (list)
		closedir(list);
	else if (folder >= 0)
		close(folder);
	return found;
}

/* Replaces each part of the relative path name by the name that exists there, upper and lower case being the same
 * (files_match_name). False: no such name exists for one of the parts. */
static bool files_match_path(int root, char *name)
{
	char below[PATH_MAX] = "";
	size_t length = 0;
	for (char *part = name, *end; *part; part = end) {
		end = strchrnul(part, '/');
		char slash = *end;
		*end = '\0';
		bool found = files_match_name(root, below, part);
		length += (size_t)snprintf(below + length, sizeof below - length, "%s%s", length ? "/" : "", part);
		STILB_ASSERT(length < sizeof below);
		*end = slash;
		end += slash == '/';
		if (!found)
			return false;
	}
	return true;
}

/* ---- names ------------------------------------------------------------------------------------------------------- */

/* Removes "." and "a/.." from a relative path, in place, and any ".." that are then left at its front. Returns the
 * number of these. */
static unsigned files_simplify(char *name)
{
	unsigned up = 0;
	char *out = name;
	for (const char *part = name; *part;) {
		size_t length = strcspn(part, "/");
		const char *next = part + length + (part[length] == '/');
		if (length == 2 && part[0] == '.' && part[1] == '.') {
			up += out == name;
			while (out > name && *--out != '/') {
			}
		} else if (length > 0 && !(length == 1 && part[0] == '.')) {
			if (out > name)
				*out++ = '/';
			STILB_ASSERT(out <= part);
			memmove(out, part, length);
			out += length;
		}
		part = next;
	}
	*out = '\0';
	return up;
}

/* The folder `up` levels above the scene's; -1: more than one, or it cannot be opened. */
static int files_root(scene_files *files, unsigned up)
{
	STILB_ASSERT(files->folder >= 0 && "initialised");
	if (up == 0)
		return files->folder;
	if (up == 1 && files->parent < 0)
		files->parent = openat(files->folder, "..", FILES_FOLDER);
	return up == 1 ? files->parent : -1;
}

static int files_open_relative(scene_files *files, char *name, const char **why)
{
	char given[PATH_MAX];
	snprintf(given, sizeof given, "%s", name);
	unsigned up = files_simplify(name);
	int root = files_root(files, up);
	if (root < 0 && files->allow_outside)
		return files_keep_regular(openat(files->folder, given, FILES_READ), why);
	if (root < 0) {
		*why = files_lies_outside;
		return -1;
	}
	int file = files_keep_regular(files_open_below(root, name, FILES_READ), why);
	if (file < 0 && *why == files_link_outside && files->allow_outside)
		file = files_keep_regular(openat(root, name, FILES_READ), why);
	if (file < 0 && *why == files_missing && files_match_path(root, name))
		file = files_keep_regular(files_open_below(root, name, FILES_READ), why);
	return file;
}

static int files_open_absolute(const scene_files *files, const char *name, const char **why)
{
	if (files->allow_outside)
		return files_keep_regular(open(name, FILES_READ), why);
	*why = files_lies_outside;
	return -1;
}

/* ---- public ------------------------------------------------------------------------------------------------------ */

stilb_result scene_files_init(scene_files *files, const char *scene, bool allow_outside)
{
	STILB_ASSERT(files && scene);
	*files = (scene_files){.folder = -1, .parent = -1, .allow_outside = allow_outside};
	const char *slash = strrchr(scene, '/');
	size_t length = slash ? (size_t)(slash - scene) + 1 : 0;
	if (length < sizeof files->prefix) {
		memcpy(files->prefix, scene, length);
		files->folder = open(length ? files->prefix : ".", FILES_FOLDER);
	}
	if (files->folder >= 0)
		return STILB_OK;
	return stilb_fail(STILB_ERROR_FILE, "cannot read '%s': its folder cannot be opened: %s", scene, strerror(errno));
}

int scene_files_open(scene_files *files, const char *name, char why[static 256])
{
	STILB_ASSERT(files && name && why);
	char path[PATH_MAX];
	const char *reason = files_missing, *start = path;
	if (strlen(name) >= sizeof path || name[0] == '\0') {
		snprintf(why, 256, "%s", files_missing);
		return -1;
	}
	snprintf(path, sizeof path, "%s", name);
	for (char *c = path; *c; c++)
		if (*c == '\\')
			*c = '/';
	size_t prefix = strlen(files->prefix);
	if (prefix > 0 && strncmp(path, files->prefix, prefix) == 0)
		start += prefix;
	else if (strncmp(path, "//", 2) == 0) /* Blender's notation for the scene's folder */
		start += 2;
	char rest[PATH_MAX];
	snprintf(rest, sizeof rest, "%s", start);
	int file = start == path && path[0] == '/' ? files_open_absolute(files, rest, &reason)
	                                           : files_open_relative(files, rest, &reason);
	const char *last = strrchr(start, '/');
	if (file < 0 && last && last[1] && (reason == files_missing || reason == files_lies_outside)) {
		const char *other = files_missing;
		snprintf(rest, sizeof rest, "%s", last + 1);
		if (strcmp(rest, "..") != 0)
			file = files_open_relative(files, rest, &other);
		if (file < 0 && other != files_missing)
			reason = other;
	}
	snprintf(why, 256, "%s", file < 0 ? reason : "");
	return file;
}

bool scene_files_outside(const char *why)
{
	STILB_ASSERT(why);
	return strcmp(why, files_lies_outside) == 0 || strcmp(why, files_link_outside) == 0;
}

void scene_files_finish(scene_files *files)
{
	STILB_ASSERT(files);
	if (files->folder >= 0)
		close(files->folder);
	if (files->parent >= 0)
		close(files->parent);
	files->folder = files->parent = -1;
}
