/*
 * The share of light that a rough metal reflects, computed by importance sampling, as a path tracer does at every hit.
 *
 *   cc -std=c17 -I STILB/engine white_furnace.c -lm
 *
 * C code uses the name stilb_vec3; vec3 and GLSL's other words exist only between glsl_begin.h and glsl_end.h.
 */
#include "shading/shade_brdf.h"
#include "shading/shade_sampling.h"

#include <stdio.h>

#define SAMPLES 65536

/* A pair of low-discrepancy numbers: fractional parts of multiples of two irrational numbers. */
static stilb_vec2 pair(int i)
{
	double x = (i + 0.5) * 0.75487766624669276, y = (i + 0.5) * 0.56984029099805327;
	return (stilb_vec2){(float)(x - floor(x)), (float)(y - floor(y))};
}

int main(void)
{
	shade_brdf_model ggx = {
		.kind = SHADE_BRDF_MICROFACET, .ndf = SHADE_NDF_GGX, .g = SHADE_G_SMITH_GGX, .f = SHADE_F_SCHLICK};
	stilb_vec3 n = {0.0f, 0.0f, 1.0f}, v = {0.6f, 0.0f, 0.8f};
	shade_frame frame = shade_frame_from_normal(n);
	for (int step = 1; step <= 4; step++) {
		shade_brdf_parameters metal = {.specular = {1.0f, 0.8f, 0.3f}, .roughness = 0.25f * (float)step};
		float alpha = shade_alpha_from_roughness(metal.roughness);
		stilb_vec3 sum = {0.0f, 0.0f, 0.0f};
		for (int i = 0; i < SAMPLES; i++) {
			shade_sample s = shade_sample_ggx_visible((shade_alphas){alpha, alpha}, v, pair(i));
			sum += shade_brdf_cos(ggx, metal, frame, s.direction, v) / s.pdf;
		}
		sum /= (float)SAMPLES;
		printf("roughness %.2f: %.3f %.3f %.3f\n", (double)metal.roughness, (double)sum[0], (double)sum[1],
		       (double)sum[2]);
	}
}
