/* Deferred lighting: surfaces are drawn into images, with the radiance that comes from no light; then a pass over the
 * picture adds that of the lights. Source: Deering and others, "The Triangle Processor and Normal Vector Shader" (1988);
 * Karis, "Deferred rendering 2" (2009). */
#include "render/device/render_images.h"
#include "render/render_internal.h"

#include <stdio.h>
#include <string.h>

const stilb_gpu_format render_gbuffer_formats[1 + RENDER_GBUFFER_IMAGES] = {STILB_GPU_RGBA16_F, STILB_GPU_RGBA16_U,
                                                                            STILB_GPU_RGBA16_U, STILB_GPU_RGBA16_U};
static const char *const deferred_images[RENDER_GBUFFER_IMAGES] = {
	STILB_RENDER_IMAGE_NORMAL, STILB_RENDER_IMAGE_DIFFUSE, STILB_RENDER_IMAGE_SPECULAR};

bool render_view_is_deferred(const render_device *device, const stilb_render_view *view)
{
	return view->lighting == STILB_RENDER_LIGHTING_DEFERRED && device->samples == 1 && render_view_is_lit(view);
}

bool render_maps_are_deferred(uint64_t bits)
{
	return !(bits & (RENDER_MAPS_BLEND | RENDER_MAPS_LAYERS | RENDER_MAPS_THROUGH)) && render_maps_function(bits) == 0;
}

uint32_t render_gbuffer_bits(uint32_t light_bits)
{
	return (light_bits & (RENDER_LIGHTS_SIDES | RENDER_LIGHTS_PANORAMA | RENDER_LIGHTS_GLOSS)) | RENDER_LIGHTS_GBUFFER;
}

void render_deferred_attach(render_device *device, render_frame_target *target, stilb_gpu_pass *row)
{
	for (uint32_t i = 0; i < RENDER_GBUFFER_IMAGES; i++) {
		char name[STILB_GPU_MAX_NAME + 1];
		snprintf(name, sizeof name, "%s%s%s", target->main ? "" : target->from->name, target->main ? "" : " ",
		         deferred_images[i]);
		target->surfaces[i] =
			stilb_gpu_plan_image(device->plan, &(stilb_gpu_plan_image_row){.name = name,
		                                                                   .format = render_gbuffer_formats[1 + i],
		                                                                   .width = target->width,
		                                                                   .height = target->height});
		row->color[1 + i] = (stilb_gpu_attachment){.image = target->surfaces[i], .load = STILB_GPU_LOAD_DISCARD};
	}
	row->color_count = 1 + RENDER_GBUFFER_IMAGES;
}

stilb_result render_deferred_lights(render_device *device, const render_frame_target *target,
                                    render_formula_programs *choice, const render_push *push)
{
	stilb_result result = render_programs_deferred(device, choice);
	if (result != STILB_OK)
		return result;
	stilb_gpu_pass row = {
		.name = "lights",
		.kind = STILB_GPU_PASS_FULLSCREEN,
		.program = choice->deferred.id,
		.color_count = 1,
		.color = {{.image = target->color, .load = STILB_GPU_LOAD_KEEP}},
		.use_count = 1 + RENDER_GBUFFER_IMAGES,
		.uses = {{.resource = target->depth, .how = STILB_GPU_USE_SAMPLED}},
		.constant_bytes = sizeof *push,
	};
	for (uint16_t i = 0; i < RENDER_GBUFFER_IMAGES; i++)
		row.uses[1 + i] =
			(stilb_gpu_use){.resource = target->surfaces[i], .how = STILB_GPU_USE_SAMPLED, .slot = (uint16_t)(1 + i)};
	memcpy(row.constants, push, sizeof *push);
	stilb_gpu_plan_pass(device->plan, &row);
	return STILB_OK;
}
