/* A simulated GPU: stands between render and the null device and keeps everything that a GPU would have got. A
 * draw must find its mesh, material and texture there, and so must the draws of the frames that are still in flight.
 *
 * Things to draw with tell who they are: mesh, material and texture number n hold n in every vertex, in a colour, in
 * the pixels; and a draw holds the number in its translation. */
#ifndef RENDER_GPU_H
#define RENDER_GPU_H

#include "support/render_fixture.h"

#define GPU_THING_MOST_VERTICES 40u

/* A mesh, a material and its texture. */
typedef struct gpu_thing {
	stilb_render_mesh mesh;
	stilb_render_material material;
	stilb_render_texture texture;
	uint32_t number;
} gpu_thing;

/* A draw of a submitted frame. */
typedef struct gpu_draw {
	render_command command;
	uint64_t image; /* stilb_gpu_image.id of its texture */
	uint32_t number;
} gpu_draw;

typedef struct gpu_frame {
	gpu_draw *draws;
	uint32_t count, capacity;
} gpu_frame;

#define GPU_IMAGES 65536u

static struct {
	gpu_functions functions;
	const gpu_functions *real;
	const stilb_render *render;
	stilb_gpu *device;
	uint8_t *heaps[RENDER_HEAPS];
	uint64_t heap_bytes[RENDER_HEAPS];
	struct {
		uint64_t id;
		uint32_t pixel; /* the first one */
	} images[GPU_IMAGES];
	gpu_frame frames[STILB_GPU_FRAMES];
	uint32_t frame;
	_Atomic stilb_result texture_result; /* of the next image that is made, on whatever thread */
	bool losing;                         /* the frame does not run */
	uint64_t draws_seen;
	uint32_t wrong; /* draws whose mesh, material or texture was not there */
} gpu;

/* ---- things ----------------------------------------------------------------------------------------------------- */

static inline uint32_t gpu_thing_vertices(uint32_t number)
{
	return 3 + number * 7 % (GPU_THING_MOST_VERTICES - 2);
}

static inline uint32_t gpu_thing_indices(uint32_t number)
{
	return 3 * (1 + number * 5 % 20);
}

static inline uint32_t gpu_thing_index(uint32_t number, uint32_t i)
{
	return (number + i) % gpu_thing_vertices(number);
}

static inline stilb_result gpu_mesh_create(stilb_render *render, uint32_t number, stilb_render_mesh *mesh)
{
	stilb_scene_vertex vertices[GPU_THING_MOST_VERTICES] = {0};
	uint32_t indices[60];
	for (uint32_t v = 0; v < gpu_thing_vertices(number); v++)
		vertices[v] = (stilb_scene_vertex){.position = {(float)number, (float)v, 0}, .normal = {0, 1, 0}};
	for (uint32_t i = 0; i < gpu_thing_indices(number); i++)
		indices[i] = gpu_thing_index(number, i);
	stilb_scene_mesh source = {.vertices = vertices,
	                           .indices = indices,
	                           .vertex_count = gpu_thing_vertices(number),
	                           .index_count = gpu_thing_indices(number)};
	stilb_scene_level level = {0, 3, source.vertex_count, 1.0f};
	if (number % 3 == 0) { /* some have a level, of their first triangle */
		source.level_count = 1;
		source.level_index_count = 3;
		source.levels = &level;
		source.level_indices = indices;
	}
	return stilb_render_mesh_create(render, &source, mesh);
}

static inline stilb_result gpu_material_create(stilb_render *render, uint32_t number, stilb_render_texture texture,
                                               stilb_render_material *material)
{
	stilb_scene_material source = {.diffuse = {(float)number, 1, 1}, .specular = {0, 0, 0}, .roughness = 0.5f};
	return stilb_render_material_create(render, &source, texture, material);
}

static inline stilb_result gpu_texture_create(stilb_render *render, uint32_t number, stilb_render_texture *texture)
{
	uint8_t pixels[4] = {(uint8_t)number, (uint8_t)(number >> 8), (uint8_t)(number >> 16), 0xff};
	stilb_image source = {1, 1, 4, STILB_IMAGE_U8_SRGB, pixels, 0};
	return stilb_render_texture_create(render, &source, texture);
}

static inline void gpu_thing_create(stilb_render *render, uint32_t number, gpu_thing *thing)
{
	thing->number = number;
	assert_int_equal(gpu_texture_create(render, number, &thing->texture), STILB_OK);
	assert_int_equal(gpu_material_create(render, number, thing->texture, &thing->material), STILB_OK);
	assert_int_equal(gpu_mesh_create(render, number, &thing->mesh), STILB_OK);
}

static inline void gpu_thing_destroy(stilb_render *render, const gpu_thing *thing)
{
	stilb_render_mesh_destroy(render, thing->mesh);
	stilb_render_material_destroy(render, thing->material);
	stilb_render_texture_destroy(render, thing->texture);
}

static inline fixture_draw gpu_thing_draw(const gpu_thing *thing)
{
	fixture_draw draw = {.mesh = thing->mesh,
	                     .material = thing->material,
	                     .index_count = gpu_thing_indices(thing->number),
	                     .texture = fixture_index(thing->texture.id),
	                     .transform = stilb_mat4_identity()};
	draw.transform.m[12] = (float)thing->number;
	return draw;
}

/* ---- what the GPU has ------------------------------------------------------------------------------------------- */

#define GPU_VERTEX 24u /* bytes */

static inline bool gpu_draw_is_good(const gpu_draw *draw)
{
	const render_command *c = &draw->command;
	uint32_t vertices = gpu_thing_vertices(draw->number), indices = gpu_thing_indices(draw->number);
	/* Of packed vertices, whose positions come first. */
	const uint8_t *vertex = gpu.heaps[RENDER_HEAP_VERTICES] + (size_t)(uint32_t)c->vertex_offset * GPU_VERTEX;
	const uint16_t *index = (const uint16_t *)gpu.heaps[RENDER_HEAP_INDICES_16] + c->first_index;
	const render_material *material = (const render_material *)gpu.heaps[RENDER_HEAP_MATERIALS] + c->material;
	if (c->index_count != indices || c->instance_count != 1 ||
	    ((uint64_t)(uint32_t)c->vertex_offset + vertices) * GPU_VERTEX > gpu.heap_bytes[RENDER_HEAP_VERTICES] ||
	    ((uint64_t)c->first_index + indices) * sizeof *index > gpu.heap_bytes[RENDER_HEAP_INDICES_16] ||
	    ((uint64_t)c->material + 1) * sizeof *material > gpu.heap_bytes[RENDER_HEAP_MATERIALS])
		return false;
	bool good = material->diffuse[0] == (float)draw->number && gpu_image_of(gpu.device, draw->image) &&
	            gpu.images[draw->image % GPU_IMAGES].id == draw->image &&
	            gpu.images[draw->image % GPU_IMAGES].pixel == (draw->number | 0xff000000u);
	for (uint32_t v = 0; v < vertices; v++, vertex += GPU_VERTEX) {
		float position[2];
		memcpy(position, vertex, sizeof position);
		good &= position[0] == (float)draw->number && position[1] == (float)v;
	}
	for (uint32_t i = 0; i < indices; i++)
		good &= index[i] == gpu_thing_index(draw->number, i);
	return good;
}

static inline void gpu_check_frames(void)
{
	for (uint32_t f = 0; f < STILB_GPU_FRAMES; f++)
		for (uint32_t d = 0; d < gpu.frames[f].count; d++)
			gpu.wrong += !gpu_draw_is_good(&gpu.frames[f].draws[d]);
}

static inline stilb_result gpu_begin(stilb_gpu *device)
{
	gpu_check_frames(); /* what was destroyed since the last frame is no longer in flight */
	gpu.frame = (gpu.frame + 1) % STILB_GPU_FRAMES;
	gpu.frames[gpu.frame].count = 0; /* the GPU is done with it */
	return gpu.real->begin(device);
}

static inline stilb_result gpu_image_make(stilb_gpu *device, gpu_image *image)
{
	stilb_result result = atomic_exchange_explicit(&gpu.texture_result, STILB_OK, memory_order_relaxed);
	return result == STILB_OK ? gpu.real->image_make(device, image) : stilb_fail(result, "no such texture on this GPU");
}

/* realloc for the tests alone, which may make realloc fail. */
static inline void *gpu_larger(void *memory, size_t old_size, size_t size)
{
	void *larger = calloc(1, size);
	assert_non_null(larger);
	if (memory)
		memcpy(larger, memory, old_size);
	free(memory);
	return larger;
}

/* Takes an upload's bytes as a device's copy would. */
static inline void gpu_take(const gpu_upload_ready *ready)
{
	const stilb_gpu_upload *upload = &ready->upload;
	const uint8_t *bytes = (const uint8_t *)gpu.device->ring.buffer.mapped + ready->place;
	if (upload->image.id) {
		gpu.images[upload->image.id % GPU_IMAGES].id = upload->image.id;
		memcpy(&gpu.images[upload->image.id % GPU_IMAGES].pixel, bytes, sizeof(uint32_t));
		return;
	}
	for (int kind = 0; kind < RENDER_HEAPS; kind++) {
		if (gpu.render->device->heaps[kind].buffer.id != upload->buffer.id)
			continue;
		uint64_t size = gpu.render->device->heaps[kind].bytes;
		if (size > gpu.heap_bytes[kind]) {
			gpu.heaps[kind] = gpu_larger(gpu.heaps[kind], gpu.heap_bytes[kind], size);
			gpu.heap_bytes[kind] = size;
		}
		assert_true(upload->offset + upload->bytes <= size);
		memcpy(gpu.heaps[kind] + upload->offset, bytes, upload->bytes);
	}
}

static inline stilb_result gpu_flush(stilb_gpu *device, const gpu_upload_ready *uploads, uint32_t count)
{
	for (uint32_t u = 0; u < count; u++)
		gpu_take(&uploads[u]);
	return gpu.real->flush(device, uploads, count);
}

static inline void gpu_keep(gpu_frame *frame, gpu_draw draw)
{
	if (frame->count == frame->capacity) {
		frame->capacity = frame->capacity * 2 + 1000;
		frame->draws =
			gpu_larger(frame->draws, frame->count * sizeof *frame->draws, frame->capacity * sizeof *frame->draws);
	}
	frame->draws[frame->count++] = draw;
	gpu.draws_seen++;
}

static inline void gpu_list(const stilb_gpu_draws *list)
{
	for (uint32_t r = 0; r < list->run_count; r++) {
		const stilb_gpu_run *run = &list->runs[r];
		const gpu_set *set = gpu_set_of(gpu.device, run->set);
		assert_non_null(set);
		for (uint32_t c = run->first; c < run->first + run->count; c++) {
			const render_command *command = (const render_command *)list->draws + c;
			const render_row *row = render_row_of(gpu.render, command);
			gpu_keep(&gpu.frames[gpu.frame], (gpu_draw){*command, set->items[0].image.id, (uint32_t)row->transform[3]});
		}
	}
}

static inline stilb_result gpu_run(stilb_gpu *device, const stilb_gpu_plan *plan, const stilb_gpu_draws *lists,
                                   uint32_t list_count, const stilb_gpu_threads *threads,
                                   const gpu_upload_ready *uploads, uint32_t upload_count)
{
	if (gpu.losing) {
		gpu.losing = false;
		return stilb_fail(STILB_ERROR_DEVICE, "this frame never arrives");
	}
	for (uint32_t u = 0; u < upload_count; u++)
		gpu_take(&uploads[u]);
	for (uint32_t l = 0; l < list_count; l++)
		gpu_list(&lists[l]);
	gpu_check_frames();
	return gpu.real->run(device, plan, lists, list_count, threads, uploads, upload_count);
}

static inline void gpu_attach(stilb_render *render)
{
	memset(&gpu, 0, sizeof gpu);
	gpu.render = render;
	gpu.device = render->device->gpu;
	gpu.real = gpu.device->functions;
	gpu.functions = *gpu.real;
	gpu.functions.begin = gpu_begin;
	gpu.functions.image_make = gpu_image_make;
	gpu.functions.flush = gpu_flush;
	gpu.functions.run = gpu_run;
	gpu.device->functions = &gpu.functions;
}

static inline void gpu_detach(stilb_render *render)
{
	render->device->gpu->functions = gpu.real;
	for (int kind = 0; kind < RENDER_HEAPS; kind++)
		free(gpu.heaps[kind]);
	for (uint32_t f = 0; f < STILB_GPU_FRAMES; f++)
		free(gpu.frames[f].draws);
	assert_int_equal(gpu.wrong, 0);
}

#endif
