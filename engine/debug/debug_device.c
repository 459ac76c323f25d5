/* The device's part: a quadrilateral for each record, in one pass over the picture. */
#include "debug/debug_internal.h"

#include <stdlib.h>
#include <string.h>

/* As the shaders have it. */
typedef struct device_push {
	float view_projection[16];
	uint64_t records, places;
	float origin[2], size[2]; /* of the view's part of the picture, pixels */
	uint32_t view, views;
} device_push;

#define DEVICE_RECORDS 16384u /* of one draw: four vertices each, which 16-bit indices can name */
#define DEVICE_INDICES 6u

/* As VkDrawIndexedIndirectCommand. */
typedef struct device_command {
	uint32_t index_count, instance_count, first_index;
	int32_t vertex_offset;
	uint32_t first_instance, unused[3];
} device_command;

static_assert(sizeof(device_command) == STILB_GPU_DRAW_STRIDE, "commands and records are equally large");

/* Draws that so many records need. */
static uint32_t device_count(uint32_t records)
{
	return records / DEVICE_RECORDS + (records % DEVICE_RECORDS > 0);
}

/* Elements of a buffer before its records. */
static uint64_t device_before(uint32_t capacity)
{
	return STILB_RENDER_MAX_PASSES + (uint64_t)device_count(capacity);
}

static stilb_gpu *device_gpu(const stilb_debug *debug)
{
	return stilb_render_gpu(debug->render);
}

/* ---- what stays -------------------------------------------------------------------------------------------------- */

/* Two triangles for each four vertices. */
static stilb_result device_make_indices(stilb_debug *debug)
{
	static const uint16_t corners[DEVICE_INDICES] = {0, 1, 2, 2, 1, 3};
	stilb_gpu_buffer_desc desc = {.name = "debug indices",
	                              .bytes = (uint64_t)DEVICE_RECORDS * DEVICE_INDICES * sizeof(uint16_t),
	                              .memory = STILB_GPU_MEMORY_WRITE,
	                              .uses = STILB_GPU_BUFFER_INDICES};
	stilb_result result = stilb_gpu_buffer_create(device_gpu(debug), &desc, &debug->indices);
	if (result != STILB_OK)
		return result;
	uint16_t *out = stilb_gpu_buffer_mapped(device_gpu(debug), debug->indices);
	for (uint32_t r = 0; r < DEVICE_RECORDS; r++)
		for (uint32_t i = 0; i < DEVICE_INDICES; i++)
			out[r * DEVICE_INDICES + i] = (uint16_t)(4 * r + corners[i]);
	return STILB_OK;
}

/* Makes a new set of the picture of glyphs, which may be {0}. */
static stilb_result device_make_set(stilb_debug *debug)
{
	stilb_gpu_set set;
	stilb_gpu_set_item item = {.image = debug->glyphs};
	stilb_result result = stilb_gpu_set_create(device_gpu(debug), &item, 1, &set);
	if (result != STILB_OK)
		return result;
	if (debug->set.id)
		stilb_gpu_set_destroy(device_gpu(debug), debug->set);
	debug->set = set;
	return STILB_OK;
}

static stilb_result device_send_glyphs(stilb_debug *debug)
{
	const ui_fonts *fonts = &debug->fonts;
	stilb_gpu_upload upload = {.image = debug->glyphs,
	                           .width = fonts->width,
	                           .height = fonts->height,
	                           .depth = 1,
	                           .bytes = (uint64_t)fonts->width * fonts->height};
	void *bytes;
	stilb_result result = stilb_gpu_upload_begin(device_gpu(debug), &upload, &bytes);
	while (result == STILB_OK && !bytes) { /* other threads fill the ring, too */
		result = stilb_gpu_upload_flush(device_gpu(debug));
		if (result == STILB_OK)
			result = stilb_gpu_upload_begin(device_gpu(debug), &upload, &bytes);
	}
	if (result != STILB_OK)
		return result;
	memcpy(bytes, fonts->coverage, upload.bytes);
	stilb_gpu_upload_end(device_gpu(debug), bytes);
	return STILB_OK;
}

static stilb_result device_make_glyphs(stilb_debug *debug)
{
	stilb_gpu_image_desc desc = {.name = "debug glyphs",
	                             .extent = {.format = STILB_GPU_R8_U,
	                                        .width = debug->fonts.width,
	                                        .height = debug->fonts.height,
	                                        .depth = 1,
	                                        .layers = 1,
	                                        .mips = 1,
	                                        .samples = 1,
	                                        .uses = 1u << STILB_GPU_USE_SAMPLED | 1u << STILB_GPU_USE_COPY_TO}};
	stilb_result result = stilb_gpu_image_create(device_gpu(debug), &desc, &debug->glyphs);
	if (result == STILB_OK)
		result = device_send_glyphs(debug);
	if (result == STILB_OK)
		result = device_make_set(debug);
	if (result != STILB_OK) {
		stilb_gpu_image_destroy(device_gpu(debug), debug->glyphs);
		debug->glyphs = (stilb_gpu_image){0};
	}
	return result;
}

/* The program for a depth image of so many samples a pixel. */
static stilb_result device_program(stilb_debug *debug, uint32_t samples, stilb_gpu_program *out)
{
	bool several = samples > 1;
	stilb_gpu_program *program = &debug->programs[several];
	if (several && debug->samples != samples) {
		stilb_gpu_program_destroy(device_gpu(debug), *program);
		*program = (stilb_gpu_program){0};
		debug->samples = samples;
	}
	stilb_result result = STILB_OK;
	if (program->id == 0) {
		stilb_gpu_program_desc desc = {
			.name = "debug",
			.vertex = debug_shader_vertex,
			.fragment = debug_shader_fragment[several],
			.samplers = 1,
			.set_items = 1,
			.blend = STILB_GPU_BLEND_PREMULTIPLIED,
			.constant_count = several,
			.constants = {{0, samples}},
		};
		result = stilb_gpu_program_create(device_gpu(debug), &desc, program);
	}
	*out = *program;
	return result;
}

/* ---- the plan's row ---------------------------------------------------------------------------------------------- */

/* The frame's list of draws, which all views share. */
static stilb_result device_list(stilb_debug *debug, uint32_t *number)
{
	const debug_buffer *buffer = &debug->buffers[debug->buffer];
	uint64_t offset = STILB_RENDER_MAX_PASSES * sizeof(debug_place);
	debug->binding = (stilb_gpu_binding){.index_bytes = 2, .indices = debug->indices.id};
	debug->run = (stilb_gpu_run){.count = device_count(debug->count), .set = debug->set.id};
	stilb_gpu_draws list = {
		.draws = (const uint8_t *)stilb_gpu_buffer_mapped(device_gpu(debug), buffer->buffer) + offset,
		.commands = buffer->buffer,
		.offset = offset,
		.bindings = &debug->binding,
		.binding_count = 1,
		.runs = &debug->run,
		.run_count = 1,
	};
	return stilb_render_add_draws(debug->render, &list, number);
}

/* Adds the pass of a view. */
static stilb_result device_add_view(stilb_debug *debug, stilb_gpu_plan *plan, uint32_t number, uint16_t picture,
                                    uint32_t list)
{
	const debug_view *view = &debug->views[number];
	const debug_buffer *buffer = &debug->buffers[debug->buffer];
	uint16_t depth = stilb_gpu_plan_find(plan, view->depth);
	stilb_gpu_program program;
	const stilb_gpu_extent *extent = stilb_gpu_plan_extent(plan, picture);
	if (depth == 0 || view->place[0] + (uint32_t)view->place[2] > extent->width ||
	    view->place[1] + (uint32_t)view->place[3] > extent->height)
		return STILB_OK; /* no pass of this frame has the view, which is that of an earlier one */
	stilb_result result = device_program(debug, stilb_gpu_plan_extent(plan, depth)->samples, &program);
	if (result != STILB_OK)
		return result;
	uint64_t address = stilb_gpu_buffer_address(device_gpu(debug), buffer->buffer);
	device_push push = {
		.records = address + device_before(buffer->capacity) * sizeof(debug_record),
		.places = address,
		.origin = {(float)view->place[0], (float)view->place[1]},
		.size = {(float)view->place[2], (float)view->place[3]},
		.view = number,
		.views = debug->view_count,
	};
	memcpy(push.view_projection, view->view_projection.m, sizeof push.view_projection);
	stilb_gpu_pass pass = {
		.name = "debug drawing",
		.kind = STILB_GPU_PASS_DRAWS,
		.color = {{.image = picture, .load = STILB_GPU_LOAD_KEEP}},
		.color_count = 1,
		.uses = {{.resource = depth, .how = STILB_GPU_USE_SAMPLED}},
		.use_count = 1,
		.program = program.id,
		.draws = list,
		.constant_bytes = sizeof push,
	};
	memcpy(pass.area, view->place, sizeof pass.area);
	memcpy(pass.constants, &push, sizeof push);
	stilb_gpu_plan_pass(plan, &pass);
	return STILB_OK;
}

static stilb_result device_add(void *user, stilb_gpu_plan *plan, uint16_t *image)
{
	stilb_debug *debug = user;
	uint32_t list;
	if (!debug->ready)
		return STILB_OK; /* there is nothing to draw */
	stilb_result result = device_list(debug, &list);
	for (uint32_t v = 0; v < debug->view_count && result == STILB_OK; v++)
		result = device_add_view(debug, plan, v, *image, list);
	return result;
}

/* ---- the frame's buffer ------------------------------------------------------------------------------------------ */

/* Makes room for commands and records. */
static stilb_result device_fit(stilb_debug *debug, debug_buffer *buffer, uint32_t count)
{
	if (count <= buffer->capacity)
		return STILB_OK;
	uint32_t capacity = count + count / 2 + 1024;
	stilb_gpu_buffer_desc desc = {.name = "debug records",
	                              .bytes = (capacity + device_before(capacity)) * sizeof(debug_record),
	                              .memory = STILB_GPU_MEMORY_WRITE,
	                              .uses = STILB_GPU_BUFFER_ADDRESS | STILB_GPU_BUFFER_INDIRECT};
	stilb_gpu_buffer larger;
	stilb_result result = stilb_gpu_buffer_create(device_gpu(debug), &desc, &larger);
	if (result != STILB_OK)
		return result;
	stilb_gpu_buffer_destroy(device_gpu(debug), buffer->buffer);
	*buffer = (debug_buffer){larger, capacity};
	return STILB_OK;
}

stilb_result debug_device_begin(stilb_debug *debug, uint32_t count, debug_record **records)
{
	stilb_result result = STILB_OK;
	debug->buffer = (debug->buffer + 1) % STILB_GPU_FRAMES;
	debug_buffer *buffer = &debug->buffers[debug->buffer];
	if (debug->indices.id == 0)
		result = device_make_indices(debug);
	if (result == STILB_OK && debug->set.id == 0)
		result = device_make_set(debug);
	/* Acquire: see its declaration. */
	if (result == STILB_OK && debug->glyphs.id == 0 && atomic_load_explicit(&debug->has_fonts, memory_order_acquire))
		result = device_make_glyphs(debug);
	if (result == STILB_OK)
		result = device_fit(debug, buffer, count);
	if (result == STILB_OK && !debug->added) {
		result = stilb_render_add_feature(
			debug->render,
			&(stilb_render_feature){.stage = STILB_RENDER_STAGE_PICTURE, .add = device_add, .user = debug});
		debug->added = result == STILB_OK;
	}
	if (result == STILB_OK)
		*records = (debug_record *)stilb_gpu_buffer_mapped(device_gpu(debug), buffer->buffer) +
		           device_before(buffer->capacity);
	return result;
}

/* Writes where the views are seen. */
static void device_places(const stilb_debug *debug, debug_place *out)
{
	for (uint32_t v = 0; v < debug->view_count; v++) {
		const uint16_t *p = debug->views[v].place;
		uint32_t border = debug->views[v].border, right = p[0] + (uint32_t)p[2], bottom = p[1] + (uint32_t)p[3];
		out[v] = (debug_place){
			.place = {p[0], p[1], right, bottom},
			.inner = {p[0] + border, p[1] + border, right > border ? right - border : 0,
		              bottom > border ? bottom - border : 0},
		};
	}
}

void debug_device_end(stilb_debug *debug, uint32_t count)
{
	uint8_t *bytes = stilb_gpu_buffer_mapped(device_gpu(debug), debug->buffers[debug->buffer].buffer);
	device_command *commands = (device_command *)(bytes + STILB_RENDER_MAX_PASSES * sizeof(debug_place));
	device_places(debug, (debug_place *)bytes);
	for (uint32_t first = 0; first < count; first += DEVICE_RECORDS) {
		uint32_t some = count - first < DEVICE_RECORDS ? count - first : DEVICE_RECORDS;
		*commands++ = (device_command){
			.index_count = some * DEVICE_INDICES, .instance_count = 1, .vertex_offset = (int32_t)(4 * first)};
	}
	debug->ready = true;
}

void debug_device_finish(stilb_debug *debug)
{
	stilb_gpu *gpu = device_gpu(debug);
	if (debug->added)
		stilb_render_remove_feature(debug->render, debug);
	for (uint32_t b = 0; b < STILB_GPU_FRAMES; b++)
		stilb_gpu_buffer_destroy(gpu, debug->buffers[b].buffer);
	stilb_gpu_buffer_destroy(gpu, debug->indices);
	for (uint32_t p = 0; p < 2; p++)
		if (debug->programs[p].id)
			stilb_gpu_program_destroy(gpu, debug->programs[p]);
	if (debug->set.id)
		stilb_gpu_set_destroy(gpu, debug->set);
	stilb_gpu_image_destroy(gpu, debug->glyphs);
}
