/*
 * scene_channel: what a picture can show of surfaces in the place of their light, to find faults of materials. Frames
 * and rays have the same channels, with the same values.
 *
 * Values.   Linear, as they are: no light, no exposure, no tone map. Directions are 0.5 + 0.5 n in world space, numbers
 *           grey, places on textures red and green. Where no surface is, and where a surface has no such thing (a
 *           tangent, a second uv), it is black. What blends counts as if it were opaque.
 * Display.  Colours and emission become sRGB codes, as light does, cut off at 1. Of data the code is the value: 0.5 is
 *           128. Counts have a colour each. Files of radiance (.exr, .hdr) hold the values.
 * Threads.  Constant. [any-thread]
 */
#ifndef STILB_SCENE_CHANNEL_H
#define STILB_SCENE_CHANNEL_H

#include "base/base.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* How values are shown on a display. */
typedef enum stilb_scene_channel_kind {
	STILB_SCENE_CHANNEL_LIGHT, /* as sRGB shows light */
	STILB_SCENE_CHANNEL_DATA,  /* the code is the value */
	STILB_SCENE_CHANNEL_COUNT, /* black, blue, green, yellow, red, white from 8 on */
} stilb_scene_channel_kind;

/* X(ENUM, identifier, words for users, kind). The order is known to shaders (render/shaders/channel.glsl). Of a
 * material without a surface (scene_surface.h) base colour and metalness are those that give its reflectances. */
#define STILB_SCENE_CHANNELS_OF_SURFACES(X)                                                                            \
	X(BASE, base, "base colour, or what an unlit surface shows", LIGHT)                                                \
	X(NORMAL, normal, "the normal that is lit, with its map, 0.5 + 0.5 n in world space", DATA)                        \
	X(TANGENT, tangent, "tangents of the vertices, 0.5 + 0.5 t in world space", DATA)                                  \
	X(ROUGHNESS, roughness, "0 is a mirror, 1 the widest highlight", DATA)                                             \
	X(METALNESS, metalness, "0 is a dielectric, 1 a metal", DATA)                                                      \
	X(OCCLUSION, occlusion, "the share of even light that its map lets through", DATA)                                 \
	X(EMISSION, emission, "radiance that surfaces emit", LIGHT)                                                        \
	X(ALPHA, alpha, "1 is opaque, 0 is not there", DATA)                                                               \
	X(UV0, uv0, "fractions of the first uv, u red and v green", DATA)                                                  \
	X(UV1, uv1, "fractions of the second uv, u red and v green", DATA)                                                 \
	X(WIREFRAME, wireframe, "edges of the triangles; frames alone", DATA)                                              \
	X(OVERDRAW, overdraw, "how often a pixel is drawn, 1 blue to 8 white; frames alone", COUNT)

#define STILB_SCENE_CHANNEL_ENUM(id, ...) STILB_SCENE_CHANNEL_##id,
typedef enum stilb_scene_surface_channel {
	STILB_SCENE_CHANNELS_OF_SURFACES(STILB_SCENE_CHANNEL_ENUM) STILB_SCENE_CHANNELS
} stilb_scene_surface_channel;
#undef STILB_SCENE_CHANNEL_ENUM

/* The channels from here on are of frames alone. */
#define STILB_SCENE_CHANNELS_OF_RAYS STILB_SCENE_CHANNEL_WIREFRAME

/* The identifiers by stilb_scene_surface_channel, NULL-terminated. */
extern const char *const stilb_scene_channel_names[];

stilb_scene_channel_kind stilb_scene_channel_kind_of(stilb_scene_surface_channel channel);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
