/* Effects by the CPU's threads, as rows of the plan: the light is copied to memory, a function works on it, and it is
 * copied back. */
#include "post/cpu/post_cpu.h"
#include "post/post_internal.h"

static void host_bloom(void *user)
{
	stilb_post *post = user;
	post_cpu_bloom(post->cpu, &post->settings, stilb_gpu_buffer_mapped(stilb_render_gpu(post->render), post->mapped));
}

/* Makes the buffer as large as the light. */
static stilb_result host_fit(stilb_post *post, uint64_t bytes)
{
	if (post->mapped_bytes == bytes)
		return STILB_OK;
	stilb_gpu *gpu = stilb_render_gpu(post->render);
	stilb_gpu_buffer_desc desc = {
		.name = "post", .bytes = bytes, .memory = STILB_GPU_MEMORY_SHARED, .uses = STILB_GPU_BUFFER_COPY};
	stilb_gpu_buffer made;
	stilb_result result = stilb_gpu_buffer_create(gpu, &desc, &made);
	if (result != STILB_OK)
		return result;
	stilb_gpu_buffer_destroy(gpu, post->mapped);
	post->mapped = made;
	post->mapped_bytes = bytes;
	return STILB_OK;
}

static void host_copy(stilb_gpu_plan *plan, const char *name, uint16_t from, uint16_t to)
{
	stilb_gpu_plan_pass(plan, &(stilb_gpu_pass){.name = name,
	                                            .kind = STILB_GPU_PASS_COPY,
	                                            .uses = {{.resource = from, .how = STILB_GPU_USE_COPY_FROM},
	                                                     {.resource = to, .how = STILB_GPU_USE_COPY_TO}},
	                                            .use_count = 2});
}

stilb_result post_host_bloom_add(stilb_post *post, stilb_gpu_plan *plan, uint16_t *light)
{
	const stilb_gpu_extent *extent = stilb_gpu_plan_extent(plan, *light);
	STILB_ASSERT(extent->format == STILB_GPU_RGBA16_F);
	stilb_gpu_plan_image_row row = {
		.name = "bloomed", .format = extent->format, .width = extent->width, .height = extent->height};
	uint64_t bytes = (uint64_t)extent->width * extent->height * 8;
	stilb_result result = post->cpu ? STILB_OK : post_cpu_create(&post->cpu);
	if (result == STILB_OK)
		result = post_cpu_fit(post->cpu, extent->width, extent->height, post->pool);
	if (result == STILB_OK)
		result = host_fit(post, bytes);
	if (result != STILB_OK)
		return result;
	uint16_t bloomed = stilb_gpu_plan_image(plan, &row);
	uint16_t mapped = stilb_gpu_plan_buffer(
		plan, &(stilb_gpu_plan_buffer_row){.name = "post", .bytes = bytes, .owned = post->mapped.id});
	host_copy(plan, "light to memory", *light, mapped);
	stilb_gpu_plan_pass(plan, &(stilb_gpu_pass){.name = "bloom",
	                                            .kind = STILB_GPU_PASS_HOST,
	                                            .host = host_bloom,
	                                            .host_user = post,
	                                            .uses = {{.resource = mapped, .how = STILB_GPU_USE_HOST}},
	                                            .use_count = 1});
	host_copy(plan, "light from memory", mapped, bloomed);
	*light = bloomed;
	return STILB_OK;
}
