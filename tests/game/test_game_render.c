/* stilb render: pictures, numbers, refusals, signals, full disks, and the output on a terminal. With the argument
 * "long" the tests that take seconds. */
#include "image/image.h"
#include "support/stilb_program.h"

#include <math.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <termios.h>

#define SMALL "render cornell --size 32x32 --spp 4 "
#define SLOW "render cornell --size 64x64 --spp 65536 --workers 2 "

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

static bool exists(const char *path)
{
	return access(path, F_OK) == 0;
}

static stilb_image load(const char *path)
{
	stilb_image image;
	stilb_result result = stilb_image_load(path, &image);
	if (result != STILB_OK)
		print_error("%s\n", stilb_error_message());
	assert_int_equal(result, STILB_OK);
	return image;
}

static bool same_pixels(const char *a, const char *b)
{
	stilb_image first = load(a), second = load(b);
	bool same = first.width == second.width && first.height == second.height && first.channels == second.channels &&
	            first.format == second.format && memcmp(first.pixels, second.pixels, stilb_image_size(&first)) == 0;
	stilb_image_finish(&first);
	stilb_image_finish(&second);
	return same;
}

/* The mean of a channel over the whole picture. */
static double mean(const stilb_image *image, uint32_t channel)
{
	const float *pixels = image->pixels;
	size_t count = (size_t)image->width * image->height;
	double sum = 0.0;
	assert_int_equal(image->format, STILB_IMAGE_F32_LINEAR);
	for (size_t i = 0; i < count; i++)
		sum += (double)pixels[i * image->channels + channel];
	return sum / (double)count;
}

/* ---- what it is for ---------------------------------------------------------------------------------------------- */

static void test_it_just_works(void **state)
{
	(void)state;
	stilb_good("render cornell -o a.exr --size 48x32 --spp 16 --stats a.json --workers 2 --seed 7");
	assert_said(run.out, "cornell: 38 triangles");
	assert_said(run.out, "path, 48x32, 16 samples a pixel (sobol); 2 workers, ");
	assert_said(run.out, "picture: a.exr\n");
	assert_said(run.out, "stats: a.json\n");
	assert_int_equal(folder_entries(), 2);
	stilb_image image = load("a.exr");
	assert_int_equal(image.width, 48);
	assert_int_equal(image.height, 32);
	assert_true(mean(&image, 0) > 0.1 && mean(&image, 0) < 2.0);
	assert_true(mean(&image, 0) > mean(&image, 2)); /* more red than blue: the light is warm */
	stilb_image_finish(&image);
	read_stats("a.json");
	assert_string_equal(stat_text("scene.name", '"'), "cornell");
	assert_int_equal(stat_int("scene.triangles"), 38);
	assert_string_equal(stat_text("integrator", '"'), "path");
	assert_string_equal(stat_text("end", '"'), "samples");
	assert_int_equal(stat_int("spp"), 16);
	assert_int_equal(stat_int("workers"), 2);
	assert_string_equal(stat_text("seed", '"'), "7");
	assert_int_equal(stat_int("camera_rays"), 48 * 32 * 16);
	assert_true(stat_int("rays") > 2 * stat_int("camera_rays"));
	assert_true(stat_int("shadow_rays") > 0 && stat_int("shadow_rays") < stat_int("rays"));
	assert_true(stat_ms("render_s") > 0.0);
	assert_true(stat_text("isa", '"')[0] != '\0');
	assert_jobs();
	assert_int_equal(stat_int("passes[0].first_sample"), 0);
	assert_true(stat_int("passes[0].block") > 1); /* the first pass is coarse */
}

static void test_png_is_what_one_sees(void **state)
{
	(void)state;
	stilb_good("render -o a.PNG --size=40x30 --spp=2 cornell --workers 1"); /* the scene may stand anywhere */
	stilb_good("render -o dark.png --size=40x30 --spp=2 cornell --workers 1 --exposure -3");
	stilb_image image = load("a.PNG"), dark = load("dark.png");
	assert_int_equal(image.format, STILB_IMAGE_U8_SRGB);
	const uint8_t *pixels = image.pixels, *darker = dark.pixels;
	uint64_t sum = 0, dark_sum = 0;
	for (size_t i = 0; i < stilb_image_size(&image); i++) {
		sum += pixels[i];
		dark_sum += darker[i];
	}
	assert_in_range(sum / stilb_image_size(&image), 60, 220);
	assert_in_range(10 * dark_sum / sum, 2, 6);
	stilb_image_finish(&image);
	stilb_image_finish(&dark);
}

static void test_same_bits_from_any_workers(void **state)
{
	(void)state;
	stilb_good(SMALL "-o a.exr --workers 1");
	stilb_good(SMALL "-o b.exr --workers 3");
	assert_true(same_pixels("a.exr", "b.exr"));
	stilb_good(SMALL "-o b.exr --workers 3 --seed 2");
	assert_false(same_pixels("a.exr", "b.exr"));
}

/* The denoised picture is another one, whatever the format and the workers, with the same other layers. */
static void test_denoise(void **state)
{
	(void)state;
	stilb_good(SMALL "-o noisy.exr");
	stilb_good(SMALL "-o a.exr --denoise --workers 1 --stats s.json");
	read_stats("s.json");
	assert_said(run.out, "denoised in ");
	assert_true(strtod(stat_text("denoise_s", '0'), NULL) > 0.0);
	stilb_good(SMALL "-o b.exr --denoise --workers 3");
	assert_true(same_file("a.exr", "b.exr"));
	assert_false(same_pixels("noisy.exr", "a.exr"));
	stilb_good(SMALL "-o noisy.png");
	stilb_good(SMALL "-o a.png --denoise");
	assert_false(same_pixels("noisy.png", "a.png"));
	stilb_good(SMALL "-o a.hdr --denoise --error 0.5"); /* ends by its error, with some number of samples */
}

/* ---- an end before the end --------------------------------------------------------------------------------------- */

/* A killed process leaves its checkpoint; a run that resumes from it ends with the same bits as one without a break. */
static void test_resume_gives_the_same_bits(void **state)
{
	(void)state;
#define MEDIUM "render cornell --size 64x48 --spp 600 "
	stilb_start(no_display, -1, MEDIUM "-o a.exr --workers 2 --checkpoint 0.05");
	for (int i = 0; i < 300000 && !exists("a.exr.checkpoint") && !exists("a.exr"); i++)
		usleep(1000);
	kill(run.pid, SIGKILL);
	program_wait(&run);
	assert_false(exists("a.exr"));
	assert_true(exists("a.exr.checkpoint"));
	stilb_good(MEDIUM "-o a.exr --workers 3 --resume --stats a.json");
	assert_false(exists("a.exr.checkpoint"));
	stilb_good(MEDIUM "-o b.exr --workers 1");
	assert_true(same_pixels("a.exr", "b.exr"));
	read_stats("a.json");
	assert_true(stat_int("camera_rays") > 0);
}

/* The numbers decide when a run is killed, which the machine's speed turns into what it was doing. */
static double random_s(uint32_t *state, double most)
{
	*state = *state * 1664525u + 1013904223u;
	return most * (*state >> 8) / (1u << 24);
}

/* A run that is killed again and again, at any time: while it reads the scene, fills the cache, renders, writes a
 * checkpoint or the picture; the last one ends. A picture that is there is never half of one. */
static void kill_at_any_time(const char *line, const char *output, uint32_t *numbers)
{
	int killed = 0, resumed = 0;
	char checkpoint[32], words[256];
	snprintf(checkpoint, sizeof checkpoint, "%s.checkpoint", output);
	for (int i = 0; i < 5; i++) {
		snprintf(words, sizeof words, "render %s -o %s --workers %d --checkpoint 0.02 --resume", line, output,
		         1 + i % 3);
		resumed += exists(checkpoint);
		stilb_start(no_display, -1, words);
		usleep((useconds_t)(1e6 * random_s(numbers, 0.6)));
		kill(run.pid, SIGKILL);
		program_wait(&run);
		killed += run.code != 0;
		assert_true(!exists(output) || !exists("whole.exr") || same_file(output, "whole.exr"));
	}
	snprintf(words, sizeof words, "render %s -o %s --workers 2 --resume", line, output);
	assert_int_equal(stilb_code(no_display, words), 0); /* it may say that there is nothing to resume: one has ended */
	print_message("%s: %d of 5 runs were killed, %d had something to resume\n", line, killed, resumed);
	assert_true(killed > 0);
}

/* At last the picture is that of a run without a break, and nothing else is beside it. */
static void test_killed_at_any_time(void **state)
{
	(void)state;
	static const char *const lines[] = {"cornell --size 128x128 --spp 96",
	                                    "spheres --size 96x96 --spp 16 --integrator split --rays 4",
	                                    "cornell --size 96x96 --spp 64 --integrator irradiance-cache --cache-rays 256"};
	uint32_t numbers = 23;
	for (int i = 0; i < 3; i++) {
		stilb_good("render %s -o whole.exr", lines[i]);
		kill_at_any_time(lines[i], "a.exr", &numbers);
		assert_true(same_file("a.exr", "whole.exr"));
		assert_int_equal(folder_entries(), 2); /* no checkpoint, no temporary file */
		assert_int_equal(remove("a.exr") + remove("whole.exr"), 0);
	}
	kill_at_any_time("cornell --size 128x128 --spp 96 --part 1/2", "1.part", &numbers);
	assert_int_equal(folder_entries(), 1);
	stilb_good("render %s -o whole.exr", lines[0]);
	stilb_good("render %s --part 2/2 -o 2.part", lines[0]);
	stilb_good("render --merge 1.part 2.part -o a.exr");
	assert_true(same_file("a.exr", "whole.exr"));
}

static void interrupt_with(int signal_number)
{
	stilb_start(no_display, -1, SLOW "-o a.png --stats a.json");
	assert_true(catches_interrupts(run.pid));
	kill(run.pid, signal_number);
	program_wait(&run);
	assert_int_equal(run.code, 0);
	assert_said(run.out, "picture: a.png\n");
	assert_said(run.out, "--resume continues it\n");
	assert_true(exists("a.png.checkpoint"));
	read_stats("a.json");
	assert_string_equal(stat_text("end", '"'), "stopped");
	assert_true(stat_int("spp") < 65536);
}

static void test_interrupt(void **state)
{
	(void)state;
	interrupt_with(SIGINT);
}

/* SIGTERM and SIGHUP, as SIGINT, make the run write the picture and a checkpoint; the checkpoint is refused with other
 * settings. */
static void test_other_signals(void **state)
{
	(void)state;
	interrupt_with(SIGTERM);
	interrupt_with(SIGHUP);
	assert_int_equal(stilb_code(no_display, SLOW "-o a.png --resume --seed 3"), 2);
	assert_error_lines(1);
	assert_said(run.err, "seed");
	assert_true(exists("a.png.checkpoint"));
	stilb_image image = load("a.png");
	stilb_image_finish(&image);
}

static void test_checkpoints_that_are_none(void **state)
{
	(void)state;
	assert_int_equal(stilb_code(no_display, SMALL "-o a.png --resume"), 0);
	assert_error_lines(1);
	assert_said(run.err, "starting from the beginning");
	FILE *file = fopen("a.png.checkpoint", "w");
	assert_non_null(file);
	fputs("not a checkpoint", file);
	fclose(file);
	assert_int_equal(stilb_code(no_display, SMALL "-o a.png --resume"), 2);
	assert_error_lines(1);
	assert_said(run.err, "a.png.checkpoint");
	assert_int_equal(stilb_code(no_display, SMALL "-o a.png"), 0); /* without --resume it is not read */
	assert_error_lines(1);
	assert_said(run.err, "--resume");
}

/* A pipe without a writer is refused instead of waited for. */
static void test_pipes_are_no_files(void **state)
{
	(void)state;
	assert_int_equal(mkfifo("a.png.checkpoint", 0666), 0);
	assert_int_equal(stilb_code(no_display, SMALL "-o a.png --resume"), 2);
	assert_error_lines(1);
	assert_said(run.err, "'a.png.checkpoint': it is a device or a pipe");
	assert_int_equal(
		stilb_code(no_display, SMALL "-o b.png --integrator irradiance-cache --cache-load a.png.checkpoint"), 2);
	assert_error_lines(1);
	assert_said(run.err, "--cache-load: cannot read 'a.png.checkpoint': it is a device or a pipe");
	assert_int_equal(folder_entries(), 1);
}

static void touch(const char *path)
{
	FILE *file = fopen(path, "w");
	assert_non_null(file);
	fclose(file);
}

/* The temporary file of a killed run is named after its output, and the next run removes it. */
static void test_what_a_killed_run_left_is_removed(void **state)
{
	(void)state;
	touch("a.exr.12.tmp");
	touch("a.exr.checkpoint.12.tmp");
	touch("a.json.12.tmp");
	assert_int_equal(stilb_code(no_display, SMALL "-o a.exr --resume --stats a.json"), 0);
	assert_true(exists("a.exr") && exists("a.json"));
	assert_int_equal(folder_entries(), 2);
}

static void test_limits(void **state)
{
	(void)state;
	stilb_good("render cornell --size 32x32 --time 0.1 -o a.png --stats a.json");
	read_stats("a.json");
	assert_string_equal(stat_text("end", '"'), "time");
	assert_true(stat_ms("render_s") >= 0.1 && stat_ms("render_s") < 5.0);
	stilb_good("render furnace:0.5 --size 16x16 --error 0.02 -o a.png --stats a.json");
	read_stats("a.json");
	assert_string_equal(stat_text("end", '"'), "error");
}

/* ---- refusals ---------------------------------------------------------------------------------------------------- */

/* Command lines that are refused, and a part of the message. */
typedef struct refusal {
	const char *line, *said;
} refusal;

static const refusal refused[] = {
	{"render", "no scene"},
	{"render -o a.png", "no scene"},
	{"render {} -o a.png", "''"},
	{"render cornell", "no output"},
	{"render cornell -o", "-o: its value is missing"},
	{"render cornell spheres -o a.png", "'spheres' is one word too many"},
	{"render cornell -o a.jpg", "a.jpg"},
	{"render cornell -o missing/a.png", "missing"},
	{"render cornell -o .", "'.'"},
	{"render cornell -o a.png --integrator magic", "irradiance-cache"},
	{"render cornell -o a.png --spp 1 --denoise", "give --spp 2 or more"},
	{"render cornell --preview --denoise", "give -o FILE"},
	{"render cornell -o a.png --show nose", "'nose' is not one of: base, normal, tangent, roughness, metalness"},
	{"render cornell -o a.png --show wireframe", "rays have none; 'stilb view --show wireframe' draws it"},
	{"render cornell -o a.png --show overdraw", "rays have none"},
	{"render cornell -o a.png --show base --integrator path", "leave out --integrator path"},
	{"render cornell -o a.png --sampler halton", "blue-noise"},
	{"render cornell -o a.png --filter mitchell", "blackman-harris"},
	{"render cornell -o a.png --brdf magic", "microfacet"},
	{"render cornell -o a.png --spp 0", "1..65536"},
	{"render cornell -o a.png --spp 65537", "1..65536"},
	{"render cornell -o a.png --size 0x5", "--size"},
	{"render cornell -o a.png --size 16384x16384", "--size: 16384x16384 is 268435456 pixels; at most 67108864"},
	{"render cornell -o a.png --size 70000x1", "1..65536 pixels each way"},
	{"render cornell -o a.png --camera 0,0,1e39,0,0", "'0,0,1e39,0,0' is out of range in number 3"},
	{"render cornell -o a.png --aperture 1e38", "'1e38' is out of range; give a number in 0..1000"},
	{"render cornell -o a.png --time -1", "--time"},
	{"render cornell -o a.png --error 2", "--error"},
	{"render cornell -o a.png --workers 0", "1..256"},
	{"render cornell -o a.png --workers 257", "1..256"},
	{"render cornell -o a.png --isa neon", "avx2"},
	{"render cornell -o a.png --depth 1025", "--depth"},
	{"render cornell -o a.png --camera 1,2,3", "X,Y,Z,YAW,PITCH[,FOV]"},
	{"render cornell -o a.png --camera 1,2,3,4,5,180", "field of view"},
	{"render cornell -o a.png --aperture 0.1", "--focus"},
	{"render cornell -o a.png --focus 3", "--aperture"},
	{"render cornell -o a.png --blades 5", "--aperture"},
	{"render cornell -o a.png --aperture 0.1 --focus 1 --blades 2", "--blades"},
	{"render cornell -o a.png --stats a.png", "two outputs"},
	{"render cornell -o a.png --stats b.json --trace ./b.json", "two outputs"},
	{"render cornell -o a.png --stats a.png.checkpoint", "two outputs"},
	{"render cornell -o a.png --stats missing/a.json", "missing"},
	{"render cornell --preview --resume", "-o FILE"},
	{"render cornell -o a.png --integrator irradiance-cache --cache-load missing.cache", "missing.cache"},
	{"render cornell -o a.png --integrator montecarlo --rays 16 --depth 8", "--force"},
	{"render cornell -o a.png --bogus", "--bogus"},
	{"render cornel -o a.png", "cornel"},
};

/* Errors that are found when the scene is read. */
static const refusal refused_late[] = {
	{"render missing.gltf -o a.png", "missing.gltf"},
	{"render furnace:1 -o a.png", "furnace"},
	{"render furnace:x -o a.png", "furnace"},
	{"render furnace -o a.png", "furnace"},
	{"render cornell -o a.png --environment missing.exr", "missing.exr"},
	{"render cornell -o a.png --environment 1,2", "1,2"},
	{"render cornell -o a.png --environment 1,-2,3", "out of range; give radiances in 0.."},
	{"render cornell -o a.png --environment 1e39,1,1", "out of range; give radiances in 0.."},
	{"render cornell -o a.png --camera 0,0,1e38,0,0", "camera.position[2] is 1e+38; it must be -1e+12 to 1e+12"},
	{"render cornell -o a.png --integrator irradiance-cache --cache-error 0", "cache"},
	{"render cornell -o a.png --integrator irradiance-cache --overture off --cache frozen", "overture"},
	{"render cornell -o a.png --camera 10000000000000,0,0,0,0", "camera.position"},
	{"render cornell -o a.png --integrator irradiance-cache --cache-load /dev/null", "/dev/null"},
};

static void assert_refused(const refusal *refusals, size_t count)
{
	for (size_t i = 0; i < count; i++) {
		int code = stilb_code(no_display, refusals[i].line);
		if (code != 2 || !strstr(run.err, refusals[i].said))
			print_error("stilb %s: %d, %s\n", refusals[i].line, code, run.err);
		assert_int_equal(code, 2);
		assert_error_lines(1);
		assert_said(run.err, refusals[i].said);
		assert_string_equal(run.out, "");
		assert_int_equal(folder_entries(), 0);
	}
}

static void test_refusals(void **state)
{
	(void)state;
	assert_refused(refused, sizeof refused / sizeof *refused);
}

static void test_late_refusals(void **state)
{
	(void)state;
	assert_refused(refused_late, sizeof refused_late / sizeof *refused_late);
}

static void test_an_output_never_replaces_the_scene(void **state)
{
	(void)state;
	FILE *file = fopen("a.obj", "w");
	assert_non_null(file);
	fclose(file);
	assert_int_equal(stilb_code(no_display, "render a.obj -o a.png --stats ./a.obj"), 2);
	assert_said(run.err, "would replace 'a.obj'");
}

/* A flag without effect is reported, and does not end the run. */
static void test_flags_without_use(void **state)
{
	(void)state;
	assert_int_equal(stilb_code(no_display, SMALL "-o a.png --integrator color --depth 3 --cache-rays 64 --denoise"),
	                 0);
	assert_error_lines(3);
	assert_said(run.err, "--denoise is ignored: --integrator color does not use it");
	assert_said(run.err, "--depth is ignored: --integrator color does not use it");
	assert_said(run.err, "--cache-rays is ignored: --integrator color does not use it");
}

/* The sum of all bytes of the picture of the Cornell box with these flags. */
static uint64_t shadowed(const char *flags)
{
	char line[256];
	stilb_image picture;
	uint64_t sum = 0;
	snprintf(line, sizeof line, SMALL "-o s.png %s", flags);
	assert_int_equal(stilb_code(no_display, line), 0);
	assert_int_equal(stilb_image_load("s.png", &picture), STILB_OK);
	for (size_t i = 0; i < stilb_image_size(&picture); i++)
		sum += ((const uint8_t *)picture.pixels)[i];
	stilb_image_finish(&picture);
	return sum;
}

/* Of direct light shadows can be left out; elsewhere a line says that they are not. */
static void test_shadows(void **state)
{
	(void)state;
	uint64_t with = shadowed("--integrator direct"), without = shadowed("--integrator direct --shadows off");
	assert_true(without > with + with / 20);
	assert_true(shadowed("--integrator direct --shadows on") == with);
	assert_null(strstr(run.err, "shadows"));
	uint64_t paths = shadowed("--shadows on");
	assert_null(strstr(run.err, "shadows"));
	assert_true(shadowed("--shadows off") == paths);
	assert_said(run.err, "--shadows off is ignored: only --integrator direct");
	assert_int_equal(stilb_code(no_display, SMALL "-o s.png --no-shadows"), 2);
	assert_int_equal(stilb_code(no_display, SMALL "-o s.png --shadows map"), 2);
}

static void test_dry_run(void **state)
{
	(void)state;
	stilb_good("render cornell --integrator montecarlo --size 10x10 --spp 2 --rays 3 --depth 2 --dry-run");
	assert_said(run.out, "100 pixels, 2 samples a pixel");
	assert_said(run.out, " 2600 rays"); /* 200 samples of 1 + 3 + 9 rays */
	stilb_good("render cornell --integrator montecarlo --rays 1000 --depth 20 --dry-run");
	stilb_good("render cornell --dry-run");
	assert_int_equal(folder_entries(), 0);
}

/* ---- files that cannot be written -------------------------------------------------------------------------------- */

static void test_full_disk(void **state)
{
	(void)state;
	assert_int_equal(stilb_code(no_display, SMALL "-o a.png --stats /dev/full"), 1);
	assert_error_lines(1);
	assert_said(run.err, "/dev/full");
	assert_true(exists("a.png"));
	assert_int_equal(stilb_code(no_display, SMALL "-o c.png --integrator irradiance-cache --cache-save /dev/full"), 1);
	assert_said(run.err, "/dev/full");
	assert_int_equal(remove("c.png"), 0); /* the picture is written although the cache cannot be saved */
	assert_int_equal(stilb_code(no_display, SMALL "-o a.png --trace /dev/full"), 1);
	assert_said(run.err, "/dev/full");

	/* Files are limited to a kilobyte: the old picture stays, and no other file is left. */
	stilb_good(SMALL "-o a.exr");
	assert_int_equal(rename("a.exr", "old.exr"), 0);
	stilb_good(SMALL "-o a.exr --seed 2");
	struct rlimit kilobyte = {1024, RLIM_INFINITY};
	struct rlimit before;
	assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
	signal(SIGXFSZ, SIG_IGN);
	assert_int_equal(setrlimit(RLIMIT_FSIZE, &kilobyte), 0);
	int code = stilb_code(no_display, SMALL "-o a.exr");
	assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
	assert_int_equal(code, 1);
	assert_said(run.err, "a.exr");
	assert_false(same_pixels("a.exr", "old.exr"));
	assert_int_equal(folder_entries(), 3);
}

/* ---- what else it writes ----------------------------------------------------------------------------------------- */

static void test_trace(void **state)
{
	(void)state;
	stilb_good(SMALL "-o a.png --trace a.json --workers 2");
	assert_said(run.out, "trace: a.json\n");
	trace_check_report report;
	trace_check_file("a.json", &report);
	assert_string_equal(report.error, "");
	assert_int_equal(trace_check_zones(&report, "render", "open the scene"), 1);
	assert_int_equal(trace_check_zones(&report, "render", "prepare the scene"), 1);
	assert_int_equal(trace_check_zones(&report, "render", "write the picture"), 1);
	trace_check_finish(&report);
}

static void test_no_display(void **state)
{
	(void)state;
	assert_int_equal(stilb_code(no_display, SMALL "-o a.png --preview"), 0);
	assert_error_lines(1);
	assert_said(run.err, "without a preview");
	assert_true(exists("a.png"));
}

/* In a terminal of 100 columns the progress is a bar, which is cleared at the end. */
static void test_terminal(void **state)
{
	(void)state;
	struct winsize size = {.ws_row = 25, .ws_col = 100};
	int master = posix_openpt(O_RDWR | O_NOCTTY), length = 0;
	static char said[65536];
	assert_true(master >= 0 && grantpt(master) == 0 && unlockpt(master) == 0);
	int terminal = open(ptsname(master), O_RDWR | O_NOCTTY);
	assert_true(terminal >= 0);
	assert_int_equal(ioctl(terminal, TIOCSWINSZ, &size), 0);
	pid_t pid = fork();
	assert_true(pid >= 0);
	if (pid == 0) {
		dup2(terminal, STDERR_FILENO);
		close(terminal);
		close(master);
		dup2(open("words", O_WRONLY | O_CREAT, 0644), STDOUT_FILENO);
		execl(stilb_path, stilb_path, "render", "cornell", "--size", "32x32", "--time", "1.2", "-o", "a.png", NULL);
		_exit(127);
	}
	close(terminal);
	for (ssize_t got; (got = read(master, said + length, sizeof said - 1 - (size_t)length)) > 0;)
		length += (int)got;
	said[length] = '\0';
	close(master);
	int status;
	assert_int_equal(waitpid(pid, &status, 0), pid);
	assert_int_equal(status, 0);
	assert_said(said, "\r[");
	assert_said(said, "#");
	assert_said(said, " %, ");
	assert_said(said, " Mrays/s, ");
	assert_said(said, " left\033[K");
	assert_true(length >= 4 && strcmp(said + length - 4, "\r\033[K") == 0);
}

static void test_help(void **state)
{
	(void)state;
	stilb_good("render --help");
	static const char *const words[] = {"cornell",  "--integrator", "irradiance-cache", "blue-noise", "blackman-harris",
	                                    "--resume", "Ctrl-C"};
	for (size_t i = 0; i < sizeof words / sizeof *words; i++)
		assert_said(run.out, words[i]);
	stilb_good("--help");
	assert_said(run.out, "  render ");
}

/* ---- everything -------------------------------------------------------------------------------------------------- */

static const char *const integrators[] = {"color", "direct",           "ao",     "montecarlo", "path",
                                          "split", "irradiance-cache", "channel"};
#define INTEGRATORS (sizeof integrators / sizeof *integrators)

static void assert_renders(const char *scene, const char *integrator)
{
	stilb_good("render %s --integrator %s --size 32x32 --spp 2 -o a.exr", scene, integrator);
	stilb_image image = load("a.exr");
	if (!(mean(&image, 1) > 0.0 && mean(&image, 1) < 1000.0))
		print_error("%s %s: a mean of %g\n", scene, integrator, mean(&image, 1));
	assert_true(mean(&image, 1) > 0.0 && mean(&image, 1) < 1000.0);
	stilb_image_finish(&image);
}

static void write_text(const char *path, const char *text)
{
	FILE *file = fopen(path, "w");
	assert_non_null(file);
	fputs(text, file);
	assert_int_equal(fclose(file), 0);
}

/* Triangles of area 0 are counted in --stats only; one with a NaN coordinate is reported in a line. */
static void test_triangles_left_out(void **state)
{
	(void)state;
	write_text("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\n");
	assert_int_equal(stilb_code(no_display, "render flat.obj --size 8x8 --spp 1 -o a.png --stats a.json"), 0);
	assert_null(strstr(run.err, "left out"));
	read_stats("a.json");
	assert_int_equal(stat_int("scene.triangles"), 1);
	assert_int_equal(stat_int("scene.flat"), 1);
	assert_int_equal(stat_int("scene.invalid"), 0);
	write_text("nan.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\nf 1 2 3\nf 1 2 4\n");
	assert_int_equal(stilb_code(no_display, "render nan.obj --size 8x8 --spp 1 -o a.png --stats a.json"), 0);
	assert_said(run.err, "nan.obj: triangles with a coordinate that is NaN or infinite are left out: 1 mesh");
	read_stats("a.json");
	assert_int_equal(stat_int("scene.triangles"), 1);
	write_text("far.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1e11 0 1\nf 1 2 3\nf 1 2 4\n");
	assert_int_equal(stilb_code(no_display, "render far.obj --size 8x8 --spp 1 -o a.png --stats a.json"), 0);
	assert_said(run.err, "'far.obj': 1 triangle is left out: a coordinate is NaN");
	read_stats("a.json");
	assert_int_equal(stat_int("scene.invalid"), 1);
}

static void test_every_integrator_and_scene(void **state)
{
	(void)state;
	static const char *const scenes[] = {"cornell", "outdoor", "furnace:0.8", "plane-wall", "stress"};
	for (size_t i = 0; i < INTEGRATORS; i++)
		assert_renders("spheres", integrators[i]);
	for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++)
		assert_renders(scenes[i], "path");
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup(test_it_just_works, folder_fresh),
		cmocka_unit_test_setup(test_interrupt, folder_fresh),
		cmocka_unit_test_setup(test_refusals, folder_fresh),
		cmocka_unit_test_setup(test_pipes_are_no_files, folder_fresh),
		cmocka_unit_test_setup(test_what_a_killed_run_left_is_removed, folder_fresh),
		cmocka_unit_test_setup(test_an_output_never_replaces_the_scene, folder_fresh),
		cmocka_unit_test_setup(test_triangles_left_out, folder_fresh),
		cmocka_unit_test_setup(test_dry_run, folder_fresh),
		cmocka_unit_test_setup(test_help, folder_fresh),
	};
	const struct CMUnitTest slow[] = {
		cmocka_unit_test_setup(test_png_is_what_one_sees, folder_fresh),
		cmocka_unit_test_setup(test_same_bits_from_any_workers, folder_fresh),
		cmocka_unit_test_setup(test_denoise, folder_fresh),
		cmocka_unit_test_setup(test_resume_gives_the_same_bits, folder_fresh),
		cmocka_unit_test_setup(test_killed_at_any_time, folder_fresh),
		cmocka_unit_test_setup(test_other_signals, folder_fresh),
		cmocka_unit_test_setup(test_checkpoints_that_are_none, folder_fresh),
		cmocka_unit_test_setup(test_limits, folder_fresh),
		cmocka_unit_test_setup(test_late_refusals, folder_fresh),
		cmocka_unit_test_setup(test_flags_without_use, folder_fresh),
		cmocka_unit_test_setup(test_shadows, folder_fresh),
		cmocka_unit_test_setup(test_full_disk, folder_fresh),
		cmocka_unit_test_setup(test_trace, folder_fresh),
		cmocka_unit_test_setup(test_no_display, folder_fresh),
		cmocka_unit_test_setup(test_terminal, folder_fresh),
		cmocka_unit_test_setup(test_every_integrator_and_scene, folder_fresh),
	};
	if (!folder_enter(argc > 1 ? argv[1] : NULL, "game_render")) {
		fprintf(stderr, "usage: %s PATH-OF-STILB [long]\n", argv[0]);
		return 2;
	}
	if (argc > 2)
		return cmocka_run_group_tests(slow, NULL, folder_leave);
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
