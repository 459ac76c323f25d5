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
	void *draws;
	uint64_t draw_bytes;
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
	uint8_t *bytes; /* or NULL */
} null_thing;

static null_thing *null_take(gpu_null *null, uint32_t pool, uint64_t bytes, uint64_t mapped)
{
	if (gpu_fault_allocation(&null->base))
		return NULL;
	null_thing *thing = calloc(1, sizeof *thing);
	if (thing && mapped > 0)
		thing->bytes = stilb_memory_alloc(1, mapped);
	if (thing && (thing->bytes || mapped == 0) &&
	    gpu_memory_take(&null->blocks, pool, bytes, GPU_TLSF_UNIT, &thing->place) == 0)
		return thing;
	if (thing)
		free(thing->bytes);
	free(thing);
	return NULL;
}

static void null_give(gpu_null *null, null_thing *thing)
{
	if (!thing)
		return;
	gpu_memory_give(&null->blocks, &thing->place);
	free(thing->bytes);
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

static stilb_result null_program_follow(stilb_gpu *gpu, const gpu_program *from, gpu_program *to)
{
	(void)gpu, (void)from, (void)to;
	return STILB_OK;
}

static stilb_result null_program_compile(stilb_gpu *gpu, gpu_program *program)
{
	(void)gpu, (void)program;
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

/* Makes null->draws hold so many elements of `size` bytes; what was there is lost. */
static stilb_result null_reserve(gpu_null *null, const stilb_gpu_pass *pass, uint64_t count, size_t size)
{
	if (count <= null->draw_bytes / size)
		return STILB_OK;
	free(null->draws);
	null->draws = gpu_fault_allocation(&null->base) ? NULL : stilb_memory_alloc(count + count / 4, size);
	null->draw_bytes = null->draws ? (count + count / 4) * size : 0;
	return null->draws ? STILB_OK
	                   : stilb_fail(STILB_ERROR_MEMORY, "no memory for the commands of pass '%s'; draw fewer models",
	                                pass->name);
}

/* A part of a list. */
typedef struct null_part {
	_Alignas(STILB_CACHE_LINE) uint64_t binds;
} null_part;

typedef struct null_work {
	const stilb_gpu_draws *list;
	uint8_t *to;
	uint64_t draws;
	uint32_t parts;
	null_part *part;
} null_work;

/* Writes draws first .. end - 1 of the list as a driver would, and counts the bindings that they need. */
static uint64_t null_write(const null_work *work, uint64_t first, uint64_t end)
{
	const stilb_gpu_draws *list = work->list;
	const stilb_gpu_run *last = NULL;
	uint64_t before = 0, binds = 0;
	uint8_t *to = work->to + first * DRAW_BYTES;
	for (uint32_t r = 0; r < list->run_count && before < end; before += list->runs[r++].count) {
		const stilb_gpu_run *run = &list->runs[r];
		uint64_t from = first > before ? first - before : 0, count = end - before;
		count = count < run->count ? count : run->count;
		if (from >= count)
			continue;
		binds += gpu_binds_count(gpu_binds_between(list, last, run));
		last = run;
		const uint8_t *draw = (const uint8_t *)list->draws + (run->first + from) * STILB_GPU_DRAW_STRIDE;
		for (; from < count; from++, draw += STILB_GPU_DRAW_STRIDE, to += DRAW_BYTES)
			memcpy(to, draw, DRAW_BYTES);
	}
	return binds;
}

static void null_task(uint32_t index, void *context)
{
	PROFILE("record secondary");
	const null_work *work = context;
	work->part[index].binds = null_write(work, gpu_draws_part(work->draws, work->parts, index),
	                                     gpu_draws_part(work->draws, work->parts, index + 1));
}

/* What a driver is given of each run: where its draws lie, how far apart, and how many they are. */
typedef struct null_indirect {
	uint64_t offset;
	uint32_t count, stride;
} null_indirect;

static stilb_result null_indirect_draws(gpu_null *null, const stilb_gpu_pass *pass, const stilb_gpu_draws *list)
{
	stilb_result result = null_reserve(null, pass, list->run_count, sizeof(null_indirect));
	if (result != STILB_OK)
		return result;
	null_indirect *to = (null_indirect *)null->draws;
	const stilb_gpu_run *last = NULL;
	for (uint32_t r = 0; r < list->run_count; last = &list->runs[r++]) {
		const stilb_gpu_run *run = &list->runs[r];
		null->base.stats.binds += gpu_binds_count(gpu_binds_between(list, last, run));
		to[r] = (null_indirect){list->offset + (uint64_t)run->first * STILB_GPU_DRAW_STRIDE, run->count,
		                        STILB_GPU_DRAW_STRIDE};
	}
	null->base.stats.indirect_commands += list->run_count;
	return STILB_OK;
}

/* A list, as a driver would write it. */
static stilb_result null_draws(gpu_null *null, const stilb_gpu_pass *pass, const stilb_gpu_draws *list,
                               const stilb_gpu_threads *threads)
{
	stilb_gpu_stats *stats = &null->base.stats;
	if (list->replay == STILB_GPU_REPLAY_INDIRECT)
		return null_indirect_draws(null, pass, list);
	null_part part[GPU_MOST_PARTS];
	bool secondary = list->replay == STILB_GPU_REPLAY_SECONDARY && list->run_count > 0;
	null_work work = {
		.list = list, .draws = gpu_draws_count(list), .parts = secondary ? gpu_draws_parts(threads) : 1, .part = part};
	if (work.draws == 0)
		return STILB_OK;
	stilb_result result = null_reserve(null, pass, work.draws, DRAW_BYTES);
	if (result != STILB_OK)
		return result;
	work.to = null->draws;
	if (work.parts > 1)
		threads->run(threads->user, work.parts, null_task, &work);
	else
		part[0].binds = null_write(&work, 0, work.draws);
	for (uint32_t p = 0; p < work.parts; p++)
		stats->binds += part[p].binds;
	stats->draw_commands += work.draws;
	stats->execute_commands += secondary ? work.parts : 0;
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
		stilb_prof_zone_begin(gpu_step_site(gpu, s, pass->name));
		if (pass->kind == STILB_GPU_PASS_DRAWS)
			result = null_draws(null, pass, &lists[pass->draws], threads);
		stilb_prof_zone_end();
	}
	return result;
}

static stilb_result null_flush(stilb_gpu *gpu, const gpu_upload_ready *uploads, uint32_t upload_count)
{
	for (uint32_t u = 0; u < upload_count; u++)
		null_upload((gpu_null *)gpu, &uploads[u]);
	return STILB_OK;
}

static stilb_result null_set_surface(stilb_gpu *gpu, const stilb_gpu_surface *surface)
{
	(void)gpu, (void)surface;
	return STILB_OK;
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
	.attachment_side = 16384,
	.image_side_3d = 2048,
	.image_layers = 2048,
	.color_attachments = STILB_GPU_MAX_COLORS,
	.samplers_stage = 32,
	.images_stage = 128,
	.storage_images_stage = 16,
	.uniforms_stage = 12,
	.uniform_bytes = 65536,
	.uniform_align = 256,
	.group_size = {1024, 1024, 64},
	.group_invocations = 1024,
	.group_count = {65535, 65535, 65535},
	.shared_bytes = 32768,
	.samples = 1 | 4,
	.buffer_bytes = (uint64_t)1 << 40,
	.anisotropy = 16.0f,
	.bc = true,
	.indirect_count = true,
	.lines = true,
	.counts = true,
	.some_colors = true,
};

static uint32_t null_format(const stilb_gpu_format_info *format)
{
	uint32_t any = 1u << STILB_GPU_USE_SAMPLED | 1u << STILB_GPU_USE_COPY_FROM | 1u << STILB_GPU_USE_COPY_TO;
	uint32_t storage =
		1u << STILB_GPU_USE_STORAGE_READ | 1u << STILB_GPU_USE_STORAGE_WRITE | 1u << STILB_GPU_USE_STORAGE;
	if (format->block_side > 1)
		return any | GPU_FORMAT_LINEAR;
	if (format == stilb_gpu_format_describe(STILB_GPU_D32_F_S8))
		return STILB_GPU_EXTENT_ATTACHMENT;
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
		.program_follow = null_program_follow,
		.program_compile = null_program_compile,
		.begin = null_begin,
		.run = null_run,
		.present = null_present,
		.read = null_read,
		.read_done = null_read_done,
		.flush = null_flush,
		.set_surface = null_set_surface,
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
	null->base.formats[STILB_GPU_RGB32_F] = 0; /* see gpu_format.h */
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
