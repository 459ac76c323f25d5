#version 460
#extension GL_GOOGLE_include_directive : require
// The light of the view's lights on what the images of surfaces hold (gbuffer.glsl), added to the radiance.
// DEFERRED_APART: of PREPASS and PRELIGHT, on white surfaces: scattered light and highlights. LIT_TERMS: in place of
// light the shares of up to four lights that arrive, for the buffer of shadows.
#include "../mesh.glsl"

layout(set = 0, binding = 0) uniform sampler2D depth_image;
layout(set = 0, binding = 1) uniform sampler2D normal_image;
layout(location = 0) out vec4 color;
#ifdef DEFERRED_APART
#ifndef LIT_TERMS
layout(location = 1) out vec4 highlight; // of PRELIGHT
#endif
#define GBUFFER_SLIM
#define LIT_APART
#else
layout(set = 0, binding = 2) uniform sampler2D diffuse_image;
layout(set = 0, binding = 3) uniform sampler2D specular_image;
#endif

vec3 world_position;
const uint model_lights = 0u;

#define LIT_SURFACES
#include "../lit.glsl"
#include "place.glsl"

void main()
{
	ivec2 at = ivec2(gl_FragCoord.xy);
	float depth = texelFetch(depth_image, at, 0).x;
	if (depth == 0.0)
		discard;
	vec4 place = place_at(gl_FragCoord.xy, depth);
	if (place.w == 0.0) // the view's matrix has no inverse
		discard;
	world_position = place.xyz;
	vec4 normal = texelFetch(normal_image, at, 0);
	vec3 camera = push.view.camera_position.xyz;
	vec3 ray = world_position - camera, to_camera = -normalize(ray);
	if (gbuffer_narrow) // along the same ray, as far as the codes say
		world_position = camera + ray * (gbuffer_depth(normal.xy) * place.w);
	shade_brdf_model model = {brdf, ndf, g, f};
#ifdef DEFERRED_APART
	GbufferSurface surface = gbuffer_of_slim(normal, gbuffer_ahead(world_position));
	receives = surface.receives;
#else
	vec4 diffuse = texelFetch(diffuse_image, at, 0), specular = texelFetch(specular_image, at, 0);
	GbufferSurface surface = gbuffer_surface(normal, diffuse, specular, gbuffer_ahead(world_position));
	receives = surface.receives;
#endif
#ifdef LIT_TERMS
	terms_write(frame_here(surface.normal).n);
	color = terms_color();
#elif defined(DEFERRED_APART)
	vec3 scattered = from_lights(model, surface.material, frame_here(surface.normal), to_camera);
	color = vec4(scattered, gbuffer_narrow ? shade_luminance(highlights) : 0.0);
	highlight = vec4(highlights, 0.0);
#else
	shade_material material = shade_surface_seen(model, surface.material, dot(surface.normal, to_camera));
	color = vec4(from_lights(model, material, frame_here(surface.normal), to_camera), 0.0);
#endif
	if (lights_counted)
		color = counted_color();
}
