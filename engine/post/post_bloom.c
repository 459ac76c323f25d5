/* Bloom: the light is halved in size until it is a few texels high, and added up on the way back. */
#include "post/post_internal.h"
#include "post/post_levels.h"

#include <math.h>
#include <string.h>

/* As the shaders have it. */
typedef struct bloom_push {
	float texel[2]; /* 1 / the texels of the image that is filtered */
	float share;    /* of that image in what is written */
	float exposure; /* factor */
} bloom_push;

/* A level is half as large as the one before it, the first half as large as the light; rounded up. */
typedef struct bloom_level {
	uint16_t halved; /* the light in this size */
	uint16_t summed; /* what is scattered from this level on; of the last one `halved` */
	uint32_t width, height;
} bloom_level;

typedef struct bloom_chain {
	stilb_post *post;
	stilb_gpu_plan *plan;
	bloom_level levels[POST_LEVELS];
	uint32_t count;
} bloom_chain;

static const char *const bloom_halved_names[POST_LEVELS] = {
	"bloom halved",   "bloom halved 2", "bloom halved 3", "bloom halved 4",  "bloom halved 5",  "bloom halved 6",
	"bloom halved 7", "bloom halved 8", "bloom halved 9", "bloom halved 10", "bloom halved 11", "bloom halved 12"};
static const char *const bloom_summed_names[POST_LEVELS] = {"bloom",   "bloom 2",  "bloom 3",  "bloom 4",
                                                            "bloom 5", "bloom 6",  "bloom 7",  "bloom 8",
                                                            "bloom 9", "bloom 10", "bloom 11", "bloom 12"};

static uint16_t bloom_image(const bloom_chain *chain, const char *name, const bloom_level *level)
{
	bool fixed = chain->post->settings.bloom_format == STILB_POST_BLOOM_FIXED;
	stilb_gpu_plan_image_row row = {.name = name,
	                                .format = fixed ? STILB_GPU_RGBA8_SRGB : STILB_GPU_RGBA16_F,
	                                .width = level->width,
	                                .height = level->height};
	return stilb_gpu_plan_image(chain->plan, &row);
}

/* Adds the images of all levels that a light of this size has. */
static void bloom_levels(bloom_chain *chain, const post_levels *sizes)
{
	chain->count = sizes->count;
	for (uint32_t l = 0; l < sizes->count; l++) {
		bloom_level *level = &chain->levels[l];
		level->width = sizes->sizes[l][0];
		level->height = sizes->sizes[l][1];
		level->halved = bloom_image(chain, bloom_halved_names[l], level);
	}
	chain->levels[chain->count - 1].summed = chain->levels[chain->count - 1].halved;
	for (uint32_t l = 0; l + 1 < chain->count; l++)
		chain->levels[l].summed = bloom_image(chain, bloom_summed_names[l], &chain->levels[l]);
}

/* Adds a pass that filters an image of the size of width x height, and reads a second one, 0: none, texel by texel. */
static stilb_result bloom_pass(bloom_chain *chain, post_program number, uint16_t out, uint16_t filtered, uint32_t width,
                               uint32_t height, uint16_t plain, float share)
{
	static const char *const names[POST_PROGRAMS] = {"bloom halved", "bloom halved", "bloom summed", "bloom"};
	stilb_gpu_program program;
	stilb_result result = post_program_get(chain->post, number, &program);
	if (result != STILB_OK)
		return result;
	bloom_push push = {
		.texel = {1.0f / (float)width, 1.0f / (float)height}, .share = share, .exposure = exp2f(chain->post->exposure)};
	stilb_gpu_pass pass = {
		.color = {{.image = out}},
		.uses = {{.resource = filtered, .sampler = chain->post->linear.id}, {.resource = plain}},
		.constant_bytes = sizeof push,
	};
	post_row_fill(&pass, names[number], program, 1, plain != 0 ? 2 : 1);
	memcpy(pass.constants, &push, sizeof push);
	stilb_gpu_plan_pass(chain->plan, &pass);
	return STILB_OK;
}

stilb_result post_bloom_add(stilb_post *post, stilb_gpu_plan *plan, uint16_t *light)
{
	const stilb_gpu_extent *extent = stilb_gpu_plan_extent(plan, *light);
	stilb_gpu_plan_image_row row = {
		.name = "bloomed", .format = extent->format, .width = extent->width, .height = extent->height};
	uint32_t width = extent->width, height = extent->height;
	bloom_chain chain = {.post = post, .plan = plan};
	post_levels sizes = post_levels_of(width, height);
	bloom_levels(&chain, &sizes);
	uint16_t bloomed = stilb_gpu_plan_image(plan, &row);
	stilb_result result = STILB_OK;
	for (uint32_t l = 0; l < chain.count && result == STILB_OK; l++) {
		const bloom_level *level = &chain.levels[l], *finer = &chain.levels[l > 0 ? l - 1 : 0];
		result = l == 0 ? bloom_pass(&chain, POST_BLOOM_HALVE_FIRST, level->halved, *light, width, height, 0, 0.0f)
		                : bloom_pass(&chain, POST_BLOOM_HALVE, level->halved, finer->halved, finer->width,
		                             finer->height, 0, 0.0f);
	}
	for (uint32_t l = chain.count - 1; l-- > 0 && result == STILB_OK;) {
		const bloom_level *level = &chain.levels[l], *wider = level + 1;
		float share = l < sizes.first ? 1.0f : post->settings.bloom_width;
		result = bloom_pass(&chain, POST_BLOOM_DOUBLE, level->summed, wider->summed, wider->width, wider->height,
		                    level->halved, share);
	}
	const bloom_level *finest = &chain.levels[0];
	if (result == STILB_OK)
		result = bloom_pass(&chain, POST_BLOOM_ADD, bloomed, finest->summed, finest->width, finest->height, *light,
		                    post->settings.bloom);
	*light = bloomed;
	return result;
}
