#include "base/base_file.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* What a path leads to. */
typedef enum file_kind {
	FILE_KIND_REGULAR, /* a regular file, or nothing yet: written beside its place and renamed */
	FILE_KIND_DIRECT,  /* stdout, a device, a pipe: written as it is */
	FILE_KIND_REFUSED, /* the message says why */
} file_kind;

static file_kind file_refuse(const char *path, const char *why)
{
	stilb_fail(STILB_ERROR_ARGUMENT, "cannot write '%s': %s", path, why);
	return FILE_KIND_REFUSED;
}

/* The folder that path's last name lies in, in a new string. */
static char *file_folder(const char *path)
{
	const char *slash = strrchr(path, '/');
	if (!slash)
		return strdup(".");
	return slash == path ? strdup("/") : strndup(path, (size_t)(slash - path));
}

/* Follows links to where the bytes must end, also when that file does not exist yet. NULL with errno. */
static char *file_resolve(const char *path)
{
	char *current = strdup(path);
	for (int depth = 0; current && depth < 40; depth++) {
		char link[PATH_MAX];
		ssize_t length = readlink(current, link, sizeof link - 1);
		if (length < 0)
			return current; /* not a link, or not there: this is the place */
		link[length] = '\0';
		char *next = NULL;
		if (link[0] == '/') {
			next = strdup(link);
		} else {
			char *folder = file_folder(current);
			if (!folder || asprintf(&next, "%s/%s", folder, link) < 0)
				next = NULL;
			free(folder);
		}
		free(current);
		current = next;
	}
	if (current)
		errno = ELOOP;
	free(current);
	return NULL;
}

static file_kind file_check_folder(const char *path)
{
	char *target = file_resolve(path);
	if (!target)
		return file_refuse(path, strerror(errno));
	char *folder = file_folder(target);
	free(target);
	if (!folder)
		return file_refuse(path, "out of memory");
	struct stat info;
	file_kind kind = FILE_KIND_REGULAR;
	if (stat(folder, &info) != 0)
		kind = file_refuse(path, errno == ENOENT ? "its folder does not exist; create it first" : strerror(errno));
	else if (!S_ISDIR(info.st_mode))
		kind = file_refuse(path, "its folder is a file");
	else if (access(folder, W_OK | X_OK) != 0)
		kind = file_refuse(path, "no permission to write in its folder");
	free(folder);
	return kind;
}

bool stilb_file_is_stdout(const char *path)
{
	return strcmp(path, "-") == 0 || strcmp(path, "/dev/stdout") == 0;
}

/* Where path ends, links followed: one name for all its names; NULL when its folder is not there. */
static char *file_real_target(const char *path)
{
	char *target = file_resolve(path), *folder = target ? file_folder(target) : NULL;
	char *real = folder ? realpath(folder, NULL) : NULL, *whole = NULL;
	const char *slash = target ? strrchr(target, '/') : NULL;
	if (real && asprintf(&whole, "%s/%s", real, slash ? slash + 1 : target) < 0)
		whole = NULL;
	free(target);
	free(folder);
	free(real);
	return whole;
}

bool stilb_file_same(const char *a, const char *b)
{
	if (stilb_file_is_stdout(a) || stilb_file_is_stdout(b))
		return stilb_file_is_stdout(a) && stilb_file_is_stdout(b);
	struct stat info;
	if (stat(a, &info) == 0 && !S_ISREG(info.st_mode))
		return false; /* a device takes any number of writers */
	char *real_a = file_real_target(a), *real_b = file_real_target(b);
	bool same = real_a && real_b && strcmp(real_a, real_b) == 0;
	free(real_a);
	free(real_b);
	return same;
}

static file_kind file_classify(const char *path)
{
	if (path[0] == '\0')
		return file_refuse(path, "the name is empty");
	if (stilb_file_is_stdout(path))
		return FILE_KIND_DIRECT;
	if (path[strlen(path) - 1] == '/')
		return file_refuse(path, "it names a folder, not a file");
	struct stat info;
	if (stat(path, &info) != 0)
		return errno == ENOENT || errno == ENOTDIR ? file_check_folder(path) : file_refuse(path, strerror(errno));
	if (S_ISDIR(info.st_mode))
		return file_refuse(path, "it is a folder, not a file");
	if (access(path, W_OK) != 0)
		return file_refuse(path, "no permission");
	return S_ISREG(info.st_mode) ? file_check_folder(path) : FILE_KIND_DIRECT;
}

stilb_result stilb_file_check(const char *path)
{
	return file_classify(path) == FILE_KIND_REFUSED ? STILB_ERROR_ARGUMENT : STILB_OK;
}

static stilb_result file_fail(const char *path, const char *what, int error)
{
	return stilb_fail(STILB_ERROR_FILE, "cannot %s '%s': %s", what, path, strerror(error));
}

static FILE *file_open_direct(const char *path)
{
	if (!stilb_file_is_stdout(path))
		return fopen(path, "wb");
	int copy = dup(STDOUT_FILENO); /* so that finish may close it */
	FILE *stream = copy < 0 ? NULL : fdopen(copy, "wb");
	if (!stream && copy >= 0)
		close(copy);
	return stream;
}

/* Differs for every file of this process. */
static unsigned file_serial(void)
{
	static atomic_uint serial;
	return atomic_fetch_add_explicit(&serial, 1, memory_order_relaxed); /* a counter, orders nothing */
}

/* Makes a file beside the target under a name that is free: one of a killed process may still be there, with this
 * process's number. The name is short, since the target's may be as long as a name can be. -1 with errno. */
static int file_create_temporary(stilb_file *file)
{
	char *folder = file_folder(file->target);
	int descriptor = -1;
	int error = folder ? EEXIST : ENOMEM;
	for (int tries = 0; descriptor < 0 && error == EEXIST && tries < 1000; tries++) {
		char *name = NULL;
		if (asprintf(&name, "%s/stilb-%d-%u.tmp", folder, (int)getpid(), file_serial()) < 0) {
			error = ENOMEM;
			break;
		}
		descriptor = open(name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
		error = errno;
		if (descriptor < 0)
			free(name);
		else
			file->temporary = name;
	}
	free(folder);
	errno = error;
	return descriptor;
}

static FILE *file_open_temporary(stilb_file *file)
{
	file->target = file_resolve(file->path);
	int descriptor = file->target ? file_create_temporary(file) : -1;
	if (descriptor < 0)
		return NULL;
	struct stat old;
	if (stat(file->target, &old) == 0)
		fchmod(descriptor, old.st_mode & 07777); /* the new file keeps the old one's mode */
	FILE *stream = fdopen(descriptor, "wb");
	if (!stream)
		close(descriptor);
	return stream;
}

stilb_result stilb_file_open(stilb_file *file, const char *path)
{
	*file = (stilb_file){0};
	file_kind kind = file_classify(path);
	if (kind == FILE_KIND_REFUSED)
		return STILB_ERROR_FILE; /* the folder may have gone since stilb_file_check */
	file->path = strdup(path);
	errno = ENOMEM;
	if (file->path)
		file->stream = kind == FILE_KIND_DIRECT ? file_open_direct(path) : file_open_temporary(file);
	if (file->stream)
		return STILB_OK;
	int error = errno;
	stilb_file_finish(file);
	return file_fail(path, "create", error);
}

int stilb_file_write(stilb_file *file, const void *data, size_t size)
{
	errno = 0;
	if (fwrite(data, 1, size, file->stream) == size)
		return 0;
	return errno ? -errno : -EIO;
}

/* 0 or an errno. Devices and pipes cannot be synced: that is no error. */
static int file_flush(stilb_file *file)
{
	errno = 0;
	if (ferror(file->stream) || fflush(file->stream) != 0)
		return errno ? errno : ENOSPC;
	if (file->temporary && fsync(fileno(file->stream)) != 0)
		return errno;
	FILE *stream = file->stream;
	file->stream = NULL;
	return fclose(stream) == 0 ? 0 : errno;
}

stilb_result stilb_file_commit(stilb_file *file)
{
	int error = file_flush(file);
	if (!error && file->temporary && rename(file->temporary, file->target) != 0)
		error = errno;
	stilb_result result = error ? file_fail(file->path, "write", error) : STILB_OK;
	if (!error) {
		free(file->temporary); /* renamed: there is nothing left to remove */
		file->temporary = NULL;
	}
	stilb_file_finish(file);
	return result;
}

void stilb_file_finish(stilb_file *file)
{
	if (file->stream)
		fclose(file->stream);
	if (file->temporary)
		unlink(file->temporary);
	free(file->path);
	free(file->target);
	free(file->temporary);
	*file = (stilb_file){0};
}

stilb_result stilb_file_save(const char *path, const void *data, size_t size)
{
	stilb_file file;
	stilb_result result = stilb_file_open(&file, path);
	if (result != STILB_OK)
		return result;
	stilb_file_write(&file, data, size); /* commit reports what went wrong */
	return stilb_file_commit(&file);
}
