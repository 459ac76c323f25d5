/* The plain Vulkan program's last pass: from linear light in half floats to the picture, by the engine's tone map. */
#include "bench/subjects/vulkan_bare.h"

/* The engine's shaders, compiled to SPIR-V by its build. */
static const uint32_t tone_vertex_code[] =
#include "fullscreen.vert.inc"
	;
static const uint32_t tone_fragment_code[] =
#include "tone.frag.inc"
	;

/* What the fragment shader is given: no exposure. */
typedef struct tone_push {
	float exposure;
	uint32_t dither;
} tone_push;

static void make_set(bare *b)
{
	VkDescriptorSetLayoutBinding binding = {
		.descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
		.descriptorCount = 1,
		.stageFlags = VK_SHADER_STAGE_FRAGMENT_BIT,
	};
	VkDescriptorSetLayoutCreateInfo layout = {
		.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
		.bindingCount = 1,
		.pBindings = &binding,
	};
	bare_check(vkCreateDescriptorSetLayout(b->device, &layout, NULL, &b->tone.set_layout),
	           "vkCreateDescriptorSetLayout");
	VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1};
	VkDescriptorPoolCreateInfo pool = {
		.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
		.maxSets = 1,
		.poolSizeCount = 1,
		.pPoolSizes = &size,
	};
	bare_check(vkCreateDescriptorPool(b->device, &pool, NULL, &b->tone.pool), "vkCreateDescriptorPool");
	VkDescriptorSetAllocateInfo set = {
		.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
		.descriptorPool = b->tone.pool,
		.descriptorSetCount = 1,
		.pSetLayouts = &b->tone.set_layout,
	};
	bare_check(vkAllocateDescriptorSets(b->device, &set, &b->tone.set), "vkAllocateDescriptorSets");
	VkSamplerCreateInfo nearest = {
		.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
		.addressModeU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
		.addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
	};
	bare_check(vkCreateSampler(b->device, &nearest, NULL, &b->tone.sampler), "vkCreateSampler");
	VkDescriptorImageInfo image = {
		.sampler = b->tone.sampler, .imageView = b->light.view, .imageLayout = VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL};
	VkWriteDescriptorSet write = {
		.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
		.dstSet = b->tone.set,
		.descriptorCount = 1,
		.descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
		.pImageInfo = &image,
	};
	vkUpdateDescriptorSets(b->device, 1, &write, 0, NULL);
}

void bare_tone_make(bare *b, uint32_t width, uint32_t height)
{
	make_set(b);
	VkPushConstantRange range = {.stageFlags = VK_SHADER_STAGE_FRAGMENT_BIT, .size = sizeof(tone_push)};
	VkPipelineLayoutCreateInfo layout = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
		.setLayoutCount = 1,
		.pSetLayouts = &b->tone.set_layout,
		.pushConstantRangeCount = 1,
		.pPushConstantRanges = &range,
	};
	bare_check(vkCreatePipelineLayout(b->device, &layout, NULL, &b->tone.layout), "vkCreatePipelineLayout");
	bare_program program = {.codes = {tone_vertex_code, tone_fragment_code},
	                        .sizes = {sizeof tone_vertex_code, sizeof tone_fragment_code},
	                        .format = VK_FORMAT_R8G8B8A8_SRGB,
	                        .layout = b->tone.layout,
	                        .width = width,
	                        .height = height};
	b->tone.pipeline = bare_make_pipeline(b, &program);
}

void bare_tone_draw(const bare *b, VkCommandBuffer commands)
{
	tone_push push = {1.0f, b->dither};
	vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, b->tone.pipeline);
	vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, b->tone.layout, 0, 1, &b->tone.set, 0, NULL);
	vkCmdPushConstants(commands, b->tone.layout, VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof push, &push);
	vkCmdDraw(commands, 3, 1, 0, 0);
}

void bare_tone_free(bare *b)
{
	vkDestroyPipeline(b->device, b->tone.pipeline, NULL);
	vkDestroyPipelineLayout(b->device, b->tone.layout, NULL);
	vkDestroyDescriptorPool(b->device, b->tone.pool, NULL);
	vkDestroySampler(b->device, b->tone.sampler, NULL);
	vkDestroyDescriptorSetLayout(b->device, b->tone.set_layout, NULL);
}
