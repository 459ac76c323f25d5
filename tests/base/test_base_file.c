/* base_file: files are whole or not there, whatever goes wrong, and nothing else is left in the folder. */
#include "base/base_file.h"
#include "support/folder.h"
#include "support/test.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

/* ---- the calls that can be made to fail -------------------------------------------------------------------------- */

static int rename_error, fsync_error, fsync_calls;
static bool renamed, folder_synced; /* the last rename succeeded; the folder was synced since */

int __wrap_rename(const char *from, const char *to);
int __real_rename(const char *from, const char *to);
int __wrap_fsync(int descriptor);
int __real_fsync(int descriptor);

int __wrap_rename(const char *from, const char *to)
{
	renamed = !rename_error;
	folder_synced = false;
	if (renamed)
		return __real_rename(from, to);
	errno = rename_error;
	return -1;
}

int __wrap_fsync(int descriptor)
{
	struct stat info;
	fsync_calls++;
	assert_int_equal(fstat(descriptor, &info), 0);
	folder_synced |= renamed && S_ISDIR(info.st_mode);
	if (!fsync_error)
		return __real_fsync(descriptor);
	errno = fsync_error;
	return -1;
}

/* ---- a folder of its own, which is the current one --------------------------------------------------------------- */

static int folder_leave(void **state)
{
	(void)state;
	folder_clear();
	return folder_remove();
}

static int folder_fresh(void **state)
{
	(void)state;
	folder_clear();
	rename_error = fsync_error = 0;
	renamed = folder_synced = false;
	return 0;
}

static void assert_entries(int count)
{
	int found = 0;
	DIR *dir = opendir(".");
	assert_non_null(dir);
	for (struct dirent *entry; (entry = readdir(dir));)
		found += strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
	closedir(dir);
	assert_int_equal(found, count);
}

static void assert_content(const char *path, const char *text)
{
	char read[256];
	FILE *file = fopen(path, "rb");
	assert_non_null(file);
	size_t length = fread(read, 1, sizeof read - 1, file);
	fclose(file);
	read[length] = '\0';
	assert_string_equal(read, text);
}

static void put(const char *path, const char *text)
{
	FILE *file = fopen(path, "wb");
	assert_non_null(file);
	fputs(text, file);
	assert_int_equal(fclose(file), 0);
}

static stilb_result save(const char *path, const char *text)
{
	return stilb_file_save(path, text, strlen(text));
}

/* ---- saving ------------------------------------------------------------------------------------------------------ */

static void test_new_file(void **state)
{
	(void)state;
	mode_t mask = umask(027);
	fsync_calls = 0;
	assert_int_equal(stilb_file_check("a.txt"), STILB_OK);
	assert_entries(0); /* the check creates nothing */
	assert_int_equal(save("a.txt", "one"), STILB_OK);
	umask(mask);
	assert_content("a.txt", "one");
	assert_entries(1);
	assert_int_equal(fsync_calls, 2);
	assert_true(folder_synced);
	struct stat info;
	assert_int_equal(stat("a.txt", &info), 0);
	assert_int_equal(info.st_mode & 07777, 0640);
	assert_int_equal(save("empty", ""), STILB_OK);
	assert_content("empty", "");
}

static void test_paths(void **state)
{
	(void)state;
	char here[512], path[1024];
	assert_non_null(getcwd(here, sizeof here));
	assert_int_equal(mkdir("sub", 0777), 0);
	snprintf(path, sizeof path, "%s/sub/b.txt", here);
	assert_int_equal(save(path, "absolute"), STILB_OK);
	assert_content("sub/b.txt", "absolute");
	assert_int_equal(save("./sub/../c.txt", "dots"), STILB_OK);
	assert_content("c.txt", "dots");
	assert_entries(2);
	assert_int_equal(remove("sub/b.txt"), 0);
	memset(path, 'n', 255); /* the longest name that a file can have */
	path[255] = '\0';
	assert_int_equal(stilb_file_check(path), STILB_OK);
	assert_int_equal(save(path, "long"), STILB_OK);
	assert_content(path, "long");
	path[255] = 'n';
	path[256] = '\0';
	assert_int_equal(stilb_file_check(path), STILB_ERROR_ARGUMENT);
}

static void test_existing_file_keeps_its_mode(void **state)
{
	(void)state;
	put("a.txt", "old and longer");
	assert_int_equal(chmod("a.txt", 0604), 0);
	struct stat before, after;
	assert_int_equal(stat("a.txt", &before), 0);
	int reader = open("a.txt", O_RDONLY);
	assert_int_equal(save("a.txt", "new"), STILB_OK);
	assert_content("a.txt", "new");
	assert_int_equal(stat("a.txt", &after), 0);
	assert_int_equal(after.st_mode & 07777, 0604);
	assert_true(after.st_ino != before.st_ino);
	char text[32] = "";
	assert_int_equal(read(reader, text, sizeof text), 14); /* a reader that has it open still reads the old file */
	assert_string_equal(text, "old and longer");
	close(reader);
	assert_entries(1);
}

static void test_links_are_followed(void **state)
{
	(void)state;
	assert_int_equal(mkdir("sub", 0777), 0);
	put("sub/target", "old");
	assert_int_equal(symlink("target", "sub/inner"), 0);
	assert_int_equal(symlink("sub/inner", "outer"), 0);
	assert_int_equal(stilb_file_check("outer"), STILB_OK);
	assert_int_equal(save("outer", "new"), STILB_OK);
	assert_content("sub/target", "new");
	struct stat info;
	assert_int_equal(lstat("outer", &info), 0);
	assert_true(S_ISLNK(info.st_mode));
	assert_int_equal(lstat("sub/inner", &info), 0);
	assert_true(S_ISLNK(info.st_mode));
	assert_int_equal(lstat("sub/target", &info), 0);
	assert_true(S_ISREG(info.st_mode));
	assert_int_equal(remove("sub/inner"), 0);
	assert_int_equal(remove("sub/target"), 0);
	assert_int_equal(rmdir("sub"), 0); /* empty: nothing else was left there */
}

static void test_dangling_links(void **state)
{
	(void)state;
	char here[512], path[1024];
	assert_non_null(getcwd(here, sizeof here));
	snprintf(path, sizeof path, "%s/far", here);
	assert_int_equal(symlink(path, "near"), 0);
	assert_int_equal(stilb_file_check("near"), STILB_OK);
	assert_int_equal(save("near", "made"), STILB_OK);
	assert_content("far", "made");
	assert_entries(2);
	assert_int_equal(symlink("nowhere/x", "lost"), 0);
	assert_int_equal(stilb_file_check("lost"), STILB_ERROR_ARGUMENT);
	assert_int_equal(symlink("loop", "loop"), 0);
	assert_int_equal(stilb_file_check("loop"), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "'loop'"));
	assert_int_equal(save("loop", "x"), STILB_ERROR_FILE);
	assert_entries(4);
}

/* ---- temporary files of others ----------------------------------------------------------------------------------- */

/* Starts a process that begins to write path and never ends by itself; returns its number. */
static pid_t begin_elsewhere(const char *path)
{
	int ready[2];
	char byte;
	assert_int_equal(pipe(ready), 0);
	pid_t pid = fork();
	assert_true(pid >= 0);
	if (pid == 0) {
		stilb_file file;
		prctl(PR_SET_PDEATHSIG, SIGKILL); /* also if the test fails */
		if (stilb_file_open(&file, path) != STILB_OK || stilb_file_write(&file, "half", 4) != 0 ||
		    write(ready[1], "", 1) != 1)
			_exit(1);
		for (;;)
			pause();
	}
	close(ready[1]);
	assert_int_equal(read(ready[0], &byte, 1), 1);
	close(ready[0]);
	return pid;
}

static void kill_and_wait(pid_t pid)
{
	assert_int_equal(kill(pid, SIGKILL), 0);
	assert_int_equal(waitpid(pid, NULL, 0), pid);
}

static void test_a_killed_process_leaves_what_the_next_removes(void **state)
{
	(void)state;
	char name[64];
	pid_t alive = begin_elsewhere("a.txt"), dead = begin_elsewhere("a.txt"), other = begin_elsewhere("b.txt");
	kill_and_wait(dead);
	kill_and_wait(other);
	assert_entries(3);
	assert_int_equal(save("a.txt", "mine"), STILB_OK);
	assert_entries(3);
	snprintf(name, sizeof name, "a.txt.%d.tmp", (int)alive);
	assert_int_equal(access(name, F_OK), 0); /* still being written */
	snprintf(name, sizeof name, "b.txt.%d.tmp", (int)other);
	assert_int_equal(access(name, F_OK), 0);
	stilb_file_clean("./b.txt");
	assert_entries(2);
	kill_and_wait(alive);
	assert_int_equal(symlink("a.txt", "link"), 0);
	stilb_file_clean("link");
	assert_entries(2);
	assert_content("a.txt", "mine");
}

/* Files with similar names stay, and so do a folder, a link and a pipe with names of temporary files. */
static void test_cleaning_touches_nothing_else(void **state)
{
	(void)state;
	static const char *const names[] = {"a.txt.tmp",   "a.txt.x1.tmp",  "a.txt.1.tmp~", "a.txt.1-.tmp",
	                                    "a.txt..tmp",  "b.txt.1.tmp",   "xa.txt.1.tmp", "a.txt.1-2-3.tmp",
	                                    "a.txtx1.tmp", "a.txt.1.2.tmp", "a.txt.-1.tmp"};
	int count = sizeof names / sizeof *names;
	for (int i = 0; i < count; i++)
		put(names[i], "user");
	assert_int_equal(mkdir("a.txt.1.tmp", 0777), 0);
	assert_int_equal(symlink("b.txt.1.tmp", "a.txt.2.tmp"), 0);
	assert_int_equal(mkfifo("a.txt.3.tmp", 0666), 0);
	put("a.txt.4.tmp", "left behind");
	put("a.txt.5-17.tmp", "left behind");
	assert_int_equal(save("a.txt", "new"), STILB_OK);
	assert_entries(count + 4);
	stilb_file_clean("/nonexistent/a.txt");
	stilb_file_clean("-");
}

/* The longest possible name is cut to make room for the temporary ending. */
static void test_longest_name(void **state)
{
	(void)state;
	char name[NAME_MAX + 1];
	memset(name, 'n', NAME_MAX);
	name[NAME_MAX] = '\0';
	kill_and_wait(begin_elsewhere(name));
	assert_entries(1);
	assert_int_equal(save(name, "whole"), STILB_OK);
	assert_content(name, "whole");
	assert_entries(1);
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

static void assert_unreadable(const char *path, const char *why)
{
	FILE *stream = stdin;
	assert_int_equal(stilb_file_read_open(path, &stream), STILB_ERROR_FILE);
	assert_null(stream);
	assert_non_null(strstr(stilb_error_message(), path));
	assert_non_null(strstr(stilb_error_message(), why));
}

static void test_reading(void **state)
{
	(void)state;
	FILE *stream;
	char text[8] = "";
	put("a.txt", "text");
	assert_int_equal(stilb_file_read_open("a.txt", &stream), STILB_OK);
	assert_int_equal(fread(text, 1, sizeof text, stream), 4);
	assert_string_equal(text, "text");
	fclose(stream);
	assert_int_equal(mkfifo("pipe", 0666), 0);
	assert_unreadable("pipe", "regular file"); /* and does not wait for a writer */
	assert_unreadable("/dev/null", "regular file");
	assert_unreadable(".", "folder");
	assert_unreadable("missing", strerror(ENOENT));
}

/* ---- refused ----------------------------------------------------------------------------------------------------- */

static void assert_refused(const char *path, const char *why)
{
	assert_int_equal(stilb_file_check(path), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), why));
	assert_non_null(strstr(stilb_error_message(), path));
	assert_int_equal(save(path, "x"), STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), why));
}

static void test_refused_paths(void **state)
{
	(void)state;
	assert_int_equal(mkdir("sub", 0777), 0);
	put("plain", "p");
	assert_refused("", "empty");
	assert_refused("sub", "folder");
	assert_refused("sub/", "folder");
	assert_refused("new/", "folder");
	assert_refused(".", "folder");
	assert_refused("/", "folder");
	assert_refused("missing/a.txt", "does not exist");
	assert_refused("plain/a.txt", "file");
	assert_refused("missing/", "folder");
	assert_entries(2);
	assert_content("plain", "p");
}

/* ---- written directly -------------------------------------------------------------------------------------------- */

static void test_device(void **state)
{
	(void)state;
	struct stat before, after;
	assert_int_equal(stat("/dev/full", &before), 0);
	assert_int_equal(stilb_file_check("/dev/full"), STILB_OK);
	assert_int_equal(save("/dev/full", "x"), STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), "/dev/full"));
	assert_non_null(strstr(stilb_error_message(), strerror(ENOSPC)));
	char *much = calloc(1, 1 << 20);
	assert_non_null(much);
	assert_int_equal(stilb_file_save("/dev/full", much, 1 << 20), STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), strerror(ENOSPC)));
	free(much);
	assert_int_equal(symlink("/dev/full", "full"), 0);
	assert_int_equal(save("full", "x"), STILB_ERROR_FILE);
	assert_int_equal(stat("/dev/full", &after), 0);
	assert_true(S_ISCHR(after.st_mode));
	assert_int_equal(after.st_ino, before.st_ino);
	assert_entries(1);
}

/* A failed write is remembered, also if later ones succeed. */
static void test_write_reports_errors(void **state)
{
	(void)state;
	stilb_file file;
	assert_int_equal(stilb_file_open(&file, "/dev/full"), STILB_OK);
	setvbuf(file.stream, NULL, _IONBF, 0);
	assert_int_equal(stilb_file_write(&file, "x", 1), -ENOSPC);
	assert_int_equal(stilb_file_commit(&file), STILB_ERROR_FILE);
	assert_null(file.path);
	assert_int_equal(stilb_file_open(&file, "a.txt"), STILB_OK);
	assert_int_equal(stilb_file_write(&file, "x", 1), 0);
	assert_int_equal(stilb_file_commit(&file), STILB_OK);
}

static void test_pipe(void **state)
{
	(void)state;
	assert_int_equal(mkfifo("pipe", 0666), 0);
	int reader = open("pipe", O_RDONLY | O_NONBLOCK);
	assert_true(reader >= 0);
	assert_int_equal(stilb_file_check("pipe"), STILB_OK);
	assert_int_equal(save("pipe", "through"), STILB_OK);
	char text[32] = "";
	assert_int_equal(read(reader, text, sizeof text), 7);
	assert_string_equal(text, "through");
	close(reader);
	struct stat info;
	assert_int_equal(stat("pipe", &info), 0);
	assert_true(S_ISFIFO(info.st_mode));
	assert_entries(1);
}

static void test_dash_is_standard_output(void **state)
{
	(void)state;
	FILE *taken = tmpfile();
	assert_non_null(taken);
	fflush(stdout);
	int kept = dup(STDOUT_FILENO);
	dup2(fileno(taken), STDOUT_FILENO);
	stilb_result check = stilb_file_check("-"), first = save("-", "one "), second = save("-", "two");
	dup2(kept, STDOUT_FILENO);
	close(kept);
	assert_int_equal(check, STILB_OK);
	assert_int_equal(first, STILB_OK);
	assert_int_equal(second, STILB_OK); /* the first save did not close standard output */
	char text[32] = "";
	rewind(taken);
	assert_int_equal(fread(text, 1, sizeof text - 1, taken), 7);
	assert_string_equal(text, "one two");
	fclose(taken);
	assert_entries(0);
}

/* ---- failure half-way -------------------------------------------------------------------------------------------- */

static void test_same(void **state)
{
	(void)state;
	assert_int_equal(mkdir("inner", 0777), 0);
	assert_int_equal(stilb_file_save("plain", "x", 1), STILB_OK);
	assert_int_equal(symlink("plain", "link"), 0);
	assert_int_equal(symlink("new", "dangling"), 0);
	assert_true(stilb_file_same("a", "a"));
	assert_true(stilb_file_same("a", "./a"));
	assert_true(stilb_file_same("inner/../a", "a"));
	assert_true(stilb_file_same("link", "plain"));
	assert_true(stilb_file_same("dangling", "new"));
	assert_true(stilb_file_same("-", "/dev/stdout"));
	assert_false(stilb_file_same("a", "b"));
	assert_false(stilb_file_same("a", "inner/a"));
	assert_false(stilb_file_same("-", "a"));
	assert_false(stilb_file_same("/dev/null", "/dev/null"));
	assert_false(stilb_file_same("missing/a", "missing/a")); /* no such folder: stilb_file_check refuses both */
	assert_int_equal(unlink("link") | unlink("dangling") | unlink("plain") | rmdir("inner"), 0);
}

static void test_finish_drops(void **state)
{
	(void)state;
	put("a.txt", "old");
	stilb_file file;
	assert_int_equal(stilb_file_open(&file, "a.txt"), STILB_OK);
	assert_entries(2);
	assert_int_equal(stilb_file_write(&file, "new", 3), 0);
	stilb_file_finish(&file);
	assert_null(file.stream);
	assert_content("a.txt", "old");
	assert_entries(1);
	stilb_file_finish(&file); /* accepts {0} */
	assert_int_equal(stilb_file_open(&file, "b.txt"), STILB_OK);
	stilb_file_finish(&file);
	assert_entries(1);
}

static void test_two_at_a_time(void **state)
{
	(void)state;
	stilb_file a, b;
	assert_int_equal(stilb_file_open(&a, "same"), STILB_OK);
	assert_int_equal(stilb_file_open(&b, "same"), STILB_OK);
	stilb_file_write(&a, "first", 5);
	stilb_file_write(&b, "second", 6);
	assert_int_equal(stilb_file_commit(&b), STILB_OK);
	assert_content("same", "second");
	assert_int_equal(stilb_file_commit(&a), STILB_OK);
	assert_content("same", "first");
	assert_entries(1);
}

static void assert_save_fails(const char *path, int error)
{
	assert_int_equal(save(path, "new"), STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), path));
	assert_non_null(strstr(stilb_error_message(), strerror(error)));
}

static void test_failing_rename_and_fsync(void **state)
{
	(void)state;
	put("old.txt", "old");
	rename_error = EXDEV;
	assert_save_fails("old.txt", EXDEV);
	assert_save_fails("new.txt", EXDEV);
	rename_error = 0;
	fsync_error = EIO;
	assert_save_fails("old.txt", EIO);
	assert_save_fails("new.txt", EIO);
	fsync_error = 0;
	assert_content("old.txt", "old");
	assert_entries(1);
}

static void test_folder_gone_after_the_check(void **state)
{
	(void)state;
	assert_int_equal(mkdir("sub", 0777), 0);
	assert_int_equal(stilb_file_check("sub/a.txt"), STILB_OK);
	stilb_file file;
	assert_int_equal(stilb_file_open(&file, "sub/a.txt"), STILB_OK);
	assert_int_equal(unlink(file.temporary), 0);
	assert_int_equal(rmdir("sub"), 0);
	assert_int_equal(stilb_file_commit(&file), STILB_ERROR_FILE);
	assert_int_equal(stilb_file_open(&file, "sub/a.txt"), STILB_ERROR_FILE);
	assert_null(file.path);
	assert_entries(0);
}

#define FRESH_TEST(name) cmocka_unit_test_setup(name, folder_fresh)

int main(void)
{
	const struct CMUnitTest tests[] = {
		FRESH_TEST(test_new_file),
		FRESH_TEST(test_paths),
		FRESH_TEST(test_existing_file_keeps_its_mode),
		FRESH_TEST(test_links_are_followed),
		FRESH_TEST(test_dangling_links),
		FRESH_TEST(test_a_killed_process_leaves_what_the_next_removes),
		FRESH_TEST(test_cleaning_touches_nothing_else),
		FRESH_TEST(test_longest_name),
		FRESH_TEST(test_reading),
		FRESH_TEST(test_refused_paths),
		FRESH_TEST(test_device),
		FRESH_TEST(test_write_reports_errors),
		FRESH_TEST(test_pipe),
		FRESH_TEST(test_dash_is_standard_output),
		FRESH_TEST(test_same),
		FRESH_TEST(test_finish_drops),
		FRESH_TEST(test_two_at_a_time),
		FRESH_TEST(test_failing_rename_and_fsync),
		FRESH_TEST(test_folder_gone_after_the_check),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_leave);
}
