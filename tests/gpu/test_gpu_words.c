/* Messages about GPUs and their errors. The test needs no driver. */
#include "gpu/vulkan/gpu_vulkan_internal.h"
#include "support/test.h"

#include <string.h>

static void every_kind_of_gpu_has_its_word(void **state)
{
	(void)state;
	static const struct {
		VkPhysicalDeviceType type;
		const char *text;
	} kinds[] = {
		{VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU, "discrete GPU"},
		{VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU, "integrated GPU"},
		{VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU, "virtual GPU"},
		{VK_PHYSICAL_DEVICE_TYPE_CPU, "software"},
		{VK_PHYSICAL_DEVICE_TYPE_OTHER, "other"},
		{(VkPhysicalDeviceType)1000, "other"}, /* a kind from a newer driver than this program */
	};
	for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
		assert_string_equal(gpu_vulkan_gpu_type_text(kinds[i].type), kinds[i].text);
}

static void errors_have_a_result_a_name_and_a_way_out(void **state)
{
	(void)state;
	static const struct {
		VkResult error;
		stilb_result result;
		const char *text;
	} errors[] = {
		{VK_ERROR_OUT_OF_HOST_MEMORY, STILB_ERROR_MEMORY,
	     "cannot draw: out of memory (VK_ERROR_OUT_OF_HOST_MEMORY -1); try fewer models or a smaller --size"},
		{VK_ERROR_OUT_OF_DEVICE_MEMORY, STILB_ERROR_MEMORY,
	     "cannot draw: out of memory (VK_ERROR_OUT_OF_DEVICE_MEMORY -2); try fewer models or a smaller --size"},
		{VK_ERROR_FEATURE_NOT_PRESENT, STILB_ERROR_DEVICE,
	     "cannot draw: device error (VK_ERROR_FEATURE_NOT_PRESENT -8)"},
		{VK_ERROR_SURFACE_LOST_KHR, STILB_ERROR_WINDOW,
	     "cannot draw: the window or its display has gone (VK_ERROR_SURFACE_LOST_KHR -1000000000)"},
		{VK_ERROR_DEVICE_LOST, STILB_ERROR_DEVICE_LOST,
	     "cannot draw: device lost (VK_ERROR_DEVICE_LOST -4): GPU 'Testcard' was reset or its driver failed, "
	     "'dmesg' may say why; start again, or take another with --gpu"},
		{VK_ERROR_UNKNOWN, STILB_ERROR_DEVICE, "cannot draw: device error (VkResult -13)"},
	};
	static gpu_vulkan gpu = {.base.name = "Testcard"};
	for (size_t i = 0; i < sizeof errors / sizeof *errors; i++) {
		assert_int_equal(gpu_vulkan_fail(&gpu, errors[i].error, "draw"), errors[i].result);
		assert_string_equal(stilb_error_message(), errors[i].text);
	}
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(every_kind_of_gpu_has_its_word),
		cmocka_unit_test(errors_have_a_result_a_name_and_a_way_out),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
