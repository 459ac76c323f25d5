/* Report descriptors of any bytes: stilb_input_descriptor_parse returns a table or a reason; all that is in the table
 * is within the reports, the reports have the sizes that a plain walk over the items finds, and values of a report of
 * any bytes are read, or refused, by the bit. The mutator changes whole items of the descriptor, because random changes
 * of bytes seldom give a valid one. */
#include "input/hid/input_descriptor.h"

#include "support/input_descriptors.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerInitialize(int *argc, char ***argv);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed);
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size);

/* Checks are not instrumented, so that the fuzzer follows the branches of the parser alone. */
#define UNTRACED __attribute__((no_sanitize("coverage")))

UNTRACED static void require(bool condition)
{
	if (!condition)
		abort();
}

static uint8_t *random_bytes; /* STILB_INPUT_REPORT_MAX of them, and the end of the memory */

/* The last argument is the folder of the seeds, which the fuzzer reads after this and adds to. */
int LLVMFuzzerInitialize(int *argc, char ***argv)
{
	const char *seeds = (*argv)[*argc - 1];
	if (*argc < 2 || seeds[0] == '-') {
		fprintf(stderr, "usage: fuzz_input_descriptor [-OPTION=VALUE ...] FOLDER\n");
		exit(1);
	}
	require((random_bytes = malloc(STILB_INPUT_REPORT_MAX)));
	for (size_t i = 0; i < STILB_INPUT_REPORT_MAX; i++)
		random_bytes[i] = (uint8_t)stilb_random_u64(1, i);
	mkdir(seeds, 0777);
	for (size_t i = 0; i < input_test_descriptor_count; i++) {
		const input_test_descriptor *pad = &input_test_descriptors[i];
		char path[512];
		snprintf(path, sizeof path, "%s/pad-%zu", seeds, i);
		FILE *file = fopen(path, "wb");
		require(file && fwrite(pad->bytes, 1, pad->size, file) == pad->size && fclose(file) == 0);
	}
	return 0;
}

/* ---- mutations --------------------------------------------------------------------------------------------------- */

/* Bytes that the item takes; at least 1, at most what is left. */
UNTRACED static size_t item_size(const uint8_t *data, size_t left)
{
	size_t size = data[0] == 0xfe && left >= 2 ? 3u + data[1] : 1u + ((data[0] & 3) == 3 ? 4 : data[0] & 3);
	return size < left ? size : left;
}

/* The offset at which the item begins that holds the byte at this offset. */
UNTRACED static size_t item_at(const uint8_t *data, size_t size, size_t byte)
{
	size_t at = 0;
	for (size_t next; at < size && (next = at + item_size(data + at, size - at)) <= byte;)
		at = next;
	return at;
}

UNTRACED static size_t replace(uint8_t *data, size_t size, size_t max_size, size_t at, size_t old, const uint8_t *with,
                               size_t length)
{
	uint8_t copy[8];
	if (length > sizeof copy || size - old + length > max_size)
		return size;
	memcpy(copy, with, length); /* copied first, because `with` may lie in the data that is moved */
	memmove(data + at + length, data + at + old, size - at - old);
	memcpy(data + at, copy, length);
	return size - old + length;
}

UNTRACED size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed)
{
	static const uint8_t ends[] = {0, 1, 2, 7, 8, 31, 32, 33, 64, 127, 128, 255};
	uint64_t random = stilb_random_u64(seed, 0);
	if (size == 0 || random % 4 == 0)
		return LLVMFuzzerMutate(data, size, max_size);
	size_t at = item_at(data, size, (random >> 8 & 0xffff) % size), length = item_size(data + at, size - at);
	size_t other = item_at(data, size, (random >> 24 & 0xffff) % size);
	size_t other_length = item_size(data + other, size - other);
	uint8_t made[] = {(uint8_t)((random >> 48 & 0xfc) | (random >> 40 & 3)), (uint8_t)(random >> 56),
	                  (uint8_t)(random >> 52), (uint8_t)(random >> 44), (uint8_t)(random >> 40)};
	switch (random >> 4 & 7) {
	case 0: /* remove an item */
		return replace(data, size, max_size, at, length, data, 0);
	case 1: /* copy an item to another place */
		return replace(data, size, max_size, other, 0, data + at, length);
	case 2: /* replace an item by another */
		return replace(data, size, max_size, other, other_length, data + at, length);
	case 3: /* insert a new item */
		return replace(data, size, max_size, at, 0, made, item_size(made, sizeof made));
	case 4: /* another tag with the same data */
		data[at] = (uint8_t)((data[at] & 3) | (random >> 48 & 0xfc));
		return size;
	default: /* other data, at the ends of its range */
		if (length > 1)
			data[at + 1] = ends[(random >> 48) % sizeof ends];
		return size;
	}
}

/* ---- what must hold ---------------------------------------------------------------------------------------------- */

/* Sizes of reports in bits by kind and id, from a walk that looks only at the items that determine them. */
typedef struct plain_sizes {
	uint32_t bits[3][256];
	bool seen[3][256], numbered;
} plain_sizes;

UNTRACED static uint32_t item_data(const uint8_t *data, size_t size)
{
	uint32_t value = 0;
	for (size_t i = 1; i < size; i++)
		value |= (uint32_t)data[i] << 8 * (i - 1);
	return value;
}

UNTRACED static void plain_walk(const uint8_t *data, size_t size, plain_sizes *sizes)
{
	struct {
		uint32_t size, count, id;
	} now = {0}, stack[16];
	uint32_t depth = 0;
	for (size_t at = 0, length; at < size; at += length) {
		length = item_size(data + at, size - at);
		uint32_t value = data[at] == 0xfe ? 0 : item_data(data + at, length);
		int kind = (data[at] & 0xfc) == 0x80 ? 0 : (data[at] & 0xfc) == 0x90 ? 1 : (data[at] & 0xfc) == 0xb0 ? 2 : -1;
		switch (data[at] & 0xfc) {
		case 0x74:
			now.size = value;
			break;
		case 0x84:
			now.id = value;
			sizes->numbered = true;
			break;
		case 0x94:
			now.count = value;
			break;
		case 0xa4:
			stack[depth++] = now;
			break;
		case 0xb4:
			now = stack[--depth];
			break;
		}
		if (kind < 0)
			continue;
		sizes->seen[kind][now.id] = true;
		sizes->bits[kind][now.id] += now.size * now.count;
	}
}

UNTRACED static void require_reports(const stilb_input_descriptor *parsed, plain_sizes *sizes)
{
	require(parsed->report_count <= STILB_INPUT_REPORTS_MAX && parsed->numbered == sizes->numbered);
	for (uint32_t i = 0; i < parsed->report_count; i++) {
		const stilb_input_report *report = &parsed->reports[i];
		require(report->kind < 3 && sizes->seen[report->kind][report->id]);
		sizes->seen[report->kind][report->id] = false; /* each report is listed once */
		require(report->size == (sizes->bits[report->kind][report->id] + 7) / 8 + sizes->numbered);
		require(report->size <= STILB_INPUT_REPORT_MAX);
	}
	for (int kind = 0; kind < 3; kind++)
		for (int id = 0; id < 256; id++)
			require(!sizes->seen[kind][id]);
}

UNTRACED static void require_value(const stilb_input_field *field, uint32_t i, const uint8_t *report, size_t size)
{
	uint64_t begin = field->bit + (uint64_t)i * field->size, end = begin + field->size;
	uint32_t value = 0x5a5a5a5a;
	bool read = stilb_input_bits(report, size, (uint32_t)begin, field->size, &value);
	require(read == (field->size <= 32 && end <= 8 * size));
	if (!read) {
		require(value == 0x5a5a5a5a);
		return;
	}
	uint32_t slowly = 0;
	for (uint64_t bit = begin; bit < end; bit++)
		slowly |= (uint32_t)(report[bit / 8] >> bit % 8 & 1) << (bit - begin);
	require(value == slowly);
}

UNTRACED static void require_field(const stilb_input_field *field, const plain_sizes *sizes, uint64_t seed)
{
	uint32_t bits = sizes->bits[field->kind][field->report_id] + (sizes->numbered ? 8 : 0);
	require(field->kind < 3 && field->size >= 1 && field->count >= 1);
	require((uint64_t)field->bit + (uint64_t)field->size * field->count <= bits);
	require(field->bit >= (sizes->numbered ? 8 : 0));
	require(!(field->flags & STILB_INPUT_CONSTANT) && field->logical_min <= field->logical_max);
	require(field->usage <= field->usage_last && field->usage >> 16 == field->usage_last >> 16);
	if (field->flags & STILB_INPUT_VARIABLE)
		require(field->usage_last - field->usage < field->count);
	else
		require(field->usage_last - field->usage <= field->logical_max - field->logical_min);
	size_t whole = (bits + 7) / 8, size = seed % 4 ? whole : seed / 4 % (whole + 1);
	const uint8_t *report = random_bytes + STILB_INPUT_REPORT_MAX - size;
	uint32_t step = 1 + field->count / 16;
	for (uint32_t i = 0; i <= field->count; i += step)
		require_value(field, i, report, size);
	require_value(field, field->count - 1, report, size);
}

UNTRACED int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	static stilb_input_descriptor parsed;
	uint8_t *copy = malloc(size ? size : 1); /* of exactly that size: a read beyond its end is noticed */
	require(copy);
	if (size > 0)
		memcpy(copy, data, size);
	stilb_result result = stilb_input_descriptor_parse(copy, size, &parsed);
	free(copy);
	if (result != STILB_OK) {
		size_t offset;
		require(result == STILB_ERROR_ARGUMENT && parsed.field_count == 0 && parsed.report_count == 0);
		require(sscanf(stilb_error_message(), "report descriptor, byte %zu: ", &offset) == 1 && offset <= size);
		return 0;
	}
	plain_sizes sizes = {0};
	plain_walk(data, size, &sizes);
	require_reports(&parsed, &sizes);
	require(parsed.field_count <= STILB_INPUT_FIELDS_MAX);
	uint64_t hash = stilb_hash_fnv1a64(STILB_FNV1A64_START, data, size);
	for (uint32_t i = 0; i < parsed.field_count; i++)
		require_field(&parsed.fields[i], &sizes, stilb_random_u64(hash, i));
	return 0;
}
