/* Shared by the tests of post: frames whose light is a picture of the test's, and what the chain makes of it. */
#ifndef POST_STAGE_H
#define POST_STAGE_H

#include "image/image.h"
#include "post/post.h"
#include "support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct post_stage {
	stilb_render *render;
	stilb_post *post;
	stilb_gpu_image source;
	uint32_t width, height;
	float alpha; /* of the light's pixels */
	/* Frames have these, all zeros: nothing moves, and everything is far away. id 0: they have not. */
	stilb_gpu_image velocity, depth, models;
} post_stage;

/* An image of the stage's size. */
static inline stilb_gpu_image stage_image(post_stage *s, const char *name, stilb_gpu_format format)
{
	stilb_gpu_image image;
	stilb_gpu_image_desc desc = {
		.name = name,
		.extent = {.format = format,
	               .width = s->width,
	               .height = s->height,
	               .depth = 1,
	               .layers = 1,
	               .mips = 1,
	               .samples = 1,
	               .uses = 1u << STILB_GPU_USE_SAMPLED | 1u << STILB_GPU_USE_COPY_FROM | 1u << STILB_GPU_USE_COPY_TO}};
	assert_int_equal(stilb_gpu_image_create(stilb_render_gpu(s->render), &desc, &image), STILB_OK);
	return image;
}

static inline uint16_t stage_row(const post_stage *s, stilb_gpu_plan *plan, const char *name, stilb_gpu_format format,
                                 stilb_gpu_image image)
{
	stilb_gpu_plan_image_row row = {
		.name = name, .format = format, .width = s->width, .height = s->height, .owned = image.id};
	return stilb_gpu_plan_image(plan, &row);
}

/* Puts the test's image in the place of the light. */
static inline stilb_result stage_source(void *user, stilb_gpu_plan *plan, uint16_t *image)
{
	post_stage *s = user;
	*image = stage_row(s, plan, "source", STILB_GPU_RGBA16_F, s->source);
	if (s->velocity.id == 0)
		return STILB_OK;
	stage_row(s, plan, "velocity", STILB_GPU_RG16_F, s->velocity);
	stage_row(s, plan, "velocity depth", STILB_GPU_R32_F, s->depth);
	stage_row(s, plan, "id", STILB_GPU_R32_UI, s->models);
	return STILB_OK;
}

static inline void stage_source_make(post_stage *s)
{
	s->source = stage_image(s, "source", STILB_GPU_RGBA16_F);
}

static inline void stage_open_for(post_stage *s, stilb_render_device_kind device, stilb_render_output output,
                                  uint32_t width, uint32_t height)
{
	*s = (post_stage){.width = width, .height = height, .alpha = 1.0f};
	stilb_render_desc desc = {.device = device,
	                          .output = output,
	                          .width = width,
	                          .height = height,
	                          .samples = 1,
	                          .context_count = 1,
	                          .validate = true};
	if (stilb_render_create(&desc, &s->render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stage_source_make(s);
	stilb_render_feature feature = {STILB_RENDER_STAGE_LIGHT, stage_source, s};
	assert_int_equal(stilb_render_add_feature(s->render, &feature), STILB_OK);
	assert_int_equal(stilb_post_create(s->render, &s->post), STILB_OK);
}

static inline void stage_open(post_stage *s, stilb_render_device_kind device, uint32_t width, uint32_t height)
{
	stage_open_for(s, device, STILB_RENDER_OUTPUT_LINEAR, width, height);
}

static inline void stage_close(post_stage *s)
{
	assert_int_equal(stilb_render_validation_messages(s->render), 0);
	stilb_post_destroy(s->post);
	stilb_gpu_image images[] = {s->source, s->velocity, s->depth, s->models};
	for (uint32_t i = 0; i < (s->velocity.id == 0 ? 1 : 4); i++)
		stilb_gpu_image_destroy(stilb_render_gpu(s->render), images[i]);
	stilb_render_destroy(s->render);
}

/* Another size of the picture, whose light is then to be given. */
static inline void stage_resize(post_stage *s, uint32_t width, uint32_t height)
{
	assert_int_equal(stilb_render_resize(s->render, width, height), STILB_OK);
	stilb_gpu_image_destroy(stilb_render_gpu(s->render), s->source);
	s->width = width;
	s->height = height;
	stage_source_make(s);
}

/* Gives frames images of what does not move. */
static inline void stage_still(post_stage *s)
{
	stilb_gpu *gpu = stilb_render_gpu(s->render);
	s->velocity = stage_image(s, "velocity", STILB_GPU_RG16_F);
	s->depth = stage_image(s, "velocity depth", STILB_GPU_R32_F);
	s->models = stage_image(s, "id", STILB_GPU_R32_UI);
	stilb_gpu_image images[] = {s->velocity, s->depth, s->models};
	for (uint32_t i = 0; i < 3; i++) {
		stilb_gpu_upload upload = {.image = images[i],
		                           .width = s->width,
		                           .height = s->height,
		                           .depth = 1,
		                           .bytes = (uint64_t)s->width * s->height * 4};
		void *bytes;
		assert_int_equal(stilb_gpu_upload_begin(gpu, &upload, &bytes), STILB_OK);
		memset(bytes, 0, upload.bytes);
		stilb_gpu_upload_end(gpu, bytes);
	}
}

/* The light that the next frames have: RGB, rows from the top. */
static inline void stage_light(post_stage *s, const float *rgb)
{
	stilb_gpu *gpu = stilb_render_gpu(s->render);
	uint32_t pixels = s->width * s->height;
	stilb_gpu_upload upload = {
		.image = s->source, .width = s->width, .height = s->height, .depth = 1, .bytes = (uint64_t)pixels * 8};
	void *bytes;
	assert_int_equal(stilb_gpu_upload_begin(gpu, &upload, &bytes), STILB_OK);
	assert_non_null(bytes);
	uint16_t *out = bytes;
	for (uint32_t p = 0; p < pixels; p++)
		for (uint32_t c = 0; c < 4; c++)
			out[4 * p + c] = stilb_image_half_from_float(c == 3 ? s->alpha : rgb[3 * p + c]);
	stilb_gpu_upload_end(gpu, bytes);
}

static inline stilb_render_view stage_view(void)
{
	return (stilb_render_view){.view_projection = stilb_mat4_identity(),
	                           .shading = stilb_render_shading_default(),
	                           .backdrop = {.kind = STILB_SCENE_BACKDROP_NOTHING}};
}

/* Draws a frame without draws. */
static inline void stage_draw_view(post_stage *s, stilb_render_view view)
{
	stilb_render_pass pass = {.name = "scene"};
	assert_int_equal(stilb_render_frame_begin(s->render), STILB_OK);
	assert_int_equal(stilb_render_pass_begin(s->render, 0, 0), STILB_OK);
	assert_int_equal(stilb_render_pass_end(s->render, 0), STILB_OK);
	if (stilb_render_replay(s->render, &pass, 1, &view, 1, NULL, 0) != STILB_OK)
		fail_msg("%s", stilb_error_message());
}

static inline void stage_draw(post_stage *s)
{
	stage_draw_view(s, stage_view());
}

/* What a frame shows, RGB; to be freed. */
static inline float *stage_shown(post_stage *s)
{
	stilb_image image = {0};
	stage_draw(s);
	if (stilb_render_read_image(s->render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(image.format, STILB_IMAGE_F16_LINEAR);
	assert_int_equal(image.width * image.height, s->width * s->height);
	float *rgb = calloc((size_t)s->width * s->height, 3 * sizeof *rgb);
	assert_non_null(rgb);
	assert_int_equal(image.channels, 4); /* there is no backdrop */
	for (uint32_t p = 0; p < s->width * s->height; p++) {
		const uint16_t *texel = (const uint16_t *)image.pixels + (size_t)4 * p;
		for (uint32_t c = 0; c < 3; c++)
			rgb[3 * p + c] = stilb_image_half_to_float(texel[c]);
		assert_true(stilb_image_half_to_float(texel[3]) == s->alpha);
	}
	stilb_image_finish(&image);
	return rgb;
}

#endif
