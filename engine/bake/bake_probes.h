/*
 * bake_probes: light in the air, for what moves: a grid of places, each with the radiance around it as spherical
 * harmonics, and how far it sees in each direction.
 *
 * Light.       Nine coefficients a channel (shade_sh.h) of the radiance from everywhere. A surface with the normal n
 *              has the irradiance shade_sh_irradiance of it.
 * Seen.        How far a probe sees, over 8 x 8 directions of an octahedron, so that what is behind something counts
 *              little. What is near in a direction is mostly flat, and the distance d to a plane n . x = h is in the
 *              direction w h / (n . w): 1 / d is linear in w. So each direction has the plane that fits the rays about
 *              it best, and the variance of 1 / d that is left, which makes a soft decision of it as Chebyshev's
 *              inequality does in Majercik, Guertin, Nowrouzezahrai, McGuire, "Dynamic Diffuse Global Illumination with
 *              Ray-Traced Irradiance Fields" (JCGT 2019).
 * Moved, dead. A probe whose rays meet backs of surfaces more often than a quarter of them lies inside of something. It
 *              moves out, if that is nearer than half a cell; else it is dead and does not count.
 * Same bits.   For any number of workers.
 * Threads.     bake: [main-thread] of the pool; at: [any-thread].
 * Units.       Metres, W m^-2 sr^-1.
 */
#ifndef STILB_BAKE_PROBES_H
#define STILB_BAKE_PROBES_H

#include "bake/bake_light.h"
#include "shading/shade_sh.h"

#define STILB_BAKE_SEEN 8u /* directions of the octahedron, each way */
#define STILB_BAKE_MAX_PROBES 1000000u

typedef struct stilb_bake_probe {
	shade_sh_rgb light;
	float position[3];
	float seen[STILB_BAKE_SEEN * STILB_BAKE_SEEN]
			  [4]; /* n / h of the plane, 1 / m, and the variance of 1 / d, 1 / m^2 */
	bool dead;
} stilb_bake_probe;

typedef struct stilb_bake_probes {
	uint32_t count[3]; /* >= 1 each */
	float low[3];      /* where probe (0, 0, 0) is, before it moves */
	float spacing;     /* metres from one to the next along each axis */
	uint32_t moved, dead;
	stilb_bake_probe *probes; /* [count[2]][count[1]][count[0]] */
} stilb_bake_probes;

typedef struct stilb_bake_probes_options {
	float spacing;    /* metres, > 0; 0: about 2,000 probes */
	uint32_t samples; /* of each probe, 16..65536; as of the gather */
	stilb_bake_watch_fn *watch;
	void *user;
} stilb_bake_probes_options;

/* Bakes a grid over the box of what rays can hit: of at least two cells each way, the outermost half a cell from its
 * sides. gather: for as many threads as the pool has with its owner. STILB_ERROR_ARGUMENT: more than
 * STILB_BAKE_MAX_PROBES, or nothing can be hit; STILB_ERROR_MEMORY; STILB_ERROR_GIVEN_UP. Then probes is {0}. */
stilb_result stilb_bake_probes_bake(const stilb_scene *scene, const stilb_gi_scene *gi_scene, stilb_gi_gather *gather,
                                    stilb_job_pool *pool, const stilb_bake_probes_options *options,
                                    stilb_bake_probes *probes);

/* Frees the probes and leaves {0}. Accepts {0}. [one-writer] */
void stilb_bake_probes_finish(stilb_bake_probes *probes);

/* The radiance around a place on something that has the unit normal there: of the eight probes about it, each by how
 * near it is, whether it is in front, and whether it sees the place. Beyond the grid that of its border; if all eight
 * are dead 0. */
shade_sh_rgb stilb_bake_probes_at(const stilb_bake_probes *probes, const float position[3], const float normal[3]);

/* The same of the eight probes by nearness alone: to compare with. */
shade_sh_rgb stilb_bake_probes_at_plain(const stilb_bake_probes *probes, const float position[3]);

#endif
