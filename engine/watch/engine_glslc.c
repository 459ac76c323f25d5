/* glslc as a child process: what it writes goes to files in memory, so that nobody has to read while it runs. */
#include "watch/engine_watch.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#define GLSLC_AT_ONCE 8u
#define GLSLC_LOOK_MS 5 /* between two looks whether one has ended */
#define GLSLC_ARGUMENTS 64u

extern char **environ;

/* One that runs; pid 0: none. */
typedef struct glslc_child {
	pid_t pid;
	int code, text; /* files in memory: SPIR-V, and messages */
} glslc_child;

bool engine_glslc_is_there(void)
{
	const char *path = getenv("PATH");
	char program[PATH_MAX];
	for (const char *end; path && *path; path = *end ? end + 1 : end) {
		end = strchrnul(path, ':');
		if (snprintf(program, sizeof program, "%.*s/glslc", (int)(end - path), path) < (int)sizeof program &&
		    access(program, X_OK) == 0)
			return true;
	}
	return false;
}

/* Cuts a list of words apart. Returns how many there are, or 0 if they are more than `most`. */
static uint32_t glslc_words(char *list, char **words, uint32_t most)
{
	uint32_t count = 0;
	char *rest = NULL;
	for (char *word = strtok_r(list, " ", &rest); word; word = strtok_r(NULL, " ", &rest)) {
		if (count == most)
			return 0;
		words[count++] = word;
	}
	return count;
}

/* Signals are as in a program that has just started: threads of the engine's block them all. */
static int glslc_attributes(posix_spawnattr_t *attributes)
{
	sigset_t none, all;
	sigemptyset(&none);
	sigfillset(&all);
	int error = posix_spawnattr_init(attributes);
	if (error != 0)
		return error;
	posix_spawnattr_setsigmask(attributes, &none);
	posix_spawnattr_setsigdefault(attributes, &all);
	return posix_spawnattr_setflags(attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
}

/* Starts it; 0, or an errno. */
static int glslc_spawn(char *const *arguments, const char *folder, glslc_child *child)
{
	posix_spawn_file_actions_t actions;
	posix_spawnattr_t attributes;
	int error = glslc_attributes(&attributes);
	if (error != 0)
		return error;
	error = posix_spawn_file_actions_init(&actions);
	if (error == 0) {
		posix_spawn_file_actions_addchdir_np(&actions, folder);
		posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
		posix_spawn_file_actions_adddup2(&actions, child->code, 1);
		posix_spawn_file_actions_adddup2(&actions, child->text, 2);
		posix_spawn_file_actions_addclosefrom_np(&actions, 3);
		error = posix_spawnp(&child->pid, arguments[0], &actions, &attributes, arguments, environ);
		posix_spawn_file_actions_destroy(&actions);
	}
	posix_spawnattr_destroy(&attributes);
	if (error != 0)
		child->pid = 0;
	return error;
}

static void glslc_start(engine_glslc *shader, const char *folder, glslc_child *child)
{
	char flags[] = STILB_GLSLC_FLAGS, *arguments[GLSLC_ARGUMENTS + 5] = {"glslc"};
	char *definitions = strdup(shader->definitions);
	uint32_t count = 1 + glslc_words(flags, arguments + 1, GLSLC_ARGUMENTS / 2);
	if (definitions)
		count += glslc_words(definitions, arguments + count, GLSLC_ARGUMENTS / 2);
	arguments[count++] = "-o";
	arguments[count++] = "-";
	arguments[count++] = (char *)shader->file;
	child->code = memfd_create("SPIR-V", MFD_CLOEXEC);
	child->text = memfd_create("messages of glslc", MFD_CLOEXEC);
	int error = !definitions                         ? ENOMEM
	            : child->code < 0 || child->text < 0 ? errno
	                                                 : glslc_spawn(arguments, folder, child);
	if (error == ENOENT && access(folder, X_OK) == 0)
		shader->message = strdup(ENGINE_GLSLC_MISSING);
	else if (error != 0 && asprintf(&shader->message, "cannot start glslc in '%s': %s", folder, strerror(error)) < 0)
		shader->message = NULL;
	free(definitions);
}

/* The bytes of a file in memory, and a 0 behind them; NULL: no memory. */
static char *glslc_read(int file, size_t *bytes)
{
	struct stat info = {0};
	*bytes = fstat(file, &info) == 0 ? (size_t)info.st_size : 0;
	char *read = malloc(*bytes + 1);
	if (!read || pread(file, read, *bytes, 0) != (ssize_t)*bytes) {
		free(read);
		return NULL;
	}
	read[*bytes] = '\0';
	return read;
}

/* Takes what an ended child has left. */
static void glslc_take(engine_glslc *shader, const glslc_child *child, int status)
{
	size_t length;
	shader->message = glslc_read(child->text, &length);
	if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
		shader->words = (uint32_t *)(void *)glslc_read(child->code, &shader->bytes);
		return;
	}
	if (shader->message && length > 0)
		return;
	free(shader->message);
	if (asprintf(&shader->message, "%s: glslc ended with %s %d, and said nothing", shader->file,
	             WIFSIGNALED(status) ? "signal" : "code",
	             WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status)) < 0)
		shader->message = NULL;
}

static void glslc_close(glslc_child *child)
{
	if (child->code >= 0)
		close(child->code);
	if (child->text >= 0)
		close(child->text);
	*child = (glslc_child){.code = -1, .text = -1};
}

/* Takes in those that have ended, and returns how many still run. */
static uint32_t glslc_gather(engine_glslc *shaders, glslc_child *children, uint32_t count)
{
	uint32_t running = 0;
	for (uint32_t c = 0; c < count; c++) {
		int status = 0;
		if (children[c].pid == 0)
			continue;
		pid_t ended = waitpid(children[c].pid, &status, WNOHANG);
		if (ended == 0) {
			running++;
			continue;
		}
		/* A program that ignores SIGCHLD loses how it ended: then what it wrote tells. */
		if (ended < 0 && errno == ECHILD && lseek(children[c].code, 0, SEEK_END) == 0)
			status = W_EXITCODE(1, 0);
		glslc_take(&shaders[c], &children[c], status);
		children[c].pid = 0;
	}
	return running;
}

bool engine_glslc_run(engine_glslc *shaders, uint32_t count, const char *folder, int end)
{
	struct pollfd ends = {.fd = end, .events = POLLIN};
	bool ended = false;
	for (uint32_t first = 0; first < count && !ended; first += GLSLC_AT_ONCE) {
		uint32_t many = count - first < GLSLC_AT_ONCE ? count - first : GLSLC_AT_ONCE;
		glslc_child children[GLSLC_AT_ONCE];
		for (uint32_t c = 0; c < many; c++) {
			children[c] = (glslc_child){.code = -1, .text = -1};
			glslc_start(&shaders[first + c], folder, &children[c]);
		}
		while (glslc_gather(shaders + first, children, many) > 0 && !ended)
			ended = poll(&ends, 1, GLSLC_LOOK_MS) > 0;
		for (uint32_t c = 0; c < many; c++) {
			if (children[c].pid > 0) {
				kill(children[c].pid, SIGKILL);
				waitpid(children[c].pid, NULL, 0);
			}
			glslc_close(&children[c]);
		}
	}
	return !ended;
}
