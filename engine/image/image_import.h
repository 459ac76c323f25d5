/*
 * image_import: pictures of unknown origin, of many formats. Decoders may crash on files that were crafted for it, so
 * only the import process (engine/scene/importer) and tests call this. OpenImageIO is loaded with the first picture
 * that is neither PNG nor EXR nor HDR nor a DDS file of the formats that stilb_image_load reads.
 *
 * Life cycle.  stilb_image_import -> the picture is used -> stilb_image_finish, or stilb_image_share for another
 *              process.
 * Threads.     [any-thread], several pictures at a time.
 * Errors.      A missing, damaged, too large or unknown file is STILB_ERROR_FILE.
 */
#ifndef STILB_IMAGE_IMPORT_H
#define STILB_IMAGE_IMPORT_H

#include "image/image.h"

typedef enum stilb_image_import_flags {
	STILB_IMAGE_IMPORT_SHARED = 1,    /* allocates by stilb_image_create_shared */
	STILB_IMAGE_IMPORT_FOR_LIGHT = 2, /* also refuses a picture that would exceed STILB_IMAGE_MAX_BYTES as RGB floats */
	STILB_IMAGE_IMPORT_AGAIN = 4,     /* with SHARED: by stilb_image_reshape_shared of image */
	STILB_IMAGE_IMPORT_BLOCKS = 8,    /* DDS as stilb_image_load reads it */
} stilb_image_import_flags;

/* Reads PNG, JPEG, TGA, BMP, GIF, TIFF, DDS, PSD, WebP, EXR and Radiance HDR with the precision and the channels of the
 * file: U8_SRGB or U16_SRGB for codes, F16_LINEAR or F32_LINEAR for floats; other precisions become the next larger. Of
 * DDS, unless BLOCKS is set, the largest level is decoded: BC1, BC3 and BC7 to U8_SRGB, as what a picture is used for
 * says whether it is colour, BC4 and BC5 to U16_LINEAR. Cube maps, arrays and volumes are refused.
 * The format is recognised by the first bytes, TGA by its extension; of several pictures in a file the first is read. A
 * picture that is too large is refused by its header, before it is decoded.
 * flags: stilb_image_import_flags but AGAIN, or 0. [any-thread] STILB_ERROR_FILE, STILB_ERROR_MEMORY; then image is
 * {0}. */
stilb_result stilb_image_import(const char *path, uint32_t flags, stilb_image *image);

/* stilb_image_import of a file in memory, size bytes at data (NULL only if size is 0); name stands in messages, and its
 * extension tells TGA. With STILB_IMAGE_IMPORT_AGAIN image is {0} or a picture of stilb_image_create_shared, whose
 * memory the new one gets if it is large enough. [any-thread] */
stilb_result stilb_image_import_memory(const char *name, const void *data, size_t size, uint32_t flags,
                                       stilb_image *image);

/* Loads OpenImageIO and returns its version, "2.4.7"; "not found" if it cannot be loaded. Static. [any-thread] */
const char *stilb_image_library_version(void);

#endif
