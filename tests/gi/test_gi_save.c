/* Renders as files: every layer in the .exr as it is in the film, the picture in the .png as on a display. */
#include "gi_render_fixture.h"
#include "support/folder.h"

#include "image/image_layers.h"
#include "shading/shade_tonemap.h"

#include <math.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>

static const char exr[] = "a.exr", png[] = "a.png";

static int tear_down(void **state)
{
	(void)state;
	remove(exr);
	remove(png);
	return folder_remove();
}

static void saved(stilb_gi_render *render, const char *path)
{
	if (stilb_gi_render_save(render, path) != STILB_OK)
		fail_msg("%s", stilb_error_message());
}

static stilb_image_layers *loaded(const char *path)
{
	stilb_image_layers *layers;
	if (stilb_image_layers_load(path, &layers) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return layers;
}

/* The file's channel is number c of each pixel's `stride` numbers in the plane, bit by bit. */
static void holds(const stilb_image_layers *layers, const char *name, const float *plane, size_t stride)
{
	const stilb_image_channel *channel = stilb_image_layers_channel(layers, name);
	if (!channel)
		fail_msg("there is no channel %s", name);
	for (size_t i = 0; i < (size_t)layers->width * layers->height; i++)
		assert_memory_equal(&channel->values[i * channel->stride], &plane[i * stride], sizeof *plane);
}

static void every_layer(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 1);
	stilb_gi_settings settings = render_fixture_settings(&fixture);
	settings.camera.yaw = 0.7f; /* past the box too: nothing is hit there */
	settings.lens.radius = 0.1f;
	stilb_gi_render *render = render_fixture_create(&fixture, &settings);
	assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	saved(render, exr);
	stilb_gi_film film = stilb_gi_render_film(render);
	stilb_image_layers *layers = loaded(exr);
	assert_int_equal(layers->width, film.width);
	assert_int_equal(layers->height, film.height);
	assert_int_equal(layers->channel_count, 14);
	static const char *const names[4][3] = {{"R", "G", "B"},
	                                        {"albedo.R", "albedo.G", "albedo.B"},
	                                        {"normal.X", "normal.Y", "normal.Z"},
	                                        {"variance.R", "variance.G", "variance.B"}};
	const float *planes[4] = {film.radiance, film.albedo, film.normal, film.variance};
	for (int layer = 0; layer < 4; layer++) {
		for (int c = 0; c < 3; c++)
			holds(layers, names[layer][c], planes[layer] + c, 3);
	}
	holds(layers, "depth.Z", film.depth, 1);
	const stilb_image_channel *samples = stilb_image_layers_channel(layers, "samples");
	assert_true(samples->values[0] == (float)settings.samples);
	bool missed = false;
	for (size_t i = 0; i < (size_t)film.width * film.height; i++)
		missed |= isinf(film.depth[i]) != 0;
	assert_true(missed);
	stilb_image_layers_finish(layers);
	stilb_gi_render_destroy(render);
	render_fixture_finish(&fixture);
}

/* The file of a denoised picture has it as its radiance, denoised when it is saved, and the other layers unchanged. */
static void denoised(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 0);
	stilb_gi_settings settings = render_fixture_settings(&fixture);
	settings.denoise = true;
	stilb_gi_render *render = render_fixture_create(&fixture, &settings);
	assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	saved(render, exr);
	stilb_gi_film film = stilb_gi_render_film(render);
	assert_non_null(film.denoised);
	assert_memory_not_equal(film.denoised, film.radiance, sizeof(float[3]) * film.width * film.height);
	stilb_image_layers *layers = loaded(exr);
	for (int c = 0; c < 3; c++) {
		holds(layers, (const char *[]){"R", "G", "B"}[c], film.denoised + c, 3);
		holds(layers, (const char *[]){"variance.R", "variance.G", "variance.B"}[c], film.variance + c, 3);
	}
	stilb_image_layers_finish(layers);
	stilb_gi_render_destroy(render);
	render_fixture_finish(&fixture);
}

static void says(const stilb_image_layers *layers, const char *name, const char *text)
{
	const char *found = stilb_image_layers_attribute(layers, name);
	assert_non_null(found);
	assert_string_equal(found, text);
}

static void every_setting(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 0);
	stilb_gi_settings settings = render_fixture_settings(&fixture);
	settings.integrator = STILB_GI_INTEGRATOR_AO;
	settings.firefly_weight = settings.denoise = true;
	settings.lens.radius = 0.1f;
	settings.seed = 12345678901234567890u;
	stilb_gi_render *render = render_fixture_create(&fixture, &settings);
	saved(render, exr);
	stilb_image_layers *layers = loaded(exr);
	says(layers, "stilb:integrator", "ao");
	says(layers, "stilb:firefly_weight", "yes");
	says(layers, "stilb:denoise", "yes");
	says(layers, "stilb:width", "37");
	says(layers, "stilb:samples", "6");
	says(layers, "stilb:seed", "12345678901234567890");
	says(layers, "stilb:isa", stilb_gi_scene_info_of(fixture.gi)->isa);
	assert_true(strtof(stilb_image_layers_attribute(layers, "stilb:lens.radius"), NULL) == 0.1f);
	assert_null(stilb_image_layers_attribute(layers, "stilb:progressive"));
	assert_null(stilb_image_layers_attribute(layers, "stilb:exposure")); /* the light is the same with any */
	says(layers, "stilb:environment", "0,0,0");
	assert_non_null(stilb_image_layers_attribute(layers, "Software"));
	stilb_image_layers_finish(layers);
	stilb_gi_render_destroy(render);
	render_fixture_finish(&fixture);
}

static size_t read_file(const char *path, unsigned char *data, size_t size)
{
	FILE *file = fopen(path, "rb");
	assert_non_null(file);
	size_t got = fread(data, 1, size, file);
	fclose(file);
	return got;
}

/* The same bytes, whatever the order of its pixels was. */
static void same_picture_same_file(void **state)
{
	(void)state;
	static unsigned char files[2][400000];
	size_t sizes[2];
	for (uint32_t i = 0; i < 2; i++) {
		render_fixture fixture = render_fixture_make("cornell", i);
		stilb_gi_settings settings = render_fixture_settings(&fixture);
		settings.progressive = i;
		stilb_gi_render *render = render_fixture_create(&fixture, &settings);
		assert_int_equal(stilb_gi_render_run(render), STILB_OK);
		saved(render, exr);
		sizes[i] = read_file(exr, files[i], sizeof files[i]);
		stilb_gi_render_destroy(render);
		render_fixture_finish(&fixture);
	}
	assert_in_range(sizes[0], 1000, sizeof files[0] - 1);
	assert_int_equal(sizes[0], sizes[1]);
	assert_memory_equal(files[0], files[1], sizes[0]);
}

/* Linear to 0.6, then below 1; two stops are four times the light. */
static void display(void **state)
{
	(void)state;
	const float rgb[][3] = {{0.0f, 0.0f, 0.0f}, {0.125f, 0.05f, 0.01f}, {1e30f, 0.0f, NAN}, {-1.0f, INFINITY, 0.1f}};
	uint8_t plain[4][3], bright[4][3];
	stilb_gi_display(rgb[0], 4, 0.0f, SHADE_TONE_KNEE, plain[0]);
	stilb_gi_display(rgb[0], 4, 2.0f, SHADE_TONE_KNEE, bright[0]);
	assert_true(plain[0][0] == 0 && plain[0][2] == 0);
	assert_int_equal(plain[1][0], 99); /* sRGB codes of the numbers themselves */
	assert_int_equal(plain[1][1], 63);
	assert_int_equal(plain[1][2], 25);
	assert_int_equal(bright[1][0], 188);
	assert_int_equal(bright[1][1], 124);
	assert_int_equal(bright[1][2], 56);
	assert_true(plain[2][0] == 255 && plain[2][1] == 0 && plain[2][2] == 0);
	assert_true(plain[3][0] == 0 && plain[3][1] == 255);
}

static void swap_channels(const void *user, const float code[3], float out[3])
{
	(void)user;
	for (int c = 0; c < 3; c++)
		out[c] = 0.5f * code[2 - c];
}

/* Codes go through the grade; dither adds up to a code and keeps the mean. shown: the picture without. */
static void graded(stilb_gi_render *render, const uint8_t *shown, size_t size)
{
	stilb_image images[2];
	double sums[2] = {0.0, 0.0};
	for (uint32_t d = 0; d < 2; d++) {
		stilb_gi_grade grade = {.at = swap_channels, .dither = d == 1};
		assert_int_equal(stilb_gi_render_save_graded(render, png, &grade), STILB_OK);
		assert_int_equal(stilb_image_load(png, &images[d]), STILB_OK);
		assert_int_equal(stilb_image_size(&images[d]), size);
		const uint8_t *codes = images[d].pixels;
		for (size_t i = 0; i < size; i++) {
			double half = 0.5 * shown[i - i % 3 + 2 - i % 3];
			assert_true(fabs(codes[i] - half) <= (d ? 1.76 : 0.76));
			sums[d] += codes[i];
		}
	}
	assert_true(memcmp(images[0].pixels, images[1].pixels, size) != 0);
	assert_true(fabs(sums[0] - sums[1]) <= 0.1 * (double)size);
	for (uint32_t d = 0; d < 2; d++)
		stilb_image_finish(&images[d]);
}

static void picture(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 0);
	stilb_gi_settings settings = render_fixture_settings(&fixture);
	settings.exposure = 1.0f;
	settings.progressive = true;
	stilb_gi_render *render = render_fixture_create(&fixture, &settings);
	assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	saved(render, png);
	stilb_image image;
	assert_int_equal(stilb_image_load(png, &image), STILB_OK);
	static uint8_t shown[21][37][3];
	stilb_gi_display(stilb_gi_render_film(render).radiance, sizeof shown / 3, settings.exposure, settings.tone,
	                 shown[0][0]);
	assert_int_equal(stilb_image_size(&image), sizeof shown);
	assert_memory_equal(image.pixels, shown, sizeof shown);
	stilb_image_finish(&image);
	graded(render, shown[0][0], sizeof shown);
	saved(render, exr); /* .exr is not exposed, and any reader of pictures reads it */
	assert_int_equal(stilb_image_load(exr, &image), STILB_OK);
	assert_int_equal(image.channels, 3);
	assert_memory_equal(image.pixels, stilb_gi_render_film(render).radiance, stilb_image_size(&image));
	stilb_image_finish(&image);
	const char *hdr = "a.hdr"; /* neither, with 8 bits of a pixel's brightest channel */
	saved(render, hdr);
	assert_int_equal(stilb_image_load(hdr, &image), STILB_OK);
	const float *light = stilb_gi_render_film(render).radiance, *kept = image.pixels;
	for (size_t i = 0; i < sizeof shown; i++) {
		const float *pixel = light + i / 3 * 3;
		assert_true(fabsf(kept[i] - light[i]) <= fmaxf(fmaxf(pixel[0], pixel[1]), pixel[2]) / 256.0f);
	}
	stilb_image_finish(&image);
	remove(hdr);
	stilb_gi_render_destroy(render);
	render_fixture_finish(&fixture);
}

/* ---- what goes wrong --------------------------------------------------------------------------------------------- */

static void refused(stilb_gi_render *render, const char *path, stilb_result expected)
{
	assert_int_equal(stilb_gi_render_save(render, path), expected);
	assert_non_null(strstr(stilb_error_message(), path));
}

static void full_disks_and_wrong_paths(void **state)
{
	(void)state;
	static unsigned char before[400000], after[sizeof before];
	render_fixture fixture = render_fixture_make("cornell", 0);
	stilb_gi_settings settings = render_fixture_settings(&fixture);
	settings.samples = 1;
	stilb_gi_render *render = render_fixture_create(&fixture, &settings);
	assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	refused(render, "no/such/folder/a.exr", STILB_ERROR_ARGUMENT);
	refused(render, "a.jpeg", STILB_ERROR_ARGUMENT);
	refused(render, "a", STILB_ERROR_ARGUMENT);
	refused(render, "", STILB_ERROR_ARGUMENT);
	for (int i = 0; i < 2; i++) {
		const char *path = i ? png : exr;
		saved(render, path);
		size_t size = read_file(path, before, sizeof before);
		struct rlimit old, small = {.rlim_cur = size / 2};
		assert_int_equal(getrlimit(RLIMIT_FSIZE, &old), 0);
		small.rlim_max = old.rlim_max;
		signal(SIGXFSZ, SIG_IGN);
		assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
		stilb_result result = stilb_gi_render_save(render, path);
		assert_int_equal(setrlimit(RLIMIT_FSIZE, &old), 0);
		assert_int_equal(result, STILB_ERROR_FILE);
		assert_int_equal(read_file(path, after, sizeof after), size);
		assert_memory_equal(before, after, size);
	}
	static const char link[] = "full.exr";
	assert_int_equal(symlink("/dev/full", link), 0);
	refused(render, link, STILB_ERROR_FILE);
	remove(link);
	stilb_gi_render_destroy(render);
	render_fixture_finish(&fixture);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_layer),
		cmocka_unit_test(denoised),
		cmocka_unit_test(every_setting),
		cmocka_unit_test(same_picture_same_file),
		cmocka_unit_test(display),
		cmocka_unit_test(picture),
		cmocka_unit_test(full_disks_and_wrong_paths),
	};
	return cmocka_run_group_tests(tests, folder_make, tear_down);
}
