/* DDS files of every kind that is read, made here byte by byte; and damaged, cut off, huge ones and other kinds, which
 * end in a message that names them. */
#include "image/image_import.h"
#include "support/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct file_bytes {
	uint8_t data[4096];
	size_t size;
} file_bytes;

static void put(file_bytes *file, size_t at, uint32_t number)
{
	for (int k = 0; k < 4; k++)
		file->data[at + (size_t)k] = (uint8_t)(number >> 8 * k);
}

/* A file with the header of this size, and `bytes` of pixels, each another one. code: DX10 with the number of a DXGI
 * format, another of old files, or NULL: plain. */
static file_bytes file_make(uint32_t width, uint32_t height, uint32_t levels, const char *code, uint32_t dxgi,
                            size_t bytes)
{
	file_bytes file = {.size = 128};
	memcpy(file.data, "DDS ", 4);
	put(&file, 4, 124), put(&file, 8, 0x1007), put(&file, 12, height), put(&file, 16, width), put(&file, 28, levels);
	put(&file, 76, 32), put(&file, 80, code ? 4 : 0x41), put(&file, 108, 0x1000);
	if (code)
		memcpy(file.data + 84, code, 4);
	if (code && strcmp(code, "DX10") == 0) {
		put(&file, 128, dxgi), put(&file, 132, 3), put(&file, 140, 1);
		file.size = 148;
	}
	assert_true(file.size + bytes <= sizeof file.data);
	for (size_t i = 0; i < bytes; i++)
		file.data[file.size + i] = (uint8_t)(37 * i + i / 256 + 1);
	file.size += bytes;
	return file;
}

/* The masks of a plain file. */
static void file_masks(file_bytes *file, uint32_t bits, uint32_t red, uint32_t green, uint32_t blue, uint32_t alpha)
{
	put(file, 80, alpha ? 0x41 : 0x40), put(file, 88, bits);
	put(file, 92, red), put(file, 96, green), put(file, 100, blue), put(file, 104, alpha);
}

static stilb_result file_load(const file_bytes *file, stilb_image *image)
{
	char path[] = "test_image_dds_XXXXXX.dds";
	int stream = mkstemps(path, 4);
	assert_true(stream >= 0);
	assert_int_equal(write(stream, file->data, file->size), file->size);
	close(stream);
	stilb_result result = stilb_image_load(path, image);
	unlink(path);
	return result;
}

static stilb_image loaded(const file_bytes *file)
{
	stilb_image image;
	if (file_load(file, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return image;
}

static stilb_image imported(const file_bytes *file, uint32_t flags)
{
	stilb_image image;
	if (stilb_image_import_memory("it", file->data, file->size, flags, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return image;
}

/* ---- what is read ------------------------------------------------------------------------------------------------ */

static const struct {
	const char *code;
	uint32_t dxgi;
	stilb_image_format format, texels; /* as it is; as the import decodes it */
	uint32_t channels, block;
} kinds[] = {
	{"DXT1", 0, STILB_IMAGE_BC1_SRGB, STILB_IMAGE_U8_SRGB, 4, 8},
	{"DXT5", 0, STILB_IMAGE_BC3_SRGB, STILB_IMAGE_U8_SRGB, 4, 16},
	{"ATI1", 0, STILB_IMAGE_BC4_LINEAR, STILB_IMAGE_U16_LINEAR, 1, 8},
	{"BC4U", 0, STILB_IMAGE_BC4_LINEAR, STILB_IMAGE_U16_LINEAR, 1, 8},
	{"ATI2", 0, STILB_IMAGE_BC5_LINEAR, STILB_IMAGE_U16_LINEAR, 2, 16},
	{"BC5U", 0, STILB_IMAGE_BC5_LINEAR, STILB_IMAGE_U16_LINEAR, 2, 16},
	{"DX10", 71, STILB_IMAGE_BC1_LINEAR, STILB_IMAGE_U8_SRGB, 4, 8},
	{"DX10", 72, STILB_IMAGE_BC1_SRGB, STILB_IMAGE_U8_SRGB, 4, 8},
	{"DX10", 77, STILB_IMAGE_BC3_LINEAR, STILB_IMAGE_U8_SRGB, 4, 16},
	{"DX10", 78, STILB_IMAGE_BC3_SRGB, STILB_IMAGE_U8_SRGB, 4, 16},
	{"DX10", 80, STILB_IMAGE_BC4_LINEAR, STILB_IMAGE_U16_LINEAR, 1, 8},
	{"DX10", 83, STILB_IMAGE_BC5_LINEAR, STILB_IMAGE_U16_LINEAR, 2, 16},
	{"DX10", 98, STILB_IMAGE_BC7_LINEAR, STILB_IMAGE_U8_SRGB, 4, 16},
	{"DX10", 99, STILB_IMAGE_BC7_SRGB, STILB_IMAGE_U8_SRGB, 4, 16},
};

/* Levels are in copies, and in what another process gets; shared becomes that. bytes: of all of them. */
static void levels_go_on(const stilb_image *image, stilb_image *shared, size_t bytes)
{
	assert_int_equal(stilb_image_levels_size(image), bytes);
	for (int s = 0; s < 2; s++) {
		stilb_image copy;
		assert_int_equal(stilb_image_copy(image, s, &copy), STILB_OK);
		assert_true(copy.pixels != image->pixels && copy.format == image->format && copy.width == image->width);
		assert_int_equal(stilb_image_level_count(&copy), stilb_image_level_count(image));
		assert_memory_equal(copy.pixels, image->pixels, bytes);
		stilb_image_finish(&copy);
	}
	for (uint32_t few = 1; few <= 6; few++) { /* those that it has not are refused */
		stilb_image got;
		stilb_image_copy(image, true, &got);
		int file = few == 4 ? stilb_image_share(shared) : stilb_image_share(&got);
		stilb_image_finish(&got);
		stilb_result result =
			stilb_image_receive(file, image->width, image->height, image->channels, image->format, few, &got);
		assert_int_equal(result, few == 4 ? STILB_OK : few < 4 ? STILB_ERROR_FILE : STILB_ERROR_ARGUMENT);
		if (few == 4) {
			assert_int_equal(stilb_image_level_count(&got), 4);
			assert_memory_equal(got.pixels, image->pixels, bytes);
		}
		stilb_image_finish(&got);
		close(file);
	}
}

/* 13 x 6 texels are 4 x 2 blocks, then 6 x 3, 3 x 1 and 1 x 1 follow. */
static void every_kind_of_blocks(void **state)
{
	(void)state;
	static const uint32_t sides[4][2] = {{13, 6}, {6, 3}, {3, 1}, {1, 1}}, blocks[4] = {8, 2, 1, 1};
	for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
		uint32_t size = kinds[k].block;
		file_bytes file = file_make(13, 6, 4, kinds[k].code, kinds[k].dxgi, 12 * size);
		const uint8_t *pixels = file.data + file.size - 12 * size;
		stilb_image image = loaded(&file);
		assert_true(image.width == 13 && image.height == 6);
		assert_int_equal(image.format, kinds[k].format);
		assert_int_equal(image.channels, kinds[k].channels);
		assert_int_equal(stilb_image_size(&image), 8 * size);
		assert_int_equal(stilb_image_level_count(&image), 4);
		for (uint32_t l = 0, before = 0; l < 4; before += blocks[l++]) {
			stilb_image level = stilb_image_level(&image, l);
			assert_true(level.width == sides[l][0] && level.height == sides[l][1] && level.format == image.format);
			assert_int_equal(stilb_image_level_count(&level), 1);
			assert_int_equal(stilb_image_size(&level), blocks[l] * size);
			assert_memory_equal(level.pixels, pixels + before * size, blocks[l] * size);
		}
		stilb_image decoded, again = imported(&file, 0), kept = imported(&file, STILB_IMAGE_IMPORT_BLOCKS);
		assert_int_equal(stilb_image_decode(&image, &decoded), STILB_OK);
		assert_int_equal(again.format, kinds[k].texels);
		assert_int_equal(stilb_image_level_count(&again), 1);
		assert_memory_equal(again.pixels, decoded.pixels, stilb_image_size(&decoded));
		assert_true(kept.format == image.format && stilb_image_level_count(&kept) == 4);
		assert_memory_equal(kept.pixels, pixels, 12 * size);
		stilb_image shared = imported(&file, STILB_IMAGE_IMPORT_BLOCKS | STILB_IMAGE_IMPORT_SHARED);
		assert_true(shared.format == image.format && stilb_image_level_count(&shared) == 4);
		assert_memory_equal(shared.pixels, pixels, 12 * size);
		levels_go_on(&image, &shared, 12 * size);
		stilb_image_finish(&image);
		stilb_image_finish(&decoded);
		stilb_image_finish(&again);
		stilb_image_finish(&kept);
	}
}

/* 3 x 2 pixels and the level behind them, 1 x 1: seven pixels. */
static void plain_pixels_in_their_orders(void **state)
{
	(void)state;
	static const struct {
		const char *code;
		uint32_t dxgi, bits, red, blue, alpha;
		stilb_image_format format;
		uint32_t channels;
	} plain[] = {
		{NULL, 0, 32, 0xff, 0xff0000, 0xff000000, STILB_IMAGE_U8_SRGB, 4},
		{NULL, 0, 32, 0xff0000, 0xff, 0xff000000, STILB_IMAGE_U8_SRGB, 4},
		{NULL, 0, 32, 0xff0000, 0xff, 0, STILB_IMAGE_U8_SRGB, 3},
		{NULL, 0, 24, 0xff0000, 0xff, 0, STILB_IMAGE_U8_SRGB, 3},
		{NULL, 0, 24, 0xff, 0xff0000, 0, STILB_IMAGE_U8_SRGB, 3},
		{"DX10", 28, 32, 0xff, 0, 0, STILB_IMAGE_U8_LINEAR, 4},
		{"DX10", 29, 32, 0xff, 0, 0, STILB_IMAGE_U8_SRGB, 4},
		{"DX10", 87, 32, 0xff0000, 0, 0, STILB_IMAGE_U8_LINEAR, 4},
		{"DX10", 91, 32, 0xff0000, 0, 0, STILB_IMAGE_U8_SRGB, 4},
		{"DX10", 88, 32, 0xff0000, 0, 0, STILB_IMAGE_U8_LINEAR, 3},
		{"DX10", 93, 32, 0xff0000, 0, 0, STILB_IMAGE_U8_SRGB, 3},
	};
	for (size_t k = 0; k < sizeof plain / sizeof *plain; k++) {
		uint32_t bytes = plain[k].bits / 8, channels = plain[k].channels;
		file_bytes file = file_make(3, 2, 2, plain[k].code, plain[k].dxgi, 7 * bytes);
		if (!plain[k].code)
			file_masks(&file, plain[k].bits, plain[k].red, 0xff00, plain[k].blue, plain[k].alpha);
		stilb_image image = loaded(&file), decoded = imported(&file, 0);
		assert_true(image.width == 3 && image.height == 2 && stilb_image_level_count(&image) == 2);
		assert_true(image.format == plain[k].format && image.channels == channels);
		assert_true(decoded.format == STILB_IMAGE_U8_SRGB && decoded.channels == channels);
		assert_memory_equal(decoded.pixels, image.pixels, 6 * channels);
		for (uint32_t p = 0; p < 7; p++) {
			const uint8_t *from = file.data + file.size + bytes * p - 7 * bytes;
			const uint8_t *to = (uint8_t *)image.pixels + (size_t)p * channels;
			bool blue_first = plain[k].red == 0xff0000;
			assert_true(to[0] == from[blue_first ? 2 : 0] && to[1] == from[1] && to[2] == from[blue_first ? 0 : 2]);
			assert_true(channels == 3 || to[3] == from[3]);
		}
		assert_memory_equal(stilb_image_level(&image, 1).pixels, (uint8_t *)image.pixels + 6 * channels, channels);
		stilb_image_finish(&image);
		stilb_image_finish(&decoded);
	}
}

/* No count of levels is one level, and bytes behind the pixels do not matter. */
static void loose_headers_are_read(void **state)
{
	(void)state;
	file_bytes file = file_make(4, 4, 0, "DXT1", 0, 8 + 100);
	stilb_image image = loaded(&file);
	assert_int_equal(stilb_image_level_count(&image), 1);
	assert_memory_equal(image.pixels, file.data + 128, 8);
	stilb_image_finish(&image);
}

static void blocks_are_saved_as_texels(void **state)
{
	(void)state;
	static const char *const names[] = {"test_image_dds_saved.png", "test_image_dds_saved.exr"};
	file_bytes file = file_make(5, 3, 1, "DXT5", 0, 32);
	stilb_image image = loaded(&file), texels, back;
	float want[5 * 4], got[5 * 4];
	assert_int_equal(stilb_image_decode(&image, &texels), STILB_OK);
	for (int i = 0; i < 2; i++) {
		assert_int_equal(stilb_image_save(&image, names[i]), STILB_OK);
		assert_int_equal(stilb_image_load(names[i], &back), STILB_OK);
		assert_true(back.width == 5 && back.height == 3 && back.channels == 4);
		for (uint32_t y = 0; y < 3; y++) {
			stilb_image_row_to_light(&texels, y, want);
			stilb_image_row_to_light(&back, y, got);
			for (int k = 0; k < 20; k++)
				assert_true(want[k] - got[k] < 5e-4f && got[k] - want[k] < 5e-4f); /* a half's step */
		}
		stilb_image_finish(&back);
		unlink(names[i]);
	}
	stilb_image_finish(&image);
	stilb_image_finish(&texels);
	assert_int_equal(stilb_image_path_check("a.dds"), STILB_ERROR_ARGUMENT); /* none is written */
}

/* ---- what is not ------------------------------------------------------------------------------------------------- */

static void refused(const file_bytes *file, const char *why)
{
	stilb_image image;
	assert_int_equal(file_load(file, &image), STILB_ERROR_FILE);
	assert_null(image.pixels);
	const char *message = stilb_error_message();
	if (!strstr(message, why) || !strstr(message, "cannot read 'test_image_dds_") || strchr(message, '\n'))
		fail_msg("\"%s\" does not say \"%s\"", message, why);
}

static void refused_both(const file_bytes *file, const char *why)
{
	stilb_image image;
	refused(file, why);
	assert_int_equal(stilb_image_import_memory("it", file->data, file->size, 0, &image), STILB_ERROR_FILE);
	assert_null(image.pixels);
	if (!strstr(stilb_error_message(), why))
		fail_msg("\"%s\" does not say \"%s\"", stilb_error_message(), why);
}

#define CHANGED(at, number, why)                                                                                       \
	file = good, put(&file, at, number);                                                                               \
	refused_both(&file, why)

static void damaged_headers_are_refused(void **state)
{
	(void)state;
	file_bytes good = file_make(8, 8, 4, "DX10", 98, 16 * 7), file;
	stilb_image image = loaded(&good);
	stilb_image_finish(&image);
	CHANGED(4, 123, "its header is damaged");
	CHANGED(76, 31, "its header is damaged");
	CHANGED(16, 0, "0 x 8 pixels; width and height must be 1 to 65536");
	CHANGED(12, 0, "8 x 0 pixels");
	CHANGED(16, 65537, "65537 x 8 pixels");
	CHANGED(12, UINT32_MAX, "8 x 4294967295 pixels");
	CHANGED(28, 5, "it has 5 mip levels; 8 x 8 pixels have at most 4");
	CHANGED(28, UINT32_MAX, "it has 4294967295 mip levels");
	CHANGED(112, 0xfe00, "it is a cube map; save one of its sides");
	CHANGED(112, 0x200000, "it is a volume");
	CHANGED(136, 4, "it is a cube map");
	CHANGED(132, 4, "it is a volume or a line");
	CHANGED(140, 6, "it is an array of 6 pictures");
	CHANGED(140, 0, "it is an array of 0 pictures");
	CHANGED(144, 2, "multiplied by alpha");
	CHANGED(12, 65536, "the file is cut off: 8 x 65536 pixels with 4 mip levels need 753664 bytes");
	memcpy(good.data, "DDS!", 4);
	refused(&good, "it is not a DDS file");
}

/* Kinds of pixels that this reader does not know go to OpenImageIO, where pictures of any origin are read. */
static void other_kinds_are_named(void **state)
{
	(void)state;
	stilb_image image;
	file_bytes file = file_make(4, 4, 1, "DXT3", 0, 16);
	refused(&file, "the code 'DXT3'; save it as BC1, BC3, BC4, BC5, BC7 or RGBA of 8 bits");
	image = imported(&file, 0);
	assert_true(image.width == 4 && image.channels == 4 && image.format == STILB_IMAGE_U8_SRGB);
	stilb_image_finish(&image);
	file = file_make(4, 4, 1, "BC5S", 0, 16);
	refused(&file, "the code 'BC5S'");
	file = file_make(4, 4, 1, "\1A'\n", 0, 16);
	refused(&file, "the code '?A'?'");
	file = file_make(4, 4, 1, "DX10", 95, 16);
	refused(&file, "its pixels have DXGI format 95");
	file = file_make(4, 4, 1, NULL, 0, 32);
	file_masks(&file, 16, 0xf800, 0x7e0, 0x1f, 0);
	refused(&file, "its pixels have 16 bits and the code 'none'");
	file_masks(&file, 32, 0xff, 0xff00, 0xff0000, 0xff);
	refused(&file, "32 bits and the code 'none'");
	put(&file, 80, 0x20000); /* luminance */
	refused(&file, "32 bits and the code 'none'");
}

/* Every length below the whole file's. */
static void cut_files_are_refused(void **state)
{
	(void)state;
	static const char *const codes[] = {"DX10", "ATI2", NULL};
	for (int k = 0; k < 3; k++) {
		size_t bytes = codes[k] ? 16 * 7 : 85 * 4;
		file_bytes whole = file_make(8, 8, 4, codes[k], 98, bytes);
		if (!codes[k])
			file_masks(&whole, 32, 0xff, 0xff00, 0xff0000, 0xff000000);
		stilb_image image = loaded(&whole);
		stilb_image_finish(&image);
		for (size_t size = 0; size < whole.size; size++) {
			stilb_image none;
			uint8_t *part = malloc(size + 1); /* of its own, so that the sanitizer sees the end */
			memcpy(part, whole.data, size);
			assert_int_equal(stilb_image_import_memory("it", part, size, STILB_IMAGE_IMPORT_BLOCKS, &none),
			                 STILB_ERROR_FILE);
			assert_null(none.pixels);
			if (size >= 4)
				assert_non_null(strstr(stilb_error_message(), "cut off"));
			free(part);
		}
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_kind_of_blocks),        cmocka_unit_test(plain_pixels_in_their_orders),
		cmocka_unit_test(loose_headers_are_read),      cmocka_unit_test(blocks_are_saved_as_texels),
		cmocka_unit_test(damaged_headers_are_refused), cmocka_unit_test(other_kinds_are_named),
		cmocka_unit_test(cut_files_are_refused),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
