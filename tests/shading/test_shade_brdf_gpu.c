/* Every combination of D, G and F (shade_specular.h) as the renderer makes it, by one shader with three specialisation
 * constants, against C with the same integers. */
#include "shading/cases/brdf_combination.h"
#include "support/shade_gpu.h"

static const uint32_t code[] =
#include "brdf.comp.inc"
	;

typedef struct combination {
	int32_t ndf, g, f;
} combination;

static combination combination_of(int index)
{
	return (combination){index % SHADE_NDF_COUNT, index / SHADE_NDF_COUNT % SHADE_G_COUNT,
	                     index / SHADE_NDF_COUNT / SHADE_G_COUNT};
}

static stilb_vec4 in_c(int index, stilb_vec4 a, stilb_vec4 b)
{
	combination c = combination_of(index);
	return shade_combination(c.ndf, c.g, c.f, a, b);
}

static int start(void **state)
{
	(void)state;
	shade_gpu_start(code, sizeof code);
	return 0;
}

static void specialise(combination c)
{
	shade_gpu_specialise((int32_t[3]){c.ndf, c.g, c.f}, 3);
}

/* Of the 96 combinations the worst is printed. */
static void every_combination_agrees(void **state)
{
	(void)state;
	double most = 0.0;
	for (int index = 0; index < SHADE_NDF_COUNT * SHADE_G_COUNT * SHADE_F_COUNT; index++) {
		combination c = combination_of(index);
		size_t where[2] = {0, 0};
		specialise(c);
		shade_gpu_run(index);
		double worst = shade_gpu_worst(in_c, index, 1e-5, 1e-6, where);
		most = fmax(most, worst);
		if (worst <= 1.0)
			continue;
		shade_gpu_print_worst(in_c, index, where);
		fail_msg("D %d, G %d, F %d", c.ndf, c.g, c.f);
	}
	printf("the worst of 96 combinations: %.2g of max(1e-5 relative, 1e-6)\n", most);
}

int main(void)
{
	if (!shade_gpu_present())
		return 77;
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_combination_agrees),
		cmocka_unit_test(shade_gpu_layer_said_nothing),
	};
	return cmocka_run_group_tests(tests, start, shade_gpu_end);
}
