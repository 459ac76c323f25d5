/* The contracts of engine/numeric (what its asserts demand of a caller), each broken on purpose: the program must abort
 * with that assert. */
#include "numeric/numeric_catalog.h"
#include "numeric/numeric_quadrature.h"
#include "numeric/numeric_sh.h"
#include "numeric/numeric_vmf.h"
#include "support/contract.h"
#include "support/test.h"

static double one(double x, const void *context)
{
	(void)x;
	(void)context;
	return 1.0;
}

static double one_everywhere(const double direction[3], const void *context)
{
	(void)direction;
	(void)context;
	return 1.0;
}

static void integrals(void **state)
{
	(void)state;
	contract_breaks("panels >= 1", stilb_numeric_integrate(one, NULL, 0.0, 1.0, 0));
	contract_breaks("isfinite (high)", stilb_numeric_integrate(one, NULL, 0.0, (double)INFINITY, 1));
	contract_breaks("high <= 1.0", stilb_numeric_integrate_sphere(one_everywhere, NULL, 0.0, 1.5, 1));
	contract_breaks("low <= high", stilb_numeric_integrate_sphere(one_everywhere, NULL, 1.0, 0.0, 1));
	contract_breaks("width > 0.0", stilb_numeric_integrate_lobe(one_everywhere, NULL, 0.0));
}

static void albedos(void **state)
{
	(void)state;
	size_t count;
	const stilb_numeric_row *row = stilb_numeric_catalog(&count), *brdf = row;
	while (brdf->kind != STILB_NUMERIC_BRDF)
		brdf++;
	shade_brdf_parameters rough = stilb_numeric_white(1.0f, 0.0f);
	stilb_numeric_shape shape = {.anisotropy = 1.0f, .view = {0.0f, 0.0f, 1.0f}};
	rough.roughness = 1.5f;
	contract_breaks("parameters->roughness <= 1.0f",
	                stilb_numeric_albedo_of_view(&brdf->model, &rough, (stilb_numeric_angles){0.0, 0.0}));
	contract_breaks("fixed.polar >= 0.0", stilb_numeric_white_albedo(brdf, 0.5f, (stilb_numeric_angles){2.0, 0.0}));
	contract_breaks("row->kind == STILB_NUMERIC_BRDF",
	                stilb_numeric_white_albedo(row, 0.5f, (stilb_numeric_angles){0.0, 0.0}));
	contract_breaks("roughness <= 1.0f", stilb_numeric_white(2.0f, 0.0f));
	contract_breaks("shape->anisotropy < 1.0f", stilb_numeric_measure_of(row, &shape));
}

static void light(void **state)
{
	(void)state;
	double direction[3];
	shade_sh_rgb sh;
	stilb_image map = {.width = 1, .height = 1, .channels = 5, .format = STILB_IMAGE_F32_LINEAR, .pixels = &sh};
	contract_breaks("u <= 1.0", (stilb_numeric_latlong_direction(1.5, 0.5, direction), 0));
	contract_breaks("map->channels <= 4", stilb_numeric_sh_project_map(&map, &sh));
	contract_breaks("panels >= 1", stilb_numeric_sh_project(one_everywhere, NULL, 0));
	contract_breaks("directions || count == 0", stilb_numeric_vmf_fit(NULL, NULL, 3, &(shade_vmf){0}));
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(integrals), cmocka_unit_test(albedos), cmocka_unit_test(light)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
