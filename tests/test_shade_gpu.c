/* Every shading function on the GPU against the same text compiled as C: each row of shade_cases.h on many inputs, within
 * the bound that stands beside it; and every word of the dialect. */
#include "render/vulkan/vulkan_internal.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "shade_cases.h"

static const uint32_t shade_gpu[] =
#include "shade_gpu.comp.inc"
	;

#define COUNT 20000u
#define GROUP 64u

typedef struct push {
	VkDeviceAddress inputs, results;
	int32_t row;
	uint32_t count;
	float zero;
} push;

typedef struct harness {
	stilb_render *render; /* for its device and its memory */
	vulkan_device *device;
	vulkan_buffer inputs, results; /* 2 * COUNT and COUNT vec4 */
	VkPipelineLayout layout;
	VkPipeline pipeline;
} harness;

static harness gpu;

static void make_pipeline(void)
{
	VkDevice device = gpu.device->device;
	const VkPushConstantRange range = {VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(push)};
	const VkPipelineLayoutCreateInfo layout = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
		.pushConstantRangeCount = 1,
		.pPushConstantRanges = &range,
	};
	const VkShaderModuleCreateInfo code = {
		.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
		.codeSize = sizeof shade_gpu,
		.pCode = shade_gpu,
	};
	VkShaderModule module;
	assert_int_equal(vkCreatePipelineLayout(device, &layout, NULL, &gpu.layout), VK_SUCCESS);
	assert_int_equal(vkCreateShaderModule(device, &code, NULL, &module), VK_SUCCESS);
	const VkComputePipelineCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
		.stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
	              .stage = VK_SHADER_STAGE_COMPUTE_BIT,
	              .module = module,
	              .pName = "main"},
		.layout = gpu.layout,
	};
	assert_int_equal(vkCreateComputePipelines(device, VK_NULL_HANDLE, 1, &info, NULL, &gpu.pipeline), VK_SUCCESS);
	vkDestroyShaderModule(device, module, NULL);
}

static void fill_inputs(void)
{
	float *input = gpu.inputs.mapped;
	for (uint64_t i = 0; i < 8 * (uint64_t)COUNT; i++)
		input[i] = stilb_random_float(3, i);
	memset(input, 0, 8 * sizeof *input); /* corners of the range */
	for (int i = 8; i < 16; i++)
		input[i] = 0.99999994f;
}

static int start(void **state)
{
	(void)state;
	const stilb_render_desc desc = {.width = 1, .height = 1, .samples = 1, .context_count = 1, .validate = true};
	const VkBufferUsageFlags usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
	if (stilb_render_create(&desc, &gpu.render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	gpu.device = (vulkan_device *)gpu.render->device;
	const VkDeviceSize size = COUNT * sizeof(stilb_vec4);
	assert_int_equal(vulkan_buffer_create(gpu.device, 2 * size, usage, VULKAN_MEMORY_WRITE, &gpu.inputs), STILB_OK);
	assert_int_equal(vulkan_buffer_create(gpu.device, size, usage, VULKAN_MEMORY_READBACK, &gpu.results), STILB_OK);
	fill_inputs();
	make_pipeline();
	return 0;
}

static int end(void **state)
{
	(void)state;
	vkDestroyPipeline(gpu.device->device, gpu.pipeline, NULL);
	vkDestroyPipelineLayout(gpu.device->device, gpu.layout, NULL);
	vulkan_buffer_destroy(gpu.device, &gpu.inputs);
	vulkan_buffer_destroy(gpu.device, &gpu.results);
	stilb_render_destroy(gpu.render);
	return 0;
}

static void the_layer_said_nothing(void **state)
{
	(void)state;
	assert_int_equal(stilb_render_validation_messages(gpu.render), 0);
}

static void run(int32_t row)
{
	VkCommandBuffer commands = gpu.device->slots[0].draw;
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
	const push values = {gpu.inputs.address, gpu.results.address, row, COUNT, 0.0f};
	memset(gpu.results.mapped, 0xff, COUNT * sizeof(stilb_vec4)); /* NaN: what is not written fails */
	vkResetCommandPool(gpu.device->device, gpu.device->slots[0].pool, 0);
	vkBeginCommandBuffer(commands, &begin);
	vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, gpu.pipeline);
	vkCmdPushConstants(commands, gpu.layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof values, &values);
	vkCmdDispatch(commands, (COUNT + GROUP - 1) / GROUP, 1, 1);
	vkCmdPipelineBarrier2(commands, &dependency);
	assert_int_equal(vkEndCommandBuffer(commands), VK_SUCCESS);
	assert_int_equal(vulkan_queue_submit(gpu.device, commands, VK_NULL_HANDLE, VK_NULL_HANDLE), STILB_OK);
	assert_int_equal(vulkan_timeline_wait(gpu.device, gpu.device->timeline_value), STILB_OK);
}

/* The largest difference in units of max(1, |C's answer|). */
static double worst_difference(int32_t row)
{
	const float *in = gpu.inputs.mapped, *out = gpu.results.mapped;
	double worst = 0.0;
	for (size_t i = 0; i < COUNT; i++, in += 8, out += 4) {
		stilb_vec4 a = {in[0], in[1], in[2], in[3]}, b = {in[4], in[5], in[6], in[7]};
		stilb_vec4 want = shade_case(row, a, b);
		int lanes = row == 2 || row == 3 ? 4 : row == 10 ? 1 : row == 8 || row == 9 ? 2 : 3;
		for (int k = 0; k < lanes; k++) {
			double difference = fabs((double)out[k] - (double)want[k]) / fmax(1.0, fabs((double)want[k]));
			worst = difference <= worst ? worst : difference; /* NaN stays */
		}
	}
	return worst;
}

static void gpu_and_c_agree(void **state)
{
	(void)state;
	static const struct {
		const char *name;
		double bound;
	} rows[] = {
#define ROW(row, name, bound) {#name, (double)bound},
		SHADE_CASES(ROW)
#undef ROW
	};
	bool good = true;
	for (int32_t row = 0; row < SHADE_CASE_COUNT; row++) {
		run(row);
		double worst = worst_difference(row);
		bool within = worst <= rows[row].bound;
		printf("%-36s %.1e of %.0e%s\n", rows[row].name, worst, rows[row].bound, within ? "" : "  TOO FAR");
		good &= within;
	}
	assert_true(good);
}

static void every_word_answers_right(void **state)
{
	(void)state;
	run(SHADE_CASE_COUNT);
	const float *out = gpu.results.mapped;
	for (size_t i = 0; i < COUNT; i++)
		if (!(out[4 * i] == 0.0f))
			fail_msg("shade_vocabulary.h:%.0f", (double)out[4 * i]);
}

int main(void)
{
	stilb_render_gpu one;
	uint32_t count;
	if (stilb_render_gpu_list(&one, 1, &count) != STILB_OK || count == 0) {
		printf("skipped: no Vulkan driver (apt install mesa-vulkan-drivers)\n");
		return 77;
	}
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(gpu_and_c_agree),
		cmocka_unit_test(every_word_answers_right),
		cmocka_unit_test(the_layer_said_nothing),
	};
	return cmocka_run_group_tests(tests, start, end);
}
