/* Views of lights drawn by a plain Vulkan program: those of the suite's engine, for what they must cost; and the six
 * sides of a cube, each as a view of its own and all in one recording with layers. One thread records. */
#include "bench/harness/bench_child.h"
#include "bench/shadows/shadows_scene.h"
#include "bench/subjects/vulkan_bare.h"

#include "shadow/shadow.h"

#include <math.h>
#include <string.h>
#include <time.h>

#define MOST_VIEWS 6u

/* The shaders, compiled to SPIR-V. */
static const uint32_t one_code[] =
#include "shadows_map.vert.inc"
	;
static const uint32_t layered_code[] =
#include "shadows_map_layered.vert.inc"
	;

/* As the shaders have it. */
typedef struct map_row {
	float transform[12];
	uint32_t view, unused[3];
} map_row;

typedef struct map_push {
	VkDeviceAddress rows, matrices;
} map_push;

typedef struct maps {
	bare b;
	const stilb_scene *scene;
	VkImage image;
	VkDeviceMemory memory;
	VkImageView layers[MOST_VIEWS], all; /* each; and all of them */
	VkPipelineLayout layout;
	VkPipeline one, layered;
	VkCommandPool pool;
	VkCommandBuffer commands;
	VkFence done;
	bare_buffer rows, indirect, matrices, vertices, indices;
	bare_mesh *meshes;
	uint32_t size, view_count;
	stilb_shadow_map views[MOST_VIEWS];
	stilb_frustum frusta[MOST_VIEWS];
	uint32_t draws[MOST_VIEWS]; /* of each view */
	double triangles;           /* of the last frame */
} maps;

static double cpu_ms(clockid_t clock)
{
	struct timespec now;
	clock_gettime(clock, &now);
	return 1e3 * (double)now.tv_sec + 1e-6 * (double)now.tv_nsec;
}

/* ---- objects ----------------------------------------------------------------------------------------------------- */

static void *array_of(size_t count, size_t size)
{
	void *made = calloc(count, size);
	if (!made)
		bench_child_fail("no memory");
	return made;
}

static void make_meshes(maps *m)
{
	const stilb_scene *scene = m->scene;
	uint32_t vertices = 0, indices = 0;
	m->meshes = array_of(scene->mesh_count, sizeof *m->meshes);
	for (uint32_t i = 0; i < scene->mesh_count; i++) {
		m->meshes[i] = (bare_mesh){scene->meshes[i].index_count, indices, (int32_t)vertices};
		vertices += scene->meshes[i].vertex_count;
		indices += scene->meshes[i].index_count;
	}
	m->vertices = bare_make_buffer(&m->b, vertices * sizeof(float[3]), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
	m->indices = bare_make_buffer(&m->b, indices * sizeof(uint32_t), VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
	for (uint32_t i = 0; i < scene->mesh_count; i++) {
		const stilb_scene_mesh *mesh = &scene->meshes[i];
		float *out = (float *)m->vertices.mapped + 3 * (size_t)m->meshes[i].vertex_offset;
		for (uint32_t v = 0; v < mesh->vertex_count; v++)
			memcpy(out + 3 * v, mesh->vertices[v].position, sizeof(float[3]));
		memcpy((uint32_t *)m->indices.mapped + m->meshes[i].first_index, mesh->indices,
		       mesh->index_count * sizeof *mesh->indices);
	}
}

static VkImageView make_view(const maps *m, uint32_t first, uint32_t count)
{
	VkImageViewCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
		.image = m->image,
		.viewType = VK_IMAGE_VIEW_TYPE_2D_ARRAY,
		.format = VK_FORMAT_D32_SFLOAT,
		.subresourceRange = {VK_IMAGE_ASPECT_DEPTH_BIT, 0, 1, first, count},
	};
	VkImageView made;
	bare_check(vkCreateImageView(m->b.device, &info, NULL, &made), "vkCreateImageView");
	return made;
}

static void make_image(maps *m)
{
	VkImageCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
		.imageType = VK_IMAGE_TYPE_2D,
		.format = VK_FORMAT_D32_SFLOAT,
		.extent = {m->size, m->size, 1},
		.mipLevels = 1,
		.arrayLayers = m->view_count,
		.samples = VK_SAMPLE_COUNT_1_BIT,
		.tiling = VK_IMAGE_TILING_OPTIMAL,
		.usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
	};
	bare_check(vkCreateImage(m->b.device, &info, NULL, &m->image), "vkCreateImage");
	m->memory = bare_image_memory(&m->b, m->image);
	for (uint32_t v = 0; v < m->view_count; v++)
		m->layers[v] = make_view(m, v, 1);
	m->all = make_view(m, 0, m->view_count);
}

static VkPipeline make_pipeline(const maps *m, const uint32_t *code, size_t size)
{
	VkShaderModuleCreateInfo shader = {
		.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = size, .pCode = code};
	VkPipelineShaderStageCreateInfo stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
	                                         .stage = VK_SHADER_STAGE_VERTEX_BIT,
	                                         .pName = "main"};
	bare_check(vkCreateShaderModule(m->b.device, &shader, NULL, &stage.module), "vkCreateShaderModule");
	VkVertexInputBindingDescription binding = {.stride = sizeof(float[3])};
	VkVertexInputAttributeDescription attribute = {.format = VK_FORMAT_R32G32B32_SFLOAT};
	VkPipelineVertexInputStateCreateInfo input = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
		.vertexBindingDescriptionCount = 1,
		.pVertexBindingDescriptions = &binding,
		.vertexAttributeDescriptionCount = 1,
		.pVertexAttributeDescriptions = &attribute,
	};
	VkPipelineInputAssemblyStateCreateInfo assembly = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
		.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
	};
	VkRect2D area = {.extent = {m->size, m->size}};
	VkViewport whole = {.width = (float)m->size, .height = (float)m->size, .maxDepth = 1.0f};
	VkPipelineViewportStateCreateInfo viewport = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
		.viewportCount = 1,
		.pViewports = &whole,
		.scissorCount = 1,
		.pScissors = &area,
	};
	VkPipelineRasterizationStateCreateInfo rasterization = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
		.depthBiasEnable = VK_TRUE,
		.depthBiasSlopeFactor = -1.0f,
		.lineWidth = 1.0f,
	};
	VkPipelineMultisampleStateCreateInfo multisample = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
		.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT,
	};
	VkPipelineDepthStencilStateCreateInfo depth = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
		.depthTestEnable = VK_TRUE,
		.depthWriteEnable = VK_TRUE,
		.depthCompareOp = VK_COMPARE_OP_GREATER, /* reversed depth: near is 1 */
	};
	VkPipelineRenderingCreateInfo rendering = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
		.depthAttachmentFormat = VK_FORMAT_D32_SFLOAT,
	};
	VkGraphicsPipelineCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
		.pNext = &rendering,
		.stageCount = 1,
		.pStages = &stage,
		.pVertexInputState = &input,
		.pInputAssemblyState = &assembly,
		.pViewportState = &viewport,
		.pRasterizationState = &rasterization,
		.pMultisampleState = &multisample,
		.pDepthStencilState = &depth,
		.layout = m->layout,
	};
	VkPipeline made;
	bare_check(vkCreateGraphicsPipelines(m->b.device, VK_NULL_HANDLE, 1, &info, NULL, &made),
	           "vkCreateGraphicsPipelines");
	vkDestroyShaderModule(m->b.device, stage.module, NULL);
	return made;
}

static void make_frame(maps *m)
{
	VkPushConstantRange range = {.stageFlags = VK_SHADER_STAGE_VERTEX_BIT, .size = sizeof(map_push)};
	VkPipelineLayoutCreateInfo layout = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
	                                     .pushConstantRangeCount = 1,
	                                     .pPushConstantRanges = &range};
	VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
	                                .flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT};
	VkCommandBufferAllocateInfo commands = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
	                                        .commandBufferCount = 1};
	VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
	size_t most = (size_t)m->scene->part_count * m->view_count;
	VkBufferUsageFlags read = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
	bare_check(vkCreatePipelineLayout(m->b.device, &layout, NULL, &m->layout), "vkCreatePipelineLayout");
	bare_check(vkCreateCommandPool(m->b.device, &pool, NULL, &m->pool), "vkCreateCommandPool");
	commands.commandPool = m->pool;
	bare_check(vkAllocateCommandBuffers(m->b.device, &commands, &m->commands), "vkAllocateCommandBuffers");
	bare_check(vkCreateFence(m->b.device, &fence, NULL, &m->done), "vkCreateFence");
	m->rows = bare_make_buffer(&m->b, most * sizeof(map_row), read);
	m->matrices = bare_make_buffer(&m->b, MOST_VIEWS * sizeof(float[16]), read);
	m->indirect =
		bare_make_buffer(&m->b, most * sizeof(VkDrawIndexedIndirectCommand), VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT);
	m->one = make_pipeline(m, one_code, sizeof one_code);
	m->layered = make_pipeline(m, layered_code, sizeof layered_code);
}

static void maps_close(maps *m)
{
	vkDeviceWaitIdle(m->b.device);
	bare_buffer *buffers[] = {&m->rows, &m->indirect, &m->matrices, &m->vertices, &m->indices};
	for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++)
		bare_free_buffer(&m->b, buffers[i]);
	for (uint32_t v = 0; v < m->view_count; v++)
		vkDestroyImageView(m->b.device, m->layers[v], NULL);
	vkDestroyImageView(m->b.device, m->all, NULL);
	vkDestroyImage(m->b.device, m->image, NULL);
	vkFreeMemory(m->b.device, m->memory, NULL);
	vkDestroyPipeline(m->b.device, m->one, NULL);
	vkDestroyPipeline(m->b.device, m->layered, NULL);
	vkDestroyPipelineLayout(m->b.device, m->layout, NULL);
	vkDestroyCommandPool(m->b.device, m->pool, NULL);
	vkDestroyFence(m->b.device, m->done, NULL);
	vkDestroyDevice(m->b.device, NULL);
	vkDestroyInstance(m->b.instance, NULL);
	free(m->meshes);
}

/* ---- a frame ----------------------------------------------------------------------------------------------------- */

static bool sees(const maps *m, uint32_t view, uint32_t model)
{
	const stilb_scene_bounds *bounds = &m->scene->bounds;
	stilb_sphere sphere = {bounds->x[model], bounds->y[model], bounds->z[model], bounds->radius[model]};
	return stilb_frustum_may_see(&m->frusta[view], sphere) && stilb_shadow_casters_have(&m->views[view], sphere);
}

static void write_row(map_row *row, const stilb_mat4 *to_world, uint32_t view)
{
	for (int r = 0; r < 3; r++)
		for (int c = 0; c < 4; c++)
			row->transform[4 * r + c] = to_world->m[4 * c + r];
	row->view = view;
}

/* Writes rows and commands: of all views in one list where these are layered, else a list for each. Returns the number
 * of commands. */
static uint32_t write_draws(maps *m, bool layered)
{
	const stilb_scene *scene = m->scene;
	map_row *rows = m->rows.mapped;
	VkDrawIndexedIndirectCommand *commands = m->indirect.mapped;
	uint32_t row = 0, command = 0;
	m->triangles = 0.0;
	for (uint32_t first = 0; first < (layered ? 1 : m->view_count); first++) {
		uint32_t before = command;
		for (uint32_t i = 0; i < scene->model_count; i++) {
			for (uint32_t part = scene->first_part[i]; part < scene->first_part[i + 1]; part++) {
				uint32_t from = row;
				for (uint32_t v = first; v < (layered ? m->view_count : first + 1); v++)
					if (sees(m, v, i))
						write_row(&rows[row++], &scene->part_transform[part], v);
				if (row == from)
					continue;
				const bare_mesh *mesh = &m->meshes[scene->part_mesh[part]];
				commands[command++] = (VkDrawIndexedIndirectCommand){mesh->index_count, row - from, mesh->first_index,
				                                                     mesh->vertex_offset, from};
				m->triangles += (double)mesh->index_count / 3.0 * (row - from);
			}
		}
		m->draws[first] = command - before;
	}
	return command;
}

static void record_rendering(maps *m, uint32_t first_command, uint32_t commands, VkImageView view, uint32_t layers)
{
	VkRenderingAttachmentInfo depth = {
		.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
		.imageView = view,
		.imageLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
		.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
		.storeOp = VK_ATTACHMENT_STORE_OP_STORE,
	};
	VkRenderingInfo rendering = {
		.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
		.renderArea.extent = {m->size, m->size},
		.layerCount = layers,
		.pDepthAttachment = &depth,
	};
	map_push push = {m->rows.address, m->matrices.address};
	vkCmdBeginRendering(m->commands, &rendering);
	vkCmdBindPipeline(m->commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layers > 1 ? m->layered : m->one);
	vkCmdPushConstants(m->commands, m->layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof push, &push);
	vkCmdBindVertexBuffers(m->commands, 0, 1, &m->vertices.buffer, &(VkDeviceSize){0});
	vkCmdBindIndexBuffer(m->commands, m->indices.buffer, 0, VK_INDEX_TYPE_UINT32);
	vkCmdDrawIndexedIndirect(m->commands, m->indirect.buffer, first_command * sizeof(VkDrawIndexedIndirectCommand),
	                         commands, sizeof(VkDrawIndexedIndirectCommand));
	vkCmdEndRendering(m->commands);
}

static void record(maps *m, bool layered)
{
	VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
	                                  .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
	VkImageMemoryBarrier2 barrier = {
		.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
		.dstStageMask = VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT,
		.dstAccessMask = VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT,
		.newLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
		.image = m->image,
		.subresourceRange = {VK_IMAGE_ASPECT_DEPTH_BIT, 0, 1, 0, m->view_count},
	};
	bare_check(vkResetCommandPool(m->b.device, m->pool, 0), "vkResetCommandPool");
	bare_check(vkBeginCommandBuffer(m->commands, &begin), "vkBeginCommandBuffer");
	vkCmdPipelineBarrier2(m->commands, &(VkDependencyInfo){.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
	                                                       .imageMemoryBarrierCount = 1,
	                                                       .pImageMemoryBarriers = &barrier});
	uint32_t commands = write_draws(m, layered), first = 0;
	if (layered)
		record_rendering(m, 0, commands, m->all, m->view_count);
	for (uint32_t v = 0; v < m->view_count && !layered; v++) {
		record_rendering(m, first, m->draws[v], m->layers[v], 1);
		first += m->draws[v];
	}
	bare_check(vkEndCommandBuffer(m->commands), "vkEndCommandBuffer");
}

static void submit(maps *m)
{
	VkCommandBufferSubmitInfo commands = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
	                                      .commandBuffer = m->commands};
	VkSubmitInfo2 info = {
		.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2, .commandBufferInfoCount = 1, .pCommandBufferInfos = &commands};
	bare_check(vkQueueSubmit2(m->b.queue, 1, &info, m->done), "vkQueueSubmit2");
	bare_check(vkWaitForFences(m->b.device, 1, &m->done, VK_TRUE, UINT64_MAX), "vkWaitForFences");
	bare_check(vkResetFences(m->b.device, 1, &m->done), "vkResetFences");
}

/* Depth of all layers as it is now, to be freed. */
static float *read_layers(maps *m, size_t *bytes)
{
	*bytes = (size_t)m->size * m->size * m->view_count * sizeof(float);
	bare_buffer copy = bare_make_buffer(&m->b, *bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
	VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
	VkImageMemoryBarrier2 barrier = {
		.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
		.srcStageMask = VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT,
		.srcAccessMask = VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT,
		.dstStageMask = VK_PIPELINE_STAGE_2_COPY_BIT,
		.dstAccessMask = VK_ACCESS_2_TRANSFER_READ_BIT,
		.oldLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
		.newLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
		.image = m->image,
		.subresourceRange = {VK_IMAGE_ASPECT_DEPTH_BIT, 0, 1, 0, m->view_count},
	};
	VkBufferImageCopy region = {.imageSubresource = {VK_IMAGE_ASPECT_DEPTH_BIT, 0, 0, m->view_count},
	                            .imageExtent = {m->size, m->size, 1}};
	bare_check(vkResetCommandPool(m->b.device, m->pool, 0), "vkResetCommandPool");
	bare_check(vkBeginCommandBuffer(m->commands, &begin), "vkBeginCommandBuffer");
	vkCmdPipelineBarrier2(m->commands, &(VkDependencyInfo){.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
	                                                       .imageMemoryBarrierCount = 1,
	                                                       .pImageMemoryBarriers = &barrier});
	vkCmdCopyImageToBuffer(m->commands, m->image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, copy.buffer, 1, &region);
	bare_check(vkEndCommandBuffer(m->commands), "vkEndCommandBuffer");
	submit(m);
	float *depth = array_of(*bytes, 1);
	memcpy(depth, copy.mapped, *bytes);
	bare_free_buffer(&m->b, &copy);
	return depth;
}

/* Ends the program unless both ways draw the same, and something. */
static void check_layers(maps *m)
{
	float *depths[2];
	size_t bytes;
	for (int layered = 0; layered < 2; layered++) {
		record(m, layered);
		submit(m);
		depths[layered] = read_layers(m, &bytes);
	}
	size_t drawn = 0;
	for (size_t i = 0; i < bytes / sizeof(float); i++)
		drawn += depths[0][i] > 0.0f;
	if (drawn == 0 || memcmp(depths[0], depths[1], bytes) != 0)
		bench_child_fail("wrong result: six views and layers differ, or show nothing");
	free(depths[0]);
	free(depths[1]);
}

/* Views, a matrix and a frustum each. */
static void set_views(maps *m, const stilb_shadow_map *views)
{
	for (uint32_t v = 0; v < m->view_count; v++) {
		m->views[v] = views[v];
		m->frusta[v] = stilb_frustum_from_matrix(&views[v].view_projection);
		memcpy((float *)m->matrices.mapped + 16 * v, views[v].view_projection.m, sizeof(float[16]));
	}
}

/* CPU time of all threads of a frame, and the recording's part of it, the least of some. */
static void measure(maps *m, bool layered, double *frame, double *recording)
{
	double start = cpu_ms(CLOCK_PROCESS_CPUTIME_ID), begin = cpu_ms(CLOCK_THREAD_CPUTIME_ID);
	record(m, layered);
	*recording = fmin(*recording, cpu_ms(CLOCK_THREAD_CPUTIME_ID) - begin);
	submit(m);
	*frame = fmin(*frame, cpu_ms(CLOCK_PROCESS_CPUTIME_ID) - start);
}

/* ---- cases ------------------------------------------------------------------------------------------------------- */

static bool maps_open(maps *m, const stilb_scene *scene, uint32_t size, uint32_t views)
{
	*m = (maps){.scene = scene, .size = size, .view_count = views};
	if (!bare_open(&m->b))
		return false;
	make_meshes(m);
	make_image(m);
	make_frame(m);
	return true;
}

/* The engine's three cascades. */
static bool run_views(const bench_child *child, uint32_t models)
{
	stilb_scene *scene = shadows_scene(models);
	stilb_shadow_plan plan = {0};
	maps m;
	if (!maps_open(&m, scene, SHADOWS_SIZE, SHADOWS_CASCADES))
		return false;
	double frame = HUGE_VAL, recording = HUGE_VAL;
	uint64_t end = bench_child_now_ns() + (uint64_t)(child->seconds * 1e9);
	for (uint32_t f = 1; f < 8 || bench_child_now_ns() < end; f++) {
		stilb_scene_animate(scene, f / 60.0);
		scene->moved_count = 0;
		if (shadows_plan(scene, &plan) != STILB_OK || plan.map_count != SHADOWS_CASCADES)
			bench_child_fail("no plan of %u maps", SHADOWS_CASCADES);
		set_views(&m, plan.maps);
		measure(&m, false, &frame, &recording);
	}
	bench_child_metric("maps", 1e-3 * m.triangles);
	bench_child_metric("frame", frame);
	bench_child_metric("record", recording);
	maps_close(&m);
	stilb_shadow_plan_finish(&plan);
	stilb_scene_destroy(scene);
	return true;
}

/* The six sides of a cube around a lamp over the middle of the scene. */
static bool run_cube(const bench_child *child, uint32_t models)
{
	stilb_scene *scene = shadows_scene(models);
	stilb_shadow_plan plan = {0};
	maps m;
	if (!maps_open(&m, scene, SHADOWS_CUBE, 6))
		return false;
	if (shadows_plan_lamp(scene, &plan) != STILB_OK || plan.map_count != 6)
		bench_child_fail("no plan of six maps");
	set_views(&m, plan.maps);
	check_layers(&m);
	double frames[2] = {HUGE_VAL, HUGE_VAL}, recordings[2] = {HUGE_VAL, HUGE_VAL};
	uint64_t end = bench_child_now_ns() + (uint64_t)(child->seconds * 1e9);
	for (uint32_t f = 0; f < 5 || bench_child_now_ns() < end; f++)
		for (int layered = 0; layered < 2; layered++) /* by turns */
			measure(&m, layered, &frames[layered], &recordings[layered]);
	bench_child_metric("maps", 1e-3 * m.triangles);
	bench_child_metric("six", frames[0]);
	bench_child_metric("layered", frames[1]);
	bench_child_metric("record-six", recordings[0]);
	bench_child_metric("record-layered", recordings[1]);
	bench_child_metric("ratio", frames[1] / frames[0]);
	maps_close(&m);
	stilb_shadow_plan_finish(&plan);
	stilb_scene_destroy(scene);
	return true;
}

int main(int argc, char **argv)
{
	bench_child child = bench_child_args(argc, argv);
	uint32_t models;
	if (sscanf(child.case_name, "views-%u", &models) == 1)
		return run_views(&child, models) ? 0 : BENCH_CHILD_SKIP;
	if (sscanf(child.case_name, "cube-%u", &models) == 1)
		return run_cube(&child, models) ? 0 : BENCH_CHILD_SKIP;
	return BENCH_CHILD_SKIP;
}
