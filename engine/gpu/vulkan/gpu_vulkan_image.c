/* Images of all shapes, their views, samplers, and sets of draw lists. */
#include "gpu/vulkan/gpu_vulkan_internal.h"

#include <stdio.h>
#include <stdlib.h>

/* ---- formats ----------------------------------------------------------------------------------------------------- */

static const VkFormat texel_formats[STILB_GPU_FORMAT_COUNT] = {
	[STILB_GPU_NONE] = VK_FORMAT_UNDEFINED,
	[STILB_GPU_R8_U] = VK_FORMAT_R8_UNORM,
	[STILB_GPU_RG8_U] = VK_FORMAT_R8G8_UNORM,
	[STILB_GPU_RGBA8_U] = VK_FORMAT_R8G8B8A8_UNORM,
	[STILB_GPU_RGBA8_SRGB] = VK_FORMAT_R8G8B8A8_SRGB,
	[STILB_GPU_RGB10A2_U] = VK_FORMAT_A2B10G10R10_UNORM_PACK32,
	[STILB_GPU_R16_U] = VK_FORMAT_R16_UNORM,
	[STILB_GPU_RG16_U] = VK_FORMAT_R16G16_UNORM,
	[STILB_GPU_RGBA16_U] = VK_FORMAT_R16G16B16A16_UNORM,
	[STILB_GPU_RG16_S] = VK_FORMAT_R16G16_SNORM,
	[STILB_GPU_R16_F] = VK_FORMAT_R16_SFLOAT,
	[STILB_GPU_RG16_F] = VK_FORMAT_R16G16_SFLOAT,
	[STILB_GPU_RGBA16_F] = VK_FORMAT_R16G16B16A16_SFLOAT,
	[STILB_GPU_R11G11B10_F] = VK_FORMAT_B10G11R11_UFLOAT_PACK32,
	[STILB_GPU_R32_F] = VK_FORMAT_R32_SFLOAT,
	[STILB_GPU_RG32_F] = VK_FORMAT_R32G32_SFLOAT,
	[STILB_GPU_RGB32_F] = VK_FORMAT_R32G32B32_SFLOAT,
	[STILB_GPU_RGBA32_F] = VK_FORMAT_R32G32B32A32_SFLOAT,
	[STILB_GPU_R8_UI] = VK_FORMAT_R8_UINT,
	[STILB_GPU_R16_UI] = VK_FORMAT_R16_UINT,
	[STILB_GPU_R32_UI] = VK_FORMAT_R32_UINT,
	[STILB_GPU_RG32_UI] = VK_FORMAT_R32G32_UINT,
	[STILB_GPU_D16] = VK_FORMAT_D16_UNORM,
	[STILB_GPU_D32_F] = VK_FORMAT_D32_SFLOAT,
	[STILB_GPU_D32_F_S8] = VK_FORMAT_D32_SFLOAT_S8_UINT,
	[STILB_GPU_BC1_U] = VK_FORMAT_BC1_RGBA_UNORM_BLOCK,
	[STILB_GPU_BC1_SRGB] = VK_FORMAT_BC1_RGBA_SRGB_BLOCK,
	[STILB_GPU_BC3_U] = VK_FORMAT_BC3_UNORM_BLOCK,
	[STILB_GPU_BC3_SRGB] = VK_FORMAT_BC3_SRGB_BLOCK,
	[STILB_GPU_BC4_U] = VK_FORMAT_BC4_UNORM_BLOCK,
	[STILB_GPU_BC5_U] = VK_FORMAT_BC5_UNORM_BLOCK,
	[STILB_GPU_BC6H_F] = VK_FORMAT_BC6H_UFLOAT_BLOCK,
	[STILB_GPU_BC7_U] = VK_FORMAT_BC7_UNORM_BLOCK,
	[STILB_GPU_BC7_SRGB] = VK_FORMAT_BC7_SRGB_BLOCK,
};

VkFormat gpu_vulkan_format(stilb_gpu_format format)
{
	STILB_ASSERT((uint32_t)format < STILB_GPU_FORMAT_COUNT);
	return texel_formats[format];
}

#define STORAGE_USES                                                                                                   \
	(1u << STILB_GPU_USE_STORAGE_READ | 1u << STILB_GPU_USE_STORAGE_WRITE | 1u << STILB_GPU_USE_STORAGE)

void gpu_vulkan_formats_find(gpu_vulkan *gpu)
{
	static const struct {
		VkFormatFeatureFlags feature;
		uint32_t uses;
	} meanings[] = {
		{VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT, 1u << STILB_GPU_USE_SAMPLED},
		{VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT, STORAGE_USES},
		{VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT, STILB_GPU_EXTENT_ATTACHMENT},
		{VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT, STILB_GPU_EXTENT_ATTACHMENT},
		{VK_FORMAT_FEATURE_TRANSFER_SRC_BIT, 1u << STILB_GPU_USE_COPY_FROM},
		{VK_FORMAT_FEATURE_TRANSFER_DST_BIT, 1u << STILB_GPU_USE_COPY_TO},
		{VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT, GPU_FORMAT_LINEAR},
		{VK_FORMAT_FEATURE_BLIT_SRC_BIT, GPU_FORMAT_BLIT_FROM},
		{VK_FORMAT_FEATURE_BLIT_DST_BIT, GPU_FORMAT_BLIT_TO},
	};
	for (uint32_t f = STILB_GPU_NONE + 1; f < STILB_GPU_FORMAT_COUNT; f++) {
		VkFormatProperties properties;
		vkGetPhysicalDeviceFormatProperties(gpu->physical, texel_formats[f], &properties);
		gpu->base.formats[f] = 0;
		for (size_t m = 0; m < sizeof meanings / sizeof *meanings; m++)
			if (properties.optimalTilingFeatures & meanings[m].feature)
				gpu->base.formats[f] |= meanings[m].uses;
	}
	gpu->base.formats[STILB_GPU_RGB32_F] = 0; /* see gpu_format.h */
	gpu->base.formats[STILB_GPU_D32_F_S8] &= STILB_GPU_EXTENT_ATTACHMENT;
}

VkImageLayout gpu_vulkan_layout(stilb_gpu_layout layout)
{
	static const VkImageLayout layouts[STILB_GPU_LAYOUTS] = {
		[STILB_GPU_LAYOUT_NONE] = VK_IMAGE_LAYOUT_UNDEFINED,
		[STILB_GPU_LAYOUT_COLOR] = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
		[STILB_GPU_LAYOUT_DEPTH] = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
		[STILB_GPU_LAYOUT_DEPTH_READ] = VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL,
		[STILB_GPU_LAYOUT_SAMPLED] = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
		[STILB_GPU_LAYOUT_STORAGE] = VK_IMAGE_LAYOUT_GENERAL,
		[STILB_GPU_LAYOUT_COPY_FROM] = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
		[STILB_GPU_LAYOUT_COPY_TO] = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
	};
	STILB_ASSERT((uint32_t)layout < STILB_GPU_LAYOUTS);
	return layouts[layout];
}

stilb_gpu_layout gpu_vulkan_rest(const stilb_gpu_extent *extent)
{
	bool depth = stilb_gpu_format_describe(extent->format)->kind == STILB_GPU_FORMAT_DEPTH;
	if (extent->uses & 1u << STILB_GPU_USE_SAMPLED)
		return depth ? STILB_GPU_LAYOUT_DEPTH_READ : STILB_GPU_LAYOUT_SAMPLED;
	return STILB_GPU_LAYOUT_STORAGE; /* GENERAL, for all */
}

void gpu_vulkan_name(gpu_vulkan *gpu, VkObjectType type, uint64_t object, const char *name)
{
	if (gpu->object_name && name && *name && object)
		gpu->object_name(gpu->device, &(VkDebugUtilsObjectNameInfoEXT){
										  .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT,
										  .objectType = type,
										  .objectHandle = object,
										  .pObjectName = name,
									  });
}

/* ---- images ------------------------------------------------------------------------------------------------------ */

static VkImageCreateInfo texels_info(const stilb_gpu_extent *e)
{
	static const VkImageType types[] = {
		[STILB_GPU_SHAPE_2D] = VK_IMAGE_TYPE_2D,
		[STILB_GPU_SHAPE_CUBE] = VK_IMAGE_TYPE_2D,
		[STILB_GPU_SHAPE_3D] = VK_IMAGE_TYPE_3D,
		[STILB_GPU_SHAPE_1D] = VK_IMAGE_TYPE_1D,
	};
	bool depth = stilb_gpu_format_describe(e->format)->kind == STILB_GPU_FORMAT_DEPTH;
	VkImageUsageFlags usage = 0;
	if (e->uses & 1u << STILB_GPU_USE_SAMPLED)
		usage |= VK_IMAGE_USAGE_SAMPLED_BIT;
	if (e->uses & STORAGE_USES)
		usage |= VK_IMAGE_USAGE_STORAGE_BIT;
	if (e->uses & 1u << STILB_GPU_USE_COPY_FROM)
		usage |= VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
	if (e->uses & 1u << STILB_GPU_USE_COPY_TO)
		usage |= VK_IMAGE_USAGE_TRANSFER_DST_BIT;
	if (e->uses & STILB_GPU_EXTENT_ATTACHMENT)
		usage |= depth ? VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT : VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
	return (VkImageCreateInfo){
		.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
		.flags = e->shape == STILB_GPU_SHAPE_CUBE ? VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT : 0,
		.imageType = types[e->shape],
		.format = texel_formats[e->format],
		.extent = {e->width, e->height, e->depth},
		.mipLevels = e->mips,
		.arrayLayers = e->layers,
		.samples = (VkSampleCountFlagBits)e->samples,
		.tiling = VK_IMAGE_TILING_OPTIMAL,
		.usage = usage,
		.initialLayout = VK_IMAGE_LAYOUT_UNDEFINED,
	};
}

/* Asks whether the GPU has such an image: creating one that it has not is undefined, not an error. */
static VkResult texels_check(const gpu_vulkan *gpu, const VkImageCreateInfo *info)
{
	VkImageFormatProperties can;
	VkResult result = vkGetPhysicalDeviceImageFormatProperties(gpu->physical, info->format, info->imageType,
	                                                           info->tiling, info->usage, info->flags, &can);
	if (result != VK_SUCCESS)
		return result;
	bool fits = info->extent.width <= can.maxExtent.width && info->extent.height <= can.maxExtent.height &&
	            info->extent.depth <= can.maxExtent.depth && info->mipLevels <= can.maxMipLevels &&
	            info->arrayLayers <= can.maxArrayLayers && (can.sampleCounts & info->samples) != 0;
	return fits ? VK_SUCCESS : VK_ERROR_FORMAT_NOT_SUPPORTED;
}

VkResult gpu_vulkan_texels_needs(gpu_vulkan *gpu, const stilb_gpu_extent *extent, VkMemoryRequirements *needs)
{
	VkImageCreateInfo info = texels_info(extent);
	VkImage image;
	VkResult result = texels_check(gpu, &info);
	if (result == VK_SUCCESS)
		result = vkCreateImage(gpu->device, &info, gpu->allocator, &image);
	if (result != VK_SUCCESS)
		return result;
	vkGetImageMemoryRequirements(gpu->device, image, needs);
	vkDestroyImage(gpu->device, image, gpu->allocator);
	return VK_SUCCESS;
}

static VkResult texels_make(gpu_vulkan *gpu, const VkImageCreateInfo *info, const gpu_memory_place *memory,
                            uint64_t offset, gpu_vulkan_texels *texels)
{
	VkResult result = vkCreateImage(gpu->device, info, gpu->allocator, &texels->image);
	if (result != VK_SUCCESS)
		return result;
	if (!memory) {
		VkMemoryRequirements needs;
		vkGetImageMemoryRequirements(gpu->device, texels->image, &needs);
		result = gpu_vulkan_memory_take(gpu, gpu_vulkan_memory_heap(gpu, needs, true), needs.size, needs.alignment,
		                                &texels->place);
		if (result != VK_SUCCESS)
			return result;
		memory = &texels->place;
	}
	return vkBindImageMemory(gpu->device, texels->image, gpu_vulkan_memory_of(memory->handle), memory->offset + offset);
}

VkResult gpu_vulkan_texels_create(gpu_vulkan *gpu, const char *name, const stilb_gpu_extent *extent,
                                  const gpu_memory_place *memory, uint64_t offset, gpu_vulkan_texels *texels)
{
	VkImageCreateInfo info = texels_info(extent);
	bool depth = stilb_gpu_format_describe(extent->format)->kind == STILB_GPU_FORMAT_DEPTH;
	*texels = (gpu_vulkan_texels){
		.extent = *extent,
		.format = info.format,
		.aspect = depth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT,
	};
	if (stilb_gpu_format_has_stencil(extent->format))
		texels->aspect |= VK_IMAGE_ASPECT_STENCIL_BIT;
	VkResult result = texels_check(gpu, &info);
	if (result == VK_SUCCESS)
		result = texels_make(gpu, &info, memory, offset, texels);
	if (result != VK_SUCCESS)
		gpu_vulkan_texels_destroy(gpu, texels);
	else
		gpu_vulkan_name(gpu, VK_OBJECT_TYPE_IMAGE, (uint64_t)texels->image, name);
	return result;
}

void gpu_vulkan_texels_destroy(gpu_vulkan *gpu, gpu_vulkan_texels *texels)
{
	for (uint32_t v = 0; v < texels->view_count; v++)
		vkDestroyImageView(gpu->device, texels->views[v].view, gpu->allocator);
	free(texels->views);
	vkDestroyImage(gpu->device, texels->image, gpu->allocator);
	gpu_memory_give(&gpu->blocks, &texels->place);
	*texels = (gpu_vulkan_texels){0};
}

/* ---- views ------------------------------------------------------------------------------------------------------- */

/* One layer is 2D, several are an array, all six of a cube are a cube. */
static VkImageViewType view_type(const stilb_gpu_extent *e, gpu_vulkan_seen seen, stilb_gpu_range range)
{
	if (e->shape == STILB_GPU_SHAPE_3D)
		return VK_IMAGE_VIEW_TYPE_3D;
	if (e->shape == STILB_GPU_SHAPE_1D)
		return range.layers > 1 ? VK_IMAGE_VIEW_TYPE_1D_ARRAY : VK_IMAGE_VIEW_TYPE_1D;
	if (e->shape == STILB_GPU_SHAPE_CUBE && seen == GPU_VULKAN_SAMPLED && range.layers == 6)
		return VK_IMAGE_VIEW_TYPE_CUBE;
	return range.layers > 1 || seen == GPU_VULKAN_ARRAY ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D;
}

static VkImageView view_make(gpu_vulkan *gpu, gpu_vulkan_texels *texels, VkImageViewType type, stilb_gpu_range range)
{
	if (texels->view_count == texels->view_capacity) {
		uint32_t capacity = texels->view_capacity ? 2 * texels->view_capacity : 2;
		gpu_vulkan_view *grown = realloc(texels->views, capacity * sizeof *grown);
		if (!grown)
			return VK_NULL_HANDLE;
		texels->views = grown;
		texels->view_capacity = capacity;
	}
	static const VkComponentMapping mappings[STILB_GPU_CHANNELS_COUNT] = {
		[STILB_GPU_CHANNELS_GREY] = {VK_COMPONENT_SWIZZLE_R, VK_COMPONENT_SWIZZLE_R, VK_COMPONENT_SWIZZLE_R,
	                                 VK_COMPONENT_SWIZZLE_ONE},
		[STILB_GPU_CHANNELS_GREY_ALPHA] = {VK_COMPONENT_SWIZZLE_R, VK_COMPONENT_SWIZZLE_R, VK_COMPONENT_SWIZZLE_R,
	                                       VK_COMPONENT_SWIZZLE_G},
	};
	VkImageViewCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
		.image = texels->image,
		.viewType = type,
		.format = texels->format,
		.components = mappings[texels->channels],
		.subresourceRange = {texels->aspect, range.mip, range.mips, range.layer, range.layers},
	};
	gpu_vulkan_view view = {type, range.mip, range.mips, range.layer, range.layers, VK_NULL_HANDLE};
	if (vkCreateImageView(gpu->device, &info, gpu->allocator, &view.view) != VK_SUCCESS)
		return VK_NULL_HANDLE;
	texels->views[texels->view_count++] = view;
	return view.view;
}

VkImageView gpu_vulkan_texels_view(gpu_vulkan *gpu, gpu_vulkan_texels *texels, gpu_vulkan_seen seen,
                                   stilb_gpu_range range)
{
	VkImageViewType type = view_type(&texels->extent, seen, range);
	VkImageView found = VK_NULL_HANDLE;
	stilb_lock_take(&gpu->views_lock);
	for (uint32_t v = 0; v < texels->view_count && !found; v++) {
		const gpu_vulkan_view *view = &texels->views[v];
		if (view->type == type && view->mip == range.mip && view->mips == range.mips && view->layer == range.layer &&
		    view->layers == range.layers)
			found = view->view;
	}
	if (!found)
		found = view_make(gpu, texels, type, range);
	stilb_lock_give(&gpu->views_lock);
	return found;
}

/* ---- images of programs ------------------------------------------------------------------------------------------ */

stilb_result gpu_vulkan_image_make(stilb_gpu *base, gpu_image *image)
{
	gpu_vulkan *gpu = (gpu_vulkan *)base;
	gpu_vulkan_texels *texels = calloc(1, sizeof *texels);
	if (!texels)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for image '%s'", image->name);
	VkResult result = gpu_vulkan_texels_create(gpu, image->name, &image->extent, NULL, 0, texels);
	if (result == VK_SUCCESS) {
		texels->channels = image->channels;
		image->own = texels;
		stilb_result noted = gpu_vulkan_rest_add(gpu, image);
		if (noted != STILB_OK)
			gpu_vulkan_image_free(base, image);
		return noted;
	}
	free(texels);
	if (result == VK_ERROR_FORMAT_NOT_SUPPORTED)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "image '%s': '%s' has no such image of format %s and %u samples, with these sizes and uses; "
		                  "make it smaller, or leave uses out",
		                  image->name, base->name, stilb_gpu_format_describe(image->extent.format)->name,
		                  image->extent.samples);
	char what[GPU_NAME + 32];
	snprintf(what, sizeof what, "make image '%s'", image->name);
	return gpu_vulkan_fail(gpu, result, what);
}

void gpu_vulkan_image_free(stilb_gpu *base, gpu_image *image)
{
	gpu_vulkan_texels_destroy((gpu_vulkan *)base, image->own);
	free(image->own);
	image->own = NULL;
}

/* ---- samplers ---------------------------------------------------------------------------------------------------- */

stilb_result gpu_vulkan_sampler_make(stilb_gpu *base, uint32_t index, const stilb_gpu_sampler_desc *desc)
{
	static const VkSamplerAddressMode wraps[] = {
		[STILB_GPU_WRAP_CLAMP] = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
		[STILB_GPU_WRAP_REPEAT] = VK_SAMPLER_ADDRESS_MODE_REPEAT,
		[STILB_GPU_WRAP_MIRROR] = VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT,
	};
	gpu_vulkan *gpu = (gpu_vulkan *)base;
	VkFilter filter = desc->linear ? VK_FILTER_LINEAR : VK_FILTER_NEAREST;
	VkSamplerCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
		.magFilter = filter,
		.minFilter = filter,
		.mipmapMode = desc->mip_linear ? VK_SAMPLER_MIPMAP_MODE_LINEAR : VK_SAMPLER_MIPMAP_MODE_NEAREST,
		.addressModeU = wraps[desc->wrap[0]],
		.addressModeV = wraps[desc->wrap[1]],
		.addressModeW = wraps[desc->wrap[2]],
		.anisotropyEnable = desc->anisotropy > 1.0f,
		.maxAnisotropy = desc->anisotropy,
		.compareEnable = desc->compare != 0,
		.compareOp = VK_COMPARE_OP_GREATER_OR_EQUAL, /* reference >= texel: reversed depth, the texel is not nearer */
		.maxLod = desc->mips ? VK_LOD_CLAMP_NONE : 0.0f,
	};
	VkResult result = vkCreateSampler(gpu->device, &info, gpu->allocator, &gpu->samplers[index]);
	return result == VK_SUCCESS ? STILB_OK : gpu_vulkan_fail(gpu, result, "make a sampler");
}

/* ---- sets -------------------------------------------------------------------------------------------------------- */

typedef struct vulkan_set {
	VkDescriptorSet set;
	VkDescriptorPool pool;
} vulkan_set;

#define SET_POOL_SETS 256u

VkResult gpu_vulkan_set_layout(gpu_vulkan *gpu, uint32_t count)
{
	VkDescriptorSetLayoutBinding bindings[STILB_GPU_MAX_SET_ITEMS];
	if (gpu->item_layouts[count])
		return VK_SUCCESS;
	for (uint32_t i = 0; i < count; i++)
		bindings[i] = (VkDescriptorSetLayoutBinding){
			.binding = i,
			.descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
			.descriptorCount = 1,
			.stageFlags = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT,
		};
	VkDescriptorSetLayoutCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
		.bindingCount = count,
		.pBindings = bindings,
	};
	return vkCreateDescriptorSetLayout(gpu->device, &info, gpu->allocator, &gpu->item_layouts[count]);
}

static VkResult set_pool_add(gpu_vulkan *gpu)
{
	uint32_t shift = gpu->item_pool_count < 8 ? gpu->item_pool_count : 8;
	VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, (SET_POOL_SETS << shift) * 4};
	VkDescriptorPoolCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
		.flags = VK_DESCRIPTOR_POOL_CREATE_FREE_DESCRIPTOR_SET_BIT,
		.maxSets = SET_POOL_SETS << shift,
		.poolSizeCount = 1,
		.pPoolSizes = &size,
	};
	if (gpu->item_pool_count == GPU_VULKAN_POOLS)
		return VK_ERROR_OUT_OF_POOL_MEMORY;
	VkResult result =
		vkCreateDescriptorPool(gpu->device, &info, gpu->allocator, &gpu->item_pools[gpu->item_pool_count]);
	gpu->item_pool_count += result == VK_SUCCESS;
	return result;
}

/* A set from one of the pools, or from a new one. The caller holds the lock. */
static VkResult set_allocate(gpu_vulkan *gpu, uint32_t count, vulkan_set *set)
{
	VkResult result = gpu_vulkan_set_layout(gpu, count);
	for (uint32_t p = gpu->item_pool_count; result == VK_SUCCESS; p--) {
		if (p == 0) {
			result = set_pool_add(gpu);
			p = gpu->item_pool_count;
		}
		if (result != VK_SUCCESS)
			break;
		VkDescriptorSetAllocateInfo info = {
			.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
			.descriptorPool = gpu->item_pools[p - 1],
			.descriptorSetCount = 1,
			.pSetLayouts = &gpu->item_layouts[count],
		};
		VkResult allocated = vkAllocateDescriptorSets(gpu->device, &info, &set->set);
		set->pool = info.descriptorPool;
		if (allocated == VK_SUCCESS)
			return VK_SUCCESS;
		if (allocated != VK_ERROR_OUT_OF_POOL_MEMORY && allocated != VK_ERROR_FRAGMENTED_POOL)
			return allocated;
	}
	return result;
}

stilb_result gpu_vulkan_set_make(stilb_gpu *base, gpu_set *entry)
{
	gpu_vulkan *gpu = (gpu_vulkan *)base;
	vulkan_set *set = calloc(1, sizeof *set);
	VkDescriptorImageInfo images[STILB_GPU_MAX_SET_ITEMS];
	VkWriteDescriptorSet writes[STILB_GPU_MAX_SET_ITEMS];
	if (!set)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a set of images");
	VkResult result = VK_SUCCESS;
	for (uint32_t i = 0; i < entry->count && result == VK_SUCCESS; i++) {
		const stilb_gpu_set_item *item = &entry->items[i];
		gpu_vulkan_texels *texels = item->image.id ? gpu_image_of(base, item->image.id)->own : &gpu->white;
		stilb_gpu_range range = {0, (uint8_t)texels->extent.mips, 0, texels->extent.layers};
		if (item->seen == STILB_GPU_SEEN_LAYER && item->image.id)
			range = (stilb_gpu_range){0, range.mips, item->layer, 1};
		gpu_vulkan_seen seen = item->seen == STILB_GPU_SEEN_ARRAY ? GPU_VULKAN_ARRAY : GPU_VULKAN_SAMPLED;
		images[i] = (VkDescriptorImageInfo){
			.sampler = gpu->samplers[item->sampler.id],
			.imageView = gpu_vulkan_texels_view(gpu, texels, seen, range),
			.imageLayout = gpu_vulkan_layout(gpu_vulkan_rest(&texels->extent)),
		};
		result = images[i].imageView ? VK_SUCCESS : VK_ERROR_OUT_OF_HOST_MEMORY;
	}
	if (result == VK_SUCCESS) {
		stilb_lock_take(&gpu->views_lock);
		result = set_allocate(gpu, entry->count, set);
		stilb_lock_give(&gpu->views_lock);
	}
	if (result != VK_SUCCESS) {
		free(set);
		return gpu_vulkan_fail(gpu, result, "make a set of images");
	}
	for (uint32_t i = 0; i < entry->count; i++)
		writes[i] = (VkWriteDescriptorSet){
			.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
			.dstSet = set->set,
			.dstBinding = i,
			.descriptorCount = 1,
			.descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
			.pImageInfo = &images[i],
		};
	vkUpdateDescriptorSets(gpu->device, entry->count, writes, 0, NULL);
	entry->own = set;
	return STILB_OK;
}

void gpu_vulkan_set_free(stilb_gpu *base, gpu_set *entry)
{
	gpu_vulkan *gpu = (gpu_vulkan *)base;
	vulkan_set *set = entry->own;
	stilb_lock_take(&gpu->views_lock);
	vkFreeDescriptorSets(gpu->device, set->pool, 1, &set->set);
	stilb_lock_give(&gpu->views_lock);
	free(set);
}

VkDescriptorSet gpu_vulkan_set_handle(const gpu_set *entry)
{
	return ((const vulkan_set *)entry->own)->set;
}
