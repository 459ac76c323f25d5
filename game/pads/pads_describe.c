/* stilb pads --describe: the fields of a report descriptor, by which a HID device describes the reports that it sends,
 * and the layout (the mapping to axes and buttons) that follows from it. */
#include "game/cli/flags.h"
#include "pads.h"

#include "input/input_recording.h"

#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

typedef struct describe_run {
	stilb_input_pad_info info;
	stilb_input_descriptor descriptor;
	stilb_input_layout layout;
	bool identified; /* bus, vendor and product are known */
	bool gamepad;
	char why_not[256];
} describe_run;

static const char *const kinds[] = {"input", "output", "feature"};

/* ---- reading the descriptor -------------------------------------------------------------------------------------- */

/* Reads vendor and product as --id takes them: "054c:05c4". */
static bool describe_take_id(const char *text, stilb_input_pad_info *info)
{
	static const char digits[] = "0123456789abcdefABCDEF";
	if (strlen(text) != 9 || strspn(text, digits) != 4 || text[4] != ':' || strspn(text + 5, digits) != 4) {
		stilb_log("--id: '%s' is not vendor and product like 054c:05c4", text);
		return false;
	}
	info->vendor = (uint16_t)strtoul(text, NULL, 16);
	info->product = (uint16_t)strtoul(text + 5, NULL, 16);
	return true;
}

/* True if the file begins with a character that recordings begin with. No descriptor does: as items, the elements of a
 * descriptor, these bytes are reserved or cannot come first (HID 1.11, section 6.2.2). */
static bool describe_is_recording(FILE *file)
{
	int first = getc(file);
	if (first != EOF)
		ungetc(first, file);
	return first != EOF && first != 0 && strchr("#DRNPI", first);
}

/* Takes descriptor, name, bus, vendor and product of the first pad of a recording. */
static bool describe_take_recording(const pads_options *o, describe_run *run)
{
	stilb_input_recording *recording;
	stilb_input_event event;
	if (o->id) {
		stilb_log("--id cannot be combined with a recording: '%s' has its own numbers", o->describe);
		return false;
	}
	if (stilb_input_recording_load(o->describe, &recording) != STILB_OK) {
		stilb_log("%s", stilb_error_message());
		return false;
	}
	if (stilb_input_recording_next(recording, INT64_MAX, &event)) /* a recording begins with a pad */
		run->info = *event.info;
	run->identified = true;
	stilb_input_recording_free(recording);
	return true;
}

static bool describe_take_bytes(const char *name, FILE *file, stilb_input_pad_info *info)
{
	uint8_t bytes[STILB_INPUT_DESCRIPTOR_MAX + 1];
	size_t size = fread(bytes, 1, sizeof bytes, file);
	if (ferror(file)) {
		stilb_log("cannot read '%s': %s", name, strerror(errno));
		return false;
	}
	if (size == 0 || size > STILB_INPUT_DESCRIPTOR_MAX) {
		stilb_log("cannot read '%s': it has %s bytes; a report descriptor has 1..%u", name,
		          size == 0 ? "no" : "too many", STILB_INPUT_DESCRIPTOR_MAX);
		return false;
	}
	snprintf(info->name, sizeof info->name, "%s", strrchr(name, '/') ? strrchr(name, '/') + 1 : name);
	memcpy(info->descriptor, bytes, size);
	info->descriptor_size = (uint16_t)size;
	return true;
}

static bool describe_take_file(const pads_options *o, describe_run *run)
{
	bool standard = strcmp(o->describe, "-") == 0;
	FILE *file = standard ? stdin : fopen(o->describe, "rbe");
	if (!file) {
		stilb_log("cannot read '%s': %s", o->describe, strerror(errno));
		return false;
	}
	bool recorded = describe_is_recording(file);
	bool taken = recorded || describe_take_bytes(standard ? "standard input" : o->describe, file, &run->info);
	if (!standard)
		fclose(file);
	return recorded ? describe_take_recording(o, run) : taken;
}

/* Reads what --describe names. A node /dev/hidrawN is looked up in sysfs, which needs no permission; anything else is
 * read as a file. */
static bool describe_take(const pads_options *o, describe_run *run)
{
	static const uint16_t buses[] = {STILB_INPUT_BUS_USB, STILB_INPUT_BUS_BLUETOOTH};
	if (strncmp(o->describe, "/dev/hidraw", 11) == 0) {
		run->identified = true;
		if (stilb_input_look(o->describe, &run->info) == STILB_OK)
			return true;
		stilb_log("%s", stilb_error_message());
		return false;
	}
	run->info.bus = buses[o->bus];
	run->identified = o->id;
	return (!o->id || describe_take_id(o->id, &run->info)) && describe_take_file(o, run);
}

/* ---- as a table -------------------------------------------------------------------------------------------------- */

/* Writes the usages of a field, which say what its values mean: "Button / 1 .. 14", "Generic Desktop / X". */
static const char *describe_usages(const stilb_input_field *field, char text[160])
{
	char last[80];
	const char *end;
	stilb_input_usage_text(field->usage, text, 80);
	if (field->usage_last <= field->usage || field->count < 2)
		return text;
	stilb_input_usage_text(field->usage_last, last, sizeof last);
	end = strstr(last, " / ");
	size_t length = strlen(text);
	snprintf(text + length, 160 - length, " .. %s", end ? end + 3 : last);
	return text;
}

static void describe_print_fields(FILE *out, const stilb_input_descriptor *d)
{
	fprintf(out, "\nreport         bit  bits    values                usage\n");
	for (uint32_t i = 0; i < d->field_count; i++) {
		const stilb_input_field *field = &d->fields[i];
		char usages[160], bits[32], range[64];
		snprintf(bits, sizeof bits, "%" PRIu32 "x%" PRIu32, field->count, field->size);
		snprintf(range, sizeof range, "%" PRId64 "..%" PRId64, field->logical_min, field->logical_max);
		fprintf(
			out, "%-7s 0x%02x %5" PRIu32 "  %-6s  %-20s  %s%s%s%s\n", kinds[field->kind], field->report_id, field->bit,
			bits, range, describe_usages(field, usages), field->flags & STILB_INPUT_VARIABLE ? "" : ", array",
			field->flags & STILB_INPUT_RELATIVE ? ", relative" : "", field->flags & STILB_INPUT_NULL ? ", null" : "");
	}
	fprintf(out, "\nreport        bytes\n");
	for (uint32_t i = 0; i < d->report_count; i++)
		fprintf(out, "%-7s 0x%02x %6" PRIu32 "\n", kinds[d->reports[i].kind], d->reports[i].id, d->reports[i].size);
}

static const char *describe_target(const stilb_input_source *source)
{
	if (source->kind == STILB_INPUT_SOURCE_HAT)
		return "up, right, down, left";
	return source->kind == STILB_INPUT_SOURCE_AXIS ? stilb_input_axis_names[source->target]
	                                               : stilb_input_button_names[source->target];
}

static void describe_print_layout(FILE *out, const stilb_input_layout *layout)
{
	fprintf(out, "\n%s: %s\n%s\n", layout->name, layout->recognised,
	        layout->rumble == STILB_INPUT_RUMBLE_NONE ? "no rumble" : "rumbles");
	for (uint32_t r = 0; r < layout->report_count; r++) {
		const stilb_input_layout_report *report = &layout->reports[r];
		fprintf(out, "\nreport 0x%02x, %u bytes%s\n", report->id, report->size,
		        report->crc ? ", the last four a CRC-32" : "");
		for (uint32_t i = 0; i < report->source_count; i++) {
			const stilb_input_source *source = &report->sources[i];
			fprintf(out, "  byte %3" PRIu32 " bit %" PRIu32 " %3u %-4s  %6" PRId64 "..%-6" PRId64 "  %s\n",
			        source->bit / 8, source->bit % 8, source->bits, source->bits == 1 ? "bit" : "bits", source->low,
			        source->high, describe_target(source));
		}
	}
}

static void describe_print(FILE *out, const pads_options *o, const describe_run *run)
{
	char bus[16];
	const stilb_input_pad_info *info = &run->info;
	fprintf(out, "%s: %u bytes, %" PRIu32 " fields", o->describe, info->descriptor_size, run->descriptor.field_count);
	if (run->identified)
		fprintf(out, "; %s, vendor %04x, product %04x\n", pads_bus_text(info->bus, bus), info->vendor, info->product);
	else
		fprintf(out, "; read as an unknown pad's, because --id is not given\n");
	describe_print_fields(out, &run->descriptor);
	if (run->gamepad)
		describe_print_layout(out, &run->layout);
	else
		fprintf(out, "\nnot a gamepad: %s\n", run->why_not);
}

/* ---- as JSON ----------------------------------------------------------------------------------------------------- */

static void describe_json_field(stilb_json *json, const stilb_input_field *field)
{
	char usages[160];
	stilb_json_begin(json, NULL, '{');
	stilb_json_string(json, "kind", kinds[field->kind]);
	stilb_json_int(json, "report", field->report_id);
	stilb_json_int(json, "bit", field->bit);
	stilb_json_int(json, "bits", field->size);
	stilb_json_int(json, "count", field->count);
	stilb_json_string(json, "usage", describe_usages(field, usages));
	stilb_json_int(json, "logical_min", field->logical_min);
	stilb_json_int(json, "logical_max", field->logical_max);
	stilb_json_bool(json, "array", !(field->flags & STILB_INPUT_VARIABLE));
	stilb_json_bool(json, "relative", field->flags & STILB_INPUT_RELATIVE);
	stilb_json_bool(json, "null", field->flags & STILB_INPUT_NULL);
	stilb_json_end(json, '}');
}

static void describe_json_source(stilb_json *json, const stilb_input_source *source)
{
	static const char *const source_kinds[] = {"axis", "button", "hat"};
	stilb_json_begin(json, NULL, '{');
	stilb_json_string(json, "kind", source_kinds[source->kind]);
	stilb_json_string(json, "target", describe_target(source));
	stilb_json_int(json, "bit", source->bit);
	stilb_json_int(json, "bits", source->bits);
	stilb_json_int(json, "low", source->low);
	stilb_json_int(json, "high", source->high);
	stilb_json_end(json, '}');
}

static void describe_json_layout(stilb_json *json, const stilb_input_layout *layout)
{
	stilb_json_string(json, "layout", layout->name);
	stilb_json_string(json, "recognised", layout->recognised);
	stilb_json_bool(json, "rumble", layout->rumble != STILB_INPUT_RUMBLE_NONE);
	stilb_json_begin(json, "mapping", '[');
	for (uint32_t r = 0; r < layout->report_count; r++) {
		const stilb_input_layout_report *report = &layout->reports[r];
		stilb_json_begin(json, NULL, '{');
		stilb_json_int(json, "report", report->id);
		stilb_json_int(json, "bytes", report->size);
		stilb_json_bool(json, "crc", report->crc > 0);
		stilb_json_begin(json, "sources", '[');
		for (uint32_t i = 0; i < report->source_count; i++)
			describe_json_source(json, &report->sources[i]);
		stilb_json_end(json, ']');
		stilb_json_end(json, '}');
	}
	stilb_json_end(json, ']');
}

static stilb_result describe_save(const pads_options *o, const describe_run *run)
{
	stilb_json json = {0};
	stilb_json_begin(&json, NULL, '{');
	pads_json_info(&json, &run->info);
	stilb_json_int(&json, "bytes", run->info.descriptor_size);
	stilb_json_begin(&json, "fields", '[');
	for (uint32_t i = 0; i < run->descriptor.field_count; i++)
		describe_json_field(&json, &run->descriptor.fields[i]);
	stilb_json_end(&json, ']');
	stilb_json_begin(&json, "reports", '[');
	for (uint32_t i = 0; i < run->descriptor.report_count; i++) {
		stilb_json_begin(&json, NULL, '{');
		stilb_json_string(&json, "kind", kinds[run->descriptor.reports[i].kind]);
		stilb_json_int(&json, "report", run->descriptor.reports[i].id);
		stilb_json_int(&json, "bytes", run->descriptor.reports[i].size);
		stilb_json_end(&json, '}');
	}
	stilb_json_end(&json, ']');
	stilb_json_bool(&json, "gamepad", run->gamepad);
	if (run->gamepad)
		describe_json_layout(&json, &run->layout);
	else
		stilb_json_string(&json, "why_not", run->why_not);
	stilb_json_end(&json, '}');
	return stilb_json_save(&json, o->json);
}

/* ---- the command ------------------------------------------------------------------------------------------------- */

int pads_describe(const pads_options *o)
{
	static describe_run run;
	FILE *words = pads_message_stream(o);
	if (!describe_take(o, &run))
		return EXIT_REFUSED;
	if (stilb_input_descriptor_parse(run.info.descriptor, run.info.descriptor_size, &run.descriptor) != STILB_OK) {
		stilb_log("'%s' is not a report descriptor: %s", o->describe, stilb_error_message());
		return EXIT_REFUSED;
	}
	if (run.descriptor.field_count == 0) {
		stilb_log("'%s' is not a report descriptor: it has no fields", o->describe);
		return EXIT_FAILED;
	}
	run.gamepad = stilb_input_layout_find(&run.info, &run.layout) == STILB_OK;
	if (!run.gamepad)
		snprintf(run.why_not, sizeof run.why_not, "%s", stilb_error_message());
	if (words)
		describe_print(words, o, &run);
	if (o->json && describe_save(o, &run) != STILB_OK) {
		stilb_log("%s", stilb_error_message());
		return EXIT_FAILED;
	}
	return EXIT_DONE;
}
