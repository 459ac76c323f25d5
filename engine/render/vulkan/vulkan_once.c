/* Pipelines that several threads may need at once: each is made by one of them. */
#include "render/vulkan/vulkan_internal.h"

VkResult vulkan_pipeline_once(vulkan_device *device, vulkan_pipeline *pipeline, vulkan_make_fn *make, const void *what)
{
	pthread_mutex_lock(&device->pipelines_lock);
	if (pipeline->making) {
		PROFILE("wait for a pipeline");
		while (pipeline->making)
			pthread_cond_wait(&device->pipelines_made, &device->pipelines_lock);
	}
	bool missing = !pipeline->handle;
	pipeline->making = missing;
	pthread_mutex_unlock(&device->pipelines_lock);
	if (!missing)
		return VK_SUCCESS;
	VkPipeline made = VK_NULL_HANDLE;
	VkResult result;
	{
		PROFILE("make a pipeline");
		result = make(device, what, &made);
	}
	pthread_mutex_lock(&device->pipelines_lock);
	pipeline->handle = result == VK_SUCCESS ? made : VK_NULL_HANDLE;
	pipeline->making = false;
	pthread_cond_broadcast(&device->pipelines_made);
	pthread_mutex_unlock(&device->pipelines_lock);
	return result;
}
