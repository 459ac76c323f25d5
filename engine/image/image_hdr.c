/*
 * Radiance HDR: a text header, then for each pixel red, green and blue as 8-bit mantissas of one 8-bit exponent, each
 * scanline run-length coded. Sources: Ward, "Real Pixels", Graphics Gems II, 1991; "Radiance File Formats",
 * radiance-online.org. EXPOSURE lines are not applied.
 */
#include "image/image_internal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define HDR_BIAS 136 /* a value is mantissa * 2^(exponent - 136): 128 is the exponent's bias, 8 the mantissa's bits */

/* Scanlines of these widths may be coded channel by channel; others are coded pixel by pixel. */
#define HDR_MIN_RUN_WIDTH 8u
#define HDR_MAX_RUN_WIDTH 32767u

#define HDR_SCRATCH(width) ((size_t)(width)*7 + 64)

/* ---- writing ----------------------------------------------------------------------------------------------------- */

/* NaN and values below 0 become 0, infinity the largest value of the format. */
static float hdr_storable(float value)
{
	return value > 0.0f ? fminf(value, 1.6e38f) : 0.0f;
}

static void hdr_pixel(const float *rgb, unsigned char coded[4])
{
	float light[3], most = 0.0f;
	for (int i = 0; i < 3; i++) {
		light[i] = hdr_storable(rgb[i]);
		most = fmaxf(most, light[i]);
	}
	memset(coded, 0, 4);
	int exponent;
	(void)frexpf(most, &exponent);
	if (most <= 0.0f || exponent < -126)
		return; /* black, or too dark for the format */
	if (ldexpf(most, 8 - exponent) >= 255.5f)
		exponent++; /* it would round to 256 */
	STILB_ASSERT(exponent + 128 > 0 && exponent + 128 < 256);
	for (int i = 0; i < 3; i++)
		coded[i] = (unsigned char)(ldexpf(light[i], 8 - exponent) + 0.5f);
	coded[3] = (unsigned char)(exponent + 128);
}

/* Run-length codes one channel of a scanline: 4 and more equal values as the bytes 128 + length, value; others as
 * length, values. Returns the number of bytes written to out, at most width + width / 128 + 2. */
static size_t hdr_runs(const unsigned char *values, uint32_t width, unsigned char *out)
{
	STILB_ASSERT(width >= HDR_MIN_RUN_WIDTH && width <= HDR_MAX_RUN_WIDTH);
	size_t size = 0;
	for (uint32_t x = 0, plain = 0; plain < width;) {
		uint32_t run = 1;
		while (x + run < width && run < 127 && values[x + run] == values[x])
			run++;
		bool ends = run >= 4 || x + run >= width;
		if (run < 4)
			x += run;
		while (ends && plain < x) {
			uint32_t length = x - plain < 128 ? x - plain : 128;
			out[size++] = (unsigned char)length;
			memcpy(out + size, values + plain, length);
			size += length;
			plain += length;
		}
		if (run >= 4) {
			out[size++] = (unsigned char)(128 + run);
			out[size++] = values[x];
			plain = x += run;
		}
	}
	STILB_ASSERT(size <= (size_t)width + width / 128 + 2);
	return size;
}

/* Appends a scanline of `width` coded pixels, 4 bytes each. scratch: HDR_SCRATCH(width) bytes: one channel and four
 * coded ones. False: out of memory. */
static bool hdr_put_scanline(const unsigned char *pixels, uint32_t width, unsigned char *scratch, image_bytes *file)
{
	if (width < HDR_MIN_RUN_WIDTH || width > HDR_MAX_RUN_WIDTH)
		return image_bytes_write(file, file->size, pixels, (size_t)width * 4);
	unsigned char *channel = scratch, *out = scratch + width;
	size_t size = 4;
	STILB_ASSERT(scratch);
	memcpy(out, (const unsigned char[4]){2, 2, (unsigned char)(width >> 8), (unsigned char)width}, 4);
	for (int c = 0; c < 4; c++) {
		for (uint32_t x = 0; x < width; x++)
			channel[x] = pixels[4 * (size_t)x + (size_t)c];
		size += hdr_runs(channel, width, out + size);
	}
	STILB_ASSERT(width + size <= HDR_SCRATCH(width));
	return image_bytes_write(file, file->size, out, size);
}

/* Writes "name=text" lines, each on one line. */
static bool hdr_put_attributes(const image_input *input, image_bytes *file)
{
	bool good = true;
	for (uint32_t i = 0; i < input->attribute_count && good; i++) {
		char *line;
		int length = asprintf(&line, "%s=%s\n", input->attributes[i].name, input->attributes[i].text);
		good = length >= 0;
		for (int c = 0; good && c < length - 1; c++)
			if ((unsigned char)line[c] < ' ')
				line[c] = ' ';
		good = good && image_bytes_write(file, file->size, line, (size_t)length);
		if (length >= 0)
			free(line);
	}
	return good;
}

static image_outcome hdr_encode(const image_input *input, image_bytes *file, image_message *message)
{
	const image_shape *shape = &input->shape;
	STILB_ASSERT(shape->scalar == IMAGE_SCALAR_F32);
	STILB_ASSERT(input->pixels && file && message);
	if (shape->channels % 2 == 0) {
		image_message_set(message, "a .hdr file holds no alpha; use .exr");
		return IMAGE_OUTCOME_CODEC;
	}
	char header[128];
	static const char software[] = "#?RADIANCE\nSOFTWARE=Stilb " STILB_VERSION "\n";
	int length =
		snprintf(header, sizeof header, "FORMAT=32-bit_rle_rgbe\n\n-Y %u +X %u\n", shape->height, shape->width);
	unsigned char *coded = malloc((size_t)shape->width * 4), *scratch = malloc(HDR_SCRATCH(shape->width));
	bool good = coded && scratch && image_bytes_write(file, file->size, software, sizeof software - 1) &&
	            hdr_put_attributes(input, file) && image_bytes_write(file, file->size, header, (size_t)length);
	const float *light = input->pixels;
	for (uint32_t y = 0; y < shape->height && good; y++) {
		for (uint32_t x = 0; x < shape->width; x++, light += shape->channels) {
			const float grey[3] = {light[0], light[0], light[0]};
			hdr_pixel(shape->channels == 1 ? grey : light, coded + 4 * (size_t)x);
		}
		good = hdr_put_scanline(coded, shape->width, scratch, file);
	}
	free(coded);
	free(scratch);
	return good ? IMAGE_OUTCOME_DONE : IMAGE_OUTCOME_MEMORY;
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

typedef struct hdr_input {
	const unsigned char *at, *end; /* the bytes that are still to be read */
	uint32_t width, height;        /* of the picture as it is shown */
	bool x_first;                  /* a scanline is a column of the picture, not a row */
	bool x_down, y_up;             /* the file lists pixels from right to left; from bottom to top */
} hdr_input;

/* The next line of the header without its end. False: there is none, or it is longer than 255 bytes. */
static bool hdr_line(hdr_input *input, char line[static 256])
{
	STILB_ASSERT(input->at <= input->end);
	const unsigned char *end = memchr(input->at, '\n', (size_t)(input->end - input->at));
	if (!end || end - input->at >= 256)
		return false;
	memcpy(line, input->at, (size_t)(end - input->at));
	line[end - input->at] = '\0';
	input->at = end + 1;
	return true;
}

/* Reads "-Y 480 +X 640" or one of the seven other orders of scanlines. False: damaged. */
static bool hdr_resolution(hdr_input *input, const char *line)
{
	char sign[2], axis[2];
	uint32_t size[2];
	int end = 0;
	if (sscanf(line, "%c%c %9u %c%c %9u%n", &sign[0], &axis[0], &size[0], &sign[1], &axis[1], &size[1], &end) != 6 ||
	    line[end] != '\0')
		return false;
	for (int i = 0; i < 2; i++)
		if ((sign[i] != '+' && sign[i] != '-') || (axis[i] != 'X' && axis[i] != 'Y'))
			return false;
	input->x_first = axis[0] == 'X';
	int x = input->x_first ? 0 : 1, y = 1 - x;
	input->width = size[x];
	input->height = size[y];
	input->x_down = sign[x] == '-';
	input->y_up = sign[y] == '+';
	return axis[0] != axis[1] && size[0] > 0 && size[1] > 0;
}

/* Returns NULL, or the reason why the file cannot be read. */
static const char *hdr_header(hdr_input *input)
{
	char line[256];
	if (!hdr_line(input, line) || strncmp(line, "#?", 2) != 0)
		return "it is not a Radiance HDR file";
	for (;;) {
		if (!hdr_line(input, line))
			return "its header is damaged";
		if (line[0] == '\0')
			break;
		if (strncmp(line, "FORMAT=", 7) == 0 && strcmp(line + 7, "32-bit_rle_rgbe") != 0)
			return "its pixels are not red, green and blue";
	}
	return hdr_line(input, line) && hdr_resolution(input, line) ? NULL : "its header is damaged";
}

/* Decodes a scanline that is coded channel by channel into codes, [width][4]. False: damaged. */
static bool hdr_get_runs(hdr_input *input, unsigned char *codes, uint32_t width)
{
	for (uint32_t c = 0; c < 4; c++)
		for (uint32_t x = 0; x < width;) {
			if (input->end - input->at < 2)
				return false;
			bool run = input->at[0] > 128;
			uint32_t length = run ? input->at[0] - 128u : input->at[0];
			uint32_t bytes = run ? 1 : length;
			input->at++;
			if (length == 0 || length > width - x || (size_t)(input->end - input->at) < bytes)
				return false;
			for (uint32_t i = 0; i < length; i++, x++)
				codes[4 * (size_t)x + c] = input->at[run ? 0 : i];
			input->at += bytes;
		}
	return true;
}

/* Decodes a scanline that is coded pixel by pixel into codes, [width][4]. A pixel of mantissas 1, 1, 1 stands for the
 * pixel before it, repeated as often as its exponent says; if several such pixels follow one another, the count of each
 * is multiplied by 256 once more than that of the one before. False: damaged. */
static bool hdr_get_pixels(hdr_input *input, unsigned char *codes, uint32_t width)
{
	unsigned shift = 0;
	for (uint32_t x = 0; x < width; input->at += 4) {
		if (input->end - input->at < 4)
			return false;
		const unsigned char *pixel = input->at;
		if (pixel[0] != 1 || pixel[1] != 1 || pixel[2] != 1) {
			memcpy(codes + 4 * (size_t)x++, pixel, 4);
			shift = 0;
			continue;
		}
		uint64_t times = shift < 32 ? (uint64_t)pixel[3] << shift : UINT64_MAX;
		if (x == 0 || times > width - x)
			return false;
		for (uint64_t i = 0; i < times; i++, x++)
			memcpy(codes + 4 * (size_t)x, codes + 4 * (size_t)(x - 1), 4);
		shift += 8;
	}
	return true;
}

/* Decodes the next scanline into codes, [width][4]. False: damaged. */
static bool hdr_get_scanline(hdr_input *input, unsigned char *codes, uint32_t width)
{
	bool runs = width >= HDR_MIN_RUN_WIDTH && width <= HDR_MAX_RUN_WIDTH && input->end - input->at >= 4 &&
	            input->at[0] == 2 && input->at[1] == 2 && input->at[2] < 128;
	if (!runs)
		return hdr_get_pixels(input, codes, width);
	if ((uint32_t)(input->at[2] << 8 | input->at[3]) != width)
		return false;
	input->at += 4;
	return hdr_get_runs(input, codes, width);
}

/* Decodes all scanlines and writes each pixel to its place in light, [height][width][3]. codes: room for one scanline.
 * False: damaged. */
static bool hdr_read(hdr_input *input, unsigned char *codes, float *light)
{
	STILB_ASSERT(input->width > 0 && input->height > 0);
	uint32_t lines = input->x_first ? input->width : input->height;
	uint32_t length = input->x_first ? input->height : input->width;
	float scale[256] = {0}; /* value of a mantissa of 1, by the exponent's code; code 0 means black */
	for (int e = 1; e < 256; e++)
		scale[e] = ldexpf(1.0f, e - HDR_BIAS);
	for (uint32_t line = 0; line < lines; line++) {
		if (!hdr_get_scanline(input, codes, length))
			return false;
		STILB_ASSERT(input->at <= input->end);
		for (uint32_t i = 0; i < length; i++) {
			uint32_t along_x = input->x_first ? line : i, along_y = input->x_first ? i : line;
			uint32_t x = input->x_down ? input->width - 1 - along_x : along_x;
			uint32_t y = input->y_up ? input->height - 1 - along_y : along_y;
			const unsigned char *code = codes + 4 * (size_t)i;
			for (size_t c = 0; c < 3; c++)
				light[((size_t)y * input->width + x) * 3 + c] = (float)code[c] * scale[code[3]];
		}
	}
	return true;
}

static image_outcome hdr_decode(const void *data, size_t size, image_allocate *allocate, void *context,
                                image_message *message)
{
	STILB_ASSERT(data && allocate && message);
	hdr_input input = {.at = data, .end = (const unsigned char *)data + size};
	const char *trouble = hdr_header(&input);
	if (trouble) {
		image_message_set(message, trouble);
		return IMAGE_OUTCOME_CODEC;
	}
	image_shape shape = {input.width, input.height, 3, IMAGE_SCALAR_F32};
	float *light = allocate(context, &shape);
	if (!light)
		return IMAGE_OUTCOME_CALLBACK;
	unsigned char *codes = malloc((size_t)(input.x_first ? input.height : input.width) * 4);
	if (!codes)
		return IMAGE_OUTCOME_MEMORY;
	bool whole = hdr_read(&input, codes, light);
	free(codes);
	if (whole)
		return IMAGE_OUTCOME_DONE;
	image_message_set(message, input.end - input.at < 4 ? "the file is cut off" : "its pixels are damaged");
	return IMAGE_OUTCOME_CODEC;
}

const image_codec image_codec_hdr = {".hdr", false, hdr_encode, hdr_decode};
