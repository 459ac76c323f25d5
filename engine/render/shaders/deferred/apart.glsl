// What PREPASS and PRELIGHT keep of lights, apart from surfaces' colours: light that a white surface scatters, and
// highlights of a white one without Fresnel's term.

// The highlights that all lights so far have.
vec3 highlights = vec3(0.0);

// Returns the scattered light, and adds to the highlights. In 8 bits there is no roughness: highlights are Phong's of
// one roughness (Engel, "Light Pre-Pass Renderer", 2008).
vec3 light_apart(shade_material material, shade_frame frame, shade_sun seen, bool sized, vec3 spread, vec3 v)
{
	const float PREPASS_ROUGHNESS = 0.4; // as STILB_RENDER_PREPASS_ROUGHNESS
	shade_brdf_model shiny = {brdf, ndf, g, SHADE_F_NONE};
	shade_brdf_model matt = {brdf == SHADE_BRDF_LAMBERT ? SHADE_BRDF_LAMBERT : SHADE_BRDF_WRAPPED, 0, 0, 0};
	if (gbuffer_narrow) {
		if (brdf != SHADE_BRDF_LAMBERT && brdf != SHADE_BRDF_WRAPPED)
			shiny.kind = SHADE_BRDF_PHONG_MODIFIED;
		material.roughness = PREPASS_ROUGHNESS;
	}
	highlights += shade_surface_highlight_cos(shiny, material, frame, seen.direction, v) * seen.irradiance;
	return shade_surface_lit(matt, material, frame, seen, sized, spread, v);
}
