/* Effects on jobs: parallel loops over the rows of each of their images. */
#include "post/cpu/post_cpu_internal.h"

#include <stdlib.h>

#define CPU_PIXELS 4096u /* of a slice of a loop, some */

stilb_result post_cpu_create(post_cpu **cpu)
{
	post_cpu *made = calloc(1, sizeof *made);
	*cpu = made;
	if (!made)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for effects on the CPU");
	made->rows = &post_cpu_rows_scalar;
	made->occlusion = &post_cpu_occlusion_plain;
	stilb_cpu_features has = stilb_cpu_query();
#if defined(__x86_64__)
	if (has.f16c)
		made->rows = &post_cpu_rows_f16c;
#endif
	if (has.avx2 && post_cpu_occlusion_avx2)
		made->occlusion = post_cpu_occlusion_avx2;
	return STILB_OK;
}

void post_cpu_destroy(post_cpu *cpu)
{
	if (!cpu)
		return;
	free(cpu->texels);
	free(cpu->scratch);
	free(cpu->halves);
	free(cpu);
}

/* ---- memory ------------------------------------------------------------------------------------------------------ */

static uint32_t cpu_threads(stilb_job_pool *pool)
{
	return pool ? stilb_job_pool_worker_count(pool) + 1 : 1;
}

/* Makes *texels at least so large; what was there is lost. */
static bool cpu_reserve(post_texel **texels, size_t *capacity, size_t count)
{
	if (count <= *capacity)
		return true;
	post_texel *made = aligned_alloc(64, (count * sizeof *made + 63) & ~(size_t)63);
	if (!made)
		return false;
	free(*texels);
	*texels = made;
	*capacity = count;
	return true;
}

stilb_result post_cpu_fit(post_cpu *cpu, uint32_t width, uint32_t height, stilb_job_pool *pool)
{
	post_levels levels = post_levels_of(width, height);
	size_t count = 0, halves = post_cpu_occlusion_floats(width, height) / 4 + 1;
	for (uint32_t l = 0; l < levels.count; l++)
		count += (size_t)levels.sizes[l][0] * levels.sizes[l][1];
	if (!cpu_reserve(&cpu->texels, &cpu->texel_capacity, count) ||
	    !cpu_reserve(&cpu->halves, &cpu->half_capacity, halves) ||
	    !cpu_reserve(&cpu->scratch, &cpu->scratch_capacity, (size_t)4 * width * cpu_threads(pool)))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for effects on %u x %u pixels; make the picture smaller",
		                  width, height);
	cpu->pool = pool;
	cpu->width = width;
	cpu->height = height;
	cpu->levels = levels;
	post_texel *texels = cpu->texels;
	for (uint32_t l = 0; l < levels.count; l++) {
		cpu->halved[l] = (cpu_picture){texels, levels.sizes[l][0], levels.sizes[l][1]};
		texels += (size_t)levels.sizes[l][0] * levels.sizes[l][1];
	}
	return STILB_OK;
}

/* ---- loops ------------------------------------------------------------------------------------------------------ */

void post_cpu_loop(const post_cpu *cpu, stilb_job_range_fn *rows, uint32_t width, uint32_t height, void *context)
{
	uint32_t grain = CPU_PIXELS / width + 1;
	if (cpu->pool)
		stilb_job_parallel_for(cpu->pool, height, grain, rows, context, 0);
	else
		rows(0, height, 0, context);
}
