/* Barriers of a plan. */
#include "gpu/vulkan/gpu_vulkan_internal.h"

#include <string.h>

/* ---- what an access means to Vulkan ------------------------------------------------------------------------------ */

typedef struct access_meaning {
	VkPipelineStageFlags2 stage;
	VkAccessFlags2 access;
} access_meaning;

#define GRAPHICS_SHADERS (VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT)
#define DEPTH_TESTS (VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT)

static const access_meaning meanings[STILB_GPU_ACCESSES] = {
	[STILB_GPU_ACCESS_NONE] = {VK_PIPELINE_STAGE_2_NONE, VK_ACCESS_2_NONE},
	[STILB_GPU_ACCESS_COLOR] = {VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
                                VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT},
	[STILB_GPU_ACCESS_DEPTH] = {DEPTH_TESTS, VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT |
                                                 VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT},
	[STILB_GPU_ACCESS_DEPTH_READ] = {DEPTH_TESTS | GRAPHICS_SHADERS, VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT |
                                                                         VK_ACCESS_2_SHADER_SAMPLED_READ_BIT},
	[STILB_GPU_ACCESS_RESOLVE] = {VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
                                  VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT},
	[STILB_GPU_ACCESS_SAMPLED_FRAGMENT] = {GRAPHICS_SHADERS, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT},
	[STILB_GPU_ACCESS_SAMPLED_COMPUTE] = {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT},
	[STILB_GPU_ACCESS_STORAGE_READ_GRAPHICS] = {GRAPHICS_SHADERS,
                                                VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_UNIFORM_READ_BIT},
	[STILB_GPU_ACCESS_STORAGE_READ_COMPUTE] = {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                                               VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_UNIFORM_READ_BIT},
	[STILB_GPU_ACCESS_STORAGE_GRAPHICS] = {GRAPHICS_SHADERS,
                                           VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT},
	[STILB_GPU_ACCESS_STORAGE_COMPUTE] = {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                                          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT},
	[STILB_GPU_ACCESS_VERTICES] = {VK_PIPELINE_STAGE_2_VERTEX_INPUT_BIT,
                                   VK_ACCESS_2_VERTEX_ATTRIBUTE_READ_BIT | VK_ACCESS_2_INDEX_READ_BIT},
	[STILB_GPU_ACCESS_INDIRECT] = {VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT},
	[STILB_GPU_ACCESS_COPY_FROM] = {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_READ_BIT},
	[STILB_GPU_ACCESS_COPY_TO] = {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT},
	[STILB_GPU_ACCESS_HOST] = {VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT}, /* its writes: by submission */
	[STILB_GPU_ACCESS_OUTPUT] = {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_READ_BIT},
};

#define WRITES                                                                                                         \
	(VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT |                         \
	 VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT)

/* Several accesses together, a bit each. */
static access_meaning meaning_of(uint32_t bits)
{
	access_meaning all = {VK_PIPELINE_STAGE_2_NONE, VK_ACCESS_2_NONE};
	for (; bits != 0; bits &= bits - 1) {
		all.stage |= meanings[__builtin_ctz(bits)].stage;
		all.access |= meanings[__builtin_ctz(bits)].access;
	}
	return all;
}

/* ---- barriers ---------------------------------------------------------------------------------------------------- */

void gpu_vulkan_full_barrier(VkCommandBuffer commands)
{
	VkMemoryBarrier2 barrier = {
		.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
		.srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
		.srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
		.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
		.dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT,
	};
	vkCmdPipelineBarrier2(commands, &(VkDependencyInfo){.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
	                                                    .memoryBarrierCount = 1,
	                                                    .pMemoryBarriers = &barrier});
}

static VkImageMemoryBarrier2 access_barrier(const gpu_vulkan_texels *texels, VkImageLayout from, VkImageLayout to,
                                            access_meaning before, access_meaning behind, stilb_gpu_range range)
{
	return (VkImageMemoryBarrier2){
		.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
		.srcStageMask = before.stage,
		.srcAccessMask = before.access & WRITES,
		.dstStageMask = behind.stage,
		.dstAccessMask = behind.access,
		.oldLayout = from,
		.newLayout = to,
		.srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
		.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
		.image = texels->image,
		.subresourceRange = {texels->aspect, range.mip, range.mips, range.layer, range.layers},
	};
}

VkImageMemoryBarrier2 gpu_vulkan_relayout_barrier(const gpu_vulkan_texels *texels, stilb_gpu_layout from,
                                                  stilb_gpu_layout to, stilb_gpu_range range)
{
	VkImageMemoryBarrier2 barrier = access_barrier(texels, gpu_vulkan_layout(from), gpu_vulkan_layout(to),
	                                               (access_meaning){0}, (access_meaning){0}, range);
	barrier.srcStageMask = barrier.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
	barrier.srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT;
	barrier.dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
	return barrier;
}

void gpu_vulkan_relayout(VkCommandBuffer commands, const gpu_vulkan_texels *texels, stilb_gpu_layout from,
                         stilb_gpu_layout to, stilb_gpu_range range)
{
	VkImageMemoryBarrier2 barrier = gpu_vulkan_relayout_barrier(texels, from, to, range);
	gpu_vulkan_image_barriers(commands, &barrier, 1);
}

/* Barriers that are recorded as one command. */
#define BATCH 32u
typedef struct access_batch {
	VkCommandBuffer commands;
	VkImageMemoryBarrier2 images[BATCH];
	uint32_t image_count;
	VkMemoryBarrier2 memory; /* of buffers, and of memory that changes its owner */
	bool has_memory;
} access_batch;

static void batch_record(access_batch *batch)
{
	if (batch->image_count == 0 && !batch->has_memory)
		return;
	/* No pointers to nothing: Mesa's software driver copies them, and without memory for 0 bytes it frees ours. */
	VkDependencyInfo info = {
		.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
		.memoryBarrierCount = batch->has_memory,
		.pMemoryBarriers = batch->has_memory ? &batch->memory : NULL,
		.imageMemoryBarrierCount = batch->image_count,
		.pImageMemoryBarriers = batch->image_count > 0 ? batch->images : NULL,
	};
	vkCmdPipelineBarrier2(batch->commands, &info);
	batch->image_count = 0;
	batch->has_memory = false;
}

static void batch_memory(access_batch *batch, access_meaning before, access_meaning behind)
{
	if (!batch->has_memory)
		batch->memory = (VkMemoryBarrier2){.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
	batch->has_memory = true;
	batch->memory.srcStageMask |= before.stage;
	batch->memory.srcAccessMask |= before.access & WRITES;
	batch->memory.dstStageMask |= behind.stage;
	batch->memory.dstAccessMask |= behind.access;
}

static void batch_image(access_batch *batch, VkImageMemoryBarrier2 barrier)
{
	if (batch->image_count == BATCH)
		batch_record(batch);
	batch->images[batch->image_count++] = barrier;
}

/* Fills a part of an image with zeros, in the layout COPY_TO. */
static void zero_image(VkCommandBuffer commands, const gpu_vulkan_texels *texels, stilb_gpu_range range)
{
	VkImageSubresourceRange part = {texels->aspect, range.mip, range.mips, range.layer, range.layers};
	if (texels->aspect & VK_IMAGE_ASPECT_DEPTH_BIT)
		vkCmdClearDepthStencilImage(commands, texels->image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
		                            &(VkClearDepthStencilValue){0}, 1, &part);
	else
		vkCmdClearColorImage(commands, texels->image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &(VkClearColorValue){0}, 1,
		                     &part);
}

static const access_meaning copies = {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT};

/* What a barrier's image is in before: of owned images that the plan has not touched the device knows it, and it may
 * differ from part to part. */
static void plan_image(access_batch *batch, const gpu_vulkan_target *target, const stilb_gpu_barrier *b,
                       access_meaning before, access_meaning behind)
{
	const gpu_vulkan_texels *texels = b->previous ? target->before : target->texels;
	stilb_gpu_format_kind kind = stilb_gpu_format_describe(texels->extent.format)->kind;
	VkImageLayout to = gpu_vulkan_layout(stilb_gpu_access_layout((stilb_gpu_access)b->to, kind));
	VkImageLayout from = VK_IMAGE_LAYOUT_UNDEFINED;
	stilb_gpu_range range = {b->mip, b->mips, b->layer, b->layers};
	if (b->zero) {
		batch_image(batch, access_barrier(texels, from, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, before, copies, range));
		batch_record(batch);
		zero_image(batch->commands, texels, range);
		from = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
		before = copies;
	} else if (!b->discard && b->from == STILB_GPU_ACCESS_NONE) {
		STILB_ASSERT(target->layouts && "it is the program's own");
		for (uint32_t layer = b->layer; layer < (uint32_t)b->layer + b->layers; layer++)
			for (uint32_t mip = b->mip; mip < (uint32_t)b->mip + b->mips; mip++) {
				uint8_t layout = target->layouts[layer * texels->extent.mips + mip];
				stilb_gpu_range part = {(uint8_t)mip, 1, (uint16_t)layer, 1};
				VkImageMemoryBarrier2 barrier =
					access_barrier(texels, gpu_vulkan_layout((stilb_gpu_layout)layout), to, before, behind, part);
				/* Frames of other plans, and the device's copies, may have used it. */
				barrier.srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
				barrier.srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT;
				batch_image(batch, barrier);
			}
		return;
	} else if (!b->discard)
		from = gpu_vulkan_layout(stilb_gpu_access_layout((stilb_gpu_access)b->from, kind));
	batch_image(batch, access_barrier(texels, from, to, before, behind, range));
}

static void plan_buffer(access_batch *batch, const gpu_vulkan_target *target, const stilb_gpu_barrier *b,
                        access_meaning before, access_meaning behind)
{
	if (b->zero) {
		batch_memory(batch, before, copies);
		batch_record(batch);
		vkCmdFillBuffer(batch->commands, (b->previous ? target->buffer_before : target->buffer)->buffer, 0,
		                VK_WHOLE_SIZE, 0);
		before = copies;
	}
	batch_memory(batch, before, behind);
}

void gpu_vulkan_plan_barriers(gpu_vulkan *gpu, VkCommandBuffer commands, const stilb_gpu_plan *plan, uint32_t first,
                              uint32_t count)
{
	access_batch batch = {.commands = commands};
	const stilb_gpu_barrier *barriers;
	uint32_t all = stilb_gpu_plan_barriers(plan, &barriers);
	STILB_ASSERT(first + count <= all);
	(void)all;
	for (uint32_t i = 0; i < count; i++) {
		const stilb_gpu_barrier *b = &barriers[first + i];
		const gpu_vulkan_target *target = &gpu->targets[b->resource];
		access_meaning before = meaning_of(b->from_all), behind = meaning_of(b->to_all | 1u << b->to);
		if (b->memory)
			batch_memory(&batch, before, b->zero ? copies : behind);
		if (target->texels)
			plan_image(&batch, target, b, before, behind);
		else
			plan_buffer(&batch, target, b, before, behind);
	}
	batch_record(&batch);
}
