/* Replay, on the main thread: turns what the workers recorded into device commands. Workers leave, for each segment (a
 * numbered part of a pass), runs of draws with the same bindings. These are joined in the order of the segments'
 * numbers, and the passes are given to the device in the order of stilb_render_pass.order. */
#include "render/render_internal.h"

#include <string.h>

/* Joins the runs of a pass's segments in number order; adjacent runs of the same state are merged. */
static stilb_result replay_order(const stilb_render_pass *pass, render_pass_lists *lists)
{
	uint64_t kind = pass->kind == STILB_RENDER_PASS_2D ? RENDER_STATE_2D : 0;
	lists->run_count = 0;
	lists->draws = lists->states = 0;
	lists->kinds = lists->detail == STILB_RENDER_DETAIL_FADE ? 1u << render_state_detail(RENDER_STATE_FADE) : 0;
	uint32_t most = 0;
	for (uint32_t s = 0; s < lists->segment_count; s++) {
		STILB_ASSERT(lists->segments[s].context && "every segment is recorded, an empty one too");
		most += lists->segments[s].run_count;
	}
	if (!render_reserve((void **)&lists->runs, &lists->run_capacity, most, sizeof *lists->runs))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the order of %u runs of draws", most);
	render_run *last = NULL;
	for (uint32_t s = 0; s < lists->segment_count; s++) {
		const render_segment *segment = &lists->segments[s];
		for (uint32_t r = 0; r < segment->run_count; r++) {
			const render_run *run = &segment->context->runs[segment->first_run + r];
			STILB_ASSERT((run->state & RENDER_STATE_2D) == kind && "2D draws in 2D passes alone");
			STILB_ASSERT(run->count > 0 && segment->first_run + r < segment->context->run_count);
			lists->draws += run->count;
			lists->states |= run->state;
			lists->kinds |= 1u << render_state_detail(run->state);
			if (last && last->first + last->count == run->first && last->state == run->state) {
				last->count += run->count;
				continue;
			}
			last = &lists->runs[lists->run_count++];
			*last = *run;
		}
	}
	return STILB_OK;
}

/* Sort key of passes: scene passes before 2D passes, each kind by ascending order. */
static uint64_t replay_rank(const stilb_render_pass *pass)
{
	return (uint64_t)(pass->kind == STILB_RENDER_PASS_2D) << 32 | pass->order;
}

/* The pass that follows `after` by rank, then by table index; after NULL: the first. NULL: there is none. */
static const stilb_render_pass *replay_next_pass(const stilb_render_pass *passes, uint32_t count,
                                                 const stilb_render_pass *after)
{
	const stilb_render_pass *next = NULL;
	for (const stilb_render_pass *p = passes; p < passes + count; p++) {
		uint64_t rank = replay_rank(p), last = after ? replay_rank(after) : 0;
		bool later = !after || rank > last || (rank == last && p > after);
		if (later && (!next || rank < replay_rank(next)))
			next = p;
	}
	return next;
}

/* Checks an ordered pass: runs are not empty and lie in the claimed commands, each command in a claimed row, and draws
 * and states are those of the runs. For STILB_CHECK: time in proportion to the draws. */
static bool replay_lists_is_sound(const stilb_render *render, const render_pass_lists *lists)
{
	/* Relaxed: no worker records any more. */
	uint32_t commands = atomic_load_explicit(&render->memory[RENDER_MEMORY_COMMANDS].next, memory_order_relaxed);
	uint32_t frame_rows = atomic_load_explicit(&render->memory[RENDER_MEMORY_ROWS].next, memory_order_relaxed);
	uint32_t scene_rows = render->shown_rows ? render->shown_rows->capacity : 0;
	uint64_t draws = 0, states = 0;
	for (uint32_t r = 0; r < lists->run_count; r++) {
		const render_run *run = &lists->runs[r];
		if (run->count == 0 || run->first >= commands || run->count > commands - run->first)
			return false;
		const render_command *command = render_commands(render) + run->first;
		for (uint32_t c = 0; c < run->count; c++) {
			uint32_t rows = command[c].row & RENDER_ROW_FRAME ? frame_rows : scene_rows;
			if (render_command_row(&command[c]) >= rows || command[c].instance_count != 1)
				return false;
		}
		draws += run->count;
		states |= run->state;
	}
	return draws == lists->draws && states == lists->states;
}

stilb_result render_order(stilb_render *render, const stilb_render_pass *pass, render_pass_lists *lists)
{
	STILB_ASSERT(lists->state == RENDER_LIST_CLOSED && "every replayed pass is recorded");
	STILB_ASSERT((uint32_t)pass->kind <= STILB_RENDER_PASS_2D);
	STILB_ASSERT(pass->kind == STILB_RENDER_PASS_SCENE || !pass->sort);
	lists->kind = pass->kind;
	stilb_result result = replay_order(pass, lists);
	if (result == STILB_OK && pass->sort)
		result = render_sort(render, lists);
	STILB_CHECK(result != STILB_OK || replay_lists_is_sound(render, lists));
	return result;
}

/* Keeps what the stream hash covers of the view. */
static void replay_keep_view(render_pass_lists *lists, const render_stream *stream)
{
	const stilb_scene_surroundings *around = &stream->view->surroundings;
	uint32_t lamps = stream->lights.count > 0 ? render_view_lamps(stream->view, stream->panorama) : 0;
	lists->shading = stream->view->shading;
	memcpy(lists->sky, around->sky, sizeof lists->sky);
	memcpy(lists->ground, around->ground, sizeof lists->ground);
	lists->glossy = (uint32_t)around->glossy + 2 * (uint32_t)stream->view->ambient;
	lists->both_sides = stream->view->both_sides;
	lists->first_light = stream->lights.first + lamps;
	lists->light_count = stream->lights.count - lamps;
	lists->panorama = stream->panorama ? stream->panorama->key : 0;
	lists->rotation = stream->panorama ? around->rotation : 0.0f;
	lists->shadow = stream->view->shadow;
}

static stilb_result replay_pass(stilb_render *render, const stilb_render_pass *pass, render_pass_lists *lists,
                                render_stream *stream)
{
	stream->pass = pass;
	stream->commands = render_commands(render);
	stream->runs = lists->runs;
	stream->run_count = lists->run_count;
	stream->rows = render->shown_rows;
	stream->draws = lists->draws;
	stream->states = lists->states;
	stream->kinds = lists->kinds;
	lists->state = RENDER_LIST_REPLAYED;
	if (stream->view)
		replay_keep_view(lists, stream);
	stilb_render_stats *stats = &render->device->stats;
	stats->draws += lists->draws;
	stats->recorded_bytes += lists->draws * sizeof(render_command);
	stats->binds_asked += lists->draws * 3;
	return render_device_pass(render->device, stream);
}

/* Bytes that were recorded in this frame besides commands: 2D geometry, and rows, of which contexts claim more than
 * they write. */
static uint64_t replay_other_bytes(const stilb_render *render)
{
	/* Relaxed: no worker records any more. */
	uint64_t rows = atomic_load_explicit(&render->memory[RENDER_MEMORY_ROWS].next, memory_order_relaxed);
	for (uint32_t i = 0; i < render->context_count; i++)
		rows -= (uint64_t)(render->contexts[i].row_end - render->contexts[i].row);
	uint64_t bytes = rows * sizeof(render_row);
	for (int kind = RENDER_MEMORY_VERTICES_2D; kind <= RENDER_MEMORY_INDICES_2D; kind++)
		/* Relaxed: no worker records any more. */
		bytes += (uint64_t)atomic_load_explicit(&render->memory[kind].next, memory_order_relaxed) *
		         render->memory[kind].element;
	return bytes;
}

static void *replay_make_panorama(void *user, size_t bytes)
{
	return render_device_panorama_make(user, bytes);
}

static stilb_result replay_show_panorama(void *user, const render_panorama_gloss *gloss)
{
	return render_device_panorama_show(user, gloss);
}

/* Makes what frames need of the panorama of the first view that has one: in a window over several frames, so that it
 * never waits for a large one. */
static stilb_result replay_update_panorama(stilb_render *render, const stilb_render_view *views, uint32_t view_count,
                                           stilb_job_pool *pool, uint32_t worker)
{
	render_panorama_memory memory = {replay_make_panorama, replay_show_panorama, render->device};
	for (uint32_t v = 0; v < view_count; v++)
		if (!render_view_is_depth(&views[v]) && render_panorama_is_good(&views[v].surroundings.panorama))
			return render_panorama_update(&render->panorama, &views[v].surroundings.panorama, memory,
			                              stilb_gpu_in_window(render->device->gpu), pool, worker);
	render_panorama_leave(&render->panorama);
	return STILB_OK;
}

/* Orders the draws of every pass, and the passes themselves. All of it before the device gets the first pass, because
 * sorting may move the memory that holds the commands. */
static stilb_result replay_order_passes(stilb_render *render, const stilb_render_pass *passes, uint32_t count,
                                        const stilb_render_view *views)
{
	PROFILE("order");
	const stilb_render_pass *pass = NULL;
	stilb_result result = STILB_OK;
	while (result == STILB_OK && (pass = replay_next_pass(passes, count, pass))) {
		uint32_t index = (uint32_t)(pass - passes);
		result = render_order(render, pass, &render->passes[index]);
		if (result == STILB_OK && pass->kind == STILB_RENDER_PASS_SCENE)
			result = render_maps_order(render, &views[pass->view], pass->sort, &render->passes[index]);
		if (result == STILB_OK)
			render->replayed[render->replayed_count++] = index;
	}
	return result;
}

static bool replay_target_is_sound(const stilb_render_target *target)
{
	if (!target)
		return true;
	size_t length = target->name ? strnlen(target->name, STILB_RENDER_TARGET_NAME + 1) : 0;
	bool placed = target->place[2] > 0 && target->place[3] > 0;
	return length > 0 && length <= STILB_RENDER_TARGET_NAME && (uint32_t)target->kind <= STILB_RENDER_TARGET_DEPTH &&
	       target->width >= 1 && target->width <= 16384 && target->height >= 1 && target->height <= 16384 &&
	       target->layers <= RENDER_MAX_LAYERS &&
	       (target->kind == STILB_RENDER_TARGET_LIGHT ? target->layers == 0 && !target->lasting : !placed);
}

/* True if the view fills a part of its target that is there. */
static bool replay_area_is_sound(const stilb_render_view *view)
{
	const stilb_render_target *target = view->target;
	const uint16_t *area = view->area;
	bool none = area[0] == 0 && area[1] == 0 && area[2] == 0 && area[3] == 0;
	if (!render_view_is_depth(view))
		return none && view->layer == 0 && !view->shadow;
	return view->layer < (target->layers > 0 ? target->layers : 1) &&
	       (none || (area[2] > 0 && area[3] > 0 && area[0] + area[2] <= (int)target->width &&
	                 area[1] + area[3] <= (int)target->height));
}

stilb_result stilb_render_replay(stilb_render *render, const stilb_render_pass *passes, uint32_t pass_count,
                                 const stilb_render_view *views, uint32_t view_count, stilb_job_pool *pool,
                                 uint32_t worker)
{
	(void)view_count;
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(passes && (views || view_count == 0));
	STILB_ASSERT(pass_count >= 1 && pass_count <= STILB_RENDER_MAX_PASSES && render->state == RENDER_FRAME_BEGUN);
	for (const stilb_render_pass *pass = passes; pass < passes + pass_count; pass++)
		STILB_ASSERT(pass->kind != STILB_RENDER_PASS_SCENE ||
		             (pass->view < view_count && replay_target_is_sound(views[pass->view].target) &&
		              replay_area_is_sound(&views[pass->view]) && render_view_lighting_is_known(&views[pass->view])));
	render_device *device = render->device;
	device->stats = (stilb_render_stats){.gpu_ms = device->stats.gpu_ms, .recorded_bytes = replay_other_bytes(render)};
	render->state = RENDER_FRAME_REPLAYED;
	render_view_lights lights[STILB_RENDER_MAX_PASSES];
	stilb_result result = replay_update_panorama(render, views, view_count, pool, worker);
	if (result == STILB_OK)
		result = render_lights_place(render, passes, pass_count, views, lights, pool, worker);
	if (result == STILB_OK)
		result = render_memory_place(render);
	if (result == STILB_OK)
		result = replay_order_passes(render, passes, pass_count, views);
	bool updated = result == STILB_OK;
	if (updated)
		result = render_resources_update(render);
	for (uint32_t p = 0; p < render->replayed_count && result == STILB_OK; p++) {
		uint32_t index = render->replayed[p];
		const stilb_render_pass *pass = &passes[index];
		const stilb_render_view *view = pass->kind == STILB_RENDER_PASS_SCENE ? &views[pass->view] : NULL;
		render_stream stream = {
			.view = view,
			.panorama = view ? render_view_panorama(render, view) : NULL,
			.lights = lights[index],
			.written = lights[index].count > 0
		                   ? (const render_light *)render->memory[RENDER_MEMORY_LIGHTS].data + lights[index].first
		                   : NULL,
		};
		result = replay_pass(render, pass, &render->passes[index], &stream);
	}
	if (result == STILB_OK)
		result = render_device_run(device, pool, worker);
	if (updated)
		render_resources_sent(render, result == STILB_OK);
	return result;
}

/* ---- the hash of the stream -------------------------------------------------------------------------------------- */

/* state: of the draw's run. */
static uint64_t hash_draw(uint64_t hash, const render_resources *resources, const render_command *command,
                          const render_row *row, uint64_t state)
{
	const render_material *materials = (const render_material *)resources->heaps[RENDER_HEAP_MATERIALS].data;
	float transform[16] = {[15] = 1.0f};
	for (int r = 0; r < 3; r++)
		for (int c = 0; c < 4; c++)
			transform[4 * c + r] = row->transform[4 * r + c];
	uint32_t ids[2] = {resources->meshes[row->mesh].name, materials[row->material].name};
	hash = stilb_hash_fnv1a64(hash, ids, sizeof ids);
	hash = stilb_hash_fnv1a64(hash, transform, sizeof transform);
	hash = stilb_hash_fnv1a64(hash, &command->index_count, sizeof command->index_count);
	if (state & RENDER_STATE_MAPS) {
		uint64_t maps[2] = {resources->maps[materials[row->material].maps].hash, state & RENDER_STATE_EXTRAS};
		hash = stilb_hash_fnv1a64(hash, maps, sizeof maps);
	}
	if (state & RENDER_STATE_WIDE && render_levels_have_clusters(resources->levels[row->mesh])) {
		uint32_t from = command->first_index - resources->meshes[row->mesh].first_index;
		hash = stilb_hash_fnv1a64(hash, &from, sizeof from);
	}
	uint32_t detail = render_command_detail(command) | render_state_detail(state) << 8;
	return (detail & 0xff) > 0 ? stilb_hash_fnv1a64(hash, &detail, sizeof detail) : hash;
}

static_assert(sizeof(stilb_render_shading) == 8 * sizeof(uint32_t), "hashed as it is: no padding");

static uint64_t hash_view(uint64_t hash, const stilb_render *render, const render_pass_lists *lists, bool panorama)
{
	const render_memory *memory = &render->memory[RENDER_MEMORY_LIGHTS];
	hash = stilb_hash_fnv1a64(hash, &lists->shading, sizeof lists->shading);
	hash = stilb_hash_fnv1a64(hash, lists->sky, sizeof lists->sky);
	hash = stilb_hash_fnv1a64(hash, lists->ground, sizeof lists->ground);
	hash = stilb_hash_fnv1a64(hash, &lists->glossy, sizeof lists->glossy);
	hash = stilb_hash_fnv1a64(hash, &lists->both_sides, sizeof lists->both_sides);
	hash = stilb_hash_fnv1a64(hash, &lists->light_count, sizeof lists->light_count);
	if (panorama && lists->panorama != 0) {
		hash = stilb_hash_fnv1a64(hash, &lists->panorama, sizeof lists->panorama);
		hash = stilb_hash_fnv1a64(hash, &lists->rotation, sizeof lists->rotation);
	}
	if (lists->light_count == 0)
		return hash;
	STILB_ASSERT(lists->first_light + lists->light_count <= memory->capacity);
	const render_light *lights = (const render_light *)memory->data + lists->first_light;
	for (uint32_t l = 0; l < lists->light_count; l++) {
		render_light light = lights[l];
		light.kind = (float)((uint32_t)light.kind % RENDER_LIGHT_SHADOW); /* as without shadows */
		hash = stilb_hash_fnv1a64(hash, &light, sizeof light);
	}
	return hash;
}

/* Caller holds the lock of resources: other threads may create materials, which may move their heap. */
static uint64_t hash_passes(const stilb_render *render, bool panorama)
{
	uint64_t hash = STILB_FNV1A64_START;
	for (uint32_t i = 0; i < render->replayed_count; i++) {
		const render_pass_lists *lists = &render->passes[render->replayed[i]];
		if (lists->kind != STILB_RENDER_PASS_SCENE || lists->shadow)
			continue;
		hash = hash_view(hash, render, lists, panorama);
		for (uint32_t r = 0; r < lists->run_count; r++) {
			const render_run *run = &lists->runs[r];
			STILB_ASSERT(run->first + run->count <= render->memory[RENDER_MEMORY_COMMANDS].capacity);
			for (uint32_t c = run->first; c < run->first + run->count; c++) {
				const render_command *command = &render_commands(render)[c];
				hash = hash_draw(hash, &render->resources, command, render_row_of(render, command), run->state);
			}
		}
	}
	return hash;
}

static uint64_t hash_locked(const stilb_render *render, bool panorama)
{
	stilb_lock *lock = (stilb_lock *)&render->resources.lock;
	stilb_lock_take(lock);
	uint64_t hash = hash_passes(render, panorama);
	stilb_lock_give(lock);
	return hash;
}

uint64_t stilb_render_stream_hash(const stilb_render *render)
{
	STILB_ASSERT_OWNER(render->owner);
	return hash_locked(render, true);
}

uint64_t stilb_render_triangles(const stilb_render *render)
{
	STILB_ASSERT_OWNER(render->owner);
	uint64_t indices = 0;
	for (uint32_t i = 0; i < render->replayed_count; i++) {
		const render_pass_lists *lists = &render->passes[render->replayed[i]];
		for (uint32_t r = 0; lists->kind == STILB_RENDER_PASS_SCENE && r < lists->run_count; r++)
			for (uint32_t c = lists->runs[r].first; c < lists->runs[r].first + lists->runs[r].count; c++)
				indices += render_commands(render)[c].index_count;
	}
	return indices / 3;
}

uint64_t render_hash_plain(const stilb_render *render)
{
	return hash_locked(render, false);
}
