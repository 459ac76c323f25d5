/* Model files through the programs that a user runs: what `stilb render` opens, `stilb view --headless --validate`
 * shows without a message of the validation layer, and one without textures has the radiance of `stilb render
 * --integrator direct --shadows off`, to 1 % of the largest value, silhouettes aside, on Lambert in the light that both
 * give it. What does not open is refused by both with the same line. One file; with STILB_MODELS=all in the environment
 * every file of Debian's package assimp-testmodels, and with STILB_MODELS=FOLDER every one below that folder, a line
 * for each. */
#include "image/image_compare.h"
#include "image/image_layers.h"
#include "support/stilb_program.h"

#include <fts.h>
#include <math.h>
#include <stdlib.h>

#define MODELS "/usr/share/assimp/models"

#define WIDTH 96u
#define HEIGHT 72u
#define FINE 4u    /* points of a frame along a side of a pixel */
#define BOUND 0.01 /* of the largest value, root of the mean square */
/* Pixels whose points differ by more of the largest value are left out, with their neighbours. */
#define SILHOUETTE 0.05f
#define BEND 0.03f  /* of traced normals: of more the pixel counts as a silhouette, too */
#define BRIGHT 6e4f /* more does not fit into the halves of a frame */
#define BLACK 1e-2f /* nothing is brighter, as of metals on Lambert: the comparison would say nothing */
#define SAMPLES "64"
#define MORE_SAMPLES "2048" /* for a file that differs */
#define ENOUGH 20u          /* pixels; fewer are a file that is not compared */

typedef struct picture {
	float value[HEIGHT][WIDTH][3];
	float spread[HEIGHT][WIDTH]; /* view: the largest difference of a pixel's points */
	bool solid[HEIGHT][WIDTH];   /* rendered: one smooth surface fills the pixel */
} picture;

typedef struct outcome {
	bool opens, textured;
	double rms, most; /* of the difference, relative to the largest value; that value */
	uint32_t inside;  /* pixels that were compared */
	uint32_t messages;
} outcome;

static picture viewed, rendered;

static stilb_image_layers *load(const char *path)
{
	stilb_image_layers *layers;
	if (stilb_image_layers_load(path, &layers) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return layers;
}

static const stilb_image_channel *channel(const stilb_image_layers *layers, const char *name)
{
	const stilb_image_channel *found = stilb_image_layers_channel(layers, name);
	assert_non_null(found);
	return found;
}

static void read_viewed(const char *path)
{
	static const char *const names[] = {"R", "G", "B"};
	stilb_image_layers *layers = load(path);
	assert_true(layers->width == WIDTH * FINE && layers->height == HEIGHT * FINE);
	memset(&viewed, 0, sizeof viewed);
	for (int c = 0; c < 3; c++) {
		const stilb_image_channel *from = channel(layers, names[c]);
		for (uint32_t y = 0; y < HEIGHT; y++)
			for (uint32_t x = 0; x < WIDTH; x++) {
				float low = INFINITY, high = -INFINITY, sum = 0.0f;
				for (uint32_t p = 0; p < FINE * FINE; p++) {
					size_t point = (size_t)(y * FINE + p / FINE) * WIDTH * FINE + x * FINE + p % FINE;
					float value = from->values[point * from->stride];
					low = fminf(low, value), high = fmaxf(high, value), sum += value;
				}
				viewed.value[y][x][c] = sum / (FINE * FINE);
				viewed.spread[y][x] = fmaxf(viewed.spread[y][x], high - low);
			}
	}
	stilb_image_layers_finish(layers);
}

static void read_rendered(const char *path)
{
	static const char *const names[] = {"R", "G", "B", "normal.X", "normal.Y", "normal.Z"};
	stilb_image_layers *layers = load(path);
	assert_true(layers->width == WIDTH && layers->height == HEIGHT);
	for (uint32_t y = 0; y < HEIGHT; y++)
		for (uint32_t x = 0; x < WIDTH; x++) {
			float pixel[6];
			for (int c = 0; c < 6; c++) {
				const stilb_image_channel *from = channel(layers, names[c]);
				pixel[c] = from->values[(y * (size_t)WIDTH + x) * from->stride];
			}
			memcpy(rendered.value[y][x], pixel, sizeof rendered.value[y][x]);
			float length = sqrtf(pixel[3] * pixel[3] + pixel[4] * pixel[4] + pixel[5] * pixel[5]);
			rendered.solid[y][x] = length >= 1.0f - BEND; /* of a pixel in part covered it is shorter */
		}
	stilb_image_layers_finish(layers);
}

/* ---- comparing --------------------------------------------------------------------------------------------------- */

/* True if the pixel and those around it show one smooth surface. */
static bool is_inside(uint32_t x, uint32_t y, float most)
{
	bool inside = x > 0 && y > 0 && x + 1 < WIDTH && y + 1 < HEIGHT;
	for (uint32_t v = y - 1; inside && v <= y + 1; v++)
		for (uint32_t u = x - 1; inside && u <= x + 1; u++)
			inside = viewed.spread[v][u] <= SILHOUETTE * most && rendered.solid[v][u];
	return inside;
}

/* The mean of nine pixels, of which rays have a third of the noise of one. */
static double mean_around(const picture *of, uint32_t x, uint32_t y, int c)
{
	double sum = 0.0;
	for (uint32_t v = y - 1; v <= y + 1; v++)
		for (uint32_t u = x - 1; u <= x + 1; u++)
			sum += (double)of->value[v][u][c] / 9.0;
	return sum;
}

static stilb_image made(uint32_t channels, stilb_image_format format)
{
	stilb_image image;
	assert_int_equal(stilb_image_create(&image, WIDTH, HEIGHT, channels, format), STILB_OK);
	return image;
}

static void compare(outcome *result)
{
	stilb_image means[2] = {made(3, STILB_IMAGE_F32_LINEAR), made(3, STILB_IMAGE_F32_LINEAR)};
	stilb_image mask = made(1, STILB_IMAGE_U8_LINEAR);
	stilb_image_comparison apart;
	float most = 0.0f;
	for (uint32_t y = 0; y < HEIGHT; y++)
		for (uint32_t x = 0; x < WIDTH; x++)
			for (int c = 0; rendered.solid[y][x] && c < 3; c++)
				most = fmaxf(most, rendered.value[y][x][c]);
	for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
		uint32_t x = i % WIDTH, y = i / WIDTH;
		if (!is_inside(x, y, most))
			continue;
		((uint8_t *)mask.pixels)[i] = 255;
		for (int c = 0; c < 3; c++) {
			((float *)means[0].pixels)[3 * i + (uint32_t)c] = (float)mean_around(&viewed, x, y, c);
			((float *)means[1].pixels)[3 * i + (uint32_t)c] = (float)mean_around(&rendered, x, y, c);
		}
	}
	assert_int_equal(stilb_image_compare(&means[0], &means[1], &mask, 0.0, &apart), STILB_OK);
	result->inside = (uint32_t)apart.pixels;
	result->most = (double)most;
	result->rms = most > 0.0f ? apart.rms_all / result->most : 0.0;
	stilb_image_finish(&means[0]);
	stilb_image_finish(&means[1]);
	stilb_image_finish(&mask);
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

/* Runs stilb on a file whose name may have blanks. */
static int stilb_on(const char *command, const char *path, const char *const *flags)
{
	const char *words[32] = {stilb_path, command, path};
	size_t count = 3;
	while (*flags)
		words[count++] = *flags++;
	assert_true(count < 32);
	assert_true(program_start(&run, words, no_display, -1));
	program_wait(&run);
	return run.code;
}

static uint32_t said_messages(void)
{
	const char *line = strstr(run.err, "stilb: the validation layer had ");
	return line ? (uint32_t)strtoul(line + strlen("stilb: the validation layer had "), NULL, 10) : 0;
}

static bool has_textures(const char *path)
{
	static const char *const flags[] = {"--quiet", "--json", "i.json", NULL};
	assert_int_equal(stilb_on("info", path, flags), 0);
	read_stats("i.json");
	return json_flat_find(&stats, "textures[0].width");
}

static const char *const view_flags[] = {"--headless",   "--validate", "--size",  "384x288", "--brdf", "lambert",
                                         "--screenshot", "v.exr",      "--quiet", "--msaa",  "1",      "--lod",
                                         "off",          "--shadows",  "off",     NULL};

/* Renders the file; the program's exit code. */
static int render_file(const char *path, const char *samples)
{
	const char *const flags[] = {"--integrator", "direct", "--shadows", "off",     "--size",
	                             "96x72",        "--spp",  samples,     "--brdf",  "lambert",
	                             "-o",           "r.exr",  "--force",   "--quiet", NULL};
	return stilb_on("render", path, flags);
}

static void measure(const char *path, outcome *result)
{
	char refused[PROGRAM_SAID];
	*result = (outcome){0};
	int code = render_file(path, SAMPLES);
	snprintf(refused, sizeof refused, "%s", run.err);
	result->opens = code == 0;
	int again = stilb_on("view", path, view_flags);
	result->messages = said_messages();
	if (code != 0) {
		assert_error_lines(1);
		assert_string_equal(run.err, refused);
		assert_int_equal(again, code);
		return;
	}
	assert_int_equal(again, result->messages > 0 ? 1 : 0);
	result->textured = has_textures(path);
	read_rendered("r.exr");
	read_viewed("v.exr");
	compare(result);
	if (result->rms > BOUND) { /* which may be noise of the rays */
		assert_int_equal(render_file(path, MORE_SAMPLES), 0);
		read_rendered("r.exr");
		compare(result);
	}
}

static bool is_compared(const outcome *result)
{
	return !result->textured && result->inside >= ENOUGH && result->most > (double)BLACK &&
	       result->most < (double)BRIGHT;
}

static bool is_good(const outcome *result)
{
	return result->messages == 0 && (!is_compared(result) || result->rms <= BOUND);
}

static void tell(const char *path, const outcome *result)
{
	printf("%s %.2f %% of %.3g on %u pixels%s%s", path, 100.0 * result->rms, result->most, result->inside,
	       result->textured ? ", textured" : "", is_compared(result) ? "" : ", not compared");
	printf(result->messages ? ", %u messages\n" : "\n", result->messages);
	fflush(stdout);
}

static void a_model_looks_as_rendered(void **state)
{
	(void)state;
	outcome result;
	measure(MODELS "/OFF/Wuson.off", &result);
	tell(MODELS "/OFF/Wuson.off", &result);
	assert_true(is_compared(&result) && is_good(&result));
}

static void all_models_look_as_rendered(void **state)
{
	(void)state;
	const char *wanted = getenv("STILB_MODELS");
	char *roots[] = {(char *)(strcmp(wanted, "all") == 0 ? MODELS : wanted), NULL};
	FTS *walk = fts_open(roots, FTS_PHYSICAL | FTS_NOCHDIR, NULL);
	uint32_t files = 0, opened = 0, compared = 0, bad = 0;
	assert_non_null(walk);
	for (FTSENT *entry; (entry = fts_read(walk));) {
		outcome result;
		if (entry->fts_info != FTS_F)
			continue;
		measure(entry->fts_path, &result);
		files++;
		if (!result.opens)
			continue;
		opened++;
		compared += is_compared(&result);
		bad += !is_good(&result);
		tell(entry->fts_path, &result);
	}
	fts_close(walk);
	printf("%u files, %u open, %u compared, %u differ or have messages\n", files, opened, compared, bad);
	assert_true(opened > 0 && bad == 0);
}

int main(int argc, char **argv)
{
	const struct CMUnitTest few[] = {cmocka_unit_test_setup(a_model_looks_as_rendered, folder_fresh)};
	const struct CMUnitTest all[] = {cmocka_unit_test_setup(all_models_look_as_rendered, folder_fresh)};
	if (access(MODELS, R_OK) != 0) {
		printf("skipped: no " MODELS "; install assimp-testmodels\n");
		return 77;
	}
	if (!folder_enter(argc > 1 ? argv[1] : NULL, "game_models")) {
		fprintf(stderr, "usage: %s PATH-OF-STILB\n", argv[0]);
		return 2;
	}
	return getenv("STILB_MODELS") ? cmocka_run_group_tests_name("all models", all, NULL, folder_leave)
	                              : cmocka_run_group_tests(few, NULL, folder_leave);
}
