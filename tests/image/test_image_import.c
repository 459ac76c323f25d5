/* Pictures of unknown origin: formats are recognised by their first bytes, and damaged files end in a message. */
#include "image/image_import.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Two pixels, side by side, of code ff 80 00 (in HDR light 1, 0.5, 0), as files in hexadecimal. */
static const struct {
	const char *name, *bytes;
} files[] = {
	{"orange.jpg",
     "ffd8ffe000104a46494600010100000100010000ffdb00430003020202020203020202030303030406040404040408060605"
     "0609080a0a090809090a0c0f0c0a0b0e0b09090d110d0e0f101011100a0c12131210130f101010ffdb004301030303040304"
     "08040408100b090b101010101010101010101010101010101010101010101010101010101010101010101010101010101010"
     "1010101010101010ffc00011080001000203011100021101031101ffc40014000100000000000000000000000000000006ff"
     "c40014100100000000000000000000000000000000ffc40014010100000000000000000000000000000008ffc40014110100"
     "000000000000000000000000000000ffda000c03010002110311003f007a0e18afffd9"},
	{"orange.tga", "0000020000000000000000000200010018000080ff0080ff"},
	{"orange.bmp",
     "424d92000000000000008a0000007c0000000200000001000000010018000000000008000000000000000000000000000000"
     "000000000000ff0000ff0000ff000000000000ff424752730000000000000000000000000000000000000000000000000000"
     "00000000000000000000000000000000000000000000040000000000000000000000000000000080ff0080ff0000"},
	{"orange.gif", "47494638396102000100f00000ff800000000021f90400000000002c0000000002000100000202040a003b"},
	{"orange.tif",
     "49492a0014000000ffff80800000ffff808000000f0000010300010000000200000001010300010000000100000002010300"
     "03000000ce0000000301030001000000010000000601030001000000020000000a0103000100000001000000110104000100"
     "0000080000001201030001000000010000001501030001000000030000001601030001000000010000001701040001000000"
     "0c0000001c01030001000000010000002901030002000000000001003e01050002000000040100003f01050006000000d400"
     "00000000000010001000100085eb510000008000c3f5a80000000002cdcc4c0000000001cdcc4c0000008000cdcc4c000000"
     "00028fc2f50000000010371aa000000000022b870a0000002000"},
	{"orange.dds",
     "444453207c00000007100a000100000002000000080000000000000002000000494d4147454d414749434b00000000000000"
     "0000000000000000000000000000000000000000000000000000200000000400000044585431000000000000000000000000"
     "00000000000000000810400000000000000000000000000000000000e0ff00faafaaaaaae0ff00faabaaaaaa"},
	{"orange.psd",
     "3842505300010000000000000003000000010000000200100003000000000000001c3842494d03ed00000000001000000001"
     "0001000100000001000100010000005c00000054000100000000000000000000000100000002000300000000000600010000"
     "00060002000000063842494d6e6f726dff0001000000000c0000000000000000024c31000000ffffffff0000808080800000"
     "00000000000000000000ffffffff8080808000000000"},
	{"orange.webp",
     "524946463c0000005745425056503820300000001002009d012a0200010002003425a00274ba01f801f80003c800fee730ff"
     "fb5a038355fe9d9ffd6ff98e1cfc00000000"},
	{"orange.hdr",
     "233f52414449414e43450a47414d4d413d302e3435343534350a5052494d41524945533d302e363420302e333320302e3320"
     "302e3620302e313520302e303620302e3331323720302e3332390a464f524d41543d33322d6269745f726c655f726762650a"
     "0a2d592031202b5820320a8040008180400081"},
};

#define FILES (sizeof files / sizeof *files)

/* To be freed. */
static unsigned char *file_bytes(size_t i, size_t *size)
{
	*size = strlen(files[i].bytes) / 2;
	unsigned char *bytes = malloc(*size);
	for (size_t k = 0; k < *size; k++) {
		unsigned byte;
		assert_int_equal(sscanf(files[i].bytes + 2 * k, "%2x", &byte), 1);
		bytes[k] = (unsigned char)byte;
	}
	return bytes;
}

static void assert_orange(const stilb_image *image, const char *name)
{
	assert_int_equal(image->width, 2);
	assert_int_equal(image->height, 1);
	assert_in_range(image->channels, 3, 4);
	bool words = strstr(name, ".tif") || strstr(name, ".psd"); /* these have 16 bits */
	assert_int_equal(image->format, strstr(name, ".hdr") ? STILB_IMAGE_F32_LINEAR
	                                : words              ? STILB_IMAGE_U16_SRGB
	                                                     : STILB_IMAGE_U8_SRGB);
	for (uint32_t x = 0; x < 2; x++)
		for (uint32_t i = 0; i < 3; i++) {
			size_t at = x * image->channels + i;
			float value = words ? (float)((const uint16_t *)image->pixels)[at] / 65535.0f
			              : image->format == STILB_IMAGE_U8_SRGB ? (float)((const uint8_t *)image->pixels)[at] / 255.0f
			                                                     : ((const float *)image->pixels)[at];
			if (fabsf(value - 1.0f + 0.5f * (float)i) > 0.012f) /* some formats are lossy */
				fail_msg("%s: pixel %u has %g in channel %u", name, x, (double)value, i);
		}
}

static void every_kind_is_read(void **state)
{
	(void)state;
	for (size_t i = 0; i < FILES; i++) {
		size_t size;
		stilb_image image;
		unsigned char *bytes = file_bytes(i, &size);
		if (stilb_image_import_memory(files[i].name, bytes, size, 0, &image) != STILB_OK)
			fail_msg("%s", stilb_error_message());
		assert_orange(&image, files[i].name);
		stilb_image_finish(&image);
		/* The first bytes count, not the name, but for TGA, which has no signature. */
		stilb_result result = stilb_image_import_memory("texture", bytes, size, 0, &image);
		assert_int_equal(result, strstr(files[i].name, ".tga") ? STILB_ERROR_FILE : STILB_OK);
		stilb_image_finish(&image);
		free(bytes);
	}
}

static void files_are_read_from_disk(void **state)
{
	(void)state;
	char path[] = "/tmp/test_image_import_XXXXXX";
	size_t size;
	stilb_image image;
	int file = mkstemp(path);
	unsigned char *bytes = file_bytes(0, &size);
	assert_int_equal(write(file, bytes, size), size);
	close(file);
	assert_int_equal(stilb_image_import(path, 0, &image), STILB_OK);
	assert_orange(&image, path);
	stilb_image_finish(&image);
	unlink(path);
	free(bytes);
}

/* The eight orders in which a Radiance file may list the pixels: the top left is light 1, to its right 2, below it 4;
 * and a run of old files, of pixels that are like the one before. */
static void hdr_of_every_order(void **state)
{
	(void)state;
	static const struct {
		const char *order;
		unsigned char exponents[6]; /* in the file's order; light 1 is 0x80 with exponent 0x81 */
	} orders[] = {
		{"-Y 3 +X 2", {0x81, 0x82, 0x83, 0x84, 0x85, 0x86}}, {"-Y 3 -X 2", {0x82, 0x81, 0x84, 0x83, 0x86, 0x85}},
		{"+Y 3 +X 2", {0x85, 0x86, 0x83, 0x84, 0x81, 0x82}}, {"+Y 3 -X 2", {0x86, 0x85, 0x84, 0x83, 0x82, 0x81}},
		{"+X 2 -Y 3", {0x81, 0x83, 0x85, 0x82, 0x84, 0x86}}, {"+X 2 +Y 3", {0x85, 0x83, 0x81, 0x86, 0x84, 0x82}},
		{"-X 2 -Y 3", {0x82, 0x84, 0x86, 0x81, 0x83, 0x85}}, {"-X 2 +Y 3", {0x86, 0x84, 0x82, 0x85, 0x83, 0x81}}};
	stilb_image image;
	unsigned char file[128];
	for (size_t i = 0; i < sizeof orders / sizeof *orders; i++) {
		size_t size = (size_t)snprintf((char *)file, sizeof file, "#?RGBE\n# who\nEXPOSURE=1\n\n%s\n", orders[i].order);
		for (int p = 0; p < 6; p++, size += 4)
			memcpy(file + size, (const unsigned char[]){0x80, 0x80, 0x80, orders[i].exponents[p]}, 4);
		assert_int_equal(stilb_image_import_memory("order", file, size, 0, &image), STILB_OK);
		assert_true(image.width == 2 && image.height == 3);
		for (int p = 0; p < 6; p++)
			assert_true(((const float *)image.pixels)[3 * p] == (float)(1 << p));
		stilb_image_finish(&image);
	}
	static const char runs[] = "#?RADIANCE\n\n-Y 1 +X 262\n\x80\0\0\x81\1\1\1\4\1\1\1\1\x80\0\0\x82";
	assert_int_equal(stilb_image_import_memory("runs", runs, sizeof runs - 1, 0, &image), STILB_OK);
	for (int p = 0; p < 262; p++)
		assert_true(((const float *)image.pixels)[3 * p] == (p < 261 ? 1.0f : 2.0f));
	stilb_image_finish(&image);
	assert_int_equal(stilb_image_import_memory("runs", runs, sizeof runs - 5, 0, &image), STILB_ERROR_FILE);
	static const char early[] = "#?RADIANCE\n\n-Y 1 +X 9\n\1\1\1\4\1\1\1\4\1\1\1\1";
	assert_int_equal(stilb_image_import_memory("early", early, sizeof early - 1, 0, &image), STILB_ERROR_FILE);
	static const char xyz[] = "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n\x80\0\0\x81";
	assert_int_equal(stilb_image_import_memory("xyz", xyz, sizeof xyz - 1, 0, &image), STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), "red, green and blue"));
}

static void assert_refused(const char *path, const char *says)
{
	stilb_image image = {.width = 1};
	assert_int_equal(stilb_image_import(path, 0, &image), STILB_ERROR_FILE);
	assert_true(image.width == 0 && !image.pixels);
	assert_non_null(strstr(stilb_error_message(), path));
	assert_non_null(strstr(stilb_error_message(), says));
}

static void refusals_name_file_and_reason(void **state)
{
	(void)state;
	char path[] = "/tmp/test_image_import_XXXXXX.png";
	assert_refused("/nonexistent/leaf.jpg", "No such file");
	assert_refused("/tmp", "folder");
	assert_refused("/dev/zero", "not a regular file");
	int file = mkstemps(path, 4);
	assert_refused(path, "empty");
	assert_int_equal(write(file, "no picture", 10), 10);
	close(file);
	assert_refused(path, "not a picture of a supported format");
	unlink(path);
}

/* Files that are cut or have changed bytes give a picture or a message, never a crash (the sanitizers watch). */
static void damaged_pictures_do_no_harm(void **state)
{
	(void)state;
	int refused = 0;
	for (size_t i = 0; i < FILES; i++) {
		size_t size;
		unsigned char *bytes = file_bytes(i, &size);
		for (size_t cut = 0; cut < size; cut += 1 + size / 16) {
			stilb_image image;
			refused += stilb_image_import_memory(files[i].name, bytes, cut, 0, &image) != STILB_OK;
			stilb_image_finish(&image);
			unsigned char old = bytes[cut];
			bytes[cut] ^= (unsigned char)(1 + stilb_random_u64(i, cut) % 255);
			if (stilb_image_import_memory(files[i].name, bytes, size, 0, &image) != STILB_OK)
				assert_non_null(strstr(stilb_error_message(), files[i].name));
			stilb_image_finish(&image);
			bytes[cut] = old;
		}
		free(bytes);
	}
	assert_true(refused > (int)FILES);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_kind_is_read),          cmocka_unit_test(files_are_read_from_disk),
		cmocka_unit_test(hdr_of_every_order),          cmocka_unit_test(refusals_name_file_and_reason),
		cmocka_unit_test(damaged_pictures_do_no_harm),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
