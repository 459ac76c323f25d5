/* Draws strips, which are pictures of spheres in rows (shade_strip.h): their layout, the lamps that light the spheres,
 * the pixels and the captions. */
#include "shade_strip.h"

#include "game/cli/lettering.h"
#include "shading/shade_light.h"
#include "shading/shade_tonemap.h"

#include <math.h>
#include <stdlib.h>

/* ---- layout ------------------------------------------------------------------------------------------------------ */

/* Sizes of the parts of a picture of spheres, all in units of the side of a cell, the square around a sphere. */
#define CAPTION_WIDTH 2.05f
#define TITLE_HEIGHT 0.42f
#define MARGIN 0.12f
#define NUMBER_HEIGHT 0.22f /* below each sphere */
#define SPHERE_RADIUS 0.46f

typedef struct layout {
	float cell;      /* side of a cell, pixels */
	float left, top; /* of the first cell, pixels from the picture's upper left corner */
	float row;       /* height of a row with the numbers below its spheres, pixels */
} layout;

static float layout_columns(const strip *s)
{
	return CAPTION_WIDTH + (float)s->column_count + MARGIN;
}

static float layout_rows(const strip *s)
{
	return TITLE_HEIGHT + (float)s->row_count * (1.0f + NUMBER_HEIGHT) + MARGIN;
}

static layout layout_of(const strip *s, const stilb_image *picture)
{
	float cell = fminf((float)picture->width / layout_columns(s), (float)picture->height / layout_rows(s));
	return (layout){
		.cell = cell,
		.left = 0.5f * ((float)picture->width - cell * layout_columns(s)) + cell * CAPTION_WIDTH,
		.top = 0.5f * ((float)picture->height - cell * layout_rows(s)) + cell * TITLE_HEIGHT,
		.row = cell * (1.0f + NUMBER_HEIGHT),
	};
}

void strip_size(const strip *s, float sphere, uint32_t size[2])
{
	STILB_ASSERT(sphere > 0.0f);
	float cell = sphere / (2.0f * SPHERE_RADIUS);
	size[0] = (uint32_t)ceilf(cell * layout_columns(s));
	size[1] = (uint32_t)ceilf(cell * layout_rows(s));
}

/* ---- lights ------------------------------------------------------------------------------------------------------ */

/* A distant round lamp is approximated by points; each stands for the part of the lamp around it. */
#define LAMP_POINTS_MAX 256
#define LAMPS 2

typedef struct lamp {
	stilb_vec3 direction;
	float angle;           /* angular radius, radians */
	stilb_vec3 irradiance; /* on a surface that faces it */
} lamp;

typedef struct surroundings {
	lamp lamps[LAMPS];      /* the first from above left; the second from behind right, to show the rim */
	stilb_vec3 sky, ground; /* radiance */
} surroundings;

static surroundings studio(void)
{
	return (surroundings){
		.lamps = {{stilb_vec3_normalize(stilb_vec3_make(-0.55f, 0.62f, 0.62f)), 0.14f,
	               stilb_vec3_make(2.55f, 2.5f, 2.4f)},
	              {stilb_vec3_normalize(stilb_vec3_make(0.86f, 0.2f, -0.35f)), 0.2f,
	               stilb_vec3_make(0.36f, 0.41f, 0.50f)}},
		.sky = stilb_vec3_make(0.13f, 0.145f, 0.17f),
		.ground = stilb_vec3_make(0.042f, 0.038f, 0.034f),
	};
}

/* The number of points of the lamp that give a smooth highlight: at most 64, or LAMP_POINTS_MAX for an anisotropic one,
 * which may be narrower in one direction. */
static int lamp_points(const lamp *light, const shade_brdf_parameters *highlight)
{
	float across = 4.0f * light->angle / shade_alpha_from_roughness(highlight->roughness);
	return (int)fminf(fmaxf(across * across, 1.0f), highlight->anisotropy == 0.0f ? 64.0f : (float)LAMP_POINTS_MAX);
}

/* The direction to point i of `count`, which are spread evenly over the lamp: each is turned by the golden angle from
 * the one before.
 * Source: Vogel, "A better way to construct the sunflower head" (1979). */
static stilb_vec3 lamp_point(const lamp *light, int i, int count)
{
	if (count == 1)
		return light->direction;
	shade_frame frame = shade_frame_from_normal(light->direction);
	float radius = tanf(light->angle) * sqrtf(((float)i + 0.5f) / (float)count), turn = 2.39996323f * (float)i;
	return stilb_vec3_normalize(light->direction + frame.t * (radius * cosf(turn)) + frame.b * (radius * sinf(turn)));
}

/* The roughness that makes a highlight as wide as light from a part of a lamp with that angular radius would:
 * alpha'^2 = alpha^2 + 2 sigma^2, with sigma half the radius because a lobe about the half vector h widens by
 * half as much as the light. Parts are as wide as their distance, so that their highlights merge. */
static float widened_roughness(float roughness, float radius)
{
	float alpha = shade_alpha_from_roughness(roughness), sigma = 0.5f * radius;
	return fminf(sqrtf(sqrtf(alpha * alpha + 2.0f * sigma * sigma)), 1.0f);
}

/* The points of a lamp for the highlight of one sphere. */
typedef struct lamp_parts {
	stilb_vec3 directions[LAMP_POINTS_MAX];
	int count;    /* 0: the sphere has no highlight */
	float radius; /* angular radius of the part that a point stands for */
} lamp_parts;

static lamp_parts lamp_divide(const lamp *light, const strip_sphere *sphere)
{
	lamp_parts parts = {.count = lamp_points(light, &sphere->highlight)};
	stilb_vec3 specular = sphere->highlight.specular;
	if (fmaxf(specular[0], fmaxf(specular[1], specular[2])) <= 0.0f)
		parts.count = 0;
	for (int i = 0; i < parts.count; i++)
		parts.directions[i] = lamp_point(light, i, parts.count);
	parts.radius = light->angle / sqrtf(fmaxf((float)parts.count, 1.0f));
	return parts;
}

static stilb_vec3 from_lamp(const strip_sphere *sphere, const lamp *light, const lamp_parts *parts,
                            const shade_frame *frame, float roughness, stilb_vec3 v)
{
	shade_brdf_model even = {.kind = SHADE_BRDF_WRAPPED};
	shade_brdf_parameters paint = {.specular = sphere->diffuse, .wrap = sphere->wrap};
	stilb_vec3 density = shade_brdf_cos(even, paint, *frame, light->direction, v) * sphere->diffuse_gain;
	shade_brdf_parameters highlight = sphere->highlight;
	highlight.roughness = widened_roughness(roughness, parts->radius);
	for (int i = 0; i < parts->count; i++)
		density += shade_brdf_cos(sphere->model, highlight, *frame, parts->directions[i], v) *
		           (sphere->highlight_gain / (float)parts->count);
	return density * light->irradiance;
}

/* Radiance from the sky and the ground, by the diffuse part and by the highlight. */
static stilb_vec3 from_surroundings(const strip_sphere *sphere, const surroundings *world, const shade_frame *frame,
                                    float roughness, stilb_vec3 v)
{
	stilb_vec3 irradiance = shade_hemisphere_irradiance(frame->n[1], world->sky, world->ground);
	float n_dot_v = fmaxf(stilb_vec3_dot(frame->n, v), 0.0f);
	stilb_vec3 mirrored = frame->n * (2.0f * n_dot_v) - v;
	float alpha = shade_alpha_from_roughness(roughness);
	float exponent = shade_exponent_about_r(shade_exponent_from_alpha(alpha));
	stilb_vec3 seen = shade_hemisphere_radiance(mirrored[1], exponent, world->sky, world->ground);
	stilb_vec3 share = shade_f(sphere->model.f, sphere->highlight.specular, n_dot_v) * sphere->mirror;
	return shade_lambert(sphere->diffuse) * irradiance * sphere->diffuse_gain + share * seen;
}

/* ---- pixels ------------------------------------------------------------------------------------------------------ */

#define SUBSAMPLES 2 /* along each side of a pixel */

typedef struct cell {
	strip_sphere sphere;
	lamp_parts lamps[LAMPS];
} cell;

typedef struct painting {
	const strip *s;
	stilb_image *picture;
	layout place;
	surroundings world;
	bool tone_mapped;
	cell cells[STRIP_ROWS_MAX][STRIP_COLUMNS_MAX];
} painting;

stilb_vec3 strip_normal(float x, float y)
{
	float length = sqrtf(x * x + y * y), inside = fminf(length, 0.999f);
	float shrink = length > 0.0f ? inside / length : 0.0f;
	return stilb_vec3_make(x * shrink, y * shrink, sqrtf(1.0f - inside * inside));
}

/* Radiance of a place with normal n. The eye is far away, so that the direction to it is the same everywhere. The
 * tangent t of the frame goes around the y axis. */
static stilb_vec3 normal_radiance(const surroundings *world, const cell *c, stilb_vec3 n, float roughness)
{
	stilb_vec3 v = stilb_vec3_make(0.0f, 0.0f, 1.0f);
	shade_frame frame = {.n = n};
	frame.t = stilb_vec3_normalize(stilb_vec3_cross(stilb_vec3_make(0.0f, 1.0f, 0.0f), n));
	frame.b = stilb_vec3_cross(n, frame.t);
	stilb_vec3 radiance = from_surroundings(&c->sphere, world, &frame, roughness, v);
	for (int i = 0; i < LAMPS; i++)
		radiance += from_lamp(&c->sphere, &world->lamps[i], &c->lamps[i], &frame, roughness, v);
	return radiance;
}

static stilb_vec3 sphere_radiance(const surroundings *world, const cell *c, strip_place place)
{
	const strip_sphere *sphere = &c->sphere;
	if (sphere->radiance)
		return sphere->radiance(sphere, strip_normal(place.x, place.y));
	if (!sphere->relief)
		return normal_radiance(world, c, strip_normal(place.x, place.y), sphere->highlight.roughness);
	stilb_vec3 sum = stilb_vec3_make(0.0f, 0.0f, 0.0f);
	for (uint32_t i = 0; i < sphere->relief_samples; i++) {
		stilb_vec3 n = strip_normal(place.x, place.y);
		float roughness = sphere->highlight.roughness;
		sphere->relief(sphere, place, i, &n, &roughness);
		sum += normal_radiance(world, c, n, roughness);
	}
	return sum * (1.0f / (float)sphere->relief_samples);
}

/* The background, which is brighter in the middle. */
static stilb_vec3 backdrop(const painting *p, float x, float y)
{
	float dx = x / (float)p->picture->width - 0.5f, dy = y / (float)p->picture->height - 0.4f;
	float light = 0.020f - 0.016f * fminf(dx * dx + dy * dy, 0.5f);
	return stilb_vec3_make(light * 0.93f, light, light * 1.12f);
}

/* The share of a pixel, 0..1, that lies inside a circle; distance is that between their centres. All in pixels; good
 * for radii of many pixels, where the edge is nearly straight. */
static float circle_coverage(float distance, float radius)
{
	return fminf(fmaxf(radius - distance + 0.5f, 0.0f), 1.0f);
}

static stilb_vec3 shown(const painting *p, stilb_vec3 radiance)
{
	return p->tone_mapped ? shade_tonemap(radiance, SHADE_TONEMAP_A, SHADE_TONEMAP_B) : radiance;
}

/* The colour of a pixel on a sphere. Its samples are tone mapped before they are averaged, so that a single very bright
 * one does not hide the others: edges of highlights stay smooth. */
static stilb_vec3 sphere_color(const painting *p, const cell *c, float x, float y, float radius)
{
	stilb_vec3 sum = stilb_vec3_make(0.0f, 0.0f, 0.0f);
	for (int i = 0; i < SUBSAMPLES * SUBSAMPLES; i++) {
		int column = i % SUBSAMPLES, row = i / SUBSAMPLES;
		float sx = x - 0.5f + ((float)column + 0.5f) / SUBSAMPLES;
		float sy = y - 0.5f + ((float)row + 0.5f) / SUBSAMPLES;
		sum += shown(p, sphere_radiance(&p->world, c, (strip_place){sx / radius, -sy / radius, 1.0f / radius}));
	}
	return sum * (1.0f / (SUBSAMPLES * SUBSAMPLES));
}

static stilb_vec3 pixel_color(const painting *p, float x, float y)
{
	stilb_vec3 color = shown(p, backdrop(p, x, y));
	float column = (x - p->place.left) / p->place.cell, row = (y - p->place.top) / p->place.row;
	if (column < 0.0f || row < 0.0f || column >= (float)p->s->column_count || row >= (float)p->s->row_count)
		return color;
	float center_x = p->place.left + (floorf(column) + 0.5f) * p->place.cell;
	float center_y = p->place.top + floorf(row) * p->place.row + 0.5f * p->place.cell;
	float radius = SPHERE_RADIUS * p->place.cell;
	float coverage = circle_coverage(hypotf(x - center_x, y - center_y), radius);
	if (coverage > 0.0f)
		color +=
			(sphere_color(p, &p->cells[(int)row][(int)column], x - center_x, y - center_y, radius) - color) * coverage;
	return color;
}

static void paint_lines(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	const painting *p = context;
	for (uint32_t y = begin; y < end; y++)
		for (uint32_t x = 0; x < p->picture->width; x++) {
			stilb_vec3 color = pixel_color(p, (float)x + 0.5f, (float)y + 0.5f);
			float *pixel = (float *)p->picture->pixels + 3 * ((size_t)y * p->picture->width + x);
			for (int k = 0; k < 3; k++)
				pixel[k] = color[k];
		}
}

/* ---- words ------------------------------------------------------------------------------------------------------- */

static stilb_result write_words(const painting *p, lettering *letters,
                                strip_words words[STRIP_ROWS_MAX][STRIP_COLUMNS_MAX])
{
	stilb_ui_color bright = stilb_ui_rgb(0xe8e8e8), soft = stilb_ui_rgb(0xb4b8c0);
	const layout *at = &p->place;
	float edge = at->left - (CAPTION_WIDTH - MARGIN) * at->cell, gap = 0.1f * at->cell;
	float right = at->left + (float)p->s->column_count * at->cell;
	stilb_ui_rect title = {edge, at->top - TITLE_HEIGHT * at->cell, right, at->top};
	stilb_result result =
		lettering_write(letters, p->picture, STILB_UI_TEXT_STRONG, title, STILB_UI_ALIGN_LEFT, bright, p->s->title);
	for (int r = 0; r < p->s->row_count && result == STILB_OK; r++) {
		float top = at->top + (float)r * at->row;
		stilb_ui_rect caption = {edge, top, at->left - gap, top + at->cell};
		result = lettering_write(letters, p->picture, STILB_UI_TEXT_NORMAL, caption, STILB_UI_ALIGN_LEFT, bright,
		                         p->s->rows[r].caption);
		for (int c = 0; c < p->s->column_count && result == STILB_OK; c++) {
			float left = at->left + (float)c * at->cell;
			stilb_ui_rect number = {left, top + at->cell, left + at->cell,
			                        top + at->cell * (1.0f + 0.8f * NUMBER_HEIGHT)};
			result = lettering_write(letters, p->picture, STILB_UI_TEXT_SMALL, number, STILB_UI_ALIGN_CENTER, soft,
			                         words[r][c]);
		}
	}
	return result;
}

/* Writes the texts in letters that grow with the spheres; leaves them out if they would be too small to read. */
static stilb_result write_captions(const painting *p, strip_words words[STRIP_ROWS_MAX][STRIP_COLUMNS_MAX])
{
	float scale = p->place.cell / 100.0f;
	if (scale < 0.5f)
		return STILB_OK;
	lettering *letters;
	stilb_result result = lettering_create(fminf(scale, 4.0f), &letters);
	if (result == STILB_OK)
		result = write_words(p, letters, words);
	lettering_destroy(letters);
	return result;
}

static void make_cell(painting *p, int row, int column, char *words)
{
	cell *c = &p->cells[row][column];
	p->s->rows[row].make(&p->s->rows[row], column, &c->sphere, words);
	for (int i = 0; i < LAMPS; i++)
		c->lamps[i] = lamp_divide(&p->world.lamps[i], &c->sphere);
}

static stilb_result paint(painting *p, stilb_job_pool *pool)
{
	strip_words words[STRIP_ROWS_MAX][STRIP_COLUMNS_MAX];
	for (int r = 0; r < p->s->row_count; r++)
		for (int c = 0; c < p->s->column_count; c++)
			make_cell(p, r, c, words[r][c]);
	stilb_job_parallel_for(pool, p->picture->height, 4, paint_lines, p, 0);
	return write_captions(p, words);
}

stilb_result strip_draw(const strip *s, stilb_image *picture, bool tone_mapped, stilb_job_pool *pool)
{
	STILB_ASSERT(s->row_count <= STRIP_ROWS_MAX && s->column_count <= STRIP_COLUMNS_MAX);
	STILB_ASSERT(picture->channels == 3 && picture->format == STILB_IMAGE_F32_LINEAR);
	painting *p = stilb_memory_alloc(1, sizeof *p);
	if (!p)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a strip of spheres");
	p->s = s;
	p->picture = picture;
	p->place = layout_of(s, picture);
	p->world = studio();
	p->tone_mapped = tone_mapped && !s->tone_mapped;
	stilb_result result = s->prepare ? s->prepare() : STILB_OK;
	if (result == STILB_OK)
		result = paint(p, pool);
	if (s->finish)
		s->finish();
	free(p);
	return result;
}
