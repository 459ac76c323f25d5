/* stilb replay --until, --show and --plan: frames with several cameras, ended with each of their passes in turn. With
 * the argument "null" only what needs no Vulkan. */
#include "support/stilb_program.h"

#include "image/image.h"

#define MOST_ROWS 32u
#define SIZE "--size 96x54 --shadows off " /* which are not in dumps */
#define INSET "view spheres --headless --quiet --inset 0,2,6,0,-10 " SIZE
#define CAMERAS "demo --headless --models 100 --cameras 3 " SIZE

/* With the address sanitizer every third pass. */
enum { ROW_STEP = TEST_ASAN ? 3 : 1 };

/* A pass of a plan, as its text has it. */
typedef struct row {
	char name[64];
	char image[64];   /* the first that it draws into */
	unsigned area[4]; /* left, top, width, height; width 0: all of its attachments */
} row;

/* Runs stilb replay with these words, which may hold blanks; ends with NULL. Returns the exit code. */
static int replay(const char *file, ...)
{
	const char *words[32] = {stilb_path, "replay", file, "--frames", "1"};
	size_t count = 5;
	va_list arguments;
	va_start(arguments, file);
	for (const char *word; (word = va_arg(arguments, const char *)) && count < 31;)
		words[count++] = word;
	va_end(arguments);
	assert_true(program_start(&run, words, no_display, -1));
	program_wait(&run);
	if (run.code != 0)
		print_message("stilb replay: %s", run.err);
	return run.code;
}

static char *read_text(const char *path)
{
	static char text[32768];
	FILE *file = fopen(path, "r");
	assert_non_null(file);
	size_t size = fread(text, 1, sizeof text - 1, file);
	assert_true(size > 0 && size < sizeof text - 1);
	text[size] = '\0';
	fclose(file);
	return text;
}

/* The passes of the text of a plan without left out ones; returns their number. */
static uint32_t read_rows(const char *path, row rows[MOST_ROWS])
{
	char *rest = NULL;
	uint32_t count = 0;
	for (char *line = strtok_r(read_text(path), "\n", &rest); line; line = strtok_r(NULL, "\n", &rest)) {
		unsigned number;
		char name[64];
		if (strcmp(line, "left out") == 0 || strcmp(line, "resources") == 0)
			break;
		if (sscanf(line, " %u %63[^,],", &number, name) == 2 && number == count + 1) {
			assert_true(count < MOST_ROWS);
			rows[count] = (row){0};
			strcpy(rows[count].name, name);
			const char *part = strstr(line, ", of it ");
			unsigned *area = rows[count].area;
			if (part)
				assert_int_equal(sscanf(part, ", of it %u x %u at %u, %u", &area[2], &area[3], &area[0], &area[1]), 4);
			count++;
		} else if (count > 0 && rows[count - 1].image[0] == '\0') {
			(void)(sscanf(line, "    draws into %63[^\n]", rows[count - 1].image) == 1 ||
			       sscanf(line, "    draws over %63[^\n]", rows[count - 1].image) == 1);
		}
	}
	return count;
}

/* The lines of passes of a plan's text, joined: "1 scene 2 tone map ". */
static void list_rows(const char *path, char *list, size_t size)
{
	row rows[MOST_ROWS];
	uint32_t count = read_rows(path, rows);
	list[0] = '\0';
	for (uint32_t i = 0; i < count; i++) {
		size_t used = strlen(list);
		snprintf(list + used, size - used, "%u %s>%s ", i + 1, rows[i].name, rows[i].image);
	}
}

/* ---- without pictures -------------------------------------------------------------------------------------------- */

/* The plans of both frames, whole and ended with each pass. */
static void test_plans(void **state)
{
	(void)state;
	static const char *const frames[] = {INSET, CAMERAS};
	for (int f = 0; f < 2; f++) {
		char wanted[1024], found[1024];
		stilb_good("%s --device null --frames 2 --dump a.dump --plan a.txt --stats a.json", frames[f]);
		uint64_t hash = stat_hash("a.json");
		list_rows("a.txt", wanted, sizeof wanted);
		assert_int_equal(replay("a.dump", "--device", "null", "--plan", "b.txt", "--stats", "b.json", NULL), 0);
		list_rows("b.txt", found, sizeof found);
		assert_string_equal(found, wanted); /* the frame's plan is the one that was dumped */
		assert_true(stat_hash("b.json") == hash);
		row rows[MOST_ROWS];
		uint32_t count = read_rows("b.txt", rows);
		assert_int_equal(count, 6);
		for (uint32_t i = 0; i < count; i += ROW_STEP) {
			char number[16], line[256];
			snprintf(number, sizeof number, "%u", i + 1);
			assert_int_equal(
				replay("a.dump", "--device", "null", "--until", number, "--plan", "b.txt", "--stats", "b.json", NULL),
				0);
			assert_true(stat_hash("b.json") == hash);
			assert_said(run.out, "as in the file");
			bool shown = strcmp(rows[i].image, "picture") == 0;
			snprintf(line, sizeof line, "picture 96 x 54, %u pass%s, ", i + 1 + !shown, i + 1 + !shown > 1 ? "es" : "");
			const char *text = read_text("b.txt");
			assert_said(text, line);
			snprintf(line, sizeof line, "%3u %.63s: the frame is cut after pass %u, %.63s\n", count,
			         rows[count - 1].name, i + 1, rows[i].name);
			assert_true((bool)strstr(text, line) == (i + 1 < count));
			snprintf(line, sizeof line, "%3u show, fullscreen, 96 x 54\n", count + 1);
			assert_true((bool)strstr(text, line) == !shown);
		}
	}
	assert_int_equal(replay("a.dump", "--device", "null", "--until", "camera 2", "--plan", "-", NULL), 0);
	assert_int_equal(strncmp(run.out, "picture 96 x 54, 3 passes", 25), 0); /* two scenes and what shows the image */
	assert_said(run.err, "frames end with the pass 'camera 2'");
	assert_int_equal(replay("a.dump", "--device", "null", "--until", "tone map", "--plan", "b.svg", NULL), 0);
	assert_int_equal(strncmp(read_text("b.svg"), "<svg", 4), 0);
	assert_int_equal(replay("a.dump", "--device", "null", "--until", "camera", NULL), 2);
	assert_said(run.err, "this frame has 1 scene, 2 camera 2, 3 camera 3, 4 tone map, 5 tone map, 6 tone map\n");
}

/* ---- with pictures ----------------------------------------------------------------------------------------------- */

static stilb_image load(const char *path)
{
	stilb_image image;
	assert_int_equal(stilb_image_load(path, &image), STILB_OK);
	assert_true(image.width == 96 && image.height == 54 && image.channels == 3);
	return image;
}

static bool same_picture(const char *path_a, const char *path_b)
{
	stilb_image a = load(path_a), b = load(path_b);
	bool same = memcmp(a.pixels, b.pixels, stilb_image_size(&a)) == 0;
	stilb_image_finish(&a);
	stilb_image_finish(&b);
	return same;
}

/* Different colours of a picture, counted up to 100. */
static uint32_t count_colors(const char *path)
{
	stilb_image image = load(path);
	const uint8_t *pixels = image.pixels;
	uint8_t colors[100][3];
	uint32_t count = 0;
	for (size_t p = 0; p < (size_t)96 * 54 && count < 100; p++) {
		uint32_t c = 0;
		while (c < count && memcmp(colors[c], pixels + 3 * p, 3) != 0)
			c++;
		if (c == count)
			memcpy(colors[count++], pixels + 3 * p, 3);
	}
	stilb_image_finish(&image);
	return count;
}

/* The picture of a frame that ends with a tone map is the whole one but in the places of later ones. */
static void check_tones(const row *later, uint32_t count)
{
	stilb_image whole = load("a.png"), got = load("b.png");
	uint32_t differ = 0;
	for (unsigned y = 0; y < 54; y++)
		for (unsigned x = 0; x < 96; x++) {
			bool open = false;
			for (uint32_t i = 0; i < count; i++)
				open |= x >= later[i].area[0] && x < later[i].area[0] + later[i].area[2] && y >= later[i].area[1] &&
				        y < later[i].area[1] + later[i].area[3];
			size_t at = 3 * ((size_t)y * 96 + x);
			bool same = memcmp((uint8_t *)whole.pixels + at, (uint8_t *)got.pixels + at, 3) == 0;
			assert_true(open || same);
			differ += !same;
		}
	assert_true((differ > 0) == (count > 0));
	stilb_image_finish(&whole);
	stilb_image_finish(&got);
}

/* Ends the frame of a.dump, whose picture is a.png, with each of its passes. What the last pass into an image leaves is
 * what the whole frame shows of it; a backdrop has no models. kinds: tone maps, last passes, backdrops. */
static void check_each_pass(uint32_t kinds[3])
{
	row rows[MOST_ROWS];
	assert_int_equal(replay("a.dump", "--plan", "a.txt", "--screenshot", "b.png", "--validate", NULL), 0);
	assert_true(same_picture("a.png", "b.png"));
	uint32_t count = read_rows("a.txt", rows);
	for (uint32_t i = 0; i < count; i += ROW_STEP) {
		char number[16];
		snprintf(number, sizeof number, "%u", i + 1);
		assert_int_equal(replay("a.dump", "--until", number, "--screenshot", "b.png", "--validate", NULL), 0);
		uint32_t later = i + 1;
		while (later < count && strcmp(rows[later].image, rows[i].image) != 0)
			later++;
		if (strcmp(rows[i].image, "picture") == 0) {
			assert_string_equal(rows[i].name, "tone map");
			check_tones(&rows[i + 1], count - i - 1);
			kinds[0]++;
		} else if (later == count) {
			assert_int_equal(replay("a.dump", "--show", rows[i].image, "--screenshot", "c.png", "--validate", NULL), 0);
			assert_true(same_picture("b.png", "c.png"));
			assert_true(count_colors("b.png") > 50);
			kinds[1]++;
		} else {
			assert_string_equal(rows[i].name, "backdrop");
			assert_in_range(count_colors("b.png"), 2, 4);
			kinds[2]++;
		}
	}
}

static void test_inset(void **state)
{
	(void)state;
	uint32_t kinds[3] = {0};
	stilb_good(INSET "--frames 2 --msaa 4 --dump a.dump --screenshot a.png");
	check_each_pass(kinds);
	assert_true(TEST_ASAN || (kinds[0] == 2 && kinds[1] == 4 && kinds[2] == 2));
	assert_int_equal(replay("a.dump", "--until", "tone map", "--screenshot", "b.png", NULL), 0);
	assert_true(same_picture("a.png", "b.png"));
}

static void test_cameras(void **state)
{
	(void)state;
	uint32_t kinds[3] = {0};
	stilb_good(CAMERAS "--frames 2 --msaa 1 --dump a.dump --screenshot a.png");
	check_each_pass(kinds);
	assert_true(TEST_ASAN || (kinds[0] == 3 && kinds[1] == 3 && kinds[2] == 0));
}

/* Images are shown as the program that made the dump shows them, whole or as soon as they are there. */
static void test_show(void **state)
{
	(void)state;
	stilb_good(INSET "--frames 2 --dump a.dump --screenshot a.png --show depth --show-range 0,0.2");
	stilb_good("replay a.dump --frames 1 --show depth --show-range 0,0.2 --screenshot b.png --validate");
	assert_true(same_picture("a.png", "b.png"));
	assert_true(count_colors("a.png") > 20);
	stilb_good("replay a.dump --frames 1 --until 2 --show depth --show-range 0,0.2 --screenshot b.png --validate");
	assert_true(same_picture("a.png", "b.png"));
	stilb_good("replay a.dump --frames 1 --show depth --screenshot b.png");
	assert_false(same_picture("a.png", "b.png")); /* another range */
	/* as radiance */
	stilb_good(INSET "--frames 2 --dump a.dump --screenshot a.exr");
	stilb_good("replay a.dump --frames 1 --screenshot b.exr --validate");
	assert_true(same_picture("a.exr", "b.exr"));
	stilb_good("replay a.dump --frames 1 --until 5 --screenshot b.exr --validate");
	assert_false(same_picture("a.exr", "b.exr")); /* the inset comes with the sixth pass */
}

#define FRESH_TEST(name) cmocka_unit_test_setup(name, folder_fresh)

int main(int argc, char **argv)
{
	const struct CMUnitTest null_tests[] = {FRESH_TEST(test_plans)};
	const struct CMUnitTest tests[] = {FRESH_TEST(test_inset), FRESH_TEST(test_cameras), FRESH_TEST(test_show)};
	bool null = argc == 3 && strcmp(argv[2], "null") == 0;
	if ((argc != 2 && !null) ||
	    !folder_enter(argv[1], null ? "test_game_replay_until_null" : "test_game_replay_until")) {
		fprintf(stderr, "usage: test_game_replay_until STILB [null]\n");
		return 1;
	}
	if (null)
		return cmocka_run_group_tests(null_tests, NULL, folder_leave);
	if (stilb_code(no_display, "demo --headless --validate --models 1 --size 8x8 --frames 1") != 0 &&
	    (strstr(run.err, "mesa-vulkan-drivers") || strstr(run.err, "vulkan-validationlayers"))) {
		folder_leave(NULL);
		printf("skipped: %s", run.err);
		return 77;
	}
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
