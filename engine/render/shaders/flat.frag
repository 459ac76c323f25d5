#version 460

layout(location = 0) in vec4 light; // premultiplied
layout(location = 1) flat in vec4 clip; // left, top, right, bottom in pixels

#ifdef FLAT_TEXTURE
layout(location = 2) in vec2 surface_uv;
layout(set = 0, binding = 0) uniform sampler2D picture;
#endif

layout(location = 0) out vec4 color;

void main()
{
	if (any(lessThan(gl_FragCoord.xy, clip.xy)) || any(greaterThanEqual(gl_FragCoord.xy, clip.zw)))
		discard;
#ifdef FLAT_TEXTURE
	vec4 texel = texture(picture, surface_uv);
	color = light * vec4(texel.rgb * texel.a, texel.a);
#else
	color = light;
#endif
}
