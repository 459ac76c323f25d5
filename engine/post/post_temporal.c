/* Temporal antialiasing: where frames sample the scene, and the row that takes the mean of them. */
#include "post/post_internal.h"

#include "render/device/render_images.h"

#include <math.h>
#include <string.h>

/* As the shader has it. */
typedef struct temporal_push {
	float to_last[16];
	float ahead_row[4];
	float exposure, history;
} temporal_push;

/* ---- where the scene is sampled ---------------------------------------------------------------------------------- */

#define TEMPORAL_BITS 6u /* of the number of places: 64 */

/* Bit b of this number turns bits of the second dimension: column b of Sobol's matrix, the binomial coefficients modulo
 * 2, from the highest bit down. */
static uint32_t temporal_turned(uint32_t number)
{
	uint32_t column = 1u << (TEMPORAL_BITS - 1), turned = 0;
	for (; number > 0; number >>= 1) {
		if (number & 1)
			turned ^= column;
		column ^= column >> 1;
	}
	return turned;
}

static uint32_t temporal_reversed(uint32_t number)
{
	uint32_t reversed = 0;
	for (uint32_t b = 0; b < TEMPORAL_BITS; b++)
		reversed |= (number >> b & 1) << (TEMPORAL_BITS - 1 - b);
	return reversed;
}

void stilb_post_jitter(uint64_t frame, float pixels[2])
{
	STILB_ASSERT(pixels);
	uint32_t places = 1u << TEMPORAL_BITS, number = (uint32_t)(frame % places);
	pixels[0] = ((float)temporal_reversed(number) + 0.5f) / (float)places - 0.5f;
	pixels[1] = ((float)temporal_turned(number) + 0.5f) / (float)places - 0.5f;
}

/* ---- the row ----------------------------------------------------------------------------------------------------- */

/* An image of the size of the light that the next frame may read. */
static uint16_t temporal_image(stilb_gpu_plan *plan, const char *name, stilb_gpu_format format,
                               const stilb_gpu_extent *extent)
{
	stilb_gpu_plan_image_row row = {
		.name = name, .format = format, .width = extent->width, .height = extent->height, .keep = true};
	return stilb_gpu_plan_image(plan, &row);
}

stilb_result post_temporal_add(stilb_post *post, stilb_gpu_plan *plan, uint16_t *light)
{
	stilb_gpu_extent extent = *stilb_gpu_plan_extent(plan, *light);
	uint16_t velocity = stilb_gpu_plan_find(plan, STILB_RENDER_IMAGE_VELOCITY);
	uint16_t depth = post_velocity_depth(plan);
	uint16_t id = stilb_gpu_plan_find(plan, STILB_RENDER_IMAGE_ID);
	if (velocity == 0 || depth == 0 || id == 0 || extent.format != STILB_GPU_RGBA16_F)
		return STILB_OK;
	stilb_gpu_program program;
	stilb_result result = post_program_get(post, POST_TEMPORAL, &program);
	if (result != STILB_OK)
		return result;
	uint16_t mean = temporal_image(plan, "antialiased", extent.format, &extent);
	uint16_t models = temporal_image(plan, "antialiased models", STILB_GPU_RG32_UI, &extent);
	uint16_t places = temporal_image(plan, "antialiased places", STILB_GPU_RGBA16_F, &extent);
	temporal_push push = {.exposure = exp2f(post->exposure), .history = post->forgotten ? 0.0f : 1.0f};
	memcpy(push.to_last, post->to_last.m, sizeof push.to_last);
	for (int c = 0; c < 4; c++)
		push.ahead_row[c] = post->from_clip.m[4 * c + 3];
	stilb_gpu_pass pass = {
		.color = {{.image = mean}, {.image = models}, {.image = places}},
		.uses = {{.resource = *light},
	             {.resource = velocity},
	             {.resource = depth},
	             {.resource = id},
	             {.resource = mean, .previous = true},
	             {.resource = models, .previous = true},
	             {.resource = places, .previous = true}},
		.constant_bytes = sizeof push,
	};
	post_row_fill(&pass, "temporal antialiasing", program, 3, 7);
	memcpy(pass.constants, &push, sizeof push);
	stilb_gpu_plan_pass(plan, &pass);
	post->forgotten = false;
	*light = mean;
	return STILB_OK;
}
