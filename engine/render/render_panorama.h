/*
 * render_panorama: what frames need of a panorama, made once on the pool when another one is shown: its small bright
 * lamps as directional lights, the irradiance of the rest by normal, and its texels for the background. Turning it
 * makes nothing anew. Not for other modules.
 *
 * Cells.     The panorama is read as 64 x 32 cells of equal angles; each keeps the sum of its texels' L dw (irradiance
 *            across their beam) and the mean of their directions, weighted by brightness. A cell that is wholly above a
 *            surface's horizon gives it exactly the product of both.
 * Lamps.     A cell whose light comes from one place (a sun) and is at least 1 / 200 of all is a directional light,
 *            which frames compute without interpolation, and whose highlight the surface's formula shapes; of more than
 *            eight the brightest are. Its cell is left out of the table.
 * Table.     [65][128] irradiance by the normal, in the panorama's latitude and longitude, poles and the middle column
 *            included, interpolated between four. Where the horizon cuts a cell, its light is taken as spread over the
 *            cell's width.
 * Texels.    Three half floats, each the mean of what it covers where there are more than 2048 x 1024; values above
 *            65504 are that.
 * Cost.      Of the time and the memory, and how far the light is from the exact one: docs/rendering.md.
 */
#ifndef STILB_RENDER_PANORAMA_H
#define STILB_RENDER_PANORAMA_H

#include "image/image.h"
#include "jobs/job.h"

#define RENDER_PANORAMA_LAMPS 8
#define RENDER_PANORAMA_COLUMNS 128 /* of the table; shaders/mesh.frag has both, too */
#define RENDER_PANORAMA_ROWS 65
#define RENDER_PANORAMA_WIDTH 2048u /* of the texels at most */
#define RENDER_PANORAMA_HEIGHT 1024u

/* A directional light: unit direction to it in the panorama's own axes, irradiance across its beam. */
typedef struct render_panorama_lamp {
	float direction[3], irradiance[3];
} render_panorama_lamp;

typedef struct render_panorama {
	uint64_t key;       /* of the panorama that this was made of: its size and some of its values; 0: none */
	const void *pixels; /* where it lay */
	uint32_t version;   /* counts what was made, for devices that keep a copy */
	uint32_t lamp_count;
	render_panorama_lamp lamps[RENDER_PANORAMA_LAMPS];
	float table[RENDER_PANORAMA_ROWS][RENDER_PANORAMA_COLUMNS][4]; /* W m^-2; the fourth is 0 */
	uint32_t width, height;
	uint16_t (*texels)[4]; /* [height][width] half floats; the fourth is 0 */
} render_panorama;

/* True if frames can draw it: three channels or more of floats. {0}: false. */
bool render_panorama_is_good(const stilb_image *panorama);

/* A number of its size and 251 of its texels. Not 0. */
uint64_t render_panorama_key(const stilb_image *panorama);

/* Makes *out of a panorama that is good, unless it was made of the same one. Same bits for any number of workers. pool
 * may be NULL. STILB_ERROR_MEMORY: *out has key 0. [main-thread] */
stilb_result render_panorama_update(render_panorama *out, const stilb_image *panorama, stilb_job_pool *pool,
                                    uint32_t worker);

/* A direction of the panorama's own axes in the world, turned by rotation (stilb_scene_surroundings). */
void render_panorama_turn(const float own[3], float rotation, float world[3]);

/* Frees what belongs to it and leaves {0}. */
void render_panorama_finish(render_panorama *panorama);

#endif
