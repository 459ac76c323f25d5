/* Stands in for the Vulkan device, so that tests of the null device load no library of others. */
#include "gpu/gpu_internal.h"

stilb_result gpu_vulkan_open(const stilb_gpu_desc *desc, stilb_gpu **gpu)
{
	(void)desc, (void)gpu;
	return stilb_fail(STILB_ERROR_DEVICE, "no Vulkan in this test");
}
