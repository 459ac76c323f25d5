/* Command lines of random bytes: flags_parse never crashes, keeps every value in range, and prints at most one line. */
#include "game/cli/flags.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerInitialize(int *argc, char ***argv);

#define WORDS_MAX 32

static void require(bool condition)
{
	if (!condition)
		abort();
}

/* Collects the messages of flags_parse. The fuzzer keeps its own copy of stderr for its reports. */
static FILE *said;

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
	(void)argc, (void)argv;
	said = tmpfile();
	require(said);
	return 0;
}

/* Splits data into words, each ended by a zero byte. Returns their number. */
static int split(char *data, size_t size, char *words[WORDS_MAX])
{
	int count = 0;
	for (size_t at = 0; at < size && count < WORDS_MAX; at += strlen(data + at) + 1)
		words[count++] = data + at;
	return count;
}

static void require_lines(flags_result result)
{
	char text[4096];
	long end = ftell(said);
	rewind(said);
	size_t length = fread(text, 1, sizeof text, said);
	require(end >= 0 && length == (size_t)end);
	rewind(said);
	if (result != FLAGS_REFUSED) {
		require(length == 0);
		return;
	}
	require(length > 8 && memcmp(text, "stilb: ", 7) == 0);
	require(memchr(text, '\n', length) == text + length - 1);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	static const char *const choices[] = {"red", "green", "greenish", NULL};
	bool loud = false;
	uint64_t number = 10, seed = 1;
	uint32_t workers = 5, side[2] = {12, 34};
	int choice = 1;
	const char *text = "old", *word = NULL;
	float amount = 2.0f;
	flag_list place = {.count = 2};
	const flag flags[] = {
		{"--loud", FLAG_SWITCH, &loud, NULL, "say more", 0, 0, NULL},
		{"--number", FLAG_NUMBER, &number, "N", "a number", 3, 4000, NULL},
		{"--seed", FLAG_NUMBER, &seed, "N", "any number", 0, UINT64_MAX, NULL},
		{"--workers", FLAG_WORKERS, &workers, "N", "threads", 0, 256, NULL},
		{"--size", FLAG_SIZE, side, "WxH", "a size", 1, 16384, NULL},
		{"--choice", FLAG_CHOICE, &choice, "red|green|greenish", "a colour", 0, 0, choices},
		{"--text", FLAG_TEXT, &text, "FILE", "a name", 0, 0, NULL},
		{"--amount", FLAG_AMOUNT, &amount, "X", "an amount", 1, 40, NULL},
		{"--place", FLAG_LIST, &place, "X,Y[,Z]", "a place", 2, 3, NULL},
		{"word", FLAG_WORD, &word, NULL, NULL, 0, 0, NULL},
	};
	char *copy = malloc(size + 1), *words[WORDS_MAX];
	require(copy);
	if (size > 0)
		memcpy(copy, data, size);
	copy[size] = '\0';
	int count = split(copy, size, words);
	FILE *terminal = stderr;
	stderr = said;
	flags_result result = flags_parse(flags, sizeof flags / sizeof *flags, count, words);
	fflush(said);
	stderr = terminal;
	require_lines(result);
	require(ftruncate(fileno(said), 0) == 0);
	require(number >= 3 && number <= 4000);
	require(workers <= 256 || workers == FLAG_WORKERS_AUTO);
	require(side[0] >= 1 && side[0] <= 16384 && side[1] >= 1 && side[1] <= 16384);
	require(choice >= 0 && choice < 3 && text[0] != '\0');
	require(amount >= 1.0f && amount <= 40.0f && place.count >= 2 && place.count <= 3);
	require(!word || (word[0] != '\0' && word[0] != '-'));
	for (size_t i = 0; i < sizeof flags / sizeof *flags; i++)
		if (result == FLAGS_OK && flags[i].kind != FLAG_WORD)
			flags_given(flags, sizeof flags / sizeof *flags, count, words, flags[i].name);
	if (result == FLAGS_HELP)
		require(!loud && number == 10 && seed == 1 && workers == 5);
	free(copy);
	return 0;
}
