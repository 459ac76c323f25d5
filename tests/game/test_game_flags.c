/* Command lines by a table of flags: each kind, each error with its one line; and the statistics of stage times. */
#include "game/cli/flags.h"
#include "game/cli/nearest.h"
#include "game/cli/stage_times.h"
#include "support/test.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- flags ------------------------------------------------------------------------------------------------------- */

typedef struct values {
	bool loud;
	uint64_t number, seed;
	uint32_t workers, size[2];
	int choice;
	float share, amount;
	flag_list place;
	const char *text, *thing;
} values;

static const char *const choices[] = {"red", "green", "greenish", "sky_blue", NULL};
static values v;
static char said[8192]; /* stderr of the last parse */

static const flag table[] = {
	{"--loud", FLAG_SWITCH, &v.loud, NULL, "say more", 0, 0, NULL},
	{"--number", FLAG_NUMBER, &v.number, "N", "a number", 3, 4000, NULL},
	{"--seed", FLAG_NUMBER, &v.seed, "N", "any number", 0, UINT64_MAX, NULL},
	{"--workers", FLAG_WORKERS, &v.workers, "N", "threads", 0, 256, NULL},
	{"--size", FLAG_SIZE, v.size, "WxH", "a size", 1, 16384, NULL},
	{"--choice", FLAG_CHOICE, &v.choice, "red|green|greenish|sky-blue", "a colour", 0, 0, choices},
	{"--share", FLAG_DECIMAL, &v.share, "X", "a share", 0, 2, NULL},
	{"--amount", FLAG_AMOUNT, &v.amount, "X", "an amount", 1, 40, NULL},
	{"--place", FLAG_LIST, &v.place, "X,Y[,Z]", "a place", 2, 3, NULL},
	{"--text", FLAG_TEXT, &v.text, "FILE", "a name", 0, 0, NULL},
};
#define TABLE (sizeof table / sizeof *table)

/* A table with a row of the kind FLAG_WORD. */
static const flag table_with_word[] = {
	{"--number", FLAG_NUMBER, &v.number, "N", "a number", 3, 4000, NULL},
	{"thing", FLAG_WORD, &v.thing, NULL, NULL, 0, 0, NULL},
	{"--loud", FLAG_SWITCH, &v.loud, NULL, "say more", 0, 0, NULL},
};
#define TABLE_WITH_WORD (sizeof table_with_word / sizeof *table_with_word)

static const values defaults = {false, 10, 1, 5, {12, 34}, 1, 0.5f, 2.0f, {0}, "old", NULL};

/* Sets the defaults, parses a list of words that ends with NULL, and stores stderr in said. */
static flags_result parse_by(const flag *flags, size_t count, const char *const *words)
{
	int argc = 0;
	while (words[argc])
		argc++;
	v = defaults;
	FILE *file = tmpfile();
	assert_non_null(file);
	fflush(stderr);
	int kept = dup(STDERR_FILENO);
	dup2(fileno(file), STDERR_FILENO);
	flags_result result = flags_parse(flags, count, argc, (char **)(uintptr_t)words);
	fflush(stderr);
	dup2(kept, STDERR_FILENO);
	close(kept);
	rewind(file);
	said[fread(said, 1, sizeof said - 1, file)] = '\0';
	fclose(file);
	return result;
}

static flags_result parse(const char *const *words)
{
	return parse_by(table, TABLE, words);
}

#define PARSE(...) parse((const char *const[]){__VA_ARGS__, NULL})
#define PARSE_WORDS(...) parse_by(table_with_word, TABLE_WITH_WORD, (const char *const[]){__VA_ARGS__, NULL})

static void assert_right(flags_result result)
{
	assert_string_equal(said, "");
	assert_int_equal(result, FLAGS_OK);
}

/* Asserts a refusal with one line that begins with the program's name and contains part. */
static void assert_wrong(flags_result result, const char *part)
{
	assert_int_equal(result, FLAGS_REFUSED);
	assert_memory_equal(said, "stilb: ", 7);
	assert_ptr_equal(strchr(said, '\n'), said + strlen(said) - 1);
	assert_non_null(strstr(said, part));
}

static void test_nothing_keeps_the_defaults(void **state)
{
	(void)state;
	assert_right(parse((const char *const[]){NULL}));
	assert_memory_equal(&v, &defaults, sizeof v);
}

static void test_every_kind(void **state)
{
	(void)state;
	assert_right(PARSE("--loud", "--number", "77", "--seed=9", "--workers", "2", "--size", "640x480", "--choice",
	                   "greenish", "--text", "a b"));
	assert_true(v.loud);
	assert_true(v.number == 77 && v.seed == 9 && v.workers == 2 && v.size[0] == 640 && v.size[1] == 480 &&
	            v.choice == 2);
	assert_string_equal(v.text, "a b");
	assert_right(PARSE("--text", "--loud")); /* a value may look like a flag */
	assert_string_equal(v.text, "--loud");
	assert_false(v.loud);
	assert_right(PARSE("--choice", "sky_blue"));
	assert_int_equal(v.choice, 3);
	assert_right(PARSE("--choice=sky-blue")); /* the enumerator's '_' is typed as '-' */
	assert_int_equal(v.choice, 3);
	assert_right(PARSE("--share", "-0.25")); /* a value may begin with a minus */
	assert_true(v.share == -0.25f);
	assert_right(PARSE("--share=+1.5"));
	assert_true(v.share == 1.5f);
	assert_right(PARSE("--amount", "39.5", "--place", "-1,.5"));
	assert_true(v.amount == 39.5f && v.place.count == 2 && v.place.numbers[0] == -1.0f && v.place.numbers[1] == 0.5f);
	assert_right(PARSE("--place=1,2", "--place=3,4,-5"));
	assert_true(v.place.count == 3 && v.place.numbers[0] == 3.0f && v.place.numbers[2] == -5.0f);
	assert_right(PARSE("--text=a=b"));
	assert_string_equal(v.text, "a=b");
	assert_right(PARSE("--text", "=")); /* only the first '=' separates */
	assert_string_equal(v.text, "=");
}

static void test_bounds(void **state)
{
	(void)state;
	assert_right(PARSE("--number", "3", "--workers=0", "--size=1x16384"));
	assert_true(v.number == 3 && v.workers == 0 && v.size[0] == 1 && v.size[1] == 16384);
	assert_right(PARSE("--number", "4000", "--workers=256", "--size=16384x1"));
	assert_true(v.number == 4000 && v.workers == 256 && v.size[0] == 16384);
	assert_right(PARSE("--seed", "18446744073709551615"));
	assert_true(v.seed == UINT64_MAX);
	assert_right(PARSE("--seed", "0"));
	assert_true(v.seed == 0);
	assert_right(PARSE("--number", "0000000000000000000000000000077"));
	assert_true(v.number == 77);
	assert_right(PARSE("--workers", "auto"));
	assert_true(v.workers == FLAG_WORKERS_AUTO);
	static const struct {
		const char *text;
		float share;
	} shares[] = {{"2", 2.0f}, {"-2.000", -2.0f},    {".5", 0.5f},    {"1.", 1.0f},
	              {"0", 0.0f}, {"0.0000001", 1e-7f}, {"1e-7", 1e-7f}, {"-15E-1", -1.5f}};
	for (size_t i = 0; i < sizeof shares / sizeof *shares; i++) {
		assert_right(PARSE("--share", shares[i].text));
		assert_true(v.share == shares[i].share);
	}
	assert_right(PARSE("--share=-0"));
	assert_false(signbit(v.share)); /* -0 becomes 0: equal values have equal bits, which are hashed */
}

static void test_wrong_values(void **state)
{
	(void)state;
	static const char *const wrong[][2] = {
		{"--number", "2"},
		{"--number", "4001"},
		{"--number", "-1"},
		{"--number", "+5"},
		{"--number", " 5"},
		{"--number", "5 "},
		{"--number", "5.0"},
		{"--number", "0x10"},
		{"--number", "1e3"},
		{"--number", "banana"},
		{"--number", "5000000000"},
		{"--number", "18446744073709551626"}, /* 2^64 + 10 */
		{"--seed", "18446744073709551616"},
		{"--seed", "99999999999999999999999999"},
		{"--seed", "-1"},
		{"--workers", "257"},
		{"--workers", "-1"},
		{"--workers", "999999999"},
		{"--workers", "4294967295"},
		{"--workers", "4294967296"},
		{"--workers", "AUTO"},
		{"--workers", "auto "},
		{"--size", "0x0"},
		{"--size", "1x"},
		{"--size", "x1"},
		{"--size", "x"},
		{"--size", "12"},
		{"--size", "1x1x1"},
		{"--size", "16385x1"},
		{"--size", "1x16385"},
		{"--size", "1X1"},
		{"--size", "-1x1"},
		{"--size", "1 x1"},
		{"--size", "4294967297x1"},
		{"--share", "2.0001"},
		{"--share", "-2.0001"},
		{"--share", "-"},
		{"--share", "."},
		{"--share", "1.2.3"},
		{"--share", "+-1"},
		{"--share", " 1"},
		{"--share", "1 "},
		{"--share", "1,5"},
		{"--share", "1e1"},
		{"--share", "1e"},
		{"--share", "e1"},
		{"--share", "0x1"},
		{"--share", "nan"},
		{"--share", "-inf"},
		{"--share", "half"},
		{"--share", "99999999999999999999999999999999999999999999"},
		{"--amount", "0.999"},
		{"--amount", "40.01"},
		{"--amount", "-1"},
		{"--amount", "nan"},
		{"--amount", "4.1e1"},
		{"--amount", "1e308"},
		{"--place", "1"},
		{"--place", "1,2,3,4"},
		{"--place", "1,"},
		{"--place", ",1"},
		{"--place", "1,,2"},
		{"--place", "1 2"},
		{"--place", "1, 2"},
		{"--place", "1,2,x"},
		{"--place", "1,2,nan"},
		{"--place", "1,99999999999999999999999999999999999999999999"},
		{"--place", "-1e39,1"},
		{"--choice", "blue"},
		{"--choice", "gree"},
		{"--choice", "greeni"},
		{"--choice", "Red"},
		{"--choice", "sky-"},
		{"--choice", "sky blue"},
		{"--choice", "sky--blue"},
		{"--choice", "-red"},
	};
	for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
		char joined[64], quoted[64];
		snprintf(joined, sizeof joined, "%s=%s", wrong[i][0], wrong[i][1]);
		snprintf(quoted, sizeof quoted, "%s: '%s'", wrong[i][0], wrong[i][1]);
		assert_wrong(PARSE(wrong[i][0], wrong[i][1]), quoted);
		assert_memory_equal(&v, &defaults, sizeof v);
		assert_wrong(PARSE(joined), quoted);
		assert_memory_equal(&v, &defaults, sizeof v);
	}
	PARSE("--number", "2");
	assert_non_null(strstr(said, "3..4000")); /* names the accepted range */
	PARSE("--workers", "x");
	assert_non_null(strstr(said, "0..256 or 'auto'"));
	PARSE("--choice", "x");
	assert_non_null(strstr(said, "red, green, greenish, sky-blue"));
	PARSE("--share", "x");
	assert_non_null(strstr(said, "not a number"));
	assert_non_null(strstr(said, "-2..2"));
	PARSE("--share", "1e38");
	assert_non_null(strstr(said, "out of range; give a number in -2..2"));
	PARSE("--amount", "x");
	assert_non_null(strstr(said, "1..40"));
	PARSE("--place", "1,1e39");
	assert_non_null(strstr(said, "out of range in number 2; give numbers in -3.4e+38..3.4e+38"));
	PARSE("--place", "x");
	assert_non_null(strstr(said, "X,Y[,Z]"));
	PARSE("--size", "x");
	assert_non_null(strstr(said, "1..16384"));
}

static void test_empty_and_missing_values(void **state)
{
	(void)state;
	for (size_t i = 0; i < TABLE; i++) {
		char joined[64];
		snprintf(joined, sizeof joined, "%s=", table[i].name);
		if (table[i].kind == FLAG_SWITCH)
			continue;
		assert_wrong(PARSE(table[i].name, ""), table[i].name);
		assert_wrong(PARSE(joined), table[i].name);
		assert_wrong(PARSE("--loud", table[i].name), "missing");
		assert_non_null(strstr(said, table[i].argument));
	}
	assert_wrong(PARSE("--loud=yes"), "--loud takes no value");
	assert_wrong(PARSE("--loud="), "--loud takes no value");
}

static void test_mistyped_flags(void **state)
{
	(void)state;
	static const char *const pairs[][2] = {{"--lou", "'--loud'"},      {"--wrokers", "'--workers'"},
	                                       {"--seeed=4", "'--seed'"},  {"workers", "'--workers'"},
	                                       {"--chioce", "'--choice'"}, {"--numbr", "'--number'"}};
	for (size_t i = 0; i < sizeof pairs / sizeof *pairs; i++) {
		assert_wrong(PARSE(pairs[i][0], "5"), pairs[i][0]);
		assert_non_null(strstr(said, "; did you mean "));
		assert_non_null(strstr(said, pairs[i][1]));
	}
	assert_wrong(PARSE("--bogus", "5"), "--bogus");
	assert_null(strstr(said, "did you mean"));
}

static const char *nearest_of(const char *typed)
{
	static const char *const words[] = {"demo", "render", "bench", "replay", "trace", "shade", "pads", "info"};
	nearest_word nearest = nearest_begin(typed, strlen(typed));
	for (size_t i = 0; i < sizeof words / sizeof *words; i++)
		nearest_try(&nearest, words[i]);
	return nearest.best ? nearest.best : "";
}

static void test_nearest(void **state)
{
	(void)state;
	assert_string_equal(nearest_of("rneder"), "render");
	assert_string_equal(nearest_of("rendr"), "render");
	assert_string_equal(nearest_of("rendering"), "render");
	assert_string_equal(nearest_of("dmeo"), "demo");
	assert_string_equal(nearest_of("reply"), "replay");
	assert_string_equal(nearest_of("pad"), "pads");
	assert_string_equal(nearest_of("demo"), "demo");
	assert_string_equal(nearest_of("x"), "");
	assert_string_equal(nearest_of(""), "");
	assert_string_equal(nearest_of("dx"), "");
	assert_string_equal(nearest_of("model.gltf"), "");
	assert_string_equal(nearest_of("renderrenderrenderrenderrenderrender"), "");
}

static void test_exit_codes(void **state)
{
	(void)state;
	assert_int_equal(exit_code_of(STILB_OK), 0);
	assert_int_equal(exit_code_of(STILB_ERROR_ARGUMENT), 2);
	assert_int_equal(exit_code_of(STILB_ERROR_FILE), 2);
	assert_int_equal(exit_code_of(STILB_ERROR_DEVICE), 2);
	assert_int_equal(exit_code_of(STILB_ERROR_WINDOW), 2);
	assert_int_equal(exit_code_of(STILB_ERROR_MEMORY), 1);
	assert_int_equal(exit_code_of(STILB_ERROR_THREAD), 1);
	assert_int_equal(exit_code_of(STILB_ERROR_GIVEN_UP), 1);
	assert_int_equal(exit_code_of(STILB_ERROR_DEVICE_LOST), 1);
}

static void test_unknown_flags(void **state)
{
	(void)state;
	static const char *const unknown[] = {"--bogus", "-loud", "loud", "--lou", "--loudly", "--LOUD",   "",
	                                      "-",       "--",    "=",    "--=3",  "%s%n",     "--numbe=3"};
	for (size_t i = 0; i < sizeof unknown / sizeof *unknown; i++) {
		assert_wrong(PARSE(unknown[i], "5"), unknown[i]);
		assert_wrong(PARSE("--number", "5", unknown[i]), unknown[i]);
	}
	assert_wrong(PARSE("--a\nb\033[2J"), "--a?b?[2J"); /* control characters are replaced */
}

static void test_the_last_one_counts(void **state)
{
	(void)state;
	assert_right(PARSE("--number", "5", "--number=6", "--text", "a", "--text", "b", "--loud", "--loud", "--choice",
	                   "red", "--choice", "green", "--size", "1x1", "--size", "2x3"));
	assert_true(v.number == 6 && v.choice == 1 && v.size[0] == 2 && v.size[1] == 3 && v.loud);
	assert_string_equal(v.text, "b");
	assert_right(PARSE("--workers", "3", "--workers", "auto"));
	assert_true(v.workers == FLAG_WORKERS_AUTO);
	assert_right(PARSE("--workers", "auto", "--workers", "3"));
	assert_true(v.workers == 3);
	assert_wrong(PARSE("--number", "bad", "--number", "5"), "bad"); /* a repeated flag is checked each time */
}

/* The word of a FLAG_WORD may stand anywhere; the value of a flag is not taken for it. */
static void test_a_word(void **state)
{
	(void)state;
	assert_right(PARSE_WORDS("a", "--number", "5"));
	assert_string_equal(v.thing, "a");
	assert_right(PARSE_WORDS("--number", "5", "b", "--loud"));
	assert_string_equal(v.thing, "b");
	assert_true(v.number == 5 && v.loud);
	assert_right(PARSE_WORDS("--loud", "c"));
	assert_string_equal(v.thing, "c");
	assert_right(PARSE_WORDS("--loud"));
	assert_null(v.thing);
	assert_wrong(PARSE_WORDS("a", "b"), "'b' is one word too many: the thing is 'a' already");
	assert_wrong(PARSE_WORDS(""), "''");
	assert_wrong(PARSE_WORDS("thing=1", "--bogus"), "'--bogus'");
	assert_wrong(PARSE_WORDS("-"), "'-'"); /* a lone dash is not a word */
}

static void test_what_was_given(void **state)
{
	(void)state;
	char *words[] = {"--number", "5", "--text", "--loud", "--size=1x1", "word", "--seed", "--workers"};
	int count = sizeof words / sizeof *words;
	static const char *const given[] = {"--number", "--text", "--size", "--seed"};
	static const char *const not_given[] = {"--loud", "--workers", "--share", "--place"};
	for (size_t i = 0; i < sizeof given / sizeof *given; i++)
		assert_true(flags_given(table, TABLE, count, words, given[i]));
	for (size_t i = 0; i < sizeof not_given / sizeof *not_given; i++)
		assert_false(flags_given(table, TABLE, count, words, not_given[i]));
	assert_false(flags_given(table, TABLE, 0, NULL, "--number"));
}

static void test_numbers(void **state)
{
	(void)state;
	flag_list list = {.count = 7};
	assert_true(flags_numbers("1,-2.5,.5", 3, 3, &list));
	assert_true(list.count == 3 && list.numbers[1] == -2.5f);
	assert_false(flags_numbers("1,2", 3, 3, &list));
	assert_false(flags_numbers("sky.exr", 1, 8, &list));
	assert_false(flags_numbers("", 1, 8, &list));
	assert_true(list.count == 3); /* unchanged */
}

static void test_help_wins(void **state)
{
	(void)state;
	assert_int_equal(PARSE("--help"), FLAGS_HELP);
	assert_int_equal(PARSE("-h"), FLAGS_HELP);
	assert_int_equal(PARSE("--bogus", "--number", "bad", "--help"), FLAGS_HELP);
	assert_string_equal(said, "");
	assert_memory_equal(&v, &defaults, sizeof v);
	assert_wrong(PARSE("--help=1"), "--help=1");
	assert_wrong(PARSE("--helpme"), "--helpme");
}

/* ---- stage times ------------------------------------------------------------------------------------------------- */

static void add(stage_times *times, double frame, double gpu)
{
	stilb_engine_times ms = {.frame = frame,
	                         .cull = 2 * frame,
	                         .record = 3 * frame,
	                         .ui = 4 * frame,
	                         .replay = 5 * frame,
	                         .present = 6 * frame,
	                         .gpu = gpu};
	assert_true(stage_times_add(times, &ms));
}

static void assert_summary(const stage_summary *summary, double median, double p99, double min)
{
	assert_float_equal((float)summary->median, (float)median, 1e-6f * (float)median);
	assert_float_equal((float)summary->p99, (float)p99, 1e-6f * (float)p99);
	assert_float_equal((float)summary->min, (float)min, 1e-6f * (float)min);
}

static void test_one_frame_and_none(void **state)
{
	(void)state;
	stage_times times = {0};
	stage_summary summary[STAGE_COUNT];
	uint64_t warmup = 99;
	assert_true(stage_times_summarise(&times, summary, &warmup));
	assert_int_equal(warmup, 0);
	for (int s = 0; s < STAGE_COUNT; s++)
		assert_summary(&summary[s], 0, 0, 0);
	stage_times_last_gpu(&times, 3.0); /* without a frame it does nothing */
	add(&times, 1.5, 0.0);
	assert_true(stage_times_summarise(&times, summary, &warmup));
	assert_int_equal(warmup, 0);
	for (int s = STAGE_FRAME; s <= STAGE_PRESENT; s++)
		assert_summary(&summary[s], 1.5 * (s + 1), 1.5 * (s + 1), 1.5 * (s + 1));
	assert_summary(&summary[STAGE_GPU], 0, 0, 0);
	stage_times_last_gpu(&times, 3.0);
	assert_true(stage_times_summarise(&times, summary, &warmup));
	assert_summary(&summary[STAGE_GPU], 3, 3, 3);
	stage_times_finish(&times);
	assert_null(times.frames);
}

static void test_warm_up_is_left_out(void **state)
{
	(void)state;
	static const struct {
		int frames, warmup;
	} cases[] = {{9, 0}, {10, 1}, {19, 1}, {20, 2}, {119, 11}, {120, 12}};
	for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
		stage_times times = {0};
		stage_summary summary[STAGE_COUNT];
		uint64_t warmup;
		for (int i = 0; i < cases[c].frames; i++)
			add(&times, i < cases[c].warmup ? 0.001 : i == cases[c].warmup ? 1.0 : 2.0, 0.0);
		assert_true(stage_times_summarise(&times, summary, &warmup));
		assert_int_equal(warmup, cases[c].warmup);
		assert_summary(&summary[STAGE_FRAME], 2.0, 2.0, 1.0); /* the 1.0 counts, the 0.001 of the warm-up do not */
		stage_times_finish(&times);
	}
}

static void test_median_and_p99(void **state)
{
	(void)state;
	stage_times times = {0};
	stage_summary summary[STAGE_COUNT];
	uint64_t warmup;
	for (int i = 0; i < 100; i++)
		add(&times, 1e6, 1e6); /* the warm-up, a tenth of 1001 */
	for (int i = 0; i < 901; i++)
		add(&times, 1 + (i * 7919) % 901,
		    i % 2 ? 5.0 : 0.0); /* 1..901 in mixed order; every other GPU time is unknown */
	assert_true(stage_times_summarise(&times, summary, &warmup));
	assert_int_equal(warmup, 100);
	for (int s = STAGE_FRAME; s <= STAGE_PRESENT; s++)
		assert_summary(&summary[s], 451.0 * (s + 1), 892.0 * (s + 1), 1.0 * (s + 1));
	assert_summary(&summary[STAGE_GPU], 5, 5, 5);
	stage_times_finish(&times);
}

/* Of an endless run only the latest million frames, STAGE_TIMES_MAX, are kept. */
static void test_ring(void **state)
{
	(void)state;
	stage_times times = {0};
	stage_summary summary[STAGE_COUNT];
	uint64_t warmup;
	uint32_t more = 1500, first = (STAGE_TIMES_MAX + more) / 10; /* first frame after the warm-up */
	for (uint32_t i = 0; i < STAGE_TIMES_MAX + more; i++)
		add(&times, i < more ? 1e6 : i == first - 1 ? 0.25 : i == first ? 0.5 : 1.0 + i % 3, i % 2);
	assert_int_equal(times.capacity, STAGE_TIMES_MAX);
	assert_int_equal(times.count, STAGE_TIMES_MAX + more);
	assert_true(stage_times_summarise(&times, summary, &warmup));
	assert_int_equal(warmup, first);
	assert_summary(&summary[STAGE_FRAME], 2.0, 3.0, 0.5);
	stage_times_last_gpu(&times, 0.25);
	assert_true(stage_times_summarise(&times, summary, &warmup));
	assert_summary(&summary[STAGE_GPU], 1.0, 1.0, 0.25); /* the least is the last frame's 0.25; before all were 1 */
	for (uint32_t i = 0; i < STAGE_TIMES_MAX; i++)
		add(&times, 7.0, 0.0);
	assert_int_equal(times.capacity, STAGE_TIMES_MAX);
	assert_true(stage_times_summarise(&times, summary, &warmup));
	assert_summary(&summary[STAGE_FRAME], 7.0, 7.0, 7.0); /* the earlier frames are gone */
	stage_times_finish(&times);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_nothing_keeps_the_defaults),
		cmocka_unit_test(test_every_kind),
		cmocka_unit_test(test_bounds),
		cmocka_unit_test(test_wrong_values),
		cmocka_unit_test(test_empty_and_missing_values),
		cmocka_unit_test(test_unknown_flags),
		cmocka_unit_test(test_mistyped_flags),
		cmocka_unit_test(test_nearest),
		cmocka_unit_test(test_exit_codes),
		cmocka_unit_test(test_the_last_one_counts),
		cmocka_unit_test(test_a_word),
		cmocka_unit_test(test_what_was_given),
		cmocka_unit_test(test_numbers),
		cmocka_unit_test(test_help_wins),
		cmocka_unit_test(test_one_frame_and_none),
		cmocka_unit_test(test_warm_up_is_left_out),
		cmocka_unit_test(test_median_and_p99),
		cmocka_unit_test(test_ring),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
