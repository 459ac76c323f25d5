// consumer PICTURE: prints the mean colour of its middle, a twentieth of each side, as three codes. It is C++, and
// includes the engine's public headers, those that need most others first.
#include <stilb/gi_render.h>

#include <stilb/engine.h>

#include <stilb/scene_build.h>

#include <stilb/ui_draw.h>

#include <stilb/input_control.h>

#include <cstdio>

int main(int argc, char **argv)
{
	stilb_image image;
	unsigned long sum[3] = {0, 0, 0}, count = 0;
	static_assert(STILB_VERSION_MAJOR == 0 && STILB_VERSION_MINOR >= 2, "the version is known to the preprocessor");
	if (argc != 2 || stilb_image_load(argv[1], &image) != STILB_OK || image.channels != 3 ||
	    image.format != STILB_IMAGE_U8_SRGB) {
		std::fprintf(stderr, "%s\n", stilb_error_message());
		return 1;
	}
	const unsigned char *codes = static_cast<const unsigned char *>(image.pixels);
	for (uint32_t y = image.height * 19 / 40; y < image.height * 21 / 40; y++)
		for (uint32_t x = image.width * 19 / 40; x < image.width * 21 / 40; x++, count++)
			for (uint32_t c = 0; c < 3; c++)
				sum[c] += codes[(static_cast<size_t>(y) * image.width + x) * 3 + c];
	std::printf("%lu %lu %lu\n", sum[0] / count, sum[1] / count, sum[2] / count);
	stilb_image_finish(&image);
	return 0;
}
