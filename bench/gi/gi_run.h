/*
 * gi_run: the program of the suite `gi`. What is compared takes turns in one process, on the same scene and the same
 * rays, so that ratios do not see the machine's moods; what a case is stands in gi_cases.h.
 */
#ifndef GI_RUN_H
#define GI_RUN_H

#include "bench/harness/bench_child.h"
#include "gi/gi_render.h"
#include "scene/scene.h"

/* Prints why and ends the program. */
void gi_run_check(stilb_result result, const char *what);

/* ---- scenes ------------------------------------------------------------------------------------------------------ */

/* A closed box of 20 m with 27 bumpy balls in it and a ceiling that glows: 1,037,244 triangles. */
stilb_scene *gi_run_million(void);

/* A scene and the threads to trace it: workers beside this one. */
typedef struct gi_run_world {
	stilb_job_pool *pool;
	stilb_scene *scene;
	stilb_gi_scene *gi;
} gi_run_world;

/* Takes the scene. */
gi_run_world gi_run_world_make(stilb_scene *scene, uint32_t workers);
void gi_run_world_finish(gi_run_world *world);

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

#define GI_RUN_SIDE 256u /* of the Cornell box's pictures */

/* Linear Rec.709, three floats a pixel, row 0 on top. */
typedef struct gi_run_picture {
	float *rgb;
	double seconds;
	uint64_t rays, records;
} gi_run_picture;

/* Renders and times it, the making of the scene not included. */
gi_run_picture gi_run_render(const gi_run_world *world, const stilb_gi_settings *settings);
void gi_run_picture_finish(gi_run_picture *picture);

/* Settings of the Cornell box: 256 x 256, at most 64 bounces. */
stilb_gi_settings gi_run_cornell(const stilb_scene *scene);

/* Means of two independent renderings, with what they say about their own error. */
typedef struct gi_run_reference {
	float *all, *indirect;
	double all_noise, indirect_noise; /* mean square error of each */
	bool *left_out;                   /* pixels within 2 of the visible light: radiance above 4 */
} gi_run_reference;

/* Written by the case `reference`, read by the others. */
void gi_run_reference_write(const char *path, uint32_t samples);
gi_run_reference gi_run_reference_read(const char *path);

/* Mean square error of rgb, the reference's own taken off, and how far its mean is from the reference's, in percent. */
typedef struct gi_run_error {
	double square, bias;
} gi_run_error;
gi_run_error gi_run_compare(const gi_run_reference *reference, const float *rgb, bool indirect);

/* ---- the baseline ------------------------------------------------------------------------------------------------ */

/*
 * A path tracer as one writes it in an afternoon: one path after the other, PCG32 numbers, one light sample at every
 * hit, power heuristic, Russian roulette from the third bounce. For triangles of diffuse materials and emitting
 * triangles alone, on Embree's own threads and build.
 */
typedef struct gi_plain gi_plain;
gi_plain *gi_plain_make(const stilb_scene *scene);
void gi_plain_finish(gi_plain *plain);
gi_run_picture gi_plain_render(const gi_plain *plain, const stilb_gi_settings *settings, uint32_t threads);

/* ---- the cases --------------------------------------------------------------------------------------------------- */

void gi_run_build(const bench_child *child);
void gi_run_primary(const bench_child *child);
void gi_run_path(const bench_child *child);

#endif
