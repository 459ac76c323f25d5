/* Depth of field: a thin lens, whose circles of confusion follow from depth alone. */
#include "post/post_lens.h"
#include "post/post_internal.h"

#include "render/device/render_images.h"

#include <math.h>
#include <string.h>

#define LENS_LARGEST 0.125f /* radius of the largest circle, of the picture's height */
#define LENS_MOST 200.0f    /* and in pixels; what the smallest of the levels is made for */
#define LENS_LEAST 0.5f     /* pixels: below, light is sharp */
#define LENS_LEVELS 6u    /* of the light in sizes, the first one the picture's, each half as large as the one before */
#define LENS_NARROW 0.25f /* radius of the small one of two blurs, of that of the large one */
#define LENS_TILE 16u     /* pixels along a tile */

/* As the shaders have it. */
typedef struct lens_push {
	float at_infinity, slope, largest;
	uint32_t levels;
	float radius;
} lens_push;

/* What the rows of a frame have in common. */
typedef struct lens_frame {
	stilb_post *post;
	stilb_gpu_plan *plan;
	lens_push push;
	uint32_t width, height;         /* pixels */
	uint16_t light, depth, blended; /* blended: depth, where nothing blends */
	uint16_t levels, soft;          /* `soft` begins with the second level */
} lens_frame;

static const struct {
	const char *name;
	const stilb_gpu_shader *shader;
	uint8_t samplers;
} lens_programs[POST_LENS_PROGRAMS] = {
	[POST_LENS_LIGHT] = {"defocus", &post_shader_lens_light, 3},
	[POST_LENS_HALVE_FIRST] = {"defocus halved", &post_shader_lens_halve, 2},
	[POST_LENS_HALVE] = {"defocus halved", &post_shader_lens_halve, 2},
	[POST_LENS_TILES] = {"defocus tiles", &post_shader_lens_tiles, 1},
	[POST_LENS_REACH] = {"defocus reach", &post_shader_lens_reach, 1},
	[POST_LENS_GATHER] = {"defocus gathered", &post_shader_lens_gather, 3},
	[POST_LENS_COMBINE] = {"depth of field", &post_shader_lens_combine, 5},
	[POST_LENS_BLUR] = {"defocus blurred", &post_shader_lens_blur, 1},
	[POST_LENS_LERP] = {"depth of field", &post_shader_lens_lerp, 4},
};

bool post_lens_is_valid(const stilb_post_settings *settings)
{
	bool plane = isfinite(settings->focus) && settings->focus >= 0.0f;
	bool lens = isfinite(settings->aperture) && settings->aperture >= 0.0f;
	bool shape = settings->blades == 0 || (settings->blades >= 3 && settings->blades <= POST_LENS_MAX_BLADES);
	bool is_there = settings->dof == STILB_POST_DOF_OFF || settings->aperture == 0.0f || settings->focus > 0.0f;
	return (unsigned)settings->dof < STILB_POST_DOF_COUNT && plane && lens && shape && is_there;
}

/* The program of this number; for another number of blades it is made anew. */
static stilb_result lens_program(stilb_post *post, post_lens_program number, stilb_gpu_program *program)
{
	stilb_gpu *gpu = stilb_render_gpu(post->render);
	stilb_gpu_program *made = &post->lens[number];
	uint32_t blades = post->settings.blades;
	stilb_result result = STILB_OK;
	if (made->id != 0 && post->lens_blades[number] != blades) {
		stilb_gpu_program_destroy(gpu, *made);
		*made = (stilb_gpu_program){0};
	}
	if (made->id == 0) {
		bool halves = number == POST_LENS_HALVE_FIRST || number == POST_LENS_HALVE;
		stilb_gpu_program_desc desc = {
			.name = lens_programs[number].name,
			.fragment = *lens_programs[number].shader,
			.samplers = lens_programs[number].samplers,
			.constant_count = number == POST_LENS_TILES ? 0
		                      : halves                  ? 2
		                                                : 1,
			.constants = {{0, blades}, {1, number == POST_LENS_HALVE_FIRST}},
		};
		result = stilb_gpu_program_create(gpu, &desc, made);
		post->lens_blades[number] = blades;
	}
	*program = *made;
	return result;
}

/* Adds a pass into one image, or two, that reads others; its constants are the frame's. */
static stilb_result lens_pass(const lens_frame *frame, post_lens_program number, stilb_gpu_pass pass)
{
	stilb_gpu_program program;
	stilb_result result = lens_program(frame->post, number, &program);
	if (result != STILB_OK)
		return result;
	post_row_fill(&pass, lens_programs[number].name, program, pass.color[1].image != 0 ? 2 : 1,
	              lens_programs[number].samplers);
	if (number != POST_LENS_TILES) {
		memcpy(pass.constants, &frame->push, sizeof frame->push);
		pass.constant_bytes = sizeof frame->push;
	}
	stilb_gpu_plan_pass(frame->plan, &pass);
	return STILB_OK;
}

/* A side of the second mip of an image. */
static uint32_t lens_half(uint32_t side)
{
	return side > 1 ? side / 2 : 1;
}

static uint16_t lens_image(const lens_frame *frame, const char *name, stilb_gpu_format format, uint32_t width,
                           uint32_t height)
{
	stilb_gpu_plan_image_row row = {.name = name, .format = format, .width = width, .height = height};
	return stilb_gpu_plan_image(frame->plan, &row);
}

/* In half the picture's size. */
static uint16_t lens_half_image(const lens_frame *frame, const char *name)
{
	return lens_image(frame, name, STILB_GPU_RGBA16_F, lens_half(frame->width), lens_half(frame->height));
}

/* A texel for each tile. */
static uint16_t lens_tiles_image(const lens_frame *frame, const char *name)
{
	return lens_image(frame, name, STILB_GPU_R16_F, (frame->width + LENS_TILE - 1) / LENS_TILE,
	                  (frame->height + LENS_TILE - 1) / LENS_TILE);
}

/* Circles of confusion at depth d are at_infinity + slope * d: that of a thin lens is aperture (1 / focus - 1 / z) in
 * the picture plane at distance 1, and 1 / z is linear in d. False: the camera has no perspective, or the picture so
 * few rows that circles are cut to nothing. */
static bool lens_optics(const stilb_post *post, uint32_t height, lens_push *push)
{
	const float *m = post->from_clip.m; /* (x, y, d, 1) -> a point at 1 / w of a direction that is the same for all d */
	float ahead = hypotf(hypotf(m[12], m[13]), m[14]), up = hypotf(hypotf(m[4], m[5]), m[6]);
	if (!(fabsf(m[11]) > 0.0f) || !(ahead > 0.0f) || !(up > 0.0f))
		return false;
	float pixels = 0.5f * (float)height * ahead / up; /* of the picture plane at distance 1, a metre */
	float scale = post->settings.aperture * pixels;
	push->at_infinity = scale * (1.0f / post->settings.focus - m[15] / ahead);
	push->slope = -scale * m[11] / ahead;
	push->largest = fminf(LENS_LARGEST * (float)(post->whole > 0 ? post->whole : height), LENS_MOST);
	return isfinite(push->at_infinity) && isfinite(push->slope) && push->largest >= LENS_LEAST;
}

/* Adds the rows that fill all levels. */
static stilb_result lens_levels(lens_frame *frame)
{
	uint32_t side = frame->width > frame->height ? frame->width : frame->height, levels = 1;
	while (levels < LENS_LEVELS && side >> levels > 0)
		levels++;
	frame->push.levels = levels;
	frame->levels = stilb_gpu_plan_image(frame->plan, &(stilb_gpu_plan_image_row){.name = "defocus",
	                                                                              .format = STILB_GPU_RGBA16_F,
	                                                                              .width = frame->width,
	                                                                              .height = frame->height,
	                                                                              .mips = (uint16_t)levels});
	frame->soft = stilb_gpu_plan_image(frame->plan, &(stilb_gpu_plan_image_row){.name = "defocus soft",
	                                                                            .format = STILB_GPU_R16_F,
	                                                                            .width = lens_half(frame->width),
	                                                                            .height = lens_half(frame->height),
	                                                                            .mips = (uint16_t)(levels - 1)});
	stilb_gpu_pass first = {
		.color = {{.image = frame->levels}},
		.uses = {{.resource = frame->light}, {.resource = frame->depth}, {.resource = frame->blended}}};
	stilb_result result = lens_pass(frame, POST_LENS_LIGHT, first);
	for (uint32_t l = 1; l < levels && result == STILB_OK; l++) {
		stilb_gpu_use from = {.resource = frame->levels, .mip = (uint8_t)(l - 1), .mips = 1};
		stilb_gpu_use soft = {.resource = frame->soft, .mip = (uint8_t)(l - 2), .mips = 1};
		stilb_gpu_pass next = {
			.color = {{.image = frame->levels, .mip = (uint8_t)l}, {.image = frame->soft, .mip = (uint8_t)(l - 1)}},
			.uses = {from, l > 1 ? soft : from}};
		result = lens_pass(frame, l > 1 ? POST_LENS_HALVE : POST_LENS_HALVE_FIRST, next);
	}
	return result;
}

/* Adds the rows of near and far fields. */
static stilb_result lens_bokeh(const lens_frame *frame, uint16_t out)
{
	uint16_t tiles = lens_tiles_image(frame, "defocus tiles");
	uint16_t reach = lens_tiles_image(frame, "defocus reach");
	uint16_t near = lens_half_image(frame, "defocus near");
	uint16_t rest = lens_half_image(frame, "defocus rest");
	stilb_gpu_pass tile = {.color = {{.image = tiles}}, .uses = {{.resource = frame->levels, .mips = 1}}};
	stilb_gpu_pass dilate = {.color = {{.image = reach}}, .uses = {{.resource = tiles}}};
	stilb_gpu_pass gather = {.color = {{.image = near}, {.image = rest}},
	                         .uses = {{.resource = frame->levels}, {.resource = frame->soft}, {.resource = reach}}};
	stilb_gpu_pass combine = {.color = {{.image = out}},
	                          .uses = {{.resource = frame->light},
	                                   {.resource = frame->levels},
	                                   {.resource = reach},
	                                   {.resource = near},
	                                   {.resource = rest}}};
	stilb_result result = lens_pass(frame, POST_LENS_TILES, tile);
	if (result == STILB_OK)
		result = lens_pass(frame, POST_LENS_REACH, dilate);
	if (result == STILB_OK)
		result = lens_pass(frame, POST_LENS_GATHER, gather);
	return result == STILB_OK ? lens_pass(frame, POST_LENS_COMBINE, combine) : result;
}

/* Adds the rows of two blurs, the larger one that of what is infinitely far away. */
static stilb_result lens_lerp(lens_frame *frame, uint16_t out)
{
	static const char *const names[2] = {"defocus narrow", "defocus wide"};
	uint8_t linear = frame->post->linear.id;
	uint16_t blurs[2];
	stilb_result result = STILB_OK;
	frame->push.largest = fmaxf(fminf(frame->push.largest, frame->push.at_infinity), 1.0f);
	for (uint32_t b = 0; b < 2 && result == STILB_OK; b++) {
		blurs[b] = lens_half_image(frame, names[b]);
		frame->push.radius = frame->push.largest * (b == 0 ? LENS_NARROW : 1.0f);
		stilb_gpu_pass blur = {.color = {{.image = blurs[b]}}, .uses = {{.resource = frame->levels}}};
		result = lens_pass(frame, POST_LENS_BLUR, blur);
	}
	frame->push.radius = frame->push.largest * LENS_NARROW;
	stilb_gpu_pass lerp = {.color = {{.image = out}},
	                       .uses = {{.resource = frame->light},
	                                {.resource = frame->levels, .mips = 1},
	                                {.resource = blurs[0], .sampler = linear},
	                                {.resource = blurs[1], .sampler = linear}}};
	return result == STILB_OK ? lens_pass(frame, POST_LENS_LERP, lerp) : result;
}

stilb_result post_lens_add(stilb_post *post, stilb_gpu_plan *plan, uint16_t *light)
{
	const stilb_gpu_extent *extent = stilb_gpu_plan_extent(plan, *light);
	stilb_gpu_plan_image_row row = {
		.name = "depth of field", .format = extent->format, .width = extent->width, .height = extent->height};
	lens_frame frame = {.post = post,
	                    .plan = plan,
	                    .width = extent->width,
	                    .height = extent->height,
	                    .light = *light,
	                    .depth = stilb_gpu_plan_find(plan, STILB_RENDER_IMAGE_DEPTH)};
	frame.blended = stilb_gpu_plan_find(plan, STILB_RENDER_IMAGE_BLENDED_DEPTH);
	frame.blended = frame.blended != 0 ? frame.blended : frame.depth;
	if (frame.depth == 0 || stilb_gpu_plan_extent(plan, frame.depth)->samples > 1 ||
	    !lens_optics(post, row.height, &frame.push))
		return STILB_OK;
	uint16_t out = stilb_gpu_plan_image(plan, &row);
	stilb_result result = lens_levels(&frame);
	if (result == STILB_OK)
		result = post->settings.dof == STILB_POST_DOF_LERP ? lens_lerp(&frame, out) : lens_bokeh(&frame, out);
	*light = out;
	return result;
}

void post_lens_finish(stilb_post *post)
{
	for (uint32_t p = 0; p < POST_LENS_PROGRAMS; p++)
		if (post->lens[p].id != 0)
			stilb_gpu_program_destroy(stilb_render_gpu(post->render), post->lens[p]);
}
