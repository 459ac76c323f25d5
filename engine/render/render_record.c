/* Contexts: how draws become commands, on any thread. */
#include "render/render_internal.h"

#include "profiler/prof.h"

#include <stdlib.h>
#include <string.h>

/* Models in a segment: enough work (some 512 draws) to be worth a claim, and many segments per worker. */
#define RECORD_SEGMENT_MODELS 256u

/* ---- memory of a context ------------------------------------------------------------------------------------------- */

stilb_result render_contexts_create(stilb_render *render, uint32_t count)
{
	stilb_render_context *contexts = stilb_memory_alloc(count, sizeof *contexts);
	if (!contexts)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for %u render contexts", count);
	memset(contexts, 0, count * sizeof *contexts);
	for (uint32_t i = 0; i < count; i++)
		contexts[i].render = render;
	render_contexts_destroy(render);
	render->contexts = contexts;
	render->context_count = count;
	return STILB_OK;
}

void render_contexts_destroy(stilb_render *render)
{
	for (uint32_t i = 0; i < render->context_count; i++) {
		stilb_render_context *context = &render->contexts[i];
		for (uint32_t b = 0; b < context->block_count; b++)
			free(context->blocks[b]);
		for (uint32_t o = 0; o < context->overflow_count; o++)
			free(context->overflows[o].rows);
		free(context->blocks);
		free(context->overflows);
	}
	free(render->contexts);
	render->contexts = NULL;
	render->context_count = 0;
}

void render_contexts_rewind(stilb_render *render)
{
	for (uint32_t i = 0; i < render->context_count; i++) {
		stilb_render_context *context = &render->contexts[i];
		STILB_ASSERT(!context->segment);
		context->block = 0;
		context->command = context->block_count ? context->blocks[0]->commands : NULL;
		context->block_end = context->block_count ? context->command + RENDER_BLOCK_COMMANDS : NULL;
		context->row = context->row_end = NULL; /* the rows of the frame before are the device's now */
		for (uint32_t o = 0; o < context->overflow_count; o++)
			free(context->overflows[o].rows);
		context->overflow_count = 0;
		context->failed = false;
	}
	atomic_store_explicit(&render->rows.next, 0, memory_order_relaxed); /* published by the submit of the first job */
	render_passes_rewind(render);
}

void render_passes_rewind(stilb_render *render)
{
	for (uint32_t p = 0; p < STILB_RENDER_MAX_PASSES; p++)
		render->passes[p].state = RENDER_LIST_EMPTY;
	render->replayed_count = 0;
}

/* Room for one more element of an array that doubles. */
static bool record_reserve(void **array, uint32_t *capacity, uint32_t count, size_t size)
{
	if (count < *capacity)
		return true;
	uint32_t larger = *capacity ? *capacity * 2 : 16;
	void *grown = realloc(*array, larger * size);
	if (!grown)
		return false;
	*array = grown;
	*capacity = larger;
	return true;
}

/* The next block of commands, made when there is none yet. */
static bool record_next_block(stilb_render_context *context)
{
	uint32_t next = context->command ? context->block + 1 : 0;
	if (next == context->block_count) {
		if (!record_reserve((void **)&context->blocks, &context->block_capacity, next, sizeof *context->blocks))
			return false;
		render_block *block = stilb_memory_alloc(1, sizeof *block);
		if (!block)
			return false;
		context->blocks[context->block_count++] = block;
	}
	context->block = next;
	context->command = context->blocks[next]->commands;
	context->block_end = context->command + RENDER_BLOCK_COMMANDS;
	return true;
}

/* A chunk of rows on the heap. */
static render_row *record_overflow(stilb_render_context *context, uint32_t first)
{
	if (!record_reserve((void **)&context->overflows, &context->overflow_capacity, context->overflow_count,
	                    sizeof *context->overflows))
		return NULL;
	render_row *chunk = stilb_memory_alloc(RENDER_ROW_CHUNK, sizeof *chunk);
	if (chunk)
		context->overflows[context->overflow_count++] = (render_overflow){chunk, first};
	return chunk;
}

/* The next chunk of rows: in the device's memory, or on the heap when the frame outgrows it. Without memory row and row_end
 * stay equal, so that the next draw comes here, too. */
static bool record_next_rows(stilb_render_context *context)
{
	render_rows *rows = &context->render->rows;
	if (context->failed)
		return false; /* claims no more: the counter would wrap before a large scene is through */
	uint32_t first = atomic_fetch_add_explicit(&rows->next, RENDER_ROW_CHUNK, memory_order_relaxed);
	bool fits = first + RENDER_ROW_CHUNK <= rows->capacity;
	render_row *chunk = fits ? rows->memory + first : record_overflow(context, first);
	if (!chunk)
		return false;
	context->row = chunk;
	context->row_end = chunk + RENDER_ROW_CHUNK;
	context->row_index = first;
	return true;
}

stilb_result render_rows_place(stilb_render *render)
{
	/* Relaxed: the job system's wait has ordered all claims before this. */
	uint32_t claimed = atomic_load_explicit(&render->rows.next, memory_order_relaxed);
	if (claimed > render->rows.capacity) {
		uint64_t wanted = (uint64_t)claimed + claimed / 4;
		uint32_t capacity = wanted < UINT32_MAX ? (uint32_t)wanted : UINT32_MAX;
		stilb_result result = render->device->functions->rows_grow(render->device, &render->rows, capacity);
		if (result != STILB_OK)
			return result;
	}
	for (uint32_t i = 0; i < render->context_count; i++) {
		const stilb_render_context *context = &render->contexts[i];
		for (uint32_t o = 0; o < context->overflow_count; o++)
			memcpy(render->rows.memory + context->overflows[o].first, context->overflows[o].rows,
			       RENDER_ROW_CHUNK * sizeof(render_row));
	}
	return STILB_OK;
}

/* ---- recording by hand --------------------------------------------------------------------------------------------- */

stilb_render_context *stilb_render_context_get(stilb_render *render, uint32_t worker)
{
	STILB_ASSERT(worker < render->context_count);
	return &render->contexts[worker];
}

stilb_result stilb_render_pass_begin(stilb_render *render, uint32_t pass, uint32_t segment_count)
{
	STILB_ASSERT(pass < STILB_RENDER_MAX_PASSES);
	render_pass_lists *lists = &render->passes[pass];
	STILB_ASSERT(lists->state == RENDER_LIST_EMPTY);
	if (segment_count > lists->segment_capacity) {
		render_segment *grown = realloc(lists->segments, segment_count * sizeof *grown);
		if (!grown)
			return stilb_fail(STILB_ERROR_MEMORY, "no memory for %u segments", segment_count);
		lists->segments = grown;
		lists->segment_capacity = segment_count;
	}
	lists->segment_count = segment_count;
	for (uint32_t s = 0; s < segment_count; s++)
		lists->segments[s] = (render_segment){0};
	lists->state = RENDER_LIST_RECORDING;
	return STILB_OK;
}

void stilb_render_segment_begin(stilb_render_context *context, uint32_t pass, uint32_t segment)
{
	render_pass_lists *lists = &context->render->passes[pass];
	STILB_ASSERT(lists->state == RENDER_LIST_RECORDING && segment < lists->segment_count);
	STILB_ASSERT(!context->segment && !lists->segments[segment].context);
	context->segment = &lists->segments[segment];
	*context->segment = (render_segment){
		.context = context,
		.block = context->block,
		.first = context->command ? (uint32_t)(context->command - context->blocks[context->block]->commands) : 0,
	};
}

void stilb_render_segment_end(stilb_render_context *context)
{
	render_segment *segment = context->segment;
	STILB_ASSERT(segment);
	if (context->command) {
		uint64_t position = (uint64_t)(context->command - context->blocks[context->block]->commands) +
		                    (uint64_t)context->block * RENDER_BLOCK_COMMANDS;
		segment->count = (uint32_t)(position - segment->first - (uint64_t)segment->block * RENDER_BLOCK_COMMANDS);
	}
	context->segment = NULL;
}

/* The matrix's upper three rows, one after the other. */
static inline void record_write_row(render_row *row, const stilb_mat4 *transform, uint32_t material)
{
	const float *m = transform->m;
	STILB_ASSERT(m[3] == 0.0f && m[7] == 0.0f && m[11] == 0.0f && m[15] == 1.0f);
	for (int r = 0; r < 3; r++)
		for (int c = 0; c < 4; c++)
			row->transform[4 * r + c] = m[4 * c + r];
	row->material = material;
	row->unused[0] = row->unused[1] = row->unused[2] = 0;
}

static inline void record_draw(stilb_render_context *context, uint32_t mesh, uint32_t material,
                               const stilb_mat4 *transform)
{
	const stilb_render *render = context->render;
	STILB_ASSERT(context->segment && mesh < render->mesh_count && material < render->material_count);
	if (context->command == context->block_end && !record_next_block(context))
		goto no_memory;
	if (context->row == context->row_end && !record_next_rows(context))
		goto no_memory;
	record_write_row(context->row++, transform, material);
	*context->command++ = (render_command){
		.row = context->row_index++,
		.mesh = mesh,
		.material = material,
		.index_count = render->meshes[mesh].index_count,
		.first_index = render->meshes[mesh].first_index,
		.vertex_offset = render->meshes[mesh].vertex_offset,
	};
	return;
no_memory:
	context->failed = true;
}

void stilb_render_draw(stilb_render_context *context, uint32_t mesh, uint32_t material, const stilb_mat4 *transform)
{
	record_draw(context, mesh, material, transform);
}

stilb_result stilb_render_pass_end(stilb_render *render, uint32_t pass)
{
	render_pass_lists *lists = &render->passes[pass];
	STILB_ASSERT(lists->state == RENDER_LIST_RECORDING);
	lists->state = RENDER_LIST_CLOSED;
	for (uint32_t i = 0; i < render->context_count; i++)
		if (render->contexts[i].failed)
			return stilb_fail(STILB_ERROR_MEMORY, "no memory for the frame's draws; try fewer models");
	return STILB_OK;
}

/* ---- recording a scene ---------------------------------------------------------------------------------------------- */

/* A pass that is being recorded: what the slices of its loop share. */
typedef struct record_pass {
	stilb_render *render;
	const stilb_scene *scene;
	const uint32_t *visible;
	uint32_t visible_count;
	uint32_t pass;
} record_pass;

static void record_segment(const record_pass *recorded, stilb_render_context *context, uint32_t segment)
{
	PROFILE("record segment");
	const stilb_scene *scene = recorded->scene;
	uint32_t first = segment * RECORD_SEGMENT_MODELS, end = first + RECORD_SEGMENT_MODELS;
	end = end < recorded->visible_count ? end : recorded->visible_count;
	stilb_render_segment_begin(context, recorded->pass, segment);
	for (uint32_t i = first; i < end; i++) {
		uint32_t model = recorded->visible[i];
		for (uint32_t p = scene->first_part[model]; p < scene->first_part[model + 1]; p++)
			record_draw(context, scene->part_mesh[p], scene->part_material[p], &scene->part_transform[p]);
	}
	stilb_render_segment_end(context);
}

static void record_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const record_pass *recorded = context;
	for (uint32_t segment = begin; segment < end; segment++)
		record_segment(recorded, &recorded->render->contexts[worker], segment);
}

stilb_result stilb_render_record(stilb_render *render, uint32_t pass, const stilb_scene *scene, const uint32_t *visible,
                                 uint32_t visible_count, stilb_job_pool *pool, uint32_t worker)
{
	uint32_t segments = (visible_count + RECORD_SEGMENT_MODELS - 1) / RECORD_SEGMENT_MODELS;
	stilb_result result = stilb_render_pass_begin(render, pass, segments);
	if (result != STILB_OK)
		return result;
	record_pass recorded = {render, scene, visible, visible_count, pass};
	stilb_job_parallel_for(pool, segments, 1, record_slice, &recorded, worker);
	return stilb_render_pass_end(render, pass);
}
