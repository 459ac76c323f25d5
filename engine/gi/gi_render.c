/*
 * gi_render: renders a picture by ray tracing: passes over the picture, each split into tiles (one job each), whose
 * samples (camera rays with their light) are computed in batches.
 *
 * A pass has a grid of pixels and a number of samples that each of them shall have. A pixel knows how many it has, so
 * a pass that a stop or a time limit cut short is repeated and renders only what is missing.
 */
#include "gi/gi_render_internal.h"

#include "gi/film/gi_denoise.h"
#include "gi/gi_settings.h"
#include "gi/integrate/gi_backdrop.h"
#include "gi/sample/gi_counter.h"
#include "gi/trace/gi_through.h"
#include "profiler/prof.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define TILE 16u              /* side of a tile, in points of the pass's grid (pixels where block is 1) */
#define SMALLEST_TILE 4u      /* side of a tile where TILE would give too few tiles for the workers */
#define TILES_FOR_A_WORKER 8u /* so that no worker waits long for another's last tile */
#define RAYS_OF_BATCH 0x40000 /* rays in a batch, about: few enough that a stop, seen between batches, comes soon */
#define RAYS_OF_PATH 8        /* rays of one path after its camera ray: an estimate, for the size of a batch */
#define OVERTURE_SHARE 0.5    /* of the time limit, for filling the irradiance cache before the picture */
#define WATCH_NS 50000000u    /* between two calls of the watcher */
#define FIRST_SAMPLES 16u     /* of each pixel in the first round of a progressive render: see first_samples */
#define UNIT_WAIT_NS 500000   /* before a feed that has no unit now is asked again */
#define SLICE_BATCH 128u      /* samples in a batch at most where loops are cut into slices: about a millisecond */

/* ---- life -------------------------------------------------------------------------------------------------------- */

/* Estimated number of rays that one sample takes after its camera ray: those from the first hit, and all that follow
 * from where these arrive. */
static double rays_of_sample(const stilb_gi_settings *settings)
{
	switch (settings->integrator) {
	case STILB_GI_INTEGRATOR_MONTECARLO:
		return stilb_gi_montecarlo_rays(settings) / ((double)settings->width * settings->height * settings->samples);
	case STILB_GI_INTEGRATOR_AO:
		return settings->rays;
	case STILB_GI_INTEGRATOR_SPLIT:
		return settings->rays * RAYS_OF_PATH;
	case STILB_GI_INTEGRATOR_IRRADIANCE_CACHE:
		return settings->cache.mode == STILB_GI_CACHE_LIVE ? settings->cache.rays : RAYS_OF_PATH;
	default:
		return RAYS_OF_PATH;
	}
}

static uint32_t batch_size_for(const stilb_gi_settings *settings)
{
	double fitting = RAYS_OF_BATCH / rays_of_sample(settings);
	return fitting >= GI_BATCH ? GI_BATCH : fitting > 1.0 ? (uint32_t)fitting : 1;
}

static bool batch_worker_init(gi_render_worker *worker, size_t scratch_size)
{
	worker->count = 0;
	worker->counters = (gi_render_counters){0};
	worker->scratch = stilb_memory_alloc(1, scratch_size ? scratch_size : 1);
	return worker->scratch;
}

static stilb_result batch_workers_create(stilb_gi_render *render)
{
	uint32_t count = stilb_job_pool_worker_count(render->pool) + 1;
	render->workers = stilb_memory_alloc(count, sizeof *render->workers);
	for (; render->workers && render->worker_count < count; render->worker_count++)
		if (!batch_worker_init(&render->workers[render->worker_count], render->integrator->scratch_size))
			break;
	if (render->worker_count == count)
		return STILB_OK;
	return stilb_fail(STILB_ERROR_MEMORY, "out of memory for %u threads that render", count);
}

static stilb_result gi_render_fill(stilb_gi_render *render)
{
	const stilb_gi_settings *settings = &render->view.settings;
	stilb_result result = gi_film_create(&render->film, settings->width, settings->height, gi_film_kind_of(settings));
	if (result == STILB_OK)
		result = batch_workers_create(render);
	if (result == STILB_OK && settings->integrator == STILB_GI_INTEGRATOR_IRRADIANCE_CACHE)
		result = gi_cache_fill_create(&render->view, render->pool, &render->cache_fill);
	if (result == STILB_OK && render->cache_fill)
		render->view.cache = gi_cache_fill_records(render->cache_fill);
	return result;
}

/* The functions for the widest instruction set that this CPU has, or for the one that the environment variable
 * STILB_ISA names; the results are the same bits with each. */
static const gi_primary_kernels *primary_kernels(void)
{
	stilb_isa isa;
	return gi_primary_kernels_for(stilb_cpu_isa(&isa) == STILB_OK ? isa : STILB_ISA_SCALAR);
}

stilb_result stilb_gi_render_create(const stilb_gi_scene *scene, const stilb_gi_settings *settings,
                                    stilb_job_pool *pool, stilb_gi_render **out)
{
	STILB_ASSERT(scene && settings && pool && out);
	*out = NULL;
	stilb_result result = gi_settings_check(settings);
	if (result != STILB_OK)
		return result;
	stilb_gi_render *render = calloc(1, sizeof *render);
	if (!render || !stilb_lock_init(&render->lock)) {
		free(render);
		return stilb_fail(STILB_ERROR_MEMORY, "out of memory for a picture");
	}
	stilb_owner_take(&render->owner);
	render->view.scene = scene;
	render->view.settings = *settings;
	render->view.sampler = gi_sampler_make(settings->sampler, settings->seed, settings->samples);
	render->camera = gi_camera_make(&settings->camera, &settings->lens, settings->width, settings->height);
	render->kernels = primary_kernels();
	render->integrator = gi_integrator_of(settings->integrator);
	render->batch_size = batch_size_for(settings);
	STILB_ASSERT(render->batch_size >= 1 && render->batch_size <= GI_BATCH);
	render->pool = pool;
	render->estimate = HUGE_VAL;
	result = gi_render_fill(render);
	if (result == STILB_OK)
		*out = render;
	else
		stilb_gi_render_destroy(render);
	return result;
}

void stilb_gi_render_destroy(stilb_gi_render *render)
{
	if (!render)
		return;
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(render->begun_ns == 0 && "run does not run");
	gi_cache_fill_destroy(render->cache_fill);
	for (uint32_t i = 0; i < render->worker_count; i++)
		free(render->workers[i].scratch);
	free(render->workers);
	gi_film_finish(&render->film);
	free(render->units.order);
	free(render->identity);
	stilb_lock_finish(&render->lock);
	free(render);
}

void stilb_gi_render_until(stilb_gi_render *render, uint32_t samples)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(render->begun_ns == 0 && "run does not run");
	STILB_ASSERT(!render->cache_fill && render->view.settings.seconds <= 0.0 && render->view.settings.error <= 0.0f);
	render->until = samples;
}

void stilb_gi_render_share(stilb_gi_render *render, uint32_t caller, double slice)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(render->begun_ns == 0 && render->pass_count == 0 && "before the first run");
	STILB_ASSERT(caller == 0 || caller == STILB_JOB_OUTSIDE);
	STILB_ASSERT(slice >= 0.0 && slice <= 1e6);
	STILB_ASSERT(!render->cache_fill && "the irradiance cache is filled by the pool's main thread");
	render->caller = caller;
	render->slice_ns = (uint64_t)(slice * 1e9);
	render->batch_size = batch_size_for(&render->view.settings);
	if (render->slice_ns > 0 && render->batch_size > SLICE_BATCH)
		render->batch_size = SLICE_BATCH;
}

/* ---- batches ----------------------------------------------------------------------------------------------------- */

static void batch_to_film(stilb_gi_render *render, gi_render_worker *worker)
{
	PROFILE("gi.film");
	uint64_t bad = 0;
	for (uint32_t i = 0; i < worker->count; i++) {
		gi_film_sample sample = {.radiance = worker->radiance[i],
		                         .albedo = worker->primary.albedo[i],
		                         .normal = worker->primary.normal[i],
		                         .depth = worker->primary.depth[i]};
		bad += !gi_film_add(&render->film, worker->pixels[i], &sample);
	}
	gi_counter_add(&worker->counters.bad_samples, bad);
}

/* True if the picture is of light, and there is glass for it to go through. */
static bool batch_passes(const stilb_gi_render *render)
{
	stilb_gi_integrator integrator = render->view.settings.integrator;
	return render->view.scene->passes && integrator != STILB_GI_INTEGRATOR_COLOR &&
	       integrator != STILB_GI_INTEGRATOR_AO && integrator != STILB_GI_INTEGRATOR_CHANNEL;
}

static void batch_render(stilb_gi_render *render, gi_render_worker *worker)
{
	STILB_ASSERT(worker->count > 0 && worker->count <= render->batch_size);
	gi_batch batch = {.view = &render->view,
	                  .worker = (uint32_t)(worker - render->workers),
	                  .count = worker->count,
	                  .points = worker->points,
	                  .rays = worker->primary.rays,
	                  .radiance = worker->radiance,
	                  .scratch = worker->scratch};
	{
		PROFILE("gi.primary");
		gi_primary_samples samples = {worker->count, worker->x, worker->y, worker->points};
		gi_primary_trace(render->kernels, &render->view, &render->camera, &samples, &worker->primary);
	}
	bool passes = batch_passes(render);
	for (uint32_t i = 0; i < batch.count && passes; i++)
		worker->left[i] = gi_through(render->view.scene, &worker->primary.rays[i], &batch.rays_traced);
	render->integrator->shade(&batch);
	gi_backdrop_shade(&batch);
	for (uint32_t i = 0; i < batch.count && passes; i++)
		worker->radiance[i] *= worker->left[i];
	batch_to_film(render, worker);
	gi_counter_add(&worker->counters.samples, batch.count);
	gi_counter_add(&worker->counters.rays, batch.count + batch.rays_traced);
	gi_counter_add(&worker->counters.camera_rays, batch.count);
	gi_counter_add(&worker->counters.shadow_rays, batch.shadow_rays);
}

/* ---- tiles ------------------------------------------------------------------------------------------------------- */

typedef struct tile_grid {
	stilb_gi_render *render;
	uint32_t block, target; /* every block-th pixel of every block-th row gets samples until it has target of them */
	uint32_t tile, tiles_x; /* side of a tile in points of the grid; tiles side by side in a row of tiles */
	uint32_t tile_count;
	uint32_t first_tile; /* the loop begins with it */
} tile_grid;

static uint32_t parts_of(uint32_t whole, uint32_t part)
{
	STILB_ASSERT(part > 0);
	return (whole + part - 1) / part;
}

static tile_grid grid_make(stilb_gi_render *render, const stilb_gi_pass *pass)
{
	tile_grid grid = {.render = render, .block = pass->block, .target = pass->first_sample + pass->sample_count};
	uint32_t width = parts_of(render->film.width, grid.block), height = parts_of(render->film.height, grid.block);
	uint32_t wanted = TILES_FOR_A_WORKER * render->worker_count;
	for (grid.tile = TILE;; grid.tile /= 2) {
		grid.tiles_x = parts_of(width, grid.tile);
		grid.tile_count = grid.tiles_x * parts_of(height, grid.tile);
		if (grid.tile_count >= wanted || grid.tile == SMALLEST_TILE)
			return grid;
	}
}

static bool is_ending(const stilb_gi_render *render)
{
	/* Relaxed: struct stilb_gi_render says why. */
	return atomic_load_explicit(&render->stop, memory_order_relaxed) ||
	       (render->deadline_ns && stilb_time_ns() >= render->deadline_ns);
}

/* Shows the program how far the render is, on the thread in run, and stops for it. */
static void watch(stilb_gi_render *render)
{
	uint64_t now = render->watch ? stilb_time_ns() : 0;
	if (!render->watch || now - render->watched_ns < WATCH_NS)
		return;
	stilb_gi_progress progress;
	stilb_gi_render_progress(render, &progress);
	if (!render->watch(render->watch_user, &progress))
		stilb_gi_render_stop(render);
	render->watched_ns = stilb_time_ns();
}

/* The thread's slice of the loop over tiles is over. It begins with the first tile that it takes. */
static bool slice_is_over(const stilb_gi_render *render, gi_render_worker *worker)
{
	if (render->slice_ns == 0)
		return false;
	uint64_t now = stilb_time_ns();
	if (worker->loop != render->loop) {
		worker->loop = render->loop;
		worker->slice_end_ns = now + render->slice_ns;
	}
	return now >= worker->slice_end_ns;
}

/* Renders the samples that the worker has collected and empties its batch. False: the render is ending (stop, or the
 * time limit), or the thread's slice is over, and the samples were dropped instead. */
static bool batch_flush(stilb_gi_render *render, gi_render_worker *worker)
{
	if (worker == &render->workers[0])
		watch(render);
	bool go_on = worker->count == 0 || (!is_ending(render) && !slice_is_over(render, worker));
	if (go_on && worker->count > 0) {
		batch_render(render, worker);
		worker->added = true;
	}
	worker->count = 0;
	return go_on;
}

static bool pixel_render(const tile_grid *grid, gi_render_worker *worker, uint32_t x, uint32_t y)
{
	STILB_ASSERT(x < grid->render->film.width && y < grid->render->film.height);
	stilb_gi_render *render = grid->render;
	size_t pixel = (size_t)y * render->film.width + x;
	for (uint32_t i = render->film.pixels[pixel].samples; i < grid->target; i++) {
		uint32_t at = worker->count++;
		STILB_ASSERT(at < render->batch_size);
		worker->points[at] = gi_sampler_point(&render->view.sampler, x, y, i);
		worker->pixels[at] = pixel;
		worker->x[at] = (uint16_t)x;
		worker->y[at] = (uint16_t)y;
		if (worker->count == render->batch_size && !batch_flush(render, worker))
			return false;
	}
	return true;
}

typedef struct grid_tile {
	uint32_t x, y; /* its first point, counted in points of the pass's grid */
	uint32_t side;
} grid_tile;

static grid_tile tile_of(const tile_grid *grid, uint32_t index)
{
	STILB_ASSERT(index < grid->tile_count);
	return (grid_tile){index % grid->tiles_x * grid->tile, index / grid->tiles_x * grid->tile, grid->tile};
}

/* x of an 8-bit Morton code, which interleaves the bits of x (the even ones) and y (the odd ones). y is found by
 * passing code >> 1. */
static uint32_t morton_x(uint32_t code)
{
	STILB_ASSERT(code < 256);
	code &= 0x55;
	code = (code | code >> 1) & 0x33;
	return (code | code >> 2) & 0x0f;
}
static_assert(TILE <= 16, "so that a point's Morton code has 8 bits");

/* The pixel of point number `point` of the tile. Points are in Morton order, so that sixteen consecutive camera rays,
 * which are traced together as a packet, go to pixels close together. False: the pixel is outside the picture. */
static bool tile_pixel(const tile_grid *grid, const grid_tile *tile, uint32_t point, uint32_t *x, uint32_t *y)
{
	*x = (tile->x + morton_x(point)) * grid->block;
	*y = (tile->y + morton_x(point >> 1)) * grid->block;
	return *x < grid->render->film.width && *y < grid->render->film.height;
}

static bool tile_gather(const tile_grid *grid, gi_render_worker *worker, const grid_tile *tile)
{
	for (uint32_t i = 0, x, y; i < tile->side * tile->side; i++) {
		if (tile_pixel(grid, tile, i, &x, &y) && !pixel_render(grid, worker, x, y))
			return false;
	}
	return batch_flush(grid->render, worker);
}

static void tile_resolve(const tile_grid *grid, const grid_tile *tile)
{
	gi_film *film = &grid->render->film;
	for (uint32_t i = 0, x, y; i < tile->side * tile->side; i++) {
		if (tile_pixel(grid, tile, i, &x, &y))
			gi_film_resolve(film, (size_t)y * film->width + x);
	}
}

/* Notes that a tile was not finished. */
static void tile_cut(stilb_gi_render *render, uint32_t tile)
{
	/* Relaxed: see struct stilb_gi_render. */
	atomic_store_explicit(&render->cut, true, memory_order_relaxed);
	uint32_t first = atomic_load_explicit(&render->first_cut, memory_order_relaxed);
	while (tile < first && !atomic_compare_exchange_weak_explicit(&render->first_cut, &first, tile,
	                                                              memory_order_relaxed, memory_order_relaxed)) {
	}
}

/* stilb_job_range_fn */
static void tiles_render(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	STILB_ASSERT(worker < ((const tile_grid *)context)->render->worker_count);
	const tile_grid *grid = context;
	for (uint32_t i = begin; i < end; i++) {
		PROFILE("gi.tile");
		gi_render_worker *own = &grid->render->workers[worker];
		grid_tile tile = tile_of(grid, grid->first_tile + i);
		own->added = false;
		if (slice_is_over(grid->render, own) || !tile_gather(grid, own, &tile))
			tile_cut(grid->render, grid->first_tile + i);
		if (own->added)
			tile_resolve(grid, &tile);
	}
}

/* ---- units ------------------------------------------------------------------------------------------------------- */

static tile_grid unit_grid(stilb_gi_render *render)
{
	return (tile_grid){
		.render = render, .block = 1, .target = render->view.settings.samples, .tile = render->units.side};
}

/* Renders all samples of the unit that it lacks. False: the render is ending before they are done. */
static bool unit_render(const tile_grid *grid, gi_render_worker *worker, uint32_t unit)
{
	PROFILE("gi.unit");
	gi_unit_place place = gi_unit_place_of(&grid->render->units, unit);
	grid_tile tile = {place.x, place.y, grid->tile};
	worker->added = false;
	bool whole = tile_gather(grid, worker, &tile);
	if (worker->added)
		tile_resolve(grid, &tile);
	return whole;
}

/* stilb_job_range_fn: each slice takes units from the feed until there are none, so that no thread waits for the units
 * of another. */
static void units_render(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	tile_grid *grid = context;
	stilb_gi_render *render = grid->render;
	const stilb_farm_feed *feed = &render->feed;
	STILB_ASSERT(begin < end && worker < render->worker_count);
	(void)begin;
	(void)end;
	while (!is_ending(render)) {
		uint32_t unit;
		stilb_farm_taken taken = feed->take(feed->user, &unit);
		if (taken == STILB_FARM_NO_MORE)
			return;
		if (taken == STILB_FARM_LATER) {
			nanosleep(&(struct timespec){.tv_nsec = UNIT_WAIT_NS}, NULL);
			if (worker == 0)
				watch(render);
		} else if (unit_render(grid, &render->workers[worker], unit)) {
			feed->done(feed->user, unit);
		} else {
			feed->back(feed->user, unit);
			break;
		}
	}
	atomic_store_explicit(&render->cut, true, memory_order_relaxed); /* see struct stilb_gi_render */
}

/* The pass over units: the last one, or one after those that a checkpoint of a render without a feed has brought. */
static stilb_gi_pass *units_pass(stilb_gi_render *render, uint32_t samples)
{
	STILB_ASSERT_LOCKED(&render->lock);
	stilb_gi_pass *last = render->pass_count ? &render->passes[render->pass_count - 1] : NULL;
	if (last && !last->finished && last->block == 1 && last->first_sample == 0 && last->sample_count == samples)
		return last;
	STILB_ASSERT(render->pass_count < STILB_GI_MAX_PASSES);
	last = &render->passes[render->pass_count++];
	*last = (stilb_gi_pass){.block = 1, .sample_count = samples};
	return last;
}

/* The one pass of a render that has a feed: all samples of each unit that the feed gives. */
static stilb_gi_end units_run(stilb_gi_render *render)
{
	tile_grid grid = unit_grid(render);
	uint64_t begun = stilb_time_ns();
	stilb_lock_take(&render->lock);
	stilb_gi_pass *pass = units_pass(render, grid.target);
	snprintf(render->stage, sizeof render->stage, "units");
	stilb_lock_give(&render->lock);
	atomic_store_explicit(&render->cut, false, memory_order_relaxed); /* see struct stilb_gi_render */
	atomic_store_explicit(&render->share_next, 0, memory_order_relaxed);
	stilb_job_parallel_for(render->pool, render->worker_count, 1, units_render, &grid, render->caller);
	bool cut = atomic_load_explicit(&render->cut, memory_order_relaxed);
	stilb_lock_take(&render->lock);
	pass->finished = !cut;
	pass->seconds += (double)(stilb_time_ns() - begun) * 1e-9;
	stilb_lock_give(&render->lock);
	return cut ? STILB_GI_END_STOPPED : STILB_GI_END_SAMPLES;
}

/* ---- passes ------------------------------------------------------------------------------------------------------ */

static double seconds_spent(const stilb_gi_render *render)
{
	double now = render->begun_ns ? (double)(stilb_time_ns() - render->begun_ns) * 1e-9 : 0.0;
	return render->seconds + now;
}

/* How many further samples of every pixel fit into what is left of the time limit, judged by the time that the `done`
 * samples of each pixel have taken so far; 1 to 65536. */
static uint32_t samples_in_time(const stilb_gi_render *render, uint32_t done)
{
	STILB_ASSERT(done > 0 && render->view.settings.seconds > 0.0);
	double spent = 0.0;
	for (uint32_t i = 0; i < render->pass_count; i++)
		spent += render->passes[i].seconds;
	double fitting = (render->view.settings.seconds - seconds_spent(render)) * done / fmax(spent, 1e-9);
	return fitting < 1.0 ? 1 : fitting < 65536.0 ? (uint32_t)fitting : 65536;
}

/* Samples of each pixel in the first round over the picture. With a limit of time or error: one, so that all pixels
 * are there soon, whenever the limit ends the render. Progressive without a limit: few, so that a first picture is
 * there soon, but sixteen, which fill a packet of rays. Else all of them, in one pass. */
static uint32_t first_samples(const stilb_gi_settings *settings)
{
	if (settings->seconds > 0.0 || settings->error > 0.0f)
		return 1;
	return settings->progressive && settings->samples > FIRST_SAMPLES ? FIRST_SAMPLES : settings->samples;
}

/* Plans the next pass. The first round over the picture goes from coarse to fine: one pixel of each block, then blocks
 * of half the side, until all pixels have samples. After that each pass doubles the samples of all pixels. False: all
 * samples are done. */
static bool pass_plan(const stilb_gi_render *render, stilb_gi_pass *next)
{
	STILB_ASSERT(render->pass_count < STILB_GI_MAX_PASSES);
	const stilb_gi_settings *settings = &render->view.settings;
	uint32_t wanted = render->until > 0 && render->until < settings->samples ? render->until : settings->samples;
	if (render->pass_count == 0) {
		uint32_t first = first_samples(settings);
		*next = (stilb_gi_pass){.block = settings->progressive ? GI_FILM_LARGEST_BLOCK : 1,
		                        .sample_count = first < wanted ? first : wanted};
		return true;
	}
	const stilb_gi_pass *last = &render->passes[render->pass_count - 1];
	*next = (stilb_gi_pass){.block = last->block / 2, last->first_sample, last->sample_count};
	if (last->block > 1)
		return true;
	uint32_t done = last->first_sample + last->sample_count;
	/* 0 if a resumed checkpoint has more samples than are wanted now */
	uint32_t left = wanted > done ? wanted - done : 0;
	*next = (stilb_gi_pass){.block = 1, .first_sample = done, .sample_count = done < left ? done : left};
	if (settings->seconds > 0.0) {
		uint32_t fitting = samples_in_time(render, done);
		next->sample_count = fitting < next->sample_count ? fitting : next->sample_count;
	}
	if (render->pass_count == STILB_GI_MAX_PASSES - 1)
		next->sample_count = left;
	return left > 0;
}

/* The pass to render next: the last one if it was cut short, else a new one; NULL: nothing is left to do. */
static stilb_gi_pass *pass_next(stilb_gi_render *render)
{
	bool cut = render->pass_count > 0 && !render->passes[render->pass_count - 1].finished;
	stilb_gi_pass next;
	if (!cut && !pass_plan(render, &next))
		return NULL;
	stilb_lock_take(&render->lock);
	if (!cut)
		render->passes[render->pass_count++] = next;
	stilb_gi_pass *pass = &render->passes[render->pass_count - 1];
	snprintf(render->stage, sizeof render->stage, "pass %u", render->pass_count);
	stilb_lock_give(&render->lock);
	return pass;
}

/* The estimated error: measured anew after a whole pass if settings.error needs it, else the last one. */
static double error_after(const stilb_gi_render *render, const stilb_gi_pass *last)
{
	bool wanted = last && last->finished && render->view.settings.error > 0.0f;
	return wanted ? gi_film_error(&render->film) : render->estimate;
}

/* Tiles for the next loop: all that are left, or as many as are likely to be done in a slice. With more of them, each
 * thread would take tiles far behind those of the others, which later loops would visit in vain. */
static uint32_t loop_tiles(const stilb_gi_render *render, const tile_grid *grid)
{
	uint32_t left = grid->tile_count - grid->first_tile, window = render->window;
	if (window < TILES_FOR_A_WORKER * render->worker_count)
		window = TILES_FOR_A_WORKER * render->worker_count;
	return render->slice_ns == 0 || window > left ? left : window;
}

/* One loop over tiles of the pass. True: not all tiles of the pass are done. */
static bool tiles_loop(stilb_gi_render *render, tile_grid *grid)
{
	atomic_store_explicit(&render->cut, false, memory_order_relaxed); /* see struct stilb_gi_render */
	atomic_store_explicit(&render->first_cut, UINT32_MAX, memory_order_relaxed);
	render->loop++;
	grid->first_tile = render->first_tile;
	uint32_t count = loop_tiles(render, grid);
	stilb_job_parallel_for(render->pool, count, 1, tiles_render, grid, render->caller);
	bool cut = atomic_load_explicit(&render->cut, memory_order_relaxed);
	uint32_t end = cut ? atomic_load_explicit(&render->first_cut, memory_order_relaxed) : grid->first_tile + count;
	STILB_ASSERT(end >= grid->first_tile && end <= grid->tile_count);
	render->window = cut ? end - grid->first_tile : 2 * count;
	render->first_tile = end < grid->tile_count ? end : 0;
	return end < grid->tile_count;
}

static void pass_run(stilb_gi_render *render, stilb_gi_pass *pass)
{
	STILB_ASSERT(!pass->finished && pass->sample_count > 0);
	STILB_ASSERT(pass->block >= 1 && pass->block <= GI_FILM_LARGEST_BLOCK && (pass->block & (pass->block - 1)) == 0);
	PROFILE("gi.pass");
	tile_grid grid = grid_make(render, pass);
	uint64_t begun = stilb_time_ns();
	bool cut;
	do
		cut = tiles_loop(render, &grid);
	while (cut && !is_ending(render)); /* a loop without slices is cut only where the render is ending */
	stilb_gi_pass done = *pass;
	done.finished = !cut;
	double estimate = error_after(render, &done);
	done.seconds += (double)(stilb_time_ns() - begun) * 1e-9;
	stilb_lock_take(&render->lock);
	*pass = done;
	render->estimate = estimate;
	stilb_lock_give(&render->lock);
}

/* True if the error limit is met. Checked before each pass, also before the first after a resume, so that a resumed
 * render ends where an uninterrupted one does. */
static bool is_good_enough(const stilb_gi_render *render)
{
	return render->estimate <= (double)render->view.settings.error;
}

static stilb_gi_end end_of(const stilb_gi_render *render)
{
	bool stopped = atomic_load_explicit(&render->stop, memory_order_relaxed); /* see struct stilb_gi_render */
	return stopped ? STILB_GI_END_STOPPED : STILB_GI_END_SECONDS;
}

static stilb_gi_end passes_run(stilb_gi_render *render)
{
	for (;;) {
		if (is_good_enough(render))
			return STILB_GI_END_ERROR;
		stilb_gi_pass *pass = pass_next(render);
		if (!pass)
			return render->until > 0 && render->until < render->view.settings.samples ? STILB_GI_END_STOPPED
			                                                                          : STILB_GI_END_SAMPLES;
		if (is_ending(render))
			return end_of(render);
		pass_run(render, pass);
	}
}

/* ---- run --------------------------------------------------------------------------------------------------------- */

/* True if the overture, which fills the irradiance cache before the picture, must end now: on a stop, and when it has
 * used its half of the time limit. Where the cache is left without records, the picture traces paths instead. */
static bool overture_is_ending(const stilb_gi_render *render)
{
	double share = render->view.settings.seconds * OVERTURE_SHARE;
	return is_ending(render) || (render->deadline_ns && seconds_spent(render) >= share);
}

/* gi_cache_report */
static bool overture_report(void *user, const gi_cache_progress *progress)
{
	STILB_ASSERT(progress->done >= 0.0 && progress->done <= 1.0);
	stilb_gi_render *render = user;
	stilb_lock_take(&render->lock);
	render->overture_done = progress->done;
	snprintf(render->stage, sizeof render->stage, "overture %u", progress->round);
	stilb_lock_give(&render->lock);
	watch(render);
	return !overture_is_ending(render);
}

/* Runs the overture, which fills the irradiance cache before the first pass of the picture. If stop is called
 * meanwhile, the next stilb_gi_render_run continues it. */
static stilb_result overture_run(stilb_gi_render *render)
{
	if (!render->cache_fill || render->overture_finished)
		return STILB_OK;
	PROFILE("gi.overture");
	stilb_result result = gi_cache_fill_run(render->cache_fill, overture_report, render);
	render->overture_finished = result == STILB_OK && !is_ending(render);
	if (!render->overture_finished)
		return result;
	stilb_lock_take(&render->lock);
	render->overture_done = 1.0;
	stilb_lock_give(&render->lock);
	return STILB_OK;
}

static void run_begin(stilb_gi_render *render)
{
	STILB_ASSERT(render->begun_ns == 0 && "run does not run already");
	gi_film_drop_denoised(&render->film);
	double seconds = render->view.settings.seconds, left = fmax(seconds - render->seconds, 0.0);
	const stilb_gi_pass *last = render->pass_count ? &render->passes[render->pass_count - 1] : NULL;
	double estimate = error_after(render, last);
	stilb_lock_take(&render->lock);
	render->begun_ns = stilb_time_ns();
	render->deadline_ns = seconds > 0.0 ? render->begun_ns + (uint64_t)(left * 1e9) : 0;
	render->estimate = estimate;
	render->end = STILB_GI_END_NOT;
	stilb_lock_give(&render->lock);
}

static void run_end(stilb_gi_render *render, stilb_gi_end end)
{
	STILB_ASSERT(render->begun_ns != 0);
	stilb_lock_take(&render->lock);
	render->seconds = seconds_spent(render);
	render->begun_ns = 0;
	render->end = end;
	stilb_lock_give(&render->lock);
	atomic_store_explicit(&render->stop, false, memory_order_relaxed); /* see struct stilb_gi_render */
}

static bool end_is_final(stilb_gi_end end)
{
	return end == STILB_GI_END_SAMPLES || end == STILB_GI_END_SECONDS || end == STILB_GI_END_ERROR;
}

stilb_result stilb_gi_render_run(stilb_gi_render *render)
{
	STILB_ASSERT_OWNER(render->owner);
	PROFILE("gi.render");
	run_begin(render);
	stilb_result result = overture_run(render);
	stilb_gi_end end = result != STILB_OK  ? STILB_GI_END_NOT
	                   : render->feed.take ? units_run(render)
	                                       : passes_run(render);
	run_end(render, end);
	if (end_is_final(end) && render->cache_fill)
		result = gi_cache_fill_save(render->cache_fill);
	return result;
}

stilb_result stilb_gi_render_denoise(stilb_gi_render *render)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(render->begun_ns == 0 && "run does not run");
	STILB_ASSERT(render->view.settings.denoise);
	return gi_denoise(&render->film, render->pool, render->caller);
}

void stilb_gi_render_watch(stilb_gi_render *render, stilb_gi_watch_fn *fn, void *user)
{
	STILB_ASSERT(render);
	STILB_ASSERT_OWNER(render->owner);
	render->watch = fn;
	render->watch_user = user;
	render->watched_ns = 0;
}

void stilb_gi_render_stop(stilb_gi_render *render)
{
	STILB_ASSERT(render);
	atomic_store_explicit(&render->stop, true, memory_order_relaxed); /* see struct stilb_gi_render */
}

/* ---- what can be seen of it -------------------------------------------------------------------------------------- */

gi_render_totals gi_render_totals_of(const stilb_gi_render *render)
{
	gi_render_totals totals = render->resumed;
	totals.samples += atomic_load_explicit(&render->others.samples, memory_order_relaxed);
	totals.rays += atomic_load_explicit(&render->others.rays, memory_order_relaxed);
	totals.camera_rays += atomic_load_explicit(&render->others.camera_rays, memory_order_relaxed);
	totals.shadow_rays += atomic_load_explicit(&render->others.shadow_rays, memory_order_relaxed);
	totals.bad_samples += atomic_load_explicit(&render->others.bad_samples, memory_order_relaxed);
	for (uint32_t i = 0; i < render->worker_count; i++) {
		const gi_render_counters *counters = &render->workers[i].counters; /* relaxed: see gi_render_counters */
		totals.samples += atomic_load_explicit(&counters->samples, memory_order_relaxed);
		totals.rays += atomic_load_explicit(&counters->rays, memory_order_relaxed);
		totals.camera_rays += atomic_load_explicit(&counters->camera_rays, memory_order_relaxed);
		totals.shadow_rays += atomic_load_explicit(&counters->shadow_rays, memory_order_relaxed);
		totals.bad_samples += atomic_load_explicit(&counters->bad_samples, memory_order_relaxed);
	}
	return totals;
}

/* The share of the work that is done, [0, 1]: the progress towards that limit (samples, seconds or error) which is the
 * nearest. The error falls with the square root of the samples, so its ratio is squared. */
static double share_done(const stilb_gi_render *render, const stilb_gi_progress *progress, uint64_t samples)
{
	STILB_ASSERT_LOCKED(&render->lock);
	const stilb_gi_settings *settings = &render->view.settings;
	double pixels = render->share_pixels ? (double)render->share_pixels : (double)settings->width * settings->height;
	double done = (double)samples / (pixels * settings->samples);
	if (render->cache_fill)
		done = 0.5 * (render->overture_done + done); /* the overture counts as half of the work */
	if (settings->seconds > 0.0)
		done = fmax(done, progress->seconds / settings->seconds);
	if (settings->error > 0.0f && render->estimate < HUGE_VAL && render->estimate > 0.0)
		done = fmax(done, pow((double)settings->error / render->estimate, 2.0));
	return progress->finished ? 1.0 : fmin(done, 1.0);
}

/* Pixels of every block-th row and column. */
static double block_pixels(const stilb_gi_render *render, uint32_t block)
{
	return (double)parts_of(render->film.width, block) * parts_of(render->film.height, block);
}

/* Samples that a pass adds: in the first round, the coarser blocks' pixels have them. */
static double pass_samples(const stilb_gi_render *render, const stilb_gi_pass *pass)
{
	bool finer = pass->first_sample == 0 && pass > render->passes;
	double before = finer ? block_pixels(render, 2 * pass->block) : 0.0;
	return (block_pixels(render, pass->block) - before) * pass->sample_count;
}

static double pass_share(const stilb_gi_render *render, uint64_t samples)
{
	STILB_ASSERT_LOCKED(&render->lock);
	const stilb_gi_pass *last = render->pass_count ? &render->passes[render->pass_count - 1] : NULL;
	if (!last || last->finished)
		return last ? 1.0 : 0.0;
	double there = (double)samples, wanted = pass_samples(render, last);
	if (render->feed.take)
		wanted = (render->share_pixels ? (double)render->share_pixels : block_pixels(render, 1)) * last->sample_count;
	for (uint32_t i = 0; !render->feed.take && i + 1 < render->pass_count; i++)
		there -= pass_samples(render, &render->passes[i]);
	return fmax(0.0, fmin(there / wanted, 1.0));
}

static void progress_of_passes(const stilb_gi_render *render, stilb_gi_progress *progress)
{
	STILB_ASSERT_LOCKED(&render->lock);
	for (uint32_t i = 0; i < render->pass_count; i++) {
		const stilb_gi_pass *pass = &render->passes[i];
		progress->passes[i] = *pass;
		if (!pass->finished)
			continue;
		progress->block = pass->block;
		progress->samples = pass->block == 1 ? pass->first_sample + pass->sample_count : 0;
	}
	progress->pass_count = render->pass_count;
}

void stilb_gi_render_progress(stilb_gi_render *render, stilb_gi_progress *progress)
{
	STILB_ASSERT(render && progress);
	*progress = (stilb_gi_progress){0};
	gi_render_totals totals = gi_render_totals_of(render);
	gi_cache_progress cache = {0};
	if (render->cache_fill)
		cache = gi_cache_fill_progress(render->cache_fill);
	progress->rays = totals.rays + cache.rays;
	progress->camera_rays = totals.camera_rays;
	progress->shadow_rays = totals.shadow_rays + cache.shadow_rays;
	progress->bad_samples = totals.bad_samples;
	progress->records = cache.records;
	stilb_lock_take(&render->lock);
	progress->seconds = seconds_spent(render);
	progress->error = render->estimate < HUGE_VAL ? render->estimate : 0.0;
	progress->end = render->end;
	progress->finished = end_is_final(render->end);
	snprintf(progress->stage, sizeof progress->stage, "%s", render->stage);
	progress_of_passes(render, progress);
	progress->done = share_done(render, progress, totals.samples);
	progress->pass_done = pass_share(render, totals.samples);
	stilb_lock_give(&render->lock);
}

void stilb_gi_render_preview(const stilb_gi_render *render, float *rgb)
{
	STILB_ASSERT(render && rgb);
	gi_film_preview(&render->film, rgb);
	if (gi_shows_data(&render->view.settings))
		gi_data_to_light(rgb, (size_t)render->film.width * render->film.height);
}

stilb_gi_film stilb_gi_render_film(const stilb_gi_render *render)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(render->begun_ns == 0 && "run does not run");
	return gi_film_planes(&render->film);
}
