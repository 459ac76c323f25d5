/* Files that traces are written to: forms by their ending, places, replacing whole files, and temporary files. */
#include "profiler/prof_internal.h"
#include "profiler/prof_trace.h"
#include "profiler/write/prof_file.h"
#include "support/failing_memory.h"
#include "support/test.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <sys/wait.h>
#include <unistd.h>

/* A zone in a frame. */
static const stilb_prof_label label = {.name = "frame work", .function = "", .file = ""};
static const stilb_prof_zone zone = {
	.begin_ns = 1000, .end_ns = 9000, .self_ns = 8000, .parent = STILB_PROF_NONE, .size = 1};
static const stilb_prof_lane lane = {.name = "main", .tid = 77, .zones = &zone, .zone_count = 1};
static const stilb_prof_frame frame = {41, 500, 10000};
static const stilb_prof_snapshot made = {
	.labels = &label,
	.lanes = &lane,
	.frames = &frame,
	.label_count = 1,
	.lane_count = 1,
	.frame_count = 1,
	.begin_ns = 500,
	.end_ns = 10000,
	.clock = "rdtsc",
	.hz = 2596000000.4,
};

/* ---- files ------------------------------------------------------------------------------------------------------- */

static char folder[] = "test_prof_file_XXXXXX";

static int enter_folder(void **state)
{
	(void)state;
	memcpy(folder + sizeof folder - 7, "XXXXXX", 6);
	return mkdtemp(folder) && chdir(folder) == 0 ? 0 : -1;
}

static int leave_folder(void **state)
{
	(void)state;
	DIR *all = opendir(".");
	for (struct dirent *entry; all && (entry = readdir(all));)
		if (entry->d_name[0] != '.' && unlink(entry->d_name) != 0)
			rmdir(entry->d_name);
	closedir(all);
	return chdir("..") == 0 && rmdir(folder) == 0 ? 0 : -1;
}

static int count_files(void)
{
	int count = 0;
	DIR *all = opendir(".");
	assert_non_null(all);
	for (struct dirent *entry; (entry = readdir(all));)
		count += entry->d_name[0] != '.';
	closedir(all);
	return count;
}

static void write_text(const char *path, const char *text)
{
	FILE *file = fopen(path, "wb");
	assert_non_null(file);
	assert_true(fputs(text, file) >= 0);
	assert_int_equal(fclose(file), 0);
}

/* Reads the first bytes of a file into a static buffer, which the next call overwrites. */
static const char *read_text(const char *path)
{
	static char text[64];
	FILE *file = fopen(path, "rb");
	assert_non_null(file);
	text[fread(text, 1, sizeof text - 1, file)] = 0;
	fclose(file);
	return text;
}

static void assert_begins(const char *path, const char *beginning)
{
	assert_memory_equal(read_text(path), beginning, strlen(beginning));
}

static void the_ending_names_the_form(void **state)
{
	(void)state;
	assert_int_equal(stilb_prof_trace_form("a.json"), STILB_PROF_FORM_CHROME);
	assert_int_equal(stilb_prof_trace_form("-"), STILB_PROF_FORM_CHROME);
	assert_int_equal(stilb_prof_trace_form("x.csv/trace"), STILB_PROF_FORM_CHROME);
	assert_int_equal(stilb_prof_trace_form("x.CSV"), STILB_PROF_FORM_FRAMES_CSV);
	static const char *const named[] = {"a.json", "A.JSON", "a.folded", "b/a.csv", ".csv"};
	static const char *const unnamed[] = {"a.foo", "a", "json", "a.json.gz", "a.json/b", "-", ""};
	for (size_t i = 0; i < sizeof named / sizeof *named; i++)
		assert_true(stilb_prof_trace_is_named(named[i]));
	for (size_t i = 0; i < sizeof unnamed / sizeof *unnamed; i++)
		assert_false(stilb_prof_trace_is_named(unnamed[i]));
	assert_int_equal(stilb_prof_trace_save(&made, NULL, "t.json"), 0);
	assert_int_equal(stilb_prof_trace_save(&made, NULL, "t.folded"), 0);
	assert_int_equal(stilb_prof_trace_save(&made, NULL, "./t.csv"), 0);
	assert_begins("t.json", "{\"displayTimeUnit\"");
	assert_begins("t.folded", "main;frame work");
	assert_begins("t.csv", "frame,begin_ms");
	assert_int_equal(count_files(), 3);
}

static void files_are_replaced_whole(void **state)
{
	(void)state;
	struct stat info;
	write_text("real.json", "old");
	assert_int_equal(chmod("real.json", 0640), 0);
	assert_int_equal(symlink("real.json", "link.json"), 0);
	assert_int_equal(stilb_prof_trace_check("link.json"), 0);
	assert_int_equal(stilb_prof_trace_save(&made, NULL, "link.json"), 0);
	assert_begins("real.json", "{\"display");
	assert_int_equal(lstat("link.json", &info), 0);
	assert_true(S_ISLNK(info.st_mode));
	assert_int_equal(stat("real.json", &info), 0);
	assert_int_equal(info.st_mode & 07777, 0640);
	assert_int_equal(count_files(), 2);
}

static void a_link_to_nothing_makes_its_target(void **state)
{
	(void)state;
	struct stat info;
	assert_int_equal(mkdir("sub", 0777), 0);
	assert_int_equal(symlink("sub/new.json", "link.json"), 0);
	assert_int_equal(stilb_prof_trace_save(&made, NULL, "link.json"), 0);
	assert_begins("sub/new.json", "{\"display");
	assert_int_equal(lstat("link.json", &info), 0);
	assert_true(S_ISLNK(info.st_mode));
	assert_int_equal(unlink("sub/new.json"), 0);
	assert_int_equal(symlink("b", "a"), 0);
	assert_int_equal(symlink("a", "b"), 0);
	assert_int_equal(stilb_prof_trace_save(&made, NULL, "a"), -ELOOP);
}

static void bad_places_are_refused(void **state)
{
	(void)state;
	static const struct {
		const char *path;
		int error;
	} bad[] = {
		{"", -ENOENT}, {"missing/t.json", -ENOENT}, {".", -EISDIR}, {"t.json/", -EISDIR}, {"file/t.json", -ENOTDIR},
	};
	write_text("file", "");
	for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
		assert_int_equal(stilb_prof_trace_check(bad[i].path), bad[i].error);
		assert_int_equal(stilb_prof_trace_save(&made, NULL, bad[i].path), bad[i].error);
	}
	assert_int_equal(stilb_prof_trace_check("new.json"), 0);
	assert_int_equal(count_files(), 1);
}

/* Writes to a device node that the test makes, like /dev/full: if the code were wrong, root would replace the real
 * one. */
static void a_full_device_is_an_error(void **state)
{
	(void)state;
	bool own = mknod("full", S_IFCHR | 0600, makedev(1, 7)) == 0 && access("full", W_OK) == 0;
	const char *device = own ? "full" : "/dev/full";
	struct stat info;
	if (!own && geteuid() == 0) {
		print_message("no device can be made here: not tested\n");
		return;
	}
	assert_int_equal(stilb_prof_trace_save(&made, NULL, device), -ENOSPC);
	assert_int_equal(stat(device, &info), 0);
	assert_true(S_ISCHR(info.st_mode));
}

/* No file may be longer than 100 bytes: as if the disk were full. */
static void nothing_half_written_is_left(void **state)
{
	(void)state;
	struct rlimit old;
	write_text("t.json", "old");
	assert_int_equal(getrlimit(RLIMIT_FSIZE, &old), 0);
	struct rlimit small = {.rlim_cur = 100, .rlim_max = old.rlim_max};
	void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
	assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
	int over = stilb_prof_trace_save(&made, NULL, "t.json");
	int beside = stilb_prof_trace_save(&made, NULL, "new.json");
	setrlimit(RLIMIT_FSIZE, &old);
	signal(SIGXFSZ, handler);
	assert_int_equal(over, -EFBIG);
	assert_int_equal(beside, -EFBIG);
	assert_string_equal(read_text("t.json"), "old");
	assert_int_equal(count_files(), 1);
}

/* ---- temporary files --------------------------------------------------------------------------------------------- */

static uint32_t folder_syncs;

int __real_fsync(int file);
int __wrap_fsync(int file);
int __wrap_fsync(int file)
{
	struct stat info;
	folder_syncs += fstat(file, &info) == 0 && S_ISDIR(info.st_mode);
	return __real_fsync(file);
}

static char temporary_seen[NAME_MAX + 1]; /* name of the temporary file that a writer found in its target's folder */

static void see_temporary(void)
{
	DIR *all = opendir(".");
	assert_non_null(all);
	for (struct dirent *entry; (entry = readdir(all));)
		if (strstr(entry->d_name, ".tmp"))
			snprintf(temporary_seen, sizeof temporary_seen, "%s", entry->d_name);
	closedir(all);
}

/* The temporary file is named after the target and lies in its folder, which is synced after the rename. */
static void a_file_is_written_beside_its_place(void **state)
{
	(void)state;
	char expected[64];
	prof_file file;
	folder_syncs = 0;
	snprintf(expected, sizeof expected, "t.json.%d.tmp", (int)getpid());
	assert_int_equal(prof_file_open(&file, "t.json", false), 0);
	see_temporary();
	assert_string_equal(temporary_seen, expected);
	assert_int_equal(prof_file_write(&file, "text", 4), 0);
	assert_int_equal(folder_syncs, 0);
	assert_int_equal(prof_file_commit(&file, 0), 0);
	assert_int_equal(folder_syncs, 1);
	assert_string_equal(read_text("t.json"), "text");
	assert_int_equal(count_files(), 1);
}

/* Two writers in one process, as a capture and a crash may be, write the same file at the same time. */
static void two_write_the_same_file(void **state)
{
	(void)state;
	prof_file a, b;
	assert_int_equal(prof_file_open(&a, "t.json", false), 0);
	assert_int_equal(prof_file_open(&b, "t.json", false), 0);
	assert_int_equal(count_files(), 2);
	prof_file_write(&a, "a", 1);
	prof_file_write(&b, "b", 1);
	assert_int_equal(prof_file_commit(&a, 0), 0);
	assert_string_equal(read_text("t.json"), "a");
	assert_int_equal(prof_file_commit(&b, 0), 0);
	assert_string_equal(read_text("t.json"), "b");
	assert_int_equal(count_files(), 1);
}

/* A process that is killed while it writes leaves its temporary file; the next writer of the same target removes it. It
 * removes neither the temporary file of a process that lives, nor that of another target, nor a file with a similar
 * name. */
static void what_a_killed_process_left_is_removed(void **state)
{
	(void)state;
	static const char *const others[] = {"t.json.tmp",    "t.json.x1.tmp", "t.json.1.tmp~",
	                                     "t.json.1-.tmp", "u.json.1.tmp",  "xt.json.1.tmp",
	                                     "t.jsonx1.tmp",  "t.json..tmp",   "t.json.1-2-3.tmp"};
	int ends[2], status;
	char left[64], byte;
	struct stat info;
	assert_int_equal(pipe(ends), 0);
	pid_t child = fork();
	if (child == 0) {
		prof_file file;
		bool good = prof_file_open(&file, "t.json", false) == 0 && write(ends[1], "", 1) == 1;
		pause();
		_exit(good);
	}
	assert_true(child > 0);
	assert_int_equal(read(ends[0], &byte, 1), 1);
	snprintf(left, sizeof left, "t.json.%d.tmp", (int)child);
	for (size_t i = 0; i < sizeof others / sizeof *others; i++)
		write_text(others[i], "");
	assert_int_equal(mkfifo("t.json.3.tmp", 0600), 0);
	assert_int_equal(stilb_prof_trace_save(&made, NULL, "t.json"), 0);
	assert_int_equal(stat(left, &info), 0); /* not removed while it is being written */
	assert_int_equal(kill(child, SIGKILL), 0);
	assert_int_equal(waitpid(child, &status, 0), child);
	write_text("t.json.99-7.tmp", "");
	assert_int_equal(stilb_prof_trace_save(&made, NULL, "t.json"), 0);
	assert_int_equal(stat(left, &info), -1);
	assert_int_equal(stat("t.json.99-7.tmp", &info), -1);
	assert_int_equal(count_files(), 2 + sizeof others / sizeof *others);
	close(ends[0]);
	close(ends[1]);
}

/* A name as long as a name can be still has room for its temporary file. */
static void the_longest_name_is_written(void **state)
{
	(void)state;
	char name[NAME_MAX + 1];
	memset(name, 'n', NAME_MAX);
	memcpy(name + NAME_MAX - 5, ".json", 6);
	assert_int_equal(stilb_prof_trace_save(&made, NULL, name), 0);
	assert_begins(name, "{\"display");
	assert_int_equal(count_files(), 1);
}

static void a_fresh_file_replaces_none(void **state)
{
	(void)state;
	prof_file file;
	assert_int_equal(prof_trace_save_fresh(&made, NULL, "t.json"), 0);
	assert_begins("t.json", "{\"display");
	write_text("t.json", "old");
	assert_int_equal(prof_trace_save_fresh(&made, NULL, "t.json"), -EEXIST);
	assert_string_equal(read_text("t.json"), "old");
	assert_int_equal(prof_file_open(&file, "u.json", true), 0);
	write_text("u.json", "meanwhile");
	assert_int_equal(prof_file_commit(&file, 0), -EEXIST);
	assert_string_equal(read_text("u.json"), "meanwhile");
	assert_int_equal(count_files(), 2);
}

static void a_pipe_is_written_directly(void **state)
{
	(void)state;
	struct stat info;
	assert_int_equal(mkfifo("pipe", 0600), 0);
	int reader = open("pipe", O_RDONLY | O_NONBLOCK);
	assert_true(reader >= 0);
	assert_int_equal(stilb_prof_trace_save(&made, NULL, "pipe"), 0);
	char text[17] = "";
	assert_int_equal(read(reader, text, 16), 16);
	assert_string_equal(text, "{\"displayTimeUni");
	close(reader);
	assert_int_equal(stat("pipe", &info), 0);
	assert_true(S_ISFIFO(info.st_mode));
}

static void a_dash_is_stdout(void **state)
{
	(void)state;
	int ends[2], status = -1;
	char text[17] = "";
	assert_int_equal(pipe(ends), 0);
	pid_t child = fork();
	if (child == 0) {
		dup2(ends[1], STDOUT_FILENO);
		_exit(stilb_prof_trace_save(&made, NULL, "-") == 0 ? 0 : 1);
	}
	assert_int_equal(waitpid(child, &status, 0), child);
	assert_int_equal(status, 0);
	assert_int_equal(read(ends[0], text, 16), 16);
	assert_string_equal(text, "{\"displayTimeUni");
	close(ends[0]);
	close(ends[1]);
	assert_int_equal(count_files(), 0);
}

static void no_memory_for_a_file(void **state)
{
	(void)state;
	int failures = 0;
	for (;; failures++) {
		fail_allocation = failures;
		int error = stilb_prof_trace_save(&made, NULL, "t.json");
		bool failed = fail_allocation < 0;
		fail_allocation = -1;
		if (!failed)
			break;
		assert_int_equal(error, -ENOMEM);
		assert_int_equal(count_files(), 0);
	}
	assert_true(failures >= 4);
	assert_int_equal(count_files(), 1);
}

#define FILE_TEST(f) cmocka_unit_test_setup_teardown(f, enter_folder, leave_folder)

int main(void)
{
	const struct CMUnitTest tests[] = {
		FILE_TEST(the_ending_names_the_form),
		FILE_TEST(files_are_replaced_whole),
		FILE_TEST(a_link_to_nothing_makes_its_target),
		FILE_TEST(bad_places_are_refused),
		FILE_TEST(a_full_device_is_an_error),
		FILE_TEST(nothing_half_written_is_left),
		FILE_TEST(a_file_is_written_beside_its_place),
		FILE_TEST(two_write_the_same_file),
		FILE_TEST(what_a_killed_process_left_is_removed),
		FILE_TEST(the_longest_name_is_written),
		FILE_TEST(a_fresh_file_replaces_none),
		FILE_TEST(a_pipe_is_written_directly),
		FILE_TEST(a_dash_is_stdout),
		FILE_TEST(no_memory_for_a_file),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
