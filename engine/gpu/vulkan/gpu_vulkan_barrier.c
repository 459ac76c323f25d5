/* Barriers between the commands of a queue. */
#include "gpu/vulkan/gpu_vulkan_internal.h"

VkImageMemoryBarrier2 gpu_vulkan_image_transition(VkImage image, VkImageAspectFlags aspect, VkImageLayout from,
                                                  VkImageLayout to, VkPipelineStageFlags2 from_stage,
                                                  VkAccessFlags2 from_access, VkPipelineStageFlags2 to_stage,
                                                  VkAccessFlags2 to_access)
{
	STILB_ASSERT(image && aspect && to != VK_IMAGE_LAYOUT_UNDEFINED);
	return (VkImageMemoryBarrier2){
		.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
		.srcStageMask = from_stage,
		.srcAccessMask = from_access,
		.dstStageMask = to_stage,
		.dstAccessMask = to_access,
		.oldLayout = from,
		.newLayout = to,
		.srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
		.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
		.image = image,
		.subresourceRange = {.aspectMask = aspect, .levelCount = 1, .layerCount = 1},
	};
}

void gpu_vulkan_image_barriers(VkCommandBuffer commands, const VkImageMemoryBarrier2 *transitions, uint32_t count)
{
	STILB_ASSERT(commands && count > 0);
	VkDependencyInfo dependency = {
		.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
		.imageMemoryBarrierCount = count,
		.pImageMemoryBarriers = transitions,
	};
	vkCmdPipelineBarrier2(commands, &dependency);
}

void gpu_vulkan_image_barrier(VkCommandBuffer commands, VkImage image, VkImageAspectFlags aspect, VkImageLayout from,
                              VkImageLayout to, VkPipelineStageFlags2 from_stage, VkAccessFlags2 from_access,
                              VkPipelineStageFlags2 to_stage, VkAccessFlags2 to_access)
{
	VkImageMemoryBarrier2 transition =
		gpu_vulkan_image_transition(image, aspect, from, to, from_stage, from_access, to_stage, to_access);
	gpu_vulkan_image_barriers(commands, &transition, 1);
}

void gpu_vulkan_host_barrier(VkCommandBuffer commands)
{
	VkMemoryBarrier2 barrier = {
		.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
		.srcStageMask = VK_PIPELINE_STAGE_2_COPY_BIT | VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
		.srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
		.dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT,
		.dstAccessMask = VK_ACCESS_2_HOST_READ_BIT,
	};
	VkDependencyInfo dependency = {
		.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
		.memoryBarrierCount = 1,
		.pMemoryBarriers = &barrier,
	};
	vkCmdPipelineBarrier2(commands, &dependency);
}
