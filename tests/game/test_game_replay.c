/* stilb demo --dump and stilb replay: the same draws and the same picture without the scene, and messages on files that
 * are no dumps. With the argument "null" only the tests that need no Vulkan. */
#include "support/stilb_program.h"

#include "base/base.h"
#include "image/image.h"

#define SMALL "--models 400 --size 320x180 --shadows off " /* which are not in dumps */
#define NULL_DEMO "demo --headless --device null --frames 3 " SMALL

static const char *const replays[] = {"indirect", "direct", "secondary"};
static const char *const materials[] = {"index", "bind", "pipeline"};

/* With the address sanitizer one way for each replay and each kind of materials, and every second scene. */
enum { WAY_STEP = TEST_ASAN ? 4 : 1, SCENE_STEP = TEST_ASAN ? 2 : 1 };

static void copy_file(const char *from, const char *to, long bytes)
{
	char command[256];
	snprintf(command, sizeof command, "head -c %ld %s > %s", bytes, from, to);
	assert_int_equal(system(command), 0);
}

static long file_bytes(const char *path)
{
	struct stat info;
	assert_int_equal(stat(path, &info), 0);
	return (long)info.st_size;
}

static void assert_whole(void)
{
	assert_string_equal(run.err, "");
	assert_said(run.out, "as in the file");
	assert_said(run.out, "record a draw");
	assert_said(run.out, "they add up to ");
}

/* ---- without Vulkan ---------------------------------------------------------------------------------------------- */

static void test_the_same_draws(void **state)
{
	(void)state;
	static const char *const whats[] = {"", "--view few --models 5000", "--animate --workers 2 --seed 5 --view half",
	                                    "--ndf beckmann --light-model windowed"};
	int way = 0;
	for (size_t w = 0; w < sizeof whats / sizeof *whats; w += SCENE_STEP) {
		stilb_good(NULL_DEMO "%s --dump a.dump --stats a.json", whats[w]);
		assert_said(run.out, "dump: a.dump");
		uint64_t hash = stat_hash("a.json");
		long long draws = stat_int("draws");
		for (int i = 0; i < 3; i++, way++) {
			stilb_good("replay a.dump --device null --frames 4 --workers %d --replay %s --materials %s --stats b.json",
			           i, replays[(way + 1) % 3], materials[i]);
			assert_whole();
			assert_true(stat_hash("b.json") == hash);
			assert_int_equal(stat_int("draws"), draws);
			assert_int_equal(stat_int("frames"), 4);
			assert_int_equal(stat_int("workers"), i);
			assert_string_equal(stat_text("replay", '"'), replays[(way + 1) % 3]);
			assert_string_equal(stat_text("materials", '"'), materials[i]);
			assert_int_equal(stat_int("kinds[0].count"), draws);
			assert_true(stat_ms("kinds[0].ns") > 0.0 && stat_ms("stages.record.median") > 0.0);
			assert_true(stat_int("rounds") >= 5);
		}
	}
	assert_int_equal(folder_entries(), 3); /* no temporary file */
}

static void test_the_same_file(void **state)
{
	(void)state;
	stilb_good(NULL_DEMO "--workers 0 --dump a.dump");
	stilb_good(NULL_DEMO "--workers 3 --cull flat --replay direct --materials bind --dump b.dump");
	assert_int_equal(system("cmp a.dump b.dump"), 0);
	stilb_good(NULL_DEMO "--workers 0 --seed 2 --dump b.dump");
	assert_int_not_equal(system("cmp -s a.dump b.dump"), 0);
}

/* Dumps hold frames as they are without shadow maps. */
static void test_shadows_are_left_out(void **state)
{
	(void)state;
	stilb_good(NULL_DEMO "--shadows map --dump a.dump");
	stilb_good("replay a.dump --device null --frames 2"); /* which compares the hash of its draws */
}

static void test_through_a_pipe(void **state)
{
	(void)state;
	char command[3 * PATH_MAX];
	snprintf(command, sizeof command,
	         "'%s' " NULL_DEMO "--dump - 2> words | '%s' replay - --device null --frames 2 --stats b.json > said",
	         stilb_path, stilb_path);
	assert_int_equal(system(command), 0);
	assert_int_equal(system("grep -q 'bound by' words && grep -q 'as in the file' said"), 0);
	stilb_good(NULL_DEMO "--stats a.json");
	uint64_t hash = stat_hash("a.json");
	assert_true(stat_hash("b.json") == hash);
	assert_int_equal(stilb_code(no_display, NULL_DEMO "--dump a.dump"), 0);
	assert_int_equal(stilb_code(no_display, "replay a.dump --device null --stats -"), 0);
	json_flat_finish(&stats);
	assert_true(json_flat_text(run.out, strlen(run.out), &stats)); /* nothing but JSON */
	assert_said(run.err, "record a draw");
}

static void test_help(void **state)
{
	(void)state;
	static const char *const flags[] = {"--device",   "--frames", "--workers",    "--replay", "--materials",
	                                    "--size",     "--gpu",    "--screenshot", "--stats",  "--headless",
	                                    "--validate", "--until",  "--show",       "--plan",   "--show-range"};
	stilb_good("replay --help");
	for (size_t i = 0; i < sizeof flags / sizeof *flags; i++) {
		char line[32];
		snprintf(line, sizeof line, "\n  %s ", flags[i]);
		assert_said(run.out, line);
	}
	for (const char *at = run.out, *end; (end = strchr(at, '\n')); at = end + 1)
		assert_true(end - at <= 110); /* columns of a usual terminal window */
	stilb_good("replay a.dump --help");
	stilb_good("--help");
	assert_said(run.out, "  replay ");
	stilb_good("demo --help");
	assert_said(run.out, "  --dump ");
}

static const char *const refusals[][2] = {
	{"replay", "no file"},
	{"replay {}", "no file"},
	{"replay --frames 3", "no file"},
	{"replay missing.dump", "'missing.dump'"},
	{"replay missing.dump --device null", "demo --dump"},
	{"replay folder --device null", "directory"},
	{"replay a.dump b.dump", "'b.dump'"},
	{"replay a.dump --bogus", "'--bogus'"},
	{"replay a.dump --frames 0", "1..1000000"},
	{"replay a.dump --workers 257", "0..256"},
	{"replay a.dump --replay slow", "indirect, direct, secondary"},
	{"replay a.dump --materials none", "index, bind, pipeline"},
	{"replay a.dump --size 0x1", "'0x1'"},
	{"replay a.dump --device null --screenshot a.png", "null device"},
	{"replay a.dump --screenshot a.bmp", ".png, .exr or .hdr"},
	{"replay a.dump --stats missing/a.json", "does not exist"},
	{"replay a.dump --plan missing/a.svg", "does not exist"},
	{"replay a.dump --plan a.json --stats a.json", "two outputs"},
	{"replay a.dump --show lod", "'lod' is chosen when a frame is dumped"},
	{"replay a.dump --show normal", "'normal' is in no dump"},
	{"replay a.dump --show depth:x", "'depth:x' is no IMAGE:MIP"},
	{"replay a.dump --show-range 0,1", "name one with --show"},
	{"replay a.dump --show depth --show-range 1,1", "'1,1' is not LOW,HIGH"},
	{"replay a.dump --device null --show nothing",
     "there is no image 'nothing' to show; this frame has picture, color"},
	{"replay a.dump --device null --show depth:1", "there is no mip 1"},
	{"replay a.dump --device null --until nothing",
     "there is no pass 'nothing' for the frame to end with; this frame has 1 scene, 2 tone map"},
	{"replay a.dump --device null --until 3", "there is no pass '3'"},
	{"replay a.dump --device null --until scene --show picture",
     "image 'picture' has no content yet after pass 1 'scene'"},
	{"replay a.dump --stats a.png --screenshot a.png", "two outputs"},
	{NULL_DEMO "--dump missing/a.dump", "does not exist"},
	{NULL_DEMO "--dump folder", "folder"},
	{NULL_DEMO "--dump a.json --stats ./a.json", "two outputs"},
	{NULL_DEMO "--dump - --trace -", "two outputs"},
};

static void test_refusals(void **state)
{
	(void)state;
	stilb_good(NULL_DEMO "--models 1 --dump a.dump");
	assert_int_equal(mkdir("folder", 0777), 0);
	for (size_t i = 0; i < sizeof refusals / sizeof *refusals; i++) {
		int code = stilb_code(no_display, refusals[i][0]);
		if (code != 2)
			print_error("stilb %s: %s", refusals[i][0], run.err);
		assert_int_equal(code, 2);
		assert_string_equal(run.out, "");
		assert_error_lines(1);
		assert_said(run.err, refusals[i][1]);
		assert_int_equal(folder_entries(), 2); /* no new file */
	}
}

/* Asserts that stilb replay refuses a file that exists but is no dump, and names the file and the reason. */
static void assert_bad(const char *path, const char *reason)
{
	char line[256], quoted[64];
	snprintf(line, sizeof line, "replay %s --device null --stats a.json", path);
	snprintf(quoted, sizeof quoted, "'%s'", path);
	assert_int_equal(stilb_code(no_display, line), 2);
	assert_string_equal(run.out, "");
	assert_error_lines(1);
	assert_said(run.err, quoted);
	assert_said(run.err, reason);
	assert_int_not_equal(access("a.json", F_OK), 0);
}

/* Changes 32 bits at an offset in bytes from the start of the file, and corrects the file's checksum. */
static void forge(const char *path, size_t offset, uint32_t value)
{
	FILE *file = fopen(path, "r+b");
	assert_non_null(file);
	size_t size = (size_t)file_bytes(path);
	uint8_t *bytes = malloc(size);
	assert_non_null(bytes);
	assert_int_equal(fread(bytes, 1, size, file), size);
	memcpy(bytes + offset, &value, sizeof value);
	uint64_t checksum = stilb_hash_fnv1a64(STILB_FNV1A64_START, bytes, size - sizeof checksum);
	memcpy(bytes + size - sizeof checksum, &checksum, sizeof checksum);
	rewind(file);
	assert_int_equal(fwrite(bytes, 1, size, file), size);
	assert_int_equal(fclose(file), 0);
	free(bytes);
}

static void test_bad_files(void **state)
{
	(void)state;
	stilb_good(NULL_DEMO "--models 3 --dump good.dump");
	long size = file_bytes("good.dump");
	const long sizes[] = {1, 8, 50, 128, 1000, size / 2, size - 8, size - 1};
	copy_file("good.dump", "bad.dump", 0);
	assert_bad("bad.dump", "empty");
	for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
		copy_file("good.dump", "bad.dump", sizes[i]);
		assert_bad("bad.dump", sizes[i] < 144 ? "header" : "truncated");
	}
	assert_int_equal(system("cat good.dump good.dump > bad.dump"), 0);
	assert_bad("bad.dump", "continues after its last byte");
	assert_int_equal(system("tr '\\200' '\\201' < good.dump > bad.dump"), 0);
	assert_bad("bad.dump", "damaged");
	assert_bad("/dev/null", "empty");
	assert_bad(stilb_path, "not a frame dump");
	copy_file("good.dump", "bad.dump", size);
	forge("bad.dump", 24, 0x12345678);
	assert_bad("bad.dump", "stream hash");
	for (uint32_t version = 0; version <= 16; version++) {
		char reason[80];
		snprintf(reason, sizeof reason, "header: version %u, but this program reads version 15; 'stilb demo --dump",
		         version);
		copy_file("good.dump", "bad.dump", size);
		forge("bad.dump", 8, version);
		if (version != 15)
			assert_bad("bad.dump", reason);
	}
	copy_file("good.dump", "bad.dump", size);
	forge("bad.dump", 32, 20000);
	assert_bad("bad.dump", "header: a picture of 20000x180");
}

static void test_full_disk(void **state)
{
	(void)state;
	assert_int_equal(stilb_code(no_display, NULL_DEMO "--dump /dev/full --stats a.json --trace t.json"), 1);
	assert_error_lines(1);
	assert_said(run.err, "/dev/full");
	read_stats("a.json"); /* the other outputs are written all the same */
	assert_trace("t.json", 256, 3);
	stilb_good(NULL_DEMO "--dump a.dump");
	assert_int_equal(stilb_code(no_display, "replay a.dump --device null --stats /dev/full"), 1);
	assert_error_lines(1);
	int full = open("/dev/full", O_WRONLY | O_CLOEXEC);
	stilb_start(no_display, full, NULL_DEMO "--dump -");
	program_wait(&run);
	assert_int_equal(run.code, 1);
	assert_said(run.err, "stilb: cannot write '-'");
	stilb_start(no_display, full, "replay a.dump --device null --frames 1");
	program_wait(&run);
	assert_int_equal(run.code, 1);
	assert_error_lines(1);
	close(full);
	assert_int_equal(folder_entries(), 3);
}

static void test_no_driver(void **state)
{
	(void)state;
	stilb_good(NULL_DEMO "--models 1 --dump a.dump");
	assert_int_equal(stilb_code(no_driver, "replay a.dump"), 2);
	assert_error_lines(1);
	assert_said(run.err, "mesa-vulkan-drivers");
	assert_said(run.err, "--device null");
}

/* ---- with Vulkan ------------------------------------------------------------------------------------------------- */

static bool same_picture(const char *path_a, const char *path_b)
{
	stilb_image a, b;
	assert_int_equal(stilb_image_load(path_a, &a), STILB_OK);
	assert_int_equal(stilb_image_load(path_b, &b), STILB_OK);
	bool same = a.width == b.width && a.height == b.height && a.format == b.format && a.channels == b.channels &&
	            memcmp(a.pixels, b.pixels, stilb_image_size(&a)) == 0;
	stilb_image_finish(&a);
	stilb_image_finish(&b);
	return same;
}

static void test_the_same_picture(void **state)
{
	(void)state;
	stilb_good("demo --headless --frames 3 --animate " SMALL "--dump a.dump --screenshot a.png --stats a.json");
	uint64_t hash = stat_hash("a.json");
	for (int way = 0; way < 9; way += WAY_STEP) {
		stilb_good("replay a.dump --frames 2 --workers %d --replay %s --materials %s --screenshot b.png --stats b.json "
		           "--validate",
		           (way + way / 4) % 4, replays[way % 3], materials[way / 3]);
		assert_whole();
		assert_true(stat_hash("b.json") == hash);
		assert_true(same_picture("a.png", "b.png"));
		assert_int_equal(stat_int("commands.draw"), way % 3 == 0 ? 0 : 800);
	}
	stilb_good("replay a.dump --frames 1 --size 160x180 --screenshot b.png");
	assert_false(same_picture("a.png", "b.png"));
	stilb_good("demo --headless --frames 2 --animate " SMALL "--screenshot b.png");
	assert_false(same_picture("a.png", "b.png")); /* another frame of the animation */
}

static void test_the_same_picture_in_other_ways(void **state)
{
	(void)state;
	static const char *const whats[] = {"--msaa 4 --view half --workers 0", "--view few --models 3000 --seed 3",
	                                    "--ndf ggx-anisotropic --g schlick-ggx --light-model subtracted",
	                                    "--brdf minimalist --light-model hemisphere"};
	for (size_t w = 0; w < sizeof whats / sizeof *whats; w += SCENE_STEP) {
		stilb_good("demo --headless --frames 2 " SMALL "%s --dump a.dump --screenshot a.png", whats[w]);
		stilb_good("replay a.dump --frames 1 --screenshot b.png --validate");
		assert_true(same_picture("a.png", "b.png"));
	}
	stilb_good("demo --headless --frames 2 " SMALL "--dump a.dump --screenshot a.exr");
	stilb_good("replay a.dump --frames 1 --screenshot b.exr --validate");
	assert_true(same_picture("a.exr", "b.exr"));
	/* Backgrounds, and a panorama that lights, are in the file. */
	static const char *const views[] = {"--environment sky.hdr", "--environment sky.hdr --background blur",
	                                    "--studio on", "--background transparent"};
	stilb_good("render outdoor -o sky.hdr --size 16x8 --spp 1");
	for (size_t v = 0; v < sizeof views / sizeof *views; v += SCENE_STEP) {
		stilb_good(
			"view spheres --headless --frames 2 --size 96x54 --quiet --shadows off %s --dump a.dump --screenshot a.png",
			views[v]);
		stilb_good("replay a.dump --frames 1 --screenshot b.png");
		assert_true(same_picture("a.png", "b.png"));
	}
	/* Dumps leave shadows out, which is said. */
	stilb_good("demo --headless --frames 2 --models 100 --size 96x54 --dump a.dump --screenshot a.png");
	assert_said(run.out, "dump: without shadow maps");
	stilb_good("replay a.dump --frames 1 --screenshot b.png");
	assert_false(same_picture("a.png", "b.png"));
	stilb_good("demo --headless --frames 2 --models 100 --size 96x54 --shadows off --dump a.dump --screenshot a.png");
	assert_false(strstr(run.out, "shadow"));
	assert_true(same_picture("a.png", "b.png"));
	stilb_good("demo --headless --frames 2 " SMALL "--dump a.dump --screenshot a.exr");
	stilb_good("demo --headless --device null --frames 2 " SMALL "--dump a.dump"); /* a dump of the null device */
	stilb_good("replay a.dump --frames 1 --screenshot c.exr");
	assert_true(same_picture("a.exr", "c.exr"));
}

static void write_text(const char *name, const char *text)
{
	FILE *file = fopen(name, "w");
	assert_non_null(file);
	fputs(text, file);
	fclose(file);
}

static void test_textures(void **state)
{
	(void)state;
	stilb_good("demo --headless --frames 1 --models 50 --size 64x64 --screenshot tile.png");
	write_text("tile.mtl", "newmtl tile\nKd 1 1 1\nmap_Kd tile.png\n");
	write_text("tile.obj", "mtllib tile.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nusemtl tile\n"
	                       "f 1/1 2/2 3/3\n");
	stilb_good("view tile.obj --headless --studio off --environment 1,1,1 --size 64x64 --shadows off --dump a.dump "
	           "--screenshot a.png");
	stilb_good("replay a.dump --frames 1 --screenshot b.png --validate");
	assert_true(same_picture("a.png", "b.png"));
	write_text("tile.mtl", "newmtl tile\nKd 1 1 1\n");
	stilb_good("view tile.obj --headless --studio off --environment 1,1,1 --size 64x64 --screenshot b.png");
	assert_false(same_picture("a.png", "b.png")); /* the texture is seen */
}

#define FRESH_TEST(name) cmocka_unit_test_setup(name, folder_fresh)

int main(int argc, char **argv)
{
	const struct CMUnitTest null_tests[] = {
		FRESH_TEST(test_the_same_draws), FRESH_TEST(test_the_same_file), FRESH_TEST(test_shadows_are_left_out),
		FRESH_TEST(test_through_a_pipe), FRESH_TEST(test_help),          FRESH_TEST(test_refusals),
		FRESH_TEST(test_bad_files),      FRESH_TEST(test_full_disk),     FRESH_TEST(test_no_driver),
	};
	const struct CMUnitTest tests[] = {
		FRESH_TEST(test_the_same_picture),
		FRESH_TEST(test_the_same_picture_in_other_ways),
		FRESH_TEST(test_textures),
	};
	bool null = argc == 3 && strcmp(argv[2], "null") == 0;
	if ((argc != 2 && !null) || !folder_enter(argv[1], null ? "test_game_replay_null" : "test_game_replay")) {
		fprintf(stderr, "usage: test_game_replay STILB [null]\n");
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
