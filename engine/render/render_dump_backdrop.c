/* What a dump has of backgrounds and of the panorama: sizes, writing, checks and reading. */
#include "render/render_dump_format.h"
#include "render/render_internal.h"

#include <float.h>
#include <string.h>

#define BACKDROP_MAP_FLOATS ((size_t)3 * STILB_SCENE_BACKDROP_WIDTH * STILB_SCENE_BACKDROP_HEIGHT)
#define BACKDROP_FLOOR_FLOATS (sizeof(stilb_scene_floor) / sizeof(float))

static_assert(sizeof(stilb_scene_floor) == (4 + STILB_SCENE_FLOOR_SIDE * STILB_SCENE_FLOOR_SIDE) * sizeof(float),
              "a floor is written as it is: no padding");

/* ---- sizes ------------------------------------------------------------------------------------------------------- */

/* The floats of a record's panorama; sides are at most STILB_IMAGE_MAX_SIDE. */
static uint64_t backdrop_panorama_floats(const render_dump_backdrop *record)
{
	return (uint64_t)record->width * record->height * record->channels;
}

/* The first record with a panorama, or NULL. */
static const render_dump_backdrop *backdrop_with_panorama(const render_dump_backdrop *records, uint32_t views)
{
	for (uint32_t v = 0; v < views; v++)
		if (records[v].width > 0)
			return &records[v];
	return NULL;
}

uint64_t render_dump_backdrop_bytes(const render_dump_backdrop *records, uint32_t views)
{
	const render_dump_backdrop *panorama = backdrop_with_panorama(records, views);
	uint64_t floats = panorama ? backdrop_panorama_floats(panorama) : 0;
	for (uint32_t v = 0; v < views; v++)
		floats += (records[v].map ? BACKDROP_MAP_FLOATS : 0) + (records[v].floor ? BACKDROP_FLOOR_FLOATS : 0);
	return views * sizeof *records + render_dump_fill(floats * sizeof(float));
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

bool render_dump_backdrops_fill(const stilb_render *render, const stilb_render_view *views, uint32_t count,
                                render_dump_backdrop *records, bool *without_panorama)
{
	const render_panorama *shown = &render->panorama;
	bool any = false;
	*without_panorama = false;
	for (uint32_t v = 0; v < count; v++) {
		const stilb_scene_backdrop *from = &views[v].backdrop;
		const stilb_image *map = &views[v].surroundings.panorama;
		render_dump_backdrop *record = &records[v];
		*record = (render_dump_backdrop){.kind = from->kind,
		                                 .color = {from->color[0], from->color[1], from->color[2]},
		                                 .map = from->map ? 1 : 0,
		                                 .floor = from->floor ? 1 : 0};
		bool good = render_panorama_is_good(map);
		if (good && shown->pixels == map->pixels && shown->key == render_panorama_key(map)) {
			record->rotation = views[v].surroundings.rotation;
			record->width = map->width;
			record->height = map->height;
			record->channels = map->channels;
		} else {
			*without_panorama |= good;
		}
		any |= from->kind != STILB_SCENE_BACKDROP_SURROUNDINGS || record->width > 0;
	}
	return any;
}

void render_dump_backdrops_put(const render_dump_backdrop *records, const stilb_render_view *views, uint32_t count,
                               uint8_t *out)
{
	bool written = false; /* the panorama, which views share */
	memcpy(out, records, count * sizeof *records);
	out += count * sizeof *records;
	for (uint32_t v = 0; v < count; v++) {
		size_t bytes = backdrop_panorama_floats(&records[v]) * sizeof(float);
		if (bytes == 0 || written)
			continue;
		memcpy(out, views[v].surroundings.panorama.pixels, bytes);
		out += bytes;
		written = true;
	}
	for (uint32_t v = 0; v < count; v++) {
		if (records[v].map) {
			memcpy(out, views[v].backdrop.map, BACKDROP_MAP_FLOATS * sizeof(float));
			out += BACKDROP_MAP_FLOATS * sizeof(float);
		}
		if (records[v].floor) {
			memcpy(out, views[v].backdrop.floor, sizeof(stilb_scene_floor));
			out += sizeof(stilb_scene_floor);
		}
	}
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

static bool backdrop_within(const float *values, size_t count, float low, float high)
{
	bool within = true;
	for (size_t i = 0; i < count; i++)
		within &= values[i] >= low && values[i] <= high; /* false for a NaN */
	return within;
}

static stilb_result backdrop_check_record(const stilb_render_dump *dump, uint32_t v)
{
	const render_dump_backdrop *record = &dump->backdrops[v];
	const render_dump_backdrop *first = backdrop_with_panorama(dump->backdrops, dump->header->views);
	if (record->kind >= STILB_SCENE_BACKDROPS || record->map > 1 || record->floor > 1)
		return stilb_fail(STILB_ERROR_FILE, "background of view %u: unknown kind %u, map %u or floor %u", v,
		                  record->kind, record->map, record->floor);
	if (!backdrop_within(record->color, 3, 0.0f, FLT_MAX) || !backdrop_within(&record->rotation, 1, -FLT_MAX, FLT_MAX))
		return stilb_fail(STILB_ERROR_FILE, "background of view %u: a number is negative or not finite", v);
	if (record->width == 0)
		return record->height == 0 && record->channels == 0
		           ? STILB_OK
		           : stilb_fail(STILB_ERROR_FILE, "background of view %u: a panorama without a width", v);
	if (record->width > STILB_IMAGE_MAX_SIDE || record->height < 1 || record->height > STILB_IMAGE_MAX_SIDE ||
	    record->channels < 3 || record->channels > 4)
		return stilb_fail(STILB_ERROR_FILE,
		                  "background of view %u: a panorama of %ux%u pixels of %u channels; a side has "
		                  "1..%u, channels are 3 or 4",
		                  v, record->width, record->height, record->channels, STILB_IMAGE_MAX_SIDE);
	if (record->width != first->width || record->height != first->height || record->channels != first->channels)
		return stilb_fail(STILB_ERROR_FILE, "background of view %u: another panorama than a view before it has", v);
	return STILB_OK;
}

/* Finds the floats of a view's map and floor, which lie behind the panorama, the first of all; either is NULL where
 * there is none. Returns where they end. */
static const float *backdrop_floats(const stilb_render_dump *dump, uint32_t view, const float **map,
                                    const float **floor)
{
	const render_dump_backdrop *records = dump->backdrops, *panorama;
	const float *at = (const float *)(records + dump->header->views);
	panorama = backdrop_with_panorama(records, dump->header->views);
	at += panorama ? backdrop_panorama_floats(panorama) : 0;
	for (uint32_t v = 0; v <= view; v++) {
		*map = records[v].map ? at : NULL;
		at += records[v].map ? BACKDROP_MAP_FLOATS : 0;
		*floor = records[v].floor ? at : NULL;
		at += records[v].floor ? BACKDROP_FLOOR_FLOATS : 0;
	}
	return at;
}

stilb_result render_dump_check_backdrops(const stilb_render_dump *dump)
{
	const render_dump_header *h = dump->header;
	const float *map, *floor;
	if (h->backdrop_bytes == 0)
		return STILB_OK;
	if (h->backdrop_bytes < h->views * sizeof *dump->backdrops)
		return stilb_fail(STILB_ERROR_FILE, "header: %u bytes of backgrounds are too few for %u views",
		                  h->backdrop_bytes, h->views);
	for (uint32_t v = 0; v < h->views; v++) {
		stilb_result result = backdrop_check_record(dump, v);
		if (result != STILB_OK)
			return result;
	}
	uint64_t bytes = render_dump_backdrop_bytes(dump->backdrops, h->views);
	if (bytes != h->backdrop_bytes)
		return stilb_fail(STILB_ERROR_FILE, "header: %u bytes of backgrounds, but views have %llu", h->backdrop_bytes,
		                  (unsigned long long)bytes);
	const float *end = backdrop_floats(dump, h->views - 1, &map, &floor);
	const float *part_end = (const float *)((const uint8_t *)dump->backdrops + bytes);
	if (end < part_end && memcmp(end, (const uint32_t[1]){0}, sizeof *end) != 0)
		return stilb_fail(STILB_ERROR_FILE, "the bytes behind the backgrounds are not zero");
	for (uint32_t v = 0; v < h->views; v++) {
		backdrop_floats(dump, v, &map, &floor);
		if (map && !backdrop_within(map, BACKDROP_MAP_FLOATS, 0.0f, FLT_MAX))
			return stilb_fail(STILB_ERROR_FILE,
			                  "background of view %u: its map has a negative number or one that is not "
			                  "finite",
			                  v);
		if (floor && (!backdrop_within(floor, 3, -FLT_MAX, FLT_MAX) || !(floor[3] > 0.0f && floor[3] <= FLT_MAX) ||
		              !backdrop_within(floor + 4, BACKDROP_FLOOR_FLOATS - 4, 0.0f, 1.0f)))
			return stilb_fail(STILB_ERROR_FILE, "background of view %u: a number of its floor is out of range", v);
	}
	return STILB_OK;
}

void render_dump_backdrop_get(const stilb_render_dump *dump, uint32_t view, stilb_render_view *out)
{
	if (dump->header->backdrop_bytes == 0)
		return;
	const float *map, *floor, *panorama = (const float *)(dump->backdrops + dump->header->views);
	backdrop_floats(dump, view, &map, &floor);
	const render_dump_backdrop *from = &dump->backdrops[view];
	out->backdrop = (stilb_scene_backdrop){.kind = (stilb_scene_backdrop_kind)from->kind,
	                                       .color = {from->color[0], from->color[1], from->color[2]},
	                                       .map = (float *)map,
	                                       .floor = (stilb_scene_floor *)floor};
	out->surroundings.rotation = from->rotation;
	if (from->width > 0)
		out->surroundings.panorama = (stilb_image){.width = from->width,
		                                           .height = from->height,
		                                           .channels = from->channels,
		                                           .format = STILB_IMAGE_F32_LINEAR,
		                                           .pixels = (void *)panorama};
}
