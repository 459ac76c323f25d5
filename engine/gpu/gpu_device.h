/*
 * gpu: which devices there are, the window that one draws to, and the errors that tests ask it for.
 */
#ifndef STILB_GPU_DEVICE_H
#define STILB_GPU_DEVICE_H

#include "base/base.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

typedef enum stilb_gpu_kind { STILB_GPU_KIND_VULKAN, STILB_GPU_KIND_NULL } stilb_gpu_kind;

/* How pictures get to the window's screen. A mode that the window does not offer becomes FIFO, and is named once in the
 * log. */
typedef enum stilb_gpu_presentation {
	STILB_GPU_PRESENT_FIFO,      /* one for each refresh of the screen, in order; always there */
	STILB_GPU_PRESENT_MAILBOX,   /* the newest at each refresh: nobody waits, nothing tears */
	STILB_GPU_PRESENT_IMMEDIATE, /* at once: the least delay, and pictures tear */
} stilb_gpu_presentation;

/* A window, as two functions that hide both the window system and Vulkan's types. */
typedef struct stilb_gpu_surface {
	void *user;
	const char *const *(*extensions)(void *user, uint32_t *count);    /* Vulkan instance extensions that it needs */
	int32_t (*create)(void *user, void *instance, uint64_t *surface); /* surface of a VkInstance; returns a VkResult */
} stilb_gpu_surface;

/* Errors that a device makes on purpose, for tests. Counted from 1; 0: none. */
typedef struct stilb_gpu_faults {
	uint32_t allocation;   /* the n-th allocation of device memory fails */
	uint32_t lost_frame;   /* the device is lost when its n-th frame is submitted */
	uint32_t surface_lost; /* the window's surface is lost when the n-th frame is shown */
	uint32_t image_side;   /* no larger images, but for those that are drawn into; 0: the device's own limit */
} stilb_gpu_faults;

/* A GPU of this machine. */
typedef struct stilb_gpu_listed {
	char name[256];
	char driver[256];     /* name and version as the driver gives them */
	char api_version[32]; /* "1.3.230" */
	const char *type;     /* "discrete GPU", "integrated GPU", "virtual GPU", "software", "other" */
	const char *missing;  /* NULL: it can run Stilb; else the first feature that it lacks */
	bool bc;              /* stilb_gpu_limits.bc */
} stilb_gpu_listed;

/* The version that the Vulkan loader offers: "1.3.239". In a static buffer. [main-thread] */
const char *stilb_gpu_vulkan_version(void);

/* Lists up to capacity GPUs in the order of --gpu numbers. *count may be 0. STILB_ERROR_MEMORY: a driver cannot be
 * loaded for want of memory. STILB_ERROR_DEVICE: no Vulkan driver at all. [any-thread] */
stilb_result stilb_gpu_list(stilb_gpu_listed *gpus, uint32_t capacity, uint32_t *count);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
