// What images hold of the surface that each pixel shows, for passes over the picture that light it: "normal", its shading
// normal, octahedral, anisotropy, wrap; "diffuse" and roughness; "specular" (device/render_images.h).
#include "../../shading/shade_impostor.h"

struct GbufferSurface {
	shade_material material; // as it stands, not as it is seen (shade_surface_seen)
	vec3 normal;             // unit
};

// What reflects nothing.
GbufferSurface gbuffer_none()
{
	return GbufferSurface(shade_material(vec3(0.0), vec3(0.0), 1.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0));
}

// Behind the radiance.
#define GBUFFER_OUTPUTS \
	layout(location = 1) out vec4 gbuffer_normal; \
	layout(location = 2) out vec4 gbuffer_diffuse; \
	layout(location = 3) out vec4 gbuffer_specular; \
	void gbuffer_write(GbufferSurface surface) \
	{ \
		shade_material m = surface.material; \
		vec2 place = shade_octahedral_from_direction(surface.normal); \
		gbuffer_normal = vec4(vec3(place, m.anisotropy) * 0.5 + 0.5, m.wrap); \
		gbuffer_diffuse = vec4(m.diffuse, m.roughness); \
		gbuffer_specular = vec4(m.specular, 1.0); \
	}

GbufferSurface gbuffer_surface(vec4 normal, vec4 diffuse, vec4 specular)
{
	vec3 place = normal.xyz * 2.0 - 1.0;
	return GbufferSurface(shade_material(diffuse.xyz, specular.xyz, diffuse.w, place.z, normal.w),
		shade_direction_from_octahedral(place.xy));
}
