#include "bake_options.h"

#include "bake/bake_atlas.h"

#include <stdio.h>
#include <string.h>

typedef struct bake_word {
	const char *name, *help;
} bake_word;

static const bake_word what_words[] = {
	{"lightmap", "light that a white surface would reflect there: irradiance over pi"},
	{"ao", "ambient occlusion: how much of the hemisphere is open"},
	{"glb", "the scene with the places of its triangles on the pages, for other programs"},
	{"rnm", "light from three directions, for bumps: radiosity normal maps"},
	{"intensity", "the same in one picture, whose colour is the lightmap's"},
	{"probes", "light in the air, for what moves: a grid of spherical harmonics"},
};

static const bake_word show_words[] = {
	{"charts", "which pieces of the surface lie where"},
	{"texels", "texels as chequers, those that are covered in part alone in colour"},
	{"states", "which texels were lit, filled from neighbours, or lie inside of something"},
	{"light", "the lightmap as pictures are displayed"},
};

#define WORDS(words) words, sizeof words / sizeof *words

/* Reads words with commas between them. False after a line. */
static bool read_words(const char *flag_name, const char *text, const bake_word *words, size_t count, uint32_t *bits)
{
	*bits = 0;
	for (const char *at = text;;) {
		size_t length = strcspn(at, ","), word = 0;
		while (word < count && (strlen(words[word].name) != length || strncmp(at, words[word].name, length) != 0))
			word++;
		if (word == count) {
			char list[128] = "";
			for (size_t i = 0; i < count; i++)
				snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s", i > 0 ? ", " : "", words[i].name);
			stilb_log("%s: '%.*s' is not known; give some of %s, with commas between them", flag_name, (int)length, at,
			          list);
			return false;
		}
		*bits |= 1u << word;
		if (at[length] == '\0')
			return true;
		at += length + 1;
	}
}

static void print_words(const char *title, const bake_word *words, size_t count)
{
	printf("\n%s:\n", title);
	for (size_t i = 0; i < count; i++)
		printf("  %-18s %s\n", words[i].name, words[i].help);
}

static bool options_check(bake_options *o)
{
	if (!o->scene)
		stilb_log("no scene; give one: stilb bake SCENE -o DIR, a file or one of %s", stilb_scene_builtin_names());
	else if (!o->output)
		stilb_log("no output; give -o DIR, a folder");
	else if (o->cone < 1.0f)
		stilb_log("--cone: charts need some degrees to grow; give 1..85");
	else if (o->crease < 1.0f)
		stilb_log("--crease: at 0 degrees every edge would be one; give 1..180");
	else
		return read_words("--what", o->what_text, WORDS(what_words), &o->what) &&
		       (!o->show_text || read_words("--show", o->show_text, WORDS(show_words), &o->show));
	return false;
}

flags_result bake_options_parse(bake_options *o, int argc, char **argv)
{
	static const char *const onlys[] = {"all", "indirect", NULL}, *const hiddens[] = {"fill", "keep", NULL};
	*o = (bake_options){.what_text = "lightmap,ao,glb",
	                    .workers = FLAG_WORKERS_AUTO,
	                    .cone = 55.0f,
	                    .crease = 60.0f,
	                    .side = 1024,
	                    .mips = 1,
	                    .samples = 64,
	                    .depth = 64,
	                    .probe_samples = 256};
	const flag rows[] = {
		{"scene", FLAG_WORD, &o->scene, NULL, NULL, 0, 0, NULL},
		{"-o", FLAG_TEXT, &o->output, "DIR", "folder for the files; it is made if it is not there", 0, 0, NULL},
		{"--what", FLAG_TEXT, &o->what_text, "LIST", "what to write, see below (lightmap,ao,glb)", 0, 0, NULL},
		{"--show", FLAG_TEXT, &o->show_text, "LIST", "pictures of how it came about, see below", 0, 0, NULL},

		{"Texels", FLAG_TITLE, NULL, NULL, NULL, 0, 0, NULL},
		{"--texels-per-unit", FLAG_AMOUNT, &o->density, "T", "texels a metre; 0: as many as about fill one page (0)", 0,
	     1000000, NULL},
		{"--page", FLAG_NUMBER, &o->side, "N", "side of a page, texels, 64..8192 (1024)", 64, 8192, NULL},
		{"--mips", FLAG_NUMBER, &o->mips, "N", "mip levels below the largest that keep charts apart, 0..4 (1)", 0, 4,
	     NULL},
		{"--cone", FLAG_AMOUNT, &o->cone, "DEG", "how far triangles lean off their chart, 1..85 degrees (55)", 0, 85,
	     NULL},
		{"--crease", FLAG_AMOUNT, &o->crease, "DEG", "edges sharper than this end charts, 1..180 degrees (60)", 0, 180,
	     NULL},

		{"Light", FLAG_TITLE, NULL, NULL, NULL, 0, 0, NULL},
		{"--spp", FLAG_NUMBER, &o->samples, "N", "samples a texel, 1..65536 (64)", 1, 65536, NULL},
		{"--depth", FLAG_NUMBER, &o->depth, "N", "reflections at most, 0..1024; 1: direct light alone (64)", 0, 1024,
	     NULL},
		{"--only", FLAG_CHOICE, &o->only, "all|indirect", "indirect: without light straight from the lights (all)", 0,
	     0, onlys},
		{"--ao-distance", FLAG_AMOUNT, &o->ao_distance, "D",
	     "surfaces farther away than D metres do not occlude; 0: all do (0)", 0, 1000000, NULL},
		{"--hidden", FLAG_CHOICE, &o->hidden, "fill|keep",
	     "texels that see backs of surfaces: fill from neighbours, or keep (fill)", 0, 0, hiddens},
		{"--environment", FLAG_TEXT, &o->environment, "FILE", "panorama of the surroundings, .hdr or .exr", 0, 0, NULL},
		{"--seed", FLAG_NUMBER, &o->seed, "N", "seed of all random numbers, 0..2^64-1 (0)", 0, UINT64_MAX, NULL},

		{"Probes", FLAG_TITLE, NULL, NULL, NULL, 0, 0, NULL},
		{"--probe-spacing", FLAG_AMOUNT, &o->probe_spacing, "D", "metres between them; 0: about 2,000 probes (0)", 0,
	     1000000, NULL},
		{"--probe-spp", FLAG_NUMBER, &o->probe_samples, "N", "samples of each, 16..65536 (256)", 16, 65536, NULL},

		{"The run", FLAG_TITLE, NULL, NULL, NULL, 0, 0, NULL},
		{"--workers", FLAG_WORKERS, &o->workers, "N", "threads, 1..256 or auto: one for each CPU (auto)", 1, 256, NULL},
		{"--allow-outside", FLAG_SWITCH, &o->allow_outside, NULL,
	     "the scene may name files anywhere, not only beside it", 0, 0, NULL},
		{"--quiet", FLAG_SWITCH, &o->quiet, NULL, "say nothing of what the file has and is not shown", 0, 0, NULL},
	};
	size_t count = sizeof rows / sizeof *rows;
	flags_result result = flags_parse(rows, count, argc, argv);
	if (result == FLAGS_HELP) {
		printf(
			"stilb bake SCENE -o DIR [FLAGS]: unwraps a scene, and computes the light on its surfaces by rays. SCENE\n"
			"is a file (glTF, OBJ, ...) or one of %s.\n\n",
			stilb_scene_builtin_names());
		flags_print(rows, count);
		print_words("What --what writes", WORDS(what_words));
		print_words("What --show shows", WORDS(show_words));
	}
	return result == FLAGS_OK && !options_check(o) ? FLAGS_REFUSED : result;
}
