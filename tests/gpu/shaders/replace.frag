#version 460
/* One value over the whole area; the definitions make it another shader, or one that does not fit. */
#ifndef VALUE
#define VALUE 0.25
#endif
layout(constant_id = 3) const float scale = 1.0;
#ifdef WIDE
layout(constant_id = 4) const double wide = 1.0;
#endif
#ifdef BINDING
layout(set = 0, binding = 0) uniform sampler2D image;
#endif
#ifdef PLACE
layout(location = 2) in float place;
#endif
#ifdef PUSH
layout(push_constant) uniform constants { vec4 first[8]; float behind; };
#endif
layout(location = 0) out vec4 color;
void main()
{
	float value = VALUE * scale;
#ifdef WIDE
	value += float(wide);
#endif
#ifdef BINDING
	value += texelFetch(image, ivec2(0), 0).r;
#endif
#ifdef PLACE
	value += place;
#endif
#ifdef PUSH
	value += behind;
#endif
	color = vec4(value);
}
