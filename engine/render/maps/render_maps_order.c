/* The order of draws with maps: those of a material together, so that its set is bound once; then those that light goes
 * through; and behind all others of their pass those that blend, from the farthest to the nearest. */
#include "render/render_internal.h"

#include <stdlib.h>
#include <string.h>

static bool blend_is(const stilb_render *render, const render_run *run)
{
	uint32_t both = RENDER_MAPS_BLEND | RENDER_MAPS_THROUGH;
	return run->state & RENDER_STATE_MAPS &&
	       (render->resources.maps[render_state_maps(run->state)].bits & both) == RENDER_MAPS_BLEND;
}

static bool through_is(const stilb_render *render, const render_run *run)
{
	return run->state & RENDER_STATE_MAPS &&
	       render->resources.maps[render_state_maps(run->state)].bits & RENDER_MAPS_THROUGH;
}

/* ---- together ---------------------------------------------------------------------------------------------------- */

/* The draws of the materials whose maps are opaque, in the order in which they come first. */
typedef struct group_plan {
	uint32_t *of;           /* [maps] by the maps' index: 1 + the group; 0: none so far */
	uint32_t *draws, *runs; /* [groups] how many, then where the next one goes */
	uint32_t count, capacity, run_capacity;
	uint32_t all_draws, all_runs;
} group_plan;

static bool group_is(const stilb_render *render, const render_run *run)
{
	return run->state & RENDER_STATE_MAPS && !blend_is(render, run);
}

/* False: no memory. */
static bool group_count(const stilb_render *render, const render_pass_lists *lists, group_plan *plan)
{
	for (uint32_t r = 0; r < lists->run_count; r++) {
		const render_run *run = &lists->runs[r];
		if (!group_is(render, run))
			continue;
		uint32_t *group = &plan->of[render_state_maps(run->state)];
		if (*group == 0) {
			if (!render_reserve((void **)&plan->draws, &plan->capacity, plan->count + 1, sizeof *plan->draws) ||
			    !render_reserve((void **)&plan->runs, &plan->run_capacity, plan->count + 1, sizeof *plan->runs))
				return false;
			plan->draws[plan->count] = plan->runs[plan->count] = 0;
			*group = ++plan->count;
		}
		plan->draws[*group - 1] += run->count;
		plan->runs[*group - 1]++;
		plan->all_draws += run->count;
		plan->all_runs++;
	}
	return true;
}

/* Turns counts into places. */
static void group_places(group_plan *plan)
{
	uint32_t draws = 0, runs = 0;
	for (uint32_t g = 0; g < plan->count; g++) {
		uint32_t d = plan->draws[g], r = plan->runs[g];
		plan->draws[g] = draws;
		plan->runs[g] = runs;
		draws += d;
		runs += r;
	}
}

/* Copies the groups' commands to the claim at `first`, and puts their runs behind the others'. moved: room for them. */
static void group_place(stilb_render *render, render_pass_lists *lists, group_plan *plan, uint32_t first,
                        render_run *moved)
{
	render_command *commands = render->memory[RENDER_MEMORY_COMMANDS].data;
	uint32_t kept = 0;
	STILB_ASSERT(plan->count > 0 && plan->draws && plan->runs);
	for (uint32_t r = 0; r < lists->run_count; r++) {
		render_run run = lists->runs[r];
		if (!group_is(render, &run)) {
			lists->runs[kept++] = run;
			continue;
		}
		uint32_t group = plan->of[render_state_maps(run.state)] - 1, to = first + plan->draws[group];
		memcpy(commands + to, commands + run.first, run.count * sizeof *commands);
		moved[plan->runs[group]++] = (render_run){to, run.count, run.state};
		plan->draws[group] += run.count;
	}
	lists->run_count = kept;
	for (uint32_t r = 0; r < plan->all_runs; r++) {
		render_run *last = r > 0 ? &lists->runs[lists->run_count - 1] : NULL;
		if (last && last->state == moved[r].state)
			last->count += moved[r].count;
		else
			lists->runs[lists->run_count++] = moved[r];
	}
}

/* Moves the draws of each material with opaque maps together, behind those without maps. */
static stilb_result group_order(stilb_render *render, render_pass_lists *lists)
{
	uint32_t first;
	stilb_lock_take(&render->resources.lock);
	uint32_t maps = render->resources.indices[RENDER_RESOURCE_MAPS].next_unused;
	stilb_lock_give(&render->resources.lock);
	group_plan plan = {.of = calloc((size_t)maps + 1, sizeof *plan.of)};
	render_run *moved = NULL;
	stilb_result result = STILB_OK;
	bool memory = plan.of && group_count(render, lists, &plan);
	bool gains = memory && plan.all_runs > plan.count;
	if (gains) {
		moved = stilb_memory_alloc(plan.all_runs, sizeof *moved);
		memory = moved;
	}
	if (!memory)
		result = stilb_fail(STILB_ERROR_MEMORY, "no memory for the order of draws with surfaces");
	else if (gains)
		result = render_sort_claim(render, plan.all_draws, &first);
	if (result == STILB_OK && gains) {
		group_places(&plan);
		group_place(render, lists, &plan, first, moved);
	}
	free(moved);
	free(plan.of);
	free(plan.draws);
	free(plan.runs);
	return result;
}

/* ---- what light goes through ------------------------------------------------------------------------------------- */

/* Moves their runs behind the others. */
static stilb_result through_order(const stilb_render *render, render_pass_lists *lists)
{
	uint32_t count = 0, kept = 0;
	for (uint32_t r = 0; r < lists->run_count; r++)
		count += through_is(render, &lists->runs[r]);
	if (count == 0 || count == lists->run_count)
		return STILB_OK;
	render_run *moved = stilb_memory_alloc(count, sizeof *moved);
	if (!moved)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the order of %u runs of draws with transmission", count);
	count = 0;
	for (uint32_t r = 0; r < lists->run_count; r++)
		if (through_is(render, &lists->runs[r]))
			moved[count++] = lists->runs[r];
		else
			lists->runs[kept++] = lists->runs[r];
	memcpy(lists->runs + kept, moved, count * sizeof *moved);
	free(moved);
	return STILB_OK;
}

/* ---- what blends ------------------------------------------------------------------------------------------------- */

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

/* How near the middle of a draw's mesh is: along the view, by the row of the matrix that gives its distance or, of a
 * parallel projection, its depth. */
static float blend_nearness(const stilb_render *render, const stilb_render_view *view, const render_row *row)
{
	const float *m = view->view_projection.m, *t = row->transform;
	const float *c = render->resources.centers[row->mesh];
	float place[3];
	for (int r = 0; r < 3; r++, t += 4)
		place[r] = t[0] * c[0] + t[1] * c[1] + t[2] * c[2] + t[3];
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

static stilb_result blend_order(stilb_render *render, const stilb_render_view *view, render_pass_lists *lists)
{
	uint64_t count = 0;
	for (uint32_t r = 0; r < lists->run_count; r++)
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

stilb_result render_maps_order(stilb_render *render, const stilb_render_view *view, bool sorted,
                               render_pass_lists *lists)
{
	stilb_result result = STILB_OK;
	if (!(lists->states & RENDER_STATE_MAPS))
		return STILB_OK;
	if (!sorted)
		result = group_order(render, lists);
	if (result == STILB_OK)
		result = through_order(render, lists);
	return result == STILB_OK && !render_view_is_depth(view) ? blend_order(render, view, lists) : result;
}
