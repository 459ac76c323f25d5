/*
 * shade_gpu: one compute shader over many inputs: two buffers, a pipeline and a dispatch, on the first Vulkan device
 * and under the validation layer.
 *
 * The shader gets shade_gpu_push as its push constants: addresses of the inputs (two vec4 for each result, [0, 1)) and
 * of the results (vec4), an integer that is the test's own, and the count.
 */
#ifndef SHADE_GPU_H
#define SHADE_GPU_H

#include "support/shade_proof.h"

#include "render/vulkan/vulkan_internal.h"
#include "support/test.h"

#include <stdio.h>
#include <string.h>

#define SHADE_GPU_COUNT 20000u
#define SHADE_GPU_GROUP 64u

typedef struct shade_gpu_push {
	VkDeviceAddress inputs, results;
	int32_t row;
	uint32_t count;
} shade_gpu_push;

static struct {
	stilb_render *render; /* for its device and its memory */
	vulkan_device *device;
	gpu_vulkan_buffer inputs, results;
	VkPipelineLayout layout;
	VkShaderModule code;
	VkPipeline pipeline;
} shade_gpu;

/* specialization may be NULL. */
static inline void shade_gpu_make_pipeline(const VkSpecializationInfo *specialization)
{
	const VkComputePipelineCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
		.stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
	              .stage = VK_SHADER_STAGE_COMPUTE_BIT,
	              .module = shade_gpu.code,
	              .pName = "main",
	              .pSpecializationInfo = specialization},
		.layout = shade_gpu.layout,
	};
	VkDevice device = shade_gpu.device->gpu->device;
	vkDestroyPipeline(device, shade_gpu.pipeline, NULL);
	assert_int_equal(vkCreateComputePipelines(device, VK_NULL_HANDLE, 1, &info, NULL, &shade_gpu.pipeline), VK_SUCCESS);
}

static inline void shade_gpu_load_code(const uint32_t *words, size_t size)
{
	VkDevice device = shade_gpu.device->gpu->device;
	const VkPushConstantRange range = {VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(shade_gpu_push)};
	const VkPipelineLayoutCreateInfo layout = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
		.pushConstantRangeCount = 1,
		.pPushConstantRanges = &range,
	};
	const VkShaderModuleCreateInfo code = {
		.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
		.codeSize = size,
		.pCode = words,
	};
	assert_int_equal(vkCreatePipelineLayout(device, &layout, NULL, &shade_gpu.layout), VK_SUCCESS);
	assert_int_equal(vkCreateShaderModule(device, &code, NULL, &shade_gpu.code), VK_SUCCESS);
}

static inline void shade_gpu_fill_inputs(void)
{
	float *input = shade_gpu.inputs.mapped;
	for (uint64_t i = 0; i < 8 * (uint64_t)SHADE_GPU_COUNT; i++)
		input[i] = stilb_random_float(3, i);
	for (int corner = 0; corner < SHADE_PROOF_CORNERS; corner++)
		for (int k = 0; k < 8; k++)
			input[8 * corner + k] = shade_proof_corner(corner, k);
}

/* Device, buffers and code; the pipeline is the test's to make. */
static inline void shade_gpu_start(const uint32_t *words, size_t size)
{
	stilb_render_desc desc = {.width = 1, .height = 1, .samples = 1, .context_count = 1, .validate = true};
	const VkBufferUsageFlags usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
	const VkDeviceSize results = SHADE_GPU_COUNT * sizeof(stilb_vec4);
	if (stilb_render_create(&desc, &shade_gpu.render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	shade_gpu.device = (vulkan_device *)shade_gpu.render->device;
	assert_int_equal(
		gpu_vulkan_buffer_create(shade_gpu.device->gpu, 2 * results, usage, STILB_GPU_MEMORY_WRITE, &shade_gpu.inputs),
		STILB_OK);
	assert_int_equal(
		gpu_vulkan_buffer_create(shade_gpu.device->gpu, results, usage, STILB_GPU_MEMORY_READ, &shade_gpu.results),
		STILB_OK);
	shade_gpu_fill_inputs();
	shade_gpu_load_code(words, size);
}

static inline int shade_gpu_end(void **state)
{
	(void)state;
	VkDevice device = shade_gpu.device->gpu->device;
	vkDestroyPipeline(device, shade_gpu.pipeline, NULL);
	vkDestroyShaderModule(device, shade_gpu.code, NULL);
	vkDestroyPipelineLayout(device, shade_gpu.layout, NULL);
	gpu_vulkan_buffer_destroy(shade_gpu.device->gpu, &shade_gpu.inputs);
	gpu_vulkan_buffer_destroy(shade_gpu.device->gpu, &shade_gpu.results);
	stilb_render_destroy(shade_gpu.render);
	return 0;
}

/* Runs the pipeline and waits for the results. */
static inline void shade_gpu_run(int32_t row)
{
	VkCommandBuffer commands = shade_gpu.device->gpu->slots[0].draw;
	const VkCommandBufferBeginInfo begin = {
		.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
		.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT,
	};
	const VkMemoryBarrier2 barrier = {
		.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
		.srcStageMask = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
		.srcAccessMask = VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
		.dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT,
		.dstAccessMask = VK_ACCESS_2_HOST_READ_BIT,
	};
	const VkDependencyInfo dependency = {
		.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1, .pMemoryBarriers = &barrier};
	shade_gpu_push values = {shade_gpu.inputs.address, shade_gpu.results.address, row, SHADE_GPU_COUNT};
	memset(shade_gpu.results.mapped, 0xff, SHADE_GPU_COUNT * sizeof(stilb_vec4)); /* NaN: what is not written fails */
	vkResetCommandPool(shade_gpu.device->gpu->device, shade_gpu.device->gpu->slots[0].pool, 0);
	vkBeginCommandBuffer(commands, &begin);
	vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, shade_gpu.pipeline);
	vkCmdPushConstants(commands, shade_gpu.layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof values, &values);
	vkCmdDispatch(commands, (SHADE_GPU_COUNT + SHADE_GPU_GROUP - 1) / SHADE_GPU_GROUP, 1, 1);
	vkCmdPipelineBarrier2(commands, &dependency);
	assert_int_equal(vkEndCommandBuffer(commands), VK_SUCCESS);
	assert_int_equal(gpu_vulkan_queue_submit(shade_gpu.device->gpu, commands, VK_NULL_HANDLE, VK_NULL_HANDLE),
	                 STILB_OK);
	assert_int_equal(gpu_vulkan_timeline_wait(shade_gpu.device->gpu, shade_gpu.device->gpu->timeline_value), STILB_OK);
}

/* What the shader computes, in C: the result for the eight numbers of one input. row: the test's own integer. */
typedef stilb_vec4 shade_gpu_function(int row, stilb_vec4 a, stilb_vec4 b);

/* The largest of |gpu - c| / max(relative |c|, absolute): at most 1. where: the input and the lane it was seen at. */
static inline double shade_gpu_worst(shade_gpu_function *c, int row, double relative, double absolute, size_t where[2])
{
	const float *in = shade_gpu.inputs.mapped, *out = shade_gpu.results.mapped;
	double worst = 0.0;
	for (size_t i = 0; i < SHADE_GPU_COUNT; i++, in += 8, out += 4) {
		stilb_vec4 want = c(row, (stilb_vec4){in[0], in[1], in[2], in[3]}, (stilb_vec4){in[4], in[5], in[6], in[7]});
		for (size_t k = 0; k < 4; k++) {
			double difference = fabs((double)out[k] - (double)want[k]);
			double share = difference == 0.0 ? 0.0 : difference / fmax(relative * fabs((double)want[k]), absolute);
			if (share <= worst)
				continue;
			worst = share; /* NaN comes here too, and stays */
			where[0] = i;
			where[1] = k;
			if (isnan(share))
				return share;
		}
	}
	return worst;
}

/* What was seen at shade_gpu_worst's place. */
static inline void shade_gpu_print_worst(shade_gpu_function *c, int row, const size_t where[2])
{
	const float *in = (const float *)shade_gpu.inputs.mapped + 8 * where[0], *out = shade_gpu.results.mapped;
	stilb_vec4 want = c(row, (stilb_vec4){in[0], in[1], in[2], in[3]}, (stilb_vec4){in[4], in[5], in[6], in[7]});
	printf("  TOO FAR: lane %zu of", where[1]);
	for (int k = 0; k < 8; k++)
		printf(" %.9g", (double)in[k]);
	printf(" is %.9g on the GPU, %.9g in C\n", (double)out[4 * where[0] + where[1]], (double)want[where[1]]);
}

static inline void shade_gpu_layer_said_nothing(void **state)
{
	(void)state;
	assert_int_equal(stilb_render_validation_messages(shade_gpu.render), 0);
}

static inline bool shade_gpu_present(void)
{
	stilb_gpu_listed one;
	uint32_t count;
	if (stilb_gpu_list(&one, 1, &count) == STILB_OK && count > 0)
		return true;
	printf("skipped: no Vulkan driver (apt install mesa-vulkan-drivers)\n");
	return false;
}

#endif
