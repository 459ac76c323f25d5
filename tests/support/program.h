/* program: runs a program as a user would and keeps what it said, for tests. POSIX; one at a time. */
#ifndef STILB_PROGRAM_H
#define STILB_PROGRAM_H

#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#define PROGRAM_SAID 16384

typedef struct program_run {
	pid_t pid;
	int code; /* exit status; 128 + the signal that killed it */
	FILE *files[2];
	char out[PROGRAM_SAID], err[PROGRAM_SAID];
} program_run;

/* Starts words[0] with the arguments after it, up to NULL. Each of environment, up to NULL, is NAME=VALUE, or NAME to
 * take it away. output, when not -1, is the descriptor that standard output is instead of run->out. */
static inline bool program_start(program_run *run, const char *const *words, const char *const *environment, int output)
{
	*run = (program_run){.code = -1, .files = {tmpfile(), tmpfile()}};
	if (!run->files[0] || !run->files[1])
		return false;
	fflush(NULL);
	run->pid = fork();
	if (run->pid != 0)
		return run->pid > 0;
	if (dup2(output < 0 ? fileno(run->files[0]) : output, STDOUT_FILENO) < 0 ||
	    dup2(fileno(run->files[1]), STDERR_FILENO) < 0)
		_exit(126);
	for (; environment && *environment; environment++) {
		if (strchr(*environment, '='))
			putenv((char *)(uintptr_t)*environment);
		else
			unsetenv(*environment);
	}
	execv(words[0], (char **)(uintptr_t)words);
	_exit(127);
}

/* Waits for the program's end and reads what it wrote to out and err. */
static inline void program_wait(program_run *run)
{
	int status = 0;
	while (waitpid(run->pid, &status, 0) < 0)
		continue;
	run->code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
	char *const texts[2] = {run->out, run->err};
	for (int i = 0; i < 2; i++) {
		rewind(run->files[i]);
		texts[i][fread(texts[i], 1, PROGRAM_SAID - 1, run->files[i])] = '\0';
		fclose(run->files[i]);
	}
}

/* Lines in text, each ended. */
static inline int program_lines(const char *text)
{
	int lines = 0;
	for (; (text = strchr(text, '\n')); text++)
		lines++;
	return lines;
}

#endif
