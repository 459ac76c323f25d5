/* Contexts: how the draws that a worker records become commands in the frame's memory; those by hand also rows (the
 * transform, the material), while those of a scene name rows that are kept (render_rows.h). On any thread. */
#include "render/render_clusters.h"
#include "render/render_detail.h"
#include "render/render_internal.h"
#include "shading/shade_tonemap.h"

#include <stdlib.h>
#include <string.h>

/* Models in a segment, one step of the parallel loop that records a scene. That is about 512 draws: far more work than
 * taking a step costs, and yet few enough that every worker gets many. */
#define RECORD_SEGMENT_MODELS 256u

/* ---- memory of a context ----------------------------------------------------------------------------------------- */

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

static void context_drop_overflows(stilb_render_context *context)
{
	for (uint32_t o = 0; o < context->overflow_count; o++)
		free(context->overflows[o].data);
	context->overflow_count = 0;
}

void render_contexts_destroy(stilb_render *render)
{
	for (uint32_t i = 0; i < render->context_count; i++) {
		context_drop_overflows(&render->contexts[i]);
		free(render->contexts[i].runs);
		free(render->contexts[i].overflows);
		render_cluster_cut_finish(&render->contexts[i].cut);
	}
	free(render->contexts);
	render->contexts = NULL;
	render->context_count = 0;
}

void render_contexts_rewind(stilb_render *render)
{
	/* The number of rows of the last frame. Relaxed: no thread claims memory now, so it does not change. */
	uint32_t rows = atomic_load_explicit(&render->memory[RENDER_MEMORY_ROWS].next, memory_order_relaxed);
	for (uint32_t i = 0; i < render->context_count; i++) {
		stilb_render_context *context = &render->contexts[i];
		STILB_ASSERT(!context->segment && "every segment has ended");
		context_drop_overflows(context);
		/* The last frame's chunks belong to the device now. */
		context->command = context->command_end = NULL;
		context->row = context->row_end = NULL;
		context->run_count = 0;
		context->failed = false;
		context->material_mask = render_material_mask(render->device->materials);
		context->stream_rows = rows > RENDER_CACHED_ROWS;
		context->meshes = render->resources.meshes;
		context->materials = render->resources.materials;
		context->levels = render->resources.levels;
	}
	/* Relaxed: workers see it, because jobs are submitted after it and that orders it. */
	for (int kind = 0; kind < RENDER_MEMORY_KINDS; kind++)
		atomic_store_explicit(&render->memory[kind].next, 0, memory_order_relaxed);
	render->shown_rows = NULL;
	render_passes_rewind(render);
}

void render_passes_rewind(stilb_render *render)
{
	for (uint32_t p = 0; p < STILB_RENDER_MAX_PASSES; p++) {
		render->passes[p].state = RENDER_LIST_EMPTY;
		render->passes[p].segment_count = render->passes[p].run_count = 0;
		render->passes[p].combined.model_count = 0;
	}
	render->replayed_count = 0;
}

/* Memory on the heap for a claim that lies beyond the frame's memory; NULL: no memory. */
static void *record_overflow(stilb_render_context *context, render_memory_kind kind, uint32_t first, uint32_t count)
{
	const render_memory *memory = &context->render->memory[kind];
	if (!render_reserve((void **)&context->overflows, &context->overflow_capacity, context->overflow_count + 1,
	                    sizeof *context->overflows))
		return NULL;
	void *data = stilb_memory_alloc(count, memory->element);
	if (data)
		context->overflows[context->overflow_count++] = (render_overflow){kind, first, count, data};
	return data;
}

/* Claims count elements of the frame's memory; *first is their position in it. Returns where to write them: in place,
 * or on the heap if they lie beyond the capacity. NULL: no memory. */
static void *record_claim(stilb_render_context *context, render_memory_kind kind, uint32_t count, uint32_t *first)
{
	STILB_ASSERT(count > 0);
	render_memory *memory = &context->render->memory[kind];
	/* Relaxed: all that matters is that no two claims overlap. A claim makes no data visible to other threads; what is
	 * written to it is published when the jobs are waited for. */
	*first = atomic_fetch_add_explicit(&memory->next, count, memory_order_relaxed);
	if (*first > UINT32_MAX - count)
		return NULL; /* the counter wraps: the frame fails, so it does not matter that later claims overlap */
	if (*first + count <= memory->capacity)
		return (uint8_t *)memory->data + (size_t)*first * memory->element;
	return record_overflow(context, kind, *first, count);
}

void *render_claim(stilb_render *render, render_memory_kind kind, uint32_t count, uint32_t *first)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(!render->contexts[0].segment && "no worker records any more");
	return record_claim(&render->contexts[0], kind, count, first);
}

static bool record_next_commands(stilb_render_context *context)
{
	uint32_t first;
	render_command *chunk = record_claim(context, RENDER_MEMORY_COMMANDS, RENDER_COMMAND_CHUNK, &first);
	if (!chunk)
		return false;
	context->command = chunk;
	context->command_end = chunk + RENDER_COMMAND_CHUNK;
	context->command_chunk = first;
	return true;
}

static bool record_next_rows(stilb_render_context *context)
{
	render_row *chunk = record_claim(context, RENDER_MEMORY_ROWS, RENDER_ROW_CHUNK, &context->row_index);
	if (!chunk || context->row_index > RENDER_MAX_ROWS - RENDER_ROW_CHUNK)
		return false;
	context->row = chunk;
	context->row_end = chunk + RENDER_ROW_CHUNK;
	return true;
}

stilb_result render_memory_place(stilb_render *render)
{
	PROFILE("place");
	for (int kind = 0; kind < RENDER_MEMORY_KINDS; kind++) {
		render_memory *memory = &render->memory[kind];
		/* Relaxed: the job system's wait orders all claims before this. */
		uint32_t claimed = atomic_load_explicit(&memory->next, memory_order_relaxed);
		if (claimed <= memory->capacity)
			continue;
		uint64_t wanted = (uint64_t)claimed + claimed / 4;
		uint32_t capacity = wanted < UINT32_MAX ? (uint32_t)wanted : UINT32_MAX;
		stilb_result result = render_device_grow(render->device, memory, (uint32_t)kind, capacity, memory->capacity);
		if (result != STILB_OK)
			return result;
	}
	for (uint32_t i = 0; i < render->context_count; i++) {
		stilb_render_context *context = &render->contexts[i];
		for (uint32_t o = 0; o < context->overflow_count; o++) {
			const render_overflow *overflow = &context->overflows[o];
			const render_memory *memory = &render->memory[overflow->kind];
			memcpy((uint8_t *)memory->data + (size_t)overflow->first * memory->element, overflow->data,
			       (size_t)overflow->count * memory->element);
		}
		context_drop_overflows(context);
	}
	return STILB_OK;
}

/* ---- runs -------------------------------------------------------------------------------------------------------- */

/* Position of the next command among the frame's commands. */
static uint32_t record_command_index(const stilb_render_context *context)
{
	STILB_ASSERT(context->command && context->command <= context->command_end);
	return context->command_chunk + RENDER_COMMAND_CHUNK - (uint32_t)(context->command_end - context->command);
}

/* Ends the run (consecutive draws with the same bindings) that is being recorded, if there is one: the next command is
 * not part of it. */
static void record_end_run(stilb_render_context *context)
{
	if (context->state == RENDER_NO_STATE)
		return;
	STILB_ASSERT(context->run_count > context->first_run);
	render_run *run = &context->runs[context->run_count - 1];
	run->count = record_command_index(context) - run->first;
	STILB_ASSERT(run->count > 0 && run->count <= RENDER_COMMAND_CHUNK && "a run lies in one chunk");
	context->state = RENDER_NO_STATE;
}

/* False: no memory. */
static bool record_begin_run(stilb_render_context *context, uint64_t state)
{
	STILB_ASSERT(context->state == RENDER_NO_STATE && state != RENDER_NO_STATE);
	if (!render_reserve((void **)&context->runs, &context->run_capacity, context->run_count + 1, sizeof *context->runs))
		return false;
	context->runs[context->run_count++] = (render_run){record_command_index(context), 0, state};
	context->state = state;
	return true;
}

/* Claims new chunks for the next draw and begins a new run, as far as it needs them. row: it writes a row. False: no
 * memory, now or before. */
static bool record_make_room(stilb_render_context *context, uint64_t state, bool row)
{
	if (context->failed)
		return false;       /* each draw would claim again, until the 32-bit counters wrap */
	context->failed = true; /* unless the end of this function is reached */
	if (row && context->row == context->row_end && !record_next_rows(context))
		return false;
	if (context->command == context->command_end) {
		record_end_run(context);
		if (!record_next_commands(context))
			return false;
	}
	if (state != context->state) {
		record_end_run(context);
		if (!record_begin_run(context, state))
			return false;
	}
	context->failed = false;
	return true;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

#if defined(__SSE2__) && !defined(__SANITIZE_THREAD__)
#include <emmintrin.h>

/* The command is built in vector registers: a wide load of a struct that was just stored member by member cannot be
 * forwarded from the store buffer and stalls. */
static inline void record_write_command(render_command *out, const render_level *level, uint32_t row, uint32_t material,
                                        uint64_t key)
{
	__m128i draw = _mm_load_si128((const __m128i *)level);
	__m128i rest = _mm_set_epi32((int32_t)(key >> 32), (int32_t)key, (int32_t)material, (int32_t)row);
	_mm_store_si128((__m128i *)out, draw);
	_mm_store_si128((__m128i *)out + 1, rest);
}

#else
static inline void record_write_command(render_command *out, const render_level *level, uint32_t row, uint32_t material,
                                        uint64_t key)
{
	*out = (render_command){
		.index_count = level->index_count,
		.instance_count = 1,
		.first_index = level->first_index,
		.vertex_offset = level->vertex_offset,
		.row = row,
		.material = material,
		.key = key,
	};
}
#endif

/* ---- recording by hand ------------------------------------------------------------------------------------------- */

stilb_render_context *stilb_render_context_get(stilb_render *render, uint32_t worker)
{
	STILB_ASSERT(worker < render->context_count);
	return &render->contexts[worker];
}

stilb_result stilb_render_pass_begin(stilb_render *render, uint32_t pass, uint32_t segment_count)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(pass < STILB_RENDER_MAX_PASSES && render->state == RENDER_FRAME_BEGUN);
	render_pass_lists *lists = &render->passes[pass];
	STILB_ASSERT(lists->state == RENDER_LIST_EMPTY && "a pass is recorded once a frame");
	if (!render_reserve((void **)&lists->segments, &lists->segment_capacity, segment_count, sizeof *lists->segments))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for %u segments", segment_count);
	lists->segment_count = segment_count;
	lists->detail = STILB_RENDER_DETAIL_OFF;
	for (uint32_t s = 0; s < segment_count; s++)
		lists->segments[s] = (render_segment){0};
	lists->state = RENDER_LIST_RECORDING;
	return STILB_OK;
}

void stilb_render_segment_begin(stilb_render_context *context, uint32_t pass, uint32_t segment)
{
	STILB_ASSERT(pass < STILB_RENDER_MAX_PASSES && !context->segment);
	render_pass_lists *lists = &context->render->passes[pass];
	STILB_ASSERT(lists->state == RENDER_LIST_RECORDING && segment < lists->segment_count);
	STILB_ASSERT(!lists->segments[segment].context && "a segment is recorded once");
	stilb_owner_take(&context->writer);
	context->segment = &lists->segments[segment];
	context->first_run = context->run_count;
	context->state = RENDER_NO_STATE;
}

void stilb_render_segment_end(stilb_render_context *context)
{
	STILB_ASSERT_OWNER(context->writer);
	STILB_ASSERT(context->segment);
	record_end_run(context);
	render_row_drain();
	/* One store of the whole entry at the end: other workers write the neighbouring entries, in the same cache line. */
	*context->segment = (render_segment){context, context->first_run, context->run_count - context->first_run};
	context->segment = NULL;
}

/* What a draw is made of. */
typedef struct record_what {
	const render_level *level;
	uint32_t mesh, material; /* indices */
	uint32_t detail;         /* the high bits of the command's row word, in place */
	uint64_t key;
	uint64_t state; /* the bits RENDER_STATE_MESH of its level */
} record_what;

static inline void record_write(stilb_render_context *context, record_what what, uint32_t row)
{
	record_write_command(context->command++, what.level, row | what.detail, what.material, what.key);
}

/* The same with a row of the frame. */
static inline void record_write_by_hand(stilb_render_context *context, record_what what, const stilb_mat4 *transform)
{
	render_row_write(context->row++, transform, what.material, what.mesh, 0, 0, context->stream_rows);
	record_write(context, what, context->row_index++ | RENDER_ROW_FRAME);
}

static_assert(STILB_RENDER_MAX_MESHES <= RENDER_MAX_ROWS, "a mesh's index and the detail share a word");

/* Record a draw that needs a new chunk or a new run. Not inlined, and called as a tail call with all of its arguments
 * in registers: callers then save none in the common case, a draw that needs neither. mesh_material: the mesh's index
 * with the detail above it, and in the high half the material's. */
__attribute__((noinline)) static void record_hand_making_room(stilb_render_context *context, uint64_t key,
                                                              const render_level *level, uint64_t mesh_material,
                                                              const stilb_mat4 *transform, uint64_t state)
{
	record_what what = {.level = level,
	                    .mesh = (uint32_t)mesh_material & (RENDER_MAX_ROWS - 1),
	                    .material = (uint32_t)(mesh_material >> 32),
	                    .detail = (uint32_t)mesh_material & ~(RENDER_MAX_ROWS - 1),
	                    .key = key};
	if (record_make_room(context, state, true))
		record_write_by_hand(context, what, transform);
}

/* word: of the row, with the detail. */
__attribute__((noinline)) static void record_making_room(stilb_render_context *context, uint64_t key,
                                                         const render_level *level, uint32_t word, uint32_t material,
                                                         uint64_t state)
{
	if (record_make_room(context, state, false))
		record_write(context, (record_what){.level = level, .material = material, .key = key}, word);
}

/* A draw of the mesh in full; asserts that mesh and material may be drawn. */
static inline record_what record_full(const stilb_render_context *context, stilb_render_mesh mesh,
                                      stilb_render_material material)
{
	const render_mesh_slot *slot = &context->meshes[mesh.id & RENDER_INDEX_MASK];
	uint32_t entry = context->materials[material.id & RENDER_INDEX_MASK];
	STILB_ASSERT_OWNER(context->writer);
	STILB_ASSERT(context->segment && (mesh.id & RENDER_INDEX_MASK) < STILB_RENDER_MAX_MESHES);
	STILB_ASSERT(slot->generation && slot->generation == mesh.id >> RENDER_GENERATION_SHIFT && "a mesh that exists");
	STILB_ASSERT(entry >> RENDER_GENERATION_SHIFT && "a material that exists");
	STILB_ASSERT(entry >> RENDER_GENERATION_SHIFT == material.id >> RENDER_GENERATION_SHIFT &&
	             "a material that exists");
	(void)entry;
	return (record_what){.level = (const render_level *)slot,
	                     .mesh = mesh.id & RENDER_INDEX_MASK,
	                     .material = material.id & RENDER_INDEX_MASK,
	                     .state = render_state_of_mesh(slot)};
}

/* kind: the RENDER_STATE_... of its detail. */
static inline uint64_t record_state(const stilb_render_context *context, const record_what *what, uint64_t kind)
{
	return render_state(context->materials[what->material], what->material, context->material_mask) | kind |
	       what->state;
}

/* row: its word. */
static inline void record_put(stilb_render_context *context, record_what what, uint32_t row, uint64_t kind)
{
	uint64_t state = record_state(context, &what, kind);
	if (context->command == context->command_end || state != context->state)
		record_making_room(context, what.key, what.level, row | what.detail, what.material, state);
	else
		record_write(context, what, row);
}

/* The same with a row of the frame. */
static inline void record_put_by_hand(stilb_render_context *context, record_what what, const stilb_mat4 *transform,
                                      uint64_t kind)
{
	STILB_ASSERT(transform->m[3] == 0.0f && transform->m[7] == 0.0f && transform->m[11] == 0.0f);
	STILB_ASSERT(transform->m[15] == 1.0f && "the transform is affine");
	uint64_t state = record_state(context, &what, kind);
	if (context->command == context->command_end || context->row == context->row_end || state != context->state)
		record_hand_making_room(context, what.key, what.level, what.mesh | what.detail | (uint64_t)what.material << 32,
		                        transform, state);
	else
		record_write_by_hand(context, what, transform);
}

static inline void record_draw(stilb_render_context *context, uint64_t key, stilb_render_mesh mesh,
                               stilb_render_material material, const stilb_mat4 *transform)
{
	record_what what = record_full(context, mesh, material);
	what.key = key;
	record_put_by_hand(context, what, transform, 0);
}

void stilb_render_draw(stilb_render_context *context, stilb_render_mesh mesh, stilb_render_material material,
                       const stilb_mat4 *transform)
{
	record_draw(context, 0, mesh, material, transform);
}

void stilb_render_draw_with_key(stilb_render_context *context, uint64_t key, stilb_render_mesh mesh,
                                stilb_render_material material, const stilb_mat4 *transform)
{
	record_draw(context, key, mesh, material, transform);
}

void render_draw_level(stilb_render_context *context, uint64_t key, stilb_render_mesh mesh,
                       stilb_render_material material, const stilb_mat4 *transform, uint32_t level, uint32_t detail,
                       uint32_t kind)
{
	record_what what = record_full(context, mesh, material);
	what.detail = detail << RENDER_DETAIL_SHIFT;
	what.key = key;
	const render_levels *levels = context->levels[what.mesh];
	STILB_ASSERT(level == 0 || (levels && level <= levels->count));
	bool moves = kind == render_state_detail(RENDER_STATE_MORPH) && detail > 0;
	STILB_ASSERT(!moves || (levels && levels->morphs && level < levels->count));
	if (levels) {
		what.level = &render_levels_level(levels)[moves ? levels->count + 1 + level : level];
		what.state = (what.state & RENDER_STATE_EXTRAS) | render_state_of_level(levels, level);
	}
	record_put_by_hand(context, what, transform, render_state_of_detail(kind));
}

void render_draw_clusters(stilb_render_context *context, uint64_t key, stilb_render_mesh mesh,
                          stilb_render_material material, const stilb_mat4 *transform, render_cluster_range range,
                          uint32_t detail, uint32_t kind)
{
	record_what what = record_full(context, mesh, material);
	const render_levels *levels = context->levels[what.mesh];
	STILB_ASSERT(render_levels_have_clusters(levels) && range.index_count > 0);
	render_level level = *what.level;
	uint32_t skipped = range.first_index < level.index_count ? 0 : levels->clusters->coarser - level.index_count;
	STILB_ASSERT((uint64_t)range.first_index + skipped + range.index_count <= levels->indices[0].count);
	level.first_index += range.first_index + skipped;
	level.index_count = range.index_count;
	what.level = &level;
	what.detail = detail << RENDER_DETAIL_SHIFT;
	what.key = key;
	record_put_by_hand(context, what, transform, render_state_of_detail(kind));
}

uint32_t stilb_render_geometry_2d(stilb_render_context *context, const stilb_render_vertex_2d *vertices,
                                  uint32_t vertex_count, const uint32_t *indices, uint32_t index_count)
{
	STILB_ASSERT_OWNER(context->writer);
	STILB_ASSERT(context->segment && (vertices || vertex_count == 0) && (indices || index_count == 0));
	if (context->failed || vertex_count == 0 || index_count == 0)
		return 0;
	uint32_t first_vertex, first_index = 0, most = 0;
	stilb_render_vertex_2d *to = record_claim(context, RENDER_MEMORY_VERTICES_2D, vertex_count, &first_vertex);
	uint32_t *out = to ? record_claim(context, RENDER_MEMORY_INDICES_2D, index_count, &first_index) : NULL;
	context->failed = !out;
	if (!out)
		return 0;
	memcpy(to, vertices, (size_t)vertex_count * sizeof *to);
	for (uint32_t i = 0; i < index_count; i++) {
		most = indices[i] > most ? indices[i] : most;
		out[i] = first_vertex + indices[i];
	}
	STILB_ASSERT(most < vertex_count);
	return first_index;
}

/* kind: further bits of the draw's state. factor: the second column of its row. */
static void record_draw_2d(stilb_render_context *context, uint32_t first_index, uint32_t index_count,
                           const float clip[4], stilb_render_texture texture, uint64_t kind, const float shown[2])
{
	uint32_t index = texture.id & RENDER_INDEX_MASK;
	STILB_ASSERT_OWNER(context->writer);
	STILB_ASSERT(context->segment && index < STILB_RENDER_MAX_TEXTURES);
	STILB_ASSERT(!texture.id == !index && "a handle or {0}");
	STILB_ASSERT(context->render->resources.textures[index] == texture.id >> RENDER_GENERATION_SHIFT);
	uint64_t state = RENDER_STATE_2D | kind | index;
	bool room = context->command != context->command_end && context->row != context->row_end;
	if (context->failed || ((!room || state != context->state) && !record_make_room(context, state, true)))
		return;
	*context->row++ = (render_row){.transform = {clip[0], clip[1], clip[2], clip[3], shown[0], shown[1]}};
	*context->command++ = (render_command){.index_count = index_count,
	                                       .instance_count = 1,
	                                       .first_index = first_index,
	                                       .row = context->row_index++ | RENDER_ROW_FRAME};
}

void stilb_render_draw_2d(stilb_render_context *context, uint32_t first_index, uint32_t index_count,
                          const float clip[4], stilb_render_texture texture)
{
	record_draw_2d(context, first_index, index_count, clip, texture, 0, (const float[2]){0.0f, 0.0f});
}

void stilb_render_draw_picture(stilb_render_context *context, const float place[4], const float clip[4],
                               stilb_render_texture texture, float factor, uint32_t tone)
{
	STILB_ASSERT(texture.id != 0 && place[2] > place[0] && place[3] > place[1]);
	STILB_ASSERT(factor >= 0.0f && tone < SHADE_TONE_COUNT);
	static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
	const stilb_render_vertex_2d corners[4] = {
		{.position = {place[0], place[1]}, .uv = {0.0f, 0.0f}, .color = {255, 255, 255, 255}},
		{.position = {place[2], place[1]}, .uv = {1.0f, 0.0f}, .color = {255, 255, 255, 255}},
		{.position = {place[2], place[3]}, .uv = {1.0f, 1.0f}, .color = {255, 255, 255, 255}},
		{.position = {place[0], place[3]}, .uv = {0.0f, 1.0f}, .color = {255, 255, 255, 255}},
	};
	uint32_t first = stilb_render_geometry_2d(context, corners, 4, indices, 6);
	record_draw_2d(context, first, 6, clip, texture, RENDER_STATE_PICTURE, (const float[2]){factor, (float)tone});
}

stilb_result stilb_render_pass_end(stilb_render *render, uint32_t pass)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(pass < STILB_RENDER_MAX_PASSES);
	render_pass_lists *lists = &render->passes[pass];
	STILB_ASSERT(lists->state == RENDER_LIST_RECORDING && "pass_end follows pass_begin");
	lists->state = RENDER_LIST_CLOSED;
	for (uint32_t i = 0; i < render->context_count; i++)
		if (render->contexts[i].failed)
			return stilb_fail(STILB_ERROR_MEMORY, "no memory for the frame's draws; try fewer models");
	return STILB_OK;
}

/* ---- recording a scene ------------------------------------------------------------------------------------------- */

/* A pass of a scene that is being recorded: shared, read-only, by the slices of its loop. */
typedef struct record_pass {
	stilb_render *render;
	const stilb_scene *scene;
	const uint32_t *visible;
	uint32_t visible_count;
	uint32_t pass;
} record_pass;

/* What a segment's loop reads, in locals, because the compiler must assume that a draw's stores change the members of
 * scene and renderer. */
typedef struct record_parts {
	const uint32_t *visible, *first_part, *meshes, *materials;
	const uint32_t *words;  /* render_places.words */
	const float *stretches; /* render_places.stretches */
	const stilb_mat4 *transforms;
	const stilb_render_mesh *mesh_handles;
	const stilb_render_material *material_handles;
} record_parts;

static record_parts record_parts_of(const record_pass *recorded)
{
	const stilb_scene *scene = recorded->scene;
	const render_scene *tables = &recorded->render->scene;
	return (record_parts){
		.visible = recorded->visible,
		.first_part = scene->first_part,
		.meshes = scene->part_mesh,
		.materials = scene->part_material,
		.words = tables->places.words,
		.stretches = tables->places.stretches,
		.transforms = scene->part_transform,
		.mesh_handles = tables->meshes,
		.material_handles = tables->materials,
	};
}

static inline record_what record_what_of(const stilb_render_context *context, const record_parts *parts, uint32_t p)
{
	return record_full(context, parts->mesh_handles[parts->meshes[p]], parts->material_handles[parts->materials[p]]);
}

static void record_segment(const record_pass *recorded, stilb_render_context *context, uint32_t segment)
{
	PROFILE("record segment");
	record_parts parts = record_parts_of(recorded);
	uint32_t first = segment * RECORD_SEGMENT_MODELS, end = first + RECORD_SEGMENT_MODELS;
	end = end < recorded->visible_count ? end : recorded->visible_count;
	stilb_render_segment_begin(context, recorded->pass, segment);
	for (uint32_t i = first; i < end; i++) {
		uint32_t model = parts.visible[i];
		STILB_ASSERT(model < recorded->scene->model_count);
		for (uint32_t p = parts.first_part[model]; p < parts.first_part[model + 1]; p++)
			record_put(context, record_what_of(context, &parts, p), render_place_word(parts.words, p), 0);
	}
	stilb_render_segment_end(context);
}

/* ---- recording a scene as a view sees it ------------------------------------------------------------------------- */

/* A pass with the levels that its view asks for. */
typedef struct record_pass_view {
	record_pass pass;
	render_detail_view view;
	const stilb_render_view *seen;
	const stilb_mat4 *last; /* of the view */
	uint16_t *history;      /* [part_count] NULL: levels do not depend on frames before */
	uint8_t *impostors;     /* [impostor_model_count] NULL: none are drawn */
} record_pass_view;

/* The state of a mesh in full becomes that of its level. If that has 16 bit indices, each level has. */
static inline void record_set_state(const render_levels *levels, uint32_t level, record_what *what)
{
	if (__builtin_expect((what->state & RENDER_STATE_WIDE) != 0, 0))
		what->state = (what->state & RENDER_STATE_EXTRAS) | render_state_of_level(levels, level);
}

static inline void record_set_level(const render_levels *levels, uint32_t level, record_what *what)
{
	what->level = &render_levels_level(levels)[level];
	record_set_state(levels, level, what);
}

/* Chooses the level in which a part is drawn, and brings its history, if it has one, up to date. False: the part
 * fades. */
static inline bool record_choose(const render_detail_view *view, const render_levels *levels, float stretch, float room,
                                 uint16_t *history, record_what *what)
{
	uint32_t level = render_detail_allowed(levels, stretch, room);
	if (history && __builtin_expect(*history != render_detail_rest(level), 0)) {
		*history = render_detail_step(*history, view->mode, levels, level, stretch, room);
		if (render_detail_fades(*history))
			return false;
		level = (*history & 63u) - 1;
	}
	record_set_level(levels, level, what);
	if (view->shows)
		what->detail = (level < 62 ? level + 1 : 63) << RENDER_DETAIL_SHIFT;
	return true;
}

/* The same for a mesh that morphs. */
static inline void record_choose_morph(const render_levels *levels, float stretch, float room, float inverse,
                                       uint16_t *history, record_what *what)
{
	uint32_t allowed = render_detail_allowed(levels, stretch, room);
	uint32_t target = 64 * allowed + render_detail_morph(levels, allowed, stretch, inverse);
	uint32_t place = render_detail_follow(history, 64 * levels->count, target);
	uint32_t level = place >> 6, gone = place & 63u;
	what->level = &render_levels_level(levels)[level + ((levels->count + 1) & -(uint32_t)(gone > 0))];
	what->detail = gone << RENDER_DETAIL_SHIFT;
	record_set_state(levels, level, what);
}

/* Records a part in the level that its room allows. False: it fades, and is not recorded. morphs: a constant, so that
 * each mode has code of its own; only with it the inverse of the room counts. */
__attribute__((always_inline)) static inline bool
record_part_seen(const render_detail_view *view, stilb_render_context *context, const record_parts *parts, uint32_t p,
                 uint16_t *history, float room, float inverse, bool morphs, bool has_levels, record_what what)
{
	uint64_t plain = morphs ? RENDER_STATE_MORPH : view->shows ? RENDER_STATE_SHOW : 0;
	if (has_levels) {
		const render_levels *levels = context->levels[what.mesh];
		float stretch = parts->stretches[p];
		if (morphs && levels->morphs > 0)
			record_choose_morph(levels, stretch, room, inverse, history, &what);
		else if (!record_choose(view, levels, stretch, room, history, &what))
			return false;
	}
	record_put(context, what, render_place_word(parts->words, p), plain);
	return true;
}

/* True if clusters are drawn in place of the mesh in full. */
static inline bool record_is_cut(const render_detail_view *view, const render_levels *levels, const record_what *what)
{
	return levels->clusters && what->level == render_levels_level(levels) && view->scale >= 0.0f;
}

/* Records the clusters of a part that its view needs. kind: as of record_put. */
__attribute__((noinline)) static void record_clusters(const record_pass_view *recorded, stilb_render_context *context,
                                                      record_what what, const record_parts *parts, uint32_t p,
                                                      uint64_t kind)
{
	const render_clusters *clusters = context->levels[what.mesh]->clusters;
	render_cluster_view view = render_cluster_view_make(&recorded->view, recorded->seen, &parts->transforms[p]);
	bool shows = recorded->view.shows;
	if (context->failed || !render_clusters_choose(clusters, &view, shows, &context->cut)) {
		context->failed = true;
		return;
	}
	uint32_t row = render_place_word(parts->words, p);
	for (uint32_t r = 0; r < context->cut.range_count && !context->failed; r++) {
		const render_cluster_range *range = &context->cut.ranges[r];
		render_level level = {.index_count = range->index_count,
		                      .instance_count = 1,
		                      .first_index = what.level->first_index + range->first_index,
		                      .vertex_offset = what.level->vertex_offset};
		record_what piece = what;
		piece.level = &level;
		if (shows)
			piece.detail = (range->depth < 62 ? range->depth + 1 : 63) << RENDER_DETAIL_SHIFT;
		record_put(context, piece, row, kind);
	}
}

/* Records a level that a part fades from or to. */
static void record_fading(const record_pass_view *recorded, stilb_render_context *context, record_what what,
                          const record_parts *parts, uint32_t p)
{
	const render_levels *levels = context->levels[what.mesh];
	if (levels && record_is_cut(&recorded->view, levels, &what))
		record_clusters(recorded, context, what, parts, p, RENDER_STATE_FADE);
	else
		record_put(context, what, render_place_word(parts->words, p), RENDER_STATE_FADE);
}

/* Records a part of a mesh that has clusters, as record_part_seen does: it never morphs. */
static bool record_part_cut(const record_pass_view *recorded, stilb_render_context *context, const record_parts *parts,
                            uint32_t p, float room, record_what what)
{
	const render_detail_view *view = &recorded->view;
	const render_levels *levels = context->levels[what.mesh];
	uint64_t plain = view->shows ? RENDER_STATE_SHOW : view->mode == STILB_RENDER_DETAIL_MORPH ? RENDER_STATE_MORPH : 0;
	if (!record_choose(view, levels, parts->stretches[p], room, recorded->history ? &recorded->history[p] : NULL,
	                   &what))
		return false;
	if (record_is_cut(view, levels, &what)) {
		record_clusters(recorded, context, what, parts, p, plain);
		return true;
	}
	bool level = view->shows && what.level != render_levels_level(levels);
	/* The clusters' colours come before those of levels. */
	uint32_t deeper = level ? (what.detail >> RENDER_DETAIL_SHIFT) + levels->clusters->depth : 0;
	if (level)
		what.detail = (deeper < 63 ? deeper : 63) << RENDER_DETAIL_SHIFT;
	record_put(context, what, render_place_word(parts->words, p), plain);
	return true;
}

/* The same for a part of a mesh whose state has bits of its own. A function of its own, so that the loop below, which
 * has no register left for them, is as fast as if there were none (measured: 4 %). */
__attribute__((noinline)) static bool record_part_odd(const record_pass_view *recorded, stilb_render_context *context,
                                                      uint32_t p, float room)
{
	record_parts parts = record_parts_of(&recorded->pass);
	record_what what = record_what_of(context, &parts, p);
	uint16_t *history = recorded->history ? &recorded->history[p] : NULL;
	bool levels = context->meshes[what.mesh].flags & RENDER_MESH_LEVELS;
	if (levels && context->levels[what.mesh]->clusters)
		return record_part_cut(recorded, context, &parts, p, room, what);
	return recorded->view.mode == STILB_RENDER_DETAIL_MORPH
	           ? record_part_seen(&recorded->view, context, &parts, p, history, room, 1.0f / room, true, levels, what)
	           : record_part_seen(&recorded->view, context, &parts, p, history, room, 0.0f, false, levels, what);
}

/* Records the parts of models first .. end - 1 of the visible ones, but those that fade. True: there are some. morphs
 * and forgets, that there is no history: constants, as above. */
__attribute__((always_inline)) static inline bool record_models_seen(const record_pass_view *recorded,
                                                                     stilb_render_context *context, uint32_t first,
                                                                     uint32_t end, const float *rooms, bool morphs,
                                                                     bool forgets)
{
	record_parts parts = record_parts_of(&recorded->pass);
	render_detail_view view = recorded->view;
	uint16_t *history = recorded->history;
	bool fades = false;
	for (uint32_t i = first; i < end; i++) {
		uint32_t model = parts.visible[i];
		STILB_ASSERT(model < recorded->pass.scene->model_count);
		float room = rooms[i - first], inverse = morphs ? 1.0f / room : 0.0f;
		for (uint32_t p = parts.first_part[model]; p < parts.first_part[model + 1]; p++) {
			record_what what = record_what_of(context, &parts, p);
			uint32_t flags = context->meshes[what.mesh].flags;
			uint16_t *before = forgets ? NULL : &history[p];
			what.state = 0;
			if (flags == RENDER_MESH_LEVELS)
				fades |= !record_part_seen(&view, context, &parts, p, before, room, inverse, morphs, true, what);
			else if (__builtin_expect(flags == 0, 1))
				record_part_seen(&view, context, &parts, p, before, room, inverse, morphs, false, what);
			else
				fades |= !record_part_odd(recorded, context, p, room);
		}
	}
	return fades;
}

static bool record_models_by_mode(const record_pass_view *recorded, stilb_render_context *context, uint32_t first,
                                  uint32_t end, const float *rooms)
{
	if (!recorded->history)
		return record_models_seen(recorded, context, first, end, rooms, false, true);
	return recorded->view.mode == STILB_RENDER_DETAIL_MORPH
	           ? record_models_seen(recorded, context, first, end, rooms, true, false)
	           : record_models_seen(recorded, context, first, end, rooms, false, false);
}

/* Records the parts of models first .. end - 1 that fade, both levels of each: either in the pixels that the other one
 * leaves. */
static void record_models_fading(const record_pass_view *recorded, stilb_render_context *context, uint32_t first,
                                 uint32_t end)
{
	record_parts parts = record_parts_of(&recorded->pass);
	bool morphs = recorded->view.mode == STILB_RENDER_DETAIL_MORPH;
	for (uint32_t i = first; i < end; i++)
		for (uint32_t p = parts.first_part[parts.visible[i]]; p < parts.first_part[parts.visible[i] + 1]; p++) {
			record_what what = record_what_of(context, &parts, p);
			uint16_t history = recorded->history[p];
			if (!(context->meshes[what.mesh].flags & RENDER_MESH_LEVELS) || !render_detail_fades(history))
				continue;
			const render_levels *levels = context->levels[what.mesh];
			if (morphs && levels->morphs > 0) /* what is left of another mode */
				continue;
			uint32_t share = history >> 12 << 1;
			record_what before = what;
			record_set_level(levels, (history & 63u) - 1, &what);
			what.detail = share << RENDER_DETAIL_SHIFT;
			record_fading(recorded, context, what, &parts, p);
			what = before;
			record_set_level(levels, (history >> 6 & 63u) - 1, &what);
			what.detail = (share | RENDER_DETAIL_OUT) << RENDER_DETAIL_SHIFT;
			record_fading(recorded, context, what, &parts, p);
		}
}

/* Records the model's impostor, with a row of the frame: that of the part has another material. */
static void record_impostor(const record_pass_view *recorded, stilb_render_context *context, uint32_t model,
                            uint32_t detail, uint64_t kind)
{
	const stilb_scene *scene = recorded->pass.scene;
	const stilb_render_impostor *impostor = &recorded->pass.render->scene.impostors[scene->model_impostor[model] - 1];
	const stilb_mat4 *transform = &scene->part_transform[scene->first_part[model]];
	record_what what = record_full(context, impostor->mesh, impostor->material);
	what.detail = detail << RENDER_DETAIL_SHIFT;
	record_put_by_hand(context, what, transform, kind);
	uint32_t last = render_place_last_row(&recorded->pass.render->scene.places, scene->first_part[model]);
	if (context->failed)
		return;
	render_row *row = &context->row[-1]; /* that was just written */
	if (last != 0)
		row->last = last;
	row->model = render_row_model(scene, model);
}

/* Records a model that fades between its impostor and its meshes, each in the coarsest level that it may have. */
static void record_model_fading(const record_pass_view *recorded, stilb_render_context *context, uint32_t model,
                                float room)
{
	record_parts parts = record_parts_of(&recorded->pass);
	uint8_t history = recorded->impostors[model];
	uint32_t share = history % 16u * 2, out = share | RENDER_DETAIL_OUT;
	bool coming = history < IMPOSTOR_GOING;
	for (uint32_t p = parts.first_part[model]; p < parts.first_part[model + 1]; p++) {
		record_what what = record_what_of(context, &parts, p);
		what.detail = (coming ? out : share) << RENDER_DETAIL_SHIFT;
		if (context->meshes[what.mesh].flags & RENDER_MESH_LEVELS) {
			const render_levels *levels = context->levels[what.mesh];
			uint32_t level = render_detail_allowed(levels, parts.stretches[p], room);
			record_set_level(levels, level, &what);
			recorded->history[p] = render_detail_rest(level);
		}
		record_fading(recorded, context, what, &parts, p);
	}
	record_impostor(recorded, context, model, coming ? share : out, RENDER_STATE_FADE);
}

/* Models with their rooms. */
typedef struct record_models {
	uint32_t ids[RECORD_SEGMENT_MODELS];
	float rooms[RECORD_SEGMENT_MODELS];
	uint32_t count;
} record_models;

/* Takes the models out of `near` that are not drawn as meshes alone, and brings the histories of their impostors up to
 * date. */
static void record_take_far(const record_pass_view *recorded, record_models *near, record_models *far)
{
	const stilb_scene *scene = recorded->pass.scene;
	uint32_t kept = 0;
	far->count = 0;
	for (uint32_t i = 0; i < near->count; i++) {
		uint32_t model = near->ids[i];
		float room = near->rooms[i];
		uint32_t impostor = model < scene->impostor_model_count ? scene->model_impostor[model] : 0;
		uint8_t *history = &recorded->impostors[impostor ? model : 0];
		if (impostor)
			*history = render_detail_impostor(recorded->history ? *history : 0, &recorded->view,
			                                  scene->impostors[impostor - 1].side, scene->bounds.radius[model], room);
		record_models *to = impostor && *history != IMPOSTOR_MESHES ? far : near;
		uint32_t at = to == far ? far->count++ : kept++;
		to->ids[at] = model;
		to->rooms[at] = room;
	}
	near->count = kept;
}

static void record_models_far(const record_pass_view *recorded, stilb_render_context *context, const record_models *far)
{
	uint64_t plain = recorded->view.shows                               ? RENDER_STATE_SHOW
	                 : recorded->view.mode == STILB_RENDER_DETAIL_MORPH ? RENDER_STATE_MORPH
	                                                                    : 0;
	for (uint32_t i = 0; i < far->count; i++) {
		if (recorded->impostors[far->ids[i]] == IMPOSTOR_ALONE)
			record_impostor(recorded, context, far->ids[i], recorded->view.shows ? 63u : 0u, plain);
		else
			record_model_fading(recorded, context, far->ids[i], far->rooms[i]);
	}
}

/* A segment of a scene that has impostors: first the models that are drawn as meshes. */
static void record_segment_far(const record_pass_view *recorded, stilb_render_context *context, const uint32_t *visible,
                               const float *rooms, uint32_t count)
{
	record_models near = {.count = count}, far;
	memcpy(near.ids, visible, count * sizeof *near.ids);
	memcpy(near.rooms, rooms, count * sizeof *near.rooms);
	record_take_far(recorded, &near, &far);
	record_pass_view meshes = *recorded;
	meshes.pass.visible = near.ids;
	bool fades = record_models_by_mode(&meshes, context, 0, near.count, near.rooms);
	if (fades)
		record_models_fading(&meshes, context, 0, near.count);
	record_models_far(recorded, context, &far);
}

static void record_segment_seen(const record_pass_view *recorded, stilb_render_context *context, uint32_t segment)
{
	PROFILE("record segment");
	float rooms[RECORD_SEGMENT_MODELS];
	uint32_t first = segment * RECORD_SEGMENT_MODELS, end = first + RECORD_SEGMENT_MODELS;
	end = end < recorded->pass.visible_count ? end : recorded->pass.visible_count;
	stilb_render_segment_begin(context, recorded->pass.pass, segment);
	render_detail_rooms(&recorded->view, &recorded->pass.scene->bounds, recorded->pass.visible + first, end - first,
	                    rooms);
	if (recorded->impostors) {
		record_segment_far(recorded, context, recorded->pass.visible + first, rooms, end - first);
		stilb_render_segment_end(context);
		return;
	}
	bool fades = record_models_by_mode(recorded, context, first, end, rooms);
	/* Parts that fade come last: they have pipelines of their own, and among the others each would end a run. */
	if (fades)
		record_models_fading(recorded, context, first, end);
	stilb_render_segment_end(context);
}

/* ---- passes ------------------------------------------------------------------------------------------------------ */

/* Makes the pass's history as long as the scene's list of parts; new parts were never drawn. */
static bool record_history_fit(render_pass_lists *lists, uint32_t part_count)
{
	uint32_t before = lists->history_capacity;
	if (!render_reserve((void **)&lists->history, &lists->history_capacity, part_count, sizeof *lists->history))
		return false;
	if (lists->history_capacity > before)
		memset(lists->history + before, 0, (lists->history_capacity - before) * sizeof *lists->history);
	return true;
}

/* The same for models that have impostors. */
static bool record_impostors_fit(render_pass_lists *lists, uint32_t model_count)
{
	uint32_t before = lists->impostor_capacity;
	if (!render_reserve((void **)&lists->impostors, &lists->impostor_capacity, model_count, 1))
		return false;
	if (lists->impostor_capacity > before)
		memset(lists->impostors + before, 0, lists->impostor_capacity - before);
	return true;
}

/* Parts of the visible models. */
static uint64_t record_count_parts(const record_pass *recorded)
{
	const uint32_t *first_part = recorded->scene->first_part;
	uint64_t parts = 0;
	for (uint32_t i = 0; i < recorded->visible_count; i++)
		parts += first_part[recorded->visible[i] + 1] - first_part[recorded->visible[i]];
	return parts;
}

/* Passes that are recorded together. */
typedef struct record_passes {
	record_pass_view passes[STILB_RENDER_MAX_PASSES]; /* [count] */
	uint32_t first_segment[STILB_RENDER_MAX_PASSES + 1];
	uint32_t count;
} record_passes;

/* Before the frame's first commands: makes room for one a part, so that a frame that draws far more than the last one
 * neither writes to the heap first nor grows by a quarter more than it needs. Without memory for it the frame goes on:
 * it may need less. */
static void record_reserve(stilb_render *render, const record_passes *all)
{
	render_memory *memory = &render->memory[RENDER_MEMORY_COMMANDS];
	uint64_t spare = (uint64_t)render->context_count * RENDER_COMMAND_CHUNK, parts = spare;
	for (uint32_t p = 0; p < all->count; p++)
		parts += all->passes[p].pass.visible_count > 0 ? all->passes[p].pass.scene->part_count : 0;
	/* Relaxed: no thread claims memory now. */
	if (atomic_load_explicit(&memory->next, memory_order_relaxed) > 0 || parts <= memory->capacity)
		return;
	parts = spare;
	for (uint32_t p = 0; p < all->count; p++)
		parts += record_count_parts(&all->passes[p].pass);
	if (parts > memory->capacity && parts <= UINT32_MAX)
		render_device_grow(render->device, memory, RENDER_MEMORY_COMMANDS, (uint32_t)parts, 0);
}

/* Brings the scene's rows up to date. needs: RENDER_PLACES_.... */
static stilb_result record_rows(stilb_render *render, const stilb_scene *scene, uint32_t needs, stilb_job_pool *pool,
                                uint32_t worker)
{
	PROFILE("rows");
	uint32_t count, first;
	stilb_result result = render_places_frame(render, scene, needs, &count);
	if (result != STILB_OK || count == 0)
		return result;
	render_row *rows = render_claim(render, RENDER_MEMORY_ROWS, count, &first);
	if (!rows || first > RENDER_MAX_ROWS - count)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the rows of %u parts that move", count);
	render_places_move(render, scene, rows, first, count, pool, worker);
	return STILB_OK;
}

/* What a pass is recorded with: its levels' history, if it may draw some. */
static stilb_result record_prepare(stilb_render *render, const stilb_scene *scene, const stilb_render_recording *asked,
                                   record_pass_view *recorded)
{
	STILB_ASSERT(asked->pass < STILB_RENDER_MAX_PASSES);
	*recorded = (record_pass_view){.pass = {render, scene, asked->visible, asked->visible_count, asked->pass}};
	const stilb_render_view *view = asked->view;
	recorded->last = view ? view->last : NULL;
	if (!view || asked->visible_count == 0)
		return STILB_OK;
	if (view->lighting == STILB_RENDER_LIGHTING_COMBINED && render_view_is_lit(view)) {
		stilb_result result =
			render_combined_note(&render->passes[asked->pass].combined, scene, asked->visible, asked->visible_count);
		if (result != STILB_OK)
			return result;
	}
	STILB_ASSERT((uint32_t)view->detail.mode <= STILB_RENDER_DETAIL_MORPH && view->show < STILB_RENDER_SHOWS);
	uint32_t size[2] = {view->area[2], view->area[3]}; /* of a target of depth alone */
	if (size[0] == 0) {
		size[0] = view->target ? view->target->width : render->device->width;
		size[1] = view->target ? view->target->height : render->device->height;
	}
	recorded->view = render_detail_view_make(view, size[0], size[1]);
	if (recorded->view.mode == STILB_RENDER_DETAIL_OFF)
		return STILB_OK;
	render_pass_lists *lists = &render->passes[asked->pass];
	bool impostors = scene->impostor_model_count > 0 && render->scene.impostor_count == scene->impostor_count &&
	                 render->scene.impostors_removed == scene->impostors_removed &&
	                 stilb_scene_impostors_are_current(scene);
	bool forgets = view->shadow && recorded->view.mode == STILB_RENDER_DETAIL_POP;
	if ((!forgets && !record_history_fit(lists, scene->part_count)) ||
	    (impostors && !record_impostors_fit(lists, scene->impostor_model_count)))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the levels of %u parts", scene->part_count);
	recorded->seen = view;
	recorded->history = forgets ? NULL : lists->history;
	recorded->impostors = impostors ? lists->impostors : NULL;
	return STILB_OK;
}

/* Begins all passes, with the scene's rows. */
static stilb_result record_begin(stilb_render *render, const stilb_scene *scene, record_passes *all,
                                 stilb_job_pool *pool, uint32_t worker)
{
	bool any = false;
	uint32_t needs = 0;
	for (uint32_t p = 0; p < all->count; p++) {
		any |= all->passes[p].pass.visible_count > 0;
		needs |= (all->passes[p].seen ? RENDER_PLACES_STRETCHES : 0) | (all->passes[p].last ? RENDER_PLACES_LAST : 0);
	}
	bool rows = any || (scene && needs & RENDER_PLACES_LAST); /* where all is now is needed in the next frame */
	STILB_ASSERT(!rows || (scene && render->scene.mesh_count == scene->mesh_count &&
	                       render->scene.material_count == scene->material_count));
	stilb_result result = STILB_OK;
	if (any)
		record_reserve(render, all);
	if (rows)
		result = record_rows(render, scene, needs, pool, worker);
	all->first_segment[0] = 0;
	for (uint32_t p = 0; p < all->count && result == STILB_OK; p++) {
		const record_pass *pass = &all->passes[p].pass;
		uint32_t segments = (pass->visible_count + RECORD_SEGMENT_MODELS - 1) / RECORD_SEGMENT_MODELS;
		all->first_segment[p + 1] = all->first_segment[p] + segments;
		result = stilb_render_pass_begin(render, pass->pass, segments);
		if (all->passes[p].seen)
			render->passes[pass->pass].detail = all->passes[p].view.mode;
	}
	for (uint32_t p = 0; p < all->count && result != STILB_OK; p++) /* no pass is left half recorded */
		render->passes[all->passes[p].pass.pass].state = RENDER_LIST_EMPTY;
	return result;
}

/* Records segments of the passes, which are numbered through. */
static void record_slice(uint32_t begin, uint32_t end, uint32_t worker, void *user)
{
	const record_passes *all = user;
	uint32_t p = 0;
	for (uint32_t s = begin; s < end; s++) {
		while (s >= all->first_segment[p + 1])
			p++;
		const record_pass_view *recorded = &all->passes[p];
		stilb_render_context *context = &recorded->pass.render->contexts[worker];
		if (recorded->seen)
			record_segment_seen(recorded, context, s - all->first_segment[p]);
		else
			record_segment(&recorded->pass, context, s - all->first_segment[p]);
	}
}

stilb_result stilb_render_record_views(stilb_render *render, const stilb_scene *scene,
                                       const stilb_render_recording *passes, uint32_t count, stilb_job_pool *pool,
                                       uint32_t worker)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(render->state == RENDER_FRAME_BEGUN && count <= STILB_RENDER_MAX_PASSES && (passes || count == 0));
	STILB_ASSERT(stilb_job_pool_worker_count(pool) < render->context_count && "a context for each worker");
	record_passes all;
	all.count = count;
	stilb_result result = STILB_OK;
	for (uint32_t p = 0; p < count && result == STILB_OK; p++)
		result = record_prepare(render, scene, &passes[p], &all.passes[p]);
	if (result == STILB_OK)
		result = record_begin(render, scene, &all, pool, worker);
	if (result != STILB_OK)
		return result;
	stilb_job_parallel_for(pool, all.first_segment[count], 1, record_slice, &all, worker);
	for (uint32_t p = 0; p < count; p++) { /* all end, whatever has failed */
		stilb_result ended = stilb_render_pass_end(render, passes[p].pass);
		result = result == STILB_OK ? ended : result;
	}
	return result;
}

stilb_result stilb_render_record_view(stilb_render *render, uint32_t pass, const stilb_scene *scene,
                                      const uint32_t *visible, uint32_t visible_count, const stilb_render_view *view,
                                      stilb_job_pool *pool, uint32_t worker)
{
	STILB_ASSERT(view);
	return stilb_render_record_views(render, scene, &(stilb_render_recording){pass, visible_count, visible, view}, 1,
	                                 pool, worker);
}

stilb_result stilb_render_record(stilb_render *render, uint32_t pass, const stilb_scene *scene, const uint32_t *visible,
                                 uint32_t visible_count, stilb_job_pool *pool, uint32_t worker)
{
	return stilb_render_record_views(render, scene, &(stilb_render_recording){pass, visible_count, visible, NULL}, 1,
	                                 pool, worker);
}
