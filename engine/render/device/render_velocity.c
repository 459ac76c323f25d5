/* The images of velocities: where what each pixel shows was in the frame before. */
#include "render/device/render_images.h"
#include "render/render_internal.h"

#include <stdio.h>
#include <string.h>

static uint16_t velocity_image(render_device *device, const render_frame_target *target, const char *what,
                               stilb_gpu_format format, bool output)
{
	char name[STILB_GPU_MAX_NAME + 1];
	bool main = target->main || !target->from;
	snprintf(name, sizeof name, "%s%s%s", main ? "" : target->from->name, main ? "" : " ", what);
	return stilb_gpu_plan_image(device->plan,
	                            &(stilb_gpu_plan_image_row){.name = name,
	                                                        .format = format,
	                                                        .width = target->width,
	                                                        .height = target->height,
	                                                        .samples = 1,
	                                                        .output = output && (main || target->from->output)});
}

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
	target->velocity = velocity_image(device, target, STILB_RENDER_IMAGE_VELOCITY, STILB_GPU_RG16_F, true);
	target->velocity_depth = velocity_image(device, target, STILB_RENDER_IMAGE_VELOCITY_DEPTH, STILB_GPU_D32_F, false);
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
