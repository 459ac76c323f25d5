/* gpu: what all devices have. For engine/gpu, and for now for engine/render's Vulkan device. */
#ifndef STILB_GPU_INTERNAL_H
#define STILB_GPU_INTERNAL_H

#include "gpu/gpu.h"

#include <stdatomic.h>

struct stilb_gpu {
	char name[256];
	bool software, in_window;
	stilb_gpu_presentation presentation; /* the one in use */
	uint32_t validation_messages;
	stilb_gpu_faults faults;
	_Atomic uint32_t allocations; /* made so far. Relaxed: a counter that orders nothing; any thread allocates */
	uint32_t frames;              /* submitted so far */
	double gpu_ms;                /* of the last frame whose time is known */
};

/* Counts an allocation of the device; true if it must fail (stilb_gpu_faults). [any-thread] */
bool gpu_fault_allocation(stilb_gpu *gpu);
/* True if the device must be lost with the frame that is submitted now (stilb_gpu_faults). */
bool gpu_fault_lost(const stilb_gpu *gpu);
/* True if the window's surface must be lost now that the submitted frame is shown; once (stilb_gpu_faults). */
bool gpu_fault_surface(stilb_gpu *gpu);

#endif
