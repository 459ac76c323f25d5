/* Plans on the Vulkan device, under validation with synchronization checks: what each kind of pass leaves behind is
 * read back and compared with what the CPU works out. */
#include "gpu/gpu_internal.h"
#include "shading/shade_srgb.h"
#include "support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef uint32_t uint;
#define PATHS_FUNCTION static
#include "gpu/shaders/paths.glsl"

#define SHADER(code)                                                                                                   \
	{                                                                                                                  \
		.words = code, .bytes = sizeof code                                                                            \
	}

static const uint32_t scene_vert[] =
#include "scene.vert.inc"
	;
static const uint32_t layered_vert[] =
#include "layered.vert.inc"
	;
static const uint32_t layered_frag[] =
#include "layered.frag.inc"
	;
static const uint32_t color_frag[] =
#include "color.frag.inc"
	;
static const uint32_t textured_frag[] =
#include "textured.frag.inc"
	;
static const uint32_t depth_frag[] =
#include "depth_to_color.frag.inc"
	;
static const uint32_t sum_comp[] =
#include "sum.comp.inc"
	;
static const uint32_t mix_frag[] =
#include "mix.frag.inc"
	;
static const uint32_t paths_frag[] =
#include "paths.frag.inc"
	;
static const uint32_t uniforms_comp[] =
#include "uniforms.comp.inc"
	;

typedef struct vertex {
	float position[2], depth;
} vertex;

typedef struct draw {
	uint32_t index_count, instance_count, first_index;
	int32_t vertex_offset;
	uint32_t first_instance, rest[3];
} draw;

static_assert(sizeof(draw) == STILB_GPU_DRAW_STRIDE, "laid out as the device reads it");

/* A device, its plan, and a square of two triangles: over the left half of the area at depth 0.5, in draw 0. */
typedef struct stage {
	stilb_gpu *gpu;
	stilb_gpu_plan *plan;
	stilb_gpu_buffer vertices, indices, commands;
	stilb_gpu_program depth_only, colored, layered, textured, show_depth, sum, mix;
	stilb_gpu_binding binding;
	stilb_gpu_run run;
	stilb_gpu_draws list;
} stage;

static stage s;

static stilb_gpu_program program_make(stilb_gpu_program_desc desc)
{
	stilb_gpu_program program;
	if (desc.vertex.words) {
		desc.vertex_bytes = sizeof(vertex);
		desc.input_count = 2;
		desc.inputs[0] = (stilb_gpu_vertex_input){.location = 0, .format = STILB_GPU_RG32_F};
		desc.inputs[1] = (stilb_gpu_vertex_input){.location = 1, .format = STILB_GPU_R32_F, .offset = 8};
	}
	if (stilb_gpu_program_create(s.gpu, &desc, &program) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return program;
}

static stilb_gpu_buffer buffer_make(const char *name, const void *bytes, uint64_t size, uint32_t uses)
{
	stilb_gpu_buffer buffer;
	stilb_gpu_buffer_desc desc = {.name = name, .bytes = size, .memory = STILB_GPU_MEMORY_SHARED, .uses = uses};
	assert_int_equal(stilb_gpu_buffer_create(s.gpu, &desc, &buffer), STILB_OK);
	memcpy(stilb_gpu_buffer_mapped(s.gpu, buffer), bytes, size);
	return buffer;
}

static int stage_open(void **state)
{
	(void)state;
	static const vertex vertices[4] = {{{-1, -1}, 0.5f}, {{0, -1}, 0.5f}, {{-1, 1}, 0.5f}, {{0, 1}, 0.5f}};
	static const uint16_t indices[6] = {0, 2, 1, 1, 2, 3};
	static const draw draws[4] = {
		{6, 1, 0, 0, 0, {0}}, {6, 1, 0, 0, 1, {0}}, {6, 1, 0, 0, 2, {0}}, {6, 1, 0, 0, 3, {0}}};
	stilb_gpu_desc desc = {.validate = true, .upload_bytes = 1 << 20};
	s = (stage){0};
	if (stilb_gpu_create(&desc, &s.gpu) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	s.plan = stilb_gpu_plan_create();
	s.vertices = buffer_make("vertices", vertices, sizeof vertices, STILB_GPU_BUFFER_VERTICES);
	s.indices = buffer_make("indices", indices, sizeof indices, STILB_GPU_BUFFER_INDICES);
	s.commands = buffer_make("commands", draws, sizeof draws, STILB_GPU_BUFFER_INDIRECT);
	s.depth_only = program_make((stilb_gpu_program_desc){
		.name = "depth only", .vertex = SHADER(scene_vert), .depth = STILB_GPU_COMPARE_GREATER, .depth_write = true});
	s.colored = program_make(
		(stilb_gpu_program_desc){.name = "colored", .vertex = SHADER(scene_vert), .fragment = SHADER(color_frag)});
	s.layered = program_make(
		(stilb_gpu_program_desc){.name = "layered", .vertex = SHADER(layered_vert), .fragment = SHADER(layered_frag)});
	s.textured = program_make((stilb_gpu_program_desc){
		.name = "textured", .vertex = SHADER(scene_vert), .fragment = SHADER(textured_frag), .set_items = 1});
	s.show_depth =
		program_make((stilb_gpu_program_desc){.name = "show depth", .fragment = SHADER(depth_frag), .samplers = 1});
	s.sum = program_make((stilb_gpu_program_desc){.name = "sum", .compute = SHADER(sum_comp), .samplers = 1});
	s.mix = program_make((stilb_gpu_program_desc){.name = "mix", .fragment = SHADER(mix_frag), .samplers = 2});
	s.binding = (stilb_gpu_binding){
		.program = s.depth_only.id, .indices = s.indices.id, .vertices = s.vertices.id, .index_bytes = 2};
	s.run = (stilb_gpu_run){.count = 1};
	s.list = (stilb_gpu_draws){.draws = stilb_gpu_buffer_mapped(s.gpu, s.commands),
	                           .commands = s.commands,
	                           .bindings = &s.binding,
	                           .runs = &s.run,
	                           .binding_count = 1,
	                           .run_count = 1};
	return 0;
}

static int stage_close(void **state)
{
	(void)state;
	assert_int_equal(stilb_gpu_wait(s.gpu), STILB_OK);
	assert_int_equal(s.gpu->validation_messages, 0);
	stilb_gpu_plan_destroy(s.plan);
	stilb_gpu_destroy(s.gpu);
	return 0;
}

static void plan_begin(uint32_t width, uint32_t height)
{
	assert_int_equal(stilb_gpu_frame_begin(s.gpu), STILB_OK);
	stilb_gpu_plan_begin(s.plan, width, height);
}

static void plan_run(const stilb_gpu_draws *lists, uint32_t count, const stilb_gpu_threads *threads)
{
	stilb_gpu_planner planner = stilb_gpu_planner_of(s.gpu);
	if (stilb_gpu_plan_make(s.plan, &planner) != STILB_OK ||
	    stilb_gpu_frame_run(s.gpu, s.plan, lists, count, threads) != STILB_OK)
		fail_msg("%s", stilb_error_message());
}

/* The bytes of an output of the last frame; valid until the next call. */
static const void *read_back(uint16_t resource, uint8_t mip, uint16_t layer)
{
	static uint64_t ticket;
	const void *bytes = NULL;
	uint64_t frame = 0;
	if (ticket > 0)
		stilb_gpu_read_end(s.gpu, ticket);
	if (stilb_gpu_read_begin(s.gpu, s.plan, resource, mip, layer, &ticket) != STILB_OK ||
	    stilb_gpu_read_get(s.gpu, ticket, true, &bytes, &frame) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_non_null(bytes);
	assert_int_equal(frame, stilb_gpu_stats_get(s.gpu).frame);
	return bytes;
}

static uint16_t image(const char *name, stilb_gpu_format format, bool output)
{
	return stilb_gpu_plan_image(
		s.plan, &(stilb_gpu_plan_image_row){.name = name, .format = format, .scale = 1.0f, .output = output});
}

/* ---- a chain of passes ------------------------------------------------------------------------------------------- */

typedef struct chain {
	uint16_t shown, copied, sums;
} chain;

/* A depth-only pass of draws, a fullscreen pass that samples it, a dispatch that adds that up, and a copy. */
static chain chain_plan(uint32_t width, uint32_t height)
{
	chain c;
	uint16_t depth = image("depth", STILB_GPU_D32_F, false);
	c.shown = image("shown", STILB_GPU_R32_UI, false);
	c.copied = image("copied", STILB_GPU_R32_UI, true);
	c.sums = stilb_gpu_plan_buffer(s.plan, &(stilb_gpu_plan_buffer_row){.name = "sums", .bytes = 16, .output = true});
	uint16_t zeros =
		stilb_gpu_plan_buffer(s.plan, &(stilb_gpu_plan_buffer_row){.name = "zeros", .bytes = 16, .keep = true});
	stilb_gpu_plan_pass(s.plan, &(stilb_gpu_pass){.name = "depth",
	                                              .kind = STILB_GPU_PASS_DRAWS,
	                                              .depth = {.image = depth, .load = STILB_GPU_LOAD_CLEAR}});
	stilb_gpu_plan_pass(s.plan, &(stilb_gpu_pass){.name = "show",
	                                              .kind = STILB_GPU_PASS_FULLSCREEN,
	                                              .color = {{.image = c.shown, .load = STILB_GPU_LOAD_DISCARD}},
	                                              .color_count = 1,
	                                              .uses = {{.resource = depth, .how = STILB_GPU_USE_SAMPLED}},
	                                              .use_count = 1,
	                                              .program = s.show_depth.id});
	stilb_gpu_plan_pass(
		s.plan, &(stilb_gpu_pass){.name = "zero",
	                              .kind = STILB_GPU_PASS_COPY,
	                              .uses = {{.resource = zeros, .how = STILB_GPU_USE_COPY_FROM, .previous = true},
	                                       {.resource = c.sums, .how = STILB_GPU_USE_COPY_TO}},
	                              .use_count = 2});
	stilb_gpu_plan_pass(s.plan, &(stilb_gpu_pass){.name = "sum",
	                                              .kind = STILB_GPU_PASS_DISPATCH,
	                                              .groups = {(width + 7) / 8, (height + 7) / 8, 1},
	                                              .uses = {{.resource = c.shown, .how = STILB_GPU_USE_SAMPLED},
	                                                       {.resource = c.sums, .how = STILB_GPU_USE_STORAGE}},
	                                              .use_count = 2,
	                                              .constant_bytes = 8,
	                                              .program = s.sum.id});
	stilb_gpu_plan_pass(s.plan, &(stilb_gpu_pass){.name = "copy",
	                                              .kind = STILB_GPU_PASS_COPY,
	                                              .uses = {{.resource = c.shown, .how = STILB_GPU_USE_COPY_FROM},
	                                                       {.resource = c.copied, .how = STILB_GPU_USE_COPY_TO}},
	                                              .use_count = 2});
	return c;
}

static void chain_check(chain c, uint32_t width, uint32_t height)
{
	/* Texels whose centre lies in the left half have depth 0.5, which is shown as 128. */
	uint32_t left = 0;
	for (uint32_t x = 0; x < width; x++)
		left += (float)x + 0.5f < (float)width * 0.5f;
	const uint32_t *sums = read_back(c.sums, 0, 0);
	assert_int_equal(sums[0], 128 * left * height);
	assert_int_equal(sums[1], width * height);
	const uint32_t *texels = read_back(c.copied, 0, 0);
	for (uint32_t y = 0; y < height; y++)
		for (uint32_t x = 0; x < width; x++)
			assert_int_equal(texels[y * width + x], x < left ? 128 : 0);
}

static void four_kinds_of_passes(void **state)
{
	(void)state;
	/* Resized from frame to frame, also to odd sizes. */
	static const uint32_t sizes[][2] = {{16, 16}, {16, 16}, {1, 1}, {4099, 3}, {640, 360}, {33, 7}, {16, 16}};
	for (uint32_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
		plan_begin(sizes[i][0], sizes[i][1]);
		chain c = chain_plan(sizes[i][0], sizes[i][1]);
		plan_run(&s.list, 1, NULL);
		chain_check(c, sizes[i][0], sizes[i][1]);
		assert_int_equal(s.gpu->validation_messages, 0);
	}
}

/* What a function adds to the texels of a mapped buffer. */
typedef struct adding {
	uint32_t *texels, count, what, calls;
} adding;

static void add_to_texels(void *user)
{
	adding *a = user;
	for (uint32_t i = 0; i < a->count; i++)
		a->texels[i] += a->what;
	a->calls++;
}

static void host_pass(uint16_t buffer, adding *what)
{
	stilb_gpu_plan_pass(s.plan, &(stilb_gpu_pass){.name = "add",
	                                              .kind = STILB_GPU_PASS_HOST,
	                                              .host = add_to_texels,
	                                              .host_user = what,
	                                              .uses = {{.resource = buffer, .how = STILB_GPU_USE_HOST}},
	                                              .use_count = 1});
}

static void copy_pass(uint16_t from, bool previous, uint16_t to)
{
	stilb_gpu_plan_pass(
		s.plan, &(stilb_gpu_pass){.name = "copy",
	                              .kind = STILB_GPU_PASS_COPY,
	                              .uses = {{.resource = from, .how = STILB_GPU_USE_COPY_FROM, .previous = previous},
	                                       {.resource = to, .how = STILB_GPU_USE_COPY_TO}},
	                              .use_count = 2});
}

/* Functions of the CPU between passes of the device, two in a frame; frames follow each other without a wait. */
static void functions_between_passes(void **state)
{
	(void)state;
	enum { SIDE = 24, TEXELS = SIDE * SIDE, FRAMES = 7 };
	stilb_gpu_buffer_desc desc = {
		.name = "host", .bytes = 4 * TEXELS, .memory = STILB_GPU_MEMORY_SHARED, .uses = STILB_GPU_BUFFER_COPY};
	stilb_gpu_buffer buffer;
	assert_int_equal(stilb_gpu_buffer_create(s.gpu, &desc, &buffer), STILB_OK);
	adding first = {stilb_gpu_buffer_mapped(s.gpu, buffer), TEXELS, 1, 0}, second = first;
	second.what = 1000;
	uint16_t out = 0;
	for (uint32_t frame = 0; frame < FRAMES; frame++) {
		plan_begin(SIDE, SIDE);
		/* Last frame's texels, zeros in the first frame, and 1 and 1,000 more. */
		stilb_gpu_plan_image_row row = {.name = "kept", .format = STILB_GPU_R32_UI, .scale = 1.0f, .keep = true};
		uint16_t kept = stilb_gpu_plan_image(s.plan, &row);
		uint16_t between = image("between", STILB_GPU_R32_UI, false);
		out = image("out", STILB_GPU_R32_UI, true);
		uint16_t host = stilb_gpu_plan_buffer(
			s.plan, &(stilb_gpu_plan_buffer_row){.name = "host", .bytes = desc.bytes, .owned = buffer.id});
		copy_pass(kept, true, host);
		host_pass(host, &first);
		copy_pass(host, false, between);
		copy_pass(between, false, host);
		host_pass(host, &second);
		copy_pass(host, false, kept);
		copy_pass(kept, false, out);
		plan_run(NULL, 0, NULL);
		assert_int_equal(first.calls, frame + 1);
		assert_int_equal(second.calls, frame + 1);
	}
	const uint32_t *texels = read_back(out, 0, 0);
	for (uint32_t i = 0; i < TEXELS; i++)
		assert_int_equal(texels[i], FRAMES * 1001);
	stilb_gpu_buffer_destroy(s.gpu, buffer);
	assert_int_equal(s.gpu->validation_messages, 0);
}

/* A buffer that is not mapped is refused, before anything runs. */
static void functions_need_mapped_buffers(void **state)
{
	(void)state;
	stilb_gpu_buffer_desc desc = {
		.name = "host", .bytes = 64, .memory = STILB_GPU_MEMORY_DEVICE, .uses = STILB_GPU_BUFFER_COPY};
	stilb_gpu_buffer buffer;
	assert_int_equal(stilb_gpu_buffer_create(s.gpu, &desc, &buffer), STILB_OK);
	adding none = {0};
	plan_begin(4, 4);
	uint16_t host =
		stilb_gpu_plan_buffer(s.plan, &(stilb_gpu_plan_buffer_row){.name = "host", .bytes = 64, .owned = buffer.id});
	host_pass(host, &none);
	stilb_gpu_planner planner = stilb_gpu_planner_of(s.gpu);
	assert_int_equal(stilb_gpu_plan_make(s.plan, &planner), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "STILB_GPU_MEMORY_SHARED"));
	assert_int_equal(none.calls, 0);
	stilb_gpu_buffer_destroy(s.gpu, buffer);
	stilb_gpu_plan_begin(s.plan, 4, 4);
	plan_run(NULL, 0, NULL);
}

/* A dispatch of `program` that reads uniform buffers, the second one from byte `from` of `second` on. */
static stilb_gpu_pass uniforms_pass(stilb_gpu_program program, uint16_t first, uint16_t second, uint32_t from,
                                    uint16_t result)
{
	return (stilb_gpu_pass){
		.name = "uniforms",
		.kind = STILB_GPU_PASS_DISPATCH,
		.groups = {1, 1, 1},
		.uses = {{.resource = second, .how = STILB_GPU_USE_UNIFORM, .slot = 1, .first = from, .bytes = 32},
	             {.resource = first, .how = STILB_GPU_USE_UNIFORM},
	             {.resource = result, .how = STILB_GPU_USE_STORAGE_WRITE}},
		.use_count = 3,
		.constant_bytes = 8,
		.program = program.id};
}

/* Parts of what the CPU has written, and what a pass before has. */
static void uniform_buffers(void **state)
{
	(void)state;
	stilb_gpu_buffer written;
	stilb_gpu_buffer_desc desc = {
		.name = "written", .bytes = 1024, .memory = STILB_GPU_MEMORY_WRITE, .uses = STILB_GPU_BUFFER_UNIFORM};
	assert_int_equal(stilb_gpu_buffer_create(s.gpu, &desc, &written), STILB_OK);
	stilb_gpu_program program = program_make((stilb_gpu_program_desc){.name = "uniforms",
	                                                                  .compute = SHADER(uniforms_comp),
	                                                                  .uniforms = 2,
	                                                                  .constant_count = 1,
	                                                                  .constants = {{0, 2}}});
	for (uint32_t frame = 0; frame < 3; frame++) {
		assert_int_equal(stilb_gpu_wait(s.gpu), STILB_OK);
		uint32_t *words = stilb_gpu_buffer_mapped(s.gpu, written);
		for (uint32_t i = 0; i < 256; i++)
			words[i] = 1000 * frame + i;
		plan_begin(8, 8);
		uint16_t from = stilb_gpu_plan_buffer(
			s.plan, &(stilb_gpu_plan_buffer_row){.name = "written", .bytes = 1024, .owned = written.id});
		uint16_t made = stilb_gpu_plan_buffer(s.plan, &(stilb_gpu_plan_buffer_row){.name = "made", .bytes = 32});
		uint16_t result =
			stilb_gpu_plan_buffer(s.plan, &(stilb_gpu_plan_buffer_row){.name = "result", .bytes = 32, .output = true});
		stilb_gpu_pass make = uniforms_pass(program, from, from, 256 * (1 + frame), made);
		stilb_gpu_pass read = uniforms_pass(program, made, made, 0, result);
		stilb_gpu_plan_pass(s.plan, &make);
		stilb_gpu_plan_pass(s.plan, &read);
		plan_run(NULL, 0, NULL);
		const uint32_t *got = read_back(result, 0, 0);
		for (uint32_t i = 0; i < 4; i++) {
			assert_int_equal(got[i], 1000 * frame + i);
			assert_int_equal(got[4 + i], 1000 * frame + 64 * (1 + frame) + 4 + i);
		}
	}
	/* The device's rules. */
	stilb_gpu_planner planner = stilb_gpu_planner_of(s.gpu);
	plan_begin(8, 8);
	uint16_t from = stilb_gpu_plan_buffer(
		s.plan, &(stilb_gpu_plan_buffer_row){.name = "written", .bytes = 1024, .owned = written.id});
	uint16_t result = stilb_gpu_plan_buffer(s.plan, &(stilb_gpu_plan_buffer_row){.name = "result", .bytes = 32});
	stilb_gpu_pass pass = uniforms_pass(program, from, from, 256, result);
	assert_null(planner.mistake(planner.user, s.plan, &pass));
	pass.uses[0].first = 258; /* of a multiple of 4 or more, whatever the device */
	assert_non_null(strstr(planner.mistake(planner.user, s.plan, &pass), "uniform_align"));
	pass.uses[0].slot = 2;
	pass.uses[0].first = 256;
	assert_non_null(strstr(planner.mistake(planner.user, s.plan, &pass), "(uniforms)"));
	stilb_gpu_plan_begin(s.plan, 8, 8);
	from = stilb_gpu_plan_buffer(s.plan,
	                             &(stilb_gpu_plan_buffer_row){.name = "vertices", .bytes = 64, .owned = s.vertices.id});
	pass = uniforms_pass(program, from, from, 0, from);
	assert_non_null(strstr(planner.mistake(planner.user, s.plan, &pass), "STILB_GPU_BUFFER_UNIFORM"));
	from = stilb_gpu_plan_buffer(s.plan, &(stilb_gpu_plan_buffer_row){.name = "large", .bytes = 1u << 30});
	pass = uniforms_pass(program, from, from, 0, from);
	pass.uses[0].bytes = 0;
	assert_non_null(strstr(planner.mistake(planner.user, s.plan, &pass), "uniform_bytes"));
	stilb_gpu_program_destroy(s.gpu, program);
	stilb_gpu_buffer_destroy(s.gpu, written);
}

/* Runs tasks one after the other, the last one first: each part has its own command buffer. */
static void run_backwards(void *user, uint32_t count, void (*task)(uint32_t index, void *context), void *context)
{
	*(uint32_t *)user += count;
	for (uint32_t i = count; i-- > 0;)
		task(i, context);
}

static void three_modes_of_replay(void **state)
{
	(void)state;
	uint32_t tasks = 0;
	stilb_gpu_threads threads = {&tasks, 3, run_backwards};
	for (uint32_t mode = 0; mode < 3; mode++) {
		stilb_gpu_draws list = s.list;
		stilb_gpu_binding bindings[2] = {s.binding, s.binding};
		stilb_gpu_run runs[2] = {s.run, {.first = 1, .count = 3, .binding = 1}};
		list.bindings = bindings;
		list.runs = runs;
		list.binding_count = list.run_count = 2;
		list.replay = (stilb_gpu_replay)mode;
		bindings[0].program = 0; /* the pass's */
		bindings[1].scissor[2] = bindings[1].scissor[3] = 2;
		plan_begin(8, 8);
		uint16_t out = image("out", STILB_GPU_RGBA8_U, true);
		stilb_gpu_pass pass = {.name = "draw",
		                       .kind = STILB_GPU_PASS_DRAWS,
		                       .program = s.colored.id,
		                       .color = {{.image = out, .load = STILB_GPU_LOAD_CLEAR, .clear = {0, 0, 1, 1}}},
		                       .color_count = 1,
		                       .constant_bytes = 16};
		bindings[1].program = s.colored.id;
		memcpy(pass.constants, (float[4]){1.0f, 0.0f, 0.0f, 1.0f}, 16);
		stilb_gpu_plan_pass(s.plan, &pass);
		plan_run(&list, 1, &threads);
		const uint8_t *texels = read_back(out, 0, 0);
		for (uint32_t y = 0; y < 8; y++)
			for (uint32_t x = 0; x < 8; x++) {
				const uint8_t *t = texels + 4 * (8 * y + x);
				assert_int_equal(t[0], x < 4 ? 255 : 0);
				assert_int_equal(t[2], x < 4 ? 0 : 255);
			}
		stilb_gpu_stats stats = stilb_gpu_stats_get(s.gpu);
		assert_int_equal(stats.indirect_commands, mode == STILB_GPU_REPLAY_INDIRECT ? 2 : 0);
		assert_int_equal(stats.draw_commands, mode == STILB_GPU_REPLAY_INDIRECT ? 0 : 4);
		assert_int_equal(stats.execute_commands, mode == STILB_GPU_REPLAY_SECONDARY ? 3 : 0);
	}
	assert_int_equal(tasks, 3);
}

/* Passes fill rectangles of one image, one after the other: a square over the left half of each, drawn in all modes, or
 * a fullscreen triangle. What they do not fill stays as it was, or as the first one clears it. */
static void passes_fill_areas(void **state)
{
	(void)state;
	static const uint16_t areas[3][4] = {{5, 1, 4, 6}, {0, 0, 2, 2}, {8, 6, 1, 1}};
	for (uint32_t mode = 0; mode < 3; mode++) {
		stilb_gpu_binding binding = s.binding;
		stilb_gpu_draws list = s.list;
		binding.program = s.colored.id;
		list.bindings = &binding;
		list.replay = (stilb_gpu_replay)mode;
		plan_begin(9, 7);
		uint16_t out = image("out", STILB_GPU_RGBA8_U, true);
		for (uint32_t a = 0; a < 3; a++) {
			stilb_gpu_pass pass = {.name = "draw",
			                       .kind = STILB_GPU_PASS_DRAWS,
			                       .color = {{.image = out, .load = STILB_GPU_LOAD_KEEP}},
			                       .color_count = 1,
			                       .constant_bytes = 16};
			if (a == 0)
				pass.color[0] =
					(stilb_gpu_attachment){.image = out, .load = STILB_GPU_LOAD_CLEAR, .clear = {0, 0, 1, 1}};
			memcpy(pass.area, areas[a], sizeof pass.area);
			memcpy(pass.constants, (float[4]){1.0f, (float)a / 2.0f, 0.0f, 1.0f}, 16);
			stilb_gpu_plan_pass(s.plan, &pass);
		}
		plan_run(&list, 1, NULL);
		const uint8_t *texels = read_back(out, 0, 0);
		for (uint32_t y = 0; y < 7; y++)
			for (uint32_t x = 0; x < 9; x++) {
				const uint8_t *t = texels + 4 * (9 * y + x);
				uint32_t by = 3;
				for (uint32_t a = 0; a < 3; a++)
					if (x >= areas[a][0] && x + 0.5f < areas[a][0] + 0.5f * areas[a][2] && y >= areas[a][1] &&
					    y < areas[a][1] + areas[a][3])
						by = a;
				assert_int_equal(t[0], by < 3 ? 255 : 0);
				assert_int_equal(t[1], by == 2 ? 255 : by == 1 ? 128 : 0);
				assert_int_equal(t[2], by < 3 ? 0 : 255);
			}
		assert_int_equal(s.gpu->validation_messages, 0);
	}
}

/* Programs get the code that their constants reach: it computes what all of it would. */
static void constants_choose_paths(void **state)
{
	(void)state;
	for (uint32_t way = 0; way < 5 * 13; way++) {
		uint32_t kind = way % 5, bits = way / 5 * 149 % 512;
		stilb_gpu_program program = program_make((stilb_gpu_program_desc){.name = "paths",
		                                                                  .fragment = SHADER(paths_frag),
		                                                                  .constant_count = 3,
		                                                                  .constants = {{1, 1}, {3, kind}, {7, bits}}});
		plan_begin(8, 8);
		uint16_t out = image("out", STILB_GPU_R32_UI, true);
		stilb_gpu_plan_pass(s.plan, &(stilb_gpu_pass){.name = "paths",
		                                              .kind = STILB_GPU_PASS_FULLSCREEN,
		                                              .color = {{.image = out, .load = STILB_GPU_LOAD_DISCARD}},
		                                              .color_count = 1,
		                                              .program = program.id});
		plan_run(NULL, 0, NULL);
		const uint32_t *texels = read_back(out, 0, 0);
		for (uint32_t x = 0; x < 64; x++) {
			uint32_t want = paths(x, kind, bits) + (x > 5 ? 1 : 2);
			if (texels[x] != want)
				fail_msg("kind %u, bits %u, x %u: %u, not %u", kind, bits, x, texels[x], want);
		}
		stilb_gpu_program_destroy(s.gpu, program);
		assert_int_equal(s.gpu->validation_messages, 0);
	}
}

/* Three runs draw the same square, each with a half of the colour that is its own: the last one is seen. */
static void runs_have_constants(void **state)
{
	(void)state;
	for (uint32_t mode = 0; mode < 3; mode++) {
		stilb_gpu_binding binding = s.binding;
		stilb_gpu_run runs[3] = {s.run, s.run, s.run};
		stilb_gpu_draws list = s.list;
		binding.program = s.colored.id;
		list.bindings = &binding;
		list.runs = runs;
		list.run_count = 3;
		list.replay = (stilb_gpu_replay)mode;
		list.has_constants = true;
		list.constant_place = 8;
		for (uint32_t r = 0; r < 3; r++)
			memcpy(&runs[r].constant, (float[2]){r == 2 ? 1.0f : 0.0f, 1.0f}, 8);
		plan_begin(8, 8);
		uint16_t out = image("out", STILB_GPU_RGBA8_U, true);
		stilb_gpu_pass pass = {.name = "draw",
		                       .kind = STILB_GPU_PASS_DRAWS,
		                       .color = {{.image = out, .load = STILB_GPU_LOAD_CLEAR}},
		                       .color_count = 1,
		                       .constant_bytes = 16};
		memcpy(pass.constants, (float[4]){1.0f, 0.0f, 0.0f, 0.0f}, 16);
		stilb_gpu_plan_pass(s.plan, &pass);
		plan_run(&list, 1, NULL);
		assert_memory_equal(read_back(out, 0, 0), ((uint8_t[4]){255, 0, 255, 255}), 4);
		assert_int_equal(stilb_gpu_stats_get(s.gpu).binds, 4); /* the program, indices, three constants at one */
	}
	assert_int_equal(stilb_gpu_frame_begin(s.gpu), STILB_OK);
	stilb_gpu_draws list = s.list;
	list.has_constants = true;
	list.constant_place = 12;
	assert_int_equal(stilb_gpu_frame_run(s.gpu, s.plan, &list, 1, NULL), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "bytes 12 to 19 of 16"));
	assert_int_equal(stilb_gpu_frame_run(s.gpu, s.plan, &s.list, 1, NULL), STILB_OK);
}

/* More than the ring holds goes in parts, with the ring emptied in between; draws see all of it. */
static void uploads_are_flushed(void **state)
{
	(void)state;
	uint64_t most = stilb_gpu_upload_most(s.gpu), part = most / 3 / 16 * 16, count = 10;
	stilb_gpu_buffer_desc desc = {
		.name = "large", .bytes = part * count, .memory = STILB_GPU_MEMORY_SHARED, .uses = STILB_GPU_BUFFER_COPY};
	stilb_gpu_buffer large;
	uint32_t flushes = 0;
	assert_int_equal(stilb_gpu_buffer_create(s.gpu, &desc, &large), STILB_OK);
	for (uint64_t i = 0; i < count; i++) {
		stilb_gpu_upload upload = {.buffer = large, .offset = i * part, .bytes = part};
		void *bytes = NULL;
		assert_int_equal(stilb_gpu_upload_begin(s.gpu, &upload, &bytes), STILB_OK);
		if (!bytes) {
			flushes++;
			assert_int_equal(stilb_gpu_upload_flush(s.gpu), STILB_OK);
			assert_int_equal(stilb_gpu_upload_begin(s.gpu, &upload, &bytes), STILB_OK);
			assert_non_null(bytes);
		}
		memset(bytes, (int)i + 1, part);
		stilb_gpu_upload_end(s.gpu, bytes);
	}
	assert_in_range(flushes, 3, 5);
	assert_int_equal(stilb_gpu_upload_flush(s.gpu), STILB_OK);
	const uint8_t *got = stilb_gpu_buffer_mapped(s.gpu, large);
	for (uint64_t i = 0; i < count; i++)
		assert_true(got[i * part] == i + 1 && got[(i + 1) * part - 1] == i + 1);
	stilb_gpu_buffer_destroy(s.gpu, large);
}

/* ---- images ------------------------------------------------------------------------------------------------------ */

static void layers_at_once(void **state)
{
	(void)state;
	stilb_gpu_binding binding = s.binding;
	binding.program = s.layered.id;
	stilb_gpu_run run = {.count = 4};
	stilb_gpu_draws list = s.list;
	list.bindings = &binding;
	list.runs = &run;
	plan_begin(8, 8);
	uint16_t out = stilb_gpu_plan_image(
		s.plan,
		&(stilb_gpu_plan_image_row){
			.name = "layers", .format = STILB_GPU_R32_UI, .width = 8, .height = 4, .layers = 4, .output = true});
	stilb_gpu_plan_pass(
		s.plan, &(stilb_gpu_pass){.name = "layers",
	                              .kind = STILB_GPU_PASS_DRAWS,
	                              .color = {{.image = out, .layers = 4, .load = STILB_GPU_LOAD_CLEAR, .clear = {7}}},
	                              .color_count = 1});
	plan_run(&list, 1, NULL);
	for (uint16_t layer = 0; layer < 4; layer++) {
		const uint32_t *texels = read_back(out, 0, layer);
		for (uint32_t t = 0; t < 32; t++)
			assert_int_equal(texels[t], t % 8 < 4 ? 100u + layer : 7u);
	}
}

/* The edge of the square runs through the middle of a column of texels: half of its samples are covered. */
static void samples_are_resolved(void **state)
{
	(void)state;
	stilb_gpu_binding binding = s.binding;
	binding.program = s.colored.id;
	stilb_gpu_draws list = s.list;
	list.bindings = &binding;
	plan_begin(7, 4);
	uint16_t samples = stilb_gpu_plan_image(
		s.plan,
		&(stilb_gpu_plan_image_row){.name = "samples", .format = STILB_GPU_RGBA8_U, .scale = 1.0f, .samples = 4});
	uint16_t out = image("resolved", STILB_GPU_RGBA8_U, true);
	stilb_gpu_pass pass = {.name = "draw",
	                       .kind = STILB_GPU_PASS_DRAWS,
	                       .color = {{.image = samples, .resolve = out, .load = STILB_GPU_LOAD_CLEAR}},
	                       .color_count = 1,
	                       .constant_bytes = 16};
	memcpy(pass.constants, (float[4]){1.0f, 1.0f, 1.0f, 1.0f}, 16);
	stilb_gpu_plan_pass(s.plan, &pass);
	plan_run(&list, 1, NULL);
	const uint8_t *texels = read_back(out, 0, 0);
	for (uint32_t t = 0; t < 28; t++) {
		uint32_t wanted = t % 7 < 3 ? 255 : t % 7 == 3 ? 128 : 0;
		assert_in_range(texels[4 * t], t % 7 == 3 ? 127 : wanted, wanted);
	}
}

/* Mesa's software device would resolve the first layer. */
static void one_layer_is_resolved(void **state)
{
	(void)state;
	plan_begin(8, 8);
	uint16_t samples = stilb_gpu_plan_image(
		s.plan, &(stilb_gpu_plan_image_row){
					.name = "samples", .format = STILB_GPU_RGBA8_U, .scale = 1.0f, .samples = 4, .layers = 2});
	uint16_t out = image("resolved", STILB_GPU_RGBA8_U, true);
	stilb_gpu_plan_pass(
		s.plan,
		&(stilb_gpu_pass){.name = "draw",
	                      .kind = STILB_GPU_PASS_DRAWS,
	                      .color = {{.image = samples, .resolve = out, .layer = 1, .load = STILB_GPU_LOAD_CLEAR}},
	                      .color_count = 1});
	stilb_gpu_planner planner = stilb_gpu_planner_of(s.gpu);
	stilb_result result = stilb_gpu_plan_make(s.plan, &planner);
	assert_int_equal(result, s.gpu->software ? STILB_ERROR_ARGUMENT : STILB_OK);
	if (s.gpu->software)
		assert_non_null(strstr(stilb_error_message(), "pass 1 'draw' resolves a layer that is not the first"));
}

static stilb_gpu_image own_image_of(const char *name, stilb_gpu_extent extent)
{
	stilb_gpu_image made;
	if (stilb_gpu_image_create(s.gpu, &(stilb_gpu_image_desc){.name = name, .extent = extent}, &made) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return made;
}

static stilb_gpu_image own_image(const char *name, stilb_gpu_format format, uint32_t width, uint32_t height,
                                 uint16_t mips, uint32_t uses)
{
	return own_image_of(name, (stilb_gpu_extent){.format = format,
	                                             .width = width,
	                                             .height = height,
	                                             .depth = 1,
	                                             .layers = 1,
	                                             .mips = mips,
	                                             .samples = 1,
	                                             .uses = (uint16_t)uses});
}

static void upload_texels(stilb_gpu_image to, uint32_t width, uint32_t height, const void *texels, uint64_t size)
{
	void *bytes;
	stilb_gpu_upload upload = {.image = to, .width = width, .height = height, .depth = 1, .bytes = size};
	assert_int_equal(stilb_gpu_upload_begin(s.gpu, &upload, &bytes), STILB_OK);
	assert_non_null(bytes);
	memcpy(bytes, texels, size);
	stilb_gpu_upload_end(s.gpu, bytes);
}

/* Uploads of one frame to overlapping parts of an image and of a buffer: the later one wins. */
static void uploads_in_order(void **state)
{
	(void)state;
	enum { SIDE = 8, LAYERS = 3, WORDS = 64 };
	static uint32_t texels[LAYERS][SIDE * SIDE], words[WORDS];
	stilb_gpu_image own =
		own_image_of("target", (stilb_gpu_extent){.format = STILB_GPU_R32_UI,
	                                              .width = SIDE,
	                                              .height = SIDE,
	                                              .depth = 1,
	                                              .layers = LAYERS,
	                                              .mips = 2,
	                                              .samples = 1,
	                                              .uses = 1u << STILB_GPU_USE_SAMPLED | 1u << STILB_GPU_USE_COPY_TO |
	                                                      1u << STILB_GPU_USE_COPY_FROM});
	stilb_gpu_buffer buffer = buffer_make("words", words, sizeof words, STILB_GPU_BUFFER_COPY);
	uint32_t number = 0;
	for (uint64_t frame = 0; frame < 20; frame++) {
		for (uint64_t i = 0; i < 100; i++) {
			uint64_t dice = stilb_random_u64(9, frame * 100 + i);
			bool all = frame == 0 && i < LAYERS; /* every texel is written first */
			uint32_t x = all ? 0 : dice % SIDE, y = all ? 0 : dice / 8 % SIDE,
					 width = all ? SIDE : 1 + dice / 64 % (SIDE - x), height = all ? SIDE : 1 + dice / 512 % (SIDE - y),
					 layer = all ? (uint32_t)i : dice / 4096 % LAYERS;
			uint32_t first = dice % WORDS, count = 1 + dice / 64 % (WORDS - first);
			bool image = all || dice / 65536 % 2 == 0;
			stilb_gpu_upload upload = {.image = own,
			                           .layer = (uint16_t)layer,
			                           .x = x,
			                           .y = y,
			                           .width = width,
			                           .height = height,
			                           .depth = 1,
			                           .bytes = (uint64_t)width * height * 4};
			if (!image)
				upload = (stilb_gpu_upload){
					.buffer = buffer, .offset = first * sizeof *words, .bytes = count * sizeof *words};
			void *bytes;
			assert_int_equal(stilb_gpu_upload_begin(s.gpu, &upload, &bytes), STILB_OK);
			assert_non_null(bytes);
			number++;
			for (uint32_t t = 0; t < upload.bytes / 4; t++)
				((uint32_t *)bytes)[t] = number;
			stilb_gpu_upload_end(s.gpu, bytes);
			for (uint32_t t = 0; t < width * height && image; t++)
				texels[layer][(y + t / width) * SIDE + x + t % width] = number;
			for (uint32_t t = first; t < first + count && !image; t++)
				words[t] = number;
		}
		plan_begin(SIDE, SIDE);
		uint16_t target = stilb_gpu_plan_image(s.plan, &(stilb_gpu_plan_image_row){.name = "target",
		                                                                           .format = STILB_GPU_R32_UI,
		                                                                           .scale = 1.0f,
		                                                                           .layers = LAYERS,
		                                                                           .mips = 2,
		                                                                           .output = true,
		                                                                           .owned = own.id});
		plan_run(NULL, 0, NULL);
		for (uint16_t layer = 0; layer < LAYERS; layer++)
			assert_memory_equal(read_back(target, 0, layer), texels[layer], sizeof texels[layer]);
		assert_int_equal(stilb_gpu_wait(s.gpu), STILB_OK);
		assert_memory_equal(stilb_gpu_buffer_mapped(s.gpu, buffer), words, sizeof words);
		assert_int_equal(s.gpu->validation_messages, 0);
	}
	stilb_gpu_buffer_destroy(s.gpu, buffer);
	stilb_gpu_image_destroy(s.gpu, own);
}

/* A chain of mips by filtered copies of an sRGB image: the mean is taken of light, not of codes. */
static void mips_in_linear_light(void **state)
{
	(void)state;
	enum { SIDE = 16, MIPS = 5 };
	uint8_t codes[SIDE * SIDE * 4];
	for (uint32_t i = 0; i < sizeof codes; i++)
		codes[i] = i % 4 == 3 ? 255 : (uint8_t)stilb_random_u64(5, i);
	stilb_gpu_image own =
		own_image("texture", STILB_GPU_RGBA8_SRGB, SIDE, SIDE, MIPS,
	              1u << STILB_GPU_USE_SAMPLED | 1u << STILB_GPU_USE_COPY_FROM | 1u << STILB_GPU_USE_COPY_TO);
	upload_texels(own, SIDE, SIDE, codes, sizeof codes);
	plan_begin(SIDE, SIDE);
	uint16_t texture = stilb_gpu_plan_image(s.plan, &(stilb_gpu_plan_image_row){.name = "texture",
	                                                                            .format = STILB_GPU_RGBA8_SRGB,
	                                                                            .width = SIDE,
	                                                                            .height = SIDE,
	                                                                            .mips = MIPS,
	                                                                            .output = true,
	                                                                            .owned = own.id});
	for (uint8_t mip = 1; mip < MIPS; mip++)
		stilb_gpu_plan_pass(
			s.plan,
			&(stilb_gpu_pass){
				.name = "mip",
				.kind = STILB_GPU_PASS_COPY,
				.uses = {{.resource = texture, .how = STILB_GPU_USE_COPY_FROM, .mip = (uint8_t)(mip - 1), .mips = 1},
		                 {.resource = texture, .how = STILB_GPU_USE_COPY_TO, .mip = mip, .mips = 1}},
				.use_count = 2});
	plan_run(NULL, 0, NULL);
	uint8_t before[SIDE * SIDE * 4];
	memcpy(before, read_back(texture, 0, 0), sizeof before);
	assert_memory_equal(before, codes, sizeof codes);
	for (uint8_t mip = 1; mip < MIPS; mip++) {
		uint32_t side = SIDE >> mip;
		const uint8_t *texels = read_back(texture, mip, 0);
		for (uint32_t i = 0; i < side * side * 4; i++) {
			uint32_t x = i / 4 % side, y = i / 4 / side, c = i % 4;
			float light = 0.0f;
			for (uint32_t t = 0; t < 4; t++) {
				uint8_t code = before[((2 * y + t / 2) * 2 * side + 2 * x + t % 2) * 4 + c];
				light += (c == 3 ? (float)code / 255.0f : shade_srgb_to_linear((float)code / 255.0f)) / 4.0f;
			}
			float wanted = 255.0f * (c == 3 ? light : shade_srgb_from_linear(light));
			if (fabsf((float)texels[i] - wanted) > 1.01f) /* the device's tables have steps */
				fail_msg("mip %u, texel %u,%u, channel %u: %u instead of %g", mip, x, y, c, texels[i], (double)wanted);
		}
		memcpy(before, texels, side * side * 4);
	}
	stilb_gpu_image_destroy(s.gpu, own);
}

/* An image of the program stays as it was between frames, is sampled by draws with a set, and is uploaded anew. */
static void textures_of_draws(void **state)
{
	(void)state;
	uint8_t texels[4][4] = {{10, 20, 30, 255}, {40, 50, 60, 255}, {70, 80, 90, 255}, {100, 110, 120, 255}};
	stilb_gpu_image own =
		own_image("texture", STILB_GPU_RGBA8_U, 2, 2, 1, 1u << STILB_GPU_USE_SAMPLED | 1u << STILB_GPU_USE_COPY_TO);
	stilb_gpu_set sets[2];
	assert_int_equal(stilb_gpu_set_create(s.gpu, &(stilb_gpu_set_item){.image = own}, 1, &sets[0]), STILB_OK);
	assert_int_equal(stilb_gpu_set_create(s.gpu, &(stilb_gpu_set_item){0}, 1, &sets[1]), STILB_OK);
	for (uint32_t frame = 0; frame < 5; frame++) {
		if (frame % 2 == 0) {
			texels[3][0] = (uint8_t)(100 + frame);
			upload_texels(own, 2, 2, texels, sizeof texels);
		}
		bool white = frame == 4;
		stilb_gpu_binding binding = s.binding;
		binding.program = s.textured.id;
		stilb_gpu_run run = {.count = 1, .set = sets[white].id};
		stilb_gpu_draws list = s.list;
		list.bindings = &binding;
		list.runs = &run;
		plan_begin(4, 4);
		uint16_t out = image("out", STILB_GPU_RGBA8_U, true);
		stilb_gpu_plan_pass(s.plan, &(stilb_gpu_pass){.name = "draw",
		                                              .kind = STILB_GPU_PASS_DRAWS,
		                                              .color = {{.image = out, .load = STILB_GPU_LOAD_CLEAR}},
		                                              .color_count = 1});
		plan_run(&list, 1, NULL);
		const uint8_t *got = read_back(out, 0, 0);
		for (uint32_t t = 0; t < 16; t++) {
			uint32_t x = t % 4, y = t / 4;
			static const uint8_t none[4] = {0, 0, 0, 0}, one[4] = {255, 255, 255, 255};
			const uint8_t *wanted = x >= 2 ? none : white ? one : texels[y % 2 * 2 + x % 2];
			assert_memory_equal(got + 4 * t, wanted, 4);
		}
	}
	stilb_gpu_set_destroy(s.gpu, sets[0]);
	stilb_gpu_set_destroy(s.gpu, sets[1]);
	stilb_gpu_image_destroy(s.gpu, own);
}

/* Each frame adds to what the last one left: the first one and the one after a resize find zeros. */
static void content_of_the_last_frame(void **state)
{
	(void)state;
	uint32_t wanted = 0;
	for (uint32_t frame = 1; frame <= 7; frame++) {
		uint32_t side = frame < 5 ? 8 : 9;
		plan_begin(side, side);
		uint16_t history = stilb_gpu_plan_image(
			s.plan, &(stilb_gpu_plan_image_row){
						.name = "history", .format = STILB_GPU_R32_UI, .scale = 1.0f, .keep = true, .output = true});
		if (!stilb_gpu_plan_kept(s.plan, history))
			wanted = 0;
		stilb_gpu_pass pass = {
			.name = "add",
			.kind = STILB_GPU_PASS_FULLSCREEN,
			.color = {{.image = history, .load = STILB_GPU_LOAD_DISCARD}},
			.color_count = 1,
			.uses = {{.resource = history, .how = STILB_GPU_USE_SAMPLED, .previous = true, .slot = 0},
		             {.resource = history, .how = STILB_GPU_USE_SAMPLED, .previous = true, .slot = 1}},
			.use_count = 2,
			.constant_bytes = 4,
			.program = s.mix.id};
		memcpy(pass.constants, &frame, sizeof frame);
		stilb_gpu_plan_pass(s.plan, &pass);
		plan_run(NULL, 0, NULL);
		const uint32_t *texels = read_back(history, 0, 0);
		wanted = (((frame ^ wanted) * 16777619u) ^ wanted) * 16777619u * 16777619u; /* of texel 0, 0 */
		assert_int_equal(texels[0], wanted);
	}
}

/* ---- many images ------------------------------------------------------------------------------------------------- */

static void ten_thousand_images(void **state)
{
	(void)state;
	enum { COUNT = TEST_ASAN ? 1000 : 10000 };
	static stilb_gpu_image images[COUNT];
	for (uint32_t f = 0; f < STILB_GPU_FRAMES; f++) { /* which make what each slot needs */
		plan_begin(8, 8);
		plan_run(NULL, 0, NULL);
	}
	stilb_gpu_memory_report before = stilb_gpu_memory_measure(s.gpu);
	for (uint32_t i = 0; i < COUNT; i++)
		images[i] = own_image("many", STILB_GPU_RGBA8_U, 1u << i % 7, 1u << i % 7, 1,
		                      1u << STILB_GPU_USE_SAMPLED | 1u << STILB_GPU_USE_COPY_TO);
	stilb_gpu_memory_report report = stilb_gpu_memory_measure(s.gpu);
	assert_int_equal(report.allocations, before.allocations + COUNT);
	assert_true(report.blocks < 32);
	/* Others take the places of those that go. */
	for (uint32_t i = 0; i < COUNT; i += 2)
		stilb_gpu_image_destroy(s.gpu, images[i]);
	for (uint32_t f = 0; f < 3; f++) {
		plan_begin(8, 8);
		plan_run(NULL, 0, NULL);
	}
	assert_int_equal(stilb_gpu_memory_measure(s.gpu).allocations, before.allocations + COUNT / 2);
	assert_true(stilb_gpu_memory_measure(s.gpu).fragmentation > 0.0);
	for (uint32_t i = 1; i < COUNT; i += 2)
		stilb_gpu_image_destroy(s.gpu, images[i]);
}

#define STAGE_TEST(f) cmocka_unit_test_setup_teardown(f, stage_open, stage_close)

int main(void)
{
	struct CMUnitTest tests[] = {
		STAGE_TEST(four_kinds_of_passes),     STAGE_TEST(uniform_buffers),
		STAGE_TEST(functions_between_passes), STAGE_TEST(functions_need_mapped_buffers),
		STAGE_TEST(three_modes_of_replay),    STAGE_TEST(layers_at_once),
		STAGE_TEST(passes_fill_areas),        STAGE_TEST(constants_choose_paths),
		STAGE_TEST(runs_have_constants),      STAGE_TEST(uploads_are_flushed),
		STAGE_TEST(samples_are_resolved),     STAGE_TEST(one_layer_is_resolved),
		STAGE_TEST(uploads_in_order),         STAGE_TEST(mips_in_linear_light),
		STAGE_TEST(textures_of_draws),        STAGE_TEST(content_of_the_last_frame),
		STAGE_TEST(ten_thousand_images),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
