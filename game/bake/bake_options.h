/* bake_options: the flags of `stilb bake`. [main-thread] */
#ifndef GAME_BAKE_OPTIONS_H
#define GAME_BAKE_OPTIONS_H

#include "game/cli/flags.h"

/* What is written, a bit for each word of --what and --show. */
enum {
	BAKE_LIGHTMAP = 1u << 0,
	BAKE_AO = 1u << 1,
	BAKE_GLB = 1u << 2,
	BAKE_RNM = 1u << 3,
	BAKE_INTENSITY = 1u << 4,
	BAKE_PROBES = 1u << 5,
	BAKE_SHOW_CHARTS = 1u << 0,
	BAKE_SHOW_TEXELS = 1u << 1,
	BAKE_SHOW_STATES = 1u << 2,
	BAKE_SHOW_LIGHT = 1u << 3,
};

typedef struct bake_options {
	const char *scene, *output, *environment, *what_text, *show_text;
	uint32_t what, show; /* bits */
	uint32_t workers;
	float density, ao_distance, probe_spacing, cone, crease; /* degrees, those that are angles */
	uint64_t side, mips, samples, depth, seed, probe_samples;
	int only, hidden; /* only: a stilb_gi_only; hidden: 0 fill, 1 keep */
	bool allow_outside, quiet;
} bake_options;

/* Reads and checks the command line. FLAGS_REFUSED after a line on stderr. */
flags_result bake_options_parse(bake_options *o, int argc, char **argv);

#endif
