/* The order of draws that blend: behind all others of their pass, from the farthest to the nearest. */
#include "render/render_internal.h"

#include <stdlib.h>
#include <string.h>

typedef struct blend_item {
	float nearness;          /* larger: nearer */
	uint32_t material, mesh; /* names */
	uint32_t place;          /* in the order of recording */
	uint32_t command;        /* index among the frame's commands */
	uint64_t state;
} blend_item;

/* Farthest first. What is equally far follows the names, and these the order of recording. */
static int blend_compare(const void *left, const void *right)
{
	const blend_item *a = left, *b = right;
	if (a->nearness != b->nearness)
		return a->nearness < b->nearness ? -1 : 1;
	if (a->material != b->material)
		return a->material < b->material ? -1 : 1;
	if (a->mesh != b->mesh)
		return a->mesh < b->mesh ? -1 : 1;
	return a->place < b->place ? -1 : a->place > b->place;
}

static bool blend_is(const stilb_render *render, const render_run *run)
{
	return run->state & RENDER_STATE_MAPS &&
	       render->resources.maps[render_state_maps(run->state)].bits & RENDER_MAPS_BLEND;
}

/* How near the middle of a draw's mesh is: along the view, by the row of the matrix that gives its distance or, of a
 * parallel projection, its depth. */
static float blend_nearness(const stilb_render *render, const stilb_render_view *view, const render_row *row)
{
	const float *m = view->view_projection.m, *t = row->transform;
	const float *c = render->resources.centers[row->mesh];
	float place[3];
	for (int r = 0; r < 3; r++)
		place[r] = t[4 * r] * c[0] + t[4 * r + 1] * c[1] + t[4 * r + 2] * c[2] + t[4 * r + 3];
	bool parallel = m[3] == 0.0f && m[7] == 0.0f && m[11] == 0.0f;
	int from = parallel ? 2 : 3;
	float value = m[from] * place[0] + m[4 + from] * place[1] + m[8 + from] * place[2] + m[12 + from];
	float nearness = parallel ? value : -value;
	return nearness == nearness ? nearness : 0.0f; /* NaN has no order */
}

/* Lists the draws that blend, and leaves the other runs in `lists`. Returns how many there are. */
static uint32_t blend_take(const stilb_render *render, const stilb_render_view *view, render_pass_lists *lists,
                           blend_item *items)
{
	const render_material *materials = (const render_material *)render->resources.heaps[RENDER_HEAP_MATERIALS].data;
	uint32_t count = 0, kept = 0;
	for (uint32_t r = 0; r < lists->run_count; r++) {
		render_run run = lists->runs[r];
		if (!blend_is(render, &run)) {
			lists->runs[kept++] = run;
			continue;
		}
		for (uint32_t c = run.first; c < run.first + run.count; c++, count++) {
			const render_command *command = &render_commands(render)[c];
			const render_row *row = render_row_of(render, command);
			items[count] = (blend_item){.nearness = blend_nearness(render, view, row),
			                            .material = materials[command->material].name,
			                            .mesh = render->resources.meshes[row->mesh].name,
			                            .place = count,
			                            .command = c,
			                            .state = run.state};
		}
	}
	lists->run_count = kept;
	return count;
}

/* Copies the commands to the claim at `first` and makes their runs. */
static void blend_place(stilb_render *render, render_pass_lists *lists, const blend_item *items, uint32_t count,
                        uint32_t first)
{
	render_command *commands = render->memory[RENDER_MEMORY_COMMANDS].data;
	render_run *run = NULL;
	for (uint32_t i = 0; i < count; i++) {
		commands[first + i] = commands[items[i].command];
		if (!run || run->state != items[i].state) {
			run = &lists->runs[lists->run_count++];
			*run = (render_run){first + i, 0, items[i].state};
		}
		run->count++;
	}
}

stilb_result render_blend_order(stilb_render *render, const stilb_render_view *view, render_pass_lists *lists)
{
	uint64_t count = 0;
	for (uint32_t r = 0; lists->states & RENDER_STATE_MAPS && r < lists->run_count; r++)
		count += blend_is(render, &lists->runs[r]) ? lists->runs[r].count : 0;
	if (count == 0)
		return STILB_OK;
	uint32_t first;
	if (count > UINT32_MAX - lists->run_count ||
	    !render_reserve((void **)&lists->runs, &lists->run_capacity, lists->run_count + (uint32_t)count,
	                    sizeof *lists->runs))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the order of %llu draws that blend",
		                  (unsigned long long)count);
	stilb_result result = render_sort_claim(render, (uint32_t)count, &first);
	blend_item *items = result == STILB_OK ? stilb_memory_alloc(count, sizeof *items) : NULL;
	if (result != STILB_OK)
		return result;
	if (!items)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the order of %llu draws that blend",
		                  (unsigned long long)count);
	stilb_lock_take(&render->resources.lock); /* other threads' new materials may move their heap */
	blend_take(render, view, lists, items);
	stilb_lock_give(&render->resources.lock);
	qsort(items, count, sizeof *items, blend_compare);
	blend_place(render, lists, items, (uint32_t)count, first);
	free(items);
	return STILB_OK;
}
