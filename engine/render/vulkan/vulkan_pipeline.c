/* Shaders, layouts and pipelines: for meshes one set of pipelines for each choice of formulas, for 2D passes three. */
#include "render/vulkan/vulkan_internal.h"

#include "shading/shade_brdf.h"

#include <stdlib.h>
#include <string.h>

/* SPIR-V that the build makes from shaders/. _texture: reads a texture; _bind: the material is in a descriptor set;
 * flat: for 2D passes. */
static const uint32_t mesh_vert[] =
#include "mesh.vert.inc"
	;
static const uint32_t mesh_texture_vert[] =
#include "mesh_texture.vert.inc"
	;
static const uint32_t mesh_packed_vert[] =
#include "mesh_packed.vert.inc"
	;
static const uint32_t mesh_packed_texture_vert[] =
#include "mesh_packed_texture.vert.inc"
	;
static const uint32_t mesh_frag[] =
#include "mesh.frag.inc"
	;
static const uint32_t mesh_texture_frag[] =
#include "mesh_texture.frag.inc"
	;
static const uint32_t mesh_bind_frag[] =
#include "mesh_bind.frag.inc"
	;
static const uint32_t mesh_bind_texture_frag[] =
#include "mesh_bind_texture.frag.inc"
	;

static const uint32_t impostor_vert[] =
#include "impostor.vert.inc"
	;
static const uint32_t impostor_packed_vert[] =
#include "impostor_packed.vert.inc"
	;
static const uint32_t impostor_frag[] =
#include "impostor.frag.inc"
	;
static const uint32_t impostor_bind_frag[] =
#include "impostor_bind.frag.inc"
	;

static const uint32_t flat_vert[] =
#include "flat.vert.inc"
	;
static const uint32_t flat_texture_vert[] =
#include "flat_texture.vert.inc"
	;
static const uint32_t flat_frag[] =
#include "flat.frag.inc"
	;
static const uint32_t flat_texture_frag[] =
#include "flat_texture.frag.inc"
	;
static const uint32_t flat_picture_vert[] =
#include "flat_picture.vert.inc"
	;
static const uint32_t flat_picture_frag[] =
#include "flat_picture.frag.inc"
	;

typedef struct pipeline_code {
	const uint32_t *words;
	size_t size;
} pipeline_code;

#define PIPELINE_CODE(words)                                                                                           \
	{                                                                                                                  \
		words, sizeof words                                                                                            \
	}

/* [1: vertices are packed] */
static const pipeline_code vertex_code[2][VULKAN_SURFACES] = {
	{
		[VULKAN_SURFACE_PLAIN] = PIPELINE_CODE(mesh_vert),
		[VULKAN_SURFACE_TEXTURE] = PIPELINE_CODE(mesh_texture_vert),
		[VULKAN_SURFACE_IMPOSTOR] = PIPELINE_CODE(impostor_vert),
	},
	{
		[VULKAN_SURFACE_PLAIN] = PIPELINE_CODE(mesh_packed_vert),
		[VULKAN_SURFACE_TEXTURE] = PIPELINE_CODE(mesh_packed_texture_vert),
		[VULKAN_SURFACE_IMPOSTOR] = PIPELINE_CODE(impostor_packed_vert),
	},
};

/* [1: the material is bound as a descriptor set] */
static const pipeline_code fragment_code[2][VULKAN_SURFACES] = {
	{
		[VULKAN_SURFACE_PLAIN] = PIPELINE_CODE(mesh_frag),
		[VULKAN_SURFACE_TEXTURE] = PIPELINE_CODE(mesh_texture_frag),
		[VULKAN_SURFACE_IMPOSTOR] = PIPELINE_CODE(impostor_frag),
	},
	{
		[VULKAN_SURFACE_PLAIN] = PIPELINE_CODE(mesh_bind_frag),
		[VULKAN_SURFACE_TEXTURE] = PIPELINE_CODE(mesh_bind_texture_frag),
		[VULKAN_SURFACE_IMPOSTOR] = PIPELINE_CODE(impostor_bind_frag),
	},
};

/* [a vulkan_pipeline_2d][0: vertex shader, 1: fragment shader] */
static const pipeline_code flat_code[VULKAN_PIPELINES_2D][2] = {
	[VULKAN_PIPELINE_2D_FLAT] = {PIPELINE_CODE(flat_vert), PIPELINE_CODE(flat_frag)},
	[VULKAN_PIPELINE_2D_TEXTURE] = {PIPELINE_CODE(flat_texture_vert), PIPELINE_CODE(flat_texture_frag)},
	[VULKAN_PIPELINE_2D_PICTURE] = {PIPELINE_CODE(flat_picture_vert), PIPELINE_CODE(flat_picture_frag)},
};

static VkResult shader_create(vulkan_device *device, pipeline_code code, VkShaderModule *module)
{
	VkShaderModuleCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
		.codeSize = code.size,
		.pCode = code.words,
	};
	return vkCreateShaderModule(device->gpu->device, &info, device->gpu->allocator, module);
}

/* ---- layout: set 0 is the texture, set 1 the material with --materials bind -------------------------------------- */

static VkResult set_layout_create(vulkan_device *device, VkDescriptorType type, const VkSampler *sampler,
                                  VkDescriptorSetLayout *layout)
{
	VkDescriptorSetLayoutBinding binding = {
		.descriptorType = type,
		.descriptorCount = 1,
		.stageFlags = VK_SHADER_STAGE_FRAGMENT_BIT,
		.pImmutableSamplers = sampler,
	};
	VkDescriptorSetLayoutCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
		.bindingCount = 1,
		.pBindings = &binding,
	};
	return vkCreateDescriptorSetLayout(device->gpu->device, &info, device->gpu->allocator, layout);
}

static VkResult layout_create(vulkan_device *device)
{
	VkResult result =
		set_layout_create(device, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, &device->sampler, &device->texture_layout);
	bool bind = device->base.materials == STILB_RENDER_MATERIALS_BIND;
	if (result == VK_SUCCESS && bind)
		result = set_layout_create(device, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER_DYNAMIC, NULL, &device->material_layout);
	if (result != VK_SUCCESS)
		return result;
	VkDescriptorSetLayout sets[2] = {device->texture_layout, device->material_layout};
	VkPushConstantRange range = {
		.stageFlags = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT,
		.size = sizeof(vulkan_push),
	};
	VkPipelineLayoutCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
		.setLayoutCount = bind ? 2 : 1,
		.pSetLayouts = sets,
		.pushConstantRangeCount = 1,
		.pPushConstantRanges = &range,
	};
	return vkCreatePipelineLayout(device->gpu->device, &info, device->gpu->allocator, &device->pipeline_layout);
}

/* ---- constant state of mesh pipelines --------------------------------------------------------------------------- */

/* What a pipeline reads of vertices: attribute number s is stream number s of the table. */
typedef struct vertex_input {
	VkVertexInputBindingDescription binding;
	VkVertexInputAttributeDescription attributes[STILB_SCENE_MOST_STREAMS];
	VkPipelineVertexInputStateCreateInfo info;
} vertex_input;

static void vertex_input_make(const render_layout *layout, vulkan_surface surface, vertex_input *input)
{
	static const VkFormat floats[] = {0, VK_FORMAT_R32_SFLOAT, VK_FORMAT_R32G32_SFLOAT, VK_FORMAT_R32G32B32_SFLOAT,
	                                  VK_FORMAT_R32G32B32A32_SFLOAT};
	/* Kinds of streams that no shader of a surface reads: fetching them costs a CPU time. */
	static const uint32_t unread[VULKAN_SURFACES] = {
		[VULKAN_SURFACE_PLAIN] = 1u << STILB_SCENE_STREAM_TEXTURE,
		[VULKAN_SURFACE_IMPOSTOR] = 1u << STILB_SCENE_STREAM_DIRECTION,
	};
	uint32_t count = 0;
	for (uint32_t s = 0; s < layout->count; s++) {
		const render_attribute *a = &layout->attributes[s];
		if (unread[surface] >> a->kind & 1u)
			continue;
		input->attributes[count++] = (VkVertexInputAttributeDescription){
			.location = s, .format = a->octahedral ? VK_FORMAT_R32_UINT : floats[a->components], .offset = a->to};
	}
	input->binding = (VkVertexInputBindingDescription){.stride = layout->size};
	input->info = (VkPipelineVertexInputStateCreateInfo){
		.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
		.vertexBindingDescriptionCount = 1,
		.pVertexBindingDescriptions = &input->binding,
		.vertexAttributeDescriptionCount = count,
		.pVertexAttributeDescriptions = input->attributes,
	};
}

static const VkPipelineInputAssemblyStateCreateInfo triangle_list = {
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

/* Clip space has y down and the projection flips it, so triangles that are counter-clockwise in the world stay so. */
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

/* ---- constant state of 2D pipelines ------------------------------------------------------------------------------ */

static const VkVertexInputBindingDescription flat_binding = {.stride = sizeof(stilb_render_vertex_2d)};

static const VkVertexInputAttributeDescription flat_attributes[3] = {
	{.location = 0, .format = VK_FORMAT_R32G32_SFLOAT, .offset = offsetof(stilb_render_vertex_2d, position)},
	{.location = 1, .format = VK_FORMAT_R8G8B8A8_UNORM, .offset = offsetof(stilb_render_vertex_2d, color)},
	{.location = 2, .format = VK_FORMAT_R32G32_SFLOAT, .offset = offsetof(stilb_render_vertex_2d, uv)},
};

/* [0] without and [1] with a texture. */
static const VkPipelineVertexInputStateCreateInfo flat_input[2] = {
	{
		.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
		.vertexBindingDescriptionCount = 1,
		.pVertexBindingDescriptions = &flat_binding,
		.vertexAttributeDescriptionCount = 2,
		.pVertexAttributeDescriptions = flat_attributes,
	},
	{
		.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
		.vertexBindingDescriptionCount = 1,
		.pVertexBindingDescriptions = &flat_binding,
		.vertexAttributeDescriptionCount = 3,
		.pVertexAttributeDescriptions = flat_attributes,
	},
};

static const VkPipelineRasterizationStateCreateInfo flat_rasterization = {
	.sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
	.polygonMode = VK_POLYGON_MODE_FILL,
	.cullMode = VK_CULL_MODE_NONE,
	.lineWidth = 1.0f,
};

static const VkPipelineMultisampleStateCreateInfo flat_samples = {
	.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
	.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT,
};

/* The operator "over" with premultiplied alpha; the picture stays opaque. */
static const VkPipelineColorBlendAttachmentState over = {
	.blendEnable = VK_TRUE,
	.srcColorBlendFactor = VK_BLEND_FACTOR_ONE,
	.dstColorBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA,
	.colorBlendOp = VK_BLEND_OP_ADD,
	.srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE,
	.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA,
	.alphaBlendOp = VK_BLEND_OP_ADD,
	.colorWriteMask = 0xf,
};

static const VkPipelineColorBlendStateCreateInfo flat_blend = {
	.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
	.attachmentCount = 1,
	.pAttachments = &over,
};

/* ---- mesh pipelines ---------------------------------------------------------------------------------------------- */

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

/* Which of a choice's pipelines. */
typedef struct pipeline_variant {
	uint32_t detail; /* render_state_detail */
	vulkan_surface surface;
	vulkan_pipeline_materials materials;
} pipeline_variant;

/* Values of the mesh shaders' specialization constants; the vertex shader has `detail` alone. */
typedef struct pipeline_constants {
	uint32_t materials; /* a vulkan_pipeline_materials */
	uint32_t detail;    /* a pipeline_variant's */
	uint32_t samples;   /* of a pixel */
	uint32_t formulas[VULKAN_FORMULAS];
} pipeline_constants;

/* Constants 2, 3, ...: the formulas. */
#define PIPELINE_FORMULA(index)                                                                                        \
	{                                                                                                                  \
		2 + (index), offsetof(pipeline_constants, formulas) + (index) * sizeof(uint32_t), sizeof(uint32_t)             \
	}

static const VkSpecializationMapEntry pipeline_constant_map[3 + VULKAN_FORMULAS] = {
	{.constantID = 8, .offset = offsetof(pipeline_constants, samples), .size = sizeof(uint32_t)},
	{.constantID = 7, .offset = offsetof(pipeline_constants, detail), .size = sizeof(uint32_t)},
	{.constantID = 1, .offset = offsetof(pipeline_constants, materials), .size = sizeof(uint32_t)},
	PIPELINE_FORMULA(VULKAN_FORMULA_BRDF),
	PIPELINE_FORMULA(VULKAN_FORMULA_NDF),
	PIPELINE_FORMULA(VULKAN_FORMULA_G),
	PIPELINE_FORMULA(VULKAN_FORMULA_F),
	PIPELINE_FORMULA(VULKAN_FORMULA_LIGHTS),
};

/* A mesh pipeline. */
typedef struct pipeline_wanted {
	const uint32_t *formulas; /* [VULKAN_FORMULAS] */
	pipeline_variant variant;
} pipeline_wanted;

static VkResult pipeline_make(void *user, const void *what, VkPipeline *pipeline)
{
	vulkan_device *device = user;
	const pipeline_wanted *wanted = what;
	const uint32_t *formulas = wanted->formulas;
	pipeline_variant variant = wanted->variant;
	const VkShaderModule *modules = device->mesh_modules[variant.surface];
	STILB_ASSERT(modules[0] && modules[1]);
	vertex_input input;
	vertex_input_make(&device->layout, variant.surface, &input);
	pipeline_constants constants = {
		.materials = variant.materials, .detail = variant.detail, .samples = device->base.samples};
	memcpy(constants.formulas, formulas, VULKAN_FORMULAS * sizeof *formulas);
	VkSpecializationInfo specialization = {3 + VULKAN_FORMULAS, pipeline_constant_map, sizeof constants, &constants};
	VkPipelineShaderStageCreateInfo stages[2] = {
		pipeline_stage(VK_SHADER_STAGE_VERTEX_BIT, modules[0], &specialization),
		pipeline_stage(VK_SHADER_STAGE_FRAGMENT_BIT, modules[1], &specialization),
	};
	VkPipelineRasterizationStateCreateInfo sides = rasterization;
	if ((formulas[VULKAN_FORMULA_LIGHTS] & RENDER_LIGHTS_SIDES) != 0 || variant.surface == VULKAN_SURFACE_IMPOSTOR)
		sides.cullMode = VK_CULL_MODE_NONE;
	VkPipelineMultisampleStateCreateInfo multisample = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
		.rasterizationSamples = (VkSampleCountFlagBits)device->base.samples,
	};
	VkFormat light = VULKAN_LIGHT_FORMAT;
	VkPipelineRenderingCreateInfo rendering = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
		.colorAttachmentCount = 1,
		.pColorAttachmentFormats = &light,
		.depthAttachmentFormat = VK_FORMAT_D32_SFLOAT,
	};
	VkGraphicsPipelineCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
		.pNext = &rendering,
		.stageCount = 2,
		.pStages = stages,
		.pVertexInputState = &input.info,
		.pInputAssemblyState = &triangle_list,
		.pViewportState = &viewport,
		.pRasterizationState = &sides,
		.pMultisampleState = &multisample,
		.pDepthStencilState = &depth,
		.pColorBlendState = &blend,
		.pDynamicState = &dynamic,
		.layout = device->pipeline_layout,
	};
	return vkCreateGraphicsPipelines(device->gpu->device, VK_NULL_HANDLE, 1, &info, device->gpu->allocator, pipeline);
}

static VkResult mesh_modules_make(vulkan_device *device, vulkan_surface surface)
{
	bool bind = device->base.materials == STILB_RENDER_MATERIALS_BIND;
	VkResult result = shader_create(device, vertex_code[device->packed][surface], &device->mesh_modules[surface][0]);
	return result == VK_SUCCESS ? shader_create(device, fragment_code[bind][surface], &device->mesh_modules[surface][1])
	                            : result;
}

/* ---- one set of mesh pipelines for each choice of formulas ------------------------------------------------------- */

static VkResult shading_make_one(vulkan_device *device, vulkan_shading *shading, pipeline_variant variant)
{
	pipeline_wanted wanted = {shading->formulas, variant};
	return gpu_vulkan_pipeline_once(device->gpu,
	                                &shading->pipelines[variant.detail][variant.surface][variant.materials],
	                                pipeline_make, device, &wanted);
}

/* Makes the pipelines that device->base.materials needs and that do not exist yet. */
static VkResult shading_make(vulkan_device *device, vulkan_shading *shading, uint32_t detail, vulkan_surface surface)
{
	if (device->base.materials != STILB_RENDER_MATERIALS_PIPELINE)
		return shading_make_one(device, shading, (pipeline_variant){detail, surface, VULKAN_PIPELINE_ANY});
	VkResult result = shading_make_one(device, shading, (pipeline_variant){detail, surface, VULKAN_PIPELINE_EVEN});
	return result == VK_SUCCESS
	           ? shading_make_one(device, shading, (pipeline_variant){detail, surface, VULKAN_PIPELINE_ODD})
	           : result;
}

/* A new entry for these formulas, without pipelines; NULL: no memory. */
static vulkan_shading *shading_add(vulkan_device *device, const uint32_t formulas[VULKAN_FORMULAS])
{
	if (!render_reserve((void **)&device->shadings, &device->shading_capacity, device->shading_count + 1,
	                    sizeof *device->shadings))
		return NULL;
	vulkan_shading *shading = calloc(1, sizeof *shading);
	if (!shading)
		return NULL;
	memcpy(shading->formulas, formulas, sizeof shading->formulas);
	device->shadings[device->shading_count++] = shading;
	return shading;
}

/* The entry for these formulas, which may be a new one; it never moves. NULL: no memory. [any-thread] */
static vulkan_shading *shading_find(vulkan_device *device, const uint32_t formulas[VULKAN_FORMULAS])
{
	vulkan_shading *found = NULL;
	pthread_mutex_lock(&device->gpu->pipelines_lock);
	for (uint32_t s = 0; s < device->shading_count && !found; s++)
		if (memcmp(device->shadings[s]->formulas, formulas, sizeof device->shadings[s]->formulas) == 0)
			found = device->shadings[s];
	if (!found)
		found = shading_add(device, formulas);
	pthread_mutex_unlock(&device->gpu->pipelines_lock);
	return found;
}

static void shading_destroy(const vulkan_device *device, vulkan_shading *shading)
{
	const gpu_vulkan_pipeline *pipelines = &shading->pipelines[0][0][0];
	for (size_t p = 0; p < sizeof shading->pipelines / sizeof *pipelines; p++)
		vkDestroyPipeline(device->gpu->device, pipelines[p].handle, device->gpu->allocator);
	free(shading);
}

/* The entry for what a view needs, with its pipelines of these kinds (render_stream.kinds) and surfaces, 1 <<
 * vulkan_surface each. [any-thread] */
static stilb_result shading_ready(vulkan_device *device, const stilb_render_shading *wanted, uint32_t light_bits,
                                  uint32_t kinds, uint32_t surfaces, vulkan_shading **ready)
{
	bool microfacet = wanted->brdf == SHADE_BRDF_MICROFACET; /* other models do not depend on D, G and F */
	STILB_ASSERT(wanted->brdf < SHADE_BRDF_COUNT);
	STILB_ASSERT(!microfacet ||
	             (wanted->ndf < SHADE_NDF_COUNT && wanted->g < SHADE_G_COUNT && wanted->f < SHADE_F_COUNT));
	uint32_t formulas[VULKAN_FORMULAS] = {
		[VULKAN_FORMULA_BRDF] = wanted->brdf,
		[VULKAN_FORMULA_NDF] = microfacet ? wanted->ndf : 0,
		[VULKAN_FORMULA_G] = microfacet ? wanted->g : 0,
		[VULKAN_FORMULA_F] = microfacet ? wanted->f : 0,
		[VULKAN_FORMULA_LIGHTS] = light_bits,
	};
	*ready = shading_find(device, formulas);
	if (!*ready)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for another kind of shading");
	VkResult result = VK_SUCCESS;
	for (uint32_t v = 0; v < VULKAN_SURFACES * RENDER_DETAIL_KINDS && result == VK_SUCCESS; v++)
		if ((kinds >> v / VULKAN_SURFACES & 1u) != 0 && (surfaces >> v % VULKAN_SURFACES & 1u) != 0)
			result = shading_make(device, *ready, v / VULKAN_SURFACES, (vulkan_surface)(v % VULKAN_SURFACES));
	return result == VK_SUCCESS ? STILB_OK : gpu_vulkan_fail(device->gpu, result, "make the mesh pipelines");
}

stilb_result vulkan_pipeline_choose(vulkan_device *device, const render_stream *stream)
{
	vulkan_shading *shading = NULL;
	uint32_t surfaces = 1u << VULKAN_SURFACE_PLAIN;
	if (render_state_texture(stream->states) != 0)
		surfaces |= 1u << VULKAN_SURFACE_TEXTURE;
	if (stream->states & RENDER_STATE_IMPOSTOR)
		surfaces |= 1u << VULKAN_SURFACE_IMPOSTOR;
	stilb_result result =
		shading_ready(device, &stream->view->shading, stream->light_bits, stream->kinds, surfaces, &shading);
	if (shading)
		device->shading = shading;
	return result;
}

stilb_result vulkan_prepare(render_device *base, const stilb_render_view *view, uint32_t light_bits)
{
	vulkan_device *device = (vulkan_device *)base;
	vulkan_shading *shading;
	uint32_t kinds = render_view_kinds(view), surfaces = 1u << VULKAN_SURFACE_PLAIN | 1u << VULKAN_SURFACE_TEXTURE;
	bool drawn = view->impostors && view->detail.mode != STILB_RENDER_DETAIL_OFF;
	if (drawn && view->show != STILB_RENDER_SHOW_LEVELS && view->detail.mode != STILB_RENDER_DETAIL_POP)
		kinds |= 1u << render_state_detail(RENDER_STATE_FADE); /* also models that morph fade to their impostor */
	surfaces |= drawn ? 1u << VULKAN_SURFACE_IMPOSTOR : 0;
	stilb_result result = shading_ready(device, &view->shading, light_bits, kinds, surfaces, &shading);
	bool nothing = view->backdrop.kind == STILB_SCENE_BACKDROP_NOTHING;
	if (result == STILB_OK && !nothing)
		result = vulkan_backdrop_make(device);
	return result == STILB_OK ? vulkan_tone_make(device, view->tone) : result;
}

static VkResult pipeline_make_2d(vulkan_device *device, const VkShaderModule modules[2], vulkan_pipeline_2d kind)
{
	bool picture = kind == VULKAN_PIPELINE_2D_PICTURE;
	VkBool32 tone_map = device->output == STILB_RENDER_OUTPUT_DISPLAY;
	VkSpecializationMapEntry entry = {.constantID = 0, .offset = 0, .size = sizeof tone_map};
	VkSpecializationInfo constants = {1, &entry, sizeof tone_map, &tone_map};
	VkPipelineShaderStageCreateInfo stages[2] = {
		pipeline_stage(VK_SHADER_STAGE_VERTEX_BIT, modules[0], NULL),
		pipeline_stage(VK_SHADER_STAGE_FRAGMENT_BIT, modules[1], picture ? &constants : NULL),
	};
	VkPipelineRenderingCreateInfo rendering = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
		.colorAttachmentCount = 1,
		.pColorAttachmentFormats = &device->color_format,
	};
	VkGraphicsPipelineCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
		.pNext = &rendering,
		.stageCount = 2,
		.pStages = stages,
		.pVertexInputState = &flat_input[kind != VULKAN_PIPELINE_2D_FLAT],
		.pInputAssemblyState = &triangle_list,
		.pViewportState = &viewport,
		.pRasterizationState = &flat_rasterization,
		.pMultisampleState = &flat_samples,
		.pColorBlendState = picture ? &blend : &flat_blend,
		.pDynamicState = &dynamic,
		.layout = device->pipeline_layout,
	};
	return vkCreateGraphicsPipelines(device->gpu->device, VK_NULL_HANDLE, 1, &info, device->gpu->allocator,
	                                 &device->pipelines_2d[kind]);
}

static VkResult pipelines_make_2d(vulkan_device *device, vulkan_pipeline_2d kind)
{
	VkShaderModule modules[2] = {VK_NULL_HANDLE, VK_NULL_HANDLE};
	VkResult result = shader_create(device, flat_code[kind][0], &modules[0]);
	if (result == VK_SUCCESS)
		result = shader_create(device, flat_code[kind][1], &modules[1]);
	if (result == VK_SUCCESS)
		result = pipeline_make_2d(device, modules, kind);
	for (int stage = 0; stage < 2; stage++)
		vkDestroyShaderModule(device->gpu->device, modules[stage], device->gpu->allocator);
	return result;
}

stilb_result vulkan_pipeline_create(vulkan_device *device)
{
	VkResult result = layout_create(device);
	for (int surface = 0; surface < VULKAN_SURFACES && result == VK_SUCCESS; surface++)
		result = mesh_modules_make(device, (vulkan_surface)surface);
	if (result != VK_SUCCESS)
		return gpu_vulkan_fail(device->gpu, result, "make the mesh shaders");
	for (int kind = 0; kind < VULKAN_PIPELINES_2D && result == VK_SUCCESS; kind++)
		result = pipelines_make_2d(device, (vulkan_pipeline_2d)kind);
	return result == VK_SUCCESS ? STILB_OK : gpu_vulkan_fail(device->gpu, result, "make the 2D pipelines");
}

void vulkan_pipeline_destroy(vulkan_device *device)
{
	for (uint32_t s = 0; s < device->shading_count; s++)
		shading_destroy(device, device->shadings[s]);
	free(device->shadings);
	for (int surface = 0; surface < VULKAN_SURFACES; surface++) {
		for (int stage = 0; stage < 2; stage++)
			vkDestroyShaderModule(device->gpu->device, device->mesh_modules[surface][stage], device->gpu->allocator);
	}
	for (int kind = 0; kind < VULKAN_PIPELINES_2D; kind++)
		vkDestroyPipeline(device->gpu->device, device->pipelines_2d[kind], device->gpu->allocator);
	vulkan_backdrop_destroy(device);
	vkDestroyPipelineLayout(device->gpu->device, device->pipeline_layout, device->gpu->allocator);
	vkDestroyDescriptorSetLayout(device->gpu->device, device->texture_layout, device->gpu->allocator);
	vkDestroyDescriptorSetLayout(device->gpu->device, device->material_layout, device->gpu->allocator);
}

VkPipeline vulkan_pipeline_for(const vulkan_device *device, uint64_t state)
{
	vulkan_pipeline_materials materials = VULKAN_PIPELINE_ANY;
	if (state & RENDER_STATE_2D)
		return device->pipelines_2d[state & RENDER_STATE_PICTURE       ? VULKAN_PIPELINE_2D_PICTURE
		                            : render_state_texture(state) != 0 ? VULKAN_PIPELINE_2D_TEXTURE
		                                                               : VULKAN_PIPELINE_2D_FLAT];
	if (device->base.materials == STILB_RENDER_MATERIALS_PIPELINE)
		materials = render_state_material(state) ? VULKAN_PIPELINE_ODD : VULKAN_PIPELINE_EVEN;
	vulkan_surface surface = state & RENDER_STATE_IMPOSTOR      ? VULKAN_SURFACE_IMPOSTOR
	                         : render_state_texture(state) != 0 ? VULKAN_SURFACE_TEXTURE
	                                                            : VULKAN_SURFACE_PLAIN;
	VkPipeline pipeline = device->shading->pipelines[render_state_detail(state)][surface][materials].handle;
	STILB_ASSERT(pipeline && "vulkan_pipeline_choose has made it");
	return pipeline;
}
