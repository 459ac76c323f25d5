#version 460
#extension GL_EXT_buffer_reference : require
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform usampler2D image;
layout(buffer_reference, std430) buffer words { uint total; uint count; };
layout(push_constant) uniform constants { words result; };
void main()
{
	ivec2 at = ivec2(gl_GlobalInvocationID.xy);
	if (any(greaterThanEqual(at, textureSize(image, 0))))
		return;
	atomicAdd(result.total, texelFetch(image, at, 0).r);
	atomicAdd(result.count, 1u);
}
