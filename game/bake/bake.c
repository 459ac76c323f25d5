/* stilb bake: a second uv for a scene, and the light that arrives at its surfaces, in files. */
#include "bake_options.h"
#include "game/commands.h"

#include "bake/bake_fill.h"
#include "bake/bake_glb.h"
#include "bake/bake_light.h"
#include "bake/bake_picture.h"
#include "bake/bake_probes.h"
#include "base/base_file.h"
#include "base/base_json.h"
#include "image/image.h"

#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define LINE_NS 10000000000u /* between two lines of progress where stderr is no terminal */
#define BAKE_PATH 4096

typedef struct bake_run {
	bake_options options;
	stilb_job_pool *pool;
	stilb_scene *scene;
	stilb_gi_scene *gi_scene;
	stilb_gi_gather *gather;
	stilb_bake_atlas *atlas;
	stilb_bake_probes probes;
	double probes_s;
	uint32_t page; /* that is being baked */
	uint64_t begun_ns, said_ns, covered, hidden;
	double open_s, unwrap_s, texels_s, light_s; /* light_s: with the files */
	double off_squares, light_squares; /* of the two-texture form: what it is off, and what there is, over all texels */
	bool terminal;
} bake_run;

/* What a page has, while it is baked. */
typedef struct bake_page {
	stilb_bake_texels *texels;
	stilb_bake_layers layers;
} bake_page;

static volatile sig_atomic_t bake_interrupted;

static void bake_on_signal(int signal_number)
{
	(void)signal_number;
	bake_interrupted = 1;
}

static double seconds_since(uint64_t start_ns)
{
	return (double)(stilb_time_ns() - start_ns) * 1e-9;
}

/* ---- progress ---------------------------------------------------------------------------------------------------- */

/* stilb_bake_watch_fn */
static bool bake_watch(void *user, double done)
{
	bake_run *run = user;
	double all = (run->page + done) / run->atlas->page_count, seconds = seconds_since(run->begun_ns);
	uint64_t now = stilb_time_ns();
	if (run->terminal || now - run->said_ns > LINE_NS) {
		run->said_ns = now;
		fprintf(stderr, "%s%.0f %%, page %u of %u, %.0f s left%s", run->terminal ? "\r" : "", 100.0 * all,
		        run->page + 1, run->atlas->page_count, all > 0.01 ? seconds * (1.0 - all) / all : 0.0,
		        run->terminal ? "\033[K" : "\n");
	}
	return bake_interrupted == 0;
}

static void bake_progress_clear(const bake_run *run)
{
	if (run->terminal)
		fprintf(stderr, "\r\033[K");
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

static void bake_path(const bake_run *run, char path[BAKE_PATH], const char *name, const char *end)
{
	if (end)
		snprintf(path, BAKE_PATH, "%s/%s-%u%s", run->options.output, name, run->page, end);
	else
		snprintf(path, BAKE_PATH, "%s/%s", run->options.output, name);
}

/* Half floats as EXR. */
static stilb_result save_halves(const bake_run *run, const float *values, uint32_t channels, const char *name)
{
	uint32_t side = run->atlas->side;
	char path[BAKE_PATH];
	stilb_image image;
	stilb_result result = stilb_image_create(&image, side, side, channels, STILB_IMAGE_F16_LINEAR);
	if (result != STILB_OK)
		return result;
	for (size_t i = 0; i < (size_t)side * side * channels; i++)
		((uint16_t *)image.pixels)[i] = stilb_image_half_from_float(fminf(values[i], 65504.0f));
	bake_path(run, path, name, ".exr");
	result = stilb_image_save(&image, path);
	stilb_image_finish(&image);
	return result;
}

/* Light from three directions: a picture each, or one of their intensities over the lightmap's. */
static stilb_result save_directional(bake_run *run, const bake_page *page)
{
	size_t count = (size_t)run->atlas->side * run->atlas->side;
	float(*one)[3] = stilb_memory_alloc(count, sizeof *one);
	stilb_result result = STILB_OK;
	if (!one)
		return stilb_fail(STILB_ERROR_MEMORY, "out of memory for a page of %zu texels", count);
	for (uint32_t k = 0; k < STILB_BAKE_BASIS && result == STILB_OK && (run->options.what & BAKE_RNM); k++) {
		char name[16];
		snprintf(name, sizeof name, "rnm%u", k + 1);
		for (size_t i = 0; i < count; i++)
			memcpy(one[i], page->layers.directional[i][k], sizeof one[i]);
		result = save_halves(run, one[0], 3, name);
	}
	if (result == STILB_OK && (run->options.what & BAKE_INTENSITY)) {
		for (size_t i = 0; i < count; i++) {
			const float *light = page->layers.light[i];
			stilb_bake_intensities(page->layers.directional[i], one[i]);
			for (uint32_t k = 0; k < STILB_BAKE_BASIS; k++)
				for (int c = 0; c < 3; c++) {
					double off = (double)(page->layers.directional[i][k][c] - light[c] * one[i][k]);
					run->off_squares += off * off;
					run->light_squares += (double)(light[c] * light[c]);
				}
		}
		result = save_halves(run, one[0], 3, "intensity");
	}
	free(one);
	return result;
}

/* Shares of 1 as data of 8 bits, grey. */
static stilb_result save_shares(const bake_run *run, const float *values, const char *name)
{
	uint32_t side = run->atlas->side;
	char path[BAKE_PATH];
	stilb_image image;
	stilb_result result = stilb_image_create(&image, side, side, 1, STILB_IMAGE_U8_LINEAR);
	if (result != STILB_OK)
		return result;
	for (size_t i = 0; i < (size_t)side * side; i++)
		((uint8_t *)image.pixels)[i] = (uint8_t)(values[i] * 255.0f + 0.5f);
	bake_path(run, path, name, ".png");
	result = stilb_image_save(&image, path);
	stilb_image_finish(&image);
	return result;
}

static void picture_states(const bake_page *page, uint8_t (*srgb)[3])
{
	static const uint8_t colors[][3] = {[STILB_BAKE_EMPTY] = {24, 24, 24},
	                                    [STILB_BAKE_FILLED] = {60, 90, 160},
	                                    [STILB_BAKE_HIDDEN] = {220, 60, 40},
	                                    [STILB_BAKE_LIT] = {230, 220, 190}};
	for (size_t i = 0; i < (size_t)page->texels->side * page->texels->side; i++) {
		bool was_hidden = page->layers.state[i] == STILB_BAKE_FILLED && page->texels->place[i] != STILB_BAKE_NO_CHART;
		memcpy(srgb[i], colors[was_hidden ? STILB_BAKE_HIDDEN : page->layers.state[i]], sizeof srgb[i]);
	}
}

/* Writes a picture of the page. draw: which of --show. */
static stilb_result save_picture(const bake_run *run, const bake_page *page, uint32_t draw, const char *name)
{
	uint32_t side = run->atlas->side;
	char path[BAKE_PATH];
	stilb_image image;
	stilb_result result = stilb_image_create(&image, side, side, 3, STILB_IMAGE_U8_SRGB);
	if (result != STILB_OK)
		return result;
	if (draw == BAKE_SHOW_CHARTS)
		stilb_bake_picture_charts(page->texels, image.pixels);
	else if (draw == BAKE_SHOW_TEXELS)
		stilb_bake_picture_texels(page->texels, image.pixels);
	else if (draw == BAKE_SHOW_STATES)
		picture_states(page, image.pixels);
	else
		stilb_gi_display(page->layers.light[0], (size_t)side * side, run->scene->camera.exposure,
		                 run->scene->camera.tone, image.pixels);
	bake_path(run, path, name, ".png");
	result = stilb_image_save(&image, path);
	stilb_image_finish(&image);
	return result;
}

static stilb_result save_glb(bake_run *run)
{
	if (!(run->options.what & BAKE_GLB))
		return STILB_OK;
	char path[BAKE_PATH];
	stilb_bake_glb_files files = {.lightmap =
	                                  run->options.what & (BAKE_LIGHTMAP | BAKE_INTENSITY) ? "lightmap-%u.exr" : NULL,
	                              .occlusion = run->options.what & BAKE_AO ? "ao-%u.png" : NULL};
	bake_path(run, path, "scene.glb", NULL);
	return stilb_bake_glb_save(run->scene, run->atlas, &files, path);
}

/* What was made, and how: bake.json. */
static stilb_result save_report(bake_run *run)
{
	const bake_options *o = &run->options;
	const stilb_bake_atlas *atlas = run->atlas;
	char path[BAKE_PATH];
	stilb_json json = {0};
	stilb_json_begin(&json, NULL, '{');
	stilb_json_string(&json, "version", STILB_VERSION);
	stilb_json_string(&json, "scene", o->scene);
	stilb_json_int(&json, "page_side", atlas->side);
	stilb_json_int(&json, "pages", atlas->page_count);
	stilb_json_int(&json, "border", atlas->border);
	stilb_json_double(&json, "texels_per_unit", (double)atlas->density);
	stilb_json_int(&json, "charts", atlas->place_count);
	stilb_json_int(&json, "triangles", (int64_t)atlas->triangles);
	stilb_json_int(&json, "triangles_flat", (int64_t)atlas->flat);
	stilb_json_int(&json, "triangles_invalid", (int64_t)atlas->invalid);
	stilb_json_int(&json, "charts_coarser", atlas->coarser);
	stilb_json_double(&json, "stretch", atlas->stretch);
	stilb_json_double(&json, "covered", atlas->covered);
	stilb_json_int(&json, "texels_lit", (int64_t)(run->covered - run->hidden));
	stilb_json_int(&json, "texels_hidden", (int64_t)run->hidden);
	if (run->light_squares > 0.0)
		stilb_json_double(&json, "intensity_error", sqrt(run->off_squares / run->light_squares));
	stilb_json_int(&json, "samples", (int64_t)o->samples);
	stilb_json_int(&json, "depth", (int64_t)o->depth);
	stilb_json_int(&json, "rays", run->gather ? (int64_t)stilb_gi_gather_rays(run->gather) : 0);
	stilb_json_double(&json, "open_s", run->open_s);
	stilb_json_double(&json, "unwrap_s", run->unwrap_s);
	stilb_json_double(&json, "texels_s", run->texels_s);
	stilb_json_double(&json, "light_s", run->light_s);
	stilb_json_begin(&json, "parts", '[');
	for (uint32_t part = 0; part < atlas->part_count; part++) {
		if (atlas->parts[part].uv == STILB_BAKE_NO_CHART)
			continue;
		stilb_json_begin(&json, NULL, '{');
		stilb_json_int(&json, "part", part);
		stilb_json_int(&json, "mesh", run->scene->part_mesh[part]);
		stilb_json_int(&json, "charts", atlas->uvs[atlas->parts[part].uv].chart_count);
		stilb_json_end(&json, '}');
	}
	stilb_json_end(&json, ']');
	stilb_json_end(&json, '}');
	bake_path(run, path, "bake.json", NULL);
	return stilb_json_save(&json, path);
}

/* ---- pages ------------------------------------------------------------------------------------------------------- */

static bool page_lights(const bake_run *run)
{
	return run->options.what & ~(uint32_t)(BAKE_GLB | BAKE_PROBES);
}

static stilb_result page_begin(bake_run *run, bake_page *page)
{
	size_t count = (size_t)run->atlas->side * run->atlas->side;
	uint64_t start = stilb_time_ns();
	stilb_result result = stilb_bake_texels_create(run->atlas, run->page, run->pool, &page->texels);
	run->texels_s += seconds_since(start);
	if (result != STILB_OK || !page_lights(run))
		return result;
	/* Which texels are hidden is known from the lightmap's rays. */
	stilb_bake_layers *layers = &page->layers;
	bool open = run->options.what & BAKE_AO, directional = run->options.what & (BAKE_RNM | BAKE_INTENSITY);
	layers->light = stilb_memory_alloc(count, sizeof *layers->light);
	layers->open = open ? stilb_memory_alloc(count, sizeof *layers->open) : NULL;
	layers->directional = directional ? stilb_memory_alloc(count, sizeof *layers->directional) : NULL;
	layers->state = stilb_memory_alloc(count, 1);
	if (layers->light && layers->state && (layers->open || !open) && (layers->directional || !directional))
		return STILB_OK;
	return stilb_fail(STILB_ERROR_MEMORY, "out of memory for a page of %u x %u texels", run->atlas->side,
	                  run->atlas->side);
}

static void page_finish(bake_page *page)
{
	stilb_bake_texels_destroy(page->texels);
	free(page->layers.light);
	free(page->layers.open);
	free(page->layers.directional);
	free(page->layers.state);
	*page = (bake_page){0};
}

static stilb_result page_light(bake_run *run, bake_page *page)
{
	const bake_options *o = &run->options;
	uint32_t side = run->atlas->side, border = run->atlas->border;
	stilb_bake_light_options options = {.samples = (uint32_t)o->samples,
	                                    .ao_distance = o->ao_distance > 0.0f ? o->ao_distance : INFINITY,
	                                    .keep_hidden = o->hidden == 1,
	                                    .watch = bake_watch,
	                                    .user = run};
	stilb_bake_layers *layers = &page->layers;
	stilb_result result =
		stilb_bake_light(run->scene, run->atlas, page->texels, run->gather, run->pool, &options, layers);
	bake_progress_clear(run);
	for (size_t i = 0; i < (size_t)side * side && result == STILB_OK; i++)
		run->hidden += page->layers.state[i] == STILB_BAKE_HIDDEN;
	if (result == STILB_OK && layers->open)
		result = stilb_bake_fill(side, page->texels->place, border, layers->state, false, layers->open, 1);
	if (result == STILB_OK && layers->directional)
		result = stilb_bake_fill(side, page->texels->place, border, layers->state, false, layers->directional[0][0],
		                         3 * STILB_BAKE_BASIS);
	if (result == STILB_OK)
		result = stilb_bake_fill(side, page->texels->place, border, layers->state, true, layers->light[0], 3);
	return result;
}

static stilb_result page_save(bake_run *run, const bake_page *page)
{
	const bake_options *o = &run->options;
	stilb_result result = STILB_OK;
	if (o->show & BAKE_SHOW_CHARTS)
		result = save_picture(run, page, BAKE_SHOW_CHARTS, "charts");
	if (result == STILB_OK && (o->show & BAKE_SHOW_TEXELS))
		result = save_picture(run, page, BAKE_SHOW_TEXELS, "texels");
	if (result == STILB_OK && (o->show & BAKE_SHOW_STATES) && page->layers.state)
		result = save_picture(run, page, BAKE_SHOW_STATES, "states");
	if (result == STILB_OK && (o->show & BAKE_SHOW_LIGHT) && page->layers.light)
		result = save_picture(run, page, BAKE_SHOW_LIGHT, "light");
	if (result == STILB_OK && (o->what & (BAKE_LIGHTMAP | BAKE_INTENSITY)) && page->layers.light)
		result = save_halves(run, page->layers.light[0], 3, "lightmap");
	if (result == STILB_OK && page->layers.directional)
		result = save_directional(run, page);
	if (result == STILB_OK && page->layers.open)
		result = save_halves(run, page->layers.open, 1, "ao");
	if (result == STILB_OK && page->layers.open)
		result = save_shares(run, page->layers.open, "ao");
	return result;
}

static stilb_result bake_pages(bake_run *run)
{
	stilb_result result = STILB_OK;
	run->begun_ns = run->said_ns = stilb_time_ns();
	if (!page_lights(run) && run->options.show == 0)
		return STILB_OK;
	for (run->page = 0; run->page < run->atlas->page_count && result == STILB_OK; run->page++) {
		bake_page page = {0};
		result = page_begin(run, &page);
		if (result == STILB_OK)
			run->covered += page.texels->covered;
		if (result == STILB_OK && page_lights(run))
			result = page_light(run, &page);
		if (result == STILB_OK)
			result = page_save(run, &page);
		page_finish(&page);
	}
	run->light_s = seconds_since(run->begun_ns) - run->texels_s;
	return result;
}

/* ---- probes ------------------------------------------------------------------------------------------------------ */

/* stilb_bake_watch_fn */
static bool probes_watch(void *user, double done)
{
	bake_run *run = user;
	uint64_t now = stilb_time_ns();
	if (run->terminal || now - run->said_ns > LINE_NS) {
		run->said_ns = now;
		fprintf(stderr, "%s%.0f %%, probes%s", run->terminal ? "\r" : "", 100.0 * done,
		        run->terminal ? "\033[K" : "\n");
	}
	return bake_interrupted == 0;
}

/* How far probes see: a tile of 8 x 8 for each, (x, y, z) at column x and row y + z * count[1] of tiles. */
static stilb_result save_seen(const bake_run *run)
{
	const stilb_bake_probes *p = &run->probes;
	uint32_t width = p->count[0] * STILB_BAKE_SEEN, height = p->count[1] * p->count[2] * STILB_BAKE_SEEN;
	char path[BAKE_PATH];
	stilb_image image;
	stilb_result result = stilb_image_create(&image, width, height, 4, STILB_IMAGE_F16_LINEAR);
	if (result != STILB_OK)
		return result;
	for (uint32_t y = 0; y < height; y++)
		for (uint32_t x = 0; x < width; x++) {
			const stilb_bake_probe *probe = &p->probes[y / STILB_BAKE_SEEN * p->count[0] + x / STILB_BAKE_SEEN];
			const float *from = probe->seen[y % STILB_BAKE_SEEN * STILB_BAKE_SEEN + x % STILB_BAKE_SEEN];
			for (int k = 0; k < 4; k++)
				((uint16_t *)image.pixels)[4 * ((size_t)y * width + x) + (size_t)k] =
					stilb_image_half_from_float(from[k]);
		}
	bake_path(run, path, "probes-seen.exr", NULL);
	result = stilb_image_save(&image, path);
	stilb_image_finish(&image);
	return result;
}

static void put_numbers(stilb_json *json, const char *key, const float *values, uint32_t count)
{
	stilb_json_begin(json, key, '[');
	for (uint32_t i = 0; i < count; i++)
		stilb_json_float(json, NULL, values[i]);
	stilb_json_end(json, ']');
}

static stilb_result save_probes(const bake_run *run)
{
	const stilb_bake_probes *p = &run->probes;
	char path[BAKE_PATH];
	stilb_json json = {0};
	stilb_json_begin(&json, NULL, '{');
	stilb_json_begin(&json, "count", '[');
	for (int k = 0; k < 3; k++)
		stilb_json_int(&json, NULL, p->count[k]);
	stilb_json_end(&json, ']');
	put_numbers(&json, "low", p->low, 3);
	stilb_json_float(&json, "spacing", p->spacing);
	stilb_json_int(&json, "moved", p->moved);
	stilb_json_int(&json, "dead", p->dead);
	stilb_json_begin(&json, "probes", '[');
	for (uint32_t i = 0; i < p->count[0] * p->count[1] * p->count[2]; i++) {
		const stilb_bake_probe *probe = &p->probes[i];
		stilb_json_begin(&json, NULL, '{');
		put_numbers(&json, "position", probe->position, 3);
		stilb_json_bool(&json, "dead", probe->dead);
		put_numbers(&json, "r", probe->light.r.c, 9);
		put_numbers(&json, "g", probe->light.g.c, 9);
		put_numbers(&json, "b", probe->light.b.c, 9);
		stilb_json_end(&json, '}');
	}
	stilb_json_end(&json, ']');
	stilb_json_end(&json, '}');
	bake_path(run, path, "probes.json", NULL);
	return stilb_json_save(&json, path);
}

static stilb_result bake_probes(bake_run *run)
{
	const bake_options *o = &run->options;
	if (!(o->what & BAKE_PROBES))
		return STILB_OK;
	uint64_t start = run->said_ns = stilb_time_ns();
	stilb_gi_settings settings = stilb_gi_settings_default(run->scene);
	settings.samples = (uint32_t)o->probe_samples;
	settings.depth = (uint32_t)o->depth;
	settings.only = (stilb_gi_only)o->only;
	settings.seed = o->seed;
	stilb_bake_probes_options options = {
		.spacing = o->probe_spacing, .samples = (uint32_t)o->probe_samples, .watch = probes_watch, .user = run};
	stilb_gi_gather *gather;
	stilb_result result =
		stilb_gi_gather_create(run->gi_scene, &settings, stilb_job_pool_worker_count(run->pool) + 1, &gather);
	if (result != STILB_OK)
		return result;
	result = stilb_bake_probes_bake(run->scene, run->gi_scene, gather, run->pool, &options, &run->probes);
	bake_progress_clear(run);
	stilb_gi_gather_destroy(gather);
	run->probes_s = seconds_since(start);
	if (result == STILB_OK)
		result = save_probes(run);
	return result == STILB_OK ? save_seen(run) : result;
}

/* ---- the command ------------------------------------------------------------------------------------------------- */

static stilb_result bake_pool(bake_run *run)
{
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	uint32_t threads = run->options.workers;
	if (threads == FLAG_WORKERS_AUTO)
		threads = stilb_job_cpu_count();
	desc.worker_count = threads - 1; /* the main thread works as well */
	desc.affinity = STILB_JOB_AFFINITY_NONE;
	int error = stilb_job_pool_create(&desc, &run->pool);
	return error == 0 ? STILB_OK : stilb_fail_threads(threads, -error);
}

static stilb_result bake_open(bake_run *run)
{
	uint64_t start = stilb_time_ns();
	stilb_scene_open_options open = {.allow_outside = run->options.allow_outside, .quiet = run->options.quiet};
	stilb_result result = stilb_scene_open_with(run->options.scene, &open, &run->scene);
	if (result == STILB_OK && run->options.environment)
		result = stilb_scene_set_environment(run->scene, run->options.environment);
	run->open_s = seconds_since(start);
	return result;
}

static stilb_result bake_unwrap(bake_run *run)
{
	const bake_options *o = &run->options;
	uint64_t start = stilb_time_ns();
	stilb_bake_atlas_options options = stilb_bake_atlas_options_default();
	options.unwrap.cone = o->cone * 0.017453293f;
	options.unwrap.crease = o->crease * 0.017453293f;
	options.density = o->density;
	options.side = (uint32_t)o->side;
	options.mips = (uint32_t)o->mips;
	stilb_result result = stilb_bake_atlas_create(run->scene, &options, run->pool, &run->atlas);
	run->unwrap_s = seconds_since(start);
	if (result != STILB_OK)
		return result;
	const stilb_bake_atlas *atlas = run->atlas;
	if (atlas->page_count == 0)
		return stilb_fail(STILB_ERROR_ARGUMENT, "'%s' has no triangles with an area: nothing to bake", o->scene);
	if (atlas->coarser > 0)
		stilb_log("%u charts have fewer than %.3g texels a metre, as they would not fit on a page of %u; give a larger "
		          "--page, or fewer --texels-per-unit",
		          atlas->coarser, (double)atlas->density, atlas->side);
	if (atlas->flat + atlas->invalid > 0 && !o->quiet)
		stilb_log("%llu triangles have no texels: %llu of area 0, %llu with a corner that is no place",
		          (unsigned long long)atlas->flat + (unsigned long long)atlas->invalid, (unsigned long long)atlas->flat,
		          (unsigned long long)atlas->invalid);
	return STILB_OK;
}

static stilb_result bake_prepare(bake_run *run)
{
	const bake_options *o = &run->options;
	if (!page_lights(run) && !(o->what & BAKE_PROBES))
		return STILB_OK;
	stilb_gi_scene_desc desc = stilb_gi_scene_desc_default(run->pool);
	stilb_result result = stilb_gi_scene_create(run->scene, &desc, &run->gi_scene);
	if (result != STILB_OK)
		return result;
	stilb_gi_settings settings = stilb_gi_settings_default(run->scene);
	settings.samples = (uint32_t)o->samples;
	settings.depth =
		o->what & ~(BAKE_AO | BAKE_GLB) ? (uint32_t)o->depth : 1; /* of openness alone, for hidden texels */
	settings.only = (stilb_gi_only)o->only;
	settings.seed = o->seed;
	return stilb_gi_gather_create(run->gi_scene, &settings, stilb_job_pool_worker_count(run->pool) + 1, &run->gather);
}

/* Makes the folder if it is not there, and finds out whether files can be written to it. */
static stilb_result bake_folder(bake_run *run)
{
	const char *folder = run->options.output;
	char path[BAKE_PATH];
	if (strlen(folder) > BAKE_PATH - 64)
		return stilb_fail(STILB_ERROR_ARGUMENT, "-o: the name of the folder is too long");
	if (mkdir(folder, 0777) != 0 && errno != EEXIST)
		return stilb_fail(STILB_ERROR_ARGUMENT, "-o: cannot make the folder '%s': %s", folder, strerror(errno));
	bake_path(run, path, "bake.json", NULL);
	return stilb_file_check(path);
}

static stilb_result bake_all(bake_run *run)
{
	stilb_result (*const steps[])(bake_run *) = {bake_folder, bake_pool, bake_open,   bake_unwrap, bake_prepare,
	                                             bake_pages,  save_glb,  bake_probes, save_report};
	size_t count = sizeof steps / sizeof *steps;
	stilb_result result = STILB_OK;
	for (size_t i = 0; i < count && result == STILB_OK; i++) {
		result = steps[i](run);
		if (result == STILB_OK && bake_interrupted && i + 1 < count)
			result = stilb_fail(STILB_ERROR_GIVEN_UP, "ended by a signal; pages that were finished stay");
	}
	return result;
}

static void bake_say(const bake_run *run)
{
	const stilb_bake_atlas *a = run->atlas;
	printf("unwrapped: %llu triangles in %u charts, stretch %.3f, %.2f s\n", (unsigned long long)a->triangles,
	       a->place_count, a->stretch, run->unwrap_s);
	printf("pages:     %u of %u x %u, %.4g texels a metre, %.0f %% covered\n", a->page_count, a->side, a->side,
	       (double)a->density, 100.0 * a->covered);
	if (page_lights(run)) {
		double rays = (double)stilb_gi_gather_rays(run->gather);
		printf("light:     %llu texels, %llu hidden, %.3g Mrays, %.2f s\n", (unsigned long long)run->covered,
		       (unsigned long long)run->hidden, rays * 1e-6, run->light_s);
	}
	if (run->options.what & BAKE_PROBES)
		printf("probes:    %u x %u x %u, %.3g m apart, %u moved, %u dead, %.2f s\n", run->probes.count[0],
		       run->probes.count[1], run->probes.count[2], (double)run->probes.spacing, run->probes.moved,
		       run->probes.dead, run->probes_s);
	printf("files:     %s\n", run->options.output);
}

static void bake_finish(bake_run *run)
{
	stilb_bake_probes_finish(&run->probes);
	stilb_gi_gather_destroy(run->gather);
	stilb_gi_scene_destroy(run->gi_scene);
	stilb_bake_atlas_destroy(run->atlas);
	stilb_scene_destroy(run->scene);
	stilb_job_pool_destroy(run->pool);
}

int bake_command(int argc, char **argv)
{
	bake_run run = {.terminal = isatty(STDERR_FILENO)};
	flags_result parsed = bake_options_parse(&run.options, argc, argv);
	if (parsed != FLAGS_OK)
		return parsed == FLAGS_HELP ? EXIT_DONE : EXIT_REFUSED;
	struct sigaction once = {.sa_handler = bake_on_signal, .sa_flags = (int)SA_RESETHAND};
	sigaction(SIGINT, &once, NULL);
	sigaction(SIGTERM, &once, NULL);
	stilb_result result = bake_all(&run);
	if (result == STILB_OK)
		bake_say(&run);
	else
		stilb_log("%s", stilb_error_message());
	bake_finish(&run);
	return result == STILB_ERROR_GIVEN_UP ? EXIT_FAILED : exit_code_of(result);
}
