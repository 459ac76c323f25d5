/* Shadow maps of views, as shaders read them. */
#include "render/render_internal.h"

#include <math.h>
#include <string.h>

/* Texels, for each texel of the filter to a side: so far may a plane across a smooth normal lie behind the triangles,
 * and the point behind itself where rounding puts it. Nothing else sees it: it is the way to the light. */
#define SHADOW_APART 0.75f

/* Clip space to texels: x from -1 .. 1 to the area's columns, y to its rows. */
static void shadow_rows(const stilb_render_shadow_map *map, float rows[4][4])
{
	float half[2] = {0.5f * (float)map->area[2], 0.5f * (float)map->area[3]};
	for (size_t c = 0; c < 4; c++) {
		const float *from = &map->view_projection.m[4 * c];
		for (int r = 0; r < 2; r++)
			rows[r][c] = half[r] * from[r] + ((float)map->area[r] + half[r]) * from[3];
		rows[2][c] = from[2];
		rows[3][c] = from[3];
	}
}

/* Metres that a texel has at w = 1. */
static float shadow_texel(float rows[4][4])
{
	const float *x = rows[0], *ahead = rows[3]; /* columns lie across what lies ahead */
	float square = ahead[0] * ahead[0] + ahead[1] * ahead[1] + ahead[2] * ahead[2], length = 0.0f;
	float along = square > 0.0f ? (x[0] * ahead[0] + x[1] * ahead[1] + x[2] * ahead[2]) / square : 0.0f;
	for (int c = 0; c < 3; c++)
		length += (x[c] - along * ahead[c]) * (x[c] - along * ahead[c]);
	return length > 0.0f ? 1.0f / sqrtf(length) : 0.0f;
}

/* Radius of the disc that a lamp is taken for, metres. */
static float shadow_radius(const stilb_scene_light *light)
{
	const float *x = light->half_x, *y = light->half_y,
				squares[2] = {x[0] * x[0] + x[1] * x[1] + x[2] * x[2], y[0] * y[0] + y[1] * y[1] + y[2] * y[2]};
	switch (light->kind) {
	case STILB_SCENE_LIGHT_SPHERE:
	case STILB_SCENE_LIGHT_DISK:
		return light->radius;
	case STILB_SCENE_LIGHT_RECTANGLE:
		return sqrtf(4.0f / 3.14159265f * sqrtf(squares[0] * squares[1])); /* of the same area */
	default:
		return 0.0f;
	}
}

/* Depth is b / w + a. A disc of the radius r seen from a point at w past something at w' hides behind an edge that is
 * r (1 / w' - 1 / w) wide at w = 1, to each side: r / b times the difference of depths. */
static float shadow_widening(const stilb_render_shadow_map *map, const stilb_scene_light *light, float texel)
{
	const float *m = map->view_projection.m, ahead[3] = {m[3], m[7], m[11]};
	float square = ahead[0] * ahead[0] + ahead[1] * ahead[1] + ahead[2] * ahead[2];
	float a = square > 0.0f ? (m[2] * ahead[0] + m[6] * ahead[1] + m[10] * ahead[2]) / square : 0.0f;
	float b = m[14] - a * m[15];
	return b != 0.0f && square > 0.0f ? shadow_radius(light) / b / texel : 0.0f;
}

/* Of a directional light's map: a point at the distance d from the camera lies area[2] - area[0] d texels before the
 * map's end, each half as long as in the map, so that it gives way along less. */
static void shadow_end(const stilb_render_shadow_map *map, render_shadow_map *out)
{
	const float *row = out->rows[0];
	float texels = 2.0f * sqrtf(row[0] * row[0] + row[1] * row[1] + row[2] * row[2]);
	out->area[0] = map->far > 0.0f ? texels : 0.0f;
	out->area[2] = map->far > 0.0f ? texels * map->far : 2.0f * (float)map->area[2];
}

/* pixels: that a length of 1 has in the picture at a distance of 1. */
static void shadow_write_map(const stilb_render_shadows *shadows, uint32_t index, uint32_t left, float pixels,
                             const stilb_scene_light *light, render_shadow_map *out)
{
	const stilb_render_shadow_map *map = &shadows->maps[index];
	shadow_rows(map, out->rows);
	for (int i = 0; i < 2; i++) {
		out->area[i] = (float)map->area[i];
		out->area[2 + i] = (float)(map->area[i] + map->area[2 + i]);
	}
	if (light->kind == STILB_SCENE_LIGHT_DIRECTIONAL) /* all of its layer */
		shadow_end(map, out);
	out->layer = (float)map->layer;
	out->blend = map->blend;
	out->left = (float)left;
	out->filter = (float)shadows->filter;
	out->map_error = (shadows->map_error + SHADOW_APART * fmaxf(out->filter, 1.0f)) * shadow_texel(out->rows);
	out->view_error = shadows->view_error / pixels;
	out->widening = shadow_widening(map, light, shadow_texel(out->rows));
}

/* True if a light's maps are as stilb_render_shadow says. */
static bool shadow_is_sound(const stilb_render_shadows *shadows, const stilb_render_shadow *shadow, bool directional)
{
	uint32_t count = shadow->map_count, end = shadow->first_map + count;
	if (shadow->first_map > shadows->map_count || count > shadows->map_count - shadow->first_map)
		return false;
	for (uint32_t m = shadow->first_map; m < end && directional; m++)
		if (shadows->maps[m].area[2] != shadows->target->width || shadows->maps[m].area[3] != shadows->target->height)
			return false;
	return (directional && shadow->faded == 0.0f) ||
	       (!directional && (count == 0 || count == 1 || count == 6) && shadow->faded >= 0.0f && shadow->faded <= 1.0f);
}

/* True if they are as stilb_render_shadows says. */
static bool shadows_are_sound(const stilb_render_shadows *shadows)
{
	const stilb_render_target *target = shadows->target;
	bool sound = target && target->kind == STILB_RENDER_TARGET_DEPTH && target->layers > 1 && shadows->map_count > 0 &&
	             shadows->map_count <= RENDER_MAX_SHADOW_MAPS && shadows->filter <= STILB_RENDER_MAX_SHADOW_FILTER &&
	             shadows->maps && shadows->lights && shadows->map_error >= 0.0f && shadows->view_error >= 0.0f;
	for (uint32_t m = 0; sound && m < shadows->map_count; m++) {
		const stilb_render_shadow_map *map = &shadows->maps[m];
		sound = map->layer < target->layers && map->area[2] > 2 * shadows->filter && map->blend >= 0.0f &&
		        map->far >= 0.0f && map->area[3] > 2 * shadows->filter &&
		        map->area[0] + map->area[2] <= (int)target->width && map->area[1] + map->area[3] <= (int)target->height;
	}
	return sound;
}

/* ---- places in the buffer ---------------------------------------------------------------------------------------- */

/* Lights of the view that have maps. */
static uint32_t shadows_count(const stilb_render_view *view)
{
	uint32_t count = 0;
	for (uint32_t i = 0; i < view->light_count; i++)
		count += view->shadows->lights[i].map_count > 0;
	return count;
}

stilb_result render_shadows_list(stilb_render *render, const stilb_render_view *view, render_light *out,
                                 render_view_lights *lights)
{
	uint32_t count = render_view_has_buffer(render->device, view) ? shadows_count(view) : 0, place = 0;
	if (count == 0 || count > STILB_RENDER_SHADOW_BUFFER_LIGHTS)
		return STILB_OK;
	uint32_t layers = (count + RENDER_SHADOW_LAYER - 1) / RENDER_SHADOW_LAYER;
	uint32_t *list = render_claim(render, RENDER_MEMORY_LIGHT_LISTS, layers, &lights->term_list);
	if (!list)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the list of %u shadowed lights", count);
	for (int lamps = 0; lamps < 2; lamps++)
		for (uint32_t i = 0; i < lights->count; i++) {
			uint32_t kind = (uint32_t)out[i].kind;
			if (kind < RENDER_LIGHT_SHADOW || (kind % 8 != STILB_SCENE_LIGHT_DIRECTIONAL) != (bool)lamps)
				continue;
			list[place++] = i;
			out[i].kind += (float)(RENDER_LIGHT_PLACE * place);
		}
	lights->terms = place;
	return STILB_OK;
}

/* ---- a frame ----------------------------------------------------------------------------------------------------- */

stilb_result render_shadows_place(stilb_render *render, const stilb_render_view *view, render_view_lights *lights)
{
	const stilb_render_shadows *shadows = view->shadows;
	if (!(lights->bits & RENDER_LIGHTS_SHADOWS) || shadows->map_count == 0)
		return STILB_OK;
	STILB_ASSERT(shadows_are_sound(shadows));
	static_assert(sizeof(render_shadow_map) % sizeof(float[4]) == 0, "whole elements");
	uint32_t each = sizeof(render_shadow_map) / sizeof(float[4]);
	render_shadow_map *out =
		render_claim(render, RENDER_MEMORY_LIGHT_LISTS, shadows->map_count * each, &lights->shadows);
	if (!out)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the frame's %u shadow maps", shadows->map_count);
	float pixels = render_view_pixels(view, view->target ? view->target->height : render->device->height);
	for (uint32_t i = 0; i < view->light_count; i++) {
		const stilb_render_shadow *shadow = &shadows->lights[i];
		STILB_ASSERT(shadow_is_sound(shadows, shadow, view->lights[i].kind == STILB_SCENE_LIGHT_DIRECTIONAL));
		for (uint32_t m = 0; m < shadow->map_count; m++)
			shadow_write_map(shadows, shadow->first_map + m, shadow->map_count - m, pixels, &view->lights[i],
			                 &out[shadow->first_map + m]);
		for (uint32_t m = 0; m < shadow->map_count; m++)
			out[shadow->first_map + m].strength = 1.0f - shadow->faded;
	}
	return STILB_OK;
}
