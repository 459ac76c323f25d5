#include "base/base_file.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

/* How a path can be written. */
typedef enum file_kind {
	FILE_KIND_REGULAR, /* a regular file, or nothing yet: a temporary file beside it is written and renamed to it */
	FILE_KIND_DIRECT,  /* stdout, a device, a pipe: opened and written */
	FILE_KIND_REFUSED, /* not at all; the message says why */
} file_kind;

/* A closed file owns nothing. An open one has a path. One that is written to a temporary file also has a target, the
 * path with its symbolic links resolved, and until the rename to the target the temporary file's name. */
static bool file_is_sound(const stilb_file *file)
{
	if (!file->stream)
		return !file->path && !file->target && !file->temporary;
	return file->path && (file->target || !file->temporary);
}

static file_kind file_refuse(const char *path, const char *why)
{
	stilb_fail(STILB_ERROR_ARGUMENT, "cannot write '%s': %s", path, why);
	return FILE_KIND_REFUSED;
}

/* The folder of path's last name, in a new string; NULL: out of memory. */
static char *file_folder(const char *path)
{
	STILB_ASSERT(path[0] && "an empty path has no folder");
	const char *slash = strrchr(path, '/');
	if (!slash)
		return strdup(".");
	return slash == path ? strdup("/") : strndup(path, (size_t)(slash - path));
}

/* path with its links followed, also if the file does not exist yet, in a new string. NULL with errno. */
static char *file_resolve(const char *path)
{
	char *current = strdup(path);
	for (int depth = 0; current && depth < 40; depth++) {
		char link[PATH_MAX];
		ssize_t length = readlink(current, link, sizeof link - 1);
		if (length < 0)
			return current; /* not a link, or nothing there yet */
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
	STILB_ASSERT(path);
	return strcmp(path, "-") == 0 || strcmp(path, "/dev/stdout") == 0;
}

/* The one absolute path, in a new string, that all paths to the same file lead to: links are followed, and the folder's
 * path is made absolute. NULL if the folder does not exist or memory runs out. */
static char *file_real_target(const char *path)
{
	char *target = file_resolve(path), *folder = target && target[0] ? file_folder(target) : NULL;
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
		return false; /* a device or pipe takes any number of writers, which replace nothing of one another */
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
	STILB_ASSERT(path);
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
	int copy = dup(STDOUT_FILENO); /* stdout itself stays open after finish */
	FILE *stream = copy < 0 ? NULL : fdopen(copy, "wb");
	if (!stream && copy >= 0)
		close(copy);
	return stream;
}

/* ---- temporary files ------------------------------------------------------------------------------------------------
 *
 * Named "<target>.<pid>.tmp" beside the target, the file that it will replace; "<target>.<pid>-<number>.tmp" if that
 * name is taken. Its writer holds its lock (flock) until the file is renamed or removed, and the kernel releases the
 * lock of a process that dies: a temporary file without a lock was left behind and may be removed. Unlike a process
 * number, a lock is also seen from other containers.
 */

#define FILE_TEMPORARY_MAX 48 /* bytes of ".<pid>-<number>.tmp" and its 0; at most 26 are used */
#define FILE_TRIES 1000u      /* temporary names that are tried before giving up */

static_assert(FILE_TEMPORARY_MAX < NAME_MAX, "a temporary name keeps a part of the file's name");

/* Sets *stem to the last name of path. Returns its length, shortened so that a temporary name is no longer than
 * NAME_MAX bytes. */
static size_t file_stem(const char *path, const char **stem)
{
	const char *slash = strrchr(path, '/');
	*stem = slash ? slash + 1 : path;
	size_t length = strlen(*stem);
	return length < NAME_MAX - FILE_TEMPORARY_MAX ? length : NAME_MAX - FILE_TEMPORARY_MAX;
}

/* True if name is a temporary name of this stem, given by any process. */
static bool file_is_temporary(const char *name, const char *stem, size_t length)
{
	STILB_ASSERT(length <= strlen(stem));
	if (strncmp(name, stem, length) != 0 || name[length] != '.')
		return false;
	const char *end = name + length + 1;
	size_t digits = strspn(end, "0123456789");
	end += digits;
	if (digits > 0 && *end == '-') {
		digits = strspn(end + 1, "0123456789");
		end += 1 + digits;
	}
	return digits > 0 && strcmp(end, ".tmp") == 0;
}

/* Removes a temporary file unless its writer holds the lock. */
static void file_remove_stale(int folder, const char *name)
{
	struct stat info;
	int descriptor = openat(folder, name, O_WRONLY | O_NONBLOCK | O_NOFOLLOW | O_CLOEXEC);
	if (descriptor < 0)
		return;
	if (fstat(descriptor, &info) == 0 && S_ISREG(info.st_mode) && flock(descriptor, LOCK_EX | LOCK_NB) == 0)
		unlinkat(folder, name, 0);
	close(descriptor);
}

static void file_clean_target(const char *target)
{
	const char *stem;
	size_t length = file_stem(target, &stem);
	char *path = file_folder(target);
	DIR *folder = path ? opendir(path) : NULL;
	free(path);
	if (!folder)
		return;
	for (struct dirent *entry; (entry = readdir(folder));)
		if (file_is_temporary(entry->d_name, stem, length))
			file_remove_stale(dirfd(folder), entry->d_name);
	closedir(folder);
}

void stilb_file_clean(const char *path)
{
	STILB_ASSERT(path);
	char *target = stilb_file_is_stdout(path) ? NULL : file_resolve(path);
	if (target && target[0])
		file_clean_target(target);
	free(target);
}

/* Creates and locks the file of this name. Before it is locked, another process may take it for a stale one and remove
 * it: then it has no name any more, and the caller tries again. -1 with errno, EEXIST for another try. */
static int file_create_locked(const char *name)
{
	struct stat info;
	int descriptor = open(name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
	if (descriptor < 0)
		return -1;
	if (flock(descriptor, LOCK_EX) != 0 || fstat(descriptor, &info) != 0 || info.st_nlink > 0)
		return descriptor; /* also on a file system without locks: there nobody takes it for a stale one */
	close(descriptor);
	errno = EEXIST;
	return -1;
}

/* Creates the temporary file beside the target and sets its name. -1 with errno. */
static int file_create_temporary(stilb_file *file)
{
	STILB_ASSERT(file->target && !file->temporary);
	const char *stem;
	size_t length = file_stem(file->target, &stem);
	file_clean_target(file->target);
	int error = EEXIST;
	for (unsigned number = 0; error == EEXIST && number < FILE_TRIES; number++) {
		char end[FILE_TEMPORARY_MAX], *name;
		snprintf(end, sizeof end, number == 0 ? ".%d.tmp" : ".%d-%u.tmp", (int)getpid(), number);
		STILB_ASSERT(strlen(end) + 1 < sizeof end && "not cut off");
		if (asprintf(&name, "%.*s%s", (int)((stem - file->target) + (ptrdiff_t)length), file->target, end) < 0) {
			error = ENOMEM;
			break;
		}
		int descriptor = file_create_locked(name);
		error = errno;
		if (descriptor >= 0) {
			file->temporary = name;
			return descriptor;
		}
		free(name);
	}
	errno = error;
	return -1;
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

/* Closes the stream, removes the temporary file if it was not renamed, and frees the names; also of a file that was not
 * opened completely. */
static void file_release(stilb_file *file)
{
	if (file->temporary)
		unlink(file->temporary);
	if (file->stream)
		fclose(file->stream);
	free(file->path);
	free(file->target);
	free(file->temporary);
	*file = (stilb_file){0};
}

stilb_result stilb_file_open(stilb_file *file, const char *path)
{
	STILB_ASSERT(file && path);
	*file = (stilb_file){0};
	file_kind kind = file_classify(path);
	if (kind == FILE_KIND_REFUSED)
		return STILB_ERROR_FILE; /* the folder may have gone since stilb_file_check */
	file->path = strdup(path);
	errno = ENOMEM;
	if (file->path)
		file->stream = kind == FILE_KIND_DIRECT ? file_open_direct(path) : file_open_temporary(file);
	if (file->stream) {
		STILB_ASSERT(file_is_sound(file));
		return STILB_OK;
	}
	int error = errno;
	file_release(file);
	return file_fail(path, "create", error);
}

int stilb_file_write(stilb_file *file, const void *data, size_t size)
{
	STILB_ASSERT(file->stream && "open");
	STILB_ASSERT(data || size == 0);
	errno = 0;
	if (fwrite(data, 1, size, file->stream) == size)
		return 0;
	return errno ? -errno : -EIO;
}

/* Flushes and syncs the file. Returns 0 or an errno. Devices and pipes cannot be synced: that is no error. */
static int file_flush(stilb_file *file)
{
	errno = 0;
	if (ferror(file->stream) || fflush(file->stream) != 0)
		return errno ? errno : ENOSPC;
	return file->temporary && !file->unsynced && fsync(fileno(file->stream)) != 0 ? errno : 0;
}

/* Makes the rename durable: without it a power cut may bring the old file back. A failure is ignored: some file systems
 * cannot sync a folder, and the file is in its place already. */
static void file_sync_folder(const char *target)
{
	char *path = file_folder(target);
	int folder = path ? open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1;
	free(path);
	if (folder < 0)
		return;
	fsync(folder);
	close(folder);
}

/* Renames the temporary file to its target and syncs the folder. Returns 0 or an errno. The caller closes the file only
 * afterwards: closing releases the lock that keeps other processes from removing the temporary file as a stale one. */
static int file_move_into_place(stilb_file *file)
{
	STILB_ASSERT(file->temporary && file->target);
	if (rename(file->temporary, file->target) != 0)
		return errno;
	free(file->temporary); /* there is no such file any more, so file_release must not remove it */
	file->temporary = NULL;
	if (!file->unsynced)
		file_sync_folder(file->target);
	return 0;
}

/* Closes the stream. Returns 0 or an errno. */
static int file_close(stilb_file *file)
{
	FILE *stream = file->stream;
	STILB_ASSERT(!file->temporary && "a temporary file is closed after its rename");
	file->stream = NULL;
	return fclose(stream) == 0 ? 0 : errno;
}

stilb_result stilb_file_commit(stilb_file *file)
{
	STILB_ASSERT(file->stream && "open");
	STILB_ASSERT(file_is_sound(file));
	int error = file_flush(file);
	if (!error)
		error = file->temporary ? file_move_into_place(file) : file_close(file);
	stilb_result result = error ? file_fail(file->path, "write", error) : STILB_OK;
	file_release(file);
	return result;
}

void stilb_file_finish(stilb_file *file)
{
	STILB_ASSERT(file && file_is_sound(file));
	file_release(file);
}

stilb_result stilb_file_save(const char *path, const void *data, size_t size)
{
	STILB_ASSERT(data || size == 0);
	stilb_file file;
	stilb_result result = stilb_file_open(&file, path);
	if (result != STILB_OK)
		return result;
	stilb_file_write(&file, data, size); /* commit reports what went wrong */
	return stilb_file_commit(&file);
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

/* NULL, or the reason why the descriptor cannot be read as a file. */
static const char *file_unreadable(int descriptor)
{
	struct stat info;
	if (fstat(descriptor, &info) != 0)
		return strerror(errno);
	if (S_ISDIR(info.st_mode))
		return "it is a folder, not a file";
	return S_ISREG(info.st_mode) ? NULL : "it is a device or a pipe; give a regular file";
}

stilb_result stilb_file_read_open(const char *path, FILE **stream)
{
	STILB_ASSERT(path && stream);
	/* O_NONBLOCK: opening a pipe would wait for its writer. Reading a regular file is not affected. */
	int descriptor = open(path, O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
	const char *why = descriptor < 0 ? strerror(errno) : file_unreadable(descriptor);
	*stream = why ? NULL : fdopen(descriptor, "rb");
	if (*stream)
		return STILB_OK;
	if (!why)
		why = strerror(errno);
	if (descriptor >= 0)
		close(descriptor);
	return stilb_fail(STILB_ERROR_FILE, "cannot read '%s': %s", path, why);
}
