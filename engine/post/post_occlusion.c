/* Occlusion: what hides the surroundings from each pixel, from the frame's depth. */
#include "post/post_internal.h"

#include <string.h>

/* As the shaders have it. */
typedef struct occlusion_push {
	float from_clip[16];
	float radius, strength, smallest;
} occlusion_push;

/* Adds a pass into an image that reads so many others. */
static stilb_result occlusion_pass(stilb_post *post, stilb_gpu_plan *plan, const char *name, post_program number,
                                   uint16_t out, const uint16_t *reads, uint32_t count)
{
	stilb_gpu_program program;
	stilb_result result = post_program_get(post, number, &program);
	if (result != STILB_OK)
		return result;
	occlusion_push push = {.radius = post->settings.occlusion_radius,
	                       .strength = post->settings.occlusion,
	                       .smallest = POST_OCCLUSION_SMALLEST};
	stilb_gpu_pass pass = {.color = {{.image = out}}};
	for (uint32_t u = 0; u < count; u++)
		pass.uses[u].resource = reads[u];
	post_row_fill(&pass, name, program, 1, count);
	if (number != POST_OCCLUSION_SMOOTH) {
		memcpy(push.from_clip, post->from_clip.m, sizeof push.from_clip);
		memcpy(pass.constants, &push, sizeof push);
		pass.constant_bytes = sizeof push;
	}
	stilb_gpu_plan_pass(plan, &pass);
	return STILB_OK;
}

stilb_result post_occlusion_add(stilb_post *post, stilb_gpu_plan *plan, uint16_t *ambient, uint16_t depth)
{
	const stilb_gpu_extent *extent = stilb_gpu_plan_extent(plan, *ambient);
	uint32_t width = extent->width, height = extent->height;
	stilb_gpu_plan_image_row out = {
		.name = "ambient occluded", .format = extent->format, .width = width, .height = height};
	stilb_gpu_plan_image_row half = {
		.name = "visibility asked", .format = STILB_GPU_RG16_F, .width = (width + 1) / 2, .height = (height + 1) / 2};
	uint16_t asked = stilb_gpu_plan_image(plan, &half);
	half.name = "visibility";
	uint16_t smooth = stilb_gpu_plan_image(plan, &half);
	uint16_t occluded = stilb_gpu_plan_image(plan, &out);
	stilb_result result = occlusion_pass(post, plan, "occlusion", POST_OCCLUSION, asked, &depth, 1);
	if (result == STILB_OK)
		result = occlusion_pass(post, plan, "occlusion smoothed", POST_OCCLUSION_SMOOTH, smooth, &asked, 1);
	if (result == STILB_OK)
		result = occlusion_pass(post, plan, "ambient occluded", POST_OCCLUSION_APPLY, occluded,
		                        (uint16_t[]){*ambient, depth, smooth}, 3);
	*ambient = occluded;
	return result;
}
