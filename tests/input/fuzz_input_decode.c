/* Any descriptor and any reports: stilb_input_layout_find gives a sound layout or a reason, and stilb_input_decode
 * gives a sound state or changes nothing.
 *
 * The fuzzer's input is: a byte that chooses the real pad whose bus, vendor and product are used; two bytes for the
 * descriptor's length; the descriptor; and reports, each with a byte for its length in front. If that byte has the bit
 * 0x80 and the layout has a CRC, the CRC is corrected before the report is decoded. */
#include "input/hid/input_layout.h"
#include "support/input_descriptors.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerInitialize(int *argc, char ***argv);

static void require(bool condition)
{
	if (!condition)
		abort();
}

/* ---- seeds ------------------------------------------------------------------------------------------------------- */

/* One pad with its descriptor, and four reports of every kind that it sends, of random bytes. */
static void write_seed(const char *folder, size_t index)
{
	const input_test_descriptor *pad = &input_test_descriptors[index];
	static stilb_input_descriptor parsed;
	char path[512];
	snprintf(path, sizeof path, "%s/own-%zu", folder, index);
	FILE *file = fopen(path, "w");
	require(file && stilb_input_descriptor_parse(pad->bytes, pad->size, &parsed) == STILB_OK);
	fputc((int)index, file);
	fputc((int)(pad->size & 0xff), file);
	fputc((int)(pad->size >> 8), file);
	require(fwrite(pad->bytes, 1, pad->size, file) == pad->size);
	for (uint32_t i = 0; i < parsed.report_count; i++) {
		const stilb_input_report *report = &parsed.reports[i];
		for (uint64_t k = 0; k < 4 && report->kind == STILB_INPUT_FIELD_INPUT && report->size <= 0x7f; k++) {
			fputc((int)(report->size | 0x80), file);
			for (uint64_t n = 0; n < report->size; n++)
				fputc(n == 0 ? report->id : (int)(stilb_random_u64(k, n) & 0xff), file);
		}
	}
	require(fclose(file) == 0);
}

/* The last argument is the folder of the seeds, which the fuzzer reads after this and adds to. */
int LLVMFuzzerInitialize(int *argc, char ***argv)
{
	const char *seeds = (*argv)[*argc - 1];
	if (*argc < 2 || seeds[0] == '-') {
		fprintf(stderr, "usage: fuzz_input_decode [-OPTION=VALUE ...] FOLDER\n");
		exit(1);
	}
	mkdir(seeds, 0777);
	for (size_t i = 0; i < input_test_descriptor_count; i++)
		write_seed(seeds, i);
	return 0;
}

/* ---- what must hold ---------------------------------------------------------------------------------------------- */

static void require_source(const stilb_input_source *s, uint32_t report_size)
{
	require(s->bits >= 1 && s->bits <= 32 && s->bit + s->bits <= 8 * report_size);
	require(s->kind <= STILB_INPUT_SOURCE_HAT);
	require(s->kind != STILB_INPUT_SOURCE_AXIS || (s->target < STILB_INPUT_AXIS_COUNT && s->low != s->high));
	require(s->kind != STILB_INPUT_SOURCE_BUTTON || (s->target < STILB_INPUT_BUTTON_COUNT && s->low <= s->high));
	require(s->kind != STILB_INPUT_SOURCE_HAT || s->low < s->high);
}

static void require_layout(const stilb_input_layout *layout)
{
	require(layout->report_count >= 1 && layout->report_count <= STILB_INPUT_LAYOUT_REPORTS_MAX);
	require(memchr(layout->name, 0, sizeof layout->name) && memchr(layout->recognised, 0, sizeof layout->recognised));
	for (uint32_t i = 0; i < layout->report_count; i++) {
		const stilb_input_layout_report *report = &layout->reports[i];
		require(report->source_count >= 1 && report->source_count <= STILB_INPUT_SOURCES_MAX);
		for (uint32_t k = 0; k < i; k++)
			require(layout->reports[k].id != report->id);
		for (uint32_t k = 0; k < report->source_count; k++)
			require_source(&report->sources[k], report->size);
	}
	uint8_t output[STILB_INPUT_OUTPUT_MAX];
	size_t size = stilb_input_rumble_report(layout, 0.5f, 1.0f, 3, output);
	require((size == 0) == (layout->rumble == STILB_INPUT_RUMBLE_NONE) && size <= sizeof output);
}

static void require_state(const stilb_input_pad_state *state)
{
	for (int i = 0; i < STILB_INPUT_AXIS_COUNT; i++)
		require(state->axes[i] <= 1.0f && state->axes[i] >= (i < STILB_INPUT_LEFT_TRIGGER ? -1.0f : 0.0f));
	require(state->buttons >> STILB_INPUT_BUTTON_COUNT == 0);
}

static void make_crc_right(const stilb_input_layout *layout, uint8_t *report, size_t size)
{
	for (uint32_t i = 0; i < layout->report_count; i++) {
		size_t at = layout->reports[i].crc;
		if (at == 0 || layout->reports[i].id != report[0] || size < at + 4)
			continue;
		uint32_t crc = stilb_input_crc32(stilb_input_crc32(0, "\xa1", 1), report, at);
		for (size_t k = 0; k < 4; k++)
			report[at + k] = (uint8_t)(crc >> 8 * k);
	}
}

/* The decoder has no state besides the pad's: the same report again changes nothing. */
static void use_report(const stilb_input_layout *layout, const uint8_t *report, size_t size,
                       stilb_input_pad_state *state)
{
	stilb_input_pad_state before = *state;
	stilb_input_decoded decoded = stilb_input_decode(layout, report, size, state);
	require_state(state);
	require(decoded == STILB_INPUT_DECODED || memcmp(state, &before, sizeof before) == 0);
	stilb_input_pad_state once = *state;
	require(stilb_input_decode(layout, report, size, state) == decoded && memcmp(state, &once, sizeof once) == 0);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	if (size < 3)
		return 0;
	static stilb_input_pad_info info;
	static stilb_input_layout layout;
	info = (stilb_input_pad_info){.name = "a thing", .vendor = 0x1234, .bus = STILB_INPUT_BUS_USB};
	if (data[0] < input_test_descriptor_count) {
		info.vendor = input_test_descriptors[data[0]].vendor;
		info.product = input_test_descriptors[data[0]].product;
		info.bus = input_test_descriptors[data[0]].bus;
	}
	size_t asked = (size_t)data[1] | (size_t)data[2] << 8, left = size - 3;
	size_t most = left < STILB_INPUT_DESCRIPTOR_MAX ? left : STILB_INPUT_DESCRIPTOR_MAX;
	info.descriptor_size = (uint16_t)(asked < most ? asked : most);
	memcpy(info.descriptor, data + 3, info.descriptor_size);
	if (stilb_input_layout_find(&info, &layout) != STILB_OK) {
		require(strstr(stilb_error_message(), "'a thing' ("));
		return 0;
	}
	require_layout(&layout);
	stilb_input_pad_state state = {0};
	for (size_t at = 3 + info.descriptor_size; at < size;) {
		uint8_t length = data[at++];
		size_t here = (length & 0x7fu) < size - at ? length & 0x7fu : size - at;
		uint8_t *report = malloc(here > 0 ? here : 1); /* of exactly that size: a read beyond its end is noticed */
		require(report);
		memcpy(report, data + at, here);
		if (length & 0x80 && here > 0)
			make_crc_right(&layout, report, here);
		use_report(&layout, report, here, &state);
		free(report);
		at += here;
	}
	return 0;
}
