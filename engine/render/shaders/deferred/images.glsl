// What surfaces make of the light that images have (apart.glsl). PREPASS: of one image, highlights in alpha, without
// colour. PRELIGHT: of two.
#ifdef LIT_GLOSS
#define LIGHT_BINDING 3
#else
#define LIGHT_BINDING 0
#endif

layout(set = 0, binding = LIGHT_BINDING) uniform sampler2D light_image;
layout(set = 0, binding = LIGHT_BINDING + 1) uniform sampler2D highlight_image; // of PREPASS the same

vec3 from_images(shade_material material, float n_dot_v)
{
	const bool prepass = (lights & 32768u) != 0; // RENDER_LIGHTS_GBUFFER8
	ivec2 at = ivec2(gl_FragCoord.xy);
	vec4 light = min(texelFetch(light_image, at, 0), 65504.0); // not infinite, which times black would be no number
	if (prepass)
		return material.diffuse * light.xyz + material.specular * light.w;
	// Fresnel's term at the viewer's angle in place of each light's own.
	vec3 fresnel = brdf == SHADE_BRDF_MICROFACET ? shade_f(f, material.specular, max(n_dot_v, 0.0)) : material.specular;
	return material.diffuse * light.xyz + fresnel * min(texelFetch(highlight_image, at, 0).xyz, 65504.0);
}
