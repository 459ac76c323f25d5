#include "render/vulkan/vulkan_internal.h"

/* SPIR-V, made from shaders/ when Stilb is built. */
static const uint32_t mesh_vert[] =
#include "mesh.vert.inc"
	;
static const uint32_t mesh_frag[] =
#include "mesh.frag.inc"
	;

static VkResult shader_create(vulkan_device *device, const uint32_t *code, size_t size, VkShaderModule *module)
{
	VkShaderModuleCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
		.codeSize = size,
		.pCode = code,
	};
	return vkCreateShaderModule(device->device, &info, NULL, module);
}

static VkResult layout_create(vulkan_device *device)
{
	const VkPushConstantRange range = {
		.stageFlags = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT,
		.size = sizeof(vulkan_push),
	};
	const VkPipelineLayoutCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
		.pushConstantRangeCount = 1,
		.pPushConstantRanges = &range,
	};
	return vkCreatePipelineLayout(device->device, &info, NULL, &device->pipeline_layout);
}

/* ---- what every pipeline has, whatever the device ------------------------------------------------------------------- */

static const VkVertexInputBindingDescription vertex_binding = {.stride = sizeof(stilb_scene_vertex)};

static const VkVertexInputAttributeDescription vertex_attributes[2] = {
	{.location = 0, .format = VK_FORMAT_R32G32B32_SFLOAT, .offset = offsetof(stilb_scene_vertex, position)},
	{.location = 1, .format = VK_FORMAT_R32G32B32_SFLOAT, .offset = offsetof(stilb_scene_vertex, normal)},
};

static const VkPipelineVertexInputStateCreateInfo vertex_input = {
	.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
	.vertexBindingDescriptionCount = 1,
	.pVertexBindingDescriptions = &vertex_binding,
	.vertexAttributeDescriptionCount = 2,
	.pVertexAttributeDescriptions = vertex_attributes,
};

static const VkPipelineInputAssemblyStateCreateInfo input_assembly = {
	.sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
	.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
};

static const VkDynamicState dynamic_states[2] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};

static const VkPipelineDynamicStateCreateInfo dynamic = {
	.sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
	.dynamicStateCount = 2,
	.pDynamicStates = dynamic_states,
};

static const VkPipelineViewportStateCreateInfo viewport = {
	.sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
	.viewportCount = 1,
	.scissorCount = 1,
};

/* y points down in clip space and the projection flips it, so what is counter-clockwise in the world stays so. */
static const VkPipelineRasterizationStateCreateInfo rasterization = {
	.sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
	.polygonMode = VK_POLYGON_MODE_FILL,
	.cullMode = VK_CULL_MODE_BACK_BIT,
	.frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE,
	.lineWidth = 1.0f,
};

static const VkPipelineDepthStencilStateCreateInfo depth = {
	.sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
	.depthTestEnable = VK_TRUE,
	.depthWriteEnable = VK_TRUE,
	.depthCompareOp = VK_COMPARE_OP_GREATER, /* reversed: near is 1 */
};

static const VkPipelineColorBlendAttachmentState no_blending = {.colorWriteMask = 0xf};

static const VkPipelineColorBlendStateCreateInfo blend = {
	.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
	.attachmentCount = 1,
	.pAttachments = &no_blending,
};

/* ---- what depends on it --------------------------------------------------------------------------------------------- */

static VkPipelineShaderStageCreateInfo pipeline_stage(VkShaderStageFlagBits stage, VkShaderModule module,
                                                      const VkSpecializationInfo *constants)
{
	return (VkPipelineShaderStageCreateInfo){
		.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
		.stage = stage,
		.module = module,
		.pName = "main",
		.pSpecializationInfo = constants,
	};
}

static VkResult pipeline_create(vulkan_device *device, VkShaderModule vertex, VkShaderModule fragment)
{
	const VkBool32 tone_map = device->output == STILB_RENDER_OUTPUT_DISPLAY;
	const VkSpecializationMapEntry entry = {.constantID = 0, .size = sizeof tone_map};
	const VkSpecializationInfo constants = {1, &entry, sizeof tone_map, &tone_map};
	const VkPipelineShaderStageCreateInfo stages[2] = {
		pipeline_stage(VK_SHADER_STAGE_VERTEX_BIT, vertex, NULL),
		pipeline_stage(VK_SHADER_STAGE_FRAGMENT_BIT, fragment, &constants),
	};
	const VkPipelineMultisampleStateCreateInfo multisample = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
		.rasterizationSamples = (VkSampleCountFlagBits)device->base.samples,
	};
	const VkPipelineRenderingCreateInfo rendering = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
		.colorAttachmentCount = 1,
		.pColorAttachmentFormats = &device->color_format,
		.depthAttachmentFormat = VK_FORMAT_D32_SFLOAT,
	};
	const VkGraphicsPipelineCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
		.pNext = &rendering,
		.stageCount = 2,
		.pStages = stages,
		.pVertexInputState = &vertex_input,
		.pInputAssemblyState = &input_assembly,
		.pViewportState = &viewport,
		.pRasterizationState = &rasterization,
		.pMultisampleState = &multisample,
		.pDepthStencilState = &depth,
		.pColorBlendState = &blend,
		.pDynamicState = &dynamic,
		.layout = device->pipeline_layout,
	};
	return vkCreateGraphicsPipelines(device->device, VK_NULL_HANDLE, 1, &info, NULL, &device->pipeline);
}

stilb_result vulkan_pipeline_create(vulkan_device *device)
{
	VkShaderModule vertex = VK_NULL_HANDLE, fragment = VK_NULL_HANDLE;
	VkResult result = layout_create(device);
	if (result == VK_SUCCESS)
		result = shader_create(device, mesh_vert, sizeof mesh_vert, &vertex);
	if (result == VK_SUCCESS)
		result = shader_create(device, mesh_frag, sizeof mesh_frag, &fragment);
	if (result == VK_SUCCESS)
		result = pipeline_create(device, vertex, fragment);
	vkDestroyShaderModule(device->device, vertex, NULL);
	vkDestroyShaderModule(device->device, fragment, NULL);
	return result == VK_SUCCESS ? STILB_OK : vulkan_fail(result, "make the mesh pipeline");
}
