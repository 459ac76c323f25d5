/* What a pass of random plans makes of its inputs; gpu_mix.c does the same on the CPU. */
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#include "mix.glsl"
layout(set = 0, binding = 0) uniform usampler2D flat_image;
layout(set = 0, binding = 1) uniform sampler2D color_image;
layout(set = 0, binding = 2) uniform usampler2DArray array_image;
layout(set = 0, binding = 3) uniform usamplerCube cube_image;
layout(set = 0, binding = 4) uniform sampler2DMS samples_image;
layout(buffer_reference, std430) buffer words { uint word[64]; };
layout(push_constant) uniform constants { words from; words to; uint number; };

uint packed_bytes(vec4 color)
{
	uvec4 bytes = uvec4(round(color * 255.0));
	return bytes.r | bytes.g << 8 | bytes.b << 16 | bytes.a << 24;
}

vec4 unpacked_bytes(uint value)
{
	return vec4(uvec4(value, value >> 8, value >> 16, value >> 24) & 255u) / 255.0;
}

uint mix_inputs(ivec2 at, uint layer)
{
	uint hash = mix_step(number, uint(at.x + 97 * at.y) + 8191u * layer);
	hash = mix_step(hash, texelFetch(flat_image, min(at, textureSize(flat_image, 0) - 1), 0).r);
	hash = mix_step(hash, packed_bytes(texelFetch(color_image, min(at, textureSize(color_image, 0) - 1), 0)));
	int mip = textureQueryLevels(array_image) - 1;
	ivec3 size = textureSize(array_image, mip);
	for (int i = 0; i < size.z; i++)
		hash = mix_step(hash, texelFetch(array_image, ivec3(min(at, size.xy - 1), i), mip).r);
	float last = float(textureQueryLevels(cube_image) - 1);
	vec3 direction = vec3(0.13, 0.23, 0.13);
	direction[number % 3u] = number % 6u < 3u ? 1.0 : -1.0;
	hash = mix_step(hash, textureLod(cube_image, direction, last).r);
	ivec2 most = textureSize(samples_image) - 1;
	hash = mix_step(hash, packed_bytes(texelFetch(samples_image, min(at, most), int(number % 4u))));
	return mix_step(hash, from.word[(at.x + 97 * at.y) % 64]);
}
