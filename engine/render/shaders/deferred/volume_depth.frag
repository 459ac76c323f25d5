#version 460
// The depth of what is seen, for an attachment that also has a stencil.
layout(set = 0, binding = 0) uniform sampler2D depth_image;

void main()
{
	gl_FragDepth = texelFetch(depth_image, ivec2(gl_FragCoord.xy), 0).x;
}
