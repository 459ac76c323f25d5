/* What each way of lighting (stilb_render_lighting) asks of programs: which surfaces, in which formats, and by which
 * bits of lights. */
#include "render/device/render_images.h"
#include "render/render_internal.h"

#include <string.h>

const stilb_gpu_format render_gbuffer_formats[STILB_RENDER_GBUFFER_KINDS][1 + RENDER_GBUFFER_IMAGES] = {
	[STILB_RENDER_GBUFFER_WIDE] = {STILB_GPU_RGBA16_F, STILB_GPU_RGBA16_U, STILB_GPU_RGBA16_U, STILB_GPU_RGBA16_U},
	[STILB_RENDER_GBUFFER_RGBA8] = {STILB_GPU_RGBA16_F, STILB_GPU_RGBA8_U, STILB_GPU_RGBA8_U, STILB_GPU_RGBA8_U},
};

const stilb_gpu_format render_hdr_formats[STILB_RENDER_HDRS] = {
	[STILB_RENDER_HDR_HALF] = STILB_GPU_RGBA16_F,
	[STILB_RENDER_HDR_RGBM] = STILB_GPU_RGBA8_U,
	[STILB_RENDER_HDR_LOGLUV] = STILB_GPU_RGBA8_U,
};

static const render_way ways[STILB_RENDER_LIGHTING_WAYS] = {
	[STILB_RENDER_LIGHTING_DEFERRED] = {.surfaces = true},
	[STILB_RENDER_LIGHTING_TILED_DEFERRED] = {.surfaces = true, .tiles = true},
	[STILB_RENDER_LIGHTING_TILED_FORWARD] = {.laid = true, .tiles = true},
	[STILB_RENDER_LIGHTING_INDEXED] = {.laid = true, .indexed = true},
	[STILB_RENDER_LIGHTING_PREPASS] = {.laid = true, .apart = true},
	[STILB_RENDER_LIGHTING_PRELIGHT] = {.laid = true, .apart = true},
};

bool render_view_lighting_is_known(const stilb_render_view *view)
{
	return (uint32_t)view->lighting < STILB_RENDER_LIGHTING_WAYS &&
	       (uint32_t)view->deferred.coverage < STILB_RENDER_COVERAGE_WAYS &&
	       (uint32_t)view->deferred.gbuffer < STILB_RENDER_GBUFFER_KINDS &&
	       (uint32_t)view->light_lists < STILB_RENDER_LIGHT_LISTS_WAYS &&
	       (uint32_t)view->ambient < STILB_RENDER_AMBIENT_KINDS && (uint32_t)view->hdr < STILB_RENDER_HDRS;
}

bool stilb_render_lighting_is_of_one_sample(stilb_render_lighting way)
{
	STILB_ASSERT((uint32_t)way < STILB_RENDER_LIGHTING_WAYS);
	return ways[way].surfaces || ways[way].laid;
}

render_way render_view_way(const render_device *device, const stilb_render_view *view)
{
	render_way way = device->samples == 1 && render_view_is_lit(view) ? ways[view->lighting] : (render_way){0};
	way.laid |= !way.surfaces && render_view_has_buffer(device, view);
	return way;
}

render_tiles render_view_tiles(const render_device *device, const stilb_render_view *view)
{
	render_way way = render_view_way(device, view);
	if (way.indexed)
		return RENDER_TILES_INDICES;
	if (!way.surfaces)
		return RENDER_TILES_DEPTH;
	return view->light_tolerance > 0.0f ? RENDER_TILES_GLOSS : RENDER_TILES_NORMALS;
}

bool render_view_has_volumes(const render_device *device, const stilb_render_view *view)
{
	return !ways[view->lighting].tiles && view->deferred.coverage == STILB_RENDER_COVERAGE_VOLUMES &&
	       stilb_gpu_limits_get(device->gpu)->counts;
}

bool render_maps_are_plain(uint64_t bits)
{
	return !(bits & (RENDER_MAPS_BLEND | RENDER_MAPS_LAYERS | RENDER_MAPS_THROUGH)) && render_maps_function(bits) == 0;
}

uint32_t render_added_bits(const stilb_render_view *view, uint32_t light_bits)
{
	bool multipass = view->lighting == STILB_RENDER_LIGHTING_MULTIPASS && render_view_is_lit(view);
	bool several = !(light_bits & RENDER_LIGHTS_ONE) && light_bits & ((1u << STILB_SCENE_LIGHT_KINDS) - 1);
	uint32_t read = ~(RENDER_LIGHTS_GLOSS | RENDER_LIGHTS_AMBIENT | RENDER_LIGHTS_ONE);
	return multipass && several ? (light_bits & read) | RENDER_LIGHTS_ADDED : 0;
}

/* How surfaces and their light are kept in images. */
static uint32_t ways_images(const stilb_render_view *view)
{
	if (ways[view->lighting].apart)
		return RENDER_LIGHTS_APART | (view->lighting == STILB_RENDER_LIGHTING_PREPASS ? RENDER_LIGHTS_GBUFFER8 : 0);
	return view->deferred.gbuffer == STILB_RENDER_GBUFFER_RGBA8 ? RENDER_LIGHTS_GBUFFER8 : 0;
}

/* How programs find lights between the two passes over surfaces. */
static uint32_t ways_lists(const stilb_render_view *view, uint32_t light_bits)
{
	bool lists = light_bits & RENDER_LIGHTS_LISTS;
	return (lists && ways[view->lighting].tiles ? RENDER_LIGHTS_TILES : 0) |
	       (lists && ways[view->lighting].indexed ? RENDER_LIGHTS_INDEXED : 0);
}

uint32_t render_gbuffer_bits(const stilb_render_view *view, uint32_t light_bits)
{
	uint32_t around = RENDER_LIGHTS_PANORAMA | RENDER_LIGHTS_GLOSS | RENDER_LIGHTS_AMBIENT;
	uint32_t read =
		RENDER_LIGHTS_SIDES | RENDER_LIGHTS_COUNTED | RENDER_LIGHTS_SHADOWS | (ways[view->lighting].apart ? 0 : around);
	return (light_bits & read) | RENDER_LIGHTS_GBUFFER | ways_images(view);
}

uint32_t render_deferred_bits(const stilb_render_view *view, uint32_t light_bits)
{
	bool lists = ways[view->lighting].tiles || view->deferred.coverage == STILB_RENDER_COVERAGE_CELLS;
	uint32_t unread = RENDER_LIGHTS_SIDES | RENDER_LIGHTS_GLOSS | RENDER_LIGHTS_AMBIENT | RENDER_LIGHTS_ONE |
	                  (lists ? 0 : RENDER_LIGHTS_LISTS);
	return (light_bits & ~unread) | ways_images(view) | ways_lists(view, light_bits);
}

uint32_t render_laid_bits(const stilb_render_view *view, uint32_t light_bits)
{
	if (!ways[view->lighting].apart)
		return light_bits | RENDER_LIGHTS_LAID | ways_lists(view, light_bits);
	uint32_t read = RENDER_LIGHTS_SIDES | RENDER_LIGHTS_PANORAMA | RENDER_LIGHTS_GLOSS | RENDER_LIGHTS_AMBIENT |
	                RENDER_LIGHTS_COUNTED;
	return (light_bits & read) | RENDER_LIGHTS_LAID | ways_images(view);
}

bool render_view_is_apart(const render_device *device, const stilb_render_view *view)
{
	return view->ambient_apart && device->samples == 1 && render_view_is_lit(view) && !render_view_counts(view);
}

uint32_t render_around_bits(uint32_t light_bits)
{
	uint32_t read = RENDER_LIGHTS_SIDES | RENDER_LIGHTS_PANORAMA | RENDER_LIGHTS_GLOSS | RENDER_LIGHTS_AMBIENT;
	return (light_bits & read) | RENDER_LIGHTS_LAID;
}

uint32_t render_unlit_around_bits(uint32_t light_bits)
{
	/* The panorama's bit stays: its lamps are lights, and have a size. */
	return (light_bits & ~(RENDER_LIGHTS_GLOSS | RENDER_LIGHTS_AMBIENT)) | RENDER_LIGHTS_DARK;
}

/* ---- shadows ----------------------------------------------------------------------------------------------------- */

stilb_render_hdr render_view_hdr(const stilb_render_view *view)
{
	bool adds = ways[view->lighting].surfaces || view->lighting == STILB_RENDER_LIGHTING_MULTIPASS;
	bool main = !view->target || (view->target->kind == STILB_RENDER_TARGET_LIGHT &&
	                              strcmp(view->target->name, STILB_RENDER_IMAGE_COLOR) == 0);
	bool light = main && view->show == STILB_RENDER_SHOW_SHADED && view->backdrop.kind != STILB_SCENE_BACKDROP_NOTHING;
	return light && !adds && !view->ambient_apart ? view->hdr : STILB_RENDER_HDR_HALF;
}

uint32_t render_shadow_bits(const stilb_render_view *view)
{
	const stilb_render_shadow_reading *reading = &view->shadow_reading;
	if (render_view_is_depth(view))
		return view->shadow_flat ? RENDER_SHADOW_FLAT : 0;
	return RENDER_SHADOW_HDR * (uint32_t)render_view_hdr(view) |
	       (view->show == STILB_RENDER_SHOW_CASCADES ? RENDER_SHADOW_CASCADES : 0) |
	       (view->show == STILB_RENDER_SHOW_ACNE ? RENDER_SHADOW_ACNE : 0) |
	       (reading->no_plane ? RENDER_SHADOW_NO_PLANE : 0) | (reading->no_way ? RENDER_SHADOW_NO_WAY : 0) |
	       (reading->things ? RENDER_SHADOW_THINGS : 0) | RENDER_SHADOW_TAPS * reading->taps;
}

bool render_view_has_buffer(const render_device *device, const stilb_render_view *view)
{
	bool shown = view->show == STILB_RENDER_SHOW_CASCADES || view->show == STILB_RENDER_SHOW_ACNE;
	return view->shadow_reading.buffer && view->shadows && device->samples == 1 && render_view_is_lit(view) &&
	       !render_view_counts(view) && !shown;
}

uint32_t render_terms_bits(uint32_t light_bits)
{
	uint32_t read =
		((1u << STILB_SCENE_LIGHT_KINDS) - 1) | RENDER_LIGHTS_END | RENDER_LIGHTS_SIDES | RENDER_LIGHTS_SHADOWS;
	return (light_bits & read) | RENDER_LIGHTS_LAID;
}

uint32_t render_terms_image_bits(const stilb_render_view *view, uint32_t light_bits)
{
	return (render_terms_bits(light_bits) & ~(RENDER_LIGHTS_LAID | RENDER_LIGHTS_SIDES)) | ways_images(view);
}

uint32_t render_terms_shadow_bits(uint32_t shadow_bits, bool mask)
{
	return (shadow_bits & (RENDER_SHADOW_HDR - 1)) | RENDER_SHADOW_TERMS | (mask ? RENDER_SHADOW_MASK : 0);
}
