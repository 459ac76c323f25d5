#include "scene/scene_streams.h"

static const stilb_scene_stream vertex_streams[STILB_SCENE_VERTEX_STREAMS] = {
	[STILB_SCENE_VERTEX_POSITION] =
		{
			.name = "position",
			.kind = STILB_SCENE_STREAM_POSITION,
			.components = 3,
			.offset = offsetof(stilb_scene_vertex, position),
			.packing = STILB_SCENE_STREAM_FLOATS,
		},
	[STILB_SCENE_VERTEX_NORMAL] =
		{
			.name = "normal",
			.kind = STILB_SCENE_STREAM_DIRECTION,
			.components = 3,
			.offset = offsetof(stilb_scene_vertex, normal),
			.weight = 0.15f,
			.packing = STILB_SCENE_STREAM_OCTAHEDRAL,
		},
	[STILB_SCENE_VERTEX_UV] =
		{
			.name = "uv",
			.kind = STILB_SCENE_STREAM_TEXTURE,
			.components = 2,
			.offset = offsetof(stilb_scene_vertex, uv),
			.weight = 0.1f,
			.seam = true,
			.packing = STILB_SCENE_STREAM_FLOATS,
		},
};

static_assert(sizeof(stilb_scene_vertex) == (3 + 3 + 2) * sizeof(float), "a row for each member");

const stilb_scene_streams stilb_scene_vertex_streams = {STILB_SCENE_VERTEX_STREAMS, sizeof(stilb_scene_vertex),
                                                        vertex_streams};
