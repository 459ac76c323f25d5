#version 460
layout(location = 0) in flat uint layer;
layout(location = 0) out uint color;
void main()
{
	color = 100u + layer;
}
