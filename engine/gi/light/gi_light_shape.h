/*
 * gi_light_shape: one emitting triangle, or two that make a rectangle, and the ways to choose a point of it. Used by
 * gi_light.c alone, and by tests. [any-thread]
 *
 * From afar a point is chosen by area; from near, where the distance and the light's cosine differ much over the shape, by
 * the solid angle that it fills, so that every sample counts the same. Sources: Arvo, "Stratified Sampling of Spherical
 * Triangles" (1995); Urena, Fajardo, King, "An Area-Preserving Parametrization for Spherical Rectangles" (2013); the solid
 * angle: Van Oosterom and Strackee, "The Solid Angle of a Plane Triangle" (1983).
 */
#ifndef STILB_GI_LIGHT_SHAPE_H
#define STILB_GI_LIGHT_SHAPE_H

#include "base/base_math.h"
#include "gi/light/gi_light.h"

typedef struct gi_light_shape {
	stilb_vec3 corner, edge_1, edge_2; /* counter-clockwise seen from the front */
	stilb_vec3 normal;                 /* unit, of the front */
	stilb_vec3 center;
	stilb_vec3 emission;
	stilb_vec3 unit_1, unit_2; /* of the edges of a rectangle, and */
	float length_1, length_2;  /* their lengths */
	float area;                /* 0: it is never asked */
	float error;               /* the triangles' own, gi_triangle_error */
	bool rectangle;            /* edge_1 x edge_2; else half of it, a triangle */
} gi_light_shape;

gi_light_shape gi_light_shape_make(const gi_emitter *emitter);

/* Two triangles that make a rectangle of one colour with one front become one shape; else false. */
bool gi_light_shape_join(const gi_emitter *first, const gi_emitter *second, gi_light_shape *shape);

/* Fills direction, distance, radiance and pdf (without the choice); false: position sees its back, or its edge. */
bool gi_light_shape_sample(const gi_light_shape *shape, stilb_vec3 position, stilb_vec2 u, gi_light_sample *sample);

/* The density with which sample chooses a point of the shape that is so far away. */
float gi_light_shape_density(const gi_light_shape *shape, stilb_vec3 position, float distance);

#endif
