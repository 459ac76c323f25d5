#version 460
// What a surface sends on of the surroundings' light, which is in two images, added to the radiance of all other light.
layout(set = 0, binding = 0) uniform sampler2D ambient;
layout(set = 0, binding = 1) uniform sampler2D reflection;
layout(location = 0) out vec4 color;

void main()
{
	ivec2 at = ivec2(gl_FragCoord.xy);
	color = vec4(texelFetch(ambient, at, 0).xyz + texelFetch(reflection, at, 0).xyz, 0.0);
}
