/*
 * gi_bsdf: light scattered by a surface, and the choice of its direction. One sampler serves every highlight whose lobe
 * is about the half vector (between the directions to the viewer and to the light): the normals of GGX's distribution
 * that the viewer sees, with the lobe's own alpha (roughness squared). Blinn's and Beckmann's distributions are at most
 * 4 / e times GGX's of the same alpha, and unlike their own samplers this one keeps weights bounded at grazing views.
 * Phong's lobes are about the mirrored direction and sampled there.
 */
#include "gi/sample/gi_bsdf.h"

#include "shading/shade_luminance.h"
#include "shading/shade_sampling.h"

static bool has_highlight(const shade_brdf_model *model)
{
	return model->kind != SHADE_BRDF_LAMBERT && model->kind != SHADE_BRDF_WRAPPED;
}

static bool is_phong(const gi_bsdf *bsdf)
{
	return bsdf->model.kind == SHADE_BRDF_PHONG || bsdf->model.kind == SHADE_BRDF_PHONG_MODIFIED;
}

static float exponent_of(const gi_bsdf *bsdf)
{
	return shade_exponent_about_r(shade_exponent_from_alpha(shade_alpha_from_roughness(bsdf->highlight.roughness)));
}

static shade_alphas alphas_of(const gi_bsdf *bsdf)
{
	float alpha = shade_alpha_from_roughness(bsdf->highlight.roughness);
	bool anisotropic = bsdf->model.kind == SHADE_BRDF_MICROFACET && bsdf->model.ndf == SHADE_NDF_GGX_ANISOTROPIC;
	shade_alphas alphas = shade_alphas_from_anisotropy(alpha, anisotropic ? bsdf->highlight.anisotropy : 0.0f);
	return (shade_alphas){fminf(alphas.x, 1.0f), fminf(alphas.y, 1.0f)};
}

/* ---- the highlight in the frame's coordinates -------------------------------------------------------------------- */

static shade_sample highlight_sample(const gi_bsdf *bsdf, stilb_vec2 u)
{
	return is_phong(bsdf) ? shade_sample_phong(exponent_of(bsdf), bsdf->local, u)
	                      : shade_sample_ggx_visible(alphas_of(bsdf), bsdf->local, u);
}

static float highlight_pdf(const gi_bsdf *bsdf, stilb_vec3 local)
{
	return is_phong(bsdf) ? shade_pdf_phong(exponent_of(bsdf), bsdf->local, local)
	                      : shade_pdf_ggx_visible(alphas_of(bsdf), bsdf->local, local);
}

/* ---- both -------------------------------------------------------------------------------------------------------- */

/* The probability of sampling the highlight: its share of the reflected light, by luminance, with the Fresnel term of a
 * half vector at the normal; kept between 0.1 and 0.9, since a rarely chosen lobe would give rare bright samples. */
static float highlight_share(const gi_bsdf *bsdf)
{
	int f = bsdf->model.kind == SHADE_BRDF_MICROFACET ? bsdf->model.f : SHADE_F_NONE;
	float diffuse = shade_luminance(bsdf->diffuse);
	float highlight = shade_luminance(shade_f(f, bsdf->highlight.specular, fminf(bsdf->local[2], 1.0f)));
	if (!(highlight > 0.0f) || bsdf->local[2] <= 0.0f)
		return 0.0f;
	return diffuse > 0.0f ? glsl_clamp_1(highlight / (diffuse + highlight), 0.1f, 0.9f) : 1.0f;
}

gi_bsdf gi_bsdf_make(const shade_brdf_model *model, const gi_surface *surface, stilb_vec3 to_viewer)
{
	STILB_ASSERT(model->kind >= 0 && model->kind < SHADE_BRDF_COUNT);
	stilb_vec3 n = surface->normal, specular = surface->specular;
	gi_bsdf bsdf; /* fields that a diffuse surface does not need are left uninitialised: this runs at every vertex */
	bsdf.geometric = surface->geometric;
	bsdf.diffuse = surface->diffuse;
	bsdf.share = 0.0f;
	if (!has_highlight(model) || !(specular[0] + specular[1] + specular[2] > 0.0f)) {
		bsdf.frame = shade_frame_from_normal(n);
		return bsdf;
	}
	/* The tangent is cross(up, n), as in the real-time renderer, so that anisotropic highlights look the same. */
	bsdf.frame = shade_frame_from_tangent(n, stilb_vec3_make(n[2], 0.0f, -n[0]));
	bsdf.to_viewer = to_viewer;
	bsdf.local = shade_frame_to_local(bsdf.frame, to_viewer);
	bsdf.model = *model;
	bsdf.highlight = (shade_brdf_parameters){
		.specular = specular, .roughness = surface->roughness, .anisotropy = surface->anisotropy};
	bsdf.share = highlight_share(&bsdf);
	return bsdf;
}

stilb_vec3 gi_bsdf_highlight_cos(const gi_bsdf *bsdf, stilb_vec3 direction)
{
	STILB_ASSERT(bsdf->share > 0.0f && bsdf->share <= 1.0f);
	return shade_lambert(bsdf->diffuse) * stilb_vec3_dot(bsdf->frame.n, direction) +
	       shade_brdf_cos(bsdf->model, bsdf->highlight, bsdf->frame, direction, bsdf->to_viewer);
}

static float mixed_pdf(const gi_bsdf *bsdf, stilb_vec3 local)
{
	return glsl_mix_1(shade_pdf_cosine(local), highlight_pdf(bsdf, local), bsdf->share);
}

float gi_bsdf_highlight_pdf(const gi_bsdf *bsdf, stilb_vec3 direction)
{
	STILB_ASSERT(bsdf->share > 0.0f && bsdf->share <= 1.0f);
	return mixed_pdf(bsdf, shade_frame_to_local(bsdf->frame, direction));
}

bool gi_bsdf_highlight_sample(const gi_bsdf *bsdf, float u_lobe, stilb_vec2 u, gi_bsdf_sample *chosen)
{
	STILB_ASSERT(bsdf->share > 0.0f && bsdf->share <= 1.0f);
	STILB_ASSERT(u_lobe >= 0.0f && u_lobe < 1.0f);
	shade_sample local = u_lobe < bsdf->share ? highlight_sample(bsdf, u) : shade_sample_cosine(u);
	chosen->direction = stilb_vec3_normalize(shade_frame_to_world(bsdf->frame, local.direction));
	chosen->pdf = mixed_pdf(bsdf, local.direction);
	if (!(chosen->pdf > 0.0f) || !gi_bsdf_sees(bsdf, chosen->direction))
		return false;
	chosen->weight = gi_bsdf_highlight_cos(bsdf, chosen->direction) / chosen->pdf;
	return true;
}
