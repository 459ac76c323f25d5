/*
 * numeric_catalog: the table of the distributions, reflection models and samplers of engine/shading: formula and source
 * of each, which of its integrals is 1, and whether it conserves energy and is reciprocal. Tests assert every row;
 * `stilb shade` and docs/shading.md print it.
 *
 *   size_t count;
 *   const stilb_numeric_row *rows = stilb_numeric_catalog(&count);
 *   stilb_numeric_shape shape = {.roughness = 0.5f, .view = {0.0f, 0.0f, 1.0f}};
 *   for (size_t i = 0; i < count; i++)
 *       printf("%s: %s is %g\n", rows[i].name, stilb_numeric_measure_text(rows[i].measure),
 *              stilb_numeric_measure_of(&rows[i], &shape));
 *
 * Space.    Directions are in a tangent frame: z along the normal or the lobe's axis.
 * Threads.  The table is constant; pure functions: [any-thread].
 */
#ifndef STILB_NUMERIC_CATALOG_H
#define STILB_NUMERIC_CATALOG_H

#include "numeric/numeric_albedo.h"

#include "shading/shade_brdf.h"
#include "shading/shade_sampling.h"

#include <stdbool.h>
#include <stddef.h>

typedef enum stilb_numeric_kind {
	/* A density of microfacet normals or of directions. */
	STILB_NUMERIC_DISTRIBUTION,
	/* A reflection model: f(l, v), sr^-1. */
	STILB_NUMERIC_BRDF,
	/* A way to choose directions at random, with its density. */
	STILB_NUMERIC_SAMPLER,
	STILB_NUMERIC_KIND_COUNT
} stilb_numeric_kind;

/* Which integral of a row is 1. This is what its constant factor is made for; seen from another angle a model may still
 * reflect more than it gets. */
typedef enum stilb_numeric_measure {
	/* Integral of the distribution D(h) over all directions h. */
	STILB_NUMERIC_MEASURE_D,
	/* Integral of D(h) n.h over all directions h, n being the normal: the projected area of the facets. */
	STILB_NUMERIC_MEASURE_D_COS,
	/* Integral of BRDF x n.l over the light directions, seen along the normal, at every roughness. */
	STILB_NUMERIC_MEASURE_REFLECTED,
	/* That integral at roughness 0 alone, where the lobe becomes a mirror. */
	STILB_NUMERIC_MEASURE_SMOOTH,
	/* Integral of the sampler's density over all directions. */
	STILB_NUMERIC_MEASURE_PDF,
	STILB_NUMERIC_MEASURE_COUNT
} stilb_numeric_measure;

/* The direction about which a sampler's density is concentrated, so that quadrature resolves it. */
typedef enum stilb_numeric_pole {
	/* z. */
	STILB_NUMERIC_POLE_AXIS,
	/* The view direction mirrored at z. */
	STILB_NUMERIC_POLE_MIRRORED,
	/* Directions whose half vector with the view is z. */
	STILB_NUMERIC_POLE_HALF,
} stilb_numeric_pole;

/* The arguments of a row's functions. roughness in [0, 1], anisotropy in (-1, 1), view unit and above the surface. */
typedef struct stilb_numeric_shape {
	float roughness, anisotropy;
	stilb_vec3 view;
} stilb_numeric_shape;

typedef struct stilb_numeric_row {
	/* Lower case and '_'; unique. */
	const char *name;
	/* The formula as text, and the paper it is from. */
	const char *formula;
	const char *source;
	stilb_numeric_kind kind;
	stilb_numeric_measure measure;

	/* DISTRIBUTION: D(direction); SAMPLER: the density of choosing the direction. sr^-1. Else NULL. */
	float (*density)(const stilb_numeric_shape *shape, stilb_vec3 direction);

	/* SAMPLER: a direction and its density from two random numbers, u in [0, 1)^2. Else NULL. */
	shade_sample (*sample)(const stilb_numeric_shape *shape, stilb_vec2 u);
	stilb_numeric_pole pole;

	/* BRDF: the model. conserving: the albedo of a white surface is at most 1 for every direction and roughness, both
	 * from the view and from the light. reciprocal: f(l, v) = f(v, l). largest_albedo: what
	 * stilb_numeric_largest_albedo gives, to 1e-3; 1 where conserving. */
	shade_brdf_model model;
	bool conserving, reciprocal;
	double largest_albedo;
} stilb_numeric_row;

/* All rows: distributions, then BRDFs, then samplers. *count is their number. */
const stilb_numeric_row *stilb_numeric_catalog(size_t *count);

/* The row of a name, in which '-' may stand for '_'; NULL: there is none. */
const stilb_numeric_row *stilb_numeric_catalog_find(const char *name);

/* The measure in words: "integral of D n.h", ...; "unknown" for a value out of range. */
const char *stilb_numeric_measure_text(stilb_numeric_measure measure);

/* The integral that row->measure names, by quadrature, for a shape. 1 where the row holds what it claims. */
double stilb_numeric_measure_of(const stilb_numeric_row *row, const stilb_numeric_shape *shape);

/* The parameters of a white surface: F0 = 1, no diffuse part but the wrapped model's, wrap 1. roughness in [0, 1]. */
shade_brdf_parameters stilb_numeric_white(float roughness, float anisotropy);

/* The larger one of the albedos of_view and of_light (numeric_albedo.h) of a white surface. row->kind is
 * STILB_NUMERIC_BRDF; anisotropic models get the anisotropy STILB_NUMERIC_CATALOG_ANISOTROPY. */
double stilb_numeric_white_albedo(const stilb_numeric_row *row, float roughness, stilb_numeric_angles angles);

#define STILB_NUMERIC_CATALOG_ANISOTROPY 0.6f

/* The largest stilb_numeric_white_albedo at 0, 10, ... 80, 85, 89 degrees from the normal and roughness 0, 0.05, ... 1;
 * of anisotropic models along the frame's t and across it. Models that do not conserve energy grow beyond 89 degrees:
 * Smith-Beckmann's G towards 1.34 with Blinn's D and 1.74 with GGX, the others without a bound. Takes up to 1 s. */
double stilb_numeric_largest_albedo(const stilb_numeric_row *row);

#endif
