/* The null device: writes everything that a GPU would be given to memory of its own, and draws nothing. So the CPU's
 * side of a frame can be measured without a driver and run under the thread sanitizer. */
#include "render/render_internal.h"

#include <stdlib.h>
#include <string.h>

/* The data of a draw in a driver's command buffer. */
typedef struct null_draw {
	uint32_t index_count, instance_count, first_index;
	int32_t vertex_offset;
	uint32_t first_instance;
} null_draw;

/* The data of an indirect draw in a driver's command buffer: offset of the first command and stride in bytes, and the
 * number of commands. */
typedef struct null_indirect {
	uint64_t offset;
	uint32_t count, stride;
} null_indirect;

typedef struct null_frame {
	void *memory[RENDER_MEMORY_KINDS];
	uint32_t capacity[RENDER_MEMORY_KINDS];
} null_frame;

/* Counters of a part of a pass that has a command buffer of its own. */
typedef struct null_list {
	_Alignas(STILB_CACHE_LINE) uint64_t draws, binds;
} null_list;

typedef struct null_device {
	render_device base;
	stilb_gpu gpu;
	null_frame frames[STILB_GPU_FRAMES];
	uint32_t frame;
	null_draw *draws; /* [draw_capacity] the draws of the last pass, one for each; unused with indirect replay */
	uint64_t draw_capacity;
	null_indirect *indirect; /* [indirect_capacity] the indirect draws of the last pass, one for each run */
	uint64_t indirect_capacity;
	null_list *lists;   /* [list_capacity] */
	render_part *parts; /* [list_capacity] */
	uint32_t list_capacity;
	void *panorama, *next_panorama; /* shown, and made */
} null_device;

static void null_destroy(render_device *base)
{
	null_device *device = (null_device *)base;
	for (uint32_t i = 0; i < STILB_GPU_FRAMES; i++)
		for (int kind = 0; kind < RENDER_MEMORY_KINDS; kind++)
			free(device->frames[i].memory[kind]);
	free(device->draws);
	free(device->indirect);
	free(device->lists);
	free(device->parts);
	free(device->panorama);
	free(device->next_panorama);
	free(device);
}

static stilb_result null_resize(render_device *device, uint32_t width, uint32_t height)
{
	device->width = width;
	device->height = height;
	return STILB_OK;
}

/* An allocation of the device, which stilb_render_faults can make fail. */
static void *null_alloc(render_device *base, uint64_t count, size_t size)
{
	return gpu_fault_allocation(base->gpu) ? NULL : stilb_memory_alloc(count, size);
}

/* ---- memory ------------------------------------------------------------------------------------------------------ */

static stilb_result null_grow(render_device *base, render_memory *memory, render_memory_kind kind, uint32_t capacity,
                              uint32_t keep)
{
	null_device *device = (null_device *)base;
	null_frame *frame = &device->frames[device->frame];
	STILB_ASSERT(kind < RENDER_MEMORY_KINDS && keep <= frame->capacity[kind] && keep <= capacity);
	void *grown = null_alloc(base, capacity, memory->element);
	if (!grown)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for %u %s; try fewer models", capacity,
		                  kind == RENDER_MEMORY_VERTICES_2D  ? "2D vertices"
		                  : kind == RENDER_MEMORY_INDICES_2D ? "2D indices"
		                  : kind == RENDER_MEMORY_LIGHTS     ? "lights"
		                                                     : "draws");
	if (keep > 0)
		memcpy(grown, frame->memory[kind], (size_t)keep * memory->element);
	free(frame->memory[kind]);
	frame->memory[kind] = memory->data = grown;
	frame->capacity[kind] = memory->capacity = capacity;
	return STILB_OK;
}

static stilb_result null_frame_begin(render_device *base, render_memory *memory)
{
	null_device *device = (null_device *)base;
	device->frame = (device->frame + 1) % STILB_GPU_FRAMES;
	null_frame *frame = &device->frames[device->frame];
	stilb_result result = STILB_OK;
	for (int kind = 0; kind < RENDER_MEMORY_KINDS && result == STILB_OK; kind++) {
		memory[kind].data = frame->memory[kind];
		memory[kind].capacity = frame->capacity[kind];
		if (!frame->memory[kind] && memory[kind].first_capacity > 0)
			result = null_grow(base, &memory[kind], (render_memory_kind)kind, memory[kind].first_capacity, 0);
	}
	return result;
}

/* Makes *array hold at least count elements; its contents are lost. False: no memory. */
static bool null_reserve(render_device *base, void **array, uint64_t *capacity, uint64_t count, size_t size)
{
	if (count <= *capacity)
		return true;
	free(*array);
	*array = null_alloc(base, count + count / 4, size);
	*capacity = *array ? count + count / 4 : 0;
	return *array;
}

static stilb_result null_no_memory(void)
{
	return stilb_fail(STILB_ERROR_MEMORY, "no memory for the commands of a pass; try fewer models");
}

static stilb_result null_rows_make(render_device *base, uint32_t capacity, render_rows **out)
{
	STILB_ASSERT(capacity > 0);
	render_rows *rows = calloc(1, sizeof *rows);
	render_row *data = rows ? null_alloc(base, capacity, sizeof *data) : NULL;
	if (!data) {
		free(rows);
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the rows of %u parts", capacity);
	}
	rows->data = data;
	rows->capacity = capacity;
	*out = rows;
	return STILB_OK;
}

static void null_rows_free(render_device *base, render_rows *rows)
{
	(void)base;
	free(rows->data);
	free(rows);
}

/* ---- resources --------------------------------------------------------------------------------------------------- */

static stilb_result null_texture_create(render_device *base, uint32_t texture, const stilb_image *image)
{
	(void)texture, (void)image;
	STILB_ASSERT(texture > 0 && texture < STILB_RENDER_MAX_TEXTURES && image->channels == 4);
	return gpu_fault_allocation(base->gpu) ? stilb_fail(STILB_ERROR_MEMORY, "no memory for a texture") : STILB_OK;
}

static void null_texture_destroy(render_device *base, uint32_t texture)
{
	(void)base, (void)texture;
}

static stilb_result null_update(render_device *base, const render_resources *resources)
{
	(void)base, (void)resources;
	STILB_ASSERT_LOCKED(&resources->lock);
	return STILB_OK;
}

static void *null_panorama_make(render_device *base, size_t bytes)
{
	null_device *device = (null_device *)base;
	free(device->next_panorama);
	device->next_panorama = null_alloc(base, 1, bytes);
	if (!device->next_panorama)
		stilb_fail(STILB_ERROR_MEMORY, "no memory for a panorama");
	return device->next_panorama;
}

static void null_panorama_show(render_device *base)
{
	null_device *device = (null_device *)base;
	free(device->panorama);
	device->panorama = device->next_panorama;
	device->next_panorama = NULL;
}

/* ---- passes ------------------------------------------------------------------------------------------------------ */

/* Writes the draws of a part to out[part.count] as a driver would, and counts the bindings they need. */
static null_list null_record(const render_device *base, const render_stream *stream, render_part part, null_draw *out)
{
	null_list list = {0};
	uint64_t state = RENDER_NO_STATE;
	for (const render_run *run = stream->runs + part.run; list.draws < part.count; run++, part.offset = 0) {
		STILB_ASSERT(run < stream->runs + stream->run_count && part.offset < run->count);
		uint64_t left = part.count - list.draws;
		uint32_t count = run->count - part.offset;
		count = count < left ? count : (uint32_t)left;
		list.binds += (uint32_t)__builtin_popcount(render_binds_between(base->materials, state, run->state));
		state = run->state;
		const render_command *command = stream->commands + run->first + part.offset;
		for (uint32_t i = 0; i < count; i++)
			memcpy(&out[list.draws + i], &command[i], sizeof *out);
		list.draws += count;
	}
	return list;
}

static stilb_result null_direct(null_device *device, const render_stream *stream)
{
	render_device *base = &device->base;
	if (!null_reserve(base, (void **)&device->draws, &device->draw_capacity, stream->draws, sizeof *device->draws))
		return null_no_memory();
	null_list list = null_record(base, stream, (render_part){.count = stream->draws}, device->draws);
	base->stats.draw_commands += list.draws;
	base->stats.binds_sent += list.binds;
	return STILB_OK;
}

typedef struct null_secondary_job {
	null_device *device;
	const render_stream *stream;
} null_secondary_job;

static void null_secondary_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	PROFILE("record secondary");
	(void)worker;
	const null_secondary_job *job = context;
	null_device *device = job->device;
	for (uint32_t p = begin; p < end; p++) {
		STILB_ASSERT(p < device->list_capacity);
		uint64_t first = 0;
		for (uint32_t before = 0; before < p; before++)
			first += device->parts[before].count;
		device->lists[p] = null_record(&device->base, job->stream, device->parts[p], device->draws + first);
	}
}

static stilb_result null_secondary(null_device *device, const render_stream *stream)
{
	render_device *base = &device->base;
	uint32_t count = stilb_job_pool_worker_count(stream->pool) + 1;
	if (count > device->list_capacity) {
		uint64_t lists = device->list_capacity, parts = lists;
		device->list_capacity = 0;
		if (!null_reserve(base, (void **)&device->lists, &lists, count, sizeof *device->lists) ||
		    !null_reserve(base, (void **)&device->parts, &parts, count, sizeof *device->parts))
			return null_no_memory();
		device->list_capacity = count;
	}
	if (!null_reserve(base, (void **)&device->draws, &device->draw_capacity, stream->draws, sizeof *device->draws))
		return null_no_memory();
	render_split(stream, count, device->parts);
	null_secondary_job job = {device, stream};
	stilb_job_parallel_for(stream->pool, count, 1, null_secondary_slice, &job, stream->worker);
	for (uint32_t p = 0; p < count; p++) {
		base->stats.draw_commands += device->lists[p].draws;
		base->stats.binds_sent += device->lists[p].binds;
	}
	base->stats.execute_commands += count;
	return STILB_OK;
}

static stilb_result null_indirect_pass(null_device *device, const render_stream *stream)
{
	render_device *base = &device->base;
	if (!null_reserve(base, (void **)&device->indirect, &device->indirect_capacity, stream->run_count,
	                  sizeof *device->indirect))
		return null_no_memory();
	uint64_t state = RENDER_NO_STATE;
	for (uint32_t r = 0; r < stream->run_count; r++) {
		const render_run *run = &stream->runs[r];
		base->stats.binds_sent +=
			(uint32_t)__builtin_popcount(render_binds_between(base->materials, state, run->state));
		state = run->state;
		device->indirect[r] =
			(null_indirect){run->first * sizeof(render_command), run->count, (uint32_t)sizeof(render_command)};
	}
	base->stats.indirect_commands += stream->run_count;
	return STILB_OK;
}

static stilb_result null_pass(render_device *base, const render_stream *stream)
{
	null_device *device = (null_device *)base;
	if (stream->draws == 0)
		return STILB_OK;
	switch (render_stream_mode(base, stream)) {
	case STILB_RENDER_REPLAY_INDIRECT:
		return null_indirect_pass(device, stream);
	case STILB_RENDER_REPLAY_DIRECT:
		return null_direct(device, stream);
	case STILB_RENDER_REPLAY_SECONDARY:
		return null_secondary(device, stream);
	}
	STILB_ASSERT(false && "a replay mode");
	return STILB_OK;
}

/* ---- the rest ---------------------------------------------------------------------------------------------------- */

static stilb_result null_submit(render_device *base)
{
	return gpu_fault_lost(base->gpu)
	           ? stilb_fail(STILB_ERROR_DEVICE_LOST, "cannot give the null device a frame: it was lost on purpose")
	           : STILB_OK;
}

static stilb_result null_nothing(render_device *base)
{
	(void)base;
	return STILB_OK;
}

static stilb_result null_set_surface(render_device *base, const stilb_gpu_surface *surface)
{
	(void)base, (void)surface;
	return STILB_OK;
}

static stilb_result null_prepare(render_device *base, const stilb_render_view *view, uint32_t light_bits)
{
	(void)base, (void)view, (void)light_bits;
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
		.resize = null_resize,
		.frame_begin = null_frame_begin,
		.grow = null_grow,
		.rows_make = null_rows_make,
		.rows_free = null_rows_free,
		.texture_create = null_texture_create,
		.texture_destroy = null_texture_destroy,
		.update = null_update,
		.panorama_make = null_panorama_make,
		.panorama_show = null_panorama_show,
		.prepare = null_prepare,
		.pass = null_pass,
		.submit = null_submit,
		.present = null_nothing,
		.set_surface = null_set_surface,
		.wait = null_nothing,
		.read_image = null_read_image,
		.read_light = null_read_image,
	};
	null_device *device = calloc(1, sizeof *device);
	if (!device)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the null device");
	device->base.functions = &functions;
	device->base.gpu = &device->gpu;
	memcpy(device->gpu.name, "null", sizeof "null");
	device->base.width = desc->width;
	device->base.height = desc->height;
	device->base.samples = desc->samples ? desc->samples : 1;
	device->base.replay = desc->replay;
	device->base.materials = desc->materials;
	device->gpu.faults = (stilb_gpu_faults){desc->faults.allocation, desc->faults.lost_frame, desc->faults.surface_lost,
	                                        desc->faults.texture_side};
	*out = &device->base;
	return STILB_OK;
}
