/* stilb bake: the files it writes, what it says, the same bits for any workers, and what it refuses. */
#include "image/image.h"
#include "support/stilb_program.h"

#include <math.h>

#define SMALL "bake cornell --page 64 --spp 2 --depth 4 "

/* The mean of all channels of a picture that has this size and number of channels. */
static double mean_of(const char *path, uint32_t side, uint32_t channels)
{
	stilb_image image;
	float row[64 * 4];
	double sum = 0.0;
	if (stilb_image_load(path, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(image.width, side);
	assert_int_equal(image.height, side);
	assert_int_equal(image.channels, channels);
	for (uint32_t y = 0; y < side; y++) {
		stilb_image_row_to_light(&image, y, row);
		for (uint32_t i = 0; i < side * channels; i++)
			sum += (double)row[i];
	}
	stilb_image_finish(&image);
	return sum / (side * side * channels);
}

static void test_it_just_works(void **state)
{
	(void)state;
	stilb_good(SMALL "-o . --show charts,texels,states,light --workers 2");
	assert_said(run.out, "unwrapped: 38 triangles in 19 charts, stretch 1.000");
	assert_said(run.out, "pages:     1 of 64 x 64");
	assert_said(run.out, "files:     .");
	assert_true(mean_of("lightmap-0.exr", 64, 3) > 0.1);
	assert_true(mean_of("ao-0.exr", 64, 1) > 0.02);
	assert_true(mean_of("charts-0.png", 64, 3) > 0.1);
	assert_true(mean_of("texels-0.png", 64, 3) > 0.05);
	assert_true(mean_of("states-0.png", 64, 3) > 0.1);
	assert_true(mean_of("light-0.png", 64, 3) > 0.05);
	read_stats("bake.json");
	assert_int_equal(stat_int("pages"), 1);
	assert_int_equal(stat_int("charts"), 19);
	assert_int_equal(stat_int("triangles"), 38);
	assert_true(stat_int("texels_lit") > 1000 && stat_int("texels_hidden") > 0 && stat_int("rays") > 4000);
}

/* The scene with its second uv is a file that Stilb itself reads: with as many triangles, and with the openness as
 * occlusion. */
static void test_the_glb_is_a_scene(void **state)
{
	(void)state;
	stilb_good(SMALL "-o .");
	stilb_good("info ./scene.glb");
	assert_said(run.out, "38 triangles");
	stilb_good("render ./scene.glb -o a.exr --integrator color --size 16x16 --spp 1");
	stilb_good(SMALL "-o . --what glb");
	assert_int_equal(access("charts-0.png", F_OK), -1);
}

static void test_the_same_bits(void **state)
{
	(void)state;
	stilb_good(SMALL "-o . --workers 1");
	assert_int_equal(rename("lightmap-0.exr", "light.exr"), 0);
	assert_int_equal(rename("ao-0.exr", "open.exr"), 0);
	assert_int_equal(rename("scene.glb", "one.glb"), 0);
	stilb_good(SMALL "-o . --workers 3");
	assert_true(same_file("lightmap-0.exr", "light.exr"));
	assert_true(same_file("ao-0.exr", "open.exr"));
	assert_true(same_file("scene.glb", "one.glb"));
	stilb_good(SMALL "-o . --seed 1");
	assert_false(same_file("lightmap-0.exr", "light.exr"));
}

static void test_three_directions(void **state)
{
	(void)state;
	stilb_good(SMALL "-o . --what rnm,intensity");
	double light = mean_of("lightmap-0.exr", 64, 3), sum = 0.0;
	sum += mean_of("rnm1-0.exr", 64, 3) + mean_of("rnm2-0.exr", 64, 3) + mean_of("rnm3-0.exr", 64, 3);
	assert_true(light > 0.1 && fabs(sum / (3.0 * light) - 1.0) < 0.01);
	assert_true(mean_of("intensity-0.exr", 64, 3) > 0.5);
	read_stats("bake.json");
	assert_true(stat_ms("intensity_error") > 0.01 && stat_ms("intensity_error") < 1.0);
}

static void test_probes(void **state)
{
	(void)state;
	stilb_good("bake cornell -o . --what probes --probe-spacing 0.3 --probe-spp 32 --depth 4 --page 64");
	assert_said(run.out, "probes:    ");
	read_stats("probes.json");
	long long count = stat_int("count[0]") * stat_int("count[1]") * stat_int("count[2]");
	char path[64];
	snprintf(path, sizeof path, "probes[%lld].g[0]", count - 1);
	assert_true(count > 8 && atof(stat_text(path, '0')) > 0.0);
	assert_int_equal(access("probes-seen.exr", F_OK), 0);
	assert_int_equal(access("lightmap-0.exr", F_OK), -1);
}

static void test_pages_and_folders(void **state)
{
	(void)state;
	stilb_good(SMALL "-o new --texels-per-unit 40 --what ao");
	assert_int_equal(access("new/ao-1.exr", F_OK), 0);
	assert_int_equal(access("new/scene.glb", F_OK), -1);
	assert_int_equal(access("new/lightmap-0.exr", F_OK), -1);
	int pages = 0;
	for (char path[64]; snprintf(path, sizeof path, "new/ao-%d.exr", pages), access(path, F_OK) == 0; pages++) {
		remove(path);
		snprintf(path, sizeof path, "new/ao-%d.png", pages);
		remove(path);
	}
	remove("new/bake.json");
	assert_true(pages > 1);
	assert_int_equal(rmdir("new"), 0);
}

static void refused(const char *line, const char *said)
{
	assert_int_equal(stilb_code(no_display, line), 2);
	assert_error_lines(1);
	assert_said(run.err, said);
}

static void test_what_is_refused(void **state)
{
	(void)state;
	refused("bake", "no scene; give one");
	refused("bake cornell", "no output; give -o DIR");
	refused("bake cornell -o . --what lightmap,sun",
	        "--what: 'sun' is not known; give some of lightmap, ao, glb, rnm, intensity, probes");
	refused("bake cornell -o . --show {}", "--show");
	refused("bake cornell -o . --show chart", "'chart' is not known; give some of charts, texels, states, light");
	refused("bake cornell -o /nonexistent/a/b", "cannot make the folder '/nonexistent/a/b'");
	refused("bake nothing.gltf -o .", "nothing.gltf");
	refused("bake cornell -o . --cone 0", "--cone");
	refused("bake cornell -o . --texels-per-unit 900000 --page 64", "texels a metre are");
	fclose(fopen("file", "w"));
	refused("bake cornell -o file", "file");
	assert_int_equal(access("bake.json", F_OK), -1);
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup(test_it_just_works, folder_fresh),
		cmocka_unit_test_setup(test_the_glb_is_a_scene, folder_fresh),
		cmocka_unit_test_setup(test_the_same_bits, folder_fresh),
		cmocka_unit_test_setup(test_three_directions, folder_fresh),
		cmocka_unit_test_setup(test_probes, folder_fresh),
		cmocka_unit_test_setup(test_pages_and_folders, folder_fresh),
		cmocka_unit_test_setup(test_what_is_refused, folder_fresh),
	};
	if (!folder_enter(argc > 1 ? argv[1] : NULL, "game_bake")) {
		fprintf(stderr, "usage: %s PATH-OF-STILB\n", argv[0]);
		return 2;
	}
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
