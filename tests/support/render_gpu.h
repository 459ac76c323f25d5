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
	uint32_t texture;
	uint32_t number;
} gpu_draw;

typedef struct gpu_frame {
	gpu_draw *draws;
	uint32_t count, capacity;
} gpu_frame;

static struct {
	render_device_functions functions;
	const render_device_functions *real;
	const stilb_render *render;
	uint8_t *heaps[RENDER_HEAPS];
	uint32_t heap_sizes[RENDER_HEAPS]; /* elements */
	bool made[STILB_RENDER_MAX_TEXTURES];
	uint32_t pixels[STILB_RENDER_MAX_TEXTURES]; /* the first pixel; 0: nothing has been uploaded */
	gpu_frame frames[STILB_GPU_FRAMES];
	uint32_t frame;
	stilb_result texture_result; /* of the next texture_create */
	bool losing;                 /* submit fails: the frame is lost */
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
	    (uint32_t)c->vertex_offset + vertices > gpu.heap_sizes[RENDER_HEAP_VERTICES] ||
	    c->first_index + indices > gpu.heap_sizes[RENDER_HEAP_INDICES_16] ||
	    c->material >= gpu.heap_sizes[RENDER_HEAP_MATERIALS])
		return false;
	bool good = material->diffuse[0] == (float)draw->number && gpu.made[draw->texture] &&
	            gpu.pixels[draw->texture] == (draw->number | 0xff000000u);
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

static inline stilb_result gpu_frame_begin(render_device *device, render_memory *memory)
{
	gpu.frame = (gpu.frame + 1) % STILB_GPU_FRAMES;
	gpu.frames[gpu.frame].count = 0; /* the GPU is done with it */
	return gpu.real->frame_begin(device, memory);
}

static inline stilb_result gpu_texture_make(render_device *device, uint32_t texture, const stilb_image *image)
{
	stilb_result result = gpu.texture_result;
	gpu.texture_result = STILB_OK;
	if (result != STILB_OK)
		return stilb_fail(result, "no such texture on this GPU");
	assert_true(texture > 0 && texture < STILB_RENDER_MAX_TEXTURES && !gpu.made[texture]);
	assert_true(image->channels == 4);
	gpu.made[texture] = true;
	gpu.pixels[texture] = 0;
	return gpu.real->texture_create(device, texture, image);
}

static inline void gpu_texture_unmake(render_device *device, uint32_t texture)
{
	assert_true(gpu.made[texture]);
	gpu.made[texture] = false;
	gpu_check_frames(); /* no frame in flight may read it */
	gpu.real->texture_destroy(device, texture);
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

static inline void gpu_copy_heap(int kind, const render_heap *heap)
{
	if (heap->size > gpu.heap_sizes[kind]) {
		gpu.heaps[kind] = gpu_larger(gpu.heaps[kind], (size_t)gpu.heap_sizes[kind] * heap->element,
		                             (size_t)heap->size * heap->element);
		gpu.heap_sizes[kind] = heap->size;
	}
	for (uint32_t r = 0; r < heap->dirty.count; r++) {
		render_range range = heap->dirty.items[r];
		assert_true(range.count > 0 && range.first + range.count <= heap->size);
		memcpy(gpu.heaps[kind] + (size_t)range.first * heap->element, heap->data + (size_t)range.first * heap->element,
		       (size_t)range.count * heap->element);
	}
}

static inline stilb_result gpu_update(render_device *device, const render_resources *resources)
{
	for (int kind = 0; kind < RENDER_HEAPS && !gpu.losing; kind++)
		gpu_copy_heap(kind, &resources->heaps[kind]);
	for (uint32_t u = 0; u < resources->upload_count; u++) {
		const render_texture_upload *upload = &resources->uploads[u];
		assert_true(gpu.made[upload->texture]);
		if (!gpu.losing)
			memcpy(&gpu.pixels[upload->texture], upload->image.pixels, sizeof *gpu.pixels);
	}
	gpu_check_frames();
	return gpu.real->update(device, resources);
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

static inline stilb_result gpu_pass(render_device *device, const render_stream *stream)
{
	for (uint32_t r = 0; r < stream->run_count && !gpu.losing; r++) {
		const render_run *run = &stream->runs[r];
		for (uint32_t c = run->first; c < run->first + run->count; c++) {
			const render_command *command = &stream->commands[c];
			const render_row *row = render_row_of(gpu.render, command);
			gpu_keep(&gpu.frames[gpu.frame],
			         (gpu_draw){*command, render_state_texture(run->state), (uint32_t)row->transform[3]});
		}
	}
	gpu_check_frames();
	return gpu.real->pass(device, stream);
}

static inline stilb_result gpu_submit(render_device *device)
{
	if (!gpu.losing)
		return gpu.real->submit(device);
	gpu.losing = false;
	return stilb_fail(STILB_ERROR_DEVICE, "this frame never arrives");
}

static inline void gpu_attach(stilb_render *render)
{
	memset(&gpu, 0, sizeof gpu);
	gpu.render = render;
	gpu.real = render->device->functions;
	gpu.functions = *gpu.real;
	gpu.functions.frame_begin = gpu_frame_begin;
	gpu.functions.texture_create = gpu_texture_make;
	gpu.functions.texture_destroy = gpu_texture_unmake;
	gpu.functions.update = gpu_update;
	gpu.functions.pass = gpu_pass;
	gpu.functions.submit = gpu_submit;
	render->device->functions = &gpu.functions;
}

static inline void gpu_detach(stilb_render *render)
{
	render->device->functions = gpu.real;
	for (int kind = 0; kind < RENDER_HEAPS; kind++)
		free(gpu.heaps[kind]);
	for (uint32_t f = 0; f < STILB_GPU_FRAMES; f++)
		free(gpu.frames[f].draws);
	assert_int_equal(gpu.wrong, 0);
}

#endif
