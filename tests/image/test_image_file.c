/* Pictures are written to files and read back: bits, conversions, and refused paths. */

#include "image/image.h"
#include "image/image_layers.h"
#include "support/test.h"

#include <dirent.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static char folder[] = "test_image_file_XXXXXX";

static const char *in_folder(const char *name)
{
	static char path[2][512];
	static int turn;
	turn = !turn;
	snprintf(path[turn], sizeof path[turn], "%s/%s", folder, name);
	return path[turn];
}

static int folder_entries(void)
{
	DIR *dir = opendir(folder);
	int count = 0;
	for (struct dirent *entry; dir && (entry = readdir(dir));)
		count += entry->d_name[0] != '.';
	closedir(dir);
	return count;
}

static void folder_clear(void)
{
	DIR *dir = opendir(folder);
	for (struct dirent *entry; dir && (entry = readdir(dir));) {
		if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0)
			remove(in_folder(entry->d_name));
	}
	closedir(dir);
}

static int folder_make(void **state)
{
	(void)state;
	return mkdtemp(folder) ? 0 : -1;
}

static int folder_remove(void **state)
{
	(void)state;
	folder_clear();
	return rmdir(folder);
}

static int each_end(void **state)
{
	(void)state;
	folder_clear();
	return 0;
}

/* The whole file, to be freed. */
static unsigned char *file_read(const char *path, size_t *size)
{
	FILE *stream = fopen(path, "rb");
	assert_non_null(stream);
	fseek(stream, 0, SEEK_END);
	*size = (size_t)ftell(stream);
	rewind(stream);
	unsigned char *data = malloc(*size + 1);
	assert_int_equal(fread(data, 1, *size, stream), *size);
	fclose(stream);
	return data;
}

static void file_write(const char *path, const void *data, size_t size)
{
	FILE *stream = fopen(path, "wb");
	assert_non_null(stream);
	assert_int_equal(fwrite(data, 1, size, stream), size);
	assert_int_equal(fclose(stream), 0);
}

static stilb_image picture(uint32_t width, uint32_t height, uint32_t channels, stilb_image_format format)
{
	stilb_image image;
	assert_int_equal(stilb_image_create(&image, width, height, channels, format), STILB_OK);
	return image;
}

static void save(const stilb_image *image, const char *path)
{
	if (stilb_image_save(image, path) != STILB_OK)
		fail_msg("%s", stilb_error_message());
}

static stilb_image load(const char *path)
{
	stilb_image image;
	if (stilb_image_load(path, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return image;
}

/* The message is one line that holds each of these. */
static void message_names(const char *a, const char *b)
{
	const char *message = stilb_error_message();
	if (!strstr(message, a) || !strstr(message, b) || strchr(message, '\n'))
		fail_msg("expected '%s' and '%s' in '%s'", a, b, message);
}

/* ---- bits there and back --------------------------------------------------------------------------------------- */

static void png_keeps_every_bit(void **state)
{
	(void)state;
	for (uint32_t channels = 1; channels <= 4; channels++) {
		stilb_image image = picture(37, 23, channels, STILB_IMAGE_U8_SRGB);
		uint8_t *pixels = image.pixels;
		for (size_t i = 0; i < stilb_image_size(&image); i++)
			pixels[i] = (uint8_t)stilb_random_u64(channels, i);
		save(&image, in_folder("bits.png"));
		stilb_image back = load(in_folder("bits.png"));
		assert_int_equal(back.width, 37);
		assert_int_equal(back.height, 23);
		assert_int_equal(back.channels, channels);
		assert_int_equal(back.format, STILB_IMAGE_U8_SRGB);
		assert_memory_equal(back.pixels, image.pixels, stilb_image_size(&image));
		stilb_image_finish(&image);
		stilb_image_finish(&back);
	}
}

static void exr_keeps_every_float(void **state)
{
	(void)state;
	for (uint32_t channels = 1; channels <= 4; channels++) {
		stilb_image image = picture(19, 31, channels, STILB_IMAGE_F32_LINEAR);
		float *pixels = image.pixels;
		for (size_t i = 0; i < stilb_image_size(&image) / 4; i++)
			pixels[i] = (stilb_random_float(channels, i) - 0.25f) * 1e6f;
		pixels[0] = 3e38f;
		pixels[1] = INFINITY;
		pixels[2] = 1e-40f;
		save(&image, in_folder("bits.exr"));
		stilb_image back = load(in_folder("bits.exr"));
		assert_int_equal(back.width, 19);
		assert_int_equal(back.height, 31);
		assert_int_equal(back.channels, channels);
		assert_int_equal(back.format, STILB_IMAGE_F32_LINEAR);
		assert_memory_equal(back.pixels, image.pixels, stilb_image_size(&image));
		stilb_image_finish(&image);
		stilb_image_finish(&back);
	}
}

/* IEEE 754 binary16 to double, independent of image_file.c: sign, 5 bits of exponent, 10 of mantissa. */
static double half_value(uint16_t half)
{
	double sign = half >> 15 ? -1.0 : 1.0;
	int exponent = half >> 10 & 31, mantissa = half & 1023;
	if (exponent == 0)
		return sign * mantissa / 16777216.0;
	return sign * (1.0 + mantissa / 1024.0) * pow(2.0, exponent - 15);
}

static void exr_keeps_every_half(void **state)
{
	(void)state;
	stilb_image image = picture(256, 256, 1, STILB_IMAGE_F16_LINEAR);
	uint16_t *pixels = image.pixels;
	for (uint32_t i = 0; i < 65536; i++)
		pixels[i] = (uint16_t)i;
	save(&image, in_folder("half.exr"));
	stilb_image back = load(in_folder("half.exr"));
	const float *values = back.pixels;
	for (uint32_t i = 0; i < 65536; i++) {
		bool finite = (i >> 10 & 31) != 31;
		if (finite && (double)values[i] != half_value((uint16_t)i))
			fail_msg("half %04x came back as %g", i, (double)values[i]);
		if (!finite && (i & 1023) == 0)
			assert_true(isinf(values[i]) && (values[i] < 0.0f) == (i >> 15));
		if (!finite && (i & 1023) != 0)
			assert_true(isnan(values[i]));
	}
	stilb_image_finish(&image);
	stilb_image_finish(&back);
}

static void first_row_is_the_top(void **state)
{
	(void)state;
	stilb_image image = picture(2, 3, 1, STILB_IMAGE_U8_SRGB);
	memcpy(image.pixels, (uint8_t[]){1, 2, 3, 4, 5, 6}, 6);
	save(&image, in_folder("rows.png"));
	size_t size;
	unsigned char *file = file_read(in_folder("rows.png"), &size);
	/* The header chunk: signature 8, length 4, "IHDR" 4, then width, height, bits, colour type 0 = grey. */
	assert_memory_equal(file + 16, "\0\0\0\2\0\0\0\3\10\0", 10);
	free(file);
	stilb_image back = load(in_folder("rows.png"));
	assert_memory_equal(back.pixels, image.pixels, 6);
	stilb_image_finish(&image);
	stilb_image_finish(&back);
}

/* ---- conversions ------------------------------------------------------------------------------------------------- */

static void linear_becomes_srgb_in_png(void **state)
{
	(void)state;
	/* Codes by IEC 61966-2-1 in double: round(255 (1.055 x^(1/2.4) - 0.055)), 12.92 x below 0.0031308. */
	static const float light[] = {0.0f, 0.001f,  0.0031308f, 0.18f, 0.2f,  0.5f,  0.6f, 0.999f,
	                              1.0f, 1.0001f, 1e30f,      -0.5f, -1e9f, 1e-9f, NAN,  INFINITY};
	static const uint8_t codes[] = {0, 3, 10, 118, 124, 188, 203, 255, 255, 255, 255, 0, 0, 0, 0, 255};
	enum { COUNT = sizeof codes };
	stilb_image image = picture(COUNT, 1, 1, STILB_IMAGE_F32_LINEAR);
	memcpy(image.pixels, light, sizeof light);
	save(&image, in_folder("linear.png"));
	stilb_image back = load(in_folder("linear.png"));
	for (int i = 0; i < COUNT; i++) {
		if (((uint8_t *)back.pixels)[i] != codes[i])
			fail_msg("%g became %d, not %d", (double)light[i], ((uint8_t *)back.pixels)[i], codes[i]);
	}
	stilb_image_finish(&image);
	stilb_image_finish(&back);
}

static void halves_become_srgb_in_png(void **state)
{
	(void)state;
	static const uint16_t halves[] = {0x0000, 0x3c00, 0x3800, 0x7c00, 0xfc00, 0x7e00, 0xb800, 0x4000, 0x0001, 0x2e66};
	static const uint8_t codes[] = {0, 255, 188, 255, 0, 0, 0, 255, 0, 89}; /* 0x2e66 = 0.09998 */
	enum { COUNT = sizeof codes };
	stilb_image image = picture(COUNT, 1, 1, STILB_IMAGE_F16_LINEAR);
	memcpy(image.pixels, halves, sizeof halves);
	save(&image, in_folder("half.png"));
	stilb_image back = load(in_folder("half.png"));
	assert_memory_equal(back.pixels, codes, COUNT);
	stilb_image_finish(&image);
	stilb_image_finish(&back);
}

static void alpha_stays_linear(void **state)
{
	(void)state;
	stilb_image image = picture(1, 1, 4, STILB_IMAGE_F32_LINEAR);
	memcpy(image.pixels, (float[]){0.5f, 0.2f, 1.0f, 0.5f}, 16);
	save(&image, in_folder("alpha.png"));
	stilb_image back = load(in_folder("alpha.png"));
	assert_memory_equal(back.pixels, ((uint8_t[]){188, 124, 255, 128}), 4);
	save(&back, in_folder("alpha.exr"));
	stilb_image_finish(&image);
	image = load(in_folder("alpha.exr"));
	const float *light = image.pixels;
	assert_true(fabsf(light[0] - 0.5029f) < 0.0005f); /* code 188 */
	assert_true(fabsf(light[1] - 0.2016f) < 0.0002f); /* code 124 */
	assert_true(light[2] == 1.0f);
	assert_true(fabsf(light[3] - 128.0f / 255.0f) < 0.0005f);
	stilb_image_finish(&image);
	stilb_image_finish(&back);
}

/* Every 8-bit code survives PNG -> EXR (halves) -> PNG: a half's step is finer than a code's everywhere. */
static void codes_survive_exr(void **state)
{
	(void)state;
	stilb_image image = picture(256, 1, 1, STILB_IMAGE_U8_SRGB);
	for (int i = 0; i < 256; i++)
		((uint8_t *)image.pixels)[i] = (uint8_t)i;
	save(&image, in_folder("codes.exr"));
	stilb_image light = load(in_folder("codes.exr"));
	save(&light, in_folder("codes.png"));
	stilb_image back = load(in_folder("codes.png"));
	assert_memory_equal(back.pixels, image.pixels, 256);
	stilb_image_finish(&image);
	stilb_image_finish(&light);
	stilb_image_finish(&back);
}

static void exr_is_not_clamped(void **state)
{
	(void)state;
	stilb_image image = picture(2, 1, 1, STILB_IMAGE_F32_LINEAR);
	memcpy(image.pixels, (float[]){1234.5f, -3.0f}, 8);
	save(&image, in_folder("high.exr"));
	stilb_image back = load(in_folder("high.exr"));
	assert_memory_equal(back.pixels, image.pixels, 8);
	stilb_image_finish(&image);
	stilb_image_finish(&back);
}

/* ---- same picture, same bytes ------------------------------------------------------------------------------------ */

static bool holds(const unsigned char *data, size_t size, const char *text)
{
	return memmem(data, size, text, strlen(text));
}

/* Saved before and after a change of the second: a date in the file would differ. */
static void same_bytes_twice(void **state)
{
	(void)state;
	stilb_image image = picture(64, 64, 3, STILB_IMAGE_F32_LINEAR);
	for (size_t i = 0; i < 64 * 64 * 3; i++)
		((float *)image.pixels)[i] = stilb_random_float(5, i);
	save(&image, in_folder("a.png"));
	save(&image, in_folder("a.exr"));
	usleep(1100000);
	save(&image, in_folder("b.PNG"));
	save(&image, in_folder("b.Exr"));
	static const char *const pairs[][2] = {{"a.png", "b.PNG"}, {"a.exr", "b.Exr"}};
	char host[256] = "";
	gethostname(host, sizeof host - 1);
	for (int i = 0; i < 2; i++) {
		size_t size_a, size_b;
		unsigned char *a = file_read(in_folder(pairs[i][0]), &size_a);
		unsigned char *b = file_read(in_folder(pairs[i][1]), &size_b);
		assert_int_equal(size_a, size_b);
		assert_memory_equal(a, b, size_a);
		assert_true(holds(a, size_a, "Stilb " STILB_VERSION));
		assert_false(holds(a, size_a, "OpenImageIO"));
		assert_false(strlen(host) > 3 && holds(a, size_a, host));
		free(a);
		free(b);
	}
	stilb_image_finish(&image);
}

/* ---- refusals ---------------------------------------------------------------------------------------------------- */

static void refused(const stilb_image *image, const char *path, stilb_result result, const char *why)
{
	int before = folder_entries();
	assert_int_equal(stilb_image_save(image, path), result);
	message_names(path, why);
	assert_int_equal(folder_entries(), before);
}

static void refused_by_check_too(const stilb_image *image, const char *path, const char *why)
{
	assert_int_equal(stilb_image_path_check(path), STILB_ERROR_ARGUMENT);
	message_names(path, why);
	refused(image, path, STILB_ERROR_ARGUMENT, why);
}

static void bad_paths_are_refused(void **state)
{
	(void)state;
	stilb_image image = picture(4, 4, 3, STILB_IMAGE_U8_SRGB);
	refused_by_check_too(&image, in_folder("a.jpg"), "'.jpg'");
	message_names(".png", ".exr");
	refused_by_check_too(&image, in_folder("a.png.tiff"), "'.tiff'");
	refused_by_check_too(&image, in_folder("a"), "no extension");
	refused_by_check_too(&image, in_folder(".png"), "no extension");
	refused_by_check_too(&image, "folder.png/picture", "no extension");
	refused_by_check_too(&image, "-", "no extension");
	refused_by_check_too(&image, in_folder("missing/a.png"), "folder");
	assert_int_equal(stilb_image_path_check(""), STILB_ERROR_ARGUMENT);
	assert_int_equal(mkdir(in_folder("folder.exr"), 0777), 0);
	refused_by_check_too(&image, in_folder("folder.exr"), "folder");
	assert_int_equal(stilb_image_path_check(in_folder("new.PnG")), STILB_OK);
	assert_int_equal(stilb_image_path_check(in_folder("new.EXR")), STILB_OK);
	assert_int_equal(folder_entries(), 1); /* checking wrote nothing */
	stilb_image_finish(&image);
}

static void full_disk_is_reported(void **state)
{
	(void)state;
	stilb_image image = picture(64, 64, 3, STILB_IMAGE_U8_SRGB);
	assert_int_equal(symlink("/dev/full", in_folder("full.png")), 0);
	assert_int_equal(symlink("/dev/full", in_folder("full.exr")), 0);
	refused(&image, in_folder("full.png"), STILB_ERROR_FILE, "No space left");
	refused(&image, in_folder("full.exr"), STILB_ERROR_FILE, "No space left");
	stilb_image_finish(&image);
}

/* A picture that cannot be saved leaves the old file as it is. */
static void old_file_survives_refusal(void **state)
{
	(void)state;
	file_write(in_folder("old.png"), "old", 3);
	stilb_image empty = {0};
	refused(&empty, in_folder("old.png"), STILB_ERROR_ARGUMENT, "empty");
	uint8_t pixel = 0;
	stilb_image wrong = {.width = 1, .height = 1, .channels = 5, .pixels = &pixel};
	refused(&wrong, in_folder("old.png"), STILB_ERROR_ARGUMENT, "channels");
	size_t size;
	unsigned char *data = file_read(in_folder("old.png"), &size);
	assert_int_equal(size, 3);
	assert_memory_equal(data, "old", 3);
	free(data);
}

static void bad_sizes_are_refused(void **state)
{
	(void)state;
	static const uint32_t bad[][3] = {
		{0, 1, 3},          {1, 0, 3},        {65537, 1, 3},     {1, 65537, 3},
		{1, 1, 0},          {1, 1, 5},        {65536, 65536, 4}, {UINT32_MAX, UINT32_MAX, 4},
		{1, 1, UINT32_MAX}, {65536, 16385, 4}};
	for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
		stilb_image image = {.width = 7};
		stilb_result result = stilb_image_create(&image, bad[i][0], bad[i][1], bad[i][2], STILB_IMAGE_F32_LINEAR);
		assert_int_equal(result, STILB_ERROR_ARGUMENT);
		assert_null(image.pixels);
		assert_int_equal(image.width, 0);
	}
	stilb_image image;
	assert_int_equal(stilb_image_create(&image, 1, 1, 1, (stilb_image_format)9), STILB_ERROR_ARGUMENT);
	assert_int_equal(stilb_image_create(&image, 65536, 1, 1, STILB_IMAGE_U8_SRGB), STILB_OK);
	assert_int_equal(((uintptr_t)image.pixels) % 64, 0);
	for (size_t i = 0; i < 65536; i++)
		assert_int_equal(((uint8_t *)image.pixels)[i], 0);
	stilb_image_finish(&image);
	stilb_image_finish(&image);
	stilb_image_finish(NULL);
}

/* ---- reading what is not there or not whole ---------------------------------------------------------------------- */

static void load_fails(const char *path, stilb_result result, const char *why)
{
	stilb_image image = {.width = 7, .pixels = &image};
	assert_int_equal(stilb_image_load(path, &image), result);
	message_names(path, why);
	assert_null(image.pixels);
	assert_int_equal(image.width, 0);
}

static void missing_files_are_named(void **state)
{
	(void)state;
	load_fails(in_folder("none.png"), STILB_ERROR_FILE, "No such file");
	load_fails(in_folder("none.bmp"), STILB_ERROR_ARGUMENT, "'.bmp'");
	assert_int_equal(mkdir(in_folder("d.png"), 0777), 0);
	load_fails(in_folder("d.png"), STILB_ERROR_FILE, "folder");
	assert_int_equal(mkfifo(in_folder("f.exr"), 0600), 0);
	load_fails(in_folder("f.exr"), STILB_ERROR_FILE, "regular");
	file_write(in_folder("e.png"), "", 0);
	load_fails(in_folder("e.png"), STILB_ERROR_FILE, "empty");
	file_write(in_folder("t.png"), "hello, I am a text file, and nothing of this is a picture", 57);
	load_fails(in_folder("t.png"), STILB_ERROR_FILE, "t.png");
	rename(in_folder("t.png"), in_folder("t.exr"));
	load_fails(in_folder("t.exr"), STILB_ERROR_FILE, "t.exr");
}

/* A file that is cut anywhere is an error that names it, never a partial picture. */
static void truncated_files_are_refused(void **state)
{
	(void)state;
	stilb_image image = picture(40, 40, 3, STILB_IMAGE_U8_SRGB);
	for (size_t i = 0; i < stilb_image_size(&image); i++)
		((uint8_t *)image.pixels)[i] = (uint8_t)stilb_random_u64(3, i);
	static const char *const names[] = {"cut.png", "cut.exr", "cut.hdr"};
	for (int n = 0; n < 3; n++) {
		char path[256];
		snprintf(path, sizeof path, "%s/%s", folder, names[n]);
		save(&image, path);
		size_t size;
		unsigned char *data = file_read(path, &size);
		for (int step = 1; step < 16; step++) {
			file_write(path, data, size * (size_t)step / 16);
			load_fails(path, STILB_ERROR_FILE, names[n]);
		}
		free(data);
	}
	stilb_image_finish(&image);
}

/* One wrong bit in the pixels of a PNG. */
static void damaged_files_are_refused(void **state)
{
	(void)state;
	stilb_image image = picture(40, 40, 3, STILB_IMAGE_U8_SRGB);
	save(&image, in_folder("bit.png"));
	stilb_image_finish(&image);
	size_t size;
	unsigned char *data = file_read(in_folder("bit.png"), &size);
	data[size - 20] ^= 4;
	file_write(in_folder("bit.png"), data, size);
	free(data);
	load_fails(in_folder("bit.png"), STILB_ERROR_FILE, "damaged");
}

/* An EXR whose table of rows points before the file. The table follows the header, which a lone zero byte ends after
 * the last attribute, the 4-byte float screenWindowWidth. */
static void rows_before_the_file_are_refused(void **state)
{
	(void)state;
	static const char last[] = "screenWindowWidth\0float\0\4\0\0"; /* and one more zero */
	stilb_image image = picture(5, 3, 1, STILB_IMAGE_F32_LINEAR);
	save(&image, in_folder("rows.exr"));
	stilb_image_finish(&image);
	size_t size;
	unsigned char *data = file_read(in_folder("rows.exr"), &size);
	unsigned char *at = memmem(data, size, last, sizeof last);
	assert_non_null(at);
	memset(at + sizeof last + 4 + 1, 0xff, 8);
	file_write(in_folder("rows.exr"), data, size);
	free(data);
	load_fails(in_folder("rows.exr"), STILB_ERROR_FILE, "rows.exr");
}

static uint32_t crc32_of(const unsigned char *data, size_t size)
{
	uint32_t crc = ~0u;
	for (size_t i = 0; i < size; i++) {
		crc ^= data[i];
		for (int bit = 0; bit < 8; bit++)
			crc = crc >> 1 ^ (0xedb88320u & -(crc & 1));
	}
	return ~crc;
}

/* A file of a few bytes whose header claims a huge picture is refused before memory is allocated. */
static void huge_claims_are_refused(void **state)
{
	(void)state;
	stilb_image image = picture(1, 1, 4, STILB_IMAGE_U8_SRGB);
	save(&image, in_folder("huge.png"));
	stilb_image_finish(&image);
	size_t size;
	unsigned char *data = file_read(in_folder("huge.png"), &size);
	memcpy(data + 16, "\0\1\0\1\0\0\0\1", 8); /* 65537 x 1 */
	uint32_t crc = __builtin_bswap32(crc32_of(data + 12, 17));
	memcpy(data + 29, &crc, 4);
	file_write(in_folder("huge.png"), data, size);
	free(data);
	load_fails(in_folder("huge.png"), STILB_ERROR_FILE, "65537 x 1");
}

/* ---- HDR --------------------------------------------------------------------------------------------------------- */

/* Widths that are coded pixel by pixel, in runs, and in runs of more than 127; each value within half a step of 2^-8 of
 * its pixel's largest. */
static void hdr_keeps_eight_bits_of_the_largest(void **state)
{
	(void)state;
	static const uint32_t widths[] = {1, 7, 8, 129, 300};
	for (size_t w = 0; w < sizeof widths / sizeof *widths; w++) {
		stilb_image image = picture(widths[w], 5, 3, STILB_IMAGE_F32_LINEAR);
		float *light = image.pixels;
		size_t count = (size_t)widths[w] * 5 * 3;
		for (size_t i = 0; i < count; i++) /* runs and single values by turns, over many exponents */
			light[i] = i / 60 % 2 ? 0.75f : ldexpf(stilb_random_float(w, i), (int)(i % 40) - 20);
		light[0] = 1.9999f; /* rounds up to the next power of two */
		save(&image, in_folder("light.hdr"));
		stilb_image back = load(in_folder("light.hdr"));
		assert_int_equal(back.width, widths[w]);
		assert_int_equal(back.height, 5);
		assert_int_equal(back.channels, 3);
		const float *read = back.pixels;
		for (size_t i = 0; i < count; i++) {
			const float *pixel = light + i / 3 * 3, most = fmaxf(fmaxf(pixel[0], pixel[1]), pixel[2]);
			if (!(fabsf(read[i] - light[i]) <= most / 256.0f))
				fail_msg("width %u: %g came back as %g", widths[w], (double)light[i], (double)read[i]);
		}
		stilb_image_finish(&image);
		stilb_image_finish(&back);
	}
}

static void hdr_holds_no_alpha_and_nothing_odd(void **state)
{
	(void)state;
	stilb_image image = picture(4, 1, 4, STILB_IMAGE_U8_SRGB);
	refused(&image, in_folder("alpha.hdr"), STILB_ERROR_FILE, "alpha");
	stilb_image_finish(&image);
	image = picture(4, 1, 1, STILB_IMAGE_F32_LINEAR);
	memcpy(image.pixels, (float[]){NAN, -1.0f, INFINITY, 1e-39f}, 16);
	save(&image, in_folder("odd.hdr"));
	stilb_image back = load(in_folder("odd.hdr"));
	const float *light = back.pixels;
	assert_true(light[0] == 0.0f && light[3] == 0.0f && light[9] == 0.0f);
	assert_true(light[6] > 1e38f && light[6] < INFINITY && light[7] == light[6]);
	stilb_image_finish(&image);
	stilb_image_finish(&back);
	image = picture(3, 1, 3, STILB_IMAGE_F16_LINEAR);
	memcpy(image.pixels, (uint16_t[]){0x3c00, 0x3800, 0, 0, 0, 0, 0x4000, 0x4000, 0x4000}, 18);
	save(&image, in_folder("half.hdr"));
	back = load(in_folder("half.hdr"));
	assert_memory_equal(back.pixels, ((float[]){1.0f, 0.5f, 0, 0, 0, 0, 2, 2, 2}), 36);
	stilb_image_finish(&image);
	stilb_image_finish(&back);
}

/* ---- what is loaded ---------------------------------------------------------------------------------------------- */

/* Our own formats need no OpenImageIO, which brings 260 libraries. */
static void no_large_library_is_loaded(void **state)
{
	(void)state;
	char line[4096];
	bool png = false, large = false;
	FILE *maps = fopen("/proc/self/maps", "r");
	assert_non_null(maps);
	while (fgets(line, sizeof line, maps)) {
		png = png || strstr(line, "libpng");
		large = large || strstr(line, "OpenImageIO") || strstr(line, "stilb-image-oiio");
	}
	fclose(maps);
	assert_true(png);
	assert_false(large);
}

/* Lines on stderr are the program's: the libraries behind the border print nothing, not about damaged files either. The
 * calls are those of the tests above, where a sanitizer's report would be seen. */
static void libraries_print_nothing(void **state)
{
	(void)state;
	FILE *kept = tmpfile();
	assert_non_null(kept);
	stilb_image image = picture(40, 40, 3, STILB_IMAGE_U8_SRGB), back;
	int real = dup(STDERR_FILENO);
	dup2(fileno(kept), STDERR_FILENO);
	static const char *const names[] = {"quiet.png", "quiet.exr", "quiet.hdr"};
	int failures = 0;
	for (int n = 0; n < 3; n++) {
		const char *path = in_folder(names[n]);
		failures += stilb_image_save(&image, path) != STILB_OK;
		failures += stilb_image_load(path, &back) != STILB_OK;
		stilb_image_finish(&back);
		failures += truncate(path, 150) != 0;
		failures += stilb_image_load(path, &back) != STILB_ERROR_FILE;
	}
	dup2(real, STDERR_FILENO);
	close(real);
	assert_int_equal(failures, 0);
	char text[512] = "";
	rewind(kept);
	size_t size = fread(text, 1, sizeof text - 1, kept);
	fclose(kept);
	if (size != 0)
		fail_msg("printed: %s", text);
	stilb_image_finish(&image);
}

/* The number of times that a file holds these bytes. */
static int times_in(const char *path, const void *bytes, size_t size)
{
	static char data[1 << 16];
	FILE *file = fopen(path, "rb");
	assert_non_null(file);
	size_t got = fread(data, 1, sizeof data, file);
	fclose(file);
	int times = 0;
	for (size_t i = 0; i + size <= got; i++)
		times += memcmp(data + i, bytes, size) == 0;
	return times;
}

/* The texts are in the file, one of other letters than ASCII too, and a text is one line of an .hdr. */
static void files_hold_texts(void **state)
{
	(void)state;
	static const stilb_image_attribute texts[] = {
		{"stilb:tone", "filmic"}, {"stilb:environment", "caf\u00e9.hdr"}, {"stilb:note", "two\nlines"}};
	stilb_image image, back;
	assert_int_equal(stilb_image_create(&image, 5, 3, 3, STILB_IMAGE_F32_LINEAR), STILB_OK);
	assert_int_equal(stilb_image_save_with(&image, in_folder("t.png"), texts, 3), STILB_OK);
	static const char png[] = "tEXtstilb:tone\0filmic", other[] = "iTXtstilb:environment\0\0\0\0\0caf\u00e9.hdr";
	assert_int_equal(times_in(in_folder("t.png"), png, sizeof png - 1), 1);
	assert_int_equal(times_in(in_folder("t.png"), other, sizeof other - 1), 1);
	assert_int_equal(stilb_image_save_with(&image, in_folder("t.hdr"), texts, 3), STILB_OK);
	static const char hdr[] = "\nstilb:tone=filmic\nstilb:environment=caf\u00e9.hdr\nstilb:note=two lines\nFORMAT";
	assert_int_equal(times_in(in_folder("t.hdr"), hdr, sizeof hdr - 1), 1);
	assert_int_equal(stilb_image_save_with(&image, in_folder("t.exr"), texts, 3), STILB_OK);
	stilb_image_layers *layers;
	assert_int_equal(stilb_image_layers_load(in_folder("t.exr"), &layers), STILB_OK);
	for (size_t i = 0; i < 3; i++)
		assert_string_equal(stilb_image_layers_attribute(layers, texts[i].name), texts[i].text);
	stilb_image_layers_finish(layers);
	static const char *const names[] = {"t.png", "t.hdr", "t.exr"};
	for (size_t i = 0; i < 3; i++) {
		assert_int_equal(stilb_image_load(in_folder(names[i]), &back), STILB_OK);
		assert_int_equal(back.width, 5);
		stilb_image_finish(&back);
	}
	stilb_image_finish(&image);
}

#define IMAGE_TEST(name) cmocka_unit_test_teardown(name, each_end)

int main(void)
{
	const struct CMUnitTest tests[] = {
		IMAGE_TEST(png_keeps_every_bit),
		IMAGE_TEST(exr_keeps_every_float),
		IMAGE_TEST(exr_keeps_every_half),
		IMAGE_TEST(first_row_is_the_top),
		IMAGE_TEST(linear_becomes_srgb_in_png),
		IMAGE_TEST(halves_become_srgb_in_png),
		IMAGE_TEST(alpha_stays_linear),
		IMAGE_TEST(codes_survive_exr),
		IMAGE_TEST(exr_is_not_clamped),
		IMAGE_TEST(same_bytes_twice),
		IMAGE_TEST(bad_paths_are_refused),
		IMAGE_TEST(full_disk_is_reported),
		IMAGE_TEST(old_file_survives_refusal),
		IMAGE_TEST(bad_sizes_are_refused),
		IMAGE_TEST(missing_files_are_named),
		IMAGE_TEST(truncated_files_are_refused),
		IMAGE_TEST(damaged_files_are_refused),
		IMAGE_TEST(rows_before_the_file_are_refused),
		IMAGE_TEST(huge_claims_are_refused),
		IMAGE_TEST(hdr_keeps_eight_bits_of_the_largest),
		IMAGE_TEST(hdr_holds_no_alpha_and_nothing_odd),
		IMAGE_TEST(files_hold_texts),
		IMAGE_TEST(libraries_print_nothing),
		IMAGE_TEST(no_large_library_is_loaded),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
