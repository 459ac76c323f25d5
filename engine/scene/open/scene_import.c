#include "scene/open/scene_import.h"

#include "scene/open/scene_files.h"
#include "scene/open/scene_stream.h"

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
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

/* ---- the other process ------------------------------------------------------------------------------------------- */

struct scene_importer {
	scene_import_limits limits;
	pid_t id; /* 0: not running */
	scene_stream stream;
	uint32_t protection;
};

/* Beside the program, where the build puts it seen from a test, where an installation puts it. */
static bool import_find(char path[static PATH_MAX + 64])
{
	static const char *const places[] = {"", "/..", "/../lib/stilb"};
	char folder[PATH_MAX];
	ssize_t length = readlink("/proc/self/exe", folder, sizeof folder - 1);
	char *slash = length > 0 ? memrchr(folder, '/', (size_t)length) : NULL;
	if (!slash)
		return false;
	*slash = '\0';
	for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
		snprintf(path, PATH_MAX + 64, "%s%s/" SCENE_IMPORTER, folder, places[i]);
		if (access(path, X_OK) == 0)
			return true;
	}
	return false;
}

#define IMPORT_SOCKET 3 /* its end of the connection, as importer_main.c knows it */

/* Starts it with nothing but its end of the socket, a standard error where sanitizers report, and an environment that
 * says only where libraries are. 0, or an errno. */
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
		posix_spawnattr_setsigmask(&attributes, &none); /* a mask of ours could keep a signal from ending it */
		error = posix_spawn(id, program, &actions, &attributes, (char *const *)arguments, environment);
		posix_spawnattr_destroy(&attributes);
		posix_spawn_file_actions_destroy(&actions);
	}
	for (size_t i = 0; i < sizeof kept / sizeof *kept; i++)
		free(given[i]);
	return error;
}

static void import_begin(scene_importer *importer)
{
	importer->stream.deadline_ns = stilb_time_ns() + (uint64_t)(importer->limits.seconds * 1e9);
	importer->stream.limit = importer->limits.bytes;
	importer->stream.taken = 0;
}

/* STILB_ERROR_FILE with a message without a name: it cannot be started, or is not of this build. */
static stilb_result import_run(scene_importer *importer)
{
	char program[PATH_MAX + 64], bytes[32], seconds[32], version[64];
	int ends[2], passed;
	if (!import_find(program))
		return stilb_fail(STILB_ERROR_FILE, "the program that reads files of others, " SCENE_IMPORTER
		                                    ", is neither beside this one nor in ../lib/stilb");
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
		return STILB_OK; /* one that said nothing at all is found out by its end */
	if (passed >= 0)
		close(passed);
	importer->protection = hello.flags;
	if (hello.kind != SCENE_MESSAGE_HELLO || strcmp(hello.text, version) != 0)
		return stilb_fail(STILB_ERROR_FILE, "%s is of another build; install both together", program);
	return STILB_OK;
}

/* Ends it if it still runs. Its wait status, or -1 when somebody else has taken it. */
static int import_end(scene_importer *importer)
{
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
	return importer->protection;
}

/* ---- limits and refusals ----------------------------------------------------------------------------------------- */

#define SCENE_IMPORT_BYTES (8ull << 30)

scene_import_limits scene_import_limits_default(void)
{
	const char *text = getenv("STILB_IMPORT_SECONDS");
	double seconds = text ? strtod(text, NULL) : 0.0;
	uint64_t memory = (uint64_t)sysconf(_SC_PHYS_PAGES) * (uint64_t)sysconf(_SC_PAGESIZE);
	return (scene_import_limits){
		.bytes = memory / 4 * 3 < SCENE_IMPORT_BYTES ? memory / 4 * 3 : SCENE_IMPORT_BYTES,
		.seconds = seconds > 0.0 && seconds < 1e6 ? seconds : 120.0,
	};
}

/* A descriptor of the file that somebody asked for, or -1 with *result and its message. */
static int import_open(const char *path, stilb_result *result)
{
	struct stat info;
	int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY); /* a pipe or a device may have no end */
	*result = STILB_ERROR_ARGUMENT;
	if (file < 0 || fstat(file, &info) != 0)
		stilb_fail(STILB_ERROR_ARGUMENT, "cannot read '%s': %s", path, strerror(errno));
	else if (!S_ISREG(info.st_mode))
		stilb_fail(STILB_ERROR_ARGUMENT, "cannot read '%s': it is %s", path,
		           S_ISDIR(info.st_mode) ? "a folder, not a file" : "not a regular file");
	else
		*result = STILB_OK;
	if (*result == STILB_OK)
		return file;
	if (file >= 0)
		close(file);
	return -1;
}

/* The end of a process that sent no end of its own. decoder: what read the file. */
static stilb_result import_died(const scene_importer *importer, const char *path, const char *decoder, int status)
{
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
	if (WIFSIGNALED(status)) /* the libraries abort where a constructor of theirs finds no memory or thread */
		return stilb_fail(STILB_ERROR_FILE, "cannot read '%s': %s crashed on it (%s); the file is damaged%s", path,
		                  decoder, strsignal(WTERMSIG(status)),
		                  WTERMSIG(status) == SIGABRT ? ", or there is too little memory or too few threads" : "");
	return stilb_fail(STILB_ERROR_FILE, "cannot read '%s': its import ended early (exit status %d)", path,
	                  WIFEXITED(status) ? WEXITSTATUS(status) : -1);
}

/* ---- requests ---------------------------------------------------------------------------------------------------- */

/* One request, while it runs. */
typedef struct import_request {
	scene_importer *importer;
	const char *path;
	scene_files *files; /* NULL: it may open none but its own */
	stilb_image *pictures;
	uint32_t picture_count, picture_room;
	bool told;           /* it ended with an end of its own, well or not */
	char refused[8][64]; /* last parts of names that were told as refused: Assimp asks more than once */
	uint32_t refused_count;
} import_request;

static void import_free(import_request *request)
{
	for (uint32_t i = 0; i < request->picture_count; i++)
		stilb_image_finish(&request->pictures[i]);
	free(request->pictures);
}

/* Starts the process if the last file ended it, and sends the request. */
static stilb_result import_ask(import_request *request, scene_message_kind kind, int file)
{
	scene_importer *importer = request->importer;
	stilb_result result = importer->id > 0 ? STILB_OK : import_run(importer);
	if (result != STILB_OK)
		return result;
	import_begin(importer);
	scene_message message = {.kind = kind};
	snprintf(message.text, sizeof message.text, "%s", request->path);
	scene_stream_write_message(importer->stream.file, &message, file); /* one that is gone is found out by listening */
	return STILB_OK;
}

/* Tells once that a file is refused. One letter is no name, but how Assimp 5.2 looks for it in other places. */
static void import_tell_refused(import_request *request, const char *name, const char *why)
{
	uint32_t most = sizeof request->refused / sizeof *request->refused;
	const char *slash = strrchr(name, '/'), *last = slash ? slash + 1 : name;
	size_t prefix = strlen(request->files->prefix);
	for (uint32_t i = 0; i < request->refused_count; i++)
		if (strncmp(request->refused[i], last, sizeof *request->refused - 1) == 0)
			return;
	if (strlen(last) < 2 || request->refused_count == most)
		return;
	snprintf(request->refused[request->refused_count++], sizeof *request->refused, "%.*s",
	         (int)sizeof *request->refused - 1, last);
	if (strncmp(name, request->files->prefix, prefix) == 0)
		name += prefix;
	stilb_log("%s: '%s' is not read: %s", request->path, name, why);
}

/* Answers an OPEN. What is refused is told here unless the process tells it, which it does of textures. */
static void import_answer(import_request *request, const scene_message *asked)
{
	scene_message answer = {.kind = SCENE_MESSAGE_FILE};
	char why[256] = "there is no such file";
	int file = request->files ? scene_files_open(request->files, asked->text, why) : -1;
	if (file < 0)
		snprintf(answer.text, sizeof answer.text, "%s", why);
	if (file < 0 && scene_files_outside(why) && !asked->flags)
		import_tell_refused(request, asked->text, why);
	scene_stream_write_message(request->importer->stream.file, &answer, file);
	if (file >= 0)
		close(file);
}

static stilb_result import_keep_picture(import_request *request, const scene_message *message, int file)
{
	if (request->picture_count == request->picture_room) {
		uint32_t room = 2 * request->picture_room + 16;
		stilb_image *more = realloc(request->pictures, room * sizeof *more);
		if (!more || room > STILB_SCENE_MAX_MODELS) {
			request->pictures = more ? more : request->pictures;
			if (file >= 0)
				close(file);
			return stilb_fail(STILB_ERROR_MEMORY, "no memory for its pictures");
		}
		request->pictures = more;
		request->picture_room = room;
	}
	stilb_image *picture = &request->pictures[request->picture_count];
	stilb_result result = scene_stream_take_picture(&request->importer->stream, message, file, picture);
	request->picture_count += result == STILB_OK;
	return result;
}

/* Listens up to an end: `end`, or an error. STILB_ERROR_FILE and not told: the process is gone. */
static stilb_result import_listen(import_request *request, scene_message_kind end, scene_message *message)
{
	int passed;
	stilb_result result = STILB_OK;
	while (result == STILB_OK && scene_stream_read_message(&request->importer->stream, message, &passed)) {
		if (message->kind == SCENE_MESSAGE_PICTURE) {
			result = import_keep_picture(request, message, passed);
			passed = -1;
		} else if (message->kind == SCENE_MESSAGE_OPEN) {
			import_answer(request, message);
		} else if (message->kind == SCENE_MESSAGE_WARNING) {
			stilb_log("%s: %s", request->path, message->text);
		}
		if (passed >= 0)
			close(passed);
		request->told = message->kind == SCENE_MESSAGE_ERROR;
		if (request->told)
			return stilb_fail(message->result == STILB_ERROR_MEMORY ? STILB_ERROR_MEMORY : STILB_ERROR_FILE,
			                  "cannot read '%s': %s", request->path, message->text);
		if (result == STILB_OK && message->kind == end)
			return STILB_OK;
	}
	return result == STILB_OK ? STILB_ERROR_FILE : result;
}

/* The result of a request with its message. A process that is gone or no longer understood is ended. */
static stilb_result import_finish(import_request *request, stilb_result result, const char *decoder)
{
	scene_importer *importer = request->importer;
	if (result == STILB_OK || request->told)
		return result;
	bool gone = importer->stream.late || importer->stream.ended || importer->stream.too_much;
	char reason[400];
	snprintf(reason, sizeof reason, "%s", stilb_error_message());
	int status = importer->id > 0 ? import_end(importer) : 0;
	if (gone)
		return import_died(importer, request->path, decoder, status);
	return stilb_fail(result, "cannot read '%s': %s", request->path, reason);
}

stilb_result scene_importer_scene(scene_importer *importer, const char *path, stilb_scene **scene)
{
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
		result = import_finish(&request, result, "Assimp");
		scene_files_finish(&files);
	}
	import_free(&request);
	close(file);
	return result;
}

stilb_result scene_importer_picture(scene_importer *importer, const char *path, bool light, stilb_image *image)
{
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
	result = import_finish(&request, result, "the decoder");
	if (result == STILB_OK) {
		*image = request.pictures[0];
		request.pictures[0] = (stilb_image){0};
	}
	import_free(&request);
	close(file);
	return result;
}

/* ---- one request, one process ------------------------------------------------------------------------------------ */

stilb_result scene_import_within(const char *path, const scene_import_limits *limits, stilb_scene **scene)
{
	scene_importer *importer;
	stilb_result result;
	*scene = NULL;
	int file = import_open(path, &result); /* the better reason, if there are two */
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
	if (result == STILB_OK) {
		stilb_image_finish(&scene->environment);
		scene->environment = map;
	}
	return result;
}

/* "NAME VERSION" lines: the version of name. */
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
	scene_import_limits limits = {.bytes = 8ull << 30, .seconds = 10.0};
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
