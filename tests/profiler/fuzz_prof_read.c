/* Reads traces of any bytes: stilb_prof_trace_parse never crashes and returns a snapshot or an error. The snapshot
 * keeps all promises, gives a table, can be compared with itself, and is the same when it is written and read again.
 * The mutator changes whole lines and numbers, since few other changes would still be JSON. */
#include "profiler/prof_diff.h"
#include "profiler/prof_read.h"
#include "profiler/prof_trace.h"

#include "support/prof_made.h"

#include <errno.h>
#include <sys/stat.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerInitialize(int *argc, char ***argv);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed);
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size);

static void require(bool condition)
{
	if (!condition)
		abort();
}

/* ---- seeds ------------------------------------------------------------------------------------------------------- */

static void write_seed(const char *folder, const char *name, const char *text)
{
	char path[512];
	snprintf(path, sizeof path, "%s/%s", folder, name);
	FILE *file = fopen(path, "w");
	require(file && fputs(text, file) >= 0 && fclose(file) == 0);
}

/* The last argument is the folder of the seeds, which the fuzzer reads after this and adds to. */
int LLVMFuzzerInitialize(int *argc, char ***argv)
{
	const char *seeds = (*argv)[*argc - 1];
	if (*argc < 2 || seeds[0] == '-') {
		fprintf(stderr, "usage: fuzz_prof_read [-OPTION=VALUE ...] FOLDER\n");
		exit(1);
	}
	mkdir(seeds, 0777);
	for (uint64_t seed = 0; seed < 8; seed++) {
		char path[512];
		made m;
		made_by_chance(&m, seed);
		snprintf(path, sizeof path, "%s/own-%d.json", seeds, (int)seed);
		require(stilb_prof_trace_save(&m.snapshot, "fuzz", path) == 0);
		made_finish(&m);
	}
	write_seed(seeds, "array",
	           "[{\"name\":\"a\",\"ph\":\"B\",\"ts\":1,\"pid\":1,\"tid\":7},\n"
	           "{\"name\":\"\\u00e9\\ud83d\\ude00\",\"ph\":\"X\",\"ts\":2.5,\"dur\":0.25,\"tid\":7},\n"
	           "{\"ph\":\"E\",\"ts\":3e1,\"pid\":1,\"tid\":\"x\"},\n");
	write_seed(seeds, "flows",
	           "{\"traceEvents\":[\n"
	           "{\"ph\":\"C\",\"name\":\"memory\",\"ts\":2,\"args\":{\"used\":1,\"free\":-2.5e-3}},\n"
	           "{\"ph\":\"s\",\"id\":\"0x1f\",\"name\":\"n\",\"ts\":10,\"tid\":1},\n"
	           "{\"ph\":\"t\",\"id\":\"0x1f\",\"name\":\"n\",\"ts\":20,\"tid\":2},\n"
	           "{\"ph\":\"f\",\"bp\":\"e\",\"id\":\"0x1f\",\"name\":\"n\",\"ts\":30,\"tid\":3}\n]}");
	return 0;
}

/* ---- mutations --------------------------------------------------------------------------------------------------- */

typedef struct piece {
	size_t begin, end;
} piece;

/* The line around a byte, its newline included. */
static piece line_at(const uint8_t *data, size_t size, size_t at)
{
	piece line = {at, at};
	while (line.begin > 0 && data[line.begin - 1] != '\n')
		line.begin--;
	while (line.end < size && data[line.end] != '\n')
		line.end++;
	line.end += line.end < size;
	return line;
}

static bool is_digit(uint8_t c)
{
	return c >= '0' && c <= '9';
}

/* The digits at a byte or after it; empty when there are none. */
static piece digits_at(const uint8_t *data, size_t size, size_t at)
{
	while (at < size && !is_digit(data[at]))
		at++;
	piece digits = {at, at};
	while (digits.begin > 0 && is_digit(data[digits.begin - 1]))
		digits.begin--;
	while (digits.end < size && is_digit(data[digits.end]))
		digits.end++;
	return digits;
}

/* Replaces a piece of the data by text, if the result fits into max_size. */
static size_t replace(uint8_t *data, size_t size, size_t max_size, piece old, const void *text, size_t text_size)
{
	size_t new_size = size - (old.end - old.begin) + text_size;
	uint8_t *copy = malloc(text_size + 1); /* text may lie in data */
	require(copy);
	if (new_size <= max_size) {
		memcpy(copy, text, text_size);
		memmove(data + old.begin + text_size, data + old.end, size - old.end);
		memcpy(data + old.begin, copy, text_size);
		size = new_size;
	}
	free(copy);
	return size;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed)
{
	static const char *const numbers[] = {"0", "1", "2", "9999999999999", "18446744073709551616", "0.0001", "1e9", "3"};
	static const char *const phases[] = {"X", "B", "E", "i", "C", "s", "t", "f", "M", "b"};
	made_random random = {.state = seed};
	if (size == 0 || made_below(&random, 4) == 0)
		return LLVMFuzzerMutate(data, size, max_size);
	piece line = line_at(data, size, made_below(&random, size));
	piece other = line_at(data, size, made_below(&random, size));
	size_t at = made_below(&random, size);
	switch (made_below(&random, 5)) {
	case 0: /* removes a line */
		return replace(data, size, max_size, line, "", 0);
	case 1: /* inserts a copy of a line somewhere else */
		return replace(data, size, max_size, (piece){other.begin, other.begin}, data + line.begin,
		               line.end - line.begin);
	case 2: /* replaces a line by a copy of another */
		return replace(data, size, max_size, other, data + line.begin, line.end - line.begin);
	case 3: {
		const char *number = numbers[made_below(&random, sizeof numbers / sizeof *numbers)];
		return replace(data, size, max_size, digits_at(data, size, at), number, strlen(number));
	}
	default: {
		const uint8_t *phase = memmem(data + at, size - at, "\"ph\":\"", 6);
		if (phase && phase + 6 < data + size)
			data[phase + 6 - data] = (uint8_t)*phases[made_below(&random, sizeof phases / sizeof *phases)];
		return size;
	}
	}
}

/* ---- what must hold ---------------------------------------------------------------------------------------------- */

typedef struct bytes {
	char *text;
	size_t size, capacity;
} bytes;

static int bytes_write(void *user, const void *data, size_t size)
{
	bytes *b = user;
	if (b->size + size > b->capacity) {
		b->capacity = 2 * (b->size + size);
		require((b->text = realloc(b->text, b->capacity)));
	}
	memcpy(b->text + b->size, data, size);
	b->size += size;
	return 0;
}

/* Writes the snapshot and reads it back: names and counts must be the same, and times, too, except for zones nested so
 * deeply that the file cannot tell their ends apart. */
static void write_and_read(const stilb_prof_snapshot *s)
{
	bytes b = {0};
	stilb_prof_snapshot back = {0};
	char error[256];
	require(stilb_prof_trace_write_chrome(s, "fuzz", (stilb_prof_sink){bytes_write, &b}) == 0);
	if (stilb_prof_trace_parse(b.text, b.size, "back", &back, error, sizeof error) != 0) {
		fprintf(stderr, "%s\n", error);
		abort();
	}
	require(made_holds(&back) && back.frame_count == s->frame_count);
	for (uint32_t i = 0; i < s->lane_count && i < back.lane_count; i++)
		require(back.lanes[i].zone_count == s->lanes[i].zone_count || back.lane_count != s->lane_count);
	stilb_prof_snapshot_finish(&back);
	free(b.text);
}

static void use(const stilb_prof_snapshot *s)
{
	stilb_prof_stats stats = {0};
	stilb_prof_diff diff = {0};
	stilb_prof_stats_range range = {.begin_ns = s->begin_ns + (s->end_ns - s->begin_ns) / 3,
	                                .end_ns = s->begin_ns + (s->end_ns - s->begin_ns) / 2};
	stilb_prof_diff_desc desc = stilb_prof_diff_desc_default();
	uint64_t calls = 0, zones = 0;
	require(stilb_prof_stats_take(&stats, s, &range) == 0 && stilb_prof_stats_take(&stats, s, NULL) == 0);
	for (uint32_t i = 0; i < stats.row_count; i++)
		calls += stats.rows[i].calls;
	for (uint32_t i = 0; i < s->lane_count; i++)
		zones += s->lanes[i].zone_count;
	require(calls == zones);
	if (zones < 200) /* exact tests are slow */
		require(stilb_prof_diff_make(&diff, s, s, &desc) == 0 && diff.slower == 0);
	stilb_prof_diff_finish(&diff);
	stilb_prof_stats_finish(&stats);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	stilb_prof_snapshot snapshot = {0};
	char error[256] = "";
	char *copy = malloc(size ? size : 1); /* of exactly that size, so that reading beyond it is detected */
	require(copy);
	if (size > 0)
		memcpy(copy, data, size);
	int result = stilb_prof_trace_parse(copy, size, "a.json", &snapshot, error, sizeof error);
	free(copy); /* the snapshot does not refer to it */
	if (result != 0) {
		require(result == -EBADMSG && !snapshot.memory && strstr(error, "'a.json', line "));
		return 0;
	}
	require(made_holds(&snapshot));
	use(&snapshot);
	write_and_read(&snapshot);
	stilb_prof_snapshot_finish(&snapshot);
	return 0;
}
