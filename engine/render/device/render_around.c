/* The surroundings' light, drawn apart from all other and then added: so that passes between may change it alone. */
#include "render/device/render_images.h"
#include "render/render_internal.h"

void render_around_attach(render_device *device, const stilb_render_view *view, render_frame_target *target,
                          stilb_gpu_pass *row)
{
	static const struct {
		const char *name;
		stilb_gpu_format format;
	} images[] = {{STILB_RENDER_IMAGE_AMBIENT, STILB_GPU_RGBA16_F},
	              {STILB_RENDER_IMAGE_REFLECTION, STILB_GPU_RGBA16_F},
	              {STILB_RENDER_IMAGE_MIRROR, STILB_GPU_RGBA8_U},
	              {STILB_RENDER_IMAGE_MIRROR_NORMAL, STILB_GPU_RG16_U}};
	row->depth = (stilb_gpu_attachment){.image = target->depth, .load = STILB_GPU_LOAD_KEEP, .read_only = true};
	row->color_count = view->mirrors ? 4 : 2;
	for (uint32_t i = 0; i < row->color_count; i++)
		row->color[i] =
			(stilb_gpu_attachment){.image = render_target_image(device, target, images[i].name, images[i].format, true),
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
