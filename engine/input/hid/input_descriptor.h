/*
 * input_descriptor: a HID report descriptor as a table of fields: what each bit of each report means. Reads every item
 * of the HID specification 1.11 (section 6.2.2): push and pop, long items (none is defined: skipped), arrays, signed and
 * 32-bit values, several reports, delimiters (the first usage of a set counts). What pads do wrong is read as Linux
 * reads it (drivers/hid/hid-core.c); what cannot be read is refused with the byte's offset and the reason.
 *
 * Time is linear in the descriptor's size; nothing is allocated. [any-thread]
 */
#ifndef STILB_INPUT_DESCRIPTOR_H
#define STILB_INPUT_DESCRIPTOR_H

#include "input/input_pad.h"

typedef enum stilb_input_field_kind {
	STILB_INPUT_FIELD_INPUT,
	STILB_INPUT_FIELD_OUTPUT,
	STILB_INPUT_FIELD_FEATURE
} stilb_input_field_kind;

/* Bits of a main item, HID 1.11 section 6.2.2.5. */
#define STILB_INPUT_CONSTANT 0x001u
#define STILB_INPUT_VARIABLE 0x002u /* else an array: each element names which of the usages is on */
#define STILB_INPUT_RELATIVE 0x004u
#define STILB_INPUT_NULL 0x040u /* a value outside the logical range means "nothing" */

/* Elements of a report that lie side by side and have one usage, or, with usage_last > usage, one usage more each:
 * element i of a variable has usage + i, until usage_last, which all that follow share. Each element of an array names
 * the usage that is on: usage + value - logical_min; an array whose usages are not one range is several fields of the
 * same bits, each with its own values. */
typedef struct stilb_input_field {
	uint8_t kind;      /* stilb_input_field_kind */
	uint8_t report_id; /* 0: the reports have no numbers */
	uint16_t flags;
	uint32_t usage, usage_last; /* page << 16 | usage; 0: none was given */
	uint32_t bit;               /* of the first element, from the start of the report as hidraw gives it, id included */
	uint32_t size;              /* of an element, bits; 1..32, or more for what has no number value */
	uint32_t count;             /* elements */
	int64_t logical_min, logical_max, physical_min, physical_max;
	uint32_t unit;
	int32_t exponent;    /* of ten */
	uint32_t collection; /* usage of the innermost collection of kind application, or 0 */
	uint16_t group;      /* which physical collection, from 1; fields of one stick share it; 0: none */
} stilb_input_field;

#define STILB_INPUT_FIELDS_MAX 512u
#define STILB_INPUT_REPORTS_MAX 256u

typedef struct stilb_input_report {
	uint8_t kind, id;
	uint32_t size; /* bytes, the id included */
} stilb_input_report;

typedef struct stilb_input_descriptor {
	uint32_t field_count, report_count;
	bool numbered; /* each report's first byte is its id */
	/* In the order of the descriptor; constants and what has no bits are left out. */
	stilb_input_field fields[STILB_INPUT_FIELDS_MAX];
	stilb_input_report reports[STILB_INPUT_REPORTS_MAX];
} stilb_input_descriptor;

/* STILB_ERROR_ARGUMENT with the byte's offset and what is wrong: cut off inside an item, pop without push, a report
 * larger than STILB_INPUT_REPORT_MAX bytes, more fields or reports than fit, id 0, ... *out then has no fields. */
stilb_result stilb_input_descriptor_parse(const uint8_t *bytes, size_t size, stilb_input_descriptor *out);

/* The value of 1..32 bits of a report from `bit` on, the least significant first: element i of a field is the field's
 * size bits from field.bit + i * field.size on, to be sign-extended where its logical_min is negative. False: there
 * are no such bits in size bytes, or it is a number of bits other than 1..32; *value is then unchanged. */
bool stilb_input_bits(const uint8_t *report, size_t size, uint32_t bit, uint32_t bits, uint32_t *value);

/* "Generic Desktop / X", "Button / 3", "0xff00 / 0x20"; into text, always terminated. Returns text. */
const char *stilb_input_usage_text(uint32_t usage, char *text, size_t size);

#endif
