/*
 * The overture: fills the irradiance cache with records for the surfaces that the picture shows, before it is rendered.
 *
 * Strips.    Pixels are looked at in levels: every 32nd pixel of every 32nd row first, then those between, finer and
 *            finer; each level in strips, sets of rows that are far apart. A pixel whose surface no record covers is a
 *            missing pixel: it is missing a record.
 * Rounds.    FROZEN: for some of the missing pixels, far from one another, a record each is gathered, as jobs; the
 *            records are added in the order in which the pixels were chosen; then all missing pixels are tested again
 *            for a record. The choice does not depend on the number of workers, so neither do the records.
 *            LIVE: a job that finds a pixel missing a record gathers one at once.
 */
#include "gi/cache/gi_cache_fill.h"

#include "gi/cache/gi_cache_file.h"
#include "gi/cache/gi_cache_gather.h"
#include "gi/film/gi_camera.h"
#include "gi/trace/gi_through.h"
#include "profiler/prof.h"

#include <stdlib.h>
#include <string.h>

#define FIRST_BLOCK 32u  /* the first level has every 32nd pixel of every 32nd row */
#define STRIP 8192u      /* pixels in a strip, about */
#define ROUND_LEAST 16u  /* records in a round at least, if so many pixels are missing one */
#define ROUND_SHARE 8u   /* records in a round: one for so many that exist, */
#define ROUND_MOST 1024u /* at most */
/* A round begins when at least so many pixels are missing a record; with fewer the next strip is looked at first. */
#define ROUND_WORTH 32u
#define SPACING 8 /* least distance, in pixels along x or y, of any two pixels that get a record in one round */
/* A record covers a pixel in the overture if its error there (gi_cache_record_error) is below this. It is below 1,
 * where a record ceases to be valid, so that the pixels between those looked at are still covered. */
#define REACH 0.8f

typedef struct fill_pixel {
	gi_surface surface;
	uint32_t x, y;
	bool missing; /* no record covers it */
} fill_pixel;

struct gi_cache_fill {
	gi_cache *cache;
	stilb_job_pool *pool;
	gi_camera camera;
	uint32_t block, strip; /* the next strip to look at, in the level of every block-th pixel; block 0: all are done */
	uint32_t count, capacity; /* of the array pixels */
	fill_pixel *pixels;       /* those that are missing a record */
	gi_cache_record *records; /* [ROUND_MOST] of one round; NULL: no overture is wanted */
	uint64_t looked;          /* pixels looked at so far */
	/* For gi_cache_fill_progress: number of the round, and share that is done. Written by gi_cache_fill_run alone;
	 * relaxed: they are for display, and order nothing. */
	_Atomic uint32_t round;
	_Atomic float done;
};

/* ---- life cycle -------------------------------------------------------------------------------------------------- */

static stilb_result fill_make(gi_cache_fill *fill, const gi_view *view)
{
	const stilb_gi_cache_settings *settings = &view->settings.cache;
	if (settings->mode == STILB_GI_CACHE_FROZEN && !settings->overture && !settings->load)
		return stilb_fail(STILB_ERROR_ARGUMENT, "a frozen cache without an overture stays empty: take the live mode, "
		                                        "or load a cache");
	stilb_result result = gi_cache_create(view, stilb_job_pool_worker_count(fill->pool) + 1u, &fill->cache);
	if (result == STILB_OK && settings->load)
		result = gi_cache_load(fill->cache, settings->load);
	if (result != STILB_OK || !settings->overture)
		return result;
	fill->block = FIRST_BLOCK;
	fill->records = stilb_memory_alloc(ROUND_MOST, sizeof(*fill->records));
	return fill->records ? STILB_OK : stilb_fail(STILB_ERROR_MEMORY, "no memory for the irradiance cache's overture");
}

stilb_result gi_cache_fill_create(const gi_view *view, stilb_job_pool *pool, gi_cache_fill **out)
{
	STILB_ASSERT(view && pool && out);
	*out = NULL;
	const stilb_gi_settings *settings = &view->settings;
	gi_cache_fill *fill = stilb_memory_alloc(1, sizeof(*fill));
	if (!fill)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the irradiance cache");
	*fill = (gi_cache_fill){
		.pool = pool, .camera = gi_camera_make(&settings->camera, &settings->lens, settings->width, settings->height)};
	stilb_result result = fill_make(fill, view);
	if (result == STILB_OK)
		*out = fill;
	else
		gi_cache_fill_destroy(fill);
	return result;
}

void gi_cache_fill_destroy(gi_cache_fill *fill)
{
	if (!fill)
		return;
	gi_cache_destroy(fill->cache);
	free(fill->pixels);
	free(fill->records);
	free(fill);
}

gi_cache *gi_cache_fill_records(gi_cache_fill *fill)
{
	return fill->cache;
}

stilb_result gi_cache_fill_save(const gi_cache_fill *fill)
{
	const char *path = fill->cache->view->settings.cache.save;
	return path ? gi_cache_save(fill->cache, path) : STILB_OK;
}

gi_cache_progress gi_cache_fill_progress(const gi_cache_fill *fill)
{
	const gi_cache *cache = fill->cache;
	/* Relaxed, here and below: the structs gi_cache_fill and gi_cache_worker say why. */
	gi_cache_progress progress = {.round = atomic_load_explicit(&fill->round, memory_order_relaxed),
	                              .done = (double)atomic_load_explicit(&fill->done, memory_order_relaxed),
	                              .records = gi_cache_octree_count(cache->octree)};
	for (uint32_t i = 0; i < cache->worker_count; i++) {
		progress.rays += atomic_load_explicit(&cache->workers[i].traced, memory_order_relaxed);
		progress.shadow_rays += atomic_load_explicit(&cache->workers[i].shadow_rays, memory_order_relaxed);
	}
	return progress;
}

/* ---- levels and strips ------------------------------------------------------------------------------------------- */

typedef struct fill_strip {
	gi_cache_fill *fill;
	/* The strip's rows, counted in rows of the level: first_row, first_row + row_step, ...; the level's row r is row
	 * r * block of the picture. */
	uint32_t first_row, row_step, rows;
	uint32_t columns;  /* places in fill->pixels for each row */
	_Atomic bool full; /* LIVE: a record could not be added for lack of memory */
} fill_strip;

static uint32_t divide_up(uint32_t a, uint32_t b)
{
	STILB_ASSERT(b > 0);
	return (a + b - 1u) / b;
}

static uint32_t level_strips(const stilb_gi_settings *settings, uint32_t block)
{
	uint32_t rows = divide_up(settings->height, block);
	uint64_t pixels = (uint64_t)rows * divide_up(settings->width, block);
	uint64_t strips = (pixels + STRIP - 1u) / STRIP;
	return strips < rows ? (uint32_t)strips : rows;
}

static bool pixel_is_of_coarser_level(uint32_t x, uint32_t y, uint32_t block)
{
	return block < FIRST_BLOCK && x % (2u * block) == 0 && y % (2u * block) == 0;
}

/* True if the pixel's centre shows a surface, perhaps behind panes, that reflects diffuse light (gi_cache_wants), and
 * no record covers it. */
static bool pixel_look(const gi_cache_fill *fill, fill_pixel *pixel)
{
	const gi_view *view = fill->cache->view;
	gi_ray_hit ray;
	gi_camera_ray(&fill->camera, (float)pixel->x + 0.5f, (float)pixel->y + 0.5f, (stilb_vec2){0.5f, 0.5f}, &ray);
	gi_point point = gi_sampler_point(&view->sampler, pixel->x, pixel->y, 0);
	if (view->scene->blends)
		ray.ray.time = gi_sample_2d(&view->sampler, point, GI_DIMENSION_SEEN)[0];
	uint64_t traced = 0; /* camera rays of the overture are not counted */
	gi_through_intersect(view->scene, &ray, &traced);
	if (!gi_is_hit(&ray))
		return false;
	gi_surface_at(view->scene, &ray, &pixel->surface);
	return gi_cache_wants(&pixel->surface) && !gi_cache_covers(fill->cache, &pixel->surface, REACH);
}

static gi_cache_record pixel_gather(gi_cache *cache, const fill_pixel *pixel, uint32_t worker)
{
	gi_point point = gi_sampler_point(&cache->view->sampler, pixel->x, pixel->y, 0);
	return gi_cache_gather(cache, worker, &pixel->surface, point);
}

static void look_rows(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	STILB_ASSERT(worker < ((const fill_strip *)context)->fill->cache->worker_count);
	PROFILE("gi.overture.look");
	fill_strip *strip = context;
	gi_cache_fill *fill = strip->fill;
	gi_cache *cache = fill->cache;
	for (uint32_t i = begin; i < end; i++) {
		fill_pixel *slots = &fill->pixels[fill->count + i * strip->columns];
		uint32_t y = (strip->first_row + i * strip->row_step) * fill->block;
		for (uint32_t column = 0; column < strip->columns; column++) {
			fill_pixel *pixel = &slots[column];
			pixel->x = column * fill->block;
			pixel->y = y;
			pixel->missing = !pixel_is_of_coarser_level(pixel->x, pixel->y, fill->block) && pixel_look(fill, pixel);
			if (pixel->missing && cache->view->settings.cache.mode == STILB_GI_CACHE_LIVE) {
				gi_cache_record record = pixel_gather(cache, pixel, worker);
				if (!gi_cache_add(cache, &record))
					atomic_store_explicit(&strip->full, true, memory_order_relaxed); /* read when all jobs have ended */
				pixel->missing = false;
			}
		}
	}
}

/* Grows the array pixels so that `more` fit behind the missing pixels in it. */
static stilb_result pixels_want(gi_cache_fill *fill, uint32_t more)
{
	if (fill->count + more <= fill->capacity)
		return STILB_OK;
	fill_pixel *larger = stilb_memory_alloc(fill->count + more, sizeof(*larger));
	if (!larger)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the irradiance cache's overture");
	if (fill->count > 0)
		memcpy(larger, fill->pixels, fill->count * sizeof(*larger));
	free(fill->pixels);
	fill->pixels = larger;
	fill->capacity = fill->count + more;
	return STILB_OK;
}

/* Keeps those of the first count pixels that are still missing a record. */
static void pixels_compact(gi_cache_fill *fill, uint32_t count)
{
	STILB_ASSERT(count <= fill->capacity);
	fill->count = 0;
	for (uint32_t i = 0; i < count; i++)
		if (fill->pixels[i].missing)
			fill->pixels[fill->count++] = fill->pixels[i];
}

static stilb_result strip_look(gi_cache_fill *fill)
{
	STILB_ASSERT(fill->block > 0 && fill->block <= FIRST_BLOCK);
	const stilb_gi_settings *settings = &fill->cache->view->settings;
	uint32_t strips = level_strips(settings, fill->block);
	uint32_t level_rows = divide_up(settings->height, fill->block);
	fill_strip strip = {.fill = fill,
	                    .first_row = fill->strip,
	                    .row_step = strips,
	                    .rows = divide_up(level_rows - fill->strip, strips),
	                    .columns = divide_up(settings->width, fill->block)};
	uint32_t looked = strip.rows * strip.columns;
	stilb_result result = pixels_want(fill, looked);
	if (result != STILB_OK)
		return result;
	stilb_job_parallel_for(fill->pool, strip.rows, 1, look_rows, &strip, 0);
	/* Relaxed: the parallel loop has ended, and with it all jobs that store this. */
	if (atomic_load_explicit(&strip.full, memory_order_relaxed))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for more records of the irradiance cache");
	pixels_compact(fill, fill->count + looked);
	fill->looked += looked;
	if (++fill->strip == strips) {
		fill->strip = 0;
		fill->block /= 2u;
	}
	return STILB_OK;
}

/* ---- rounds ------------------------------------------------------------------------------------------------------ */

typedef struct fill_round {
	gi_cache_fill *fill;
	uint32_t count;
	uint32_t chosen[ROUND_MOST]; /* indices of missing pixels */
	gi_cache_record *records;    /* [count] */
} fill_round;

static bool too_near(const fill_pixel *a, const fill_pixel *b)
{
	int dx = abs((int)a->x - (int)b->x), dy = abs((int)a->y - (int)b->y);
	return dx < SPACING && dy < SPACING;
}

/* Chooses missing pixels, evenly spread over the list, none within SPACING of another. */
static void round_choose(const gi_cache_fill *fill, uint32_t records, fill_round *round)
{
	STILB_ASSERT(fill->count > 0);
	uint32_t wanted = records / ROUND_SHARE;
	wanted = wanted < ROUND_LEAST ? ROUND_LEAST : wanted > ROUND_MOST ? ROUND_MOST : wanted;
	if (wanted > fill->count)
		wanted = fill->count;
	for (uint32_t i = 0; i < wanted; i++) {
		uint32_t candidate = (uint32_t)((uint64_t)i * fill->count / wanted);
		bool alone = true;
		for (uint32_t k = 0; k < round->count && alone; k++)
			alone = !too_near(&fill->pixels[candidate], &fill->pixels[round->chosen[k]]);
		if (alone)
			round->chosen[round->count++] = candidate;
	}
}

static void round_gather(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	STILB_ASSERT(end <= ((const fill_round *)context)->count);
	PROFILE("gi.overture.record");
	fill_round *round = context;
	for (uint32_t i = begin; i < end; i++)
		round->records[i] = pixel_gather(round->fill->cache, &round->fill->pixels[round->chosen[i]], worker);
}

static void round_look_again(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	gi_cache_fill *fill = context;
	for (uint32_t i = begin; i < end; i++) {
		fill_pixel *pixel = &fill->pixels[i];
		pixel->missing = pixel->missing && !gi_cache_covers(fill->cache, &pixel->surface, REACH);
	}
}

static stilb_result round_run(gi_cache_fill *fill)
{
	gi_cache *cache = fill->cache;
	fill_round round = {.fill = fill, .records = fill->records};
	round_choose(fill, gi_cache_octree_count(cache->octree), &round);
	STILB_ASSERT(round.count > 0 && round.count <= ROUND_MOST);
	stilb_job_parallel_for(fill->pool, round.count, 1, round_gather, &round, 0);
	for (uint32_t i = 0; i < round.count; i++) {
		if (!gi_cache_add(cache, &round.records[i]))
			return stilb_fail(STILB_ERROR_MEMORY, "no memory for more than %u records of the irradiance cache",
			                  gi_cache_octree_count(cache->octree));
		fill->pixels[round.chosen[i]].missing = false;
	}
	stilb_job_parallel_for(fill->pool, fill->count, 64, round_look_again, fill, 0);
	pixels_compact(fill, fill->count);
	return STILB_OK;
}

/* ---- all of it --------------------------------------------------------------------------------------------------- */

static bool overture_has_ended(const gi_cache_fill *fill)
{
	return fill->block == 0 && fill->count == 0;
}

/* Updates done, the share of the overture's pixels that have records. Relaxed, here and below: struct gi_cache_fill
 * says why. */
static void overture_count(gi_cache_fill *fill)
{
	STILB_ASSERT(fill->looked >= fill->count);
	const stilb_gi_settings *settings = &fill->cache->view->settings;
	uint64_t total = 0;
	for (uint32_t block = FIRST_BLOCK; block > 0; block /= 2u)
		total += (uint64_t)divide_up(settings->width, block) * divide_up(settings->height, block);
	float done = (float)(fill->looked - fill->count) / (float)total;
	atomic_store_explicit(&fill->done, done, memory_order_relaxed);
	atomic_fetch_add_explicit(&fill->round, 1u, memory_order_relaxed);
}

stilb_result gi_cache_fill_run(gi_cache_fill *fill, gi_cache_report *report, void *user)
{
	STILB_ASSERT(fill->records || fill->block == 0);
	if (fill->cache->view->settings.depth < 2)
		return STILB_OK; /* there is no indirect light */
	while (!overture_has_ended(fill)) {
		bool look = fill->block > 0 && fill->count < ROUND_WORTH;
		stilb_result result = look ? strip_look(fill) : round_run(fill);
		if (result != STILB_OK)
			return result;
		overture_count(fill);
		gi_cache_progress progress = gi_cache_fill_progress(fill);
		if (report && !report(user, &progress))
			return STILB_OK;
	}
	return STILB_OK;
}
