#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#include "push.glsl"
#define RISE 0.5 // from the middle to an edge
#include "cover.glsl"

layout(set = 0, binding = 0) uniform sampler2D scene;

ivec2 scene_size()
{
	return textureSize(scene, 0);
}

float scene_depth(ivec2 texel)
{
	return texelFetch(scene, clamp(texel, ivec2(0), scene_size() - 1), 0).r;
}

float scene_share(ivec2 texel, float depth)
{
	return depth >= scene_depth(texel) ? 1.0 : 0.0;
}
