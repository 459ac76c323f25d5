// What a pixel shows in the place of light: programs with MESH_CHANNEL. Who includes it has included lit.glsl. Rays
// have the same in gi/integrate/gi_channel.c.
#include "../../shading/shade_gltf.h"

// In the order of STILB_SCENE_CHANNELS_OF_SURFACES of scene_channel.h, from 1 on.
#define CHANNEL_BASE 1u
#define CHANNEL_NORMAL 2u
#define CHANNEL_TANGENT 3u
#define CHANNEL_ROUGHNESS 4u
#define CHANNEL_METALNESS 5u
#define CHANNEL_OCCLUSION 6u
#define CHANNEL_EMISSION 7u
#define CHANNEL_ALPHA 8u
#define CHANNEL_UV0 9u
#define CHANNEL_UV1 10u
#define CHANNEL_WIREFRAME 11u
#define CHANNEL_OVERDRAW 12u
const uint channel = lights >> 25 & 15u; // RENDER_LIGHTS_CHANNEL_SHIFT

// What a surface is made of. What it has not is 0, but for occlusion and alpha, which are 1.
struct Channels {
	vec3 base, normal, tangent, emission; // normal and tangent: unit, or 0
	float roughness, metalness, occlusion, alpha;
	vec4 uv; // both
};

// Of a material without a surface: of a mesh or an impostor.
Channels channels_of(shade_material material, vec3 emission, vec3 n, vec4 uv)
{
	shade_gltf_color found = shade_gltf_unmixed(material.diffuse, material.specular);
	return Channels(found.color, n, vec3(0.0), emission, material.roughness, found.metalness, 1.0, 1.0, uv);
}

vec3 channel_direction(vec3 direction)
{
	return dot(direction, direction) > 0.0 ? 0.5 + 0.5 * direction : vec3(0.0);
}

vec3 channel_value(Channels c)
{
	if (channel == CHANNEL_BASE)
		return c.base;
	if (channel == CHANNEL_NORMAL)
		return channel_direction(c.normal);
	if (channel == CHANNEL_TANGENT)
		return channel_direction(c.tangent);
	if (channel == CHANNEL_ROUGHNESS)
		return vec3(c.roughness);
	if (channel == CHANNEL_METALNESS)
		return vec3(c.metalness);
	if (channel == CHANNEL_OCCLUSION)
		return vec3(c.occlusion);
	if (channel == CHANNEL_EMISSION)
		return c.emission;
	if (channel == CHANNEL_ALPHA)
		return vec3(c.alpha);
	if (channel == CHANNEL_UV0)
		return vec3(fract(c.uv.xy), 0.0);
	if (channel == CHANNEL_UV1)
		return vec3(fract(c.uv.zw), 0.0);
	return vec3(1.0); // an edge, or once more drawn
}

// The draw's pixel. material: its index. Alpha is not added up where pixels are counted.
vec4 channel_color(Channels c, uint material)
{
	vec4 color = picture_color(channel_value(c), material);
	return channel == CHANNEL_OVERDRAW ? vec4(color.xyz, 0.0) : color;
}
