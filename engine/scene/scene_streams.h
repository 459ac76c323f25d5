/*
 * scene_streams: the table of what a vertex consists of. Whoever treats the values of vertices alike goes by it: the
 * simplifier and its cache (engine/geometry), the device's vertices and frame dumps (engine/render). A further member
 * of stilb_scene_vertex is a further row here; whoever fills it in and the shaders that read it are all that is left.
 *
 * Threads.  Constant data.
 */
#ifndef STILB_SCENE_STREAMS_H
#define STILB_SCENE_STREAMS_H

#include "scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* What the floats of a stream mean. */
typedef enum stilb_scene_stream_kind {
	STILB_SCENE_STREAM_POSITION,  /* metres; the first stream of a table, and no other */
	STILB_SCENE_STREAM_DIRECTION, /* 3 components: a unit vector. Where a vertex morphs to it may be shorter */
	STILB_SCENE_STREAM_TEXTURE,   /* a place on a texture */
	STILB_SCENE_STREAM_VALUE,     /* numbers of size 1, such as a colour */
} stilb_scene_stream_kind;

/* How the device has a stream, if it has packed vertices. */
typedef enum stilb_scene_stream_packing {
	STILB_SCENE_STREAM_FLOATS,     /* as it is */
	STILB_SCENE_STREAM_OCTAHEDRAL, /* DIRECTION in two numbers of 16 bits; only for meshes whose vectors are all unit */
} stilb_scene_stream_packing;

typedef struct stilb_scene_stream {
	const char *name; /* of at most 15 bytes, one of its kind in a table */
	stilb_scene_stream_kind kind;
	uint32_t components; /* floats, 1..4 */
	uint32_t offset;     /* bytes from the vertex's beginning, a multiple of 4 */
	float weight; /* of a difference where meshes are simplified: stilb_geometry_stream.weight; unused by POSITION */
	bool seam;    /* where values of one position differ, simplification keeps the cut */
	stilb_scene_stream_packing packing;
} stilb_scene_stream;

#define STILB_SCENE_MOST_STREAMS 9 /* of a table */

typedef struct stilb_scene_streams {
	uint32_t count; /* 1..STILB_SCENE_MOST_STREAMS */
	uint32_t size;  /* bytes of a vertex, all of which are streams */
	const stilb_scene_stream *streams;
} stilb_scene_streams;

/* The rows of stilb_scene_vertex_streams. */
enum {
	STILB_SCENE_VERTEX_POSITION,
	STILB_SCENE_VERTEX_NORMAL,
	STILB_SCENE_VERTEX_UV,
	STILB_SCENE_VERTEX_STREAMS,
};

/* That of stilb_scene_vertex. */
extern const stilb_scene_streams stilb_scene_vertex_streams;

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
