/*
 * gi_run: shared by the files of the program of the suite `gi`, which measures the offline renderer (engine/gi). The
 * things that a case compares take turns in one process, on the same scene and the same rays, so that disturbances of
 * the machine cancel in ratios. The cases are in gi_cases.h. Errors end the program. [main-thread]
 */
#ifndef GI_RUN_H
#define GI_RUN_H

#include "bench/harness/bench_child.h"
#include "gi/gi_render.h"
#include "scene/scene.h"

/* Ends the program with the error's message unless the result is STILB_OK; what: the action, for the message. */
void gi_run_check(stilb_result result, const char *what);

/* ---- scenes ------------------------------------------------------------------------------------------------------ */

/* Creates a closed box of 20 m with 27 bumpy balls and an emitting ceiling: 108 rings^2 + 12 triangles. */
stilb_scene *gi_run_balls(uint32_t rings);
stilb_scene *gi_run_million(void); /* 1,037,244 triangles */

/* A scene with the threads that trace it. */
typedef struct gi_run_world {
	stilb_job_pool *pool;
	stilb_scene *scene;
	stilb_gi_scene *gi;
} gi_run_world;

/* Takes ownership of the scene. workers: threads besides the caller. */
gi_run_world gi_run_world_make(stilb_scene *scene, uint32_t workers);
void gi_run_world_finish(gi_run_world *world);

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

#define GI_RUN_SIDE 256u /* width and height of the Cornell box's pictures */

/* Linear Rec.709, three floats for each pixel, row 0 at the top. */
typedef struct gi_run_picture {
	float *rgb;
	double seconds, cpu_seconds, thread_seconds; /* CPU time of all threads, and of the caller */
	uint64_t rays, records;
} gi_run_picture;

typedef struct gi_run_clock {
	double seconds, cpu_seconds; /* cpu_seconds: of this process; stilb-bench limits it, so it is counted in ticks */
	double thread_seconds;       /* CPU time of this thread, to the nanosecond */
} gi_run_clock;
gi_run_clock gi_run_now(void);

/* Renders a picture and times it, without building the scene. */
gi_run_picture gi_run_render(const gi_run_world *world, const stilb_gi_settings *settings);
void gi_run_picture_finish(gi_run_picture *picture);

/* Settings of the Cornell box: GI_RUN_SIDE x GI_RUN_SIDE pixels, at most 64 bounces. */
stilb_gi_settings gi_run_cornell(const stilb_scene *scene);

/* The picture with which others are compared: the mean of two independent renderings, with its error as estimated from
 * their difference; with all light, and with indirect light only. */
typedef struct gi_run_reference {
	float *all, *indirect;
	double all_noise, indirect_noise; /* mean square error of `all` and `indirect` */
	bool *left_out;                   /* pixels within 2 pixels of the visible light (radiance above 4) */
} gi_run_reference;

/* Write the reference into a file, in the case `reference`, and read it, in the other cases. samples: paths for each
 * pixel. */
void gi_run_reference_write(const char *path, uint32_t samples);
gi_run_reference gi_run_reference_read(const char *path);

/* square: mean square difference of a picture and the reference, minus the reference's own mean square error; bias:
 * difference of their means in percent. */
typedef struct gi_run_error {
	double square, bias;
} gi_run_error;
gi_run_error gi_run_compare(const gi_run_reference *reference, const float *rgb, bool indirect);

/* Marks the pixels within 2 pixels of a radiance above 4 (a visible light) in a picture of side x side pixels. */
void gi_run_leave_out(bool *left_out, const float *rgb, uint32_t side);

/* ---- the plain path tracer --------------------------------------------------------------------------------------- */

/*
 * What a few pages of C do on Embree: one path at a time, Owen-scrambled Sobol points, one light asked at every hit,
 * power heuristic, Russian roulette from the third bounce. Only for what the rows have: diffuse surfaces and GGX
 * highlights of constants, cut-out textures, emitting triangles, points, one sun, two colours or a panorama around.
 * The scene must outlive it. Embree builds the tree with its own threads.
 */
typedef struct gi_plain gi_plain;
gi_plain *gi_plain_make(const stilb_scene *scene);
void gi_plain_finish(gi_plain *plain);
gi_run_picture gi_plain_render(const gi_plain *plain, const stilb_gi_settings *settings, uint32_t threads);

/* The first of count > 0 ascending sums that is above u; the last, if none is. */
static inline uint32_t gi_run_find(const float *sums, uint32_t count, float u)
{
	uint32_t low = 0, high = count - 1;
	while (low < high) {
		uint32_t middle = (low + high) / 2;
		if (sums[middle] > u)
			high = middle;
		else
			low = middle + 1;
	}
	return low;
}

/* ---- the cases --------------------------------------------------------------------------------------------------- */

/* The scene of a row, by the case's name; of "million", gi_run_million. */
stilb_scene *gi_run_row_scene(const char *name);
void gi_run_row(const bench_child *child);

/* row: whose scene. */
void gi_run_denoise(const bench_child *child, const char *row);

void gi_run_choice(const bench_child *child);

void gi_run_build(const bench_child *child);

void gi_run_move(const bench_child *child);

#define GI_RUN_RAYS "rays-" /* how the names of cases begin that gi_run_rays runs; a row's name or "million" follows */
void gi_run_rays(const bench_child *child);

#endif
