/*
 * gi_render: pictures of a scene, by rays.
 *
 * Life cycle.  stilb_gi_render_create -> stilb_gi_render_run (may be asked to stop; run again goes on) -> the film is read
 *              (stilb_gi_render_film) or saved (stilb_gi_render_save) -> stilb_gi_render_destroy.
 * The same bits.  A sample depends on its pixel, its number and the settings, and a pixel adds its samples in order: so the
 *              picture does not depend on workers, tiles, passes, or on stopping and going on. Exceptions say so.
 * Threads.     create, run, save, destroy: [main-thread] of the pool. stop and progress: [any-thread], stop from a signal
 *              handler too.
 * Units.       Radiance in W sr^-1 m^-2, linear Rec.709; metres; radians.
 */
#ifndef STILB_GI_RENDER_H
#define STILB_GI_RENDER_H

#include "gi/gi_scene.h"
#include "shading/shade_brdf.h"

/* X(ENUM, identifier, what it shows) */
#define STILB_GI_INTEGRATORS(X)                                                                                        \
	X(COLOR, color, "the surface's colour, no light")                                                                  \
	X(DIRECT, direct, "light straight from the lights, with shadows")                                                  \
	X(AO, ao, "ambient occlusion: how much of the hemisphere is open")                                                 \
	X(MONTECARLO, montecarlo, "N rays at every bounce: exponential cost, the baseline for teaching")                   \
	X(PATH, path, "one path a sample, to any depth: unbiased")                                                         \
	X(SPLIT, split, "N rays at the first hit, one path after each")                                                    \
	X(IRRADIANCE_CACHE, irradiance_cache, "diffuse light interpolated between sparse records: smooth, slightly biased")

/* How random numbers are laid out. */
#define STILB_GI_SAMPLERS(X)                                                                                           \
	X(RANDOM, random, "independent numbers")                                                                           \
	X(STRATIFIED, stratified, "one in each cell of a grid")                                                            \
	X(SOBOL, sobol, "Owen-scrambled Sobol points")                                                                     \
	X(BLUE_NOISE, blue_noise, "Sobol points ordered so that the error between pixels is blue noise")

/* Pixel reconstruction. Radius in pixels: what of a sample's surroundings a pixel sees. */
#define STILB_GI_FILTERS(X)                                                                                            \
	X(BOX, box, "the pixel's square")                                                                                  \
	X(GAUSSIAN, gaussian, "sigma half a pixel, cut at 1.5 pixels")                                                     \
	X(BLACKMAN_HARRIS, blackman_harris, "4-term window of radius 1.5 pixels")

#define STILB_GI_RENDER_ENUM_INTEGRATOR(id, ...) STILB_GI_INTEGRATOR_##id,
#define STILB_GI_RENDER_ENUM_SAMPLER(id, ...) STILB_GI_SAMPLER_##id,
#define STILB_GI_RENDER_ENUM_FILTER(id, ...) STILB_GI_FILTER_##id,
typedef enum stilb_gi_integrator {
	STILB_GI_INTEGRATORS(STILB_GI_RENDER_ENUM_INTEGRATOR) STILB_GI_INTEGRATOR_COUNT
} stilb_gi_integrator;
typedef enum stilb_gi_sampler_kind {
	STILB_GI_SAMPLERS(STILB_GI_RENDER_ENUM_SAMPLER) STILB_GI_SAMPLER_COUNT
} stilb_gi_sampler_kind;
typedef enum stilb_gi_filter_kind {
	STILB_GI_FILTERS(STILB_GI_RENDER_ENUM_FILTER) STILB_GI_FILTER_COUNT
} stilb_gi_filter_kind;
#undef STILB_GI_RENDER_ENUM_INTEGRATOR
#undef STILB_GI_RENDER_ENUM_SAMPLER
#undef STILB_GI_RENDER_ENUM_FILTER

/* Which light is left in. */
typedef enum stilb_gi_only {
	STILB_GI_ALL_LIGHT,
	STILB_GI_ONLY_INDIRECT, /* light that bounced at least once before it reached the surface that is seen */
} stilb_gi_only;

/* The thin lens of `stilb render --aperture R --focus D`. */
typedef struct stilb_gi_lens {
	float radius;    /* of the aperture, metres; 0: a pinhole, everything is sharp */
	float focus;     /* from the camera to the focal plane along the view, metres, > 0 */
	uint32_t blades; /* 0: round; 3..16: a regular polygon inside that circle */
	float rotation;  /* of the polygon */
} stilb_gi_lens;

typedef enum stilb_gi_cache_mode {
	STILB_GI_CACHE_FROZEN, /* made in rounds, then only read: the same bits for every worker count */
	STILB_GI_CACHE_LIVE,   /* records appear as they are needed: faster, other bits every time */
} stilb_gi_cache_mode;

typedef enum stilb_gi_cache_radius {
	STILB_GI_CACHE_SPLIT_SPHERE, /* Ward's harmonic mean distance, bounded by gradients, distances and neighbours */
	STILB_GI_CACHE_HESSIAN,      /* the occlusion Hessian's ellipse */
	STILB_GI_CACHE_HARMONIC,     /* Ward's of 1988: the mean distance as it is */
} stilb_gi_cache_radius;

typedef struct stilb_gi_cache_settings {
	stilb_gi_cache_mode mode;
	stilb_gi_cache_radius radius;
	float error;             /* Ward's a, (0, 1]: larger is coarser */
	uint32_t rays;           /* gathered a record */
	bool gradients;          /* rotational and translational */
	bool overture;           /* fill the cache before the picture; off (LIVE only): the article's blocks */
	bool show_records;       /* draw where the records lie */
	const char *load, *save; /* files, or NULL */
} stilb_gi_cache_settings;

#define STILB_GI_MAX_PIXELS (1u << 26) /* 8192 x 8192: 168 bytes each while it is rendered */

typedef struct stilb_gi_settings {
	stilb_gi_integrator integrator;
	uint32_t width, height; /* 1..65536 each, and at most STILB_GI_MAX_PIXELS */
	uint32_t samples;       /* a pixel, 1..65536; with a limit below: the most */
	double seconds;         /* end after this long; 0: no limit */
	float error;            /* end where the estimated relative RMSE of the picture is below; 0: no limit */
	uint64_t seed;
	stilb_gi_sampler_kind sampler;
	stilb_gi_filter_kind filter;
	stilb_scene_camera camera;
	stilb_gi_lens lens;
	uint32_t depth;         /* reflections at most, 0..1024; 0: lights alone, 1: and direct light */
	shade_brdf_model model; /* of the highlights: diffuse light is Lambert's */
	stilb_gi_only only;
	bool firefly_weight; /* Karis's: biased */
	float roulette;      /* survival probability from the third bounce, (0, 1]; 0: from the path's throughput */
	uint32_t rays;       /* N of ao, montecarlo and split: at a hit */
	float ao_distance;   /* metres: what lies farther does not occlude; 0: no end */
	bool ao_weighted;    /* a near hit occludes more than a far one: 1 - d / ao_distance */
	bool progressive;    /* first every 32nd pixel of every 32nd row, then every 16th, ...; off: tile by tile */
	float exposure;      /* of .png alone: the picture is brighter by so many times two */
	stilb_gi_cache_settings cache;
} stilb_gi_settings;

/* path, 64 samples of 512 x 512, sobol, box, depth 64, GGX; the scene's camera. */
stilb_gi_settings stilb_gi_settings_default(const stilb_scene *scene);

/* Rays that MONTECARLO traces for these settings, where every ray hits something and shadow rays are left out: pixels x
 * samples x (1 + N + N^2 + ... + N^depth). Exact below 2^53; +infinity when beyond all numbers. [any-thread] */
double stilb_gi_montecarlo_rays(const stilb_gi_settings *settings);

typedef struct stilb_gi_render stilb_gi_render;

/* scene must outlive it. STILB_ERROR_ARGUMENT names the setting that is out of its range; STILB_ERROR_FILE: the irradiance
 * cache that is to be loaded is none, or another one; STILB_ERROR_MEMORY. */
stilb_result stilb_gi_render_create(const stilb_gi_scene *scene, const stilb_gi_settings *settings,
                                    stilb_job_pool *pool, stilb_gi_render **out);
void stilb_gi_render_destroy(stilb_gi_render *render);

/* Renders until the picture is finished, a limit is reached, or stop is asked for; what is left undone the next call does.
 * The calling thread takes part. STILB_OK also when stopped: progress.end says why it ended. STILB_ERROR_FILE: the irradiance
 * cache could not be saved, but the picture is finished; STILB_ERROR_MEMORY. */
stilb_result stilb_gi_render_run(stilb_gi_render *render);

/* Makes run return within some milliseconds; asked for between two calls, the next returns at once. [any-thread], and from
 * signal handlers. */
void stilb_gi_render_stop(stilb_gi_render *render);

/* Why run returned. */
typedef enum stilb_gi_end {
	STILB_GI_END_NOT, /* it has not, or never ran */
	STILB_GI_END_SAMPLES,
	STILB_GI_END_SECONDS,
	STILB_GI_END_ERROR, /* the estimate is below settings.error */
	STILB_GI_END_STOPPED,
} stilb_gi_end;

/* All pixels that lie on every block-th column and row, and not on those of the pass before, from first_sample on. */
typedef struct stilb_gi_pass {
	uint32_t block, first_sample, sample_count;
	double seconds;
	bool finished;
} stilb_gi_pass;

#define STILB_GI_MAX_PASSES 64

typedef struct stilb_gi_progress {
	double seconds; /* in run so far, over all calls */
	double done;    /* share of the work, [0, 1] */
	uint64_t rays;  /* traced, all kinds; and of these: */
	uint64_t camera_rays, shadow_rays;
	uint32_t samples; /* every pixel has at least so many */
	uint32_t block;   /* progressive: every block of so many pixels has one; 1 when done */
	char stage[32];   /* "overture 3", "pass 2", ... */
	bool finished;    /* nothing is left to do: see end */
	stilb_gi_end end;
	uint32_t records;     /* in the irradiance cache */
	double error;         /* of the last whole pass, as settings.error has it; 0: not known */
	uint64_t bad_samples; /* that were no number: they count as black */
	uint32_t pass_count;
	stilb_gi_pass passes[STILB_GI_MAX_PASSES]; /* those begun, in order */
} stilb_gi_progress;

/* [any-thread] */
void stilb_gi_render_progress(stilb_gi_render *render, stilb_gi_progress *progress);

/* A copy of what there is now, for a window: 3 floats a pixel, row 0 on top; blocks are filled with their one pixel.
 * [any-thread], while run runs too: pixels of tiles in work may be old ones. */
void stilb_gi_render_preview(const stilb_gi_render *render, float *rgb);

/* What .png holds: exposure, tone map (shade_tonemap.h), sRGB; 3 numbers a pixel. [any-thread] */
void stilb_gi_display(const float *rgb, size_t pixels, float exposure, uint8_t *srgb);

/* The picture and what belongs to it. Sizes are width x height; valid until destroy, to be read while run does not run. */
typedef struct stilb_gi_film {
	uint32_t width, height;
	const float *radiance; /* [3] mean of the samples */
	const float *albedo;   /* [3] diffuse + specular reflectance of the first hit, mean */
	const float *normal;   /* [3] shading normal of the first hit, world, mean; 0 for a miss */
	const float *depth;    /* distance along the view to the first hit, mean over those that hit; +infinity: none */
	const float *variance; /* [3] of the mean: the square of its standard error, as if samples were independent of one
	                        * another, so above the truth where the sampler spreads them; 0 below 2 samples */
	const uint32_t *samples;
} stilb_gi_film;
stilb_gi_film stilb_gi_render_film(const stilb_gi_render *render);

/* .exr: R G B, albedo.*, normal.*, depth.Z, samples, variance.*, with the settings as attributes; .hdr: R G B; .png: the
 * picture through the tone map and sRGB. Whole or not at all. [main-thread] */
stilb_result stilb_gi_render_save(const stilb_gi_render *render, const char *path);

/* What is there, so that another process can go on: the same settings, scene and binary give the same bits as one that was
 * never stopped. checkpoint writes whole or not at all, while run does not run. resume, before the first run, refuses
 * (STILB_ERROR_FILE) what is damaged or belongs to another scene or other settings, and names the first that differs; the
 * limits, progressive and exposure may be others, and with them samples, but for STRATIFIED and BLUE_NOISE, whose samples
 * depend on how many there will be. */
stilb_result stilb_gi_render_checkpoint(const stilb_gi_render *render, const char *path);
stilb_result stilb_gi_render_resume(stilb_gi_render *render, const char *path);

#endif
