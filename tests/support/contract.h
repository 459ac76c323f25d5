/* Violations of contracts, planted: each must end the program with SIGABRT and the assert's text. For tests that
 * stilb_contract_test registers. */
#ifndef SUPPORT_CONTRACT_H
#define SUPPORT_CONTRACT_H

#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

/* In the child: stderr goes into the pipe, cmocka's handlers and core files are off. */
static inline void contract_child(int out)
{
	dup2(out, STDERR_FILENO);
	close(out);
	for (int number = 1; number < 32; number++)
		signal(number, SIG_DFL);
	setrlimit(RLIMIT_CORE, &(struct rlimit){0, 0});
	alarm(60); /* against a hang alone */
}

/* Reads what the child wrote to stderr and waits for it. True if it died by SIGABRT and the text stands in that. */
static inline bool contract_died(pid_t child, int in, const char *text, const char *statement)
{
	char said[4096];
	size_t length = 0;
	for (ssize_t got; (got = read(in, said + length, sizeof said - 1 - length)) > 0;)
		length += (size_t)got;
	said[length] = '\0';
	close(in);
	int status = 0;
	waitpid(child, &status, 0);
	if (WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT && strstr(said, text))
		return true;
	printf("%s\n  must abort and say: %s\n  status %#x, said: %s\n", statement, text, (unsigned)status, said);
	return false;
}

/* contract_breaks("index < count", call(7)): runs the statement in a child process. The test fails unless it aborts
 * with the text. The statement must not need threads that the parent has started. */
#define contract_breaks(text, statement)                                                                               \
	do {                                                                                                               \
		int contract_pipe[2];                                                                                          \
		assert_int_equal(pipe(contract_pipe), 0);                                                                      \
		fflush(NULL);                                                                                                  \
		pid_t contract_pid = fork();                                                                                   \
		assert_true(contract_pid >= 0);                                                                                \
		if (contract_pid == 0) {                                                                                       \
			close(contract_pipe[0]);                                                                                   \
			contract_child(contract_pipe[1]);                                                                          \
			(void)(statement);                                                                                         \
			_exit(0);                                                                                                  \
		}                                                                                                              \
		close(contract_pipe[1]);                                                                                       \
		assert_true(contract_died(contract_pid, contract_pipe[0], text, #statement));                                  \
	} while (0)

#endif
