/* input_descriptor against the kernel: every pad's report descriptor, and random variations of them, are given to Linux
 * through /dev/uhid; the fields that Linux reads (debugfs, hid/.../rdesc) must be those of our parser.
 *
 *   soak_vm_descriptor COUNT        number of random variations */
#include "input/hid/input_descriptor.h"
#include "support/test.h"
#include "vm/uhid_pad.h"
#include "vm/vm_fixture.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define USAGES_MAX 12288u     /* of one field: HID_MAX_USAGES */
#define CHANGED_ELEMENTS 500u /* larger fields take the kernel long to print and test nothing new */

static uint32_t by_chance; /* number of random descriptors */
static int64_t started_us;
static const input_test_descriptor *given; /* the descriptor that the kernel has now */
static stilb_input_descriptor parsed;

/* ---- the kernel's fields ----------------------------------------------------------------------------------------- */

/* A field as drivers/hid/hid-debug.c prints it. */
typedef struct kernel_field {
	uint8_t kind, id;
	bool constant, variable, relative, null,
		ranged; /* ranged: the logical range is printed, which it is not if its ends are equal */
	int32_t logical_min, logical_max;
	uint32_t size, count, offset; /* size and offset in bits; the offset from the end of the report's id */
	uint32_t usage_count;
	uint32_t usages[USAGES_MAX]; /* NO_NUMBER: the kernel prints a name that is not in the list here */
} kernel_field;

#define NO_NUMBER 0xffffffffu

static uint32_t usage_number(const char *text)
{
	static const struct {
		const char *name;
		uint32_t usage;
	} names[] = {
		{"GenericDesktop.X", 0x10030},  {"GenericDesktop.Y", 0x10031},  {"GenericDesktop.Z", 0x10032},
		{"GenericDesktop.Rx", 0x10033}, {"GenericDesktop.Ry", 0x10034}, {"GenericDesktop.Rz", 0x10035},
	};
	uint32_t page, id;
	int end = 0;
	for (size_t i = 0; i < sizeof names / sizeof *names; i++)
		if (strcmp(text, names[i].name) == 0)
			return names[i].usage;
	if (sscanf(text, "Button.%4x%n", &id, &end) == 1 && text[end] == '\0')
		return 0x90000 | id;
	if (sscanf(text, "%4x.%4x%n", &page, &id, &end) == 2 && end == 9 && text[end] == '\0')
		return page << 16 | id;
	return NO_NUMBER;
}

/* Opens the kernel's text about the fields of the one pad that is plugged in. */
static FILE *kernel_open(const input_test_descriptor *pad)
{
	char start[32], path[512];
	FILE *file = NULL;
	snprintf(start, sizeof start, "%04X:%04X:%04X.", pad->bus, pad->vendor, pad->product);
	DIR *folder = opendir("/sys/kernel/debug/hid");
	assert_non_null(folder);
	for (struct dirent *entry; (entry = readdir(folder));) {
		if (strncmp(entry->d_name, start, strlen(start)) != 0)
			continue;
		snprintf(path, sizeof path, "/sys/kernel/debug/hid/%s/rdesc", entry->d_name);
		file = fopen(path, "r");
	}
	closedir(folder);
	assert_non_null(file);
	return file;
}

/* ---- our fields -------------------------------------------------------------------------------------------------- */

/* Our field with the element that begins at this bit, counted as the kernel does. Of the fields that an array has
 * become it is the one with this value; with value NULL the first. */
static const stilb_input_field *field_at(const kernel_field *theirs, uint32_t bit, const int64_t *value)
{
	uint32_t id_bits = parsed.numbered ? 8 : 0;
	for (uint32_t i = 0; i < parsed.field_count; i++) {
		const stilb_input_field *field = &parsed.fields[i];
		uint32_t begin = field->bit - id_bits;
		if (field->kind == theirs->kind && field->report_id == theirs->id && bit >= begin &&
		    bit < begin + field->size * field->count &&
		    (!value || (*value >= field->logical_min && *value <= field->logical_max)))
			return field;
	}
	return NULL;
}

static void same(bool condition, const char *what, const kernel_field *theirs)
{
	if (!condition)
		fail_msg("%s: kind %u, report %u, bit %u, %u bits times %u, %d..%d", what, theirs->kind, theirs->id,
		         theirs->offset, theirs->size, theirs->count, theirs->logical_min, theirs->logical_max);
}

static void same_element(const kernel_field *theirs, const stilb_input_field *ours, uint32_t usage, uint32_t our_usage)
{
	same(ours, "no such element", theirs);
	same(ours->size == theirs->size, "another size", theirs);
	same(usage == NO_NUMBER || usage == our_usage, "another usage", theirs);
	same(!(ours->flags & STILB_INPUT_VARIABLE) != theirs->variable, "variable", theirs);
	same(!(ours->flags & STILB_INPUT_RELATIVE) != theirs->relative, "relative", theirs);
	same(!(ours->flags & STILB_INPUT_NULL) != theirs->null, "null", theirs);
}

/* Compares a field of variables with ours. Returns the number of its elements that have a usage in our field; usage 0
 * of page 0 is none. */
static uint32_t compare_variable(const kernel_field *theirs)
{
	uint32_t id_bits = parsed.numbered ? 8 : 0;
	uint32_t elements = 0;
	for (uint32_t i = 0; i < theirs->count; i++) {
		uint32_t bit = theirs->offset + i * theirs->size;
		const stilb_input_field *ours = field_at(theirs, bit, NULL);
		same(ours, "no such element", theirs);
		uint32_t element = (bit + id_bits - ours->bit) / ours->size;
		uint32_t usage = ours->usage + element;
		same_element(theirs, ours, theirs->usages[i], usage < ours->usage_last ? usage : ours->usage_last);
		same((bit + id_bits - ours->bit) % ours->size == 0, "another bit", theirs);
		if (theirs->ranged)
			same((int32_t)ours->logical_min == theirs->logical_min && (int32_t)ours->logical_max == theirs->logical_max,
			     "another range", theirs);
		elements += ours->usage != 0;
	}
	return elements;
}

/* The same for an array, whose values name the usages in turn. Usages for which it has no value are not compared: the
 * kernel fills its list with repetitions of the last usage. */
static uint32_t compare_array(const kernel_field *theirs)
{
	uint32_t values = 0;
	for (uint32_t i = 0; theirs->ranged && i < theirs->usage_count; i++) {
		int64_t value = (int64_t)theirs->logical_min + i;
		const stilb_input_field *ours = field_at(theirs, theirs->offset, &value);
		if (!ours)
			break;
		same_element(theirs, ours, theirs->usages[i], ours->usage + (uint32_t)(value - ours->logical_min));
		same(ours->count == theirs->count, "another count", theirs);
		values++;
	}
	const stilb_input_field *first = field_at(theirs, theirs->offset, NULL);
	same(first && (values > 0 || !theirs->ranged), "no such array", theirs);
	return first->usage ? theirs->count : 0;
}

/* Number of elements with a usage in our fields; an array's elements count once, though it may have become several
 * fields. */
static uint32_t our_elements(void)
{
	uint32_t count = 0;
	for (uint32_t i = 0; i < parsed.field_count; i++) {
		const stilb_input_field *field = &parsed.fields[i], *before = field - 1;
		bool again = i > 0 && !(field->flags & STILB_INPUT_VARIABLE) && before->bit == field->bit &&
		             before->kind == field->kind && before->report_id == field->report_id;
		if (field->usage && !again)
			count += field->count;
	}
	return count;
}

static uint32_t compare(const kernel_field *field)
{
	if (field->constant || field->size == 0 || field->count == 0)
		return 0;
	return field->variable ? compare_variable(field) : compare_array(field);
}

/* Reads line by line and compares at the end of each field. Returns the number of elements, as compare does. */
static uint32_t compare_all(FILE *file)
{
	static kernel_field field;
	static char line[4 * STILB_INPUT_DESCRIPTOR_MAX]; /* the first line has all bytes of the descriptor */
	uint32_t elements = 0, id;
	while (fgets(line, sizeof line, file)) {
		char *text = line + strspn(line, " "), *end = text + strlen(text);
		while (end > text && (end[-1] == '\n' || end[-1] == ' '))
			*--end = '\0';
		size_t indent = (size_t)(text - line);
		if (indent == 2) {
			field.kind = *text == 'I'   ? STILB_INPUT_FIELD_INPUT
			             : *text == 'O' ? STILB_INPUT_FIELD_OUTPUT
			                            : STILB_INPUT_FIELD_FEATURE;
			const char *bracket = strchr(text, '(');
			field.id = bracket && sscanf(bracket, "(%u)", &id) == 1 ? (uint8_t)id : 0;
		} else if (indent == 4) { /* Field(...) */
			field.usage_count = 0;
			field.ranged = false;
		} else if (indent == 8 && field.usage_count < USAGES_MAX) {
			field.usages[field.usage_count++] = usage_number(text);
		} else if (sscanf(text, "Logical Minimum(%d)", &field.logical_min) == 1) {
			field.ranged = true;
		} else if (sscanf(text, "Logical Maximum(%d)", &field.logical_max) == 1 ||
		           sscanf(text, "Report Size(%u)", &field.size) == 1 ||
		           sscanf(text, "Report Count(%u)", &field.count) == 1 ||
		           sscanf(text, "Report Offset(%u)", &field.offset) == 1) {
			continue;
		} else if (strncmp(text, "Flags(", 6) == 0) {
			field.constant = strstr(text, "Constant");
			field.variable = strstr(text, "Variable");
			field.relative = strstr(text, "Relative");
			field.null = strstr(text, "NullState");
			elements += compare(&field);
		}
	}
	return elements;
}

static uint32_t give_to_kernel(const input_test_descriptor *pad)
{
	given = pad;
	uhid_pad *plugged = uhid_pad_create(pad, "descriptor");
	FILE *file = kernel_open(pad);
	uint32_t elements = compare_all(file);
	fclose(file);
	uhid_pad_destroy(plugged);
	assert_int_equal(elements, our_elements());
	given = NULL;
	return elements;
}

/* ---- random descriptors ------------------------------------------------------------------------------------------ */

typedef struct item {
	size_t at, size;
	uint32_t value;
} item;

static item item_at(const uint8_t *bytes, size_t at)
{
	item found = {.at = at, .size = 1u + ((bytes[at] & 3) == 3 ? 4 : bytes[at] & 3)};
	for (size_t i = 1; i < found.size; i++)
		found.value |= (uint32_t)bytes[at + i] << 8 * (i - 1);
	return found;
}

/* False: a descriptor that Linux refuses or reads differently by design: long items, sizes over 256, counts over 12288,
 * delimiters, ranges with a page or with very many usages, values of padding or of fields without bits. */
static bool kernel_reads(const uint8_t *bytes, size_t size)
{
	uint8_t all_data[STILB_INPUT_DESCRIPTOR_MAX];
	uint32_t usage_min = 0;
	memcpy(all_data, bytes, size);
	for (size_t at = 0; at < size;) {
		item found = item_at(bytes, at);
		uint8_t tag = bytes[at] & 0xfc;
		if (tag >= 0xf0 || (tag == 0x74 && found.value > 256) || (tag == 0x94 && found.value > 12288) || tag == 0xa8 ||
		    ((tag == 0x18 || tag == 0x28) && found.size > 3))
			return false;
		if (tag == 0x28 && (found.value < usage_min || found.value - usage_min > 255))
			return false;
		if (tag == 0x18)
			usage_min = found.value;
		if ((tag & 0x0c) == 0) /* a main item */
			usage_min = 0;
		if ((tag == 0x80 || tag == 0x90 || tag == 0xb0) && found.size > 1)
			all_data[at + 1] &= 0xfe;
		if ((tag == 0x74 || tag == 0x94) && found.value == 0) {
			if (found.size == 1)
				return false;
			all_data[at + 1] = 1;
		}
		at += found.size;
	}
	return stilb_input_descriptor_parse(all_data, size, &parsed) == STILB_OK &&
	       stilb_input_descriptor_parse(bytes, size, &parsed) == STILB_OK && parsed.field_count > 0;
}

static uint32_t pick(uint64_t *state, uint32_t below)
{
	return (uint32_t)(stilb_random_u64(8, ++*state) % below);
}

/* Varies a pad's descriptor: some items get other data or another tag, some are left out, some doubled. Returns the
 * size. */
static size_t change(const input_test_descriptor *pad, uint64_t *state, uint8_t *bytes)
{
	static const uint8_t ends[] = {0, 1, 2, 3, 7, 8, 9, 15, 16, 31, 32, 33, 127, 128, 254, 255};
	uint32_t one_in = 8 + pick(state, 60);
	size_t size = 0;
	for (size_t at = 0; at < pad->size;) {
		item found = item_at(pad->bytes, at);
		uint32_t what = pick(state, one_in);
		uint32_t times = what == 0 ? 0 : what == 1 ? 2 : 1;
		for (uint32_t i = 0; i < times && size + found.size <= STILB_INPUT_DESCRIPTOR_MAX; i++) {
			memcpy(bytes + size, pad->bytes + at, found.size);
			if (what == 2)
				bytes[size] = (uint8_t)(bytes[size] ^ 1u << (4 + pick(state, 4)));
			if (what >= 3 && what <= 4 && found.size > 1)
				bytes[size + 1] = ends[pick(state, sizeof ends)];
			size += found.size;
		}
		at += found.size;
	}
	return size;
}

/* ---- tests ------------------------------------------------------------------------------------------------------- */

/* Lets the kernel's driver hid-generic read all pads, because the drivers of known pads replace the pads' descriptors
 * by their own. */
static int generic_alone(void **state)
{
	(void)state;
	vm_module_set("hid", "ignore_special_drivers", "1");
	started_us = vm_now_us();
	return 0;
}

static int all_drivers(void **state)
{
	(void)state;
	vm_module_set("hid", "ignore_special_drivers", "0");
	print_message("vm: descriptors took %.1f s\n", 1e-6 * (double)(vm_now_us() - started_us));
	return 0;
}

static void test_pads(void **state)
{
	(void)state;
	uint32_t elements = 0;
	for (size_t i = 0; i < input_test_descriptor_count; i++) {
		const input_test_descriptor *pad = &input_test_descriptors[i];
		assert_int_equal(stilb_input_descriptor_parse(pad->bytes, pad->size, &parsed), STILB_OK);
		elements += give_to_kernel(pad);
	}
	print_message("vm: %zu descriptors of pads: %u elements as the kernel has them\n", input_test_descriptor_count,
	              elements);
}

static void test_changed(void **state)
{
	(void)state;
	uint64_t random = 0;
	uint32_t elements = 0, tries = 0;
	for (uint32_t i = 0; i < by_chance; tries++) {
		static uint8_t bytes[STILB_INPUT_DESCRIPTOR_MAX];
		static input_test_descriptor pad; /* static, because a failure leaves the function */
		pad = input_test_descriptors[pick(&random, (uint32_t)input_test_descriptor_count)];
		pad.size = change(&pad, &random, bytes);
		pad.bytes = bytes;
		if (!kernel_reads(pad.bytes, pad.size) || our_elements() > CHANGED_ELEMENTS)
			continue;
		elements += give_to_kernel(&pad);
		i++;
	}
	print_message("vm: %u changed ones (of %u): %u elements as the kernel has them\n", by_chance, tries, elements);
}

/* Prints the descriptor at which a test failed. */
static int print_given(void **state)
{
	(void)state;
	for (size_t i = 0; given && i < given->size; i++)
		printf("%02x%s", given->bytes[i], i + 1 < given->size ? " " : "\n");
	given = NULL;
	return 0;
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_teardown(test_pads, print_given),
		cmocka_unit_test_teardown(test_changed, print_given),
	};
	by_chance = argc > 1 ? (uint32_t)strtoul(argv[1], NULL, 10) : 0;
	return cmocka_run_group_tests(tests, generic_alone, all_drivers);
}
