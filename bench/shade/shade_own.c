/* The suite `shade`: the kernels that evaluate BRDFs by the functions of engine/shading, as the renderer and the path
 * tracer do. */
#include "bench/shade/shade_run.h"

#include "shading/shade_brdf.h"

#include <stddef.h>

static inline stilb_vec4 evaluate(const shade_run_point *p, shade_brdf_model model)
{
	shade_brdf_parameters parameters = {.specular = p->f0, .roughness = p->roughness, .wrap = SHADE_RUN_WRAP};
	shade_frame frame = {.n = p->n}; /* no tangent: none of the models is anisotropic */
	return shade_brdf_cos(model, parameters, frame, p->l, p->v);
}

/* A kernel (shade_run.h) whose BRDF model is a compile-time constant, as it is in a graphics pipeline. */
#define OWN_KERNEL(symbol, ...)                                                                                        \
	void shade_own_##symbol(const shade_run_inputs *inputs, shade_run_results *results)                                \
	{                                                                                                                  \
		for (int i = 0; i < SHADE_RUN_COUNT; i++)                                                                      \
			results->points[i] = evaluate(&inputs->points[i], (shade_brdf_model){__VA_ARGS__});                        \
	}

OWN_KERNEL(wrapped, .kind = SHADE_BRDF_WRAPPED)
OWN_KERNEL(phong_modified, .kind = SHADE_BRDF_PHONG_MODIFIED)
OWN_KERNEL(blinn_phong_modified, .kind = SHADE_BRDF_BLINN_PHONG_MODIFIED)
OWN_KERNEL(minimalist, .kind = SHADE_BRDF_MINIMALIST)
OWN_KERNEL(ggx, .kind = SHADE_BRDF_MICROFACET, .ndf = SHADE_NDF_GGX, .g = SHADE_G_SMITH_GGX, .f = SHADE_F_SCHLICK)
OWN_KERNEL(cook_torrance, .kind = SHADE_BRDF_MICROFACET, .ndf = SHADE_NDF_BECKMANN, .g = SHADE_G_COOK_TORRANCE,
           .f = SHADE_F_COOK_TORRANCE)
