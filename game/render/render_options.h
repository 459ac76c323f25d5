/*
 * offline_options: the command line of `stilb render`, read, checked, and turned into the settings of the ray tracer,
 * engine/gi.
 *
 *   static offline_options options;
 *   if (offline_options_parse(&options, argc, argv) == FLAGS_OK && offline_options_check(&options))
 *       ...                                             open the scene, then
 *       settings = offline_options_settings(&options, scene);
 *
 * Threads.  All [any-thread] for options that nobody changes; parsing is [main-thread].
 */
#ifndef STILB_RENDER_OPTIONS_H
#define STILB_RENDER_OPTIONS_H

#include "game/cli/flags.h"
#include "game/cli/picture_flags.h"
#include "gi/gi_render.h"
#include "render_rays.h"

#include <limits.h>
#include <stdio.h>

#define RENDER_NOT_GIVEN PICTURE_NOT_GIVEN

typedef struct offline_options {
	const char *scene, *output, *stats, *trace, *cache_load, *cache_save;
	char checkpoint[PATH_MAX]; /* OUTPUT.checkpoint; "" without an output file */
	uint64_t samples, seed, depth, rays, blades, cache_rays;
	float seconds, error, aperture, focus, roulette, ao_distance, cache_error, checkpoint_s;
	uint32_t size[2], workers;
	int sampler, filter, isa, only, fireflies, ao, cache, cache_radius;
	int gradients, overture;
	const char *frames; /* of --frames, "A..B"; NULL: one picture */
	uint32_t frame_first, frame_last;
	float fps, shutter; /* frames a second; share of a frame's time that its picture shows */
	uint64_t moments;   /* poses in it */
	int show;           /* stilb_scene_surface_channel, or RENDER_NOT_GIVEN */
	picture_flags picture;
	rays_flags light;
	const char *part; /* of --part, "I/N"; NULL: the whole picture */
	uint32_t part_index, part_of;
	bool merge;        /* of --help alone: render_merge.h reads it */
	bool guest;        /* one of the ranks of mpirun that write nothing */
	const char *grade; /* NULL: none */
	int dither;        /* index into offline_dithers; 1: noise of one code before rounding to 8 bits */
	bool denoise, preview, resume, dry_run, force, show_records;
} offline_options;

/* The words that the flags --sampler, --filter and --cache-radius accept, in the order of the
 * enumerations of engine/gi; NULL-terminated. */
extern const char *const offline_samplers[];
extern const char *const offline_filters[];
extern const char *const offline_cache_radii[];

/* Sets the defaults, which depend on the integrator, and reads the flags; prints the help or the error instead, as
 * flags_parse returns. A flag that the integrator has no use for is one line on stderr, not an error. */
flags_result offline_options_parse(offline_options *o, int argc, char **argv);

/* Takes out all that a rank other than 0 has no use for: its outputs, the window. After parse. */
void offline_options_be_guest(offline_options *o);

/* Checks what the table of flags cannot express: flags that contradict each other, and the files. Returns false after
 * one line on stderr. Starts nothing and writes nothing. */
bool offline_options_check(const offline_options *o);

/* Refuses what gives other bits, or makes no sense, where many machines render one picture, after one line on stderr.
 * how: what asked for them, "--part". */
bool offline_options_share_check(const offline_options *o, const char *how);

/* The settings for a scene and its camera. They point to strings of *o. */
stilb_gi_settings offline_options_settings(const offline_options *o, const stilb_scene *scene);

/* The stream for messages: stderr if an output file is standard output, else stdout. */
FILE *offline_message_stream(const offline_options *o);

#endif
