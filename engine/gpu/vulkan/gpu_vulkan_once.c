/* Pipelines that several threads may need at once: each is made by one of them. */
#include "gpu/vulkan/gpu_vulkan_internal.h"

VkResult gpu_vulkan_once_create(gpu_vulkan *gpu)
{
	if (pthread_mutex_init(&gpu->pipelines_lock, NULL) != 0)
		return VK_ERROR_OUT_OF_HOST_MEMORY;
	gpu->pipelines_lock_made = pthread_cond_init(&gpu->pipelines_made, NULL) == 0;
	if (!gpu->pipelines_lock_made)
		pthread_mutex_destroy(&gpu->pipelines_lock);
	return gpu->pipelines_lock_made ? VK_SUCCESS : VK_ERROR_OUT_OF_HOST_MEMORY;
}

void gpu_vulkan_once_destroy(gpu_vulkan *gpu)
{
	if (!gpu->pipelines_lock_made)
		return;
	pthread_cond_destroy(&gpu->pipelines_made);
	pthread_mutex_destroy(&gpu->pipelines_lock);
	gpu->pipelines_lock_made = false;
}

VkResult gpu_vulkan_pipeline_once(gpu_vulkan *gpu, gpu_vulkan_pipeline *pipeline, gpu_vulkan_make_fn *make, void *user,
                                  const void *what)
{
	pthread_mutex_lock(&gpu->pipelines_lock);
	if (pipeline->making) {
		PROFILE("wait for a pipeline");
		while (pipeline->making)
			pthread_cond_wait(&gpu->pipelines_made, &gpu->pipelines_lock);
	}
	bool missing = !pipeline->handle;
	pipeline->making = missing;
	pthread_mutex_unlock(&gpu->pipelines_lock);
	if (!missing)
		return VK_SUCCESS;
	VkPipeline made = VK_NULL_HANDLE;
	VkResult result;
	{
		PROFILE("make a pipeline");
		result = make(user, what, &made);
	}
	pthread_mutex_lock(&gpu->pipelines_lock);
	pipeline->handle = result == VK_SUCCESS ? made : VK_NULL_HANDLE;
	pipeline->making = false;
	pthread_cond_broadcast(&gpu->pipelines_made);
	pthread_mutex_unlock(&gpu->pipelines_lock);
	return result;
}
