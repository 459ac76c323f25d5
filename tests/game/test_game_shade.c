/* stilb shade: plots, spheres, the table, refusals. A script of this test stands in for gnuplot and keeps its input;
 * with the argument "gnuplot" the real one draws every plot. With the argument "long" the tests that take seconds. */
#include "image/image.h"
#include "support/stilb_program.h"

#include <math.h>
#include <sys/resource.h>

/* ---- gnuplot ----------------------------------------------------------------------------------------------------- */

static char path_here[PATH_MAX + 16];
static const char *const with_fake[] = {NO_DISPLAY, path_here, NULL};
static const char *const without_gnuplot[] = {NO_DISPLAY, "PATH=/nonexistent", NULL};

/* Installs a gnuplot that copies its script to the file `script`, and writes a few bytes as the picture. */
static void make_gnuplot(const char *last_line)
{
	FILE *file = fopen("gnuplot", "w");
	assert_non_null(file);
	fprintf(file,
	        "#!/bin/sh\n[ \"$1\" = --version ] && exit 0\n/bin/cp \"$1\" script\n"
	        "out=$(/bin/sed -n \"s/^set output '\\(.*\\)'$/\\1/p\" \"$1\")\necho drawn > \"$out\"\n%s\n",
	        last_line);
	assert_int_equal(fclose(file), 0);
	assert_int_equal(chmod("gnuplot", 0755), 0);
	snprintf(path_here, sizeof path_here, "PATH=%s", stilb_folder);
}

static char text[1 << 20];

static const char *read_text(const char *path)
{
	FILE *file = fopen(path, "r");
	if (!file)
		print_error("no file '%s'\n", path);
	assert_non_null(file);
	text[fread(text, 1, sizeof text - 1, file)] = '\0';
	fclose(file);
	return text;
}

static bool exists(const char *path)
{
	return access(path, F_OK) == 0;
}

/* ---- plots ------------------------------------------------------------------------------------------------------- */

static void test_plot(void **state)
{
	(void)state;
	make_gnuplot("");
	assert_int_equal(stilb_code(with_fake, "shade plot lambert -o lambert.svg"), 0);
	assert_string_equal(run.err, "");
	assert_string_equal(run.out, "picture: lambert.svg\n");
	assert_string_equal(read_text("lambert.svg"), "drawn\n");
	assert_said(read_text("script"), "set terminal svg ");
	assert_said(text, "f n·l for light at 45");
	/* Lambert's albedo is 1 at every angle: a straight line, for which two points are enough. */
	assert_said(text, "\n0 1\n89 1\nEND\n");
	assert_int_equal(stilb_code(with_fake, "shade plot -o a.png ggx_smith_ggx"), 0);
	assert_said(read_text("script"), "set terminal pngcairo ");
	assert_said(text, "roughness 0.3");
}

/* Only points on straight lines are left out: of the 121 points of a metal's Fresnel term those around its dip stay. */
static void test_plot_points(void **state)
{
	(void)state;
	make_gnuplot("");
	assert_int_equal(stilb_code(with_fake, "shade plot fresnel -o a.svg"), 0);
	const char *at = strstr(read_text("script"), "$block7 << END\n");
	assert_non_null(at);
	int count = 0;
	double x, y, last = -1.0, least = 1.0;
	for (at = strchr(at, '\n') + 1; sscanf(at, "%lf %lf", &x, &y) == 2; at = strchr(at, '\n') + 1) {
		assert_true(x > last);
		last = x;
		least = fmin(least, y);
		count++;
	}
	assert_true(last == 90.0);
	assert_true(fabs(least - 0.4947) < 0.0005); /* at 87 degrees */
	assert_in_range(count, 20, 60);
}

/* Copies the points of the curve of this number, from 1, out of the script; returns their number. */
static int points_of(int number, double points[][2], int room)
{
	char name[32];
	snprintf(name, sizeof name, "$block%d << END\n", number);
	const char *at = strstr(read_text("script"), name);
	assert_non_null(at);
	int count = 0;
	for (at = strchr(at, '\n') + 1; count < room && sscanf(at, "%lf %lf", &points[count][0], &points[count][1]) == 2;
	     at = strchr(at, '\n') + 1)
		count++;
	return count;
}

static void assert_point(const double point[2], double x, double y)
{
	if (fabs(point[0] - x) > 1e-5 * fabs(x) || fabs(point[1] - y) > 1e-5 * fabs(y))
		fail_msg("%g %g instead of %g %g", point[0], point[1], x, y);
}

/* A curve has a point where it bends: 0.6 diffuse and over 0.4 specular reflectance are limited to a sum of one. */
static void test_plot_corner(void **state)
{
	(void)state;
	static const double bends[3] = {0.6, 0.4, 1.0}; /* at 0.4: diffuse, specular and their sum */
	make_gnuplot("");
	assert_int_equal(stilb_code(with_fake, "shade plot limit-to-one -o a.svg"), 0);
	for (int curve = 0; curve < 3; curve++) {
		double points[101][2];
		int count = points_of(curve + 1, points, 101);
		assert_true(count >= 3);
		assert_point(points[1], 0.4, bends[curve]); /* straight up to there */
		assert_point(points[count - 1], 1.0, (const double[]){0.375, 0.625, 1.0}[curve]);
	}
}

/* The integral of exp(λ (cos - 1)) over the sphere, 2π (1 - exp(-2λ)) / λ, and the amplitude that makes it 1. */
static void test_plot_integrals(void **state)
{
	(void)state;
	double points[101][2];
	make_gnuplot("");
	assert_int_equal(stilb_code(with_fake, "shade plot sg-integrals -o a.svg"), 0);
	for (int curve = 1; curve <= 2; curve++) {
		int count = points_of(curve, points, 101);
		assert_true(count >= 2);
		for (int i = 0; i < count; i++) {
			double x = points[i][0], integral = -2.0 * M_PI * expm1(-2.0 * x) / x;
			assert_point(points[i], x, curve == 1 ? integral : 1.0 / integral);
		}
	}
}

/* The page of all samplers has a panel for each that draws directions. */
static void test_plot_samplers(void **state)
{
	(void)state;
	make_gnuplot("");
	assert_int_equal(stilb_code(with_fake, "shade plot samplers -o a.svg"), 0);
	assert_said(read_text("script"), "set title \"ggx-visible\"");
	assert_null(strstr(text, "set title \"stratified\"")); /* it moves numbers, and has a plot of its own */
}

/* An .svg has the title of its plot, and no empty groups. */
static void test_plot_svg(void **state)
{
	(void)state;
	make_gnuplot("printf '<title>Gnuplot</title>\\n<g a>\\n</g>\\n<g b>\\n<path/>\\n</g>\\n<g c>\\n' >\"$out\"");
	assert_int_equal(stilb_code(with_fake, "shade plot fresnel -o a.svg"), 0);
	assert_string_equal(read_text("a.svg"), "<title>Fresnel</title>\n<g b>\n<path/>\n</g>\n<g c>\n");
}

/* The curves of all plots are finite numbers, and every plot draws something. */
static void test_all_plots(void **state)
{
	(void)state;
	make_gnuplot("");
	assert_int_equal(stilb_code(with_fake, "shade list"), 0);
	char *list = strdup(run.out), *rest = NULL;
	int plots = 0;
	for (char *line = strtok_r(list, "\n", &rest); line; line = strtok_r(NULL, "\n", &rest)) {
		char name[64], words[160];
		if (line[0] != ' ' || sscanf(line, " %63s", name) != 1)
			continue;
		plots++;
		if (strstr(name, "-neumann") || strstr(name, "-kelemen") || strstr(name, "-schlick-"))
			continue; /* drawn by the same functions as the other pairs of D and G */
		snprintf(words, sizeof words, "shade plot %s -o %s.svg", name, name);
		int code = stilb_code(with_fake, words);
		if (code != 0)
			print_error("%s: %s\n", words, run.err);
		assert_int_equal(code, 0);
		read_text("script");
		/* A NaN would be an empty line. */
		if (strstr(text, "\n\n") || !strstr(text, "\nplot "))
			print_error("%s: no numbers, or nothing is drawn\n", name);
		assert_null(strstr(text, "\n\n"));
		assert_non_null(strstr(text, "\nplot "));
	}
	free(list);
	assert_in_range(plots, 80, 200);
}

static void test_plot_failures(void **state)
{
	(void)state;
	assert_int_equal(stilb_code(without_gnuplot, "shade plot ggx-smith-ggx -o a.svg"), 2);
	assert_error_lines(1);
	assert_said(run.err, "gnuplot-nox");
	make_gnuplot("exit 1");
	assert_int_equal(stilb_code(with_fake, "shade plot ggx-smith-ggx -o a.svg"), 1);
	assert_error_lines(1);
	assert_said(run.err, "'a.svg'");
	assert_false(exists("a.svg"));
}

static void test_catalog(void **state)
{
	(void)state;
	assert_int_equal(stilb_code(without_gnuplot, "shade catalog -o all"), 2);
	assert_said(run.err, "gnuplot-nox");
	make_gnuplot("");
	assert_int_equal(stilb_code(with_fake, "shade catalog -o missing/all"), 2);
	assert_error_lines(1);
	assert_said(run.err, "'missing/all'");
	assert_false(exists("all"));
}

/* ---- spheres ----------------------------------------------------------------------------------------------------- */

#define SIZE "659x454" /* pixels; in the strip `classic` a cell, the square around a sphere, is then 50 wide */

/* The centre of a sphere, in pixels, in the strip `classic` at the size SIZE, by the layout in shade_strip.c. */
static void middle(int row, int column, int *x, int *y)
{
	double cell = 50.0, left = 0.5 * (659.0 - cell * 13.17);
	*x = (int)(left + cell * (2.05 + column + 0.5));
	*y = (int)(cell * (0.42 + row * 1.22 + 0.5));
}

static double radiance(const stilb_image *picture, int row, int column, int dx, int dy, int channel)
{
	int x, y;
	middle(row, column, &x, &y);
	return (double)((const float *)
	                    picture->pixels)[3 * ((size_t)(y + dy) * picture->width + (size_t)(x + dx)) + (size_t)channel];
}

/* The largest green radiance of the pixels of a sphere. */
static double brightest(const stilb_image *picture, int row, int column)
{
	double most = 0.0;
	for (int dy = -16; dy <= 16; dy++)
		for (int dx = -16; dx <= 16; dx++)
			most = fmax(most, radiance(picture, row, column, dx, dy, 1));
	return most;
}

enum { METAL, OLD, NORMALISED, WRAPPED_OLD, WRAPPED, MIXED_OLD, MIXED };

/* Pictures are written in 300 MB of address space: OpenImageIO, which would need more and abort, is not loaded. */
static void test_spheres_in_little_memory(void **state)
{
	(void)state;
	struct rlimit before;
	if (TEST_ASAN)
		return; /* sanitizers need terabytes of address space */
	assert_int_equal(getrlimit(RLIMIT_AS, &before), 0);
	setrlimit(RLIMIT_AS, &(struct rlimit){300u << 20, before.rlim_max});
	int code = stilb_code(no_display, "shade spheres --size " SIZE " -o little.png");
	setrlimit(RLIMIT_AS, &before);
	if (code != 0)
		fail_msg("exit %d: %s", code, run.err);
	assert_true(exists("little.png"));
}

static void test_spheres(void **state)
{
	(void)state;
	stilb_image picture;
	stilb_good("shade spheres --size " SIZE " -o spheres.exr");
	assert_int_equal(stilb_image_load("spheres.exr", &picture), STILB_OK);
	assert_int_equal(picture.width, 659);
	assert_int_equal(picture.channels, 3);
	for (int column = 0; column <= 10; column++) {
		/* The earlier wrapped diffuse is brighter by the factor 1 + w everywhere. */
		double wrap = 0.1 * column, share = radiance(&picture, WRAPPED_OLD, column, -6, -8, 0) /
		                                    radiance(&picture, WRAPPED, column, -6, -8, 0);
		assert_true(fabs(share - (1.0 + wrap)) < 1e-4);
		/* The limited sum is darker than the one without a limit, and equal where the sum is at most 1. */
		double limited = radiance(&picture, MIXED, column, 5, 5, 0),
			   unlimited = radiance(&picture, MIXED_OLD, column, 5, 5, 0);
		assert_true(column == 0 ? limited == unlimited : limited < unlimited);
	}
	/* Normalised highlights are brighter the smaller they are; without the factor they are not. */
	assert_true(brightest(&picture, NORMALISED, 2) > 4.0 * brightest(&picture, NORMALISED, 6));
	assert_true(brightest(&picture, OLD, 2) < 1.01 * brightest(&picture, OLD, 6));
	assert_true(fabs(brightest(&picture, OLD, 10) / brightest(&picture, NORMALISED, 10) - 1.0) < 1e-4);
	/* Gold reflects more red than blue. */
	assert_true(radiance(&picture, METAL, 10, 0, 0, 0) > radiance(&picture, METAL, 10, 0, 0, 1));
	assert_true(radiance(&picture, METAL, 10, 0, 0, 1) > radiance(&picture, METAL, 10, 0, 0, 2));
	stilb_image_finish(&picture);
}

/* The irradiance of a sun alone is negative on the dark side if it is computed with three bands of spherical harmonics,
 * which is shown in magenta; with windowed bands it is not. */
static void test_spheres_negative(void **state)
{
	(void)state;
	stilb_image picture;
	int negative[4] = {0};
	stilb_good("shade spheres --strip harmonics --size 659x271 -o spheres.exr");
	assert_int_equal(stilb_image_load("spheres.exr", &picture), STILB_OK);
	for (int row = 0; row < 4; row++)
		for (int dy = -20; dy <= 20; dy++)
			for (int dx = -20; dx <= 20; dx++)
				negative[row] +=
					radiance(&picture, row, 10, dx, dy, 2) > 2.0 * radiance(&picture, row, 10, dx, dy, 1) &&
					radiance(&picture, row, 10, dx, dy, 0) > 0.5;
	assert_true(negative[1] > 50);
	assert_int_equal(negative[0] + negative[2] + negative[3], 0);
	stilb_image_finish(&picture);
}

/* The same picture from any number of workers. */
static void test_spheres_workers(void **state)
{
	(void)state;
	static const char *const strips[] = {"classic", "filter"};
	for (size_t i = 0; i < sizeof strips / sizeof *strips; i++) {
		stilb_image pictures[2];
		for (int k = 0; k < 2; k++) {
			stilb_good("shade spheres --strip %s --size 100x80 --workers %d -o spheres.png", strips[i], 3 * k);
			assert_int_equal(stilb_image_load("spheres.png", &pictures[k]), STILB_OK);
		}
		assert_int_equal(stilb_image_size(&pictures[1]), stilb_image_size(&pictures[0]));
		assert_memory_equal(pictures[1].pixels, pictures[0].pixels, stilb_image_size(&pictures[0]));
		for (int k = 0; k < 2; k++)
			stilb_image_finish(&pictures[k]);
	}
}

/* Every strip draws something brighter than its backdrop. */
static void test_strips(void **state)
{
	(void)state;
	static const char *const strips[] = {"models", "distributions", "bump", "lights", "tonemap"};
	for (size_t i = 0; i < sizeof strips / sizeof *strips; i++) {
		stilb_image picture;
		stilb_good("shade spheres --strip %s --size 100x80 -o spheres.png", strips[i]);
		assert_int_equal(stilb_image_load("spheres.png", &picture), STILB_OK);
		int bright = 0;
		for (size_t k = 0; k < stilb_image_size(&picture); k++)
			bright += ((const uint8_t *)picture.pixels)[k] > 100;
		assert_true(bright > 200);
		stilb_image_finish(&picture);
	}
}

/* Captions are drawn at the usual size, and left out where they would be too small to read. */
static void test_spheres_words(void **state)
{
	(void)state;
	static const char *const sizes[] = {"716x295", "200x84"};
	for (int i = 0; i < 2; i++) {
		stilb_image picture;
		stilb_good("shade spheres --strip harmonics --size %s -o words.png", sizes[i]);
		assert_int_equal(stilb_image_load("words.png", &picture), STILB_OK);
		int bright = 0;
		for (uint32_t y = 0; y < picture.height; y++)
			for (uint32_t x = 0; x < picture.width / 8; x++) /* left of all spheres */
				bright += ((const uint8_t *)picture.pixels)[3 * ((size_t)y * picture.width + x)] > 180;
		assert_true(i == 0 ? bright > 100 : bright == 0);
		stilb_image_finish(&picture);
	}
}

/* ---- table ------------------------------------------------------------------------------------------------------- */

static void test_table(void **state)
{
	(void)state;
	stilb_good("shade table -o table.md");
	read_text("table.md");
	assert_said(text, "| `ggx_smith_beckmann` | ");
	assert_said(text, "| 1.00000 | **no** | yes | 1.616 |");
	assert_said(text, "| `sample_ggx_visible` | ");
	/* D x G x F: 3 x 32 lines; only Smith-Beckmann's G has an albedo above 1. */
	int lines = 0, gains = 0;
	char *rest = NULL;
	char *at = strstr(text, "## Albedo of D x G x F");
	assert_non_null(at);
	for (char *line = strtok_r(at, "\n", &rest); line; line = strtok_r(NULL, "\n", &rest)) {
		if (strncmp(line, "| `", 3) != 0)
			continue;
		lines++;
		if (strstr(line, "**")) {
			gains++;
			assert_said(line, "`smith_beckmann`");
		}
	}
	assert_int_equal(lines, 3 * 32);
	assert_int_equal(gains, 3);
}

/* ---- refused ----------------------------------------------------------------------------------------------------- */

static const char *const refusals[][2] = {
	{"shade", "no part; "},
	{"shade lobes", "'lobes'"},
	{"shade plot -o a.svg", "stilb shade plot NAME -o FILE"},
	{"shade plot gxg -o a.svg", "'gxg'"},
	{"shade plot -o a.svg fresnl", "similar: fresnel;"},
	{"shade plot Fresnel -o a.svg", "similar: fresnel;"},
	{"shade plot smith_ggx -o a.svg", "similar: blinn-smith-ggx, beckmann-smith-ggx, ggx-smith-ggx,"},
	{"shade plot ggx -o a.svg", "ggx-smith-beckmann, ggx-smith-ggx;"},
	{"shade plot gxg -o a.svg", "'stilb shade list' lists the names"},
	{"shade plot fresnel a.svg", "the picture is -o FILE"},
	{"shade plot ggx-smith-ggx", "FILE.svg or FILE.png"},
	{"shade plot ggx-smith-ggx -o a.pdf", "'a.pdf'"},
	{"shade plot ggx-smith-ggx -o missing/a.svg", "missing"},
	{"shade plot ggx-smith-ggx -o a.svg --dpi 3", "'--dpi'"},
	{"shade list all", "'all'"},
	{"shade spheres", "-o FILE.png"},
	{"shade spheres -o a.gif", "a.gif"},
	{"shade spheres -o missing/a.png", "missing"},
	{"shade spheres -o a.png --strip cubes",
     "classic, models, distributions, bump, lights, harmonics, tonemap, filter"},
	{"shade spheres -o a.png --size 0x10", "1..16384"},
	{"shade spheres -o a.png --workers 257", "0..256"},
	{"shade table -o missing/a.md", "missing"},
	{"shade table extra", "'extra'"},
	{"shade catalog", "-o FOLDER"},
};

static void test_refusals(void **state)
{
	(void)state;
	make_gnuplot("");
	int entries = folder_entries();
	for (size_t i = 0; i < sizeof refusals / sizeof *refusals; i++) {
		int code = stilb_code(with_fake, refusals[i][0]);
		if (code != 2 || !strstr(run.err, refusals[i][1]))
			print_error("stilb %s: %d %s", refusals[i][0], code, run.err);
		assert_int_equal(code, 2);
		assert_string_equal(run.out, "");
		assert_error_lines(1);
		assert_said(run.err, refusals[i][1]);
		assert_int_equal(folder_entries(), entries); /* no new file */
	}
}

static void test_help(void **state)
{
	(void)state;
	static const char *const parts[][2] = {
		{"", "spheres"},       {"list ", "stilb shade plot"}, {"plot ", "-o FILE"},
		{"table ", "-o FILE"}, {"spheres ", "--strip NAME"},  {"catalog ", "-o FOLDER"}};
	for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
		stilb_good("shade %s--help", parts[i][0]);
		assert_said(run.out, parts[i][1]);
	}
}

static void test_full_disk(void **state)
{
	(void)state;
	make_gnuplot("");
	int full = open("/dev/full", O_WRONLY | O_CLOEXEC);
	stilb_start(with_fake, full, "shade list");
	program_wait(&run);
	close(full);
	assert_int_equal(run.code, 1);
	assert_error_lines(1);
}

/* ---- the real gnuplot -------------------------------------------------------------------------------------------- */

static void test_real_gnuplot(void **state)
{
	(void)state;
	assert_int_equal(stilb_code(no_display, "shade list"), 0);
	char *list = strdup(run.out), *rest = NULL;
	for (char *line = strtok_r(list, "\n", &rest); line; line = strtok_r(NULL, "\n", &rest)) {
		char name[64];
		if (line[0] != ' ' || sscanf(line, " %63s", name) != 1)
			continue;
		stilb_good("shade plot %s -o %s.svg", name, name); /* gnuplot prints no warning */
		char path[80];
		snprintf(path, sizeof path, "%s.svg", name);
		assert_said(read_text(path), "</svg>");
	}
	free(list);
	stilb_good("shade plot fresnel -o fresnel.png");
	stilb_image picture;
	assert_int_equal(stilb_image_load("fresnel.png", &picture), STILB_OK);
	assert_int_equal(picture.width, 1040);
	stilb_image_finish(&picture);
}

static int run_real_gnuplot(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test_setup(test_real_gnuplot, folder_fresh)};
	if (system("gnuplot --version >/dev/null 2>&1") != 0) {
		folder_leave(NULL);
		printf("skipped: gnuplot is not installed (Debian package gnuplot-nox)\n");
		return 77;
	}
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}

/* Tests that take seconds. */
static int run_long(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup(test_all_plots, folder_fresh),
		cmocka_unit_test_setup(test_strips, folder_fresh),
		cmocka_unit_test_setup(test_table, folder_fresh),
	};
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup(test_help, folder_fresh),
		cmocka_unit_test_setup(test_plot, folder_fresh),
		cmocka_unit_test_setup(test_plot_points, folder_fresh),
		cmocka_unit_test_setup(test_plot_corner, folder_fresh),
		cmocka_unit_test_setup(test_plot_integrals, folder_fresh),
		cmocka_unit_test_setup(test_plot_samplers, folder_fresh),
		cmocka_unit_test_setup(test_plot_svg, folder_fresh),
		cmocka_unit_test_setup(test_plot_failures, folder_fresh),
		cmocka_unit_test_setup(test_catalog, folder_fresh),
		cmocka_unit_test_setup(test_spheres, folder_fresh),
		cmocka_unit_test_setup(test_spheres_in_little_memory, folder_fresh),
		cmocka_unit_test_setup(test_spheres_negative, folder_fresh),
		cmocka_unit_test_setup(test_spheres_workers, folder_fresh),
		cmocka_unit_test_setup(test_spheres_words, folder_fresh),
		cmocka_unit_test_setup(test_refusals, folder_fresh),
		cmocka_unit_test_setup(test_full_disk, folder_fresh),
	};
	if (!folder_enter(argc > 1 ? argv[1] : NULL, "test_game_shade"))
		return 1;
	if (argc > 2 && strcmp(argv[2], "gnuplot") == 0)
		return run_real_gnuplot();
	if (argc > 2 && strcmp(argv[2], "long") == 0)
		return run_long();
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
