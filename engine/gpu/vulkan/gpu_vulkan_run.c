/* The Vulkan device of gpu.h: how it is opened, and how a frame runs. */
#include "gpu/vulkan/gpu_vulkan_internal.h"

#include <stdlib.h>
#include <string.h>

/* ---- buffers ----------------------------------------------------------------------------------------------------- */

static stilb_result run_buffer_make(stilb_gpu *base, gpu_buffer *buffer)
{
	static const VkBufferUsageFlags usages[] = {
		VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
		VK_BUFFER_USAGE_VERTEX_BUFFER_BIT,
		VK_BUFFER_USAGE_INDEX_BUFFER_BIT,
		VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT,
		VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
		VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
		VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT,
	};
	gpu_vulkan *gpu = (gpu_vulkan *)base;
	VkBufferUsageFlags usage = 0;
	for (uint32_t u = 0; u < sizeof usages / sizeof *usages; u++)
		usage |= buffer->uses & 1u << u ? usages[u] : 0;
	gpu_vulkan_buffer *own = calloc(1, sizeof *own);
	if (!own)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for buffer '%s'", buffer->name);
	stilb_result result = gpu_vulkan_buffer_create(gpu, buffer->bytes, usage, buffer->memory, own);
	if (result != STILB_OK) {
		free(own);
		return result;
	}
	gpu_vulkan_name(gpu, VK_OBJECT_TYPE_BUFFER, (uint64_t)own->buffer, buffer->name);
	buffer->own = own;
	buffer->mapped = own->mapped;
	buffer->address = own->address;
	return STILB_OK;
}

static void run_buffer_free(stilb_gpu *base, gpu_buffer *buffer)
{
	gpu_vulkan_buffer_destroy((gpu_vulkan *)base, buffer->own);
	free(buffer->own);
	buffer->own = NULL;
}

/* ---- what plans ask ---------------------------------------------------------------------------------------------- */

static stilb_result run_image_needs(stilb_gpu *base, const stilb_gpu_extent *extent, stilb_gpu_needs *needs)
{
	gpu_vulkan *gpu = (gpu_vulkan *)base;
	VkMemoryRequirements memory;
	VkResult result = gpu_vulkan_texels_needs(gpu, extent, &memory);
	if (result == VK_ERROR_FORMAT_NOT_SUPPORTED)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "'%s' has no such image of format %s and %u samples, with these sizes and uses; make it "
		                  "smaller, or take another format",
		                  base->name, stilb_gpu_format_describe(extent->format)->name, extent->samples);
	if (result != VK_SUCCESS)
		return gpu_vulkan_fail(gpu, result, "ask how much memory an image needs");
	*needs = (stilb_gpu_needs){memory.size, memory.alignment, gpu_vulkan_memory_heap(gpu, memory, true)};
	return STILB_OK;
}

static stilb_result run_buffer_needs(stilb_gpu *base, uint64_t bytes, stilb_gpu_needs *needs)
{
	gpu_vulkan *gpu = (gpu_vulkan *)base;
	VkMemoryRequirements memory;
	VkResult result = gpu_vulkan_shared_buffer_needs(gpu, bytes, &memory);
	if (result != VK_SUCCESS)
		return gpu_vulkan_fail(gpu, result, "ask how much memory a buffer needs");
	*needs = (stilb_gpu_needs){memory.size, memory.alignment, gpu_vulkan_memory_heap(gpu, memory, false)};
	return STILB_OK;
}

static stilb_gpu_memory_report run_measure(stilb_gpu *base)
{
	return gpu_memory_measure(&((gpu_vulkan *)base)->blocks);
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

static stilb_result run_begin(stilb_gpu *base)
{
	gpu_vulkan *gpu = (gpu_vulkan *)base;
	stilb_result result = gpu_vulkan_slot_take(gpu);
	if (result != STILB_OK)
		return result;
	gpu_vulkan_slot *slot = gpu_vulkan_slot_now(gpu);
	gpu_vulkan_trash_empty(gpu, slot);
	return gpu_vulkan_pass_rewind(gpu, slot);
}

/* Records a pass with its barriers, its name and its time. */
static stilb_result run_step(gpu_vulkan *gpu, const stilb_gpu_plan *plan, uint32_t number, const stilb_gpu_step *step,
                             const stilb_gpu_draws *lists, const stilb_gpu_threads *threads)
{
	const gpu_vulkan_slot *slot = gpu_vulkan_slot_now(gpu);
	const stilb_gpu_pass *pass = stilb_gpu_plan_row(plan, step->pass);
	const stilb_prof_site *site = gpu_step_site(&gpu->base, number, pass->name);
	if (gpu->label_begin)
		gpu->label_begin(slot->draw, &(VkDebugUtilsLabelEXT){.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT,
		                                                     .pLabelName = site->name});
	gpu_vulkan_plan_barriers(gpu, slot->draw, plan, step->first_barrier, step->barrier_count);
	gpu_vulkan_times_pass_begin(gpu, site);
	stilb_prof_zone_begin(site);
	bool host = pass->kind == STILB_GPU_PASS_HOST;
	if (host && gpu->label_end) /* labels end in the command buffer in which they begin */
		gpu->label_end(slot->draw);
	stilb_result result =
		host ? gpu_vulkan_slot_split(gpu, pass, site) : gpu_vulkan_plan_pass(gpu, plan, step, lists, threads);
	stilb_prof_zone_end();
	gpu_vulkan_times_pass_end(gpu);
	if (!host && gpu->label_end)
		gpu->label_end(slot->draw);
	return result;
}

static stilb_result run_record(gpu_vulkan *gpu, const stilb_gpu_plan *plan, const stilb_gpu_draws *lists,
                               const stilb_gpu_threads *threads, const gpu_upload_ready *uploads, uint32_t upload_count)
{
	const stilb_gpu_step *steps;
	uint32_t count = stilb_gpu_plan_steps(plan, &steps), first;
	stilb_result result = gpu_vulkan_slot_begin(gpu, count);
	if (result != STILB_OK)
		return result;
	const gpu_vulkan_slot *slot = gpu_vulkan_slot_now(gpu); /* whose `draw` is another one behind passes of kind HOST */
	gpu_vulkan_uploads(gpu, slot->draw, uploads, upload_count);
	gpu_vulkan_images_ready(gpu, slot->draw);
	result = gpu_vulkan_targets_take(gpu, plan);
	for (uint32_t s = 0; s < count && result == STILB_OK; s++)
		result = run_step(gpu, plan, s, &steps[s], lists, threads);
	if (result != STILB_OK)
		return result;
	uint32_t last = stilb_gpu_plan_last_barriers(plan, &first);
	gpu_vulkan_plan_barriers(gpu, slot->draw, plan, first, last);
	if (gpu->label_insert && !gpu->surface) /* where nothing is presented RenderDoc takes this as a frame's end */
		gpu->label_insert(slot->draw, &(VkDebugUtilsLabelEXT){.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT,
		                                                      .pLabelName = "vr-marker,frame_end,type,application"});
	if (gpu->base.keep_back)
		return STILB_OK;
	PROFILE("submit");
	uint64_t begin = stilb_time_ns();
	result = gpu_vulkan_slot_submit(gpu);
	gpu->base.stats.submit_ns = stilb_time_ns() - begin;
	return result;
}

static stilb_result run_run(stilb_gpu *base, const stilb_gpu_plan *plan, const stilb_gpu_draws *lists,
                            uint32_t list_count, const stilb_gpu_threads *threads, const gpu_upload_ready *uploads,
                            uint32_t upload_count)
{
	gpu_vulkan *gpu = (gpu_vulkan *)base;
	(void)list_count;
	gpu_vulkan_rest_begin(gpu);
	stilb_result result = run_record(gpu, plan, lists, threads, uploads, upload_count);
	if (result == STILB_OK && !base->keep_back)
		gpu_vulkan_targets_done(gpu, plan);
	else
		gpu_vulkan_rest_undo(gpu);
	return result;
}

static stilb_result run_present(stilb_gpu *base, const stilb_gpu_plan *plan, uint16_t image)
{
	gpu_vulkan *gpu = (gpu_vulkan *)base;
	(void)plan;
	const gpu_vulkan_texels *texels = gpu->targets[image].texels;
	if (!texels || texels->extent.samples > 1 || texels->aspect != VK_IMAGE_ASPECT_COLOR_BIT)
		return stilb_fail(STILB_ERROR_ARGUMENT, "resource %u is no colour image of one sample and cannot be shown",
		                  image);
	if (!gpu->surface || gpu->surface_lost)
		return STILB_OK;
	return gpu_vulkan_present_image(gpu, texels->image, (VkExtent2D){texels->extent.width, texels->extent.height});
}

static stilb_result run_set_surface(stilb_gpu *base, const stilb_gpu_surface *surface)
{
	return gpu_vulkan_set_surface((gpu_vulkan *)base, surface);
}

static stilb_result run_wait(stilb_gpu *base)
{
	return gpu_vulkan_wait((gpu_vulkan *)base);
}

/* ---- opening ----------------------------------------------------------------------------------------------------- */

static void run_limits(gpu_vulkan *gpu)
{
	const VkPhysicalDeviceLimits *l = &gpu->properties.limits;
	uint32_t wide = l->maxFramebufferWidth, high = l->maxFramebufferHeight, drawn = wide < high ? wide : high;
	stilb_gpu_limits *out = &gpu->base.limits;
	*out = (stilb_gpu_limits){
		.image_side = l->maxImageDimension2D,
		.attachment_side = drawn < l->maxImageDimension2D ? drawn : l->maxImageDimension2D,
		.image_side_3d = l->maxImageDimension3D,
		.image_layers = l->maxImageArrayLayers,
		.color_attachments =
			l->maxColorAttachments < STILB_GPU_MAX_COLORS ? l->maxColorAttachments : STILB_GPU_MAX_COLORS,
		.samplers_stage = l->maxPerStageDescriptorSamplers,
		.images_stage = l->maxPerStageDescriptorSampledImages,
		.storage_images_stage = l->maxPerStageDescriptorStorageImages,
		.uniforms_stage = l->maxPerStageDescriptorUniformBuffers,
		.uniform_bytes = l->maxUniformBufferRange,
		.uniform_align = (uint32_t)l->minUniformBufferOffsetAlignment,
		.group_invocations = l->maxComputeWorkGroupInvocations,
		.shared_bytes = l->maxComputeSharedMemorySize,
		.samples = l->framebufferColorSampleCounts & l->framebufferDepthSampleCounts,
		.buffer_bytes = UINT32_MAX,
		.anisotropy = gpu->anisotropic ? l->maxSamplerAnisotropy : 1.0f,
		.timestamps = gpu->timestamp_mask != 0,
		.bc = gpu->base.formats[STILB_GPU_BC7_U] != 0,
		.lines = gpu->lines,
		.some_colors = gpu->some_colors,
		.counts = gpu->counts && (gpu->base.formats[STILB_GPU_D32_F_S8] & STILB_GPU_EXTENT_ATTACHMENT) != 0,
	};
	VkPhysicalDeviceMaintenance4Properties largest = {.sType =
	                                                      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_4_PROPERTIES};
	VkPhysicalDeviceProperties2 properties = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2,
	                                          .pNext = &largest};
	vkGetPhysicalDeviceProperties2(gpu->physical, &properties);
	if (largest.maxBufferSize > 0)
		out->buffer_bytes = largest.maxBufferSize;
	/* Mesa's software driver crashes above 32 samplers a stage, whatever it says. */
	if (gpu->base.software && out->samplers_stage > 32)
		out->samplers_stage = 32;
	for (int i = 0; i < 3; i++) {
		out->group_size[i] = l->maxComputeWorkGroupSize[i];
		out->group_count[i] = l->maxComputeWorkGroupCount[i];
	}
}

static VkResult run_things(gpu_vulkan *gpu)
{
	static const stilb_gpu_extent white = {
		.format = STILB_GPU_RGBA8_U,
		.width = 1,
		.height = 1,
		.depth = 1,
		.layers = 1,
		.mips = 1,
		.samples = 1,
		.uses = 1u << STILB_GPU_USE_SAMPLED | 1u << STILB_GPU_USE_COPY_TO,
	};
	gpu->views_lock_made = stilb_lock_init(&gpu->views_lock);
	if (!gpu->views_lock_made)
		return VK_ERROR_OUT_OF_HOST_MEMORY;
	return gpu_vulkan_texels_create(gpu, "white", &white, NULL, 0, &gpu->white);
}

static void run_destroy(stilb_gpu *base)
{
	gpu_vulkan *gpu = (gpu_vulkan *)base;
	gpu_vulkan_idle(gpu);
	for (uint32_t i = 0; i < STILB_GPU_FRAMES; i++) {
		gpu_vulkan_trash_empty(gpu, &gpu->slots[i]);
		gpu_vulkan_pass_free(gpu, &gpu->slots[i]);
	}
	gpu_clear(base);
	gpu_vulkan_targets_free(gpu);
	gpu_vulkan_texels_destroy(gpu, &gpu->white);
	for (uint32_t p = 0; p < gpu->item_pool_count; p++)
		vkDestroyDescriptorPool(gpu->device, gpu->item_pools[p], gpu->allocator);
	for (uint32_t l = 0; l <= STILB_GPU_MAX_SET_ITEMS; l++)
		vkDestroyDescriptorSetLayout(gpu->device, gpu->item_layouts[l], gpu->allocator);
	for (uint32_t s = 0; s < GPU_MAX_SAMPLERS; s++)
		vkDestroySampler(gpu->device, gpu->samplers[s], gpu->allocator);
	if (gpu->views_lock_made)
		stilb_lock_finish(&gpu->views_lock);
	free(gpu->fresh);
	gpu_finish(base);
	gpu_vulkan_destroy(gpu);
}

/* Address space that compiling shaders may need in a driver that draws on the CPU. */
#define SHADER_BYTES ((size_t)1 << 24)

stilb_result gpu_vulkan_open(const stilb_gpu_desc *desc, stilb_gpu **out)
{
	static const gpu_functions functions = {
		.destroy = run_destroy,
		.buffer_make = run_buffer_make,
		.buffer_free = run_buffer_free,
		.image_make = gpu_vulkan_image_make,
		.image_free = gpu_vulkan_image_free,
		.sampler_make = gpu_vulkan_sampler_make,
		.set_make = gpu_vulkan_set_make,
		.set_free = gpu_vulkan_set_free,
		.program_make = gpu_vulkan_program_make,
		.program_free = gpu_vulkan_program_free,
		.program_prepare = gpu_vulkan_program_prepare,
		.program_follow = gpu_vulkan_program_follow,
		.program_compile = gpu_vulkan_program_compile,
		.begin = run_begin,
		.run = run_run,
		.present = run_present,
		.read = gpu_vulkan_read,
		.read_done = gpu_vulkan_read_done,
		.flush = gpu_vulkan_flush,
		.set_surface = run_set_surface,
		.wait = run_wait,
		.image_needs = run_image_needs,
		.buffer_needs = run_buffer_needs,
		.measure = run_measure,
	};
	gpu_vulkan *gpu;
	VkExtent2D picture = {desc->width ? desc->width : 1280, desc->height ? desc->height : 720};
	stilb_result result = gpu_vulkan_create(desc, picture, &gpu);
	if (result != STILB_OK)
		return result;
	gpu->base.functions = &functions;
	gpu_vulkan_formats_find(gpu);
	run_limits(gpu);
	result = gpu_vulkan_check_memory(gpu, SHADER_BYTES);
	VkResult error = result == STILB_OK ? run_things(gpu) : VK_SUCCESS;
	if (error != VK_SUCCESS)
		result = gpu_vulkan_fail(gpu, error, "open the GPU");
	else if (result == STILB_OK)
		result = gpu_start(&gpu->base, desc);
	if (result == STILB_OK)
		*out = &gpu->base;
	else
		run_destroy(&gpu->base);
	return result;
}
