/* Bytes of a stream of a scene, with its limits of time and size. */
#ifndef STILB_SCENE_STREAM_BYTES_H
#define STILB_SCENE_STREAM_BYTES_H

#include "scene/open/scene_stream.h"

/* Writes, reads exactly size bytes. False: the other side is gone; one of the stream's flags late,
 * ended and too_much says why. */
bool scene_stream_put(int file, const void *data, size_t size);
bool scene_stream_get(scene_stream *stream, void *data, size_t size);

/* STILB_ERROR_FILE: reading failed; the scene has impossible `what`. */
stilb_result scene_stream_broken(const scene_stream *stream);
stilb_result scene_stream_wrong(const char *what);

/* Waits until there is something to read. False: the deadline has passed, it was given up, or the descriptor is bad. */
bool scene_stream_wait(scene_stream *stream);

/* False: so many more bytes would exceed the limit. To be asked before memory for them is touched: the other side may
 * announce what it never sends. */
bool scene_stream_has_room(scene_stream *stream, uint64_t size);

/* Counts size more bytes. False: they would exceed the limit. */
bool scene_stream_count(scene_stream *stream, uint64_t size);

#endif
