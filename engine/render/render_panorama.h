/*
 * render_panorama: what frames need of a panorama, made on the pool when another one is shown: its small bright lamps
 * as distant lights, the irradiance of the rest by normal, and its texels for the background. Turning it makes nothing
 * anew. Not for other modules.
 *
 * Cells.     The panorama's light, L dw, in 512 x 256 cells of equal angles; a texel counts for each cell by the share
 *            of its solid angle that lies in it.
 * Lamps.     Light of at least 1 / 200 of all that comes from within 1.2 degrees, with little around it (a sun, a bulb,
 *            not a part of a window), is a distant rectangle with the same mean direction and the same spread along its
 *            two axes: surfaces are lit by shade_distant_share, without interpolation, and the surface's formula shapes
 *            its highlight. Of more than eight the brightest are. Their cells are left out of the table.
 * Table.     [129][256] irradiance by the normal, in the panorama's latitude and longitude, poles and the middle column
 *            included, interpolated between four. The light of a cell is spread evenly over its width; a row of cells
 *            shines from the row's mean sine and cosine, so that rows which the horizon does not cut are exact.
 *            Programs with highlights read it as an image, others by its address.
 * Ambient.   What approximations of the rest take (stilb_render_ambient): the mean radiance above and below the
 *            horizon, and nine spherical harmonics, a cell's light as if it shone from the cell's middle (off by 1e-5).
 *            Where their irradiance is negative in one of 2,048 directions they are blurred just enough
 *            (shade_sh_window); highlights have them blurred further, until radiance is nowhere negative, too.
 * Texels.    Three half floats, each the mean of what it covers where there are more than 2048 x 1024; values above
 *            65504 are that.
 * Gloss.     A cube for highlights (numeric_prefilter.h), made of the cells: like the table it lacks the lamps, whose
 *            highlights the surface's formula shapes, so that nothing counts twice. Its first mip has the cells'
 *            resolution, 0.7 degrees. Beside it the table by n.v and roughness (numeric_dfg.h), which is of no panorama
 *            and is made once.
 * Disk.      Cube and table are kept by a hash of the cells (stilb/panoramas of base_cache.h, 64 MiB, 1 MiB each), with
 *            a checksum, and are the bits that are made. STILB_CACHE=off in the environment: they are not.
 * Slices.    The work is cut into rows of stages. It may be done at once, or a slice of some milliseconds a frame,
 *            while what was made before stays in use. Neither that nor the workers change a bit of the result.
 * Cost.      Of the time and the memory, and how far the light is from the exact one: docs/rendering.md.
 */
#ifndef STILB_RENDER_PANORAMA_H
#define STILB_RENDER_PANORAMA_H

#include "image/image.h"
#include "jobs/job.h"
#include "shading/shade_sh.h"

#include <math.h>

#define RENDER_PANORAMA_LAMPS 8
#define RENDER_PANORAMA_COLUMNS 256 /* of the table; shaders/mesh.frag has both, too */
#define RENDER_PANORAMA_ROWS 129
#define RENDER_PANORAMA_WIDTH 2048u /* of the texels at most */
#define RENDER_PANORAMA_HEIGHT 1024u
#define RENDER_PANORAMA_FACE 128u    /* texels of a side of the cube's first mip */
#define RENDER_PANORAMA_MIPS 6u      /* shaders/lit.glsl has both, too */
#define RENDER_PANORAMA_CUBE 131040u /* texels of all its mips: 6 (128^2 + 64^2 + ... + 4^2) */
#define RENDER_PANORAMA_DFG 64u      /* texels of a side of the table of gloss */

/* A distant rectangle, in the panorama's own axes: unit direction to its middle, irradiance across its beam, and from
 * its middle to those of two sides, radians (shade_distant_share). */
typedef struct render_panorama_lamp {
	float direction[3], irradiance[3], half_x[3], half_y[3];
} render_panorama_lamp;

/* W m^-2; the fourth is 0. */
typedef float render_panorama_table[RENDER_PANORAMA_ROWS][RENDER_PANORAMA_COLUMNS][4];

/* What is made for devices: the table, then the texels. */
#define RENDER_PANORAMA_BYTES(width, height)                                                                           \
	(sizeof(render_panorama_table) + (size_t)(width) * (height) * sizeof(uint16_t[4]))

/* What devices are sent as images. */
typedef struct render_panorama_gloss {
	const uint16_t (*cube)[4];                     /* [CUBE] half floats in the order of numeric_prefilter.h */
	const uint16_t (*dfg)[RENDER_PANORAMA_DFG][2]; /* [DFG] half floats; NULL: it was shown before */
	const render_panorama_table *light;            /* the table */
	const uint16_t (*texels)[4];                   /* [height][width] half floats of which the fourth is 0 */
	uint32_t width, height;
} render_panorama_gloss;

/* Radiance without the lamps, in the panorama's own axes. */
typedef struct render_panorama_around {
	float sky[3], ground[3]; /* its halves' means */
	shade_sh_rgb harmonics;  /* blurred until irradiance is not negative */
	float mirrored[3];       /* what is left of their bands when radiance is not */
} render_panorama_around;

typedef struct render_panorama_work render_panorama_work; /* of one that is being made */

typedef struct render_panorama {
	uint64_t key;       /* of the panorama that this was made of: its size and some of its values; 0: none */
	const void *pixels; /* where it lay; NULL: it is made anew, but in use until then */
	uint32_t lamp_count;
	render_panorama_lamp lamps[RENDER_PANORAMA_LAMPS];
	render_panorama_around around;
	uint32_t width, height;                  /* of the texels */
	uint16_t (*dfg)[RENDER_PANORAMA_DFG][2]; /* [DFG] the table of gloss; NULL: none so far */
	bool dfg_shown;
	render_panorama_work *next; /* NULL: none is being made */
} render_panorama;

/* Where the bytes that devices read are made. make: memory of this size for the next panorama, aligned to 16; NULL:
 * there is none; the one before stays. show: the next panorama is
 * complete and takes the place of the one before, with this gloss, which is valid during the call; on failure, which
 * stilb_render_replay returns, none does. */
typedef struct render_panorama_memory {
	void *(*make)(void *user, size_t bytes);
	stilb_result (*show)(void *user, const render_panorama_gloss *gloss);
	void *user;
} render_panorama_memory;

/* True if frames can draw it: three channels or more of floats. {0}: false. */
bool render_panorama_is_good(const stilb_image *panorama);

/* A number of its size and 251 of its texels. Not 0. */
uint64_t render_panorama_key(const stilb_image *panorama);

/* Makes *out of a panorama that is good, unless it was made of the same one: all of it, or if sliced what a frame has
 * time for: call it again in the next one. It reads the panorama during calls alone, and begins anew with another one.
 * pool may be NULL, but is the same until it is made. STILB_ERROR_MEMORY, and what show gives: *out has key 0.
 * [main-thread] */
stilb_result render_panorama_update(render_panorama *out, const stilb_image *panorama, render_panorama_memory memory,
                                    bool sliced, stilb_job_pool *pool, uint32_t worker);

/* Another scene is shown, whose panorama may lie where this one's does: it is made anew, and in use until then.
 * [main-thread] */
void render_panorama_renew(render_panorama *panorama);

/* A frame shows none: what is being made is given up, and so is what was to be made anew. [main-thread] */
void render_panorama_leave(render_panorama *panorama);

/* True while frames show this panorama, or what was before it. */
bool render_panorama_shows(const render_panorama *panorama, const stilb_image *map);

/* A direction of the panorama's own axes in the world, turned by rotation (stilb_scene_surroundings). */
static inline void render_panorama_turn(const float own[3], float rotation, float world[3])
{
	float s = sinf(rotation), c = cosf(rotation), x = own[0], z = own[2];
	world[0] = c * x + s * z;
	world[1] = own[1];
	world[2] = c * z - s * x;
}

/* Frees what belongs to it and leaves {0}. */
void render_panorama_finish(render_panorama *panorama);

#endif
