/* What is shown over the picture: the notice about gamepads that may not be opened, which names them and the udev rules
 * that would permit it, toasts, the key card, the line of main keys, and frame rate and time. */
#include "engine_internal.h"
#include "image/image.h"
#include "support/test.h"
#include "tests/engine/stress_engine.h"

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define WIDTH 700u
#define HEIGHT 440u

static stilb_engine *engine;
static uint32_t width = WIDTH, height = HEIGHT; /* of the picture, at most these */
static uint8_t plain[WIDTH * HEIGHT * 3];

static int set_up(void **state)
{
	(void)state;
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.workers = 0;
	desc.width = WIDTH;
	desc.height = HEIGHT;
	desc.validate = true;
	desc.hint = true;
	if (stress_engine_create(&desc, &(stress_engine){.models = 1, .seed = 1}, &engine) == STILB_OK)
		return 0;
	fprintf(stderr, "%s\n", stilb_error_message());
	return -1;
}

static int tear_down(void **state)
{
	(void)state;
	assert_int_equal(stilb_engine_validation_messages(engine), 0);
	stress_engine_destroy(engine);
	return 0;
}

static int no_notice(void **state)
{
	(void)state;
	engine->overlay.notice = (engine_notice){0};
	return 0;
}

static void draw(uint8_t *pixels)
{
	stilb_engine_report report;
	stilb_image image;
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	assert_int_equal(stilb_render_read_image(engine->render, &image), STILB_OK);
	assert_int_equal(stilb_image_size(&image), (size_t)width * height * image.channels);
	for (size_t i = 0; i < (size_t)width * height; i++)
		memcpy(pixels + 3 * i, (const uint8_t *)image.pixels + image.channels * i, 3);
	stilb_image_finish(&image);
}

/* The rows first .. end - 1 in which the picture differs from the one without the notice; first == end: none. */
static void changed(uint32_t rows[2])
{
	static uint8_t now[sizeof plain];
	rows[0] = rows[1] = 0;
	draw(now);
	for (uint32_t row = 0; row < height; row++)
		if (memcmp(now + (size_t)row * width * 3, plain + (size_t)row * width * 3, (size_t)width * 3) != 0) {
			rows[0] = rows[1] == 0 ? row : rows[0];
			rows[1] = row + 1;
		}
}

static void deny(uint32_t pad, const char *path, const char *name, uint16_t vendor)
{
	stilb_input_pad_info info = {.bus = STILB_INPUT_BUS_USB, .vendor = vendor, .product = 0x05c4};
	snprintf(info.path, sizeof info.path, "%s", path);
	snprintf(info.name, sizeof info.name, "%s", name);
	engine_overlay_deny(engine, pad, &info);
}

static void it_comes_and_goes(void **state)
{
	(void)state;
	uint32_t one[2], two[2], none[2];
	draw(plain);
	deny(1, "/dev/hidraw3", "Sony Interactive Entertainment Wireless Controller", 0x054c);
	changed(one);
	assert_true(one[0] > 0 && one[1] > one[0] + 80 && one[1] < 220); /* at the top, and as high as its text needs */
	deny(2, "/dev/hidraw4", "", 0x057e);
	deny(2, "/dev/hidraw4", "", 0x057e); /* the same pad again is not added a second time */
	assert_int_equal(engine->overlay.notice.pad_count, 2);
	changed(two);
	assert_true(two[1] > one[1] + 20); /* another pad with another rule */
	engine_notice_remove(&engine->overlay.notice, 1);
	changed(two);
	engine_notice_remove(&engine->overlay.notice, 7); /* not in the notice */
	assert_true(two[0] == one[0] && two[1] > two[0] + 80);
	engine_notice_remove(&engine->overlay.notice, 2);
	changed(none);
	assert_int_equal(none[1], 0);
}

/* Pads with the same vendor and product need the same udev rule, which is shown once. */
static void equal_rules_are_said_once(void **state)
{
	(void)state;
	uint32_t one[2], two[2];
	draw(plain);
	deny(1, "/dev/hidraw3", "Pad", 0x054c);
	changed(one);
	deny(2, "/dev/hidraw4", "Pad", 0x054c);
	changed(two);
	assert_true(two[1] > one[1] && two[1] < one[1] + 20); /* one line more */
}

static void it_goes_by_itself(void **state)
{
	(void)state;
	uint32_t rows[2];
	int frames = 0;
	draw(plain);
	deny(1, "/dev/hidraw3", "Pad", 0x054c);
	engine->overlay.input.seconds = 8.0f; /* seconds that each frame takes */
	do {
		changed(rows);
		frames++;
	} while (rows[1] > 0 && frames < 100);
	assert_in_range(frames, 3, 8);
	assert_int_equal(engine->overlay.notice.pad_count, 0);
	engine->overlay.input.seconds = 0.0f;
}

static void resize(uint32_t to_width, uint32_t to_height)
{
	width = to_width;
	height = to_height;
	assert_int_equal(stilb_engine_resize(engine, width, height), STILB_OK);
}

/* The log says the same as the notice, in lines of limited length. */
static void it_is_logged(void **state)
{
	(void)state;
	static const char *const words[] = {"/dev/hidraw3: Wireless Controller", ENGINE_NOTICE_FILE,
	                                    "udevadm control --reload", "TAG+=\"uaccess\""};
	char line[512];
	bool said[4] = {false};
	FILE *log = tmpfile();
	int terminal = dup(STDERR_FILENO);
	assert_true(log && terminal >= 0 && dup2(fileno(log), STDERR_FILENO) >= 0);
	deny(1, "/dev/hidraw3", "Wireless Controller", 0x054c);
	assert_true(dup2(terminal, STDERR_FILENO) >= 0);
	close(terminal);
	rewind(log);
	while (fgets(line, sizeof line, log)) {
		assert_in_range(strlen(line), 1, 110);
		for (int i = 0; i < 4; i++)
			said[i] = said[i] || strstr(line, words[i]);
	}
	fclose(log);
	for (int i = 0; i < 4; i++)
		assert_true(said[i]);
}

/* If the notice with its rules would not fit the picture, it refers to the terminal for them, and then fits. */
static void half_a_rule_is_not_shown(void **state)
{
	(void)state;
	uint32_t rows[2];
	resize(320, 400);
	draw(plain);
	deny(1, "/dev/hidraw3", "Wireless Controller", 0x054c);
	changed(rows);
	assert_in_range(rows[1], 200, 300); /* a narrow picture: more lines */
	no_notice(NULL);
	resize(320, 180);
	draw(plain);
	deny(1, "/dev/hidraw3", "Wireless Controller", 0x054c);
	changed(rows);
	assert_in_range(rows[1], 80, 170);
	no_notice(NULL);
	resize(WIDTH, HEIGHT);
}

static void more_than_there_is_room_for(void **state)
{
	(void)state;
	uint32_t rows[2];
	char endless[128];
	memset(endless, 'w', sizeof endless);
	endless[127] = '\0';
	draw(plain);
	for (uint32_t pad = 1; pad <= 9; pad++)
		deny(pad, "/dev/hidraw63", endless, (uint16_t)(0x1000 + pad));
	assert_int_equal(engine->overlay.notice.pad_count, ENGINE_NOTICE_PADS);
	assert_int_equal(engine->overlay.notice.pads[ENGINE_NOTICE_PADS - 1].pad, 9); /* the newest ones are kept */
	changed(rows);
	assert_true(rows[1] > rows[0]);
	static const uint32_t sizes[][2] = {{1, 1}, {40, 30}, {160, 400}, {WIDTH, HEIGHT}};
	for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
		stilb_engine_report report;
		assert_int_equal(stilb_engine_resize(engine, sizes[i][0], sizes[i][1]), STILB_OK);
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	}
}

/* Toasts are at the lower edge, the newest three; the frame of a saved picture has none, and each goes by itself. */
static void toasts_come_and_go(void **state)
{
	(void)state;
	uint32_t one[2], rows[2];
	draw(plain);
	engine_overlay_tell(engine, "a.png written");
	changed(one);
	assert_in_range(one[0], HEIGHT - 60, HEIGHT - 30);
	assert_in_range(one[1], HEIGHT - 20, HEIGHT - 12);
	for (int i = 0; i < 4; i++)
		engine_overlay_tell(engine, "another one");
	changed(rows);
	assert_true(rows[1] == one[1] && rows[0] < one[0] - 2 * (one[1] - one[0]));
	assert_int_equal(engine->overlay.toasts.count, ENGINE_TOASTS);
	engine_overlay_act(engine, &(stilb_input_state){.actions = {[STILB_ENGINE_PICTURE] = 1}});
	assert_false(engine_overlay_is_open(&engine->overlay));
	engine->overlay.toasts.hidden = false;
	engine->overlay.input.seconds = 2.0f; /* seconds that each frame takes */
	int frames = 0;
	for (rows[1] = 1; rows[1] > 0 && frames < 100; frames++)
		changed(rows);
	assert_in_range(frames, 3, 5);
	assert_int_equal(engine->overlay.toasts.count, 0);
	engine->overlay.input.seconds = 0.0f;
	engine_overlay_tell(engine,
	                    "a line that is much longer than the picture is wide, so that it goes on in a second "
	                    "one: a-name-that-is-as-long-as-names-of-files-can-be-in-folders-of-others.png written");
	changed(rows);
	assert_in_range(rows[1] - rows[0], one[1] - one[0] + 12, one[1] - one[0] + 20);
	engine->overlay.toasts.count = 0;
}

static void ask(uint32_t action)
{
	stilb_input_state input = {0};
	input.actions[action] = 1;
	engine_overlay_act(engine, &input);
}

/* The card takes the height that its lines need, within the picture; one that does not fit scrolls. */
static void the_card_lists_the_table(void **state)
{
	(void)state;
	uint32_t rows[2], lines = 0;
	stilb_input_help line;
	for (uint32_t next = 0; stilb_input_help_next(&engine->actions, &next, &line);)
		lines++;
	draw(plain);
	changed(rows);
	assert_int_equal(rows[1], 0);
	ask(STILB_ENGINE_KEYS);
	changed(rows);
	assert_in_range(rows[1] - rows[0], lines * 18 + 40, lines * 18 + 120);
	assert_true(rows[0] > 0 && rows[1] < height);
	assert_true(engine->overlay.keys.list.scroll == 0.0f);
	ask(STILB_ENGINE_KEYS);
	changed(rows);
	assert_int_equal(rows[1], 0);
	resize(320, 120);
	ask(STILB_ENGINE_KEYS);
	draw(plain);
	engine->overlay.input.mouse_present = true;
	engine->overlay.input.mouse_x = 160.0f;
	engine->overlay.input.mouse_y = 90.0f;
	engine->overlay.input.wheel = -1.0f;
	changed(rows);
	changed(rows);
	assert_true(engine->overlay.keys.list.scroll > 0.0f && rows[1] > rows[0]);
	engine->overlay.input = (stilb_ui_input){0};
	ask(STILB_ENGINE_KEYS);
	resize(WIDTH, HEIGHT);
}

/* The line is at the lower edge, toasts are above it; it goes by itself, is not in a saved picture, and panels hide
 * it. */
static void the_first_line_goes(void **state)
{
	(void)state;
	uint32_t line[2], rows[2];
	draw(plain);
	assert_true(engine->overlay.keys.hint_seconds == 0.0f); /* asked for, but there is no window */
	engine->overlay.keys.hint_seconds = 10.0f;
	changed(line);
	assert_in_range(line[0], HEIGHT - 45, HEIGHT - 35);
	assert_in_range(line[1], HEIGHT - 20, HEIGHT - 12);
	engine_overlay_tell(engine, "a.png written");
	changed(rows);
	assert_true(rows[0] < line[0] - 20 && rows[1] == line[1]);
	engine->overlay.toasts.count = 0;
	ask(STILB_ENGINE_PICTURE);
	assert_false(engine_overlay_is_open(&engine->overlay));
	engine->overlay.toasts.hidden = false;
	ask(STILB_ENGINE_KEYS);
	float left = engine->overlay.keys.hint_seconds;
	engine->overlay.keys.hint_seconds = 0.0f;
	draw(plain);
	engine->overlay.keys.hint_seconds = left;
	changed(rows);
	assert_int_equal(rows[1], 0);
	ask(STILB_ENGINE_KEYS);
	engine->overlay.keys.hint_seconds = 0.0f;
	draw(plain);
	engine->overlay.keys.hint_seconds = 10.0f;
	engine->overlay.input.seconds = 3.0f;
	int frames = 0;
	for (rows[1] = 1; rows[1] > 0 && frames < 100; frames++)
		changed(rows);
	assert_int_equal(frames, 5); /* four of three seconds each, and one without it */
	engine->overlay.input.seconds = 0.0f;
}

/* Rate and time are those of the last half second, in the corner, unless a panel covers it or the picture is saved. */
static void rate_and_time_are_measured(void **state)
{
	(void)state;
	engine_rate rate = {0};
	uint64_t now = 1000000000;
	uint32_t rows[2];
	engine_rate_add(&rate, now, 500.0); /* the first frame is left out */
	for (int i = 1; i <= 50; i++)
		engine_rate_add(&rate, now += 20000000, i == 30 ? 16.0 : 8.0);
	assert_float_equal(rate.rate, 50.0f, 1e-3f);
	assert_float_equal(rate.ms, 8.32f, 1e-3f); /* of the second half: 24 of 8 ms, and the one of 16 */
	assert_float_equal(rate.longest, 16.0f, 0.0f);
	for (int i = 1; i <= 24; i++)
		engine_rate_add(&rate, now += 20000000, 4.0);
	assert_float_equal(rate.longest, 16.0f, 0.0f); /* stays readable */
	engine_rate_add(&rate, now += 20000000, 4.0);
	assert_true(rate.longest == 4.0f && rate.ms == 4.0f);
	draw(plain);
	ask(STILB_ENGINE_TIMES);
	changed(rows);
	assert_true(rows[0] < 12 && rows[1] < 40 && rows[1] > 20);
	ask(STILB_ENGINE_PICTURE);
	assert_false(engine_overlay_is_open(&engine->overlay));
	engine->overlay.toasts.hidden = false;
	resize(WIDTH, 120); /* the card is as high as the picture */
	engine->overlay.rate.open = false;
	ask(STILB_ENGINE_KEYS);
	changed(rows);
	draw(plain);
	engine->overlay.rate.open = true;
	changed(rows);
	assert_int_equal(rows[1], 0);
	ask(STILB_ENGINE_KEYS);
	ask(STILB_ENGINE_TIMES);
	assert_false(engine->overlay.rate.open || engine->overlay.keys.open);
	resize(WIDTH, HEIGHT);
}

/* Writes the pictures to a folder, if one is given, for looking at them. */
static void save_pictures(const char *folder)
{
	char path[256];
	stilb_engine_report report;
	assert_int_equal(set_up(NULL), 0);
	deny(1, "/dev/hidraw3", "Sony Interactive Entertainment Wireless Controller", 0x054c);
	for (int pads = 1; pads <= 2; pads++) {
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
		snprintf(path, sizeof path, "%s/notice-%d.png", folder, pads);
		assert_int_equal(stilb_engine_screenshot(engine, path), STILB_OK);
		deny(2, "/dev/hidraw4", "Xbox Wireless Controller", 0x045e);
	}
	assert_int_equal(stilb_engine_resize(engine, 300, 400), STILB_OK);
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	snprintf(path, sizeof path, "%s/notice-narrow.png", folder);
	assert_int_equal(stilb_engine_screenshot(engine, path), STILB_OK);
	assert_int_equal(stilb_engine_resize(engine, 320, 180), STILB_OK);
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	snprintf(path, sizeof path, "%s/notice-low.png", folder);
	assert_int_equal(stilb_engine_screenshot(engine, path), STILB_OK);
	no_notice(NULL);
	engine_overlay_tell(engine, "stilb-demo.png written");
	engine_overlay_tell(engine, "stilb-capture-2.json written");
	static const uint32_t sizes[][2] = {{1280, 720}, {640, 400}};
	for (uint32_t i = 0; i < 4; i++) {
		assert_int_equal(stilb_engine_resize(engine, sizes[i % 2][0], sizes[i % 2][1]), STILB_OK);
		assert_int_equal(engine_overlay_open(engine, i > 1, i > 1), STILB_OK);
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
		snprintf(path, sizeof path, "%s/toasts-%u.png", folder, i);
		assert_int_equal(stilb_engine_screenshot(engine, path), STILB_OK);
	}
	tear_down(NULL);
}

#define TEST(name) cmocka_unit_test_setup(name, no_notice)

int main(int argc, char **argv)
{
	if (argc == 2) {
		save_pictures(argv[1]);
		return 0;
	}
	const struct CMUnitTest tests[] = {
		TEST(it_comes_and_goes),           TEST(equal_rules_are_said_once),
		TEST(it_goes_by_itself),           TEST(it_is_logged),
		TEST(half_a_rule_is_not_shown),    TEST(toasts_come_and_go),
		TEST(more_than_there_is_room_for), TEST(the_card_lists_the_table),
		TEST(the_first_line_goes),         TEST(rate_and_time_are_measured),
	};
	return cmocka_run_group_tests(tests, set_up, tear_down);
}
