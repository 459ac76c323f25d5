/* Copies of a plan: images texel by texel or filtered, buffers, and between both. */
#include "gpu/vulkan/gpu_vulkan_internal.h"

typedef struct copy_side {
	gpu_vulkan_texels *texels; /* or */
	gpu_vulkan_buffer *buffer;
	stilb_gpu_range range;
} copy_side;

static copy_side side_of(gpu_vulkan *gpu, const stilb_gpu_plan *plan, const stilb_gpu_pass *pass,
                         stilb_gpu_use_kind how)
{
	for (uint32_t u = 0; u < pass->use_count; u++) {
		const stilb_gpu_use *use = &pass->uses[u];
		const gpu_vulkan_target *target = &gpu->targets[use->resource];
		if (use->how == how)
			return (copy_side){use->previous ? target->before : target->texels,
			                   use->previous ? target->buffer_before : target->buffer, stilb_gpu_plan_range(plan, use)};
	}
	STILB_ASSERT(false && "the plan has checked that a copy has both");
	return (copy_side){0};
}

static VkExtent3D mip_extent(const stilb_gpu_extent *e, uint32_t mip)
{
	return (VkExtent3D){gpu_mip_side(e->width, mip), gpu_mip_side(e->height, mip), gpu_mip_side(e->depth, mip)};
}

static VkOffset3D mip_corner(const stilb_gpu_extent *e, uint32_t mip)
{
	VkExtent3D size = mip_extent(e, mip);
	return (VkOffset3D){(int32_t)size.width, (int32_t)size.height, (int32_t)size.depth};
}

static void copy_images(VkCommandBuffer commands, copy_side from, copy_side to)
{
	const stilb_gpu_extent *f = &from.texels->extent, *t = &to.texels->extent;
	uint32_t mips = from.range.mips < to.range.mips ? from.range.mips : to.range.mips;
	uint32_t layers = from.range.layers < to.range.layers ? from.range.layers : to.range.layers;
	bool exact = gpu_copy_is_exact(f, from.range.mip, t, to.range.mip);
	stilb_gpu_format_kind kind = stilb_gpu_format_describe(f->format)->kind;
	for (uint32_t m = 0; m < mips; m++) {
		uint32_t fm = from.range.mip + m, tm = to.range.mip + m;
		VkImageSubresourceLayers source = {from.texels->aspect, fm, from.range.layer, layers};
		VkImageSubresourceLayers target = {to.texels->aspect, tm, to.range.layer, layers};
		if (exact) {
			VkImageCopy region = {.srcSubresource = source, .dstSubresource = target, .extent = mip_extent(f, fm)};
			vkCmdCopyImage(commands, from.texels->image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to.texels->image,
			               VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
			continue;
		}
		VkImageBlit region = {
			.srcSubresource = source,
			.srcOffsets = {{0, 0, 0}, mip_corner(f, fm)},
			.dstSubresource = target,
			.dstOffsets = {{0, 0, 0}, mip_corner(t, tm)},
		};
		vkCmdBlitImage(commands, from.texels->image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to.texels->image,
		               VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region,
		               kind == STILB_GPU_FORMAT_COLOR ? VK_FILTER_LINEAR : VK_FILTER_NEAREST);
	}
}

/* Texels of mips and layers, tightly packed: all layers of a mip, then the next mip. */
static void copy_texels(VkCommandBuffer commands, const gpu_vulkan_texels *texels, stilb_gpu_range range,
                        VkBuffer buffer, bool to_image)
{
	VkDeviceSize at = 0;
	for (uint32_t m = range.mip; m < (uint32_t)range.mip + range.mips; m++) {
		VkBufferImageCopy region = {
			.bufferOffset = at,
			.imageSubresource = {texels->aspect, m, range.layer, range.layers},
			.imageExtent = mip_extent(&texels->extent, m),
		};
		if (to_image)
			vkCmdCopyBufferToImage(commands, buffer, texels->image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
		else
			vkCmdCopyImageToBuffer(commands, texels->image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, buffer, 1, &region);
		at += gpu_mip_bytes(&texels->extent, m) * range.layers;
	}
}

void gpu_vulkan_copy(gpu_vulkan *gpu, VkCommandBuffer commands, const stilb_gpu_plan *plan, const stilb_gpu_pass *pass)
{
	copy_side from = side_of(gpu, plan, pass, STILB_GPU_USE_COPY_FROM);
	copy_side to = side_of(gpu, plan, pass, STILB_GPU_USE_COPY_TO);
	if (from.texels && to.texels)
		copy_images(commands, from, to);
	else if (from.texels)
		copy_texels(commands, from.texels, from.range, to.buffer->buffer, false);
	else if (to.texels)
		copy_texels(commands, to.texels, to.range, from.buffer->buffer, true);
	else {
		VkDeviceSize bytes = from.buffer->size < to.buffer->size ? from.buffer->size : to.buffer->size;
		vkCmdCopyBuffer(commands, from.buffer->buffer, to.buffer->buffer, 1, &(VkBufferCopy){.size = bytes});
	}
}
