#include "render/render_panorama.h"

#include "base/base.h"
#include "base/base_contract.h"
#include "profiler/prof.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define CELLS_ACROSS 64u
#define CELLS_DOWN 32u
#define CELL_COUNT (CELLS_ACROSS * CELLS_DOWN)
#define CELL_WIDTH ((float)M_PI / CELLS_DOWN) /* radians */
#define CELL_POINTS 4u                        /* that a cell is read with along a side, at least */
#define LAMP_SHARE 0.005                      /* of all light: less is no lamp */
#define LAMP_SPREAD 0.25                      /* of an evenly lit cell's spread: more is no lamp */
#define VALUE_MAX 1e15f                       /* brighter texels count as this, as for rays */
#define HALF_MAX 65504.0f

typedef float panorama_v4 __attribute__((vector_size(16)));
typedef int32_t panorama_i4 __attribute__((vector_size(16)));

typedef struct panorama_cell {
	double irradiance[3]; /* sum of L dw */
	double toward[3];     /* sum of brightness dw times direction */
	double brightness;    /* sum of brightness dw */
} panorama_cell;

/* A cell of the table's sum: mean direction, irradiance across the beam. */
typedef struct panorama_source {
	float direction[3], irradiance[3];
} panorama_source;

typedef struct panorama_work {
	const stilb_image *map;
	render_panorama *out;
	panorama_cell cells[CELL_COUNT];
	panorama_source sources[CELL_COUNT];
	uint32_t source_count;
	uint32_t across, down; /* points that the panorama is read with */
	double *column;        /* [2 * across] sine and cosine of each column's longitude */
} panorama_work;

bool render_panorama_is_good(const stilb_image *panorama)
{
	return panorama->pixels && panorama->format == STILB_IMAGE_F32_LINEAR && panorama->channels >= 3;
}

uint64_t render_panorama_key(const stilb_image *panorama)
{
	uint64_t texels = (uint64_t)panorama->width * panorama->height, step = texels / 251 + 1;
	uint32_t size[3] = {panorama->width, panorama->height, panorama->channels};
	uint64_t hash = stilb_hash_fnv1a64(STILB_FNV1A64_START, size, sizeof size);
	for (uint64_t i = 0; i < texels; i += step)
		hash = stilb_hash_fnv1a64(hash, (const float *)panorama->pixels + i * panorama->channels, sizeof(float[3]));
	return hash | 1;
}

void render_panorama_turn(const float own[3], float rotation, float world[3])
{
	float s = sinf(rotation), c = cosf(rotation);
	float turned[3] = {c * own[0] + s * own[2], own[1], c * own[2] - s * own[0]};
	memcpy(world, turned, sizeof turned);
}

void render_panorama_finish(render_panorama *panorama)
{
	free(panorama->texels);
	*panorama = (render_panorama){0};
}

static float panorama_valid(float value)
{
	return value > 0.0f ? value < VALUE_MAX ? value : VALUE_MAX : 0.0f; /* a NaN is 0 */
}

static const float *panorama_texel(const stilb_image *map, uint32_t x, uint32_t y)
{
	return (const float *)map->pixels + ((size_t)y * map->width + x) * map->channels;
}

static void panorama_loop(stilb_job_pool *pool, uint32_t count, stilb_job_range_fn *run, void *context, uint32_t worker)
{
	if (pool)
		stilb_job_parallel_for(pool, count, 1, run, context, worker);
	else
		run(0, count, 0, context);
}

/* ---- cells ------------------------------------------------------------------------------------------------------- */

/* Adds a point of the panorama, whose solid angle is that of the texel or part of one, to its cell. */
static void panorama_add(panorama_cell *cell, const float texel[3], const double direction[3], double solid)
{
	double light[3];
	for (int c = 0; c < 3; c++)
		light[c] = (double)panorama_valid(texel[c]) * solid;
	double brightness = 0.2126 * light[0] + 0.7152 * light[1] + 0.0722 * light[2];
	cell->brightness += brightness;
	for (int c = 0; c < 3; c++) {
		cell->irradiance[c] += light[c];
		cell->toward[c] += brightness * direction[c];
	}
}

/* The first row of points whose middle is in this row of cells or below. */
static uint32_t panorama_first(const panorama_work *work, uint32_t cell)
{
	return (uint32_t)(((uint64_t)cell * work->down * 2 + CELLS_DOWN - 1) / (2 * (uint64_t)CELLS_DOWN));
}

/* Rows of cells; each worker writes those of its rows alone. */
static void panorama_read(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	panorama_work *work = context;
	(void)worker;
	uint32_t per_texel = work->across / work->map->width, per_row = work->down / work->map->height;
	for (uint32_t cell = begin; cell < end; cell++)
		for (uint32_t j = panorama_first(work, cell); j < panorama_first(work, cell + 1); j++) {
			double theta = M_PI * (j + 0.5) / work->down, height = cos(theta), sine = sin(theta);
			double solid =
				2.0 * M_PI / work->across * (cos(M_PI * j / work->down) - cos(M_PI * (j + 1.0) / work->down));
			for (uint32_t i = 0; i < work->across; i++) {
				double direction[3] = {sine * work->column[2 * (size_t)i], height,
				                       -sine * work->column[2 * (size_t)i + 1]};
				uint32_t across = (uint32_t)((2 * (uint64_t)i + 1) * CELLS_ACROSS / (2 * (uint64_t)work->across));
				panorama_add(&work->cells[cell * CELLS_ACROSS + across],
				             panorama_texel(work->map, i / per_texel, j / per_row), direction, solid);
			}
		}
}

/* A multiple of the side in texels with some points in each cell: each texel is read with as many. */
static uint32_t panorama_points(uint32_t side, uint32_t cells)
{
	return side * ((CELL_POINTS * cells + side - 1) / side);
}

/* ---- lamps ------------------------------------------------------------------------------------------------------- */

/* The length of the sum of directions, as a share of what it is without any spread. */
static double panorama_length(const panorama_cell *cell)
{
	const double *t = cell->toward;
	return sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]) / cell->brightness;
}

/* Takes the brightest cell that shines from one place out of the cells; false: there is none. */
static bool panorama_take_lamp(panorama_work *work, double least)
{
	panorama_cell *found = NULL;
	for (uint32_t i = 0; i < CELL_COUNT; i++) {
		panorama_cell *cell = &work->cells[i];
		/* An evenly lit cell of width a has the mean of 1 - cos about its middle, a^2 / 12. */
		double even = (double)CELL_WIDTH * (double)CELL_WIDTH / 12.0;
		if (cell->brightness > least && (!found || cell->brightness > found->brightness) &&
		    1.0 - panorama_length(cell) < LAMP_SPREAD * even)
			found = cell;
	}
	if (!found)
		return false;
	render_panorama_lamp *lamp = &work->out->lamps[work->out->lamp_count++];
	double length = panorama_length(found);
	for (int c = 0; c < 3; c++) {
		lamp->direction[c] = (float)(found->toward[c] / (found->brightness * length));
		lamp->irradiance[c] = (float)(found->irradiance[c] * length);
	}
	*found = (panorama_cell){0};
	return true;
}

static void panorama_find_lamps(panorama_work *work)
{
	double all = 0.0;
	for (uint32_t i = 0; i < CELL_COUNT; i++)
		all += work->cells[i].brightness;
	work->out->lamp_count = 0;
	while (work->out->lamp_count < RENDER_PANORAMA_LAMPS && panorama_take_lamp(work, LAMP_SHARE * all))
		;
	work->source_count = 0;
	for (uint32_t i = 0; i < CELL_COUNT; i++) {
		const panorama_cell *cell = &work->cells[i];
		if (!(cell->brightness > 0.0))
			continue;
		panorama_source *source = &work->sources[work->source_count++];
		for (int c = 0; c < 3; c++) {
			source->direction[c] = (float)(cell->toward[c] / cell->brightness);
			source->irradiance[c] = (float)cell->irradiance[c];
		}
	}
}

/* ---- the table --------------------------------------------------------------------------------------------------- */

static panorama_v4 panorama_clamp(panorama_v4 x, float low, float high)
{
	panorama_v4 lows = {low, low, low, low}, highs = {high, high, high, high};
	panorama_i4 below = x<lows, above = x> highs;
	x = (panorama_v4)(((panorama_i4)x & ~below) | ((panorama_i4)lows & below));
	return (panorama_v4)(((panorama_i4)x & ~above) | ((panorama_i4)highs & above));
}

/* Irradiance of four normals at once, x, y, z. The cosine of a cell across the horizon is its mean over a cell's width
 * of what is above: t^2 / 2a, t = cosine + a / 2; below 0, above the cosine itself. */
static void panorama_sum(const panorama_work *work, const panorama_v4 normal[3], panorama_v4 sum[3])
{
	for (int c = 0; c < 3; c++)
		sum[c] = (panorama_v4){0.0f, 0.0f, 0.0f, 0.0f};
	for (uint32_t i = 0; i < work->source_count; i++) {
		const panorama_source *s = &work->sources[i];
		panorama_v4 cosine = normal[0] * s->direction[0] + normal[1] * s->direction[1] + normal[2] * s->direction[2];
		panorama_v4 t = panorama_clamp(cosine + 0.5f * CELL_WIDTH, 0.0f, CELL_WIDTH);
		panorama_v4 seen = t * t * (0.5f / CELL_WIDTH) + panorama_clamp(cosine - 0.5f * CELL_WIDTH, 0.0f, 2.0f);
		for (int c = 0; c < 3; c++)
			sum[c] += seen * s->irradiance[c];
	}
}

static void panorama_fill(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	panorama_work *work = context;
	(void)worker;
	for (uint32_t y = begin; y < end; y++) {
		double theta = M_PI * y / (RENDER_PANORAMA_ROWS - 1), height = cos(theta), sine = sin(theta);
		for (uint32_t x = 0; x < RENDER_PANORAMA_COLUMNS; x += 4) {
			panorama_v4 normal[3], sum[3];
			float lanes[3][4];
			for (uint32_t k = 0; k < 4; k++) {
				double phi = 2.0 * M_PI * ((double)(x + k) / RENDER_PANORAMA_COLUMNS - 0.5);
				lanes[0][k] = (float)(sine * sin(phi));
				lanes[1][k] = (float)height;
				lanes[2][k] = (float)(-sine * cos(phi));
			}
			memcpy(normal, lanes, sizeof normal);
			panorama_sum(work, normal, sum);
			for (uint32_t k = 0; k < 4; k++)
				for (int c = 0; c < 4; c++)
					work->out->table[y][x + k][c] = c < 3 ? sum[c][k] : 0.0f;
		}
	}
}

/* ---- texels ------------------------------------------------------------------------------------------------------ */

/* The half float nearest to a value in [0, HALF_MAX]. */
static uint16_t panorama_half(float value)
{
	union {
		float f;
		uint32_t u;
	} bits = {.f = value};
	if (value < 6.103515625e-5f) /* 2^-14: steps of 2^-24 below it */
		return (uint16_t)(value * 16777216.0f + 0.5f);
	uint32_t rounded = bits.u + 0xfff + (bits.u >> 13 & 1);
	return (uint16_t)((rounded >> 13) - (112u << 10));
}

static void panorama_shrink(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	panorama_work *work = context;
	const stilb_image *map = work->map;
	render_panorama *out = work->out;
	(void)worker;
	for (uint32_t y = begin; y < end; y++)
		for (uint32_t x = 0; x < out->width; x++) {
			uint32_t left = (uint32_t)((uint64_t)x * map->width / out->width);
			uint32_t right = (uint32_t)((uint64_t)(x + 1) * map->width / out->width);
			uint32_t top = (uint32_t)((uint64_t)y * map->height / out->height);
			uint32_t bottom = (uint32_t)((uint64_t)(y + 1) * map->height / out->height);
			float sum[3] = {0.0f, 0.0f, 0.0f}, count = (float)((right - left) * (bottom - top));
			for (uint32_t v = top; v < bottom; v++)
				for (uint32_t u = left; u < right; u++)
					for (int c = 0; c < 3; c++)
						sum[c] += panorama_valid(panorama_texel(map, u, v)[c]);
			uint16_t *texel = out->texels[(size_t)y * out->width + x];
			for (int c = 0; c < 3; c++)
				texel[c] = panorama_half(fminf(sum[c] / count, HALF_MAX));
			texel[3] = 0;
		}
}

/* ---- all of it --------------------------------------------------------------------------------------------------- */

static bool panorama_prepare(panorama_work *work)
{
	const stilb_image *map = work->map;
	render_panorama *out = work->out;
	work->across = panorama_points(map->width, CELLS_ACROSS);
	work->down = panorama_points(map->height, CELLS_DOWN);
	out->width = map->width < RENDER_PANORAMA_WIDTH ? map->width : RENDER_PANORAMA_WIDTH;
	out->height = map->height < RENDER_PANORAMA_HEIGHT ? map->height : RENDER_PANORAMA_HEIGHT;
	work->column = stilb_memory_alloc(2 * (size_t)work->across, sizeof *work->column);
	out->texels = stilb_memory_alloc((size_t)out->width * out->height, sizeof *out->texels);
	if (!work->column || !out->texels)
		return false;
	for (uint32_t i = 0; i < work->across; i++) {
		double phi = 2.0 * M_PI * ((i + 0.5) / work->across - 0.5);
		work->column[2 * (size_t)i] = sin(phi);
		work->column[2 * (size_t)i + 1] = cos(phi);
	}
	return true;
}

stilb_result render_panorama_update(render_panorama *out, const stilb_image *panorama, stilb_job_pool *pool,
                                    uint32_t worker)
{
	STILB_ASSERT(render_panorama_is_good(panorama));
	uint64_t key = render_panorama_key(panorama);
	if (out->key == key && out->pixels == panorama->pixels)
		return STILB_OK;
	PROFILE("panorama");
	uint32_t version = out->version;
	render_panorama_finish(out);
	out->version = version + 1;
	panorama_work *work = stilb_memory_alloc(1, sizeof *work);
	if (work)
		*work = (panorama_work){.map = panorama, .out = out};
	bool good = work && panorama_prepare(work);
	if (good) {
		panorama_loop(pool, CELLS_DOWN, panorama_read, work, worker);
		panorama_find_lamps(work);
		panorama_loop(pool, RENDER_PANORAMA_ROWS, panorama_fill, work, worker);
		panorama_loop(pool, out->height, panorama_shrink, work, worker);
		out->key = key;
		out->pixels = panorama->pixels;
	}
	if (work)
		free(work->column);
	free(work);
	return good ? STILB_OK
	            : stilb_fail(STILB_ERROR_MEMORY, "no memory for the light of a panorama of %u x %u texels",
	                         panorama->width, panorama->height);
}
