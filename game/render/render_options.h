/* What `stilb render` was asked for: its command line, read and checked. */
#ifndef STILB_RENDER_OPTIONS_H
#define STILB_RENDER_OPTIONS_H

#include "game/cli/flags.h"
#include "gi/gi_render.h"

#include <limits.h>
#include <stdio.h>

#define RENDER_NOT_GIVEN (-1)

typedef struct offline_options {
	const char *scene, *output, *stats, *trace, *environment, *cache_load, *cache_save;
	char checkpoint[PATH_MAX]; /* beside the output; "": there is none */
	uint64_t samples, seed, depth, rays, blades, cache_rays;
	float seconds, error, exposure, aperture, focus, roulette, ao_distance, cache_error, checkpoint_s;
	uint32_t size[2], workers;
	int integrator, sampler, filter, isa, only, fireflies, ao, cache, cache_radius;
	int gradients, overture;
	int brdf, ndf, g, f; /* RENDER_NOT_GIVEN, or the number of the word */
	bool preview, resume, dry_run, force, show_records, allow_outside;
	flag_list camera;
} offline_options;

/* The words of the choices, in the order of gi's enumerations; NULL-terminated. */
extern const char *const offline_integrators[];
extern const char *const offline_samplers[];
extern const char *const offline_filters[];
extern const char *const offline_cache_radii[];

/* Reads the flags, or prints the help. */
flags_result offline_options_parse(offline_options *o, int argc, char **argv);

/* What the flags alone cannot say: false after a line that tells what is wrong. Nothing is started or written. */
bool offline_options_check(const offline_options *o);

/* The settings for a scene, whose camera it is unless the flags place another. */
stilb_gi_settings offline_options_settings(const offline_options *o, const stilb_scene *scene);

/* The sky or the map of --environment, if there is one. */
stilb_result offline_options_surroundings(const offline_options *o, stilb_scene *scene);

/* Where the words go: not among the bytes of a file that is written to stdout. */
FILE *offline_options_words(const offline_options *o);

#endif
