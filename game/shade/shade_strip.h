/* shade_strip: rows of spheres, from left to right with one number that changes; each pixel is computed with the
 * functions of engine/shading. */
#ifndef STILB_SHADE_STRIP_H
#define STILB_SHADE_STRIP_H

#include "base/base_math.h"
#include "image/image.h"
#include "jobs/job.h"
#include "shading/shade_brdf.h"

typedef struct strip_sphere strip_sphere;

/* A place on a sphere of radius 1, seen along -z; step is the distance to the next sample. */
typedef struct strip_place {
	float x, y, step;
} strip_place;

/* What is on the surface there: its normal and roughness come in as those of the smooth sphere. i: which of the
 * sphere's relief_samples, whose light is averaged. */
typedef void strip_relief(const strip_sphere *sphere, strip_place place, uint32_t i, stilb_vec3 *n, float *roughness);

/* In place of the studio's light: the radiance of a place with normal n, seen along -z. */
typedef stilb_vec3 strip_radiance(const strip_sphere *sphere, stilb_vec3 n);

/* What a sphere is made of: evenly reflected light and a highlight. */
struct strip_sphere {
	stilb_vec3 diffuse;
	float wrap;
	float diffuse_gain; /* 1, or what undoes a factor that conserves energy */
	shade_brdf_model model;
	shade_brdf_parameters highlight;
	float highlight_gain; /* as diffuse_gain */
	float mirror;         /* share of the surroundings that the highlight reflects */
	strip_relief *relief; /* NULL: smooth */
	float relief_scale;
	uint32_t relief_level, relief_samples;
	strip_radiance *radiance; /* NULL: the studio's */
	float number;             /* for radiance: what changes from column to column, */
	int light;                /* and which lamp it is, a SHADE_LIGHT_ */
};

/* Of a smooth sphere of radius 1. */
stilb_vec3 strip_normal(float x, float y);

#define STRIP_ROWS_MAX 12
#define STRIP_COLUMNS_MAX 12
typedef char strip_words[32];

typedef struct strip_row strip_row;
struct strip_row {
	const char *caption; /* one to three lines */
	/* The sphere of a column, and in words what its number is. */
	void (*make)(const strip_row *row, int column, strip_sphere *sphere, strip_words words);
	/* What tells rows with the same make apart. */
	int kind; /* of its model (SHADE_BRDF_), its distribution (SHADE_NDF_) or its lamp (SHADE_LIGHT_) */
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
	bool tone_mapped;              /* the rows do it themselves */
	stilb_result (*prepare)(void); /* called before the first row, or NULL */
	void (*finish)(void);
} strip;

/* shade_strip_relief.c */
extern const strip_row strip_bump_rows[], strip_filter_rows[];
#define STRIP_BUMP_ROWS 3
#define STRIP_FILTER_ROWS 3
stilb_result strip_filter_prepare(void);
void strip_filter_finish(void);
/* shade_strip_light.c */
extern const strip_row strip_light_rows[], strip_sh_rows[], strip_tonemap_rows[];
#define STRIP_LIGHT_ROWS 4
#define STRIP_SH_ROWS 4
#define STRIP_TONEMAP_ROWS 4

extern const strip strips[];
extern const int strip_count;

/* Size of the whole picture that gives spheres so many pixels wide. */
void strip_size(const strip *s, float sphere, uint32_t size[2]);

/* Draws a strip of this size (0, 0: its own) on a pool of so many workers (or FLAG_WORKERS_AUTO), and saves it.
 * Errors as stilb_image_save, and STILB_ERROR_THREAD. */
stilb_result strip_save(const strip *s, const uint32_t size[2], uint32_t workers, const char *path);

/* Draws the strip into a picture of three channels, F32_LINEAR: radiance, tone mapped or not. */
stilb_result strip_draw(const strip *s, stilb_image *picture, bool tone_mapped, stilb_job_pool *pool);

#endif
