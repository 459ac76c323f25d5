/* The things that the import process must not do, tried in a process that has entered its sandbox. */
#include "scene/importer/importer_sandbox.h"
#include "scene/open/scene_stream.h"
#include "support/test.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/landlock.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

static void *thread_body(void *context)
{
	return context;
}

/* Tries one thing. Returns 0 or the errno of its failure. */
typedef int attempt(void);

static int result_of(long value)
{
	return value < 0 ? errno : 0;
}

static int read_passwd(void)
{
	return result_of(open("/etc/passwd", O_RDONLY));
}
static int write_file(void)
{
	return result_of(open("/tmp/stilb-sandbox-test", O_WRONLY | O_CREAT, 0600));
}
static int list_root(void)
{
	return result_of(open("/", O_RDONLY | O_DIRECTORY));
}
static int read_library(void)
{
	return result_of(open("/usr/lib", O_RDONLY | O_DIRECTORY));
}
static int open_socket(void)
{
	return result_of(socket(AF_INET, SOCK_STREAM, 0));
}
static int open_local_socket(void)
{
	return result_of(socket(AF_UNIX, SOCK_STREAM, 0));
}
static int kill_parent(void)
{
	return result_of(kill(getppid(), 0));
}
static int signal_parent(void)
{
	return result_of(syscall(SYS_tgkill, getppid(), getppid(), 0));
}
static int signal_self(void)
{
	return result_of(syscall(SYS_tgkill, getpid(), getpid(), 0));
}
static int trace_parent(void)
{
	return result_of(ptrace(PTRACE_ATTACH, getppid(), NULL, NULL));
}
static int make_memory(void)
{
	return result_of(memfd_create("x", MFD_CLOEXEC));
}

static int make_process(void)
{
	pid_t id = fork();
	if (id == 0)
		_exit(0);
	return result_of(id);
}

static int run_program(void)
{
	char *const arguments[] = {"true", NULL}, *const none[] = {NULL};
	return result_of(execve("/bin/true", arguments, none));
}

static int make_thread(void)
{
	pthread_t thread;
	int error = pthread_create(&thread, NULL, thread_body, NULL);
	return error ? error : pthread_join(thread, NULL);
}

static int raise_limit(void)
{
	return result_of(setrlimit(RLIMIT_NOFILE, &(struct rlimit){16, 16}));
}

static int write_much(void)
{
	signal(SIGXFSZ, SIG_IGN);
	int file = memfd_create("x", MFD_CLOEXEC);
	return result_of(ftruncate(file, 1LL << 40));
}

enum { FREE, FILES = SCENE_PROTECTION_LANDLOCK, CALLS = SCENE_PROTECTION_SECCOMP, LIMITS = SCENE_PROTECTION_LIMITS };

static const struct {
	const char *name;
	attempt *try;
	uint32_t guard; /* the protection that forbids it; FREE: it is allowed */
	int error;
} attempts[] = {
	{"open /etc/passwd", read_passwd, FILES, EACCES},
	{"create a file", write_file, FILES, EACCES},
	{"list /", list_root, FILES, EACCES},
	{"open the libraries", read_library, FREE, 0},
	{"make a socket", open_socket, CALLS, EPERM},
	{"make a local socket", open_local_socket, CALLS, EPERM},
	{"kill the parent", kill_parent, CALLS, EPERM},
	{"signal the parent", signal_parent, CALLS, EPERM},
	{"signal itself", signal_self, FREE, 0},
	{"trace the parent", trace_parent, CALLS, EPERM},
	{"make a process", make_process, CALLS, EPERM},
	{"run a program", run_program, CALLS, EPERM},
	{"set a limit", raise_limit, CALLS, EPERM},
	{"make memory", make_memory, FREE, 0},
	{"make a thread", make_thread, FREE, 0},
	{"make a large file", write_much, LIMITS, EFBIG},
};

#define ATTEMPTS (sizeof attempts / sizeof *attempts)

/* The protections that this kernel must have. */
static uint32_t kernel_has(void)
{
	uint32_t flags = SCENE_PROTECTION_PRIVILEGES | SCENE_PROTECTION_LIMITS;
	if (syscall(SYS_landlock_create_ruleset, NULL, 0, LANDLOCK_CREATE_RULESET_VERSION) >= 1)
		flags |= SCENE_PROTECTION_LANDLOCK;
	if (prctl(PR_GET_SECCOMP) >= 0)
		flags |= SCENE_PROTECTION_SECCOMP;
	return flags;
}

/* Every attempt is made in its own process in the sandbox. */
static void the_sandbox_holds(void **state)
{
	(void)state;
	for (size_t i = 0; i < ATTEMPTS; i++) {
		int status, pipes[2];
		uint32_t flags = 0;
		assert_int_equal(pipe(pipes), 0);
		pid_t id = fork();
		if (id == 0) {
			flags = importer_sandbox_enter(8ull << 30);
			if (write(pipes[1], &flags, sizeof flags) != sizeof flags)
				_exit(255);
			_exit(attempts[i].try());
		}
		close(pipes[1]);
		assert_int_equal(read(pipes[0], &flags, sizeof flags), sizeof flags);
		close(pipes[0]);
		assert_int_equal(waitpid(id, &status, 0), id);
		assert_int_equal(flags, kernel_has());
		if (attempts[i].guard != FREE && !(flags & attempts[i].guard)) {
			print_message("%s: this kernel cannot forbid it\n", attempts[i].name);
			continue;
		}
		if (!WIFEXITED(status) || WEXITSTATUS(status) != attempts[i].error)
			fail_msg("%s: status %#x, not error %d", attempts[i].name, (unsigned)status, attempts[i].error);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(the_sandbox_holds)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
