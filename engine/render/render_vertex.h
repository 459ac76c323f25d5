/*
 * The vertices of meshes as the device has them, by the table of streams (scene/scene_streams.h). Inside render/.
 *
 * Floats.  Each vertex as the scene has it.
 * Packed.  The streams follow one another in the order of the table: FLOATS as they are, so that positions are exact
 *          and neighbouring meshes do not tear; OCTAHEDRAL ones in 32 bits: two numbers of 16 bits on the octahedral
 *          map (shade_octahedral_from_direction), x below y, each 1/32767. That is off by at most
 *          RENDER_PACKED_ANGLE. Of a stilb_scene_vertex 24 bytes are left of 32.
 * Pairs.   Of meshes that morph each vertex is followed by the place that it moves to (render_levels). Its vectors may
 *          be shorter than unit, and tell by that how fast the finer triangles' normals turn. Packed they have x, y, z
 *          in 11, 11 and 10 bits, each 1/1023, 1/1023 and 1/511, from the lowest bit on: off by at most
 *          RENDER_PACKED_MORPH.
 */
#ifndef STILB_RENDER_VERTEX_H
#define STILB_RENDER_VERTEX_H

#include "scene/scene_streams.h"

/* Radians. The half step of a number, 1/65534, in both directions, where the map stretches most: by 3 in the middle of
 * the octahedron's faces, which lie at 1 / sqrt(3) of the sphere's radius. Rounding of floats is in it. */
#define RENDER_PACKED_ANGLE 6.6e-5f
/* Length of the difference: half a step of each number. */
#define RENDER_PACKED_MORPH 1.21e-3f

/* A stream on the device. */
typedef struct render_attribute {
	stilb_scene_stream_kind kind;
	uint32_t components; /* floats in the scene's vertex */
	uint32_t from;       /* bytes in the scene's vertex */
	uint32_t to;         /* bytes in the device's vertex, a multiple of 4 */
	bool octahedral;     /* 4 bytes; else `components` floats */
} render_attribute;

typedef struct render_layout {
	uint32_t count;      /* of streams, in the order of the table */
	uint32_t from, size; /* bytes of the scene's vertex and of the device's */
	render_attribute attributes[STILB_SCENE_MOST_STREAMS];
} render_layout;

/* [any-thread] */
render_layout render_layout_make(const stilb_scene_streams *table, bool packed);

/* Writes `count` vertices as the device has them. pairs: the second, fourth, ... are where the ones before them morph
 * to. A vector that is no direction becomes some direction. [any-thread] */
void render_vertices_pack(const render_layout *layout, const void *vertices, size_t count, bool pairs, void *out);

/* The inverse, but for what packing rounds; packing the result again gives the same bytes. [any-thread] */
void render_vertices_unpack(const render_layout *layout, const void *packed, size_t count, bool pairs, void *out);

/* A direction of any length in 32 bits, and back as a unit vector: see Packed. [any-thread] */
uint32_t render_direction_pack(const float n[3]);
void render_direction_unpack(uint32_t code, float n[3]);

#endif
