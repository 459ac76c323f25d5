/* The device and memory of plain Vulkan programs. */
#include "bench/subjects/vulkan_bare.h"

#include "bench/harness/bench_child.h"

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
		.shaderOutputLayer = VK_TRUE,
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

bare_buffer bare_make_buffer(bare *b, VkDeviceSize size, VkBufferUsageFlags usage)
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

void bare_free_buffer(bare *b, bare_buffer *buffer)
{
	vkDestroyBuffer(b->device, buffer->buffer, NULL);
	vkFreeMemory(b->device, buffer->memory, NULL);
}

VkDeviceMemory bare_image_memory(bare *b, VkImage image)
{
	VkMemoryRequirements needs;
	vkGetImageMemoryRequirements(b->device, image, &needs);
	VkDeviceMemory memory = allocate(b, needs, false);
	bare_check(vkBindImageMemory(b->device, image, memory, 0), "vkBindImageMemory");
	return memory;
}

bare_image bare_make_image(bare *b, uint32_t width, uint32_t height, VkFormat format, VkImageUsageFlags usage,
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
	bare_check(vkCreateImage(b->device, &info, NULL, &made.image), "vkCreateImage");
	made.memory = bare_image_memory(b, made.image);
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

void bare_free_image(bare *b, bare_image *image)
{
	vkDestroyImageView(b->device, image->view, NULL);
	vkDestroyImage(b->device, image->image, NULL);
	vkFreeMemory(b->device, image->memory, NULL);
}
