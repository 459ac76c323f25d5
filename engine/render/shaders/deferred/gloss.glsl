// Which lights send so little to a tile that they can be left out: those whose scattered light and whose highlight are
// both below a share of the tolerance. A highlight may be bright far beyond that, but only where lights lie in the cone
// about the mirrored view; the cones of a tile's pixels are joined. Source: Karis, "Tiled Light Culling" (2012).
#include "../../../shading/shade_brdf.h"
#include "../../../shading/shade_light_cone.h"

layout(constant_id = 2) const int brdf = SHADE_BRDF_BLINN_PHONG_MODIFIED;
layout(constant_id = 3) const int ndf = SHADE_NDF_GGX;
layout(constant_id = 4) const int g = SHADE_G_SMITH_GGX;
layout(constant_id = 5) const int f = SHADE_F_SCHLICK;

// Of an irradiance of 1, sr^-1: the scattered light, and a highlight outside of the cone, are each at most this; within
// the cone a highlight is at most `peak`.
const float GLOSS_SCATTERED = SHADE_INV_PI;

struct Gloss {
	shade_cone cone;
	float peak;
};

shared vec4 gloss_cones[64]; // axis, chord
shared float gloss_peaks[64];

// The cone of lights whose highlight exceeds GLOSS_SCATTERED; of models that have none, every direction.
shade_cone gloss_cone(vec3 n, vec3 v, float roughness)
{
	float alpha = shade_alpha_from_roughness(roughness), exponent = shade_exponent_from_alpha(alpha);
	bool smith = g == SHADE_G_SMITH_GGX || g == SHADE_G_IMPLICIT || g == SHADE_G_NEUMANN;
	if (brdf == SHADE_BRDF_LAMBERT || brdf == SHADE_BRDF_WRAPPED)
		return shade_cone(n, -1.0);
	if (brdf == SHADE_BRDF_BLINN_PHONG || brdf == SHADE_BRDF_BLINN_PHONG_MODIFIED)
		return shade_cone_blinn_phong(n, v, exponent, GLOSS_SCATTERED);
	if (brdf == SHADE_BRDF_PHONG || brdf == SHADE_BRDF_PHONG_MODIFIED)
		return shade_cone_phong(n, v, shade_exponent_about_r(exponent), GLOSS_SCATTERED);
	if (brdf == SHADE_BRDF_MICROFACET && ndf == SHADE_NDF_GGX && smith)
		return shade_cone_ggx(n, v, alpha, GLOSS_SCATTERED);
	return shade_cone(n, 2.0);
}

Gloss gloss_of_tile(uint self, uvec2 first, uint side)
{
	shade_brdf_model model = {brdf, ndf, g, f};
	shade_cone cone = shade_cone(vec3(0.0, 1.0, 0.0), -1.0);
	float peak = 0.0;
	ivec2 size = textureSize(depth_image, 0);
	for (uint i = self; i < side * side; i += 64u) {
		ivec2 at = ivec2(first + uvec2(i % side, i / side));
		float depth = all(lessThan(at, size)) ? texelFetch(depth_image, at, 0).x : 0.0;
		vec4 place = depth > 0.0 ? place_at(vec2(at) + 0.5, depth) : vec4(0.0);
		if (place.w == 0.0)
			continue;
		vec3 ahead = gbuffer_ahead(place.xyz);
		GbufferSurface surface =
			gbuffer_surface(texelFetch(normal_image, at, 0), texelFetch(diffuse_image, at, 0), vec4(0.0), ahead);
		vec3 v = normalize(push.view.camera_position.xyz - place.xyz);
		float roughness = surface.material.roughness;
		shade_cone own = gloss_cone(surface.normal, v, roughness);
		cone = cone.chord < 0.0 ? own : shade_cone_union(cone, own);
		peak = max(peak, shade_brdf_peak(model, roughness, surface.material.anisotropy));
	}
	gloss_cones[self] = vec4(cone.axis, cone.chord);
	gloss_peaks[self] = peak;
	for (uint count = 32u; count > 0u; count /= 2u) {
		barrier();
		if (self < count) {
			vec4 one = gloss_cones[self], other = gloss_cones[self + count];
			shade_cone both = shade_cone_union(shade_cone(one.xyz, one.w), shade_cone(other.xyz, other.w));
			gloss_cones[self] = vec4(both.axis, both.chord);
			gloss_peaks[self] = max(gloss_peaks[self], gloss_peaks[self + count]);
		}
	}
	barrier();
	return Gloss(shade_cone(gloss_cones[0].xyz, gloss_cones[0].w), gloss_peaks[0]);
}

// False: the light sends at most `most` to any point of the box.
bool gloss_counts(uint index, Gloss gloss, vec3 low, vec3 high, float most)
{
	vec4 position_kind = push.view.lights.lights[index].position_kind;
	vec4 intensity_inner = push.view.lights.lights[index].intensity_inner;
	Reach reach = reach_of(index);
	vec3 away = max(max(low - reach.center, reach.center - high), 0.0);
	float square = dot(away, away);
	if (reach.size > 0.0 || square <= 0.0)
		return true;
	vec3 intensity = intensity_inner.xyz;
	float irradiance = max(intensity.x, max(intensity.y, intensity.z)) / square *
		shade_falloff_share(int(position_kind.w) >> 3 & 3, square, 0.0, reach.radius);
	if (irradiance * 2.0 * GLOSS_SCATTERED > most)
		return true;
	vec3 toward = reach.center - 0.5 * (low + high);
	float around = 0.5 * length(high - low), apart = length(toward);
	if (apart <= around)
		return true;
	float angle = acos(clamp(dot(toward, gloss.cone.axis) / apart, -1.0, 1.0));
	bool mirrored = gloss.cone.chord >= 0.0 &&
		angle <= shade_cone_half_angle(gloss.cone) + asin(around / apart) + REACH_ROUNDING;
	return mirrored && irradiance * (GLOSS_SCATTERED + gloss.peak) > most;
}
