#include "profiler/write/prof_file.h"

#include <assert.h>
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#define FILE_LINKS_MAX 40 /* the most symbolic links to follow: the kernel's limit */

/* The path of the folder that contains path, in a new string; NULL: no memory. */
static char *file_folder(const char *path)
{
	const char *slash = strrchr(path, '/');
	if (!slash)
		return strdup(".");
	return slash == path ? strdup("/") : strndup(path, (size_t)(slash - path));
}

/* The path that a link at path with this content refers to, in a new string; NULL: no memory. Frees path. */
static char *file_link_target(char *path, const char *content)
{
	char *next = NULL, *folder = NULL;
	if (content[0] == '/')
		next = strdup(content);
	else if (!(folder = file_folder(path)) || asprintf(&next, "%s/%s", folder, content) < 0)
		next = NULL;
	free(folder);
	free(path);
	return next;
}

/* Follows links to the path of the file itself, which need not exist. NULL: errno says why. */
static char *file_resolve(const char *path)
{
	char *current = strdup(path);
	for (int links = 0; current && links < FILE_LINKS_MAX; links++) {
		char content[PATH_MAX];
		ssize_t length = readlink(current, content, sizeof content - 1);
		if (length < 0)
			return current; /* not a link, or not there */
		content[length] = 0;
		current = file_link_target(current, content);
	}
	errno = current ? ELOOP : ENOMEM;
	free(current);
	return NULL;
}

static bool file_is_stdout(const char *path)
{
	return strcmp(path, "-") == 0 || strcmp(path, "/dev/stdout") == 0;
}

/* Returns 0 if a new file can be created in the folder of path, or a negative errno. */
static int file_check_folder(const char *path)
{
	char *target = file_resolve(path);
	char *folder = target ? file_folder(target) : NULL;
	struct stat info;
	int error = 0;
	if (!folder || stat(folder, &info) != 0 || (S_ISDIR(info.st_mode) && access(folder, W_OK | X_OK) != 0))
		error = -errno;
	else if (!S_ISDIR(info.st_mode))
		error = -ENOTDIR;
	free(folder);
	free(target);
	return error;
}

/* Returns 1: to be written directly (stdout, a device, a pipe); 0: under a temporary name; or a negative errno. */
static int file_classify(const char *path)
{
	assert(path);
	struct stat info;
	if (path[0] == 0)
		return -ENOENT;
	if (file_is_stdout(path))
		return 1;
	if (path[strlen(path) - 1] == '/')
		return -EISDIR;
	if (stat(path, &info) != 0)
		return errno == ENOENT ? file_check_folder(path) : -errno;
	if (S_ISDIR(info.st_mode))
		return -EISDIR;
	if (access(path, W_OK) != 0)
		return -errno;
	return S_ISREG(info.st_mode) ? file_check_folder(path) : 1;
}

int prof_file_check(const char *path)
{
	int kind = file_classify(path);
	return kind < 0 ? kind : 0;
}

static void file_free(prof_file *file)
{
	if (file->folder >= 0)
		close(file->folder);
	free(file->temporary);
	free(file->target);
	*file = (prof_file){.descriptor = -1, .folder = -1};
}

/* ---- temporary files ---------------------------------------------------------------------------------------------
 *
 * A file is written as "<name>.<pid>.tmp" in its own folder, or "<name>.<pid>-<number>.tmp" if that name is taken. The
 * process that writes it holds its lock (flock). The kernel releases the locks of a process that dies, so a temporary
 * file without a lock is abandoned: the next file of that name removes it.
 */

#define FILE_SUFFIX_MAX 48 /* bytes of ".<pid>-<number>.tmp", with room to spare */
#define FILE_TRIES 1000u   /* names of a temporary file to try before giving up */

/* How many bytes of a file's name its temporary files begin with: cut, so that the suffix fits into NAME_MAX. */
static size_t file_stem(const char *name)
{
	size_t length = strlen(name);
	return length < NAME_MAX - FILE_SUFFIX_MAX ? length : NAME_MAX - FILE_SUFFIX_MAX;
}

static const char *file_name(const char *path)
{
	const char *slash = strrchr(path, '/');
	return slash ? slash + 1 : path;
}

/* The end of the digits at text; NULL: there are none. */
static const char *file_digits(const char *text)
{
	size_t count = strspn(text, "0123456789");
	return count > 0 ? text + count : NULL;
}

/* True if name is that of a temporary file of stem[0..length), of any process. */
static bool file_is_temporary(const char *name, const char *stem, size_t length)
{
	if (strncmp(name, stem, length) != 0 || name[length] != '.')
		return false;
	const char *end = file_digits(name + length + 1);
	if (end && *end == '-')
		end = file_digits(end + 1);
	return end && strcmp(end, ".tmp") == 0;
}

static void file_remove_abandoned(int folder, const char *name)
{
	struct stat info;
	int file = openat(folder, name, O_WRONLY | O_NONBLOCK | O_NOFOLLOW | O_CLOEXEC);
	if (file < 0)
		return;
	if (fstat(file, &info) == 0 && S_ISREG(info.st_mode) && flock(file, LOCK_EX | LOCK_NB) == 0)
		unlinkat(folder, name, 0);
	close(file);
}

/* Removes the temporary files that killed processes have left for this target (file->target, the path to write). */
static void file_clean(const prof_file *file)
{
	assert(file->target);
	const char *stem = file_name(file->target);
	size_t length = file_stem(stem);
	int again = file->folder >= 0 ? openat(file->folder, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1;
	DIR *entries = again >= 0 ? fdopendir(again) : NULL;
	if (!entries) {
		if (again >= 0)
			close(again);
		return;
	}
	for (const struct dirent *entry; (entry = readdir(entries));)
		if (file_is_temporary(entry->d_name, stem, length))
			file_remove_abandoned(file->folder, entry->d_name);
	closedir(entries);
}

/* Creates a file and takes its lock. Between these two steps another process may have removed it as abandoned: -EEXIST,
 * and the next name is tried. Returns a descriptor or a negative errno. */
static int file_create_locked(const char *name)
{
	struct stat info;
	int file = open(name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
	if (file < 0)
		return -errno;
	/* If flock fails, locks do not work on this file system; then no process removes the file as abandoned either. */
	if (flock(file, LOCK_EX) != 0 || fstat(file, &info) != 0 || info.st_nlink > 0)
		return file;
	close(file);
	return -EEXIST;
}

/* Creates a temporary file in the target's folder under a free name. 0 or a negative errno. */
static int file_create_temporary(prof_file *file)
{
	assert(file->target && !file->temporary && file->descriptor < 0);
	const char *name = file_name(file->target);
	int stem = (int)(name - file->target) + (int)file_stem(name);
	int error = -EEXIST;
	for (uint32_t number = 0; error == -EEXIST && number < FILE_TRIES; number++) {
		char suffix[FILE_SUFFIX_MAX] = "";
		if (number > 0)
			snprintf(suffix, sizeof suffix, "-%u", number);
		free(file->temporary);
		if (asprintf(&file->temporary, "%.*s.%d%s.tmp", stem, file->target, (int)getpid(), suffix) < 0) {
			file->temporary = NULL;
			return -ENOMEM;
		}
		file->descriptor = file_create_locked(file->temporary);
		error = file->descriptor < 0 ? file->descriptor : 0;
	}
	return error;
}

static int file_open_temporary(prof_file *file, const char *path)
{
	struct stat old;
	file->target = file_resolve(path);
	if (!file->target)
		return -errno;
	char *folder = file_folder(file->target);
	if (!folder)
		return -ENOMEM;
	file->folder = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC); /* may fail: some folders can only be written */
	free(folder);
	file_clean(file);
	int error = file_create_temporary(file);
	if (error == 0 && stat(file->target, &old) == 0)
		fchmod(file->descriptor, old.st_mode & 07777); /* the new file keeps the old one's mode */
	return error;
}

int prof_file_open(prof_file *file, const char *path, bool fresh)
{
	assert(file);
	*file = (prof_file){.descriptor = -1, .folder = -1, .fresh = fresh};
	int kind = file_classify(path);
	int error = kind < 0 ? kind : 0;
	if (kind == 1) {
		file->descriptor = file_is_stdout(path) ? fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 0)
		                                        : open(path, O_WRONLY | O_CLOEXEC | O_NOCTTY);
		error = file->descriptor < 0 ? -errno : 0;
	} else if (kind == 0) {
		error = file_open_temporary(file, path);
	}
	if (error != 0)
		file_free(file);
	return error;
}

int prof_file_write(void *user, const void *data, size_t size)
{
	prof_file *file = user;
	assert(file->descriptor >= 0 && (data || size == 0) && "between open and commit");
	const char *from = data;
	while (size > 0 && file->error == 0) {
		ssize_t done = write(file->descriptor, from, size);
		if (done < 0 && errno != EINTR)
			file->error = -errno;
		if (done > 0) {
			from += done;
			size -= (size_t)done;
		}
	}
	return file->error;
}

/* Renames without replacing a file that has appeared meanwhile. Some file systems do not support that; there, link,
 * which fails if the name is taken, gives the file its second name. */
static int file_rename_fresh(const prof_file *file)
{
	if (renameat2(AT_FDCWD, file->temporary, AT_FDCWD, file->target, RENAME_NOREPLACE) == 0)
		return 0;
	if (errno != EINVAL && errno != ENOSYS)
		return -errno;
	if (link(file->temporary, file->target) != 0)
		return -errno;
	unlink(file->temporary);
	return 0;
}

/* Renames the file and syncs the folder: without that a power cut may bring back the old file. A sync that fails is not
 * an error, since the file is there. */
static int file_move(const prof_file *file)
{
	assert(file->temporary && file->descriptor >= 0 && "it is renamed while it has its lock");
	int error = file->fresh ? file_rename_fresh(file) : rename(file->temporary, file->target) != 0 ? -errno : 0;
	if (error == 0 && file->folder >= 0)
		fsync(file->folder);
	return error;
}

int prof_file_commit(prof_file *file, int error)
{
	assert(file->descriptor >= 0 && error <= 0 && file->error <= 0 && "committed once");
	if (error == 0)
		error = file->error;
	if (error == 0 && file->temporary && fsync(file->descriptor) != 0)
		error = -errno;
	if (error == 0 && file->temporary)
		error = file_move(file); /* before it is closed, which gives up the lock */
	if (error != 0 && file->temporary)
		unlink(file->temporary);
	if (close(file->descriptor) != 0 && error == 0)
		error = -errno;
	file_free(file);
	return error;
}
