/* The type of memory that a buffer gets from a GPU with several. The test stands in for the driver. */
#include "gpu/vulkan/gpu_vulkan_internal.h"
#include "support/test.h"

#define LOCAL VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT
#define MAPPED (VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT)
#define CACHED VK_MEMORY_PROPERTY_HOST_CACHED_BIT

enum {
	GPU,
	CPU,
	CPU_CACHED,
	BAR,
	TYPES
}; /* as a discrete GPU has them; BAR: the part of its memory that the CPU maps */

static gpu_vulkan gpu = {
	.base.name = "Testcard",
	.memory = {.memoryTypeCount = TYPES,
               .memoryTypes = {{.propertyFlags = LOCAL},
                               {.propertyFlags = MAPPED},
                               {.propertyFlags = MAPPED | CACHED},
                               {.propertyFlags = LOCAL | MAPPED}}},
};

/* ---- the driver -------------------------------------------------------------------------------------------------- */

static uint32_t allowed;  /* types that the buffer may have, a bit each */
static uint32_t full;     /* types without free memory, a bit each */
static uint32_t tried[8]; /* [tries], types in the order in which memory was asked for */
static uint32_t tries;
static uint64_t mapped_here; /* stands for the mapped memory */

VkResult vkCreateBuffer(VkDevice d, const VkBufferCreateInfo *info, const VkAllocationCallbacks *a, VkBuffer *buffer)
{
	(void)d, (void)info, (void)a;
	*buffer = (VkBuffer)&allowed;
	return VK_SUCCESS;
}

void vkGetBufferMemoryRequirements(VkDevice d, VkBuffer buffer, VkMemoryRequirements *needs)
{
	(void)d, (void)buffer;
	*needs = (VkMemoryRequirements){.size = 256, .alignment = 16, .memoryTypeBits = allowed};
}

VkResult vkAllocateMemory(VkDevice d, const VkMemoryAllocateInfo *info, const VkAllocationCallbacks *a,
                          VkDeviceMemory *memory)
{
	(void)d, (void)a;
	assert_in_range(tries, 0, 7);
	tried[tries++] = info->memoryTypeIndex;
	if (full & (1u << info->memoryTypeIndex))
		return VK_ERROR_OUT_OF_DEVICE_MEMORY;
	*memory = (VkDeviceMemory)&full;
	return VK_SUCCESS;
}

VkResult vkBindBufferMemory(VkDevice d, VkBuffer buffer, VkDeviceMemory memory, VkDeviceSize offset)
{
	(void)d, (void)buffer, (void)memory, (void)offset;
	return VK_SUCCESS;
}

VkResult vkMapMemory(VkDevice d, VkDeviceMemory memory, VkDeviceSize offset, VkDeviceSize size, VkMemoryMapFlags flags,
                     void **mapped)
{
	(void)d, (void)memory, (void)offset, (void)size, (void)flags;
	*mapped = &mapped_here;
	return VK_SUCCESS;
}

void vkDestroyBuffer(VkDevice d, VkBuffer buffer, const VkAllocationCallbacks *a)
{
	(void)d, (void)buffer, (void)a;
}

void vkFreeMemory(VkDevice d, VkDeviceMemory memory, const VkAllocationCallbacks *a)
{
	(void)d, (void)memory, (void)a;
}

/* ---- tests ------------------------------------------------------------------------------------------------------- */

static stilb_result buffer_of(stilb_gpu_memory kind, uint32_t allowed_types, uint32_t full_types)
{
	gpu_vulkan_buffer buffer;
	allowed = allowed_types;
	full = full_types;
	tries = 0;
	assert_int_equal(gpu_vulkan_memory_create(&gpu), VK_SUCCESS);
	stilb_result result = gpu_vulkan_buffer_create(&gpu, 256, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, kind, &buffer);
	assert_true(result != STILB_OK || !buffer.mapped == (kind == STILB_GPU_MEMORY_DEVICE));
	gpu_vulkan_buffer_destroy(&gpu, &buffer);
	gpu_vulkan_memory_destroy(&gpu);
	return result;
}

#define BIT(type) (1u << (type))
#define ANY (BIT(TYPES) - 1)

static void each_use_gets_its_memory(void **state)
{
	(void)state;
	static const struct {
		stilb_gpu_memory kind;
		uint32_t allowed, type;
	} uses[] = {
		{STILB_GPU_MEMORY_DEVICE, ANY, GPU},
		{STILB_GPU_MEMORY_WRITE, ANY, BAR},
		{STILB_GPU_MEMORY_SHARED, ANY, CPU_CACHED},
		{STILB_GPU_MEMORY_READ, ANY, CPU_CACHED},
		/* The best type that the buffer may have, and that the CPU can map if it is to. */
		{STILB_GPU_MEMORY_DEVICE, BIT(CPU) | BIT(CPU_CACHED), CPU},
		{STILB_GPU_MEMORY_WRITE, BIT(GPU) | BIT(CPU), CPU},
		{STILB_GPU_MEMORY_READ, BIT(GPU) | BIT(BAR), BAR},
	};
	for (size_t i = 0; i < sizeof uses / sizeof *uses; i++) {
		assert_int_equal(buffer_of(uses[i].kind, uses[i].allowed, 0), STILB_OK);
		assert_int_equal(tries, 1);
		assert_int_equal(tried[0], uses[i].type);
	}
}

static void the_next_best_is_taken_when_one_is_full(void **state)
{
	(void)state;
	assert_int_equal(buffer_of(STILB_GPU_MEMORY_WRITE, ANY, BIT(BAR)), STILB_OK);
	assert_int_equal(tries, 2);
	assert_int_equal(tried[0], BAR);
	assert_int_equal(tried[1], CPU);
	/* Never memory that the CPU cannot map. */
	assert_int_equal(buffer_of(STILB_GPU_MEMORY_WRITE, ANY, BIT(CPU) | BIT(CPU_CACHED) | BIT(BAR)), STILB_ERROR_MEMORY);
	assert_int_equal(tries, 3);
	assert_int_equal(buffer_of(STILB_GPU_MEMORY_WRITE, BIT(GPU), 0), STILB_ERROR_MEMORY);
	assert_int_equal(tries, 0);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(each_use_gets_its_memory),
		cmocka_unit_test(the_next_best_is_taken_when_one_is_full),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
