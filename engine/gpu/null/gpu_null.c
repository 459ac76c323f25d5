/* gpu: the null device. Its buffers are memory of the CPU, its images take places in blocks that are not there, a frame
 * runs through the plan's rows, counts what a device would be given, and draws nothing. */
#include "gpu/gpu_internal.h"

#include <stdlib.h>
#include <string.h>

typedef struct gpu_null {
	stilb_gpu base;
	gpu_memory blocks;
	uint64_t next_block;
	/* What a driver would be given of each draw of the last pass. */
	uint8_t *draws;
	uint64_t draw_capacity;
} gpu_null;

#define NULL_NO_MEMORY (-1)
#define NULL_POOL_BUFFERS 0u
#define NULL_POOL_IMAGES 1u
#define DRAW_BYTES 20u

static int32_t null_block_make(void *user, uint32_t pool, uint64_t bytes, gpu_memory_handle *handle)
{
	gpu_null *null = user;
	(void)pool, (void)bytes;
	*handle = (gpu_memory_handle){.memory = ++null->next_block};
	return 0;
}

static void null_block_drop(void *user, gpu_memory_handle handle)
{
	(void)user, (void)handle;
}

/* A place, and for buffers bytes. */
typedef struct null_thing {
	gpu_memory_place place;
	_Alignas(16) uint8_t bytes[];
} null_thing;

static null_thing *null_take(gpu_null *null, uint32_t pool, uint64_t bytes, uint64_t mapped)
{
	if (gpu_fault_allocation(&null->base))
		return NULL;
	null_thing *thing = mapped <= SIZE_MAX - sizeof *thing ? malloc(sizeof *thing + mapped) : NULL;
	if (!thing)
		return NULL;
	memset(thing->bytes, 0, mapped);
	if (gpu_memory_take(&null->blocks, pool, bytes, GPU_TLSF_UNIT, &thing->place) == 0)
		return thing;
	free(thing);
	return NULL;
}

static void null_give(gpu_null *null, null_thing *thing)
{
	if (!thing)
		return;
	gpu_memory_give(&null->blocks, &thing->place);
	free(thing);
}

static stilb_result null_buffer_make(stilb_gpu *gpu, gpu_buffer *buffer)
{
	null_thing *thing = null_take((gpu_null *)gpu, NULL_POOL_BUFFERS, buffer->bytes, buffer->bytes);
	if (!thing)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for buffer '%s' of %llu bytes", buffer->name,
		                  (unsigned long long)buffer->bytes);
	buffer->own = thing;
	buffer->mapped = buffer->memory == STILB_GPU_MEMORY_DEVICE ? NULL : thing->bytes;
	buffer->address = (uint64_t)(uintptr_t)thing->bytes;
	return STILB_OK;
}

static void null_buffer_free(stilb_gpu *gpu, gpu_buffer *buffer)
{
	null_give((gpu_null *)gpu, buffer->own);
	buffer->own = NULL;
}

static uint64_t null_image_bytes(const stilb_gpu_extent *extent)
{
	uint64_t bytes = 0;
	for (uint32_t mip = 0; mip < extent->mips; mip++)
		bytes += gpu_mip_bytes(extent, mip);
	return bytes * extent->layers * extent->samples;
}

static stilb_result null_image_make(stilb_gpu *gpu, gpu_image *image)
{
	image->own = null_take((gpu_null *)gpu, NULL_POOL_IMAGES, null_image_bytes(&image->extent), 0);
	return image->own ? STILB_OK : stilb_fail(STILB_ERROR_MEMORY, "no memory for image '%s'", image->name);
}

static void null_image_free(stilb_gpu *gpu, gpu_image *image)
{
	null_give((gpu_null *)gpu, image->own);
}

static stilb_result null_sampler_make(stilb_gpu *gpu, uint32_t index, const stilb_gpu_sampler_desc *desc)
{
	(void)gpu, (void)index, (void)desc;
	return STILB_OK;
}

static stilb_result null_set_make(stilb_gpu *gpu, gpu_set *set)
{
	(void)gpu, (void)set;
	return STILB_OK;
}

static void null_set_free(stilb_gpu *gpu, gpu_set *set)
{
	(void)gpu, (void)set;
}

static stilb_result null_program_make(stilb_gpu *gpu, gpu_program *program)
{
	(void)gpu, (void)program;
	return STILB_OK;
}

static void null_program_free(stilb_gpu *gpu, gpu_program *program)
{
	(void)gpu, (void)program;
}

static stilb_result null_program_prepare(stilb_gpu *gpu, gpu_program *program, const stilb_gpu_format *colors,
                                         uint32_t color_count, stilb_gpu_format depth, uint32_t samples)
{
	(void)gpu, (void)program, (void)colors, (void)color_count, (void)depth, (void)samples;
	return STILB_OK;
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

static stilb_result null_begin(stilb_gpu *gpu)
{
	(void)gpu;
	return STILB_OK;
}

static void null_upload(gpu_null *null, const gpu_upload_ready *ready)
{
	const gpu_buffer *target = ready->upload.buffer.id ? gpu_buffer_of(&null->base, ready->upload.buffer.id) : NULL;
	if (target)
		memcpy(((null_thing *)target->own)->bytes + ready->upload.offset,
		       (const uint8_t *)null->base.ring.buffer.mapped + ready->place, ready->upload.bytes);
}

/* Writes a list's draws as a driver would, and counts the bindings that its runs need. */
static stilb_result null_draws(gpu_null *null, const stilb_gpu_pass *pass, const stilb_gpu_draws *list)
{
	stilb_gpu_stats *stats = &null->base.stats;
	const stilb_gpu_run *last = NULL;
	uint64_t draws = 0, at = 0;
	for (uint32_t r = 0; r < list->run_count; last = &list->runs[r++]) {
		const stilb_gpu_run *run = &list->runs[r];
		uint32_t program = run->program ? run->program : pass->program;
		stats->binds += !last || program != (last->program ? last->program : pass->program);
		stats->binds += run->set && (!last || run->set != last->set);
		stats->binds += !last || run->indices != last->indices || run->vertices != last->vertices;
		draws += run->count;
	}
	if (list->replay == STILB_GPU_REPLAY_INDIRECT) {
		stats->indirect_commands += list->run_count;
		return STILB_OK;
	}
	stats->draw_commands += draws;
	if (draws > null->draw_capacity) {
		free(null->draws);
		null->draws = stilb_memory_alloc(draws + draws / 4, DRAW_BYTES);
		null->draw_capacity = null->draws ? draws + draws / 4 : 0;
		if (!null->draws)
			return stilb_fail(STILB_ERROR_MEMORY, "no memory for the commands of pass '%s'", pass->name);
	}
	for (uint32_t r = 0; r < list->run_count; r++)
		for (uint32_t d = 0; d < list->runs[r].count; d++, at++)
			memcpy(null->draws + at * DRAW_BYTES,
			       (const uint8_t *)list->draws + (uint64_t)(list->runs[r].first + d) * STILB_GPU_DRAW_STRIDE,
			       DRAW_BYTES);
	return STILB_OK;
}

static stilb_result null_run(stilb_gpu *gpu, const stilb_gpu_plan *plan, const stilb_gpu_draws *lists,
                             uint32_t list_count, const stilb_gpu_threads *threads, const gpu_upload_ready *uploads,
                             uint32_t upload_count)
{
	gpu_null *null = (gpu_null *)gpu;
	(void)list_count;
	for (uint32_t u = 0; u < upload_count; u++)
		null_upload(null, &uploads[u]);
	const stilb_gpu_step *steps;
	uint32_t count = stilb_gpu_plan_steps(plan, &steps);
	stilb_result result = STILB_OK;
	for (uint32_t s = 0; s < count && result == STILB_OK; s++) {
		const stilb_gpu_pass *pass = stilb_gpu_plan_row(plan, steps[s].pass);
		if (pass->kind != STILB_GPU_PASS_DRAWS) {
			gpu->stats.binds += pass->program != 0;
			continue;
		}
		result = null_draws(null, pass, &lists[pass->draws]);
		if (lists[pass->draws].replay == STILB_GPU_REPLAY_SECONDARY && threads)
			gpu->stats.execute_commands += threads->count > 0 ? threads->count : 1;
	}
	return result;
}

static stilb_result null_present(stilb_gpu *gpu, const stilb_gpu_plan *plan, uint16_t image)
{
	(void)gpu, (void)plan, (void)image;
	return STILB_OK;
}

/* What is read back is zeros: nothing was drawn. */
static stilb_result null_read(stilb_gpu *gpu, const stilb_gpu_plan *plan, uint16_t resource, uint8_t mip,
                              uint16_t layer, gpu_read *read)
{
	(void)mip, (void)layer;
	const stilb_gpu_placed *placed = stilb_gpu_plan_place(plan, resource);
	const gpu_buffer *owned = placed->owned ? gpu_buffer_of(gpu, placed->owned) : NULL;
	memset(read->buffer.mapped, 0, read->bytes);
	if (owned && placed->extent.format == STILB_GPU_NONE)
		memcpy(read->buffer.mapped, ((null_thing *)owned->own)->bytes, read->bytes);
	return STILB_OK;
}

static stilb_result null_read_done(stilb_gpu *gpu, const gpu_read *read, bool wait, bool *done)
{
	(void)gpu, (void)read, (void)wait;
	*done = true;
	return STILB_OK;
}

static stilb_result null_image_needs(stilb_gpu *gpu, const stilb_gpu_extent *extent, stilb_gpu_needs *needs)
{
	(void)gpu;
	*needs = (stilb_gpu_needs){null_image_bytes(extent), GPU_TLSF_UNIT, NULL_POOL_IMAGES};
	return STILB_OK;
}

static stilb_result null_buffer_needs(stilb_gpu *gpu, uint64_t bytes, stilb_gpu_needs *needs)
{
	(void)gpu;
	*needs = (stilb_gpu_needs){bytes, GPU_TLSF_UNIT, NULL_POOL_BUFFERS};
	return STILB_OK;
}

static stilb_gpu_memory_report null_measure(stilb_gpu *gpu)
{
	return gpu_memory_measure(&((gpu_null *)gpu)->blocks);
}

static void null_destroy(stilb_gpu *gpu)
{
	gpu_null *null = (gpu_null *)gpu;
	gpu_clear(gpu);
	gpu_finish(gpu);
	gpu_memory_finish(&null->blocks);
	free(null->draws);
	free(null);
}

/* Generous, but for counts that devices of today have: what passes here passes there. */
static const stilb_gpu_limits null_limits = {
	.image_side = 16384,
	.image_side_3d = 2048,
	.image_layers = 2048,
	.color_attachments = STILB_GPU_MAX_COLORS,
	.samplers_stage = 32,
	.images_stage = 128,
	.storage_images_stage = 16,
	.group_size = {1024, 1024, 64},
	.group_invocations = 1024,
	.group_count = {65535, 65535, 65535},
	.shared_bytes = 32768,
	.samples = 1 | 4,
	.buffer_bytes = (uint64_t)1 << 40,
	.anisotropy = 16.0f,
	.bc = true,
	.indirect_count = true,
};

static uint32_t null_format(const stilb_gpu_format_info *format)
{
	uint32_t any = 1u << STILB_GPU_USE_SAMPLED | 1u << STILB_GPU_USE_COPY_FROM | 1u << STILB_GPU_USE_COPY_TO;
	uint32_t storage =
		1u << STILB_GPU_USE_STORAGE_READ | 1u << STILB_GPU_USE_STORAGE_WRITE | 1u << STILB_GPU_USE_STORAGE;
	if (format->block_side > 1)
		return any | GPU_FORMAT_LINEAR;
	if (format->kind == STILB_GPU_FORMAT_DEPTH)
		return any | STILB_GPU_EXTENT_ATTACHMENT;
	return any | STILB_GPU_EXTENT_ATTACHMENT | storage | GPU_FORMAT_BLIT_FROM | GPU_FORMAT_BLIT_TO |
	       (format->kind == STILB_GPU_FORMAT_COLOR ? GPU_FORMAT_LINEAR : 0);
}

stilb_result gpu_null_create(const stilb_gpu_desc *desc, stilb_gpu **out)
{
	static const gpu_functions functions = {
		.destroy = null_destroy,
		.buffer_make = null_buffer_make,
		.buffer_free = null_buffer_free,
		.image_make = null_image_make,
		.image_free = null_image_free,
		.sampler_make = null_sampler_make,
		.set_make = null_set_make,
		.set_free = null_set_free,
		.program_make = null_program_make,
		.program_free = null_program_free,
		.program_prepare = null_program_prepare,
		.begin = null_begin,
		.run = null_run,
		.present = null_present,
		.read = null_read,
		.read_done = null_read_done,
		.wait = null_begin,
		.image_needs = null_image_needs,
		.buffer_needs = null_buffer_needs,
		.measure = null_measure,
	};
	gpu_null *null = stilb_memory_alloc(1, sizeof *null);
	if (!null)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the null device");
	memset(null, 0, sizeof *null);
	null->base.functions = &functions;
	memcpy(null->base.name, "null", sizeof "null");
	null->base.faults = desc->faults;
	null->base.limits = null_limits;
	for (uint32_t f = STILB_GPU_NONE + 1; f < STILB_GPU_FORMAT_COUNT; f++)
		null->base.formats[f] = null_format(stilb_gpu_format_describe((stilb_gpu_format)f));
	stilb_result result = STILB_OK;
	if (!gpu_memory_init(&null->blocks, (gpu_memory_source){null, null_block_make, null_block_drop, NULL_NO_MEMORY}))
		result = stilb_fail(STILB_ERROR_MEMORY, "no memory for the null device");
	else
		result = gpu_start(&null->base, desc);
	if (result == STILB_OK)
		*out = &null->base;
	else
		null_destroy(&null->base);
	return result;
}
