/*
 * image_layers: pictures of many named channels with text attributes, as EXR files of 32-bit floats.
 *
 * Other programs show channels by their names: "R", "G", "B" are the picture, "albedo.R" is the channel R of the layer
 * albedo. Files are written whole or not at all, and the same channels and attributes give the same bytes.
 *
 * Life cycle.  stilb_image_layers_load -> read the channels -> stilb_image_layers_finish. To save, the caller fills in
 *              a stilb_image_layers around pixels of its own; it is neither changed nor kept, and not finished.
 * Threads.     Reading a loaded picture, loading and saving are [any-thread]; finish is [one-writer].
 * Errors.      As in image.h.
 * Example.     Depth beside a grey picture:
 *
 *   stilb_image_channel channels[] = {{"Y", grey, 1}, {"depth.Z", depth, 1}};
 *   stilb_image_layers layers = {.width = 640, .height = 480, .channel_count = 2, .channels = channels};
 *   stilb_result result = stilb_image_layers_save(&layers, "out.exr");
 */
#ifndef STILB_IMAGE_LAYERS_H
#define STILB_IMAGE_LAYERS_H

#include "image/image.h"

#define STILB_IMAGE_MAX_CHANNELS 64u

typedef struct stilb_image_channel {
	const char *name;
	const float *values; /* value of the top left pixel */
	size_t stride;       /* floats from one pixel to the next, >= 1; rows follow one another without gaps */
} stilb_image_channel;

typedef struct stilb_image_layers {
	uint32_t width, height, channel_count, attribute_count;
	const stilb_image_channel *channels;
	const stilb_image_attribute *attributes;
} stilb_image_layers;

/* Writes path, which ends in .exr: 1..STILB_IMAGE_MAX_CHANNELS channels with different names that are not empty; limits
 * of sides and bytes as in image.h. [any-thread] STILB_ERROR_ARGUMENT for a path, a shape or names that are refused,
 * STILB_ERROR_FILE (disk full), STILB_ERROR_MEMORY. */
stilb_result stilb_image_layers_save(const stilb_image_layers *layers, const char *path);

/* Reads the first part of an EXR file: its channels as floats, R G B A first, and its text attributes. Channels without
 * a layer come first, then layer by layer. [any-thread] STILB_ERROR_ARGUMENT for another extension, STILB_ERROR_FILE
 * for a file that is missing, damaged or too large, STILB_ERROR_MEMORY; then *layers is NULL. */
stilb_result stilb_image_layers_load(const char *path, stilb_image_layers **layers);

/* The channel of this name, or NULL. [any-thread] */
const stilb_image_channel *stilb_image_layers_channel(const stilb_image_layers *layers, const char *name);

/* The text of the attribute of this name, or NULL. [any-thread] */
const char *stilb_image_layers_attribute(const stilb_image_layers *layers, const char *name);

/* Frees a loaded picture with its names, texts and values. Accepts NULL. [one-writer] */
void stilb_image_layers_finish(stilb_image_layers *layers);

#endif
