/*
 * image_layers: pictures of many named channels and what is to be known about them, as EXR files of 32-bit floats.
 *
 * A channel's name is what other programs show: "R", "G", "B" are the picture, "albedo.R" the channel R of the layer
 * albedo. Files are written whole or not at all, and the same channels and attributes give the same bytes.
 *
 * Life cycle.  stilb_image_layers_load -> channels are read -> stilb_image_layers_finish. What is saved stays the
 * caller's.
 * Errors.      As in image.h.
 */
#ifndef STILB_IMAGE_LAYERS_H
#define STILB_IMAGE_LAYERS_H

#include "image/image.h"

#define STILB_IMAGE_MAX_CHANNELS 64u

typedef struct stilb_image_channel {
	const char *name;
	const float *values; /* the first pixel's, top left */
	size_t stride;       /* floats from one pixel to the next; rows follow one another without a gap */
} stilb_image_channel;

typedef struct stilb_image_attribute {
	const char *name, *text;
} stilb_image_attribute;

typedef struct stilb_image_layers {
	uint32_t width, height, channel_count, attribute_count;
	const stilb_image_channel *channels;
	const stilb_image_attribute *attributes;
} stilb_image_layers;

/* 1..STILB_IMAGE_MAX_CHANNELS channels whose names differ, sides and bytes as in image.h; path ends in .exr.
 * [any-thread] STILB_ERROR_ARGUMENT, STILB_ERROR_FILE (disk full), STILB_ERROR_MEMORY. */
stilb_result stilb_image_layers_save(const stilb_image_layers *layers, const char *path);

/* The first part of an EXR file: its channels as floats, R G B A first, and those attributes that are text.
 * [any-thread] STILB_ERROR_ARGUMENT, STILB_ERROR_FILE, STILB_ERROR_MEMORY; then *layers is NULL. */
stilb_result stilb_image_layers_load(const char *path, stilb_image_layers **layers);

/* Of a loaded one; NULL where there is none of that name. [any-thread] */
const stilb_image_channel *stilb_image_layers_channel(const stilb_image_layers *layers, const char *name);
const char *stilb_image_layers_attribute(const stilb_image_layers *layers, const char *name);

/* Frees what was loaded. Accepts NULL. */
void stilb_image_layers_finish(stilb_image_layers *layers);

#endif
