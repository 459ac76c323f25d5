/* One run of a benchmark: starts the program, reads its output, and kills it when it exceeds its limit of CPU time or
 * of wall-clock time. */
#include "bench/harness/bench.h"
#include "bench/harness/bench_child.h"
#include "bench/harness/bench_internal.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

/* The last bytes that a stream delivered, zero-terminated. */
typedef struct text {
	char bytes[4096];
	size_t length;
} text;

/* Reads what is there, and discards old bytes if the buffer is full. False at the end of the stream or on an error. */
static bool text_read(text *t, int descriptor)
{
	if (t->length == sizeof t->bytes - 1) { /* keep the newer half: results and messages come last */
		t->length /= 2;
		memmove(t->bytes, t->bytes + sizeof t->bytes - 1 - t->length, t->length);
	}
	ssize_t got = read(descriptor, t->bytes + t->length, sizeof t->bytes - 1 - t->length);
	if (got > 0)
		t->length += (size_t)got;
	t->bytes[t->length] = '\0';
	return got > 0 || (got < 0 && errno == EINTR);
}

static void text_last_line(const text *t, char *line, size_t size)
{
	size_t end = t->length;
	while (end > 0 && t->bytes[end - 1] == '\n')
		end--;
	size_t start = end;
	while (start > 0 && t->bytes[start - 1] != '\n')
		start--;
	snprintf(line, size, "%.*s", (int)(end - start), t->bytes + start);
}

bool bench_program_path(const char *program, char *path, size_t size)
{
	char self[PATH_MAX];
	ssize_t length = readlink("/proc/self/exe", self, sizeof self - 1);
	if (length < 0)
		return false;
	self[length] = '\0';
	int folder = (int)(strrchr(self, '/') - self);
	return snprintf(path, size, "%.*s/%s", folder, self, program) < (int)size && access(path, X_OK) == 0;
}

/* Turns the forked process into the program. Does not return. */
static void become(const char *path, char *const *argv, const int out[2], const int error[2], rlim_t cpu_seconds)
{
	struct rlimit cpu = {cpu_seconds, cpu_seconds + 1}; /* SIGXCPU at the limit, SIGKILL one second of CPU time later */
	setrlimit(RLIMIT_CPU, &cpu);
	prctl(PR_SET_PDEATHSIG, SIGKILL); /* if stilb-bench dies, the kernel kills the program, too */
	signal(SIGPIPE, SIG_DFL);
	int nothing = open("/dev/null", O_RDONLY);
	dup2(nothing, STDIN_FILENO);
	dup2(out[1], STDOUT_FILENO);
	dup2(error[1], STDERR_FILENO);
	execv(path, argv);
	fprintf(stderr, "cannot start %s: %s\n", path, strerror(errno));
	_exit(127);
}

/* Starts the program with pipes as stdout and stderr: *out and *error are their ends to read. Returns the process id,
 * or -1 with errno; then nothing is open. */
static pid_t start(const char *path, char *const *argv, rlim_t cpu_seconds, int *out, int *error)
{
	int outs[2], errors[2];
	if (pipe2(outs, O_CLOEXEC) != 0)
		return -1;
	if (pipe2(errors, O_CLOEXEC) != 0) {
		close(outs[0]), close(outs[1]);
		return -1;
	}
	fflush(NULL); /* else the child would flush our buffers a second time */
	pid_t child = fork();
	if (child == 0)
		become(path, argv, outs, errors, cpu_seconds);
	close(outs[1]), close(errors[1]);
	*out = outs[0], *error = errors[0];
	if (child < 0)
		close(outs[0]), close(errors[0]);
	return child;
}

/* Reads both streams to their ends. False: the deadline passed first. */
static bool collect(int out, int error, text *outs, text *errors, uint64_t deadline_ns)
{
	struct pollfd streams[2] = {{.fd = out, .events = POLLIN}, {.fd = error, .events = POLLIN}};
	text *texts[2] = {outs, errors};
	while (streams[0].fd >= 0 || streams[1].fd >= 0) {
		uint64_t now = bench_child_now_ns();
		if (now >= deadline_ns)
			return false;
		poll(streams, 2, (int)((deadline_ns - now) / 1000000 + 1));
		for (int i = 0; i < 2; i++)
			if (streams[i].fd >= 0 && streams[i].revents != 0 && !text_read(texts[i], streams[i].fd))
				streams[i].fd = -1;
	}
	return true;
}

/* Parses lines "metric value". False if a line is something else, if there are too many, or none. */
static bool parse_values(const char *lines, bench_child_result *result)
{
	int taken = 0;
	for (; *lines; lines += taken) {
		if (result->value_count == BENCH_CHILD_VALUES)
			return false;
		size_t i = result->value_count++;
		if (sscanf(lines, "%47s %lf%n", result->values[i].metric, &result->values[i].value, &taken) != 2 ||
		    lines[taken++] != '\n')
			return false;
	}
	return result->value_count > 0;
}

/* Fills state, message and values from the exit status and the two streams. */
static void judge(int status, const text *outs, const text *errors, bench_child_result *result)
{
	text_last_line(errors, result->message, sizeof result->message);
	if (WIFEXITED(status) && WEXITSTATUS(status) == BENCH_CHILD_SKIP) {
		result->state = BENCH_CHILD_SKIPPED;
	} else if (WIFEXITED(status) && WEXITSTATUS(status) == 0 && parse_values(outs->bytes, result)) {
		result->state = BENCH_CHILD_DONE;
	} else {
		result->state = BENCH_CHILD_FAILED;
		if (WIFSIGNALED(status))
			snprintf(result->message, sizeof result->message, "killed by signal %d (%s)", WTERMSIG(status),
			         strsignal(WTERMSIG(status)));
		else if (!result->message[0])
			snprintf(result->message, sizeof result->message, "exit status %d, without a reason; its output: %.100s",
			         WEXITSTATUS(status), outs->bytes);
	}
}

/* CPU time of the machine since boot, in kernel ticks, and the part that the hypervisor gave to others (steal). */
typedef struct cpu_ticks {
	uint64_t all, stolen;
} cpu_ticks;

static cpu_ticks read_cpu_ticks(void)
{
	cpu_ticks ticks = {0, 0};
	FILE *stat = fopen("/proc/stat", "re");
	if (!stat)
		return ticks;
	unsigned long long column[8] = {0};
	if (fscanf(stat, "cpu %llu %llu %llu %llu %llu %llu %llu %llu", &column[0], &column[1], &column[2], &column[3],
	           &column[4], &column[5], &column[6], &column[7]) == 8) {
		for (int i = 0; i < 8; i++)
			ticks.all += column[i];
		ticks.stolen = column[7];
	}
	fclose(stat);
	return ticks;
}

void bench_child_run(const char *program, const char *subject, const char *case_name, double seconds, uint32_t round,
                     const char *argument, bench_limit limit, bench_child_result *result)
{
	STILB_ASSERT(program && !strchr(program, '/') && subject && case_name && result);
	STILB_ASSERT(seconds >= 0.0 && limit.cpu_seconds > 0.0 && limit.seconds > 0.0);
	*result = (bench_child_result){.state = BENCH_CHILD_FAILED};
	char path[PATH_MAX], length[32], number[16];
	if (!bench_program_path(program, path, sizeof path)) {
		snprintf(result->message, sizeof result->message,
		         "%s is not in the folder of stilb-bench; build the target stilb-bench-programs", program);
		return;
	}
	snprintf(length, sizeof length, "%.6f", seconds);
	snprintf(number, sizeof number, "%u", round);
	/* execv's parameter is not const for historical reasons; it does not write to the strings. */
	char *argv[] = {path, (char *)subject, (char *)case_name, length, number, (char *)argument, NULL};

	text outs = {.length = 0}, errors = {.length = 0};
	int out, error, status = 0;
	cpu_ticks before = read_cpu_ticks();
	uint64_t begin = bench_child_now_ns();
	pid_t child = start(path, argv, (rlim_t)ceil(limit.cpu_seconds), &out, &error);
	if (child < 0) {
		snprintf(result->message, sizeof result->message, "cannot start %s: %s", program, strerror(errno));
		return;
	}
	bool in_time = collect(out, error, &outs, &errors, begin + (uint64_t)(limit.seconds * 1e9));
	if (!in_time)
		kill(child, SIGKILL);
	close(out), close(error);
	struct rusage usage = {0};
	while (wait4(child, &status, 0, &usage) < 0 && errno == EINTR) {
	}
	result->seconds = (double)(bench_child_now_ns() - begin) * 1e-9;
	cpu_ticks after = read_cpu_ticks();
	result->peak_mb = (double)usage.ru_maxrss / 1024.0;
	if (after.all > before.all)
		result->steal = 100.0 * (double)(after.stolen - before.stolen) / (double)(after.all - before.all);
	bool spent = in_time && WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU;
	if (in_time && !spent) {
		judge(status, &outs, &errors, result);
		return;
	}
	result->state = BENCH_CHILD_TIMED_OUT;
	snprintf(result->message, sizeof result->message, "no result after %.0f s%s, killed",
	         spent ? ceil(limit.cpu_seconds) : limit.seconds, spent ? " of CPU time" : "");
}
