/* The lights of views, as shaders read them: all in one array, and for views with many of them the lists of their cells
 * (light/light.h), by which a pixel asks those that reach it. */
#include "image/image.h"
#include "light/light_reached.h"
#include "render/render_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LIGHTS_FEW 8u /* so many lights that end somewhere are faster without lists */
/* Pixels of a cell's sides, and slices of depth: on GPUs, and on software devices, where a pixel's lights take
 * thousands of times as long as finding them. */
#define LIGHTS_TILE 32u
#define LIGHTS_SLICES 24u
#define LIGHTS_TILE_SOFTWARE 8u /* doubled until there are at most this many cells */
#define LIGHTS_CELLS_SOFTWARE (1u << 20)
#define LIGHTS_SLICES_SOFTWARE 96u
#define LIGHTS_TILE_SHOWN 16u /* of a tile's sides, without slices */
/* Mesa's software devices end all loops of a pixel, or of a thread, after so many turns together. */
#define LIGHTS_TURNS_SOFTWARE 65535u
#define LIGHTS_RANGE 256.0f /* the last one begins so much farther away than the first one ends, at most */

/* What lights that are left out of a cell may send, W sr^-1 m^-2. */
static float lights_tolerance(const stilb_render_view *view)
{
	bool deferred =
		view->lighting == STILB_RENDER_LIGHTING_DEFERRED && view->deferred.coverage == STILB_RENDER_COVERAGE_CELLS;
	bool lists = view->lighting == STILB_RENDER_LIGHTING_AUTO || view->lighting == STILB_RENDER_LIGHTING_CLUSTERED;
	return deferred || lists ? view->light_tolerance * exp2f(-view->exposure) : 0.0f;
}

/* True if lists may leave the light out of some cells. */
static bool light_is_listed(const stilb_scene_light *light, float tolerance)
{
	return render_light_ends(light) || (tolerance > 0.0f && light->kind != STILB_SCENE_LIGHT_DIRECTIONAL);
}

/* Says once that a device leaves lights out. asked: as many as pixels ask at most. */
static void lights_tell_loop(stilb_render *render, uint32_t asked)
{
	if (render->told_loop || asked <= RENDER_LIGHTS_LOOP || !stilb_gpu_is_software(render->device->gpu))
		return;
	render->told_loop = true;
	stilb_log("of %u lights that a pixel may ask this software device asks %u; light by clustered, or by deferred with "
	          "coverage screen, which asks all",
	          asked, RENDER_LIGHTS_LOOP);
}

/* ---- counts ------------------------------------------------------------------------------------------------------ */

/* A view's lights, without BAKED ones. */
typedef struct lights_counts {
	uint32_t all, faded, gone; /* faded: with those that are gone */
} lights_counts;

static lights_counts lights_count(const stilb_render_view *view, const render_lights_fade *fade)
{
	lights_counts counts = {0};
	for (uint32_t i = 0; i < view->light_count; i++) {
		if (view->lights[i].use == STILB_SCENE_LIGHT_BAKED)
			continue;
		float left = render_light_left(fade, &view->lights[i]);
		counts.all++;
		counts.faded += left < 1.0f;
		counts.gone += left == 0.0f;
	}
	return counts;
}

static void lights_note(stilb_render *render, lights_counts counts)
{
	stilb_render_stats *stats = &render->device->stats;
	stats->lights += counts.all;
	stats->light_faded += counts.faded;
	stats->light_gone += counts.gone;
}

/* What lights in place of the surroundings. A panorama lights in place of sky and ground, and is mirrored without
 * RENDER_LIGHTS_GLOSS. */
static uint32_t lights_around(const stilb_render_view *view, bool panorama)
{
	static const uint32_t bits[STILB_RENDER_AMBIENT_KINDS] = {
		[STILB_RENDER_AMBIENT_NONE] = RENDER_LIGHTS_DARK,
		[STILB_RENDER_AMBIENT_CONSTANT] = RENDER_LIGHTS_GLOSS,
		[STILB_RENDER_AMBIENT_HEMISPHERE] = RENDER_LIGHTS_GLOSS,
		[STILB_RENDER_AMBIENT_SH_VERTEX] = RENDER_LIGHTS_GLOSS | RENDER_LIGHTS_SH_VERTEX,
		[STILB_RENDER_AMBIENT_SH_PIXEL] = RENDER_LIGHTS_GLOSS | RENDER_LIGHTS_SH_PIXEL,
	};
	if (view->ambient != STILB_RENDER_AMBIENT_ENVIRONMENT)
		return bits[view->ambient];
	return panorama ? RENDER_LIGHTS_PANORAMA : view->surroundings.glossy ? RENDER_LIGHTS_GLOSS : 0;
}

/* So many lights that end somewhere are asked without lists. */
static uint32_t lights_few(stilb_render_lighting way)
{
	switch (way) {
	case STILB_RENDER_LIGHTING_FORWARD:
	case STILB_RENDER_LIGHTING_MULTIPASS:
	case STILB_RENDER_LIGHTING_COMBINED:
		return UINT32_MAX;
	case STILB_RENDER_LIGHTING_CLUSTERED:
	case STILB_RENDER_LIGHTING_TILED_DEFERRED:
	case STILB_RENDER_LIGHTING_TILED_FORWARD:
	case STILB_RENDER_LIGHTING_INDEXED:
		return 0;
	default:
		return LIGHTS_FEW;
	}
}

uint32_t render_light_bits(const stilb_render_view *view, bool panorama, uint32_t lamps)
{
	uint32_t sides = view->both_sides ? RENDER_LIGHTS_SIDES : 0, channel = render_view_channel(view);
	if (render_view_is_depth(view))
		return RENDER_LIGHTS_DEPTH | sides | (view->shadow ? RENDER_LIGHTS_SHADOWS : 0);
	if (channel > 0)
		return channel << RENDER_LIGHTS_CHANNEL_SHIFT | sides;
	bool counts = render_view_counts(view);
	uint32_t shadows = view->shadows && !counts ? RENDER_LIGHTS_SHADOWS : 0;
	uint32_t around = counts ? RENDER_LIGHTS_DARK | RENDER_LIGHTS_COUNTED : lights_around(view, panorama);
	uint32_t bits = sides | shadows | around | (lamps > 0 ? 1u << STILB_SCENE_LIGHT_DIRECTIONAL : 0);
	uint32_t count = lamps, listed = 0;
	float tolerance = lights_tolerance(view);
	for (uint32_t i = 0; i < view->light_count; i++) {
		const stilb_scene_light *light = &view->lights[i];
		if (light->use == STILB_SCENE_LIGHT_BAKED)
			continue;
		count++;
		listed += light_is_listed(light, tolerance);
		bits |= 1u << light->kind;
		bits |= light->falloff != STILB_SCENE_LIGHT_PHYSICAL ? RENDER_LIGHTS_END : 0;
	}
	bits |= view->lighting == STILB_RENDER_LIGHTING_COMBINED && count > 1 ? RENDER_LIGHTS_COMBINED : 0;
	bool one = count == 1 && !(view->light_fade > 0.0f);
	return bits | (listed > lights_few(view->lighting) ? RENDER_LIGHTS_LISTS : one ? RENDER_LIGHTS_ONE : 0);
}

const render_panorama *render_view_panorama(const stilb_render *render, const stilb_render_view *view)
{
	bool shows = !render_view_is_depth(view) && render_panorama_shows(&render->panorama, &view->surroundings.panorama);
	return shows ? &render->panorama : NULL;
}

/* ---- the array --------------------------------------------------------------------------------------------------- */

/* index: of the light of the view; left: the share that fading leaves of it. */
static void lights_write(render_light *out, const stilb_render_view *view, uint32_t index, float left)
{
	const stilb_scene_light *light = &view->lights[index];
	const stilb_render_shadow *maps = view->shadows ? &view->shadows->lights[index] : NULL;
	bool shadowed = maps && maps->map_count > 0, cube = shadowed && maps->map_count == 6;
	uint32_t shadow = shadowed ? 2 * (1 + maps->first_map) + cube : 0;
	bool round = light->kind == STILB_SCENE_LIGHT_SPHERE || light->kind == STILB_SCENE_LIGHT_DISK;
	STILB_ASSERT(!stilb_scene_light_mistake(light));
	*out = (render_light){
		.kind = (float)((uint32_t)light->kind + 8 * (uint32_t)light->falloff + RENDER_LIGHT_SHADOW * shadow),
		.cos_inner = light->cos_inner,
		.cos_outer = light->cos_outer,
		.radius = round ? light->radius : 0.0f,
		.reach = light->reach};
	memcpy(out->position, light->position, sizeof out->position);
	memcpy(out->direction, light->direction, sizeof out->direction);
	for (int c = 0; c < 3; c++)
		out->intensity[c] = left * light->intensity[c];
	memcpy(out->half_x, light->half_x, sizeof out->half_x);
	memcpy(out->half_y, light->half_y, sizeof out->half_y);
}

static void lights_write_lamps(render_light *out, const stilb_render_view *view, const render_panorama *panorama)
{
	for (uint32_t i = 0; i < render_view_lamps(view, panorama); i++, out++) {
		const render_panorama_lamp *lamp = &panorama->lamps[i];
		*out = (render_light){.kind = STILB_SCENE_LIGHT_DIRECTIONAL};
		render_panorama_turn(lamp->direction, view->surroundings.rotation, out->direction);
		for (int c = 0; c < 3; c++)
			out->direction[c] = -out->direction[c];
		memcpy(out->intensity, lamp->irradiance, sizeof out->intensity);
		render_panorama_turn(lamp->half_x, view->surroundings.rotation, out->half_x);
		render_panorama_turn(lamp->half_y, view->surroundings.rotation, out->half_y);
	}
}

/* Claims room for the lamps and so many lights, and writes the lamps. *out: where the lights go; NULL: there are
 * none. */
static stilb_result lights_claim(stilb_render *render, const stilb_render_view *view, const render_panorama *panorama,
                                 uint32_t count, render_view_lights *lights, render_light **out)
{
	uint32_t lamps = render_view_lamps(view, panorama);
	lights->count = lamps + count;
	*out = lights->count > 0 ? render_claim(render, RENDER_MEMORY_LIGHTS, lights->count, &lights->first) : NULL;
	if (lights->count > 0 && !*out)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the frame's %u lights", lights->count);
	if (lamps > 0) {
		lights_write_lamps(*out, view, panorama);
		*out += lamps;
	}
	return STILB_OK;
}

static stilb_result lights_place_all(stilb_render *render, const stilb_render_view *view,
                                     const render_panorama *panorama, render_view_lights *lights)
{
	render_lights_fade fade = render_lights_fade_of(render, view);
	lights_counts counts = lights_count(view, &fade);
	bool all = view->lighting == STILB_RENDER_LIGHTING_COMBINED; /* which knows lights by their places */
	uint32_t count = counts.all - (all ? 0 : counts.gone), endless = 0;
	for (uint32_t i = 0; i < view->light_count; i++)
		endless += view->lights[i].use != STILB_SCENE_LIGHT_BAKED && !render_light_ends(&view->lights[i]);
	render_light *out;
	lights_note(render, counts);
	stilb_result result = lights_claim(render, view, panorama, count, lights, &out);
	lights->everywhere = lights->count;
	lights->endless = lights->count - count + endless;
	for (int ends = 0; ends < 2 && result == STILB_OK && count > 0; ends++)
		for (uint32_t i = 0; i < view->light_count; i++) {
			const stilb_scene_light *light = &view->lights[i];
			float left = render_light_left(&fade, light);
			if (light->use != STILB_SCENE_LIGHT_BAKED && render_light_ends(light) == (bool)ends && (all || left > 0.0f))
				lights_write(out++, view, i, left);
		}
	return result == STILB_OK && lights->count > 0 ? render_shadows_list(render, view, out - lights->count, lights)
	                                               : result;
}

/* ---- lists ------------------------------------------------------------------------------------------------------- */

/* Copies the lists to the frame's memory. */
static stilb_result lists_write(stilb_render *render, const stilb_light_lists *lists, render_view_lights *lights)
{
	uint32_t cells = lists->columns * lists->rows * lists->slices;
	uint64_t words = sizeof(render_light_lists) / sizeof(uint32_t) + (uint64_t)cells + 1 + lists->id_count;
	render_light_lists *out = words <= UINT32_MAX ? render_claim(render, RENDER_MEMORY_LIGHT_LISTS,
	                                                             (uint32_t)((words + 3) / 4), &lights->lists)
	                                              : NULL;
	if (!out)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the lists of %u lights in %u cells", lists->light_count,
		                  cells);
	memcpy(out->depth_plane, lists->depth_plane, sizeof out->depth_plane);
	out->slice_scale = lists->slice_scale;
	out->slice_bias = lists->slice_bias;
	out->room = UINT32_MAX;
	out->all = 0;
	memcpy(out->words, lists->starts, (cells + 1) * sizeof *out->words);
	if (lists->id_count > 0)
		memcpy(out->words + cells + 1, lists->ids, lists->id_count * sizeof *out->words);
	return STILB_OK;
}

/* Copies what programs make lists of to the frame's memory. */
static stilb_result lists_write_cells(stilb_render *render, const stilb_light_lists *lists, render_view_lights *lights)
{
	uint64_t cells = stilb_light_cells_bytes(lists) / sizeof(float[4]);
	uint64_t listed = lists->light_count - lists->everywhere_count;
	uint64_t parts = cells + listed * (sizeof(stilb_light_reached) / sizeof(float[4]));
	uint8_t *out =
		parts <= UINT32_MAX ? render_claim(render, RENDER_MEMORY_LIGHT_LISTS, (uint32_t)parts, &lights->lists) : NULL;
	if (!out)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the lists of %u lights", lists->light_count);
	lights->reached = lights->lists + (uint32_t)cells;
	stilb_light_cells_write(lists, (stilb_light_cells *)out);
	stilb_light_reached_write(lists, (stilb_light_reached *)(out + cells * sizeof(float[4])));
	return STILB_OK;
}

/* True if the view's lists are to be made by compute, by choice. Jobs alone shorten lists by a tolerance. */
static bool lists_by_compute(const render_device *device, const stilb_render_view *view)
{
	return view->light_lists == STILB_RENDER_LIGHT_LISTS_COMPUTE && !device->null && !(view->light_tolerance > 0.0f);
}

/* Distances from the four sides of a view, positive inside: functions of a point, by their factors of its coordinates
 * and 1. Metres. */
typedef struct lists_sides {
	float planes[4][4];
} lists_sides;

static lists_sides lists_sides_of(const stilb_mat4 *matrix)
{
	lists_sides sides;
	const float *m = matrix->m;
	for (int s = 0; s < 4; s++) {
		float *plane = sides.planes[s], sign = s % 2 ? -1.0f : 1.0f;
		for (int c = 0; c < 4; c++)
			plane[c] = m[4 * c + 3] + sign * m[4 * c + s / 2];
		float length = sqrtf(plane[0] * plane[0] + plane[1] * plane[1] + plane[2] * plane[2]);
		for (int c = 0; c < 4; c++)
			plane[c] /= length;
	}
	return sides;
}

/* False if the sphere lies outside of the view: then its depth does not matter. */
static bool lists_see(const lists_sides *sides, const float p[3], float radius)
{
	for (int s = 0; s < 4; s++) {
		const float *plane = sides->planes[s];
		if (plane[0] * p[0] + plane[1] * p[1] + plane[2] * p[2] + plane[3] < -radius)
			return false;
	}
	return true;
}

/* Sets the depths between which cells are cut: where lights are that lists hold and the view may see. Parallel views
 * are not cut. */
static void lists_range(const stilb_render_view *view, stilb_light_grid *grid)
{
	const float *m = view->view_projection.m;
	float scale = sqrtf(m[3] * m[3] + m[7] * m[7] + m[11] * m[11]), nearest = INFINITY, farthest = 0.0f;
	lists_sides sides = lists_sides_of(&view->view_projection);
	for (uint32_t i = 0; i < view->light_count; i++) {
		const stilb_scene_light *light = &view->lights[i];
		const float *p = light->position;
		if (!light_is_listed(light, grid->tolerance) || light->use == STILB_SCENE_LIGHT_BAKED)
			continue;
		bool ends = render_light_ends(light); /* what does not is seen from anywhere */
		float reach = ends ? light->reach : 0.0f, depth = (m[3] * p[0] + m[7] * p[1] + m[11] * p[2] + m[15]) / scale;
		if (ends && (depth + reach <= 0.0f || !lists_see(&sides, p, reach)))
			continue;
		nearest = fminf(nearest, depth - reach);
		farthest = fmaxf(farthest, depth + reach);
	}
	grid->last = farthest;
	grid->first = fmaxf(nearest, grid->last / LIGHTS_RANGE);
	bool cut = isfinite(farthest) && grid->first > 0.0f && grid->first < grid->last; /* no NaN */
	if (!cut)
		grid->slices = 1;
}

/* How the view is cut, by the size of what it draws into. */
static void lists_cut(const stilb_render *render, const stilb_render_view *view, stilb_light_grid *grid)
{
	grid->tile = LIGHTS_TILE;
	grid->slices = LIGHTS_SLICES;
	if (render_view_way(render->device, view).tiles) { /* what they show shortens their lists (render_tiles.c) */
		grid->tile = LIGHTS_TILE_SHOWN;
		grid->slices = 1;
		return;
	}
	if (stilb_gpu_is_software(render->device->gpu)) {
		grid->tile = LIGHTS_TILE_SOFTWARE;
		grid->slices = LIGHTS_SLICES_SOFTWARE;
		while ((uint64_t)grid->width * grid->height / grid->tile / grid->tile * grid->slices > LIGHTS_CELLS_SOFTWARE)
			grid->tile *= 2;
	}
	lists_range(view, grid);
}

/* The lights that fading leaves something of: *candidates, [count], to be freed. */
static stilb_result lists_candidates(const stilb_render_view *view, const render_lights_fade *fade, uint32_t count,
                                     uint32_t **candidates)
{
	uint32_t *next = *candidates = stilb_memory_alloc(count + 1, sizeof *next);
	if (!next)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for %u lights that have not faded", count);
	for (uint32_t i = 0; i < view->light_count; i++)
		if (view->lights[i].use != STILB_SCENE_LIGHT_BAKED && render_light_left(fade, &view->lights[i]) > 0.0f)
			*next++ = i;
	return STILB_OK;
}

/* False if compute could not make the lists of the lights that have been found: they might have too many pairs, or a
 * software device end its loops. Of these a thread takes a turn for every 64 lights, for each of those and each of its
 * columns one at most, and for each column one for tangents' sake and two to trim. */
static bool lists_suit_compute(const render_device *device, const stilb_light_lists *lists)
{
	uint64_t listed = lists->light_count - lists->everywhere_count;
	uint64_t turns = listed * (lists->columns / 64 + 1) + (listed / 64 + 1) * (3 * (uint64_t)lists->columns + 3);
	bool software = stilb_gpu_is_software(device->gpu);
	return stilb_light_reached_most(lists) <= UINT32_MAX && (!software || turns < LIGHTS_TURNS_SOFTWARE);
}

/* Finds the lights that reach the view, and, but by compute, their lists. *room: for lists by compute; set to 0 if jobs
 * have made them. */
static stilb_result lists_build(stilb_render *render, const stilb_render_view *view, const stilb_light_grid *grid,
                                const uint32_t *candidates, uint32_t count, uint32_t *room, stilb_job_pool *pool,
                                uint32_t worker)
{
	stilb_light_lists *lists = &render->lists;
	if (*room > 0) {
		stilb_result result =
			stilb_light_reached_find(lists, grid, view->lights, view->light_count, candidates, count, pool, worker);
		if (result != STILB_OK || lists_suit_compute(render->device, lists))
			return result;
		*room = 0;
	}
	return stilb_light_lists_build(lists, grid, view->lights, view->light_count, candidates, count, pool, worker);
}

/* Lights that a pixel asks of the lists at most; by compute, with such a room, of all. */
static uint32_t lists_longest(const stilb_render *render, const stilb_render_view *view, uint32_t room)
{
	const stilb_light_lists *lists = &render->lists;
	uint32_t longest = 0, cells = lists->columns * lists->rows * lists->slices;
	uint32_t listed = lists->light_count - lists->everywhere_count;
	bool deferred = view->lighting == STILB_RENDER_LIGHTING_DEFERRED && !render_view_way(render->device, view).tiles;
	if (listed <= RENDER_LIGHTS_LOOP || (deferred && view->deferred.coverage != STILB_RENDER_COVERAGE_CELLS))
		return 0;
	if (room > 0)
		return listed;
	for (uint32_t c = 0; c < cells; c++) {
		uint32_t length = lists->starts[c + 1] - lists->starts[c];
		longest = length > longest ? length : longest;
	}
	return longest;
}

/* pass: its number. */
static stilb_result lights_place_lists(stilb_render *render, const stilb_render_view *view,
                                       const render_panorama *panorama, uint32_t pass, render_view_lights *lights,
                                       stilb_job_pool *pool, uint32_t worker)
{
	stilb_light_grid grid = {
		.view_projection = view->view_projection, .tolerance = lights_tolerance(view), .peak = view->light_peak};
	stilb_light_lists *lists = &render->lists;
	uint32_t room = lists_by_compute(render->device, view) ? render_cells_room(render->device, pass) : 0;
	render_lights_fade fade = render_lights_fade_of(render, view);
	lights_counts counts = lights_count(view, &fade);
	uint32_t shown = counts.all - counts.gone, *candidates = NULL;
	render_view_size(render, view, &grid.width, &grid.height);
	lists_cut(render, view, &grid);
	stilb_result result = view->light_fade > 0.0f ? lists_candidates(view, &fade, shown, &candidates) : STILB_OK;
	if (result == STILB_OK)
		result = lists_build(render, view, &grid, candidates, candidates ? shown : 0, &room, pool, worker);
	free(candidates);
	render_light *out;
	if (result == STILB_OK)
		result = lights_claim(render, view, panorama, lists->light_count, lights, &out);
	if (result != STILB_OK)
		return result;
	for (uint32_t i = 0; out && i < lists->light_count; i++)
		lights_write(out++, view, lists->lights[i], render_light_left(&fade, &view->lights[lists->lights[i]]));
	if (lights->count > 0)
		result = render_shadows_list(render, view, out - lights->count, lights);
	if (result != STILB_OK)
		return result;
	lights->endless = lights->everywhere = lights->count - lists->light_count + lists->everywhere_count;
	lights_note(render, counts);
	if (room == 0)
		render_cells_know(render->device, pass, lists->id_count);
	render->device->stats.light_pairs += render->device->pairs[pass];
	render->device->stats.light_left_out += lists->left_out;
	lights->grid[0] = lists->columns | lists->rows << 16;
	lights->grid[1] = (uint32_t)__builtin_ctz(grid.tile) | lists->slices << 8;
	lights_tell_loop(render, lights->everywhere + lists_longest(render, view, room));
	lights->cells = room > 0 ? 1 + pass : 0;
	lights->list_ids = room > 0 ? room : lists->id_count;
	return room > 0 ? lists_write_cells(render, lists, lights) : lists_write(render, lists, lights);
}

/* ---- counted lights ---------------------------------------------------------------------------------------------- */

stilb_render_light_counts stilb_render_count_lights(const uint16_t (*texels)[4], uint64_t count)
{
	STILB_ASSERT(texels || count == 0);
	stilb_render_light_counts counts = {.pixels = count};
	for (uint64_t i = 0; i < count; i++) {
		uint16_t most = 0x7bff, asked = texels[i][0] < most ? texels[i][0] : most; /* infinite ones, too */
		counts.lights += (double)stilb_image_half_to_float(asked);
		counts.cut += asked == most;
		counts.shadings += (double)stilb_image_half_to_float(texels[i][1]);
		counts.shown += texels[i][1] != 0;
	}
	return counts;
}

stilb_render_error stilb_render_measure_error(const uint16_t (*texels)[4], uint64_t count, float exposure)
{
	STILB_ASSERT(texels || count == 0);
	stilb_render_error error = {.pixels = count};
	double sum = 0.0, bright = exp2((double)exposure);
	uint64_t seen = 0;
	for (uint64_t i = 0; i < count; i++) {
		double most = 0.0;
		for (int c = 0; c < 3; c++) {
			double off = bright * (double)stilb_image_half_to_float(texels[i][c]);
			most = off > most ? off : most;
			sum += off * off;
		}
		seen += most > 1.0 / 255.0;
		error.most = most > error.most ? most : error.most;
	}
	if (count > 0) {
		error.rms = sqrt(sum / (3.0 * (double)count));
		error.share = (double)seen / (double)count;
	}
	return error;
}

/* ---- a frame ----------------------------------------------------------------------------------------------------- */

/* True if both views have the same lights, without lists. */
static bool lights_are_same(const render_device *device, const stilb_render_view *a, const stilb_render_view *b)
{
	return render_view_has_buffer(device, a) == render_view_has_buffer(device, b) && a->lights == b->lights &&
	       a->light_count == b->light_count && a->shadows == b->shadows && !(a->light_fade > 0.0f) &&
	       !(b->light_fade > 0.0f) && a->surroundings.panorama.pixels == b->surroundings.panorama.pixels &&
	       a->surroundings.rotation == b->surroundings.rotation &&
	       (a->ambient == STILB_RENDER_AMBIENT_NONE) == (b->ambient == STILB_RENDER_AMBIENT_NONE);
}

stilb_result render_lights_place(stilb_render *render, const stilb_render_pass *passes, uint32_t pass_count,
                                 const stilb_render_view *views, render_view_lights placed[STILB_RENDER_MAX_PASSES],
                                 stilb_job_pool *pool, uint32_t worker)
{
	PROFILE("lights");
	const stilb_render_view *last = NULL; /* whose lights are placed without lists */
	render_view_lights now = {0};
	stilb_result result = STILB_OK;
	render_cells_read(render->device);
	for (uint32_t p = 0; p < pass_count && result == STILB_OK; p++) {
		const stilb_render_view *view = passes[p].kind == STILB_RENDER_PASS_SCENE ? &views[passes[p].view] : NULL;
		placed[p] = (render_view_lights){0};
		if (!view)
			continue;
		STILB_ASSERT(view->light_tolerance >= 0.0f && view->light_tolerance <= 1.0f);
		STILB_ASSERT(view->light_fade >= 0.0f && isfinite(view->light_fade));
		STILB_ASSERT((view->light_tolerance == 0.0f || view->light_peak >= 0.318f) && "stilb_render_light_peak");
		const render_panorama *panorama = render_view_panorama(render, view);
		uint32_t bits = render_light_bits(view, panorama, render_view_lamps(view, panorama));
		placed[p].bits = bits;
		placed[p].shadow_bits = render_shadow_bits(view);
		if (!render_view_is_lit(view))
			continue;
		result = render_shadows_place(render, view, &placed[p]);
		if (result != STILB_OK)
			break;
		uint32_t shadows = placed[p].shadows, shadow_bits = placed[p].shadow_bits;
		if (bits & RENDER_LIGHTS_LISTS)
			result = lights_place_lists(render, view, panorama, p, &placed[p], pool, worker);
		/* A view that cannot be cut into cells shows nothing, or a plane: asking all lights is as well. */
		if (bits & RENDER_LIGHTS_LISTS && result != STILB_ERROR_ARGUMENT)
			continue;
		result = STILB_OK;
		if (!last || !lights_are_same(render->device, view, last)) {
			now = (render_view_lights){0};
			result = lights_place_all(render, view, panorama, &now);
			lights_tell_loop(render, now.everywhere);
			last = view;
		}
		placed[p] = now;
		placed[p].shadows = shadows;
		placed[p].shadow_bits = shadow_bits;
		placed[p].bits = bits & ~RENDER_LIGHTS_LISTS;
		render_combined_pass *combined = &render->passes[p].combined;
		if (combined->model_count == 0)
			placed[p].bits &= ~RENDER_LIGHTS_COMBINED;
		if (result == STILB_OK && placed[p].bits & RENDER_LIGHTS_COMBINED)
			result = render_combined_place(render, view, panorama, combined, &placed[p], pool, worker);
	}
	return result;
}
