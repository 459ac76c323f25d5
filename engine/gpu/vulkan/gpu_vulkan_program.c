/* Programs: shaders, layouts, and a pipeline for each combination of attachments. */
#include "gpu/spirv/gpu_specialize.h"
#include "gpu/vulkan/gpu_vulkan_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

VkShaderStageFlags gpu_vulkan_program_stages(const stilb_gpu_program_desc *desc)
{
	return desc->compute.words ? VK_SHADER_STAGE_COMPUTE_BIT
	                           : VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;
}

/* ---- layouts ----------------------------------------------------------------------------------------------------- */

static VkResult program_uses_layout(gpu_vulkan *gpu, const stilb_gpu_program_desc *desc, gpu_vulkan_program *program)
{
	VkDescriptorSetLayoutBinding bindings[32];
	uint32_t images = (uint32_t)desc->samplers + desc->storage_images, count = images + desc->uniforms;
	STILB_ASSERT(count <= 32);
	for (uint32_t b = 0; b < count; b++)
		bindings[b] = (VkDescriptorSetLayoutBinding){
			.binding = b,
			.descriptorType = b < desc->samplers ? VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER
		                      : b < images       ? VK_DESCRIPTOR_TYPE_STORAGE_IMAGE
		                                         : VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER,
			.descriptorCount = 1,
			.stageFlags = gpu_vulkan_program_stages(desc),
		};
	VkDescriptorSetLayoutCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
		.bindingCount = count,
		.pBindings = bindings,
	};
	return vkCreateDescriptorSetLayout(gpu->device, &info, gpu->allocator, &program->uses);
}

static VkResult program_layout(gpu_vulkan *gpu, const stilb_gpu_program_desc *desc, gpu_vulkan_program *program)
{
	VkResult result = program_uses_layout(gpu, desc, program);
	VkDescriptorSetLayout sets[2] = {program->uses, VK_NULL_HANDLE};
	if (result == VK_SUCCESS && desc->set_items > 0) {
		stilb_lock_take(&gpu->views_lock);
		result = gpu_vulkan_set_layout(gpu, desc->set_items);
		stilb_lock_give(&gpu->views_lock);
		sets[1] = gpu->item_layouts[desc->set_items];
	}
	if (result != VK_SUCCESS)
		return result;
	VkPushConstantRange range = {gpu_vulkan_program_stages(desc), 0, STILB_GPU_MAX_CONSTANTS};
	VkPipelineLayoutCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
		.setLayoutCount = desc->set_items > 0 ? 2 : 1,
		.pSetLayouts = sets,
		.pushConstantRangeCount = 1,
		.pPushConstantRanges = &range,
	};
	return vkCreatePipelineLayout(gpu->device, &info, gpu->allocator, &program->layout);
}

static VkResult program_module(gpu_vulkan *gpu, const stilb_gpu_program_desc *desc, const stilb_gpu_shader *shader,
                               VkShaderModule *module)
{
	if (!shader->words)
		return VK_SUCCESS;
	size_t count;
	uint32_t *words = gpu_specialize(shader->words, shader->bytes / sizeof *words, desc, &count);
	VkShaderModuleCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
		.codeSize = words ? count * sizeof *words : shader->bytes,
		.pCode = words ? words : shader->words,
	};
	VkResult result = vkCreateShaderModule(gpu->device, &info, gpu->allocator, module);
	free(words);
	return result;
}

static void program_destroy(gpu_vulkan *gpu, gpu_vulkan_program *program)
{
	for (uint32_t v = 0; v < program->variant_count; v++) {
		vkDestroyPipeline(gpu->device, program->variants[v]->pipeline.handle, gpu->allocator);
		free(program->variants[v]);
	}
	free(program->variants);
	vkDestroyPipelineLayout(gpu->device, program->layout, gpu->allocator);
	vkDestroyDescriptorSetLayout(gpu->device, program->uses, gpu->allocator);
	for (int m = 0; m < 2; m++)
		vkDestroyShaderModule(gpu->device, program->modules[m], gpu->allocator);
	free(program);
}

stilb_result gpu_vulkan_program_make(stilb_gpu *base, gpu_program *entry)
{
	gpu_vulkan *gpu = (gpu_vulkan *)base;
	const stilb_gpu_program_desc *desc = &entry->desc;
	gpu_vulkan_program *program = calloc(1, sizeof *program);
	if (!program)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for program '%s'", entry->name);
	bool compute = desc->compute.words;
	VkResult result = program_layout(gpu, desc, program);
	if (result == VK_SUCCESS)
		result = program_module(gpu, desc, &entry->code[compute ? GPU_STAGE_COMPUTE : GPU_STAGE_VERTEX],
		                        &program->modules[0]);
	if (result == VK_SUCCESS)
		result = program_module(gpu, desc, &entry->code[GPU_STAGE_FRAGMENT], &program->modules[1]);
	if (result == VK_SUCCESS) {
		gpu_vulkan_name(gpu, VK_OBJECT_TYPE_PIPELINE_LAYOUT, (uint64_t)program->layout, entry->name);
		entry->own = program;
		return STILB_OK;
	}
	program_destroy(gpu, program);
	char what[GPU_NAME + 32];
	snprintf(what, sizeof what, "make program '%s'", entry->name);
	return gpu_vulkan_fail(gpu, result, what);
}

void gpu_vulkan_program_free(stilb_gpu *base, gpu_program *entry)
{
	program_destroy((gpu_vulkan *)base, entry->own);
}

/* ---- pipelines --------------------------------------------------------------------------------------------------- */

typedef struct program_wanted {
	const gpu_vulkan_program *program;
	const stilb_gpu_program_desc *desc;
	const gpu_vulkan_variant *variant;
} program_wanted;

/* Specialization constants, as Vulkan wants them. */
typedef struct program_constants {
	VkSpecializationMapEntry entries[STILB_GPU_MAX_SPECIALIZATIONS];
	VkSpecializationInfo info;
} program_constants;

static void constants_make(const stilb_gpu_program_desc *desc, program_constants *constants)
{
	for (uint32_t c = 0; c < desc->constant_count; c++)
		constants->entries[c] = (VkSpecializationMapEntry){
			.constantID = desc->constants[c].id,
			.offset = c * (uint32_t)sizeof *desc->constants + (uint32_t)sizeof desc->constants->id,
			.size = sizeof desc->constants->value,
		};
	constants->info = (VkSpecializationInfo){
		.mapEntryCount = desc->constant_count,
		.pMapEntries = constants->entries,
		.dataSize = sizeof desc->constants,
		.pData = desc->constants,
	};
}

static VkPipelineShaderStageCreateInfo stage_of(VkShaderStageFlagBits stage, VkShaderModule module,
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

/* Of colour attachment number `color`. */
static VkPipelineColorBlendAttachmentState blend_of(const stilb_gpu_program_desc *desc, uint32_t color)
{
	uint8_t blend = desc->blend;
	if (desc->colors > 0 && color >= desc->colors)
		return (VkPipelineColorBlendAttachmentState){0}; /* it stays as it is */
	bool multiply = blend == STILB_GPU_BLEND_MULTIPLY;
	VkBlendFactor target = multiply                       ? VK_BLEND_FACTOR_SRC_COLOR
	                       : blend == STILB_GPU_BLEND_ADD ? VK_BLEND_FACTOR_ONE
	                                                      : VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
	return (VkPipelineColorBlendAttachmentState){
		.blendEnable = blend != STILB_GPU_BLEND_NONE,
		.srcColorBlendFactor = multiply ? VK_BLEND_FACTOR_ZERO : VK_BLEND_FACTOR_ONE,
		.dstColorBlendFactor = target,
		.srcAlphaBlendFactor = multiply ? VK_BLEND_FACTOR_ZERO : VK_BLEND_FACTOR_ONE,
		.dstAlphaBlendFactor = multiply ? VK_BLEND_FACTOR_ONE : target,
		.colorWriteMask = desc->stencil == STILB_GPU_STENCIL_COUNT ? 0 : 0xf,
	};
}

static VkResult pipeline_compute(gpu_vulkan *gpu, const program_wanted *wanted, VkPipeline *pipeline)
{
	program_constants constants;
	constants_make(wanted->desc, &constants);
	VkComputePipelineCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
		.stage = stage_of(VK_SHADER_STAGE_COMPUTE_BIT, wanted->program->modules[0], &constants.info),
		.layout = wanted->program->layout,
	};
	return vkCreateComputePipelines(gpu->device, VK_NULL_HANDLE, 1, &info, gpu->allocator, pipeline);
}

/* What a program reads of vertices. */
static uint32_t vertex_attributes(const stilb_gpu_program_desc *desc,
                                  VkVertexInputAttributeDescription attributes[STILB_GPU_MAX_VERTEX_INPUTS])
{
	for (uint32_t i = 0; i < desc->input_count; i++)
		attributes[i] = (VkVertexInputAttributeDescription){
			.location = desc->inputs[i].location,
			.format = gpu_vulkan_format((stilb_gpu_format)desc->inputs[i].format),
			.offset = desc->inputs[i].offset,
		};
	return desc->input_count;
}

static VkPipelineDepthStencilStateCreateInfo depth_of(const stilb_gpu_program_desc *desc)
{
	static const VkCompareOp compares[] = {
		[STILB_GPU_COMPARE_NONE] = VK_COMPARE_OP_ALWAYS,
		[STILB_GPU_COMPARE_GREATER] = VK_COMPARE_OP_GREATER,
		[STILB_GPU_COMPARE_GREATER_EQUAL] = VK_COMPARE_OP_GREATER_OR_EQUAL,
		[STILB_GPU_COMPARE_EQUAL] = VK_COMPARE_OP_EQUAL,
	};
	VkStencilOpState keep = {.compareOp = VK_COMPARE_OP_ALWAYS, .compareMask = 0xff, .writeMask = 0xff};
	VkStencilOpState front = keep, back = keep;
	if (desc->stencil == STILB_GPU_STENCIL_COUNT) {
		front.depthFailOp = VK_STENCIL_OP_DECREMENT_AND_WRAP;
		back.depthFailOp = VK_STENCIL_OP_INCREMENT_AND_WRAP;
	} else if (desc->stencil == STILB_GPU_STENCIL_COUNTED) {
		front.compareOp = VK_COMPARE_OP_NOT_EQUAL;
		front.passOp = VK_STENCIL_OP_ZERO;
		back = front;
	}
	return (VkPipelineDepthStencilStateCreateInfo){
		.sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
		.depthTestEnable = desc->depth != STILB_GPU_COMPARE_NONE || desc->depth_write,
		.depthWriteEnable = desc->depth_write,
		.depthCompareOp = compares[desc->depth],
		.stencilTestEnable = desc->stencil != STILB_GPU_STENCIL_NONE,
		.front = front,
		.back = back,
	};
}

static VkResult pipeline_graphics(gpu_vulkan *gpu, const program_wanted *wanted, VkPipeline *pipeline)
{
	static const VkDynamicState states[2] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
	const stilb_gpu_program_desc *desc = wanted->desc;
	const gpu_vulkan_variant *variant = wanted->variant;
	program_constants constants;
	constants_make(desc, &constants);
	VkPipelineShaderStageCreateInfo stages[2] = {
		stage_of(VK_SHADER_STAGE_VERTEX_BIT, wanted->program->modules[0], &constants.info),
		stage_of(VK_SHADER_STAGE_FRAGMENT_BIT, wanted->program->modules[1], &constants.info),
	};
	VkVertexInputAttributeDescription attributes[STILB_GPU_MAX_VERTEX_INPUTS];
	VkVertexInputBindingDescription binding = {.stride = desc->vertex_bytes};
	VkPipelineVertexInputStateCreateInfo input = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
		.vertexBindingDescriptionCount = desc->vertex_bytes > 0,
		.pVertexBindingDescriptions = &binding,
		.vertexAttributeDescriptionCount = vertex_attributes(desc, attributes),
		.pVertexAttributeDescriptions = attributes,
	};
	VkPipelineInputAssemblyStateCreateInfo assembly = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
		.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
	};
	VkPipelineViewportStateCreateInfo viewport = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO, .viewportCount = 1, .scissorCount = 1};
	VkPipelineRasterizationStateCreateInfo rasterization = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
		.depthClampEnable = desc->stencil != STILB_GPU_STENCIL_NONE,
		.polygonMode = desc->lines ? VK_POLYGON_MODE_LINE : VK_POLYGON_MODE_FILL,
		.cullMode = desc->cull_back ? VK_CULL_MODE_BACK_BIT : VK_CULL_MODE_NONE,
		.frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE,
		.depthBiasEnable = desc->depth_bias != 0.0f || desc->depth_bias_slope != 0.0f,
		.depthBiasConstantFactor = desc->depth_bias,
		.depthBiasSlopeFactor = desc->depth_bias_slope,
		.lineWidth = 1.0f,
	};
	VkPipelineMultisampleStateCreateInfo samples = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
		.rasterizationSamples = (VkSampleCountFlagBits)variant->samples,
		.alphaToCoverageEnable = desc->alpha_to_coverage,
	};
	VkPipelineDepthStencilStateCreateInfo depth = depth_of(desc);
	VkPipelineColorBlendAttachmentState blends[STILB_GPU_MAX_COLORS];
	for (uint32_t c = 0; c < variant->color_count; c++)
		blends[c] = blend_of(desc, c);
	VkPipelineColorBlendStateCreateInfo blend = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
		.attachmentCount = variant->color_count,
		.pAttachments = blends,
	};
	VkPipelineDynamicStateCreateInfo dynamic = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
		.dynamicStateCount = 2,
		.pDynamicStates = states,
	};
	VkPipelineRenderingCreateInfo rendering = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
		.colorAttachmentCount = variant->color_count,
		.pColorAttachmentFormats = variant->colors,
		.depthAttachmentFormat = variant->depth,
		.stencilAttachmentFormat = gpu_vulkan_stencil_format(variant->depth),
	};
	VkGraphicsPipelineCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
		.pNext = &rendering,
		.stageCount = wanted->program->modules[1] ? 2 : 1,
		.pStages = stages,
		.pVertexInputState = &input,
		.pInputAssemblyState = &assembly,
		.pViewportState = &viewport,
		.pRasterizationState = &rasterization,
		.pMultisampleState = &samples,
		.pDepthStencilState = &depth,
		.pColorBlendState = &blend,
		.pDynamicState = &dynamic,
		.layout = wanted->program->layout,
	};
	return vkCreateGraphicsPipelines(gpu->device, VK_NULL_HANDLE, 1, &info, gpu->allocator, pipeline);
}

static VkResult pipeline_make(void *user, const void *what, VkPipeline *pipeline)
{
	const program_wanted *wanted = what;
	return wanted->desc->compute.words ? pipeline_compute(user, wanted, pipeline)
	                                   : pipeline_graphics(user, wanted, pipeline);
}

static bool variant_is(const gpu_vulkan_variant *a, const gpu_vulkan_variant *b)
{
	return a->color_count == b->color_count && a->depth == b->depth && a->samples == b->samples &&
	       memcmp(a->colors, b->colors, a->color_count * sizeof *a->colors) == 0;
}

/* The program's entry for these attachments, which may be a new one; it never moves. NULL: no memory. */
static gpu_vulkan_variant *variant_find(gpu_vulkan *gpu, gpu_vulkan_program *program, const gpu_vulkan_variant *wanted)
{
	gpu_vulkan_variant *found = NULL;
	pthread_mutex_lock(&gpu->pipelines_lock);
	for (uint32_t v = 0; v < program->variant_count && !found; v++)
		if (variant_is(program->variants[v], wanted))
			found = program->variants[v];
	if (!found && program->variant_count == program->variant_capacity) {
		uint32_t capacity = program->variant_capacity ? 2 * program->variant_capacity : 2;
		gpu_vulkan_variant **grown = realloc(program->variants, capacity * sizeof(*grown));
		if (grown) {
			program->variants = grown;
			program->variant_capacity = capacity;
		}
	}
	if (!found && program->variant_count < program->variant_capacity) {
		found = malloc(sizeof *found);
		if (found) {
			*found = *wanted;
			found->pipeline = (gpu_vulkan_pipeline){0};
			program->variants[program->variant_count++] = found;
		}
	}
	pthread_mutex_unlock(&gpu->pipelines_lock);
	return found;
}

stilb_result gpu_vulkan_program_pipeline(gpu_vulkan *gpu, gpu_program *entry, const gpu_vulkan_variant *wanted,
                                         VkPipeline *pipeline)
{
	gpu_vulkan_program *program = entry->own;
	gpu_vulkan_variant *variant = variant_find(gpu, program, wanted);
	if (!variant)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a pipeline of program '%s'", entry->name);
	program_wanted make = {program, &entry->desc, variant};
	VkResult result = gpu_vulkan_pipeline_once(gpu, &variant->pipeline, pipeline_make, gpu, &make);
	*pipeline = variant->pipeline.handle;
	if (result == VK_SUCCESS)
		return STILB_OK;
	char what[GPU_NAME + 48];
	snprintf(what, sizeof what, "compile a pipeline of program '%s'", entry->name);
	return gpu_vulkan_fail(gpu, result, what);
}

stilb_result gpu_vulkan_program_prepare(stilb_gpu *base, gpu_program *program, const stilb_gpu_format *colors,
                                        uint32_t color_count, stilb_gpu_format depth, uint32_t samples)
{
	gpu_vulkan_variant wanted = {.color_count = color_count, .depth = gpu_vulkan_format(depth), .samples = samples};
	for (uint32_t c = 0; c < color_count; c++)
		wanted.colors[c] = gpu_vulkan_format(colors[c]);
	if (program->desc.compute.words)
		wanted = (gpu_vulkan_variant){.samples = 1};
	VkPipeline pipeline;
	return gpu_vulkan_program_pipeline((gpu_vulkan *)base, program, &wanted, &pipeline);
}

stilb_result gpu_vulkan_program_follow(stilb_gpu *base, const gpu_program *from, gpu_program *to)
{
	gpu_vulkan *gpu = (gpu_vulkan *)base;
	const gpu_vulkan_program *program = from->own;
	for (uint32_t v = 0;; v++) {
		gpu_vulkan_variant wanted;
		pthread_mutex_lock(&gpu->pipelines_lock);
		bool more = v < program->variant_count;
		if (more)
			wanted = *program->variants[v]; /* its attachments */
		pthread_mutex_unlock(&gpu->pipelines_lock);
		if (!more)
			return STILB_OK;
		if (!variant_find(gpu, to->own, &wanted))
			return stilb_fail(STILB_ERROR_MEMORY, "no memory for a pipeline of program '%s'", to->name);
	}
}

stilb_result gpu_vulkan_program_compile(stilb_gpu *base, gpu_program *entry)
{
	const gpu_vulkan_program *program = entry->own;
	stilb_result result = STILB_OK;
	VkPipeline pipeline;
	for (uint32_t v = 0; v < program->variant_count && result == STILB_OK; v++)
		result = gpu_vulkan_program_pipeline((gpu_vulkan *)base, entry, program->variants[v], &pipeline);
	return result;
}
