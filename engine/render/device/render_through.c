/* What is seen through draws with transmission: a copy of what their target shows before they are drawn, with mips that
 * rough surfaces read (shaders/through.glsl). Frames without such draws have neither the image nor the passes. */
#include "render/device/render_images.h"
#include "render/render_internal.h"

#include <stdio.h>
#include <string.h>

#define THROUGH_MIPS 9u /* of the image at most: a texel of the last one is 256 pixels wide */

/* Constants of shaders/behind.frag. */
typedef struct through_push {
	float exposure;
	uint32_t surroundings; /* 1: they are seen where no model is */
} through_push;

static uint32_t through_mips(const render_frame_target *target)
{
	uint32_t mips = render_mip_count(target->width, target->height);
	return mips < THROUGH_MIPS ? mips : THROUGH_MIPS;
}

static void through_image(render_device *device, render_frame_target *target)
{
	char name[STILB_GPU_MAX_NAME + 1];
	snprintf(name, sizeof name, "%s behind", target->main ? STILB_RENDER_IMAGE_COLOR : target->from->name);
	target->behind =
		stilb_gpu_plan_image(device->plan, &(stilb_gpu_plan_image_row){.name = name,
	                                                                   .format = STILB_GPU_RGBA16_F,
	                                                                   .width = target->width,
	                                                                   .height = target->height,
	                                                                   .mips = (uint16_t)through_mips(target)});
}

static_assert(STILB_RENDER_TARGET_NAME + sizeof " behind" <= STILB_GPU_MAX_NAME, "names of a target's images fit");

/* Adds the row that fills the first mip. */
static void through_first(render_device *device, const render_stream *stream, const render_frame_target *target)
{
	through_push push = {target->exposure, stream->view->backdrop.kind == STILB_SCENE_BACKDROP_SURROUNDINGS};
	stilb_gpu_pass row = {
		.name = "behind",
		.kind = STILB_GPU_PASS_FULLSCREEN,
		.color_count = 1,
		.color = {{.image = target->behind, .load = STILB_GPU_LOAD_DISCARD}},
		.use_count = 2,
		.uses = {{.resource = render_target_light(target), .how = STILB_GPU_USE_SAMPLED},
	             {.resource = target->depth, .how = STILB_GPU_USE_SAMPLED, .slot = 1}},
		.program = device->programs.behind.id,
		.constant_bytes = sizeof push,
	};
	memcpy(row.constants, &push, sizeof push);
	stilb_gpu_plan_pass(device->plan, &row);
}

stilb_result render_through_copy(render_device *device, const render_stream *stream, render_frame_target *target)
{
	stilb_result result = render_programs_behind(device);
	if (result != STILB_OK)
		return result;
	if (target->behind == 0)
		through_image(device, target);
	through_first(device, stream, target);
	for (uint32_t mip = 1; mip < through_mips(target); mip++) {
		stilb_gpu_use use = {
			.resource = target->behind, .how = STILB_GPU_USE_SAMPLED, .mip = (uint8_t)(mip - 1), .mips = 1};
		stilb_gpu_pass row = {.name = "behind, mips", .use_count = 1, .uses = {use}};
		if (mip == 1) {
			row.kind = STILB_GPU_PASS_FULLSCREEN;
			row.program = device->programs.behind_half.id;
			row.color_count = 1;
			row.color[0] = (stilb_gpu_attachment){.image = target->behind, .mip = 1, .load = STILB_GPU_LOAD_DISCARD};
		} else {
			row.kind = STILB_GPU_PASS_COPY;
			row.use_count = 2;
			row.uses[0].how = STILB_GPU_USE_COPY_FROM;
			row.uses[1] = use;
			row.uses[1].how = STILB_GPU_USE_COPY_TO;
			row.uses[1].mip = (uint8_t)mip;
		}
		stilb_gpu_plan_pass(device->plan, &row);
	}
	return STILB_OK;
}

stilb_result render_through_use(render_device *device, const render_frame_target *target, uint16_t slot,
                                stilb_gpu_use *use)
{
	stilb_gpu_sampler sampler;
	stilb_gpu_sampler_desc desc = {.linear = true, .mips = true, .mip_linear = true}; /* clamped */
	stilb_result result = stilb_gpu_sampler_get(device->gpu, &desc, &sampler);
	if (result == STILB_OK)
		*use = (stilb_gpu_use){
			.resource = target->behind, .how = STILB_GPU_USE_SAMPLED, .slot = slot, .sampler = sampler.id};
	return result;
}
