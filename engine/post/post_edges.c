/* Antialiasing of the shown picture, by its edges alone. */
#include "post/post_internal.h"

stilb_result post_edges_add(stilb_post *post, stilb_gpu_plan *plan, uint16_t *picture)
{
	stilb_gpu_extent extent = *stilb_gpu_plan_extent(plan, *picture);
	stilb_gpu_program program;
	if (extent.format != STILB_GPU_RGBA8_SRGB) /* radiance: it has no luma as shown */
		return STILB_OK;
	stilb_result result = post_program_get(post, POST_EDGES, &program);
	if (result != STILB_OK)
		return result;
	stilb_gpu_plan_image_row row = {
		.name = "picture smooth", .format = extent.format, .width = extent.width, .height = extent.height};
	uint16_t smooth = stilb_gpu_plan_image(plan, &row);
	stilb_gpu_pass pass = {.color = {{.image = smooth}}, .uses = {{.resource = *picture}}};
	post_row_fill(&pass, "antialiasing", program, 1, 1);
	stilb_gpu_plan_pass(plan, &pass);
	*picture = smooth;
	return STILB_OK;
}
