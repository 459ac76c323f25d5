/* mpirun stilb render: ranks make one picture, the same file as that of one process; ranks that do not belong are
 * refused by name; ranks that die, signals and full disks leave a checkpoint. With the argument "long" the tests that
 * take seconds. Skipped, with the reason, where Open MPI is missing. */
#include "support/stilb_program.h"

static const char *const environment[] = {NO_DISPLAY, RANKS_ENVIRONMENT, NULL};

static int ranks(const char *line)
{
	ranks_start(environment, line);
	program_wait(&run);
	return run.code;
}

#define PICTURE "cornell --size 72x48 --spp 8"

static void test_same_bits_from_any_ranks(void **state)
{
	(void)state;
	stilb_good("render " PICTURE " -o whole.exr");
	static const char *const counts[] = {"1 --workers", "2 --workers", "3 --workers", "5 --workers"};
	for (int i = 0; i < 4; i++) {
		char line[256];
		snprintf(line, sizeof line, "-n %.1s @ " PICTURE " -o ranks.exr --workers %d --stats s.json", counts[i],
		         1 + i % 2);
		if (ranks(line) != 0)
			print_error("%s\n%s", line, run.err);
		assert_int_equal(run.code, 0);
		assert_true(same_file("whole.exr", "ranks.exr"));
		read_stats("s.json");
		assert_int_equal(stat_int("ranks"), atoi(counts[i]));
		assert_true(stat_int("camera_rays") >= 72 * 48 * 8); /* of all ranks */
		assert_true(i == 0 || strstr(run.out, " ranks rendered "));
	}
	stilb_good("render " PICTURE " -o whole.exr --denoise");
	assert_int_equal(ranks("-n 2 @ " PICTURE " -o ranks.exr --denoise"), 0);
	assert_true(same_file("whole.exr", "ranks.exr"));
	/* The cache's overture is computed by each, and is the same. */
	stilb_good("render " PICTURE " -o whole.png --integrator irradiance-cache --cache-rays 64");
	assert_int_equal(ranks("-n 2 @ " PICTURE " -o ranks.png --integrator irradiance-cache --cache-rays 64"), 0);
	assert_true(same_file("whole.png", "ranks.png"));
	assert_int_equal(folder_entries(), 5);
}

static void refused(const char *line, const char *said)
{
	assert_int_equal(ranks(line), 2);
	assert_said(run.err, said);
	const char *again = strstr(run.err, "stilb: "); /* one rank complains, once */
	assert_non_null(again);
	assert_null(strstr(again + 1, "stilb: "));
}

static void test_ranks_that_do_not_belong(void **state)
{
	(void)state;
	refused("-n 2 @ " PICTURE " -o a.exr --time 3", "--time");
	refused("-n 2 @ " PICTURE " -o a.part --part 1/2", "--part is for machines that do not talk");
	refused("-n 1 @ " PICTURE " -o a.exr : -n 1 @ " PICTURE " -o a.exr --isa sse2", "rank 1 (");
	assert_said(run.err, "has isa sse2, not");
	refused("-n 2 @ " PICTURE " -o a.exr : -n 1 @ " PICTURE " -o a.exr --depth 3", "rank 2 (");
	assert_said(run.err, "has depth 3, not 64 as rank 0");
	assert_int_equal(mkdir("here", 0700), 0);
	FILE *file = fopen("here/a.obj", "w");
	fputs("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", file);
	fclose(file);
	refused("-n 1 -wdir here @ a.obj --size 320x320 -o a.exr --quiet : -n 1 @ a.obj --size 320x320 -o a.exr --quiet",
	        "rank 1 (");
	assert_said(run.err, "a.obj");
	assert_said(run.err, "no such file");
	refused("-n 2 @ none.obj --size 8x8 -o a.exr", "none.obj"); /* rank 0 itself */
	assert_int_equal(access("a.exr", F_OK), -1);
	remove("here/a.obj");
}

/* ---- ends before the end ----------------------------------------------------------------------------------------- */

#define SLOW "cornell --size 96x96 --spp 800 --workers 1 -o slow.exr"

/* The process of a rank below that process, or 0. */
static pid_t rank_of(pid_t parent, int rank)
{
	char wanted[64], path[300];
	static char text[65536];
	snprintf(wanted, sizeof wanted, "OMPI_COMM_WORLD_RANK=%d", rank);
	DIR *dir = opendir("/proc");
	pid_t found = 0;
	for (struct dirent *entry; !found && (entry = readdir(dir));) {
		int above = 0;
		snprintf(path, sizeof path, "/proc/%s/stat", entry->d_name);
		FILE *file = atoi(entry->d_name) > 0 ? fopen(path, "r") : NULL;
		if (!file)
			continue;
		int got = fscanf(file, "%*d (%*[^)]) %*c %d", &above);
		fclose(file);
		snprintf(path, sizeof path, "/proc/%s/environ", entry->d_name);
		file = got == 1 && above == parent ? fopen(path, "r") : NULL;
		size_t size = file ? fread(text, 1, sizeof text - 1, file) : 0;
		if (file)
			fclose(file);
		text[size] = '\0';
		for (char *at = text; at < text + size && !found; at += strlen(at) + 1)
			found = strcmp(at, wanted) == 0 ? atoi(entry->d_name) : 0;
	}
	closedir(dir);
	return found;
}

/* True while a process runs in this test's folder: ranks outlive mpirun a little. */
static bool ranks_left(void)
{
	char path[300], folder[PATH_MAX];
	DIR *dir = opendir("/proc");
	bool found = false;
	for (struct dirent *entry; !found && (entry = readdir(dir));) {
		snprintf(path, sizeof path, "/proc/%s/cwd", entry->d_name);
		pid_t process = atoi(entry->d_name);
		ssize_t length = process > 0 && process != getpid() ? readlink(path, folder, sizeof folder - 1) : -1;
		folder[length > 0 ? length : 0] = '\0';
		found = length > 0 && strcmp(folder, stilb_folder) == 0;
	}
	closedir(dir);
	return found;
}

static void pause_s(double seconds)
{
	nanosleep(&(struct timespec){(time_t)seconds, (long)((seconds - (double)(time_t)seconds) * 1e9)}, NULL);
}

/* Waits until no rank is left, for 10 s at most: one may still write its checkpoint when mpirun has ended. */
static void ranks_end(void)
{
	for (int i = 0; i < 200 && ranks_left(); i++)
		pause_s(0.05);
}

/* Processor time of a process, seconds; 0 if there is none. */
static double cpu_seconds_of(pid_t process)
{
	char path[64];
	unsigned long user = 0, system = 0;
	snprintf(path, sizeof path, "/proc/%d/stat", (int)process);
	FILE *file = fopen(path, "r");
	if (!file)
		return 0.0;
	int got = fscanf(file, "%*d (%*[^)]) %*c %*d %*d %*d %*d %*d %*u %*u %*u %*u %*u %lu %lu", &user, &system);
	fclose(file);
	return got == 2 ? (double)(user + system) / (double)sysconf(_SC_CLK_TCK) : 0.0;
}

/* Starts three ranks, waits until they render, and returns the process of one. On a busy machine that may be long after
 * they began, so what counts is what they have computed: Open MPI takes 0.1 s to start, the picture several. */
static pid_t slow_start(int rank)
{
	ranks_start(environment, "-n 3 @ " SLOW);
	pid_t process = 0;
	for (int i = 0; i < 200 && !process; i++) {
		pause_s(0.05);
		process = rank_of(run.pid, rank);
	}
	assert_true(process > 0);
	for (int i = 0; i < 1200 && cpu_seconds_of(process) < 0.6; i++)
		pause_s(0.05);
	assert_true(cpu_seconds_of(process) >= 0.6);
	return process;
}

static void goes_on_with(const char *count)
{
	char line[256];
	snprintf(line, sizeof line, "-n %s @ " SLOW " --resume", count);
	ranks_end();
	assert_int_equal(access("slow.exr.checkpoint", F_OK), 0);
	assert_int_equal(ranks(line), 0);
	assert_null(strstr(run.err, "there is no")); /* it has gone on, not begun anew */
	assert_true(same_file("whole.exr", "slow.exr"));
	assert_int_equal(access("slow.exr.checkpoint", F_OK), -1);
	assert_int_equal(folder_entries(), 2);
}

static void whole_make(void)
{
	stilb_good("render " SLOW);
	assert_int_equal(rename("slow.exr", "whole.exr"), 0);
}

static void test_a_rank_that_dies(void **state)
{
	(void)state;
	whole_make();
	kill(slow_start(1), SIGKILL);
	program_wait(&run);
	assert_int_not_equal(run.code, 0);
	assert_said(run.err, "--resume continues it");
	goes_on_with("2");
}

static void test_ctrl_c(void **state)
{
	(void)state;
	whole_make();
	slow_start(0);
	kill(run.pid, SIGINT); /* to mpirun: its ranks are in process groups of their own */
	program_wait(&run);
	assert_said(run.err, "--resume continues it");
	goes_on_with("1");
	kill(slow_start(0), SIGTERM); /* to the host alone */
	program_wait(&run);
	assert_int_equal(run.code, 0);
	assert_said(run.out, "--resume continues it");
	goes_on_with("3");
}

/* Any rank, rank 0 too, at any time: while mpirun starts, while scenes are read, while it renders or writes. */
static void test_any_rank_killed_at_any_time(void **state)
{
	(void)state;
	whole_make();
	uint32_t numbers = 23;
	int killed = 0;
	for (int i = 0; i < 5; i++) {
		int rank = i % 3;
		ranks_start(environment, "-n 3 @ " SLOW " --checkpoint 0.05 --resume");
		pid_t process = 0;
		for (int k = 0; k < 400 && !process; k++) {
			pause_s(0.02);
			process = rank_of(run.pid, rank);
		}
		numbers = numbers * 1664525u + 1013904223u;
		pause_s(1.2 * (numbers >> 8) / (1u << 24));
		/* The process may have ended by itself: then its number is no rank's any more. */
		if (process && rank_of(run.pid, rank) == process)
			killed += kill(process, SIGKILL) == 0;
		program_wait(&run);
		ranks_end();
		/* Rank 0, warned by mpirun, writes the picture so far, and a checkpoint beside it. */
		assert_true(access("slow.exr", F_OK) != 0 || access("slow.exr.checkpoint", F_OK) == 0 ||
		            same_file("whole.exr", "slow.exr"));
		remove("slow.exr");
	}
	assert_true(killed >= 3);
	assert_int_equal(ranks("-n 2 @ " SLOW " --resume"), 0);
	assert_true(same_file("whole.exr", "slow.exr"));
	assert_int_equal(folder_entries(), 2); /* no checkpoint, no temporary file */
}

/* A picture that cannot be written is kept as a checkpoint. */
static void test_full_disk(void **state)
{
	(void)state;
	assert_int_equal(symlink("/dev/full", "full.exr"), 0);
	assert_int_equal(ranks("-n 2 @ " PICTURE " -o full.exr"), 1);
	assert_said(run.err, "full.exr");
	assert_int_equal(access("full.exr.checkpoint", F_OK), 0);
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup(test_same_bits_from_any_ranks, folder_fresh),
		cmocka_unit_test_setup(test_ranks_that_do_not_belong, folder_fresh),
	};
	const struct CMUnitTest slow[] = {
		cmocka_unit_test_setup(test_a_rank_that_dies, folder_fresh),
		cmocka_unit_test_setup(test_ctrl_c, folder_fresh),
		cmocka_unit_test_setup(test_any_rank_killed_at_any_time, folder_fresh),
		cmocka_unit_test_setup(test_full_disk, folder_fresh),
	};
	if (ranks_are_missing(argc > 2 ? argv[2] : NULL))
		return 77;
	if (!folder_enter(argc > 1 ? argv[1] : NULL, "game_mpi")) {
		fprintf(stderr, "usage: %s PATH-OF-STILB PATH-OF-MODULE [long]\n", argv[0]);
		return 2;
	}
	if (argc > 3)
		return cmocka_run_group_tests(slow, NULL, folder_leave);
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
