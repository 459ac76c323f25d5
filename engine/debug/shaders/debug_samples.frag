#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#include "push.glsl"
#define RISE 1.0 // samples are up to that far from any point
#include "cover.glsl"

layout(constant_id = 0) const int samples = 4;
layout(set = 0, binding = 0) uniform sampler2DMS scene;

ivec2 scene_size()
{
	return textureSize(scene);
}

float scene_depth(ivec2 texel)
{
	return texelFetch(scene, clamp(texel, ivec2(0), scene_size() - 1), 0).r;
}

float scene_share(ivec2 texel, float depth)
{
	float count = 0.0;
	for (int s = 0; s < samples; s++)
		count += depth >= texelFetch(scene, texel, s).r ? 1.0 : 0.0;
	return count / float(samples);
}
