/* Sorts the draws of a pass by key: a radix sort from the lowest digit up. It is stable, so draws with equal keys stay
 * in the order of their segments. Bits that all keys share, below, above and in whole digits between, are skipped. */
#include "render/render_internal.h"

#include <stdlib.h>
#include <string.h>

typedef struct sort_item {
	uint64_t key;
	uint32_t command; /* index among the frame's commands */
	uint32_t texture; /* index of the material's texture when the draw was recorded; it may be destroyed by now; and
	                     above it the state's bits of detail and mesh */
} sort_item;

/* Digits have at most 8 bits, and at most 12 when there are so many items that fewer passes are worth a larger table,
 * and so few that 4,096 places to write to stay within the second cache and the translation buffer. */
enum { SORT_NARROW_BITS = 8, SORT_WIDE_BITS = 12, SORT_WIDE_MIN = 8192, SORT_WIDE_MAX = 1 << 18 };

/* One stable pass: orders count items by the `bits` bits of their keys from `shift` on, into `to`. */
static void sort_pass(const sort_item *from, sort_item *to, uint32_t count, uint32_t shift, uint32_t bits)
{
	STILB_ASSERT(bits > 0 && bits <= SORT_WIDE_BITS && shift + bits <= 64);
	uint32_t place[1 << SORT_WIDE_BITS], mask = (1u << bits) - 1, sum = 0;
	memset(place, 0, sizeof *place << bits);
	for (uint32_t i = 0; i < count; i++)
		place[from[i].key >> shift & mask]++;
	for (uint32_t digit = 0; digit <= mask; digit++) {
		uint32_t here = place[digit];
		place[digit] = sum;
		sum += here;
	}
	for (uint32_t i = 0; i < count; i++)
		to[place[from[i].key >> shift & mask]++] = from[i];
}

/* Sorts count items by ascending key; scratch has as many. Returns the array that holds the result: items or
 * scratch. */
static sort_item *sort_items(sort_item *items, sort_item *scratch, uint32_t count)
{
	STILB_ASSERT(count > 0 && items && scratch && items != scratch);
	uint64_t differing = 0;
	for (uint32_t i = 1; i < count; i++)
		differing |= items[i].key ^ items[0].key;
	if (differing == 0)
		return items;
	uint32_t shift = (uint32_t)__builtin_ctzll(differing), end = 64 - (uint32_t)__builtin_clzll(differing);
	bool wide = count >= SORT_WIDE_MIN && count <= SORT_WIDE_MAX;
	uint32_t limit = wide ? SORT_WIDE_BITS : SORT_NARROW_BITS;
	uint32_t passes = (end - shift + limit - 1) / limit;
	for (; passes > 0; passes--) {
		uint32_t bits = (end - shift + passes - 1) / passes;
		if (differing >> shift & ((1u << bits) - 1)) {
			sort_pass(items, scratch, count, shift, bits);
			sort_item *sorted = scratch;
			scratch = items;
			items = sorted;
		}
		shift += bits;
	}
	return items;
}

#define SORT_DETAIL_SHIFT 24u /* in sort_item.texture */

/* The state's bits RENDER_STATE_DETAIL and _MESH, moved to the lowest places. */
static uint32_t sort_detail(uint64_t state)
{
	return (uint32_t)((state & (RENDER_STATE_DETAIL | RENDER_STATE_MESH)) / RENDER_STATE_FADE);
}

/* Lists the pass's draws in recorded order. */
static void sort_gather(const render_command *commands, const render_pass_lists *lists, sort_item *items)
{
	for (const render_run *run = lists->runs; run < lists->runs + lists->run_count; run++)
		for (uint32_t c = run->first; c < run->first + run->count; c++)
			*items++ = (sort_item){commands[c].key, c,
			                       render_state_entry(run->state) | sort_detail(run->state) << SORT_DETAIL_SHIFT};
}

stilb_result render_sort_claim(stilb_render *render, uint32_t count, uint32_t *first)
{
	render_memory *memory = &render->memory[RENDER_MEMORY_COMMANDS];
	/* Relaxed: no worker records any more. */
	uint64_t claimed = atomic_load_explicit(&memory->next, memory_order_relaxed), wanted = claimed + count;
	if (wanted > UINT32_MAX)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for sorting %u draws", count);
	*first = (uint32_t)claimed;
	atomic_store_explicit(&memory->next, (uint32_t)wanted, memory_order_relaxed);
	if (wanted <= memory->capacity)
		return STILB_OK;
	return render_device_grow(render->device, memory, RENDER_MEMORY_COMMANDS, (uint32_t)wanted, (uint32_t)claimed);
}

/* Copies the pass's commands to the claim at `first` in their new order, and makes its runs anew. False: no memory. */
static bool sort_place(stilb_render *render, render_pass_lists *lists, const sort_item *items, uint32_t first)
{
	render_command *commands = render->memory[RENDER_MEMORY_COMMANDS].data;
	uint32_t mask = render_material_mask(render->device->materials), count = (uint32_t)lists->draws;
	render_run *run = NULL;
	STILB_ASSERT((uint64_t)first + count <= render->memory[RENDER_MEMORY_COMMANDS].capacity);
	lists->run_count = 0;
	for (uint32_t i = 0; i < count; i++) {
		STILB_ASSERT(items[i].command < first && (i == 0 || items[i - 1].key <= items[i].key));
		const render_command *command = &commands[items[i].command];
		uint64_t detail = (items[i].texture >> SORT_DETAIL_SHIFT) * RENDER_STATE_FADE;
		uint64_t state = render_state(items[i].texture, command->material, mask) | detail;
		commands[first + i] = *command;
		if (!run || run->state != state) {
			if (!render_reserve((void **)&lists->runs, &lists->run_capacity, lists->run_count + 1, sizeof *run))
				return false;
			run = &lists->runs[lists->run_count++];
			*run = (render_run){first + i, 0, state};
		}
		run->count++;
	}
	return true;
}

/* Scratch memory for at least count items, kept from frame to frame; NULL: no memory. */
static sort_item *sort_scratch(stilb_render *render, uint64_t count)
{
	if (count > render->sort_capacity) {
		free(render->sort_items);
		render->sort_items = stilb_memory_alloc(count, sizeof(sort_item));
		render->sort_capacity = render->sort_items ? count : 0;
	}
	return render->sort_items;
}

stilb_result render_sort(stilb_render *render, render_pass_lists *lists)
{
	STILB_ASSERT(lists->state == RENDER_LIST_CLOSED && lists->draws <= UINT32_MAX);
	if (lists->draws == 0)
		return STILB_OK;
	uint32_t first = 0;
	stilb_result result = render_sort_claim(render, (uint32_t)lists->draws, &first);
	if (result != STILB_OK)
		return result;
	sort_item *items = sort_scratch(render, 2 * lists->draws);
	if (!items)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for sorting %u draws", (uint32_t)lists->draws);
	sort_gather(render_commands(render), lists, items);
	const sort_item *sorted = sort_items(items, items + lists->draws, (uint32_t)lists->draws);
	return sort_place(render, lists, sorted, first)
	           ? STILB_OK
	           : stilb_fail(STILB_ERROR_MEMORY, "no memory for the runs of a sorted pass");
}
