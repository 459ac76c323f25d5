// Changes one thing, which its first parameter names, for test_render_functions.c.
#include "shading/shade_srgb.h"

Surface surface_function(Surface surface, SurfacePoint point)
{
	int what = int(surface_parameter(0).x);
	vec4 value = surface_parameter(1);
	if (what == 1)
		surface.color = value.rgb;
	if (what == 2)
		surface.alpha = step(0.5, fract(value.x * point.uv.x + value.y * point.time));
	if (what == 3)
		surface.normal = value.xyz;
	if (what == 4)
		surface.emission = value.rgb;
	if (what == 5)
		surface.color = vec3(point.time, fract(point.time), 0.0);
	if (what == 6)
		surface.color = 0.5 + 0.25 * point.position;
	if (what == 7)
		surface.color = vec3(point.uv.x, point.uv.y, point.uv1.x);
	if (what == 8)
		surface.color = 0.5 + 0.25 * point.local;
	if (what == 9)
		surface = Surface(vec3(0.0 / value.x, value.y, -1.0), value.x / value.x, vec3(value.x / value.x),
			value.x / value.x, value.x / value.x, value.x / value.x, vec3(value.x / value.x), vec3(value.x / value.x));
	if (what == 10)
		surface.color = point.color.rgb * point.color.a;
	if (what == 11) {
		surface.metalness = value.x;
		surface.roughness = value.y;
		surface.occlusion = value.z;
	}
	if (what == 12)
		surface.color = vec3(shade_srgb_to_linear(value.x)) + surface_parameter(2).rgb + surface_parameter(3).rgb +
			surface_parameter(9).aaa;
	if (what == 13)
		surface.color = 0.5 + 0.5 * point.normal;
	if (what == 14)
		surface.color = 0.5 + 0.5 * surface.normal;
	if (what == 15)
		surface.color = point.front ? 0.5 + 0.5 * point.to_viewer : vec3(0.0);
	return surface;
}
