/* Reflections: what surfaces mirror of the picture, by rays over a hierarchy of its depth. */
#include "post/post_reflections.h"
#include "post/post_internal.h"

#include "render/device/render_images.h"

#include <math.h>
#include <string.h>

#define REFLECTIONS_LEVELS 8u /* of the hierarchy at most, the picture's size included */

/* As the shaders have it. */
typedef struct reflections_push {
	float across[4], down[4], ahead[4], clip_x[4], clip_y[4], clip_w[4];
	uint32_t levels;
} reflections_push;

/* What the rows of a frame have in common. */
typedef struct reflections_frame {
	stilb_post *post;
	stilb_gpu_plan *plan;
	reflections_push push;
	uint32_t width, height, levels;
	uint16_t color, ambient, reflection, depth, mirror, normal; /* that it reads */
} reflections_frame;

static const struct {
	const char *name;
	const stilb_gpu_shader *shader;
	uint8_t samplers;
} reflections_programs[POST_REFLECTIONS_PROGRAMS] = {
	[POST_REFLECTIONS_LIGHT] = {"mirrored light", &post_shader_reflections_light, 3},
	[POST_REFLECTIONS_NEAREST] = {"nearest depth", &post_shader_reflections_nearest, 1},
	[POST_REFLECTIONS_PLACE] = {"nearest depth placed", &post_shader_reflections_place, 1},
	[POST_REFLECTIONS_TRACE] = {"reflections traced", &post_shader_reflections_trace, 5},
	[POST_REFLECTIONS_APPLY] = {"reflections", &post_shader_reflections_apply, 5},
};

/* The program of this number; for another way it is made anew. */
static stilb_result reflections_program(stilb_post *post, post_reflections_program number, stilb_gpu_program *program)
{
	stilb_gpu *gpu = stilb_render_gpu(post->render);
	stilb_gpu_program *made = &post->reflections[number];
	uint32_t way = post->settings.reflections;
	stilb_result result = STILB_OK;
	if (made->id != 0 && post->reflections_way[number] != way) {
		stilb_gpu_program_destroy(gpu, *made);
		*made = (stilb_gpu_program){0};
	}
	if (made->id == 0) {
		stilb_gpu_program_desc desc = {
			.name = reflections_programs[number].name,
			.fragment = *reflections_programs[number].shader,
			.samplers = reflections_programs[number].samplers,
			.constant_count = number >= POST_REFLECTIONS_TRACE,
			.constants = {{0, number == POST_REFLECTIONS_TRACE ? way : way != STILB_POST_REFLECTIONS_CONES}},
		};
		result = stilb_gpu_program_create(gpu, &desc, made);
		post->reflections_way[number] = way;
	}
	*program = *made;
	return result;
}

/* Adds a pass into an image that reads others; its constants are the frame's. */
static stilb_result reflections_pass(const reflections_frame *frame, post_reflections_program number,
                                     stilb_gpu_pass pass)
{
	stilb_gpu_program program;
	stilb_result result = reflections_program(frame->post, number, &program);
	if (result != STILB_OK)
		return result;
	pass.name = reflections_programs[number].name;
	pass.kind = STILB_GPU_PASS_FULLSCREEN;
	pass.program = program.id;
	pass.color_count = 1;
	pass.use_count = reflections_programs[number].samplers;
	for (uint32_t u = 0; u < pass.use_count; u++) {
		pass.uses[u].how = STILB_GPU_USE_SAMPLED;
		pass.uses[u].slot = (uint16_t)u;
	}
	if (number != POST_REFLECTIONS_NEAREST && number != POST_REFLECTIONS_PLACE) {
		memcpy(pass.constants, &frame->push, sizeof frame->push);
		pass.constant_bytes = sizeof frame->push;
	}
	stilb_gpu_plan_pass(frame->plan, &pass);
	return STILB_OK;
}

/* How places and pixels belong together. False: the camera has no perspective. */
static bool reflections_optics(const stilb_post *post, uint32_t height, reflections_push *push)
{
	const float *from = post->from_clip.m, *to = post->to_clip.m;
	float square = to[3] * to[3] + to[7] * to[7] + to[11] * to[11];
	float along = to[2] * to[3] + to[6] * to[7] + to[10] * to[11];
	float up = sqrtf(to[1] * to[1] + to[5] * to[5] + to[9] * to[9]);
	if (!(square > 0.0f) || from[11] == 0.0f)
		return false;
	for (size_t i = 0; i < 3; i++) {
		push->across[i] = from[i];
		push->down[i] = from[4 + i];
		push->ahead[i] = from[12 + i];
		push->clip_x[i] = to[4 * i];
		push->clip_y[i] = to[4 * i + 1];
		push->clip_w[i] = to[4 * i + 3];
	}
	push->across[3] = from[11];
	push->down[3] = from[15];
	push->ahead[3] = exp2f(post->exposure);
	push->clip_x[3] = along / square;
	push->clip_y[3] = to[14];
	push->clip_w[3] = 0.5f * (float)height * up;
	return true;
}

/* Adds the rows that fill the image of light and its mips. */
static stilb_result reflections_light(const reflections_frame *frame, uint16_t *light)
{
	stilb_gpu_plan_image_row row = {.name = "mirrored light",
	                                .format = STILB_GPU_RGBA16_F,
	                                .width = frame->width,
	                                .height = frame->height,
	                                .mips = (uint16_t)frame->levels};
	*light = stilb_gpu_plan_image(frame->plan, &row);
	stilb_gpu_pass pass = {
		.color = {{.image = *light, .load = STILB_GPU_LOAD_DISCARD}},
		.uses = {{.resource = frame->color}, {.resource = frame->ambient}, {.resource = frame->reflection}}};
	stilb_result result = reflections_pass(frame, POST_REFLECTIONS_LIGHT, pass);
	stilb_gpu_plan_mips(frame->plan, *light, 0, 0);
	return result;
}

/* Adds the row that puts a level of the hierarchy, from the second one on, at its place in the image of all. */
static stilb_result reflections_place(const reflections_frame *frame, uint32_t level, uint16_t chain, uint16_t placed)
{
	uint32_t w = frame->width, h = frame->height;
	int32_t corner[2] = {level > 1 ? (int32_t)(w >> 1) : 0, level > 1 ? (int32_t)((h >> 1) - (h >> (level - 1))) : 0};
	stilb_gpu_pass pass = {
		.area = {(uint16_t)corner[0], (uint16_t)corner[1], (uint16_t)(w >> level), (uint16_t)(h >> level)},
		.color = {{.image = placed, .load = level > 1 ? STILB_GPU_LOAD_KEEP : STILB_GPU_LOAD_CLEAR}},
		.uses = {{.resource = chain, .mip = (uint8_t)(level - 1), .mips = 1}},
		.constant_bytes = sizeof corner,
	};
	memcpy(pass.constants, corner, sizeof corner);
	return reflections_pass(frame, POST_REFLECTIONS_PLACE, pass);
}

/* Adds the rows that fill the hierarchy of depth, from half the picture's size on: the second level on the left, the
 * others on the right of it one below the other. *placed: depth itself if there is no second level. */
static stilb_result reflections_nearest(const reflections_frame *frame, uint16_t *placed)
{
	uint32_t width = frame->width >> 1, height = frame->height >> 1;
	*placed = frame->depth;
	if (frame->levels < 2)
		return STILB_OK;
	stilb_gpu_plan_image_row row = {.name = "nearest depth",
	                                .format = STILB_GPU_R32_F,
	                                .width = width,
	                                .height = height,
	                                .mips = (uint16_t)(frame->levels - 1)};
	uint16_t chain = stilb_gpu_plan_image(frame->plan, &row);
	row = (stilb_gpu_plan_image_row){
		.name = "nearest depths", .format = STILB_GPU_R32_F, .width = width + (frame->width >> 2), .height = height};
	*placed = stilb_gpu_plan_image(frame->plan, &row);
	stilb_result result = STILB_OK;
	for (uint32_t l = 1; l < frame->levels && result == STILB_OK; l++) {
		stilb_gpu_use from = {.resource = chain, .mip = (uint8_t)(l - 2), .mips = 1};
		if (l == 1)
			from = (stilb_gpu_use){.resource = frame->depth};
		stilb_gpu_pass pass = {.color = {{.image = chain, .mip = (uint8_t)(l - 1), .load = STILB_GPU_LOAD_DISCARD}},
		                       .uses = {from}};
		result = reflections_pass(frame, POST_REFLECTIONS_NEAREST, pass);
		if (result == STILB_OK)
			result = reflections_place(frame, l, chain, *placed);
	}
	return result;
}

/* Adds the rows that trace, and add what was found. */
static stilb_result reflections_trace(const reflections_frame *frame, uint16_t light, uint16_t nearest, uint16_t out)
{
	stilb_gpu_sampler mips;
	stilb_gpu_sampler_desc desc = {.linear = true, .mips = true, .mip_linear = true};
	stilb_gpu_plan_image_row row = {
		.name = "reflections traced", .format = STILB_GPU_RGBA16_F, .width = frame->width, .height = frame->height};
	stilb_result result = stilb_gpu_sampler_get(stilb_render_gpu(frame->post->render), &desc, &mips);
	if (result != STILB_OK)
		return result;
	uint16_t traced = stilb_gpu_plan_image(frame->plan, &row);
	stilb_gpu_pass trace = {.color = {{.image = traced, .load = STILB_GPU_LOAD_DISCARD}},
	                        .uses = {{.resource = frame->depth},
	                                 {.resource = nearest},
	                                 {.resource = frame->mirror},
	                                 {.resource = frame->normal},
	                                 {.resource = light, .sampler = mips.id}}};
	stilb_gpu_pass apply = {.color = {{.image = out, .load = STILB_GPU_LOAD_DISCARD}},
	                        .uses = {{.resource = frame->reflection},
	                                 {.resource = traced},
	                                 {.resource = frame->mirror},
	                                 {.resource = frame->normal},
	                                 {.resource = frame->depth}}};
	result = reflections_pass(frame, POST_REFLECTIONS_TRACE, trace);
	return result == STILB_OK ? reflections_pass(frame, POST_REFLECTIONS_APPLY, apply) : result;
}

stilb_result post_reflections_add(stilb_post *post, stilb_gpu_plan *plan, uint16_t *reflection)
{
	const stilb_gpu_extent *extent = stilb_gpu_plan_extent(plan, *reflection);
	stilb_gpu_plan_image_row row = {
		.name = "reflections", .format = extent->format, .width = extent->width, .height = extent->height};
	reflections_frame frame = {.post = post,
	                           .plan = plan,
	                           .width = extent->width,
	                           .height = extent->height,
	                           .levels = 1,
	                           .color = stilb_gpu_plan_find(plan, STILB_RENDER_IMAGE_COLOR),
	                           .ambient = post->ambient,
	                           .reflection = *reflection,
	                           .depth = stilb_gpu_plan_find(plan, STILB_RENDER_IMAGE_DEPTH),
	                           .mirror = stilb_gpu_plan_find(plan, STILB_RENDER_IMAGE_MIRROR),
	                           .normal = stilb_gpu_plan_find(plan, STILB_RENDER_IMAGE_MIRROR_NORMAL)};
	uint32_t side = frame.width < frame.height ? frame.width : frame.height; /* so no level has a side of 0 */
	if (frame.mirror == 0 || !reflections_optics(post, frame.height, &frame.push))
		return STILB_OK;
	while (frame.levels < REFLECTIONS_LEVELS && side >> frame.levels > 0)
		frame.levels++;
	frame.push.levels = frame.levels;
	uint16_t out = stilb_gpu_plan_image(plan, &row), light, nearest;
	stilb_result result = reflections_light(&frame, &light);
	if (result == STILB_OK)
		result = reflections_nearest(&frame, &nearest);
	if (result == STILB_OK)
		result = reflections_trace(&frame, light, nearest, out);
	*reflection = out;
	return result;
}

void post_reflections_finish(stilb_post *post)
{
	for (uint32_t p = 0; p < POST_REFLECTIONS_PROGRAMS; p++)
		if (post->reflections[p].id != 0)
			stilb_gpu_program_destroy(stilb_render_gpu(post->render), post->reflections[p]);
}
