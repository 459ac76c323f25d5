/*
 * The overture: records for what the picture shows, before it is made.
 *
 * Strips.    Pixels are looked at in levels, every 32nd pixel of every 32nd row first, then what lies between, finer
 *            and finer; and a level in strips of rows that lie far from one another. A pixel that no record covers is
 *            missing one.
 * Rounds.    FROZEN: some of the missing pixels, far from one another, gather a record each, as jobs; then the records
 *            are added in the order in which the pixels were chosen, and all that are still missing look again. Who is
 *            chosen does not depend on the workers, so nothing does.
 *            LIVE: whoever looks and misses gathers there and then.
 */
#include "gi/cache/gi_cache_internal.h"

#include "gi/trace/gi_ray.h"
#include "profiler/prof.h"

#include <stdlib.h>
#include <string.h>

#define FIRST_BLOCK 32u
#define STRIP 8192u      /* pixels, about */
#define ROUND_LEAST 16u  /* records of a round at least, where so many are missing; and later */
#define ROUND_SHARE 8u   /* one for so many as there are; */
#define ROUND_MOST 1024u /* at most */
#define ROUND_WORTH 32u  /* missing pixels for which a round is begun before the next strip is looked at */
#define SPACING 8        /* between the pixels of a round, pixels */
#define REACH 0.8f /* the overture wants records nearer than the picture does: there are some between pixels too */

typedef struct gi_cache_pixel {
	gi_surface surface;
	uint32_t x, y;
	bool missing;
} gi_cache_pixel;

/* ---- life -------------------------------------------------------------------------------------------------------- */

stilb_result gi_cache_overture_init(gi_cache_overture *overture, bool wanted)
{
	if (!wanted)
		return STILB_OK;
	overture->block = FIRST_BLOCK;
	overture->records = stilb_memory_alloc(ROUND_MOST, sizeof(*overture->records));
	return overture->records ? STILB_OK
	                         : stilb_fail(STILB_ERROR_MEMORY, "no memory for the irradiance cache's overture");
}

void gi_cache_overture_finish(gi_cache_overture *overture)
{
	free(overture->pixels);
	free(overture->records);
}

/* ---- levels and strips ------------------------------------------------------------------------------------------- */

typedef struct overture_strip {
	gi_cache *cache;
	uint32_t first_row, row_step, rows; /* of the level: its row r is the picture's r * block */
	uint32_t columns;                   /* slots for a row */
	_Atomic bool full;                  /* LIVE: no memory for a record */
} overture_strip;

static uint32_t divide_up(uint32_t a, uint32_t b)
{
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

static bool covered(const gi_cache *cache, const gi_surface *surface)
{
	return gi_cache_octree_covers(cache->octree, surface->position, surface->normal, cache->limits.turn, REACH);
}

/* Whether the pixel's centre shows a surface that wants a record and has none. */
static bool pixel_look(gi_cache *cache, gi_cache_pixel *pixel)
{
	const gi_view *view = cache->view;
	gi_ray_hit ray;
	gi_camera_ray(&cache->camera, (float)pixel->x + 0.5f, (float)pixel->y + 0.5f, (stilb_vec2){0.5f, 0.5f}, &ray);
	view->scene->tracer.intersect(&view->scene->tracer, &ray);
	if (!gi_is_hit(&ray))
		return false;
	gi_surface_at(view->scene, &ray, &pixel->surface);
	return gi_cache_wants(&pixel->surface) && !covered(cache, &pixel->surface);
}

static gi_cache_record pixel_gather(gi_cache *cache, const gi_cache_pixel *pixel, uint32_t worker)
{
	gi_point point = gi_sampler_point(&cache->view->sampler, pixel->x, pixel->y, 0);
	return gi_cache_gather(cache, worker, &pixel->surface, point);
}

static void look_rows(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	PROFILE("gi.overture.look");
	overture_strip *strip = context;
	gi_cache *cache = strip->cache;
	gi_cache_overture *overture = &cache->overture;
	for (uint32_t i = begin; i < end; i++) {
		gi_cache_pixel *slots = &overture->pixels[overture->count + i * strip->columns];
		uint32_t y = (strip->first_row + i * strip->row_step) * overture->block;
		for (uint32_t column = 0; column < strip->columns; column++) {
			gi_cache_pixel *pixel = &slots[column];
			pixel->x = column * overture->block;
			pixel->y = y;
			pixel->missing =
				!pixel_is_of_coarser_level(pixel->x, pixel->y, overture->block) && pixel_look(cache, pixel);
			if (pixel->missing && cache->view->settings.cache.mode == STILB_GI_CACHE_LIVE) {
				gi_cache_record record = pixel_gather(cache, pixel, worker);
				if (!gi_cache_add(cache, &record))
					atomic_store_explicit(&strip->full, true, memory_order_relaxed); /* read after the loop has ended */
				pixel->missing = false;
			}
		}
	}
}

/* Room for so many pixels behind the missing ones. */
static stilb_result pixels_want(gi_cache_overture *overture, uint32_t more)
{
	if (overture->count + more <= overture->capacity)
		return STILB_OK;
	gi_cache_pixel *larger = stilb_memory_alloc(overture->count + more, sizeof(*larger));
	if (!larger)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the irradiance cache's overture");
	if (overture->count > 0)
		memcpy(larger, overture->pixels, overture->count * sizeof(*larger));
	free(overture->pixels);
	overture->pixels = larger;
	overture->capacity = overture->count + more;
	return STILB_OK;
}

/* The first count pixels, without those that are no longer missing. */
static void pixels_compact(gi_cache_overture *overture, uint32_t count)
{
	overture->count = 0;
	for (uint32_t i = 0; i < count; i++)
		if (overture->pixels[i].missing)
			overture->pixels[overture->count++] = overture->pixels[i];
}

static stilb_result strip_look(gi_cache *cache)
{
	gi_cache_overture *overture = &cache->overture;
	const stilb_gi_settings *settings = &cache->view->settings;
	uint32_t strips = level_strips(settings, overture->block);
	uint32_t level_rows = divide_up(settings->height, overture->block);
	overture_strip strip = {.cache = cache,
	                        .first_row = overture->strip,
	                        .row_step = strips,
	                        .rows = divide_up(level_rows - overture->strip, strips),
	                        .columns = divide_up(settings->width, overture->block)};
	uint32_t looked = strip.rows * strip.columns;
	stilb_result result = pixels_want(overture, looked);
	if (result != STILB_OK)
		return result;
	stilb_job_parallel_for(cache->pool, strip.rows, 1, look_rows, &strip, 0);
	/* relaxed: the loop has ended, and with it all stores */
	if (atomic_load_explicit(&strip.full, memory_order_relaxed))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for more records of the irradiance cache");
	pixels_compact(overture, overture->count + looked);
	overture->looked += looked;
	if (++overture->strip == strips) {
		overture->strip = 0;
		overture->block /= 2u;
	}
	return STILB_OK;
}

/* ---- rounds ------------------------------------------------------------------------------------------------------ */

typedef struct overture_round {
	gi_cache *cache;
	uint32_t count;
	uint32_t chosen[ROUND_MOST]; /* of the missing pixels */
	gi_cache_record *records;    /* [count] */
} overture_round;

static bool too_near(const gi_cache_pixel *a, const gi_cache_pixel *b)
{
	int dx = abs((int)a->x - (int)b->x), dy = abs((int)a->y - (int)b->y);
	return dx < SPACING && dy < SPACING;
}

/* Evenly from all that are missing, none near another. */
static void round_choose(const gi_cache_overture *overture, uint32_t records, overture_round *round)
{
	uint32_t wanted = records / ROUND_SHARE;
	wanted = wanted < ROUND_LEAST ? ROUND_LEAST : wanted > ROUND_MOST ? ROUND_MOST : wanted;
	if (wanted > overture->count)
		wanted = overture->count;
	for (uint32_t i = 0; i < wanted; i++) {
		uint32_t candidate = (uint32_t)((uint64_t)i * overture->count / wanted);
		bool alone = true;
		for (uint32_t k = 0; k < round->count && alone; k++)
			alone = !too_near(&overture->pixels[candidate], &overture->pixels[round->chosen[k]]);
		if (alone)
			round->chosen[round->count++] = candidate;
	}
}

static void round_gather(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	PROFILE("gi.overture.record");
	overture_round *round = context;
	for (uint32_t i = begin; i < end; i++)
		round->records[i] = pixel_gather(round->cache, &round->cache->overture.pixels[round->chosen[i]], worker);
}

static void round_look_again(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	gi_cache *cache = context;
	for (uint32_t i = begin; i < end; i++) {
		gi_cache_pixel *pixel = &cache->overture.pixels[i];
		pixel->missing = pixel->missing && !covered(cache, &pixel->surface);
	}
}

static stilb_result round_run(gi_cache *cache)
{
	gi_cache_overture *overture = &cache->overture;
	overture_round round = {.cache = cache, .records = overture->records};
	round_choose(overture, gi_cache_octree_count(cache->octree), &round);
	stilb_job_parallel_for(cache->pool, round.count, 1, round_gather, &round, 0);
	for (uint32_t i = 0; i < round.count; i++) {
		if (!gi_cache_add(cache, &round.records[i]))
			return stilb_fail(STILB_ERROR_MEMORY, "no memory for more than %u records of the irradiance cache",
			                  gi_cache_octree_count(cache->octree));
		overture->pixels[round.chosen[i]].missing = false;
	}
	stilb_job_parallel_for(cache->pool, overture->count, 64, round_look_again, cache, 0);
	pixels_compact(overture, overture->count);
	return STILB_OK;
}

/* ---- all of it --------------------------------------------------------------------------------------------------- */

static bool overture_has_ended(const gi_cache_overture *overture)
{
	return overture->block == 0 && overture->count == 0;
}

/* relaxed, here and below: numbers to show */
static void overture_count(gi_cache *cache)
{
	const stilb_gi_settings *settings = &cache->view->settings;
	gi_cache_overture *overture = &cache->overture;
	uint64_t total = 0;
	for (uint32_t block = FIRST_BLOCK; block > 0; block /= 2u)
		total += (uint64_t)divide_up(settings->width, block) * divide_up(settings->height, block);
	float done = (float)(overture->looked - overture->count) / (float)total;
	atomic_store_explicit(&overture->done, done, memory_order_relaxed);
	atomic_fetch_add_explicit(&overture->round, 1u, memory_order_relaxed);
}

stilb_result gi_cache_overture_run(gi_cache *cache, gi_cache_report *report, void *user)
{
	gi_cache_overture *overture = &cache->overture;
	if (cache->view->settings.depth < 2)
		return STILB_OK; /* there is no indirect light */
	while (!overture_has_ended(overture)) {
		bool look = overture->block > 0 && overture->count < ROUND_WORTH;
		stilb_result result = look ? strip_look(cache) : round_run(cache);
		if (result != STILB_OK)
			return result;
		overture_count(cache);
		gi_cache_progress progress = gi_cache_progress_of(cache);
		if (report && !report(user, &progress))
			return STILB_OK;
	}
	return STILB_OK;
}
