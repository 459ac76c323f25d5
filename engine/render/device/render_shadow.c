/* The image of shadow maps that passes read. */
#include "render/device/render_images.h"
#include "render/render_internal.h"

/* The image in place of maps, of one texel, which nothing writes: programs without shadows do not look at it. */
static stilb_result shadow_none(render_device *device)
{
	if (device->no_shadows.id == 0) {
		stilb_gpu_image_desc desc = {.name = STILB_RENDER_IMAGE_NO_SHADOWS,
		                             .extent = {.format = STILB_GPU_R32_F,
		                                        .width = 1,
		                                        .height = 1,
		                                        .depth = 1,
		                                        .layers = 2, /* an array */
		                                        .mips = 1,
		                                        .samples = 1,
		                                        .uses = 1u << STILB_GPU_USE_SAMPLED}};
		stilb_result result = stilb_gpu_image_create(device->gpu, &desc, &device->no_shadows);
		if (result != STILB_OK)
			return result;
	}
	if (device->frame.no_shadows == 0)
		device->frame.no_shadows = stilb_gpu_plan_image(device->plan, &(stilb_gpu_plan_image_row){
																		  .name = STILB_RENDER_IMAGE_NO_SHADOWS,
																		  .format = STILB_GPU_R32_F,
																		  .width = 1,
																		  .height = 1,
																		  .layers = 2,
																		  .owned = device->no_shadows.id,
																	  });
	return STILB_OK;
}

/* Clears layers that no pass has drawn: nothing is in front of a light there. Returns how many are read. */
static uint16_t shadow_clear(render_device *device, const stilb_render_shadows *shadows, render_frame_target *target)
{
	uint16_t layers = 2; /* an array */
	for (uint32_t m = 0; m < shadows->map_count; m++)
		layers = layers > shadows->maps[m].layer ? layers : (uint16_t)(shadows->maps[m].layer + 1);
	for (uint16_t layer = 0; layer < layers && !shadows->target->lasting; layer++) {
		uint64_t *drawn = &target->layers_drawn[layer / 64], bit = UINT64_C(1) << layer % 64;
		if (!(*drawn & bit))
			stilb_gpu_plan_pass(device->plan,
			                    &(stilb_gpu_pass){
									.name = "no shadow",
									.kind = STILB_GPU_PASS_DRAWS,
									.draws = render_target_nothing(device),
									.depth = {.image = target->depth, .layer = layer, .load = STILB_GPU_LOAD_CLEAR},
								});
		*drawn |= bit;
	}
	return layers;
}

/* ---- the buffer -------------------------------------------------------------------------------------------------- */

static uint16_t terms_layers(const render_stream *stream)
{
	return (uint16_t)((stream->lights.terms + RENDER_SHADOW_LAYER - 1) / RENDER_SHADOW_LAYER);
}

stilb_result render_terms_mask(const render_device *device, const render_frame_target *target, uint16_t *mask)
{
	*mask = target->main ? stilb_gpu_plan_find(device->plan, STILB_RENDER_IMAGE_MASK) : 0;
	if (*mask == 0)
		return STILB_OK;
	const stilb_gpu_extent *extent = stilb_gpu_plan_extent(device->plan, *mask);
	if (extent->format == STILB_GPU_R8_U && extent->width == target->width && extent->height == target->height)
		return STILB_OK;
	return stilb_fail(STILB_ERROR_ARGUMENT,
	                  "image '%s' is %ux%u of format %s, and the main images are %ux%u; make it as large, of r8_u",
	                  STILB_RENDER_IMAGE_MASK, extent->width, extent->height,
	                  stilb_gpu_format_describe(extent->format)->name, target->width, target->height);
}

stilb_result render_terms_attach(render_device *device, const render_stream *stream, render_frame_target *target,
                                 uint16_t mask, uint16_t layer, stilb_gpu_pass *row)
{
	stilb_result result = render_shadow_use(device, stream, target, row);
	if (result == STILB_OK && mask == 0)
		result = shadow_none(device);
	if (result != STILB_OK)
		return result;
	row->uses[row->use_count] = (stilb_gpu_use){.resource = mask != 0 ? mask : device->frame.no_shadows,
	                                            .how = STILB_GPU_USE_SAMPLED,
	                                            .slot = row->use_count,
	                                            .array = true};
	row->use_count++;
	if (target->terms == 0)
		target->terms = render_target_layers(device, target, STILB_RENDER_IMAGE_SHADOW_BUFFER, STILB_GPU_RGBA8_U,
		                                     terms_layers(stream));
	row->color_count = 1;
	row->color[0] = (stilb_gpu_attachment){.image = target->terms, .layer = layer, .load = STILB_GPU_LOAD_DISCARD};
	return STILB_OK;
}

/* ---- what passes read -------------------------------------------------------------------------------------------- */

stilb_result render_shadow_use(render_device *device, const render_stream *stream, const render_frame_target *target,
                               stilb_gpu_pass *row)
{
	stilb_gpu_use use = {.how = STILB_GPU_USE_SAMPLED, .slot = row->use_count, .array = true};
	const stilb_render_shadows *shadows = stream->view ? stream->view->shadows : NULL;
	if (stream->lights.shadow_bits & RENDER_SHADOW_BUFFER) {
		use.resource = target->terms;
	} else if (stream->lights.bits & RENDER_LIGHTS_SHADOWS && shadows && shadows->map_count > 0) {
		render_frame_target *maps = render_target_get(device, shadows->target, STILB_RENDER_HDR_HALF);
		use.resource = maps->depth;
		use.layers = shadow_clear(device, shadows, maps);
	} else {
		stilb_result result = shadow_none(device);
		if (result != STILB_OK)
			return result;
		use.resource = device->frame.no_shadows;
	}
	row->uses[row->use_count++] = use;
	return STILB_OK;
}
