#include "input/hid/input_descriptor.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* Types and tags of items, HID 1.11 sections 6.2.2.4 to 6.2.2.8. */
enum { TYPE_MAIN, TYPE_GLOBAL, TYPE_LOCAL, TYPE_RESERVED };
enum { MAIN_INPUT = 8, MAIN_OUTPUT, MAIN_COLLECTION, MAIN_FEATURE, MAIN_END_COLLECTION };
enum {
	GLOBAL_USAGE_PAGE,
	GLOBAL_LOGICAL_MIN,
	GLOBAL_LOGICAL_MAX,
	GLOBAL_PHYSICAL_MIN,
	GLOBAL_PHYSICAL_MAX,
	GLOBAL_EXPONENT,
	GLOBAL_UNIT,
	GLOBAL_REPORT_SIZE,
	GLOBAL_REPORT_ID,
	GLOBAL_REPORT_COUNT,
	GLOBAL_PUSH,
	GLOBAL_POP
};
enum { LOCAL_USAGE, LOCAL_USAGE_MIN, LOCAL_USAGE_MAX, LOCAL_DELIMITER = 10 };
enum { COLLECTION_PHYSICAL, COLLECTION_APPLICATION };

#define LONG_ITEM 0xfeu
#define STACK_MAX 8u        /* states of the global items kept by nested push items; Linux allows 4 */
#define COLLECTIONS_MAX 32u /* collections nested in one another */
#define RANGES_MAX STILB_INPUT_FIELDS_MAX
#define REPORT_BITS_MAX ((STILB_INPUT_REPORT_MAX - 1) * 8) /* without the id */

typedef struct descriptor_item {
	uint8_t type, tag;
	uint8_t size; /* of the data, bytes: 0, 1, 2 or 4 */
	uint32_t data;
} descriptor_item;

/* Set by global items; each value holds until it is set again. */
typedef struct descriptor_globals {
	uint16_t usage_page;
	uint8_t report_id;
	uint32_t report_size, report_count, unit;
	int32_t exponent;
	int64_t logical_min, logical_max, physical_min, physical_max;
} descriptor_globals;

/* The usages of one Usage item, or of a Usage Minimum and a Usage Maximum. */
typedef struct descriptor_range {
	uint16_t page, first, last;
	bool extended; /* `page` was in the item; else it is the page set by the last Usage Page item */
} descriptor_range;

/* Set by local items; it holds until the next main item. */
typedef struct descriptor_locals {
	uint32_t range_count;
	uint32_t min;   /* the last Usage Minimum */
	bool delimited; /* inside a delimited set of alternative usages */
	bool chosen;    /* the set's first usage was taken; the others are skipped */
} descriptor_locals;

typedef struct descriptor_collection {
	uint32_t application; /* stilb_input_field.collection of the fields in it */
	uint16_t group;       /* stilb_input_field.group of the fields in it */
} descriptor_collection;

typedef struct descriptor_parser {
	stilb_input_descriptor *out;
	size_t offset; /* bytes from the descriptor's start to the item being read, for messages too */
	descriptor_globals global, stack[STACK_MAX];
	uint32_t stack_depth;
	descriptor_locals local;
	descriptor_range ranges[RANGES_MAX];                    /* [local.range_count] */
	descriptor_collection collections[COLLECTIONS_MAX + 1]; /* [depth] is the innermost, [0] is outside of all */
	uint32_t depth;
	uint16_t groups;                               /* physical collections so far */
	uint16_t report_number[3][256];                /* by kind and id: 1 + index in out->reports; 0: there is none yet */
	uint32_t report_bits[STILB_INPUT_REPORTS_MAX]; /* bits of each of out->reports so far, without the id */
} descriptor_parser;

static stilb_result descriptor_refuse(const descriptor_parser *parser, const char *format, ...)
	__attribute__((format(printf, 2, 3)));

static stilb_result descriptor_refuse(const descriptor_parser *parser, const char *format, ...)
{
	char what[128];
	va_list arguments;
	va_start(arguments, format);
	vsnprintf(what, sizeof what, format, arguments);
	va_end(arguments);
	return stilb_fail(STILB_ERROR_ARGUMENT, "report descriptor, byte %zu: %s", parser->offset, what);
}

/* ---- items ------------------------------------------------------------------------------------------------------- */

/* The item's data as a signed number in two's complement, as long as the data. */
static int64_t item_signed(const descriptor_item *item)
{
	STILB_ASSERT(item->size <= 4 && item->size != 3);
	switch (item->size) {
	case 1:
		return (int8_t)item->data;
	case 2:
		return (int16_t)item->data;
	default:
		return (int32_t)item->data;
	}
}

/* Reads the item at parser->offset. Returns its size in bytes; 0: the descriptor ends inside it. */
static size_t item_read(const descriptor_parser *parser, const uint8_t *bytes, size_t size, descriptor_item *item)
{
	STILB_ASSERT(parser->offset < size);
	const uint8_t *at = bytes + parser->offset;
	size_t left = size - parser->offset;
	if (at[0] == LONG_ITEM) { /* HID 1.11 defines none: skipped */
		*item = (descriptor_item){.type = TYPE_RESERVED};
		return left < 3 || left - 3 < at[1] ? 0 : 3u + at[1];
	}
	uint8_t length = (at[0] & 3) == 3 ? 4 : at[0] & 3;
	if (left - 1 < length)
		return 0;
	*item = (descriptor_item){.type = at[0] >> 2 & 3, .tag = at[0] >> 4, .size = length};
	for (uint32_t i = 0; i < length; i++)
		item->data |= (uint32_t)at[1 + i] << 8 * i;
	return 1u + length;
}

/* ---- local items ------------------------------------------------------------------------------------------------- */

/* Adds the usages first..last. Usages of up to 16 bits get the present usage page, and a later one in complete_pages. A
 * range that ends before it begins goes on to the end of its page, as in Linux. */
static stilb_result range_add(descriptor_parser *parser, uint32_t first, uint32_t last)
{
	uint16_t page = (uint16_t)(first >> 16 ? first >> 16 : last >> 16);
	bool ends = (last & 0xffff) >= (first & 0xffff) && (last >> 16 == page || last >> 16 == 0);
	if (parser->local.delimited && parser->local.chosen)
		return STILB_OK;
	parser->local.chosen = true;
	if (parser->local.range_count == RANGES_MAX)
		return descriptor_refuse(parser, "more than %u usages for one item", RANGES_MAX);
	parser->ranges[parser->local.range_count++] = (descriptor_range){.page = page ? page : parser->global.usage_page,
	                                                                 .first = (uint16_t)first,
	                                                                 .last = ends ? (uint16_t)last : 0xffff,
	                                                                 .extended = page != 0};
	return STILB_OK;
}

/* A delimited set is one control's usages, the preferred one first (HID 1.11 section 6.2.2.8). */
static stilb_result delimiter(descriptor_parser *parser, bool opens)
{
	if (opens == parser->local.delimited)
		return descriptor_refuse(parser, opens ? "a delimited set within another"
		                                       : "the end of a delimited set that did not begin");
	parser->local.delimited = opens;
	parser->local.chosen = false;
	return STILB_OK;
}

static stilb_result local_item(descriptor_parser *parser, const descriptor_item *item)
{
	switch (item->tag) {
	case LOCAL_USAGE:
		return range_add(parser, item->data, item->data);
	case LOCAL_USAGE_MIN:
		parser->local.min = item->data;
		return STILB_OK;
	case LOCAL_USAGE_MAX:
		return range_add(parser, parser->local.min, item->data);
	case LOCAL_DELIMITER:
		return delimiter(parser, item->data != 0);
	default: /* designators, strings and what is reserved */
		return STILB_OK;
	}
}

/* Gives the usages without a page of their own the last page before the main item. Going back from the last usage this
 * stops at the first that has this page already: the usages before it were meant for the pages given before them. As in
 * Linux, hid_concatenate_last_usage_page. */
static void complete_pages(descriptor_parser *parser)
{
	for (uint32_t i = parser->local.range_count; i-- > 0;) {
		descriptor_range *range = &parser->ranges[i];
		if (range->extended)
			continue;
		if (range->page == parser->global.usage_page)
			break;
		range->page = parser->global.usage_page;
	}
}

/* ---- global items ------------------------------------------------------------------------------------------------ */

static stilb_result global_item(descriptor_parser *parser, const descriptor_item *item)
{
	descriptor_globals *global = &parser->global;
	switch (item->tag) {
	case GLOBAL_USAGE_PAGE:
		global->usage_page = (uint16_t)item->data;
		return STILB_OK;
	case GLOBAL_LOGICAL_MIN:
		global->logical_min = item_signed(item);
		return STILB_OK;
	case GLOBAL_LOGICAL_MAX: /* unsigned unless the minimum is negative, as in Linux: 25 ff is 255 after 15 00 */
		global->logical_max = global->logical_min < 0 ? item_signed(item) : (int64_t)item->data;
		return STILB_OK;
	case GLOBAL_PHYSICAL_MIN:
		global->physical_min = item_signed(item);
		return STILB_OK;
	case GLOBAL_PHYSICAL_MAX:
		global->physical_max = global->physical_min < 0 ? item_signed(item) : (int64_t)item->data;
		return STILB_OK;
	case GLOBAL_EXPONENT: /* by the specification a nibble, -8 to 7; some pads write a signed byte or more */
		global->exponent = (int32_t)item_signed(item);
		if (item->data < 16)
			global->exponent = (int32_t)item->data - (item->data < 8 ? 0 : 16);
		return STILB_OK;
	case GLOBAL_UNIT:
		global->unit = item->data;
		return STILB_OK;
	case GLOBAL_REPORT_SIZE:
		global->report_size = item->data;
		return STILB_OK;
	case GLOBAL_REPORT_COUNT:
		global->report_count = item->data;
		return STILB_OK;
	case GLOBAL_REPORT_ID:
		if (item->data < 1 || item->data > 255)
			return descriptor_refuse(parser, "report id %u; it must be 1 to 255", item->data);
		global->report_id = (uint8_t)item->data;
		parser->out->numbered = true;
		return STILB_OK;
	case GLOBAL_PUSH:
		if (parser->stack_depth == STACK_MAX)
			return descriptor_refuse(parser, "more than %u pushes", STACK_MAX);
		parser->stack[parser->stack_depth++] = *global;
		return STILB_OK;
	case GLOBAL_POP:
		if (parser->stack_depth == 0)
			return descriptor_refuse(parser, "pop without a push");
		*global = parser->stack[--parser->stack_depth];
		return STILB_OK;
	default:
		return descriptor_refuse(parser, "the global item 0x%x is not defined", item->tag);
	}
}

/* ---- main items -------------------------------------------------------------------------------------------------- */

static stilb_result collection_begin(descriptor_parser *parser, uint32_t kind)
{
	const descriptor_range *range = &parser->ranges[0];
	descriptor_collection inner = parser->collections[parser->depth];
	if (parser->depth == COLLECTIONS_MAX)
		return descriptor_refuse(parser, "more than %u nested collections", COLLECTIONS_MAX);
	if (kind == COLLECTION_APPLICATION)
		inner.application = parser->local.range_count ? (uint32_t)range->page << 16 | range->first : 0;
	if (kind == COLLECTION_PHYSICAL) {
		parser->groups++;
		inner.group = parser->groups;
	}
	parser->depth++;
	parser->collections[parser->depth] = inner;
	return STILB_OK;
}

static stilb_result collection_end(descriptor_parser *parser)
{
	if (parser->depth == 0)
		return descriptor_refuse(parser, "the end of a collection that did not begin");
	parser->depth--;
	return STILB_OK;
}

/* The size in bits, so far, of the report that a main item adds to; NULL: there are too many reports. */
static uint32_t *report_bits(descriptor_parser *parser, stilb_input_field_kind kind)
{
	STILB_ASSERT(kind <= STILB_INPUT_FIELD_FEATURE);
	stilb_input_descriptor *out = parser->out;
	uint16_t *number = &parser->report_number[kind][parser->global.report_id];
	if (*number == 0) {
		if (out->report_count == STILB_INPUT_REPORTS_MAX)
			return NULL;
		out->reports[out->report_count] = (stilb_input_report){.kind = (uint8_t)kind, .id = parser->global.report_id};
		out->report_count++;
		*number = (uint16_t)out->report_count;
	}
	STILB_ASSERT(*number <= out->report_count);
	return &parser->report_bits[*number - 1];
}

/* False: there are too many fields. */
static bool field_add(descriptor_parser *parser, const stilb_input_field *field)
{
	STILB_ASSERT(field->size > 0 && field->count > 0 && field->usage <= field->usage_last);
	if (parser->out->field_count == STILB_INPUT_FIELDS_MAX)
		return false;
	parser->out->fields[parser->out->field_count++] = *field;
	return true;
}

/* Adds a field for each range of usages: each takes as many elements as it has usages, the last one all that are
 * left. */
static bool variable_add(descriptor_parser *parser, stilb_input_field field)
{
	uint32_t left = field.count;
	for (uint32_t i = 0; i < parser->local.range_count && left; i++) {
		const descriptor_range *range = &parser->ranges[i];
		uint32_t usages = range->last - range->first + 1u, named = usages < left ? usages : left;
		field.count = i + 1 == parser->local.range_count ? left : named;
		field.usage = (uint32_t)range->page << 16 | range->first;
		field.usage_last = field.usage + named - 1;
		if (!field_add(parser, &field))
			return false;
		field.bit += field.count * field.size;
		left -= field.count;
	}
	return true;
}

/* Adds a field for each range of usages, all of the same bits: the values from logical_min on name the usages in
 * turn. */
static bool array_add(descriptor_parser *parser, stilb_input_field field)
{
	int64_t max = field.logical_max;
	for (uint32_t i = 0; i < parser->local.range_count && field.logical_min <= max; i++) {
		const descriptor_range *range = &parser->ranges[i];
		int64_t last = field.logical_min + range->last - range->first;
		field.logical_max = last < max ? last : max;
		field.usage = (uint32_t)range->page << 16 | range->first;
		field.usage_last = field.usage + (uint32_t)(field.logical_max - field.logical_min);
		if (!field_add(parser, &field))
			return false;
		field.logical_min = last + 1;
	}
	return true;
}

static stilb_result data_item(descriptor_parser *parser, stilb_input_field_kind kind, uint32_t flags)
{
	const descriptor_globals *global = &parser->global;
	const descriptor_collection *collection = &parser->collections[parser->depth];
	uint64_t width = (uint64_t)global->report_size * global->report_count;
	uint32_t *bits = report_bits(parser, kind);
	if (!bits)
		return descriptor_refuse(parser, "more than %u reports", STILB_INPUT_REPORTS_MAX);
	if (width > REPORT_BITS_MAX - *bits)
		return descriptor_refuse(parser, "report %u is longer than %u bytes", global->report_id,
		                         STILB_INPUT_REPORT_MAX);
	uint32_t bit = *bits;
	*bits += (uint32_t)width;
	if (flags & STILB_INPUT_CONSTANT || width == 0)
		return STILB_OK;
	if (global->logical_min > global->logical_max)
		return descriptor_refuse(parser, "the values from %lld to %lld are not a range", (long long)global->logical_min,
		                         (long long)global->logical_max);
	stilb_input_field field = {.kind = (uint8_t)kind,
	                           .report_id = global->report_id,
	                           .flags = (uint16_t)flags,
	                           .bit = bit,
	                           .size = global->report_size,
	                           .count = global->report_count,
	                           .logical_min = global->logical_min,
	                           .logical_max = global->logical_max,
	                           .physical_min = global->physical_min,
	                           .physical_max = global->physical_max,
	                           .unit = global->unit,
	                           .exponent = global->exponent,
	                           .collection = collection->application,
	                           .group = collection->group};
	bool added = parser->local.range_count == 0 ? field_add(parser, &field)
	             : flags & STILB_INPUT_VARIABLE ? variable_add(parser, field)
	                                            : array_add(parser, field);
	return added ? STILB_OK : descriptor_refuse(parser, "more than %u fields", STILB_INPUT_FIELDS_MAX);
}

static stilb_result main_item(descriptor_parser *parser, const descriptor_item *item)
{
	stilb_result result = STILB_OK; /* for undefined items too: descriptors of Bluetooth pads end with a zero */
	complete_pages(parser);
	switch (item->tag) {
	case MAIN_INPUT:
		result = data_item(parser, STILB_INPUT_FIELD_INPUT, item->data);
		break;
	case MAIN_OUTPUT:
		result = data_item(parser, STILB_INPUT_FIELD_OUTPUT, item->data);
		break;
	case MAIN_FEATURE:
		result = data_item(parser, STILB_INPUT_FIELD_FEATURE, item->data);
		break;
	case MAIN_COLLECTION:
		result = collection_begin(parser, item->data);
		break;
	case MAIN_END_COLLECTION:
		result = collection_end(parser);
		break;
	}
	parser->local = (descriptor_locals){0};
	return result;
}

/* ---- the whole descriptor ---------------------------------------------------------------------------------------- */

/* For STILB_CHECK: every field is within its report and has a range and usages of one page. */
static bool descriptor_is_sound(const stilb_input_descriptor *d)
{
	bool sound = d->field_count <= STILB_INPUT_FIELDS_MAX && d->report_count <= STILB_INPUT_REPORTS_MAX;
	for (uint32_t i = 0; sound && i < d->field_count; i++) {
		const stilb_input_field *field = &d->fields[i];
		uint64_t end = field->bit + (uint64_t)field->size * field->count;
		bool inside = false;
		for (uint32_t k = 0; k < d->report_count; k++)
			if (d->reports[k].kind == field->kind && d->reports[k].id == field->report_id)
				inside = end <= 8 * (uint64_t)d->reports[k].size;
		sound = inside && field->logical_min <= field->logical_max && field->usage >> 16 == field->usage_last >> 16;
	}
	return sound;
}

/* If one report has an id, all have: also those that came before the first id (HID 1.11, section 6.2.2.7). */
static void finish(const descriptor_parser *parser)
{
	stilb_input_descriptor *out = parser->out;
	for (uint32_t i = 0; i < out->report_count; i++)
		out->reports[i].size = (parser->report_bits[i] + 7) / 8 + out->numbered;
	for (uint32_t i = 0; i < out->field_count && out->numbered; i++)
		out->fields[i].bit += 8;
}

static stilb_result parse(descriptor_parser *parser, const uint8_t *bytes, size_t size)
{
	stilb_result result = STILB_OK;
	if (size == 0 || size > STILB_INPUT_DESCRIPTOR_MAX)
		result = descriptor_refuse(parser, "it has %zu bytes; a report descriptor has 1 to %u", size,
		                           STILB_INPUT_DESCRIPTOR_MAX);
	while (result == STILB_OK && parser->offset < size) {
		descriptor_item item;
		size_t length = item_read(parser, bytes, size, &item);
		if (length == 0)
			result = descriptor_refuse(parser, "the item is cut off");
		else if (item.type == TYPE_MAIN)
			result = main_item(parser, &item);
		else if (item.type == TYPE_GLOBAL)
			result = global_item(parser, &item);
		else if (item.type == TYPE_LOCAL)
			result = local_item(parser, &item);
		parser->offset += length;
	}
	if (result == STILB_OK && parser->depth)
		result = descriptor_refuse(parser, "collections that do not end: %u", parser->depth);
	if (result == STILB_OK && parser->local.delimited)
		result = descriptor_refuse(parser, "a delimited set does not end");
	return result;
}

stilb_result stilb_input_descriptor_parse(const uint8_t *bytes, size_t size, stilb_input_descriptor *out)
{
	STILB_ASSERT((bytes || size == 0) && out);
	descriptor_parser parser = {.out = out};
	out->field_count = out->report_count = 0;
	out->numbered = false;
	stilb_result result = parse(&parser, bytes, size);
	if (result == STILB_OK)
		finish(&parser);
	STILB_CHECK(result != STILB_OK || descriptor_is_sound(out));
	if (result != STILB_OK)
		out->field_count = out->report_count = 0;
	return result;
}

bool stilb_input_bits(const uint8_t *report, size_t size, uint32_t bit, uint32_t bits, uint32_t *value)
{
	STILB_ASSERT((report || size == 0) && value);
	if (bits < 1 || bits > 32 || (uint64_t)bit + bits > (uint64_t)size * 8)
		return false;
	uint64_t word = 0; /* the bytes that hold the bits: at most five */
	size_t first = bit / 8, end = (bit + bits + 7) / 8;
	for (size_t i = end; i-- > first;)
		word = word << 8 | report[i];
	*value = (uint32_t)(word >> bit % 8 & (UINT64_MAX >> (64 - bits)));
	return true;
}
