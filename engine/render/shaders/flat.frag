#version 460
#ifdef FLAT_PICTURE
#extension GL_GOOGLE_include_directive : require
#include "../../shading/shade_tonemap.h"

layout(constant_id = 0) const bool tone_map = true;
layout(location = 3) flat in float factor; // of radiance before the tone map; 0: the texels are shown as they are
layout(location = 4) flat in int tone;
#endif

layout(location = 0) in vec4 light; // premultiplied
layout(location = 1) flat in vec4 clip; // left, top, right, bottom in pixels

#ifdef FLAT_TEXTURE
layout(location = 2) in vec2 surface_uv;
layout(set = 1, binding = 0) uniform sampler2D picture;
#endif

layout(location = 0) out vec4 color;

void main()
{
	if (any(lessThan(gl_FragCoord.xy, clip.xy)) || any(greaterThanEqual(gl_FragCoord.xy, clip.zw)))
		discard;
#ifdef FLAT_PICTURE
	ivec2 size = textureSize(picture, 0);
	vec3 texel = texelFetch(picture, clamp(ivec2(surface_uv * vec2(size)), ivec2(0), size - 1), 0).rgb;
	if (tone_map && factor > 0.0)
		texel = shade_tone(tone, texel * factor);
	color = vec4(texel, light.a); // alpha 1
#elif defined(FLAT_TEXTURE)
	vec4 texel = texture(picture, surface_uv);
	color = light * vec4(texel.rgb * texel.a, texel.a);
#else
	color = light;
#endif
}
