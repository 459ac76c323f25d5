/* Files of any bytes under the names .png, .exr and .hdr: stilb_image_load never crashes and returns a picture or a
 * reason. It starts from pictures that stilb_image_save made. */
#include "image/image.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerInitialize(int *argc, char ***argv);

static char picture[3][512]; /* the file that is loaded, as .png, as .exr and as .hdr */

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
	for (uint32_t channels = 1; channels <= 4; channels++) {
		make_seed(seeds, channels, STILB_IMAGE_U8_SRGB, 0);
		make_seed(seeds, channels, STILB_IMAGE_F32_LINEAR, 1);
		make_seed(seeds, channels, STILB_IMAGE_F16_LINEAR, 1);
		if (channels % 2 == 1) /* no alpha there */
			make_seed(seeds, channels, STILB_IMAGE_F32_LINEAR, 2);
	}
	return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	if (size == 0)
		return 0;
	const char *path = picture[data[0] % 3];
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
	volatile uint8_t sum = 0; /* every byte is there */
	for (size_t i = 0; i < stilb_image_size(&image); i += 4096)
		sum = (uint8_t)(sum + ((const uint8_t *)image.pixels)[i]);
	stilb_image_finish(&image);
	return 0;
}
