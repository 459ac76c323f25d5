/*
 * gi_bsdf: how a surface scatters light towards one viewer: Lambert's diffuse share and the highlight of any shade_brdf_model,
 * evaluated, sampled, and weighed. [any-thread]
 *
 * Directions are unit and point away from the surface. Surfaces are opaque: what lies below the triangle's plane is 0, and so is
 * what lies below the shading normal's.
 */
#ifndef STILB_GI_BSDF_H
#define STILB_GI_BSDF_H

#include "gi/gi_surface.h"
#include "shading/shade_brdf.h"
#include "shading/shade_sampling.h"

typedef struct gi_bsdf {
	shade_frame frame;      /* about the shading normal */
	stilb_vec3 geometric;   /* the triangle's normal, on the viewer's side */
	stilb_vec3 to_viewer;   /* in the world, and */
	stilb_vec3 local;       /* in the frame */
	stilb_vec3 diffuse;     /* reflectance */
	shade_brdf_model model; /* of the highlight */
	shade_brdf_parameters highlight;
	float share; /* [0, 1]: probability that gi_bsdf_sample asks the highlight; 0: there is none */
} gi_bsdf;

/* SHADE_BRDF_LAMBERT and SHADE_BRDF_WRAPPED have no highlight: light that would wrap around the terminator comes from below the
 * surface, where an opaque one sees nothing. */
gi_bsdf gi_bsdf_make(const shade_brdf_model *model, const gi_surface *surface, stilb_vec3 to_viewer);

/* Above the triangle and above the shading normal's horizon. */
static inline bool gi_bsdf_sees(const gi_bsdf *bsdf, stilb_vec3 direction)
{
	return stilb_vec3_dot(bsdf->geometric, direction) > 0.0f && stilb_vec3_dot(bsdf->frame.n, direction) > 0.0f;
}

/* gi_bsdf_cos and gi_bsdf_pdf of a direction that the surface sees, where there is a highlight. */
stilb_vec3 gi_bsdf_highlight_cos(const gi_bsdf *bsdf, stilb_vec3 direction);
float gi_bsdf_highlight_pdf(const gi_bsdf *bsdf, stilb_vec3 direction);

/* BSDF times n.l, sr^-1; 0 below the surface. */
static inline stilb_vec3 gi_bsdf_cos(const gi_bsdf *bsdf, stilb_vec3 direction)
{
	if (!gi_bsdf_sees(bsdf, direction))
		return (stilb_vec3){0};
	if (bsdf->share > 0.0f)
		return gi_bsdf_highlight_cos(bsdf, direction);
	return shade_lambert(bsdf->diffuse) * stilb_vec3_dot(bsdf->frame.n, direction);
}

/* The density of gi_bsdf_sample_direction, per steradian. */
static inline float gi_bsdf_pdf(const gi_bsdf *bsdf, stilb_vec3 direction)
{
	if (bsdf->share > 0.0f)
		return gi_bsdf_highlight_pdf(bsdf, direction);
	return shade_pdf_cosine((stilb_vec3){0.0f, 0.0f, stilb_vec3_dot(bsdf->frame.n, direction)});
}

typedef struct gi_bsdf_sample {
	stilb_vec3 direction;
	stilb_vec3 weight; /* BSDF n.l / pdf; of a diffuse surface exactly its reflectance */
	float pdf;
} gi_bsdf_sample;

/* As below, where there is a highlight. */
bool gi_bsdf_highlight_sample(const gi_bsdf *bsdf, float u_lobe, stilb_vec2 u, gi_bsdf_sample *chosen);

/* u_lobe and u in [0, 1). False: the direction is below the surface, and carries nothing. */
static inline bool gi_bsdf_sample_direction(const gi_bsdf *bsdf, float u_lobe, stilb_vec2 u, gi_bsdf_sample *chosen)
{
	if (bsdf->share > 0.0f)
		return gi_bsdf_highlight_sample(bsdf, u_lobe, u, chosen);
	const shade_sample local = shade_sample_cosine(u);
	chosen->direction = shade_frame_to_world(bsdf->frame, local.direction);
	chosen->weight = bsdf->diffuse;
	chosen->pdf = local.pdf;
	return stilb_vec3_dot(bsdf->geometric, chosen->direction) > 0.0f;
}

#endif
