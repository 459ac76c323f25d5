#version 460

#ifdef SCREEN_CLIP
layout(location = 0) out vec2 clip;
#endif

// One triangle that covers the picture.
void main()
{
	vec2 corner = vec2(gl_VertexIndex == 1 ? 3.0 : -1.0, gl_VertexIndex == 2 ? 3.0 : -1.0);
#ifdef SCREEN_CLIP
	clip = corner;
#endif
	gl_Position = vec4(corner, 0.0, 1.0);
}
