/*
 * gi_light_shape: one emitting triangle, or two that make a rectangle, and how points of it are sampled. For
 * gi_light.c and tests. [any-thread]
 *
 * From afar points are uniform by area. From near, where distance and cosine vary over the shape, they are uniform
 * by solid angle, so that all samples count the same. Sources: Arvo, "Stratified Sampling of Spherical Triangles"
 * (1995); Urena, Fajardo, King, "An Area-Preserving Parametrization for Spherical Rectangles" (2013); Van Oosterom
 * and Strackee, "The Solid Angle of a Plane Triangle" (1983).
 */
#ifndef STILB_GI_LIGHT_SHAPE_H
#define STILB_GI_LIGHT_SHAPE_H

#include "base/base_math.h"
#include "gi/light/gi_light.h"

typedef struct gi_light_shape {
	stilb_vec3 corner, edge_1, edge_2; /* counter-clockwise as seen from the front */
	stilb_vec3 normal;                 /* unit, towards the front */
	stilb_vec3 center;
	stilb_vec3 emission;       /* the mean, if there is a glow */
	const gi_glow *glow;       /* what its points emit; NULL: emission. A triangle's alone */
	stilb_vec3 unit_1, unit_2; /* directions of the edges of a rectangle, unit, */
	float length_1, length_2;  /* and their lengths */
	float area;                /* m^2; 0: it is never sampled */
	float error;               /* gi_triangle_error of the triangles, the larger one */
	bool unmet;                /* gi_emitter.unmet */
	bool rectangle;            /* spanned by edge_1 and edge_2; else the triangle that is half of it */
} gi_light_shape;

gi_light_shape gi_light_shape_make(const gi_emitter *emitter);

/* Makes one shape of two triangles that form a rectangle of one emission and one front. False: they do not. */
bool gi_light_shape_join(const gi_emitter *first, const gi_emitter *second, gi_light_shape *shape);

/* Samples a point: fills direction, distance, radiance and pdf, the probability of choosing the shape not included.
 * False: position is behind the shape or in its plane. u in [0, 1)^2. */
bool gi_light_shape_sample(const gi_light_shape *shape, stilb_vec3 position, stilb_vec2 u, gi_light_sample *sample);

/* The density of gi_light_shape_sample, per steradian, for a point of the shape at that distance. */
float gi_light_shape_density(const gi_light_shape *shape, stilb_vec3 position, float distance);

#endif
