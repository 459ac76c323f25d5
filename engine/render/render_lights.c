/* The lights of views, as shaders read them: all in one array, and for views with many of them the lists of their cells
 * (light/light.h), by which a pixel asks those that reach it. */
#include "render/render_internal.h"

#include <math.h>
#include <string.h>

#define LIGHTS_FEW 8u       /* so many lights that end somewhere are faster without lists */
#define LIGHTS_TILE 32u     /* pixels of a cell's sides */
#define LIGHTS_SLICES 24u   /* of depth */
#define LIGHTS_RANGE 256.0f /* the last one begins so much farther away than the first one ends, at most */

/* True if the light sends nothing beyond its reach. */
static bool light_ends(const stilb_scene_light *light)
{
	return light->kind != STILB_SCENE_LIGHT_DIRECTIONAL && light->falloff != STILB_SCENE_LIGHT_PHYSICAL;
}

/* RENDER_LIGHTS_GLOSS or 0. A panorama lights in place of sky and ground, and is mirrored without it. */
static uint32_t lights_gloss(const stilb_render_view *view, bool panorama)
{
	return view->surroundings.glossy && !panorama && render_view_is_lit(view) ? RENDER_LIGHTS_GLOSS : 0;
}

uint32_t render_light_bits(const stilb_render_view *view, bool panorama, uint32_t lamps)
{
	uint32_t sides = view->both_sides ? RENDER_LIGHTS_SIDES : 0, channel = render_view_channel(view);
	if (render_view_is_depth(view))
		return RENDER_LIGHTS_DEPTH | sides;
	if (channel > 0)
		return channel << RENDER_LIGHTS_CHANNEL_SHIFT | sides;
	uint32_t bits = sides | (panorama ? RENDER_LIGHTS_PANORAMA : 0) | lights_gloss(view, panorama) |
	                (lamps > 0 ? 1u << STILB_SCENE_LIGHT_DIRECTIONAL : 0);
	uint32_t count = lamps, ending = 0;
	for (uint32_t i = 0; i < view->light_count; i++) {
		const stilb_scene_light *light = &view->lights[i];
		if (light->use == STILB_SCENE_LIGHT_BAKED)
			continue;
		count++;
		ending += light_ends(light);
		bits |= 1u << light->kind;
		bits |= light->falloff != STILB_SCENE_LIGHT_PHYSICAL ? RENDER_LIGHTS_END : 0;
	}
	bool all = view->lighting == STILB_RENDER_LIGHTING_FORWARD || view->lighting == STILB_RENDER_LIGHTING_MULTIPASS;
	uint32_t few = all ? UINT32_MAX : view->lighting == STILB_RENDER_LIGHTING_CLUSTERED ? 0 : LIGHTS_FEW;
	return bits | (ending > few ? RENDER_LIGHTS_LISTS : count == 1 ? RENDER_LIGHTS_ONE : 0);
}

const render_panorama *render_view_panorama(const stilb_render *render, const stilb_render_view *view)
{
	bool shows = !render_view_is_depth(view) && render_panorama_shows(&render->panorama, &view->surroundings.panorama);
	return shows ? &render->panorama : NULL;
}

/* ---- the array --------------------------------------------------------------------------------------------------- */

static void lights_write(render_light *out, const stilb_scene_light *light)
{
	bool round = light->kind == STILB_SCENE_LIGHT_SPHERE || light->kind == STILB_SCENE_LIGHT_DISK;
	STILB_ASSERT(!stilb_scene_light_mistake(light));
	*out = (render_light){.kind = (float)((uint32_t)light->kind + 8 * (uint32_t)light->falloff),
	                      .cos_inner = light->cos_inner,
	                      .cos_outer = light->cos_outer,
	                      .radius = round ? light->radius : 0.0f,
	                      .reach = light->reach};
	memcpy(out->position, light->position, sizeof out->position);
	memcpy(out->direction, light->direction, sizeof out->direction);
	memcpy(out->intensity, light->intensity, sizeof out->intensity);
	memcpy(out->half_x, light->half_x, sizeof out->half_x);
	memcpy(out->half_y, light->half_y, sizeof out->half_y);
}

static void lights_write_lamps(render_light *out, const stilb_render_view *view, const render_panorama *panorama)
{
	for (uint32_t i = 0; i < panorama->lamp_count; i++, out++) {
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
	uint32_t lamps = panorama ? panorama->lamp_count : 0;
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
	uint32_t count = 0, ending = 0;
	for (uint32_t i = 0; i < view->light_count; i++) {
		bool shown = view->lights[i].use != STILB_SCENE_LIGHT_BAKED;
		count += shown;
		ending += shown && light_ends(&view->lights[i]);
	}
	render_light *out;
	stilb_result result = lights_claim(render, view, panorama, count, lights, &out);
	lights->everywhere = lights->count;
	lights->endless = lights->count - ending;
	for (int ends = 0; ends < 2 && result == STILB_OK && count > 0; ends++)
		for (uint32_t i = 0; i < view->light_count; i++)
			if (view->lights[i].use != STILB_SCENE_LIGHT_BAKED && light_ends(&view->lights[i]) == (bool)ends)
				lights_write(out++, &view->lights[i]);
	return result;
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
	memset(out->padding, 0, sizeof out->padding);
	memcpy(out->words, lists->starts, (cells + 1) * sizeof *out->words);
	if (lists->id_count > 0)
		memcpy(out->words + cells + 1, lists->ids, lists->id_count * sizeof *out->words);
	return STILB_OK;
}

/* Sets the depths between which cells are cut: where lights that end somewhere are. Parallel views are not cut. */
static void lists_range(const stilb_render_view *view, stilb_light_grid *grid)
{
	const float *m = view->view_projection.m;
	float scale = sqrtf(m[3] * m[3] + m[7] * m[7] + m[11] * m[11]), nearest = INFINITY, farthest = 0.0f;
	for (uint32_t i = 0; i < view->light_count; i++) {
		const stilb_scene_light *light = &view->lights[i];
		const float *p = light->position;
		if (!light_ends(light) || light->use == STILB_SCENE_LIGHT_BAKED)
			continue;
		float depth = (m[3] * p[0] + m[7] * p[1] + m[11] * p[2] + m[15]) / scale;
		nearest = fminf(nearest, depth - light->reach);
		farthest = fmaxf(farthest, depth + light->reach);
	}
	grid->last = 0.8f * farthest;
	grid->first = fmaxf(nearest, grid->last / LIGHTS_RANGE);
	bool cut = isfinite(farthest) && grid->first > 0.0f && grid->first < grid->last; /* no NaN */
	grid->slices = cut ? LIGHTS_SLICES : 1;
}

static stilb_result lights_place_lists(stilb_render *render, const stilb_render_view *view,
                                       const render_panorama *panorama, render_view_lights *lights,
                                       stilb_job_pool *pool, uint32_t worker)
{
	stilb_light_grid grid = {.view_projection = view->view_projection, .tile = LIGHTS_TILE};
	stilb_light_lists *lists = &render->lists;
	if (view->target) {
		grid.width = view->target->width;
		grid.height = view->target->height;
	} else {
		stilb_render_size(render, &grid.width, &grid.height);
	}
	lists_range(view, &grid);
	stilb_result result = stilb_light_lists_build(lists, &grid, view->lights, view->light_count, NULL, 0, pool, worker);
	render_light *out;
	if (result == STILB_OK)
		result = lights_claim(render, view, panorama, lists->light_count, lights, &out);
	if (result != STILB_OK)
		return result;
	for (uint32_t i = 0; out && i < lists->light_count; i++)
		lights_write(out++, &view->lights[lists->lights[i]]);
	lights->endless = lights->everywhere = lights->count - lists->light_count + lists->everywhere_count;
	lights->grid[0] = lists->columns | lists->rows << 16;
	lights->grid[1] = (uint32_t)__builtin_ctz(grid.tile) | lists->slices << 8;
	return lists_write(render, lists, lights);
}

/* ---- a frame ----------------------------------------------------------------------------------------------------- */

/* True if both views have the same lights, without lists. */
static bool lights_are_same(const stilb_render_view *a, const stilb_render_view *b)
{
	return a->lights == b->lights && a->light_count == b->light_count &&
	       a->surroundings.panorama.pixels == b->surroundings.panorama.pixels &&
	       a->surroundings.rotation == b->surroundings.rotation;
}

stilb_result render_lights_place(stilb_render *render, const stilb_render_pass *passes, uint32_t pass_count,
                                 const stilb_render_view *views, render_view_lights placed[STILB_RENDER_MAX_PASSES],
                                 stilb_job_pool *pool, uint32_t worker)
{
	PROFILE("lights");
	const stilb_render_view *last = NULL; /* whose lights are placed without lists */
	render_view_lights now = {0};
	stilb_result result = STILB_OK;
	for (uint32_t p = 0; p < pass_count && result == STILB_OK; p++) {
		const stilb_render_view *view = passes[p].kind == STILB_RENDER_PASS_SCENE ? &views[passes[p].view] : NULL;
		placed[p] = (render_view_lights){0};
		if (!view)
			continue;
		const render_panorama *panorama = render_view_panorama(render, view);
		uint32_t bits = render_light_bits(view, panorama, panorama ? panorama->lamp_count : 0);
		placed[p].bits = bits;
		if (!render_view_is_lit(view))
			continue;
		if (bits & RENDER_LIGHTS_LISTS)
			result = lights_place_lists(render, view, panorama, &placed[p], pool, worker);
		/* A view that cannot be cut into cells shows nothing, or a plane: asking all lights is as well. */
		if (bits & RENDER_LIGHTS_LISTS && result != STILB_ERROR_ARGUMENT)
			continue;
		result = STILB_OK;
		if (!last || !lights_are_same(view, last)) {
			now = (render_view_lights){0};
			result = lights_place_all(render, view, panorama, &now);
			last = view;
		}
		placed[p] = now;
		placed[p].bits = bits & ~RENDER_LIGHTS_LISTS;
	}
	return result;
}
