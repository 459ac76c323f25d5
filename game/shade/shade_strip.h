/*
 * shade_strip: pictures of spheres in rows. From left to right one number changes, for example the roughness; each row
 * is another material or model. Every pixel is computed with the functions of engine/shading.
 *
 *   uint32_t size[2];
 *   strip_size(&strips[0], 100.0f, size);
 *   if (strip_save(&strips[0], size, FLAG_WORKERS_AUTO, "classic.png") != STILB_OK)
 *       stilb_log("%s", stilb_error_message());
 *
 * shade_strip.c draws; the tables of rows are in shade_strip_rows.c, shade_strip_light.c and shade_strip_relief.c.
 * Threads.  The functions are [main-thread]; the callbacks relief and radiance of a sphere run on jobs.
 */
#ifndef STILB_SHADE_STRIP_H
#define STILB_SHADE_STRIP_H

#include "base/base_math.h"
#include "image/image.h"
#include "jobs/job.h"
#include "shading/shade_brdf.h"

typedef struct strip_sphere strip_sphere;

/* A point on the visible side of a sphere of radius 1 that is seen along -z: x to the right, y up; step is the distance
 * to the next sample in x and y. */
typedef struct strip_place {
	float x, y, step;
} strip_place;

/* Replaces the normal *n and the roughness of the smooth sphere by those of the surface at a place, for sample i of the
 * sphere's relief_samples, whose radiance is averaged. [any-thread] */
typedef void strip_relief(const strip_sphere *sphere, strip_place place, uint32_t i, stilb_vec3 *n, float *roughness);

/* Returns the radiance, seen along -z, of a place with the normal n. Without this callback the place is lit by the
 * studio, the lamps and the sky in shade_strip.c. [any-thread] */
typedef stilb_vec3 strip_radiance(const strip_sphere *sphere, stilb_vec3 n);

/* The material of a sphere: a diffuse part and a highlight. */
struct strip_sphere {
	stilb_vec3 diffuse;
	float wrap;
	float diffuse_gain; /* factor, 1; another cancels a factor of the model, to show the effect of that */
	shade_brdf_model model;
	shade_brdf_parameters highlight;
	float highlight_gain; /* factor of the highlight, as diffuse_gain of the diffuse part */
	float mirror;         /* factor of the surroundings reflected by the highlight; 0: only lamps are */
	strip_relief *relief; /* NULL: smooth */
	float relief_scale;
	uint32_t relief_level, relief_samples;
	strip_radiance *radiance; /* NULL: that under the light of the studio */
	float number;             /* for the callback radiance: the number that changes from column to column */
	int light;                /* for the callback radiance: the lamp, a SHADE_LIGHT_ */
};

/* The normal of a smooth sphere of radius 1 at a place; beyond its rim that of the rim. [any-thread] */
stilb_vec3 strip_normal(float x, float y);

#define STRIP_ROWS_MAX 12
#define STRIP_COLUMNS_MAX 12
typedef char strip_words[32];

typedef struct strip_row strip_row;
struct strip_row {
	const char *caption; /* one to three lines */
	/* Sets *sphere to that of a column, and words to its number, for the text below it. */
	void (*make)(const strip_row *row, int column, strip_sphere *sphere, strip_words words);
	/* Parameters of make, for functions that several rows share. */
	int kind; /* a model (SHADE_BRDF_), a distribution (SHADE_NDF_) or a lamp (SHADE_LIGHT_) */
	float anisotropy;
	strip_relief *relief;
	uint32_t relief_samples;
	strip_radiance *radiance;
};

typedef struct strip {
	const char *name;
	const char *title;
	const strip_row *rows;
	int row_count, column_count;
	bool tone_mapped;              /* the rows apply tone mapping themselves */
	stilb_result (*prepare)(void); /* called before the rows are drawn; NULL: nothing to prepare */
	void (*finish)(void);          /* called after they were drawn, or after prepare has failed; NULL: nothing to do */
} strip;

/* Defined in shade_strip_relief.c. */
extern const strip_row strip_bump_rows[], strip_filter_rows[];
#define STRIP_BUMP_ROWS 3
#define STRIP_FILTER_ROWS 3
stilb_result strip_filter_prepare(void);
void strip_filter_finish(void);
/* Defined in shade_strip_light.c. */
extern const strip_row strip_light_rows[], strip_sh_rows[], strip_tonemap_rows[];
#define STRIP_LIGHT_ROWS 4
#define STRIP_SH_ROWS 4
#define STRIP_TONEMAP_ROWS 4

extern const strip strips[];
extern const int strip_count;

/* Computes the size of the picture, pixels, in which each sphere is `sphere` > 0 pixels wide. */
void strip_size(const strip *s, float sphere, uint32_t size[2]);

/* Draws a strip of this size ({0, 0}: spheres of 100 pixels) on a pool of `workers` threads (or FLAG_WORKERS_AUTO), and
 * saves it as path. Errors of stilb_image_save, and STILB_ERROR_THREAD. */
stilb_result strip_save(const strip *s, const uint32_t size[2], uint32_t workers, const char *path);

/* Draws the strip into a picture of three channels in the format F32_LINEAR: radiance, tone mapped if asked to.
 * STILB_ERROR_MEMORY. */
stilb_result strip_draw(const strip *s, stilb_image *picture, bool tone_mapped, stilb_job_pool *pool);

#endif
