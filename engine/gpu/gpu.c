/* gpu: what a user calls: checks, numbers, what is freed when. */
#include "gpu/gpu_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const size_t entry_sizes[GPU_KINDS] = {
	[GPU_BUFFER] = sizeof(gpu_buffer),
	[GPU_IMAGE] = sizeof(gpu_image),
	[GPU_SET] = sizeof(gpu_set),
	[GPU_PROGRAM] = sizeof(gpu_program),
};

/* ---- life -------------------------------------------------------------------------------------------------------- */

stilb_result gpu_start(stilb_gpu *gpu, const stilb_gpu_desc *desc)
{
	stilb_owner_take(&gpu->owner);
	for (int kind = 0; kind < GPU_KINDS; kind++)
		gpu->tables[kind].element = entry_sizes[kind];
	gpu->lock_made = stilb_lock_init(&gpu->lock);
	if (gpu->lock_made && !stilb_lock_init(&gpu->replacing)) {
		stilb_lock_finish(&gpu->lock);
		gpu->lock_made = false;
	}
	if (!gpu->lock_made)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the device's lock");
	stilb_result result =
		gpu_ring_create(gpu, desc->upload_bytes ? desc->upload_bytes : GPU_UPLOAD_BYTES, desc->upload_frame);
	if (result == STILB_OK)
		result = gpu->functions->sampler_make(gpu, 0, &gpu->samplers[0]);
	if (result == STILB_OK)
		atomic_store_explicit(&gpu->sampler_count, 1, memory_order_release); /* see sampler_count */
	return result;
}

void gpu_clear(stilb_gpu *gpu)
{
	/* Sets first: they hold views of images. */
	static const gpu_kind order[GPU_KINDS] = {GPU_SET, GPU_PROGRAM, GPU_IMAGE, GPU_BUFFER};
	for (int k = 0; k < GPU_KINDS; k++) {
		gpu_table *table = &gpu->tables[order[k]];
		for (uint32_t i = 0; i < table->count; i++) {
			void *entry = gpu_table_at(table, i);
			if (entry)
				gpu_entry_free(gpu, order[k], entry);
		}
		gpu_table_finish(table);
	}
	for (uint32_t r = 0; r < gpu->read_capacity; r++)
		if (gpu->reads[r].buffer.own)
			gpu->functions->buffer_free(gpu, &gpu->reads[r].buffer);
	free(gpu->reads);
	gpu->reads = NULL;
	gpu->read_capacity = 0;
	gpu_ring_destroy(gpu);
}

void gpu_finish(stilb_gpu *gpu)
{
	gpu_sources_finish(gpu);
	free(gpu->retired);
	free(gpu->sites);
	gpu->retired = NULL;
	gpu->sites = NULL;
	if (gpu->lock_made) {
		stilb_lock_finish(&gpu->lock);
		stilb_lock_finish(&gpu->replacing);
	}
	gpu->lock_made = false;
}

void stilb_gpu_destroy(stilb_gpu *gpu)
{
	if (!gpu)
		return;
	STILB_ASSERT_OWNER(gpu->owner);
	gpu->functions->destroy(gpu);
}

void stilb_gpu_own(stilb_gpu *gpu)
{
	stilb_owner_take(&gpu->owner);
}

const stilb_gpu_limits *stilb_gpu_limits_get(const stilb_gpu *gpu)
{
	return &gpu->limits;
}

const char *stilb_gpu_name(const stilb_gpu *gpu)
{
	return gpu->name;
}

bool stilb_gpu_is_software(const stilb_gpu *gpu)
{
	return gpu->software;
}

uint32_t stilb_gpu_validation_messages(const stilb_gpu *gpu)
{
	STILB_ASSERT_OWNER(gpu->owner);
	return gpu->validation_messages;
}

stilb_gpu_memory_report stilb_gpu_memory_measure(stilb_gpu *gpu)
{
	return gpu->functions->measure(gpu);
}

/* ---- what is made and destroyed ---------------------------------------------------------------------------------- */

stilb_result stilb_gpu_buffer_create(stilb_gpu *gpu, const stilb_gpu_buffer_desc *desc, stilb_gpu_buffer *out)
{
	STILB_ASSERT(gpu && desc && out);
	*out = (stilb_gpu_buffer){0};
	stilb_result result = gpu_check_buffer(gpu, desc);
	if (result != STILB_OK)
		return result;
	uint64_t id;
	gpu_buffer *buffer = gpu_entry_add(gpu, GPU_BUFFER, &id);
	if (!buffer)
		return STILB_ERROR_MEMORY;
	gpu_name_copy(buffer->name, desc->name);
	buffer->bytes = desc->bytes;
	buffer->memory = desc->memory;
	buffer->uses = desc->uses;
	result = gpu->functions->buffer_make(gpu, buffer);
	if (result == STILB_OK)
		out->id = id;
	else
		gpu_entry_drop(gpu, GPU_BUFFER, buffer, id);
	return result;
}

void stilb_gpu_buffer_destroy(stilb_gpu *gpu, stilb_gpu_buffer buffer)
{
	gpu_entry_retire(gpu, GPU_BUFFER, buffer.id);
}

void *stilb_gpu_buffer_mapped(stilb_gpu *gpu, stilb_gpu_buffer buffer)
{
	const gpu_buffer *entry = gpu_buffer_of(gpu, buffer.id);
	STILB_ASSERT(entry);
	return entry->mapped;
}

uint64_t stilb_gpu_buffer_address(stilb_gpu *gpu, stilb_gpu_buffer buffer)
{
	const gpu_buffer *entry = gpu_buffer_of(gpu, buffer.id);
	STILB_ASSERT(entry && entry->uses & STILB_GPU_BUFFER_ADDRESS);
	return entry->address;
}

stilb_result stilb_gpu_image_create(stilb_gpu *gpu, const stilb_gpu_image_desc *desc, stilb_gpu_image *out)
{
	STILB_ASSERT(gpu && desc && out);
	*out = (stilb_gpu_image){0};
	stilb_result result = gpu_check_image(gpu, desc->name ? desc->name : "", &desc->extent);
	if (result == STILB_OK)
		result = gpu_check_channels(desc);
	if (result != STILB_OK)
		return result;
	uint64_t id;
	gpu_image *image = gpu_entry_add(gpu, GPU_IMAGE, &id);
	if (!image)
		return STILB_ERROR_MEMORY;
	gpu_name_copy(image->name, desc->name);
	image->extent = desc->extent;
	image->channels = desc->channels;
	image->layouts = calloc((size_t)desc->extent.layers * desc->extent.mips, sizeof *image->layouts);
	result = image->layouts ? gpu->functions->image_make(gpu, image)
	                        : stilb_fail(STILB_ERROR_MEMORY, "no memory for the state of image '%s'", image->name);
	if (result == STILB_OK)
		out->id = id;
	else {
		free(image->layouts);
		gpu_entry_drop(gpu, GPU_IMAGE, image, id);
	}
	return result;
}

void stilb_gpu_image_destroy(stilb_gpu *gpu, stilb_gpu_image image)
{
	gpu_entry_retire(gpu, GPU_IMAGE, image.id);
}

stilb_result stilb_gpu_sampler_get(stilb_gpu *gpu, const stilb_gpu_sampler_desc *desc, stilb_gpu_sampler *out)
{
	STILB_ASSERT(gpu && desc && out);
	*out = (stilb_gpu_sampler){0};
	stilb_result result = gpu_check_sampler(gpu, desc);
	if (result != STILB_OK)
		return result;
	/* Member by member: padding does not count. */
	stilb_gpu_sampler_desc wanted;
	memset(&wanted, 0, sizeof wanted);
	wanted.linear = desc->linear;
	wanted.mip_linear = desc->mip_linear;
	wanted.mips = desc->mips;
	memcpy(wanted.wrap, desc->wrap, sizeof wanted.wrap);
	wanted.compare = desc->compare;
	wanted.anisotropy = desc->anisotropy > 1.0f ? desc->anisotropy : 0.0f;
	stilb_lock_take(&gpu->lock);
	/* Relaxed: written under the lock. */
	uint32_t count = atomic_load_explicit(&gpu->sampler_count, memory_order_relaxed), found = 0;
	while (found < count && memcmp(&gpu->samplers[found], &wanted, sizeof wanted) != 0)
		found++;
	if (found == count && count == GPU_MAX_SAMPLERS)
		result = stilb_fail(STILB_ERROR_ARGUMENT, "there are 255 samplers already; ask for fewer kinds");
	else if (found == count) {
		gpu->samplers[count] = wanted;
		result = gpu->functions->sampler_make(gpu, count, &wanted);
		if (result == STILB_OK)
			atomic_store_explicit(&gpu->sampler_count, count + 1, memory_order_release); /* see sampler_count */
	}
	stilb_lock_give(&gpu->lock);
	if (result == STILB_OK)
		out->id = (uint8_t)found;
	return result;
}

stilb_result stilb_gpu_set_create(stilb_gpu *gpu, const stilb_gpu_set_item *items, uint32_t count, stilb_gpu_set *out)
{
	STILB_ASSERT(gpu && out && (items || count == 0));
	*out = (stilb_gpu_set){0};
	if (count == 0 || count > STILB_GPU_MAX_SET_ITEMS || count > gpu->limits.samplers_stage)
		return stilb_fail(STILB_ERROR_ARGUMENT, "a set of %u images: it has 1..%u", count, STILB_GPU_MAX_SET_ITEMS);
	for (uint32_t i = 0; i < count; i++) {
		const gpu_image *image = items[i].image.id ? gpu_image_of(gpu, items[i].image.id) : NULL;
		if (items[i].image.id && (!image || !(image->extent.uses & 1u << STILB_GPU_USE_SAMPLED)))
			return stilb_fail(STILB_ERROR_ARGUMENT, "item %u of a set is no image, or one that cannot be sampled", i);
		if (image && items[i].seen != STILB_GPU_SEEN_WHOLE && image->extent.shape != STILB_GPU_SHAPE_2D)
			return stilb_fail(STILB_ERROR_ARGUMENT, "item %u of a set: only images of shape 2D are seen by layers", i);
		if (image && items[i].seen == STILB_GPU_SEEN_LAYER && items[i].layer >= image->extent.layers)
			return stilb_fail(STILB_ERROR_ARGUMENT, "item %u of a set: layer %u of an image that has %u", i,
			                  items[i].layer, image->extent.layers);
		if (items[i].sampler.id >= atomic_load_explicit(&gpu->sampler_count, memory_order_acquire)) /* sampler_get */
			return stilb_fail(STILB_ERROR_ARGUMENT, "item %u of a set has sampler %u, which was never made", i,
			                  items[i].sampler.id);
		const stilb_gpu_sampler_desc *sampler = &gpu->samplers[items[i].sampler.id];
		if (image && (sampler->linear || sampler->mip_linear) &&
		    !(gpu->formats[image->extent.format] & GPU_FORMAT_LINEAR))
			return stilb_fail(STILB_ERROR_ARGUMENT,
			                  "item %u of a set: '%s' cannot filter images of format %s; take a nearest sampler", i,
			                  gpu->name, stilb_gpu_format_describe(image->extent.format)->name);
	}
	uint64_t id;
	gpu_set *set = gpu_entry_add(gpu, GPU_SET, &id);
	if (!set)
		return STILB_ERROR_MEMORY;
	set->count = count;
	memcpy(set->items, items, count * sizeof *items);
	stilb_result result = gpu->functions->set_make(gpu, set);
	if (result == STILB_OK)
		out->id = (uint32_t)id;
	else
		gpu_entry_drop(gpu, GPU_SET, set, id);
	return result;
}

void stilb_gpu_set_destroy(stilb_gpu *gpu, stilb_gpu_set set)
{
	gpu_entry_retire(gpu, GPU_SET, set.id);
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

static stilb_result planner_image_needs(void *user, const stilb_gpu_extent *extent, stilb_gpu_needs *needs)
{
	stilb_gpu *gpu = user;
	stilb_result result = gpu_check_image(gpu, NULL, extent);
	return result == STILB_OK ? gpu->functions->image_needs(gpu, extent, needs) : result;
}

static stilb_result planner_buffer_needs(void *user, uint64_t bytes, stilb_gpu_needs *needs)
{
	stilb_gpu *gpu = user;
	if (bytes > gpu->limits.buffer_bytes)
		return stilb_fail(STILB_ERROR_ARGUMENT, "%llu bytes: '%s' has buffers of up to %llu; cut it into several",
		                  (unsigned long long)bytes, gpu->name, (unsigned long long)gpu->limits.buffer_bytes);
	return gpu->functions->buffer_needs(gpu, bytes, needs);
}

static const char *planner_mistake(void *user, const stilb_gpu_plan *plan, const stilb_gpu_pass *pass)
{
	return gpu_check_pass(user, plan, pass);
}

stilb_gpu_planner stilb_gpu_planner_of(stilb_gpu *gpu)
{
	return (stilb_gpu_planner){
		.user = gpu,
		.image_needs = planner_image_needs,
		.buffer_needs = planner_buffer_needs,
		.mistake = planner_mistake,
	};
}

stilb_result stilb_gpu_frame_begin(stilb_gpu *gpu)
{
	STILB_ASSERT_OWNER(gpu->owner);
	stilb_result result = gpu->functions->begin(gpu);
	if (result != STILB_OK)
		return result;
	stilb_lock_take(&gpu->lock);
	gpu_programs_swap(gpu);
	gpu->frame++;
	stilb_lock_give(&gpu->lock);
	uint64_t done = gpu->frame > STILB_GPU_FRAMES ? gpu->frame - STILB_GPU_FRAMES : 0;
	gpu_retired_free(gpu, done);
	gpu_ring_frame(gpu, done);
	for (uint32_t r = 0; r < gpu->read_capacity; r++)
		if (gpu->reads[r].given_up && gpu->reads[r].frame <= done)
			gpu->reads[r].ticket = 0;
	gpu->begun = true;
	return STILB_OK;
}

/* Owned resources of a plan are there, and are what their rows say. */
static stilb_result check_owned(const stilb_gpu *gpu, const stilb_gpu_plan *plan)
{
	uint32_t count = stilb_gpu_plan_resources(plan);
	for (uint32_t r = 1; r <= count; r++) {
		const stilb_gpu_placed *placed = stilb_gpu_plan_place(plan, (uint16_t)r);
		const char *name = stilb_gpu_plan_name(plan, (uint16_t)r);
		if (!placed->owned)
			continue;
		if (placed->extent.format == STILB_GPU_NONE) {
			const gpu_buffer *buffer = gpu_buffer_of(gpu, placed->owned);
			if (!buffer || buffer->bytes < placed->bytes)
				return stilb_fail(STILB_ERROR_ARGUMENT,
				                  "buffer '%s' of the plan: the program's own is not there, or "
				                  "smaller than its row says",
				                  name);
			continue;
		}
		const gpu_image *image = gpu_image_of(gpu, placed->owned);
		const stilb_gpu_extent *e = image ? &image->extent : NULL, *p = &placed->extent;
		if (!e || e->format != p->format || e->shape != p->shape || e->width != p->width || e->height != p->height ||
		    e->depth != p->depth || e->layers != p->layers || e->mips != p->mips || e->samples != p->samples)
			return stilb_fail(STILB_ERROR_ARGUMENT,
			                  "image '%s' of the plan: the program's own is not there, or not as its row says", name);
		if ((p->uses & ~e->uses) != 0)
			return stilb_fail(STILB_ERROR_ARGUMENT,
			                  "image '%s' of the plan is used in a way that the program's own was not made for; add "
			                  "%#x to its uses",
			                  name, p->uses & ~e->uses);
	}
	return STILB_OK;
}

stilb_result stilb_gpu_frame_run(stilb_gpu *gpu, const stilb_gpu_plan *plan, const stilb_gpu_draws *lists,
                                 uint32_t list_count, const stilb_gpu_threads *threads)
{
	STILB_ASSERT_OWNER(gpu->owner);
	STILB_ASSERT(plan && gpu->begun && "after stilb_gpu_frame_begin, once");
	stilb_result result = check_owned(gpu, plan);
	if (result == STILB_OK)
		result = gpu_check_lists(gpu, plan, lists, list_count);
	if (result != STILB_OK)
		return result;
	gpu->begun = false;
	const stilb_gpu_step *steps;
	const stilb_gpu_barrier *barriers;
	gpu->stats = (stilb_gpu_stats){
		.frame = gpu->frame,
		.passes = stilb_gpu_plan_steps(plan, &steps),
		.barriers = stilb_gpu_plan_barriers(plan, &barriers),
	};
	const gpu_upload_ready *uploads = gpu->ring.ready;
	uint32_t upload_count = gpu_ring_ready(gpu, gpu->ring.frame_bytes);
	for (uint32_t u = 0; u < upload_count; u++)
		gpu->stats.uploaded_bytes += uploads[u].upload.bytes;
	gpu->frames += !gpu->keep_back;
	result =
		!gpu->keep_back && gpu_fault_lost(gpu)
			? stilb_fail(STILB_ERROR_DEVICE_LOST,
	                     "cannot give '%s' a frame: it was lost on purpose; choose another GPU with --gpu", gpu->name)
			: gpu->functions->run(gpu, plan, lists, list_count, threads, uploads, upload_count);
	if (result != STILB_OK || gpu->keep_back)
		gpu_ring_untake(gpu);
	return result;
}

stilb_result stilb_gpu_upload_flush(stilb_gpu *gpu)
{
	STILB_ASSERT_OWNER(gpu->owner);
	PROFILE("flush uploads");
	uint32_t count = gpu_ring_ready(gpu, UINT64_MAX);
	stilb_result result = gpu->functions->flush(gpu, gpu->ring.ready, count);
	if (result == STILB_OK)
		gpu_ring_frame(gpu, gpu->frame);
	else
		gpu_ring_untake(gpu);
	return result;
}

const stilb_prof_site *gpu_step_site(stilb_gpu *gpu, uint32_t step, const char *name)
{
	name = name ? name : "pass";
	if (step >= gpu->site_capacity) {
		uint32_t larger = 2 * step + 16;
		const stilb_prof_site **grown = realloc(gpu->sites, larger * sizeof(*grown));
		if (!grown)
			return stilb_prof_site_make(name, 0);
		memset(grown + gpu->site_capacity, 0, (larger - gpu->site_capacity) * sizeof(*grown));
		gpu->sites = grown;
		gpu->site_capacity = larger;
	}
	if (!gpu->sites[step] || strcmp(gpu->sites[step]->name, name) != 0)
		gpu->sites[step] = stilb_prof_site_make(name, 0);
	return gpu->sites[step];
}

stilb_result stilb_gpu_present(stilb_gpu *gpu, const stilb_gpu_plan *plan, uint16_t image)
{
	STILB_ASSERT_OWNER(gpu->owner);
	if (!stilb_gpu_plan_ready(plan, image, 0, 0))
		return stilb_fail(STILB_ERROR_ARGUMENT, "image %u is no output of the last frame and cannot be shown", image);
	return gpu->functions->present(gpu, plan, image);
}

stilb_result stilb_gpu_set_surface(stilb_gpu *gpu, const stilb_gpu_surface *surface)
{
	STILB_ASSERT_OWNER(gpu->owner);
	STILB_ASSERT(!surface || (surface->extensions && surface->create));
	return gpu->functions->set_surface(gpu, surface);
}

bool stilb_gpu_in_window(const stilb_gpu *gpu)
{
	STILB_ASSERT_OWNER(gpu->owner);
	return gpu->in_window;
}

stilb_gpu_presentation stilb_gpu_presentation_used(const stilb_gpu *gpu)
{
	STILB_ASSERT_OWNER(gpu->owner);
	return gpu->presentation;
}

stilb_result stilb_gpu_wait(stilb_gpu *gpu)
{
	STILB_ASSERT_OWNER(gpu->owner);
	return gpu->functions->wait(gpu);
}

stilb_gpu_stats stilb_gpu_stats_get(const stilb_gpu *gpu)
{
	STILB_ASSERT_OWNER(gpu->owner);
	stilb_gpu_stats stats = gpu->stats;
	stats.gpu_ms = gpu->gpu_ms;
	return stats;
}

/* ---- read-back --------------------------------------------------------------------------------------------------- */

/* An unused read with a buffer of at least so many bytes; NULL: an error. */
static gpu_read *read_new(stilb_gpu *gpu, uint64_t bytes)
{
	gpu_read *found = NULL;
	for (uint32_t r = 0; r < gpu->read_capacity; r++) {
		gpu_read *read = &gpu->reads[r];
		if (read->ticket == 0 && (!found || (read->buffer.bytes >= bytes && found->buffer.bytes < bytes)))
			found = read;
	}
	if (!found) {
		uint32_t capacity = gpu->read_capacity ? 2 * gpu->read_capacity : 8;
		gpu_read *grown = realloc(gpu->reads, capacity * sizeof *grown);
		if (!grown) {
			stilb_fail(STILB_ERROR_MEMORY, "no memory for the list of what is read back");
			return NULL;
		}
		memset(grown + gpu->read_capacity, 0, (capacity - gpu->read_capacity) * sizeof *grown);
		found = grown + gpu->read_capacity;
		gpu->reads = grown;
		gpu->read_capacity = capacity;
	}
	if (found->buffer.bytes >= bytes)
		return found;
	if (found->buffer.own)
		gpu->functions->buffer_free(gpu, &found->buffer);
	found->buffer = (gpu_buffer){
		.name = "read back", .bytes = bytes, .memory = STILB_GPU_MEMORY_READ, .uses = STILB_GPU_BUFFER_COPY};
	if (gpu->functions->buffer_make(gpu, &found->buffer) == STILB_OK)
		return found;
	found->buffer = (gpu_buffer){0};
	return NULL;
}

stilb_result stilb_gpu_read_begin(stilb_gpu *gpu, const stilb_gpu_plan *plan, uint16_t resource, uint8_t mip,
                                  uint16_t layer, uint64_t *ticket)
{
	STILB_ASSERT_OWNER(gpu->owner);
	*ticket = 0;
	if (!stilb_gpu_plan_ready(plan, resource, mip, layer))
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "resource %u, mip %u, layer %u is no output of the last frame; mark it as one", resource, mip,
		                  layer);
	const stilb_gpu_placed *placed = stilb_gpu_plan_place(plan, resource);
	bool image = placed->extent.format != STILB_GPU_NONE;
	if (image && placed->extent.samples > 1)
		return stilb_fail(STILB_ERROR_ARGUMENT, "image '%s' has %u samples a texel; resolve it, and read that",
		                  stilb_gpu_plan_name(plan, resource), placed->extent.samples);
	uint64_t bytes = image ? gpu_mip_bytes(&placed->extent, mip) : placed->bytes;
	gpu_read *read = read_new(gpu, bytes);
	if (!read)
		return STILB_ERROR_MEMORY;
	read->bytes = bytes;
	read->frame = gpu->frame;
	read->given_up = false;
	stilb_result result = gpu->functions->read(gpu, plan, resource, mip, layer, read);
	if (result == STILB_OK)
		*ticket = read->ticket = ++gpu->last_ticket;
	return result;
}

static gpu_read *read_of(stilb_gpu *gpu, uint64_t ticket)
{
	for (uint32_t r = 0; r < gpu->read_capacity && ticket > 0; r++)
		if (gpu->reads[r].ticket == ticket)
			return &gpu->reads[r];
	return NULL;
}

stilb_result stilb_gpu_read_get(stilb_gpu *gpu, uint64_t ticket, bool wait, const void **bytes, uint64_t *frame)
{
	STILB_ASSERT_OWNER(gpu->owner);
	const gpu_read *read = read_of(gpu, ticket);
	*bytes = NULL;
	*frame = 0;
	if (!read || read->given_up)
		return stilb_fail(STILB_ERROR_ARGUMENT, "nothing is read back under the number %llu",
		                  (unsigned long long)ticket);
	bool done = false;
	stilb_result result = gpu->functions->read_done(gpu, read, wait, &done);
	if (result == STILB_OK && done) {
		*bytes = read->buffer.mapped;
		*frame = read->frame;
	}
	return result;
}

void stilb_gpu_read_end(stilb_gpu *gpu, uint64_t ticket)
{
	STILB_ASSERT_OWNER(gpu->owner);
	gpu_read *read = read_of(gpu, ticket);
	if (!read)
		return;
	bool done = false;
	if (gpu->functions->read_done(gpu, read, false, &done) == STILB_OK && done)
		read->ticket = 0;
	else
		read->given_up = true;
}
