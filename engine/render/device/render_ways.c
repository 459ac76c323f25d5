/* What each way of lighting (stilb_render_lighting) asks of programs: which surfaces, in which formats, and by which
 * bits of lights. */
#include "render/render_internal.h"

const stilb_gpu_format render_gbuffer_formats[STILB_RENDER_GBUFFER_KINDS][1 + RENDER_GBUFFER_IMAGES] = {
	[STILB_RENDER_GBUFFER_WIDE] = {STILB_GPU_RGBA16_F, STILB_GPU_RGBA16_U, STILB_GPU_RGBA16_U, STILB_GPU_RGBA16_U},
	[STILB_RENDER_GBUFFER_RGBA8] = {STILB_GPU_RGBA16_F, STILB_GPU_RGBA8_U, STILB_GPU_RGBA8_U, STILB_GPU_RGBA8_U},
};

bool render_view_lighting_is_known(const stilb_render_view *view)
{
	return (uint32_t)view->lighting < STILB_RENDER_LIGHTING_WAYS &&
	       (uint32_t)view->deferred.coverage < STILB_RENDER_COVERAGE_WAYS &&
	       (uint32_t)view->deferred.gbuffer < STILB_RENDER_GBUFFER_KINDS;
}

bool render_view_is_deferred(const render_device *device, const stilb_render_view *view)
{
	return view->lighting == STILB_RENDER_LIGHTING_DEFERRED && device->samples == 1 && render_view_is_lit(view);
}

bool render_maps_are_plain(uint64_t bits)
{
	return !(bits & (RENDER_MAPS_BLEND | RENDER_MAPS_LAYERS | RENDER_MAPS_THROUGH)) && render_maps_function(bits) == 0;
}

uint32_t render_added_bits(const stilb_render_view *view, uint32_t light_bits)
{
	bool multipass = view->lighting == STILB_RENDER_LIGHTING_MULTIPASS && render_view_is_lit(view);
	bool several = !(light_bits & RENDER_LIGHTS_ONE) && light_bits & ((1u << STILB_SCENE_LIGHT_KINDS) - 1);
	uint32_t read = ~(RENDER_LIGHTS_GLOSS | RENDER_LIGHTS_ONE);
	return multipass && several ? (light_bits & read) | RENDER_LIGHTS_ADDED : 0;
}

static uint32_t deferred_narrow(const stilb_render_view *view)
{
	return view->deferred.gbuffer == STILB_RENDER_GBUFFER_RGBA8 ? RENDER_LIGHTS_GBUFFER8 : 0;
}

uint32_t render_gbuffer_bits(const stilb_render_view *view, uint32_t light_bits)
{
	uint32_t around = RENDER_LIGHTS_SIDES | RENDER_LIGHTS_PANORAMA | RENDER_LIGHTS_GLOSS;
	return (light_bits & around) | RENDER_LIGHTS_GBUFFER | deferred_narrow(view);
}

uint32_t render_deferred_bits(const stilb_render_view *view, uint32_t light_bits)
{
	bool lists = view->deferred.coverage == STILB_RENDER_COVERAGE_CELLS;
	uint32_t unread = RENDER_LIGHTS_SIDES | RENDER_LIGHTS_GLOSS | RENDER_LIGHTS_ONE | (lists ? 0 : RENDER_LIGHTS_LISTS);
	return (light_bits & ~unread) | deferred_narrow(view);
}
