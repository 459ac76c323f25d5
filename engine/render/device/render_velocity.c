/* The image of velocities: where what each pixel shows was in the frame before. */
#include "render/device/render_images.h"
#include "render/render_internal.h"

#include <string.h>

static_assert(STILB_RENDER_TARGET_NAME + sizeof " " STILB_RENDER_IMAGE_VELOCITY_DEPTH <= STILB_GPU_MAX_NAME + 1,
              "names of a target's images fit");
static_assert(sizeof(render_velocity_push) == 96, "std430");

stilb_result render_velocity_begin(render_device *device, const render_stream *stream, uint64_t view,
                                   render_frame_target *target)
{
	const stilb_scene_backdrop *backdrop = &stream->view->backdrop;
	if (target->beside[RENDER_BESIDE_IMAGE_VELOCITY] != 0)
		return STILB_OK;
	stilb_result result = render_programs_velocity(device);
	if (result != STILB_OK)
		return result;
	render_velocity_push push = {.half_size = {0.5f * (float)target->width, 0.5f * (float)target->height},
	                             .last = view + offsetof(render_view_data, last_view_projection)};
	render_backdrop_axes(stream->view, push.ahead, push.across, push.down);
	memcpy(push.camera, stream->view->camera_position, sizeof stream->view->camera_position);
	if (backdrop->kind == STILB_SCENE_BACKDROP_COLOR && backdrop->floor) {
		memcpy(push.floor_radius, backdrop->floor->center, sizeof backdrop->floor->center);
		push.floor_radius[3] = backdrop->floor->radius;
	}
	stilb_gpu_pass row = {
		.name = "velocity far away",
		.kind = STILB_GPU_PASS_FULLSCREEN,
		.program = device->programs.velocity_far.id,
		.color_count = 1,
		.color = {{.image = render_target_beside(device, target, RENDER_BESIDE_IMAGE_VELOCITY),
	               .load = STILB_GPU_LOAD_DISCARD}},
		.constant_bytes = sizeof push,
	};
	memcpy(row.constants, &push, sizeof push);
	stilb_gpu_plan_pass(device->plan, &row);
	return STILB_OK;
}

stilb_gpu_attachment render_velocity_depth(render_device *device, const stilb_render_view *view,
                                           render_frame_target *target)
{
	stilb_gpu_load load = target->velocity_depth != 0 ? STILB_GPU_LOAD_KEEP : STILB_GPU_LOAD_CLEAR;
	if (target->velocity_depth == 0)
		target->velocity_depth =
			render_target_image(device, target, STILB_RENDER_IMAGE_VELOCITY_DEPTH, STILB_GPU_D32_F, view->surfaces);
	return (stilb_gpu_attachment){.image = target->velocity_depth, .load = load};
}
