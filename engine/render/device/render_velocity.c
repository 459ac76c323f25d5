/* The images of velocities: where what each pixel shows was in the frame before; and of its normal and model. */
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
	if (target->velocity != 0)
		return STILB_OK;
	stilb_result result = render_programs_velocity(device);
	if (result != STILB_OK)
		return result;
	target->velocity = render_target_image(device, target, STILB_RENDER_IMAGE_VELOCITY, STILB_GPU_RG16_F, true);
	target->velocity_depth =
		render_target_image(device, target, STILB_RENDER_IMAGE_VELOCITY_DEPTH, STILB_GPU_D32_F, stream->view->surfaces);
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
		.color = {{.image = target->velocity, .load = STILB_GPU_LOAD_DISCARD}},
		.constant_bytes = sizeof push,
	};
	memcpy(row.constants, &push, sizeof push);
	stilb_gpu_plan_pass(device->plan, &row);
	return STILB_OK;
}

void render_velocity_attach(render_device *device, const render_stream *stream, bool begun, render_frame_target *target,
                            stilb_gpu_pass *row)
{
	row->color_count = 1;
	row->color[0] = (stilb_gpu_attachment){.image = target->velocity, .load = STILB_GPU_LOAD_KEEP};
	row->depth = (stilb_gpu_attachment){.image = target->velocity_depth,
	                                    .load = begun ? STILB_GPU_LOAD_KEEP : STILB_GPU_LOAD_CLEAR};
	if (!stream->view->surfaces)
		return;
	stilb_gpu_load load = target->id != 0 ? STILB_GPU_LOAD_KEEP : STILB_GPU_LOAD_CLEAR; /* to 0 */
	if (target->id == 0) {
		target->normal = render_target_image(device, target, STILB_RENDER_IMAGE_SURFACE_NORMAL, STILB_GPU_RG16_U, true);
		target->id = render_target_image(device, target, STILB_RENDER_IMAGE_ID, STILB_GPU_R32_UI, true);
	}
	row->color_count = 3;
	row->color[1] = (stilb_gpu_attachment){.image = target->normal, .load = load};
	row->color[2] = (stilb_gpu_attachment){.image = target->id, .load = load};
}
