/* gi_farm: a render as work for many machines, parts of it as files, and a picture from parts. */
#include "gi/gi_farm.h"

#include "gi/film/gi_denoise.h"
#include "gi/film/gi_identity.h"
#include "gi/film/gi_picture.h"
#include "gi/gi_render_internal.h"
#include "gi/gi_settings.h"
#include "profiler/prof.h"

#include <stdlib.h>
#include <string.h>

/* ---- a render as work -------------------------------------------------------------------------------------------- */

stilb_result stilb_gi_farm_begin(stilb_gi_render *render)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(render->begun_ns == 0 && "run does not run");
	const stilb_gi_settings *settings = &render->view.settings;
	if (settings->seconds > 0.0)
		return stilb_fail(STILB_ERROR_ARGUMENT, "a limit of time gives other bits on every machine: a picture of many "
		                                        "machines ends by its samples alone");
	if (settings->error > 0.0f)
		return stilb_fail(STILB_ERROR_ARGUMENT, "a limit of error is of the whole picture, which no machine has: a "
		                                        "picture of many machines ends by its samples alone");
	if (render->cache_fill && settings->cache.mode == STILB_GI_CACHE_LIVE)
		return stilb_fail(STILB_ERROR_ARGUMENT, "a live irradiance cache gives other bits in every run: a picture of "
		                                        "many machines needs a frozen one");
	if (render->units.order)
		return STILB_OK;
	return gi_units_create(settings->width, settings->height, settings->samples, &render->units)
	           ? STILB_OK
	           : stilb_fail(STILB_ERROR_MEMORY, "out of memory for the units of a picture");
}

/* ---- work ---- */

/* How the functions of work see a film: a render's, or one that parts are merged into. */
static stilb_farm_state units_state(const gi_units *units, const gi_film *film, uint32_t unit, uint32_t samples)
{
	uint32_t least, most;
	gi_unit_samples(units, film, unit, &least, &most);
	return least >= samples ? STILB_FARM_WHOLE : most > 0 ? STILB_FARM_BEGUN : STILB_FARM_NEW;
}

static stilb_farm_state work_state(void *user, uint32_t unit)
{
	const stilb_gi_render *render = user;
	return units_state(&render->units, &render->film, unit, render->view.settings.samples);
}

static void work_get(void *user, uint32_t unit, void *result)
{
	const stilb_gi_render *render = user;
	gi_unit_get(&render->units, &render->film, unit, result);
}

static bool work_set(void *user, uint32_t unit, const void *result, bool whole)
{
	stilb_gi_render *render = user;
	uint32_t samples = render->view.settings.samples;
	return gi_unit_set(&render->units, &render->film, unit, whole ? samples : 0, samples, result);
}

stilb_farm_work stilb_gi_farm_work(stilb_gi_render *render)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(render->units.order && "after stilb_gi_farm_begin");
	if (!render->identity)
		render->identity = stilb_memory_alloc(1, sizeof *render->identity);
	if (render->identity)
		gi_identity_make(render, GI_IDENTITY_PART, render->identity);
	return (stilb_farm_work){.identity = render->identity ? render->identity->text : NULL,
	                         .unit_count = render->units.count,
	                         .unit_size = gi_unit_size(&render->units, &render->film),
	                         .state = work_state,
	                         .get = work_get,
	                         .set = work_set,
	                         .user = render};
}

void stilb_gi_farm_feed(stilb_gi_render *render, const stilb_farm_feed *feed)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(render->units.order && render->begun_ns == 0);
	STILB_ASSERT(feed->take && feed->done && feed->back);
	render->feed = *feed;
}

void stilb_gi_farm_count(stilb_gi_render *render, const stilb_gi_farm_counts *more)
{
	gi_render_counters *others = &render->others; /* relaxed: see gi_render_counters */
	atomic_fetch_add_explicit(&others->samples, more->samples, memory_order_relaxed);
	atomic_fetch_add_explicit(&others->rays, more->rays, memory_order_relaxed);
	atomic_fetch_add_explicit(&others->camera_rays, more->camera_rays, memory_order_relaxed);
	atomic_fetch_add_explicit(&others->shadow_rays, more->shadow_rays, memory_order_relaxed);
	atomic_fetch_add_explicit(&others->bad_samples, more->bad_samples, memory_order_relaxed);
}

stilb_gi_farm_counts stilb_gi_farm_counted(const stilb_gi_render *render)
{
	gi_render_totals totals = gi_render_totals_of(render);
	return (stilb_gi_farm_counts){.samples = totals.samples,
	                              .rays = totals.rays,
	                              .camera_rays = totals.camera_rays,
	                              .shadow_rays = totals.shadow_rays,
	                              .bad_samples = totals.bad_samples};
}

/* ---- a share of it ----------------------------------------------------------------------------------------------- */

/* The feed of a share: its units in order. Those that a checkpoint brought are found whole, and cost nothing. */
static stilb_farm_taken share_take(void *user, uint32_t *unit)
{
	stilb_gi_render *render = user;
	stilb_farm_range range = stilb_farm_share(render->units.count, render->share_index, render->share_of);
	/* Relaxed: the units' pixels are read and written by who takes them alone, until the loop has ended. */
	uint32_t next = atomic_fetch_add_explicit(&render->share_next, 1, memory_order_relaxed);
	*unit = range.first + next;
	return next < range.count ? STILB_FARM_TAKEN : STILB_FARM_NO_MORE;
}

/* done and back */
static void share_keep(void *user, uint32_t unit)
{
	(void)user;
	(void)unit;
}

stilb_result stilb_gi_farm_share(stilb_gi_render *render, uint32_t index, uint32_t of)
{
	STILB_ASSERT(index >= 1 && index <= of);
	stilb_result result = stilb_gi_farm_begin(render);
	if (result != STILB_OK)
		return result;
	stilb_farm_range range = stilb_farm_share(render->units.count, index, of);
	stilb_gi_farm_feed(render, &(stilb_farm_feed){share_take, share_keep, share_keep, render});
	render->share_index = index;
	render->share_of = of;
	render->share_pixels = gi_unit_pixels(&render->units, range.first, range.count);
	return STILB_OK;
}

enum { NOTE_RAYS, NOTE_NANOSECONDS };

stilb_result stilb_gi_farm_save_part(const stilb_gi_render *render, const char *path)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(render->begun_ns == 0 && render->share_of > 0 && render->end == STILB_GI_END_SAMPLES);
	PROFILE("gi.part");
	gi_render_totals totals = gi_render_totals_of(render);
	uint64_t notes[STILB_FARM_NOTES] = {
		[NOTE_RAYS] = totals.rays, [NOTE_NANOSECONDS] = (uint64_t)(render->seconds * 1e9)};
	stilb_farm_work work = stilb_gi_farm_work((stilb_gi_render *)render); /* fills its identity alone */
	if (!work.identity)
		return stilb_fail(STILB_ERROR_MEMORY, "cannot write '%s': out of memory", path);
	return stilb_farm_part_save(&work, render->share_index, render->share_of, notes, path);
}

/* ---- a picture from parts ---------------------------------------------------------------------------------------- */

typedef struct merge_picture {
	stilb_gi_settings settings;
	gi_units units;
	gi_film film;
	gi_picture picture;
	char isa[GI_SETTING_TEXT], surroundings[GI_SURROUNDINGS_TEXT];
} merge_picture;

static stilb_farm_state merge_state(void *user, uint32_t unit)
{
	const merge_picture *merge = user;
	return units_state(&merge->units, &merge->film, unit, merge->settings.samples);
}

static void merge_get(void *user, uint32_t unit, void *result)
{
	const merge_picture *merge = user;
	gi_unit_get(&merge->units, &merge->film, unit, result);
}

static bool merge_set(void *user, uint32_t unit, const void *result, bool whole)
{
	merge_picture *merge = user;
	uint32_t samples = merge->settings.samples;
	return gi_unit_set(&merge->units, &merge->film, unit, whole ? samples : 0, samples, result);
}

static bool merge_text(const char *identity, const char *name, char *text, size_t size)
{
	int length;
	const char *value = stilb_farm_value(identity, name, &length);
	if (value)
		snprintf(text, size, "%.*s", length, value);
	return value;
}

/* Reads all that the picture's file says from the identity. */
static bool merge_settings(const char *identity, merge_picture *merge)
{
	char text[GI_SETTING_TEXT];
	bool good = true;
	for (uint32_t i = 0; good && i < gi_settings_count(); i++) {
		gi_setting setting = gi_settings_get(&merge->settings, i);
		good = merge_text(identity, setting.name, text, sizeof text) && gi_settings_put(&merge->settings, i, text);
	}
	good = good && merge_text(identity, "isa", merge->isa, sizeof merge->isa) &&
	       merge_text(identity, "alpha", text, sizeof text);
	merge->picture.transparent = good && strcmp(text, "yes") == 0;
	static const char last[] = "\nsurroundings "; /* to the end: a file's name in it may have lines */
	const char *words = strstr(identity, last);
	if (!good || !words || gi_settings_check(&merge->settings) != STILB_OK)
		return false;
	words += sizeof last - 1;
	snprintf(merge->surroundings, sizeof merge->surroundings, "%.*s", (int)strlen(words) - 1, words);
	return true;
}

static stilb_result merge_begin(const stilb_farm_part *part, merge_picture *merge)
{
	stilb_result result = STILB_OK;
	if (!merge_settings(part->identity, merge))
		return stilb_fail(STILB_ERROR_FILE, "'%s' is no part of a picture of this version; make it again", part->path);
	const stilb_gi_settings *settings = &merge->settings;
	if (!gi_units_create(settings->width, settings->height, settings->samples, &merge->units))
		result = stilb_fail(STILB_ERROR_MEMORY, "out of memory for the units of a picture");
	if (result == STILB_OK)
		result = gi_film_create(&merge->film, settings->width, settings->height, gi_film_kind_of(settings));
	if (result == STILB_OK && (part->head.unit_count != merge->units.count ||
	                           part->head.unit_size != gi_unit_size(&merge->units, &merge->film)))
		result = stilb_fail(STILB_ERROR_FILE, "'%s' is damaged; make this part again", part->path);
	merge->picture.settings = settings;
	merge->picture.film = &merge->film;
	merge->picture.surroundings = merge->surroundings;
	merge->picture.isa = merge->isa;
	return result;
}

static stilb_result merge_parts(stilb_farm_part *const *parts, uint32_t count, const char *output, stilb_job_pool *pool,
                                stilb_gi_farm_merged *merged)
{
	stilb_result result = stilb_farm_parts_check(parts, count);
	if (result != STILB_OK)
		return result;
	merge_picture merge = {0};
	result = merge_begin(parts[0], &merge);
	stilb_farm_work work = {.identity = parts[0]->identity,
	                        .unit_count = merge.units.count,
	                        .unit_size = parts[0]->head.unit_size,
	                        .state = merge_state,
	                        .get = merge_get,
	                        .set = merge_set,
	                        .user = &merge};
	*merged = (stilb_gi_farm_merged){merge.settings.width, merge.settings.height, merge.settings.samples, 0, 0.0};
	for (uint32_t i = 0; i < count && result == STILB_OK; i++) {
		result = stilb_farm_part_merge(parts[i], &work);
		merged->rays += parts[i]->head.notes[NOTE_RAYS];
		merged->seconds += (double)parts[i]->head.notes[NOTE_NANOSECONDS] * 1e-9;
	}
	if (result == STILB_OK && merge.settings.denoise)
		result = gi_denoise(&merge.film, pool, 0);
	if (result == STILB_OK)
		result = gi_picture_save(&merge.picture, output);
	gi_film_finish(&merge.film);
	free(merge.units.order);
	return result;
}

stilb_result stilb_gi_farm_merge(const char *const *paths, uint32_t count, const char *output, stilb_job_pool *pool,
                                 stilb_gi_farm_merged *merged)
{
	STILB_ASSERT(paths && count >= 1 && output && pool && merged);
	PROFILE("gi.merge");
	stilb_farm_part **parts = calloc(count, sizeof *parts);
	stilb_result result = parts ? STILB_OK : stilb_fail(STILB_ERROR_MEMORY, "no memory for %u parts", count);
	for (uint32_t i = 0; i < count && result == STILB_OK; i++)
		result = stilb_farm_part_open(paths[i], &parts[i]);
	if (result == STILB_OK)
		result = merge_parts(parts, count, output, pool, merged);
	for (uint32_t i = 0; parts && i < count; i++)
		stilb_farm_part_close(parts[i]);
	free(parts);
	return result;
}
