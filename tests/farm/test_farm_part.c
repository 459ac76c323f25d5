/* Shares, identities and parts: what covers a work once is merged, anything else is refused by name. */
#include "farm/farm.h"
#include "support/folder.h"
#include "support/test.h"

#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>

static int tear_down(void **state)
{
	(void)state;
	return folder_remove();
}

/* ---- a work: unit u has the result {u * u, seed} ----------------------------------------------------------------- */

#define UNITS 37u

typedef struct squares {
	uint64_t seed, results[UNITS][2];
	uint32_t set[UNITS];
} squares;

static stilb_farm_state squares_state(void *user, uint32_t unit)
{
	return ((squares *)user)->set[unit] ? STILB_FARM_WHOLE : STILB_FARM_NEW;
}

static void squares_get(void *user, uint32_t unit, void *result)
{
	uint64_t numbers[2] = {(uint64_t)unit * unit, ((squares *)user)->seed};
	memcpy(result, numbers, sizeof numbers);
}

static bool squares_set(void *user, uint32_t unit, const void *result, bool whole)
{
	squares *s = user;
	assert_true(unit < UNITS && whole);
	memcpy(s->results[unit], result, sizeof s->results[unit]);
	s->set[unit]++;
	return s->results[unit][0] < (uint64_t)UNITS * UNITS;
}

static stilb_farm_work work_of(squares *s, const char *identity)
{
	return (stilb_farm_work){.identity = identity,
	                         .unit_count = UNITS,
	                         .unit_size = 16,
	                         .state = squares_state,
	                         .get = squares_get,
	                         .set = squares_set,
	                         .user = s};
}

static const char ours[] = "version 1\nscene 77\nseed 5\n";

static void save(const char *path, const char *identity, uint32_t index, uint32_t of)
{
	squares s = {.seed = 5};
	stilb_farm_work work = work_of(&s, identity);
	uint64_t notes[STILB_FARM_NOTES] = {index, of};
	assert_int_equal(stilb_farm_part_save(&work, index, of, notes, path), STILB_OK);
}

/* Opens, checks, merges; the parts' names are the words of a line. */
static stilb_result merge(const char *line, squares *s)
{
	char copy[512], *rest = NULL;
	stilb_farm_part *parts[16] = {NULL};
	uint32_t count = 0;
	stilb_result result = STILB_OK;
	memset(s, 0, sizeof *s);
	snprintf(copy, sizeof copy, "%s", line);
	for (char *word = strtok_r(copy, " ", &rest); word && result == STILB_OK; word = strtok_r(NULL, " ", &rest))
		result = stilb_farm_part_open(word, &parts[count++]);
	if (result == STILB_OK)
		result = stilb_farm_parts_check(parts, count);
	stilb_farm_work work = work_of(s, ours);
	for (uint32_t i = 0; i < count && result == STILB_OK; i++)
		result = stilb_farm_part_merge(parts[i], &work);
	for (uint32_t i = 0; i < count; i++)
		stilb_farm_part_close(parts[i]);
	return result;
}

static void merges(const char *line)
{
	squares s;
	if (merge(line, &s) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	for (uint32_t i = 0; i < UNITS; i++) {
		assert_int_equal(s.set[i], 1);
		assert_int_equal(s.results[i][0], i * i);
		assert_int_equal(s.results[i][1], 5);
	}
}

static void refuses(const char *line, stilb_result expected, const char *said)
{
	squares s;
	stilb_result result = merge(line, &s);
	if (result != expected || !strstr(stilb_error_message(), said))
		fail_msg("%s: %d '%s', not '%s'", line, result, stilb_error_message(), said);
}

/* ---- shares ------------------------------------------------------------------------------------------------------ */

static void shares_cover_once(void **state)
{
	(void)state;
	for (uint32_t units = 1; units < 90; units += 7)
		for (uint32_t of = 1; of < 120; of++) {
			uint32_t end = 0, least = units / of, most = (units + of - 1) / of;
			for (uint32_t index = 1; index <= of; index++) {
				stilb_farm_range range = stilb_farm_share(units, index, of);
				assert_int_equal(range.first, end);
				assert_in_range(range.count, least, most);
				end += range.count;
			}
			assert_int_equal(end, units);
		}
	stilb_farm_range last = stilb_farm_share(UINT32_MAX, UINT32_MAX, UINT32_MAX); /* no product overflows */
	assert_int_equal(last.first, UINT32_MAX - 1);
	assert_int_equal(last.count, 1);
}

static void differences_have_names(void **state)
{
	(void)state;
	stilb_farm_difference d;
	assert_false(stilb_farm_differ(ours, ours, &d));
	assert_true(stilb_farm_differ(ours, "version 1\nscene 77\nseed 6\n", &d));
	assert_int_equal(d.name_length, 4);
	assert_memory_equal(d.name, "seed", 4);
	assert_true(d.a_length == 1 && d.a[0] == '5' && d.b_length == 1 && d.b[0] == '6');
	assert_true(stilb_farm_differ("version 1\nscene 77\n", ours, &d)); /* a lacks a line */
	assert_memory_equal(d.name, "seed", 4);
	assert_true(!d.a && d.a_length == 0 && d.b[0] == '5');
	int length;
	assert_memory_equal(stilb_farm_value(ours, "scene", &length), "77", 2);
	assert_int_equal(length, 2);
	assert_null(stilb_farm_value(ours, "see", &length));
	assert_true(stilb_farm_binary() != 0 && stilb_farm_binary() == stilb_farm_binary());
}

/* ---- parts ------------------------------------------------------------------------------------------------------- */

static void any_parts_in_any_order(void **state)
{
	(void)state;
	save("1", ours, 1, 1);
	save("a", ours, 1, 3);
	save("b", ours, 2, 3);
	save("c", ours, 3, 3);
	save("5", ours, 5, 6); /* 5/6 and 6/6 are 3/3 */
	save("6", ours, 6, 6);
	merges("1");
	merges("a b c");
	merges("c a b");
	merges("b 6 5 a");
	save("x", ours, 1, 100); /* holds nothing */
	merges("c x b x a");
	refuses("a b 5", STILB_ERROR_ARGUMENT, "from 81.08 to 100 %"); /* from unit 30 of 37 */
	folder_clear();
}

static void what_does_not_fit(void **state)
{
	(void)state;
	save("a", ours, 1, 3);
	save("b", ours, 2, 3);
	save("c", ours, 3, 3);
	save("d", ours, 1, 2);
	save("seed", "version 1\nscene 77\nseed 6\n", 2, 3);
	save("scene", "version 1\nscene 78\nseed 5\n", 2, 3);
	save("build", "version 1\nbinary 78\nscene 77\nseed 5\n", 2, 3);
	refuses("a c", STILB_ERROR_ARGUMENT, "1 of 3 parts is missing: 2/3");
	refuses("b", STILB_ERROR_ARGUMENT, "2 of 3 parts are missing: 1/3, 3/3");
	refuses("a b c b", STILB_ERROR_ARGUMENT, "'b', part 2/3, and 'b', part 2/3, hold the same units");
	refuses("c d b a", STILB_ERROR_ARGUMENT, "'a', part 1/3, and 'd', part 1/2, hold the same units");
	refuses("a seed c", STILB_ERROR_ARGUMENT, "'seed' does not belong to 'a': its seed is 6, not 5");
	refuses("a scene c", STILB_ERROR_ARGUMENT, "'scene' is of another scene than 'a'");
	refuses("a build c", STILB_ERROR_ARGUMENT, "'build' was made by another build");
	refuses("a none c", STILB_ERROR_FILE, "none");
	folder_clear();
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

static size_t read_file(const char *path, unsigned char *bytes, size_t room)
{
	FILE *stream = fopen(path, "rb");
	assert_non_null(stream);
	size_t size = fread(bytes, 1, room, stream);
	fclose(stream);
	return size;
}

static void write_file(const char *path, const unsigned char *bytes, size_t size)
{
	FILE *stream = fopen(path, "wb");
	assert_non_null(stream);
	assert_int_equal(fwrite(bytes, 1, size, stream), size);
	fclose(stream);
}

/* Every byte of a file counts: each changed, each length. */
static void damage_is_seen(void **state)
{
	(void)state;
	static unsigned char good[4096], bad[sizeof good];
	squares s;
	save("a", ours, 1, 2);
	save("b", ours, 2, 2);
	size_t size = read_file("b", good, sizeof good);
	assert_in_range(size, 400, sizeof good - 1);
	for (size_t i = 0; i < size; i++) {
		memcpy(bad, good, size);
		bad[i] ^= 1u << (i % 8);
		write_file("bad", bad, size);
		assert_int_not_equal(merge("a bad", &s), STILB_OK);
	}
	for (size_t length = 0; length < size; length++) {
		write_file("bad", good, length);
		assert_int_equal(merge("a bad", &s), STILB_ERROR_FILE);
		assert_non_null(strstr(stilb_error_message(), "'bad'"));
	}
	memcpy(bad, good, size);
	write_file("bad", bad, size + 1);
	assert_int_equal(merge("a bad", &s), STILB_ERROR_FILE);
	write_file("bad", (const unsigned char *)"no part", 7);
	refuses("bad", STILB_ERROR_FILE, "'bad' is no part of this version");
	assert_int_equal(mkfifo("pipe", 0600), 0);
	refuses("pipe", STILB_ERROR_FILE, "pipe");
	merges("a b");
	folder_clear();
}

/* A disk that fills leaves the old part. */
static void whole_or_not_at_all(void **state)
{
	(void)state;
	save("a", ours, 1, 1);
	struct rlimit old, small = {.rlim_cur = 300};
	assert_int_equal(getrlimit(RLIMIT_FSIZE, &old), 0);
	small.rlim_max = old.rlim_max;
	signal(SIGXFSZ, SIG_IGN);
	squares s = {.seed = 6};
	stilb_farm_work work = work_of(&s, ours);
	assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
	stilb_result result = stilb_farm_part_save(&work, 1, 1, (uint64_t[STILB_FARM_NOTES]){0}, "a");
	assert_int_equal(setrlimit(RLIMIT_FSIZE, &old), 0);
	assert_int_equal(result, STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), "'a'"));
	merges("a");
	assert_int_equal(folder_clear(), 1);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(shares_cover_once),      cmocka_unit_test(differences_have_names),
		cmocka_unit_test(any_parts_in_any_order), cmocka_unit_test(what_does_not_fit),
		cmocka_unit_test(damage_is_seen),         cmocka_unit_test(whole_or_not_at_all),
	};
	return cmocka_run_group_tests(tests, folder_make, tear_down);
}
