/* A panorama's way to what frames need of it: reading its cells, shrinking its texels, and the order of all stages. */
#include "render/render_panorama.h"

#include "base/base.h"
#include "base/base_contract.h"
#include "profiler/prof.h"
#include "render/panorama/render_panorama_work.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define HALF_MAX 65504.0f  /* of half floats */
#define PIECE 1024u        /* texels of a row that are read together; four times as many floats are on the stack */
#define SLICE 1500000.0    /* cost of a frame's share, in texels read: some 3 ms of one thread */
#define SUM_COST 20000.0   /* of a row of sums */
#define TABLE_COST 40000.0 /* of a row of the table */
#define LAMPS_COST 1000000.0
#define AMBIENT_COST 900000.0
#define FIND_COST 500000.0 /* of looking for the gloss on disk */

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

/* ---- cells ------------------------------------------------------------------------------------------------------- */

static void read_add_four(float *sums, const float *values, size_t count, float factor)
{
	panorama_v4 value = {0.0f, 0.0f, 0.0f, 0.0f}, sum;
	memcpy(&value, values, count * sizeof(float));
	memcpy(&sum, sums, sizeof sum);
	sum += panorama_valid(value) * factor;
	memcpy(sums, &sum, sizeof sum);
}

/* Adds values times factor to sums: count floats, and zeros to up to 3 more. */
static void read_add(float *sums, const float *values, uint32_t count, float factor)
{
	uint32_t fours = count / 4 * 4;
	for (uint32_t i = 0; i < fours; i += 4)
		read_add_four(sums + i, values + i, 4, factor);
	if (count > fours)
		read_add_four(sums + fours, values + fours, count - fours, factor);
}

/* Gives the light of texels first .. first + count - 1 of a row, of which `sums` has count * channels numbers, to the
 * cells of a row, each by the share of its width. */
static void read_spread(const stilb_image *map, uint32_t first, uint32_t count, const float *sums,
                        float cells[PANORAMA_ACROSS][3])
{
	for (uint32_t x = first; x < first + count; x++, sums += map->channels) {
		uint64_t begin = (uint64_t)x * PANORAMA_ACROSS, end = begin + PANORAMA_ACROSS; /* in 1 / width of a cell */
		while (begin < end) {
			uint64_t cell = begin / map->width, next = (cell + 1) * map->width;
			float share = (float)((next < end ? next : end) - begin) * (1.0f / PANORAMA_ACROSS);
			for (int c = 0; c < 3; c++)
				cells[cell][c] += sums[c] * share;
			begin = next;
		}
	}
}

static void read_row(render_panorama_work *work, uint32_t row)
{
	const stilb_image *map = &work->map;
	uint32_t first = (uint32_t)((uint64_t)row * map->height / PANORAMA_DOWN);
	uint32_t end = (uint32_t)(((uint64_t)(row + 1) * map->height + PANORAMA_DOWN - 1) / PANORAMA_DOWN);
	memset(work->cells[row], 0, sizeof work->cells[row]);
	for (uint32_t x = 0; x < map->width; x += PIECE) {
		float sums[4 * PIECE + 4] = {0};
		uint32_t count = map->width - x < PIECE ? map->width - x : PIECE;
		for (uint32_t y = first; y < end; y++) {
			panorama_overlap part = panorama_overlap_of(y, map->height, row, PANORAMA_DOWN);
			double solid = 2.0 * M_PI / map->width * (cos(M_PI * part.begin) - cos(M_PI * part.end));
			if (part.end > part.begin)
				read_add(sums, panorama_texel(map, x, y), count * map->channels, (float)solid);
		}
		read_spread(map, x, count, sums, work->cells[row]);
	}
}

/* ---- texels ------------------------------------------------------------------------------------------------------ */

typedef uint32_t shrink_u4 __attribute__((vector_size(16)));

/* The half floats nearest to values in [0, HALF_MAX], as numbers. */
static panorama_i4 shrink_half(panorama_v4 values)
{
	panorama_v4 least = {0x1p-14f, 0x1p-14f, 0x1p-14f, 0x1p-14f}; /* steps of 2^-24 below it */
	panorama_i4 low = values < least;
	shrink_u4 wide = (shrink_u4)values; /* the exponent and 23 bits behind it, of which 10 stay */
	panorama_i4 normal = (panorama_i4)((wide + 0xfff + (wide / 8192 & 1)) / 8192 - (112 << 10));
	panorama_i4 small = __builtin_convertvector(values * 0x1p24f + 0.5f, panorama_i4);
	return (normal & ~low) | (small & low);
}

/* A texel and whatever lies behind it, which there is nothing of at the panorama's end. */
static panorama_v4 shrink_load(const stilb_image *map, uint32_t x, uint32_t y)
{
	const float *texel = panorama_texel(map, x, y);
	panorama_v4 value;
	if (x + 1 == map->width && y + 1 == map->height)
		return (panorama_v4){texel[0], texel[1], texel[2], 0.0f};
	memcpy(&value, texel, sizeof value);
	return value;
}

static void shrink_row(render_panorama_work *work, uint32_t y)
{
	const stilb_image *map = &work->map;
	uint32_t top = (uint32_t)((uint64_t)y * map->height / work->height);
	uint32_t bottom = (uint32_t)((uint64_t)(y + 1) * map->height / work->height);
	panorama_v4 most = {HALF_MAX, HALF_MAX, HALF_MAX, HALF_MAX};
	for (uint32_t x = 0; x < work->width; x++) {
		uint32_t left = (uint32_t)((uint64_t)x * map->width / work->width);
		uint32_t right = (uint32_t)((uint64_t)(x + 1) * map->width / work->width);
		panorama_v4 sum = {0.0f, 0.0f, 0.0f, 0.0f};
		for (uint32_t v = top; v < bottom; v++)
			for (uint32_t u = left; u < right; u++)
				sum += panorama_valid(shrink_load(map, u, v));
		sum /= (float)((right - left) * (bottom - top));
		panorama_i4 beyond = sum > most;
		panorama_i4 half = shrink_half((panorama_v4)(((panorama_i4)sum & ~beyond) | ((panorama_i4)most & beyond)));
		uint16_t texel[4] = {(uint16_t)half[0], (uint16_t)half[1], (uint16_t)half[2], 0};
		memcpy(work->texels[(size_t)y * work->width + x], texel, sizeof texel);
	}
}

/* ---- stages ------------------------------------------------------------------------------------------------------ */

static void stage_read(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	for (uint32_t row = begin; row < end; row++)
		read_row(context, row);
}

static void stage_shrink(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	for (uint32_t row = begin; row < end; row++)
		shrink_row(context, row);
}

static void stage_ambient(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)begin, (void)end, (void)worker;
	render_panorama_find_ambient(context);
}

static void stage_lamps(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)begin, (void)end, (void)worker;
	render_panorama_find_lamps(context);
}

static void stage_sum(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	render_panorama_sum_rows(context, begin, end);
}

static void stage_fill(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	render_panorama_fill_rows(context, begin, end);
}

static void stage_find(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)begin, (void)end, (void)worker;
	render_panorama_work *work = context;
	work->kept = render_panorama_cache_find(work);
}

/* Rows of a stage, which each reads what the stages before it wrote, and their cost. */
typedef struct panorama_stage {
	stilb_job_range_fn *run;
	uint32_t rows, grain;
	double cost;
} panorama_stage;

#define LIGHT_STAGES 7u
#define STAGES (LIGHT_STAGES + PANORAMA_GLOSS_STAGES)

static void stage_gloss(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	render_panorama_work *work = context;
	render_panorama_gloss_run(work, work->stage - LIGHT_STAGES, begin, end);
}

static panorama_stage stage_of(const render_panorama_work *work, uint32_t stage)
{
	double texels = (double)work->map.width * work->map.height;
	panorama_stage stages[LIGHT_STAGES] = {
		{stage_read, PANORAMA_DOWN, 1, texels / PANORAMA_DOWN},
		{stage_shrink, work->height, 8, (texels + (double)work->width * work->height) / work->height},
		{stage_lamps, 1, 1, LAMPS_COST},
		{stage_ambient, 1, 1, AMBIENT_COST},
		{stage_sum, PANORAMA_DOWN, 16, SUM_COST},
		{stage_fill, RENDER_PANORAMA_ROWS, 8, TABLE_COST},
		{stage_find, 1, 1, FIND_COST},
	};
	if (stage < LIGHT_STAGES)
		return stages[stage];
	panorama_stage gloss = {.run = stage_gloss, .grain = 1};
	gloss.rows = render_panorama_gloss_rows(work, stage - LIGHT_STAGES, &gloss.cost);
	return gloss;
}

/* A stage's rows from `first` on, for the workers of a loop, which counts from 0. */
typedef struct panorama_rows {
	render_panorama_work *work;
	stilb_job_range_fn *run;
	uint32_t first;
} panorama_rows;

static void panorama_run(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const panorama_rows *rows = context;
	rows->run(rows->first + begin, rows->first + end, worker, rows->work);
}

/* Does the next rows, at most as many as the budget allows, but one at least. True: all stages are done. */
static bool panorama_advance(render_panorama_work *work, double budget, stilb_job_pool *pool, uint32_t worker)
{
	while (work->stage < STAGES && budget > 0.0) {
		panorama_stage stage = stage_of(work, work->stage);
		double afford = budget / stage.cost + 1.0;
		uint32_t left = stage.rows - work->row, count = afford < left ? (uint32_t)afford : left;
		panorama_rows rows = {work, stage.run, work->row};
		if (pool && count > 0)
			stilb_job_parallel_for(pool, count, stage.grain, panorama_run, &rows, worker);
		else
			panorama_run(0, count, 0, &rows);
		budget -= count * stage.cost;
		work->row += count;
		if (work->row == stage.rows) {
			work->row = 0;
			work->stage++;
		}
	}
	return work->stage == STAGES;
}

/* ---- all of it --------------------------------------------------------------------------------------------------- */

static void panorama_give_up(render_panorama *panorama)
{
	if (!panorama->next)
		return;
	render_panorama_gloss_end(panorama->next);
	free(panorama->next->cells);
	free(panorama->next->sums);
	free(panorama->next);
	panorama->next = NULL;
}

static bool panorama_begin(render_panorama *out, const stilb_image *map, uint64_t key, render_panorama_memory memory)
{
	render_panorama_work *work = stilb_memory_alloc(1, sizeof *work);
	out->next = work;
	if (!work)
		return false;
	*work = (render_panorama_work){.map = *map, .key = key};
	work->width = map->width < RENDER_PANORAMA_WIDTH ? map->width : RENDER_PANORAMA_WIDTH;
	work->height = map->height < RENDER_PANORAMA_HEIGHT ? map->height : RENDER_PANORAMA_HEIGHT;
	work->cells = stilb_memory_alloc(PANORAMA_DOWN, sizeof *work->cells);
	work->sums = stilb_memory_alloc(PANORAMA_DOWN, sizeof *work->sums);
	if (!out->dfg)
		out->dfg = stilb_memory_alloc(RENDER_PANORAMA_DFG, sizeof *out->dfg);
	work->dfg = out->dfg;
	work->dfg_shown = out->dfg_shown;
	if (work->cells && work->sums && work->dfg)
		work->light = memory.make(memory.user, RENDER_PANORAMA_BYTES(work->width, work->height));
	if (!work->light || !render_panorama_gloss_begin(work)) {
		panorama_give_up(out);
		return false;
	}
	work->texels = (uint16_t(*)[4])(void *)(work->light + 1);
	return true;
}

static stilb_result panorama_take(render_panorama *out, render_panorama_memory memory)
{
	const render_panorama_work *work = out->next;
	render_panorama_gloss gloss = {.cube = work->cube,
	                               .dfg = out->dfg_shown ? NULL : work->dfg,
	                               .light = work->light,
	                               .texels = (const uint16_t(*)[4])work->texels,
	                               .width = work->width,
	                               .height = work->height};
	stilb_result result = memory.show(memory.user, &gloss);
	out->dfg_shown |= result == STILB_OK;
	if (result != STILB_OK) {
		panorama_give_up(out);
		out->key = 0;
		return result;
	}
	if (!work->kept)
		render_panorama_cache_keep(work);
	out->key = work->key;
	out->pixels = work->map.pixels;
	out->width = work->width;
	out->height = work->height;
	out->lamp_count = work->lamp_count;
	memcpy(out->lamps, work->lamps, sizeof out->lamps);
	out->around = work->around;
	panorama_give_up(out);
	return STILB_OK;
}

stilb_result render_panorama_update(render_panorama *out, const stilb_image *panorama, render_panorama_memory memory,
                                    bool sliced, stilb_job_pool *pool, uint32_t worker)
{
	STILB_ASSERT(render_panorama_is_good(panorama));
	uint64_t key = render_panorama_key(panorama);
	bool same = out->next && out->next->key == key && out->next->map.pixels == panorama->pixels;
	if (!same)
		panorama_give_up(out);
	if (out->key == key && out->pixels == panorama->pixels)
		return STILB_OK;
	PROFILE("panorama");
	if (!same && !panorama_begin(out, panorama, key, memory)) {
		out->key = 0;
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the light of a panorama of %u x %u texels",
		                  panorama->width, panorama->height);
	}
	if (panorama_advance(out->next, sliced ? SLICE : (double)INFINITY, pool, worker))
		return panorama_take(out, memory);
	return STILB_OK;
}

void render_panorama_renew(render_panorama *panorama)
{
	panorama_give_up(panorama);
	panorama->pixels = NULL;
}

void render_panorama_leave(render_panorama *panorama)
{
	panorama_give_up(panorama);
	if (!panorama->pixels)
		panorama->key = 0;
}

bool render_panorama_shows(const render_panorama *panorama, const stilb_image *map)
{
	const void *pixels = panorama->next ? panorama->next->map.pixels : panorama->pixels;
	return panorama->key != 0 && render_panorama_is_good(map) && pixels == map->pixels;
}

void render_panorama_finish(render_panorama *panorama)
{
	panorama_give_up(panorama);
	free(panorama->dfg);
	*panorama = (render_panorama){0};
}
