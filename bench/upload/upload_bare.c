/* The subjects of the suite `upload` that ours is compared with: `memcpy`, which writes the same bytes to memory like
 * the ring, and `vulkan_bare`, which copies from a mapped buffer to images by a plain Vulkan program. */
#include "bench/harness/bench_child.h"
#include "bench/subjects/vulkan_bare.h"
#include "bench/upload/upload_cases.h"

#include <string.h>

static uint8_t *source;

static void *take(size_t bytes)
{
	void *memory = malloc(bytes);
	if (!memory)
		bench_child_fail("no memory");
	return memory;
}

static uint64_t next_place(uint64_t at, uint64_t bytes)
{
	return at + 2 * bytes <= UPLOAD_SOURCE_BYTES ? at + bytes : 0;
}

/* ---- memcpy ------------------------------------------------------------------------------------------------------ */

/* As the ring is used: what was written last is copied on before its memory is written again. */
static void run_memcpy(double seconds, uint32_t bytes)
{
	static upload_samples samples;
	uint32_t count = upload_batch(bytes);
	uint8_t *ring = take(UPLOAD_RING_BYTES), *target = take(UPLOAD_BATCH_BYTES);
	uint64_t end = bench_child_now_ns() + (uint64_t)(seconds * 1e9), at = 0, head = 0;
	for (uint32_t round = 0; round < 8 || bench_child_now_ns() < end; round++) {
		head = head + (uint64_t)count * bytes > UPLOAD_RING_BYTES ? 0 : head;
		uint64_t first = head, from = at, begin = bench_child_now_ns();
		for (uint32_t i = 0; i < count; i++, at = next_place(at, bytes), head += bytes) {
			memcpy(ring + head, source + at, bytes);
			__asm__ volatile("" ::: "memory"); /* one after the other, as calls */
		}
		double time = (double)(bench_child_now_ns() - begin);
		if (round >= 4)
			upload_sample(&samples, (double)count * bytes / time);
		memcpy(target, ring + first, (size_t)count * bytes);
		if (memcmp(target, source + from, bytes) != 0)
			bench_child_fail("round %u: what arrived is not what was written", round);
	}
	bench_child_metric("written", upload_quantile(&samples, 0.5));
	free(ring);
	free(target);
}

/* ---- plain Vulkan ------------------------------------------------------------------------------------------------ */

typedef struct copier {
	bare b;
	VkCommandPool pool;
	VkCommandBuffer commands;
	VkFence done;
	bare_buffer ring;
	bare_image images[UPLOAD_BATCH_MOST];
	VkImageMemoryBarrier2 barriers[UPLOAD_BATCH_MOST];
	uint32_t count, side;
} copier;

static VkImageMemoryBarrier2 transition(VkImage image, VkImageLayout from, VkImageLayout to, bool first)
{
	return (VkImageMemoryBarrier2){
		.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
		.srcStageMask = first ? VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT : VK_PIPELINE_STAGE_2_COPY_BIT,
		.srcAccessMask = first ? 0 : VK_ACCESS_2_TRANSFER_WRITE_BIT,
		.dstStageMask = first ? VK_PIPELINE_STAGE_2_COPY_BIT : VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT,
		.dstAccessMask = first ? VK_ACCESS_2_TRANSFER_WRITE_BIT : VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
		.oldLayout = from,
		.newLayout = to,
		.image = image,
		.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1},
	};
}

static void copier_open(copier *c, uint32_t bytes)
{
	if (!bare_open(&c->b))
		exit(BENCH_CHILD_SKIP);
	bare *b = &c->b;
	VkCommandPoolCreateInfo pool = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
		.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT,
	};
	bare_check(vkCreateCommandPool(b->device, &pool, NULL, &c->pool), "vkCreateCommandPool");
	VkCommandBufferAllocateInfo commands = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
		.commandPool = c->pool,
		.commandBufferCount = 1,
	};
	bare_check(vkAllocateCommandBuffers(b->device, &commands, &c->commands), "vkAllocateCommandBuffers");
	VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
	bare_check(vkCreateFence(b->device, &fence, NULL, &c->done), "vkCreateFence");
	c->ring = bare_make_buffer(b, UPLOAD_RING_BYTES, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
	c->count = upload_batch(bytes);
	c->side = (uint32_t)sqrt((double)bytes / 4.0);
	for (uint32_t i = 0; i < c->count; i++) {
		c->images[i] =
			bare_make_image(b, c->side, c->side, VK_FORMAT_R8G8B8A8_UNORM,
		                    VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT, VK_IMAGE_ASPECT_COLOR_BIT);
	}
}

/* All images before or after their copies. Written anew each time, as by a program whose images change. */
static void barriers(copier *c, bool before)
{
	VkImageLayout from = before ? VK_IMAGE_LAYOUT_UNDEFINED : VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
	VkImageLayout to = before ? VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL : VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
	for (uint32_t i = 0; i < c->count; i++)
		c->barriers[i] = transition(c->images[i].image, from, to, before);
	VkDependencyInfo dependency = {
		.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
		.imageMemoryBarrierCount = c->count,
		.pImageMemoryBarriers = c->barriers,
	};
	vkCmdPipelineBarrier2(c->commands, &dependency);
}

/* Records the copies from byte `first` of the ring on, and waits until they are done. */
static void copy_all(copier *c, uint64_t first, uint32_t bytes)
{
	VkCommandBufferBeginInfo begin = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
		.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT,
	};
	bare_check(vkResetCommandPool(c->b.device, c->pool, 0), "vkResetCommandPool");
	bare_check(vkBeginCommandBuffer(c->commands, &begin), "vkBeginCommandBuffer");
	barriers(c, true);
	for (uint32_t i = 0; i < c->count; i++) {
		VkBufferImageCopy region = {
			.bufferOffset = first + (uint64_t)i * bytes,
			.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
			.imageExtent = {c->side, c->side, 1},
		};
		vkCmdCopyBufferToImage(c->commands, c->ring.buffer, c->images[i].image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1,
		                       &region);
	}
	barriers(c, false);
	bare_check(vkEndCommandBuffer(c->commands), "vkEndCommandBuffer");
	VkSubmitInfo submit = {
		.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
		.commandBufferCount = 1,
		.pCommandBuffers = &c->commands,
	};
	bare_check(vkQueueSubmit(c->b.queue, 1, &submit, c->done), "vkQueueSubmit");
	bare_check(vkWaitForFences(c->b.device, 1, &c->done, VK_TRUE, UINT64_MAX), "vkWaitForFences");
	bare_check(vkResetFences(c->b.device, 1, &c->done), "vkResetFences");
}

static void copier_close(copier *c)
{
	for (uint32_t i = 0; i < c->count; i++)
		bare_free_image(&c->b, &c->images[i]);
	bare_free_buffer(&c->b, &c->ring);
	vkDestroyFence(c->b.device, c->done, NULL);
	vkDestroyCommandPool(c->b.device, c->pool, NULL);
	vkDestroyDevice(c->b.device, NULL);
	vkDestroyInstance(c->b.instance, NULL);
}

static void run_copies(double seconds, uint32_t bytes)
{
	static upload_samples samples;
	static copier c;
	copier_open(&c, bytes);
	uint64_t end = bench_child_now_ns() + (uint64_t)(seconds * 1e9), at = 0, head = 0;
	for (uint32_t round = 0; round < 8 || bench_child_now_ns() < end; round++) {
		if (head + (uint64_t)c.count * bytes > UPLOAD_RING_BYTES)
			head = 0;
		for (uint32_t i = 0; i < c.count; i++, at = next_place(at, bytes))
			memcpy((uint8_t *)c.ring.mapped + head + (uint64_t)i * bytes, source + at, bytes);
		uint64_t begin = bench_child_now_ns();
		copy_all(&c, head, bytes);
		if (round >= 4)
			upload_sample(&samples, (double)(bench_child_now_ns() - begin) / c.count);
		head += (uint64_t)c.count * bytes;
	}
	bench_child_metric("copied", upload_quantile(&samples, 0.5) * 1e-3);
	copier_close(&c);
}

int main(int argc, char **argv)
{
	bench_child child = bench_child_args(argc, argv);
	source = take(UPLOAD_SOURCE_BYTES);
	for (size_t i = 0; i < UPLOAD_SOURCE_BYTES / 4; i++)
		((uint32_t *)source)[i] = (uint32_t)i * 2654435761u;
#define CASE(NAME, TITLE, KIND, BYTES)                                                                                 \
	if (strcmp(child.case_name, NAME) == 0)                                                                            \
		UPLOAD_##KIND == UPLOAD_CALLER ? run_memcpy(child.seconds, BYTES) : run_copies(child.seconds, BYTES);
	UPLOAD_CASES(CASE)
#undef CASE
	free(source);
	return 0;
}
