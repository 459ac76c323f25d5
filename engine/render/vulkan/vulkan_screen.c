/* What covers the whole picture: its area, and pipelines of one triangle over all of it. */
#include "render/vulkan/vulkan_internal.h"

void vulkan_screen_area(const vulkan_device *device, VkCommandBuffer commands)
{
	VkRect2D area = {.extent = {device->base.width, device->base.height}};
	VkViewport viewport = {
		.width = (float)device->base.width, .height = (float)device->base.height, .minDepth = 0.0f, .maxDepth = 1.0f};
	vkCmdSetViewport(commands, 0, 1, &viewport);
	vkCmdSetScissor(commands, 0, 1, &area);
}

/* ---- pipelines --------------------------------------------------------------------------------------------------- */

static const VkPipelineVertexInputStateCreateInfo no_vertices = {
	.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
};

static const VkPipelineInputAssemblyStateCreateInfo screen_triangle = {
	.sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
	.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
};

static const VkPipelineViewportStateCreateInfo screen_viewport = {
	.sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
	.viewportCount = 1,
	.scissorCount = 1,
};

static const VkPipelineRasterizationStateCreateInfo screen_rasterization = {
	.sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
	.cullMode = VK_CULL_MODE_NONE,
	.lineWidth = 1.0f,
};

static const VkPipelineDepthStencilStateCreateInfo no_depth = {
	.sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
};

static const VkPipelineColorBlendAttachmentState screen_channels = {.colorWriteMask = 0xf};

static const VkPipelineColorBlendStateCreateInfo screen_blend = {
	.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
	.attachmentCount = 1,
	.pAttachments = &screen_channels,
};

static const VkDynamicState screen_states[2] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};

static const VkPipelineDynamicStateCreateInfo screen_dynamic = {
	.sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
	.dynamicStateCount = 2,
	.pDynamicStates = screen_states,
};

static VkResult screen_pipeline(const vulkan_device *device, const vulkan_screen *screen,
                                const VkShaderModule modules[2], VkPipeline *pipeline)
{
	static const VkSpecializationMapEntry entries[2] = {{.constantID = 0, .offset = 0, .size = sizeof(uint32_t)},
	                                                    {.constantID = 1, .offset = 4, .size = sizeof(uint32_t)}};
	VkSpecializationInfo constants = {2, entries, sizeof screen->constants, screen->constants};
	VkPipelineShaderStageCreateInfo stages[2];
	for (int i = 0; i < 2; i++)
		stages[i] = (VkPipelineShaderStageCreateInfo){
			.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
			.stage = i == 0 ? VK_SHADER_STAGE_VERTEX_BIT : VK_SHADER_STAGE_FRAGMENT_BIT,
			.module = modules[i],
			.pName = "main",
			.pSpecializationInfo = i == 0 ? NULL : &constants,
		};
	VkPipelineMultisampleStateCreateInfo samples = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
		.rasterizationSamples = (VkSampleCountFlagBits)screen->samples,
	};
	VkPipelineRenderingCreateInfo rendering = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
		.colorAttachmentCount = 1,
		.pColorAttachmentFormats = &screen->format,
		.depthAttachmentFormat = screen->depth,
	};
	VkGraphicsPipelineCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
		.pNext = &rendering,
		.stageCount = 2,
		.pStages = stages,
		.pVertexInputState = &no_vertices,
		.pInputAssemblyState = &screen_triangle,
		.pViewportState = &screen_viewport,
		.pRasterizationState = &screen_rasterization,
		.pMultisampleState = &samples,
		.pDepthStencilState = &no_depth,
		.pColorBlendState = &screen_blend,
		.pDynamicState = &screen_dynamic,
		.layout = screen->layout,
	};
	return vkCreateGraphicsPipelines(device->gpu->device, VK_NULL_HANDLE, 1, &info, device->gpu->allocator, pipeline);
}

VkResult vulkan_screen_make(const vulkan_device *device, const vulkan_screen *screen, VkPipeline *pipeline)
{
	VkShaderModule modules[2] = {VK_NULL_HANDLE, VK_NULL_HANDLE};
	VkResult result = VK_SUCCESS;
	for (int i = 0; i < 2 && result == VK_SUCCESS; i++) {
		VkShaderModuleCreateInfo info = {
			.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
			.codeSize = i == 0 ? screen->vertex_bytes : screen->fragment_bytes,
			.pCode = i == 0 ? screen->vertex : screen->fragment,
		};
		result = vkCreateShaderModule(device->gpu->device, &info, device->gpu->allocator, &modules[i]);
	}
	if (result == VK_SUCCESS)
		result = screen_pipeline(device, screen, modules, pipeline);
	for (int i = 0; i < 2; i++)
		vkDestroyShaderModule(device->gpu->device, modules[i], device->gpu->allocator);
	return result;
}
