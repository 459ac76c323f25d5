#include "flags.h"

#include "nearest.h"

#include <errno.h>
#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Reads decimal digits, without a sign, into *out; false if text is anything else or the number is outside [low,
 * high]. */
static bool parse_number(const char *text, uint64_t low, uint64_t high, uint64_t *out)
{
	if (text[0] == '\0' || strspn(text, "0123456789") != strlen(text))
		return false;
	errno = 0;
	uint64_t number = strtoull(text, NULL, 10);
	if (errno || number < low || number > high)
		return false;
	*out = number;
	return true;
}

static flags_result refuse_number(const flag *f, const char *value)
{
	stilb_log("%s: '%s' is not a whole number in %" PRIu64 "..%" PRIu64 "%s", f->name, value, f->low, f->high,
	          f->kind == FLAG_WORKERS ? " or 'auto'" : "");
	return FLAGS_REFUSED;
}

/* Accepts sign, digits, point and exponent, but not "inf", "nan" or hexadecimal, which strtof would take too. A number
 * beyond the range of float becomes infinite. */
static bool parse_real(const char *value, float *number)
{
	char *end;
	*number = strtof(value, &end) + 0.0f; /* turns -0 into 0 */
	return end != value && *end == '\0' && strspn(value, "+-.0123456789eE") == strlen(value);
}

static flags_result parse_between(const flag *f, const char *value, double low, double high)
{
	float number;
	bool real = parse_real(value, &number);
	if (real && (double)number >= low && (double)number <= high) {
		*(float *)f->value = number;
		return FLAGS_OK;
	}
	stilb_log(real ? "%s: '%s' is out of range; give a number in %.0f..%.0f"
	               : "%s: '%s' is not a number; give one like 0.25 in %.0f..%.0f",
	          f->name, value, low, high);
	return FLAGS_REFUSED;
}

/* Reads `low` to `high` numbers, separated by commas, into *list. Overwrites the commas of text by '\0'. */
static bool split_numbers(char *text, uint32_t low, uint32_t high, flag_list *list)
{
	char *next = text;
	while (next && list->count < high)
		if (!parse_real(strsep(&next, ","), &list->numbers[list->count++]))
			return false;
	return !next && list->count >= low;
}

bool flags_numbers(const char *text, uint32_t low, uint32_t high, flag_list *out)
{
	STILB_ASSERT(text && out && low >= 1 && low <= high && high <= FLAG_LIST_MAX);
	flag_list list = {0};
	char *copy = strdup(text);
	bool right = copy && split_numbers(copy, low, high, &list);
	free(copy);
	if (right)
		*out = list;
	return right;
}

static flags_result parse_list(const flag *f, const char *value)
{
	flag_list list;
	if (!flags_numbers(value, (uint32_t)f->low, (uint32_t)f->high, &list)) {
		stilb_log("%s: '%s' is not %s; give numbers separated by commas", f->name, value, f->argument);
		return FLAGS_REFUSED;
	}
	for (uint32_t i = 0; i < list.count; i++)
		if (!isfinite(list.numbers[i])) {
			stilb_log("%s: '%s' is out of range in number %" PRIu32 "; give numbers in -%.2g..%.2g", f->name, value,
			          i + 1, (double)FLT_MAX, (double)FLT_MAX);
			return FLAGS_REFUSED;
		}
	*(flag_list *)f->value = list;
	return FLAGS_OK;
}

static flags_result parse_size(const flag *f, const char *value)
{
	uint64_t side[2];
	const char *x = strchr(value, 'x');
	char *width = x ? strndup(value, (size_t)(x - value)) : NULL;
	bool right =
		width && parse_number(width, f->low, f->high, &side[0]) && parse_number(x + 1, f->low, f->high, &side[1]);
	free(width);
	if (!right) {
		stilb_log("%s: '%s' is not a size like 1280x720 with %" PRIu64 "..%" PRIu64 " pixels each way", f->name, value,
		          f->low, f->high);
		return FLAGS_REFUSED;
	}
	for (int i = 0; i < 2; i++)
		((uint32_t *)f->value)[i] = (uint32_t)side[i];
	return FLAGS_OK;
}

const char *flags_choice(char text[FLAG_CHOICE_SIZE], const char *choice)
{
	snprintf(text, FLAG_CHOICE_SIZE, "%s", choice);
	for (char *c = text; *c; c++)
		if (*c == '_')
			*c = '-';
	return text;
}

/* Compares a choice with a typed value; for a '_' of the choice, '-' and '_' may be typed. */
static bool is_choice(const char *choice, const char *value)
{
	for (; *value && (*choice == *value || (*choice == '_' && *value == '-')); value++)
		choice++;
	return *choice == *value;
}

static flags_result parse_choice(const flag *f, const char *value)
{
	for (int i = 0; f->choices[i]; i++)
		if (is_choice(f->choices[i], value)) {
			*(int *)f->value = i;
			return FLAGS_OK;
		}
	char list[256] = "";
	for (int i = 0; f->choices[i]; i++) {
		char choice[FLAG_CHOICE_SIZE];
		size_t length = strlen(list);
		snprintf(list + length, sizeof list - length, "%s%s", i ? ", " : "", flags_choice(choice, f->choices[i]));
	}
	stilb_log("%s: '%s' is not one of: %s", f->name, value, list);
	return FLAGS_REFUSED;
}

static flags_result parse_value(const flag *f, const char *value)
{
	uint64_t number;
	switch (f->kind) {
	case FLAG_NUMBER:
		return parse_number(value, f->low, f->high, f->value) ? FLAGS_OK : refuse_number(f, value);
	case FLAG_DECIMAL:
		return parse_between(f, value, -(double)f->high, (double)f->high);
	case FLAG_WORKERS:
		number = FLAG_WORKERS_AUTO;
		if (strcmp(value, "auto") != 0 && !parse_number(value, f->low, f->high, &number))
			return refuse_number(f, value);
		*(uint32_t *)f->value = (uint32_t)number;
		return FLAGS_OK;
	case FLAG_SIZE:
		return parse_size(f, value);
	case FLAG_CHOICE:
		return parse_choice(f, value);
	case FLAG_TEXT:
		if (value[0] == '\0') {
			stilb_log("%s: its value is empty; give %s %s", f->name, f->name, f->argument);
			return FLAGS_REFUSED;
		}
		*(const char **)f->value = value;
		return FLAGS_OK;
	case FLAG_AMOUNT:
		return parse_between(f, value, (double)f->low, (double)f->high);
	case FLAG_LIST:
		return parse_list(f, value);
	case FLAG_SWITCH:
	case FLAG_WORD:
	case FLAG_WORDS:
	case FLAG_TITLE:
		break;
	}
	return FLAGS_OK;
}

/* Prints the error, with the known flag that is most like the word. Returns 0, as parse_one does for a refusal. */
static int refuse_flag(const flag *flags, size_t flag_count, const char *word)
{
	nearest_word nearest = nearest_begin(word, strcspn(word, "="));
	for (size_t i = 0; i < flag_count; i++)
		if (flags[i].name[0] == '-')
			nearest_try(&nearest, flags[i].name);
	if (nearest.best)
		stilb_log("unknown flag '%s'; did you mean '%s'? --help lists them all", word, nearest.best);
	else
		stilb_log("unknown flag '%s'; --help lists them all", word);
	return 0;
}

/* Stores a word that is no flag in the row of kind FLAG_WORD or FLAG_WORDS. Returns 1, the number of arguments used, or
 * 0 when it is refused. */
static int parse_word(const flag *flags, size_t flag_count, const char *word)
{
	for (size_t i = 0; i < flag_count; i++) {
		if (flags[i].kind == FLAG_WORDS && word[0] != '\0') {
			flag_words *words = flags[i].value;
			words->words[words->count++] = word;
			return 1;
		}
		if (flags[i].kind != FLAG_WORD || word[0] == '\0')
			continue;
		const char **value = flags[i].value;
		if (*value) {
			stilb_log("'%s' is one word too many: the %s is '%s' already", word, flags[i].name, *value);
			return 0;
		}
		*value = word;
		return 1;
	}
	return refuse_flag(flags, flag_count, word);
}

static const flag *find_flag(const flag *flags, size_t flag_count, const char *name, size_t length)
{
	for (size_t i = 0; i < flag_count; i++)
		if (strlen(flags[i].name) == length && strncmp(flags[i].name, name, length) == 0)
			return &flags[i];
	return NULL;
}

/* Reads one flag with its value, or one word. Returns the number of arguments used, 0 when it is refused. */
static int parse_one(const flag *flags, size_t flag_count, int argc, char **argv)
{
	if (argv[0][0] != '-')
		return parse_word(flags, flag_count, argv[0]);
	const char *equals = strchr(argv[0], '=');
	size_t length = equals ? (size_t)(equals - argv[0]) : strlen(argv[0]);
	const flag *f = find_flag(flags, flag_count, argv[0], length);
	if (!f)
		return refuse_flag(flags, flag_count, argv[0]);
	if (f->kind == FLAG_SWITCH) {
		if (equals) {
			stilb_log("%s takes no value", f->name);
			return 0;
		}
		*(bool *)f->value = true;
		return 1;
	}
	if (!equals && argc < 2) {
		stilb_log("%s: its value is missing; give %s %s", f->name, f->name, f->argument);
		return 0;
	}
	if (parse_value(f, equals ? equals + 1 : argv[1]) != FLAGS_OK)
		return 0;
	return equals ? 1 : 2;
}

/* True if a row has all that its kind needs. */
static bool flag_is_sound(const flag *f)
{
	switch (f->kind) {
	case FLAG_TITLE:
		return f->name && !f->value;
	case FLAG_WORD:
		return f->name && f->value;
	case FLAG_WORDS:
		return f->name && f->value && ((const flag_words *)f->value)->words;
	case FLAG_SWITCH:
		return f->name && f->name[0] == '-' && f->value && !f->argument && f->help;
	case FLAG_CHOICE:
		if (!f->choices || !f->choices[0])
			return false;
		break;
	case FLAG_LIST:
		if (f->low < 1 || f->high > FLAG_LIST_MAX)
			return false;
		break;
	case FLAG_WORKERS:
	case FLAG_SIZE:
		if (f->high > UINT32_MAX)
			return false;
		break;
	case FLAG_NUMBER:
	case FLAG_DECIMAL:
	case FLAG_TEXT:
	case FLAG_AMOUNT:
		break;
	}
	return f->name && f->name[0] == '-' && f->value && f->argument && f->help && f->low <= f->high;
}

/* True if all rows are sound and no two flags have the same name. */
static bool flags_are_sound(const flag *flags, size_t flag_count)
{
	for (size_t i = 0; i < flag_count; i++)
		if (!flag_is_sound(&flags[i]) ||
		    find_flag(flags, flag_count, flags[i].name, strlen(flags[i].name)) != &flags[i])
			return false;
	return true;
}

void flag_rows_add(flag_rows *table, const flag *rows, size_t count)
{
	STILB_ASSERT(table && rows);
	STILB_ASSERT(count <= FLAG_ROWS_MAX - table->count && "the table has room");
	memcpy(&table->rows[table->count], rows, count * sizeof *rows);
	table->count += count;
}

flags_result flags_parse(const flag *flags, size_t flag_count, int argc, char **argv)
{
	STILB_ASSERT(argc >= 0 && (argc == 0 || argv));
	STILB_ASSERT(flags_are_sound(flags, flag_count));
	for (int i = 0; i < argc; i++)
		if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0)
			return FLAGS_HELP;
	for (int i = 0; i < argc;) {
		int taken = parse_one(flags, flag_count, argc - i, argv + i);
		if (taken == 0)
			return FLAGS_REFUSED;
		i += taken;
	}
	return FLAGS_OK;
}

bool flags_given(const flag *flags, size_t flag_count, int argc, char **argv, const char *name)
{
	STILB_ASSERT(find_flag(flags, flag_count, name, strlen(name)));
	for (int i = 0; i < argc; i++) {
		const char *equals = strchr(argv[i], '=');
		size_t length = equals ? (size_t)(equals - argv[i]) : strlen(argv[i]);
		const flag *f = argv[i][0] == '-' ? find_flag(flags, flag_count, argv[i], length) : NULL;
		if (f && strcmp(f->name, name) == 0)
			return true;
		i += f && f->kind != FLAG_SWITCH && !equals; /* skips the flag's value */
	}
	return false;
}

void flags_print(const flag *flags, size_t flag_count)
{
	for (size_t i = 0; i < flag_count; i++) {
		char left[64];
		if (flags[i].kind == FLAG_TITLE)
			printf("%s%s:\n", i > 0 ? "\n" : "", flags[i].name);
		if (flags[i].name[0] != '-')
			continue;
		snprintf(left, sizeof left, "%s %s", flags[i].name, flags[i].argument ? flags[i].argument : "");
		printf("  %-28s %s\n", left, flags[i].help);
	}
}

int exit_code_of(stilb_result result)
{
	switch (result) {
	case STILB_OK:
		return EXIT_DONE;
	case STILB_ERROR_ARGUMENT:
	case STILB_ERROR_FILE:
	case STILB_ERROR_DEVICE:
	case STILB_ERROR_WINDOW:
		return EXIT_REFUSED;
	case STILB_ERROR_MEMORY:
	case STILB_ERROR_DEVICE_LOST:
	case STILB_ERROR_THREAD:
	case STILB_ERROR_GIVEN_UP:
		break;
	}
	return EXIT_FAILED;
}
