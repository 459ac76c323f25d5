#include "scene/open/scene_import.h"

#include "base/base_file.h"
#include "scene/open/scene_files.h"
#include "scene/open/scene_stream.h"
#include "scene/open/scene_stream_rest.h"
#include "scene/scene_internal.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <limits.h>
#include <math.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

/* ---- the other process ------------------------------------------------------------------------------------------- */

struct scene_importer {
	scene_import_limits limits;
	pid_t id; /* 0: not running */
	scene_stream stream;
	uint32_t protection; /* flags of scene_protection */
};

#define IMPORT_SOCKET 3 /* the process's end of the connection; the same in importer_main.c */

/* Starts the program with its end of the socket, our standard error for the reports of sanitizers, no other files, and
 * an environment that names only the folders of libraries. Returns 0 or an errno. */
static int import_spawn(const char *program, const char *const arguments[], int out, pid_t *id)
{
	static const char *const kept[] = {"LD_LIBRARY_PATH", "ASAN_OPTIONS", "UBSAN_OPTIONS", "LSAN_OPTIONS"};
	char *environment[sizeof kept / sizeof *kept + 1], *given[sizeof kept / sizeof *kept];
	size_t count = 0;
	for (size_t i = 0; i < sizeof kept / sizeof *kept; i++) {
		const char *value = getenv(kept[i]);
		given[i] = NULL;
		if (value && asprintf(&given[i], "%s=%s", kept[i], value) > 0)
			environment[count++] = given[i];
	}
	environment[count] = NULL;
	posix_spawn_file_actions_t actions;
	posix_spawnattr_t attributes;
	sigset_t none;
	sigemptyset(&none);
	int error = posix_spawn_file_actions_init(&actions);
	if (!error)
		error = posix_spawnattr_init(&attributes);
	if (!error) {
		posix_spawn_file_actions_adddup2(&actions, out, IMPORT_SOCKET);
		posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
		posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
		posix_spawn_file_actions_addclosefrom_np(&actions, IMPORT_SOCKET + 1);
		posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
		posix_spawnattr_setsigmask(&attributes, &none); /* with our mask a signal might not end it */
		error = posix_spawn(id, program, &actions, &attributes, (char *const *)arguments, environment);
		posix_spawnattr_destroy(&attributes);
		posix_spawn_file_actions_destroy(&actions);
	}
	for (size_t i = 0; i < sizeof kept / sizeof *kept; i++)
		free(given[i]);
	return error;
}

/* Sets the limits of one request. */
static void import_begin(scene_importer *importer)
{
	STILB_ASSERT(importer->id > 0 && "running");
	importer->stream.deadline_ns = stilb_time_ns() + (uint64_t)(importer->limits.seconds * 1e9);
	importer->stream.limit = importer->limits.bytes;
	importer->stream.give_up = importer->limits.give_up;
	importer->stream.user = importer->limits.user;
	importer->stream.taken = 0;
}

/* Starts the process. Errors of scene_importer_start. */
static stilb_result import_run(scene_importer *importer)
{
	STILB_ASSERT(importer->id == 0 && "not running");
	char program[STILB_FILE_PART_MAX], bytes[32], seconds[32], version[64];
	int ends[2], passed;
	if (!stilb_file_find_part(SCENE_IMPORTER, program))
		return stilb_fail(STILB_ERROR_FILE,
		                  "the program that reads scenes and pictures, " SCENE_IMPORTER ", is " STILB_FILE_PART_PLACES);
	if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
		return stilb_fail(STILB_ERROR_FILE, "no connection to " SCENE_IMPORTER ": %s", strerror(errno));
	snprintf(bytes, sizeof bytes, "%" PRIu64, importer->limits.bytes);
	snprintf(seconds, sizeof seconds, "%.0f", ceil(importer->limits.seconds));
	const char *const arguments[] = {SCENE_IMPORTER, bytes, seconds, NULL};
	int error = import_spawn(program, arguments, ends[1], &importer->id);
	close(ends[1]);
	if (error) {
		close(ends[0]);
		importer->id = 0;
		return stilb_fail(STILB_ERROR_FILE, "%s cannot be started: %s", program, strerror(error));
	}
	importer->stream = (scene_stream){.file = ends[0]};
	import_begin(importer);
	scene_message hello;
	scene_stream_version(version);
	if (!scene_stream_read_message(&importer->stream, &hello, &passed))
		return STILB_OK; /* the process has ended already: the request that follows finds that out and reports it */
	if (passed >= 0)
		close(passed);
	importer->protection = hello.flags;
	if (hello.kind != SCENE_MESSAGE_HELLO || strcmp(hello.text, version) != 0)
		return stilb_fail(STILB_ERROR_FILE, "%s is of another build; install both together", program);
	return STILB_OK;
}

/* Ends the process if it still runs. Returns its wait status, or -1 if somebody else has waited for it. */
static int import_end(scene_importer *importer)
{
	STILB_ASSERT(importer->id > 0 && "running");
	int status;
	pid_t id = importer->id;
	close(importer->stream.file);
	if (!importer->stream.ended)
		kill(id, SIGKILL);
	importer->id = 0;
	while (waitpid(id, &status, 0) < 0)
		if (errno != EINTR)
			return -1;
	return status;
}

stilb_result scene_importer_start(const scene_import_limits *limits, scene_importer **importer)
{
	STILB_ASSERT(limits && importer);
	STILB_ASSERT(limits->bytes > 0 && limits->seconds > 0.0);
	scene_importer *made = calloc(1, sizeof *made);
	*importer = NULL;
	if (!made)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for an import");
	made->limits = *limits;
	stilb_result result = import_run(made);
	if (result == STILB_OK)
		*importer = made;
	else
		scene_importer_stop(made);
	return result;
}

void scene_importer_stop(scene_importer *importer)
{
	if (importer && importer->id > 0)
		import_end(importer);
	free(importer);
}

uint32_t scene_importer_protection(const scene_importer *importer)
{
	STILB_ASSERT(importer);
	return importer->protection;
}

/* ---- limits and refusals ----------------------------------------------------------------------------------------- */

#define IMPORT_BYTES_MAX (8ull << 30)
#define IMPORT_SECONDS 120.0

scene_import_limits scene_import_limits_default(void)
{
	const char *text = getenv("STILB_IMPORT_SECONDS");
	double seconds = text ? strtod(text, NULL) : 0.0;
	uint64_t memory = (uint64_t)sysconf(_SC_PHYS_PAGES) * (uint64_t)sysconf(_SC_PAGESIZE);
	return (scene_import_limits){
		.bytes = memory / 4 * 3 < IMPORT_BYTES_MAX ? memory / 4 * 3 : IMPORT_BYTES_MAX,
		.seconds = seconds > 0.0 && seconds < 1e6 ? seconds : IMPORT_SECONDS,
	};
}

/* Opens the regular file at path. Returns a descriptor, or -1 with *result and its message. */
static int import_open(const char *path, stilb_result *result)
{
	struct stat info;
	int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY); /* does not wait for a pipe's writer */
	*result = STILB_ERROR_ARGUMENT;
	if (file < 0 || fstat(file, &info) != 0)
		stilb_fail(STILB_ERROR_ARGUMENT, "cannot read '%s': %s", path, strerror(errno));
	else if (!S_ISREG(info.st_mode))
		stilb_fail(STILB_ERROR_ARGUMENT, "cannot read '%s': it is %s", path,
		           S_ISDIR(info.st_mode) ? "a folder, not a file" : "not a regular file");
	else if (info.st_size == 0)
		*result = stilb_fail(STILB_ERROR_FILE, "cannot read '%s': it is empty", path);
	else
		*result = STILB_OK;
	if (*result == STILB_OK)
		return file;
	if (file >= 0)
		close(file);
	return -1;
}

/* The failure of a process that ended without sending a result. decoder: the library that read the file. */
static stilb_result import_died(const scene_importer *importer, const char *path, const char *decoder, int status)
{
	if (importer->stream.given_up)
		return stilb_fail(STILB_ERROR_FILE, "'%s' was given up", path);
	if (importer->stream.too_much)
		return stilb_fail(STILB_ERROR_MEMORY,
		                  "cannot read '%s': it is larger than the %" PRIu64 " MiB that an import may be", path,
		                  importer->limits.bytes >> 20);
	if (importer->stream.late || (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU))
		return stilb_fail(STILB_ERROR_FILE,
		                  "cannot read '%s': not done after %.0f s; the file is damaged, or give it more time with "
		                  "STILB_IMPORT_SECONDS=N",
		                  path, importer->limits.seconds);
	if (WIFSIGNALED(status) && WTERMSIG(status) == SIGINT)
		return stilb_fail(STILB_ERROR_FILE, "cannot read '%s': interrupted", path);
	if (WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL)
		return stilb_fail(STILB_ERROR_MEMORY, "cannot read '%s': its import was killed, likely for want of memory",
		                  path);
	if (WIFSIGNALED(status)) /* SIGABRT: some libraries abort if a constructor gets no memory or thread */
		return stilb_fail(STILB_ERROR_FILE, "cannot read '%s': %s crashed on it (%s); the file is damaged%s", path,
		                  decoder, strsignal(WTERMSIG(status)),
		                  WTERMSIG(status) == SIGABRT ? ", or there is too little memory or too few threads" : "");
	return stilb_fail(STILB_ERROR_FILE, "cannot read '%s': its import ended early (exit status %d)", path,
	                  WIFEXITED(status) ? WEXITSTATUS(status) : -1);
}

/* ---- requests ---------------------------------------------------------------------------------------------------- */

#define IMPORT_DONE_MOST 0.99f /* of what the process says: the scene must still be sent, and checked */

/* One request, while it runs. */
typedef struct import_request {
	scene_importer *importer;
	const char *path;
	scene_files *files;    /* opens the files that the scene names; NULL: it may name none */
	stilb_image *pictures; /* [picture_count], received in this order */
	uint32_t picture_count, picture_capacity;
	float done;          /* what scene_import_limits.progress was told last */
	bool ended;          /* the process has sent a result, so it is alive and ready for the next request */
	char refused[8][64]; /* last parts of names that were logged as refused: Assimp asks more than once */
	uint32_t refused_count;
} import_request;

/* Every received picture has its pixels, there are no more than the array has room for, and no more refusals are noted
 * than refused has room for. */
static bool import_request_is_sound(const import_request *request)
{
	for (uint32_t i = 0; i < request->picture_count; i++)
		if (!request->pictures[i].pixels)
			return false;
	return request->picture_count <= request->picture_capacity &&
	       request->refused_count <= sizeof request->refused / sizeof *request->refused;
}

/* Frees the pictures that the request still owns: those not moved into a scene or to the caller. */
static void import_free(import_request *request)
{
	for (uint32_t i = 0; i < request->picture_count; i++)
		stilb_image_finish(&request->pictures[i]);
	free(request->pictures);
}

/* Sends the request with the descriptor of its file, -1: none. Starts the process first if the last file ended it. */
static stilb_result import_ask(import_request *request, scene_message_kind kind, int file)
{
	STILB_ASSERT(kind >= SCENE_MESSAGE_READ_SCENE && "a request");
	STILB_ASSERT((file >= 0) == (kind != SCENE_MESSAGE_ABOUT));
	scene_importer *importer = request->importer;
	stilb_result result = importer->id > 0 ? STILB_OK : import_run(importer);
	if (result != STILB_OK)
		return result;
	import_begin(importer);
	scene_message message = {.kind = kind};
	snprintf(message.text, sizeof message.text, "%s", request->path);
	scene_stream_write_message(importer->stream.file, &message, file); /* import_listen reports failures */
	return STILB_OK;
}

/* Logs that a file which the scene names is refused, once for each file. Names of one letter are not logged: Assimp 5.2
 * asks for them while it looks for a file in other places. */
static void import_log_refused(import_request *request, const char *name, const char *why)
{
	STILB_ASSERT(request->files);
	uint32_t most = sizeof request->refused / sizeof *request->refused;
	const char *slash = strrchr(name, '/'), *last = slash ? slash + 1 : name;
	size_t prefix = strlen(request->files->prefix);
	for (uint32_t i = 0; i < request->refused_count; i++)
		if (strncmp(request->refused[i], last, sizeof *request->refused - 1) == 0)
			return;
	if (strlen(last) < 2 || request->refused_count == most || request->importer->limits.quiet)
		return;
	snprintf(request->refused[request->refused_count++], sizeof *request->refused, "%.*s",
	         (int)sizeof *request->refused - 1, last);
	if (strncmp(name, request->files->prefix, prefix) == 0)
		name += prefix;
	stilb_log("%s: '%s' is not read: %s", request->path, name, why);
}

/* Tells who asks for it the path of a file that the scene names. */
static void import_tell_opened(const scene_import_limits *limits, int file)
{
	char link[32], path[PATH_MAX];
	snprintf(link, sizeof link, "/proc/self/fd/%d", file);
	ssize_t length = limits->opened ? readlink(link, path, sizeof path - 1) : -1;
	if (length <= 0)
		return;
	path[length] = '\0';
	limits->opened(limits->user, path);
}

/* Tells who asks for it how much is done, unless that is not more than before, or not less than all. */
static void import_tell_progress(import_request *request, float done, float most)
{
	const scene_import_limits *limits = &request->importer->limits;
	if (!limits->progress || !(done > request->done) || !(done <= most))
		return;
	request->done = done;
	limits->progress(limits->user, done);
}

/* Answers an OPEN message with the file's descriptor or a refusal. Logs a refusal unless asked->flags is set: then the
 * import process warns of it, as it does of textures. */
static void import_answer(import_request *request, const scene_message *asked)
{
	STILB_ASSERT(asked->kind == SCENE_MESSAGE_OPEN);
	scene_message answer = {.kind = SCENE_MESSAGE_FILE};
	char why[256] = "there is no such file";
	int file = request->files ? scene_files_open(request->files, asked->text, why) : -1;
	if (file < 0)
		snprintf(answer.text, sizeof answer.text, "%s", why);
	if (request->files && file < 0 && scene_files_outside(why) && !asked->flags)
		import_log_refused(request, asked->text, why);
	scene_stream_write_message(request->importer->stream.file, &answer, file);
	if (file >= 0)
		import_tell_opened(&request->importer->limits, file);
	if (file >= 0)
		close(file);
}

/* Makes room for another picture. */
static bool import_grow_pictures(import_request *request)
{
	if (request->picture_count < request->picture_capacity)
		return true;
	uint32_t capacity = 2 * request->picture_capacity + 16;
	stilb_image *pictures =
		capacity <= STILB_SCENE_MAX_MODELS ? realloc(request->pictures, capacity * sizeof *pictures) : NULL;
	if (!pictures)
		return false;
	request->pictures = pictures;
	request->picture_capacity = capacity;
	return true;
}

/* Appends the picture of a PICTURE message to the request's; closes file. */
static stilb_result import_keep_picture(import_request *request, const scene_message *message, int file)
{
	if (!import_grow_pictures(request)) {
		if (file >= 0)
			close(file);
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for its pictures");
	}
	stilb_image *picture = &request->pictures[request->picture_count];
	stilb_result result = scene_stream_take_picture(&request->importer->stream, message, file, picture);
	request->picture_count += result == STILB_OK;
	STILB_CHECK(import_request_is_sound(request));
	return result;
}

/* Handles messages until the one of kind `end` or an ERROR. Failures without request->ended: the process is gone, too
 * slow, or has sent nonsense. */
static stilb_result import_listen(import_request *request, scene_message_kind end, scene_message *message)
{
	STILB_ASSERT(end == SCENE_MESSAGE_PICTURE || end == SCENE_MESSAGE_SCENE || end == SCENE_MESSAGE_VERSION);
	int passed;
	stilb_result result = STILB_OK;
	while (result == STILB_OK && scene_stream_read_message(&request->importer->stream, message, &passed)) {
		if (message->kind == SCENE_MESSAGE_PICTURE) {
			result = import_keep_picture(request, message, passed);
			passed = -1;
		} else if (message->kind == SCENE_MESSAGE_OPEN) {
			import_answer(request, message);
		} else if (message->kind == SCENE_MESSAGE_PROGRESS) {
			import_tell_progress(request, message->done, IMPORT_DONE_MOST);
		} else if (message->kind == SCENE_MESSAGE_WARNING && !request->importer->limits.quiet) {
			stilb_log("%s: %s", request->path, message->text);
		}
		if (passed >= 0)
			close(passed);
		request->ended = message->kind == SCENE_MESSAGE_ERROR;
		if (request->ended)
			return stilb_fail(message->result == STILB_ERROR_MEMORY ? STILB_ERROR_MEMORY : STILB_ERROR_FILE,
			                  "cannot read '%s': %s", request->path, message->text);
		if (result == STILB_OK && message->kind == end)
			return STILB_OK;
	}
	return result == STILB_OK ? STILB_ERROR_FILE : result;
}

/* The failure of a request with its message. Ends a process that is gone or has sent nonsense. decoder: the library
 * that read the file. */
static stilb_result import_fail(import_request *request, stilb_result result, const char *decoder)
{
	scene_importer *importer = request->importer;
	STILB_ASSERT(result != STILB_OK);
	if (request->ended)
		return result;
	char reason[400];
	snprintf(reason, sizeof reason, "%s", stilb_error_message());
	const scene_stream *stream = &importer->stream;
	bool gone = stream->late || stream->ended || stream->too_much || stream->given_up;
	if (importer->id > 0 && gone)
		return import_died(importer, request->path, decoder, import_end(importer));
	if (importer->id > 0)
		import_end(importer);
	return stilb_fail(result, "cannot read '%s': %s", request->path, reason);
}

/* The most memory that the process has had at once, bytes, as the kernel counts it (proc(5)); 0: unknown. */
static uint64_t import_most_bytes(const scene_importer *importer)
{
	char path[64], line[128];
	unsigned long long kib = 0;
	snprintf(path, sizeof path, "/proc/%d/status", (int)importer->id);
	FILE *status = fopen(path, "re");
	while (status && fgets(line, sizeof line, status) && sscanf(line, "VmHWM: %llu", &kib) != 1) {
	}
	if (status)
		fclose(status);
	return kib * 1024;
}

/* Who reads the scene in this file, for messages. */
static const char *import_reader(const char *path)
{
	const char *dot = strrchr(path, '.');
	return dot && (strcasecmp(dot, ".gltf") == 0 || strcasecmp(dot, ".glb") == 0) ? "the reader of glTF" : "Assimp";
}

stilb_result scene_importer_scene(scene_importer *importer, const char *path, stilb_scene **scene)
{
	STILB_ASSERT(importer && path && scene);
	stilb_result result;
	scene_files files;
	scene_message message;
	*scene = NULL;
	int file = import_open(path, &result);
	if (file < 0)
		return result;
	result = scene_files_init(&files, path, importer->limits.allow_outside);
	import_request request = {.importer = importer, .path = path, .files = &files};
	if (result == STILB_OK) {
		result = import_ask(&request, SCENE_MESSAGE_READ_SCENE, file);
		if (result == STILB_OK)
			result = import_listen(&request, SCENE_MESSAGE_SCENE, &message);
		if (result == STILB_OK)
			result = scene_stream_read(&importer->stream, request.pictures, request.picture_count, scene);
		if (result == STILB_OK)
			import_tell_progress(&request, 1.0f, 1.0f);
		if (result == STILB_OK && importer->limits.most_bytes)
			*importer->limits.most_bytes = import_most_bytes(importer);
		if (result != STILB_OK)
			result = import_fail(&request, result, import_reader(path));
		scene_files_finish(&files);
	}
	import_free(&request);
	close(file);
	return result;
}

static bool import_is_light(const stilb_image *picture)
{
	return picture->channels == 3 && picture->format == STILB_IMAGE_F32_LINEAR;
}

stilb_result scene_importer_picture(scene_importer *importer, const char *path, bool light, stilb_image *image)
{
	STILB_ASSERT(importer && path && image);
	stilb_result result;
	scene_message message;
	*image = (stilb_image){0};
	int file = import_open(path, &result);
	if (file < 0)
		return STILB_ERROR_FILE;
	import_request request = {.importer = importer, .path = path};
	result = import_ask(&request, light ? SCENE_MESSAGE_READ_LIGHT : SCENE_MESSAGE_READ_PICTURE, file);
	if (result == STILB_OK)
		result = import_listen(&request, SCENE_MESSAGE_PICTURE, &message);
	STILB_ASSERT(result != STILB_OK || (request.pictures && request.picture_count == 1));
	if (result == STILB_OK && stilb_image_format_is_blocks(request.pictures[0].format))
		result = stilb_fail(STILB_ERROR_FILE, "its import sent a picture in blocks, which nobody asked for");
	if (result == STILB_OK && light && !import_is_light(&request.pictures[0]))
		result = stilb_fail(STILB_ERROR_FILE, "its import sent a picture that is not three channels of light");
	if (result == STILB_OK) {
		*image = request.pictures[0];
		request.pictures[0] = (stilb_image){0};
	} else {
		result = import_fail(&request, result, "the decoder");
	}
	import_free(&request);
	close(file);
	return result;
}

/* ---- a process for one request ----------------------------------------------------------------------------------- */

stilb_result scene_import_within(const char *path, const scene_import_limits *limits, stilb_scene **scene)
{
	scene_importer *importer;
	stilb_result result;
	*scene = NULL;
	int file = import_open(path, &result); /* before the start: a missing file matters more than a missing program */
	if (file < 0)
		return result;
	close(file);
	result = scene_importer_start(limits, &importer);
	if (result != STILB_OK) {
		char reason[400];
		snprintf(reason, sizeof reason, "%s", stilb_error_message());
		return stilb_fail(result, "cannot read '%s': %s", path, reason);
	}
	result = scene_importer_scene(importer, path, scene);
	scene_importer_stop(importer);
	return result;
}

stilb_result stilb_scene_set_environment(stilb_scene *scene, const char *path)
{
	STILB_ASSERT(scene && path);
	scene_importer *importer;
	stilb_image map;
	scene_import_limits limits = scene_import_limits_default();
	stilb_result result = scene_importer_start(&limits, &importer);
	if (result != STILB_OK) {
		char reason[400];
		snprintf(reason, sizeof reason, "%s", stilb_error_message());
		return stilb_fail(result, "cannot read '%s': %s", path, reason);
	}
	result = scene_importer_picture(importer, path, true, &map);
	scene_importer_stop(importer);
	if (result != STILB_OK)
		return result;
	STILB_ASSERT(import_is_light(&map));
	stilb_scene_surroundings *around = &scene->surroundings;
	if (!scene_panorama_halves(&map, around->sky, around->ground)) {
		stilb_image_finish(&map);
		return stilb_fail(STILB_ERROR_MEMORY, "cannot read '%s': no memory for a row of it", path);
	}
	stilb_image_finish(&around->panorama);
	around->panorama = map;
	const char *slash = strrchr(path, '/');
	snprintf(around->name, sizeof around->name, "%.*s", (int)sizeof around->name - 1, slash ? slash + 1 : path);
	scene_stream_clean_name(around->name, sizeof around->name);
	scene->revisions.surroundings++; /* also if the new pixels lie where the old ones did */
	return STILB_OK;
}

/* Finds the line "<name> <version>" and copies its version; "not found" if there is none. */
static void import_find_version(const char *lines, const char *name, char version[static 32])
{
	const char *line = strstr(lines, name);
	snprintf(version, 32, "not found");
	if (line)
		snprintf(version, 32, "%.*s", (int)strcspn(line + strlen(name) + 1, "\n"), line + strlen(name) + 1);
}

stilb_scene_import_info stilb_scene_import_query(void)
{
	stilb_scene_import_info info = {0};
	scene_importer *importer;
	scene_message message = {0};
	scene_import_limits limits = {.bytes = IMPORT_BYTES_MAX, .seconds = 10.0};
	if (scene_importer_start(&limits, &importer) == STILB_OK) {
		import_request request = {.importer = importer, .path = ""};
		if (import_ask(&request, SCENE_MESSAGE_ABOUT, -1) != STILB_OK ||
		    import_listen(&request, SCENE_MESSAGE_VERSION, &message) != STILB_OK)
			message.text[0] = '\0';
		info.privileges = importer->protection & SCENE_PROTECTION_PRIVILEGES;
		info.landlock = importer->protection & SCENE_PROTECTION_LANDLOCK;
		info.seccomp = importer->protection & SCENE_PROTECTION_SECCOMP;
		info.limits = importer->protection & SCENE_PROTECTION_LIMITS;
		import_free(&request);
		scene_importer_stop(importer);
	}
	import_find_version(message.text, "Assimp", info.assimp);
	import_find_version(message.text, "OpenImageIO", info.openimageio);
	return info;
}
