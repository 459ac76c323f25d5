/* stilb demo on a Vulkan device: any number of workers gives the same picture and the same draws. */
#include "image/image.h"
#include "support/stilb_program.h"

#include <math.h>

#define SMALL "demo --headless --models 400 --size 320x180 --frames 4 "
#define LARGE "demo --headless --models 100 --size 640x600 --frames 4 "

static stilb_image picture;

static int picture_fresh(void **state)
{
	stilb_image_finish(&picture);
	return folder_fresh(state);
}

static void read_picture(const char *path)
{
	stilb_image_finish(&picture);
	assert_int_equal(stilb_image_load(path, &picture), STILB_OK);
}

/* True if the picture that was read last and this one have the same pixels. */
static bool same_picture(const char *path)
{
	stilb_image other;
	assert_int_equal(stilb_image_load(path, &other), STILB_OK);
	bool same = other.width == picture.width && other.height == picture.height && other.format == picture.format &&
	            other.channels == picture.channels &&
	            memcmp(other.pixels, picture.pixels, stilb_image_size(&picture)) == 0;
	stilb_image_finish(&other);
	return same;
}

/* Counts the colours in the picture that was read last, at 5 bits a channel; a picture of the background alone has
 * one. */
static int colours(void)
{
	static uint8_t seen[32768];
	const uint8_t *pixels = picture.pixels;
	int count = 0;
	memset(seen, 0, sizeof seen);
	assert_int_equal(picture.format, STILB_IMAGE_U8_SRGB);
	for (size_t i = 0; i + picture.channels <= stilb_image_size(&picture); i += picture.channels) {
		size_t class = (size_t)(pixels[i] >> 3) << 10 | (size_t)(pixels[i + 1] >> 3) << 5 | pixels[i + 2] >> 3;
		count += !seen[class];
		seen[class] = 1;
	}
	return count;
}

/* ---- the same from any number of workers ------------------------------------------------------------------------- */

static const char *const ways[] = {"--workers 0",
                                   "--workers 0", /* again: two equal runs */
                                   "--workers 1",
                                   "--workers 2",
                                   "--workers 3",
                                   "--workers 8",
                                   "--workers 8",
                                   "--workers 0 --replay direct",
                                   "--workers 2 --replay direct --cull flat",
                                   "--workers 2 --cull flat",
                                   "--workers 2 --cull octree",
                                   "--workers 3 --validate"};
#define WAYS (sizeof ways / sizeof *ways)

/* With the address sanitizer, which sees no more in another way or name, every third way and sixth name is run, every
 * second change of flags and route, and the windows of the profiler and of materials in a few ways. */
enum {
	WAY_STEP = TEST_ASAN ? 3 : 1,
	NAME_STEP = TEST_ASAN ? 6 : 1,
	FLAG_STEP = TEST_ASAN ? 2 : 1,
	WINDOW_STEP = TEST_ASAN ? 5 : 1
};

static uint64_t null_hash(const char *what)
{
	stilb_good(SMALL "--device null %s --stats null.json", what);
	return stat_hash("null.json");
}

static void same_for_all_ways(const char *what, size_t first, size_t step)
{
	uint64_t expected = null_hash(what);
	for (size_t i = first; i < WAYS; i += step * WAY_STEP) {
		stilb_good(SMALL "%s %s --screenshot %s --stats a.json", ways[i], what, i == first ? "first.png" : "other.png");
		assert_true(stat_hash("a.json") == expected);
		if (i == first)
			read_picture("first.png");
		else
			assert_true(same_picture("other.png"));
	}
	assert_int_equal(picture.width, 320);
	assert_int_equal(picture.height, 180);
	assert_true(colours() > 100);
}

static void test_same_picture_and_draws(void **state)
{
	(void)state;
	same_for_all_ways("", 0, 1);
	assert_int_equal(folder_entries(), 4);
}

static void test_same_picture_and_draws_while_models_move(void **state)
{
	(void)state;
	same_for_all_ways("--animate", 0, 2);
	stilb_good(SMALL "--screenshot still.png --stats a.json");
	assert_false(same_picture("still.png"));
	assert_true(stat_hash("a.json") != null_hash("--animate"));
}

static void test_same_picture_and_draws_with_samples(void **state)
{
	(void)state;
	same_for_all_ways("--msaa 4 --view half --seed 18446744073709551615", 1, 3);
	stilb_good(SMALL "--msaa 1 --view half --seed 18446744073709551615 --screenshot one.png");
	assert_false(same_picture("one.png"));
}

static void test_same_picture_and_draws_of_several_cameras(void **state)
{
	(void)state;
	same_for_all_ways("--cameras 3 --render-scale 0.7", 2, 3);
	stilb_good(SMALL "--cameras 3 --screenshot fine.png");
	assert_false(same_picture("fine.png"));
}

/* ---- flags that change the picture ------------------------------------------------------------------------------- */

static void test_flags_change_the_picture(void **state)
{
	(void)state;
	static const char *const changes[] = {"--seed 2", "--view half", "--view few",         "--models 100",
	                                      "--msaa 4", "--cameras 2", "--render-scale 0.5", "--shadows off"};
	stilb_good(SMALL "--screenshot first.png");
	read_picture("first.png");
	for (size_t i = 0; i < sizeof changes / sizeof *changes; i += FLAG_STEP) {
		stilb_good(SMALL "--screenshot other.png %s", changes[i]);
		assert_false(same_picture("other.png"));
	}
	stilb_good(SMALL
	           "--screenshot other.png --msaa 1 --seed 1 --view all --gpu 0 --no-present --frames 9 --shadows map");
	assert_true(same_picture("other.png")); /* nothing moves, and a software device takes one sample a pixel */
	stilb_good("demo --headless --models 1 --size 1x1 --frames 1 --screenshot tiny.PNG");
	read_picture("tiny.PNG");
	assert_int_equal(picture.width * picture.height, 1);
}

/* ---- formulas and lights ----------------------------------------------------------------------------------------- */

#define SHADED "demo --headless --models 100 --size 200x150 --frames 2 "

/* Each reflection model, light or added number gives another picture, and --stats names it. */
static void test_each_name_is_another_picture(void **state)
{
	(void)state;
	static const char *const names[] = {
		"",
		"--brdf lambert",
		"--brdf wrapped",
		"--brdf phong",
		"--brdf phong-modified",
		"--brdf blinn-phong",
		"--brdf minimalist",
		"--brdf microfacet",
		"--ndf ggx-anisotropic",
		"--ndf beckmann",
		"--ndf blinn",
		"--g implicit",
		"--g cook-torrance",
		"--f none",
		"--brdf microfacet --ndf beckmann --g kelemen --f cook-torrance",
		"--roughness 0.3",
		"--roughness -0.3",
		"--wrap 0.5",
		"--specular -0.1",
		"--ndf ggx-anisotropic --anisotropy -0.6",
		"--light-model hemisphere",
		"--light-model sphere",
		"--light-model disk",
		"--light-model windowed",
		"--light-model subtracted",
	};
	enum { NAMES = sizeof names / sizeof *names };
	stilb_image pictures[NAMES];
	uint64_t hashes[NAMES];
	for (size_t i = 0; i < NAMES; i += NAME_STEP) {
		stilb_good(SHADED "%s --screenshot a.png --stats a.json --validate", names[i]);
		hashes[i] = stat_hash("a.json");
		assert_int_equal(stilb_image_load("a.png", &pictures[i]), STILB_OK);
		for (size_t k = 0; k < i; k += NAME_STEP) {
			assert_true(hashes[k] != hashes[i]);
			assert_memory_not_equal(pictures[k].pixels, pictures[i].pixels, stilb_image_size(&pictures[i]));
		}
	}
	assert_string_equal(stat_text("light_model", '"'), "subtracted");
	assert_string_equal(stat_text("brdf", '"'), "blinn-phong-modified");
	for (size_t i = 0; i < NAMES; i += NAME_STEP)
		stilb_image_finish(&pictures[i]);
}

/* --stats has the numbers that are added to all materials; a number that a flag gives replaces the default of the
 * chosen model. */
static void test_numbers_added_to_materials(void **state)
{
	(void)state;
	stilb_good(SHADED "--brdf lambert --screenshot first.png --stats a.json");
	read_stats("a.json");
	assert_string_equal(stat_text("added.wrap", '0'), "0.000000");
	read_picture("first.png");
	stilb_good(SHADED "--brdf wrapped --wrap 0 --screenshot other.png");
	assert_true(same_picture("other.png"));
	stilb_good(SHADED "--brdf wrapped --screenshot first.png --stats a.json");
	read_stats("a.json");
	assert_string_equal(stat_text("added.wrap", '0'), "0.500000");
	read_picture("first.png");
	stilb_good(SHADED "--brdf wrapped --wrap=.5 --screenshot other.png");
	assert_true(same_picture("other.png"));
	stilb_good(SHADED "--brdf microfacet --screenshot first.png");
	read_picture("first.png");
	stilb_good(SHADED "--ndf ggx-anisotropic --anisotropy 0 --screenshot other.png");
	assert_true(same_picture("other.png")); /* an anisotropy of 0 is isotropic GGX, to 8 bits a channel */
	stilb_good(SHADED "--ndf ggx-anisotropic --roughness -0.25 --specular +1 --stats a.json");
	read_stats("a.json");
	assert_string_equal(stat_text("added.roughness", '0'), "-0.250000");
	assert_string_equal(stat_text("added.anisotropy", '0'), "0.600000");
	assert_string_equal(stat_text("added.specular", '0'), "1.000000");
}

static void test_the_same_formulas_in_every_way(void **state)
{
	(void)state;
	static const char *const routes[] = {
		"--replay direct --workers 2",
		"--replay secondary --workers 2",
		"--replay secondary --materials bind",
		"--replay direct --materials pipeline",
		"--replay indirect --materials pipeline --workers 3",
		"--brdf microfacet --g=schlick_ggx", /* '_' is accepted for '-' */
	};
	stilb_good(SHADED
	           "--ndf ggx-anisotropic --g schlick-ggx --light-model sphere --screenshot first.png --stats a.json");
	uint64_t hash = stat_hash("a.json");
	assert_string_equal(stat_text("brdf", '"'), "microfacet");
	assert_string_equal(stat_text("ndf", '"'), "ggx-anisotropic");
	assert_string_equal(stat_text("g", '"'), "schlick-ggx");
	assert_string_equal(stat_text("f", '"'), "schlick");
	read_picture("first.png");
	for (size_t i = 0; i < sizeof routes / sizeof *routes; i += FLAG_STEP) {
		stilb_good(SHADED
		           "--ndf ggx-anisotropic --g schlick-ggx --light-model sphere --screenshot other.png --stats a.json "
		           "--validate %s",
		           routes[i]);
		assert_true(stat_hash("a.json") == hash);
		assert_true(same_picture("other.png"));
	}
}

static void test_linear_picture(void **state)
{
	(void)state;
	stilb_good(SMALL "--screenshot a.exr");
	read_picture("a.exr");
	assert_int_equal(picture.format, STILB_IMAGE_F32_LINEAR);
	assert_int_equal(picture.width, 320);
	const float *pixels = picture.pixels;
	float most = 0.0f, least = INFINITY;
	for (size_t i = 0; i < stilb_image_size(&picture) / sizeof(float); i++) {
		assert_true(isfinite(pixels[i]) && pixels[i] >= 0.0f);
		most = fmaxf(most, pixels[i]);
		least = fminf(least, pixels[i]);
	}
	assert_true(most > 0.3f && least < most / 4.0f);
}

/* Counts the rows of pixels from the top that are equal in the picture that was read last and this one. */
static uint32_t same_rows(const char *path)
{
	stilb_image other;
	assert_int_equal(stilb_image_load(path, &other), STILB_OK);
	assert_int_equal(stilb_image_size(&other), stilb_image_size(&picture));
	size_t row = stilb_image_size(&picture) / picture.height;
	uint32_t same = 0;
	while (same < picture.height &&
	       memcmp((uint8_t *)other.pixels + same * row, (uint8_t *)picture.pixels + same * row, row) == 0)
		same++;
	stilb_image_finish(&other);
	return same;
}

/* The profiler's window covers the lower part of the picture in every mode of replay, and does not change the draws. */
static void test_overlay(void **state)
{
	(void)state;
	static const char *const drawn[] = {"--replay indirect --workers 2",
	                                    "--replay direct",
	                                    "--replay secondary",
	                                    "--msaa 4",
	                                    "--ui-aa off",
	                                    "--ui-aa article"};
	for (size_t i = 0; i < sizeof drawn / sizeof *drawn; i += WINDOW_STEP) {
		stilb_good(LARGE "%s --screenshot plain.png --stats a.json", drawn[i]);
		uint64_t hash = stat_hash("a.json");
		read_picture("plain.png");
		stilb_good(LARGE "%s --overlay --validate --screenshot over.png --stats a.json --trace t.json", drawn[i]);
		assert_true(stat_hash("a.json") == hash);
		assert_true(stat_ms("stages.ui.median") > 0.0);
		assert_in_range(same_rows("over.png"), 20, 580);
		read_picture("over.png");
		assert_true(colours() > 100);
		trace_check_report report;
		trace_check_file("t.json", &report);
		assert_string_equal(report.error, "");
		assert_int_equal(trace_check_zones(&report, "main", "ui build"), 4);
		assert_true(trace_check_zones(&report, "GPU", "overlay") >= 1);
		assert_true(trace_check_zones(&report, "GPU", "scene") >= 1);
		trace_check_finish(&report);
	}
	stilb_good(
		"demo --headless --models 1 --size 1x1 --frames 2 --overlay --inspector --validate --screenshot tiny.png");
	stilb_good("demo --headless --models 1 --size 200x100 --frames 2 --overlay --no-profile --validate");
}

/* The window of materials covers the right side of the picture, alone and beside the profiler's. */
static void test_inspector(void **state)
{
	(void)state;
	stilb_good(LARGE "--size 960x640 --screenshot plain.png --stats a.json");
	uint64_t hash = stat_hash("a.json");
	read_picture("plain.png");
	static const char *const drawn[] = {"--replay secondary --workers 2", "--overlay", ""};
	for (size_t i = 0; i < sizeof drawn / sizeof *drawn; i += WINDOW_STEP) {
		stilb_good(LARGE "--size 960x640 %s --inspector --validate --screenshot over.png --stats a.json", drawn[i]);
		assert_true(stat_hash("a.json") == hash);
		assert_in_range(same_rows("over.png"), 1, 40);
	}
}

/* stilb trace show: another frame gives another picture, the same frame the same one. */
static void test_show_of_a_trace(void **state)
{
	(void)state;
	stilb_good("demo --headless --device null --models 400 --frames 20 --workers 2 --trace t.json");
	stilb_good("trace show t.json --frame 7 --size 640x360 --screenshot seven.png");
	assert_string_equal(run.out, "picture: seven.png\n");
	read_picture("seven.png");
	assert_int_equal(picture.width, 640);
	assert_int_equal(picture.height, 360);
	assert_true(colours() > 100);
	stilb_good("trace show t.json --frame 7 --size 640x360 --screenshot again.png");
	assert_true(same_picture("again.png"));
	stilb_good("trace show t.json --frame 8 --size 640x360 --screenshot eight.png");
	assert_false(same_picture("eight.png"));
	stilb_good("trace show t.json --size 1x1 --screenshot tiny.png");
	assert_int_equal(stilb_code(no_display, "trace show t.json"), 2);
	assert_error_lines(1);
	assert_said(run.err, "give --screenshot FILE, which needs no window");
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

static void test_stats_and_trace(void **state)
{
	(void)state;
	static const char *const replays[] = {"indirect", "direct"};
	for (int i = 0; i < 2; i++) {
		stilb_good(SMALL "--workers 2 --validate --replay %s --stats a.json --trace t.json", replays[i]);
		assert_said(run.out, "bound by: ");
		read_stats("a.json");
		assert_stats("vulkan", replays[i], "auto", 400, 2, 4);
		assert_int_equal(stat_int("visible"), 400);
		assert_stages(true);
		assert_jobs();
		assert_trace("t.json", 2, 4);
	}
	stilb_good(SMALL "--no-present --validate --stats a.json");
	read_stats("a.json");
	assert_stages(false);
	assert_int_equal(folder_entries(), 2);
}

static void test_full_disk(void **state)
{
	(void)state;
	assert_int_equal(symlink("/dev/full", "full.png"), 0);
	assert_int_equal(symlink("/dev/full", "full.exr"), 0);
	assert_int_equal(stilb_code(no_display, SMALL "--screenshot full.png"), 1);
	assert_error_lines(1);
	assert_said(run.err, "'full.png'");
	assert_int_equal(stilb_code(no_display, SMALL "--screenshot full.exr --stats /dev/full --trace /dev/full"), 1);
	assert_error_lines(3);
	assert_int_equal(stilb_code(no_display, SMALL "--screenshot full.png --stats a.json --trace t.json"), 1);
	assert_error_lines(1);
	read_stats("a.json");
	assert_int_equal(folder_entries(), 4);
}

/* ---- surroundings ------------------------------------------------------------------------------------------------ */

static void test_without_a_display(void **state)
{
	(void)state;
	assert_int_equal(stilb_code(no_display, "demo --models 100 --size 64x64 --stats a.json"), 0);
	assert_error_lines(1);
	assert_said(run.err, "headless");
	read_stats("a.json");
	assert_int_equal(stat_int("frames"), 30);
	const char *const broken[] = {"DISPLAY=:987654", "WAYLAND_DISPLAY", NULL};
	assert_int_equal(stilb_code(broken, "demo --models 100 --size 64x64 --frames 2"), 0);
	assert_error_lines(1);
	assert_said(run.err, "headless");
}

static void test_choice_of_a_gpu(void **state)
{
	(void)state;
	stilb_good("info --json info.json");
	read_stats("info.json");
	char name[256];
	snprintf(name, sizeof name, "%.*s", (int)strcspn(stat_text("gpus[0].name", '"'), " "),
	         stat_text("gpus[0].name", '"'));
	stilb_good(SMALL "--gpu %s --stats a.json", name);
	read_stats("a.json");
	assert_said(stat_text("device_name", '"'), name);
	stilb_good(SMALL "--gpu 0");
	const char *bits = strstr(stat_text("device_name", '"'), " bits)"); /* "llvmpipe (LLVM 15.0.6, 256 bits)" */
	assert_non_null(bits);
	stilb_good(SMALL "--gpu %.3s", bits - 3); /* 256 is no number of a GPU here, so it must be a part of its name */
	static const char *const none[] = {"31", "99", "nosuch", "-1", "0x0", "99999999999999999999"};
	for (size_t i = 0; i < sizeof none / sizeof *none; i++) {
		char line[256];
		snprintf(line, sizeof line, SMALL "--gpu %s", none[i]);
		assert_int_equal(stilb_code(no_display, line), 2);
		assert_error_lines(1);
		assert_said(run.err, none[i]);
	}
}

static void test_interrupt_ends_it_well(void **state)
{
	(void)state;
	stilb_start(
		no_display, -1,
		"demo --headless --models 100 --size 64x64 --frames 1000000 --screenshot a.png --stats a.json --trace t.json");
	bool ready = catches_interrupts(run.pid);
	kill(run.pid, ready ? SIGINT : SIGKILL);
	program_wait(&run);
	assert_true(ready);
	assert_int_equal(run.code, 0);
	assert_string_equal(run.err, "");
	read_stats("a.json");
	assert_in_range(stat_int("frames"), 1, 999999);
	read_picture("a.png");
	assert_int_equal(folder_entries(), 3);
}

#define FRESH_TEST(name) cmocka_unit_test_setup(name, picture_fresh)

/* What GPUs do with textures of blocks. */
static void test_info_of_blocks(void **state)
{
	(void)state;
	stilb_good("info");
	bool software = strstr(run.out, ", software, ");
	assert_said(run.out, software ? "\n     compressed textures: BC1, BC3, BC4, BC5; BC7 is decoded"
	                              : "\n     compressed textures: ");
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		FRESH_TEST(test_info_of_blocks),
		FRESH_TEST(test_same_picture_and_draws),
		FRESH_TEST(test_same_picture_and_draws_while_models_move),
		FRESH_TEST(test_same_picture_and_draws_with_samples),
		FRESH_TEST(test_same_picture_and_draws_of_several_cameras),
		FRESH_TEST(test_flags_change_the_picture),
		FRESH_TEST(test_each_name_is_another_picture),
		FRESH_TEST(test_numbers_added_to_materials),
		FRESH_TEST(test_the_same_formulas_in_every_way),
		FRESH_TEST(test_linear_picture),
		FRESH_TEST(test_overlay),
		FRESH_TEST(test_inspector),
		FRESH_TEST(test_show_of_a_trace),
		FRESH_TEST(test_stats_and_trace),
		FRESH_TEST(test_full_disk),
		FRESH_TEST(test_without_a_display),
		FRESH_TEST(test_choice_of_a_gpu),
		FRESH_TEST(test_interrupt_ends_it_well),
	};
	if (argc != 2 || !folder_enter(argv[1], "test_game_demo")) {
		fprintf(stderr, "usage: test_game_demo STILB\n");
		return 1;
	}
	if (stilb_code(no_display, "demo --headless --validate --models 1 --size 8x8 --frames 1") != 0 &&
	    (strstr(run.err, "mesa-vulkan-drivers") || strstr(run.err, "vulkan-validationlayers"))) {
		folder_leave(NULL);
		printf("skipped: %s", run.err);
		return 77;
	}
	int failed = cmocka_run_group_tests(tests, NULL, folder_leave);
	stilb_image_finish(&picture);
	return failed;
}
