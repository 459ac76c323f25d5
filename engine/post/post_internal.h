/* Inside post/: the chain's state, and the rows that all effects are made of. */
#ifndef POST_INTERNAL_H
#define POST_INTERNAL_H

#include "base/base_contract.h"
#include "post/cpu/post_cpu.h"
#include "post/post.h"

#define POST_BLOOM_DEFAULT_WIDTH 0.6f
#define POST_MOTION_DEFAULT_MOST 0.1f
#define POST_MOTION_DEFAULT_FAR 10.0f      /* metres */
#define POST_OCCLUSION_DEFAULT_RADIUS 1.0f /* metres */

typedef enum post_program {
	POST_BLOOM_HALVE_FIRST, /* the frame's light, which may hold anything */
	POST_BLOOM_HALVE,
	POST_BLOOM_DOUBLE,
	POST_BLOOM_ADD,
	POST_OCCLUSION,
	POST_OCCLUSION_SMOOTH,
	POST_OCCLUSION_APPLY,
	POST_EXPOSURE,
	POST_TEMPORAL,
	POST_MOTION_KEPT,
	POST_MOTION_ROWS,
	POST_MOTION_TILES,
	POST_MOTION_AROUND,
	POST_MOTION,
	POST_MOTION_FAR,
	POST_MOTION_FAR_SHOW,
	POST_EDGES,
	POST_PROGRAMS
} post_program;

/* Images that the CPU works on. */
typedef enum post_mapped { POST_MAPPED_LIGHT, POST_MAPPED_AMBIENT, POST_MAPPED_DEPTH, POST_MAPPED } post_mapped;

/* ---- exposure ---- */

#define POST_EXPOSURE_CLASSES 512u             /* of luminance: 16 a stop, from 2^-16 on */
#define POST_EXPOSURE_GROUPS 64u               /* work groups at most, each of which counts for itself */
#define POST_EXPOSURE_COUNTS "exposure counts" /* the buffer */
#define POST_EXPOSURE_GREY 0.18                /* of display white */

/* A copy of a frame's counts that is on its way. */
typedef struct post_counts {
	uint64_t ticket; /* 0: none */
	uint32_t groups;
} post_counts;

/* The exposure's state. */
typedef struct post_meter {
	bool known;         /* exposure counts */
	float exposure;     /* stops */
	float wanted;       /* where it goes */
	uint32_t groups;    /* that count in the frame that was planned last */
	post_counts coming; /* of the frame before the last */
} post_meter;

/* ---- grade ---- */

#define POST_GRADE_BLENDED 33u /* entries a side of what several tables are blended to, at most */

typedef struct post_grading {
	stilb_post_table *tables[STILB_POST_MAX_AREAS + 1]; /* copies: of the areas, and behind them that of no area */
	stilb_post_area areas[STILB_POST_MAX_AREAS];        /* .table: of these, or NULL */
	uint32_t count;
	float weights[STILB_POST_MAX_AREAS]; /* of what `shown` is made of */
	bool known;                          /* weights count */
	float exposure;                      /* stops of the areas */
	stilb_gpu_image image;
	uint32_t width, height, depth; /* of the image */
	stilb_render_grade shown;
	bool shows; /* there is a table to be seen */
} post_grading;

/* What each area weighs at this place: weights[count], whose sum is at most 1. Returns what is left for no area. */
float post_grade_weights(const stilb_post_area *areas, uint32_t count, const float position[3], float *weights);
void post_grade_finish(stilb_post *post);

/* The exposure that shows the mean of what lies between the percentiles as grey, stops. counts:
 * [POST_EXPOSURE_CLASSES]. False: nothing was counted. */
bool post_exposure_of(const uint64_t *counts, const stilb_post_settings *settings, float *stops);
/* Where an exposure is that goes from `from` to `to` for so many seconds. */
float post_exposure_step(float from, float to, float seconds, const stilb_post_settings *settings);
/* The exposure's members of the settings, each in its range; and their defaults in place of 0. */
bool post_exposure_is_valid(const stilb_post_settings *settings);
void post_exposure_defaults(stilb_post_settings *settings);

typedef enum post_lens_program {
	POST_LENS_LIGHT,
	POST_LENS_HALVE_FIRST,
	POST_LENS_HALVE,
	POST_LENS_TILES,
	POST_LENS_REACH,
	POST_LENS_GATHER,
	POST_LENS_COMBINE,
	POST_LENS_BLUR,
	POST_LENS_LERP,
	POST_LENS_PROGRAMS
} post_lens_program;

typedef enum post_reflections_program {
	POST_REFLECTIONS_LIGHT,
	POST_REFLECTIONS_NEAREST,
	POST_REFLECTIONS_PLACE,
	POST_REFLECTIONS_TRACE,
	POST_REFLECTIONS_APPLY,
	POST_REFLECTIONS_PROGRAMS
} post_reflections_program;

struct stilb_post {
	stilb_render *render;
	stilb_post_settings settings;
	float exposure;       /* stops */
	bool sees;            /* from_clip is there */
	stilb_mat4 from_clip; /* to the world's directions, around the camera */
	post_meter meter;
	post_grading grading;
	bool shows_light;   /* the main view's image is light, not counts or a channel of materials */
	bool shaded;        /* and nothing else: not how far it is off, either */
	bool follows;       /* to_last is there, and what frames show may be followed from frame to frame */
	stilb_mat4 to_last; /* from clip space to that of the frame before */
	bool held;          /* motion blur goes on with the velocities of the frame before */
	bool forgotten;     /* the next frame has no history */
	uint32_t whole;     /* the height of the picture of which frames show a part; 0: they show all of it */
	stilb_mat4 to_clip; /* its inverse */
	uint16_t ambient;   /* of this frame, with occlusion */
	stilb_gpu_sampler linear;
	post_cpu *cpu; /* NULL: nothing was computed by the CPU yet */
	stilb_job_pool *pool;
	stilb_gpu_buffer mapped[POST_MAPPED]; /* images while the CPU works on them */
	uint64_t mapped_bytes[POST_MAPPED];
	stilb_gpu_program programs[STILB_POST_BLOOM_FORMATS_COUNT][POST_PROGRAMS];
	stilb_gpu_program lens[POST_LENS_PROGRAMS];
	uint32_t lens_blades[POST_LENS_PROGRAMS]; /* of the aperture that each of them is made for */
	stilb_gpu_program reflections[POST_REFLECTIONS_PROGRAMS];
	uint32_t reflections_way[POST_REFLECTIONS_PROGRAMS]; /* likewise, a stilb_post_reflections */
};

extern const stilb_gpu_shader post_shader_bloom_halve, post_shader_bloom_double, post_shader_bloom_add;
extern const stilb_gpu_shader post_shader_exposure;
extern const stilb_gpu_shader post_shader_occlusion, post_shader_occlusion_smooth, post_shader_occlusion_apply;
extern const stilb_gpu_shader post_shader_temporal, post_shader_edges;
extern const stilb_gpu_shader post_shader_motion_kept, post_shader_motion_tile, post_shader_motion_around,
	post_shader_motion, post_shader_motion_far, post_shader_motion_far_show;
extern const stilb_gpu_shader post_shader_reflections_light, post_shader_reflections_nearest,
	post_shader_reflections_place;
extern const stilb_gpu_shader post_shader_reflections_trace, post_shader_reflections_apply;
extern const stilb_gpu_shader post_shader_lens_light, post_shader_lens_halve, post_shader_lens_tiles;
extern const stilb_gpu_shader post_shader_lens_reach, post_shader_lens_gather, post_shader_lens_combine;
extern const stilb_gpu_shader post_shader_lens_blur, post_shader_lens_lerp;

/* The program of this number, made when it is first asked for; of bloom in the settings' format. Constant 0 of bloom's
 * shaders is whether it is FIXED, 1 of the one that halves whether it is the first; 0 of the one of
 * tiles whether it reads velocities. */
stilb_result post_program_get(stilb_post *post, post_program number, stilb_gpu_program *program);

/* What fullscreen rows of effects have in common: fills in the row's kind, and that each of its colours, which it has,
 * is drawn anew, and use number u, which names a resource, is sampled at binding u. */
void post_row_fill(stilb_gpu_pass *row, const char *name, stilb_gpu_program program, uint32_t colors, uint32_t uses);

/* The depth by which the image of velocities was decided; 0: there is none. */
uint16_t post_velocity_depth(const stilb_gpu_plan *plan);

/* Adds occlusion's rows, and puts the image with it in the place of *ambient. */
stilb_result post_occlusion_add(stilb_post *post, stilb_gpu_plan *plan, uint16_t *ambient, uint16_t depth);

/* Likewise, for the CPU's threads. */
stilb_result post_host_bloom_add(stilb_post *post, stilb_gpu_plan *plan, uint16_t *light);
stilb_result post_host_occlusion_add(stilb_post *post, stilb_gpu_plan *plan, uint16_t *ambient, uint16_t depth);

/* Adds the row that counts the light's pixels. */
stilb_result post_exposure_add(stilb_post *post, stilb_gpu_plan *plan, uint16_t light);
/* Gives up copies that are on their way. */
void post_exposure_finish(stilb_post *post);
/* Adds the row of temporal antialiasing, and puts the image with it in the place of *light; none in frames that lack an
 * image for it. */
stilb_result post_temporal_add(stilb_post *post, stilb_gpu_plan *plan, uint16_t *light);

/* Adds the rows of motion blur, and puts the image with it in the place of *light; none without velocities. */
stilb_result post_motion_add(stilb_post *post, stilb_gpu_plan *plan, uint16_t *light);

/* Adds the row of antialiasing by edges, and puts its image in the place of *picture; none if that holds radiance. */
stilb_result post_edges_add(stilb_post *post, stilb_gpu_plan *plan, uint16_t *picture);

/* Adds bloom's rows, and puts the image with it in the place of *light. */
stilb_result post_bloom_add(stilb_post *post, stilb_gpu_plan *plan, uint16_t *light);

#endif
