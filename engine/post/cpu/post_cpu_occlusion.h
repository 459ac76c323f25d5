/*
 * The passes of occlusion (shaders/occlusion*.frag) for the CPU: rows of pictures, eight texels at a time, on vectors
 * of the compiler's, so that every instruction set makes the same bits of them. Inside post/cpu/.
 */
#ifndef POST_CPU_OCCLUSION_H
#define POST_CPU_OCCLUSION_H

#include "post/cpu/post_cpu.h"

#define OCCLUSION_LANES 8u
#define OCCLUSION_MARGIN 8u /* texels before and behind a row in half the size, which repeat its ends */

/* A picture's occlusion. Images in half the size have rows of `stride` floats, behind OCCLUSION_MARGIN. */
typedef struct occlusion_work {
	const float *depth; /* [width * height] as of the frame: 1 is nearest */
	uint32_t width, height, half_width, half_height, stride;
	float from_clip[16]; /* to the world's directions, around the camera */
	float radius, strength, smallest;
	float *asked, *distance, *smooth; /* [half_height * stride] visibility in half the directions; m; visibility */
} occlusion_work;

typedef struct occlusion_rows {
	/* Row y of `asked` and `distance`, with their margins. */
	void (*ask)(const occlusion_work *work, uint32_t y);
	/* Row y of `smooth`, when all of `asked` is there. */
	void (*smooth)(const occlusion_work *work, uint32_t y);
	/* shares: [width, rounded up to OCCLUSION_LANES] of ambient light that row y of the picture has. */
	void (*share)(const occlusion_work *work, uint32_t y, float *shares);
} occlusion_rows;

extern const occlusion_rows post_cpu_occlusion_plain;
extern const occlusion_rows *const post_cpu_occlusion_avx2; /* NULL: not for this architecture */

#endif
