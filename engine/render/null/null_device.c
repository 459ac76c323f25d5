/* The null device: takes everything a GPU would be given, into memory of its own, and draws nothing. What remains is the
 * CPU's side of a frame, measurable without a driver and visible to the thread sanitizer. */
#include "render/render_internal.h"

#include <stdlib.h>
#include <string.h>

#define NULL_FRAMES 2
#define NULL_FIRST_ROWS 32768u

typedef struct null_frame {
	render_row *rows;
	uint32_t row_capacity;
	render_indirect *indirect;
	uint64_t indirect_capacity;
} null_frame;

typedef struct null_device {
	render_device base;
	null_frame frames[NULL_FRAMES];
	uint32_t frame;
	uint64_t indirect_count; /* of this pass */
} null_device;

static void null_destroy(render_device *base)
{
	null_device *device = (null_device *)base;
	for (int i = 0; i < NULL_FRAMES; i++) {
		free(device->frames[i].rows);
		free(device->frames[i].indirect);
	}
	free(device);
}

static stilb_result null_upload(render_device *base, const stilb_scene *scene, const render_material *materials)
{
	(void)base, (void)scene, (void)materials;
	return STILB_OK;
}

static stilb_result null_resize(render_device *device, uint32_t width, uint32_t height)
{
	device->width = width;
	device->height = height;
	return STILB_OK;
}

static stilb_result null_rows_grow(render_device *base, render_rows *rows, uint32_t capacity)
{
	null_device *device = (null_device *)base;
	null_frame *frame = &device->frames[device->frame];
	render_row *grown = stilb_memory_alloc(capacity, sizeof *grown);
	if (!grown)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for %u draws", capacity);
	if (frame->rows)
		memcpy(grown, frame->rows, frame->row_capacity * sizeof *grown);
	free(frame->rows);
	frame->rows = grown;
	frame->row_capacity = capacity;
	rows->memory = grown;
	rows->capacity = capacity;
	return STILB_OK;
}

static stilb_result null_frame_begin(render_device *base, render_rows *rows)
{
	null_device *device = (null_device *)base;
	device->frame = (device->frame + 1) % NULL_FRAMES;
	null_frame *frame = &device->frames[device->frame];
	if (!frame->rows)
		return null_rows_grow(base, rows, NULL_FIRST_ROWS);
	rows->memory = frame->rows;
	rows->capacity = frame->row_capacity;
	return STILB_OK;
}

static stilb_result null_pass_begin(render_device *base, const stilb_render_pass *pass, const stilb_render_view *view,
                                    uint64_t draw_count)
{
	(void)pass, (void)view;
	null_device *device = (null_device *)base;
	null_frame *frame = &device->frames[device->frame];
	device->indirect_count = 0;
	if (base->replay != STILB_RENDER_REPLAY_INDIRECT || draw_count <= frame->indirect_capacity)
		return STILB_OK;
	free(frame->indirect);
	frame->indirect = stilb_memory_alloc(draw_count + draw_count / 4, sizeof *frame->indirect);
	frame->indirect_capacity = frame->indirect ? draw_count + draw_count / 4 : 0;
	return frame->indirect ? STILB_OK : stilb_fail(STILB_ERROR_MEMORY, "no memory for the frame's indirect draws");
}

static void null_draws(render_device *base, const render_command *commands, uint32_t count)
{
	null_device *device = (null_device *)base;
	if (base->replay == STILB_RENDER_REPLAY_DIRECT) {
		base->stats.draw_commands += count;
		return;
	}
	render_write_indirect(device->frames[device->frame].indirect + device->indirect_count, commands, count);
	device->indirect_count += count;
}

static void null_pass_end(render_device *base)
{
	null_device *device = (null_device *)base;
	base->stats.indirect_commands += device->indirect_count > 0;
}

static stilb_result null_nothing(render_device *base)
{
	(void)base;
	return STILB_OK;
}

static stilb_result null_read_image(render_device *base, stilb_image *image)
{
	(void)base, (void)image;
	return stilb_fail(STILB_ERROR_DEVICE, "the null device draws no picture; use --device vulkan for a screenshot");
}

stilb_result render_null_create(const stilb_render_desc *desc, render_device **out)
{
	static const render_device_functions functions = {
		.destroy = null_destroy,
		.upload = null_upload,
		.resize = null_resize,
		.frame_begin = null_frame_begin,
		.rows_grow = null_rows_grow,
		.pass_begin = null_pass_begin,
		.draws = null_draws,
		.pass_end = null_pass_end,
		.submit = null_nothing,
		.present = null_nothing,
		.wait = null_nothing,
		.read_image = null_read_image,
	};
	null_device *device = calloc(1, sizeof *device);
	if (!device)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the null device");
	device->base = (render_device){
		.functions = &functions,
		.name = "null",
		.width = desc->width,
		.height = desc->height,
		.samples = desc->samples ? desc->samples : 1,
		.replay = desc->replay,
	};
	*out = &device->base;
	return STILB_OK;
}
