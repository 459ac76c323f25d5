/* The plain Vulkan program's device, memory, pipeline and frames. */
#include "bench/subjects/vulkan_bare.h"

#include "bench/record/record_child.h"

/* The engine's shaders, compiled to SPIR-V by its build. */
static const uint32_t vertex_code[] =
#include "mesh.vert.inc"
	;
static const uint32_t fragment_code[] =
#include "mesh.frag.inc"
	;

void bare_check(VkResult result, const char *call)
{
	if (result != VK_SUCCESS)
		bench_child_fail("%s: VkResult %d", call, (int)result);
}

/* ---- device ------------------------------------------------------------------------------------------------------ */

/* Chooses the first device that draws on the CPU; false, after a line on stderr, if there is none. */
static bool find_gpu(bare *b)
{
	VkPhysicalDevice gpus[16];
	uint32_t count = 16;
	if (vkEnumeratePhysicalDevices(b->instance, &count, gpus) < 0)
		count = 0;
	for (uint32_t i = 0; i < count; i++) {
		VkPhysicalDeviceProperties properties;
		vkGetPhysicalDeviceProperties(gpus[i], &properties);
		if (properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU && properties.apiVersion >= VK_API_VERSION_1_3) {
			b->gpu = gpus[i];
			return true;
		}
	}
	fprintf(stderr, "no software driver for Vulkan 1.3 is installed (Debian package mesa-vulkan-drivers)\n");
	return false;
}

/* Creates the device with one queue of family 0, which on lavapipe has all capabilities. */
static void make_device(bare *b)
{
	static const float priority = 1.0f;
	VkPhysicalDeviceVulkan13Features v13 = {
		.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES,
		.dynamicRendering = VK_TRUE,
		.synchronization2 = VK_TRUE,
	};
	VkPhysicalDeviceVulkan12Features v12 = {
		.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
		.pNext = &v13,
		.bufferDeviceAddress = VK_TRUE,
	};
	VkPhysicalDeviceFeatures features = {.multiDrawIndirect = VK_TRUE, .drawIndirectFirstInstance = VK_TRUE};
	VkDeviceQueueCreateInfo queue = {
		.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
		.queueCount = 1,
		.pQueuePriorities = &priority,
	};
	VkDeviceCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
		.pNext = &v12,
		.queueCreateInfoCount = 1,
		.pQueueCreateInfos = &queue,
		.pEnabledFeatures = &features,
	};
	bare_check(vkCreateDevice(b->gpu, &info, NULL, &b->device), "vkCreateDevice");
	vkGetDeviceQueue(b->device, 0, 0, &b->queue);
}

bool bare_open(bare *b)
{
	VkApplicationInfo application = {
		.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
		.apiVersion = VK_API_VERSION_1_3,
	};
	VkInstanceCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
		.pApplicationInfo = &application,
	};
	*b = (bare){0};
	if (vkCreateInstance(&info, NULL, &b->instance) != VK_SUCCESS) {
		fprintf(stderr, "no Vulkan driver is installed (Debian package mesa-vulkan-drivers)\n");
		return false;
	}
	if (!find_gpu(b)) {
		vkDestroyInstance(b->instance, NULL);
		return false;
	}
	make_device(b);
	return true;
}

/* ---- memory ------------------------------------------------------------------------------------------------------ */

/* Allocates memory of the first allowed type. All of lavapipe's memory can be mapped. */
static VkDeviceMemory allocate(bare *b, VkMemoryRequirements needs, bool address)
{
	VkMemoryAllocateFlagsInfo flags = {
		.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
		.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT,
	};
	VkMemoryAllocateInfo info = {
		.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
		.pNext = address ? &flags : NULL,
		.allocationSize = needs.size,
		.memoryTypeIndex = (uint32_t)__builtin_ctz(needs.memoryTypeBits),
	};
	VkDeviceMemory memory;
	bare_check(vkAllocateMemory(b->device, &info, NULL, &memory), "vkAllocateMemory");
	return memory;
}

static bare_buffer make_buffer(bare *b, VkDeviceSize size, VkBufferUsageFlags usage)
{
	bool address = usage & VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
	VkBufferCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
		.size = size,
		.usage = usage,
	};
	bare_buffer made = {0};
	VkMemoryRequirements needs;
	bare_check(vkCreateBuffer(b->device, &info, NULL, &made.buffer), "vkCreateBuffer");
	vkGetBufferMemoryRequirements(b->device, made.buffer, &needs);
	made.memory = allocate(b, needs, address);
	bare_check(vkBindBufferMemory(b->device, made.buffer, made.memory, 0), "vkBindBufferMemory");
	bare_check(vkMapMemory(b->device, made.memory, 0, VK_WHOLE_SIZE, 0, &made.mapped), "vkMapMemory");
	VkBufferDeviceAddressInfo where = {
		.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO,
		.buffer = made.buffer,
	};
	if (address)
		made.address = vkGetBufferDeviceAddress(b->device, &where);
	return made;
}

static void free_buffer(bare *b, bare_buffer *buffer)
{
	vkDestroyBuffer(b->device, buffer->buffer, NULL);
	vkFreeMemory(b->device, buffer->memory, NULL);
}

static bare_image make_image(bare *b, uint32_t width, uint32_t height, VkFormat format, VkImageUsageFlags usage,
                             VkImageAspectFlags aspect)
{
	VkImageCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
		.imageType = VK_IMAGE_TYPE_2D,
		.format = format,
		.extent = {width, height, 1},
		.mipLevels = 1,
		.arrayLayers = 1,
		.samples = VK_SAMPLE_COUNT_1_BIT,
		.tiling = VK_IMAGE_TILING_OPTIMAL,
		.usage = usage,
	};
	bare_image made = {0};
	VkMemoryRequirements needs;
	bare_check(vkCreateImage(b->device, &info, NULL, &made.image), "vkCreateImage");
	vkGetImageMemoryRequirements(b->device, made.image, &needs);
	made.memory = allocate(b, needs, false);
	bare_check(vkBindImageMemory(b->device, made.image, made.memory, 0), "vkBindImageMemory");
	VkImageViewCreateInfo view = {
		.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
		.image = made.image,
		.viewType = VK_IMAGE_VIEW_TYPE_2D,
		.format = format,
		.subresourceRange = {.aspectMask = aspect, .levelCount = 1, .layerCount = 1},
	};
	bare_check(vkCreateImageView(b->device, &view, NULL, &made.view), "vkCreateImageView");
	return made;
}

static void free_image(bare *b, bare_image *image)
{
	vkDestroyImageView(b->device, image->view, NULL);
	vkDestroyImage(b->device, image->image, NULL);
	vkFreeMemory(b->device, image->memory, NULL);
}

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
	b->vertices = make_buffer(b, vertices * sizeof(stilb_scene_vertex), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
	b->indices = make_buffer(b, indices * sizeof(uint32_t), VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
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
	b->materials = make_buffer(b, scene->material_count * sizeof(bare_material), SHADER_BUFFER);
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
	VkVertexInputBindingDescription binding = {.stride = sizeof(stilb_scene_vertex)};
	const VkVertexInputAttributeDescription attributes[2] = {
		{.location = 0, .format = VK_FORMAT_R32G32B32_SFLOAT, .offset = offsetof(stilb_scene_vertex, position)},
		{.location = 1, .format = VK_FORMAT_R32G32B32_SFLOAT, .offset = offsetof(stilb_scene_vertex, normal)},
	};
	VkPipelineVertexInputStateCreateInfo vertex_input = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
		.vertexBindingDescriptionCount = program->vertices ? 1 : 0,
		.pVertexBindingDescriptions = &binding,
		.vertexAttributeDescriptionCount = program->vertices ? 2 : 0,
		.pVertexAttributeDescriptions = attributes,
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
		.cullMode = program->vertices ? VK_CULL_MODE_BACK_BIT : VK_CULL_MODE_NONE,
		.frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE,
		.lineWidth = 1.0f,
	};
	VkPipelineMultisampleStateCreateInfo multisample = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
		.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT,
	};
	VkPipelineDepthStencilStateCreateInfo depth = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
		.depthTestEnable = program->vertices,
		.depthWriteEnable = program->vertices,
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
		.depthAttachmentFormat = program->vertices ? VK_FORMAT_D32_SFLOAT : VK_FORMAT_UNDEFINED,
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
	bare_program program = {.codes = {vertex_code, fragment_code},
	                        .sizes = {sizeof vertex_code, sizeof fragment_code},
	                        .vertices = true,
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
	frame->rows = make_buffer(b, draws * sizeof(bare_row), SHADER_BUFFER);
	frame->indirect = make_buffer(b, draws * sizeof(VkDrawIndexedIndirectCommand), VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT);
	frame->view = make_buffer(b, sizeof(bare_view), SHADER_BUFFER);
	frame->picture = make_buffer(b, (VkDeviceSize)width * height * 4, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
}

static void free_frame(bare *b, bare_frame *frame)
{
	vkDestroyCommandPool(b->device, frame->pool, NULL);
	vkDestroyFence(b->device, frame->done, NULL);
	free_buffer(b, &frame->rows);
	free_buffer(b, &frame->indirect);
	free_buffer(b, &frame->view);
	free_buffer(b, &frame->picture);
}

void bare_prepare(bare *b, const stilb_scene *scene, uint32_t width, uint32_t height)
{
	make_meshes(b, scene);
	make_materials(b, scene);
	b->color =
		make_image(b, width, height, VK_FORMAT_R8G8B8A8_SRGB,
	               VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT, VK_IMAGE_ASPECT_COLOR_BIT);
	b->light = make_image(b, width, height, VK_FORMAT_R16G16B16A16_SFLOAT,
	                      VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT, VK_IMAGE_ASPECT_COLOR_BIT);
	b->depth = make_image(b, width, height, VK_FORMAT_D32_SFLOAT, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT,
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
	free_image(b, &b->light);
	free_image(b, &b->color);
	free_image(b, &b->depth);
	free_buffer(b, &b->vertices);
	free_buffer(b, &b->indices);
	free_buffer(b, &b->materials);
	free(b->meshes);
	vkDestroyPipeline(b->device, b->pipeline, NULL);
	vkDestroyPipelineLayout(b->device, b->layout, NULL);
	vkDestroyDevice(b->device, NULL);
	vkDestroyInstance(b->instance, NULL);
}
