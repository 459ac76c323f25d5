/* Occlusion on jobs: the three passes of post_occlusion.c. */
#include "post/cpu/post_cpu_internal.h"

#include "profiler/prof.h"

#include <string.h>

typedef struct occlusion_step {
	const post_cpu *cpu;
	occlusion_work work;
	uint16_t *ambient;
} occlusion_step;

static void occlusion_ask(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const occlusion_step *step = context;
	(void)worker;
	for (uint32_t y = begin; y < end; y++)
		step->cpu->occlusion->ask(&step->work, y);
}

static void occlusion_smooth(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const occlusion_step *step = context;
	(void)worker;
	for (uint32_t y = begin; y < end; y++)
		step->cpu->occlusion->smooth(&step->work, y);
}

static void occlusion_apply(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const occlusion_step *step = context;
	const post_cpu *cpu = step->cpu;
	post_texel *row = cpu->scratch + (size_t)4 * cpu->width * worker;
	float *shares = (float *)(row + cpu->width); /* of the three rows behind it */
	for (uint32_t y = begin; y < end; y++) {
		uint16_t *ambient = step->ambient + (size_t)4 * y * cpu->width;
		cpu->occlusion->share(&step->work, y, shares);
		cpu->rows->widen(ambient, cpu->width, row);
		for (uint32_t x = 0; x < cpu->width; x++)
			row[x] *= (post_texel){shares[x], shares[x], shares[x], 1.0f};
		cpu->rows->narrow(row, cpu->width, ambient);
	}
}

void post_cpu_occlusion(post_cpu *cpu, const stilb_post_settings *settings, const stilb_mat4 *from_clip,
                        const float *depth, uint16_t *ambient)
{
	PROFILE("occlusion on the CPU");
	uint32_t stride = post_cpu_occlusion_stride(cpu->width), half_height = (cpu->height + 1) / 2;
	size_t image = (size_t)stride * half_height;
	occlusion_step step = {
		.cpu = cpu,
		.work = {.depth = depth,
	             .width = cpu->width,
	             .height = cpu->height,
	             .half_width = (cpu->width + 1) / 2,
	             .half_height = half_height,
	             .stride = stride,
	             .radius = settings->occlusion_radius,
	             .strength = settings->occlusion,
	             .smallest = POST_OCCLUSION_SMALLEST,
	             .asked = (float *)cpu->halves,
	             .distance = (float *)cpu->halves + image,
	             .smooth = (float *)cpu->halves + 2 * image},
		.ambient = ambient,
	};
	STILB_ASSERT(settings->occlusion > 0.0f && settings->occlusion_radius > 0.0f && depth && ambient);
	memcpy(step.work.from_clip, from_clip->m, sizeof step.work.from_clip);
	post_cpu_loop(cpu, occlusion_ask, 8 * cpu->width, half_height, &step); /* a texel takes as long as some pixels */
	post_cpu_loop(cpu, occlusion_smooth, cpu->width, half_height, &step);
	post_cpu_loop(cpu, occlusion_apply, cpu->width, cpu->height, &step);
}
