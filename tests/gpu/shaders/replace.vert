#version 460
/* A triangle over the area, or none of it; with an output, or an input that vertices do not have. */
#ifdef INPUT
layout(location = 5) in vec2 given;
#endif
#ifdef INTEGER
layout(location = 0) in ivec2 given;
#endif
#ifdef PLACE
layout(location = 2) out float place;
#endif
void main()
{
	vec2 uv = vec2(gl_VertexIndex & 2, (gl_VertexIndex << 1) & 2);
	gl_Position = vec4(uv * 2.0 - 1.0, 0.0, 1.0);
#if defined(INPUT) || defined(INTEGER)
	gl_Position.xy += vec2(given);
#endif
#ifdef PLACE
	place = 0.5;
#endif
}
