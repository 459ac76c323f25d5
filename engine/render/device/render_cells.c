/* Lists of lights by compute (shaders/deferred/cells.comp): programs count the lights of each cell, find where its list
 * begins, and fill it. The CPU says which lights reach the view and in which slices (light/light_reached.h). How much
 * room lists need is known two frames later; where it was too little, pixels ask all lights, which gives the same sums,
 * and the frames after that have more. */
#include "render/render_internal.h"

#include <stdio.h>
#include <string.h>

/* Constants of these programs (shaders/deferred/cells.glsl). */
typedef struct render_cells_push {
	uint64_t lists, rows, counts;
	uint64_t cells, reached; /* stilb_light_cells and stilb_light_reached */
	uint32_t room, pass;
} render_cells_push;

static_assert(sizeof(render_cells_push) == 48, "std430");

void render_cells_read(render_device *device)
{
	render_slot *slot = render_slot_now(device);
	const uint32_t *pairs = slot->pairs.mapped;
	for (uint32_t p = 0; p < STILB_RENDER_MAX_PASSES; p++) {
		if (slot->counted[p])
			device->pairs[p] = pairs[p];
		slot->counted[p] = false;
	}
}

void render_cells_forget(render_device *device)
{
	memset(render_slot_now(device)->counted, 0, sizeof render_slot_now(device)->counted);
}

void render_cells_know(render_device *device, uint32_t pass, uint32_t pairs)
{
	device->pairs[pass] = pairs;
	for (uint32_t s = 0; s < STILB_GPU_FRAMES; s++)
		device->slots[s].counted[pass] = false;
}

uint32_t render_cells_room(render_device *device, uint32_t pass)
{
	uint64_t pairs = device->pairs[pass], room = device->rooms[pass];
	if (pairs == UINT32_MAX)
		return 0;
	if (room == 0 || room < pairs + pairs / 16 || room > pairs + pairs / 2 + 2048)
		room = pairs + pairs / 4 + 1024;
	device->rooms[pass] = room < UINT32_MAX ? (uint32_t)room : UINT32_MAX - 1;
	return device->rooms[pass] < device->most_room ? device->rooms[pass] : device->most_room;
}

/* Where the programs count pairs. *counts: its number in the plan. */
static stilb_result cells_counts(render_device *device, uint32_t pass, uint16_t *counts)
{
	render_slot *slot = render_slot_now(device);
	uint64_t bytes = STILB_RENDER_MAX_PASSES * sizeof(uint32_t);
	char name[STILB_GPU_MAX_NAME + 1];
	stilb_result result = STILB_OK;
	if (slot->pairs.bytes == 0) {
		result = render_buffer_make(device, "light pairs", bytes, STILB_GPU_MEMORY_READ, STILB_GPU_BUFFER_ADDRESS,
		                            &slot->pairs);
		if (result == STILB_OK && slot->pairs.mapped)
			memset(slot->pairs.mapped, 0xff, bytes); /* not known */
	}
	if (result != STILB_OK)
		return result;
	snprintf(name, sizeof name, "light pairs %u", device->slot);
	*counts = stilb_gpu_plan_find(device->plan, name);
	if (*counts == 0)
		*counts = stilb_gpu_plan_buffer(
			device->plan, &(stilb_gpu_plan_buffer_row){.name = name, .bytes = bytes, .owned = slot->pairs.buffer.id});
	slot->counted[pass] = true;
	return STILB_OK;
}

static uint16_t cells_buffer(render_device *device, const char *what, uint32_t pass, uint64_t bytes)
{
	char name[STILB_GPU_MAX_NAME + 1];
	snprintf(name, sizeof name, "%s %u", what, pass);
	return stilb_gpu_plan_buffer(device->plan, &(stilb_gpu_plan_buffer_row){.name = name, .bytes = bytes});
}

stilb_result render_cells_make(render_device *device, const render_stream *stream)
{
	static const char *const names[RENDER_CELLS_PASSES] = {"light lists count", "light lists sum", "light lists fill"};
	const render_view_lights *lights = &stream->lights;
	render_frame *frame = &device->frame;
	frame->light_lists = 0;
	if (lights->cells == 0)
		return STILB_OK;
	uint32_t columns = lights->grid[0] & 0xffffu, rows = lights->grid[0] >> 16, slices = lights->grid[1] >> 8;
	uint32_t pass = lights->cells - 1;
	uint64_t memory = render_slot_now(device)->memory[RENDER_MEMORY_LIGHT_LISTS].address;
	uint64_t words = (uint64_t)columns * rows * slices + 1 + (lights->count - lights->everywhere) + lights->list_ids;
	uint16_t counts;
	stilb_result result = render_programs_cells(device);
	if (result == STILB_OK)
		result = cells_counts(device, pass, &counts);
	if (result != STILB_OK)
		return result;
	frame->light_lists =
		cells_buffer(device, "light lists", pass, sizeof(render_light_lists) + words * sizeof(uint32_t));
	uint16_t sums = cells_buffer(device, "light rows", pass, ((uint64_t)rows * slices + 1) * sizeof(uint32_t));
	render_cells_push push = {.cells = memory + lights->lists * sizeof(float[4]),
	                          .reached = memory + lights->reached * sizeof(float[4]),
	                          .room = lights->list_ids,
	                          .pass = pass};
	for (int p = 0; p < RENDER_CELLS_PASSES; p++) {
		bool sum = p == RENDER_CELLS_SUM, fill = p == RENDER_CELLS_FILL;
		stilb_gpu_pass row = {
			.name = names[p],
			.kind = STILB_GPU_PASS_DISPATCH,
			.program = device->programs.cells[p].id,
			.groups = {sum ? 1 : rows, sum ? 1 : slices, 1},
			.uses = {{.resource = sums,
		              .how = fill  ? STILB_GPU_USE_STORAGE_READ
		                     : sum ? STILB_GPU_USE_STORAGE
		                           : STILB_GPU_USE_STORAGE_WRITE,
		              .slot = offsetof(render_cells_push, rows)},
		             {.resource = sum ? counts : frame->light_lists,
		              .how = fill ? STILB_GPU_USE_STORAGE : STILB_GPU_USE_STORAGE_WRITE,
		              .slot = sum ? offsetof(render_cells_push, counts) : offsetof(render_cells_push, lists)}},
			.use_count = 2,
			.constant_bytes = sizeof push,
		};
		memcpy(row.constants, &push, sizeof push);
		stilb_gpu_plan_pass(device->plan, &row);
	}
	return STILB_OK;
}

void render_cells_use(const render_device *device, uint16_t slot, stilb_gpu_pass *row)
{
	if (device->frame.light_lists != 0)
		row->uses[row->use_count++] =
			(stilb_gpu_use){.resource = device->frame.light_lists, .how = STILB_GPU_USE_STORAGE_READ, .slot = slot};
}
