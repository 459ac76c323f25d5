/* input_recording: events written to a file are read back, other programs' files are read, and damaged files are
 * refused with the line. */
#include "input/input_recording_internal.h"
#include "input/input_text_internal.h"
#include "jobs/job_random.h"
#include "support/failing_memory.h"
#include "support/folder.h"
#include "support/input_descriptors.h"
#include "support/test.h"

#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- a folder of its own, which is the current one --------------------------------------------------------------- */

static int folder_leave(void **state)
{
	(void)state;
	return folder_remove();
}

static void write_text(const char *path, const char *text, size_t length)
{
	FILE *file = fopen(path, "w");
	assert_non_null(file);
	assert_int_equal(fwrite(text, 1, length, file), length);
	assert_int_equal(fclose(file), 0);
}

/* Reads a file as a new string; *length is its length. */
static char *read_text(const char *path, size_t *length)
{
	struct stat info;
	FILE *file = fopen(path, "r");
	assert_non_null(file);
	assert_int_equal(fstat(fileno(file), &info), 0);
	*length = (size_t)info.st_size;
	char *text = test_malloc(*length + 1);
	assert_int_equal(fread(text, 1, *length, file), *length);
	text[*length] = '\0';
	fclose(file);
	return text;
}

/* ---- made events ------------------------------------------------------------------------------------------------- */

typedef struct made_event {
	stilb_input_event event;
	stilb_input_pad_info info;
	uint8_t bytes[64];
} made_event;

#define MADE_START 7200000123 /* microseconds of the clock at the first event: a recording's own times begin at 0 */

static void made_info(stilb_input_pad_info *info, const char *name, const char *path, size_t descriptor)
{
	const input_test_descriptor *from = &input_test_descriptors[descriptor];
	*info = (stilb_input_pad_info){.bus = from->bus, .vendor = from->vendor, .product = from->product};
	snprintf(info->name, sizeof info->name, "%s", name);
	snprintf(info->path, sizeof info->path, "%s", path);
	snprintf(info->unique, sizeof info->unique, "00:11:22:33:44:55");
	info->descriptor_size = (uint16_t)from->size;
	memcpy(info->descriptor, from->bytes, from->size);
}

static made_event made_added(uint32_t pad, int64_t time_us, const char *name, size_t descriptor)
{
	made_event made = {.event = {.kind = STILB_INPUT_PAD_ADDED, .pad = pad, .time_us = MADE_START + time_us}};
	char path[64];
	snprintf(path, sizeof path, "/dev/hidraw%u", pad);
	made_info(&made.info, name, path, descriptor);
	return made;
}

static made_event made_other(stilb_input_event_kind kind, uint32_t pad, int64_t time_us, uint32_t size)
{
	made_event made = {.event = {.kind = kind, .pad = pad, .time_us = MADE_START + time_us, .size = size}};
	for (uint32_t i = 0; i < size; i++)
		made.bytes[i] = (uint8_t)((uint64_t)time_us + i * 37 + pad);
	return made;
}

static void record(stilb_input_recorder *recorder, made_event *made)
{
	made->event.info = made->event.kind <= STILB_INPUT_PAD_DENIED ? &made->info : NULL;
	made->event.bytes = made->event.kind == STILB_INPUT_PAD_REPORT ? made->bytes : NULL;
	assert_int_equal(stilb_input_recorder_add(recorder, &made->event), STILB_OK);
}

static void assert_same_event(const stilb_input_event *event, const made_event *made, int64_t start_us)
{
	assert_int_equal(event->kind, made->event.kind);
	assert_int_equal(event->pad, made->event.pad);
	assert_int_equal(event->time_us, made->event.time_us - start_us);
	assert_int_equal(event->size, made->event.size);
	if (event->kind == STILB_INPUT_PAD_REPORT)
		assert_memory_equal(event->bytes, made->bytes, event->size);
	if (event->kind != STILB_INPUT_PAD_ADDED)
		return;
	assert_string_equal(event->info->name, made->info.name);
	assert_string_equal(event->info->path, made->info.path);
	assert_string_equal(event->info->unique, "");
	assert_int_equal(event->info->bus, made->info.bus);
	assert_int_equal(event->info->vendor, made->info.vendor);
	assert_int_equal(event->info->product, made->info.product);
	assert_int_equal(event->info->descriptor_size, made->info.descriptor_size);
	assert_memory_equal(event->info->descriptor, made->info.descriptor, made->info.descriptor_size);
}

static stilb_input_recording *load(const char *path)
{
	stilb_input_recording *recording;
	if (stilb_input_recording_load(path, &recording) != STILB_OK)
		print_error("%s\n", stilb_error_message());
	assert_non_null(recording);
	return recording;
}

/* Records the events of a recording to another file. */
static void record_again(stilb_input_recording *recording, const char *path)
{
	stilb_input_recorder *recorder;
	stilb_input_event event;
	assert_int_equal(stilb_input_recorder_create(path, &recorder), STILB_OK);
	while (stilb_input_recording_next(recording, INT64_MAX, &event))
		assert_int_equal(stilb_input_recorder_add(recorder, &event), STILB_OK);
	assert_int_equal(stilb_input_recorder_close(recorder), STILB_OK);
}

static void assert_same_files(const char *a, const char *b)
{
	size_t lengths[2];
	char *texts[2] = {read_text(a, &lengths[0]), read_text(b, &lengths[1])};
	assert_int_equal(lengths[0], lengths[1]);
	assert_memory_equal(texts[0], texts[1], lengths[0]);
	test_free(texts[0]);
	test_free(texts[1]);
}

/* ---- there and back ---------------------------------------------------------------------------------------------- */

#define REPORTS 600

/* Three pads, one of which is unplugged and comes back with another number, among events that are not recorded. */
static void test_round_trip(void **state)
{
	(void)state;
	static made_event made[REPORTS + 16];
	bool kept[REPORTS + 16];
	size_t count = 0;
	stilb_input_recorder *recorder;
	made[count++] = made_added(7, -5, "denied", 0);
	made[0].event.kind = STILB_INPUT_PAD_DENIED;
	made[count++] = made_other(STILB_INPUT_PAD_REMOVED, 7, -4, 0);
	made[count] = made_added(8, -3, "of the window", 0);
	made[count++].info.descriptor_size = 0;
	made[count++] = made_other(STILB_INPUT_PAD_STATE, 8, -2, 0);
	made[count++] = made_added(2, 0, "Wireless Controller", 0);
	made[count++] = made_added(900000, 0, "Maus \xc3\xbc, not \xe2\x82\xac", 2);
	for (uint32_t i = 0; i < REPORTS; i++) {
		if (i == 400)
			made[count++] = made_other(STILB_INPUT_PAD_REMOVED, 2, 40000, 0);
		if (i == 500)
			made[count++] = made_added(3, 50000, "", 0);
		uint32_t pad = i % 3 == 0 ? 900000 : i < 400 ? 2 : 3;
		made[count++] = made_other(STILB_INPUT_PAD_REPORT, pad, 100 * (int64_t)i, 1 + i % 64);
	}
	made[count++] = made_other(STILB_INPUT_PAD_REMOVED, 900000, 3599999999, 0);
	made[count++] = made_other(STILB_INPUT_PAD_REPORT, 900000, 3600000000, 9); /* of a pad that was removed */
	made[count++] = made_other(STILB_INPUT_PAD_REMOVED, 2, 3600000001, 0);
	assert_int_equal(stilb_input_recorder_create("a.rec", &recorder), STILB_OK);
	static const uint32_t pads[] = {2, 3, 900000}; /* numbers of the pads that are recorded */
	bool there[3] = {false};
	for (size_t i = 0; i < count; i++) {
		const stilb_input_event *event = &made[i].event;
		record(recorder, &made[i]);
		kept[i] = false;
		for (int k = 0; k < 3; k++) {
			if (event->pad != pads[k])
				continue;
			kept[i] = there[k] || event->kind == STILB_INPUT_PAD_ADDED;
			there[k] = kept[i] && event->kind != STILB_INPUT_PAD_REMOVED;
		}
	}
	assert_int_equal(stilb_input_recorder_close(recorder), STILB_OK);
	stilb_input_event read;
	stilb_input_recording *recording = load("a.rec");
	assert_int_equal(stilb_input_recording_end_us(recording), 3599999999);
	for (size_t i = 0; i < count; i++) {
		if (!kept[i])
			continue;
		assert_true(stilb_input_recording_next(recording, INT64_MAX, &read));
		assert_same_event(&read, &made[i], MADE_START);
	}
	assert_false(stilb_input_recording_next(recording, INT64_MAX, &read));
	stilb_input_recording_free(recording);
	recording = load("a.rec");
	record_again(recording, "b.rec");
	stilb_input_recording_free(recording);
	assert_same_files("a.rec", "b.rec");
	assert_int_equal(folder_clear(), 2);
}

static const char golden[] = "# recorded by Stilb " STILB_VERSION ", in the format of hid-recorder\n"
							 "D: 0\n"
							 "# added 000000.000000\n"
							 "R: 4 05 01 c0 ff\n"
							 "N: Pad\n"
							 "P: /dev/hidraw0\n"
							 "I: 3 054c 05c4\n"
							 "E: 000001.000000 2 01 a0\n"
							 "E: 000003.250001 1 0f\n"
							 "# removed 000004.000000\n";

/* The exact text, because other programs read it. */
static void test_text(void **state)
{
	(void)state;
	static made_event made[4];
	stilb_input_recorder *recorder;
	made[0] = made_added(1, 0, "Pad", 0);
	snprintf(made[0].info.path, sizeof made[0].info.path, "/dev/hidraw0");
	made[0].info.bus = 3;
	made[0].info.vendor = 0x54c;
	made[0].info.product = 0x5c4;
	made[0].info.descriptor_size = 4;
	memcpy(made[0].info.descriptor, "\x05\x01\xc0\xff", 4);
	made[1] = made_other(STILB_INPUT_PAD_REPORT, 1, 1000000, 2);
	memcpy(made[1].bytes, "\x01\xa0", 2);
	made[2] = made_other(STILB_INPUT_PAD_REPORT, 1, 3250001, 1);
	made[2].bytes[0] = 15;
	made[3] = made_other(STILB_INPUT_PAD_REMOVED, 1, 4000000, 0);
	assert_int_equal(stilb_input_recorder_create("a.rec", &recorder), STILB_OK);
	for (int i = 0; i < 4; i++)
		record(recorder, &made[i]);
	assert_int_equal(stilb_input_recorder_close(recorder), STILB_OK);
	write_text("golden.rec", golden, sizeof golden - 1);
	assert_same_files("a.rec", "golden.rec");
	assert_int_equal(folder_clear(), 2);
}

/* stilb_input_recording_next gives the events up to a time, that time included. */
static void test_until(void **state)
{
	(void)state;
	stilb_input_event event;
	write_text("a.rec", golden, sizeof golden - 1);
	stilb_input_recording *recording = load("a.rec");
	assert_false(stilb_input_recording_next(recording, -1, &event));
	assert_true(stilb_input_recording_next(recording, 0, &event));
	assert_false(stilb_input_recording_next(recording, 999999, &event));
	assert_true(stilb_input_recording_next(recording, 1000000, &event));
	assert_int_equal(event.time_us, 1000000);
	assert_false(stilb_input_recording_next(recording, 3250000, &event));
	assert_true(stilb_input_recording_next(recording, 4000000, &event));
	assert_int_equal(event.time_us, 3250001);
	assert_true(stilb_input_recording_next(recording, 4000000, &event));
	assert_int_equal(event.kind, STILB_INPUT_PAD_REMOVED);
	assert_false(stilb_input_recording_next(recording, INT64_MAX, &event));
	stilb_input_recording_free(recording);
	folder_clear();
}

/* A recording without a report does not replace an existing file. */
static void test_nothing_recorded(void **state)
{
	(void)state;
	static made_event made;
	stilb_input_recorder *recorder;
	write_text("a.rec", golden, sizeof golden - 1);
	for (int described = 0; described < 2; described++) {
		assert_int_equal(stilb_input_recorder_create("a.rec", &recorder), STILB_OK);
		made = made_added(1, 0, "Pad", 0);
		made.event.kind = described ? STILB_INPUT_PAD_ADDED : STILB_INPUT_PAD_DENIED;
		record(recorder, &made);
		assert_int_equal(stilb_input_recorder_close(recorder), STILB_ERROR_FILE);
		assert_non_null(strstr(stilb_error_message(), "no gamepad sent a report: 'a.rec' is not written"));
	}
	write_text("golden.rec", golden, sizeof golden - 1);
	assert_same_files("a.rec", "golden.rec");
	assert_int_equal(folder_clear(), 2);
	stilb_input_recording_free(NULL);
	assert_int_equal(stilb_input_recorder_close(NULL), STILB_OK);
	folder_clear();
}

/* ---- other programs' files --------------------------------------------------------------------------------------- */

/* As hid-recorder writes two devices: descriptions first, remarks between, its own time; and as an editor may leave
 * it. */
static const char foreign[] = "# Wireless Controller\n"
							  "# 0x05, 0x01,   // Usage Page (Generic Desktop)  0\n"
							  "D: 0\r\n"
							  "R: 3  05 01\tC0\n"
							  "N: Wireless Controller\r\n"
							  "P: usb-0000:00:14.0-1/input3\n"
							  "I: 3 54C 5c4\n"
							  "\n"
							  "D: 1\n"
							  "I: 5 045e 02e0\n"
							  "R: 1 c0\n"
							  "P:\n"
							  "D: 0\n"
							  "# ReportID: 1 / X: 127\n"
							  "E: 001700.500000 3 01 02 03\n"
							  "D: 1\n"
							  "E: 001700.400000 1 ff\n"
							  "# removed\n"
							  "# removed by hand\n"
							  "D: 0\n"
							  "E: 001701.500007 1 00";

static void test_foreign(void **state)
{
	(void)state;
	static const struct {
		stilb_input_event_kind kind;
		uint32_t pad, size;
		int64_t time_us;
	} wanted[] = {
		{STILB_INPUT_PAD_ADDED, 1, 0, 0},  {STILB_INPUT_PAD_ADDED, 2, 0, 0},   {STILB_INPUT_PAD_REPORT, 1, 3, 0},
		{STILB_INPUT_PAD_REPORT, 2, 1, 0}, {STILB_INPUT_PAD_REMOVED, 2, 0, 0}, {STILB_INPUT_PAD_REPORT, 1, 1, 1000007},
	};
	const stilb_input_pad_info *infos[2] = {NULL, NULL};
	stilb_input_event event;
	write_text("a.rec", foreign, sizeof foreign - 1);
	stilb_input_recording *recording = load("a.rec");
	for (size_t i = 0; i < sizeof wanted / sizeof *wanted; i++) {
		assert_true(stilb_input_recording_next(recording, INT64_MAX, &event));
		assert_int_equal(event.kind, wanted[i].kind);
		assert_int_equal(event.pad, wanted[i].pad);
		assert_int_equal(event.size, wanted[i].size);
		assert_int_equal(event.time_us, wanted[i].time_us);
		if (event.info)
			infos[event.pad - 1] = event.info;
	}
	assert_false(stilb_input_recording_next(recording, INT64_MAX, &event));
	assert_string_equal(infos[0]->name, "Wireless Controller");
	assert_string_equal(infos[0]->path, "usb-0000:00:14.0-1/input3");
	assert_int_equal(infos[0]->vendor, 0x54c);
	assert_int_equal(infos[0]->descriptor_size, 3);
	assert_memory_equal(infos[0]->descriptor, "\x05\x01\xc0", 3);
	assert_string_equal(infos[1]->name, "");
	assert_string_equal(infos[1]->path, "");
	assert_int_equal(infos[1]->bus, 5);
	stilb_input_recording_free(recording);
	folder_clear();
}

/* Names go to terminals and into windows. */
static void test_names(void **state)
{
	(void)state;
	static const char *const names[][2] = {
		{"plain", "plain"},
		{"\x1b[31mred\x7f\t", "?[31mred??"},
		{"c1 \xc2\x9b!", "c1 ?!"},
		{"\xc3\xa4 \xe2\x82\xac \xf0\x9f\x8e\xae", "\xc3\xa4 \xe2\x82\xac \xf0\x9f\x8e\xae"},
		{"bad \xff\xc3 \xed\xa0\x80 \xc0\xaf \xf4\x90\x80\x80 \xe0\x80\xaf \xe2\x82", "bad ?? ??? ?? ???? ??? ??"},
	};
	stilb_input_event event;
	for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
		char text[256];
		int length = snprintf(text, sizeof text, "N: %s\nR: 1 c0\nI: 3 1 2\nE: 000000.000000 1 00\n", names[i][0]);
		write_text("a.rec", text, (size_t)length);
		stilb_input_recording *recording = load("a.rec");
		assert_true(stilb_input_recording_next(recording, 0, &event));
		assert_string_equal(event.info->name, names[i][1]);
		stilb_input_recording_free(recording);
	}
	folder_clear();
	char cut[8];
	input_text_copy(cut, sizeof cut, "\xe2\x82\xac", 2); /* the third byte is beyond the length */
	assert_string_equal(cut, "??");
	for (size_t size = 1; size <= sizeof cut; size++) { /* text is cut after a whole character */
		static const size_t fits[] = {0, 1, 1, 1, 4, 4, 4, 7};
		input_text_copy(cut, size, "a\xe2\x82\xac\xe2\x82\xac", 7);
		assert_int_equal(strlen(cut), fits[size - 1]);
	}
}

/* ---- refused ----------------------------------------------------------------------------------------------------- */

#define PAD "R: 1 c0\nI: 3 054c 05c4\n"

static const struct {
	const char *text, *message;
} refusals[] = {
	{"{\"traceEvents\": []}", "line 1: does not begin with D: R:"},
	{"# fine\nX: 1\n", "line 2: does not begin with"},
	{"D:\n", "line 1: D: needs the pad's number"},
	{"D: x\n", "line 1: D: needs"},
	{"D: 0 0\n", "line 1: D: needs"},
	{"D: -1\n", "line 1: D: needs"},
	{"D: 4294967295\n", "line 1: D: needs"},
	{"D: 99999999999999999999\n", "line 1: D: needs"},
	{"R:\n", "line 1: the descriptor's size is not 1..4096"},
	{"R: 0\n", "line 1: the descriptor's size"},
	{"R: 4097 00\n", "line 1: the descriptor's size"},
	{"R: 2 00\n", "line 1: the descriptor has 1 bytes, not the 2 it says"},
	{"R: 1 00 00\n", "line 1: the descriptor has 2 bytes, not the 1 it says"},
	{"R: 1\n", "line 1: the descriptor has 0 bytes, not the 1"},
	{"R: 1 0\n", "line 1: the descriptor has something other than bytes"},
	{"R: 1 000\n", "line 1: the descriptor has something other"},
	{"R: 1 0g\n", "line 1: the descriptor has something other"},
	{"R: 1c0\n", "line 1: the descriptor has something other"},
	{"R: 1 c0\nR: 1 c0\n", "line 2: pad 0 has an R line already"},
	{"I: 3 054c\n", "line 1: I: needs bus, vendor and product"},
	{"I: 3 054c 05c4 1\n", "line 1: I: needs"},
	{"I: 3 054c 105c4\n", "line 1: I: needs"},
	{"I: 3 -1 0\n", "line 1: I: needs"},
	{"E: 000001.000000 1 00\n", "line 1: pad 0 has no R and I lines before this"},
	{"R: 1 c0\nE: 000001.000000 1 00\n", "line 2: pad 0 has no R and I lines"},
	{PAD "D: 1\nE: 000001.000000 1 00\n", "line 4: pad 1 has no R and I lines"},
	{"R: 1 c0\n", "pad 0 has no I line"},
	{PAD "D: 3\nN: late\nI: 3 0 0\n", "pad 3 has no R line"},
	{PAD "E:\n", "line 3: E: needs time, size and bytes"},
	{PAD "E: 1 1 00\n", "line 3: E: needs"},
	{PAD "E: 000001.5 1 00\n", "line 3: E: needs"},
	{PAD "E: 000001.5000000 1 00\n", "line 3: E: needs"},
	{PAD "E: -00001.500000 1 00\n", "line 3: E: needs"},
	{PAD "E: 4294967296.000000 1 00\n", "line 3: E: needs"},
	{PAD "E: 000001.000000\n", "line 3: the report's size"},
	{PAD "E: 000001.000000 0\n", "line 3: the report's size"},
	{PAD "E: 000001.000000 4097 00\n", "line 3: the report's size"},
	{PAD "E: 000001.000000 2 00\n", "line 3: the report has 1 bytes, not the 2"},
	{PAD "E: 000001.000000 1 zz\n", "line 3: the report has something other"},
	{"# removed\n", "line 1: pad 0 has no R and I lines"},
	{PAD "# removed\n# removed\n", "line 4: pad 0 was removed before"},
	{PAD "# removed 000001.000000\nE: 000002.000000 1 00\n", "line 4: pad 0 was removed before"},
	{PAD "# removed\nN: again\n", "line 4: pad 0 was removed before"},
	{"", "it holds no report"},
	{"# a remark\n", "it holds no report"},
	{"D: 0\nD: 1\n", "it holds no report"},
	{PAD "# removed\n", "it holds no report"},
	{PAD "E: 000009.000000 1 00\nE: 000007.999999 1 00\n", "line 4: the time goes back by 1.000001 s"},
	{PAD "E: 000009.000000 1 00\nE: 000008.500000 1 00\nE: 000007.999999 1 00\n", "line 5: the time goes back"},
	{PAD "E: 000009.000000 1 00\n# removed 000001.000000\n", "line 4: the time goes back"},
};

static void assert_refused(const char *path, const char *message)
{
	stilb_input_recording *recording = (stilb_input_recording *)refusals;
	assert_int_equal(stilb_input_recording_load(path, &recording), STILB_ERROR_FILE);
	assert_null(recording);
	if (!strstr(stilb_error_message(), path) || !strstr(stilb_error_message(), message))
		print_error("not '%s' and '%s' in: %s\n", path, message, stilb_error_message());
	assert_non_null(strstr(stilb_error_message(), path));
	assert_non_null(strstr(stilb_error_message(), message));
}

static void test_refusals(void **state)
{
	(void)state;
	for (size_t i = 0; i < sizeof refusals / sizeof *refusals; i++) {
		write_text("a.rec", refusals[i].text, strlen(refusals[i].text));
		assert_refused("a.rec", refusals[i].message);
	}
	write_text("a.rec", "# a\0b\n# c\n", 10);
	assert_refused("a.rec", "line 1: is longer than 16382 bytes or has a zero byte");
	assert_refused("/dev/zero", "line 1: is longer");
	assert_refused("missing.rec", "No such file");
	assert_refused(".", "Is a directory");
	folder_clear();
}

/* A line of 16382 bytes and its line end is read, one of a byte more is refused. */
static void test_line_length(void **state)
{
	(void)state;
	static const char report[] = PAD "E: 000000.000000 1 00\n";
	static char text[sizeof report - 1 + 16384];
	size_t before = sizeof report - 1;
	memcpy(text, report, before);
	char *line = text + before;
	memset(line, '#', 16384);
	line[16382] = '\n';
	write_text("a.rec", text, before + 16383);
	stilb_input_recording_free(load("a.rec"));
	write_text("a.rec", text, before + 16382); /* the last line without a line end */
	stilb_input_recording_free(load("a.rec"));
	line[16382] = '#';
	line[16383] = '\n';
	write_text("a.rec", text, before + 16384);
	assert_refused("a.rec", "is longer");
	folder_clear();
}

/* A time may go back by up to a second for one pad, and by more if it is another pad's: it then counts as the time of
 * the line before. */
static void test_disorder(void **state)
{
	(void)state;
	static const char text[] = PAD "D: 1\n" PAD "D: 0\nE: 000009.000000 1 00\nE: 000008.000000 1 01\n"
								   "D: 1\nE: 000001.000000 1 02\n";
	stilb_input_event event;
	write_text("a.rec", text, sizeof text - 1);
	stilb_input_recording *recording = load("a.rec");
	assert_int_equal(stilb_input_recording_end_us(recording), 0);
	for (int i = 0; i < 5; i++)
		assert_true(stilb_input_recording_next(recording, 0, &event));
	assert_int_equal(event.bytes[0], 2);
	stilb_input_recording_free(recording);
	folder_clear();
}

/* The largest descriptor and report, and as many pads as there may be; one more is refused on both sides. */
static void test_limits(void **state)
{
	(void)state;
	static made_event made;
	static uint8_t large[STILB_INPUT_REPORT_MAX];
	stilb_input_recorder *recorder;
	stilb_input_event event = {.kind = STILB_INPUT_PAD_REPORT, .bytes = large, .size = sizeof large};
	memset(large, 0xee, sizeof large);
	made = made_added(1, 0, "large", 0);
	made.info.descriptor_size = STILB_INPUT_DESCRIPTOR_MAX;
	assert_int_equal(stilb_input_recorder_create("a.rec", &recorder), STILB_OK);
	record(recorder, &made);
	event.pad = 1;
	assert_int_equal(stilb_input_recorder_add(recorder, &event), STILB_OK);
	made.info.descriptor_size = 1;
	for (uint32_t pad = 2; pad <= 4096; pad++) {
		made.event.pad = pad;
		record(recorder, &made);
	}
	assert_int_equal(stilb_input_recorder_close(recorder), STILB_OK);
	stilb_input_recording *recording = load("a.rec");
	assert_true(stilb_input_recording_next(recording, 0, &event));
	assert_int_equal(event.info->descriptor_size, STILB_INPUT_DESCRIPTOR_MAX);
	assert_true(stilb_input_recording_next(recording, 0, &event));
	assert_int_equal(event.size, sizeof large);
	assert_memory_equal(event.bytes, large, sizeof large);
	stilb_input_recording_free(recording);

	recording = load("a.rec");
	assert_int_equal(stilb_input_recorder_create("b.rec", &recorder), STILB_OK);
	while (stilb_input_recording_next(recording, 0, &event))
		assert_int_equal(stilb_input_recorder_add(recorder, &event), STILB_OK);
	made.event.pad = 4097;
	made.event.info = &made.info;
	assert_int_equal(stilb_input_recorder_add(recorder, &made.event), STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), "4096"));
	assert_int_equal(stilb_input_recorder_close(recorder), STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), "'b.rec'"));
	assert_int_equal(access("b.rec", F_OK), -1);
	stilb_input_recording_free(recording);

	FILE *file = fopen("a.rec", "a");
	assert_non_null(file);
	fputs("D: 4096\n" PAD, file);
	fclose(file);
	assert_refused("a.rec", "there are more than 4096 pads");
	assert_int_equal(folder_clear(), 1);
}

/* ---- disks and memory -------------------------------------------------------------------------------------------- */

/* After a failed write the old file stays, and nothing is left beside it. */
static void test_full_disk(void **state)
{
	(void)state;
	static made_event made;
	struct rlimit before, small = {.rlim_cur = 20000};
	stilb_input_recorder *recorder;
	write_text("a.rec", golden, sizeof golden - 1);
	assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
	small.rlim_max = before.rlim_max;
	signal(SIGXFSZ, SIG_IGN);
	assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
	assert_int_equal(stilb_input_recorder_create("a.rec", &recorder), STILB_OK);
	made = made_added(1, 0, "Pad", 0);
	record(recorder, &made);
	int failures = 0;
	for (int i = 0; i < 1000; i++) {
		made = made_other(STILB_INPUT_PAD_REPORT, 1, i, 64);
		made.event.bytes = made.bytes;
		failures += stilb_input_recorder_add(recorder, &made.event) != STILB_OK;
	}
	assert_in_range(failures, 1, 999); /* reported at once, and for every event after it */
	assert_int_equal(stilb_input_recorder_close(recorder), STILB_ERROR_FILE);
	assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
	assert_non_null(strstr(stilb_error_message(), "cannot record to 'a.rec': File too large"));
	stilb_input_recording_free(load("a.rec"));
	assert_int_equal(folder_clear(), 1);

	assert_int_equal(stilb_input_recorder_create("/dev/full", &recorder), STILB_OK);
	assert_int_equal(stilb_input_recorder_close(recorder), STILB_ERROR_FILE);
	assert_int_equal(stilb_input_recorder_create("missing/a.rec", &recorder), STILB_ERROR_FILE);
	assert_null(recorder);
	assert_non_null(strstr(stilb_error_message(), "its folder does not exist"));
}

/* Whichever allocation fails, the message says so and nothing leaks. */
static void test_no_memory(void **state)
{
	(void)state;
	write_text("a.rec", foreign, sizeof foreign - 1);
	stilb_input_recorder *recorder;
	fail_allocation = 0;
	assert_int_equal(stilb_input_recorder_create("b.rec", &recorder), STILB_ERROR_MEMORY);
	fail_allocation = -1;
	int failed = 0;
	for (stilb_result result = STILB_ERROR_MEMORY; result != STILB_OK; failed++) {
		stilb_input_recording *recording;
		fail_allocation = failed;
		result = stilb_input_recording_load("a.rec", &recording);
		fail_allocation = -1;
		if (result == STILB_OK)
			stilb_input_recording_free(recording);
		else
			assert_int_equal(result, STILB_ERROR_MEMORY);
		assert_true(failed < 100);
	}
	assert_true(failed > 5);
	assert_int_equal(folder_clear(), 1);
}

/* ---- damaged files ----------------------------------------------------------------------------------------------- */

/* Checks that events are of pads that were added and not removed, and in time order. Returns their number. */
static size_t walk(stilb_input_recording *recording)
{
	size_t count = 0;
	int64_t last_us = 0;
	uint64_t reports = 0;
	stilb_input_event event;
	for (; stilb_input_recording_next(recording, INT64_MAX, &event); count++) {
		assert_true(event.time_us >= last_us);
		assert_true(event.kind == STILB_INPUT_PAD_ADDED ? event.info && true : !event.info);
		assert_true(event.kind == STILB_INPUT_PAD_REPORT ? event.bytes && true : !event.bytes);
		assert_true(event.pad > 0);
		if (event.info)
			assert_in_range(event.info->descriptor_size, 1, STILB_INPUT_DESCRIPTOR_MAX);
		if (event.bytes)
			assert_in_range(event.size, 1, STILB_INPUT_REPORT_MAX);
		reports += event.kind == STILB_INPUT_PAD_REPORT;
		last_us = event.time_us;
	}
	assert_int_equal(stilb_input_recording_end_us(recording), last_us);
	assert_true(reports > 0);
	return count;
}

/* Bytes replaced, removed and doubled at random: the file is refused, or its events can be written and read again. */
static void test_damaged(void **state)
{
	(void)state;
	static const char letters[] = "0123456789abcdefDRNPIE:#. \n\r\xff";
	int taken = 0;
	for (uint64_t seed = 1; seed <= 4000; seed++) {
		char text[2 * sizeof foreign];
		uint64_t random = seed;
		size_t length = sizeof foreign - 1;
		memcpy(text, foreign, length);
		for (uint64_t changes = next_random(&random) % 4 + 1; changes > 0; changes--) {
			size_t at = next_random(&random) % length, span = next_random(&random) % 8 % (length - at);
			switch (next_random(&random) % 3) {
			case 0:
				text[at] = letters[next_random(&random) % (sizeof letters - 1)];
				break;
			case 1:
				memmove(text + at, text + at + span, length - at - span);
				length -= span;
				break;
			default:
				memmove(text + at + span, text + at, length - at);
				length += span;
			}
		}
		FILE *stream = fmemopen(text, length, "r");
		stilb_input_recording *recording;
		assert_non_null(stream);
		if (input_recording_read(stream, "damaged", &recording) == STILB_OK) {
			taken++;
			size_t events = walk(recording);
			if (taken % 32 == 0) { /* not every time: writing a recording is slow, as it is synced to the disk */
				stilb_input_recording_free(recording);
				rewind(stream);
				assert_int_equal(input_recording_read(stream, "damaged", &recording), STILB_OK);
				record_again(recording, "a.rec");
				stilb_input_recording_free(recording);
				recording = load("a.rec");
				assert_int_equal(walk(recording), events);
			}
			stilb_input_recording_free(recording);
		} else {
			assert_null(recording);
			assert_non_null(strstr(stilb_error_message(), "cannot read 'damaged': "));
		}
		fclose(stream);
	}
	assert_in_range(taken, 100, 3900);
	folder_clear();
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(test_round_trip),       cmocka_unit_test(test_text),        cmocka_unit_test(test_until),
		cmocka_unit_test(test_nothing_recorded), cmocka_unit_test(test_foreign),     cmocka_unit_test(test_names),
		cmocka_unit_test(test_refusals),         cmocka_unit_test(test_line_length), cmocka_unit_test(test_limits),
		cmocka_unit_test(test_full_disk),        cmocka_unit_test(test_no_memory),   cmocka_unit_test(test_damaged),
		cmocka_unit_test(test_disorder),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_leave);
}
