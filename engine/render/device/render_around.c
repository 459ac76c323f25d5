/* The surroundings' light, drawn apart from all other and then added: so that passes between may change it alone. */
#include "render/render_internal.h"

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
