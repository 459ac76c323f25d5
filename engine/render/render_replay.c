/* Replay: the segments in number order, on the main thread. */
#include "render/render_internal.h"

/* Calls visit for each run of commands that lie together, in the order of the stream. */
typedef void replay_visit(void *user, const render_command *commands, uint32_t count);

static void replay_segment(const render_segment *segment, replay_visit *visit, void *user)
{
	uint32_t block = segment->block, first = segment->first, left = segment->count;
	while (left > 0) {
		uint32_t here = RENDER_BLOCK_COMMANDS - first;
		here = here < left ? here : left;
		if (here > 0)
			visit(user, segment->context->blocks[block]->commands + first, here);
		left -= here;
		first = 0;
		block++;
	}
}

static void replay_pass(const render_pass_lists *lists, replay_visit *visit, void *user)
{
	for (uint32_t s = 0; s < lists->segment_count; s++) {
		STILB_ASSERT(lists->segments[s].context); /* every segment is recorded, an empty one too */
		replay_segment(&lists->segments[s], visit, user);
	}
}

static uint64_t replay_count(const render_pass_lists *lists)
{
	uint64_t count = 0;
	for (uint32_t s = 0; s < lists->segment_count; s++)
		count += lists->segments[s].count;
	return count;
}

static void replay_to_device(void *user, const render_command *commands, uint32_t count)
{
	render_device *device = user;
	device->functions->draws(device, commands, count);
}

/* The pass with the lowest order that comes after `after`; equal orders keep the table's sequence. */
static const stilb_render_pass *replay_next_pass(const stilb_render_pass *passes, uint32_t count,
                                                 const stilb_render_pass *after)
{
	const stilb_render_pass *next = NULL;
	for (const stilb_render_pass *p = passes; p < passes + count; p++) {
		bool later = !after || p->order > after->order || (p->order == after->order && p > after);
		if (later && (!next || p->order < next->order))
			next = p;
	}
	return next;
}

stilb_result stilb_render_replay(stilb_render *render, const stilb_render_pass *passes, uint32_t pass_count,
                                 const stilb_render_view *views, uint32_t view_count)
{
	(void)view_count;
	STILB_ASSERT(pass_count >= 1 && pass_count <= STILB_RENDER_MAX_PASSES && render->replayed_count == 0);
	render_device *device = render->device;
	stilb_result result = render_rows_place(render);
	device->stats.draws = device->stats.draw_commands = device->stats.indirect_commands = 0;
	const stilb_render_pass *pass = NULL;
	while (result == STILB_OK && (pass = replay_next_pass(passes, pass_count, pass))) {
		render_pass_lists *lists = &render->passes[pass - passes];
		STILB_ASSERT(lists->state == RENDER_LIST_CLOSED && pass->view < view_count);
		uint64_t draws = replay_count(lists);
		result = device->functions->pass_begin(device, pass, &views[pass->view], draws);
		if (result != STILB_OK)
			return result;
		replay_pass(lists, replay_to_device, device);
		device->functions->pass_end(device);
		device->stats.draws += draws;
		render->replayed[render->replayed_count++] = (uint32_t)(pass - passes);
	}
	return result == STILB_OK ? device->functions->submit(device) : result;
}

void render_write_indirect(render_indirect *indirect, const render_command *commands, uint32_t count)
{
	for (uint32_t i = 0; i < count; i++)
		indirect[i] = (render_indirect){
			.index_count = commands[i].index_count,
			.instance_count = 1,
			.first_index = commands[i].first_index,
			.vertex_offset = commands[i].vertex_offset,
			.first_instance = commands[i].row,
		};
}

/* ---- the hash of the stream ---------------------------------------------------------------------------------------- */

typedef struct replay_hash {
	const stilb_render *render;
	uint64_t value;
} replay_hash;

static void replay_hash_draws(void *user, const render_command *commands, uint32_t count)
{
	replay_hash *hash = user;
	for (uint32_t i = 0; i < count; i++) {
		const render_row *row = render_row_at(hash->render, commands[i].row);
		float transform[16] = {[15] = 1.0f};
		for (int r = 0; r < 3; r++)
			for (int c = 0; c < 4; c++)
				transform[4 * c + r] = row->transform[4 * r + c];
		const uint32_t ids[2] = {commands[i].mesh, commands[i].material};
		hash->value = stilb_hash_fnv1a64(hash->value, ids, sizeof ids);
		hash->value = stilb_hash_fnv1a64(hash->value, transform, sizeof transform);
		hash->value = stilb_hash_fnv1a64(hash->value, &commands[i].index_count, sizeof commands[i].index_count);
	}
}

uint64_t stilb_render_stream_hash(const stilb_render *render)
{
	replay_hash hash = {render, STILB_FNV1A64_START};
	for (uint32_t i = 0; i < render->replayed_count; i++)
		replay_pass(&render->passes[render->replayed[i]], replay_hash_draws, &hash);
	return hash.value;
}
