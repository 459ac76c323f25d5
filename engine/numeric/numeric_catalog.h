/*
 * numeric_catalog: the one table of the distributions, reflection models and samplers of engine/shading: what each is, what it
 * must integrate to, and what it keeps. Tests assert it, `stilb shade` and docs/shading.md print it.
 *
 * Space.    Directions are in a tangent frame: z along the normal or the lobe's axis.
 * Threads.  The table never changes; pure functions: [any-thread].
 */
#ifndef STILB_NUMERIC_CATALOG_H
#define STILB_NUMERIC_CATALOG_H

#include "numeric/numeric_albedo.h"

#include "shading/shade_brdf.h"
#include "shading/shade_sampling.h"

#include <stdbool.h>
#include <stddef.h>

typedef enum stilb_numeric_kind {
	STILB_NUMERIC_DISTRIBUTION, /* of microfacet normals, or of directions */
	STILB_NUMERIC_BRDF,
	STILB_NUMERIC_SAMPLER,
	STILB_NUMERIC_KIND_COUNT
} stilb_numeric_kind;

/* The integral that is 1. Normalised by any of these is not yet energy conserving. */
typedef enum stilb_numeric_measure {
	STILB_NUMERIC_MEASURE_D,         /* of D over all directions */
	STILB_NUMERIC_MEASURE_D_COS,     /* of D n.h: the area of the facets seen from above */
	STILB_NUMERIC_MEASURE_REFLECTED, /* of BRDF x n.l over the light, seen along the normal, for every roughness */
	STILB_NUMERIC_MEASURE_SMOOTH,    /* the same at the least roughness: it becomes a mirror */
	STILB_NUMERIC_MEASURE_PDF,       /* of the density over all directions */
	STILB_NUMERIC_MEASURE_COUNT
} stilb_numeric_measure;

/* Where a sampler's density is dense. */
typedef enum stilb_numeric_pole {
	STILB_NUMERIC_POLE_AXIS,     /* z */
	STILB_NUMERIC_POLE_MIRRORED, /* the mirrored view */
	STILB_NUMERIC_POLE_HALF,     /* where the half vector of the direction and the view is z */
} stilb_numeric_pole;

/* What a row's functions depend on. roughness in [0, 1], anisotropy in (-1, 1), view above the surface. */
typedef struct stilb_numeric_shape {
	float roughness, anisotropy;
	stilb_vec3 view;
} stilb_numeric_shape;

typedef struct stilb_numeric_row {
	const char *name; /* lower case and '_'; no two rows share it */
	const char *formula;
	const char *source;
	stilb_numeric_kind kind;
	stilb_numeric_measure measure;

	/* STILB_NUMERIC_DISTRIBUTION: D(h), and STILB_NUMERIC_SAMPLER: the density of a direction. sr^-1 */
	float (*density)(const stilb_numeric_shape *shape, stilb_vec3 direction);

	/* STILB_NUMERIC_SAMPLER: u in [0, 1) each. */
	shade_sample (*sample)(const stilb_numeric_shape *shape, stilb_vec2 u);
	stilb_numeric_pole pole;

	/* STILB_NUMERIC_BRDF. conserving: the albedo of a white surface is at most 1 for every direction and roughness, seen from the
	 * view and from the light. largest_albedo: over the directions and roughnesses of stilb_numeric_largest_albedo; 1 or less
	 * but for rounding where conserving. reciprocal: f(l, v) = f(v, l). */
	shade_brdf_model model;
	bool conserving, reciprocal;
	double largest_albedo;
} stilb_numeric_row;

/* All rows: distributions, then BRDFs, then samplers. */
const stilb_numeric_row *stilb_numeric_catalog(size_t *count);

/* By name, where '-' is as good as '_'; NULL: there is none. */
const stilb_numeric_row *stilb_numeric_catalog_find(const char *name);

/* "integral of D n.h", ... */
const char *stilb_numeric_measure_text(stilb_numeric_measure measure);

/* The row's own measure by quadrature. */
double stilb_numeric_measure_of(const stilb_numeric_row *row, const stilb_numeric_shape *shape);

/* A white surface: F0 = 1, and wrapped all the way. */
shade_brdf_parameters stilb_numeric_white(float roughness, float anisotropy);

/* The larger one of the albedos seen from the view and from the light. row->kind is STILB_NUMERIC_BRDF. */
double stilb_numeric_white_albedo(const stilb_numeric_row *row, float roughness, stilb_numeric_angles angles);

/* The largest of those at 0, 10, ... 80, 85, 89 degrees and the roughnesses 0, 0.05, ... 1; anisotropy 0.6, along and across.
 * What does not conserve energy grows on beyond 89 degrees: Smith-Beckmann's pairs to a limit of 1.34 with Blinn and of 1.74
 * with GGX, the others without a bound. */
#define STILB_NUMERIC_CATALOG_ANISOTROPY 0.6f
double stilb_numeric_largest_albedo(const stilb_numeric_row *row);

#endif
