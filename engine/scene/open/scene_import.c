#include "scene/open/scene_import.h"

#include "scene/open/scene_stream.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <limits.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

/* ---- the other process ------------------------------------------------------------------------------------------- */

typedef struct import_process {
	pid_t id;
	scene_stream stream; /* what it says */
} import_process;

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

/* Starts it with its end of the pipe as standard output. 0, or an errno. */
static int import_spawn(const char *program, const char *const arguments[], int out, pid_t *id)
{
	posix_spawn_file_actions_t actions;
	posix_spawnattr_t attributes;
	sigset_t none;
	sigemptyset(&none);
	int error = posix_spawn_file_actions_init(&actions);
	if (error)
		return error;
	error = posix_spawnattr_init(&attributes);
	if (!error) {
		posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
		posix_spawn_file_actions_adddup2(&actions, out, STDOUT_FILENO);
		posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
		posix_spawnattr_setsigmask(&attributes, &none); /* a mask of ours could keep a signal from ending it */
		error = posix_spawn(id, program, &actions, &attributes, (char *const *)arguments, environ);
		posix_spawnattr_destroy(&attributes);
	}
	posix_spawn_file_actions_destroy(&actions);
	return error;
}

/* STILB_ERROR_FILE with a message without a name: it cannot be started, or is not of this build. */
static stilb_result import_start(const char *path, const scene_import_limits *limits, import_process *process)
{
	char program[PATH_MAX + 64], bytes[32], version[64];
	int ends[2];
	if (!import_find(program))
		return stilb_fail(STILB_ERROR_FILE, "the program that reads scene files, " SCENE_IMPORTER
		                                    ", is neither beside this one nor in ../lib/stilb");
	if (pipe2(ends, O_CLOEXEC) != 0)
		return stilb_fail(STILB_ERROR_FILE, "no pipe to " SCENE_IMPORTER ": %s", strerror(errno));
	snprintf(bytes, sizeof bytes, "%" PRIu64, limits->bytes);
	const char *const arguments[] = {SCENE_IMPORTER, bytes, path, NULL};
	int error = import_spawn(program, arguments, ends[1], &process->id);
	close(ends[1]);
	if (error) {
		close(ends[0]);
		return stilb_fail(STILB_ERROR_FILE, "%s cannot be started: %s", program, strerror(error));
	}
	process->stream =
		(scene_stream){.file = ends[0], .deadline_ns = stilb_time_ns() + (uint64_t)(limits->seconds * 1e9)};
	scene_message hello;
	scene_stream_version(version);
	if (scene_stream_read_message(&process->stream, &hello) &&
	    (hello.kind != SCENE_MESSAGE_HELLO || strcmp(hello.text, version) != 0))
		return stilb_fail(STILB_ERROR_FILE, "%s is of another build; install both together", program);
	return STILB_OK; /* one that said nothing at all is found out by its end */
}

/* Ends it if it still runs. Its wait status, or -1 when somebody else has taken it. */
static int import_end(import_process *process, bool kill_it)
{
	int status;
	close(process->stream.file); /* one that still writes is ended by that */
	if (kill_it)
		kill(process->id, SIGKILL);
	while (waitpid(process->id, &status, 0) < 0)
		if (errno != EINTR)
			return -1;
	return status;
}

/* ---- importing --------------------------------------------------------------------------------------------------- */

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

/* Why a name cannot be a scene file. */
static stilb_result import_check(const char *path)
{
	struct stat info;
	if (stat(path, &info) != 0) {
		if (errno == ENOENT)
			return stilb_fail(STILB_ERROR_ARGUMENT, "'%s': no such file, and no built-in scene (%s)", path,
			                  stilb_scene_builtin_names());
		return stilb_fail(STILB_ERROR_ARGUMENT, "cannot read '%s': %s", path, strerror(errno));
	}
	if (!S_ISREG(info.st_mode)) /* a pipe or a device may have no end */
		return stilb_fail(STILB_ERROR_ARGUMENT, "cannot read '%s': it is %s", path,
		                  S_ISDIR(info.st_mode) ? "a folder, not a file" : "not a regular file");
	if (access(path, R_OK) != 0)
		return stilb_fail(STILB_ERROR_ARGUMENT, "cannot read '%s': %s", path, strerror(errno));
	return STILB_OK;
}

/* The end of a process that sent neither a scene nor an error. */
static stilb_result import_died(const char *path, const scene_import_limits *limits, bool late, int status)
{
	if (late)
		return stilb_fail(STILB_ERROR_FILE,
		                  "cannot read '%s': not done after %.0f s; the file is damaged, or give it more time with "
		                  "STILB_IMPORT_SECONDS=N",
		                  path, limits->seconds);
	if (WIFSIGNALED(status) && WTERMSIG(status) == SIGINT)
		return stilb_fail(STILB_ERROR_FILE, "cannot read '%s': interrupted", path);
	if (WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL)
		return stilb_fail(STILB_ERROR_MEMORY, "cannot read '%s': its import was killed, likely for want of memory",
		                  path);
	if (WIFSIGNALED(status))
		return stilb_fail(STILB_ERROR_FILE, "cannot read '%s': Assimp crashed on it (%s); the file is damaged", path,
		                  strsignal(WTERMSIG(status)));
	return stilb_fail(STILB_ERROR_FILE, "cannot read '%s': its import ended early (exit status %d)", path,
	                  WIFEXITED(status) ? WEXITSTATUS(status) : -1);
}

/* Reads what it says up to a scene or an error. *told: the message is the file's. */
static stilb_result import_listen(const char *path, import_process *process, stilb_scene **scene, bool *told)
{
	scene_message message;
	while (scene_stream_read_message(&process->stream, &message)) {
		*told = message.kind == SCENE_MESSAGE_ERROR;
		if (message.kind == SCENE_MESSAGE_ERROR)
			return stilb_fail(message.result == STILB_ERROR_MEMORY ? STILB_ERROR_MEMORY : STILB_ERROR_FILE,
			                  "cannot read '%s': %s", path, message.text);
		if (message.kind == SCENE_MESSAGE_SCENE)
			return scene_stream_read(&process->stream, scene);
		stilb_log("%s: %s", path, message.text);
	}
	return STILB_ERROR_FILE;
}

stilb_result scene_import_within(const char *path, const scene_import_limits *limits, stilb_scene **scene)
{
	import_process process = {0};
	bool told = false;
	*scene = NULL;
	stilb_result result = import_check(path);
	if (result != STILB_OK)
		return result;
	result = import_start(path, limits, &process);
	bool started = process.id > 0, understood = result == STILB_OK;
	if (understood)
		result = import_listen(path, &process, scene, &told);
	bool gone = process.stream.late || process.stream.ended;
	int status = started ? import_end(&process, result != STILB_OK && !process.stream.ended) : 0;
	if (result == STILB_OK || told)
		return result;
	if (understood && gone)
		return import_died(path, limits, process.stream.late, status);
	char reason[400];
	snprintf(reason, sizeof reason, "%s", stilb_error_message());
	return stilb_fail(result, "cannot read '%s': %s", path, reason);
}

stilb_result scene_import(const char *path, stilb_scene **scene)
{
	const scene_import_limits limits = scene_import_limits_default();
	return scene_import_within(path, &limits, scene);
}

const char *stilb_scene_library_version(void)
{
	static scene_message message;
	const scene_import_limits limits = {.bytes = UINT64_MAX, .seconds = 10.0};
	import_process process = {0};
	stilb_result result = import_start("", &limits, &process);
	bool known = result == STILB_OK && scene_stream_read_message(&process.stream, &message) &&
	             message.kind == SCENE_MESSAGE_WARNING;
	if (process.id > 0)
		import_end(&process, !known);
	return known ? message.text : "not found";
}
