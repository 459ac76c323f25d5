/*
 * flags: command lines from a table. `--flag value` and `--flag=value` are the same; a repeated flag counts as given
 * last. Words that are no flag and no flag's value go to the table's FLAG_WORD, wherever they stand.
 * Whatever is wrong becomes one line on stderr that names the flag, the value and what would be right.
 */
#ifndef STILB_FLAGS_H
#define STILB_FLAGS_H

#include "base/base.h"

typedef enum flag_kind {
	FLAG_SWITCH,  /* bool: no value */
	FLAG_NUMBER,  /* uint64_t in [low, high] */
	FLAG_DECIMAL, /* float in [-high, high] */
	FLAG_WORKERS, /* uint32_t in [low, high], or FLAG_WORKERS_AUTO for "auto" */
	FLAG_SIZE,    /* uint32_t[2] from WxH, both in [low, high] */
	FLAG_CHOICE,  /* int: index into choices */
	FLAG_TEXT,    /* const char *, not empty */
	FLAG_AMOUNT,  /* float in [low, high] */
	FLAG_LIST,    /* flag_list: low to high numbers with commas between, at most FLAG_LIST_MAX */
	FLAG_WORD,    /* const char *: a word without a flag, once; its name is how messages call it */
	FLAG_TITLE,   /* no flag: what those after it are about */
} flag_kind;

#define FLAG_WORKERS_AUTO UINT32_MAX

#define FLAG_LIST_MAX 8

typedef struct flag_list {
	uint32_t count; /* 0: not given */
	float numbers[FLAG_LIST_MAX];
} flag_list;

typedef struct flag {
	const char *name; /* with its dashes */
	flag_kind kind;
	void *value;          /* keeps its default when the flag is not given */
	const char *argument; /* as help shows it, NULL for a switch */
	const char *help;
	uint64_t low, high;
	const char *const *choices; /* NULL-terminated; may be identifiers of C, whose '_' is typed and shown as '-' */
} flag;

typedef enum flags_result {
	FLAGS_OK,
	FLAGS_HELP,    /* --help was given */
	FLAGS_REFUSED, /* the line is printed: exit with 2 */
} flags_result;

/* Reads argv[0..argc-1]. */
flags_result flags_parse(const flag *flags, size_t flag_count, int argc, char **argv);

/* Reads low to high numbers with commas between, high <= FLAG_LIST_MAX; false, and *list stays, when text is none. A
 * number that is too large for a float is infinite. */
bool flags_numbers(const char *text, uint32_t low, uint32_t high, flag_list *list);

/* Whether the flag of this name is among argv[0..argc-1], which flags_parse took. */
bool flags_given(const flag *flags, size_t flag_count, int argc, char **argv, const char *name);

/* A choice as it is typed and shown: with '-' for each '_'. */
#define FLAG_CHOICE_SIZE 64
const char *flags_choice(char text[FLAG_CHOICE_SIZE], const char *choice);

/* One line a flag, on stdout; words have none. */
void flags_print(const flag *flags, size_t flag_count);

/* Exit codes of every subcommand. */
enum { EXIT_DONE = 0, EXIT_FAILED = 1, EXIT_REFUSED = 2 };

/* The exit code for what could not be started: refused where the user named something wrong or the machine lacks it (a
 * damaged file, no such GPU, no driver, no display), failed where memory or threads ran out. */
int exit_code_of(stilb_result result);

#endif
