/*
 * input_descriptor: a HID report descriptor (the bytes by which a device declares the layout of its reports) as a table
 * of fields: the meaning of each bit of each report.
 *
 * Reads every item (a tag with up to four bytes of data) of the HID specification 1.11, section 6.2.2: push and pop,
 * long items (none is defined; skipped), arrays, signed and 32-bit values, several reports, delimiters (the first usage
 * of a set is taken). Common mistakes of real pads are read as Linux reads them (drivers/hid/hid-core.c); a descriptor
 * that cannot be read is refused with the reason and the offset of the byte in it.
 *
 * Life cycle.  A plain value that parse fills; nothing is allocated. Time is linear in the descriptor's size.
 *
 *     static stilb_input_descriptor d;
 *     if (stilb_input_descriptor_parse(bytes, size, &d) == STILB_OK)
 *         for (uint32_t i = 0; i < d.field_count; i++)
 *             printf("bit %u: %s\n", d.fields[i].bit, stilb_input_usage_text(d.fields[i].usage, text, sizeof text));
 *
 * Threads.     [any-thread]
 */
#ifndef STILB_INPUT_DESCRIPTOR_H
#define STILB_INPUT_DESCRIPTOR_H

#include "input/input_pad.h"

typedef enum stilb_input_field_kind {
	STILB_INPUT_FIELD_INPUT,
	STILB_INPUT_FIELD_OUTPUT,
	STILB_INPUT_FIELD_FEATURE
} stilb_input_field_kind;

/* Bits of stilb_input_field.flags, from HID 1.11, section 6.2.2.5. A field that is not VARIABLE is an array: each of
 * its elements names a usage that is on. NULL: a value outside the logical range means that there is no value. */
#define STILB_INPUT_CONSTANT 0x001u
#define STILB_INPUT_VARIABLE 0x002u
#define STILB_INPUT_RELATIVE 0x004u
#define STILB_INPUT_NULL 0x040u

/* Elements of a report that are adjacent, equally large, and have one usage or consecutive usages. */
typedef struct stilb_input_field {
	/* stilb_input_field_kind. */
	uint8_t kind;
	/* 0: the reports have no ids. */
	uint8_t report_id;
	uint16_t flags;
	/* The usage is HID's number for the meaning of an element, as page << 16 | usage; 0: none was given. Element i of a
	 * variable has the usage `usage + i`; those beyond usage_last share usage_last. The value of an array's element
	 * names the usage `usage + value - logical_min`. An array whose usages are not consecutive becomes several fields
	 * of the same bits, each with its part of the values. */
	uint32_t usage, usage_last;
	/* First bit of the first element, from the start of the report as hidraw gives it, the id included. */
	uint32_t bit;
	/* Bits of an element: 1..32 for a number; more for other data. */
	uint32_t size;
	/* Elements. */
	uint32_t count;
	/* The range of the values as sent; negative values are in two's complement if logical_min is negative. Physical:
	 * the same range in the unit below. */
	int64_t logical_min, logical_max, physical_min, physical_max;
	/* unit: as coded by HID 1.11, section 6.2.2.7, a nibble for each base unit; exponent: the power of ten by which the
	 * unit is multiplied. */
	uint32_t unit;
	int32_t exponent;
	/* Usage of the innermost application collection, or 0. */
	uint32_t collection;
	/* Number of the innermost physical collection, from 1, which the axes of one stick share; 0: none. */
	uint16_t group;
} stilb_input_field;

/* Fields and reports that fit; more than these are an error. */
#define STILB_INPUT_FIELDS_MAX 512u
#define STILB_INPUT_REPORTS_MAX 256u

typedef struct stilb_input_report {
	/* stilb_input_field_kind, and the report's id; 0: the reports have no ids. */
	uint8_t kind, id;
	/* Bytes, the id included. */
	uint32_t size;
} stilb_input_report;

typedef struct stilb_input_descriptor {
	uint32_t field_count, report_count;
	/* The first byte of each report is its id. */
	bool numbered;
	/* In the order of the descriptor, without constant fields (padding) and without fields of 0 bits. */
	stilb_input_field fields[STILB_INPUT_FIELDS_MAX];
	/* One for each pair of kind and id that occurs. */
	stilb_input_report reports[STILB_INPUT_REPORTS_MAX];
} stilb_input_descriptor;

/* Parses size bytes. STILB_ERROR_ARGUMENT with "report descriptor, byte N: reason": an item cut off, a pop without
 * push, id 0 or above 255, a report longer than STILB_INPUT_REPORT_MAX bytes, more fields or reports than fit, a size
 * other than 1..STILB_INPUT_DESCRIPTOR_MAX, ...; *out then has no fields and no reports. Source: HID 1.11, section
 * 6.2.2. [any-thread] */
stilb_result stilb_input_descriptor_parse(const uint8_t *bytes, size_t size, stilb_input_descriptor *out);

/* The value of `bits` bits (1..32) of a report of size bytes, from bit number `bit` on, the least significant first.
 * Element i of a field is the field's size bits from field.bit + i * field.size on, to be sign-extended if its
 * logical_min is negative. False, and *value unchanged: not all of these bits are in the report, or bits is not 1..32.
 * [any-thread] */
bool stilb_input_bits(const uint8_t *report, size_t size, uint32_t bit, uint32_t bits, uint32_t *value);

/* Writes a usage (page << 16 | usage) as words: "Generic Desktop / X", "Button / 3", "0xff00 / 0x20" where there is no
 * name, "none" for 0. text has size > 0 bytes and ends with a zero; returns text. Source of the names: HID Usage Tables
 * 1.12. [any-thread] */
const char *stilb_input_usage_text(uint32_t usage, char *text, size_t size);

#endif
