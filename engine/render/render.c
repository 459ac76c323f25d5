/* Creation, settings and the frame's begin and end: what is the same for all devices. */
#include "render/render_internal.h"
#include "shading/shade_brdf.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

stilb_render_shading stilb_render_shading_default(void)
{
	return (stilb_render_shading){
		.brdf = SHADE_BRDF_BLINN_PHONG_MODIFIED,
		.ndf = SHADE_NDF_GGX,
		.g = SHADE_G_SMITH_GGX,
		.f = SHADE_F_SCHLICK,
	};
}

const char *const stilb_render_show_names[] = {
#define RENDER_SHOW_NAME(id, name, ...) #name,
	STILB_RENDER_SHOWN(RENDER_SHOW_NAME)
#undef RENDER_SHOW_NAME
		NULL};

const char *const stilb_render_show_words[] = {
#define RENDER_SHOW_WORDS(id, name, words, ...) words,
	STILB_RENDER_SHOWN(RENDER_SHOW_WORDS)
#undef RENDER_SHOW_WORDS
		NULL};

#define RENDER_NAME(id, name, words) #name,
#define RENDER_NAME_TEXT(id, name, words) name,
#define RENDER_WORDS(id, name, words) words,
const char *const stilb_render_lighting_names[] = {STILB_RENDER_LIGHTINGS(RENDER_NAME_TEXT) NULL};
const char *const stilb_render_lighting_words[] = {STILB_RENDER_LIGHTINGS(RENDER_WORDS) NULL};
const char *const stilb_render_light_lists_names[] = {STILB_RENDER_LIGHT_LISTS(RENDER_NAME) NULL};
const char *const stilb_render_coverage_names[] = {STILB_RENDER_COVERAGES(RENDER_NAME) NULL};
const char *const stilb_render_gbuffer_names[] = {STILB_RENDER_GBUFFERS(RENDER_NAME) NULL};
const char *const stilb_render_hdr_names[] = {STILB_RENDER_HDR_KINDS(RENDER_NAME) NULL};
const char *const stilb_render_ambient_names[] = {STILB_RENDER_AMBIENTS(RENDER_NAME_TEXT) NULL};
const char *const stilb_render_ambient_words[] = {STILB_RENDER_AMBIENTS(RENDER_WORDS) NULL};
#undef RENDER_NAME
#undef RENDER_NAME_TEXT
#undef RENDER_WORDS

const char *const stilb_render_detail_names[] = {[STILB_RENDER_DETAIL_OFF] = "off",
                                                 [STILB_RENDER_DETAIL_POP] = "pop",
                                                 [STILB_RENDER_DETAIL_FADE] = "fade",
                                                 [STILB_RENDER_DETAIL_MORPH] = "morph",
                                                 NULL};

static bool render_size_is_valid(uint32_t width, uint32_t height)
{
	return width >= 1 && width <= 16384 && height >= 1 && height <= 16384;
}

/* True between pass_begin and pass_end of any pass. */
static bool render_is_recording(const stilb_render *render)
{
	for (uint32_t p = 0; p < STILB_RENDER_MAX_PASSES; p++)
		if (render->passes[p].state == RENDER_LIST_RECORDING)
			return true;
	return false;
}

stilb_result stilb_render_create(const stilb_render_desc *desc, stilb_render **out)
{
	STILB_ASSERT(render_size_is_valid(desc->width, desc->height) && "1..16384 pixels a side");
	STILB_ASSERT(desc->samples == 0 || desc->samples == 1 || desc->samples == 4);
	STILB_ASSERT(desc->max_anisotropy <= 16);
	STILB_ASSERT((uint32_t)desc->specular_aa <= STILB_RENDER_SPECULAR_AA_OFF);
	STILB_ASSERT(desc->context_count >= 1);
	STILB_ASSERT((uint32_t)desc->device <= STILB_RENDER_DEVICE_NULL &&
	             (uint32_t)desc->output <= STILB_RENDER_OUTPUT_LINEAR);
	STILB_ASSERT((uint32_t)desc->replay <= STILB_RENDER_REPLAY_SECONDARY);
	STILB_ASSERT((uint32_t)desc->materials <= STILB_RENDER_MATERIALS_PIPELINE);
	STILB_ASSERT(!desc->surface || (desc->surface->extensions && desc->surface->create));
	*out = NULL;
	stilb_render *render = stilb_memory_alloc(1, sizeof *render);
	if (!render)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the renderer");
	memset(render, 0, sizeof *render);
	stilb_owner_take(&render->owner);
	render->output = desc->output;
	render->specular_aa = desc->specular_aa;
	render->memory[RENDER_MEMORY_COMMANDS].element = sizeof(render_command);
	render->memory[RENDER_MEMORY_COMMANDS].first_capacity = RENDER_FIRST_COMMANDS;
	render->memory[RENDER_MEMORY_ROWS].element = sizeof(render_row);
	render->memory[RENDER_MEMORY_ROWS].first_capacity = RENDER_FIRST_ROWS;
	render->memory[RENDER_MEMORY_VERTICES_2D].element = sizeof(stilb_render_vertex_2d);
	render->memory[RENDER_MEMORY_INDICES_2D].element = sizeof(uint32_t);
	render->memory[RENDER_MEMORY_LIGHTS].element = sizeof(render_light);
	render->memory[RENDER_MEMORY_LIGHT_LISTS].element = sizeof(float[4]);
	stilb_result result = render_contexts_create(render, desc->context_count);
	if (result == STILB_OK)
		result = render_resources_create(&render->resources, desc->keep_textures, !desc->float_vertices);
	render->resources.morph = desc->morph;
	if (result == STILB_OK && desc->faults.textures > 0) /* and one more, which stands for no texture */
		render->resources.indices[RENDER_RESOURCE_TEXTURE].capacity = desc->faults.textures + 1;
	if (result == STILB_OK)
		result = render_device_create(desc, &render->device);
	if (result != STILB_OK) {
		stilb_render_destroy(render);
		return result;
	}
	*out = render;
	return STILB_OK;
}

void stilb_render_own(stilb_render *render)
{
	stilb_owner_take(&render->owner);
	stilb_gpu_own(render->device->gpu);
}

void stilb_render_destroy(stilb_render *render)
{
	if (!render)
		return;
	STILB_ASSERT_OWNER(render->owner);
	if (render->device) {
		stilb_gpu_wait(render->device->gpu); /* a device that is lost uses nothing any more */
		render_places_finish(render, &render->scene.places, false);
		render_rows_finish(render);
		render_device_destroy(render->device);
	}
	render_contexts_destroy(render);
	for (uint32_t p = 0; p < STILB_RENDER_MAX_PASSES; p++) {
		free(render->passes[p].segments);
		free(render->passes[p].runs);
		free(render->passes[p].history);
		free(render->passes[p].impostors);
		render_combined_pass_finish(&render->passes[p].combined);
	}
	render_scene_finish(&render->scene);
	render_panorama_finish(&render->panorama);
	render_resources_destroy(&render->resources);
	free(render->sort_items);
	render_order_finish(&render->order);
	stilb_light_lists_finish(&render->lists);
	render_combined_finish(&render->combined);
	free(render);
}

void stilb_render_set_textures(stilb_render *render, stilb_render_textures textures)
{
	STILB_ASSERT_OWNER(render->owner);
	atomic_store_explicit(&render->textures, (int)textures, memory_order_relaxed); /* partner: render_textures_mode */
}

uint32_t stilb_render_textures_left(const stilb_render *render)
{
	STILB_ASSERT_OWNER(render->owner);
	return render->scene.loading ? render->scene.loading->left : 0;
}

void stilb_render_set_pool(stilb_render *render, stilb_job_pool *pool)
{
	STILB_ASSERT_OWNER(render->owner);
	render->pool = pool;
}

const char *stilb_render_device_name(const stilb_render *render)
{
	return stilb_gpu_name(render->device->gpu);
}

bool stilb_render_device_is_software(const stilb_render *render)
{
	return stilb_gpu_is_software(render->device->gpu);
}

stilb_result stilb_render_reserve_target(stilb_render *render, const stilb_render_target *target)
{
	STILB_ASSERT(render && target && target->kind == STILB_RENDER_TARGET_DEPTH && target->lasting);
	return render_target_reserve(render->device, target);
}

uint32_t stilb_render_samples(const stilb_render *render)
{
	return render->device->samples;
}

stilb_gpu_presentation stilb_render_presentation_used(const stilb_render *render)
{
	STILB_ASSERT_OWNER(render->owner);
	return stilb_gpu_presentation_used(render->device->gpu);
}

uint32_t stilb_render_validation_messages(const stilb_render *render)
{
	STILB_ASSERT_OWNER(render->owner);
	return stilb_gpu_validation_messages(render->device->gpu);
}

stilb_result stilb_render_set_context_count(stilb_render *render, uint32_t context_count)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(context_count >= 1);
	STILB_ASSERT(!render_is_recording(render) && "between frames");
	stilb_result result = render_contexts_create(render, context_count);
	if (result == STILB_OK)
		render_passes_rewind(render); /* their segments point into the old contexts */
	return result;
}

stilb_result stilb_render_resize(stilb_render *render, uint32_t width, uint32_t height)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(render_size_is_valid(width, height) && "1..16384 pixels a side");
	STILB_ASSERT(!render_is_recording(render) && "between frames");
	return render_device_resize(render->device, width, height);
}

void stilb_render_size(const stilb_render *render, uint32_t *width, uint32_t *height)
{
	STILB_ASSERT_OWNER(render->owner);
	*width = render->device->width;
	*height = render->device->height;
}

/* Moves what a matrix projects, in x and y of clip space. */
static stilb_mat4 matrix_moved(const stilb_mat4 *matrix, const float by[2])
{
	stilb_mat4 moved = *matrix;
	for (int c = 0; c < 4; c++)
		for (int r = 0; r < 2; r++)
			moved.m[4 * c + r] += by[r] * moved.m[4 * c + 3];
	return moved;
}

stilb_mat4 stilb_render_view_drawn(const stilb_render_view *view)
{
	STILB_ASSERT(view);
	return matrix_moved(&view->view_projection, view->jitter);
}

stilb_mat4 stilb_render_view_drawn_last(const stilb_render_view *view)
{
	STILB_ASSERT(view);
	return matrix_moved(view->last ? view->last : &view->view_projection, view->jitter);
}

stilb_result stilb_render_frame_begin(stilb_render *render)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(!render_is_recording(render) && "every pass that was begun has ended");
	/* A frame mostly needs as much memory as the one before: growing now saves overflows to the heap. It may need
	 * less, so failing to grow here is no error. Relaxed: no thread claims memory now, so `next` does not change. */
	uint32_t wanted[RENDER_MEMORY_KINDS];
	for (int kind = 0; kind < RENDER_MEMORY_KINDS; kind++)
		wanted[kind] = atomic_load_explicit(&render->memory[kind].next, memory_order_relaxed);
	render_contexts_rewind(render);
	render->state = RENDER_FRAME_NONE;
	stilb_result result = render_device_frame_begin(render->device, render->memory);
	for (int kind = 0; kind < RENDER_MEMORY_KINDS && result == STILB_OK; kind++) {
		render_memory *memory = &render->memory[kind];
		if (wanted[kind] > memory->capacity)
			result = render_device_grow(render->device, memory, (uint32_t)kind, wanted[kind], 0);
		result = result == STILB_ERROR_MEMORY ? STILB_OK : result;
	}
	if (result != STILB_OK)
		return result;
	render_resources_frame(render);
	render_rows_frame(render);
	render->state = RENDER_FRAME_BEGUN;
	return STILB_OK;
}

stilb_result stilb_render_present(stilb_render *render)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(render->state == RENDER_FRAME_REPLAYED);
	return render_device_present(render->device);
}

stilb_result stilb_render_set_surface(stilb_render *render, const stilb_gpu_surface *surface)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(!surface || (surface->extensions && surface->create));
	STILB_ASSERT(!render_is_recording(render) && "between frames");
	return stilb_gpu_set_surface(render->device->gpu, surface);
}

stilb_result stilb_render_wait(stilb_render *render)
{
	STILB_ASSERT_OWNER(render->owner);
	stilb_result result = stilb_gpu_wait(render->device->gpu);
	render->device->stats.gpu_ms = stilb_gpu_stats_get(render->device->gpu).gpu_ms;
	return result;
}

stilb_result stilb_render_read_image(stilb_render *render, stilb_image *image)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(image && !render_is_recording(render) && "between frames");
	return render_device_read_picture(render->device, image);
}

stilb_result stilb_render_read_radiance(stilb_render *render, stilb_image *image)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(image && !render_is_recording(render) && "between frames");
	return render_device_read_light(render->device, image);
}

stilb_result stilb_render_read_for_file(stilb_render *render, const char *path, stilb_image *image)
{
	STILB_ASSERT(path);
	bool light = stilb_image_path_is_light(path) && render->output == STILB_RENDER_OUTPUT_DISPLAY;
	return light ? stilb_render_read_radiance(render, image) : stilb_render_read_image(render, image);
}

void stilb_render_show_image(stilb_render *render, const stilb_render_shown *shown)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(!shown || shown->name);
	render_device *device = render->device;
	device->shown = shown ? *shown : (stilb_render_shown){0};
	if (!shown)
		return;
	snprintf(device->shown_name, sizeof device->shown_name, "%s", shown->name);
	device->shown.name = device->shown_name;
}

void stilb_render_until(stilb_render *render, const char *pass)
{
	STILB_ASSERT_OWNER(render->owner);
	render_device *device = render->device;
	snprintf(device->until, sizeof device->until, "%s", pass ? pass : "");
}

stilb_gpu *stilb_render_gpu(stilb_render *render)
{
	return render->device->gpu;
}

const stilb_gpu_plan *stilb_render_plan(const stilb_render *render)
{
	STILB_ASSERT_OWNER(render->owner);
	return render->device->plan;
}

stilb_result stilb_render_add_feature(stilb_render *render, const stilb_render_feature *feature)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(feature && feature->add && (uint32_t)feature->stage < STILB_RENDER_STAGES);
	render_device *device = render->device;
	if (device->feature_count == STILB_RENDER_MAX_FEATURES)
		return stilb_fail(STILB_ERROR_ARGUMENT, "there are %u features already; remove some first",
		                  STILB_RENDER_MAX_FEATURES);
	device->features[device->feature_count++] = *feature;
	return STILB_OK;
}

stilb_result stilb_render_add_draws(stilb_render *render, const stilb_gpu_draws *draws, uint32_t *number)
{
	STILB_ASSERT_OWNER(render->owner);
	render_device *device = render->device;
	render_frame *frame = &device->frame;
	STILB_ASSERT(frame->begun && draws && !draws->runs == (draws->run_count == 0) && number);
	if (frame->own_lists == STILB_RENDER_MAX_FEATURES)
		return stilb_fail(STILB_ERROR_ARGUMENT, "a frame has %u lists of features already; draw more with each",
		                  STILB_RENDER_MAX_FEATURES);
	frame->own_lists++;
	*number = frame->list_count++;
	device->draws[*number] = *draws;
	return STILB_OK;
}

void stilb_render_remove_feature(stilb_render *render, const void *user)
{
	STILB_ASSERT_OWNER(render->owner);
	render_device *device = render->device;
	uint32_t kept = 0;
	for (uint32_t f = 0; f < device->feature_count; f++)
		if (device->features[f].user != user)
			device->features[kept++] = device->features[f];
	device->feature_count = kept;
}

stilb_render_stats stilb_render_stats_get(const stilb_render *render)
{
	STILB_ASSERT_OWNER(render->owner);
	return render->device->stats;
}
