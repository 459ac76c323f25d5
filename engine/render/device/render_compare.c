/* How far a target's light is from that of the reference, another view of the same size. */
#include "render/device/render_images.h"
#include "render/render_internal.h"

#include <string.h>

/* The image of the reference; 0: no view draws it in the size of `target`. */
static uint16_t target_reference(const render_device *device, const render_frame_target *target)
{
	for (uint32_t t = 0; t < device->frame.target_count; t++) {
		const render_frame_target *other = &device->frame.targets[t];
		if (other->from && strcmp(other->from->name, STILB_RENDER_IMAGE_REFERENCE) == 0 &&
		    other->width == target->width && other->height == target->height)
			return other->color;
	}
	return 0;
}

stilb_result render_target_compare(render_device *device, const render_frame_target *target, uint16_t *light)
{
	uint16_t reference = target_reference(device, target);
	if (reference == 0)
		return stilb_fail(STILB_ERROR_ARGUMENT, "a view shows its error, and none draws the target '%s' in its size",
		                  STILB_RENDER_IMAGE_REFERENCE);
	stilb_result result = render_programs_difference(device);
	if (result != STILB_OK)
		return result;
	uint16_t apart = render_target_image(device, target, STILB_RENDER_IMAGE_ERROR, STILB_GPU_RGBA16_F, true);
	stilb_gpu_pass compare = {
		.name = "difference",
		.kind = STILB_GPU_PASS_FULLSCREEN,
		.program = device->programs.difference.id,
		.color_count = 1,
		.color = {{.image = apart, .load = STILB_GPU_LOAD_DISCARD}},
		.use_count = 2,
		.uses = {{.resource = target->color, .how = STILB_GPU_USE_SAMPLED},
	             {.resource = reference, .how = STILB_GPU_USE_SAMPLED, .slot = 1}},
	};
	stilb_gpu_plan_pass(device->plan, &compare);
	*light = apart;
	return STILB_OK;
}
