/* Motion blur: the longest movement of tiles and of those around them, and the row that gathers along it. */
#include "post/post_internal.h"

#include "render/device/render_images.h"

#include <math.h>
#include <string.h>

/* As the shaders have it. */
typedef struct motion_push {
	float ahead_row[4];
	int32_t tile[2];
	float half_way, longest;
} motion_push;

/* Of what is far away. */
typedef struct far_push {
	float to_last[16], ahead_row[4];
	float half_size[2];
	float half_way, longest, far;
} far_push;

typedef struct motion_chain {
	stilb_post *post;
	stilb_gpu_plan *plan;
	motion_push push;
} motion_chain;

static uint16_t motion_image(const motion_chain *chain, const char *name, uint32_t width, uint32_t height, bool keep)
{
	stilb_gpu_plan_image_row row = {
		.name = name, .format = STILB_GPU_RG16_F, .width = width, .height = height, .keep = keep};
	return stilb_gpu_plan_image(chain->plan, &row);
}

/* Adds a pass into an image that reads so many others, the last of them as it was in the frame before, or not. tile_*:
 * what is one texel of its image, of the first that it reads. */
static stilb_result motion_pass(motion_chain *chain, const char *name, post_program number, uint16_t out,
                                const uint16_t *reads, uint32_t count, bool previous, uint32_t tile_x, uint32_t tile_y)
{
	stilb_gpu_program program;
	stilb_result result = post_program_get(chain->post, number, &program);
	if (result != STILB_OK)
		return result;
	stilb_gpu_pass pass = {.color = {{.image = out}}};
	for (uint32_t u = 0; u < count; u++)
		pass.uses[u] = (stilb_gpu_use){.resource = reads[u], .previous = previous && u + 1 == count};
	post_row_fill(&pass, name, program, 1, count);
	if (tile_x > 0) {
		chain->push.tile[0] = (int32_t)tile_x;
		chain->push.tile[1] = (int32_t)tile_y;
		memcpy(pass.constants, &chain->push, sizeof chain->push);
		pass.constant_bytes = sizeof chain->push;
	}
	stilb_gpu_plan_pass(chain->plan, &pass);
	return STILB_OK;
}

/* Adds a pass of the camera's blur of what is far away. */
static stilb_result far_pass(stilb_post *post, stilb_gpu_plan *plan, const far_push *push, post_program number,
                             stilb_gpu_pass pass)
{
	stilb_gpu_program program;
	stilb_result result = post_program_get(post, number, &program);
	if (result != STILB_OK)
		return result;
	bool shows = number == POST_MOTION_FAR_SHOW;
	post_row_fill(&pass, shows ? "motion blur" : "far blur", program, 1, shows ? 3 : 2);
	memcpy(pass.constants, push, sizeof *push);
	pass.constant_bytes = sizeof *push;
	stilb_gpu_plan_pass(plan, &pass);
	return STILB_OK;
}

static stilb_result far_add(stilb_post *post, stilb_gpu_plan *plan, uint16_t *light, uint16_t depth)
{
	stilb_gpu_extent extent = *stilb_gpu_plan_extent(plan, *light);
	const stilb_post_settings *settings = &post->settings;
	far_push push = {.half_size = {0.5f * (float)extent.width, 0.5f * (float)extent.height},
	                 .half_way = 0.5f * settings->motion_blur,
	                 .longest = fmaxf(0.5f * settings->motion_blur_most * (float)extent.height, 1.0f),
	                 .far = settings->motion_blur_far};
	memcpy(push.to_last, post->to_last.m, sizeof push.to_last);
	for (int c = 0; c < 4; c++)
		push.ahead_row[c] = post->from_clip.m[4 * c + 3];
	stilb_gpu_plan_image_row row = {.name = "far blurred",
	                                .format = extent.format,
	                                .width = (extent.width + 1) / 2,
	                                .height = (extent.height + 1) / 2};
	uint16_t small = stilb_gpu_plan_image(plan, &row);
	row = (stilb_gpu_plan_image_row){
		.name = "blurred", .format = extent.format, .width = extent.width, .height = extent.height};
	uint16_t blurred = stilb_gpu_plan_image(plan, &row);
	stilb_gpu_pass blur = {.color = {{.image = small}}, .uses = {{.resource = *light}, {.resource = depth}}};
	stilb_gpu_pass show = {
		.color = {{.image = blurred}},
		.uses = {{.resource = *light}, {.resource = depth}, {.resource = small, .sampler = (uint8_t)post->linear.id}}};
	stilb_result result = far_pass(post, plan, &push, POST_MOTION_FAR, blur);
	if (result == STILB_OK)
		result = far_pass(post, plan, &push, POST_MOTION_FAR_SHOW, show);
	*light = blurred;
	return result;
}

stilb_result post_motion_add(stilb_post *post, stilb_gpu_plan *plan, uint16_t *light)
{
	stilb_gpu_extent extent = *stilb_gpu_plan_extent(plan, *light);
	uint32_t width = extent.width, height = extent.height;
	uint16_t velocity = stilb_gpu_plan_find(plan, STILB_RENDER_IMAGE_VELOCITY);
	uint16_t depth = post_velocity_depth(plan);
	if (velocity == 0 || depth == 0 || extent.format != STILB_GPU_RGBA16_F)
		return STILB_OK;
	if (post->settings.motion == STILB_POST_MOTION_FAR)
		return far_add(post, plan, light, depth);
	float longest = fmaxf(0.5f * post->settings.motion_blur_most * (float)height, 1.0f);
	motion_chain chain = {post, plan, {.half_way = 0.5f * post->settings.motion_blur, .longest = longest}};
	for (int c = 0; c < 4; c++)
		chain.push.ahead_row[c] = post->from_clip.m[4 * c + 3];
	uint32_t tile = (uint32_t)ceilf(longest), columns = (width + tile - 1) / tile, rows = (height + tile - 1) / tile;
	uint16_t kept = motion_image(&chain, "blur velocity", width, height, true);
	uint16_t lines = motion_image(&chain, "blur rows", columns, height, false);
	uint16_t tiles = motion_image(&chain, "blur tiles", columns, rows, false);
	uint16_t around = motion_image(&chain, "blur tiles around", columns, rows, false);
	uint16_t blurred = stilb_gpu_plan_image(
		plan,
		&(stilb_gpu_plan_image_row){.name = "blurred", .format = extent.format, .width = width, .height = height});
	bool held = post->held && stilb_gpu_plan_kept(plan, kept);
	stilb_result result = held
	                          ? motion_pass(&chain, "velocity held", POST_MOTION_KEPT, kept, &kept, 1, true, 0, 0)
	                          : motion_pass(&chain, "velocity kept", POST_MOTION_KEPT, kept, &velocity, 1, false, 0, 0);
	if (result == STILB_OK)
		result = motion_pass(&chain, "blur rows", POST_MOTION_ROWS, lines, &kept, 1, false, tile, 1);
	if (result == STILB_OK)
		result = motion_pass(&chain, "blur tiles", POST_MOTION_TILES, tiles, &lines, 1, false, 1, tile);
	if (result == STILB_OK)
		result = motion_pass(&chain, "blur tiles around", POST_MOTION_AROUND, around, &tiles, 1, false, 0, 0);
	if (result == STILB_OK)
		result = motion_pass(&chain, "motion blur", POST_MOTION, blurred, (uint16_t[]){*light, kept, depth, around}, 4,
		                     false, tile, tile);
	*light = blurred;
	return result;
}
