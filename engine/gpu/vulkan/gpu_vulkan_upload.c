/* Uploads before a frame's passes, and read-back behind them. */
#include "gpu/vulkan/gpu_vulkan_internal.h"

#include <stdlib.h>
#include <string.h>

static stilb_gpu_range part_of(uint32_t mip, uint32_t layer)
{
	return (stilb_gpu_range){(uint8_t)mip, 1, (uint16_t)layer, 1};
}

/* ---- uploads ----------------------------------------------------------------------------------------------------- */

/* Gives parts of an image that nobody has written a layout, all or none: so a set can sample all mips once some were
 * uploaded. Texels are undefined until they are written. */
static void upload_rest(const gpu_vulkan *gpu, VkCommandBuffer commands, gpu_image *image)
{
	gpu_vulkan_texels *texels = image->own;
	if (texels->rested > 0)
		return;
	texels->rested = gpu->resting;
	stilb_gpu_layout rest = gpu_vulkan_rest(&image->extent);
	uint32_t parts = (uint32_t)image->extent.layers * image->extent.mips, written = 0;
	for (uint32_t p = 0; p < parts; p++)
		written += image->layouts[p] != STILB_GPU_LAYOUT_NONE;
	if (written == 0) {
		stilb_gpu_range all = {0, (uint8_t)image->extent.mips, 0, image->extent.layers};
		gpu_vulkan_relayout(commands, texels, STILB_GPU_LAYOUT_NONE, rest, all);
		memset(image->layouts, (int)rest, parts);
		return;
	}
	for (uint32_t layer = 0; layer < image->extent.layers; layer++)
		for (uint32_t mip = 0; mip < image->extent.mips; mip++) {
			uint8_t *layout = &image->layouts[layer * image->extent.mips + mip];
			if (*layout != STILB_GPU_LAYOUT_NONE)
				continue;
			gpu_vulkan_relayout(commands, texels, STILB_GPU_LAYOUT_NONE, rest, part_of(mip, layer));
			*layout = (uint8_t)rest;
		}
}

/* Uploads that are copied without barriers between them: none writes what another one of them writes. */
#define GROUP 64u
typedef struct upload_group {
	const gpu_upload_ready *items[GROUP];
	uint64_t targets[GROUP]; /* what they write to: most uploads meet no other */
	uint32_t count;
	VkImageMemoryBarrier2 before[GROUP], after[GROUP]; /* of parts of images */
	uint32_t part_count;
} upload_group;

static bool same_part(const stilb_gpu_upload *a, const stilb_gpu_upload *b)
{
	return a->image.id != 0 && a->image.id == b->image.id && a->mip == b->mip && a->layer == b->layer;
}

static bool uploads_meet(const stilb_gpu_upload *a, const stilb_gpu_upload *b)
{
	if (a->image.id == 0)
		return a->buffer.id == b->buffer.id && a->offset < b->offset + b->bytes && b->offset < a->offset + a->bytes;
	return same_part(a, b) && a->x < b->x + b->width && b->x < a->x + a->width && a->y < b->y + b->height &&
	       b->y < a->y + a->height && a->z < b->z + b->depth && b->z < a->z + a->depth;
}

/* Ids of images are odd, those of buffers even. */
static uint64_t target_of(const stilb_gpu_upload *upload)
{
	return upload->image.id ? upload->image.id << 1 | 1 : upload->buffer.id << 1;
}

/* The group can take an upload. known: it has an upload to the same part already, or the target is a buffer, which has
 * no layout. */
static bool group_takes(const upload_group *group, const stilb_gpu_upload *upload, bool *known)
{
	uint64_t target = target_of(upload);
	*known = upload->image.id == 0;
	for (uint32_t i = 0; i < group->count; i++) {
		if (group->targets[i] != target)
			continue;
		if (uploads_meet(&group->items[i]->upload, upload))
			return false;
		*known = *known || same_part(&group->items[i]->upload, upload);
	}
	return group->count < GROUP;
}

/* Adds an upload that the group can take. known: as group_takes says. */
static void group_add(gpu_vulkan *gpu, VkCommandBuffer commands, upload_group *group, const gpu_upload_ready *ready,
                      bool known)
{
	const stilb_gpu_upload *u = &ready->upload;
	group->targets[group->count] = target_of(u);
	group->items[group->count++] = ready;
	if (known)
		return;
	gpu_image *image = gpu_image_of(&gpu->base, u->image.id);
	upload_rest(gpu, commands, image);
	uint8_t *layout = &image->layouts[u->layer * image->extent.mips + u->mip];
	stilb_gpu_layout from = (stilb_gpu_layout)*layout;
	if (from == STILB_GPU_LAYOUT_NONE)
		*layout = (uint8_t)gpu_vulkan_rest(&image->extent);
	stilb_gpu_range part = part_of(u->mip, u->layer);
	group->before[group->part_count] = gpu_vulkan_relayout_barrier(image->own, from, STILB_GPU_LAYOUT_COPY_TO, part);
	group->after[group->part_count++] =
		gpu_vulkan_relayout_barrier(image->own, STILB_GPU_LAYOUT_COPY_TO, (stilb_gpu_layout)*layout, part);
}

static void upload_copy(const gpu_vulkan *gpu, VkCommandBuffer commands, const gpu_upload_ready *ready)
{
	const stilb_gpu_upload *u = &ready->upload;
	const gpu_vulkan_buffer *ring = gpu->base.ring.buffer.own;
	if (u->image.id == 0) {
		const gpu_vulkan_buffer *target = gpu_buffer_of(&gpu->base, u->buffer.id)->own;
		VkBufferCopy copy = {ready->place, u->offset, u->bytes};
		vkCmdCopyBuffer(commands, ring->buffer, target->buffer, 1, &copy);
		return;
	}
	const gpu_vulkan_texels *texels = gpu_image_of(&gpu->base, u->image.id)->own;
	VkBufferImageCopy region = {
		.bufferOffset = ready->place,
		.imageSubresource = {texels->aspect, u->mip, u->layer, 1},
		.imageOffset = {(int32_t)u->x, (int32_t)u->y, (int32_t)u->z},
		.imageExtent = {u->width, u->height, u->depth},
	};
	vkCmdCopyBufferToImage(commands, ring->buffer, texels->image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
}

/* Records the copies of a group, which is then empty. */
static void group_record(const gpu_vulkan *gpu, VkCommandBuffer commands, upload_group *group)
{
	if (group->part_count > 0)
		gpu_vulkan_image_barriers(commands, group->before, group->part_count);
	for (uint32_t i = 0; i < group->count; i++)
		upload_copy(gpu, commands, group->items[i]);
	if (group->part_count > 0)
		gpu_vulkan_image_barriers(commands, group->after, group->part_count);
	gpu_vulkan_full_barrier(commands);
	group->count = group->part_count = 0;
}

static void white_make(gpu_vulkan *gpu, VkCommandBuffer commands)
{
	stilb_gpu_range all = {0, 1, 0, 1};
	VkImageSubresourceRange range = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
	VkClearColorValue one = {.float32 = {1.0f, 1.0f, 1.0f, 1.0f}};
	gpu_vulkan_relayout(commands, &gpu->white, STILB_GPU_LAYOUT_NONE, STILB_GPU_LAYOUT_COPY_TO, all);
	vkCmdClearColorImage(commands, gpu->white.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &one, 1, &range);
	gpu_vulkan_relayout(commands, &gpu->white, STILB_GPU_LAYOUT_COPY_TO, STILB_GPU_LAYOUT_SAMPLED, all);
	gpu->white_rested = gpu->resting;
}

void gpu_vulkan_uploads(gpu_vulkan *gpu, VkCommandBuffer commands, const gpu_upload_ready *uploads, uint32_t count)
{
	if (gpu->white_rested == 0)
		white_make(gpu, commands);
	if (count == 0)
		return;
	upload_group group;
	group.count = group.part_count = 0;
	gpu_vulkan_full_barrier(commands);
	for (uint32_t i = 0; i < count; i++) {
		bool known;
		if (!group_takes(&group, &uploads[i].upload, &known)) {
			group_record(gpu, commands, &group);
			group_takes(&group, &uploads[i].upload, &known);
		}
		group_add(gpu, commands, &group, &uploads[i], known);
	}
	group_record(gpu, commands, &group);
}

void gpu_vulkan_images_ready(gpu_vulkan *gpu, VkCommandBuffer commands)
{
	stilb_lock_take(&gpu->base.lock);
	for (uint32_t i = 0; i < gpu->fresh_count; i++)
		if (gpu->fresh[i]->entry.used && !gpu->fresh[i]->entry.hidden &&
		    gpu->fresh[i]->extent.uses & 1u << STILB_GPU_USE_SAMPLED)
			upload_rest(gpu, commands, gpu->fresh[i]);
	gpu->fresh_count = 0;
	stilb_lock_give(&gpu->base.lock);
}

stilb_result gpu_vulkan_flush(stilb_gpu *base, const gpu_upload_ready *uploads, uint32_t upload_count)
{
	gpu_vulkan *gpu = (gpu_vulkan *)base;
	gpu_vulkan_slot *slot = gpu_vulkan_slot_now(gpu);
	VkCommandBuffer commands = VK_NULL_HANDLE;
	if (upload_count == 0)
		return gpu_vulkan_timeline_wait(gpu, gpu->timeline_value);
	VkResult error = gpu_vulkan_extra_begin(gpu, slot, &commands);
	if (error != VK_SUCCESS)
		return gpu_vulkan_fail(gpu, error, "upload");
	gpu_vulkan_rest_begin(gpu);
	gpu_vulkan_uploads(gpu, commands, uploads, upload_count);
	error = vkEndCommandBuffer(commands);
	stilb_result result = error == VK_SUCCESS ? gpu_vulkan_queue_submit(gpu, commands, VK_NULL_HANDLE, VK_NULL_HANDLE)
	                                          : gpu_vulkan_fail(gpu, error, "upload");
	if (result != STILB_OK) {
		gpu_vulkan_rest_undo(gpu);
		return result;
	}
	slot->done = gpu->timeline_value;
	return gpu_vulkan_timeline_wait(gpu, gpu->timeline_value);
}

/* ---- read-back --------------------------------------------------------------------------------------------------- */

static void read_image(VkCommandBuffer commands, const gpu_vulkan_target *target, uint32_t mip, uint32_t layer,
                       VkBuffer to)
{
	const gpu_vulkan_texels *texels = target->texels;
	const stilb_gpu_extent *e = &texels->extent;
	VkBufferImageCopy region = {
		.imageSubresource = {texels->aspect, mip, layer, 1},
		.imageExtent = {gpu_mip_side(e->width, mip), gpu_mip_side(e->height, mip), gpu_mip_side(e->depth, mip)},
	};
	/* Outputs are in this layout after the frame (stilb_gpu_access OUTPUT). */
	stilb_gpu_layout layout =
		target->layouts ? (stilb_gpu_layout)target->layouts[layer * e->mips + mip] : STILB_GPU_LAYOUT_COPY_FROM;
	if (layout != STILB_GPU_LAYOUT_COPY_FROM)
		gpu_vulkan_relayout(commands, texels, layout, STILB_GPU_LAYOUT_COPY_FROM, part_of(mip, layer));
	vkCmdCopyImageToBuffer(commands, texels->image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to, 1, &region);
	if (layout != STILB_GPU_LAYOUT_COPY_FROM && layout != STILB_GPU_LAYOUT_NONE)
		gpu_vulkan_relayout(commands, texels, STILB_GPU_LAYOUT_COPY_FROM, layout, part_of(mip, layer));
}

stilb_result gpu_vulkan_read(stilb_gpu *base, const stilb_gpu_plan *plan, uint16_t resource, uint8_t mip,
                             uint16_t layer, gpu_read *read)
{
	gpu_vulkan *gpu = (gpu_vulkan *)base;
	gpu_vulkan_slot *slot = gpu_vulkan_slot_now(gpu);
	const gpu_vulkan_target *target = &gpu->targets[resource];
	const gpu_vulkan_buffer *to = read->buffer.own;
	(void)plan;
	VkCommandBuffer commands = VK_NULL_HANDLE;
	VkResult result = gpu_vulkan_extra_begin(gpu, slot, &commands);
	if (result != VK_SUCCESS)
		return gpu_vulkan_fail(gpu, result, "read an image back");
	gpu_vulkan_full_barrier(commands);
	if (target->texels)
		read_image(commands, target, mip, layer, to->buffer);
	else
		vkCmdCopyBuffer(commands, target->buffer->buffer, to->buffer, 1, &(VkBufferCopy){.size = read->bytes});
	gpu_vulkan_host_barrier(commands);
	gpu_vulkan_full_barrier(commands); /* the next frame may write it */
	result = vkEndCommandBuffer(commands);
	if (result != VK_SUCCESS)
		return gpu_vulkan_fail(gpu, result, "read an image back");
	stilb_result submitted = gpu_vulkan_queue_submit(gpu, commands, VK_NULL_HANDLE, VK_NULL_HANDLE);
	slot->done = gpu->timeline_value;
	read->done = gpu->timeline_value;
	return submitted;
}

stilb_result gpu_vulkan_read_done(stilb_gpu *base, const gpu_read *read, bool wait, bool *done)
{
	gpu_vulkan *gpu = (gpu_vulkan *)base;
	uint64_t value = 0;
	*done = false;
	if (wait) {
		stilb_result result = gpu_vulkan_timeline_wait(gpu, read->done);
		*done = result == STILB_OK;
		return result;
	}
	VkResult result = vkGetSemaphoreCounterValue(gpu->device, gpu->timeline, &value);
	*done = result == VK_SUCCESS && value >= read->done;
	return result == VK_SUCCESS ? STILB_OK : gpu_vulkan_fail(gpu, result, "ask the GPU how far it is");
}
