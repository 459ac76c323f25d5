#include "scene/importer/importer_files.h"

#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

scene_stream importer_stream;

static struct {
	char path[SCENE_MESSAGE_TEXT];
	int file; /* descriptor of the file at path, which the request brought; -1: none */
} files_request = {.file = -1};

void importer_files_begin(const char *path, int given)
{
	STILB_ASSERT(path);
	importer_files_end();
	snprintf(files_request.path, sizeof files_request.path, "%s", path);
	files_request.file = given;
}

void importer_files_end(void)
{
	if (files_request.file >= 0)
		close(files_request.file);
	files_request.file = -1;
}

int importer_files_ask(const char *name, bool quiet, char why[static 256])
{
	STILB_ASSERT(name && why);
	scene_message message = {.kind = SCENE_MESSAGE_OPEN, .flags = quiet};
	int file = -1;
	snprintf(why, 256, "there is no such file");
	if (strcmp(name, files_request.path) == 0)
		return fcntl(files_request.file, F_DUPFD_CLOEXEC, 0);
	if (strlen(name) >= sizeof message.text)
		return -1;
	memcpy(message.text, name, strlen(name) + 1);
	if (!scene_stream_write_message(importer_stream.file, &message, -1) ||
	    !scene_stream_read_message(&importer_stream, &message, &file))
		_exit(1); /* the process that sends the requests has ended */
	if (file < 0)
		snprintf(why, 256, "%.255s", message.text);
	return file;
}

bool importer_bytes_read(int file, importer_bytes *bytes)
{
	STILB_ASSERT(file >= 0 && bytes);
	struct stat info;
	*bytes = (importer_bytes){0};
	bool good = fstat(file, &info) == 0 && info.st_size >= 0;
	size_t size = good ? (size_t)info.st_size : 0;
	bytes->data = good ? malloc(size + 1) : NULL;
	good = bytes->data;
	while (good && bytes->size < size) { /* pread: copies of a descriptor share one file offset */
		ssize_t got = pread(file, bytes->data + bytes->size, size - bytes->size, (off_t)bytes->size);
		if (got < 0 && errno == EINTR)
			continue;
		good = got > 0;
		bytes->size += good ? (size_t)got : 0;
	}
	close(file);
	if (!good)
		importer_bytes_free(bytes);
	STILB_ASSERT(!good || bytes->size == size);
	return good;
}

void importer_bytes_free(importer_bytes *bytes)
{
	free(bytes->data);
	*bytes = (importer_bytes){0};
}

/* ---- OBJ --------------------------------------------------------------------------------------------------------- */

/* True if text[i] is the point of a number without a digit before it, as ".5" or "-.5" after a blank. */
static bool files_lacks_digit(const unsigned char *text, size_t size, size_t i)
{
	STILB_ASSERT(i < size);
	if (text[i] != '.' || i + 1 >= size || !isdigit(text[i + 1]) || i == 0)
		return false;
	unsigned char before = text[i - 1];
	return before == ' ' || before == '\t' ||
	       ((before == '-' || before == '+') && i > 1 && (text[i - 2] == ' ' || text[i - 2] == '\t'));
}

/* Inserts a 0 before the point of numbers like ".5" in the vertex lines of an OBJ file. Assimp 5.2 does not read these
 * as numbers, drops the vertex, and then finds its index out of range. False: out of memory. */
static bool files_complete_numbers(importer_bytes *bytes)
{
	size_t lacking = 0;
	for (size_t i = 0; i < bytes->size; i++)
		lacking += files_lacks_digit(bytes->data, bytes->size, i);
	if (lacking == 0)
		return true;
	unsigned char *whole = malloc(bytes->size + lacking + 1);
	if (!whole)
		return false;
	size_t size = 0;
	bool vertex = false, begin = true;
	for (size_t i = 0; i < bytes->size; i++) {
		unsigned char c = bytes->data[i];
		if (begin)
			vertex = c == 'v';
		begin = c == '\n' || c == '\r';
		if (vertex && files_lacks_digit(bytes->data, bytes->size, i))
			whole[size++] = '0';
		whole[size++] = c;
	}
	STILB_ASSERT(size <= bytes->size + lacking);
	free(bytes->data);
	*bytes = (importer_bytes){whole, size};
	return true;
}

/* ---- for Assimp -------------------------------------------------------------------------------------------------- */

typedef struct files_open {
	struct aiFile face;
	importer_bytes bytes;
	size_t at;
} files_open;

static files_open *files_of(struct aiFile *file)
{
	return (files_open *)(void *)file->UserData;
}

static size_t files_read(struct aiFile *file, char *out, size_t size, size_t count)
{
	files_open *open = files_of(file);
	STILB_ASSERT(open->at <= open->bytes.size);
	size_t left = open->bytes.size - open->at, whole = size ? left / size : 0;
	if (count > whole)
		count = whole;
	memcpy(out, open->bytes.data + open->at, count * size);
	open->at += count * size;
	return count;
}

static size_t files_write(struct aiFile *file, const char *data, size_t size, size_t count)
{
	(void)file, (void)data, (void)size, (void)count;
	return 0;
}

static size_t files_tell(struct aiFile *file)
{
	return files_of(file)->at;
}

static size_t files_size(struct aiFile *file)
{
	return files_of(file)->bytes.size;
}

static enum aiReturn files_seek(struct aiFile *file, size_t offset, enum aiOrigin origin)
{
	files_open *open = files_of(file);
	size_t base = origin == aiOrigin_CUR ? open->at : origin == aiOrigin_END ? open->bytes.size : 0;
	if (base + offset > open->bytes.size)
		return aiReturn_FAILURE;
	open->at = base + offset; /* a negative offset comes as a large one, and the sum wraps around */
	return aiReturn_SUCCESS;
}

static void files_flush(struct aiFile *file)
{
	(void)file;
}

static struct aiFile *files_open_proc(struct aiFileIO *io, const char *name, const char *mode)
{
	char why[256];
	(void)io;
	int file = strchr(mode, 'w') ? -1 : importer_files_ask(name, false, why);
	files_open *open = file >= 0 ? calloc(1, sizeof *open) : NULL;
	if (!open) {
		if (file >= 0)
			close(file);
		return NULL;
	}
	size_t length = strlen(name);
	bool good = importer_bytes_read(file, &open->bytes);
	if (good && length > 4 && strcasecmp(name + length - 4, ".obj") == 0)
		good = files_complete_numbers(&open->bytes);
	if (!good) {
		importer_bytes_free(&open->bytes);
		free(open);
		return NULL;
	}
	open->face = (struct aiFile){.ReadProc = files_read,
	                             .WriteProc = files_write,
	                             .TellProc = files_tell,
	                             .FileSizeProc = files_size,
	                             .SeekProc = files_seek,
	                             .FlushProc = files_flush,
	                             .UserData = (aiUserData)open};
	return &open->face;
}

static void files_close_proc(struct aiFileIO *io, struct aiFile *file)
{
	(void)io;
	if (!file)
		return;
	importer_bytes_free(&files_of(file)->bytes);
	free(files_of(file));
}

struct aiFileIO importer_file_io = {.OpenProc = files_open_proc, .CloseProc = files_close_proc};
