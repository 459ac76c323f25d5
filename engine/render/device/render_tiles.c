/* Which lights reach what is seen, once its depth is there: lists of tiles and places of pixels, made by compute from
 * the lists of cells (shaders/deferred/tiles.comp, indices.comp). What they leave out sends nothing. */
#include "render/render_internal.h"

#include <math.h>
#include <string.h>

/* Constants of those programs. */
typedef struct render_tiles_push {
	render_view_push view;
	uint64_t out;
	float tolerance; /* of RENDER_TILES_GLOSS, W sr^-1 m^-2 */
	uint32_t padding;
} render_tiles_push;

#define TILES_HEADER 32u /* bytes of either buffer before what it has for each tile or pixel */
#define INDICES_HEADER 16u
#define INDICES_PIXEL 16u /* bytes */
#define INDICES_GROUP 8u  /* pixels of a group's sides */

static_assert(TILES_HEADER == sizeof(render_light_lists), "programs read lists of tiles as those of cells");

/* The buffer that a group of the pass fills. */
static uint16_t tiles_buffer(render_device *device, render_frame_target *target, const render_view_lights *lights,
                             bool indexed)
{
	char name[STILB_GPU_MAX_NAME + 1];
	uint64_t tiles = (uint64_t)(lights->grid[0] & 0xffffu) * (lights->grid[0] >> 16);
	uint64_t bytes = TILES_HEADER + (2 * tiles + lights->list_ids) * sizeof(uint32_t);
	if (lights->cells > 0)
		bytes += (uint64_t)(lights->count - lights->everywhere) * sizeof(uint32_t);
	if (indexed)
		bytes = INDICES_HEADER + (uint64_t)target->width * target->height * INDICES_PIXEL;
	render_target_name(target, indexed ? "light indices" : "tiles", name);
	return stilb_gpu_plan_buffer(device->plan, &(stilb_gpu_plan_buffer_row){.name = name, .bytes = bytes});
}

stilb_result render_tiles_make(render_device *device, const render_stream *stream, render_frame_target *target,
                               const render_push *push, stilb_gpu_use *use)
{
	const render_view_lights *lights = &stream->lights;
	render_way way = render_view_way(device, stream->view);
	render_tiles kind = render_view_tiles(device, stream->view);
	stilb_gpu_program program;
	STILB_ASSERT(lights->bits & RENDER_LIGHTS_LISTS && (way.tiles || way.indexed));
	stilb_result result = render_programs_tiles_of(device, stream->view, lights->bits, &program);
	if (result != STILB_OK)
		return result;
	uint16_t buffer = tiles_buffer(device, target, lights, way.indexed);
	stilb_gpu_pass row = {
		.name = way.indexed ? "light indices" : "tiles",
		.kind = STILB_GPU_PASS_DISPATCH,
		.program = program.id,
		.groups = {lights->grid[0] & 0xffffu, lights->grid[0] >> 16, 1},
		.uses = {{.resource = target->depth, .how = STILB_GPU_USE_SAMPLED},
	             {.resource = buffer,
	              .how = STILB_GPU_USE_STORAGE_WRITE,
	              .slot = (uint16_t)offsetof(render_tiles_push, out)},
	             {.resource = target->surfaces[0], .how = STILB_GPU_USE_SAMPLED, .slot = 1},
	             {.resource = target->surfaces[1], .how = STILB_GPU_USE_SAMPLED, .slot = 2}},
		.use_count = kind == RENDER_TILES_GLOSS     ? 4
	                 : kind == RENDER_TILES_NORMALS ? 3
	                                                : 2,
		.constant_bytes = sizeof(render_tiles_push),
	};
	if (way.indexed) {
		row.groups[0] = (target->width + INDICES_GROUP - 1) / INDICES_GROUP;
		row.groups[1] = (target->height + INDICES_GROUP - 1) / INDICES_GROUP;
	}
	render_tiles_push own = {.view = push->view,
	                         .tolerance = stream->view->light_tolerance * exp2f(-stream->view->exposure)};
	memcpy(row.constants, &own, sizeof own);
	render_cells_use(device, (uint16_t)offsetof(render_tiles_push, view.lists), &row);
	stilb_gpu_plan_pass(device->plan, &row);
	*use = (stilb_gpu_use){
		.resource = buffer, .how = STILB_GPU_USE_STORAGE_READ, .slot = (uint16_t)offsetof(render_push, view.lists)};
	return STILB_OK;
}
