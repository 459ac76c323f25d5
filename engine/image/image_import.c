/* Pictures of unknown origin: PNG, EXR, HDR and most DDS by our own codecs, every other format by OpenImageIO. */
#include "image/image_import.h"

#include "image/image_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* The first bytes of files of each format. Files that are not WebP may begin with RIFF, and raw photographs as TIFF
 * does: the decoder refuses these. */
static const struct image_signature {
	const char *bytes;
	size_t size;
	const image_codec *codec; /* NULL: read by OpenImageIO */
	const char *foreign;      /* OpenImageIO's name of the format */
} image_signatures[] = {
	{"\x89PNG", 4, &image_codec_png, NULL},
	{"\x76\x2f\x31\x01", 4, &image_codec_exr, NULL},
	{"#?", 2, &image_codec_hdr, NULL},
	{"\xff\xd8\xff", 3, NULL, "jpeg"},
	{"BM", 2, NULL, "bmp"},
	{"GIF8", 4, NULL, "gif"},
	{"DDS ", 4, NULL, "dds"},
	{"8BPS", 4, NULL, "psd"},
	{"II*\0", 4, NULL, "tiff"},
	{"MM\0*", 4, NULL, "tiff"},
	{"RIFF", 4, NULL, "webp"},
};

static const struct image_signature image_signature_targa = {.foreign = "targa"};

/* The format of a file by its first bytes, and of TGA, which has no signature, by its name. NULL: unknown. */
static const struct image_signature *image_signature_of(const char *name, const void *data, size_t size)
{
	for (size_t i = 0; i < sizeof image_signatures / sizeof *image_signatures; i++) {
		const struct image_signature *signature = &image_signatures[i];
		if (size >= signature->size && memcmp(data, signature->bytes, signature->size) == 0)
			return signature;
	}
	const char *dot = strrchr(name, '.');
	return dot && strcasecmp(dot, ".tga") == 0 ? &image_signature_targa : NULL;
}

/* False for a JPEG file that ends before its picture does: libjpeg fills the rest with grey. Markers between the scans
 * are passed over by their lengths, for they may hold a picture of their own. Source: ITU-T T.81, B.1.1. */
static bool image_jpeg_ends(const unsigned char *data, size_t size)
{
	size_t at = 2;
	while (at + 1 < size) {
		unsigned char marker = data[at + 1];
		if (data[at] != 0xff || marker == 0xff || marker == 0x00 || (marker >= 0xd0 && marker <= 0xd7)) {
			at++; /* a scan's bytes, its restarts, and fill bytes */
			continue;
		}
		if (marker == 0xd9)
			return true;
		bool alone = marker == 0x01 || marker == 0xd8;
		size_t length = alone ? 0 : at + 3 < size ? (size_t)data[at + 2] << 8 | data[at + 3] : size;
		at += 2 + length;
	}
	return false;
}

static image_outcome image_decode_foreign(const char *format, const void *data, size_t size, image_load *load,
                                          image_message *message)
{
	STILB_ASSERT(format);
	if (strcmp(format, "jpeg") == 0 && !image_jpeg_ends(data, size)) {
		snprintf(message->text, sizeof message->text, "the file is cut off");
		return IMAGE_OUTCOME_CODEC;
	}
	const image_foreign *foreign = image_foreign_load(message);
	return foreign ? foreign->decode(format, data, size, image_load_allocate, load, message) : IMAGE_OUTCOME_CODEC;
}

stilb_result stilb_image_import_memory(const char *name, const void *data, size_t size, uint32_t flags,
                                       stilb_image *image)
{
	STILB_ASSERT(name && image);
	STILB_ASSERT(data || size == 0);
	STILB_ASSERT(flags <= (STILB_IMAGE_IMPORT_SHARED | STILB_IMAGE_IMPORT_FOR_LIGHT | STILB_IMAGE_IMPORT_AGAIN |
	                       STILB_IMAGE_IMPORT_BLOCKS));
	STILB_ASSERT(!(flags & STILB_IMAGE_IMPORT_AGAIN) || flags & STILB_IMAGE_IMPORT_SHARED);
	stilb_image memory = flags & STILB_IMAGE_IMPORT_AGAIN ? *image : (stilb_image){0};
	*image = (stilb_image){0};
	image_load load = {.path = name,
	                   .image = image,
	                   .memory = memory,
	                   .exact = true,
	                   .shared = flags & STILB_IMAGE_IMPORT_SHARED,
	                   .blocks = flags & STILB_IMAGE_IMPORT_BLOCKS,
	                   .for_light = flags & STILB_IMAGE_IMPORT_FOR_LIGHT};
	image_message message = {.text = "it is not a picture of a supported format"};
	image_outcome outcome = IMAGE_OUTCOME_CODEC;
	const struct image_signature *signature = image_signature_of(name, data, size);
	bool dds = signature && signature->foreign && strcmp(signature->foreign, "dds") == 0;
	if (dds && image_dds_is_known(data, size))
		outcome = image_dds_decode(data, size, &load, &message);
	else if (signature && signature->codec)
		outcome = signature->codec->decode(data, size, image_load_allocate, &load, &message);
	else if (signature)
		outcome = image_decode_foreign(signature->foreign, data, size, &load, &message);
	return image_load_end(&load, outcome, &message);
}

stilb_result stilb_image_import(const char *path, uint32_t flags, stilb_image *image)
{
	STILB_ASSERT(path && image);
	STILB_ASSERT(!(flags & STILB_IMAGE_IMPORT_AGAIN));
	*image = (stilb_image){0};
	void *data = NULL;
	size_t size = 0;
	const char *trouble = image_file_read(path, &data, &size);
	stilb_result result = trouble ? stilb_fail(STILB_ERROR_FILE, "cannot read '%s': %s", path, trouble)
	                              : stilb_image_import_memory(path, data, size, flags, image);
	free(data);
	return result;
}

const char *stilb_image_library_version(void)
{
	image_message message;
	const image_foreign *foreign = image_foreign_load(&message);
	return foreign ? foreign->version() : "not found";
}
