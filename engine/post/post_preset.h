/*
 * post_preset: a look as one JSON file: every setting of the chain, exposure, tone map, grade and areas.
 *
 *   {
 *     "exposure": "adapt",                     or stops, -32..32
 *     "exposure_percentiles": [0.7, 0.97], "exposure_speed": 2, "exposure_rate": 4, "exposure_range": [-16, 16],
 *     "ao": 1, "ao_radius": 2,
 *     "bloom": 0.06, "bloom_width": 0.6, "bloom_format": "half", "post": "auto",
 *     "aa": "temporal", "motion_blur": 0.5, "motion_blur_most": 0.1, "motion_blur_of": "far", "motion_blur_far": 10,
 *     "reflections": "cones", "dof": "bokeh", "aperture": 0.02, "focus": 5, "blades": 5,
 *     "tone": "piecewise", "grade": "warm.cube", "dither": "triangular",
 *     "areas": [{"low": [-4, 0, -3], "high": [0, 3, 3], "blend": 1, "exposure": 0.5, "grade": "cold.cube"}]
 *   }
 *
 * Members   Any of these, each at most once, with the meaning and the range of stilb_post_settings and
 *           stilb_post_area; what is left out is as in {0}. Files of tables lie beside the preset, or have whole paths.
 *           An area needs low and high; its blend is 1 if it says none. Another member is an error that names it.
 * Saving    stilb_post_preset_save writes what is not as in {0}, so that reading it gives the same look.
 * Threads   [any-thread] for presets that nobody destroys.
 */
#ifndef STILB_POST_PRESET_H
#define STILB_POST_PRESET_H

#include "post/post.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* A scene's own look is called SCENE and this behind it, as `stilb view` finds it. */
#define STILB_POST_PRESET_SUFFIX ".post.json"

typedef struct stilb_post_preset {
	stilb_post_settings settings; /* valid */
	bool has_exposure;            /* it says stops, or that it adapts; then exposure counts, 0 if it adapts */
	float exposure;               /* stops */
	bool has_tone;
	uint32_t tone;                                       /* SHADE_TONE_... */
	stilb_post_table *grade;                             /* NULL: none */
	stilb_post_area areas[STILB_POST_MAX_AREAS];         /* valid; .table: NULL, or one of these: */
	stilb_post_table *area_grades[STILB_POST_MAX_AREAS]; /* NULL: it has none */
	uint32_t area_count;
	/* Of the tables, as the preset named them, from where the program stands; owned. NULL: none. */
	char *grade_file, *area_files[STILB_POST_MAX_AREAS];
} stilb_post_preset;

/* Reads a preset and the tables that it names. STILB_ERROR_FILE: a file cannot be read, or is wrong; the message has
 * its name and the line. STILB_ERROR_MEMORY. *preset is NULL then. */
stilb_result stilb_post_preset_open(const char *path, stilb_post_preset **preset);
/* Writes a preset, whole or not at all. Tables are named by their files: those in the preset's folder by their name,
 * others by their whole path. STILB_ERROR_ARGUMENT: a table has no file. STILB_ERROR_FILE, STILB_ERROR_MEMORY. */
stilb_result stilb_post_preset_save(const stilb_post_preset *preset, const char *path);
/* Accepts NULL. */
void stilb_post_preset_destroy(stilb_post_preset *preset);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
