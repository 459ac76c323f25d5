/* The surroundings' light, drawn apart from all other and then added: so that passes between may change it alone. */
#include "render/device/render_images.h"
#include "render/render_internal.h"

void render_around_attach(render_device *device, render_frame_target *target, stilb_gpu_pass *row)
{
	static const char *const images[2] = {STILB_RENDER_IMAGE_AMBIENT, STILB_RENDER_IMAGE_REFLECTION};
	row->depth = (stilb_gpu_attachment){.image = target->depth, .load = STILB_GPU_LOAD_KEEP, .read_only = true};
	row->color_count = 2;
	for (uint32_t i = 0; i < 2; i++)
		row->color[i] =
			(stilb_gpu_attachment){.image = render_target_image(device, target, images[i], STILB_GPU_RGBA16_F, true),
		                           .load = STILB_GPU_LOAD_CLEAR};
}

stilb_result render_around_add(render_device *device, const render_frame_target *target, const uint16_t images[2])
{
	stilb_result result = render_programs_around(device);
	if (result != STILB_OK)
		return result;
	stilb_gpu_pass add = {
		.name = "ambient added",
		.kind = STILB_GPU_PASS_FULLSCREEN,
		.program = device->programs.around.id,
		.color_count = 1,
		.color = {{.image = target->color, .load = STILB_GPU_LOAD_KEEP}},
		.use_count = 2,
		.uses = {{.resource = images[0], .how = STILB_GPU_USE_SAMPLED},
	             {.resource = images[1], .how = STILB_GPU_USE_SAMPLED, .slot = 1}},
	};
	stilb_gpu_plan_pass(device->plan, &add);
	return STILB_OK;
}
