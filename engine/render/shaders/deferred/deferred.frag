#version 460
#extension GL_GOOGLE_include_directive : require
// The light of the view's lights on what the images of surfaces hold (gbuffer.glsl), added to the radiance.
#include "../mesh.glsl"

layout(set = 0, binding = 0) uniform sampler2D depth_image;
layout(set = 0, binding = 1) uniform sampler2D normal_image;
layout(set = 0, binding = 2) uniform sampler2D diffuse_image;
layout(set = 0, binding = 3) uniform sampler2D specular_image;

layout(location = 0) out vec4 color;

vec3 world_position;

#include "../lit.glsl"
#include "gbuffer.glsl"

void main()
{
	ivec2 at = ivec2(gl_FragCoord.xy);
	float depth = texelFetch(depth_image, at, 0).x;
	if (depth == 0.0)
		discard;
	vec2 size = 2.0 * vec2(push.view.rest.half_width, push.view.rest.half_height);
	vec4 place = push.view.rest.from_clip * vec4(gl_FragCoord.xy / size * 2.0 - 1.0, depth, 1.0);
	if (place.w == 0.0) // the view's matrix has no inverse
		discard;
	world_position = place.xyz / place.w;
	vec4 normal = texelFetch(normal_image, at, 0);
	vec3 camera = push.view.camera_position.xyz;
	vec3 ray = world_position - camera, to_camera = -normalize(ray);
	if (gbuffer_narrow) // along the same ray, as far as the codes say
		world_position = camera + ray * (gbuffer_depth(normal.xy) * place.w);
	vec4 diffuse = texelFetch(diffuse_image, at, 0), specular = texelFetch(specular_image, at, 0);
	GbufferSurface surface = gbuffer_surface(normal, diffuse, specular, gbuffer_ahead(world_position));
	shade_brdf_model model = {brdf, ndf, g, f};
	shade_material material = shade_surface_seen(model, surface.material, dot(surface.normal, to_camera));
	color = vec4(from_lights(model, material, frame_here(surface.normal), to_camera), 0.0);
}
