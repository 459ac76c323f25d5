/* Inside post/cpu/. */
#ifndef POST_CPU_INTERNAL_H
#define POST_CPU_INTERNAL_H

#include "base/base_contract.h"
#include "post/cpu/post_cpu_occlusion.h"
#include "post/post_levels.h"

/* A picture between: rows without gaps. */
typedef struct cpu_picture {
	post_texel *texels;
	uint32_t width, height;
} cpu_picture;

struct post_cpu {
	const post_cpu_rows *rows;
	const occlusion_rows *occlusion;
	stilb_job_pool *pool;
	uint32_t width, height;
	post_levels levels;
	cpu_picture halved[POST_LEVELS]; /* of bloom, in `texels` */
	post_texel *texels, *halves;     /* of all levels; the images of occlusion */
	post_texel *scratch;             /* four rows of the picture for each thread */
	size_t texel_capacity, half_capacity, scratch_capacity;
	uint16_t *light; /* of the call of post_cpu_bloom */
};

/* Calls rows for all rows of a picture, on the threads that there are. */
void post_cpu_loop(const post_cpu *cpu, stilb_job_range_fn *rows, uint32_t width, uint32_t height, void *context);

/* Of rows of the images of occlusion: floats, margins included. */
static inline uint32_t post_cpu_occlusion_stride(uint32_t width)
{
	uint32_t lanes = OCCLUSION_LANES - 1;
	return (((width + 1) / 2 + lanes) & ~lanes) + 2 * OCCLUSION_MARGIN;
}

/* Floats of all three. */
static inline size_t post_cpu_occlusion_floats(uint32_t width, uint32_t height)
{
	return (size_t)3 * post_cpu_occlusion_stride(width) * ((height + 1) / 2);
}

#endif
