/* stilb render --part and --merge: a picture that several runs make together is the same file as that of one. */
#include "support/stilb_program.h"

#define SMALL "render cornell --size 40x24 --spp 16 "

static void refused(const char *line, const char *said)
{
	assert_int_equal(stilb_code(no_display, line), 2);
	assert_said(run.err, said);
	assert_error_lines(1);
}

static void test_parts_are_the_picture(void **state)
{
	(void)state;
	stilb_good(SMALL "-o whole.exr --workers 1");
	stilb_good(SMALL "-o whole.png --workers 1");
	for (int i = 1; i <= 3; i++) {
		stilb_good(SMALL "--part %d/3 -o %d.part --workers %d --stats s.json", i, i, i);
		read_stats("s.json");
		assert_string_equal(stat_text("end", '"'), "samples");
		assert_true(stat_int("camera_rays") > 40 * 24 * 16 / 4 && stat_int("camera_rays") < 40 * 24 * 16 / 2);
	}
	assert_said(run.out, "part 3 of 3\n");
	assert_said(run.out, "part: 3.part\n");
	stilb_good("render --merge 2.part 3.part 1.part -o merged.exr");
	assert_said(run.out, "3 parts, 40x24, 16 samples a pixel, ");
	assert_said(run.out, "picture: merged.exr\n");
	assert_true(same_file("whole.exr", "merged.exr"));
	stilb_good("render 1.part -o merged.png 2.part --merge 3.part"); /* in any order with the flags */
	assert_true(same_file("whole.png", "merged.png"));
	assert_int_equal(folder_entries(), 8); /* four pictures, three parts, the numbers */
}

/* What denoising needs is in the parts, and it is done when they are joined. */
static void test_parts_are_denoised(void **state)
{
	(void)state;
	stilb_good(SMALL "-o noisy.exr --workers 1");
	stilb_good(SMALL "-o whole.exr --workers 2 --denoise");
	stilb_good(SMALL "--part 1/2 -o 1.part --denoise");
	stilb_good(SMALL "--part 2/2 -o 2.part --denoise");
	stilb_good(SMALL "--part 2/2 -o other.part");
	stilb_good("render --merge 2.part 1.part -o merged.exr");
	assert_true(same_file("whole.exr", "merged.exr"));
	assert_false(same_file("noisy.exr", "merged.exr"));
	refused("render --merge 1.part other.part -o a.exr",
	        "'other.part' does not belong to '1.part': its denoise is no, not yes");
}

static void test_what_does_not_fit(void **state)
{
	(void)state;
	stilb_good(SMALL "--part 1/2 -o 1.part");
	stilb_good(SMALL "--part 2/2 -o 2.part");
	stilb_good(SMALL "--part 2/2 -o other.part --depth 3");
	stilb_good("render outdoor --size 40x24 --spp 16 --part 2/2 -o outdoor.part");
	refused("render --merge 1.part -o a.exr", "1 of 2 parts is missing: 2/2");
	refused("render --merge 1.part 2.part 1.part -o a.exr", "hold the same units; leave out one");
	refused("render --merge 1.part other.part -o a.exr",
	        "'other.part' does not belong to '1.part': its depth is 3, not");
	refused("render --merge 1.part outdoor.part -o a.exr", "'outdoor.part' is of another scene than '1.part'");
	refused("render --merge 1.part none.part -o a.exr", "none.part");
	refused("render --merge 1.part 2.part -o 2.part", "'2.part'"); /* no picture's name */
	refused("render --merge 1.part 2.part", "--merge: no output");
	refused("render --merge -o a.exr", "--merge: no parts");
	refused("render --merge 1.part 2.part -o a.exr --spp 4", "unknown flag '--spp'");
	assert_int_equal(truncate("2.part", 30000), 0);
	refused("render --merge 1.part 2.part -o a.exr", "'2.part' is damaged or cut short; make this part again");
	assert_int_equal(folder_entries(), 4);
}

/* A copy of the program with a byte more is another build. */
static void test_another_build(void **state)
{
	(void)state;
	static char block[1 << 20], kept[PATH_MAX];
	FILE *from = fopen(stilb_path, "rb"), *to = fopen("stilb", "wb");
	assert_true(from && to);
	for (size_t got; (got = fread(block, 1, sizeof block, from)) > 0;)
		assert_int_equal(fwrite(block, 1, got, to), got);
	fputc('x', to);
	fclose(from);
	assert_int_equal(fclose(to), 0);
	assert_int_equal(chmod("stilb", 0700), 0);
	stilb_good(SMALL "--part 1/2 -o 1.part");
	snprintf(kept, sizeof kept, "%s", stilb_path);
	snprintf(stilb_path, sizeof stilb_path, "./stilb");
	int code = stilb_code(no_display, SMALL "--part 2/2 -o 2.part");
	snprintf(stilb_path, sizeof stilb_path, "%s", kept);
	assert_int_equal(code, 0);
	refused("render --merge 1.part 2.part -o a.exr", "'2.part' was made by another build of the program than '1.part'");
}

static void test_what_no_part_can_do(void **state)
{
	(void)state;
	refused(SMALL "--part 1/2 -o 1.png", "-o FILE.part");
	refused(SMALL "--part 1/2", "no output");
	refused(SMALL "--part 0/2 -o 1.part", "--part: '0/2' is no I/N");
	refused(SMALL "--part 3/2 -o 1.part", "--part: '3/2' is no I/N");
	refused(SMALL "--part 1 -o 1.part", "--part: '1' is no I/N");
	refused(SMALL "--part 1/2x -o 1.part", "--part: '1/2x' is no I/N");
	refused(SMALL "--part 1/99999999999 -o 1.part", "is no I/N");
	refused(SMALL "--part 1/2 -o 1.part --time 1", "--time");
	refused(SMALL "--part 1/2 -o 1.part --error 0.1", "--error");
	refused(SMALL "--part 1/2 -o 1.part --integrator irradiance-cache --cache live", "--cache live");
	refused(SMALL "--part 1/2 -o 1.part --frames 0..3", "--frames");
	refused(SMALL "--part 1/2 -o 1.part --shutter 0.5", "--shutter");
	refused(SMALL "-o 1.part", "1.part"); /* without --part no picture has that name */
	assert_int_equal(folder_entries(), 0);
}

/* Ctrl-C leaves a checkpoint of the share and no part, and --resume makes the same part of it. */
static void test_a_part_resumes(void **state)
{
	(void)state;
	static const char slow[] = "render cornell --size 64x64 --spp 250 --part 1/2 -o 1.part --workers 2";
	stilb_start(no_display, -1, slow);
	nanosleep(&(struct timespec){.tv_nsec = 150000000}, NULL);
	kill(run.pid, SIGINT);
	program_wait(&run);
	assert_int_equal(run.code, 0);
	assert_said(run.out, "--resume continues it");
	assert_int_equal(access("1.part", F_OK), -1);
	assert_int_equal(access("1.part.checkpoint", F_OK), 0);
	stilb_good("%s --resume", slow);
	assert_int_equal(access("1.part.checkpoint", F_OK), -1);
	stilb_good("render cornell --size 64x64 --spp 250 --part 2/2 -o 2.part");
	stilb_good("render --merge 1.part 2.part -o merged.exr");
	stilb_good("render cornell --size 64x64 --spp 250 -o whole.exr");
	assert_true(same_file("whole.exr", "merged.exr"));
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup(test_parts_are_the_picture, folder_fresh),
		cmocka_unit_test_setup(test_parts_are_denoised, folder_fresh),
		cmocka_unit_test_setup(test_what_does_not_fit, folder_fresh),
		cmocka_unit_test_setup(test_another_build, folder_fresh),
		cmocka_unit_test_setup(test_what_no_part_can_do, folder_fresh),
		cmocka_unit_test_setup(test_a_part_resumes, folder_fresh),
	};
	if (!folder_enter(argc > 1 ? argv[1] : NULL, "game_parts")) {
		fprintf(stderr, "usage: %s PATH-OF-STILB\n", argv[0]);
		return 2;
	}
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
