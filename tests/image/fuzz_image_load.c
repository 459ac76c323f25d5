/* Files of any bytes under the names .png, .exr, .hdr and .dds: stilb_image_load never crashes and returns a picture or
 * a reason; blocks become texels, and all levels are there. It starts from pictures that stilb_image_save made, and
 * from DDS files that are written here. */
#include "image/image.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerInitialize(int *argc, char ***argv);

#define KINDS 4

static char picture[KINDS][512]; /* the file that is loaded, as .png, as .exr, as .hdr and as .dds */

static void require(bool condition)
{
	if (!condition)
		abort();
}

/* One seed: the kind's byte, then the file. */
static void make_seed(const char *seeds, uint32_t channels, stilb_image_format format, int kind)
{
	static uint8_t file[65536];
	char path[512];
	stilb_image image;
	require(stilb_image_create(&image, 5, 3, channels, format) == STILB_OK);
	for (size_t i = 0; i < stilb_image_size(&image) / 2; i++)
		((uint8_t *)image.pixels)[2 * i] = (uint8_t)(37 * i);
	require(stilb_image_save(&image, picture[kind]) == STILB_OK);
	stilb_image_finish(&image);
	FILE *stream = fopen(picture[kind], "rb");
	require(stream);
	size_t size = fread(file + 1, 1, sizeof file - 1, stream);
	fclose(stream);
	file[0] = (uint8_t)kind;
	snprintf(path, sizeof path, "%s/%d-%u-%d", seeds, kind, channels, (int)format);
	stream = fopen(path, "wb");
	require(stream && fwrite(file, 1, size + 1, stream) == size + 1);
	fclose(stream);
}

static void put(uint8_t *file, size_t at, uint32_t number)
{
	for (int k = 0; k < 4; k++)
		file[at + (size_t)k] = (uint8_t)(number >> 8 * k);
}

/* A DDS file of 5 x 3 pixels and the two levels behind them, of a DXGI format or, for 0, of old kinds. */
static void make_dds_seed(const char *seeds, uint32_t dxgi, const char *code, uint32_t bits)
{
	uint8_t file[1 + 148 + 256] = {3};
	char path[512];
	memcpy(file + 1, "DDS ", 4);
	put(file + 1, 4, 124), put(file + 1, 12, 3), put(file + 1, 16, 5), put(file + 1, 28, 3), put(file + 1, 76, 32);
	put(file + 1, 80, code[0] ? 4 : 0x41), put(file + 1, 88, bits), put(file + 1, 92, 0xff0000);
	put(file + 1, 96, 0xff00), put(file + 1, 100, 0xff), put(file + 1, 104, 0xff000000);
	memcpy(file + 1 + 84, code, 4);
	if (dxgi > 0)
		put(file + 1, 128, dxgi), put(file + 1, 132, 3), put(file + 1, 140, 1);
	for (size_t i = 150; i < sizeof file; i++)
		file[i] = (uint8_t)(37 * i);
	snprintf(path, sizeof path, "%s/3-%u-%s", seeds, dxgi, code[0] ? code : "plain");
	FILE *stream = fopen(path, "wb");
	require(stream && fwrite(file, 1, sizeof file, stream) == sizeof file);
	fclose(stream);
}

/* The last argument is the folder of the seeds, which the fuzzer reads after this and adds to; the file to load lies
 * beside it. */
int LLVMFuzzerInitialize(int *argc, char ***argv)
{
	const char *seeds = (*argv)[*argc - 1];
	if (*argc < 2 || seeds[0] == '-') {
		fprintf(stderr, "usage: fuzz_image_load [-OPTION=VALUE ...] FOLDER\n");
		exit(1);
	}
	mkdir(seeds, 0777);
	snprintf(picture[0], sizeof picture[0], "%s.png", seeds);
	snprintf(picture[1], sizeof picture[1], "%s.exr", seeds);
	snprintf(picture[2], sizeof picture[2], "%s.hdr", seeds);
	snprintf(picture[3], sizeof picture[3], "%s.dds", seeds);
	for (uint32_t channels = 1; channels <= 4; channels++) {
		make_seed(seeds, channels, STILB_IMAGE_U8_SRGB, 0);
		make_seed(seeds, channels, STILB_IMAGE_F32_LINEAR, 1);
		make_seed(seeds, channels, STILB_IMAGE_F16_LINEAR, 1);
		if (channels % 2 == 1) /* no alpha there */
			make_seed(seeds, channels, STILB_IMAGE_F32_LINEAR, 2);
	}
	static const uint32_t numbers[] = {28, 88, 71, 78, 80, 83, 98, 99};
	for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
		make_dds_seed(seeds, numbers[i], "DX10", 0);
	make_dds_seed(seeds, 0, "DXT1", 0);
	make_dds_seed(seeds, 0, "ATI2", 0);
	make_dds_seed(seeds, 0, "\0\0\0", 32);
	return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	if (size == 0)
		return 0;
	const char *path = picture[data[0] % KINDS];
	FILE *file = fopen(path, "wb");
	require(file);
	require(fwrite(data + 1, 1, size - 1, file) == size - 1);
	require(fclose(file) == 0);
	stilb_image image;
	stilb_result result = stilb_image_load(path, &image);
	if (result != STILB_OK) {
		require(!image.pixels && strstr(stilb_error_message(), path));
		return 0;
	}
	require(image.width >= 1 && image.width <= STILB_IMAGE_MAX_SIDE && image.height >= 1 &&
	        image.height <= STILB_IMAGE_MAX_SIDE);
	require(image.channels >= 1 && image.channels <= 4 && stilb_image_size(&image) <= STILB_IMAGE_MAX_BYTES);
	volatile uint8_t sum = 0; /* every page of every level is there, and its last byte */
	for (uint32_t l = 0; l < stilb_image_level_count(&image); l++) {
		stilb_image level = stilb_image_level(&image, l);
		for (size_t i = 0; i < stilb_image_size(&level); i += 4096)
			sum = (uint8_t)(sum + ((const uint8_t *)level.pixels)[i]);
		sum = (uint8_t)(sum + ((const uint8_t *)level.pixels)[stilb_image_size(&level) - 1]);
	}
	if (stilb_image_format_is_blocks(image.format)) {
		stilb_image texels;
		require(stilb_image_decode(&image, &texels) == STILB_OK);
		stilb_image_finish(&texels);
	}
	stilb_image_finish(&image);
	return 0;
}
