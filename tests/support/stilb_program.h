/* stilb_program: what the tests of the program stilb share: a folder of their own, runs, and the files it writes. */
#ifndef STILB_STILB_PROGRAM_H
#define STILB_STILB_PROGRAM_H

#include "json_flat.h"
#include "support/program.h"
#include "support/test.h"
#include "trace_check.h"

#include <dirent.h>
#include <errno.h>
#include <limits.h>
#include <stdarg.h>
#include <stddef.h>
#include <sys/stat.h>
#include <time.h>

static char stilb_path[PATH_MAX], stilb_folder[PATH_MAX];
static program_run run;
static json_flat stats;

#define NO_DISPLAY "DISPLAY", "WAYLAND_DISPLAY"
#define NO_DRIVER "VK_DRIVER_FILES=/nonexistent/x.json", "VK_ICD_FILENAMES=/nonexistent/x.json"

static const char *const no_display[] = {NO_DISPLAY, NULL};
static const char *const no_driver[] = {NO_DISPLAY, NO_DRIVER, NULL};

/* Starts stilb with the words of one line, split at blanks; {} stands for an empty word. */
static inline void stilb_start(const char *const *environment, int output, const char *line)
{
	char copy[2048], *rest = NULL;
	const char *words[64] = {stilb_path};
	snprintf(copy, sizeof copy, "%s", line);
	size_t count = 1;
	for (char *word = strtok_r(copy, " ", &rest); word && count < 63; word = strtok_r(NULL, " ", &rest))
		words[count++] = strcmp(word, "{}") == 0 ? "" : word;
	assert_true(program_start(&run, words, environment, output));
}

static inline int stilb_code(const char *const *environment, const char *line)
{
	stilb_start(environment, -1, line);
	program_wait(&run);
	return run.code;
}

/* Takes out the lines of progress that a render prints every ten seconds: they tell of a busy machine, not of a
 * fault. */
static inline void forget_progress(char *text)
{
	for (char *line = text; *line;) {
		char *end = strchr(line, '\n');
		end = end ? end + 1 : line + strlen(line);
		char *percent = strstr(line, " %, "); /* "12 %, pass 3, ...", or of ranks "12 %, units, ..." */
		if (*line >= '0' && *line <= '9' && percent && percent < end)
			memmove(line, end, strlen(end) + 1);
		else
			line = end;
	}
}

/* Runs stilb with the words of a line; the run must succeed and print nothing on stderr but lines of progress. */
static inline void stilb_good(const char *format, ...) __attribute__((format(printf, 1, 2)));

static inline void stilb_good(const char *format, ...)
{
	char line[2048];
	va_list arguments;
	va_start(arguments, format);
	vsnprintf(line, sizeof line, format, arguments);
	va_end(arguments);
	int code = stilb_code(no_display, line);
	forget_progress(run.err);
	if (code != 0 || run.err[0])
		print_error("stilb %s\n%s", line, run.err);
	assert_int_equal(code, 0);
	assert_string_equal(run.err, "");
}

/* Asserts that the last run's stderr has that many lines, each of which begins with the program's name. */
static inline void assert_error_lines(int lines)
{
	int begun = strncmp(run.err, "stilb: ", 7) == 0;
	for (const char *at = run.err; (at = strstr(at, "\nstilb: ")); at++)
		begun++;
	if (begun != lines || program_lines(run.err) != lines)
		print_error("%s", run.err);
	assert_int_equal(begun, lines);
	assert_int_equal(program_lines(run.err), lines);
}

static inline void assert_said(const char *text, const char *part)
{
	if (!strstr(text, part))
		print_error("not there: '%s' in\n%s\n", part, text);
	assert_non_null(strstr(text, part));
}

static inline bool same_file(const char *a, const char *b)
{
	FILE *one = fopen(a, "r"), *other = fopen(b, "r");
	assert_true(one && other);
	int x, y;
	do {
		x = getc(one);
		y = getc(other);
	} while (x == y && x != EOF);
	fclose(one);
	fclose(other);
	return x == y;
}

/* True if the file holds a text chunk of this name and text. */
static inline bool says_in_png(const char *path, const char *name, const char *text)
{
	static char data[1 << 20], chunk[256];
	FILE *file = fopen(path, "rb");
	assert_non_null(file);
	size_t size = fread(data, 1, sizeof data, file);
	fclose(file);
	int length = snprintf(chunk, sizeof chunk, "tEXt%s%c%s", name, '\0', text);
	return memmem(data, size, chunk, (size_t)length);
}

static inline int folder_entries(void)
{
	int count = 0;
	DIR *dir = opendir(".");
	assert_non_null(dir);
	for (struct dirent *entry; (entry = readdir(dir));)
		count += strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
	closedir(dir);
	return count;
}

static inline int folder_fresh(void **state)
{
	(void)state;
	DIR *dir = opendir(".");
	for (struct dirent *entry; dir && (entry = readdir(dir));)
		if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0)
			remove(entry->d_name);
	closedir(dir);
	json_flat_finish(&stats);
	return 0;
}

/* Makes a new folder, whose name begins with `name`, the current one. argument: the path of the program stilb. */
static inline bool folder_enter(const char *argument, const char *name)
{
	char parent[PATH_MAX / 2];
	return argument && realpath(argument, stilb_path) && getcwd(parent, sizeof parent) &&
	       snprintf(stilb_folder, sizeof stilb_folder, "%s/%s_XXXXXX", parent, name) > 0 && mkdtemp(stilb_folder) &&
	       chdir(stilb_folder) == 0;
}

static inline int folder_leave(void **state)
{
	folder_fresh(state);
	return chdir("..") == 0 ? rmdir(stilb_folder) : -1;
}

/* ---- what --stats wrote ------------------------------------------------------------------------------------------ */

static inline void read_stats(const char *path)
{
	json_flat_finish(&stats);
	json_flat_file(path, &stats);
	assert_string_equal(stats.error, "");
}

static inline const char *stat_text(const char *path, char kind)
{
	const json_flat_value *value = json_flat_find(&stats, path);
	if (!value)
		print_error("no %s\n", path);
	assert_non_null(value);
	assert_int_equal(value->kind, kind);
	return value->text;
}

static inline long long stat_int(const char *path)
{
	const char *text = stat_text(path, '0');
	assert_null(strpbrk(text, ".eE-"));
	return atoll(text);
}

static inline double stat_ms(const char *path)
{
	const char *text = stat_text(path, '0');
	assert_non_null(strchr(text, '.'));
	return strtod(text, NULL);
}

/* Asserts that the file of --stats tells of a pool that has run loops, and all that was submitted. */
static inline void assert_jobs(void)
{
	static const char *const counts[] = {"jobs.steals", "jobs.loops_helped", "jobs.parks", "jobs.wakes"};
	static const char *const lengths[] = {"jobs.deque", "jobs.high", "jobs.shared", "jobs.low"};
	assert_int_equal(stat_int("jobs.jobs"), stat_int("jobs.submitted"));
	assert_true(stat_int("jobs.slices") > 0);
	assert_true(stat_ms("jobs.spin_ms") >= 0.0);
	for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
		assert_true(stat_int(counts[i]) >= 0);
	for (size_t i = 0; i < sizeof lengths / sizeof *lengths; i++)
		assert_int_equal(stat_int(lengths[i]), 0);
}

/* The stream hash in the file of --stats at this path, which it reads. */
static inline uint64_t stat_hash(const char *path)
{
	read_stats(path);
	const char *text = stat_text("stream_hash", '"');
	assert_int_equal(strlen(text), 16);
	assert_int_equal(strspn(text, "0123456789abcdef"), 16);
	return strtoull(text, NULL, 16);
}

/* Asserts that the file of --stats has the three times of each stage of a frame, ms, in ascending order; presented:
 * the run presented its frames in a window, else the time of that stage is 0. */
static inline void assert_stages(bool presented)
{
	static const char *const stages[] = {"frame", "cull", "record", "ui", "replay", "present"};
	for (size_t i = 0; i < 6; i++) {
		double ms[3];
		static const char *const kinds[] = {"min", "median", "p99"};
		for (int k = 0; k < 3; k++) {
			char path[64];
			snprintf(path, sizeof path, "stages.%s.%s", stages[i], kinds[k]);
			ms[k] = stat_ms(path);
		}
		assert_true(ms[0] >= 0.0 && ms[0] <= ms[1] && ms[1] <= ms[2] && ms[2] < 600000.0);
		assert_true(presented || i < 5 || ms[2] == 0.0);
		assert_true(i > 2 || ms[2] > 0.0); /* frame, cull and record take time anywhere */
	}
}

/* Asserts that the file of --stats that read_stats read last has every key that a reader of it may rely on, with right
 * values: the arguments are the settings of the run that wrote it. */
static inline void assert_stats(const char *device, const char *replay, const char *cull, long long models,
                                long long workers, long long frames)
{
	assert_int_equal(stat_int("models"), models);
	assert_true(stat_int("visible") >= 1 && stat_int("visible") <= models);
	assert_int_equal(stat_int("draws"), 2 * stat_int("visible"));
	assert_int_equal(stat_int("workers"), workers);
	assert_int_equal(stat_int("frames"), frames);
	assert_string_equal(stat_text("device", '"'), device);
	assert_true(stat_text("device_name", '"')[0] != '\0');
	assert_string_equal(stat_text("replay", '"'), replay);
	assert_string_equal(stat_text("cull", '"'), cull);
	const char *by = stat_text("culled_by", '"'); /* with "auto": the method that was chosen */
	assert_true(strcmp(cull, "auto") == 0 ? strcmp(by, "octree") == 0 || strcmp(by, "flat") == 0
	                                      : strcmp(by, cull) == 0);
	assert_int_equal(strlen(stat_text("stream_hash", '"')), 16);
	bool direct = strcmp(replay, "direct") == 0;
	assert_int_equal(stat_int("commands.draw"), direct ? stat_int("draws") : 0);
	assert_true(direct ? stat_int("commands.draw_indirect") == 0 : stat_int("commands.draw_indirect") >= 1);
	assert_int_equal(stat_int("commands.execute"), 0);
}

/* ---- traces and signals ------------------------------------------------------------------------------------------ */

static inline void assert_trace(const char *path, uint32_t workers, uint64_t frames)
{
	trace_check_report report;
	trace_check_file(path, &report);
	assert_string_equal(report.error, "");
	static const char *const stages[] = {"frame", "cull", "record", "ui", "replay", "present"};
	for (size_t i = 0; i < 6; i++)
		assert_int_equal(trace_check_zones(&report, "main", stages[i]), frames);
	assert_true(trace_check_zones(&report, NULL, "record segment") >= frames);
	/* A worker that did nothing is not listed, a GPU is. */
	assert_in_range(report.threads, 1, workers + 2);
	trace_check_finish(&report);
}

/* Waits until the process catches SIGINT and has then used some CPU time, so that an interrupt meets it at work. False:
 * the process ended before, or five minutes went by. */
static inline bool catches_interrupts(pid_t pid)
{
	char path[64], line[512];
	long start = -1;
	for (int i = 0; i < 30000; i++, usleep(10000)) {
		unsigned long long caught = 0;
		long ticks = 0, user = 0, system = 0;
		snprintf(path, sizeof path, "/proc/%d/status", (int)pid);
		FILE *status = fopen(path, "r");
		while (status && fgets(line, sizeof line, status))
			sscanf(line, "SigCgt: %llx", &caught);
		if (status)
			fclose(status);
		snprintf(path, sizeof path, "/proc/%d/stat", (int)pid);
		FILE *stat_file = fopen(path, "r");
		const char *after = stat_file && fgets(line, sizeof line, stat_file) ? strrchr(line, ')') : NULL;
		if (after && sscanf(after, ") %*c %*d %*d %*d %*d %*d %*u %*u %*u %*u %*u %ld %ld", &user, &system) == 2)
			ticks = user + system;
		if (stat_file)
			fclose(stat_file);
		if (start < 0 && (caught >> (SIGINT - 1) & 1))
			start = ticks;
		if (start >= 0 && ticks > start + 10)
			return true;
	}
	return false;
}

/* ---- under mpirun ------------------------------------------------------------------------------------------------ */

#define RANKS_MPIRUN "/usr/bin/mpirun"

/* What Open MPI runs as root only with: tests run in containers, as root. */
#define RANKS_ENVIRONMENT "OMPI_ALLOW_RUN_AS_ROOT=1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1", "PMIX_MCA_gds=hash"

/* Starts mpirun with the words of a line; @ is the program stilb with "render". */
static inline void ranks_start(const char *const *environment, const char *line)
{
	char copy[2048], *rest = NULL;
	const char *words[64] = {RANKS_MPIRUN, "--oversubscribe"};
	size_t count = 2;
	snprintf(copy, sizeof copy, "%s", line);
	for (char *word = strtok_r(copy, " ", &rest); word && count < 62; word = strtok_r(NULL, " ", &rest)) {
		words[count++] = strcmp(word, "@") == 0 ? stilb_path : word;
		if (strcmp(word, "@") == 0)
			words[count++] = "render";
	}
	assert_true(program_start(&run, words, environment, -1));
}

/* True, after a line that says why, if there is no mpirun, or no module for it. */
static inline bool ranks_are_missing(const char *module)
{
	if (access(RANKS_MPIRUN, X_OK) != 0) {
		printf("skipped: there is no " RANKS_MPIRUN "; install openmpi-bin\n");
		return true;
	}
	if (!module || access(module, R_OK) == 0)
		return false;
	printf("skipped: there is no '%s': this build was configured without libopenmpi-dev\n", module);
	return true;
}

#endif
