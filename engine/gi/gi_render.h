/*
 * gi_render: pictures of a scene by ray tracing.
 *
 * Life cycle.  stilb_gi_render_create -> stilb_gi_render_run, which renders until the picture is finished or somebody
 *              calls stilb_gi_render_stop; called again it continues -> the film is read (stilb_gi_render_film) or
 *              written to a file (stilb_gi_render_save) -> stilb_gi_render_destroy.
 *
 *   stilb_gi_settings settings = stilb_gi_settings_default(scene);
 *   settings.samples = 256;
 *   stilb_gi_render *render;
 *   if (stilb_gi_render_create(gi_scene, &settings, pool, &render) == STILB_OK &&
 *       stilb_gi_render_run(render) == STILB_OK)
 *       stilb_gi_render_save(render, "picture.exr");
 *   stilb_gi_render_destroy(render);
 *
 * Same bits.   A sample depends on its pixel, its number and the settings alone, and a pixel adds its samples in the
 *              order of their numbers. So the picture does not depend on the number of workers, on tiles or passes, or
 *              on being stopped and continued. Settings for which this does not hold say so.
 * Threads.     create, run, film, save, checkpoint, resume, destroy: [main-thread], the one thread that created the
 *              render, which must be the pool's main thread unless stilb_gi_render_share says otherwise. stop, progress
 *              and preview: [any-thread], also while run runs.
 * Units.       Radiance in W sr^-1 m^-2, linear Rec.709; metres; radians; seconds.
 * Errors.      A stilb_result, with a line for the user in stilb_error_message.
 */
#ifndef STILB_GI_RENDER_H
#define STILB_GI_RENDER_H

#include "gi/gi_scene.h"
#include "scene/scene_channel.h"
#include "shading/shade_model.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* ---- settings ---------------------------------------------------------------------------------------------------- */

/* The integrators: how a camera ray becomes radiance. X(ENUM, identifier, description for users)
 *
 * COLOR             diffuse + specular reflectance of the first hit, without light or shadow; black for a miss.
 * DIRECT            emission and light reflected once, by multiple importance sampling of one light and, where the
 *                   surface is glossy, one reflected ray (Veach 1997, chapter 9).
 * AO                ambient occlusion: share of cosine-weighted rays from the first hit that meet nothing within
 *                   ao_distance.
 * MONTECARLO        Kajiya's rendering equation by recursion: `rays` rays at every hit, depth levels deep. Lights are
 *                   met by chance alone, except those without a size, which no ray can meet: these are sampled.
 * PATH              Kajiya's path tracing (1986) with a light sampled at every vertex (Veach 1997) and Russian roulette
 *                   (Arvo and Kirk 1990). Unbiased.
 * SPLIT             PATH with `rays` paths from the first hit of every sample: less noise for the same number of camera
 *                   rays.
 * IRRADIANCE_CACHE  diffuse indirect light from records (Ward 1988, and cache/gi_cache.h), direct light and highlights
 *                   as PATH. Smooth after few samples; slightly biased.
 * CHANNEL           settings.channel of the first hit, as it is: scene_channel.h; 0 for a miss. */
#define STILB_GI_INTEGRATORS(X)                                                                                        \
	X(COLOR, color, "the surface's colour, no light")                                                                  \
	X(DIRECT, direct, "light straight from the lights, with shadows")                                                  \
	X(AO, ao, "ambient occlusion: how much of the hemisphere is open")                                                 \
	X(MONTECARLO, montecarlo, "N rays at every bounce: exponential cost, the baseline for teaching")                   \
	X(PATH, path, "one path a sample, to any depth: unbiased")                                                         \
	X(SPLIT, split, "N rays at the first hit, one path after each")                                                    \
	X(IRRADIANCE_CACHE, irradiance_cache,                                                                              \
	  "diffuse light interpolated between sparse records: smooth, slightly biased")                                    \
	X(CHANNEL, channel, "what --show names of the surface, no light")

/* Samplers: how the random numbers of a pixel's samples are spread. X(ENUM, identifier, description for users)
 *
 * RANDOM      independent numbers: the error falls with the square root of the samples.
 * STRATIFIED  correlated multi-jittered cells (Kensler 2013): one point in each cell of a grid that has as many cells
 *             as samples are planned.
 * SOBOL       Sobol's sequence, Owen-scrambled for each pixel (Burley 2020): any number of samples is well spread.
 * BLUE_NOISE  the same points dealt to pixels in a hierarchical order (Ahmed and Wonka 2020): at few samples the error
 *             looks like fine grain. Made for the planned number of samples. */
#define STILB_GI_SAMPLERS(X)                                                                                           \
	X(RANDOM, random, "independent numbers")                                                                           \
	X(STRATIFIED, stratified, "one in each cell of a grid")                                                            \
	X(SOBOL, sobol, "Owen-scrambled Sobol points")                                                                     \
	X(BLUE_NOISE, blue_noise, "Sobol points ordered so that the error between pixels is blue noise")

/* Reconstruction filters: how samples around a pixel's centre are weighted. X(ENUM, identifier, description for users)
 *
 * Samples are placed with the density of the filter and all weigh the same (Ernst, Stamminger, Greiner 2006), so a
 * pixel needs no samples of its neighbours and tiles are independent. The window is Harris's (1978). */
#define STILB_GI_FILTERS(X)                                                                                            \
	X(BOX, box, "the pixel's square")                                                                                  \
	X(GAUSSIAN, gaussian, "sigma half a pixel, cut at 1.5 pixels")                                                     \
	X(BLACKMAN_HARRIS, blackman_harris, "4-term window of radius 1.5 pixels")

/* STILB_GI_INTEGRATOR_COLOR, ..., STILB_GI_SAMPLER_RANDOM, ..., STILB_GI_FILTER_BOX, ...: from the lists above. */
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

/* Which part of the light the picture shows. */
typedef enum stilb_gi_only {
	STILB_GI_ALL_LIGHT,
	/* Light that was reflected at least once before it reached the surface that is seen. */
	STILB_GI_ONLY_INDIRECT,
} stilb_gi_only;

/* A thin lens: points off the focal plane are blurred. */
typedef struct stilb_gi_lens {
	/* Radius of the aperture, metres, 0..1e12. 0: a pinhole, everything is sharp. */
	float radius;
	/* Distance of the focal plane from the camera along the view axis, metres, 1e-9..1e12. */
	float focus;
	/* 0: a round aperture; 3..16: a regular polygon with that many corners on the circle. */
	uint32_t blades;
	/* Rotation of the polygon about the view axis, radians, -1e6..1e6. */
	float rotation;
} stilb_gi_lens;

/* When records of the irradiance cache are made. */
typedef enum stilb_gi_cache_mode {
	/* Records are made in rounds before the picture (the overture) and only read after that: the picture has the same
	 * bits for any number of workers. */
	STILB_GI_CACHE_FROZEN,
	/* A record is made whenever a sample finds no valid one. This is faster, but the picture's bits depend on timing
	 * and differ from run to run. */
	STILB_GI_CACHE_LIVE,
} stilb_gi_cache_mode;

/* Rules for the radius in which a record of the irradiance cache is valid. Sources: cache/gi_cache.h. */
typedef enum stilb_gi_cache_radius {
	/* Harmonic mean distance to the surfaces that the record sees, bounded by the irradiance's gradient and by the
	 * radii of records nearby. */
	STILB_GI_CACHE_SPLIT_SPHERE,
	/* An ellipse in which the second derivative of irradiance keeps the error below a tolerance. */
	STILB_GI_CACHE_HESSIAN,
	/* Harmonic mean distance without bounds, as in Ward's first paper (1988). */
	STILB_GI_CACHE_HARMONIC,
} stilb_gi_cache_radius;

/* Settings of the integrator IRRADIANCE_CACHE; others ignore them. */
typedef struct stilb_gi_cache_settings {
	stilb_gi_cache_mode mode;
	stilb_gi_cache_radius radius;
	/* The parameter a of Ward (1988), 1e-4..1: the relative error that a record may have; larger is coarser and
	 * faster. */
	float error;
	/* Rays that gather one record, 16..65536. */
	uint32_t rays;
	/* Interpolate with the rotational and translational gradients of the records. */
	bool gradients;
	/* Fill the cache before the picture. It may be off only with mode LIVE or with a file to load: a FROZEN cache would
	 * stay empty. */
	bool overture;
	/* Draw a dot where each record lies. */
	bool show_records;
	/* Files of records: one to load before the render, one to write at its end; NULL: none. The strings must outlive
	 * the render. */
	const char *load, *save;
} stilb_gi_cache_settings;

/* Largest width x height: 8192 x 8192. A render takes 168 bytes a pixel. */
#define STILB_GI_MAX_PIXELS (1u << 26)

typedef struct stilb_gi_settings {
	stilb_gi_integrator integrator;
	/* Of the integrator CHANNEL: one that rays have, below STILB_SCENE_CHANNELS_OF_RAYS. A .png and the preview then
	 * show values as scene_channel.h says; exposure and tone are not read. */
	stilb_scene_surface_channel channel;
	/* Pixels, 1..65536 each, and at most STILB_GI_MAX_PIXELS in all. */
	uint32_t width, height;
	/* Samples of each pixel, 1..65536; if seconds or error sets a limit, too, the largest number there will be. */
	uint32_t samples;
	/* Stop after so many seconds in stilb_gi_render_run, over all calls, 0..1e9; 0: no limit. */
	double seconds;
	/* Stop when the estimated relative root-mean-square error of the picture is below, 0..1e9; 0: no limit. */
	float error;
	/* Seed of all random numbers; another one gives another, equally good, picture. */
	uint64_t seed;
	stilb_gi_sampler_kind sampler;
	stilb_gi_filter_kind filter;
	/* Camera rays see what lies between near_z and far_z, as frames do; exposure and tone are the members below. */
	stilb_scene_camera camera;
	stilb_gi_lens lens;
	/* Most reflections of a path, 0..1024. 0: only the lights themselves are seen; 1: also direct light. */
	uint32_t depth;
	/* BRDF of the highlights; diffuse reflection is always Lambert's. */
	shade_brdf_model model;
	stilb_gi_only only;
	/* Nothing hides a light or the surroundings from a surface, and emission is seen by the camera alone: a light with
	 * a face lights as the list says. What frames without shadows show, for comparing them; DIRECT only. */
	bool no_shadows;
	/* Weight bright samples less, 1 / (1 + luminance): no fireflies, but biased. Source: Karis (2013). */
	bool firefly_weight;
	/* Keep what stilb_gi_render_denoise needs, 32 bytes a pixel more, and save the denoised picture. Needs 2 samples a
	 * pixel at least; not with COLOR and CHANNEL, which have no light. */
	bool denoise;
	/* Russian roulette: the probability with which a path goes on at each bounce from the third on, 0..1; 0: chosen
	 * from its throughput (the share of light that it still carries). Unbiased. */
	float roulette;
	/* N of the integrators ao, montecarlo and split: rays at a hit, 1..65536. */
	uint32_t rays;
	/* For ao, metres, 0..1e12: what is farther away does not occlude; 0: everything does. */
	float ao_distance;
	/* For ao: a hit at distance d counts as 1 - d / ao_distance instead of 1; needs ao_distance > 0. */
	bool ao_weighted;
	/* Render every 32nd pixel of every 32nd row first, then every 16th, ...; off: tile by tile. Same bits either
	 * way. */
	bool progressive;
	/* In stops, -100..100: radiance is multiplied by 2^exposure in .png files and where the picture is displayed. */
	float exposure;
	uint32_t tone; /* SHADE_TONE_... of shading/shade_tonemap.h, of .png files and where the picture is displayed */
	stilb_gi_cache_settings cache;
} stilb_gi_settings;

/* Integrator path, 64 samples of 512 x 512 pixels, sampler sobol, filter box, depth 64, model GGX with Smith's G and
 * Schlick's F, the scene's camera, its exposure and its tone map. [any-thread] */
stilb_gi_settings stilb_gi_settings_default(const stilb_scene *scene);

/* Number of rays that MONTECARLO traces with these settings if every ray hits something, shadow rays not counted:
 * pixels x samples x (1 + N + N^2 + ... + N^depth) with N = settings->rays >= 1. Exact below 2^53; +infinity if beyond
 * the range of a double. For a warning before a render that would never end. [any-thread] */
double stilb_gi_montecarlo_rays(const stilb_gi_settings *settings);

/* ---- life cycle -------------------------------------------------------------------------------------------------- */

typedef struct stilb_gi_render stilb_gi_render;

/* A render with no sample yet. scene and pool must outlive it; settings are copied. Reads settings->cache.load.
 * Errors: STILB_ERROR_ARGUMENT names the first setting out of its range, and the range; STILB_ERROR_FILE: the file of
 * the irradiance cache cannot be read, is damaged, or belongs to another scene or other settings; STILB_ERROR_MEMORY.
 * Then *out is NULL. [main-thread] */
stilb_result stilb_gi_render_create(const stilb_gi_scene *scene, const stilb_gi_settings *settings,
                                    stilb_job_pool *pool, stilb_gi_render **out);

/* Frees everything, the film too. Not while run runs. Accepts NULL. [main-thread] */
void stilb_gi_render_destroy(stilb_gi_render *render);

/* Lets run share its pool with others, before the first run; not with the integrator irradiance-cache. caller: 0, or
 * STILB_JOB_OUTSIDE for a thread that is not of the pool; that thread only waits, and the pool, which then has workers,
 * renders. slice, seconds: run's loops on the pool end after so long, and some milliseconds later at most, so that
 * other work of the pool comes in between; 0: they last until their pass over the picture is done. The same bits either
 * way. The thread that created it. */
void stilb_gi_render_share(stilb_gi_render *render, uint32_t caller, double slice);

/* Renders until the picture is finished, a limit is reached, or stop is called; a later call continues. The calling
 * thread works, too. STILB_OK also if stopped: stilb_gi_progress.end says why it returned. Errors: STILB_ERROR_FILE:
 * the irradiance cache could not be saved, but the picture is finished; STILB_ERROR_MEMORY. [main-thread] */
stilb_result stilb_gi_render_run(stilb_gi_render *render);

/* Lets run return as soon as every pixel has so many samples, settings.samples at most, without being finished: the
 * next ones may be of the scene in another pose (stilb_gi_scene_update). Motion blur is a picture of many of them. 0 is
 * settings.samples. Not with the integrator irradiance-cache, nor with a limit of error or seconds; at most 32 times
 * for a render. [main-thread], while run does not run. */
void stilb_gi_render_until(stilb_gi_render *render, uint32_t samples);

/* Makes run return within milliseconds; called between two runs, the next one returns at once. [any-thread], and in
 * signal handlers. */
void stilb_gi_render_stop(stilb_gi_render *render);

/* ---- progress ---------------------------------------------------------------------------------------------------- */

/* Why run returned. */
typedef enum stilb_gi_end {
	STILB_GI_END_NOT,     /* it has not returned: it runs, or was never called; or it failed */
	STILB_GI_END_SAMPLES, /* all settings.samples are done */
	STILB_GI_END_SECONDS, /* settings.seconds are over */
	STILB_GI_END_ERROR,   /* the estimated error is below settings.error */
	STILB_GI_END_STOPPED, /* stilb_gi_render_stop was called */
} stilb_gi_end;

/* One pass over the picture: samples first_sample .. first_sample + sample_count - 1 of the pixels in every block-th
 * column and row that have no such samples yet. block is a power of two, 32 at most. */
typedef struct stilb_gi_pass {
	uint32_t block, first_sample, sample_count;
	double seconds; /* that it has taken so far, over all calls of run */
	bool finished;
} stilb_gi_pass;

/* Passes of one render at most; the last one takes all samples that are left. */
#define STILB_GI_MAX_PASSES 64

typedef struct stilb_gi_progress {
	/* Seconds in stilb_gi_render_run, over all calls, those before a resumed checkpoint included. */
	double seconds;
	/* Share of the work that is done, [0, 1]; an estimate where a limit of time or error may end the render sooner. */
	double done;
	/* Traced rays of all kinds, and how many of these were camera rays and shadow rays. */
	uint64_t rays;
	uint64_t camera_rays, shadow_rays;
	/* Least number of samples that a pixel has by now. */
	uint32_t samples;
	/* Side, pixels, of the squares of which only one pixel has samples so far in a progressive render; 1: all pixels
	 * have samples. */
	uint32_t block;
	/* The current stage, for people: "overture 3", "pass 2", ... */
	char stage[32];
	/* Nothing is left to do; end says why. */
	bool finished;
	stilb_gi_end end;
	/* Records in the irradiance cache. */
	uint32_t records;
	/* Estimated relative error after the last whole pass, as settings.error means it; 0: not known. */
	double error;
	/* Samples whose radiance was NaN or infinite; they count as black. */
	uint64_t bad_samples;
	/* The passes begun so far, in order. */
	uint32_t pass_count;
	stilb_gi_pass passes[STILB_GI_MAX_PASSES];
	/* Share of the pixels of the last of them that have its samples, [0, 1]: an estimate while it runs, by the samples
	 * that are there. */
	double pass_done;
} stilb_gi_progress;

/* Fills progress with the state of the moment; the counts of samples and rays may lack the batches (at most 1024
 * samples) that the threads are working on. [any-thread]
 *
 *   stilb_gi_progress progress;
 *   do {
 *       stilb_gi_render_progress(render, &progress);       another thread is in run meanwhile
 *       printf("%3.0f %% %s\n", 100.0 * progress.done, progress.stage);
 *       sleep(1);
 *   } while (!progress.finished);
 */
void stilb_gi_render_progress(stilb_gi_render *render, stilb_gi_progress *progress);

/* Takes the state of the moment while run runs; false: run returns, as after stilb_gi_render_stop. Called on the thread
 * that called run, which works on nothing else meanwhile, every 50 ms at most; it may read the picture so far
 * (stilb_gi_render_preview), and must not call what is [main-thread]. */
typedef bool stilb_gi_watch_fn(void *user, const stilb_gi_progress *progress);

/* From the next run on, calls fn with user; NULL: nobody watches, as at the start. Where a thread other than the one in
 * run may look, it can as well call stilb_gi_render_progress. [main-thread]
 *
 *   static bool show(void *user, const stilb_gi_progress *progress)
 *   {
 *       window_draw_bar(user, progress->done);
 *       return !window_is_closed(user);
 *   }
 *
 *   stilb_gi_render_watch(render, show, window); */
void stilb_gi_render_watch(stilb_gi_render *render, stilb_gi_watch_fn *fn, void *user);

/* ---- the picture ------------------------------------------------------------------------------------------------- */

/* Copies the picture as far as it is, for a window. rgb: [height][width][3] linear radiance, row 0 at the top; of a
 * channel of data the light whose sRGB code is the value. A pixel without samples shows the nearest coarser pixel that
 * has some. [any-thread], also while run runs: then pixels of
 * tiles in progress may be of different age. */
void stilb_gi_render_preview(const stilb_gi_render *render, float *rgb);

/* Linear radiance to what a .png holds: times 2^exposure, tone mapped by `tone`, SHADE_TONE_... of shade_tonemap.h,
 * sRGB in 8 bits. rgb, srgb: [pixels][3]; NaN and negative radiance become black. [any-thread] */
void stilb_gi_display(const float *rgb, size_t pixels, float exposure, uint32_t tone, uint8_t *srgb);

/* The planes (layers of floats or numbers) of the picture, [height][width], or [height][width][3] for those marked [3],
 * row 0 at the top. Means are over the samples of a pixel. */
typedef struct stilb_gi_film {
	uint32_t width, height;
	/* [3] Mean radiance. */
	const float *radiance;
	/* [3] Mean of diffuse + specular reflectance at the first hit; 0 for a miss. */
	const float *albedo;
	/* [3] Mean shading normal at the first hit, in world space, not unit; 0 for a miss. */
	const float *normal;
	/* Mean distance to the first hit along the view axis, of the samples that hit; +infinity: none did. */
	const float *depth;
	/* [3] Variance of the mean radiance, that is the square of its standard error, as if samples were independent: too
	 * large for the samplers that spread samples evenly. 0 below two samples. */
	const float *variance;
	/* Number of samples. */
	const uint32_t *samples;
	/* [3] Radiance that stilb_gi_render_denoise made; NULL: it has not been called since the last run. */
	const float *denoised;
} stilb_gi_film;

/* The film, not copied: valid until destroy, to be read while run does not run. [main-thread] */
stilb_gi_film stilb_gi_render_film(const stilb_gi_render *render);

/* Filters the noise out of the picture so far, on the pool, as film/gi_denoise.h tells: the same bits for any number of
 * workers. settings.denoise only. The samples stay: run may go on, and drops the filtered picture. Takes 132 bytes a
 * pixel while it works, and a megabyte a thread; 12 bytes a pixel stay. STILB_ERROR_MEMORY. [main-thread] */
stilb_result stilb_gi_render_denoise(stilb_gi_render *render);

/* Writes the picture, whole or not at all. With settings.denoise the radiance is the denoised one; what has not called
 * stilb_gi_render_denoise is done here. A name that ends in .exr: all planes as layers (R G B, albedo.*, normal.*,
 * depth.Z, variance.*, samples), with the settings as attributes. .hdr: the mean radiance alone. .png: what
 * stilb_gi_display gives. If the scene's backdrop is nothing, .exr and .png have alpha, the share of the samples that
 * hit something; the radiance of an .exr is then premultiplied, as that format has it. Errors: STILB_ERROR_ARGUMENT:
 * other endings; STILB_ERROR_FILE; STILB_ERROR_MEMORY. [main-thread] */
stilb_result stilb_gi_render_save(stilb_gi_render *render, const char *path);

/* What a .png shows besides exposure and tone map. */
typedef struct stilb_gi_grade {
	/* The colour that codes of sRGB over 255 become, likewise; NULL: they stay. */
	void (*at)(const void *user, const float code[3], float out[3]);
	const void *user;
	bool dither; /* adds noise of up to one code before rounding (STILB_RENDER_DITHER_TRIANGULAR): the mean stays, and
	                slow gradients show no bands */
} stilb_gi_grade;

/* The same; grade counts for .png of light alone: other files keep radiance, and channels are what they are.
 * The file's own settings do not name the grade. NULL: none. */
stilb_result stilb_gi_render_save_graded(stilb_gi_render *render, const char *path, const stilb_gi_grade *grade);

/* Writes everything that another process needs to continue with stilb_gi_render_resume: there the same settings, scene,
 * binary and instruction set give the same bits as a render that was never stopped. Whole or not at all; not while run
 * runs. Errors: STILB_ERROR_FILE. [main-thread] */
stilb_result stilb_gi_render_checkpoint(const stilb_gi_render *render, const char *path);

/* Continues from a checkpoint; only before the first run (else STILB_ERROR_ARGUMENT). The limits, progressive and
 * exposure may differ from the checkpoint's; so may samples, except with the samplers STRATIFIED and BLUE_NOISE, whose
 * points depend on how many there will be. Errors: STILB_ERROR_FILE: it cannot be read, is damaged, or belongs to
 * another scene, version or other settings, of which the message names the first that differs; STILB_ERROR_MEMORY. Then
 * the render stays empty. [main-thread] */
stilb_result stilb_gi_render_resume(stilb_gi_render *render, const char *path);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
