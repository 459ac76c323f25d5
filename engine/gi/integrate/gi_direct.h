/*
 * gi_direct: direct light at one vertex of a path by multiple importance sampling of two techniques: a light is
 * sampled, or the path's next ray happens to hit it. The weights of both techniques add up to 1. [any-thread]
 */
#ifndef STILB_GI_DIRECT_H
#define STILB_GI_DIRECT_H

#include "gi/integrate/gi_integrator.h"
#include "gi/sample/gi_bsdf.h"

/* Who else finds the light that is asked for. */
typedef enum gi_direct_beside {
	GI_DIRECT_ALONE, /* nobody: asking has to find all of it */
	/* The path's next ray, which may go wherever the surface reflects: it finds what is around alone where that is no
	 * brighter than its mean. */
	GI_DIRECT_WITH_RAY,
	/* A ray that follows the highlight alone, though all that it finds counts: the sky is asked, too. */
	GI_DIRECT_WITH_HIGHLIGHT,
} gi_direct_beside;

/* The weight, by multiple importance sampling, of a direction that was chosen with density pdf and that another
 * technique chooses with density other: the power heuristic, beta = 2, written so that no square overflows.
 * Source: Veach, "Robust Monte Carlo Methods for Light Transport Simulation" (1997), 9.2.4. */
static inline float gi_direct_weight(float pdf, float other)
{
	float ratio = other / pdf;
	return 1.0f / (1.0f + ratio * ratio);
}

/* Samples one light of each group. direct[i]: radiance that the surface reflects towards its viewer if nothing is on
 * the shadow ray shadows[i], which the caller passes to gi_tracer.occluded; returns how many there are, at most
 * GI_LIGHT_GROUPS. origin: gi_surface_ray_origin, on the viewer's side. numbers: gi_sample_8 of the vertex. Unless it
 * is alone, gi_direct_found will count light that a ray hits, so direct gets its weight by multiple importance sampling
 * (MIS) against gi_bsdf_pdf, the density of that ray. part: gi_surface.part. */
uint32_t gi_direct_ask(const gi_view *view, const gi_bsdf *bsdf, uint32_t part, stilb_vec3 origin,
                       const float numbers[8], gi_direct_beside beside, gi_ray *shadows, stilb_vec3 *direct);

/* True if asking has to find all of the light, as no ray that leaves the part can: its MIS weight is 1. Of a part that
 * receives no shadows rays towards lights meet nothing, so that they find the surroundings alone. */
static inline bool gi_direct_asks_alone(const gi_part *part, const gi_light_sample *light)
{
	return light->delta || (!part->lit_by && light->distance < INFINITY);
}

/* From which side a layered surface asks a light. False: from none. origin, normal: those of the viewer's side before,
 * of the side that is asked afterwards; choice: the number that decides, [0, 1), and another such number afterwards;
 * *chance: probability of that side. */
bool gi_direct_side(const gi_bsdf *bsdf, stilb_vec3 *origin, stilb_vec3 *normal, float *choice, float *chance);

/* What gi_direct_found needs to know of a direction that gi_bsdf_sample_direction chose. */
typedef struct gi_direct_left {
	stilb_vec3 normal; /* of the surface that the ray left */
	float pdf;         /* 0: no light was asked there, and all that the ray finds counts in full */
	gi_direct_beside beside;
} gi_direct_left;

static inline gi_direct_left gi_direct_leave(const gi_bsdf *bsdf, const gi_bsdf_sample *chosen, gi_direct_beside beside)
{
	const gi_layers *layers = gi_bsdf_layers(bsdf);
	if (!layers)
		return (gi_direct_left){bsdf->frame.n, chosen->pdf, beside};
	/* The density of asking is times the side's chance, and only its quotient with the other density counts. */
	bool beyond = stilb_vec3_dot(bsdf->geometric, chosen->direction) < 0.0f;
	float chance = beyond ? layers->lobes.ask_beyond : layers->lobes.ask;
	return (gi_direct_left){beyond ? -bsdf->frame.n : bsdf->frame.n, chance > 0.0f ? chosen->pdf / chance : 0.0f,
	                        beside};
}

/* Emission that a traced ray found, with its MIS weight against gi_direct_ask: of surface, or of the surroundings if
 * surface is NULL, which it is for a miss. */
stilb_vec3 gi_direct_found(const gi_view *view, const gi_direct_left *left, const gi_ray_hit *ray,
                           const gi_surface *surface);

/* Traces a ray that left a surface of the part as one towards lights, and returns what it finds of them, as of
 * gi_direct_found. ray: as it will be traced to look, which in a scene with gi_scene.flagged may end elsewhere; there
 * light of gi_direct_left.pdf > 0 is found by this ray, not by the one that looks. *traced: the number of rays is
 * added. */
stilb_vec3 gi_direct_find(const gi_view *view, const gi_direct_left *left, uint32_t part, const gi_ray_hit *ray,
                          uint64_t *traced);

#endif
