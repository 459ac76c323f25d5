#version 460
layout(set = 0, binding = 0) uniform sampler2D depth;
layout(location = 0) in vec2 uv;
layout(location = 0) out uint color;
void main()
{
	color = uint(texelFetch(depth, ivec2(gl_FragCoord.xy), 0).r * 256.0);
}
