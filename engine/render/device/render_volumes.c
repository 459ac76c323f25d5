/* Bodies around lights, for deferred lighting: a light is added where its body encloses what is seen, which the
 * stencil counts, also if the viewer is inside. Sources: maxest, "Deferred Lighting on Android" (2012); counting behind
 * what is seen is of shadow volumes, Carmack (2000). */
#include "render/render_internal.h"

#include <string.h>

/* The draw of a body, and its faces: anticlockwise as seen from outside, in a picture whose y points down. */
static stilb_result volumes_make(render_device *device)
{
	static const uint16_t faces[20][3] = {
		{0, 5, 11},  {0, 1, 5},  {0, 7, 1},  {0, 10, 7}, {0, 11, 10}, {1, 9, 5}, {5, 4, 11},
		{11, 2, 10}, {10, 6, 7}, {7, 8, 1},  {3, 4, 9},  {3, 2, 4},   {3, 6, 2}, {3, 8, 6},
		{3, 9, 8},   {4, 5, 9},  {2, 11, 4}, {6, 10, 2}, {8, 7, 6},   {9, 1, 8},
	};
	if (device->volume_indices.buffer.id != 0)
		return STILB_OK;
	stilb_result result = STILB_OK;
	if (device->volume_draw.buffer.id == 0)
		result = render_buffer_make(device, "light volume draw", STILB_GPU_DRAW_STRIDE, STILB_GPU_MEMORY_WRITE,
		                            STILB_GPU_BUFFER_INDIRECT, &device->volume_draw);
	if (result == STILB_OK)
		result = render_buffer_make(device, "light volume faces", sizeof faces, STILB_GPU_MEMORY_WRITE,
		                            STILB_GPU_BUFFER_INDICES, &device->volume_indices);
	if (result != STILB_OK)
		return result;
	memcpy(device->volume_indices.mapped, faces, sizeof faces);
	memcpy(device->volume_draw.mapped, &(render_command){.index_count = 60, .instance_count = 1},
	       sizeof(render_command));
	return STILB_OK;
}

/* The image that has a stencil, with the depth of what is seen. */
static uint16_t volumes_image(render_device *device, const render_frame_target *target)
{
	char name[STILB_GPU_MAX_NAME + 1];
	render_target_name(target, "light volumes", name);
	uint16_t image = stilb_gpu_plan_image(device->plan, &(stilb_gpu_plan_image_row){.name = name,
	                                                                                .format = STILB_GPU_D32_F_S8,
	                                                                                .width = target->width,
	                                                                                .height = target->height});
	stilb_gpu_plan_pass(device->plan, &(stilb_gpu_pass){
										  .name = "light volumes depth",
										  .kind = STILB_GPU_PASS_FULLSCREEN,
										  .program = device->programs.volume_depth.id,
										  .depth = {.image = image, .load = STILB_GPU_LOAD_CLEAR},
										  .uses = {{.resource = target->depth, .how = STILB_GPU_USE_SAMPLED}},
										  .use_count = 1,
									  });
	return image;
}

/* The list of draws: for each light its body twice, to count and to add its light. */
static stilb_result volumes_list(render_device *device, const render_stream *stream,
                                 const render_formula_programs *choice, bool apart, uint32_t *number)
{
	render_frame *frame = &device->frame;
	const render_view_lights *lights = &stream->lights;
	uint32_t count = lights->count - lights->endless;
	uint64_t first = render_slot_now(device)->memory[RENDER_MEMORY_LIGHTS].address +
	                 (lights->first + lights->endless) * sizeof(render_light);
	*number = frame->list_count;
	STILB_ASSERT(*number < RENDER_MAX_LISTS);
	render_list *list = &device->lists[frame->list_count++];
	device->draws[*number] = (stilb_gpu_draws){0};
	list->first_run = frame->run_count;
	if (count > (UINT32_MAX - frame->run_count) / 2 ||
	    !render_reserve((void **)&device->runs, &device->run_capacity, frame->run_count + 2 * count,
	                    sizeof *device->runs) ||
	    !render_reserve((void **)&list->bindings, &list->binding_capacity, 2, sizeof *list->bindings))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the bodies of %u lights", count);
	for (uint32_t i = 0; i < 2 * count; i++)
		device->runs[frame->run_count++] =
			(stilb_gpu_run){.count = 1, .binding = i & 1u, .constant = first + i / 2 * sizeof(render_light)};
	for (int lit = 0; lit < 2; lit++)
		list->bindings[lit] = (stilb_gpu_binding){
			.program = lit ? choice->volumes.id : device->programs.volume_count[apart].id,
			.index_bytes = 2,
			.indices = device->volume_indices.buffer.id,
		};
	device->draws[*number] = (stilb_gpu_draws){
		.draws = device->volume_draw.mapped,
		.commands = device->volume_draw.buffer,
		.bindings = list->bindings,
		.binding_count = 2,
		.run_count = 2 * count,
		.replay = STILB_GPU_REPLAY_DIRECT,
		.has_constants = true,
		.constant_place = offsetof(render_push, view.lights),
	};
	return STILB_OK;
}

stilb_result render_volumes_add(render_device *device, const render_stream *stream, render_frame_target *target,
                                const render_formula_programs *choice, stilb_gpu_pass *row)
{
	uint32_t list, one = 1;
	bool apart = render_view_way(device, stream->view).apart;
	stilb_result result = volumes_make(device);
	if (result == STILB_OK)
		result = volumes_list(device, stream, choice, apart, &list);
	if (result != STILB_OK)
		return result;
	row->kind = STILB_GPU_PASS_DRAWS;
	row->program = 0;
	row->draws = list;
	row->depth = (stilb_gpu_attachment){.image = volumes_image(device, target), .load = STILB_GPU_LOAD_KEEP};
	memcpy(row->constants + offsetof(render_push, view.light_count), &one, sizeof one);
	stilb_gpu_plan_pass(device->plan, row);
	return STILB_OK;
}
