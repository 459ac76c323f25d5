/*
 * gi_bsdf: light scattered by a surface, and the choice of its direction. One sampler serves every highlight whose lobe
 * is about the half vector (between the directions to the viewer and to the light): the normals of GGX's distribution
 * that the viewer sees, with the lobe's own alpha (roughness squared). Blinn's and Beckmann's distributions are at most
 * 4 / e times GGX's of the same alpha, and unlike their own samplers this one keeps weights bounded at grazing views.
 * Phong's lobes are about the mirrored direction and sampled there.
 */
#include "gi/sample/gi_bsdf.h"

#include "gi/gi_vector.h"
#include "gi/sample/gi_glass.h"
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

/* ---- layers ------------------------------------------------------------------------------------------------------ */

/* What may be reflected by a lobe is chosen at least so often: a rarely chosen lobe would give rare bright samples. */
#define LOBE_LEAST 0.1f

static bool shows_highlight(const gi_bsdf *bsdf)
{
	stilb_vec3 specular = bsdf->highlight.specular;
	return has_highlight(&bsdf->model) && specular[0] + specular[1] + specular[2] > 0.0f;
}

static stilb_vec3 surface_f(const gi_bsdf *bsdf, float v_dot_h)
{
	int f = bsdf->model.kind == SHADE_BRDF_MICROFACET ? bsdf->model.f : SHADE_F_NONE;
	return shade_f(f, bsdf->highlight.specular, fminf(v_dot_h, 1.0f));
}

/* Reflectance of a facet; of a volume the angle in the thinner medium counts. */
static stilb_vec3 facet_f(const gi_bsdf *bsdf, float v_dot_h)
{
	return surface_f(bsdf, gi_glass_thin_side(bsdf->layers->lobes.eta, v_dot_h));
}

/* Probabilities of lobes: the share of an even light that each sends to the viewer, about, but none too small. */
static void lobes_choose(gi_lobes *lobes)
{
	float *each[] = {&lobes->coat, &lobes->sheen, &lobes->diffuse, &lobes->highlight, &lobes->through};
	float sum = 0.0f, all = 0.0f;
	for (size_t i = 0; i < sizeof each / sizeof *each; i++)
		sum += *each[i];
	for (size_t i = 0; i < sizeof each / sizeof *each; i++) {
		*each[i] = *each[i] > 0.0f ? fmaxf(*each[i], LOBE_LEAST * sum) : 0.0f;
		all += *each[i];
	}
	for (size_t i = 0; i < sizeof each / sizeof *each; i++)
		*each[i] *= all > 0.0f ? 1.0f / all : 0.0f;
}

/* Share of light that facets let through, about: those of rough glass also where a smooth one would reflect all. */
static float through_left(const gi_bsdf *bsdf)
{
	float left =
		shade_facet_left(bsdf->highlight.specular, gi_glass_thin_side(bsdf->layers->lobes.eta, bsdf->local[2]));
	return bsdf->layers->roughness > GI_PANE_ROUGHNESS ? fmaxf(left, LOBE_LEAST) : left;
}

static void lobes_make(const gi_bsdf *bsdf, gi_surface *surface)
{
	const gi_layers *layers = &surface->layers;
	gi_lobes *lobes = &surface->layers.lobes;
	float n_dot_v = bsdf->local[2], coat_n_dot_v = stilb_vec3_dot(layers->coat_normal, bsdf->to_viewer);
	bool inside = layers->solid && !surface->front;
	*lobes = (gi_lobes){.coat_share = shade_coat_share(layers->coat, coat_n_dot_v),
	                    .sheen_left = shade_sheen_left(layers->sheen, n_dot_v, layers->sheen_roughness),
	                    .eta = !layers->solid ? 1.0f
	                           : inside       ? layers->ior
	                                          : 1.0f / layers->ior,
	                    .beyond = gi_surface_ray_origin(surface, -surface->geometric)};
	float below = 1.0f - lobes->coat_share, base = below * lobes->sheen_left;
	lobes->coat = lobes->coat_share;
	lobes->sheen = below * shade_luminance(layers->sheen) * shade_sheen_albedo(n_dot_v, layers->sheen_roughness);
	lobes->diffuse = base * shade_luminance(bsdf->diffuse);
	lobes->highlight = shows_highlight(bsdf) ? base * shade_luminance(facet_f(bsdf, n_dot_v)) : 0.0f;
	if (layers->pass == 0.0f && n_dot_v > 0.0f)
		lobes->through = base * shade_luminance(layers->through) * through_left(bsdf);
	lobes_choose(lobes);
	lobes->ask_beyond = lobes->through > 0.0f && !layers->solid ? glsl_clamp_1(lobes->through, 0.1f, 0.9f) : 0.0f;
	lobes->ask = inside ? 0.0f : 1.0f - lobes->ask_beyond;
}

static __attribute__((noinline)) void layered_make(const shade_brdf_model *model, gi_surface *surface,
                                                   stilb_vec3 to_viewer, gi_bsdf *out)
{
	stilb_vec3 n = surface->normal, tangent = stilb_vec3_make(n[2], 0.0f, -n[0]);
	const gi_layers *layers = &surface->layers;
	gi_bsdf bsdf = {.geometric = surface->geometric,
	                .to_viewer = to_viewer,
	                .diffuse = surface->diffuse,
	                .model = *model,
	                .highlight = {.specular = surface->specular, .roughness = surface->roughness},
	                .share = 1.0f,
	                .layers = layers};
	if (layers->anisotropy > 0.0f && model->kind == SHADE_BRDF_MICROFACET && model->ndf == SHADE_NDF_GGX) {
		stilb_vec2 brushed = shade_gltf_brushed(surface->roughness, layers->anisotropy);
		bsdf.model.ndf = SHADE_NDF_GGX_ANISOTROPIC;
		bsdf.highlight.roughness = brushed[0];
		bsdf.highlight.anisotropy = brushed[1];
		tangent = layers->brushed;
	}
	bsdf.frame = shade_frame_from_tangent(n, tangent);
	bsdf.local = shade_frame_to_local(bsdf.frame, to_viewer);
	if (shows_highlight(&bsdf))
		bsdf.diffuse *= shade_brdf_diffuse_left(*model, bsdf.local[2], surface->roughness);
	lobes_make(&bsdf, surface);
	*out = bsdf;
}

/* The highlight; inside of a volume, where its model's own F would take the angle there, by facet_f. */
static stilb_vec3 layered_highlight(const gi_bsdf *bsdf, stilb_vec3 l)
{
	if (!(bsdf->layers->lobes.eta > 1.0f))
		return shade_brdf_cos(bsdf->model, bsdf->highlight, bsdf->frame, l, bsdf->to_viewer);
	shade_brdf_model model = bsdf->model;
	shade_brdf_parameters white = bsdf->highlight;
	model.f = SHADE_F_NONE;
	white.specular = stilb_vec3_make(1.0f, 1.0f, 1.0f);
	return shade_brdf_cos(model, white, bsdf->frame, l, bsdf->to_viewer) *
	       facet_f(bsdf, 0.5f * gi_length(l + bsdf->to_viewer));
}

static shade_alphas through_alphas(const gi_bsdf *bsdf)
{
	float alpha = shade_alpha_from_roughness(bsdf->layers->roughness);
	return (shade_alphas){alpha, alpha};
}

/* Light from beyond. */
static stilb_vec3 through_cos(const gi_bsdf *bsdf, stilb_vec3 l)
{
	const gi_lobes *lobes = &bsdf->layers->lobes;
	stilb_vec3 f0 = bsdf->highlight.specular, v = bsdf->local, n = bsdf->frame.n;
	float share = lobes->sheen_left * (1.0f - lobes->coat_share), lit;
	if (!(lobes->through > 0.0f) || !(stilb_vec3_dot(n, l) < 0.0f))
		return (stilb_vec3){0};
	if (bsdf->layers->solid) {
		stilb_vec3 local = shade_frame_to_local(bsdf->frame, l);
		shade_alphas alphas = through_alphas(bsdf);
		float v_dot_h = stilb_vec3_dot(v, gi_glass_facet(lobes->eta, v, local));
		lit = gi_glass_pdf(lobes->eta, alphas, v, local) * gi_glass_share(lobes->eta, f0, alphas.x, v_dot_h, local[2]);
	} else {
		lit = shade_thin_cos(f0, bsdf->layers->roughness, n, l, bsdf->to_viewer);
	}
	return bsdf->layers->through * (share * lit);
}

static __attribute__((noinline)) stilb_vec3 layered_cos(const gi_bsdf *bsdf, stilb_vec3 l)
{
	const gi_layers *layers = bsdf->layers;
	const gi_lobes *lobes = &bsdf->layers->lobes;
	stilb_vec3 n = bsdf->frame.n, v = bsdf->to_viewer, light = {0};
	float n_dot_l = stilb_vec3_dot(n, l);
	if (stilb_vec3_dot(bsdf->geometric, l) <= 0.0f)
		return through_cos(bsdf, l);
	if (n_dot_l > 0.0f) {
		stilb_vec3 base = shade_lambert(bsdf->diffuse) * n_dot_l;
		if (shows_highlight(bsdf))
			base += layered_highlight(bsdf, l);
		light = base * lobes->sheen_left;
		if (lobes->sheen > 0.0f)
			light += layers->sheen * shade_sheen_cos(layers->sheen_roughness, n, l, v);
	}
	light *= 1.0f - lobes->coat_share;
	if (lobes->coat > 0.0f)
		light += lobes->coat_share * shade_coat_cos(layers->coat_roughness, layers->coat_normal, l, v);
	return light * (1.0f / (1.0f - layers->pass));
}

static shade_alphas coat_alphas(const gi_bsdf *bsdf)
{
	float alpha = shade_alpha_from_roughness(bsdf->layers->coat_roughness);
	return (shade_alphas){alpha, alpha};
}

/* Density of what goes through. */
static float through_pdf(const gi_bsdf *bsdf, stilb_vec3 local)
{
	if (bsdf->layers->solid)
		return gi_glass_pdf(bsdf->layers->lobes.eta, through_alphas(bsdf), bsdf->local, local);
	return shade_pdf_ggx_visible(through_alphas(bsdf), bsdf->local, stilb_vec3_make(local[0], local[1], -local[2]));
}

static __attribute__((noinline)) float layered_pdf(const gi_bsdf *bsdf, stilb_vec3 l)
{
	const gi_lobes *lobes = &bsdf->layers->lobes;
	stilb_vec3 local = shade_frame_to_local(bsdf->frame, l);
	if (bsdf->layers->solid && stilb_vec3_dot(bsdf->geometric, l) < 0.0f)
		return lobes->through * through_pdf(bsdf, local);
	float pdf = lobes->diffuse * shade_pdf_cosine(local) + lobes->sheen * shade_pdf_hemisphere(local);
	if (lobes->highlight > 0.0f)
		pdf += lobes->highlight * highlight_pdf(bsdf, local);
	if (lobes->through > 0.0f)
		pdf += lobes->through * through_pdf(bsdf, local);
	if (lobes->coat > 0.0f) {
		shade_frame frame = shade_frame_from_normal(bsdf->layers->coat_normal);
		pdf += lobes->coat * shade_pdf_ggx_visible(coat_alphas(bsdf), shade_frame_to_local(frame, bsdf->to_viewer),
		                                           shade_frame_to_local(frame, l));
	}
	return pdf;
}

/* A direction by one of the lobes but the last. */
static stilb_vec3 layered_direction(const gi_bsdf *bsdf, float u_lobe, stilb_vec2 u)
{
	const gi_lobes *lobes = &bsdf->layers->lobes;
	float end = lobes->coat;
	if (u_lobe < end) {
		shade_frame frame = shade_frame_from_normal(bsdf->layers->coat_normal);
		stilb_vec3 local = shade_frame_to_local(frame, bsdf->to_viewer);
		return shade_frame_to_world(frame, shade_sample_ggx_visible(coat_alphas(bsdf), local, u).direction);
	}
	if (u_lobe < (end += lobes->highlight))
		return shade_frame_to_world(bsdf->frame, highlight_sample(bsdf, u).direction);
	if (u_lobe < (end += lobes->sheen))
		return shade_frame_to_world(bsdf->frame, shade_sample_hemisphere(u).direction);
	if (u_lobe < end + lobes->diffuse)
		return shade_frame_to_world(bsdf->frame, shade_sample_cosine(u).direction);
	stilb_vec3 mirrored = shade_sample_ggx_visible(through_alphas(bsdf), bsdf->local, u).direction;
	return shade_frame_to_world(bsdf->frame, stilb_vec3_make(mirrored[0], mirrored[1], -mirrored[2]));
}

/* A direction into a volume or out of it, where no other lobe carries anything. The weight is of the facet that was
 * chosen, which could be told from both directions only where light turns much. */
static bool glass_sample(const gi_bsdf *bsdf, stilb_vec2 u, gi_bsdf_sample *chosen)
{
	const gi_lobes *lobes = &bsdf->layers->lobes;
	shade_alphas alphas = through_alphas(bsdf);
	stilb_vec3 v = bsdf->local, h = shade_sample_ggx_visible_normal(alphas, v, u).direction;
	float v_dot_h = stilb_vec3_dot(v, h);
	if (!(v_dot_h > 0.0f) || gi_glass_beyond(lobes->eta, v_dot_h) == 0.0f)
		return false;
	stilb_vec3 local = stilb_vec3_normalize(gi_glass_refract(lobes->eta, v, h));
	chosen->direction = stilb_vec3_normalize(shade_frame_to_world(bsdf->frame, local));
	if (!(local[2] < 0.0f) || !(stilb_vec3_dot(bsdf->geometric, chosen->direction) < 0.0f))
		return false;
	float share = gi_glass_share(lobes->eta, bsdf->highlight.specular, alphas.x, v_dot_h, local[2]);
	chosen->pdf = lobes->through * gi_glass_pdf(lobes->eta, alphas, v, local);
	chosen->weight = bsdf->layers->through * (share * lobes->sheen_left * (1.0f - lobes->coat_share) / lobes->through);
	return true;
}

static __attribute__((noinline)) bool layered_sample(const gi_bsdf *bsdf, float u_lobe, stilb_vec2 u,
                                                     gi_bsdf_sample *chosen)
{
	bool solid = bsdf->layers->solid && bsdf->layers->lobes.through > 0.0f;
	if (solid && u_lobe >= 1.0f - bsdf->layers->lobes.through)
		return glass_sample(bsdf, u, chosen);
	chosen->direction = stilb_vec3_normalize(layered_direction(bsdf, u_lobe, u));
	chosen->pdf = layered_pdf(bsdf, chosen->direction);
	if (!(chosen->pdf > 0.0f) || (solid && stilb_vec3_dot(bsdf->geometric, chosen->direction) < 0.0f))
		return false;
	chosen->weight = layered_cos(bsdf, chosen->direction) / chosen->pdf;
	return chosen->weight[0] + chosen->weight[1] + chosen->weight[2] > 0.0f;
}

/* ---- all --------------------------------------------------------------------------------------------------------- */

bool gi_bsdf_is_matt(const shade_brdf_model *model, const gi_surface *surface)
{
	stilb_vec3 specular = surface->specular;
	return !surface->layered && (!has_highlight(model) || !(specular[0] + specular[1] + specular[2] > 0.0f));
}

void gi_bsdf_make(const shade_brdf_model *model, gi_surface *surface, stilb_vec3 to_viewer, gi_bsdf *bsdf)
{
	STILB_ASSERT(model->kind >= 0 && model->kind < SHADE_BRDF_COUNT);
	stilb_vec3 n = surface->normal, specular = surface->specular;
	/* Fields that a diffuse surface does not need are left uninitialised: this runs at every vertex. */
	if (surface->layered) {
		layered_make(model, surface, to_viewer, bsdf);
		return;
	}
	bsdf->geometric = surface->geometric;
	bsdf->diffuse = surface->diffuse;
	bsdf->share = 0.0f;
	if (gi_bsdf_is_matt(model, surface)) {
		bsdf->frame = shade_frame_from_normal(n);
		return;
	}
	/* The tangent is cross(up, n), as in the real-time renderer, so that anisotropic highlights look the same. */
	bsdf->frame = shade_frame_from_tangent(n, stilb_vec3_make(n[2], 0.0f, -n[0]));
	bsdf->to_viewer = to_viewer;
	bsdf->local = shade_frame_to_local(bsdf->frame, to_viewer);
	bsdf->model = *model;
	bsdf->highlight = (shade_brdf_parameters){
		.specular = specular, .roughness = surface->roughness, .anisotropy = surface->anisotropy};
	if (bsdf->diffuse[0] + bsdf->diffuse[1] + bsdf->diffuse[2] > 0.0f)
		bsdf->diffuse *= shade_brdf_diffuse_left(*model, bsdf->local[2], surface->roughness);
	bsdf->share = highlight_share(bsdf);
	bsdf->layers = NULL;
}

/* Of a direction that the surface sees. */
static stilb_vec3 highlight_cos(const gi_bsdf *bsdf, stilb_vec3 direction)
{
	return shade_lambert(bsdf->diffuse) * stilb_vec3_dot(bsdf->frame.n, direction) +
	       shade_brdf_cos(bsdf->model, bsdf->highlight, bsdf->frame, direction, bsdf->to_viewer);
}

stilb_vec3 gi_bsdf_highlight_cos(const gi_bsdf *bsdf, stilb_vec3 direction)
{
	STILB_ASSERT(bsdf->share > 0.0f && bsdf->share <= 1.0f);
	if (bsdf->layers)
		return layered_cos(bsdf, direction);
	return gi_bsdf_sees(bsdf, direction) ? highlight_cos(bsdf, direction) : (stilb_vec3){0};
}

static float mixed_pdf(const gi_bsdf *bsdf, stilb_vec3 local)
{
	return glsl_mix_1(shade_pdf_cosine(local), highlight_pdf(bsdf, local), bsdf->share);
}

float gi_bsdf_highlight_pdf(const gi_bsdf *bsdf, stilb_vec3 direction)
{
	STILB_ASSERT(bsdf->share > 0.0f && bsdf->share <= 1.0f);
	if (bsdf->layers)
		return layered_pdf(bsdf, direction);
	return mixed_pdf(bsdf, shade_frame_to_local(bsdf->frame, direction));
}

bool gi_bsdf_highlight_sample(const gi_bsdf *bsdf, float u_lobe, stilb_vec2 u, gi_bsdf_sample *chosen)
{
	STILB_ASSERT(bsdf->share > 0.0f && bsdf->share <= 1.0f);
	STILB_ASSERT(u_lobe >= 0.0f && u_lobe < 1.0f);
	if (bsdf->layers)
		return layered_sample(bsdf, u_lobe, u, chosen);
	shade_sample local = u_lobe < bsdf->share ? highlight_sample(bsdf, u) : shade_sample_cosine(u);
	chosen->direction = stilb_vec3_normalize(shade_frame_to_world(bsdf->frame, local.direction));
	chosen->pdf = mixed_pdf(bsdf, local.direction);
	if (!(chosen->pdf > 0.0f) || !gi_bsdf_sees(bsdf, chosen->direction))
		return false;
	chosen->weight = highlight_cos(bsdf, chosen->direction) / chosen->pdf;
	return true;
}
