#version 460
layout(push_constant) uniform constants { vec4 value; };
layout(location = 0) out vec4 color;
void main()
{
	color = value;
}
