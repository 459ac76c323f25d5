/*
 * bake_light: the light that arrives at the texels of a page, by the integrators of gi.
 *
 * Lightmap.    Radiance that a white surface which reflects evenly would have there: irradiance over pi. Times the
 *              diffuse colour it is what is seen.
 * Openness.    The cosine-weighted share of the hemisphere that nothing hides within a distance: ambient occlusion.
 * Samples.     Each texel has as many, shared among its spots; their random numbers are those of the page, of the
 *              texel's column and row, and of the sample: nothing else. So the result has the same bits for any number
 *              of workers, and a page by itself is the same as among others.
 * Hidden.      A spot whose rays mostly meet backs of surfaces lies inside of something, as the floor below a
 *              cupboard: it counts only where no spot of the texel sees out, and such a texel is filled from its
 *              neighbours (bake_fill.h). If a chart has no other, it keeps what it has.
 * Threads.     [main-thread] of the pool.
 */
#ifndef STILB_BAKE_LIGHT_H
#define STILB_BAKE_LIGHT_H

#include "bake/bake_basis.h"
#include "bake/bake_texels.h"
#include "gi/gi_gather.h"

/* Called on the calling thread as the work goes on, ten times a second at most: done in [0, 1]. False: give up. */
typedef bool stilb_bake_watch_fn(void *user, double done);

typedef struct stilb_bake_light_options {
	uint32_t samples;           /* of each texel, 1..65536, as gi_settings.samples of the gather */
	float ao_distance;          /* metres, > 0: what is farther away hides nothing; INFINITY */
	bool keep_hidden;           /* hidden texels are as others */
	stilb_bake_watch_fn *watch; /* NULL: nobody */
	void *user;
} stilb_bake_light_options;

/* What a texel has. */
typedef enum stilb_bake_state {
	STILB_BAKE_EMPTY,  /* nothing: no triangle touches it */
	STILB_BAKE_FILLED, /* what its neighbours have: bake_fill.h */
	STILB_BAKE_HIDDEN, /* it lies inside of something */
	STILB_BAKE_LIT,
} stilb_bake_state;

/* What is written of a page: a pointer that is NULL is not asked for. Texels without spots are 0. */
typedef struct stilb_bake_layers {
	float (*light)[3];                         /* [side * side] the lightmap */
	float (*directional)[STILB_BAKE_BASIS][3]; /* [side * side] bake_basis.h; only with light */
	float *open;                               /* [side * side] */
	uint8_t *state;                            /* [side * side] stilb_bake_state, never NULL; by the rays of light */
} stilb_bake_layers;

/* Bakes a page. gather: for as many threads as the pool has with its owner. The scene is that of atlas and gather.
 * STILB_ERROR_MEMORY; STILB_ERROR_GIVEN_UP. */
stilb_result stilb_bake_light(const stilb_scene *scene, const stilb_bake_atlas *atlas, const stilb_bake_texels *texels,
                              stilb_gi_gather *gather, stilb_job_pool *pool, const stilb_bake_light_options *options,
                              const stilb_bake_layers *layers);

#endif
