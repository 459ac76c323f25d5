/* Captures: which frames are written, when and where, and what happens if that fails. */
#include "profiler/prof_capture.h"
#include "profiler/prof_frames.h"
#include "profiler/prof_internal.h"
#include "profiler/prof_trace.h"
#include "support/test.h"

#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

/* ---- functions that the capture calls, replaced by the linker's --wrap ------------------------------------------- */

/* If true, frames are synthetic: the test itself calls the frame hook and says how many frames have begun. */
static bool synthetic;
static prof_frame_hook *synthetic_hook;
static uint64_t synthetic_begun;
static uint64_t synthetic_lost; /* frames below this number are not held any more */

void __real_prof_frame_hook_set(prof_frame_hook *hook);
void __wrap_prof_frame_hook_set(prof_frame_hook *hook);
void __wrap_prof_frame_hook_set(prof_frame_hook *hook)
{
	synthetic_hook = hook;
	__real_prof_frame_hook_set(synthetic ? NULL : hook);
}

uint64_t __real_prof_frames_begun(void);
uint64_t __wrap_prof_frames_begun(void);
uint64_t __wrap_prof_frames_begun(void)
{
	/* Relaxed: the number is all that synthetic_frame, which stores it, shares with the threads that ask for it. */
	return synthetic ? __atomic_load_n(&synthetic_begun, __ATOMIC_RELAXED) : __real_prof_frames_begun();
}

static int strings_left = -1; /* copies of strings until one fails; negative: none fails */

char *__real_strdup(const char *text);
char *__wrap_strdup(const char *text);
char *__wrap_strdup(const char *text)
{
	return strings_left < 0 || strings_left-- > 0 ? __real_strdup(text) : NULL;
}

static void synthetic_frame(double ms)
{
	uint64_t number = synthetic_begun - 1;
	__atomic_store_n(&synthetic_begun, synthetic_begun + 1, __ATOMIC_RELAXED);
	synthetic_hook(number, (uint64_t)(ms * 1e6));
}

/* The window of the last snapshot that the capture has taken. */
static stilb_prof_window asked_window;

int __real_stilb_prof_snapshot_take(stilb_prof_snapshot *snapshot, const stilb_prof_window *window);
int __wrap_stilb_prof_snapshot_take(stilb_prof_snapshot *snapshot, const stilb_prof_window *window);
int __wrap_stilb_prof_snapshot_take(stilb_prof_snapshot *snapshot, const stilb_prof_window *window)
{
	static stilb_prof_frame frame;
	asked_window = *window;
	int error = __real_stilb_prof_snapshot_take(snapshot, window);
	if (error == 0 && synthetic && window->frame_count > 0) {
		frame.number = window->first_frame > synthetic_lost ? window->first_frame : synthetic_lost;
		snapshot->frames = &frame;
		snapshot->frame_count = window->first_frame + window->frame_count > frame.number;
	}
	return error;
}

/* The last snapshot that was saved. */
static struct {
	uint64_t first, last; /* numbers of its first and last frame */
	uint32_t frames;
	bool contiguous;
	uint32_t zones, open; /* of the first lane */
} saved;

static char saved_meanwhile[256]; /* path of a file that appears before the next one is written; empty: none */

int __real_prof_trace_save_fresh(const stilb_prof_snapshot *snapshot, const char *process_name, const char *path);
int __wrap_prof_trace_save_fresh(const stilb_prof_snapshot *snapshot, const char *process_name, const char *path);
int __wrap_prof_trace_save_fresh(const stilb_prof_snapshot *snapshot, const char *process_name, const char *path)
{
	memset(&saved, 0, sizeof saved);
	saved.frames = snapshot->frame_count;
	saved.contiguous = true;
	for (uint32_t i = 0; i < saved.frames; i++)
		saved.contiguous &= snapshot->frames[i].number == snapshot->frames[0].number + i;
	if (saved.frames > 0) {
		saved.first = snapshot->frames[0].number;
		saved.last = snapshot->frames[saved.frames - 1].number;
	}
	for (uint32_t i = 0; snapshot->lane_count > 0 && i < snapshot->lanes[0].zone_count; i++) {
		saved.zones += !snapshot->lanes[0].zones[i].open;
		saved.open += snapshot->lanes[0].zones[i].open;
	}
	if (saved_meanwhile[0] != 0) {
		FILE *file = fopen(saved_meanwhile, "w");
		saved_meanwhile[0] = 0;
		if (!file || fputs("meanwhile", file) < 0 || fclose(file) != 0)
			return -EIO;
	}
	return __real_prof_trace_save_fresh(snapshot, process_name, path);
}

/* ---- the callback done (stilb_prof_capture_desc) and its arguments ----------------------------------------------- */

static struct {
	uint32_t count; /* release and acquire: done and told_wait */
	char path[256];
	stilb_prof_captured last;
	const void *user;
	int stop_error; /* returned by stop inside done */
	bool again;     /* ask for another capture inside done */
} told;

static void done(void *user, const stilb_prof_captured *captured)
{
	told.user = user;
	snprintf(told.path, sizeof told.path, "%s", captured->path);
	told.last = *captured;
	told.stop_error = stilb_prof_capture_stop();
	if (told.again) {
		told.again = false;
		stilb_prof_capture_now();
	}
	__atomic_store_n(&told.count, told.count + 1, __ATOMIC_RELEASE);
}

static uint32_t told_count(void)
{
	return __atomic_load_n(&told.count, __ATOMIC_ACQUIRE);
}

static void sleep_us(long us)
{
	nanosleep(&(struct timespec){.tv_sec = us / 1000000, .tv_nsec = us % 1000000 * 1000}, NULL);
}

static double now_s(void)
{
	return 1e-9 * (double)stilb_prof_clock_monotonic();
}

#define PATIENCE_S 60 /* seconds until a wait fails: with the lowest priority, captures take long on a busy machine */

/* Waits until done has been called `count` times. */
static void told_wait(uint32_t count)
{
	double begin = now_s();
	while (told_count() < count && now_s() - begin < PATIENCE_S)
		sleep_us(200);
	assert_int_equal(told_count(), count);
}

/* ---- a folder for each test -------------------------------------------------------------------------------------- */

static char folder[64];

static const char *in_folder(const char *name)
{
	static char path[128];
	snprintf(path, sizeof path, "%s/%s", folder, name);
	return path;
}

/* The number of files in the test's folder, hidden ones included. */
static uint32_t folder_count(void)
{
	uint32_t count = 0;
	DIR *dir = opendir(folder);
	for (const struct dirent *entry; (entry = readdir(dir));)
		count += strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
	closedir(dir);
	return count;
}

static int set_up(void **state)
{
	(void)state;
	strcpy(folder, "/tmp/stilb-prof-capture-XXXXXX");
	synthetic = false;
	synthetic_lost = 0;
	memset(&told, 0, sizeof told);
	memset(&saved, 0, sizeof saved);
	return !mkdtemp(folder) || stilb_prof_thread_begin("main") != 0;
}

static int tear_down(void **state)
{
	(void)state;
	stilb_prof_capture_stop();
	stilb_prof_shutdown();
	DIR *dir = opendir(folder);
	for (const struct dirent *entry; (entry = readdir(dir));)
		if (entry->d_name[0] != '.' || strlen(entry->d_name) > 2)
			unlink(in_folder(entry->d_name));
	closedir(dir);
	return rmdir(folder);
}

static stilb_prof_capture_desc desc_for(const char *path)
{
	stilb_prof_capture_desc desc = stilb_prof_capture_desc_default();
	desc.path = path;
	desc.done = done;
	desc.user = &told;
	return desc;
}

static void start(const stilb_prof_capture_desc *desc)
{
	assert_int_equal(stilb_prof_capture_start(desc), 0);
}

/* Begins a frame and sleeps us microseconds in it. */
static void frame(long us)
{
	stilb_prof_frame_mark();
	PROFILE("work");
	sleep_us(us);
}

/* Makes frames until done has been called `count` times. */
static void frames_until(uint32_t count)
{
	double begin = now_s();
	for (int i = 0; told_count() < count && now_s() - begin < PATIENCE_S; i++)
		frame(i < 100 ? 1000 : 50000); /* only 1,024 frames are remembered */
	assert_int_equal(told_count(), count);
}

static bool is_whole_json(const char *path)
{
	char end[3] = "";
	FILE *file = fopen(path, "r");
	bool good = file && fgetc(file) == '{' && fseek(file, -3, SEEK_END) == 0 && fread(end, 3, 1, file) == 1;
	if (file)
		fclose(file);
	return good && memcmp(end, "}}\n", 3) == 0;
}

/* ---- asking ------------------------------------------------------------------------------------------------------ */

static void frames_before_and_after(void **state)
{
	(void)state;
	stilb_prof_capture_desc desc = desc_for(in_folder("a.json"));
	desc.frames_before = 20;
	desc.frames_after = 10;
	start(&desc);
	for (int i = 0; i < 101; i++)
		frame(10);
	assert_int_equal(stilb_prof_capture_now(), 0);
	frames_until(1);
	assert_int_equal(told.last.error, 0);
	assert_int_equal(told.last.cause, STILB_PROF_CAUSE_ASKED);
	assert_int_equal(told.last.frame, 100);
	assert_int_equal(told.last.frame_count, 31);
	assert_string_equal(told.path, in_folder("a.json"));
	assert_int_equal(saved.first, 80);
	assert_int_equal(saved.last, 110);
	assert_true(saved.contiguous);
	assert_int_equal(saved.zones, 31);
	assert_int_equal(saved.open, 0);
	assert_true(is_whole_json(in_folder("a.json")));
	assert_int_equal(folder_count(), 1);
	assert_ptr_equal(told.user, &told);
	assert_int_equal(told.stop_error, -EDEADLK);
	assert_int_equal(stilb_prof_capture_stop(), 0);
	assert_int_equal(told_count(), 1);
	assert_int_equal(stilb_prof_capture_now(), -ESRCH);
}

static void early_frames(void **state)
{
	(void)state;
	stilb_prof_capture_desc desc = desc_for(in_folder("a.json"));
	desc.frames_after = 5;
	start(&desc);
	frame(10);
	frame(10);
	stilb_prof_capture_now();
	frames_until(1);
	assert_int_equal(told.last.frame, 1);
	assert_int_equal(saved.first, 0);
	assert_int_equal(saved.last, 6);
}

/* A program that hangs: the capture shows the open zones. */
static void frames_stand_still(void **state)
{
	(void)state;
	stilb_prof_capture_desc desc = desc_for(in_folder("a.json"));
	start(&desc);
	for (int i = 0; i < 10; i++)
		frame(10);
	stilb_prof_frame_mark();
	PROFILE("hangs");
	double begin = now_s();
	stilb_prof_capture_now();
	told_wait(1);
	assert_true(now_s() - begin > 0.9);
	assert_int_equal(told.last.error, 0);
	assert_int_equal(told.last.frame, 10);
	assert_int_equal(saved.frames, 10);
	assert_int_equal(saved.zones, 10);
	assert_int_equal(saved.open, 1);
}

static void without_any_frame(void **state)
{
	(void)state;
	stilb_prof_capture_desc desc = desc_for(in_folder("a.json"));
	start(&desc);
	{
		PROFILE("only");
	}
	stilb_prof_capture_now();
	told_wait(1);
	assert_int_equal(told.last.error, 0);
	assert_int_equal(saved.frames, 0);
	assert_int_equal(saved.zones, 1);
}

static void asking_again(void **state)
{
	(void)state;
	stilb_prof_capture_desc desc = desc_for(in_folder("a.json"));
	desc.frames_after = 20;
	start(&desc);
	for (int i = 0; i < 10; i++) {
		frame(2000);
		stilb_prof_capture_now(); /* the first counts, the others are within its frames */
	}
	frames_until(1);
	for (int i = 0; i < 50; i++)
		frame(1000);
	assert_int_equal(told_count(), 1);
	assert_int_equal(told.last.frame, 0);
	told.again = true;
	stilb_prof_capture_now();
	frames_until(3);
	assert_string_equal(told.path, in_folder("a-3.json"));
	assert_int_equal(folder_count(), 3);
}

static void write_text(const char *path, const char *text)
{
	FILE *file = fopen(path, "w");
	assert_non_null(file);
	assert_true(fputs(text, file) >= 0);
	assert_int_equal(fclose(file), 0);
}

static void assert_text(const char *path, const char *expected)
{
	char text[64] = "";
	FILE *file = fopen(path, "r");
	assert_non_null(file);
	assert_true(fread(text, 1, sizeof text - 1, file) > 0);
	fclose(file);
	assert_string_equal(text, expected);
}

/* Files of an earlier run stay, and so does a file that appears while a capture is being written. */
static void files_of_earlier_runs_stay(void **state)
{
	(void)state;
	char path[128];
	snprintf(path, sizeof path, "%s", in_folder("a.json"));
	stilb_prof_capture_desc desc = desc_for(path);
	write_text(path, "first");
	write_text(in_folder("a-3.json"), "third");
	for (int run = 0; run < 2; run++) {
		start(&desc);
		frame(10);
		for (uint32_t i = 0; i < 2; i++) {
			stilb_prof_capture_now();
			frames_until(told_count() + 1);
			assert_int_equal(told.last.error, 0);
		}
		assert_int_equal(stilb_prof_capture_stop(), 0);
	}
	assert_string_equal(told.path, in_folder("a-6.json"));
	assert_text(in_folder("a.json"), "first");
	assert_text(in_folder("a-3.json"), "third");
	assert_true(is_whole_json(in_folder("a-2.json")) && is_whole_json(in_folder("a-4.json")));
	snprintf(saved_meanwhile, sizeof saved_meanwhile, "%s", in_folder("a-7.json"));
	start(&desc);
	frame(10);
	stilb_prof_capture_now();
	frames_until(told_count() + 1);
	assert_string_equal(told.path, in_folder("a-8.json"));
	assert_text(in_folder("a-7.json"), "meanwhile");
	assert_int_equal(folder_count(), 8);
}

static void many_in_a_row(void **state)
{
	(void)state;
	stilb_prof_capture_desc desc = desc_for(in_folder("a.csv"));
	desc.frames_before = 3;
	desc.frames_after = 1;
	start(&desc);
	for (uint32_t i = 1; i <= 100; i++) {
		frame(10);
		stilb_prof_capture_now();
		frames_until(i);
		assert_int_equal(told.last.error, 0);
	}
	assert_string_equal(told.path, in_folder("a-100.csv"));
	assert_int_equal(folder_count(), 100);
}

static void names(void **state)
{
	(void)state;
	const char *const cases[][2] = {
		{"a.b.json", "a.b-2.json"}, {"plain", "plain-2"}, {".json", ".json-2"}, {"a.", "a-2."}, {"x.csv", "x-2.csv"}};
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
		told.count = 0;
		stilb_prof_capture_desc desc = desc_for(in_folder(cases[i][0]));
		desc.frames_after = 0;
		start(&desc);
		stilb_prof_capture_now();
		frames_until(1);
		assert_string_equal(told.path, in_folder(cases[i][0]));
		stilb_prof_capture_now();
		frames_until(2);
		assert_string_equal(told.path, in_folder(cases[i][1]));
		assert_int_equal(stilb_prof_capture_stop(), 0);
	}
	assert_int_equal(folder_count(), 10);
}

static void stop_writes_what_is_pending(void **state)
{
	(void)state;
	stilb_prof_capture_desc desc = desc_for(in_folder("a.json"));
	double fastest = PATIENCE_S;
	for (int i = 0; i < 20; i++) {
		start(&desc);
		frame(10);
		assert_int_equal(stilb_prof_capture_start(&desc), -EALREADY);
		stilb_prof_capture_now();
		if (i % 2)
			sleep_us(300);
		double begin = now_s();
		assert_int_equal(stilb_prof_capture_stop(), 0);
		double seconds = now_s() - begin;
		fastest = seconds < fastest ? seconds : fastest;
		assert_int_equal(told_count(), i + 1);
		assert_int_equal(told.last.error, 0);
	}
	assert_true(fastest < 0.9); /* stop does not wait for the frames after, or for a second without frames */
	assert_int_equal(stilb_prof_capture_stop(), 0);
}

/* ---- signals ----------------------------------------------------------------------------------------------------- */

static void other_handler(int number)
{
	(void)number;
}

static void a_signal_asks(void **state)
{
	(void)state;
	struct sigaction now;
	stilb_prof_capture_desc desc = desc_for(in_folder("a.json"));
	desc.frames_after = 2;
	desc.signal = SIGUSR1;
	signal(SIGUSR1, other_handler);
	start(&desc);
	frame(10);
	raise(SIGUSR1);
	frames_until(1);
	assert_int_equal(told.last.cause, STILB_PROF_CAUSE_ASKED);
	stilb_prof_capture_stop();
	sigaction(SIGUSR1, NULL, &now);
	assert_ptr_equal(now.sa_handler, other_handler);

	/* A handler that the program has set since the start of captures stays. */
	signal(SIGUSR1, SIG_DFL);
	start(&desc);
	signal(SIGUSR1, other_handler);
	stilb_prof_capture_stop();
	sigaction(SIGUSR1, NULL, &now);
	assert_ptr_equal(now.sa_handler, other_handler);
	signal(SIGUSR1, SIG_DFL);
}

/* ---- errors ------------------------------------------------------------------------------------------------------ */

static void refused(void **state)
{
	(void)state;
	stilb_prof_capture_desc desc = desc_for(NULL);
	assert_int_equal(stilb_prof_capture_start(&desc), -EINVAL);
	desc = desc_for("");
	assert_int_equal(stilb_prof_capture_start(&desc), -EINVAL);
	char path[5000];
	memset(path, 'a', sizeof path);
	path[sizeof path - 1] = 0;
	desc = desc_for(path);
	assert_int_equal(stilb_prof_capture_start(&desc), -ENAMETOOLONG);
	double lengths[] = {-1, (double)NAN, (double)INFINITY};
	for (int i = 0; i < 3; i++) {
		desc = desc_for("a.json");
		desc.spike = STILB_PROF_SPIKE_FIXED;
		desc.spike_ms = lengths[i];
		assert_int_equal(stilb_prof_capture_start(&desc), -EINVAL);
	}
	int signals[] = {-1, SIGKILL, SIGSTOP, 32, 1000, SIGSEGV};
	for (int i = 0; i < 6; i++) {
		desc = desc_for("a.json");
		desc.signal = signals[i];
		desc.crash = true;
		assert_int_equal(stilb_prof_capture_start(&desc), -EINVAL);
	}
	assert_int_equal(stilb_prof_capture_now(), -ESRCH);
	assert_int_equal(stilb_prof_capture_stop(), 0);
}

static void no_memory_to_start(void **state)
{
	(void)state;
	stilb_prof_capture_desc desc = desc_for("a.json");
	desc.process_name = "a program";
	for (int copies = 0; copies < 2; copies++) {
		strings_left = copies;
		assert_int_equal(stilb_prof_capture_start(&desc), -ENOMEM);
		assert_int_equal(stilb_prof_capture_now(), -ESRCH);
	}
	strings_left = -1;
	start(&desc);
	assert_int_equal(stilb_prof_capture_stop(), 0);
}

static void cannot_be_written(void **state)
{
	(void)state;
	const struct {
		const char *path;
		int error;
	} cases[] = {{"/dev/full", -ENOSPC}, {in_folder("missing/a.json"), -ENOENT}, {folder, -EISDIR}};
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
		told.count = 0;
		stilb_prof_capture_desc desc = desc_for(cases[i].path);
		desc.frames_after = 1;
		start(&desc);
		for (uint32_t k = 1; k <= 2; k++) { /* each capture fails, and each is reported */
			stilb_prof_capture_now();
			frames_until(k);
			assert_int_equal(told.last.error, cases[i].error);
			assert_string_equal(told.path, cases[i].path);
		}
		stilb_prof_capture_stop();
	}
	assert_int_equal(folder_count(), 0);
}

/* Writing fails half-way: a limit on the size of files stands for a full disk. */
static void nothing_half_written(void **state)
{
	(void)state;
	struct rlimit limit, little;
	stilb_prof_capture_desc desc = desc_for(in_folder("a.json"));
	desc.frames_after = 1;
	start(&desc);
	for (int i = 0; i < 50; i++)
		frame(10);
	getrlimit(RLIMIT_FSIZE, &limit);
	little = limit;
	little.rlim_cur = 1000;
	setrlimit(RLIMIT_FSIZE, &little);
	stilb_prof_capture_now();
	frames_until(1);
	setrlimit(RLIMIT_FSIZE, &limit);
	assert_int_equal(told.last.error, -EFBIG);
	assert_int_equal(folder_count(), 0);
	stilb_prof_capture_now();
	frames_until(2);
	assert_int_equal(told.last.error, 0);
	assert_true(is_whole_json(in_folder("a.json")));
}

/* After failed captures: once writing is possible again, the next capture is written, under the first name. */
static void tried_anew(void **state)
{
	(void)state;
	char sub[128], path[160];
	snprintf(sub, sizeof sub, "%s", in_folder("sub"));
	snprintf(path, sizeof path, "%s/a.json", sub);
	stilb_prof_capture_desc desc = desc_for(path);
	desc.frames_after = 1;
	start(&desc);
	stilb_prof_capture_now();
	frames_until(1);
	assert_int_equal(told.last.error, -ENOENT);
	assert_int_equal(mkdir(sub, 0700), 0);
	stilb_prof_capture_now();
	frames_until(2);
	assert_int_equal(told.last.error, 0);
	assert_string_equal(told.path, path);
	assert_int_equal(unlink(path), 0);
	assert_int_equal(rmdir(sub), 0);
}

/* ---- slow frames ------------------------------------------------------------------------------------------------- */

static void synthetic_start(stilb_prof_spike spike, double ms)
{
	stilb_prof_capture_desc desc = desc_for(in_folder("a.csv"));
	desc.frames_before = 5;
	desc.frames_after = 3;
	desc.spike = spike;
	desc.spike_ms = ms;
	desc.cool_down = 50;
	desc.spike_files = 3;
	synthetic = true;
	synthetic_begun = 1;
	start(&desc);
}

static void synthetic_frames(uint32_t count, double ms)
{
	for (uint32_t i = 0; i < count; i++)
		synthetic_frame(ms);
}

/* Asserts that `count` captures have been written by now: those that are due, and no others. */
static void assert_told(uint32_t count)
{
	if (told_count() < count)
		told_wait(count);
	sleep_us(2000);
	assert_int_equal(told_count(), count);
}

static void a_spike_is_twice_the_median(void **state)
{
	(void)state;
	synthetic_start(STILB_PROF_SPIKE_AUTO, 16.7);
	synthetic_frames(19, 500); /* the start of a program is slow, and no spike */
	synthetic_frames(100, 10);
	synthetic_frame(19.9); /* less than twice the median: no spike */
	synthetic_frames(10, 10);
	assert_told(0);
	uint64_t number = synthetic_begun - 1;
	synthetic_frame(20.5);
	synthetic_frames(2, 10);
	assert_told(0); /* the frames after the spike have not ended yet */
	synthetic_frame(10);
	assert_told(1);
	assert_int_equal(told.last.cause, STILB_PROF_CAUSE_SPIKE);
	assert_int_equal(told.last.frame, number);
	assert_float_equal(told.last.frame_ms, 20.5, 1e-9);
	assert_int_equal(asked_window.first_frame, number - 5);
	assert_int_equal(asked_window.frame_count, 9);
	assert_int_equal(asked_window.last_frames, 0);

	/* The cool-down: 50 frames after the slow one, of which 3 are over. */
	synthetic_frames(46, 10);
	synthetic_frame(100);
	assert_told(1);
	synthetic_frame(101);
	synthetic_frames(3, 10);
	assert_told(2);
	assert_int_equal(told.last.frame, number + 51);

	/* If frames stay slower, the median follows, and they are no spikes any more. */
	synthetic_frames(49, 10);
	synthetic_frames(60, 30);
	assert_told(3);
	synthetic_frames(200, 30);
	assert_told(3);
	synthetic_frame(1000); /* three files are the limit */
	synthetic_frames(200, 30);
	assert_told(3);
	stilb_prof_capture_now(); /* but requests are still written */
	synthetic_frames(5, 30);
	assert_told(4);
	assert_string_equal(told.path, in_folder("a-4.csv"));
	synthetic_hook = NULL;
}

static void the_budget_counts(void **state)
{
	(void)state;
	synthetic_start(STILB_PROF_SPIKE_AUTO, 16.7);
	synthetic_frames(100, 2);
	synthetic_frame(16); /* eight times the median, but shorter than spike_ms: no spike */
	synthetic_frames(10, 2);
	assert_told(0);
	synthetic_frame(17);
	synthetic_frames(10, 2);
	assert_told(1);
}

static void a_fixed_limit(void **state)
{
	(void)state;
	synthetic_start(STILB_PROF_SPIKE_FIXED, 33);
	synthetic_frames(100, 32.9);
	assert_told(0);
	synthetic_frame(33.1);
	synthetic_frames(10, 1);
	assert_told(1);
}

/* The frame before the slow one is overwritten in the rings before it is copied; then the slow one, too; then all.
 * Without the slow frame there is no file. */
static void the_rings_went_round(void **state)
{
	(void)state;
	synthetic_start(STILB_PROF_SPIKE_OFF, 1);
	for (uint64_t lost = 0; lost < 6; lost++) {
		synthetic_frames(20, 1);
		uint64_t number = synthetic_begun - 1;
		synthetic_lost = number - 1 + lost;
		stilb_prof_capture_now();
		synthetic_frames(5, 1);
		assert_told((uint32_t)lost + 1);
		assert_int_equal(told.last.error, lost < 2 ? 0 : -ENODATA);
	}
	assert_int_equal(folder_count(), 2);
}

static void off_is_off(void **state)
{
	(void)state;
	synthetic_start(STILB_PROF_SPIKE_OFF, 1);
	synthetic_frames(100, 1);
	synthetic_frames(10, 1000);
	synthetic_frames(100, 1);
	assert_told(0);
}

static void a_slow_frame_of_a_real_loop(void **state)
{
	(void)state;
	stilb_prof_capture_desc desc = desc_for(in_folder("a.json"));
	desc.frames_before = 4;
	desc.frames_after = 4;
	desc.spike = STILB_PROF_SPIKE_FIXED;
	desc.spike_ms = 200; /* more than a busy machine adds to a frame */
	start(&desc);
	for (int i = 0; i < 50; i++)
		frame(100);
	frame(250000);
	frames_until(1);
	assert_int_equal(told.last.frame, 50);
	assert_in_range((uint64_t)told.last.frame_ms, 250, 10000);
	assert_int_equal(saved.first, 46);
	assert_int_equal(saved.last, 54);
}

/* ---- frame times ------------------------------------------------------------------------------------------------- */

static uint64_t random_state = 1;

static uint64_t random_next(void)
{
	random_state = random_state * 6364136223846793005u + 1442695040888963407u;
	return random_state >> 33;
}

static int ascending(const void *a, const void *b)
{
	uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
	return (x > y) - (x < y);
}

/* Compares with sorting the last 100 frames each time. */
static void the_window_is_sorted(void **state)
{
	(void)state;
	static uint64_t all[5000];
	prof_frame_window window = {0};
	assert_int_equal(prof_frame_window_rank(&window, 50), 0);
	for (uint32_t n = 0; n < 5000; n++) {
		all[n] = n % 7 == 0 ? 500 : random_next() % (n < 2500 ? 10 : 1000000);
		prof_frame_window_add(&window, all[n]);
		uint32_t count = n + 1 < 100 ? n + 1 : 100;
		uint64_t sorted[100];
		memcpy(sorted, &all[n + 1 - count], count * sizeof sorted[0]);
		qsort(sorted, count, sizeof sorted[0], ascending);
		assert_int_equal(window.count, count);
		assert_memory_equal(window.sorted, sorted, count * sizeof sorted[0]);
		assert_int_equal(prof_frame_window_rank(&window, 50), sorted[(count + 1) / 2 - 1]);
		assert_int_equal(prof_frame_window_rank(&window, 100), sorted[count - 1]);
		if (count == 100)
			assert_int_equal(prof_frame_window_rank(&window, 99), sorted[98]);
	}
}

static void stats_of_no_frames(void **state)
{
	(void)state;
	stilb_prof_frame_stats stats;
	for (int marks = 0; marks < 2; marks++) {
		stilb_prof_frame_stats_take(&stats, 16);
		assert_int_equal(stats.count, 0);
		assert_false(stats.spike);
		assert_true(isinf(stats.limit_ms));
		stilb_prof_frame_mark();
	}
}

static void stats_of_frames(void **state)
{
	(void)state;
	stilb_prof_frame_stats stats;
	for (int i = 0; i < 130; i++)
		frame(100);
	frame(100000);
	stilb_prof_frame_mark();
	stilb_prof_frame_stats_take(&stats, 90);
	assert_int_equal(stats.count, 100);
	assert_int_equal(stats.last, 130);
	assert_true(stats.ms[99] >= 100);
	assert_true(stats.max_ms >= stats.ms[99] && stats.p99_ms <= stats.max_ms && stats.p50_ms <= stats.p99_ms);
	assert_true(stats.mean_ms > 1 && stats.mean_ms < stats.max_ms);
	assert_true(stats.p50_ms >= 0.1);
	assert_true(stats.limit_ms >= 90);
	assert_true(stats.spike);
	stilb_prof_frame_stats_take(&stats, 10000);
	assert_float_equal(stats.limit_ms, 10000, 0);
	assert_false(stats.spike);
	frame(100);
	stilb_prof_frame_mark();
	stilb_prof_frame_stats_take(&stats, 90);
	assert_false(stats.spike); /* the spike is not the newest frame any more */
}

/* ---- everything at once ------------------------------------------------------------------------------------------ */

static uint32_t crowd_stop;

static bool crowd_goes_on(void)
{
	return !__atomic_load_n(&crowd_stop, __ATOMIC_RELAXED); /* no data depends on it */
}

static void *crowd_records(void *user)
{
	(void)user;
	while (crowd_goes_on()) {
		stilb_prof_thread_begin("crowd");
		for (int i = 0; i < 2000; i++) {
			PROFILE("outer");
			PROFILE("inner");
		}
		sched_yield();
		stilb_prof_thread_end();
	}
	return NULL;
}

static void *crowd_asks(void *user)
{
	(void)user;
	while (crowd_goes_on()) {
		stilb_prof_capture_now();
		sleep_us(500);
	}
	return NULL;
}

/* More threads than CPUs record, begin, end and ask, while captures are started and stopped. */
static void a_crowd(void **state)
{
	(void)state;
	pthread_t threads[6];
	stilb_prof_capture_desc desc = desc_for(in_folder("a.json"));
	desc.frames_before = 3;
	desc.frames_after = 1;
	desc.spike = STILB_PROF_SPIKE_FIXED;
	desc.spike_ms = 1;
	desc.cool_down = 0;
	desc.signal = SIGUSR1;
	desc.crash = true;
	__atomic_store_n(&crowd_stop, 0, __ATOMIC_RELAXED);
	stilb_prof_ring_events_set(1024); /* keep the processors busy, not the writers of long files */
	for (int i = 0; i < 6; i++)
		assert_int_equal(pthread_create(&threads[i], NULL, i < 4 ? crowd_records : crowd_asks, NULL), 0);
	for (int round = 0; round < 3; round++) {
		start(&desc);
		for (int i = 0; i < 40; i++) {
			frame(200);
			if (i % 10 == 0)
				raise(SIGUSR1);
		}
		stilb_prof_capture_stop();
		assert_int_equal(told.last.error, 0);
	}
	__atomic_store_n(&crowd_stop, 1, __ATOMIC_RELAXED);
	for (int i = 0; i < 6; i++)
		pthread_join(threads[i], NULL);
	assert_true(told_count() >= 3);
	assert_true(is_whole_json(in_folder("a.json")));
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup_teardown(frames_before_and_after, set_up, tear_down),
		cmocka_unit_test_setup_teardown(early_frames, set_up, tear_down),
		cmocka_unit_test_setup_teardown(frames_stand_still, set_up, tear_down),
		cmocka_unit_test_setup_teardown(without_any_frame, set_up, tear_down),
		cmocka_unit_test_setup_teardown(asking_again, set_up, tear_down),
		cmocka_unit_test_setup_teardown(files_of_earlier_runs_stay, set_up, tear_down),
		cmocka_unit_test_setup_teardown(many_in_a_row, set_up, tear_down),
		cmocka_unit_test_setup_teardown(names, set_up, tear_down),
		cmocka_unit_test_setup_teardown(stop_writes_what_is_pending, set_up, tear_down),
		cmocka_unit_test_setup_teardown(a_signal_asks, set_up, tear_down),
		cmocka_unit_test_setup_teardown(refused, set_up, tear_down),
		cmocka_unit_test_setup_teardown(no_memory_to_start, set_up, tear_down),
		cmocka_unit_test_setup_teardown(cannot_be_written, set_up, tear_down),
		cmocka_unit_test_setup_teardown(nothing_half_written, set_up, tear_down),
		cmocka_unit_test_setup_teardown(tried_anew, set_up, tear_down),
		cmocka_unit_test_setup_teardown(a_spike_is_twice_the_median, set_up, tear_down),
		cmocka_unit_test_setup_teardown(the_budget_counts, set_up, tear_down),
		cmocka_unit_test_setup_teardown(a_fixed_limit, set_up, tear_down),
		cmocka_unit_test_setup_teardown(the_rings_went_round, set_up, tear_down),
		cmocka_unit_test_setup_teardown(off_is_off, set_up, tear_down),
		cmocka_unit_test_setup_teardown(a_slow_frame_of_a_real_loop, set_up, tear_down),
		cmocka_unit_test(the_window_is_sorted),
		cmocka_unit_test_setup_teardown(stats_of_no_frames, set_up, tear_down),
		cmocka_unit_test_setup_teardown(stats_of_frames, set_up, tear_down),
		cmocka_unit_test_setup_teardown(a_crowd, set_up, tear_down),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
