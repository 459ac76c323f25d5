/*
 * flags: reads a command line by a table with one row for each flag. `--flag value` and `--flag=value` mean the same,
 * and of a flag that is given twice the last value counts. A word that is neither a flag nor the value of one goes to
 * the row of kind FLAG_WORD, wherever it stands, or each to that of kind FLAG_WORDS.
 *
 *   uint64_t frames = 120;
 *   bool headless = false;
 *   const flag flags[] = {
 *       {"--frames", FLAG_NUMBER, &frames, "N", "frames, 1..1000000 (120)", 1, 1000000, NULL},
 *       {"--headless", FLAG_SWITCH, &headless, NULL, "no window", 0, 0, NULL},
 *   };
 *   flags_result parsed = flags_parse(flags, 2, argc, argv);
 *   if (parsed == FLAGS_HELP)
 *       flags_print(flags, 2);
 *
 * Errors.   A command line that is not understood is one line on stderr that names the flag, the value and the values
 *           that are accepted. A faulty table is the programmer's error: an assert.
 * Threads.  No function keeps state. All are [any-thread], as long as nobody else writes the values of the table.
 */
#ifndef STILB_FLAGS_H
#define STILB_FLAGS_H

#include "base/base.h"

/* The kind of a flag gives the type that flag.value points to, and the meaning of low and high. */
typedef enum flag_kind {
	FLAG_SWITCH,  /* bool, set to true; the flag takes no value */
	FLAG_NUMBER,  /* uint64_t in [low, high], decimal digits alone */
	FLAG_DECIMAL, /* float in [-high, high] */
	FLAG_WORKERS, /* uint32_t in [low, high], or FLAG_WORKERS_AUTO for the word "auto" */
	FLAG_SIZE,    /* uint32_t[2], width and height, from WxH; both in [low, high] */
	FLAG_CHOICE,  /* int, an index into choices */
	FLAG_TEXT,    /* const char *, not empty; points into argv */
	FLAG_AMOUNT,  /* float in [low, high] */
	FLAG_LIST,    /* flag_list: from low to high numbers with commas between, high <= FLAG_LIST_MAX */
	FLAG_WORD,    /* const char *, a word without a flag, at most one; `name` is what messages call it: "scene" */
	FLAG_WORDS,   /* flag_words, all words without a flag; not beside FLAG_WORD */
	FLAG_TITLE,   /* not a flag: `name` is a heading that --help prints above the flags after it */
} flag_kind;

#define FLAG_WORKERS_AUTO UINT32_MAX

#define FLAG_LIST_MAX 8

typedef struct flag_list {
	uint32_t count; /* 0: the flag was not given */
	float numbers[FLAG_LIST_MAX];
} flag_list;

/* Words that stand without a flag, in their order. The caller gives memory for as many as there are arguments. */
typedef struct flag_words {
	uint32_t count;
	const char **words;
} flag_words;

typedef struct flag {
	const char *name; /* with its dashes */
	flag_kind kind;
	void *value;          /* keeps its default unless the flag is given */
	const char *argument; /* placeholder of the value in --help and messages, "N"; NULL for a switch */
	const char *help;     /* one line; defaults stand in parentheses at its end */
	uint64_t low, high;
	const char *const *choices; /* NULL-terminated. Names of C's enumerators are fine: their '_' is typed as '-' */
} flag;

/* A table that is made of pieces, for rows that several commands share; {0} is empty. */
#define FLAG_ROWS_MAX 128
typedef struct flag_rows {
	size_t count;
	flag rows[FLAG_ROWS_MAX];
} flag_rows;

/* Appends rows. Asserts that there is room. */
void flag_rows_add(flag_rows *table, const flag *rows, size_t count);

typedef enum flags_result {
	FLAGS_OK,
	FLAGS_HELP,    /* --help or -h was among the arguments; no value has changed */
	FLAGS_REFUSED, /* the error is printed, some values may have changed: exit with EXIT_REFUSED */
} flags_result;

/* Reads the arguments argv[0], which is not the program's name, to argv[argc - 1] and stores their values in the
 * variables that the rows' `value` points to. */
flags_result flags_parse(const flag *flags, size_t flag_count, int argc, char **argv);

/* Reads from low to high numbers separated by commas, low <= high <= FLAG_LIST_MAX, into *list. Returns false, and
 * leaves *list alone, if text is anything else. A number beyond the range of float becomes infinite. */
bool flags_numbers(const char *text, uint32_t low, uint32_t high, flag_list *list);

/* True if the flag of this name is among argv[0] to argv[argc - 1], for which flags_parse returned FLAGS_OK. */
bool flags_given(const flag *flags, size_t flag_count, int argc, char **argv, const char *name);

/* Copies a choice into text as users type and see it, with '-' for each '_', cut to FLAG_CHOICE_SIZE. Returns text. */
#define FLAG_CHOICE_SIZE 64
const char *flags_choice(char text[FLAG_CHOICE_SIZE], const char *choice);

/* Prints the flags for --help on stdout: a line for each flag, for each FLAG_TITLE a heading, after an empty line if
 * it is not the first.
 * FLAG_WORD and FLAG_WORDS are left out; the command's own text names them. */
void flags_print(const flag *flags, size_t flag_count);

/* The exit codes of every subcommand: done; failed while it ran; refused before it started. */
enum { EXIT_DONE = 0, EXIT_FAILED = 1, EXIT_REFUSED = 2 };

/* The exit code after an error at the start. EXIT_REFUSED if the user named something wrong or the machine lacks it (a
 * damaged file, no such GPU, no driver, no display); EXIT_FAILED if memory or threads ran out; EXIT_DONE for
 * STILB_OK. */
int exit_code_of(stilb_result result);

#endif
