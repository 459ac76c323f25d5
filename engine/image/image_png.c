#include "image/image_internal.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

/* Table for png_crc, one byte at a time: ISO 3309's polynomial, reflected. */
static void png_crc_table(uint32_t table[256])
{
	for (uint32_t i = 0; i < 256; i++) {
		uint32_t crc = i;
		for (int bit = 0; bit < 8; bit++)
			crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
		table[i] = crc;
	}
}

static uint32_t png_crc(const uint32_t table[256], const unsigned char *data, size_t size)
{
	uint32_t crc = ~0u;
	for (size_t i = 0; i < size; i++)
		crc = crc >> 8 ^ table[(crc ^ data[i]) & 255];
	return ~crc;
}

static uint32_t png_u32(const unsigned char *bytes)
{
	return (uint32_t)bytes[0] << 24 | (uint32_t)bytes[1] << 16 | (uint32_t)bytes[2] << 8 | bytes[3];
}

bool image_png_is_whole(const void *data, size_t size, image_message *message)
{
	static const unsigned char signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
	const unsigned char *bytes = data;
	if (size < 8 || memcmp(bytes, signature, 8) != 0) {
		snprintf(message->text, sizeof message->text, "it is not a PNG file");
		return false;
	}
	uint32_t table[256];
	png_crc_table(table);
	/* A chunk: length, name, that many bytes, checksum of name and bytes. */
	for (size_t at = 8; size - at >= 12;) {
		size_t length = png_u32(bytes + at);
		if (length > size - at - 12)
			break;
		if (png_crc(table, bytes + at + 4, length + 4) != png_u32(bytes + at + 8 + length)) {
			snprintf(message->text, sizeof message->text, "the file is damaged near byte %zu", at);
			return false;
		}
		if (memcmp(bytes + at + 4, "IEND", 4) == 0)
			return true;
		at += length + 12;
	}
	snprintf(message->text, sizeof message->text, "the file is cut off");
	return false;
}
