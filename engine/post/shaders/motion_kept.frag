#version 460
// Velocities as motion blur takes them: of this frame, or, while everything is paused, those that it had before.
layout(set = 0, binding = 0) uniform sampler2D velocity;
layout(location = 0) out vec2 kept;

void main()
{
	kept = texelFetch(velocity, ivec2(gl_FragCoord.xy), 0).rg;
}
