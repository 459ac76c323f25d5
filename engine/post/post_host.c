/* Effects by the CPU's threads, as rows of the plan: images are copied to memory, a function works on them, and what it
 * has changed is copied back. */
#include "post/post_internal.h"

/* A buffer for the texels of an image, as large as they are. */
static stilb_result host_fit(stilb_post *post, post_mapped which, uint64_t bytes)
{
	static const char *const names[POST_MAPPED] = {"post light", "post ambient", "post depth"};
	if (post->mapped_bytes[which] == bytes)
		return STILB_OK;
	stilb_gpu *gpu = stilb_render_gpu(post->render);
	stilb_gpu_buffer_desc desc = {
		.name = names[which], .bytes = bytes, .memory = STILB_GPU_MEMORY_SHARED, .uses = STILB_GPU_BUFFER_COPY};
	stilb_gpu_buffer made;
	stilb_result result = stilb_gpu_buffer_create(gpu, &desc, &made);
	if (result != STILB_OK)
		return result;
	stilb_gpu_buffer_destroy(gpu, post->mapped[which]);
	post->mapped[which] = made;
	post->mapped_bytes[which] = bytes;
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

/* The row of the buffer. */
static uint16_t host_row(const stilb_post *post, stilb_gpu_plan *plan, post_mapped which)
{
	static const char *const names[POST_MAPPED] = {"light in memory", "ambient in memory", "depth in memory"};
	return stilb_gpu_plan_buffer(plan, &(stilb_gpu_plan_buffer_row){.name = names[which],
	                                                                .bytes = post->mapped_bytes[which],
	                                                                .owned = post->mapped[which].id});
}

static void *host_texels(const stilb_post *post, post_mapped which)
{
	return stilb_gpu_buffer_mapped(stilb_render_gpu(post->render), post->mapped[which]);
}

/* Makes memory for effects on this image of half floats, and its buffer. */
static stilb_result host_begin(stilb_post *post, post_mapped which, const stilb_gpu_extent *extent)
{
	STILB_ASSERT(extent->format == STILB_GPU_RGBA16_F);
	stilb_result result = post->cpu ? STILB_OK : post_cpu_create(&post->cpu);
	if (result == STILB_OK)
		result = post_cpu_fit(post->cpu, extent->width, extent->height, post->pool);
	return result == STILB_OK ? host_fit(post, which, (uint64_t)extent->width * extent->height * 8) : result;
}

/* ---- bloom ------------------------------------------------------------------------------------------------------- */

static void host_bloom(void *user)
{
	stilb_post *post = user;
	post_cpu_bloom(post->cpu, &post->settings, host_texels(post, POST_MAPPED_LIGHT));
}

stilb_result post_host_bloom_add(stilb_post *post, stilb_gpu_plan *plan, uint16_t *light)
{
	const stilb_gpu_extent *extent = stilb_gpu_plan_extent(plan, *light);
	stilb_gpu_plan_image_row row = {
		.name = "bloomed", .format = extent->format, .width = extent->width, .height = extent->height};
	stilb_result result = host_begin(post, POST_MAPPED_LIGHT, extent);
	if (result != STILB_OK)
		return result;
	uint16_t bloomed = stilb_gpu_plan_image(plan, &row), mapped = host_row(post, plan, POST_MAPPED_LIGHT);
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

/* ---- occlusion --------------------------------------------------------------------------------------------------- */

static void host_occlusion(void *user)
{
	stilb_post *post = user;
	post_cpu_occlusion(post->cpu, &post->settings, &post->from_clip, host_texels(post, POST_MAPPED_DEPTH),
	                   host_texels(post, POST_MAPPED_AMBIENT));
}

stilb_result post_host_occlusion_add(stilb_post *post, stilb_gpu_plan *plan, uint16_t *ambient, uint16_t depth)
{
	const stilb_gpu_extent *extent = stilb_gpu_plan_extent(plan, *ambient);
	stilb_gpu_plan_image_row row = {
		.name = "ambient occluded", .format = extent->format, .width = extent->width, .height = extent->height};
	stilb_result result = host_begin(post, POST_MAPPED_AMBIENT, extent);
	if (result == STILB_OK)
		result = host_fit(post, POST_MAPPED_DEPTH, (uint64_t)extent->width * extent->height * 4);
	if (result != STILB_OK)
		return result;
	uint16_t occluded = stilb_gpu_plan_image(plan, &row);
	uint16_t mapped = host_row(post, plan, POST_MAPPED_AMBIENT), depths = host_row(post, plan, POST_MAPPED_DEPTH);
	host_copy(plan, "depth to memory", depth, depths);
	host_copy(plan, "ambient to memory", *ambient, mapped);
	stilb_gpu_plan_pass(plan, &(stilb_gpu_pass){.name = "occlusion",
	                                            .kind = STILB_GPU_PASS_HOST,
	                                            .host = host_occlusion,
	                                            .host_user = post,
	                                            .uses = {{.resource = mapped, .how = STILB_GPU_USE_HOST},
	                                                     {.resource = depths, .how = STILB_GPU_USE_HOST}},
	                                            .use_count = 2});
	host_copy(plan, "ambient from memory", mapped, occluded);
	*ambient = occluded;
	return STILB_OK;
}
