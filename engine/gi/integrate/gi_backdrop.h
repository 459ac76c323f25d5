/*
 * gi_backdrop: what camera rays see that meet nothing: the scene's backdrop in place of the surroundings, and on its
 * floor the shadow of the models. [any-thread]
 */
#ifndef STILB_GI_BACKDROP_H
#define STILB_GI_BACKDROP_H

#include "gi/integrate/gi_integrator.h"

/* Copies the scene's backdrop, with its map and its floor, and what the floor needs to know of the lights.
 * STILB_ERROR_MEMORY; then *out is NULL. */
stilb_result gi_backdrop_create(const stilb_scene *scene, gi_backdrop **out);

/* Accepts NULL. */
void gi_backdrop_destroy(gi_backdrop *backdrop);

/* Adds the backdrop to a hash of the scene. */
uint64_t gi_backdrop_hash(uint64_t hash, const gi_backdrop *backdrop);

/* True if nothing is behind the models, so that files with alpha are transparent there. */
bool gi_backdrop_is_nothing(const gi_backdrop *backdrop);

/* Replaces the radiance of the batch's camera rays that hit nothing, after the integrator: not if the backdrop is the
 * surroundings, which the integrator has seen, nor in pictures of indirect light and of the integrators color, ao and
 * channel, which are not of light; but nothing is nothing for all of them.
 *
 * The floor shows its color times 1 - blocked / unblocked, both of the irradiance that it would get: unblocked is a
 * closed form, and blocked is estimated by one light of each group (gi_light.h) and a shadow ray to it. So the mean
 * of many samples has no bias, and a single one may be negative. */
void gi_backdrop_shade(gi_batch *batch);

#endif
