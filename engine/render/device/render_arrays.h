/*
 * Array images: textures of one size and format that surfaces name are layers of a few images, so that draws with
 * different textures need the same images bound. Inside render/.
 *
 * Growth.    Images are never copied or resized: where no layer is free another image is made. It has as many layers
 *            as all of that kind before it together, at least as many as are expected, and at most RENDER_ARRAY_BYTES;
 *            one, where a layer has RENDER_ARRAY_LARGE bytes or more. A layer that is given back is used again; an
 *            image without textures is destroyed.
 * Threads.   The caller holds the lock of render_resources.
 */
#ifndef RENDER_ARRAYS_H
#define RENDER_ARRAYS_H

#include "gpu/gpu.h"
#include "image/image.h"

#define RENDER_ARRAY_BYTES ((uint64_t)512 << 20)
#define RENDER_ARRAY_LARGE ((uint64_t)2 << 20)

/* What the layers of an image have in common. */
typedef struct render_array_kind {
	uint32_t width, height;
	stilb_gpu_format format;
	uint32_t mips;
} render_array_kind;

/* An image of such layers. */
typedef struct render_array {
	render_array_kind kind;
	stilb_gpu_image image; /* {0}: the entry is free */
	uint32_t serial;       /* no array before had it */
	uint32_t next;         /* 1 + the next one in the chain, or free; 0: none */
	uint32_t layers, used;
	uint64_t taken[2048 / 64]; /* bit by layer */
} render_array;

/* How many more textures of a kind are expected. */
typedef struct render_array_hope {
	render_array_kind kind;
	uint32_t count;
} render_array_hope;

#define RENDER_ARRAY_CHAINS 256u

typedef struct render_arrays {
	render_array *items; /* [capacity], `count` were ever in use */
	uint32_t count, capacity, free, serial;
	uint32_t chains[RENDER_ARRAY_CHAINS]; /* 1 + the first array, by kind; 0: none */
	render_array_hope *hopes;             /* [hope_count] */
	uint32_t hope_count, hope_capacity;
} render_arrays;

typedef struct render_device render_device;

/* That of the textures that are made of images of this format. [any-thread] */
stilb_gpu_format render_texture_format(stilb_image_format format);
/* How those of this format are seen: one channel as grey, two as grey with alpha, as texels of them are. */
stilb_gpu_channels render_texture_channels(stilb_gpu_format format);

/* Bytes of a layer with its mips. */
uint64_t render_array_layer(const render_array_kind *kind);
/* True if each such texture has an image of its own. */
bool render_array_is_large(const render_array_kind *kind);
/* Takes a free layer. *array: index of render_arrays.items. STILB_ERROR_MEMORY, with a message; errors of
 * stilb_gpu_image_create. */
stilb_result render_array_take(render_device *device, const render_array_kind *kind, uint32_t *array, uint16_t *layer);
void render_array_give(render_device *device, uint32_t array, uint16_t layer);
/* Announces one more texture of this kind. False: no memory. */
bool render_array_expect(render_arrays *arrays, const render_array_kind *kind);
/* Nothing is expected any more. */
void render_array_expect_none(render_arrays *arrays);
/* Frees the tables; the images go with the device. */
void render_arrays_finish(render_arrays *arrays);

#endif
