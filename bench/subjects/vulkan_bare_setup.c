/* The plain Vulkan program's meshes, pipeline and frames. */
#include "bench/subjects/vulkan_bare.h"

#include "bench/record/record_child.h"

/* The engine's shaders, compiled to SPIR-V by its build. */
static const uint32_t vertex_code[] =
#include "mesh.vert.inc"
	;
static const uint32_t fragment_code[] =
#include "mesh_alone.frag.inc"
	;

/* ---- the scene's buffers ----------------------------------------------------------------------------------------- */

static void make_meshes(bare *b, const stilb_scene *scene)
{
	uint32_t vertices = 0, indices = 0;
	b->meshes = record_alloc(scene->mesh_count, sizeof *b->meshes);
	for (uint32_t i = 0; i < scene->mesh_count; i++) {
		b->meshes[i] = (bare_mesh){scene->meshes[i].index_count, indices, (int32_t)vertices};
		vertices += scene->meshes[i].vertex_count;
		indices += scene->meshes[i].index_count;
	}
	b->vertices = bare_make_buffer(b, vertices * sizeof(stilb_scene_vertex), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
	b->indices = bare_make_buffer(b, indices * sizeof(uint32_t), VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
	for (uint32_t i = 0; i < scene->mesh_count; i++) {
		const stilb_scene_mesh *mesh = &scene->meshes[i];
		memcpy((stilb_scene_vertex *)b->vertices.mapped + b->meshes[i].vertex_offset, mesh->vertices,
		       mesh->vertex_count * sizeof *mesh->vertices);
		memcpy((uint32_t *)b->indices.mapped + b->meshes[i].first_index, mesh->indices,
		       mesh->index_count * sizeof *mesh->indices);
	}
}

#define SHADER_BUFFER (VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT)

static void make_materials(bare *b, const stilb_scene *scene)
{
	b->materials = bare_make_buffer(b, scene->material_count * sizeof(bare_material), SHADER_BUFFER);
	bare_material *out = b->materials.mapped;
	for (uint32_t i = 0; i < scene->material_count; i++) {
		const stilb_scene_material *in = &scene->materials[i];
		out[i] = (bare_material){.roughness = in->roughness, .anisotropy = in->anisotropy, .wrap = in->wrap};
		memcpy(out[i].diffuse, in->diffuse, sizeof in->diffuse);
		memcpy(out[i].specular, in->specular, sizeof in->specular);
	}
}

/* ---- pipeline ---------------------------------------------------------------------------------------------------- */

static VkShaderModule make_shader(const bare *b, const uint32_t *code, size_t size)
{
	VkShaderModuleCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
		.codeSize = size,
		.pCode = code,
	};
	VkShaderModule made;
	bare_check(vkCreateShaderModule(b->device, &info, NULL, &made), "vkCreateShaderModule");
	return made;
}

static void make_layout(bare *b)
{
	VkPushConstantRange range = {
		.stageFlags = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT,
		.size = sizeof(bare_push),
	};
	VkPipelineLayoutCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
		.pushConstantRangeCount = 1,
		.pPushConstantRanges = &range,
	};
	bare_check(vkCreatePipelineLayout(b->device, &info, NULL, &b->layout), "vkCreatePipelineLayout");
}

/* With a fixed viewport. */
VkPipeline bare_make_pipeline(const bare *b, const bare_program *program)
{
	const VkPipelineShaderStageCreateInfo stages[2] = {
		{.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
	     .stage = VK_SHADER_STAGE_VERTEX_BIT,
	     .module = make_shader(b, program->codes[0], program->sizes[0]),
	     .pName = "main"},
		{.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
	     .stage = VK_SHADER_STAGE_FRAGMENT_BIT,
	     .module = make_shader(b, program->codes[1], program->sizes[1]),
	     .pName = "main"},
	};
	static const bare_vertices none = {0};
	bool has_vertices = program->vertices;
	const bare_vertices *vertices = has_vertices ? program->vertices : &none;
	VkPipelineVertexInputStateCreateInfo vertex_input = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
		.vertexBindingDescriptionCount = vertices->binding_count,
		.pVertexBindingDescriptions = vertices->bindings,
		.vertexAttributeDescriptionCount = vertices->attribute_count,
		.pVertexAttributeDescriptions = vertices->attributes,
	};
	VkPipelineInputAssemblyStateCreateInfo assembly = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
		.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
	};
	VkRect2D area = {.extent = {program->width, program->height}};
	VkViewport whole = {.width = (float)program->width, .height = (float)program->height, .maxDepth = 1.0f};
	VkPipelineViewportStateCreateInfo viewport = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
		.viewportCount = 1,
		.pViewports = &whole,
		.scissorCount = 1,
		.pScissors = &area,
	};
	VkPipelineRasterizationStateCreateInfo rasterization = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
		.cullMode = has_vertices ? VK_CULL_MODE_BACK_BIT : VK_CULL_MODE_NONE,
		.frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE,
		.lineWidth = 1.0f,
	};
	VkPipelineMultisampleStateCreateInfo multisample = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
		.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT,
	};
	VkPipelineDepthStencilStateCreateInfo depth = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
		.depthTestEnable = has_vertices,
		.depthWriteEnable = has_vertices,
		.depthCompareOp = VK_COMPARE_OP_GREATER, /* reversed depth: near is 1 */
	};
	VkPipelineColorBlendAttachmentState no_blending = {.colorWriteMask = 0xf};
	VkPipelineColorBlendStateCreateInfo blend = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
		.attachmentCount = 1,
		.pAttachments = &no_blending,
	};
	VkPipelineRenderingCreateInfo rendering = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
		.colorAttachmentCount = 1,
		.pColorAttachmentFormats = &program->format,
		.depthAttachmentFormat = has_vertices ? VK_FORMAT_D32_SFLOAT : VK_FORMAT_UNDEFINED,
	};
	VkGraphicsPipelineCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
		.pNext = &rendering,
		.stageCount = 2,
		.pStages = stages,
		.pVertexInputState = &vertex_input,
		.pInputAssemblyState = &assembly,
		.pViewportState = &viewport,
		.pRasterizationState = &rasterization,
		.pMultisampleState = &multisample,
		.pDepthStencilState = &depth,
		.pColorBlendState = &blend,
		.layout = program->layout,
	};
	VkPipeline made;
	bare_check(vkCreateGraphicsPipelines(b->device, VK_NULL_HANDLE, 1, &info, NULL, &made),
	           "vkCreateGraphicsPipelines");
	vkDestroyShaderModule(b->device, stages[0].module, NULL);
	vkDestroyShaderModule(b->device, stages[1].module, NULL);
	return made;
}

static void make_pipeline(bare *b, uint32_t width, uint32_t height)
{
	static const VkVertexInputBindingDescription binding = {.stride = sizeof(stilb_scene_vertex)};
	static const VkVertexInputAttributeDescription attributes[2] = {
		{.location = 0, .format = VK_FORMAT_R32G32B32_SFLOAT, .offset = offsetof(stilb_scene_vertex, position)},
		{.location = 1, .format = VK_FORMAT_R32G32B32_SFLOAT, .offset = offsetof(stilb_scene_vertex, normal)},
	};
	static const bare_vertices vertices = {1, 2, &binding, attributes};
	bare_program program = {.codes = {vertex_code, fragment_code},
	                        .sizes = {sizeof vertex_code, sizeof fragment_code},
	                        .vertices = &vertices,
	                        .format = VK_FORMAT_R16G16B16A16_SFLOAT,
	                        .layout = b->layout,
	                        .width = width,
	                        .height = height};
	b->pipeline = bare_make_pipeline(b, &program);
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

static void make_frame(bare *b, bare_frame *frame, uint32_t draws, uint32_t width, uint32_t height)
{
	VkCommandPoolCreateInfo pool = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
		.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT,
	};
	bare_check(vkCreateCommandPool(b->device, &pool, NULL, &frame->pool), "vkCreateCommandPool");
	VkCommandBufferAllocateInfo commands = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
		.commandPool = frame->pool,
		.commandBufferCount = 1,
	};
	bare_check(vkAllocateCommandBuffers(b->device, &commands, &frame->commands), "vkAllocateCommandBuffers");
	VkFenceCreateInfo fence = {
		.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO,
		.flags = VK_FENCE_CREATE_SIGNALED_BIT, /* signaled, so that the first frame does not wait */
	};
	bare_check(vkCreateFence(b->device, &fence, NULL, &frame->done), "vkCreateFence");
	frame->rows = bare_make_buffer(b, draws * sizeof(bare_row), SHADER_BUFFER);
	frame->indirect =
		bare_make_buffer(b, draws * sizeof(VkDrawIndexedIndirectCommand), VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT);
	frame->view = bare_make_buffer(b, sizeof(bare_view), SHADER_BUFFER);
	frame->picture = bare_make_buffer(b, (VkDeviceSize)width * height * 4, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
}

static void free_frame(bare *b, bare_frame *frame)
{
	vkDestroyCommandPool(b->device, frame->pool, NULL);
	vkDestroyFence(b->device, frame->done, NULL);
	bare_free_buffer(b, &frame->rows);
	bare_free_buffer(b, &frame->indirect);
	bare_free_buffer(b, &frame->view);
	bare_free_buffer(b, &frame->picture);
}

void bare_prepare(bare *b, const stilb_scene *scene, uint32_t width, uint32_t height)
{
	b->width = width;
	b->height = height;
	make_meshes(b, scene);
	make_materials(b, scene);
	b->color = bare_make_image(b, width, height, VK_FORMAT_R8G8B8A8_SRGB,
	                           VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
	                           VK_IMAGE_ASPECT_COLOR_BIT);
	b->light =
		bare_make_image(b, width, height, VK_FORMAT_R16G16B16A16_SFLOAT,
	                    VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT, VK_IMAGE_ASPECT_COLOR_BIT);
	b->depth = bare_make_image(b, width, height, VK_FORMAT_D32_SFLOAT, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT,
	                           VK_IMAGE_ASPECT_DEPTH_BIT);
	make_layout(b);
	make_pipeline(b, width, height);
	bare_tone_make(b, width, height);
	for (int i = 0; i < BARE_FRAMES; i++)
		make_frame(b, &b->frames[i], scene->part_count, width, height);
}

void bare_close(bare *b)
{
	vkDeviceWaitIdle(b->device);
	for (int i = 0; i < BARE_FRAMES; i++)
		free_frame(b, &b->frames[i]);
	bare_tone_free(b);
	bare_free_image(b, &b->light);
	bare_free_image(b, &b->color);
	bare_free_image(b, &b->depth);
	bare_free_buffer(b, &b->vertices);
	bare_free_buffer(b, &b->indices);
	bare_free_buffer(b, &b->materials);
	free(b->meshes);
	vkDestroyPipeline(b->device, b->pipeline, NULL);
	vkDestroyPipelineLayout(b->device, b->layout, NULL);
	vkDestroyDevice(b->device, NULL);
	vkDestroyInstance(b->instance, NULL);
}
