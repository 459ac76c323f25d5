/*
 * image_import: pictures of unknown origin, of many formats. Decoders crash on files that somebody made for it, so only
 * the import process (engine/scene/importer) and tests call this; it loads OpenImageIO with the first picture that is
 * neither PNG nor EXR nor HDR.
 */
#ifndef STILB_IMAGE_IMPORT_H
#define STILB_IMAGE_IMPORT_H

#include "image/image.h"

typedef enum stilb_image_import_flags {
	STILB_IMAGE_IMPORT_SHARED = 1,    /* pixels as of stilb_image_create_shared */
	STILB_IMAGE_IMPORT_FOR_LIGHT = 2, /* refuses by its header what has no room as three floats a pixel */
} stilb_image_import_flags;

/* Reads PNG, JPEG, TGA, BMP, GIF, TIFF, DDS, PSD, WebP, EXR and Radiance HDR with the precision and the channels of the
 * file: U8_SRGB or U16_SRGB for codes, F16_LINEAR or F32_LINEAR for floats; other precisions become the next larger.
 * The format is told by the first bytes, TGA by its extension; of several pictures in a file the first counts.
 * flags: of stilb_image_import_flags. [any-thread] STILB_ERROR_FILE, STILB_ERROR_MEMORY; then image is {0}. */
stilb_result stilb_image_import(const char *path, uint32_t flags, stilb_image *image);

/* The same from a file in memory; name is what messages call it. */
stilb_result stilb_image_import_memory(const char *name, const void *data, size_t size, uint32_t flags,
                                       stilb_image *image);

/* OpenImageIO's version, as loaded: "2.4.7"; "not found" when it cannot be. [any-thread] */
const char *stilb_image_library_version(void);

#endif
