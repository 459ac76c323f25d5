/* The contracts of engine/numeric (what its asserts demand of a caller), each broken on purpose: the program must abort
 * with that assert. */
#include "numeric/numeric_catalog.h"
#include "numeric/numeric_dfg.h"
#include "numeric/numeric_prefilter.h"
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

static void gloss(void **state)
{
	(void)state;
	float values[6] = {0.0f};
	stilb_image map = {.width = 2, .height = 1, .channels = 3, .format = STILB_IMAGE_F32_LINEAR, .pixels = values};
	stilb_numeric_prefilter_source source = {.panorama = &map}, both = {.panorama = &map, .faces = &map};
	stilb_numeric_prefilter_settings good = {.face = 8, .mips = 2}, odd = {.face = 12, .mips = 2},
									 deep = {8, 5, false, 0};
	contract_breaks("settings_are_valid", stilb_numeric_prefilter_offset(&odd, 0, 0));
	contract_breaks("settings_are_valid", stilb_numeric_prefilter_offset(&deep, 0, 0));
	contract_breaks("face < 6", stilb_numeric_prefilter_offset(&good, 0, 6));
	stilb_vec4 cube[6 * (64 + 16)];
	stilb_numeric_prefilter *work;
	contract_breaks("!source->panorama != !source->faces", stilb_numeric_prefilter_create(&both, &good, cube, &work));
	assert_int_equal(stilb_numeric_prefilter_create(&source, &good, cube, &work), STILB_OK);
	contract_breaks("stage < 6", stilb_numeric_prefilter_rows(work, 6));
	contract_breaks("begin <= end", (stilb_numeric_prefilter_run(work, 0, 1, 0), 0));
	stilb_numeric_prefilter_destroy(work);
	contract_breaks("n_dot_v <= 1.0", (stilb_numeric_dfg_of(1.5, 0.5), 0));
	contract_breaks("side >= 2", (stilb_numeric_dfg_rows(values, 1, 0, 1), 0));
	stilb_numeric_point points[16];
	contract_breaks("panels >= 1", (stilb_numeric_points(0.0, 1.0, 0, points), 0));
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
	const struct CMUnitTest tests[] = {cmocka_unit_test(integrals), cmocka_unit_test(albedos), cmocka_unit_test(gloss),
	                                   cmocka_unit_test(light)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
