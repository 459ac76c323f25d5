/* What scene passes draw into: the images of a frame's targets, and how they come into the picture. */
#include "render/device/render_images.h"
#include "render/render_internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- images ------------------------------------------------------------------------------------------------------ */

static bool target_is_main(const stilb_render_target *target)
{
	return !target ||
	       (target->kind == STILB_RENDER_TARGET_LIGHT && strcmp(target->name, STILB_RENDER_IMAGE_COLOR) == 0);
}

void render_target_name(const render_frame_target *target, const char *what, char name[STILB_GPU_MAX_NAME + 1])
{
	bool main = target_is_main(target->from);
	snprintf(name, STILB_GPU_MAX_NAME + 1, "%s%s%s", main ? "" : target->from->name, main ? "" : " ", what);
}

/* An image of a target. what: what it is, behind the target's name; "": nothing. */
static uint16_t target_image(render_device *device, const render_frame_target *target, const char *name,
                             const char *what, stilb_gpu_format format, uint32_t samples, bool output)
{
	bool array = target->from && target->from->kind == STILB_RENDER_TARGET_DEPTH;
	uint16_t layers = array ? target->from->layers : 0;
	char whole[STILB_GPU_MAX_NAME + 1];
	if (what[0] != '\0') {
		snprintf(whole, sizeof whole, "%s %s", name, what);
		name = whole;
	}
	return stilb_gpu_plan_image(device->plan, &(stilb_gpu_plan_image_row){.name = name,
	                                                                      .format = format,
	                                                                      .width = target->width,
	                                                                      .height = target->height,
	                                                                      .samples = (uint8_t)samples,
	                                                                      .layers = layers,
	                                                                      .output = output});
}

stilb_result render_target_reserve(render_device *device, const stilb_render_target *from)
{
	stilb_gpu_extent extent = {.format = STILB_GPU_D32_F,
	                           .width = from->width,
	                           .height = from->height,
	                           .depth = 1,
	                           .layers = from->layers > 0 ? from->layers : 1,
	                           .mips = 1,
	                           .samples = 1,
	                           .uses = 1u << STILB_GPU_USE_SAMPLED | STILB_GPU_EXTENT_ATTACHMENT};
	const stilb_gpu_extent *last = &device->lasting_extent;
	if (device->lasting.id != 0 && extent.width == last->width && extent.height == last->height &&
	    extent.layers == last->layers)
		return STILB_OK;
	stilb_gpu_image_desc desc = {.name = from->name, .extent = extent};
	if (device->lasting.id != 0)
		stilb_gpu_image_destroy(device->gpu, device->lasting);
	device->lasting = (stilb_gpu_image){0};
	device->lasting_extent = extent;
	stilb_result result = stilb_gpu_image_create(device->gpu, &desc, &device->lasting);
	if (result != STILB_OK)
		device->lasting = (stilb_gpu_image){0};
	return result;
}

/* The image of a lasting target. */
static uint16_t target_lasting(render_device *device, render_frame_target *target)
{
	const stilb_gpu_extent *extent = &device->lasting_extent;
	target->result = render_target_reserve(device, target->from);
	if (target->result != STILB_OK)
		return 0;
	stilb_gpu_plan_image_row row = {.name = target->from->name,
	                                .format = extent->format,
	                                .width = extent->width,
	                                .height = extent->height,
	                                .layers = extent->layers,
	                                .output = target->from->output,
	                                .owned = device->lasting.id};
	return stilb_gpu_plan_image(device->plan, &row);
}

static void target_images(render_device *device, render_frame_target *target)
{
	const stilb_render_target *from = target->from;
	if (from && from->kind == STILB_RENDER_TARGET_DEPTH) {
		target->depth = from->lasting ? target_lasting(device, target)
		                              : target_image(device, target, from->name, "", STILB_GPU_D32_F, 1, from->output);
		return;
	}
	bool main = target_is_main(from);
	target->main = main;
	const char *name = main ? STILB_RENDER_IMAGE_COLOR : from->name;
	const char *depth = main ? STILB_RENDER_IMAGE_DEPTH : from->name;
	target->color = target_image(device, target, name, "", STILB_GPU_RGBA16_F, 1, main || from->output);
	target->depth = target_image(device, target, depth, main ? "" : "depth", STILB_GPU_D32_F, device->samples, false);
	if (device->samples > 1)
		target->samples =
			target_image(device, target, name, "samples", render_hdr_formats[target->hdr], device->samples, false);
	else if (target->hdr != STILB_RENDER_HDR_HALF)
		target->encoded = target_image(device, target, name, "encoded", render_hdr_formats[target->hdr], 1, false);
}

static_assert(STILB_RENDER_TARGET_NAME + sizeof " samples" <= STILB_GPU_MAX_NAME, "names of a target's images fit");

render_frame_target *render_target_get(render_device *device, const stilb_render_target *from, stilb_render_hdr hdr)
{
	render_frame *frame = &device->frame;
	for (uint32_t t = 0; t < frame->target_count; t++)
		if (frame->targets[t].from == from)
			return &frame->targets[t];
	STILB_ASSERT(frame->target_count < STILB_RENDER_MAX_PASSES);
	render_frame_target *target = &frame->targets[frame->target_count++];
	*target = (render_frame_target){.from = from,
	                                .hdr = hdr,
	                                .width = from ? from->width : device->width,
	                                .height = from ? from->height : device->height};
	target_images(device, target);
	return target;
}

static uint16_t target_image_of(render_device *device, const render_frame_target *target, const char *what,
                                stilb_gpu_format format, uint16_t layers, bool output)
{
	char name[STILB_GPU_MAX_NAME + 1];
	bool main = target->main || !target->from;
	render_target_name(target, what, name);
	return stilb_gpu_plan_image(device->plan,
	                            &(stilb_gpu_plan_image_row){.name = name,
	                                                        .format = format,
	                                                        .width = target->width,
	                                                        .height = target->height,
	                                                        .layers = layers,
	                                                        .samples = 1,
	                                                        .output = output && (main || target->from->output)});
}

uint16_t render_target_image(render_device *device, const render_frame_target *target, const char *what,
                             stilb_gpu_format format, bool output)
{
	return target_image_of(device, target, what, format, 1, output);
}

uint16_t render_target_layers(render_device *device, const render_frame_target *target, const char *what,
                              stilb_gpu_format format, uint16_t layers)
{
	return target_image_of(device, target, what, format, layers, false);
}

uint16_t render_target_beside(render_device *device, render_frame_target *target, render_beside image)
{
	if (target->beside[image] == 0)
		target->beside[image] =
			render_target_image(device, target, render_beside_name(image), render_beside_format(image), true);
	return target->beside[image];
}

void render_target_attach(render_device *device, const render_formula_programs *choice, render_frame_target *target,
                          stilb_gpu_pass *row)
{
	for (uint32_t i = 0; i < RENDER_BESIDE_IMAGES; i++) {
		int place = render_beside_place(choice, (render_beside)i);
		if (place < 0)
			continue;
		while (row->color_count <= place)
			row->color[row->color_count++] = (stilb_gpu_attachment){.load = STILB_GPU_LOAD_NONE};
		stilb_gpu_load load = target->beside[i] != 0 ? STILB_GPU_LOAD_KEEP : STILB_GPU_LOAD_CLEAR; /* to 0 */
		row->color[place] =
			(stilb_gpu_attachment){.image = render_target_beside(device, target, (render_beside)i), .load = load};
	}
}

render_frame_target *render_target_main(render_device *device)
{
	for (uint32_t t = 0; t < device->frame.target_count; t++)
		if (device->frame.targets[t].main)
			return &device->frame.targets[t];
	return NULL;
}

uint32_t render_target_nothing(render_device *device)
{
	render_frame *frame = &device->frame;
	if (frame->empty_list > 0)
		return frame->empty_list - 1;
	uint32_t number = frame->list_count++;
	STILB_ASSERT(number < RENDER_MAX_LISTS);
	device->lists[number].first_run = frame->run_count;
	device->draws[number] =
		(stilb_gpu_draws){.commands = render_slot_now(device)->memory[RENDER_MEMORY_COMMANDS].buffer};
	frame->empty_list = number + 1;
	return number;
}

/* ---- the picture ------------------------------------------------------------------------------------------------- */

/* The rectangle of the picture that shows the target. False: none does. */
static bool target_place(const render_device *device, const render_frame_target *target, uint16_t place[4])
{
	memcpy(place, (uint16_t[4]){0, 0, (uint16_t)device->width, (uint16_t)device->height}, 4 * sizeof *place);
	if (!target->from)
		return true;
	memcpy(place, target->from->place, 4 * sizeof *place);
	return target->color != 0 && place[2] > 0;
}

/* A fullscreen pass that samples `from`, besides what its row has already, and fills an area of `to`, all zeros: all
 * of it. */
static void target_screen(render_device *device, stilb_gpu_pass row, uint16_t from, stilb_gpu_attachment to,
                          stilb_gpu_sampler sampler, render_tone_push push)
{
	row.kind = STILB_GPU_PASS_FULLSCREEN;
	row.color[0] = to;
	row.color_count = 1;
	row.uses[0] = (stilb_gpu_use){.resource = from, .how = STILB_GPU_USE_SAMPLED, .sampler = (uint8_t)sampler.id};
	row.use_count = row.use_count > 1 ? row.use_count : 1;
	memcpy(row.constants, &push, sizeof push);
	row.constant_bytes = sizeof push;
	stilb_gpu_plan_pass(device->plan, &row);
}

void render_targets_resolve(render_device *device)
{
	const render_frame *frame = &device->frame;
	for (uint32_t t = 0; t < frame->target_count; t++) {
		const render_frame_target *target = &frame->targets[t];
		stilb_gpu_pass row = {.name = target->samples ? "resolve" : "decode",
		                      .program = target->samples ? device->programs.resolves[target->hdr].id
		                                                 : device->programs.decodes[target->hdr].id};
		if (target->samples || target->encoded)
			target_screen(device, row, render_target_light(target),
			              (stilb_gpu_attachment){.image = target->color, .load = STILB_GPU_LOAD_DISCARD},
			              (stilb_gpu_sampler){0},
			              (render_tone_push){.exposure = target->data ? 0.0f : target->exposure});
	}
}

/* Has the row that shows the target look up its colours in a table. */
static void target_grade(render_device *device, const render_frame_target *target, stilb_gpu_pass *row,
                         render_tone_push *push)
{
	const stilb_render_grade *grade = target->grade;
	uint32_t size = grade->size;
	stilb_gpu_plan_image_row image = {.name = "grade",
	                                  .format = STILB_GPU_RGBA32_F,
	                                  .shape = STILB_GPU_SHAPE_3D,
	                                  .width = grade->curves ? 256 : size,
	                                  .height = grade->curves ? (size + 255) / 256 : size,
	                                  .depth = grade->curves ? 1 : size,
	                                  .owned = grade->table.id};
	uint16_t table = stilb_gpu_plan_find(device->plan, image.name);
	if (table == 0)
		table = stilb_gpu_plan_image(device->plan, &image);
	row->name = "tone map, grade";
	row->program = device->programs.grades[(bool)target->from][target->tone][grade->curves].id;
	row->uses[1] = (stilb_gpu_use){.resource = table, .how = STILB_GPU_USE_SAMPLED, .slot = 1};
	row->use_count = 2;
	push->grade_size = (int32_t)size;
	for (int c = 0; c < 3; c++) {
		push->grade_low[c] = grade->low[c];
		push->grade_scale[c] = (float)(size - 1) / (grade->high[c] - grade->low[c]);
	}
}

void render_targets_show(render_device *device, uint16_t main_light)
{
	render_frame *frame = &device->frame;
	const render_frame_target *main = render_target_main(device);
	for (uint32_t t = 0; t < frame->target_count; t++) {
		const render_frame_target *target = &frame->targets[t];
		stilb_gpu_pass row = {.name = "tone map"};
		if (!target_place(device, target, row.area))
			continue;
		bool scaled = target->width != row.area[2] || target->height != row.area[3];
		bool all = row.area[2] == device->width && row.area[3] == device->height;
		stilb_gpu_attachment to = {.image = frame->picture,
		                           .load = (uint8_t)(all            ? STILB_GPU_LOAD_DISCARD
		                                             : frame->shown ? STILB_GPU_LOAD_KEEP
		                                                            : STILB_GPU_LOAD_CLEAR),
		                           .clear = {0.0f, 0.0f, 0.0f, 1.0f}};
		render_tone_push push = {.exposure = target->exposure,
		                         .dither = target->dither,
		                         .left = row.area[0],
		                         .top = row.area[1],
		                         .width = row.area[2],
		                         .height = row.area[3],
		                         .border = target->from ? target->from->border : 0};
		row.program = device->programs.tones[(bool)target->from][target->tone].id;
		if (target->grade)
			target_grade(device, target, &row, &push);
		target_screen(device, row, target == main ? main_light : target->color, to,
		              scaled ? device->linear : (stilb_gpu_sampler){0}, push);
		frame->shown = true;
	}
}
