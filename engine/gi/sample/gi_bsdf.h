/*
 * gi_bsdf: how a surface scatters light towards one viewer: Lambert's diffuse part and the highlight of a
 * shade_brdf_model, and the layers of shade_layers.h; evaluated, sampled, with its density. [any-thread]
 *
 * Directions are unit and point away from the surface. Directions below the triangle or below the shading normal's
 * horizon get 0, but for what light goes through: below both, thin walls have a lobe of their own (not panes, which
 * rays pass before they come here: gi_through.h), and volumes one that refracts (gi_glass.h).
 */
#ifndef STILB_GI_BSDF_H
#define STILB_GI_BSDF_H

#include "gi/gi_surface.h"
#include "shading/shade_brdf.h"
#include "shading/shade_sampling.h"

typedef struct gi_bsdf {
	shade_frame frame;      /* about the shading normal */
	stilb_vec3 geometric;   /* the triangle's normal, on the viewer's side */
	stilb_vec3 to_viewer;   /* in world space, and */
	stilb_vec3 local;       /* in the frame's coordinates */
	stilb_vec3 diffuse;     /* reflectance, less what the highlight takes at the viewer's angle */
	shade_brdf_model model; /* the highlight's model */
	shade_brdf_parameters highlight;
	float share; /* probability that gi_bsdf_sample_direction samples the highlight, [0, 1]; 0: there is none */
	const gi_layers
		*layers; /* of the surface; NULL: there are none. Where there are some, share is 1. Set if share > 0 */
} gi_bsdf;

/* SHADE_BRDF_LAMBERT and SHADE_BRDF_WRAPPED have no highlight. The light that WRAPPED adds beyond Lambert's is left
 * out: it comes from below the surface, which an opaque surface does not see. A surface that is brushed has
 * SHADE_NDF_GGX_ANISOTROPIC in place of SHADE_NDF_GGX; other models show no brushing. surface must stay. Its lobes are
 * written if it is layered: so a gi_bsdf, which is made at every vertex, need not carry them. It is made in place, as a
 * copy would read whole vectors whose parts have just been stored (gi_ray.h). */
void gi_bsdf_make(const shade_brdf_model *model, gi_surface *surface, stilb_vec3 to_viewer, gi_bsdf *bsdf);

/* True if the surface, seen by this model, reflects as Lambert's law says and in no other way. */
bool gi_bsdf_is_matt(const shade_brdf_model *model, const gi_surface *surface);

/* Its layers; NULL: there are none. */
static inline const gi_layers *gi_bsdf_layers(const gi_bsdf *bsdf)
{
	return bsdf->share > 0.0f ? bsdf->layers : NULL;
}

static inline bool gi_bsdf_is_layered(const gi_bsdf *bsdf)
{
	return gi_bsdf_layers(bsdf);
}

/* True if the direction is on the other side of the triangle, where only light that goes through it is. */
static inline bool gi_bsdf_is_beyond(const gi_bsdf *bsdf, stilb_vec3 direction)
{
	return gi_bsdf_is_layered(bsdf) && stilb_vec3_dot(bsdf->geometric, direction) < 0.0f;
}

/* The origin of a ray that leaves in this direction; origin: of those on the viewer's side. */
static inline stilb_vec3 gi_bsdf_origin(const gi_bsdf *bsdf, stilb_vec3 origin, stilb_vec3 direction)
{
	const gi_layers *layers = gi_bsdf_layers(bsdf);
	return layers && stilb_vec3_dot(bsdf->geometric, direction) < 0.0f ? layers->lobes.beyond : origin;
}

/* True if the direction is above the triangle and above the shading normal's horizon. */
static inline bool gi_bsdf_sees(const gi_bsdf *bsdf, stilb_vec3 direction)
{
	return stilb_vec3_dot(bsdf->geometric, direction) > 0.0f && stilb_vec3_dot(bsdf->frame.n, direction) > 0.0f;
}

/* What gi_bsdf_cos and gi_bsdf_pdf return where there is a highlight (share > 0). */
stilb_vec3 gi_bsdf_highlight_cos(const gi_bsdf *bsdf, stilb_vec3 direction);
float gi_bsdf_highlight_pdf(const gi_bsdf *bsdf, stilb_vec3 direction);

/* The BSDF, sr^-1, times the cosine between the shading normal and the direction; 0 for one below the surface. */
static inline stilb_vec3 gi_bsdf_cos(const gi_bsdf *bsdf, stilb_vec3 direction)
{
	if (bsdf->share > 0.0f)
		return gi_bsdf_highlight_cos(bsdf, direction);
	if (!gi_bsdf_sees(bsdf, direction))
		return (stilb_vec3){0};
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
	stilb_vec3 weight; /* gi_bsdf_cos / pdf; for a diffuse surface exactly its reflectance */
	float pdf;
} gi_bsdf_sample;

/* What gi_bsdf_sample_direction does where there is a highlight (share > 0). */
bool gi_bsdf_highlight_sample(const gi_bsdf *bsdf, float u_lobe, stilb_vec2 u, gi_bsdf_sample *chosen);

/* Chooses a direction; u_lobe and u in [0, 1). False: it is below the surface and carries nothing. */
static inline bool gi_bsdf_sample_direction(const gi_bsdf *bsdf, float u_lobe, stilb_vec2 u, gi_bsdf_sample *chosen)
{
	if (bsdf->share > 0.0f)
		return gi_bsdf_highlight_sample(bsdf, u_lobe, u, chosen);
	shade_sample local = shade_sample_cosine(u);
	chosen->direction = shade_frame_to_world(bsdf->frame, local.direction);
	chosen->weight = bsdf->diffuse;
	chosen->pdf = local.pdf;
	return stilb_vec3_dot(bsdf->geometric, chosen->direction) > 0.0f;
}

#endif
