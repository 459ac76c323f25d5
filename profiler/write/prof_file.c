#include "profiler/write/prof_file.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define FILE_LINKS_MAX 40 /* as the kernel follows */

/* The folder that path's last name lies in, in a new string; NULL: no memory. */
static char *file_folder(const char *path)
{
	const char *slash = strrchr(path, '/');
	if (slash == NULL)
		return strdup(".");
	return slash == path ? strdup("/") : strndup(path, (size_t)(slash - path));
}

/* What the link at path, with this content, names: relative to the link's folder. Frees path. */
static char *file_link_target(char *path, const char *content)
{
	char *next = NULL, *folder = NULL;
	if (content[0] == '/')
		next = strdup(content);
	else if ((folder = file_folder(path)) == NULL || asprintf(&next, "%s/%s", folder, content) < 0)
		next = NULL;
	free(folder);
	free(path);
	return next;
}

/* Follows links to where the bytes must end, also when nothing is there yet. NULL with errno. */
static char *file_resolve(const char *path)
{
	char *current = strdup(path);
	for (int links = 0; current != NULL && links < FILE_LINKS_MAX; links++) {
		char content[PATH_MAX];
		const ssize_t length = readlink(current, content, sizeof content - 1);
		if (length < 0)
			return current; /* not a link, or not there: this is the place */
		content[length] = 0;
		current = file_link_target(current, content);
	}
	errno = current != NULL ? ELOOP : ENOMEM;
	free(current);
	return NULL;
}

static bool file_is_stdout(const char *path)
{
	return strcmp(path, "-") == 0 || strcmp(path, "/dev/stdout") == 0;
}

/* The folder must take a new file. */
static int file_check_folder(const char *path)
{
	char *target = file_resolve(path);
	char *folder = target != NULL ? file_folder(target) : NULL;
	struct stat info;
	int error = 0;
	if (folder == NULL || stat(folder, &info) != 0)
		error = -errno;
	else if (!S_ISDIR(info.st_mode))
		error = -ENOTDIR;
	else if (access(folder, W_OK | X_OK) != 0)
		error = -errno;
	free(folder);
	free(target);
	return error;
}

/* 1: to be written directly (stdout, a device, a pipe); 0: beside its place; or a negative errno. */
static int file_classify(const char *path)
{
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
	const int kind = file_classify(path);
	return kind < 0 ? kind : 0;
}

static void file_free(prof_file *file)
{
	free(file->temporary);
	free(file->target);
	*file = (prof_file){.descriptor = -1};
}

/* Makes a file beside the target under a name that is free: one of a killed process may still be there, with this
 * process's number. The name is short, since the target's may be as long as a name can be. 0 or a negative errno. */
static int file_create_temporary(prof_file *file)
{
	static uint32_t serial;
	char *folder = file_folder(file->target);
	int error = folder != NULL ? -EEXIST : -ENOMEM;
	for (int tries = 0; error == -EEXIST && tries < 1000; tries++) {
		/* Relaxed: a counter, orders nothing. */
		const uint32_t number = __atomic_fetch_add(&serial, 1, __ATOMIC_RELAXED);
		free(file->temporary);
		if (asprintf(&file->temporary, "%s/stilb-prof-%d-%u.tmp", folder, (int)getpid(), number) < 0) {
			file->temporary = NULL;
			error = -ENOMEM;
			break;
		}
		file->descriptor = open(file->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
		error = file->descriptor < 0 ? -errno : 0;
	}
	free(folder);
	return error;
}

static int file_open_temporary(prof_file *file, const char *path)
{
	struct stat old;
	file->target = file_resolve(path);
	if (file->target == NULL)
		return -errno;
	const int error = file_create_temporary(file);
	if (error == 0 && stat(file->target, &old) == 0)
		fchmod(file->descriptor, old.st_mode & 07777); /* the new file keeps the old one's mode */
	return error;
}

int prof_file_open(prof_file *file, const char *path)
{
	*file = (prof_file){.descriptor = -1};
	const int kind = file_classify(path);
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
	const char *from = data;
	while (size > 0 && file->error == 0) {
		const ssize_t done = write(file->descriptor, from, size);
		if (done < 0 && errno != EINTR)
			file->error = -errno;
		if (done > 0) {
			from += done;
			size -= (size_t)done;
		}
	}
	return file->error;
}

int prof_file_commit(prof_file *file, int error)
{
	if (error == 0)
		error = file->error;
	if (error == 0 && file->temporary != NULL && fsync(file->descriptor) != 0)
		error = -errno;
	if (close(file->descriptor) != 0 && error == 0)
		error = -errno;
	if (error == 0 && file->temporary != NULL && rename(file->temporary, file->target) != 0)
		error = -errno;
	if (error != 0 && file->temporary != NULL)
		unlink(file->temporary);
	file_free(file);
	return error;
}
