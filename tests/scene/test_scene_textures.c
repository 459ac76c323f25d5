/* Textures of scenes as somebody hostile, or a bad program, writes them: each is shown, or named in a line with the
 * reason. Memory and time stay bounded, and nothing crashes. With the argument `large` those of gigabytes. */
#include "engine/answers/png_made.h"
#include "glb_made.h"
#include "image/image.h"

#include <time.h>

/* ---- files ------------------------------------------------------------------------------------------------------- */

/* 8 x 8 pixels of (255, 0, 128) in CMYK, and in YCbCr, written by libjpeg. */
static const unsigned char jpeg_cmyk[] = {
	255, 216, 255, 238, 0,   14,  65,  100, 111, 98,  101, 0,   100, 0,   0,  0,   0,   2,   255, 219, 0,  67, 0,
	16,  11,  12,  14,  12,  10,  16,  14,  13,  14,  18,  17,  16,  19,  24, 40,  26,  24,  22,  22,  24, 49, 35,
	37,  29,  40,  58,  51,  61,  60,  57,  51,  56,  55,  64,  72,  92,  78, 64,  68,  87,  69,  55,  56, 80, 109,
	81,  87,  95,  98,  103, 104, 103, 62,  77,  113, 121, 112, 100, 120, 92, 101, 103, 99,  255, 219, 0,  67, 1,
	17,  18,  18,  24,  21,  24,  47,  26,  26,  47,  99,  66,  56,  66,  99, 99,  99,  99,  99,  99,  99, 99, 99,
	99,  99,  99,  99,  99,  99,  99,  99,  99,  99,  99,  99,  99,  99,  99, 99,  99,  99,  99,  99,  99, 99, 99,
	99,  99,  99,  99,  99,  99,  99,  99,  99,  99,  99,  99,  99,  99,  99, 99,  99,  99,  255, 192, 0,  20, 8,
	0,   8,   0,   8,   4,   1,   34,  0,   2,   17,  1,   3,   17,  1,   4,  34,  0,   255, 196, 0,   22, 0,  1,
	1,   1,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,  0,   5,   7,   255, 196, 0,  20, 16,
	1,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,  0,   0,   255, 196, 0,   21, 1,  1,
	1,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,  4,   6,   255, 196, 0,   20, 17, 1,
	0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,  0,   255, 218, 0,   14,  4,  1,  0,
	2,   17,  3,   17,  4,   0,   0,   63,  0,   164, 0,   168, 134, 128, 3,  255, 217};
static const unsigned char jpeg_ycc[] = {
	255, 216, 255, 224, 0,   16,  74,  70,  73,  70,  0,   1,   1,   0,  0,   1,   0,  1,   0,   0,  255, 219, 0,   67,
	0,   16,  11,  12,  14,  12,  10,  16,  14,  13,  14,  18,  17,  16, 19,  24,  40, 26,  24,  22, 22,  24,  49,  35,
	37,  29,  40,  58,  51,  61,  60,  57,  51,  56,  55,  64,  72,  92, 78,  64,  68, 87,  69,  55, 56,  80,  109, 81,
	87,  95,  98,  103, 104, 103, 62,  77,  113, 121, 112, 100, 120, 92, 101, 103, 99, 255, 219, 0,  67,  1,   17,  18,
	18,  24,  21,  24,  47,  26,  26,  47,  99,  66,  56,  66,  99,  99, 99,  99,  99, 99,  99,  99, 99,  99,  99,  99,
	99,  99,  99,  99,  99,  99,  99,  99,  99,  99,  99,  99,  99,  99, 99,  99,  99, 99,  99,  99, 99,  99,  99,  99,
	99,  99,  99,  99,  99,  99,  99,  99,  99,  99,  99,  99,  99,  99, 255, 192, 0,  17,  8,   0,  8,   0,   8,   3,
	1,   34,  0,   2,   17,  1,   3,   17,  1,   255, 196, 0,   21,  0,  1,   1,   0,  0,   0,   0,  0,   0,   0,   0,
	0,   0,   0,   0,   0,   0,   0,   5,   255, 196, 0,   20,  16,  1,  0,   0,   0,  0,   0,   0,  0,   0,   0,   0,
	0,   0,   0,   0,   0,   0,   255, 196, 0,   21,  1,   1,   1,   0,  0,   0,   0,  0,   0,   0,  0,   0,   0,   0,
	0,   0,   0,   4,   6,   255, 196, 0,   20,  17,  1,   0,   0,   0,  0,   0,   0,  0,   0,   0,  0,   0,   0,   0,
	0,   0,   0,   255, 218, 0,   12,  3,   1,   0,   2,   17,  3,   17, 0,   63,  0,  152, 1,   75, 119, 255, 217};

/* Two pictures of 4 x 4 pixels, the first one red, the second one blue. */
static const unsigned char gif_moving[] = {
	71, 73, 70, 56, 57,  97, 4,  0,  4,   0,  240, 0,   0,  255, 0,  0,  0,   0,   0,   33, 249, 4, 0,  0,
	0,  0,  0,  33, 255, 11, 78, 69, 84,  83, 67,  65,  80, 69,  50, 46, 48,  3,   1,   0,  0,   0, 44, 0,
	0,  0,  0,  4,  0,   4,  0,  0,  2,   4,  132, 143, 9,  5,   0,  33, 249, 4,   0,   0,  0,   0, 0,  44,
	0,  0,  0,  0,  4,   0,  4,  0,  128, 0,  0,   255, 0,  0,   0,  2,  4,   132, 143, 9,  5,   0, 59};

typedef struct bits {
	unsigned char *data; /* of malloc */
	size_t size;
	uint32_t held, count; /* bits that are no whole byte yet */
} bits;

/* Appends bits, the lowest first. */
static void bits_put(bits *to, uint32_t value, uint32_t count)
{
	to->held |= value << to->count;
	for (to->count += count; to->count >= 8; to->count -= 8, to->held >>= 8)
		to->data[to->size++] = (unsigned char)to->held;
}

/* Compresses zeros: RFC 1951 with the fixed codes, literals and copies of 258 bytes, in the envelope of RFC 1950. They
 * stand behind 8 unused bytes. */
static bits zeros_compressed(uint64_t zeros)
{
	bits to = {.data = malloc(zeros / 150 + 1024), .size = 8};
	uint64_t copies = (zeros - 1) / 258, literals = zeros - copies * 258;
	assert_non_null(to.data);
	bits_put(&to, 0x0178, 16);
	bits_put(&to, 3, 3);
	for (uint64_t i = 0; i < literals; i++)
		bits_put(&to, 0x0c, 8); /* 00110000, the highest bit first */
	for (uint64_t i = 0; i < copies; i++) {
		bits_put(&to, 0xa3, 8); /* 11000101: 258 bytes */
		bits_put(&to, 0, 5);    /* from one byte before */
	}
	bits_put(&to, 0, 7);
	bits_put(&to, 0, (8 - to.count) % 8);
	uint32_t sums = (uint32_t)(zeros % 65521) << 16 | 1;
	for (int i = 24; i >= 0; i -= 8)
		to.data[to.size++] = (unsigned char)(sums >> i);
	return to;
}

/* bytes: of malloc, with room for 12 more; the content stands behind the first 8, which become length and kind. */
static void put_chunk(FILE *file, const char *kind, unsigned char *bytes, size_t size)
{
	png_made_bytes made = {.data = bytes};
	png_made_chunk(&made, kind, (uint32_t)size);
	fwrite(made.data, 1, made.size, file);
}

#define PNG_PALETTE 3 /* beside png_made_color */

/* Bytes of a picture's lines, of Adam7 those of its seven pictures. Source: ISO/IEC 15948, 8.2. */
static uint64_t png_bytes(uint32_t width, uint32_t height, uint32_t pixel, bool interlaced)
{
	static const uint32_t passes[7][4] = {{0, 0, 8, 8}, {4, 0, 8, 8}, {0, 4, 4, 8}, {2, 0, 4, 4},
	                                      {0, 2, 2, 4}, {1, 0, 2, 2}, {0, 1, 1, 2}};
	if (!interlaced)
		return (uint64_t)height * (1ull + (uint64_t)width * pixel);
	uint64_t bytes = 0;
	for (int p = 0; p < 7; p++) {
		const uint32_t *pass = passes[p];
		uint64_t across = (width + pass[2] - 1 - pass[0]) / pass[2], down = (height + pass[3] - 1 - pass[1]) / pass[3];
		bytes += across > 0 ? down * (1 + across * pixel) : 0;
	}
	return bytes;
}

/* Writes a PNG of zeros; of a palette, the colour (10, 200, 30) with alpha 99. pixels: false, the
 * file has one byte of them. */
static void write_png(const char *name, uint32_t width, uint32_t height, int color, uint32_t depth, bool interlaced,
                      bool pixels)
{
	static const uint32_t channels[] = {
		[PNG_MADE_GREY] = 1, [PNG_MADE_RGB] = 3, [PNG_PALETTE] = 1, [PNG_MADE_GREY_ALPHA] = 2, [PNG_MADE_RGBA] = 4};
	FILE *file = fopen(name, "wb");
	assert_non_null(file);
	fwrite("\x89PNG\r\n\x1a\n", 1, 8, file);
	unsigned char chunk[64] = {0};
	png_made_u32(chunk + 8, width);
	png_made_u32(chunk + 12, height);
	chunk[16] = (unsigned char)depth;
	chunk[17] = (unsigned char)color;
	chunk[20] = interlaced;
	put_chunk(file, "IHDR", chunk, 13);
	if (color == PNG_PALETTE) {
		memcpy(chunk + 8, (const unsigned char[]){10, 200, 30}, 3);
		put_chunk(file, "PLTE", chunk, 3);
		chunk[8] = 99;
		put_chunk(file, "tRNS", chunk, 1);
	}
	bits packed = zeros_compressed(pixels ? png_bytes(width, height, channels[color] * depth / 8, interlaced) : 1);
	put_chunk(file, "IDAT", packed.data, packed.size - 8);
	free(packed.data);
	put_chunk(file, "IEND", chunk, 0);
	assert_int_equal(fclose(file), 0);
}

/* Writes test.glb with a triangle for each picture, of a material "m" that has it as its colour, and opens it. */
static stilb_scene *open_with(const char *const *names, uint32_t count, uint64_t *bytes)
{
	char *text;
	size_t size;
	FILE *json = open_memstream(&text, &size);
	assert_non_null(json);
	begin();
	put(triangle, sizeof triangle);
	fprintf(json, NODE ",\"accessors\":[" VEC3(0) "],\"meshes\":[{\"primitives\":[");
	for (uint32_t i = 0; i < count; i++)
		fprintf(json, "%s{\"attributes\":{\"POSITION\":0},\"material\":%u}", i ? "," : "", i);
	fprintf(json, "]}],\"materials\":[");
	for (uint32_t i = 0; i < count; i++)
		fprintf(json, "%s{\"name\":\"m\",\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":%u}}}", i ? "," : "",
		        i);
	fprintf(json, "],\"textures\":[");
	for (uint32_t i = 0; i < count; i++)
		fprintf(json, "%s{\"source\":%u}", i ? "," : "", i);
	fprintf(json, "],\"images\":[");
	for (uint32_t i = 0; i < count; i++)
		fprintf(json, "%s{\"uri\":\"%s\"}", i ? "," : "", names[i]);
	fprintf(json, "]");
	fclose(json);
	write_glb(text);
	free(text);
	stilb_scene *scene;
	said[0] = '\0';
	stilb_scene_open_options options = {.import_bytes = bytes};
	if (stilb_scene_open_with("test.glb", &options, &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return scene;
}

static char told[1 << 17];

static void take_log(void *user, const char *line)
{
	(void)user;
	size_t used = strlen(told);
	snprintf(told + used, sizeof told - used, "%s\n", line);
}

static stilb_scene *open_one(const char *name)
{
	told[0] = '\0';
	return open_with(&name, 1, NULL);
}

static void assert_told(const char *name, const char *words)
{
	char line[256];
	snprintf(line, sizeof line, "texture '%s': ", name);
	const char *at = strstr(told, line);
	if (!at || strncmp(at + strlen(line), words, strlen(words)) != 0)
		fail_msg("%s: '%s' does not say '%s'", name, told, words);
}

/* ---- tests ------------------------------------------------------------------------------------------------------- */

/* Unusual pictures that are as good as others; the first texel is what they say. */
static void odd_pictures_are_shown(void **state)
{
	(void)state;
	static const struct {
		const char *name;
		uint32_t width, height, channels;
		stilb_image_format format;
		uint8_t texel[4];
	} rows[] = {
		{"one.png", 1, 1, 3, STILB_IMAGE_U8_SRGB, {0}},
		{"column.png", 1, 4096, 3, STILB_IMAGE_U8_SRGB, {0}},
		{"row.png", 4096, 1, 1, STILB_IMAGE_U8_SRGB, {0}},
		{"deep.png", 16, 16, 4, STILB_IMAGE_U16_SRGB, {0}},
		{"laced.png", 13, 7, 3, STILB_IMAGE_U8_SRGB, {0}},
		{"palette.png", 16, 16, 4, STILB_IMAGE_U8_SRGB, {10, 200, 30, 99}},
		{"grey alpha.png", 16, 16, 2, STILB_IMAGE_U8_SRGB, {0}},
		{"wrong ending.jpg", 8, 8, 3, STILB_IMAGE_U8_SRGB, {0}},
		{"cmyk.jpg", 8, 8, 3, STILB_IMAGE_U8_SRGB, {254, 0, 128}},
		{"ycc.jpg", 8, 8, 3, STILB_IMAGE_U8_SRGB, {254, 0, 128}},
		{"moving.gif", 4, 4, 4, STILB_IMAGE_U8_SRGB, {255, 0, 0, 255}},
	};
	write_png("one.png", 1, 1, PNG_MADE_RGB, 8, false, true);
	write_png("column.png", 1, 4096, PNG_MADE_RGB, 8, false, true);
	write_png("row.png", 4096, 1, PNG_MADE_GREY, 8, false, true);
	write_png("deep.png", 16, 16, PNG_MADE_RGBA, 16, false, true);
	write_png("laced.png", 13, 7, PNG_MADE_RGB, 8, true, true);
	write_png("palette.png", 16, 16, PNG_PALETTE, 8, false, true);
	write_png("grey alpha.png", 16, 16, PNG_MADE_GREY_ALPHA, 8, false, true);
	write_png("wrong ending.jpg", 8, 8, PNG_MADE_RGB, 8, false, true);
	write_file("cmyk.jpg", jpeg_cmyk, sizeof jpeg_cmyk);
	write_file("ycc.jpg", jpeg_ycc, sizeof jpeg_ycc);
	write_file("moving.gif", gif_moving, sizeof gif_moving);
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		stilb_scene *scene = open_one(rows[i].name);
		if (scene->texture_count != 1)
			fail_msg("%s: %s", rows[i].name, told);
		assert_null(strstr(told, "texture"));
		const stilb_image *image = &scene->textures[0];
		if (image->width != rows[i].width || image->height != rows[i].height || image->channels != rows[i].channels ||
		    image->format != rows[i].format)
			fail_msg("%s: %u x %u, %u channels, format %d", rows[i].name, image->width, image->height, image->channels,
			         image->format);
		for (uint32_t c = 0; c < image->channels && image->format == STILB_IMAGE_U8_SRGB; c++)
			if (abs(((const uint8_t *)image->pixels)[c] - rows[i].texel[c]) > 2)
				fail_msg("%s: channel %u is %u", rows[i].name, c, ((const uint8_t *)image->pixels)[c]);
		stilb_scene_destroy(scene);
		remove(rows[i].name);
	}
}

#define CUT_MOST 320u

/* Writes every beginning of a file, and asserts that each is named with a reason and none is shown. */
static void cut_everywhere(const unsigned char *bytes, uint32_t size, const char *ending)
{
	static char names[CUT_MOST][24];
	static const char *list[CUT_MOST];
	assert_true(size <= CUT_MOST);
	for (uint32_t i = 0; i < size; i++) {
		snprintf(names[i], sizeof names[i], "cut-%u.%s", i, ending);
		list[i] = names[i];
		write_file(names[i], bytes, i);
	}
	told[0] = '\0';
	stilb_scene *scene = open_with(list, size, NULL);
	assert_int_equal(scene->texture_count, 0);
	for (uint32_t i = 0; i < size; i++) {
		assert_told(names[i], "");
		assert_true(scene->materials[i].diffuse[0] > 0.9f); /* magenta */
		assert_true(scene->materials[i].diffuse[1] < 0.01f);
		remove(names[i]);
	}
	assert_null(strstr(told, "crash"));
	assert_null(strstr(told, "broke off"));
	stilb_scene_destroy(scene);
}

static void cut_pictures_are_named(void **state)
{
	(void)state;
	unsigned char bytes[CUT_MOST];
	write_png("whole.png", 16, 16, PNG_MADE_RGB, 8, false, true);
	FILE *file = fopen("whole.png", "rb");
	assert_non_null(file);
	size_t size = fread(bytes, 1, sizeof bytes, file);
	fclose(file);
	remove("whole.png");
	cut_everywhere(bytes, (uint32_t)size, "png");
	cut_everywhere(jpeg_ycc, sizeof jpeg_ycc, "jpg");
	cut_everywhere(gif_moving, 40, "gif");
}

static void what_is_no_picture_is_named(void **state)
{
	(void)state;
	static const char words[] = "this is text, whatever its name says\n";
	static const unsigned char zeros[4096];
	static const struct {
		const char *name, *says;
	} rows[] = {
		{"empty.png", "the file is empty"},
		{"words.png", "it is not a picture of a supported format"},
		{"zeros.jpg", "it is not a picture of a supported format"},
		{"missing.png", "there is no such file"},
		{"claims.png", "it has 65537 x 1 pixels"},
		{"claims more.png", "it has 65536 x 65536 pixels; its pixels would take more than 4 GiB"},
		{"nothing.png", "the file is damaged"},
	};
	write_file("empty.png", "", 0);
	write_file("words.png", words, sizeof words - 1);
	write_file("zeros.jpg", zeros, sizeof zeros);
	write_png("claims.png", 65537, 1, PNG_MADE_RGB, 8, false, true);
	write_png("claims more.png", 65536, 65536, PNG_MADE_RGBA, 16, false, false);
	write_png("nothing.png", 16384, 16384, PNG_MADE_RGB, 8, false, false);
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		uint64_t bytes = 0;
		told[0] = '\0';
		stilb_scene *scene = open_with(&rows[i].name, 1, &bytes);
		assert_told(rows[i].name, rows[i].says);
		assert_int_equal(scene->texture_count, 0);
		assert_true(TEST_ASAN || bytes < (64u << 20)); /* it is refused before memory for its pixels is touched */
		stilb_scene_destroy(scene);
		remove(rows[i].name);
	}
}

/* Number i of a picture, of codes the code. */
static float value_of(const stilb_image *image, size_t i)
{
	switch (image->format) {
	case STILB_IMAGE_U8_SRGB:
		return (float)((const uint8_t *)image->pixels)[i];
	case STILB_IMAGE_U16_SRGB:
		return (float)((const uint16_t *)image->pixels)[i];
	case STILB_IMAGE_F16_LINEAR:
		return stilb_image_half_to_float(((const uint16_t *)image->pixels)[i]);
	default:
		return ((const float *)image->pixels)[i];
	}
}

static void set_value(stilb_image *image, size_t i, float value)
{
	if (image->format == STILB_IMAGE_U8_SRGB)
		((uint8_t *)image->pixels)[i] = (uint8_t)value;
	else if (image->format == STILB_IMAGE_F16_LINEAR)
		((uint16_t *)image->pixels)[i] = stilb_image_half_from_float(value);
	else
		((float *)image->pixels)[i] = value;
}

#define WIDE 16386u

/* The texture of a file is WIDE / 2 x 1, and its channels have these values. */
static void assert_halved(const char *name, stilb_image_format format, const float values[3])
{
	stilb_scene *scene = open_one(name);
	assert_told(name, "of its 16386 x ");
	const stilb_image *half = &scene->textures[0];
	assert_true(scene->texture_count == 1 && half->format == format && half->width == WIDE / 2 && half->height == 1);
	for (size_t i = 0; i < (size_t)half->width * half->channels; i++)
		assert_true(fabsf(value_of(half, i) - values[i % half->channels]) < 1e-3f);
	stilb_scene_destroy(scene);
	remove(name);
}

/* Scenes have textures of at most 16384 a side: larger ones are halved, by means of four values. */
static void long_sides_are_halved(void **state)
{
	(void)state;
	static const stilb_image_format formats[] = {STILB_IMAGE_U8_SRGB, STILB_IMAGE_F16_LINEAR, STILB_IMAGE_F32_LINEAR};
	for (size_t f = 0; f < sizeof formats / sizeof *formats; f++) {
		stilb_image image;
		const char *name = formats[f] == STILB_IMAGE_U8_SRGB ? "wide.png" : "wide.exr";
		assert_int_equal(stilb_image_create(&image, WIDE, 2, 3, formats[f]), STILB_OK);
		for (uint32_t i = 0; i < WIDE * 2 * 3; i++)
			set_value(&image, i, i % 3 == 0 ? 10.0f * (float)(i / 3 % 2) : i / 3 >= WIDE ? 40.0f : 20.0f);
		assert_int_equal(stilb_image_save(&image, name), STILB_OK);
		stilb_image_finish(&image);
		assert_halved(name, formats[f], (const float[]){5, 30, 30});
	}
	static unsigned char words[WIDE][2];
	for (uint32_t x = 0; x < WIDE; x++) {
		words[x][0] = 3; /* the high byte */
		words[x][1] = x % 2 ? 100 : 200;
	}
	png_made_bytes deep = png_made(WIDE, 1, PNG_MADE_GREY, 16, words);
	write_file("wide.png", deep.data, deep.size);
	free(deep.data);
	assert_halved("wide.png", STILB_IMAGE_U16_SRGB, (const float[3]){3 * 256 + 150});
	write_png("long.png", 1, 65536, PNG_MADE_GREY, 8, false, true);
	stilb_scene *scene = open_one("long.png");
	assert_told("long.png", "of its 1 x 65536 pixels 1 x 16384 are kept: a side has 16384 at most");
	assert_true(scene->texture_count == 1 && scene->textures[0].height == 16384 && scene->textures[0].width == 1);
	stilb_scene_destroy(scene);
	remove("long.png");
}

/* Floats may hold anything: what is NaN or infinite is 0, and told. */
static void values_that_are_none_are_0(void **state)
{
	(void)state;
	static const float bad[4] = {NAN, INFINITY, -INFINITY, -NAN};
	for (int half = 0; half < 2; half++) {
		stilb_image image;
		stilb_image_format format = half ? STILB_IMAGE_F16_LINEAR : STILB_IMAGE_F32_LINEAR;
		assert_int_equal(stilb_image_create(&image, 4, 4, 3, format), STILB_OK);
		for (uint32_t i = 0; i < 48; i++)
			set_value(&image, i, i % 12 < 4 ? bad[i % 4] : 0.5f);
		assert_int_equal(stilb_image_save(&image, "none.exr"), STILB_OK);
		stilb_image_finish(&image);
		stilb_scene *scene = open_one("none.exr");
		assert_told("none.exr", "16 of its values are NaN or infinite, and count as 0");
		assert_int_equal(scene->textures[0].format, format);
		for (uint32_t i = 0; i < 48; i++)
			assert_true(value_of(&scene->textures[0], i) == (i % 12 < 4 ? 0.0f : 0.5f));
		assert_true(scene->materials[0].diffuse[0] >= 0.0f && scene->materials[0].diffuse[0] < 1.0f); /* the mean */
		stilb_scene_destroy(scene);
		remove("none.exr");
	}
}

/* ---- large ones -------------------------------------------------------------------------------------------------- */

#define LARGE 9u /* textures of 256 MiB, from files of 1.7 MiB: 2.25 GiB */

static void small_files_of_gigabytes(void **state)
{
	(void)state;
	static char names[LARGE][24];
	static const char *list[LARGE];
	uint64_t bytes = 0;
	struct timespec before, after;
	write_png("large-0.png", 16384, 16384, PNG_MADE_GREY, 8, false, true);
	for (uint32_t i = 0; i < LARGE; i++) {
		snprintf(names[i], sizeof names[i], "large-%u.png", i);
		list[i] = names[i];
		assert_true(i == 0 || link(names[0], names[i]) == 0);
	}
	told[0] = '\0';
	clock_gettime(CLOCK_MONOTONIC, &before);
	stilb_scene *scene = open_with(list, LARGE, &bytes);
	clock_gettime(CLOCK_MONOTONIC, &after);
	print_message("%u textures of %u in %ld s, %llu MiB\n", scene->texture_count, LARGE, after.tv_sec - before.tv_sec,
	              (unsigned long long)(bytes >> 20));
	/* What finds no memory is named: the import process has three quarters of the machine's. */
	uint32_t named = 0;
	for (uint32_t i = 0; i < LARGE; i++) {
		named += strstr(told, names[i]) ? 1 : 0;
		remove(names[i]);
	}
	assert_int_equal(scene->texture_count + named, LARGE);
	assert_true(scene->texture_count > 0 && bytes < (uint64_t)LARGE * (256u << 20) + (256u << 20));
	stilb_scene_destroy(scene);
}

static int set_up(void **state)
{
	stilb_log_set(take_log, NULL);
	return folder_make(state);
}

static int tear_down(void **state)
{
	stilb_log_set(NULL, NULL);
	return glb_clear(state);
}

int main(int argc, char **argv)
{
	(void)argv;
	const struct CMUnitTest large[] = {cmocka_unit_test(small_files_of_gigabytes)};
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(odd_pictures_are_shown),      cmocka_unit_test(cut_pictures_are_named),
		cmocka_unit_test(what_is_no_picture_is_named), cmocka_unit_test(long_sides_are_halved),
		cmocka_unit_test(values_that_are_none_are_0),
	};
	return argc > 1 ? cmocka_run_group_tests_name("large", large, set_up, tear_down)
	                : cmocka_run_group_tests(tests, set_up, tear_down);
}
