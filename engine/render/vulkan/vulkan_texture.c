/* Textures on the GPU: an image and a descriptor set each, made on the thread that creates the texture. There is one
 * mip level, so distant textures may flicker. All calls hold the lock of render_resources, which also guards the
 * pool. */
#include "render/vulkan/vulkan_internal.h"

#include <stdio.h>
#include <stdlib.h>

static const VkFormat texture_formats[] = {
	[STILB_IMAGE_U8_SRGB] = VK_FORMAT_R8G8B8A8_SRGB,
	[STILB_IMAGE_F16_LINEAR] = VK_FORMAT_R16G16B16A16_SFLOAT,
	[STILB_IMAGE_F32_LINEAR] = VK_FORMAT_R32G32B32A32_SFLOAT,
};

static VkResult textures_make(vulkan_device *device)
{
	VkSamplerCreateInfo sampler = {
		.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
		.magFilter = VK_FILTER_LINEAR,
		.minFilter = VK_FILTER_LINEAR,
		.addressModeU = VK_SAMPLER_ADDRESS_MODE_REPEAT,
		.addressModeV = VK_SAMPLER_ADDRESS_MODE_REPEAT,
	};
	VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, STILB_RENDER_MAX_TEXTURES};
	VkDescriptorPoolCreateInfo pool = {
		.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
		.flags = VK_DESCRIPTOR_POOL_CREATE_FREE_DESCRIPTOR_SET_BIT,
		.maxSets = STILB_RENDER_MAX_TEXTURES,
		.poolSizeCount = 1,
		.pPoolSizes = &size,
	};
	VkResult result = vkCreateSampler(device->gpu->device, &sampler, device->gpu->allocator, &device->sampler);
	if (result == VK_SUCCESS)
		result = vkCreateDescriptorPool(device->gpu->device, &pool, device->gpu->allocator, &device->texture_pool);
	return result;
}

stilb_result vulkan_textures_create(vulkan_device *device)
{
	device->textures = calloc(STILB_RENDER_MAX_TEXTURES, sizeof *device->textures);
	if (!device->textures)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the table of textures");
	VkResult result = textures_make(device);
	return result == VK_SUCCESS ? STILB_OK : gpu_vulkan_fail(device->gpu, result, "make a sampler of textures");
}

void vulkan_textures_destroy(vulkan_device *device)
{
	for (uint32_t t = 0; device->textures && t < STILB_RENDER_MAX_TEXTURES; t++)
		gpu_vulkan_image_destroy(device->gpu, &device->textures[t].image);
	vkDestroyDescriptorPool(device->gpu->device, device->texture_pool, device->gpu->allocator); /* frees the sets too */
	vkDestroySampler(device->gpu->device, device->sampler, device->gpu->allocator);
	free(device->textures);
	device->textures = NULL;
}

/* ---- one texture ------------------------------------------------------------------------------------------------- */

/* Checks the GPU's limits: creating an image beyond them is undefined behaviour, not an error. */
static stilb_result texture_check(const vulkan_device *device, const VkImageCreateInfo *info, const stilb_image *image)
{
	VkFormatFeatureFlags needed = VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT |
	                              VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT |
	                              VK_FORMAT_FEATURE_TRANSFER_DST_BIT;
	VkFormatProperties format;
	VkImageFormatProperties can;
	vkGetPhysicalDeviceFormatProperties(device->gpu->physical, info->format, &format);
	VkResult result = vkGetPhysicalDeviceImageFormatProperties(device->gpu->physical, info->format, info->imageType,
	                                                           info->tiling, info->usage, info->flags, &can);
	if ((format.optimalTilingFeatures & needed) != needed || result == VK_ERROR_FORMAT_NOT_SUPPORTED)
		return stilb_fail(
			STILB_ERROR_ARGUMENT, "GPU '%s' cannot filter textures of %s; use an image of 8-bit codes or 16-bit floats",
			device->gpu->base.name, info->format == VK_FORMAT_R32G32B32A32_SFLOAT ? "32-bit floats" : "this format");
	if (result != VK_SUCCESS)
		return gpu_vulkan_fail(device->gpu, result, "ask the GPU for its largest texture");
	if (info->extent.width > can.maxExtent.width || info->extent.height > can.maxExtent.height)
		return render_texture_too_large(&device->base, can.maxExtent.width, can.maxExtent.height, image);
	return STILB_OK;
}

static VkResult texture_set_create(vulkan_device *device, vulkan_texture *texture)
{
	VkDescriptorSetAllocateInfo info = {
		.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
		.descriptorPool = device->texture_pool,
		.descriptorSetCount = 1,
		.pSetLayouts = &device->texture_layout,
	};
	VkResult result = vkAllocateDescriptorSets(device->gpu->device, &info, &texture->set);
	if (result != VK_SUCCESS)
		return result;
	VkDescriptorImageInfo image = {
		.imageView = texture->image.view,
		.imageLayout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
	};
	VkWriteDescriptorSet write = {
		.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
		.dstSet = texture->set,
		.descriptorCount = 1,
		.descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
		.pImageInfo = &image,
	};
	vkUpdateDescriptorSets(device->gpu->device, 1, &write, 0, NULL);
	return VK_SUCCESS;
}

stilb_result vulkan_texture_create(render_device *base, uint32_t index, const stilb_image *image)
{
	vulkan_device *device = (vulkan_device *)base;
	STILB_ASSERT(index > 0 && index < STILB_RENDER_MAX_TEXTURES && image->channels == 4);
	vulkan_texture *texture = &device->textures[index];
	STILB_ASSERT(!texture->image.image && !texture->set && "a released index");
	VkImageCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
		.imageType = VK_IMAGE_TYPE_2D,
		.format = texture_formats[image->format],
		.extent = {image->width, image->height, 1},
		.mipLevels = 1,
		.arrayLayers = 1,
		.samples = VK_SAMPLE_COUNT_1_BIT,
		.tiling = VK_IMAGE_TILING_OPTIMAL,
		.usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
		.initialLayout = VK_IMAGE_LAYOUT_UNDEFINED,
	};
	stilb_result possible = texture_check(device, &info, image);
	if (possible != STILB_OK)
		return possible;
	VkResult result = gpu_vulkan_image_create(device->gpu, &info, VK_IMAGE_ASPECT_COLOR_BIT, &texture->image);
	if (result == VK_SUCCESS)
		result = texture_set_create(device, texture);
	if (result == VK_SUCCESS)
		return STILB_OK;
	gpu_vulkan_image_destroy(device->gpu, &texture->image);
	char what[64];
	snprintf(what, sizeof what, "make a texture of %ux%u pixels", image->width, image->height);
	return gpu_vulkan_fail(device->gpu, result, what);
}

void vulkan_texture_destroy(render_device *base, uint32_t index)
{
	vulkan_device *device = (vulkan_device *)base;
	vulkan_texture *texture = &device->textures[index];
	STILB_ASSERT(texture->image.image && texture->set);
	vkFreeDescriptorSets(device->gpu->device, device->texture_pool, 1, &texture->set);
	gpu_vulkan_image_destroy(device->gpu, &texture->image);
	*texture = (vulkan_texture){0};
}

void vulkan_texture_copy(vulkan_device *device, const render_texture_upload *upload, VkDeviceSize at)
{
	vulkan_slot *slot = vulkan_slot_now(device);
	VkImage image = device->textures[upload->texture].image.image;
	STILB_ASSERT(image && at % 16 == 0 && upload->sent > upload->rows);
	VkBufferImageCopy region = {
		.bufferOffset = at,
		.imageSubresource = {.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT, .layerCount = 1},
		.imageOffset = {0, (int32_t)upload->rows, 0},
		.imageExtent = {upload->image.width, upload->sent - upload->rows, 1},
	};
	/* Draws of the frames before may still sample a texture that is written again. */
	if (upload->rows == 0)
		gpu_vulkan_image_barrier(slot->gpu->draw, image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
		                         VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
		                         VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_2_COPY_BIT,
		                         VK_ACCESS_2_NONE, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT);
	vkCmdCopyBufferToImage(slot->gpu->draw, slot->staging.buffer, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1,
	                       &region);
	if (upload->sent < upload->image.height)
		return; /* heaps_barrier orders the next rows after these */
	gpu_vulkan_image_barrier(slot->gpu->draw, image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
	                         VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, VK_PIPELINE_STAGE_2_COPY_BIT,
	                         VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT,
	                         VK_ACCESS_2_SHADER_SAMPLED_READ_BIT);
}
