/* The program stilb-bench: finds the suite, reads the flags, runs it (bench.h). */
#include "bench/harness/bench.h"

#include "base/base_file.h"
#include "game/cli/flags.h"

#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define DEFAULT_ROUNDS 5
#define QUICK_ROUNDS 3
#define DEFAULT_SECONDS 0.5
#define DEFAULT_GIVE_UP 120 /* seconds */
#define QUICK_GIVE_UP 30

static const bench_suite *const suites[] = {
	&bench_queue_suite,    &bench_jobs_suite,     &bench_cull_suite,      &bench_record_suite, &bench_profiler_suite,
	&bench_shade_suite,    &bench_gi_suite,       &bench_furnace_suite,   &bench_input_suite,  &bench_import_suite,
	&bench_gltf_suite,     &bench_simplify_suite, &bench_clusters_suite,  &bench_lod_suite,    &bench_pop_suite,
	&bench_plan_suite,     &bench_bake_suite,     &bench_prefilter_suite, &bench_upload_suite, &bench_animate_suite,
	&bench_textured_suite, &bench_lights_suite,   &bench_shadows_suite,   &bench_post_suite};

/* The i-th suite; NULL after the last. The last is `threads`, whose tables the first call of bench_threads_suite
 * fills. */
static const bench_suite *suite_at(size_t i)
{
	size_t count = sizeof suites / sizeof *suites;
	return i < count ? suites[i] : i == count ? bench_threads_suite() : NULL;
}

typedef struct arguments {
	bench_options options;
	uint64_t rounds;     /* 0: not given */
	uint64_t give_up;    /* 0: not given */
	const char *seconds; /* NULL: not given */
	bool steps;
} arguments;

#define MAX_FLAGS 12

static size_t flag_table(arguments *a, flag flags[MAX_FLAGS])
{
	bench_options *options = &a->options;
	const flag table[] = {
		{"--quick", FLAG_SWITCH, &options->quick, NULL, "short runs, less than 30 s in all; less precise numbers", 0, 0,
	     NULL},
		{"--rounds", FLAG_NUMBER, &a->rounds, "N",
	     "run every subject N times in every case, 1..1000 (5; with --quick 3)", 1, 1000, NULL},
		{"--seconds", FLAG_TEXT, &a->seconds, "S",
	     "length of a run in seconds, 0.01..60 (0.5; with --quick as long as fits)", 0, 0, NULL},
		{"--only", FLAG_TEXT, &options->only, "SUBJECT,...",
	     "run these subjects only; names or shell patterns: 'stilb*'", 0, 0, NULL},
		{"--case", FLAG_TEXT, &options->cases, "CASE,...", "run these cases only; names or shell patterns: 'batch16-*'",
	     0, 0, NULL},
		{"--json", FLAG_TEXT, &options->json, "FILE", "write all numbers as JSON; - is standard output", 0, 0, NULL},
		{"--plot", FLAG_TEXT, &options->plot, "FILE", "write a picture (PNG), drawn by gnuplot", 0, 0, NULL},
		{"--traces", FLAG_TEXT, &options->traces, "DIR",
	     "threads only: write a timeline of each subject's slowest frame", 0, 0, NULL},
		{"--goals", FLAG_SWITCH, &options->goals, NULL,
	     "check against the bounds in docs/benchmarks.md, set on another CPU", 0, 0, NULL},
		{"--give-up", FLAG_NUMBER, &a->give_up, "S",
	     "kill a run that has not ended after S seconds, 1..3600 (120; with --quick 30)", 1, 3600, NULL},
		{"--list", FLAG_SWITCH, &options->list, NULL, "list the suite's subjects and cases, run nothing", 0, 0, NULL},
		{"--steps", FLAG_SWITCH, &a->steps, NULL, "queue only: run 'queue --steps' instead", 0, 0, NULL},
	};
	size_t count = sizeof table / sizeof *table;
	memcpy(flags, table, sizeof table);
	return count;
}

static void print_help(void)
{
	arguments unused = {0};
	flag flags[MAX_FLAGS];
	size_t count = flag_table(&unused, flags);
	printf(
		"stilb-bench: measures Stilb's parts on this machine, beside other libraries and the machine's limits\n\n"
		"usage: stilb-bench SUITE [FLAGS]\n\n"
		"A suite runs its subjects (implementations) in its cases (workloads) and prints tables, then three sentences\n"
		"that sum them up. 'stilb-bench SUITE --quick' is a first look.\n\n");
	for (size_t i = 0; suite_at(i); i++)
		printf("  %-16s %s\n", suite_at(i)->name, suite_at(i)->help);
	printf("  %-16s %s\n\n", "queue --steps", bench_steps_suite()->help);
	flags_print(flags, count);
}

static int refuse(const char *what, const char *value, const char *right)
{
	stilb_log("%s: '%s' %s", what, value, right);
	return EXIT_REFUSED;
}

static bool parse_seconds(const char *text, double *seconds)
{
	char *end;
	*seconds = strtod(text, &end);
	return text[strspn(text, "0123456789.")] == '\0' && end != text && *end == '\0' && *seconds >= 0.01 &&
	       *seconds <= 60.0;
}

/* EXIT_DONE if path is NULL, a folder that can be written to, or does not exist and can be created. */
static int check_folder(const char *path)
{
	struct stat status;
	if (path && stat(path, &status) == 0) {
		if (!S_ISDIR(status.st_mode) || access(path, W_OK | X_OK) != 0)
			return refuse("--traces", path, "is not a folder that can be written to");
	} else if (path && stilb_file_check(path) != STILB_OK) {
		stilb_log("--traces: %s", stilb_error_message());
		return EXIT_REFUSED;
	}
	return EXIT_DONE;
}

/* Refuses files that could not be written, before the first run. */
static int check_files(const bench_options *options)
{
	const char *paths[] = {options->json, options->plot};
	for (int i = 0; i < 2; i++)
		if (paths[i] && stilb_file_check(paths[i]) != STILB_OK) {
			stilb_log("%s", stilb_error_message());
			return EXIT_REFUSED;
		}
	if (options->json && options->plot && stilb_file_same(options->json, options->plot))
		return refuse("--plot", options->plot, "is the file of --json, too; give it another name");
	return check_folder(options->traces);
}

static int finish_options(arguments *a, const bench_suite *suite)
{
	bench_options *options = &a->options;
	uint32_t quick_rounds = suite->quick_rounds ? suite->quick_rounds : QUICK_ROUNDS;
	options->rounds = a->rounds ? (uint32_t)a->rounds : options->quick ? quick_rounds : DEFAULT_ROUNDS;
	options->give_up = a->give_up ? (uint32_t)a->give_up : options->quick ? QUICK_GIVE_UP : DEFAULT_GIVE_UP;
	options->seconds = options->quick ? 0.0 : DEFAULT_SECONDS;
	if (a->seconds && !parse_seconds(a->seconds, &options->seconds))
		return refuse("--seconds", a->seconds, "is not a number in 0.01..60");
	return check_files(options);
}

static const bench_suite *find_suite(const char *name)
{
	for (size_t i = 0; suite_at(i); i++)
		if (strcmp(suite_at(i)->name, name) == 0)
			return suite_at(i);
	return NULL;
}

static int run(int argc, char **argv)
{
	if (argc < 2) {
		stilb_log("no suite given; 'stilb-bench queue --quick' is a first look, 'stilb-bench --help' lists all suites");
		return EXIT_REFUSED;
	}
	if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0 || strcmp(argv[1], "help") == 0) {
		print_help();
		return EXIT_DONE;
	}
	const bench_suite *suite = find_suite(argv[1]);
	if (!suite)
		return refuse("suite", argv[1], "does not exist; 'stilb-bench --help' lists all");
	arguments a = {0};
	flag flags[MAX_FLAGS];
	size_t count = flag_table(&a, flags);
	flags_result parsed = flags_parse(flags, count, argc - 2, argv + 2);
	if (parsed == FLAGS_HELP)
		print_help();
	if (parsed != FLAGS_OK)
		return parsed == FLAGS_HELP ? EXIT_DONE : EXIT_REFUSED;
	if (a.steps && suite != &bench_queue_suite)
		return refuse("--steps", suite->name, "has no steps; only the suite queue has");
	if (a.options.traces && !suite->traces)
		return refuse("--traces", suite->name, "draws no frames; only the suite threads writes timelines");
	int code = finish_options(&a, suite);
	return code != EXIT_DONE ? code : bench_run(a.steps ? bench_steps_suite() : suite, &a.options);
}

int main(int argc, char **argv)
{
	signal(SIGPIPE, SIG_IGN); /* writing to a closed pipe then fails, which is reported below */
	int code = run(argc, argv);
	if ((fflush(stdout) != 0 || ferror(stdout)) && code == EXIT_DONE) {
		stilb_log("cannot write to standard output");
		return EXIT_FAILED;
	}
	return code;
}
