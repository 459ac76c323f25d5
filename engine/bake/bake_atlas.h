/*
 * bake_atlas: a place on pages of texels for every chart of every part of a scene.
 *
 * Meshes are unwrapped once, for all parts that show them scaled evenly; a part that is stretched is unwrapped by
 * itself, as it lies in the world. Each part has texels of its own. Texel (i, j) of a page covers the square from
 * (i, j) to (i + 1, j + 1), row 0 at the top; a place on the page over its side is the second uv.
 *
 * Life cycle.  stilb_bake_atlas_create -> stilb_bake_atlas_destroy. In between constant, read by any thread.
 * Threads.     create: [main-thread] of the pool.
 * Units.       Metres of the world, texels.
 */
#ifndef STILB_BAKE_ATLAS_H
#define STILB_BAKE_ATLAS_H

#include "bake/bake_unwrap.h"
#include "scene/scene.h"

typedef struct stilb_bake_atlas_options {
	stilb_bake_unwrap_options unwrap;
	float density; /* texels a metre, > 0; 0: as many as about fill one page, as far as that is possible */
	uint32_t side; /* of a page, texels: 64..STILB_BAKE_MAX_SIDE */
	/* Mip levels below the largest, 0..6, in which lookups between texels stay on their chart: decides how wide the
	 * border around charts is. */
	uint32_t mips;
} stilb_bake_atlas_options;

/* Fills a page of 1024, one level below it. [any-thread] */
stilb_bake_atlas_options stilb_bake_atlas_options_default(void);

/* Where a part's chart lies. */
typedef struct stilb_bake_place {
	uint32_t page, x, y; /* of the box's corner (0, 0), texels; the border is around it */
	float scale;         /* texels a unit of stilb_bake_uv.corners */
} stilb_bake_place;

typedef struct stilb_bake_part {
	uint32_t uv;          /* index in stilb_bake_atlas.uvs; STILB_BAKE_NO_CHART: the part has no texels */
	uint32_t first_place; /* that of its first chart, the others follow */
} stilb_bake_part;

typedef struct stilb_bake_atlas {
	uint32_t side, page_count; /* page_count 0: nothing has texels */
	uint32_t border;           /* texels around each chart, at least */
	float density;             /* texels a metre */
	uint32_t part_count, uv_count, place_count;
	stilb_bake_part *parts; /* [part_count] those of the scene */
	stilb_bake_uv *uvs;     /* [uv_count] */
	stilb_bake_place *places;
	uint64_t triangles;     /* of all parts, with texels */
	uint64_t flat, invalid; /* without: of area 0, and with corners that are no places */
	uint32_t coarser;       /* charts that have fewer texels a metre, as they would not fit on a page */
	double stretch;         /* stilb_bake_stretch, the mean square over all parts */
	double covered;         /* share of the pages' area that charts have */
} stilb_bake_atlas;

/* Hidden models and parts without a mesh have no texels. STILB_ERROR_MEMORY; STILB_ERROR_ARGUMENT: there would be more
 * than 2^31 charts, or than STILB_BAKE_MAX_PAGES; then *out is NULL. */
#define STILB_BAKE_MAX_PAGES 1024u
stilb_result stilb_bake_atlas_create(const stilb_scene *scene, const stilb_bake_atlas_options *options,
                                     stilb_job_pool *pool, stilb_bake_atlas **out);

/* Accepts NULL. [one-writer] */
void stilb_bake_atlas_destroy(stilb_bake_atlas *atlas);

/* The place of a part's triangle on its page, texels: its three corners. False: it has none. [any-thread] */
bool stilb_bake_atlas_corners(const stilb_bake_atlas *atlas, uint32_t part, uint32_t triangle, uint32_t *page,
                              float corners[3][2]);

#endif
