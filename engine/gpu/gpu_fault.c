/* gpu: errors that devices make on purpose. */
#include "gpu/gpu_internal.h"

bool gpu_fault_allocation(stilb_gpu *gpu)
{
	/* Relaxed: see stilb_gpu.allocations. */
	return atomic_fetch_add_explicit(&gpu->allocations, 1, memory_order_relaxed) + 1 == gpu->faults.allocation;
}

bool gpu_fault_lost(const stilb_gpu *gpu)
{
	return gpu->frames == gpu->faults.lost_frame && gpu->faults.lost_frame > 0;
}

bool gpu_fault_surface(stilb_gpu *gpu)
{
	bool lost = gpu->frames == gpu->faults.surface_lost && gpu->faults.surface_lost > 0;
	if (lost)
		gpu->faults.surface_lost = 0;
	return lost;
}
