/* The commands of a plan's pass: what it draws into, what it binds, what it runs. */
#include "gpu/vulkan/gpu_vulkan_internal.h"

#include <stdlib.h>
#include <string.h>

/* ---- what a slot keeps for passes -------------------------------------------------------------------------------- */

#define POOL_SETS 128u

static VkResult pool_add(gpu_vulkan *gpu, gpu_vulkan_slot *slot)
{
	uint32_t sets = POOL_SETS << (slot->pool_count < 8 ? slot->pool_count : 8);
	VkDescriptorPoolSize sizes[3] = {{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, sets * 4},
	                                 {VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, sets * 2},
	                                 {VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, sets * 2}};
	VkDescriptorPoolCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
		.maxSets = sets,
		.poolSizeCount = 3,
		.pPoolSizes = sizes,
	};
	if (slot->pool_count == GPU_VULKAN_POOLS)
		return VK_ERROR_OUT_OF_POOL_MEMORY;
	VkResult result = vkCreateDescriptorPool(gpu->device, &info, gpu->allocator, &slot->pools[slot->pool_count]);
	slot->pool_count += result == VK_SUCCESS;
	return result;
}

/* A set of the frame; it is gone when the slot is used again. */
static VkResult pool_set(gpu_vulkan *gpu, VkDescriptorSetLayout layout, VkDescriptorSet *set)
{
	gpu_vulkan_slot *slot = gpu_vulkan_slot_now(gpu);
	for (;; slot->pool_now++) {
		VkResult result = slot->pool_now == slot->pool_count ? pool_add(gpu, slot) : VK_SUCCESS;
		if (result != VK_SUCCESS)
			return result;
		VkDescriptorSetAllocateInfo info = {
			.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
			.descriptorPool = slot->pools[slot->pool_now],
			.descriptorSetCount = 1,
			.pSetLayouts = &layout,
		};
		result = vkAllocateDescriptorSets(gpu->device, &info, set);
		if (result != VK_ERROR_OUT_OF_POOL_MEMORY && result != VK_ERROR_FRAGMENTED_POOL)
			return result;
	}
}

void gpu_vulkan_pass_free(gpu_vulkan *gpu, gpu_vulkan_slot *slot)
{
	for (uint32_t p = 0; p < slot->pool_count; p++)
		vkDestroyDescriptorPool(gpu->device, slot->pools[p], gpu->allocator);
	for (uint32_t l = 0; l < slot->list_count; l++) {
		vkDestroyCommandPool(gpu->device, slot->lists[l].pool, gpu->allocator);
		free(slot->lists[l].commands);
	}
	free(slot->lists);
	free(slot->extra);
	free(slot->parts);
	free(slot->trash);
}

stilb_result gpu_vulkan_pass_rewind(gpu_vulkan *gpu, gpu_vulkan_slot *slot)
{
	VkResult result = VK_SUCCESS;
	for (uint32_t p = 0; p < slot->pool_count && result == VK_SUCCESS; p++)
		result = vkResetDescriptorPool(gpu->device, slot->pools[p], 0);
	slot->pool_now = 0;
	slot->extra_used = 0;
	for (uint32_t l = 0; l < slot->list_count; l++)
		slot->lists[l].used = 0;
	return result == VK_SUCCESS ? STILB_OK : gpu_vulkan_fail(gpu, result, "begin a frame");
}

/* ---- a pass ------------------------------------------------------------------------------------------------------ */

/* What is being recorded: shared by the threads that fill secondary command buffers, which only read it. */
typedef struct pass_work {
	gpu_vulkan *gpu;
	const stilb_gpu_plan *plan;
	const stilb_gpu_step *step;
	const stilb_gpu_pass *pass;
	const stilb_gpu_draws *list; /* DRAWS */
	gpu_vulkan_variant variant;  /* the attachments */
	uint8_t constants[STILB_GPU_MAX_CONSTANTS];
	/* of DRAWS, by binding of the list */
	VkPipeline *pipelines;
	VkDescriptorSet *sets;
	gpu_program **programs;
} pass_work;

static const stilb_gpu_extent *extent_of(const pass_work *work, uint16_t resource)
{
	return &stilb_gpu_plan_place(work->plan, resource)->extent;
}

/* The constants, with the addresses of buffers at their slots. */
static void pass_constants(pass_work *work)
{
	const stilb_gpu_pass *pass = work->pass;
	memcpy(work->constants, pass->constants, pass->constant_bytes);
	for (uint32_t u = 0; u < pass->use_count; u++) {
		const stilb_gpu_use *use = &pass->uses[u];
		const gpu_vulkan_target *target = &work->gpu->targets[use->resource];
		const gpu_vulkan_buffer *buffer = use->previous ? target->buffer_before : target->buffer;
		if (!buffer || use->how < STILB_GPU_USE_STORAGE_READ || use->how > STILB_GPU_USE_STORAGE ||
		    use->slot == STILB_GPU_NO_SLOT)
			continue;
		STILB_ASSERT(use->slot + sizeof buffer->address <= pass->constant_bytes);
		memcpy(work->constants + use->slot, &buffer->address, sizeof buffer->address);
	}
}

static void pass_push(const pass_work *work, VkCommandBuffer commands, const gpu_program *program)
{
	if (work->pass->constant_bytes > 0)
		vkCmdPushConstants(commands, ((gpu_vulkan_program *)program->own)->layout,
		                   gpu_vulkan_program_stages(&program->desc), 0, work->pass->constant_bytes, work->constants);
}

/* Set 0 for a program: the pass's uses. VK_NULL_HANDLE: the program has none. */
static VkResult pass_set(pass_work *work, const gpu_program *program, VkDescriptorSet *set)
{
	VkDescriptorImageInfo images[STILB_GPU_MAX_USES];
	VkDescriptorBufferInfo buffers[STILB_GPU_MAX_USES];
	VkWriteDescriptorSet writes[STILB_GPU_MAX_USES];
	uint32_t count = 0;
	gpu_vulkan *gpu = work->gpu;
	*set = VK_NULL_HANDLE;
	if (program->desc.samplers + program->desc.storage_images + program->desc.uniforms == 0)
		return VK_SUCCESS;
	VkResult result = pool_set(gpu, ((gpu_vulkan_program *)program->own)->uses, set);
	for (uint32_t u = 0; u < work->pass->use_count && result == VK_SUCCESS; u++) {
		const stilb_gpu_use *use = &work->pass->uses[u];
		const gpu_vulkan_target *target = &gpu->targets[use->resource];
		if (use->how == STILB_GPU_USE_UNIFORM) {
			buffers[count] = (VkDescriptorBufferInfo){
				.buffer = (use->previous ? target->buffer_before : target->buffer)->buffer,
				.offset = use->first,
				.range = use->bytes > 0 ? use->bytes : VK_WHOLE_SIZE,
			};
			writes[count] = (VkWriteDescriptorSet){
				.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
				.dstSet = *set,
				.dstBinding = use->slot,
				.descriptorCount = 1,
				.descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER,
				.pBufferInfo = &buffers[count],
			};
			count++;
			continue;
		}
		gpu_vulkan_texels *texels = use->previous ? target->before : target->texels;
		if (!texels || use->how > STILB_GPU_USE_STORAGE)
			continue;
		bool sampled = use->how == STILB_GPU_USE_SAMPLED;
		gpu_vulkan_seen seen = !sampled ? GPU_VULKAN_STORED : use->array ? GPU_VULKAN_ARRAY : GPU_VULKAN_SAMPLED;
		bool depth = texels->aspect & VK_IMAGE_ASPECT_DEPTH_BIT;
		stilb_gpu_layout layout = !sampled ? STILB_GPU_LAYOUT_STORAGE
		                          : depth  ? STILB_GPU_LAYOUT_DEPTH_READ
		                                   : STILB_GPU_LAYOUT_SAMPLED;
		images[count] = (VkDescriptorImageInfo){
			.sampler = sampled ? gpu->samplers[use->sampler] : VK_NULL_HANDLE,
			.imageView = gpu_vulkan_texels_view(gpu, texels, seen, stilb_gpu_plan_range(work->plan, use)),
			.imageLayout = gpu_vulkan_layout(layout),
		};
		if (!images[count].imageView)
			return VK_ERROR_OUT_OF_HOST_MEMORY;
		writes[count] = (VkWriteDescriptorSet){
			.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
			.dstSet = *set,
			.dstBinding = use->slot,
			.descriptorCount = 1,
			.descriptorType = sampled ? VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER : VK_DESCRIPTOR_TYPE_STORAGE_IMAGE,
			.pImageInfo = &images[count],
		};
		count++;
	}
	if (result == VK_SUCCESS)
		vkUpdateDescriptorSets(gpu->device, count, writes, 0, NULL);
	return result;
}

/* ---- attachments ------------------------------------------------------------------------------------------------- */

static VkAttachmentLoadOp load_of(uint8_t load)
{
	bool clears = load == STILB_GPU_LOAD_CLEAR || load == STILB_GPU_LOAD_CLEAR_AREA;
	return load == STILB_GPU_LOAD_KEEP ? VK_ATTACHMENT_LOAD_OP_LOAD
	       : clears                    ? VK_ATTACHMENT_LOAD_OP_CLEAR
	                                   : VK_ATTACHMENT_LOAD_OP_DONT_CARE;
}

static stilb_gpu_range attachment_range(const stilb_gpu_attachment *a)
{
	return (stilb_gpu_range){a->mip, 1, a->layer, a->layers > 0 ? a->layers : 1};
}

static VkClearColorValue clear_of(const stilb_gpu_attachment *a, stilb_gpu_format_kind kind)
{
	VkClearColorValue clear;
	for (int c = 0; c < 4; c++)
		if (kind == STILB_GPU_FORMAT_INTEGER)
			clear.uint32[c] = (uint32_t)a->clear[c];
		else
			clear.float32[c] = a->clear[c];
	return clear;
}

static VkResult attachment_color(pass_work *work, const stilb_gpu_attachment *a, VkRenderingAttachmentInfo *out)
{
	gpu_vulkan *gpu = work->gpu;
	*out = (VkRenderingAttachmentInfo){.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
	if (gpu_attachment_is_none(a))
		return VK_SUCCESS;
	stilb_gpu_format_kind kind = stilb_gpu_format_describe(extent_of(work, a->image)->format)->kind;
	VkImageView resolve = VK_NULL_HANDLE;
	if (a->resolve) {
		stilb_gpu_range first = {0, 1, 0, 1};
		resolve = gpu_vulkan_texels_view(gpu, gpu->targets[a->resolve].texels, GPU_VULKAN_DRAWN, first);
		if (!resolve)
			return VK_ERROR_OUT_OF_HOST_MEMORY;
	}
	*out = (VkRenderingAttachmentInfo){
		.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
		.imageView = gpu_vulkan_texels_view(gpu, gpu->targets[a->image].texels, GPU_VULKAN_DRAWN, attachment_range(a)),
		.imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
		.resolveMode = !a->resolve                        ? VK_RESOLVE_MODE_NONE
	                   : kind == STILB_GPU_FORMAT_INTEGER ? VK_RESOLVE_MODE_SAMPLE_ZERO_BIT
	                                                      : VK_RESOLVE_MODE_AVERAGE_BIT,
		.resolveImageView = resolve,
		.resolveImageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
		.loadOp = load_of(a->load),
		.storeOp = VK_ATTACHMENT_STORE_OP_STORE,
		.clearValue = {.color = clear_of(a, kind)},
	};
	return out->imageView ? VK_SUCCESS : VK_ERROR_OUT_OF_HOST_MEMORY;
}

static VkResult attachment_depth(pass_work *work, const stilb_gpu_attachment *a, VkRenderingAttachmentInfo *out)
{
	gpu_vulkan *gpu = work->gpu;
	*out = (VkRenderingAttachmentInfo){
		.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
		.imageView = gpu_vulkan_texels_view(gpu, gpu->targets[a->image].texels, GPU_VULKAN_DRAWN, attachment_range(a)),
		.imageLayout = gpu_vulkan_layout(a->read_only ? STILB_GPU_LAYOUT_DEPTH_READ : STILB_GPU_LAYOUT_DEPTH),
		.loadOp = load_of(a->load),
		.storeOp = a->read_only ? VK_ATTACHMENT_STORE_OP_NONE : VK_ATTACHMENT_STORE_OP_STORE,
		.clearValue = {.depthStencil = {.depth = a->clear[0]}},
	};
	return out->imageView ? VK_SUCCESS : VK_ERROR_OUT_OF_HOST_MEMORY;
}

/* What the pass fills: its area, or all of its attachments. */
static VkRect2D pass_rectangle(const pass_work *work)
{
	const uint16_t *area = work->pass->area;
	if (gpu_pass_has_area(work->pass))
		return (VkRect2D){{area[0], area[1]}, {area[2], area[3]}};
	return (VkRect2D){.extent = {work->step->area[0], work->step->area[1]}};
}

/* What attachments are loaded in: all, unless one is cleared in the pass's area alone. */
static VkRect2D rendering_area(const pass_work *work)
{
	bool part = work->pass->depth.image != 0 && work->pass->depth.load == STILB_GPU_LOAD_CLEAR_AREA;
	for (uint32_t c = 0; c < work->pass->color_count; c++)
		part |= work->pass->color[c].load == STILB_GPU_LOAD_CLEAR_AREA;
	return part ? pass_rectangle(work) : (VkRect2D){.extent = {work->step->area[0], work->step->area[1]}};
}

static VkResult rendering_begin(pass_work *work, VkCommandBuffer commands, VkRenderingFlags contents)
{
	const stilb_gpu_pass *pass = work->pass;
	VkRenderingAttachmentInfo colors[STILB_GPU_MAX_COLORS], depth;
	uint32_t layers = 1;
	bool stencil = pass->depth.image && stilb_gpu_format_has_stencil(extent_of(work, pass->depth.image)->format);
	VkResult result = VK_SUCCESS;
	for (uint32_t c = 0; c < pass->color_count && result == VK_SUCCESS; c++) {
		result = attachment_color(work, &pass->color[c], &colors[c]);
		layers = pass->color[c].layers > layers ? pass->color[c].layers : layers;
	}
	if (pass->depth.image && result == VK_SUCCESS) {
		result = attachment_depth(work, &pass->depth, &depth);
		layers = pass->depth.layers > layers ? pass->depth.layers : layers;
	}
	if (result != VK_SUCCESS)
		return result;
	VkRenderingInfo info = {
		.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
		.flags = contents,
		.renderArea = rendering_area(work),
		.layerCount = layers,
		.colorAttachmentCount = pass->color_count,
		.pColorAttachments = pass->color_count > 0 ? colors : NULL, /* see batch_record in gpu_vulkan_access.c */
		.pDepthAttachment = pass->depth.image ? &depth : NULL,
		.pStencilAttachment = stencil ? &depth : NULL,
	};
	vkCmdBeginRendering(commands, &info);
	return VK_SUCCESS;
}

static void pass_area(const pass_work *work, VkCommandBuffer commands)
{
	VkRect2D scissor = pass_rectangle(work);
	VkViewport viewport = {.x = (float)scissor.offset.x,
	                       .y = (float)scissor.offset.y,
	                       .width = (float)scissor.extent.width,
	                       .height = (float)scissor.extent.height,
	                       .maxDepth = 1.0f};
	vkCmdSetViewport(commands, 0, 1, &viewport);
	vkCmdSetScissor(commands, 0, 1, &scissor);
}

/* ---- lists of draws ---------------------------------------------------------------------------------------------- */

/* Finds programs, pipelines and sets of all bindings, before anything is recorded: threads only read them. */
static stilb_result draws_prepare(pass_work *work)
{
	uint32_t count = work->list->binding_count;
	work->pipelines = calloc(count + 1, sizeof *work->pipelines);
	work->sets = calloc(count + 1, sizeof *work->sets);
	work->programs = calloc(count + 1, sizeof(*work->programs));
	if (!work->pipelines || !work->sets || !work->programs)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the %u bindings of pass '%s'", count, work->pass->name);
	for (uint32_t b = 0; b < count; b++) {
		uint32_t id = work->list->bindings[b].program;
		gpu_program *program = gpu_program_of(&work->gpu->base, id ? id : work->pass->program);
		work->programs[b] = program;
		stilb_result result = gpu_vulkan_program_pipeline(work->gpu, program, &work->variant, &work->pipelines[b]);
		if (result != STILB_OK)
			return result;
		VkResult set = pass_set(work, program, &work->sets[b]);
		if (set != VK_SUCCESS)
			return gpu_vulkan_fail(work->gpu, set, "bind the images of a pass");
	}
	return STILB_OK;
}

/* Commands that were recorded. */
typedef struct draws_sent {
	uint64_t draws, binds;
} draws_sent;

static void draws_bind_program(const pass_work *work, VkCommandBuffer commands, uint32_t binding)
{
	const gpu_program *program = work->programs[binding];
	vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, work->pipelines[binding]);
	if (work->sets[binding])
		vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, ((gpu_vulkan_program *)program->own)->layout,
		                        0, 1, &work->sets[binding], 0, NULL);
	pass_push(work, commands, program);
}

static void draws_bind_scissor(const pass_work *work, VkCommandBuffer commands, const uint32_t s[4])
{
	VkRect2D scissor = pass_rectangle(work);
	if (s[2] > 0) { /* what both have in common */
		uint32_t left = (uint32_t)scissor.offset.x, top = (uint32_t)scissor.offset.y;
		uint32_t right = left + scissor.extent.width, bottom = top + scissor.extent.height;
		left = s[0] > left ? s[0] : left;
		top = s[1] > top ? s[1] : top;
		right = s[0] + s[2] < right ? s[0] + s[2] : right;
		bottom = s[1] + s[3] < bottom ? s[1] + s[3] : bottom;
		scissor = (VkRect2D){{(int32_t)left, (int32_t)top},
		                     {right > left ? right - left : 0, bottom > top ? bottom - top : 0}};
	}
	vkCmdSetScissor(commands, 0, 1, &scissor);
}

/* last: the run before in this command buffer, or NULL. */
static void draws_bind(const pass_work *work, VkCommandBuffer commands, const stilb_gpu_run *run,
                       const stilb_gpu_run *last, draws_sent *sent)
{
	const stilb_gpu_draws *list = work->list;
	const stilb_gpu_binding *binding = gpu_binding_of(list, run);
	const gpu_program *program = work->programs[run->binding];
	VkPipelineLayout layout = ((gpu_vulkan_program *)program->own)->layout;
	const stilb_gpu *base = &work->gpu->base;
	gpu_binds binds = gpu_binds_between(list, last, run);
	if (binds.program)
		draws_bind_program(work, commands, run->binding);
	if (binds.set) {
		VkDescriptorSet set = gpu_vulkan_set_handle(gpu_set_of(base, run->set));
		vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout, 1, 1, &set, 0, NULL);
	}
	if (binds.constant)
		vkCmdPushConstants(commands, layout, gpu_vulkan_program_stages(&program->desc), list->constant_place,
		                   sizeof run->constant, &run->constant);
	if (binds.indices) {
		const gpu_vulkan_buffer *indices = gpu_buffer_of(base, binding->indices)->own;
		vkCmdBindIndexBuffer(commands, indices->buffer, 0,
		                     binding->index_bytes == 2 ? VK_INDEX_TYPE_UINT16 : VK_INDEX_TYPE_UINT32);
	}
	if (binds.vertices) {
		const gpu_vulkan_buffer *vertices = gpu_buffer_of(base, binding->vertices)->own;
		vkCmdBindVertexBuffers(commands, 0, 1, &vertices->buffer, &(VkDeviceSize){0});
	}
	if (binds.scissor)
		draws_bind_scissor(work, commands, binding->scissor);
	sent->binds += gpu_binds_count(binds);
}

/* Records draws first .. first + count - 1 of the list, counted over all runs, one command each. */
static draws_sent draws_direct(const pass_work *work, VkCommandBuffer commands, uint64_t first, uint64_t count)
{
	draws_sent sent = {0};
	const stilb_gpu_run *last = NULL;
	uint64_t before = 0;
	for (uint32_t r = 0; r < work->list->run_count && sent.draws < count; r++) {
		const stilb_gpu_run *run = &work->list->runs[r];
		uint64_t skip = first > before ? first - before : 0;
		before += run->count;
		if (skip >= run->count)
			continue;
		draws_bind(work, commands, run, last, &sent);
		last = run;
		const uint8_t *at = (const uint8_t *)work->list->draws + (run->first + skip) * STILB_GPU_DRAW_STRIDE;
		for (uint64_t d = skip; d < run->count && sent.draws < count; d++, at += STILB_GPU_DRAW_STRIDE) {
			VkDrawIndexedIndirectCommand draw;
			memcpy(&draw, at, sizeof draw);
			vkCmdDrawIndexed(commands, draw.indexCount, draw.instanceCount, draw.firstIndex, draw.vertexOffset,
			                 draw.firstInstance);
			sent.draws++;
		}
	}
	return sent;
}

static draws_sent draws_indirect(const pass_work *work, VkCommandBuffer commands)
{
	draws_sent sent = {0};
	const stilb_gpu_run *last = NULL;
	uint32_t most = work->gpu->properties.limits.maxDrawIndirectCount;
	const gpu_vulkan_buffer *buffer = gpu_buffer_of(&work->gpu->base, work->list->commands.id)->own;
	for (uint32_t r = 0; r < work->list->run_count; last = &work->list->runs[r++]) {
		const stilb_gpu_run *run = &work->list->runs[r];
		draws_bind(work, commands, run, last, &sent);
		for (uint32_t done = 0, count; done < run->count; done += count) {
			count = run->count - done < most ? run->count - done : most;
			vkCmdDrawIndexedIndirect(commands, buffer->buffer,
			                         work->list->offset + (run->first + (VkDeviceSize)done) * STILB_GPU_DRAW_STRIDE,
			                         count, STILB_GPU_DRAW_STRIDE);
			sent.draws++;
		}
	}
	return sent;
}

/* ---- secondary command buffers ----------------------------------------------------------------------------------- */

typedef struct secondary_work {
	const pass_work *pass;
	uint64_t draws;
	uint32_t parts;
	VkCommandBuffer *commands; /* [parts] */
	VkResult *results;
	draws_sent *sent;
} secondary_work;

/* Gives the slot at least so many lists. */
static VkResult lists_fit(gpu_vulkan *gpu, gpu_vulkan_slot *slot, uint32_t count)
{
	if (count <= slot->list_count)
		return VK_SUCCESS;
	gpu_vulkan_list *lists = stilb_memory_alloc(count, sizeof *lists);
	if (!lists)
		return VK_ERROR_OUT_OF_HOST_MEMORY;
	memset(lists, 0, count * sizeof *lists);
	if (slot->list_count > 0)
		memcpy(lists, slot->lists, slot->list_count * sizeof *lists);
	free(slot->lists);
	slot->lists = lists;
	for (; slot->list_count < count; slot->list_count++) {
		VkCommandPoolCreateInfo info = {
			.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
			.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT,
			.queueFamilyIndex = gpu->queue_family,
		};
		VkResult result = vkCreateCommandPool(gpu->device, &info, gpu->allocator, &lists[slot->list_count].pool);
		if (result != VK_SUCCESS)
			return result;
	}
	return VK_SUCCESS;
}

/* The list's next command buffer; the first call of a frame empties all of them. */
static VkResult list_next(gpu_vulkan *gpu, gpu_vulkan_list *list, VkCommandBuffer *commands)
{
	VkResult result = list->used == 0 ? vkResetCommandPool(gpu->device, list->pool, 0) : VK_SUCCESS;
	if (result == VK_SUCCESS && list->used == list->made) {
		VkCommandBuffer *grown = realloc(list->commands, (list->made + 1) * sizeof *grown);
		if (!grown)
			return VK_ERROR_OUT_OF_HOST_MEMORY;
		list->commands = grown;
		VkCommandBufferAllocateInfo info = {
			.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
			.commandPool = list->pool,
			.level = VK_COMMAND_BUFFER_LEVEL_SECONDARY,
			.commandBufferCount = 1,
		};
		result = vkAllocateCommandBuffers(gpu->device, &info, &list->commands[list->made]);
		list->made += result == VK_SUCCESS;
	}
	if (result == VK_SUCCESS)
		*commands = list->commands[list->used++];
	return result;
}

static VkResult list_begin(const pass_work *work, VkCommandBuffer commands)
{
	VkCommandBufferInheritanceRenderingInfo rendering = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_INHERITANCE_RENDERING_INFO,
		.colorAttachmentCount = work->variant.color_count,
		.pColorAttachmentFormats = work->variant.colors,
		.depthAttachmentFormat = work->variant.depth,
		.stencilAttachmentFormat = gpu_vulkan_stencil_format(work->variant.depth),
		.rasterizationSamples = (VkSampleCountFlagBits)work->variant.samples,
	};
	VkCommandBufferInheritanceInfo inheritance = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_INHERITANCE_INFO,
	                                              .pNext = &rendering};
	VkCommandBufferBeginInfo begin = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
		.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT | VK_COMMAND_BUFFER_USAGE_RENDER_PASS_CONTINUE_BIT,
		.pInheritanceInfo = &inheritance,
	};
	return vkBeginCommandBuffer(commands, &begin);
}

static void secondary_task(uint32_t index, void *context)
{
	PROFILE("record secondary");
	const secondary_work *work = context;
	gpu_vulkan *gpu = work->pass->gpu;
	gpu_vulkan_list *list = &gpu_vulkan_slot_now(gpu)->lists[index];
	uint64_t first = gpu_draws_part(work->draws, work->parts, index);
	uint64_t end = gpu_draws_part(work->draws, work->parts, index + 1);
	VkResult result = list_next(gpu, list, &work->commands[index]);
	if (result == VK_SUCCESS)
		result = list_begin(work->pass, work->commands[index]);
	if (result == VK_SUCCESS) {
		pass_area(work->pass, work->commands[index]);
		work->sent[index] = draws_direct(work->pass, work->commands[index], first, end - first);
		result = vkEndCommandBuffer(work->commands[index]);
	}
	work->results[index] = result;
}

/* Cuts the list into parts, has threads record them, and executes them in order. */
static stilb_result draws_secondary(pass_work *work, VkCommandBuffer commands, const stilb_gpu_threads *threads)
{
	VkCommandBuffer buffers[GPU_MOST_PARTS];
	VkResult results[GPU_MOST_PARTS];
	draws_sent sent[GPU_MOST_PARTS] = {0};
	uint32_t parts = gpu_draws_parts(threads);
	secondary_work secondary = {.pass = work,
	                            .draws = gpu_draws_count(work->list),
	                            .parts = parts,
	                            .commands = buffers,
	                            .results = results,
	                            .sent = sent};
	VkResult result = lists_fit(work->gpu, gpu_vulkan_slot_now(work->gpu), parts);
	if (result == VK_SUCCESS && parts > 1)
		threads->run(threads->user, parts, secondary_task, &secondary);
	else if (result == VK_SUCCESS)
		secondary_task(0, &secondary);
	for (uint32_t p = 0; p < parts && result == VK_SUCCESS; p++)
		result = results[p];
	if (result == VK_SUCCESS)
		result = rendering_begin(work, commands, VK_RENDERING_CONTENTS_SECONDARY_COMMAND_BUFFERS_BIT);
	if (result != VK_SUCCESS)
		return gpu_vulkan_fail(work->gpu, result, "record secondary command buffers");
	vkCmdExecuteCommands(commands, parts, buffers);
	vkCmdEndRendering(commands);
	for (uint32_t p = 0; p < parts; p++) {
		work->gpu->base.stats.draw_commands += sent[p].draws;
		work->gpu->base.stats.binds += sent[p].binds;
	}
	work->gpu->base.stats.execute_commands += parts;
	return STILB_OK;
}

/* ---- kinds of passes --------------------------------------------------------------------------------------------- */

static stilb_result pass_draws(pass_work *work, VkCommandBuffer commands, const stilb_gpu_threads *threads)
{
	stilb_gpu_stats *stats = &work->gpu->base.stats;
	stilb_result prepared = draws_prepare(work);
	if (prepared != STILB_OK)
		return prepared;
	if (work->list->replay == STILB_GPU_REPLAY_SECONDARY && work->list->run_count > 0)
		return draws_secondary(work, commands, threads);
	VkResult result = rendering_begin(work, commands, 0);
	if (result != VK_SUCCESS)
		return gpu_vulkan_fail(work->gpu, result, "begin a pass");
	pass_area(work, commands);
	if (work->list->replay == STILB_GPU_REPLAY_INDIRECT && work->list->run_count > 0) {
		draws_sent sent = draws_indirect(work, commands);
		stats->indirect_commands += sent.draws;
		stats->binds += sent.binds;
	} else {
		draws_sent sent = draws_direct(work, commands, 0, UINT64_MAX);
		stats->draw_commands += sent.draws;
		stats->binds += sent.binds;
	}
	vkCmdEndRendering(commands);
	return STILB_OK;
}

/* Binds the pass's own program. */
static stilb_result pass_bind(pass_work *work, VkCommandBuffer commands, VkPipelineBindPoint point)
{
	gpu_program *program = gpu_program_of(&work->gpu->base, work->pass->program);
	VkPipeline pipeline;
	VkDescriptorSet set;
	stilb_result result = gpu_vulkan_program_pipeline(work->gpu, program, &work->variant, &pipeline);
	if (result != STILB_OK)
		return result;
	VkResult error = pass_set(work, program, &set);
	if (error != VK_SUCCESS)
		return gpu_vulkan_fail(work->gpu, error, "bind the images of a pass");
	vkCmdBindPipeline(commands, point, pipeline);
	if (set)
		vkCmdBindDescriptorSets(commands, point, ((gpu_vulkan_program *)program->own)->layout, 0, 1, &set, 0, NULL);
	pass_push(work, commands, program);
	return STILB_OK;
}

static stilb_result pass_fullscreen(pass_work *work, VkCommandBuffer commands)
{
	stilb_result result = pass_bind(work, commands, VK_PIPELINE_BIND_POINT_GRAPHICS);
	if (result != STILB_OK)
		return result;
	VkResult error = rendering_begin(work, commands, 0);
	if (error != VK_SUCCESS)
		return gpu_vulkan_fail(work->gpu, error, "begin a pass");
	pass_area(work, commands);
	vkCmdDraw(commands, 3, 1, 0, 0);
	vkCmdEndRendering(commands);
	return STILB_OK;
}

static stilb_result pass_dispatch(pass_work *work, VkCommandBuffer commands)
{
	const stilb_gpu_pass *pass = work->pass;
	work->variant = (gpu_vulkan_variant){.samples = 1};
	stilb_result result = pass_bind(work, commands, VK_PIPELINE_BIND_POINT_COMPUTE);
	if (result != STILB_OK)
		return result;
	if (pass->groups[0] + pass->groups[1] + pass->groups[2] > 0) {
		vkCmdDispatch(commands, pass->groups[0], pass->groups[1], pass->groups[2]);
		return STILB_OK;
	}
	for (uint32_t u = 0; u < pass->use_count; u++)
		if (pass->uses[u].how == STILB_GPU_USE_INDIRECT) {
			const gpu_vulkan_target *target = &work->gpu->targets[pass->uses[u].resource];
			vkCmdDispatchIndirect(commands, (pass->uses[u].previous ? target->buffer_before : target->buffer)->buffer,
			                      pass->uses[u].slot);
		}
	return STILB_OK;
}

static stilb_result pass_run(pass_work *work, VkCommandBuffer commands, const stilb_gpu_threads *threads)
{
	switch ((stilb_gpu_pass_kind)work->pass->kind) {
	case STILB_GPU_PASS_DRAWS:
		return pass_draws(work, commands, threads);
	case STILB_GPU_PASS_FULLSCREEN:
		return pass_fullscreen(work, commands);
	case STILB_GPU_PASS_DISPATCH:
		return pass_dispatch(work, commands);
	default:
		gpu_vulkan_copy(work->gpu, commands, work->plan, work->pass);
		return STILB_OK;
	}
}

stilb_result gpu_vulkan_plan_pass(gpu_vulkan *gpu, const stilb_gpu_plan *plan, const stilb_gpu_step *step,
                                  const stilb_gpu_draws *lists, const stilb_gpu_threads *threads)
{
	VkCommandBuffer commands = gpu_vulkan_slot_now(gpu)->draw;
	const stilb_gpu_pass *pass = stilb_gpu_plan_row(plan, step->pass);
	pass_work work = {.gpu = gpu, .plan = plan, .step = step, .pass = pass};
	work.list = pass->kind == STILB_GPU_PASS_DRAWS ? &lists[pass->draws] : NULL;
	work.variant.color_count = pass->color_count;
	work.variant.samples = step->samples > 0 ? step->samples : 1;
	for (uint32_t c = 0; c < pass->color_count; c++)
		work.variant.colors[c] = gpu_attachment_is_none(&pass->color[c])
		                             ? VK_FORMAT_UNDEFINED
		                             : gpu->targets[pass->color[c].image].texels->format;
	if (pass->depth.image)
		work.variant.depth = gpu->targets[pass->depth.image].texels->format;
	pass_constants(&work);
	stilb_result result = pass_run(&work, commands, threads);
	free(work.pipelines);
	free(work.sets);
	free(work.programs);
	return result;
}
