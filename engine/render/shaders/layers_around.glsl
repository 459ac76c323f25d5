// The light of lights and surroundings on a surface with layers. Inside of lit.glsl.

// Sky and ground, or the panorama, as a highlight of that roughness mirrors them, of which it loses nothing.
vec3 around_mirrored(float roughness, vec3 n, vec3 v)
{
#ifdef LIT_GLOSS
	vec2 dfg = gloss_shares(n, v, roughness);
	return gloss_mirrored(n, v, roughness) * (dfg.x + dfg.y);
#else
	return lights_gloss && !lights_panorama ? sky_mirrored(reflect(-v, n), roughness) : vec3(0.0);
#endif
}

#ifdef LIT_GLOSS
// The panorama as brushed metal mirrors it: the mean of BRUSHED highlights, at least of the roughness across the brush
// and wide enough to leave no gaps, whose normals are tilted along it. The tilts' slopes are those of GGX: the share of
// facets below u times the width is (1 + u / sqrt(1 + u u)) / 2, of which these are the middles of equal parts.
vec3 panorama_brushed(shade_material material, shade_frame frame, vec3 v)
{
	const int BRUSHED = 11;
	shade_alphas alphas =
		shade_alphas_from_anisotropy(shade_alpha_from_roughness(material.roughness), material.anisotropy);
	float width = sqrt(max(alphas.x * alphas.x - alphas.y * alphas.y, 0.0));
	float across = sqrt(max(alphas.y, 0.1 * width));
	vec3 light = vec3(0.0);
	float weights = 0.0;
	for (int i = 0; i < BRUSHED; i++) {
		float q = (2.0 * float(i) + 1.0) / float(BRUSHED) - 1.0;
		vec3 n = normalize(frame.n + frame.t * (width * q * inversesqrt(1.0 - q * q)));
		vec3 toward = reflect(-v, n);
		float weight = max(dot(toward, frame.n), 0.0) * step(0.0, dot(n, v));
		light += weight * gloss_light(shade_environment_direction(n, v, across), across);
		weights += weight;
	}
	return light * gloss_reflectance(material, gloss_shares(frame.n, v, material.roughness)) / max(weights, 1e-4);
}
#endif

// The base's highlight of the surroundings. material, frame: brushed or not.
vec3 around_highlight(shade_material material, bool brushed, shade_frame frame, vec3 v)
{
#ifdef LIT_GLOSS
	if (is_brushed && brushed)
		return panorama_brushed(material, frame, v);
	return panorama_highlight(material, frame.n, v);
#else
	bool mirrors = lights_gloss && !lights_panorama && brdf != SHADE_BRDF_LAMBERT && brdf != SHADE_BRDF_WRAPPED;
	return mirrors ? sky_highlight(material, frame.n, v) : vec3(0.0);
#endif
}

#ifdef LIT_THROUGH
#include "through.glsl"
#endif

// As lit_radiance_open, with `layers`.
vec3 layered_radiance(shade_material material, vec3 emission, float open, vec3 n, vec3 v)
{
	shade_brdf_model model = {brdf, ndf, g, f};
	shade_frame frame = frame_here(n);
	material = shade_surface_seen(model, material, dot(n, v));
	if (lets_through)
		material.diffuse *= 1.0 - layers.transmission;
	layers.roughness = material.roughness;
	bool brushes = is_brushed && brdf == SHADE_BRDF_MICROFACET && ndf == SHADE_NDF_GGX && layers.brushed > 0.0;
	if (brushes) {
		vec2 brushed = shade_gltf_brushed(material.roughness, layers.brushed);
		model.ndf = SHADE_NDF_GGX_ANISOTROPIC;
		material.roughness = brushed.x;
		material.anisotropy = brushed.y;
		frame = shade_frame_from_tangent(n, layers.along);
	}
	vec3 lights_sent = from_lights(model, material, frame, v);
	vec3 around = material.diffuse * own_even_radiance(vec3(1.0), n) * open;
	around += around_highlight(material, brushes, frame, v);
	around += material.diffuse * from_others(n);
#ifdef LIT_THROUGH
	around += seen_through(material, n, v);
#endif
	if (has_sheen) {
		float albedo = shade_sheen_albedo(dot(n, v), layers.sheen_roughness);
		vec3 toward = shade_sheen_direction(n, v, layers.sheen_roughness);
		around = around * sheen_left(n, v) + layers.sheen * albedo * even_radiance(vec3(1.0), toward) * open;
	}
	around += emission;
	if (has_coat) {
		float share = coat_share(v);
		around = around * (1.0 - share) + share * around_mirrored(layers.coat_roughness, layers.coat_n, v);
	}
	return lights_sent + around;
}
