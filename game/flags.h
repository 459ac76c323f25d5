/*
 * flags: command lines from a table. `--flag value` and `--flag=value` are the same; a repeated flag counts as given last.
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
} flag_kind;

#define FLAG_WORKERS_AUTO UINT32_MAX

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

/* Reads argv[0..argc-1], which holds flags only. */
flags_result flags_parse(const flag *flags, size_t flag_count, int argc, char **argv);

/* A choice as it is typed and shown: with '-' for each '_'. */
#define FLAG_CHOICE_SIZE 64
const char *flags_choice(char text[FLAG_CHOICE_SIZE], const char *choice);

/* One line a flag, on stdout. */
void flags_print(const flag *flags, size_t flag_count);

/* Exit codes of every subcommand. */
enum { EXIT_DONE = 0, EXIT_FAILED = 1, EXIT_REFUSED = 2 };

#endif
