/* input_descriptor: parses a HID report descriptor into fields. Every item of the specification, every refusal, and the
 * fields of real pads' descriptors. */
#include "input/hid/input_descriptor.h"

#include "support/input_descriptors.h"
#include "support/test.h"
#include "test_input_descriptor_tables.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

static stilb_input_descriptor parsed;

/* ---- descriptors in few words ------------------------------------------------------------------------------------ */

/* Parses a copy in memory of exactly that size, so that the address sanitizer notices a read beyond its end. */
static stilb_result parse_bytes(const uint8_t *bytes, size_t size)
{
	uint8_t *copy = malloc(size ? size : 1);
	assert_non_null(copy);
	memcpy(copy, bytes, size);
	memset(&parsed, 0xa5, sizeof parsed);
	stilb_result result = stilb_input_descriptor_parse(copy, size, &parsed);
	free(copy);
	return result;
}

/* Reads hexadecimal bytes like "75 08 | 95 01"; "|" only groups them for the reader. Returns their number. */
static size_t from_hex(const char *hex, uint8_t *bytes, size_t capacity)
{
	size_t size = 0;
	for (const char *at = hex; *at;) {
		if (*at == ' ' || *at == '|') {
			at++;
			continue;
		}
		char pair[3] = {at[0], at[1], '\0'};
		assert_true(size < capacity);
		bytes[size++] = (uint8_t)strtoul(pair, NULL, 16);
		at += 2;
	}
	return size;
}

static stilb_result parse_hex(const char *hex)
{
	uint8_t bytes[1024];
	return parse_bytes(bytes, from_hex(hex, bytes, sizeof bytes));
}

static void good(const char *hex)
{
	stilb_result result = parse_hex(hex);
	if (result != STILB_OK)
		print_error("%s\n", stilb_error_message());
	assert_int_equal(result, STILB_OK);
}

/* Checks that the descriptor is refused with this message, and that no fields are left. */
static void refused(const char *hex, const char *message)
{
	assert_int_equal(parse_hex(hex), STILB_ERROR_ARGUMENT);
	assert_string_equal(stilb_error_message(), message);
	assert_int_equal(parsed.field_count, 0);
	assert_int_equal(parsed.report_count, 0);
}

/* A field as the tables write it: id@bit size[*count] usage[-last] logical [(physical)] flags group. */
static void field_text(const stilb_input_field *field, char *text, size_t size)
{
	size_t n = (size_t)snprintf(text, size, "%02x@%u %u", field->report_id, field->bit, field->size);
	if (field->count > 1)
		n += (size_t)snprintf(text + n, size - n, "*%u", field->count);
	n += (size_t)snprintf(text + n, size - n, " %x", field->usage);
	if (field->usage_last != field->usage)
		n += (size_t)snprintf(text + n, size - n, "-%x", field->usage_last);
	n += (size_t)snprintf(text + n, size - n, " %lld..%lld", (long long)field->logical_min,
	                      (long long)field->logical_max);
	if (field->physical_min || field->physical_max)
		n += (size_t)snprintf(text + n, size - n, " (%lld..%lld)", (long long)field->physical_min,
		                      (long long)field->physical_max);
	n += (size_t)snprintf(text + n, size - n, "%s%s%s", field->flags & STILB_INPUT_VARIABLE ? "" : " array",
	                      field->flags & STILB_INPUT_RELATIVE ? " relative" : "",
	                      field->flags & STILB_INPUT_NULL ? " null" : "");
	if (field->group)
		n += (size_t)snprintf(text + n, size - n, " g%u", field->group);
	assert_true(n < size);
}

/* Checks that the fields of this kind, written by field_text with a line each, are the expected ones. */
static void fields_are(stilb_input_field_kind kind, const char *expected)
{
	char text[8192] = "";
	size_t n = 0;
	for (uint32_t i = 0; i < parsed.field_count; i++) {
		if (parsed.fields[i].kind != kind)
			continue;
		field_text(&parsed.fields[i], text + n, sizeof text - n - 1);
		n += strlen(text + n);
		text[n++] = '\n';
		text[n] = '\0';
	}
	assert_string_equal(text, expected);
}

static void reports_are(const char *expected)
{
	char text[4096] = "";
	size_t n = 0;
	for (uint32_t i = 0; i < parsed.report_count && n < sizeof text; i++)
		n += (size_t)snprintf(text + n, sizeof text - n, "%s%c%02x:%u", i ? " " : "", "iof"[parsed.reports[i].kind],
		                      parsed.reports[i].id, parsed.reports[i].size);
	assert_string_equal(text, expected);
}

/* ---- real descriptors -------------------------------------------------------------------------------------------- */

/* The report that a field is in; it must exist. */
static const stilb_input_report *report_of(const stilb_input_field *field)
{
	for (uint32_t i = 0; i < parsed.report_count; i++)
		if (parsed.reports[i].kind == field->kind && parsed.reports[i].id == field->report_id)
			return &parsed.reports[i];
	fail_msg("a field without a report");
	return NULL;
}

static void test_tables(void **state)
{
	(void)state;
	assert_int_equal(COUNT(descriptor_tables), input_test_descriptor_count);
	for (size_t i = 0; i < input_test_descriptor_count; i++) {
		assert_string_equal(descriptor_tables[i].name, input_test_descriptors[i].name);
		assert_int_equal(parse_bytes(input_test_descriptors[i].bytes, input_test_descriptors[i].size), STILB_OK);
		reports_are(descriptor_tables[i].reports);
		fields_are(STILB_INPUT_FIELD_INPUT, descriptor_tables[i].fields);
		for (uint32_t k = 0; k < parsed.field_count; k++) {
			const stilb_input_field *field = &parsed.fields[k];
			assert_true(field->bit + field->size * field->count <= 8 * report_of(field)->size);
			assert_true(field->size && field->count && field->usage_last >= field->usage);
			assert_true(field->logical_min <= field->logical_max);
		}
	}
}

/* The fields of an output report, here that for rumble, are read like those of input reports. */
static void test_outputs_of_an_xbox_pad(void **state)
{
	(void)state;
	const input_test_descriptor *pad = input_test_descriptor_find(STILB_INPUT_BUS_BLUETOOTH, 0x045e, 0x02e0);
	assert_int_equal(parse_bytes(pad->bytes, pad->size), STILB_OK);
	fields_are(STILB_INPUT_FIELD_OUTPUT, "03@8 4 f0097 0..1\n"
	                                     "03@16 8*4 f0070 0..100\n"
	                                     "03@48 8 f0050 0..255\n"
	                                     "03@56 8 f00a7 0..255\n"
	                                     "03@64 8 f007c 0..255\n");
	for (uint32_t i = 0; i < parsed.field_count; i++) {
		const stilb_input_field *field = &parsed.fields[i];
		assert_int_equal(field->collection, 0x10005);
		if (field->usage == 0xf0050) { /* hundredths of a second */
			assert_int_equal(field->unit, 0x1001);
			assert_int_equal(field->exponent, -2);
		}
	}
}

/* A descriptor that is cut off anywhere is refused, because it then ends inside an item or a collection; the exception
 * are the few places between two collections. */
static void test_prefixes_are_refused(void **state)
{
	(void)state;
	for (size_t i = 0; i < input_test_descriptor_count; i++) {
		const input_test_descriptor *pad = &input_test_descriptors[i];
		size_t whole = pad->size - (pad->bytes[pad->size - 1] == 0); /* some have a superfluous zero at their end */
		uint32_t good_ones = 0;
		for (size_t size = 8; size < whole; size++) { /* from 8 bytes on the first collection has begun */
			stilb_result result = parse_bytes(pad->bytes, size);
			good_ones += result == STILB_OK;
			if (result == STILB_OK)
				continue;
			assert_true(strstr(stilb_error_message(), "cut off") || strstr(stilb_error_message(), "not end"));
			assert_int_equal(parsed.field_count, 0);
		}
		/* The Asus and the Elite have another collection behind the pad's, and items of two bytes before it. */
		bool two = pad->vendor == 0x18d1 || pad->product == 0x0b05;
		assert_int_equal(good_ones, two ? 3 : 0);
	}
}

/* ---- values ------------------------------------------------------------------------------------------------------ */

static uint64_t bits_slowly(const uint8_t *bytes, uint32_t bit, uint32_t count)
{
	uint64_t value = 0;
	for (uint32_t i = 0; i < count; i++)
		value |= (uint64_t)(bytes[(bit + i) / 8] >> (bit + i) % 8 & 1) << i;
	return value;
}

static void test_bits(void **state)
{
	(void)state;
	uint8_t bytes[9];
	for (size_t i = 0; i < sizeof bytes; i++)
		bytes[i] = (uint8_t)stilb_random_u64(1, i);
	for (size_t size = 0; size <= sizeof bytes; size++) {
		uint8_t *report = malloc(size ? size : 1); /* the address sanitizer sees what reads beyond it */
		memcpy(report, bytes, size);
		for (uint32_t bit = 0; bit <= 80; bit++) {
			for (uint32_t count = 0; count <= 40; count++) {
				uint32_t value = 0xdeadbeef;
				bool inside = count >= 1 && count <= 32 && bit + count <= 8 * size;
				assert_int_equal(stilb_input_bits(report, size, bit, count, &value), inside);
				assert_int_equal(value, inside ? bits_slowly(report, bit, count) : 0xdeadbeef);
			}
		}
		free(report);
	}
	uint32_t value;
	assert_false(stilb_input_bits(bytes, sizeof bytes, UINT32_MAX, 1, &value));
	assert_false(stilb_input_bits(bytes, sizeof bytes, UINT32_MAX - 7, 32, &value));
}

static void write_bits(uint8_t *report, uint32_t bit, uint32_t count, uint64_t value)
{
	for (uint32_t i = 0; i < count; i++) {
		report[(bit + i) / 8] &= (uint8_t) ~(1u << (bit + i) % 8);
		report[(bit + i) / 8] |= (uint8_t)((value >> i & 1) << (bit + i) % 8);
	}
}

/* Checks that each value of the field's range, written into element i, is read back, with `around` in all other bytes
 * of the report. */
static void element_says(const stilb_input_field *field, uint32_t i, size_t size, uint8_t around)
{
	uint8_t report[STILB_INPUT_REPORT_MAX];
	uint32_t bit = field->bit + i * field->size;
	int64_t values[] = {field->logical_min, field->logical_max, (field->logical_min + field->logical_max) / 2};
	for (size_t k = 0; k < COUNT(values); k++) {
		uint32_t value = 0;
		memset(report, around, size);
		write_bits(report, bit, field->size, (uint64_t)values[k]);
		assert_true(stilb_input_bits(report, size, bit, field->size, &value));
		assert_int_equal(value, values[k] & (int64_t)(UINT64_MAX >> (64 - field->size)));
	}
	/* A report that ends before its last bit has no value. */
	size_t end = (bit + field->size + 7) / 8;
	uint32_t value = 0;
	assert_true(stilb_input_bits(report, end, bit, field->size, &value));
	value = 0x5a5a5a5a;
	assert_false(stilb_input_bits(report, end - 1, bit, field->size, &value));
	assert_int_equal(value, 0x5a5a5a5a);
}

static void test_every_element_of_every_pad(void **state)
{
	(void)state;
	for (size_t i = 0; i < input_test_descriptor_count; i++) {
		assert_int_equal(parse_bytes(input_test_descriptors[i].bytes, input_test_descriptors[i].size), STILB_OK);
		for (uint32_t k = 0; k < parsed.field_count; k++) {
			const stilb_input_field *field = &parsed.fields[k];
			for (uint32_t e = 0; e < field->count; e++) {
				element_says(field, e, report_of(field)->size, 0x00);
				element_says(field, e, report_of(field)->size, 0xff);
			}
		}
	}
}

static void test_signed_values(void **state)
{
	(void)state;
	good("05 01 | 15 81 25 7f 75 08 95 01 09 30 81 02 | 15 00 25 ff 09 31 81 02 |"
	     "16 00 80 26 ff 7f 75 10 09 32 81 02 | 17 00 00 00 80 27 ff ff ff 7f 75 20 09 33 81 02 |"
	     "15 00 27 ff ff ff ff 09 34 81 02 | 15 fc 25 03 75 03 09 35 81 02 | 15 ff 25 00 75 01 09 36 81 02");
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8 10030 -127..127\n"
	                                    "00@8 8 10031 0..255\n"
	                                    "00@16 16 10032 -32768..32767\n"
	                                    "00@32 32 10033 -2147483648..2147483647\n"
	                                    "00@64 32 10034 0..4294967295\n"
	                                    "00@96 3 10035 -4..3\n"
	                                    "00@99 1 10036 -1..0\n");
	reports_are("i00:13");
	/* A maximum is signed if its minimum is negative; the same for the physical ends. */
	good("25 01 75 08 95 01 | 35 00 45 ff 81 02 | 35 fe 45 ff 81 02 | 15 fe 25 ff 36 00 80 46 00 80 81 02");
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8 0 0..1 (0..255)\n"
	                                    "00@8 8 0 0..1 (-2..-1)\n"
	                                    "00@16 8 0 -2..-1 (-32768..-32768)\n");
}

/* An element wider than 32 bits takes its place in the report, but cannot be read as a number. */
static void test_wide_elements(void **state)
{
	(void)state;
	good("05 01 09 30 | 25 01 75 21 95 02 81 02 | 09 31 75 08 95 01 81 02");
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 33*2 10030 0..1\n"
	                                    "00@66 8 10031 0..1\n");
	uint8_t report[10] = {0};
	uint32_t value;
	assert_false(stilb_input_bits(report, sizeof report, 0, 33, &value));
	assert_true(stilb_input_bits(report, sizeof report, 66, 8, &value));
}

/* ---- items ------------------------------------------------------------------------------------------------------- */

#define AXIS "25 7f 75 08 95 01 " /* values 0..127, a byte, once */

static void test_usages_of_elements(void **state)
{
	(void)state;
	/* As many usages as elements. */
	good("05 01 25 7f 75 08 | 95 03 09 30 09 31 09 32 81 02");
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8 10030 0..127\n00@8 8 10031 0..127\n00@16 8 10032 0..127\n");
	good("05 01 25 7f 75 08 | 95 04 09 30 09 31 81 02"); /* fewer usages: the last one repeats */
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8 10030 0..127\n00@8 8*3 10031 0..127\n");
	good("05 01 25 7f 75 08 | 95 02 09 30 09 31 09 32 81 02"); /* more usages: the rest is unused */
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8 10030 0..127\n00@8 8 10031 0..127\n");
	good("25 7f 75 08 | 95 02 81 02"); /* no usages at all */
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8*2 0 0..127\n");
	good("05 09 25 01 75 01 | 95 08 19 01 29 08 81 02");
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 1*8 90001-90008 0..1\n");
	good("05 09 25 01 75 01 | 95 08 19 01 29 04 81 02"); /* elements 3 to 7 are button 4 */
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 1*8 90001-90004 0..1\n");
	good("05 09 25 01 75 01 | 95 08 19 01 29 10 81 02");
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 1*8 90001-90008 0..1\n");
	good("05 09 25 01 75 01 | 95 08 19 01 29 02 09 07 19 0a 29 10 81 02"); /* ranges and single ones in turn */
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 1*2 90001-90002 0..1\n00@2 1 90007 0..1\n00@3 1*5 9000a-9000e 0..1\n");
	good("05 09 25 01 75 01 | 95 02 19 07 81 02 | 95 04 29 08 81 02"); /* a minimum alone, a maximum alone */
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 1*2 0 0..1\n00@2 1*4 90000-90003 0..1\n");
	good("05 09 25 01 75 01 | 95 04 19 05 29 06 29 06 81 02"); /* a minimum holds for every maximum after it */
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 1*2 90005-90006 0..1\n00@2 1*2 90005-90006 0..1\n");
	good("05 09 25 01 75 01 | 95 04 19 05 29 04 81 02"); /* reversed: to the end of the page */
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 1*4 90005-90008 0..1\n");
	good("05 09 25 01 75 01 | 95 08 19 00 2a ff ff 81 02"); /* every usage of a page */
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 1*8 90000-90007 0..1\n");
}

static void test_pages_of_usages(void **state)
{
	(void)state;
	good(AXIS "09 30 05 01 81 02"); /* the page may come after the usage */
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8 10030 0..127\n");
	good(AXIS "05 02 09 30 09 31 95 02 05 01 81 02"); /* the last page before the main item is that of all usages */
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8 10030 0..127\n00@8 8 10031 0..127\n");
	good(AXIS "05 01 09 30 05 02 09 c5 95 02 81 02"); /* but not of those that already had this page before */
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8 10030 0..127\n00@8 8 200c5 0..127\n");
	good(AXIS "05 09 0b c4 00 02 00 09 01 95 02 05 01 81 02"); /* a usage with its page keeps it */
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8 200c4 0..127\n00@8 8 10001 0..127\n");
	good(AXIS "05 01 1b 01 00 09 00 2b 04 00 09 00 95 04 81 02");
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8*4 90001-90004 0..127\n");
	good(AXIS "05 01 1b 01 00 09 00 29 02 95 03 81 02 | 19 01 2b 02 00 09 00 81 02"); /* page in one end only */
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8*3 90001-90002 0..127\n00@24 8*3 90001-90002 0..127\n");
	good(AXIS "1b 01 00 09 00 2b 04 00 0a 00 95 04 81 02"); /* a range from one page into another stays in the first */
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8*4 90001-90004 0..127\n");
	good(AXIS "1b 07 00 09 00 2b 08 00 0a 00 95 01 81 00 | 16 00 80 27 ff ff 00 00 95 01 1b fe ff 09 00 2b ff ff 0a 00 "
	          "81 00");
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8 90007-90086 0..127 array\n00@8 8 9fffe-9ffff -32768..-32767 array\n");
	good(AXIS "07 00 ff 34 12 09 20 81 02 | 06 00 ff 0a 20 01 81 02"); /* a page has 16 bits */
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8 ff000020 0..127\n00@8 8 ff000120 0..127\n");
	good("09 05 05 01 a1 01 " AXIS "09 30 81 02 c0"); /* a collection's usage gets the page after it, too */
	assert_int_equal(parsed.fields[0].collection, 0x10005);
}

static void test_local_items_end_with_the_main_item(void **state)
{
	(void)state;
	good("05 01 " AXIS "09 30 81 02 81 02"); /* the second main item has no usage left */
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8 10030 0..127\n00@8 8 0 0..127\n");
	good("05 01 " AXIS "09 30 50 81 02 | 09 31 00 81 02 | 09 32 f0 81 02"); /* undefined main items clear usages, too */
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8 0 0..127\n00@8 8 0 0..127\n00@16 8 0 0..127\n");
}

static void test_ignored_items(void **state)
{
	(void)state;
	/* Designators and strings; local items and types that are not defined; long items, whose bytes look like items. */
	good("05 01 09 30 39 01 49 01 59 02 79 01 89 01 99 02 | b9 07 | 6c 7f aa aa bb bb | fe 00 10 | fe 05 20 75 20 95 "
	     "09 c0 |" AXIS "81 02");
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8 10030 0..127\n");
	good("05 01 09 30 " AXIS "81 02 00 00 00"); /* zeros after the end */
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8 10030 0..127\n");
}

static void test_delimiters(void **state)
{
	(void)state;
	good("05 01 " AXIS "95 02 | a9 01 09 30 09 31 09 32 a9 00 | a9 01 0b c4 00 02 00 09 33 a9 00 | 81 02");
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8 10030 0..127\n00@8 8 200c4 0..127\n");
	good("05 09 " AXIS
	     "95 03 | 09 07 | a9 01 19 01 29 02 19 03 29 04 09 05 a9 00 | 81 02"); /* the set's first usage is a range */
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8 90007 0..127\n00@8 8*2 90001-90002 0..127\n");
	refused("a9 01 09 30 a9 01", "report descriptor, byte 4: a delimited set within another");
	refused("09 30 a9 00", "report descriptor, byte 2: the end of a delimited set that did not begin");
	refused("05 01 a9 01 09 30", "report descriptor, byte 6: a delimited set does not end");
	refused("a9 01 09 30 81 02 a9 00", "report descriptor, byte 6: the end of a delimited set that did not begin");
}

static void test_push_and_pop(void **state)
{
	(void)state;
	good("85 01 05 01 15 ff 25 01 35 fe 45 02 55 0e 65 14 75 08 95 01 | a4 |"
	     "85 02 05 02 15 00 25 09 35 00 45 08 55 01 65 00 75 10 95 02 09 c4 81 02 | b4 | 09 30 81 02");
	fields_are(STILB_INPUT_FIELD_INPUT, "02@8 16*2 200c4 0..9 (0..8)\n01@8 8 10030 -1..1 (-2..2)\n");
	assert_int_equal(parsed.fields[0].exponent, 1);
	assert_int_equal(parsed.fields[1].exponent, -2);
	assert_int_equal(parsed.fields[0].unit, 0);
	assert_int_equal(parsed.fields[1].unit, 0x14);
	good("75 08 a4 75 09 a4 75 0a a4 75 0b a4 75 0c a4 75 0d a4 75 0e a4 75 0f a4 | b4 b4 b4 b4 b4 b4 b4 b4 | 95 01 81 "
	     "02");
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8 0 0..0\n");
	refused("a4 a4 a4 a4 a4 a4 a4 a4 a4", "report descriptor, byte 8: more than 8 pushes");
	refused("a4 b4 b4", "report descriptor, byte 2: pop without a push");
}

static void test_sizes_of_items(void **state)
{
	(void)state;
	good("05 01 09 30 | 16 ff ff 26 01 00 | 37 ff ff ff ff 47 01 00 00 00 | 76 08 00 97 01 00 00 00 | 82 02 00");
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8 10030 -1..1 (-1..1)\n");
	good("05 01 09 30 15 05 25 09 | 14 | 75 08 95 01 81 02"); /* no data: zero */
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8 10030 0..9\n");
	good("05 01 09 30 25 09 75 08 95 01 | 83 06 01 00 00 | 80"); /* flags of nine bits; of none: an array */
	assert_int_equal(parsed.fields[0].flags, 0x106);
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8 10030 0..9 relative\n00@8 8 0 0..9 array\n");
}

static void exponent_is(const char *item, int32_t exponent)
{
	char hex[64];
	snprintf(hex, sizeof hex, "25 01 75 08 95 01 %s 81 02", item);
	good(hex);
	assert_int_equal(parsed.fields[0].exponent, exponent);
}

static void test_exponents(void **state)
{
	(void)state;
	exponent_is("55 00", 0);
	exponent_is("55 07", 7);
	exponent_is("55 08", -8); /* a nibble with its sign, HID 1.11 section 6.2.2.7 */
	exponent_is("55 0e", -2);
	exponent_is("55 fd", -3); /* a byte with its sign, as the Saitek has it */
	exponent_is("56 fe ff", -2);
	exponent_is("55 10", 16);
	exponent_is("54", 0);
}

static void test_constants_and_nothing(void **state)
{
	(void)state;
	/* Constants take room; Report Size 0 and Report Count 0 make no field, but their report. */
	good("05 01 25 01 75 04 95 01 09 30 81 03 | 09 31 81 02 | 75 00 09 32 81 02 | 75 08 95 00 09 33 81 02 | 85 09 b1 "
	     "02");
	fields_are(STILB_INPUT_FIELD_INPUT, "00@12 4 10031 0..1\n");
	reports_are("i00:2 f09:1");
	/* 2^32 - 1 elements of no bits are none. */
	good("75 00 97 ff ff ff ff 81 02");
	assert_int_equal(parsed.field_count, 0);
	reports_are("i00:0");
	/* The range of padding need not make sense. */
	good("15 05 25 01 75 08 95 01 81 03");
	reports_are("i00:1");
	good("00");
	assert_int_equal(parsed.report_count, 0);
}

static void test_arrays(void **state)
{
	(void)state;
	good("05 07 15 00 25 65 75 08 95 06 19 00 29 65 81 00"); /* the array of keys of a keyboard */
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8*6 70000-70065 0..101 array\n");
	good("05 09 15 01 25 04 75 04 95 02 19 11 29 14 81 00"); /* the smallest value names the first usage */
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 4*2 90011-90014 1..4 array\n");
	good("05 09 15 01 25 06 75 08 95 01 | 09 07 19 01 29 03 05 0c 0a 23 02 81 00"); /* values name usages in turn */
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8 90007 1..1 array\n"
	                                    "00@0 8 90001-90003 2..4 array\n"
	                                    "00@0 8 c0223 5..5 array\n");
	good("05 09 15 01 25 02 75 08 95 01 | 09 07 19 01 29 03 09 09 81 00"); /* more usages than values */
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8 90007 1..1 array\n00@0 8 90001 2..2 array\n");
	good("05 09 15 ff 25 03 75 08 95 01 | 19 01 29 09 81 00");
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8 90001-90005 -1..3 array\n");
	good("15 01 25 03 75 08 95 01 81 00");
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 8 0 1..3 array\n");
	/* Every usage and every value there is. */
	good("05 09 17 00 00 00 80 27 ff ff ff 7f 75 20 95 01 1a 00 00 2a ff ff 81 00");
	fields_are(STILB_INPUT_FIELD_INPUT, "00@0 32 90000-9ffff -2147483648..-2147418113 array\n");
	/* The Saitek's effects: six usages out of order, one field of the same bits each. */
	const input_test_descriptor *saitek = input_test_descriptor_find(STILB_INPUT_BUS_USB, 0x06a3, 0xff0d);
	assert_int_equal(parse_bytes(saitek->bytes, saitek->size), STILB_OK);
	uint32_t found = 0;
	for (uint32_t i = 0; i < parsed.field_count; i++) {
		const stilb_input_field *field = &parsed.fields[i];
		if (field->report_id != 0x15 || field->kind != STILB_INPUT_FIELD_FEATURE)
			continue;
		assert_int_equal(field->bit, 8);
		found |= 1u << field->logical_min;
		assert_int_equal(field->logical_min, field->logical_max);
		if (field->logical_min == 3)
			assert_int_equal(field->usage, 0xf0032);
		if (field->logical_min == 4)
			assert_int_equal(field->usage, 0xf0031);
	}
	assert_int_equal(found, 0x7e);
}

static void test_collections(void **state)
{
	(void)state;
	const char *axis = "09 30 " AXIS "81 02";
	char hex[1024];
	snprintf(hex, sizeof hex,
	         "05 01 %s | 09 05 a1 01 | %s | 09 01 a1 00 %s | a1 02 %s c0 c0 | a1 00 %s a1 00 %s c0 c0 |"
	         "05 0c 09 01 a1 01 05 01 %s c0 | %s c0 | a1 01 %s c0 | %s",
	         axis, axis, axis, axis, axis, axis, axis, axis, axis, axis);
	good(hex);
	static const struct {
		uint32_t collection;
		uint16_t group;
	} expected[] = {{0, 0},       {0x10005, 0}, {0x10005, 1}, {0x10005, 1}, {0x10005, 2},
	                {0x10005, 3}, {0xc0001, 0}, {0x10005, 0}, {0, 0},       {0, 0}};
	assert_int_equal(parsed.field_count, COUNT(expected));
	for (uint32_t i = 0; i < COUNT(expected); i++) {
		assert_int_equal(parsed.fields[i].collection, expected[i].collection);
		assert_int_equal(parsed.fields[i].group, expected[i].group);
	}
	good("05 01 19 04 29 05 a1 01 " AXIS "81 02 c0"); /* of several usages a collection has the first */
	assert_int_equal(parsed.fields[0].collection, 0x10004);
	refused("05 01 c0", "report descriptor, byte 2: the end of a collection that did not begin");
	refused("a1 01 a1 02 c0", "report descriptor, byte 5: collections that do not end: 1");
}

static void test_reports(void **state)
{
	(void)state;
	good("25 01 75 01 95 09 81 02 91 02 b1 02"); /* without ids: each kind is padded to whole bytes */
	assert_false(parsed.numbered);
	reports_are("i00:2 o00:2 f00:2");
	good("25 01 75 01 95 03 | 85 01 81 02 | 85 ff 81 02 91 02 | 85 01 81 02 b1 02"); /* report 1 is continued later */
	assert_true(parsed.numbered);
	reports_are("i01:2 iff:2 off:2 f01:2");
	fields_are(STILB_INPUT_FIELD_INPUT, "01@8 1*3 0 0..1\nff@8 1*3 0 0..1\n01@11 1*3 0 0..1\n");
	good("25 01 75 08 95 01 81 02 | 85 05 b1 02"); /* if one report has an id, all have */
	assert_true(parsed.numbered);
	reports_are("i00:2 f05:2");
	fields_are(STILB_INPUT_FIELD_INPUT, "00@8 8 0 0..1\n");
}

/* ---- refusals ---------------------------------------------------------------------------------------------------- */

static void test_refusals(void **state)
{
	(void)state;
	refused("", "report descriptor, byte 0: it has 0 bytes; a report descriptor has 1 to 4096");
	refused("05", "report descriptor, byte 0: the item is cut off");
	refused("05 01 26 ff", "report descriptor, byte 2: the item is cut off");
	refused("05 01 27 ff ff ff", "report descriptor, byte 2: the item is cut off");
	refused("05 01 fe", "report descriptor, byte 2: the item is cut off");
	refused("05 01 fe 00", "report descriptor, byte 2: the item is cut off");
	refused("05 01 fe 03 00 01 02", "report descriptor, byte 2: the item is cut off");
	refused("85 00", "report descriptor, byte 0: report id 0; it must be 1 to 255");
	refused("84", "report descriptor, byte 0: report id 0; it must be 1 to 255");
	refused("86 00 01", "report descriptor, byte 0: report id 256; it must be 1 to 255");
	refused("05 01 c5 01", "report descriptor, byte 2: the global item 0xc is not defined");
	refused("f4", "report descriptor, byte 0: the global item 0xf is not defined");
	refused("15 01 25 00 75 08 95 01 81 02", "report descriptor, byte 8: the values from 1 to 0 are not a range");
	refused("15 ff 25 fe 75 08 95 01 81 02", "report descriptor, byte 8: the values from -1 to -2 are not a range");
	refused("85 07 75 08 96 00 10 81 02", "report descriptor, byte 7: report 7 is longer than 4096 bytes");
	refused("75 01 97 ff ff ff ff 81 02", "report descriptor, byte 7: report 0 is longer than 4096 bytes");
	refused("77 ff ff ff ff 97 ff ff ff ff 81 02", "report descriptor, byte 10: report 0 is longer than 4096 bytes");
	refused("75 08 96 fe 0f 81 03 95 01 81 03 81 03",
	        "report descriptor, byte 11: report 0 is longer than 4096 bytes"); /* 4095 and an id's byte fit */
}

/* A descriptor that repeats the same bytes `count` times, with changes by the caller. */
typedef struct made_bytes {
	uint8_t bytes[STILB_INPUT_DESCRIPTOR_MAX + 1];
	size_t size;
} made_bytes;

static made_bytes made;

static void made_add(const char *hex)
{
	made.size += from_hex(hex, made.bytes + made.size, sizeof made.bytes - made.size);
}

static void made_times(uint32_t count, const char *hex)
{
	for (uint32_t i = 0; i < count; i++)
		made_add(hex);
}

static void made_is(stilb_result expected, const char *message)
{
	assert_int_equal(parse_bytes(made.bytes, made.size), expected);
	if (expected != STILB_OK)
		assert_string_equal(stilb_error_message(), message);
	if (expected != STILB_OK)
		assert_int_equal(parsed.field_count + parsed.report_count, 0);
}

static void test_as_many_fields_as_fit(void **state)
{
	(void)state;
	for (uint32_t extra = 0; extra < 2; extra++) { /* as many main items as there may be fields, and one more */
		made.size = 0;
		made_add("25 01 75 01 95 01");
		made_times(STILB_INPUT_FIELDS_MAX + extra, "81 02");
		made_is(extra ? STILB_ERROR_ARGUMENT : STILB_OK, "report descriptor, byte 1030: more than 512 fields");
	}
	assert_int_equal(made.size, 6 + 2 * 513);
	for (uint32_t extra = 0; extra < 2; extra++) { /* the same by the usages of elements */
		made.size = 0;
		made_add("25 01 75 01 96 00 02");
		made_times(STILB_INPUT_FIELDS_MAX, "09 30");
		made_add(extra ? "81 02 81 02" : "81 02");
		made_is(extra ? STILB_ERROR_ARGUMENT : STILB_OK, "report descriptor, byte 1033: more than 512 fields");
	}
	for (uint32_t extra = 0; extra < 2; extra++) { /* the same by the usages of an array */
		made.size = 0;
		made_add("26 ff 7f 75 10 95 01");
		if (extra)
			made_add("81 02");
		made_times(STILB_INPUT_FIELDS_MAX, "09 30");
		made_add("81 00");
		made_is(extra ? STILB_ERROR_ARGUMENT : STILB_OK, "report descriptor, byte 1033: more than 512 fields");
	}
	made.size = 0;
	made_add("25 01 75 01 95 01 81 02"); /* one, and 512 more in one item of variables */
	made_add("96 00 02");
	made_times(STILB_INPUT_FIELDS_MAX, "09 30");
	made_add("81 02");
	made_is(STILB_ERROR_ARGUMENT, "report descriptor, byte 1035: more than 512 fields");
}

static void test_as_many_usages_as_fit(void **state)
{
	(void)state;
	made.size = 0;
	made_add("25 01 75 01 95 01");
	made_times(STILB_INPUT_FIELDS_MAX, "09 30");
	made_add("81 02");
	made_is(STILB_OK, NULL);
	assert_int_equal(parsed.field_count, 1);
	made.size -= 2;
	made_add("09 30 81 02");
	made_is(STILB_ERROR_ARGUMENT, "report descriptor, byte 1030: more than 512 usages for one item");
}

static void test_as_many_reports_as_fit(void **state)
{
	(void)state;
	made.size = 0;
	made_add("25 01 75 08 95 01");
	for (uint32_t id = 1; id < 256; id++) {
		uint8_t item[] = {0x85, (uint8_t)id, 0x81, 0x02};
		memcpy(made.bytes + made.size, item, sizeof item);
		made.size += sizeof item;
	}
	made_add("91 02");
	made_is(STILB_OK, NULL);
	assert_int_equal(parsed.report_count, STILB_INPUT_REPORTS_MAX);
	made_add("91 02"); /* adds to the output report 255: no new report */
	made_is(STILB_OK, NULL);
	made_add("b1 02");
	made_is(STILB_ERROR_ARGUMENT, "report descriptor, byte 1030: more than 256 reports");
}

static void test_collections_as_deep_as_fit(void **state)
{
	(void)state;
	made.size = 0;
	made_times(32, "a1 00");
	made_add("25 01 75 08 95 01 81 02");
	made_times(32, "c0");
	made_is(STILB_OK, NULL);
	assert_int_equal(parsed.fields[0].group, 32);
	made.size = 0;
	made_times(33, "a1 00");
	made_is(STILB_ERROR_ARGUMENT, "report descriptor, byte 64: more than 32 nested collections");
}

static void test_as_long_as_fits(void **state)
{
	(void)state;
	made.size = 0;
	made_add("25 01 75 08 96 ff 0f 85 01 81 02"); /* a report of 4095 bytes and its id */
	made_times(STILB_INPUT_DESCRIPTOR_MAX - (uint32_t)made.size, "00");
	made_is(STILB_OK, NULL);
	reports_are("i01:4096");
	made_add("00");
	made_is(STILB_ERROR_ARGUMENT, "report descriptor, byte 0: it has 4097 bytes; a report descriptor has 1 to 4096");
}

/* ---- usages in words --------------------------------------------------------------------------------------------- */

static void usage_is(uint32_t usage, const char *expected)
{
	char text[64];
	assert_string_equal(stilb_input_usage_text(usage, text, sizeof text), expected);
}

static void test_usage_text(void **state)
{
	(void)state;
	usage_is(0x10030, "Generic Desktop / X");
	usage_is(0x10039, "Generic Desktop / Hat switch");
	usage_is(0x10077, "Generic Desktop / 0x77");
	usage_is(0x200c4, "Simulation / Accelerator");
	usage_is(0x90003, "Button / 3");
	usage_is(0x9000a, "Button / 10");
	usage_is(0xc0224, "Consumer / AC Back");
	usage_is(0xff000020, "0xff00 / 0x20");
	usage_is(0x20, "0x0000 / 0x20");
	usage_is(0xffffffff, "0xffff / 0xffff");
	usage_is(0, "none");
	char text[8];
	assert_string_equal(stilb_input_usage_text(0x10030, text, sizeof text), "Generic"); /* cut, and ended */
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(test_tables),
		cmocka_unit_test(test_outputs_of_an_xbox_pad),
		cmocka_unit_test(test_prefixes_are_refused),
		cmocka_unit_test(test_bits),
		cmocka_unit_test(test_every_element_of_every_pad),
		cmocka_unit_test(test_signed_values),
		cmocka_unit_test(test_wide_elements),
		cmocka_unit_test(test_usages_of_elements),
		cmocka_unit_test(test_pages_of_usages),
		cmocka_unit_test(test_local_items_end_with_the_main_item),
		cmocka_unit_test(test_ignored_items),
		cmocka_unit_test(test_delimiters),
		cmocka_unit_test(test_push_and_pop),
		cmocka_unit_test(test_sizes_of_items),
		cmocka_unit_test(test_exponents),
		cmocka_unit_test(test_constants_and_nothing),
		cmocka_unit_test(test_arrays),
		cmocka_unit_test(test_collections),
		cmocka_unit_test(test_reports),
		cmocka_unit_test(test_refusals),
		cmocka_unit_test(test_as_many_fields_as_fit),
		cmocka_unit_test(test_as_many_usages_as_fit),
		cmocka_unit_test(test_as_many_reports_as_fit),
		cmocka_unit_test(test_collections_as_deep_as_fit),
		cmocka_unit_test(test_as_long_as_fits),
		cmocka_unit_test(test_usage_text),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
