#version 460
layout(location = 0) in vec2 position;
layout(location = 1) in float depth;
void main()
{
	gl_Position = vec4(position, depth, 1.0);
}
