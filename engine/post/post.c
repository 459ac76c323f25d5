/* The chain: what there is of it. */
#include "post/post_internal.h"
#include "post/post_lens.h"
#include "post/post_reflections.h"

#include "render/device/render_images.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define POST_NAME(id, name, text) name,
const char *const stilb_post_bloom_format_names[] = {STILB_POST_BLOOM_FORMATS(POST_NAME) NULL};
const char *const stilb_post_place_names[] = {STILB_POST_PLACES(POST_NAME) NULL};
const char *const stilb_post_dither_names[] = {STILB_POST_DITHERS(POST_NAME) NULL};
const char *const stilb_post_aa_names[] = {STILB_POST_AAS(POST_NAME) NULL};
const char *const stilb_post_reflections_names[] = {STILB_POST_REFLECTIONS_WAYS(POST_NAME) NULL};
const char *const stilb_post_motion_names[] = {STILB_POST_MOTIONS(POST_NAME) NULL};
const char *const stilb_post_dof_names[] = {STILB_POST_DOFS(POST_NAME) NULL};

static bool post_is_share(float value)
{
	return value >= 0.0f && value <= 1.0f;
}

bool stilb_post_settings_are_valid(const stilb_post_settings *settings)
{
	STILB_ASSERT(settings);
	return post_is_share(settings->occlusion) && settings->occlusion_radius >= 0.0f &&
	       isfinite(settings->occlusion_radius) && post_is_share(settings->bloom) &&
	       post_is_share(settings->bloom_width) && (unsigned)settings->bloom_format < STILB_POST_BLOOM_FORMATS_COUNT &&
	       (unsigned)settings->place < STILB_POST_PLACES_COUNT &&
	       (unsigned)settings->dither < STILB_POST_DITHERS_COUNT && post_exposure_is_valid(settings) &&
	       (unsigned)settings->aa < STILB_POST_AA_COUNT && post_is_share(settings->motion_blur) &&
	       post_is_share(settings->motion_blur_most) && (unsigned)settings->motion < STILB_POST_MOTION_COUNT &&
	       settings->motion_blur_far >= 0.0f && isfinite(settings->motion_blur_far) &&
	       (unsigned)settings->reflections < STILB_POST_REFLECTIONS_COUNT && post_lens_is_valid(settings);
}

stilb_post_settings stilb_post_settings_filled(const stilb_post_settings *settings)
{
	STILB_ASSERT(stilb_post_settings_are_valid(settings));
	stilb_post_settings filled = *settings;
	if (filled.bloom_width == 0.0f)
		filled.bloom_width = POST_BLOOM_DEFAULT_WIDTH;
	if (filled.motion_blur_most == 0.0f)
		filled.motion_blur_most = POST_MOTION_DEFAULT_MOST;
	if (filled.motion_blur_far == 0.0f)
		filled.motion_blur_far = POST_MOTION_DEFAULT_FAR;
	if (filled.occlusion_radius == 0.0f)
		filled.occlusion_radius = POST_OCCLUSION_DEFAULT_RADIUS;
	post_exposure_defaults(&filled);
	return filled;
}

/* ---- the chain --------------------------------------------------------------------------------------------------- */

/* True if the CPU's threads compute what becomes of this image. */
static bool post_is_by_cpu(const stilb_post *post, const stilb_gpu_plan *plan, uint16_t image)
{
	bool cpu = post->settings.place == STILB_POST_PLACE_AUTO ? stilb_render_device_is_software(post->render)
	                                                         : post->settings.place == STILB_POST_PLACE_CPU;
	return cpu && stilb_gpu_plan_extent(plan, image)->format == STILB_GPU_RGBA16_F;
}

static stilb_result post_bloom_choose(stilb_post *post, stilb_gpu_plan *plan, uint16_t *light)
{
	bool fixed = post->settings.place == STILB_POST_PLACE_AUTO && post->settings.bloom_format == STILB_POST_BLOOM_FIXED;
	return post_is_by_cpu(post, plan, *light) && !fixed ? post_host_bloom_add(post, plan, light)
	                                                    : post_bloom_add(post, plan, light);
}

static stilb_result post_add_light(void *user, stilb_gpu_plan *plan, uint16_t *light)
{
	stilb_post *post = user;
	const stilb_post_settings *settings = &post->settings;
	stilb_result result = STILB_OK;
	if (settings->aa == STILB_POST_AA_TEMPORAL && post->follows)
		result = post_temporal_add(post, plan, light);
	bool lens = settings->dof != STILB_POST_DOF_OFF && settings->aperture > 0.0f;
	if (result == STILB_OK && lens && post->sees && post->shaded)
		result = post_lens_add(post, plan, light);
	if (result == STILB_OK && settings->motion_blur > 0.0f && post->follows && post->whole == 0)
		result = post_motion_add(post, plan, light);
	if (result == STILB_OK && settings->exposure_adapts && post->shows_light && post->whole == 0)
		result = post_exposure_add(post, plan, *light);
	return result == STILB_OK && settings->bloom > 0.0f && post->shaded ? post_bloom_choose(post, plan, light) : result;
}

static stilb_result post_add_ambient(void *user, stilb_gpu_plan *plan, uint16_t *ambient)
{
	stilb_post *post = user;
	uint16_t depth = stilb_gpu_plan_find(plan, STILB_RENDER_IMAGE_DEPTH);
	post->ambient = *ambient;
	if (post->settings.occlusion == 0.0f || !post->sees || !post->shaded)
		return STILB_OK;
	STILB_ASSERT(depth != 0);
	bool floats = stilb_gpu_plan_extent(plan, depth)->format == STILB_GPU_D32_F;
	stilb_result result = post_is_by_cpu(post, plan, *ambient) && floats
	                          ? post_host_occlusion_add(post, plan, ambient, depth)
	                          : post_occlusion_add(post, plan, ambient, depth);
	post->ambient = *ambient;
	return result;
}

static stilb_result post_add_reflection(void *user, stilb_gpu_plan *plan, uint16_t *reflection)
{
	stilb_post *post = user;
	bool is_there = post->settings.reflections != STILB_POST_REFLECTIONS_OFF && post->sees && post->shaded;
	return is_there ? post_reflections_add(post, plan, reflection) : STILB_OK;
}

static stilb_result post_add_picture(void *user, stilb_gpu_plan *plan, uint16_t *picture)
{
	stilb_post *post = user;
	return post->settings.aa == STILB_POST_AA_POST ? post_edges_add(post, plan, picture) : STILB_OK;
}

stilb_result stilb_post_create(stilb_render *render, stilb_post **post)
{
	STILB_ASSERT(render && post);
	stilb_gpu_sampler_desc linear = {.linear = true};
	*post = NULL;
	stilb_post *made = calloc(1, sizeof *made);
	if (!made)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the chain of effects");
	made->render = render;
	made->shows_light = made->shaded = true;
	stilb_result result = stilb_gpu_sampler_get(stilb_render_gpu(render), &linear, &made->linear);
	if (result == STILB_OK)
		result = stilb_render_add_feature(
			render,
			&(stilb_render_feature){.stage = STILB_RENDER_STAGE_AMBIENT, .add = post_add_ambient, .user = made});
	if (result == STILB_OK)
		result = stilb_render_add_feature(
			render,
			&(stilb_render_feature){.stage = STILB_RENDER_STAGE_REFLECTION, .add = post_add_reflection, .user = made});
	if (result == STILB_OK)
		result = stilb_render_add_feature(
			render, &(stilb_render_feature){.stage = STILB_RENDER_STAGE_LIGHT, .add = post_add_light, .user = made});
	if (result == STILB_OK)
		result = stilb_render_add_feature(
			render,
			&(stilb_render_feature){.stage = STILB_RENDER_STAGE_PICTURE, .add = post_add_picture, .user = made});
	if (result != STILB_OK) {
		stilb_render_remove_feature(render, made);
		free(made);
		return result;
	}
	*post = made;
	return STILB_OK;
}

void stilb_post_destroy(stilb_post *post)
{
	if (!post)
		return;
	stilb_render_remove_feature(post->render, post);
	post_exposure_finish(post);
	post_grade_finish(post);
	post_lens_finish(post);
	post_reflections_finish(post);
	for (uint32_t f = 0; f < STILB_POST_BLOOM_FORMATS_COUNT; f++)
		for (uint32_t p = 0; p < POST_PROGRAMS; p++)
			if (post->programs[f][p].id)
				stilb_gpu_program_destroy(stilb_render_gpu(post->render), post->programs[f][p]);
	post_cpu_destroy(post->cpu);
	for (uint32_t m = 0; m < POST_MAPPED; m++)
		stilb_gpu_buffer_destroy(stilb_render_gpu(post->render), post->mapped[m]);
	free(post);
}

void stilb_post_set_pool(stilb_post *post, stilb_job_pool *pool)
{
	STILB_ASSERT(post);
	post->pool = pool;
}

void stilb_post_set(stilb_post *post, const stilb_post_settings *settings)
{
	STILB_ASSERT(post && settings);
	post->settings = stilb_post_settings_filled(settings);
	if (!post->settings.exposure_adapts)
		post_exposure_finish(post);
}

void stilb_post_hold(stilb_post *post, bool held)
{
	STILB_ASSERT(post);
	post->held = held;
}

void stilb_post_set_whole(stilb_post *post, uint32_t height)
{
	STILB_ASSERT(post);
	post->whole = height;
	post->forgotten = true;
}

void stilb_post_see(stilb_post *post, const stilb_render_view *view)
{
	STILB_ASSERT(post && view && isfinite(view->exposure));
	stilb_mat4 around = stilb_mat4_identity();
	memcpy(&around.m[12], view->camera_position, sizeof view->camera_position);
	around = stilb_mat4_multiply(stilb_render_view_drawn(view), around);
	post->exposure = view->exposure;
	post->shaded = view->show == STILB_RENDER_SHOW_SHADED;
	post->shows_light = post->shaded || view->show == STILB_RENDER_SHOW_ERROR;
	post->to_clip = around;
	post->from_clip = stilb_mat4_inverse(&around);
	post->sees = post->from_clip.m[15] != 0.0f || post->from_clip.m[11] != 0.0f;
	for (int i = 0; i < 16; i++)
		post->sees &= isfinite(post->from_clip.m[i]);
	post->follows = post->sees && view->last && view->show == STILB_RENDER_SHOW_SHADED;
	if (post->follows) {
		stilb_mat4 last = stilb_mat4_identity();
		memcpy(&last.m[12], view->camera_position, sizeof view->camera_position);
		last = stilb_mat4_multiply(stilb_render_view_drawn_last(view), last);
		post->to_last = stilb_mat4_multiply(last, post->from_clip);
	}
}
