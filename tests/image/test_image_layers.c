/* Pictures of many channels are written and read back; wrong requests and damaged files are refused. */
#include "image/image_layers.h"
#include "support/folder.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char path[] = "a.exr";

static int tear_down(void **state)
{
	(void)state;
	remove(path);
	return folder_remove();
}

#define W 29
#define H 17
#define NAMES 11

/* In the order of saving, which differs from the order in the file. */
static const char *const names[NAMES] = {"samples",  "R",       "G",        "B",        "normal.X", "normal.Y",
                                         "normal.Z", "depth.Z", "albedo.B", "albedo.G", "albedo.R"};
static float values[H * W][NAMES];
static stilb_image_channel channels[NAMES];
static const stilb_image_attribute attributes[] = {
	{"stilb:integrator", "path"}, {"stilb:lens.radius", "0.100000001"}, {"stilb:note", "two\nlines, and \xc3\xa4"}};

static stilb_image_layers layers_make(void)
{
	for (size_t i = 0; i < H * W; i++) {
		for (size_t c = 0; c < NAMES; c++)
			values[i][c] = (stilb_random_float(c, i) - 0.5f) * 1e6f;
	}
	values[3][7] = INFINITY;
	values[4][1] = -0.0f;
	values[5][1] = 1e-40f;
	for (size_t c = 0; c < NAMES; c++)
		channels[c] = (stilb_image_channel){.name = names[c], .values = &values[0][c], .stride = NAMES};
	return (stilb_image_layers){.width = W,
	                            .height = H,
	                            .channel_count = NAMES,
	                            .attribute_count = 3,
	                            .channels = channels,
	                            .attributes = attributes};
}

static void there_and_back(void **state)
{
	(void)state;
	stilb_image_layers layers = layers_make(), *back;
	assert_int_equal(stilb_image_layers_save(&layers, path), STILB_OK);
	assert_int_equal(stilb_image_layers_load(path, &back), STILB_OK);
	assert_int_equal(back->width, W);
	assert_int_equal(back->height, H);
	assert_int_equal(back->channel_count, NAMES);
	assert_string_equal(back->channels[0].name, "R");
	assert_string_equal(back->channels[2].name, "B");
	for (size_t c = 0; c < NAMES; c++) {
		const stilb_image_channel *channel = stilb_image_layers_channel(back, names[c]);
		assert_non_null(channel);
		for (size_t i = 0; i < H * W; i++)
			assert_memory_equal(&channel->values[i * channel->stride], &values[i][c], sizeof(float));
	}
	for (size_t i = 0; i < 3; i++)
		assert_string_equal(stilb_image_layers_attribute(back, attributes[i].name), attributes[i].text);
	assert_null(stilb_image_layers_channel(back, "r"));
	assert_null(stilb_image_layers_attribute(back, "stilb:none"));
	stilb_image_layers_finish(back);
	stilb_image_layers_finish(NULL);
}

/* Each channel may have its own plane, with stride 1. */
static void one_plane(void **state)
{
	(void)state;
	stilb_image_layers layers = layers_make(), *back;
	stilb_image_channel plane = {.name = "Y", .values = values[0], .stride = 1};
	layers.channel_count = 1;
	layers.channels = &plane;
	layers.attribute_count = 0;
	assert_int_equal(stilb_image_layers_save(&layers, path), STILB_OK);
	assert_int_equal(stilb_image_layers_load(path, &back), STILB_OK);
	assert_int_equal(back->channels[0].stride, 1);
	assert_memory_equal(back->channels[0].values, values[0], W * H * sizeof(float));
	stilb_image_layers_finish(back);
}

/* stilb_image_load reads R G B of a file with more channels. */
static void picture_of_many(void **state)
{
	(void)state;
	stilb_image_layers layers = layers_make();
	stilb_image image;
	assert_int_equal(stilb_image_layers_save(&layers, path), STILB_OK);
	assert_int_equal(stilb_image_load(path, &image), STILB_OK);
	assert_int_equal(image.channels, 3);
	for (size_t i = 0; i < H * W; i++)
		assert_memory_equal((float *)image.pixels + 3 * i, &values[i][1], 3 * sizeof(float));
	stilb_image_finish(&image);
	channels[1].name = "red";
	assert_int_equal(stilb_image_layers_save(&layers, path), STILB_OK);
	assert_int_equal(stilb_image_load(path, &image), STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), "11 channels"));
}

static size_t read_file(unsigned char *data, size_t size)
{
	FILE *file = fopen(path, "rb");
	assert_non_null(file);
	size_t got = fread(data, 1, size, file);
	fclose(file);
	return got;
}

static void write_file(const unsigned char *data, size_t size)
{
	FILE *file = fopen(path, "wb");
	assert_non_null(file);
	assert_int_equal(fwrite(data, 1, size, file), size);
	assert_int_equal(fclose(file), 0);
}

static void same_bytes(void **state)
{
	(void)state;
	static unsigned char first[100000], second[sizeof first];
	stilb_image_layers layers = layers_make();
	assert_int_equal(stilb_image_layers_save(&layers, path), STILB_OK);
	size_t size = read_file(first, sizeof first);
	assert_int_equal(stilb_image_layers_save(&layers, path), STILB_OK);
	assert_int_equal(read_file(second, sizeof second), size);
	assert_memory_equal(first, second, size);
	stilb_image_layers *back; /* no date, which would differ later */
	assert_int_equal(stilb_image_layers_load(path, &back), STILB_OK);
	assert_null(stilb_image_layers_attribute(back, "DateTime"));
	stilb_image_layers_finish(back);
}

static void refused(const stilb_image_layers *layers, const char *where, stilb_result expected, const char *words)
{
	assert_int_equal(stilb_image_layers_save(layers, where), expected);
	if (!strstr(stilb_error_message(), words) || !strstr(stilb_error_message(), where))
		fail_msg("\"%s\" does not say \"%s\"", stilb_error_message(), words);
}

static void refused_requests(void **state)
{
	(void)state;
	stilb_image_layers layers = layers_make(), wrong = layers;
	refused(&layers, "a.png", STILB_ERROR_ARGUMENT, ".exr");
	refused(&layers, ".exr", STILB_ERROR_ARGUMENT, ".exr");
	refused(&layers, "no/such/folder/a.exr", STILB_ERROR_ARGUMENT, "folder");
	wrong.channel_count = 0;
	refused(&wrong, path, STILB_ERROR_ARGUMENT, "1 to 64 channels");
	wrong.channel_count = STILB_IMAGE_MAX_CHANNELS + 1;
	refused(&wrong, path, STILB_ERROR_ARGUMENT, "1 to 64 channels");
	wrong = layers;
	wrong.width = 65537;
	refused(&wrong, path, STILB_ERROR_ARGUMENT, "65536");
	wrong.width = wrong.height = 65536;
	refused(&wrong, path, STILB_ERROR_ARGUMENT, "4 GiB");
	channels[1].name = channels[2].name;
	refused(&layers, path, STILB_ERROR_ARGUMENT, "'G' twice");
	channels[1].name = "";
	refused(&layers, path, STILB_ERROR_ARGUMENT, "name");
}

static void not_read(const char *where, stilb_result expected)
{
	stilb_image_layers *back = (stilb_image_layers *)path;
	assert_int_equal(stilb_image_layers_load(where, &back), expected);
	assert_null(back);
	assert_non_null(strstr(stilb_error_message(), where));
}

static void refused_files(void **state)
{
	(void)state;
	static unsigned char whole[100000], damaged[sizeof whole];
	remove(path);
	not_read(path, STILB_ERROR_FILE);
	not_read("a.png", STILB_ERROR_ARGUMENT);
	not_read(".", STILB_ERROR_ARGUMENT);
	stilb_image_layers layers = layers_make(), *back;
	assert_int_equal(stilb_image_layers_save(&layers, path), STILB_OK);
	size_t size = read_file(whole, sizeof whole);
	for (size_t length = 0; length < size; length += 1 + size / 60) {
		write_file(whole, length);
		not_read(path, STILB_ERROR_FILE);
	}
	uint32_t read = 0;
	for (size_t at = 0; at < 1200; at += 17) { /* where the names, sizes and types are: read or refused */
		memcpy(damaged, whole, size);
		damaged[at] ^= (unsigned char)(1 + at % 255);
		write_file(damaged, size);
		if (stilb_image_layers_load(path, &back) == STILB_OK)
			read++;
		stilb_image_layers_finish(back);
	}
	assert_true(read < 1200 / 17);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(there_and_back), cmocka_unit_test(one_plane),     cmocka_unit_test(picture_of_many),
		cmocka_unit_test(same_bytes),     cmocka_unit_test(refused_files), cmocka_unit_test(refused_requests),
	};
	return cmocka_run_group_tests(tests, folder_make, tear_down);
}
