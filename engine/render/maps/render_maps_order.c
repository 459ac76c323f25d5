/* The order of draws with maps: those of a class of groups together (render_groups.h), so that their images are bound
 * once; then those that light goes through; and behind all others of their pass those that blend, from the farthest to
 * the nearest. */
#include "render/render_internal.h"

#include <stdlib.h>
#include <string.h>

/* The entry of a run with maps in render_resources.group_classes. */
static uint32_t entry_of(const stilb_render *render, const render_run *run)
{
	return render->resources.group_classes[render_state_group(run->state)];
}

static bool blend_is(const stilb_render *render, const render_run *run)
{
	return run->state & RENDER_STATE_MAPS && entry_of(render, run) & RENDER_CLASS_BLENDS;
}

static bool through_is(const stilb_render *render, const render_run *run)
{
	return run->state & RENDER_STATE_MAPS &&
	       render_group_of(&render->resources, render_state_group(run->state))->key.bits & RENDER_MAPS_THROUGH;
}

/* ---- together ---------------------------------------------------------------------------------------------------- */

/* The place of a class in order->classes, where it is entered if it is new. UINT32_MAX: no memory. */
static uint32_t class_enter(render_order_memory *order, uint32_t class)
{
	if (!render_reserve((void **)&order->classes, &order->capacity, order->count + 1, sizeof *order->classes))
		return UINT32_MAX;
	order->classes[order->count] = (render_order_class){.class = class};
	order->places[class] = ++order->count;
	return order->count - 1;
}

/* Counts the draws of each class, in the order in which classes come first, and the stretches of draws that
 * are not interrupted by draws of another class or without maps. Notes the class of each run. False: no memory. */
static bool class_count(const stilb_render *render, const render_pass_lists *lists, render_order_memory *order)
{
	/* Copies: what is written below may be them, for all the compiler knows. */
	const uint32_t *places = order->places, *entries = render->resources.group_classes;
	const render_run *runs = lists->runs;
	uint32_t *of = order->of, last = UINT32_MAX, run_count = lists->run_count, draws = 0, moved = 0, stretches = 0;
	render_order_class *classes = order->classes;
	order->count = 0;
	for (uint32_t r = 0; r < run_count; r++) {
		uint64_t state = runs[r].state;
		uint32_t class = state & RENDER_STATE_MAPS ? entries[render_state_group(state)] : RENDER_CLASS_BLENDS;
		if (class & RENDER_CLASS_BLENDS) { /* or without maps: it is not put together with others */
			last = of[r] = UINT32_MAX;
			continue;
		}
		uint32_t place = places[class] - 1;
		if (place == UINT32_MAX) {
			place = class_enter(order, class);
			classes = order->classes;
		}
		if (place == UINT32_MAX)
			return false;
		classes[place].draws += runs[r].count; /* what else is counted here costs half a nanosecond a draw */
		of[r] = place;
		draws += runs[r].count;
		moved++;
		stretches += place != last;
		last = place;
	}
	order->draws = draws;
	order->runs = moved;
	order->stretches = stretches;
	return true;
}

/* Turns counts into places. */
static void class_places(render_order_memory *order)
{
	uint32_t draws = 0;
	for (uint32_t c = 0; c < order->count; c++) {
		uint32_t count = order->classes[c].draws;
		order->classes[c].draws = draws;
		draws += count;
	}
}

/* A run of a class is complete: draws up to `end`. */
static void class_close(render_order_memory *order, render_order_class *class, uint32_t end)
{
	render_run run = class->open;
	run.count = end - run.first;
	order->moved[order->moved_count++] = (render_order_run){run, 0};
	if (class->last > 0)
		order->moved[class->last - 1].next = order->moved_count;
	else
		class->first = order->moved_count;
	class->last = order->moved_count;
}

/* Copies the classes' commands to the claim at `first`, and puts their runs behind the others'; those of one state that
 * follow one another become one. */
static void class_place(stilb_render *render, render_pass_lists *lists, render_order_memory *order, uint32_t first)
{
	render_command *commands = render->memory[RENDER_MEMORY_COMMANDS].data;
	uint32_t kept = 0, run_count = lists->run_count;
	const uint32_t *of = order->of;
	render_order_class *classes = order->classes;
	order->moved_count = 0;
	for (uint32_t r = 0; r < run_count; r++) {
		render_run run = lists->runs[r];
		if (of[r] == UINT32_MAX) {
			lists->runs[kept++] = run;
			continue;
		}
		render_order_class *class = &classes[of[r]];
		uint32_t to = first + class->draws;
		for (uint32_t c = 0; c < run.count; c++) /* mostly one */
			commands[to + c] = commands[run.first + c];
		class->draws += run.count;
		if (class->open.state == run.state)
			continue;
		if (class->open.state != 0)
			class_close(order, class, to);
		class->open = (render_run){to, 0, run.state};
	}
	for (uint32_t c = 0; c < order->count; c++) {
		class_close(order, &classes[c], first + classes[c].draws);
		for (uint32_t r = classes[c].first; r > 0; r = order->moved[r - 1].next)
			lists->runs[kept++] = order->moved[r - 1].run;
	}
	lists->run_count = kept;
}

/* Moves the draws of each class of opaque maps together, behind those without maps. */
static stilb_result class_order(stilb_render *render, render_pass_lists *lists)
{
	render_order_memory *order = &render->order;
	stilb_lock_take(&render->resources.lock);
	uint32_t classes = render->resources.indices[RENDER_RESOURCE_CLASS].next_unused, before = order->place_capacity;
	stilb_lock_give(&render->resources.lock);
	uint32_t first;
	stilb_result result = STILB_OK;
	bool memory = render_reserve((void **)&order->places, &order->place_capacity, classes, sizeof *order->places);
	for (uint32_t p = before; p < order->place_capacity && memory; p++)
		order->places[p] = 0;
	order->count = 0;
	memory = memory && render_reserve((void **)&order->of, &order->of_capacity, lists->run_count, sizeof *order->of);
	memory = memory && class_count(render, lists, order);
	bool gains = memory && order->stretches > order->count; /* which images textures have got has no say in it */
	if (gains)
		memory = render_reserve((void **)&order->moved, &order->moved_capacity, order->runs, sizeof *order->moved);
	if (!memory)
		result = stilb_fail(STILB_ERROR_MEMORY, "no memory for the order of draws with surfaces");
	else if (gains)
		result = render_sort_claim(render, order->draws, &first);
	if (result == STILB_OK && gains) {
		class_places(order);
		class_place(render, lists, order, first);
	}
	for (uint32_t c = 0; c < order->count; c++)
		order->places[order->classes[c].class] = 0;
	return result;
}

void render_order_finish(render_order_memory *order)
{
	free(order->places);
	free(order->classes);
	free(order->moved);
	free(order->of);
	free(order->items);
	*order = (render_order_memory){0};
}

/* ---- what light goes through ------------------------------------------------------------------------------------- */

/* Moves their runs behind the others. */
static stilb_result through_order(const stilb_render *render, render_pass_lists *lists)
{
	uint32_t count = 0, kept = 0;
	for (uint32_t r = 0; render->device->through > 0 && r < lists->run_count; r++)
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

/* Farthest first. What is equally far follows the names, and these the order of recording. */
static int blend_compare(const void *left, const void *right)
{
	const render_blend_item *a = left, *b = right;
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
static float blend_nearness(stilb_render *render, const stilb_render_view *view, const render_row *row)
{
	const float *m = view->view_projection.m, *t = row->transform;
	const float *c = render_mesh_center(&render->resources, row->mesh);
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
static uint32_t blend_take(stilb_render *render, const stilb_render_view *view, render_pass_lists *lists,
                           render_blend_item *items)
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
			items[count] = (render_blend_item){.nearness = blend_nearness(render, view, row),
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
static void blend_place(stilb_render *render, render_pass_lists *lists, const render_blend_item *items, uint32_t count,
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
	if (result != STILB_OK)
		return result;
	render_order_memory *order = &render->order;
	if (!render_reserve((void **)&order->items, &order->item_capacity, (uint32_t)count, sizeof *order->items))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the order of %llu draws that blend",
		                  (unsigned long long)count);
	stilb_lock_take(&render->resources.lock); /* other threads' new materials may move their heap */
	blend_take(render, view, lists, order->items);
	stilb_lock_give(&render->resources.lock);
	qsort(order->items, count, sizeof *order->items, blend_compare);
	blend_place(render, lists, order->items, (uint32_t)count, first);
	return STILB_OK;
}

stilb_result render_maps_order(stilb_render *render, const stilb_render_view *view, bool sorted,
                               render_pass_lists *lists)
{
	stilb_result result = STILB_OK;
	if (!(lists->states & RENDER_STATE_MAPS))
		return STILB_OK;
	if (!sorted)
		result = class_order(render, lists);
	if (result == STILB_OK)
		result = through_order(render, lists);
	return result == STILB_OK && !render_view_is_depth(view) ? blend_order(render, view, lists) : result;
}
