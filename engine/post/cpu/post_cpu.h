/*
 * Effects on the CPU's own threads: what a frame's light becomes, computed by jobs and not by a device's programs. The
 * pixels are those of the programs (shaders/) but for rounding: images in between are floats here. Any number of
 * workers and any instruction set give the same bits.
 * Inside post/.
 */
#ifndef POST_CPU_H
#define POST_CPU_H

#include "jobs/job.h"
#include "post/post.h"

#define POST_OCCLUSION_SMALLEST 1e-12f /* depth that is still something: what is behind it is the backdrop */

typedef struct post_cpu post_cpu;

/* STILB_ERROR_MEMORY. */
stilb_result post_cpu_create(post_cpu **cpu);
/* Accepts NULL. */
void post_cpu_destroy(post_cpu *cpu);

/* The next picture: its size, 1..16384, and the pool whose threads help, of which the caller is the owner; NULL: the
 * caller alone. Takes the memory that effects need. STILB_ERROR_MEMORY: the picture before is the next one. */
stilb_result post_cpu_fit(post_cpu *cpu, uint32_t width, uint32_t height, stilb_job_pool *pool);

/* Bloom (post_bloom.c) of a picture of the size of post_cpu_fit: [width * height] RGBA in half floats, in place. Of the
 * settings bloom, which is above 0, and bloom_width count. */
void post_cpu_bloom(post_cpu *cpu, const stilb_post_settings *settings, uint16_t *texels);

/* Occlusion (post_occlusion.c) of such a picture: depth, 1 is nearest; ambient: RGBA in half floats, in place;
 * from_clip: of clip space to the world's directions, around the camera. Of the settings occlusion and occlusion_radius
 * count, both above 0. */
void post_cpu_occlusion(post_cpu *cpu, const stilb_post_settings *settings, const stilb_mat4 *from_clip,
                        const float *depth, uint16_t *ambient);

/* ---- rows: what differs between instruction sets ----------------------------------------------------------------- */

typedef float post_texel __attribute__((vector_size(16))); /* RGBA */

typedef struct post_cpu_rows {
	/* Half floats to floats, exactly. */
	void (*widen)(const uint16_t *from, uint32_t count, post_texel *to);
	/* Floats to the nearest half floats, ties to even; beyond 65,504 to infinity. */
	void (*narrow)(const post_texel *from, uint32_t count, uint16_t *to);
} post_cpu_rows;

extern const post_cpu_rows post_cpu_rows_scalar;
#if defined(__x86_64__)
extern const post_cpu_rows post_cpu_rows_f16c;
#endif

#endif
