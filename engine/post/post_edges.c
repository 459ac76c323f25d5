/* Antialiasing of the shown picture, by its edges alone. */
#include "post/post_internal.h"

stilb_result post_edges_add(stilb_post *post, stilb_gpu_plan *plan, uint16_t *picture)
{
	stilb_gpu_extent extent = *stilb_gpu_plan_extent(plan, *picture);
	stilb_gpu_program program;
	if (extent.format != STILB_GPU_RGBA8_SRGB) /* radiance: it has no luma as shown */
		return STILB_OK;
	stilb_result result = post_program_get(post, STILB_POST_BLOOM_HALF, POST_EDGES, &program);
	if (result != STILB_OK)
		return result;
	stilb_gpu_plan_image_row row = {
		.name = "picture smooth", .format = extent.format, .width = extent.width, .height = extent.height};
	uint16_t smooth = stilb_gpu_plan_image(plan, &row);
	stilb_gpu_plan_pass(plan, &(stilb_gpu_pass){.name = "antialiasing",
	                                            .kind = STILB_GPU_PASS_FULLSCREEN,
	                                            .program = program.id,
	                                            .color = {{.image = smooth, .load = STILB_GPU_LOAD_DISCARD}},
	                                            .color_count = 1,
	                                            .uses = {{.resource = *picture, .how = STILB_GPU_USE_SAMPLED}},
	                                            .use_count = 1});
	*picture = smooth;
	return STILB_OK;
}
