/* PNG files of any bit depth and kind of colour, which the library that Stilb writes PNG with is not asked for:
 * uncompressed, in one piece. Source: ISO/IEC 15948; RFC 1950, 1951. */
#ifndef PNG_MADE_H
#define PNG_MADE_H

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef enum png_made_color {
	PNG_MADE_GREY = 0,
	PNG_MADE_RGB = 2,
	PNG_MADE_GREY_ALPHA = 4,
	PNG_MADE_RGBA = 6
} png_made_color;

typedef struct png_made_bytes {
	unsigned char *data; /* of malloc */
	size_t size;
} png_made_bytes;

static inline void png_made_u32(unsigned char *at, uint32_t value)
{
	for (int i = 0; i < 4; i++)
		at[i] = (unsigned char)(value >> (24 - 8 * i));
}

static inline uint32_t png_made_crc(const unsigned char *data, size_t size)
{
	uint32_t crc = UINT32_MAX;
	for (size_t i = 0; i < size; i++) {
		crc ^= data[i];
		for (int bit = 0; bit < 8; bit++)
			crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
	}
	return ~crc;
}

/* Appends a chunk of this kind, whose content was written behind its first 8 bytes. */
static inline void png_made_chunk(png_made_bytes *to, const char *kind, uint32_t size)
{
	unsigned char *at = to->data + to->size;
	png_made_u32(at, size);
	memcpy(at + 4, kind, 4);
	png_made_u32(at + 8 + size, png_made_crc(at + 4, size + 4));
	to->size += size + 12u;
}

/* pixels: [height][width][channels] numbers of `depth` bits, 8 or 16, the high byte first. At most 64 KiB of rows. */
static inline png_made_bytes png_made(uint32_t width, uint32_t height, png_made_color color, uint32_t depth,
                                      const void *pixels)
{
	static const uint32_t channels[] = {
		[PNG_MADE_GREY] = 1, [PNG_MADE_RGB] = 3, [PNG_MADE_GREY_ALPHA] = 2, [PNG_MADE_RGBA] = 4};
	uint32_t row = width * channels[color] * depth / 8, raw = height * (row + 1);
	png_made_bytes made = {malloc(raw + 256u), 8};
	if (!made.data || raw > 65535)
		abort();
	memcpy(made.data, "\x89PNG\r\n\x1a\n", 8);
	unsigned char *at = made.data + 16;
	png_made_u32(at, width);
	png_made_u32(at + 4, height);
	const unsigned char rest[5] = {(unsigned char)depth, (unsigned char)color, 0, 0, 0};
	memcpy(at + 8, rest, 5);
	png_made_chunk(&made, "IHDR", 13);
	at = made.data + made.size + 8;
	const unsigned char begin[7] = {
		0x78, 1, 1, (unsigned char)raw, (unsigned char)(raw >> 8), (unsigned char)~raw, (unsigned char)(~raw >> 8)};
	memcpy(at, begin, 7); /* one stored block */
	uint32_t a = 1, b = 0;
	for (uint32_t y = 0; y < height; y++) {
		at[7 + y * (row + 1)] = 0; /* no filter */
		memcpy(at + 8 + y * (row + 1), (const unsigned char *)pixels + y * row, row);
	}
	for (uint32_t i = 0; i < raw; i++) {
		a = (a + at[7 + i]) % 65521;
		b = (b + a) % 65521;
	}
	png_made_u32(at + 7 + raw, b << 16 | a);
	png_made_chunk(&made, "IDAT", raw + 11);
	png_made_chunk(&made, "IEND", 0);
	return made;
}

#endif
