/* Inside post/: the chain's state, and the rows that all effects are made of. */
#ifndef POST_INTERNAL_H
#define POST_INTERNAL_H

#include "base/base_contract.h"
#include "post/cpu/post_cpu.h"
#include "post/post.h"

#define POST_BLOOM_DEFAULT_WIDTH 0.6f
#define POST_OCCLUSION_DEFAULT_RADIUS 1.0f /* metres */

typedef enum post_program {
	POST_BLOOM_HALVE_FIRST, /* the frame's light, which may hold anything */
	POST_BLOOM_HALVE,
	POST_BLOOM_DOUBLE,
	POST_BLOOM_ADD,
	POST_OCCLUSION,
	POST_OCCLUSION_SMOOTH,
	POST_OCCLUSION_APPLY,
	POST_PROGRAMS
} post_program;

/* Images that the CPU works on. */
typedef enum post_mapped { POST_MAPPED_LIGHT, POST_MAPPED_AMBIENT, POST_MAPPED_DEPTH, POST_MAPPED } post_mapped;

struct stilb_post {
	stilb_render *render;
	stilb_post_settings settings;
	float exposure;       /* stops */
	bool sees;            /* from_clip is there */
	stilb_mat4 from_clip; /* to the world's directions, around the camera */
	stilb_gpu_sampler linear;
	post_cpu *cpu; /* NULL: nothing was computed by the CPU yet */
	stilb_job_pool *pool;
	stilb_gpu_buffer mapped[POST_MAPPED]; /* images while the CPU works on them */
	uint64_t mapped_bytes[POST_MAPPED];
	stilb_gpu_program programs[STILB_POST_BLOOM_FORMATS_COUNT][POST_PROGRAMS];
};

extern const stilb_gpu_shader post_shader_bloom_halve, post_shader_bloom_double, post_shader_bloom_add;
extern const stilb_gpu_shader post_shader_occlusion, post_shader_occlusion_smooth, post_shader_occlusion_apply;

/* The program of this number, made when it is first asked for; of bloom in this format. Constant 0 of bloom's shaders
 * is whether it is FIXED, 1 of the one that halves whether it is the first. */
stilb_result post_program_get(stilb_post *post, stilb_post_bloom_format format, post_program number,
                              stilb_gpu_program *program);

/* Adds occlusion's rows, and puts the image with it in the place of *ambient. */
stilb_result post_occlusion_add(stilb_post *post, stilb_gpu_plan *plan, uint16_t *ambient, uint16_t depth);

/* Likewise, for the CPU's threads. */
stilb_result post_host_bloom_add(stilb_post *post, stilb_gpu_plan *plan, uint16_t *light);
stilb_result post_host_occlusion_add(stilb_post *post, stilb_gpu_plan *plan, uint16_t *ambient, uint16_t depth);

/* Adds bloom's rows, and puts the image with it in the place of *light. */
stilb_result post_bloom_add(stilb_post *post, stilb_gpu_plan *plan, uint16_t *light);

#endif
